"""Mass and stiffness of a shell on any closed meridian, by quadrature on its curvatures, and its natural modes.

The shapes are those of the sphere carried over to the meridian x(phi), z(phi): v = P_n(cos phi) along e_r and
u = dP_n/dphi along e_phi, the directions of the sphere at the same angle, so that n = 1 with v = u remains rigid heave.
With the tangent t and the normal n of the meridian and ds = |(x', z')| dphi, a displacement s has

    e_s = t.ds/ds,  e_theta = s_x/x,  beta = n.ds/ds,  kappa_s = -d beta/ds,  kappa_theta = -beta dx/ds /x

(Sanders' linear theory of thin shells of revolution), and the energy

    pi int [C (e_s^2 + e_theta^2 + 2 nu e_s e_theta) + D (kappa_s^2 + kappa_theta^2 + 2 nu kappa_s kappa_theta)] x ds.

On the sphere these are the strains and curvatures of `vsb.engine.shell.modes`.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from vsb.engine.shell.meridian import ClosedMeridian, bend, curve, length, meridian_rule
from vsb.engine.shell.shell import Shell
from vsb.errors import ConvergenceError
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


CONVERGED = 1e-11
"""Relative change of a matrix at which its quadrature is converged.

Round-off of sums over the thousand points and more that long capsules need is 1e-12 to 4e-12.
"""
MOST_POINTS = 4096
"""Points of quadrature at most."""


@dataclass(frozen=True)
class Strains:
    """Strains, rotation and changes of curvature of displacements of unit amplitude, each (displacement, point)."""

    meridional: FloatArray  # [1/m]
    hoop: FloatArray
    rotation: FloatArray
    meridional_bending: FloatArray  # [1/m^2]
    hoop_bending: FloatArray


class Displacements(NamedTuple):
    """Displacements along e_r and e_phi and their derivatives by the angle, each (displacement, point) [-]."""

    v: FloatArray
    dv: FloatArray
    ddv: FloatArray
    u: FloatArray
    du: FloatArray
    ddu: FloatArray


def of_degrees(degree: int, phi: FloatArray) -> Displacements:
    """Return radial displacements of degrees 0..degree and meridional ones of 1..degree.

    Parameters
    ----------
    phi : ndarray, shape (point,) [rad]
        Between the poles.
    """
    p, dp, ddp = legendre(degree, phi)
    n, sin, cos = np.arange(degree + 1)[:, None], np.sin(phi), np.cos(phi)
    dddp = dp / sin**2 - cos / sin * ddp - n * (n + 1) * dp  # Legendre's equation, differentiated
    none = np.zeros_like(p[1:])
    radial = [np.concatenate([part, none]) for part in (p, dp, ddp)]
    meridional = [np.concatenate([0 * p, part[1:]]) for part in (dp, ddp, dddp)]
    return Displacements(*radial, *meridional)


def strains(meridian: ClosedMeridian, phi: FloatArray, of: Displacements) -> Strains:
    """Return the strains of a shell by displacements.

    Parameters
    ----------
    phi : ndarray, shape (point,) [rad]
        Between the poles.
    of : Displacements
        At these points.
    """
    at, (ddx, ddz), sin, cos = curve(meridian, phi), bend(meridian, phi), np.sin(phi), np.cos(phi)
    along_r, along_phi = of.dv - of.u, of.du + of.v  # of ds/dphi
    turn_r, turn_phi = of.ddv - of.du - along_phi, of.ddu + of.dv + along_r  # of its own derivative
    slope = length(at.dx, at.dz)
    tangent = at.dx * sin + at.dz * cos, at.dx * cos - at.dz * sin  # along e_r and e_phi, times the slope
    normal = at.dx * cos - at.dz * sin, -(at.dz * cos + at.dx * sin)
    following = ddx * cos - ddz * sin, -(ddz * cos + ddx * sin)  # of the normal, in fixed directions
    rotation = (along_r * normal[0] + along_phi * normal[1]) / slope**2
    stretched = (at.dx * ddx + at.dz * ddz) / slope**2
    change = turn_r * normal[0] + turn_phi * normal[1] + along_r * following[0] + along_phi * following[1]
    turned = change / slope**2 - 2 * stretched * rotation
    return Strains(
        (along_r * tangent[0] + along_phi * tangent[1]) / slope**2,
        (of.v * sin + of.u * cos) / at.x,
        rotation,
        -turned / slope,
        -rotation * at.dx / (at.x * slope),
    )


class Matrices(NamedTuple):
    """Mass [kg], membrane and bending stiffness [N/m] over radial, then meridional displacements, by degree."""

    mass: FloatArray
    membrane: FloatArray
    bending: FloatArray


@lru_cache(maxsize=32)
def matrices(shell: Shell, degree: int) -> Matrices:
    """Return mass and stiffness over radial displacements of degrees 0..degree and meridional ones of 1..degree.

    The points of the quadrature are doubled until nothing changes. Raises `ConvergenceError` if `MOST_POINTS` do not
    suffice.
    """
    points = 32 + 2 * (degree + shell.meridian.terms)
    coarse = _integrated(shell, degree, points)
    while points < MOST_POINTS:
        points *= 2
        fine = _integrated(shell, degree, points)
        if all(_near(a, b) for a, b in zip(coarse, fine, strict=True)):
            for matrix in fine:
                matrix.setflags(write=False)
            return fine
        coarse = fine
    raise ConvergenceError(
        f"device.shape: the energy of its shell is not integrated by {MOST_POINTS} points; needs a rounder meridian"
    )


def _near(a: FloatArray, b: FloatArray) -> bool:
    """Whether two positive semidefinite matrices are the same to `CONVERGED`."""
    size = np.sqrt(np.abs(np.diag(b)))
    return bool(np.all(np.abs(a - b) <= CONVERGED * (np.outer(size, size) + 1e-300) + 1e-15 * np.abs(b).max()))


def _integrated(shell: Shell, degree: int, points: int) -> Matrices:
    """The same by so many points of quadrature."""
    found, area, mass = _of_unit_wall(shell.meridian, degree, points)
    membrane = shell.membrane_stiffness * energy(found.meridional, found.hoop, shell.poisson_ratio, area)
    bending = shell.bending_stiffness * energy(found.meridional_bending, found.hoop_bending, shell.poisson_ratio, area)
    return Matrices(shell.density * shell.thickness * mass, membrane, bending)


@lru_cache(maxsize=8)
def _of_unit_wall(meridian: ClosedMeridian, degree: int, points: int) -> tuple[Strains, FloatArray, FloatArray]:
    """For walls of any material: strains and areas (point,) [m^2] at the points, mass of one of unit mass per area."""
    phi, dphi = meridian_rule(meridian.junctions, points)
    at = curve(meridian, phi)
    area = 2 * np.pi * at.x * length(at.dx, at.dz) * dphi
    p, dp, _ = legendre(degree, phi)
    radial, meridional = (p * area) @ p.T, (dp[1:] * area) @ dp[1:].T
    none = np.zeros((degree + 1, degree))
    return strains(meridian, phi, of_degrees(degree, phi)), area, np.block([[radial, none], [none.T, meridional]])


def energy(a: FloatArray, b: FloatArray, ratio: float, area: FloatArray) -> FloatArray:
    """Return int (a a + b b + nu (a b + b a)) dA of strains or curvatures a, b of displacements, by quadrature.

    Parameters
    ----------
    a, b : ndarray, shape (displacement, point)
    ratio : float
        nu [-].
    area : ndarray, shape (point,) [m^2]
    """
    mixed = (a * area) @ b.T
    return np.asarray((a * area) @ a.T + (b * area) @ b.T + ratio * (mixed + mixed.T))


def heave(degree: int) -> FloatArray:
    """Return rigid heave in terms of the displacements of `matrices`, v = P_1 and u = dP_1/dphi."""
    shares = np.zeros(2 * degree + 1)
    shares[[1, degree + 1]] = 1.0
    return shares


class NaturalModes(NamedTuple):
    """Natural frequencies of a shell in vacuo, ascending (mode,) [rad/s], and their shapes (displacement, mode) [-]."""

    omega: FloatArray
    shapes: FloatArray


def natural_modes(shell: Shell, degree: int) -> NaturalModes:
    """Return the axisymmetric natural modes of a shell of any meridian but rigid heave, by Ritz' method.

    Parameters
    ----------
    degree : int
        Highest degree of the displacements; at least 1. There are 2 * degree modes.

    Notes
    -----
    K s = omega^2 M s among displacements that are orthogonal to rigid heave. Membrane and bending stiffness differ by
    (h/r)^2; both are solved together in units of the mass.
    """
    mass, membrane, bending = matrices(shell.of_unit_material, degree)  # the modes are the same
    held = np.linalg.qr(np.column_stack([mass @ heave(degree), np.eye(len(mass))]))[0][:, 1:]
    squares, shapes = eigh(held.T @ (membrane + bending) @ held, held.T @ mass @ held)
    scale = np.sqrt(shell.young_modulus / shell.density)
    return NaturalModes(scale * np.sqrt(np.maximum(squares, 0.0)), held @ shapes)


def legendre(degree: int, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return P_n(cos phi) and its first and second derivatives by phi for n = 0..degree.

    Parameters
    ----------
    colatitude : ndarray, shape (point,) [rad]

    Returns
    -------
    tuple of ndarray, each shape (degree + 1, point) [-]
    """
    cos, n = np.cos(colatitude), np.arange(degree + 1.0)[:, None]
    p = polynomials(cos, degree)
    by_cos = slopes_of_polynomials(degree) @ p
    return p, -np.sin(colatitude) * by_cos, cos * by_cos - n * (n + 1) * p  # by Legendre's equation


def polynomials(x: FloatArray, degree: int) -> FloatArray:
    """Return Legendre's P_n(x) for n = 0..degree, shape (degree + 1, point); quicker than NumPy's `legvander`."""
    p = np.empty((degree + 1, len(x)), dtype=x.dtype)
    p[0] = 1.0
    p[1:2] = x
    for n in range(2, degree + 1):
        p[n] = (p[n - 1] * x * (2 * n - 1) - p[n - 2] * (n - 1)) / n
    return p


@lru_cache
def slopes_of_polynomials(degree: int) -> FloatArray:
    """Return derivatives of P_n in terms of P_k, 2k + 1 for k = n - 1, n - 3, ..., shape (n, k)."""
    n = np.arange(degree + 1)
    below = n[:, None] - n
    return np.where((below > 0) & (below % 2 == 1), 2.0 * n + 1, 0.0)
