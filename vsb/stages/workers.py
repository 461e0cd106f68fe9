"""Tasks side by side, by processes forked from this one, which has imported what they compute with."""

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

import psutil

from vsb.errors import VsbError
from vsb.pipeline.graph import Task
from vsb.pipeline.jobs import longest_chains
from vsb.stages.stage import function_of

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
