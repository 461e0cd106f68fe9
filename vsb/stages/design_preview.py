"""Checks of a design problem before anything is solved, and what `vsb check` prints of it."""

from pathlib import Path

from vsb.errors import ConfigError
from vsb.stages.climate import read_climate
from vsb.study.campaign import study_at
from vsb.study.design import Variable, unit_of
from vsb.study.design_plan import DesignPlan
from vsb.study.vary import unit
from vsb.waves.climate import OUTSIDE, climate_line

EVALUATION_SECONDS, EVALUATIONS = 0.3, 6
"""Of a buoy with all derivatives on one core; per variable and start, one more."""


def check_design(plan: DesignPlan) -> None:
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
    _check_model(plan)


def _check_model(plan: DesignPlan) -> None:
    """Raise where derivatives of the study's year are not known."""
    from vsb.design.searched import degrees_of, problem_of

    seas = read_climate(plan.climate, plan.loaded.climate_path)
    try:
        for search in (plan.flexible, plan.rigid):
            problem_of(search, seas, degrees_of(search)[0])
    except ConfigError as error:
        raise ConfigError(f"{plan.loaded.source}: study: {error}") from None


def design_summary(plan: DesignPlan) -> list[str]:
    """Return the lines `vsb check` prints of a design problem: variables, limits, cost."""
    check_design(plan)
    problem, search = plan.loaded.problem, plan.flexible
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    limits = ", ".join(f"{name} {value:g} {unit_of(name)}".removesuffix(" 1") for name, value in search.limits.items())
    left = sum(not Path(path).exists() for path in plan.start_paths)
    points, kept = sum(map(len, problem.pareto.values())), ", ".join(one.key for one in plan.rigid.variables)
    evaluations = EVALUATIONS * (len(search.variables) + 1) * (left + 2 * points)
    minutes = max(1, round(evaluations * EVALUATION_SECONDS / 60))
    return [
        f"design       {plan.name}: {problem.maximise} of {plan.loaded.flexible} in {problem.study} over "
        f"{len(seas.hours)} seas",
        *(f"variable     {_bounds(one)}" for one in search.variables),
        f"limits       {limits or 'none'}",
        f"competitor   {plan.loaded.rigid}, optimised in {kept or 'nothing'}",
        f"jobs         {left} of {len(plan.start_paths)} starts to do, {points} points of Pareto fronts"
        + (f", {problem.verify.seas} seas in time" if problem.verify else ""),
        f"cost         about {evaluations} evaluations, {minutes} min on one core"
        + (", runs in time apart" if problem.verify else ""),
        *(f"note         {note}" for note in plan.loaded.notes),
        *map(climate_line, seas.notes),
    ]


def _bounds(one: Variable) -> str:
    """A variable with its bounds."""
    dimension = unit(one.key)
    by = ", by its logarithm" if one.log else ""
    return f"{one.key} {one.low:g} to {one.high:g}{'' if dimension == '1' else ' ' + dimension}{by}"
