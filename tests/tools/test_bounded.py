import itertools
import re
import signal
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from vsb.tools.bounded import bounded_memory, bounded_time

linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded on Linux only")


@linux
def test_what_takes_more_memory_than_it_may_is_told_so():
    with bounded_memory(2**28):
        small = np.zeros(2**20)
        with pytest.raises(MemoryError):
            np.zeros(2**28)
    assert len(np.empty(2**28)) == 2**28  # the bound is gone
    assert small.any() == 0


@linux
def test_what_a_process_takes_already_does_not_count():
    import resource

    status = Path("/proc/self/status").read_text(encoding="ascii")
    taken = int(re.search(r"VmSize:\s+(\d+) kB", status)[1]) * 1024
    with bounded_memory(2**28):
        bound = resource.getrlimit(resource.RLIMIT_AS)[0]
    with bounded_memory(2**40), bounded_memory(2**28):
        assert resource.getrlimit(resource.RLIMIT_AS)[0] == pytest.approx(bound, abs=2**24)
    assert bound == pytest.approx(taken + 2**28, abs=2**24)


@linux
def test_the_bound_is_gone_after_an_error():
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    with pytest.raises(KeyError), bounded_memory(2**30):
        raise KeyError
    assert resource.getrlimit(resource.RLIMIT_AS) == before


@linux
def test_a_bound_that_is_there_already_stays_below():
    import resource

    with bounded_memory(2**28):
        inner = resource.getrlimit(resource.RLIMIT_AS)[0]
        with bounded_memory(2**40):
            assert resource.getrlimit(resource.RLIMIT_AS)[0] == inner


def test_what_has_no_end_is_ended_and_nothing_is_left_behind():
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(TimeoutError, match=r"it takes more than 0.05 s"), bounded_time(0.05):
        sum(1 for _ in itertools.count())
    assert signal.getsignal(signal.SIGALRM) is before
    with bounded_time(60.0):
        pass  # done in time: no alarm rings later
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_in_another_thread_time_has_no_bound_but_nothing_breaks():
    done = []

    def work():
        with bounded_time(1e-9):
            done.append(sum(range(1000)))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [499500]


def test_where_there_is_no_timer_time_has_no_bound(monkeypatch):
    monkeypatch.delattr(signal, "setitimer")
    with bounded_time(1e-9):
        assert sum(range(1000)) == 499500


@linux
def test_a_bound_within_a_bound_gives_that_back():
    """Also after an error inside."""
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


def test_where_a_process_cannot_be_looked_at_memory_has_no_bound(monkeypatch):
    def unreadable(*_, **__):
        raise OSError("no /proc")

    monkeypatch.setattr(Path, "read_text", unreadable)
    with bounded_memory(-(2**40)):
        assert sum(range(1000)) == 499500


def test_an_alarm_of_before_rings_as_it_did():
    """What is done in time leaves the handler that was there, after an error too."""
    before = signal.getsignal(signal.SIGALRM)
    ours = signal.signal(signal.SIGALRM, lambda *_: None)
    try:
        known = signal.getsignal(signal.SIGALRM)
        with bounded_time(60.0):
            assert signal.getsignal(signal.SIGALRM) is not known
            assert 0 < signal.getitimer(signal.ITIMER_REAL)[0] <= 60.0
        assert signal.getsignal(signal.SIGALRM) is known
        with pytest.raises(KeyError), bounded_time(60.0):
            raise KeyError
        assert signal.getsignal(signal.SIGALRM) is known
        assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    finally:
        signal.signal(signal.SIGALRM, ours)
    assert signal.getsignal(signal.SIGALRM) is before
