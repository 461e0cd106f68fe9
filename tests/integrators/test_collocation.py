"""Exponential collocation: order 6 in smooth forces, to the tolerance where a force has a kink."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vsb.engine.integrators.collocation import NODES, SHORTEST, Collocation, collocated
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import legs, suited
from vsb.engine.motion.forces import Damper, Excitation, Force, Linear, QuadraticDrag, Spring
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import Sea
from vsb.errors import ConvergenceError

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
    """f = -a q^3 - b v^3."""

    def linear(self):
        return Linear(fully_linear=False)

    def force(self, time, q, v):
        return -40.0 * q**3 - 0.2 * v**3


@dataclass(frozen=True)
class Jumping(Smooth):
    """Coulomb friction as a discontinuous function of velocity."""

    def force(self, time, q, v):
        return -50.0 * np.sign(v)


def reference(force):
    """Position and velocity by DOP853 in steps shorter than the distance between kinks."""

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
    """Largest difference over the largest value, in the energy norm."""
    weights = np.sqrt([50.0, 2.0])
    away = np.linalg.norm((np.hstack([motion.position, motion.velocity]) - expected) * weights, axis=1)
    return away.max() / np.linalg.norm(expected * weights, axis=1).max()


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_quadratic_drag_is_integrated_to_the_tolerance(with_drag, tolerance):
    """Drag has a kink wherever the relative flow reverses; the error is below the tolerance but not needlessly small."""
    motion, steps = collocated(dragged(), TIME, START, tolerance)
    assert error(motion, with_drag) < tolerance
    assert error(motion, with_drag) > 1e-3 * tolerance
    assert steps < len(TIME)


def test_order_is_six():

    expected = reference(lambda y, _: -40 * y[0] ** 3 - 0.2 * y[1] ** 3)[[-1]]
    errors = []
    for steps in (100, 200, 400):
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


def test_mean_powers_agree_with_harmonic_balance():
    """Power of drag and take-off in the steady state, by the audit of a run and by harmonic balance."""
    period, settings = 2 * np.pi / OMEGA, Simulation(duration=60.0, window=(40.0, 60.0), tolerance=1e-7)
    assert suited(dragged()) == "collocation"
    (leg,) = legs(dragged(), Sea(np.array([OMEGA]), np.array([1.0 + 0j])), settings, None, longest=None)
    assert leg.balance.residual < 1e-7
    assert leg.method == "exponential collocation"
    late = leg.motion.time >= 60.0 - 8 * period - 1e-9
    mean = {term: np.polyfit(leg.motion.time[late], leg.energy[term][late], 1)[0] for term in ("pto", "drag")}
    found = harmonic_balance(dragged())
    assert mean["pto"] == pytest.approx(found.power.pto, rel=2e-3)  # of a line fitted to an oscillation
    assert mean["drag"] == pytest.approx(found.power.structural, rel=2e-3)
    last = np.flatnonzero(late)[-1]
    rate = found.at(leg.motion.time[last : last + 1])[1][0, 0].real
    assert leg.motion.velocity[last, 0] == pytest.approx(rate, abs=1e-6 * np.abs(leg.motion.velocity).max())


def test_discontinuous_force_is_refused():
    with pytest.raises(
        ConvergenceError,
        match=rf"cannot be followed at t = .* s: the step became shorter than {TIME[1] * 2.0**SHORTEST:.1e} s; check the "
        "study for forces that",
    ):
        collocated(system(friction=Jumping()), TIME, START, 1e-6)
