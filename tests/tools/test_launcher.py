"""Snakemake ends when its work does, with its exit code and all it said."""

import contextlib
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest

from vsb.tools import launcher

FLOW = "rule all:\n    output: 'made.txt'\n    shell: '{how}'\n"


@pytest.mark.parametrize(("how", "code"), [("echo done > made.txt", 0), ("false", 1)])
def test_a_run_says_and_returns_what_snakemake_does(tmp_path, how, code):
    (tmp_path / "Snakefile").write_text(FLOW.format(how=how))
    command = [sys.executable, "-m", "vsb.tools.launcher", "--cores", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert (tmp_path / "made.txt").exists() == (code == 0)
    assert ("1 of 1 steps (100%) done" in done.stderr) == (code == 0)


def begun_with(monkeypatch, snakemake):
    """Put something in the place of Snakemake, in a process that goes on."""
    monkeypatch.setattr("snakemake.cli.main", snakemake)
    monkeypatch.setattr(launcher, "seldom_collected", contextlib.nullcontext)


def test_what_is_still_waiting_is_not_waited_for(monkeypatch):
    """A timer of a minute, as Snakemake leaves one of a second: the end comes first."""
    told = []

    def snakemake():
        timer = threading.Timer(60.0, print)
        timer.start()
        told.append(timer)
        print("the last word")
        raise SystemExit(3)

    begun_with(monkeypatch, snakemake)
    monkeypatch.setattr(launcher.os, "_exit", told.append)
    launcher.launch()
    told[0].cancel()
    assert told[1] == 3


@pytest.mark.parametrize(("said", "code"), [("a word", 1), (None, 0)])
def test_an_end_without_a_number_is_what_it_is_to_python(monkeypatch, said, code):
    def snakemake():
        raise SystemExit(said)

    told = []
    begun_with(monkeypatch, snakemake)
    monkeypatch.setattr(launcher.os, "_exit", told.append)
    launcher.launch()
    assert told == [code]


def test_all_that_was_said_is_written_before_the_end(monkeypatch):
    """On both streams, logs among it: a process that ends so writes nothing itself."""
    said = []
    monkeypatch.setattr("logging.shutdown", lambda: said.append("logs"))
    for name in ("stdout", "stderr"):
        monkeypatch.setattr(sys, name, SimpleNamespace(flush=lambda name=name: said.append(name), write=len))

    def snakemake():
        raise SystemExit(7)

    begun_with(monkeypatch, snakemake)
    monkeypatch.setattr(launcher.os, "_exit", said.append)
    launcher.launch()
    assert said[0] == "logs"
    assert said[-1] == 7
    assert {"stdout", "stderr"} <= set(said[1:-1])


def test_a_run_that_returns_ends_as_any_function(monkeypatch):
    begun_with(monkeypatch, lambda: None)
    monkeypatch.setattr(launcher.os, "_exit", pytest.fail)
    assert launcher.launch() is None


def test_a_mistake_of_snakemake_is_told(monkeypatch):
    def snakemake():
        raise KeyError("broken")

    begun_with(monkeypatch, snakemake)
    monkeypatch.setattr(launcher.os, "_exit", pytest.fail)
    with pytest.raises(KeyError, match="broken"):
        launcher.launch()
