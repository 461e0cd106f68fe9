"""Take-offs that switch on the instantaneous wet shell: smooth and independent methods, order across events, audit."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import springs
from scipy.integrate import solve_ivp

from vsb.errors import ConvergenceError
from vsb.integrators import energy_preserving, wet_phases
from vsb.integrators.audit import energies, residual
from vsb.integrators.energy_preserving import STALLED, settled
from vsb.integrators.exponential import integrate
from vsb.integrators.simulate import legs, simulate
from vsb.integrators.switching import Switching, switched
from vsb.integrators.wet_phases import WetPhase
from vsb.motion.builders import assumed_pressure_scene
from vsb.motion.forces import AssumedPressure, Damper, Excitation, Spring
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import EndStop, TakeOff
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import mode_basis, rigid_basis
from vsb.study.sections import Simulation
from vsb.waves.seas import NO_WAVES

B, START, DURATION = np.ones(1), (0.1, 0.2), 5.0
LAWS = {
    "saturated": (TakeOff(B, 8e3, 2e4, 4e3), None),
    "coulomb": (TakeOff(B, np.inf, limit=4e3), None),
    "latching": (TakeOff(B, 8e3, pause=0.4), None),
    "declutching": (TakeOff(B, 3e4, pause=0.4, paused_damping=0.0), None),
    "end stop": (TakeOff(B, 8e3), EndStop(B, 0.3, 1e6, 1e4)),
}


def scene(seed, degree, law=None, stop=None, damping=0.0):
    """The paper's buoy under an assumed pressure; degree 0: rigid."""
    basis = mode_basis(seed.device, "membrane", degree) if degree else rigid_basis(seed.device)
    shell = DeformedShell(basis, seed.centre_height, np.zeros(len(basis.labels)))
    motions = np.eye(len(basis.labels))
    found = assumed_pressure_scene(shell, LinearPto(damping), AssumedPressure(1800.0, 2.5), 1025.0, 9.81, motions)
    port = np.eye(len(basis.labels))[0]
    laws = {"pto": law, "end_stop": stop}
    forces = {name: replace(force, direction=port) for name, force in laws.items() if force}
    return replace(found, forces={**found.forces, **forces})


@pytest.mark.parametrize("degree", [0, 2])
def test_a_law_that_never_switches_is_the_smooth_damper(seed, degree):
    """The exponential Adams method, at 1e-11; the port turns round all the same."""
    time = np.linspace(0.0, DURATION, 101)
    smooth = scene(seed, degree, damping=8e3)
    expected, _ = integrate(System.of(smooth), time, smooth.start(*START), 1e-11)
    found, switches = switched(System.of(scene(seed, degree, TakeOff(B, 8e3))), time, smooth.start(*START), 1e-8)
    assert switches >= 3
    for part in ("position", "velocity", "acceleration"):
        scale = np.abs(getattr(expected, part)).max()
        assert getattr(found, part) == pytest.approx(getattr(expected, part), abs=1e-8 * scale)


@pytest.mark.parametrize("name", ["saturated", "end stop"])
def test_motion_is_that_of_an_explicit_method_in_plain_coordinates(seed, name):
    """DOP853 steps over the kinks, which limits it; jumps it would need events for."""
    one, time = scene(seed, 0, *LAWS[name]), np.linspace(0.0, DURATION, 101)
    water, weight, mass, stiffness = one.water, one.forces["weight"].value, one.mass[0, 0], springs(one)[0, 0]

    def rates(t, y):
        q, v = np.array([[y[0]]]), np.array([[y[1]]])
        laws = sum(one.forces[k].force(t, q, v)[0, 0] for k in ("pto", "end_stop") if k in one.forces)
        still, uniform, _ = water.shell.forces(q)
        pressure = water.assumed.amplitude * np.cos(2.5 * t)
        force = water.specific_weight * still[0, 0] + pressure * uniform[0, 0] + weight[0] - stiffness * y[0] + laws
        return [y[1], force / mass]

    expected = solve_ivp(rates, (0.0, DURATION), START, "DOP853", rtol=1e-11, atol=1e-12, t_eval=time, max_step=0.02)
    found, switches = switched(System.of(one), time, one.start(*START), 1e-9)
    assert switches > 8
    assert found.position[:, 0] == pytest.approx(expected.y[0], abs=2e-7 * np.abs(expected.y[0]).max())


@pytest.mark.parametrize("name", LAWS)
def test_the_audit_closes_and_forces_balance(seed, name):
    """Shell modes, too, from rest on: laws are far from smooth, and what is stored is read from the exact shape."""
    law, stop = LAWS[name]
    one = scene(seed, 2, law, stop)
    system, time = System.of(one), np.linspace(0.0, DURATION, 401)
    y, rate = one.start(*START)
    motion, switches = switched(system, time, (one.rest + y, rate), 1e-7)
    assert switches > 3
    assert residual(energies(system, motion)) < 1e-6
    assert motion.acceleration @ one.mass == pytest.approx(sum(system.forces(motion).values()), abs=1e-5)
    assert np.abs(motion.forces["pto"]).max() <= law.limit * (1 + 1e-12)
    if stop:  # without losses V sqrt(m/k)
        lossless = np.abs(motion.velocity[:, 0]).max() * np.sqrt(one.mass[0, 0] / stop.stiffness)
        assert 0.3 * lossless < np.abs(motion.position[:, 0]).max() - stop.stroke < lossless


@pytest.mark.parametrize("name", ["saturated", "coulomb", "latching", "end stop"])
def test_order_is_six_across_events(seed, name, monkeypatch):
    """Of a step nothing is known before it begins, so an event costs no order; the audit's is six, too."""
    monkeypatch.setattr("vsb.integrators.switching.RESOLVED", 1e9)
    one, steps = scene(seed, 0, *LAWS[name]), np.array([25, 50, 100, 200])
    system, starts = System.of(one), [(0.1, 0.2), (0.12, 0.15), (0.08, 0.25), (0.11, 0.3)]

    def run(start, count):
        motion, switches = Switching(system, np.inf).follow(np.linspace(0.0, DURATION, count + 1), one.start(*start))
        return motion.position[:: count // 25], residual(energies(system, motion)), switches

    exact = [run(start, 1600) for start in starts]
    errors, audits = np.empty((2, len(steps)))
    for k, count in enumerate(steps):
        found = [run(start, count) for start in starts]
        assert [f[2] for f in found] == [e[2] for e in exact]
        errors[k] = max(np.abs(f[0] - e[0]).max() for f, e in zip(found, exact, strict=True))
        audits[k] = max(f[1] for f in found)
    assert abs(np.log2(errors[0] / errors[-1]) / 3 - 6.0) < 0.8, np.diff(np.log2(errors))
    assert abs(np.log2(audits[1] / audits[-1]) / 2 - 6.0) < 0.5, np.diff(np.log2(audits))


def test_steps_are_halved_until_the_tolerance_is_met(seed, monkeypatch):
    monkeypatch.setattr("vsb.integrators.switching.RESOLVED", 1.0)
    one, time = scene(seed, 0, *LAWS["saturated"]), np.linspace(0.0, DURATION, 11)
    exact, _ = switched(System.of(one), np.linspace(0.0, DURATION, 401), one.start(*START), 1e-10)
    for tolerance in (1e-4, 1e-6, 1e-8):
        found, _ = switched(System.of(one), time, one.start(*START), tolerance)
        assert np.abs(found.position - exact.position[::40]).max() < tolerance * np.abs(exact.position).max()
    monkeypatch.setattr("vsb.integrators.switching.FINEST", 1)
    with pytest.raises(ConvergenceError, match=r"is not followed to 1e-14 by steps of .* raise simulation.tolerance"):
        switched(System.of(one), time, one.start(*START), 1e-14)


def test_springs_and_stops_count_from_rest(seed):
    """A buoy that rests elsewhere moves as one whose zero is there."""
    law, stop = LAWS["saturated"][0], replace(LAWS["end stop"][1], stroke=0.25)
    moved = [replace(x, rest=0.05) for x in (law, stop)]
    q, v = np.array([[0.2], [0.35], [-0.4]]), np.array([[0.1], [-0.2], [-0.3]])
    for there, here in zip(moved, (law, stop), strict=True):
        assert there.force(0.0, q + 0.05, v) == pytest.approx(here.force(0.0, q, v), rel=1e-12)
    one = scene(seed, 0, *moved)
    system, time = System.of(one), np.linspace(0.0, DURATION, 201)
    motion, _ = switched(system, time, one.start(*START))
    named = one.named(time, motion.position, motion.velocity)
    for name in ("pto", "end_stop"):
        assert motion.forces[name] == pytest.approx(named[name], abs=1e-6)
    assert np.abs(motion.forces["end_stop"]).max() > 100.0


def test_a_study_follows_them_by_the_same_door_in_legs(seed):
    one = scene(seed, 0, *LAWS["latching"])
    setting = Simulation(duration=6.0, window=(3.0, 6.0), initial_position=0.1, initial_velocity=0.2)
    whole, stride, method = simulate(System.of(one), NO_WAVES, setting, None)
    assert method.startswith("exponential collocation between switches, ")
    parts = list(legs(System.of(one), NO_WAVES, setting, None, longest=60))
    assert len(parts) > 2
    position = np.concatenate([part.motion.position[bool(i) :: part.stride] for i, part in enumerate(parts)])
    assert position == pytest.approx(whole.position[::stride], abs=1e-6)
    assert parts[-1].balance.residual < 1e-7


# a step, by hand -----------------------------------------------------------------------------------------------------

PORT = np.array([1.0, -0.7])


@pytest.fixture
def stepping(monkeypatch):
    """Function n(t, p), law -> a regime of two masses in a wave, in water that does n beyond its tangent."""
    forces = {
        "hydrostatic": Spring(np.array([[50.0, -10.0], [-10.0, 30.0]])),
        "structural_damping": Damper(np.diag([0.4, 0.2])),
        "excitation": Excitation(np.array([1.5, 2.0]), np.array([[3.0 - 1.0j, 0.5j], [-2.0, 1.0 + 1j]])),
    }
    system = System.of(Scene(("Heave", "Membrane0"), np.diag([2.0, 1.0]), forces, np.eye(2)))

    def by(n, held=False, step=0.2):
        def added(r, time, p):
            return np.array([n(t, x) for t, x in zip(time, p, strict=True)])

        for name in ("_places", "_tangent"):
            own = getattr(energy_preserving, name)
            monkeypatch.setattr(energy_preserving, name, getattr(own, "py_func", own))
        monkeypatch.setattr(energy_preserving, "added", added)
        monkeypatch.setattr(wet_phases, "added", added)
        monkeypatch.setattr(wet_phases, "settled", getattr(settled, "py_func", settled))
        one = WetPhase(system, system.shapes.T @ PORT, 4.0, 7.0, held, step, 0.1)
        one.__dict__["water"] = SimpleNamespace(round_off=0.0)
        return one

    return by


def stepped(one, t, z, f):
    """The state that begins a step, its coefficients unknown, and its error."""
    state = np.concatenate([z, [f], np.zeros(len(one.flow) - len(z) - 1)])
    return one.begun(t, state)


def followed(one, n, t, z, f, span):
    """Where an explicit method of order 8 goes."""
    order = len(z)

    def rates(s, z):
        push = (np.exp(-1j * one.system.omega * s) @ one.system.waves).real + n(s, z[:2])
        return one.matrix[:order, :order] @ z + one.matrix[:order, order] * f + one.system.input @ one.allowed @ push

    return solve_ivp(rates, (t, t + span), z, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


T, Z, F = 3.0, np.array([0.6, -0.8, 0.5, 0.3]), 1.7
COURSES = np.array([[0.3, -1.0], [2.0, 0.5], [-1.5, 4.0], [3.0, -2.0], [10.0, 20.0]])


def course(t, p):
    """A force of time alone: of degree four from `T` on."""
    return np.polynomial.polynomial.polyval(t - T, COURSES)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("share", [1.0, 0.37, 0.0])
def test_a_force_of_degree_four_is_followed_exactly_over_any_part_of_a_step(stepping, held, share):
    """A port that is held stays at rest under it."""
    one, span = stepping(course, held), 0.2 * share
    z = Z - (one.system.input @ one.port) * (one.port @ Z[2:]) / (one.port @ one.port) * held
    state, error = stepped(one, T, z, F)
    assert error == pytest.approx(0.0, abs=1e-12)
    found = one.states(np.array([T + span]), one.later(one.transient(T, state), span)[None])[0]
    np.testing.assert_allclose(found[:4], followed(one, course, T, z, F, span), atol=1e-10)
    assert found[4] == F
    if held:
        assert one.port @ found[2:4] == pytest.approx(0.0, abs=1e-12)


def test_the_force_carried_and_its_derivatives_are_those_of_its_polynomial(stepping):
    """As a step begins, and where it ends; what holds the port feels it."""
    one = stepping(course, True)
    state, _ = stepped(one, T, Z, F)
    ends = one.states(np.array([T + 0.2]), one.later(one.transient(T, state), 0.2)[None])
    for at, states in ((T, state[None]), (T + 0.2, ends)):
        for k, found in enumerate(one.added(states)):
            powers = np.polynomial.polynomial.polyder(COURSES, k)
            np.testing.assert_allclose(found[0], np.polynomial.polynomial.polyval(at - T, powers), rtol=1e-9)
    without = state.copy()
    without[5:] = 0.0
    pushes = [one.watched(np.array([T]), one_state[None]).push[0] for one_state in (state, without)]
    assert pushes[0] - pushes[1] == pytest.approx(COURSES[0] @ one.port / (one.port @ one.port), rel=1e-10)


def spring(t, p):
    """A force of position and time that is no polynomial."""
    return np.array([-3.0 * np.sin(p[0]) + p[1], np.cos(2 * t) - p[0] * p[1]])


def test_a_force_of_position_is_met_by_the_motion_it_makes(stepping):
    """To order six of the step; the error of it is told by what its polynomial misses between two nodes."""
    errors = []
    for step in (0.1, 0.05):
        one = stepping(spring, step=step)
        state, error = stepped(one, T, Z, F)
        found = one.states(np.array([T + step]), one.later(one.transient(T, state), step)[None])[0]
        errors.append(np.abs(found[:4] - followed(one, spring, T, Z, F, step)).max())
        there = one.states(np.array([T + 0.375 * step]), one.later(one.transient(T, state), 0.375 * step)[None])[0]
        missed = spring(T + 0.375 * step, there[:2]) - one.added(there[None])[0, 0]
        assert error == pytest.approx(step * np.linalg.norm(missed), rel=1e-6)
        assert error > 0
    assert errors[0] < 1e-6
    assert 2**6 < errors[0] / errors[1] < 2**8  # of one step a power more


def test_a_step_that_is_not_met_has_no_error_that_would_do(stepping, monkeypatch):
    one = stepping(spring)
    monkeypatch.setattr(wet_phases, "settled", lambda *_: STALLED)
    state, error = stepped(one, T, Z, F)
    assert error == np.inf
    assert not state[5:].any()


def test_where_no_step_came_before_the_force_is_as_it_is_there(stepping):
    """Of what was carried nothing is left."""
    one = stepping(spring)
    state = np.concatenate([Z, [F], np.arange(1.0, 11.0)])
    before, found = state.copy(), one.reset(state, T)
    np.testing.assert_array_equal(state, before)
    np.testing.assert_array_equal(found[:5], state[:5])
    np.testing.assert_allclose(found[5:7], spring(T, Z[:2]))
    assert not found[7:].any()


@pytest.mark.parametrize(("norm", "least", "round_off", "scale"), [
    (1.0, 0.3, 0.0, 1.0), (1.0, 2.0, 0.0, 2.0), (1.0, 0.3, 5e-10, 10.0),
])  # fmt: skip
def test_a_step_is_met_to_its_state_to_what_matters_or_to_round_off(
    stepping, monkeypatch, norm, least, round_off, scale
):
    asked = []
    one = stepping(spring)
    one.__dict__["water"] = SimpleNamespace(round_off=round_off)
    monkeypatch.setattr(System, "least", property(lambda _: least))
    monkeypatch.setattr(wet_phases, "settled", lambda *given: asked.append(given) or 1.0)
    stepped(one, T, norm * Z / np.linalg.norm(Z), F)
    ((water, _, time, _, push, n, found),) = asked
    assert found == pytest.approx(scale)
    np.testing.assert_allclose(time, T + 0.2 * np.array([0.0, 0.25, 0.5, 0.75, 1.0]))
    assert (push.shape, n.shape, push.any()) == ((5, 2), (5, 2), False)
    assert water is one.water


def test_the_search_for_a_force_begins_with_the_polynomial_carried(stepping, monkeypatch):
    """Its values at the nodes, from its Taylor coefficients in units of the step."""
    asked, one = [], stepping(course)
    monkeypatch.setattr(wet_phases, "settled", lambda *given: asked.append(given[5].copy()) or 1.0)
    scaled = COURSES * (0.2 ** np.arange(5) * np.array([1.0, 1.0, 2.0, 6.0, 24.0]))[:, None]
    one.begun(T, np.concatenate([Z, [F], scaled.ravel()]))
    np.testing.assert_allclose(asked[0], [course(T + 0.05 * k, None) for k in range(5)], rtol=1e-12)
