"""Body-exact motion: order, independent integrator, published values, energy, limits."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import compiled_motion, varied

from vsb.commands import assumed_pressure_scene
from vsb.errors import ConvergenceError
from vsb.exponential import NODES, ExponentialIntegrator, _march, integrate, on_a_grid, phi_integrals, step_matrices
from vsb.plant import Plant
from vsb.power import merit
from vsb.trajectory import energies, labelled, residual, simulate
from vsb.waves import NO_WAVES

ASSUMED = {"model": "assumed_pressure", "pressure": 1800.0}


@pytest.fixture(scope="module")
def assumed(seed):
    return varied(seed, hydro=ASSUMED, water={"density": 1024.7589})


def scene(study, design="VSWEC", **changes):
    """Plant of one design."""
    one = varied(study, designs={design: study.designs[design].model_dump()}, **changes)
    return assumed_pressure_scene(one, {})[0], one


def test_phi_integrals_of_a_number():
    for x in (-3.0, 0.1, 2.0):
        whole, (one, two, three) = phi_integrals(np.array([[x]]), np.eye(1), 1.0, 3)
        e = np.exp(x)
        assert whole[0, 0] == pytest.approx(e)
        assert one[0, 0] == pytest.approx((e - 1) / x)
        assert two[0, 0] == pytest.approx((e - 1 - x) / x**2)
        assert three[0, 0] == pytest.approx((e - 1 - x - x**2 / 2) / x**3)


def test_integrals_on_a_grid_are_those_of_each_time():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(6, 6)), rng.normal(size=(6, 2))
    powers, grid = on_a_grid(a, b, 0.1, 8)
    for i in (0, 3, 7):
        whole, integrals = phi_integrals(a, b, 0.1 * (i + 1), NODES)
        assert powers[i] == pytest.approx(whole, abs=1e-13)
        assert grid[i] == pytest.approx(integrals, abs=1e-13)


def fixed_steps(method, first, spacing, count):
    """State after `count` steps of four equal node distances, whatever their error."""
    matrices = step_matrices(method.system.matrix, method.input, spacing, 0)
    z, n, out = first.copy(), np.zeros((NODES, method.input.shape[1])), np.empty((NODES, len(first)))
    for _ in range(count):
        out[0] = z
        _march(method.remainder, matrices, spacing, 0, 0, 1.0, z, n, 1e9, out)
    return z


@pytest.mark.parametrize(("design", "order"), [("FSB", 6.0), ("VSWEC90", 5.0)])
def test_order_is_six_and_five_with_stiff_modes(assumed, design, order):
    plant, _ = scene(assumed, design, hydro={"pressure": 0.0})
    method = ExponentialIntegrator(plant, plant.water, 0.01)
    first = np.zeros(len(method.system.matrix))
    first[plant.motions.shape[1]] = 50.0
    counts = np.array([8, 12, 16, 24, 32]) * (1 if design == "FSB" else 12)
    ends = [fixed_steps(method, first, 2.0 / count / 4, count) for count in [*counts, 4 * counts[-1]]]
    errors = [np.linalg.norm(end - ends[-1]) for end in ends[:-1]]
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.all(np.abs(slopes[1:] - order) < 0.35), slopes


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC0", "VSWEC90"])
def test_motion_agrees_with_an_independent_integrator(assumed, design):
    plant, _ = scene(assumed, design)
    time = np.linspace(0.0, 4.0, 161)
    start = plant.start(0.05, -0.8)
    reference = compiled_motion(plant, time, start)
    for tolerance, bound in ((1e-7, 2e-4), (1e-11, 1e-7)):
        motion, _ = integrate(plant, time, start, tolerance)
        assert np.abs(motion.position - reference).max() < bound * np.abs(reference).max()


@pytest.mark.parametrize(
    ("pressure", "damping", "published"),
    [(1800.0, 8000.0, (1.797, 4.548, 41.4e3, None)), (360.0, 6000.0, (0.3888, 0.9775, 1433.0, 42.9e3))],
)
def test_rigid_buoy_of_the_paper(assumed, pressure, damping, published):
    """Displacement and velocity peak to peak, peak power, energy of a body-exact FSB, to the digits published."""
    plant, study = scene(assumed, "FSB", hydro={"pressure": pressure}, pto={"damping": damping})
    motion, stride, _ = simulate(plant, NO_WAVES, study.simulation, None)
    run = labelled(plant, motion, None, "FSB", "wave", stride)
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
    motion, _, _ = simulate(plant, NO_WAVES, study.simulation, None)
    assert residual(energies(plant, motion)) < 1e-6


def test_audit_sees_a_lost_force(assumed):
    plant, study = scene(assumed, "FSB")
    motion, _, _ = simulate(plant, NO_WAVES, study.simulation, None)
    fewer = {name: force for name, force in plant.forces.items() if name != "pto"}
    assert residual(energies(Plant(plant.labels, plant.mass, fewer, plant.motions), motion)) > 0.01


def undamped(study, design="VSWEC"):
    still = {"pto": {"damping": 0.0}, "device": {"damping": {"alpha": 0.0, "beta": 0.0}}, "waves": [{"kind": "still"}]}
    return scene(study, design, **still)


def test_undamped_free_shell_keeps_its_energy_over_a_thousand_periods(assumed):
    """Of its breathing mode, 2 pi/51.4 s; the error of the energy falls with the tolerance."""
    plant, _ = undamped(assumed)
    time = np.linspace(0.0, 1000 * 2 * np.pi / 51.434, 4001)
    drifts = []
    for tolerance in (1e-8, 1e-10):
        motion, _ = integrate(plant, time, plant.start(0.1, 0.0), tolerance)
        energy = energies(plant, motion)
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
        motion, _ = integrate(plant, time, plant.start(a, 0.0), 1e-13)
        balance = motion.position[:, 0] - a * np.cos(np.sqrt(stiffness / mass) * time)
        errors.append(np.abs(balance).max() / a)
    slopes = np.diff(np.log(errors)) / np.diff(np.log(amplitudes))
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


def test_stiff_shell_is_rigid(assumed):
    rigid, study = scene(assumed, "FSB")
    motion = simulate(rigid, NO_WAVES, study.simulation, None)[0]
    stiff, study = scene(assumed, "VSWEC", device={"young_modulus": 1e15})
    flexible = simulate(stiff, NO_WAVES, study.simulation, None)[0]
    every = [m.position[:: (len(m.time) - 1) // 4800, 0] for m in (motion, flexible)]
    assert np.abs(every[0] - every[1]).max() < 1e-6 * np.abs(every[0]).max()


def test_recorded_instants_inside_a_long_step_are_as_good_as_its_end(assumed):
    plant, _ = scene(assumed, "FSB")
    start = plant.start(0.0, -0.8)
    fine, _ = integrate(plant, np.linspace(0.0, 6.0, 961), start, 1e-9)
    coarse, steps = integrate(plant, np.linspace(0.0, 6.0, 121), start, 1e-9)
    assert steps < 961 / 2  # several recorded instants a step
    assert np.abs(fine.position[::8] - coarse.position).max() < 1e-5


def test_thrown_out_of_the_water_and_back(assumed):
    """Starting 3 m up, dry: free fall until the keel touches, then a splash the step size follows."""
    plant, _ = undamped(assumed, "FSB")
    time = np.linspace(0.0, 3.0, 301)
    motion, _ = integrate(plant, time, plant.start(3.0, 0.0), 1e-9)
    dry = time < np.sqrt(2 * 1.0 / 9.81)
    assert motion.position[dry, 0] == pytest.approx(3.0 - 9.81 * time[dry] ** 2 / 2, abs=1e-8)
    assert np.abs(motion.position - compiled_motion(plant, time, plant.start(3.0, 0.0))).max() < 1e-5


def test_a_crushed_shell_is_an_error_not_garbage(assumed):
    plant, _ = scene(assumed, "VSWEC")
    crushing = replace(plant.water, assumed=replace(plant.water.assumed, amplitude=1e12))
    worse = replace(plant, forces={**plant.forces, "water": crushing})
    with pytest.raises(ConvergenceError, match=r"cannot be followed at t = .*loads that crush the shell"):
        integrate(worse, np.linspace(0.0, 5.0, 401), plant.start(0.0, 0.0), 1e-8)


def test_a_linear_scene_is_refused(assumed):
    plant, _ = scene(assumed, "FSB")
    dry = replace(plant, forces={"pto": plant.forces["pto"]})
    with pytest.raises(ValueError, match="needs a scene with water pressure"):
        integrate(dry, np.linspace(0.0, 1.0, 11), plant.start(0.0, 0.0), 1e-8)
