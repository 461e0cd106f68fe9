"""What membrane forces and pressure inside do to shapes of azimuthal order m >= 1: the prestress of the sphere's sides.

Membrane forces N of the load at rest work on the second-order part of Green's strains, half the squared gradient of the
displacement along each line of the surface; the pressure inside on the volume's. Neither knows which way the buoy is
turned, so rigid motions have none.
"""

import numpy as np

from vsb.shell.deformed import gauss_rule
from vsb.shell.loaded import LoadedShell
from vsb.shell.orders import OrderBasis
from vsb.tools.arrays import FloatArray


def geometric_stiffness(
    basis: OrderBasis, colatitude: FloatArray, area: FloatArray, meridional: FloatArray, hoop: FloatArray
) -> FloatArray:
    """Return int [N_phi |d u/d phi|^2 + N_theta |d u/d theta|^2/sin^2(phi)]/r^2 dA, shape (dof, dof) [N/m].

    Parameters
    ----------
    basis : OrderBasis
    colatitude, area : ndarray, shape (point,)
        Quadrature points [rad], and the area of the ring of each [m^2].
    meridional, hoop : ndarray, shape (point,)
        Membrane forces N_phi and N_theta, the same around [N/m].

    Notes
    -----
    The gradient of v e_r + u e_phi + w e_theta, v and u with cos(m theta), w with sin(m theta); either is a half on
    average around. For m = 0 the same are strains and rotation of `ElasticShell.geometric_stiffness`.
    """
    r, m, sin, cos = basis.shell.radius, basis.order, np.sin(colatitude), np.cos(colatitude)
    (v, u, w), (dv, du, dw) = basis.field(colatitude), basis.field(colatitude, derivative=1)
    along = (dv - u, du + v, dw)
    around = (-m * v - w * sin, -m * u - w * cos, m * w + v * sin + u * cos)
    by_phi, by_theta = area * meridional / (2 * r**2), area * hoop / (2 * (r * sin) ** 2)
    found = sum((by_phi * one) @ one.T for one in along) + sum((by_theta * one) @ one.T for one in around)
    return _of_shapes(basis, np.asarray(found))


def volume_hessian(basis: OrderBasis) -> FloatArray:
    """Return d2V/dq_j dq_k of the volume enclosed, int psi_j.dN_k with N = r_phi x r_theta, shape (dof, dof) [m]."""
    cosine, weight = gauss_rule(2 * max(mode.degree for mode in basis.modes) + 2)
    phi = np.arccos(cosine)
    r, m, sin, cos, dphi = basis.shell.radius, basis.order, np.sin(phi), cosine, weight / np.sin(phi)
    (v, u, w), (dv, du, _) = basis.field(phi), basis.field(phi, derivative=1)
    normal = (sin * (du + v) + v * sin + u * cos + m * w, -sin * (dv - u), m * v + w * sin)  # dN/(r d amplitude)
    found = sum((one * dphi) @ changed.T for one, changed in zip((v, u, w), normal, strict=True))
    return _of_shapes(basis, np.pi * r * np.asarray(found))


def prestress_stiffness(basis: OrderBasis, loaded: LoadedShell) -> FloatArray:
    """Return the prestress of shapes of an order about the undeformed sphere, shape (dof, dof) [N/m].

    As `LoadedShell.prestress_stiffness` of axisymmetric ones, whose load it is; zero of rigid motions.
    """
    if not basis.modes:
        return np.zeros((len(basis.labels),) * 2)
    colatitude, area = loaded.elastic.rings
    forces = loaded.linear_resultants(colatitude)
    return geometric_stiffness(basis, colatitude, area, *forces) - loaded.pressure_inside * volume_hessian(basis)


def _of_shapes(basis: OrderBasis, matrix: FloatArray) -> FloatArray:
    """A matrix with exact zeros where rigid motions take part."""
    matrix[: basis.rigid, :] = matrix[:, : basis.rigid] = 0.0
    return matrix
