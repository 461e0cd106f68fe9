"""Specifications of the stages say what the study says."""

import json

import pytest
from conftest import EXAMPLE, varied
from pydantic import ValidationError

from vsb.study import specs
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, content_id, load


@pytest.fixture(scope="module")
def pressurised():
    """A study about its equilibrium, whose shapes and meshes hold the shell."""
    return load(EXAMPLE.with_name("pressurised.yaml"))


@pytest.mark.parametrize("kind", [specs.ModesSpec, specs.CompareSpec, specs.RadiationSpec])
def test_specification_of_another_stage_or_version_is_refused(seed, kind):
    plan = StudyPlan(seed)
    (spec,) = (one for one in (plan.modes, plan.comparison, plan.radiation) if isinstance(one, kind))
    raw = json.loads(canonical(spec))
    assert kind.model_validate(raw) == spec
    for key, value in (("stage", "other"), ("physics", spec.physics + 1)):
        with pytest.raises(ValidationError, match=f"{key} .*: needs .*, of this version; run vsb run CONFIG again"):
            kind.model_validate({**raw, key: value})
    with pytest.raises(ValidationError, match="Extra inputs"):
        kind.model_validate({**raw, "more": 1})


def test_simulated_member_is_its_study_in_still_water(seed):
    floats = specs.BuoySystem(**{name: part for name, part in seed if name in specs.BuoySystem.model_fields})
    parts = {"system": floats, "hydro": seed.hydro, "simulation": seed.simulation}
    climate = specs.ClimateSpec(contents="0" * 16, form="spectra")
    spec = specs.VerificationSpec(sweep=("a",), climate=climate, tuning=("one",), verify=specs.Verify(), **parts)
    read = specs.VerificationSpec.model_validate_json(canonical(spec))
    whole = varied(seed, waves=[{"kind": "still"}]).model_copy(update={"study": "member"})
    assert canonical(spec.simulated) == canonical(read.simulated) == canonical(whole)


def test_loaded_shape_depends_on_neither_damping_nor_depth(pressurised):
    shape = StudyPlan(pressurised).shape
    assert isinstance(shape, specs.LoadedShape)
    other = varied(pressurised, device={"damping": {"alpha": 1.0}}, water={"depth": 30.0})
    assert content_id(StudyPlan(other).shape) == content_id(shape)
    stiffer = varied(pressurised, device={"young_modulus": 2e7})
    assert content_id(StudyPlan(stiffer).shape) != content_id(shape)
