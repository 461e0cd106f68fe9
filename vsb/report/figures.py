"""Figures of power, motion and response, any figure of a study by its name, its captions. Datasets in, Figure out."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from vsb.engine.hydro.variables import RIGID, ROTATIONS, body_of, is_rigid, motion_of
from vsb.report.answer import useful_band
from vsb.report.canvas import (
    PORT,
    StudyData,
    folded,
    grid_of_axes,
    heave_force,
    legend_above,
    note,
    panels,
    period_axis,
    shown_window,
    zero_axis,
)
from vsb.report.hydro_figures import added_mass_damping, radiation_kernel, spectra, witness
from vsb.report.shell_figures import extreme_shapes, mode_shapes, shapes_3d, snapshots, volume_area
from vsb.study.figure_names import OF_THE_RESPONSE
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray
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
    axes[0, 0].set(ylabel="absorbed power\nper amplitude² [kW/m²]", xlim=data.band)
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
    top.set_xlim(data.band)
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
    omega, (low, high) = data.response.omega, data.band
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
    if found.sizes["design"]:
        legend_above(figure, left)
    else:
        note(left, "waves move no design's port")
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
    "reactance": "Why: the take-off sees each design as one impedance R + iX. Optimal damping absorbs the share "
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

    `neglected` says what the response leaves out, `given` whether powers at a given damping are drawn, too, `body`
    whether it is any body, without a known limit, `limit` the capture width where the port reaches more than heave,
    `compared` whether gains are drawn, `heaving` whether the take-off is a damper alone between heave and the sea bed.
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


SMALL = 1e-3
"""Share of the largest of its kind below which a motion is left out, and of its own largest below which a phase is."""
MOST_HEADINGS, MOST_MODES = 4, 8
"""That are drawn."""
MARKERS = ("", "o", "^", "s")
"""Of headings."""
STEPS = (15, 30, 45, 90, 180, 360, 720, 1440)
"""Between ticks of phases [degrees]."""
TICKS = 4
LEAD = 170.0
"""Most a curve starts ahead of zero and of the first curve; less than half a turn, for opposite phases have noise."""
LEAST_SPAN = 40.0
"""Of an axis of phases [degrees]."""

Curve = tuple[ComplexArray, dict[str, Any]]
"""Values (omega,) and looks."""


def rao(data: StudyData) -> Figure:
    """Draw amplitude and phase of the rigid motions and of the take-off's port, by design and heading."""
    values = _few_headings(data.raos).transpose("wave_direction", ...)
    rigid = _moving(values, [str(dof) for dof in values.dof.values if is_rigid(str(dof))], data)
    ports = {PORT: data.port, **{f"{PORT} {name}": kind for name, kind in data.ports.items()}}
    own = rigid + [
        port
        for port in ports
        if port in values.dof and not any(np.allclose(values.sel(dof=port), values.sel(dof=dof)) for dof in rigid)
    ]
    rows: dict[str, list[Curve]] = {}
    for dof in own:
        turns = motion_of(dof) in ROTATIONS
        name = f"{dof.removeprefix('take-off ')}'s {ports[dof].motion}" if dof in ports else _in_words(dof)
        unit = superscripts(ports[dof].motion_unit) if dof in ports else "degrees" if turns else "m"
        rows[f"{name}\n[{unit}/m]"] = [
            (np.asarray(at * (180 / np.pi if turns else 1.0), dtype=complex), look)
            for design in data.designs
            for at, look in zip(
                values.sel(dof=dof, design=design).values,
                _looks(data.style(design), values.wave_direction.values),
                strict=True,
            )
        ]
    return _drawn(data, values.omega.values, rows)


def excitation(data: StudyData) -> Figure:
    """Draw amplitude and phase of the wave excitation of the rigid motions by heading, and of the first modes."""
    force = data.database.excitation_force.rename(influenced_dof="dof")
    if force.sizes["wave_direction"] > MOST_HEADINGS:  # of many those of the study's waves
        apart = force.wave_direction.values - data.raos.wave_direction.values[:, None]
        force = force.isel(wave_direction=np.abs(np.exp(1j * apart) - 1).argmin(axis=1))  # nearest, modulo full turns
    force = _few_headings(force).transpose("wave_direction", "omega", "dof")
    labels = [str(dof) for dof in force.dof.values]
    headings = force.wave_direction.values
    colours = mpl.colormaps["viridis"].resampled(len(headings) + 1)
    looks = [{"color": colours(i), "label": _towards(heading)} for i, heading in enumerate(headings)]
    if len(headings) == 1:
        looks = [{"color": "black", "label": "rigid motions"}]
    rows: dict[str, list[Curve]] = {}
    for dof in _moving(force, [dof for dof in labels if is_rigid(dof)], data):
        unit = "kN m/m" if motion_of(dof) in ROTATIONS else "kN/m"
        own = force.sel(dof=dof).values / 1e3
        rows[f"{_in_words(dof)}\n[{unit}]"] = list(zip(own, looks, strict=True))
    modes = _moving(force, [dof for dof in labels if not is_rigid(dof)], data)[:MOST_MODES]
    if modes:
        colours = mpl.colormaps["plasma"].resampled(len(modes) + 1)
        looks = [{"color": colours(i), "linestyle": "--", "label": dof} for i, dof in enumerate(modes)]
        rows["modes\n[kN/m]"] = list(zip(force[0].sel(dof=modes).values.T / 1e3, looks, strict=True))
    return _drawn(data, force.omega.values, rows)


def _few_headings(values: xr.DataArray) -> xr.DataArray:
    """Values at headings, ascending, at most so many, evenly taken."""
    values = values.sortby("wave_direction")
    size = values.sizes["wave_direction"]
    return values.isel(wave_direction=np.unique(np.linspace(0, size - 1, min(size, MOST_HEADINGS)).round().astype(int)))


def _towards(heading: float) -> str:
    """A heading [rad] in words."""
    return f"waves to {float(f'{np.degrees(heading):.4g}'):g}°"


def _looks(line: Mapping[str, Any], headings: FloatArray) -> list[dict[str, Any]]:
    """Looks of a design at each heading: its own, with markers and the heading's name where there are several."""
    if len(headings) < 2:
        return [dict(line)]
    return [
        {
            **line,
            "label": f"{line['label']}, {_towards(heading)}",
            "marker": marker,
            "markevery": 0.1,
            "markersize": 3.5,
        }
        for heading, marker in zip(headings, MARKERS, strict=False)
    ]


def _moving(values: xr.DataArray, labels: Sequence[str], data: StudyData) -> list[str]:
    """Degrees of freedom that are not negligible beside the largest of their kind in the band shown."""
    low, high = data.band
    shown = values.sel(omega=slice(low, high))
    sizes = {dof: float(np.abs(shown.sel(dof=dof).values).max(initial=0.0)) for dof in labels}
    kinds = {dof: motion_of(dof) in ROTATIONS for dof in labels}
    largest = {kind: max(sizes[dof] for dof in labels if kinds[dof] == kind) for kind in set(kinds.values())}
    return [dof for dof in labels if sizes[dof] > SMALL * largest[kinds[dof]]]


def _in_words(dof: str) -> str:
    """A rigid motion, after the name of its body if there are several."""
    return f"{body_of(dof)} {motion_of(dof).lower()}".strip()


def _drawn(data: StudyData, omega: FloatArray, rows: Mapping[str, Sequence[Curve]]) -> Figure:
    """Rows of axes: amplitude left, phase right."""
    if not rows:
        figure, axes = grid_of_axes(1.5)
        note(axes[0, 0], "nothing moves")
        return figure
    figure, axes = grid_of_axes(0.85 + 1.35 * len(rows), len(rows), 2, sharex=True)
    low, high = data.band
    shown: BoolArray = (omega >= low) & (omega <= high)
    for (label, curves), (left, right) in zip(rows.items(), axes, strict=True):
        angles = phases([values for values, _ in curves], shown)
        for (values, look), angle in zip(curves, angles, strict=True):
            left.plot(omega, np.abs(values), **look)
            if np.isfinite(angle).any():  # matplotlib places no markers on a line without points
                right.plot(omega, angle, **look)
        largest = max(float(np.abs(values[shown]).max(initial=0.0)) for values, _ in curves)
        left.set(ylabel=label, ylim=(0.0, 1.08 * largest or 1.0))
        seen = np.concatenate([angle[shown] for angle in angles])
        seen = seen[np.isfinite(seen)] if np.isfinite(seen).any() else np.zeros(1)
        span, middle = max(float(np.ptp(seen)), LEAST_SPAN), float(seen.min() + seen.max()) / 2
        right.set(ylabel="phase lag\n[degrees]", ylim=(middle - 0.56 * span, middle + 0.56 * span))
        step = next((one for one in STEPS if span / one <= TICKS), STEPS[-1])
        right.yaxis.set_major_locator(MultipleLocator(step))
    for ax in axes[0]:
        period_axis(ax, (1.5, 2, 3, 4, 6, 10))
    for ax in axes[-1]:
        ax.set(xlabel="wave frequency [rad/s]", xlim=(low, high))
    legend_above(figure, *axes[:, 0])
    return figure


def phases(curves: Sequence[ComplexArray], shown: BoolArray) -> list[FloatArray]:
    """Return the phases of curves over frequency, continuous, in the same turn at low frequencies [degrees].

    NaN outside the band shown and where a curve is less than `SMALL` of its largest there: such a phase is noise.
    """
    found: list[FloatArray] = []
    first = 0.0
    for values in curves:
        size = np.abs(values)
        kept = shown & (size > SMALL * size[shown].max(initial=0.0))
        angle = np.full(len(values), np.nan)
        if kept.any():
            turned = np.degrees(np.unwrap(np.angle(values[kept])))
            angle[kept] = turned - 360 * np.floor((turned[0] - first + LEAD) / 360)
            first = first if found else float(angle[kept][0])
        found.append(angle)
    return found
