"""Spectral densities of irregular seas, and the shares of their energy beyond a frequency.

Spectra that were measured are read in `vsb.waves.measured_spectra`.
"""

import math

import numpy as np

from vsb.study.spectrum_table import SpectrumTable
from vsb.study.waves import Irregular, Jonswap, OchiHubble, RecordedSea, SeaOfFile, SeaPart, TabulatedSea, WhiteNoise
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
