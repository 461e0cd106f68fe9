"""One linear regime of a switching take-off: its motion over any span, and the signals its switches depend on.

While a take-off keeps to one piece of its law, F = -(c V + k S) + f at the port, or holds it at rest, the scene is

    z' = A z + B (beta f + n + Re sum w_j exp(-i omega_j t)),    S = (beta/s).z,  V = beta.p',

with beta = shapes^T b, s the scale of the modes and constant c, k, f. In a linear scene n = 0, and z - z_s =
exp(A (t - t_0)) (z - z_s)(t_0) about the steady response z_s to the waves has no step-size error. f is one more,
constant state.

In a body-exact scene n(t, z) is what the water does beyond its tangent. Over one or more steps it is the polynomial of
degree four through its values at five equally spaced instants of the motion it causes: exponential collocation, of
order 6. Its Taylor coefficients are states like f, so the motion inside is that of a linear system, known at every
instant an event may need, to the same order. No past is needed: a polynomial starts afresh after each event.

Works are integrated between the nodes of a run, the instants of the lookout and the events. Between two of them every
force is smooth, and states and their first two derivatives are known at both, z' = A z + B g and z'' = A z' + B g'.
Power P has then a rule of order six,

    int P dt = h/2 (P0 + P1) + h^2/10 (P0' - P1') + h^3/120 (P0'' + P1''):

work along the exact motion, against which what the states store is audited. Work of the water beyond its tangent is
the waves' work, except the part that is stored.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import factorial
from typing import NamedTuple

import numpy as np

from vsb.engine.integrators.exact import SERIES, steady_state, transition
from vsb.engine.integrators.exponential import phi_integrals
from vsb.engine.motion.system import Controller, Remainder, System, remainder
from vsb.engine.waves.sampling import Sampler, signals, signals_along
from vsb.engine.waves.seas import superposed
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray
from vsb.tools.compiled import assign, njit

# the force n(t, y) at the nodes of an implicit step, whose positions depend on it -------------------------------------


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
        assign(missing[known * free :], force[: nodes - known].ravel() - now[known * free :])
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


# regimes ------------------------------------------------------------------------------------------------------------


AHEAD = 128
"""Most instants computed ahead at a time."""


class Signals(NamedTuple):
    """Signals that switches depend on, each shape (time,)."""

    stroke: FloatArray  # S [m]
    velocity: FloatArray  # V [m/s]
    net_force: FloatArray  # net force of all but the take-off on a port that is held [N]
    remembered: FloatArray  # C x of a controller [N]
    remembered_rate: FloatArray  # its rate [N/s]


@dataclass(frozen=True, eq=False)
class Phase:
    """A scene with a damper, a spring and a controller at its port, or with the port held; states are (z, f)."""

    system: System  # without the take-off
    port: FloatArray  # beta (free,)
    damping: float  # c [N s/m]
    stiffness: float  # k [N/m]
    held: bool
    step: float  # between the instants of a run, the longest span [s]
    rest: float = 0.0  # S at rest, from which it is measured [m]
    output: float = 0.0  # part of the output of a controller's states that acts: all or nothing
    controller: Controller | None = None

    carried = 0
    """Further states per mode: none in a linear scene."""

    @property
    def reach(self) -> int:
        """Most steps that can be computed ahead."""
        return AHEAD

    @cached_property
    def free_rates(self) -> FloatArray:
        """Rates of p' of a port that is not held, shape (free, state + 1)."""
        n = self.system.free
        return np.pad(self.system.matrix[n : 2 * n], ((0, 0), (0, 1))) + np.outer(self.port, self.load)

    @cached_property
    def load(self) -> FloatArray:
        """Row of the force on the port over (z, f), shape (state + 1,)."""
        n, row = self.system.free, -self.output * self.remembered
        row[:n] -= self.stiffness * self.port / self.system.scale
        row[n : 2 * n] -= self.damping * self.port
        row[-1] = 1.0
        return np.asarray(row)

    @cached_property
    def remembered(self) -> FloatArray:
        """Row of the output of the controller's states over (z, f), shape (state + 1,)."""
        own = np.zeros(0) if self.controller is None else self.controller.output
        return np.concatenate([np.zeros(len(self.system.matrix) - len(own)), own, np.zeros(1)])

    @property
    def allowed(self) -> FloatArray:
        """Projector of rates of p' on those that leave a held port at rest, shape (free, free)."""
        unit = self.port / np.linalg.norm(self.port) * self.held
        return np.eye(self.system.free) - np.outer(unit, unit)

    @cached_property
    def matrix(self) -> FloatArray:
        """A of (z, f), shape (state + 1, state + 1)."""
        n, order = self.system.free, len(self.system.matrix)
        out = np.zeros((order + 1, order + 1))
        out[:order, :order] = self.system.matrix
        out[n : 2 * n] = self.allowed @ self.free_rates
        if self.controller is not None:
            out[order - len(self.controller.output) : order] -= np.outer(self.controller.of_force, self.load)
        return out

    @cached_property
    def flow(self) -> FloatArray:
        """Generator of (z, f, ...); the states beyond f are a force and its derivatives in units of the step."""
        n, count = self.system.free, len(self.matrix)
        out = np.zeros((count + self.carried * n, count + self.carried * n))
        out[:count, :count] = self.matrix
        if self.carried:
            out[n : 2 * n, count : count + n] = self.allowed
            out[count:, count:] = np.kron(np.eye(self.carried, k=1), np.eye(n)) / self.step
        return out

    @cached_property
    def swing(self) -> ComplexArray:
        """Phasors of z_s, shape (component, state)."""
        regime = replace(self.system, matrix=self.matrix[:-1, :-1], waves=self.system.waves @ self.allowed)
        return steady_state(regime)

    @cached_property
    def signals(self) -> FloatArray:
        """Rows of the signals over (z, f), shape (5, state + 1)."""
        n, out = self.system.free, np.zeros((5, len(self.matrix)))
        out[0, :n] = self.port / self.system.scale
        out[1, n : 2 * n] = self.port
        out[2] = self.port @ self.free_rates / (self.port @ self.port)
        out[3] = self.remembered
        out[4] = self.remembered @ self.matrix
        return out

    @cached_property
    def steady(self) -> Sampler:
        """Z_s, and the waves along the port over beta^2."""
        along = self.system.waves @ self.port / (self.port @ self.port)
        return Sampler(signals(self.system.omega, np.column_stack([self.swing, along])))

    def swung(self, time: FloatArray) -> FloatArray:
        """Return z_s and the waves along the port over beta^2 at some instants, shape (time, state + 1)."""
        held = self.steady.during(float(time[0]), float(time[-1]))
        return np.asarray(signals_along(held, np.ascontiguousarray(time)))

    def transient(self, t: float, state: FloatArray) -> FloatArray:
        """Return (z - z_s, f, ...) at an instant of (z, f, ...)."""
        out, order = state.copy(), len(self.system.matrix)
        out[:order] -= self.swung(np.array([t]))[0, :-1]
        return out

    def states(self, time: FloatArray, transients: FloatArray) -> FloatArray:
        """Return (z, f, ...) at some instants, of transients (z - z_s, f, ...), shape (time, state + ...)."""
        out, order = transients.copy(), len(self.system.matrix)
        out[:, :order] += self.swung(time)[:, :-1]
        return out

    def watched(self, time: FloatArray, states: FloatArray) -> Signals:
        """Return the signals of (z, f, ...) at some instants."""
        count, n = len(self.matrix), self.system.free
        wave = self.swung(time)[:, -1]
        stroke, velocity, net_force, *remembered = self.signals @ states[:, :count].T
        if self.carried:
            wave = wave + states[:, count : count + n] @ self.port / (self.port @ self.port)
        return Signals(stroke - self.rest, velocity, net_force + wave, *remembered)

    def begun(self, t: float, state: FloatArray, steps: int, limit: float) -> tuple[FloatArray, float]:
        """Return (z, f, ...) at the start of some steps, and the error of z at their end: none in a linear scene."""
        return state, 0.0

    def added(self, states: FloatArray) -> FloatArray:
        """Return n and two derivatives in time, shape (3, node, free): zero in a linear scene."""
        return np.zeros((3, len(states), self.system.free))

    def reset(self, state: FloatArray, t: float) -> FloatArray:
        """Return the state of a run that starts: unchanged in a linear scene."""
        return state

    def net_force(self, states: FloatArray, waves: FloatArray, constant: float) -> FloatArray:
        """Return the net force of states z under waves on the modes, shape (time,) [N]."""
        row = self.signals[2]
        return np.asarray(
            states[:, : len(row) - 1] @ row[:-1] + waves @ self.port / (self.port @ self.port) + row[-1] * constant
        )

    @cached_property
    def ladder(self) -> list[FloatArray]:
        """exp(A step/2^j), j = 0, 1, ..., down to where the series needs no scaling."""
        size = np.abs(self.flow).sum(axis=0).max() * self.step
        count = max(1, int(np.ceil(np.log2(max(2 * size, 1.0)))) + 1)
        return [transition(self.flow * (self.step / 2**j)) for j in range(count)]

    @cached_property
    def ahead(self) -> FloatArray:
        """exp(A step)^m, m = 1.. `reach`, shape (reach, state + ..., state + ...)."""
        powers = [self.ladder[0]]
        while len(powers) < self.reach:
            powers.append(powers[-1] @ self.ladder[0])
        return np.array(powers)

    def later(self, transient: FloatArray, span: float) -> FloatArray:
        """Return a transient after any span up to a step: by halved steps, and a series for the rest."""
        part = self.step
        for halved in self.ladder:
            if span >= part:
                transient, span = halved @ transient, span - part
            part /= 2
        term = out = transient
        for k in range(1, SERIES + 2):
            term = self.flow @ term * (span / k)
            out = out + term
        return out


LONGEST = 32
"""Most steps under one polynomial."""
MATRICES = 2**21
"""Numbers in their matrices, at most."""
MET = 1e-2
"""Change of the last iteration over the error some steps may make."""
NODES = 5
PROBE = 0.375
"""Point of a step where n is compared with its polynomial: midway between two nodes."""
_NODE = np.linspace(0.0, 1.0, NODES)
_AT_PROBE, _AT_NODES = 2, np.array([0, 1, 3, 4, 5])
_INSTANTS = np.insert(_NODE, _AT_PROBE, PROBE)
"""Nodes and probe in order."""
_DISTANCES = np.poly(_NODE)[::-1] / np.polyval(np.poly(_NODE), PROBE)
"""Coefficients of x^k in the product of distances from the nodes, 1 at the probe."""


def taylor(at: FloatArray) -> FloatArray:
    """Return the Taylor terms at instants after the start of a step, in units of the step, shape (instant, NODES)."""
    return np.asarray(np.vander(at, NODES, increasing=True) / [float(factorial(k)) for k in range(NODES)])


_TAYLOR = taylor(_NODE)
_COEFFICIENTS = np.linalg.inv(_TAYLOR)
"""Taylor coefficients from the values at the nodes."""


class Collocation(NamedTuple):
    """Matrices of a collocation over some steps."""

    nodes: Step
    coefficients: FloatArray  # Taylor coefficients, in units of a step, from the values at the nodes (NODES, NODES)
    probe: FloatArray  # positions at `PROBE` from (z - z_s, f, coefficients) at the start (free, state + ...)
    at_nodes: FloatArray  # n at the nodes from the coefficients (NODES, NODES)
    at_probe: FloatArray  # n at the probe from the coefficients (NODES,)
    missed: FloatArray  # z at the end from what n misses there (free, state)


@dataclass(frozen=True, eq=False)
class WetPhase(Phase):
    """A scene with water on its instantaneous wet shell; states are (z, f, Taylor coefficients of n)."""

    carried = NODES
    _collocations: dict[int, Collocation] = field(default_factory=dict, init=False)  # found so far, by number of steps

    @property
    def reach(self) -> int:
        """Most steps that can be computed ahead with matrices of bounded memory, a power of 2."""
        return int(min(2 ** int(np.log2(max(MATRICES / self.flow.size, 1.0))), LONGEST))

    @cached_property
    def water(self) -> Remainder:
        """Arguments of the compiled n."""
        arguments = self.system.remainder
        assert arguments is not None
        return arguments

    def collocation(self, steps: int) -> Collocation:
        """Return the collocation over some steps."""
        if steps not in self._collocations:
            n, count, span = self.system.free, len(self.matrix), self.step * steps
            quarter, parts = transition(self.flow * (span / (NODES - 1))), [np.eye(len(self.flow))]
            while len(parts) < NODES:
                parts.append(quarter @ parts[-1])
            rows = np.array(parts)[:, :n].reshape(NODES * n, -1)
            to_taylor = _COEFFICIENTS / float(steps) ** np.arange(NODES)[:, None]
            forced = rows[:, count:] @ np.kron(to_taylor, np.eye(n))
            nodes = Step(span, np.ascontiguousarray(rows[:, :count]), np.ascontiguousarray(forced))
            order = len(self.system.matrix)
            response = phi_integrals(self.matrix[:order, :order], self.flow[:order, count : count + n], span, NODES + 1)
            self._collocations[steps] = Collocation(
                nodes,
                to_taylor,
                transition(self.flow * (span * PROBE))[:n],
                taylor(steps * _NODE),
                taylor(np.array([steps * PROBE]))[0],
                response.of_polynomials(_DISTANCES[:, None], span)[0],
            )
        return self._collocations[steps]

    def begun(self, t: float, state: FloatArray, steps: int, limit: float) -> tuple[FloatArray, float]:
        """Return (z, f, coefficients) at the start of some steps, consistent with their motion, and the error of z.

        The iteration starts from the coefficients before, and ends at a small part of the limit of the error. The error
        is what n misses at the probe, with the shape of the product of its distances from the nodes. It is infinite if
        the iteration does not converge: the steps are too long together.
        """
        count, n, z = len(self.matrix), self.system.free, state[: len(self.matrix) - 1]
        rule = self.collocation(steps)
        span, time = rule.nodes.size, t + rule.nodes.size * _INSTANTS
        water, swung = self.water, self.swung(time)[:, :-1]
        assert self.system.scene.water is not None
        if waves := self.system.scene.water.waves_during(float(time[0]), float(time[-1])):
            water = water._replace(waves=waves)
        values = rule.at_nodes @ state[count:].reshape(NODES, n)
        around = state.copy()
        around[: len(z)] -= swung[0]
        away = rule.nodes.free @ around[:count] + swung[_AT_NODES, :n].ravel()
        scale = max(float(np.linalg.norm(z)), self.system.least, span * water.round_off / STALLED)
        enough = MET * limit / scale
        change = solve_nodes(water, rule.nodes, time[_AT_NODES], away, values, scale, enough)
        if not change < max(enough, STALLED):
            return state, np.inf
        coefficients = rule.coefficients @ values
        out = np.append(state[:count], coefficients)
        around[count:] = coefficients.ravel()
        place = rule.probe @ around + swung[_AT_PROBE, :n]
        seen = added(water, time[_AT_PROBE : _AT_PROBE + 1], place[None])[0]
        missed = seen - rule.at_probe @ coefficients
        return out, float(np.linalg.norm(missed @ rule.missed)) + change * scale

    def added(self, states: FloatArray) -> FloatArray:
        """Return n and its first two derivatives in time, shape (3, node, free)."""
        coefficients = states[:, len(self.matrix) :].reshape(len(states), NODES, -1)[:, :3]
        return np.asarray(coefficients.transpose(1, 0, 2) / self.step ** np.arange(3.0)[:, None, None])

    def reset(self, state: FloatArray, t: float) -> FloatArray:
        """Return the state of a run that starts: coefficients of constant n."""
        out, n = state.copy(), self.system.free
        out[len(self.matrix) :] = 0.0
        out[len(self.matrix) : len(self.matrix) + n] = added(self.water, np.array([t]), state[None, :n].copy())[0]
        return out


# forces and works of a run ------------------------------------------------------------------------------------------


TERMS = ("wave", "pto", "structural", "radiated")
AT_ONCE = 512
"""Nodes accounted for together: what is kept of them stays in the cache."""


class LinearLaw(NamedTuple):
    """A force -(c V + k S + g C x) + f at the port, C x of a controller's states."""

    damping: float  # c [N s/m]
    stiffness: float  # k [N/m]
    constant: float  # f [N]
    output: float = 0.0  # g, 0 or 1


class Piece(NamedTuple):
    """What is in force between two events."""

    phase: Phase
    taken: LinearLaw  # by the take-off, except the force that holds the port
    stopped: LinearLaw  # by the end stop

    def jet(self, states: FloatArray, driven: FloatArray) -> FloatArray:
        """Return z, z', z'' of nodes, shape (3, node, state), from states (node, state + ...).

        `driven` are waves, what the water does beyond its tangent, and their derivatives, shape (3, node, free).
        """
        matrix, n = self.phase.matrix, self.phase.system.free
        constant = np.full((len(states), 1), self.taken.constant + self.stopped.constant)
        out = [np.hstack([states[:, : len(matrix) - 1], constant])]
        for forcing in driven[:2]:
            rates = out[-1] @ matrix.T
            rates[:, n : 2 * n] += forcing @ self.phase.allowed
            out.append(rates)
        return np.array(out)[:, :, :-1]

    def at_port(self, load: LinearLaw, jet: FloatArray) -> FloatArray:
        """Return a force on the port and its derivatives, shape (3, node)."""
        rows = load.damping * self.phase.signals[1] + load.stiffness * self.phase.signals[0]
        out = -jet @ (rows + load.output * self.phase.remembered)[:-1]
        out[0] += load.constant
        return np.asarray(out)

    def powers(self, jet: FloatArray, driven: FloatArray, lost: FloatArray, radiated: FloatArray) -> FloatArray:
        """Return the powers of `TERMS` and their derivatives, shape (term, 3, node).

        `lost` and `radiated` are the forms of structural and radiated power, each shape (state, state).
        """
        n, phase = self.phase.system.free, self.phase
        rate = jet[:, :, n : 2 * n]
        velocity = (rate @ phase.port)[:, :, None]
        taken = self.at_port(self.taken, jet)[:, :, None]
        stopped = -self.stopped.damping * velocity  # the energy of its spring is stored
        return np.array([
            product(rate, driven),
            -product(velocity, taken),
            product(jet, jet @ lost) - product(velocity, stopped),
            product(jet, jet @ radiated),
        ])  # fmt: skip


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a.b and its first two derivatives from those of a and b, shape (3, node)."""
    zero, one, two, cross = (np.einsum("ki,ki->k", a[i], b[j]) for i, j in ((0, 0), (1, 0), (2, 0), (1, 1)))
    return np.array([
        zero,
        one + np.einsum("ki,ki->k", a[0], b[1]),
        two + 2 * cross + np.einsum("ki,ki->k", a[0], b[2]),
    ])  # fmt: skip


def integrated(before: FloatArray, after: FloatArray, spans: FloatArray) -> FloatArray:
    """Return the integrals of P over spans from P, P', P'' at both ends, shape (..., 3, node) to (..., node)."""
    plus, minus = before + after, before - after
    return np.asarray(spans / 2 * plus[..., 0, :] + spans**2 / 10 * minus[..., 1, :] + spans**3 / 120 * plus[..., 2, :])


def driven_at(system: System, time: FloatArray, regular: BoolArray) -> FloatArray:
    """Return the waves and two derivatives at nodes, some equally spaced, on the modes, shape (3, node, free)."""
    phasors = np.hstack([system.waves * (-1j * system.omega[:, None]) ** k for k in range(3)])
    out = np.empty((len(time), phasors.shape[1]))
    out[regular] = superposed(system.omega, phasors, time[regular])
    others = np.flatnonzero(~regular)
    for at in np.array_split(others, 1 + len(others) // AT_ONCE):
        out[at] = np.real(np.exp(-1j * np.outer(time[at], system.omega)) @ phasors)
    return out.reshape(len(time), 3, -1).transpose(1, 0, 2)


class Account(NamedTuple):
    """A run at its nodes."""

    rates: FloatArray  # p'' (node, free)
    taken: FloatArray  # force of the take-off on the port (node,) [N]
    stopped: FloatArray  # of the end stop (node,) [N]
    works: FloatArray  # of `TERMS` since the start (term, node) [J]


def account(
    system: System,
    time: FloatArray,
    states: FloatArray,
    leaving: FloatArray,
    pieces: dict[Piece, list[int]],
    regular: BoolArray,
) -> Account:
    """Return accelerations, forces and works of a run at nodes, times (node,) [s].

    `states` are as steps end at the nodes, `leaving` as they begin there, (node, state + ...): what is carried beyond
    z and f differs. `regular` says which nodes are equally spaced.
    """
    n, last, driven = system.free, len(time) - 1, driven_at(system, time, regular)
    own, structural, radiated = system.losses()
    lost = own + structural
    rates, works = np.empty((last + 1, n)), np.zeros((len(TERMS), last + 1))
    taken, stopped = np.empty((2, last + 1))
    for piece, nodes in pieces.items():
        for at in np.array_split(np.array(nodes), 1 + len(nodes) // AT_ONCE):
            forcing = driven[:, at] + piece.phase.added(leaving[at])
            jet = piece.jet(states[at], forcing)
            rates[at], stopped[at] = jet[1][:, n : 2 * n], piece.at_port(piece.stopped, jet)[0]
            taken[at] = piece.at_port(piece.taken, jet)[0]
            if piece.phase.held:
                taken[at] = -piece.phase.net_force(states[at], forcing[0], piece.stopped.constant)
            at = at[at < last]
            received = driven[:, at + 1] + piece.phase.added(states[at + 1])
            ends = piece.jet(states[at + 1], received)
            before = piece.powers(jet[:, : len(at)], forcing[:, : len(at)], lost, radiated)
            after = piece.powers(ends, received, lost, radiated)
            works[:, at + 1] = integrated(before, after, time[at + 1] - time[at])
    return Account(rates, taken, stopped, np.cumsum(works, axis=1))
