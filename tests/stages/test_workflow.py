"""The workflow as a user runs it: cold, again, varied, interrupted, damaged."""

import copy
import csv
import fcntl
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np
import psutil
import pytest
import yaml
from conftest import SEED
from snakemake.shell import shell

import vsb
from vsb.cli import main
from vsb.stages.make import make
from vsb.stages.verify import study_faults
from vsb.study import study as config
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical
from vsb.tools.files import load, read_groups

BASE = yaml.safe_load(SEED.read_text())
BASE["study"] = "base"
BASE["modes"]["degree"] = 2
BASE["designs"] = {"FSB": {"flexible": False}, "VSWEC": {}}
BASE["hydro"] = {"rows": 16, "omega_max": 5.0, "tolerance": 4.0e-3}
BASE["simulation"].update(duration=20.0, window=[10.0, 20.0])
FOREIGN = (
    "Snakefile",
    "workflow/Snakefile",
    "profiles/default/config.yaml",
    "snakemake.py",
    "yaml.py",
    "vsb/study/plan.py",
)
"""Files of the current folder that have nothing to do with a study."""
SCIENCE = {"mesh", "green", "deformed", "witness", "panels", "spectral", "database", "radiation"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory, green_folder):
    """A working folder with a stranger's workflow and a Green-function table, and the base study run in it."""
    place = tmp_path_factory.mktemp("study")
    for name in FOREIGN:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text("open('stranger', 'w')\n")
    table = place / StudyPlan(config.load(SEED)).green_folder
    shutil.copytree(green_folder, table)
    Path(f"{table}.done").write_text("0 s\n")
    process = start(place, "run", write(place, BASE))
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err + out
    return place


def write(place, raw, name=None):
    path = place / f"{name or raw['study']}.yaml"
    path.write_text(yaml.safe_dump(raw))
    return path


def start(place, *arguments, **options):
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    return subprocess.Popen(
        [Path(sys.executable).with_name("vsb"), *map(str, arguments)],
        cwd=place, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options,
    )  # fmt: skip


def run(place, path, *options, command="run"):
    """A command in a folder, by this process: what it returns and it and its children write."""
    arguments = [command, *map(str, (path, *options))]
    kept = os.dup(1), os.dup(2)
    with chdir(place), TemporaryFile("w+", buffering=1) as out, TemporaryFile("w+", buffering=1) as err:
        os.dup2(out.fileno(), 1), os.dup2(err.fileno(), 2)
        try:
            with redirect_stdout(out), redirect_stderr(err):
                code = main(arguments)
        finally:
            for number, own in zip((1, 2), kept, strict=True):
                os.dup2(own, number)
                os.close(own)
        said = [stream.seek(0) or stream.read() for stream in (out, err)]
    return subprocess.CompletedProcess(arguments, code, *said)


def run_in_process(place, raw):
    """The results of a study by `vsb.run`, which leaves the workflow nothing to do."""
    with chdir(place):
        results = vsb.run(vsb.load(write(place, raw)))
    assert planned(place, raw) == {}
    return results


def planned(place, raw, name=None):
    """Rules a dry run would execute, with their counts."""
    dry = run(place, write(place, raw, name), "-n")
    assert dry.returncode == 0, dry.stderr
    lines = dry.stdout.splitlines() + dry.stderr.splitlines()
    rows = [line.split() for line in lines]
    return {
        row[0]: int(row[1]) for row in rows if len(row) == 2 and row[1].isdigit() and row[0] not in ("total", "all")
    }


def with_(**changes):
    raw = copy.deepcopy(BASE)
    for key, value in changes.items():
        raw[key] = {**raw[key], **value} if isinstance(value, dict) and key != "designs" else value
    return raw


def test_everything_promised_is_there(folder):
    results = folder / "results" / "base"
    rows = list(csv.DictReader((results / "comparison.csv").open()))
    assert [row["design"] for row in rows] == ["FSB", "VSWEC"]
    assert float(rows[0]["energy_gain_percent"]) == 0.0
    assert all(float(row["energy_residual"]) < 1e-4 for row in rows)
    assert [(float(row["damping"]), float(row["stiffness"])) for row in rows] == [(8000.0, 0.0)] * 2
    rigid, shell = (float(row["power_mean"]) for row in rows)
    assert float(rows[1]["power_gain_percent"]) == pytest.approx(100 * (shell / rigid - 1), rel=1e-6)
    response = load(results / "response.nc")
    assert response.rao.dims == ("design", "omega", "dof")
    assert 2 * np.pi / 2.5 in response.omega.values
    trajectory = load(results / "trajectories" / f"VSWEC-{rows[0]['wave']}.nc")
    assert {"position", "velocity", "excitation", "pto", "hydrostatic", "radiation", "elastic"} <= set(trajectory)
    ledger = json.loads((results / "validity.json").read_text())
    verdicts = {check["name"]: check["verdict"] for check in ledger["checks"]}
    assert {"buckling", "power_limit", "passivity", "hydro haskind"} <= verdicts.keys()
    for name in ("witness", "witness_derivatives", "witness_database"):
        assert verdicts[name] == "ok"
    report = (results / "report.html").read_text()
    assert report.count('<div class="drawn"') == 14
    assert "http://" not in report.replace("http://www.w3.org", "").replace("http://purl.org", "").replace(
        "http://creativecommons.org", ""
    )
    index = (folder / "results" / "hydro" / "INDEX.tsv").read_text().splitlines()
    assert index[0].startswith("id\tradius_m")
    assert len(index) == 2
    for kind in ("vtu", "nc"):  # to look at, and for the second solver, next to which are those of the blocks
        names = {path.stem for path in (folder / "results" / "hydro" / "mesh").glob(f"*/*.{kind}")}
        assert names == {"mean", *(f"Membrane{n}_{side}" for n in range(3) for side in ("minus", "plus"))}


def test_nothing_of_a_stranger_in_the_current_folder_is_run(folder):
    """The workflow, its profiles and all modules are the package's."""
    assert all((folder / name).is_file() for name in FOREIGN)
    assert not (folder / "stranger").exists()


def test_a_specification_longer_than_an_argument_may_be_reaches_its_command(folder, monkeypatch, tmp_path):
    """By the shell of snakemake, with the words of the rule; Linux takes no argument above 128 KiB."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    seas = [{"kind": "jonswap", "hs": 1.0, "tp": tp, "realisations": 600} for tp in (4.0, 5.0, 6.0)]
    plan = StudyPlan(config.parse(with_(waves=seas)))
    assert len(canonical(plan.comparison)) > 2**17
    shell("vsb modes --out modes.nc <<< {spec:q}", spec=canonical(plan.modes) + " " * 2**17)
    assert load("modes.nc").equals(load(folder / "results/base/modes.nc"))


def test_a_lost_product_is_made_again(folder):
    lost = folder / "results/base/comparison.csv"
    text = lost.read_text()
    lost.unlink()
    assert run(folder, folder / "base.yaml").returncode == 0
    assert lost.read_text() == text


def test_a_second_run_has_nothing_to_do(folder, monkeypatch):
    assert planned(folder, BASE) == {}
    monkeypatch.chdir(folder)
    assert study_faults(StudyPlan(config.load("base.yaml"))) == []


SECONDS = re.compile(r"\d[\d.e+-]*(?= s\b| on one core)")


def contents(path):
    """What a file of results says, without the seconds it took."""
    if path.suffix == ".pdf":
        return path.read_bytes()
    if path.suffix != ".nc":
        text = path.read_text(encoding="utf-8")
        return SECONDS.sub("", text) if path.suffix == ".html" else text
    said = {name: ds.drop_vars([key for key in ds if "seconds" in key]) for name, ds in read_groups(path).items()}
    for ds in said.values():
        ds.attrs = {key: value for key, value in ds.attrs.items() if "seconds" not in key and key != "checksum"}
    return repr([(name, ds.to_dict()) for name, ds in said.items()])


def test_in_one_process_the_same_files_say_the_same(folder, tmp_path, monkeypatch):
    """`vsb.run` beside the workflow: by panels, with the second solver; nothing is left to do for the workflow."""
    shutil.copytree(folder / "results/hydro/green", tmp_path / "results/hydro/green")
    results = run_in_process(tmp_path, BASE)
    for path in results.plan.ids:
        assert contents(tmp_path / path) == contents(folder / path), path
    rows = csv.DictReader((folder / "results/base/comparison.csv").open())
    monkeypatch.chdir(tmp_path)
    assert [row["power_mean"] for row in rows] == [f"{row['power_mean']:.10g}" for row in results.comparison]


def test_comments_order_and_spelling_rerun_nothing(folder):
    text = write(folder, BASE, "spelled").read_text()
    data = yaml.safe_load(text)
    data["device"]["young_modulus"] = "1e7"
    lines = ["# a remark", yaml.safe_dump(dict(reversed(data.items())), sort_keys=False)]
    (folder / "spelled.yaml").write_text("\n".join(lines))
    dry = run(folder, folder / "spelled.yaml", "-n")
    assert "Nothing to be done" in dry.stdout + dry.stderr


def test_a_pto_change_reruns_no_hydrodynamics(folder):
    rules = planned(folder, with_(pto={"damping": 5000.0}), "pto")
    assert set(rules) == {"response", "ladder", "simulate", "compare", "figures", "report"}
    assert rules["simulate"] == 2


def test_a_study_of_the_same_buoy_shares_the_database(folder):
    other = with_(study="other", designs={"clamped": {"clamp": 0}}, waves=[{"kind": "still"}])
    assert not {"display", *SCIENCE} & set(planned(folder, other))  # the shapes to look at as well


def test_another_material_or_basis_runs_no_bem(folder):
    stiff = with_(study="stiff", device={"young_modulus": 1e9, "density": 7850.0, "internal_pressure": 1e3})
    assert not {"panels", "spectral", "deformed", "witness"} & set(planned(folder, stiff))
    assert not {"panels", "spectral"} & set(planned(folder, with_(study="both", modes={"basis": "full", "degree": 2})))


def test_a_wider_band_computes_new_blocks_only(folder):
    assert planned(folder, with_(study="wide", hydro={"omega_max": 7.0}))["panels"] == 1


def test_tabulated_frequencies_and_irregular_sea_without_rigid_design(folder):
    raw = with_(
        study="table",
        hydro={"omega": [1.0, 2.0, 2.5132741228718345]},
        designs={"VSWEC": {}},
        waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}],
    )
    plan = run_in_process(folder, raw).plan
    database = load(folder / plan.database_path)
    assert list(database.omega.values) == [1.0, 2.0, 2.5132741228718345]
    assert not any("nan" in line.lower() for line in (folder / "results/table/comparison.csv").read_text().splitlines())
    assert "No rigid design" in (folder / "results/table/report.html").read_text()


@pytest.mark.parametrize("tabulated", [{}, {"omega": [1.0, 2.0]}], ids=["sweep", "tabulated"])
def test_deep_water_without_rows_needs_no_panels(folder, tabulated):
    name = "spectral" + "_table" * bool(tabulated)
    raw = with_(study=name)
    raw["hydro"] = {"omega_max": 5.0, "tolerance": 1.0e-3, "witness": "none", **tabulated}
    if not tabulated:  # the rules of its blocks
        done = run(folder, write(folder, raw), "database")
        assert done.returncode == 0, done.stderr
    plan = run_in_process(folder, raw).plan
    assert len(plan.bem_blocks) == 1 + len(plan.tabulated_blocks)
    ds = load(folder / plan.database_path)
    assert list(ds.omega.values) == (tabulated.get("omega") or [round(0.1 * i, 10) for i in range(1, 51)])
    ledger = json.loads((folder / f"results/{name}/validity.json").read_text())
    (estimate,) = [check for check in ledger["checks"] if check["name"] == "hydro error_estimate"]
    assert estimate["value"] < 1e-3
    rows = [list(csv.DictReader((folder / f"results/{s}/comparison.csv").open())) for s in (name, "base")]
    for ours, panels in zip(*rows, strict=True):  # 16 rows of panels are 1 % off
        assert float(ours["power_mean"]) == pytest.approx(float(panels["power_mean"]), rel=0.02)


def held(lock):
    """Whether a process holds a lock."""
    if not lock.exists():
        return False
    with lock.open() as handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False


def wait_until(condition, process):
    """Wait for what a process at work will bring about."""
    deadline = time.time() + 120
    while not condition() and process.poll() is None and time.time() < deadline:
        time.sleep(0.02)
    assert condition()


def solvers(process):
    """What a run has at work of panels."""
    try:
        started = psutil.Process(process.pid).children(recursive=True)
        return [one for one in started if {"vsb", "panels"} <= {Path(word).name for word in one.cmdline()}]
    except psutil.NoSuchProcess:
        return []


def test_killed_and_resumed_gives_identical_numbers(folder):
    raw = with_(
        study="killed",
        device={"mass": 16000.0},
        hydro={"witness": "none"},
        simulation={"duration": 12.0, "window": [6.0, 12.0]},
    )
    process = start(folder, "run", write(folder, raw), start_new_session=True)
    wait_until(lambda: held(folder / "results/killed/.lock"), process)
    crowded = run(folder, folder / "killed.yaml")
    assert (crowded.returncode, crowded.stderr) == (
        2,
        "vsb: error: results/killed: another run is at work in this folder; wait for it to end\n",
    )
    blocks, before = folder / "results/hydro/blocks", len(list((folder / "results/hydro/blocks").glob("*.nc")))
    wait_until(lambda: len(list(blocks.glob("*.nc"))) > before, process)
    assert process.poll() is None
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    told = start(folder, "run", folder / "killed.yaml")
    wait_until(lambda: solvers(told), told)
    started = psutil.Process(told.pid).children(recursive=True)
    told.terminate()
    assert told.communicate(timeout=60)[1].endswith("vsb: ended; run the same command again to go on from here\n")
    assert told.returncode == 128 + signal.SIGTERM
    assert psutil.wait_procs(started, timeout=5)[1] == []
    assert not held(folder / "results/.lock")
    assert not (folder / "results/killed/report.html").exists()
    finished = run(folder, folder / "killed.yaml", "compare")
    assert finished.returncode == 0, finished.stderr
    resumed = (folder / "results/killed/comparison.csv").read_text()
    shutil.rmtree(folder / "results/killed")
    plan = StudyPlan(config.load(folder / "killed.yaml"))
    for path in [plan.database_path, plan.radiation_path, *(plan.block_path(b) for b in plan.sweep_blocks)]:
        (folder / path).unlink()
    with chdir(folder):
        make(plan, ["results/killed/comparison.csv"])
    assert (folder / "results/killed/comparison.csv").read_text() == resumed


@pytest.mark.parametrize("content", [b"not netCDF", None], ids=["corrupt", "foreign"])
def test_a_damaged_database_is_one_line_before_any_job(folder, content):
    path = folder / StudyPlan(config.load(folder / "base.yaml")).database_path
    good = path.read_bytes()
    try:
        if content is None:
            shutil.copy(next((folder / "results/base/trajectories").glob("*.nc")), path)
        else:
            path.write_bytes(content)
        broken = run(folder, folder / "base.yaml")
    finally:
        path.write_bytes(good)
    assert broken.returncode == 2
    assert broken.stdout == ""
    assert broken.stderr.startswith("vsb: error: results/hydro/db/")
    assert broken.stderr.count("\n") == 1


def test_a_failed_check_fails_the_rule_unless_accepted(folder):
    # 4 rows up to 2 rad/s cannot satisfy Kramers-Kronig: the band ends where the damping peaks
    raw = with_(study="coarse", hydro={"rows": 12, "omega_max": 2.0, "witness": "none"}, waves=[{"kind": "still"}])
    failed = run(folder, write(folder, raw))
    assert failed.returncode == 2
    last = failed.stderr.strip().splitlines()[-1]
    assert last.startswith("vsb: error: hydro database: check 'kramers_kronig' failed: ")
    assert "list the name under hydro.accept" in last


def test_bad_input_ends_with_two_and_one_line(folder):
    raw = with_(study="bad", device={"thickness": -1})
    for command in ("run", "check", "shell"):
        wrong = run(folder, write(folder, raw), command=command)
        assert wrong.returncode == 2
        assert wrong.stderr.count("\n") == 1
        assert "bad.yaml:14: device.thickness: received -1;" in wrong.stderr
        assert not (folder / "results" / "bad").exists()


def test_check_and_shell_speak_to_people(folder):
    summary = run(folder, folder / "base.yaml", command="check")
    assert summary.returncode == 0
    assert "BEM jobs     0 of 3" in summary.stdout
    assert "buckling" in summary.stdout
    table = run(folder, folder / "base.yaml", "--json", command="shell")
    shell = json.loads(table.stdout)
    assert [row["degree"] for row in shell["membrane"]] == [0, 1, 2]
    assert shell["paper_ritz"][1]["omega"] == pytest.approx(62.153777189, rel=4e-8)
    assert shell["bending"] == [{"degree": 2, "omega": pytest.approx(22.3593100, rel=1e-8)}]
    assert shell["buckling_pressure"] == pytest.approx(302.6, abs=0.1)


def test_export_and_import_of_a_studys_database(folder):
    """To WAMIT's files and back: the coefficients to seven digits, judged by the same identities."""
    done = run(folder, "base.yaml", "exchange", command="export")
    assert done.returncode == 0, done.stderr
    assert [Path(line).name for line in done.stdout.split()] == [
        f"base{extension}" for extension in (".1", ".3", ".3fk", ".3sc", ".hst", ".mmx", ".h5")
    ]
    done = run(folder, "exchange", "base", "exchange/back.nc", "--axisymmetric", command="import-wamit")
    assert done.returncode == 0, done.stderr
    assert "ok           haskind" in done.stdout
    ours, theirs = (
        load(folder / StudyPlan(config.load(folder / "base.yaml")).database_path),
        load(folder / "exchange/back.nc"),
    )
    for name in ("added_mass", "radiation_damping", "excitation_force", "hydrostatic_stiffness"):
        assert theirs[name].values == pytest.approx(
            ours[name].values, rel=2e-6, abs=2e-6 * np.abs(ours[name]).max().item()
        )
