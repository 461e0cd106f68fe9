"""Periodic functions, Floquet multipliers and harmonic balance: closed forms, runs in time, stability, limits."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from conftest import HERE, varied
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

from vsb.engine.integrators import harmonic_balance as harmonic
from vsb.engine.integrators.exact import steady_state
from vsb.engine.integrators.exponential import integrate
from vsb.engine.integrators.harmonic_balance import (
    PeriodicScene,
    continued,
    harmonic_balance,
    harmonics_of,
    hill_matrix,
    largest,
    monodromy,
    multipliers,
    phases,
    steady_power,
    synthesized,
)
from vsb.engine.motion.forces import AssumedPressure, Excitation, TakeOff
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, assumed_pressure_scene, body_exact_scene, linear_scene, resting
from vsb.engine.motion.system import System
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.models.rest import design_motions, study_basis
from vsb.study import study as config

SEEDS = st.integers(0, 2**32 - 1)


def random_harmonics(rng, count, *shape):
    """Of a real function: the mean has no imaginary part."""
    out = rng.normal(size=(count, *shape)) + 1j * rng.normal(size=(count, *shape))
    out[0] = out[0].real
    return out


@given(SEEDS, st.integers(1, 6), st.integers(1, 14))
def test_hill_matrix_equals_the_product_in_time(seed, count, wide):
    rng, free = np.random.default_rng(seed), 2
    matrix, u = random_harmonics(rng, wide, free, free), random_harmonics(rng, count, free)
    phase = phases(2 * (wide + count))
    product = np.einsum(
        "tij,tj->ti", synthesized(matrix.reshape(wide, -1), phase).reshape(-1, free, free), synthesized(u, phase)
    )
    parts = np.array([u.real, u.imag])
    real, imaginary = np.einsum("ahibkj,bkj->ahi", hill_matrix(matrix, count), parts)
    assert real + 1j * imaginary == pytest.approx(harmonics_of(product)[:count], abs=1e-11)


def random_system(seed, free=2, memory=3):
    rng = np.random.default_rng(seed)
    matrix, parts = rng.normal(size=(2 * free + memory,) * 2), random_harmonics(rng, 3, free, free)
    return matrix, lambda phase: synthesized(parts.reshape(3, -1), phase).reshape(-1, free, free)


def test_monodromy_has_order_six_against_an_independent_integrator():
    (matrix, coupling), period, size, free = random_system(1), 2.0, 7, 2

    def rates(t, y):
        z = y.reshape(size, size)
        out = matrix @ z
        out[free : 2 * free] += coupling(np.array([2 * np.pi * t / period]))[0] @ z[:free]
        return out.ravel()

    done = solve_ivp(rates, (0.0, period), np.eye(size).ravel(), method="DOP853", rtol=1e-13, atol=1e-13)
    truth = done.y[:, -1].reshape(size, size)
    counts = np.array([32, 48, 64, 96, 128])
    errors = [np.abs(monodromy(matrix, coupling(phases(count)), period) - truth).max() for count in counts]
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.all(np.abs(slopes - 6.0) < 0.4), slopes


def mathieu(a, q, count):
    """Monodromy over pi of y'' + (a - 2 q cos 2t) y = 0."""
    return monodromy(np.array([[0.0, 1.0], [-a, 0.0]]), 2 * q * np.cos(phases(count))[:, None, None], np.pi)


@pytest.mark.parametrize(("boundary", "order", "trace"), [(mathieu_b, 1, -2.0), (mathieu_a, 2, 2.0)])
def test_stability_boundaries_of_mathieus_equation(boundary, order, trace):
    """Abramowitz and Stegun 20.2: at a characteristic value one solution has the period pi or 2 pi."""
    a = float(boundary(order, 1.0))
    errors = [abs(np.trace(mathieu(a, 1.0, count)) - trace) for count in (64, 128, 256)]
    assert errors[2] < 1e-8
    assert all(coarse > 30 * fine or coarse < 1e-9 for coarse, fine in itertools.pairwise(errors))


def test_unresolved_multipliers_are_refused():
    """A coupling that is another one at every sampling."""
    matrix = np.array([[0.0, 3.0], [-3.0, 0.0]])
    with pytest.raises(ConvergenceError, match=r"stability of a periodic motion cannot be determined: .*add"):
        multipliers(matrix, lambda phase: np.random.default_rng(7).normal(size=(len(phase), 1, 1)), 50.0)


OMEGA = 2 * np.pi / 2.5
STATED, INFERRED = {"pressure": 1800.0}, {"pressure": 360.0}


@pytest.fixture(scope="module")
def paper():
    study = config.load(HERE.parent / "config" / "paper.yaml")
    return config.parse({**study.model_dump(), "published": None})


def assumed(study, design="FSB", period=None, **changes):
    """Scene of one design under an assumed pressure."""
    if period:
        changes["waves"] = [{"kind": "regular", "amplitude": 0.1, "period": period}]
    one = varied(study, designs={design: study.designs[design].model_dump()}, **changes)
    basis, water = study_basis(one), one.water
    omega = getattr(one.waves[0], "omega", 0.0)
    load = AssumedPressure(one.hydro.pressure if omega else 0.0, omega)
    shell, motions = (
        DeformedShell(basis, one.centre_height, np.zeros(len(basis.labels))),
        design_motions(one, basis, design),
    )
    return assumed_pressure_scene(shell, LinearPto(one.pto.damping), load, water.density, water.gravity, motions)


def tuned(paper, ratio, damping, **changes):
    """A rigid buoy under an assumed pressure of `ratio` times the frequency of its free heave."""
    plant = assumed(paper, pto={"damping": damping}, **changes)
    natural = np.sqrt(plant.water.tangent[0, 0] / plant.mass[0, 0])
    return assumed(paper, period=float(2 * np.pi / (ratio * natural)), pto={"damping": damping}, **changes)


@pytest.fixture(scope="module")
def scene(wet_buoy):
    """Function (design, sea, kind) -> body-exact or linear scene of the body-exact study, and its buoy."""
    study = config.load(HERE.parent / "config" / "body_exact.yaml")

    def build(design, sea, kind="exact"):
        buoy, shape, radiation, motions = wet_buoy(study, design)
        if kind == "linear":
            return linear_scene(buoy, radiation, sea, motions), buoy
        return body_exact_scene(buoy, shape, radiation, sea, motions), buoy

    return build


def swell(amplitude, omega=OMEGA):
    return Sea(np.array([omega]), np.array([complex(amplitude)]))


def marched(plant, periods, tolerance=1e-9):
    """Times and motion of the last of many periods."""
    period = 2 * np.pi / harmonic.regular_frequency(System.of(plant))
    time = np.linspace(0.0, periods * period, 64 * periods + 1)
    motion, _ = integrate(System.of(plant), time, plant.start(0.0, 0.0), tolerance)
    return time[-65:], motion.position[-65:]


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_linear_scene_equals_its_exact_steady_state(scene, design):
    plant, _ = scene(design, swell(0.3), "linear")
    found, system, free = harmonic_balance(System.of(plant)), System.of(plant), plant.motions.shape[1]
    expected = steady_state(system)[0, :free] @ system.position.T
    assert np.abs(found.harmonics[1] - expected).max() < 1e-12 * np.abs(expected).max()
    assert np.abs(np.delete(found.harmonics, 1, axis=0)).max() == 0.0
    growth = np.exp(np.linalg.eigvals(system.matrix).real.max() * 2 * np.pi / OMEGA)
    assert found.decay == pytest.approx(growth, rel=1e-9)


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_database_radiation_reproduces_linear_theory(scene, design):
    plant, buoy = scene(design, swell(0.3), "linear")
    linear = buoy.absorbed_power(np.array([OMEGA]), buoy.rao(np.array([OMEGA]), plant.motions))[0] * 0.09
    exact, fitted = steady_power(System.of(plant), transfer=buoy.spectrum.transfer), steady_power(System.of(plant))
    assert exact == pytest.approx(linear, rel=1e-4)  # added mass by Kramers-Kronig
    assert fitted == pytest.approx(linear, rel=2e-3)  # tolerance of the state space: 1e-3


@pytest.mark.parametrize(("load", "damping"), [(STATED, 8000.0), (STATED, 500.0)])
def test_heaving_sphere_satisfies_its_closed_form_equation(paper, load, damping):
    """Half submerged: m z'' + c z' + pi rho g (r^2 z - z^3/3) = P cos(w t) pi (r^2 - z^2) while |z| < r."""
    plant = assumed(paper, hydro=load, pto={"damping": damping})
    found = harmonic_balance(System.of(plant), 1e-11)
    time = np.random.default_rng(1).uniform(0.0, 2.5, 40)
    z, v = (values[:, 0] for values in found.at(time))
    order = found.omega * np.arange(len(found.harmonics))
    acceleration = np.real(np.exp(-1j * np.outer(time, order)) @ (-(order**2) * found.harmonics[:, 0]))
    inertia = plant.mass[0, 0] * acceleration + damping * v
    restoring = np.pi * plant.water.specific_weight * (4.0 * z - z**3 / 3)
    driving = load["pressure"] * np.cos(found.omega * time) * np.pi * (4.0 - z**2)
    assert np.abs(z).max() < 2.0
    assert np.abs(inertia + restoring - driving).max() < 2e-7 * np.abs(restoring).max()  # it floats 1e-8 m higher


def test_long_run_in_waves_converges_to_harmonic_balance(scene):
    plant, _ = scene("FSB", swell(0.179))
    found = harmonic_balance(System.of(plant), 1e-9)
    time, position = marched(plant, 25)
    assert np.abs(position - found.at(time)[0]).max() < 1e-8 * largest(found.harmonics)
    assert found.error < 1e-9


def measured_multipliers(plant, u, wave, periods):
    """Multipliers of a small disturbance of a periodic motion, from its state once a period in time."""
    period, order = 2 * np.pi / wave.omega, -1j * wave.omega * np.arange(len(u))[:, None]
    y, v = (np.real(part.sum(axis=0)) @ wave.system.modes.T for part in (u, order * u))
    time = np.linspace(0.0, periods * period, 64 * periods + 1)
    motion, _ = integrate(System.of(plant), time, (y + 1e-5, v), 1e-12)
    away = np.hstack([motion.position[::64] - y, motion.velocity[::64] - v])
    return np.linalg.eigvals(np.linalg.lstsq(away[:-1], away[1:], rcond=None)[0])


def test_difference_from_linear_theory_is_of_second_order_in_amplitude(scene):
    amplitudes = np.array([0.02, 0.04, 0.08])
    found = np.array(
        [harmonic_balance(System.of(scene("FSB", swell(a))[0]), 1e-11).harmonics[:3, 0] for a in amplitudes]
    )
    drift, first, second = np.abs(found[:, 0]), found[:, 1] / amplitudes, np.abs(found[:, 2])
    for values in (drift, second):
        assert np.diff(np.log(values)) / np.log(2) == pytest.approx(2.0, abs=0.1)
    assert np.diff(np.log(np.abs(np.diff(first)))) / np.log(2) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_still_water_gives_rest(scene, paper, design):
    plant, _ = scene(design, NO_WAVES)
    found = harmonic_balance(System.of(plant))
    assert found.at(np.array([0.0, 3.0]))[0] == pytest.approx(np.array([plant.origin, plant.origin]))
    assert (found.omega, found.power.pto, found.power.residual, found.decay) == (0.0, 0.0, 0.0, 0.0)
    calm = harmonic_balance(System.of(assumed(paper, design, waves=[{"kind": "still"}])))
    assert calm.harmonics.shape == (1, plant.motions.shape[1])
    assert steady_power(System.of(scene(design, NO_WAVES, "linear")[0])) == 0.0


def test_high_wave_is_reached_by_continuation(paper):
    """At resonance with little damping, where the linear amplitude would be 47 m."""
    plant = tuned(paper, 1.0, 200.0)
    found = harmonic_balance(System.of(plant), 1e-9)
    assert found.iterations > harmonic.STEPS
    assert found.power.residual < 1e-8
    time = np.linspace(0.0, 2 * np.pi / found.omega, 65)
    start = tuple(values[0] for values in found.at(np.zeros(1)))
    motion, _ = integrate(System.of(plant), time, start, 1e-11)
    assert np.abs(motion.position - found.at(time)[0]).max() < 1e-7


def test_parametric_resonance_is_refused_and_grows_as_in_time(paper):
    """A light buoy forced at twice its natural frequency; its waterplane varies with its draft."""
    plant = tuned(paper, 2.0, 200.0, device={"mass": 9000.0})
    with pytest.raises(StabilityError, match=r"the steady state is unstable: .*multiplied by 1\.061.*add damping"):
        harmonic_balance(System.of(plant))
    wave = PeriodicScene(System.of(plant), harmonic.regular_frequency(System.of(plant)), None)
    u = continued(wave, resting(plant), 1e-11).harmonics
    found = multipliers(wave.system.matrix, lambda phase: wave.coupling(u, phase), 2 * np.pi / wave.omega)
    assert np.sort_complex(measured_multipliers(plant, u, wave, 12)) == pytest.approx(np.sort_complex(found), abs=1e-4)
    assert found[0].real < -1.06  # at twice the period


def test_undamped_resonance_is_refused(scene):
    plant, _ = scene("FSB", swell(0.1), "linear")
    natural = float(np.sqrt(plant.stiffness[0, 0] / plant.mass[0, 0]))
    lossless = {name: force for name, force in plant.forces.items() if name not in ("pto", "radiation")}
    lossless["excitation"] = replace(plant.excitation, omega=np.array([natural]))
    with pytest.raises(StabilityError, match="undamped resonance"):
        harmonic_balance(System.of(replace(plant, forces=lossless)))


@pytest.mark.parametrize("kind", ["exact", "linear"])
def test_irregular_sea_is_refused(scene, kind):
    sea = Sea(np.array([1.0, 2.0]), np.array([0.1 + 0j, 0.1 + 0j]))
    with pytest.raises(ConfigError, match=r"received 2 frequencies from 1 to 2 rad/s, needs one above zero: .*kind:"):
        harmonic_balance(System.of(scene("FSB", sea, kind)[0]))


def test_crushing_load_is_refused(paper):
    plant = assumed(paper, "VSWEC", hydro={"pressure": 1e8})
    with pytest.raises(ConvergenceError, match=r"no steady state is found beyond [\d.]+ % of the wave's amplitude"):
        harmonic_balance(System.of(plant))


def test_unrestrained_mass_is_refused():
    """A free mass in waves: any constant may be added to its motion."""
    waves = Excitation(np.array([2.0]), np.array([[30.0 + 0j]]))
    unrestrained = Scene(
        ("Heave",), np.eye(1), {"pto": TakeOff(np.ones(1), 4.0, limit=5.0), "excitation": waves}, np.eye(1)
    )
    with pytest.raises(ConvergenceError, match="nothing holds a coordinate in a mean place; follow it in time"):
        harmonic_balance(System.of(unrestrained))


def test_tolerance_below_round_off_is_refused(paper):
    with pytest.raises(ConvergenceError, match=r"the steady state is known to .* harmonics, needs 1e-18; use a"):
        harmonic_balance(System.of(assumed(paper)), 1e-18)
