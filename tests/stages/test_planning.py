"""The degree of the shell modes is found before the plan, kept, and stands in the ids."""

import json
from pathlib import Path

import pytest
import yaml
from conftest import EXAMPLE, varied

import vsb
from vsb.stages.planning import _checksum, degree_lines, degree_spec, extremes, plan_of, with_degree
from vsb.study.plan import StudyPlan
from vsb.study.sections import DEGREES
from vsb.study.study import content_id, load

TOLERANT = {"basis": "full", "degree": None, "tolerance": 0.005}


@pytest.fixture(scope="module")
def asked():
    """The example in one wave, modes by a tolerance."""
    return varied(load(EXAMPLE), modes=TOLERANT, designs={"FSB": {"flexible": False}, "VSWEC": {}})


@pytest.fixture(scope="module")
def planned(asked, tmp_path_factory):
    return with_degree(StudyPlan(asked, root=str(tmp_path_factory.mktemp("results"))))


def kept(plan):
    (path,) = Path(plan.root, "hydro", "degrees").iterdir()
    return path


def test_a_degree_given_stays_and_nothing_is_looked_for(asked, tmp_path):
    plan = StudyPlan(varied(asked, modes={"basis": "full", "degree": 5}), root=str(tmp_path))
    assert with_degree(plan) is plan
    assert not list(tmp_path.iterdir())


def test_a_tolerance_becomes_a_degree_of_the_list_and_is_kept(asked, planned):
    assert planned.study.modes.degree in DEGREES
    assert planned.study.modes.tolerance == 0.005
    assert json.loads(kept(planned).read_text())["degree"] == planned.study.modes.degree


def test_what_is_kept_is_not_looked_for_again_and_what_is_damaged_is(asked, planned):
    path, right = kept(planned), kept(planned).read_text()
    again = StudyPlan(asked, root=planned.root)
    checksum = _checksum(content_id(degree_spec(asked)), 42)
    path.write_text(json.dumps({**json.loads(right), "degree": 42, "checksum": checksum}))
    assert with_degree(again).study.modes.degree == 42
    for damaged in (
        right[:20],
        json.dumps({**json.loads(right), "degree": 60}),
        json.dumps({**json.loads(right), "degree": "none"}),
    ):
        path.write_text(damaged)
        assert with_degree(again).study.modes == planned.study.modes
        assert json.loads(path.read_text()) == json.loads(right)


def test_the_degree_stands_in_the_ids_and_a_change_of_waves_solves_nothing_again(asked, planned):
    other = varied(asked, waves=[{"kind": "regular", "amplitude": 0.1, "period": 6.0}])
    there = with_degree(StudyPlan(other, root=planned.root))
    assert there.study.modes.degree == planned.study.modes.degree
    assert content_id(there.database) == content_id(planned.database)
    richer = StudyPlan(varied(asked, modes={"basis": "full", "degree": 20}), root=planned.root)
    assert content_id(richer.database) != content_id(planned.database)


def test_a_tolerance_changes_what_is_looked_for_but_no_stage_of_the_same_degree(asked):
    rough, fine = (StudyPlan(varied(asked, modes={**TOLERANT, "tolerance": t})) for t in (0.02, 0.001))
    assert content_id(degree_spec(rough.study)) != content_id(degree_spec(fine.study))
    rough, fine = (
        StudyPlan(varied(asked, modes={"basis": "full", "degree": 9, "tolerance": t})) for t in (0.02, 0.001)
    )
    assert content_id(rough.database) == content_id(fine.database)
    assert content_id(rough.ladder) != content_id(fine.ladder)  # whose check knows it


def test_rigid_designs_alone_need_no_modes(asked, tmp_path):
    rigid = varied(asked, designs={"FSB": {"flexible": False}})
    assert with_degree(StudyPlan(rigid, root=str(tmp_path))).study.modes.degree == DEGREES[0]
    assert not list(tmp_path.iterdir())


def test_in_still_water_regular_waves_stand_for_seas(asked, tmp_path):
    still = varied(asked, waves=[{"kind": "still"}])
    assert with_degree(StudyPlan(still, root=str(tmp_path))).study.modes.degree in DEGREES


def test_extremes_are_the_ends_of_every_key_and_all_words():
    points = [{"a": a, "b": b, "c": c} for a in (2.0, 1.0, 3.0) for b in (5.0,) for c in ("x", "y")]
    found = extremes(points)
    assert {point["a"] for point in found} >= {1.0, 3.0}
    assert {point["c"] for point in found} == {"x", "y"}
    assert len(found) <= 4
    assert extremes([{}]) == [{}]


def test_a_campaign_has_the_degree_of_its_thinnest_shell_and_one_that_gives_way_counts_not(
    asked, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "buoy.yaml").write_text(yaml.safe_dump(asked.model_dump(exclude_none=True)))
    (tmp_path / "site.csv").write_text("Hs/Te, 5, 6\n0.75, 5, 8\n1.25, 4, 10\n")
    given = {"campaign": "site", "study": "buoy.yaml", "climate": {"scatter": "site.csv"}, "tuning": ["one"]}

    def degree(vary):
        (tmp_path / "site.yaml").write_text(yaml.safe_dump({**given, "vary": vary}))
        return plan_of("site.yaml").loaded.base.modes.degree

    thick, thin = degree({"device.thickness": [0.03]}), degree({"device.thickness": [0.008]})
    assert thin >= thick
    assert degree({"device.thickness": [0.03, 0.008]}) == max(thick, thin)
    assert degree({"device.internal_pressure": [0.0]}) == DEGREES[0]  # vented, without equilibrium


def test_results_of_a_study_as_it_is_in_its_file_are_those_of_its_degree(asked, planned):
    assert vsb.Results(asked, planned.root).plan.study.modes == planned.study.modes


def test_check_says_whether_a_given_degree_meets_the_tolerance(asked, planned):
    needed = planned.study.modes.degree

    def line(**modes):
        (only,) = degree_lines(StudyPlan(varied(asked, modes=modes), root=planned.root))
        return only

    assert line(basis="full", degree=needed).startswith("ok ")
    assert f"needs the full basis to degree {needed}" in line(basis="full", degree=needed - 1)
    assert line(basis="membrane", degree=90).startswith("doubt")
