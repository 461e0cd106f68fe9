"""The best damper of each of many seas from one table, against the climb of each by itself."""

import numpy as np
import pytest

from vsb.motion.damping_curve import NEIGHBOURS, STEP, _highest, best_of_table, dampers
from vsb.motion.port import Port
from vsb.motion.tuning import best_dampers

OMEGA = np.linspace(0.3, 6.0, 40)


def random_port(seed):
    """Two resonances at random, passive."""
    random = np.random.default_rng(seed)
    admittance = np.zeros(len(OMEGA), dtype=complex)
    for _ in range(2):
        mass, damping, resonance = random.uniform([1e4, 2e3, 0.5], [1e5, 5e4, 5.0])
        admittance += 1 / (-1j * OMEGA * mass + damping + mass * resonance**2 / (-1j * OMEGA))
    return Port(OMEGA, admittance, random.uniform(0.1, 2.0, len(OMEGA)) + 0j, 1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_the_table_finds_the_best_of_each_sea(seed):
    """Power to 1e-10, which the climb reaches to the square of its last step; damper as far as a maximum is sharp."""
    port, squares = random_port(seed), np.random.default_rng(100 + seed).exponential(size=(200, len(OMEGA))) ** 4
    tried = dampers(port)
    found = best_of_table(tried, port.power(tried) @ squares.T)
    climbed = best_dampers(port, squares)
    assert found.power == pytest.approx(climbed.power, rel=1e-9)
    assert np.all(found.power > climbed.power * (1 - 1e-11))
    assert found.damping == pytest.approx(climbed.damping, rel=1e-3)
    exact = np.sum(np.array([port.power(float(c)) for c in found.damping]) * squares, axis=1)
    assert found.power == pytest.approx(exact, rel=1e-11)


def test_a_single_wave_wants_its_own_impedance():
    """Best damper |Z|, in closed form."""
    port = random_port(1)
    tried = dampers(port)
    found = best_of_table(tried, port.power(tried) @ np.eye(len(OMEGA)))
    assert found.damping == pytest.approx(port.best_damping, rel=1e-6)
    assert found.power == pytest.approx(port.best_power, rel=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_dampers_reach_six_steps_beyond_all_of_single_waves_and_no_seventh(seed):
    port = random_port(seed)
    tried = dampers(port)
    assert np.diff(np.log(tried)) == pytest.approx(np.full(len(tried) - 1, STEP), rel=1e-9)
    assert tried[6] == pytest.approx(port.best_damping.min(), rel=1e-9)
    assert 6 <= np.log(tried[-1] / port.best_damping.max()) / STEP < 7


def test_a_curve_that_is_hollow_at_the_best_damper_tried_is_left_there():
    """Newton's method would go down to its lowest point; that of a round curve is its top, but within a step."""
    x = [0.1, 0.02]
    tops = ((1, x[0]), (-1, x[1]), (-1, 9.0), (-1, -x[1]), (-1, -9.0))
    found = _highest(np.array([[0.0, sign, -2 * sign * at, 1.0] for sign, at in tops]).T)
    assert found == pytest.approx([0.0, x[1], 1.0 / NEIGHBOURS, -x[1], -1.0 / NEIGHBOURS], abs=1e-12)


def test_at_either_end_of_a_table_the_polynomial_is_through_its_outermost_entries():
    """Which is followed by a step at most from its middle; where there is no power no damper is better than another."""
    tried = np.exp(0.3 + STEP * np.arange(30))
    rising = 2.0 + 0.1 * np.arange(30.0)
    found = best_of_table(tried, np.stack([rising, rising[::-1], np.zeros(30)], axis=1))
    np.testing.assert_allclose(found.power, [rising[24], rising[24], 0.0], rtol=1e-9)
    np.testing.assert_allclose(found.damping, tried[[24, 5, 5]], rtol=1e-9)
    bent = np.cosh(STEP * np.arange(30.0))  # hollow: the middle stays
    found = best_of_table(tried, np.stack([bent, bent[::-1]], axis=1))
    np.testing.assert_allclose(found.damping, tried[[24, 5]], rtol=1e-9)
    np.testing.assert_allclose(found.power, bent[24], rtol=1e-9)
