"""Runs on Slurm, whose commands are replaced by scripts that note what they were asked."""

import os
import re

import pytest
import yaml

from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import plan_of
from vsb.stages import slurm
from vsb.stages.run import ended
from vsb.study.study import parse
from vsb.tools.commands import HOME

SEED = HOME / "tests" / "data" / "seed.yaml"
PROFILE = yaml.safe_load((HOME / "profiles" / "slurm" / "config.yaml").read_text())
QUEUE = """7 vsb-seed-31_aa
8 vsb-seed-312_bb
9 other
12 vsb-seed-31_cc d
13
14 \n"""


@pytest.fixture
def queue(tmp_path, monkeypatch):
    """A queue of six jobs, two without a name; cancelled jobs are written to a file."""
    for name, text in {"squeue": f"cat <<'E'\n{QUEUE}\nE", "scancel": f'echo "$@" > {tmp_path}/cancelled'}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    return tmp_path / "cancelled"


def test_only_the_jobs_of_the_run_are_cancelled(queue):
    assert slurm.cancel("vsb-seed-31") == 2
    assert queue.read_text() == "7 12\n"


def test_job_name_identifies_study_and_folder(queue, tmp_path, monkeypatch):
    plan = plan_of(str(SEED))
    name = slurm.run_name(plan)
    assert re.fullmatch(r"vsb-seed-[0-9a-f]{8}", name)
    assert slurm.run_name(plan_of(str(SEED))) == name
    monkeypatch.chdir(tmp_path)
    assert slurm.run_name(plan) != name


def test_interrupted_run_cancels_its_jobs(queue, capsys):
    with pytest.raises(KeyboardInterrupt), ended("vsb-seed-31"):
        raise KeyboardInterrupt
    assert queue.read_text() == "7 12\n"
    assert "vsb: 2 jobs on Slurm cancelled" in capsys.readouterr().err


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    """A machine that has srun, outside any job."""
    (tmp_path / "srun").write_text("#!/bin/sh\n")
    (tmp_path / "srun").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.delenv("SLURM_JOB_ID", raising=False)


def test_short_study_is_one_job_on_two_cores(cluster):
    plan = plan_of(str(HOME / "config" / "paper.yaml"))
    found = slurm.single_job(plan, PROFILE)
    size = ["--ntasks=1", "--nodes=1", "--cpus-per-task=2", "--mem=4000", "--time=60"]  # [MB], [minutes]
    assert found == ["srun", *size, f"--job-name={slurm.run_name(plan)}_whole"]


@pytest.mark.parametrize(
    ("simulation", "waves", "short"),
    [
        ({"duration": 60.0, "window": [40.0, 60.0]}, 1, True),
        ({"duration": 60.0, "window": [40.0, 60.0]}, slurm.MOST_RUNS, False),  # of two designs
        ({"duration": slurm.SHORT, "window": [40.0, 60.0]}, 1, False),
    ],
)
def test_long_or_many_runs_are_jobs_of_their_own(simulation, waves, short):
    seas = [{"kind": "regular", "amplitude": 0.1, "period": 3.0 + k} for k in range(waves)]
    raw = yaml.safe_load(SEED.read_text()) | {"waves": seas, "simulation": simulation}
    raw["designs"] = {"FSB": {"flexible": False}, "VSWEC": {}}
    assert slurm.is_short(StudyPlan(parse(raw))) == short
    assert not slurm.is_short(StudyPlan(parse({**raw, "hydro": {**raw["hydro"], "solver": "panels"}})))


def test_account_comes_from_the_profile_and_other_resources_are_left_to_the_plugin(cluster):
    given = {"default-resources": {"slurm_account": "me", "slurm_partition": "day"}}
    assert {"--account=me", "--partition=day"} <= set(slurm.single_job(plan_of(str(SEED)), {**PROFILE, **given}))
    for more in ({"default-resources": ["slurm_extra=--gres=gpu:1"]}, {"slurm-qos": "high"}):
        assert slurm.single_job(plan_of(str(SEED)), {**PROFILE, **more}) == []
