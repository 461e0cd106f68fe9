"""Retardation kernel and the Kramers-Kronig relations of radiation, from damping over frequency.

The damping is a cubic spline through the solved frequencies and through B(0) = 0 (B ~ omega^3 in deep water, omega in
finite depth), continued above the band as omega^-3, the decay of a body that meets the surface at a right angle. All
that follows from it is linear in the values at the solved frequencies: a sum with weights that all motions share.
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

    @property
    def diagonal(self) -> "DampingSpectrum":
        """The spectrum of each motion by itself, its damping of shape (omega, dof)."""
        return DampingSpectrum(self.omega, np.einsum("wii->wi", self.damping))

    def combined(self, combinations: FloatArray) -> "DampingSpectrum":
        """Return the spectrum of combinations of the motions, shape (dof, combination)."""
        return DampingSpectrum(self.omega, combinations.T @ self.damping @ combinations)

    @cached_property
    def _quadrature(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gauss points within every spline interval: frequencies, weights, shares of the solved values there."""
        edges = np.append(0.0, self.omega)
        half = np.diff(edges)[:, None] / 2
        nodes = ((edges[:-1] + edges[1:])[:, None] / 2 + half * _NODE).ravel()
        return nodes, (half * _WEIGHT).ravel(), self.shares(nodes)

    @cached_property
    def _unit(self) -> CubicSpline:
        """Cubic splines over [0, omega_max], each one at one solved frequency and zero at the others and at 0."""
        count = len(self.omega)
        ones, flat = np.eye(count + 1)[:, 1:], np.zeros(count)
        return CubicSpline(np.append(0.0, self.omega), ones, bc_type=("not-a-knot", (2, flat)))

    def shares(self, omega: FloatArray) -> FloatArray:
        """Return the shares of the solved values in the damping at any frequency, shape (omega, solved) [-]."""
        top = self.omega[-1]
        fall = np.minimum(1.0, top / np.maximum(omega, 1e-12)) ** 3
        return np.asarray(self._unit(np.minimum(omega, top)) * fall[:, None])

    def kernel(self, time: FloatArray) -> FloatArray:
        """Return the retardation kernel K(t) = (2/pi) int B cos(omega t) d omega, shape (time, dof, dof) [kg/s^2].

        Eight Gauss points per interval are exact to round-off up to t = 10/(frequency step). The tail integral is a
        generalized exponential integral, int_W^inf cos(wt) w^-3 dw = Re E_3(iWt)/W^2.
        """
        nodes, weights, shares = self._quadrature
        top = self.omega[-1]
        rows = np.cos(np.outer(time, nodes)) @ (weights[:, None] * shares)
        rows[:, -1] += np.real(_e3(1j * top * time)) * top
        return np.asarray(2 / np.pi * np.tensordot(rows, self.damping, 1))

    def added_mass_shares(self, omega: FloatArray) -> FloatArray:
        """Return the weights of the solved damping in A(omega) - A(infinity) by Kramers-Kronig, (omega, solved) [s].

        -(2/pi) PV int B(v)/(omega^2 - v^2) dv, with the singularity taken out: PV int dv/(omega^2 - v^2) = 0.
        """
        nodes, weights, shares = self._quadrature
        top = self.omega[-1]
        u = 0.5 * (_TAIL_NODE + 1)  # v = top/u beyond the band
        beyond, beyond_weight = top / u, 0.5 * _TAIL_WEIGHT * top / u**2
        within = weights / (omega[:, None] ** 2 - nodes**2)
        above = beyond_weight / (omega[:, None] ** 2 - beyond**2)
        rows = within @ shares - (within.sum(axis=1) + above.sum(axis=1))[:, None] * self.shares(omega)
        rows[:, -1] += above @ u**3
        return np.asarray(-2 / np.pi * rows)

    def added_mass_difference(self, omega: FloatArray) -> FloatArray:
        """Return A(omega) - A(infinity) by Kramers-Kronig, shape (omega, dof, dof) [kg]."""
        return np.asarray(np.tensordot(self.added_mass_shares(omega), self.damping, 1))

    def at(self, omega: FloatArray) -> FloatArray:
        """Return the damping at any frequency, shape (omega, dof, dof) [kg/s]."""
        return np.asarray(np.tensordot(self.shares(omega), self.damping, 1))

    def transfer(self, omega: FloatArray) -> ComplexArray:
        """Return K(s = i omega) = B + i omega (A - A(infinity)), shape (omega, dof, dof) [kg/s]."""
        rows = self.shares(omega) + 1j * omega[:, None] * self.added_mass_shares(omega)
        return np.asarray(np.tensordot(rows, self.damping, 1))


def _e3(z: ComplexArray) -> ComplexArray:
    """Generalized exponential integral E_3 by recurrence from E_1; E_3(0) = 1/2."""
    z = np.asarray(z, dtype=complex)
    safe = np.where(z == 0, 1.0, z)
    e2 = np.exp(-safe) - safe * exp1(safe)
    return np.where(z == 0, 0.5, (np.exp(-safe) - safe * e2) / 2)
