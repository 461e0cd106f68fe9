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


def steps(residual, jacobian, x, enough=0.0):
    """Where residuals and their slopes were asked for."""
    asked, sloped = [], []

    def told(x):
        asked.append(x.copy())
        return residual(x)

    def slopes(x):
        sloped.append(x.copy())
        return jacobian(x)

    return levenberg_marquardt(told, slopes, np.array(x), enough), asked, sloped


def curve(x):
    return np.array([np.exp(x[0]) - 3.0, x[0] * x[1] - 2.0, x[1] ** 3 - 1.0])


def curve_slope(x):
    return np.array([[np.exp(x[0]), 0.0], [x[1], x[0]], [0.0, 3 * x[1] ** 2]])


@pytest.mark.parametrize("start", [[-1.0, 2.0], [4.0, -1.0], [0.0, 0.0]])
def test_least_squares_go_by_the_slopes_where_they_are_and_by_nielsen_s_damping(start):
    """Each step written out: mu/3 to 1 - (2 gain - 1)^3 of the damping after a gain, 2, 4, 8, ... times after a loss."""
    found, asked, sloped = steps(curve, curve_slope, start)
    x, slope = np.array(start), curve_slope(np.array(start))
    mu, growth, gained = 1e-3 * (slope**2).sum(axis=0).max(), 2.0, 1
    for tried in asked[1:]:
        r = curve(x)
        step = np.linalg.solve(slope.T @ slope + mu * np.eye(2), -slope.T @ r)
        assert tried == pytest.approx(x + step, rel=1e-9, abs=1e-12)
        fell = r @ r - curve(tried) @ curve(tried)
        promised = r @ r - (r + slope @ step) @ (r + slope @ step)
        if fell > 0:
            x, slope = tried, curve_slope(tried)
            assert sloped[gained] == pytest.approx(x)
            mu, growth, gained = mu * max(1 / 3, 1 - (2 * fell / promised - 1) ** 3), 2.0, gained + 1
        else:
            mu, growth = mu * growth, 2 * growth
    assert gained > 3
    assert found == pytest.approx(x)
    assert np.linalg.norm(curve_slope(found).T @ curve(found)) < 0.1 * np.linalg.norm(curve(found))


def test_least_squares_end_as_soon_as_no_more_than_enough_is_left():
    """One step of a straight line leaves a millionth and less: what is left may be just as much as is enough."""
    plain = steps(lambda x: x - 1.0, lambda x: np.eye(1), [0.0])
    left = float((plain[1][1][0] - 1.0) ** 2)
    exactly, less = (steps(lambda x: x - 1.0, lambda x: np.eye(1), [0.0], e) for e in (left, 0.99 * left))
    assert len(exactly[1]) == 2
    assert len(less[1]) > 2


def test_least_squares_stand_slopes_without_full_rank():
    """Of two unknowns that come as their sum, however small the damping has become."""
    found, asked, _ = steps(
        lambda x: np.array([x[0] + x[1] - 2.0, 1e3 * (np.tanh(0.1 * (x[0] + x[1])) - np.tanh(0.2))]),
        lambda x: np.array([[1.0, 1.0], 2 * [100.0 / np.cosh(0.1 * (x[0] + x[1])) ** 2]]), [30.0, 0.0],
    )  # fmt: skip
    assert found.sum() == pytest.approx(2.0, rel=1e-3)
    assert len(asked) < 200
