import argparse
import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from conftest import EXAMPLE, SEED, SMALL, SMALL_PLAN, shipped, told

import vsb
from vsb import cli, errors
from vsb.cli import main, parser
from vsb.stages.preview import summary
from vsb.stages.stage import STAGES
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, load
from vsb.tools import completion
from vsb.tools import files as storage

FORMATS = (".1", ".3", ".3fk", ".3sc", ".hst", ".mmx", ".h5")
COMMANDS = (
    "init", "run", "check", "schema", "completion", "verify", "shell", "body", "shape-dependence", "export", "import-wamit", "import-bemio",
    *(stage.name for stage in STAGES),
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


def given(monkeypatch, text, terminal=False):
    """Standard input that holds a text."""
    stream = io.StringIO(text)
    stream.isatty = lambda: terminal
    monkeypatch.setattr(sys, "stdin", stream)


def test_missing_input_of_a_rule_is_one_line(capsys, monkeypatch):
    given(monkeypatch, '{"database":"x","tolerance":0.001}')
    assert main(["radiation", "--database", "no.nc", "--out", "out.nc"]) == 2
    assert (
        capsys.readouterr().err == "vsb: error: no.nc: file not found; run the rule that makes it (vsb run CONFIG).\n"
    )


def test_a_rule_without_specification_asks_nothing_of_a_terminal(workplace, capsys, monkeypatch):
    given(monkeypatch, "", terminal=True)
    assert told(["green", "--folder", "file/green", "--out", "out.txt"], capsys).startswith("file")
    assert told(["spectral", "--out", "out.nc"], capsys).startswith("standard input: received a terminal, needs")


def test_unknown_command_is_two():
    with pytest.raises(SystemExit) as stop:
        parser().parse_args(["simulat"])
    assert stop.value.code == 2


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["chek", "x.yaml"], "COMMAND: received chek, did you mean check?; see vsb --help"),
        (["shell", "x.yaml", "--jsn"], "unrecognized arguments: --jsn; did you mean --json?; see vsb --help"),
        (["shell", "x.yaml", "--frobnicate"], "unrecognized arguments: --frobnicate; see vsb --help"),
        (
            ["shell", "x.yaml", "--jsn", "--frobnicate"],
            "unrecognized arguments: --jsn --frobnicate; did you mean --json?",
        ),
        (["completion", "basch"], "shell: received basch, did you mean bash?; see vsb completion --help"),
        (["frobnicate"], "argument COMMAND: invalid choice: 'frobnicate' (choose from 'init', "),
    ],
)
def test_a_misspelt_command_or_option_is_told_what_was_meant(capsys, arguments, meant):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert capsys.readouterr().err.startswith(f"vsb: error: {meant}")


def test_all_mistakes_of_a_file_are_told_each_in_a_line(workplace, capsys):
    """With the line it stands in, and what was probably meant; then those that several sections make together."""
    text = SEED.read_text().replace("thickness", "thicknes").replace("{basis: membrane", "{basis: membran")
    Path("several.yaml").write_text(text.replace("amplitude", "hs"))
    assert main(["check", "several.yaml"]) == 2
    start, lines = "vsb: error: several.yaml:", capsys.readouterr().err.splitlines()
    at = {name: 1 + text[: text.index(name)].count("\n") for name in ("device:", "thicknes:", "basis:", "amplitude:")}
    assert lines == [
        f"{start}{at['thicknes:']}: device.thicknes: received 0.01; unknown key; did you mean thickness?",
        f"{start}{at['amplitude:']}: waves.0.hs: received 0.179; unknown key; remove it or correct its spelling",
        f"{start}{at['device:']}: device.thickness: missing, but required: "
        "thickness of the shell; thin-shell theory needs less than radius/10 [m]",
        f"{start}{at['basis:']}: modes.basis: received 'membran'; needs 'paper', 'membrane' or 'full'; "
        "did you mean membrane?",
        f"{start}{at['amplitude:']}: waves.0.amplitude: missing, but required: "
        "half the height from trough to crest [m]",
    ]
    assert main(["check", written("heavy.yaml", device={**yaml.safe_load(SEED.read_text())["device"], "mass": 1e9},
                 waves=[{"kind": "regular", "amplitude": 0.1, "period": 0.1}])]) == 2  # fmt: skip
    heavy, short = capsys.readouterr().err.splitlines()
    assert "device.mass 1e+09 kg: the buoy would sink" in heavy
    assert "waves.0 regular_A0.1_T0.1: the wave is too short" in short


def test_interruption_says_how_to_go_on(monkeypatch, capsys):
    def interrupted(path):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "plan_of", interrupted)
    assert main(["check", "any.yaml"]) == 130
    assert "run the same command again" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["body", "missing.yaml", "out"], ["shape-dependence", "missing.yaml", "out"]])
def test_a_missing_file_of_any_command_is_one_line_and_writes_nothing(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(command) == 2
    err = capsys.readouterr().err
    assert err.startswith("vsb: error: missing.yaml: cannot be read")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


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
        ({"hydro": {"tolerance": 0.0327}}, "hydro.tolerance: received 0.0327; needs a number of at most 0.02"),
        ({"hydro": {"omega": [1e-9], "solver": "panels"}}, "hydro.omega: received 1e-09 rad/s, needs at least"),
        ({"waves": [{"kind": "regular", "amplitude": 1, "period": 500.0}]}, "waves.0.period: received 500 s"),
        ({"reference_shape": "equilibrium"}, "reference_shape: received 'equilibrium', but the shell buckles"),
        ({"hydro": {"accept": ["nonsense"]}}, "study: hydro.accept ['nonsense']: no such check; needs some of"),
    ],
)
@pytest.mark.parametrize("name", ["study.yaml", "sp ace/ünï.yaml"])
def test_a_mistake_of_the_plan_names_the_study_file_once(workplace, capsys, changes, message, name):
    Path(name).parent.mkdir(exist_ok=True)
    for command in ("check", "run"):
        line = told([command, written(name, **changes)], capsys)
        assert re.sub(r":\d+", "", line, count=1).startswith(f"{name}: {message}")
        assert line.count(name) == 1


def test_a_mistake_of_another_command_names_its_file_once(workplace, capsys):
    shallow = written("shallow.yaml", water={"depth": 30.0})
    line = told(["shape-dependence", shallow, "out"], capsys)
    assert line == "shallow.yaml: water.depth: received 30 m; shape dependence needs deep water, .inf"
    Path("body.yaml").write_text("{body: b, mesh: none.stl, modes: none.nc, omega: [1.0]}")
    assert told(["body", "body.yaml", "out"], capsys).startswith("body.yaml: none.stl: mesh not found")
    assert told(["export", written("study.yaml"), "out"], capsys).startswith("results/hydro/db/")  # not of the study
    assert not {"out", "out.shapes", "results"} & {path.name for path in workplace.iterdir()}


def test_a_database_of_another_study_is_not_exported_as_the_studys_own(finished, workplace, capsys):
    """Whatever its name says; the study whose it is has it exported."""
    for name, more, line in (("small", {}, ""), ("other", {"modes": {"degree": 3}}, "needs")):
        Path(f"{name}.yaml").write_text(yaml.safe_dump(SMALL | more))
        stored = Path(StudyPlan(load(f"{name}.yaml")).database_path)
        stored.parent.mkdir(parents=True, exist_ok=True)
        stored.write_bytes((finished / SMALL_PLAN.database_path).read_bytes())
        if line:
            refused = told(["export", f"{name}.yaml", "out"], capsys)
            assert refused.startswith(f"{stored}: ")
            assert re.search(rf"{Path(SMALL_PLAN.database_path).stem}.*{line} .*{stored.stem}", refused)
        else:
            assert main(["export", f"{name}.yaml", "out"]) == 0
            assert capsys.readouterr().out.split() == [f"out/small{kind}" for kind in FORMATS]
    assert len(list(Path("out").iterdir())) == len(FORMATS)


def test_files_for_other_codes_are_named_after_the_database_or_the_study(tmp_path, monkeypatch, capsys):
    """Of a study it must be its own, whose id it is named by; of a file it is whatever it is."""
    given = []
    exported = "vsb.hydro.formats.exchange.export"
    monkeypatch.setattr(exported, lambda *args, **known: given.append((*args, known)) or ["a.1", "b.h5"])
    monkeypatch.chdir(tmp_path)
    Path("file.yaml").write_text(yaml.safe_dump({**yaml.safe_load(SEED.read_text()), "study": "named"}))
    stored = Path(StudyPlan(load("file.yaml")).database_path)
    for config in ("there/of.a.buoy.nc", "file.yaml"):
        assert main(["export", config, "out"]) == 0
        assert capsys.readouterr().out == "a.1\nb.h5\n"
    assert given == [
        (Path("there/of.a.buoy.nc"), "out", "of.a.buoy", {}),
        (stored, "out", "named", {"expected_id": stored.stem}),
    ]


LONG = [["export", "study.yaml"], ["body", "study.yaml"], ["shape-dependence", "study.yaml"]]


@pytest.mark.parametrize("command", LONG, ids=lambda command: command[0])
def test_what_cannot_be_written_is_told_before_any_work(workplace, capsys, command):
    line = told([*command, "file/out"], capsys)
    assert line.startswith("file/out")
    assert "cannot be written" in line
    assert f"{workplace / 'file'} is no folder); needs" in line
    assert [path.name for path in workplace.iterdir()] == ["file"]
    assert Path("file").read_text() == "kept"


def test_a_folder_in_place_of_a_result_is_told_before_any_work(workplace, capsys):
    (workplace / "a.nc").mkdir()
    line = told(["shape-dependence", "study.yaml", "a"], capsys)
    assert line.startswith("a.nc: cannot be written (it is a folder or a device); needs a file in a folder")
    (workplace / "b.svg").mkdir()
    line = told(["shape-dependence", "study.yaml", "b"], capsys)
    assert line.startswith("b.svg: cannot be written (it is a folder or a device); needs a file in a folder")


def test_a_result_of_a_rule_that_cannot_be_written_is_one_line(workplace, capsys, monkeypatch):
    spec = canonical(StudyPlan(load(SEED)).modes)
    (workplace / "folder").mkdir()
    for out in ("folder", "file/modes.nc"):
        given(monkeypatch, spec)
        assert told(["modes", "--out", out], capsys).startswith(f"{out}: cannot be written (")
    assert sorted(path.name for path in workplace.rglob("*")) == ["file", "folder"]


def test_a_results_folder_that_is_none_is_told_before_any_work(workplace, capsys):
    (workplace / "results").write_text("kept")
    assert told(["run", written("study.yaml")], capsys).startswith("results: cannot be written (")
    assert (workplace / "results").read_text() == "kept"
    assert {path.name for path in workplace.iterdir()} == {"file", "results", "study.yaml"}


def test_a_file_that_cannot_be_used_is_one_line(workplace, capsys, monkeypatch):
    paper = yaml.safe_load(EXAMPLE.with_name("paper.yaml").read_text())
    given(monkeypatch, canonical(paper))
    options = {"modes": "m", "trajectories": "t", "figures": "f", "out": "r.html", "manifest": "m.json"}
    line = told(["report", "--tables", "none.json", *(f"--{key}={value}" for key, value in options.items())], capsys)
    assert line.startswith("none.json: ")


def test_an_error_of_no_file_is_not_the_users(monkeypatch):
    def exhausted(path):
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(cli, "plan_of", exhausted)
    with pytest.raises(OSError, match="Too many open files"):
        main(["check", "any.yaml"])


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("{", "standard input: not valid JSON (Expecting property name"),
        ("", "standard input: not valid JSON (Expecting value"),
        ("[1]", "standard input: received [1], needs a mapping"),
    ],
)
def test_a_spec_that_is_none_is_one_line(workplace, capsys, monkeypatch, spec, message):
    given(monkeypatch, spec)
    assert told(["modes", "--out", "out.nc"], capsys).startswith(message)


def test_a_rule_does_not_wait_for_somebody_to_type(workplace, capsys, monkeypatch):
    given(monkeypatch, "{}", terminal=True)
    assert told(["modes", "--out", "out.nc"], capsys).startswith("standard input: received a terminal, needs the spec")


@pytest.mark.parametrize("one", [one for one in STAGES if one.spec], ids=lambda one: one.name)
def test_every_rule_with_a_specification_waits_for_nobody(one, workplace, capsys, monkeypatch):
    """Whatever else it may be given."""
    given(monkeypatch, "{}", terminal=True)
    files = [word for name in one.files for word in (f"--{name}", "some")]
    assert told([one.name, *files], capsys).startswith("standard input: received a terminal, needs the spec")


def test_nobody_reading_on_is_no_mistake():
    """The reader of `vsb check | head` goes away after a line."""
    command = f"{sys.executable} -m vsb.cli check {SEED} | head -1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    closed = f"{sys.executable} -m vsb.cli shell {SEED} | true; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", closed], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_profile_whose_executor_is_not_installed_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vsb.stages.run.find_spec", lambda name: None)
    assert main(["run", str(SEED), "--profile", "slurm"]) == 2
    assert "executor: received slurm, which is not installed; needs pip install 'vsb[slurm]'" in capsys.readouterr().err


def test_campaigns_and_studies_have_names_of_their_own(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    year = EXAMPLE.parent / "year.yaml"
    (tmp_path / "results" / "year").mkdir(parents=True)
    (tmp_path / "results" / "year" / "study.json").touch()
    assert main(["check", str(year)]) == 2
    assert "campaign: received year, the name of a study with results in results/year" in capsys.readouterr().err
    (tmp_path / "results" / "seed" / "members").mkdir(parents=True)
    assert main(["check", str(SEED)]) == 2
    assert "study: received seed, the name of a campaign with results in results/seed" in capsys.readouterr().err


def test_check_tells_of_a_campaign_what_it_is_and_what_is_left(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["check", str(EXAMPLE.parent / "when_it_pays.yaml")]) == 0
    out = capsys.readouterr().out
    assert "few_modes.yaml over 8600 seas, tuning constrained" in out
    assert "84 of device.young_modulus x device.thickness x pto.force_limit, 0 done" in out
    assert "32 of 32 batches to do, 1 shapes of the water" in out


def test_every_option_of_every_command_says_what_it_is_for():
    """Of commands that are listed: those of the workflow are not for people."""
    (commands,) = (a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    listed = {action.dest for action in commands._choices_actions}
    bare = {
        (name, action.option_strings[0])
        for name, command in commands.choices.items()
        for action in command._actions
        if name in listed and action.option_strings and not action.help
    }
    assert listed
    assert not bare


def test_check_prints_all_that_can_be_said_of_a_study_a_line_each(small, capsys):
    assert main(["check", "small.yaml"]) == 0
    assert capsys.readouterr().out.splitlines() == summary(small.study, small)


def test_export_names_its_files_as_the_study_or_as_the_database_that_was_given(small, tmp_path, capsys):
    """A study of its own name has files of that name, a file those of its own; all are printed, a line each."""
    for source, stem in (("small.yaml", "small"), (small.database_path, Path(small.database_path).stem)):
        assert main(["export", source, str(tmp_path / stem)]) == 0
        files = capsys.readouterr().out.splitlines()
        assert sorted(files) == sorted(map(str, (tmp_path / stem).iterdir()))
        assert {Path(file).name.partition(".")[0] for file in files} == {stem}


def test_a_database_of_something_else_is_not_exported_as_that_of_a_study(
    small, finished, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    place = tmp_path / small.database_path
    place.parent.mkdir(parents=True)
    other = storage.load(finished / small.database_path).assign_attrs(spec_id="0" * 16)
    storage.save(other, place)
    assert told(["export", str(finished / "small.yaml"), "out"], capsys).startswith(f"{small.database_path}: ")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("kind", "title"), [("study", "Study"), ("body-study", "BodyStudy"), ("body", "BodyFile"), ("campaign", "Campaign")]
)
def test_every_kind_of_file_has_its_own_schema(capsys, kind, title):
    assert main(["schema", kind]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == title


@pytest.mark.parametrize("table", [{"membrane": [1.5]}, {"natural": [{"mode": "Shell1", "omega": 2.5}]}])
def test_a_shell_of_any_kind_is_told_as_json_where_that_is_asked_for(capsys, monkeypatch, table):
    monkeypatch.setattr("vsb.stages.preview.shell_table", lambda study: table)
    monkeypatch.setattr("vsb.stages.preview.shell_text", lambda given: f"in words {given == table}")
    assert main(["shell", str(SEED), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == table
    assert main(["shell", str(SEED)]) == 0
    assert capsys.readouterr().out == "in words True\n"


def noted(monkeypatch, place, answer):
    """What a function is called with, in place of its work."""
    calls = []

    def work(*args, **options):
        calls.append((args, options))
        return answer

    monkeypatch.setattr(place, work)
    return calls


def check_of(name, verdict):
    return SimpleNamespace(line=f"{name}: {verdict}", verdict=verdict)


@pytest.mark.parametrize(
    ("place", "arguments", "given"),
    [
        ("verify.verify", ["verify", "a.yaml"], (("a.yaml",), {"heal": False})),
        ("verify.verify", ["verify", "a.yaml", "--heal"], (("a.yaml",), {"heal": True})),
        ("crate.crate", ["crate", "a.yaml", "b.zip"], (("a.yaml", "b.zip", None, None), {})),
        ("crate.crate", ["crate", "a.yaml", "b.zip", "--author", "N", "--licence", "U"],
         (("a.yaml", "b.zip", "U", "N"), {})),
    ],
)  # fmt: skip
def test_options_of_a_command_reach_what_does_its_work(workplace, monkeypatch, capsys, place, arguments, given):
    """And all lines it returns are printed."""
    calls = noted(monkeypatch, f"vsb.stages.{place}", ["first", "second"])
    assert main(arguments) == 0
    assert calls == [given]
    assert capsys.readouterr().out == "first\nsecond\n"


@pytest.mark.parametrize("verdict", ["ok", "doubt", "accepted", "fail"])
def test_databases_of_others_are_read_as_is_told_and_their_verdict_is_that_of_all_checks(
    workplace, monkeypatch, capsys, verdict
):
    """Whichever check fails; then notes, what was written, and what to look at. A fact not told has its default."""
    checks = [check_of("first", verdict), check_of("second", "ok")]
    calls = noted(monkeypatch, "vsb.stages.exchange.import_wamit", (checks, ["noted", "and more"], ["units", "names"]))
    told = ["--density=1000", "--gravity=9.8", "--length=2", "--depth=30", "--axisymmetric"]
    for more in (told, []):
        assert main(["import-wamit", "in", "name", "out.nc", *more]) == int(verdict == "fail")
        lines = capsys.readouterr().out.splitlines()
        said = ["noted", "and more", "out.nc", "look at units", "look at names"]
        assert lines == [f"first: {verdict}", "second: ok", *said]
    facts = [{"density": 1000.0, "gravity": 9.8, "length": 2.0, "depth": 30.0, "axisymmetric": True},
             {"density": 1025.0, "gravity": 9.81, "length": 1.0, "depth": float("inf"), "axisymmetric": False}]  # fmt: skip
    assert calls == [(("in", "name", "out.nc"), one) for one in facts]
    calls = noted(monkeypatch, "vsb.stages.exchange.import_bemio", (checks[::-1], [], []))
    for more, axisymmetric in ((["--axisymmetric"], True), ([], False)):
        assert main(["import-bemio", "in.h5", "out.nc", *more]) == int(verdict == "fail")
        assert calls.pop() == (("in.h5", "out.nc"), {"axisymmetric": axisymmetric})
    calls = noted(monkeypatch, "vsb.hydro.bodies.study.run", checks)
    capsys.readouterr()
    assert main(["body", "a.yaml", "folder"]) == int(verdict == "fail")
    assert calls == [(("a.yaml", "folder"), {})]
    assert capsys.readouterr().out.splitlines() == [f"first: {verdict}", "second: ok", "folder: blocks and database"]


def test_what_every_command_writes_is_asked_for_before_it_works(workplace, monkeypatch, capsys):
    """A folder in the place of a file, a file in the place of a folder; nothing has been done then."""
    (workplace / "a.nc").mkdir()
    (workplace / "a.zip").mkdir()
    for place, arguments in (
        ("vsb.stages.crate.crate", ["crate", "x.yaml", "a.zip"]),
        ("vsb.stages.exchange.import_wamit", ["import-wamit", "in", "name", "a.nc"]),
        ("vsb.stages.exchange.import_bemio", ["import-bemio", "in.h5", "a.nc"]),
        ("vsb.hydro.formats.exchange.export", ["export", "x.nc", "file"]),
        ("vsb.hydro.bodies.study.run", ["body", "x.yaml", "file"]),
    ):
        calls = noted(monkeypatch, place, ([], [], []))
        assert told(arguments, capsys).startswith(f"{arguments[-1]}: cannot be written")
        assert not calls


def test_shape_dependence_writes_under_the_name_it_is_given_and_prints_its_answer(workplace, monkeypatch, capsys):
    calls = noted(monkeypatch, "vsb.stages.shape_dependence.shape_dependence", "it depends")
    assert main(["shape-dependence", str(SEED), "a.b"]) == 0
    ((study, *files), _), *others = calls
    assert (study.study, files, others) == ("seed", ["a.b.nc", "a.b.svg"], [])
    assert capsys.readouterr().out == "a.b.nc a.b.svg\nit depends\n"


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (
            PermissionError(13, "Permission denied", "a"),
            "a: cannot be read or written (Permission denied); needs a path",
        ),
        (OSError(18, "Other device", "a", None, "b"), "b: cannot be read or written (Other device); needs a path"),
        (errors.StabilityError("it is not stable,\n  at rest"), "it is not stable, at rest"),
        (errors.ConfigError("a: wrong"), "x.yaml: a: wrong"),
        (errors.ConfigError("x.yaml: a: wrong"), "x.yaml: a: wrong"),
        (errors.ConfigError("x.yaml.csv: wrong"), "x.yaml: x.yaml.csv: wrong"),
        (errors.DatabaseError("y.nc: file not found"), "y.nc: file not found"),
    ],
)
def test_mistakes_of_every_kind_are_a_line_that_names_its_file(monkeypatch, capsys, error, line):
    def failing(path):
        raise error

    monkeypatch.setattr(cli, "plan_of", failing)
    assert told(["check", "x.yaml"], capsys).startswith(line)


def test_compare_hands_studies_on_in_their_order(workplace, monkeypatch, capsys):
    calls = noted(monkeypatch, "vsb.stages.side_by_side.compare", "a table")
    assert main(["compare", "b.yaml", "a.yaml", "--out", "t.csv"]) == main(["compare", "c.yaml"]) == 0
    assert calls == [((["b.yaml", "a.yaml"], "t.csv"), {}), ((["c.yaml"], None), {})]
    assert capsys.readouterr().out == "a table\n" * 2


def test_what_is_of_the_rule_alone_is_refused_beside_studies_and_all_that_is_missing_is_told(capsys):
    one = next(stage for stage in STAGES if stage.name == "compare")
    needed = [name for name in one.files if name != "out"]
    for name in (*needed, *one.optional):
        with pytest.raises(SystemExit) as stop:
            main(["compare", "a.yaml", f"--{name}", "x"])
        assert stop.value.code == 2
        told = f"--{name} is of the rule compare, which takes no studies; see vsb compare --help"
        assert capsys.readouterr().err == f"vsb: error: {told}\n"
    for given in ([], ["--out", "x", "--study", "y"]):
        with pytest.raises(SystemExit):
            main(["compare", *given])
        missing = " ".join(f"--{name}" for name in one.files if f"--{name}" not in given)
        told = f"needs studies, or as a rule of the workflow {missing}; see vsb compare --help"
        assert capsys.readouterr().err == f"vsb: error: {told}\n"


def test_a_rule_asks_for_its_files_and_not_for_what_may_be_absent(capsys):
    (commands,) = (a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    for one in STAGES:
        if one.name != "compare":
            required = {a.dest: a.required for a in commands.choices[one.name]._actions if a.dest != "help"}
            assert required == dict.fromkeys(one.files, True) | dict.fromkeys(one.optional, False)


def test_a_command_line_that_says_little_means_the_usual():
    line = parser()
    assert vars(line.parse_args(["run", "a.yaml"])).items() >= {"profile": "default", "cores": None}.items()
    for name in ("-c", "--cores"):
        assert line.parse_args(["run", "a.yaml", name, "3"]).cores == line.parse_args(["run", "a", f"{name}=3"]).cores
        assert str(line.parse_args(["run", "a.yaml", name, "3"]).cores) == "3"
    assert line.parse_args(["schema"]).kind == "study"
    assert line.parse_args(["init", "a.yaml"]).radius is None


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("hinged_barge", "body_preview.body_summary"),
        ("year", "campaign_preview.campaign_summary"),
        ("seed", "preview.summary"),
    ],
)
def test_check_prints_what_is_said_of_each_kind_of_file_a_line_each(workplace, monkeypatch, capsys, name, place):
    calls = noted(monkeypatch, f"vsb.stages.{place}", ["first", "second"])
    assert main(["check", str(shipped(name))]) == 0
    assert capsys.readouterr().out == "first\nsecond\n"
    assert calls[0][0][-1].name == name


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_completion_is_of_the_shell_asked_for(capsys, shell):
    assert main(["completion", shell]) == 0
    assert capsys.readouterr().out == completion.script(parser(), shell)


def test_a_study_that_is_begun_says_how_to_go_on(workplace, capsys):
    assert main(["init", "my.yaml", "--radius", "3"]) == 0
    assert capsys.readouterr().out == "my.yaml: change it, then vsb check my.yaml and vsb run my.yaml\n"
    assert load("my.yaml").device.radius == 3.0


def test_the_version_is_that_of_the_package(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"vsb {vsb.__version__}\n"
    assert "__version__" in dir(vsb)


def test_help_says_what_the_commands_and_rules_do(capsys):
    """A command for people by what is said of its handler, a rule by its text, which the help of all lists."""
    line = parser()
    (commands,) = (a for a in line._actions if isinstance(a, argparse._SubParsersAction))
    for action in commands._choices_actions:
        one = commands.choices[action.dest]
        assert one.description == one.get_default("handler").__doc__
    for stage in STAGES:
        assert f"  {stage.name:10} {stage.text}\n" in f"{line.epilog}\n"
        if stage.name != "compare":
            assert commands.choices[stage.name].description == f"Rule {stage.name}: {stage.text}."
    assert "Further options, such as -n, go to snakemake." in commands.choices["run"].format_help()


@pytest.mark.parametrize("broken", ["", "write", "flush"])
def test_a_reader_that_stops_is_no_mistake_also_where_all_was_held_back_until_the_end(monkeypatch, tmp_path, broken):
    """What is printed is handed on before the command is done; what is still to come goes nowhere."""
    told = []

    def done(name):
        told.append(name)
        if name == broken:
            raise BrokenPipeError

    line = argparse.ArgumentParser()
    line.set_defaults(handler=lambda args: print("answer") or 7, writes=())
    with open(tmp_path / "out", "w") as out:
        stream = SimpleNamespace(write=lambda _: done("write"), flush=lambda: done("flush"), fileno=out.fileno)
        with monkeypatch.context() as patch:
            patch.setattr(sys, "stdout", stream)
            code = cli.answer(line, [])
        os.write(out.fileno(), b"more")
    assert code == (0 if broken else 7)
    assert told[-1] == (broken or "flush")
    assert (tmp_path / "out").read_bytes() == (b"" if broken else b"more")
