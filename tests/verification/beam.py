"""Still-water stiffness of a barge that bends as an inextensible beam with plane sections: derived apart.

The water's potential is -rho g int z dV over the immersed body. A section whose reference point lies at z_G goes up by
w(s) and turns by w'; the axis keeps its length, so a volume at zeta above it is B (1 - zeta w'') ds dzeta at
z = z_G + w + zeta cos w'. To second order, with draft T,

    U = rho g B { int w^2/2 ds + T (T/2 + z_G) [ int w'^2/2 ds - (w w') at the ends ] },

which for w = s is Newman's stiffness of pitch. A hinge is the sum of its two halves, each with ends of its own.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

Shape = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Deflection and slope along the barge, [m], [-]."""


def free_free(n: int, length: float) -> Shape:
    """The n-th bending mode of a uniform free beam about amidships, one at the bow."""
    sign = 1.0 if n % 2 else -1.0
    middle = (n + 0.5) * np.pi / 2
    k = brentq(lambda q: np.tan(q) + sign * np.tanh(q), middle - 0.2, middle + 0.2) * 2 / length
    a, b = (np.cos, np.cosh) if n % 2 else (np.sin, np.sinh)
    da, db = (lambda q: -np.sin(q), np.sinh) if n % 2 else (np.cos, np.cosh)
    end = k * length / 2

    def shape(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (a(k * s) / a(end) + b(k * s) / b(end)) / 2, k * (da(k * s) / a(end) + db(k * s) / b(end)) / 2

    return shape


def stiffness(
    shape: Shape, ends: list[float], beam: float, draft: float, centre: float, specific_weight: float
) -> float:
    """Second derivative of the potential by the amplitude, N/m, over parts between neighbouring ends."""
    t, weight = np.polynomial.legendre.leggauss(60)
    total = 0.0
    for low, high in pairwise(ends):
        w, slope = shape((low + high) / 2 + (high - low) / 2 * t)
        size = (high - low) / 2 * weight
        at = np.array([low, high]) + np.array([1e-9, -1e-9]) * (high - low)
        edge, turn = shape(at)
        bracket = size @ slope**2 - 2 * (edge[1] * turn[1] - edge[0] * turn[0])
        total += size @ w**2 + draft * (draft / 2 + centre) * bracket
    return specific_weight * beam * total
