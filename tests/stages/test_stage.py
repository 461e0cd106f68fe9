"""Stages: the same names and files as the rules of the workflow; specifications and stamps."""

import json

import pytest
from conftest import SEED

from vsb.errors import ConfigError
from vsb.stages.stage import STAGES, stamp
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, load

BY_NAME = {stage.name: stage for stage in STAGES}


def test_wrong_specification_is_one_line():
    spec = json.loads(canonical(StudyPlan(load(SEED)).radiation))
    with pytest.raises(ConfigError, match=r"^standard input: tolerance: received 'x'; needs a number"):
        BY_NAME["radiation"].read(canonical({**spec, "tolerance": "x"}))
    with pytest.raises(ConfigError, match=r"^standard input: not valid JSON \(maximum recursion depth"):
        BY_NAME["radiation"].read("[" * 100_000)


def test_stamp_depends_on_specification_and_source_files():
    plan = StudyPlan(load(SEED))
    ids = [
        stamp(plan.radiation, *files)["spec_id"]
        for files in ((), ("a/one.nc",), ("b/one.nc", ""), ("one.nc", "two.nc"))
    ]
    assert ids[1] == ids[2]
    assert len(set(ids)) == 3
    assert stamp(plan.response, "a/one.nc")["spec_id"] != ids[1]
