"""The wet meridian of a shell: points of an integral equation of spectral order and the influence of 1/r on them.

No panels: potentials are polynomials in a parameter of the meridian that crowds its points to the waterline, where
they have weak singularities. They go with cos(m theta) around the body.

The influence of 1/r is that of rings of sources, integrated over the azimuth. With r1, r2 the largest and least
distances between point and ring, r^2 = s^2 (1 + q^2 - 2 q cos theta) with s = (r1 + r2)/2 and
q = (r1 - r2)/(r1 + r2), so the integrals are Laplace's coefficients of celestial mechanics. Near the ring a recurrence
in m from elliptic integrals is stable, far from it their series in q converges.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1, hyp2f1, poch, roots_legendre

from vsb.engine.hydro.dofs import bessel
from vsb.engine.shell.deformed import DeformedShell
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

_FAR = 0.75
"""Ratio q below which the series is summed; the recurrence loses a factor q^(-2m) there."""


def ring(
    order: int, source: FloatArray, apart: FloatArray, height: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return p = int_0^{2 pi} cos(m theta)/r d theta and, as c and d, its gradient c e_R + d (apart, -height).

    Parameters
    ----------
    order : int
        Azimuthal order m.
    source : ndarray [m]
        Radius R' of the ring.
    apart, height : ndarray [m]
        By how much the point's radius exceeds it, and the point's height above the ring.

    Returns
    -------
    p, c, d : ndarray [1/m, 1/m^2, 1/m^3]
        The gradient is by the position of the source. At the ring p grows like log r2, d like 1/r2^2.

    Notes
    -----
    d = int cos(m theta)/r^3 d theta and c = (r2^2 d - p)/(2 R'); for m = 0 p = 4 K/r1 and d = 4 E/(r1 r2^2) with
    1 - m = (r2/r1)^2. The distance itself is the argument: no coordinates are subtracted near the singularity.
    """
    near = np.maximum(apart**2 + height**2, 1e-300)
    product = 4 * source * (source + apart)
    far = near + product
    root = np.sqrt(far)
    p: FloatArray = 4 * ellipkm1(near / far) / root
    e: FloatArray = 4 * ellipe(1 - near / far) / root
    if order:
        p, e = _of_order(order, p, e, near, product)
    return p, (e - p) / (2 * source), e / near


def _of_order(
    order: int, p: FloatArray, e: FloatArray, near: FloatArray, product: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values p and e = r2^2 d of an order >= 1 from those of order 0, r2^2 and 4 R R'."""
    far = near + product
    total = np.sqrt(far) + np.sqrt(near)
    q = product / total**2
    series = q < _FAR
    of_p, of_e = np.empty_like(q), np.empty_like(q)
    of_p[series], of_e[series] = _by_series(order, q[series], total[series])
    close = ~series
    of_p[close], of_e[close] = _by_recurrence(order, p[close], e[close], near[close], product[close])
    return of_p, of_e


def _by_recurrence(
    order: int, p: FloatArray, e: FloatArray, near: FloatArray, product: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Order 0 to m, in the differences 2 R R' (p_n - p_{n+1}), which do not grow at the ring (DLMF 14.10.3)."""
    far = near + product
    step = far * e - near * p
    for n in range(1, order + 1):
        p = p - 2 * step / product
        step = ((n - 0.5) * step - 2 * n * near * p) / (n + 0.5)
    return p, (2 * order + 1) * (step + near * p) / far


def _by_series(order: int, q: FloatArray, total: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Laplace's coefficients, b_{1/2} and (1 - q)^2 b_{3/2}, for q well below 1; `total` is r1 + r2."""
    scale = 4 * np.pi * poch(0.5, order) / poch(1, order) * q**order / total
    p = scale * hyp2f1(0.5, order + 0.5, order + 1, q**2)
    return p, scale * (2 * order + 1) * hyp2f1(-0.5, order - 0.5, order + 1, q**2) / (1 + q) ** 2


_CROWDING = 3
"""Power of t the distance r from the waterline grows with: r log r becomes t^3 log t. Whole, for a smooth shell."""
_KEEL_SLOPE = 1.5
"""Rate of the colatitude at the keel, in terms of equal spacing."""
_INTERIOR = (0.02, 0.15, 0.4)
"""Depths of the points inside, in drafts: near the surface every eigenfunction is at its largest."""
_LONGEST_IN_NODES = 12
"""Longest interval of the rules for the singular integrals, of 16 points, in mean distances of nodes."""
_CIRCLES = (0.2, 0.45)
"""Radii of the circles of points inside for orders >= 1, in distances from the axis to the shell [-]."""


@cache
def unit_rule(points: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on [0, 1], each shape (points,)."""
    node, weight = roots_legendre(points)
    return (node + 1) / 2, weight / 2


@cache
def log_rule() -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights on [0, 1], each shape (24,), of a rule for f + g log u with smooth f and g.

    Nodes u = v^2 of Gauss' rule in v; its weights are moved as little as makes u^p and u^p log u exact for p < 10.
    """

    def moments(u: FloatArray) -> FloatArray:
        p = np.polynomial.legendre.legvander(2 * u - 1, 9).T
        return np.concatenate([p, p * np.log(u)])

    (v, w), (fine_v, fine_w) = unit_rule(24), unit_rule(200)
    weight, rows = 2 * v * w, moments(v**2)
    exact = moments(fine_v**6) @ (6 * fine_v**5 * fine_w)
    return v**2, weight + np.linalg.lstsq(rows, exact - rows @ weight, rcond=1e-13)[0]


_ROWS = 16
"""Nodes whose singular integrals are taken at once."""
_KEPT = 64
"""Nodes up to which their rules are kept for further shapes: 10 MB at most."""


class Points(NamedTuple):
    """Points of the wet meridian, each shape (point,)."""

    x: FloatArray  # radius [m]
    z: FloatArray  # height [m]
    n_x: FloatArray  # unit normal out of the body
    n_z: FloatArray
    rate: FloatArray  # x ds/dt, area per radian of azimuth and unit of t [m^2]
    colatitude: FloatArray  # on the undeformed sphere [rad]

    def influence(self, order: int, apart: FloatArray, height: FloatArray, sign: float) -> FloatArray:
        """Return potential and normal derivative of rings here (sign -1) or their images (1), shape (2, ..., point).

        `apart` and `height` lead from the (mirrored) rings to the points of influence.
        """
        potential, along, across = ring(order, self.x, apart, height)
        return np.stack([potential, self.n_x * along + across * (self.n_x * apart - sign * self.n_z * height)])

    def wave(self, order: int, k: FloatArray) -> FloatArray:
        """Return e^{kz} J_m(kx) and its normal derivative, shape (2, point, wavenumber)."""
        value, lower = bessel(order, np.outer(self.x, k))
        n_x, n_z, bend = self.n_x[:, None], self.n_z[:, None], (order * self.n_x / self.x)[:, None]
        return np.exp(np.outer(self.z, k)) * np.stack([value, (k * n_z - bend) * value + k * n_x * lower])


def _rule_about(t: float, longest: float, breaks: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Distances from t and weights of a rule on [0, 1] for a logarithm at t and its mirror images beyond both ends.

    Intervals double from t on, up to a longest one within which the integrated polynomials turn little; `breaks`, where
    these change, part them.
    """
    offsets, weights = [], []
    nearest = min(t, 1 - t, *(abs(t - each) for each in breaks))
    for sign, end in ((-1, t), (1, 1 - t)):
        doubling = 2.0 ** np.arange(np.ceil(np.log2(2 * end / nearest + 1)) + 1) - 1
        edges = doubling * end / doubling[-1]
        inside = [sign * (each - t) for each in breaks if 0 < sign * (each - t) < end]
        edges = np.unique(np.append(edges, inside))
        parts = [np.linspace(a, b, int(np.ceil((b - a) / longest)) + 1)[:-1] for a, b in itertools.pairwise(edges)]
        for a, b in itertools.pairwise(np.append(np.concatenate(parts), end)):
            u, w = unit_rule(16) if a else log_rule()
            offsets.append(sign * (a + (b - a) * u))
            weights.append((b - a) * w)
    return np.concatenate(offsets), np.concatenate(weights)


_FURTHER = 4
"""Nodes of each piece of a meridian with junctions beside its share."""
_MERGED = 0.02
"""Pieces shorter than this in t are none of their own: near the waterline they measure 1e-5 of the meridian or less."""


class Piece(NamedTuple):
    """A smooth piece of the wet meridian between two values of t, and its number of nodes."""

    start: float
    end: float
    nodes: int

    @property
    def rule(self) -> tuple[FloatArray, FloatArray]:
        """Gauss-Legendre nodes and weights in t, each shape (node,)."""
        t, weight = unit_rule(self.nodes)
        return self.start + (self.end - self.start) * t, (self.end - self.start) * weight


def _interpolation(pieces: Sequence[Piece], t: FloatArray) -> FloatArray:
    """Values at t of the polynomials that are one at one node, shape (point, node); barycentric.

    Each is zero beyond its own piece.
    """
    found, at, last = np.zeros((len(t), sum(piece.nodes for piece in pieces))), 0, pieces[-1]
    for piece in pieces:
        node, weight = unit_rule(piece.nodes)
        here = (t >= piece.start) & ((t < piece.end) | (piece is last))
        scale = (-1.0) ** np.arange(piece.nodes) * np.sqrt(node * (1 - node) * weight)
        terms = (t[here, None] - piece.start) / (piece.end - piece.start) - node
        terms[terms == 0.0] = 1e-300
        np.divide(scale, terms, out=terms)
        terms /= terms.sum(axis=1, keepdims=True)
        found[here, at : at + piece.nodes] = terms
        at += piece.nodes
    return found


class _SingularRule(NamedTuple):
    """Points of the singular integrals about some nodes, one node after the other; of all shapes with such pieces."""

    of_node: IntArray  # (point,)
    offset: FloatArray  # in t (point,)
    weight: FloatArray
    onto: FloatArray  # from values at the nodes (point, node)


@lru_cache(maxsize=32)
def _singular_rule(pieces: tuple[Piece, ...], nodes: int, first: int, count: int) -> _SingularRule:
    """The rule about nodes from a first one on."""
    start = np.concatenate([piece.rule[0] for piece in pieces])[first : first + count]
    breaks = [piece.start for piece in pieces[1:]]
    rules = [_rule_about(float(each), _LONGEST_IN_NODES / nodes, breaks) for each in start]
    of_node = np.repeat(np.arange(count), [len(offset) for offset, _ in rules])
    offset, weight = (np.concatenate(part) for part in zip(*rules, strict=True))
    return _SingularRule(of_node, offset, weight, _interpolation(pieces, start[of_node] + offset))


@dataclass(frozen=True)
class WetMeridian:
    """The wet side of a shell at Gauss points in t, 0 at the waterline and 1 at the keel, for one azimuthal order.

    Where the curvature of the meridian jumps, normals and potentials are smooth on either side alone: each side has
    nodes of its own.
    """

    shell: DeformedShell
    nodes: int  # on a smooth meridian; where there are junctions some more
    order: int = 0

    @cached_property
    def pieces(self) -> list[Piece]:
        """The smooth pieces, from the waterline to the keel."""
        edges = [0.0]
        for junction in self.shell.basis.shell.meridian.junctions:
            if self._colatitude(np.array([_MERGED]))[0][0] < junction:
                at = brentq(lambda t, to=junction: self._colatitude(np.array([t]))[0][0] - to, 0.0, 1.0, xtol=1e-15)
                edges += [at] if at - edges[-1] > _MERGED and 1 - at > _MERGED else []
        if len(edges) == 1:
            return [Piece(0.0, 1.0, self.nodes)]
        ends = itertools.pairwise((*edges, 1.0))
        return [Piece(a, b, _FURTHER + max(2, round((b - a) * self.nodes))) for a, b in ends]

    @cached_property
    def rule(self) -> tuple[FloatArray, FloatArray]:
        """Nodes and weights in t of all pieces, each shape (node,)."""
        t, weight = zip(*(piece.rule for piece in self.pieces), strict=True)
        return np.concatenate(t), np.concatenate(weight)

    @property
    def count(self) -> int:
        """Number of nodes."""
        return sum(piece.nodes for piece in self.pieces)

    @property
    def waterline(self) -> float:
        """Colatitude of the waterline [rad]; `ConfigError` if the shell at rest has not one, or is no surface."""
        return self.shell.waterline

    def _colatitude(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Colatitude and its rate by t: from the waterline by t^q (1 + (q - s)(1 - t)), s the slope at the keel."""
        q, extra, span = _CROWDING, _CROWDING - _KEEL_SLOPE, np.pi - self.waterline
        rate = span * t ** (q - 1) * (q * (1 + extra * (1 - t)) - extra * t)
        return self.waterline + span * t**q * (1 + extra * (1 - t)), rate

    def chord(self, start: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the vector from t = start to start + `offset`, radial and vertical, each shape (point,) [m].

        By products, as (b^n - a^n)/(b - a) is a sum of a^i b^(n-1-i): a difference of coordinates near the waterline
        would be all round-off.
        """

        def quotient(power: int) -> FloatArray:
            return np.asarray(sum(start**i * (start + offset) ** (power - 1 - i) for i in range(power)))

        extra, span = _CROWDING - _KEEL_SLOPE, np.pi - self.waterline
        further = span * offset * ((1 + extra) * quotient(_CROWDING) - extra * quotient(_CROWDING + 1))
        return self.shell.chord(self._colatitude(start)[0], further)

    def at(self, t: FloatArray) -> Points:
        """Return the points at t."""
        phi, rate = self._colatitude(t)
        m = self.shell.curve(phi)
        length = np.hypot(m.dx, m.dz)
        _, z = self.chord(np.zeros_like(t), t)
        return Points(m.x, z, -m.dz / length, m.dx / length, m.x * length * rate, phi)

    @cached_property
    def points(self) -> Points:
        """The shell at the Gauss points."""
        return self.at(self.rule[0])

    @cached_property
    def areas(self) -> FloatArray:
        """Area per radian of azimuth that each node stands for, shape (node,) [m^2]."""
        return self.rule[1] * self.points.rate

    @cached_property
    def targets(self) -> tuple[FloatArray, FloatArray]:
        """Radius and height of the equations' points: nodes, then inside, each shape (target,) [m].

        On the axis for order 0; else, where potentials vanish there, on circles about it that the shell is clear of.
        """
        height = self.shell.curve(np.array([np.pi])).z * np.array(_INTERIOR)
        if self.order:
            clear = np.hypot(self.points.x, self.points.z - height[:, None]).min(axis=1)
            radius = np.outer(_CIRCLES, clear).ravel()
            height = np.tile(height, len(_CIRCLES))
        else:
            radius = 0 * height
        return np.concatenate([self.points.x, radius]), np.concatenate([self.points.z, height])

    def interpolation(self, t: FloatArray) -> FloatArray:
        """Return the values at t of the polynomials that are one at one node, shape (point, node)."""
        return _interpolation(self.pieces, t)

    def _singular_rows(self, nodes: IntArray) -> FloatArray:
        """Integrals over the shell of 1/r, 1/r' at some nodes, (2 sources, potential and derivative, target, node)."""
        rule = _singular_rule if self.count <= _KEPT else _singular_rule.__wrapped__
        of_node, offset, weight, onto = rule(tuple(self.pieces), self.nodes, int(nodes[0]), len(nodes))
        starts, ends = self.rule[0][nodes], np.searchsorted(of_node, np.arange(len(nodes) + 1))
        points = self.at(starts[of_node] + offset)
        dx, dz = self.chord(starts[of_node], offset)
        both = (-dz, -1.0), (self.points.z[nodes][of_node] + points.z, 1.0)
        values = np.stack([points.influence(self.order, -dx, height, sign) for height, sign in both])
        values *= weight * points.rate
        rows = [values[..., a:b] @ onto[a:b] for a, b in itertools.pairwise(ends)]
        return np.stack(rows, axis=2)

    @cached_property
    def rankine(self) -> FloatArray:
        """Influence of 1/r and 1/r', shape (2 sources, 2 potential and derivative, target, node) [m, -]."""
        groups = [np.arange(i, min(i + _ROWS, self.count)) for i in range(0, self.count, _ROWS)]
        on = np.concatenate([self._singular_rows(group) for group in groups], axis=2)
        p, (x, z) = self.points, (a[self.count :, None] for a in self.targets)
        inside = np.stack([p.influence(self.order, x - p.x, z + sign * p.z, sign) for sign in (-1.0, 1.0)])
        return np.concatenate([on, inside * self.areas], axis=2)

    def solve(self, double: ComplexArray, right: ComplexArray) -> ComplexArray:
        """Return phi of 2 pi phi - D phi = right on the nodes and -D phi = right inside, shape (node, column).

        Least squares in the norm of the surface; an interior equation counts as much as all of the surface.
        """
        root = np.sqrt(self.areas)
        inside = len(double) - self.count
        rows = np.concatenate([root, np.full(inside, np.sqrt(root @ root))])[:, None]
        matrix = -double * rows / root
        matrix[: self.count] += 2 * np.pi * np.eye(self.count)
        adjoint = matrix.conj().T
        return np.asarray(np.linalg.solve(adjoint @ matrix, adjoint @ (rows * right)) / root[:, None])
