"""Exponentials and phi functions of a matrix on spans that double: what exponential integrators are made of.

P_k(h) = int_0^h exp((h - s) A) B s^(k-1)/(k-1)! ds = h^k phi_k(hA) B. Taylor's series gives them where |A| h is small,
and from there

    exp(2hA) = exp(hA)^2,    P_k(2h) = exp(hA) P_k(h) + sum_{j <= k} h^(k-j)/(k-j)! P_j(h):

a ladder of spans costs a few small products a rung, however stiff A is.
"""

from math import factorial
from typing import NamedTuple

import numpy as np

from vsb.tools.arrays import FloatArray

_SMALL, _TERMS = 0.5, 16  # 0.5^16/16! is below round-off


class PhiIntegrals(NamedTuple):
    """exp(hA) and P_k(h), k = 1, 2, ... of one span."""

    span: float  # h [s]
    exponential: FloatArray  # (state, state)
    integrals: FloatArray  # (k, state, input)

    def of_polynomials(self, coefficients: FloatArray, unit: float) -> FloatArray:
        """Return int_0^h exp((h-s) A) B l_i(s/unit) ds of polynomials l_i.

        Parameters
        ----------
        coefficients : ndarray, shape (power, polynomial)
            Of x^power in l_i(x).
        unit : float [s]

        Returns
        -------
        ndarray, shape (polynomial, input, state)
            Transposed: products with it run along the state.
        """
        powers = range(len(coefficients))
        scaled = coefficients * np.array([[factorial(k) / unit**k] for k in powers])
        response = np.tensordot(scaled.T, self.integrals[: len(coefficients)], 1)
        return np.ascontiguousarray(response.transpose(0, 2, 1))


def phi_integrals(a: FloatArray, b: FloatArray, h: float, count: int) -> PhiIntegrals:
    """Return exp(hA) and P_k(h), k = 1..count.

    Parameters
    ----------
    a : ndarray, shape (state, state) [1/s]
    b : ndarray, shape (state, input)
    h : float [s]
    count : int
    """
    if not is_small(a, h):
        return doubled(phi_integrals(a, b, h / 2, count))
    terms = [np.hstack([np.eye(len(a)), b])]
    for _ in range(_TERMS):
        terms.append(h * a @ terms[-1])
    weights = np.array([[h**k / factorial(k + j) for j in range(_TERMS + 1)] for k in range(count + 1)])
    series = np.tensordot(weights, np.array(terms), 1)
    return PhiIntegrals(h, series[0, :, : len(a)], series[1:, :, len(a) :])


def is_small(a: FloatArray, h: float) -> bool:
    """Whether Taylor's series of exp(hA) needs no scaling."""
    return bool(np.linalg.norm(a, 1) * h <= _SMALL)


def doubled(half: PhiIntegrals) -> PhiIntegrals:
    """Return exponential and integrals of twice the span."""
    h, e, p = half
    count = len(p)
    shift = np.array([[h ** (k - j) / factorial(k - j) if j <= k else 0.0 for j in range(count)] for k in range(count)])
    return PhiIntegrals(2 * h, e @ e, e @ p + np.tensordot(shift, p, 1))


def lagrange(nodes: FloatArray) -> FloatArray:
    """Return the coefficients of x^k in the Lagrange polynomials of some nodes, shape (k, node)."""
    return np.linalg.inv(np.vander(nodes, increasing=True))
