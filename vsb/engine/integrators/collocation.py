"""Exponential collocation: any smooth forces of position and velocity beside the linear part, which is exact.

    z' = A z + B f(t, z),    f = n + waves

Over a step f is the polynomial of degree four through its values at five equally spaced instants, of the motion it
causes: order 6, however stiff A is. No past is needed, so steps change their length freely: where f has a kink, as the
drag of a flow that turns, they become as short as the tolerance requires and then long again. Forces are evaluated in
NumPy, all instants of a step together: a new force needs no compiled version.
"""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.special import comb

from vsb.engine.integrators.exponential import lagrange, phi_integrals
from vsb.engine.motion.system import Motion, System
from vsb.errors import ConvergenceError
from vsb.tools.arrays import FloatArray

NODES = 5
PARTS = 8
"""Of a step at least: nodes lie at every other part, the probe at the third."""
PROBE = 3
LONGEST, SHORTEST = 5, -14
"""A step is at most 2^LONGEST recorded instants long, at least 2^SHORTEST of one."""
SWEEPS = 25
"""Most substitutions until f is met."""
MET = 1e-2
"""Change of the last substitution over the error a step may make."""
SPENT = 0.02
"""Part of the saved shares that one step at a kink may use."""
GROWTH = 2.0**7
"""Twice the step makes 2^6 times the error per time."""
ROUND_OFF = 1e-14
AT_ONCE = 128
"""Steps whose waves are summed together."""
_NODE = PARTS // (NODES - 1)
_QUARTERS = np.arange(float(NODES))
_MASK = (1 << -SHORTEST) - 1
"""Ticks of a recorded step: steps are counted in its 2^SHORTEST-th part."""


class Step(NamedTuple):
    """A step from z under f at the nodes: z at the end of each part is free_i z + forced_i f."""

    span: float  # [s]
    free: FloatArray  # (part, state, state)
    forced: FloatArray  # (part, state, NODES free)


def step_of(matrix: FloatArray, inputs: FloatArray, span: float, parts: int) -> Step:
    """Return the matrices of a step of z' = A z + B f of so many parts, A (state, state) and B (state, free)."""
    part, width = phi_integrals(matrix, inputs, span / parts, NODES), (NODES - 1) / parts
    basis = lagrange(np.arange(float(NODES)))
    order, free = inputs.shape
    whole, forced = [part.exponential], []
    response = np.zeros((order, NODES * free))
    for i in range(parts):
        own = part.of_polynomials(_shifted(basis, i * width, width), part.span).reshape(NODES * free, order).T
        response = part.exponential @ response + own
        forced.append(response)
        whole.append(part.exponential @ whole[-1])
    return Step(span, np.array(whole[:parts]), np.array(forced))


def _shifted(coefficients: FloatArray, begin: float, unit: float) -> FloatArray:
    """Coefficients of s^j of polynomials of begin + unit s, shape (power, polynomial)."""
    k = np.arange(len(coefficients))
    binomial = comb(k, k[:, None]) * begin ** np.maximum(k - k[:, None], 0.0)
    return np.asarray(unit ** k[:, None] * (binomial @ coefficients))


def _at(instants: FloatArray) -> FloatArray:
    """Values at instants, in quarters of the step, from those at the nodes, shape (instant, NODES)."""
    return np.vander(instants, NODES, increasing=True) @ lagrange(np.arange(float(NODES)))


class Samples(NamedTuple):
    """What depends on time alone, at all parts of some steps of one level."""

    first: int  # tick
    waves: FloatArray  # (instant, free)
    added: Callable[[FloatArray, slice], FloatArray]  # n at rows of the instants


_AT_PROBE = _at(np.array([PROBE * (NODES - 1) / PARTS]))[0]


@dataclass(frozen=True)
class Collocation:
    """Steps of a system between recorded instants."""

    system: System
    dt: float  # between recorded instants [s]
    begin: float = 0.0  # the first of them [s]
    _steps: dict[int, Step] = field(default_factory=dict, init=False)  # made so far, by level
    _samples: dict[int, Samples] = field(default_factory=dict, init=False)  # the last ones of each level

    def step(self, level: int) -> Step:
        """Return the step of dt 2^level."""
        if level not in self._steps:
            self._steps[level] = step_of(
                self.system.matrix, self.system.input, self.dt * 2.0**level, max(PARTS, 2 ** max(level, 0))
            )
        return self._steps[level]

    def samples(self, level: int, tick: int) -> tuple[Samples, int]:
        """Return samples of the step of a level from a tick on, and the row it begins with; of many steps at once."""
        span, count = 1 << (level - SHORTEST), AT_ONCE if level >= 0 else 1
        have = self._samples.get(level)
        if have is None or not have.first <= tick < have.first + count * span or (tick - have.first) % span:
            instants = self.begin + self.dt * (tick + span / PARTS * np.arange(count * PARTS + 1)) * 2.0**SHORTEST
            have = Samples(tick, self.system.wave_forcing(instants), self.system.added_during(instants))
            self._samples[level] = have
        return have, (tick - have.first) // span * PARTS

    def met(self, level: int, tick: int, z: FloatArray, f: FloatArray, limit: float) -> tuple[FloatArray, float]:
        """Return f at the nodes and the error of a step from z on: infinite if f does not converge, the step too long.

        Of a first guess f (NODES, free), exact at the start of the step, which begins at a tick. The error is that of
        the polynomial at the probe, over all of the step; f may be off by a part of its limit.
        """
        step, (samples, row) = self.step(level), self.samples(level, tick)
        parts, rows = len(step.free), slice(row + _NODE, row + PARTS + 1, _NODE)
        nodes = np.arange(1, NODES) * (parts // (NODES - 1)) - 1  # parts that end there
        values, before = f.copy(), np.inf
        free, forced, waves = step.free[nodes] @ z, step.forced[nodes], samples.waves[rows]
        for _ in range(SWEEPS):
            new = samples.added(free + forced @ values.ravel(), rows) + waves
            change = step.span * float(np.linalg.norm(new - values[1:]))
            values[1:] = new
            if change <= MET * limit + ROUND_OFF * step.span * float(np.linalg.norm(values)):
                part, at = parts * PROBE // PARTS - 1, row + PROBE
                there = step.free[part] @ z + step.forced[part] @ values.ravel()
                actual = samples.added(there[None], slice(at, at + 1))[0] + samples.waves[at]
                return values, step.span * float(np.linalg.norm(actual - _AT_PROBE @ values))
            if not change < 0.9 * before:
                break
            before = change
        return f, np.inf

    def run(self, time: FloatArray, first: FloatArray, tolerance: float) -> tuple[FloatArray, int]:
        """Return the states at recorded instants, shape (time, state), and the number of steps tried.

        Raises `ConvergenceError` if steps have to be shorter than dt 2^`SHORTEST`.
        """
        horizon, last = min(self.system.horizon, float(time[-1] - time[0])), (len(time) - 1) << -SHORTEST
        out, z = np.zeros((len(time), len(first))), first
        f = np.tile(self.system.forcing(time[:1], first[None]), (NODES, 1))
        out[0], tick, level, steps, left = first, 0, 0, 0, 0.0
        largest = max(float(np.linalg.norm(first)), self.system.least, self.dt * float(np.linalg.norm(f[0])))
        while tick < last:
            level = min(level, (last - tick).bit_length() - 1 + SHORTEST)
            step = self.step(level)
            share = tolerance * largest * min(step.span / horizon, 1.0)
            f, error = self.met(level, tick, z, f, share)
            steps += 1
            if not error <= share + SPENT * left:
                if level == SHORTEST:
                    shortest = self.dt * 2.0**SHORTEST
                    raise ConvergenceError(
                        f"the motion cannot be followed at t = {self.begin + tick * shortest:.6g} s: the step became "
                        f"shorter than {shortest:.1e} s; check the study for forces that jump, or raise "
                        "simulation.tolerance."
                    )
                level, f = level - 1, _at(_QUARTERS / 2) @ f
                continue
            ends, span = step.free @ z + step.forced @ f.ravel(), 1 << (level - SHORTEST)
            tick, z, left = tick + span, ends[-1], max(left + share - error, 0.0)
            if level >= 0:  # the recorded ones of the ends
                parts, record = len(ends) >> level, 1 + (tick >> -SHORTEST)
                out[record - (1 << level) : record] = ends[parts - 1 :: parts]
            elif not tick & _MASK:
                out[tick >> -SHORTEST] = z
            largest = max(largest, float(np.linalg.norm(z)))
            twice = level < LONGEST and error * GROWTH < share and tick % (2 * span) == 0
            level, f = level + twice, _at((NODES - 1) + _QUARTERS * (1 + twice)) @ f
        return out, steps


def collocated(system: System, time: FloatArray, start: tuple[FloatArray, ...], tolerance: float) -> tuple[Motion, int]:
    """Return the motion of a scene with any smooth forces at equally spaced times, and the number of steps tried.

    Parameters and errors of `vsb.engine.integrators.exponential.integrate`; for a scene with or without water.
    """
    system.check_smooth()
    method, first = Collocation(system, float(time[1] - time[0]), float(time[0])), system.first(start)
    system.forcing(time[:1], first[None])  # the water compiles or loads: no part of the motion's seconds
    begun = clock.perf_counter()
    states, steps = method.run(time, first, tolerance)
    return system.motion(time, states, system.forcing(time, states), clock.perf_counter() - begun), steps
