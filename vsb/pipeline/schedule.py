"""What a plan has left to do, how long that takes, and by how many processes it is done."""

import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from vsb.pipeline import costs
from vsb.pipeline.jobs import Job, jobs
from vsb.pipeline.tasks import Task, due, products, tasks
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.plans import Plan

SHORT = 600.0
"""CPU time up to which a run does without Snakemake, whose every job costs two seconds more [s].

A longer one has a log, a record and bounds of its own for each job.
"""
WORTH_A_FORK = 2.0
"""Time that side by side must save [s]: processes forked share no memory of what others have read or compiled."""


def left(plan: Plan, stale: Collection[str] = ()) -> list[Job]:
    """Return the jobs of a plan that have something left to do, with the tasks left of each."""
    some = {task.makes for task in due(tasks(plan), products(plan), stale)}
    found = (Job(job.rule, tuple(task for task in job.tasks if task.makes in some)) for job in jobs(plan))
    return [job for job in found if job.tasks]


def is_short(plan: Plan, stale: Collection[str] = ()) -> bool:
    """Return whether what is left of a plan is done without Snakemake."""
    return _seconds_here(plan, left(plan, stale)) <= SHORT


def workers(some: Sequence[Task]) -> int:
    """Return how many processes do tasks: one a core, or one where side by side they end no sooner."""
    total, longest = sum(task.seconds for task in some), max(longest_chains(some), default=0.0)
    count = min(cores(), len(some))
    return count if total - max(longest, total / count if count else 0.0) > WORTH_A_FORK else 1


def cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def longest_chains(some: Sequence[Task]) -> list[float]:
    """Return how long it takes from the begin of a task until all that waits for it is done, by its place [s]."""
    found = [0.0] * len(some)
    after: dict[str, float] = {}  # by file: the longest chain of what needs it
    for place in reversed(range(len(some))):
        task = some[place]
        found[place] = task.seconds + max((after.get(path, 0.0) for path in task.makes), default=0.0)
        for path in task.needs:
            after[path] = max(after.get(path, 0.0), found[place])
    return found


def _seconds_here(plan: Plan, some: Sequence[Job]) -> float:
    """What jobs take in a process that is there [s]; members of a campaign that are finished are kept."""
    tasks = [task for job in some for task in job.tasks]
    if not isinstance(plan, CampaignPlan):
        return sum(task.seconds for task in tasks)
    from vsb.tools.packed import packs

    stored = packs(Path(plan.folder, "members"))

    def share_left(task: Task) -> float:
        if not stored or task.stage != "members":
            return 1.0
        batch = plan.members_by_batch[Path(task.makes[0]).stem]
        return sum(one.id not in stored for one in batch) / len(batch)

    return sum(task.seconds * share_left(task) for task in tasks)


def seconds_of_jobs(plan: Plan) -> float:
    """Return the CPU time of starting jobs [s]: none of a short plan."""
    return 0.0 if is_short(plan) else costs.WORKFLOW_SECONDS + costs.JOB_SECONDS * len(left(plan))


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
    seconds = costs.START_OF_A_PROCESS + _seconds_here(plan, some) + better
    seconds += seconds_of_jobs(plan)
    return f"cost         {len(some)} of {len(jobs(plan))} jobs to do: about {costs.plain_seconds(seconds)} on one core"
