"""Spectral densities of model seas.

Spectra that were measured are read in `vsb.engine.waves.measured_spectra`.
"""

import math
from collections.abc import Callable

import numpy as np

from vsb.engine.waves.dispersion import wavenumbers
from vsb.tools.arrays import FloatArray


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
    return _scaled(lambda w: _jonswap_shape(w, tp, gamma), omega, hs, tp)


def tma_spectrum(omega: FloatArray, hs: float, tp: float, gamma: float, depth: float, gravity: float) -> FloatArray:
    """Return the TMA spectral density, shape of `omega` [m^2 s/rad]: JONSWAP's in water of a depth [m], 16 m0 = hs^2.

    S = S_J(w) tanh^2(kh)/(1 + 2kh/sinh 2kh): a saturated sea has in any depth the same spectrum over wavenumber
    (Kitaigorodskii et al. 1975; Bouws et al., J. Geophys. Res. 90, 1985). In deep water it is JONSWAP's.
    """
    return _scaled(lambda w: _jonswap_shape(w, tp, gamma) * depth_factor(w, depth, gravity), omega, hs, tp)


def depth_factor(omega: FloatArray, depth: float, gravity: float) -> FloatArray:
    """Return tanh^2(kh)/(1 + 2kh/sinh 2kh), shape of `omega` [-]: (w^2 h/g)/2 in shallow, 1 in deep water."""
    kh = np.minimum(depth * wavenumbers(omega, depth, gravity), 300.0)
    return np.asarray(np.tanh(kh) ** 2 / (1 + 2 * kh / np.sinh(2 * kh)))


def _jonswap_shape(omega: FloatArray, tp: float, gamma: float) -> FloatArray:
    """JONSWAP's spectrum but for its height."""
    peak = 2 * np.pi / tp
    sigma = np.where(omega <= peak, 0.07, 0.09)
    bump: FloatArray = gamma ** np.exp(-((omega / peak - 1) ** 2) / (2 * sigma**2))
    return np.asarray(omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4) * bump)


def _scaled(shape: Callable[[FloatArray], FloatArray], omega: FloatArray, hs: float, tp: float) -> FloatArray:
    """A shape with the variance of a sea."""
    fine = np.linspace(0.02, 40.0, 40001) * 2 * np.pi / tp
    m0 = float(np.trapezoid(shape(fine), fine))
    return np.asarray(hs**2 / 16 / m0 * shape(omega))


def ochi_hubble_peak(omega: FloatArray, hs: float, tp: float, peakedness: float) -> FloatArray:
    """Return the spectral density of one of Ochi and Hubble's two peaks, shape of `omega` [m^2 s/rad], 16 m0 = hs^2.

    S = (1/4) (p w_p^4/4)^l/Gamma(l) hs^2/w^p exp(-(p/4) (w_p/w)^4), p = 4 l + 1, with the peakedness l; l = 1 is
    Pierson and Moskowitz's form (Ochi and Hubble, Six-parameter wave spectra, Proc. 15th ICCE, 1976).
    """
    p, peak = 4 * peakedness + 1, 2 * np.pi / tp
    scale = 0.25 * (p / 4) ** peakedness / math.gamma(peakedness) * hs**2 / peak
    ratio = omega / peak
    return np.asarray(scale * np.exp(-p * (np.log(ratio) + 0.25 * ratio**-4.0)))
