"""Shells of revolution held to three-dimensional elasticity, which knows no strains or curvatures of a shell.

Ritz' method in the displacements of the solid, as Kang and Leissa (2008) for ellipsoids: polynomials along the meridian
and through the thickness, energy of linear elasticity in cylindrical coordinates. A thin shell is its limit.
"""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import eigh
from scipy.optimize import brentq

from vsb.shell.curve import bend, curve
from vsb.shell.ritz import natural_modes
from vsb.shell.sphere import Shell
from vsb.study.meridian import capsule, spheroid

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


def test_the_solid_breathes_as_the_exact_hollow_sphere():
    """Of u = d/dr [(A sin kr + B cos kr)/r] no stress on either face (Lamb 1882): to the (h/r)^8 of cubics through it."""
    of = shell(spheroid(2.0, 4.0), 0.19)
    nu = of.poisson_ratio
    speed = np.sqrt(of.young_modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu) * of.density))
    ratio = 4 * (1 - 2 * nu) / (2 * (1 - nu))  # 4 mu over lambda + 2 mu

    def stress(k, r):
        """Over lambda + 2 mu: -k^2 f - (4 mu) f'/r of f = sin kr/r and cos kr/r."""
        f = np.sin(k * r) / r, np.cos(k * r) / r
        df = (k * np.cos(k * r) - f[0]) / r, (-k * np.sin(k * r) - f[1]) / r
        return [-(k**2) * a - ratio * b / r for a, b in zip(f, df, strict=True)]

    def both(k):
        inner, outer = stress(k, 2.0 - 0.095), stress(k, 2.0 + 0.095)
        return inner[0] * outer[1] - inner[1] * outer[0]

    thin = np.sqrt(2 * of.young_modulus / ((1 - nu) * of.density)) / 2.0
    exact = speed * brentq(both, 0.98 * thin / speed, 1.02 * thin / speed, xtol=1e-15)
    assert np.abs(solid(of, 12) / exact - 1).min() < 1e-8


def test_the_solid_moves_as_a_rigid_one():
    found = solid(shell(spheroid(2.0, 3.0), 0.04), 12)
    assert found[0] < 1e-4 * found[1]


@pytest.mark.parametrize(
    ("meridian", "thickness"),
    [
        (spheroid(2.0, 4.0), 0.04),
        (spheroid(2.0, 3.0), 0.04),
        (spheroid(2.0, 2.5), 0.02),
        (spheroid(2.0, 6.0), 0.04),
        (capsule(1.0, 1.0), 0.04),
    ],
)
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
