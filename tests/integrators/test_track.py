"""Nodes of a switching run as they are found."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from vsb.integrators.track import SOON, Lookout, Mode, Track, dips, sign


def test_nodes_keep_their_modes_and_the_last_one_how_it_was_left():
    track = Track(Lookout(0.1))
    track.add(np.array([0.0, 0.1]), np.array([[1.0, 0.0], [3.0, 4.0]]), Mode(1), np.array([True, True]))
    track.switch(0.15, np.array([0.0, 2.0]), Mode(-1, limited=1))
    track.leave(np.array([0.0, 7.0]), 1e-9)
    track.leave(np.array([0.0, 8.0]), 2e-9)
    assert track.modes == [Mode(1), Mode(1), Mode(-1, limited=1)]
    assert np.concatenate(track.regular).tolist() == [True, True, False]
    np.testing.assert_array_equal(np.concatenate(track.states)[-1], [0.0, 2.0])
    np.testing.assert_array_equal(np.concatenate(track.leaving), [[1.0, 0.0], [3.0, 4.0], [0.0, 8.0]])
    assert track.events == [0.15]
    assert track.error == pytest.approx(3e-9)
    assert track.largest == 5.0
    assert track.nodes() == {Mode(1): [0, 1], Mode(-1, limited=1): [2]}


def test_events_of_one_instant_are_as_many_as_there_are():
    """A take-off that chatters without time going on is given up by their number."""
    track = Track(Lookout(0.1))
    for k, t in enumerate([0.2, 0.2, 0.2, 0.3]):
        track.switch(t, np.array([float(k)]), Mode((-1) ** k))
    assert track.events == [0.2, 0.2, 0.2, 0.3]
    assert track.nodes() == {Mode(1): [0, 2], Mode(-1): [1, 3]}


def test_only_the_last_of_nodes_added_together_is_left_otherwise():
    track = Track(Lookout(0.1))
    states = np.arange(6.0).reshape(3, 2)
    track.add(0.1 * np.arange(3), states, Mode(1), np.ones(3, dtype=bool))
    track.leave(np.array([7.0, 8.0]), 0.0)
    np.testing.assert_array_equal(track.leaving[0], [[0.0, 1.0], [2.0, 3.0], [7.0, 8.0]])
    np.testing.assert_array_equal(track.states[0], states)


@pytest.mark.parametrize(("contact", "i", "far", "steps"), [
    (0, 0, 2, [4, 8]), (0, 5, 1, [8]), (0, 8, 1, [12]), (1, 5, 2, [6, 7]), (-1, 8, 1, [9]),
])  # fmt: skip
def test_a_stop_that_is_not_pressed_is_looked_for_in_whole_strides(contact, i, far, steps):
    """From an instant between two strides on the next one is that at the end of the stride begun."""
    lookout, mode = Lookout(0.1, 4), Mode(1, contact=contact)
    assert list(range(20))[lookout.ahead(mode, i, far)] == steps
    assert lookout.apart(mode) == pytest.approx(0.1 if contact else 0.4)


def test_a_mode_of_which_nothing_is_said_is_a_free_port_watched_at_every_step():
    assert Mode(1) == Mode(way=1, limited=0, contact=0, paused=False, until=np.inf)
    assert Lookout(0.1) == Lookout(step=0.1, stride=1)
    for mode in (Mode(1), Mode(1, contact=1), Mode(0)):
        assert Lookout(0.1).steps(mode) == 1


def test_the_sign_of_nothing_is_positive():
    assert [sign(value) for value in (-1e-300, 0.0, 2.0)] == [-1, 1, 1]


def parabola(bottom, depth, curvature=1.0):
    """Ends and rates over a span of curvature (s - bottom)^2 - depth."""
    ends = np.array([0.0, 1.0])
    return curvature * (ends - bottom) ** 2 - depth, 2 * curvature * (ends - bottom)


@pytest.mark.parametrize("bottom", [0.05, 0.4, 0.97])
def test_a_guard_dips_where_it_goes_below_zero_between_its_instants(bottom):
    assert dips(*parabola(bottom, 1e-9)) == [(0, pytest.approx(bottom, abs=1e-12))]
    assert dips(*parabola(bottom, -1e-9)) == []


def test_a_dip_behind_a_guard_that_hardly_falls_yet_is_where_its_cubic_has_it():
    """0.01 - 1e-12 s - s^2 + s^3 is lowest at 2/3, 0.14 below zero."""
    falling = -1e-12
    found = dips(np.array([0.01, 0.01 + falling]), np.array([falling, 1.0 + falling]))
    assert found == [(0, pytest.approx(2 / 3, abs=1e-9))]


@pytest.mark.parametrize(("part", "found"), [(1.1, 1), (0.9, 0)])
def test_a_bottom_right_behind_an_event_is_round_off_of_it(part, found):
    bottom = part * SOON
    assert len(dips(*parabola(bottom, 1e6 * bottom**2 / 2, 1e6))) == found


def test_of_many_spans_those_are_named_that_begin_above_zero_and_fall_and_end_rising():
    """Dips in the second and the last, which ends at zero; the fourth begins below it, the others do not turn."""
    values = np.array([2.0, 1.0, 1.0, -0.5, 0.5, 0.1, 0.0])
    rates = np.array([-1.0, -9.0, 9.0, -5.0, 5.0, -3.0, 3.0])
    found = dips(values, rates)
    assert [span for span, _ in found] == [1, 5]
    for span, part in found:
        cubic = CubicHermiteSpline([0, 1], values[span : span + 2], rates[span : span + 2])
        assert cubic(part, 1) == pytest.approx(0.0, abs=1e-9)
        assert cubic(part) < 0
