"""A run's progress as one line of a terminal: jobs done, their rate, and the time left."""

import re
from collections.abc import Callable, Iterable, MutableSequence

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

TOTAL = re.compile(r"^total\s+(\d+)$")
DONE = re.compile(r"^(\d+) of (\d+) steps \(\d+%\) done$")
FAILED = re.compile(r"\bvsb (\w+)\s.* > (\S+) 2>&1' returned non-zero exit status \d+")
REMEMBERED = 600.0
"""Time over which the rate is averaged [s]."""


class Rate(TextColumn):
    """Jobs per minute."""

    def __init__(self) -> None:
        super().__init__("")

    def render(self, task: Task) -> Text:
        """Return the rate, nothing while none is known."""
        speed = task.finished_speed or task.speed
        return Text(f"{60 * speed:.3g}/min" if speed else "")


def followed(
    lines: Iterable[str],
    name: str,
    console: Console,
    last: MutableSequence[str],
    said: Callable[[], str] | None = None,
) -> None:
    """Show the progress of Snakemake as one line, erased when the run ends.

    Parameters
    ----------
    name : str
        Of the study or campaign.
    console : Console
        A terminal.
    last : sequence of str
        Receives the lines, for error messages.
    said : callable, optional
        Returns what else is to be shown, asked whenever a line comes.
    """
    columns = (
        TextColumn("{task.description}"), BarColumn(bar_width=20), MofNCompleteColumn(), TextColumn("jobs"), Rate(),
        TimeRemainingColumn(), TextColumn("left"), TextColumn("{task.fields[said]}"),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, speed_estimate_period=REMEMBERED) as progress:
        task = progress.add_task(name, total=None, said="")
        for line in lines:
            last.append(line)
            if found := DONE.match(line.strip()):
                progress.update(task, completed=int(found[1]), total=int(found[2]))
            elif found := TOTAL.match(line.strip()):
                progress.update(task, total=int(found[1]))
            if said:
                progress.update(task, said=said())


def failed(lines: Iterable[str]) -> dict[str, str]:
    """Return the rules that failed in the output of Snakemake, by the log file of the job."""
    return {found[2]: found[1] for line in lines if (found := FAILED.search(line))}
