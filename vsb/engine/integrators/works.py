"""Forces and energy audit of a switching run: powers integrated between its nodes, on the pieces in force.

Nodes are the instants of the lookout and the events. Between two of them every force is smooth, and states and their
first two derivatives are known at both, z' = A z + B g and z'' = A z' + B g'. Power P has then a rule of order six,

    int P dt = h/2 (P0 + P1) + h^2/10 (P0' - P1') + h^3/120 (P0'' + P1''):

work along the exact motion, against which what the states store is audited. Work of the water beyond its tangent is
the waves' work, except the part that is stored.
"""

from typing import NamedTuple

import numpy as np

from vsb.engine.integrators.phases import Phase
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import superposed
from vsb.tools.arrays import BoolArray, FloatArray

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
        """Return z, z', z'' of nodes, shape (3, node, state).

        Parameters
        ----------
        states : ndarray, shape (node, state + ...)
        driven : ndarray, shape (3, node, free)
            Waves, what the water does beyond its tangent, and their derivatives.
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
    """Return accelerations, forces and works of a run.

    Parameters
    ----------
    time : ndarray, shape (node,) [s]
    states, leaving : ndarray, shape (node, state + ...)
        As steps end at the nodes, and as they begin there: what is carried beyond z and f differs.
    regular : ndarray of bool, shape (node,)
        Which nodes are equally spaced.
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
