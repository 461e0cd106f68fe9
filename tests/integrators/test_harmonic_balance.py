"""Steady state in a regular wave: closed forms, long motion in time, order, energy, invariance, stability, limits."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from conftest import HERE, solved_block, varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.hydro import database
from vsb.hydro.statespace import RadiationModel, fit_radiation
from vsb.integrators import harmonic_balance as harmonic
from vsb.integrators.exact import steady_state
from vsb.integrators.exponential import integrate
from vsb.integrators.floquet import largest, multipliers, phases
from vsb.integrators.harmonic_balance import (
    Power,
    SteadyState,
    check_stable,
    continued,
    harmonic_balance,
    missed,
    steady_power,
)
from vsb.integrators.regular_wave import PeriodicScene
from vsb.motion.builders import assumed_pressure_scene, body_exact_scene, linear_scene
from vsb.motion.forces import AssumedPressure, Damper, Excitation, Force, Linear, QuadraticDrag, RadiationMemory, Spring
from vsb.motion.frequency import LinearBuoy
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene, resting
from vsb.motion.system import System
from vsb.motion.take_off import TakeOff
from vsb.scenes.rest import design_motions, reference_shell, study_basis
from vsb.shell.deformed import DeformedShell
from vsb.study import study as config
from vsb.study.plan import StudyPlan
from vsb.waves.seas import NO_WAVES, Sea

OMEGA = 2 * np.pi / 2.5
STATED, INFERRED = {"pressure": 1800.0}, {"pressure": 360.0}
DESIGNS = ("FSB", "VSWEC", "VSWEC0", "VSWEC90")


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
def scene():
    """Function (design, sea, kind) -> body-exact or linear plant of the body-exact study, and its buoy; no panels."""
    study = config.load(HERE.parent / "config" / "body_exact.yaml")
    basis = study_basis(study)
    blocks = [solved_block(block, None) for block in StudyPlan(study).sweep_blocks]
    raw = database.in_modes(database.with_excitation(database.merged_blocks(blocks)), basis)
    ds = database.with_structure(database.with_symmetrized(raw), reference_shell(study))
    ds = ds.assign_attrs({"gravity": 9.81, "water_depth": "inf", "water_density": 1025.0})
    buoy = LinearBuoy(ds, basis.damping, LinearPto(study.pto.damping))
    radiation = fit_radiation(buoy.spectrum, 1e-3)[0]
    shape = DeformedShell(basis, study.centre_height, reference_shell(study).modal_amplitude)

    def build(design, sea, kind="exact"):
        motions = design_motions(study, basis, design)
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


# closed forms and other methods --------------------------------------------------------------------------------------


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_linear_scene_is_its_exact_steady_state(scene, design):
    plant, _ = scene(design, swell(0.3), "linear")
    found, system, free = harmonic_balance(System.of(plant)), System.of(plant), plant.motions.shape[1]
    expected = steady_state(system)[0, :free] @ system.position.T
    assert np.abs(found.harmonics[1] - expected).max() < 1e-12 * np.abs(expected).max()
    assert np.abs(np.delete(found.harmonics, 1, axis=0)).max() == 0.0
    growth = np.exp(np.linalg.eigvals(system.matrix).real.max() * 2 * np.pi / OMEGA)
    assert found.decay == pytest.approx(growth, rel=1e-9)


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_radiation_of_the_database_itself_gives_linear_theory_without_a_state_space(scene, design):
    plant, buoy = scene(design, swell(0.3), "linear")
    linear = buoy.absorbed_power(np.array([OMEGA]), buoy.rao(np.array([OMEGA]), plant.motions))[0] * 0.09
    exact, fitted = steady_power(System.of(plant), transfer=buoy.spectrum.transfer), steady_power(System.of(plant))
    assert exact == pytest.approx(linear, rel=1e-4)  # added mass by Kramers-Kronig
    assert fitted == pytest.approx(linear, rel=2e-3)  # tolerance of the state space: 1e-3


@pytest.mark.parametrize(("load", "damping"), [(STATED, 8000.0), (INFERRED, 6000.0), (STATED, 500.0)])
def test_orbit_of_a_sphere_solves_its_equation_in_closed_form(paper, load, damping):
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


def test_published_velocity_of_the_rigid_buoy(paper):
    """The paper's Table II, FSB: 0.9732 m/s peak to peak, and 1421 W at the peak, with the parameters it implies."""
    found = harmonic_balance(System.of(assumed(paper, hydro=INFERRED, pto={"damping": 6000.0})))
    velocity = found.at(np.linspace(0.0, 2.5, 2001))[1][:, 0]
    assert np.ptp(velocity) == pytest.approx(0.9732, rel=5e-3)
    assert 6000.0 * np.max(velocity**2) == pytest.approx(1421.0, rel=1e-2)


@pytest.mark.parametrize("design", DESIGNS)
def test_a_long_motion_under_assumed_pressure_ends_there(paper, design):
    plant = assumed(paper, design)
    found = harmonic_balance(System.of(plant), 1e-9)
    time, position = marched(plant, 36)
    assert np.abs(position - found.at(time)[0]).max() < 3e-8 * np.abs(position).max()


@pytest.mark.parametrize(("design", "periods"), [("FSB", 25), ("VSWEC", 55)])
def test_a_long_motion_in_waves_ends_there(scene, design, periods):
    plant, _ = scene(design, swell(0.179))
    found = harmonic_balance(System.of(plant), 1e-9)
    time, position = marched(plant, periods)
    assert np.abs(position - found.at(time)[0]).max() < 1e-8 * largest(found.harmonics)
    assert found.error < 1e-9


def measured_multipliers(plant, u, wave, periods):
    """Of a small disturbance of an orbit of a scene with two states, seen once a period in a motion in time."""
    period, order = 2 * np.pi / wave.omega, -1j * wave.omega * np.arange(len(u))[:, None]
    y, v = (np.real(part.sum(axis=0)) @ wave.system.modes.T for part in (u, order * u))
    time = np.linspace(0.0, periods * period, 64 * periods + 1)
    motion, _ = integrate(System.of(plant), time, (y + 1e-5, v), 1e-12)
    away = np.hstack([motion.position[::64] - y, motion.velocity[::64] - v])
    return np.linalg.eigvals(np.linalg.lstsq(away[:-1], away[1:], rcond=None)[0])


@pytest.mark.parametrize("damping", [6000.0, 200.0])
def test_multipliers_are_those_of_a_motion_in_time(paper, damping):
    plant = assumed(paper, hydro=INFERRED, pto={"damping": damping})
    found = harmonic_balance(System.of(plant), 1e-11)
    wave = PeriodicScene(System.of(plant), OMEGA, None)
    measured = measured_multipliers(plant, continued(wave, plant.motions[0] * 0.0, 1e-11).harmonics, wave, 12)
    assert np.sort_complex(measured) == pytest.approx(np.sort_complex(found.multipliers), abs=1e-4)


# order ---------------------------------------------------------------------------------------------------------------


def with_harmonics(monkeypatch, plant, count):
    """Orbit of a given number of harmonics, and its scene."""
    monkeypatch.setattr(harmonic, "COUPLED", count)
    system, memory = System.of(plant), plant.memory
    wave = PeriodicScene(system, harmonic.regular_frequency(system), memory.transfer if memory else None)
    return wave, continued(wave, plant.origin if plant.origin.size else resting(plant), 1e-13)


def distance(wave, orbit, truth):
    """Largest difference of two motions, over the amplitude."""
    u = orbit.harmonics @ wave.system.modes.T
    return largest(np.concatenate([u, np.zeros((len(truth) - len(u), u.shape[1]))]) - truth) / largest(truth[1:])


def test_harmonics_converge_exponentially_under_assumed_pressure_and_the_error_is_known(paper, monkeypatch):
    plant = assumed(paper, "VSWEC")
    truth = harmonic_balance(System.of(plant), 1e-12).harmonics
    counts, errors = np.array([2, 4, 6, 8, 10]), []
    for count in counts:
        wave, orbit = with_harmonics(monkeypatch, plant, count)
        errors.append(distance(wave, orbit, truth))
        assert 0.5 < sum(missed(wave, orbit)) / errors[-1] < 2.0
    orders = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.all(np.diff(np.log(errors)) < np.log(0.1)), errors
    assert np.all(orders[2:] > orders[:2] + 3), orders  # faster than any power


def test_harmonics_in_waves_fall_with_the_sixth_power_and_grow_with_the_fourth_of_the_amplitude(scene):
    """Heave of the rigid buoy, odd ones. The force has a kink (y/r) k Z^3 where the wave Z at the shell changes sign."""
    order, amplitudes = np.array([7, 9, 11, 13, 15]), np.array([0.04, 0.08, 0.16, 0.32])
    found = np.abs(
        [harmonic_balance(System.of(scene("FSB", swell(a))[0]), 1e-10).harmonics[order, 0] for a in amplitudes]
    )
    slopes = np.diff(np.log(found), axis=1) / np.diff(np.log(order))
    assert np.all((slopes < -5.8) & (slopes > -7.5)), slopes
    assert np.diff(np.log2(found), axis=0) == pytest.approx(4.0, abs=0.1)


def test_difference_to_linear_theory_is_of_second_order(scene):
    amplitudes = np.array([0.01, 0.02, 0.04, 0.08, 0.16, 0.32])
    found = np.array(
        [harmonic_balance(System.of(scene("FSB", swell(a))[0]), 1e-11).harmonics[:3, 0] for a in amplitudes]
    )
    drift, first, second = np.abs(found[:, 0]), found[:, 1] / amplitudes, np.abs(found[:, 2])
    for values in (drift, second):
        assert np.diff(np.log(values)) / np.log(2) == pytest.approx(2.0, abs=0.1)
    assert np.diff(np.log(np.abs(np.diff(first)))) / np.log(2) == pytest.approx(2.0, abs=0.15)


# energy, invariance --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("design", DESIGNS)
def test_energy_balance_closes(paper, scene, design):
    for plant in (assumed(paper, design), scene(design, swell(0.179))[0]):
        found = harmonic_balance(System.of(plant), 1e-9)
        assert found.power.residual < 1e-9
        assert min(found.power) >= 0.0
    order = OMEGA * np.arange(len(found.harmonics))
    heave = found.harmonics @ plant.motions[0]
    assert found.power.pto == pytest.approx(4000.0 * np.sum((order * np.abs(heave)) ** 2), rel=1e-12)


def test_energy_balance_sees_a_lost_force(scene):
    plant, _ = scene("FSB", swell(0.179))
    found = harmonic_balance(System.of(plant))
    wrong = found.power._replace(pto=0.99 * found.power.pto)
    assert wrong.residual == pytest.approx(0.01 * found.power.pto / found.power.wave, rel=1e-3)


def test_phase_of_the_wave_shifts_the_motion_and_nothing_else(scene):
    found = harmonic_balance(System.of(scene("FSB", swell(0.179))[0]), 1e-10).harmonics

    @settings(max_examples=5)
    @given(st.floats(-np.pi, np.pi))
    def shifted(phase):
        other = harmonic_balance(System.of(scene("FSB", swell(0.179 * np.exp(1j * phase)))[0]), 1e-10).harmonics
        expected = found * np.exp(1j * phase * np.arange(len(found)))[:, None]
        assert np.abs(other[:17] - expected[:17]).max() < 1e-9 * np.abs(found[1]).max()

    shifted()


def test_a_stiff_shell_is_rigid(paper):
    stiff = assumed(paper, "VSWEC", device={"young_modulus": 1e15})
    assert steady_power(System.of(stiff)) == pytest.approx(steady_power(System.of(assumed(paper))), rel=1e-7)


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_still_water_is_rest(scene, paper, design):
    plant, _ = scene(design, NO_WAVES)
    found = harmonic_balance(System.of(plant))
    assert found.at(np.array([0.0, 3.0]))[0] == pytest.approx(np.array([plant.origin, plant.origin]))
    assert (found.omega, found.power.pto, found.power.residual, found.decay) == (0.0, 0.0, 0.0, 0.0)
    calm = harmonic_balance(System.of(assumed(paper, design, waves=[{"kind": "still"}])))
    assert calm.harmonics.shape == (1, plant.motions.shape[1])
    assert steady_power(System.of(scene(design, NO_WAVES, "linear")[0])) == 0.0


# several steady states, unstable ones, none --------------------------------------------------------------------------


def test_a_wave_too_high_for_newtons_method_is_raised_step_by_step(paper):
    """At resonance with little damping: the linear amplitude would be 47 m. The orbit solves its own equation."""
    plant = tuned(paper, 1.0, 200.0)
    found = harmonic_balance(System.of(plant), 1e-9)
    assert found.iterations > harmonic.STEPS
    assert found.power.residual < 1e-8
    time = np.linspace(0.0, 2 * np.pi / found.omega, 65)
    start = tuple(values[0] for values in found.at(np.zeros(1)))
    motion, _ = integrate(System.of(plant), time, start, 1e-11)
    assert np.abs(motion.position - found.at(time)[0]).max() < 1e-7


def test_parametric_resonance_is_refused_and_its_growth_is_that_of_a_motion_in_time(paper):
    """A light buoy pushed at twice its natural frequency: its waterplane varies with its draft."""
    plant = tuned(paper, 2.0, 200.0, device={"mass": 9000.0})
    with pytest.raises(StabilityError, match=r"the steady state is unstable: .*multiplied by 1\.061.*add damping"):
        harmonic_balance(System.of(plant))
    wave = PeriodicScene(System.of(plant), harmonic.regular_frequency(System.of(plant)), None)
    u = continued(wave, resting(plant), 1e-11).harmonics
    found = multipliers(wave.system.matrix, lambda phase: wave.coupling(u, phase), 2 * np.pi / wave.omega)
    assert np.sort_complex(measured_multipliers(plant, u, wave, 12)) == pytest.approx(np.sort_complex(found), abs=1e-4)
    assert found[0].real < -1.06  # at twice the period


def test_an_undamped_resonance_of_a_linear_scene_is_refused(scene):
    plant, _ = scene("FSB", swell(0.1), "linear")
    natural = float(np.sqrt(plant.stiffness[0, 0] / plant.mass[0, 0]))
    lossless = {name: force for name, force in plant.forces.items() if name not in ("pto", "radiation")}
    lossless["excitation"] = replace(plant.excitation, omega=np.array([natural]))
    with pytest.raises(StabilityError, match="undamped resonance"):
        harmonic_balance(System.of(replace(plant, forces=lossless)))


@pytest.mark.parametrize("kind", ["exact", "linear"])
def test_an_irregular_sea_has_no_steady_state(scene, kind):
    sea = Sea(np.array([1.0, 2.0]), np.array([0.1 + 0j, 0.1 + 0j]))
    with pytest.raises(
        ConfigError, match=r"received 2 frequencies from 1 to 2 rad/s, needs one above zero: .*kind: regular"
    ):
        harmonic_balance(System.of(scene("FSB", sea, kind)[0]))


def test_a_load_without_a_period_is_refused(paper):
    plant = assumed(paper)
    constant = replace(plant.water, assumed=replace(plant.water.assumed, omega=0.0))
    with pytest.raises(ConfigError, match=r"received 1 frequencies from 0 to 0 rad/s, needs one above zero"):
        harmonic_balance(System.of(replace(plant, forces={**plant.forces, "water": constant})))


def test_a_load_that_no_motion_answers_is_refused(paper):
    plant = assumed(paper, "VSWEC", hydro={"pressure": 1e8})
    with pytest.raises(ConvergenceError, match=r"no steady state is found beyond [\d.]+ % of the wave's amplitude"):
        harmonic_balance(System.of(plant))


def test_what_nothing_holds_in_a_mean_place_is_refused():
    """A mass that drifts in its waves, its damper saturated: a constant may be added to any motion of it."""
    waves = Excitation(np.array([2.0]), np.array([[30.0 + 0j]]))
    adrift = Scene(("Heave",), np.eye(1), {"pto": TakeOff(np.ones(1), 4.0, limit=5.0), "excitation": waves}, np.eye(1))
    with pytest.raises(ConvergenceError, match="nothing holds a coordinate in a mean place; follow it in time"):
        harmonic_balance(System.of(adrift))


def test_a_tolerance_below_round_off_is_refused(paper):
    with pytest.raises(
        ConvergenceError, match=r"the steady state is known to .* harmonics, needs 1e-18; use a gentler"
    ):
        harmonic_balance(System.of(assumed(paper)), 1e-18)


@pytest.mark.parametrize(
    ("powers", "residual"),
    [((-3.0, 1.0, 1.0, -6.0), 1 / 6), ((4.0, 1.0, 2.0, 3.0), 1 / 2), ((4.0, 1.0, 1.0, 1.0), 1 / 4), ((0.0,) * 4, 0.0)],
)
def test_unbalanced_power_is_told_by_its_size_over_that_of_the_largest_term(powers, residual):
    assert Power(*powers).residual == pytest.approx(residual)


def test_a_steady_motion_is_that_of_all_its_harmonics_and_coordinates():
    harmonics = np.array([[0.3, -0.2], [1.0 - 2.0j, 0.5j], [0.1j, -0.4]])
    found = SteadyState(1.7, harmonics, 0.0, 1, np.array([0.3, -0.2 + 0.6j, 0.1]), Power(0.0, 0.0, 0.0, 0.0))
    time = np.array([0.0, 0.4, -1.3])
    turn, turn2 = np.exp(-1.7j * time)[:, None], np.exp(-3.4j * time)[:, None]
    position, velocity = found.at(time)
    assert position == pytest.approx(np.real(harmonics[0] + turn * harmonics[1] + turn2 * harmonics[2]))
    assert velocity == pytest.approx(np.real(-1.7j * turn * harmonics[1] - 3.4j * turn2 * harmonics[2]))
    assert found.decay == pytest.approx(np.hypot(0.2, 0.6))


def test_a_disturbance_is_judged_by_the_largest_of_its_multipliers_to_a_millionth():
    check_stable(np.array([0.2, -1 - 0.9e-6, 0.1]), 4.0)
    with pytest.raises(StabilityError, match=r"multiplied by 1\.5 in every period of 4 s, needs at most 1"):
        check_stable(np.array([0.2, -1.5, 1.2j]), 4.0)
    with pytest.raises(StabilityError, match="multiplied by 1 in every"):
        check_stable(np.array([1.0, -1 - 1.1e-6]), 4.0)


# by hand -------------------------------------------------------------------------------------------------------------

STEP = 1.5


def two_motions(take_off="pto", **more):
    """Two coupled motions of masses that are not one, a wave, two dampers, drag and a memory."""
    turning, channel = np.array([[0.0, 1.4], [-1.4, 0.0]]), np.array([1.0, 0.6])
    memory = RadiationModel(turning - np.outer(channel, channel) / 2, np.array([[2.0, 0.1], [1.5, -1.0]]), channel)
    forces = {
        "hydrostatic": Spring(np.array([[50.0, -10.0], [-10.0, 300.0]])),
        "pto": Damper(np.array([[4.0, 1.0], [1.0, 2.0]])),
        "structural_damping": Damper(np.diag([0.3, 0.7])),
        "friction": Damper(np.diag([0.1, 0.4])),
        "drag": QuadraticDrag(np.eye(2), np.array([3.0, 1.0]), np.zeros(0), np.zeros((0, 2), dtype=complex)),
        "radiation": RadiationMemory(memory),
        "excitation": Excitation(np.array([STEP]), np.array([[3.0 - 1.0j, 0.5j]])),
    }
    mass = np.array([[2.0, 0.3], [0.3, 1.0]])
    return System.of(Scene(("Heave", "Membrane0"), mass, forces | more, np.eye(2), take_off=take_off)), memory


@pytest.mark.parametrize("take_off", ["pto", "drag", "friction", "radiation", "none"])
def test_mean_powers_of_an_orbit_are_those_of_its_forces_in_plain_coordinates(take_off):
    """Waves and each loss by a sum over a period, radiation by the real part of what it answers at every harmonic."""
    across = QuadraticDrag(np.array([[0.5, -1.0]]), np.array([2.0]), np.zeros(0), np.zeros((0, 1), dtype=complex))
    system, memory = two_motions(take_off, fins=across)
    rng = np.random.default_rng(5)
    u = 0.3 * (rng.normal(size=(4, 2)) + 1j * rng.normal(size=(4, 2)))
    u[0] = u[0].real

    def transfer(omega):
        return np.array([[[1.0 + 2j * w, 0.3 + 0.1j], [0.3 + 0.1j, 0.5 * w]] for w in omega])

    scene = PeriodicScene(system, STEP, transfer)
    orbit = harmonic.Orbit(u, scene.impedance(64), None, 0)
    rates = -1j * STEP * np.arange(4)[:, None] * (u @ system.modes.T)
    phase = 2 * np.pi / 4000 * np.arange(4000)
    v = (np.exp(-1j * np.outer(phase, np.arange(4))) @ rates).real
    forces = system.scene.forces
    losses = {name: np.mean(np.einsum("ti,ij,tj->t", v, forces[name].damping, v)) for name in
              ("pto", "structural_damping", "friction")}  # fmt: skip
    losses["drag"] = np.mean(np.abs(v) ** 3 @ [3.0, 1.0])
    losses["fins"] = np.mean(2.0 * np.abs(v @ [0.5, -1.0]) ** 3)

    def answered(transfer):
        at = transfer(STEP * np.arange(1, 4)).conj()
        return 0.5 * np.einsum("hi,hij,hj", rates[1:].conj(), at, rates[1:]).real

    found = harmonic.mean_power(scene, orbit)
    wave = 0.5 * (np.array([3.0 - 1.0j, 0.5j]) @ rates[1].conj()).real
    assert found.wave == pytest.approx(wave, rel=1e-9)
    relaxed = answered(memory.transfer) if take_off == "radiation" else 0.0
    assert found.pto == pytest.approx(losses.pop(take_off, 0.0) + relaxed, rel=1e-3)
    assert found.structural == pytest.approx(sum(losses.values()), rel=1e-3)  # drag has a kink
    assert found.radiated == pytest.approx(answered(transfer), rel=1e-9)


class Raised(NamedTuple):
    """A scene of which nothing is known but the share of its waves."""

    share: float = 1.0

    def raised(self, share):
        """Itself in a share of the wave."""
        return Raised(share)

    @property
    def scene(self):
        """Its modes are its coordinates."""
        return self

    modes = np.array([[2.0]])
    free = 1


@dataclass(frozen=True)
class Wave:
    """What `continued` and `refined` ask of a scene."""

    system: Raised

    def impedance(self, count):
        """So many."""
        return np.zeros((count, 1, 1), dtype=complex)


@pytest.mark.parametrize(("highest", "shares"), [
    (1.0, [1.0]), (0.7, [1.0, 0.5, 1.0]), (0.4, [1.0, 0.5, 0.25, 0.75]),
])  # fmt: skip
def test_a_wave_is_raised_by_steps_that_double_where_they_may_and_halve_where_they_must(monkeypatch, highest, shares):
    """An orbit is found up to a height above the one it begins from; each begins with the one before."""
    asked, begun = [], []
    monkeypatch.setattr(harmonic, "Newton", lambda *given: begun.append(given))

    def balanced(scene, orbit, tolerance):
        asked.append(scene.system.share)
        height = orbit.iterations / 1000
        return orbit._replace(iterations=round(1000 * asked[-1])) if asked[-1] - height <= highest else None

    monkeypatch.setattr(harmonic, "balanced", balanced)
    found = continued(Wave(Raised()), np.array([6.0]), 1e-6)
    assert asked[: len(shares)] == shares
    assert asked[-1] == 1.0
    assert found.iterations == 1000
    ((calm, _, first, samples),) = begun
    assert (calm.system.share, samples) == (0.0, 2)
    assert first[:, 0].tolist() == [3.0] + [0.0] * harmonic.COUPLED
    assert found.samples == 4 * harmonic.COUPLED


def test_the_height_beyond_which_no_orbit_is_found_is_told(monkeypatch):
    """To three digits of what was reached."""
    monkeypatch.setattr(harmonic, "Newton", lambda *given: None)
    monkeypatch.setattr(harmonic, "balanced", lambda scene, orbit, _: orbit if scene.system.share <= 0.3214 else None)
    with pytest.raises(
        ConvergenceError, match=r"^no steady state is found beyond 32\.1 % of the wave's amplitude; use a"
    ):
        continued(Wave(Raised()), np.zeros(1), 1e-6)


def refining(monkeypatch, errors, tolerance, found=True):
    """Harmonics and samples of the orbits tried where they miss so much by samples and by harmonics, and what comes."""
    tried, left = [], iter(errors)

    def missed(scene, orbit):
        tried.append((len(orbit.harmonics), orbit.samples))
        assert not orbit.harmonics[17:].any()
        return next(left)

    monkeypatch.setattr(harmonic, "missed", missed)
    monkeypatch.setattr(harmonic, "balanced", lambda scene, orbit, _: orbit if found else None)
    first = harmonic.Orbit(np.ones((17, 1), dtype=complex), np.zeros((32, 1, 1)), None, 3)
    try:
        orbit, error = harmonic.refined(Wave(Raised()), first, tolerance)
    except ConvergenceError as refused:
        return tried, str(refused)
    return tried, (len(orbit.harmonics), orbit.samples, error)


def test_harmonics_or_samples_are_doubled_whichever_miss_more(monkeypatch):
    """No fewer than four samples a harmonic; both errors together are within the tolerance."""
    errors = [(1e-3, 2e-3), (3e-3, 1e-3), (2e-3, 2e-3), (0.4e-4, 0.5e-4)]
    tried, found = refining(monkeypatch, errors, 1e-4)
    assert tried == [(17, 64), (33, 132), (33, 264), (33, 528)]
    assert found == (33, 528, pytest.approx(0.9e-4))
    assert refining(monkeypatch, [(0.6e-4, 0.5e-4), (0.0, 0.0)], 1e-4)[0] == [(17, 64), (17, 128)]
    assert refining(monkeypatch, [(1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 0.0)], 1e-4)[0][-1] == (33, 256)


@pytest.mark.parametrize(("errors", "last", "words"), [
    ([(0.0, 2e-3)] * 99, (1025, 4100), "known to 2.0e-03 with 1024 harmonics, needs 1e-06; use a gentler wave"),
    ([(2e-3, 1e-3)] * 99, (17, 16384), "known to 3.0e-03 with 16 harmonics, needs 1e-06; use a gentler wave"),
])  # fmt: skip
def test_there_are_so_many_harmonics_and_samples_at_most(monkeypatch, errors, last, words):
    tried, told = refining(monkeypatch, errors, 1e-6)
    assert tried[-1] == last
    assert words in told


def test_an_orbit_that_is_lost_on_the_way_is_told_with_what_was_known(monkeypatch):
    tried, told = refining(monkeypatch, [(1e-3, 2e-3)] * 9, 1e-6, found=False)
    assert tried == [(17, 64)]
    assert "the steady state is known to 3.0e-03 with 16 harmonics, needs 1e-06" in told


def test_what_a_step_of_newtons_method_takes_away_is_what_its_scene_is_missing():
    """Of a linear scene all of it, of harmonics that are coupled and of those beyond."""
    system, memory = two_motions(drag=Damper(np.zeros((2, 2))))
    scene = PeriodicScene(system, STEP, memory.transfer)
    impedance, rng = scene.impedance(64), np.random.default_rng(6)
    newton = harmonic.Newton(scene, impedance, np.zeros((harmonic.COUPLED + 1, 2), dtype=complex), 2)
    missing = rng.normal(size=(40, 2)) + 1j * rng.normal(size=(40, 2))
    missing[0] = missing[0].real
    found = newton.step(impedance, missing)
    np.testing.assert_allclose(np.einsum("hij,hj->hi", impedance[:40], found), missing, atol=1e-9)
    assert not found[0].imag.any()


@pytest.mark.parametrize(("held", "refused"), [(0.0, True), (1e-3, False)])
def test_what_nothing_holds_has_no_mean_place_whatever_pushes_it(held, refused):
    """The first coordinate draws the second after it, which nothing holds where it is; or the first is not held."""
    system, memory = two_motions(drag=Damper(np.zeros((2, 2))))
    scene = PeriodicScene(system, STEP, memory.transfer)
    for rest in ([[5.0, 0.0], [2.0, held]], [[held, 2.0], [0.0, 5.0]]):
        impedance = scene.impedance(64)
        impedance[0] = rest
        start = np.zeros((harmonic.COUPLED + 1, 2), dtype=complex)
        if refused:
            with pytest.raises(
                ConvergenceError, match=r"^harmonic balance: nothing holds a coordinate in a mean place;"
            ):
                harmonic.Newton(scene, impedance, start, 2)
        else:
            harmonic.Newton(scene, impedance, start, 2)


def test_the_inertia_of_an_orbit_is_that_of_the_harmonics_it_has():
    rng = np.random.default_rng(6)
    u, z = (rng.normal(size=shape) + 1j * rng.normal(size=shape) for shape in ((3, 2), (5, 2, 2)))
    orbit = harmonic.Orbit(u, z, None, 0)
    assert orbit.samples == 10
    np.testing.assert_allclose(orbit.inertial, [*(z[h] @ u[h] for h in range(3)), [0, 0], [0, 0]], rtol=1e-12)


def test_a_steady_power_is_the_take_offs_to_the_tolerance_and_with_the_radiation_asked_for(monkeypatch):
    asked = []

    def balanced(system, tolerance, transfer):
        asked.append((system, tolerance, transfer))
        return SimpleNamespace(power=Power(1.0, 2.0, 3.0, 4.0))

    monkeypatch.setattr(harmonic, "harmonic_balance", balanced)
    assert steady_power("scene") == steady_power("scene", 1e-3, "water") == 2.0
    assert asked == [("scene", 1e-8, None), ("scene", 1e-3, "water")]


@pytest.mark.parametrize("given", [None, lambda omega: np.ones((len(omega), 2, 2)) + 0j])
def test_all_of_a_steady_state_is_handed_on_in_plain_coordinates(given):
    """Harmonics in metres, multipliers of all states, an error below the tolerance; radiation as given or remembered."""
    system, memory = two_motions(drag=Damper(np.zeros((2, 2))))
    found = harmonic_balance(system, 1e-9, given)
    y = found.harmonics[1]
    water = (given or memory.transfer)(np.array([STEP]))[0].conj()
    scene = system.scene
    exact = np.linalg.solve(
        scene.stiffness - STEP**2 * scene.mass - 1j * STEP * (scene.damping + water), [3.0 - 1.0j, 0.5j]
    )
    np.testing.assert_allclose(y, exact, rtol=1e-8)
    np.testing.assert_allclose(np.delete(found.harmonics, 1, axis=0), 0.0, atol=1e-12)
    expected = np.exp(2 * np.pi / STEP * np.linalg.eigvals(system.matrix).real)
    np.testing.assert_allclose(np.abs(found.multipliers), np.sort(expected)[::-1], rtol=1e-6, atol=1e-12)
    assert found.omega == STEP
    assert 0 <= found.error <= 1e-9
    assert found.iterations >= 1
    v = -1j * STEP * exact
    assert found.power.pto == pytest.approx(0.5 * (v.conj() @ scene.forces["pto"].damping @ v).real, rel=1e-8)
    assert found.power.radiated == pytest.approx(0.5 * (v.conj() @ water @ v).real, rel=1e-8)


@dataclass(frozen=True)
class Beat(Force):
    """A force of time alone, of one harmonic of the wave on both coordinates."""

    harmonic: int

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return np.outer(np.cos(self.harmonic * STEP * time), [0.3, -0.7])


@pytest.mark.parametrize("beat", [3, 24, 60])
def test_what_an_orbit_misses_is_what_its_harmonics_or_its_samples_do_not_resolve(beat):
    """64 samples take the 60th harmonic for the fourth; with twice as many that error is seen. The 24th is none of 17."""
    system, memory = two_motions(drag=Beat(beat))
    scene = PeriodicScene(system, STEP, memory.transfer)
    impedance, first = scene.impedance(32), np.zeros((harmonic.COUPLED + 1, 2), dtype=complex)
    orbit = harmonic.Orbit(first, impedance, harmonic.Newton(scene, impedance, first, 2), 0)
    found = harmonic.balanced(scene, orbit, 1e-12)
    pushed = system.shapes.T @ [0.3, -0.7]
    u = np.linalg.solve(impedance[1], scene.push)
    np.testing.assert_allclose(found.harmonics[1], u, rtol=1e-9)
    at = {3: 3, 24: 24, 60: 4}[beat]
    wrong = np.linalg.solve(impedance[at], pushed)
    if at <= harmonic.COUPLED:
        np.testing.assert_allclose(found.harmonics[at], wrong, rtol=1e-8)
    size = np.abs(system.modes @ wrong).max() / scene.amplitude(found.harmonics)
    expected = {3: (0.0, 0.0), 24: (0.0, size), 60: (size, 0.0)}[beat]
    assert missed(scene, found) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_an_orbit_beyond_its_reach_or_that_does_not_settle_is_none(monkeypatch):
    """In metres of whichever coordinate; steps are those Newton's method takes, at most thirty."""
    system, memory = two_motions(drag=Beat(3))
    scene, first = PeriodicScene(system, STEP, memory.transfer), np.zeros((harmonic.COUPLED + 1, 2), dtype=complex)
    asked = []

    class Stepping:
        def __init__(self, size):
            self.size = size

        def step(self, impedance, missing):
            asked.append(missing.shape)
            return np.full(first.shape, self.size * (-1.0) ** len(asked) + 0j)

    monkeypatch.setattr(harmonic, "Newton", lambda *given: Stepping(1e-2))
    orbit = harmonic.Orbit(first, scene.impedance(32), Stepping(1e-2), 5)
    assert harmonic.balanced(scene, orbit, 1e-6) is None
    assert asked == [first.shape] * harmonic.STEPS
    metres = largest(np.ones(first.shape) @ system.modes.T)
    for share, count in ((0.99, harmonic.STEPS), (1.01, 1)):
        asked.clear()
        assert harmonic.balanced(scene, orbit._replace(newton=Stepping(share * scene.reach / metres)), 1e-6) is None
        assert len(asked) == count
    asked.clear()
    small = harmonic.balanced(scene, orbit._replace(newton=Stepping(0.9e-7 * scene.size / metres)), 1e-6)
    assert (small.iterations, len(asked)) == (6, 1)


@dataclass(frozen=True)
class Mixed(Force):
    """Each coordinate's force depends on places, and if it is asked for on rates, of both."""

    rates: float

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        first = -30 * q[:, 0] * q[:, 1] ** 2 - 4 * self.rates * v[:, 1] * q[:, 0]
        return np.stack([first, 20 * q[:, 0] ** 3 - 5 * self.rates * v[:, 0] * v[:, 1]], axis=1)


@pytest.mark.parametrize("rates", [1.0, 0.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_newtons_tangent_is_the_derivative_of_what_an_orbit_is_missing(rates, seed):
    """Along an orbit of two motions, in the direction of any change of its harmonics up to the highest coupled."""
    system, memory = two_motions(drag=Mixed(rates))
    scene, rng = PeriodicScene(system, STEP, memory.transfer), np.random.default_rng(seed)
    u, change = np.zeros((2, harmonic.COUPLED + 1, 2), dtype=complex)
    u[:3] = 0.3 * (rng.normal(size=(3, 2)) + 1j * rng.normal(size=(3, 2)))
    change[:] = rng.normal(size=u.shape) + 1j * rng.normal(size=u.shape)
    u[0], change[0] = u[0].real, change[0].real
    impedance, phase, h = scene.impedance(64), phases(128), 1e-6

    def missing(u):
        return (scene.forced(u, phase) - harmonic.Orbit(u, impedance, None, 0).inertial)[: len(u)]

    lost = (missing(u - h * change) - missing(u + h * change)) / (2 * h)
    found = harmonic.Newton(scene, impedance, u, 64).step(impedance, lost)
    np.testing.assert_allclose(found, change, atol=1e-5)


@dataclass(frozen=True)
class Unknown(Force):
    """A spring and a damper, neither symmetric, that do not say so."""

    def linear(self):
        """Nothing."""
        return Linear(whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return q @ [[-20.0, 3.0], [5.0, -60.0]] + v @ [[-6.0, 1.0], [-2.0, -9.0]]


def test_newtons_method_knows_what_does_not_change_along_an_orbit_at_every_harmonic():
    """Those beyond the coupled ones are taken by the mean of the tangents, by places and by rates."""
    system, memory = two_motions(drag=Unknown())
    scene, rng = PeriodicScene(system, STEP, memory.transfer), np.random.default_rng(8)
    u, change = rng.normal(size=(2, 40, 2)) + 1j * rng.normal(size=(2, 40, 2))
    u[0], change[0] = u[0].real, change[0].real
    impedance, phase = scene.impedance(64), phases(128)

    def missing(u):
        return (scene.forced(u, phase) - harmonic.Orbit(u, impedance, None, 0).inertial)[: len(u)]

    newton = harmonic.Newton(scene, impedance, u[: harmonic.COUPLED + 1], 64)
    np.testing.assert_allclose(newton.step(impedance, missing(u) - missing(u + change)), change, atol=1e-5)
