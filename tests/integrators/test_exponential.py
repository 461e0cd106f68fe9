"""Exponential Adams method: order, published values, energy, limits; phi functions."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import compiled_motion, labelled, only_run, varied

from vsb.engine.integrators.audit import energies
from vsb.engine.integrators.exponential import (
    EVALUATIONS,
    HISTORY,
    KEPT,
    STEPS,
    ExponentialIntegrator,
    integrate,
    march,
)
from vsb.engine.integrators.simulate import simulate
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import NO_WAVES
from vsb.errors import ConvergenceError
from vsb.models.build import assumed_pressure_design
from vsb.results.comparison import merit

ASSUMED = {"model": "assumed_pressure", "pressure": 1800.0}


@pytest.fixture(scope="module")
def assumed(seed):
    return varied(seed, hydro=ASSUMED, water={"density": 1024.7589})


def scene(study, design="VSWEC", **changes):
    """Scene of one design."""
    one = varied(study, designs={design: study.designs[design].model_dump()}, **changes)
    return assumed_pressure_design(only_run(one), {})[0], one


def fixed_steps(method, first, spacing, count):
    """State after `count` steps of one size without error control, started at a tight tolerance."""
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


@pytest.mark.parametrize(("design", "fewest"), [("FSB", 48)])
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
    time, start = np.linspace(0.0, 10.0, 801), plant.start(0.0, -0.8)
    exact, _ = integrate(System.of(plant), time, start, 1e-12)
    errors = []
    for tolerance in (tolerances := 10.0 ** -np.array([4, 8])):
        motion, _ = integrate(System.of(plant), time, start, tolerance)
        errors.append(np.abs(motion.position - exact.position).max() / np.ptp(exact.position[:, 0]))
    assert np.all(errors < 2 * tolerances), errors / tolerances
    assert np.all(errors > 1e-3 * tolerances), errors / tolerances  # not needlessly small


def test_stiff_modes_do_not_limit_the_step(assumed):
    """Membrane modes of up to 66 000 rad/s: at most three times the steps of the rigid buoy."""
    soft, _ = scene(assumed, "FSB")
    stiff, _ = scene(assumed, "VSWEC", device={"young_modulus": 1e12})
    time = np.linspace(0.0, 10.0, 801)
    (_, few), (_, many) = (integrate(System.of(plant), time, plant.start(0.0, -0.8), 1e-5) for plant in (soft, stiff))
    assert many < 3 * few


@pytest.mark.parametrize(
    ("pressure", "damping", "published"),
    [(1800.0, 8000.0, (1.797, 4.548, 41.4e3, None)), (360.0, 6000.0, (0.3888, 0.9775, 1433.0, 42.9e3))],
)
def test_rigid_buoy_of_the_paper(assumed, pressure, damping, published):
    """Peak-to-peak displacement and velocity, peak power and energy of the FSB, to the published digits."""
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


def undamped(study, design="VSWEC"):
    still = {"pto": {"damping": 0.0}, "device": {"damping": {"alpha": 0.0, "beta": 0.0}}, "waves": [{"kind": "still"}]}
    return scene(study, design, **still)


def test_undamped_free_shell_conserves_energy_over_many_periods(assumed):
    """Periods of the breathing mode, 2 pi/51.4 s; the energy error falls with the tolerance."""
    plant, _ = undamped(assumed)
    time = np.linspace(0.0, 200 * 2 * np.pi / 51.434, 801)
    drifts = []
    for tolerance in (1e-6, 1e-8):
        motion, _ = integrate(System.of(plant), time, plant.start(0.1, 0.0), tolerance)
        energy = energies(System.of(plant), motion)
        assert np.all(energy["wave"] == 0.0)
        kinetic = 0.5 * np.einsum("ti,ij,tj->t", motion.velocity, plant.mass, motion.velocity)
        drifts.append(np.abs(energy["stored"]).max() / kinetic.max())
    assert drifts[1] < 0.2 * drifts[0] < 1e-4


def test_free_fall_and_splash(assumed):
    """From 3 m above the water: free fall until the keel touches, then a splash."""
    plant, _ = undamped(assumed, "FSB")
    time = np.linspace(0.0, 3.0, 301)
    motion, _ = integrate(System.of(plant), time, plant.start(3.0, 0.0), 1e-9)
    dry = time < np.sqrt(2 * 1.0 / 9.81)
    assert motion.position[dry, 0] == pytest.approx(3.0 - 9.81 * time[dry] ** 2 / 2, abs=1e-8)
    assert np.abs(motion.position - compiled_motion(plant, time, plant.start(3.0, 0.0))).max() < 1e-5


def test_crushed_shell_is_an_error(assumed):
    plant, _ = scene(assumed, "VSWEC")
    crushing = replace(plant.water, assumed=replace(plant.water.assumed, amplitude=1e12))
    worse = replace(plant, forces={**plant.forces, "water": crushing})
    with pytest.raises(ConvergenceError, match=r"cannot be followed at t = .* s: the step .*loads that crush the"):
        integrate(System.of(worse), np.linspace(0.0, 5.0, 401), plant.start(0.0, 0.0), 1e-8)


def test_scene_without_water_pressure_is_refused(assumed):
    plant, _ = scene(assumed, "FSB")
    dry = replace(plant, forces={"pto": plant.forces["pto"]})
    with pytest.raises(ValueError, match="needs a scene with water pressure"):
        integrate(System.of(dry), np.linspace(0.0, 1.0, 11), plant.start(0.0, 0.0), 1e-8)
