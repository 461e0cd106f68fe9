from dataclasses import replace

import numpy as np
import pytest
from conftest import labelled, varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import StabilityError
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.audit import energies, residual
from vsb.integrators.convolution import convolve
from vsb.integrators.energy_preserving import structure_preserving
from vsb.integrators.exact import propagate, series, steady_state, transition
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.simulate import simulate
from vsb.motion.builders import linear_scene
from vsb.motion.forces import Damper, Excitation, RadiationMemory, RelaxingDamper, Spring
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.results.power import averaging_window
from vsb.scenes.rest import design_motions, study_basis
from vsb.waves.seas import Sea, sea

CALM = DampingSpectrum(np.arange(1, 11) * 1.0, np.zeros((10, 1, 1)))


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
def test_slow_decay_beside_a_fast_one_keeps_its_digits(fast, slow, coupling):
    """exp of [[-a, k a], [0, -b]] in closed form, a up to 1e9: squaring exp itself leaves 1e-8 of b."""
    a, b = 10.0**fast, 10.0**slow
    found = transition(np.array([[-a, coupling * a], [0.0, -b]]))
    assert found[1, 1] == pytest.approx(np.exp(-b), rel=1e-13)
    assert found[0, 0] == pytest.approx(np.exp(-a), rel=1e-13, abs=1e-15)
    if abs(a - b) > 0.1 * a:
        assert found[0, 1] == pytest.approx(coupling * a * (np.exp(-b) - np.exp(-a)) / (a - b), rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("instants", [2, 3, 4, 10, 37, 101])
@pytest.mark.parametrize("begin", [0.0, -3.0, 5.0])
def test_motion_starts_at_the_first_instant_whenever_that_is(instants, begin):
    plant = oscillator({"pto": Damper(np.array([[1.2]]))})
    time = np.linspace(begin, begin + 6.0, instants)
    motion = propagate(System.of(plant), time, (np.array([1.0]), np.array([-0.5])))
    assert motion.position[:, 0] == pytest.approx(damped(time - begin), abs=1e-13)
    wave = {"excitation": Excitation(np.array([2.0]), np.array([[30.0 + 5j]])), **plant.forces}
    pushed = propagate(System.of(replace(plant, forces=wave)), time, (np.array([1.0]), np.array([-0.5])))
    assert pushed.position[0, 0] == pytest.approx(1.0)
    assert pushed.velocity[0, 0] == pytest.approx(-0.5)


def test_a_transient_that_is_over_is_nothing():
    """100 000 s of decay, exp(-30 000): no subnormal numbers, which are slow and wrong in every digit."""
    system = System.of(oscillator({"pto": Damper(np.array([[1.2]]))}))
    motion = propagate(system, np.arange(0.0, 1e5, 0.5), (np.ones(1), np.zeros(1)))
    assert np.all(motion.position[-1000:] == 0.0)
    assert np.abs(motion.position[motion.position != 0]).min() > 1e-300


def test_a_transient_keeps_its_digits_down_to_the_last():
    """Over 200 s heave falls by exp(-60); its error falls with it."""
    time = np.arange(0.0, 200.0, 0.05)
    plant = oscillator({"pto": Damper(np.array([[1.2]]))})
    motion = propagate(System.of(plant), time, (np.array([1.0]), np.array([-0.5])))
    assert np.all(np.abs(motion.position[:, 0] - damped(time)) < 1e-11 * np.exp(-0.3 * time))


def test_many_components_are_the_sum_of_each_alone():
    """Motion is linear: 200 components of one spacing, by transforms, against eight at a time, as they stand."""
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


def test_undamped_shell_conserves_energy_over_a_thousand_periods():
    plant = oscillator({})
    motion = propagate(System.of(plant), np.linspace(0.0, 1000 * 2 * np.pi / 5, 200_001), (np.ones(1), np.zeros(1)))
    energy = 25.0 * motion.position[:, 0] ** 2 + motion.velocity[:, 0] ** 2
    assert np.abs(energy / 25.0 - 1).max() < 1e-9


class TestOfTheSeed:
    def scene(self, buoy_of, radiation_of, study, design, waves):
        motions = design_motions(study, study_basis(study), design)
        return linear_scene(buoy_of(study), radiation_of(study), waves, motions)

    @pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC0", "VSWEC90"])
    @pytest.mark.parametrize("period", [2.5, np.pi, 5.0])
    def test_three_models_agree_in_the_steady_state(self, buoy_of, radiation_of, coarse, design, period):
        study = varied(
            coarse,
            waves=[{"kind": "regular", "amplitude": 0.2, "period": period}],
            simulation={"window": (60.0 - 6 * period, 60.0), "initial_velocity": 0.0},
        )
        wave = study.waves[0]
        waves = sea(wave, study.hydro.omega_max, 60.0)
        plant = self.scene(buoy_of, radiation_of, study, design, waves)
        buoy = buoy_of(study)
        expected = 0.04 * buoy.absorbed_power(waves.omega, buoy.rao(waves.omega, plant.motions))[0]
        for method in ("exact", "convolution"):
            settings = varied(study, simulation={"method": method, "tolerance": 1e-5}).simulation
            motion, _, _ = simulate(System.of(plant), waves, settings, buoy.spectrum)
            absorbed = energies(System.of(plant), motion)["pto"]
            start, end = averaging_window(wave, settings.window)
            mean = np.diff(np.interp([start, end], motion.time, absorbed))[0] / (end - start)
            assert mean == pytest.approx(expected, rel=5e-3), method

    @pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC90"])
    def test_energy_balance_closes(self, buoy_of, radiation_of, coarse, design):
        waves = sea(coarse.waves[0], coarse.hydro.omega_max, 60.0)
        plant = self.scene(buoy_of, radiation_of, coarse, design, waves)
        motion, stride, _ = simulate(System.of(plant), waves, coarse.simulation, buoy_of(coarse).spectrum)
        energy = energies(System.of(plant), motion)
        assert residual(energy) < 1e-6
        assert np.all(np.diff(energy["radiated"]) >= 0)  # the water never gives back more than it stores
        run = labelled(System.of(plant), motion, waves, design, "wave", stride)
        assert run.attrs["energy_residual"] < 1e-6
        assert ("elastic" in run) == (design != "FSB")

    def test_audit_sees_a_lost_force(self, buoy_of, radiation_of, coarse):
        waves = sea(coarse.waves[0], coarse.hydro.omega_max, 60.0)
        plant = self.scene(buoy_of, radiation_of, coarse, "FSB", waves)
        motion, _, _ = simulate(System.of(plant), waves, coarse.simulation, buoy_of(coarse).spectrum)
        fewer = {name: force for name, force in plant.forces.items() if name != "pto"}
        assert residual(energies(System.of(Scene(plant.labels, plant.mass, fewer, plant.motions)), motion)) > 0.01

    def test_clamp_holds_to_round_off(self, buoy_of, radiation_of, coarse):
        waves = sea(coarse.waves[0], coarse.hydro.omega_max, 60.0)
        plant = self.scene(buoy_of, radiation_of, coarse, "VSWEC90", waves)
        motion, _, _ = simulate(System.of(plant), waves, coarse.simulation, buoy_of(coarse).spectrum)
        rows = study_basis(coarse).clamp_rows([np.pi / 2])
        assert np.abs(rows @ plant.motions @ motion.position.T).max() < 1e-13

    def test_irregular_mean_power_is_the_spectral_sum(self, buoy_of, radiation_of, coarse):
        """Components of a realisation repeat after 1.1 durations: over that period the mean is the sum exactly."""
        study = varied(coarse, waves=[{"kind": "jonswap", "hs": 1.0, "tp": 4.0}])
        short = sea(study.waves[0], study.hydro.omega_max, 200.0)
        width = short.omega[1] - short.omega[0]
        plant = self.scene(buoy_of, radiation_of, study, "VSWEC", short)
        buoy = buoy_of(study)
        period = 2 * np.pi / width
        time = np.linspace(0.0, 2 * period, 40_001)
        motion = propagate(System.of(plant), time, plant.start(0.0, 0.0))
        absorbed = energies(System.of(plant), motion)["pto"]
        mean = (absorbed[-1] - absorbed[20_000]) / period
        expected = short.mean_of(buoy.absorbed_power(short.omega, buoy.rao(short.omega, plant.motions)))
        assert mean == pytest.approx(expected, rel=5e-3)

    def test_free_decay_of_the_oes_sphere(self, buoy_of, radiation_of, seed):
        """OES Task 10 heaving sphere: extrema of the linear semi-analytic decay from 1 m (s, m)."""
        published = [
            (2.213, -0.8671), (4.418, 0.6350), (6.597, -0.4649), (8.770, 0.3467), (10.945, -0.2575), (13.119, 0.1917),
        ]  # fmt: skip
        sphere = varied(
            seed,
            device={"radius": 5.0, "mass": 261.8e3},
            water={"density": 1000.0},
            designs={"sphere": {"flexible": False}},
            hydro={"rows": 24, "omega_max": 6.0},
            pto={"damping": 0.0},
            waves=[{"kind": "still"}],
            simulation={"initial_position": 1.0, "initial_velocity": 0.0, "duration": 15.0, "window": (0.0, 15.0)},
        )
        still = Sea(np.zeros(0), np.zeros(0, dtype=complex))
        plant = linear_scene(buoy_of(sphere), radiation_of(sphere), still, np.eye(1))
        time = np.linspace(0.0, 15.0, 15_001)
        motion = propagate(System.of(plant), time, plant.start(1.0, 0.0))
        heave, velocity = motion.position[:, 0], motion.velocity[:, 0]
        turns = np.flatnonzero(velocity[1:-1] * velocity[2:] < 0) + 1
        assert time[turns[:6]] == pytest.approx([t for t, _ in published], abs=0.02)
        assert heave[turns[:6]] == pytest.approx([z for _, z in published], abs=0.01)


OMEGA, PORT, CHAMBER = 1.7, np.array([0.8, -0.6]), 0.4
TAKE_OFFS = (LinearPto(3.0, 0.0, PORT), LinearPto(3.0, 5.0, PORT), LinearPto(3.0, -1.0, PORT))


def chambered(pto):
    """Two motions that radiate, under a wave, with a take-off behind a chamber."""
    beside, own = pto.relaxed(CHAMBER)
    forces = {
        "hydrostatic": Spring(np.array([[9.0, 1.0], [1.0, 20.0]])),
        "radiation": RadiationMemory(RadiationModel(np.array([[-0.5]]), np.array([[1.2, 0.4]]), np.ones(1))),
        "pto": RelaxingDamper(beside.spring(2), PORT, beside.damping, own),
        "excitation": Excitation(np.array([OMEGA]), np.array([[4.0 + 1j, -2.0]])),
    }
    return Scene(("Heave", "Membrane2"), np.array([[2.0, 0.3], [0.3, 1.0]]), forces, np.eye(2))


def swinging(pto):
    """Force F and velocity V - dF/dt C of the take-off as phasors, of motion, chamber and damper written out (C1)."""
    scene = chambered(pto)
    radiation = scene.forces["radiation"].model.transfer(np.array([OMEGA]))[0].conj()
    moving = -(OMEGA**2) * scene.mass - 1j * OMEGA * radiation + scene.forces["hydrostatic"].stiffness
    whole = np.zeros((4, 4), dtype=complex)  # of q, F, flow
    whole[:2, :2], whole[:2, 2] = moving, PORT
    whole[2, 2:] = [1.0, -(pto.damping + 1j * pto.stiffness / OMEGA)]
    whole[3] = [*(1j * OMEGA * PORT), -1j * OMEGA * CHAMBER, 1.0]
    return np.linalg.solve(whole, [*scene.forces["excitation"].phasors[0], 0.0, 0.0])[2:]


@pytest.mark.parametrize("pto", TAKE_OFFS, ids=["damper", "spring", "negative spring"])
def test_a_take_off_behind_a_chamber_takes_in_time_what_it_takes_at_one_frequency(pto):
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


def test_other_integrators_follow_a_chamber_and_the_convolution_refuses_it():
    system, time = System.of(chambered(TAKE_OFFS[0])), np.linspace(0.0, 10.0, 201)
    exact = propagate(system, time, (np.ones(2), np.zeros(2)))
    other, _ = structure_preserving(system, time, (np.ones(2), np.zeros(2)), 1e-6)
    assert other.position == pytest.approx(exact.position, abs=1e-4)
    assert residual(energies(system, other)) < 1e-6
    with pytest.raises(ValueError, match="convolution: received forces that remember besides radiation"):
        convolve(system, CALM, time, (np.ones(2), np.zeros(2)))


def two_springs(omega, natural=(5.0, 8.0)):
    """Unit masses that know nothing of each other, without damping, both pushed by some waves."""
    waves = Excitation(np.array(omega), np.ones((len(omega), 2)) + 0j)
    forces = {"hydrostatic": Spring(np.diag(np.square(natural))), "excitation": waves}
    return System.of(Scene(("Heave", "Membrane0"), np.eye(2), forces, np.eye(2)))


@pytest.mark.parametrize("near", [5.0, 8.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_wave_within_a_billionth_of_an_undamped_resonance_is_named(near, way):
    """Relative to its own frequency; of several waves that one, and just beyond none."""
    inside, beyond = (near * (1 + way * share * 1e-9) for share in (0.9, 1.1))
    for omega in ([2.0, inside, 11.0], [inside, 2.0, 11.0], [11.0, 2.0, inside]):
        with pytest.raises(
            StabilityError, match=rf"^the wave of {near:g} rad/s meets an undamped resonance: no steady"
        ):
            steady_state(two_springs(omega))
    assert np.isfinite(steady_state(two_springs([2.0, beyond, 11.0]))).all()


@pytest.mark.parametrize("count", [1, 255, 256, 257, 600])
def test_steady_states_of_more_waves_than_are_solved_at_a_time_are_each_their_own(count):
    """F/(k - w^2 m - i w c), of position and velocity."""
    omega, rng = np.linspace(0.3, 9.0, count), np.random.default_rng(6)
    push = rng.normal(size=(count, 1)) + 1j * rng.normal(size=(count, 1))
    system = System.of(oscillator({"pto": Damper(np.array([[1.2]])), "excitation": Excitation(omega, push)}))
    found, exact = steady_state(system), push[:, 0] / (50.0 - 2.0 * omega**2 - 1.2j * omega)
    np.testing.assert_allclose(found[:, 0] * system.position[0, 0], exact, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1] * system.modes[0, 0], -1j * omega * exact, rtol=1e-9)


def test_a_steady_state_that_is_known_is_taken_as_it_is():
    """The right one changes nothing; with none the motion is the free one."""
    wave = Excitation(np.array([2.0]), np.array([[30.0 + 5j]]))
    free, system = (
        System.of(oscillator({"pto": Damper(np.array([[1.2]])), **more})) for more in ({}, {"excitation": wave})
    )
    time, start = np.linspace(1.0, 9.0, 33), (np.array([1.0]), np.array([-0.5]))
    plain, known, none, calm = (
        propagate(one, time, start, *steady).position
        for one, *steady in (
            (system,), (system, steady_state(system)), (system, np.zeros((1, 2), dtype=complex)), (free,),
        )
    )  # fmt: skip
    np.testing.assert_array_equal(known, plain)
    np.testing.assert_allclose(none, calm, atol=1e-12)
    assert np.abs(plain - calm).max() > 0.1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_small_part_of_a_transient_that_lasts_is_kept_beside_a_large_one_that_goes(sign):
    """Two masses alone: one falls by exp(-100) between records, the other, of a ten thousandth, by next to nothing."""
    dampers = Damper(np.diag([1e3, 1e-3]))
    system = System.of(Scene(("a", "b"), np.eye(2), {"pto": dampers}, np.eye(2)))
    time = 0.1 * np.arange(400)
    motion = propagate(system, time, (np.zeros(2), sign * np.array([-1e4, -1.0])))
    np.testing.assert_allclose(motion.velocity[:, 1], -sign * np.exp(-1e-3 * time), rtol=1e-11)


def test_motion_velocity_acceleration_and_memory_are_those_of_the_whole_system():
    """Of two coupled motions in two waves with a chamber: the equation of motion and its memory at every record."""
    pto, time = TAKE_OFFS[1], np.linspace(-2.0, 4.0, 61)
    system = System.of(chambered(pto))
    first = (np.array([0.3, -0.2]), np.array([0.5, 0.1]), np.array([0.2, -0.4])[: len(system.matrix) - 4])
    motion = propagate(system, time, first)
    for found, begun in zip((motion.position, motion.velocity, motion.memory), first, strict=True):
        np.testing.assert_allclose(found[0], begun, atol=1e-12)
    z = system.states(motion)
    push = np.real(np.exp(-1j * np.outer(time, system.omega)) @ system.waves)
    rates = z @ system.matrix.T + push @ system.input.T
    np.testing.assert_allclose(motion.acceleration, rates[:, 2:4] @ system.modes.T, atol=1e-10)
    fine = propagate(system, np.linspace(-2.0, -1.9, 11), first)
    slope = (fine.memory[2:] - fine.memory[:-2]) / 0.02
    now = system.states(fine) @ system.matrix.T
    np.testing.assert_allclose(slope, now[1:-1, 4:], atol=1e-3)


@pytest.mark.parametrize(("entry", "halvings"), [(0.0, 0), (0.041, 0), (0.043, 1), (-0.043, 1), (0.24, 3), (1.0, 5)])
def test_a_series_is_halved_until_its_columns_add_up_to_a_half(entry, halvings):
    """Twelve states alike: 0.0417 each are a half; the terms are those of the exponential of what is left."""
    x = np.full((12, 12), entry)
    terms, found = series(x)
    assert found == halvings
    part, power = x / 2.0**halvings, np.eye(12)
    for k, term in enumerate(terms):
        np.testing.assert_allclose(term, power, rtol=1e-12, atol=1e-300)
        power = power @ part / (k + 1)
    grown = np.expm1(12 * entry) / 12  # all in one direction
    np.testing.assert_allclose(transition(x), np.eye(12) + grown, rtol=1e-12)


def test_a_series_is_halved_by_the_largest_column_of_several():
    x = np.diag([0.1, -3.9, 1.0])
    assert series(x)[1] == 3
    assert series(x.T + np.diag([0.0, 0.0, 7.0]))[1] == 4
