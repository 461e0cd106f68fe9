"""Law and limits of the take-off in a study file."""

import pytest
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study.study import canonical, load
from vsb.study.take_off import Pto


@pytest.fixture(scope="module")
def seed():
    return load(SEED)


def test_a_take_off_of_before_keeps_its_canonical_form(seed):
    """Keys at their default are not there: results of before keep their names."""
    assert canonical(seed.pto) == '{"damping":8000.0}'
    assert not seed.pto.switches


@pytest.mark.parametrize(
    ("keys", "form"),
    [
        ({"force_limit": 3e3}, '{"damping":8000.0,"force_limit":3000.0}'),
        ({"stroke_limit": 0.5}, '{"damping":8000.0,"stroke_limit":0.5}'),
        ({"law": "coulomb", "force_limit": 3e3}, '{"damping":8000.0,"force_limit":3000.0,"law":"coulomb"}'),
    ],
)
def test_a_law_is_part_of_the_canonical_form_and_comes_back(seed, keys, form):
    study = varied(seed, pto=keys)
    assert canonical(study.pto) == form
    assert Pto(**study.pto.model_dump()) == study.pto
    assert study.pto.switches


@pytest.mark.parametrize("law", ["saturated", "coulomb"])
def test_laws_of_a_limit_need_it(seed, law):
    with pytest.raises(ConfigError, match=f"pto: force_limit: missing; law {law} needs one in N"):
        varied(seed, pto={"law": law})


@pytest.mark.parametrize("keys", [{"force_limit": 0.0}, {"stroke_limit": -1.0}])
def test_limits_are_positive(seed, keys):
    (key,) = keys
    with pytest.raises(ConfigError, match=f"pto.{key}: received .*greater than 0"):
        varied(seed, pto=keys)


@pytest.mark.parametrize("model", ["body_exact", "auto"])
def test_a_model_that_cannot_follow_a_law_is_refused(seed, model):
    wrong = (
        f"pto: received law saturated with force_limit 3000 N and stroke_limit inf m, which hydro.model '{model}' "
        "cannot follow; needs hydro.model: linear, or law: linear without limits"
    )
    with pytest.raises(ConfigError, match=wrong):
        varied(seed, pto={"law": "saturated", "force_limit": 3e3}, hydro={"model": model})


def test_a_method_that_cannot_follow_a_law_is_refused(seed):
    with pytest.raises(
        ConfigError, match=r"simulation.method .exact.: cannot follow a take-off that switches; needs a"
    ):
        varied(seed, pto={"stroke_limit": 0.5}, simulation={"method": "exact"})
