"""Stages: the same names and files as the rules of the workflow; specifications and stamps."""

import json
import re

import pytest
from conftest import EXAMPLE, SEED

from vsb.errors import ConfigError
from vsb.stages.stage import STAGES, stamp
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, load

RULES = {
    name: text
    for path in sorted((EXAMPLE.parent.parent / "workflow" / "rules").glob("*.smk"))
    for name, text in re.findall(r"^rule (\w+):\n((?:    .*\n|\n)*)", path.read_text(encoding="utf-8"), re.MULTILINE)
}
BY_NAME = {stage.name: stage for stage in STAGES}


def test_every_rule_calls_the_command_of_its_name_with_its_files():
    assert set(RULES) == set(BY_NAME)
    for stage in STAGES:
        command = "".join(re.findall(r'"(.*)"', RULES[stage.name].partition("shell:")[2]))
        assert command.startswith(f"vsb {stage.name} ")
        assert set(re.findall(r"--(\w+) ", command)) == set(stage.files), stage.name
        assert ("{params.hydro}" in command) == bool(stage.optional), stage.name
        specified = re.search(r" <<< \{params.spec:q\} | < \{input.study\} ", command)
        assert bool(stage.spec) == bool(specified), stage.name


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
