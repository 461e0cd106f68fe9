"""Mass and stiffness of single Legendre degrees of a sphere, over radial and meridional amplitudes V, U.

Degrees n are orthogonal, so each has a 2 x 2 block of its own in v = V P_n(cos phi), u = U dP_n/dphi. All blocks take
one degree or many, shape (degree,), and return shape (2, 2) or (degree, 2, 2).
"""

import numpy as np

from vsb.engine.shell.shell import Shell
from vsb.tools.arrays import FloatArray, IntArray

Degrees = int | IntArray


def membrane_block(shell: Shell, degree: Degrees) -> FloatArray:
    """Return the membrane stiffness of (V, U) of degrees [N/m].

    From U_m = pi E h/(1-nu^2) int (ef^2 + et^2 + 2 nu ef et) r^2 sin phi dphi, Eqs. 21-23, with
    ef = (u' + v)/r, et = (u cot phi + v)/r and int P_n^2 sin phi dphi = 2/(2n+1). The cross term of Eq. 61 is kept;
    Eq. 63 prints squares in its place, which does not give Table I.
    """
    return shell.membrane_stiffness * _stretched(degree, shell.poisson_ratio)


def bending_block(shell: Shell, degree: Degrees) -> FloatArray:
    """Return the bending stiffness of (V, U) of degrees [N/m].

    From U_b = pi D int (kf^2 + kt^2 + 2 nu kf kt) r^2 sin phi dphi with kf = -(v'' - u')/r^2,
    kt = -cot phi (v' - u)/r^2. The paper's stiffness (Eq. 63) has no bending.
    """
    nu, lam = shell.poisson_ratio, _product(degree)
    return shell.bending_stiffness / shell.radius**2 * (lam - 1 + nu) * _turned(degree)


def tension_block(degree: Degrees) -> FloatArray:
    """Return the stiffness of (V, U) of degrees by a membrane force of 1 N/m in all directions [-].

    int (ef^2 + et^2 + ((v' - u)/r)^2) dA: the geometric stiffness of a uniform tension.
    """
    return _stretched(degree, 0.0) + _turned(degree)


def mass_block(shell: Shell, degree: Degrees) -> FloatArray:
    """Return the mass of (V, U) of degrees, 2 pi rho h r^2 2/(2n+1) diag(1, n(n+1)) [kg]."""
    scale = _norm(degree) * shell.density * shell.thickness * shell.radius**2
    return np.asarray(scale * _of_entries(1.0, 0.0, _product(degree)))


def twisted(degree: IntArray) -> FloatArray:
    """Return the stiffness of the twist of degrees by a shear stiffness of 1 N/m, shape (degree,) [-].

    (n-1)(n+2) int |T grad S|^2 dA/r^2, the same of the tension p r/2 of an internal pressure p; n = 1 turns the sphere.
    """
    turns = degree * (degree + 1.0)
    return np.asarray((turns - 2) * turns * _norm(degree)[..., 0, 0])


def twisting_mass(shell: Shell, degree: IntArray) -> FloatArray:
    """Return the mass of the twist of degrees, that of their displacements along the surface, shape (degree,) [kg]."""
    return np.asarray(mass_block(shell, degree)[..., 1, 1])


def _product(degree: Degrees) -> FloatArray:
    """The factor n (n + 1) of blocks."""
    n = np.asarray(degree, dtype=float)[..., None, None]
    return np.asarray(n * (n + 1))


def _norm(degree: Degrees) -> FloatArray:
    """2 pi int P_n^2 sin phi dphi, as a factor of blocks."""
    return np.asarray(4 * np.pi / (2 * np.asarray(degree, dtype=float)[..., None, None] + 1))


def _of_entries(radial: FloatArray | float, mixed: FloatArray | float, meridional: FloatArray | float) -> FloatArray:
    """Symmetric blocks of entries that are factors of blocks themselves."""
    one, two = np.diag([1.0, 0.0]), np.diag([0.0, 1.0])
    return np.asarray(radial * one + mixed * (1 - np.eye(2)) + meridional * two)


def _stretched(degree: Degrees, nu: float) -> FloatArray:
    """2 pi int (ef^2 + et^2 + 2 nu ef et) r^2 sin phi dphi, a quadratic form of (V, U)."""
    lam = _product(degree)
    return _norm(degree) * _of_entries(2 * (1 + nu), -lam * (1 + nu), lam * (lam - 1 + nu))


def _turned(degree: Degrees) -> FloatArray:
    """2 pi int (v' - u)^2 sin phi dphi, a quadratic form of (V, U)."""
    lam = _product(degree)
    return _norm(degree) * _of_entries(lam, -lam, lam)
