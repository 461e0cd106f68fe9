"""Bounds of memory and time."""

import itertools
import signal
import sys

import numpy as np
import pytest

from vsb.tools.bounded import bounded_memory, bounded_time

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


@linux
def test_nested_memory_bounds_are_restored():
    """After an error inside, too."""
    import resource

    with bounded_memory(2**32):
        outer = resource.getrlimit(resource.RLIMIT_AS)
        with bounded_memory(2**28):
            inner = resource.getrlimit(resource.RLIMIT_AS)
        assert resource.getrlimit(resource.RLIMIT_AS) == outer
        with pytest.raises(KeyError), bounded_memory(2**28):
            raise KeyError
        assert resource.getrlimit(resource.RLIMIT_AS) == outer
    assert inner[0] < outer[0] < 2**48
    assert inner[1] == outer[1]
