"""The waves' part of Green's function, integrated over the azimuth of rings of strength cos(m theta).

In deep water, with K = omega^2/g and Z = z + z', it is

    2K PV int_0^inf e^{kZ} J0(k rho)/(k - K) dk + 2 pi i K e^{KZ} J0(K rho),

and int_0^{2 pi} J0(k rho) cos(m theta) d theta = 2 pi J_m(kR) J_m(kR').

A level bottom at depth d adds, with alpha = (k + K)/(k - K), the reflection of the water's surface, the image in the
bottom, 1/r'' at -2d - z', and the images of image and source in both,

    int_0^inf alpha/(1 - alpha e^{-2kd}) [alpha e^{-2kd} uu' + e^{-kd} (uv' + vu') + e^{-2kd} vv'] J0(k rho) dk,
    u = e^{kz}, v = e^{-k(z+d)}:

John's function less the deep-water one and 1/r'', free of cancellation, and smooth however near the bottom: the
integrand falls like e^{-k(2d - draft)}. Outgoing waves (phasors exp(-i omega t)) need the path below the poles, K and
k0 tanh k0 d = K, whether apart or nearly equal. It leaves zero at 45 degrees, between them and the evanescent poles
-i k_n, and continues at a fixed distance from the real axis, the same for all frequencies. So are the exponentials and
Bessel functions along it; alpha = -1 and 1 are the limits of infinite and zero frequency.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import jv

from vsb.engine.hydro.dofs import bessel
from vsb.engine.hydro.spectral.meridian import Piece, WetMeridian, unit_rule
from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray

_CUTOFF = 6.0
"""Cutoff between quadrature and Laplace transform of the waves' part, in largest wavenumbers or inverse radii."""
_NEGLIGIBLE = 23.0
"""Exponent of the part left out of the transform, 1e-10; more would amplify the round-off of its small integrand."""


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
        found = np.empty((len(self.lengths[0]), 2, *apart.shape))
        for each, s in zip(found, self.lengths[0], strict=True):
            each[:] = p.influence(self.meridian.order, apart, height - s, 1.0)
            each -= (at * (2 * np.pi * w * np.exp(-k * s))) @ source
        return found

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


_NEAREST = 0.01
"""Least clearance under the keel that was tested, in drafts. It needs half again the nodes of deep water."""
_NEGLIGIBLE_ON_PATH = 31.0
"""Exponent of the part left out by the path, 3e-14, and of the error of the image's rule."""
_ELEMENT = 10
"""Points of the image's rule for the element of area, by measurement: with it the rule is exact to 1e-11."""
_GROWTH = 4.0
"""Ratio of the ends of a panel of the path near zero."""
_LEVEL = 1.0
"""Distance of the path from the real axis, in terms of the inverse of the largest radius: J_m^2 grows to e^2."""


def wave_profile(k: FloatArray, depth: float, z: FloatArray) -> FloatArray:
    """Return cosh k(z+d)/cosh kd of waves in a depth that may be infinite, shape (k, point) [-]; never overflows."""
    down = np.outer(k, z)
    floor = np.exp(-2 * k * depth)[:, None]
    return np.asarray((np.exp(down) + np.exp(-down - 2 * k[:, None] * depth)) / (1 + floor))


def _panels(edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of 16 Gauss points between each two edges."""
    node, weight = unit_rule(16)
    length = np.diff(edges)[:, None]
    return (edges[:-1, None] + length * node).ravel(), (length * weight).ravel()


@dataclass(frozen=True)
class FiniteDepthWavePart:
    """The bottom's part of Green's function between the equations' points and the nodes, from a least wavenumber on.

    It adds to 1/r + 1/r' and `WavePart`, of the meridian's azimuthal order. Wavenumbers are those of deep
    water, omega^2/g. `ConfigError` if the shell touches the bottom or nearly does.
    """

    meridian: WetMeridian
    depth: float  # [m]
    smallest: float  # [1/m]

    def __post_init__(self) -> None:
        """Check the clearance under the keel."""
        least = (1 + _NEAREST) * self.draft
        if self.depth < least * (1 - 1e-12):  # the draft is known to round-off
            raise ConfigError(
                f"water.depth: received {self.depth:g} m under a shell of {self.draft:.6g} m draft; needs at least "
                f"{least:.6g} m: deepen the water or lighten the buoy"
            )

    @cached_property
    def draft(self) -> float:
        """Depth of the lowest point that is known [m]."""
        return -float(min(self.meridian.at(np.ones(1)).z[0], self.meridian.points.z.min()))

    @cached_property
    def path(self) -> tuple[ComplexArray, ComplexArray]:
        """Wavenumbers along the path and their weights, each shape (wavenumber,) [1/m]; ever finer to zero."""
        end = _NEGLIGIBLE_ON_PATH / (2 * self.depth - self.draft)
        level = min(end, _LEVEL / float(self.meridian.points.x.max()))
        scales = level * max(1 / self.smallest, self.depth)
        count = np.ceil(np.log(max(scales, 1.0)) / np.log(_GROWTH))
        ray, ray_weight = _panels(np.append(0.0, level * _GROWTH ** np.arange(-count, 1)))
        along, weight = _panels(np.linspace(level, end, int(np.ceil((end - level) / (2 * level))) + 1))
        slant = 1 - 1j
        return np.concatenate([slant * ray, along - 1j * level]), np.concatenate([slant * ray_weight, weight])

    @cached_property
    def factors(self) -> tuple[ComplexArray, ComplexArray]:
        """J_m times u, v at targets, (2, target, wavenumber), and nodes, with derivative, (2, 2, wavenumber, node)."""
        (x, z), p, (k, _), m = self.meridian.targets, self.meridian.points, self.path, self.meridian.order
        decay = np.exp(np.stack([np.outer(z, k), -np.outer(z + self.depth, k)]))
        at = decay * jv(m, np.outer(x, k))
        on, decay = at[:, : len(p.x)], decay[:, : len(p.x)]
        radial = m / p.x[:, None] * on - k * decay * jv(m + 1, np.outer(p.x, k))
        vertical = np.array([1.0, -1.0])[:, None, None] * k * on
        source = np.stack([on, p.n_x[:, None] * radial + p.n_z[:, None] * vertical], axis=1)
        return at, source.swapaxes(2, 3).copy()

    @cached_property
    def image(self) -> FloatArray:
        """Influence of 1/r'', shape (2 potential and derivative, target, node) [1/m, 1/m^2].

        Under the keel a ring is near its image: the nodes' polynomials are integrated on as many points as that takes.
        """
        found = []
        for piece in self.meridian.pieces:
            t, weight = piece._replace(nodes=self._image_points(piece)).rule
            p, (x, z) = self.meridian.at(t), self.meridian.targets
            apart, height = x[:, None] - p.x, z[:, None] + p.z + 2 * self.depth
            values = p.influence(self.meridian.order, apart, height, 1.0) * weight * p.rate
            found.append(values @ self.meridian.interpolation(t))
        return np.asarray(sum(found) / self.meridian.areas)

    def _image_points(self, piece: Piece) -> int:
        """Number of Gauss points for the image: a target's kernel is singular about t +- 2i (z + d)/(ds/dt)."""
        t, p = self.meridian.rule[0], self.meridian.points
        pole = t + 2j * (p.z + self.depth) * p.x / p.rate
        pole = 2 * (pole - piece.start) / (piece.end - piece.start) - 1
        ellipse = np.log(np.abs(pole + np.sqrt(pole - 1) * np.sqrt(pole + 1)).min())  # Bernstein's, through the pole
        return _ELEMENT + int(np.ceil((piece.nodes + _NEGLIGIBLE_ON_PATH / ellipse) / 2))

    def _reflected(self, alpha: ComplexArray | float) -> ComplexArray:
        """Influence with a surface that reflects by alpha along the path."""
        (k, weight), ((u, v), source) = self.path, self.factors
        down = np.exp(-k * self.depth)
        between = 2 * np.pi * weight * down * alpha / (1 - alpha * down**2)
        up_going, down_going = between * (alpha * down * u + v), between * (u + down * v)
        return np.asarray(self.image + up_going @ source[0] + down_going @ source[1])

    def influences(self, k: FloatArray) -> Iterator[ComplexArray]:
        """Yield potential and derivative at wavenumbers from the smallest on, each (2, target, node) [1/m, 1/m^2]."""
        path = self.path[0]
        for each in k:
            yield self._reflected((path + each) / (path - each))

    def at_infinity(self) -> FloatArray:
        """Return the addition to 1/r - 1/r' at infinite frequency, shape (2, target, node) [1/m, 1/m^2]."""
        return self._reflected(-1.0).real

    def at_zero(self) -> FloatArray:
        """Return the addition to 1/r + 1/r' at frequency zero, shape (2, target, node) [1/m, 1/m^2].

        Order 0 has no limit (`ConfigError`): a flux V through the shell leaves through a layer of water of thickness d,
        and its added mass rho V^2/(4 pi d) log(1/K) grows without bounds.
        """
        if self.meridian.order == 0:
            raise ConfigError(
                f"water.depth: received {self.depth:g} m at frequency zero, where axisymmetric added mass grows like "
                "-log omega; needs infinite depth or a positive frequency"
            )
        return self._reflected(1.0).real
