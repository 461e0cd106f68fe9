"""One regime of a switching take-off: exact over any span, with a port that is held at rest there."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from vsb.integrators.phases import FELT, Phase, felt_rate
from vsb.motion.forces import Damper, Excitation, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System

PORT = np.array([1.0, -0.7])


@pytest.fixture(scope="module")
def system():
    """Two masses, coupled, in a regular wave, without take-off."""
    forces = {
        "hydrostatic": Spring(np.array([[50.0, -10.0], [-10.0, 30.0]])),
        "structural_damping": Damper(np.diag([0.4, 0.2])),
        "excitation": Excitation(np.array([1.5]), np.array([[3.0 - 1.0j, 0.5j]])),
    }
    return System.of(Scene(("Heave", "Membrane0"), np.diag([2.0, 1.0]), forces, np.eye(2)))


def phase(system, held=False, **law):
    return Phase(system, system.shapes.T @ PORT, law.get("damping", 0.0), law.get("stiffness", 0.0), held, 0.1)


def test_damper_and_spring_at_the_port_are_those_of_the_scene_with_them(system):
    with_both = dict(system.scene.forces)
    with_both["hydrostatic"] = Spring(with_both["hydrostatic"].stiffness + 7.0 * np.outer(PORT, PORT))
    with_both["pto"] = Damper(4.0 * np.outer(PORT, PORT))
    whole = System.of(Scene(system.scene.labels, system.scene.mass, with_both, np.eye(2)))
    ours = np.linalg.eigvals(phase(system, damping=4.0, stiffness=7.0).matrix[:-1, :-1])
    np.testing.assert_allclose(np.sort_complex(ours), np.sort_complex(np.linalg.eigvals(whole.matrix)), rtol=1e-10)


def test_a_port_that_is_held_does_not_move_whatever_pushes(system):
    held = phase(system, held=True)
    velocity = held.signals[1]
    np.testing.assert_allclose(velocity @ held.matrix, 0.0, atol=1e-12)
    np.testing.assert_allclose(velocity[:-1] @ held.swing.T, 0.0, atol=1e-12)


def test_a_switch_watches_stroke_and_velocity_of_the_port_and_what_it_takes_to_hold_it(system):
    """By Newton's law: M a = f + b F - b H with b.a = 0, so that H = F + b.M^-1 f/(b.M^-1 b)."""
    one = replace(phase(system, held=True), rest=0.25)
    q, v, time, more = (
        np.array([[0.2, -0.1], [0.3, 0.4]]),
        np.array([[0.5, 0.3], [-0.2, 0.1]]),
        np.array([0.3, 0.8]),
        7.0,
    )
    states = np.array([[*system.first(start), more] for start in zip(q, v, strict=True)])
    scene, waves = system.scene, np.array([3.0 - 1.0j, 0.5j]) * np.exp(-1.5j * time[:, None])
    force = waves.real - q @ scene.stiffness - v @ scene.damping
    light = np.linalg.solve(scene.mass, PORT)
    hold = more + force @ light / (PORT @ light)
    stroke, velocity, push = one.watched(time, states)
    np.testing.assert_allclose(stroke, q @ PORT - 0.25, rtol=1e-12)
    np.testing.assert_allclose(velocity, v @ PORT, rtol=1e-12)
    np.testing.assert_allclose(push, hold, rtol=1e-12)
    on_modes = np.real(system.waves * np.exp(-1.5j * time[:, None]))
    np.testing.assert_allclose(one.push(states[:, :-1], on_modes, more), hold, rtol=1e-12)


@pytest.mark.parametrize("span", [0.1, 0.037, 1e-7])
def test_a_transient_is_followed_exactly_over_any_part_of_a_step(system, span):
    one, state = phase(system, damping=4.0), np.array([0.2, -0.1, 0.5, 0.3, 1.0])
    np.testing.assert_allclose(one.later(state, span), expm(span * one.matrix) @ state, rtol=1e-12, atol=1e-14)


def test_states_are_transients_about_the_swing_of_the_wave(system):
    one, time = phase(system, damping=4.0), np.array([0.0, 0.1, 0.2])
    states = np.arange(15.0).reshape(3, 5)
    transients = np.array([one.transient(t, state) for t, state in zip(time, states, strict=True)])
    np.testing.assert_allclose(one.states(time, transients), states, atol=1e-12)
    assert (transients[:, -1] == states[:, -1]).all()  # the constant force is no swing


def test_what_is_known_ahead_are_powers_of_a_step(system):
    one = phase(system)
    for m in (1, 2, 7):
        np.testing.assert_allclose(one.ahead[m - 1], expm(m * one.step * one.matrix), atol=1e-11)


@pytest.mark.parametrize(("springs", "dampers", "rate"), [
    ((0.0,), (), 5.0), ((0.0, 288.0), (), 13.0), ((288.0, 0.0), (3.0,), 13.0), ((0.0,), (3.0, 30.0), 15.0),
    ((-82.0,), (), 4.0), ((-50.0,), (), 1e-3),
])  # fmt: skip
def test_a_port_feels_the_stiffest_of_its_springs_or_the_strongest_of_its_dampers(springs, dampers, rate):
    """One mass of 2 kg on 50 N/m: sqrt(|50 + s|/2) under a spring at it, which may push it over, c/2 under a damper."""
    forces = {"hydrostatic": Spring(np.array([[50.0]]))}
    system = System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))
    port = np.array([np.sqrt(0.5)])  # of the motion scaled to unit mass
    assert felt_rate(system, port, springs, dampers) == pytest.approx(rate, rel=1e-12)


@pytest.mark.parametrize(("part", "rate"), [(1.05, 10.0), (0.95, 1.0)])
def test_a_port_feels_a_mode_that_answers_a_kick_with_a_thousandth_of_the_largest_motion(part, rate):
    """Unit masses at 1 and 10 rad/s: kicked by beta^2 each, they go beta^2/omega far."""
    forces = {"hydrostatic": Spring(np.diag([1.0, 100.0]))}
    system = System.of(Scene(("Heave", "Membrane0"), np.eye(2), forces, np.eye(2)))
    port = system.shapes.T @ np.sqrt([1.0, 10 * part * FELT])
    assert felt_rate(system, port, [0.0], []) == pytest.approx(rate, rel=1e-9)


@pytest.mark.parametrize("damping", [0.0, 4.0, 30.0, 4e3])
def test_rungs_halve_a_step_until_a_series_needs_no_scaling(system, damping):
    """Down to a norm of a half, and no further; exact over any part of a step however strong the damper."""
    one = phase(system, damping=damping, stiffness=10 * damping)
    norm = np.linalg.norm(one.flow, 1) * one.step
    last = norm / 2 ** (len(one.ladder) - 1)
    assert last <= 0.5
    assert last > 0.25 or len(one.ladder) == 1
    for j, rung in enumerate(one.ladder):
        np.testing.assert_allclose(rung, expm(one.flow * one.step / 2**j), rtol=1e-9, atol=1e-11)
    state = np.array([0.2, -0.1, 0.5, 0.3, 1.0])
    for span in (0.1, 0.0999, 0.061, 0.0031):
        np.testing.assert_allclose(one.later(state, span), expm(span * one.flow) @ state, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("law", [{}, {"damping": 4.0}, {"stiffness": -7.0}, {"damping": 4.0, "stiffness": 7.0}])
def test_rates_are_those_of_the_equation_of_motion_in_plain_coordinates(system, law):
    """M a = -K q - C v - b (c V + k S) + b f: damper, spring and constant force at the port."""
    one, scene, f = phase(system, **law), system.scene, 3.5
    q, v = np.array([0.2, -0.1]), np.array([0.5, 0.3])
    rates = one.matrix @ np.append(system.first((q, v)), f)
    port = PORT * (f - law.get("damping", 0.0) * (v @ PORT) - law.get("stiffness", 0.0) * (q @ PORT))
    expected = np.linalg.solve(scene.mass, port - scene.stiffness @ q - scene.damping @ v)
    np.testing.assert_allclose(system.modes @ rates[2:4], expected, rtol=1e-12)
    np.testing.assert_allclose(system.position @ rates[:2], v, rtol=1e-12)
    assert rates[4] == 0.0


def test_the_swing_is_the_steady_state_of_the_scene_with_damper_and_spring(system):
    """In plain coordinates, (K + k b b^T - w^2 M - i w (C + c b b^T)) q = F."""
    one, scene, w, outer = phase(system, damping=4.0, stiffness=7.0), system.scene, 1.5, np.outer(PORT, PORT)
    z = scene.stiffness + 7.0 * outer - w**2 * scene.mass - 1j * w * (scene.damping + 4.0 * outer)
    q = np.linalg.solve(z, [3.0 - 1.0j, 0.5j])
    np.testing.assert_allclose(system.position @ one.swing[0, :2], q, rtol=1e-10)
    np.testing.assert_allclose(system.modes @ one.swing[0, 2:4], -1j * w * q, rtol=1e-10)


def test_what_a_port_that_is_held_lets_through_moves_across_it(system):
    """A projection; a port that is free lets all through."""
    held, free = phase(system, held=True).allowed, phase(system).allowed
    np.testing.assert_array_equal(free, np.eye(2))
    np.testing.assert_allclose(held @ held, held, atol=1e-14)
    np.testing.assert_allclose(held @ (system.shapes.T @ PORT), 0.0, atol=1e-14)
    assert np.trace(held) == pytest.approx(1.0)


def test_a_linear_regime_carries_nothing_and_a_step_of_it_has_no_error(system):
    one, state = phase(system), np.arange(5.0)
    begun, error = one.begun(0.7, state)
    assert (begun.tolist(), error) == (state.tolist(), 0.0)
    assert one.reset(state, 0.7).tolist() == state.tolist()
    assert (one.added(np.zeros((3, 5))).shape, one.added(np.zeros((3, 5))).any()) == ((3, 3, 2), False)
    assert one.flow is one.matrix or np.array_equal(one.flow, one.matrix)
    assert len(one.ahead) == one.reach


def test_the_strongest_rate_is_that_of_whichever_spring_or_damper_makes_it():
    """Two coupled masses at a port on both: by numpy on mass and stiffness in plain coordinates."""
    mass, stiffness, direction = np.diag([2.0, 0.5]), np.array([[50.0, -10.0], [-10.0, 90.0]]), np.array([1.0, -0.7])
    system = System.of(Scene(("Heave", "Membrane0"), mass, {"hydrostatic": Spring(stiffness)}, np.eye(2)))
    port, light = system.shapes.T @ direction, direction @ np.linalg.solve(mass, direction)

    def fastest(spring):
        whole = np.linalg.solve(mass, stiffness + spring * np.outer(direction, direction))
        return np.sqrt(np.linalg.eigvals(whole).max())

    assert felt_rate(system, port, [0.0, 300.0, 20.0], [1.0]) == pytest.approx(fastest(300.0), rel=1e-9)
    assert felt_rate(system, port, [-30.0, 0.0], [1.0, 0.0]) == pytest.approx(fastest(0.0), rel=1e-9)
    assert felt_rate(system, port, [0.0], [3.0, 900.0, 2.0]) == pytest.approx(900.0 * light, rel=1e-9)
