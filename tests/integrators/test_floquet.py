"""Fourier series, Hill's matrix, Floquet multipliers: closed forms, an independent integrator, order."""

import itertools
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.special import mathieu_a, mathieu_b

from vsb.errors import ConvergenceError
from vsb.integrators import floquet
from vsb.integrators.floquet import harmonics_of, hill_matrix, largest, monodromy, multipliers, phases, synthesized

SEEDS = st.integers(0, 2**32 - 1)


def random_harmonics(rng, count, *shape):
    """Of a real function: the mean has no imaginary part."""
    out = rng.normal(size=(count, *shape)) + 1j * rng.normal(size=(count, *shape))
    out[0] = out[0].real
    return out


@given(SEEDS, st.integers(1, 9))
def test_samples_and_harmonics_are_each_others_inverse(seed, count):
    harmonics = random_harmonics(np.random.default_rng(seed), count, 3)
    found = harmonics_of(synthesized(harmonics, phases(2 * count)))
    assert found == pytest.approx(harmonics, abs=1e-13 * count)


@given(SEEDS)
def test_no_function_exceeds_the_bound_of_its_harmonics(seed):
    harmonics = random_harmonics(np.random.default_rng(seed), 5, 2)
    assert np.abs(synthesized(harmonics, phases(64, 0.3))).max() <= largest(harmonics) + 1e-12


@given(SEEDS, st.integers(1, 6), st.integers(1, 14))
def test_hills_matrix_is_the_product_in_time(seed, count, wide):
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


@given(SEEDS)
def test_determinant_of_a_period_is_that_of_liouville(seed):
    """The coupling has no trace."""
    matrix, coupling = random_system(seed)
    matrix, period = matrix / 4, 1.0
    whole = monodromy(matrix, coupling(phases(64)), period)
    assert np.linalg.det(whole) == pytest.approx(np.exp(np.trace(matrix) * period), rel=1e-6)


def test_constant_coupling_is_a_constant_system():
    matrix, _ = random_system(5)
    coupling = np.array([[-1.0, 0.3], [0.2, -2.0]])
    whole = matrix.copy()
    whole[2:4, :2] += coupling
    expected = np.linalg.eigvals(expm(1.5 * whole))
    found = multipliers(matrix, lambda phase: np.broadcast_to(coupling, (len(phase), 2, 2)), 1.5)
    assert np.abs(found) == pytest.approx(np.sort(np.abs(expected))[::-1], rel=1e-2)
    assert np.linalg.eigvals(monodromy(matrix, np.broadcast_to(coupling, (256, 2, 2)), 1.5)) == pytest.approx(
        expected, rel=1e-8
    )


def mathieu(a, q, count):
    """Monodromy over pi of y'' + (a - 2 q cos 2t) y = 0."""
    return monodromy(np.array([[0.0, 1.0], [-a, 0.0]]), 2 * q * np.cos(phases(count))[:, None, None], np.pi)


@pytest.mark.parametrize("q", [0.3, 1.0, 3.0])
@pytest.mark.parametrize(
    ("boundary", "order", "trace"),
    [(mathieu_b, 1, -2.0), (mathieu_a, 1, -2.0), (mathieu_b, 2, 2.0), (mathieu_a, 2, 2.0)],
)
def test_edges_of_the_tongues_of_mathieus_equation(q, boundary, order, trace):
    """Abramowitz and Stegun 20.2: at a characteristic value one solution has the period pi or 2 pi."""
    a = float(boundary(order, q))
    errors = [abs(np.trace(mathieu(a, q, count)) - trace) for count in (64, 128, 256)]
    assert errors[2] < 1e-8
    assert all(coarse > 30 * fine or coarse < 1e-9 for coarse, fine in itertools.pairwise(errors))


def test_within_a_tongue_a_disturbance_grows_and_beside_it_it_does_not():
    q = 0.5
    inside, outside = (float(mathieu_b(1, q)) + shift for shift in (0.2, -0.2))
    matrix = np.array([[0.0, 1.0], [-inside, 0.0]])
    found = multipliers(matrix, lambda phase: 2 * q * np.cos(phase)[:, None, None], np.pi)
    assert found[0].real < -1.1  # at twice the period
    assert found[0] * found[1] == pytest.approx(1.0, abs=1e-4)
    matrix[1, 0] = -outside
    found = multipliers(matrix, lambda phase: 2 * q * np.cos(phase)[:, None, None], np.pi)
    assert np.abs(found) == pytest.approx(1.0, abs=1e-6)


def test_what_cannot_be_told_is_refused():
    """A coupling that is another one at every sampling."""
    matrix = np.array([[0.0, 3.0], [-3.0, 0.0]])
    with pytest.raises(
        ConvergenceError, match=r"stability of a periodic motion cannot be told: .*add structural damping"
    ):
        multipliers(matrix, lambda phase: np.random.default_rng(7).normal(size=(len(phase), 1, 1)), 50.0)


@pytest.mark.parametrize(("q", "shift", "counts"), [(3.0, 1.0, [32]), (3.0, 0.2, [32, 128]), (3.0, -0.2, [32, 128])])
def test_growth_that_half_the_samples_tell_to_a_hundredth_of_its_distance_from_one_is_believed(q, shift, counts):
    """Mathieu's equation: at 32 samples 0.4 %, 1.6 % too little and 1.7 % too much."""
    matrix, asked = np.array([[0.0, 1.0], [-float(mathieu_b(1, q)) - shift, 0.0]]), []

    def coupling(phase):
        asked.append(len(phase))
        return 2 * q * np.cos(phase)[:, None, None]

    found = np.abs(multipliers(matrix, coupling, np.pi)[0])
    assert asked == counts
    fine, half = (np.abs(np.linalg.eigvals(mathieu(-matrix[1, 0], q, count))).max() for count in (32, 16))
    assert (abs(fine - half) < 0.01 * abs(1 - fine)) == (counts == [32])
    assert abs(fine - half) < 0.02 * abs(1 - fine)
    assert found == pytest.approx(np.abs(np.linalg.eigvals(mathieu(-matrix[1, 0], q, 512))).max(), rel=1e-3)


@pytest.mark.parametrize(("strength", "counts"), [(19.0, [32]), (22.0, [32, 128])])
def test_growth_near_one_is_believed_to_a_ten_millionth(strength, counts):
    """A speed that a damper of mean -1e-6 swings: exp(1e-6) in a period, the swings leave nothing."""
    matrix, asked = np.array([[0.0, 1.0], [0.0, 1e-6]]), []

    def coupling(phase):
        asked.append(len(phase))
        return strength * np.sin(phase)[:, None, None] * np.array([0.0, 1.0])

    found = multipliers(matrix, coupling, 1.0)
    assert asked == counts
    assert np.abs(found[0]) == pytest.approx(np.exp(1e-6), abs=1e-8)


def test_a_bound_is_that_of_the_component_where_it_is_largest():
    assert largest(np.array([[1.0 + 0j, -2.0], [3.0j, 0.5], [-4.0, 0.0]])) == pytest.approx(8.0)
    assert largest(np.zeros((0, 2), dtype=complex)) == 0.0


def test_phases_are_a_period_from_the_first_on():
    assert phases(4) == pytest.approx([0.0, np.pi / 2, np.pi, 3 * np.pi / 2])
    assert phases(4, 0.5) == pytest.approx(np.pi / 4 * np.array([1, 3, 5, 7]))


def test_who_cannot_be_told_is_told_with_all_and_with_half_the_samples(monkeypatch):
    """The last tried, 2048 and 1024 of a period; a multiplier is told by its size."""
    monkeypatch.setattr(floquet, "monodromy", lambda a, w, period: np.diag([0.5, -3.0 - 1000.0 / len(w)]))
    words = f"multiplied by {3 + 1000 / 2048:.6g} in a period, or by {3 + 1000 / 1024:.6g} with half the samples; add"
    with pytest.raises(ConvergenceError, match=re.escape(words)):
        multipliers(np.eye(2), lambda phase: phase, 1.0)


def test_multipliers_come_with_the_largest_first_whatever_their_signs(monkeypatch):
    monkeypatch.setattr(floquet, "monodromy", lambda a, w, period: np.diag([0.9, -0.95, 0.1, -0.3]))
    assert multipliers(np.eye(4), lambda phase: phase, 1.0) == pytest.approx([-0.95, 0.9, -0.3, 0.1])


def test_a_coupling_by_rates_too_is_followed():
    """Of two coordinates and a memory, by an independent integrator: forces of four states, another at each instant."""
    rng, period, size, free = np.random.default_rng(4), 2.0, 7, 2
    matrix, parts = rng.normal(size=(size, size)), random_harmonics(rng, 3, free, 2 * free)

    def coupling(phase):
        return synthesized(parts.reshape(3, -1), phase).reshape(-1, free, 2 * free)

    def rates(t, y):
        z = y.reshape(size, size)
        out = matrix @ z
        out[free : 2 * free] += coupling(np.array([2 * np.pi * t / period]))[0] @ z[: 2 * free]
        return out.ravel()

    done = solve_ivp(rates, (0.0, period), np.eye(size).ravel(), method="DOP853", rtol=1e-12, atol=1e-12)
    truth = done.y[:, -1].reshape(size, size)
    errors = [np.abs(monodromy(matrix, coupling(phases(count)), period) - truth).max() for count in (64, 128, 256)]
    assert errors[2] < 1e-6 * np.abs(truth).max()
    assert all(2**5 < coarse / fine < 2**8 for coarse, fine in itertools.pairwise(errors))
