from itertools import permutations

import numpy as np
import pytest
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from examples import barge
from vsb.hydro.bodies import body as bodies
from vsb.hydro.bodies.coarsening import (
    _around,
    _beside,
    _boundary,
    _cut,
    _flat,
    _smooth,
    _thinnest,
    _without_blunt_corners,
    coarser_body,
    coarser_panels,
)

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


@pytest.mark.parametrize("planes", [(), ("xOz",), BOTH])
@pytest.mark.parametrize("panels", [1, 2, 3])
def test_a_box_becomes_the_box_of_half_the_panels(panels, planes):
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2 * panels)
    (coarse, share), half = coarser_panels(vertices, faces, planes), barge.box(6.0, 4.0, 2.0, panels)

    def listed(x, f):
        return np.column_stack([x[f].mean(axis=1), areas(x, f)])

    ours, theirs = listed(vertices, coarse), listed(*half)
    assert len(ours) == len(theirs)
    assert share == pytest.approx(1.0)
    assert cKDTree(ours).query(theirs)[0].max() < 1e-9


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000), length=st.floats(1.0, 100.0), panels=st.integers(1, 3))
@example(seed=77, length=1.0, panels=3)  # a corner that bends a side by 9 degrees
def test_whatever_the_triangles_no_side_of_a_box_gains_or_loses(seed, length, panels):
    vertices, faces = barge.box(length, 4.0, 2.0, panels)
    cut = triangles(faces, seed)
    coarse = coarser_panels(vertices, cut, ()).faces
    assert len(coarse) < 0.7 * len(cut)
    assert sides(vertices, coarse) == pytest.approx(sides(vertices, faces), rel=1e-12, abs=1e-9)
    assert len(np.unique(np.sort(coarse, axis=1), axis=0)) == len(coarse)


@pytest.mark.parametrize(("rows", "azimuth"), [(6, 16), (8, 32), (9, 20), (5, 18)])
def test_fewer_panels_of_a_sphere_look_outwards_and_have_its_planes_of_symmetry(rows, azimuth):
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


def test_corners_of_their_own_are_no_edges():
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2)
    apart = coarser_panels(vertices[faces].reshape(-1, 3), np.arange(4 * len(faces)).reshape(-1, 4), BOTH)
    assert len(apart.faces) == len(coarser_panels(vertices, faces, BOTH).faces) == len(faces) / 4


def test_panels_without_partners_stay():
    corners = np.array([[x, y, z] for z in (-1.0, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
    faces = np.array([[3, 2, 1, 0], *([i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4] for i in range(4))])
    found = coarser_panels(corners, faces, ())
    assert sorted(found.faces.tolist()) == sorted(faces.tolist())
    assert found.share == 0.0


def test_displacements_are_those_of_the_corners():
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2)
    body = made(vertices, faces, rigid(vertices))
    fewer, _ = coarser_body(body, BOTH)
    assert fewer.labels == body.labels
    assert fewer.modes == pytest.approx(rigid(fewer.centres), abs=1e-12)
    assert fewer.volumes == pytest.approx(body.volumes)


def test_what_is_coarser_one_way_only_is_no_second_resolution():
    """Sides of one row of panels: joined along the waterline, not over the draught."""
    vertices, faces = barge.box(6.0, 4.0, 2.0, 1)
    found = coarser_panels(vertices, faces, ())
    assert len(found.faces) < len(faces)
    assert found.share == pytest.approx(6 * 4 / (6 * 4 + 2 * 2 * (6 + 4)))


def test_panels_are_not_joined_across_the_edges_of_a_hexagon():
    angle = np.pi / 3 * np.arange(7)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    z = np.linspace(0.0, -2.0, 5)
    vertices = np.array([[*ring[i], height] for height in z for i in range(6)])
    faces = np.array(
        [[6 * k + i, 6 * k + 6 + i, 6 * k + 6 + (i + 1) % 6, 6 * k + (i + 1) % 6] for k in range(4) for i in range(6)]
    )
    found = coarser_panels(vertices, faces, ())
    a = areas(vertices, found.faces)
    assert np.linalg.norm(a, axis=1).sum() == pytest.approx(12.0, rel=1e-12)  # cut corners would be less
    assert found.share == 0.0


@pytest.mark.parametrize("alike", [1, 2, 9])
def test_one_panel_beyond_25_degrees_of_the_mean_makes_an_edge(alike):
    """However many others are alike, and seen from whichever side."""
    for off, smooth in ((24.9, True), (25.1, False)):
        at = np.deg2rad(off)  # of the last from the mean: the sine rule gives its angle from the others
        turned = at + np.arcsin(np.sin(at) / alike)
        normals = np.array([[0.0, 0.0, 1.0]] * alike + [[np.sin(turned), 0.0, np.cos(turned)]])
        for seen in (normals, -normals, normals[::-1]):
            assert _smooth(seen, set(range(alike + 1))) == smooth


@pytest.mark.parametrize(("corners", "area"), [
    ([(0, 0), (2, 0), (2, 1), (0, 3)], 1.0),
    ([(0, 0), (4, 0), (1, 2), (0, 1)], 0.5),
    ([(0, 0), (4, 0), (1, 2)], 4.0),
    ([(0, 0), (2, 0), (0.5, 0.5), (0, 2)], 0.5),
    ([(0, 0), (0, 2), (0.5, 0.5), (2, 0)], -0.5),
    ([(0.5, 0.5), (0, 2), (0, 0), (2, 0)], 0.5),
    ([(2, 0), (0.5, 0.5), (0, 2), (-3, -3)], -1.0),
])  # fmt: skip
def test_the_thinnest_half_of_a_panel_is_that_on_the_smaller_side_of_its_first_diagonal(corners, area):
    """Triangles of known areas; a half that is turned over counts as less than nothing, of a triangle there is one."""
    vertices = np.column_stack([np.array(corners, dtype=float), np.zeros(len(corners))])
    panel = np.array([[0, 1, 2, len(corners) - 1]])
    assert _thinnest(vertices, panel, np.array([0.0, 0.0, 1.0])) == pytest.approx(area)


def test_panels_are_beside_each_other_both_ways_but_not_across_an_edge():
    """Two quadrilaterals and a triangle in a row, and one at right angles on the first."""
    corners = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [2, 6, 5, 5], [0, 3, 8, 7]])
    normals = np.array([[0, 0, 1.0], [0, 0, 1.0], [0, 0, 1.0], [1.0, 0, 0]])
    assert _beside(corners, normals) == {0: {1}, 1: {0, 2}, 2: {1}}
    assert _beside(corners, normals[[0, 0, 0, 0]]) == {0: {1, 3}, 1: {0, 2}, 2: {1}, 3: {0}}
    wall = np.vstack([corners, [4, 1, 9, 10]])  # a third one on the side of the first two
    assert _beside(wall, normals[[0, 0, 0, 0, 0]]) == {0: {3}, 1: {2}, 2: {1}, 3: {0}}


@pytest.mark.parametrize(("count", "centre"), [(1, False), (2, True), (8, True), (9, False)])
def test_a_vertex_with_more_than_eight_panels_is_a_pole(count, centre):
    corners = np.array([[0, i + 1, i + 2, i + 2] for i in range(count)])
    found = _around(corners, np.tile([0.0, 0.0, 1.0], (count, 1)))
    assert found.get(0) == (set(range(count)) if centre else None)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("share", "flat"), [(0.9, True), (1.1, False)])
def test_a_patch_is_flat_by_its_bend_in_terms_of_its_size(size, share, flat):
    square = size * np.array([[0, 0, 0], [1, 0, 0], [1, 1, share * 1e-6], [0, 1, 0]])
    assert _flat(square + size, np.array([0.0, 0.0, 1.0]), size**2) == flat


def test_only_one_closed_line_is_a_boundary():
    ring = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
    assert _boundary(ring[:3]) == [0, 1, 2, 3, 7, 6, 5, 4]
    assert _boundary(ring) == []  # two
    assert _boundary(np.array([[0, 1, 2, 2], [2, 3, 4, 4]])) == []  # that touch
    assert _boundary(np.array([[5, 3, 4, 4]])) == [3, 4, 5]
    closed = [[0, 1, 2, 2], [1, 0, 3, 3], [2, 1, 3, 3], [0, 2, 3, 3]]
    assert _boundary(np.array(closed)) == []  # none at all


@pytest.mark.parametrize("panels", [4, 3])
def test_a_third_panel_on_an_edge_leaves_no_boundary(panels):
    """Turned as one of the two others, of all or of three sides of a tetrahedron: its sides meet no line, or a ring."""
    patch = np.array([[0, 1, 2, 2], [2, 1, 3, 3], [0, 2, 3, 3], [3, 1, 0, 0]])[:panels]
    patch = np.concatenate([patch, [[4, 1, 2, 2]]])
    for numbers in permutations(range(5)):
        assert _boundary(np.array(numbers)[patch]) == []


def test_a_polygon_is_cut_into_quadrilaterals_and_at_most_one_triangle():
    assert [_cut(list(range(10, 10 + count))) for count in (3, 4, 5, 6)] == [
        [[10, 11, 12, 12]], [[10, 11, 12, 13]], [[10, 11, 12, 13], [10, 13, 14, 14]], [[10, 11, 12, 13], [10, 13, 14, 15]],
    ]  # fmt: skip


@pytest.mark.parametrize(("least", "kept"), [(0.09, 6), (0.11, 5), (0.21, 4), (100.0, 3)])
def test_the_bluntest_corners_go_first_until_what_they_cut_off_is_too_much(least, kept):
    """A square of side 2 with corners raised by 0.1 and 0.2 on two sides: they cut off as much area."""
    vertices = np.array([[0, 0, 0], [1, -0.1, 0], [2, 0, 0], [2, 2, 0], [1, 2.2, 0], [0, 2, 0.0]])
    found = _without_blunt_corners(vertices, list(range(6)), np.array([0.0, 0.0, 1.0]), least)
    assert len(found) == kept
    assert found[: kept - 3] == [[], [0], [0, 2], [0, 1, 2]][kept - 3]


@pytest.mark.parametrize("seed", range(3))
def test_however_corners_and_panels_are_numbered_four_become_one(seed):
    """A plate of 6 x 10 squares: patches begin in its corners and lie side by side."""
    x, y = np.meshgrid(np.arange(7.0), np.arange(11.0), indexing="ij")
    place, chance = np.arange(77).reshape(7, 11), np.random.default_rng(seed)
    faces = np.stack([place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]], axis=-1).reshape(-1, 4)
    old = chance.permutation(77)
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(77)])[old]
    found = coarser_panels(vertices, np.argsort(old)[chance.permutation(faces)], ())
    assert found.share == pytest.approx(1.0)
    assert len(found.faces) == 15
    assert np.linalg.norm(areas(vertices, found.faces), axis=1) == pytest.approx(4.0)


def fan(boundary, centre):
    """Triangles from a point to a polygon around it."""
    count = len(boundary)
    vertices = np.array([*boundary, centre], dtype=float)
    return vertices, np.array([[i, (i + 1) % count, count, count] for i in range(count)])


@pytest.mark.parametrize(
    ("sides", "panels", "share"), [(3, 1, 1), (4, 1, 1), (5, 2, 1), (6, 2, 1), (7, 3, 0), (8, 3, 1)]
)
def test_two_panels_and_a_half_in_one_are_fewer_both_ways(sides, panels, share):
    angle = 2 * np.pi * np.arange(sides) / sides
    vertices, faces = fan(np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), (0.0, 0.0, 0.0))
    found = coarser_panels(vertices, faces, ())
    assert len(found.faces) == panels
    assert found.share == pytest.approx(share)


@pytest.mark.parametrize(("edge", "joined"), [(0.045, False), (0.06, True)])
def test_no_half_of_a_panel_is_thinner_than_a_twentieth_of_the_mean(edge, joined):
    """A triangle with a corner cut off: of either pair of halves one has the area of the edge, of two halves of 1 + e/2."""
    vertices, faces = fan([(0, 0, 0), (2, 0, 0), (2, edge, 0), (0, 2, 0)], (0.6, 0.6, 0.0))
    assert (edge > 0.05 * (1 + edge / 2)) == joined
    assert len(coarser_panels(vertices, faces, ()).faces) == (1 if joined else 4)


@pytest.mark.parametrize("first", range(5))
def test_a_polygon_is_cut_where_its_thinnest_half_is_largest(first):
    """One corner is nearly straight: no half is that corner's alone."""
    corners = np.roll([(0, 0, 0), (1, -0.01, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)], first, axis=0)
    vertices, faces = fan(corners, (1.0, 1.0, 0.0))
    up = np.array([0.0, 0.0, 1.0])
    assert _thinnest(vertices, coarser_panels(vertices, faces, ()).faces, up) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(("height", "panels"), [(0.35, 1), (0.38, 2)])
def test_of_a_bent_patch_what_cuts_off_a_twelfth_is_a_corner(height, panels):
    """A square of side 2, not quite flat, with a side raised by h in its middle, h of 4 + h in area."""
    corners = np.array([(-1, -1, 0), (0, -1 - height, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=float)
    corners[:, 2] = 0.01 * corners[:, 0] * corners[:, 1]
    vertices, faces = fan(corners, (0.0, 0.0, 0.0))
    assert (height / (4 + height) < 1 / 12) == (panels == 1)
    assert len(coarser_panels(vertices, faces, ()).faces) == panels
