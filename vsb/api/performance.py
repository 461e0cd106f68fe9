"""Energy production and power matrices of IEC TS 62600-100, from and to the arrays that MHKiT uses."""

from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from vsb.engine.waves.climate import YEAR_HOURS
from vsb.errors import ConfigError
from vsb.results.year import Bins


def power_matrix(
    hs: npt.ArrayLike,
    te: npt.ArrayLike,
    values: npt.ArrayLike,
    statistic: Literal["mean", "std", "frequency"] = "mean",
) -> xr.DataArray:
    """Return a quantity of many seas by bins of 0.5 m of Hs and 1 s of Te, dims (hs, te); NaN in empty bins.

    Parameters
    ----------
    hs, te : array_like, shape (sea,) [m], [s]
    values : array_like, shape (sea,)
        Power, capture width or energy flux of each sea.
    statistic : {'mean', 'std', 'frequency'}
        `frequency` is the share of seas in a bin, whatever the values.

    Raises
    ------
    ConfigError
        If the arrays differ in length or hold a number that is not finite.
    """
    height, period, value = (np.asarray(each, dtype=float) for each in (hs, te, values))
    if not height.shape == period.shape == value.shape or height.ndim != 1 or not height.size:
        raise ConfigError(
            f"power_matrix: received {height.shape} hs, {period.shape} te, {value.shape} values; needs as many of each"
        )
    if not all(np.isfinite(each).all() for each in (height, period, value)) or min(height.min(), period.min()) < 0:
        raise ConfigError("power_matrix: needs finite numbers, heights and periods not below 0")
    if statistic not in ("mean", "std", "frequency"):
        raise ConfigError(f"power_matrix: received {statistic!r}, needs one of mean, std, frequency")
    bins = Bins(height, period, np.full(len(height), 1 / len(height)))
    matrix = {"mean": bins.mean, "std": bins.deviation}[statistic](value) if statistic != "frequency" else bins.share
    at = {"hs": bins.hs_centres, "te": bins.te_centres}
    return xr.DataArray(np.where(bins.count > 0, matrix, np.nan), coords=at, dims=("hs", "te"))


def annual_energy(capture_width: npt.ArrayLike, energy_flux: npt.ArrayLike, frequency: npt.ArrayLike) -> float:
    """Return the mean annual energy production by matrices, 8766 h times the sum of L J f [Wh].

    Parameters
    ----------
    capture_width : array_like, shape (hs, te) [m]
    energy_flux : array_like, shape (hs, te) [W/m]
    frequency : array_like, shape (hs, te) [-]
        Share of the year of each bin. A bin without seas may be NaN in all three.

    Raises
    ------
    ConfigError
        If the shapes differ, shares sum to more than 1, or a bin with seas has no value.
    """
    width, flux, share = (np.asarray(each, dtype=float) for each in (capture_width, energy_flux, frequency))
    if not width.shape == flux.shape == share.shape or not width.size:
        raise ConfigError(f"annual_energy: received shapes {width.shape}, {flux.shape}, {share.shape}; needs one shape")
    share = np.where(np.isnan(share), 0.0, share)
    if share.sum() > 1 + 1e-9 or share.min() < 0:
        raise ConfigError(
            f"annual_energy: received shares that sum to {share.sum():.6g}; needs at most 1, none below 0"
        )
    occupied = share > 0
    energy = (width * flux * share)[occupied]
    if not np.isfinite(energy).all():
        raise ConfigError(
            f"annual_energy: received {np.count_nonzero(~np.isfinite(energy))} bins with seas but without a value, as "
            "of a design that is not viable; needs a value in each"
        )
    return float(YEAR_HOURS * energy.sum())


def annual_energy_of_series(capture_width: npt.ArrayLike, energy_flux: npt.ArrayLike) -> float:
    """Return the mean annual energy production by records of equal shares, 8766 h times the mean of L J [Wh].

    Parameters
    ----------
    capture_width : array_like, shape (record,) [m]
    energy_flux : array_like, shape (record,) [W/m]
    """
    width, flux = np.asarray(capture_width, float), np.asarray(energy_flux, float)
    if width.shape != flux.shape or not width.size or not np.isfinite(width * flux).all():
        raise ConfigError(
            f"annual_energy_of_series: received shapes {width.shape} and {flux.shape}; needs as many finite numbers"
        )
    return float(YEAR_HOURS * np.mean(width * flux))
