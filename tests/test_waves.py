import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.config import Jonswap, RegularWave, StillWater
from vsb.waves import group_velocity, irregular, jonswap_spectrum, power_limit, sea, wavenumber

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


def test_limit_in_deep_water():
    assert power_limit(2.0, np.inf, 1025.0, G) == pytest.approx(1025.0 * G**3 / (4 * 2.0**3))


@pytest.mark.parametrize("gamma", [1.0, 3.3, 7.0])
def test_spectrum_carries_its_significant_height(gamma):
    omega = np.linspace(0.05, 40.0, 200_001)
    m0 = np.trapezoid(jonswap_spectrum(omega, 2.5, 6.0, gamma), omega)
    assert 4 * np.sqrt(m0) == pytest.approx(2.5, rel=2e-3)
    assert omega[np.argmax(jonswap_spectrum(omega, 2.5, 6.0, gamma))] == pytest.approx(2 * np.pi / 6, rel=1e-3)


def test_realisations_differ_by_phase_only_and_repeat_by_seed():
    first, again = (irregular(Jonswap(kind="jonswap", hs=1, tp=5, seed=3), 12.0, 60.0) for _ in range(2))
    other = irregular(Jonswap(kind="jonswap", hs=1, tp=5, seed=4), 12.0, 60.0)
    assert np.array_equal(first.amplitude, again.amplitude)
    assert np.abs(first.amplitude) == pytest.approx(np.abs(other.amplitude))
    assert not np.allclose(first.amplitude, other.amplitude)
    assert 4 * np.sqrt(0.5 * np.sum(np.abs(first.amplitude) ** 2)) == pytest.approx(1.0, rel=5e-3)
    assert 2 * np.pi / np.diff(first.omega).max() >= 60.0  # no repetition within the run


def test_regular_and_still_seas():
    regular = sea(RegularWave(kind="regular", amplitude=0.2, period=4.0), 12.0, 60.0)
    assert regular.elevation(np.array([0.0, 1.0, 2.0])) == pytest.approx([0.2, 0.0, -0.2], abs=1e-15)
    still = sea(StillWater(kind="still"), 12.0, 60.0)
    assert np.array_equal(still.elevation(np.array([0.0, 1.0])), [0.0, 0.0])
