from pathlib import Path

import pytest
import yaml

from vsb import cli
from vsb.cli import main, parser

COMMANDS = (
    "run", "check", "shell", "modes", "mesh", "display-meshes", "green", "bem", "database", "radiation", "response", "simulate",
    "compare", "figures", "report", "spectral", "workprecision", "body", "barge", "time-precision", "hydro-precision", "shape-dependence",
    "hard-cases", "export", "import-wamit",
)  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    assert command in capsys.readouterr().out


def test_a_users_mistake_is_one_line_and_two(capsys, tmp_path):
    for arguments in (["run", "nowhere.yaml"], ["check", "nowhere.yaml"], ["shell", "nowhere.yaml"]):
        assert main(arguments) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        assert captured.err.startswith("vsb: error: nowhere.yaml: cannot be read")
        assert captured.err.count("\n") == 1


def test_missing_input_of_a_rule_is_one_line(capsys):
    spec = '{"database":"x","tolerance":0.001}'
    assert main(["radiation", "--spec", spec, "--database", "no.nc", "--out", "out.nc"]) == 2
    assert (
        capsys.readouterr().err == "vsb: error: no.nc: file not found; run the rule that makes it (vsb run CONFIG).\n"
    )


def test_unknown_command_is_two():
    with pytest.raises(SystemExit) as stop:
        parser().parse_args(["simulat"])
    assert stop.value.code == 2


def test_interruption_says_how_to_go_on(monkeypatch, capsys):
    def interrupted(path):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "load", interrupted)
    assert main(["check", "any.yaml"]) == 130
    assert "run the same command again" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command",
    [
        ["body", "missing.yaml", "out"], ["barge", "missing.yaml", "out"], ["time-precision", "missing.yaml", "out"],
        ["shape-dependence", "missing.yaml", "out"],
    ],
)  # fmt: skip
def test_a_missing_file_of_any_command_is_one_line_and_writes_nothing(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(command) == 2
    err = capsys.readouterr().err
    assert err.startswith("vsb: error: missing.yaml: cannot be read")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_rigid_study_has_no_integrators_to_compare(tmp_path, capsys):
    study = {**yaml.safe_load(Path("config/seed.yaml").read_text()), "designs": {"FSB": {"flexible": False}}}
    (tmp_path / "rigid.yaml").write_text(yaml.safe_dump(study))
    assert main(["time-precision", str(tmp_path / "rigid.yaml"), str(tmp_path / "out")]) == 2
    assert "needs a flexible one" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
