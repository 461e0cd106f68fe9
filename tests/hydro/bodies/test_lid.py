from itertools import pairwise

import numpy as np
import pytest
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with

from examples.barge import box
from vsb.engine.hydro.bodies.lid import first_irregular_frequency, gap_resonance, interior_lid
from vsb.engine.hydro.bodies.mesh import joined
from vsb.engine.hydro.panels import rings as bem


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


def disc_and_walls(radii, around=72, draught=0.2):
    """Wetted surface of a flat ring between two radii, or of a disc where the inner one is zero."""
    theta = 2 * np.pi * np.arange(around) / around
    circle, i = np.column_stack([np.cos(theta), np.sin(theta)]), np.arange(around)
    loops = [(radii[1], 0.0), (radii[1], -draught), (radii[0], -draught), (radii[0], 0.0)][: 4 if radii[0] else 3]
    vertices = np.vstack([np.column_stack([r * circle, np.full(around, z)]) for r, z in loops])
    faces = [
        np.column_stack([a + i, b + i, b + np.roll(i, -1), a + np.roll(i, -1)])
        for a, b in pairwise(around * np.arange(len(loops)))
    ]
    return vertices, np.concatenate(faces)


def test_lid_lies_inside_the_waterlines_with_normals_down():
    """A spar of 2 m in the moonpool of a ring."""
    vertices, faces = joined([disc_and_walls((3.0, 7.0)), disc_and_walls((0.0, 2.0))])
    lid, panels = interior_lid(made(vertices, faces, rigid(vertices)[2:3]), 8)
    corner = lid[panels]
    away = np.linalg.norm(corner[..., :2], axis=-1)
    assert (((away > 3.0) & (away < 7.0)) | (away < 2.0)).all()
    assert (away < 2.0).any()
    assert (away > 3.0).any()
    assert (np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])[:, 2] < 0).all()
    assert len(np.unique(corner.mean(axis=1).round(6), axis=0)) == len(panels)


def test_lower_bound_of_irregular_frequencies():
    vertices, faces = box(10.0, 8.0, 4.0, 1)
    body = made(vertices, faces, rigid(vertices)[2:3])
    p = np.pi * np.hypot(0.1, 0.125)
    assert first_irregular_frequency(body, 9.81) == pytest.approx(np.sqrt(9.81 * p / np.tanh(4 * p)), rel=1e-12)
    hemisphere = revolved_body(shell_with(0.0), 8, (1,), 16)
    assert 0.8 * 2.557 < first_irregular_frequency(hemisphere, 1.0) ** 2 < 2.557
    below = np.concatenate([faces, faces[:, ::-1] + len(vertices)])
    vertices = np.concatenate([vertices, vertices * [1, 1, -1]]) - [0.0, 0.0, 5.0]
    under = made(vertices, below, rigid(vertices)[2:3])
    assert first_irregular_frequency(under, 9.81) == np.inf
    assert interior_lid(under, 8) is None


def test_resonance_of_a_gap_between_two_bodies():
    """Ring of 3.3 to 5 m around a spar of 3 m: damping of heave peaks and added mass turns negative at 1.70 rad/s."""
    vertices, faces = joined([disc_and_walls((3.3, 5.0), draught=3.0), disc_and_walls((0.0, 3.0), draught=3.0)])
    found = gap_resonance(made(vertices, faces, rigid(vertices)[2:3]), 9.81)
    assert found.omega == pytest.approx(1.70, rel=0.01)
    assert found.width == pytest.approx(0.3, rel=1e-6)
    vertices, faces = joined([disc_and_walls((6.0, 8.0), draught=3.0), disc_and_walls((0.0, 3.0), draught=3.0)])
    assert gap_resonance(made(vertices, faces, rigid(vertices)[2:3]), 9.81) is None
