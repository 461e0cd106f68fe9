"""Command run: what goes to Snakemake, what never does, and how all of it ends."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest
import yaml
from conftest import SEED, SMALL_PLAN, told, varied
from snakemake.cli import get_argument_parser
from stages.test_coefficients import SWELL, as_body
from stages.test_members import MODULI, planned, with_seas
from test_cli import written

from vsb.cli import main
from vsb.errors import ConfigError, VsbError
from vsb.stages import run as launcher
from vsb.stages import slurm
from vsb.study.plan import StudyPlan
from vsb.study.study import load


@pytest.mark.parametrize("cores", ["0", "-3", "x", "1.5", ""])
def test_a_run_without_cores_would_wait_for_ever(workplace, capsys, cores):
    with pytest.raises(SystemExit) as stop:
        main(["run", written("study.yaml"), f"--cores={cores}"])
    assert stop.value.code == 2
    assert f"argument --cores/-c: received {cores}, needs a whole number above 0, or all" in capsys.readouterr().err


def test_cores_go_to_snakemake(workplace, monkeypatch):
    seen = []

    monkeypatch.setattr(launcher, "finished", lambda command, **_: seen.append(command) or 0)
    for options in (["-c", "2"], ["--cores", "all"], []):
        assert main(["run", written("study.yaml"), *options, "-n"]) == 0
    assert [command[command.index("none") + 1 :] for command in seen] == [
        ["--cores", "2", "-n"],
        ["--cores", "all", "-n"],
        ["-n"],
    ]


def test_on_slurm_a_short_study_is_run_whole_by_srun_and_a_dry_run_is_none(workplace, monkeypatch):
    seen = []
    monkeypatch.setattr(launcher, "finished", lambda command, **_: seen.append(command) or 0)
    monkeypatch.setattr(launcher, "find_spec", lambda name: True)
    monkeypatch.setattr("vsb.stages.slurm.whole", lambda plan, profile: ["srun", profile["executor"], plan.name])
    cancelled = []
    monkeypatch.setattr("vsb.stages.slurm.cancel", lambda prefix: cancelled.append(prefix) or 0)
    options = (["-c", "4"], [], ["-n"])  # nothing of it is there
    for option in options:
        assert main(["run", written("study.yaml"), "--profile", "slurm", *option]) == 0
    assert [command[: command.index(sys.executable)] for command in seen] == [["srun", "slurm", "seed"]] * 2 + [[]]
    assert [Path(command[command.index("--profile") + 1]).name for command in seen] == ["default", "default", "slurm"]
    assert [command[command.index("--cores") + 1] for command in seen[:2]] == ["4", "2"]
    assert ["--slurm-jobname-prefix" in command for command in seen] == [False, False, True]
    assert cancelled == [slurm.whole_name(StudyPlan(load("study.yaml")))] * 2  # what a killed run left behind


def test_where_nothing_is_left_to_do_slurm_is_asked_for_nothing(workplace, monkeypatch):
    seen = []
    monkeypatch.setattr(launcher, "finished", lambda command, **_: seen.append(command) or 0)
    monkeypatch.setattr(launcher, "find_spec", lambda name: True)
    monkeypatch.setattr("vsb.stages.slurm.whole", lambda plan, profile: ["srun"])
    monkeypatch.setattr("vsb.stages.slurm.cancel", lambda prefix: 0)
    monkeypatch.setattr("vsb.stages.verify.stale_products", lambda plan, dry: [])
    monkeypatch.setattr(StudyPlan, "products", ["study.yaml"])
    assert main(["run", written("study.yaml"), "--profile", "slurm"]) == 0
    monkeypatch.setattr("vsb.stages.verify.stale_products", lambda plan, dry: ["old.csv"])
    assert main(["run", written("study.yaml"), "--profile", "slurm"]) == 0
    monkeypatch.setattr("vsb.stages.verify.stale_products", lambda plan, dry: [])
    assert main(["run", written("study.yaml"), "--profile", "slurm", "--forceall"]) == 0  # asked to make it again
    assert [command[0] for command in seen] == [sys.executable, "srun", "srun"]


@pytest.mark.parametrize("short", [True, False])
def test_a_run_on_slurm_that_is_interrupted_cancels_the_jobs_it_named(workplace, monkeypatch, short):
    """The one of all that is short, or those of its rules, which the plug-in names by what it is told."""
    commands, cancelled = [], []

    def interrupted(command, **_):
        commands.append(command)
        raise KeyboardInterrupt

    monkeypatch.setattr(launcher, "finished", interrupted)
    monkeypatch.setattr(launcher, "find_spec", lambda name: True)
    monkeypatch.setattr("vsb.stages.slurm.whole", lambda plan, profile: ["srun"] if short else [])
    monkeypatch.setattr("vsb.stages.slurm.cancel", lambda prefix: cancelled.append(prefix) or 0)
    config = written("study.yaml")
    plan = StudyPlan(load(config))
    assert main(["run", config, "--profile", "slurm"]) == 130
    (command,), (before, own) = commands, cancelled
    assert before == slurm.whole_name(plan)
    assert own == (slurm.whole_name(plan) if short else slurm.job_name("seed"))
    told = command[command.index("--slurm-jobname-prefix") + 1] if "--slurm-jobname-prefix" in command else None
    assert told == (None if short else slurm.job_name("seed"))


@pytest.mark.parametrize("option", ["-n", "--dry-run", "--dryrun"])
def test_a_dry_run_by_any_name_holds_nothing_and_tells_of_no_report(workplace, monkeypatch, capsys, option):
    """Nor is a report of before what it made."""
    held, asked = [], []
    monkeypatch.setattr(launcher, "finished", lambda command, pass_fds, **_: held.append(pass_fds) or 0)
    monkeypatch.setattr("vsb.stages.verify.stale_products", lambda plan, dry: asked.append(dry) or [])
    Path("results/seed").mkdir(parents=True)
    Path("results/seed/report.html").write_text("of before")
    assert main(["run", written("study.yaml"), option]) == 0
    assert (held, asked) == ([[]], [True])
    assert capsys.readouterr().out == ""
    assert not Path("results/hydro").exists()


def test_a_run_sees_the_programs_beside_its_own_first_and_no_modules_of_the_current_folder(workplace, monkeypatch):
    seen = []
    monkeypatch.setattr(launcher, "finished", lambda command, env, **_: seen.append(env) or 0)
    monkeypatch.setenv("PATH", "/one:/two")
    monkeypatch.setenv("OWN", "kept")
    assert main(["run", written("study.yaml"), "-n"]) == 0
    (env,) = seen
    assert env["PATH"] == f"{Path(sys.executable).parent}:/one:/two"
    assert (env["PYTHONSAFEPATH"], env["OWN"]) == ("1", "kept")


@pytest.mark.parametrize(
    ("mark", "kind"),
    [("campaign.nc", "study"), ("members", "study"), ("study.json", "campaign"), ("modes.nc", "campaign")],
)
def test_a_name_is_of_a_study_or_of_a_campaign(tmp_path, monkeypatch, mark, kind):
    """By either of the files that the other leaves first; its own are no hindrance."""

    class Campaign(SimpleNamespace):
        """A plan of a campaign."""

    monkeypatch.setattr(launcher, "CampaignPlan", Campaign)
    plans = {"study": SimpleNamespace, "campaign": Campaign}
    plan, other = (plans[one](folder=tmp_path, name="twice") for one in (kind, *(plans.keys() - {kind})))
    launcher.check_name(plan)
    (tmp_path / mark).touch()
    launcher.check_name(other)
    its = {"study": "campaign", "campaign": "study"}[kind]
    needs = f"{kind}: received twice, the name of a {its} with results in {tmp_path}; needs another"
    with pytest.raises(ConfigError, match=f"^{re.escape(needs)}$"):
        launcher.check_name(plan)


@pytest.mark.parametrize("name", ["nowhere", "mine", "./nowhere"])
def test_an_unknown_profile_is_one_line(workplace, capsys, name):
    for folder in (Path("mine"), Path("profiles/mine")):  # of the current folder only if told so
        folder.mkdir(parents=True)
        (folder / "config.yaml").write_text("cores: 1")
    line = told(["run", written("study.yaml"), "--profile", name], capsys)
    assert line.startswith(f"--profile: received {name}, needs default, slurm, or the path of a folder of your own (./")
    assert not Path("results").exists()


def test_a_profile_of_the_users_own_is_named_by_its_path(workplace, monkeypatch):
    seen = []
    monkeypatch.setattr(launcher, "finished", lambda command, **_: seen.extend(command) or 0)
    Path("mine").mkdir()
    Path("mine/config.yaml").write_text("cores: 1")
    assert main(["run", written("study.yaml"), "--profile", "./mine", "-n"]) == 0
    assert seen[seen.index("--profile") + 1] == "mine"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--frobnicate"], "unrecognized arguments: --frobnicate, of snakemake"),
        (["--jobs", "many"], "Error parsing number of jobs (--jobs, -j): must be integer., of snakemake"),
        (
            ["nowhere"],
            "target: received nowhere, needs one of all, coefficients, compare, database, ",
        ),
        (["results-of-another/report.html"], "target: received results-of-another/report.html, needs one of all, "),
        (["database", "nowhere"], "target: received nowhere, needs one of all, coefficients, compare, database, "),
    ],
)
def test_what_snakemake_would_answer_with_pages_is_one_line(workplace, capsys, options, message):
    assert told(["run", written("study.yaml"), *options], capsys).startswith(message)
    assert not Path("results").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--kep-going"], "unrecognized arguments: --kep-going, of snakemake; did you mean --keep-going?"),
        (["--xyzzyq"], "unrecognized arguments: --xyzzyq, of snakemake"),
        (["--retries"], ": expected one argument, of snakemake"),
        (["--retries=--kep-going"], ": invalid int value: '--kep-going', of snakemake"),
        (["database", "coeficients"], r"results; did you mean coefficients?"),
        (["nowhere"], "or a file in results"),
    ],
)
def test_of_what_snakemake_does_not_know_the_nearest_is_told_if_there_is_one(workplace, capsys, options, message):
    assert told(["run", written("study.yaml"), *options], capsys).endswith(message)


@pytest.mark.parametrize("options", [["database", "results/a/report.html"], ["--version"]])
def test_targets_files_among_the_results_and_what_snakemake_only_tells_go_through(workplace, monkeypatch, options):
    seen = []
    monkeypatch.setattr(launcher, "finished", lambda command, **_: seen.extend(command) or 0)
    assert main(["run", written("study.yaml"), *options, "-n"]) == 0
    assert set(options) <= set(seen)


@pytest.mark.parametrize(("number", "code"), [("TERM", 143), ("INT", 130), ("HUP", 129)])
def test_a_command_told_to_end_ends_all_it_started(tmp_path, number, code):
    """Its children too, which would go on for minutes and hold the lock."""
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
    _, told = process.communicate(timeout=20)
    assert process.returncode == code
    assert told.count("\n") == 1
    assert "run the same command again" in told
    children = [one for one in psutil.process_iter(["cmdline"]) if str(tmp_path) in " ".join(one.info["cmdline"] or [])]
    assert children == []


def test_what_is_stale_is_made_anew_beside_what_the_user_asks_for():
    assert launcher._forced(["-n"], []) == ["-n"]
    assert launcher._forced(["-n"], ["a.nc"]) == ["-n", "--forcerun", "a.nc"]
    assert launcher._forced(["-R", "simulate", "-n"], ["a.nc"]) == ["-R", "a.nc", "simulate", "-n"]
    assert launcher._forced(["--forcerun", "simulate"], ["a", "b"]) == ["--forcerun", "a", "b", "simulate"]


@pytest.mark.parametrize(
    ("asked", "handed"),
    [(["-n"], ["-n", "--forcerun", "old.csv"]), (["-n", "-R", "simulate"], ["-n", "-R", "old.csv", "simulate"])],
)
def test_a_run_hands_what_is_stale_to_snakemake(workplace, monkeypatch, asked, handed):
    """Files that are damaged are there, and no older than what they are made of."""
    seen = []
    monkeypatch.setattr(launcher, "finished", lambda command, **_: seen.append(command) or 0)
    monkeypatch.setattr("vsb.stages.verify.stale_products", lambda plan, dry: ["old.csv"])
    assert main(["run", written("study.yaml"), *asked]) == 0
    (command,) = seen
    assert command[command.index("none") + 1 :] == handed


def test_of_a_run_that_failed_the_rules_own_line_comes_last(workplace, capsys):
    plan, logs = StudyPlan(load(SEED)), Path("results/logs")
    assert launcher._failed(plan, 0.0) == 1
    assert capsys.readouterr().err == "vsb: error: the run of 'seed' did not complete, see above\n"
    logs.mkdir(parents=True)
    (logs / "simulate.log").write_text("a step\nvsb: error: device.mass: too heavy\n")
    assert launcher._failed(plan, 0.0) == 2
    assert capsys.readouterr().err == "vsb: error: device.mass: too heavy\n"
    begun = (logs / "simulate.log").stat().st_mtime
    assert launcher._failed(plan, begun + 0.9) == 2  # clocks of file systems are coarse
    assert launcher._failed(plan, begun + 1.1) == 1  # of a run before
    capsys.readouterr()
    (logs / "simulate.log").write_text("vsb: error: the first\nvsb: error: the last\nwords after it\n")
    assert launcher._failed(plan, 0.0) == 2
    assert capsys.readouterr().err == "vsb: error: the last\n"


TOLD = """Building DAG of jobs...
CalledProcessError in file "workflow/rules/simulate.smk", line 24:
Command 'set -euo pipefail;  vsb simulate  --out a.nc <<< '{"designs":{}}' > results/logs/simulate/seed/FSB-still.log 2>&1' returned non-zero exit status 137.
Exiting because a job execution failed. Look above for error messages
"""


def test_logs_and_what_is_told_may_hold_what_is_no_text(workplace, capsys):
    """Words of another alphabet, or cut within a letter: all the rest is told as ever."""
    plan, log = StudyPlan(load(SEED)), Path("results/logs/simulate/seed/FSB-still.log")
    log.parent.mkdir(parents=True)
    log.write_bytes(b"a caf\xe9\nvsb: error: device.mass: too heavy\n\xc3")
    assert launcher._failed(plan, 0.0) == 2
    assert capsys.readouterr().err == "vsb: error: device.mass: too heavy\n"
    log.write_bytes(b"no caf\xe9\n")
    assert launcher._failed(plan, 0.0, TOLD.splitlines(keepends=True)) == 1
    assert "simulate ended with no caf\ufffd; all that was told is in " in capsys.readouterr().err
    found = []
    assert launcher.finished(["bash", "-c", "printf 'one \\351\\ntwo\\n'"], {}, line=found.extend) == 0
    assert (len(found), found[0][:4], found[1]) == (2, "one ", "two\n")


def test_of_a_run_shown_as_one_line_what_nobody_saw_is_kept_if_no_rule_says_what_is_wrong(workplace, capsys):
    """One line, none of Snakemake's words: which rule, its last words, and where the rest is."""
    plan, log = StudyPlan(load(SEED)), Path("results/logs/simulate/seed/FSB-still.log")
    begins, ends = "vsb: error: the run of 'seed' did not complete: ", "all that was told is in results/logs/seed.log\n"
    assert launcher._failed(plan, 0.0, TOLD.splitlines(keepends=True)) == 1
    killed = "simulate ended without a word, as when it is killed or memory is out; "
    assert capsys.readouterr().err == begins + killed + ends
    assert Path("results/logs/seed.log").read_text() == TOLD
    log.parent.mkdir(parents=True)
    log.write_text("Traceback\nMemoryError: no room\n\n")
    assert launcher._failed(plan, 0.0, TOLD.splitlines(keepends=True)) == 1
    assert capsys.readouterr().err == begins + "simulate ended with MemoryError: no room; " + ends
    other = TOLD.replace(str(log), "results/logs/radiation.log").replace("simulate", "radiation")
    assert launcher._failed(plan, 0.0, (TOLD + other).splitlines(keepends=True)) == 1
    both = "simulate ended with MemoryError: no room; " + killed.replace("simulate", "radiation")
    assert capsys.readouterr().err == begins + both + ends
    log.write_text("vsb: error: device.mass: too heavy\n")
    assert launcher._failed(plan, 0.0, ["Building DAG\n"]) == 2
    assert capsys.readouterr().err == "vsb: error: device.mass: too heavy\n"


def test_of_a_full_disk_one_line_is_left(workplace, capsys):
    Path("results").mkdir()
    Path("results/logs").write_text("")  # no folder can be made of it
    told = ["Building DAG\n", "OSError: [Errno 28] No space left on device\n"]
    assert launcher._failed(StudyPlan(load(SEED)), 0.0, told) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(
        "vsb: error: the run of 'seed' did not complete: No space left on device; what was told cannot"
    )


def test_what_the_system_says_is_told_where_no_rule_failed_and_then_its_last_words(workplace, capsys):
    plan, own = StudyPlan(load(SEED)), [f"OSError: [Errno {n}] {text}\n" for n, text in ((5, "first"), (28, "last"))]
    begins, ends = (
        "vsb: error: the run of 'seed' did not complete: ",
        "; all that was told is in results/logs/seed.log\n",
    )
    assert launcher._failed(plan, 0.0, own) == 1
    assert capsys.readouterr().err == f"{begins}last{ends}"
    log = Path("results/logs/simulate/seed/FSB-still.log")
    log.parent.mkdir(parents=True)
    log.write_text("  \na word   \n   \n")
    assert launcher._failed(plan, 0.0, [*own, *TOLD.splitlines(keepends=True)]) == 1
    assert capsys.readouterr().err == f"{begins}simulate ended with a word{ends}"


def test_a_run_is_one_line_where_somebody_looks_on_and_asks_nothing_more(monkeypatch):
    plan, last = StudyPlan(load(SEED)), []
    assert launcher._line([], plan, last) is None
    for stream in (sys.stdout, sys.stderr):
        monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)
    assert launcher._line(["-n"], plan, last) is None
    launcher._line([], plan, last)(["1 of 2 steps (50%) done\n"])
    assert last == ["1 of 2 steps (50%) done\n"]


def test_what_follows_a_command_gets_all_it_tells():
    found = []
    code = launcher.finished(["bash", "-c", "echo one; echo two >&2; exit 4"], {}, line=found.extend)
    assert (code, found) == (4, ["one\n", "two\n"])


def test_while_a_command_begins_something_else_is_done(tmp_path):
    """The command waits here for what is done meanwhile."""
    mark, script = tmp_path / "mark", 'for i in $(seq 500); do [ -e "$0" ] && exit 5; sleep 0.02; done'
    assert launcher.finished(["bash", "-c", script, str(mark)], {"PATH": "/usr/bin:/bin"}, meanwhile=mark.touch) == 5


def test_the_exit_code_of_a_command_is_returned_and_signals_are_heard_as_before():
    before = [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT)]
    assert launcher.finished(["bash", "-c", "exit 3"], {}) == 3
    assert [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT)] == before


def test_a_command_that_cannot_begin_leaves_interruptions_heard():
    with pytest.raises(FileNotFoundError):
        launcher.finished(["/nowhere/at/all"], {})
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_an_interruption_while_the_command_begins_is_not_lost(monkeypatch):
    """A moment in which it is ignored, so that what is started ignores it, must not swallow it."""
    begun, popen = [], subprocess.Popen

    def interrupted(*args, **options):
        begun.append(popen(*args, **options))
        signal.raise_signal(signal.SIGINT)
        return begun[0]

    monkeypatch.setattr(launcher.subprocess, "Popen", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored by what runs behind a shell
    try:
        with pytest.raises(KeyboardInterrupt):
            launcher.finished(["sleep", "100"], {"PATH": "/usr/bin:/bin"})
    finally:
        signal.signal(signal.SIGINT, before)
    assert begun[0].returncode == -signal.SIGKILL


def test_records_snakemake_cannot_read_are_forgotten_and_the_others_kept(tmp_path):
    """It ends in a traceback over them; what results are, they know themselves."""
    good = [b'{"input": ["a.nc"], "params": ["x"], "log": []}', b'{"code": null, "params": null}', b"{}"]
    bad = [
        b"",
        b"{",
        b"\xff\xfe",
        b"[]",
        b'"x"',
        b"[" * 100_000,
        b"9" * 100_000,
        b'{"params": 5}',
        b'{"input": "a"}',
        b'{"log": {"a": 1}}',
    ]
    (tmp_path / "@deeper").mkdir()
    for number, content in enumerate([*good, *bad]):
        (tmp_path / ("@deeper" if number % 2 else ".") / str(number)).write_bytes(content)
    launcher.forget_damaged(tmp_path)
    assert sorted(path.name for path in tmp_path.rglob("*") if path.is_file()) == ["0", "1", "2"]
    launcher.forget_damaged(tmp_path / "nowhere")


class Starting:
    """A process that starts another each time it is looked at, until it is stopped."""

    def __init__(self, most=5):
        self.started, self.most, self.stopped, self.killed = [], most, False, False

    def children(self, recursive):
        for one in [self, *self.started]:
            if not one.stopped and len(self.started) < self.most:
                self.started.append(Starting(0))
        return [*self.started]

    def suspend(self):
        self.stopped = True

    def kill(self):
        assert self.stopped
        self.killed = True


def test_what_starts_processes_while_it_is_ended_leaves_none(monkeypatch):
    """Each is stopped as soon as it is seen, so that what is killed in the end is all there is."""
    root = Starting()
    monkeypatch.setattr(launcher.psutil, "Process", lambda pid: root)
    launcher._end(1)
    assert all(one.killed for one in (root, *root.started))
    assert len(root.started) < root.most


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("study", "pto.stiffness: received -1e+06 N/m, with which a buoy does not rest"),
        ("body", "waves.0.direction: received 30 degrees, needs one of 0"),
        ("campaign", "hydro.omega_max: received 2.5 rad/s, needs at least "),
    ],
)
def test_what_would_fail_later_is_told_before_a_run_begins(finished, workplace, monkeypatch, capsys, kind, message):
    monkeypatch.setattr(launcher, "finished", lambda command, **_: pytest.fail("a run was begun"))
    name = f"{kind}.yaml"
    if kind == "campaign":
        planned(with_seas(workplace, (1.0, 6.0)), {"hydro.omega_max": [5.0, 2.5]}, name=kind)
    elif kind == "body":
        Path(name).write_text(yaml.safe_dump(as_body(finished, waves=[{**SWELL, "direction": 30.0}])))
    else:
        written(name, pto={"damping": 1.0, "stiffness": -1e6})
    assert message in told(["run", name], capsys)


def test_a_run_locks_only_what_it_will_make_for_others_too(finished, workplace, monkeypatch):
    """Who only reads needs no permission to write among the shared files: blocks are not made where a database is."""
    shutil.copytree(finished / "results", "results")
    shutil.rmtree("results/hydro/blocks")
    assert launcher.unmade(SMALL_PLAN) == []
    Path(SMALL_PLAN.radiation_path).unlink()
    assert launcher.unmade(SMALL_PLAN) == [SMALL_PLAN.radiation_path]
    Path(SMALL_PLAN.database_path).unlink()
    blocks = {SMALL_PLAN.block_path(block) for block in SMALL_PLAN.sweep_blocks}
    assert set(launcher.unmade(SMALL_PLAN)) >= {SMALL_PLAN.radiation_path, SMALL_PLAN.database_path, *blocks}
    assert launcher.unmade(planned(with_seas(workplace, (1.0, 6.0)), MODULI)) == []


@pytest.mark.parametrize("text", ["", "- cores", "cores", "3"])
def test_a_profile_that_is_no_mapping_says_nothing(workplace, text):
    """An empty one is a profile all the same; of others it is Snakemake that says what it needs."""
    Path("config.yaml").write_text(text)
    assert launcher._settings(Path("config.yaml")) == {}


def test_what_runs_a_study_holds_its_folder_and_all_it_makes_for_others_too(workplace, monkeypatch):
    """Locks go with the processes that hold them: a run that is killed must not let go of what its jobs still make."""
    held = []

    def finished(command, pass_fds, **_):
        held.append({os.path.relpath(os.readlink(f"/proc/self/fd/{one}")) for one in pass_fds})
        return 0

    monkeypatch.setattr(launcher, "finished", finished)
    monkeypatch.delenv("PATH")
    for options in ([], ["-n"]):
        assert main(["run", written("study.yaml"), *options]) == 0
    plan = StudyPlan(load("study.yaml"))
    shared = {Path(path) for path in launcher.unmade(plan)}
    named = {path.stem for path in shared if path.suffix == ".nc" and path.parent.name in ("db", "radiation")}
    locks, nothing = held
    assert nothing == set()
    assert f"{plan.folder}/.lock" in locks
    assert {f"results/hydro/.locks/{name}" for name in named} < locks
    assert locks == {
        f"{plan.folder}/.lock",
        *(f"results/hydro/.locks/{p.name}" for p in Path("results/hydro/.locks").iterdir()),
    }


def test_a_plugin_that_is_missing_is_named_as_pip_knows_it(workplace, capsys):
    Path("mine").mkdir()
    Path("mine/config.yaml").write_text("executor: cluster-nowhere")
    line = told(["run", written("study.yaml"), "--profile", "./mine"], capsys)
    needed = "which is not installed; needs pip install snakemake-executor-plugin-cluster-nowhere"
    assert line.removeprefix("vsb: ").strip() == f"mine/config.yaml: executor: received cluster-nowhere, {needed}"


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("executor: cluster-generic", ["snakemake_executor_plugin_cluster_generic"]),
        ("executor: tes-by-hand", ["snakemake_executor_plugin_tes_by_hand"]),
        ("executor: slurm", ["snakemake_executor_plugin_slurm"]),
        ("executor: local", []),
        ("cores: 3", []),
    ],
)
def test_a_plugin_is_looked_for_by_the_name_of_its_module(workplace, monkeypatch, text, asked):
    """What runs jobs here needs none."""
    seen = []
    monkeypatch.setattr(launcher, "find_spec", lambda name: seen.append(name) or True)
    Path("config.yaml").write_text(text)
    assert launcher._settings(Path("config.yaml")) == yaml.safe_load(text)
    assert seen == asked


def test_the_plugin_of_slurm_comes_with_an_extra_of_vsb(workplace, monkeypatch, capsys):
    monkeypatch.setattr(launcher, "find_spec", lambda name: None)
    Path("mine").mkdir()
    Path("mine/config.yaml").write_text("executor: slurm")
    line = told(["run", written("study.yaml"), "--profile", "./mine"], capsys)
    assert line.endswith("executor: received slurm, which is not installed; needs pip install 'vsb[slurm]'")


def test_a_run_that_failed_tells_of_its_own_logs_only(workplace, monkeypatch, capsys):
    logs = Path("results/logs")
    logs.mkdir(parents=True)
    (logs / "old.log").write_text("vsb: error: of a run before\n")
    os.utime(logs / "old.log", (0.0, 0.0))
    monkeypatch.setattr(launcher, "finished", lambda command, **_: 1)
    assert main(["run", written("study.yaml")]) == 1
    assert capsys.readouterr().err == "vsb: error: the run of 'seed' did not complete, see above\n"

    def mistaken(command, **_):
        (logs / "simulate.log").write_text("vsb: error: device.mass: too heavy\n")
        return 1

    monkeypatch.setattr(launcher, "finished", mistaken)
    assert main(["run", written("study.yaml")]) == 2
    assert capsys.readouterr().err == "vsb: error: device.mass: too heavy\n"


@pytest.mark.parametrize(
    "options",
    [
        ["-R", "a", "-R", "b"], ["--forcerun", "a", "-n", "-R", "b"], ["--forcerun=b"], ["-Rb"], ["-R=b", "-n"],
        ["--forceru", "a", "b"], ["-n"], ["--forceall"], ["--force", "b"], ["--forcerun", "b", "--cores", "2"],
    ],
)  # fmt: skip
def test_snakemake_hears_of_all_that_is_stale_however_it_is_asked_for_more(options):
    """Of several lists it takes the last; what it would do without anything stale it does all the same."""
    parser = get_argument_parser()
    asked, given = (parser.parse_args(launcher._forced(options, stale)) for stale in ([], ["old.csv", "x.nc"]))
    assert given.forcerun == {*asked.forcerun, "old.csv", "x.nc"}
    told = [[vars(one)[name] for name in ("targets", "dryrun", "force", "forceall", "cores")] for one in (asked, given)]
    assert told[0] == told[1]


@pytest.mark.parametrize(("out", "err", "shown"), [(True, True, True), (True, False, False), (False, True, False)])
def test_a_line_is_shown_only_where_both_streams_are_seen(monkeypatch, out, err, shown):
    for stream, seen in ((sys.stdout, out), (sys.stderr, err)):
        monkeypatch.setattr(stream, "isatty", lambda seen=seen: seen, raising=False)
    assert (launcher._line([], StudyPlan(load(SEED)), []) is not None) == shown


@pytest.mark.parametrize("dry", [False, True])
def test_a_run_that_is_over_tells_its_answer_and_where_its_report_is(workplace, monkeypatch, capsys, dry):
    """Of what it made; both folders snakemake writes to were looked at before."""
    looked, given = [], []
    monkeypatch.setattr("vsb.tools.files.check_folder", looked.append)
    monkeypatch.setattr("vsb.stages.verify.stale_products", lambda plan, dry: [])
    monkeypatch.setattr(launcher, "finished", lambda command, **named: given.append(named) or 0)
    monkeypatch.setattr(launcher, "_answer", lambda plan: f"the answer of {plan.name}; ")
    monkeypatch.setattr(launcher, "_line", lambda options, plan, last: (options, plan.name, last))
    assert main(["run", written("study.yaml"), *["-n"] * dry]) == 0
    assert capsys.readouterr().out == ""
    Path("results/seed").mkdir(parents=True, exist_ok=True)
    Path("results/seed/report.html").touch()
    assert main(["run", "study.yaml", *["-n"] * dry]) == 0
    assert capsys.readouterr().out == ("" if dry else "seed: the answer of seed; results/seed/report.html\n")
    assert looked == [".", "results"] * 2
    options, name, last = given[-1]["line"]
    assert (options, name, last.maxlen) == (["-n"] * dry, "seed", launcher.KEPT)


def test_the_answer_of_a_study_is_of_its_own_checked_tables_over_its_rigid_design(monkeypatch):
    plan, asked = StudyPlan(varied(load(SEED), designs={"A": {}, "B": {"flexible": False}})), []
    tables = '{"equal_tuning": ["tuned"], "comparison": ["run"], "invalid": ["broken"]}'
    monkeypatch.setattr("vsb.tools.stamps.read_text", lambda *given: asked.append(given) or tables)
    monkeypatch.setattr("vsb.report.tuned.closing_line", lambda *given: given)
    assert launcher._answer(plan) == (["tuned"], "B", ["broken"])
    assert asked == [("results/seed/tables.json", plan.manifest, plan.study_id)]


def test_the_answer_of_a_campaign_is_of_its_own_data(workplace, monkeypatch):
    plan = planned(with_seas(workplace, (1.0, 6.0)), MODULI)
    monkeypatch.setattr("vsb.tools.files.load", lambda path, expected: f"{path} {expected}")
    monkeypatch.setattr("vsb.report.campaign_answer.closing_answer", lambda data: f"told of {data}:")
    assert launcher._answer(plan) == f"told of {plan.data_path} {plan.campaign_id}: "


def test_a_signal_that_is_ignored_stays_so_while_a_command_runs():
    """As behind nohup; others are heard by what ends the command, until it is over."""
    before = {number: signal.getsignal(number) for number in (signal.SIGHUP, signal.SIGTERM)}
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        heard = []
        look = lambda: heard.extend(signal.getsignal(number) for number in before)  # noqa: E731
        assert launcher.finished(["true"], {"PATH": "/usr/bin:/bin"}, meanwhile=look) == 0
        assert heard == [signal.SIG_IGN, launcher._told_to_end]
        assert [signal.getsignal(number) for number in before] == [signal.SIG_IGN, signal.SIG_DFL]
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_command_told_to_end_while_it_begins_is_ended_once_it_has_begun(monkeypatch, capsys, number):
    begun, popen, done = [], subprocess.Popen, []

    def told_to_end(*args, **options):
        begun.append(popen(*args, **options))
        signal.raise_signal(number)
        return begun[0]

    monkeypatch.setattr(launcher.subprocess, "Popen", told_to_end)
    before = signal.signal(number, signal.SIG_DFL)
    try:
        with pytest.raises(SystemExit) as stop:
            launcher.finished(["sleep", "100"], {"PATH": "/usr/bin:/bin"}, meanwhile=lambda: done.append(1))
    finally:
        signal.signal(number, before)
    assert stop.value.code == 128 + number
    assert (begun[0].returncode, done) == (-signal.SIGKILL, [])
    assert capsys.readouterr().err == "vsb: ended; run the same command again to go on from here\n"


def test_what_has_ended_by_itself_meanwhile_needs_no_end(monkeypatch):
    """A process that is gone, or goes while its children are looked for."""

    class Gone(Starting):
        """One that is gone when it is told anything."""

        def suspend(self):
            raise psutil.NoSuchProcess(1)

        kill = suspend

    root, other = Starting(0), Gone(0)
    root.started, other.stopped = [other, Starting(0)], True
    monkeypatch.setattr(launcher.psutil, "Process", lambda pid: root)
    launcher._end(1)
    assert [one.killed for one in (root, *root.started)] == [True, False, True]

    def none(pid):
        raise psutil.NoSuchProcess(pid)

    monkeypatch.setattr(launcher.psutil, "Process", none)
    launcher._end(1)


def test_what_a_run_told_unseen_is_kept_when_it_fails_and_records_that_are_damaged_are_gone_before(
    workplace, monkeypatch, capsys
):
    record = Path(".snakemake/metadata/bad")
    record.parent.mkdir(parents=True)
    record.write_text("{")
    monkeypatch.setattr(launcher, "_line", lambda options, plan, last: last.extend)

    def finished(command, line, **_):
        assert not record.exists()
        line(["Building DAG\n", "OSError: [Errno 28] No space left on device\n"])
        return 1

    monkeypatch.setattr(launcher, "finished", finished)
    assert main(["run", written("study.yaml")]) == 1
    told = "the run of 'seed' did not complete: No space left on device; all that was told is in results/logs/seed.log"
    assert capsys.readouterr().err == f"vsb: error: {told}\n"
    assert Path("results/logs/seed.log").read_text().startswith("Building DAG\nOSError")


@pytest.mark.parametrize(
    ("option", "near"), [("--proflie", "--profile"), ("--crores", "--cores"), ("--dry-rum", "--dry-run")]
)
def test_options_of_the_command_itself_are_among_those_that_may_be_meant(option, near):
    needs = f"unrecognized arguments: {option}, of snakemake; did you mean {near}?"
    with pytest.raises(VsbError, match=f"^{re.escape(needs)}$"):
        launcher.check_options([option], StudyPlan(load(SEED)))
