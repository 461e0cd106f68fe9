"""Force of waves and water on the instantaneous wet shell: nonlinear Froude-Krylov and hydrostatics, compiled.

The axisymmetric part of long-crested waves, elevation Z(x, t) = Re sum a J_0(kx) exp(-i omega t) at radius x, acts by

    p = -rho g z + rho g Re sum a J_0(kx) cosh k(z + d)/cosh kd exp(-i omega t)    below still water,
    p = rho g (Z - z)                                                              between still water and the wave,

zero on the wave itself. To first order this is the linear Froude-Krylov force and hydrostatic stiffness. Quadrature is
split at still water, where p has a kink, and so keeps its accuracy.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import j0, j1

from vsb.compiled import njit
from vsb.units import ComplexArray, FloatArray
from vsb.waves import Sea, wavenumber
from vsb.wetforce import Shape, legendre, meridian_point, wet_intervals

_SPACING = 0.02  # of the Bessel table: cubic Hermite interpolation is then good to 5e-10


class Incident(NamedTuple):
    """Regular components of a sea, and what the compiled loops need of Bessel's function."""

    wavenumber: FloatArray  # (component,) [1/m]
    omega: FloatArray  # [rad/s]
    amplitude: ComplexArray  # [m]
    bottom: FloatArray  # exp(-2kd) (component,), zero in deep water
    bessel: FloatArray  # J_0 and its derivative at equal steps (2, sample)


def incident(sea: Sea, depth: float, gravity: float, radius: float) -> Incident:
    """Return the incident waves of a sea, for a shell that never reaches beyond two radii."""
    k = np.array([wavenumber(w, depth, gravity) for w in sea.omega])
    bottom = np.exp(-2 * k * depth) if np.isfinite(depth) else np.zeros_like(k)
    argument = np.arange(0.0, 2 * radius * (k.max() if k.size else 0.0) + 2 * _SPACING, _SPACING)
    return Incident(k, sea.omega, sea.amplitude, bottom, np.array([j0(argument), -j1(argument)]))


@njit(cache=True)
def _bessel(table: FloatArray, argument: float) -> float:
    """J_0 by cubic Hermite interpolation; beyond the table its last value, which no sane shell asks for."""
    i = min(int(argument / _SPACING), table.shape[1] - 2)
    s = min(argument / _SPACING - i, 1.0)
    value = (1 + 2 * s) * (1 - s) ** 2 * table[0, i] + s * s * (3 - 2 * s) * table[0, i + 1]
    return float(value + _SPACING * (s * (1 - s) ** 2 * table[1, i] + s * s * (s - 1) * table[1, i + 1]))


@njit(cache=True)
def _dynamic(waves: Incident, phases: ComplexArray, x: float, z: float) -> float:
    """Dynamic pressure head [m] at radius x and height z, at z > 0 that of z = 0: the elevation."""
    head, below = 0.0, min(z, 0.0)
    for j in range(len(phases)):
        k, bottom = waves.wavenumber[j], waves.bottom[j]
        profile = np.exp(k * below)
        if bottom > 0:
            profile = (profile + bottom / profile) / (1 + bottom)
        head += phases[j].real * _bessel(waves.bessel, k * abs(x)) * profile
    return head


@njit(cache=True)
def _point(shape: Shape, q: FloatArray, c: float, p: FloatArray, dp: FloatArray) -> tuple[float, float]:
    """Radius and height of the meridian."""
    legendre(c, p, dp)
    s2 = 1 - c * c
    x, z = shape.radius, shape.centre_height + shape.radius * c
    for j in range(len(q)):
        n, v, u = shape.degree[j], shape.radial[j], shape.meridional[j]
        x += q[j] * (v * p[n] - u * c * dp[n])
        z += q[j] * (v * c * p[n] + u * s2 * dp[n])
    return np.sqrt(max(s2, 0.0)) * x, z


@njit(cache=True)
def _submergence(
    shape: Shape, q: FloatArray, waves: Incident, phases: ComplexArray, c: float, p: FloatArray, dp: FloatArray
) -> float:
    """Height of a point above the wave, negative under it [m]."""
    x, z = _point(shape, q, c, p, dp)
    return z - _dynamic(waves, phases, x, 0.0)


@njit(cache=True)
def _edges(
    shape: Shape, q: FloatArray, waves: Incident, phases: ComplexArray, p: FloatArray, dp: FloatArray
) -> FloatArray:
    """Points in c, ascending from -1 to 1, where the shell meets still water or the wave."""
    still = wet_intervals(shape, q, p, dp)
    count = len(shape.grid)
    edges = np.empty(len(still) + count + 1)
    edges[: len(still)] = still
    edges[len(still)], edges[len(still) + 1] = -1.0, 1.0
    found = len(still) + 2
    low = shape.grid[0]
    f_low = _submergence(shape, q, waves, phases, low, p, dp)
    for i in range(1, count):
        high = shape.grid[i]
        f_high = _submergence(shape, q, waves, phases, high, p, dp)
        if (f_low < 0) != (f_high < 0):
            edges[found] = _crossing(shape, q, waves, phases, low, high, f_low, f_high, p, dp)
            found += 1
        low, f_low = high, f_high
    return np.sort(edges[:found])


@njit(cache=True)
def _crossing(
    shape: Shape, q: FloatArray, waves: Incident, phases: ComplexArray, a: float, b: float, f_a: float, f_b: float,
    p: FloatArray, dp: FloatArray,
) -> float:  # fmt: skip
    """Where the shell crosses the wave, in a bracket: regula falsi with the Illinois rule."""
    side = 0
    for _ in range(60):
        c = (a * f_b - b * f_a) / (f_b - f_a)
        f = _submergence(shape, q, waves, phases, c, p, dp)
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

    Q_j = -2 pi int p X (s^2 z' h_j + T v_j) dc, notation of `vsb.wetforce`.
    """
    order = shape.degree.max() + 1
    p, dp = np.empty(order), np.empty(order)
    h, v = np.empty(len(q)), np.empty(len(q))
    phases = waves.amplitude * np.exp(-1j * waves.omega * time)
    out[:] = 0.0
    edges = _edges(shape, q, waves, phases, p, dp)
    for k in range(len(edges) - 1):
        half, middle = 0.5 * (edges[k + 1] - edges[k]), 0.5 * (edges[k + 1] + edges[k])
        if half < 1e-14 or _submergence(shape, q, waves, phases, middle, p, dp) > 0:
            continue
        for i in range(len(shape.node)):
            c = middle + half * shape.node[i]
            s2 = 1 - c * c
            x, z, slope, t = meridian_point(shape, q, c, p, dp, h, v)
            pressure = _dynamic(waves, phases, np.sqrt(s2) * x, z) - z
            w = -2 * np.pi * half * shape.weight[i] * x * pressure
            for j in range(len(q)):
                out[j] += w * (s2 * slope * h[j] + t * v[j])


@njit(cache=True)
def wave_forces(shape: Shape, q: FloatArray, waves: Incident, time: FloatArray) -> FloatArray:
    """Return `wave_force` along a motion, q and result of shape (time, dof)."""
    out = np.empty(q.shape)
    for i in range(len(time)):
        wave_force(shape, q[i], waves, time[i], out[i])
    return out
