"""A causal controller as a filter: what it realises, its stability, its force cut at a limit, its motion in time."""

import numpy as np
import pytest
from motion.test_causal import buoy
from scipy.integrate import solve_ivp

from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.switching import Switching
from vsb.engine.motion.causal import NOISE, RmsLimits, optimum
from vsb.engine.motion.controller import FITTED, Controller, achieved, realised, within_limit
from vsb.engine.motion.forces import Damper, Excitation, Spring, TakeOff
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.errors import StabilityError


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_filter_realises_the_optimum(share):
    port = buoy()
    best = optimum(port, RmsLimits(share * optimum(port, RmsLimits(), 0.0, np.inf).force_rms / 3))
    gain = port.controller(best.weights)
    power, force = achieved(port, gain, NOISE)
    assert power == pytest.approx(best.power, rel=1e-5)
    assert force == pytest.approx(best.force_rms, rel=1e-3)
    assert achieved(port, gain)[1] < force  # without noise
    filtered, error = realised(port, gain)
    stable, margin = filtered.stability(port.omega, port.admittance)
    assert error <= FITTED
    assert stable
    assert margin == pytest.approx(1 / np.abs(1 - gain).max(), rel=0.05)


@pytest.mark.parametrize("damping", [2e3, -2e3, -2e4])
def test_nyquist_agrees_with_the_poles_of_the_loop(damping):
    """A damper beside an oscillator is stable until it gives more than the oscillator loses."""
    omega, mass, own, spring = np.arange(5e-3, 40.0, 1e-2), 3e4, 4e3, 8e4
    s = -1j * omega
    none = Controller(-np.eye(1), np.zeros(1), np.zeros(1), np.zeros(1), damping, 0.0)
    stable, margin = none.stability(omega, s / (mass * s**2 + own * s + spring))
    assert stable == (damping > -own)
    assert margin == pytest.approx(min(1.0, abs(1 + damping / own)), rel=1e-2)


def test_force_at_a_limit():
    """A limit out of reach changes little; a scarce one leaves a force that is at its limit nearly all the time."""
    port, free = buoy(), optimum(buoy(), RmsLimits())
    gain = within_limit(port, free, NOISE, 10 * free.force_rms)
    assert achieved(port, gain)[0] == pytest.approx(free.power, rel=1e-2)
    weak = within_limit(port, optimum(port, RmsLimits(1.0)), NOISE, 1.0)
    assert achieved(port, weak)[1] > 5.0


def test_unstable_filters_are_refused(monkeypatch):
    port = buoy()
    monkeypatch.setattr(Controller, "stability", lambda *_: (False, 0.0))
    with pytest.raises(StabilityError, match=r"pto\.law causal: no filter of up to 24 states"):
        realised(port, port.controller(optimum(port, RmsLimits(3e3)).weights))


@pytest.mark.parametrize("limit", [np.inf, 6.0])
def test_motion_agrees_with_an_independent_integrator(limit):
    """2 y'' + 0.3 y' + 50 y = waves - F, with a filter of two states that its own cut force drives."""
    filtered = Controller(
        np.array([[-0.5, 4.0], [-4.0, -0.5]]),
        np.array([1.0, 0.5]),
        np.array([0.1, -0.2]),
        np.array([3.0, -5.0]),
        1.0,
        -9.0,
    )
    law = TakeOff(np.ones(1), filtered.damping, filtered.stiffness, limit, controller=filtered)
    waves = Excitation(np.array([2.0, 4.3]), np.array([[30.0 + 5j], [-9j]]))
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "structural_damping": Damper(np.array([[0.3]]))}
    system = System.of(Scene(("Heave",), np.array([[2.0]]), forces | {"excitation": waves, "pto": law}, np.eye(1)))
    time = np.linspace(0.0, 12.0, 801)

    def rates(t, z):
        y, v, x = z[0], z[1], z[2:]
        taken = np.clip(filtered.damping * v + filtered.stiffness * y + filtered.output @ x, -limit, limit)
        wave = np.real(np.exp(-1j * waves.omega * t) @ waves.phasors[:, 0])
        return [
            v,
            (wave - 50 * y - 0.3 * v - taken) / 2,
            *(filtered.state_matrix @ x + filtered.of_velocity * v + filtered.of_force * taken),
        ]

    expected = solve_ivp(
        rates, (0.0, 12.0), [0.1, 0.3, 0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-13, t_eval=time, max_step=0.01
    )
    motion, switches = Switching(system).follow(time, (np.array([0.1]), np.array([0.3])))
    assert (switches > 8) or np.isinf(limit)
    assert motion.position[:, 0] == pytest.approx(expected.y[0], abs=1e-7)
    assert motion.memory == pytest.approx(expected.y[2:].T, abs=1e-6)
    assert residual(energies(system, motion)) < 1e-9
    if np.isfinite(limit):
        assert np.abs(motion.forces["pto"]).max() == pytest.approx(limit)
