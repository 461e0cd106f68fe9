"""Work that a process of its own does meanwhile."""

import multiprocessing
import os
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

T = TypeVar("T")


def cores() -> int:
    """Return how many cores this process was given: what Snakemake, like OpenMP, says by OMP_NUM_THREADS."""
    given = os.environ.get("OMP_NUM_THREADS", "1")
    return int(given) if given.isdecimal() else 1


def aside(work: Callable[[], T]) -> Callable[[], T]:
    """Begin some work in a process of its own, if there is a core for it, and return what waits for its result.

    Parameters
    ----------
    work : callable
        What it gives, or raises, is handed over; what it needs, it has as it is now. Without a second core it is done
        when it is asked for, and where a copy of a running process may not be sound: elsewhere than on Linux.
    """
    if cores() < 2 or sys.platform != "linux":
        return work
    fork = multiprocessing.get_context("fork")
    receiver, sender = fork.Pipe(duplex=False)
    process = fork.Process(target=_told, args=(work, sender), daemon=True)
    process.start()
    sender.close()

    def result() -> T:
        try:
            done, found = receiver.recv()
        except EOFError:
            process.join()
            raise ChildProcessError(f"work aside ended without a result, with code {process.exitcode}") from None
        process.join()
        if not done:
            raise found
        return found  # type: ignore[no-any-return]

    return result


def _told(work: Callable[[], Any], sender: Connection) -> None:
    """Send what some work gives or raises."""
    try:
        told = (True, work())
    except Exception as error:
        told = (False, error)
    sender.send(told)
