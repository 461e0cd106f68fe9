"""One run at a time in a results folder."""

import fcntl

import pytest

from vsb.errors import VsbError
from vsb.stages.alone import alone, nobody_else, sharing


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


def test_whoever_holds_all_folders_is_refused_where_one_is_held_and_lets_go_of_the_others(tmp_path):
    for name in ("a", "b"):
        with alone(tmp_path / name):
            pass
    with alone(tmp_path / "b"), pytest.raises(VsbError, match=r"b: another run is at work in this folder"):
        nobody_else(tmp_path).__enter__()
    with nobody_else(tmp_path):
        for name in ("a", "b"):
            with pytest.raises(VsbError, match=f"{name}: another run is at work in this folder"):
                alone(tmp_path / name).__enter__()
    with alone(tmp_path / "a"), alone(tmp_path / "b"):
        pass


def test_whoever_holds_the_folders_of_all_studies_holds_no_folder_above_or_within_one(tmp_path):
    with alone(tmp_path / "a"):
        pass
    with alone(tmp_path), alone(tmp_path / "a" / "inner"), nobody_else(tmp_path):
        pass


def test_who_waits_for_a_file_that_another_makes_says_so(tmp_path, monkeypatch, capsys):
    asked = []

    def flock(handle, how):
        asked.append(how)
        if how & fcntl.LOCK_NB and len(asked) == 1:
            raise BlockingIOError

    monkeypatch.setattr("vsb.stages.alone.fcntl.flock", flock)
    with sharing(tmp_path, [f"hydro/{'a' * 16}.nc", f"hydro/{'b' * 16}.nc"]) as handles:
        assert len(handles) == 2
    assert asked == [fcntl.LOCK_EX | fcntl.LOCK_NB, fcntl.LOCK_EX, fcntl.LOCK_EX | fcntl.LOCK_NB]
    assert capsys.readouterr().out == f"vsb: waiting for another run that makes {'a' * 16}\n"


def test_what_is_shared_is_held_once_in_one_order_by_the_name_of_its_file_or_folder(tmp_path, monkeypatch):
    """Two files of a folder are one; whoever holds the same waits for nobody in a circle. Without any nothing is made."""
    held = []
    monkeypatch.setattr("vsb.stages.alone._wait", lambda handle, name: held.append(name))
    first, *others, mesh = (16 * letter for letter in "0123456789abcdef")
    paths = [f"hydro/mesh/{mesh}/mean.nc", *(f"hydro/db/{name}.nc" for name in others)]
    paths.append(f"hydro/mesh/{mesh}/Membrane2_plus.vtu")
    with sharing(tmp_path, []) as handles:
        assert handles == []
    assert not list(tmp_path.iterdir())
    for given in ([*paths, f"hydro/db/{first}.nc"], [f"hydro/db/{first}.nc", *paths[::-1]]):
        held.clear()
        with sharing(tmp_path, given) as handles:
            assert len(set(handles)) == 16
        assert held == [first, *others, mesh]
    assert sorted(path.name for path in (tmp_path / "hydro" / ".locks").iterdir()) == held
