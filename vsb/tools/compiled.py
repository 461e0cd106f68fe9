"""Where compiled loops are kept between runs: a folder of its own for every state of their sources.

A compiled loop holds what it calls from other files, and numba looks at its own file alone: kept beside the source, a
loop would go on with the old force after `vsb.motion.wetted` was edited. Import `njit` from here. What one loop alone
calls has `inline="always"`: else it is compiled by itself and once more within the loop.
"""

import hashlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from numba import config, njit

__all__ = ["njit"]
HERE = Path(__file__).parents[1]


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


config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]
