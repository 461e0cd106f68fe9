"""Fourier series, Hill's matrix, Floquet multipliers: closed forms, an independent integrator, order."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

from vsb.engine.integrators.floquet import harmonics_of, hill_matrix, monodromy, multipliers, phases, synthesized
from vsb.errors import ConvergenceError

SEEDS = st.integers(0, 2**32 - 1)


def random_harmonics(rng, count, *shape):
    """Of a real function: the mean has no imaginary part."""
    out = rng.normal(size=(count, *shape)) + 1j * rng.normal(size=(count, *shape))
    out[0] = out[0].real
    return out


@given(SEEDS, st.integers(1, 6), st.integers(1, 14))
def test_hill_matrix_equals_the_product_in_time(seed, count, wide):
    rng, free = np.random.default_rng(seed), 2
    matrix, u = random_harmonics(rng, wide, free, free), random_harmonics(rng, count, free)
    phase = phases(2 * (wide + count))
    product = np.einsum(
        "tij,tj->ti", synthesized(matrix.reshape(wide, -1), phase).reshape(-1, free, free), synthesized(u, phase)
    )
    parts = np.array([u.real, u.imag])
    real, imaginary = np.einsum("ahibkj,bkj->ahi", hill_matrix(matrix, count), parts)
    assert real + 1j * imaginary == pytest.approx(harmonics_of(product)[:count], abs=1e-11)


def random_system(seed, free=2, memory=3):
    rng = np.random.default_rng(seed)
    matrix, parts = rng.normal(size=(2 * free + memory,) * 2), random_harmonics(rng, 3, free, free)
    return matrix, lambda phase: synthesized(parts.reshape(3, -1), phase).reshape(-1, free, free)


def test_monodromy_has_order_six_against_an_independent_integrator():
    (matrix, coupling), period, size, free = random_system(1), 2.0, 7, 2

    def rates(t, y):
        z = y.reshape(size, size)
        out = matrix @ z
        out[free : 2 * free] += coupling(np.array([2 * np.pi * t / period]))[0] @ z[:free]
        return out.ravel()

    done = solve_ivp(rates, (0.0, period), np.eye(size).ravel(), method="DOP853", rtol=1e-13, atol=1e-13)
    truth = done.y[:, -1].reshape(size, size)
    counts = np.array([32, 48, 64, 96, 128])
    errors = [np.abs(monodromy(matrix, coupling(phases(count)), period) - truth).max() for count in counts]
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.all(np.abs(slopes - 6.0) < 0.4), slopes


def mathieu(a, q, count):
    """Monodromy over pi of y'' + (a - 2 q cos 2t) y = 0."""
    return monodromy(np.array([[0.0, 1.0], [-a, 0.0]]), 2 * q * np.cos(phases(count))[:, None, None], np.pi)


@pytest.mark.parametrize("q", [1.0])
@pytest.mark.parametrize(("boundary", "order", "trace"), [(mathieu_b, 1, -2.0), (mathieu_a, 2, 2.0)])
def test_stability_boundaries_of_mathieus_equation(q, boundary, order, trace):
    """Abramowitz and Stegun 20.2: at a characteristic value one solution has the period pi or 2 pi."""
    a = float(boundary(order, q))
    errors = [abs(np.trace(mathieu(a, q, count)) - trace) for count in (64, 128, 256)]
    assert errors[2] < 1e-8
    assert all(coarse > 30 * fine or coarse < 1e-9 for coarse, fine in itertools.pairwise(errors))


def test_unresolved_multipliers_are_refused():
    """A coupling that is another one at every sampling."""
    matrix = np.array([[0.0, 3.0], [-3.0, 0.0]])
    with pytest.raises(ConvergenceError, match=r"stability of a periodic motion cannot be determined: .*add"):
        multipliers(matrix, lambda phase: np.random.default_rng(7).normal(size=(len(phase), 1, 1)), 50.0)
