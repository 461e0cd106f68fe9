"""Locks on files: they go with the processes that hold them, so a killed one leaves none behind."""

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform == "win32":
    import msvcrt

    _BEYOND = 1 << 30  # where nothing is written: what is locked there nobody else can read

    def take(handle: int) -> bool:
        """Take the lock of an open file, unless another process has it; return whether it is taken."""
        os.lseek(handle, _BEYOND, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            return False
        return True
else:
    import fcntl

    def take(handle: int) -> bool:
        """Take the lock of an open file, unless another process has it; return whether it is taken."""
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


def wait(handle: int, seconds: float = float("inf")) -> bool:
    """Take the lock of an open file, waiting so many seconds for it; return whether it is taken."""
    until = time.monotonic() + seconds
    while not (taken := take(handle)) and time.monotonic() < until:
        time.sleep(0.02)
    return taken


@contextmanager
def locked(path: str | Path) -> Iterator[None]:
    """Hold the lock of a file, waiting for it."""
    with Path(path).open("a") as handle:
        wait(handle.fileno())
        yield
