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


@pytest.mark.parametrize(("start", "tried"), [(0.0, 2), (1e-3, 3)])
def test_least_squares_end_where_no_step_promises_a_thousandth_of_what_is_left(start, tried):
    """x - 1 and x + 1 leave 2 at x = 0: nothing is to be gained there, and next to it a millionth."""
    asked = []

    def residual(x):
        asked.append(x)
        return np.array([x[0] - 1.0, x[0] + 1.0])

    found = levenberg_marquardt(residual, lambda x: np.ones((2, 1)), np.array([start]))
    assert found == pytest.approx([0.0], abs=1e-5)
    assert len(asked) <= tried
