"""Two bodies in one mesh: apart they are read, in each other or touching they are refused in one line."""

import re
from itertools import permutations

import numpy as np
import pytest
from hydro.bodies.test_lid import disc_and_walls

from examples.barge import box
from vsb.errors import ConfigError
from vsb.hydro.bodies import apart
from vsb.hydro.bodies import body as bodies
from vsb.hydro.bodies.apart import check_apart
from vsb.hydro.bodies.body import FlexibleBody, at_centres, joined
from vsb.hydro.bodies.files import read_body, write_body


def two(shift, second=(4.0, 3.0, 1.0)):
    """Two boxes, the second one somewhere else, heave of each."""
    one, (x, faces) = box(4.0, 3.0, 1.0, 1), box(*second, 1)
    vertices, panels = joined([one, (x + np.array(shift), faces)])
    up = np.zeros((2, len(vertices), 3))
    up[0, : len(one[0]), 2] = up[1, len(one[0]) :, 2] = 1.0
    moved = at_centres(vertices, panels, up)
    return FlexibleBody(vertices, panels, ("float__Heave", "spar__Heave"), moved, up)


@pytest.mark.parametrize("shift", [(5.0, 0.0, 0.0), (0.0, 3.001, 0.0), (0.0, -3.2, 0.0), (4.2, 3.5, 0.0)])
def test_bodies_apart_are_read(shift, tmp_path):
    body = two(shift)
    check_apart(body)
    write_body(body, tmp_path / "two.nc")
    assert read_body(tmp_path / "two.nc", tmp_path / "two.nc").labels == body.labels


@pytest.mark.parametrize(
    ("shift", "second"),
    [((1.0, 0.5, 0.0), (4.0, 3.0, 1.0)), ((0.2, 0.1, 0.0), (1.0, 0.8, 0.5)), ((3.9, 0.3, 0.0), (4.0, 3.0, 1.0))],
)
def test_bodies_in_each_other_are_refused(shift, second, tmp_path):
    """Beside, one whole inside the other, and by a tenth of a metre at one end."""
    write_body(two(shift, second), tmp_path / "two.nc")
    with pytest.raises(
        ConfigError, match=r"two.nc, .*two.nc: mesh: \d+ panels? of spar lie inside float|of float lie inside spar"
    ) as error:
        read_body(tmp_path / "two.nc", tmp_path / "two.nc")
    assert "\n" not in str(error.value)


def test_walls_that_coincide_with_other_panels_are_refused_and_both_bodies_named():
    with pytest.raises(ConfigError, match=r"^mesh: \d+ panels of float lie inside spar or on its wall"):
        check_apart(two((3.0, 0.0, 0.0), (2.0, 1.7, 0.9)))


def test_round_walls_of_one_radius_are_refused_whatever_edges_they_share():
    """48 panels around a moonpool and 36 around what fills it have twelve edges in common."""
    parts = [disc_and_walls((3.0, 5.0), around=48), disc_and_walls((0.0, 3.0), around=36)]
    vertices, faces = joined(parts)
    up = np.zeros((2, len(vertices), 3))
    up[0, : len(parts[0][0]), 2] = up[1, len(parts[0][0]) :, 2] = 1.0
    body = FlexibleBody(vertices, faces, ("ring__Heave", "spar__Heave"), at_centres(vertices, faces, up), up)
    with pytest.raises(ConfigError, match=r"^mesh: \d+ panels of ring lie inside spar or on its wall"):
        check_apart(body)


def test_bodies_that_touch_at_a_corner_alone_lie_apart():
    check_apart(two((4.0, 3.0, 0.0)))


def test_bodies_that_share_a_side_are_refused():
    with pytest.raises(ConfigError, match=r"mesh: panel \d+ at \(.*\) is there twice; needs bodies apart"):
        check_apart(two((4.0, 0.0, 0.0)))


def test_one_body_is_no_pair():
    vertices, panels = box(4.0, 3.0, 1.0, 2)
    up = np.zeros((1, len(vertices), 3))
    up[0, :, 2] = 1.0
    check_apart(FlexibleBody(vertices, panels, ("Heave",), at_centres(vertices, panels, up), up))


def test_the_first_panel_that_lies_inside_is_where_it_is_said_to_be():
    """One whole inside the other: its first panel."""
    body = two((0.2, 0.1, 0.0), (1.0, 0.8, 0.5))
    inner = body.centres[len(box(4.0, 3.0, 1.0, 1)[1]) :]
    x, y, z = (f"{value:.4g}" for value in inner[0])
    with pytest.raises(ConfigError, match=re.escape(f"the first at ({x}, {y}, {z}); needs bodies apart")):
        check_apart(body)


@pytest.mark.parametrize("many", [1, 100, 10**6])
def test_points_inside_are_told_in_their_order_however_many_are_seen_at_a_time(many, monkeypatch):
    """Inside, beside, inside the mirror image above still water, below."""
    vertices, panels = box(4.0, 3.0, 1.0, 1)
    up = np.ones((1, len(vertices), 3))
    body = FlexibleBody(vertices, panels, ("Heave",), at_centres(vertices, panels, up), up)
    points = np.array([[0.1, 0.2, -0.5], [3.0, 0.0, -0.5], [-1.0, 1.0, 0.7], [0.0, 0.0, -1.5]])
    monkeypatch.setattr(apart, "_MANY", many)
    found = apart._winding(body, np.ones(len(panels), dtype=bool), points)
    assert found == pytest.approx([1.0, 0.0, 1.0, 0.0], abs=1e-12)


def test_the_panel_that_is_there_twice_is_the_first_of_the_side_they_share():
    body = two((4.0, 0.0, 0.0))
    shared = np.flatnonzero(np.isclose(body.centres[:, 0], 2.0))
    owner = bodies.owners(body.vertices)
    corners = [tuple(sorted(row)) for row in owner[body.faces].tolist()]
    first = {corners[k]: k for k in shared[::-1]}
    assert len(first) == len(shared) / 2
    with pytest.raises(ConfigError) as error:
        check_apart(body)
    told = re.fullmatch(
        r"mesh: panel (\d+) at \((.*), (.*), (.*)\) is there twice; needs bodies apart, .*", str(error.value)
    )
    panel = int(told[1])
    assert panel in first.values()
    assert [told[k] for k in (2, 3, 4)] == [f"{value:.4g}" for value in body.centres[panel]]


def test_panels_inside_are_counted():
    """One whole inside the other, and one of which an end is."""
    inner = box(1.0, 0.8, 0.5, 1)[1]
    with pytest.raises(
        ConfigError, match=rf"^mesh: {len(inner)} panels of \w+ lie inside \w+ or on its wall, the first at"
    ):
        check_apart(two((0.2, 0.1, 0.0), (1.0, 0.8, 0.5)))
    with pytest.raises(
        ConfigError, match=rf"^mesh: {len(inner)} panels of \w+ lie inside \w+ or on its wall, the first at"
    ):
        check_apart(_swapped(two((0.2, 0.1, 0.0), (1.0, 0.8, 0.5))))


def _swapped(body):
    """The same, its parts the other way round."""
    first = np.flatnonzero(body.part == 0)
    order = np.concatenate([np.flatnonzero(body.part == 1), first])
    return FlexibleBody(body.vertices, body.faces[order], body.labels, body.modes[:, order], body.shapes)


@pytest.mark.parametrize("order", list(permutations(range(3))), ids=str)
def test_any_two_of_three_bodies_may_lie_in_each_other(order):
    """A small one in a large one, and one beside them, in any order."""
    sizes = [((4.0, 3.0, 1.0), 0.0), ((1.0, 0.8, 0.5), 0.2), ((4.0, 3.0, 1.0), 9.0)]
    meshes = []
    for size, shift in (sizes[k] for k in order):
        vertices, faces = box(*size, 1)
        meshes.append((vertices + np.array([shift, 0.0, 0.0]), faces))
    vertices, panels = joined(meshes)
    up = np.zeros((1, len(vertices), 3))
    up[0, :, 2] = 1.0
    body = FlexibleBody(vertices, panels, ("Heave",), at_centres(vertices, panels, up), up)
    with pytest.raises(
        ConfigError, match=r"^mesh: \d+ panels of part \d lie inside part \d or on its wall, the first at"
    ):
        check_apart(body)
