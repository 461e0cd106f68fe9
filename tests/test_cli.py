"""The command line: one line and exit code 2 for every error of a user, before any work and without half-written files."""

import io
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from conftest import EXAMPLE, SEED, SMALL, SMALL_PLAN, error_line
from stages.test_members import planned, with_seas

from vsb import __version__
from vsb.cli import main, parser
from vsb.errors import INTERRUPTED
from vsb.keys.quantities import canonical
from vsb.pipeline.graph import StudyPlan
from vsb.study.study import load
from vsb.tools.commands import commands
from vsb.tools.stamps import check_product


def written(name, **changes):
    """A copy of the seed study with some sections updated."""
    raw = yaml.safe_load(SEED.read_text())
    for section, update in changes.items():
        raw[section] = {**raw[section], **update} if section in ("hydro", "water") else update
    Path(name).write_text(yaml.safe_dump(raw))
    return name


def given(monkeypatch, text, terminal=False):
    """Standard input that holds a text."""
    stream = io.StringIO(text)
    stream.isatty = lambda: terminal
    monkeypatch.setattr(sys, "stdin", stream)


def test_package_runs_as_a_module():
    done = subprocess.run([sys.executable, "-m", "vsb", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == f"vsb {__version__}"


def test_every_command_has_help(capsys):
    for command in commands(parser()):
        with pytest.raises(SystemExit) as stop:
            main([command, "--help"])
        assert stop.value.code == 0
        assert command in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["chek", "x.yaml"], "COMMAND: received chek, did you mean check?; see vsb --help"),
        (["frobnicate"], "argument COMMAND: invalid choice: 'frobnicate' (choose from 'init', "),
        (["shell", "x.yaml", "--jsn"], "unrecognized arguments: --jsn; did you mean --json?; see vsb --help"),
        (["shell", "x.yaml", "--frobnicate"], "unrecognized arguments: --frobnicate; see vsb --help"),
        (["schema", "campain"], "kind: received campain, did you mean campaign?; see vsb schema --help"),
    ],
)
def test_misspelt_command_or_option_gets_a_suggestion(capsys, arguments, message):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert capsys.readouterr().err.startswith(f"vsb: error: {message}")


@pytest.mark.parametrize("command", ["run", "check", "shell", "body", "shape-dependence"])
def test_missing_file(workplace, capsys, command):
    arguments = [command, "missing.yaml", *["out"] * (command in ("body", "shape-dependence"))]
    assert error_line(arguments, capsys).startswith("missing.yaml: cannot be read")
    assert [path.name for path in workplace.iterdir()] == ["file"]


def test_all_errors_of_a_file_are_reported_each_with_its_line(workplace, capsys):
    """Then those of several sections together."""
    text = SEED.read_text().replace("thickness", "thicknes").replace("{basis: membrane", "{basis: membran")
    Path("several.yaml").write_text(text.replace("amplitude", "hs"))
    assert main(["check", "several.yaml"]) == 2
    start, lines = "vsb: error: several.yaml:", capsys.readouterr().err.splitlines()
    at = {name: 1 + text[: text.index(name)].count("\n") for name in ("device:", "thicknes:", "basis:", "amplitude:")}
    assert lines == [
        f"{start}{at['thicknes:']}: device.thicknes: received 0.01; unknown key; did you mean thickness?",
        f"{start}{at['amplitude:']}: waves.0.hs: received 0.179; unknown key; "
        "it belongs to kind jonswap or pierson_moskowitz or tma or white_noise",
        f"{start}{at['basis:']}: modes.basis: received 'membran'; needs 'paper', 'membrane' or 'full'; "
        "did you mean membrane?",
        f"{start}{at['amplitude:']}: waves.0.amplitude: missing, but required: "
        "half the height from trough to crest [m]",
    ]
    device = {**yaml.safe_load(SEED.read_text())["device"], "mass": 1e9}
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 0.1}]
    assert main(["check", written("heavy.yaml", device=device, waves=waves)]) == 2
    heavy, short = capsys.readouterr().err.splitlines()
    assert "device.mass 1e+09 kg: the buoy would sink" in heavy
    assert "waves.0 regular_A0.1_T0.1: the wave is too short" in short


@pytest.mark.parametrize(
    ("command", "changes", "message"),
    [
        ("check", {"hydro": {"omega_max": 20.0}}, "hydro.omega_max: received 20 rad/s, needs at most"),
        ("run", {"hydro": {"tolerance": 1e-5, "solver": "panels"}}, "hydro.tolerance: received 1e-05, needs at least"),
        ("check", {"hydro": {"tolerance": 0.0327}}, "hydro.tolerance: received 0.0327; needs a number of at most 0.02"),
        ("run", {"hydro": {"omega": [1e-9], "solver": "panels"}}, "hydro.omega: received 1e-09 rad/s, needs at least"),
        ("check", {"waves": [{"kind": "regular", "amplitude": 1, "period": 500.0}]}, "waves.0.period: received 500 s"),
        ("run", {"reference_shape": "equilibrium"}, "reference_shape: received 'equilibrium', but the shell buckles"),
        (
            "check",
            {"hydro": {"accept": ["nonsense"]}},
            "study: hydro.accept ['nonsense']: no such check; needs some of",
        ),
    ],
)
def test_error_of_the_plan_names_the_study_file_once(workplace, capsys, changes, message, command):
    name = "sp ace/ünï.yaml"
    Path(name).parent.mkdir()
    line = error_line([command, written(name, **changes)], capsys)
    assert re.sub(r":\d+", "", line, count=1).startswith(f"{name}: {message}")
    assert line.count(name) == 1


@pytest.mark.parametrize(
    ("arguments", "path"),
    [
        (["export", "study.yaml", "file/out"], "file/out"),
        (["body", "study.yaml", "file/out"], "file/out"),
        (["body", "study.yaml", "file"], "file"),
        (["shape-dependence", "study.yaml", "file/out"], "file/out"),
        (["shape-dependence", "study.yaml", "folder"], "folder.nc"),
        (["import-wamit", "in", "name", "folder.nc"], "folder.nc"),
        (["import-bemio", "in.h5", "folder.nc"], "folder.nc"),
    ],
)
def test_output_that_cannot_be_written_is_reported_before_any_work(workplace, capsys, arguments, path):
    Path("folder.nc").mkdir()
    line = error_line(arguments, capsys)
    assert line.startswith(path)
    assert "cannot be written" in line
    assert {path.name for path in workplace.rglob("*")} == {"file", "folder.nc"}
    assert Path("file").read_text() == "kept"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "standard input:1: no JSON from its end on; needs the tasks"),
        ("", "standard input:1: no JSON from its end on; needs the tasks"),
        ("[1]", "standard input: received [1], needs the tasks"),
        ('[{"stage": "lunch", "spec": {}, "files": {}, "makes": []}]', "standard input: stage: received lunch, needs "),
        (
            '[{"stage": "modes", "spec": {}, "files": {}, "makes": ["out.nc"]}]',
            "standard input: modes: missing a required argument",
        ),
    ],
)
def test_wrong_tasks_of_a_rule(workplace, capsys, monkeypatch, text, message):
    given(monkeypatch, text)
    assert error_line(["stage", "modes"], capsys).startswith(message)


def test_only_the_database_of_the_study_is_exported(finished, workplace, capsys):
    """Whatever its file name says; files are named after the study, or after a database that is given."""
    formats = (".1", ".3", ".3fk", ".3sc", ".hst", ".mmx", ".h5")
    for name, more, refused in (("small", {}, False), ("other", {"modes": {"degree": 3}}, True)):
        Path(f"{name}.yaml").write_text(yaml.safe_dump(SMALL | more))
        stored = Path(StudyPlan(load(f"{name}.yaml")).database.out)
        stored.parent.mkdir(parents=True, exist_ok=True)
        stored.write_bytes((finished / SMALL_PLAN.database.out).read_bytes())
        if refused:
            line = error_line(["export", f"{name}.yaml", "out"], capsys)
            assert line.startswith(f"{stored}: ")
            assert re.search(rf"{Path(SMALL_PLAN.database.out).stem}.*needs .*{stored.stem}", line)
        else:
            for source, stem in ((f"{name}.yaml", "small"), (str(stored), stored.stem)):
                assert main(["export", source, "out"]) == 0
                assert capsys.readouterr().out.split() == [f"out/{stem}{extension}" for extension in formats]
    assert len(list(Path("out").iterdir())) == 2 * len(formats)


@pytest.mark.parametrize("command", ["schema study | head -1", "init my.yaml | true"])
def test_closed_pipe_is_no_error(workplace, command):
    line = f"{sys.executable} -m vsb {command}; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_study_and_campaign_may_not_share_a_results_folder(workplace, capsys):
    planned(with_seas(workplace, (1.0, 6.0)), name="year")
    for folder, mark in (("year", "study.json"), ("seed", "members")):
        (workplace / "results" / folder / mark).mkdir(parents=True)
    line = error_line(["check", "year.yaml"], capsys)
    assert "campaign: received year, the name of a study with results in results/year" in line
    line = error_line(["check", str(SEED)], capsys)
    assert "study: received seed, the name of a campaign with results in results/seed" in line


@pytest.mark.parametrize(
    ("arguments", "lost", "kind"),
    [
        (["compare", "small.yaml", "--out", "small.yaml"], "small.yaml", "an input"),
        (["compare", "small.yaml", "--out", "other.yaml"], "other.yaml", "a study file"),
        (["compare", "small.yaml", "--out", "results/small/report.html"], "results/small/report.html", "a product"),
        (["import-bemio", "other.h5", "link.h5"], "link.h5", "an input"),
        (["import-bemio", "other.h5", "results/small/response.nc"], "results/small/response.nc", "a product"),
        (["import-wamit", ".", "two", "two.1"], "two.1", "an input"),
        (["compare", "small.yaml", "--out", "results/small/comparison.csv"], "results/small/comparison.csv", "a prod"),
        (["compare", "year.yaml", "--out", "site.csv"], "site.csv", "an input"),
        (["shape-dependence", "small.yaml", "results/small/response"], "results/small/response.nc", "a product"),
        (["body", "raft.yaml", "."], "raft.nc", "an input"),
        (["export", "results/hydro/db/{database}.nc", "results/hydro/db"], None, None),
        *(
            (arguments, own, "no earlier output of vsb")
            for arguments, own in (
                (["compare", "small.yaml", "--out", "mine.html"], "mine.html"),
                (["compare", "small.yaml", "--out", "mine.csv"], "mine.csv"),
                (["series", "{run}", "mine.csv"], "mine.csv"),
                (["series", "{run}", "mine.nc"], "mine.nc"),
                (["import-bemio", "other.h5", "mine.nc"], "mine.nc"),
                (["shape-dependence", "small.yaml", "mine"], "mine.nc"),
                (["export", "small.yaml", "mine"], "mine/small.h5"),
            )
        ),
    ],
)
def test_no_output_takes_the_place_of_an_input_a_study_a_product_or_a_file_of_the_user(
    finished, tmp_path, monkeypatch, capsys, arguments, lost, kind
):
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    own = ("mine.html", "mine.csv", "mine.nc", "mine/small.h5")
    Path("mine").mkdir()
    for name in ("other.yaml", "other.h5", "two.1", "site.csv", "raft.nc", *own):
        Path(name).write_text(name)
    Path("link.h5").symlink_to("other.h5")
    Path("year.yaml").write_text("{campaign: year, study: small.yaml, climate: {scatter: site.csv}}")
    Path("raft.yaml").write_text(
        "{body: raft, mesh: other.h5, modes: raft.nc, omega: [1.0], water: {density: 1025.0, gravity: 9.81}}"
    )
    before = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
    run = next(iter(Path("results/small/trajectories").iterdir()))
    arguments = [one.format(database=Path(SMALL_PLAN.database.out).stem, run=run) for one in arguments]
    if lost is None:
        assert main(arguments) == 0
    else:
        assert error_line(arguments, capsys).startswith(f"{lost}: is {kind}")
        assert {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(
    "arguments",
    [
        ["export", "small.yaml", "{out}"],
        ["compare", "small.yaml", "--out", "{out}/both.csv"],
        ["compare", "small.yaml", "--out", "{out}/both.html"],
    ],
)
def test_earlier_output_of_a_command_is_replaced(small, tmp_path, arguments):
    arguments = [one.format(out=tmp_path) for one in arguments]
    assert main(arguments) == main(arguments) == 0


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (["import-wamit", "out", "small", "own.nc"], ["series", "{run}", "own.nc"], "hydro database of vsb, no time s"),
        (
            ["series", "{run}", "own.csv"],
            ["compare", "small.yaml", "--out", "own.csv"],
            "time series of vsb, no table of",
        ),
        (
            ["series", "{run}", "own.nc"],
            ["import-wamit", "out", "small", "own.nc"],
            "time series of vsb, no hydro data",
        ),
    ],
)
def test_an_output_replaces_its_own_kind_only(small, tmp_path, monkeypatch, capsys, first, second, message):
    """A database took a week to solve: no time series takes its place, though both are outputs of this package."""
    run = next(iter(Path(small.folder, "trajectories").iterdir())).absolute()
    assert main(["export", "small.yaml", str(tmp_path / "out")]) == 0
    named = [
        [str(tmp_path / one) if one.startswith("own") or one == "out" else one.format(run=run) for one in line]
        for line in (first, second)
    ]
    assert main(named[0]) in (0, 1)
    own = next(tmp_path.glob("own.*"))
    before, _ = own.read_bytes(), capsys.readouterr()
    assert f"is a {message}" in error_line(named[1], capsys)
    assert own.read_bytes() == before
    assert main(named[0]) in (0, 1)


def test_a_rule_replaces_its_own_products_only(workplace, capsys, monkeypatch):
    """Called by hand it replaced a study, and any other file."""
    Path("small.yaml").write_text(yaml.safe_dump(SMALL))
    every = {task.stage: task for task in StudyPlan(load("small.yaml")).tasks}

    def given_paths(stage, out, makes, **files):
        task = replace(every[stage], files={"out": out, **files}, makes=makes)
        given(monkeypatch, canonical([task.handed]))

    for _ in range(2):
        given_paths("modes", "modes.nc", ("modes.nc",))
        assert main(["stage", "modes"]) == 0
    Path("text.nc").write_text("mine")
    for name in ("small.yaml", "text.nc"):
        before = Path(name).read_bytes()
        given_paths("modes", name, (name,))
        assert f"{name}: is no earlier output of the rule modes, and would be lost" in error_line(
            ["stage", "modes"], capsys
        )
        assert Path(name).read_bytes() == before
    Path("mine").mkdir()
    Path("mine/shell.vtu").write_text("mine")
    given_paths("display", "mine/shell.vtu", ("mine/shell.vtu",), manifest="mine/manifest.json")
    assert "mine/shell.vtu: is no earlier output of the rule meshes" in error_line(["stage", "meshes"], capsys)
    given_paths("display", "new/shell.vtu", ("new/shell.vtu",), manifest="small.yaml")
    assert "small.yaml: is no earlier output of the rule meshes" in error_line(["stage", "meshes"], capsys)
    Path("modes.nc").rename("one.nc")
    Path("search/starts").mkdir(parents=True)
    Path("one.nc").rename("search/starts/one.nc")
    check_product("search", "design_results", "design_results")  # a design's folder before its tables: starts alone


def test_results_lie_where_they_are_asked_for(capsys, tmp_path):
    """The plan of a check, and of a workflow that Snakemake only shows."""
    folder = str(tmp_path / "elsewhere")
    assert main(["check", str(EXAMPLE), "--results", folder]) == 0
    assert f"database     {folder}/hydro/db/" in capsys.readouterr().out


@pytest.mark.parametrize(("line", "follows"), [("vsb run --q", {"--quiet "}), ("vsb check m", {"my.yaml "})])
def test_a_shell_is_told_what_may_follow(tmp_path, monkeypatch, line, follows):
    monkeypatch.chdir(tmp_path)
    Path("my.yaml").touch()
    asked = {"_ARGCOMPLETE": "1", "_ARGCOMPLETE_IFS": "\n", "COMP_LINE": line, "COMP_POINT": str(len(line))}
    asked |= {"_ARGCOMPLETE_STDOUT_FILENAME": "found"}
    subprocess.run([sys.executable, "-m", "vsb"], env={**os.environ, **asked}, check=True)
    assert {*Path("found").read_text().split("\n")} == follows


def test_database_of_a_study_is_exported_from_the_folder_of_its_results(small, tmp_path, monkeypatch):
    results, study = Path("results").absolute(), Path("small.yaml").absolute()
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(study), "out", "--results", str(results)]) == 0
    assert Path("out/small.1").exists()


def test_ctrl_c_while_modules_load_is_one_line():
    """The first half second of a command goes into imports."""
    loading = "class Finder:\n def find_spec(name, *rest):\n  if name == 'vsb.cli': raise KeyboardInterrupt"
    code = f"import sys\n{loading}\nsys.meta_path.insert(0, Finder)\nfrom vsb.__main__ import main\nsys.exit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, f"{INTERRUPTED}\n")
