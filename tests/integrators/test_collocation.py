"""Exponential collocation: exact where linear, order 6 where smooth, to the tolerance where a force has a kink."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from vsb.errors import ConvergenceError
from vsb.integrators.collocation import NODES, SHORTEST, Collocation, collocated, recorded, step_of
from vsb.integrators.exact import propagate
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.simulate import legs, suited
from vsb.motion.forces import Damper, Excitation, Force, Linear, QuadraticDrag, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import TakeOff
from vsb.study.study import Simulation
from vsb.waves.seas import NO_WAVES, Sea

OMEGA, PUSH, FLOW, DRAG = 2.5, 30.0 + 5.0j, 0.2 - 0.1j, 3.0
LINEAR = {
    "hydrostatic": Spring(np.array([[50.0]])),
    "pto": Damper(np.array([[1.2]])),
    "excitation": Excitation(np.array([OMEGA]), np.array([[PUSH]])),
}
START = np.array([0.3]), np.array([0.1])
TIME = np.linspace(0.0, 30.0, 2401)


def system(**others):
    return System.of(Scene(("Heave",), np.array([[2.0]]), LINEAR | others, np.eye(1)))


def dragged():
    return system(drag=QuadraticDrag(np.eye(1), np.array([DRAG]), np.array([OMEGA]), np.array([[FLOW]])))


@dataclass(frozen=True)
class Smooth(Force):
    """f = -a q^3 - b v^3: smooth in both."""

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return -40.0 * q**3 - 0.2 * v**3


@dataclass(frozen=True)
class Jumping(Smooth):
    """Friction, written as a force that any state has: it jumps."""

    def force(self, time, q, v):
        """Return the force."""
        return -50.0 * np.sign(v)


def reference(force):
    """Position and velocity by an explicit method of order 8, a wave short of the kinks' distance at most a step."""

    def rates(t, y):
        wave = np.exp(-1j * OMEGA * t)
        return [y[1], (-50 * y[0] - 1.2 * y[1] + (PUSH * wave).real + force(y, (FLOW * wave).real)) / 2]

    run = solve_ivp(
        rates, TIME[[0, -1]], np.concatenate(START), method="DOP853", rtol=1e-13, atol=1e-14, t_eval=TIME, max_step=0.02
    )
    return run.y.T


@pytest.fixture(scope="module")
def with_drag():
    return reference(lambda y, flow: -DRAG * abs(y[1] - flow) * (y[1] - flow))


def error(motion, expected):
    """Largest difference over the largest value, both as roots of twice the energy."""
    weights = np.sqrt([50.0, 2.0])
    away = np.linalg.norm((np.hstack([motion.position, motion.velocity]) - expected) * weights, axis=1)
    return away.max() / np.linalg.norm(expected * weights, axis=1).max()


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8])
def test_a_kink_is_met_to_the_tolerance(with_drag, tolerance):
    """Drag has a kink at every turn of the flow: errors stay below the tolerance, and not for any price."""
    motion, steps = collocated(dragged(), TIME, START, tolerance)
    assert error(motion, with_drag) < tolerance
    assert error(motion, with_drag) > 1e-3 * tolerance
    assert steps < len(TIME)


def test_the_order_is_six():
    """Fixed steps in a smooth force of position and velocity, four refinements."""
    expected = reference(lambda y, _: -40 * y[0] ** 3 - 0.2 * y[1] ** 3)[[-1]]
    errors = []
    for steps in (100, 200, 400, 800):
        method, time = Collocation(system(smooth=Smooth()), 30.0 / steps), np.linspace(0.0, 30.0, steps + 1)
        z = method.system.first(START)
        f = np.tile(method.system.forcing(time[:1], z[None]), (NODES, 1))
        for i in range(steps):
            f, missed = method.met(0, i * 2**14, z, f, 1e-13)
            assert np.isfinite(missed)
            step = method.step(0)
            z = (step.free @ z + step.forced @ f.ravel())[-1]
            f = np.tile(f[-1], (NODES, 1))
        motion = method.system.motion(time[-1:], z[None], np.zeros((1, 1)), 0.0)
        errors.append(error(motion, expected))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert 5.5 < np.min(orders) <= np.max(orders) < 6.5


def test_a_linear_scene_is_followed_as_closely_as_asked():
    scene = system()
    exact = propagate(scene, TIME, START)
    found, steps = collocated(scene, TIME, START, 1e-6)
    assert error(found, np.hstack([exact.position, exact.velocity])) < 1e-6
    assert steps < len(TIME) / 5


def test_what_an_error_may_be_grows_with_the_motion(monkeypatch):
    """From rest on it costs next to nothing more than if the largest motion to come were known."""
    start = np.zeros(1), np.zeros(1)
    motion, steps = collocated(dragged(), TIME, start, 1e-6)
    largest = float(np.hypot(np.sqrt(50.0) * motion.position, np.sqrt(2.0) * motion.velocity).max())
    assert largest > 20 * TIME[1] * abs(PUSH) / np.sqrt(2.0)  # what is known of it at the begin
    monkeypatch.setattr(System, "least", property(lambda _: largest))
    _, known = collocated(dragged(), TIME, start, 1e-6)
    assert known <= steps < 1.1 * known


def test_rest_stays_rest():
    still = System.of(Scene(("Heave",), np.array([[2.0]]), {"hydrostatic": LINEAR["hydrostatic"], "drag": QuadraticDrag(
        np.eye(1), np.array([DRAG]), np.zeros(0), np.zeros((0, 1), dtype=complex))}, np.eye(1)))  # fmt: skip
    found, _ = collocated(still, TIME, (np.zeros(1), np.zeros(1)), 1e-6)
    assert not found.position.any()


def test_time_and_harmonics_take_the_same_power():
    """What drag and take-off take in the steady state, by the audit of a run and by harmonic balance; the audit closes."""
    period, settings = 2 * np.pi / OMEGA, Simulation(duration=60.0, window=(40.0, 60.0), tolerance=1e-7)
    assert suited(dragged()) == "collocation"
    (leg,) = legs(dragged(), Sea(np.array([OMEGA]), np.array([1.0 + 0j])), settings, None, longest=None)
    assert leg.balance.residual < 1e-7
    assert leg.method == "exponential collocation"
    late = leg.motion.time >= 60.0 - 8 * period - 1e-9
    mean = {term: np.polyfit(leg.motion.time[late], leg.energy[term][late], 1)[0] for term in ("pto", "drag")}
    found = harmonic_balance(dragged())
    assert mean["pto"] == pytest.approx(found.power.pto, rel=2e-3)  # of a straight line through a wavy one
    assert mean["drag"] == pytest.approx(found.power.structural, rel=2e-3)
    last = np.flatnonzero(late)[-1]
    rate = found.at(leg.motion.time[last : last + 1])[1][0, 0].real
    assert leg.motion.velocity[last, 0] == pytest.approx(rate, abs=1e-6 * np.abs(leg.motion.velocity).max())


def test_legs_join(with_drag):
    """A run cut into legs is the run in one."""
    sea, settings = Sea(np.array([OMEGA]), np.array([1.0 + 0j])), Simulation(duration=20.0, window=(10.0, 20.0))
    whole = next(iter(legs(dragged(), sea, settings, None, longest=None)))
    *_, last = legs(dragged(), sea, settings, None, longest=500)
    assert last.end[0] == pytest.approx(whole.end[0], abs=1e-6 * np.abs(whole.motion.position).max())
    assert last.balance.ended["drag"] == pytest.approx(whole.balance.ended["drag"], rel=1e-5)


def test_what_jumps_is_refused():
    with pytest.raises(
        ConvergenceError,
        match=rf"cannot be followed at t = .* s: the step became shorter than {TIME[1] * 2.0**SHORTEST:.1e} s; check the "
        "study for forces that",
    ):
        collocated(system(friction=Jumping()), TIME, START, 1e-6)


def test_switches_are_refused():
    with pytest.raises(ValueError, match="received a take-off that switches, needs smooth forces"):
        collocated(system(pto=TakeOff(np.ones(1), 1.0, limit=2.0)), TIME, START, 1e-6)


def test_a_still_sea_needs_no_waves():
    quiet = System.of(Scene(("Heave",), np.array([[2.0]]), {k: LINEAR[k] for k in ("hydrostatic", "pto")} | {
        "drag": QuadraticDrag(np.eye(1), np.array([DRAG]), NO_WAVES.omega, NO_WAVES.amplitude[:, None])}, np.eye(1)))  # fmt: skip
    found, _ = collocated(quiet, TIME, START, 1e-6)
    energy = 25 * found.position[:, 0] ** 2 + found.velocity[:, 0] ** 2
    assert (np.diff(energy) < 1e-9).all()
    assert energy[-1] < 0.01 * energy[0]


def test_matrices_of_a_step_of_any_parts_follow_what_its_polynomial_drives():
    """z' = A z + B f, f of degree four: at the ends of eight and of twelve parts, by steps of a block exponential."""
    plant, span, z = system(), 0.7, np.array([0.4, -1.1])
    a, b, powers = plant.matrix, plant.input[:, 0], np.array([0.3, -2.0, 1.0, 4.0, -3.0])
    block = np.zeros((7, 7))
    block[:2, :2] = a
    block[:2, 2] = b
    block[2:, 2:] = np.diag(np.arange(1.0, 5.0), 1)  # derivatives of powers of time, the lowest first
    f = np.polynomial.polynomial.polyval(span * np.arange(5) / 4, powers)
    for parts in (8, 12):
        step = step_of(plant, span, parts)
        assert step.span == span
        assert step.nodes.tolist() == [parts // 4 - 1, parts // 2 - 1, 3 * parts // 4 - 1, parts - 1]
        found = step.free @ z + step.forced @ f
        for i in range(parts):
            flow = expm(span * (i + 1) / parts * block)
            chain = flow[:2, :2] @ z + flow[:2, 2:] @ powers
            np.testing.assert_allclose(found[i], chain, atol=1e-12)


@pytest.mark.parametrize(
    ("level", "tick", "kept"),
    [(0, 2**14, [7]), (0, 2**15, [7]), (1, 2**15, [3, 7]), (2, 2**16, [1, 3, 5, 7]), (-1, 2**13, []), (-1, 2**14, [7])],
)
def test_recorded_are_the_ends_of_parts_at_recorded_instants(level, tick, kept):
    assert recorded(np.arange(8.0)[:, None], level, tick).ravel().tolist() == kept


def test_no_step_is_shorter_than_the_shortest_and_the_instant_is_told_from_the_begin_of_the_run():
    method = Collocation(system(), 0.25, 7.0)
    assert method.shorter(SHORTEST + 1, 0) == SHORTEST
    assert method.shorter(3, 0) == 2
    with pytest.raises(
        ConvergenceError, match=rf"followed at t = 7\.375 s: the step became shorter than {0.25 / 2**14:.1e} s"
    ):
        method.shorter(SHORTEST, 3 * 2**13)


def test_samples_of_steps_are_those_of_their_instants():
    """Waves at all parts of a step, of several levels, from wherever it begins: ahead, back and off the others' beat."""
    method = Collocation(system(), 0.25, 7.0)
    for level, tick in (
        (0, 0),
        (0, 2**14),
        (0, 2**14 * 130),
        (0, 2**13),
        (1, 2**15),
        (-2, 2**12),
        (-2, 3 * 2**12),
        (0, 0),
    ):
        samples, row = method.samples(level, tick)
        instants = 7.0 + 0.25 * (tick / 2**14 + 2.0**level * np.arange(9) / 8)
        np.testing.assert_allclose(samples.push[row : row + 9], method.system.push(instants), atol=1e-10)


def test_errors_add_up_until_the_slowest_motion_is_forgotten():
    """2 y'' + 1.2 y' + 50 y = 0 falls as exp(-0.3 t)."""
    assert Collocation(system(), 0.1).horizon == pytest.approx(1 / 0.3, rel=1e-9)
    assert Collocation(system(pto=Damper(np.array([[-0.4]]))), 0.1).horizon == np.inf
