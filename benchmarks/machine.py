"""The machine and the versions that benchmarks measure."""

import os
import platform
from importlib.metadata import version
from pathlib import Path

from benchmarks.measure import Row, as_csv
from vsb.tools.files import write_text


def benchmark(out: str | Path) -> list[Row]:
    """Write a table of what a reader needs to know of the machine."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text(encoding="utf-8").splitlines() if known.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    found = {"processor": names[0] if names else platform.processor() or platform.machine()}
    found |= {"cores": str(os.cpu_count()), "load": f"{os.getloadavg()[0]:.1f}", "python": platform.python_version()}
    found |= {name: version(name) for name in ("vsb", "capytaine", "numpy", "scipy", "numba")}
    rows: list[Row] = [{"name": name, "value": value} for name, value in found.items()]
    write_text(out, as_csv(rows, ("name", "value")))
    return rows
