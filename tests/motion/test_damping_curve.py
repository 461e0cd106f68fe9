"""The optimal damper of each of many seas from one table, against separate optimisations."""

import numpy as np
import pytest

from vsb.motion.port import Port
from vsb.motion.tuning import best_dampers, best_of_table, dampers

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
def test_table_finds_the_optimum_of_each_sea(seed):
    port, squares = random_port(seed), np.random.default_rng(100 + seed).exponential(size=(200, len(OMEGA))) ** 4
    tried = dampers(port)
    found = best_of_table(tried, port.power(tried) @ squares.T)
    climbed = best_dampers(port, squares)
    assert found.power == pytest.approx(climbed.power, rel=1e-9)
    assert np.all(found.power > climbed.power * (1 - 1e-11))
    assert found.damping == pytest.approx(climbed.damping, rel=1e-3)
    exact = np.sum(np.array([port.power(float(c)) for c in found.damping]) * squares, axis=1)
    assert found.power == pytest.approx(exact, rel=1e-11)


def test_optimal_damping_of_a_single_wave_is_its_impedance():
    port = random_port(1)
    tried = dampers(port)
    found = best_of_table(tried, port.power(tried) @ np.eye(len(OMEGA)))
    assert found.damping == pytest.approx(port.best_damping, rel=1e-6)
    assert found.power == pytest.approx(port.best_power, rel=1e-12)
