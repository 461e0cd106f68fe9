"""What a plan has left to do, and whether one process does it sooner than jobs side by side."""

import os
from collections.abc import Collection, Mapping
from pathlib import Path

from vsb.pipeline import costs
from vsb.pipeline.jobs import Job, jobs
from vsb.pipeline.tasks import Task, due, products, tasks
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.plans import Plan

WORTH_JOBS = 1.5
"""How many times sooner jobs side by side must end to be worth the CPU time that starting them takes."""


def left(plan: Plan, stale: Collection[str] = ()) -> list[Job]:
    """Return the jobs of a plan that have something left to do, with the tasks left of each."""
    some = {task.makes for task in due(tasks(plan), products(plan), stale)}
    found = (Job(job.rule, tuple(task for task in job.tasks if task.makes in some)) for job in jobs(plan))
    return [job for job in found if job.tasks]


def is_faster_here(plan: Plan, stale: Collection[str] = ()) -> bool:
    """Return whether one process, task after task, ends about as soon as Snakemake's jobs on the cores there are."""
    some, cores = left(plan, stale), len(os.sched_getaffinity(0))
    return sum(_seconds_here(plan, job) for job in some) <= WORTH_JOBS * _seconds_side_by_side(some, cores)


def _seconds_here(plan: Plan, job: Job) -> float:
    """What a job takes in a process that is there [s]; members of a campaign that are finished are kept."""
    return sum(task.seconds * _share_left(plan, task) for task in job.tasks)


def _share_left(plan: Plan, task: Task) -> float:
    """Which part of a task is to be done."""
    if not (isinstance(plan, CampaignPlan) and task.stage == "members"):
        return 1.0
    from vsb.tools.packed import SUFFIX

    batch = plan.members_by_batch[Path(task.makes[0]).stem]
    return sum(not Path(plan.folder, "members", f"{one.id}{SUFFIX}").exists() for one in batch) / len(batch)


def _seconds_side_by_side(some: Collection[Job], cores: int) -> float:
    """When jobs are over that Snakemake starts [s]: the longest chain of them, or all of them over the cores."""
    over: dict[str, float] = {}  # by file
    for job in some:
        end = job.seconds + max((over.get(path, 0.0) for path in job.needs), default=0.0)
        over |= dict.fromkeys(job.makes, end)
    busy = sum(job.seconds for job in some) / cores
    return costs.WORKFLOW_SECONDS + max(busy, *over.values(), 0.0)


def seconds_of_jobs(plan: Plan) -> float:
    """Return the CPU time of starting jobs [s]: none where one process does all."""
    return 0.0 if is_faster_here(plan) else costs.WORKFLOW_SECONDS + costs.JOB_SECONDS * len(left(plan))


def cost_line(plan: Plan, known: Mapping[str, float]) -> str:
    """Return the line `vsb check` prints of the jobs left and their CPU time.

    Parameters
    ----------
    plan : plan of a study or campaign
    known : mapping of str to float
        CPU time of the task that makes a file, where it is known better than from the plan [s].
    """
    some = left(plan)
    better = sum(known[task.makes[0]] - task.seconds for job in some for task in job.tasks if task.makes[0] in known)
    seconds = costs.START_OF_A_PROCESS + sum(_seconds_here(plan, job) for job in some) + better
    seconds += seconds_of_jobs(plan)
    return f"cost         {len(some)} of {len(jobs(plan))} jobs to do: about {costs.plain_seconds(seconds)} on one core"
