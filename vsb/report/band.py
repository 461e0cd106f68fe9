"""The band of wave frequencies that is shown, and that counts."""

import xarray as xr

LOWEST = 0.3
"""Least frequency shown, of waves of 21 s [rad/s]: longer ones are not seas."""
USEFUL = 0.05
"""Part of the largest absorbed power, less than which is of no use: nor is a gain there."""


def lowest(first: float, last: float) -> float:
    """Return the least frequency shown of a band [rad/s]: its own first where hardly any of it is of seas."""
    return LOWEST if last >= 2 * LOWEST else first


def useful_band(absorbed: xr.DataArray) -> xr.DataArray:
    """Return at which frequencies some design absorbs a useful power; dims of the argument (design, omega)."""
    best, least = absorbed.max(dim="design"), lowest(float(absorbed.omega[0]), float(absorbed.omega[-1]))
    found: xr.DataArray = (best >= USEFUL * best.max()) & (absorbed.omega >= least)
    return found
