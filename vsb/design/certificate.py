"""Whether a buoy is a best one: the first- and second-order conditions of a constrained optimum, computed anew.

At an optimum multipliers lambda >= 0 of limits and mu >= 0 of bounds exist with df/dx + lambda dg/dx + mu (+-e) = 0 and
lambda g = 0 (Karush, Kuhn and Tucker). They are found by nonnegative least squares from the gradients, whatever the
optimiser says. The Hessian of the Lagrangian, by differences of gradients, on the directions left free distinguishes
a maximum from a saddle, and names flat ridges: directions in which the whole range of a variable changes next to
nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import nnls

from vsb.design.problem import IMPOSSIBLE, Point, Problem
from vsb.tools.arrays import BoolArray, FloatArray

KKT, VIOLATION = 1e-6, 1e-8
"""What an optimum must meet: residual of the first-order conditions, excess over limits."""
ACTIVE = 1e-6
"""Distance from a limit, relative to it, or from a bound, relative to its range, within which it may be active."""
FLAT = 2e-3
"""Curvature below which going the whole range of a variable changes the objective by less than a thousandth."""
SHARE = 0.3
"""Component from which on a variable is named in a direction of unit length."""
STEP = 1e-4
"""Of a difference of gradients, in ranges."""


@dataclass(frozen=True)
class Multipliers:
    """Multipliers of limits and bounds at a point, and what is left of the first-order conditions."""

    limits: FloatArray  # shape (limit,)
    lower: FloatArray  # of lower bounds, shape (variable,)
    upper: FloatArray
    residual: float  # largest component of the gradient of the Lagrangian
    complementarity: float  # largest multiplier times distance from its limit

    @property
    def kkt(self) -> float:
        """Residual of the first-order conditions."""
        return max(self.residual, self.complementarity)

    @property
    def free(self) -> BoolArray:
        """Variables that no bound with a multiplier holds."""
        return np.asarray((self.lower <= 0) & (self.upper <= 0))


def multipliers(point: Point, active: float = ACTIVE) -> Multipliers:
    """Return the multipliers of a point by nonnegative least squares.

    Parameters
    ----------
    active : float
        Distance from a limit or bound within which it counts.
    """
    near = point.excess >= -active if len(point.place) else np.zeros(len(point.excess), dtype=bool)
    low, high = point.place <= active, point.place >= 1 - active
    eye = np.eye(len(point.place))
    columns = np.vstack([point.jacobian[near], -eye[low], eye[high]]).T
    found = nnls(columns, -point.slope)[0] if columns.shape[1] else np.zeros(0)
    rest = point.slope + columns @ found
    parts = np.split(found, np.cumsum([near.sum(), low.sum()]))
    whole = [np.zeros(len(mask)) for mask in (near, low, high)]
    for one, mask, part in zip(whole, (near, low, high), parts, strict=True):
        one[mask] = part
    limits, lower, upper = whole
    distances = np.concatenate([limits * point.excess, lower * point.place, upper * (1 - point.place)])
    left, gap = (float(np.abs(values).max(initial=0.0)) for values in (rest, distances))
    return Multipliers(limits, lower, upper, left, gap)


@dataclass(frozen=True)
class Curvature:
    """Hessian of the Lagrangian over free variables, and on the directions the active limits leave."""

    hessian: FloatArray  # shape (free, free)
    reduced: FloatArray  # eigenvalues, ascending
    directions: FloatArray  # of the eigenvalues, shape (variable, direction)

    def flat(self, variables: tuple[str, ...]) -> list[str]:
        """Return the flat directions in words: the variables that move in each, with their signs."""
        found = []
        for value, direction in zip(self.reduced, self.directions.T, strict=True):
            if abs(value) < FLAT:
                sign = np.sign(direction[np.abs(direction).argmax()])
                named = [
                    f"{'+' if sign * share > 0 else '-'}{name}"
                    for name, share in zip(variables, direction, strict=True)
                    if abs(share) > SHARE
                ]
                found.append(" ".join(named))
        return found

    @property
    def saddle(self) -> bool:
        """Whether some direction the limits leave gives more."""
        return bool((self.reduced < -FLAT).any())


def curvature(problem: Problem, point: Point, found: Multipliers) -> Curvature | None:
    """Return the curvature at a point; None where the buoys beside it do not rest.

    One evaluation per free variable, a step towards the middle of its range; none at a vertex.
    """
    free = np.flatnonzero(found.free)
    active = point.jacobian[found.limits > 0][:, free]
    left = null_space(active) if active.size else np.eye(len(free))
    if not left.shape[1]:  # a vertex: bounds and limits leave no direction
        return Curvature(np.zeros((len(free), len(free))), np.zeros(0), np.zeros((len(point.place), 0)))

    def slope(at: Point) -> FloatArray:
        return np.asarray(at.slope + found.limits @ at.jacobian)[free]

    here, rows = slope(point), []
    for i in free:
        step = STEP if point.place[i] < 0.5 else -STEP
        moved = point.place.copy()
        moved[i] += step
        try:
            rows.append((slope(problem.at(moved)) - here) / step)
        except IMPOSSIBLE:
            return None
    hessian = np.array(rows).reshape(len(free), len(free))
    hessian = 0.5 * (hessian + hessian.T)
    values, vectors = np.linalg.eigh(left.T @ hessian @ left)
    directions = np.zeros((len(point.place), left.shape[1]))
    directions[free] = left @ vectors
    return Curvature(hessian, values, directions)


def newton_step(point: Point, found: Multipliers, curved: Curvature) -> FloatArray:
    """Return the step to where the first-order conditions hold to second order; flat directions are left alone.

    Variables held by a bound go to it, limits that hold are met to first order, and what they leave free goes to where
    the gradient of the Lagrangian vanishes.
    """
    whole = np.where(found.lower > 0, -point.place, 0.0) + np.where(found.upper > 0, 1 - point.place, 0.0)
    free, on = np.flatnonzero(found.free), found.limits > 0
    rows, excess = point.jacobian[on][:, free], point.excess[on] + point.jacobian[on] @ whole
    step = np.linalg.lstsq(rows, -excess, rcond=None)[0] if rows.size else np.zeros(len(free))
    lagrangian = (point.slope + found.limits @ point.jacobian)[free] + curved.hessian @ step
    along = curved.directions[free]
    steep = np.abs(curved.reduced) > FLAT
    inverse = np.divide(1.0, curved.reduced, out=np.zeros_like(curved.reduced), where=steep)
    whole[free] = step - along @ (inverse * (along.T @ lagrangian))
    return whole


def bound_names(found: Multipliers, variables: tuple[str, ...]) -> Mapping[str, float]:
    """Return the multipliers of bounds that hold, by the name of the bound."""
    ends = (("lower bound of", found.lower), ("upper bound of", found.upper))
    return {
        f"{end} {name}": float(value)
        for end, values in ends
        for name, value in zip(variables, values, strict=True)
        if value > 0
    }
