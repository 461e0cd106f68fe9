"""The deforming buoys in the waves, as a page draws them: frames of stored runs, thinned, and the shell's shapes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from vsb.hydro.dofs import flexible
from vsb.report.living import packed
from vsb.study.study import Water
from vsb.tools.units import FloatArray
from vsb.waves.dispersion import wavenumber
from vsb.waves.seas import Sea
from vsb.waves.superposition import superposed

PER_PERIOD = 24
"""Frames of a period: heave and shell move smoothly with it."""
PERIODS = 8
"""Periods of a sea that are shown, the last ones of its window."""
COLATITUDES = 46
"""Points of a meridian."""
ACROSS = 9
"""Places at which the water's surface is drawn."""
SEEN = 1.7
"""Half the width of the water around a buoy [radii]."""


def shapes_data(modes: xr.Dataset) -> dict[str, Any]:
    """Return the shell's shapes along a meridian, thinned, and its amplitudes at rest.

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
        **{name: packed(modes[name].values[kept]) for name in ("rest_radial", "rest_meridional") if name in modes},
    }


def frames_data(
    words: str,
    runs: Mapping[str, xr.Dataset],
    waves: Sea,
    window: tuple[float, float],
    period: float,
    width: float,
    water: Water,
) -> dict[str, Any]:
    """Return the frames of one sea: time, the water's surface, heave and shell amplitudes of every design.

    Parameters
    ----------
    words : str
    runs : mapping design -> Dataset
        Trajectories.
    waves : Sea
        Without components of still water.
    window : (float, float) [s]
    period : float
        Of the sea [s].
    width : float
        Half of what is seen of the water [m].
    water : Water
    """
    start, end = max(window[0], window[1] - PERIODS * period), window[1]
    time = np.linspace(start, end, int(PER_PERIOD * (end - start) / period) + 2)
    place = width * np.linspace(-1, 1, ACROSS)
    return {
        "words": words,
        "start": float(time[0]),
        "step": float(time[1] - time[0]),
        "frames": len(time),
        "surface": packed(surface(waves, time, place, water).ravel()),
        "designs": [_amplitudes(run, time) for run in runs.values()],
    }


def surface(waves: Sea, time: FloatArray, place: FloatArray, water: Water) -> FloatArray:
    """Return the undisturbed surface Re sum a exp(i(k x - w t)), shape (time, place) [m]; flat in still water."""
    if not len(waves.omega):
        return np.zeros((len(time), len(place)))
    number = np.array([wavenumber(w, water.depth, water.gravity) for w in waves.omega])
    amplitude = waves.amplitude[:, None] * np.exp(1j * number[:, None] * place)
    return superposed(waves.omega, amplitude, time)


def _amplitudes(run: xr.Dataset, time: FloatArray) -> dict[str, Any]:
    """Heave and, of a flexible design, the amplitudes of its shell at some times."""
    position = run.position.values
    count = position.shape[1] - 1 if flexible(run.dof.values) else 0
    found = [np.interp(time, run.time.values, position[:, i]) for i in range(1 + count)]
    shell = np.array(found[1:]).T.ravel() if count else np.zeros(0)
    return {"modes": count, "heave": packed(found[0]), "shell": packed(shell)}
