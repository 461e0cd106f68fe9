"""Runs on Slurm without Slurm: its commands are scripts that tell what they were asked."""

import os
import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from conftest import EXAMPLE, varied

from vsb.errors import VsbError
from vsb.stages import slurm
from vsb.stages.run import ended
from vsb.stages.stage import STAGES
from vsb.study.campaign_plan import plan_of
from vsb.study.plan import StudyPlan
from vsb.study.study import load
from vsb.tools.shipped import HOME

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
    """A queue of six jobs, two of which have no name; what is cancelled stands in a file."""
    for name, text in {"squeue": f"cat <<'E'\n{QUEUE}\nE", "scancel": f'echo "$@" > {tmp_path}/cancelled'}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    return tmp_path / "cancelled"


def test_only_a_runs_own_jobs_are_cancelled(queue):
    assert slurm.cancel("vsb-seed-31") == 2
    assert queue.read_text() == "7 12\n"


@pytest.mark.parametrize("given", [{"mem_mb": "500", "runtime": "5"}, ["mem_mb=500", "runtime=5"]])
def test_default_resources_are_a_mapping_a_list_or_none(given):
    assert slurm.resources({"default-resources": given}) == {"mem_mb": "500", "runtime": "5"}
    assert slurm.resources({}) == slurm.resources({"default-resources": None}) == {}


def test_nothing_is_cancelled_where_there_is_nothing(queue):
    assert slurm.cancel("vsb-year-1") == 0
    assert not queue.exists()


def test_the_one_job_of_a_study_is_known_to_its_next_run_and_to_no_other(queue, tmp_path, monkeypatch):
    """Killed, srun leaves it its cores until its time is over."""
    plan = plan_of(str(SEED))
    name = slurm.whole_name(plan)
    assert re.fullmatch(r"vsb-seed-[0-9a-f]{8}", name)
    assert slurm.whole_name(plan_of(str(SEED))) == name
    assert slurm.whole_name(plan_of(str(EXAMPLE.parent / "paper.yaml"))).removeprefix("vsb-paper") != name.removeprefix(
        "vsb-seed"
    )
    monkeypatch.chdir(tmp_path)
    assert slurm.whole_name(plan) != name


@pytest.mark.parametrize("reason", [KeyboardInterrupt, SystemExit(143)])
def test_a_run_told_to_end_leaves_no_jobs_behind(queue, capsys, reason):
    with pytest.raises((KeyboardInterrupt, SystemExit)), ended("vsb-seed-31"):
        raise reason
    assert queue.read_text() == "7 12\n"
    assert "vsb: 2 jobs on Slurm cancelled" in capsys.readouterr().err


def test_where_there_is_no_slurm_nothing_is_cancelled(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert slurm.cancel("vsb-seed-31") == 0


def test_a_run_that_ends_by_itself_cancels_nothing(queue):
    with ended("vsb-seed-31"):
        pass
    assert not queue.exists()


@pytest.mark.parametrize("name", ["seed", "x" * 80, "my study: 1"])
def test_names_of_jobs_are_what_the_plug_in_takes(name):
    found = slurm.job_name(name)
    assert re.fullmatch(r"[A-Za-z0-9_-]{1,50}", found)
    assert found.endswith(f"-{os.getpid()}")
    assert found.startswith(re.sub("[ :]", "_", f"vsb-{name}")[: 50 - len(str(os.getpid())) - 1])


def test_the_profile_asks_for_neither_account_nor_accounting():
    assert PROFILE["slurm-no-account"] is True
    assert PROFILE["slurm-status-command"] == "squeue"  # with sacct alone jobs never end where there is no slurmdbd
    assert not {"slurm_account", "slurm_partition"} & set(PROFILE["default-resources"])
    assert PROFILE["retries"] >= 1


def test_rules_in_groups_are_rules_and_none_of_many_jobs():
    """They run one after another, so on one core; of many jobs each is better a job of its own."""
    groups = dict(each.split("=") for each in PROFILE["groups"])
    assert set(groups) <= {stage.name for stage in STAGES}
    assert not set(groups) & {"simulate", "members", "panels", "verification"}
    assert PROFILE["cores"] == 1


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    """A machine that has srun, outside any job."""
    (tmp_path / "srun").write_text("#!/bin/sh\n")
    (tmp_path / "srun").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.delenv("SLURM_JOB_ID", raising=False)


@pytest.mark.parametrize("name", ["pressurised.yaml", "paper.yaml"])
def test_all_that_is_short_is_one_job_of_two_cores(cluster, name):
    plan = plan_of(str(HOME / "config" / name))
    found = slurm.whole(plan, PROFILE)
    size = ["--ntasks=1", "--nodes=1", "--cpus-per-task=2", "--mem=4000", "--time=60"]  # [MB], [minutes]
    assert found == ["srun", *size, f"--job-name={slurm.whole_name(plan)}_whole"]


@pytest.mark.parametrize(
    "given",
    [{"slurm_account": "me", "slurm_partition": "day"}, ["slurm_account=me", "slurm_partition=day", "mem_mb=9"]],
)
def test_account_and_partition_are_the_profiles(cluster, given):
    found = slurm.whole(plan_of(str(SEED)), {**PROFILE, "default-resources": given})
    assert {"--account=me", "--partition=day"} <= set(found)


def test_a_resource_may_hold_the_sign_that_ends_its_name():
    assert slurm.resources({"default-resources": ["slurm_extra=--gres=gpu:1"]}) == {"slurm_extra": "--gres=gpu:1"}


@pytest.mark.parametrize(
    "more",
    [
        {"default-resources": {"slurm_extra": "--gres=gpu:1"}},
        {"slurm-qos": "high"},
        {"default-resources": {"slurm_cluster": "b"}},
    ],
    ids=["extra", "quality of service", "cluster"],
)
def test_what_else_a_profile_asks_of_slurm_is_left_to_its_plug_in(cluster, more):
    assert slurm.whole(plan_of(str(SEED)), {**PROFILE, **more}) == []


def test_within_a_job_none_is_asked_for_all(cluster, monkeypatch):
    monkeypatch.setenv("SLURM_JOB_ID", "7")
    assert slurm.whole(plan_of(str(SEED)), PROFILE) == []


def test_without_srun_a_line_says_so(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: None)
    with pytest.raises(
        VsbError, match=r"^--profile: received one for Slurm, whose srun is not found; needs a machine of"
    ):
        slurm.whole(plan_of(str(SEED)), PROFILE)


LONG = {
    "runs": {"waves": [{"kind": "jonswap", "hs": 1.0, "tp": 5.0, "realisations": 3}]},
    "hours": {"simulation": {"duration": 7201.0, "window": [0.0, 1.0]}},
    "panels": {"hydro": {"solver": "panels"}},
    "pauses": {"pto": {"law": "latching"}},
}


@pytest.mark.parametrize("changes", LONG.values(), ids=LONG)
def test_what_is_long_is_a_job_for_every_rule(cluster, changes):
    assert slurm.whole(StudyPlan(varied(load(SEED), **changes)), PROFILE) == []


def test_a_body_that_is_solved_of_its_mesh_is_long():
    assert not slurm.is_short(plan_of(str(EXAMPLE.parent / "barge.yaml")))


@pytest.mark.parametrize(
    ("seas", "duration", "short"),
    [(2, 3600.0, True), (2, 3600.1, False), (1, 7200.0, True), (1, 7200.1, False), (3, 1.0, False)],
)
def test_eight_runs_of_eight_hours_together_are_short(seas, duration, short):
    """Of the seed's four designs; one run or a second more is long."""
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 3.0 + i} for i in range(seas)]
    simulation = {"duration": duration, "window": [0.0, 1.0]}
    plan = StudyPlan(varied(load(SEED), waves=waves, simulation=simulation))
    assert len(plan.study.designs) == 4
    assert slurm.is_short(plan) == short


class Year:
    """What is asked of a campaign's plan: batches, points run in time in some seas of a duration, of three designs."""

    def __init__(self, batches=1, points=2, seas=4, duration=1200.0, constrained=None):
        self.batches, self.verifications = {str(i): i for i in range(batches)}, {str(i): i for i in range(points)}
        base = SimpleNamespace(designs=dict.fromkeys("ABC"), simulation=SimpleNamespace(duration=duration))
        verify = SimpleNamespace(seas=seas) if seas else None
        campaign = SimpleNamespace(verify=verify)
        self.loaded = SimpleNamespace(base=base, campaign=campaign, constrained=constrained)


@pytest.mark.parametrize(
    ("year", "short"),
    [
        (Year(), True),
        (Year(duration=1200.1), False),
        (Year(points=3), False),
        (Year(seas=5), False),
        (Year(points=30, seas=None, duration=1e6), True),
        (Year(batches=8), True),
        (Year(batches=9), False),
        (Year(constrained=SimpleNamespace(seconds=1.0)), False),
    ],
)
def test_a_campaign_is_short_by_its_batches_and_the_motion_of_all_its_runs(monkeypatch, year, short):
    """Two points of three designs in four seas of a third of an hour are eight hours; runs are none without seas."""
    monkeypatch.setattr(slurm, "CampaignPlan", Year)
    assert slurm.is_short(year) == short


@pytest.mark.parametrize(
    "changes",
    [
        {"verify": {"seas": 124}},
        {"tuning": ["one", "constrained"]},
        {"vary": {"device.mass": {"log": [1.6e4, 1.8e4, 5000]}}, "verify": None},
    ],
    ids=["hours verified", "optima under limits", "many members"],
)
def test_a_long_campaign_is_a_job_for_every_rule(changes, tmp_path):
    shutil.copytree(HOME / "config", tmp_path, dirs_exist_ok=True)
    given = yaml.safe_load((tmp_path / "year.yaml").read_text()) | {
        "study": "pressurised.yaml",
        "vary": {"device.density": [2600.0]},
        "tuning": ["one"],
    }
    (tmp_path / "year.yaml").write_text(yaml.safe_dump(given))
    assert slurm.is_short(plan_of(str(tmp_path / "year.yaml")))
    (tmp_path / "year.yaml").write_text(yaml.safe_dump(given | changes))
    assert not slurm.is_short(plan_of(str(tmp_path / "year.yaml")))


def test_rules_of_a_second_run_where_snakemake_does():
    texts = "".join(path.read_text() for path in sorted(Path(HOME, "workflow", "rules").glob("*.smk")))
    local = {
        word
        for block in re.findall(r"localrules:[^\n]*\n((?:    \w+,\n)+)", texts)
        for word in re.findall(r"\w+", block)
    }
    assert local == {"modes", "display", "mesh", "deformed"}
