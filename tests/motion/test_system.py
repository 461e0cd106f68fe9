"""The first-order system of integrators, z' = A z + B (n + waves), is M q'' = sum of forces."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLE, only_run, varied

from vsb.engine.hydro.radiation import RadiationModel
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
