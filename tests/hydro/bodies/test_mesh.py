"""Panels of a surface: rigid motions, parts, gaps, clipping at the water, and separate bodies."""

import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_body import made, revolved_body, rigid, shell_with
from hydro.bodies.test_solver import disc_and_walls

from examples.barge import box
from vsb.engine.hydro.bodies.body import FlexibleBody, check_apart
from vsb.engine.hydro.bodies.build import read_body, write_body
from vsb.engine.hydro.bodies.mesh import at_centres, at_vertices, divided, joined, rigid_motion
from vsb.errors import ConfigError

LINEAR = np.array([[1.0, 0.2, 0.3], [0.0, 1.0, 0.5], [0.4, 0.0, 1.0]])


# Values and rigid motions


@pytest.mark.parametrize("size", [2.0, 0.6])
def test_triangles_of_cad_are_divided_without_changing_the_surface(size):
    """A prism as CAD writes it, two fans and long strips, every facet with corners of its own."""
    turn = 2 * np.pi * np.arange(13) / 12
    low, high = (np.column_stack([3 * np.cos(turn), 3 * np.sin(turn), np.full(13, z)]) for z in (-5.0, 0.0))
    a, b, c, d = low[:-1], low[1:], high[1:], high[:-1]
    tips = [np.tile([0.0, 0.0, z], (12, 1)) for z in (-5.0, 0.0)]
    facets = [(a, b, c), (a, c, d), (tips[0], b, a), (tips[1], d, c)]
    points = np.concatenate([np.stack(facet, axis=1) for facet in facets]).reshape(-1, 3)
    faces = np.arange(len(points)).reshape(-1, 3)[:, [0, 1, 2, 2]]
    vertices, panels = divided(points, faces, size)
    corner = vertices[panels[:, :3]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
    polygon = 0.5 * 12 * 9 * np.sin(np.pi / 6)
    assert np.linalg.norm(normal, axis=1).sum() == pytest.approx(2 * polygon + 12 * 5 * 6 * np.sin(np.pi / 12))
    assert (corner.mean(axis=1) * normal).sum() / 3 == pytest.approx(5 * polygon)
    assert np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max() <= size
    edges = np.sort(np.stack([panels[:, :3], np.roll(panels[:, :3], 1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}  # corners meet everywhere
    with pytest.raises(ConfigError, match=r"panel: received 0.001 m, which makes more than 50000 panels; needs larger"):
        divided(points, faces, 1e-3)


def test_linear_fields_are_exact_at_centroids_and_at_inner_corners():
    body = revolved_body(shell_with(0.15), 4, (1,), 8)  # trapezoids and triangles
    field = at_centres(body.vertices, body.faces, (body.vertices @ LINEAR)[None])[0]
    assert field == pytest.approx(body.centres @ LINEAR, abs=1e-14)
    vertices, faces = box(6.0, 4.0, 2.0, 2)
    values = (at_centres(vertices, faces, vertices[None])[0] @ LINEAR)[None]
    shared = at_vertices(vertices, faces, values)
    apart = at_vertices(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 4), values)
    assert apart.reshape(-1, 4, 3) == pytest.approx(shared[0][faces], abs=1e-14)  # panels with corners of their own
    middle = int(np.argmin(np.linalg.norm(vertices - [0.0, 0.0, -2.0], axis=1)))  # four equal panels meet here
    assert shared[0, middle] == pytest.approx(vertices[middle] @ LINEAR, abs=1e-14)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("kind", range(6))
def test_rigid_motions_are_recognised_at_every_size(scale, kind):
    points = box(6.0, 4.0, 2.0, 2)[0] + [3.0, -2.0, 0.7]
    moved = scale * rigid(points)[kind]
    assert np.concatenate(rigid_motion(points, moved)) == pytest.approx(scale * np.eye(6)[kind], rel=1e-12, abs=0.0)
    assert rigid_motion(points, moved + 1e-6 * scale * points[:, :1] ** 2 * [0.0, 0.0, 1.0]) is None
    single = rigid_motion(points, moved.astype(np.float32).astype(float))
    assert np.concatenate(single) == pytest.approx(scale * np.eye(6)[kind], abs=1e-6 * scale)


# Edges


@pytest.mark.parametrize(("cut", "where"), [((1,), "y = 0"), ((0, 1), "x = 0 and y = 0")])
def test_half_or_quarter_of_a_body_is_refused(cut, where):
    """A face missing in a plane through the origin adds nothing to the three volumes."""
    vertices, faces = box(4.0, 2.0, 1.0, 1)
    kept = (vertices[faces][..., list(cut)] >= -1e-9).all(axis=(1, 2))
    with pytest.raises(ConfigError, match=f"^mesh: open along {where}, where .* symmetry flags of its file"):
        made(vertices, faces[kept], rigid(vertices)[2:3], ("Heave",))


# Clipping


def hull(above):
    """A box 6 x 4 m with a draught of 2 m, walls that go on `above` the water, and a deck."""
    vertices, faces = box(6.0, 4.0, 2.0, 2)
    vertices[:, 2] = np.where(vertices[:, 2] == 0.0, above, vertices[:, 2])
    corners = np.array([[-3.0, -2, above], [3, -2, above], [3, 2, above], [-3, 2, above]])
    return np.vstack([vertices, corners]), np.vstack([faces, len(vertices) + np.arange(4)])


@pytest.mark.parametrize(("dims", "above"), [("vertex", 0.7), ("panel", 0.7), ("panel", 0.0)])
def test_mesh_is_cut_at_the_water_and_rigid_motions_stay_rigid(tmp_path, dims, above):
    vertices, faces = hull(above)
    modes = rigid(vertices)[[2, 4]]
    modes = modes if dims == "vertex" else at_centres(vertices, faces, modes)
    data = {"vertices": (("vertex", "xyz"), vertices), "faces": (("panel", "corner"), faces)}
    data |= {"mode_shape": (("dof", dims, "xyz"), modes), "centre_of_mass": ("xyz", [0.0, 0.0, 0.1])}
    xr.Dataset(data, coords={"dof": ["Heave", "Pitch"]}).to_netcdf(path := tmp_path / "a.nc")
    body = read_body(path, path)
    assert body.volumes == pytest.approx([48.0] * 3, rel=1e-9)
    assert np.abs(body.modes - rigid(body.centres)[[2, 4]]).max() < 1e-9
    cut = np.count_nonzero((vertices[faces][..., 2] > 0).any(axis=1)) - 1 if above else 0
    note = f"clipped at z = 0: {cut} of {len(faces)} panels cut, 1 above the water or in its surface left out"
    assert body.history == note
    data["vertices"] = ("vertex", "xyz"), vertices + np.array([0.0, 0.0, 9.0])
    xr.Dataset(data, coords={"dof": ["Heave", "Pitch"]}).to_netcdf(path := tmp_path / "high.nc")
    with pytest.raises(
        ConfigError, match=r"none of .* panels lies below z = 0, the lowest point at 7 m; needs .*draught"
    ):
        read_body(path, path)


# Separate bodies


def two(*meshes):
    """Two bodies in one mesh, heave of each."""
    vertices, panels = joined(meshes)
    up = np.zeros((2, len(vertices), 3))
    up[0, : len(meshes[0][0]), 2] = up[1, len(meshes[0][0]) :, 2] = 1.0
    return FlexibleBody(vertices, panels, ("float__Heave", "spar__Heave"), at_centres(vertices, panels, up), up)


def boxes(shift, second=(4.0, 3.0, 1.0)):
    vertices, faces = box(*second, 1)
    return two(box(4.0, 3.0, 1.0, 1), (vertices + np.array(shift), faces))


@pytest.mark.parametrize("shift", [(0.0, 3.001, 0.0), (4.2, 3.5, 0.0), (4.0, 3.0, 0.0)])
def test_bodies_beside_each_other_are_accepted(shift, tmp_path):
    """A millimetre apart, diagonally, touching at a corner."""
    body = boxes(shift)
    write_body(body, tmp_path / "two.nc")
    assert read_body(tmp_path / "two.nc", tmp_path / "two.nc").labels == body.labels


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (boxes((1.0, 0.5, 0.0)), r"mesh: \d+ panels of float lie inside spar or on its wall, the first at \("),
        (boxes((0.2, 0.1, 0.0), (1.0, 0.8, 0.5)), r"mesh: \d+ panels of spar lie inside float"),
        (boxes((4.0, 0.0, 0.0)), r"4 panels lie .* in pairs, the first at \(2, .*: the walls of float and spar"),
        (two(disc_and_walls((3.0, 5.0), 48), disc_and_walls((0.0, 3.0), 36)), r"of ring|of float lie inside spar"),
    ],
    ids=["overlapping", "inside", "shared wall", "round walls of one radius"],
)
def test_bodies_that_overlap_or_touch_are_refused(body, message):
    with pytest.raises(ConfigError, match=message):
        check_apart(body)
