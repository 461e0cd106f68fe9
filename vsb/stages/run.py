"""Command run: a whole study through Snakemake, alone in its results folder."""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from vsb.errors import VsbError
from vsb.stages.alone import alone
from vsb.study.plan import StudyPlan
from vsb.study.study import load
from vsb.tools.shipped import HOME

ERROR = "vsb: error:"
SNAKEFILE = HOME / "workflow" / "Snakefile"


def run(args: argparse.Namespace) -> int:
    """Run a whole study through Snakemake, after validating everything that can be known beforehand."""
    from vsb.stages import preview, verify
    from vsb.tools.files import check_folder

    study = load(args.config)
    plan = StudyPlan(study)
    preview.check_before_run(study, plan)
    for folder in (".", plan.root):  # snakemake writes to both
        check_folder(folder)
    profile = ["--profile", str(_profile(args.profile)), "--workflow-profile", "none"]
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE), "--configfile", args.config]
    command += ["--nolock", *profile, *(["--cores", args.cores] if args.cores else [])]
    paths = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": paths, "PYTHONSAFEPATH": "1"}  # nor modules of the current folder
    begun = time.time()
    dry = bool({"-n", "--dry-run", "--dryrun"} & set(args.snakemake))
    with alone(Path(plan.root), waits=not dry) as lock:
        command += _forced(args.snakemake, verify.stale_products(plan, dry=dry))
        code = subprocess.run(command, env=environment, check=False, pass_fds=lock).returncode
    if code:
        return _failed(plan, begun)
    if not dry and (report := Path(plan.folder) / "report.html").is_file():
        print(f"{study.study}: {report}")
    return 0


def _profile(name: str) -> Path:
    """Folder of a profile: of the package by name, of the user's own by a path with a separator in it."""
    own = os.sep in name
    folder = Path(name) if own else HOME / "profiles" / name
    if not (folder / "config.yaml").is_file():
        known = ", ".join(sorted(path.parent.name for path in (HOME / "profiles").glob("*/config.yaml")))
        raise VsbError(
            f"--profile: received {name}, needs {known}, or the path of a folder of your own (./{Path(name).name}) "
            "with a config.yaml"
        )
    return folder


def _forced(options: Sequence[str], stale: Sequence[str]) -> list[str]:
    """Options for Snakemake, and what it must make anew beside what the user asked it to."""
    flags = [option for option in options if option in ("-R", "--forcerun")]
    if not stale or not flags:
        return [*options, *(["--forcerun", *stale] if stale else [])]
    place = options.index(flags[-1]) + 1
    return [*options[:place], *stale, *options[place:]]


def _failed(plan: StudyPlan, begun: float) -> int:
    """Repeat the failing rule's own line last, where it is seen; 2 if it was the user's to mend, else 1."""
    logs = [path for path in Path(plan.root, "logs").rglob("*.log") if path.stat().st_mtime >= begun - 1.0]
    lines = [line for path in logs for line in path.read_text(encoding="utf-8").splitlines()]
    mistakes = [line for line in lines if line.startswith(ERROR)]
    last = mistakes[-1] if mistakes else f"{ERROR} the run of {plan.study.study!r} did not complete, see above"
    print(last, file=sys.stderr)
    return 2 if mistakes else 1


def cores(text: str) -> str:
    """A number of cores as snakemake takes it; with none it would wait for ever."""
    if text != "all" and not (text.isdecimal() and int(text)):
        raise argparse.ArgumentTypeError(f"received {text}, needs a whole number above 0, or all")
    return text
