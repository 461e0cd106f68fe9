"""Switching take-offs on the instantaneous wet shell: independent methods, order across events, energy."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import springs
from scipy.integrate import solve_ivp

from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.switching import Switching
from vsb.engine.motion.builders import assumed_pressure_scene
from vsb.engine.motion.controller import Controller
from vsb.engine.motion.forces import AssumedPressure, EndStop, TakeOff
from vsb.engine.motion.port import LinearPto, port_direction
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import StrainPort
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis, rigid_basis

B, START, DURATION = np.ones(1), (0.1, 0.2), 5.0
FILTER = Controller(
    np.array([[-0.5, 2.0], [-2.0, -0.5]]),
    np.array([60.0, 0.0]),
    np.array([0.0, 2e-3]),
    np.array([50.0, 20.0]),
    0.0,
    0.0,
)
LAWS = {
    "saturated": (TakeOff(B, 8e3, 2e4, 4e3), None),
    "coulomb": (TakeOff(B, np.inf, limit=4e3), None),
    "latching": (TakeOff(B, 8e3, latching_time=0.4), None),
    "declutching": (TakeOff(B, 3e4, latching_time=0.4, latching_damping=0.0), None),
    "end stop": (TakeOff(B, 8e3), EndStop(B, 0.3, 1e6, 1e4)),
    "controller": (TakeOff(B, 6e3, -1e4, 4e3, controller=FILTER), None),
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


@pytest.mark.parametrize("name", [pytest.param("saturated", marks=pytest.mark.slow), "end stop"])
def test_motion_agrees_with_an_explicit_method(seed, name):
    """Laws with kinks only: DOP853 steps over them, with some loss of accuracy."""
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
    found, switches = Switching(System.of(one), 1e-9).follow(time, one.start(*START))
    assert switches > 8
    assert found.position[:, 0] == pytest.approx(expected.y[0], abs=2e-7 * np.abs(expected.y[0]).max())


@pytest.mark.parametrize("name", ["coulomb", "latching", "end stop", "controller"])
def test_energy_audit_closes_and_forces_balance(seed, name):
    """A flexible shell from rest."""
    law, stop = LAWS[name]
    one = scene(seed, 2, law, stop)
    system, time = System.of(one), np.linspace(0.0, DURATION, 401)
    y, rate = one.start(*START)
    motion, switches = Switching(system, 1e-7).follow(time, (one.rest + y, rate))
    assert switches > 3
    assert residual(energies(system, motion)) < 1e-6
    assert motion.acceleration @ one.mass == pytest.approx(sum(system.forces(motion).values()), abs=1e-5)
    assert np.abs(motion.forces["pto"]).max() <= law.limit * (1 + 1e-12)
    if stop:  # without losses V sqrt(m/k)
        lossless = np.abs(motion.velocity[:, 0]).max() * np.sqrt(one.mass[0, 0] / stop.stiffness)
        assert 0.3 * lossless < np.abs(motion.position[:, 0]).max() - stop.stroke < lossless


@pytest.mark.parametrize("name", ["saturated", "latching"])
def test_motion_keeps_its_tolerance(seed, name):
    """However many instants one polynomial of the water's force reaches over."""
    law, stop = LAWS[name]
    system, time = System.of(scene(seed, 2, law, stop)), np.linspace(0.0, DURATION, 401)
    start = (system.scene.rest + system.scene.start(*START)[0], system.scene.start(*START)[1])
    exact, coarse = (system.states(Switching(system, tol).follow(time, start)[0]) for tol in (1e-9, 1e-5))
    error = np.linalg.norm(coarse - exact, axis=1).max() / np.linalg.norm(exact, axis=1).max()
    assert 1e-12 < error < 1e-5


@pytest.mark.parametrize("name", ["coulomb", pytest.param("latching", marks=pytest.mark.slow)])
def test_energy_audit_closes_at_a_port_of_strain(seed, name):
    """Tension against the change of area, of friction [N/m] or latched: the shell strains in steps."""
    law = {"coulomb": TakeOff(B, np.inf, limit=100.0), "latching": TakeOff(B, 2e3, latching_time=0.1)}[name]
    one = scene(seed, 2, law)
    shape = one.water.shell
    area = port_direction(StrainPort(strain="area"), DeformedShell(shape.basis, shape.centre_height, one.water.rest))
    one = replace(one, forces={**one.forces, "pto": replace(law, direction=area)})
    system, time = System.of(one), np.linspace(0.0, 1.3, 131)
    y, rate = one.start(*START)
    motion, switches = Switching(system, 1e-7).follow(time, (one.rest + y, rate))
    energy = energies(system, motion)
    assert switches >= 3  # slips, sticks, slips; one more where rounding decides the sign of the first velocity
    assert residual(energy) < 1e-6
    assert energy["pto"][-1] > 0
    if name == "coulomb":
        assert np.abs(motion.forces["pto"] @ area / (area @ area)).max() <= law.limit * (1 + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["saturated", "latching"])
def test_motion_is_within_its_tolerance_across_events(seed, name):
    """The tolerance alone sets the steps; energy is conserved far better."""
    one, starts = scene(seed, 0, *LAWS[name]), [(0.1, 0.2), (0.12, 0.15), (0.08, 0.25), (0.11, 0.3)]
    system = System.of(one)

    def run(start, tolerance):
        motion, switches = Switching(system, tolerance).follow(np.linspace(0.0, DURATION, 101), one.start(*start))
        return motion.position, residual(energies(system, motion)), switches

    exact = [run(start, 1e-12) for start in starts]
    for tolerance in (1e-4, 1e-6, 1e-8):
        found = [run(start, tolerance) for start in starts]
        assert [f[2] for f in found] == [e[2] for e in exact]
        assert max(np.abs(f[0] - e[0]).max() for f, e in zip(found, exact, strict=True)) < 2 * tolerance
        assert max(f[1] for f in found) < 1e-8


def test_springs_and_stops_act_from_the_rest_position(seed):

    law, stop = LAWS["saturated"][0], replace(LAWS["end stop"][1], stroke=0.25)
    moved = [replace(x, rest=0.05) for x in (law, stop)]
    q, v = np.array([[0.2], [0.35], [-0.4]]), np.array([[0.1], [-0.2], [-0.3]])
    for there, here in zip(moved, (law, stop), strict=True):
        assert there.force(0.0, q + 0.05, v) == pytest.approx(here.force(0.0, q, v), rel=1e-12)
    one = scene(seed, 0, *moved)
    system, time = System.of(one), np.linspace(0.0, DURATION, 201)
    motion, _ = Switching(system).follow(time, one.start(*START))
    named = one.named(time, motion.position, motion.velocity)
    for name in ("pto", "end_stop"):
        assert motion.forces[name] == pytest.approx(named[name], abs=1e-6)
    assert np.abs(motion.forces["end_stop"]).max() > 100.0
