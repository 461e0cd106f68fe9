"""Modes of a body by name: hinges, free-free bending and polynomials, with their modal mass and stiffness.

Hinges, bending and polynomials move sections across a horizontal axis, which stay plane and normal to it: the
displacement at s along the axis and z is W(s) upward and -(z - z_0) W'(s) along the axis, z_0 the height sections turn
about. Their second order, by which still water is as stiff as it is, is that of hinges and beams (`hydrostatics`).

A round floating plate has Zernike polynomials with the elastic energy of Kirchhoff's plate: plate n m has the
deflection w = R_n^m(r) cos(m theta), one at the edge, r in radii; n - m is even. Those of degrees 0 and 1 are heave and
pitch. Each is orthogonal to all others over the plate, so that none carries momentum.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from scipy.optimize import brentq
from scipy.special import jacobi

from vsb.engine.hydro.bodies.body import Sections
from vsb.engine.hydro.bodies.body_file import Hinge, Line, ModeFamilies, RoundPlate
from vsb.engine.hydro.bodies.mesh import SAME
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray

AXES = {"x": 0, "y": 1}
_GAUSS = 64  # points of the integrals of polynomials' curvatures, exact


def free_free_root(n: int) -> float:
    """Return half of the n-th root b > 0 of cos b cosh b = 1: tan k + tanh k = 0 for odd n, tan k = tanh k for even.

    Both are sin and cos of k with e^{-2k}, so neither overflows nor cancels however high the mode.
    """
    sign = 1.0 if n % 2 else -1.0
    middle = (n + 0.5) * np.pi / 2
    return float(brentq(lambda k: np.sin(k) + sign * np.tanh(k) * np.cos(k), middle - 0.1, middle + 0.1, xtol=1e-15))


def free_free_shape(n: int, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the n-th bending mode of a free beam on -1 <= s <= 1, one at s = 1, and its derivative by s.

    (cos ks/cos k + cosh ks/cosh k)/2 for odd n, likewise with sines for even n, the hyperbolic part as
    e^{k(|s| - 1)} (1 +- e^{-2k|s|})/(1 +- e^{-2k}): no difference of large numbers in modes of any order.
    """
    k, even = free_free_root(n), n % 2 == 1
    u, sign = np.abs(s), 1.0 if n % 2 else -1.0
    grown = np.exp(k * (u - 1)) / (1 + sign * np.exp(-2 * k))
    with_sum, with_difference = grown * (1 + np.exp(-2 * k * u)), np.sign(s) * grown * -np.expm1(-2 * k * u)
    if even:
        return (np.cos(k * s) / np.cos(k) + with_sum) / 2, k * (with_difference - np.sin(k * s) / np.cos(k)) / 2
    return (np.sin(k * s) / np.sin(k) + with_difference) / 2, k * (np.cos(k * s) / np.sin(k) + with_sum) / 2


class Shape(NamedTuple):
    """W along an axis and its derivatives."""

    rise: FloatArray  # W [-]
    slope: FloatArray  # [1/m]
    bend: FloatArray  # [1/m^2]


class LineMode(NamedTuple):
    """A displacement of sections across an axis."""

    label: str
    axis: int  # 0 or 1
    height: float  # z_0 [m]
    shape: Callable[[FloatArray], Shape]  # coordinate [m] -> W
    smooth: bool = True  # no hinge

    def at(self, points: FloatArray) -> FloatArray:
        """Return the displacement of points, shape (..., xyz) -> (..., xyz) [-]."""
        w = self.shape(points[..., self.axis])
        moved = np.zeros(np.shape(points))
        moved[..., 2], moved[..., self.axis] = w.rise, -(points[..., 2] - self.height) * w.slope
        return moved

    def sections(self, points: FloatArray, axis: int) -> Sections:
        """Return the motion of the sections at points, shape (triangle, n, xyz)."""
        w, turned = self.shape(points[..., axis]), 1 - axis
        shift, turn, stretch, bend = (np.zeros(points.shape) for _ in Sections._fields)
        sign = -1.0 if axis == 0 else 1.0  # rising along x turns about -y, along y about x
        shift[..., 2], shift[..., axis] = w.rise, self.height * w.slope
        stretch[..., 2], stretch[..., axis] = w.slope, self.height * w.bend
        turn[..., turned], bend[..., turned] = sign * w.slope, sign * w.bend
        return Sections(shift, turn, stretch, bend)


class Hull(NamedTuple):
    """What modes by name are made for: the extent of a hull and the masses its sections carry."""

    low: FloatArray  # (xyz) [m]
    high: FloatArray  # (xyz) [m]
    centre_of_mass: FloatArray | None  # (xyz) [m]
    points: FloatArray  # (point, xyz): where the displaced water is [m]
    shares: FloatArray  # (point,): of it [-]

    @property
    def mass_height(self) -> float:
        """Height of the centre of mass [m]; raises `ConfigError` if it is not known."""
        if self.centre_of_mass is None:
            raise ConfigError(
                "centre_of_mass: received none, and the mesh is not closed above the water; needs it, because sections "
                "turn about it"
            )
        return float(self.centre_of_mass[2])

    @property
    def masses_at(self) -> FloatArray:
        """Places of the masses: sections carry that of their own displaced water, at the centre of mass's height."""
        at = self.points.copy()
        at[:, 2] = self.mass_height
        return at


def line_modes(families: ModeFamilies, hull: Hull) -> list[LineMode]:
    """Return the modes of a hull: bending or polynomials first, then hinges; none of them carries vertical momentum.

    Raises `ConfigError` if a hinge lies outside the hull, or the centre of mass is not known.
    """
    found = []
    if line := families.bending or families.polynomial:
        name = "Bending" if families.bending else "Polynomial"
        found = [_along(line, f"{name}{n}", n, hull) for n in range(1, line.count + 1)]
    several = len(families.hinge) > 1
    found += [_hinged(one, f"Hinge{i if several else ''}", hull) for i, one in enumerate(families.hinge, 1)]
    return found


def _along(line: Line, label: str, n: int, hull: Hull) -> LineMode:
    """The n-th free-free bending mode, or Legendre polynomial of degree n + 1, less its mean over the masses."""
    axis, polynomial = AXES[line.axis], Legendre.basis(n + 1)
    middle, half = (hull.high[axis] + hull.low[axis]) / 2, (hull.high[axis] - hull.low[axis]) / 2

    def whole(at: FloatArray) -> Shape:
        s = (at - middle) / half
        if not label.startswith("Bending"):
            return Shape(polynomial(s), polynomial.deriv()(s) / half, polynomial.deriv(2)(s) / half**2)
        rise, slope = free_free_shape(n, s)
        # the second derivative of `free_free_shape`: of its circular part it has the opposite sign
        k = free_free_root(n)
        circular = np.cos(k * s) / np.cos(k) if n % 2 else np.sin(k * s) / np.sin(k)
        return Shape(rise, slope / half, np.asarray(k**2 * (free_free_shape(n, s)[0] - circular)) / half**2)

    mean = float(hull.shares @ whole(hull.points[:, axis]).rise)

    def shape(at: FloatArray) -> Shape:
        found = whole(at)
        return found._replace(rise=found.rise - mean)

    return LineMode(label, axis, hull.mass_height, shape)


def _hinged(hinge: Hinge, label: str, hull: Hull) -> LineMode:
    """Straight pieces on either side of a hinge, both ends up by 1 m per unit, the hinge down: W = |s| (1 + d) - d."""
    axis, (at, height) = AXES[hinge.axis], hinge.at
    if not hull.low[axis] < at < hull.high[axis]:
        raise ConfigError(
            f"modes.hinge.at: received {hinge.axis} = {at:g} m, needs a place between the ends of the hull, "
            f"{hull.low[axis]:g} and {hull.high[axis]:g} m"
        )
    length = np.array([hull.low[axis] - at, hull.high[axis] - at])

    def unit(place: FloatArray) -> tuple[FloatArray, FloatArray]:
        side = np.sign(np.where(np.abs(place - at) <= SAME * (length[1] - length[0]), 0.0, place - at))
        first, second = 1 / length
        slope = np.where(side < 0, first, np.where(side > 0, second, (first + second) / 2))  # corners at the hinge
        return (place - at) * slope, slope

    mean = float(hull.shares @ unit(hull.points[:, axis])[0])
    down = mean / (1 - mean)  # without momentum: (1 + d) mean = d

    def shape(place: FloatArray) -> Shape:
        rise, slope = unit(place)
        return Shape((1 + down) * rise - down, (1 + down) * slope, np.zeros_like(slope))

    return LineMode(label, axis, height, shape, smooth=False)


def structural_stiffness(families: ModeFamilies, hull: Hull, modes: Sequence[LineMode]) -> FloatArray:
    """Return the stiffness of bending and of hinges, shape (mode, mode) [N/m].

    EI int W_i'' W_j'' ds: of free-free modes EI (2k/L)^4 L/4. A hinge's is by the angle between its pieces.
    """
    line = families.bending or families.polynomial
    matrix = np.zeros((len(modes), len(modes)))
    count = line.count if line else 0
    if line and line.stiffness:
        axis = AXES[line.axis]
        length = float(hull.high[axis] - hull.low[axis])
        if families.bending:
            curved = np.diag([(2 * free_free_root(n) / length) ** 4 * length / 4 for n in range(1, count + 1)])
        else:
            s, weight = np.polynomial.legendre.leggauss(_GAUSS)
            bent = np.array([Legendre.basis(n + 1).deriv(2)(s) for n in range(1, count + 1)])
            curved = (2 / length) ** 3 * (bent * weight) @ bent.T
        matrix[:count, :count] = line.stiffness * curved
    for k, hinge in enumerate(families.hinge, count):
        ends = np.array([hull.low[AXES[hinge.axis]], hull.high[AXES[hinge.axis]]])
        angle = float(np.diff(modes[k].shape(ends).slope)[0])
        matrix[k, k] = hinge.stiffness * angle**2
    return matrix


ROUND = 0.01
"""Difference of the lengths along x and y, in terms of them, beyond which a hull is not round."""
_GAUSS_plates = 64  # points of the integrals of polynomials


# A round plate


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
    r, weight = np.polynomial.legendre.leggauss(_GAUSS_plates)
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
