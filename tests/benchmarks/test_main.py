"""The command line of the benchmarks, and of the examples."""

from pathlib import Path

import pytest
import yaml
from conftest import SEED, told

from benchmarks.__main__ import COMMANDS, main
from examples import barge


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    assert f"python -m benchmarks {command}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("run", "command"),
    [
        (main, ["integrators", "missing.yaml", "out"]),
        (main, ["time-domain", "missing.yaml", "out"]),
        (main, ["hard-cases", "missing.yaml", "out.csv"]),
        (barge.main, ["missing.yaml", "out"]),
    ],
)
def test_a_missing_file_is_one_line_and_writes_nothing(workplace, capsys, run, command):
    assert told(command, capsys, run).startswith("missing.yaml: cannot be read")
    assert [path.name for path in workplace.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("run", "command"),
    [
        (main, ["integrators", "study.yaml", "file/out"]),
        (main, ["coefficients", "file/out"]),
        (main, ["time-domain", "study.yaml", "file/out"]),
        (main, ["hard-cases", "study.yaml", "file/out"]),
        (barge.main, ["study.yaml", "file/out"]),
    ],
)
def test_what_cannot_be_written_is_told_before_any_work(workplace, capsys, run, command):
    assert told(command, capsys, run).startswith("file/out: cannot be written (")
    assert Path("file").read_text() == "kept"


def test_a_rigid_study_has_no_integrators_to_compare(workplace, capsys):
    study = {**yaml.safe_load(SEED.read_text()), "designs": {"A": {"flexible": False}}}
    Path("rigid.yaml").write_text(yaml.safe_dump(study))
    line = told(["time-domain", "rigid.yaml", "out"], capsys, main)
    assert line.startswith("rigid.yaml: designs: received only rigid ones, A")
    assert "needs a flexible one" in line
    assert not Path("out").exists()
