import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.hydro.spectral.rings import _FAR, ring

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


@pytest.mark.parametrize("order", [1, 2, 3, 6])
def test_both_branches_agree_where_they_meet(order):
    """The ratio q of the two distances decides; just above and below it nothing but q may differ."""
    source, height = 1.3, 0.0
    apart = source * (_FAR - 1)  # q of a point in the ring's plane is its radius in terms of the ring's
    above, below = (of_point(order, source, apart * (1 + e), height) for e in (-1e-13, 1e-13))
    assert above == pytest.approx(below, rel=1e-11)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_singularity_is_logarithmic(order):
    """p -> 2/R (log(8R/r2) - 2 sum_{j<=m} 1/(2j - 1)), d -> 2/(R r2^2); the next term is r2/R smaller."""
    source = 0.7
    harmonic = 2 * sum(1 / (2 * j - 1) for j in range(1, order + 1))
    errors = []
    for distance in (1e-3, 1e-5, 1e-7):
        p, _, d = of_point(order, source, 0.6 * distance, 0.8 * distance)
        errors.append(abs(p * source / 2 - np.log(8 * source / distance) + harmonic))
        assert d * distance**2 * source / 2 == pytest.approx(1.0, abs=2 * distance * order**2)
    assert np.all(np.array(errors) < [1e-2, 1e-4, 1e-6])


@pytest.mark.parametrize("order", [1, 2, 5])
def test_far_away_only_the_multipole_of_the_order_is_left(order):
    """p -> 2 pi (1/2)_m/m! (R R')^m/s^(2m+1): exact to relative, not absolute, round-off."""
    source, height = 1.0, 1e4
    p, _, d = of_point(order, source, 0.0, height)
    factor = 2 * np.pi * np.prod((np.arange(order) + 0.5) / (np.arange(order) + 1))
    assert p == pytest.approx(factor / height ** (2 * order + 1), rel=1e-7)
    assert d == pytest.approx((2 * order + 1) * factor / height ** (2 * order + 3), rel=1e-7)


@given(st.integers(1, 5), st.floats(0.1, 3.0), st.floats(0.1, 3.0), st.floats(0.01, 3.0))
def test_reciprocity_and_recurrence(order, source, x, height):
    """p is symmetric in the two radii; (m + 1/2) p_{m+1} = 2 m chi p_m - (m - 1/2) p_{m-1} (DLMF 14.10.3)."""
    below, p, above = (of_point(m, source, x - source, height)[0] for m in (order - 1, order, order + 1))
    assert of_point(order, x, source - x, height)[0] == pytest.approx(p, rel=1e-12)
    chi = (source**2 + x**2 + height**2) / (2 * source * x)
    terms = (order + 0.5) * above, 2 * order * chi * p, (order - 0.5) * below
    assert abs(terms[0] - terms[1] + terms[2]) < 1e-12 * max(terms)


@given(st.integers(0, 4), st.floats(0.2, 3.0), st.floats(-0.9, 3.0), st.floats(0.05, 3.0))
def test_gradient_is_the_derivative_by_the_source(order, source, apart, height):
    """By central differences: the ring widened at the same point, and raised."""
    h = 1e-5
    _, along, across = of_point(order, source, apart * source, height)
    wider = [of_point(order, source + s, apart * source - s, height)[0] for s in (h, -h)]
    higher = [of_point(order, source, apart * source, height - s)[0] for s in (h, -h)]
    size = abs(of_point(0, source, apart * source, height)[2]) * max(1.0, source, height) + 1.0
    assert abs((wider[0] - wider[1]) / (2 * h) - along - across * apart * source) < 1e-5 * size
    assert abs((higher[0] - higher[1]) / (2 * h) - across * height) < 1e-5 * size


@pytest.mark.parametrize("order", [1, 2, 3])
def test_nothing_of_an_order_is_felt_on_the_axis(order):
    assert of_point(order, 1.2, -1.2, 0.4) == pytest.approx([0.0, 0.0, 0.0], abs=1e-15)
