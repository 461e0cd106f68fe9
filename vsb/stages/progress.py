"""Lines of a run: what begins, how much is done of all, and the time left; of a run by Snakemake from its output."""

import re
import sys
import time
from collections.abc import Callable, Collection, Iterable, MutableSequence, Sequence
from dataclasses import dataclass, field

from vsb.pipeline.costs import plain_seconds
from vsb.pipeline.jobs import RULES, Rule

BEGUN = re.compile(r"^(?:local)?rule (\w+):$")
WILDCARD = re.compile(r"^\s+wildcards: job=(.+)$")
LAST = re.compile(r"^\s+resources: ")
DONE = re.compile(r"^(\d+) of (\d+) steps \(\d+%\) done$")
FAILED = re.compile(r"\bvsb stage (\w+)\s.* > (\S+) 2>&1' returned non-zero exit status \d+")


FIRM = 10.0
"""Work after which the rate of a run counts as much as the estimate [s]: what comes first is mostly imports."""


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    name: str
    seconds: Sequence[float]  # CPU time of its parts as estimated, in their order [s]
    quiet: bool = False
    workers: int = 1  # processes that do them
    begun: float = field(default_factory=time.monotonic)

    def say(self, words: str) -> None:
        """Print a line of the run, unless it is quiet."""
        if not self.quiet:
            print(f"{self.name}: {words}", file=sys.stderr, flush=True)

    def begin(self, words: str, done: Collection[int]) -> None:
        """Say what begins, when parts in these places are done, and how long all that is left takes."""
        before = sum(self.seconds[place] for place in done)
        rate = (time.monotonic() - self.begun + FIRM / self.workers) / (before + FIRM)
        left = rate * (sum(self.seconds) - before)
        still = f", about {plain_seconds(left)} left" if left >= 1.0 else ""
        self.say(f"{len(done)} of {len(self.seconds)} done{still}; {words}")


def followed(
    lines: Iterable[str],
    progress: Progress,
    rules: Iterable[Rule],
    kept: MutableSequence[str],
    words: Callable[[], str] | None = None,
) -> None:
    """Say how far a run by Snakemake is.

    Parameters
    ----------
    lines : iterable of str
        Snakemake's output.
    progress : Progress
        With the jobs left as its parts.
    rules : iterable of Rule
    kept : sequence of str
        Receives the lines.
    words : callable, optional
        Returns what else is to be said when a job is done.
    """
    stems = {rule.name: rule.stem for rule in rules}
    name, which, done = "", "", 0
    for line in lines:
        kept.append(line)
        if found := BEGUN.match(line):
            name, which = found[1], ""
        elif found := WILDCARD.match(line):
            which = f" {found[1].strip()}"
        elif name in stems and LAST.match(line):
            progress.begin(f"{RULES[stems[name]]}{which}", range(done))
            name = ""
        elif found := DONE.match(line.strip()):
            done = min(int(found[1]), len(progress.seconds))
            if words and (said := words()):
                progress.say(said)


def failed(lines: Iterable[str]) -> dict[str, str]:
    """Return the rules that failed in the output of Snakemake, by the log file of the job."""
    return {found[2]: found[1] for line in lines if (found := FAILED.search(line))}
