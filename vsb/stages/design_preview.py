"""Checks of a design problem before anything is solved, and what `vsb check` prints of it."""

from pathlib import Path
from time import process_time

from vsb.design.optimise import first_possible
from vsb.design.problem import Problem
from vsb.design.searched import degrees_of, places, problem_of
from vsb.errors import ConfigError, ConvergenceError
from vsb.stages.climate import read_climate
from vsb.study.campaign import study_at
from vsb.study.design import Variable, unit_of
from vsb.study.design_plan import DesignPlan
from vsb.study.vary import unit
from vsb.waves.climate import OUTSIDE, Climate, climate_line

JOB_SECONDS, RESULTS_SECONDS = 5.0, 10.0
"""CPU time of a process of its own, and of tables, figures and report [s]."""
COMPARED = 12
"""Evaluations of the buoys compared: twin, sphere, and finer ones for the numerical error."""
MORE_MODES = 1.5
"""Cost of an evaluation with the degrees of shell modes beyond the first, in terms of the first."""


def check(plan: DesignPlan) -> None:
    """Raise what would fail later in a design problem; raises `ConfigError`."""
    source, loaded = plan.loaded.source, plan.loaded
    seas = read_climate(plan.climate, loaded.climate_path)
    study = study_at(plan.flexible.base, {})
    outside = seas.variance_outside(0.0, study.hydro.omega_max)
    if outside > OUTSIDE:
        raise ConfigError(
            f"{source}: climate: {outside:.1%} of its variance lies above {study.hydro.omega_max:.4g} rad/s, up to "
            f"which the water is solved; needs at most {OUTSIDE:.0%}, a larger hydro.omega_max in the study"
        )
    study_at(plan.rigid.base, {})
    _problems(plan, seas)


def _problems(plan: DesignPlan, seas: Climate) -> list[Problem]:
    """The problems of the flexible buoy and of its competitor; raises where derivatives of their year are not known."""
    try:
        return [problem_of(search, seas, degrees_of(search)[0]) for search in (plan.flexible, plan.rigid)]
    except ConfigError as error:
        raise ConfigError(f"{plan.loaded.source}: study: {error}") from None


def summary(plan: DesignPlan) -> list[str]:
    """Return the lines `vsb check` prints of a design problem: variables, limits, cost."""
    check(plan)
    problem, search = plan.loaded.problem, plan.flexible
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    limits = ", ".join(f"{name} {value:g} {unit_of(name)}".removesuffix(" 1") for name, value in search.limits.items())
    left = sum(not Path(path).exists() for path in plan.start_paths)
    points, kept = sum(map(len, problem.pareto.values())), ", ".join(one.key for one in plan.rigid.variables)
    return [
        f"design       {plan.name}: {problem.maximise} of {plan.loaded.flexible} in {problem.study} over "
        f"{len(seas.hours)} seas",
        *(f"variable     {_bounds(one)}" for one in search.variables),
        f"limits       {limits or 'none'}",
        f"competitor   {plan.loaded.rigid}, optimised in {kept or 'nothing'}",
        f"jobs         {left} of {len(plan.start_paths)} starts to do, {points} points of Pareto fronts"
        + (f", {problem.verify.seas} seas in time" if problem.verify else ""),
        f"cost         {_cost(plan, seas, points)}" + (", runs in time apart" if problem.verify else ""),
        *(f"note         {note}" for note in plan.loaded.notes),
        *map(climate_line, seas.notes),
    ]


def evaluations_of_start(variables: int) -> int:
    """Return about how many buoys one start evaluates: 7 of one variable, 22 of four, 55 of seven, as measured."""
    return variables**2 + 6


def evaluations_of_point(variables: int) -> int:
    """Return about how many buoys a point of a Pareto front evaluates, begun at the optimum of its neighbour."""
    return variables + 6


def _cost(plan: DesignPlan, seas: Climate, points: int) -> str:
    """Evaluations and CPU time of what is left to do, from one evaluation of each kind of buoy in this process."""
    evaluations, seconds, problem = 0, RESULTS_SECONDS, plan.loaded.problem
    for search, starts in ((plan.flexible, plan.starts), (plan.rigid, plan.rigid_starts)):
        left, count = sum(not Path(plan.start_path(name)).exists() for name in starts), len(search.variables)
        degrees = search.degrees[:3] or (None,)
        begun = process_time()
        one = problem_of(search, seas, degrees[0])
        built = process_time() - begun
        try:
            place = first_possible(one, places(one, len(starts), problem.seed, 0))[0].place
        except ConvergenceError as error:
            return f"not known: of {search.design}, {error}"
        begun = process_time()
        one.known.clear()  # a repeated evaluation, without what the first one prepares
        one.at(place)
        each = process_time() - begun
        more = MORE_MODES * (len(degrees) - 1)
        of_starts, of_points = left * evaluations_of_start(count), points * evaluations_of_point(count)
        evaluations += of_starts + of_points
        seconds += left * (JOB_SECONDS + (1 + more) * built + (1 + more) * each) + (points > 0) * (JOB_SECONDS + built)
        seconds += (of_starts + of_points + COMPARED) * each
    return f"about {evaluations} evaluations, {seconds:.0f} s on one core"


def _bounds(one: Variable) -> str:
    """A variable with its bounds."""
    dimension = unit(one.key)
    by = ", by its logarithm" if one.log else ""
    return f"{one.key} {one.low:g} to {one.high:g}{'' if dimension == '1' else ' ' + dimension}{by}"
