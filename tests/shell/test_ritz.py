"""Shells of any meridian by the Ritz method, compared with the closed form of the sphere and with conical finite elements."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import eigh

from vsb.engine.shell import ritz
from vsb.engine.shell.meridian import RestMeridian, bend, capsule, curve, spheroid
from vsb.engine.shell.ritz import bending_block, heave, mass_block, matrices, membrane_block, natural_modes
from vsb.engine.shell.shell import Shell

SEED = Shell(radius=2.0, thickness=0.01, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
OBLATE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))
PROLATE = Shell(2.0, 0.05, 10e6, 0.3, 2700.0, spheroid(2.0, 6.0))
EGG = RestMeridian((1.0, 0.05), (0.0, 1.3, 0.05))
CAPSULE = Shell(1.0, 0.02, 10e6, 0.3, 2700.0, capsule(1.0, 1.0))


def _blocks(block, shell, degree):
    """A closed-form matrix of the sphere over radial, then meridional displacements."""
    found = np.zeros((2 * degree + 1, 2 * degree + 1))
    for n in range(degree + 1):
        at = [n, degree + n] if n else [0]
        found[np.ix_(at, at)] = block(shell, n)[: len(at), : len(at)]
    return found


@pytest.mark.parametrize("degree", [1, 6])
def test_matrices_of_the_sphere_match_the_closed_form(degree):
    for found, block in zip(matrices(SEED, degree), (mass_block, membrane_block, bending_block), strict=True):
        exact = _blocks(block, SEED, degree)
        assert np.abs(found - exact).max() < 1e-11 * np.abs(exact).max()
        size = np.sqrt(np.outer(*2 * (np.diag(exact) + 1e-9 * exact.max(),)))
        assert np.abs((found - exact) / size).max() < 1e-10


@pytest.mark.parametrize("shell", [OBLATE, PROLATE, CAPSULE])
def test_rigid_heave_has_no_strain_and_the_mass_of_the_shell(shell):
    mass, membrane, bending = matrices(shell, 8)
    rigid = heave(8)
    assert rigid @ mass @ rigid == pytest.approx(shell.mass, rel=1e-12)
    assert np.abs(membrane @ rigid).max() < 1e-12 * membrane.max()
    assert np.abs(bending @ rigid).max() < 1e-12 * bending.max()
    modes = natural_modes(shell, 8)
    assert np.abs(rigid @ mass @ modes.shapes).max() < 1e-11 * np.sqrt(shell.mass)
    assert (modes.omega > 0).all()


def test_uniform_swelling_has_membrane_energy_only():
    """A displacement proportional to the position stretches all lines alike and rotates none."""
    terms = np.zeros(2 * 6 + 1)
    meridian = spheroid(2.0, 2.6)  # x sin + z cos along e_r, x cos - z sin along e_phi: degrees 0 and 2
    a, c = 2.0, 1.3
    terms[0], terms[2], terms[6 + 2] = (2 * a + c) / 3, 2 * (c - a) / 3, (c - a) / 3
    shell = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, meridian)
    _, membrane, bending = matrices(shell, 6)
    assert terms @ membrane @ terms == pytest.approx(
        2 * (1 + 0.3) * shell.membrane_stiffness * meridian.area, rel=1e-12
    )
    assert abs(terms @ bending @ terms) < 1e-12 * bending.max()
    phi = np.linspace(0.1, 3.0, 7)
    found = ritz.strains(meridian, phi, ritz.of_degrees(6, phi))
    assert terms @ found.meridional == pytest.approx(1.0)
    assert terms @ found.hoop == pytest.approx(1.0)
    assert np.abs(terms @ found.rotation).max() < 1e-12


MODES = 6
THROUGH = 3
"""Degree of the displacements through the thickness."""


def shell(meridian, thickness):
    """A shell of E = 10 MPa, nu = 0.3 and 2700 kg/m^3 around a meridian."""
    return Shell(meridian.radius, thickness, 10e6, 0.3, 2700.0, meridian)


def shapes(x, degree):
    """Legendre polynomials and their derivatives, (degree, point)."""
    one = np.eye(degree + 1)
    slopes = [legendre.legval(x, legendre.legder(one[n])) for n in range(degree + 1)]
    return legendre.legvander(x, degree).T, np.array(slopes)


def solid(of, degree):
    """Axisymmetric natural frequencies of the solid between the faces of a shell, rigid heave first [rad/s]."""
    along, through = (legendre.leggauss(count) for count in (degree + 54, THROUGH + 2))
    phi, s = (part.ravel() for part in np.meshgrid(np.arccos(along[0]), through[0], indexing="ij"))
    at, (ddx, ddz), half = curve(of.meridian, phi), bend(of.meridian, phi), of.thickness / 2
    slope = np.hypot(at.dx, at.dz)
    turned = (at.dx * ddz - at.dz * ddx) / slope**3  # of the normal (-z', x')/slope along the tangent
    x = at.x - half * s * at.dz / slope
    dx, dz = (1 - half * s * turned) * at.dx, (1 - half * s * turned) * at.dz  # by phi, then by s
    across, up = -half * at.dz / slope, half * at.dx / slope
    jacobian = dx * up - across * dz

    (p, dp), (q, dq) = shapes(np.cos(phi), degree), shapes(s, THROUGH)
    sin, cos, dp = np.sin(phi), np.cos(phi), -np.sin(phi) * dp

    def each(a, b):
        return (a[:, None] * b).reshape(-1, len(phi))

    def gradient(by_phi, by_s):
        return (by_phi * up - by_s * dz) / jacobian, (by_s * dx - by_phi * across) / jacobian

    w, u = each(p, q), each(sin * p, q)  # along the axis, and across, where it vanishes on the axis
    (wx, wz), (ux, uz) = gradient(each(dp, q), each(p, dq)), gradient(each(cos * p + sin * dp, q), each(sin * p, dq))
    none = np.zeros_like(w)
    radial, axial, hoop = np.r_[ux, none], np.r_[none, wz], np.r_[u / x, none]
    shear = np.r_[uz, wx]
    volume = 2 * np.pi * x * np.abs(jacobian) / sin * np.outer(along[1], through[1]).ravel()
    e, nu = of.young_modulus, of.poisson_ratio
    pressure, rigidity = e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))

    def product(a):
        return (a * volume) @ a.T

    stiffness = pressure * product(radial + axial + hoop) + rigidity * (
        2 * (product(radial) + product(axial) + product(hoop)) + product(shear)
    )
    mass = of.density * (product(np.r_[u, none]) + product(np.r_[none, w]))
    size = np.sqrt(np.outer(np.diag(mass), np.diag(mass)))
    return np.sqrt(np.abs(eigh(stiffness / size, mass / size, eigvals_only=True)))


def test_frequencies_of_a_thin_capsule_are_those_of_the_solid():
    """Where its curvature jumps both follow with a power of the degree; shear and rotation lower those of the solid."""
    thin = shell(capsule(1.0, 1.0), 0.02)
    apart = solid(thin, 50)[1 : 1 + MODES] / natural_modes(thin, 60).omega[:MODES] - 1
    assert np.all((apart < 0) & (apart > -1.2e-3))
    assert abs(apart[0]) < 1e-4


@pytest.mark.parametrize(("meridian", "thickness"), [(spheroid(2.0, 3.0), 0.04), (EGG, 0.03)])
def test_a_thin_shell_is_the_limit_of_the_solid(meridian, thickness):
    """Apart by the square of the thickness in the lowest mode; the next ones by a little less than that, for they turn
    from membrane to bending somewhere along the meridian; never by more than shear and rotation of a solid's sections.
    """
    thick, thin = (
        solid(shell(meridian, h), 26)[1 : 1 + MODES] / natural_modes(shell(meridian, h), 30).omega[:MODES] - 1
        for h in (thickness, thickness / 2)
    )
    order = np.log2(thick / thin)
    assert order[0] == pytest.approx(2.0, abs=0.15)
    assert np.all((order > 1.4) & (order < 2.3))
    assert np.all((thin < 0) & (thin > -1.2e-3))
    assert abs(thin[0]) < 3e-5
