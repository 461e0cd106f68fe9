"""Work in a subprocess."""

import os
import sys

import pytest

from vsb.tools.aside import aside

LINUX = sys.platform == "linux"


@pytest.mark.parametrize("given", ["1", "2"])
def test_result_is_the_same_in_a_subprocess(monkeypatch, given):
    """A subprocess if there is a second core for it."""
    monkeypatch.setenv("OMP_NUM_THREADS", given)
    numbers = [1, 2, 3]
    begun = aside(lambda: (os.getpid(), sum(numbers)))
    numbers.append(4)  # it was begun with what there was
    worker, total = begun()
    own = given == "2" and LINUX
    assert (worker != os.getpid(), total) == ((True, 6) if own else (False, 10))


@pytest.mark.parametrize("given", ["1", "2"])
def test_error_is_raised_where_the_result_is_needed(monkeypatch, given):
    monkeypatch.setenv("OMP_NUM_THREADS", given)

    def wrong():
        raise ValueError("no such figure")

    result = aside(wrong)
    with pytest.raises(ValueError, match="no such figure"):
        result()


@pytest.mark.skipif(not LINUX, reason="work is done aside on Linux alone")
def test_killed_subprocess_is_reported(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    result = aside(lambda: os._exit(3))
    with pytest.raises(ChildProcessError, match="ended without a result, with code 3"):
        result()
