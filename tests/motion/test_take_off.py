"""Laws of take-offs and end stops as forces of stroke and velocity."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.motion.take_off import EndStop, TakeOff

B = np.array([1.0, 0.5])
small = st.floats(-3.0, 3.0)


@given(small, small, small, small)
def test_a_law_is_a_limited_spring_and_damper_at_its_port(y, x, vy, vx):
    q, v = np.array([[y, x]]), np.array([[vy, vx]])
    force = TakeOff(B, 4.0, 10.0, 5.0).force(np.zeros(1), q, v)
    wanted = 4.0 * (v @ B)[0] + 10.0 * (q @ B)[0]
    assert force[0] == pytest.approx(-np.clip(wanted, -5.0, 5.0) * B)


@given(small, small, small, st.floats(-2.0, 2.0))
def test_spring_and_stop_count_from_where_the_port_rests(stroke, speed, slack, rest):
    """The same law a distance further on."""
    one, at, v = np.array([1.0]), np.zeros(1), np.array([[speed]])
    for law in (TakeOff(one, 4.0, 10.0, 50.0), EndStop(one, 0.7, 100.0, 30.0)):
        moved = replace(law, rest=rest)
        q = np.array([[stroke], [slack]])
        assert moved.force(at, q + rest, v) == pytest.approx(law.force(at, q, v), abs=1e-9)
        assert moved.stored(q + rest) == pytest.approx(law.stored(q), abs=1e-9)


def test_a_law_of_which_nothing_more_is_said_is_a_damper_about_the_place_at_rest():
    law, stop = TakeOff(np.array([1.0, 0.5]), 8e3), EndStop(np.array([1.0, 0.5]), 2.0, 1e5, 1e3)
    assert law.coefficients(False) == (8e3, 0.0)
    assert (law.pause, law.limit, law.rest, stop.rest) == (0.0, np.inf, 0.0, 0.0)
    assert not law.force(np.zeros(1), np.array([[3.0, 1.0]]), np.zeros((1, 2))).any()


def test_friction_has_the_sign_of_the_velocity():
    force = TakeOff(B, np.inf, limit=5.0).force(np.zeros(3), np.zeros((3, 2)), np.array([[2.0, 0], [-1e-9, 0], [0, 0]]))
    assert force[:, 0].tolist() == [-5.0, 5.0, 0.0]


@pytest.mark.parametrize("limit", [0.0, np.inf])
def test_friction_without_a_limit_is_refused(limit):
    with pytest.raises(ValueError, match=f"friction: received a limit of {limit:g} N, needs a finite one above 0"):
        TakeOff(B, np.inf, limit=limit)


@given(small, small)
def test_an_end_stop_pushes_and_never_pulls(stroke, speed):
    """It gives back what its spring stores, by its gradient, and no more."""
    stop = EndStop(np.array([1.0]), 0.7, 100.0, 30.0)
    q, v = np.array([[stroke]]), np.array([[speed]])
    force = stop.force(np.zeros(1), q, v)[0, 0]
    assert force * stroke <= 0.0
    assert force == 0.0 or abs(stroke) > 0.7
    step = np.array([[1e-6]])
    gradient = (stop.stored(q + step) - stop.stored(q - step))[0] / 2e-6
    if abs(abs(stroke) - 0.7) > 1e-5:
        lost = -(force + gradient) * speed
        loading = abs(stroke) > 0.7 and stroke * speed > 0
        assert lost == pytest.approx(30.0 * speed**2 if loading else 0.0, abs=1e-5)


def test_in_a_pause_a_law_has_another_damper_and_no_spring():
    law = TakeOff(B, 4.0, 10.0, 5.0, pause=0.3, paused_damping=0.5)
    assert (law.coefficients(False), law.coefficients(True)) == ((4.0, 10.0), (0.5, 0.0))
    assert TakeOff(B, 4.0, 10.0, pause=0.3).coefficients(True) == (np.inf, 0.0)


@pytest.mark.parametrize("limit", [-5.0, np.nan])
def test_friction_of_no_size_is_refused(limit):
    with pytest.raises(ValueError, match=f"^friction: received a limit of {limit:g} N, needs a finite one above 0$"):
        TakeOff(B, np.inf, limit=limit)


def test_a_stop_at_a_port_of_several_motions_pushes_along_it_on_either_side():
    """f = -b (k d + c V) of a stroke beyond, d with its sign; unloading without the damper, and at rest without it."""
    stop = EndStop(B, 0.7, 100.0, 30.0, rest=0.2)
    q = np.array([[1.0, 0.4], [-1.0, -0.4], [1.0, 0.4], [-1.0, -0.4], [1.0, 0.4], [0.5, 0.8]])
    v = np.array([[2.0, 0.0], [-2.0, 0.0], [-2.0, 0.0], [2.0, 0.0], [0.0, 0.0], [2.0, 0.0]])
    pressed = np.array([0.3, -0.7, 0.3, -0.7, 0.3, 0.0])
    assert stop.beyond(q) == pytest.approx(pressed)
    pushed = -100.0 * pressed - 30.0 * np.array([2.0, -2.0, 0.0, 0.0, 0.0, 0.0])
    assert stop.force(np.zeros(6), q, v) == pytest.approx(np.outer(pushed, B))
    assert stop.stored(q) == pytest.approx(50.0 * pressed**2)
