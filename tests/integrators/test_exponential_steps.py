"""Matrices of the exponential Adams steps: exact where what drives is a polynomial, of order six elsewhere."""

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from vsb.integrators.exponential_steps import KEPT, PAST, step_matrices
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
