import numpy as np
import pytest

from vsb.tools.least_squares import levenberg_marquardt


def test_least_squares_follow_a_curved_valley():
    def residual(x):
        return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])

    def jacobian(x):
        return np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])

    assert levenberg_marquardt(residual, jacobian, np.array([-1.2, 1.0])) == pytest.approx([1.0, 1.0], abs=1e-3)
    near = levenberg_marquardt(residual, jacobian, np.array([-1.2, 1.0]), 1.0)
    assert 1e-3 < residual(near) @ residual(near) <= 1.0
