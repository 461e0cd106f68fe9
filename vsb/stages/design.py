"""Rules design_start and design_front: the best buoy from one start, and the best buoys over the values of a limit."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import xarray as xr

from vsb.design.certificate import ACTIVE, VIOLATION
from vsb.design.evaluation import Evaluation, Quantity
from vsb.design.optimise import Finer, optimised, within_margins
from vsb.design.problem import IMPOSSIBLE, Point, excesses, limit_parts
from vsb.design.searched import Outcome, best, failed, finer_of, from_start, problem_of, uncertain_margins
from vsb.engine.waves.climate import Climate
from vsb.errors import ConvergenceError, DatabaseError
from vsb.stages.check import read_climate
from vsb.stages.stage import Stamp
from vsb.study.design import OF_SHELL
from vsb.study.specs import Search
from vsb.tools.files import load, save


def run_design_start(search: Search, seed: int, start: int, climate: str, out: str, stamp: Stamp) -> None:
    """Optimise from one start and write where it ended.

    Where the same start ended under other limits it is kept if these limits do not hold it, or else begun from.
    """
    before = earlier(stamp["spec"], Path(out).parent)
    for name, end, limits in before:
        if same := under_limits(end, limits, search.limits, search.sigmas):
            print(f"kept: where start {name} ended, under other limits that did not and do not hold it", flush=True)
            save(same.dataset.assign_attrs(stamp), out)
            return
    begin = None
    if accepted := [(name, end) for name, end, _ in before if end.accepted]:
        name, begin = accepted[0]
        print(f"begun where start {name} ended under other limits", flush=True)
    seas, keys = read_climate(search.climate, climate), [one.key for one in search.variables]
    try:
        found = from_start(search, seas, seed, start, BestSoFar(search), begin)
        result = Outcome.of(found, keys).dataset
    except ConvergenceError as error:
        result = failed(str(error))
    save(result.assign_attrs(stamp), out)


def earlier(text: str, folder: Path) -> list[tuple[str, Outcome, Mapping[str, float]]]:
    """Return names and ends of the same start of the same problem but for values of limits, and those limits."""
    wanted, found = json.loads(text), []
    limits = wanted["search"].pop("limits")
    for path in sorted(folder.glob("*.nc")):
        try:
            ds = load(path)
            given = json.loads(ds.attrs["spec"])
            before = given["search"].pop("limits")
            end = Outcome.read(ds) if given == wanted and before != limits else ""
        except (DatabaseError, KeyError, ValueError):  # no start, or one that is being written
            continue
        if isinstance(end, Outcome):
            found.append((path.stem, end, before))
    return found


def under_limits(
    found: Outcome, before: Mapping[str, float], limits: Mapping[str, float], sigmas: float = 0.0
) -> Outcome | None:
    """Return an optimum as one under other limits, or without some; None if they may have another.

    Where a limit has no multiplier, and the buoy is away from it, the first- and second-order conditions do not contain
    it: they are the same if it is wider, or none, or narrower and the buoy still away from it.

    Parameters
    ----------
    before, limits : mapping
        Limits it was found under, and those now.
    sigmas : float
        Standard deviations kept from them: by how much a buoy nears a narrower limit is then not known.
    """
    if not found.accepted or set(limits) - set(before):
        return None
    known = Evaluation({name: Quantity(value, np.zeros(0)) for name, value in found.quantities.items()})
    margins = dict(found.margins)
    for name, limit in before.items():
        if (now := limits.get(name)) == limit:
            continue
        try:
            parts, far = limit_parts({name: limit}), -ACTIVE
            for part, one in zip(parts, excesses(known, {name: limit}), strict=True):
                if one.value >= far or part in found.multipliers:
                    return None
                if now is None:
                    margins.pop(part, None)
                    continue
                times = now / limit if name == "load_factor" else limit / now
                if times > 1 and sigmas:
                    return None
                margins[part] = times * margins.get(part, math.nan)
                if not times * (1 + one.value) - 1 + max(margins[part], 0.0) < far:
                    return None
        except KeyError:  # what is limited is not known of the buoy
            return None
    return replace(found, margins=margins)


class BestSoFar:
    """Prints the best buoy within all limits whenever there is a better one."""

    def __init__(self, search: Search) -> None:
        self.search, self.objective = search, -math.inf

    def __call__(self, point: Point) -> None:
        """See one more buoy."""
        if point.violation <= VIOLATION and point.objective > self.objective:
            self.objective = point.objective
            named = zip(self.search.variables, point.values, strict=True)
            words = ", ".join(
                f"{one.key.removeprefix('device.').removeprefix('pto.')} {value:.4g}" for one, value in named
            )
            unit = "W " if self.search.maximise == "annual_mean_power" else ""
            maximised = unit + self.search.maximise.replace("_", " ")
            print(f"best so far: {point.objective:.6g} {maximised} with {words}", flush=True)


def outcomes(folder: str, ids: Sequence[str]) -> list[Outcome | str]:
    """Return where starts ended, from their files."""
    return [Outcome.read(load(Path(folder) / f"{one}.nc", expected=one)) for one in ids]


def run_design_front(
    search: Search,
    limit: str,
    values: list[float],
    begun: list[str],
    climate: str,
    starts: str,
    out: str,
    stamp: Stamp,
) -> None:
    """Optimise over the values of one limit, each begun at the best buoy of its neighbour."""
    first, seas = best(outcomes(starts, begun)), read_climate(search.climate, climate)
    save(front(search, seas, limit, sorted(values), first).assign_attrs(stamp), out)


def front(search: Search, climate: Climate, limit: str, values: Sequence[float], first: Outcome) -> xr.Dataset:
    """Return the best buoys over the values of a limit.

    Each is begun at the best buoy of its neighbour, from the one nearest to the search's own outwards, and then once
    more from its other neighbour: the better of both.

    Parameters
    ----------
    values : sequence of float
        Ascending.
    first : Outcome
        The best buoy of the search itself: it is where the value next to its own begins.
    """
    has = first.quantities.get(limit, search.limits.get(limit, values[-1]))
    nearest, last = int(np.argmin([abs(math.log(value / has)) for value in values])), len(values) - 1
    ends: dict[int, Outcome] = {}
    outwards = [(i, i - 1) for i in range(nearest, last + 1)] + [(i, i + 1) for i in range(nearest - 1, -1, -1)]
    inwards = [(i, i + 1) for i in range(last - 1, -1, -1)] + [(i, i - 1) for i in range(1, last + 1)]
    begun: dict[int, set[bytes]] = {i: set() for i in range(last + 1)}
    for i, neighbour in (*outwards, *inwards):
        begin = ends.get(neighbour, first)
        if begin.values.tobytes() in begun[i]:
            continue
        begun[i].add(begin.values.tobytes())
        found = _best_from(under_limit(search, limit, values[i]), climate, begin, first.degree)
        if found and (i not in ends or (found.accepted, found.objective) > (ends[i].accepted, ends[i].objective)):
            ends[i] = found
    return as_dataset(limit, [(values[i], end) for i, end in sorted(ends.items())])


def under_limit(search: Search, limit: str, value: float) -> Search:
    """The search under a value of a limit; those of a shell hold no rigid buoy."""
    if limit in OF_SHELL and not search.flexible:
        return search
    return search.model_copy(update={"limits": {**search.limits, limit: value}})


def _best_from(search: Search, climate: Climate, begin: Outcome, degree: int | None) -> Outcome | None:
    """The best buoy of a search from where another ended; None if there is no such buoy at rest."""
    of = cache(partial(problem_of, search, climate))
    problem, margins_of = of(degree), uncertain_margins(search)
    try:
        start = problem.at(problem.place(list(begin.values)))
        found = optimised(problem, start)
    except IMPOSSIBLE:
        return None
    uncertain = partial(margins_of, problem) if margins_of else None
    try:
        found, known = within_margins(problem, found, partial(finer_of, search, of, degree=degree), uncertain)
    except IMPOSSIBLE as error:
        message = f"with more shell modes than to degree {degree} it has no stable rest shape: {error}"
        found, known = replace(found, accepted=False, message=message), Finer(None, np.array([]))
    margins = dict(zip(problem.limit_names, map(float, known.margins), strict=False))
    keys, made = [one.key for one in search.variables], problem.evaluations
    return Outcome.at(found, keys, start.values, degree, known.truncation, made, margins)


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
