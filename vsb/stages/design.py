"""Rules design_start and design_front: the best buoy from one start, and the best buoys over the values of a limit."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import xarray as xr

from vsb.design.certificate import VIOLATION
from vsb.design.optimise import Finer, optimised, within_margins
from vsb.design.problem import IMPOSSIBLE, Point
from vsb.design.searched import Outcome, best, failed, finer_of, from_start, problem_of, uncertain_margins
from vsb.errors import ConvergenceError
from vsb.stages.climate import read_climate
from vsb.stages.stage import stamp
from vsb.study.specs import DesignFrontSpec, DesignStartSpec, Search
from vsb.tools.files import load, save
from vsb.waves.climate import Climate


def run_design_start(spec: DesignStartSpec, climate: str, out: str) -> None:
    """Optimise from one start and write where it ended."""
    seas, keys = read_climate(spec.search.climate, climate), [one.key for one in spec.search.variables]
    try:
        found = from_start(spec.search, seas, spec.starts, spec.seed, spec.start, BestSoFar(spec.search))
        result = Outcome.of(found, keys).dataset
    except ConvergenceError as error:
        result = failed(str(error))
    save(result.assign_attrs(stamp(spec)), out)


class BestSoFar:
    """Prints the best buoy within all limits whenever there is a better one."""

    def __init__(self, search: Search) -> None:
        self.search, self.objective = search, -math.inf

    def __call__(self, point: Point) -> None:
        """See one more buoy."""
        if point.violation <= VIOLATION and point.objective > self.objective:
            self.objective = point.objective
            named = zip((one.key.rpartition(".")[2] for one in self.search.variables), point.values, strict=True)
            words = ", ".join(f"{name} {value:.4g}" for name, value in named)
            print(f"best so far: {point.objective:.6g} {self.search.maximise} with {words}", flush=True)


def outcomes(folder: str, ids: Sequence[str]) -> list[Outcome | str]:
    """Return where starts ended, from their files."""
    return [Outcome.read(load(Path(folder) / f"{one}.nc", expected=one)) for one in ids]


def run_design_front(spec: DesignFrontSpec, climate: str, starts: str, out: str) -> None:
    """Optimise over the values of one limit, each begun at the best buoy of its neighbour."""
    first = best(outcomes(starts, spec.starts))
    seas = read_climate(spec.search.climate, climate)
    found = front(spec.search, seas, spec.limit, sorted(spec.values), first)
    save(found.assign_attrs(stamp(spec)), out)


def front(search: Search, climate: Climate, limit: str, values: Sequence[float], first: Outcome) -> xr.Dataset:
    """Return the best buoys over the values of a limit.

    Parameters
    ----------
    values : sequence of float
        Ascending.
    first : Outcome
        The best buoy of the search itself: it is where the value next to its own begins.
    """
    has = first.quantities.get(limit, search.limits.get(limit, values[-1]))
    nearest = int(np.argmin([abs(math.log(value / has)) for value in values]))
    ends: dict[int, Outcome | None] = {}
    keys = [one.key for one in search.variables]
    for order in (range(nearest, len(values)), range(nearest - 1, -1, -1)):
        begin = ends.get(nearest) or first
        for i in order:
            wanted = search.model_copy(update={"limits": {**search.limits, limit: values[i]}})
            problem = problem_of(wanted, climate, first.degree)
            try:
                start = problem.at(problem.place(list(begin.values)))
                found = optimised(problem, start)
            except IMPOSSIBLE:
                ends[i] = None
                continue
            try:
                at_degree = cache(partial(problem_of, wanted, climate))
                finer_at = partial(finer_of, wanted, at_degree, degree=first.degree)
                margins_of = uncertain_margins(wanted)
                uncertain = partial(margins_of, problem) if margins_of else None
                found, known = within_margins(problem, found, finer_at, uncertain)
            except IMPOSSIBLE as error:
                message = f"with more shell modes than to degree {first.degree} it has no stable rest shape: {error}"
                found, known = replace(found, accepted=False, message=message), Finer(None, np.array([]))
            margins = dict(zip(problem.limit_names, map(float, known.margins), strict=False))
            made = problem.evaluations
            end = Outcome.at(found, keys, start.values, first.degree, known.truncation, made, margins)
            ends[i] = begin = end
    return as_dataset(limit, [(values[i], end) for i, end in sorted(ends.items()) if end is not None])


def as_dataset(limit: str, points: Sequence[tuple[float, Outcome]]) -> xr.Dataset:
    """Return the best buoys over the values of a limit as a dataset."""
    parts = [one.dataset for _, one in points]
    ds = xr.concat(parts, "limit_value", combine_attrs="drop") if parts else xr.Dataset()
    facts = json.dumps([one.attrs["outcome"] for one in parts])
    return ds.assign_coords(limit_value=[value for value, _ in points]).assign_attrs(limit=limit, outcomes=facts)


def points_of(ds: xr.Dataset) -> list[tuple[float, Outcome]]:
    """Return what `as_dataset` holds."""
    found = []
    for i, facts in enumerate(json.loads(ds.attrs["outcomes"])):
        one = ds.isel(limit_value=i)
        end = Outcome.read(one.assign_attrs(outcome=facts))
        assert isinstance(end, Outcome)
        found.append((float(one.limit_value), end))
    return found
