"""Figures of power, hydrodynamics and motion; any figure by its name. Datasets in, Figure out; computes nothing."""

from collections.abc import Callable, Iterable
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.report.band import lowest, useful_band
from vsb.report.body_figures import degrees_of_freedom, port_motion
from vsb.report.canvas import (
    StudyData,
    folded,
    force_of,
    grid_of_axes,
    heave_force,
    legend_above,
    note,
    panels,
    period_axis,
    plain_numbers,
    shown_window,
    style,
    zero_axis,
)
from vsb.report.sea_figures import spectra
from vsb.report.shell_figures import extreme_shapes, mode_shapes, shapes_3d, snapshots, volume_area
from vsb.report.witness_figure import witness
from vsb.study.quantities import RIGID, ROTATIONS, is_rigid, motion_of


def absorbed_power(data: StudyData) -> Figure:
    """Draw absorbed power over the band with its limit, and any gain of flexible designs over the rigid one.

    Left with each design at its own best damper, right at the given one, if there is one.
    """
    response = data.response
    omega, limit = response.omega.values, response.power_limit / 1e3
    given = {} if data.tuned else {"all at the given damper": response.absorbed_power}
    powers = {"each at its own best damper": response.best_power} | given
    size: dict[str, Any] = {"height": 5.2, "rows": 2, "height_ratios": [3, 2]} if _compares(data) else {"height": 3.4}
    figure, axes = grid_of_axes(columns=len(powers), sharex=True, sharey="row", **size)
    for (title, power), (top, *below) in zip(powers.items(), axes.T, strict=True):
        top.plot(omega, limit, color="#999999", linewidth=3, alpha=0.6, label=data.limit)
        for design in data.designs:
            top.plot(omega, power.sel(design=design) / 1e3, **style(design, data.designs))
        for bottom in below:
            _gain(data, power, bottom)
        [top, *below][-1].set(xlabel="wave frequency [rad/s]")
        top.set_title(title, fontsize=9)
        period_axis(top)
        _mark_waves(data, (top, *below))
    largest = max(float(power.where(_shown(data)).max()) for power in powers.values()) / 1e3
    axes[0, 0].set(ylabel="absorbed power\nper amplitude² [kW/m²]", xlim=_band(data))
    axes[0, 0].set_ylim(0, 1.25 * largest or float(limit.median()) or 1.0)
    if _compares(data):
        _limit_gain(data, powers.values(), axes[1, 0])
    legend_above(figure, axes[0, 0])
    return figure


def reactance(data: StudyData) -> Figure:
    """Draw Q = |X|/R of each design's impedance over the band, and the share of the limit its best damper takes."""
    impedance = data.response.port_impedance
    quality = np.abs(impedance.imag) / impedance.real.where(impedance.real > 0)
    figure, axes = grid_of_axes(4.6, 2, 1, sharex=True)
    top, bottom = axes[:, 0]
    for design in data.designs:
        line, q = style(design, data.designs), quality.sel(design=design)
        top.plot(q.omega, q, **line)
        bottom.plot(q.omega, 2 / (1 + np.sqrt(1 + q**2)), **line)
    shown = quality.where(_shown(data))
    largest = max(0.1, float(shown.max().fillna(0.0)))
    top.set(ylabel="Q = |X|/R [-]", yscale="log", ylim=(0.05, 1.5 * largest))
    top.set_xlim(_band(data))
    bottom.set(xlabel="wave frequency [rad/s]", ylabel="best damper's share\n2/(1 + √(1 + Q²)) [-]", ylim=(0, 1.02))
    period_axis(top)
    _mark_waves(data, (top, bottom))
    legend_above(figure, top)
    return figure


FEW = 100.0
"""Ratio of the ends of a logarithmic axis up to which it has more numbers than powers of ten."""
WAVE: dict[str, Any] = {"color": "#E69F00", "linestyle": "none", "marker": "^", "markersize": 6, "clip_on": False}


def _shown(data: StudyData) -> xr.DataArray:
    """Which frequencies figures over the band show."""
    omega, (low, high) = data.response.omega, _band(data)
    shown: xr.DataArray = (omega > low) & (omega < high)
    return shown


def _mark_waves(data: StudyData, axes: Iterable[Axes]) -> None:
    """Mark the study's waves on the axis of frequencies, where the mark crosses no curve."""
    omegas = data.wave_frequencies
    for ax in axes if omegas else ():
        label = "study's wave" if len(omegas) == 1 else "study's waves"
        ax.plot(omegas, 0 * np.array(omegas), transform=ax.get_xaxis_transform(), zorder=5, label=label, **WAVE)


def _band(data: StudyData) -> tuple[float, float]:
    """Frequencies shown: from the `lowest` on to where no design absorbs 1 % of its largest power, and all waves."""
    power = data.response.absorbed_power.max(dim="design")
    absorbs = power.omega.where(power > 0.01 * power.max(), drop=True) if float(power.max()) > 0 else power.omega
    last = float(absorbs.max())
    ends = np.array([lowest(float(power.omega[0]), last), last, *data.wave_frequencies])
    return float(ends.min()), float(ends.max())


def _compares(data: StudyData) -> bool:
    """Whether there is a gain to draw: of another design over the rigid one."""
    return data.reference is not None and len(data.designs) > 1


def _gain(data: StudyData, power: xr.DataArray, ax: Axes) -> None:
    """Draw the gain of each flexible design over the rigid one [%]."""
    if not float(power.sel(design=data.reference).min()) > 0:
        return note(ax, "no absorbed power to compare with")
    gain = 100 * (power / power.sel(design=data.reference) - 1).where(useful_band(power))
    for design in data.designs:
        if design != data.reference:
            ax.plot(power.omega, gain.sel(design=design), **style(design, data.designs))
    ax.axhspan(0, 1e4, color="#009E73", alpha=0.06)
    ax.axhspan(-100, 0, color="#D55E00", alpha=0.06)
    ax.axhline(0, color="black", linewidth=0.8)


def _limit_gain(data: StudyData, powers: Iterable[xr.DataArray], ax: Axes) -> None:
    """Give axes of gains their label, and bounds that show all gains of some powers."""
    moved = [power for power in powers if float(power.sel(design=data.reference).max()) > 0]
    shown = [power.where(_shown(data) & useful_band(power)) for power in moved]
    gains = [100 * (power / power.sel(design=data.reference) - 1).values.ravel() for power in shown]
    known = np.concatenate([[0.0], *gains])  # what is shown of a power may be of no use
    low, high = float(np.nanmin(known)), float(np.nanmax(known))
    ends = float(np.clip(1.15 * low, -100, -20)), float(np.clip(1.15 * high, 20, 250))
    ax.set(ylabel=f"gain over {data.reference} [%]", ylim=ends)


def added_mass_damping(data: StudyData) -> Figure:
    """Draw the diagonal of added mass and radiation damping; dashed: added mass at infinite frequency."""
    database = data.database
    figure, axes = grid_of_axes(4.6, 2, 1, sharex=True)
    top, bottom = axes[:, 0]
    labels = database.influenced_dof.values
    colours = mpl.colormaps["viridis"].resampled(max(2, len(labels)))
    for i, label in enumerate(labels):
        own = {"influenced_dof": label, "radiating_dof": label}
        if not database.added_mass.sel(own).any():  # pitch about a sphere's centre moves no water
            continue
        line = {"color": "black" if i == 0 else colours(i - 1), "label": label}
        if i == 0:  # above a mode that moves the same water, which is seen between its dots
            line |= {"linestyle": (0, (1, 1.5)), "linewidth": 2.2, "zorder": 3}
        top.plot(database.omega, database.added_mass.sel(own), **line)
        top.axhline(float(database.added_mass_inf.sel(own)), color=line["color"], linewidth=0.7, linestyle="--")
        bottom.plot(database.omega, database.radiation_damping.sel(own).clip(min=1e-3), **line)
    turns = any(_turns(str(label)) for label in labels)  # a rotation beside displacements
    top.set(ylabel="added mass\n[kg, of rotations kg m²]" if turns else "added mass [kg]", yscale="log")
    if np.divide(*top.get_ylim()[::-1]) < FEW:
        plain_numbers(top.yaxis)
    largest = float(database.radiation_damping.max())
    unit = "\n[kg/s, of rotations kg m²/s]" if turns else " [kg/s]"
    bottom.set(ylabel=f"radiation damping{unit}", yscale="log", ylim=(1e-5 * largest, 2 * largest))
    bottom.set(xlabel="frequency [rad/s]", xlim=(0, float(database.omega[-1])))
    legend_above(figure, top)
    return figure


def radiation_kernel(data: StudyData) -> Figure:
    """Draw the retardation kernel from the damping and from the state space, of three motions: displacements first."""
    kernel = data.radiation
    labels = sorted(map(str, kernel.influenced_dof.values), key=lambda label: (_turns(label), not is_rigid(label)))
    labels = [label for label in labels if not _turns(label)][:3] or labels[:3]
    figure, axes = grid_of_axes(1.3 + 1.3 * len(labels), len(labels), 1, sharex=True)
    for ax, label in zip(axes[:, 0], labels, strict=True):
        own = {"influenced_dof": label, "radiating_dof": label}
        ax.plot(kernel.time, kernel.kernel.sel(own) / 1e3, color="black", label="convolution kernel")
        ax.plot(
            kernel.time, kernel.kernel_state_space.sel(own) / 1e3, color="#D55E00", linestyle="--", label="state space"
        )
        ax.set_ylabel(f"{label}\n[10³ kg{' m²' * _turns(label)}/s²]")
    axes[-1, 0].set(xlabel="time [s]", xlim=(0, min(12.0, float(kernel.time[-1]))))
    legend_above(figure, axes[0, 0])
    return figure


def _turns(label: str) -> bool:
    """Whether a degree of freedom is a rotation, of whichever body."""
    return motion_of(label) in ROTATIONS


def heave_excitation(data: StudyData, wave: str) -> Figure:
    """Draw heave and excitation force, the paper's Fig. 5."""
    heave = ("heave [m]", lambda run: run.position.isel(dof=0))
    return panels(data, wave, [heave, ("excitation force [kN]", lambda run: heave_force(run, "excitation"))])


def directions(data: StudyData, wave: str) -> Figure:
    """Draw surge, heave and pitch; of a buoy that is free all six rigid motions, but for those that do not move."""
    positions = [run.position for (_, sea), run in data.runs.items() if sea == wave]
    there = [name for name in RIGID if name in positions[0].dof]
    moved = [name for name in there if any(position.sel(dof=name).any() for position in positions)]
    return panels(data, wave, [_direction(name) for name in moved or there])


def _direction(name: str) -> tuple[str, Callable[[xr.Dataset], xr.DataArray]]:
    """A rigid motion and what to draw of a run."""
    if name not in ROTATIONS:
        return f"{name.lower()} [m]", lambda run: run.position.sel(dof=name)

    def angle(run: xr.Dataset) -> xr.DataArray:
        turned: xr.DataArray = np.rad2deg(run.position.sel(dof=name))
        return turned

    return f"{name.lower()} [degrees]", angle


def velocity_pto(data: StudyData, wave: str) -> Figure:
    """Draw heave velocity and power take-off force, the paper's Fig. 6."""
    velocity = ("heave velocity [m/s]", lambda run: run.velocity.isel(dof=0))
    return panels(data, wave, [velocity, ("power take-off force [kN]", lambda run: heave_force(run, "pto"))])


def power_energy(data: StudyData, wave: str) -> Figure:
    """Draw absorbed power in the window and absorbed energy over the whole run, the paper's Fig. 10."""
    figure, axes = grid_of_axes(4.6, 2, 1)
    top, bottom = axes[:, 0]
    for design in data.designs:
        run, line = data.runs[design, wave], style(design, data.designs)
        inside = run.sel(time=slice(*shown_window(data, wave)))
        top.plot(inside.time, -(force_of(inside, "pto") * inside.velocity).sum("dof"), **line)
        bottom.plot(run.time, run.energy.sel(term="pto") / 1e3, **line)
    top.set(ylabel="absorbed power [kW]", xlabel="time [s]", xlim=shown_window(data, wave))
    bottom.set(ylabel="absorbed energy [kJ]", xlabel="time [s]", xlim=(0, float(run.time[-1])))
    for ax in (top, bottom):
        zero_axis(ax)
    legend_above(figure, top)
    return figure


def energy_audit(data: StudyData, wave: str) -> Figure:
    """Draw where the energy of each run went: wave work = take-off + radiated + structural + stored."""
    figure, axes = grid_of_axes(0.9 + 0.45 * len(data.designs))
    ax = axes[0, 0]
    colours = {"pto": "#0072B2", "radiated": "#56B4E9", "structural": "#E69F00", "drag": "#009E73", "stored": "#999999"}
    names = {"pto": "power take-off", "structural": "structural damping"}
    rows = np.arange(len(data.designs))
    final = [data.runs[design, wave].energy.isel(time=-1) / 1e3 for design in data.designs]
    left = {True: np.zeros(len(rows)), False: np.zeros(len(rows))}
    there = set.intersection(*(set(one.term.values) for one in final))
    for term, colour in ((term, colour) for term, colour in colours.items() if term in there):
        values = np.array([float(one.sel(term=term)) for one in final])
        gone = values >= 0
        label = names.get(term, term)
        ax.barh(rows, values, left=np.where(gone, left[True], left[False]), color=colour, label=label)
        for sign in left:
            left[sign] += np.where(gone == sign, values, 0.0)
    ax.plot([float(one.sel(term="wave")) for one in final], rows, "k|", markersize=16, label="work of the wave")
    ax.set_yticks(range(len(data.designs)), [folded(design, 24) for design in data.designs])
    ax.invert_yaxis()
    ax.use_sticky_edges = False  # room beside the longest bar
    ax.margins(x=0.06)
    ax.axvline(0, color="black", linewidth=0.8)
    given_up = "; stored below 0: given up by the motion it started with" if left[False].min() < 0 else ""
    ax.set(xlabel=f"energy over the run [kJ]{given_up}")
    legend_above(figure, ax)
    return figure


def draw(name: str, data: StudyData) -> Figure:
    """Return the figure of a name from `vsb.study.plan.figure_names`."""
    kind, _, wave = name.partition("-")
    per_study = {
        f.__name__: f
        for f in (absorbed_power, reactance, spectra, mode_shapes, added_mass_damping, radiation_kernel, witness)
    }
    per_wave = {
        f.__name__: f
        for f in (
            heave_excitation, directions, velocity_pto, power_energy, energy_audit, snapshots,
            extreme_shapes, shapes_3d, volume_area, port_motion, degrees_of_freedom,
        )
    }  # fmt: skip
    return per_wave[kind](data, wave) if kind in per_wave else per_study[kind](data)
