"""Bending modes of a round floating plate by name: Zernike polynomials, with the elastic energy of Kirchhoff's plate.

Plate n m has the deflection w = R_n^m(r) cos(m theta), one at the edge, r in radii; n - m is even. Those of degrees 0
and 1 are heave and pitch. Each is orthogonal to all others over the plate, so that none carries momentum.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from scipy.special import jacobi

from vsb.engine.hydro.bodies.body_file import RoundPlate
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray

ROUND = 0.01
"""Difference of the lengths along x and y, in terms of them, beyond which a hull is not round."""
_GAUSS = 64  # points of the integrals of polynomials


class PlateMode(NamedTuple):
    """A vertical deflection of a round plate, symmetric about the plane of waves along x."""

    degree: int
    order: int
    radius: float  # [m]
    centre: FloatArray  # (xy) [m]

    @property
    def label(self) -> str:
        """Degree and order."""
        return f"Plate{self.degree}_{self.order}"

    @property
    def radial(self) -> Polynomial:
        """R_n^m(r) = r^m P_j^{(0, m)}(2 r^2 - 1), j = (n - m)/2."""
        inner = jacobi((self.degree - self.order) // 2, 0, self.order)
        return Polynomial(inner.coef[::-1])(Polynomial([-1.0, 0.0, 2.0])) * Polynomial.basis(self.order)

    def at(self, points: FloatArray) -> FloatArray:
        """Return the displacement of points, shape (..., xyz) -> (..., xyz) [-]."""
        x, y = np.moveaxis(points[..., :2] - self.centre, -1, 0) / self.radius
        moved = np.zeros(np.shape(points))
        moved[..., 2] = self.radial(np.hypot(x, y)) * np.cos(self.order * np.arctan2(y, x))
        return moved


def plate_modes(plate: RoundPlate | None, low: FloatArray, high: FloatArray) -> list[PlateMode]:
    """Return the modes of a plate of degrees 2 to the one asked for, by degree; none without a plate.

    Raises `ConfigError` if the hull between two corners (xyz) [m] is not round.
    """
    if plate is None:
        return []
    sides = (high - low)[:2]
    if np.ptp(sides) > ROUND * sides.max():
        raise ConfigError(f"modes.plate: received a hull of {sides[0]:g} x {sides[1]:g} m; needs a round one")
    middle, degrees = (high + low)[:2] / 2, range(2, plate.degree + 1)
    return [PlateMode(n, m, float(sides.mean() / 2), middle) for n in degrees for m in range(n % 2, n + 1, 2)]


def plate_stiffness(plate: RoundPlate | None, modes: Sequence[PlateMode]) -> FloatArray:
    """Return the bending stiffness of a plate with a free edge, shape (mode, mode) [N/m].

    D int [(k_r + k_t)^2 - 2 (1 - nu) (k_r k_t - k_rt^2)] dA of the curvatures k_r = w'', k_t = w'/r - m^2 w/r^2 and
    the twist k_rt = m (w'/r - w/r^2).
    """
    matrix = np.zeros((len(modes), len(modes)))
    if plate is None:
        return matrix
    r, weight = np.polynomial.legendre.leggauss(_GAUSS)
    r, weight = (r + 1) / 2, weight * (r + 1) / 4
    for m in {mode.order for mode in modes}:
        rows = [i for i, mode in enumerate(modes) if mode.order == m]
        radial = [modes[i].radial for i in rows]
        turned = np.array([w.deriv()(r) / r for w in radial])
        rise = np.array([w(r) / r**2 for w in radial])
        bent = np.array([w.deriv(2)(r) for w in radial])
        around, twist = turned - m**2 * rise, m * (turned - rise)
        energy = ((bent + around) * weight) @ (bent + around).T
        crossed = (bent * weight) @ around.T
        energy -= (1 - plate.poisson_ratio) * (crossed + crossed.T - 2 * (twist * weight) @ twist.T)
        matrix[np.ix_(rows, rows)] = (
            np.pi * (2 if m == 0 else 1) * plate.stiffness / modes[rows[0]].radius ** 2 * energy
        )
    return matrix
