"""One regime of a switching take-off in a body-exact scene: the linear part exactly, the water's rest by polynomials.

Beside a linear regime (`vsb.integrators.phases`) acts n(t, z), what the water does beyond its tangent:

    z' = A z + B (beta f + n + waves).

Over a step n is the polynomial of degree four through its values at five equally spaced instants, met by the motion it
makes: exponential collocation, of order 6. Its Taylor coefficients are carried as states like f, so the motion inside a
step is that of a linear system, known at every instant an event may ask for, to the same order. No past is needed: a
step begins anew after each event.
"""

from dataclasses import dataclass
from functools import cached_property
from math import factorial

import numpy as np

from vsb.integrators.energy_preserving import STALLED, Step, added, settled
from vsb.integrators.exact import transition
from vsb.integrators.phases import Phase
from vsb.motion.system import Remainder
from vsb.tools.arrays import FloatArray

NODES = 5
PROBE = 0.375
"""Where in a step n is compared with its polynomial: midway between two nodes."""
_NODE = np.linspace(0.0, 1.0, NODES)


def taylor(at: FloatArray) -> FloatArray:
    """Return what Taylor coefficients at the begin of a step, in units of the step, add up to, (instant, NODES)."""
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
        """Positions at the nodes from (z - z_s, f, coefficients) at the begin, shape (NODES, free, state + ...)."""
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
        n, count, none = self.system.free, len(self.matrix), np.zeros((0, 0))
        rows = self._at_nodes.reshape(NODES * n, -1)
        forced = rows[:, count:] @ np.kron(_COEFFICIENTS, np.eye(n))
        return Step(self.step, np.ascontiguousarray(rows[:, :count]), np.ascontiguousarray(forced), none, none)

    def swung(self, time: FloatArray) -> FloatArray:
        """Return scaled modal positions of z_s at any instants, shape (time, free)."""
        turn = np.exp(-1j * np.outer(time, self.system.omega))
        return np.asarray(np.real(turn @ self.swing[:, : self.system.free]))

    def begun(self, t: float, state: FloatArray) -> tuple[FloatArray, float]:
        """Return (z, f, coefficients) at the begin of a step, n met by the motion, and the error of n there.

        The coefficients received, those of the step before, are where the search begins. The error is infinite if no n
        is met: the step is too long.
        """
        count, n, z = len(self.matrix), self.system.free, state[: len(self.matrix) - 1]
        time = t + self.step * _NODE
        values = _TAYLOR @ state[count:].reshape(NODES, n)
        around = self.transient(t, state)
        away = self._collocation.free @ around[:count] + self.swung(time).ravel()
        scale = max(float(np.linalg.norm(z)), self.system.least, self.step * self.water.round_off / STALLED)
        if not settled(self.water, self._collocation, time, away, np.zeros_like(values), values, scale) < STALLED:
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
        """Return a state with n alone in its coefficients, as it is at an instant: where no step came before."""
        out, n = state.copy(), self.system.free
        out[len(self.matrix) :] = 0.0
        out[len(self.matrix) : len(self.matrix) + n] = added(self.water, np.array([t]), state[None, :n].copy())[0]
        return out
