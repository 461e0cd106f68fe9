"""A campaign on a real Slurm of one node: killed, resumed, and compared byte by byte.

Needs Debian's packages slurm-wlm and munge but no rights: daemons, key, sockets and state are the user's, in a folder
of their own. srun is on the path as a script because the jobs of Snakemake's plug-in lose SLURM_CONF.
"""

import contextlib
import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import yaml

from vsb.errors import VsbError
from vsb.tools.commands import HOME
from vsb.tools.packed import packs

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "srun", "squeue", "scancel", "sinfo")
ADMIN = "/usr/sbin"
"""Folder of the daemons, not on every user's path."""
PATIENCE = 600.0
"""Longest run [s]."""
CAMPAIGN = {
    "campaign": "shells",
    "study": "pressurised.yaml",
    "vary": {"device.young_modulus": {"log": [1e7, 1e10, 100]}, "device.thickness": [0.01, 0.02, 0.03, 0.04]},
    "climate": {"spectra": "climate/ndbc46042_1996_spectra.txt.gz"},
    "tuning": ["one"],
}
PRODUCTS = ("campaign.nc", "campaign.csv")


class Row(NamedTuple):
    """One step, what it took, and what came of it."""

    step: str
    seconds: float
    verdict: str


def programs() -> dict[str, str]:
    """Return where the programs of Slurm lie.

    Raises
    ------
    VsbError
        If some are not there.
    """
    path = f"{os.environ['PATH']}{os.pathsep}{ADMIN}"
    found = {name: shutil.which(name, path=path) for name in PROGRAMS}
    if missing := [name for name, place in found.items() if place is None]:
        raise VsbError(
            f"cluster: Slurm is not installed, {', '.join(missing)} not found; needs, on Debian, "
            "apt-get install slurm-wlm munge"
        )
    return {name: str(place) for name, place in found.items()}


def configuration(folder: Path, host: str, user: str, ports: tuple[int, int], cores: int) -> str:
    """Return slurm.conf of a cluster of this machine alone, all of whose files lie in a folder."""
    return f"""ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=16000 State=UNKNOWN
PartitionName=main Nodes={host} Default=YES State=UP
"""


@contextlib.contextmanager
def slurm(cores: int = 2) -> Iterator[dict[str, str]]:
    """Start a cluster and give the environment in which its commands, and jobs, find it; stop it in the end."""
    found, user = programs(), subprocess.check_output(["id", "-un"], text=True).strip()
    with tempfile.TemporaryDirectory(prefix="slurm-") as name:
        folder, host = Path(name), socket.gethostname().partition(".")[0]
        for part in ("state", "spool", "bin"):
            (folder / part).mkdir()
        (folder / "munge.key").write_bytes(secrets.token_bytes(1024))
        (folder / "munge.key").chmod(0o400)
        (folder / "slurm.conf").write_text(configuration(folder, host, user, (_port(), _port()), cores))
        script = folder / "bin" / "srun"
        script.write_text(f'#!/bin/sh\nSLURM_CONF={folder}/slurm.conf exec {found["srun"]} "$@"\n')
        script.chmod(0o755)
        path = f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf"), "PATH": path}
        try:
            _start(folder, found, environment)
            yield environment
        finally:
            for daemon in ("slurmd", "slurmctld", "munged"):
                _stop(folder / f"{daemon}.pid")


def _port() -> int:
    """A port nobody listens on."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def _start(folder: Path, found: Mapping[str, str], environment: Mapping[str, str]) -> None:
    """Start the daemons and wait for the node to be idle."""
    munge = {"socket": "socket", "key-file": "key", "log-file": "log", "seed-file": "seed"}
    files = [f"--{option}={folder}/munge.{end}" for option, end in munge.items()]
    for command in ([found["munged"], "--force", *files], [found["slurmctld"]], [found["slurmd"]]):
        command += [f"--pid-file={folder}/munged.pid"] if command[0] == found["munged"] else []
        subprocess.run(command, env=environment, check=True, capture_output=True)
    state = [found["sinfo"], "--noheader", "--format=%T"]

    def idle() -> bool:
        return "idle" in subprocess.run(state, env=environment, capture_output=True, text=True, check=False).stdout

    _wait(idle, 30.0, f"Slurm did not start: {_last(folder / 'slurmctld.log')} {_last(folder / 'slurmd.log')}")


def _last(log: Path) -> str:
    """The last line of a log."""
    lines = log.read_text().splitlines() if log.is_file() else []
    return lines[-1] if lines else f"{log.name} is empty"


def _wait(done: Callable[[], bool], seconds: float, failure: str) -> None:
    """Wait until something is done."""
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            raise VsbError(f"cluster: {failure}")
        time.sleep(0.1)


def _stop(pid_file: Path) -> None:
    """End a daemon by the process it says it is, and wait for that."""
    with contextlib.suppress(OSError, ValueError):
        pid = int(pid_file.read_text())
        os.kill(pid, signal.SIGTERM)
        _wait(lambda: not pid_file.exists() or not Path(f"/proc/{pid}").exists(), 10.0, f"{pid_file.stem} goes on")


def benchmark(place: str | Path) -> list[Row]:
    """Run the campaign here, on Slurm, on Slurm killed and resumed, and the seed's study; compare bytes.

    Parameters
    ----------
    place : str or Path
        Folder of the runs; what is in it is removed.
    """
    programs()
    folder = Path(place).absolute()
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(HOME / "config", folder)
    (folder / "shells.yaml").write_text(yaml.safe_dump(CAMPAIGN, sort_keys=False))
    rows = [_said(Row("campaign here", _ran(folder, "here", os.environ, "default"), ""))]
    with slurm() as environment:
        seconds = _ran(folder, "slurm", environment)
        rows.append(_said(Row("campaign on Slurm", seconds, _same(folder, "slurm"))))
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
            name = number.name.lower()
            _killed(folder, name, environment, number)
            left = _left(environment)
            seconds = _ran(folder, name, environment)
            text = f"{_same(folder, name)}; {left} jobs had been left behind"
            rows.append(_said(Row(f"resumed after {number.name}", seconds, text)))
        rows.append(_said(Row("a study on Slurm", _ran(folder, "study", environment, config="pressurised.yaml"), "")))
    return rows


def _said(row: Row) -> Row:
    """The row, reported at once."""
    print(f"{row.step:24} {row.seconds:6.1f} s  {row.verdict}", flush=True)
    return row


def _run(
    folder: Path, name: str, environment: Mapping[str, str], profile: str, config: str
) -> "subprocess.Popen[bytes]":
    """Start a run in a folder of its own, in a group of its own."""
    (folder / name).mkdir(exist_ok=True)
    command = [sys.executable, "-m", "vsb", "run", f"../{config}", "--profile", profile]
    with (folder / f"{name}.log").open("a") as log:
        return subprocess.Popen(
            command, cwd=folder / name, env=environment, stdout=log, stderr=log, start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # ignored of what a shell runs aside
        )  # fmt: skip


def _ran(
    folder: Path, name: str, environment: Mapping[str, str], profile: str = "slurm", config: str = "shells.yaml"
) -> float:
    """Seconds of a run."""
    begun, process = time.monotonic(), _run(folder, name, environment, profile, config)
    if code := _ended(process, PATIENCE, f"{folder / name}: not done in {PATIENCE:g} s; see {name}.log beside it"):
        raise VsbError(f"cluster: {folder / name}: ended with {code}; see {name}.log beside it")
    return time.monotonic() - begun


def _ended(process: "subprocess.Popen[bytes]", seconds: float, failure: str) -> int:
    """Exit code of a run, which is killed if it does not end."""
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        raise VsbError(f"cluster: {failure}") from None


def _killed(folder: Path, name: str, environment: Mapping[str, str], number: signal.Signals) -> None:
    """Begin a run, and end it by a signal once the first members are there."""
    process = _run(folder, name, environment, "slurm", "shells.yaml")
    members = folder / name / "results" / "shells" / "members"
    _wait(lambda: len(packs(members)) > 9, PATIENCE, f"{name}: no members")
    if number == signal.SIGKILL:
        os.killpg(process.pid, number)
    else:
        process.send_signal(number)
    _ended(process, 60.0, f"{name}: goes on after {number.name}")


def _left(environment: Mapping[str, str]) -> int:
    """How many jobs are in the queue."""
    listed = subprocess.run(
        ["squeue", "--noheader", "--states=PENDING,RUNNING"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return len(listed.stdout.splitlines())


def _same(folder: Path, name: str) -> str:
    """Whether the products of a run are, byte for byte, those of the run here."""
    here, there = (folder / one / "results" / "shells" for one in ("here", name))
    differ = [product for product in PRODUCTS if (here / product).read_bytes() != (there / product).read_bytes()]
    return f"other bytes in {', '.join(differ)}" if differ else "the same bytes"
