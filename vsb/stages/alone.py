"""One run at a time in a results folder."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vsb.errors import VsbError


@contextmanager
def alone(root: Path, *, waits: bool = True) -> Iterator[list[int]]:
    """Hold the results folder; the lock goes with the processes that hold it, so a killed run leaves none behind."""
    if not waits:  # a dry run writes nothing
        yield []
        return
    root.mkdir(parents=True, exist_ok=True)
    with (root / ".lock").open("w") as handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise VsbError(f"{root}: another run is at work in this folder; wait for it to end") from None
        yield [handle.fileno()]
