"""Content ids: a key changes the ids of the results that depend on it and of no other."""

import pytest
from conftest import SEED, varied

from vsb.study.plan import StudyPlan
from vsb.study.specs import PHYSICS
from vsb.study.study import content_id, load

SWELL, SEA = {"kind": "regular", "amplitude": 0.1, "period": 3.0}, {"kind": "jonswap", "hs": 0.2, "tp": 3.5}
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 30.0}}


@pytest.fixture(scope="module")
def study():
    return varied(load(SEED), waves=[SWELL, SEA], designs=DESIGNS)


def ids(study):
    """Ids of the results of a study; runs are those of the first sea."""
    plan, wave = StudyPlan(study), study.waves[0]
    return {
        "blocks": [content_id(block) for block in plan.sweep_blocks],
        "database": content_id(plan.database),
        "radiation": content_id(plan.radiation),
        "witness": plan.witness and content_id(plan.witness),
        "modes": content_id(plan.modes),
        "response": plan.response_id,
        "ladder": plan.ladder_id,
        "runs": [plan.trajectory_id(design, wave) for design in ("FSB", "VSWEC")],
        "report": plan.study_id,
    }


def changed(before, after):
    return {name for name in before if before[name] != after[name]}


MOTION = {"response", "ladder", "runs", "report"}
WATER = {"database", "radiation", *MOTION}
SHELL = {"modes", *WATER}
ALL = {"blocks", "witness", *SHELL}


@pytest.mark.parametrize(
    ("changes", "renamed"),
    [
        ({"water": {"density": 1000.0}}, ALL),
        ({"water": {"depth": 30.0}}, ALL),
        ({"device": {"mass": 17000.0}}, ALL),
        ({"modes": {"degree": 5}}, ALL),
        ({"reference_shape": "equilibrium"}, ALL),
        ({"device": {"thickness": 0.02}}, ALL - {"blocks"}),  # the second solver meshes deformed shells
        ({"modes": {"basis": "full"}}, ALL - {"blocks"}),
        ({"device": {"young_modulus": 2e7}}, SHELL),
        ({"device": {"damping": {"alpha": 1.0}}}, SHELL),
        ({"device": {"internal_pressure": 1e3}}, SHELL),
        ({"hydro": {"omega_max": 13.0}}, {"blocks", *WATER}),
        ({"hydro": {"tolerance": 1e-4}}, {"blocks", *WATER}),
        ({"hydro": {"omega": [2.0]}}, WATER),
        ({"hydro": {"accept": ["rank_one"]}}, WATER),
        ({"hydro": {"witness": "none"}}, {"witness", "report"}),
        ({"hydro": {"model": "body_exact"}}, {"runs", "report"}),
        ({"pto": {"damping": 1.0}}, MOTION),
        ({"pto": {"force_limit": 1e3}}, MOTION),
        ({"waves": [{**SWELL, "period": 4.0}, SEA]}, MOTION),
        ({"drag": {"heave": {"coefficient": 0.5, "area": 3.0}}}, MOTION - {"response"}),
        ({"simulation": {"duration": 100.0}}, MOTION - {"response"}),
        ({"simulation": {"method": "exact"}}, {"runs", "report"}),
        ({"waves": [SWELL, {**SEA, "seed": 2}]}, {"ladder", "report"}),  # runs of the other sea stay
        ({"designs": {**DESIGNS, "VSWEC0": {"clamp": 45.0}}}, {"modes", *MOTION} - {"runs"}),  # of the other designs
        ({"published": {"source": "a paper", "values": {"FSB": {"power_mean": 1.0}}}}, {"report"}),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_key_changes_the_ids_of_the_results_that_depend_on_it(study, changes, renamed):
    assert changed(ids(study), ids(varied(study, **changes))) == renamed


@pytest.mark.parametrize(
    ("tag", "renamed"),
    [
        ("block", {"blocks", *WATER}), ("database", WATER), ("radiation", {"radiation", "runs", "report"}),
        ("response", {"response", "report"}), ("ladder", {"ladder", "report"}), ("simulate", {"runs", "report"}),
        ("witness", {"witness", "report"}), ("compare", {"report"}), ("member", set()),
    ],
)  # fmt: skip
def test_version_of_the_physics_is_part_of_the_ids(study, monkeypatch, tag, renamed):
    before = ids(study)
    monkeypatch.setitem(PHYSICS, tag, PHYSICS[tag] + 1)
    assert changed(before, ids(study)) == renamed
