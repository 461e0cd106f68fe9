"""The force n(t, y) at the nodes of an implicit step, whose positions depend on it: by substitution, else by Newton."""

from typing import NamedTuple

import numpy as np

from vsb.engine.motion.system import Remainder, remainder
from vsb.tools.arrays import FloatArray
from vsb.tools.compiled import assign, njit

SWEEPS, NEWTON = 40, 40
ROUND_OFF = 4e-16
"""Change of the state in a sweep that is round-off."""
FAR = 1e3
"""Displacement in radii beyond which an iteration has diverged."""
LEAST_SHARE = 1e-4
"""Least share of a Newton step."""
STALLED = 1e-11
"""Changes of the state that no longer decrease are round-off below this."""


class Step(NamedTuple):
    """Matrices of an implicit step; n needs positions alone."""

    size: float  # [s]
    free: FloatArray  # positions at the nodes without n (node * free, state)
    forced: FloatArray  # what n at the nodes adds to the positions there (node * free, node * free)


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
    for c in range(count):
        assign(times[c], time)
        assign(places[c].ravel(), p.ravel())
        for i in range(nodes * (c > 0)):
            places[c, i, (c - 1) % free] += moved if c <= free else -moved
    return places.reshape(-1, free), times.ravel()


@njit(cache=True, inline="always")
def _tangent(step: Step, around: FloatArray, moved: float, nodes: int, free: int) -> FloatArray:
    """Derivative of what is missing of n by n, from n on either side of the nodes, (node * free, node * free)."""
    out, force = -np.eye(nodes * free), around.reshape(2, free, nodes, free)
    for j in range(free):
        slope = (force[0, j] - force[1, j]) / (2 * moved)
        for i in range(nodes):
            for k in range(free):
                for m in range(nodes * free):
                    out[i * free + k, m] += slope[i, k] * step.forced[i * free + j, m]
    return out


@njit(cache=True)
def solve_nodes(
    r: Remainder, step: Step, time: FloatArray, carried: FloatArray, n: FloatArray, scale: float, enough: float
) -> float:
    """Solve for n at the nodes, the first at the start; return the last change of the state over the scale.

    By substitution while that converges fast, else by Newton's method, shortened where the residual grows, until a
    change is enough or round-off. The water's force is called in one place only: its code is large.
    """
    nodes, free = n.shape
    now = n.ravel()
    begun, base, full = now.copy(), now.copy(), np.zeros(nodes * free)
    newton, share, least, change, sweep = False, 1.0, np.inf, np.inf, 0
    while sweep < SWEEPS + NEWTON:
        known = 1 if sweep > 0 and not newton else 0  # n at the start, whose position is given
        positions = (carried + step.forced @ now).reshape(n.shape)
        places, times = _places(positions[known:], time[known:], 1e-6 * scale, newton)
        force = added(r, times, places)
        missing = np.zeros(nodes * free)
        missing[known * free :] = force[: nodes - known].ravel() - now[known * free :]
        size = np.sqrt(np.sum(missing**2))
        if newton and not size < least:
            share /= 2
            if change < STALLED or share < LEAST_SHARE:
                assign(now, base)
                break
            assign(now, base + share * full)
            continue
        sweep, before, full = sweep + 1, change, missing
        if newton:
            full = np.linalg.solve(-_tangent(step, force[nodes:], 1e-6 * scale, nodes, free), missing)
        share, least, change = 1.0, size, step.size * np.sqrt(np.sum(full**2)) / scale
        assign(base, now)
        assign(now, now + full)
        if change <= max(enough, ROUND_OFF) or STALLED > change >= 0.5 * before:
            break
        if not newton and (sweep == SWEEPS or not change < 0.7 * before):
            newton, least, change = True, np.inf, np.inf
            assign(now, begun)
    return float(change)
