"""Rational interpolation of many functions of frequency at once: barycentric, with common support points and weights.

Coefficients of motions that are real in time obey f(-conj omega) = conj f(omega): they are rational functions of
s = -i omega with real coefficients. Support points therefore come in pairs +-omega, and every solved frequency counts
twice. With nodes s_j, values f_j and weights w_j (Nakatsukasa, Sete and Trefethen 2018, AAA; common weights of several
functions: Lietaert, Meerbergen, Perez and Vandereycken 2022),

    r(s) = [sum_j w_j f_j/(s - s_j) + conj. pairs]/[sum_j w_j/(s - s_j) + conj. pairs],

which has the values f_j whatever the weights; these make the linearized misfit elsewhere as small as can be.
"""

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigvals

from vsb.errors import ConvergenceError
from vsb.tools.arrays import ComplexArray, FloatArray

_COLUMNS = 12
"""Combinations of columns that the weights are found from; all columns are interpolated."""
FEWEST_SAMPLES = 4
"""Least number of samples for which three interpolants can be compared."""


@dataclass(frozen=True)
class Rational:
    """Rational functions of frequency with common poles, one for each column."""

    support: FloatArray  # (point,) [rad/s]
    values: ComplexArray  # (point, column)
    weights: ComplexArray  # (point,)

    def __call__(self, omega: FloatArray) -> ComplexArray:
        """Return the values at real frequencies [rad/s], shape (omega, column); at support points those given."""
        apart = omega[:, None] - self.support
        upper = self.weights / np.where(apart == 0.0, 1e-290, apart)
        lower = -self.weights.conj() / (omega[:, None] + self.support)
        total = upper.sum(axis=1) + lower.sum(axis=1)
        return np.asarray((upper @ self.values + lower @ self.values.conj()) / total[:, None])

    @property
    def at_infinity(self) -> FloatArray:
        """Limits at infinite frequency, shape (column,); an extrapolation."""
        return np.asarray((self.weights @ self.values).imag / self.weights.sum().imag)

    @cached_property
    def poles(self) -> ComplexArray:
        """Finite poles, shape (pole,) [rad/s]: eigenvalues of the arrowhead pencil of the denominator."""
        nodes = np.concatenate([self.support, -self.support]).astype(complex)
        size = len(nodes) + 1
        arrow = np.diag(np.concatenate([[0.0], nodes]))
        arrow[0, 1:] = np.concatenate([self.weights, -self.weights.conj()])
        arrow[1:, 0] = 1.0
        finite = np.eye(size)
        finite[0, 0] = 0.0
        alpha, beta = eigvals(arrow, finite, homogeneous_eigvals=True)
        there = np.abs(beta) > 1e-12 * np.abs(alpha)
        return np.asarray(alpha[there] / beta[there])

    def spurious(self, grid: FloatArray) -> bool:
        """Return whether a pole hides between neighbours of an ascending grid of real frequencies.

        Such a pole is nearer to the real axis than the grid is fine, so that no value on the grid need reveal it: a
        doublet of pole and zero made of round-off or noise. Poles of floating bodies lie deep below the axis.
        """
        inside = (self.poles.real > grid[0]) & (self.poles.real < grid[-1])
        poles = self.poles[inside]
        gap = np.diff(grid)[np.searchsorted(grid, poles.real) - 1]
        return bool(np.any(np.abs(poles.imag) < gap))


def _loewner(omega: FloatArray, values: ComplexArray, size: FloatArray, support: list[int]) -> FloatArray:
    """Linearized misfit at the other samples of unit real and imaginary weights, shape (2 row, 2 point)."""
    others = np.setdiff1d(np.arange(len(omega)), support)
    at, f = omega[others, None], values[others, None]
    upper = (f - values[support]) / (at - omega[support])[..., None]
    lower = -(f - values[support].conj()) / (at + omega[support])[..., None]
    terms = np.concatenate([upper + lower, 1j * (upper - lower)], axis=1) * size[others, None, None]
    rows = terms.transpose(0, 2, 1).reshape(-1, 2 * len(support))
    return np.concatenate([rows.real, rows.imag])


def _leading(values: ComplexArray, size: FloatArray) -> ComplexArray:
    """Real combinations of the columns that hold most of their misfits, at most `_COLUMNS`, shape (sample, fewer)."""
    real = np.concatenate([values.real * size[:, None], values.imag * size[:, None]])
    left, s, _ = np.linalg.svd(real, full_matrices=False)
    kept = left[:, :_COLUMNS] * s[:_COLUMNS]
    return np.asarray((kept[: len(values)] + 1j * kept[len(values) :]) / size[:, None])


def interpolants(omega: FloatArray, values: ComplexArray, size: FloatArray) -> list[Rational]:
    """Return the interpolants with 1, 2, ... support points, each but the first where the last one missed most.

    Parameters
    ----------
    omega : ndarray, shape (sample,) [rad/s]
        Positive, different.
    values : ndarray, shape (sample, column)
    size : ndarray, shape (sample,)
        Positive: how much an error counts at each sample.
    """
    combined = _leading(values, size)
    support: list[int] = []
    missed = np.abs(values - values.mean(axis=0)).max(axis=1) * size
    found = []
    for _ in range(len(omega) - 1):
        missed[support] = -1.0
        support.append(int(np.argmax(missed)))
        _, _, right = np.linalg.svd(_loewner(omega, combined, size, support), full_matrices=False)
        real, imaginary = right[-1].reshape(2, -1)
        found.append(Rational(omega[support], values[support], real + 1j * imaginary))
        missed = np.abs(found[-1](omega) - values).max(axis=1) * size
    return found


class Selected(NamedTuple):
    """The interpolant its neighbours agree with best."""

    rational: Rational
    doubt: FloatArray  # (grid,): the larger difference from the interpolants with one support point less and more
    error: float  # estimated largest on the grid: the largest doubt, or misfit at a sample; inf if a pole hides there


def selected(
    omega: FloatArray, values: ComplexArray, size: FloatArray, grid: FloatArray, on_grid: FloatArray
) -> Selected:
    """Return the interpolant that one support point more or less changes least on a grid, and by how much.

    Too few support points miss features, too many fit noise with doublets of poles and zeros; in between neighbours
    agree. Interpolants with a hidden pole (`Rational.spurious`) are passed over. Raises `ConvergenceError` if there are
    fewer than `FEWEST_SAMPLES` samples.

    Parameters
    ----------
    omega, values, size
        Samples, as of `interpolants`.
    grid : ndarray, shape (grid,) [rad/s]
        Ascending.
    on_grid : ndarray, shape (grid,)
        How much an error counts there.
    """
    if len(omega) < FEWEST_SAMPLES:
        raise ConvergenceError(
            f"omega: received {len(omega)} samples, rational interpolation needs {FEWEST_SAMPLES}; solve more of them"
        )
    ascending = np.argsort(omega)  # round-off, and what it decides, must not depend on the order of solving
    omega, values, size = omega[ascending], values[ascending], size[ascending]
    found = interpolants(omega, values, size)
    on = [r(grid) for r in found]
    steps = [np.abs(b - a).max(axis=1) * on_grid for a, b in itertools.pairwise(on)]
    doubts = [np.maximum(a, b) for a, b in itertools.pairwise(steps)]
    misfits = [float((np.abs(r(omega) - values).max(axis=1) * size).max()) for r in found[1:-1]]
    errors = [max(float(doubt.max()), misfit) for doubt, misfit in zip(doubts, misfits, strict=True)]
    order = [int(i) for i in np.argsort(errors, kind="stable")]
    for i in order:
        if not found[i + 1].spurious(grid):
            return Selected(found[i + 1], doubts[i], errors[i])
    return Selected(found[order[0] + 1], doubts[order[0]], np.inf)
