import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import jv, jvp

from vsb.hydro.azimuthal import bessel, legendre_function, multiplicity, wave_around

PHI = np.linspace(0.05, np.pi - 0.05, 41)


def test_functions_of_low_order_are_the_textbooks():
    """Abramowitz and Stegun 8.6, without their (-1)^m."""
    s, c = np.sin(PHI), np.cos(PHI)
    for (n, m), (value, slope) in {
        (1, 1): (s, c),
        (2, 1): (3 * s * c, 3 * np.cos(2 * PHI)),
        (2, 2): (3 * s**2, 6 * s * c),
        (3, 3): (15 * s**3, 45 * s**2 * c),
    }.items():
        for found, expected in zip(legendre_function(n, m, PHI), (value, slope), strict=True):
            assert found == pytest.approx(expected, abs=1e-13)


@given(st.integers(1, 6), st.integers(0, 6))
def test_slope_is_the_derivative(order, more):
    h = 1e-5
    ahead, behind = (legendre_function(order + more, order, PHI + sign * h)[0] for sign in (1, -1))
    slope = legendre_function(order + more, order, PHI)[1]
    assert np.abs((ahead - behind) / (2 * h) - slope).max() < 1e-6 * np.abs(slope).max()


@given(st.integers(1, 8), st.floats(0.0, 10.0))
def test_component_of_a_wave_is_jacobis_and_angers(order, kx):
    value, rise = wave_around(order, 64, np.array([kx]))
    assert value[0] == pytest.approx(2 * 1j**order * jv(order, kx), abs=1e-13)
    assert rise[0] == pytest.approx(2 * 1j**order * jvp(order, kx), abs=1e-13)


def test_few_points_alias_the_next_order():
    """Points cannot tell order m from n - m: i^{n-m} J_{n-m} joins in."""
    value, kx = wave_around(2, 7, np.array([1.5]))[0][0], 1.5
    assert value == pytest.approx(2 * (1j**2 * jv(2, kx) + 1j**5 * jv(5, kx)), abs=1e-4)
    assert abs(value - 2 * 1j**2 * jv(2, kx)) > 1e-3


@given(st.floats(0.01, 20.0), st.floats(-np.pi, np.pi))
def test_components_add_up_to_the_plane_wave(kr, theta):
    """Jacobi and Anger's expansion of exp(i k R cos theta)."""
    parts = [multiplicity(m) * 1j**m * bessel(m, np.array(kr))[0] * np.cos(m * theta) for m in range(50)]
    assert sum(parts) == pytest.approx(np.exp(1j * kr * np.cos(theta)), abs=1e-12)
