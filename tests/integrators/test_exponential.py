"""Exponential Adams method: order, published values, energy, hard cases of the wet shell, refused motions."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLE, compiled_motion, labelled, only_run, springs, varied
from scipy.integrate import solve_ivp

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
from vsb.engine.motion.wetted import WetShell, meridian_series, wet_intervals
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis
from vsb.engine.waves.seas import NO_WAVES
from vsb.errors import ConvergenceError
from vsb.models.build import assumed_pressure_design
from vsb.results.comparison import merit
from vsb.study import study as config

ASSUMED = {"model": "assumed_pressure", "pressure": 1800.0}


@pytest.fixture(scope="module")
def assumed(seed):
    return varied(seed, hydro=ASSUMED, water={"density": 1024.7589})


def scene(study, design="VSWEC", **changes):
    """Scene of one design of a study, and that study."""
    designs = {design: study.designs[design].model_dump()}
    one = varied(study, **{"designs": designs, **changes})
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


def test_order_is_six(assumed):
    plant, _ = scene(assumed, "FSB", hydro={"pressure": 0.0})
    method = ExponentialIntegrator(System.of(plant), 0.01)
    first = np.zeros(len(method.system.matrix))
    first[plant.motions.shape[1]] = 50.0
    counts = np.array([48, 60, 72, 96, 120, 144])
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


STILL = [{"kind": "still"}]


@pytest.fixture(scope="module")
def paper():
    study = config.load(EXAMPLE.parent / "paper.yaml")
    return config.parse({**study.model_dump(), "published": None})


def independent(plant, time, start):
    """Motion in still water from `DeformedShell`'s quadrature in colatitude and a general integrator."""
    shell, n, weight = plant.water.shell, plant.motions.shape[1], plant.forces["weight"].value
    inverse = np.linalg.inv(plant.motions.T @ plant.mass @ plant.motions)
    stiffness, damping = springs(plant), plant.damping

    def rates(_, y):
        wet = DeformedShell(shell.basis, shell.centre_height, plant.motions @ y[:n])
        force = plant.motions.T @ (wet.hydrostatics(plant.water.specific_weight, 1.0, 24)[0] + weight)
        return np.concatenate([y[n:], inverse @ (force - stiffness @ y[:n] - damping @ y[n:])])

    done = solve_ivp(rates, (0.0, time[-1]), np.concatenate(start), "DOP853", rtol=1e-8, atol=1e-12, t_eval=time)
    return done.y[:n].T


def test_waterline_on_a_sample_is_found_despite_round_off(paper):
    """Table and recurrence may see z at a sample with different signs."""
    basis, q = mode_basis(paper.device, "membrane", 0), np.array([-0.9410052093878509, -0.004144601433786726])
    table = WetShell(basis, 0.0).shape
    on_sample = -(meridian_series(table, q)[1] @ table.on_grid[:, 5])
    for ulps in range(-8, 9):
        height = float(on_sample + ulps * 1.1e-16)
        wet = WetShell(basis, height).shape
        (low, high) = wet_intervals(wet, meridian_series(wet, q))
        assert low == -1.0
        assert high == pytest.approx(table.grid[5], abs=1e-12), ulps


@pytest.mark.parametrize(("degree", "height"), [(0, 2.0), (40, -1.0), (0, -2.0 - 1e-15)])
def test_sphere_that_touches_the_water_has_its_closed_form_force(paper, degree, height):
    """Volume and waterplane of a spherical cap, from dry to submerged."""
    basis = mode_basis(paper.device, "full", degree)
    static, uniform, moment = WetShell(basis, height).forces(np.zeros((1, len(basis.labels))))
    depth = min(max(2.0 - height, 0.0), 4.0)
    assert static[0, 0] == pytest.approx(np.pi * depth**2 * (6.0 - depth) / 3, rel=1e-12, abs=1e-13)
    assert uniform[0, 0] == pytest.approx(np.pi * depth * (4.0 - depth), rel=1e-12, abs=1e-12)
    assert np.isfinite(moment).all()


def test_force_of_a_self_crossing_meridian_has_a_potential(paper):
    """No possible shell, but an integrator that meets it must not gain energy."""
    basis = mode_basis(paper.device, "membrane", 3)
    wet = WetShell(basis, 0.2)
    q = np.array([0.0, -1.6, 0.4, 1.6, 0.9])
    assert DeformedShell(basis, 0.2, q).meridian(np.linspace(0, np.pi, 200)).x.min() < -0.1

    def slope(e, h):
        return (wet.forces((q + h * e)[None])[2][0] - wet.forces((q - h * e)[None])[2][0]) / (2 * h)

    gradient = [(4 * slope(e, 5e-4) - slope(e, 1e-3)) / 3 for e in np.eye(5)]
    assert wet.forces(q[None])[0][0] == pytest.approx(gradient, abs=1e-6)


def test_ringing_in_step_with_the_nodes_is_resolved(paper):
    """A thin undamped shell, clamped at the top, rings nearly twice between nodes: sampled there it looks constant."""
    device = {"young_modulus": 1.2e10, "thickness": 7.6e-4, "damping": {"alpha": 0.0, "beta": 0.0}}
    plant, _ = scene(paper, "VSWEC0", device=device, modes={"basis": "full", "degree": 1}, pto={"damping": 1e6})
    time, start = np.linspace(0.0, 0.2, 17), plant.start(-1.0, 0.0)
    truth = compiled_motion(plant, time, start, rtol=1e-9)
    motion, _ = integrate(System.of(plant), time, start, 1e-6)
    shell = np.abs(truth[:, 1]).max()
    assert np.abs(motion.position - truth)[:, 1].max() < 0.01 * shell


CASES = {
    "thrown up": ("FSB", {}, 5.0, 30.0, 4.0),
    "breathing only": ("VSWEC", {"modes": {"basis": "membrane", "degree": 0}}, 0.3, 0.0, 0.5),
    "clamped at both poles": (
        "VSWEC0", {"modes": {"basis": "full", "degree": 3}, "designs": {"VSWEC0": {"clamp": [0, 180]}}}, 0.0, -0.8, 0.1,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_motion_agrees_with_plain_quadrature_and_a_general_integrator(paper, name):
    design, changes, heave, velocity, duration = CASES[name]
    plant, _ = scene(paper, design, **{**changes, "waves": STILL})
    time, start = np.linspace(0.0, duration, 9), plant.start(heave, velocity)
    truth = independent(plant, time, start)
    motion, _ = integrate(System.of(plant), time, start, 1e-9)
    assert np.abs(motion.position - truth).max() < 3e-6 * np.abs(truth).max()


@pytest.mark.parametrize("duration", [1e-3, 1.2345])
def test_run_of_any_duration_ends_on_the_longer_run(paper, duration):
    """Shorter than a record, one record, not a multiple of a step."""
    settings = {"duration": duration, "window": [0.0, duration], "tolerance": 1e-10}
    plant, study = scene(paper, "VSWEC", simulation=settings)
    motion, _, _ = simulate(System.of(plant), NO_WAVES, study.simulation, None)
    assert motion.time[-1] == pytest.approx(duration, rel=1e-15)
    longer, _ = integrate(System.of(plant), np.linspace(0.0, 2 * duration, 401), plant.start(0.0, -0.8), 1e-10)
    assert motion.position[-1] == pytest.approx(longer.position[200], abs=1e-8)
