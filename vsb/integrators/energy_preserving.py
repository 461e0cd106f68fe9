"""Structure-preserving integration of a scene: collocation of order 4 that neither makes nor loses energy, any step.

The scene is z' = A z + B (n(t, z) + waves), and without waves a flow z' = D grad H with stored energy H
and D + D^T <= 0: port-Hamiltonian, radiation memory included. On a step the motion is the polynomial of second degree
whose rate has the same mean and the same first moment as the right-hand side:

    z' = g_0 P_0 + g_1 P_1,    g_j = int P_j(s) (A z + B n) ds,    P_0 = 1, P_1 = sqrt(3) (2 s - 1), 0 < s < 1.

Then H gains h sum_j G_j.D G_j <= 0, G_j the moments of grad H, and what the waves do: a discrete storage inequality at
every step size. Linear terms are integrated exactly, which makes this Gauss' method of two stages there; n by Gauss'
rule of four points, exact for the water about a sphere. Hairer (2010), "Energy-preserving variant of collocation
methods"; Brugnano, Iavernaro & Trigiante (2010), "Hamiltonian boundary value methods", HBVM(4, 2).
"""

import time as clock
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vsb.errors import ConvergenceError
from vsb.motion.system import Motion, Remainder, System, remainder
from vsb.tools.arrays import FloatArray
from vsb.tools.compiled import njit

NODES = 4
FINEST = 10
"""Most halvings of a recorded step."""
SWEEPS, NEWTON = 40, 40
ROUND_OFF = 4e-16
"""Change of the state in a sweep that is round-off."""
FAR = 1e3
"""Displacement in radii beyond which an iteration has diverged."""
LEAST_SHARE = 1e-4
"""Least share of a Newton step."""
STALLED = 1e-11
"""Changes of the state that no longer decrease are round-off below this."""
_NODE, _WEIGHT = (0.5 * x for x in np.polynomial.legendre.leggauss(NODES))
_NODE = _NODE + 0.5
_P = np.array([np.ones(NODES), np.sqrt(3.0) * (2 * _NODE - 1)])
"""P_j at the nodes (2, node)."""
_INTEGRAL = np.array([_NODE, np.sqrt(3.0) * (_NODE**2 - _NODE)])
"""int_0^c P_j (2, node)."""
_MOMENT = np.array([[0.5, -0.5 / np.sqrt(3.0)], [0.5 / np.sqrt(3.0), 0.0]])
"""int P_i int_0^s P_j (2, 2)."""
_AHEAD = np.vander(_NODE + 1, NODES) @ np.linalg.inv(np.vander(_NODE, NODES))
"""The polynomial through the nodes at the nodes of the next step (node, node)."""


class Step(NamedTuple):
    """Matrices of a step of size h; n acts on the velocity rows alone, n itself needs positions alone."""

    size: float  # h [s]
    free: FloatArray  # positions at the nodes without n (node * free, state)
    forced: FloatArray  # what n at the nodes adds there (node * free, node * free)
    end_free: FloatArray  # state at the end (state, state)
    end_forced: FloatArray  # (state, node * free)


def step_matrices(a: FloatArray, free: int, h: float) -> Step:
    """Return the matrices of a step of z' = A z + B n, B putting n into the `free` velocity rows.

    Parameters
    ----------
    a : ndarray, shape (state, state) [1/s]
    h : float [s]
    """
    state = len(a)
    into = np.zeros((2, state, NODES, free))
    for row in range(free):
        into[:, free + row, :, row] = _P * _WEIGHT
    right = np.hstack([np.vstack([a, np.zeros_like(a)]), into.reshape(2 * state, -1)])
    moments = np.linalg.solve(np.eye(2 * state) - h * np.kron(_MOMENT, a), right).reshape(2, state, -1)
    nodes = h * np.einsum("jn,jsc->nsc", _INTEGRAL, moments[:, :free]).reshape(NODES * free, -1)
    still = np.tile(np.eye(free, state), (NODES, 1))
    end = h * moments[0]
    return Step(
        h,
        np.ascontiguousarray(still + nodes[:, :state]),
        np.ascontiguousarray(nodes[:, state:]),
        np.ascontiguousarray(np.eye(state) + end[:, :state]),
        np.ascontiguousarray(end[:, state:]),
    )


@njit(cache=True, inline="always")
def added(r: Remainder, time: FloatArray, p: FloatArray) -> FloatArray:
    """Return n at some instants, p and result of shape (instant, free); infinite far outside any shell."""
    out = np.full(p.shape, np.inf)
    if np.abs(p @ r.position.T).max() < FAR * r.shape.radius:
        for i in range(len(time)):
            remainder(r, time[i], p[i], out[i])
    return out


@njit(cache=True, inline="always")
def _places(p: FloatArray, time: FloatArray, moved: float, newton: bool) -> tuple[FloatArray, FloatArray]:
    """Points where n is evaluated: the nodes, and for Newton's method on either side of them along every coordinate."""
    nodes, free = p.shape
    count = 1 + 2 * free if newton else 1
    places, times = np.empty((count, nodes, free)), np.empty((count, nodes))
    places[:], times[:] = p, time
    for j in range((count - 1) // 2):
        places[1 + j, :, j] += moved
        places[1 + free + j, :, j] -= moved
    return places.reshape(-1, free), times.ravel()


@njit(cache=True, inline="always")
def _tangent(step: Step, around: FloatArray, moved: float, nodes: int, free: int) -> FloatArray:
    """Derivative of what is missing of n by n, from n on either side of the nodes, (node * free, node * free)."""
    out, force = -np.eye(nodes * free), around.reshape(2, free, nodes, free)
    for j in range(free):
        slope = (force[0, j] - force[1, j]) / (2 * moved)
        for i in range(nodes):
            for k in range(free):
                out[i * free + k] += slope[i, k] * step.forced[i * free + j]
    return out


@njit(cache=True, inline="always")
def solve_nodes(
    r: Remainder, step: Step, time: FloatArray, carried: FloatArray, push: FloatArray, n: FloatArray, scale: float
) -> float:
    """Solve for n at the nodes; return the last change, over the scale.

    By substitution while that converges fast, else by Newton's method, shortened where the residual grows. The water's
    force is called in one place only: its code is large.
    """
    nodes, free = n.shape
    begun, base = n.copy(), n.copy()
    full: FloatArray = np.zeros(n.shape)
    newton, share, least, change, sweep = False, 1.0, np.inf, np.inf, 0
    while sweep < SWEEPS + NEWTON:
        places, times = _places((carried + step.forced @ n.ravel()).reshape(n.shape), time, 1e-6 * scale, newton)
        force = added(r, times, places)
        missing = force[:nodes] + push - n
        size = np.sqrt(np.sum(missing**2))
        if newton and not size < least:
            share /= 2
            if change < STALLED or share < LEAST_SHARE:
                n[:] = base
                break
            n[:] = base + share * full
            continue
        sweep, before, full = sweep + 1, change, missing
        if newton:
            tangent = _tangent(step, force[nodes:], 1e-6 * scale, nodes, free)
            full = np.linalg.solve(-tangent, missing.ravel()).reshape(n.shape)
        share, least, change = 1.0, size, step.size * np.sqrt(np.sum(full**2)) / scale
        base[:] = n
        n += full
        if change <= ROUND_OFF or STALLED > change >= 0.5 * before:
            break
        if not newton and (sweep == SWEEPS or not change < 0.7 * before):
            newton, least, change = True, np.inf, np.inf
            n[:] = begun
    return float(change)


@njit(cache=True)
def _march(r: Remainder, step: Step, start: float, push: FloatArray, least: float, every: int, out: FloatArray) -> int:
    """Fill the states at every so many steps; return the steps made, all unless one cannot be solved."""
    z, n = out[0].copy(), np.zeros((NODES, len(r.constant)))
    scale = least
    for i in range(every * (len(out) - 1)):
        time = start + (i + _NODE) * step.size
        scale = max(scale, np.sqrt(z @ z))
        if not solve_nodes(r, step, time, step.free @ z, push[i], n, scale) < STALLED:
            return i
        z = step.end_free @ z + step.end_forced @ n.ravel()
        n = _AHEAD @ (n - push[i])
        if i + 1 < len(push):
            n += push[i + 1]
        if (i + 1) % every == 0:
            out[(i + 1) // every] = z
    return every * (len(out) - 1)


@njit(cache=True)
def _march_linear(step: Step, push: FloatArray, every: int, out: FloatArray) -> None:
    """Fill the states of a linear scene at every so many steps."""
    z = out[0].copy()
    for i in range(every * (len(out) - 1)):
        z = step.end_free @ z + step.end_forced @ push[i].ravel()
        if (i + 1) % every == 0:
            out[(i + 1) // every] = z


@dataclass(frozen=True)
class GaussIntegrator:
    """Equal steps of a scene, linear or body-exact."""

    system: System

    def run(self, first: FloatArray, time: FloatArray, substeps: int) -> FloatArray:
        """Return the states at recorded instants, shape (time, state), by so many steps between two of them.

        Raises `ConvergenceError` if the equations of a step have no solution that is found.
        """
        self.system.check_compiled()
        h, out = float(time[1] - time[0]) / substeps, np.empty((len(time), len(first)))
        out[0], count = first, substeps * (len(time) - 1)
        step, r = step_matrices(self.system.matrix, self.system.free, h), self.system.remainder
        begins = time[0] + h * np.arange(count)
        push = np.stack([self.system.push(begins + c * h) for c in _NODE], axis=1)
        if r is None:
            _march_linear(step, push, substeps, out)
            return out
        least = max(self.system.least, h * r.round_off / STALLED)
        done = _march(r, step, float(time[0]), push, least, substeps, out)
        if done < count:
            raise ConvergenceError(
                f"a step of {h:.3g} s at t = {time[0] + done * h:.6g} s: its equations are not solved in {NEWTON} "
                "Newton iterations, needs a shorter step; record more instants, or use simulation.method: exponential."
            )
        return out

    def motion(self, time: FloatArray, states: FloatArray, seconds: float) -> Motion:
        """Return recorded states as a motion."""
        return self.system.motion(time, states, self.system.forcing(time, states), seconds)


def fixed_step(system: System, time: FloatArray, start: tuple[FloatArray, ...], substeps: int = 1) -> Motion:
    """Return the motion of a scene by equal steps, so many between two recorded instants.

    Raises `ConvergenceError` if a step is too long for its equations to be solved.

    Parameters
    ----------
    system : System
        Linear or body-exact.
    time : ndarray, shape (time,) [s]
        Equally spaced.
    start : tuple of ndarray
        y [m] and y' [m/s] at the first instant, each shape (free,); then memory states, if the water is not at rest.
    """
    begun = clock.perf_counter()
    method = GaussIntegrator(system)
    states = method.run(system.first(start), time, substeps)
    return method.motion(time, states, clock.perf_counter() - begun)


def structure_preserving(
    system: System, time: FloatArray, start: tuple[FloatArray, ...], tolerance: float
) -> tuple[Motion, int]:
    """Return the motion of a scene with equal steps small enough, and the number of steps.

    Raises `ConvergenceError` if 2^`FINEST` steps between two instants are not enough.

    Parameters
    ----------
    system : System
        Linear or body-exact.
    time : ndarray, shape (time,) [s]
        Equally spaced; a step is an interval or an equal part of it.
    start : tuple of ndarray
        y [m] and y' [m/s] at the first instant, each shape (free,); then memory states, if the water is not at rest.
    tolerance : float
        Of the state at every instant, relative to its largest norm, the root of twice the energy, or to
        `System.least` if that is larger. The error is a fifteenth of the difference to steps twice as long.
    """
    begun = clock.perf_counter()
    method = GaussIntegrator(system)
    first, coarse, error = system.first(start), None, np.inf
    for halving in range(FINEST + 1):
        try:
            states = method.run(first, time, 2**halving)
        except ConvergenceError:  # a step so long that it cannot be solved
            continue
        if coarse is not None:
            largest = max(float(np.linalg.norm(states, axis=1).max()), system.least, 1e-300)
            error = float(np.abs(states - coarse).max() / 15 / largest)
        if error <= tolerance:
            return method.motion(time, states, clock.perf_counter() - begun), 2**halving * (len(time) - 1)
        coarse = states
    raise ConvergenceError(
        f"structure-preserving steps of {(time[1] - time[0]) / 2**FINEST:.2g} s: the motion is known to {error:.1e}, "
        f"needs {tolerance:g}; raise simulation.tolerance, or use simulation.method: auto."
    )
