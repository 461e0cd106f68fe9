"""The scene of one design in one sea, from the files of a finished study, by its model."""

from contextlib import nullcontext
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import only_run, varied

from vsb.errors import DatabaseError
from vsb.hydro.statespace import RadiationModel
from vsb.motion.bodies import Memory
from vsb.motion.forces import Damper, Spring
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.take_off import TakeOff
from vsb.scenes import build
from vsb.scenes.afloat import linear_buoy
from vsb.scenes.build import SCENES, _dampers, check_followed
from vsb.scenes.pause import NEAR, BestPause
from vsb.scenes.rest import design_motions
from vsb.study.body_specs import BodySimulateSpec
from vsb.study.plan import StudyPlan
from vsb.study.take_off import Pto
from vsb.study.waves import RegularWave
from vsb.waves.seas import Sea


def built(plan, design, **changes):
    study = varied(plan.study, **changes)
    one = StudyPlan(study).simulation(design, study.waves[0])
    return SCENES[one.hydro.model](one, dict(plan.hydro_files))


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_a_scene_moves_as_its_design_may_in_its_sea(small, design, model):
    found = built(small, design, hydro={"model": model})
    _, basis = linear_buoy(small.study, small.database_path)
    np.testing.assert_array_equal(found.scene.motions, design_motions(small.study, basis, design))
    assert found.scene.flexible == small.study.designs[design].flexible
    assert found.scene.linear["pto"].damping[0, 0] == small.study.pto.damping
    assert found.sea.omega.tolist() == [small.study.waves[0].omega]
    assert found.notes["model"] == model
    assert (found.scene.water is not None) == (model == "body_exact")
    assert found.system.free == found.scene.motions.shape[1]
    assert found.spectrum.kernel(np.array([0.0])).shape == (1, len(basis.labels), len(basis.labels))


def test_without_bem_there_is_no_sea_and_no_radiation(small):
    found = built(small, "VSWEC", hydro={"model": "assumed_pressure", "pressure": 1800.0, "omega_max": 12.0})
    assert found.spectrum is None
    assert found.scene.memory is None
    assert found.sea.omega.size == 0
    assert found.scene.water.assumed.amplitude == 1800.0
    assert found.scene.water.assumed.omega == small.study.waves[0].omega


def test_in_still_water_no_pressure_is_assumed(small):
    still = {
        "hydro": {"model": "assumed_pressure", "pressure": 1800.0, "omega_max": 12.0},
        "waves": [{"kind": "still"}],
    }
    found = built(small, "VSWEC", **still)
    assert (found.scene.water.assumed.amplitude, found.scene.water.assumed.omega) == (0.0, 0.0)


def test_a_take_off_that_pauses_where_nothing_moves_leaves_the_scene_as_it_is(small):
    """A rigid buoy at a port of the volume: no law, and no pause to be noted."""
    found = built(small, "FSB", pto={"port": "volume", "law": "latching"})
    assert found.scene.law is None
    assert found.notes == {"model": "linear"}


@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_in_still_water_a_take_off_does_not_pause(small, model):
    found = built(small, "FSB", pto={"law": "latching"}, waves=[{"kind": "still"}], hydro={"model": model})
    assert found.notes == {"model": model, "pause": 0.0, "pause_power": 0.0, "pause_within": 0.0}
    assert found.scene.law.pause == 0.0


@pytest.mark.parametrize(("given", "asked"), [({}, 0.01), ({"power_tolerance": 0.07}, 0.07)])
def test_the_automatic_model_is_chosen_to_the_tolerance_of_its_study(small, monkeypatch, given, asked):
    """A hundredth where none is given; what it chose is the scene of the run and noted, with the seconds it took."""
    tolerances = []
    choice = SimpleNamespace(scene="chosen", notes={"model": "rigid"})
    monkeypatch.setattr("vsb.scenes.automatic.chosen", lambda scenes, tolerance: tolerances.append(tolerance) or choice)
    found = built(small, "VSWEC", hydro={"model": "auto", **given})
    assert tolerances == [asked]
    assert (found.scene, found.notes["model"]) == ("chosen", "rigid")
    assert found.notes["choice_seconds"] >= 0.0


def test_files_of_another_study_are_refused(small):
    one = small.simulation("FSB", small.study.waves[0])
    swapped = {"database": small.radiation_path, "radiation": small.database_path}
    with pytest.raises(
        DatabaseError, match=r"radiation/\w+.nc: holds no hydro database; needs one of results/hydro/db"
    ):
        SCENES["linear"](one, swapped)


@pytest.mark.parametrize(
    ("resistance", "tried"), [(1.0, [80.0, 800.0, 8e3]), (2e3, [2e3, 4e3, 8e3]), (3.2e4, [8e3, 1.6e4, 3.2e4])]
)
def test_a_damper_that_pauses_is_sought_between_the_resistance_and_the_best_one_alone(resistance, tried):
    """No lower than a hundredth of the latter."""
    wave = Sea(np.array([1.5]), np.array([0.1 + 0j]))
    floating = SimpleNamespace(
        pto=SimpleNamespace(damping=8e3, direction=lambda dof: np.eye(dof)[0]),
        port=lambda omega, motions, direction: SimpleNamespace(impedance=np.array([resistance - 4e3j])),
    )
    assert _dampers(floating, np.eye(2), wave) == pytest.approx(tried)


def assumed(seed, design="VSWEC", **changes):
    """The scene of one design under an assumed pressure, and of its study."""
    hydro = {"model": "assumed_pressure", "pressure": 1800.0, "omega_max": 12.0}
    study = varied(seed, hydro=hydro, designs={design: seed.designs[design].model_dump()}, **changes)
    return SCENES["assumed_pressure"](only_run(study), {})


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC90"])
def test_an_assumed_pressure_acts_beside_the_damper_and_the_spring_of_its_own_design(seed, design):
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


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
@pytest.mark.parametrize("wave", [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 2.5}])
def test_a_pressure_is_assumed_in_waves_alone(seed, design, wave):
    still = wave["kind"] == "still"
    force = assumed(seed, design, waves=[wave]).scene.water.assumed
    assert (force.amplitude, force.omega) == ((0.0, 0.0) if still else (1800.0, pytest.approx(2 * np.pi / 2.5)))


def test_an_assumed_pressure_acts_beside_a_take_off_with_limits(seed):
    """From where the deformed shell rests."""
    found = assumed(seed, "FSB", pto={"stiffness": 2e4, "law": "saturated", "force_limit": 3e3, "stroke_limit": 0.2})
    law = found.scene.law
    assert (law.damping, law.stiffness, law.limit) == (8e3, 2e4, 3e3)
    assert found.scene.stop.stroke == 0.2
    assert law.rest == found.scene.stop.rest == pytest.approx(float(found.scene.rest[0]))


WAVE = Sea(np.array([1.5]), np.array([0.1 + 0j]))


def paused_scene(water=None):
    """A mass on a spring whose take-off pauses, perhaps on a wet shell."""
    forces = {"hydrostatic": Spring(np.eye(1)), "pto": TakeOff(np.ones(1), 5.0, 3.0, pause=0.0)}
    return Scene(("Heave",), np.eye(1), forces | ({"water": water} if water else {}), np.eye(1))


@pytest.mark.parametrize(("tuning", "tuned"), [("fixed", False), ("one", False), ("each", True)])
def test_only_a_damper_of_its_own_sea_is_found_with_its_pause(monkeypatch, tuning, tuned):
    """One for all seas stays what it is."""
    asked = []
    monkeypatch.setattr(build, "best_pause_in_sea", lambda *given: asked.append(given) or BestPause(0.4, 9.0, 0.1))
    monkeypatch.setattr(
        build, "best_pair_in_sea", lambda *given: asked.append(given) or (77.0, BestPause(0.5, 8.0, 0.2))
    )
    monkeypatch.setattr(build, "_dampers", lambda *given: given)
    run = SimpleNamespace(pto=SimpleNamespace(tuning=tuning), simulation="settings")
    floating = SimpleNamespace(pto=LinearPto(55.0))
    found = build._paused("linear", run, WAVE, floating, "motions")
    assert found == ((77.0, (0.5, 8.0, 0.2), {"tuned_damping": 77.0}) if tuned else (55.0, (0.4, 9.0, 0.1), {}))
    assert asked == [("linear", WAVE, "settings", *([(floating, "motions", WAVE)] if tuned else []))]


@pytest.mark.parametrize("wet", [False, True])
@pytest.mark.parametrize("calm", [False, True])
def test_a_pause_is_refined_on_the_wet_shell_with_the_damper_found_beside_it(monkeypatch, wet, calm):
    """In waves: from the linear scene's, which is noted with how far from it others were tried."""
    monkeypatch.setattr(Scene, "water", property(lambda scene: scene.forces.get("water")))
    monkeypatch.setattr(build, "_linear", lambda run, at: "linear")
    monkeypatch.setattr(
        build, "_paused", lambda *given: asked.append(given) or (77.0, BestPause(0.5, 8.0, 0.2), {"a": 1})
    )
    refined, asked = [], []
    monkeypatch.setattr(build, "refined_pause", lambda *given: refined.append(given) or BestPause(0.6, 7.0, 0.3))
    sea = Sea(np.zeros(0), np.zeros(0, dtype=complex)) if calm else WAVE
    at = SimpleNamespace(sea=sea, buoy="buoy", motions="motions")
    run = SimpleNamespace(pto=Pto(damping=5.0, law="latching"), simulation="settings")
    scene = paused_scene(Damper(np.zeros((1, 1))) if wet else None)
    released, notes = build._released(scene, run, at)
    assert asked == [("linear", run, sea, "buoy", "motions")]
    best = (0.6, 7.0, 0.3) if wet and not calm else (0.5, 8.0, 0.2)
    told = {"linear_pause": 0.5, "pause_tried": pytest.approx(NEAR * np.pi / 1.5)} if wet and not calm else {}
    assert notes == {"a": 1, **told, **dict(zip(("pause", "pause_power", "pause_within"), best, strict=True))}
    assert (released.law.pause, released.law.damping) == (best[0], 77.0)
    assert len(refined) == (wet and not calm)
    for begun, linear, waves, settings in refined:
        assert (begun.law.pause, begun.law.damping) == (0.5, 77.0)
        assert (linear, waves, settings) == ((0.5, 8.0, 0.2), sea, "settings")


@dataclass(frozen=True)
class Floating:
    """Stands for a buoy or a body."""

    labels: tuple[str, ...] = ("Heave", "Pitch")
    database: str = "database"
    pto: LinearPto | None = None
    direction: float = 0.0
    spectrum: str = "spectrum"


SEAS = [RegularWave(kind="regular", amplitude=0.1 * i, period=2.0 + i, direction=20.0 * i) for i in (1, 2, 3)]


@pytest.mark.parametrize("others", [(), SEAS[1:]])
@pytest.mark.parametrize("tuning", ["fixed", "one"])
def test_a_buoy_in_its_sea_has_a_damper_of_the_seas_named_or_of_its_own(monkeypatch, others, tuning):
    tuned, told = [], []
    for name, known in {
        "linear_buoy": lambda run, path: (Floating(), f"basis of {path}"),
        "radiation_model": lambda path: f"memory of {path}",
        "rest_shape": lambda *given: given[1:],
        "design_motions": lambda run, basis, design: (basis, design),
        "study_port": lambda run, buoy, basis: "port",
        "sea": lambda wave, highest, duration: (wave.label, highest, duration),
        "tuned_take_off": lambda *given: tuned.append(given) or LinearPto(66.0, 2.0),
        "linearised": lambda *given: told.append(given) or {"linear": 1.0},
    }.items():
        monkeypatch.setattr(build, name, known)
    run = SimpleNamespace(
        designs={"A": None}, waves=SEAS[:1], seas=others, pto=Pto(tuning=tuning, damping=4.0), drag=None,
        hydro=SimpleNamespace(omega_max=9.0), simulation=SimpleNamespace(duration=30.0),
    )  # fmt: skip
    at = build._from_bem(run, {"database": "db", "radiation": "rad"})
    here, *rest = ((wave, (wave.label, 9.0, 30.0)) for wave in (SEAS[0], *others))
    ((pto, design, floating, seas, drag),) = tuned
    assert (pto, design, seas, drag) == (run.pto, "A", rest or [here], None)
    assert (floating.motions, floating.port) == ({"A": ("basis of db", "A")}, "port")
    ((_, _, _, damper, wave, sea),) = told
    assert (damper.damping, wave, sea) == (66.0, *here)
    assert (at.radiation, at.sea, at.shape) == ("memory of rad", here[1], (Floating(), "basis of db"))
    assert at.buoy.direction == pytest.approx(np.deg2rad(20.0))
    assert (at.buoy.pto.damping, at.buoy.pto.stiffness) == (66.0, 2.0)
    assert at.notes == {"linear": 1.0} | ({} if tuning == "fixed" else {"tuned_damping": 66.0})
    assert at.with_scene("scene", {"a": 2}, {"linear": 3.0}).notes == {**at.notes, "a": 2, "linear": 3.0}


@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_drag_is_the_last_that_is_added_to_a_scene_and_what_it_is_told_is_of_its_own_sea(monkeypatch, model):
    """To the scene of the take-off, released; notes of take-off, pause and model."""
    at = build._FromBem(
        SimpleNamespace(pto="pto", spectrum="spectrum"), "shape", "radiation", "sea", "motions", {"a": 1}
    )
    monkeypatch.setattr(build, "_from_bem", lambda run, paths: at if paths == {"database": "db"} else None)
    monkeypatch.setattr(build, "linear_scene", lambda *given: ("linear", *given))
    monkeypatch.setattr(build, "body_exact_scene", lambda *given: ("body_exact", *given))
    monkeypatch.setattr(build, "with_take_off", lambda *given: ("take-off", *given))
    monkeypatch.setattr(build, "_released", lambda *given: (("released", *given), {"pause": 0.3}))
    monkeypatch.setattr(build, "with_drag", lambda *given: ("drag", *given))
    run = SimpleNamespace(pto="law", waves=("wave", "another"))
    found = SCENES[model](run, {"database": "db"})
    bare = {
        "linear": ("linear", at.buoy, "radiation", "sea", "motions"),
        "body_exact": ("body_exact", at.buoy, "shape", "radiation", "sea", "motions"),
    }[model]
    released = ("released", ("take-off", bare, "law", "pto"), run, at)
    assert found.scene == ("drag", released, run, "wave", "sea")
    assert (found.shape, found.sea, found.spectrum) == ("shape", "sea", "spectrum")
    assert found.notes == {"a": 1, "pause": 0.3, "model": model}


@pytest.mark.parametrize("drag", [None, "plate"])
def test_a_damper_is_tuned_beside_the_drag_of_its_own_run(monkeypatch, drag):
    tuned = []
    for name, known in {
        "linear_buoy": lambda run, path: (Floating(), "basis"),
        "radiation_model": lambda path: path,
        "rest_shape": lambda *given: "shape",
        "design_motions": lambda *given: "motions",
        "study_port": lambda *given: "port",
        "sea": lambda *given: "sea",
        "tuned_take_off": lambda *given: tuned.append(given) or LinearPto(66.0, 2.0),
        "linearised": lambda *given: {},
        "dragged_port": lambda *given: given,
    }.items():
        monkeypatch.setattr(build, name, known)
    run = SimpleNamespace(
        designs={"A": None}, waves=SEAS[:1], seas=(), pto=Pto(tuning="each"), drag=drag,
        hydro=SimpleNamespace(omega_max=9.0), simulation=SimpleNamespace(duration=30.0),
    )  # fmt: skip
    build._from_bem(run, {"database": "db", "radiation": "rad"})
    ((*_, dragged),) = tuned
    assert (dragged is None) if drag is None else (dragged("more") == (run, "more"))


@pytest.mark.parametrize(("given", "tolerance"), [(None, 0.01), (0.07, 0.07)])
def test_an_automatic_scene_is_chosen_among_all_of_its_design_in_its_sea(monkeypatch, given, tolerance):
    """To a hundredth if the study does not say; what was chosen, and how long it took, is noted."""
    asked, seconds = [], iter([10.0, 12.5])
    at = build._FromBem(
        SimpleNamespace(spectrum="spectrum"), SimpleNamespace(basis="basis"), "radiation", "sea", "motions", {"a": 1}
    )
    monkeypatch.setattr(build, "_from_bem", lambda run, paths: at if paths == {"database": "db"} else None)
    monkeypatch.setattr(build, "clock", SimpleNamespace(perf_counter=lambda: next(seconds)))
    monkeypatch.setattr(build.automatic, "motion_ladder", lambda *given: given)
    monkeypatch.setattr(build.automatic, "Scenes", lambda *given: given)
    choice = SimpleNamespace(scene="chosen", notes={"model": "linear", "power_error": 1e-3})
    monkeypatch.setattr(build.automatic, "chosen", lambda *given: asked.append(given) or choice)
    run = SimpleNamespace(designs={"A": None}, hydro=SimpleNamespace(power_tolerance=given), simulation="settings")
    found = SCENES["auto"](run, {"database": "db"})
    ladder = (run, "basis", "A")
    assert asked == [((at.buoy, at.shape, "radiation", "sea", ladder, "settings"), tolerance)]
    assert (found.scene, found.shape, found.sea, found.spectrum) == ("chosen", at.shape, "sea", "spectrum")
    assert found.notes == {"a": 1, "model": "linear", "power_error": 1e-3, "choice_seconds": 2.5}


@pytest.mark.parametrize("model", ["linear", "body_exact", "assumed_pressure", "auto"])
def test_a_run_of_a_buoy_is_by_its_model_and_one_of_a_body_by_its_own(monkeypatch, model):
    for name in SCENES:
        monkeypatch.setitem(SCENES, name, lambda *given, name=name: (name, *given))
    monkeypatch.setattr(build, "body_design", lambda *given: ("body", *given))
    run, body = SimpleNamespace(hydro=SimpleNamespace(model=model)), BodySimulateSpec.model_construct()
    assert build.design_in_sea(run, {"database": "db"}) == (model, run, {"database": "db"})
    assert build.design_in_sea(body, {"database": "db"}) == ("body", body, {"database": "db"})


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
