"""Progress of a run on a terminal: one line with what is done, and nothing of it when the run ends."""

import io
import re
import time
from types import SimpleNamespace

import pytest
from rich.console import Console

from vsb.tools.progress import Rate, failed, followed

TOLD = [
    "Building DAG of jobs...\n",
    "total          3\n",
    "\n",
    "1 of 3 steps (33%) done\n",
    "2 of 3 steps (67%) done\n",
]


def screen(lines, width=80):
    """All that is written on a terminal, and what is told at the end."""
    out, last = io.StringIO(), []
    followed(lines, "seed", Console(file=out, force_terminal=True, width=width, color_system=None), last)
    return out.getvalue(), last


def read_slowly(lines, seconds=0.15):
    """Lines that come one after the other, so that each is seen."""
    for line in lines:
        yield line
        time.sleep(seconds)


@pytest.mark.parametrize("width", [80, 40])
def test_it_is_one_line_that_goes(width):
    shown, _ = screen(read_slowly(TOLD), width)
    assert shown.count("\n") == 1, "the line is ended once, to be erased"
    assert shown.endswith("\r\x1b[1A\x1b[2K")
    lines = re.split(r"\r|\n", shown)
    assert all(len(re.sub(r"\x1b\[[?\d]*\w", "", line)) <= width for line in lines)


def test_it_says_what_is_done_how_fast_and_what_is_left():
    shown, _ = screen(read_slowly(TOLD))
    assert "seed" in shown
    assert "0/3 jobs" in shown
    assert re.search(r"2/3 +jobs +[\d.]+/min +0:00:\d\d left", shown)


@pytest.mark.parametrize(
    ("told", "shown"),
    [
        (TOLD[3:], "2/3 jobs"),
        ([*TOLD, "3 of 7 steps (43%) done\n"], "3/7 jobs"),
        ([*TOLD, "3 of 3 steps (100%) done\n"], "3/3 jobs"),
        (["1200 of 30000 steps (4%) done\n"], "1200/30000 jobs"),
    ],
    ids=["none", "other", "all", "many"],
)
def test_how_many_there_are_is_what_is_told_last(told, shown):
    """Also where nothing was told of it before the first was done, or jobs were added since."""
    assert shown in screen(read_slowly(told))[0]


def test_the_rate_of_what_is_done_is_that_of_all_of_it():
    task = SimpleNamespace(finished_speed=None, speed=None)
    assert str(Rate().render(task)) == ""
    task.speed = 0.5
    assert str(Rate().render(task)) == "30/min"
    task.finished_speed = 0.05
    assert str(Rate().render(task)) == "3/min"


def test_all_lines_are_handed_on():
    assert screen(TOLD)[1] == TOLD
    assert screen([])[1] == []


def test_an_interrupted_run_leaves_nothing_of_it():
    def interrupted():
        yield from read_slowly(TOLD)
        raise KeyboardInterrupt

    out = io.StringIO()
    with pytest.raises(KeyboardInterrupt):
        followed(interrupted(), "seed", Console(file=out, force_terminal=True, width=80, color_system=None), [])
    assert out.getvalue().endswith("\r\x1b[1A\x1b[2K")


def test_rules_that_failed_are_told_by_the_logs_of_their_jobs():
    """Two of one rule are two; what went well, or failed without a log, is none."""
    told = [
        "Command 'set -o pipefail;  vsb simulate a.yaml FSB --out b.nc > logs/FSB.log 2>&1' returned non-zero exit status 1.\n",
        "Command ' vsb simulate a.yaml VSWEC > logs/VSWEC.log 2>&1' returned non-zero exit status 137.\n",
        "    shell: vsb report a.yaml > logs/report.log 2>&1\n",
        "Command 'vsb table a.yaml > logs/table.log 2>&1' returned non-zero exit status 2.\n",
    ]
    assert failed(told) == {
        "logs/FSB.log": "simulate", "logs/VSWEC.log": "simulate", "logs/table.log": "table",
    }  # fmt: skip
