"""Exact propagation of linear scenes and Cummins' convolution: closed forms, superposition, frequency domain, chambers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.hydro.radiation import RadiationModel, fit_radiation
from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.exact import convolve, propagate, steady_state, transition
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import simulate
from vsb.engine.motion.forces import Damper, Excitation, RadiationMemory, RelaxingDamper, Spring
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, linear_scene
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import Sea
from vsb.errors import StabilityError
from vsb.models.rest import design_motions, study_basis


def oscillator(forces):
    return Scene(("Heave",), np.array([[2.0]]), {"hydrostatic": Spring(np.array([[50.0]])), **forces}, np.eye(1))


def damped(time, heave=1.0, velocity=-0.5):
    """Closed form of 2 y'' + 1.2 y' + 50 y = 0."""
    decay, frequency = 0.3, np.sqrt(25 - 0.09)
    return np.exp(-decay * time) * (
        heave * np.cos(frequency * time) + (velocity + decay * heave) / frequency * np.sin(frequency * time)
    )


def test_propagation_is_exact_for_any_step():
    plant = oscillator({"pto": Damper(np.array([[1.2]]))})
    for step in (0.01, 0.5, 7.0):
        time = np.arange(0.0, 21.0, step)
        motion = propagate(System.of(plant), time, (np.array([1.0]), np.array([-0.5])))
        assert motion.position[:, 0] == pytest.approx(damped(time), abs=1e-12)


@settings(max_examples=40)
@given(st.floats(-3.0, 9.0), st.floats(-3.0, 1.5), st.floats(-1.0, 1.0))
def test_matrix_exponential_of_widely_spaced_rates_has_its_closed_form(fast, slow, coupling):
    """exp of [[-a, k a], [0, -b]], a up to 1e9; plain squaring of exp keeps only 1e-8 of exp(-b)."""
    a, b = 10.0**fast, 10.0**slow
    found = transition(np.array([[-a, coupling * a], [0.0, -b]]))
    assert found[1, 1] == pytest.approx(np.exp(-b), rel=1e-13)
    assert found[0, 0] == pytest.approx(np.exp(-a), rel=1e-13, abs=1e-15)
    if abs(a - b) > 0.1 * a:
        assert found[0, 1] == pytest.approx(coupling * a * (np.exp(-b) - np.exp(-a)) / (a - b), rel=1e-12, abs=1e-14)


def test_motion_in_many_wave_components_is_the_sum_over_components():
    """200 equally spaced components, summed by FFT, against eight at a time."""
    plant, time = oscillator({"pto": Damper(np.array([[1.2]]))}), np.linspace(0.0, 30.0, 901)
    omega, rng = 0.03 * np.arange(1, 201), np.random.default_rng(4)
    force = rng.normal(size=(200, 1)) + 1j * rng.normal(size=(200, 1))

    def motion(some):
        pushed = {**plant.forces, "excitation": Excitation(omega[some], force[some])}
        return propagate(System.of(replace(plant, forces=pushed)), time, (np.zeros(1), np.zeros(1)))

    whole, parts = motion(slice(None)), [motion(slice(i, i + 8)) for i in range(0, 200, 8)]
    for name in ("position", "velocity", "acceleration"):
        expected = sum(getattr(part, name) for part in parts)
        assert getattr(whole, name) == pytest.approx(expected, abs=1e-11 * np.abs(expected).max()), name


def test_forced_motion_satisfies_the_equation_of_motion():
    wave = Excitation(np.array([2.0, 3.3]), np.array([[30.0 + 5j], [-4j]]))
    plant = oscillator({"pto": Damper(np.array([[1.2]])), "excitation": wave})
    time = np.linspace(0.0, 10.0, 501)
    motion = propagate(System.of(plant), time, (np.array([0.2]), np.zeros(1)))
    push = np.real(np.exp(-1j * np.outer(time, wave.omega)) @ wave.phasors)[:, 0]
    left = 2.0 * motion.acceleration[:, 0] + 1.2 * motion.velocity[:, 0] + 50.0 * motion.position[:, 0]
    assert left == pytest.approx(push, abs=1e-10)
    assert motion.position[0, 0] == pytest.approx(0.2)


def test_undamped_resonance_has_no_steady_state():
    plant = oscillator({"excitation": Excitation(np.array([5.0]), np.array([[1.0 + 0j]]))})
    with pytest.raises(StabilityError, match=r"wave of 5 rad/s meets an undamped resonance.*add device.damping"):
        propagate(System.of(plant), np.linspace(0, 1, 11), (np.zeros(1), np.zeros(1)))


@pytest.fixture(scope="module")
def linear(seed, spectral_seed):
    """Function (design, sea) -> linear scene of the seed and its buoy."""
    radiation, buoy = fit_radiation(spectral_seed.spectrum, 1e-3)[0], replace(spectral_seed, pto=LinearPto(8e3))

    def build(design, waves):
        return linear_scene(buoy, radiation, waves, design_motions(seed, study_basis(seed), design)), buoy

    return build


@pytest.mark.parametrize(("design", "period"), [("FSB", 2.5), ("VSWEC90", 5.0)])
def test_propagation_and_convolution_agree_with_the_frequency_domain(linear, design, period):
    waves = Sea(np.array([2 * np.pi / period]), np.array([0.2 + 0j]))
    plant, buoy = linear(design, waves)
    expected = 0.04 * buoy.absorbed_power(waves.omega, buoy.rao(waves.omega, plant.motions))[0]
    for method in ("exact", "convolution"):
        window = (60.0 - 6 * period, 60.0)
        settings = Simulation(duration=60.0, window=window, method=method, tolerance=1e-5)
        motion, _, _ = simulate(System.of(plant), waves, settings, buoy.spectrum)
        absorbed = energies(System.of(plant), motion)["pto"]
        mean = np.diff(np.interp(window, motion.time, absorbed))[0] / (6 * period)
        assert mean == pytest.approx(expected, rel=5e-3), method


OMEGA, PORT, CHAMBER = 1.7, np.array([0.8, -0.6]), 0.4
TAKE_OFFS = (LinearPto(3.0, 0.0, PORT), LinearPto(3.0, 5.0, PORT), LinearPto(3.0, -1.0, PORT))


def chambered(pto):
    """Two radiating motions in a wave with a take-off behind an air chamber."""
    beside, own = pto.relaxed(CHAMBER)
    forces = {
        "hydrostatic": Spring(np.array([[9.0, 1.0], [1.0, 20.0]])),
        "radiation": RadiationMemory(RadiationModel(np.array([[-0.5]]), np.array([[1.2, 0.4]]), np.ones(1))),
        "pto": RelaxingDamper(beside.spring(2), PORT, beside.damping, own),
        "excitation": Excitation(np.array([OMEGA]), np.array([[4.0 + 1j, -2.0]])),
    }
    return Scene(("Heave", "Membrane2"), np.array([[2.0, 0.3], [0.3, 1.0]]), forces, np.eye(2))


def swinging(pto):
    """Phasors of the take-off's force F and velocity V - C dF/dt, from the equations written out."""
    scene = chambered(pto)
    radiation = scene.forces["radiation"].model.transfer(np.array([OMEGA]))[0].conj()
    moving = -(OMEGA**2) * scene.mass - 1j * OMEGA * radiation + scene.forces["hydrostatic"].stiffness
    whole = np.zeros((4, 4), dtype=complex)  # of q, F, flow
    whole[:2, :2], whole[:2, 2] = moving, PORT
    whole[2, 2:] = [1.0, -(pto.damping + 1j * pto.stiffness / OMEGA)]
    whole[3] = [*(1j * OMEGA * PORT), -1j * OMEGA * CHAMBER, 1.0]
    return np.linalg.solve(whole, [*scene.forces["excitation"].phasors[0], 0.0, 0.0])[2:]


@pytest.mark.parametrize("pto", TAKE_OFFS, ids=["damper", "spring", "negative spring"])
def test_take_off_behind_an_air_chamber_absorbs_the_closed_form_power(pto):
    force, flow = swinging(pto)
    mean, system, period = 0.5 * pto.damping * abs(flow) ** 2, System.of(chambered(pto)), 2 * np.pi / OMEGA
    time, (swing,) = np.linspace(0.0, 3 * period, 481), steady_state(system).real
    motion = propagate(system, time, (system.position @ swing[:2], system.modes @ swing[2:4], swing[4:]))
    energy = energies(system, motion)
    assert residual(energy) < 1e-10
    assert energy["pto"][-1] / (3 * period) == pytest.approx(mean, rel=1e-9)
    expected = np.real(force * np.exp(-1j * OMEGA * time))
    assert system.forces(motion)["pto"] == pytest.approx(-np.outer(expected, PORT), abs=1e-9 * abs(force))
    steady = harmonic_balance(system)
    assert steady.power.pto == pytest.approx(mean, rel=1e-9)
    assert steady.power.residual < 1e-9


COUPLED = RadiationModel(
    np.array([[-0.5, 0.7], [-0.7, -0.3]]), np.array([[1.5, 0.4], [-0.6, 1.1]]), np.diag(np.sqrt([1.0, 0.6]))
)
"""A memory of two states whose kernel is not a symmetric matrix."""


def test_convolution_of_coupled_motions_in_waves_is_of_second_order():
    """Two motions coupled by mass, springs, dampers and memory."""
    memory, motions = RadiationMemory(COUPLED), np.array([[1.0, 0.5], [-0.2, 1.0]])
    forces = {
        "hydrostatic": Spring(np.array([[50.0, 4.0], [4.0, 20.0]])),
        "pto": Damper(np.array([[1.2, 0.2], [0.2, 0.5]])),
        "radiation": memory,
        "excitation": Excitation(np.array([0.9, 2.1]), np.array([[3.0 + 1.0j, -2.0j], [-1.0, 4.0 + 0.5j]])),
    }
    scene = Scene(("Heave", "Pitch"), np.array([[2.0, 0.3], [0.3, 1.5]]), forces, motions)
    system = System.of(scene)
    begin, errors = (np.array([0.3, -0.7]), np.array([-0.5, 0.4])), []
    for count in (100, 200, 400):
        time = np.linspace(0.0, 4.0, count + 1)
        exact, found = propagate(system, time, begin), convolve(system, COUPLED, time, begin)
        errors.append(
            [np.abs(getattr(found, of) - getattr(exact, of)).max() for of in ("position", "velocity", "acceleration")]
        )
        assert found.time is time
        assert found.memory.shape == (count + 1, 0)
    slopes = np.diff(np.log(errors), axis=0) / np.log(0.5)
    assert np.all(np.abs(slopes - 2.0) < 0.15), slopes
