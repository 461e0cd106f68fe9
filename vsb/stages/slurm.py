"""Jobs a run hands over to Slurm: a short run is a single job; jobs are cancelled when the run is terminated."""

import os
import re
import shutil
import subprocess
import zlib
from collections.abc import Mapping
from typing import Any

from vsb.errors import VsbError
from vsb.pipeline.plans import CampaignPlan, DesignPlan, Plan

LONGEST = 50
"""Characters of a name the plug-in takes."""
CORES, MEGABYTES, MINUTES = 2, 4000, 60
"""Of the one job of a short study or campaign."""
MOST_RUNS = 8
"""Runs in time, or batches, that one job does."""
SHORT = 8 * 3600.0
"""Motion of all runs together that takes a minute or so [s]."""
NAMED = {"slurm_account": "--account", "slurm_partition": "--partition"}
"""What a profile may name of a cluster, and what srun calls it."""
UNDERSTOOD = {*NAMED, "mem_mb", "runtime", "slurm-no-account", "slurm-status-command"} | {
    "slurm-init-seconds-before-status-checks"
}
"""All else that a profile asks of Slurm is the plug-in's to understand."""


def single_job(plan: Plan, profile: Mapping[str, Any]) -> list[str]:
    """Return the command by which Slurm runs another one, of all of a short study or campaign, on one node.

    A job of each rule waits in the queue, starts snakemake twice and is asked for at growing intervals, which takes
    longer than what is short. Raises `VsbError` if this machine hands no jobs to Slurm.

    Parameters
    ----------
    profile : mapping
        What a profile of Snakemake's with Slurm for its executor says.

    Returns
    -------
    list of str
        Empty where rules are better jobs of their own: if the plan is long, if the profile asks for more than account
        and partition, or in a job of Slurm's.
    """
    if shutil.which("srun") is None:
        raise VsbError("--profile: received one for Slurm, whose srun is not found; needs a machine of the cluster")
    named = resources(profile)
    asked = {*named, *(key for key in profile if key.startswith("slurm"))}
    if not is_short(plan) or asked - UNDERSTOOD or "SLURM_JOB_ID" in os.environ:
        return []
    options = [f"{option}={named[key]}" for key, option in NAMED.items() if key in named]
    size = [f"--cpus-per-task={CORES}", f"--mem={MEGABYTES}", f"--time={MINUTES}"]
    return ["srun", "--ntasks=1", "--nodes=1", *size, *options, f"--job-name={run_name(plan)}_whole"]


def run_name(plan: Plan) -> str:
    """Return what the name of the one job of a plan begins with: the same in every run of it that writes there.

    A job whose srun was killed holds its cores until its time is over; the next run, which is alone there, cancels it.
    """
    name, place = re.sub(r"[^A-Za-z0-9_-]", "_", f"vsb-{plan.name}"), os.path.abspath(plan.folder)
    return f"{name}-{zlib.crc32(place.encode()):08x}"


def resources(profile: Mapping[str, Any]) -> dict[str, Any]:
    """Return the default resources of a profile, given as a mapping or as a list of `name=value`."""
    given = profile.get("default-resources") or {}
    return dict(given) if isinstance(given, Mapping) else dict(str(each).split("=", 1) for each in given)


def is_short(plan: Plan) -> bool:
    """Return whether all of a plan takes a few minutes on two cores."""
    if isinstance(plan, CampaignPlan):
        loaded, verify = plan.loaded, plan.loaded.campaign.verify
        runs = len(plan.verifications) * len(loaded.base.designs) * (verify.seas if verify else 0)
        motion = runs * loaded.base.simulation.duration
        return len(plan.batches) <= MOST_RUNS and motion <= SHORT and loaded.constrained is None
    if isinstance(plan, DesignPlan):
        return len(plan.all_starts) <= MOST_RUNS and not plan.verification
    study = plan.study
    runs = len(study.designs) * len(study.waves)
    motion = runs * study.simulation.duration
    return runs <= MOST_RUNS and motion <= SHORT and not study.uses_panels and not study.pto.has_latching_time


def job_name(name: str) -> str:
    """Return what the names of a run's jobs begin with: its study or campaign, and its process."""
    mine = f"-{os.getpid()}"
    return re.sub(r"[^A-Za-z0-9_-]", "_", f"vsb-{name}")[: LONGEST - len(mine)] + mine


def cancel(prefix: str) -> int:
    """Cancel the user's jobs whose names begin with a prefix; return how many, none where there is no Slurm."""
    if shutil.which("squeue") is None:
        return 0
    listed = subprocess.run(
        ["squeue", "--me", "--noheader", "--format=%i %j"], capture_output=True, text=True, check=False
    )
    jobs = [line.partition(" ")[::2] for line in listed.stdout.splitlines()]
    mine = [number for number, name in jobs if name.startswith(f"{prefix}_")]
    if mine:
        subprocess.run(["scancel", *mine], capture_output=True, check=False)
    return len(mine)
