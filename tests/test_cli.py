import pytest

from vsb import cli
from vsb.cli import main, parser

COMMANDS = (
    "run", "check", "shell", "modes", "mesh", "display-meshes", "green", "bem", "database", "radiation", "response", "simulate",
    "compare", "figures", "report",
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
