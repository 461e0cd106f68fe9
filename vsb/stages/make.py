"""A plan in this process: its tasks in the order of their inputs, finished files kept; lines of how far a run is."""

import contextlib
import re
import sys
import time
from collections.abc import Callable, Collection, Iterable, MutableSequence, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vsb.pipeline.costs import plain_seconds
from vsb.pipeline.graph import StudyPlan, Task, due
from vsb.pipeline.jobs import RULES, Rule, workers
from vsb.pipeline.plans import DesignPlan, Plan
from vsb.stages.check import check_plan, known_seconds
from vsb.stages.stage import CAN_FORK, exclusive_lock, run_side_by_side, run_task, shared_lock
from vsb.stages.verify import stale_products
from vsb.study.study import Study
from vsb.tools.files import check_folder

# how far a run is, also one by Snakemake from its output --------------------------------------------------------------


BEGUN = re.compile(r"^(?:local)?rule (\w+):$")
WILDCARD = re.compile(r"^\s+wildcards: job=(.+)$")
LAST = re.compile(r"^\s+resources: ")
DONE = re.compile(r"^(\d+) of (\d+) steps \(\d+%\) done$")
FAILED = re.compile(r"\bvsb stage (\w+)\s.* > (\S+) 2>&1' returned non-zero exit status \d+")


FIRM = 10.0
"""Work after which the rate of a run counts as much as the estimate [s]: what comes first is mostly imports."""


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    name: str
    seconds: Sequence[float]  # CPU time of its parts as estimated, in their order [s]
    quiet: bool = False
    workers: int = 1  # processes that do them
    begun: float = field(default_factory=time.monotonic)

    def say(self, words: str) -> None:
        """Print a line of the run, unless it is quiet."""
        if not self.quiet:
            print(f"{self.name}: {words}", file=sys.stderr, flush=True)

    def begin(self, words: str, done: Collection[int]) -> None:
        """Say what begins, when parts in these places are done, and how long all that is left takes."""
        before = sum(self.seconds[place] for place in done)
        rate = (time.monotonic() - self.begun + FIRM / self.workers) / (before + FIRM)
        left = rate * (sum(self.seconds) - before)
        still = f", about {plain_seconds(left)} left" if left >= 1.0 else ""
        self.say(f"{len(done)} of {len(self.seconds)} done{still}; {words}")


def followed(
    lines: Iterable[str],
    progress: Progress,
    rules: Iterable[Rule],
    kept: MutableSequence[str],
    words: Callable[[], str] | None = None,
) -> None:
    """Say how far a run by Snakemake is.

    Parameters
    ----------
    lines : iterable of str
        Snakemake's output.
    progress : Progress
        With the jobs left as its parts.
    rules : iterable of Rule
    kept : sequence of str
        Receives the lines.
    words : callable, optional
        Returns what else is to be said when a job is done.
    """
    stems = {rule.name: rule.stem for rule in rules}
    name, which, done = "", "", 0
    for line in lines:
        kept.append(line)
        if found := BEGUN.match(line):
            name, which = found[1], ""
        elif found := WILDCARD.match(line):
            which = f" {found[1].strip()}"
        elif name in stems and LAST.match(line):
            progress.begin(f"{RULES[stems[name]]}{which}", range(done))
            name = ""
        elif found := DONE.match(line.strip()):
            done = min(int(found[1]), len(progress.seconds))
            if words and (said := words()):
                progress.say(said)


def failed(lines: Iterable[str]) -> dict[str, str]:
    """Return the rules that failed in the output of Snakemake, by the log file of the job."""
    return {found[2]: found[1] for line in lines if (found := FAILED.search(line))}


# a run without Snakemake ----------------------------------------------------------------------------------------------


Begun = Callable[[Task], None]
"""Told of each task before it is done."""


def run(plan: Plan, *, quiet: bool = True) -> None:
    """Make all products of a plan in this process: files and numbers are those of `vsb run`, finished ones are kept."""
    check_plan(plan)
    check_folder(plan.root)
    with exclusive_lock(Path(plan.folder)):
        stale = stale_products(plan, dry=False)
        make_each(plan, due(plan.tasks, plan.products, stale), stale, quiet=quiet)


def make_each(
    plan: Plan, some: Sequence[Task], stale: Collection[str], *, quiet: bool, side_by_side: bool = False
) -> None:
    """Do tasks, saying what begins, how much is done and the time left, unless quiet.

    One after another in this process, or side by side in forks of it: files and numbers are the same. What stages
    print goes into the log.
    """
    count = workers(some) if side_by_side and CAN_FORK else 1
    known = {} if quiet else known_seconds(plan)
    progress = Progress(plan.name, [known.get(task.out, task.seconds) for task in some], quiet, count)

    def begun(place: int, done: Collection[int]) -> None:
        progress.begin(some[place].words, done)
        if isinstance(plan, DesignPlan) and (found := best_so_far(plan)):
            progress.say(found)

    log = Path(log_path(plan))
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w", encoding="utf-8", buffering=1) as lines, contextlib.redirect_stdout(lines):
        if count > 1:
            run_side_by_side(some, lambda task: _run(plan, [task], stale), count, begun)
        else:
            _run(plan, some, stale, lambda task: begun(place := some.index(task), range(place)))


def log_path(plan: Plan) -> str:
    """Return the file of what stages, or Snakemake, say in a run."""
    return f"{plan.root}/logs/{plan.name}.log"


BEST = re.compile(r"^best so far: (\S+) ")
"""What a start says of the best buoy within its limits."""


def best_so_far(plan: DesignPlan) -> str:
    """Return the best buoy within its limits any start has found yet; empty before the first."""
    logs = [Path(log_path(plan)), *Path(plan.root, "logs").glob(f"design_start*/{plan.name}*.log")]
    lines = [line for path in logs if path.exists() for line in path.read_text(encoding="utf-8").splitlines()]
    found = [(float(match[1]), line) for line in lines if (match := BEST.match(line))]
    return max(found)[1] if found else ""


def make(plan: Plan, targets: Collection[str], stale: Collection[str] = ()) -> None:
    """Make files of a plan, and what they need; those that are there, and not stale, are kept."""
    _run(plan, due(plan.tasks, targets, stale), stale)


def hydro_files(study: Study, folder: str | Path) -> dict[str, str]:
    """Return the paths of the database and radiation model of a study by name, made if not there yet.

    Files are named by content, so studies in one folder share them.
    """
    from vsb.models.rest import check_stable, reference_shell  # a dry run does without them

    plan = StudyPlan(study, root=str(folder))
    check_stable(study, reference_shell(study))
    if study.needs_bem:
        plan.check_waves()
    make(plan, plan.hydro_files.values())
    return dict(plan.hydro_files)


def solve(plan: StudyPlan) -> None:
    """Solve the frequencies of a buoy's shape that are not there: what of a study a member of a campaign needs."""
    targets = [plan.block_path(block) for block in plan.sweep_blocks]
    if not all(Path(path).exists() for path in targets):
        _run(plan, due(list(plan.blocks()), targets))


def _run(plan: Plan, some: Sequence[Task], stale: Collection[str] = (), begun: Begun | None = None) -> None:
    """Run tasks in their order, each alone at its shared files."""
    for task in some:
        with shared_lock(plan.root, filter(plan.is_shared, task.makes)):
            if begun:
                begun(task)
            if not all(Path(path).exists() and path not in stale for path in task.makes):  # made meanwhile, by another
                run_task(task)
