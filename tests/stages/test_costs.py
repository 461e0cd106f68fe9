"""Estimated CPU time and memory: measured runs of shipped files, what is left of a run, and campaigns about an equilibrium."""

from dataclasses import replace

import psutil
import pytest
import yaml
from conftest import EXAMPLE, shipped, varied
from stages.test_members import with_seas

from vsb.stages import costs
from vsb.study.jobs import jobs
from vsb.study.plan import StudyPlan
from vsb.study.plans import plan_of
from vsb.study.study import load

MEASURED = {"buoy": 60.0}
"""CPU-seconds of `vsb run` on a machine that does nothing else, 55 to 64."""


def seconds(plan):
    """The estimate, by its parts."""
    left = costs.due(jobs(plan), plan.products)
    return costs.WORKFLOW_SECONDS + sum(costs.JOB_SECONDS + costs.task_seconds(plan, job) for job in left)


@pytest.mark.parametrize("name", MEASURED)
def test_estimate_is_within_a_factor_of_two_of_a_measured_run(name, tmp_path):
    study = load(shipped(name))
    plan = StudyPlan(varied(study, modes={"degree": study.modes.degree or 9}), root=str(tmp_path))
    assert MEASURED[name] / 2 < seconds(plan) < 2 * MEASURED[name]
    assert costs.cost_line(plan).startswith("cost         16 of 16 jobs to do: about ")


def test_what_is_there_costs_nothing(tmp_path):
    """A run that was killed goes on: only jobs whose files are missing are counted."""
    plan = StudyPlan(varied(load(EXAMPLE), modes={"degree": 9}), root=str(tmp_path))
    before = seconds(plan)
    for job in jobs(plan):
        if job.stage in ("spectral", "witness", "deformed"):
            for path in job.makes:
                (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
                (tmp_path / path).touch()
    assert seconds(plan) < before - 10
    assert "13 of 16 jobs" in costs.cost_line(plan)


def test_points_about_their_own_equilibrium_cost_their_shape_and_rest(tmp_path):
    """Measured about 1.6 s of each; a point that shares the undeformed shape takes a hundredth of that."""
    with_seas(tmp_path, (1.0, 6.0), (2.2, 9.0))
    raw = yaml.safe_load(EXAMPLE.read_text()) | {"study": "shell", "modes": {"degree": 9}}
    given = {"campaign": "many", "study": "shell.yaml", "climate": {"spectra": "sea.txt"}}
    found = {}
    for shape in ("equilibrium", "undeformed"):
        for count in (10, 20):
            (tmp_path / "shell.yaml").write_text(yaml.safe_dump({**raw, "reference_shape": shape}))
            vary = {"device.young_modulus": {"log": [1e7, 1e8, count]}}
            (tmp_path / "many.yaml").write_text(yaml.safe_dump({**given, "vary": vary}))
            plan = replace(plan_of(str(tmp_path / "many.yaml")), root=str(tmp_path / "results"))
            members = [job for job in jobs(plan) if job.stage == "members"]
            found[shape, count] = sum(costs.task_seconds(plan, job) for job in members)
    assert found["equilibrium", 20] - found["equilibrium", 10] == pytest.approx(10 * 1.6, rel=0.1)
    assert found["undeformed", 20] - found["undeformed", 10] == pytest.approx(10 * 0.016)


def test_a_job_that_fills_the_memory_is_doubted():
    """22 GB on a machine of 23 GB end in the system's killer, not in a result."""
    there = psutil.virtual_memory().total / 1e9
    assert costs.memory_doubts(0.5 * there) == []
    (line,) = costs.memory_doubts(0.95 * there)
    assert line.startswith("doubt        memory: a frequency needs about")


@pytest.mark.parametrize(("value", "words"), [(7.31, "7.3 s"), (89.0, "89 s"), (250.0, "4.2 min"), (9000.0, "2.5 h")])
def test_seconds_are_as_precise_as_the_estimate(value, words):
    assert costs.plain_seconds(value) == words
