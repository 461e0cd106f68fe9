"""A plan in this process: its tasks in the order of their inputs, finished files kept, without Snakemake."""

import contextlib
import re
from collections.abc import Callable, Collection, Sequence
from pathlib import Path

from vsb.pipeline.design_plan import DesignPlan
from vsb.pipeline.graph import StudyPlan, Task, due
from vsb.pipeline.jobs import workers
from vsb.pipeline.plans import Plan
from vsb.stages.check import check_plan
from vsb.stages.locks import exclusive_lock, shared_lock
from vsb.stages.progress import Progress
from vsb.stages.stage import run_task
from vsb.stages.verify import stale_products
from vsb.stages.workers import CAN_FORK, run_side_by_side
from vsb.study.study import Study
from vsb.tools.files import check_folder

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
    progress = Progress(plan.name, [task.seconds for task in some], quiet, count)

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
