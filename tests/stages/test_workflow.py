"""The workflow as a user runs it: from scratch, again, after changes, killed and resumed; studies and campaigns."""

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
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np
import psutil
import pytest
import yaml
from conftest import SEED
from snakemake.shell import shell
from stages.test_members import BASE as MEMBER_BASE
from stages.test_members import with_seas

import vsb
from vsb.cli import main
from vsb.keys.quantities import canonical
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import make
from vsb.stages.verify import study_faults
from vsb.study import study as config
from vsb.tools.commands import HOME
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
    "vsb/pipeline/graph.py",
)
"""Unrelated files in the current folder, which would be executed if they were imported."""
SCIENCE = {"mesh", "green", "cross_check", "panels", "spectral", "database"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory, green_folder):
    """A working folder with unrelated files and a Green-function table, and the base study run in it."""
    place = tmp_path_factory.mktemp("study")
    for name in FOREIGN:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text("open('stranger', 'w')\n")
    table = place / StudyPlan(config.load(SEED)).green.files["folder"]
    shutil.copytree(green_folder, table)
    Path(f"{table}.done").write_text("0 s\n")
    process = start(place, "run", write(place, BASE), "--cores", "2")
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
    """Run a command in a folder by this process, with all that it and its children write."""
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
    """Results of a study by `vsb.run`, which leaves the workflow nothing to do."""
    with chdir(place):
        results = vsb.run(vsb.load(write(place, raw)))
    assert planned(place, raw) == {}
    return results


def planned(place, raw, name=None):
    """Rules that a dry run would execute, with their counts."""
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


@pytest.mark.slow
def test_all_products_are_there_and_consistent(folder):
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
    assert report.count('<div class="drawn"') == 16
    assert "http://" not in report.replace("http://www.w3.org", "").replace("http://purl.org", "").replace(
        "http://creativecommons.org", ""
    )
    index = (folder / "results" / "hydro" / "INDEX.tsv").read_text().splitlines()
    assert index[0].startswith("id\tradius_m")
    assert len(index) == 2
    meshes = folder / "results" / "hydro" / "mesh"
    (shapes,) = meshes.glob("*/shapes.nc")
    names = {"mean", *(f"Membrane{n}_{side}" for n in range(3) for side in ("minus", "plus"))}
    assert {*map(str, load(shapes).shape.values)} == names
    assert len([*meshes.glob("*/shell.vtu")]) == 1


@pytest.mark.slow
def test_specification_longer_than_a_shell_argument(folder, monkeypatch, tmp_path):
    """Linux takes no argument above 128 KiB."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    seas = [{"kind": "jonswap", "hs": 1.0, "tp": tp, "realisations": 600} for tp in (4.0, 5.0, 6.0)]
    plan = StudyPlan(config.parse(with_(waves=seas)))
    assert len(canonical(plan.compare.spec)) > 2**17
    task = replace(next(iter(plan.tasks)), files={"out": "modes.nc"}, makes=("modes.nc",))
    shell("vsb stage modes <<< {text:q}", text=canonical([task.handed]) + " " * 2**17)
    assert load("modes.nc").equals(load(folder / "results/base/modes.nc"))


@pytest.mark.slow
def test_lost_product_is_remade(folder):
    lost = folder / "results/base/comparison.csv"
    text = lost.read_text()
    lost.unlink()
    assert run(folder, folder / "base.yaml").returncode == 0
    assert lost.read_text() == text


@pytest.mark.slow
def test_second_run_has_nothing_to_do(folder, monkeypatch):
    assert planned(folder, BASE) == {}
    monkeypatch.chdir(folder)
    assert study_faults(StudyPlan(config.load("base.yaml"))) == []


SECONDS = re.compile(r"\d[\d.e+-]*(?= s\b| on one core)")


def contents(path):
    """Contents of a file of results without the seconds it took."""
    if path.suffix != ".nc":
        text = path.read_text(encoding="utf-8")
        return SECONDS.sub("", text) if path.suffix == ".html" else text
    said = {name: ds.drop_vars([key for key in ds if "seconds" in key]) for name, ds in read_groups(path).items()}
    for ds in said.values():
        ds.attrs = {key: value for key, value in ds.attrs.items() if "seconds" not in key and key != "checksum"}
    return repr([(name, ds.to_dict()) for name, ds in said.items()])


@pytest.mark.slow
def test_vsb_run_gives_the_same_files_as_the_workflow(folder, tmp_path, monkeypatch):
    """By panels, with the second solver."""
    shutil.copytree(folder / "results/hydro/green", tmp_path / "results/hydro/green")
    results = run_in_process(tmp_path, BASE)
    for path in results.plan.file_ids:
        assert contents(tmp_path / path) == contents(folder / path), path
    rows = csv.DictReader((folder / "results/base/comparison.csv").open())
    monkeypatch.chdir(tmp_path)
    assert [row["power_mean"] for row in rows] == [
        f"{row['power_mean']:.10g}" for row in results.comparison.to_dict("records")
    ]


@pytest.mark.slow
def test_changes_rerun_only_what_depends_on_them(folder):
    rules = planned(folder, with_(pto={"damping": 5000.0}), "pto")
    assert rules == {"response": 1, "simulate": 1, "results": 1}
    clamped = with_(study="other", designs={"clamped": {"clamp": 0}}, waves=[{"kind": "still"}])
    assert not {"meshes", *SCIENCE} & set(planned(folder, clamped))
    stiff = with_(study="stiff", device={"young_modulus": 1e9, "density": 7850.0, "internal_pressure": 1e3})
    assert not {"panels", "spectral", "cross_check"} & set(planned(folder, stiff))
    assert not {"panels", "spectral"} & set(planned(folder, with_(study="both", modes={"basis": "full", "degree": 2})))
    assert planned(folder, with_(study="wide", hydro={"omega_max": 7.0}))["panels"] == 1


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
    """Wait for a condition while a process runs."""
    deadline = time.time() + 120
    while not condition() and process.poll() is None and time.time() < deadline:
        time.sleep(0.02)
    assert condition()


def solvers(process):
    """Processes of a run that solve panels."""
    try:
        started = psutil.Process(process.pid).children(recursive=True)
        return [one for one in started if {"vsb", "panels"} <= {Path(word).name for word in one.cmdline()}]
    except psutil.NoSuchProcess:
        return []


@pytest.mark.slow
def test_killed_run_resumes_to_identical_numbers(folder):
    raw = with_(
        study="killed",
        device={"mass": 16000.0},
        hydro={"witness": "none"},
        simulation={"duration": 12.0, "window": [6.0, 12.0]},
    )
    process = start(folder, "run", write(folder, raw), "--cores", "2", start_new_session=True)
    wait_until(lambda: held(folder / "results/killed/.lock"), process)
    crowded = run(folder, folder / "killed.yaml")
    assert crowded.returncode == 2
    assert crowded.stderr.startswith(
        f"vsb: error: results/killed: another run is at work in this folder (process {process.pid} on "
    )
    blocks, before = folder / "results/hydro/blocks", len(list((folder / "results/hydro/blocks").glob("*.nc")))
    wait_until(lambda: len(list(blocks.glob("*.nc"))) > before, process)
    assert process.poll() is None
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    process = start(folder, "run", folder / "killed.yaml", "--cores", "2")
    wait_until(lambda: solvers(process), process)
    started = psutil.Process(process.pid).children(recursive=True)
    process.terminate()
    assert process.communicate(timeout=60)[1].endswith(
        f"vsb: ended, process {process.pid} by SIGTERM; run the same command again to go on from here\n"
    )
    assert process.returncode == 128 + signal.SIGTERM
    assert psutil.wait_procs(started, timeout=5)[1] == []
    assert not held(folder / "results/.lock")
    assert not (folder / "results/killed/report.html").exists()
    finished = run(folder, folder / "killed.yaml", "results")
    assert finished.returncode == 0, finished.stderr
    resumed = (folder / "results/killed/comparison.csv").read_text()
    shutil.rmtree(folder / "results/killed")
    plan = StudyPlan(config.load(folder / "killed.yaml"))
    for path in [plan.database.out, plan.radiation.out, *(plan.block_path(b) for b in plan.sweep_blocks)]:
        (folder / path).unlink()
    with chdir(folder):
        make(plan, ["results/killed/comparison.csv"])
    assert (folder / "results/killed/comparison.csv").read_text() == resumed


@pytest.mark.slow
def test_failed_check_fails_the_run(folder):
    # 4 rows up to 2 rad/s cannot satisfy Kramers-Kronig: the band ends where the damping peaks
    raw = with_(study="coarse", hydro={"rows": 12, "omega_max": 2.0, "witness": "none"}, waves=[{"kind": "still"}])
    failed = run(folder, write(folder, raw))
    assert failed.returncode == 2
    last = failed.stderr.strip().splitlines()[-1]
    assert last.startswith("vsb: error: hydro database: check 'kramers_kronig' failed: ")
    assert "list the name under hydro.accept" in last


@pytest.fixture(scope="module")
def campaign_folder(tmp_path_factory):
    place = with_seas(tmp_path_factory.mktemp("year"), (1.0, 6.0), (2.2, 9.0), (3.1, 12.0))
    (place / "seed.yaml").write_text(yaml.safe_dump(MEMBER_BASE))
    given = {"campaign": "soft", "study": "seed.yaml", "climate": {"spectra": "sea.txt"}, "tuning": ["one"]}
    given["vary"] = {"device.young_modulus": [1e6, 1e7]}
    (place / "soft.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    return place


def vsb_run(place, *options):
    """What a run of the campaign says, which must succeed."""
    done = run(place, "soft.yaml", *options)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout + done.stderr


def test_campaign_from_plan_to_report(campaign_folder):
    out = vsb_run(campaign_folder, "--cores", "2", "--verbose")
    rows = re.findall(r"^(members|campaign|all|total) +(\d+)$", out, re.MULTILINE)
    assert dict(rows) == {"members": "1", "campaign": "1", "all": "1", "total": "3"}
    assert len(re.findall(r"Finished jobid", out)) == 3
    assert "\x1b" not in out  # progress is for terminals
    assert "results/soft/report.html" in out
    assert "Nothing to be done" in vsb_run(campaign_folder, "-n")


@pytest.mark.slow
def test_snakemakes_report_has_captions_and_categories(campaign_folder):
    """Of all outputs of a campaign."""
    vsb_run(campaign_folder, "--cores", "2")
    options = ["--snakefile", str(HOME / "workflow" / "Snakefile"), "--configfile", "soft.yaml", "--cores", "1"]
    options += ["--workflow-profile", "none", "--report", "all.html"]
    subprocess.run([sys.executable, "-m", "snakemake", *options], cwd=campaign_folder, check=True, timeout=300)
    text = (campaign_folder / "all.html").read_text()
    for part in ("The answer of campaign soft", "A figure of campaign soft", "every point, design and tuning"):
        assert part in text
    assert all(f'"{category}"' in text for category in ("The answer", "Numbers", "Figures"))
