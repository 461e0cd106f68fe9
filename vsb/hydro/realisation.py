"""State spaces of transfer functions of many motions: realised by a vector fit of samples, shortened by balancing.

Nothing here asks for passivity: see `vsb.hydro.passive`.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh, solve_continuous_lyapunov

from vsb.hydro.statespace import partial_fractions, vector_fit
from vsb.tools.arrays import ComplexArray, FloatArray

_COLUMNS = 24  # combinations of entries the poles are found from


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
        """Return it with the states that the motions reach and the forces see."""
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
