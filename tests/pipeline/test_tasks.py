"""Tasks and jobs make every product once and in order, and only what is missing or stale."""

import inspect
from dataclasses import replace

import pytest
from conftest import SEED, shipped, varied

from vsb.pipeline.graph import StudyPlan, Task, due
from vsb.pipeline.jobs import BATCH_SECONDS, jobs, rules
from vsb.pipeline.plans import plan_of
from vsb.stages.stage import function_of
from vsb.study import study as config

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
        arguments = [task.spec] if task.spec else []
        inspect.signature(function_of(task.stage)).bind(*arguments, **task.files)


SEAS = tuple({"kind": "regular", "amplitude": 0.1, "period": 2.5 + 0.1 * i} for i in range(20))


@pytest.mark.parametrize(("duration", "together"), [(60.0, True), (3e4, False)])
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
