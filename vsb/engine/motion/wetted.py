"""Force of still water and waves on the instantaneous wet shell, compiled: the hot loop of body-exact motion.

With c = cos phi and s^2 = 1 - c^2 the deformed meridian is polynomial in c: height z(c), radius x = s X(c). So are all
integrands, and Gauss-Legendre quadrature on each wet interval is exact:

    Q_j = -2 pi int p X (s^2 z' h_j + T v_j) dc,   T = c X - s^2 X' = dx/dphi,

with the vertical shape v_j and the horizontal shape s h_j. All are kept as Chebyshev series; of the meridian at rest,
x = sum a_k sin k phi and z = sum b_k cos k phi, these are X = sum a_k U_{k-1}(c), z = sum b_k T_k(c),
z' = sum k b_k U_{k-1}(c) and T = sum k a_k T_k(c). Sums over points come before those over shapes, so that every loop
runs along one of the two. A meridian at rest whose curvature jumps has far more terms than the shapes: its part of z is
tabulated where the sign is looked up, and a wet interval has as many points as its length in phi needs.
`vsb.engine.shell.deformed.DeformedShell` computes the same without compilation.

The axisymmetric part of long-crested waves, elevation Z(x, t) = Re sum a J_0(kx) exp(-i omega t) at radius x, acts by

    p = -rho g z + rho g Re sum a J_0(kx) cosh k(z + d)/cosh kd exp(-i omega t)    below still water,
    p = rho g (Z - z)                                                              between still water and the wave,

zero on the wave itself. To first order this is the linear Froude-Krylov force and hydrostatic stiffness. Quadrature is
split at still water, where p has a kink, and so keeps its accuracy.

Both are series whose coefficients are sums over the components, functions of time alone: points cost the same in any
sea. Elevation is a Chebyshev series in x^2, up to X = 2 r, by Neumann's addition theorem

    J_0(kx) = sum_n e_n (-1)^n J_n(kX/2)^2 T_n(2 x^2/X^2 - 1),    e_0 = 1, e_n = 2 beyond.

J_0(kx) exp(kz) is harmonic: about a point of the axis at depth D it is sum_l w_l (rho/D)^l P_l(cos theta) with the
weights of a Poisson distribution, w_l = exp(-kD) (kD)^l/l!. The deeper that point, the less do terms exceed their sum:
at the surface by exp(k (rho - D)), about exp(k x^2/(2 D)). Coefficients of many components are sampled in time
(`vsb.engine.waves.sampling`), those of few are summed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import takewhile
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.special import gammaln, jv

from vsb.engine.shell.meridian import ClosedMeridian, RestMeridian, curve
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.waves.sampling import Signals, signals, signals_at
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import wavenumber
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray
from vsb.tools.compiled import assign, njit

REORDERED = {"reassoc", "contract", "nsz"}
"""What the compiler may do to sums: add in any order, fuse; never assume that there are no NaN."""


RULES = (24, 32, 48, 64, 96, 128, 192)
"""Points of rules for wet intervals, where the exact one has more."""
SPARE_POINTS = 16
"""What a rule has beyond a quarter of the phase of its integrand: then it is off by round-off alone."""
ARC_TERMS = 96
"""Terms that stand for a meridian whose curvature jumps: they follow it to 1e-5 of its radius, its volume to 1e-7."""


class Shape(NamedTuple):
    """What the compiled loops know of a shell and its basis: Chebyshev coefficients of X, z, z' and T."""

    radius: float
    at_rest: FloatArray  # of the undeformed meridian (4, order) [m]
    series: FloatArray  # of the shapes, X: h_j, z: v_j (dof, 4, few)
    counts: IntArray  # points of rules of Gauss and Legendre on [-1, 1], ascending; the last is exact (rule,)
    nodes: FloatArray  # (rule, point)
    weights: FloatArray
    grid: FloatArray  # where the sign of z is looked up, c ascending from -1 to 1 (sample,)
    on_grid: FloatArray  # Chebyshev polynomials there (few, sample)
    rest_on_grid: FloatArray  # X, z and z' of the undeformed meridian there (3, sample)


@njit(cache=True)
def meridian_series(shape: Shape, q: FloatArray) -> FloatArray:
    """Return the Chebyshev coefficients of X, z, z' and T of a deformed shell, shape (4, order)."""
    out = shape.at_rest.copy()
    for j in range(len(q)):
        for i in range(4):
            for k in range(shape.series.shape[2]):
                out[i, k] += q[j] * shape.series[j, i, k]
    return out


@njit(cache=True, fastmath=REORDERED)
def chebyshev_table(c: FloatArray, order: int) -> FloatArray:
    """Return T_k(c), k < order, shape (order, point)."""
    table = np.empty((order, len(c)))
    for i in range(len(c)):
        table[0, i], table[1, i] = 1.0, c[i]
    for k in range(2, order):
        for i in range(len(c)):
            table[k, i] = 2 * c[i] * table[k - 1, i] - table[k - 2, i]
    return table


@njit(cache=True, fastmath=REORDERED)
def values(series: FloatArray, table: FloatArray) -> FloatArray:
    """Return series @ table, shape (series, point)."""
    out = np.zeros((len(series), table.shape[1]))
    for i in range(len(series)):
        for k in range(len(table)):
            for j in range(table.shape[1]):
                out[i, j] += series[i, k] * table[k, j]
    return out


@njit(cache=True, fastmath=REORDERED)
def values_on_grid(shape: Shape, series: FloatArray) -> FloatArray:
    """Return X, z and z' of a deformed shell where the sign of z is looked up, shape (3, sample)."""
    out = shape.rest_on_grid.copy()
    for i in range(3):
        for k in range(len(shape.on_grid)):
            change = series[i, k] - shape.at_rest[i, k]
            for j in range(out.shape[1]):
                out[i, j] += change * shape.on_grid[k, j]
    return out


@njit(cache=True)
def rule(shape: Shape, low: float, high: float) -> int:
    """Return which rule integrates over an interval of c to round-off.

    In phi the integrand is a trigonometric polynomial whose order is twice the points of the exact rule. Over an
    interval Gauss' rule converges faster than exponentially once it has a point for every four radians of the phase.
    """
    phase = 2 * shape.counts[-1] * (np.arccos(max(low, -1.0)) - np.arccos(min(high, 1.0)))
    for i in range(len(shape.counts) - 1):
        if shape.counts[i] >= phase / 4 + SPARE_POINTS:
            return i
    return len(shape.counts) - 1


@njit(cache=True)
def value(series: FloatArray, c: float) -> float:
    """Return a Chebyshev series at a point, by Clenshaw's recurrence."""
    one, two = 0.0, 0.0
    for k in range(len(series) - 1, 0, -1):
        one, two = series[k] + 2 * c * one - two, one
    return float(series[0] + c * one - two)


@njit(cache=True)
def _zero(f: FloatArray, slope: FloatArray, low: float, high: float, start: float, below: bool) -> float:
    """Zero of a series in a bracket: Newton, halving where that leaves it.

    `below` is the sign at the lower end as the caller knows it: round-off here may see the other one.
    """
    c = start if low < start < high else 0.5 * (low + high)
    for _ in range(100):
        here, rise = value(f, c), value(slope, c)
        if (here < 0) == below:
            low = c
        else:
            high = c
        following = c - here / rise if rise != 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - c) < 1e-15 or here == 0.0:
            return c
        c = following
    return c


@njit(cache=True)
def _extremum(slope: FloatArray, low: float, high: float, below: bool) -> float:
    """Zero of z' in a bracket, by halving."""
    while high - low > 1e-15:
        c = 0.5 * (low + high)
        if not low < c < high:
            break
        if (value(slope, c) < 0) == below:
            low = c
        else:
            high = c
    return 0.5 * (low + high)


@njit(cache=True)
def _secant(low: float, high: float, f_low: float, f_high: float) -> float:
    """Where a straight line crosses zero."""
    return low + (high - low) * f_low / (f_low - f_high) if f_low != f_high else low


@njit(cache=True)
def wet_intervals(shape: Shape, series: FloatArray) -> FloatArray:
    """Return the edges of the wet intervals in c, ascending, an even number of them.

    Between two samples of one sign z may still dip through the surface: where its slopes say that |z| has a minimum
    there, that extremum is looked at.
    """
    z, slope = series[1], series[2]
    count, at = len(shape.grid), values_on_grid(shape, series)[1:]
    edges = np.empty(2 * count + 2)
    found = 0
    if at[0, 0] < 0:
        edges[found], found = -1.0, found + 1
    for i in range(count - 1):
        low, high, wet = shape.grid[i], shape.grid[i + 1], at[0, i] < 0
        if wet != (at[0, i + 1] < 0):
            start = _secant(low, high, at[0, i], at[0, i + 1])
            edges[found], found = _zero(z, slope, low, high, start, wet), found + 1
        elif at[1, i] * at[1, i + 1] < 0 and (at[1, i] > 0) == wet:
            middle = _extremum(slope, low, high, not wet)
            if (value(z, middle) < 0) != wet:
                edges[found] = _zero(z, slope, low, middle, low, wet)
                edges[found + 1] = _zero(z, slope, middle, high, low, not wet)
                found += 2
    if at[0, count - 1] < 0:
        edges[found], found = 1.0, found + 1
    return edges[:found]


@njit(cache=True, fastmath=REORDERED)
def add_force(shape: Shape, table: FloatArray, pressure: FloatArray, meridian: FloatArray, out: FloatArray) -> None:
    """Add sum_i pressure_i (s^2 z' h_j + T v_j), sums over points first; pressure holds the weights."""
    c = table[1]
    for k in range(shape.series.shape[2]):
        level, upright = 0.0, 0.0
        for i in range(len(c)):
            weighed = pressure[i] * table[k, i]
            level += weighed * (1 - c[i] * c[i]) * meridian[2, i]
            upright += weighed * meridian[3, i]
        for j in range(len(out)):
            out[j] += level * shape.series[j, 0, k] + upright * shape.series[j, 1, k]


@njit(cache=True)
def points(shape: Shape, low: float, high: float, order: int) -> tuple[FloatArray, FloatArray]:
    """Return -2 pi times the weights of the points of an interval of c, and Chebyshev polynomials there."""
    i, half, middle = rule(shape, low, high), 0.5 * (high - low), 0.5 * (high + low)
    flux, c = np.empty(shape.counts[i]), np.empty(shape.counts[i])
    for j in range(len(c)):
        flux[j], c[j] = -2 * np.pi * half * shape.weights[i, j], middle + half * shape.nodes[i, j]
    return flux, chebyshev_table(c, order)


@njit(cache=True)
def wet_force(shape: Shape, q: FloatArray, static: FloatArray, uniform: FloatArray) -> float:
    """Fill the generalized forces on the wet shell of the pressure -rho g z, per rho g, and of a uniform one, per Pa.

    Of q (dof,) [m] they have shape (dof,) [m^3] and [m^2]. Returns int z dV over the displaced water [m^4]: static is
    its gradient, -rho g times it the potential energy.
    """
    for j in range(len(q)):
        static[j], uniform[j] = 0.0, 0.0
    moment, series = 0.0, meridian_series(shape, q)
    edges = wet_intervals(shape, series)
    for k in range(0, len(edges), 2):
        flux, table = points(shape, edges[k], edges[k + 1], series.shape[1])
        meridian = values(series, table)
        x, z, slope = meridian[0], meridian[1], meridian[2]
        for i in range(len(flux)):
            flux[i] *= x[i]
            moment -= 0.5 * flux[i] * (1 - table[1, i] ** 2) * x[i] * z[i] * slope[i]
        add_force(shape, table, flux, meridian, uniform)
        for i in range(len(flux)):
            flux[i] *= -z[i]
        add_force(shape, table, flux, meridian, static)
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
    centre_height: float  # of the undisplaced shell above still water [m]
    _last: list[tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray]]] = field(
        default_factory=list, init=False, repr=False, compare=False
    )  # the motion last asked for, and its forces: energies and forces are both of the same motion

    @cached_property
    def shape(self) -> Shape:
        """Tables of the compiled loops; as many points as integrate their polynomials exactly."""
        shell, rest = self.basis.shell, _series(self.basis.shell.meridian)
        highest = self.basis.highest_degree + len(rest[1]) - 2
        counts = np.array([*takewhile(lambda n: n < 2 * highest + 3, RULES), 2 * highest + 3])
        nodes, weights = np.zeros((2, len(counts), counts[-1]))
        for i, n in enumerate(counts):
            nodes[i, :n], weights[i, :n] = np.polynomial.legendre.leggauss(n)
        grid = -np.cos(np.linspace(0.0, np.pi, 6 * (highest + 1) + 1))
        at_rest, series = _at_rest(rest, highest + 2), _of_shapes(self.basis)
        at_rest[1, 0] += self.centre_height
        table = np.ascontiguousarray(chebyshev.chebvander(grid, highest + 1).T)
        on_grid = table[: series.shape[2]].copy()
        return Shape(shell.radius, at_rest, series, counts, nodes, weights, grid, on_grid, at_rest[:3] @ table)

    def forces(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return `wet_force` along a motion q (time, dof) [m], heave and modal amplitudes.

        Static and uniform have shape (time, dof) [m^3], [m^2], the moment (time,) [m^4].
        """
        q = np.array(q, dtype=float, order="C")  # read-only arrays would compile the loop once more
        if not (self._last and np.array_equal(self._last[0][0], q)):
            self._last[:] = [(q, _along(self.shape, q))]
        return self._last[0][1]


def _series(rest: ClosedMeridian) -> tuple[Sequence[float], Sequence[float]]:
    """Terms a_1, a_2, ... and b_0, b_1, ... of a meridian at rest [m]; of one with junctions the first `ARC_TERMS`.

    By the discrete orthogonality of sines and cosines at many midpoints.
    """
    if isinstance(rest, RestMeridian):
        return rest.radial, rest.axial
    count = 64 * ARC_TERMS
    phi = np.pi * (np.arange(count) + 0.5) / count
    angles, at = np.outer(np.arange(ARC_TERMS), phi), curve(rest, phi)
    radial, axial = 2 / count * np.sin(angles) @ at.x, 2 / count * np.cos(angles) @ at.z
    axial[0] /= 2
    return radial[1:].tolist(), axial.tolist()


def _at_rest(rest: tuple[Sequence[float], Sequence[float]], terms: int) -> FloatArray:
    """Chebyshev coefficients of X, z, z' and T of a meridian at rest by its terms, shape (4, term) [m]."""
    out = np.zeros((4, terms))
    radial, axial = rest
    for k, a in enumerate(radial, 1):
        out[0] += a * _second_kind(k - 1, terms)
        out[3, k] += k * a
    for k, b in enumerate(axial):
        out[1, k] += b
        out[2] += k * b * _second_kind(k - 1, terms)
    return out


def _second_kind(degree: int, terms: int) -> FloatArray:
    """U_n in terms of T_k, shape (term,): 2 T_n + 2 T_{n-2} + ..., the last T_0 once; zero of n = -1."""
    out = np.zeros(terms)
    if degree >= 0:
        out[degree::-2] = 2.0
        out[0] /= 2
    return out


def _of_shapes(basis: ModeBasis) -> FloatArray:
    """Chebyshev coefficients of h_j, v_j, dv_j/dc and c h_j - s^2 dh_j/dc of each shape, (dof, 4, term)."""
    order = basis.highest_degree + 2
    c = chebyshev.chebpts1(order)
    single = [_displacement(c, n, 1.0, 0.0) for n in range(order - 1)]
    single += [_displacement(c, n, 0.0, 1.0) for n in range(1, order - 1)]
    to_series = np.linalg.inv(chebyshev.chebvander(c, order - 1)).T
    return np.asarray(np.einsum("id,dpk->ipk", basis.displacements, np.array(single)) @ to_series)


def _displacement(c: FloatArray, n: int, radial: float, meridional: float) -> list[FloatArray]:
    """h, v, dv/dc and c h - s^2 dh/dc of a radial and a meridional displacement of degree n."""
    legendre = np.polynomial.legendre.Legendre.basis(n)
    p, dp, s2, lam = legendre(c), legendre.deriv()(c), 1 - c * c, n * (n + 1)
    turn = radial * (c * p - s2 * dp) + meridional * (dp - lam * c * p)
    return [
        radial * p - meridional * c * dp,
        radial * c * p + meridional * s2 * dp,
        radial * (p + c * dp) - meridional * lam * p,
        turn,
    ]


# waves: nonlinear Froude-Krylov force ---------------------------------------------------------------------------------


REACH = 2.0
"""X/r: no shell reaches farther from the axis than so many of its radii."""
EXCEEDING = 6.0
"""Exponent by which terms of the shortest waves' pressure exceed their sum at 1.2 radii, but in shallow water."""
LEFT_OUT = -37.0
"""Exponent of what is left out of a series: round-off."""
DEEPEST = 1000.0
"""Largest k D: weights must not overflow."""


class Incident(NamedTuple):
    """Regular components of a sea, the longest first, and the series of their elevation and pressure."""

    wavenumber: FloatArray  # (component,) [1/m]
    omega: FloatArray  # [rad/s]
    amplitude: ComplexArray  # [m]
    bottom: FloatArray  # exp(-2kd) (component,), zero in deep water
    radius: float  # r [m]
    depth: float  # D [m]
    weights: FloatArray  # w of the pressure (component, l)
    signals: Signals  # coefficients of the elevation, then of the pressure [m]


def incident(sea: Sea, depth: float, gravity: float, radius: float) -> Incident:
    """Return the incident waves of a sea, for a shell that never reaches beyond `REACH` radii."""
    order = np.argsort(sea.omega, kind="stable")
    omega, amplitude = sea.omega[order], sea.amplitude[order]
    k = np.array([wavenumber(w, depth, gravity) for w in omega])
    bottom = np.exp(-2 * k * depth) if np.isfinite(depth) else np.zeros_like(k)
    shortest, height = float(k.max(initial=0.0)), float(np.sqrt(8 * np.sum(np.abs(amplitude) ** 2)))
    deep = max(2 * radius, height, shortest * (1.2 * radius) ** 2 / (2 * EXCEEDING))
    deep = min(deep, depth, DEEPEST / shortest if shortest else np.inf)
    count = _terms(shortest * np.hypot(deep, REACH * radius), -shortest * deep)
    factors = np.hstack([np.exp(-k * deep / 2)[:, None], (k * deep)[:, None] / np.arange(1.0, count)])
    weights = np.exp(-k * deep / 2)[:, None] * np.cumprod(factors, axis=1)  # products keep all digits
    down, up = 1 / (1 + bottom), np.exp(-2 * k * (depth - deep)) / (1 + bottom)
    pressure = weights * (down[:, None] + np.outer(up, (-1.0) ** np.arange(weights.shape[1])))
    n = np.arange(_terms(shortest * REACH * radius / 4, 0.5 * LEFT_OUT))
    elevation = np.where(n, 2, 1) * (-1.0) ** n * jv(n, k[:, None] * REACH * radius / 2) ** 2
    phasors = amplitude[:, None] * np.hstack([elevation, pressure])
    return Incident(k, omega, amplitude, bottom, radius, deep, weights, signals(omega, phasors))


def _terms(reach: float, offset: float) -> int:
    """Terms of exp(offset) sum_l reach^l/l! down to round-off, at least 4."""
    l = np.arange(4.0, 5000.0)  # noqa: E741
    left = offset + l * np.log(max(reach, 1e-300)) - gammaln(l + 1)
    return int(l[np.argmax((left < LEFT_OUT) & (l > reach))])


def scaled(waves: Incident, share: float) -> Incident:
    """Return a share of the waves."""
    kept = waves.signals
    own = kept._replace(phasors=share * kept.phasors, samples=share * kept.samples)
    return waves._replace(amplitude=share * waves.amplitude, signals=own)


class Moment(NamedTuple):
    """A sea at one instant."""

    elevation: FloatArray  # coefficients of T_n(2 x^2/X^2 - 1) (n,) [m]
    pressure: FloatArray  # of solid harmonics over D^l about a point of the axis (l,) [m]
    centre: float  # height of that point [m]


@njit(cache=True)
def moment(waves: Incident, time: float, height: float) -> Moment:
    """Return the sea at one instant, for a shell of a mean height [m].

    A shell deeper than D, as no floating one is but in a trial, has its pressure expanded D below it, by components.
    """
    found, count = signals_at(waves.signals, time), waves.weights.shape[1]
    elevation, pressure = found[: len(found) - count], found[len(found) - count :]
    lowered = min(height + waves.depth, 0.0)
    if lowered < 0:
        for i in range(count):
            pressure[i] = 0.0
        for j in range(len(waves.omega)):
            k, bottom, angle = waves.wavenumber[j], waves.bottom[j], waves.omega[j] * time
            head = waves.amplitude[j].real * np.cos(angle) + waves.amplitude[j].imag * np.sin(angle)
            down, up = np.exp(k * lowered) / (1 + bottom), 0.0
            if bottom > 0:
                up = np.exp(np.log(bottom) + k * (2 * waves.depth - lowered)) / (1 + bottom)
            for i in range(count):
                pressure[i] += head * waves.weights[j, i] * (down + up if i % 2 == 0 else down - up)
    return Moment(elevation, pressure, lowered - waves.depth)


@njit(cache=True)
def elevation_at(waves: Incident, now: Moment, x2: float) -> float:
    """Return the elevation at a squared radius [m], beyond X that at X, by Clenshaw's recurrence."""
    return value(now.elevation, min(2 * x2 / (REACH * waves.radius) ** 2 - 1, 1.0))


@njit(cache=True, fastmath=REORDERED)
def dynamic_head(waves: Incident, now: Moment, x2: FloatArray, z: FloatArray) -> FloatArray:
    """Return the dynamic pressure head at squared radii and heights below still water, shape (point,) [m]."""
    past, here, out = np.zeros(len(z)), np.ones(len(z)), np.zeros(len(z))
    height, square = np.empty(len(z)), np.empty(len(z))
    for i in range(len(z)):
        height[i] = (z[i] - now.centre) / waves.depth
        square[i] = x2[i] / waves.depth**2 + height[i] * height[i]
    for n in range(len(now.pressure)):
        a, b = (2 * n + 1) / (n + 1), n / (n + 1)
        for i in range(len(z)):
            out[i] += now.pressure[n] * here[i]
            following = a * height[i] * here[i] - b * square[i] * past[i]
            past[i], here[i] = here[i], following
    return out


@njit(cache=True)
def _submergence(series: FloatArray, waves: Incident, now: Moment, c: float) -> float:
    """Height of a point above the wave, negative under it [m]."""
    x2 = max(1 - c * c, 0.0) * value(series[0], c) ** 2
    return value(series[1], c) - elevation_at(waves, now, x2)


@njit(cache=True)
def _edges(shape: Shape, series: FloatArray, waves: Incident, now: Moment) -> FloatArray:
    """Points in c, ascending from -1 to 1, where the shell meets still water or the wave."""
    still, grid = wet_intervals(shape, series), shape.grid
    count, at = len(grid), values_on_grid(shape, series)[:2]
    edges = np.empty(len(still) + count + 1)
    assign(edges[: len(still)], still)
    edges[len(still)], edges[len(still) + 1] = -1.0, 1.0
    found, highest = len(still) + 2, 0.0
    for i in range(len(now.elevation)):
        highest += abs(now.elevation[i])
    f_low, low = 0.0, -1.0
    for i in range(count):
        f, c = at[1, i], grid[i]
        if abs(f) <= highest:
            f -= elevation_at(waves, now, max(1 - c * c, 0.0) * at[0, i] ** 2)
        if i and (f_low < 0) != (f < 0):
            edges[found] = _crossing(series, waves, now, low, c, f_low, f)
            found += 1
        low, f_low = c, f
    return in_order(edges[:found])


@njit(cache=True)
def in_order(values: FloatArray) -> FloatArray:
    """Sort some values in place, by insertion: `np.sort` takes numba longer to compile."""
    for i in range(1, len(values)):
        value, k = values[i], i
        while k > 0 and values[k - 1] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value
    return values


@njit(cache=True)
def _crossing(series: FloatArray, waves: Incident, now: Moment, a: float, b: float, f_a: float, f_b: float) -> float:
    """Where the shell crosses the wave, in a bracket: regula falsi with the Illinois rule."""
    side = 0
    for _ in range(60):
        c = (a * f_b - b * f_a) / (f_b - f_a)
        f = _submergence(series, waves, now, c)
        if abs(f) < 1e-14 or b - a < 1e-15:
            return c
        if (f < 0) == (f_b < 0):
            b, f_b = c, f
            f_a = f_a / 2 if side == -1 else f_a
            side = -1
        else:
            a, f_a = c, f
            f_b = f_b / 2 if side == 1 else f_b
            side = 1
    return c


@njit(cache=True)
def wave_force(shape: Shape, q: FloatArray, waves: Incident, time: float, out: FloatArray) -> None:
    """Fill the generalized force per rho g of water and waves on the instantaneous wet shell, shape (dof,) [m^3].

    Q_j = -2 pi int p X (s^2 z' h_j + T v_j) dc, notation of `vsb.engine.motion.wetted`.
    """
    series = meridian_series(shape, q)
    now = moment(waves, time, series[1, 0])
    for j in range(len(out)):
        out[j] = 0.0
    edges = _edges(shape, series, waves, now)
    for k in range(len(edges) - 1):
        half, middle = 0.5 * (edges[k + 1] - edges[k]), 0.5 * (edges[k + 1] + edges[k])
        if half < 1e-14 or _submergence(series, waves, now, middle) > 0:
            continue
        flux, table = points(shape, edges[k], edges[k + 1], series.shape[1])
        meridian, x2, below = values(series, table), np.empty(len(flux)), value(series[1], middle) < 0
        x, z = meridian[0], meridian[1]
        for i in range(len(flux)):
            x2[i] = (1 - table[1, i] ** 2) * x[i] * x[i]
        head = dynamic_head(waves, now, x2, z) if below else np.empty(len(flux))
        for i in range(len(flux)):
            flux[i] *= x[i] * ((head[i] if below else elevation_at(waves, now, x2[i])) - z[i])
        add_force(shape, table, flux, meridian, out)


@njit(cache=True)
def wave_forces(shape: Shape, q: FloatArray, waves: Incident, time: FloatArray) -> FloatArray:
    """Return `wave_force` along a motion, q and result of shape (time, dof)."""
    out = np.empty(q.shape)
    for i in range(len(time)):
        wave_force(shape, q[i], waves, time[i], out[i])
    return out
