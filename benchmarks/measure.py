"""Timing, progress and tables of the benchmarks, and the outcome of random trials."""

import os
import subprocess
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from vsb.errors import VsbError
from vsb.tools.files import write_text
from vsb.tools.stamps import check_table
from vsb.tools.words import csv_text

Row = dict[str, Any]
CONFIG = Path(__file__).parents[1] / "config"


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the seconds a processor works on something, and what comes out."""
    begun = time.process_time()
    found = work()
    return time.process_time() - begun, found


def say(line: str) -> None:
    """Print progress, on a terminal only."""
    if sys.stderr.isatty():
        print(line, file=sys.stderr, flush=True)


def as_csv(rows: Sequence[Row], columns: Sequence[str]) -> str:
    """Return the table as CSV; an empty cell is a quantity that does not exist, such as the error of a failed run."""
    return csv_text(columns, ([row.get(name) for name in columns] for row in rows), 6)


def written(file: str, changed: Mapping[str, object], folder: str) -> str:
    """Write a file of config/ with some keys changed, None to leave one out, as one.yaml; return the name in it."""
    data = yaml.safe_load((CONFIG / file).read_text(encoding="utf-8")) | dict(changed)
    name = str(data.get("design") or data.get("campaign") or data["study"])
    if data["study"] != name:
        data["study"] = str(CONFIG / data["study"])
        data["climate"] = {kind: str(CONFIG / path) for kind, path in data["climate"].items()}
    kept = {key: value for key, value in data.items() if value is not None}
    write_text(Path(folder, "one.yaml"), yaml.safe_dump(kept))
    return name


def on_one_core() -> None:
    """Keep this process and those it starts on one core, where the system can: a run then stays in one process."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def run_python(folder: str, *words: str) -> None:
    """Run Python in a folder; raise `VsbError` unless it ends with 0, or with 1 as a study in doubt does."""
    done = subprocess.run([sys.executable, *words], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise VsbError(done.stderr)


def seconds_at(rows: Sequence[Row], method: str, error: float) -> tuple[float, bool]:
    """Return the seconds in which a method reaches an error, and whether its coarsest run is better already.

    Interpolated on logarithmic scales between its runs, never extrapolated: infinite if no run reaches the error.
    """
    done = sorted((r["seconds"], r["error"]) for r in rows if r["method"] == method and r.get("error") is not None)
    seconds, errors = np.log(np.array(done).reshape(-1, 2)).T
    reached = np.flatnonzero(errors <= np.log(error))
    if not reached.size:
        return np.inf, False
    if (i := int(reached[0])) == 0:
        return float(np.exp(seconds[0])), bool(done[0][1] < error)
    return float(np.exp(np.interp(np.log(error), errors[[i, i - 1]], seconds[[i, i - 1]]))), False


class Outcome(NamedTuple):
    """Outcome of a random trial."""

    verdict: str
    reason: str

    @classmethod
    def of(cls, error: Exception, verdict: str, lines: int = 1) -> "Outcome":
        """Return the verdict on an exception: it should be an error of ours with a message of so many lines."""
        if not isinstance(error, VsbError):
            return cls("traceback", " | ".join("".join(traceback.format_exception(error)).strip().splitlines()[-3:]))
        message = str(error)
        return cls("long message" if len(message) > 1000 or message.count("\n") >= lines else verdict, message)


def tabulated(
    fates: Iterable[tuple[tuple[object, ...], Outcome]], columns: Sequence[str], bad: Sequence[str], out: str
) -> Counter[str]:
    """Write the outcome of every trial as a table, print bad ones at once; return the count of each bad verdict."""
    found: Counter[str] = Counter()
    rows = []
    head = (*columns, "verdict", "reason")
    check_table(out, head)
    for tried, (verdict, reason) in fates:
        found[verdict] += 1
        rows.append((*tried, verdict, reason.replace("\n", " ")))
        if verdict in bad:
            print(f"{', '.join(map(str, tried))}: {verdict}: {reason[:400]}", flush=True)
    write_text(out, csv_text(head, rows))
    print(", ".join(f"{number} {verdict}" for verdict, number in found.most_common()))
    return Counter({verdict: number for verdict, number in found.items() if verdict in bad})
