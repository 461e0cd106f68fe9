"""What makes a campaign cheap, each against the plain loop in its place: seconds of both in one run, and the error.

The hourly loop is written apart: own quadrature, one hour and one damper at a time. A plain member is a point that
shares nothing: climate and coefficients are read for it, as they would be for a study by itself.
"""

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.integrators import as_csv
from benchmarks.take_offs import timed
from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.motion.tuning import best_damper_of_each, best_dampers
from vsb.results.year import DesignYear
from vsb.scenes.ports import design_ports
from vsb.scenes.rest import reference_shell
from vsb.stages.climate import read_climate
from vsb.stages.members import Work, finished
from vsb.study.campaign_plan import CampaignPlan, Member, plan_of
from vsb.tools.files import write_text
from vsb.tools.units import FloatArray
from vsb.waves.climate import Climate

DAMPERS = 120
MEMBERS = 12
EVERY = 10
"""Of the hours of the year the loop takes one in so many."""
COLUMNS = ("case", "cells", "seconds", "plain_seconds", "times_faster", "error")


def by_hours(ports: Sequence[Port], climate: Climate, dampers: FloatArray) -> FloatArray:
    """Return the mean power of every design and damper over the year, hour by hour, shape (design, damper) [W]."""
    powers = [[_by_hours(port, climate, float(damper)) for damper in dampers] for port in ports]
    return np.array(powers)


def _by_hours(port: Port, climate: Climate, damper: float) -> float:
    """The same of one port and damper: power on straight lines between the port's frequencies, each band by itself."""
    power = 0.5 * damper * np.abs(port.velocity / (1 + damper * port.admittance)) ** 2
    bands = [
        _band(port.omega, power, low, high) for low, high in zip(climate.edges[:-1], climate.edges[1:], strict=True)
    ]
    hours = zip(climate.density.tolist(), climate.hours.tolist(), strict=True)
    return math.fsum(share * math.fsum(s * band for s, band in zip(sea, bands, strict=True)) for sea, share in hours)


def _band(omega: FloatArray, power: FloatArray, low: float, high: float) -> float:
    """Integral 2 P dw over a band, by trapezoids between the frequencies in it."""
    low, high = max(low, float(omega[0])), min(high, float(omega[-1]))
    if not low < high:
        return 0.0
    at = [low, *omega[(omega > low) & (omega < high)].tolist(), high]
    p = np.interp(at, omega, power).tolist()
    return math.fsum((b - a) * (p[i] + p[i + 1]) for i, (a, b) in enumerate(pairwise(at)))


def at_once(ports: Sequence[Port], climate: Climate, dampers: FloatArray) -> FloatArray:
    """Return the same as matrix products, every hour's power on the way."""
    return np.array([DesignYear(port, climate).table(dampers) @ climate.hours for port in ports])


def one_by_one(ports: Sequence[Port], squares: FloatArray) -> FloatArray:
    """Return the best damper of each port, each climbed to by itself [N s/m]."""
    return np.array([best_dampers(port, squares[None]).damping[0] for port in ports])


def sweep(plan: CampaignPlan, some: Sequence[Member], folder: Path, *, shared: bool) -> FloatArray:
    """Return annual mean powers of members computed in one job, or each by itself, (member, design, tuning) [W]."""
    path, spec = plan.loaded.climate_path, next(iter(plan.batches.values()))

    def work() -> Work:
        return Work(read_climate(plan.climate, path), spec, plan.root)

    together = work()
    found = [finished(folder / f"{one.id}.npz", one, together if shared else work()) for one in some]
    return np.array([one.annual_mean_power.values for one in found])


def compared(case: str, cells: int, fast: Callable[[], FloatArray], plain: Callable[[], FloatArray]) -> dict[str, Any]:
    """Return one row of the table."""
    (seconds, found), (plain_seconds, expected) = timed(fast), timed(plain)
    error = float(np.nanmax(np.abs(found - expected)) / np.nanmax(np.abs(expected)))
    row = {"case": case, "cells": cells, "seconds": seconds, "plain_seconds": plain_seconds}
    return row | {"times_faster": plain_seconds / seconds, "error": error}


def benchmark(config: str, place: str | Path, dampers: int = DAMPERS, count: int = MEMBERS) -> list[dict[str, Any]]:
    """Write campaigns.csv of a campaign file into a folder and return its rows.

    Parameters
    ----------
    config : str
        A campaign that varies what leaves the wetted shape as it is.
    place : str or Path
    dampers, count : int
        Dampers of the year, members of the sweep.

    Raises
    ------
    ConfigError
        If it is a study.
    """
    plan = plan_of(config)
    if not isinstance(plan, CampaignPlan):
        raise ConfigError(f"{config}: received a study, needs a campaign such as config/when_it_pays.yaml")
    folder = Path(place)
    plan = replace(plan, root=str(folder / "results"))
    whole, some = read_climate(plan.climate, plan.loaded.climate_path), plan.members[:count]
    climate = Climate.of_spectra(
        whole.omega, whole.density[::EVERY], np.full(n := len(whole.hours[::EVERY]), 1 / n), whole.name
    )
    rest = reference_shell(some[0].study)
    water = Work(climate, next(iter(plan.batches.values())), plan.root).water(some[0], rest.basis)
    ports = list(design_ports(some[0].study, rest, water).values())
    tried, squares = np.geomspace(1e3, 1e6, dampers), DesignYear(ports[0], climate).squares
    many = [port for _ in range(count) for port in ports]
    with tempfile.TemporaryDirectory() as name:
        rows = [
            compared(
                "year, hour by hour", len(ports) * dampers * n,
                lambda: at_once(ports, climate, tried), lambda: by_hours(ports, climate, tried),
            ),
            compared(
                "best dampers, each alone", len(many),
                lambda: best_damper_of_each(many, squares), lambda: one_by_one(many, squares),
            ),
            compared(
                "sweep, each member alone", len(some),
                lambda: sweep(plan, some, Path(name, "shared"), shared=True),
                lambda: sweep(plan, some, Path(name, "alone"), shared=False),
            ),
        ]  # fmt: skip
    write_text(folder / "campaigns.csv", as_csv(rows, COLUMNS))
    return rows
