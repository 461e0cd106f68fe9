"""Proof of passivity: the least damping of a state space over all frequencies, by eigenvalues of a Hamiltonian matrix.

K(s) = C (s - A)^-1 B is passive if Phi(i omega) = K(i omega) + K(i omega)^H has no negative eigenvalue at any
frequency. Samples cannot tell: what happens between two of them is not seen. But Phi(i omega) + 2 epsilon is singular
exactly at the imaginary eigenvalues i omega of

    [[A - B C/(2 epsilon), B B^T/(2 epsilon)], [-C^T C/(2 epsilon), -A^T + C^T B^T/(2 epsilon)]]

(Boyd, Balakrishnan and Kabamba 1989). At infinite frequency it is 2 epsilon: positive everywhere if there are none.
"""

from typing import NamedTuple

import numpy as np

from vsb.errors import ConvergenceError, StabilityError
from vsb.hydro.realisation import StateSpace
from vsb.tools.arrays import FloatArray

LEVEL = 1e-8
"""Negative damping, in terms of the largest |K|, up to which no proof goes: round-off of the Hamiltonian matrix."""
_IMAGINARY = 1e-6  # real part, in terms of the eigenvalue, up to which one may be imaginary: they come in close pairs
_ROUND_OFF = 1e-14  # or in terms of the largest
_ROUNDS = 30


class LeastDamping(NamedTuple):
    """The least eigenvalue of the Hermitian part of K over all frequencies."""

    value: float  # found; never positive, as K vanishes at infinity
    omega: float  # where [rad/s]
    bound: float  # no frequency has less: proven


def least_damping(system: StateSpace) -> LeastDamping:
    """Return the least eigenvalue of the Hermitian part of K(i omega) over all frequencies, and a proven bound.

    Raises
    ------
    StabilityError
        If A is not stable: K is then no transfer function of a memory.

    Notes
    -----
    The level -epsilon is lowered to the least damping between the frequencies where it is crossed, until it is not
    crossed any more (Boyd and Balakrishnan 1990); convergence is quadratic, the proof is the last Hamiltonian matrix.
    """
    poles = np.linalg.eigvals(system.state_matrix)
    if poles.real.max() >= 0:
        raise StabilityError(
            f"passivity: received a pole with growth rate {poles.real.max():.3g}/s, needs a stable state matrix."
        )
    places = np.unique(np.concatenate([[0.0], np.abs(poles), np.abs(poles.imag)]))
    size = float(np.abs(system.transfer(places)).max())
    if size == 0.0:
        return LeastDamping(0.0, 0.0, 0.0)
    value, omega = 0.0, np.inf
    for _ in range(_ROUNDS):
        damping = system.damping(places)
        if damping.min() < value:
            value, omega = float(damping.min()), float(places[damping.argmin()])
        bound = 1.001 * value - LEVEL * size
        crossed = crossings(system, -bound)
        if not crossed.size:
            return LeastDamping(value, omega, bound)
        edges = np.concatenate([[0.0], crossed, [2 * crossed[-1]]])
        places = np.concatenate([crossed, 0.5 * (edges[1:] + edges[:-1])])
        if system.damping(places).min() >= bound:  # touched or round-off: not crossed
            return LeastDamping(value, omega, bound)
    raise ConvergenceError(
        f"passivity: received no level that is not crossed after {_ROUNDS}; scale the motions alike."
    )


def crossings(system: StateSpace, level: float) -> FloatArray:
    """Return the frequencies where an eigenvalue of the Hermitian part of K is -level, ascending [rad/s]."""
    a, b, c = system
    left = a - b @ c / (2 * level)
    values = np.linalg.eigvals(np.block([[left, b @ b.T / (2 * level)], [-c.T @ c / (2 * level), -left.T]]))
    near = _IMAGINARY * np.abs(values) + _ROUND_OFF * np.abs(values).max()
    return np.unique(values[(np.abs(values.real) <= near) & (values.imag >= 0)].imag)
