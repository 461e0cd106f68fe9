"""Force of waves and water on the instantaneous wet shell: nonlinear Froude-Krylov and hydrostatics, compiled.

The axisymmetric part of long-crested waves, elevation Z(x, t) = Re sum a J_0(kx) exp(-i omega t) at radius x, acts by

    p = -rho g z + rho g Re sum a J_0(kx) cosh k(z + d)/cosh kd exp(-i omega t)    below still water,
    p = rho g (Z - z)                                                              between still water and the wave,

zero on the wave itself. To first order this is the linear Froude-Krylov force and hydrostatic stiffness. Quadrature is
split at still water, where p has a kink, and so keeps its accuracy.

J_0(kx) exp(kz) is harmonic: about a point of the axis it is sum_l (k rho)^l/l! P_l(cos theta), and so is a sea, with
coefficients summed over its components. Points then cost the same in any sea, and no Bessel functions. Components too
short for the series' round-off are summed one by one.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import factorial, j0, j1

from vsb.motion.wetted import (
    REORDERED,
    Shape,
    add_force,
    chebyshev_table,
    meridian_series,
    value,
    values,
    wet_intervals,
)
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.compiled import assign, njit
from vsb.waves.dispersion import wavenumber
from vsb.waves.seas import Sea

_SPACING = 0.02  # of the Bessel table: cubic Hermite interpolation is then good to 5e-10
_SHORT = 10.0
"""k r of the shortest wave in the series: round-off is exp(k rho) of the machine's, 1e-11 at rho = 1.2 r."""


class Incident(NamedTuple):
    """Regular components of a sea, the longest first, and tables for the compiled loops."""

    wavenumber: FloatArray  # (component,) [1/m]
    omega: FloatArray  # [rad/s]
    amplitude: ComplexArray  # [m]
    bottom: FloatArray  # exp(-2kd) (component,), zero in deep water
    radius: float  # r, unit of length of the series [m]
    powers: FloatArray  # (kr)^l/l! of the components in the series (component, l)
    even: FloatArray  # (-1)^m (kr/2)^2m/m!^2, J_0 in powers of (x/r)^2 (component, m)
    bessel: FloatArray  # J_0 and its derivative at equal steps, for the others (2, sample)


def incident(sea: Sea, depth: float, gravity: float, radius: float) -> Incident:
    """Return the incident waves of a sea, for a shell that never reaches beyond two radii."""
    order = np.argsort(sea.omega, kind="stable")
    omega, amplitude = sea.omega[order], sea.amplitude[order]
    k = np.array([wavenumber(w, depth, gravity) for w in omega])
    bottom = np.exp(-2 * k * depth) if np.isfinite(depth) else np.zeros_like(k)
    series = k[k * radius <= _SHORT] * radius
    m = np.arange(_terms(2 * series.max(initial=0.0)) + 1)
    argument = np.arange(0.0, 2 * radius * k.max(initial=0.0) + 2 * _SPACING, _SPACING)
    even = (-1.0) ** m * (series[:, None] / 2) ** (2 * m) / factorial(m) ** 2
    powers = series[:, None] ** m / factorial(m)
    return Incident(k, omega, amplitude, bottom, radius, powers, even, np.array([j0(argument), -j1(argument)]))


@njit(cache=True)
def _terms(reach: float) -> int:
    """Terms of exp(reach) above 1e-13."""
    return int(16 + 3.2 * reach)


@njit(cache=True)
def _bessel(table: FloatArray, argument: float) -> float:
    """J_0 by cubic Hermite interpolation; beyond the table its last value, which no sane shell asks for."""
    i = max(min(int(argument / _SPACING), table.shape[1] - 2), 0)  # of what is not a number any
    s = min(argument / _SPACING - i, 1.0)
    value = (1 + 2 * s) * (1 - s) ** 2 * table[0, i] + s * s * (3 - 2 * s) * table[0, i + 1]
    return float(value + _SPACING * (s * (1 - s) ** 2 * table[1, i] + s * s * (s - 1) * table[1, i + 1]))


@njit(cache=True)
def rotated(waves: Incident, time: float) -> ComplexArray:
    """Return exp(-i omega t) of every component."""
    angle = waves.omega * time
    return np.asarray(np.cos(angle) - 1j * np.sin(angle))


class Moment(NamedTuple):
    """A sea at one instant."""

    head: FloatArray  # Re a exp(-i omega t) of every component [m]
    elevation: FloatArray  # coefficients of (x/r)^2m (m,) [m]
    pressure: FloatArray  # of solid harmonics about a point of the axis (l,) [m]
    centre: float  # height of that point [m]


@njit(cache=True, fastmath=REORDERED)
def _moment(waves: Incident, rotation: ComplexArray, centre: float) -> Moment:
    """The sea at one instant, its pressure in solid harmonics about a height on the axis."""
    head = np.empty(len(rotation))
    for j in range(len(rotation)):
        head[j] = waves.amplitude[j].real * rotation[j].real - waves.amplitude[j].imag * rotation[j].imag
    count = waves.powers.shape[1]
    elevation, downward, upward = np.zeros(count), np.zeros(count), np.zeros(count)
    for j in range(len(waves.powers)):
        k, bottom = waves.wavenumber[j], waves.bottom[j]
        down = head[j] * np.exp(k * centre) / (1 + bottom)
        for i in range(count):
            elevation[i] += head[j] * waves.even[j, i]
            downward[i] += down * waves.powers[j, i]
        if bottom > 0:
            up = head[j] * bottom * np.exp(-k * centre) / (1 + bottom)
            for i in range(count):
                upward[i] += up * waves.powers[j, i]
    for i in range(count):
        downward[i] += upward[i] if i % 2 == 0 else -upward[i]
    return Moment(head, elevation, downward, centre)


@njit(cache=True)
def _elevation(waves: Incident, now: Moment, x2: float) -> float:
    """Elevation at a squared radius [m]."""
    reach = np.sqrt(x2)
    s, out = x2 / waves.radius**2, 0.0
    longest = waves.wavenumber[len(waves.powers) - 1] if len(waves.powers) else 0.0
    for m in range(min(len(now.elevation), _terms(longest * reach) // 2 + 4) - 1, -1, -1):
        out = out * s + now.elevation[m]
    for j in range(len(waves.powers), len(now.head)):
        out += now.head[j] * _bessel(waves.bessel, waves.wavenumber[j] * reach)
    return out


@njit(cache=True, fastmath=REORDERED)
def _dynamic(waves: Incident, now: Moment, x2: FloatArray, z: FloatArray) -> FloatArray:
    """Dynamic pressure head at squared radii and heights below still water, shape (point,) [m]."""
    past, here, out = np.zeros(len(z)), np.ones(len(z)), np.zeros(len(z))
    height, square, largest = np.empty(len(z)), np.empty(len(z)), 0.0
    for i in range(len(z)):
        height[i] = (z[i] - now.centre) / waves.radius
        square[i] = x2[i] / waves.radius**2 + height[i] * height[i]
        largest = max(largest, square[i])
    longest = waves.wavenumber[len(waves.powers) - 1] if len(waves.powers) else 0.0
    count = min(len(now.pressure), _terms(longest * waves.radius * np.sqrt(largest)))
    for n in range(count):
        a, b = (2 * n + 1) / (n + 1), n / (n + 1)
        for i in range(len(z)):
            out[i] += now.pressure[n] * here[i]
            following = a * height[i] * here[i] - b * square[i] * past[i]
            past[i], here[i] = here[i], following
    for j in range(len(waves.powers), len(now.head)):
        k, bottom = waves.wavenumber[j], waves.bottom[j]
        for i in range(len(z)):
            profile = np.exp(k * z[i])
            if bottom > 0:
                profile = (profile + bottom * np.exp(-k * z[i])) / (1 + bottom)
            out[i] += now.head[j] * _bessel(waves.bessel, k * np.sqrt(x2[i])) * profile
    return out


@njit(cache=True)
def _submergence(series: FloatArray, waves: Incident, now: Moment, c: float) -> float:
    """Height of a point above the wave, negative under it [m]."""
    x2 = max(1 - c * c, 0.0) * value(series[0], c) ** 2
    return value(series[1], c) - _elevation(waves, now, x2)


@njit(cache=True)
def _edges(shape: Shape, series: FloatArray, waves: Incident, now: Moment) -> FloatArray:
    """Points in c, ascending from -1 to 1, where the shell meets still water or the wave."""
    still, grid = wet_intervals(shape, series), shape.grid
    count, at = len(grid), values(series[:2], shape.on_grid)
    edges = np.empty(len(still) + count + 1)
    assign(edges[: len(still)], still)
    edges[len(still)], edges[len(still) + 1] = -1.0, 1.0
    found, highest = len(still) + 2, np.sum(np.abs(now.head))
    f_low, low = 0.0, -1.0
    for i in range(count):
        f, c = at[1, i], grid[i]
        if abs(f) <= highest:
            f -= _elevation(waves, now, max(1 - c * c, 0.0) * at[0, i] ** 2)
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
def wave_force(shape: Shape, q: FloatArray, waves: Incident, rotation: ComplexArray, out: FloatArray) -> None:
    """Fill the generalized force per rho g of water and waves on the instantaneous wet shell, shape (dof,) [m^3].

    Q_j = -2 pi int p X (s^2 z' h_j + T v_j) dc, notation of `vsb.motion.wetted`; `rotation` holds exp(-i omega t).
    """
    series = meridian_series(shape, q)
    now = _moment(waves, rotation, min(series[1, 0], 0.0))
    out[:] = 0.0
    edges = _edges(shape, series, waves, now)
    for k in range(len(edges) - 1):
        half, middle = 0.5 * (edges[k + 1] - edges[k]), 0.5 * (edges[k + 1] + edges[k])
        if half < 1e-14 or _submergence(series, waves, now, middle) > 0:
            continue
        c = middle + half * shape.node
        table = chebyshev_table(c, series.shape[1])
        meridian = values(series, table)
        x, z = meridian[0], meridian[1]
        x2 = (1 - c * c) * x * x
        if value(series[1], middle) < 0:
            pressure = _dynamic(waves, now, x2, z) - z
        else:
            pressure = -z
            for i in range(len(z)):
                pressure[i] += _elevation(waves, now, x2[i])
        add_force(shape, table, -2 * np.pi * half * shape.weight * x * pressure, meridian, out)


@njit(cache=True)
def wave_forces(shape: Shape, q: FloatArray, waves: Incident, time: FloatArray) -> FloatArray:
    """Return `wave_force` along a motion, q and result of shape (time, dof)."""
    out = np.empty(q.shape)
    for i in range(len(time)):
        wave_force(shape, q[i], waves, rotated(waves, time[i]), out[i])
    return out
