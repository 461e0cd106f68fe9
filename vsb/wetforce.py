"""Force of the water on the instantaneous wet part of the deformed shell, compiled: the hot loop of body-exact motion.

With c = cos phi and s^2 = 1 - c^2 the deformed meridian is polynomial in c: height z(c), radius x = s X(c). So are all
integrands, and Gauss-Legendre quadrature on each wet interval is exact:

    Q_j = -2 pi int p X (s^2 z' h_j + T v_j) dc,   T = c X - s^2 X' = dx/dphi,

with the vertical shape v_j and the horizontal shape s h_j. `vsb.surface.DeformedShell` is the plain twin.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from vsb.compiled import njit
from vsb.modes import ModeBasis
from vsb.units import FloatArray


class Shape(NamedTuple):
    """What the compiled loops know of a shell and its basis."""

    radius: float
    centre_height: float
    degree: np.ndarray[Any, np.dtype[np.int64]]  # (dof,)
    radial: FloatArray  # V (dof,)
    meridional: FloatArray  # U (dof,)
    node: FloatArray  # Gauss-Legendre on [-1, 1] (point,)
    weight: FloatArray
    grid: FloatArray  # where the sign of z is looked up, c ascending from -1 to 1 (sample,)
    vertical: FloatArray  # vertical shapes there (dof, sample)
    slope: FloatArray  # their derivatives by c


@njit(cache=True)
def legendre(c: float, p: FloatArray, dp: FloatArray) -> None:
    """Fill P_n(c) and P_n'(c)."""
    p[0], dp[0] = 1.0, 0.0
    for n in range(1, len(p)):
        dp[n] = n * p[n - 1] + c * dp[n - 1]
        p[n] = ((2 * n - 1) * c * p[n - 1] - (n - 1) * p[n - 2]) / n if n > 1 else c


@njit(cache=True)
def _height(shape: Shape, q: FloatArray, c: float, p: FloatArray, dp: FloatArray) -> tuple[float, float]:
    """Height z of the meridian and its slope dz/dc."""
    legendre(c, p, dp)
    z, slope = shape.centre_height + shape.radius * c, shape.radius
    for j in range(len(q)):
        n, v, u = shape.degree[j], shape.radial[j], shape.meridional[j]
        z += q[j] * (v * c * p[n] + u * (1 - c * c) * dp[n])
        slope += q[j] * (v * (p[n] + c * dp[n]) - u * n * (n + 1) * p[n])
    return z, slope


@njit(cache=True)
def _zero(
    shape: Shape, q: FloatArray, low: float, high: float, below: bool, which: int, p: FloatArray, dp: FloatArray
) -> float:
    """Zero of z (which = 0) or of dz/dc (which = 1) in a bracket: Newton, halving where that leaves it.

    `below` is the sign at the lower end as the caller knows it: round-off here may see the other one.
    """
    c = 0.5 * (low + high)
    for _ in range(100):
        z, slope = _height(shape, q, c, p, dp)
        f = slope if which else z
        if (f < 0) == below:
            low = c
        else:
            high = c
        following = c - z / slope if which == 0 and slope != 0.0 else 0.5 * (low + high)
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - c) < 2e-16 or f == 0.0:
            return c
        c = following
    return c


@njit(cache=True)
def wet_intervals(shape: Shape, q: FloatArray, p: FloatArray, dp: FloatArray) -> FloatArray:
    """Return the edges of the wet intervals in c, ascending, an even number of them.

    Between two samples of one sign z may still dip through the surface: where its slopes say that |z| has a minimum
    there, that extremum is looked at.
    """
    count = len(shape.grid)
    z, slope = shape.centre_height + shape.radius * shape.grid, np.full(count, shape.radius)
    for j in range(len(q)):
        for i in range(count):
            z[i] += q[j] * shape.vertical[j, i]
            slope[i] += q[j] * shape.slope[j, i]
    edges = np.empty(2 * count + 2)
    found = 0
    if z[0] < 0:
        edges[found], found = -1.0, found + 1
    for i in range(count - 1):
        low, high, wet = shape.grid[i], shape.grid[i + 1], z[i] < 0
        if wet != (z[i + 1] < 0):
            edges[found], found = _zero(shape, q, low, high, wet, 0, p, dp), found + 1
        elif slope[i] * slope[i + 1] < 0 and (slope[i] > 0) == wet:
            middle = _zero(shape, q, low, high, not wet, 1, p, dp)
            if (_height(shape, q, middle, p, dp)[0] < 0) != wet:
                edges[found] = _zero(shape, q, low, middle, wet, 0, p, dp)
                edges[found + 1] = _zero(shape, q, middle, high, not wet, 0, p, dp)
                found += 2
    if z[count - 1] < 0:
        edges[found], found = 1.0, found + 1
    return edges[:found]


@njit(cache=True)
def meridian_point(
    shape: Shape, q: FloatArray, c: float, p: FloatArray, dp: FloatArray, h: FloatArray, v: FloatArray
) -> tuple[float, float, float, float]:
    """Return X, z, dz/dc and T = dx/dphi at a point, and fill the shapes h and v there."""
    s2 = 1 - c * c
    legendre(c, p, dp)
    z, slope = shape.centre_height + shape.radius * c, shape.radius
    x, t = shape.radius, shape.radius * c
    for j in range(len(q)):
        n, a, b = shape.degree[j], shape.radial[j], shape.meridional[j]
        lam = n * (n + 1)
        h[j] = a * p[n] - b * c * dp[n]
        v[j] = a * c * p[n] + b * s2 * dp[n]
        x += q[j] * h[j]
        z += q[j] * v[j]
        slope += q[j] * (a * (p[n] + c * dp[n]) - b * lam * p[n])
        t += q[j] * (a * (c * p[n] - s2 * dp[n]) + b * (dp[n] - lam * c * p[n]))
    return x, z, slope, t


@njit(cache=True)
def wet_force(shape: Shape, q: FloatArray, static: FloatArray, uniform: FloatArray) -> float:
    """Fill the generalized forces on the wet shell of the pressure -rho g z, per rho g, and of a uniform one, per Pa.

    Parameters
    ----------
    shape : Shape
    q : ndarray, shape (dof,) [m]
    static, uniform : ndarray, shape (dof,)
        Filled with the forces [m^3] and [m^2].

    Returns
    -------
    float
        int z dV over the displaced water [m^4]; static is its gradient, -rho g times it the potential energy.
    """
    order = shape.degree.max() + 1
    p, dp = np.empty(order), np.empty(order)
    h, v = np.empty(len(q)), np.empty(len(q))
    static[:], uniform[:], moment = 0.0, 0.0, 0.0
    edges = wet_intervals(shape, q, p, dp)
    for k in range(0, len(edges), 2):
        half, middle = 0.5 * (edges[k + 1] - edges[k]), 0.5 * (edges[k + 1] + edges[k])
        for i in range(len(shape.node)):
            c = middle + half * shape.node[i]
            s2 = 1 - c * c
            x, z, slope, t = meridian_point(shape, q, c, p, dp, h, v)
            w = 2 * np.pi * half * shape.weight[i] * x
            moment += 0.5 * w * s2 * x * z * slope
            for j in range(len(q)):
                flux = w * (s2 * slope * h[j] + t * v[j])
                static[j] += z * flux
                uniform[j] -= flux
    return moment


@njit(cache=True)
def _along(shape: Shape, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """`wet_force` at every instant of a motion."""
    static, uniform, moment = np.empty(q.shape), np.empty(q.shape), np.empty(len(q))
    for i in range(len(q)):
        moment[i] = wet_force(shape, q[i], static[i], uniform[i])
    return static, uniform, moment


@dataclass(frozen=True)
class WetShell:
    """Generalized forces of water on the wet part of a shell, for any heave and modal amplitudes."""

    basis: ModeBasis
    centre_height: float  # of the undisplaced sphere above still water [m]

    @cached_property
    def shape(self) -> Shape:
        """Tables of the compiled loops; 2 N + 3 points integrate polynomials of degree 4 N + 5 exactly."""
        basis, highest = self.basis, self.basis.highest_degree
        node, weight = np.polynomial.legendre.leggauss(2 * highest + 3)
        grid = -np.cos(np.linspace(0.0, np.pi, 6 * (highest + 1) + 1))
        phi = np.arccos(grid)
        v, u = basis.displacement(phi)
        degree = np.array(basis.degrees)[:, None]
        p = np.array([np.polynomial.legendre.Legendre.basis(n)(grid) for n in basis.degrees])
        dp = np.array([np.polynomial.legendre.Legendre.basis(n).deriv()(grid) for n in basis.degrees])
        radial = np.array([mode.radial for mode in basis.shapes])
        meridional = np.array([mode.meridional for mode in basis.shapes])
        slope = radial[:, None] * (p + grid * dp) - meridional[:, None] * degree * (degree + 1) * p
        return Shape(
            basis.shell.radius,
            self.centre_height,
            degree[:, 0],
            radial,
            meridional,
            node,
            weight,
            grid,
            v * np.cos(phi) - u * np.sin(phi),
            slope,
        )

    def forces(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return `wet_force` along a motion.

        Parameters
        ----------
        q : ndarray, shape (time, dof) [m]
            Heave and modal amplitudes.

        Returns
        -------
        static, uniform : ndarray, shape (time, dof) [m^3], [m^2]
        moment : ndarray, shape (time,) [m^4]
        """
        return _along(self.shape, np.ascontiguousarray(q, dtype=float))
