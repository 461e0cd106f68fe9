import numpy as np
import pytest
from hydro.bodies.test_body import rigid

from examples import barge
from vsb.hydro.bodies.rigid import displaced, fitted_motion, rigid_motion


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("kind", range(6))
def test_a_motion_is_as_rigid_at_every_size(scale, kind):
    """Round-off is told from a rotation by the motion's own size; what bends at a part in a million is not rigid."""
    points = barge.box(6.0, 4.0, 2.0, 2)[0] + [3.0, -2.0, 0.7]
    moved = scale * rigid(points)[kind]
    found = rigid_motion(points, moved)
    assert np.concatenate(found) == pytest.approx(
        scale * np.eye(6)[kind], rel=1e-12, abs=0.0
    )  # the others exactly none
    assert rigid_motion(points, moved + 1e-6 * scale * points[:, :1] ** 2 * [0.0, 0.0, 1.0]) is None


@pytest.mark.parametrize(("reach", "kind"), [(1e4, 4), (1e4, 5), (1e-3, 3)])
def test_a_turn_counts_by_how_far_it_moves_the_points_beside_a_shift(reach, kind):
    """A ten thousand millionth of a radian moves what is ten kilometres away by a micrometre; round-off moves nothing."""
    points = reach * np.random.default_rng(1).uniform(-1, 1, (20, 3))
    moved = rigid(points)[0] + 1e-6 / reach * rigid(points)[kind]
    found = rigid_motion(points, moved)
    assert found.translation == pytest.approx([1.0, 0.0, 0.0], rel=1e-9)
    assert found.rotation == pytest.approx(1e-6 / reach * np.eye(3)[kind - 3], rel=1e-6)
    still = rigid_motion(points, rigid(points)[0] + 1e-10 / reach * rigid(points)[kind])
    assert still.rotation.tolist() == [0.0, 0.0, 0.0]


def test_single_precision_leaves_a_motion_rigid():
    points = barge.box(6.0, 4.0, 2.0, 2)[0]
    moved = 0.3 * rigid(points)[4] + rigid(points)[2]
    found = rigid_motion(points, moved.astype(np.float32).astype(float))
    assert found.translation == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert found.rotation == pytest.approx([0.0, 0.3, 0.0], abs=1e-6)


def test_a_part_that_hardly_moves_is_rigid_beside_what_moves():
    points = barge.box(6.0, 4.0, 2.0, 2)[0]
    noise = 1e-9 * np.random.default_rng(3).uniform(-1, 1, points.shape)
    assert rigid_motion(points, noise) is None
    assert np.concatenate(rigid_motion(points, noise, 1.0)) == pytest.approx(np.zeros(6), abs=1e-8)


def test_the_nearest_rigid_motion_is_left_by_what_it_cannot_do():
    points = barge.box(6.0, 4.0, 2.0, 2)[0]
    moved = rigid(points)[3] + 0.1 * points**2
    motion = fitted_motion(points, moved, 1.0)
    left = moved - displaced(motion, points)
    assert np.abs(np.einsum("kpx,px->k", rigid(points), left)).max() < 1e-9
