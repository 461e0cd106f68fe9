"""A body drawn in waves: the lines its hull is cut in, and their rigid motion."""

import numpy as np
import pytest
import xarray as xr

from vsb.engine.hydro.bodies.body import FlexibleBody
from vsb.engine.hydro.bodies.hulls import hull_panels
from vsb.engine.hydro.bodies.mesh import joined, wetted
from vsb.engine.hydro.bodies.outline import cut
from vsb.engine.hydro.bodies.plain_hulls import BoxHull, SphereHull
from vsb.report.animation import displaced_outline

CENTRE = np.array([0.0, 0.0, 1.0])


def floating(*hulls):
    """Bodies that heave, and pitch about a point above still water, by hull and its place along y."""
    parts = []
    for hull, y in hulls:
        vertices, faces = hull_panels(hull)
        wet = wetted(vertices, faces)
        parts.append((wet.vertices + np.array([0.0, y, 0.0]), wet.faces))
    vertices, faces = joined(parts) if len(parts) > 1 else parts[0]
    shapes = np.array([np.tile([0.0, 0.0, 1.0], (len(vertices), 1)), np.cross([0.0, 1.0, 0.0], vertices - CENTRE)])
    return FlexibleBody(
        vertices, faces, ("Heave", "Pitch"), shapes[:, faces].mean(axis=2), shapes, centre_of_mass=CENTRE
    )


@pytest.fixture
def box():
    hull = BoxHull(kind="box", length=8.0, width=4.0, height=3.0, draft=2.0, panel=1.0)
    return cut(floating((hull, 0.0)))


def test_corner_of_a_box_moves_as_heave_and_pitch_do(box):
    """Linear: x + theta (z - z0), z + heave - theta x; a positive pitch takes the bow, x > 0, down."""
    heave, theta = np.array([0.0, 0.3]), np.array([0.0, 0.02])
    position = xr.DataArray(np.array([theta, heave]).T, {"dof": ["Pitch", "Heave"]}, ("time", "dof"))
    rest, moved = displaced_outline(box, position)
    ends = box.outline.values
    assert (ends.min(axis=(0, 1)), ends.max(axis=(0, 1))) == (pytest.approx([-4, 0, -2]), pytest.approx([4, 0, 0]))
    lengths = np.linalg.norm(rest[:, 1] - rest[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(8.0 + 2 * 2.0)
    corner = np.isclose(rest, [4.0, -2.0]).all(axis=-1)
    assert corner.sum() == 2, "of the bottom and of the bow"
    expected = [4.0 + 0.02 * (-2.0 - 1.0), -2.0 + 0.3 - 0.02 * 4.0]
    np.testing.assert_allclose(moved[corner], [expected, expected], atol=1e-12)


def test_every_part_is_cut_through_its_own_middle():
    """Two spheres beside each other: half circles of their radius, as well as panels are spheres."""
    sphere = SphereHull(kind="sphere", radius=3.0, draft=3.0, panel=0.5)
    ends = cut(floating((sphere, -5.0), (sphere, 5.0))).outline.values
    assert set(ends[..., 1].round(9).ravel()) == {-5.0, 5.0}
    np.testing.assert_allclose(np.linalg.norm(ends[..., ::2], axis=-1), 3.0, rtol=0.02)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(2 * 3.0 * np.pi, rel=0.02)
