"""Retardation kernel and the Kramers-Kronig relations of radiation, from damping over frequency.

The damping is a cubic spline through the solved frequencies and through B(0) = 0 (B ~ omega^3 in deep water, omega in
finite depth), continued above the band as omega^-3, the decay of a body that meets the surface at a right angle.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import exp1

from vsb.errors import DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray

_NODE, _WEIGHT = np.polynomial.legendre.leggauss(8)
_TAIL_NODE, _TAIL_WEIGHT = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True)
class DampingSpectrum:
    """Radiation damping as a function of frequency, and its transforms."""

    omega: FloatArray  # solved frequencies, ascending, (omega,) [rad/s]
    damping: FloatArray  # (omega, dof, dof) [kg/s]

    def __post_init__(self) -> None:
        """Check that all values are finite."""
        if not (np.isfinite(self.omega).all() and np.isfinite(self.damping).all()):
            raise DatabaseError("radiation damping: received NaN or infinite values; solve these frequencies again.")

    def combined(self, combinations: FloatArray) -> "DampingSpectrum":
        """Return the spectrum of combinations of the motions, shape (dof, combination): all transforms are linear."""
        return DampingSpectrum(self.omega, combinations.T @ self.damping @ combinations)

    @property
    def diagonal(self) -> "DampingSpectrum":
        """The spectrum of each motion by itself, its damping of shape (omega, dof, 1)."""
        return DampingSpectrum(self.omega, np.einsum("wii->wi", self.damping)[..., None])

    @cached_property
    def spline(self) -> CubicSpline:
        """Cubic spline of the damping over [0, omega_max], zero at 0."""
        omega = np.concatenate([[0.0], self.omega])
        damping = np.concatenate([np.zeros_like(self.damping[:1]), self.damping])
        flat = np.zeros_like(self.damping[0])
        return CubicSpline(omega, damping, bc_type=("not-a-knot", (2, flat)))

    @cached_property
    def _quadrature(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gauss points within every spline interval: frequencies, weights, damping there."""
        edges = self.spline.x
        half = np.diff(edges)[:, None] / 2
        nodes = ((edges[:-1] + edges[1:])[:, None] / 2 + half * _NODE).ravel()
        return nodes, (half * _WEIGHT).ravel(), self.spline(nodes)

    @property
    def _tail(self) -> FloatArray:
        """Damping at the end of the band, beyond which it falls as omega^-3."""
        end: FloatArray = self.damping[-1]
        return end

    def kernel(self, time: FloatArray) -> FloatArray:
        """Return the retardation kernel K(t) = (2/pi) int B cos(omega t) d omega, shape (time, dof, dof) [kg/s^2].

        Eight Gauss points per interval are exact to round-off up to t = 10/(frequency step). The tail integral is a
        generalized exponential integral, int_W^inf cos(wt) w^-3 dw = Re E_3(iWt)/W^2.
        """
        nodes, weights, values = self._quadrature
        top = self.omega[-1]
        band = np.cos(np.outer(time, nodes)) @ (weights[:, None] * values.reshape(len(nodes), -1))
        tail = np.outer(np.real(_e3(1j * top * time)) * top, self._tail.ravel())
        kernel: FloatArray = 2 / np.pi * (band + tail).reshape(len(time), *self.damping.shape[1:])
        return kernel

    def added_mass_difference(self, omega: FloatArray) -> FloatArray:
        """Return A(omega) - A(infinity) by Kramers-Kronig, shape (omega, dof, dof) [kg].

        -(2/pi) PV int B(v)/(omega^2 - v^2) dv, with the singularity taken out: PV int dv/(omega^2 - v^2) = 0.
        """
        nodes, weights, values = self._quadrature
        top = self.omega[-1]
        u = 0.5 * (_TAIL_NODE + 1)  # v = top/u beyond the band
        beyond, beyond_weight = top / u, 0.5 * _TAIL_WEIGHT * top / u**2
        v, w = np.concatenate([nodes, beyond]), np.concatenate([weights, beyond_weight])
        b = np.concatenate([values, u[:, None, None] ** 3 * self._tail])
        here = self.at(omega)
        kernel = w / (omega[:, None] ** 2 - v**2)
        integral = np.tensordot(kernel, b, 1) - kernel.sum(axis=1)[:, None, None] * here
        difference: FloatArray = -2 / np.pi * integral
        return difference

    def at(self, omega: FloatArray) -> FloatArray:
        """Return the damping at any frequency, shape (omega, dof, dof) [kg/s]."""
        top = self.omega[-1]
        inside: FloatArray = self.spline(np.minimum(omega, top))
        fall = np.minimum(1.0, top / np.maximum(omega, 1e-12)) ** 3
        damping: FloatArray = inside * fall[:, None, None]
        return damping

    def transfer(self, omega: FloatArray) -> ComplexArray:
        """Return K(s = i omega) = B + i omega (A - A(infinity)), shape (omega, dof, dof) [kg/s]."""
        transfer: ComplexArray = self.at(omega) + 1j * omega[:, None, None] * self.added_mass_difference(omega)
        return transfer


def _e3(z: ComplexArray) -> ComplexArray:
    """Generalized exponential integral E_3 by recurrence from E_1; E_3(0) = 1/2."""
    z = np.asarray(z, dtype=complex)
    safe = np.where(z == 0, 1.0, z)
    e2 = np.exp(-safe) - safe * exp1(safe)
    return np.where(z == 0, 0.5, (np.exp(-safe) - safe * e2) / 2)
