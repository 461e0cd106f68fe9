"""Structure-preserving steps: order, conservation and passivity at any step size, agreement with other methods."""

import numpy as np
import pytest
from conftest import only_run, shipped, varied
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from benchmarks import hard_cases as hardcases
from vsb.errors import ConvergenceError
from vsb.integrators.audit import energies
from vsb.integrators.energy_preserving import fixed_step, structure_preserving
from vsb.integrators.exact import propagate
from vsb.integrators.exponential import integrate
from vsb.motion.forces import Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.scenes.build import SCENES
from vsb.study import study as config
from vsb.study.plan import StudyPlan

STILL = [{"kind": "still"}]
REFINEMENTS = np.array([20, 40, 80, 160])


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
    """Stored energy at every instant over the largest kinetic energy."""
    energy = energies(System.of(plant), motion)
    return energy["stored"] / energy["turned"].max()


@pytest.mark.parametrize("name", ["seed", "body_exact"])
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


def test_undamped_linear_scene_conserves_energy_over_many_periods():
    """Heave coupled with a shell mode a thousand times faster: the energy drifts by round-off only.

    Per step it is at most 4 eps || |L| |P| |L^-1| ||, with the propagator P and the energy H = L^T L.
    """
    mass, springs = np.array([[2e4, 300.0], [300.0, 80.0]]), np.diag([1e5, 4e8])
    plant = Scene(("Heave", "Membrane0"), mass, {"elastic": Spring(springs)}, np.eye(2))
    steps = 3 * 2000
    time = instants(2000 * 2 * np.pi / np.sqrt(5.0), steps)
    motion = fixed_step(System.of(plant), time, (np.array([0.3, 1e-4]), np.array([0.2, 0.5])))
    q, v = motion.position, motion.velocity
    energy = 0.5 * (np.einsum("ti,ij,tj->t", v, mass, v) + np.einsum("ti,ij,tj->t", q, springs, q))
    step = [fixed_step(System.of(plant), time[:2], (unit[:2], unit[2:])) for unit in np.eye(4)]
    propagator = np.column_stack([np.concatenate([s.position[1], s.velocity[1]]) for s in step])
    root = np.linalg.cholesky(block_diag(springs, mass)).T
    sums = np.linalg.norm(np.abs(root) @ np.abs(propagator) @ np.abs(np.linalg.inv(root)), 2)
    assert sums < 2.0
    assert np.abs(energy / energy[0] - 1).max() < steps * 4 * np.finfo(float).eps * sums


@pytest.mark.parametrize("step", [0.02, 1.0])
def test_undamped_sphere_in_nonlinear_hydrostatics_conserves_energy_at_any_step(scene, step):
    """The hydrostatic force is cubic in heave, for which the quadrature is exact."""
    plant = scene("paper", "FSB", pto={"damping": 0.0}, waves=STILL)
    motion = fixed_step(System.of(plant), instants(400 * step, 400), plant.start(1.2, -0.5))
    assert np.ptp(motion.position) > 2.0
    assert np.abs(stored(plant, motion)).max() < 1e-11


@pytest.mark.parametrize(("name", "design"), [("seed", "VSWEC"), ("body_exact", "VSWEC")])
def test_energy_never_grows_without_waves(scene, name, design):
    plant = scene(name, design, waves=STILL)

    @settings(max_examples=6)
    @given(step=st.floats(-2.5, 1.0), heave=st.floats(0.1, 0.5), velocity=st.floats(-1.0, 1.0))
    def passive(step, heave, velocity):
        motion = fixed_step(System.of(plant), instants(30 * 10.0**step, 30), plant.start(heave, velocity))
        energy = stored(plant, motion)
        assert np.diff(energy).max() < 1e-9
        assert np.abs(motion.position).max() < 5.0

    passive()


@pytest.mark.parametrize(("name", "tolerance"), [("seed", 1e-4), ("body_exact", 1e-7)])
def test_error_is_within_the_tolerance(scene, name, tolerance):
    plant = scene(name, "VSWEC")
    start, time = plant.start(0.1, -0.5), instants(8.0, 80)
    found, steps = structure_preserving(System.of(plant), time, start, tolerance)
    exact = (
        integrate(System.of(plant), time, start, 1e-12)[0] if plant.water else propagate(System.of(plant), time, start)
    )
    error = np.abs(found.position - exact.position).max()
    assert error < 2 * tolerance * np.abs(exact.velocity).max()
    assert steps % 80 == 0
    assert np.abs(found.memory - exact.memory).max() < 10 * tolerance * np.abs(exact.memory).max()


@pytest.mark.slow
def test_shell_in_equilibrium_stays_at_rest(scene):
    """Its motion is round-off, which must not be followed by ever shorter steps."""
    rests = {"device": {"internal_pressure": 16.5e3}, "modes": {"basis": "full", "degree": 3}, "waves": STILL}
    plant = scene("seed", "VSWEC", **rests, reference_shape="equilibrium", hydro={"model": "body_exact"})
    time = instants(4.0, 100)
    found, steps = structure_preserving(System.of(plant), time, plant.start(0.0, 0.0), 1e-9)
    assert steps <= 400
    assert np.abs(found.position).max() < 1e-9


def test_step_without_a_solution_is_reported(scene):
    plant = scene("body_exact", "VSWEC")
    with pytest.raises(ConvergenceError, match=r"a step of 50 s at t = 0 s: .*needs a shorter step"):
        fixed_step(System.of(plant), instants(100.0, 2), plant.start(0.0, 1e200))
