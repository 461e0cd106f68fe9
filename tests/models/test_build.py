"""The scene of one design in one sea, from the files of a finished study."""

from contextlib import nullcontext

import numpy as np
import pytest
from conftest import SEED, only_run, varied

from benchmarks.hard_cases import hydro_files
from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import legs, simulate
from vsb.engine.integrators.switching import Switching, periodic_power
from vsb.engine.motion.constrained import constrained_optimum
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.forces import Damper, Excitation, Spring, TakeOff
from vsb.engine.motion.port import Port
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import Sea
from vsb.errors import DatabaseError
from vsb.models.build import (
    KNOWN_BODY_EXACT,
    NEAR,
    SCENES,
    STEADY,
    Memory,
    best_damper_and_time,
    best_latching_time,
    body_exact_latching_time,
    check_followed,
    linear_latching_time,
    windowed_power,
    with_latching_time,
)
from vsb.models.floating_system import floating_system
from vsb.models.rest import design_motions
from vsb.pipeline.graph import StudyPlan
from vsb.study import study as config


def built(plan, design, **changes):
    study = varied(plan.study, **changes)
    one = StudyPlan(study).simulation(design, study.waves[0]).spec["run"]
    return SCENES[study.hydro.model](one, dict(plan.hydro_files))


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_scene_has_the_motions_and_the_sea_of_its_design(small, design, model):
    found = built(small, design, hydro={"model": model})
    motions = floating_system(small.study, small.database.out).motions
    np.testing.assert_array_equal(found.scene.motions, motions[design])
    assert found.scene.flexible == small.study.designs[design].flexible
    assert found.scene.linear["pto"].damping[0, 0] == small.study.pto.damping
    assert found.sea.omega.tolist() == [small.study.waves[0].omega]
    assert found.notes["model"] == model
    assert (found.scene.water is not None) == (model == "body_exact")
    assert found.system.free == found.scene.motions.shape[1]
    assert found.spectrum.kernel(np.array([0.0])).shape == (1, *found.scene.mass.shape)


def test_assumed_pressure_needs_no_coefficients(small):
    found = built(small, "VSWEC", hydro={"model": "assumed_pressure", "pressure": 1800.0, "omega_max": 12.0})
    assert found.spectrum is None
    assert found.scene.memory is None
    assert found.sea.omega.size == 0
    assert found.scene.water.assumed.amplitude == 1800.0
    assert found.scene.water.assumed.omega == small.study.waves[0].omega


def test_still_water_has_no_assumed_pressure(small):
    still = {
        "hydro": {"model": "assumed_pressure", "pressure": 1800.0, "omega_max": 12.0},
        "waves": [{"kind": "still"}],
    }
    found = built(small, "VSWEC", **still)
    assert (found.scene.water.assumed.amplitude, found.scene.water.assumed.omega) == (0.0, 0.0)


def test_latching_on_an_immobile_port_has_no_effect(small):
    found = built(small, "FSB", pto={"port": "volume", "law": "latching"})
    assert found.scene.law is None
    assert found.notes == {"model": "linear"}


def assumed(seed, design="VSWEC", **changes):
    """The scene of one design under an assumed pressure, and of its study."""
    hydro = {"model": "assumed_pressure", "pressure": 1800.0, "omega_max": 12.0}
    study = varied(seed, hydro=hydro, designs={design: seed.designs[design].model_dump()}, **changes)
    return SCENES["assumed_pressure"](only_run(study), {})


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC90"])
def test_assumed_pressure_with_damper_and_spring_of_the_design(seed, design):
    dampers = {"FSB": 7e3, "VSWEC": 8e3, "VSWEC90": 9e3}
    found = assumed(
        seed, design, pto={"damping": {design: dampers[design]}, "stiffness": 2e4}, water={"density": 1010.0}
    )
    pto = found.scene.linear["pto"]
    assert (pto.damping[0, 0], pto.stiffness[0, 0]) == (dampers[design], 2e4)
    assert found.scene.water.specific_weight == pytest.approx(1010.0 * 9.81)
    assert found.shape.centre_height != 0.0
    assert not found.shape.modal_amplitude.any()
    np.testing.assert_array_equal(found.scene.motions, design_motions(seed, found.shape.basis, design))
    assert found.notes == {"model": "assumed_pressure"}


def test_assumed_pressure_with_force_and_stroke_limits(seed):
    found = assumed(seed, "FSB", pto={"stiffness": 2e4, "law": "saturated", "force_limit": 3e3, "stroke_limit": 0.2})
    law = found.scene.law
    assert (law.damping, law.stiffness, law.limit) == (8e3, 2e4, 3e3)
    assert found.scene.stop.stroke == 0.2
    assert law.rest == found.scene.stop.rest == pytest.approx(float(found.scene.rest[0]))


def test_a_sea_may_not_have_its_waves_where_the_memory_does_not_follow():
    memory = Memory(RadiationModel(np.array([[-0.5]]), np.ones((1, 1)), np.ones(1)), np.eye(1), up_to=2.0)
    for high, refused in ((1e-4, False), (2e-3, True)):
        waves = Sea(np.array([1.0, 3.0]), np.sqrt([1.0, high]).astype(complex))
        with (
            pytest.raises(DatabaseError, match=r"up to 2 rad/s, but 0\.2 % of the variance of sea")
            if refused
            else nullcontext()
        ):
            check_followed(memory, waves, "sea")


B, MASS, SPRING, LOSS = np.ones(1), 2.0, 50.0, 0.6
SETTINGS = Simulation(duration=60.0, window=(20.0, 60.0), initial_position=0.0, initial_velocity=0.0)
IRREGULAR = Sea(np.array([1.6, 1.9, 2.3]), np.array([0.3, 0.5 + 0.4j, -0.3j]))


def scene(law, sea):
    """2 y'' + 0.6 y' + 50 y = 30 times the elevation + take-off: natural frequency 5 rad/s."""
    waves = {"excitation": Excitation(sea.omega, 30.0 * sea.amplitude[:, None])} if sea.omega.size else {}
    forces = {"hydrostatic": Spring(np.array([[SPRING]])), "structural_damping": Damper(np.array([[LOSS]]))}
    return Scene(("Heave",), np.array([[MASS]]), {**forces, "pto": law, **waves}, np.eye(1))


def regular(omega):
    return Sea(np.array([omega]), np.array([1.0 + 0j]))


def impedance(omega):
    return LOSS + 1j * (SPRING / omega - omega * MASS)


def matched(sea):
    return float(np.sum(np.abs(30.0 * sea.amplitude) ** 2) / (8 * LOSS))


def passive(sea, damping):
    """Mean power of dampers, shape (damper,)."""
    per_component = (
        0.5 * damping[:, None] * np.abs(30.0 * sea.amplitude / (impedance(sea.omega) + damping[:, None])) ** 2
    )
    return per_component.sum(axis=1)


@pytest.fixture(scope="module", autouse=True)
def coarse():
    """Fewer latching times tried: these powers have one maximum, and a flat one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vsb.models.build.SCANNED", 8)
        patch.setattr("vsb.models.build.KNOWN", 0.01)
        yield


@pytest.fixture(scope="module")
def latched(coarse):
    """Latching in a regular wave far below resonance, its best latching time."""
    law, sea = TakeOff(B, 2.0, latching_time=0.0, latching_damping=np.inf), regular(2.0)
    return scene(law, sea), sea, linear_latching_time(scene(law, sea), sea, SETTINGS)


def test_latching_beats_the_optimal_damper_and_stays_below_the_force_bound(latched):
    """The optimal latching time is about half the wave period less half the natural period."""
    held, sea, best = latched
    assert best.time == pytest.approx(np.pi / 2 - np.pi / 5, rel=0.12)
    assert 5 * passive(sea, np.abs(impedance(sea.omega)))[0] < best.power < matched(sea)
    system = System.of(with_latching_time(held, best.time))
    motion, _ = Switching(system).follow(np.linspace(0.0, 80 * np.pi, 80 * 64 + 1), (np.zeros(1), np.zeros(1)))
    taken = (motion.works["pto"][-1] - motion.works["pto"][-641]) / (10 * np.pi)
    assert best.power == pytest.approx(taken, rel=2 * STEADY)
    force, stroke = (np.abs(x[-641:]).max() for x in (motion.forces["pto"], motion.position))
    harmonics = Harmonics(2.0, 1.0, 15)
    admittance = 1 / impedance(harmonics.port_omega)
    port = Port(harmonics.port_omega, admittance, 30.0 * admittance, 1 / SPRING)
    allowed = constrained_optimum(harmonics, port, np.eye(15)[0], Limits(force, stroke))
    assert best.power <= allowed.bound < matched(sea)


def test_no_other_latching_time_absorbs_more(latched):
    held, _, best = latched
    for latching_time in (0.9, 0.98):
        assert periodic_power(System.of(with_latching_time(held, latching_time)), STEADY)[0] <= best.power * (
            1 + 2 * STEADY
        )


@pytest.mark.slow
def test_latching_in_an_irregular_sea_beats_every_damper():
    law = TakeOff(B, 2.0, latching_time=0.0)
    best = linear_latching_time(scene(law, IRREGULAR), IRREGULAR, SETTINGS)
    assert 1.5 * passive(IRREGULAR, np.geomspace(0.1, 100.0, 200)).max() < best.power < matched(IRREGULAR)
    system = System.of(with_latching_time(scene(law, IRREGULAR), best.time))
    motion, *_ = simulate(system, IRREGULAR, SETTINGS, None)
    taken = np.interp(SETTINGS.window, motion.time, motion.works["pto"])
    assert best.power == pytest.approx(np.diff(taken)[0] / 40.0, rel=1e-9)
    parts = [windowed_power(system, IRREGULAR, SETTINGS.model_copy(update={"window": w})) for w in ((20, 45), (45, 60))]
    assert 25 * parts[0] + 15 * parts[1] == pytest.approx(40 * best.power, rel=1e-9)


@pytest.mark.parametrize("top", [(0.3, 0.2), (2.0, 0.71), (40.0, 0.97)])
def test_optimal_damper_and_latching_time_on_a_tilted_ridge(top):
    tried = []

    def power(damper, latching_time):
        u, v = np.log(damper / top[0]), latching_time - top[1]
        tried.append(9.0 - u**2 - 40 * v**2 - 4 * u * v)
        return tried[-1]

    damper, best = best_damper_and_time(power, [0.2, 3.0, 45.0], 1.0)
    assert best.power == max(tried)
    assert best.power == pytest.approx(9.0, abs=0.03)
    assert best.time == pytest.approx(top[1], abs=0.05)
    assert damper == pytest.approx(top[0], rel=0.2)


def test_latching_time_is_refined(latched):
    held, sea, best = latched
    off = best._replace(time=best.time - 0.8 * NEAR * np.pi / 2)
    refined = body_exact_latching_time(held, off, sea, SETTINGS)
    assert refined.time == pytest.approx(best.time, abs=0.04 * np.pi / 2)
    assert refined.power == pytest.approx(best.power, rel=0.02)
    assert refined.within == KNOWN_BODY_EXACT * np.pi / 2
    assert 0.0 <= body_exact_latching_time(held, best._replace(time=0.0), sea, SETTINGS).time <= NEAR * np.pi / 2


def test_declutching_helps_a_damper_that_is_too_strong():
    law, sea = TakeOff(B, 60.0, latching_time=1.1, latching_damping=0.0), regular(2.0)
    assert periodic_power(System.of(scene(law, sea)), STEADY)[0] > 1.4 * passive(sea, np.array([60.0]))[0]


@pytest.mark.parametrize("top", [0.0, 0.37, 0.7311, 1.0])
def test_maximum_is_found_within_the_stated_tolerance(top):
    best = best_latching_time(lambda latching_time: 5.0 - (latching_time - top) ** 2, 1.0)
    assert best.time == pytest.approx(top, abs=0.01)
    assert best.within == 0.01
    steps = best_latching_time(lambda latching_time: float(latching_time >= 0.95), 1.0)
    assert (steps.time, steps.power) == (1.0, 1.0)


@pytest.mark.slow
def test_study_with_latching_reports_its_optimal_time(tmp_path_factory, monkeypatch):
    monkeypatch.setattr("vsb.models.build.KNOWN_BODY_EXACT", 0.03)
    monkeypatch.setattr("vsb.models.build.SCANNED", 4)
    monkeypatch.setattr("vsb.models.build.KNOWN", 0.1)
    monkeypatch.setattr("vsb.engine.integrators.switching.MOST", 16)
    study = varied(
        config.load(SEED),
        designs={"FSB": {"flexible": False}},
        hydro={"model": "body_exact", "omega_max": 4.5, "tolerance": 1e-2},
        pto={"damping": 8000.0, "law": "latching", "force_limit": 5e4},
        waves=[{"kind": "regular", "amplitude": 0.1, "period": 5.0}],
        simulation={"initial_velocity": 0.0},
    )
    files = hydro_files(study, tmp_path_factory.getbasetemp() / "latching")
    design = SCENES["body_exact"](only_run(study), files)
    assert 0.5 < design.notes["latching_time"] < 1.5
    assert design.scene.forces["pto"].latching_time == design.notes["latching_time"]
    assert design.notes["latching_time_within"] == pytest.approx(0.075)
    assert design.notes["latching_time_searched"] == 2.5 * NEAR
    assert abs(design.notes["latching_time"] - design.notes["linear_latching_time"]) < 2.5 * NEAR
    parts = list(legs(design.system, design.sea, study.simulation, None))
    assert max(part.balance.residual for part in parts) < 1e-6
    absorbed = np.diff(np.interp([50.0, 60.0], parts[-1].motion.time, parts[-1].energy["pto"]))[0] / 10.0
    assert absorbed == pytest.approx(design.notes["latching_power"], rel=0.05)


def test_tuned_damper_is_found_together_with_its_latching_time(tmp_path_factory, monkeypatch):
    """Lighter than the optimal damper alone, and it absorbs more."""
    monkeypatch.setattr("vsb.models.build.PAIRED", 2)
    monkeypatch.setattr("vsb.models.build.KNOWN", 0.1)
    monkeypatch.setattr("vsb.models.build.ROUNDS", 1)
    monkeypatch.setattr("vsb.engine.integrators.switching.MOST", 16)
    study = varied(
        config.load(SEED),
        designs={"FSB": {"flexible": False}},
        hydro={"omega_max": 4.5, "tolerance": 1e-2},
        pto={"damping": None, "tuning": "each", "law": "latching"},
        waves=[{"kind": "regular", "amplitude": 0.1, "period": 5.0}],
    )
    files = hydro_files(study, tmp_path_factory.getbasetemp() / "latching")
    design = SCENES["linear"](only_run(study), files)
    law = design.scene.forces["pto"]
    alone = SCENES["linear"](only_run(varied(study, pto={"law": "linear"})), files).notes["tuned_damping"]
    assert law.damping == design.notes["tuned_damping"] < 0.5 * alone
    assert law.latching_time == design.notes["latching_time"] > 0.5
    assert (
        design.notes["latching_power"]
        > 1.5 * periodic_power(System.of(with_latching_time(design.scene, 0.0, alone)))[0]
    )
