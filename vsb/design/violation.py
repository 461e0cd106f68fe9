"""A buoy within all limits, or the limits that leave none: what comes before a search.

Minimised is v = 1/2 sum r_i^2 with r = ln(1 + g) of the excesses g > 0 over limits, by the method of Gauss and Newton
between the bounds. Where it ends above 0 its gradient vanishes, but for what bounds hold back:

    sum_i r_i dr_i/dx = mu,    mu >= 0 at lower bounds, <= 0 at upper ones, 0 elsewhere.

With the weights r > 0 this is a certificate: to first order no other buoy exceeds these limits less, all together, and
the limits and bounds with a weight are those that conflict.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from vsb.design.evaluation import Evaluation
from vsb.design.problem import IMPOSSIBLE, Point, Problem
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
