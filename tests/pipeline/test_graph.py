"""Tasks of studies: files, ids and what they depend on; jobs."""

import inspect
import json
import re
from dataclasses import replace
from operator import attrgetter
from typing import get_args

import pytest
import yaml
from conftest import EXAMPLE, SEED, shipped, varied

from vsb.engine.shell.device import Basis
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical, content_id
from vsb.pipeline.graph import BodyPlan, StudyPlan, Task, due
from vsb.pipeline.jobs import BATCH_SECONDS, jobs, rules
from vsb.pipeline.plans import plan_of, planned
from vsb.stages.stage import function_of, read_of
from vsb.study import study as config
from vsb.study.body import LocatedBody, located
from vsb.study.resolution import block_id
from vsb.study.specs import PHYSICS
from vsb.study.study import load

STUDIES = {
    "spectral": {},
    "without witness": {"hydro": {"witness": "none"}},
    "panels": {"hydro": {"rows": 16, "omega_max": 5.0, "omega": (1.0, 2.0)}},
    "shallow": {"water": {"depth": 2.02}},
    "assumed pressure": {"hydro": {"model": "assumed_pressure", "pressure": 1800.0}},
}


@pytest.fixture(params=STUDIES)
def plan(request, tmp_path):
    return StudyPlan(varied(config.load(SEED), **STUDIES[request.param]), root=str(tmp_path))


@pytest.mark.parametrize("steps", [lambda plan: plan.tasks, jobs])
def test_all_products_are_made_once_and_in_order(plan, steps):
    made = []
    for step in steps(plan):
        assert set(step.needs) <= set(made), step
        made += step.makes
    assert len(made) == len(set(made))
    assert set(plan.products) <= set(made)
    assert set(made) - set(plan.file_ids) <= {f"{plan.green.out}"}


def test_jobs_of_a_campaign_make_all_its_products_in_order():
    given = plan_of(str(shipped("when_it_pays")))
    modes = given.loaded.base.modes.model_copy(update={"degree": 6})  # else looked for
    plan = replace(given, loaded=given.loaded.model_copy(update={"base": varied(given.loaded.base, modes=modes)}))
    made = [plan.loaded.climate_path]
    for job in jobs(plan):
        assert set(job.needs) <= set(made), job.rule
        made += job.makes
    assert set(plan.products) <= set(made)


def test_functions_of_stages_take_the_files_of_their_tasks(plan):
    for task in plan.tasks:
        run, text = inspect.signature(function_of(task.stage)), json.loads(canonical(task.spec))
        stamp = {"stamp": {}} if "stamp" in run.parameters else {}
        run.bind(**read_of(task.stage, text), **task.files, **stamp)


SEAS = tuple({"kind": "regular", "amplitude": 0.1, "period": 2.5 + 0.1 * i} for i in range(20))


@pytest.mark.parametrize(("duration", "together"), [(60.0, True), (6e4, False)])
def test_short_runs_share_jobs_of_ten_seconds_and_long_ones_have_their_own(tmp_path, duration, together):
    simulation = {"duration": duration, "window": (10.0, 40.0)}
    study = config.parse(
        config.load(SEED).model_dump(exclude_none=True)
        | {"waves": SEAS, "simulation": simulation, "hydro": {"model": "body_exact", "omega_max": 8.0}}
    )
    plan = StudyPlan(study, root=str(tmp_path))
    runs = [job for job in jobs(plan) if job.rule == "simulate"]
    assert sum(len(job.tasks) for job in runs) == len(SEAS) * len(study.designs)
    assert all((len(job.tasks) > 1) is together for job in runs)
    assert all(sum(task.seconds for task in job.tasks) >= BATCH_SECONDS for job in runs[:-1])
    names = [rule.name for rule in rules(plan) if rule.stem == "simulate"]
    assert names == ([f"simulate_{i}" for i in range(1, len(runs) + 1)] if together else ["simulate"])
    made = {path.format(job=name) for rule in rules(plan) for name in rule.jobs for path in rule.makes}
    assert set(plan.products) <= made


@pytest.mark.parametrize(
    ("there", "stale", "wanted", "named"),
    [
        ("abc", "", "abc", []),
        ("ac", "", "abc", ["first"]),
        ("bc", "", "abc", ["first"]),
        ("ac", "", "b", ["first"]),
        ("abc", "a", "abc", ["first"]),
        ("a", "", "c", ["first", "last"]),
        ("c", "", "c", []),
    ],
)
def test_task_is_due_if_any_wanted_file_is_missing_or_stale(tmp_path, there, stale, wanted, named):
    """The first task makes a and b, from which the last makes c."""
    a, b, c = (str(tmp_path / name) for name in "abc")
    ordered = [Task("first", None, {}, (a, b)), Task("last", None, {}, (c,), (b, a))]
    for name in there:
        (tmp_path / name).touch()
    found = due(ordered, [str(tmp_path / name) for name in wanted], [str(tmp_path / name) for name in stale])
    assert [task.stage for task in found] == named


def test_tasks_depend_on_all_files_they_read(plan):
    """Files given one by one, and those in folders that are named by its specification."""
    made = {path for task in plan.tasks for path in task.makes}
    for task in plan.tasks:
        read = {path for path in task.files.values() if path in made} - set(task.makes)
        assert read <= set(task.needs), task.stage
    needs = {task.stage: set(task.needs) for task in plan.tasks}
    drawn = {path for task in plan.tasks if task.stage == "figures" for path in task.makes}
    assert drawn <= needs["report"]
    if plan.study.needs_bem:
        assert needs["database"] == {plan.block_path(block) for block in plan.bem_blocks.values()}
        for stage in ("radiation", "response", "ladder"):
            assert needs[stage] == {plan.database.out}, stage
    for task in plan.tasks:
        if task.stage == "panels":
            assert f"{plan.green.out}" in task.needs


@pytest.fixture(scope="module")
def seed(seed):
    """The seed study by panels, whose plan has meshes and blocks."""
    return varied(seed, hydro={"solver": "panels"})


def block_ids(study):
    return {block_id(block) for block in StudyPlan(study).sweep_blocks + StudyPlan(study).tabulated_blocks}


def test_labels_are_those_of_the_basis(seed):
    from vsb.models.rest import study_basis

    for basis in get_args(Basis):
        study = varied(seed, modes={"basis": basis, "degree": 4})
        assert study_basis(study).labels[1:] == StudyPlan(study).mode_labels


def test_assumed_pressure_needs_no_bem(seed):
    plan = StudyPlan(varied(seed, hydro={"model": "assumed_pressure", "pressure": 100.0}))
    assert plan.bem_blocks == plan.hydro_files == {}
    assert not [path for path in plan.products if "/hydro/db" in path or "response" in path]
    assert plan.simulation("FSB", plan.study.waves[0]).spec["run"].study.hydro.pressure == 100.0


def rewritten(text):
    """The seed with comments gone, keys in reverse order and numbers spelled otherwise."""
    raw = yaml.safe_load(text)
    reversed_keys = {key: dict(reversed(v.items())) if key == "device" else v for key, v in reversed(raw.items())}
    return yaml.safe_dump(reversed_keys, sort_keys=False).replace("10000000.0", "1e7").replace("17170.0", "17170")


@pytest.mark.parametrize("rewrite", [rewritten, lambda text: f"# remark\n{text}# end\n"], ids=["respelled", "comments"])
def test_ids_do_not_depend_on_spelling(tmp_path, rewrite):
    file = tmp_path / "other.yaml"
    file.write_text(rewrite(SEED.read_text()))
    assert file.read_text() != SEED.read_text()
    ours, theirs = StudyPlan(config.load(SEED)), StudyPlan(config.load(file))
    for spec in ("database", "radiation", "display", "modes", "response", "compare"):
        assert getattr(theirs, spec).id == getattr(ours, spec).id
    assert block_ids(theirs.study) == block_ids(ours.study)


def test_memory_bounds_what_was_measured(seed):
    """Measured with the seed's free shell: 0.3 GB for 60 s, 0.6 GB for 16 000 s, 1.7 GB for 100 000 s."""
    asked = {}
    for duration in (60.0, 16e3, 1e5):
        plan = StudyPlan(varied(seed, simulation={"duration": duration, "window": (0.0, duration)}))
        asked[duration] = plan.simulation("VSWEC", plan.study.waves[0]).megabytes
    assert 600 < asked[60.0] < 1000
    assert 700 < asked[16e3] < 1400
    assert 1700 < asked[1e5] < 2 * 1700
    irregular = varied(seed, waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}], simulation={"duration": 1e5})
    assert 2900 < StudyPlan(irregular).simulation("VSWEC", irregular.waves[0]).megabytes < 2 * 2900


@pytest.mark.parametrize("solver", ["spectral", "panels"])
def test_every_file_has_the_id_of_what_it_is_made_from(solver):
    """Shared files carry it in their name or folder; tables, figures and report have the study's."""
    plan = StudyPlan(varied(load(SEED), hydro={"solver": solver}), root="r")
    stages = {plan.response.out: plan.response.id}
    stages |= {f"{plan.folder}/modes.nc": plan.modes.id}
    stages |= {f"{plan.folder}/ladder.{kind}": plan.ladder.id for kind in ("csv", "json")}
    runs = {
        plan.simulation(design, wave).out: plan.simulation(design, wave).id
        for design in plan.study.designs
        for wave in plan.study.waves
    }
    assert len({plan.response.id, plan.ladder.id, plan.identity, *runs.values()}) == 3 + len(runs)
    for path, identity in plan.file_ids.items():
        if path in stages or path in runs:
            assert identity == (stages | runs)[path]
        elif plan.is_shared(path):
            *_, folder, file = path.split("/")
            assert re.fullmatch("[0-9a-f]{16}", identity)
            assert file.startswith(f"{identity}.") or folder == identity
        else:
            assert identity == plan.identity
    assert plan.file_ids[plan.database.out] == plan.database.id
    assert {path for path in plan.file_ids if "/mesh/" in path}


@pytest.fixture(scope="module")
def pressurised():
    """A study about its equilibrium, whose shapes and meshes hold the shell."""
    return load(EXAMPLE.with_name("pressurised.yaml"))


@pytest.mark.parametrize("stage", ["modes", "compare", "radiation"])
def test_specification_of_another_stage_or_version_is_refused(seed, stage):
    spec = json.loads(canonical(getattr(StudyPlan(seed), stage).spec))
    assert read_of(stage, spec).keys() == spec.keys() - {"stage", "physics"}
    for key, value in (("stage", "other"), ("physics", spec["physics"] + 1)):
        with pytest.raises(ConfigError, match=f"{key} .*: needs .*, of this version; run vsb run CONFIG again"):
            read_of(stage, {**spec, key: value})
    with pytest.raises(ConfigError, match="more: is nothing that"):
        read_of(stage, {**spec, "more": 1})


def test_part_of_a_study_holds_what_a_stage_reads_and_nothing_else(seed):
    """Also once read from its text."""
    spec = StudyPlan(seed).ladder.spec
    for one in (spec, read_of("ladder", json.loads(canonical(spec)))):
        assert canonical(one["study"]) == canonical(spec["study"])
        assert one["study"].pto == seed.pto
        assert one["study"].hydro.omega_max == seed.hydro.omega_max
        for absent in ("published", "hydro.tolerance"):
            with pytest.raises(AttributeError):
                attrgetter(absent)(one["study"])


def test_loaded_shape_depends_on_neither_damping_nor_depth(pressurised):
    shape = StudyPlan(pressurised).shape
    assert shape.at_equilibrium
    other = varied(pressurised, device={"damping": {"alpha": 1.0}}, water={"depth": 30.0})
    assert content_id(StudyPlan(other).shape) == content_id(shape)
    stiffer = varied(pressurised, device={"young_modulus": 2e7})
    assert content_id(StudyPlan(stiffer).shape) != content_id(shape)


SWELL, SEA = {"kind": "regular", "amplitude": 0.1, "period": 3.0}, {"kind": "jonswap", "hs": 0.2, "tp": 3.5}
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 30.0}}


@pytest.fixture(scope="module")
def study():
    return varied(load(SEED), waves=[SWELL, SEA], designs=DESIGNS)


def ids(study):
    """Ids of the results of a study; runs are those of the first sea."""
    plan, wave = StudyPlan(study), study.waves[0]
    return {
        "blocks": [block_id(block) for block in plan.sweep_blocks],
        "database": plan.database.id,
        "radiation": plan.radiation.id,
        "witness": plan.witness and plan.witness.id,
        "modes": plan.modes.id,
        "response": plan.response.id,
        "ladder": plan.ladder.id,
        "runs": [plan.simulation(design, wave).id for design in ("FSB", "VSWEC")],
        "report": plan.identity,
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


RAW = {
    "study": "raft",
    "body": {"database": "sha256:raft"},
    "designs": {"flexible": {}, "rigid": {"dofs": "rigid"}},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}, {"kind": "jonswap", "hs": 1.0, "tp": 7.0}],
}


def body_plan(**changes):
    found: LocatedBody = located({**RAW, **changes}, "raft.yaml")
    return BodyPlan(found.study, files=found.files)


OF_BODY = ("database", "radiation", "response", "ladder", "compare")


@pytest.mark.parametrize(
    ("changes", "renamed"),
    [
        ({"body": {"database": "sha256:other"}}, {"database", "compare"}),
        ({"body": {**RAW["body"], "mass": {"Heave": 1.0}}}, {"database", "compare"}),
        ({"hydro": {"omega_max": 2.0}}, {"database", "compare"}),
        ({"hydro": {"repair": ["kramers_kronig"]}}, {"database", "compare"}),
        ({"hydro": {"tolerance": 0.02}}, {"radiation", "compare"}),
        ({"hydro": {"added_mass_inf": "given"}}, {"radiation", "compare"}),
        ({"pto": {"damping": 1.0}}, {"response", "ladder", "compare"}),
        ({"pto": {"port": {"dof": "Pitch"}}}, {"response", "ladder", "compare"}),
        ({"simulation": {"duration": 90.0}}, {"ladder", "compare"}),
        ({"waves": [{**RAW["waves"][1], "seed": 2}, RAW["waves"][0]]}, {"ladder", "compare"}),
        ({"designs": {"flexible": {}, "rigid": {"dofs": ["Heave"]}}}, {"response", "ladder", "compare"}),
        ({"water": {"density": 1000.0}}, {"database", "response", "ladder", "compare"}),
    ],
)
def test_key_changes_the_ids_of_the_stages_that_read_it(changes, renamed):
    before, after = body_plan(), body_plan(**changes)
    found = {
        name for name in OF_BODY if content_id(getattr(before, name).spec) != content_id(getattr(after, name).spec)
    }
    assert found == renamed
    assert before.identity != after.identity


def test_mesh_is_solved_with_a_green_function_table(tmp_path):
    body = {"body": "raft", "mesh": "sha256:m", "modes": "sha256:d", "omega": [0.6, 0.9]}
    own = body_plan(body={"file": body})
    assert own.study.uses_panels
    assert own.inputs == [f"{own.green.out}"]
    assert own.sources == {"folder": "results/hydro/bodies", "green": own.green.files["folder"]}
    assert own.database.spec["versions"]["solver"].startswith("capytaine")
    assert own.highest == 0.9
    assert "versions" not in body_plan().database.spec
    (tmp_path / "raft.nc").write_text("numbers")
    read = planned({**RAW, "body": {"database": "raft.nc"}, "root": "out"}, str(tmp_path / "raft.yaml"))
    assert read.root == "out"
    assert [name.endswith("raft.nc") for name in read.inputs] == [True]
    assert read.inputs == list(read.sources.values())


def test_a_hull_in_place_of_a_study_is_told_how_to_get_one():
    with pytest.raises(ConfigError, match=r"cad/hull.STL: received a hull.* vsb init my.yaml --body .* mesh: hull.STL"):
        plan_of("cad/hull.STL")
