"""A scene at the harmonics of a wave: one frequency or none, and the impedance of its equation."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from vsb.errors import ConfigError
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.floquet import phases, synthesized
from vsb.integrators.regular_wave import PeriodicScene, regular_frequency
from vsb.motion.forces import Damper, Excitation, Force, Linear, RadiationMemory, Spring
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


def coupled(**more):
    """Two coupled motions of masses that are not one, with a spring, a damper and a wave."""
    forces = {
        "hydrostatic": Spring(np.array([[50.0, -10.0], [-10.0, 300.0]])),
        "pto": Damper(np.array([[4.0, 1.0], [1.0, 2.0]])),
        "excitation": Excitation(np.array([1.5]), np.array([[3.0 - 1.0j, 0.5j]])),
    }
    mass = np.array([[2.0, 0.3], [0.3, 1.0]])
    return System.of(Scene(("Heave", "Membrane0"), mass, forces | more, np.eye(2)))


def test_the_impedance_of_coupled_modes_is_that_of_the_equation_in_plain_coordinates():
    """V^T (K - w^2 M - i w (C + conj B(w))) V at every harmonic; B is complex and, here, without symmetry."""

    def transfer(omega):
        return np.array([[[1.0 + 2j * w, 0.3], [-0.2j, 0.5 * w]] for w in omega])

    system, w = coupled(), 1.5 * np.arange(4)
    found = PeriodicScene(system, 1.5, transfer).impedance(4)
    scene, v = system.scene, system.modes
    water = np.concatenate([np.zeros((1, 2, 2)), transfer(w[1:]).conj()])
    plain = [scene.stiffness - x**2 * scene.mass - 1j * x * (scene.damping + b) for x, b in zip(w, water, strict=True)]
    np.testing.assert_allclose(found, v.T @ np.array(plain) @ v, atol=1e-10)


@pytest.mark.parametrize("name", ["pto", "other"])
def test_what_the_take_off_remembers_is_no_radiation(name):
    """A chamber behind the take-off adds to the impedance, the memory of another force is given by the transfer."""
    turning, channel = np.array([[0.0, 1.4], [-1.4, 0.0]]), np.array([1.0, 0.6])
    memory = RadiationModel(turning - np.outer(channel, channel) / 2, np.array([[2.0, 0.1], [1.5, -1.0]]), channel)
    system, omega = coupled(**{name: RadiationMemory(memory)}), np.array([0.5, 2.0])
    scene = PeriodicScene(system, 1.5, None)
    exact = system.shapes.T @ memory.transfer(omega).conj() @ system.shapes if name == "pto" else np.zeros((2, 2, 2))
    np.testing.assert_allclose(scene.relaxation(omega), exact, atol=1e-12)
    assert not scene.radiation(omega).any()
    damping = scene.impedance(3) - PeriodicScene(coupled(**{name: Damper(np.zeros((2, 2)))}), 1.5, None).impedance(3)
    if name == "pto":
        at = 1.5 * np.arange(1, 3)
        expected = system.shapes.T @ memory.transfer(at).conj() @ system.shapes
        np.testing.assert_allclose(damping[1:], -1j * at[:, None, None] * expected, atol=1e-10)
    else:
        np.testing.assert_allclose(damping, 0.0, atol=1e-12)


@dataclass(frozen=True)
class Mixed(Force):
    """Each coordinate's force depends on places and rates of both."""

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return np.stack([-3 * q[:, 0] * q[:, 1] ** 2 - v[:, 1] ** 3, 2 * q[:, 0] ** 3 - 5 * v[:, 0] * q[:, 1]], axis=1)


@pytest.fixture
def mixed():
    """A scene of two motions with such a force, a motion of three harmonics, and 16 phases of it."""
    rng = np.random.default_rng(12)
    harmonics = 0.3 * (rng.normal(size=(3, 2)) + 1j * rng.normal(size=(3, 2)))
    harmonics[0] = harmonics[0].real
    return PeriodicScene(coupled(mixed=Mixed()), 1.5, None), harmonics


def test_states_of_an_orbit_are_scaled_places_and_rates_of_its_modes(mixed):
    scene, harmonics = mixed
    phase = phases(16, 0.3)
    turn = np.exp(-1j * np.outer(phase, np.arange(3)))
    u, rate = (turn @ harmonics).real, (turn @ (-1.5j * np.arange(3)[:, None] * harmonics)).real
    np.testing.assert_allclose(scene.states(harmonics, phase), np.hstack([scene.system.scale * u, rate]), rtol=1e-12)


def test_the_coupling_of_an_orbit_is_what_a_small_change_of_its_states_does(mixed):
    """Of every mode's place and rate, by differences of the force itself."""
    scene, harmonics = mixed
    phase = phases(8)
    z, found, h = scene.states(harmonics, phase), scene.coupling(harmonics, phase), 1e-6
    assert found.shape == (8, 2, 4)
    for k, unit in enumerate(np.eye(4)):
        slope = (scene.remainder(phase, z + h * unit) - scene.remainder(phase, z - h * unit)) / (2 * h)
        np.testing.assert_allclose(found[:, :, k], slope, rtol=1e-5, atol=1e-6)


def test_a_force_along_an_orbit_is_the_same_from_whatever_phase_it_is_sampled(mixed):
    """Its harmonics are of phase zero; the linear waves push at the first."""
    scene, harmonics = mixed
    at_zero, later = (scene.forced(harmonics, phases(32, offset)) for offset in (0.0, 0.4))
    np.testing.assert_allclose(later, at_zero, atol=1e-12)
    samples = scene.remainder(phases(32), scene.states(harmonics, phases(32)))
    at_zero[1] -= scene.push
    np.testing.assert_allclose(synthesized(at_zero, phases(32)), samples, atol=1e-12)
    assert np.abs(scene.push).min() > 0.1


def test_an_amplitude_is_that_of_the_coordinate_that_moves_most_about_its_mean(mixed):
    """In metres, not in modes; no less than what is too small to matter, a metre of a scene without scale."""
    scene, harmonics = mixed
    moving = np.abs(harmonics[1:] @ scene.system.modes.T).sum(axis=0)
    assert scene.amplitude(harmonics) == pytest.approx(moving.max(), rel=1e-12)
    assert scene.amplitude(np.vstack([np.full((1, 2), 9.0 + 0j), np.zeros((2, 2))])) == scene.size == 1e-6
    assert scene.reach == pytest.approx(10.0)
    linear = PeriodicScene(coupled(), 1.5, None)
    assert linear.amplitude(np.zeros((3, 2), dtype=complex)) == 1.0
    assert linear.reach == np.inf


def test_what_no_wave_pushes_has_no_push():
    still = System.of(Scene(("a", "b"), np.eye(2), {"hydrostatic": Spring(np.eye(2))}, np.eye(2)))
    assert PeriodicScene(still, 1.0, None).push.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("found", "words"), [
    ([0.25, 1.5, 7.0], "received 3 frequencies from 0.25 to 7 rad/s, needs one above zero"),
    ([0.0], "received 1 frequencies from 0 to 0 rad/s, needs one above zero"),
    ([0.0, 2.0], "received 2 frequencies from 0 to 2 rad/s, needs one above zero"),
])  # fmt: skip
def test_frequencies_that_are_refused_are_told_from_the_least_to_the_largest(found, words):
    with pytest.raises(ConfigError, match=f"^waves: {words}"):
        regular_frequency(SimpleNamespace(frequencies=np.array(found)))
