"""Stiffness of a loaded shell about its axisymmetric rest shape against shapes of azimuthal orders m >= 1.

The second variation of the same potential as `vsb.engine.shell.loaded`: with the deformed meridian's tangent
r_phi = r [beta e_r + (1 + e_phi) e_phi] and r_theta = r sin(phi) (1 + e_theta) e_theta a displacement psi changes the
Green strains by

    E_phi = r_phi.psi_phi/r^2,  E_theta = r_theta.psi_theta/(r sin)^2,  2 E_phitheta = (r_phi.psi_theta +
    r_theta.psi_phi)/(r^2 sin),

to second order by half the squared gradients, and the normal by dN = psi_phi x r_theta + r_phi x psi_theta. Of the
directions along the surface the gradients of a potential alone are among the shapes (`vsb.engine.shell.orders`): the
least stiffness is that of these, at least that of all.
"""

import numpy as np
from scipy.linalg import eigh

from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.shell.modes import Mode, strain_shapes
from vsb.engine.shell.orders import Ballast, OrderBasis, geometric_stiffness
from vsb.engine.shell.shell import gauss_rule
from vsb.tools.arrays import FloatArray


def azimuthal_stiffness(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """Return the tangent stiffness of shell, inner pressure and water, shape (dof, dof) [N/m]; 0 of rigid motions.

    Parameters
    ----------
    basis : OrderBasis
        Of the sphere.
    q : ndarray, shape (dof,) [m]
        Its heave and axisymmetric modes at rest.
    """
    stiffness = _elastic(basis, loaded, q) + _pressure(basis, loaded, q) + _water(basis, loaded, q)
    stiffness[: basis.rigid, :] = stiffness[:, : basis.rigid] = 0.0
    return np.asarray((stiffness + stiffness.T) / 2)


def _elastic(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """The wall's: material and geometric."""
    elastic, wall = loaded.elastic, basis.shell.wall
    colatitude, area = elastic.rings
    meridional, hoop, rotation = (1 + q @ elastic.shapes[0], 1 + q @ elastic.shapes[1], q @ elastic.shapes[2])
    r, m, sin, cos = basis.shell.radius, basis.order, np.sin(colatitude), np.cos(colatitude)
    (v, u, w), (dv, du, dw) = basis.field(colatitude), basis.field(colatitude, derivative=1)
    kappa, around, twist = basis.curvatures(colatitude)
    normal = (
        (meridional * (du + v) + rotation * (dv - u)) / r,
        hoop * (m * w + v * sin + u * cos) / (r * sin),
        kappa,
        around,
    )
    sheared = -meridional * (m * u + w * cos) - rotation * (m * v + w * sin)
    shear = (sheared / (r * sin) + hoop * dw / r, twist)
    moduli, half = wall.moduli(elastic.deformation(q)), area / 2  # cos^2 and sin^2 around
    found = geometric_stiffness(basis, colatitude, area, *elastic.resultants(q))
    for strains, by in ((normal, moduli.normal), (shear, moduli.shear)):
        for one, row in zip(strains, half * by, strict=True):
            found = found + one @ sum(c * other for c, other in zip(row, strains, strict=True)).T
    return np.asarray(found)


def _turned(
    basis: OrderBasis, loaded: LoadedShell, q: FloatArray, phi: FloatArray
) -> tuple[FloatArray, tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """psi.N, psi and the change dN of N = r_phi x r_theta by each amplitude along e_r, e_phi, e_theta."""
    e, t, b = strain_shapes(loaded.basis, phi)
    r, m, sin, cos = basis.shell.radius, basis.order, np.sin(phi), np.cos(phi)
    across, along, around = r * (q @ b), r * (1 + q @ e), r * sin * (1 + q @ t)
    (v, u, w), (dv, du, _) = basis.field(phi), basis.field(phi, derivative=1)
    turn = m * w + v * sin + u * cos
    changed = (
        (du + v) * around + along * turn,
        -(dv - u) * around - across * turn,
        along * (m * v + w * sin) - across * (m * u + w * cos),
    )
    return around * (along * v - across * u), (v, u, w), changed


def _pressure(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """That of the pressure inside, -p d2V; trapped gas adds nothing, for the volume does not change."""
    cosine, weight = gauss_rule(2 * (basis.highest_degree + loaded.basis.highest_degree) + 16)
    phi = np.arccos(cosine)
    _, psi, changed = _turned(basis, loaded, q, phi)
    dphi = weight / np.sin(phi)
    volume = sum((one * dphi) @ other.T for one, other in zip(psi, changed, strict=True))
    return np.asarray(-np.pi * loaded.pressure(q) * volume)


def _water(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """That of the water, -rho g int [psi_z psi.N + z psi.dN] over the wet shell."""
    shape = DeformedShell(loaded.basis, loaded.centre_height, q)
    node, weight = gauss_rule(2 * (basis.highest_degree + loaded.basis.highest_degree) + 30)
    found = np.zeros((len(basis.labels),) * 2)
    for a, b in shape.wet_segments:
        phi, dphi = (a + b) / 2 + (b - a) / 2 * node, (b - a) / 2 * weight
        across, psi, changed = _turned(basis, loaded, q, phi)
        raised = psi[0] * np.cos(phi) - psi[1] * np.sin(phi)
        height = shape.curve(phi).z * dphi
        found += (across * dphi) @ raised.T
        found += sum((one * height) @ other.T for one, other in zip(psi, changed, strict=True))
    return -np.pi * loaded.water_density * loaded.gravity * found


def complete_order(loaded: LoadedShell, order: int, degree: int) -> OrderBasis:
    """Return all gradient shapes of an order to a degree, radial and meridional ones apart."""
    modes = []
    for n in range(max(2, order), degree + 1):
        modes += [Mode(f"Radial{n}c{order}", n, 1.0, 0.0), Mode(f"Meridional{n}c{order}", n, 0.0, 1 / n)]
    shell = loaded.basis.shell
    return OrderBasis(shell, order, tuple(modes), Ballast(loaded.basis.total_mass, 0.0, 0.0), bending=True)


def softest_order(loaded: LoadedShell, q: FloatArray, orders: int, degree: int) -> tuple[float, int]:
    """Return the least stiffness about a rest shape over that of the unloaded shell, and its order, of 2 to `orders`.

    Below 0 the shell buckles or wrinkles into it.
    """
    found = []
    for order in range(2, orders + 1):
        basis = complete_order(loaded, order, degree)
        stiffness = azimuthal_stiffness(basis, loaded, q)
        found.append((float(eigh(stiffness, basis.stiffness, eigvals_only=True, subset_by_index=[0, 0])[0]), order))
    return min(found)
