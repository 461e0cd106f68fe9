"""A climate from a scatter table, the occurrence of heights and periods, with one spectral shape for all seas."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np

from vsb.engine.waves.climate import FAULTY, TINY, YEAR_HOURS, Climate, band_edges
from vsb.engine.waves.records import impossible
from vsb.engine.waves.scatter_table import Table, read_table
from vsb.engine.waves.series import read_series
from vsb.engine.waves.spectra import jonswap_spectrum
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray

Spectrum = Literal["jonswap", "pierson_moskowitz"]
BAND = 0.02
"""Width of the bands of a climate from a table, relative to their frequency [-]."""
REACH = 0.45, 10.0
"""Ends of the bands in multiples of peak frequencies: 1e-4 of the variance lies beyond."""
WHOLE = 0.02
"""Relative error allowed in the sum of shares, percent or hours: tables round."""


def read_scatter(path: str | Path, spectrum: Spectrum = "jonswap", gamma: float = 3.3) -> Climate:
    """Return the climate of a scatter table, one sea for each occupied cell.

    Raises `ConfigError` with file, line, value received and value needed.

    Parameters
    ----------
    path : path
        CSV: a table whose corner says `Hs/Te`, `Hs/Tp` or `Hs/Tz` (or the other way round), or three columns named so
        with occurrences in percent, hours, shares or counts. Labels are centres of bins, or ranges; see
        `vsb.engine.waves.scatter_table`. Or a series of Hs and a period, which is counted; see
        `vsb.engine.waves.series`.
    spectrum : {'jonswap', 'pierson_moskowitz'}
    gamma : float
        Peakedness of JONSWAP.
    """
    table = read_series(path) or read_table(path)
    share, total = _shares(path, table)
    gamma = gamma if spectrum == "jonswap" else 1.0
    ratio = energy_period_over(table.kind, gamma)
    te = table.period * ratio
    notes = [f"{len(share)} occupied cells of Hs and {table.kind.capitalize()}, which sum to {total}", *table.notes]
    shape = f"JONSWAP spectra, gamma {gamma:g}" if spectrum == "jonswap" else "Pierson-Moskowitz spectra"
    notes += [f"Te = {ratio:.3f} {table.kind.capitalize()} of these spectra"] if table.kind in ("tz", "t01") else []
    wrong = impossible(table.hs, te)
    if share[wrong].sum() > FAULTY:
        at = int((table.hs / np.maximum(te, TINY) ** 2).argmax())
        raise ConfigError(
            f"{path}: received {share[wrong].sum():.1%} of seas that are physically impossible, as Hs "
            f"{table.hs[at]:.4g} m with {table.kind.capitalize()} {table.period[at]:.4g} s; needs Hs "
            "in m, periods in s, the corner the right way"
        )
    return climate_of_cells(table.hs, te, share, gamma, Path(path).name, (*notes, shape))


def climate_of_cells(
    hs: FloatArray, te: FloatArray, share: FloatArray, gamma: float, name: str, notes: Sequence[str] = ()
) -> Climate:
    """Return the climate of JONSWAP seas of given heights, energy periods and shares, each shape (sea,)."""
    tp = te / energy_over_peak_period(gamma)
    low, high = 2 * np.pi / tp.max() * REACH[0], 2 * np.pi / tp.min() * REACH[1]
    omega = np.geomspace(low, high, int(np.ceil(np.log(high / low) / BAND)) + 1)
    return Climate(omega, jonswap_bands(omega, hs, tp, gamma), share, hs, te, name, tuple(notes))


@cache
def _unit_sea(gamma: float) -> tuple[FloatArray, FloatArray]:
    """Frequencies over that of the peak, and the variance below them of a sea of m0 = 1."""
    from scipy.integrate import cumulative_trapezoid  # slow to import, and not needed for spectra

    x = np.linspace(0.0, 40.0, 40001)[1:]
    below = cumulative_trapezoid(jonswap_spectrum(x, 4.0, 2 * np.pi, gamma), x=x, initial=0)
    return x, np.asarray(below / below[-1])


@cache
def energy_period_over(kind: str, gamma: float) -> float:
    """Return Te over another period of a JONSWAP sea [-], by its moments: Te = 2 pi m_-1/m_0.

    Parameters
    ----------
    kind : {'te', 'tp', 'tz', 't01'}
        The energy period itself, the peak period, the zero-crossing period 2 pi sqrt(m_0/m_2), or 2 pi m_0/m_1.
    gamma : float
    """
    x, _ = _unit_sea(gamma)
    density = jonswap_spectrum(x, 4.0, 2 * np.pi, gamma)
    before, m0, m1, m2 = (float(np.trapezoid(density * x**n, x)) for n in (-1, 0, 1, 2))
    m2 += float(density[-1] * x[-1] ** 3) / 2  # beyond the last frequency S falls with its fifth power
    te = before / m0  # in peak periods, as the others
    return float(te / {"te": te, "tp": 1.0, "tz": np.sqrt(m0 / m2), "t01": m0 / m1}[kind])


def energy_over_peak_period(gamma: float) -> float:
    """Return Te/Tp of a JONSWAP sea [-]; 0.857 for gamma 1, 0.903 for 3.3."""
    return energy_period_over("tp", gamma)


def jonswap_bands(omega: FloatArray, hs: FloatArray, tp: FloatArray, gamma: float) -> FloatArray:
    """Return mean densities over bands of JONSWAP seas, shape (sea, omega) [m^2 s].

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
        Centres of the bands.
    hs, tp : ndarray, shape (sea,) [m], [s]
    """
    edges = band_edges(omega)
    x, below = _unit_sea(gamma)
    cumulated = np.interp(np.outer(tp / (2 * np.pi), edges), x, below)
    return np.asarray(hs[:, None] ** 2 / 16 * np.diff(cumulated, axis=1) / np.diff(edges))


def _shares(path: str | Path, table: Table) -> tuple[FloatArray, str]:
    """Shares of the year, and the sum of the occurrences in words."""
    total = float(table.occurrence.sum())
    known = {100.0: "percent", 1.0: "shares", YEAR_HOURS: "hours"}
    units = [table.unit] if table.unit else list(known)
    near = [unit for unit in units if abs(total / unit - 1) <= WHOLE]
    if near:
        return table.occurrence / total, f"{total:.6g} ({known[near[0]]} of {near[0]:g})"
    if table.unit is None and np.all(table.occurrence == np.rint(table.occurrence)):
        return table.occurrence / total, f"{total:.6g} counts"
    needed = f"{table.unit:g} ({known[table.unit]})" if table.unit else "1, 100 (percent), 8766 (hours) or whole counts"
    raise ConfigError(f"{path}: received occurrences that sum to {total:.6g}, needs {needed}")
