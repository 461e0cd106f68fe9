"""Derivatives of added mass, damping and excitation by the wetted shape, from the potentials that are solved anyway.

Hadamard's boundary formulas for axisymmetric motion (m = 0) in water of any depth. With colatitude phi as the label of
material points, ' = d/dphi, the displacements (X_i, Z_i) per unit amplitude and f_i = x (-z' X_i + x' Z_i),

    G_ij = 2 pi int f_i phi_j dphi,    A + i B/omega = -rho G,    excitation = -rho g G_iT,

where phi_j is the potential of the normal velocity w_j and phi_T that of the incident wave and the body held, w_T = 0.
If points move by (X_k, Z_k), of normal part eta and tangential part tau, the surface element and the potential on the
moving points change by

    T_ij = 2 pi {int [X_k (-z' X_i + x' Z_i) + x (-Z_k' X_i + X_k' Z_i)] phi_j dphi
                 + int f_i (tau d_s phi_j + eta w_j) dphi - f_i phi_j|_w dphi_w},    dphi_w = -Z_k/z',

the last at the waterline w, whose material points change. The potentials change, too; by reciprocity no further problem
needs to be solved:

    dG_ij = T_ij + T_ji - 2 pi int eta (d_s phi_i d_s phi_j + w_i w_j) x ds
            + 2 pi (omega^2/g) x_w delta phi_i phi_j|_w,                                delta = X_k - x' Z_k/z',
    dG_iT = T_iT - 2 pi int eta d_s phi_i d_s phi_T x ds + 2 pi (omega^2/g) x_w delta phi_i phi_T|_w.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from vsb.engine.hydro.dofs import normal_velocities
from vsb.engine.hydro.spectral.meridian import WetMeridian, unit_rule
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.meridian import Curve
from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray

Directions = Callable[[FloatArray], Curve]
"""Colatitudes (point,) [rad] -> radial and vertical displacement of the points there and their slopes by colatitude,
each (direction, point), per unit of each change of the shape."""


class ShapeDerivative(NamedTuple):
    """Coefficients of displacements of one shape, and their derivatives by changes of the shape."""

    radiation: ComplexArray  # A + i B/omega (omega, displacement, displacement) [kg]
    excitation: ComplexArray  # per wave amplitude (omega, displacement) [N/m]
    radiation_change: ComplexArray  # (omega, direction, displacement, displacement) [kg per unit of the direction]
    excitation_change: ComplexArray  # (omega, direction, displacement)


def slope_matrix(meridian: WetMeridian) -> FloatArray:
    """Return the derivatives by t, at the nodes, of the polynomials that are one at one node, shape (node, node).

    See Berrut and Trefethen, Barycentric Lagrange Interpolation (2004), section 9.
    """
    return block_diag(*(_slopes(piece.nodes) / (piece.end - piece.start) for piece in meridian.pieces))


def _slopes(nodes: int) -> FloatArray:
    """The same of one piece from 0 to 1."""
    t, weight = unit_rule(nodes)
    scale = (-1.0) ** np.arange(nodes) * np.sqrt(t * (1 - t) * weight)
    apart = t[:, None] - t + np.eye(nodes)
    found = scale / scale[:, None] / apart
    np.fill_diagonal(found, 0.0)
    np.fill_diagonal(found, -found.sum(axis=1))
    return found


def shape_derivative(problem: SpectralProblem, omegas: list[float], directions: Directions) -> ShapeDerivative:
    """Return added mass, damping and excitation at frequencies and their derivatives by changes of the wetted shape.

    Raises `ConfigError` if the displacements are of another azimuthal order than 0.

    Parameters
    ----------
    problem : SpectralProblem
        Of axisymmetric displacements. The derivatives need twice the digits of the coefficients: 32 nodes give 1e-8.
    omegas : list of float [rad/s]
    directions : callable
        How the points move; the amplitude of `Radial0` of unit radial displacement is the radius of a sphere.
    """
    if problem.order:
        raise ConfigError(f"displacements: received azimuthal order {problem.order}; shape derivatives need order 0")
    m, phi = problem.meridian, problem.potentials(omegas).swapaxes(1, 2)  # (omega, displacement and wave, node)
    p, area, w = m.points, m.areas, problem.velocities
    w_all = np.vstack([w, np.zeros(m.count)])  # the body is held in the incident wave
    slope = (phi @ slope_matrix(m).T) * (p.x / p.rate)  # by the length of the arc
    at, moved, (x_i, z_i) = m.shell.curve(p.colatitude), directions(p.colatitude), _components(problem, p.colatitude)
    normal, tangential = moved.x * p.n_x + moved.z * p.n_z, moved.x * p.n_z - moved.z * p.n_x
    turned = (moved.dx[:, None] * z_i - moved.dz[:, None] * x_i) / np.hypot(at.dx, at.dz)
    element = (moved.x[:, None] * w / p.x + turned) * area  # change of f_i dphi, (direction, displacement, node)
    phi, slope = phi[:, None], slope[:, None]  # (omega, 1, displacement and wave, node)
    followed = tangential[:, None] * slope + normal[:, None] * w_all

    edge = np.array([m.waterline])
    rim, rim_moved = m.shell.curve(edge), directions(edge)
    (x_w, _, dx_w, dz_w), (rim_x, rim_z) = rim, (values[:, 0] for values in _components(problem, edge))
    phi_w = (phi @ m.interpolation(np.zeros(1))[0])[..., None, :]  # (omega, 1, 1, displacement and wave)
    f_w = (x_w * (-dz_w * rim_x + dx_w * rim_z))[:, None]
    phi_moved, reach = -rim_moved.z[:, :, None] / dz_w, (rim_moved.x - dx_w * rim_moved.z / dz_w)[:, :, None]

    t = element @ phi.swapaxes(2, 3) + (w * area) @ followed.swapaxes(2, 3) - phi_moved * f_w * phi_w
    kinetic = (slope[:, :, :-1] * (normal * area)[:, None]) @ slope.swapaxes(2, 3)
    kinetic = kinetic + (w * (normal * area)[:, None]) @ w_all.T
    surface = (np.square(omegas) / problem.gravity)[:, None, None, None] * x_w * reach
    change = t - kinetic + surface * phi_w[..., :-1].swapaxes(2, 3) * phi_w
    change[..., :-1] += t[..., :-1].swapaxes(2, 3)
    change *= -2 * np.pi * problem.density
    whole = problem.onto @ phi[:, 0].swapaxes(1, 2)
    gravity = problem.gravity
    return ShapeDerivative(whole[..., :-1], gravity * whole[..., -1], change[..., :-1], gravity * change[..., -1])


def _components(problem: SpectralProblem, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radial and vertical displacement per unit amplitude at points, each (displacement, point) [-]."""
    nowhere, one, none = np.zeros((2, len(colatitude))), np.ones(len(colatitude)), np.zeros(len(colatitude))
    return (
        normal_velocities(problem.displacements, colatitude, nowhere, np.array([one, none])),
        normal_velocities(problem.displacements, colatitude, nowhere, np.array([none, one])),
    )
