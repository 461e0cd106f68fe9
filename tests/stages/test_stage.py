"""Rule, stage, command and file have one name, and their files the same names."""

import importlib
import inspect
import json
import re

import pytest
from conftest import EXAMPLE, SEED, shipped, varied

from vsb.errors import ConfigError
from vsb.stages.inputs import Inputs
from vsb.stages.stage import STAGES, stamp
from vsb.study.body import KINDS
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, load

RULES = {
    name: text
    for path in sorted((EXAMPLE.parent.parent / "workflow" / "rules").glob("*.smk"))
    for name, text in re.findall(r"^rule (\w+):\n((?:    .*\n|\n)*)", path.read_text(encoding="utf-8"), re.MULTILINE)
}
BY_NAME = {stage.name: stage for stage in STAGES}


def test_every_rule_is_a_stage_and_every_stage_a_rule():
    assert set(RULES) == set(BY_NAME)


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_a_rule_calls_the_command_of_its_name_with_its_files(stage):
    command = "".join(re.findall(r'"(.*)"', RULES[stage.name].partition("shell:")[2]))
    assert command.startswith(f"vsb {stage.name} ")
    said = set(re.findall(r"--(\w+) ", command))
    assert said == set(stage.files)
    assert ("{params.hydro}" in command) == bool(stage.optional)
    assert bool(stage.spec) == bool(re.search(r" <<< \{params.spec:q\} | < \{input.study\} ", command))


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_a_file_of_the_name_runs_it(stage):
    module = importlib.import_module(f"vsb.stages.{stage.name}")
    parameters = list(inspect.signature(module.run).parameters.values())[bool(stage.spec) :]
    own = {one.name for one in parameters if one.kind is not one.VAR_KEYWORD}
    handed_on = re.findall(r"files\[['\"](\w+)['\"]\]", inspect.getsource(module)) if len(own) < len(parameters) else []
    if "Inputs(" in inspect.getsource(module):
        handed_on += re.findall(r'self\.path\("(\w+)"\)', inspect.getsource(Inputs))
    if "files[spec.body.kind]" in inspect.getsource(module):
        handed_on += KINDS
    assert own <= {*stage.files, *stage.optional}
    assert {*stage.files, *stage.optional} - own <= {*handed_on}


def specifications(study):
    """What is said to the stages of a study, by name."""
    plan = StudyPlan(study)
    found = {
        "modes": plan.modes,
        "display": plan.display,
        "compare": plan.comparison,
        "figures": study,
        "report": study,
    }
    found["simulate"] = plan.simulation(next(iter(study.designs)), study.waves[0])
    if not study.needs_bem:
        return found
    found |= {"database": plan.database, "radiation": plan.radiation, "response": plan.response}
    found |= {"deformed": plan.witness.meshes, "witness": plan.witness}
    block = plan.sweep_blocks[0]
    return found | ({"panels": block, "mesh": block.mesh} if study.uses_panels else {"spectral": block})


@pytest.mark.parametrize("name", ["seed", "paper", "pressurised", "automatic"])
@pytest.mark.parametrize("solver", ["auto", "panels"])
def test_what_a_plan_says_a_stage_reads(name, solver):
    study = load(shipped(name))
    if study.needs_bem:
        study = varied(study, hydro={"solver": solver})
    for stage, spec in specifications(study).items():
        text = canonical(spec)
        assert canonical(BY_NAME[stage].read(text)) == text


def test_a_wrong_specification_is_one_line():
    spec = json.loads(canonical(StudyPlan(load(SEED)).radiation))
    with pytest.raises(ConfigError, match=r"^standard input: tolerance: received 'x'; needs a number"):
        BY_NAME["radiation"].read(canonical({**spec, "tolerance": "x"}))
    with pytest.raises(ConfigError, match=r"^standard input: not valid JSON \(maximum recursion depth"):
        BY_NAME["radiation"].read("[" * 100_000)


@pytest.mark.parametrize("more", [{}, {"added_mass_inf": "given"}], ids=["buoy", "body"])
def test_a_mistake_is_told_of_the_type_it_is_nearest_to(more):
    """A radiation model is of a buoy, or of a body, which says one thing more."""
    spec = {"database": "0" * 16, "tolerance": "x", **more}
    with pytest.raises(ConfigError) as error:
        BY_NAME["radiation"].read(json.dumps(spec))
    assert str(error.value).startswith("standard input: tolerance: received 'x'; needs a number")
    assert "added_mass_inf" not in str(error.value)


def test_a_stage_without_specification_reads_none(monkeypatch, tmp_path):
    """The Green-function table depends on no study: nothing stands on its standard input."""
    seen = []
    monkeypatch.setattr("vsb.stages.green.stored_green_function", seen.append)
    (green,) = (stage for stage in STAGES if stage.name == "green")
    green.run({"folder": "table", "out": str(tmp_path / "table.done")}, "")
    assert seen == ["table"]
    assert (tmp_path / "table.done").read_text().endswith(" s\n")


def test_a_stamp_is_of_the_specification_and_of_the_files_it_was_made_of():
    plan = StudyPlan(load(SEED))
    ids = [
        stamp(plan.radiation, *files)["spec_id"]
        for files in ((), ("a/one.nc",), ("b/one.nc", ""), ("one.nc", "two.nc"))
    ]
    assert ids[1] == ids[2]
    assert len(set(ids)) == 3
    assert stamp(plan.response, "a/one.nc")["spec_id"] != ids[1]


@pytest.mark.parametrize("text", ["[1, 2, 3]", '"x"', "3", "null", "[" + 30 * "1, " + "1]"])
def test_what_is_no_mapping_is_told_by_its_beginning(text):
    line = f"standard input: received {text[:40]}, needs a mapping"
    with pytest.raises(ConfigError, match=f"^{re.escape(line)}$"):
        BY_NAME["radiation"].read(text)


def test_a_stage_hands_on_all_its_files_those_that_are_absent_as_nothing(monkeypatch):
    """And its specification, read; options of other stages are none of its own."""
    plan, asked = StudyPlan(load(SEED)), []
    spec = plan.simulation("FSB", plan.study.waves[0])
    monkeypatch.setattr("vsb.stages.simulate.run", lambda *given, **named: asked.append((given, named)))
    files = {"out": "o.nc", "database": "d.nc", "radiation": None, "folder": "elsewhere"}
    BY_NAME["simulate"].run(files, canonical(spec))
    assert asked == [((spec,), {"out": "o.nc", "database": "d.nc", "radiation": ""})]
