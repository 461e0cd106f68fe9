"""The drag of a study file: absent where it is not asked for, refused where it cannot be followed."""

import pytest
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study.drag import Drag
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, load

PLATE = {"heave": {"coefficient": 0.5, "area": 12.57}}


@pytest.fixture(scope="module")
def seed():
    return load(SEED)


def test_what_has_no_drag_says_nothing_of_it(seed):
    assert '"drag"' not in canonical(seed)
    assert '"drag":{"heave":{"area":12.57,"coefficient":0.5}}' in canonical(varied(seed, drag=PLATE))


def test_drag_concerns_runs_ladder_and_study_alone(seed):
    before, after = StudyPlan(seed), StudyPlan(varied(seed, drag=PLATE))
    wave = seed.waves[0]
    assert before.hydro_ids == after.hydro_ids
    assert before.response_id == after.response_id
    assert before.trajectory_id("FSB", wave) != after.trajectory_id("FSB", wave)
    assert before.ladder_id != after.ladder_id
    assert before.study_id != after.study_id


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        ({"hydro": {"model": "auto"}}, "drag: hydro.model 'auto' knows none; needs linear or body_exact"),
        (
            {"pto": {"force_limit": 1e3}},
            "drag: cannot be followed beside a take-off that switches, received law linear with force_limit 1000 N and "
            "stroke_limit inf m; needs law: linear without limits",
        ),
        (
            {"pto": {"law": "saturated", "stroke_limit": 0.5, "force_limit": 2e3}},
            "received law saturated with force_limit 2000 N and stroke_limit 0.5 m; needs law: linear without limits",
        ),
        (
            {"hydro": {"model": "assumed_pressure", "pressure": 9.0}},
            "drag: hydro.model 'assumed_pressure' knows none; needs linear or body_exact",
        ),
        ({"simulation": {"method": "exact"}}, "simulation.method 'exact': cannot follow a drag; needs auto"),
        (
            {"simulation": {"method": "exponential"}, "hydro": {"model": "body_exact"}},
            "method 'exponential': cannot follow a drag",
        ),
        (
            {"simulation": {"method": "structure_preserving"}},
            "method 'structure_preserving': cannot follow a drag; needs auto",
        ),
        ({"drag": {"heave": {"coefficient": -1.0, "area": 1.0}}}, "drag.heave.coefficient"),
        ({"drag": {"heave": {"coefficient": 1e3, "area": 1.0}}}, "needs at most 100"),
        ({"drag": {"heave": {"coefficient": 1.0}}}, "drag.heave.area"),
        ({"drag": {"pitch": {"coefficient": 1.0, "area": 1.0}}}, "drag.pitch.lever"),
        ({"drag": {"heave": PLATE["heave"] | {"lever": 1.0}}}, "drag.heave.lever"),
        ({"drag": {"heave": None}}, "drag.*needs one of surge, sway, heave, roll, pitch, yaw"),
    ],
)
def test_refused_in_one_line(seed, sections, message):
    with pytest.raises(ConfigError, match=message):
        varied(seed, **{"drag": PLATE, **sections})


def test_a_drag_is_followed_by_the_models_that_know_it_and_no_law_that_pauses(seed):
    for model in ("linear", "body_exact"):
        assert varied(seed, drag=PLATE, hydro={"model": model}).drag.directions.keys() == {"heave"}
    with pytest.raises(ConfigError, match="take-off that switches, received law latching with force_limit inf N"):
        varied(seed, drag=PLATE, pto={"law": "latching"})


def test_a_drag_acts_on_the_directions_it_is_given_for():
    plate = {"coefficient": 1.0, "area": 2.0}
    for name in Drag.LATER:
        own = plate | ({"lever": 3.0} if name in ("roll", "pitch", "yaw") else {})
        assert {key: one.model_dump() for key, one in Drag(**{name: own}).directions.items()} == {name: own}
