"""Stiffness of still water, and of weight, for bodies of any shape: rigid motions, hinges, bending, several bodies."""

from itertools import combinations_with_replacement

import numpy as np

from vsb.hydro.bodies.body import FlexibleBody, Rigid, Triangles, squared_gradients
from vsb.hydro.bodies.second_order import BeamPath, Pieces, cut_at_hinges, rigid_pieces
from vsb.tools.units import FloatArray


def hydrostatic_stiffness(body: FlexibleBody, density: float, gravity: float) -> FloatArray:
    """Return the stiffness of still water (and of weight, for rotations), shape (dof, dof) [N/m].

    Notes
    -----
    Water has the energy U = -rho g int_V z dV = -(rho g/2) int_S z^2 n_z dS of the space V the body takes from it, and
    C is its second derivative, with that of the weight's, along x = x_0 + sum q_i psi_i + sum q_i q_j chi_ij/2:

        C_ij = [second derivative of U on panels displaced by psi] - rho g int z chi_ij.n dS + g int chi_ij,z dm.

    Without chi displaced panels would stretch where they only turn. It is known

    - of motions rigid part by part, separate parts: turns. With such a motion i, C_ij = -rho g int psi_j.n w_i dS, w_i
      its vertical part (Newman 1994), and between such motions the weight rho V g of each part at its centre of mass
      joins in: metacentric heights;
    - of motions rigid piece by piece of one part, a hinge between them: between two of them C is the sum of the forms of
      the pieces, each closed by a vertical wall at the hinge and carrying its own weight straight above or below its own
      centre of buoyancy at the height of the part's centre of mass. So water stands in the gap; `hinge_gap` says what
      changes if the gap is sealed;
    - of beams: `second_order.BeamPath`, with the weight of each section that of the water it displaces, at that height;
    - of what a file states (`FlexibleBody.second_order`), which takes the place of both latter ones. The rise of its
      masses, g int chi_z dm, is left to the stiffness of the structure.

    Of any other displacement chi = 0 is a choice, not knowledge: `linear_share`. A flexible mode must carry no
    momentum, int psi dm = 0, as free-free modes do, or the weight it moves is missing.
    """
    stiffness = _energy_hessian(body.triangles)
    eulerian = _fixed_field_stiffness(body.triangles)
    rigid = body.rigid.keys() | body.rigid_parts.keys()
    others = [i for i in range(len(body.labels)) if i not in rigid]
    pieces = _pieces(body, others)
    beams = [_of_beam(path) for path in _paths(body, others)]
    for i, j in combinations_with_replacement(others, 2):
        if body.second_order is not None:
            stiffness[i, j] += _work(body.triangles, body.corners_of(body.second_order[i, j]))
        elif i in pieces and j in pieces:
            stiffness[i, j] = _hinged(body, pieces[i], pieces[j])[0]
        elif beam := next((beam for beam in beams if {i, j} <= beam.keys()), None):
            stiffness[i, j] = beam[i][j]
        stiffness[j, i] = stiffness[i, j]
    for i in rigid:
        for j in range(len(body.labels)):
            if j in rigid:
                both = (eulerian[i, j] + eulerian[j, i]) / 2
                stiffness[i, j] = both + _weight_lift(body, i, j)
            else:
                stiffness[i, j] = stiffness[j, i] = eulerian[i, j]
    return np.asarray(density * gravity * stiffness)


def hinge_gap(body: FlexibleBody) -> float:
    """Return by what share, at most, the stiffness of a hinge in one part changes if its gap is sealed against water.

    The gap opens by psi.n of the walls that close the pieces, 2 int_walls w psi.n dS more if it is part of the body.
    Waves and radiation are solved on the panels there are: of the sealed body.
    """
    others = [] if body.second_order is not None else [i for i in range(len(body.labels)) if i not in body.rigid]
    forms = [_hinged(body, each, each) for each in _pieces(body, others).values()]
    return max((abs(gap) / (abs(own) + abs(gap)) for own, gap in forms if gap), default=0.0)


def linear_share(body: FlexibleBody) -> float:
    """Return what the second-order part of displacements might have, as a share of their stiffness, where none is known.

    An estimate of its order, (1/2) int z^2 |grad psi|^2 dS, as of a box that shortens as it bends.
    """
    rigid = body.rigid.keys() | body.rigid_parts.keys()
    others = [] if body.second_order is not None else [i for i in range(len(body.labels)) if i not in rigid]
    pieces, paths = _pieces(body, others), _paths(body, others)
    unknown = [i for i in others if i not in pieces and not any(i in path.dofs for path in paths)]
    if not unknown:
        return 0.0
    t = body.triangles
    height = ((t.corner[..., 2] ** 2).sum(axis=1) + t.corner[..., 2].sum(axis=1) ** 2) / 12
    missed = squared_gradients(t, unknown) @ height / 2
    known = np.abs(np.diag(_energy_hessian(t))[unknown])
    return float((missed / (missed + known)).max())


def _pieces(body: FlexibleBody, dofs: list[int]) -> dict[int, Pieces]:
    """Rigid pieces of the degrees of freedom that have such."""
    return {i: found for i in dofs if (found := rigid_pieces(body, i))}


def _paths(body: FlexibleBody, dofs: list[int]) -> list[BeamPath]:
    """The body as a beam along x and along y, if there is need, where some motion is such a beam's."""
    paths = [BeamPath(body, axis) for axis in (0, 1)] if dofs else []
    return [path for path in paths if path.dofs]


def _of_beam(path: BeamPath) -> dict[int, dict[int, float]]:
    """Stiffness between every two motions of a beam [m^2]."""
    matrix: dict[int, dict[int, float]] = {i: {} for i in path.dofs}
    linear = _energy_hessian(path.triangles)
    for (a, i), (b, j) in combinations_with_replacement(enumerate(path.dofs), 2):
        moved, rise = path.field(i, j)
        value = linear[a, b] + _work(path.triangles, moved) + _lift(path.triangles, rise)
        matrix[i][j] = matrix[j][i] = float(value)
    return matrix


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


def _work(t: Triangles, moved: FloatArray) -> float:
    """Work of unit pressure -z on a displacement of corners (triangle, 3, xyz), -int z chi.n dS [m^2]."""
    return -float(t.integral(np.einsum("tkx,tx->tk", moved, t.area), t.corner[..., 2]))


def _lift(t: Triangles, rise: FloatArray) -> float:
    """Work against a weight that is everywhere that of the water displaced, on a rise (triangle, 3), [m^2]."""
    return float(t.integral(rise * t.area[:, 2, None], t.corner[..., 2]))


def _hinged(body: FlexibleBody, one: Pieces, other: Pieces) -> tuple[float, float]:
    """Sum of the forms of the pieces common to two motions, and what sealing their gaps adds to it [m^2].

    Notes
    -----
    Of a piece with its wall, by the vertical parts of its normals alone, which a vertical wall has none of:
    -int w_i w_j n_z dS - (a_i.a_j)_horizontal int (z_G - z/2) z n_z dS, waterplane and metacentric height. The flux
    through walls is what the wet surface and the waterplane lack of int_V div(w_j psi_i) dV = int_V psi_i.grad w_j dV.
    """
    t = body.triangles
    corner, parent = cut_at_hinges(*cut_at_hinges(t.corner, np.arange(len(t.corner)), one), other)
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
    middle, z, down = corner.mean(axis=1), corner[..., 2], area[:, 2, None]
    (t_i, a_i), (t_j, a_j) = one.at(parent, middle), other.at(parent, middle)
    psi_i, psi_j = (shift[:, None] + np.cross(turn[:, None], corner) for shift, turn in ((t_i, a_i), (t_j, a_j)))
    alike = (a_i[:, :2] * a_j[:, :2]).sum(axis=1)[:, None]
    mass = _centres(body)[np.tile(body.part, 2) if len(_centres(body)) > 1 else np.zeros(len(t.corner), dtype=int), 2]
    flat = float(t.integral(psi_i[..., 2] * down, psi_j[..., 2]))
    form = -flat - float(t.integral(alike * down * (mass[parent][:, None] - z / 2), z))
    gap = 2 * flat
    for psi, own, w, turn in ((psi_i, a_i, psi_j[..., 2], a_j), (psi_j, a_j, psi_i[..., 2], a_i)):
        slope = np.column_stack([-turn[:, 1], turn[:, 0]])  # grad w
        lean = z[..., None] * np.column_stack([own[:, 1], -own[:, 0]])[:, None]  # of psi, with z
        gap += float(t.integral(np.einsum("tkx,tx->tk", psi[..., :2] - lean / 2, slope) * down, z))
        gap -= float(t.integral(np.einsum("tkx,tx->tk", psi, area), w))
    return form, gap


def _fixed_field_stiffness(t: Triangles) -> FloatArray:
    """-int psi_j.n w_i dS, row i, column j, (dof, dof) [m^2]."""
    flow = np.einsum("jtkx,tx->jtk", t.moved, t.area)
    return np.array([[-t.integral(f, w) for f in flow] for w in t.moved[..., 2]])


def _weight_lift(body: FlexibleBody, i: int, j: int) -> float:
    """Second-order rise of the centres of mass by two rigid motions, times the volumes they displace [m^4]."""
    total = 0.0
    for p, (volume, centre) in enumerate(zip(_volumes(body), _centres(body), strict=True)):
        (t_i, a_i), (t_j, a_j) = _motion_of(body, i, p), _motion_of(body, j, p)
        move_i, move_j = t_i + np.cross(a_i, centre), t_j + np.cross(a_j, centre)
        total += volume * float((np.cross(a_i, move_j) + np.cross(a_j, move_i))[2] / 2)
    return total


def _motion_of(body: FlexibleBody, i: int, p: int) -> Rigid:
    """Rigid motion of a part."""
    return body.rigid[i] if i in body.rigid else body.rigid_parts[i][p]


def _volumes(body: FlexibleBody) -> FloatArray:
    """Volume of water each part displaces; of everything, where there is one centre of mass (part,) [m^3]."""
    if len(_centres(body)) == 1:
        return np.array([body.volume])
    corner, area, _ = body.triangles
    volumes = np.zeros(len(_centres(body)))
    np.add.at(volumes, np.tile(body.part, 2), corner.mean(axis=1)[:, 2] * area[:, 2])
    return volumes


def _centres(body: FlexibleBody) -> FloatArray:
    """Centre of mass of each part; without any nothing turns (part, xyz) [m]."""
    return np.zeros((1, 3)) if body.centre_of_mass is None else np.atleast_2d(body.centre_of_mass)
