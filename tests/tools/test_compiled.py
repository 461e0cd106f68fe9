"""Compiled loops follow their sources."""

import os
import shutil
import subprocess
import sys

import pytest
from conftest import HERE

from vsb.tools.compiler import sources_id


@pytest.mark.slow
def test_edited_force_reaches_the_loops_that_call_it_and_one_of_two_processes_compiles(tmp_path):
    """In a copy of the package, with a force and a loop that compile quickly; each process prints what it compiled."""
    shutil.copytree(HERE.parent / "vsb", tmp_path / "vsb", ignore=shutil.ignore_patterns("__pycache__"))
    engine = tmp_path / "vsb" / "engine"
    force, loop = engine / "motion" / "wetted.py", engine / "integrators" / "exponential.py"
    compiled = "\n\n@njit(cache=True)\ndef {}():\n    return {}\n"
    text = force.read_text()
    loop.write_text(
        loop.read_text() + "\nfrom vsb.engine.motion.wetted import a_force\n" + compiled.format("a_loop", "a_force()")
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    found = []
    for value in ("1.0", "2.0"):
        force.write_text(text + compiled.format("a_force", value))
        code = (
            "from vsb.engine.integrators.exponential import a_loop; print(a_loop(), a_loop.stats.cache_misses.total())"
        )
        command = [sys.executable, "-c", code]
        both = [subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE) for _ in range(2)]
        found.append(sorted(process.communicate()[0].decode().strip() for process in both))
    assert found == [["1.0 0", "1.0 1"], ["2.0 0", "2.0 1"]]


def test_cache_depends_on_sources_with_compiled_loops_only(tmp_path):
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
