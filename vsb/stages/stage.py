"""Tasks at work: the function of a stage, one task or several side by side, and locks on what studies share.

A task's `stage` is a function `run_STAGE` of a module here.
"""

import importlib
import inspect
import json
import multiprocessing
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path
from typing import Any, get_type_hints

import psutil
from pydantic import TypeAdapter, ValidationError

from vsb.errors import ConfigError, VsbError
from vsb.keys.quantities import canonical, id_in
from vsb.keys.reading import one_line
from vsb.pipeline.graph import STAGES, Task
from vsb.pipeline.jobs import longest_chains
from vsb.study.specs import PHYSICS
from vsb.tools import files
from vsb.tools.stamps import check_product, faults, read_manifest

GIVEN = "standard input"
Stamp = dict[str, str]
"""Attributes of a netCDF file: `spec`, what it was made from as text, and `spec_id`, its id."""


def function_of(stage: str) -> Any:
    """Return the function of a stage; imports the science only now."""
    return getattr(importlib.import_module(f"vsb.stages.{STAGES[stage].module}"), f"run_{stage}")


def run_task(task: Task) -> None:
    """Run the stage of a task on what it reads as text, as a job has it: both give the same numbers."""
    run, text = function_of(task.stage), canonical(task.spec)
    stamps = {"stamp": {"spec": text, "spec_id": task.id}} if "stamp" in get_type_hints(run) else {}
    given = read_of(task.stage, json.loads(text)) | {**task.files, **stamps}
    try:
        inspect.signature(run).bind(**given)
    except TypeError as error:
        raise ConfigError(f"{GIVEN}: {task.stage}: {error}; run vsb run CONFIG again") from None
    run(**given)


def read_of(stage: str, spec: dict[str, Any]) -> dict[str, Any]:
    """Return what a stage reads of a study by parameter of its function, from JSON; raises `ConfigError`."""
    tag, hints = STAGES[stage].tag or stage, get_type_hints(function_of(stage), include_extras=True)
    given = {"stage": tag, "physics": PHYSICS.get(tag), "versions": {}} | spec
    given.pop("versions")
    for key, value in (("stage", tag), ("physics", PHYSICS.get(tag))):
        if (received := given.pop(key)) != value:
            raise ConfigError(
                f"{GIVEN}: {key} {received!r}: needs {value!r}, of this version; run vsb run CONFIG again"
            )
    if unknown := [*given.keys() - hints.keys()]:
        raise ConfigError(f"{GIVEN}: {unknown[0]}: is nothing that {stage} reads; run vsb run CONFIG again")
    try:
        return {name: _adapter(hints[name]).validate_python(value) for name, value in given.items()}
    except ValidationError as error:
        raise ConfigError(f"{GIVEN}: {one_line(error, given)}") from None


_adapter = cache(TypeAdapter)
"""What checks values of a type, built once: that of any study takes 30 ms."""


def run_job(rule: str, text: str) -> None:
    """Run the tasks of a job, as JSON; one whose files are there, and what they should be, is finished.

    Raises `ConfigError` by what are no tasks, `DatabaseError` if a file of the user would be replaced.
    """
    for task in read_tasks(text):
        if is_finished(task):
            continue
        tag = STAGES[task.stage].tag or task.stage
        for path in filter(None, (*task.makes, task.files.get("manifest"))):
            check_product(path, rule, tag)
        run_task(task)


def read_tasks(text: str) -> Iterator[Task]:
    """Yield the tasks of a text; raises `ConfigError`."""
    needs = "needs the tasks of a rule"
    try:
        raw = json.loads(text)
    except json.JSONDecodeError as error:
        seen = repr(rest[:40]) if (rest := text[error.pos :].strip()) else "its end"
        raise ConfigError(f"{GIVEN}:{error.lineno}: no JSON from {seen} on; {needs}") from None
    except (ValueError, RecursionError):
        raise ConfigError(f"{GIVEN}: numbers too long or parts too deep; {needs}") from None
    try:
        found = [TypeAdapter(Task).validate_python(one) for one in raw]
    except (ValidationError, TypeError):
        raise ConfigError(f"{GIVEN}: received {text[:40]}, {needs}") from None
    for task in found:
        if task.stage not in STAGES:
            raise ConfigError(f"{GIVEN}: stage: received {task.stage}, needs one of {', '.join(STAGES)}")
    yield from found


def is_finished(task: Task) -> bool:
    """Whether all that a task makes is there, of its specification and whole."""
    if not all(Path(path).exists() for path in task.makes):
        return False
    if not task.id:
        return True
    manifest = read_manifest(task.files["manifest"]) if "manifest" in task.files else {}
    return not faults(dict.fromkeys(task.makes, task.id), manifest)


# locks: one run at a time of a study, and of what makes a file that studies share -------------------------------------


PATIENCE = 5.0
"""Time a lock is waited for without a word [s]."""
LOCKS = ".locks"
"""Folder of the locks on what studies share, beside it."""


@contextmanager
def exclusive_lock(folder: Path, *, waits: bool = True) -> Iterator[list[int]]:
    """Hold the folder of a study; the lock goes with the processes that hold it, so a killed run leaves none behind."""
    if not waits:  # a dry run writes nothing
        yield []
        return
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("a") as handle:
        if not files.take(handle.fileno()):
            holder = (folder / ".lock").read_text(encoding="utf-8")  # if it has said so
            words = f" ({holder})" if holder else ""
            raise VsbError(f"{folder}: another run is at work in this folder{words}; wait for it to end")
        handle.truncate(0)
        handle.write(f"process {os.getpid()} on {socket.gethostname()}")
        handle.flush()
        yield [handle.fileno()]


@contextmanager
def shared_lock(root: str | Path, paths: Iterable[str]) -> Iterator[list[int]]:
    """Hold what is about to make files that studies share, until it is done; wait for another run that makes them now.

    Parameters
    ----------
    root : str or Path
        Folder of all results.
    paths : iterable of str
        Files, named by their content id or lying in a folder that is.
    """
    folder = Path(root, "hydro", LOCKS)
    with ExitStack() as stack:
        handles = []
        for name in sorted(set(map(id_in, paths))):  # in one order: nobody waits in a circle
            folder.mkdir(parents=True, exist_ok=True)
            handle = stack.enter_context((folder / name).open("w"))
            if not files.wait(handle.fileno(), PATIENCE):
                print(f"vsb: waiting for another run or task that makes {name}", file=sys.stderr, flush=True)
                files.wait(handle.fileno())
            handles.append(handle.fileno())
        yield handles


# tasks side by side, by processes forked from this one, which has imported what they compute with ---------------------


CAN_FORK = sys.platform.startswith("linux")
"""Whether processes may be forked: the system's own libraries on macOS do not stand it, Windows has no forks."""
_work: Callable[[Task], None]
"""What a forked process does with a task."""


def run_side_by_side(
    some: Sequence[Task], work: Callable[[Task], None], count: int, begun: Callable[[int, Collection[int]], None]
) -> None:
    """Do tasks, as many at once as there are processes; of those that can begin first what others wait for longest.

    Parameters
    ----------
    some : sequence of Task
        Each after those whose files it needs.
    work : callable
        Does a task. Its error ends the others, and is raised here.
    count : int
        Number of processes; but a second task begins only where the memory for it is free.
    begun : callable
        Called with the task that begins and those done, by their places in `some`.
    """
    chains = longest_chains(some)
    waiting = sorted(range(len(some)), key=lambda place: -chains[place])
    unmade = {path for task in some for path in task.makes}
    done: list[int] = []
    running: dict[Future[None], int] = {}
    with _processes(work, some, count) as pool:
        while waiting or running:
            for place in [place for place in waiting if unmade.isdisjoint(some[place].needs)]:
                free = len(running) < count and psutil.virtual_memory().available > 1e6 * some[place].megabytes
                if free or not running:
                    waiting.remove(place)
                    begun(place, done)
                    running[pool.submit(_do, some[place])] = place
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                future.result()
                done.append(running.pop(future))
                unmade -= {*some[done[-1]].makes}


@contextmanager
def _processes(work: Callable[[Task], None], some: Sequence[Task], count: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that do tasks; if anything ends this run, they are killed: files are written whole or not at all."""
    for stage in {task.stage for task in some}:
        function_of(stage)  # its imports, once
    context, before = multiprocessing.get_context("fork"), _children()
    pool = ProcessPoolExecutor(count, context, _begin_process, (work, os.getpid()))
    try:
        yield pool
    except BaseException as error:
        for process in _children() - before:
            process.kill()
        pool.shutdown(cancel_futures=True)
        if isinstance(error, BrokenProcessPool):
            raise VsbError(
                "a task ended without a word, as when memory is out; run the same command again to go on from here"
            ) from None
        raise
    pool.shutdown()


def _children() -> set[psutil.Process]:
    """Processes this one started."""
    return {*psutil.Process().children()}


def _begin_process(work: Callable[[Task], None], parent: int) -> None:
    """Begin in a new process: signals go to its parent, without which it ends."""
    global _work
    _work = work
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    threading.Thread(target=_end_without, args=(parent,), daemon=True).start()


def _end_without(parent: int) -> None:
    """End this process once its parent is no more."""
    while os.getppid() == parent:
        time.sleep(0.1)
    os._exit(1)


def _do(task: Task) -> None:
    """Do a task in this process."""
    _work(task)
