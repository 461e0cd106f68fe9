"""Periodic functions and linear equations with periodic coefficients: Fourier, Hill's matrix, Floquet multipliers.

A periodic function of phase is f = Re sum F_h exp(-i h phase), h = 0, 1, ... (C1).
"""

from collections.abc import Callable
from functools import reduce

import numpy as np

from vsb.engine.integrators.collocation import NODES, step_of
from vsb.errors import ConvergenceError
from vsb.tools.arrays import ComplexArray, FloatArray

SAMPLES = (32, 128, 512, 2048)
"""Samples of a period tried for its multipliers."""
AGREEMENT = 1e-7
"""Tolerance of the largest multiplier, or a hundredth of its distance from one if that is larger."""


def phases(count: int, offset: float = 0.0) -> FloatArray:
    """Return equally spaced phases of a period [rad], the first `offset` of a distance after zero, shape (count,)."""
    return 2 * np.pi / count * (np.arange(count) + offset)


def harmonics_of(samples: FloatArray) -> ComplexArray:
    """Return F_h from an even number of equally spaced samples of a period, shape (sample/2, ...)."""
    count = len(samples)
    out = 2 / count * np.conj(np.fft.rfft(samples, axis=0))[: count // 2]
    out[0] /= 2
    return np.asarray(out)


def synthesized(harmonics: ComplexArray, phase: FloatArray) -> FloatArray:
    """Return f at some phases, shape (phase, ...)."""
    return np.real(np.exp(-1j * np.outer(phase, np.arange(len(harmonics)))) @ harmonics)


def largest(harmonics: ComplexArray) -> float:
    """Return a bound of a signal from its harmonics, of the component where it is largest."""
    return float(np.abs(harmonics).sum(axis=0).max(initial=0.0))


def hill_matrix(matrix: ComplexArray, count: int) -> FloatArray:
    """Return the real matrix from the harmonics of u to those of E(t) u(t).

    Parameters
    ----------
    matrix : ndarray, shape (harmonic, free, free)
        Harmonics of E; those beyond are zero.
    count : int
        Harmonics of u and of the product, the mean among them.

    Returns
    -------
    ndarray, shape (2, count, free, 2, count, free)
        Real and imaginary parts, harmonics, components of the product; the same of u. The mean has no imaginary part.

    Notes
    -----
    With two-sided T_m, T_-m = conj T_m, the product has harmonics sum_k T_(h-k) U_k + T_(h+k) conj U_k, the mean of u
    twice in all but the mean of the product.
    """
    two_sided = np.zeros((max(2 * count - 1, len(matrix)), *matrix.shape[1:]), dtype=complex)
    two_sided[: len(matrix)] = matrix / 2
    two_sided[0] *= 2
    order = np.arange(count)
    apart = order[:, None] - order
    direct = np.where((apart >= 0)[..., None, None], two_sided[np.abs(apart)], two_sided[np.abs(apart)].conj())
    mirrored = two_sided[order[:, None] + order]
    mirrored[:, 0] = 0.0
    mirrored[0] /= 2
    direct[1:, 0] *= 2
    direct[0, 1:] /= 2
    plus, minus = direct + mirrored, direct - mirrored
    blocks = np.array([[plus.real, -minus.imag], [plus.imag, minus.real]])
    blocks[:, 1, :, 0], blocks[1, :, 0] = 0.0, 0.0
    return np.ascontiguousarray(blocks.transpose(0, 2, 4, 1, 3, 5))


def monodromy(matrix: FloatArray, coupling: FloatArray, period: float) -> FloatArray:
    """Return the change of z over a period of z' = (A + B W(t) P) z, shape (state, state).

    Parameters
    ----------
    matrix : ndarray, shape (state, state) [1/s]
        A.
    coupling : ndarray, shape (sample, free, seen) [1/s]
        W at equally spaced instants, a multiple of four of them: rates of z[free:2 free] per unit z[:seen].
    period : float [s]

    Notes
    -----
    Exponential collocation: W P z is a polynomial through the five instants of a step, the rest exact. Order 6, where
    A is stiff 5; what is seen at the nodes solves p_i = exp(i d A) z + sum_j F_ij W_j p_j.
    """
    (_, free, seen), size, inner = coupling.shape, len(matrix), NODES - 1
    steps = len(coupling) // inner
    step = step_of(matrix, np.eye(size, free, -free), period / steps, inner)  # forces act on the rates
    exact, forced = step.free, step.forced.reshape(inner, size, NODES, free)
    nodes = coupling[(inner * np.arange(steps)[:, None] + np.arange(NODES)) % len(coupling)]
    first = np.concatenate([nodes[:, 0], np.zeros((steps, free, size - seen))], axis=2)  # W P z at the start
    mutual = np.einsum("iajf,sjfg->siajg", forced[:, :seen, 1:], nodes[:, 1:]).reshape(steps, inner * seen, -1)
    alone = exact[:, :seen] + np.einsum("iaf,sfz->siaz", forced[:, :seen, 0], first)
    there = np.linalg.solve(np.eye(inner * seen) - mutual, alone.reshape(steps, inner * seen, size))
    acting = nodes[:, 1:] @ there.reshape(steps, inner, seen, size)
    ends = exact[-1] + forced[-1, :, 0] @ first + np.einsum("ajf,sjfz->saz", forced[-1, :, 1:], acting)
    whole: FloatArray = reduce(np.matmul, ends[::-1])
    return whole


def multipliers(matrix: FloatArray, coupling: Callable[[FloatArray], FloatArray], period: float) -> ComplexArray:
    """Return the Floquet multipliers of z' = (A + B W(t) P) z, largest first, shape (state,).

    Raises `ConvergenceError` if the largest is not resolved: stiff modes without damping need more samples.

    Parameters
    ----------
    matrix : ndarray, shape (state, state) [1/s]
    coupling : callable
        Phases, shape (sample,) [rad] -> W there, see `monodromy`.
    period : float [s]
    """
    for count in SAMPLES:
        sampled = coupling(phases(count))
        values, coarse = (np.linalg.eigvals(monodromy(matrix, sampled[::every], period)) for every in (1, 2))
        growth, before = (float(np.abs(found).max()) for found in (values, coarse))
        if abs(growth - before) < max(AGREEMENT, 0.01 * abs(1 - growth)):
            return np.asarray(values[np.argsort(-np.abs(values))], dtype=complex)
    raise ConvergenceError(
        f"stability of a periodic motion cannot be determined: a disturbance grows by {growth:.6g} in a period, "
        f"or by {before:.6g} with half the samples; add structural damping, or follow the motion in time."
    )
