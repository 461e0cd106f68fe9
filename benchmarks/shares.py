"""Where the processor time of whole commands goes: a study, a campaign, a body and a design."""

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks import sampler
from benchmarks.measure import Row, as_csv, on_one_core, run_python, say, written
from vsb.tools.files import write_text

COLUMNS = ("command", "part", "seconds")
COMMANDS: Mapping[str, tuple[str, Mapping[str, object]]] = {
    "study": ("buoy.yaml", {}),
    "campaign": (
        "year.yaml",
        {"vary": {"pto.stiffness": np.linspace(0.0, 4e4, 100).tolist()}, "tuning": ["one"], "verify": None},
    ),
    "body": ("float.yaml", {}),
    "design": ("best_buoy.yaml", {"starts": 1, "pareto": None, "uncertain": None}),
}
"""Files of config/, and what of them is changed."""


def benchmark(out: str | Path) -> list[Row]:
    """Run every command twice, each from no results, and write a table of the seconds of the second run's parts."""
    on_one_core()
    rows: list[Row] = []
    for name, (file, changed) in COMMANDS.items():
        with tempfile.TemporaryDirectory() as folder:
            written(file, changed, folder)
            for results in ("first", "second"):  # a first run compiles kernels and modules, which all others load
                run_python(folder, sampler.__file__, "seconds.json", "run", "one.yaml", "--results", results)
            seconds = json.loads(Path(folder, "seconds.json").read_text(encoding="utf-8"))
        rows += [{"command": name, "part": part, "seconds": value} for part, value in seconds.items()]
        say(f"{name}: {sum(seconds.values()):.1f} s")
    write_text(out, as_csv(rows, COLUMNS))
    return rows
