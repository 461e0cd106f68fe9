"""Force of waves and water on the instantaneous wet shell: nonlinear Froude-Krylov and hydrostatics, compiled.

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

from typing import NamedTuple

import numpy as np
from scipy.special import gammaln, jv

from vsb.engine.motion.wetted import (
    REORDERED,
    Shape,
    add_force,
    chebyshev_table,
    meridian_series,
    rule,
    value,
    values,
    values_on_grid,
    wet_intervals,
)
from vsb.engine.waves.sampling import Signals, signals, signals_at
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import wavenumber
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.compiled import assign, njit

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
    weights = _poisson(k * deep, _terms(shortest * np.hypot(deep, REACH * radius), -shortest * deep))
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


def _poisson(mean: FloatArray, count: int) -> FloatArray:
    """Weights exp(-m) m^l/l!, shape (mean, count); by products, which keep all digits."""
    root = np.exp(-mean / 2)[:, None]
    factors = np.hstack([root, mean[:, None] / np.arange(1.0, count)])
    return np.asarray(root * np.cumprod(factors, axis=1))


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
        pressure[:] = 0.0
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
    found, highest = len(still) + 2, np.sum(np.abs(now.elevation))
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
    out[:] = 0.0
    edges = _edges(shape, series, waves, now)
    for k in range(len(edges) - 1):
        half, middle = 0.5 * (edges[k + 1] - edges[k]), 0.5 * (edges[k + 1] + edges[k])
        if half < 1e-14 or _submergence(series, waves, now, middle) > 0:
            continue
        i = rule(shape, edges[k], edges[k + 1])
        n = shape.counts[i]
        c, weight = middle + half * shape.nodes[i, :n], shape.weights[i, :n]
        table = chebyshev_table(c, series.shape[1])
        meridian = values(series, table)
        x, z = meridian[0], meridian[1]
        x2 = (1 - c * c) * x * x
        if value(series[1], middle) < 0:
            pressure = dynamic_head(waves, now, x2, z) - z
        else:
            pressure = -z
            for i in range(len(z)):
                pressure[i] += elevation_at(waves, now, x2[i])
        add_force(shape, table, -2 * np.pi * half * weight * x * pressure, meridian, out)


@njit(cache=True)
def wave_forces(shape: Shape, q: FloatArray, waves: Incident, time: FloatArray) -> FloatArray:
    """Return `wave_force` along a motion, q and result of shape (time, dof)."""
    out = np.empty(q.shape)
    for i in range(len(time)):
        wave_force(shape, q[i], waves, time[i], out[i])
    return out
