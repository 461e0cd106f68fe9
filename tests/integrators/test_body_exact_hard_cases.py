"""Hard cases of body-exact motion: degenerate waterlines, ringing in step with the nodes, extreme motion."""

import numpy as np
import pytest
from conftest import EXAMPLE, compiled_motion, only_run, springs, varied
from scipy.integrate import solve_ivp

from vsb.engine.integrators.exponential import integrate
from vsb.engine.integrators.simulate import simulate
from vsb.engine.motion.system import System
from vsb.engine.motion.wetted import WetShell, meridian_series, wet_intervals
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis
from vsb.engine.waves.seas import NO_WAVES
from vsb.models.build import assumed_pressure_design
from vsb.study import study as config

STILL = [{"kind": "still"}]


@pytest.fixture(scope="module")
def paper():
    study = config.load(EXAMPLE.parent / "paper.yaml")
    return config.parse({**study.model_dump(), "published": None})


def scene(study, design="VSWEC", **changes):
    """Scene of one design of a study, and that study."""
    designs = {design: study.designs[design].model_dump()}
    one = varied(study, **{"designs": designs, **changes})
    return assumed_pressure_design(only_run(one), {})[0], one


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


@pytest.mark.parametrize(("kind", "q", "sample"), [("membrane0", [-0.9410052093878509, -0.004144601433786726], 5)])
def test_waterline_on_a_sample_is_found_despite_round_off(paper, kind, q, sample):
    """Table and recurrence may see z at a sample with different signs."""
    basis, q = mode_basis(paper.device, kind[:-1], int(kind[-1])), np.array(q)
    table = WetShell(basis, 0.0).shape
    on_sample = -(meridian_series(table, q)[1] @ table.on_grid[:, sample])
    for ulps in range(-8, 9):
        height = float(on_sample + ulps * 1.1e-16)
        wet = WetShell(basis, height).shape
        (low, high) = wet_intervals(wet, meridian_series(wet, q))
        assert low == -1.0
        assert high == pytest.approx(table.grid[sample], abs=1e-12), ulps


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
