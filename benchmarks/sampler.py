"""Where a command of vsb spends its processor time: `python benchmarks/sampler.py OUT.json COMMAND...`.

Every few milliseconds of processor time the innermost function that belongs to a part of the package says which part
is at work; all that it calls, NumPy and capytaine included, counts as its own. Nothing of vsb is imported before the
clock runs, so that imports count.
"""

import json
import signal
import sys
import time
from collections import defaultdict
from pathlib import Path
from types import FrameType

INTERVAL = 0.004
"""Of processor time, between two samples [s]."""
PARTS = {
    "importlib": "imports",
    "numba/core": "compilation",
    "vsb/engine/hydro": "hydrodynamics",
    "vsb/engine/shell": "shell",
    "vsb/models": "shell",
    "vsb/engine/integrators": "motion in time",
    "vsb/engine/motion": "motion by frequency",
    "vsb/results": "results and their intervals",
    "vsb/design": "results and their intervals",
    "vsb/engine/waves": "waves",
    "vsb/report": "page and figures",
    "vsb/stages": "files, ids, plans",
    "vsb/study": "files, ids, plans",
    "vsb/keys": "files, ids, plans",
    "vsb/pipeline": "files, ids, plans",
    "vsb/cli": "files, ids, plans",
}
"""By a piece of the path of a module, the first that fits; tools belong to what calls them."""


class Sampler:
    """Seconds of processor time by part."""

    def __init__(self) -> None:
        """Begin."""
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.before = 0.0
        signal.signal(signal.SIGPROF, self.sample)
        signal.setitimer(signal.ITIMER_PROF, INTERVAL, INTERVAL)

    def sample(self, number: int, frame: FrameType | None) -> None:
        """Give the time since the last sample to the part at work: one long call of compiled code is one sample."""
        now = time.process_time()
        self.seconds[part(frame)] += now - self.before
        self.before = now


def part(frame: FrameType | None) -> str:
    """Return the part a frame of Python or the nearest of its callers belongs to."""
    while frame:
        path = frame.f_code.co_filename
        for piece, name in PARTS.items():
            if piece in path:
                return name
        frame = frame.f_back
    return "Python itself"


def main(out: str, *command: str) -> int:
    """Run a command of vsb and write the seconds of its parts."""
    sys.dont_write_bytecode = False  # as of any installation
    sys.modules["dask"] = None  # type: ignore[assignment]  # which `vsb[spectra]` brings along, and xarray imports
    sampler = Sampler()
    from vsb.cli import main as vsb

    code = vsb(list(command))
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    sampler.sample(0, None)
    Path(out).write_text(json.dumps(sampler.seconds), encoding="utf-8")
    return code


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
