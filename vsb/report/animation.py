"""Animated buoys and bodies of a page: frames of stored runs, thinned, and the shapes of the shell or hull."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.bodies.outline import DISPLACED, OUTLINE
from vsb.engine.hydro.labels import motion_of
from vsb.engine.waves.seas import Sea, superposed
from vsb.engine.waves.water import Water, wavenumber
from vsb.report.interactive import as_script, packed
from vsb.report.shell_figures import round_factor
from vsb.tools.arrays import FloatArray

PER_PERIOD = 24
"""Frames of a period."""
PERIODS = 8
"""Periods of a sea that are shown, the last ones of its window."""
COLATITUDES = 46
"""Points of a meridian."""
ACROSS = 9
"""Points of the water surface around a buoy."""
ACROSS_BODY = 65
"""Points of the water surface around a body, which may be longer than waves."""
SEEN = 1.7
"""Half the width of the water around a buoy [radii]."""
LIVELY = 400
"""Moments of a run at which the motion of a body is measured."""
RIGID = {"heave": "Heave", "surge": "Surge", "pitch": "Pitch"}
"""Rigid motions in the plane that is drawn, by their name in the page's data."""
FROM_LEFT = "Waves come from the left; dotted: undeformed."
PLANE = (
    "The view is the vertical plane of surge, about its mean; a drifting buoy is followed. Waves towards 0 degrees "
    "come from the left; dotted: undeformed, with the line from the centre to the top."
)
HULL = (
    "The view is the vertical plane along x, {:.3g} m wide: the wetted hull cut through the middle of each body, surge "
    "about its mean, and the undisturbed water at y = {:g} m. Waves towards 0 degrees come from the left; dotted: at "
    "rest."
)


class View(NamedTuple):
    """A piece of water that is drawn."""

    width: float  # half of it [m]
    middle: tuple[float, float] = (0.0, 0.0)  # x and y [m]
    across: int = ACROSS  # points of the surface


def shapes_data(modes: xr.Dataset) -> dict[str, Any]:
    """Return the shapes of the shell along a meridian, thinned, and its amplitudes at rest.

    Parameters
    ----------
    modes : Dataset
        Of rule `modes`.
    """
    kept = np.linspace(0, modes.sizes["colatitude"] - 1, COLATITUDES).astype(int)
    return {
        "radius": float(modes.attrs["radius"]),
        "centre": float(modes.attrs["centre_height"]),
        "colatitude": packed(modes.colatitude.values[kept]),
        "radial": packed(modes.radial.values[:, kept].ravel()),
        "meridional": packed(modes.meridional.values[:, kept].ravel()),
        "rest": packed(modes.static_amplitude.values),
        **({"order": packed(modes["order"].values)} if "order" in modes else {}),
        **{name: packed(modes[name].values[kept]) for name in ("rest_radial", "rest_meridional") if name in modes},
    }


def frames_data(
    words: str,
    runs: Mapping[str, xr.DataArray],
    waves: Sea,
    span: tuple[float, float],
    period: float,
    view: View,
    water: Water,
    shell: Sequence[str],
    direction: float = 0.0,
) -> dict[str, Any]:
    """Return the frames of one sea: time, water surface, rigid motions and shell amplitudes of every design.

    Parameters
    ----------
    runs : mapping design -> DataArray, dims (time, dof) [m]
        Positions.
    waves : Sea
        Without components in still water, or under an assumed pressure.
    span : (float, float) [s]
        Its last `PERIODS` are shown.
    period : float
        Of the sea [s].
    view : View
    shell : sequence of str
        Labels of the shell modes, of a body of all its degrees of freedom.
    direction : float
        The waves travel to, from the x axis [rad].
    """
    start, end = max(span[0], span[1] - PERIODS * period), span[1]
    time = np.linspace(start, end, int(PER_PERIOD * (end - start) / period) + 2)
    x, y = view.middle[0] + view.width * np.linspace(-1, 1, view.across), view.middle[1]
    place = x * np.cos(direction) + y * np.sin(direction)
    return {
        "words": words,
        "start": float(time[0]),
        "step": float(time[1] - time[0]),
        "frames": len(time),
        "calm": not len(waves.omega),
        "surface": packed(surface(waves, time, place, water).ravel()),
        "designs": [_amplitudes(run, time, shell) for run in runs.values()],
    }


def surface(waves: Sea, time: FloatArray, place: FloatArray, water: Water) -> FloatArray:
    """Return the undisturbed surface Re sum a exp(i(k x - w t)), shape (time, place) [m]; flat in still water."""
    if not len(waves.omega):
        return np.zeros((len(time), len(place)))
    number = np.array([wavenumber(w, water.depth, water.gravity) for w in waves.omega])
    amplitude = waves.amplitude[:, None] * np.exp(1j * number[:, None] * place)
    return superposed(waves.omega, amplitude, time)


def _amplitudes(run: xr.DataArray, time: FloatArray, shell: Sequence[str]) -> dict[str, Any]:
    """Motions in the plane that is drawn at some times, surge without its drift; no shell of a rigid design."""
    moved = np.array([np.interp(time, run.time.values, column) for column in run.values.T]).T
    at = without_drift(xr.DataArray(moved, {"time": time, "dof": run.dof.values}, ("time", "dof")))
    found = dict(zip(map(str, at.dof.values), at.values.T, strict=True))
    rigid = {name: packed(found[label]) for name, label in RIGID.items() if label in found}
    none = np.zeros(len(time))
    shown = [found.get(label, none) for label in shell] if set(shell) & set(found) else []
    return {**rigid, "modes": len(shown), "shell": packed(np.array(shown).T.ravel())}


def without_drift(position: xr.DataArray) -> xr.DataArray:
    """Return positions, dims (time, dof), with the surge of every body about its mean and drift."""
    time, values = position.time.values, position.values.copy()
    for i in (i for i, label in enumerate(position.dof.values) if motion_of(str(label)) == "Surge"):
        values[:, i] -= _drift(time, values[:, i])
    return position.copy(data=values)


def _drift(time: FloatArray, surge: FloatArray) -> FloatArray:
    """Steady drift: the line through the means of the first and of the last period."""
    first, last = surge[:PER_PERIOD].mean(), surge[-PER_PERIOD:].mean()
    velocity = (last - first) / (time[-PER_PERIOD:].mean() - time[:PER_PERIOD].mean() or np.inf)
    return np.asarray(surge.mean() + velocity * (time - time.mean()))


def largest_shell(run: xr.DataArray, shell: Sequence[str]) -> float:
    """Return the largest amplitude of the shell modes of a run [m]; zero of a rigid design."""
    moved = run.isel(dof=run.dof.isin(list(shell)).values)
    return float(abs(moved).max()) if moved.size else 0.0


def displaced_outline(ds: xr.Dataset, position: xr.DataArray) -> FloatArray:
    """Return the lines of a body displaced in the x-z plane, shape (time, line, end, xz) [m].

    Parameters
    ----------
    ds : Dataset
        Its hydro database, with `outline` and `outline_displacement` psi.
    position : DataArray, dims (time, dof) [m, rad]
        Amplitudes q: points x move to x + sum_i q_i psi_i(x), as linear theory has it, rotations included.
    """
    moved = ds[DISPLACED].sel(influenced_dof=position.dof.values).values[..., ::2]
    return np.asarray(ds[OUTLINE].values[..., ::2] + np.tensordot(position.values, moved, 1))


def largest_motion(ds: xr.Dataset, run: xr.Dataset) -> float:
    """Return the largest displacement in a run of a body without its drift, or elevation if that is larger [m]."""
    seen = run.isel(time=np.linspace(0, run.sizes["time"] - 1, LIVELY).astype(int))
    moved = displaced_outline(ds, without_drift(seen.position)) - ds[OUTLINE].values[..., ::2]
    return max(float(np.abs(moved).max()), float(np.abs(run.elevation).max()))


def outline_data(ds: xr.Dataset, largest: float) -> tuple[View, dict[str, Any]]:
    """Return the view of a body, and the data of its lines: factor on motion and waves, shapes, what is seen of z.

    Parameters
    ----------
    ds : Dataset
        Its hydro database, with `outline` and `outline_displacement`.
    largest : float
        Motion that must fit into the view [m].
    """
    points = ds[OUTLINE].values
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    size, middle = max(high[0] - low[0], -low[2]) / 2, (low + high) / 2
    factor = round_factor(largest, size)
    beside = max(0.35 * size, 1.3 * factor * largest)
    view = View(float(size + beside), (float(middle[0]), float(middle[1])), ACROSS_BODY)
    shapes = {
        "outline": packed(points[..., ::2].ravel()),
        "displacement": packed(ds[DISPLACED].values[..., ::2].ravel()),
    }
    seen = {"middle": list(view.middle), "top": float(beside), "bottom": float(beside - low[2])}
    return view, {"factor": factor, "shapes": shapes, **seen}


def in_motion(animated: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return what a page says of animated buoys, and their data for its scripts; None of none."""
    if animated is None:
        return None
    seas, factor = animated["seas"], animated["factor"]
    of_body = "outline" in animated["shapes"]
    names = [design["name"] for design in animated["designs"]]
    shown = f"{', '.join(names)}{' side by side' if len(names) > 1 and not of_body else ''}"
    if factor <= 1:
        scale = "all is to scale"
    elif of_body:
        scale = f"motion and waves are magnified {factor:g} times"
    else:
        scale = f"shell displacement is magnified {factor:g} times, heave and waves are to scale"
    if of_body:
        view = HULL.format(2 * animated["width"], round(animated["middle"][1], 3) + 0.0)
    elif any("surge" in design for sea in seas for design in sea["designs"]):
        view = PLANE
    else:
        view = "Dotted: undeformed." if all(sea["calm"] for sea in seas) else FROM_LEFT
    words = f"{animated.get('message', '')} {shown}; {scale}.".strip()
    title = "The body in the waves" if of_body else "The buoys in the waves"
    return {"title": title, "words": words, "view": view, "data": as_script(animated)}
