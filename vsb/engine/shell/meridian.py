"""The closed meridian of a shell at rest: what it may be, its volume, area and curvature.

With phi from 0 at the top to pi at the keel, the radius x is odd and the height z even about both poles; a smooth
meridian is therefore

    x = sum_k a_k sin k phi,    z = sum_k b_k cos k phi,

and sin phi times, or just, a polynomial in cos phi. The sphere is a_1 = b_1 = r, a spheroid a_1 and b_1 alone.

A meridian of circular arcs and straight lines, such as a capsule's, has one tangent where they join and a curvature
that jumps there: its `junctions`. Whatever integrates along a meridian does so between them.
"""

import bisect
import cmath
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from vsb.tools.arrays import AnyArray, FloatArray

SAMPLES = 400
"""Points of the meridian at which it is judged, beside eight for each of its terms."""
MOST_TERMS = 160
"""Terms of a meridian at most."""
SMALL_OF_PROFILES = 1e-7
"""Of the radius: terms of a profile below it are left out, for its spline has terms without end."""
MISFIT = 2e-4
"""Of the radius: a smooth meridian passes through the points of a profile to within this."""
ON_AXIS = 1e-9
"""Of the radius: ends of a profile nearer to the axis than this lie on it."""


@lru_cache(maxsize=64)
def _gauss(count: int) -> tuple[tuple[float, float], ...]:
    """Nodes and weights of Gauss-Legendre quadrature on [0, 1]."""
    nodes, weights = gauss_rule(count)
    return tuple(zip(((1 + nodes) / 2).tolist(), (weights / 2).tolist(), strict=True))


class ClosedMeridian:
    """A closed meridian, clear of the axis between its poles and of itself, by an angle phi; checked when made."""

    def __post_init__(self) -> None:
        """Refuse what bounds no body; numbers with the imaginary part of a complex step are judged without it."""
        if self.stepped:
            return
        if not all(map(math.isfinite, self._numbers)):
            raise ValueError("received NaN or infinite numbers; needs finite ones")
        _, x, z = min(self._samples[1:-1], key=lambda at: at[1])
        if x <= 0 or self.at(0.0)[2] <= 0 or self.at(math.pi)[2] >= 0:
            raise ValueError(
                f"received a meridian that crosses the axis near ({x:.4g}, {z:.4g}) m; needs one clear of it between "
                "its poles"
            )
        if (crossing := _crossing(self._samples)) is not None:
            raise ValueError(
                f"received a meridian that crosses itself near ({crossing[0]:.4g}, {crossing[1]:.4g}) m; needs one "
                "that does not"
            )

    @property
    def _numbers(self) -> tuple[float, ...]:
        """All numbers it is made of."""
        raise NotImplementedError

    @property
    def terms(self) -> int:
        """How many terms of a series turn as often as it does: the points of a quadrature grow with it."""
        raise NotImplementedError

    @property
    def junctions(self) -> tuple[float, ...]:
        """Angles between the poles where its curvature jumps, ascending [rad]; none of a smooth meridian."""
        return ()

    def _with_bend(self, phi: float) -> tuple[float, float, float, float, float, float]:
        """Radius, height, their slopes and second derivatives by phi."""
        raise NotImplementedError

    @property
    def stepped(self) -> bool:
        """Whether its numbers have imaginary parts, for derivatives by a complex step."""
        return any(isinstance(number, complex) for number in self._numbers)

    def at(self, phi: float) -> tuple[float, float, float, float]:
        """Return radius, height and their slopes by phi at an angle [m]."""
        return self._with_bend(phi)[:4]

    @cached_property
    def _bends(self) -> tuple[tuple[float, ...], ...]:
        """`_with_bend` at angles evenly spaced from the top to the keel."""
        count = SAMPLES + 8 * self.terms
        return tuple(self._with_bend(math.pi * i / count) for i in range(count + 1))

    @cached_property
    def _samples(self) -> tuple[tuple[float, float, float], ...]:
        """Angle, radius and height there."""
        count = len(self._bends) - 1
        return tuple((math.pi * i / count, bend[0], bend[1]) for i, bend in enumerate(self._bends))

    @cached_property
    def radius(self) -> float:
        """Largest radius [m]."""
        return self.at(self.widest)[0]

    @cached_property
    def widest(self) -> float:
        """Angle of the largest radius [rad]."""
        phi, step = max(self._samples, key=lambda at: at[1])[0], math.pi / len(self._samples)
        low, high = phi - step, phi + step
        while high - low > 1e-9:  # a flat maximum: of the radius twice as many digits are right
            a, b = low + (high - low) / 3, high - (high - low) / 3
            low, high = (a, high) if self.at(a)[0] < self.at(b)[0] else (low, b)
        return 0.5 * (low + high)

    @property
    def top(self) -> float:
        """Height of the top pole [m]."""
        return self.at(0.0)[1]

    @property
    def keel(self) -> float:
        """Height of the bottom pole [m]."""
        return self.at(math.pi)[1]

    def _integral(self, of: Callable[[float], float], parts: Sequence[tuple[float, float]]) -> float:
        """Integral over parts of the meridian, by as many points as its terms need in each, a multiple of eight."""
        total = 0.0
        for start, end in parts:
            edges = (start, *(phi for phi in self.junctions if start < phi < end), end)
            for a, b in itertools.pairwise(edges):
                rule = _gauss(24 + 8 * math.ceil(self.terms * (b - a) / (4 * math.pi)))
                total += sum((b - a) * w * of(a + (b - a) * u) for u, w in rule)
        return total

    def _below(self, height: float) -> list[tuple[float, float]]:
        """Parts of the meridian below a height."""
        edges = [0.0]
        for (a, _, za), (b, _, zb) in zip(self._samples[:-1], self._samples[1:], strict=True):
            if (za < height) != (zb < height):
                edges.append(self._at_height(height, a, b))
        edges.append(math.pi)
        return [(a, b) for a, b in itertools.pairwise(edges) if self.at(0.5 * (a + b))[1] < height]

    def _at_height(self, height: float, a: float, b: float) -> float:
        """Where the meridian has a height, by Newton's method kept in a bracket."""
        rising, phi = self.at(b)[1] > height, 0.5 * (a + b)
        while a < phi < b:
            _, z, _, dz = self.at(phi)
            a, b = (a, phi) if (z > height) == rising else (phi, b)
            following = phi - (z - height) / dz if dz else a
            if abs(following - phi) <= 1e-15:
                break
            phi = following if a < following < b else 0.5 * (a + b)
        return phi

    def volume_below(self, height: float) -> float:
        """Return the volume below a height, -int 2 pi x (z - height) n_z: pi x^2 dz integrated by parts [m^3]."""

        def ring(phi: float) -> float:
            x, z, dx, _ = self.at(phi)
            return 2 * math.pi * x * (z - height) * dx

        return self._integral(ring, self._below(height))

    def centroid_below(self, height: float) -> float:
        """Return the height of the centroid of what is below a height [m]; pi x^2 z dz integrated by parts, too."""

        def ring(phi: float) -> float:
            x, z, dx, _ = self.at(phi)
            return math.pi * x * (z**2 - height**2) * dx

        return self._integral(ring, self._below(height)) / self.volume_below(height)

    @cached_property
    def volume(self) -> float:
        """Volume of the body [m^3]."""
        return self.volume_below(max(z for _, _, z in self._samples) + self.radius)

    @cached_property
    def area(self) -> float:
        """Area of its surface [m^2]."""

        def ring(phi: float) -> float:
            x, _, dx, dz = self.at(phi)
            return 2 * math.pi * x * math.hypot(dx, dz)

        count = 8  # parts: the slope's root is no polynomial
        return self._integral(ring, [(math.pi * i / count, math.pi * (i + 1) / count) for i in range(count)])

    @cached_property
    def sharpest(self) -> float:
        """Smallest radius of curvature [m]."""
        return 1 / max(max(map(abs, _curvatures(*bend))) for bend in self._bends[1:-1])

    def curvatures(self, phi: float) -> tuple[float, float]:
        """Return the principal curvatures at an angle between the poles, of meridian and parallel [1/m]."""
        return _curvatures(*self._with_bend(phi))

    def radius_at(self, height: float) -> float:
        """Return the largest radius at a height [m]; 0 beyond the body."""
        ends = {phi for part in self._below(height) for phi in part if 0 < phi < math.pi}
        return max((self.at(phi)[0] for phi in ends), default=0.0)

    def draft_of(self, volume: float) -> float:
        """Return the draft at which a volume is below the water [m], by Newton's method kept in a bracket."""
        low, high = self.lowest, self.highest
        height = 0.5 * (low + high)
        for _ in range(200):
            excess = self.volume_below(height) - volume
            low, high = (low, height) if excess > 0 else (height, high)
            plane = sum(math.pi * (self.at(a)[0] ** 2 - self.at(b)[0] ** 2) for a, b in self._below(height))
            following = height - excess / plane if plane > 0 else low
            if not low < following < high:
                following = 0.5 * (low + high)
            if abs(following - height) <= 1e-14 * self.radius:
                break
            height = following
        return height - self.lowest

    @cached_property
    def lowest(self) -> float:
        """Height of its lowest point [m]."""
        return min(z for _, _, z in self._samples)

    @cached_property
    def highest(self) -> float:
        """Height of its highest point [m]."""
        return max(z for _, _, z in self._samples)


@dataclass(frozen=True)
class RestMeridian(ClosedMeridian):
    """A smooth closed meridian by its terms."""

    radial: tuple[float, ...]  # a_1, a_2, ... [m]
    axial: tuple[float, ...]  # b_0, b_1, ... [m]

    @property
    def _numbers(self) -> tuple[float, ...]:
        return (*self.radial, *self.axial)

    @property
    def terms(self) -> int:
        """The number of its terms."""
        return max(len(self.radial), len(self.axial))

    def _with_bend(self, phi: float) -> tuple[float, float, float, float, float, float]:
        """As of every meridian; (e^(i phi))^k in place of k sines and cosines."""
        x, dx, ddx, z, dz, ddz = 0.0, 0.0, 0.0, self.axial[0], 0.0, 0.0
        turn, turned = cmath.rect(1.0, phi), 1.0 + 0.0j
        for k, (a, b) in enumerate(itertools.zip_longest(self.radial, self.axial[1:], fillvalue=0.0), 1):
            turned *= turn
            sin, cos = turned.imag, turned.real
            x, dx, ddx = x + a * sin, dx + k * a * cos, ddx - k * k * a * sin
            z, dz, ddz = z + b * cos, dz - k * b * sin, ddz - k * k * b * cos
        return x, z, dx, dz, ddx, ddz

    @property
    def top(self) -> float:
        """Height of the top pole [m]."""
        return sum(self.axial)

    @property
    def keel(self) -> float:
        """Height of the bottom pole [m]."""
        return sum(-b if k % 2 else b for k, b in enumerate(self.axial))

    def scaled(self, across: float, along: float, up: float = 0.0) -> "RestMeridian":
        """Return it stretched across and along its axis, then moved up [m]."""
        axial = tuple(along * b for b in self.axial)
        return RestMeridian(tuple(across * a for a in self.radial), (axial[0] + up, *axial[1:]))


class ArcStart(NamedTuple):
    """Where an arc begins: its curvature, length from the top, radius, height, angle of the tangent below the level."""

    curvature: float  # [1/m]
    arc: float  # [m]
    x: float  # [m]
    z: float  # [m]
    tangent: float  # [rad]


@dataclass(frozen=True)
class ArcMeridian(ClosedMeridian):
    """Circular arcs and straight lines from the top to the keel, each going on in the tangent of the one before.

    Height zero is the middle between top and keel. phi goes with the length of the arc. On an arc of curvature k from
    (x0, z0) with a tangent psi0 below the level, a length u further,

        x = x0 + u sinc(k u/2) cos(psi0 + k u/2),    z = z0 - u sinc(k u/2) sin(psi0 + k u/2),

    sinc(t) = sin(t)/t, of lines and arcs alike and analytic in lengths and curvatures of a complex step.
    """

    lengths: tuple[float, ...]  # [m]
    arc_curvatures: tuple[float, ...]  # [1/m]; positive towards the axis

    @property
    def _numbers(self) -> tuple[float, ...]:
        return (*self.lengths, *self.arc_curvatures)

    @cached_property
    def length(self) -> float:
        """Length of the arc from the top to the keel [m]."""
        return sum(self.lengths)

    @cached_property
    def terms(self) -> int:
        """How many terms of a series turn as often as its most curved arc."""
        return 3 + math.ceil(max(abs(complex(k * self.length)) for k in self.arc_curvatures) / math.pi)

    @cached_property
    def junctions(self) -> tuple[float, ...]:
        """Angles between the poles where its curvature jumps, ascending [rad]."""
        return tuple(math.pi * start.arc / self.length for start in self.starts[1:])

    @cached_property
    def starts(self) -> tuple[ArcStart, ...]:
        """Where each arc begins."""
        arc, x, z, tangent, found = 0.0, 0.0, 0.0, 0.0, []
        for length, curvature in zip(self.lengths, self.arc_curvatures, strict=True):
            found.append(ArcStart(curvature, arc, x, z, tangent))
            across, down = _arc_chord(curvature, tangent, length)
            arc, x, z, tangent = arc + length, x + across, z - down, tangent + curvature * length
        return tuple(start._replace(z=start.z - z / 2) for start in found)

    def _with_bend(self, phi: float) -> tuple[float, float, float, float, float, float]:
        start = self.starts[bisect.bisect_right([complex(angle).real for angle in self.junctions], phi)]
        rate = self.length / math.pi
        across, down = _arc_chord(start.curvature, start.tangent, rate * phi - start.arc)
        of = cmath if self.stepped else math
        tangent = start.tangent + start.curvature * (rate * phi - start.arc)
        dx, dz, bend = rate * of.cos(tangent), -rate * of.sin(tangent), rate * start.curvature
        return start.x + across, start.z - down, dx, dz, bend * dz, -bend * dx


def _arc_chord(curvature: float, tangent: float, length: float) -> tuple[float, float]:
    """Return how far across and down an arc leads that begins with a tangent at an angle below the level [m]."""
    of = cmath if isinstance(curvature * length + tangent, complex) else math
    half = curvature * length / 2
    chord = length * (of.sin(half) / half if half else 1.0)
    return chord * of.cos(tangent + half), chord * of.sin(tangent + half)


def _curvatures(x: float, _: float, dx: float, dz: float, ddx: float, ddz: float) -> tuple[float, float]:
    """Principal curvatures by radius, height, their slopes and second derivatives [1/m]."""
    slope = math.hypot(dx, dz)
    return (ddx * dz - dx * ddz) / slope**3, -dz / (x * slope)


def _crossing(samples: Sequence[tuple[float, float, float]]) -> tuple[float, float] | None:
    """A point where an open polygon, each point an angle, x and z, crosses itself, if there is one."""
    heights = [z for _, _, z in samples]
    if all(a > b for a, b in itertools.pairwise(heights)):
        return None
    points = [(x, z) for _, x, z in samples[:: max(1, len(samples) // SAMPLES)]]
    sides = list(itertools.pairwise(points))

    def left(p: tuple[float, float], q: tuple[float, float], r: tuple[float, float]) -> bool:
        return (q[0] - p[0]) * (r[1] - p[1]) > (q[1] - p[1]) * (r[0] - p[0])

    for i, (a, b) in enumerate(sides):
        for c, d in sides[i + 2 :]:
            if left(a, b, c) != left(a, b, d) and left(c, d, a) != left(c, d, b):
                return a
    return None


@lru_cache(maxsize=32)
def spheroid(radius: float, height: float) -> RestMeridian:
    """Return a spheroid of an equatorial radius and a height from pole to pole [m]; phi is its eccentric angle."""
    return RestMeridian((radius,), (0.0, height / 2))


@lru_cache(maxsize=32)
def capsule(radius: float, length: float) -> ClosedMeridian:
    """Return a cylinder of a length between two hemispheres [m]; without length the sphere.

    Radius and length may be complex, for derivatives by a complex step.
    """
    if not length:
        return spheroid(radius, 2 * radius)
    cap = math.pi * radius / 2
    return ArcMeridian((cap, length, cap), (1 / radius, 0.0, 1 / radius))


@lru_cache(maxsize=32)
def series(radial: tuple[float, ...], axial: tuple[float, ...], radius: float) -> RestMeridian:
    """Return the meridian x = sum a_k sin k phi, z = sum b_k cos k phi, scaled to a largest radius [m].

    Numbers may be complex, for derivatives by a complex step.

    Parameters
    ----------
    radial, axial : tuple of float
        a_1, a_2, ... and b_1, b_2, ..., in any unit. Height zero becomes the middle between top and keel.
    """
    own, widest = RestMeridian(radial, (0.0, *axial)), None
    if not own.stepped and own.top <= own.keel:
        raise ValueError(f"received a top at height {own.top:.4g} and a keel at {own.keel:.4g}; needs the top above it")
    if own.stepped:
        real = [tuple(complex(term).real for term in terms) for terms in (radial, (0.0, *axial))]
        widest = RestMeridian(*real).widest
    return _of_radius_one(own, widest).scaled(radius, radius)


@lru_cache(maxsize=32)
def through(points: tuple[tuple[float, float], ...], radius: float) -> RestMeridian:
    """Return a smooth meridian through points (x, z) from the top to the keel, scaled to a largest radius [m].

    Raises `ValueError` if the points are fewer than five or no numbers, do not end on the axis, meet it or each other
    before, turn more sharply than a smooth meridian can follow, or bound no body.

    Parameters
    ----------
    points : tuple of (x, z)
        The first and the last on the axis; in any unit. Height zero becomes the middle between top and keel.
    radius : float [m]

    Notes
    -----
    Cubic splines over the length of the chords, x without curvature and z without slope at the poles, as mirrored they
    go on; then their trigonometric series, to `MISFIT` radii. The angle phi goes with the length of the chords.
    """
    return _through(points).scaled(radius, radius)


@lru_cache(maxsize=32)
def _through(points: tuple[tuple[float, float], ...]) -> RestMeridian:
    """The same of radius one, which serves all sizes."""
    from scipy.interpolate import CubicSpline  # slow to import

    _check_points(points)
    largest, at = max(x for x, _ in points), _chords(points)
    (x, z), angles = np.array(points).T, _midpoints(8 * MOST_TERMS)
    across, along = CubicSpline(at, x, bc_type="natural")(angles), CubicSpline(at, z, bc_type="clamped")(angles)
    found = _of_series(across.tolist(), along.tolist(), largest)
    for phi, (px, pz) in zip(at, points, strict=True):
        there = found.at(phi)
        if math.hypot(there[0] - px, there[1] - pz) > MISFIT * largest:
            raise ValueError(
                f"received points that turn too sharply for a smooth meridian near ({px:.4g}, {pz:.4g}); needs "
                "fewer turns"
            )
    return _of_radius_one(found)


def _chords(points: Sequence[tuple[float, float]]) -> list[float]:
    """Angles phi of points, in proportion to the length of the chords."""
    at = [0.0]
    for (x, z), (following, lower) in itertools.pairwise(points):
        at.append(at[-1] + math.hypot(following - x, lower - z))
    return [math.pi * t / at[-1] for t in at]


def _midpoints(count: int) -> list[float]:
    """Angles in the middle of equal parts of the meridian."""
    return [math.pi * (i + 0.5) / count for i in range(count)]


def _of_series(x: Sequence[float], z: Sequence[float], largest: float) -> RestMeridian:
    """The meridian of radii and heights at `_midpoints`, without small terms of the highest orders."""
    count, k = len(z), np.arange(1, MOST_TERMS + 1)
    at = np.outer(k, np.pi * (np.arange(count) + 0.5) / count)
    cosines, sines = 2 / count * np.cos(at) @ z, 2 / count * np.sin(at) @ x
    size, small = np.maximum(abs(cosines), abs(sines)), SMALL_OF_PROFILES * largest
    kept = next((n for n in range(9, MOST_TERMS) if size[n - 4 : n].max() < small), MOST_TERMS)
    return RestMeridian(tuple(sines[:kept].tolist()), (sum(z) / len(z), *cosines[:kept].tolist()))


def _of_radius_one(meridian: RestMeridian, widest: float | None = None) -> RestMeridian:
    """A meridian scaled to a largest radius of one, the middle of its height at zero; widest at an angle, if known."""
    scale = 1 / (meridian.radius if widest is None else meridian.at(widest)[0])
    return meridian.scaled(scale, scale, -scale * (meridian.top + meridian.keel) / 2)


@lru_cache(maxsize=32)
def also_through(points: tuple[tuple[float, float], ...], radius: float) -> RestMeridian:
    """Return another meridian through the points of `through`, whose distance from it says what points leave open.

    Akima's curve in place of the spline, with slopes of the neighbouring chords alone (SciPy's modified Akima
    interpolation), points mirrored in the axis at the poles.
    """
    from scipy.interpolate import Akima1DInterpolator

    at, (x, z) = np.array(_chords(points)), np.array(points).T
    mirrored = np.concatenate([-at[:0:-1], at, 2 * math.pi - at[-2::-1]])
    x, z = np.concatenate([-x[:0:-1], x, -x[-2::-1]]), np.concatenate([z[:0:-1], z, z[-2::-1]])
    x, z = (Akima1DInterpolator(mirrored, one, method="makima")(_midpoints(8 * MOST_TERMS)) for one in (x, z))
    return _of_radius_one(_of_series(x.tolist(), z.tolist(), float(x.max()))).scaled(radius, radius)


def _check_points(points: Sequence[tuple[float, float]]) -> None:
    """Raise `ValueError` if points are none of a closed meridian."""
    if len(points) < 5:
        raise ValueError(f"received {len(points)} points; needs at least five, from the top to the keel")
    if not all(math.isfinite(value) for point in points for value in point):
        raise ValueError("received points that are no finite numbers; needs finite ones")
    largest = max(x for x, _ in points)
    for name, (x, z) in (("first", points[0]), ("last", points[-1])):
        if not abs(x) <= ON_AXIS * largest:
            raise ValueError(
                f"received the {name} point at ({x:.4g}, {z:.4g}), so the meridian is not closed; needs one on the "
                "axis, x = 0"
            )
    if points[0][1] <= points[-1][1]:
        raise ValueError(
            f"received a first point at height {points[0][1]:.4g} and a last one at {points[-1][1]:.4g}; needs the "
            "top first"
        )
    if (inside := min(x for x, _ in points[1:-1])) <= 0:
        raise ValueError(f"received a point at radius {inside:.4g} between the poles; needs radii above 0 there")
    if any(a == b for a, b in itertools.pairwise(points)):
        raise ValueError("received the same point twice in a row; needs each once")


class Curve(NamedTuple):
    """Radius and height of a meridian at some angles phi, and their derivatives by phi, each shape (point,) [m]."""

    x: FloatArray
    z: FloatArray
    dx: FloatArray
    dz: FloatArray


def curve(meridian: ClosedMeridian, phi: FloatArray) -> Curve:
    """Return a meridian at angles, shape (point,) [rad]; analytic in its numbers and in angles of a complex step."""
    if isinstance(meridian, ArcMeridian):
        return _on_arcs(meridian, phi)[0]
    assert isinstance(meridian, RestMeridian)
    (a, j), (b, k) = _numbered(meridian)
    if np.iscomplexobj(phi):
        (sin_j, cos_j), (sin_k, cos_k) = ((np.sin(np.outer(n, phi)), np.cos(np.outer(n, phi))) for n in (j, k))
        return Curve(a @ sin_j, b @ cos_k, (j * a) @ cos_j, -(k * b) @ sin_k)
    (_, x), (dx, _) = _sums(np.concatenate([np.zeros((2, 1)), np.array([a, j * a])], axis=1), phi).swapaxes(0, 1)
    (z, _), (_, fall) = _sums(np.array([b, k * b]), phi).swapaxes(0, 1)
    return Curve(x, z, dx, -fall)


def _on_arcs(meridian: ArcMeridian, phi: FloatArray) -> tuple[Curve, tuple[FloatArray, FloatArray]]:
    """A meridian of arcs at angles, and its second derivatives."""
    which = np.searchsorted(np.real(meridian.junctions), np.real(phi), side="right")
    curvature, arc, x, z, tangent = np.array(meridian.starts)[which].T
    rate = meridian.length / np.pi
    along = rate * phi - arc
    across, down = arc_chord(curvature, tangent, along)
    dx, dz, bent = (
        rate * np.cos(tangent + curvature * along),
        -rate * np.sin(tangent + curvature * along),
        rate * curvature,
    )
    return Curve(x + across, z - down, dx, dz), (bent * dz, -bent * dx)


def arc_chord(curvature: FloatArray, tangent: FloatArray, arc: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far across and down arcs lead, of `vsb.engine.shell.meridian.ArcMeridian`, each shape (point,) [m]."""
    half = curvature * arc / 2
    straight = half == 0.0
    chord = arc * np.where(straight, 1.0, np.sin(half) / np.where(straight, 1.0, half))
    return chord * np.cos(tangent + half), chord * np.sin(tangent + half)


def _sums(coefficients: AnyArray, phi: FloatArray) -> AnyArray:
    """Sums c_k cos(k phi) and c_k sin(k phi) over k = 0, 1, ... of several series, shape (2, series, point).

    With k = m w + r sum c_k exp(i k phi) is sum_m exp(i m w phi) sum_r c_mr exp(i r phi): two short tables of
    exponentials and a product of matrices in place of one exponential for each term and point; long capsules have
    hundreds of terms.
    """
    if np.iscomplexobj(coefficients):
        return np.asarray(_sums(coefficients.real, phi) + 1j * _sums(coefficients.imag, phi))
    series, terms = coefficients.shape
    width = math.isqrt(terms - 1) + 1
    rows = -(-terms // width)
    padded = np.zeros((series, rows * width))
    padded[:, :terms] = coefficients
    near, far = (np.exp(1j * np.outer(step * np.arange(count), phi)) for step, count in ((1, width), (width, rows)))
    inner = (padded.reshape(series * rows, width) @ near).reshape(series, rows, len(phi))
    found = (inner * far).sum(axis=1)
    return np.stack([found.real, found.imag])


def length(dx: FloatArray, dz: FloatArray) -> FloatArray:
    """Return the root of dx^2 + dz^2, analytic in a complex step of them."""
    return np.sqrt(dx**2 + dz**2) if np.iscomplexobj(dx) or np.iscomplexobj(dz) else np.hypot(dx, dz)


def bend(meridian: ClosedMeridian, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the second derivatives of radius and height by the angle, each shape (point,) [m]."""
    if isinstance(meridian, ArcMeridian):
        return _on_arcs(meridian, phi)[1]
    assert isinstance(meridian, RestMeridian)
    (a, j), (b, k) = _numbered(meridian)
    return -(j**2 * a) @ np.sin(np.outer(j, phi)), -(k**2 * b) @ np.cos(np.outer(k, phi))


def _numbered(meridian: RestMeridian) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Terms of radius and height, each with its number."""
    a, b = np.array(meridian.radial), np.array(meridian.axial)
    return (a, np.arange(1.0, len(a) + 1)), (b, np.arange(float(len(b))))


@cache
def gauss_rule(points: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights of Gauss-Legendre quadrature on [-1, 1], each shape (points,), not to be written to."""
    rule = np.polynomial.legendre.leggauss(points)
    for values in rule:
        values.setflags(write=False)
    return rule


FEWEST_ON_PART = 16
"""Points of a quadrature on each part of a meridian with junctions, beside its share of them."""


def parts(junctions: Sequence[float], start: float, end: float) -> list[tuple[float, float]]:
    """Return the parts of a meridian between two angles that its junctions leave [rad]."""
    inside = [phi for phi in junctions if np.real(start) < np.real(phi) < np.real(end)]
    return list(itertools.pairwise((start, *inside, end)))


def meridian_rule(junctions: Sequence[float], points: int) -> tuple[FloatArray, FloatArray]:
    """Return angles and weights of dphi of a Gauss-Legendre rule in cos(phi) from pole to pole, each (point,) [rad].

    On a meridian with junctions `points` are shared among the parts between them, `FEWEST_ON_PART` more on each.
    """
    if not junctions:
        cos, weight = gauss_rule(points)
        return np.arccos(cos), weight / np.sin(np.arccos(cos))
    found = []
    for a, b in parts(junctions, 0.0, math.pi):
        node, weight = gauss_rule(FEWEST_ON_PART + math.ceil(points * np.real(b - a) / math.pi))
        top, bottom = np.cos(a), np.cos(b)
        phi = np.arccos((top + bottom) / 2 + (top - bottom) / 2 * node)
        found.append((phi, (top - bottom) / 2 * weight / np.sin(phi)))
    phis, weights = zip(*found, strict=True)
    return np.concatenate(phis), np.concatenate(weights)
