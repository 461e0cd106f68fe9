"""Stages: the same names and files as the rules of the workflow; specifications and stamps."""

from conftest import SEED

from vsb.pipeline.graph import StudyPlan
from vsb.stages.stage import stamp
from vsb.study.study import load


def test_stamp_depends_on_specification_and_source_files():
    plan = StudyPlan(load(SEED))
    ids = [
        stamp(plan.radiation.spec, *files)["spec_id"]
        for files in ((), ("a/one.nc",), ("b/one.nc", ""), ("one.nc", "two.nc"))
    ]
    assert ids[1] == ids[2]
    assert len(set(ids)) == 3
    assert stamp(plan.response.spec, "a/one.nc")["spec_id"] != ids[1]
