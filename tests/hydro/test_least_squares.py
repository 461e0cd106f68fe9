"""Levenberg-Marquardt least squares."""

import numpy as np
import pytest

from vsb.engine.hydro.radiation import levenberg_marquardt


def test_converges_in_rosenbrocks_valley():
    def residual(x):
        return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])

    def jacobian(x):
        return np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])

    assert levenberg_marquardt(residual, jacobian, np.array([-1.2, 1.0])) == pytest.approx([1.0, 1.0], abs=1e-3)
    near = levenberg_marquardt(residual, jacobian, np.array([-1.2, 1.0]), 1.0)
    assert 1e-3 < residual(near) @ residual(near) <= 1.0


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
