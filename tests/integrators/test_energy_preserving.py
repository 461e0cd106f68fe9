"""Structure-preserving steps: order, energy and passivity at any step size, agreement with exact and exponential."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import only_run, shipped, varied
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from benchmarks import hard_cases as hardcases
from vsb.errors import ConfigError, ConvergenceError
from vsb.integrators import energy_preserving as gauss
from vsb.integrators.audit import energies, residual
from vsb.integrators.energy_preserving import fixed_step, structure_preserving
from vsb.integrators.exact import propagate
from vsb.integrators.exponential import integrate
from vsb.integrators.simulate import simulate
from vsb.motion.forces import Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.scenes.build import SCENES
from vsb.study import study as config
from vsb.study.plan import StudyPlan
from vsb.waves.seas import Sea

STILL = [{"kind": "still"}]
REFINEMENTS = np.array([20, 40, 80, 160, 320])


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Function (study, design, changes) -> plant; hydro files are made once."""
    folder = tmp_path_factory.mktemp("hydro")

    def build(name, design, **changes):
        study = varied(config.load(shipped(name)), published=None, **changes)
        paths = hardcases.hydro_files(study, folder)
        one = varied(study, designs={design: study.designs[design].model_dump()})
        StudyPlan(one)
        return SCENES[one.hydro.model](only_run(one), paths).scene

    return build


def instants(duration, steps):
    return np.linspace(0.0, duration, steps + 1)


def stored(plant, motion):
    """Energy stored at every instant, relative to what went round."""
    energy = energies(System.of(plant), motion)
    return energy["stored"] / energy["turned"].max()


# order ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["seed", "body_exact", "paper"])
def test_order_is_four(scene, name):
    plant = scene(name, "FSB")
    start, duration = plant.start(0.1, -0.3), 10.0
    time = instants(duration, 320)
    exact = (
        integrate(System.of(plant), time, start, 1e-12)[0] if plant.water else propagate(System.of(plant), time, start)
    )
    errors = []
    for steps in REFINEMENTS:
        found = fixed_step(System.of(plant), instants(duration, steps), start)
        errors.append(np.abs(found.position - exact.position[:: 320 // steps]).max())
    orders = -np.diff(np.log2(errors))
    assert np.all(np.abs(orders - 4.0) < 0.3), orders


def test_substeps_are_steps(scene):
    plant = scene("body_exact", "FSB")
    start = plant.start(0.1, -0.3)
    fine, coarse = (
        fixed_step(System.of(plant), instants(4.0, 80), start, 1),
        fixed_step(System.of(plant), instants(4.0, 20), start, 4),
    )
    for name in ("position", "velocity", "acceleration", "memory"):
        assert getattr(coarse, name) == pytest.approx(getattr(fine, name)[::4], rel=1e-9, abs=1e-9)


# energy --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("per_period", [3, 20])
def test_undamped_linear_scene_keeps_its_energy_for_ten_thousand_periods(per_period):
    """Slow heave coupled with a shell mode a thousand times faster: what is lost is the round-off of so many steps.

    Of each step that of four sums of four products, whatever their order, measured by the energy H = L^T L: at most
    4 eps || |L| |P| |L^-1| ||, with the propagator P.
    """
    mass, springs = np.array([[2e4, 300.0], [300.0, 80.0]]), np.diag([1e5, 4e8])
    plant = Scene(("Heave", "Membrane0"), mass, {"elastic": Spring(springs)}, np.eye(2))
    steps = per_period * 10_000
    time = instants(10_000 * 2 * np.pi / np.sqrt(5.0), steps)
    motion = fixed_step(System.of(plant), time, (np.array([0.3, 1e-4]), np.array([0.2, 0.5])))
    q, v = motion.position, motion.velocity
    energy = 0.5 * (np.einsum("ti,ij,tj->t", v, mass, v) + np.einsum("ti,ij,tj->t", q, springs, q))
    step = [fixed_step(System.of(plant), time[:2], (unit[:2], unit[2:])) for unit in np.eye(4)]
    propagator = np.column_stack([np.concatenate([s.position[1], s.velocity[1]]) for s in step])
    root = np.linalg.cholesky(block_diag(springs, mass)).T
    sums = np.linalg.norm(np.abs(root) @ np.abs(propagator) @ np.abs(np.linalg.inv(root)), 2)
    assert sums < 2.0
    assert np.abs(energy / energy[0] - 1).max() < steps * 4 * np.finfo(float).eps * sums


@pytest.mark.parametrize("step", [0.02, 0.1, 0.5, 1.0])
def test_undamped_sphere_on_nonlinear_water_keeps_its_energy_at_any_step(scene, step):
    """The water's force is a cubic of heave while the waterline stays on the sphere: four points are exact."""
    plant = scene("paper", "FSB", pto={"damping": 0.0}, waves=STILL)
    motion = fixed_step(System.of(plant), instants(400 * step, 400), plant.start(1.2, -0.5))
    assert np.ptp(motion.position) > 2.0
    assert np.abs(stored(plant, motion)).max() < 1e-11


def test_undamped_shell_on_nonlinear_water_keeps_its_energy(scene):
    plant = scene("paper", "VSWEC", pto={"damping": 0.0}, waves=STILL, device={"damping": {"alpha": 0.0, "beta": 0.0}})
    motion = fixed_step(System.of(plant), instants(40.0, 800), plant.start(0.6, 0.0))
    assert np.abs(stored(plant, motion)).max() < 1e-7  # no polynomial: the rule's own error


@pytest.mark.parametrize(("name", "design"), [("seed", "VSWEC"), ("body_exact", "FSB"), ("body_exact", "VSWEC")])
def test_energy_never_grows_without_waves_at_any_step_size(scene, name, design):
    plant = scene(name, design, waves=STILL)

    @settings(max_examples=12)
    @given(step=st.floats(-2.5, 1.0), heave=st.floats(0.1, 0.5), velocity=st.floats(-1.0, 1.0))
    def passive(step, heave, velocity):
        motion = fixed_step(System.of(plant), instants(30 * 10.0**step, 30), plant.start(heave, velocity))
        energy = stored(plant, motion)
        assert np.diff(energy).max() < 1e-9
        assert np.abs(motion.position).max() < 5.0

    passive()


@pytest.mark.parametrize("name", ["seed", "body_exact"])
def test_a_step_far_too_long_stays_bounded(scene, name):
    """Eight steps of 12 periods each, and two hundred of a period and a half, in waves."""
    plant = scene(name, "VSWEC")
    for steps, duration in ((8, 240.0), (200, 750.0)):
        motion = fixed_step(System.of(plant), instants(duration, steps), plant.start(0.0, 0.0))
        assert np.abs(motion.position).max() < 2.0


def test_the_audit_closes(scene):
    plant = scene("body_exact", "FSB")
    motion, _ = structure_preserving(System.of(plant), instants(20.0, 1600), plant.start(0.0, -0.8), 1e-8)
    assert residual(energies(System.of(plant), motion)) < 1e-6


# agreement -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
@pytest.mark.parametrize(("name", "design"), [("seed", "VSWEC"), ("body_exact", "FSB"), ("body_exact", "VSWEC")])
def test_the_error_is_within_the_tolerance(scene, name, design, tolerance):
    plant = scene(name, design)
    start, time = plant.start(0.1, -0.5), instants(8.0, 80)
    found, steps = structure_preserving(System.of(plant), time, start, tolerance)
    exact = (
        integrate(System.of(plant), time, start, 1e-12)[0] if plant.water else propagate(System.of(plant), time, start)
    )
    error = np.abs(found.position - exact.position).max()
    assert error < 2 * tolerance * np.abs(exact.velocity).max()
    assert steps % 80 == 0
    assert np.abs(found.memory - exact.memory).max() < 10 * tolerance * np.abs(exact.memory).max()


def test_a_shell_that_rests_on_a_large_load_starts_to_move(scene):
    """At rest the forces' round-off is all there is to iterate on: it is no failure."""
    plant = scene(
        "seed", "VSWEC", device={"internal_pressure": 16.5e3}, modes={"degree": 2}, hydro={"model": "body_exact"}
    )
    time = instants(4.0, 256)
    found = fixed_step(System.of(plant), time, plant.start(0.0, 0.0))
    exact, _ = integrate(System.of(plant), time, plant.start(0.0, 0.0), 1e-10)
    assert np.abs(found.position - exact.position).max() < 1e-5


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_what_stays_at_rest_is_followed_by_the_longest_steps(scene, design):
    """Its motion is round-off, which no shorter step knows better: measured against itself it would need all of them."""
    rests = {"device": {"internal_pressure": 16.5e3}, "modes": {"basis": "full", "degree": 3}, "waves": STILL}
    plant = scene("seed", design, **rests, reference_shape="equilibrium", hydro={"model": "body_exact"})
    time = instants(4.0, 100)
    found, steps = structure_preserving(System.of(plant), time, plant.start(0.0, 0.0), 1e-9)
    assert steps <= 400
    assert np.abs(found.position).max() < 1e-9


def test_an_assumed_pressure_is_followed(scene):
    plant = scene("paper", "VSWEC0")
    time = instants(5.0, 200)
    found, _ = structure_preserving(System.of(plant), time, plant.start(0.0, 0.0), 1e-8)
    exact, _ = integrate(System.of(plant), time, plant.start(0.0, 0.0), 1e-12)
    assert np.abs(found.position - exact.position).max() < 1e-7
    assert np.abs(found.acceleration[:, 0] - exact.acceleration[:, 0]).max() < 1e-5


def test_a_record_may_start_at_any_time(scene):
    plant = scene("body_exact", "FSB")
    time = instants(6.0, 120)
    whole = fixed_step(System.of(plant), time, plant.start(0.0, 0.0), 2)
    shifted = fixed_step(System.of(scene("seed", "FSB")), time + 2.5, scene("seed", "FSB").start(0.1, 0.0))
    again = fixed_step(System.of(scene("seed", "FSB")), time, scene("seed", "FSB").start(0.1, 0.0))
    assert shifted.position == pytest.approx(again.position, abs=1e-10)  # a period later
    later = fixed_step(System.of(plant), time + 2.5, plant.start(0.0, 0.0), 2)
    assert later.position == pytest.approx(whole.position, abs=1e-10)


@pytest.mark.parametrize(("name", "at"), [("seed", 37), ("body_exact", 37), ("body_exact", 84)])
def test_a_record_goes_on_where_another_ended_in_the_middle_of_a_period(scene, name, at):
    plant, time = scene(name, "FSB"), instants(6.0, 120)
    system = System.of(plant)
    whole = fixed_step(system, time, plant.start(0.1, 0.0), 2)
    end = whole.position[at], whole.velocity[at], whole.memory[at]
    assert fixed_step(system, time[at:], end, 2).position == pytest.approx(whole.position[at:], abs=1e-8)


# errors --------------------------------------------------------------------------------------------------------------


def test_a_step_without_a_solution_says_so(scene):
    plant = scene("body_exact", "VSWEC")
    with pytest.raises(ConvergenceError, match=r"a step of 50 s at t = 0 s: .*needs a shorter step"):
        fixed_step(System.of(plant), instants(100.0, 2), plant.start(0.0, 1e200))


def test_a_tolerance_out_of_reach_says_so(scene, monkeypatch):
    monkeypatch.setattr(gauss, "FINEST", 2)
    plant = scene("seed", "FSB")
    with pytest.raises(ConvergenceError, match=r"known to .*e-.*, needs 1e-12; raise simulation.tolerance"):
        structure_preserving(System.of(plant), instants(10.0, 20), plant.start(0.1, 0.0), 1e-12)


# the workflow's own call ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["seed", "body_exact"])
def test_a_study_may_ask_for_it(name):
    study = config.load(shipped(name))
    assert varied(study, simulation={"method": "structure_preserving"}).simulation.method == "structure_preserving"
    with pytest.raises(ConfigError, match=r"simulation.method 'structure_preserving': .*'auto' needs one of auto"):
        varied(study, simulation={"method": "structure_preserving"}, hydro={"model": "auto"})


@pytest.mark.parametrize("name", ["seed", "body_exact"])
def test_a_run_with_it_closes_its_audit(scene, name):
    plant = scene(name, "FSB")
    settings = config.load(shipped(name)).simulation
    short = settings.model_copy(update={"duration": 10.0, "method": "structure_preserving", "tolerance": 1e-7})
    sea = Sea(plant.excitation.omega, np.array([0.179 + 0j]))
    motion, _, method = simulate(System.of(plant), sea, short, None)
    assert method.startswith("structure-preserving, ")
    assert residual(energies(System.of(plant), motion)) < 1e-7


def test_what_predicts_the_next_step_is_the_polynomial_through_this_one():
    """Values at the nodes of a polynomial of as many terms go over into those a whole step later."""
    for power in range(gauss.NODES):
        np.testing.assert_allclose(gauss._AHEAD @ gauss._NODE**power, (gauss._NODE + 1) ** power, rtol=1e-12)


@pytest.mark.parametrize("way", [1, -1])
def test_a_place_a_thousand_radii_away_is_beyond_any_shell(scene, way):
    """There the water's force is not finite, so that a step is not solved; nearer it is."""
    plant = scene("paper", "FSB")
    r = System.of(plant).remainder
    away = way * gauss.FAR * plant.water.shell.shape.radius / r.position[0, 0]
    near, far = (gauss.added.py_func(r, np.zeros(1), np.array([[share * away]])) for share in (0.999, 1.001))
    assert np.isfinite(near).all()
    assert np.isinf(far).all()


# inside a step -------------------------------------------------------------------------------------------------------


def test_places_newtons_method_asks_for_are_on_either_side_of_the_nodes():
    """First the nodes, then all of them moved along each coordinate, then back along each."""
    p, time = np.arange(12.0).reshape(4, 3), np.array([0.1, 0.2, 0.4, 0.7])
    places, times = gauss._places.py_func(p, time, 0.25, True)
    sides = [p, *(p + 0.25 * unit for unit in np.eye(3)), *(p - 0.25 * unit for unit in np.eye(3))]
    np.testing.assert_array_equal(places, np.concatenate(sides))
    np.testing.assert_array_equal(times, np.tile(time, 7))
    places, times = gauss._places.py_func(p, time, 0.25, False)
    np.testing.assert_array_equal(places, p)
    np.testing.assert_array_equal(times, time)


def stepped(nodes=4, free=2, seed=3):
    """A step whose matrices are random, what is known of the positions at its nodes, and what pushes there."""
    rng = np.random.default_rng(seed)
    forced = rng.normal(size=(nodes * free, nodes * free))
    none = np.zeros((0, 0))
    return gauss.Step(0.3, none, forced, none, none), rng.normal(size=nodes * free), rng.normal(size=(nodes, free))


def law(time, p):
    """A force of two coordinates, each of which feels the other, and of time."""
    return np.stack([np.sin(p[:, 0]) + 0.3 * p[:, 1] ** 2 + time, p[:, 0] * p[:, 1] - np.cos(2 * p[:, 1])], axis=1)


def test_the_tangent_is_the_derivative_of_what_is_missing():
    """By what n at any node and of any coordinate does to the positions at all others."""
    step, carried, push = stepped()
    time, n, moved = np.array([0.1, 0.2, 0.4, 0.7]), np.ones((4, 2)), 1e-5

    def missing(n):
        return (law(time, (carried + step.forced @ n.ravel()).reshape(4, 2)) + push - n).ravel()

    places, times = gauss._places.py_func((carried + step.forced @ n.ravel()).reshape(4, 2), time, moved, True)
    found = gauss._tangent.py_func(step, law(times, places)[4:], moved, 4, 2)
    for k, unit in enumerate(np.eye(8)):
        slope = (missing(n + 1e-5 * unit.reshape(4, 2)) - missing(n - 1e-5 * unit.reshape(4, 2))) / 2e-5
        np.testing.assert_allclose(found[:, k], slope, atol=1e-8)


def solved(monkeypatch, force, step, carried, push, first):
    """Last change and n of a step, and the places at the nodes that were asked for, by how many at once."""
    asked = []

    def added(r, time, p):
        asked.append((len(p) // len(first), p[: len(first)].copy()))
        return force(time, p)

    monkeypatch.setattr(gauss, "added", added)
    for name in ("_places", "_tangent"):
        own = getattr(gauss, name)
        monkeypatch.setattr(gauss, name, getattr(own, "py_func", own))  # compiled for this alone it takes seconds
    n, time = first.copy(), np.linspace(0.1, 0.4, len(first))
    change = gauss.settled.py_func(None, step, time, carried, push, n, 2.0)
    return change, n, asked, time


@pytest.mark.parametrize("strength", [1e-3, 0.3, 5.0])
def test_a_step_is_met_by_substitution_where_that_is_quick_and_else_by_newtons_method(monkeypatch, strength):
    """Newton's method begins where the step did, not where substitution went. A spring that hardens, against its n."""
    step, carried, push = stepped()
    step = step._replace(forced=step.forced @ step.forced.T)

    def force(time, p):
        return -strength * (p + p**3 / (1 + p**2)) - time[:, None]

    first = np.full((4, 2), 0.25)
    change, n, asked, time = solved(monkeypatch, force, step, carried, push, first)
    assert change < gauss.STALLED
    places = (carried + step.forced @ n.ravel()).reshape(4, 2)
    np.testing.assert_allclose(n, force(time, places) + push, rtol=1e-8, atol=1e-9)
    newton = [at for count, at in asked if count > 1]
    assert bool(newton) == (strength > 0.1)
    if newton:
        np.testing.assert_array_equal(newton[0], asked[0][1])


def test_what_a_step_begins_with_is_no_part_of_its_answer(monkeypatch):
    """A linear force is met by one Newton step from anywhere."""
    step, carried, push = stepped()
    matrix = np.array([[3.0, -1.0], [2.0, 4.0]])
    exact = np.linalg.solve(
        np.eye(8) - np.kron(np.eye(4), matrix.T) @ step.forced, (carried.reshape(4, 2) @ matrix + push).ravel()
    )
    for first in (np.zeros((4, 2)), np.arange(8.0).reshape(4, 2)):
        change, n, asked, _ = solved(monkeypatch, lambda _, p: p @ matrix, step, carried, push, first)
        np.testing.assert_allclose(n.ravel(), exact, rtol=1e-8)
        assert change < gauss.STALLED
        assert len(asked) < 12


def test_the_step_that_is_not_solved_is_told_by_its_begin(monkeypatch):
    """The fourth of steps of a quarter second from 4 s on begins at 4.75 s."""
    flat = SimpleNamespace(
        check_compiled=lambda: None, matrix=np.zeros((2, 2)), free=1, remainder=SimpleNamespace(round_off=0.0),
        least=1e-6, push=lambda time: np.zeros((len(time), 1)),
    )  # fmt: skip
    monkeypatch.setattr(gauss, "_march", lambda *given: 3)
    words = r"^a step of 0\.25 s at t = 4\.75 s: its equations are not solved in 40 Newton iterations, needs a shorter"
    with pytest.raises(ConvergenceError, match=words):
        gauss.GaussIntegrator(flat).run(np.zeros(2), np.array([4.0, 4.5, 5.0]), 2)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("share", "steps"), [(0.99, 8 * 3), (1.01, 16 * 3)])
def test_steps_are_halved_until_a_fifteenth_of_the_difference_is_within_the_tolerance(monkeypatch, share, steps, way):
    """Of the largest norm of a state, here 5; steps too long to be solved are passed over."""
    tolerance, asked = 1e-3, []

    def run(self, first, time, substeps):
        asked.append(substeps)
        if substeps < 4:
            raise ConvergenceError("too long")
        error = {4: 0.0, 8: way * share, 16: way * share}[substeps] * 15 * 5.0 * tolerance
        return np.array([[0.0, 0.0], [3.0, -4.0], [1.0, 0.0], [0.0, -2.0 + error]])

    monkeypatch.setattr(gauss.GaussIntegrator, "run", run)
    monkeypatch.setattr(gauss.GaussIntegrator, "motion", lambda self, time, states, seconds: states)
    still = SimpleNamespace(first=lambda start: np.zeros(2), least=1e-9)
    _, found = structure_preserving(still, np.linspace(0.0, 3.0, 4), (), tolerance)
    assert found == steps
    assert asked == [1, 2, 4, 8, 16][: len(asked)]


def test_a_motion_below_what_matters_is_measured_against_that(monkeypatch):
    """Its own largest norm is 1e-3, what matters 1."""
    monkeypatch.setattr(gauss.GaussIntegrator, "run", lambda *given: np.array([[1e-3, 0.0], [0.0, 1e-3 / given[-1]]]))
    monkeypatch.setattr(gauss.GaussIntegrator, "motion", lambda self, time, states, seconds: states)
    still = SimpleNamespace(first=lambda start: np.zeros(2), least=1.0)
    assert structure_preserving(still, np.array([0.0, 1.0]), (), 0.5e-3 / 15 * 1.01)[1] == 2
    assert structure_preserving(still, np.array([0.0, 1.0]), (), 0.5e-3 / 15 * 0.99)[1] == 4


def test_what_is_not_known_to_the_tolerance_is_told_with_both(monkeypatch):
    """Of the last two of all steps tried: they differ by 15/1024 of a norm of 2."""
    monkeypatch.setattr(gauss.GaussIntegrator, "run", lambda *given: np.array([[2.0], [15 * 2.0 / given[-1]]]))
    still = SimpleNamespace(first=lambda start: np.zeros(1), least=0.0)
    words = r"steps of 0\.00049 s: the motion is known to 9\.8e-04, needs 1e-09; raise simulation.tolerance"
    with pytest.raises(ConvergenceError, match=words):
        structure_preserving(still, np.array([1.0, 1.5]), (), 1e-9)


def test_a_linear_step_is_gauss_method_of_two_stages():
    """Its propagator is the Pade approximant (1 + x/2 + x^2/12)/(1 - x/2 + x^2/12) of exp x, forces are of its stages."""
    rng, h, free = np.random.default_rng(5), 0.3, 2
    a = rng.normal(size=(5, 5))
    step, x, one = gauss.step_matrices(a, free, h), h * a, np.eye(5)
    even = one + x @ x / 12
    np.testing.assert_allclose(step.end_free, np.linalg.solve(even - x / 2, even + x / 2), atol=1e-12)
    assert step.size == h
    z, (low, high) = rng.normal(size=5), 0.5 + np.array([-1.0, 1.0]) / np.sqrt(12.0)
    force = rng.normal(size=(2, 2))  # linear in time, so that its moments are those of the two stages

    def push(c):
        return [0.0, 0.0, *(force[0] + c * force[1]), 0.0]

    root = np.sqrt(3.0) / 6
    stages = np.array([[0.25, 0.25 - root], [0.25 + root, 0.25]])
    at = [a @ z + push(c) for c in (low, high)]
    k = np.linalg.solve(np.eye(10) - h * np.kron(stages, a), np.ravel(at)).reshape(2, 5)
    n = np.array([push(c)[2:4] for c in gauss._NODE]).ravel()
    np.testing.assert_allclose(step.end_free @ z + step.end_forced @ n, z + h * k.mean(axis=0), atol=1e-12)
    inside = (step.free @ z + step.forced @ n).reshape(gauss.NODES, 2)
    for c, place in zip(gauss._NODE, inside, strict=True):  # the polynomial through z whose rates at both stages are k
        rate = np.array([c * high - c**2 / 2, c**2 / 2 - c * low]) / (high - low)
        np.testing.assert_allclose(place, (z + h * rate @ k)[:2], atol=1e-12)


def test_equal_steps_are_the_records_unless_more_are_asked_for(monkeypatch):
    asked = []
    monkeypatch.setattr(gauss.GaussIntegrator, "run", lambda self, first, time, substeps: asked.append(substeps) or "z")
    monkeypatch.setattr(gauss.GaussIntegrator, "motion", lambda self, time, states, seconds: (time, states))
    still = SimpleNamespace(first=lambda start: start)
    assert fixed_step(still, "time", "start") == fixed_step(still, "time", "start", 3) == ("time", "z")
    assert asked == [1, 3]


@pytest.mark.parametrize("failing", [None, 0, 3, 5])
def test_a_march_goes_from_step_to_step_until_one_is_not_solved(monkeypatch, failing):
    """Two steps a record: n begins as the polynomial of the step before goes on, beside what pushes now."""
    rng, h, least = np.random.default_rng(7), 0.2, 0.9
    a, push, first = rng.normal(size=(3, 3)), rng.normal(size=(6, 4, 1)), np.array([0.3, -0.2, 0.4])
    step, asked, answers = gauss.step_matrices(a, 1, h), [], rng.normal(size=(6, 4, 1))

    def settled(r, step, time, carried, pushed, n, scale):
        i = len(asked)
        asked.append((time.copy(), carried.copy(), pushed.copy(), n.copy(), scale))
        n[:] = answers[i]
        return gauss.STALLED if i == failing else 0.5 * gauss.STALLED

    monkeypatch.setattr(gauss, "settled", settled)
    out = np.zeros((4, 3))
    out[0] = first
    r = SimpleNamespace(constant=np.zeros(1))
    done = gauss._march.py_func(r, step, 3.0, push, least, 2, out)
    assert done == (6 if failing is None else failing)
    z, largest, n = first, least, np.zeros((4, 1))
    for i, (time, carried, pushed, begun, scale) in enumerate(asked):
        largest = max(largest, np.linalg.norm(z))
        np.testing.assert_allclose(time, 3.0 + h * (i + gauss._NODE), rtol=1e-13)
        np.testing.assert_allclose(carried, step.free @ z, rtol=1e-13)
        np.testing.assert_array_equal(pushed, push[i])
        np.testing.assert_allclose(begun, n, atol=1e-12)
        assert scale == pytest.approx(largest, rel=1e-13)
        z = step.end_free @ z + step.end_forced @ answers[i].ravel()
        if i < done and i % 2:
            np.testing.assert_allclose(out[(i + 1) // 2], z, rtol=1e-12)
        n = gauss._AHEAD @ (answers[i] - push[i]) + (push[i + 1] if i < 5 else 0.0)
    assert len(asked) == (6 if failing is None else failing + 1)
    assert not out[1 + done // 2 :].any()


def test_a_place_that_is_no_place_is_beyond_any_shell_and_none_is_asked_for_there(monkeypatch):
    """One of many nodes is enough; else each is asked for at its own instant."""
    asked = []

    def remainder(r, t, p, out):
        asked.append(t)
        out[:] = t * p

    monkeypatch.setattr(gauss, "remainder", remainder)
    r = SimpleNamespace(position=np.array([[1.0, 0.0], [0.5, -2.0]]), shape=SimpleNamespace(radius=2.0))
    time, p = np.array([1.0, 2.0, 3.0]), np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]])
    np.testing.assert_array_equal(gauss.added.py_func(r, time, p), time[:, None] * p)
    assert asked == [1.0, 2.0, 3.0]
    for way in (1.0, -1.0):
        for far in (1001.0 * way, np.nan, np.inf * way):
            away = p.copy()
            away[1, 1] = far
            with np.errstate(invalid="ignore"):
                assert np.isinf(gauss.added.py_func(r, time, away)).all()
    assert len(asked) == 3
