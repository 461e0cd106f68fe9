"""State spaces of transfer functions of many motions: vector fit, balanced truncation, least damping.

None of these need be passive; `vsb.engine.hydro.passive` makes them so. K(s) = C (s - A)^-1 B is passive if
Phi(i omega) = K(i omega) + K(i omega)^H has no negative eigenvalue at any frequency. Samples cannot prove that, for
they miss what happens between them. But Phi(i omega) + 2 epsilon is singular exactly at the imaginary eigenvalues
i omega of

    [[A - B C/(2 epsilon), B B^T/(2 epsilon)], [-C^T C/(2 epsilon), -A^T + C^T B^T/(2 epsilon)]]

(Boyd, Balakrishnan and Kabamba 1989). At infinite frequency it is 2 epsilon: positive everywhere if there are none.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh, solve_continuous_lyapunov

from vsb.engine.hydro.statespace import partial_fractions, vector_fit
from vsb.errors import ConvergenceError, StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray

_COLUMNS = 24  # combinations of entries that the poles are found from


class StateSpace(NamedTuple):
    """K(s) = C (s - A)^-1 B, passive or not."""

    state_matrix: FloatArray  # A (state, state) [1/s]
    input_matrix: FloatArray  # B (state, dof)
    output_matrix: FloatArray  # C (dof, state)

    def transfer(self, omega: FloatArray) -> ComplexArray:
        """Return K(i omega), shape (omega, dof, dof)."""
        a, b, c = self
        poles, vectors = np.linalg.eig(a)
        inside = 1 / (1j * omega[:, None] - poles)
        return np.asarray(np.einsum("in,wn,nj->wij", c @ vectors, inside, np.linalg.solve(vectors, b), optimize=True))

    def damping(self, omega: FloatArray) -> FloatArray:
        """Return the least eigenvalue of the Hermitian part of K(i omega), shape (omega,)."""
        k = self.transfer(omega)
        return np.asarray(np.linalg.eigvalsh(0.5 * (k + k.conj().transpose(0, 2, 1)))[:, 0])


def rational_fit(omega: FloatArray, k: ComplexArray, poles: int) -> StateSpace:
    """Return the state space of a plain vector fit with common poles and full residues; it need not be passive."""
    dof, flat = k.shape[1], k.reshape(len(omega), -1)
    found = vector_fit(omega, _combined(flat), poles)
    basis, block, ones = partial_fractions(1j * omega, found)
    rows, right = (np.vstack([part.real, part.imag]) for part in (basis, flat))
    residues = np.linalg.lstsq(rows, right, rcond=None)[0].reshape(-1, dof, dof)
    output = residues.transpose(1, 0, 2).reshape(dof, -1)
    return StateSpace(np.kron(block, np.eye(dof)), np.kron(ones[:, None], np.eye(dof)), output)


def _combined(columns: ComplexArray) -> ComplexArray:
    """Real combinations of the columns that hold most of them, at most `_COLUMNS`."""
    left, singular, _ = np.linalg.svd(np.vstack([columns.real, columns.imag]), full_matrices=False)
    kept = (left * singular)[:, : min(_COLUMNS, int((singular > 1e-9 * singular[0]).sum()))]
    return np.asarray(kept[: len(columns)] + 1j * kept[len(columns) :])


@dataclass(frozen=True)
class Balanced:
    """A stable state space and the square roots of its Gramians (Moore 1981; Tombs and Postlethwaite 1987)."""

    system: StateSpace
    left: FloatArray  # (state, order), Hankel singular values descending
    right: FloatArray  # (state, order)

    @classmethod
    def of(cls, system: StateSpace) -> "Balanced":
        """Return it with the controllable and observable states."""
        a, b, c = system
        reached, seen = _root(solve_continuous_lyapunov(a, -b @ b.T)), _root(solve_continuous_lyapunov(a.T, -c.T @ c))
        u, hankel, v = np.linalg.svd(seen.T @ reached)
        kept = hankel > 1e-13 * hankel[0]
        scale = np.sqrt(hankel[kept])
        return cls(system, seen @ u[:, : len(kept)][:, kept] / scale, reached @ v.T[:, : len(kept)][:, kept] / scale)

    @property
    def order(self) -> int:
        """Number of states of the smallest realisation."""
        return int(self.left.shape[1])

    def truncated(self, order: int) -> StateSpace:
        """Return the state space of so many states; its K is off by twice the other singular values at most."""
        a, b, c = self.system
        left, right = self.left[:, :order], self.right[:, :order]
        return StateSpace(left.T @ a @ right, left.T @ b, c @ right)


def _root(gramian: FloatArray) -> FloatArray:
    """R with R R^T = a positive semidefinite matrix."""
    values, vectors = eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


LEVEL = 1e-8
"""Negative damping below which nothing is proved, relative to the largest |K|: round-off of the Hamiltonian matrix."""
_IMAGINARY = 1e-6  # real part, relative to the eigenvalue, up to which it may be imaginary: they come in close pairs
_ROUND_OFF = 1e-14  # the same relative to the largest eigenvalue
_ROUNDS = 30


class LeastDamping(NamedTuple):
    """The least eigenvalue of the Hermitian part of K over all frequencies."""

    value: float  # found; never positive, as K vanishes at infinity
    omega: float  # where [rad/s]
    bound: float  # no frequency has less: proven


def least_damping(system: StateSpace) -> LeastDamping:
    """Return the least eigenvalue of the Hermitian part of K(i omega) over all frequencies, and a proven bound.

    Raises `StabilityError` if A is not stable: K is then no transfer function of a memory.

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
