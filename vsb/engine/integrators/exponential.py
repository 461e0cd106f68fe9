"""Exponential Adams method of order 6 for a body-exact scene, compiled.

In z' = A z + B n(t, z) the matrix A holds elasticity, damping, memory and the tangent of the water's force, so stiff
modes do not limit the step; n is smooth and small and depends on positions alone. It becomes the polynomial through its
values at equally spaced instants, for which

    z(t + d) = exp(d A) z(t) + int_0^d exp((d - s) A) B n(t + s) ds

is exact: five past values predict, one evaluation corrects, one more value gives the error. Steps are the recorded
ones, or every 2^k-th or 2^-k-th of them; recorded instants between them follow from the same polynomial. The error of a
step may be its share of the tolerance, d over the time in which errors add up; what a step leaves of its share is
saved for the few steps that meet a kink, such as a keel that leaves the water.

The integrals P_k(h) = int_0^h exp((h - s) A) B s^(k-1)/(k-1)! ds = h^k phi_k(hA) B come from Taylor's series where
|A| h is small, and from there by doubling the span,

    exp(2hA) = exp(hA)^2,    P_k(2h) = exp(hA) P_k(h) + sum_{j <= k} h^(k-j)/(k-j)! P_j(h).
"""

import time as clock
from dataclasses import dataclass, field
from math import factorial
from typing import Any, NamedTuple

import numpy as np
from scipy.special import comb

from vsb.engine.motion.system import Motion, Remainder, System, remainder
from vsb.errors import ConvergenceError
from vsb.tools.arrays import FloatArray
from vsb.tools.compiled import assign, njit

_SMALL, _TERMS = 0.5, 16  # 0.5^16/16! is below round-off


class PhiIntegrals(NamedTuple):
    """exp(hA) and P_k(h), k = 1, 2, ... of one span."""

    span: float  # h [s]
    exponential: FloatArray  # (state, state)
    integrals: FloatArray  # (k, state, input)

    def of_polynomials(self, coefficients: FloatArray, unit: float) -> FloatArray:
        """Return int_0^h exp((h-s) A) B l_i(s/unit) ds of polynomials l_i, shape (polynomial, input, state).

        Coefficients (power, polynomial) are of x^power in l_i(x). Transposed: products with the result run along the
        state.
        """
        powers = range(len(coefficients))
        scaled = coefficients * np.array([[factorial(k) / unit**k] for k in powers])
        response = np.tensordot(scaled.T, self.integrals[: len(coefficients)], 1)
        return np.ascontiguousarray(response.transpose(0, 2, 1))


def phi_integrals(a: FloatArray, b: FloatArray, h: float, count: int) -> PhiIntegrals:
    """Return exp(hA) and P_k(h), k = 1..count, of A (state, state) [1/s], B (state, input) and h [s]."""
    if not is_small(a, h):
        return doubled(phi_integrals(a, b, h / 2, count))
    terms = [np.hstack([np.eye(len(a)), b])]
    for _ in range(_TERMS):
        terms.append(h * a @ terms[-1])
    weights = np.array([[h**k / factorial(k + j) for j in range(_TERMS + 1)] for k in range(count + 1)])
    series = np.tensordot(weights, np.array(terms), 1)
    return PhiIntegrals(h, series[0, :, : len(a)], series[1:, :, len(a) :])


def is_small(a: FloatArray, h: float) -> bool:
    """Whether Taylor's series of exp(hA) needs no scaling."""
    return bool(np.linalg.norm(a, 1) * h <= _SMALL)


def doubled(half: PhiIntegrals) -> PhiIntegrals:
    """Return exponential and integrals of twice the span."""
    h, e, p = half
    count = len(p)
    shift = np.array([[h ** (k - j) / factorial(k - j) if j <= k else 0.0 for j in range(count)] for k in range(count)])
    return PhiIntegrals(2 * h, e @ e, e @ p + np.tensordot(shift, p, 1))


def lagrange(nodes: FloatArray) -> FloatArray:
    """Return the coefficients of x^k in the Lagrange polynomials of some nodes, shape (k, node)."""
    return np.linalg.inv(np.vander(nodes, increasing=True))


PAST = 5
"""Past values of n that predict; more, with one evaluation a step, are unstable with shell modes."""
KEPT = PAST + 1
"""Past values that a step reads: one more for its error."""
HISTORY = 2 * KEPT - 1
"""Past values of which every other one serves a step twice as long."""
LONGEST = 10  # nodes are at most 2^10 recorded instants apart
SHORTEST = -20
SAFE = 5.0
"""Errors of successive steps differ in sign: so many times the share of each still adds up to the tolerance."""
SPENT = 0.1
"""Part of what has been put aside that one step at a kink may take."""
GROWTH = 100.0
"""Twice the step makes 2^6 times the error per time; the rest is a margin."""
STARTS = 30
"""Turns of the starting procedure, at most."""
PROBE = 0.618
"""Where in a step positions are looked at: a ring that all nodes meet in one phase is seen there."""

Counters = np.ndarray[Any, np.dtype[np.int64]]
TICK, KNOWN, STEPS, EVALUATIONS, TROUBLED = range(5)
"""Counters: time in 2^SHORTEST records; past values known; steps tried; evaluations; steps since a failure."""
LARGEST, PEAK, ASIDE = range(3)
"""Levels: largest norm of the state; error over its share, of late; error put aside."""


def _values(nodes: FloatArray, at: FloatArray) -> FloatArray:
    """Lagrange polynomials of some nodes at some points, shape (point, node)."""
    return np.ascontiguousarray(np.vander(at, len(nodes), increasing=True) @ lagrange(nodes))


_BACK = -np.arange(float(KEPT))
_CORRECTOR = lagrange(np.append(1.0, _BACK[:PAST]))
_AHEAD = _values(_BACK[:PAST], np.ones(1))[0]
_AHEAD_BY_ALL = _values(_BACK, np.ones(1))[0]
_HALVED = np.hstack([_values(_BACK, _BACK / 2), np.zeros((KEPT, HISTORY - KEPT))])
_DOUBLED = np.eye(HISTORY)[::2].copy()
_REVERSED = _values(-_BACK, _BACK)
_AT_PROBE = _values(np.append(1.0, _BACK[:PAST]), np.array([PROBE]))[0]
_SHIFT = np.ascontiguousarray(comb(np.arange(KEPT), np.arange(KEPT)[:, None]))  # of a polynomial by one


class Step(NamedTuple):
    """Matrices of a step of size d; transposed, so that products run along the state. n acts on the velocity rows."""

    spacing: float  # d [s]
    free: FloatArray  # exp(dA) (state, state)
    forced: FloatArray  # response to the past values (PAST, free, state)
    corrected: FloatArray  # to what the prediction of the new value missed (free, state)
    missed: FloatArray  # to that of the prediction by one more (free, state)
    probe_free: FloatArray  # positions at `PROBE` (state, free)
    probe_forced: FloatArray  # (KEPT, free, free)
    record_free: FloatArray  # from one recorded instant to the next (state, state)
    record_forced: FloatArray  # to the coefficients of the polynomial, in recorded instants (KEPT, free, state)
    coefficients: FloatArray  # these coefficients from new and past values (KEPT, KEPT)


@njit(cache=True)
def _add(out: FloatArray, matrix: FloatArray, vector: FloatArray) -> None:
    """Add vector @ matrix."""
    for i in range(len(vector)):
        for j in range(len(out)):
            out[j] += vector[i] * matrix[i, j]


@njit(cache=True)
def _size(vector: FloatArray) -> float:
    """Euclidean norm."""
    square = 0.0
    for i in range(len(vector)):
        square += vector[i] * vector[i]
    return float(np.sqrt(square))


@njit(cache=True)
def _mixed(weights: FloatArray, rows: FloatArray) -> FloatArray:
    """Return weights @ rows."""
    out = np.zeros(rows.shape[1])
    for i in range(len(weights)):
        for j in range(len(out)):
            out[j] += weights[i] * rows[i, j]
    return out


@njit(cache=True)
def _beyond(value: FloatArray, weights: FloatArray, rows: FloatArray) -> FloatArray:
    """Return value - weights @ rows."""
    out = _mixed(weights, rows)
    for j in range(len(out)):
        out[j] = value[j] - out[j]
    return out


@njit(cache=True)
def _predicted(step: Step, z: FloatArray, past: FloatArray) -> FloatArray:
    """State at the end of a step by the past values of n alone."""
    out = np.zeros(len(z))
    _add(out, step.free, z)
    for i in range(PAST):
        _add(out, step.forced[i], past[i])
    return out


@njit(cache=True)
def _norm_of(matrix: FloatArray, vector: FloatArray) -> float:
    """Norm of vector @ matrix."""
    out = np.zeros(matrix.shape[1])
    _add(out, matrix, vector)
    return _size(out)


@njit(cache=True, inline="always")
def _started(r: Remainder, step: Step, t: float, z: FloatArray, limit: float, past: FloatArray) -> int:
    """Fill the past of the first step with a polynomial that its own steps reproduce; return the evaluations, or -1.

    The past of the start need not have happened: it continues backwards what the first steps find.
    """
    nodes, here, own = np.empty((KEPT, past.shape[1])), np.empty(past.shape[1]), past.copy()
    state, enough, i, turn = z, 0.0, 0, 0
    while True:  # the water's force is called in one place: its code is large
        remainder(r, t + i * step.spacing, state, here)
        if i == KEPT:
            fits = _norm_of(step.missed, _beyond(here, _AHEAD_BY_ALL, own)) < 0.1 * limit
            return 2 + turn * PAST if fits else -1
        assign(nodes[i], here)
        if i == 0:
            enough = 0.1 * limit + 1e-11 * _size(here) * step.spacing  # what continuing makes of round-off
            for k in range(len(past)):
                assign(past[k], here)
        else:
            _add(state, step.corrected, _beyond(here, _AHEAD, own))
            _put_first(own, here)
        i += 1
        if i == KEPT:
            change, turn = np.zeros(len(z)), turn + 1
            for k in range(KEPT):
                older = _mixed(_REVERSED[k], nodes)
                for j in range(len(older)):
                    past[k, j] = older[j] - past[k, j]
                if k < PAST:
                    _add(change, step.forced[k], past[k])
                assign(past[k], older)
            size = _size(change)
            if not size < enough:
                if turn == STARTS or not size < 1e300:
                    return -1
                i = 1
        if i == 1:
            state = z
            for k in range(KEPT):
                assign(own[k], past[k])
        state = _predicted(step, state, own)


@njit(cache=True, inline="always")
def _unseen(
    r: Remainder, step: Step, t: float, z: FloatArray, nodes: FloatArray, places: FloatArray, limit: float
) -> tuple[float, int]:
    """Error by what n does between nodes, and the evaluations this took: none where positions there fit those at nodes.

    `nodes` and `places` hold n and positions at the new node and the past ones. What n makes of a position unforeseen
    is at most of the order of the tangent's force.
    """
    position = np.zeros(nodes.shape[1])
    _add(position, step.probe_free, z)
    for i in range(KEPT):
        _add(position, step.probe_forced[i], nodes[i])
    stray, felt = _beyond(position, _AT_PROBE, places), np.zeros(len(position))
    for i in range(len(felt)):
        for j in range(len(stray)):
            felt[i] += r.tangent[i, j] * stray[j]
    if _norm_of(step.corrected, felt) < 0.2 * limit:
        return 0.0, 0
    between = np.empty(len(position))
    remainder(r, t + PROBE * step.spacing, position, between)
    return _norm_of(step.corrected, _beyond(between, _AT_PROBE, nodes)), 1


@njit(cache=True)
def _record(
    step: Step, z: FloatArray, nodes: FloatArray, first: int, count: int, out: FloatArray, pushes: FloatArray
) -> None:
    """Fill states and n at recorded instants inside a step, from the polynomial through new and past values."""
    course = np.zeros((KEPT, nodes.shape[1]))
    for i in range(KEPT):
        _add(course[i], nodes, step.coefficients[i])
    state = z
    for k in range(first, min(first + count, len(out))):
        _add(out[k], step.record_free, state)
        for i in range(KEPT):
            _add(out[k], step.record_forced[i], course[i])
            for j in range(i + 1, KEPT):  # from here on in instants since this one
                for m in range(course.shape[1]):
                    course[i, m] += _SHIFT[i, j] * course[j, m]
        state = out[k]
        assign(pushes[k], course[0])


@njit(cache=True)
def _resized(past: FloatArray, weights: FloatArray) -> None:
    """Past values at another distance: `_DOUBLED`, or `_HALVED`."""
    old = past.copy()
    for i in range(KEPT):
        assign(past[i], _mixed(weights[i], old))


@njit(cache=True)
def _put_first(past: FloatArray, newest: FloatArray) -> None:
    """Move past values on and put the newest before them."""
    for i in range(len(past) - 1, 0, -1):
        assign(past[i], past[i - 1])
    assign(past[0], newest)


@njit(cache=True)
def march(
    r: Remainder, step: Step, dt: float, level: int, tolerance: float, horizon: float, z: FloatArray, past: FloatArray,
    places: FloatArray, counters: Counters, levels: FloatArray, out: FloatArray, pushes: FloatArray,
) -> int:  # fmt: skip
    """Take steps of one size until the end, or until another size is better; +1: twice, -1: half, 0: the end.

    z is the state, `past` and `places` hold n and positions at it and before, the newest first. All arrays are
    carried on.
    """
    per_record = 1 << -SHORTEST
    span, last = 1 << (level - SHORTEST), (len(out) - 1) * per_record
    free = past.shape[1]
    new, nodes, seen = np.empty(free), np.empty((KEPT, free)), np.empty((KEPT, free))
    while counters[TICK] < last:
        t = counters[TICK] / per_record * dt
        limit = SAFE * tolerance * levels[LARGEST] * min(step.spacing / horizon, 1.0) + r.round_off * step.spacing
        allowed = limit + SPENT * levels[ASIDE] * (counters[TROUBLED] > 0)
        if counters[KNOWN] == 0:
            made = _started(r, step, t, z, allowed, past)
            if made < 0:
                counters[TROUBLED] = HISTORY
                return -1
            counters[KNOWN], counters[EVALUATIONS] = KEPT, counters[EVALUATIONS] + made
            for i in range(len(places)):
                assign(places[i], z)
        end = _predicted(step, z, past)
        remainder(r, t + step.spacing, end, new)
        counters[STEPS], counters[EVALUATIONS] = counters[STEPS] + 1, counters[EVALUATIONS] + 1
        _add(end, step.corrected, _beyond(new, _AHEAD, past))
        error = _norm_of(step.missed, _beyond(new, _AHEAD_BY_ALL, past))
        assign(nodes[0], new)
        assign(seen[0], end)
        for i in range(PAST):
            assign(nodes[i + 1], past[i])
            assign(seen[i + 1], places[i])
        if error < allowed:
            more, looked = _unseen(r, step, t, z, nodes, seen, limit)
            error += more
            counters[EVALUATIONS] += looked
        if not error < allowed:
            # interpolated values that fail once more are given up: the step starts anew
            counters[KNOWN] = KEPT if counters[KNOWN] > KEPT else 0
            _resized(past, _HALVED)
            _resized(places, _HALVED)
            levels[PEAK], counters[TROUBLED] = 0.0, HISTORY
            return -1
        first = counters[TICK] // per_record + 1
        counters[TICK], counters[TROUBLED] = counters[TICK] + span, max(counters[TROUBLED] - 1, 0)
        if level > 0:
            _record(step, z, nodes, first, (span // per_record) - 1, out, pushes)
        if counters[TICK] % per_record == 0 and counters[TICK] <= last:
            assign(out[counters[TICK] // per_record], end)
            assign(pushes[counters[TICK] // per_record], new)
        assign(z, end)
        _put_first(past, new)
        _put_first(places, end)
        counters[KNOWN] = min(counters[KNOWN] + 1, HISTORY)
        levels[LARGEST] = max(levels[LARGEST], _size(end))
        levels[ASIDE] = min(levels[ASIDE] + limit - error, SAFE * tolerance * levels[LARGEST])
        levels[PEAK] = max(0.95 * levels[PEAK], error / limit)
        aligned = counters[TICK] % min(2 * span, per_record) == 0
        if levels[PEAK] < 1 / GROWTH and aligned and level < LONGEST and counters[KNOWN] == HISTORY:
            _resized(past, _DOUBLED)
            _resized(places, _DOUBLED)
            counters[KNOWN], levels[PEAK] = KEPT, 0.0
            return 1
    return 0


class Run(NamedTuple):
    """Recorded states of a run, and what it took."""

    states: FloatArray  # (time, state)
    pushes: FloatArray  # n (time, free)
    steps: int  # tried
    evaluations: int  # of n


@dataclass(frozen=True)
class ExponentialIntegrator:
    """Steps of a body-exact system from one recorded instant to the next."""

    system: System
    dt: float  # between recorded instants [s]
    begin: float = 0.0  # the first of them [s]
    _integrals: dict[tuple[float, int], PhiIntegrals] = field(default_factory=dict, init=False)  # by unit and level

    @property
    def remainder(self) -> Remainder:
        """Arguments of the compiled n and waves; `ValueError` of a linear scene."""
        water = self.system.remainder
        if water is None:
            raise ValueError("exponential steps: needs a scene with water pressure; use propagate for a linear one.")
        return water._replace(diffraction=self.system.waves_sampler.held, begin=self.begin)

    def integrals(self, unit: float, level: int) -> PhiIntegrals:
        """Integrals over unit 2^level, twice those of half the span."""
        key, a, h = (unit, level), self.system.matrix, unit * 2.0**level
        if key not in self._integrals and is_small(a, h):
            self._integrals[key] = phi_integrals(a, self.system.input, h, KEPT + 1)
        elif key not in self._integrals:
            self._integrals[key] = doubled(self.integrals(unit, level - 1))
        return self._integrals[key]

    def step(self, level: int) -> Step:
        """Matrices of a step of dt 2^level."""
        whole, record, free = self.integrals(self.dt, level), self.integrals(self.dt, 0), self.system.free
        part = self.integrals(PROBE * self.dt, level)
        newest = lagrange(np.append(1.0, _BACK))[:, 0]  # the polynomial that is 1 at the new node, 0 at all the past
        corrected = whole.of_polynomials(_CORRECTOR[:, :1], whole.span)[0]
        return Step(
            whole.span,
            np.ascontiguousarray(whole.exponential.T),
            whole.of_polynomials(lagrange(_BACK[:PAST]), whole.span),
            corrected,
            whole.of_polynomials(newest[:, None], whole.span)[0] - corrected,
            np.ascontiguousarray(part.exponential[:free].T),
            np.ascontiguousarray(part.of_polynomials(_CORRECTOR, whole.span)[..., :free]),
            np.ascontiguousarray(record.exponential.T),
            record.of_polynomials(np.eye(KEPT), record.span),
            _CORRECTOR * (record.span / whole.span) ** np.arange(KEPT)[:, None],
        )

    def run(self, first: FloatArray, count: int, tolerance: float) -> Run:
        """Return the states at `count` recorded instants.

        Raises `ConvergenceError` if steps have to be shorter than dt 2^-20.
        """
        free = self.system.free
        run = Run(np.zeros((count, len(first))), np.zeros((count, free)), 0, 0)
        z, past, places = first.copy(), np.zeros((HISTORY, free)), np.zeros((HISTORY, free))
        largest = max(float(np.linalg.norm(first)), self.system.least)
        counters, levels = np.array([0, 0, 0, 0, HISTORY]), np.array([largest, 0.0, tolerance * largest])
        run.states[0], steps = first, {}
        duration, water = self.dt * (count - 1), self.system.scene.water
        r, end = self.remainder, self.begin + duration
        assert water is not None
        waves = water.waves_during(self.begin, end) or r.waves
        r = r._replace(waves=waves, diffraction=self.system.waves_sampler.during(self.begin, end))
        remainder(r, 0.0, first, run.pushes[0])
        level, change, horizon = -1, 1, min(duration, self.system.horizon)
        while change:
            if level < SHORTEST:
                shortest = self.dt * 2.0**SHORTEST
                raise ConvergenceError(
                    f"the motion cannot be followed at t = {self.begin + counters[TICK] * shortest:.6g} s: the step "
                    f"became shorter than {shortest:.1e} s; check the study for loads that crush the shell or a "
                    "spring below zero that drives the buoy out of the water, or raise simulation.tolerance."
                )
            if level not in steps:
                steps[level] = self.step(level)
            change = march(
                r, steps[level], self.dt, level, tolerance, horizon, z, past, places, counters, levels, run.states,
                run.pushes,
            )  # fmt: skip
            level += change
        return run._replace(steps=int(counters[STEPS]), evaluations=int(counters[EVALUATIONS]) + 1)


def integrate(system: System, time: FloatArray, start: tuple[FloatArray, ...], tolerance: float) -> tuple[Motion, int]:
    """Return the motion of a body-exact scene at equally spaced times, and the number of steps tried.

    Raises `ConvergenceError` if the motion cannot be followed; `ValueError` if the scene is linear or a force switches.

    Parameters
    ----------
    time, start
        See `vsb.engine.integrators.exact.propagate`.
    tolerance : float
        Of the error of the motion, relative to the largest norm of the state so far: the root of twice its energy.
    """
    system.check_compiled()
    method = ExponentialIntegrator(system, float(time[1] - time[0]), float(time[0]))
    if not march.signatures:  # type: ignore[attr-defined]  # compile or load: no part of the motion's seconds
        method.run(np.zeros(len(system.matrix)), 2, 1.0)
        method = ExponentialIntegrator(system, method.dt, method.begin)
    begun = clock.perf_counter()
    run = method.run(system.first(start), len(time), tolerance)
    return system.motion(time, run.states, run.pushes, clock.perf_counter() - begun), run.steps
