"""Command run: a whole study, alone in its results folder, by this process if it is short, or by Snakemake."""

import argparse
import contextlib
import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from base64 import urlsafe_b64encode
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableSequence, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

import psutil

from vsb.errors import ConfigError, VsbError
from vsb.keys.reading import nearest, read_yaml
from vsb.pipeline.graph import due
from vsb.pipeline.jobs import Job, is_short, left, rules
from vsb.pipeline.plans import CampaignPlan, DesignPlan, Plan, plan_of
from vsb.stages import slurm
from vsb.stages.check import check_plan, unit_lines
from vsb.stages.make import Progress, best_so_far, failed, followed, log_path, make_each
from vsb.stages.stage import exclusive_lock, shared_lock
from vsb.tools.commands import HOME, long_options
from vsb.tools.threads import one_thread
from vsb.tools.words import shortened

Follow = Callable[[Iterable[str]], None]
"""Shows lines as they come."""
KEPT = 4000
"""Last lines of Snakemake's output that are kept."""
ERROR = "vsb: error:"
SNAKEFILE = HOME / "workflow" / "Snakefile"
RECORD_NAME = 254
"""Longest part of the name of a file under which Snakemake keeps a record, its mark left out."""


def run(args: argparse.Namespace) -> int:
    """Check a study, campaign or design problem, then run what is not there yet."""
    from vsb.stages import verify
    from vsb.tools.files import attributes, check_folder

    one_thread()
    plan = plan_of(args.config, args.results)
    check_name(plan)
    check_plan(plan)
    for words in unit_lines(plan):
        print(words, file=sys.stderr)
    check_folder(plan.root)
    check_options(args.snakemake, plan)
    dry = bool({"-n", "--dry-run", "--dryrun"} & set(args.snakemake))
    profile, given = _profile(args.profile or "default")
    asked = args.snakemake or args.verbose or args.profile or args.cores
    with exclusive_lock(Path(plan.folder), waits=not dry) as held:
        stale = verify.stale_products(plan, dry=dry)
        if not asked and is_short(plan, stale):
            _run_here(plan, stale, quiet=args.quiet)
        elif code := _run_by_snakemake(args, plan, stale, profile, given, held, dry=dry):
            return code
    if dry or not (report := Path(plan.folder) / "report.html").is_file():
        return 0
    print(f"{plan.name}: {_answer(plan)}{report}")
    return int(isinstance(plan, DesignPlan) and not attributes(plan.data_path)["valid"])  # others may have part of one


def _run_here(plan: Plan, stale: Sequence[str], *, quiet: bool) -> None:
    """Make all products in this process and forks of it; if terminated, end after one line."""
    some = due(plan.tasks, plan.products, stale)
    before = {number: signal.signal(number, _ask_to_end) for number in _heard()}
    try:
        make_each(plan, some, stale, quiet=quiet, side_by_side=True)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        forget(Path(".snakemake"), [path for task in some for path in task.makes])


def _run_by_snakemake(
    args: argparse.Namespace,
    plan: Plan,
    stale: Sequence[str],
    profile: Path,
    given: Mapping[str, Any],
    held: Sequence[int],
    *,
    dry: bool,
) -> int:
    """Make all products, or what is asked of Snakemake, by its jobs; return the exit code.

    Processes that are left behind keep the locks in `held`.
    """
    from vsb.tools.files import check_folder, write_text

    check_folder(".")  # snakemake writes there, too
    on_slurm = given.get("executor") == "slurm"
    paths = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', os.defpath)}"
    environment = {**os.environ, "PATH": paths, "PYTHONSAFEPATH": "1"}  # nor modules of the current folder
    forget_damaged(Path(".snakemake", "metadata"))
    begun, lines = time.time(), deque[str](maxlen=KEPT)
    with _caches() as caches, shared_lock(plan.root, () if dry else unmade(plan)) as shared:
        environment |= caches
        missing = bool(stale or args.snakemake) or not all(Path(path).exists() for path in plan.products)
        whole = slurm.single_job(plan, given) if on_slurm and missing and not dry else []
        named = ["--slurm-jobname-prefix", slurm.job_name(plan.name)] if on_slurm and not whole else []
        command = [*_command(args, profile, whole), *named, *_forced(args.snakemake, stale)]
        if on_slurm and not dry:
            slurm.cancel(slurm.run_name(plan))  # of a run that was killed
        with (
            ended(slurm.run_name(plan) if whole else slurm.job_name(plan.name))
            if on_slurm
            else contextlib.nullcontext()
        ):
            follow = partial(_followed, plan, left(plan, stale), lines, quiet=args.quiet)
            line = None if args.snakemake or args.verbose else follow
            if line:  # rules that begin are needed to say so
                command += ["--quiet", "host"]
            code = finished(command, env=environment, pass_fds=[*held, *shared], line=line)
    if code:
        return _failed(plan, begun, lines)
    if line:
        with contextlib.suppress(OSError, VsbError):
            write_text(log_path(plan), "".join(lines))
    return 0


def forget(records: Path, paths: Iterable[str]) -> None:
    """Remove what Snakemake noted of files that were made without it; they know themselves what they are."""
    for path in paths:
        name = urlsafe_b64encode(path.encode()).decode()
        parts = [name[i : i + RECORD_NAME] for i in range(0, len(name), RECORD_NAME)]
        for kind in ("metadata", "incomplete"):
            Path(records, kind, *(f"@{part}" for part in parts[:-1]), parts[-1]).unlink(missing_ok=True)


@contextlib.contextmanager
def _caches() -> Iterator[dict[str, str]]:
    """Where snakemake and others keep caches: a folder of this run, if none in the home folder can be written."""
    place = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser(), "snakemake")
    with contextlib.suppress(OSError):
        place.mkdir(parents=True, exist_ok=True)
    if os.access(place, os.W_OK):
        yield {}
        return
    with tempfile.TemporaryDirectory(prefix="vsb-", ignore_cleanup_errors=True) as folder:
        yield {"XDG_CACHE_HOME": folder}


def _command(args: argparse.Namespace, profile: Path, whole: Sequence[str]) -> list[str]:
    """The package's workflow as a profile says; as here if `whole`, a command of Slurm's, runs all of it."""
    workflow = ["--snakefile", str(SNAKEFILE), "--configfile", args.config, "--nolock"]
    workflow += ["--config", f"root={args.results}"] if args.results != "results" else []
    place, cores = (HOME / "profiles" / "default", args.cores or str(slurm.CORES)) if whole else (profile, args.cores)
    settings = ["--profile", str(place), "--workflow-profile", "none", *(["--cores", cores] if cores else [])]
    return [*whole, sys.executable, "-m", "snakemake", *workflow, *settings]


def forget_damaged(records: Path) -> None:
    """Remove what Snakemake noted of jobs and cannot read any more; results themselves know what they are.

    It would end in a traceback, a dry run too.
    """
    for path in records.rglob("*"):
        if path.is_file():
            try:
                record = json.loads(path.read_bytes().decode("utf-8"))
                sound = all(isinstance(record.get(name) or [], list) for name in ("input", "log", "params"))
            except (ValueError, RecursionError, AttributeError):
                sound = False
            if not sound:
                path.unlink(missing_ok=True)


MARKS = {"study": ("study.json", "modes.nc"), "campaign": ("campaign.nc", "members"), "design": ("design.nc", "starts")}
"""What in a folder of results says whose they are."""


def check_name(plan: Plan) -> None:
    """Check that a study, a campaign or a design has not the name of another kind whose results are there.

    Raises `ConfigError`.
    """
    folder = Path(plan.folder)
    for other, marks in MARKS.items():
        if other != plan.KIND and any((folder / mark).exists() for mark in marks):
            raise ConfigError(
                f"{plan.KIND}: received {plan.name}, the name of a {other} with results in {folder}; needs another"
            )


def unmade(plan: Plan) -> list[str]:
    """Return the files a study shares with others and a run of it will make; members of a campaign make theirs."""
    if isinstance(plan, CampaignPlan | DesignPlan):
        return []
    made = [path for task in due(plan.tasks, plan.products) for path in task.makes]
    return [path for path in made if plan.is_shared(path) and not Path(path).exists()]


def _answer(plan: Plan) -> str:
    """The gain at equal tuning and at the given damper, to go before the report's path; of a campaign its answer."""
    if isinstance(plan, CampaignPlan):
        from vsb.report.campaign_answer import closing_answer
        from vsb.tools.files import load

        return f"{closing_answer(load(plan.data_path, expected=plan.identity))} "
    if isinstance(plan, DesignPlan):
        from vsb.tools.files import load

        return f"{load(plan.data_path, expected=plan.identity).attrs['answer']} "
    from vsb.report.answer import answer_of_study
    from vsb.tools.stamps import read_text

    tables = json.loads(read_text(f"{plan.folder}/tables.json", plan.manifest, plan.identity))
    return answer_of_study(plan.study, tables)


def check_options(options: Sequence[str], plan: Plan) -> None:
    """Check what is handed on to snakemake, which would answer a mistake with pages.

    Raises `VsbError` if it is no option of snakemake, no rule, and no file among the results.
    """
    if not set(options) - {"-n", "--dry-run", "--dryrun"}:
        return
    from snakemake.cli import get_argument_parser
    from snakemake.exceptions import CliException

    output, parser = io.StringIO(), get_argument_parser()
    try:
        with contextlib.redirect_stderr(output), contextlib.redirect_stdout(output):
            given = parser.parse_args(list(options))
    except SystemExit as stop:
        if not stop.code:  # of --help and --version
            return
        what = output.getvalue().strip().splitlines()[-1].partition("error: ")[2]
        known = [*long_options(parser), "--profile", "--cores"]
        near = nearest(what.rpartition(" ")[2], known) if what.startswith("unrecognized arguments") else ""
        raise VsbError(f"{what}, of snakemake" + (f"; did you mean {near}?" if near else "")) from None
    except CliException as error:
        raise VsbError(f"{error}, of snakemake") from None
    known = ["all", *(rule.name for rule in rules(plan) if "" in rule.jobs)]  # the others make a file of many
    for target in given.targets:
        if target not in known and not target.startswith(f"{plan.root}/"):
            names, near = ", ".join(known), nearest(target, known)
            meant = f"; did you mean {near}?" if near else ""
            raise VsbError(f"target: received {target}, needs one of {names}, or a file in {plan.root}{meant}")


@contextlib.contextmanager
def ended(prefix: str) -> Iterator[None]:
    """Cancel the jobs of a run on Slurm if it is terminated or interrupted."""
    try:
        yield
    except BaseException:
        print(f"vsb: {slurm.cancel(prefix)} jobs on Slurm cancelled", file=sys.stderr)
        raise


def _profile(name: str) -> tuple[Path, dict[str, Any]]:
    """Folder of a profile, of the package by name, of the user's own by a path with a separator; what it says.

    What it hands jobs to must be installed: Snakemake would answer with pages.
    """
    own = os.sep in name
    folder = Path(name) if own else HOME / "profiles" / name
    if not (profile := folder / "config.yaml").is_file():
        known = ", ".join(sorted(path.parent.name for path in (HOME / "profiles").glob("*/config.yaml")))
        raise VsbError(
            f"--profile: received {name}, needs {known}, or the path of a folder of your own (./{Path(name).name}) "
            "with a config.yaml"
        )
    read = read_yaml(profile, "a profile of snakemake")
    given = read if isinstance(read, dict) else {}
    executor = str(given.get("executor", "local"))
    if executor != "local" and not find_spec(f"snakemake_executor_plugin_{executor.replace('-', '_')}"):
        package = f"snakemake-executor-plugin-{executor}"
        raise VsbError(f"{profile}: executor: received {executor}, which is not installed; needs pip install {package}")
    return folder, given


FORCED = re.compile(r"(-R|--forcer(?:un?)?)(?:=?(.+))?")
"""The option of snakemake that has jobs done again, in all its spellings, and what may be joined to it."""


def _forced(options: Sequence[str], stale: Sequence[str]) -> list[str]:
    """Options for Snakemake, and what it must make anew beside what the user asked it to: it hears the last list."""
    if not stale:
        return [*options]
    for place in reversed(range(len(options))):
        if found := FORCED.fullmatch(options[place]):
            flag, joined = found.groups()
            return [*options[:place], flag, *stale, *([joined] if joined else []), *options[place + 1 :]]
    return [*options, "--forcerun", *stale]


def _followed(
    plan: Plan, some: Sequence[Job], kept: MutableSequence[str], lines: Iterable[str], *, quiet: bool
) -> None:
    """Say how far Snakemake is by its output, of which the last lines are kept."""
    words = partial(best_so_far, plan) if isinstance(plan, DesignPlan) else None
    followed(lines, Progress(plan.name, [job.seconds for job in some], quiet), rules(plan), kept, words)


def finished(
    command: Sequence[str],
    env: Mapping[str, str],
    pass_fds: Sequence[int] = (),
    line: Follow | None = None,
) -> int:
    """Return the exit code of a command; if terminated or interrupted, first end all processes it started.

    Its output goes to `line`, if given.
    """
    heard = _heard()
    early: list[int] = []  # signals received while the command starts: handled once its process is known
    before = {number: signal.signal(number, lambda heard, _: early.append(heard)) for number in heard}
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # one that comes meanwhile waits
    interrupt = signal.signal(signal.SIGINT, signal.SIG_IGN)  # of it and its jobs: they are ended here, without a word
    try:
        shown: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True, "errors": "replace"}
        process = subprocess.Popen(command, env=env, pass_fds=pass_fds, **(shown if line else {}))
        signal.signal(signal.SIGINT, interrupt)
        try:
            for number in heard:
                signal.signal(number, _ask_to_end)
            for received in early:
                _ask_to_end(received, None)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
            if line and process.stdout:
                line(process.stdout)
            return process.wait()
        except BaseException:
            _end(process.pid)
            process.wait()
            raise
    finally:
        signal.signal(signal.SIGINT, interrupt)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        for number, handler in before.items():
            signal.signal(number, handler)


def _heard() -> list[signal.Signals]:
    """Signals that end a run, if whoever started it did not shield it from them."""
    known = (getattr(signal, name, None) for name in ("SIGTERM", "SIGHUP"))  # Windows knows no hang-up
    return [number for number in known if number and signal.getsignal(number) != signal.SIG_IGN]


def _ask_to_end(number: int, _: object) -> NoReturn:
    """End as a shell reports it, after one line."""
    process = f"process {os.getpid()} by {signal.Signals(number).name}"
    print(f"vsb: ended, {process}; run the same command again to go on from here", file=sys.stderr)
    raise SystemExit(128 + number)


def _end(pid: int) -> None:
    """Kill a process and all that it started: files are written whole or not at all, so nothing is lost."""
    tree: dict[int, psutil.Process] = {}  # by pid: a clock that is set meanwhile changes when psutil says they began
    with contextlib.suppress(psutil.NoSuchProcess):
        root = psutil.Process(pid)
        while new := [one for one in (root, *root.children(recursive=True)) if one.pid not in tree]:
            for one in new:  # stopped, so that they start nothing more
                tree[one.pid] = one
                with contextlib.suppress(psutil.NoSuchProcess):
                    one.suspend()
    for one in tree.values():
        with contextlib.suppress(psutil.NoSuchProcess):
            one.kill()


def _failed(plan: Plan, begun: float, output: Iterable[str] = ()) -> int:
    """Repeat the failing rule's own line last, where it is seen; 2 if it was the user's to mend, else 1.

    If no rule says what is wrong, what nobody has seen yet is kept in a file: it is for those who know Snakemake.
    """
    logs = [path for path in Path(plan.root, "logs").rglob("*.log") if path.stat().st_mtime >= begun - 1.0]
    lines = [line for path in logs for line in path.read_text(encoding="utf-8", errors="replace").splitlines()]
    mistakes = [line for line in lines if line.startswith(ERROR)]
    unseen = list(output)
    whole = f"{ERROR} the run of {plan.name!r} did not complete" + (_kept(plan, unseen) if unseen else ", see above")
    print(mistakes[-1] if mistakes else whole, file=sys.stderr)
    return 2 if mistakes else 1


def _kept(plan: Plan, lines: Sequence[str]) -> str:
    """Which rules failed with the last line of each, or of the system; where the whole output is."""
    from vsb.tools.files import write_text

    words = [f"{rule} ended{_last_words(Path(log))}" for log, rule in failed(lines).items()]
    words = words or [found[1] for line in lines if (found := re.search(r"\[Errno \d+\] (.+)", line))][-1:]
    try:
        write_text(log_path(plan), "".join(lines))
        words.append(f"the whole output is in {log_path(plan)}")
    except (OSError, VsbError) as error:
        words.append(f"the output cannot be written: {error}")
    return f": {'; '.join(words)}"


def _last_words(log: Path) -> str:
    """The last line of a job's log."""
    lines = log.read_text(encoding="utf-8", errors="replace").split("\n") if log.is_file() else []
    last = next((line for line in reversed(lines) if line.strip()), "")
    return f" with {shortened(last.strip())}" if last else " without a word, as when it is killed or memory is out"


def cores(text: str) -> str:
    """A number of cores as snakemake accepts it; with none it would wait for ever."""
    if text != "all" and not (text.isdecimal() and int(text)):
        raise argparse.ArgumentTypeError(f"received {text}, needs a whole number above 0, or all")
    return text
