"""Stiffness of still water, and of weight, for bodies of any shape: rigid motions, flexible ones, several bodies."""

import numpy as np

from vsb.hydro.bodies.body import FlexibleBody, Rigid, Triangles
from vsb.tools.units import FloatArray


def hydrostatic_stiffness(body: FlexibleBody, density: float, gravity: float) -> FloatArray:
    """Return the stiffness of still water (and of weight, for rotations), shape (dof, dof) [N/m].

    Notes
    -----
    Water has the energy U = -rho g int_V z dV = -(rho g/2) int_S z^2 n_z dS of the space V the body takes from it.
    Between flexible displacements C is the exact second derivative of U on the displaced panels (x = x_0 + sum
    q_i psi_i), moving waterline and turning panels included, hence symmetric. Rigid motions turn without stretching;
    with a rigid motion i, C_ij = -rho g int psi_j.n w_i dS, w_i its vertical part (Newman 1994), and between rigid ones
    the weight rho V g at the centre of mass joins in: metacentric heights. Of several separate parts a motion of one
    alone is as rigid, with that part's weight. A flexible mode must carry no momentum, int psi dm = 0, as free-free
    modes do, or the weight it moves is missing.
    """
    flexible = _energy_hessian(body.triangles)
    eulerian = _fixed_field_stiffness(body.triangles)
    stiffness = flexible.copy()
    rigid = body.rigid.keys() | body.alone.keys()
    for i in rigid:
        for j in range(len(body.labels)):
            if j in rigid:
                both = (eulerian[i, j] + eulerian[j, i]) / 2
                stiffness[i, j] = both + _weight_lift(body, i, j)
            else:
                stiffness[i, j] = stiffness[j, i] = eulerian[i, j]
    return np.asarray(density * gravity * stiffness)


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
    total = 0.0
    for p, (volume, centre) in enumerate(zip(_volumes(body), _centres(body), strict=True)):
        (t_i, a_i), (t_j, a_j) = _motion_of(body, i, p), _motion_of(body, j, p)
        move_i, move_j = t_i + np.cross(a_i, centre), t_j + np.cross(a_j, centre)
        total += volume * float((np.cross(a_i, move_j) + np.cross(a_j, move_i))[2] / 2)
    return total


def _motion_of(body: FlexibleBody, i: int, p: int) -> Rigid:
    """Rigid motion of a part."""
    if i in body.rigid:
        return body.rigid[i]
    part, motion = body.alone[i]
    return motion if part == p else Rigid(np.zeros(3), np.zeros(3))


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
