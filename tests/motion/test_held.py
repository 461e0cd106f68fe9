"""Unrestrained motions: closed form for a mooring line at any angle, every further line, normal modes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.motion.frequency import drifting_motions, normal_modes, softest

RIGID = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
WATER = np.diag([0.0, 0.0, 1.2e5, 8e4, 8e4, 0.0])


def moored(*lines, water=WATER):
    """Stiffness of lines k a a^T beside the water's."""
    return water + sum(k * np.outer(a, a) for k, a in lines)


def line(degrees, height=0.0, arm=0.0):
    """How a horizontal line of a direction pulls: at a height above the centre, past it at an arm."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([c, s, 0.0, -height * s, height * c, arm])


@given(angle=st.floats(0.0, 360.0), exponent=st.floats(-3.0, 9.0), height=st.sampled_from([0.0, -1.5, 2.0]))
def test_single_line_leaves_sway_across_it_and_yaw(angle, exponent, height):
    stiffness = moored((10.0**exponent, line(angle, height)))
    loose = drifting_motions(stiffness, RIGID, np.eye(6))
    across = np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle)), 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(loose @ loose.T, np.outer(across, across) + np.diag([0.0] * 5 + [1.0]), atol=1e-8)
    assert softest(stiffness, loose)[0] > 0.0


@pytest.mark.parametrize(
    ("lines", "left"),
    [
        ([], 3),
        ([(2e4, line(20.0))], 2),
        ([(2e4, line(20.0)), (1e3, line(21.0))], 1),
        ([(2e4, line(20.0, arm=2.0))], 2),
        ([(2e4, line(20.0, arm=2.0)), (2e4, line(20.0, arm=-2.0))], 1),
        ([(2e4, line(20.0)), (2e4, line(110.0)), (1.0, line(20.0, arm=2.0))], 0),
    ],
)
def test_every_independent_line_restrains_one_more_motion(lines, left):
    stiffness = moored(*lines)
    loose = drifting_motions(stiffness, RIGID, np.eye(6))
    assert loose.shape == (6, left)
    np.testing.assert_allclose(loose.T @ loose, np.eye(left), atol=1e-12)
    np.testing.assert_allclose(stiffness @ loose, 0.0, atol=1e-10)
    np.testing.assert_allclose(loose[2:5], 0.0, atol=1e-15)  # surge, sway and yaw alone
    least, motion = softest(stiffness, loose)
    assert least > 0.0
    np.testing.assert_allclose(motion @ stiffness @ motion, least, rtol=1e-9)
    np.testing.assert_allclose(loose.T @ motion, 0.0, atol=1e-10)


@pytest.mark.parametrize("share", [1e-3, 1e-6, 1e-9])
def test_weak_restraint_is_not_neglected(share):
    """The softest motion is across the line with the given stiffness, of either sign."""
    for sign in (1.0, -1.0):
        stiffness = moored((2e4, line(20.0)), (sign * share * 2e4, line(110.0)))
        loose = drifting_motions(stiffness, RIGID, np.eye(6))
        assert loose.shape == (6, 1)  # yaw
        least, motion = softest(stiffness, loose)
        assert least == pytest.approx(sign * share * 2e4, rel=1e-5)
        np.testing.assert_allclose(np.abs(motion), np.abs(line(110.0)), atol=1e-6)


def test_indefinite_mooring_is_detected():
    """K v of surge is not zero though v.K v is."""
    stiffness = WATER.copy()
    stiffness[0, 1] = stiffness[1, 0] = 3e3
    loose = drifting_motions(stiffness, RIGID, np.eye(6))
    assert loose.shape == (6, 1)
    assert softest(stiffness, loose)[0] == pytest.approx(-3e3)


def test_normal_modes_with_unrestrained_motions():
    """Beside them those of the line and of the water, each of its own mass, whatever couples them."""
    rng = np.random.default_rng(7)
    mass = np.diag([2e4, 2.5e4, 3e4, 9e3, 8e3, 7e3])
    mass[0, 4] = mass[4, 0] = 4e3
    mass[1, 3] = mass[3, 1] = -5e3
    for angle in rng.uniform(0.0, 360.0, 20):
        stiffness = moored((2e4, line(angle, height=-1.5)))
        loose = drifting_motions(stiffness, RIGID, np.eye(6))
        squares, modes = normal_modes(stiffness, mass, loose)
        assert (squares[:2] == 0.0).all()
        assert (np.diff(squares) >= 0.0).all()
        np.testing.assert_allclose(modes.T @ mass @ modes, np.eye(6), atol=1e-10)
        np.testing.assert_allclose(modes.T @ stiffness @ modes, np.diag(squares), atol=1e-10 * squares[-1])
        reckoned = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
        np.testing.assert_allclose(squares, reckoned, rtol=1e-9, atol=1e-9)
    whole = np.diag([2e4, 0.0, 1e5, 8e4, 8e4, 1e3])  # sway is unrestrained as it is
    squares, modes = normal_modes(whole, mass, drifting_motions(whole, RIGID, np.eye(6)))
    assert squares[0] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(modes.T @ whole @ modes, np.diag(squares), atol=1e-10 * squares[-1])
    assert not modes[[0, 2, 4, 5], 0].any()
    turned = np.arange(6)[::-1]  # what couples to it comes first
    whole, coupled, labels = whole[np.ix_(turned, turned)], mass[np.ix_(turned, turned)], RIGID[::-1]
    squares, modes = normal_modes(whole, coupled, drifting_motions(whole, labels, np.eye(6)))
    assert (squares == 0.0).sum() == 1
    np.testing.assert_allclose(modes.T @ whole @ modes, np.diag(squares), atol=1e-10 * squares[-1])
    np.testing.assert_allclose(modes.T @ coupled @ modes, np.eye(6), atol=1e-10)
    squares, modes = normal_modes(np.diag([4.0, 18.0]), np.diag([1.0, 2.0]), np.zeros((2, 0)))
    np.testing.assert_allclose(squares, [4.0, 9.0])
    np.testing.assert_allclose(np.abs(modes), np.diag([1.0, np.sqrt(0.5)]))
