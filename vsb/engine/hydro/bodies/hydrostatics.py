"""Stiffness of still water, and of weight, for bodies of any shape: rigid motions, hinges, bending, several bodies."""

from typing import NamedTuple

import numpy as np

from vsb.engine.hydro.bodies.body import FlexibleBody, Triangles
from vsb.engine.hydro.bodies.sections import Sections
from vsb.engine.hydro.bodies.turning import Pieces, TurningMotions, turning_motions
from vsb.tools.arrays import FloatArray


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
        motions = _turning(body)
        if known := list(motions.fields):
            stiffness[np.ix_(known, known)] = _form(body, motions, known, columns_of(t))
    else:
        stiffness += [[_pressure_work(t, chi[body.triangle_corners]) for chi in row] for row in body.second_order]
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
    motions, columns, shares = _turning(body), columns_of(body.triangles), list[float]()
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
    known = _turning(body).fields
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


def _turning(body: FlexibleBody) -> TurningMotions:
    """Hinges and bending; none if the file states the second order, or no centre of mass for each part."""
    count = 0 if body.centre_of_mass is None else len(np.atleast_2d(body.centre_of_mass))
    known = body.second_order is None and count == body.part_count
    return turning_motions(body, body.flexible if known else [])


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


def _pressure_work(t: Triangles, moved: FloatArray) -> float:
    """Work against the pressure -z on a displacement of corners, (triangle, 3, xyz): -int z chi.n dS [m^2]."""
    return -float(t.integral(np.einsum("tkx,tx->tk", moved, t.area), t.corner[..., 2]))


def _fixed_field_stiffness(t: Triangles) -> FloatArray:
    """-int psi_j.n w_i dS, row i, column j, (dof, dof) [m^2]."""
    flow = np.einsum("jtkx,tx->jtk", t.moved, t.area)
    return np.array([[-t.integral(f, w) for f in flow] for w in t.moved[..., 2]])


def _weight_lift(body: FlexibleBody, i: int, j: int) -> float:
    """Second-order rise of the centres of mass by two rigid motions, times the volumes they displace [m^4]."""
    total = 0.0
    for p, (volume, centre) in enumerate(zip(_volumes(body), _centres(body), strict=True)):
        (t_i, a_i), (t_j, a_j) = (body.rigid[k] if k in body.rigid else body.rigid_parts[k][p] for k in (i, j))
        move_i, move_j = t_i + np.cross(a_i, centre), t_j + np.cross(a_j, centre)
        total += volume * float((np.cross(a_i, move_j) + np.cross(a_j, move_i))[2] / 2)
    return total


def _volumes(body: FlexibleBody) -> FloatArray:
    """Volume displaced by each part, or by the whole body if there is one centre of mass, (part,) [m^3]."""
    if len(_centres(body)) == 1:
        return np.array([body.volume])
    corner, area, _ = body.triangles
    volumes = np.zeros(len(_centres(body)))
    np.add.at(volumes, np.tile(body.part, 2), corner.mean(axis=1)[:, 2] * area[:, 2])
    return volumes


def _centres(body: FlexibleBody) -> FloatArray:
    """Centre of mass of each part, (part, xyz) [m]; without rotations it may be unknown."""
    return np.zeros((1, 3)) if body.centre_of_mass is None else np.atleast_2d(body.centre_of_mass)
