"""The first-order system of integrators is M q'' = sum of forces; clamps by the null space are those of Eq. 90."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLE, only_run, varied

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.exact import propagate
from vsb.engine.motion.forces import (
    ConstantForce,
    Damper,
    Excitation,
    QuadraticDrag,
    RadiationMemory,
    RelaxingDamper,
    Spring,
    SpringDamper,
)
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System, remainder
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import check_rank, constraint_drift, mode_basis
from vsb.errors import ConfigError
from vsb.models.build import assumed_pressure_design
from vsb.study.study import load

OMEGA = np.array([1.3, 2.1])


@pytest.fixture(scope="module")
def wet():
    """The paper's free shell under its assumed pressure."""
    study = varied(load(EXAMPLE.parent / "paper.yaml"), published=None)
    one = varied(study, designs={"VSWEC": study.designs["VSWEC"].model_dump()})
    return assumed_pressure_design(only_run(one), {}).scene


@pytest.fixture(scope="module")
def linear():
    """Three coupled masses with springs, two dampers, waves and a memory of two states."""
    rng = np.random.default_rng(11)
    roots = rng.normal(size=(4, 3, 3))
    mass, stiffness, pto, structural = (root @ root.T + np.eye(3) for root in roots)
    channel, turning = np.array([1.0, 0.5]), np.array([[0.0, 1.0], [-1.0, 0.0]])
    memory = RadiationModel(turning - np.outer(channel, channel) / 2, rng.normal(size=(2, 3)), channel)
    forces = {
        "hydrostatic": Spring(5 * stiffness),
        "pto": Damper(0.3 * pto),
        "structural_damping": Damper(0.1 * structural),
        "excitation": Excitation(OMEGA, rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3))),
        "radiation": RadiationMemory(memory),
    }
    return Scene(("Heave", "Radial2", "Radial3"), mass, forces, np.eye(3)[:, :2] + 0.1)


def moving(system, count=4):
    """Times and random states of the size of a motion."""
    time, rng = np.linspace(0.3, 1.7, count), np.random.default_rng(2)
    positions = np.linalg.solve(system.position, 0.02 * rng.normal(size=(system.free, count))).T
    return time, np.hstack([positions, rng.normal(size=(count, len(system.matrix) - system.free))])


@pytest.mark.parametrize("slack", [0.0, 0.3])
def test_compiled_forces_match_the_python_forces(wet, slack):
    """Also beside a spring that is slack away from the rest position."""
    dof = len(wet.labels)
    spring = SpringDamper(3e4 * np.eye(dof), np.zeros((dof, dof)), slack * np.arange(1.0, dof + 1))
    wet = replace(wet, forces={**wet.forces, "spring": spring})
    system = System.of(wet)
    time, z = moving(system)
    found = np.empty((len(time), system.free))
    for i, t in enumerate(time):
        remainder(system.remainder._replace(begin=0.2), t - 0.2, z[i, : system.free].copy(), found[i])
    expected = system.added(time, z)
    assert np.abs(expected).max() > 1.0
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(system.shapes.T @ wet.constant).max())


ALONG = np.array([0.5, -1.0, 2.0])


@pytest.fixture(scope="module")
def mixed(linear):
    """The three masses with a take-off behind a chamber, a slack spring, drag and a weight beside."""
    return replace(
        linear,
        forces={
            "radiation": linear.forces["radiation"], "hydrostatic": linear.forces["hydrostatic"],
            "pto": RelaxingDamper(2.0 * np.outer(ALONG, ALONG), ALONG, 4.0, 0.1),
            "mooring": SpringDamper(np.diag([1.0, 2.0, 3.0]), np.diag([0.3, 0.2, 0.1]), np.array([0.4, -0.5, 0.6])),
            "drag": QuadraticDrag(np.eye(3)[:2], np.array([3.0, 7.0]), OMEGA, np.ones((2, 2)) + 0.5j),
            "weight": ConstantForce(np.array([7.0, -1.0, 2.0])),
            "excitation": linear.forces["excitation"],
        },
    )  # fmt: skip


def test_all_kinds_of_forces_satisfy_the_equation_of_motion(mixed):
    """Two memories with their own states, a spring and a damper that are slack elsewhere."""
    system = System.of(mixed)
    time, z = moving(system)
    motion = system.motion(time, z, system.forcing(time, z), 0.0)
    named = system.forces(motion)
    total = sum(named.values()) @ mixed.motions
    inertia = motion.acceleration @ (mixed.motions.T @ mixed.mass @ mixed.motions)
    assert inertia == pytest.approx(total, abs=1e-11 * np.abs(total).max())
    q = motion.position @ mixed.motions.T
    chamber = motion.memory[:, 2:] @ mixed.forces["pto"].model.input_matrix
    assert named["pto"] == pytest.approx(-2.0 * np.outer(q @ ALONG, ALONG) - chamber, abs=1e-12)
    water = motion.memory[:, :2] @ mixed.forces["radiation"].model.input_matrix
    assert named["radiation"] == pytest.approx(-water, abs=1e-12)
    driven = system.driving(motion, named)
    assert driven == pytest.approx(system.forcing(time, z), abs=1e-11 * np.abs(driven).max())
    rows = slice(1, 3)
    assert system.added_during(time)(z[rows], rows) == pytest.approx(system.added(time, z)[rows], abs=1e-12)


def test_losses_of_two_memories(mixed):
    system = System.of(mixed)
    n, z = system.free, np.random.default_rng(3).normal(size=len(system.matrix))
    taken, lost, radiated = (z @ form @ z for form in system.losses())
    x = z[2 * n :]
    assert radiated == pytest.approx(x[:2] @ mixed.forces["radiation"].model.radiated @ x[:2])
    assert taken == pytest.approx(x[2] ** 2 / (4.0 * 0.1))
    v = z[n : 2 * n] @ system.shapes.T
    assert lost == pytest.approx(v @ mixed.forces["mooring"].damping @ v)


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


@pytest.mark.parametrize(
    ("clamps", "name", "degree"),
    [(CLAMPS["VSWEC90"], "paper", 6), (CLAMPS["repeated"], "membrane", 6), (CLAMPS["two"], "full", 20)],
)
def test_null_space_and_eq_90_give_the_same_motion(seed, clamps, name, degree):
    time = np.linspace(0.0, 60.0, 3001)
    (reduced, full), (system, _), _ = both_routes(seed, clamps, time, name, degree)
    for series in ("position", "velocity", "acceleration"):
        null_space = getattr(reduced, series) @ system.scene.motions.T
        assert (np.abs(null_space - getattr(full, series)).max() / np.abs(null_space).max()) < 1e-10, series
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
def test_indistinguishable_clamps_are_refused(seed, route):
    with pytest.raises(ConfigError, match=r"clamps closer than the basis resolves \(relative singular value"):
        route(mode_basis(seed.device, "membrane", 12), [1.0, 1.0 + 1e-9])
