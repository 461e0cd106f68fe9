"""Phi functions and the exponential Adams steps made of them: closed forms, exactness, order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, quad_vec
from scipy.linalg import expm

from vsb.integrators.exponential import KEPT, PAST, doubled, lagrange, phi_integrals, step_matrices

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
def test_polynomial_forcing_is_integrated_exactly(degree):
    d = 0.2
    step, past = steps(d), (-d * np.arange(PAST)) ** degree
    found = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
    np.testing.assert_allclose(found, exact(lambda s: s**degree, d), atol=1e-13)


def test_corrector_is_exact_for_one_degree_more():
    d = 0.2
    step, past = steps(d), (-d * np.arange(PAST)) ** PAST
    ahead = np.polyval(np.polyfit(-d * np.arange(PAST), past, PAST - 1), d)
    predicted = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
    found = predicted + (d**PAST - ahead) * step.corrected[0]
    np.testing.assert_allclose(found, exact(lambda s: s**PAST, d), atol=1e-13)


def test_predictor_error_is_of_sixth_order():
    errors = []
    for d in (0.04, 0.02, 0.01):
        step, past = steps(d), np.cos(1.4 - 4.0 * d * np.arange(PAST))
        found = START @ step.free + np.einsum("i,ij->j", past, step.forced[:, 0])
        errors.append(np.abs(found - exact(lambda s: np.cos(1.4 + 4.0 * s), d)).max())
    slopes = np.diff(np.log2(errors))
    assert np.all(np.abs(slopes + 6) < 0.4), slopes


@given(st.floats(-50.0, 3.0).filter(lambda x: abs(x) > 0.1))
def test_scalar_phi_functions_have_their_closed_form(x):
    _, whole, (one, two, three) = phi_integrals(np.array([[x]]), np.eye(1), 1.0, 3)
    e = np.exp(x)
    assert whole[0, 0] == pytest.approx(e, rel=1e-12)
    assert one[0, 0] == pytest.approx((e - 1) / x, rel=1e-12)
    assert two[0, 0] == pytest.approx((e - 1 - x) / x**2, rel=1e-10)
    assert three[0, 0] == pytest.approx((e - 1 - x - x**2 / 2) / x**3, rel=1e-9)


def test_doubling_the_integrals_doubles_the_span():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(6, 6)), rng.normal(size=(6, 2))
    one, two = (phi_integrals(a, b, h, 5) for h in (0.07, 0.14))
    for found, wanted in zip(doubled(one), two, strict=True):
        assert found == pytest.approx(wanted, abs=1e-14)
    assert two.exponential == pytest.approx(expm(0.14 * a), abs=1e-14)


def test_response_of_an_oscillator_to_a_polynomial():
    """An oscillator of 1000 rad/s over many periods, forced by (t/unit)^3."""
    w, h, unit = 1000.0, 0.1, 0.02
    a, b = np.array([[0.0, w], [-w, 0.0]]), np.array([[0.0], [1.0]])
    found = phi_integrals(a, b, h, 4).of_polynomials(np.eye(4)[:, 3:], unit)
    exact = [quad(lambda s: (s / unit) ** 3, 0, h, weight=kind, wvar=w)[0] for kind in ("cos", "sin")]
    turn = np.array([[np.sin(w * h), -np.cos(w * h)], [np.cos(w * h), np.sin(w * h)]])
    assert found[0, 0] == pytest.approx(turn @ exact, rel=1e-9)


@given(st.lists(st.integers(-6, 2), min_size=2, max_size=7, unique=True))
def test_lagrange_polynomials_are_one_at_their_own_node_and_zero_at_others(nodes):
    nodes = np.array(nodes, dtype=float)
    assert np.vander(nodes, increasing=True) @ lagrange(nodes) == pytest.approx(np.eye(len(nodes)), abs=1e-8)
