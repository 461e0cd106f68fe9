"""Clamps by Eq. 90 (Udwadia-Kalaba) against clamps by the null space."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConfigError
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.exact import propagate
from vsb.motion.forces import Damper, Excitation, QuadraticDrag, RadiationMemory, Spring, SpringDamper
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.udwadia_kalaba import constrained, constraint_drift, constraint_force, udwadia_kalaba
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import check_rank, mode_basis
from vsb.stages.preview import check_before_run
from vsb.study.plan import StudyPlan

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


def both_routes(seed, clamps, time, basis_name="membrane", degree=6, rate=0.0):
    """Motion of all coordinates by the null space and by Eq. 90, their systems, and the rows."""
    basis, plant = scene(seed, basis_name, degree)
    colatitudes = np.deg2rad(clamps)
    rows = basis.clamp_rows(colatitudes)
    reduced = System.of(replace(plant, motions=basis.clamped(colatitudes)))
    systems = reduced, constrained(plant, rows, rate)
    motions = [propagate(s, time, s.scene.start(0.0, -0.8)) for s in systems]
    return motions, systems, rows


def difference(a, b):
    return np.abs(a - b).max() / np.abs(a).max()


@pytest.mark.parametrize("clamps", CLAMPS.values(), ids=CLAMPS)
@pytest.mark.parametrize(("name", "degree"), [("membrane", 6), ("paper", 6), ("full", 6), ("full", 20)])
def test_both_routes_are_one_motion_over_a_minute(seed, clamps, name, degree):
    time = np.linspace(0.0, 60.0, 3001)
    (reduced, full), (system, _), _ = both_routes(seed, clamps, time, name, degree)
    for series in ("position", "velocity", "acceleration"):
        null_space = getattr(reduced, series) @ system.scene.motions.T
        assert difference(null_space, getattr(full, series)) < 1e-10, series
    assert np.abs(reduced.position @ system.scene.motions.T)[:, 1:].max() > 1e-3  # the shell does move


@pytest.mark.parametrize("clamps", CLAMPS.values(), ids=CLAMPS)
def test_both_routes_give_the_clamps_the_same_forces(seed, clamps):
    motions, systems, rows = both_routes(seed, clamps, np.linspace(0.0, 20.0, 1001))
    null_space, eq_90 = (constraint_force(s, m, rows) for s, m in zip(systems, motions, strict=True))
    assert np.abs(null_space).max() > 1e3
    assert difference(null_space, eq_90) < 1e-9


def test_clamp_forces_close_the_equation_of_motion_and_do_no_work(seed):
    (motion, _), (system, _), rows = both_routes(seed, [0, 90], np.linspace(0.0, 20.0, 1001))
    plant = system.scene
    q, v, a = (s @ plant.motions.T for s in (motion.position, motion.velocity, motion.acceleration))
    wave = plant.excitation
    push = np.real(np.exp(-1j * np.outer(motion.time, wave.omega)) @ wave.phasors)
    matrices = {name: getattr(force, "stiffness", getattr(force, "damping", 0)) for name, force in plant.forces.items()}
    left = a @ plant.mass + q @ (matrices["hydrostatic"] + matrices["elastic"])
    left += v @ (matrices["structural_damping"] + matrices["pto"]) + motion.memory @ plant.memory.input_matrix - push
    clamps = constraint_force(system, motion, rows) @ rows
    assert clamps == pytest.approx(left, abs=1e-9 * np.abs(left).max())
    assert np.abs(np.sum(clamps * v, axis=1)).max() < 1e-12 * np.abs(clamps).max()
    assert np.all(clamps[:, 0] == 0.0)  # an inner force: none on the heave of the buoy


def test_drift_after_ten_thousand_waves(seed):
    """Exact propagation: null space round-off at all times; Eq. 90 drifts linearly, b of Baumgarte stops it."""
    drift = {}
    for waves in (1000, 10000):
        time = np.arange(4 * waves + 1) * PERIOD / 4
        (reduced, full), (system, _), rows = both_routes(seed, [0, 90], time)
        drift[waves] = constraint_drift(full.position, rows)
        assert constraint_drift(reduced.position @ system.scene.motions.T, rows) < 1e-16
        assert drift[waves] < 1e-12 * waves
    (_, held), _, rows = both_routes(seed, [0, 90], time, rate=1.0)
    assert drift[10000] > 1e-13  # it is there
    assert constraint_drift(held.position, rows) < 1e-13


@pytest.mark.parametrize(("slip", "rate"), [(0.0, 0.0), (1e-6, 0.0), (1e-6, 2.0)])
def test_drift_of_a_time_stepper(seed, slip, rate):
    """Runge-Kutta 4, 500 steps a wave: round-off; an initial error v of the clamp grows as v t unless stabilised."""
    basis, plant = scene(seed)
    rows = basis.clamp_rows([0.0])
    constraint = udwadia_kalaba(plant.mass, rows)
    k, d, wave, waves, step = plant.stiffness, plant.damping, plant.excitation, 20, PERIOD / 500

    def rates(time, z):
        q, v = z
        push = np.real(wave.phasors[0] * np.exp(-1j * wave.omega[0] * time))
        return np.array([v, constraint.acceleration(push - k @ q - d @ v, constraint.baumgarte(q, v, rate))])

    z, worst = np.zeros((2, len(k))), 0.0
    z[1, 0], z[1, 1:] = -0.8, slip * np.linalg.pinv(rows)[1:, 0]
    for time in np.arange(500 * waves) * step:
        a = rates(time, z)
        b = rates(time + step / 2, z + step / 2 * a)
        c = rates(time + step / 2, z + step / 2 * b)
        z = z + step / 6 * (a + 2 * b + 2 * c + rates(time + step, z + step * c))
        worst = max(worst, constraint_drift(z[:1], rows))
    expected = slip / (np.e * rate) if rate else slip * waves * PERIOD
    assert worst == pytest.approx(expected, rel=1e-4, abs=1e-12)
    assert np.abs(z).max() < 10.0


def symmetric(rng, size):
    factor = rng.normal(size=(size, size))
    return factor @ factor.T + np.eye(size)


@settings(max_examples=30)
@given(st.lists(st.integers(0, 12), max_size=4), st.integers(0, 1000))
def test_projector_and_correction_have_their_defining_properties(seed, clamps, number):
    basis = mode_basis(seed.device, "full", 20)
    rng = np.random.default_rng(number)
    mass, force = symmetric(rng, len(basis.labels)), rng.normal(size=(3, len(basis.labels)))
    rows = basis.clamp_rows(np.deg2rad(15.0 * np.array(clamps, dtype=float)))
    constraint = udwadia_kalaba(mass, rows)
    p = constraint.projector
    scale = np.abs(p).max()
    assert p @ p == pytest.approx(p, abs=1e-10 * scale)
    assert np.abs(rows @ p).max(initial=0.0) < 1e-10 * scale
    assert mass @ p == pytest.approx((mass @ p).T, abs=1e-9 * np.abs(mass @ p).max())  # orthogonal in the mass
    assert np.linalg.matrix_rank(p, tol=1e-6) == len(mass) - check_rank(rows)
    free = np.linalg.solve(mass, force.T).T
    assert constraint.acceleration(force) == pytest.approx(free @ p.T, abs=1e-9 * np.abs(free).max() * scale)
    total = force + constraint.force(force)
    moved = np.linalg.solve(mass, total.T).T
    assert moved == pytest.approx(constraint.acceleration(force), abs=1e-9 * scale)


def test_acceleration_is_the_one_of_least_constraint(seed):
    """Gauss: among all accelerations the clamps allow, |M^1/2 (q'' - a)| is least; Lagrange's saddle point solves it."""
    basis = mode_basis(seed.device, "full", 6)
    rng = np.random.default_rng(7)
    rows, size = basis.clamp_rows([0.4, 1.3]), len(basis.labels)
    mass, force, wanted = symmetric(rng, size), rng.normal(size=size), rng.normal(size=4)
    saddle = np.block([[mass, rows.T], [rows, np.zeros((4, 4))]])
    solution = np.linalg.solve(saddle, np.concatenate([force, wanted]))
    constraint = udwadia_kalaba(mass, rows)
    assert constraint.acceleration(force, wanted) == pytest.approx(solution[:size], rel=1e-10, abs=1e-11)
    assert constraint.force(force, wanted) == pytest.approx(-rows.T @ solution[size:], rel=1e-10, abs=1e-10)


def test_no_clamp_changes_nothing(seed):
    basis, plant = scene(seed)
    rows = basis.clamp_rows([])
    time = np.linspace(0.0, 5.0, 101)
    a, b = (propagate(s, time, plant.start(0.1, 0.0)) for s in (System.of(plant), constrained(plant, rows)))
    assert np.array_equal(a.position, b.position)
    assert constraint_drift(a.position, rows) == 0.0
    assert constraint_force(System.of(plant), a, rows).shape == (101, 0)


@pytest.mark.parametrize("degree", [6, 20, 40, 80])
@pytest.mark.parametrize(
    ("clamps", "rank"), [([0], 1), ([180], 1), ([0, 0, 0], 1), ([90, 90], 2), ([0, 90, 180], 4), ([33, 70, 33, 0], 5)]
)
def test_rank_of_repeated_and_polar_clamps(seed, clamps, rank, degree):
    rows = mode_basis(seed.device, "full", degree).clamp_rows(np.deg2rad(clamps))
    assert check_rank(rows) == rank
    assert check_rank(rows[:, 1:]) == rank
    assert check_rank(np.vstack([rows, rows])) == rank


def test_rank_of_nothing_is_zero():
    assert check_rank(np.zeros((0, 7))) == check_rank(np.zeros((4, 7))) == check_rank(np.zeros((4, 0))) == 0


@pytest.mark.parametrize("degree", [6, 12, 40])
@pytest.mark.parametrize(("apart", "rank"), [(1e-14, 2), (1e-3, 4), (1e-5, 4)])
def test_clamps_side_by_side_are_one_or_two(seed, degree, apart, rank):
    assert check_rank(mode_basis(seed.device, "full", degree).clamp_rows([1.0, 1.0 + apart])) == rank


ROUTES = {
    "rank": lambda basis, clamps: check_rank(basis.clamp_rows(clamps)),
    "null space": lambda basis, clamps: basis.clamped(clamps),
    "Eq. 90": lambda basis, clamps: udwadia_kalaba(np.eye(len(basis.labels)), basis.clamp_rows(clamps)),
}


@pytest.mark.parametrize("route", ROUTES.values(), ids=ROUTES)
@pytest.mark.parametrize("apart", [1e-9, 1e-10, 3e-11])
def test_clamps_that_cannot_be_told_apart_are_refused(seed, route, apart):
    with pytest.raises(ConfigError, match=r"clamps so near each other .* \(relative singular value \d.\de-\d\d; needs"):
        route(mode_basis(seed.device, "membrane", 12), [1.0, 1.0 + apart])


def test_a_study_with_clamps_a_billionth_apart_is_refused_before_anything_is_solved(seed):
    study = varied(seed, designs={"A": {"clamp": [60.0, 60.0 + np.rad2deg(1e-9)]}})
    with pytest.raises(ConfigError, match=r"clamps so near each other"):
        check_before_run(study, StudyPlan(study))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_drift_is_a_size_wherever_a_clamp_goes(sign):
    positions, rows = sign * np.array([[0.0, 0.1], [0.0, -0.3]]), np.array([[1.0, 0.0], [0.0, 0.5], [0.5, 2.0]])
    assert constraint_drift(positions, rows) == pytest.approx(0.6)
    assert constraint_drift(np.maximum(positions, 0.0), rows) == pytest.approx(0.2 if sign > 0 else 0.6)
    assert constraint_drift(positions, rows[:0]) == 0.0


def test_drift_is_the_displacement_of_the_worst_clamp(seed):
    basis = mode_basis(seed.device, "membrane", 6)
    rows = basis.clamp_rows([0.0, np.pi / 2])
    positions = np.zeros((3, len(basis.labels)))
    positions[1, 0], positions[2, 1] = 5.0, -0.02  # heave moves no shell; breathing moves it everywhere
    assert constraint_drift(positions[:2], rows) == 0.0
    assert constraint_drift(positions, rows) == pytest.approx(0.02)


@pytest.mark.parametrize("given", [(), (0.0,), (1.5,)], ids=["paper", "none", "stabilised"])
def test_what_is_held_is_pushed_only_by_a_stabilisation(seed, given):
    """Phi p'' = -2 gamma Phi p' - gamma^2 Phi p; without gamma, the paper's, nothing."""
    basis, plant = scene(seed, "membrane", 2)
    rows = basis.clamp_rows(np.array([0.0]))
    system, rate = constrained(plant, rows, *given), given[0] if given else 0.0
    n, held = system.free, rows @ system.shapes
    found = held @ system.matrix[n : 2 * n]
    np.testing.assert_allclose(found[:, n : 2 * n], -2 * rate * held, atol=1e-9 * np.abs(system.matrix).max())
    np.testing.assert_allclose(found[:, :n] * system.scale, -(rate**2) * held, atol=1e-9 * np.abs(system.matrix).max())


def test_all_motions_are_free_but_for_the_rows_whatever_a_scene_allowed_and_where_it_rested(seed):
    basis, plant = scene(seed, "membrane", 2)
    held = replace(
        plant, motions=basis.clamped(np.array([0.0])), origin=np.full(basis.clamped(np.array([0.0])).shape[1], 0.1)
    )
    rows = basis.clamp_rows(np.array([0.0]))
    found, free = constrained(held, rows, 1.5), constrained(plant, rows, 1.5)
    np.testing.assert_array_equal(found.scene.motions, np.eye(len(plant.labels)))
    assert found.scene.rest.tolist() == [0.0] * len(plant.labels)
    np.testing.assert_array_equal(found.matrix, free.matrix)
    np.testing.assert_array_equal(found.waves, free.waves)


def test_clamps_are_told_apart_by_themselves_whatever_moves_with_them(seed):
    """By their rows alone, which know neither mass nor modes: a study is refused before both are known."""
    basis, plant = scene(seed, "membrane", 12)
    rows = basis.clamp_rows([1.0, 1.0 + 1e-10])
    with pytest.raises(ConfigError) as alone:
        check_rank(rows)
    with pytest.raises(ConfigError) as moving:
        constrained(plant, rows)
    assert str(moving.value) == str(alone.value)


def test_forces_that_are_not_linear_are_told_by_their_names_and_others_are_not(seed):
    basis, plant = scene(seed, "membrane", 2)
    rows, drag = basis.clamp_rows([0.0]), QuadraticDrag(np.eye(4)[:1], np.ones(1), np.zeros(0), np.zeros((0, 1)) + 0j)
    slack = SpringDamper(np.eye(4), np.zeros((4, 4)), np.full(4, 0.1))
    with pytest.raises(
        ValueError, match=r"^Eq\. 90: received the nonlinear forces drag, slack, needs a linear scene; c"
    ):
        constrained(replace(plant, forces={"drag": drag, **plant.forces, "slack": slack}), rows)
