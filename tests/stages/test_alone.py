"""One run at a time in a results folder."""

import pytest

from vsb.errors import VsbError
from vsb.stages.alone import alone


def test_a_second_run_is_told_to_wait_and_may_begin_when_the_first_has_ended(tmp_path):
    root = tmp_path / "results"
    with alone(root) as handles:
        assert len(handles) == 1
        with pytest.raises(VsbError, match=r"results: another run is at work in this folder; wait for it to end$"):
            alone(root).__enter__()
    with alone(root):
        pass


def test_a_run_that_fails_lets_the_folder_go(tmp_path):
    with pytest.raises(ZeroDivisionError, match="mine"), alone(tmp_path):
        raise ZeroDivisionError("mine")
    with alone(tmp_path):
        pass


def test_a_dry_run_neither_waits_nor_writes(tmp_path):
    with alone(tmp_path), alone(tmp_path / "none", waits=False) as handles:
        assert handles == []
    assert not (tmp_path / "none").exists()
    with alone(tmp_path), alone(tmp_path, waits=False):
        pass
