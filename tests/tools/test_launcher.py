"""Snakemake ends with its exit code when its work is done."""

import subprocess
import sys

import pytest

FLOW = "rule all:\n    output: 'made.txt'\n    shell: '{how}'\n"


@pytest.mark.parametrize(("how", "code"), [("echo done > made.txt", 0), ("false", 1)])
def test_exit_code_and_output_of_snakemake(tmp_path, how, code):
    (tmp_path / "Snakefile").write_text(FLOW.format(how=how))
    command = [sys.executable, "-m", "vsb.tools.launcher", "--cores", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert (tmp_path / "made.txt").exists() == (code == 0)
    assert ("1 of 1 steps (100%) done" in done.stderr) == (code == 0)
