"""Nodes of a switching run as they are found."""

import numpy as np
import pytest

from vsb.integrators.track import Mode, Track


def test_nodes_keep_their_modes_and_the_last_one_how_it_was_left():
    track = Track(0.1)
    track.add(np.array([0.0, 0.1]), np.array([[1.0, 0.0], [3.0, 4.0]]), Mode(1), regular=True)
    track.add(np.array([0.15]), np.array([[0.0, 2.0]]), Mode(-1, limited=1), regular=False)
    track.leave(np.array([0.0, 7.0]), 1e-9)
    track.leave(np.array([0.0, 8.0]), 2e-9)
    assert track.modes == [Mode(1), Mode(1), Mode(-1, limited=1)]
    assert np.concatenate(track.regular).tolist() == [True, True, False]
    np.testing.assert_array_equal(np.concatenate(track.states)[-1], [0.0, 2.0])
    np.testing.assert_array_equal(np.concatenate(track.leaving), [[1.0, 0.0], [3.0, 4.0], [0.0, 8.0]])
    assert track.error == pytest.approx(3e-9)
    assert track.largest == 5.0
