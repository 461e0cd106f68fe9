"""The band of wave frequencies that is shown and counts, and where gains over it are largest and smallest."""

from collections.abc import Callable

import numpy as np
import xarray as xr

from vsb.tools.arrays import BoolArray, FloatArray

LOWEST = 0.3
"""Lowest frequency shown [rad/s]: waves longer than 21 s are not seas."""
USEFUL = 0.05
"""Share of the largest absorbed power below which power, and a gain there, is of no use."""
RESOLVED, RELATIVE = 0.01, 1e-3
"""Absolute [%] and relative tolerance of gains at their extremes."""
HALVINGS = 30
"""Most halvings of a step of frequency."""


def lowest(first: float, last: float) -> float:
    """Return the lowest frequency shown of a band [rad/s]: `LOWEST`, or the first of a band that hardly exceeds it."""
    return LOWEST if last >= 2 * LOWEST else first


def useful_band(absorbed: xr.DataArray) -> xr.DataArray:
    """Return at which frequencies some design absorbs a useful power; dims of the argument (design, omega)."""
    best, least = absorbed.max(dim="design"), lowest(float(absorbed.omega[0]), float(absorbed.omega[-1]))
    found: xr.DataArray = (best >= USEFUL * best.max()) & (absorbed.omega >= least)
    return found


def gain_band(absorbed: xr.DataArray, reference: str) -> xr.DataArray:
    """Return at which frequencies a gain over a design is meaningful, dims (omega).

    Not where the reference absorbs next to nothing compared with its largest power and with other designs.
    """
    rigid = absorbed.sel(design=reference, drop=True)
    absorbs = (rigid >= USEFUL * rigid.max()) | (rigid >= 0.1 * absorbed.max("design"))
    found: xr.DataArray = useful_band(absorbed) & absorbs & (rigid > 0)
    return found


def with_extremes(power: Callable[[FloatArray], xr.DataArray], omega: FloatArray, reference: str) -> FloatArray:
    """Return frequencies refined where gains over a design are largest and smallest [rad/s].

    Parameters
    ----------
    power : callable
        Frequencies -> absorbed power, dims (design, omega).
    omega : ndarray, shape (omega,) [rad/s]
        Ascending, fine enough to show every extreme.

    Notes
    -----
    Steps next to an extreme, and across an end of `gain_band`, are halved until the gain changes over them by less than
    the tolerance `RESOLVED` + `RELATIVE` times the gain.
    """
    found = power(omega)
    for _ in range(HALVINGS):
        steps = _unresolved(found, reference)
        if not steps.any():
            break
        known = found.omega.values
        between = (known[1:] + known[:-1])[steps] / 2
        found = xr.concat([found, power(between)], "omega").sortby("omega")
    return np.asarray(found.omega.values)


def _unresolved(power: xr.DataArray, reference: str) -> BoolArray:
    """Which steps next to an extreme of gain or power, or across an end of the band, are too long."""
    shown = gain_band(power, reference).values
    others = power.sel(design=power.design != reference)
    rigid = power.sel(design=reference).where(power.sel(design=reference) > 0, 1.0)
    best = power.max("design")
    curves = np.vstack([100 * (others / rigid - 1).values, 100 * (best / best.max()).values[None]])
    change = np.diff(curves)
    long = np.abs(change) > RESOLVED + RELATIVE * np.minimum(np.abs(curves[:, 1:]), np.abs(curves[:, :-1]))
    turns = np.zeros_like(curves, dtype=bool)
    turns[:, 1:-1] = change[:, 1:] * change[:, :-1] <= 0
    near = shown[1:] | shown[:-1]
    ends = shown[1:] != shown[:-1]
    return np.asarray((long & (((turns[:, 1:] | turns[:, :-1]) & near) | ends)).any(axis=0))
