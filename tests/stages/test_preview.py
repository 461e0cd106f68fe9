"""Summary and checks of a study before anything is solved."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import varied

from vsb.engine.shell.modes import mode_basis
from vsb.engine.shell.shell import Shell, natural_frequencies
from vsb.errors import DatabaseError
from vsb.stages import preview


def test_check_counts_finished_work(small, tmp_path, monkeypatch):
    there = preview.summary(small)
    monkeypatch.chdir(tmp_path)
    before = preview.summary(small)
    blocks = len(small.bem_blocks)
    assert any(f"to solve     {blocks} of {blocks} blocks" in line for line in before)
    assert any(f"to solve     0 of {blocks} blocks" in line for line in there)
    assert any(line.endswith("(there)") for line in there)
    assert not any(line.endswith("(there)") for line in before)
    assert any("cross-check  none: hydro.witness: none" in line for line in there)
    assert there[0].startswith("study        small: FSB, VSWEC in ")


def test_unreadable_stored_files_are_reported_before_any_job(small, finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(finished / "results", "results")
    preview.check(small)
    for path in (small.radiation.out, small.block_path(small.sweep_blocks[0]), small.database.out):
        Path(path).write_bytes(b"none")
        with pytest.raises(DatabaseError, match=f"{path}: cannot be read as netCDF"):
            preview.check(small)


def test_natural_frequencies_are_those_of_the_closed_form(seed):
    """Membrane modes of every degree, bending modes from degree 2; membrane frequencies are higher."""
    study = varied(seed, modes={"degree": 4})
    shell, table = Shell.of(study.device), preview.shell_table(study)
    lower, upper = np.transpose([natural_frequencies(shell, n) for n in range(5)])
    assert [row["degree"] for row in table["membrane"]] == [0, 1, 2, 3, 4]
    assert [row["omega"] for row in table["membrane"]] == upper.tolist()
    assert [(row["degree"], row["omega"]) for row in table["bending"]] == [(n, lower[n]) for n in (2, 3, 4)]
    assert [row["omega"] for row in table["paper_ritz"]] == mode_basis(
        study.device, "paper", 4
    ).dry_frequencies.tolist()
    third = preview.shell_text(table).splitlines()[3].split()
    assert third == ["2", f"{upper[2]:.9f}", f"{lower[2]:.9f}", f"{table['paper_ritz'][2]['omega']:.9f}"]
