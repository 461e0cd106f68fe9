"""Tasks side by side, locks and stamps."""

import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

from vsb.errors import ConfigError, VsbError
from vsb.pipeline.graph import Task
from vsb.stages.stage import exclusive_lock, run_side_by_side, shared_lock
from vsb.tools import files


def test_second_run_in_a_folder_is_refused_until_the_first_ends(tmp_path):
    root = tmp_path / "results"
    with exclusive_lock(root) as handles:
        assert len(handles) == 1
        with pytest.raises(
            VsbError,
            match=rf"results: another run is at work in this folder \(process {os.getpid()} on .+\); wait for it to end$",
        ):
            exclusive_lock(root).__enter__()
    with exclusive_lock(root):
        pass


def test_every_shared_file_of_a_task_is_held_until_it_is_done(tmp_path):
    """Also those of one folder, once."""
    names = [f"{16 * digit}" for digit in "0ab"]
    paths = [f"hydro/blocks/{names[2]}.nc", f"hydro/blocks/{names[0]}.nc", *(f"mesh/{names[1]}/{end}" for end in "xy")]

    def free():
        found = {}
        for path in (path for path in tmp_path.rglob("*") if path.is_file()):
            with path.open() as handle:
                found[path.name] = files.take(handle.fileno())
        return found

    with shared_lock(tmp_path, paths) as handles:
        assert len(handles) == 3
        assert free() == dict.fromkeys(names, False)
    assert free() == dict.fromkeys(names, True)


def some(*chain):
    """Tasks by name, each with the names it needs."""
    return [Task("modes", {}, {}, (name,), tuple(needs)) for name, *needs in chain]


def test_each_begins_after_what_it_needs_and_all_are_done(tmp_path):
    tasks = some("a", "b", "cab", "dc", "e")
    lines = []

    def work(task):
        assert all((tmp_path / name).exists() for name in task.needs)
        (tmp_path / task.makes[0]).write_text(str(os.getpid()))

    run_side_by_side(tasks, work, 2, lambda place, done: lines.append((place, len(done))))
    assert {path.name for path in tmp_path.iterdir()} == set("abcde")
    assert str(os.getpid()) not in {path.read_text() for path in tmp_path.iterdir()}
    assert sorted(place for place, _ in lines) == [0, 1, 2, 3, 4]
    assert dict(lines)[3] >= 3  # d begins when a, b and c are done


def test_an_error_of_one_ends_all_and_is_raised(tmp_path):
    def work(task):
        if task.makes == ("a",):
            raise ConfigError("study.yaml: pto: received x, needs y")
        time.sleep(60.0)

    begun = time.monotonic()
    with pytest.raises(ConfigError, match=r"study\.yaml: pto: received x") as caught:
        run_side_by_side(some("b", "a"), work, 2, lambda *_: None)
    assert caught.value.mistakes == ("study.yaml: pto: received x, needs y",)
    assert time.monotonic() - begun < 30.0
    assert not psutil.Process().children()


def test_a_task_that_is_killed_is_reported():
    """The system's killer of what takes too much memory leaves no other trace."""
    with pytest.raises(VsbError, match="ended without a word, as when memory is out"):
        run_side_by_side(some("a", "b"), lambda _: os.kill(os.getpid(), signal.SIGKILL), 2, lambda *_: None)


def test_an_interrupt_ends_all():
    def begun(place, _):
        if place == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_side_by_side(some("a", "b"), lambda _: time.sleep(60.0), 2, begun)
    assert not psutil.Process().children()


def test_no_process_outlives_a_run_that_is_killed(tmp_path):
    program = f"""
import os, pathlib, time
from vsb.pipeline.graph import Task
from vsb.stages.stage import run_side_by_side
def work(task):
    pathlib.Path({str(tmp_path)!r}, task.makes[0]).write_text(str(os.getpid()))
    time.sleep(600.0)
run_side_by_side([Task("modes", None, {{}}, (name,)) for name in "ab"], work, 2, lambda *_: None)
"""
    run = subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.DEVNULL)
    files = [tmp_path / name for name in "ab"]
    while not all(path.exists() and path.read_text() for path in files):
        assert run.poll() is None
        time.sleep(0.05)
    workers = [int(path.read_text()) for path in files]
    run.kill()
    run.wait(30.0)
    _, alive = psutil.wait_procs([psutil.Process(pid) for pid in workers if psutil.pid_exists(pid)], timeout=30.0)
    assert not alive
