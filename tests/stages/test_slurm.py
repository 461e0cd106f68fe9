"""Runs on Slurm without Slurm: its commands are scripts that tell what they were asked."""

import os
import re
from pathlib import Path

import pytest
import yaml

from vsb.stages import slurm
from vsb.stages.run import ended
from vsb.stages.stage import STAGES
from vsb.tools.shipped import HOME

PROFILE = yaml.safe_load((HOME / "profiles" / "slurm" / "config.yaml").read_text())
QUEUE = """7 vsb-seed-31_aa
8 vsb-seed-312_bb
9 other
12 vsb-seed-31_cc d"""


@pytest.fixture
def queue(tmp_path, monkeypatch):
    """A queue of four jobs; what is cancelled stands in a file."""
    for name, text in {"squeue": f"cat <<'E'\n{QUEUE}\nE", "scancel": f'echo "$@" > {tmp_path}/cancelled'}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    return tmp_path / "cancelled"


def test_only_a_runs_own_jobs_are_cancelled(queue):
    assert slurm.cancel("vsb-seed-31") == 2
    assert queue.read_text() == "7 12\n"


def test_nothing_is_cancelled_where_there_is_nothing(queue):
    assert slurm.cancel("vsb-year-1") == 0
    assert not queue.exists()


@pytest.mark.parametrize("reason", [KeyboardInterrupt, SystemExit(143)])
def test_a_run_told_to_end_leaves_no_jobs_behind(queue, capsys, reason):
    with pytest.raises((KeyboardInterrupt, SystemExit)), ended("vsb-seed-31"):
        raise reason
    assert queue.read_text() == "7 12\n"
    assert "vsb: 2 jobs on Slurm cancelled" in capsys.readouterr().err


def test_a_run_that_ends_by_itself_cancels_nothing(queue):
    with ended("vsb-seed-31"):
        pass
    assert not queue.exists()


@pytest.mark.parametrize("name", ["seed", "x" * 80, "my study: 1"])
def test_names_of_jobs_are_what_the_plug_in_takes(name):
    found = slurm.job_name(name)
    assert re.fullmatch(r"[A-Za-z0-9_-]{1,50}", found)
    assert found.endswith(f"-{os.getpid()}")


def test_the_profile_asks_for_neither_account_nor_accounting():
    assert PROFILE["slurm-no-account"] is True
    assert PROFILE["slurm-status-command"] == "squeue"  # with sacct alone jobs never end where there is no slurmdbd
    assert not {"slurm_account", "slurm_partition"} & set(PROFILE["default-resources"])
    assert PROFILE["retries"] >= 1


def test_rules_in_groups_are_rules_and_none_of_many_jobs():
    """A group asks for as many cores as it has jobs side by side: two at most, however many seas and designs."""
    groups = dict(each.split("=") for each in PROFILE["groups"])
    assert set(groups) <= {stage.name for stage in STAGES}
    assert not set(groups) & {"simulate", "members", "panels", "verification"}


def test_rules_of_a_second_run_where_snakemake_does():
    texts = "".join(path.read_text() for path in sorted(Path(HOME, "workflow", "rules").glob("*.smk")))
    local = {
        word
        for block in re.findall(r"localrules:[^\n]*\n((?:    \w+,\n)+)", texts)
        for word in re.findall(r"\w+", block)
    }
    assert local == {"modes", "display", "mesh", "deformed"}
