"""Jobs: tasks done one after another by one process; what is left to do, how long it takes; the rules Snakemake knows.

A process takes 2 s to start. What is shared between studies, long, or can run beside others is a job of its own. Files
and ids are those of the tasks, whatever job does them.
"""

import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from vsb.keys.quantities import canonical
from vsb.pipeline import costs
from vsb.pipeline.graph import STAGES, Graph, Task, due

RULES = {
    "modes": "shell modes",
    "meshes": "the wetted shell deformed by each mode, to look at",
    "green": "Green-function table of the panels",
    "mesh": "mean wetted meshes of the panels",
    "panels": "a block of frequencies by panels",
    "spectral": "all frequencies by the spectral solver",
    "cross_check": "panels and the spectral solver on shells deformed by each mode",
    "frequencies": "frequencies of a body",
    "coefficients": "hydro database of a body, solved or read",
    "database": "hydro database and radiation memory",
    "response": "frequency response and control levels",
    "simulate": "designs in seas, simulated in time",
    "results": "tables, figures and report of a study",
    "members": "points of a campaign over the year",
    "verification": "seas of the year in time",
    "campaign": "tables, figures and report of a campaign",
    "design_start": "the best buoys from starts",
    "design_front": "the best buoys over one limit",
    "design_verification": "the best buoys in time",
    "design_results": "tables, figures and report of a design problem",
}
"""Rules in the order of the chain, and what they make."""
APART = {"mesh", "panels", "frequencies", "coefficients", "members", "design_front", "design_verification"}
"""Rules whose tasks are a job each: they are long, or others wait for one of them alone."""
BATCHED = {"simulate", "verification", "design_start"}
"""Rules whose tasks share a job up to `BATCH_SECONDS`; a job that is interrupted keeps those finished."""
BATCH_SECONDS, MOST_BATCHES = 10.0, 32
"""CPU time that a batch is to take at least [s], so that starting it does not count; and how many there are at most,
but for tasks longer than that."""
SHORT = 600.0
"""CPU time up to which a run does without Snakemake, whose every job costs two seconds more [s].

A longer one has a log, a record and bounds of its own for each job.
"""
WORTH_A_FORK = 2.0
"""Time that side by side must save [s]: processes forked share no memory of what others have read or compiled."""


@dataclass(frozen=True)
class Job:
    """Tasks done by one process, each after those whose files it needs."""

    rule: str
    tasks: tuple[Task, ...]

    @property
    def makes(self) -> tuple[str, ...]:
        """Files it makes."""
        return tuple(path for task in self.tasks for path in task.makes)

    @property
    def needs(self) -> tuple[str, ...]:
        """Files of other jobs, and of the user."""
        own = {*self.makes}
        return tuple(dict.fromkeys(path for task in self.tasks for path in task.needs if path not in own))

    @property
    def text(self) -> str:
        """Its tasks as canonical JSON, which its command reads from standard input."""
        return canonical([task.handed for task in self.tasks])

    @property
    def ids(self) -> str:
        """Ids of what it makes, by which Snakemake knows whether they are to be made anew."""
        return " ".join(task.id for task in self.tasks)

    @property
    def seconds(self) -> float:
        """CPU time it takes, with the start of its process [s]."""
        return costs.JOB_SECONDS + sum(task.seconds for task in self.tasks)

    @property
    def megabytes(self) -> int:
        """Memory it may take [MB]."""
        return max(task.megabytes for task in self.tasks)

    @property
    def minutes(self) -> int:
        """How long it may take [min]."""
        return max(task.minutes for task in self.tasks)


def jobs(plan: Graph) -> list[Job]:
    """Return the jobs of a plan, each after those whose files it needs."""
    by_rule: dict[str, list[list[Task]]] = {}
    for task in plan.tasks:
        if task.stage == "radiation":  # beside its database
            _making(by_rule, task.needs[0]).append(task)
            continue
        rule = STAGES[task.stage].rule
        groups = by_rule.setdefault(rule, [])
        if rule in APART or rule in BATCHED or not groups:
            groups.append([task])
        else:
            groups[0].append(task)
    return [
        Job(rule, tuple(group))
        for rule in RULES
        for group in (_batches(by_rule[rule]) if rule in BATCHED and rule in by_rule else by_rule.get(rule, []))
    ]


def _making(groups: Mapping[str, Sequence[list[Task]]], path: str) -> list[Task]:
    """The group of tasks that makes a file."""
    return next(group for some in groups.values() for group in some if any(path in task.makes for task in group))


def _batches(alone: Sequence[Sequence[Task]]) -> Iterator[list[Task]]:
    """Join short tasks, in their order, to batches of `BATCH_SECONDS` or more."""
    short = [task for (task,) in alone if task.seconds < BATCH_SECONDS]
    enough = max(BATCH_SECONDS, sum(task.seconds for task in short) / MOST_BATCHES)
    batch: list[Task] = []
    for (task,) in alone:
        if task.seconds >= BATCH_SECONDS:
            yield [task]
            continue
        batch.append(task)
        if sum(one.seconds for one in batch) >= enough:
            yield batch
            batch = []
    if batch:
        yield batch


# what is left to do -------------------------------------------------------------------------------------------------


def left(plan: Graph, stale: Collection[str] = ()) -> list[Job]:
    """Return the jobs of a plan that have something left to do, with the tasks left of each."""
    some = {task.makes for task in due(plan.tasks, plan.products, stale)}
    found = (Job(job.rule, tuple(task for task in job.tasks if task.makes in some)) for job in jobs(plan))
    return [job for job in found if job.tasks]


def _tasks_of(some: Sequence[Job]) -> list[Task]:
    """Tasks of jobs."""
    return [task for job in some for task in job.tasks]


def is_short(plan: Graph, stale: Collection[str] = ()) -> bool:
    """Return whether what is left of a plan is done without Snakemake."""
    return plan.seconds_left(_tasks_of(left(plan, stale))) <= SHORT


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


def seconds_of_jobs(plan: Graph) -> float:
    """Return the CPU time of starting jobs [s]: none of a short plan."""
    return 0.0 if is_short(plan) else costs.WORKFLOW_SECONDS + costs.JOB_SECONDS * len(left(plan))


def cost_line(plan: Graph, known: Mapping[str, float]) -> str:
    """Return the line `vsb check` prints of the jobs left and their CPU time.

    Parameters
    ----------
    plan : plan of a study or campaign
    known : mapping of str to float
        CPU time of the task that makes a file, where it is known better than from the plan [s].
    """
    some = left(plan)
    better = sum(known[task.out] - task.seconds for task in _tasks_of(some) if task.out in known)
    seconds = costs.START_OF_A_PROCESS + plan.seconds_left(_tasks_of(some)) + better
    seconds += seconds_of_jobs(plan)
    return f"cost         {len(some)} of {len(jobs(plan))} jobs to do: about {costs.plain_seconds(seconds)} on one core"


# Snakemake's rules --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rule:
    """Jobs as one rule of Snakemake's: where there are several, each makes one file, which the wildcard `job` names."""

    stem: str  # a key of `RULES`
    name: str  # with a number where several jobs of a rule make several files each
    jobs: Mapping[str, Job]  # by wildcard
    plan: Graph

    @property
    def names(self) -> str:
        """Values of the wildcard as a regular expression."""
        return "|".join(map(re.escape, self.jobs))

    @property
    def makes(self) -> list[str]:
        """Files it makes."""
        name, job = next(iter(self.jobs.items()))
        if not name:
            return list(job.makes)
        folder, _, ending = job.makes[0].rpartition(name)  # the folder of the study may be called as a job is
        return [f"{folder}{{job}}{ending}"]

    def keeps(self, path: str) -> bool:
        """Whether a file that is there stays when another of the same job is made: it is shared, or took long."""
        return self.stem in BATCHED or self.plan.is_shared(path)

    def record(self, kind: str) -> str:
        """Return the name of a record of a job: `logs` or `benchmarks`."""
        folder, ending = f"{self.plan.root}/{kind}/{self.name}", {"logs": "log", "benchmarks": "tsv"}[kind]
        return f"{folder}/{self.plan.name}{'-{job}' if '' not in self.jobs else ''}.{ending}"

    # functions of wildcards, which Snakemake asks --------------------------------------------------------------------

    def job(self, wildcards: Any) -> Job:
        """Return the job of a file."""
        return self.jobs[getattr(wildcards, "job", "")]

    def needs(self, wildcards: Any) -> list[str]:
        """Return the files a job needs."""
        return list(self.job(wildcards).needs)

    def ids(self, wildcards: Any) -> str:
        """Return the ids of what a job makes of its own; files that studies share are named by theirs."""
        return "" if all(map(self.plan.is_shared, self.makes)) else self.job(wildcards).ids

    def text(self, wildcards: Any, output: Any) -> str:
        """Return the tasks of a job, which Snakemake does not compare between runs, for `output` is asked."""
        return self.job(wildcards).text

    def megabytes(self, wildcards: Any) -> int:
        """Return the memory a job may take [MB]."""
        return self.job(wildcards).megabytes

    def minutes(self, wildcards: Any) -> int:
        """Return how long a job may take [min]."""
        return self.job(wildcards).minutes


def rules(plan: Graph) -> list[Rule]:
    """Return the rules of a plan, in the order of the chain."""
    found: list[Rule] = []
    every = jobs(plan)
    for stem in RULES:
        some = [job for job in every if job.rule == stem]
        one_file = [job for job in some if len(job.makes) == 1] if len(some) > 1 else []
        if one_file:
            found.append(Rule(stem, stem, {PurePosixPath(job.makes[0]).stem: job for job in one_file}, plan))
        others = [job for job in some if job not in one_file]
        for number, job in enumerate(others, 1):
            found.append(Rule(stem, stem if len(some) == 1 else f"{stem}_{number}", {"": job}, plan))
    return found


# Snakemake's own report ---------------------------------------------------------------------------------------------

_SHOWN = {
    "comparison.csv": ("comparison", "Numbers", {"table": "designs side by side"}),
    "statistics.csv": ("statistics", "Numbers", {"table": "irregular seas"}),
    "validity.json": ("validity", "What to doubt", {"table": "ledger"}),
    "ladder.csv": ("ladder", "Numbers", {"table": "control levels"}),
    "starts.csv": ("starts", "Numbers", {"table": "where every start ended"}),
    "budget.csv": ("budget", "Numbers", {"table": "what the gain is uncertain by"}),
    "campaign.csv": ("campaign_table", "Numbers", {"table": "every point, design and tuning"}),
    "report.html": ("report", "The answer", {"page": "report"}),
}
"""Products in Snakemake's report: caption, category, labels."""


def shown(path: str, plan: Graph) -> dict[str, Any]:
    """Return how a product stands in Snakemake's report: options of its function `report`; empty if it does not."""
    file = PurePosixPath(path)
    of = "" if plan.KIND == "study" else f"{plan.KIND}_"
    if file.name in _SHOWN:
        caption, category, labels = _SHOWN[file.name]
        prefix = of if file.name == "report.html" else ""
        return {"caption": f"../report/{prefix}{caption}.rst", "category": category, "labels": labels}
    if file.parent.name != "figures" or file.suffix != ".svg":
        return {}
    name, _, wave = file.stem.partition("-")
    found = {"category": "Figures", "labels": {"figure": name.replace("_", " ")}}
    if of:
        return {**found, "caption": f"../report/{of}figures.rst"}
    return {**found, "caption": "../report/figures.rst", "subcategory": wave or "the whole band"}
