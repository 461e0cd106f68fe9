"""A site's year: against a loop over its hours written apart, against published practice."""

from pathlib import Path

import numpy as np
import pytest

from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.results.year import frequencies, year
from vsb.study.study import Water
from vsb.waves.climate import Climate

HOME = Path(__file__).parents[2]
WATER = Water()


def port(omega, mass=17000.0, loss=3000.0, stiffness=1.26e5):
    """A mass on a spring that radiates, not the hydrodynamics of any buoy."""
    impedance = -1j * omega * mass + loss * omega + stiffness / (-1j * omega)
    return Port(omega, 1 / impedance, 5e4 / (1 + omega**2) / impedance, 1 / stiffness)


def climate(seas=40, seed=1):
    """Seas of random spectra over 20 bands."""
    random = np.random.default_rng(seed)
    omega = 0.3 + 0.1 * np.arange(20)
    peak = random.uniform(0.4, 1.5, (seas, 1))
    density = random.uniform(0.1, 0.4, (seas, 1)) * np.exp(-(((omega - peak) / 0.2) ** 2))
    hours = random.uniform(0.5, 1.5, seas)
    return Climate.of_spectra(omega, density, hours / hours.sum(), "random seas")


def looped(sea, damping, omega, port):
    """Mean power of one sea, hour by hour and band by band: the integral of the broken line of its power."""
    load = 0.5 * damping * np.abs(port.velocity / (1 + port.admittance * damping)) ** 2
    total = 0.0
    for k, centre in enumerate(omega):
        inside = np.union1d(port.omega[np.abs(port.omega - centre) < 0.05], [centre - 0.05, centre + 0.05])
        power = np.interp(inside, port.omega, load)
        total += 2 * sea[k] * float(np.sum((power[1:] + power[:-1]) / 2 * np.diff(inside)))
    return total


@pytest.mark.parametrize("step", [0.031, 0.0123])
def test_every_hour_by_itself(step):
    seas, grid = climate(), np.arange(0.1, 3.0, step)
    ports = {"A": port(grid), "B": port(grid, mass=9000.0)}
    found = year(ports, seas, WATER, dampings={"A": 8e3, "B": 2e4}, reference="A")
    for i, p in enumerate(ports.values()):
        for j in range(3):
            hourly = [looped(s, found.damping[i, j, n], seas.omega, p) for n, s in enumerate(seas.density)]
            assert found.power[i, j] == pytest.approx(hourly, rel=1e-12)
            assert found.annual_mean_power[i, j] == pytest.approx(float(np.dot(hourly, seas.hours)), rel=1e-12)


def test_tunings_stand_in_their_order():
    seas = climate()
    grid = frequencies(seas, 0.1, 4.0)
    found = year({"A": port(grid)}, seas, WATER, dampings={"A": 8e3}).annual_mean_power[0]
    assert found[0] < found[1] < found[2]


def test_too_much_beyond_the_port():
    seas = climate()
    with pytest.raises(ConfigError, match=r"of its variance outside 0\.1 to 1 rad/s, .* raise hydro\.omega_max"):
        year({"A": port(np.linspace(0.1, 1.0, 100))}, seas, WATER, tunings=["one"])
