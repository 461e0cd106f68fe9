"""Hinges and beams: displacements that rotate pieces or sections of a body without deforming them.

A linear displacement field stretches what rotates. For two kinds of fields the second order is known:

- hinges: fields that are rigid piece by piece;
- beams along x or y: sections across the axis stay plane and undeformed, and normal to the axis.

Both move sections by psi = T(s) + omega(s) x rho, rho across the axis, and both continue alike: in the frame that
rotates with a section the strain along the axis stays linear in the amplitudes. So the elastic energy is quadratic, as
with a stiffness matrix of the structure, and the neutral axis of a beam that bends keeps its length.
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array, hstack, vstack
from scipy.spatial import cKDTree

from vsb.engine.hydro.bodies.body import LEAST_PANELS, FlexibleBody
from vsb.engine.hydro.bodies.mesh import RIGID_TO, Rigid, fitted_motion
from vsb.engine.hydro.bodies.sections import Sections, TurningField
from vsb.tools.arrays import BoolArray, FloatArray, IntArray

_SEEDS = 60  # panels from which rigid pieces are grown, at most
_LEAST_SHARE = 0.5  # of the surface in rigid pieces; the rest lies across hinges
_DEGREE, _MOST_SITES = 5, 40  # of the splines along a beam
_DEFORMED = 1e-3  # displacement of a section beyond a rigid one, in terms of the largest
_SIDES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3))  # and diagonals of a panel
_SHEARED = 0.02  # angle of sections from the normals of the axis, in terms of the largest rotation


class Pieces(NamedTuple):
    """Rigid pieces. A triangle lies in one of them, or across a hinge, where two pieces meet at the same height."""

    motions: tuple[Rigid, ...]
    beside: IntArray  # (triangle, 2): the same piece twice, or the two next to it
    centre: FloatArray  # (piece, xyz) [m]

    def sections(self, points: FloatArray, axis: int) -> Sections:
        """Return the motion at points of each triangle, shape (triangle, n, xyz)."""
        translation, rotation = (np.array(each)[self.beside][:, :, None] for each in zip(*self.motions, strict=True))
        at = np.concatenate([self.centre[self.beside[:, :1]], points], axis=1)[:, None]
        rise = (translation + np.cross(rotation, at))[..., 2]  # (triangle, 2, 1 + n)
        higher = rise[:, 0] - rise[:, 1]
        first = (higher[:, 1:] * higher[:, :1] >= 0)[..., None]
        turn = np.where(first, rotation[:, 0], rotation[:, 1])
        shift = np.where(first, translation[:, 0], translation[:, 1])
        along = np.where(np.arange(3) == axis, points, 0.0)
        stretch = np.cross(turn, np.eye(3)[axis])
        return Sections(shift + np.cross(turn, along), turn, stretch, np.zeros_like(turn))


class BeamField(NamedTuple):
    """Sections of a beam."""

    motion: BSpline[np.float64]  # T and omega along the axis, (6,)

    def sections(self, points: FloatArray, axis: int) -> Sections:
        """Return the motion at points, shape (triangle, n, xyz)."""
        s = points[..., axis]
        motion, rate = self.motion(s), self.motion(s, 1)
        return Sections(motion[..., :3], motion[..., 3:], rate[..., :3], rate[..., 3:])


class TurningMotions(NamedTuple):
    """Degrees of freedom that rotate pieces or sections of every part."""

    axis: int  # normal to the sections, 0 or 1
    fields: dict[int, list[TurningField]]  # of every part


def turning_motions(body: FlexibleBody, dofs: list[int]) -> TurningMotions:
    """Return those of some degrees of freedom that are hinges or beams, along the axis that has more of them.

    Beams the body says it has are taken as they are, others are found by the displacements of the corners.
    """
    if np.bincount(body.part).min() < LEAST_PANELS:
        return TurningMotions(0, {})
    parts, known = range(body.part_count), body.beams
    hinged = {(p, i): None if i in known else rigid_pieces(body, p, i) for p in parts for i in dofs}
    found = []
    for axis in (0, 1):
        said = {i: known[i].field for i in dofs if i in known and known[i].axis == axis}
        bent = [beam_fields(body, p, [i for i in dofs if not hinged[p, i] and i not in known], axis) for p in parts]
        each = {i: [said.get(i) or hinged[p, i] or bent[p].get(i) for p in parts] for i in dofs}
        found.append(TurningMotions(axis, {i: [f for f in fields if f] for i, fields in each.items() if all(fields)}))
    return max(found, key=lambda motions: len(motions.fields))


def rigid_pieces(body: FlexibleBody, part: int, dof: int) -> Pieces | None:
    """Return the pieces of a part that a degree of freedom moves rigidly, None if it deforms more than hinges.

    Every panel outside the pieces must lie across a hinge: touch a piece, and move like one of the two nearest pieces
    or between them.
    """
    faces, shape = body.faces[body.part == part], body.shapes[dof]
    largest = float(np.abs(shape[body.faces]).max())
    corner, moved = body.vertices[faces], shape[faces]
    area = np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1) / 2
    free, piece, motions = _unstretched(corner, moved, largest), np.full(len(faces), -1), list[Rigid]()
    if area[free].sum() < _LEAST_SHARE * area.sum():
        return None
    touching = np.zeros(len(faces), dtype=bool)
    for _ in range(_SEEDS):
        if not free.any():
            break
        seed = int(np.argmax(np.where(free, area, -1.0)))
        motion, follows = _piece_from(corner, moved, seed, largest, body.size)
        mine = follows.all(axis=1) & (piece < 0)
        free &= ~mine
        free[seed] = False
        if mine.sum() >= LEAST_PANELS and _is_solid(corner[mine]):
            piece[mine] = len(motions)
            motions.append(motion)
            touching |= follows.any(axis=1)
    inside = piece >= 0
    if area[inside].sum() < _LEAST_SHARE * area.sum() or not touching.all():
        return None
    centre = corner.mean(axis=1)
    count = range(len(motions))
    middle = np.array([np.average(centre[piece == p], axis=0, weights=area[piece == p]) for p in count])
    distance = np.array([cKDTree(centre[piece == p]).query(centre)[0] for p in count])
    beside = np.argsort(distance, axis=0)[[0, min(1, len(motions) - 1)]].T
    beside[inside] = piece[inside, None]
    one, other = (np.array([motion.at(corner) for motion in motions])[each, np.arange(len(faces))] for each in beside.T)
    apart = one - other
    share = np.clip(((moved - other) * apart).sum(axis=-1) / np.maximum((apart**2).sum(axis=-1), 1e-300), 0.0, 1.0)
    if np.abs(moved - other - share[..., None] * apart).max() > RIGID_TO * largest:
        return None
    return Pieces(tuple(motions), np.tile(beside, (2, 1)), middle)


def _unstretched(corner: FloatArray, moved: FloatArray, largest: float) -> BoolArray:
    """Whether sides and diagonals of panels keep their lengths to first order, shape (panel,)."""
    side, change = (np.stack([v[:, b] - v[:, a] for a, b in _SIDES], axis=1) for v in (corner, moved))
    length = np.maximum(np.linalg.norm(side, axis=2), 1e-300)
    return np.asarray((np.abs((side * change).sum(axis=2)) / length <= 4 * RIGID_TO * largest).all(axis=1))


def _piece_from(
    corner: FloatArray, moved: FloatArray, seed: int, largest: float, size: float
) -> tuple[Rigid, BoolArray]:
    """Rigid motion of a panel and the corners that follow it, shape (panel, 4): first to the accuracy of one panel."""
    side = np.linalg.norm(np.diff(corner[seed, [0, 1, 2, 3, 0]], axis=0), axis=1)
    follows, tolerance = np.arange(len(corner))[:, None] == np.full(4, seed), RIGID_TO * largest * size / side.max()
    for _ in range(4):
        motion = fitted_motion(corner[follows], moved[follows], largest)
        found = np.abs(motion.at(corner) - moved).max(axis=2) <= tolerance
        if found.sum() < 4:
            break
        follows, tolerance = found, RIGID_TO * largest
    return motion, follows


def _is_solid(corner: FloatArray) -> bool:
    """Whether corners span a volume: a bent plate has rigid strips too."""
    points = corner.reshape(-1, 3)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] > 1e-3 * spread[0])


def beam_fields(body: FlexibleBody, part: int, dofs: list[int], axis: int) -> dict[int, BeamField]:
    """Return the fields of those degrees of freedom that move a part as a beam along an axis, 0 or 1.

    T and omega are splines, fitted to the displacements of all corners. Sections must stay undeformed, and normal to
    the axis: T' = omega x e across it, at the axis of twist where sections twist about one.
    """
    mine = body.vertex_part == part
    points, moved = body.vertices[mine], body.shapes[dofs][:, mine]
    knots = _knots(points[:, axis], body.size)
    if not dofs or knots is None:
        return {}
    matrix, s = _sections_matrix(points, knots, axis), np.linspace(knots[0], knots[-1], 4 * len(knots))
    gram, right = (matrix.T @ matrix).toarray(), matrix.T @ moved.reshape(len(dofs), -1).T
    coefficient = np.linalg.lstsq(gram, right, rcond=1e-12)[0]
    misfit = np.abs((matrix @ coefficient).T.reshape(moved.shape) - moved).max(axis=(1, 2))
    found = {}
    for k, i in enumerate(dofs):
        spline = BSpline(knots, coefficient[:, k].reshape(6, -1).T, _DEGREE)
        largest = np.abs(body.shapes[i][body.faces]).max()
        if misfit[k] <= _DEFORMED * largest and _sheared(spline, s, axis) <= _SHEARED:
            found[i] = BeamField(spline)
    return found


def _knots(at: FloatArray, size: float) -> FloatArray | None:
    """Knots of splines through the coordinates of corners along an axis, None if these are too few."""
    levels = np.sort(at)
    levels = levels[np.append(True, np.diff(levels) > RIGID_TO * size)]
    levels[-1] = at.max()
    if len(levels) < _DEGREE + 1:
        return None
    sites = np.quantile(levels, np.linspace(0, 1, min(len(levels), _MOST_SITES)))
    inner = np.convolve(sites[1:-1], np.full(_DEGREE, 1 / _DEGREE), mode="valid")  # de Boor's means
    return np.concatenate([np.repeat(sites[0], _DEGREE + 1), inner, np.repeat(sites[-1], _DEGREE + 1)])


def _sections_matrix(points: FloatArray, knots: FloatArray, axis: int) -> csr_array:
    """Displacements (xyz, point, flat) by the coefficients (T and omega, spline, flat) of sections' motions."""
    basis = BSpline.design_matrix(np.clip(points[:, axis], knots[0], knots[-1]), knots, _DEGREE)
    rho = np.where(np.arange(3) == axis, 0.0, points)
    units = [np.tile(e, (len(points), 1)) for e in np.eye(3)] + [np.cross(e, rho) for e in np.eye(3)]
    rows = [hstack([diags_array(unit[:, k]) @ basis for unit in units]) for k in range(3)]
    order = np.arange(3 * len(points)).reshape(3, -1).T.ravel()
    return csr_array(csr_array(vstack(rows))[order])


def _sheared(motion: BSpline[np.float64], s: FloatArray, axis: int) -> float:
    """Largest angle between sections and the normals of the axis, in terms of the largest rotation or rate [-]."""
    across, e = np.arange(3) != axis, np.eye(3)[axis]
    turn, rate, twist = motion(s)[:, 3:], motion(s, 1)[:, :3], motion(s, 1)[:, 3 + axis]
    lean = (rate - np.cross(turn, e))[:, across]
    if (size := float((twist**2).sum())) > 0:
        lean = lean - np.outer(twist, twist @ lean / size)  # of the axis of twist, which need not be the coordinates'
    largest = max(np.abs(turn).max(), np.abs(rate).max(), 1e-300)
    return float(np.abs(lean).max() / largest)
