"""The scene of one design in one sea, from the files of a finished study."""

from contextlib import nullcontext

import numpy as np
import pytest
from conftest import only_run, varied

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.waves.seas import Sea
from vsb.errors import DatabaseError
from vsb.models.build import SCENES, Memory, check_followed
from vsb.models.floating_system import floating_system
from vsb.models.rest import design_motions
from vsb.pipeline.graph import StudyPlan


def built(plan, design, **changes):
    study = varied(plan.study, **changes)
    one = StudyPlan(study).simulation(design, study.waves[0]).spec
    return SCENES[one.hydro.model](one, dict(plan.hydro_files))


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
