"""What a level bottom adds to Green's function of deep water, integrated over the azimuth of rings of sources.

With K = omega^2/g, depth d and alpha = (k + K)/(k - K), the reflection of the water's surface, it is the image in the
bottom, 1/r'' at -2d - z', and the images of image and source in both,

    int_0^inf alpha/(1 - alpha e^{-2kd}) [alpha e^{-2kd} uu' + e^{-kd} (uv' + vu') + e^{-2kd} vv'] J0(k rho) dk,
    u = e^{kz}, v = e^{-k(z+d)}:

John's function less the deep-water one and 1/r'', free of cancellation, and smooth however near the bottom: the
integrand falls like e^{-k(2d - draft)}. Outgoing waves (phasors exp(-i omega t)) want the path below the poles, K and
k0 tanh k0 d = K, whether apart or all but one. It leaves zero at 45 degrees, between them and the evanescent poles
-i k_n, and runs on at a fixed distance from the real axis, the same for all frequencies. So are the exponentials and
Bessel functions along it; alpha = -1 and 1 are the limits of infinite and zero frequency.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import jv

from vsb.errors import ConfigError
from vsb.hydro.spectral.meridian import WetMeridian, unit_rule
from vsb.tools.arrays import ComplexArray, FloatArray

_NEAREST = 0.01
"""Least clearance under the keel, in drafts: as near as was measured. It takes half again the nodes of deep water."""
_NEGLIGIBLE = 31.0
"""Exponent of what the path leaves out, 3e-14, and of the error of the image's rule."""
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

    It adds to 1/r + 1/r' and `deepwater.WavePart`, of the meridian's azimuthal order. Wavenumbers are those of deep
    water, omega^2/g. `ConfigError` if the shell touches the bottom or nearly does.
    """

    meridian: WetMeridian
    depth: float  # [m]
    smallest: float  # [1/m]

    def __post_init__(self) -> None:
        """Refuse what is too near the keel."""
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
        end = _NEGLIGIBLE / (2 * self.depth - self.draft)
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
        t, weight = unit_rule(self.image_points)
        p, (x, z) = self.meridian.at(t), self.meridian.targets
        apart, height = x[:, None] - p.x, z[:, None] + p.z + 2 * self.depth
        values = p.influence(self.meridian.order, apart, height, 1.0) * weight * p.rate
        return np.asarray(values @ self.meridian.interpolation(t) / self.meridian.areas)

    @property
    def image_points(self) -> int:
        """Number of Gauss points for the image: a target's kernel is singular about t +- 2i (z + d)/(ds/dt)."""
        t, p = unit_rule(self.meridian.nodes)[0], self.meridian.points
        pole = 2 * (t + 2j * (p.z + self.depth) * p.x / p.rate) - 1
        ellipse = np.log(np.abs(pole + np.sqrt(pole - 1) * np.sqrt(pole + 1)).min())  # Bernstein's, through the pole
        return _ELEMENT + int(np.ceil((self.meridian.nodes + _NEGLIGIBLE / ellipse) / 2))

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
        """Return what adds to 1/r - 1/r' at infinite frequency, shape (2, target, node) [1/m, 1/m^2]."""
        return self._reflected(-1.0).real

    def at_zero(self) -> FloatArray:
        """Return what adds to 1/r + 1/r' at frequency zero, shape (2, target, node) [1/m, 1/m^2].

        Of order 0 there is no limit (`ConfigError`): a flux V through the shell has to leave through a layer of water
        of thickness d, and its added mass rho V^2/(4 pi d) log(1/K) grows without bounds.
        """
        if self.meridian.order == 0:
            raise ConfigError(
                f"water.depth: received {self.depth:g} m at frequency zero, where axisymmetric added mass grows like "
                "-log omega; needs infinite depth or a positive frequency"
            )
        return self._reflected(1.0).real
