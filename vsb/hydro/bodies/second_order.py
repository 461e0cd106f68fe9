"""What finite motions add to linear displacements: rigid pieces turn about hinges, beams shorten and their sections turn.

A linear field stretches what merely turns. Where its second-order part works against pressure and weight it changes the
stiffness of still water, as metacentric heights show of rigid motions. It is known of fields that are rigid piece by
piece (`rigid_pieces`) and of beams, whose sections stay rigid and whose axis keeps its length (`BeamPath`).
"""

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator, PPoly
from scipy.spatial import cKDTree

from vsb.hydro.bodies.body import RIGID_TO, FlexibleBody, Rigid, Triangles, displaced, fitted_motion, owners
from vsb.tools.units import BoolArray, FloatArray, IntArray

_ATTEMPTS = 60
"""Triangles from which a rigid piece is sought before a field is taken for flexible."""
_LEAST_PANELS = 8  # triangles of a rigid piece
_LEAST_SHARE = 0.5  # of the surface in rigid pieces; the rest lies across hinges
_LEAST_SECTIONS = 5  # of a beam
_PINNED = 0.9  # share of the corners in sections whose rotation their corners show
_STRETCH = 1e-4  # of a beam's axis, in terms of the largest displacement
_SHEARED = 0.1  # of the steps of a beam's axis between sections: beyond, sections do not stay normal to it
_FINE, _MOST_TIMES = 150, 6
"""Sections from which on a beam's panels are fine enough as they are, and the most parts a side is divided into."""


class Pieces(NamedTuple):
    """Rigid pieces of a connected body. Triangles across a hinge are cut by the vertical plane through it.

    Their pieces are `one` where `plane` (1, x, y) >= 0, else `other`: where both rise alike. Within a piece both agree.
    """

    motions: tuple[Rigid, ...]
    one: IntArray  # (triangle,)
    other: IntArray  # (triangle,)
    plane: FloatArray  # (triangle, 3)

    def at(self, parent: IntArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return translations and rotations, each (n, xyz), of points (n, xyz) in given triangles."""
        piece = np.where(self.side(parent, points) >= 0, self.one[parent], self.other[parent])
        translation, rotation = (np.array(each)[piece] for each in zip(*self.motions, strict=True))
        return translation, rotation

    def side(self, parent: IntArray, points: FloatArray) -> FloatArray:
        """Return `plane` (1, x, y) of points (n, ..., xyz) in given triangles (n,)."""
        c = self.plane[parent].reshape(len(parent), *[1] * (points.ndim - 2), 3)
        return np.asarray(c[..., 0] + c[..., 1] * points[..., 0] + c[..., 2] * points[..., 1])


def rigid_pieces(body: FlexibleBody, dof: int) -> Pieces | None:
    """Return the pieces a degree of freedom moves rigidly, two or more, None if it bends the body elsewhere too.

    Every panel outside the pieces must touch one of them: it lies across a hinge, wherever its corners are.
    """
    t = body.triangles
    moved, area = t.moved[dof], np.linalg.norm(t.area, axis=1)
    whole, piece, motions = area > 1e-12 * area.max(), np.full(len(area), -1), []
    free = whole & _unstretched(t.corner, moved)
    for _ in range(_ATTEMPTS):
        if not free.any():
            break
        seed = int(np.argmax(np.where(free, area, -1.0)))
        motion, alike = _grown(t.corner, moved, seed, body.size)
        alike &= whole & (piece < 0)
        free[seed] = False
        if alike.sum() >= _LEAST_PANELS and _is_solid(t.corner[alike]):
            piece[alike] = len(motions)
            motions.append(motion)
            free &= ~alike
    inside = piece >= 0
    if len(motions) < 2 or area[inside].sum() < _LEAST_SHARE * area.sum():
        return None
    corners = owners(body.vertices)[np.concatenate([body.faces[:, [0, 1, 2]], body.faces[:, [0, 2, 3]]])]
    if not np.isin(corners, corners[inside]).any(axis=1)[whole].all():
        return None
    return _with_hinges(t.corner.mean(axis=1), area, piece, tuple(motions))


def _unstretched(corner: FloatArray, moved: FloatArray) -> BoolArray:
    """Whether the sides of each triangle keep their lengths, shape (triangle,)."""
    side, change = (np.roll(values, -1, axis=1) - values for values in (corner, moved))
    length = np.maximum(np.linalg.norm(side, axis=2), 1e-300)
    stretch = np.abs((side * change).sum(axis=2)) / length
    return np.asarray((stretch <= 4 * RIGID_TO * np.abs(moved).max()).all(axis=1))


def _grown(corner: FloatArray, moved: FloatArray, seed: int, size: float) -> tuple[Rigid, BoolArray]:
    """Rigid motion of a triangle and of all that move with it, shape (triangle,)."""
    x, largest = corner[seed], float(np.abs(moved).max())
    sides = np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1)
    height = float(np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / sides.max())
    alike, tolerance = np.arange(len(corner)) == seed, RIGID_TO * largest * size / height
    for _ in range(4):
        motion = fitted_motion(corner[alike].reshape(-1, 3), moved[alike].reshape(-1, 3), largest)
        found = np.abs(displaced(motion, corner) - moved).max(axis=(1, 2)) <= tolerance
        if not found.any():
            break
        alike, tolerance = found, RIGID_TO * largest
    return motion, alike


def _is_solid(corner: FloatArray) -> bool:
    """Whether corners span a space: of a plate alone bending makes rigid strips too."""
    points = corner.reshape(-1, 3)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] > 1e-3 * spread[0])


def _with_hinges(centre: FloatArray, area: FloatArray, piece: IntArray, motions: tuple[Rigid, ...]) -> Pieces:
    """Pieces of every triangle; those in none get the two next to them and the line along which both rise alike."""
    one, other, plane = piece.copy(), piece.copy(), np.tile([1.0, 0.0, 0.0], (len(piece), 1))
    trees = [cKDTree(centre[piece == p]) for p in range(len(motions))]
    middle = [np.average(centre[piece == p], axis=0, weights=area[piece == p]) for p in range(len(motions))]
    outside = np.flatnonzero(piece < 0)
    nearest = np.argsort([tree.query(centre[outside])[0] for tree in trees], axis=0)
    for k, (p, q) in zip(outside, nearest[:2].T, strict=True):
        one[k], other[k] = p, q
        (t, a), (s, b) = motions[p], motions[q]
        line = np.array([t[2] - s[2], b[1] - a[1], a[0] - b[0]])  # w_p - w_q
        at = float(line @ [1.0, *middle[p][:2]])
        if np.hypot(*line[1:]) > 0 and at != 0:
            plane[k] = line * np.sign(at)
    return Pieces(motions, one, other, plane)


def cut_at_hinges(corner: FloatArray, parent: IntArray, pieces: Pieces) -> tuple[FloatArray, IntArray]:
    """Return triangles (triangle, 3, xyz) and the number of the panel's half each is of, cut where hinges cross them."""
    value = pieces.side(parent, corner)
    least = 1e-12 * np.abs(value).max(axis=1)
    crossed = (value.min(axis=1) < -least) & (value.max(axis=1) > least)
    found, number = [corner[~crossed]], [parent[~crossed]]
    for k in np.flatnonzero(crossed):
        for sign in (1.0, -1.0):
            polygon = np.array(list(_clipped(corner[k], sign * value[k])))
            fan = [polygon[[0, n, n + 1]] for n in range(1, len(polygon) - 1)]
            found.append(np.array(fan).reshape(-1, 3, 3))
            number.append(np.full(len(fan), parent[k]))
    return np.concatenate(found), np.concatenate(number)


def _clipped(corner: FloatArray, value: FloatArray) -> Iterator[FloatArray]:
    """Corners of the part of a triangle where a linear function is not negative."""
    for k in range(3):
        here, there = value[k], value[(k + 1) % 3]
        if here >= 0:
            yield corner[k]
        if here * there < 0:
            yield corner[k] + here / (here - there) * (corner[(k + 1) % 3] - corner[k])


class _Sections(NamedTuple):
    """Corners of a part by its sections across an axis."""

    vertex: list[IntArray]  # corners of each section
    at: FloatArray  # (section,) [m]
    centre: FloatArray  # (section, xyz): means of their corners [m]


class _Motion(NamedTuple):
    """Motion of one part of a beam as functions of the place along it."""

    shift: PPoly  # of the axis, (xyz)
    turn: PPoly  # (xyz)
    place: FloatArray  # of the axis, (xyz), anywhere along it [m]


class BeamPath:
    """Motions of a beam along x or y to second order: rigid sections on an axis that keeps its length.

    `dofs` are the degrees of freedom that are such motions, in ascending order; none where corners lie in no sections.
    `triangles` are the panels', divided, with the displacements of `dofs` as smooth functions between sections.

    Notes
    -----
    A section moves by psi = T + omega x rho, rho = r - r_a, r_a on the axis, which does not move along itself. To second
    order the axis shortens by half the square of its slope and sections turn by finite angles,
    d2x/dq_i dq_j = -e int T_i'.T_j' ds + (omega_i x (omega_j x rho_j) + omega_j x (omega_i x rho_i))/2.
    Where sections stay normal to the axis, omega = e x T', T is Hermite's cubic between them; else it is monotone.
    """

    def __init__(self, body: FlexibleBody, axis: int) -> None:
        """Find the sections along an axis, 0 or 1, and the motions that leave them rigid."""
        self._body, self._axis, self._motions = body, axis, dict[int, list[_Motion]]()
        self._parts = _sections(body, axis)
        for i in range(len(body.labels)) if self._parts else ():
            found = [_of_sections(body, part, axis, i, _mass(body, p)) for p, part in enumerate(self._parts)]
            if i not in body.rigid and len(known := [motion for motion in found if motion]) == len(found):
                self._motions[i] = known
        self.dofs = tuple(self._motions)

    @cached_property
    def triangles(self) -> Triangles:
        """Panels, divided, and the displacements of `dofs`."""
        corner, part = self._divided
        area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
        found = Triangles(corner, area, np.zeros((len(self.dofs), *corner.shape)))
        for moved, i in zip(found.moved, self.dofs, strict=True):
            for p, motion in enumerate(self._motions[i]):
                points = corner[part == p]
                shift, turn = (_along(f, points[..., self._axis]) for f in (motion.shift, motion.turn))
                moved[part == p] = shift + np.cross(turn, self._lever(points, motion))
        return found

    @cached_property
    def _divided(self) -> tuple[FloatArray, IntArray]:
        """Triangles and the part each is of."""
        times = int(np.clip(np.ceil(_FINE / min(len(part.at) for part in self._parts)), 1, _MOST_TIMES))
        corner, parent = _divided(self._body.triangles.corner, times)
        return corner, np.tile(self._body.part, 2)[parent]

    def field(self, i: int, j: int) -> tuple[FloatArray, FloatArray]:
        """Return d2x/dq_i dq_j of the corners of `triangles`, and its vertical part at the mass below or above them.

        The mass of a section lies at the height of the part's centre of mass, on the axis where none is known.

        Returns
        -------
        tuple of ndarray, shapes (triangle, 3, xyz) and (triangle, 3) [1/m]
        """
        moved, rise = np.zeros_like(self.triangles.corner), np.zeros(self.triangles.corner.shape[:2])
        for p, pair in enumerate(zip(self._motions[i], self._motions[j], strict=True)):
            mine, mass = self._divided[1] == p, _mass(self._body, p)
            points = self.triangles.corner[mine]
            at = points[..., self._axis]
            for own, other in (pair, pair[::-1]):
                rho = self._lever(points, other)
                turn, before = _along(own.turn, at), _along(other.turn, at)
                moved[mine] += np.cross(turn, np.cross(before, rho)) / 2
                rho[..., 2] = 0.0 if mass is None else mass - other.place[2]
                rise[mine] += np.cross(turn, np.cross(before, rho))[..., 2] / 2
            moved[mine, :, self._axis] -= self._shortening(*pair, at)
        return moved, rise

    def _lever(self, points: FloatArray, motion: _Motion) -> FloatArray:
        """Points relative to the axis beside them."""
        return np.where(np.arange(3) == self._axis, 0.0, points - motion.place)

    def _shortening(self, one: _Motion, other: _Motion, at: FloatArray) -> FloatArray:
        """Integral of T_i'.T_j', by the lateral motion of the axis, from its beginning."""
        s = np.unique(np.linspace(one.shift.x[:-1], one.shift.x[1:], 65))
        lateral = np.arange(3) != self._axis
        rate = (one.shift(s, 1) * other.shift(s, 1))[:, lateral].sum(axis=1)
        return np.asarray(np.interp(at, s, cumulative_trapezoid(rate, s, initial=0.0)))


def _along(function: PPoly, at: FloatArray) -> FloatArray:
    """Values, shape (*at.shape, xyz), of a function of places many of which are the same."""
    places, number = np.unique(at, return_inverse=True)
    return np.asarray(function(places)[number.reshape(at.shape)])


def _mass(body: FlexibleBody, part: int) -> float | None:
    """Height of the centre of mass of a part [m]."""
    centre = body.centre_of_mass
    return None if centre is None else float(np.atleast_2d(centre)[part if np.ndim(centre) == 2 else 0, 2])


def _divided(corner: FloatArray, times: int) -> tuple[FloatArray, IntArray]:
    """Triangles divided into `times` squared each, and the number of that each is of."""
    n, i, j = times, *(k.ravel() for k in np.meshgrid(np.arange(times), np.arange(times), indexing="ij"))
    up, down = i + j < n, i + j < n - 1
    patterns = [[(i, j), (i + 1, j), (i, j + 1)], [(i + 1, j), (i + 1, j + 1), (i, j + 1)]]
    share = np.concatenate(
        [
            np.stack([np.column_stack([n - a - b, a, b])[kept] for a, b in three], axis=1)
            for three, kept in zip(patterns, (up, down), strict=True)
        ]
    )
    found = np.einsum("skc,tcx->tskx", share / n, corner)
    return found.reshape(-1, 3, 3), np.repeat(np.arange(len(corner)), len(share))


def _sections(body: FlexibleBody, axis: int) -> list[_Sections]:
    """Sections of panels in ranks along an axis, of every part; none where corners lie anywhere."""
    found, pinned, count = [], 0, 0
    for p in range(int(body.part.max()) + 1):
        used = np.unique(body.faces[body.part == p])
        used = used[np.argsort(body.vertices[used, axis])]
        ends = np.flatnonzero(np.diff(body.vertices[used, axis]) > RIGID_TO * body.size) + 1
        vertex = np.split(used, ends)
        if len(vertex) < _LEAST_SECTIONS:
            return []
        centre = np.array([body.vertices[v].mean(axis=0) for v in vertex])
        spreads = [np.linalg.svd(body.vertices[v] - c, compute_uv=False) for v, c in zip(vertex, centre, strict=True)]
        pinned += sum(len(v) for v, s in zip(vertex, spreads, strict=True) if len(s) > 1 and s[1] > 1e-3 * s[0])
        count += len(used)
        found.append(_Sections(vertex, centre[:, axis], centre))
    return found if pinned >= _PINNED * count else []


def _of_sections(body: FlexibleBody, sections: _Sections, axis: int, dof: int, mass: float | None) -> _Motion | None:
    """Motion of one part as a beam; None if it does not leave sections rigid or stretches the axis."""
    shape, motions = body.shapes[dof], []
    largest = float(np.abs(shape[body.faces]).max())
    for vertex, c in zip(sections.vertex, sections.centre, strict=True):
        motion = fitted_motion(body.vertices[vertex] - c, shape[vertex], largest)
        if np.abs(displaced(motion, body.vertices[vertex] - c) - shape[vertex]).max() > RIGID_TO * largest:
            return None
        motions.append(motion)
    shift, turn = (np.array(each) for each in zip(*motions, strict=True))
    lateral, place = np.arange(3) != axis, sections.centre.mean(axis=0)
    place[2] = place[2] if mass is None else mass  # where nothing tells the axis
    lever = np.cross(turn[:, None], np.eye(3)[lateral])[:, :, axis]  # motion along the axis per metre off it
    along = shift[:, axis] + (lever * (place - sections.centre)[:, lateral]).sum(axis=1)
    columns = np.column_stack([lever, np.ones(len(along))])
    off = np.linalg.lstsq(columns, -along, rcond=RIGID_TO)[0]
    if np.abs(columns @ off + along).max() > _STRETCH * largest:
        return None
    place[lateral] += off[:2]
    shift = shift + np.cross(turn, np.where(lateral, place - sections.centre, 0.0))
    e, s = np.eye(3)[axis], sections.at
    slope, step = np.cross(turn, e), np.diff(s)[:, None]
    astray = np.abs(np.diff(shift, axis=0) - step * (slope[1:] + slope[:-1]) / 2)[:, lateral].max()
    if astray > _SHEARED * np.abs(np.diff(shift, axis=0)).max():
        return _Motion(PchipInterpolator(s, shift), PchipInterpolator(s, turn), place)
    smooth = CubicHermiteSpline(s, shift, np.where(lateral, slope, 0.0))
    rate, twist = smooth.derivative(), PchipInterpolator(s, turn[:, axis])
    bent = np.cross(e, rate.c)
    return _Motion(smooth, _turned(bent, twist, rate.x, axis), place)


def _turned(bent: FloatArray, twist: PchipInterpolator, x: FloatArray, axis: int) -> PPoly:
    """Rotation of normal sections, e x T', and the twist about the axis, as one polynomial, (xyz)."""
    c = np.zeros((4, *bent.shape[1:]))
    c[-len(bent) :] = bent
    c[..., axis] = twist.c
    return PPoly(c, x)
