"""Matrix exponentials and phi functions: closed forms, doubling, round-off of stiff matrices."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import expm

from vsb.integrators.phi import doubled, is_small, lagrange, phi_integrals


@given(st.floats(-50.0, 3.0).filter(lambda x: abs(x) > 0.1))
def test_integrals_of_a_number(x):
    _, whole, (one, two, three) = phi_integrals(np.array([[x]]), np.eye(1), 1.0, 3)
    e = np.exp(x)
    assert whole[0, 0] == pytest.approx(e, rel=1e-12)
    assert one[0, 0] == pytest.approx((e - 1) / x, rel=1e-12)
    assert two[0, 0] == pytest.approx((e - 1 - x) / x**2, rel=1e-10)
    assert three[0, 0] == pytest.approx((e - 1 - x - x**2 / 2) / x**3, rel=1e-9)


def test_doubled_integrals_are_those_of_twice_the_span():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(6, 6)), rng.normal(size=(6, 2))
    one, two = (phi_integrals(a, b, h, 5) for h in (0.07, 0.14))
    assert is_small(a, 1e-3)
    assert not is_small(a, 1.0)
    for found, wanted in zip(doubled(one), two, strict=True):
        assert found == pytest.approx(wanted, abs=1e-14)
    assert two.exponential == pytest.approx(expm(0.14 * a), abs=1e-14)


def test_response_to_a_polynomial():
    """Of an oscillator of 1000 rad/s over many turns, pushed by x^3, x = t/unit."""
    w, h, unit = 1000.0, 0.1, 0.02
    a, b = np.array([[0.0, w], [-w, 0.0]]), np.array([[0.0], [1.0]])
    found = phi_integrals(a, b, h, 4).of_polynomials(np.eye(4)[:, 3:], unit)
    exact = [
        quad(lambda s: (s / unit) ** 3, 0, h, weight=kind, wvar=w)[0] for kind in ("cos", "sin")
    ]  # of cos ws and sin ws
    turn = np.array([[np.sin(w * h), -np.cos(w * h)], [np.cos(w * h), np.sin(w * h)]])
    assert found[0, 0] == pytest.approx(turn @ exact, rel=1e-9)


@given(st.lists(st.integers(-6, 2), min_size=2, max_size=7, unique=True))
def test_lagrange_polynomials_are_one_at_their_own_node_and_zero_at_others(nodes):
    nodes = np.array(nodes, dtype=float)
    assert np.vander(nodes, increasing=True) @ lagrange(nodes) == pytest.approx(np.eye(len(nodes)), abs=1e-8)


@pytest.mark.parametrize(("share", "small"), [(1.0, True), (1.0 + 1e-12, False), (0.5, True)])
def test_a_series_serves_up_to_a_norm_of_a_half(share, small):
    """Of the columns, signs left out."""
    a = np.array([[1.0, -3.0], [0.5, -1.0]])
    assert is_small(a, share * 0.125) is small


def test_integrals_are_as_many_as_asked_for_and_of_their_span():
    rng = np.random.default_rng(3)
    found = phi_integrals(rng.normal(size=(3, 3)), rng.normal(size=(3, 2)), 5.0, 4)
    assert (found.span, found.integrals.shape) == (5.0, (4, 3, 2))
