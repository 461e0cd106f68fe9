"""Clamps by Eq. 90 of the publication (Udwadia-Kalaba) against clamps by the null space."""

from dataclasses import replace

import numpy as np
import pytest

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.exact import propagate
from vsb.engine.motion.forces import Damper, Excitation, RadiationMemory, Spring
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import check_rank, constraint_drift, mode_basis
from vsb.errors import ConfigError

PERIOD = 2.5
CLAMPS = {"VSWEC0": [0], "VSWEC90": [90], "two": [0, 90], "pair": [60, 120], "repeated": [0, 90, 90, 0, 180]}


def scene(seed, basis_name="membrane", degree=6, damping=8000.0):
    """Basis and unclamped plant: true shell and hydrostatics; made-up added mass, wave and small passive memory."""
    basis = mode_basis(seed.device, basis_name, degree)
    shell = DeformedShell(basis, seed.centre_height)
    n = np.array(basis.degrees)
    dof = len(n)
    alone = 2 * np.pi * 8.0 * 1025.0 / ((n + 1) * (2 * n + 1))  # half the water around a sphere
    added = np.diag(alone) + 0.2 / np.sqrt(dof) * np.sqrt(np.outer(alone, alone))
    channel = np.array([1.0, 0.7])
    turning = np.array([[0.0, 1.5], [-1.5, 0.0]])
    memory = RadiationModel(turning - np.outer(channel, channel) / 2, np.outer([30.0, 10.0], 1 / (1 + n)), channel)
    wave = Excitation(np.array([2 * np.pi / PERIOD]), np.array([(1 - 0.3j) * 4500.0 / (1 + n)]))
    forces = {
        "hydrostatic": Spring(shell.hydrostatic_stiffness(1025.0, 9.81, 120)),
        "elastic": Spring(basis.stiffness),
        "structural_damping": Damper(basis.damping),
        "pto": Damper(np.diag([damping] + [0.0] * (dof - 1))),
        "excitation": wave,
        "radiation": RadiationMemory(memory),
    }
    return basis, Scene(basis.labels, basis.inertia + added, forces, np.eye(dof))


def constrained(plant, rows):
    """All coordinates free but for Phi q = 0 by Eq. 90: in the natural modes, of mass 1, p'' = (1 - (Phi V)^+ Phi V) a."""
    every = np.eye(len(plant.labels))
    free = System.of(replace(plant, motions=every, origin=np.zeros(0), heave=plant.motions @ plant.heaving))
    held = rows @ free.shapes
    allowed = np.eye(free.free) - np.linalg.pinv(held, rcond=1e-10) @ held
    matrix, rates = free.matrix.copy(), slice(free.free, 2 * free.free)
    matrix[rates] = allowed @ matrix[rates]
    return replace(free, matrix=matrix, waves=free.waves @ allowed.T)


def both_routes(seed, clamps, time, basis_name="membrane", degree=6):
    """Motion of all coordinates by the null space and by Eq. 90, their systems, and the rows."""
    basis, plant = scene(seed, basis_name, degree)
    colatitudes = np.deg2rad(clamps)
    rows = basis.clamp_rows(colatitudes)
    reduced = System.of(replace(plant, motions=basis.clamped(colatitudes)))
    systems = reduced, constrained(plant, rows)
    motions = [propagate(s, time, s.scene.start(0.0, -0.8)) for s in systems]
    return motions, systems, rows


def difference(a, b):
    return np.abs(a - b).max() / np.abs(a).max()


@pytest.mark.parametrize(
    ("clamps", "name", "degree"),
    [(CLAMPS["VSWEC90"], "paper", 6), (CLAMPS["repeated"], "membrane", 6), (CLAMPS["two"], "full", 20)],
)
def test_null_space_and_eq_90_give_the_same_motion(seed, clamps, name, degree):
    time = np.linspace(0.0, 60.0, 3001)
    (reduced, full), (system, _), _ = both_routes(seed, clamps, time, name, degree)
    for series in ("position", "velocity", "acceleration"):
        null_space = getattr(reduced, series) @ system.scene.motions.T
        assert difference(null_space, getattr(full, series)) < 1e-10, series
    assert np.abs(reduced.position @ system.scene.motions.T)[:, 1:].max() > 1e-3  # the shell does move


def test_clamp_forces_close_the_equation_of_motion_and_do_no_work(seed):
    """What is missing in the equation of motion lies in the directions that clamps hold."""
    (motion, _), (system, _), rows = both_routes(seed, [0, 90], np.linspace(0.0, 20.0, 1001))
    plant = system.scene
    q, v, a = (s @ plant.motions.T for s in (motion.position, motion.velocity, motion.acceleration))
    wave = plant.excitation
    push = np.real(np.exp(-1j * np.outer(motion.time, wave.omega)) @ wave.phasors)
    matrices = {name: getattr(force, "stiffness", getattr(force, "damping", 0)) for name, force in plant.forces.items()}
    clamps = a @ plant.mass + q @ (matrices["hydrostatic"] + matrices["elastic"])
    clamps += v @ (matrices["structural_damping"] + matrices["pto"]) + motion.memory @ plant.memory.input_matrix - push
    size = np.abs(clamps).max()
    assert size > 1.0
    assert clamps == pytest.approx(clamps @ np.linalg.pinv(rows) @ rows, abs=1e-9 * size)
    assert np.abs(np.sum(clamps * v, axis=1)).max() < 1e-9 * size
    assert np.abs(clamps[:, 0]).max() < 1e-9 * size  # an inner force: none on the heave of the buoy


def test_constraint_drift_after_a_thousand_waves(seed):
    """Exact propagation: round-off for the null space, linear drift for Eq. 90."""
    drift = {}
    for waves in (100, 1000):
        time = np.arange(4 * waves + 1) * PERIOD / 4
        (reduced, full), (system, _), rows = both_routes(seed, [0, 90], time)
        drift[waves] = constraint_drift(full.position, rows)
        assert constraint_drift(reduced.position @ system.scene.motions.T, rows) < 1e-16
        assert drift[waves] < 1e-12 * waves
    assert drift[1000] > 1e-13  # it is there


ROUTES = {
    "rank": lambda basis, clamps: check_rank(basis.clamp_rows(clamps)),
    "null space": lambda basis, clamps: basis.clamped(clamps),
}


@pytest.mark.parametrize("route", ROUTES.values(), ids=ROUTES)
@pytest.mark.parametrize("apart", [1e-9])
def test_indistinguishable_clamps_are_refused(seed, route, apart):
    with pytest.raises(ConfigError, match=r"clamps closer than the basis resolves \(relative singular value"):
        route(mode_basis(seed.device, "membrane", 12), [1.0, 1.0 + apart])
