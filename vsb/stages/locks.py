"""One run at a time of a study, and of what makes a file that studies share: other studies run side by side."""

import os
import socket
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from vsb.errors import VsbError
from vsb.keys.quantities import id_in
from vsb.tools.files import take, wait

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
        if not take(handle.fileno()):
            raise VsbError(f"{folder}: another run is at work in this folder{_holder(folder)}; wait for it to end")
        handle.truncate(0)
        handle.write(f"process {os.getpid()} on {socket.gethostname()}")
        handle.flush()
        yield [handle.fileno()]


def _holder(folder: Path) -> str:
    """Which process holds a folder, if it has said so."""
    said = (folder / ".lock").read_text(encoding="utf-8")
    return f" ({said})" if said else ""


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
            _wait(handle.fileno(), name)
            handles.append(handle.fileno())
        yield handles


def _wait(handle: int, name: str) -> None:
    """Take a lock; if it is another's for long, say so."""
    if not wait(handle, PATIENCE):
        print(f"vsb: waiting for another run or task that makes {name}", file=sys.stderr, flush=True)
        wait(handle)
