"""Powers between nodes: a rule of order six, and derivatives of products."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from vsb.integrators.works import driven_at, integrated, product


def jet(polynomial, time):
    """Value and first two derivatives, shape (3, node)."""
    return np.array([polynomial.deriv(k)(time) if k else polynomial(time) for k in range(3)])


@pytest.mark.parametrize("degree", range(6))
def test_powers_of_degree_five_are_integrated_exactly(degree):
    power, time = Polynomial.basis(degree) * 3.0, np.array([0.2, 0.5, 1.3])
    exact = power.integ()(time[1:]) - power.integ()(time[:-1])
    values = jet(power, time)
    np.testing.assert_allclose(integrated(values[:, :-1], values[:, 1:], np.diff(time)), exact, rtol=1e-13)


def test_other_powers_are_integrated_with_order_six():
    def rest(count):
        time = np.linspace(0.0, 2.0, count + 1)
        values = np.array([np.sin(3 * time), 3 * np.cos(3 * time), -9 * np.sin(3 * time)])
        return integrated(values[:, :-1], values[:, 1:], np.diff(time)).sum() - (1 - np.cos(6.0)) / 3

    errors = np.abs([rest(n) for n in (8, 16, 32)])
    slopes = np.diff(np.log2(errors))
    assert np.all(np.abs(slopes + 6) < 0.2), slopes


def test_a_product_and_its_derivatives():
    time = np.linspace(0.0, 1.0, 5)
    a, b = (np.stack([jet(p, time) for p in parts], axis=-1) for parts in (
        (Polynomial([1, 2, 3]), Polynomial([0, 1])), (Polynomial([2, -1]), Polynomial([1, 0, 0, 4]))))  # fmt: skip
    whole = Polynomial([1, 2, 3]) * Polynomial([2, -1]) + Polynomial([0, 1]) * Polynomial([1, 0, 0, 4])
    np.testing.assert_allclose(product(a, b), jet(whole, time), atol=1e-12)


def test_waves_and_their_derivatives_at_nodes_whether_or_not_these_are_equally_spaced():
    class Driven:
        omega, waves = np.array([1.0, 2.5]), np.array([[1.0 + 2.0j, 0.5], [0.3j, -1.0 + 0j]])

    time, regular = np.array([0.0, 0.1, 0.13, 0.2]), np.array([True, True, False, True])
    found = driven_at(Driven, time, regular)
    for k in range(3):
        phasors = Driven.waves * (-1j * Driven.omega[:, None]) ** k
        exact = np.real(np.exp(-1j * np.outer(time, Driven.omega)) @ phasors)
        np.testing.assert_allclose(found[k], exact, atol=1e-12)
