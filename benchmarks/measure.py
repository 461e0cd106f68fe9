"""Timing, progress and tables of the benchmarks, and the outcome of random trials."""

import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from vsb.errors import VsbError
from vsb.tools.files import write_text
from vsb.tools.tables import check_table, csv_text

Row = dict[str, Any]


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
