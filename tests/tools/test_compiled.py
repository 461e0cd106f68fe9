"""Compiled loops go with their sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from conftest import HERE

from vsb.hydro.database import index_text
from vsb.tools import compiled
from vsb.tools.compiled import sources_id


def test_an_edited_force_reaches_the_loops_that_call_it(tmp_path):
    """A loop of `vsb.integrators.exponential_steps` holds what it calls from `vsb.motion.wetted`: it must not outlive an edit there.

    In a copy of the package, with a force and a loop that compile in no time.
    """
    shutil.copytree(HERE.parent / "vsb", tmp_path / "vsb", ignore=shutil.ignore_patterns("__pycache__"))
    force, loop = tmp_path / "vsb" / "motion" / "wetted.py", tmp_path / "vsb" / "integrators" / "exponential_steps.py"
    compiled = "\n\n@njit(cache=True)\ndef {}():\n    return {}\n"
    text = force.read_text()
    loop.write_text(
        loop.read_text() + "\nfrom vsb.motion.wetted import a_force\n" + compiled.format("a_loop", "a_force()")
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    found = []
    for value in ("1.0", "2.0"):
        force.write_text(text + compiled.format("a_force", value))
        command = [sys.executable, "-c", "from vsb.integrators.exponential_steps import a_loop; print(a_loop())"]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        found.append(done.stdout.strip())
    assert found == ["1.0", "2.0"]


def test_folders_mean_the_same_in_whatever_order_they_are_listed(tmp_path, monkeypatch):
    """The id of compiled sources, the index of databases: file systems list as they like."""
    for name in ("b.py", "a.py", "z.nc", "c.nc"):
        (tmp_path / name).write_text(f"@njit {name}")
    found = sources_id(tmp_path), index_text(tmp_path)
    listed = {way: getattr(Path, way) for way in ("glob", "rglob")}
    for turned in (False, True):
        for way, known in listed.items():
            monkeypatch.setattr(
                Path, way, lambda self, text, known=known, turned=turned: sorted(known(self, text), reverse=turned)
            )
        assert (sources_id(tmp_path), index_text(tmp_path)) == found


def test_compiled_loops_go_to_the_first_place_that_can_be_written(tmp_path, monkeypatch):
    """Not where no folder can be made, nor where there is one that may only be read."""
    (tmp_path / "file").touch()
    places = [tmp_path / "file", tmp_path / "read", tmp_path / "written", tmp_path / "never"]
    monkeypatch.setattr(compiled, "_places", lambda: iter(places))
    monkeypatch.setattr(compiled.os, "access", lambda path, mode: mode == os.W_OK and path.parent != places[1])
    assert compiled.cache_folder() == places[2] / f"numba-{sources_id(compiled.HERE)}"
    assert not places[3].exists()


def test_places_of_compiled_loops_best_first(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "named"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(compiled.tempfile, "mkdtemp", lambda prefix: str(tmp_path / f"{prefix}new"))
    rest = [compiled.HERE / "__pycache__", tmp_path / "home" / "vsb", tmp_path / "vsb-new"]
    assert list(compiled._places()) == [tmp_path / "named", *rest]
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    assert list(compiled._places()) == rest


def test_only_sources_that_hold_loops_tell_one_state_from_another(tmp_path):
    """In whatever folder below; an edit elsewhere compiles nothing anew."""
    (tmp_path / "inner" / "deep").mkdir(parents=True)
    texts = {"a.py": "@njit one", "inner/b.py": "@njit two", "inner/deep/c.py": "@njit three", "d.py": "plain"}

    def identity(**changes):
        for name, text in {**texts, **changes}.items():
            (tmp_path / name).write_text(text)
        return sources_id(tmp_path)

    known = identity()
    assert len(known) == 16
    assert set(known) <= set("0123456789abcdef")
    assert identity(**{"d.py": "edited"}) == known
    for name in ("a.py", "inner/b.py", "inner/deep/c.py"):
        assert identity(**{name: f"{texts[name]}!"}) != known
    assert identity(**{"d.py": "@njit new"}) != known
    assert identity(**{"a.py": "@njit two", "inner/b.py": "@njit one"}) != known
