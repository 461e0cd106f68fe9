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
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from vsb.engine.integrators.exact import SERIES, steady_state, transition
from vsb.engine.integrators.exponential import phi_integrals
from vsb.engine.integrators.implicit_force import STALLED, Step, added, solve_nodes
from vsb.engine.motion.system import Controller, Remainder, System
from vsb.engine.waves.sampling import Sampler, signals, signals_along
from vsb.tools.arrays import ComplexArray, FloatArray

AHEAD = 128
"""Most instants computed ahead at a time."""


FELT = 1e-3
"""Modes that respond less than this part of the largest to an impulse at the port are neglected."""


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


def port_rate(system: System, port: FloatArray, springs: Iterable[float], dampers: Iterable[float]) -> float:
    """Return the fastest rate at a port [rad/s]: of modes under each of some springs at it, and of its dampers.

    Parameters
    ----------
    port : ndarray, shape (free,)
        Beta.
    springs, dampers : iterable of float [N/m], [N s/m]
    """
    n = system.free
    squares = -system.matrix[n : 2 * n, :n] * system.scale
    rates = [c * float(port @ port) for c in dampers]
    for spring in springs:
        values, vectors = eigh((squares + squares.T) / 2 + spring * np.outer(port, port))
        omega = np.sqrt(np.maximum(np.abs(values), 1e-6))
        kick = (port @ vectors) ** 2 / omega
        rates.append(float(omega[kick > FELT * kick.max()].max()))
    return max(rates)


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

    @property
    def reach(self) -> int:
        """Most steps that can be computed ahead with matrices of bounded memory, a power of 2."""
        return int(min(2 ** int(np.log2(max(MATRICES / self.flow.size, 1.0))), LONGEST))

    @cached_property
    def water(self) -> Remainder:
        """Arguments of the compiled n."""
        found = self.system.remainder
        assert found is not None
        return found

    def in_waves(self, time: FloatArray) -> Remainder:
        """Return the arguments of n with waves sampled for some instants."""
        water = self.system.scene.water
        assert water is not None
        waves = water.waves_during(float(time[0]), float(time[-1]))
        return self.water._replace(waves=waves) if waves else self.water

    @cached_property
    def _collocations(self) -> dict[int, Collocation]:
        """Collocations found so far, by number of steps."""
        return {}

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
        own = self.collocation(steps)
        span, time = own.nodes.size, t + own.nodes.size * _INSTANTS
        water, swung = self.in_waves(time), self.swung(time)[:, :-1]
        values = own.at_nodes @ state[count:].reshape(NODES, n)
        around = state.copy()
        around[: len(z)] -= swung[0]
        away = own.nodes.free @ around[:count] + swung[_AT_NODES, :n].ravel()
        scale = max(float(np.linalg.norm(z)), self.system.least, span * water.round_off / STALLED)
        enough = MET * limit / scale
        change = solve_nodes(water, own.nodes, time[_AT_NODES], away, values, scale, enough)
        if not change < max(enough, STALLED):
            return state, np.inf
        coefficients = own.coefficients @ values
        out = np.append(state[:count], coefficients)
        around[count:] = coefficients.ravel()
        place = own.probe @ around + swung[_AT_PROBE, :n]
        seen = added(water, time[_AT_PROBE : _AT_PROBE + 1], place[None])[0]
        missed = seen - own.at_probe @ coefficients
        return out, float(np.linalg.norm(missed @ own.missed)) + change * scale

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
