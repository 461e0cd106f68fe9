"""Command run: errors before the run, child processes, and how a failed run is reported."""

import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
import yaml
from conftest import SEED, error_line
from stages.test_coefficients import SWELL, as_body
from stages.test_members import planned, with_seas
from test_cli import written

from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.jobs import cores
from vsb.stages import run as launcher
from vsb.study.study import load


@pytest.mark.parametrize("name", ["mine", "./nowhere"])
def test_unknown_profile_is_reported_before_the_run(workplace, capsys, name):
    for folder in (Path("mine"), Path("profiles/mine")):  # of the current folder only if named by a path
        folder.mkdir(parents=True)
        (folder / "config.yaml").write_text("cores: 1")
    line = error_line(["run", written("study.yaml"), "--profile", name], capsys)
    assert line.startswith(f"--profile: received {name}, needs default, slurm, or the path of a folder of your own (./")
    assert not Path("results").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--kep-going"], "unrecognized arguments: --kep-going, of snakemake; did you mean --keep-going?"),
        (["--proflie"], "unrecognized arguments: --proflie, of snakemake; did you mean --profile?"),
        (["--jobs", "many"], "Error parsing number of jobs (--jobs, -j): must be integer., of snakemake"),
        (["other/report.html"], "target: received other/report.html, needs one of all, modes, meshes, "),
        (["database", "nowhere"], "target: received nowhere, needs one of all, modes, meshes, "),
    ],
)
def test_wrong_snakemake_options_give_one_line_with_a_suggestion(workplace, capsys, options, message):
    assert error_line(["run", written("study.yaml"), *options], capsys).startswith(message)
    assert not Path("results").exists()


@pytest.mark.parametrize(("number", "code"), [("TERM", 143), ("INT", 130)])
def test_terminated_run_kills_all_its_child_processes(tmp_path, number, code):
    """Which would go on for minutes and hold the lock."""
    job = f"echo $$ > {tmp_path}/job; sleep 100; echo over"
    program = (
        "import signal, sys\nfrom vsb import cli\nfrom vsb.stages.run import finished\n"
        "signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # ignored by what runs behind a shell
        f"command = ['bash', '-c', 'trap : TERM; ({job}) & wait; wait']\n"
        "cli.run = lambda args: finished(command, None)\nsys.exit(cli.main(['run', 'study.yaml']))"
    )
    process = subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "job").exists() or not (tmp_path / "job").read_text():
        assert process.poll() is None
    process.send_signal(getattr(signal, f"SIG{number}"))
    _, output = process.communicate(timeout=20)
    assert process.returncode == code
    assert output.count("\n") == 1
    assert "run the same command again" in output
    children = [one for one in psutil.process_iter(["cmdline"]) if str(tmp_path) in " ".join(one.info["cmdline"] or [])]
    assert children == []


def test_caches_are_kept_elsewhere_if_there_is_no_place_for_them_at_home(tmp_path, monkeypatch):
    """Snakemake's, without which it ended in a traceback."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    with launcher._caches() as found:
        assert found == {}
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file" / "cache"))
    with launcher._caches() as found:
        folder = Path(found["XDG_CACHE_HOME"])
        assert folder.is_dir()
    assert not folder.exists()


OUTPUT = """Building DAG of jobs...
CalledProcessError in file "workflow/rules/simulate.smk", line 24:
Command 'set -euo pipefail;  vsb stage simulate <<< '[{"stage":"simulate"}]' > results/logs/simulate/seed/FSB-still.log 2>&1' returned non-zero exit status 137.
Exiting because a job execution failed. Look above for error messages
"""


def test_failed_run_reports_rule_and_last_words_and_keeps_the_log(workplace, capsys):
    plan, log = StudyPlan(load(SEED)), Path("results/logs/simulate/seed/FSB-still.log")
    begins, ends = "vsb: error: the run of 'seed' did not complete: ", "the whole output is in results/logs/seed.log\n"
    assert launcher._failed(plan, 0.0, OUTPUT.splitlines(keepends=True)) == 1
    killed = "simulate ended without a word, as when it is killed or memory is out; "
    assert capsys.readouterr().err == begins + killed + ends
    assert Path("results/logs/seed.log").read_text() == OUTPUT
    log.parent.mkdir(parents=True)
    log.write_text("Traceback\nMemoryError: no room\n\n")
    assert launcher._failed(plan, 0.0, OUTPUT.splitlines(keepends=True)) == 1
    assert capsys.readouterr().err == begins + "simulate ended with MemoryError: no room; " + ends
    log.write_text("vsb: error: device.mass: too heavy\n")
    assert launcher._failed(plan, 0.0, ["Building DAG\n"]) == 2
    assert capsys.readouterr().err == "vsb: error: device.mass: too heavy\n"


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("study", "pto.stiffness: received -1e+06 N/m, which makes the buoy statically unstable"),
        ("body", "waves.0.direction: received 30 degrees, needs one of 0"),
        ("campaign", "hydro.omega_max: received 2.5 rad/s, needs at least "),
    ],
)
def test_errors_of_later_stages_are_reported_before_the_run(finished, workplace, capsys, kind, message):
    name = f"{kind}.yaml"
    if kind == "campaign":
        planned(with_seas(workplace, (1.0, 6.0)), {"hydro.omega_max": [5.0, 2.5]}, name=kind)
    elif kind == "body":
        Path(name).write_text(yaml.safe_dump(as_body(finished, waves=[{**SWELL, "direction": 30.0}])))
    else:
        written(name, pto={"damping": 1e3, "stiffness": -1e6})
    assert message in error_line(["run", name], capsys)
    assert not Path("results").exists()


@pytest.mark.skipif(cores() < 2 or not sys.platform.startswith("linux"), reason="a process of one core has one thread")
@pytest.mark.parametrize(("command", "alone"), [("run", True), ("body", False)])
def test_libraries_of_a_run_have_one_thread_of_those_they_could(monkeypatch, command, alone):
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    code = "import os, vsb.cli, numpy; print(len(os.listdir('/proc/self/task')))"
    ended = subprocess.run([sys.executable, "-c", code, command], capture_output=True, text=True, check=True)
    assert (int(ended.stdout) == 1) == alone
