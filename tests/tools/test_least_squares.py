"""Levenberg-Marquardt least squares."""

import numpy as np
import pytest

from vsb.tools.least_squares import levenberg_marquardt


def test_converges_in_rosenbrocks_valley():
    def residual(x):
        return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])

    def jacobian(x):
        return np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])

    assert levenberg_marquardt(residual, jacobian, np.array([-1.2, 1.0])) == pytest.approx([1.0, 1.0], abs=1e-3)
    near = levenberg_marquardt(residual, jacobian, np.array([-1.2, 1.0]), 1.0)
    assert 1e-3 < residual(near) @ residual(near) <= 1.0


@pytest.mark.parametrize(("start", "tried"), [(0.0, 2), (1e-3, 3)])
def test_stops_at_a_stationary_residual(start, tried):
    """x - 1 and x + 1 leave 2 at x = 0."""
    asked = []

    def residual(x):
        asked.append(x)
        return np.array([x[0] - 1.0, x[0] + 1.0])

    found = levenberg_marquardt(residual, lambda x: np.ones((2, 1)), np.array([start]))
    assert found == pytest.approx([0.0], abs=1e-5)
    assert len(asked) <= tried


def steps(residual, jacobian, x, enough=0.0):
    """Where residuals and their slopes were asked for."""
    asked, sloped = [], []

    def recorded(x):
        asked.append(x.copy())
        return residual(x)

    def slopes(x):
        sloped.append(x.copy())
        return jacobian(x)

    return levenberg_marquardt(recorded, slopes, np.array(x), enough), asked, sloped


def test_rank_deficient_jacobian():
    """Two unknowns that appear only as their sum."""
    found, asked, _ = steps(
        lambda x: np.array([x[0] + x[1] - 2.0, 1e3 * (np.tanh(0.1 * (x[0] + x[1])) - np.tanh(0.2))]),
        lambda x: np.array([[1.0, 1.0], 2 * [100.0 / np.cosh(0.1 * (x[0] + x[1])) ** 2]]), [30.0, 0.0],
    )  # fmt: skip
    assert found.sum() == pytest.approx(2.0, rel=1e-3)
    assert len(asked) < 200
