"""Progress of a run on a terminal."""

import io
import re
import time

import pytest
from rich.console import Console

from vsb.tools.progress import failed, followed

TOLD = [
    "Building DAG of jobs...\n",
    "total          3\n",
    "\n",
    "1 of 3 steps (33%) done\n",
    "2 of 3 steps (67%) done\n",
]


def screen(lines, width=80):
    """All that is written on a terminal, and the last count reported."""
    out, last = io.StringIO(), []
    followed(lines, "seed", Console(file=out, force_terminal=True, width=width, color_system=None), last)
    return out.getvalue(), last


def read_slowly(lines, seconds=0.15):
    """Lines that come one after the other, so that each is seen."""
    for line in lines:
        yield line
        time.sleep(seconds)


@pytest.mark.parametrize("width", [80, 40])
def test_progress_is_one_line_that_is_erased(width):
    shown, _ = screen(read_slowly(TOLD), width)
    assert shown.count("\n") == 1, "the line is ended once, to be erased"
    assert shown.endswith("\r\x1b[1A\x1b[2K")
    lines = re.split(r"\r|\n", shown)
    assert all(len(re.sub(r"\x1b\[[?\d]*\w", "", line)) <= width for line in lines)


def test_failed_rules_are_named_with_their_logs():
    lines = [
        "Command 'set -o pipefail;  vsb simulate a.yaml FSB --out b.nc > logs/FSB.log 2>&1' returned non-zero exit status 1.\n",
        "Command ' vsb simulate a.yaml VSWEC > logs/VSWEC.log 2>&1' returned non-zero exit status 137.\n",
        "    shell: vsb report a.yaml > logs/report.log 2>&1\n",
        "Command 'vsb table a.yaml > logs/table.log 2>&1' returned non-zero exit status 2.\n",
    ]
    assert failed(lines) == {
        "logs/FSB.log": "simulate", "logs/VSWEC.log": "simulate", "logs/table.log": "table",
    }  # fmt: skip
