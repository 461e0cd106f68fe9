"""Exponential collocation: exact where linear, order 6 where smooth, to the tolerance where a force has a kink."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from vsb.errors import ConvergenceError
from vsb.integrators.collocation import GROWTH, NODES, SHORTEST, SPENT, Collocation, collocated, recorded, step_of
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


# two coordinates, and steps by hand ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mixed(Force):
    """Each coordinate's force depends on places and rates of both."""

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        first = -3 * q[:, 0] * q[:, 1] ** 2 - 0.05 * v[:, 1] * q[:, 0]
        return np.stack([first, 2 * q[:, 0] ** 3 - 0.4 * v[:, 0] * q[:, 1]], axis=1)


MASS2, SPRINGS2 = np.array([[2.0, 0.3], [0.3, 1.0]]), np.array([[50.0, -10.0], [-10.0, 30.0]])
DAMPERS2, PUSH2 = np.array([[1.2, 0.3], [0.3, 0.8]]), np.array([[30.0 + 5.0j, -4.0]])


def pair(**others):
    """Two coupled motions in a wave."""
    forces = {
        "hydrostatic": Spring(SPRINGS2), "pto": Damper(DAMPERS2), "excitation": Excitation(np.array([OMEGA]), PUSH2),
    }  # fmt: skip
    return System.of(Scene(("Heave", "Membrane0"), MASS2, forces | others, np.eye(2)))


def test_coupled_motions_are_those_of_an_independent_integrator():
    """From an instant that is not zero, at the records and in all their parts; forces are told along them."""
    time, start = np.linspace(2.0, 7.0, 101), (np.array([0.3, -0.2]), np.array([0.1, 0.4]))
    force = Mixed().force

    def rates(t, y):
        push = (np.exp(-1j * OMEGA * t) * PUSH2[0]).real + force(t, y[None, :2], y[None, 2:])[0]
        return np.concatenate([y[2:], np.linalg.solve(MASS2, push - SPRINGS2 @ y[:2] - DAMPERS2 @ y[2:])])

    run = solve_ivp(rates, (2.0, 7.0), np.concatenate(start), "DOP853", rtol=1e-12, atol=1e-13, t_eval=time)
    found, _ = collocated(pair(mixed=Mixed()), time, start, 1e-8)
    np.testing.assert_allclose(np.hstack([found.position, found.velocity]), run.y.T, atol=1e-7)
    exact = np.array([rates(t, y)[2:] for t, y in zip(time, run.y.T, strict=True)])
    np.testing.assert_allclose(found.acceleration, exact, atol=1e-5)


COURSES = np.array([[0.3, -1.0], [2.0, 0.5], [-1.5, 0.4], [0.3, -0.2], [0.1, 0.02]])


def stepped(monkeypatch, count, errors, tolerance=1e-3, begin=3.0, dt=0.25):
    """Levels, begins in records and limits of steps whose errors are such parts of their limits; records are checked.

    The force is a polynomial of degree four, which each step hands on to the next; after the last error there is none.
    """
    plant, asked, left, time = pair(), [], iter(errors), begin + dt * np.arange(count)
    first = plant.first((np.array([0.3, -0.2]), np.array([0.1, 0.4])))

    def course(t):
        return np.polynomial.polynomial.polyval(t - begin, COURSES).T

    def met(self, level, tick, z, f, limit):
        there = begin + dt * (tick * 2.0**SHORTEST + 2.0**level * np.arange(5) / 4)
        if asked:
            known = (
                5 if 2.0 ** (level + 1) <= count - 1 - tick * 2.0**SHORTEST else 1
            )  # else the run's end made it short
            np.testing.assert_allclose(f[:known], course(there)[:known], rtol=1e-6, atol=1e-6)
        asked.append((level, tick * 2.0**SHORTEST, limit))
        return course(there), next(left, 0.0) * limit

    monkeypatch.setattr(Collocation, "met", met)
    out, steps = Collocation(plant, dt, begin).run(time, first, tolerance)
    assert steps == len(asked)

    def rates(t, z):
        return plant.matrix @ z + plant.input @ course(np.array([t]))[0]

    exact = solve_ivp(rates, time[[0, -1]], first, "DOP853", rtol=1e-12, atol=1e-12, t_eval=time).y.T
    np.testing.assert_allclose(out, exact, atol=1e-9)
    return asked, out, plant


@pytest.mark.parametrize(("errors", "steps"), [
    ([], [(0, 0), (0, 1), (1, 2), (2, 4), (3, 8)]),
    ([0.9] * 99, [(0, k) for k in range(16)]),
    ([0.9 / GROWTH, 1.1 / GROWTH] * 9, [(0, k) for k in range(16)]),
    ([np.inf, np.inf], [(0, 0), (-1, 0), (-2, 0), (-2, 0.25), (-1, 0.5), (0, 1), (1, 2), (2, 4), (3, 8)]),
    ([0.0, 0.0, 0.0, np.inf, np.inf],
     [(0, 0), (0, 1), (1, 2), (2, 4), (1, 4), (0, 4), (0, 5), (1, 6), (2, 8), (2, 12)]),
])  # fmt: skip
def test_steps_become_twice_as_long_where_they_may_and_half_as_long_where_they_must(monkeypatch, errors, steps):
    """Twice where the error is below the limit over the growth, and from instants alone that such a step may begin at."""
    asked, *_ = stepped(monkeypatch, 17, errors)
    assert [given[:2] for given in asked] == steps


def test_steps_end_with_the_run_and_are_of_32_records_at_most(monkeypatch):
    assert [given[:2] for given in stepped(monkeypatch, 6, [])[0]] == [(0, 0), (0, 1), (1, 2), (0, 4)]
    levels = [level for level, *_ in stepped(monkeypatch, 161, [])[0]]
    assert levels == [0, 0, 1, 2, 3, 4, 5, 5, 5, 5]


@pytest.mark.parametrize(("part", "accepted"), [(0.99, True), (1.01, False)])
def test_a_step_may_err_by_its_share_and_a_part_of_what_others_left(monkeypatch, part, accepted):
    """Here all of the first step's; shares are of the largest state so far and of the time in which errors add up."""
    asked, out, plant = stepped(monkeypatch, 5, [0.0, 1 + part * SPENT])
    assert asked[2][:2] == ((0, 2) if accepted else (-1, 1))
    largest = np.maximum.accumulate(np.linalg.norm(out, axis=1))
    slowest = -np.linalg.eigvals(plant.matrix).real.max()
    horizon = min(1 / slowest, 1.0)
    first = max(largest[0], 0.25 * np.linalg.norm(plant.forcing(np.array([3.0]), out[:1])[0]))
    assert asked[0][2] == pytest.approx(1e-3 * first * min(0.25 / horizon, 1.0), rel=1e-9)
    assert asked[1][2] == pytest.approx(1e-3 * max(first, largest[1]) * min(0.25 / horizon, 1.0), rel=1e-6)
    if not accepted:
        assert asked[2][2] == pytest.approx(asked[1][2] / 2, rel=1e-9)


def test_a_step_is_met_where_its_last_change_is_a_hundredth_of_what_it_may_err_by(monkeypatch):
    """Of a force of places alone; one that grows from sweep to sweep is not met, and f stays what it was."""
    plant, f = pair(mixed=Mixed()), np.zeros((NODES, 2))
    z = plant.first((np.array([0.3, -0.2]), np.array([0.1, 0.4])))
    f[:] = plant.forcing(np.array([0.0]), z[None])
    method, known = Collocation(plant, 0.1), f.copy()
    loose, tight = (method.met(0, 0, z, f, limit)[0] for limit in (1e-3, 1e-12))
    np.testing.assert_array_equal(f, known)
    step, nodes = method.step(0), 0.025 * np.arange(5)
    states = np.vstack([z[None], (step.free @ z + step.forced @ tight.ravel())[step.nodes]])
    np.testing.assert_allclose(tight, plant.forcing(nodes, states), atol=1e-9)
    change = 0.1 * np.linalg.norm(loose - tight)
    assert 0 < change < 1e-5
    assert 0.1 * np.linalg.norm(loose[0] - f[0]) == 0.0
    there = (step.free @ z + step.forced @ tight.ravel())[2]
    seen = plant.forcing(np.array([0.0375]), there[None])[0]
    missed = seen - [np.polynomial.Polynomial.fit(nodes, values, 4)(0.0375) for values in tight.T]
    assert method.met(0, 0, z, f, 1e-12)[1] == pytest.approx(0.1 * np.linalg.norm(missed), rel=1e-3)
    far, error = Collocation(plant, 3.0).met(0, 0, 30 * z, f, 1e-6)
    assert far is f
    assert error == np.inf
