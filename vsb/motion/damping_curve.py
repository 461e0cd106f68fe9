"""Mean power of many seas over the damper: a table for all of them at once, and the best damper of each.

In the logarithm u of a damper the power of each frequency is 1/(R + |Z| cosh(u - ln |Z|)) but for a factor (see
`vsb.motion.port`), which is analytic within pi/2 of the real axis. Polynomials through few entries of a fine table are
therefore exact to round-off, so that the best damper of each of thousands of seas costs no more than the table.
"""

from typing import NamedTuple

import numpy as np

from vsb.motion.port import Port
from vsb.tools.arrays import FloatArray

STEP = 0.05
"""Step of the logarithm of the dampers of a table: fine enough to miss no maximum, see `vsb.motion.tuning.LOG_STEP`."""
NEIGHBOURS = 5
"""Entries on either side of the best one that the polynomial goes through: its error is about 1e-13."""
NEWTON = 6
"""Newton's steps to the maximum of the polynomial: three would do."""
FLAT = 1e-9
"""Curvature of a polynomial, in its value, that is numerical error: a straight line has no maximum."""


class Take(NamedTuple):
    """What a damper takes of each sea."""

    damping: FloatArray  # (sea,) [N s/m]
    power: FloatArray  # (sea,) [W]


def dampers(port: Port) -> FloatArray:
    """Return dampers among which the best of any sea lies, evenly spread in logarithm, shape (damper,) [N s/m].

    Notes
    -----
    No sea's best damper is beyond the best ones |Z| of single waves; the table goes on for the polynomials' sake.
    """
    sizes = np.log(port.best_damping)
    low, high = float(sizes.min()) - (NEIGHBOURS + 1) * STEP, float(sizes.max()) + (NEIGHBOURS + 1) * STEP
    return np.asarray(np.exp(low + STEP * np.arange(int(np.ceil((high - low) / STEP)) + 1)))


def best_of_table(damping: FloatArray, table: FloatArray) -> Take:
    """Return the damper that takes most in each sea.

    Parameters
    ----------
    damping : ndarray, shape (damper,) [N s/m]
        See `dampers`.
    table : ndarray, shape (damper, sea) [W]
    """
    near = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    at = np.clip(table.argmax(axis=0), NEIGHBOURS, len(damping) - NEIGHBOURS - 1)
    values = table[at + near[:, None], np.arange(table.shape[1])]
    # Powers of the distance in steps, highest first, as polyval wants them.
    polynomial = np.linalg.solve(np.vander(near / NEIGHBOURS), values)
    x = _highest(polynomial)
    step = np.log(damping[1] / damping[0])
    return Take(damping[at] * np.exp(NEIGHBOURS * step * x), np.polyval(polynomial, x))


def _highest(polynomial: FloatArray) -> FloatArray:
    """Where polynomials, one a column, are highest near 0."""
    degree = np.arange(len(polynomial) - 1, -1, -1)[:, None]
    slope = (polynomial * degree)[:-1]
    curvature = (slope * (degree[:-1] - 1))[:-1]
    flat = -FLAT * np.abs(polynomial[-1])
    x = np.zeros(polynomial.shape[1])
    for _ in range(NEWTON):
        bend = np.polyval(curvature, x)
        move = np.divide(-np.polyval(slope, x), bend, out=np.zeros_like(x), where=bend < flat)
        x = np.clip(x + move, -1.0 / NEIGHBOURS, 1.0 / NEIGHBOURS)
    return x
