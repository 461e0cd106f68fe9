"""The paper's own loading with every design at its optimal damping.

An assumed pressure does not depend on the motion, so linear theory gives no optimal damper: the steady power of each
design, by harmonic balance on the instantaneous wet shell, is maximised over its damper. Dampers with no stable steady
state count as zero power.

    python -m examples.paper_at_optimal_damping config/paper_inferred.yaml results/paper_inferred/best_dampers.csv
"""

import argparse
import sys
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from examples import command
from vsb.engine.integrators.harmonic_balance import steady_power
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.models.build import assumed_pressure_design
from vsb.pipeline.graph import StudyPlan
from vsb.study.study import Study, load
from vsb.tools.files import write_text
from vsb.tools.stamps import check_table
from vsb.tools.words import csv_text

DAMPERS = np.geomspace(500.0, 50_000.0, 17)
"""Tried first [N s/m]."""
TOLERANCE = 1e-6


class Row(NamedTuple):
    """One design at the given damper and at its optimal one; mean powers of the steady motion."""

    design: str
    damping: float  # [N s/m]
    power: float  # [W]
    gain_percent: float  # over the first design, here and below
    best_damping: float  # [N s/m]
    best_power: float  # [W]
    best_gain_percent: float


def power_of(study: Study, design: str) -> Callable[[float], float]:
    """Return the steady mean power of a design as a function of its damper, zero if there is no steady state [W]."""
    run = StudyPlan(study).simulation(design, study.waves[0]).spec["run"]

    def power(damping: float) -> float:
        pto = run.study.pto.model_copy(update={"damping": damping})
        damped = run.model_copy(update={"study": run.study.model_copy(update={"pto": pto})})
        try:
            return steady_power(assumed_pressure_design(damped, {}).system, TOLERANCE)
        except (ConvergenceError, StabilityError):
            return 0.0

    return power


def best_damper(power: Callable[[float], float]) -> tuple[float, float]:
    """Return the optimal damper and its power: the best of a scan, refined between its neighbours."""
    k = int(np.argmax([power(float(damping)) for damping in DAMPERS]))
    between = np.log(DAMPERS[[max(k - 1, 0), min(k + 1, len(DAMPERS) - 1)]])
    found = minimize_scalar(
        lambda u: -power(float(np.exp(u))), bounds=tuple(between), method="bounded", options={"xatol": 1e-4}
    )
    return float(np.exp(found.x)), -float(found.fun)


def rows_of(study: Study) -> list[Row]:
    """Return all designs of a study under an assumed pressure."""
    if study.hydro.model != "assumed_pressure":
        raise ConfigError(f"hydro.model: received {study.hydro.model!r}, needs 'assumed_pressure', the paper's loading")
    rows: list[Row] = []
    for design in study.designs:
        power, given = power_of(study, design), study.pto.damper(design) or 0.0
        here, (best, most) = power(given), best_damper(power)
        first = rows[0] if rows else Row(design, given, here, 0.0, best, most, 0.0)
        gains = (100 * (here / first.power - 1), 100 * (most / first.best_power - 1))
        rows.append(Row(design, given, here, gains[0], best, most, gains[1]))
    return rows


def run(args: argparse.Namespace) -> int:
    """Write the table."""
    check_table(args.out, Row._fields)
    text = csv_text(Row._fields, rows_of(load(args.config)), 6)
    write_text(args.out, text)
    print(text, end="")
    return 0


main = command("paper_at_optimal_damping", __doc__, run, config="CONFIG", out="OUT.csv")

if __name__ == "__main__":
    sys.exit(main(None))
