"""Gains at ports on heave, surge and pitch with converged shell modes: the table of docs/directions.md.

    python -m examples.directions results/directions.csv

writes the fraction of λ/2π the rigid buoy absorbs in regular waves at its optimal damping, and the gain of the free
shell, of the example's shell inflated and of the paper's shell, open inside.
"""

import argparse
import math
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

from examples import command
from vsb.engine.waves.water import power_limit
from vsb.models.mode_convergence import ModeConvergence
from vsb.pipeline.graph import StudyPlan
from vsb.study.study import Study, load, parse
from vsb.tools.files import write_text
from vsb.tools.stamps import check_table
from vsb.tools.words import csv_text

PERIODS = (2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0)
PORTS = ("heave", "surge", "pitch")
SHELLS = {"inflated": ("config/buoy.yaml", 0.001), "open": ("config/seed.yaml", 0.005)}
"""Studies of the shells, and tolerances of their modes."""
AMPLITUDE = 0.1
COLUMNS = ("shell", "port", "period", "rigid_limit_fraction", "gain_percent", "by_further_modes", "degree")


def planar(path: str, tolerance: float, port: str) -> Study:
    """Return a study about the undeformed sphere in the plane of the waves, its take-off at a port."""
    raw: dict[str, Any] = load(path).model_dump()
    raw["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8000.0}
    return parse(
        raw
        | {
            "motion": "planar",
            "modes": {"tolerance": tolerance},
            "mooring": [2.0e4, 0, 0, 0, 0, 0],
            "reference_shape": "undeformed",
            "designs": {"FSB": {"flexible": False}, "VSWEC": {}},
            "pto": {"port": port, "tuning": "each"},
            "waves": [{"kind": "regular", "amplitude": AMPLITUDE, "period": period} for period in PERIODS],
            "published": None,
        }
    )


def rows_of(shell: str) -> Iterator[tuple[object, ...]]:
    """Rows of `COLUMNS` of one shell, gains with what further modes may change of them in percentage points."""
    for port in PORTS:
        study = planar(*SHELLS[shell], port)
        water, seas = study.water, [wave.realisation(study.hydro.omega_max, 0.0) for wave in study.waves]
        buoy = StudyPlan(study).with_degree().ladder.spec["study"]
        found = ModeConvergence(buoy, seas)
        rigid, free = found.compared[-1][:, :, 1]
        beyond = 100 * np.ptp(found.compared, axis=0)[1, :, 1] / rigid
        for i, period in enumerate(PERIODS):
            limit = power_limit(2 * math.pi / period, water.depth, water.density, water.gravity) * AMPLITUDE**2
            gain = 100 * float(free[i] / rigid[i] - 1)
            yield shell, port, period, float(rigid[i] / limit), gain, float(beyond[i]), found.finer


def run(args: argparse.Namespace) -> int:
    """Write the table."""
    check_table(args.out, COLUMNS)
    rows = [row for shell in SHELLS for row in rows_of(shell)]
    write_text(args.out, csv_text(COLUMNS, rows, 6))
    for shell, port in {(row[0], row[1]): None for row in rows}:
        here = [row for row in rows if row[:2] == (shell, port)]
        print(shell, port, *(f"{row[2]:g} s: {row[3]:.3f} {row[4]:+.1f} %" for row in here), sep="\n  ")
    return 0


main = command("directions", __doc__, run, out="OUT")

if __name__ == "__main__":
    sys.exit(main(None))
