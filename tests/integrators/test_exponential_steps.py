"""Matrices of the exponential Adams steps: exact where what drives is a polynomial, of order six elsewhere."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from vsb.integrators import exponential_steps
from vsb.integrators.exponential_steps import HISTORY, KEPT, PAST, step_matrices
from vsb.integrators.phi import phi_integrals

A = np.array([[0.0, 3.0], [-3.0, -0.4]])
B = np.array([[0.0], [1.0]])
START = np.array([0.3, -1.0])


def steps(d, part=0.618):
    """Matrices of a step of size d, recorded at its half."""
    return step_matrices(*(phi_integrals(A, B, span, KEPT + 1) for span in (d, part * d, d / 2)), 1)


def exact(push, d):
    forced = quad_vec(lambda s: expm((d - s) * A) @ B[:, 0] * push(s), 0.0, d, epsabs=1e-14)[0]
    return expm(d * A) @ START + forced


@pytest.mark.parametrize("degree", range(PAST))
def test_a_push_that_past_values_continue_is_followed_exactly(degree):
    d = 0.2
    step, past = steps(d), (-d * np.arange(PAST)) ** degree
    found = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
    np.testing.assert_allclose(found, exact(lambda s: s**degree, d), atol=1e-13)


def test_the_new_value_corrects_one_degree_more():
    d = 0.2
    step, past = steps(d), (-d * np.arange(PAST)) ** PAST
    ahead = np.polyval(np.polyfit(-d * np.arange(PAST), past, PAST - 1), d)
    predicted = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
    found = predicted + (d**PAST - ahead) * step.corrected[0]
    np.testing.assert_allclose(found, exact(lambda s: s**PAST, d), atol=1e-13)


def test_predictions_err_with_the_sixth_power_of_the_step():
    errors = []
    for d in (0.04, 0.02, 0.01):
        step, past = steps(d), np.cos(1.4 - 4.0 * d * np.arange(PAST))
        found = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
        errors.append(np.abs(found - exact(lambda s: np.cos(1.4 + 4.0 * s), d)).max())
    slopes = np.diff(np.log2(errors))
    assert np.all(np.abs(slopes + 6) < 0.4), slopes


@pytest.mark.parametrize(("between", "accepted"), [(0.0, True), (0.5, True), (2.0, False)])
def test_what_forces_do_between_nodes_counts_as_error_of_a_step(monkeypatch, between, accepted):
    """At its nodes a step without a push has no error; one found between them, in limits, is put down or refused."""
    step, dt, tolerance, horizon = steps(0.1), 0.1, 1e-6, 2.0
    limit = exponential_steps.SAFE * tolerance * 1.5 * 0.1 / horizon

    def still(r, t, p, out):
        out[:] = 0.0

    monkeypatch.setattr(exponential_steps, "remainder", still)
    monkeypatch.setattr(exponential_steps, "_unseen", lambda *_: (between * limit, 1))
    z, past, places = START.copy(), np.zeros((HISTORY, 1)), np.zeros((HISTORY, 1))
    counters, levels = np.array([0, KEPT, 0, 0, 0]), np.array([1.5, 0.0, 0.0])
    out, pushes = np.zeros((2, 2)), np.zeros((2, 1))
    change = exponential_steps.march.py_func(
        SimpleNamespace(round_off=0.0), step, dt, 0, tolerance, horizon, z, past, places, counters, levels, out, pushes
    )
    assert change == (0 if accepted else -1)
    assert counters.tolist() == [2**20, KEPT + 1, 1, 2, 0] if accepted else [0, 0, 1, 2, HISTORY]
    np.testing.assert_allclose(out[1], expm(dt * A) @ START if accepted else 0.0, atol=1e-13)
    if accepted:
        np.testing.assert_allclose(levels, [1.5, between, (1 - between) * limit], rtol=1e-12, atol=0.0)
