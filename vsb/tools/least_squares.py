"""Nonlinear least squares without full rank."""

from collections.abc import Callable

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from vsb.tools.arrays import FloatArray

_STEPS = 200  # of the least squares
_ENOUGH = 1e-3  # gain of a step, in terms of what is left, that ends them
_ROUND_OFF = 1e-13  # least damping of a step, in terms of the largest entry of the normal equations


def levenberg_marquardt(
    residual: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    x: FloatArray,
    enough: float = 0.0,
    gain: float = _ENOUGH,
) -> FloatArray:
    """Return where a sum of squares is least, or no more than enough, from a start; damped as Nielsen (1999) does.

    A step that gains less than a part `gain` of what is left ends the search. The normal equations are solved: with
    damping they stand a Jacobian without full rank.
    """
    r, j = residual(x), jacobian(x)
    damping, growth = 1e-3 * float((j**2).sum(axis=0).max()), 2.0
    for _ in range(_STEPS):
        slope, square = j.T @ r, j.T @ j
        damping = max(damping, _ROUND_OFF * float(np.diag(square).max()))
        step = -cho_solve(cho_factor(square + damping * np.eye(len(x))), slope)
        moved = residual(x + step)
        gained, promised = r @ r - moved @ moved, step @ (damping * step - slope)
        if gained > 0:
            x, r, j = x + step, moved, jacobian(x + step)
            damping, growth = damping * max(1 / 3, 1 - float(2 * gained / promised - 1) ** 3), 2.0
            if gained < gain * (r @ r) or r @ r <= enough:
                break
        elif promised < gain * (r @ r):
            break
        else:
            damping, growth = damping * growth, 2 * growth
    return x
