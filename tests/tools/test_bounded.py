"""Bounds of memory and time."""

import gzip
import itertools
import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from vsb.cli import main
from vsb.tools.files import LARGEST, bounded_memory, bounded_time, read_bounded, read_unpacked

linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded on Linux only")


@linux
def test_memory_beyond_the_bound_raises():
    with bounded_memory(2**28):
        small = np.zeros(2**20)
        with pytest.raises(MemoryError):
            np.zeros(2**28)
    assert len(np.empty(2**28)) == 2**28  # the bound is gone
    assert small.any() == 0


def test_time_beyond_the_bound_raises():
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(TimeoutError, match=r"it takes more than 0.05 s"), bounded_time(0.05):
        sum(1 for _ in itertools.count())
    assert signal.getsignal(signal.SIGALRM) is before
    with bounded_time(60.0):
        pass  # done in time: no alarm rings later
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pipes with names")
@pytest.mark.parametrize("command", ["check", "import-wamit", "export"])
def test_a_pipe_or_a_device_in_the_place_of_a_file_is_refused_and_not_waited_for(
    tmp_path, monkeypatch, capsys, command
):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.1")
    for name in ("pipe.1", "/dev/zero"):
        link = Path("in.nc" if command == "export" else "in.1")
        link.unlink(missing_ok=True)
        link.symlink_to(name)
        given = {"check": [str(link)], "import-bemio": [str(link), "o.nc"], "import-wamit": [".", "in", "o.nc"]}
        assert main([command, *given.get(command, [str(link), "out"])]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_a_file_holds_no_more_than_it_may_packed_or_not(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"x" * 5)
    assert read_bounded(path, 5) == b"x" * 5
    with pytest.raises(OSError, match="it holds more than"):
        read_bounded(path, 4)
    path.write_bytes(gzip.compress(b"0" * (LARGEST + 1), 1))
    with pytest.raises(OSError, match="it holds more than 256 MiB"):
        read_unpacked(path)
