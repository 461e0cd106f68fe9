"""Spectral densities of irregular seas, and the shares of their energy beyond a frequency.

Spectra that were measured are read in `vsb.engine.waves.measured_spectra`.
"""

import math
from typing import NamedTuple

import numpy as np

from vsb.engine.waves.dispersion import group_velocity
from vsb.engine.waves.kinds import (
    Irregular,
    Jonswap,
    OchiHubble,
    RecordedSea,
    RegularWave,
    SeaOfFile,
    SeaPart,
    TabulatedSea,
    WhiteNoise,
)
from vsb.engine.waves.spectrum_table import SpectrumTable
from vsb.engine.waves.water import Water
from vsb.tools.arrays import FloatArray

SMOOTHED = 0.05
"""Of the frequency of the energy period: width of the bands a record's spectrum is averaged over."""


def jonswap_spectrum(omega: FloatArray, hs: float, tp: float, gamma: float) -> FloatArray:
    """Return the JONSWAP spectral density, shape (omega,) [m^2 s/rad], scaled to 16 m0 = hs^2 exactly.

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    hs, tp : float
        Significant wave height [m], peak period [s].
    gamma : float
        Peakedness; 1 gives Pierson-Moskowitz.
    """

    def shape(w: FloatArray) -> FloatArray:
        peak = 2 * np.pi / tp
        sigma = np.where(w <= peak, 0.07, 0.09)
        bump: FloatArray = gamma ** np.exp(-((w / peak - 1) ** 2) / (2 * sigma**2))
        return np.asarray(w**-5.0 * np.exp(-1.25 * (peak / w) ** 4) * bump)

    fine = np.linspace(0.02, 40.0, 40001) * 2 * np.pi / tp
    m0 = float(np.trapezoid(shape(fine), fine))
    density: FloatArray = hs**2 / 16 / m0 * shape(omega)
    return density


def ochi_hubble_part(omega: FloatArray, part: SeaPart) -> FloatArray:
    """Return the spectral density of one of Ochi and Hubble's two peaks, shape (omega,) [m^2 s/rad], 16 m0 = hs^2.

    S = (1/4) (p w_p^4/4)^l/Gamma(l) hs^2/w^p exp(-(p/4) (w_p/w)^4), p = 4 l + 1, with the peakedness l; l = 1 is
    Pierson and Moskowitz's form (Ochi and Hubble, Six-parameter wave spectra, Proc. 15th ICCE, 1976).
    """
    p, ratio = part.exponent, omega / part.omega
    scale = 0.25 * (p / 4) ** part.peakedness / math.gamma(part.peakedness) * part.hs**2 / part.omega
    return np.asarray(scale * np.exp(-p * (np.log(ratio) + 0.25 * ratio**-4.0)))


def spectrum(wave: Irregular, omega: FloatArray) -> FloatArray:
    """Return the spectral density of an irregular sea, shape (omega,) [m^2 s/rad], 16 m0 = hs^2.

    That of a record is averaged over bands of a twentieth of the frequency of its energy period, that of a file is
    linear between its frequencies.
    """
    if isinstance(wave, RecordedSea):
        width = SMOOTHED * wave.omega
        return band_variances(wave, omega - width / 2, omega + width / 2) / width
    if isinstance(wave, TabulatedSea):
        return wave.file.at(omega)
    if isinstance(wave, OchiHubble):
        return np.asarray(sum(ochi_hubble_part(omega, part) for part in wave.parts))
    if isinstance(wave, WhiteNoise):
        low, high = wave.band
        return np.where((omega >= low) & (omega <= high), wave.hs**2 / 16 / (high - low), 0.0)
    return jonswap_spectrum(omega, wave.hs, wave.tp, wave.gamma if isinstance(wave, Jonswap) else 1.0)


def band_variances(wave: SeaOfFile, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the variance of a record or spectrum of a file between frequencies [rad/s], (band,) [m^2].

    Each harmonic of a record stands for the band of frequencies nearest to it, and is cut with it.
    """
    if isinstance(wave.file, SpectrumTable):
        return wave.file.variance_below(high) - wave.file.variance_below(low)
    spacing = 2 * np.pi / wave.file.length
    edges = spacing * (np.arange(len(wave.file.omega) + 1) + 0.5)
    below = np.concatenate([[0.0], np.cumsum(wave.file.variances)])
    return np.asarray(np.interp(high, edges, below) - np.interp(low, edges, below))


class SeaEnergy(NamedTuple):
    """Height, energy period and energy flux of a sea."""

    height: float  # significant height of an irregular sea, crest to trough of regular waves [m]
    period: float  # energy period of an irregular sea, Te = 2 pi m_-1/m_0 [s]
    flux: float  # rho g int v_g S dw, per metre of crest [W/m]


BANDS, HIGHEST = 2000, 40.0
"""Bands a spectrum is summed over, to this multiple of its highest peak frequency: beyond it lies 1e-6 of JONSWAP's."""


def sea_energy(wave: RegularWave | Irregular, water: Water) -> SeaEnergy:
    """Return height, period and energy flux of a sea in water of a depth (IEC TS 62600-101).

    Examples
    --------
    In deep water the flux is rho g^2 Hs^2 Te/(64 pi):

    >>> from vsb.engine.waves.kinds import Jonswap
    >>> sea = sea_energy(Jonswap(kind="jonswap", hs=2.0, tp=8.0), Water())
    >>> round(sea.period, 2), round(sea.flux / (1025 * 9.81**2 * 2.0**2 * sea.period / (64 * math.pi)), 6)
    (7.23, 1.0)
    """
    if isinstance(wave, RegularWave):
        omega, variance = np.array([wave.omega]), np.array([wave.amplitude**2 / 2])
        height = 2 * wave.amplitude
    else:
        (omega, variance), height = _bands(wave), wave.hs
    speed = np.array([group_velocity(w, water.depth, water.gravity) for w in omega])
    period = 2 * np.pi * float(variance @ (1 / omega) / variance.sum())
    return SeaEnergy(height, period, water.density * water.gravity * float(variance @ speed))


def _bands(wave: Irregular) -> tuple[FloatArray, FloatArray]:
    """Middles [rad/s] and variances [m^2] of the bands of an irregular sea."""
    if isinstance(wave, RecordedSea):
        return wave.file.omega, wave.file.variances
    if isinstance(wave, TabulatedSea | WhiteNoise):
        low, high = wave.band if isinstance(wave, WhiteNoise) else wave.file.omega[[0, -1]]
        edges = np.linspace(low, high, BANDS + 1)
    else:
        low, high = wave.reach
        edges = np.geomspace(low, HIGHEST * high, BANDS + 1)
    middle = (edges[1:] + edges[:-1]) / 2
    if isinstance(wave, TabulatedSea):
        return middle, band_variances(wave, edges[:-1], edges[1:])
    return middle, spectrum(wave, middle) * np.diff(edges)


def share_above(wave: Irregular, omega: float) -> float:
    """Return the share of an irregular sea's energy above a frequency [rad/s]."""
    if isinstance(wave, SeaOfFile):
        return wave.file.share_outside(0.0, omega)
    if isinstance(wave, WhiteNoise):
        low, high = wave.band
        return min(1.0, max(0.0, (high - omega) / (high - low)))
    beyond = np.linspace(omega, 20 * omega, 4001)
    return float(np.trapezoid(spectrum(wave, beyond), beyond)) * 16 / wave.hs**2


def share_below(wave: Irregular, omega: float) -> float:
    """Return the share of an irregular sea's energy below a frequency [rad/s]."""
    if isinstance(wave, SeaOfFile):
        return wave.file.share_outside(omega, np.inf)
    if isinstance(wave, WhiteNoise):
        low, high = wave.band
        return min(1.0, max(0.0, (omega - low) / (high - low)))
    below = np.linspace(0.0, omega, 4001)[1:]
    return float(np.trapezoid(spectrum(wave, below), below)) * 16 / wave.hs**2
