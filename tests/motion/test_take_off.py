"""Laws of take-offs and end stops as forces of stroke and velocity."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.motion.forces import EndStop, TakeOff

B = np.array([1.0, 0.5])
small = st.floats(-3.0, 3.0)


@given(small, small, small, small)
def test_saturated_spring_and_damper(y, x, vy, vx):
    q, v = np.array([[y, x]]), np.array([[vy, vx]])
    force = TakeOff(B, 4.0, 10.0, 5.0).force(np.zeros(1), q, v)
    wanted = 4.0 * (v @ B)[0] + 10.0 * (q @ B)[0]
    assert force[0] == pytest.approx(-np.clip(wanted, -5.0, 5.0) * B)


@given(small, small, small, st.floats(-2.0, 2.0))
def test_spring_and_stop_are_relative_to_the_rest_position(stroke, speed, slack, rest):
    one, at, v = np.array([1.0]), np.zeros(1), np.array([[speed]])
    for law in (TakeOff(one, 4.0, 10.0, 50.0), EndStop(one, 0.7, 100.0, 30.0)):
        moved = replace(law, rest=rest)
        q = np.array([[stroke], [slack]])
        assert moved.force(at, q + rest, v) == pytest.approx(law.force(at, q, v), abs=1e-9)
        assert moved.potential_energy(q + rest) == pytest.approx(law.potential_energy(q), abs=1e-9)


def test_friction_opposes_the_velocity():
    force = TakeOff(B, np.inf, limit=5.0).force(np.zeros(3), np.zeros((3, 2)), np.array([[2.0, 0], [-1e-9, 0], [0, 0]]))
    assert force[:, 0].tolist() == [-5.0, 5.0, 0.0]


@pytest.mark.parametrize("limit", [0.0, np.inf])
def test_friction_without_a_finite_limit_is_refused(limit):
    with pytest.raises(ValueError, match=f"friction: received a limit of {limit:g} N, needs a finite one above 0"):
        TakeOff(B, np.inf, limit=limit)


@given(small, small)
def test_end_stop_only_pushes(stroke, speed):
    """It returns what its spring stores and no more."""
    stop = EndStop(np.array([1.0]), 0.7, 100.0, 30.0)
    q, v = np.array([[stroke]]), np.array([[speed]])
    force = stop.force(np.zeros(1), q, v)[0, 0]
    assert force * stroke <= 0.0
    assert force == 0.0 or abs(stroke) > 0.7
    step = np.array([[1e-6]])
    gradient = (stop.potential_energy(q + step) - stop.potential_energy(q - step))[0] / 2e-6
    if abs(abs(stroke) - 0.7) > 1e-5:
        lost = -(force + gradient) * speed
        loading = abs(stroke) > 0.7 and stroke * speed > 0
        assert lost == pytest.approx(30.0 * speed**2 if loading else 0.0, abs=1e-5)


def test_end_stop_of_a_combined_port():
    """f = -b (k d + c V) for a stroke beyond by d; no damping when unloading."""
    stop = EndStop(B, 0.7, 100.0, 30.0, rest=0.2)
    q = np.array([[1.0, 0.4], [-1.0, -0.4], [1.0, 0.4], [-1.0, -0.4], [1.0, 0.4], [0.5, 0.8]])
    v = np.array([[2.0, 0.0], [-2.0, 0.0], [-2.0, 0.0], [2.0, 0.0], [0.0, 0.0], [2.0, 0.0]])
    pressed = np.array([0.3, -0.7, 0.3, -0.7, 0.3, 0.0])
    assert stop.beyond(q) == pytest.approx(pressed)
    pushed = -100.0 * pressed - 30.0 * np.array([2.0, -2.0, 0.0, 0.0, 0.0, 0.0])
    assert stop.force(np.zeros(6), q, v) == pytest.approx(np.outer(pushed, B))
    assert stop.potential_energy(q) == pytest.approx(50.0 * pressed**2)
