import numpy as np
import pytest
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from examples import barge
from vsb.engine.hydro.bodies import body as bodies
from vsb.engine.hydro.bodies.coarsening import coarser_body, coarser_panels

BOTH = ("xOz", "yOz")


def triangles(faces, seed):
    """Quadrilaterals cut along a diagonal drawn by lot."""
    turn = np.random.default_rng(seed).integers(0, 2, len(faces))
    q = np.array([np.roll(face, k) for face, k in zip(faces, turn, strict=True)])
    halves = np.stack([q[:, [0, 1, 2, 2]], q[:, [0, 2, 3, 3]]], axis=1).reshape(-1, 4)
    return halves[[len(set(half.tolist())) == 3 for half in halves]]


def areas(vertices, faces):
    """Vector areas of the panels."""
    x = vertices[faces]
    return np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]) / 2


def sides(vertices, faces):
    """Area of the panels that look along each axis, both ways, and what is left."""
    a = areas(vertices, faces)
    return np.array([*np.maximum(a, 0).sum(axis=0), *np.maximum(-a, 0).sum(axis=0), np.linalg.norm(a, axis=1).sum()])


@pytest.mark.parametrize(("panels", "planes"), [(1, ("xOz",)), (2, BOTH), (3, ())])
def test_box_becomes_the_box_of_half_the_resolution(panels, planes):
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2 * panels)
    (coarse, share), half = coarser_panels(vertices, faces, planes), barge.box(6.0, 4.0, 2.0, panels)

    def listed(x, f):
        return np.column_stack([x[f].mean(axis=1), areas(x, f)])

    ours, theirs = listed(vertices, coarse), listed(*half)
    assert len(ours) == len(theirs)
    assert share == pytest.approx(1.0)
    assert cKDTree(ours).query(theirs)[0].max() < 1e-9


@settings(max_examples=10)
@given(seed=st.integers(0, 10_000), length=st.floats(1.0, 100.0), panels=st.integers(1, 3))
@example(seed=77, length=1.0, panels=3)  # a corner that bends a side by 9 degrees
def test_sides_of_a_triangulated_box_keep_their_areas(seed, length, panels):
    vertices, faces = barge.box(length, 4.0, 2.0, panels)
    cut = triangles(faces, seed)
    coarse = coarser_panels(vertices, cut, ()).faces
    assert len(coarse) < 0.7 * len(cut)
    assert sides(vertices, coarse) == pytest.approx(sides(vertices, faces), rel=1e-12, abs=1e-9)
    assert len(np.unique(np.sort(coarse, axis=1), axis=0)) == len(coarse)


@pytest.mark.parametrize(("rows", "azimuth"), [(6, 16), (9, 20), (5, 18)])
def test_fewer_panels_of_a_sphere_keep_orientation_and_symmetry(rows, azimuth):
    body = revolved_body(shell_with(0.0), rows, (0,), azimuth)
    planes = bodies.SYMMETRIES[bodies.detected_symmetry(body)]
    coarse, share = coarser_panels(body.vertices, body.faces, planes)
    a, x = areas(body.vertices, coarse), body.vertices[coarse].mean(axis=1)
    assert len(coarse) < 0.4 * len(body.faces)
    assert share > 0.6
    assert np.all(np.sum(a * x, axis=1) > 0.85 * np.linalg.norm(a, axis=1) * np.linalg.norm(x, axis=1))
    assert np.linalg.norm(a, axis=1).sum() == pytest.approx(2 * np.pi, rel=0.12)
    for plane in planes:
        sign = np.where(np.arange(3) == bodies.PLANES[plane], -1.0, 1.0)
        assert cKDTree(x).query(x * sign)[0].max() < 1e-9


def test_displacements_are_those_of_the_corners():
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2)
    body = made(vertices, faces, rigid(vertices))
    fewer, _ = coarser_body(body, BOTH)
    assert fewer.labels == body.labels
    assert fewer.modes == pytest.approx(rigid(fewer.centres), abs=1e-12)
    assert fewer.volumes == pytest.approx(body.volumes)
