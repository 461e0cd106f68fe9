"""Exponential collocation of a body-exact scene: the linear part exactly, what the water does beyond it by polynomials.

The scene is split into z' = A z + B n(t, z). A holds elasticity, damping, memory and the tangent of the water's force,
so stiff modes do not limit the step; n is smooth and small and depends on positions alone. A step of size 4 d makes n
the polynomial through five instants d apart,

    z(t + x d) = exp(x d A) z(t) + int_0^{x d} exp((x d - s) A) B n(t + s) ds,

solved by sweeps of substitution that start from the extrapolated polynomial of the step before. Order 6 where A is not
stiff, 5 where it is. Instants d apart are the recorded ones, or every 2^k-th or 2^-k-th of them.
"""

import math
import time as clock
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from vsb.compiled import njit
from vsb.errors import ConvergenceError
from vsb.integrate import Motion
from vsb.plant import AssumedPressure, ConstantForce, Excitation, LinearSystem, Plant, Spring, WaterPressure
from vsb.units import ComplexArray, FloatArray
from vsb.waveforce import Incident, incident, wave_force
from vsb.waves import NO_WAVES
from vsb.wetforce import Shape, wet_force

NODES = 5
LONGEST = 3  # nodes are at most 2^3 recorded instants apart
SHORTEST = -16
SWEEPS = 12
PROBE = 2.618
"""Where n is looked at between the nodes: an undamped ring that all nodes meet in one phase is seen here."""


class Remainder(NamedTuple):
    """What the compiled loop needs for n(t, z) = R^T (f_water + constant + C q) + diffraction, q = L z."""

    shape: Shape
    rest: FloatArray  # (dof,)
    position: FloatArray  # L (dof, free)
    project: FloatArray  # R^T (free, dof)
    constant: FloatArray  # (dof,)
    tangent: FloatArray  # C (dof, dof)
    specific_weight: float
    amplitude: float  # of the assumed pressure
    omega: float
    waves: Incident  # none: no components
    diffraction: ComplexArray  # modal phasors (component, free)


class Step(NamedTuple):
    """Matrices of a step with nodes d apart; n acts on the velocity rows alone, n itself needs positions alone."""

    spacing: float  # d [s]
    free: FloatArray  # exp(i d A), position rows, i = 1..4 (node - 1, free, state)
    forced: FloatArray  # response there to n at the five nodes (node - 1, free, node * free)
    end_free: FloatArray  # exp(4 d A) (state, state)
    end_forced: FloatArray  # (state, node * free)
    last_forced: FloatArray  # its part of the last node (state, free)
    probe_free: FloatArray  # likewise at `PROBE`, position rows (free, state)
    probe_forced: FloatArray  # (free, node * free)
    record_free: FloatArray  # likewise at the recorded instants inside the step (record, state, state)
    record_forced: FloatArray  # (record, state, node * free)


def phi_integrals(a: FloatArray, b: FloatArray, h: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Return exp(hA) and P_k(h) = int_0^h exp((h-s) A) B s^(k-1)/(k-1)! ds, k = 1..count, from one exponential.

    Parameters
    ----------
    a : ndarray, shape (state, state) [1/s]
    b : ndarray, shape (state, free)
    h : float [s]
    count : int

    Returns
    -------
    exponential : ndarray, shape (state, state)
    integrals : ndarray, shape (count, state, free)
        h^k phi_k(hA) B: the last columns of exp of [[A, B, 0, ...], [0, 0, I, ...], ..., [0, 0, ...]] h.
    """
    n, m = b.shape
    block = np.zeros((n + count * m, n + count * m))
    block[:n, :n], block[:n, n : n + m] = a, b
    block[n : n + (count - 1) * m, n + m :] = np.eye((count - 1) * m)
    out = expm(h * block)
    return out[:n, :n], np.array([out[:n, n + k * m : n + (k + 1) * m] for k in range(count)])


def on_a_grid(a: FloatArray, b: FloatArray, unit: float, count: int) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return exp(tA) and P_k(t), k = 1..NODES, at t = unit, 2 unit, ..., count unit.

    Notes
    -----
    P_k(s + t) = exp(tA) P_k(s) + sum_j s^(k-j)/(k-j)! P_j(t): one matrix exponential serves the whole grid.
    """
    first, integrals = phi_integrals(a, b, unit, NODES)
    powers, grid = [first], [integrals]
    for i in range(1, count):
        s = i * unit
        carried = [
            first @ grid[-1][k] + sum(s ** (k - j) / math.factorial(k - j) * integrals[j] for j in range(k + 1))
            for k in range(NODES)
        ]
        powers.append(first @ powers[-1])
        grid.append(np.array(carried))
    return powers, grid


LAGRANGE = np.linalg.inv(np.vander(np.arange(NODES), increasing=True))
"""Coefficients of x^k in the Lagrange polynomials of x = 0..4, shape (k, node)."""
AT_PROBE = PROBE ** np.arange(NODES) @ LAGRANGE
"""The Lagrange polynomials at `PROBE`, shape (node,)."""


def step_matrices(a: FloatArray, b: FloatArray, dt: float, level: int) -> Step:
    """Return the matrices of a step whose nodes are dt 2^level apart, dt between recorded instants."""
    free = b.shape[1]
    spacing, fine = dt * 2.0**level, 2 ** max(level, 0)  # grid points per node distance: recorded instants
    powers, grid = on_a_grid(a, b, spacing / fine, fine * (NODES - 1))
    scale = np.array([math.factorial(k) / spacing**k for k in range(NODES)])

    def to_nodes(integrals: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("kj,ksf->sjf", LAGRANGE * scale[:, None], integrals).reshape(len(a), -1))

    forced = [to_nodes(p) for p in grid]
    probe, integrals = phi_integrals(a, b, PROBE * spacing, NODES)
    nodes = range(fine - 1, fine * (NODES - 1), fine)
    return Step(
        spacing,
        np.array([powers[i][:free] for i in nodes]),
        np.array([forced[i][:free] for i in nodes]),
        powers[-1].copy(),
        forced[-1].copy(),
        forced[-1][:, -free:].copy(),
        probe[:free].copy(),
        to_nodes(integrals)[:free].copy(),
        np.array(powers[:-1]),
        np.array(forced[:-1]),
    )


@njit(cache=True)
def _remainder(r: Remainder, t: float, p: FloatArray, out: FloatArray, static: FloatArray, uniform: FloatArray) -> None:
    """Fill n at time t and scaled modal positions p."""
    q = r.position @ p
    force = r.constant + r.tangent @ q
    if len(r.waves.omega):
        wave_force(r.shape, r.rest + q, r.waves, t, static)
        force += r.specific_weight * static
    else:
        wet_force(r.shape, r.rest + q, static, uniform)
        force += r.specific_weight * static + r.amplitude * np.cos(r.omega * t) * uniform
    out[:] = r.project @ force
    for j in range(len(r.waves.omega)):
        phase = np.exp(-1j * r.waves.omega[j] * t)
        for i in range(len(out)):
            out[i] += (r.diffraction[j, i] * phase).real


@njit(cache=True)
def _sweep(
    r: Remainder, step: Step, t: float, carried: FloatArray, n: FloatArray, static: FloatArray, uniform: FloatArray
) -> float:
    """Renew n at the nodes after the first, each from the newest of the others; return the largest change."""
    change = 0.0
    flat = n.ravel()
    old = np.empty(n.shape[1])
    for i in range(NODES - 1):
        old[:] = n[i + 1]
        position = carried[i] + step.forced[i] @ flat
        _remainder(r, t + (i + 1) * step.spacing, position, n[i + 1], static, uniform)
        change = max(change, np.sqrt(np.sum((n[i + 1] - old) ** 2)))
    return change


@njit(cache=True)
def _extrapolated(n: FloatArray, ratio: float) -> FloatArray:
    """The polynomial through five nodes, at the nodes of the following step, `ratio` as far apart."""
    out = np.zeros_like(n)
    for i in range(NODES):
        x = NODES - 1 + ratio * i
        for j in range(NODES):
            weight = 1.0
            for k in range(NODES):
                if k != j:
                    weight *= (x - k) / (j - k)
            out[i] += weight * n[j]
    return out


@njit(cache=True)
def _march(
    r: Remainder, step: Step, dt: float, ticks: int, level: int, tolerance: float, z: FloatArray, n: FloatArray,
    scale: float, out: FloatArray,
) -> tuple[int, int, float, int]:  # fmt: skip
    """Take steps of one size until the end, or until another size is better.

    Time is counted in ticks, 2^-SHORTEST of them between recorded instants. z holds the state, n the prediction of n
    at the nodes of the next step. Returns the tick reached, +1 to double the step, -1 to halve it, 0 at the end; the
    scale of the error; the steps tried.
    """
    per_record = 1 << -SHORTEST
    apart = 1 << (level - SHORTEST)
    span, last = (NODES - 1) * apart, (len(out) - 1) * per_record
    free = r.position.shape[1]
    static, uniform, carried = np.empty(len(r.constant)), np.empty(len(r.constant)), np.empty((NODES - 1, free))
    tried, between = 0, np.empty(free)
    while ticks < last:
        if ticks + span > last:
            return ticks, -1, scale, tried
        t = ticks / per_record * dt
        _remainder(r, t, z[:free].copy(), n[0], static, uniform)
        for i in range(NODES - 1):
            carried[i] = step.free[i] @ z
        limit = tolerance * scale
        lost = np.inf
        for _ in range(SWEEPS):
            change = _sweep(r, step, t, carried, n, static, uniform) * span / per_record * dt
            if not change > 0.05 * limit:
                lost = change
                break
        tried += 1
        flat = n.ravel()
        end = step.end_free @ z + step.end_forced @ flat
        fourth = n[0] - 4 * n[1] + 6 * n[2] - 4 * n[3] + n[4]
        position = step.probe_free @ z + step.probe_forced @ flat
        _remainder(r, t + PROBE * step.spacing, position, between, static, uniform)
        missed, unseen = step.last_forced @ fourth, step.last_forced @ (between - AT_PROBE @ n)
        error = (np.sqrt(missed @ missed) + np.sqrt(unseen @ unseen) + lost) / limit
        if not error < 1.0:
            n[:] = n[0].copy()
            return ticks, -1, scale, tried
        for i in range(max(span // per_record - 1, 0)):
            place = i if level >= 0 else ((i + 1) << -level) - 1
            out[ticks // per_record + i + 1] = step.record_free[place] @ z + step.record_forced[place] @ flat
        z[:] = end
        ticks += span
        scale = max(scale, float(np.sqrt(end @ end)))
        if ticks % per_record == 0:
            out[ticks // per_record] = end
        aligned = ticks % min(2 * span, per_record) == 0
        grow = error < 1 / 64 and aligned and ticks + 2 * span <= last and level < LONGEST
        n[:] = _extrapolated(n, 2.0 if grow else 1.0)
        if grow:
            return ticks, 1, scale, tried
    return ticks, 0, scale, tried


@dataclass(frozen=True)
class ExponentialIntegrator:
    """A body-exact scene split into its linear part and the remainder."""

    plant: Plant
    water: WaterPressure
    dt: float  # between recorded instants [s]

    @cached_property
    def system(self) -> LinearSystem:
        """Linear part, the tangent of the water's force among its springs."""
        linear = {name: f for name, f in self.plant.forces.items() if not isinstance(f, Excitation)}
        forces = {**linear, "tangent": Spring(self.water.tangent)}
        return replace(self.plant, forces=forces).linear_system()

    @cached_property
    def input(self) -> FloatArray:
        """B: forces act on the velocity rows, shape (state, free)."""
        n = self.plant.motions.shape[1]
        b = np.zeros((len(self.system.matrix), n))
        b[n : 2 * n] = np.eye(n)
        return b

    @cached_property
    def remainder(self) -> Remainder:
        """Arguments of the compiled remainder."""
        motions, water, dof = self.plant.motions, self.water, len(self.plant.labels)
        constants = [force.force for force in self.plant.forces.values() if isinstance(force, ConstantForce)]
        assumed = water.assumed or AssumedPressure(0.0, 0.0)
        waves = water.waves or incident(NO_WAVES, np.inf, 1.0, water.shell.shape.radius)
        diffraction = self.plant.excitation.force if self.plant.excitation else np.zeros((0, dof))
        return Remainder(
            water.shell.shape,
            water.rest,
            np.ascontiguousarray(motions @ self.system.position),
            np.ascontiguousarray((motions @ self.system.velocity).T),
            sum(constants, np.zeros(dof)),
            np.ascontiguousarray(water.tangent),
            water.specific_weight,
            assumed.amplitude,
            assumed.omega,
            waves,
            np.ascontiguousarray(diffraction @ motions @ self.system.velocity, dtype=complex),
        )

    @cached_property
    def least_scale(self) -> float:
        """Norm of a state too small to matter: a millionth of the root of rho g r^4."""
        return 1e-6 * float(np.sqrt(self.water.specific_weight) * self.water.shell.shape.radius**2)

    def step(self, level: int) -> Step:
        """Matrices of a step with nodes dt 2^level apart."""
        return step_matrices(self.system.matrix, self.input, self.dt, level)

    def run(self, first: FloatArray, count: int, tolerance: float) -> tuple[FloatArray, int]:
        """Return the states at `count` recorded instants, shape (count, state), and the number of steps tried.

        Raises
        ------
        ConvergenceError
            If nodes have to be closer than dt 2^-16.
        """
        out, z = np.empty((count, len(first))), first.copy()
        n = np.zeros((NODES, self.input.shape[1]))
        out[0], scale = first, max(float(np.linalg.norm(first)), self.least_scale)
        ticks, level, change, total, matrices = 0, -1, 1, 0, {}
        while change:
            if level < SHORTEST:
                shortest = self.dt * 2.0**SHORTEST
                raise ConvergenceError(
                    f"the motion cannot be followed at t = {ticks * shortest:.6g} s: the step became shorter than "
                    f"{shortest:.1e} s; check the study for loads that crush the shell, or raise simulation.tolerance."
                )
            if level not in matrices:
                matrices[level] = self.step(level)
            ticks, change, scale, tried = _march(
                self.remainder, matrices[level], self.dt, ticks, level, tolerance, z, n, scale, out
            )
            total, level = total + tried, level + change
        return out, total


def integrate(
    plant: Plant, time: FloatArray, start: tuple[FloatArray, FloatArray], tolerance: float
) -> tuple[Motion, int]:
    """Return the motion of a body-exact scene at equally spaced times, and the number of steps tried.

    Parameters
    ----------
    plant : Plant
        With a `WaterPressure` among its forces.
    time : ndarray, shape (time,) [s]
    start : tuple of ndarray, each shape (free,)
        Initial y [m] and y' [m/s].
    tolerance : float
        Of the local error, relative to the largest norm of the state so far: the root of twice its energy.

    Raises
    ------
    ConvergenceError
        If the motion cannot be followed.
    """
    if plant.water is None:
        raise ValueError("an exponential integrator needs a scene with water pressure; use propagate for a linear one.")
    dt = float(time[1] - time[0])
    warm = ExponentialIntegrator(plant, plant.water, dt)
    warm.run(np.zeros(len(warm.system.matrix)), 2, 1.0)  # compiles: no part of the motion's seconds
    begun = clock.perf_counter()
    method = ExponentialIntegrator(plant, plant.water, dt)
    system, n = method.system, plant.motions.shape[1]
    first = np.zeros(len(system.matrix))
    first[:n], first[n : 2 * n] = np.linalg.solve(system.position, start[0]), np.linalg.solve(system.velocity, start[1])
    states, steps = method.run(first, len(time), tolerance)
    rates = states @ system.matrix.T
    rates[:, n : 2 * n] += _remainders(method.remainder, time, np.ascontiguousarray(states[:, :n]))
    motion = Motion(
        time,
        states[:, :n] @ system.position.T,
        states[:, n : 2 * n] @ system.velocity.T,
        rates[:, n : 2 * n] @ system.velocity.T,
        states[:, 2 * n :],
        clock.perf_counter() - begun,
    )
    return motion, steps


@njit(cache=True)
def _remainders(r: Remainder, time: FloatArray, p: FloatArray) -> FloatArray:
    """n(t, p) at every recorded instant, shape (time, free)."""
    out = np.empty((len(time), r.position.shape[1]))
    static, uniform = np.empty(len(r.constant)), np.empty(len(r.constant))
    for i in range(len(time)):
        _remainder(r, time[i], p[i], out[i], static, uniform)
    return out
