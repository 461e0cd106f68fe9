"""The scene of one design in one sea, from the files of a finished study, by its model."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied

from vsb.errors import DatabaseError
from vsb.scenes.afloat import linear_buoy
from vsb.scenes.build import SCENES, _dampers
from vsb.scenes.rest import design_motions
from vsb.study.plan import StudyPlan
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
