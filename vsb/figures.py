"""Figures for publication: datasets in, Figure out; computes nothing but what it draws.

The same design always has the same colour and line style.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.units import FloatArray

WIDTH = 6.3
"""Width of a figure [inch]: a page of text."""
# Okabe & Ito's colour-blind-safe palette; the paper's designs first, others in the order of the study.
STYLES = {
    "FSB": ("#000000", "-"),
    "VSWEC": ("#D55E00", "-"),
    "VSWEC0": ("#0072B2", "--"),
    "VSWEC90": ("#009E73", "-."),
}
SPARE = (("#CC79A7", "-"), ("#E69F00", "--"), ("#56B4E9", "-."), ("#999999", ":"))


@dataclass(frozen=True)
class StudyData:
    """What the figures of a study are drawn from."""

    designs: tuple[str, ...]
    reference: str | None  # the rigid design gains are measured against
    wave_frequencies: tuple[float, ...]  # of the study's seas [rad/s]
    periods: dict[str, float]  # wave label -> period [s]
    window: tuple[float, float]  # [s]
    modes: xr.Dataset
    database: xr.Dataset
    radiation: xr.Dataset
    response: xr.Dataset
    runs: dict[tuple[str, str], xr.Dataset]  # (design, wave label) -> trajectory


def style(design: str, designs: Sequence[str]) -> dict[str, Any]:
    """Return colour, line style and label of a design: fixed for the paper's, by order in the study for others."""
    others = [name for name in designs if name not in STYLES]
    colour, line = STYLES[design] if design in STYLES else SPARE[others.index(design) % len(SPARE)]
    return {"color": colour, "linestyle": line, "label": design}


def _figure(height: float, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, np.ndarray]:
    """A figure of page width with a grid of axes, always a 2-D array of them."""
    mpl.rcParams.update({
        "font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.3, "svg.hashsalt": "vsb",
        "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "font.family": "DejaVu Sans",
    })  # fmt: skip
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def _legend_above(figure: Figure, axes: Axes) -> None:
    """One legend for all axes, above them, where it covers no data."""
    handles, labels = axes.get_legend_handles_labels()
    columns = min(len(labels), max(1, int(80 / (6 + max(map(len, labels))))))
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, fontsize=8)


def mode_shapes(data: StudyData) -> Figure:
    """Draw the undeformed circle and each deformed meridian, the paper's Fig. 4."""
    modes, columns = data.modes, 4
    count = modes.sizes["mode"]
    rows = max(1, math.ceil(count / columns))
    figure, axes = _figure(0.4 + 1.75 * rows, rows, columns)
    phi = modes.colatitude.values
    for ax in axes.flat:
        ax.set_axis_off()
        ax.set_aspect("equal")
    for ax, mode in zip(axes.flat, modes.mode.values, strict=False):
        shape = modes.sel(mode=mode)
        amplitude = 0.25 / max(1.0, float(shape.degree) / 2) ** 0.7  # smaller where the shape is steeper
        v, u = amplitude * shape.radial.values, amplitude * shape.meridional.values
        x, z = (1 + v) * np.sin(phi) + u * np.cos(phi), (1 + v) * np.cos(phi) - u * np.sin(phi)
        ax.plot(np.sin(2 * phi), np.cos(2 * phi), color="black", linewidth=0.8)
        ax.plot([*x, *-x[::-1]], [*z, *z[::-1]], color="#D55E00")
        ax.set_title(f"{mode}\n{float(shape.dry_frequency):.2f} rad/s dry", fontsize=8)
    title = "Shell modes (black: undeformed)" if count else "A rigid study has no shell modes"
    figure.suptitle(title, fontsize=9)
    return figure


def absorbed_power(data: StudyData) -> Figure:
    """Draw absorbed power over the band with its limit, and the gain of each flexible design over the rigid one."""
    response = data.response
    omega = response.omega.values
    figure, axes = _figure(5.2, 2, 1, sharex=True, height_ratios=[3, 2])
    top, bottom = axes[:, 0]
    top.plot(omega, response.power_limit / 1e3, color="#999999", linewidth=3, alpha=0.6, label="limit λ/2π")
    for design in data.designs:
        top.plot(omega, response.absorbed_power.sel(design=design) / 1e3, **style(design, data.designs))
    largest = float(response.absorbed_power.max()) / 1e3
    top.set(ylabel="absorbed power\nper amplitude² [kW/m²]", ylim=(0, 1.25 * largest or 1.0))
    _gain(data, bottom)
    bottom.set(xlabel="wave frequency [rad/s]", xlim=(0.3, _band_end(data)))
    for omega_wave in data.wave_frequencies:
        for ax in (top, bottom):
            ax.axvline(omega_wave, color="#E69F00", linewidth=0.9, linestyle=":", zorder=0)
    if data.wave_frequencies:
        top.text(data.wave_frequencies[0], 1.2 * largest, " study's wave", color="#B07800", fontsize=8, va="top")
    period = top.secondary_xaxis("top", functions=(_period, _period))
    period.set_xlabel("wave period [s]")
    period.set_xticks([t for t in (1.5, 2, 2.5, 3, 4, 6, 10, 20) if 2 * math.pi / t > 0.3])
    _legend_above(figure, top)
    return figure


def _period(omega: FloatArray) -> FloatArray:
    """2 pi over the argument: period of a frequency, frequency of a period."""
    return 2 * np.pi / np.maximum(omega, 1e-6)


def _band_end(data: StudyData) -> float:
    """Frequency above which no design absorbs 1 % of its largest power."""
    power = data.response.absorbed_power.max(dim="design")
    if not float(power.max()) > 0:
        return float(power.omega[-1])
    return float(power.omega[power > 0.01 * power.max()].max())


def _gain(data: StudyData, ax: Axes) -> None:
    """Draw the gain of each flexible design over the rigid one [%]."""
    power = data.response.absorbed_power
    if data.reference is None or not float(power.sel(design=data.reference).min()) > 0:
        why = "no rigid design" if data.reference is None else "no absorbed power"
        ax.text(0.5, 0.5, f"{why} to compare with", transform=ax.transAxes, ha="center")
        return
    base = power.sel(design=data.reference)
    for design in data.designs:
        if design != data.reference:
            ax.plot(power.omega, 100 * (power.sel(design=design) / base - 1), **style(design, data.designs))
    ax.axhspan(0, 1e4, color="#009E73", alpha=0.06)
    ax.axhspan(-100, 0, color="#D55E00", alpha=0.06)
    ax.axhline(0, color="black", linewidth=0.8)
    inside = (power.omega > 0.3) & (power.omega < _band_end(data))
    gain = 100 * (power / base - 1).where(inside, drop=True).values
    ax.set(ylabel=f"gain over {data.reference} [%]", ylim=(-100, float(np.clip(1.15 * gain.max(), 20, 250))))


def added_mass_damping(data: StudyData) -> Figure:
    """Draw the diagonal of added mass and radiation damping; dashed: added mass at infinite frequency."""
    database = data.database
    figure, axes = _figure(4.6, 2, 1, sharex=True)
    top, bottom = axes[:, 0]
    labels = database.influenced_dof.values
    colours = mpl.colormaps["viridis"].resampled(max(2, len(labels)))
    for i, label in enumerate(labels):
        own = {"influenced_dof": label, "radiating_dof": label}
        line = {"color": "black" if i == 0 else colours(i - 1), "label": label}
        top.plot(database.omega, database.added_mass.sel(own), **line)
        top.axhline(float(database.added_mass_inf.sel(own)), color=line["color"], linewidth=0.7, linestyle="--")
        bottom.plot(database.omega, database.radiation_damping.sel(own).clip(min=1e-3), **line)
    top.set(ylabel="added mass [kg]", yscale="log")
    largest = float(database.radiation_damping.max())
    bottom.set(ylabel="radiation damping [kg/s]", yscale="log", ylim=(1e-5 * largest, 2 * largest))
    bottom.set(xlabel="frequency [rad/s]", xlim=(0, float(database.omega[-1])))
    _legend_above(figure, top)
    return figure


def radiation_kernel(data: StudyData) -> Figure:
    """Draw the retardation kernel from the damping and from the state space, heave and two modes."""
    kernel = data.radiation
    labels = kernel.influenced_dof.values[:3]
    figure, axes = _figure(1.3 + 1.3 * len(labels), len(labels), 1, sharex=True)
    for ax, label in zip(axes[:, 0], labels, strict=True):
        own = {"influenced_dof": label, "radiating_dof": label}
        ax.plot(kernel.time, kernel.kernel.sel(own) / 1e3, color="black", label="convolution kernel")
        ax.plot(
            kernel.time, kernel.kernel_state_space.sel(own) / 1e3, color="#D55E00", linestyle="--", label="state space"
        )
        ax.set_ylabel(f"{label}\n[10³ kg/s²]")
    axes[-1, 0].set(xlabel="time [s]", xlim=(0, min(12.0, float(kernel.time[-1]))))
    _legend_above(figure, axes[0, 0])
    return figure


def _panels(
    data: StudyData, wave: str, quantities: Sequence[tuple[str, Callable[[xr.Dataset], xr.DataArray]]]
) -> Figure:
    """Draw time series of all designs in the window, one panel per quantity."""
    figure, axes = _figure(1.0 + 1.9 * len(quantities), len(quantities), 1, sharex=True)
    for ax, (label, quantity) in zip(axes[:, 0], quantities, strict=True):
        for design in data.designs:
            run = data.runs[design, wave].sel(time=slice(*data.window))
            ax.plot(run.time, quantity(run), **style(design, data.designs))
        ax.set_ylabel(label)
    axes[-1, 0].set(xlabel="time [s]", xlim=data.window)
    _legend_above(figure, axes[0, 0])
    return figure


def _heave_force(run: xr.Dataset, name: str) -> xr.DataArray:
    """Heave component of a force [kN]; zero where the scene has no such force."""
    return run[name].isel(dof=0) / 1e3 if name in run else 0.0 * run.elevation


def heave_excitation(data: StudyData, wave: str) -> Figure:
    """Draw heave and excitation force, the paper's Fig. 5."""
    heave = ("heave [m]", lambda run: run.position.isel(dof=0))
    return _panels(data, wave, [heave, ("excitation force [kN]", lambda run: _heave_force(run, "excitation"))])


def velocity_pto(data: StudyData, wave: str) -> Figure:
    """Draw heave velocity and power take-off force, the paper's Fig. 6."""
    velocity = ("heave velocity [m/s]", lambda run: run.velocity.isel(dof=0))
    return _panels(data, wave, [velocity, ("power take-off force [kN]", lambda run: _heave_force(run, "pto"))])


def power_energy(data: StudyData, wave: str) -> Figure:
    """Draw absorbed power in the window and absorbed energy over the whole run, the paper's Fig. 10."""
    figure, axes = _figure(4.6, 2, 1)
    top, bottom = axes[:, 0]
    for design in data.designs:
        run, line = data.runs[design, wave], style(design, data.designs)
        inside = run.sel(time=slice(*data.window))
        top.plot(inside.time, -_heave_force(inside, "pto") * inside.velocity.isel(dof=0), **line)
        bottom.plot(run.time, run.energy.sel(term="pto") / 1e3, **line)
    top.set(ylabel="absorbed power [kW]", xlabel="time [s]", xlim=data.window)
    bottom.set(ylabel="absorbed energy [kJ]", xlabel="time [s]", xlim=(0, float(run.time[-1])))
    _legend_above(figure, top)
    return figure


def energy_audit(data: StudyData, wave: str) -> Figure:
    """Draw where the energy of each run went: wave work = take-off + radiated + structural + stored."""
    figure, axes = _figure(0.9 + 0.45 * len(data.designs))
    ax = axes[0, 0]
    colours = {"pto": "#0072B2", "radiated": "#56B4E9", "structural": "#E69F00", "stored": "#999999"}
    names = {"pto": "power take-off", "radiated": "radiated", "structural": "structural damping", "stored": "stored"}
    for row, design in enumerate(data.designs):
        final = data.runs[design, wave].energy.isel(time=-1) / 1e3
        left = {True: 0.0, False: 0.0}
        for term, colour in colours.items():
            value = float(final.sel(term=term))
            ax.barh(row, value, left=left[value >= 0], color=colour, label=names[term] if row == 0 else None)
            left[value >= 0] += value
        ax.plot(float(final.sel(term="wave")), row, "k|", markersize=16, label="work of the wave" if row == 0 else None)
    ax.set_yticks(range(len(data.designs)), data.designs)
    ax.invert_yaxis()
    ax.set(xlabel="energy over the run [kJ]")
    _legend_above(figure, ax)
    return figure


def snapshots(data: StudyData, wave: str) -> Figure:
    """Draw the deformed buoys in the wave at five instants of the last period, deformation magnified."""
    columns = 5
    figure, axes = _figure(0.7 + 1.32 * len(data.designs), len(data.designs), columns, sharex=True, sharey=True)
    factor = _magnification(data, wave)
    end = data.window[1]
    instants = end - data.periods[wave] * np.linspace(1, 0, columns, endpoint=False)
    for row, design in enumerate(data.designs):
        for ax, instant in zip(axes[row], instants, strict=True):
            _snapshot(data, ax, data.runs[design, wave].sel(time=instant, method="nearest"), design, factor)
            if row == 0:
                ax.set_title(f"t = {instant:.2f} s", fontsize=8)
        axes[row, 0].set_ylabel(design)
    figure.suptitle(f"Shell displacement magnified {factor:g} times; heave and wave to scale", fontsize=9)
    return figure


def _magnification(data: StudyData, wave: str) -> float:
    """Round factor that makes the largest shell displacement about 0.2 radii."""
    largest = max(
        (float(abs(run.position.sel(time=slice(*data.window))[:, 1:]).max()) for (_, w), run in data.runs.items()
         if w == wave and run.sizes["dof"] > 1),
        default=0.0,
    )  # fmt: skip
    if largest == 0.0:
        return 1.0
    raw = 0.2 * float(data.modes.attrs["radius"]) / largest
    decade = 10.0 ** math.floor(math.log10(raw))
    return max(1.0, max(m * decade for m in (1, 2, 5) if m * decade <= raw))


def _snapshot(data: StudyData, ax: Axes, run: xr.Dataset, design: str, factor: float) -> None:
    """Draw one buoy at one instant: x = (r+v) sin + u cos, z = centre + heave + (r+v) cos - u sin."""
    modes = data.modes
    r, phi = float(modes.attrs["radius"]), modes.colatitude.values
    q = factor * run.position.values[1:]
    v, u = (q @ modes[name].values if len(q) else np.zeros_like(phi) for name in ("radial", "meridional"))
    centre = float(modes.attrs["centre_height"]) + float(run.position[0])
    x, z = (r + v) * np.sin(phi) + u * np.cos(phi), centre + (r + v) * np.cos(phi) - u * np.sin(phi)
    ax.axhspan(-3 * r, float(run.elevation), color="#56B4E9", alpha=0.25, linewidth=0)
    ax.axhline(float(run.elevation), color="#0072B2", linewidth=0.8)
    ax.plot(r * np.sin(2 * phi), centre + r * np.cos(2 * phi), color="#999999", linewidth=0.6, linestyle=":")
    ax.plot([*x, *-x[::-1]], [*z, *z[::-1]], color=style(design, data.designs)["color"])
    ax.set(aspect="equal", xlim=(-1.5 * r, 1.5 * r), ylim=(-1.5 * r, 1.5 * r), xticks=[], yticks=[])
    ax.grid(visible=False)


def draw(name: str, data: StudyData) -> Figure:
    """Return the figure of a name from `vsb.specs.figure_names`."""
    kind, _, wave = name.partition("-")
    per_study = {f.__name__: f for f in (absorbed_power, mode_shapes, added_mass_damping, radiation_kernel)}
    per_wave = {f.__name__: f for f in (heave_excitation, velocity_pto, power_energy, energy_audit, snapshots)}
    return per_wave[kind](data, wave) if kind in per_wave else per_study[kind](data)
