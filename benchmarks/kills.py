"""Whole runs of a small campaign killed at random instants and resumed: the bytes of a run nobody disturbed.

The campaign has all a campaign can have: several members, seas in time, figures and a page. Nothing else may be left.
"""

import contextlib
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import yaml

from benchmarks.damage import STUDY, small_text
from vsb.errors import VsbError
from vsb.tools.files import ROOT, checksum, read_groups, write_text

SEAS = "Hs/Te; 5,5; 6,5; 8,5\n0,75; 10 %; 20 %; 5 %\n1,25; 5 %; 30 %; 10 %\n2,25; ; 10 %; 10 %\n"
CAMPAIGN = {
    "campaign": "killed",
    "study": STUDY,
    "vary": {"device.thickness": [0.01, 0.02]},
    "climate": {"scatter": "site.csv"},
    "tuning": ["one"],
    "verify": {"seas": 4},
}
UNTOLD = ("logs", "benchmarks")
"""What a run says of itself, times too."""


class Row(NamedTuple):
    """One kill: when, how many results were there, and what the resumed run left."""

    kill: int
    seconds: float
    there: int
    verdict: str


def write_campaign(folder: Path) -> None:
    """Write the campaign, its study and its climate into a folder."""
    write_text(folder / STUDY, small_text(20.0))
    write_text(folder / "killed.yaml", yaml.safe_dump(CAMPAIGN, sort_keys=False))
    write_text(folder / "site.csv", SEAS)


def started(folder: Path) -> "subprocess.Popen[bytes]":
    """Begin a run in a folder, in a group of its own."""
    with (folder / "run.log").open("ab") as log:
        command = [sys.executable, "-m", "vsb", "run", "killed.yaml", "--cores", "2"]
        return subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, start_new_session=True)


def finish(folder: Path) -> float:
    """Run to the end; return seconds.

    Raises
    ------
    VsbError
        If the run does not succeed.
    """
    begun = time.monotonic()
    if code := started(folder).wait():
        raise VsbError(f"kills: a run ended with {code}; see {folder / 'run.log'}")
    return time.monotonic() - begun


def killed(folder: Path, seconds: float) -> bool:
    """Begin a run and kill it, with all it started, after some seconds; False if it was over before."""
    process = started(folder)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
        return False
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return True


def contents(folder: Path) -> dict[str, str]:
    """Return what every result holds, sha256 by path: of its bytes, or of all but what its making took."""
    root = folder / "results"
    paths = (path for path in root.rglob("*") if path.is_file() and path.relative_to(root).parts[0] not in UNTOLD)
    return {path.relative_to(root).as_posix(): _digest(path) for path in paths}


def _digest(path: Path) -> str:
    """The same of one file."""
    with contextlib.suppress(VsbError):
        groups = read_groups(path) if path.suffix == ".nc" else {}
        took = {name: 0.0 for one in groups.values() for name in one.attrs if str(name).endswith("seconds")}
        if took:
            return checksum({**groups, ROOT: groups[ROOT].assign_attrs(took)})
    return hashlib.sha256(path.read_bytes()).hexdigest()


def compared(found: dict[str, str], expected: dict[str, str]) -> str:
    """Return whether results are the same, or which are not, missing, or too many."""
    parts = {
        "missing": sorted(expected.keys() - found.keys()),
        "too many": sorted(found.keys() - expected.keys()),
        "other bytes": sorted(name for name in expected.keys() & found.keys() if expected[name] != found[name]),
    }
    return "; ".join(f"{what}: {', '.join(names)}" for what, names in parts.items() if names) or "the same bytes"


def benchmark(count: int, place: str | Path) -> list[Row]:
    """Kill so many runs, resume each, and compare it with one that was not; print a row each.

    Parameters
    ----------
    count : int
    place : str or Path
        Folder of the runs; what is in it is removed.
    """
    folder, draw = Path(place).absolute(), random.Random(count)
    rows: list[Row] = []
    shutil.rmtree(folder, ignore_errors=True)
    write_campaign(folder / "whole")
    whole = finish(folder / "whole")
    expected = contents(folder / "whole")
    while len(rows) < count:
        here = folder / f"kill{len(rows)}"
        shutil.rmtree(here, ignore_errors=True)
        write_campaign(here)
        seconds = draw.uniform(0.0, whole)
        if killed(here, seconds):
            there = len(contents(here))
            finish(here)
            rows.append(Row(len(rows), seconds, there, compared(contents(here), expected)))
            print(
                f"{seconds:6.1f} of {whole:.1f} s, {there:3} of {len(expected)} files: {rows[-1].verdict}", flush=True
            )
    return rows
