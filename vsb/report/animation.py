"""Animated buoys of a page: frames of stored runs, thinned, and the shapes of the shell."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from vsb.report.interactive import as_script, packed
from vsb.study.sections import Water
from vsb.tools.arrays import FloatArray
from vsb.waves.dispersion import wavenumber
from vsb.waves.seas import Sea, superposed

PER_PERIOD = 24
"""Frames of a period."""
PERIODS = 8
"""Periods of a sea that are shown, the last ones of its window."""
COLATITUDES = 46
"""Points of a meridian."""
ACROSS = 9
"""Points of the water surface."""
SEEN = 1.7
"""Half the width of the water around a buoy [radii]."""
RIGID = {"heave": "Heave", "surge": "Surge", "pitch": "Pitch"}
"""Rigid motions in the plane that is drawn, by their name in the page's data."""
FROM_LEFT = "Waves come from the left; dotted: undeformed."
PLANE = (
    "The view is the vertical plane of surge, about its mean; a drifting buoy is followed. Waves towards 0 degrees "
    "come from the left; dotted: undeformed, with the line from the centre to the top."
)


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
    width: float,
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
    width : float
        Half the width of the water [m].
    shell : sequence of str
        Labels of the shell modes.
    direction : float
        The waves travel to, from the x axis [rad].
    """
    start, end = max(span[0], span[1] - PERIODS * period), span[1]
    time = np.linspace(start, end, int(PER_PERIOD * (end - start) / period) + 2)
    place = width * np.cos(direction) * np.linspace(-1, 1, ACROSS)
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
    found = {
        str(label): np.interp(time, run.time.values, column)
        for label, column in zip(run.dof.values, run.values.T, strict=True)
    }
    if "Surge" in found:
        found["Surge"] = found["Surge"] - _drift(time, found["Surge"])
    rigid = {name: packed(found[label]) for name, label in RIGID.items() if label in found}
    moved = [found[label] for label in shell if label in found]
    return {**rigid, "modes": len(moved), "shell": packed(np.array(moved).T.ravel())}


def _drift(time: FloatArray, surge: FloatArray) -> FloatArray:
    """Steady drift: the line through the means of the first and of the last period."""
    first, last = surge[:PER_PERIOD].mean(), surge[-PER_PERIOD:].mean()
    velocity = (last - first) / (time[-PER_PERIOD:].mean() - time[:PER_PERIOD].mean() or np.inf)
    return np.asarray(surge.mean() + velocity * (time - time.mean()))


def largest_shell(run: xr.DataArray, shell: Sequence[str]) -> float:
    """Return the largest amplitude of the shell modes of a run [m]; zero of a rigid design."""
    moved = run.isel(dof=run.dof.isin(list(shell)).values)
    return float(abs(moved).max()) if moved.size else 0.0


def in_motion(animated: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return what a page says of animated buoys, and their data for its scripts; None of none."""
    if animated is None:
        return None
    seas, factor = animated["seas"], animated["factor"]
    scale = f"shell displacement is magnified {factor:g} times, heave and waves are" if factor > 1 else "all is"
    names = [design["name"] for design in animated["designs"]]
    shown = f"{', '.join(names)}{' side by side' if len(names) > 1 else ''}"
    if any("surge" in design for sea in seas for design in sea["designs"]):
        view = PLANE
    else:
        view = "Dotted: undeformed." if all(sea["calm"] for sea in seas) else FROM_LEFT
    words = f"{animated.get('message', '')} {shown}; {scale} to scale.".strip()
    return {"words": words, "view": view, "data": as_script(animated)}
