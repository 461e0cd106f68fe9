"""Rules design_start and design_front: the best buoy from one start, and the best buoys over the values of a limit."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from vsb.design.certificate import VIOLATION
from vsb.design.optimise import Optimum, optimised
from vsb.design.problem import IMPOSSIBLE, Point
from vsb.design.searched import Outcome, best, failed, from_start, problem_of
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
    own = search.limits.get(limit, first.quantities.get(limit, values[-1]))
    nearest = int(np.argmin([abs(math.log(value / own)) for value in values]))
    ends: dict[int, Optimum | None] = {}
    for order in (range(nearest, len(values)), range(nearest - 1, -1, -1)):
        begin = ends.get(nearest)
        place = begin.point.values if begin else first.values
        for i in order:
            wanted = search.model_copy(update={"limits": {**search.limits, limit: values[i]}})
            problem = problem_of(wanted, climate, first.degree)
            try:
                ends[i] = found = optimised(problem, problem.at(problem.place(list(place))))
                place = found.point.values
            except IMPOSSIBLE:
                ends[i] = None
    kept = [(values[i], end) for i, end in sorted(ends.items()) if end is not None]
    return _as_dataset(limit, kept, [one.key for one in search.variables])


def _as_dataset(limit: str, kept: Sequence[tuple[float, Optimum]], keys: Sequence[str]) -> xr.Dataset:
    """Optima over the values of a limit."""
    names = list(kept[0][1].point.evaluation.quantities) if kept else []
    table = np.array([[end.point.evaluation[name].value for name in names] for _, end in kept])
    return xr.Dataset(
        {
            "objective": ("limit_value", [end.objective for _, end in kept]),
            "best_value": (
                ("limit_value", "variable"),
                np.array([end.point.values for _, end in kept]).reshape(-1, len(keys)),
            ),
            "quantity_value": (("limit_value", "quantity"), table.reshape(-1, len(names))),
            "kkt": ("limit_value", [end.kkt for _, end in kept]),
            "violation": ("limit_value", [end.violation for _, end in kept]),
            "accepted": ("limit_value", [int(end.accepted) for _, end in kept]),
        },
        coords={"limit_value": [value for value, _ in kept], "variable": list(keys), "quantity": names},
        attrs={"limit": limit},
    )
