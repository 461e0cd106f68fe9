"""Figures of power and motion, any figure of a study by its name, and its captions. Datasets in, Figure out."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.engine.hydro.labels import RIGID, ROTATIONS
from vsb.report.band import useful_band
from vsb.report.canvas import (
    StudyData,
    folded,
    grid_of_axes,
    heave_force,
    legend_above,
    note,
    panels,
    period_axis,
    shown_band,
    shown_window,
    zero_axis,
)
from vsb.report.hydro_figures import added_mass_damping, radiation_kernel, spectra, witness
from vsb.report.response_figures import excitation, rao
from vsb.report.shell_figures import extreme_shapes, mode_shapes, shapes_3d, snapshots, volume_area
from vsb.study.figure_names import OF_THE_RESPONSE
from vsb.tools.words import prefixed, superscripts


def absorbed_power(data: StudyData) -> Figure:
    """Draw absorbed power over the band with its limit, and any gain of flexible designs over the rigid one.

    Left at the optimal damping of each design, right at the given damping, if there is one.
    """
    response = data.response
    omega, limit = response.omega.values, response.power_limit / 1e3
    given = {} if data.tuned else {"all at the given damping": response.absorbed_power}
    powers = {"each at its optimal damping": response.best_power} | given
    size: dict[str, Any] = {"height": 5.2, "rows": 2, "height_ratios": [3, 2]} if _compares(data) else {"height": 3.4}
    figure, axes = grid_of_axes(columns=len(powers), sharex=True, sharey="row", **size)
    for (title, power), (top, *below) in zip(powers.items(), axes.T, strict=True):
        if data.limit:
            top.plot(omega, limit, color="#999999", linewidth=3, alpha=0.6, label=data.limit)
        for design in data.designs:
            top.plot(omega, power.sel(design=design) / 1e3, **data.style(design))
        for bottom in below:
            _gain(data, power, bottom)
        [top, *below][-1].set(xlabel="wave frequency [rad/s]")
        top.set_title(title, fontsize=9)
        period_axis(top)
        _mark_waves(data, (top, *below))
    largest = max(float(power.where(_shown(data)).max()) for power in powers.values()) / 1e3
    axes[0, 0].set(ylabel="absorbed power\nper amplitude² [kW/m²]", xlim=shown_band(data))
    axes[0, 0].set_ylim(0, 1.25 * largest or float(limit.median()) or 1.0)
    if _compares(data):
        _limit_gain(data, powers.values(), axes[1, 0])
    legend_above(figure, axes[0, 0])
    return figure


def reactance(data: StudyData) -> Figure:
    """Draw Q = |X|/R of each design's impedance over the band, and the share of the limit at optimal damping."""
    impedance = data.response.port_impedance
    quality = np.abs(impedance.imag) / impedance.real.where(impedance.real > 0)
    figure, axes = grid_of_axes(4.6, 2, 1, sharex=True)
    top, bottom = axes[:, 0]
    for design in data.designs:
        line, q = data.style(design), quality.sel(design=design)
        top.plot(q.omega, q, **line)
        bottom.plot(q.omega, 2 / (1 + np.sqrt(1 + q**2)), **line)
    shown = quality.where(_shown(data))
    largest = max(0.1, float(shown.max().fillna(0.0)))
    top.set(ylabel="Q = |X|/R [-]", yscale="log", ylim=(0.05, 1.5 * largest))
    top.set_xlim(shown_band(data))
    bottom.set(
        xlabel="wave frequency [rad/s]", ylabel="share at optimal damping\n2/(1 + √(1 + Q²)) [-]", ylim=(0, 1.02)
    )
    period_axis(top)
    _mark_waves(data, (top, bottom))
    legend_above(figure, top)
    return figure


WAVE: dict[str, Any] = {"color": "#E69F00", "linestyle": "none", "marker": "^", "markersize": 6, "clip_on": False}


def _shown(data: StudyData) -> xr.DataArray:
    """Which frequencies figures over the band show."""
    omega, (low, high) = data.response.omega, shown_band(data)
    shown: xr.DataArray = (omega > low) & (omega < high)
    return shown


def _mark_waves(data: StudyData, axes: Iterable[Axes]) -> None:
    """Mark the study's waves on the axis of frequencies, where the mark crosses no curve."""
    omegas = data.wave_frequencies
    for ax in axes if omegas else ():
        label = "study's wave" if len(omegas) == 1 else "study's waves"
        ax.plot(omegas, 0 * np.array(omegas), transform=ax.get_xaxis_transform(), zorder=5, label=label, **WAVE)


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
            ax.plot(power.omega, gain.sel(design=design), **data.style(design))
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
    largest = max(float(abs(data.runs[design, wave].energy.sel(term="pto")).max()) for design in data.designs)
    factor, prefix = prefixed(largest, "J")
    for design in data.designs:
        run, line = data.runs[design, wave], data.style(design)
        inside = run.sel(time=slice(*shown_window(data, wave)))
        top.plot(inside.time, inside.power_absorbed / 1e3, **line)
        bottom.plot(run.time, factor * run.energy.sel(term="pto"), **line)
    top.set(ylabel="absorbed power [kW]", xlabel="time [s]", xlim=shown_window(data, wave))
    bottom.set(ylabel=f"absorbed energy [{prefix}J]", xlabel="time [s]", xlim=(0, float(run.time[-1])))
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
    final = [data.runs[design, wave].energy.isel(time=-1) for design in data.designs]
    factor, prefix = prefixed(max(float(abs(one).max()) for one in final), "J")
    final = [factor * one for one in final]
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
    ax.set(xlabel=f"energy over the run [{prefix}J]{given_up}")
    legend_above(figure, ax)
    return figure


def port_motion(data: StudyData, wave: str) -> Figure:
    """Draw displacement and velocity of the take-off's port."""
    kind = data.port
    moved = (f"port's {kind.motion} [{superscripts(kind.motion_unit)}]", lambda run: run.stroke)
    moves = (f"port's {kind.rate} [{superscripts(kind.rate_unit)}]", lambda run: run.stroke_rate)
    return panels(data, wave, [moved, moves])


def degrees_of_freedom(data: StudyData, wave: str) -> Figure:
    """Draw half of the range of every degree of freedom in the window."""
    labels = list(dict.fromkeys(str(d) for design in data.designs for d in data.runs[design, wave].dof.values))
    figure, axes = grid_of_axes(1.6 + 0.28 * len(labels))
    ax, height = axes[0, 0], 0.8 / len(data.designs)
    for i, design in enumerate(data.designs):
        run = data.runs[design, wave].sel(time=slice(*data.window)).position
        half = (run.max("time") - run.min("time")) / 2
        rows = np.array([labels.index(str(label)) for label in half.dof.values])
        line = data.style(design)
        ax.barh(
            rows + (i - (len(data.designs) - 1) / 2) * height,
            half.values,
            height,
            color=line["color"],
            label=line["label"],
        )
    ax.set_yticks(range(len(labels)), [folded(label, 24) for label in labels])
    ax.invert_yaxis()
    ax.set(xlabel="half of the range in the window [m or rad]")
    if any(bar.get_width() > 0 for bar in ax.patches):
        ax.set(xscale="log")
    legend_above(figure, ax)
    return figure


def forecast(data: StudyData, wave: str) -> Figure:
    """Draw power under causal control over seconds of forecast, and over noise, of every design in a sea."""
    found = data.knowledge[wave]
    figure, axes = grid_of_axes(3.2, columns=2, sharey="row")
    left, right = axes[0]
    for design in map(str, found.design.values):
        line, own = data.style(design), found.sel(design=design)
        left.plot(own.forecast, own.over_forecast, **line)
        right.plot(10 * np.log10(own.noise), own.over_noise, **line)
        left.axhline(float(own.known_future), color=line["color"], linestyle=":", linewidth=0.8)
        left.axhline(float(own.damper), color=line["color"], linestyle="--", linewidth=0.8, alpha=0.6)
    left.set(xlabel="forecast [s]", ylabel="mean power [W]")
    right.set(xlabel="noise [dB of the waves' force]")
    legend_above(figure, left)
    return figure


def draw(name: str, data: StudyData) -> Figure:
    """Return the figure of a name from `vsb.study.figure_names`."""
    kind, _, wave = name.partition("-")
    per_study = {
        f.__name__: f
        for f in (
            absorbed_power, reactance, rao, spectra, mode_shapes, added_mass_damping, excitation, radiation_kernel,
            witness,
        )
    }  # fmt: skip
    per_wave = {
        f.__name__: f
        for f in (
            heave_excitation, directions, velocity_pto, power_energy, energy_audit, snapshots,
            extreme_shapes, shapes_3d, volume_area, port_motion, degrees_of_freedom, forecast,
        )
    }  # fmt: skip
    return per_wave[kind](data, wave) if kind in per_wave else per_study[kind](data)


CAPTIONS = {
    "absorbed_power": "Mean absorbed power per squared wave amplitude over the whole band{gain}, {dampings}."
    "{limit}{useful}",
    "reactance": "The reason: at its port a design is one impedance R + iX. Optimal damping absorbs the share "
    "2/(1 + √(1 + Q²)), Q = |X|/R, of the most any take-off could{same}.",
    "rao": "Response amplitude operators of the rigid motions and of the take-off's port, {taken}: amplitude per wave "
    "amplitude, and phase lag behind the wave crest at the origin.{long_waves} Motions of less than a thousandth of "
    "the largest are left out, as is the port where it moves as one of the motions.",
    "excitation": "Wave excitation per wave amplitude: amplitude, and phase lag behind the wave crest at the origin."
    "{modal}",
    "spectra": "Spectra of the irregular seas. Simulations use components up to the highest frequency of the study.",
    "mode_shapes": "Shapes of the shell modes and their natural frequencies in vacuum. Displacements along the "
    "meridian are included.",
    "added_mass_damping": "Added mass (dashed: at infinite frequency) and radiation damping of {moving}.",
    "radiation_kernel": "Retardation kernel from radiation damping, and of the passive state-space model used in the "
    "time domain.",
    "witness": "Cross-check of two independent solvers, capytaine's panels and the spectral integral equation. Top: "
    "their difference on the mean shell and on shells deformed by each mode, relative to the largest coefficient at "
    "each frequency, and their own error estimates. Middle: effect of the deformation on the heave coefficients (dots: "
    "panels, open symbols: spectral). Bottom, in deep water: difference of the derivatives by the modes.",
    "forecast": "What knowledge of the waves is worth to a controller of given rms force: mean power over seconds of "
    "forecast (dotted: the future known; dashed: the best damper of that force), and over the noise of what it "
    "measures.",
    "port_motion": "Displacement and velocity of the take-off's port.",
    "degrees_of_freedom": "Range of motion of every degree of freedom, with the take-off.",
    "heave_excitation": "Heave and the heave component of the excitation force.",
    "directions": "Surge, heave and pitch (positive: the top moves with the waves), or all six rigid motions. "
    "Without a mooring nothing restores surge, sway and yaw.",
    "velocity_pto": "Heave velocity and power take-off force.",
    "power_energy": "Instantaneous absorbed power, and absorbed energy since the start.",
    "extreme_shapes": "Shells of all designs at the smallest distance between the poles, displacement magnified.",
    "shapes_3d": "The first flexible design at the start and at the smallest and largest distance between the poles "
    "in the window, displacement magnified.",
    "volume_area": "Volume enclosed by the shell and its surface area.",
    "energy_audit": "Energy balance of the whole run: the work of the waves or the assumed pressure (black mark) "
    "equals absorbed, radiated, dissipated and stored energy. Stored energy is negative if the run ends with less "
    "kinetic and potential energy than it started with.",
    "snapshots": "The buoys over the last period (dotted: undeformed). Shell displacement is magnified as stated above "
    "the figure, heave and wave are to scale.",
}
HEAVE = "heave and modes. Heave (dotted) coincides with the mode of degree 1 where both move the surface alike"
OPTIMAL = "each design at its optimal damping at every frequency"
HEAVING = "a capture width of a wavelength over 2π, the limit of an axisymmetric heaving body"
LONG_WAVES = (
    " In long waves heave tends to 1/√2 of the wave's amplitude, not to 1: the optimal damper, |X|, resists as "
    "strongly as buoyancy does."
)
REVOLUTION = "a body of revolution at this port"
SAME = (
    ". That limit is the same for all shells apart from structural loss: at optimal damping, flexibility pays if and "
    "only if it lowers Q"
)


def captions(
    neglected: str = "", *, given: bool, body: bool, limit: str = "", compared: bool = True, heaving: bool = False
) -> dict[str, str]:
    """Return the captions of a study's figures by kind.

    Parameters
    ----------
    neglected : str
        What the frequency response leaves out, in words.
    given : bool
        Whether a damping is given, at which powers are drawn next to those at optimal damping.
    body : bool
        Whether it is a body of any shape rather than a buoy of revolution, whose limit is known.
    limit : str
        The capture width of that limit where the port reaches more than heave.
    compared : bool
        Whether there are a rigid design and another one, whose gain is drawn.
    heaving : bool
        Whether the take-off is a damper alone, between heave and the sea bed.
    """
    bound = f"a capture width of {limit}, the limit of {REVOLUTION}" if limit else HEAVING
    words = {
        "dampings": f"left {OPTIMAL}, right all at the given damping" if given else OPTIMAL,
        "limit": "" if body else f" Grey: {bound}.",
        "gain": ", and the gain over the rigid design" if compared else "",
        "useful": " Gains are drawn where at least 5 % of the largest power is absorbed." if compared else "",
        "same": "" if body else SAME,
        "long_waves": LONG_WAVES if heaving and not given else "",
        "taken": "with the given damping" if given else OPTIMAL,
        "modal": "" if body else " Modes: generalised forces on the first of them.",
        "moving": "all degrees of freedom; dotted: heave" if body else HEAVE,
    }
    found = {name: text.format(**words) for name, text in CAPTIONS.items()}
    return found | ({name: f"{neglected.capitalize()}: {found[name]}" for name in OF_THE_RESPONSE} if neglected else {})
