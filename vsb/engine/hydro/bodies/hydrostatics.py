"""Stiffness of still water, and of weight, for bodies of any shape: rigid motions, hinges, bending, several bodies.

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

from vsb.engine.hydro.bodies.body import LEAST_PANELS, FlexibleBody, Sections, Triangles, TurningField
from vsb.engine.hydro.bodies.mesh import RIGID_TO, Rigid, fitted_motion, flatness
from vsb.tools.arrays import BoolArray, FloatArray, IntArray

_SEEDS = 60  # panels from which rigid pieces are grown, at most
_LEAST_SHARE = 0.5  # of the surface in rigid pieces; the rest lies across hinges
_DEGREE, _MOST_SITES = 5, 40  # of the splines along a beam
_DEFORMED = 1e-3  # displacement of a section beyond a rigid one, in terms of the largest
_SIDES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3))  # and diagonals of a panel
_SOLID = 1e-3  # `flatness` of a piece, above which it spans a volume: a bent plate has rigid strips too
_SHEARED = 0.02  # angle of sections from the normals of the axis, in terms of the largest rotation


# Hinges and beams


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


def turning_motions(body: FlexibleBody) -> TurningMotions:
    """Return the degrees of freedom that are hinges or beams, along the axis that has more of them.

    Beams the body says it has are taken as they are, others are found by the displacements of the corners. None if the
    file states the second order, or no centre of mass for each part.
    """
    centres = 0 if body.centre_of_mass is None else len(np.atleast_2d(body.centre_of_mass))
    unknown = body.second_order is not None or centres != body.part_count
    if unknown or np.bincount(body.part).min() < LEAST_PANELS:
        return TurningMotions(0, {})
    dofs = body.flexible
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
        if mine.sum() >= LEAST_PANELS and flatness(corner[mine]) > _SOLID:
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


# Stiffness


def hydrostatic_stiffness(body: FlexibleBody, density: float, gravity: float) -> FloatArray:
    """Return the stiffness of still water (and of weight, for rotations), shape (dof, dof) [N/m].

    The displaced volume V has the energy U = -rho g int_V z dV = -(rho g/2) int_S z^2 n_z dS. C is the second
    derivative of U and of the weight's energy along x = x_0 + sum q_i psi_i + sum q_i q_j chi_ij/2. The second-order
    part chi depends on the displacements:

    - Rigid motions, of the whole body or of each of several separate parts, rotate. With such a motion i,
      C_ij = -rho g int psi_j.n w_i dS, w_i its vertical part (Newman 1994); between two of them the weight rho V g of
      each part at its centre of mass is added: metacentric heights.
    - Between motions of hinged pieces and of beams (`turning`), a their rotations, e their strains along the axis,

          C_ij = rho g {int_waterplane w_i w_j dA + int_V [(a_i.a_j)_horizontal (z - z_G) - w_i e_j - w_j e_i] dV}.

      Every piece and section carries the weight of its own displaced water at the height z_G of the part's centre of
      mass. Pieces do not strain: C is the sum of their rigid forms, each closed by a wall at the hinge, with water in
      the gap. Waves are solved on the wetted surface alone, as if the gap were sealed, and so are the rows of rigid
      motions, which are the forces of long waves: `hinge_gap` estimates the effect.
    - If the file states chi (`FlexibleBody.second_order`), -rho g int z chi_ij.n dS is added to the second derivative
      on linearly displaced panels, in place of the forms of hinges and beams. The work of the weight, g int chi_z dm,
      belongs to the structure's stiffness.
    - Otherwise chi = 0 is assumed: `linear_share` estimates the effect.

    A flexible mode must carry no momentum, int psi dm = 0, as free-free modes do, or the weight it moves is missing.
    """
    t = body.triangles
    stiffness, eulerian = _energy_hessian(t), _fixed_field_stiffness(t)
    rigid = body.rigid.keys() | body.rigid_parts.keys()
    if body.second_order is None:
        motions = turning_motions(body)
        if known := list(motions.fields):
            stiffness[np.ix_(known, known)] = _form(body, motions, known, columns_of(t))
    else:
        stiffness -= [  # work against the pressure -z
            [t.integral(np.einsum("tkx,tx->tk", chi[body.triangle_corners], t.area), t.corner[..., 2]) for chi in row]
            for row in body.second_order
        ]
    for i in rigid:
        for j in range(len(body.labels)):
            if j in rigid:
                both = (eulerian[i, j] + eulerian[j, i]) / 2
                stiffness[i, j] = both + _weight_lift(body, i, j)
            else:
                stiffness[i, j] = stiffness[j, i] = eulerian[i, j]
    return np.asarray(density * gravity * stiffness)


def hinge_gap(body: FlexibleBody) -> float | None:
    """Return the largest relative change of a hinge's stiffness if its gap is sealed against water; None without one.

    The gap opens by psi.n between the walls that close the pieces; as part of the body it adds 2 int_walls w psi.n dS.
    With the wetted surface S, on which waves are solved as if the gap were sealed, and the waterplane these walls
    close every piece: int_walls w psi.n dS = int_V psi.grad w dV - int_S w psi.n dS - int_waterplane w^2 dA.
    """
    motions, columns, shares = turning_motions(body), columns_of(body.triangles), list[float]()
    for i, fields in motions.fields.items():
        if any(isinstance(field, Pieces) and len(field.motions) > 1 for field in fields):
            sections = _sections(body, motions, i, columns)
            moved = sections.displacement(columns.across(motions.axis))
            gradient = np.stack([-sections.turn[:, :, 0, 1], sections.turn[:, :, 0, 0]], axis=-1)  # of the rise w
            slope = np.einsum("tqcx,tqx->tqc", moved[..., :2], gradient)
            through = _fixed_field_stiffness(body.triangles)[i, i]
            rise = moved[..., 0, 2]
            walls = (slope * columns.volume).sum() + through - (rise**2 * columns.waterplane).sum()
            form = _form(body, motions, [i], columns)[0, 0]
            shares.append(float(2 * abs(walls) / (abs(form) + 2 * abs(walls))))
    return max(shares, default=None)


def linear_share(body: FlexibleBody) -> float | None:
    """Return the largest share of a stiffness that an unknown second-order part may have; None if all are known.

    An estimate of its order of magnitude, (1/2) int z^2 |grad psi|^2 dS, as of a box that shortens as it bends.
    """
    known = turning_motions(body).fields
    unknown = [i for i in body.flexible if i not in known]
    if not unknown or body.second_order is not None:
        return None
    t = body.triangles
    height = ((t.corner[..., 2] ** 2).sum(axis=1) + t.corner[..., 2].sum(axis=1) ** 2) / 12
    missed = t.squared_gradients(unknown) @ height / 2
    linear = np.abs(np.diag(_energy_hessian(t))[unknown])
    return float((missed / (missed + linear)).max())


class Columns(NamedTuple):
    """Quadrature of the displaced water by vertical columns from points of the wetted surface up to the waterplane.

    Vertical walls, such as those of a hinge, close a body without adding any.
    """

    points: FloatArray  # (triangle, n, xyz) [m]
    z: FloatArray  # (triangle, n, m): heights in each column [m]
    waterplane: FloatArray  # (triangle, n): weights [m^2]
    volume: FloatArray  # (triangle, n, m): weights [m^3]

    def across(self, axis: int) -> FloatArray:
        """Return places across a horizontal axis, (triangle, n, m, xyz) [m]."""
        rho = np.repeat(self.points[:, :, None], self.z.shape[-1], axis=2)
        rho[..., 2], rho[..., axis] = self.z, 0.0
        return rho


def columns_of(t: Triangles) -> Columns:
    """Return int_V g dV = int_S n_z int_0^z g dz dS as a quadrature.

    Radon's seven points in a triangle and two of Gauss in a column.
    """
    root = 15**0.5
    corner = [np.full(3, 1 / 3)]
    for a in ((6 - root) / 21, (6 + root) / 21):
        corner += list(a + (1 - 3 * a) * np.eye(3))
    weight = np.array([270.0, *[155 - root] * 3, *[155 + root] * 3]) / 1200
    points = np.einsum("qk,tkx->tqx", np.array(corner), t.corner)
    up = t.area[:, 2, None] * weight
    z = points[..., 2, None] * (0.5 + np.array([-0.5, 0.5]) / 3**0.5)
    return Columns(points, z, -up, np.repeat((up * points[..., 2])[..., None] / 2, 2, axis=-1))


def _sections(body: FlexibleBody, motions: TurningMotions, i: int, columns: Columns) -> Sections:
    """Motion of the sections of all parts at the points of the columns, shape (triangle, n, 1, xyz) each."""
    part, found = np.tile(body.part, 2), Sections(*(np.zeros_like(columns.points) for _ in Sections._fields))
    for p, field in enumerate(motions.fields[i]):
        for values, own in zip(found, field.sections(columns.points[part == p], motions.axis), strict=True):
            values[part == p] = own
    return Sections(*(values[:, :, None] for values in found))


def _form(body: FlexibleBody, motions: TurningMotions, dofs: list[int], columns: Columns) -> FloatArray:
    """Stiffness between motions of hinges and beams (`hydrostatic_stiffness`), (dof, dof) [m^2]."""
    sections = [_sections(body, motions, i, columns) for i in dofs]
    rho = columns.across(motions.axis)
    rise = np.array([each.displacement(rho)[..., 0, 2] for each in sections])
    turn = np.array([each.turn[:, :, 0, :2] for each in sections])
    opened = np.array([(each.strain(rho, motions.axis) * columns.volume).sum(axis=-1) for each in sections])
    mass = _centres(body)[np.tile(body.part, 2), 2]
    metacentric = ((columns.z - mass[:, None, None]) * columns.volume).sum(axis=-1)
    stretched = np.einsum("itq,jtq->ij", rise, opened)
    form = np.einsum("itq,jtq,tq->ij", rise, rise, columns.waterplane, optimize=True)
    form += np.einsum("itqx,jtqx,tq->ij", turn, turn, metacentric, optimize=True)
    return np.asarray(form - stretched - stretched.T)


def _energy_hessian(t: Triangles) -> FloatArray:
    """Second derivative of -(1/2) int z^2 n_z dS by the amplitudes, (dof, dof) [m^2]."""
    e, f = (t.corner[:, k] - t.corner[:, 0] for k in (1, 2))
    de, df = (t.moved[:, :, k] - t.moved[:, :, 0] for k in (1, 2))
    z, dz = t.corner[..., 2], t.moved[..., 2]
    slope = (de[..., 0] * f[:, 1] + e[:, 0] * df[..., 1] - de[..., 1] * f[:, 0] - e[:, 1] * df[..., 0]) / 2
    height = (np.sum(z**2, axis=1) + z.sum(axis=1) ** 2) / 12  # mean of z^2 over a triangle
    rise = (np.einsum("tk,itk->it", z, dz) + z.sum(axis=1) * dz.sum(axis=2)) / 6
    turn = np.einsum("it,jt->ij", de[..., 0] * height, df[..., 1]) - np.einsum(
        "it,jt->ij", de[..., 1] * height, df[..., 0]
    )
    lift = np.einsum("itk,jtk->ij", dz * t.area[:, 2, None], dz) + (dz.sum(axis=2) * t.area[:, 2]) @ dz.sum(axis=2).T
    hessian = (turn + turn.T) / 2 + slope @ rise.T + rise @ slope.T + lift / 6
    return np.asarray(-hessian / 2)


def _fixed_field_stiffness(t: Triangles) -> FloatArray:
    """-int psi_j.n w_i dS, row i, column j, (dof, dof) [m^2]."""
    flow = np.einsum("jtkx,tx->jtk", t.moved, t.area)
    return np.array([[-t.integral(f, w) for f in flow] for w in t.moved[..., 2]])


def _weight_lift(body: FlexibleBody, i: int, j: int) -> float:
    """Second-order rise of the centres of mass by two rigid motions, times the volumes they displace [m^4]."""
    total, centres, volumes = 0.0, _centres(body), np.array([body.volume])
    if len(centres) > 1:
        volumes = np.bincount(
            np.tile(body.part, 2), body.triangles.corner.mean(axis=1)[:, 2] * body.triangles.area[:, 2]
        )
    for p, (volume, centre) in enumerate(zip(volumes, centres, strict=True)):
        (t_i, a_i), (t_j, a_j) = (body.rigid[k] if k in body.rigid else body.rigid_parts[k][p] for k in (i, j))
        move_i, move_j = t_i + np.cross(a_i, centre), t_j + np.cross(a_j, centre)
        total += volume * float((np.cross(a_i, move_j) + np.cross(a_j, move_i))[2] / 2)
    return total


def _centres(body: FlexibleBody) -> FloatArray:
    """Centre of mass of each part, (part, xyz) [m]; without rotations it may be unknown."""
    return np.zeros((1, 3)) if body.centre_of_mass is None else np.atleast_2d(body.centre_of_mass)
