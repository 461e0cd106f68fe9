import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.engine.waves.water import group_velocity, horizontal_velocity, power_limit, vertical_velocity, wavenumber

G = 9.81


@given(st.floats(0.05, 20.0), st.floats(0.5, 500.0))
def test_dispersion_relation(omega, depth):
    k = wavenumber(omega, depth, G)
    assert G * k * np.tanh(k * depth) == pytest.approx(omega**2, rel=1e-9)


@given(st.floats(0.1, 5.0), st.floats(1.0, 200.0))
def test_group_velocity_is_the_derivative_of_the_dispersion_relation(omega, depth):
    h = 1e-4 * omega
    slope = (wavenumber(omega + h, depth, G) - wavenumber(omega - h, depth, G)) / (2 * h)
    assert group_velocity(omega, depth, G) == pytest.approx(1 / slope, rel=1e-5)


def test_deep_and_shallow_limits():
    assert wavenumber(2.0, np.inf, G) == 4.0 / G
    assert group_velocity(2.0, np.inf, G) == pytest.approx(G / 4)
    assert group_velocity(0.01, 1.0, G) == pytest.approx(np.sqrt(G), rel=1e-4)


@given(st.floats(0.2, 5.0), st.floats(1.0, 100.0))
def test_power_limit_is_the_flux_of_one_capture_width(omega, depth):
    k = wavenumber(omega, depth, G)
    kd = k * depth
    flux = 1025.0 * G / 2 * omega / k * 0.5 * (1 + (2 * kd / np.sinh(2 * kd) if kd < 300 else 0.0))
    assert power_limit(omega, depth, 1025.0, G) == pytest.approx(flux / k, rel=1e-12)


def test_orbital_velocities_in_closed_form():
    """cosh and sinh of their own at a depth, from the bottom up."""
    omega, depth, gravity, z = np.array([0.4, 1.1]), 7.0, 9.6, -2.5
    k = np.array([wavenumber(w, depth, gravity) for w in omega])
    np.testing.assert_allclose(
        horizontal_velocity(omega, z, depth, gravity), omega * np.cosh(k * (z + depth)) / np.sinh(k * depth), rtol=1e-12
    )
    np.testing.assert_allclose(
        vertical_velocity(omega, z, depth, gravity),
        -1j * omega * np.sinh(k * (z + depth)) / np.sinh(k * depth),
        rtol=1e-12,
    )
    deep = omega * np.exp(omega**2 / gravity * z)
    np.testing.assert_allclose(horizontal_velocity(omega, z, np.inf, gravity), deep, rtol=1e-12)
    np.testing.assert_allclose(vertical_velocity(omega, z, np.inf, gravity), -1j * deep, rtol=1e-12)
