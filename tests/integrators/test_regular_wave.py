"""A scene at the harmonics of a wave: one frequency or none, and the impedance of its equation."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from vsb.errors import ConfigError
from vsb.integrators.regular_wave import PeriodicScene, regular_frequency
from vsb.motion.forces import Damper, Excitation, Force, Linear, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System

MASS, STIFFNESS, DAMPING, PUSH = 2.0, 50.0, 1.2, 3.0 - 1.0j


def driven(omega=1.5):
    forces = {
        "hydrostatic": Spring(np.array([[STIFFNESS]])),
        "pto": Damper(np.array([[DAMPING]])),
        "excitation": Excitation(np.array([omega]), np.array([[PUSH]])),
    }
    return System.of(Scene(("Heave",), np.array([[MASS]]), forces, np.eye(1)))


@pytest.mark.parametrize(("found", "omega"), [([], 0.0), ([1.5], 1.5)])
def test_one_frequency_or_none(found, omega):
    assert regular_frequency(SimpleNamespace(frequencies=np.array(found))) == omega


@pytest.mark.parametrize(
    ("found", "words"), [([1.0, 2.0], "received 2 frequencies from 1 to 2 rad/s"), ([0.0], "received 1 frequencies")]
)
def test_several_frequencies_or_a_load_without_a_period_are_refused(found, words):
    with pytest.raises(ConfigError, match=f"waves: {words}.*only a regular wave has a steady state"):
        regular_frequency(SimpleNamespace(frequencies=np.array(found)))


def test_the_impedance_is_that_of_the_equation_of_motion():
    """Z U = G in the natural mode, u = sqrt(m) y: k/m - w^2 - i w (c + B)/m."""
    radiated = 0.7
    scene = PeriodicScene(driven(), 1.5, lambda omega: np.full((len(omega), 1, 1), radiated + 0j))
    z, w = scene.impedance(4)[:, 0, 0], 1.5 * np.arange(4)
    damping = DAMPING + radiated * (w > 0)
    np.testing.assert_allclose(z, STIFFNESS / MASS - w**2 - 1j * w * damping / MASS, rtol=1e-12)
    y = scene.push[0] / z[1] * scene.system.modes[0, 0]
    without = -(1.5**2) * MASS - 1.5j * (DAMPING + radiated) + STIFFNESS
    assert y == pytest.approx(PUSH / without, rel=1e-12)


def test_without_nonlinear_forces_nothing_is_added():
    scene = PeriodicScene(driven(), 1.5, None)
    assert not scene.radiation(np.array([1.0, 2.0])).any()
    harmonics = np.array([[0.0], [0.1 + 0.2j], [0.0]])
    phase = 2 * np.pi * np.arange(6) / 6
    force = scene.forced(harmonics, phase)
    np.testing.assert_allclose(force[1], scene.push)
    np.testing.assert_allclose(force[[0, 2]], 0.0, atol=1e-14)
    assert not scene.coupling(harmonics, phase).any()


@dataclass(frozen=True)
class Cubes(Force):
    """f = -a q^3 - b v^3."""

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return -40.0 * q**3 - 3e5 * v**3


@pytest.mark.parametrize("omega", [0.01, 1.0, 30.0])
def test_tangents_are_the_derivatives_of_forces_by_places_and_by_rates(omega):
    """-3 a q^2 and -3 b v^2 over the mass, of central differences as short as the motion is small at any frequency."""
    scene = driven(omega).scene
    found = PeriodicScene(
        System.of(Scene(scene.labels, scene.mass, {**scene.forces, "cubes": Cubes()}, np.eye(1))), omega, None
    )
    y, v = np.array([0.1, -0.2]), np.array([0.3, 2e-3])
    z = np.column_stack([y, v]) * np.append(found.system.scale, np.ones(1)) / found.system.modes[0, 0]
    e = found.tangents(np.zeros(2), z)[:, 0]
    np.testing.assert_allclose(e[:, 0], -3 * 40.0 * y**2 / MASS, rtol=1e-6)
    np.testing.assert_allclose(e[:, 1], -3 * 3e5 * v**2 / MASS, rtol=1e-4)
