"""Radiation damping from the excitation of another code's files (Haskind), at the modes and frequencies they allow."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.hydro import quality
from vsb.tools.arrays import BoolArray, FloatArray
from vsb.waves.dispersion import group_velocity, wavenumber

LARGEST_HASKIND = 0.05
"""Difference of the damping from Haskind's, in terms of the largest damping of both motions."""


class Haskind(NamedTuple):
    """Damping from excitation, and where it may be compared."""

    damping: FloatArray  # (omega, dof, dof) [kg/s]
    resolved: BoolArray  # (omega, dof)


def _narrowness(omega: FloatArray, depth: float, gravity: float) -> FloatArray:
    """Wavenumber over group velocity, shape (omega,) [s/m^2]: all of Haskind's relation that feels the depth."""
    return np.array([wavenumber(w, depth, gravity) / group_velocity(w, depth, gravity) for w in omega])


def haskind_axisymmetric(ds: xr.Dataset, *, depth: float, density: float, gravity: float) -> Haskind:
    """Return the damping of motions that send out ring waves, from the excitation of the first heading."""
    damping = quality.haskind_damping(ds, depth, density, gravity)
    return Haskind(np.real(damping), np.ones(damping.shape[:2], dtype=bool))


def haskind_headings(
    ds: xr.Dataset, size: FloatArray, *, depth: float, density: float, gravity: float
) -> Haskind | None:
    """Return the damping from the excitation of headings all around; None if they are not in equal steps.

    Parameters
    ----------
    size : ndarray, shape (dof,) [kg/s]
        Dampings that count.

    Notes
    -----
    B = k/(8 pi rho g v_g) int X X^H d beta (Newman, Marine Hydrodynamics, ch. 6), by the trapezoidal rule, which is
    exact for Fourier series over beta that end below half the number of headings. A mode is resolved up to the
    frequency at which the last two orders hold more than 2.5 % of its largest power in the band, or of its size: above
    it orders that are too high may look like low ones.
    """
    degrees, first = np.unique(np.round(np.degrees(ds.wave_direction.values) % 360, 3) % 360, return_index=True)
    n = len(degrees)
    if n < 6 or not np.allclose(np.diff([*degrees, degrees[0] + 360]), 360 / n, atol=0.01):
        return None
    factor = _narrowness(ds.omega.values, depth, gravity) / (4 * density * gravity)
    x = ds.excitation_force.values[:, first, :] * np.sqrt(factor)[:, None, None]
    power = np.abs(np.fft.fft(x, axis=1) / n) ** 2
    last = np.abs(np.fft.fftfreq(n, 1 / n)) >= n // 2 - 1
    largest = np.maximum(power.sum(axis=1).max(axis=0), size)
    resolved = np.logical_and.accumulate(power[:, last].sum(axis=1) <= LARGEST_HASKIND / 2 * largest)
    return Haskind(np.einsum("whi,whj->wij", x, x.conj()).real / n, resolved)


def fitting_depth(ratio: FloatArray, omega: FloatArray, depth: float, gravity: float) -> float | None:
    """Return the depth with which ratios of Haskind's damping to damping would be one to `LARGEST_HASKIND`, if any.

    Parameters
    ----------
    ratio : ndarray, shape (entry,) [-]
        With `depth`.
    omega : ndarray, shape (entry,) [rad/s]
    """
    own = _narrowness(omega, depth, gravity)
    longest = gravity / float(omega.min()) ** 2
    tried = np.array([np.inf, *(longest * np.geomspace(3.0, 1e-4, 150))])
    error = [np.abs(ratio * _narrowness(omega, h, gravity) / own - 1).max() for h in tried]
    best = int(np.argmin(error))
    return float(tried[best]) if error[best] <= LARGEST_HASKIND else None
