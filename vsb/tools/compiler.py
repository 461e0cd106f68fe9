"""Where compiled loops are kept between runs: a folder of its own for every state of their sources.

A compiled loop holds what it calls from other files, and numba looks at its own file alone: kept beside the source, a
loop would go on with the old force after `vsb.engine.motion.wetted` was edited. The jobs of a first run need the same
loops at the same time: one process compiles them, the others wait for it.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache

from vsb.tools.files import wait

HERE = Path(__file__).parents[1]
PATIENCE = 120.0
"""How long a process waits for another one that compiles, before it does so itself [s]."""


def sources_id(folder: Path) -> str:
    """Return 16 hex digits of sha256 over the sources in a folder that hold compiled loops."""
    texts = [path.read_bytes() for path in sorted(folder.rglob("*.py"))]
    return hashlib.sha256(b"\0".join(text for text in texts if b"@njit" in text)).hexdigest()[:16]


def _places() -> Iterator[Path]:
    """Folders to keep compiled loops in, best first."""
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(named)
    yield HERE / "__pycache__"
    yield Path(os.environ.get("XDG_CACHE_HOME", Path("~/.cache").expanduser())) / "vsb"
    yield Path(tempfile.mkdtemp(prefix="vsb-"))  # an install and a home one may only read: compiled anew


def cache_folder() -> Path:
    """Return the first folder that can be written, named by the sources."""
    for place in _places():
        folder = place / f"numba-{sources_id(HERE)}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    raise AssertionError("unreachable: a new temporary folder can be written")


FOLDER = cache_folder()
numba.config.CACHE_DIR = str(FOLDER)


class _Turn:
    """One process at a time; what compiles within a compilation has the turn already."""

    depth = 0
    lock = -1

    def begin(self) -> None:
        """Wait until no other process compiles, or for `PATIENCE`; where files cannot be locked, not at all."""
        self.depth += 1
        if self.depth == 1:
            with suppress(OSError):
                self.lock = os.open(FOLDER / ".lock", os.O_CREAT | os.O_WRONLY)
                wait(self.lock, PATIENCE)

    def end(self) -> None:
        """Let the next process compile."""
        self.depth -= 1
        if self.depth == 0:
            with suppress(OSError):
                os.close(self.lock)
            self.lock = -1  # its number may soon be another file's


_TURN = _Turn()


class _Cache(FunctionCache):  # type: ignore[misc]
    """Compiled loops in files; what is in none is compiled in turn."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a compiled loop, or None: it is to be compiled now, and then kept by `save_overload`."""
        found = super().load_overload(sig, target_context)
        if found is None:
            _TURN.begin()  # another process may compile it meanwhile
            found = super().load_overload(sig, target_context)
            if found is not None:
                _TURN.end()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a loop that was compiled."""
        try:
            super().save_overload(sig, data)
        finally:
            _TURN.end()


def compiled(function: Callable[..., Any], **options: Any) -> Any:
    """Return a loop compiled by numba with these options, and kept between runs."""
    loop: Any = numba.njit(**options)(function)
    loop._cache = _Cache(function)
    return loop
