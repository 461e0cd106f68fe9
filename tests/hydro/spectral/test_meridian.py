import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.engine.hydro.spectral.meridian import WetMeridian, log_rule, ring
from vsb.engine.shell.deformed import DeformedShell, rigid_sphere
from vsb.engine.shell.meridian import capsule
from vsb.engine.shell.modes import Mode, ModeBasis
from vsb.engine.shell.shell import Shell


@pytest.mark.parametrize("rest", [None, capsule(1.0, 0.5)])
def test_chords_have_all_digits_however_short_they_are(rest):
    """A short one is the slope times its length, a long one the difference of coordinates."""
    shell = Shell(1.0, 0.01, 1e7, 0.3, 1100.0, rest)
    basis = ModeBasis(shell, (Mode("Radial3", 3, 1.0, 0.0),), 1.0, bending=True)
    wet = WetMeridian(DeformedShell(basis, 0.1, np.array([0.0, 0.02])), 8)
    t, short = np.linspace(0.1, 0.9, 5), 1e-12
    points, low = wet.at(t), wet.at(np.array([0.05]))
    length = np.hypot(*wet.chord(t, np.full(5, short)))
    assert length == pytest.approx(points.rate / points.x * short, rel=1e-10)
    for found, apart in zip(wet.chord(np.full(5, 0.05), t - 0.05), (points.x - low.x, points.z - low.z), strict=True):
        assert found == pytest.approx(apart, rel=1e-12)


def test_the_rule_for_logarithms_is_exact():
    u, w = log_rule()
    assert np.all(w > 0)
    for p in range(10):
        assert w @ u**p == pytest.approx(1 / (p + 1), rel=1e-13)
        assert w @ (u**p * np.log(u)) == pytest.approx(-1 / (p + 1) ** 2, rel=1e-12)


def source_and_image(points, order, depth):
    """Potential of order m of a ring inside, R^m over r^(2m+1), and of its image in a wall at the surface; w there."""
    value, velocity = 0.0, 0.0
    for z0 in (depth, -depth):
        r2 = points.x**2 + (points.z - z0) ** 2
        outward = points.n_x * points.x + points.n_z * (points.z - z0)
        each = points.x**order * r2 ** (-order - 0.5)
        value = value + each
        velocity = velocity + each * (order * points.n_x / points.x - (2 * order + 1) * outward / r2)
    return value, velocity


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_known_potential_flow_satisfies_the_integral_equation(order):
    """A multipole inside the raised sphere and its image: the limit of zero frequency on the right side of a wall."""
    errors = []
    for nodes in (8, 12, 16, 24, 32):
        wet = WetMeridian(rigid_sphere(1.0, 0.3), nodes, order)
        exact, velocity = source_and_image(wet.points, order, -0.3)
        single, double = wet.rankine.sum(axis=0)
        phi = wet.solve(double + 0j, (-single @ velocity)[:, None] + 0j)[:, 0]
        errors.append(np.abs(phi - exact).max() / np.abs(exact).max())
    assert all(later < earlier / 4 for earlier, later in itertools.pairwise(errors)), errors
    assert errors[-1] < 3e-8


NODE, WEIGHT = np.polynomial.legendre.leggauss(24)
EDGES = np.pi * np.append(0.0, 2.0 ** np.arange(-40, 1))
ANGLE = ((EDGES[1:] + EDGES[:-1])[:, None] / 2 + np.diff(EDGES)[:, None] / 2 * NODE).ravel()
ARC = (np.diff(EDGES)[:, None] / 2 * WEIGHT).ravel()


def by_quadrature(order, source, apart, height):
    """p, c, d by Gauss' rule on intervals that halve towards the near side; its absolute error is that of order 0."""
    versine = 2 * np.sin(ANGLE / 2) ** 2
    r = np.sqrt(apart**2 + height**2 + 2 * source * (source + apart) * versine)
    wave = 2 * ARC * np.cos(order * ANGLE)
    return np.array([wave @ (1 / r), wave @ (-(source + apart) * versine / r**3), wave @ (1 / r**3)])


def of_point(order, source, apart, height):
    return np.array([each.item() for each in ring(order, *(np.array([a]) for a in (source, apart, height)))])


offsets = st.floats(-8.0, 1.0).map(lambda e: 10.0**e)


@given(st.integers(0, 4), st.floats(0.05, 5.0), offsets, st.floats(-np.pi, np.pi))
def test_rings_are_integrals_over_the_azimuth(order, source, ratio, angle):
    apart = max(source * ratio * np.cos(angle), -source)
    height = source * ratio * np.sin(angle)
    if np.hypot(apart, height) < 1e-9 * source:
        return
    exact, size = (by_quadrature(m, source, apart, height) for m in (order, 0))
    size[1] = size[0] / source
    assert np.all(np.abs(of_point(order, source, apart, height) - exact) < 1e-11 * np.abs(size))


@pytest.mark.parametrize("order", [1, 2, 5])
def test_far_field_is_the_multipole_of_the_order(order):
    """p -> 2 pi (1/2)_m/m! (R R')^m/s^(2m+1): exact to relative, not absolute, round-off."""
    source, height = 1.0, 1e4
    p, _, d = of_point(order, source, 0.0, height)
    factor = 2 * np.pi * np.prod((np.arange(order) + 0.5) / (np.arange(order) + 1))
    assert p == pytest.approx(factor / height ** (2 * order + 1), rel=1e-7)
    assert d == pytest.approx((2 * order + 1) * factor / height ** (2 * order + 3), rel=1e-7)
