"""The waves' part of Green's function of deep water, integrated over the azimuth of rings of strength cos(m theta).

With K = omega^2/g and Z = z + z' it is

    2K PV int_0^inf e^{kZ} J0(k rho)/(k - K) dk + 2 pi i K e^{KZ} J0(K rho),

and int_0^{2 pi} J0(k rho) cos(m theta) d theta = 2 pi J_m(kR) J_m(kR').
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vsb.hydro.azimuthal import bessel
from vsb.hydro.spectral.meridian import WetMeridian, unit_rule
from vsb.tools.arrays import ComplexArray, FloatArray

_CUTOFF = 6.0
"""Where the waves' part turns from a quadrature into a Laplace transform, in largest wavenumbers, or inverse radii."""
_NEGLIGIBLE = 23.0
"""Exponent of what is left out of the transform, 1e-10; more would amplify the round-off of its small integrand."""


def second_kind(count: int, x: FloatArray) -> FloatArray:
    """Return Legendre's Q_n on the cut at 2x - 1 for 0 < x < 1 and n < count, shape (count, point) [-]."""
    argument = 2 * x - 1
    q = np.empty((count, len(x)))
    q[0] = 0.5 * np.log(x / (1 - x))
    q[1] = argument * q[0] - 1
    for n in range(1, count - 1):
        q[n + 1] = ((2 * n + 1) * argument * q[n] - n * q[n - 1]) / (n + 1)
    return q


@dataclass(frozen=True)
class WavePart:
    """The waves' part of Green's function between the equations' points and the nodes, up to a largest wavenumber.

    Below the cutoff kc the integral over k is Gauss' with weights that take the pole exactly (polynomials times
    1/(k - K) are Legendre's Q). Above it, 1/(k - K) = int_0^inf e^{-(k-K)s} ds turns the slowly decaying rest into

        2K int_0^inf e^{Ks} T(Z - s) ds,   T(Z) = int_kc^inf e^{kZ} J_m(kR) J_m(kR') dk = [1/r'] - int_0^kc ... dk

    with T in closed form, independent of frequency, and smaller than e^{-kc s}: tabulated once.
    """

    meridian: WetMeridian
    largest: float  # [1/m]

    @cached_property
    def cutoff(self) -> float:
        """The wavenumber kc [1/m]; no less than the shell's own scale, or the transform would have to resolve it."""
        return _CUTOFF * max(self.largest, 1 / float(self.meridian.points.x.max()))

    @cached_property
    def wavenumbers(self) -> tuple[FloatArray, FloatArray]:
        """Gauss points and weights from 0 to kc, in terms of kc, each shape (wavenumber,) [-]; J_m^2 turns 2 kc R."""
        return unit_rule(int(40 + self.cutoff * self.meridian.points.x.max()))

    @cached_property
    def factors(self) -> tuple[FloatArray, FloatArray]:
        """e^{kz} J_m(kR) of targets, (target, wavenumber); of nodes, with derivative, (2, wavenumber, node)."""
        return self._factors(self.cutoff * self.wavenumbers[0])

    def _factors(self, k: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same at any wavenumbers."""
        (x, z), order = self.meridian.targets, self.meridian.order
        at = np.exp(np.outer(z, k)) * bessel(order, np.outer(x, k))[0]
        return at, self.meridian.points.wave(order, k).swapaxes(1, 2).copy()

    @cached_property
    def lengths(self) -> tuple[FloatArray, FloatArray]:
        """Nodes s of the Laplace transform and their weights, each shape (length,) [m]; ever finer to s = 0."""
        u, w = unit_rule(32)
        end = _NEGLIGIBLE / (self.cutoff - self.largest)
        return end * u**4, end * 4 * u**3 * w

    @cached_property
    def tail(self) -> FloatArray:
        """T and its derivative by the source's normal, summed over the azimuth, shape (length, 2, target, node)."""
        (x, z), p, (at, source) = self.meridian.targets, self.meridian.points, self.factors
        k, w = (self.cutoff * a for a in self.wavenumbers)
        apart, height = x[:, None] - p.x, z[:, None] + p.z
        whole = [p.influence(self.meridian.order, apart, height - s, 1.0) for s in self.lengths[0]]
        below = [(at * (2 * np.pi * w * np.exp(-k * s))) @ source for s in self.lengths[0]]
        return np.asarray(np.array(whole) - np.array(below))

    def pole_weights(self, k: FloatArray) -> FloatArray:
        """Return the weights of PV int_0^kc f(k')/(k' - k) dk' on the Gauss points, shape (k, wavenumber) [-]."""
        node, weight = self.wavenumbers
        degree = np.arange(len(node))
        p = np.polynomial.legendre.legvander(2 * node - 1, degree[-1]) * (2 * degree + 1)
        return np.asarray(-2 * weight * (p @ second_kind(len(node), k / self.cutoff)).T)

    def influences(self, k: FloatArray) -> Iterator[ComplexArray]:
        """Yield potential and derivative at wavenumbers up to the largest, each shape (2, target, node) [1/m, 1/m^2].

        2K (PV int + Laplace transform) + 2 pi i K e^{KZ} J_m J_m.
        """
        (at, source), (s, w), (here, there) = self.factors, self.lengths, self._factors(k)
        for i, pole_weights in enumerate(self.pole_weights(k)):
            real = (at * (2 * np.pi * pole_weights)) @ source + np.tensordot(w * np.exp(k[i] * s), self.tail, 1)
            yield np.asarray(2 * k[i] * (real + 2j * np.pi**2 * here[:, i, None] * there[:, None, i]))
