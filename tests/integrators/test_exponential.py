"""Body-exact motion: order, independent integrator, published values, energy, limits."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import compiled_motion, labelled, only_run, varied
from scipy.linalg import expm

from vsb.errors import ConvergenceError
from vsb.integrators.audit import energies, residual
from vsb.integrators.energy_preserving import structure_preserving
from vsb.integrators.exponential import ExponentialIntegrator, Run, integrate
from vsb.integrators.exponential_steps import EVALUATIONS, HISTORY, KEPT, PROBE, STEPS, TICK, march
from vsb.integrators.simulate import simulate
from vsb.motion.scene import Scene
from vsb.motion.system import Remainder, System
from vsb.results.power import merit
from vsb.scenes.build import assumed_pressure_design
from vsb.waves.seas import NO_WAVES

ASSUMED = {"model": "assumed_pressure", "pressure": 1800.0}


@pytest.fixture(scope="module")
def assumed(seed):
    return varied(seed, hydro=ASSUMED, water={"density": 1024.7589})


def scene(study, design="VSWEC", **changes):
    """Scene of one design."""
    one = varied(study, designs={design: study.designs[design].model_dump()}, **changes)
    return assumed_pressure_design(only_run(one), {})[0], one


def fixed_steps(method, first, spacing, count):
    """State after `count` steps of one size, whatever their error; the past is that of a start at a tight tolerance."""
    free = method.system.free
    fine = replace(method, dt=spacing)
    start = fine.run(first, KEPT, 1e-12)
    past, places = np.zeros((HISTORY, free)), np.zeros((HISTORY, free))
    past[:KEPT] = start.pushes[::-1]
    z, out = start.states[-1].copy(), np.empty((count - KEPT + 2, len(first)))
    counters, levels = np.array([0, KEPT, 0, 0, 0]), np.array([1.0, np.inf, 0.0])
    left = np.empty((len(out), free))
    march(fine.remainder, fine.step(0), spacing, 0, 1e99, 1.0, z, past, places, counters, levels, out, left)
    assert counters[STEPS] == counters[EVALUATIONS] == count - KEPT + 1  # one evaluation a step
    return z


@pytest.mark.parametrize(("design", "fewest"), [("FSB", 48), ("VSWEC90", 576)])
def test_order_is_six(assumed, design, fewest):
    plant, _ = scene(assumed, design, hydro={"pressure": 0.0})
    method = ExponentialIntegrator(System.of(plant), 0.01)
    first = np.zeros(len(method.system.matrix))
    first[plant.motions.shape[1]] = 50.0
    counts = fewest * np.array([8, 10, 12, 16, 20, 24]) // 8
    ends = [fixed_steps(method, first, 2.0 / count, count) for count in [*counts, 4 * counts[-1]]]
    errors = [np.linalg.norm(end - ends[-1]) for end in ends[:-1]]
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert abs(slope - 6.0) < 0.5, (slope, errors)


@pytest.mark.parametrize("design", ["FSB", "VSWEC0"])
def test_error_follows_the_tolerance(assumed, design):
    plant, _ = scene(assumed, design)
    time, start = np.linspace(0.0, 20.0, 1601), plant.start(0.0, -0.8)
    exact, _ = integrate(System.of(plant), time, start, 1e-12)
    errors = []
    for tolerance in (tolerances := 10.0 ** -np.arange(4, 10)):
        motion, _ = integrate(System.of(plant), time, start, tolerance)
        errors.append(np.abs(motion.position - exact.position).max() / np.ptp(exact.position[:, 0]))
    assert np.all(errors < 2 * tolerances), errors / tolerances
    assert np.all(errors > 1e-3 * tolerances), errors / tolerances  # nor is work wasted


@pytest.mark.parametrize("young_modulus", [1e9, 1e12])
def test_stiff_modes_do_not_limit_the_step(assumed, young_modulus):
    """Membrane modes of up to 2 and 66 thousand rad/s: as many steps as the seed's, within a factor."""
    soft, _ = scene(assumed, "FSB")
    stiff, _ = scene(assumed, "VSWEC", device={"young_modulus": young_modulus})
    time = np.linspace(0.0, 10.0, 801)
    (_, few), (_, many) = (integrate(System.of(plant), time, plant.start(0.0, -0.8), 1e-5) for plant in (soft, stiff))
    assert many < 3 * few


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC0", "VSWEC90"])
def test_motion_agrees_with_an_independent_integrator(assumed, design):
    plant, _ = scene(assumed, design)
    time = np.linspace(0.0, 4.0, 161)
    start = plant.start(0.05, -0.8)
    reference = compiled_motion(plant, time, start)
    for tolerance, bound in ((1e-7, 2e-4), (1e-11, 1e-7)):
        motion, _ = integrate(System.of(plant), time, start, tolerance)
        assert np.abs(motion.position - reference).max() < bound * np.abs(reference).max()


@pytest.mark.parametrize(
    ("pressure", "damping", "published"),
    [(1800.0, 8000.0, (1.797, 4.548, 41.4e3, None)), (360.0, 6000.0, (0.3888, 0.9775, 1433.0, 42.9e3))],
)
def test_rigid_buoy_of_the_paper(assumed, pressure, damping, published):
    """Displacement and velocity peak to peak, peak power, energy of a body-exact FSB, to the digits published."""
    plant, study = scene(assumed, "FSB", hydro={"pressure": pressure}, pto={"damping": damping})
    motion, stride, _ = simulate(System.of(plant), NO_WAVES, study.simulation, None)
    run = labelled(System.of(plant), motion, None, "FSB", "wave", stride)
    ours = merit(run, study.waves[0], NO_WAVES, study.water, study.simulation.window)
    assert f"{ours.displacement_pp:.4g}" == f"{published[0]:.4g}"
    assert ours.velocity_pp == pytest.approx(published[1], abs=1e-3)
    assert ours.power_peak == pytest.approx(published[2], rel=1.2e-3)
    if published[3]:
        assert ours.energy == pytest.approx(published[3], rel=1e-3)
    assert ours.capture_width is None


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC0"])
def test_energy_audit_closes_to_the_tolerance(assumed, design):
    plant, study = scene(assumed, design)
    motion, _, _ = simulate(System.of(plant), NO_WAVES, study.simulation, None)
    assert residual(energies(System.of(plant), motion)) < 1e-6


def test_audit_sees_a_lost_force(assumed):
    plant, study = scene(assumed, "FSB")
    motion, _, _ = simulate(System.of(plant), NO_WAVES, study.simulation, None)
    fewer = {name: force for name, force in plant.forces.items() if name != "pto"}
    assert residual(energies(System.of(Scene(plant.labels, plant.mass, fewer, plant.motions)), motion)) > 0.01


def undamped(study, design="VSWEC"):
    still = {"pto": {"damping": 0.0}, "device": {"damping": {"alpha": 0.0, "beta": 0.0}}, "waves": [{"kind": "still"}]}
    return scene(study, design, **still)


def test_undamped_free_shell_keeps_its_energy_over_a_thousand_periods(assumed):
    """Of its breathing mode, 2 pi/51.4 s; the error of the energy falls with the tolerance."""
    plant, _ = undamped(assumed)
    time = np.linspace(0.0, 1000 * 2 * np.pi / 51.434, 4001)
    drifts = []
    for tolerance in (1e-6, 1e-8):
        motion, _ = integrate(System.of(plant), time, plant.start(0.1, 0.0), tolerance)
        energy = energies(System.of(plant), motion)
        assert np.all(energy["wave"] == 0.0)
        kinetic = 0.5 * np.einsum("ti,ij,tj->t", motion.velocity, plant.mass, motion.velocity)
        drifts.append(np.abs(energy["stored"]).max() / kinetic.max())
    assert drifts[1] < 0.2 * drifts[0] < 1e-4


def test_small_motion_is_linear(assumed):
    """What the linear oscillator misses falls with the square of the amplitude: the waterplane is even in heave."""
    plant, _ = undamped(assumed, "FSB")
    time = np.linspace(0.0, 10.0, 401)
    stiffness, mass = plant.water.tangent[0, 0], plant.mass[0, 0]
    errors = []
    amplitudes = np.array([0.2, 0.1, 0.05, 0.025, 0.0125])
    for a in amplitudes:
        motion, _ = integrate(System.of(plant), time, plant.start(a, 0.0), 1e-13)
        balance = motion.position[:, 0] - a * np.cos(np.sqrt(stiffness / mass) * time)
        errors.append(np.abs(balance).max() / a)
    slopes = np.diff(np.log(errors)) / np.diff(np.log(amplitudes))
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


def test_stiff_shell_is_rigid(assumed):
    rigid, study = scene(assumed, "FSB")
    motion = simulate(System.of(rigid), NO_WAVES, study.simulation, None)[0]
    stiff, study = scene(assumed, "VSWEC", device={"young_modulus": 1e15})
    flexible = simulate(System.of(stiff), NO_WAVES, study.simulation, None)[0]
    every = [m.position[:: (len(m.time) - 1) // 4800, 0] for m in (motion, flexible)]
    assert np.abs(every[0] - every[1]).max() < 1e-6 * np.abs(every[0]).max()


def test_recorded_instants_inside_a_long_step_are_as_good_as_its_end(assumed):
    plant, _ = scene(assumed, "FSB")
    start = plant.start(0.0, -0.8)
    fine, _ = integrate(System.of(plant), np.linspace(0.0, 6.0, 961), start, 1e-9)
    coarse, steps = integrate(System.of(plant), np.linspace(0.0, 6.0, 121), start, 1e-9)
    assert steps < 961 / 2  # several recorded instants a step
    assert np.abs(fine.position[::8] - coarse.position).max() < 1e-5


def test_thrown_out_of_the_water_and_back(assumed):
    """Starting 3 m up, dry: free fall until the keel touches, then a splash the step size follows."""
    plant, _ = undamped(assumed, "FSB")
    time = np.linspace(0.0, 3.0, 301)
    motion, _ = integrate(System.of(plant), time, plant.start(3.0, 0.0), 1e-9)
    dry = time < np.sqrt(2 * 1.0 / 9.81)
    assert motion.position[dry, 0] == pytest.approx(3.0 - 9.81 * time[dry] ** 2 / 2, abs=1e-8)
    assert np.abs(motion.position - compiled_motion(plant, time, plant.start(3.0, 0.0))).max() < 1e-5


def test_a_crushed_shell_is_an_error_not_garbage(assumed):
    plant, _ = scene(assumed, "VSWEC")
    crushing = replace(plant.water, assumed=replace(plant.water.assumed, amplitude=1e12))
    worse = replace(plant, forces={**plant.forces, "water": crushing})
    shortest = f"{5.0 / 400 * 2.0**-20:.1e}"
    at = r"cannot be followed at t = ([^:]*): the step became shorter than "
    with pytest.raises(ConvergenceError, match=rf"{at}{shortest} s; .*loads that crush the shell") as told:
        integrate(System.of(worse), np.linspace(0.0, 5.0, 401), plant.start(0.0, 0.0), 1e-8)
    assert 0.0 <= float(re.search(at, str(told.value)).group(1).removesuffix(" s")) < 5.0


def test_the_instant_it_gives_up_at_is_counted_in_its_shortest_steps_from_the_begin(assumed, monkeypatch):
    def stuck(*given):
        counters = given[-4]
        counters[TICK] = 3 << 19
        return -1

    stuck.signatures = march.signatures
    plant, _ = scene(assumed, "FSB")
    monkeypatch.setattr("vsb.integrators.exponential.march", stuck)
    with pytest.raises(ConvergenceError, match=r"cannot be followed at t = 4\.15 s: "):  # 4 s and 1.5 records
        integrate(System.of(plant), np.linspace(4.0, 5.0, 11), plant.start(0.0, 0.0), 1e-8)


def test_a_linear_scene_is_refused(assumed):
    plant, _ = scene(assumed, "FSB")
    dry = replace(plant, forces={"pto": plant.forces["pto"]})
    with pytest.raises(ValueError, match="needs a scene with water pressure"):
        integrate(System.of(dry), np.linspace(0.0, 1.0, 11), plant.start(0.0, 0.0), 1e-8)


@pytest.mark.parametrize(("rates", "duration", "horizon"), [
    ([-2.0, -0.25], 10.0, 4.0), ([-2.0, -0.25], 3.0, 3.0), ([-2.0, 0.0], 10.0, 10.0), ([-2.0, 0.5], 10.0, 10.0),
])  # fmt: skip
def test_errors_add_up_until_the_slowest_mode_forgets_or_the_motion_ends(rates, duration, horizon):
    """What does not decay forgets nothing."""
    method = ExponentialIntegrator(SimpleNamespace(matrix=np.diag(rates)), 0.1)
    assert method.horizon(duration) == pytest.approx(horizon, rel=1e-12)


def with_waves(omega, on_shell):
    """A system whose linear waves, two motions wide, and waves on the wet shell are at some frequencies."""
    water = Remainder(*[None] * len(Remainder._fields))._replace(waves=SimpleNamespace(omega=np.array(on_shell)))
    waves = (np.arange(2.0 * len(omega)) * (1 - 2j)).reshape(-1, 2)
    return SimpleNamespace(remainder=water, omega=np.array(omega), waves=waves)


def test_linear_waves_join_those_on_the_wet_shell_each_its_own():
    """There they stand by frequency, and time is counted from the begin of the run."""
    system = with_waves([2.5, 0.7, 1.6], [0.7, 1.6, 2.5])
    found = ExponentialIntegrator(system, 0.1, 7.5).remainder
    np.testing.assert_array_equal(found.diffraction, system.waves[[1, 2, 0]])
    assert found.begin == 7.5
    assert ExponentialIntegrator(with_waves([], [0.7]), 0.1).remainder.diffraction.shape == (0, 2)


def test_linear_waves_of_another_sea_than_those_on_the_wet_shell_are_refused():
    for on_shell in ([0.7, 1.6], [0.7, 1.6, 2.6]):
        with pytest.raises(
            ValueError, match=r"^exponential steps: received linear waves unlike those on the wet shell"
        ):
            _ = ExponentialIntegrator(with_waves([2.5, 0.7, 1.6], on_shell), 0.1).remainder


@pytest.fixture(scope="module")
def oscillating():
    """The linear part of a system of two motions and a memory."""
    rng = np.random.default_rng(2)
    matrix = rng.normal(size=(5, 5)) * np.array([1.0, 40.0, 1.0, 1.0, 1.0])
    return SimpleNamespace(matrix=matrix, input=np.eye(5, 2, -2), free=2, least=0.5)


@pytest.mark.parametrize("level", [-6, -1, 0, 3])
def test_matrices_of_a_step_are_those_of_its_own_size_of_its_probe_and_of_a_record(oscillating, level):
    """From whichever level on; those found before stay as they are."""
    method = ExponentialIntegrator(oscillating, 0.02)
    for at in (1, level, -2, level):
        step, d = method.step(at), 0.02 * 2.0**at
        assert step.spacing == d
        size = np.abs(expm(d * oscillating.matrix)).max()
        np.testing.assert_allclose(step.free, expm(d * oscillating.matrix).T, atol=1e-11 * size)
        probe = expm(PROBE * d * oscillating.matrix)[:2].T
        np.testing.assert_allclose(step.probe_free, probe, atol=1e-11 * size)
        np.testing.assert_allclose(step.record_free, expm(0.02 * oscillating.matrix).T, atol=1e-12)


@pytest.mark.parametrize(("first", "largest"), [([0.3, 0.0, 0.0, -0.4, 1.2], 1.3), ([0.1, 0.0, 0.0, 0.0, 0.0], 0.5)])
def test_a_run_begins_with_short_steps_at_rest_or_not_and_adds_up_what_it_took(
    oscillating, monkeypatch, first, largest
):
    """What it may err by is measured against the largest state, no less than what matters."""
    changes, asked = iter([1, 1, -1, 0]), []

    def march(r, step, dt, level, tolerance, horizon, z, past, places, counters, levels, out, pushes):
        if not asked:
            assert counters.tolist() == [0, 0, 0, 0, HISTORY]
            assert levels.tolist() == pytest.approx([largest, 0.0, 1e-3 * largest])
            assert (z.tolist(), out[0].tolist(), pushes[0].tolist()) == (first, first, [7.0, 7.0])
            assert (past.shape, places.shape, out.shape, pushes.shape) == ((HISTORY, 2), (HISTORY, 2), (4, 5), (4, 2))
        asked.append((level, step.spacing, dt, tolerance, horizon))
        counters[STEPS : EVALUATIONS + 1] += [3, 5]
        return next(changes)

    def remainder(r, t, p, out):
        assert (t, p.tolist()) == (0.0, first[:2])
        out[:] = 7.0

    monkeypatch.setattr("vsb.integrators.exponential.march", march)
    monkeypatch.setattr("vsb.integrators.exponential.remainder", remainder)
    monkeypatch.setattr(ExponentialIntegrator, "remainder", None)
    method = ExponentialIntegrator(oscillating, 0.02)
    run = method.run(np.array(first), 4, 1e-3)
    horizon = method.horizon(3 * 0.02)
    assert asked == [(level, 0.02 * 2.0**level, 0.02, 1e-3, horizon) for level in (-1, 0, 1, 0)]
    assert (run.steps, run.evaluations) == (12, 21)


@pytest.mark.parametrize("follow", [integrate, structure_preserving])
def test_forces_that_compiled_steps_do_not_know_are_refused_before_anything_is_done(follow):
    def refuse():
        raise ValueError("unknown to compiled steps")

    system = SimpleNamespace(check_compiled=refuse, first=lambda start: np.zeros(2))
    with pytest.raises(ValueError, match="unknown to compiled steps"):
        follow(system, np.linspace(0.0, 1.0, 3), (), 1e-6)


@pytest.mark.parametrize("compiled", [(), ("once",)])
def test_a_motion_is_that_of_its_run_and_its_seconds_are_without_compiling(monkeypatch, compiled):
    """From the first instant on, to the tolerance, by steps that belong to the records; what they took is told."""
    asked, told, now = [], [], iter([10.0, 12.5])

    def run(self, first, count, tolerance):
        asked.append((self.dt, self.begin, np.asarray(first).tolist(), count, tolerance))
        return Run("states", "pushes", 7, 9)

    monkeypatch.setattr(ExponentialIntegrator, "run", run)
    monkeypatch.setattr("vsb.integrators.exponential.march", SimpleNamespace(signatures=compiled))
    monkeypatch.setattr("vsb.integrators.exponential.clock", SimpleNamespace(perf_counter=lambda: next(now)))
    system = SimpleNamespace(
        check_compiled=lambda: None, matrix=np.eye(3), first=lambda start: start,
        motion=lambda *given: told.append(given) or "motion",
    )  # fmt: skip
    time = np.array([4.0, 4.25, 4.5, 4.75])
    assert integrate(system, time, [1.0, 2.0, 3.0], 1e-4) == ("motion", 7)
    warm = [] if compiled else [(0.25, 4.0, [0.0] * 3, 2, 1.0)]
    assert asked == [*warm, (0.25, 4.0, [1.0, 2.0, 3.0], 4, 1e-4)]
    assert told == [(time, "states", "pushes", 2.5)]
