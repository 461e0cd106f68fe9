"""Jobs of a study outside Snakemake: they make every product once and in order, and only what is missing or stale."""

import shlex
from dataclasses import replace

import pytest
from conftest import SEED, shipped, varied

from vsb.cli import parser
from vsb.stages.stage import STAGES
from vsb.study import study as config
from vsb.study.jobs import Job, due, jobs
from vsb.study.plan import StudyPlan
from vsb.study.plans import plan_of

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


def test_jobs_make_all_products_once_and_in_order(plan):
    made = []
    for job in jobs(plan):
        assert set(job.needs) <= set(made), job.stage
        made += job.makes
    assert len(made) == len(set(made))
    assert set(plan.products) <= set(made)
    assert set(made) - set(plan.ids) <= {f"{plan.green_folder}.done"}


def test_jobs_of_a_campaign_make_all_its_products_in_order():
    given = plan_of(str(shipped("when_it_pays")))
    modes = given.loaded.base.modes.model_copy(update={"degree": 6})  # else looked for
    plan = replace(given, loaded=given.loaded.model_copy(update={"base": varied(given.loaded.base, modes=modes)}))
    stages = {stage.name: stage for stage in STAGES}
    made = [plan.loaded.climate_path]
    for job in jobs(plan):
        assert set(job.needs) <= set(made), job.stage
        assert set(job.files) == set(stages[job.stage].files), job.stage
        made += job.makes
    assert set(plan.products) <= set(made)


def test_command_of_a_job_reads_paths_that_begin_with_a_dash():
    """A climate named -clim.csv or a hull -hull.stl was taken for an option."""
    job = Job("design_start", None, {"climate": "-clim of a site.csv", "out": "--out.nc"}, ("--out.nc",))
    read = parser().parse_args([job.stage, *shlex.split(job.options)])
    assert (read.climate, read.out) == ("-clim of a site.csv", "--out.nc")


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
def test_job_is_due_if_any_wanted_file_is_missing_or_stale(tmp_path, there, stale, wanted, named):
    """The first job makes a and b, from which the last makes c."""
    a, b, c = (str(tmp_path / name) for name in "abc")
    ordered = [Job("first", None, {}, (a, b)), Job("last", None, {}, (c,), (b, a))]
    for name in there:
        (tmp_path / name).touch()
    found = due(ordered, [str(tmp_path / name) for name in wanted], [str(tmp_path / name) for name in stale])
    assert [job.stage for job in found] == named


def test_jobs_depend_on_all_files_they_read(plan):
    """Files given one by one, and those in folders that are named by its specification."""
    made = {path for job in jobs(plan) for path in job.makes}
    for job in jobs(plan):
        read = {path for path in job.files.values() if path in made} - set(job.makes)
        assert read <= set(job.needs), job.stage
    needs = {job.stage: set(job.needs) for job in jobs(plan)}
    drawn = {path for job in jobs(plan) if job.stage == "figures" for path in job.makes}
    assert drawn <= needs["report"]
    if plan.study.needs_bem:
        assert needs["database"] == {plan.block_path(block) for block in plan.bem_blocks.values()}
        for stage in ("radiation", "response", "ladder"):
            assert needs[stage] == {plan.database_path}, stage
    for job in jobs(plan):
        if job.stage == "panels":
            assert f"{plan.green_folder}.done" in job.needs
