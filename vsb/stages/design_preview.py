"""Checks of a design problem before anything is solved, and what `vsb check` prints of it."""

from collections.abc import Sequence
from pathlib import Path
from time import process_time
from typing import NamedTuple

from vsb.design.optimise import first_possible, led_at_rest, within_limits
from vsb.design.problem import IMPOSSIBLE, Point, Problem
from vsb.design.searched import degrees_of, places, problem_of
from vsb.engine.motion.take_off import port_kind
from vsb.engine.waves.climate import OUTSIDE, Climate, climate_line
from vsb.errors import ConfigError, ConvergenceError
from vsb.pipeline.costs import START_OF_A_PROCESS
from vsb.pipeline.graph import Task
from vsb.pipeline.jobs import seconds_of_jobs
from vsb.pipeline.plans import DesignPlan
from vsb.report.design_answer import in_control
from vsb.stages.check import read_climate
from vsb.study.campaign import CAUSAL, study_at
from vsb.study.design import PARTS, Variable, unit_of
from vsb.study.specs import Search
from vsb.study.vary import unit
from vsb.tools.variables import PortKind

RESULTS_SECONDS = 5.0
"""CPU time of tables, figures and report [s]."""
COMPARED = 12
"""Evaluations of the buoys compared: twin, sphere, and finer ones for the numerical error."""
MORE_MODES = 1.5
"""Cost of an evaluation with the degrees of shell modes beyond the first, in terms of the first."""


REPEATED = 3
"""Times a buoy is evaluated for its time: on a busy machine one of them may take twice as long."""
FAR = 100.0
"""Times the value of the study's buoy from which on a limit is probably a slip."""


def check(plan: DesignPlan) -> None:
    """Raise what would fail later in a design problem; raises `ConfigError`."""
    for one in _problems(plan, read_climate(plan.climate, plan.loaded.climate_path)):
        _check_within(plan, one)


class Prepared(NamedTuple):
    """The problem of one search, and the CPU time it took to set up [s]."""

    search: Search
    starts: tuple[Task, ...]
    problem: Problem
    seconds: float


def _problems(plan: DesignPlan, seas: Climate) -> list[Prepared]:
    """The problems of the flexible buoy and of its competitor; raises where derivatives of their year are not known."""
    source, study = plan.loaded.source, study_at(plan.flexible.base, {})
    outside = seas.variance_outside(0.0, study.hydro.omega_max)
    if outside > OUTSIDE:
        raise ConfigError(
            f"{source}: climate: {outside:.1%} of its variance lies above {study.hydro.omega_max:.4g} rad/s, up to "
            f"which the water is solved; needs at most {OUTSIDE:.0%}, a larger hydro.omega_max in the study"
        )
    study_at(plan.rigid.base, {})
    found = []
    for search, starts in ((plan.flexible, plan.starts), (plan.rigid, plan.rigid_starts)):
        begun = process_time()
        try:
            problem = problem_of(search, seas, degrees_of(search)[0])
        except ConfigError as error:
            raise ConfigError(f"{source}: study: {error}") from None
        found.append(Prepared(search, tuple(starts.values()), problem, process_time() - begun))
    return found


LED, MUCH = 2, 1.0
"""Starts led to the limits until one reaches them, and what is a large violation of limits."""


def _check_within(plan: DesignPlan, one: Prepared) -> None:
    """Check that one of the first starts leads to a buoy within the limits, or none is certified or far from them.

    Limits in waves are looked at where they are far away, for they take longer.
    """
    conflict = ""
    for start in range(LED):
        try:
            found = led_at_rest(one.problem, places(one.problem, plan.loaded.problem.seed, start)[0])
            if not found.conflict and (point := one.problem.at(found.point.place)).violation > MUCH:
                found = within_limits(one.problem, point)
        except IMPOSSIBLE:
            continue
        if not found.conflict:
            return
        if found.certified or found.point.violation > MUCH:
            conflict = found.conflict
    if conflict:
        raise ConfigError(f"{plan.loaded.source}: limits: {conflict} (design {one.search.design})")


class Tried(NamedTuple):
    """A buoy of a search evaluated, and the CPU time of that [s]; or why none rests."""

    point: Point | None
    seconds: float
    reason: str = ""


def _tried(one: Prepared, seed: int) -> Tried:
    """The buoy that the first start begins at."""
    problem = one.problem
    try:
        place = first_possible(problem, places(problem, seed, 0))[0].place
    except ConvergenceError as error:
        return Tried(None, 0.0, str(error))
    seconds = []
    for _ in range(REPEATED):
        problem.known.clear()  # a repeated evaluation, without what the first one prepares
        begun = process_time()
        point = problem.at(place)
        seconds.append(process_time() - begun)
    return Tried(point, min(seconds))


def summary(plan: DesignPlan) -> list[str]:
    """Return the lines `vsb check` prints of a design problem: variables, limits, cost, and what is probably a slip."""
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    prepared = _problems(plan, seas)
    for one in prepared:
        _check_within(plan, one)
    problem, search, study = plan.loaded.problem, plan.flexible, plan.loaded.base
    tried = [_tried(one, problem.seed) for one in prepared]
    limits = ", ".join(f"{name} {value:g} {unit_of(name)}".removesuffix(" 1") for name, value in search.limits.items())
    left = sum(not Path(one.out).exists() for one in plan.all_starts)
    points, kept = sum(map(len, problem.pareto.values())), ", ".join(one.key for one in plan.rigid.variables)
    return [
        f"design       {plan.name}: {problem.maximise} of {plan.loaded.flexible} in {problem.study} over "
        f"{len(seas.hours)} seas",
        *(f"variable     {_bounds(one, port_kind(study.pto.port))}" for one in search.variables),
        f"limits       {limits or 'none'}"
        + (f", kept by {search.sigmas:g} standard deviations" if search.sigmas else ""),
        *([f"take-off     {in_control(plan.loaded.base.pto.control)}"] if search.tuning == CAUSAL else []),
        f"competitor   {plan.loaded.rigid}{_in_heave(plan)}, optimised in {kept or 'nothing'}",
        f"jobs         {left} of {len(plan.all_starts)} starts to do, {points} points of Pareto fronts"
        + (f", {problem.verify.seas} seas in time" if problem.verify else ""),
        f"cost         {_cost(plan, prepared, tried)}" + (", runs in time apart" if problem.verify else ""),
        *(f"note         {note}" for note in plan.loaded.notes),
        *(f"doubt        {doubt}" for doubt in [*plan.loaded.doubts, *_far_limits(plan, prepared, tried)]),
        *map(climate_line, seas.notes),
    ]


def _far_limits(plan: DesignPlan, prepared: Sequence[Prepared], tried: Sequence[Tried]) -> list[str]:
    """Limits and values of fronts far from what the buoys evaluated have, and searches none of whose buoys rests."""
    found, problem = [], plan.loaded.problem
    for one, end in zip(prepared, tried, strict=True):
        if end.point is None:
            found.append(f"variables: of {one.search.design}, {end.reason}; other starts may find one")
            continue
        given = [("limits", name, value) for name, value in one.search.limits.items()]
        given += [("pareto", name, value) for name, values in problem.pareto.items() for value in values]
        for section, name, value in given:
            known = [end.point.evaluation.quantities.get(part) for part in PARTS.get(name, (name,))]
            has = max((quantity.value for quantity in known if quantity), default=0.0)
            if has > FAR * value:
                words = f"{has:.3g} {unit_of(name)}".removesuffix(" 1")
                found.append(
                    f"{section}.{name}: received {value:g}, and the first buoy of {one.search.design} has {words}: "
                    f"{has / value:.2g} times more"
                )
    return found


def evaluations_of_start(variables: int) -> int:
    """Return about how many buoys one start evaluates: measured 19 of five variables, 43 to 104 of seven."""
    return variables**2 + 6


def evaluations_of_point(variables: int) -> int:
    """Return about how many buoys a point of a Pareto front evaluates, begun at the optimum of its neighbour."""
    return variables + 6


def _cost(plan: DesignPlan, prepared: Sequence[Prepared], tried: Sequence[Tried]) -> str:
    """Evaluations and CPU time of what is left to do, from one evaluation of each kind of buoy in this process."""
    evaluations, seconds, problem = 0, START_OF_A_PROCESS + RESULTS_SECONDS, plan.loaded.problem
    points = sum(map(len, problem.pareto.values()))
    for one, end in zip(prepared, tried, strict=True):
        if end.point is None:
            return f"not known: of {one.search.design}, {end.reason}"
        left = sum(not Path(start.out).exists() for start in one.starts)
        count, more = len(one.search.variables), MORE_MODES * (len(one.search.degrees[:3] or (None,)) - 1)
        of_starts, of_points = left * evaluations_of_start(count), points * evaluations_of_point(count)
        evaluations += of_starts + of_points
        seconds += left * (one.seconds + more * (one.seconds + end.seconds)) + len(problem.pareto) * one.seconds
        seconds += (of_starts + of_points + COMPARED) * end.seconds
    seconds += seconds_of_jobs(plan)
    return f"about {evaluations} evaluations, {seconds:.0f} s on one core"


def _in_heave(plan: DesignPlan) -> str:
    """Where the take-off of the competitor acts if not where that of the study does."""
    return f", take-off in {port}" if (port := plan.loaded.problem.competitor.port) else ""


def _bounds(one: Variable, kind: PortKind) -> str:
    """A variable with its bounds, at a kind of port."""
    dimension = unit(one.key, kind)
    by = ", by its logarithm" if one.log else ""
    return f"{one.key} {one.low:g} to {one.high:g}{'' if dimension == '1' else ' ' + dimension}{by}"
