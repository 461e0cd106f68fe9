"""The best buoy from one start: sequential quadratic programming with exact gradients, then a certificate of its own.

The optimiser is scipy's SLSQP (Kraft 1988). Where an evaluation fails, because the shell has no stable rest shape, its
line search backs off. What it ends at is moved to the optimum of its active set by Newton steps and certified
(`vsb.design.certificate`); what is not certified is returned all the same and says why.

A buoy within all limits, or the limits that leave none: what comes before a search.

Minimised is v = 1/2 sum r_i^2 with r = ln(1 + g) of the excesses g > 0 over limits, by the method of Gauss and Newton
between the bounds. Where it ends above 0 its gradient vanishes, but for what bounds hold back:

    sum_i r_i dr_i/dx = mu,    mu >= 0 at lower bounds, <= 0 at upper ones, 0 elsewhere.

With the weights r > 0 this is a certificate: to first order no other buoy exceeds these limits less, all together, and
the limits and bounds with a weight are those that conflict.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.stats import qmc

from vsb.design.certificate import (
    KKT,
    VIOLATION,
    Curvature,
    Multipliers,
    bound_names,
    curvature,
    multipliers,
    newton_step,
)
from vsb.design.evaluation import Evaluation
from vsb.design.problem import IMPOSSIBLE, POWER, SMALLEST, Point, Problem, by_modes
from vsb.errors import ConvergenceError
from vsb.models.mode_convergence import by_all_modes
from vsb.study.design import limit_of
from vsb.tools.arrays import FloatArray

INSIDE = 1e-3
"""Distance from a limit that is aimed at, relative to it."""
AT_BOUND = 1e-6
"""Distance from a bound, in ranges, within which the phase begins at it: its first step would end there."""
MOST = 40
"""Evaluations at most."""
CERTAIN = 0.02
"""What may be left of the gradient of the certificate, in terms of the sum of the sizes of its parts."""
SHARE = 0.05
"""Part of the largest weight from which on a limit or bound is named."""
FAR = 1e3
"""Residual of a buoy without an equilibrium."""


class _Within(Exception):
    """Ends the phase: a buoy is within all limits."""


class Phase(NamedTuple):
    """Where the phase ended."""

    point: Point  # a buoy within all limits, or the nearest found
    conflict: str = ""  # what the nearest buoy found exceeds, in words
    certified: bool = False  # whether it exceeds least


def within_limits(problem: Problem, start: Point, seen: Callable[[Point], None] | None = None) -> Phase:
    """Return a buoy within all limits, led there from one that is not, or the nearest and what limits conflict."""
    if start.violation <= 0 or not problem.variables:
        return Phase(start)
    best, last = start, start

    def at(place: FloatArray) -> Point | None:
        nonlocal best
        try:
            found = problem.at(place)
        except IMPOSSIBLE:
            return None
        if seen:
            seen(found)
        if found.violation < best.violation:
            best = found
        if best.violation <= 0:
            raise _Within
        return found

    def residuals(place: FloatArray) -> FloatArray:
        nonlocal last
        last = at(place) or last
        return _residuals(last) if last.place.tobytes() == place.tobytes() else np.full(len(start.excess), FAR)

    def slopes(place: FloatArray) -> FloatArray:
        return _slopes(problem.at(place))

    begin = np.where(np.abs(start.place - np.round(start.place)) < AT_BOUND, np.round(start.place), start.place)
    try:
        end = least_squares(
            residuals, begin, slopes, bounds=(0.0, 1.0), method="dogbox", xtol=1e-5, ftol=1e-4, max_nfev=MOST
        )
    except _Within:
        return Phase(best)
    return _conflict(problem, problem.at(end.x))


class _NotEvaluated:
    """A model of buoys that are not evaluated, of which only what bounds every buoy is known."""

    def at(self, values: Sequence[float]) -> Evaluation:
        return Evaluation({})


def led_at_rest(problem: Problem, place: FloatArray) -> Phase:
    """Return where a place is led by the limits of a buoy at rest, those of every buoy first.

    Raises one of `IMPOSSIBLE` where no buoy can be evaluated on the way.
    """
    bounded = replace(problem, model=_NotEvaluated(), limits={}, twin=None, margins=None, known={})
    found = within_limits(bounded, bounded.at(place))
    if found.conflict or (rest := problem.at_rest) is None:
        return found
    return within_limits(rest, rest.at(found.point.place))


def _residuals(point: Point) -> FloatArray:
    """What is minimised, r (limit,)."""
    return np.asarray(np.log1p(np.maximum(point.excess + INSIDE, 0.0)))


def _slopes(point: Point) -> FloatArray:
    """Derivatives of that, (limit, variable)."""
    over = np.maximum(point.excess + INSIDE, 0.0)
    return np.where(over[:, None] > 0, point.jacobian / (1 + over[:, None]), 0.0)


def _conflict(problem: Problem, point: Point) -> Phase:
    """The limits and bounds that conflict at a buoy, and whether the conditions of least violation hold."""
    weight, slopes = _residuals(point), _slopes(point)
    parts = weight[:, None] * slopes
    gradient, size = parts.sum(axis=0), np.abs(parts).sum(axis=0).max(initial=0.0)
    held = ((point.place <= 0.0) & (gradient > 0)) | ((point.place >= 1.0) & (gradient < 0))
    certified = bool(np.abs(gradient[~held]).max(initial=0.0) <= CERTAIN * size)
    excesses: dict[str, float] = {}
    for part, excess in zip(problem.limit_names, point.excess, strict=True):
        excesses[limit_of(part)] = max(float(excess), excesses.get(limit_of(part), 0.0))
    limits = [
        f"{name} exceeded by {100 * excess:.2g} %"
        for name, excess in excesses.items()
        if np.log1p(excess) > SHARE * weight.max()
    ]
    bounds = [
        f"{one.key} at its {'lower' if place <= 0 else 'upper'} bound, {one.value(round(place)):g}"
        for one, place, slope, on in zip(problem.variables, point.place, gradient, held, strict=True)
        if on and abs(slope) > SHARE * size
    ]
    words = "no buoy keeps the limits: the nearest" if certified else "no buoy was found within the limits: the nearest"
    return Phase(point, f"{words} has {', '.join([*limits, *bounds])}", certified)


ROUNDS = ((3e-3, 1e-7), (1e-3, 1e-9), (1e-4, 1e-11), (1e-5, 1e-13), (0.0, 1e-15), (0.0, 1e-16))
"""Runs of the optimiser, each from where the last one ended: steps, in ranges, and changes of the objective at which it
leaves the rest to Newton. Near a vertex of limits its merit function is flat towards them, and its line search takes
dozens of steps; along a ridge the objective hardly changes.
"""
ITERATIONS = 100
"""Of each run."""
OFF_SADDLE = 0.01
"""Distance from a saddle at which the next run begins, in ranges."""
NEWTON_STEPS, LONGEST_STEP = 6, 0.05
"""Most Newton steps, and the longest of them in ranges."""
HELD = 1e-3
"""Distance from a limit within which it is taken for active before the Newton steps."""
BEYOND = 0.02
"""Violation from which on a start is led within the limits before it is searched from, and no run ends early."""
TRIES = 16
"""Places tried for one start until a buoy rests."""
Progress = Callable[[Point], None]
"""Is called with every buoy that is evaluated."""


@dataclass(frozen=True)
class Optimum:
    """Where one start ended, and its certificate.

    `accepted` says that first-order conditions and limits hold to `KKT` and `VIOLATION`, and that it is no saddle.
    """

    point: Point
    objective: float
    multipliers: dict[str, float]  # of limits and bounds that hold: relative gain per relative widening of a limit
    kkt: float
    violation: float
    curvatures: tuple[float, ...]  # of the Lagrangian on the directions left free, ascending; none where not known
    flat: tuple[str, ...]
    accepted: bool
    message: str
    evaluations: int  # of the problem so far


def start_places(start: int, variables: int, seed: int, given: FloatArray | None) -> list[FloatArray]:
    """Return the places a start tries in turn: the first the study's own, then its point of a scrambled Sobol sequence.

    Where no buoy rests there, points of a sequence of its own follow. They are a function of the seed and the start
    alone: more starts later keep those there are.
    """
    own = [given] if given is not None and start == 0 else []
    drawn = qmc.Sobol(variables, seed=seed).random_base2(int(np.ceil(np.log2(start + 2))))[start]
    others = qmc.Sobol(variables, seed=np.random.default_rng([seed, start])).random_base2(int(np.log2(TRIES)))
    return [*own, drawn, *others[1:]]


def first_possible(problem: Problem, places: Sequence[FloatArray]) -> tuple[Point, list[str]]:
    """Return the first buoy that rests, and why those before it do not; raises `ConvergenceError` if none does.

    A place without one is led to the limits at rest first. Where these leave no buoy no other place is tried.
    """
    reasons: list[str] = []
    for place in places:
        try:
            return problem.at(place), reasons
        except IMPOSSIBLE as error:
            reasons.append(str(error))
        try:
            led = led_at_rest(problem, place)
            if not led.conflict:
                return problem.at(led.point.place), reasons
        except IMPOSSIBLE:
            continue
        raise ConvergenceError(led.conflict)
    raise ConvergenceError(f"none of {len(places)} buoys tried rests: {reasons[-1]}")


def optimised(problem: Problem, start: Point, seen: Progress | None = None) -> Optimum:
    """Return the best buoy from a start.

    Parameters
    ----------
    start : Point
        Of this problem or of one with the same variables; its objective is the scale of this run.
    seen : callable, optional
        Is called with every buoy evaluated.
    """
    scaled = problem.rescaled(start)
    point = scaled.at(start.place)
    if point.violation > BEYOND and problem.variables:
        point, conflict, _ = within_limits(scaled, point, seen)
        if conflict:
            return replace(_certified(scaled, point, multipliers(point), None, ""), message=conflict)
        scaled = problem.rescaled(point)
        point = scaled.at(point.place)
    if not problem.variables:
        return _certified(scaled, point, multipliers(point), None, "no variables")
    best, other = _climbed(scaled, point, seen)
    if other is not None and not best.accepted:
        again, _ = _climbed(problem.rescaled(other), other, seen)
        best = again if again.accepted else best
    return best


def _climbed(problem: Problem, point: Point, seen: Progress | None) -> tuple[Optimum, Point | None]:
    """The end of a search from a point, and the side of the last saddle on its way that was not taken, if any."""
    beside: list[Point] = []
    for close, change in ROUNDS:
        point, message = _searched(problem, point, (close, change), seen)
        polished, found, curved = _polished(problem.rescaled(point), point)
        best = _certified(problem, polished, found, curved, message)
        point = best.point
        if best.accepted:
            break
        problem = problem.rescaled(point)
        point = problem.at(point.place)
        if curved and curved.saddle:
            beside = _beside_saddle(problem, point, found, curved)
            point = beside[0] if beside else point
    return best, beside[1] if len(beside) > 1 else None


OF_POWER = (POWER, "power_per_mass", "power_per_surface")
"""Objectives that gain by a wider limit of a causal controller what the power does."""


class _Close(Exception):
    """Ends a run of the optimiser: its steps have become small, near enough to all limits."""


def _searched(problem: Problem, start: Point, ends: tuple[float, float], seen: Progress | None) -> tuple[Point, str]:
    """Where SLSQP ends, and what it says; of a search that broke off the best point it has seen."""
    last, visited, iterates = [start], [start], [start.place]

    def at(place: FloatArray) -> Point | None:
        try:
            found = problem.at(np.clip(place, 0.0, 1.0))
        except IMPOSSIBLE:
            return None
        last[0] = found
        visited.append(found)
        if seen:
            seen(found)
        return found

    def cost(place: FloatArray) -> float:
        found = at(place)
        return found.cost if found else visited[0].cost + BARRIER

    def slope(place: FloatArray) -> FloatArray:
        step = np.abs(place - iterates[-1]).max()
        if 0.0 < step < ends[0] and last[0].violation <= BEYOND:
            raise _Close
        iterates.append(place.copy())
        return (at(place) or last[0]).slope

    def room(place: FloatArray) -> FloatArray:
        return -(at(place) or last[0]).excess

    def room_slope(place: FloatArray) -> FloatArray:
        return -(at(place) or last[0]).jacobian

    limits: Any = [{"type": "ineq", "fun": room, "jac": room_slope}] if start.excess.size else []
    options: Any = {"maxiter": ITERATIONS, "ftol": ends[1]}
    bounds = [(0.0, 1.0)] * len(start.place)
    try:
        found = minimize(
            cost, start.place, jac=slope, bounds=bounds, constraints=limits, method="SLSQP", options=options
        )
    except _Close:
        return last[0], "steps have become small"
    return (at(found.x) or min(visited, key=_merit)), str(found.message)


BARRIER = 1e6
"""Cost, in the objective's scale, of a buoy without a stable rest shape."""


def _merit(point: Point) -> float:
    """What orders points: cost, and far more any violation."""
    return point.cost + BARRIER * point.violation


def _polished(problem: Problem, point: Point) -> tuple[Point, Multipliers, Curvature | None]:
    """A point moved to the optimum of its active set by Newton steps, with its multipliers and curvature."""
    point = problem.at(point.place)
    found = multipliers(point, HELD)
    curved = curvature(problem, point, found)
    for _ in range(NEWTON_STEPS):
        exact = multipliers(point)
        if curved is None or (exact.kkt <= 0.1 * KKT and point.violation <= 0.1 * VIOLATION):
            break
        step = newton_step(point, found, curved)
        if np.abs(step).max(initial=0.0) > LONGEST_STEP:
            break
        try:
            moved = problem.at(np.clip(point.place + step, 0.0, 1.0))
        except IMPOSSIBLE:
            break
        after = multipliers(moved, HELD)
        if max(multipliers(moved).kkt, moved.violation) >= max(exact.kkt, point.violation):
            break
        if (after.free != found.free).any():  # the curvature is of other variables
            curved = curvature(problem, moved, after)
        point, found = moved, after
    point = problem.rescaled(point).at(point.place)  # Newton's steps have changed the objective
    return point, multipliers(point), curved


def _beside_saddle(problem: Problem, point: Point, found: Multipliers, curved: Curvature) -> list[Point]:
    """Points at either side of a saddle along the direction that gives most, the better first; those that rest."""
    beside = []
    for step in (OFF_SADDLE, -OFF_SADDLE):
        try:
            beside.append(problem.at(np.clip(point.place + step * curved.directions[:, 0], 0.0, 1.0)))
        except IMPOSSIBLE:
            continue
    return sorted(beside, key=lambda one: one.cost + float(found.limits @ one.excess))


def _certified(problem: Problem, point: Point, found: Multipliers, curved: Curvature | None, message: str) -> Optimum:
    """The certificate of a point, whose objective is scaled to itself; the first-order conditions to the start."""
    keys = tuple(one.key for one in problem.variables)
    kkt = found.kkt * max(abs(point.objective), SMALLEST) / problem.scale
    named = {name: float(value) for name, value in zip(problem.limit_names, found.limits, strict=True) if value > 0}
    named |= {name: float(value) for name, value in bound_names(found, keys).items()}
    if problem.maximise in OF_POWER:
        named |= point.evaluation.worth
    saddle = curved is not None and curved.saddle
    accepted = bool(kkt <= KKT and point.violation <= VIOLATION) and not saddle
    worst = problem.limit_names[int(point.excess.argmax())] if point.excess.size else ""
    why = "" if accepted else _why(kkt, point, worst, saddle=saddle, message=message)
    return Optimum(
        point=point,
        objective=point.objective,
        multipliers=named,
        kkt=kkt,
        violation=point.violation,
        curvatures=tuple(map(float, curved.reduced)) if curved else (),
        flat=tuple(curved.flat(keys)) if curved else (),
        accepted=accepted,
        message=why,
        evaluations=problem.evaluations,
    )


def _why(kkt: float, point: Point, worst: str, *, saddle: bool, message: str) -> str:
    """Why a point is not accepted."""
    if point.violation > VIOLATION:
        return f"the limit of {worst} is exceeded by {100 * point.violation:.2g} % ({message})"
    if kkt > KKT:
        return f"the first-order conditions hold to {kkt:.2g} only ({message})"
    return "a saddle: some direction gives more" if saddle else ""


@dataclass(frozen=True)
class Converged:
    """The best buoy from one start, with as many shell modes as its power needs."""

    optimum: Optimum
    start: Point
    reasons: tuple[str, ...]  # why places tried before do not rest
    degree: int | None  # highest Legendre degree; none of a rigid buoy
    truncation: tuple[float, float] | None  # of the power, by `left_out`; none of a rigid buoy, or where not known
    margins: dict[str, float]  # most by which shell modes left out raise the excess over each limit, relative to it
    evaluations: int


FURTHER = 2
"""Degrees beyond that of an optimum with which it is evaluated, too."""
Expected = Callable[[Point, int], float]
"""What shell modes beyond a degree are expected to change of the power of a buoy at least, relative."""


def left_out(changes: Sequence[float], least: float = 0.0) -> tuple[float, float]:
    """Return the ends between which all further degrees of shell modes change a power, relative, zero included.

    Parameters
    ----------
    changes : sequence of float
        By the degrees evaluated beyond that of the power, ascending, relative to it.
    least : float
        See `vsb.models.mode_convergence.by_all_modes`.
    """
    low, high = by_all_modes(np.zeros(()), [np.zeros(()), *map(np.asarray, changes)], least=least)
    return float(low), float(high)


@dataclass(frozen=True)
class Finer:
    """A buoy with more shell modes: what those left out may change."""

    truncation: tuple[float, float] | None  # of the power, relative, see `left_out`; none where not known
    margins: FloatArray  # most by which they raise excesses over limits, shape (limit,); nan where not known
    points: tuple[Point, ...] = ()  # values of the buoy with each of the degrees beyond its own


def finer(
    problem_of: Callable[[int | None], Problem],
    degrees: Sequence[int | None],
    point: Point,
    expected: Expected = lambda point, degree: 0.0,
) -> Finer:
    """Return a buoy with more shell modes, and what all further ones may change.

    Raises one of `IMPOSSIBLE` if it has no stable equilibrium with them.

    Parameters
    ----------
    degrees : sequence of int, or of one None
        Of the buoy, and those beyond it that are evaluated; one of none: a rigid buoy.
    expected : callable
        Buoy and degree -> what further ones change of the power at least.
    """
    last = degrees[-1]
    if last is None:
        return Finer(None, np.zeros_like(point.excess))
    own, *points = (problem_of(degree).valued.at(point.place) for degree in degrees)
    if len(points) < FURTHER:
        return Finer(None, np.full_like(point.excess, np.nan), tuple(points))
    changes = [one.evaluation[POWER].value / own.evaluation[POWER].value - 1 for one in points]
    grown = [one.excess - own.excess for one in points]
    return Finer(left_out(changes, expected(point, last)), by_modes(grown), tuple(points))


MARGIN_ROUNDS, SAFE = 4, 1.1
"""Most searches with margins of the limits, each by what was found at the end of the one before, and a little more."""
USED = 1e-3
"""Part of a limit that a buoy uses up to which no margin is kept from it."""


def within_margins(
    problem: Problem,
    found: Optimum,
    finer_at: Callable[[Point], Finer],
    spread: Callable[[Point], FloatArray] | None = None,
    seen: Progress | None = None,
) -> tuple[Optimum, Finer]:
    """Return the best buoy that keeps its limits with all shell modes, and as it may be built.

    One that does not in `MARGIN_ROUNDS` searches is not accepted. Raises one of `IMPOSSIBLE` if it has no stable
    equilibrium with more shell modes.

    Parameters
    ----------
    problem : Problem
        Without margins.
    found : Optimum
        Of that problem.
    finer_at : callable
        Buoy -> what shell modes left out may change.
    spread : callable, optional
        Buoy -> margins for what is uncertain, (limit,).
    """
    known, searches = finer_at(found.point), 0
    if not found.accepted:
        return found, known
    while True:
        margins = known.margins + (spread(found.point) if spread else 0.0)
        plain = problem.at(found.point.place).excess
        if not plain.size or ((plain + margins).max() <= VIOLATION and found.accepted):
            return found, known
        worst = int(np.nan_to_num(plain + margins, nan=np.inf).argmax())
        limit, over = problem.limit_names[worst], float((plain + margins)[worst])
        if np.isnan(over):
            words = f"what more shell modes change the limit of {limit} by is not known"
            return replace(found, accepted=False, message=words), known
        if searches == MARGIN_ROUNDS or not (found.accepted or found.violation <= VIOLATION):
            break
        factors = 1 + SAFE * np.divide(margins, 1 + plain, out=np.zeros_like(plain), where=1 + plain > USED)
        found, searches = optimised(replace(problem, margins=factors), found.point, seen), searches + 1
        known = finer_at(found.point)
    words = f"with more shell modes{' or as built' if spread else ''} the limit of {limit} is exceeded by "
    kept = f"kept away from its limits by what more shell modes change{' and as built' if spread else ''}: "
    message = f"{words}{100 * over:.2g} %" if over > 0 else f"{kept}{found.message}"
    return replace(found, accepted=False, message=message), known


def converged(
    problem_of: Callable[[int | None], Problem],
    degrees: Sequence[int | None],
    tolerance: float,
    places: Sequence[FloatArray],
    seen: Progress | None = None,
    expected: Expected = lambda point, degree: 0.0,
    spread: Callable[[Problem, Point], FloatArray] | None = None,
) -> Converged:
    """Return the best buoy from one start, solved again with more shell modes until they change little.

    An optimiser exploits what a basis leaves out, so that the modes a study converged with are not enough. Within each
    run the degree is fixed: the objective stays smooth. Raises `ConvergenceError` if no buoy rests.

    Parameters
    ----------
    problem_of : callable
        Degree -> the problem.
    degrees : sequence of int, or of one None
        To be tried, ascending; the last two are for what the others leave out.
    tolerance : float
        What all further degrees may change the power by, relative, at most.
    places : sequence of ndarray, shape (variable,)
        Tried in turn until a buoy rests.
    seen : callable, optional
        Is called with every buoy evaluated.
    expected : callable
        See `finer`.
    spread : callable, optional
        Problem and buoy -> margins of its limits for what is uncertain, (limit,).
    """
    problems: dict[int | None, Problem] = {}

    def of(degree: int | None) -> Problem:
        if degree not in problems:
            problems[degree] = problem_of(degree)
        return problems[degree]

    start, reasons = first_possible(of(degrees[0]), places)
    begin, known = start, None
    solved = degrees[: max(1, len(degrees) - FURTHER)]
    for i, degree in enumerate(solved):
        found = optimised(of(degree), begin, seen)

        def finer_at(point: Point, tried: Sequence[int | None] = degrees[i : i + 1 + FURTHER]) -> Finer:
            return finer(of, tried, point, expected)

        try:
            known = finer_at(found.point)
            sure = known.truncation is not None and max(map(abs, known.truncation)) <= tolerance
            if degree == solved[-1] or (sure and max(point.violation for point in known.points) <= tolerance):
                uncertain = partial(spread, of(degree)) if spread else None
                found, known = within_margins(of(degree), found, finer_at, uncertain, seen)
                break
        except IMPOSSIBLE as error:
            message = f"with more shell modes than to degree {degree} it has no stable rest shape: {error}"
            found, known = replace(found, accepted=False, message=message), None
            break
        begin = known.points[0]
    names = of(degree).limit_names
    margins = dict(zip(names, map(float, known.margins), strict=True)) if known else {}
    evaluations = sum(one.evaluations for one in problems.values())
    truncation = known.truncation if known else None
    return Converged(found, start, tuple(reasons), degree, truncation, margins, evaluations)
