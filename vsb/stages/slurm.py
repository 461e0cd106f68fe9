"""Jobs on Slurm that a run has handed over: cancelled when it is told to end, as its processes here are ended."""

import os
import re
import subprocess

LONGEST = 50
"""Characters of a name the plug-in takes."""


def job_name(name: str) -> str:
    """Return what the names of a run's jobs begin with: its study or campaign, and its process."""
    mine = f"-{os.getpid()}"
    return re.sub(r"[^A-Za-z0-9_-]", "_", f"vsb-{name}")[: LONGEST - len(mine)] + mine


def cancel(prefix: str) -> int:
    """Cancel the user's jobs whose names begin with a prefix; return how many."""
    listed = subprocess.run(
        ["squeue", "--me", "--noheader", "--format=%i %j"], capture_output=True, text=True, check=False
    )
    jobs = [line.split(maxsplit=1) for line in listed.stdout.splitlines() if " " in line]
    mine = [number for number, name in jobs if name.startswith(f"{prefix}_")]
    if mine:
        subprocess.run(["scancel", *mine], capture_output=True, check=False)
    return len(mine)
