"""Figures of amplitude and phase over frequency: response amplitude operators and wave excitation."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from vsb.engine.hydro.labels import ROTATIONS, body_of, is_rigid, motion_of
from vsb.report.canvas import PORT, StudyData, grid_of_axes, legend_above, note, period_axis, shown_band
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray
from vsb.tools.words import superscripts

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
    low, high = shown_band(data)
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
    figure, axes = grid_of_axes(1.0 + 1.35 * len(rows), len(rows), 2, sharex=True)
    low, high = shown_band(data)
    shown: BoolArray = (omega >= low) & (omega <= high)
    for (label, curves), (left, right) in zip(rows.items(), axes, strict=True):
        angles = phases([values for values, _ in curves], shown)
        for (values, look), angle in zip(curves, angles, strict=True):
            left.plot(omega, np.abs(values), **look)
            if np.isfinite(angle).any():  # matplotlib places no markers on a line without points
                right.plot(omega, angle, **look)
        largest = max(float(np.abs(values[shown]).max(initial=0.0)) for values, _ in curves)
        left.set(ylabel=label, ylim=(0.0, 1.08 * largest or 1.0))
        _limit_phase(right, np.concatenate([angle[shown] for angle in angles]))
    for ax in axes[0]:
        period_axis(ax, (1.5, 2, 3, 4, 6, 10))
    axes[0, 0].set_title("amplitude", fontsize=9)
    axes[0, 1].set_title("phase lag", fontsize=9)
    for ax in axes[-1]:
        ax.set(xlabel="wave frequency [rad/s]", xlim=(low, high))
    legend_above(figure, *axes[:, 0])
    return figure


def phases(curves: Sequence[ComplexArray], shown: BoolArray) -> list[FloatArray]:
    """Return the phases of curves over frequency, continuous, in the same turn at low frequencies [degrees].

    Parameters
    ----------
    curves : sequence of ndarray, shape (omega,)
    shown : ndarray, shape (omega,)
        Frequencies of the band shown.

    Returns
    -------
    list of ndarray, shape (omega,) [degrees]
        NaN outside the band and where a curve is less than `SMALL` of its largest there: such a phase is noise.
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


def _limit_phase(ax: Axes, angles: FloatArray) -> None:
    """Limits and ticks that suit phases."""
    known = angles[np.isfinite(angles)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    span = max(high - low, LEAST_SPAN)
    middle, half = (low + high) / 2, 0.56 * span
    ax.set(ylabel="[degrees]", ylim=(middle - half, middle + half))
    ax.yaxis.set_major_locator(MultipleLocator(next((step for step in STEPS if span / step <= TICKS), STEPS[-1])))
