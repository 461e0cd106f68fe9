import json
import subprocess
from pathlib import Path

import pytest
import yaml
from conftest import SEED

from vsb import cli
from vsb.cli import main, parser

COMMANDS = (
    "run", "check", "shell", "modes", "mesh", "display-meshes", "green", "bem", "database", "radiation", "response", "simulate",
    "compare", "figures", "report", "spectral", "workprecision", "body", "barge", "time-precision", "hydro-precision", "shape-dependence",
    "hard-cases", "export", "import-wamit", "import-bemio",
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


def told(arguments, capsys):
    """The one line a mistake is told in, after nothing was printed."""
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err.removeprefix("vsb: error: ").removesuffix("\n")


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """An empty current folder with a file in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("kept")
    return tmp_path


def written(name, **changes):
    """A copy of the seed study with some sections updated."""
    raw = yaml.safe_load(SEED.read_text())
    for section, update in changes.items():
        raw[section] = {**raw[section], **update} if section in ("hydro", "water") else update
    Path(name).write_text(yaml.safe_dump(raw))
    return name


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"hydro": {"omega_max": 20.0}}, "hydro.omega_max: received 20 rad/s, needs at most"),
        ({"hydro": {"tolerance": 1e-5, "solver": "panels"}}, "hydro.tolerance: received 1e-05, needs at least"),
        ({"hydro": {"omega": [1e-9], "solver": "panels"}}, "hydro.omega: received 1e-09 rad/s, needs at least"),
        ({"waves": [{"kind": "regular", "amplitude": 1, "period": 1e6}]}, "waves.0.period: received 1e+06 s"),
        ({"reference_shape": "equilibrium"}, "reference_shape: received 'equilibrium', but the shell buckles"),
        ({"hydro": {"accept": ["nonsense"]}}, "study: hydro.accept ['nonsense']: no such check; needs some of"),
    ],
)
@pytest.mark.parametrize("name", ["study.yaml", "sp ace/ünï.yaml"])
def test_a_mistake_of_the_plan_names_the_study_file_once(workplace, capsys, changes, message, name):
    Path(name).parent.mkdir(exist_ok=True)
    for command in ("check", "run"):
        line = told([command, written(name, **changes)], capsys)
        assert line.startswith(f"{name}: {message}")
        assert line.count(name) == 1


def test_a_mistake_of_another_command_names_its_file_once(workplace, capsys):
    shallow = written("shallow.yaml", water={"depth": 30.0})
    line = told(["shape-dependence", shallow, "out"], capsys)
    assert line == "shallow.yaml: water.depth: received 30 m; shape dependence needs deep water, .inf"
    rigid = written("rigid.yaml", designs={"A": {"flexible": False}})
    assert told(["time-precision", rigid, "out"], capsys).startswith("rigid.yaml: designs: received only rigid ones, A")
    Path("body.yaml").write_text("{body: b, mesh: none.stl, modes: none.nc, omega: [1.0]}")
    assert told(["body", "body.yaml", "out"], capsys).startswith("body.yaml: none.stl: mesh not found")
    assert told(["export", written("study.yaml"), "out"], capsys).startswith("results/hydro/db/")  # not of the study
    assert not {"out", "out.shapes", "results"} & {path.name for path in workplace.iterdir()}


LONG = [
    ["export", "study.yaml"], ["time-precision", "study.yaml"], ["hydro-precision"], ["body", "study.yaml"],
    ["barge", "study.yaml"], ["shape-dependence", "study.yaml"], ["hard-cases", "study.yaml"],
]  # fmt: skip


@pytest.mark.parametrize("command", LONG, ids=lambda command: command[0])
def test_what_cannot_be_written_is_told_before_any_work(workplace, capsys, command):
    line = told([*command, "file/out"], capsys)
    assert line.startswith("file/out")
    assert "cannot be written" in line
    assert f"{workplace / 'file'} is no folder); needs" in line
    assert [path.name for path in workplace.iterdir()] == ["file"]
    assert Path("file").read_text() == "kept"


@pytest.mark.parametrize("command", [["shape-dependence", "study.yaml", "a"], ["hard-cases", "study.yaml", "a.nc"]])
def test_a_folder_in_place_of_a_result_is_told_before_any_work(workplace, capsys, command):
    (workplace / "a.nc").mkdir()
    line = told(command, capsys)
    assert line.startswith("a.nc: cannot be written (it is a folder or a device); needs a file in a folder")


def test_a_result_of_a_rule_that_cannot_be_written_is_one_line(workplace, capsys):
    raw = yaml.safe_load(SEED.read_text())
    spec = json.dumps({key: raw[key] for key in ("device", "modes")})
    (workplace / "folder").mkdir()
    for out in ("folder", "file/modes.nc"):
        assert told(["modes", "--spec", spec, "--out", out], capsys).startswith(f"{out}: cannot be written (")
    assert sorted(path.name for path in workplace.rglob("*")) == ["file", "folder"]


def test_a_results_folder_that_is_none_is_told_before_any_work(workplace, capsys):
    (workplace / "results").write_text("kept")
    assert told(["run", written("study.yaml")], capsys).startswith("results: cannot be written (")
    assert (workplace / "results").read_text() == "kept"
    assert {path.name for path in workplace.iterdir()} == {"file", "results", "study.yaml"}


def test_a_file_that_cannot_be_used_is_one_line(workplace, capsys):
    arguments = ["--modes", "m.nc", "--out", "out", "t.nc"]
    line = told(["figures", "--study", "none.json", *arguments], capsys)
    assert line == "none.json: cannot be read or written (No such file or directory); needs a path you may use"


def test_an_error_of_no_file_is_not_the_users(monkeypatch):
    def exhausted(path):
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(cli, "load", exhausted)
    with pytest.raises(OSError, match="Too many open files"):
        main(["check", "any.yaml"])


@pytest.mark.parametrize(
    ("spec", "message"),
    [("{", "--spec: not valid JSON (Expecting property name"), ("[1]", "--spec: received [1], needs a mapping")],
)
def test_a_spec_that_is_none_is_one_line(workplace, capsys, spec, message):
    assert told(["modes", "--spec", spec, "--out", "out.nc"], capsys).startswith(message)


@pytest.mark.parametrize("cores", ["0", "-3", "x", "1.5", ""])
def test_a_run_without_cores_would_wait_for_ever(workplace, capsys, cores):
    with pytest.raises(SystemExit) as stop:
        main(["run", written("study.yaml"), f"--cores={cores}"])
    assert stop.value.code == 2
    assert f"argument --cores/-c: received {cores}, needs a whole number above 0, or all" in capsys.readouterr().err


def test_cores_go_to_snakemake(workplace, monkeypatch):
    seen = []

    class Done:
        returncode = 0

    monkeypatch.setattr(subprocess, "run", lambda command, **_: seen.append(command) or Done)
    for options in (["-c", "2"], ["--cores", "all"], []):
        assert main(["run", written("study.yaml"), *options, "-n"]) == 0
    assert [command[command.index("none") + 1 :] for command in seen] == [
        ["--cores", "2", "-n"],
        ["--cores", "all", "-n"],
        ["-n"],
    ]


def test_an_unknown_profile_is_one_line(workplace, capsys):
    line = told(["run", written("study.yaml"), "--profile", "nowhere"], capsys)
    assert line.startswith("--profile: received nowhere, needs a folder in ")
    assert not Path("results").exists()
