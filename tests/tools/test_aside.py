"""Work that a process of its own does meanwhile."""

import os
import sys

import pytest

from vsb.tools.aside import aside, cores

LINUX = sys.platform == "linux"


@pytest.mark.parametrize(("given", "expected"), [("4", 4), ("2", 2), ("1", 1), ("", 1), ("2,3", 1), ("-1", 1)])
def test_cores_are_what_the_environment_says(monkeypatch, given, expected):
    monkeypatch.setenv("OMP_NUM_THREADS", given)
    assert cores() == expected


def test_without_a_word_there_is_one_core(monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    assert cores() == 1


@pytest.mark.parametrize("given", ["1", "2"])
def test_work_gives_the_same_aside_and_here(monkeypatch, given):
    """By a process of its own if there is a core for it; what it needs it has from here, nothing is packed."""
    monkeypatch.setenv("OMP_NUM_THREADS", given)
    numbers = [1, 2, 3]
    begun = aside(lambda: (os.getpid(), sum(numbers)))
    numbers.append(4)  # it was begun with what there was
    worker, total = begun()
    own = given == "2" and LINUX
    assert (worker != os.getpid(), total) == ((True, 6) if own else (False, 10))


def test_where_no_copy_of_a_process_is_sound_work_is_done_when_it_is_asked_for(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.setattr(sys, "platform", "darwin")
    assert aside(os.getpid)() == os.getpid()


@pytest.mark.parametrize("given", ["1", "2"])
def test_a_mistake_aside_is_raised_where_its_result_is_asked_for(monkeypatch, given):
    monkeypatch.setenv("OMP_NUM_THREADS", given)

    def wrong():
        raise ValueError("no such figure")

    result = aside(wrong)
    with pytest.raises(ValueError, match="no such figure"):
        result()


@pytest.mark.skipif(not LINUX, reason="work is done aside on Linux alone")
def test_work_that_is_killed_is_told(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    result = aside(lambda: os._exit(3))
    with pytest.raises(ChildProcessError, match="ended without a result, with code 3"):
        result()


@pytest.mark.skipif(not LINUX, reason="work is done aside on Linux alone")
@pytest.mark.parametrize("mistake", [KeyError("a"), OSError("no space"), RuntimeError("odd")])
def test_any_mistake_aside_is_raised_as_what_it_is(monkeypatch, mistake):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")

    def wrong():
        raise mistake

    with pytest.raises(type(mistake)) as told:
        aside(wrong)()
    assert told.value.args == mistake.args


@pytest.mark.skipif(not LINUX, reason="work is done aside on Linux alone")
def test_what_is_found_aside_may_be_nothing_and_several_go_on_at_a_time(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    begun = [aside(lambda k=k: None if k == 1 else (os.getpid(), k)) for k in range(3)]
    first, nothing, last = (result() for result in begun)
    assert nothing is None
    assert (first[1], last[1]) == (0, 2)
    assert len({os.getpid(), first[0], last[0]}) == 3
