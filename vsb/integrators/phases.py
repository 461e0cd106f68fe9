"""One linear regime of a switching take-off: its motion over any span, and the signals its switches depend on.

While a take-off keeps to one piece of its law, F = -(c V + k S) + f at the port, or holds it at rest, the scene is

    z' = A z + B (beta f + n + Re sum w_j exp(-i omega_j t)),    S = (beta/s).z,  V = beta.p',

with beta = shapes^T b, s the scale of the modes and constant c, k, f. In a linear scene n = 0, and z - z_s =
exp(A (t - t_0)) (z - z_s)(t_0) about the steady response z_s to the waves has no step-size error. f is one more,
constant state.

In a body-exact scene n(t, z) is what the water does beyond its tangent. Over a step it is the polynomial of degree four
through its values at five equally spaced instants of the motion it causes: exponential collocation, of order 6. Its
Taylor coefficients are states like f, so the motion inside a step is that of a linear system, known at every instant an
event may need, to the same order. No past is needed: a step starts afresh after each event.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from vsb.integrators.exact import SERIES, steady_state, transition
from vsb.integrators.implicit_force import STALLED, Step, added, solve_nodes
from vsb.motion.system import Remainder, System
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.waves.seas import superposed

AHEAD = 128
"""Most instants computed ahead at a time."""


FELT = 1e-3
"""Modes that respond less than this part of the largest to an impulse at the port are neglected."""


class Signals(NamedTuple):
    """Signals that switches depend on, each shape (time,)."""

    stroke: FloatArray  # S [m]
    velocity: FloatArray  # V [m/s]
    net_force: FloatArray  # net force of all but the take-off on a port that is held [N]


@dataclass(frozen=True, eq=False)
class Phase:
    """A scene with a damper and a spring at its port, or with the port held; states are (z, f)."""

    system: System  # without the take-off
    port: FloatArray  # beta (free,)
    damping: float  # c [N s/m]
    stiffness: float  # k [N/m]
    held: bool
    step: float  # between the instants of a run, the longest span [s]
    rest: float = 0.0  # S at rest, from which it is measured [m]

    carried = 0
    """Further states per mode: none in a linear scene."""
    reach = AHEAD
    """Steps that can be computed ahead."""

    @cached_property
    def free_rates(self) -> FloatArray:
        """Rates of p' of a port that is not held, shape (free, state + 1)."""
        n = self.system.free
        rates = np.column_stack([self.system.matrix[n : 2 * n], self.port])
        rates[:, :n] -= self.stiffness * np.outer(self.port, self.port / self.system.scale)
        rates[:, n : 2 * n] -= self.damping * np.outer(self.port, self.port)
        return rates

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
        """Rows of the signals over (z, f), shape (3, state + 1)."""
        n, out = self.system.free, np.zeros((3, len(self.matrix)))
        out[0, :n] = self.port / self.system.scale
        out[1, n : 2 * n] = self.port
        out[2] = self.port @ self.free_rates / (self.port @ self.port)
        return out

    def transient(self, t: float, state: FloatArray) -> FloatArray:
        """Return (z - z_s, f, ...) at an instant of (z, f, ...)."""
        out, order = state.copy(), len(self.system.matrix)
        out[:order] -= np.real(np.exp(-1j * self.system.omega * t) @ self.swing)
        return out

    def states(self, time: FloatArray, transients: FloatArray) -> FloatArray:
        """Return (z, f, ...) at equally spaced instants, of transients (z - z_s, f, ...), shape (time, state + ...)."""
        out, order = transients.copy(), len(self.system.matrix)
        out[:, :order] += superposed(self.system.omega, self.swing, time)
        return out

    def watched(self, time: FloatArray, states: FloatArray) -> Signals:
        """Return the signals of (z, f, ...) at equally spaced instants."""
        count, n = len(self.matrix), self.system.free
        wave = superposed(self.system.omega, (self.system.waves @ self.port)[:, None], time)[:, 0]
        stroke, velocity, net_force = self.signals @ states[:, :count].T
        if self.carried:
            wave = wave + states[:, count : count + n] @ self.port
        return Signals(stroke - self.rest, velocity, net_force + wave / (self.port @ self.port))

    def begun(self, t: float, state: FloatArray) -> tuple[FloatArray, float]:
        """Return (z, f, ...) at the start of a step, and the error of n: none in a linear scene."""
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


NODES = 5
PROBE = 0.375
"""Point of a step where n is compared with its polynomial: midway between two nodes."""
_NODE = np.linspace(0.0, 1.0, NODES)


def taylor(at: FloatArray) -> FloatArray:
    """Return the Taylor terms at instants after the start of a step, in units of the step, shape (instant, NODES)."""
    return np.asarray(np.vander(at, NODES, increasing=True) / [float(factorial(k)) for k in range(NODES)])


_TAYLOR = taylor(_NODE)
_COEFFICIENTS = np.linalg.inv(_TAYLOR)
"""Taylor coefficients from the values at the nodes."""


@dataclass(frozen=True, eq=False)
class WetPhase(Phase):
    """A scene with water on its instantaneous wet shell; states are (z, f, Taylor coefficients of n)."""

    carried = NODES
    reach = 1

    @cached_property
    def water(self) -> Remainder:
        """Arguments of the compiled n."""
        found = self.system.remainder
        assert found is not None
        return found

    @cached_property
    def _at_nodes(self) -> FloatArray:
        """Positions at the nodes from (z - z_s, f, coefficients) at the start, shape (NODES, free, state + ...)."""
        quarter, out = transition(self.flow * (self.step / (NODES - 1))), [np.eye(len(self.flow))]
        while len(out) < NODES:
            out.append(quarter @ out[-1])
        return np.array(out)[:, : self.system.free]

    @cached_property
    def _at_probe(self) -> FloatArray:
        """Likewise at `PROBE`, shape (free, state + ...)."""
        return transition(self.flow * (self.step * PROBE))[: self.system.free]

    @cached_property
    def _collocation(self) -> Step:
        """Matrices of the collocation: positions without n, and what n at the nodes adds."""
        n, count = self.system.free, len(self.matrix)
        rows = self._at_nodes.reshape(NODES * n, -1)
        forced = rows[:, count:] @ np.kron(_COEFFICIENTS, np.eye(n))
        return Step(self.step, np.ascontiguousarray(rows[:, :count]), np.ascontiguousarray(forced))

    def swung(self, time: FloatArray) -> FloatArray:
        """Return scaled modal positions of z_s at any instants, shape (time, free)."""
        turn = np.exp(-1j * np.outer(time, self.system.omega))
        return np.asarray(np.real(turn @ self.swing[:, : self.system.free]))

    def begun(self, t: float, state: FloatArray) -> tuple[FloatArray, float]:
        """Return (z, f, coefficients) at the start of a step, consistent with its motion, and the error of n.

        The iteration starts from the coefficients of the step before. The error is infinite if it does not converge:
        the step is too long.
        """
        count, n, z = len(self.matrix), self.system.free, state[: len(self.matrix) - 1]
        time = t + self.step * _NODE
        values = _TAYLOR @ state[count:].reshape(NODES, n)
        around = self.transient(t, state)
        away = self._collocation.free @ around[:count] + self.swung(time).ravel()
        scale = max(float(np.linalg.norm(z)), self.system.least, self.step * self.water.round_off / STALLED)
        if not solve_nodes(self.water, self._collocation, time, away, values, scale) < STALLED:
            return state, np.inf
        out = np.append(state[:count], _COEFFICIENTS @ values)
        there = np.array([t + PROBE * self.step])
        place = self._at_probe @ self.transient(t, out) + self.swung(there)[0]
        seen = added(self.water, there, place[None])[0]
        missed = seen - taylor(np.array([PROBE]))[0] @ out[count:].reshape(NODES, n)
        return out, float(self.step * np.linalg.norm(missed))

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
