"""What makes a campaign cheap, each against the plain loop in its place: seconds of both in one run, and the error.

The hourly loop is written apart: own quadrature, one hour and one damper at a time. A plain member is a point that
shares nothing: climate and coefficients are read for it, as they would be for a study by itself. A point as a study has
its own hydro database, so its powers differ by what interpolation over frequency does. A run alone reads all it needs.
"""

import math
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from benchmarks.measure import Row, as_csv, timed
from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.motion.tuning import best_damper_of_each, best_dampers
from vsb.results.damped_years import ports_year
from vsb.results.in_time import DesignInTime
from vsb.results.verification import chances, drawn, verified
from vsb.results.year import DesignYear, Tuning, frequencies
from vsb.scenes.afloat import linear_buoy, study_port
from vsb.scenes.ports import design_ports
from vsb.scenes.rest import design_motions, reference_shell
from vsb.scenes.viability import with_designs
from vsb.stages.climate import read_climate
from vsb.stages.make import make
from vsb.stages.members import Work, finished
from vsb.stages.verification import in_time
from vsb.study.campaign_plan import CampaignPlan, Member, plan_of
from vsb.study.plan import StudyPlan
from vsb.study.study import Study
from vsb.tools.files import write_text
from vsb.tools.units import FloatArray
from vsb.waves.climate import Climate, realised

DAMPERS = 120
MEMBERS = 12
STUDIES = 3
"""Points computed as studies of their own, a database each."""
SEAS = 6
"""Seas run in time."""
VERIFIED = 12
"""Seas that verify a year."""
MODEL: Literal["body_exact"] = "body_exact"
DAMPER = 2e4
"""Damper of the runs [N s/m]."""
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


def together(ports: Sequence[Port], squares: FloatArray) -> FloatArray:
    """Return what each port takes with its best damper, all of them found by Newton's method at once [W]."""
    found = best_damper_of_each(ports, squares)
    return np.array([port.power(damping) @ squares for port, damping in zip(ports, found, strict=True)])


def one_by_one(ports: Sequence[Port], squares: FloatArray) -> FloatArray:
    """Return the same, each climbed to by itself: dampers differ by a ten-millionth, where power is level [W]."""
    return np.array([best_dampers(port, squares[None]).power[0] for port in ports])


def sweep(plan: CampaignPlan, some: Sequence[Member], folder: Path, *, shared: bool) -> FloatArray:
    """Return annual mean powers of members computed in one job, or each by itself, (member, design, tuning) [W]."""
    path, spec = plan.loaded.climate_path, next(iter(plan.batches.values()))

    def work() -> Work:
        return Work(read_climate(plan.climate, path), spec, plan.root)

    together = work()
    found = [finished(folder / f"{one.id}.npz", one, together if shared else work()) for one in some]
    return np.array([one.annual_mean_power.values for one in found])


def as_studies(plan: CampaignPlan, some: Sequence[Member], root: str) -> FloatArray:
    """Return the same of members each of which is a study: its database made, its year from that."""
    return np.array([_as_study(plan, one, StudyPlan(one.study, root=f"{root}/{one.id}")) for one in some])


def _as_study(plan: CampaignPlan, one: Member, alone: StudyPlan) -> FloatArray:
    """Annual mean powers of a study by itself, (design, tuning) [W]."""
    make(alone, [alone.database_path])
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    buoy, basis = linear_buoy(one.study, alone.database_path)
    omega, direction = frequencies(seas, *buoy.database.omega.values[[0, -1]]), study_port(one.study, buoy, basis)
    ports = {name: buoy.port(omega, design_motions(one.study, basis, name), direction) for name in one.study.designs}
    sprung = {name: port.beside(one.study.pto.stiffness) for name, port in ports.items()}
    tunings: list[Tuning] = [tuning for tuning in plan.loaded.tuning if tuning != "constrained"]
    return ports_year(one.study, sprung, seas, tunings).annual_mean_power


def rigid_in_time(plan: CampaignPlan, one: Member) -> Study:
    """Return the rigid design of a member with the run in time of its campaign's study; its database is made."""
    hydro = one.study.hydro.model_copy(update={"model": MODEL})
    simulated = one.study.model_copy(update={"simulation": plan.loaded.base.simulation, "hydro": hydro})
    study = with_designs(simulated, [one.study.reference_design or next(iter(one.study.designs))])
    in_time(study, plan.root)
    return study


def in_seas(
    study: Study, root: str, climate: Climate, draws: Iterable[tuple[int, int]], damper: float, *, shared: bool
) -> FloatArray:
    """Return mean powers of a design in seas with their seeds, body-exact and linear, shape (2, draw) [W]."""
    simulation = study.simulation

    def prepared() -> DesignInTime:
        return next(iter(in_time(study, root).values())).under(damper)

    def powers(sea: int, seed: int, design: DesignInTime) -> tuple[float, float]:
        low, high = design.buoy.database.omega.values[[0, -1]]
        waves = realised(climate, sea, simulation.duration, seed, low, high)
        return design.powers(waves, simulation, MODEL)

    once = prepared()
    return np.array([powers(sea, seed, once if shared else prepared()) for sea, seed in draws]).T


def evenly(climate: Climate) -> list[tuple[int, int]]:
    """Return `SEAS` seas of a year, evenly apart, their numbers also their seeds."""
    return [(sea, sea) for sea in np.linspace(0, len(climate.hours) - 1, SEAS).astype(int).tolist()]


def verified_year(
    study: Study, root: str, ports: Mapping[str, Port], climate: Climate, tried: FloatArray, *, shared: bool
) -> FloatArray:
    """Return the powers of `at_once`, one after another, and the verified one of a design, (design damper + 1,) [W].

    The design is that of the study, at its best damper, verified by the seas drawn from its year. Plainly it is a
    loop over hours, designs and dampers, and runs each of which reads all it needs.
    """
    (design,) = study.designs
    table = (at_once if shared else by_hours)(list(ports.values()), climate, tried)
    year = ports_year(study, {design: ports[design]}, climate, ("one",))
    damper = year.damping[0, 0, :1]
    annual = year.annual_mean_power[:, 0] if shared else by_hours([ports[design]], climate, damper)[:, 0]
    sample = drawn(chances(year, "one"), climate.hours, VERIFIED, 1)
    draws = zip(sample.sea.tolist(), sample.seed.tolist(), strict=True)
    better, linear = in_seas(study, root, climate, draws, float(damper[0]), shared=shared)
    found = replace(verified(year, "one", sample, better[None], linear[None]), linear_year=annual)
    return np.append(table.ravel(), found.corrected)


def compared(case: str, cells: int, fast: Callable[[], FloatArray], plain: Callable[[], FloatArray]) -> Row:
    """Return one row of the table."""
    (seconds, found), (plain_seconds, expected) = timed(fast), timed(plain)
    error = float(np.nanmax(np.abs(found - expected)) / np.nanmax(np.abs(expected)))
    row = {"case": case, "cells": cells, "seconds": seconds, "plain_seconds": plain_seconds}
    return row | {"times_faster": plain_seconds / seconds, "error": error}


def benchmark(config: str, place: str | Path, dampers: int = DAMPERS, count: int = MEMBERS) -> list[Row]:
    """Write campaigns.csv of a campaign file into a folder and return its rows.

    Parameters
    ----------
    config : str
        A campaign with a damper to be tuned; of undeformed spheres, or of shells at equilibrium.
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
    named = design_ports(some[0].study, rest, water)
    ports = list(named.values())
    few, rigid = some[:STUDIES], rigid_in_time(plan, some[0])
    tried, squares = np.geomspace(1e3, 1e6, dampers), DesignYear(ports[0], climate).squares
    many = [port for _ in range(count) for port in ports]
    with tempfile.TemporaryDirectory() as name:
        sweep(plan, some, Path(name, "before"), shared=True)  # coefficients and compiled loops are there for both
        in_seas(rigid, plan.root, climate, evenly(climate)[:1], DAMPER, shared=True)
        anew = replace(plan, root=f"{name}/anew")
        rows = [
            compared(
                "year, hour by hour", len(ports) * dampers * n,
                lambda: at_once(ports, climate, tried), lambda: by_hours(ports, climate, tried),
            ),
            compared(
                "best dampers, each alone", len(many),
                lambda: together(many, squares), lambda: one_by_one(many, squares),
            ),
            compared(
                "sweep, each member alone", len(some),
                lambda: sweep(plan, some, Path(name, "shared"), shared=True),
                lambda: sweep(plan, some, Path(name, "alone"), shared=False),
            ),
            compared(
                "sweep, each member a study", len(few),
                lambda: sweep(anew, few, Path(name, "few"), shared=True),
                lambda: as_studies(plan, few, f"{name}/studies"),
            ),
            compared(
                "seas in time, each run alone", SEAS,
                lambda: in_seas(rigid, plan.root, climate, evenly(climate), DAMPER, shared=True),
                lambda: in_seas(rigid, plan.root, climate, evenly(climate), DAMPER, shared=False),
            ),
            compared(
                "verified year, by loops", len(ports) * dampers * n + VERIFIED,
                lambda: verified_year(rigid, plan.root, named, climate, tried, shared=True),
                lambda: verified_year(rigid, plan.root, named, climate, tried, shared=False),
            ),
        ]  # fmt: skip
    write_text(folder / "campaigns.csv", as_csv(rows, COLUMNS))
    return rows
