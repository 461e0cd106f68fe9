"""The band of wave frequencies that is shown, and that counts; where gains over it are largest and least."""

from collections.abc import Callable

import numpy as np
import xarray as xr

from vsb.tools.arrays import BoolArray, FloatArray

LOWEST = 0.3
"""Least frequency shown, of waves of 21 s [rad/s]: longer ones are not seas."""
USEFUL = 0.05
"""Part of the largest absorbed power, less than which is of no use: nor is a gain there."""
RESOLVED, RELATIVE = 0.01, 1e-3
"""Gains at their extremes are known to so many points [%], and to such a part of them."""
HALVINGS = 30
"""Of a step of frequency, at most."""


def lowest(first: float, last: float) -> float:
    """Return the least frequency shown of a band [rad/s]: its own first where hardly any of it is of seas."""
    return LOWEST if last >= 2 * LOWEST else first


def useful_band(absorbed: xr.DataArray) -> xr.DataArray:
    """Return at which frequencies some design absorbs a useful power; dims of the argument (design, omega)."""
    best, least = absorbed.max(dim="design"), lowest(float(absorbed.omega[0]), float(absorbed.omega[-1]))
    found: xr.DataArray = (best >= USEFUL * best.max()) & (absorbed.omega >= least)
    return found


def gain_band(absorbed: xr.DataArray, reference: str) -> xr.DataArray:
    """Return at which frequencies a gain over a design says something, dims (omega).

    Where the reference takes next to nothing, of its own and of what others take, any power is a thousandfold of it.
    """
    rigid = absorbed.sel(design=reference, drop=True)
    takes = (rigid >= USEFUL * rigid.max()) | (rigid >= 0.1 * absorbed.max("design"))
    found: xr.DataArray = useful_band(absorbed) & takes & (rigid > 0)
    return found


def with_extremes(power: Callable[[FloatArray], xr.DataArray], omega: FloatArray, reference: str) -> FloatArray:
    """Return frequencies with those between them at which gains over a design are largest and least [rad/s].

    Parameters
    ----------
    power : callable
        Frequencies -> absorbed power, dims (design, omega).
    omega : ndarray, shape (omega,) [rad/s]
        Ascending, near enough to show that there is an extreme.
    reference : str

    Notes
    -----
    Steps beside an extreme, and across an end of `gain_band`, are halved until the gain changes over them by less than
    is asked for: by `RESOLVED` and `RELATIVE` of it.
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
    """Which steps lie beside an extreme of a gain in its band, or of power, or across an end, and are too long."""
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
