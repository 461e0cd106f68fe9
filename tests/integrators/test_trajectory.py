import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLE, only_run, varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConvergenceError
from vsb.hydro.statespace import RadiationModel
from vsb.integrators import simulate as simulating
from vsb.integrators import trajectory
from vsb.integrators.audit import START, TERMS, energies, residual
from vsb.integrators.convolution import convolve
from vsb.integrators.exact import propagate
from vsb.integrators.simulate import EXACT, legs, simulate
from vsb.integrators.trajectory import Leg, recorded
from vsb.motion.builders import linear_scene
from vsb.motion.forces import Damper, Excitation, RadiationMemory, Spring
from vsb.motion.motion import Motion
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.scenes.build import assumed_pressure_design
from vsb.scenes.rest import design_motions, study_basis
from vsb.study import resolution
from vsb.study.study import load
from vsb.waves.seas import NO_WAVES, Sea, sea

PAPER = EXAMPLE.parent / "paper.yaml"
TRANSIENT = 1e7
"""A take-off that stops the seed's buoy in 2 ms [N s/m]; records are 12.5 ms apart."""


@pytest.fixture
def scene(buoy_of, radiation_of, seed):
    """Function design, changes -> plant, sea, settings, damping of a linear scene."""

    def build(design="VSWEC", **changes):
        study = varied(seed, **changes)
        waves = sea(study.waves[0], study.hydro.omega_max, study.simulation.duration)
        motions = design_motions(study, study_basis(study), design)
        plant = linear_scene(buoy_of(study), radiation_of(seed), waves, motions)  # no change here is of the water
        return plant, waves, study.simulation, buoy_of(study).spectrum

    return build


def unbalanced(energy):
    """Largest unbalanced energy [J]."""
    return np.abs(energy["wave"] - sum(energy[term] for term in TERMS[1:])).max()


# every linear run ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC0", "VSWEC90"])
@pytest.mark.parametrize("damping", [8e3, TRANSIENT])
def test_every_design_is_audited_to_round_off_in_one_run(scene, monkeypatch, design, damping):
    plant, waves, settings, spectrum = scene(design, pto={"damping": damping})
    runs = []
    monkeypatch.setattr(simulating, "propagate", lambda *given: runs.append(given) or propagate(*given))
    motion, stride, method = simulate(System.of(plant), waves, settings, spectrum)
    energy = energies(System.of(plant), motion)
    assert (len(runs), stride, method) == (1, 1, EXACT)
    assert unbalanced(energy) < 1e-9 * energy["pto"][-1]
    assert np.all(np.diff(energy["radiated"]) >= 0)
    assert np.all(np.diff(energy["pto"]) >= 0)


def test_an_irregular_sea_is_audited_to_round_off(scene):
    plant, waves, settings, spectrum = scene(waves=[{"kind": "jonswap", "hs": 1.0, "tp": 4.0}])
    motion, stride, _ = simulate(System.of(plant), waves, settings, spectrum)
    energy = energies(System.of(plant), motion)
    assert stride == 1
    assert unbalanced(energy) < 1e-9 * energy["pto"][-1]


@pytest.mark.parametrize("modulus", [1e10, 1e12, 1e15])
def test_stiff_shells_cost_no_digits_of_the_audit(scene, modulus):
    for damping in ({"alpha": 0.0, "beta": 1e-3}, {"alpha": 0.0, "beta": 0.0}):
        plant, waves, settings, spectrum = scene(device={"young_modulus": modulus, "damping": damping})
        assert residual(energies(System.of(plant), simulate(System.of(plant), waves, settings, spectrum)[0])) < 1e-10


@settings(max_examples=25)
@given(st.integers(1, 4), st.integers(1, 6), st.floats(-2.0, 4.0), st.floats(-2.0, 1.0), st.integers(0, 10**6))
def test_any_passive_scene_is_balanced(dof, order, damping, step, seed):
    """Random masses, springs, dampers of any strength and memory, records any distance apart."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(4, dof, dof))
    mass, stiffness, pto, structural = (root @ root.T / dof for root in roots)
    skew, channel = rng.normal(size=(order, order)), rng.normal(size=order)
    memory = RadiationModel(skew - skew.T - 0.5 * np.outer(channel, channel), rng.normal(size=(order, dof)), channel)
    forces = {
        "hydrostatic": Spring(5 * stiffness),
        "pto": Damper(10.0**damping * pto),
        "structural_damping": Damper(0.1 * structural),
        "radiation": RadiationMemory(memory),
    }
    plant = Scene(tuple("abcd"[:dof]), mass + np.eye(dof), forces, np.eye(dof))
    motion = propagate(System.of(plant), 10.0**step * np.arange(60), tuple(rng.normal(size=(2, dof))))
    assert residual(energies(System.of(plant), motion)) < 1e-10


# what the audit sees ------------------------------------------------------------------------------------------------


def scaled(force, by):
    """A force by so much stronger."""
    if isinstance(force, Spring):
        return Spring(by * force.stiffness)
    if isinstance(force, Damper):
        return Damper(by * force.damping)
    if isinstance(force, Excitation):
        return Excitation(force.omega, by * force.phasors)
    return RadiationMemory(replace(force.model, input_matrix=by * force.model.input_matrix))


@pytest.mark.parametrize(
    "name", ["hydrostatic", "radiation", "pto", "elastic", "structural_damping", "excitation", "mass", "channel"]
)
def test_one_part_in_ten_thousand_of_any_force_shows(scene, name):
    """The audit of a motion in a scene that differs from its own by 1e-4 in one force, in mass or in what radiates."""
    plant, waves, settings, spectrum = scene()
    motion, _, _ = simulate(System.of(plant), waves, settings, spectrum)
    if name == "mass":
        other = replace(plant, mass=1.0001 * plant.mass)
    elif name == "channel":
        model = plant.memory
        lost = np.outer(model.channel, model.channel) / 2
        model = replace(model, channel=1.0001 * model.channel, state_matrix=model.state_matrix - (1.0001**2 - 1) * lost)
        other = replace(plant, forces={**plant.forces, "radiation": RadiationMemory(model)})
    else:
        other = replace(plant, forces={**plant.forces, name: scaled(plant.forces[name], 1.0001)})
    sound = residual(energies(System.of(plant), motion))
    assert residual(energies(System.of(other), motion)) > 1e4 * sound
    assert residual(energies(System.of(other), motion)) > 1e-7


def test_a_record_off_by_a_millionth_shows(scene):
    plant, waves, settings, spectrum = scene()
    motion, _, _ = simulate(System.of(plant), waves, settings, spectrum)
    motion.velocity[2400] *= 1.0 + 1e-6
    assert residual(energies(System.of(plant), motion)) > 1e-8


def test_a_run_whose_audit_does_not_close_is_an_error(scene):
    """The memory pushes the buoy by a thousandth less than the buoy pushes it."""
    plant, waves, settings, spectrum = scene("FSB")
    system = System.of(plant)
    matrix, n = system.matrix.copy(), system.free
    matrix[n : 2 * n, 2 * n :] *= 0.999
    with pytest.raises(ConvergenceError, match=r"audit does not close.*of the energy is missing, needs 1e-06"):
        simulate(replace(system, matrix=matrix), waves, settings, spectrum)


# long runs ----------------------------------------------------------------------------------------------------------


def in_legs(plant, waves, settings, spectrum, longest):
    """A run in legs of so many instants: legs, and its motion and energies put together."""
    parts = list(legs(System.of(plant), waves, settings, spectrum, longest))
    first = [0] + [1] * (len(parts) - 1)
    position = np.concatenate([leg.motion.position[i:] for i, leg in zip(first, parts, strict=True)])
    energy = {
        term: np.concatenate([leg.energy[term][i:] for i, leg in zip(first, parts, strict=True)]) for term in TERMS
    }
    return parts, position, energy


@pytest.mark.parametrize("waves", [[{"kind": "regular", "amplitude": 0.179, "period": 2.5}],
                                   [{"kind": "jonswap", "hs": 1.0, "tp": 4.0}]])  # fmt: skip
@pytest.mark.parametrize("method", ["auto", "structure_preserving"])
def test_legs_of_a_run_are_the_run(scene, waves, method):
    """Memory of the waves included: without it every leg would start in calm water."""
    changes = {"duration": 20.0, "window": (10.0, 20.0), "method": method}
    plant, sea_, settings, spectrum = scene(waves=waves, simulation=changes)
    motion, _, _ = simulate(System.of(plant), sea_, settings, spectrum)
    energy = energies(System.of(plant), motion)
    parts, position, pieced = in_legs(plant, sea_, settings, spectrum, 300)
    assert len(parts) >= len(motion.time) // 300
    exact = 1e-11 if method == "auto" else settings.tolerance  # each leg chooses its own steps
    assert np.abs(position - motion.position).max() < exact * np.abs(motion.position).max()
    for term in TERMS:
        assert np.abs(pieced[term] - energy[term]).max() < max(exact, 1e-9) * energy["pto"][-1], term
    assert parts[-1].balance.residual < 1e-6


def test_legs_of_a_body_exact_run_are_the_run():
    """The assumed pressure goes on where the leg before it ended."""
    changes = {"duration": 10.0, "window": (5.0, 10.0), "tolerance": 1e-9}
    study = varied(load(PAPER), simulation=changes, published=None)
    one = varied(study, designs={"FSB": study.designs["FSB"].model_dump()})
    plant = assumed_pressure_design(only_run(one), {})[0]
    motion, stride, _ = simulate(System.of(plant), NO_WAVES, one.simulation, None)
    parts, position, pieced = in_legs(plant, NO_WAVES, one.simulation, None, 190)
    assert len(parts) > 3
    begins = np.array([leg.motion.time[0] for leg in parts[1:]]) / one.waves[0].period
    assert np.all(np.abs(begins - np.rint(begins)) > 0.1)  # in whole periods a leg is not told from the first
    assert {leg.stride for leg in parts} == {stride}
    assert np.abs(position - motion.position).max() < 1e-8 * np.abs(motion.position).max()
    assert pieced["pto"][-1] == pytest.approx(energies(System.of(plant), motion)["pto"][-1], rel=1e-8)
    assert parts[-1].balance.residual < 1e-8


def test_a_leg_after_the_motion_has_died_out_is_balanced(scene):
    """What is left of a decay is round-off of the energy that went round before."""
    plant, waves, settings, spectrum = scene(
        "FSB", waves=[{"kind": "still"}], simulation={"duration": 400.0, "window": (0.0, 400.0)}
    )
    parts, _, _ = in_legs(plant, waves, settings, spectrum, 2000)
    assert len(parts) > 5
    assert np.abs(parts[-1].motion.position).max() < 1e-12 * np.abs(parts[0].motion.position).max()
    assert parts[-1].balance.residual < 1e-9


def test_a_longer_run_in_legs_takes_no_more_memory(scene):
    peaks = []
    for duration in (30.0, 120.0):
        plant, waves, settings, spectrum = scene(simulation={"duration": duration, "window": (0.0, duration)})
        tracemalloc.start()
        for _ in legs(System.of(plant), waves, settings, spectrum, 1000):
            pass
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


def test_a_long_run_records_a_part_and_its_extremes(scene, monkeypatch):
    plant, waves, settings, spectrum = scene()
    (whole,) = legs(System.of(plant), waves, settings, spectrum)
    full = recorded(System.of(plant), whole, waves, settings.window)
    monkeypatch.setattr(resolution, "KEPT", 1000)
    (leg,) = legs(System.of(plant), waves, settings, spectrum)
    run = recorded(System.of(plant), leg, waves, settings.window)
    assert leg.thinning == 5
    assert full.sizes["time"] // 5 < run.sizes["time"] < full.sizes["time"] // 5 + 50
    assert run.equals(full.sel(time=run.time))
    inside, all_inside = (one.sel(time=slice(*settings.window)) for one in (run, full))
    for name in ("position", "velocity"):
        assert float(np.ptp(inside[name].values, axis=0).min()) > 0
        assert np.array_equal(np.ptp(inside[name].values, axis=0), np.ptp(all_inside[name].values, axis=0)), name
    power = [float((-one.pto * one.velocity).sum("dof").max()) for one in (inside, all_inside)]
    assert power[0] == power[1]


def test_a_leg_followed_finer_than_recorded_records_what_was_asked_for(scene):
    plant, waves, settings, spectrum = scene()
    (leg,) = legs(System.of(plant), waves, settings, spectrum)
    whole = recorded(System.of(plant), leg, waves, settings.window)
    coarse = recorded(System.of(plant), leg._replace(stride=4), waves, settings.window)
    every = np.append(np.arange(0, whole.sizes["time"] - 1, 4), whole.sizes["time"] - 1)
    assert coarse.equals(whole.isel(time=every))


def test_a_run_of_a_day_keeps_a_tenth_of_its_instants():
    assert [resolution.thinning(n) for n in (1, 2**17, 2**17 + 1, 10**6, 10**9)] == [1, 1, 2, 8, 10]


# the other methods --------------------------------------------------------------------------------------------------


def test_the_audit_of_the_convolution_is_of_its_own_second_order(scene):
    plant, _, _, spectrum = scene("FSB")
    counts, found = np.array([200, 400, 800, 1600]), []
    for count in counts:
        motion = convolve(System.of(plant), spectrum, np.linspace(0.0, 10.0, count + 1), plant.start(0.0, -0.8))
        found.append(residual(energies(System.of(plant), motion)))
    slopes = -np.diff(np.log(found)) / np.diff(np.log(counts))
    assert np.all(np.abs(slopes - 2.0) < 0.3), (found, slopes)


@pytest.mark.parametrize("damping", [8e3, TRANSIENT])
def test_a_body_exact_run_needs_its_records_halved_twice_at_most(damping):
    """The paper's shell rings at up to 200 rad/s, its records are 12 ms apart."""
    short = {"duration": 10.0, "window": (5.0, 10.0)}
    study = varied(load(PAPER), pto={"damping": damping}, simulation=short, published=None)
    one = varied(study, designs={"VSWEC": study.designs["VSWEC"].model_dump()})
    plant = assumed_pressure_design(only_run(one), {})[0]
    motion, stride, _ = simulate(System.of(plant), NO_WAVES, one.simulation, None)
    assert residual(energies(System.of(plant), motion)) < 1e-6
    assert stride <= 4


# records of hand-made runs -------------------------------------------------------------------------------------------


def extremes(series, inside):
    return sorted(set(trajectory._extremes(np.array(series), np.array(inside)).tolist()))


def test_extremes_are_the_least_and_the_largest_of_each_column_among_the_rows_inside():
    series = [[9.0, -9.0], [1.0, 5.0], [3.0, 2.0], [-4.0, 2.5], [2.0, 1.0], [-9.0, 9.0]]
    inside = [False, True, True, True, True, False]
    assert extremes(series, inside) == [1, 2, 3, 4]
    assert extremes(series, [True] * 6) == [0, 5]
    assert extremes(series, [False] * 6) == []


def free_body(labels=("Surge", "Heave", "Pitch"), motions=((0.0, 0.0), (1.0, 0.0), (0.0, 2.0)), take_off="pto"):
    """Three motions of which a design may have two, and its forces; the take-off is in heave and pitch."""
    forces = {
        "hydrostatic": Spring(np.diag([1.0, 50.0, 30.0])),
        "pto": Damper(np.diag([0.5, 1.2, 0.7])),
        "structural_damping": Damper(np.diag([0.1, 0.2, 0.9])),
    }
    return System.of(Scene(labels, np.diag([1.0, 2.0, 3.0]), forces, np.array(motions), take_off=take_off))


def run_of(system, count=101, stride=1, thinning=1, begin=0.0):
    """A leg of a run whose motions, velocities and energies are numbers without any sense."""
    rng, time = np.random.default_rng(7), begin + 0.1 * np.arange(count)
    free, memory = system.scene.motions.shape[1], np.zeros((count, 0))
    motion = Motion(time, *(rng.normal(size=(count, free)) for _ in range(3)), memory, 0.0)
    energy = {term: rng.normal(size=count) for term in (*TERMS, "turned", "drag")}
    return Leg(motion, energy, START.after(energy), stride, thinning, "so", 3)


def test_a_record_holds_the_motions_a_design_has_and_its_forces_there():
    """All in plain coordinates; what no motion moves is left out where nothing deforms, as is what is no term."""
    system = free_body()
    leg = run_of(system)
    run = recorded(system, leg, None, (0.0, 0.0))
    q, v = leg.motion.position * [1.0, 2.0], leg.motion.velocity * [1.0, 2.0]
    assert run.dof.values.tolist() == ["Heave", "Pitch"]
    np.testing.assert_allclose(run.position.values, q)
    np.testing.assert_allclose(run.velocity.values, v)
    np.testing.assert_allclose(run.pto.values, -v * [1.2, 0.7])
    np.testing.assert_allclose(run.hydrostatic.values, -q * [50.0, 30.0])
    assert run.term.values.tolist() == ["wave", "pto", "radiated", "structural", "drag", "stored"]
    for term in run.term.values:
        np.testing.assert_array_equal(run.energy.sel(term=term).values, leg.energy[term])
    assert "elevation" not in run


def test_a_shell_that_deforms_has_all_its_modes_in_a_record():
    system = free_body(("Heave", "Membrane0", "Membrane1"), ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)))
    assert recorded(system, run_of(system), None, (0.0, 0.0)).dof.values.tolist() == list(system.scene.labels)


def test_the_last_instant_is_recorded_once_whether_it_is_in_step_or_not():
    system, waves = free_body(), Sea(np.array([2.0, 0.7]), np.array([0.1 + 0.2j, -0.3]))
    for count, kept in ((101, [0, 20, 40, 60, 80, 100]), (95, [0, 20, 40, 60, 80, 94])):
        leg = run_of(system, count, stride=20, begin=3.0)
        run = recorded(system, leg, waves, (0.0, 0.0))
        np.testing.assert_allclose(run.time.values, leg.motion.time[kept])
        np.testing.assert_allclose(run.elevation.values, waves.elevation(leg.motion.time)[kept])
        np.testing.assert_array_equal(run.energy.sel(term="pto").values, leg.energy["pto"][kept])


@pytest.mark.parametrize("take_off", ["pto", "structural_damping", "none"])
def test_of_a_long_run_instants_are_kept_at_which_a_motion_or_what_is_taken_is_extreme(take_off):
    """Least or largest, of each motion, each velocity and the power of the take-off in all motions, in the window."""
    system = free_body(take_off=take_off)
    leg, rates = run_of(system, stride=5, thinning=4), {"pto": [1.2, 0.7], "structural_damping": [0.2, 0.9]}
    run = recorded(system, leg, None, (2.0, 7.0))
    time = leg.motion.time
    (inside,) = np.nonzero((time > 1.999) & (time < 7.001))
    q, v = leg.motion.position[inside], leg.motion.velocity[inside]
    watched = [*q.T, *v.T]
    if take_off in rates:
        watched.append((v**2 * [1.0, 4.0]) @ rates[take_off])
    rows = {inside[i] for column in watched for i in (column.argmin(), column.argmax())}
    np.testing.assert_allclose(run.time.values, time[sorted({*range(0, 100, 20), 100, *rows})])


@pytest.mark.parametrize(("window", "kept"), [((0.5, 2.0), {5, 20}), ((0.55, 1.95), {6, 19})])
def test_the_instants_a_window_begins_and_ends_at_are_of_it(window, kept):
    """A motion that only rises is extreme at both."""
    system = free_body()
    leg = run_of(system, stride=10, thinning=10)
    rising = np.outer(leg.motion.time + 0.01, [1.0, 1.0])
    leg = leg._replace(motion=replace(leg.motion, position=rising, velocity=rising))
    run = recorded(system, leg, None, window)
    np.testing.assert_allclose(run.time.values, 0.1 * np.array(sorted({0, 100} | kept)))


def test_a_leg_ends_with_its_last_position_velocity_and_memory():
    leg = run_of(free_body())
    ends = leg.motion.position[-1], leg.motion.velocity[-1], leg.motion.memory[-1]
    for found, expected in zip(leg.end, ends, strict=True):
        np.testing.assert_array_equal(found, expected)
