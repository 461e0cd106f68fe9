"""Stiffness of several bodies in one mesh: each as if it were alone."""

from dataclasses import replace

import numpy as np
import pytest
from hydro.bodies.test_body import made, rigid

from examples import barge
from vsb.engine.hydro.bodies.files import read_body, write_body
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.bodies.mesh import joined
from vsb.errors import ConfigError

CENTRES = np.array([[0.0, 0.0, -0.4], [9.0, 1.0, 0.2]])
"""Of mass, of two boxes of other sizes."""
BOXES = [barge.box(6.0, 4.0, 2.0, 1), barge.box(5.0, 3.0, 1.5, 1)]


def alone(number):
    """One of the boxes by itself, its six motions about its centre of mass and one that bends."""
    vertices, faces = BOXES[number]
    vertices = vertices + number * np.array([9.0, 1.0, 0.0])
    bend = np.zeros_like(vertices)
    bend[:, 2] = 1.0 - (vertices[:, 0] - CENTRES[number, 0]) ** 2 / 8
    shapes = np.array([*rigid(vertices, CENTRES[number]), bend])
    return made(vertices, faces, shapes, centre_of_mass=CENTRES[number])


@pytest.fixture
def both():
    """Both boxes as one mesh, every motion of one alone."""
    one, other = alone(0), alone(1)
    vertices, faces = joined([(one.vertices, one.faces), (other.vertices, other.faces)])
    shapes = np.zeros((14, len(vertices), 3))
    shapes[:7, : len(one.vertices)], shapes[7:, len(one.vertices) :] = one.shapes, other.shapes
    return made(vertices, faces, shapes, centre_of_mass=CENTRES)


def test_stiffness_of_two_bodies_is_that_of_each_alone(both):
    found = hydrostatic_stiffness(both, 1025.0, 9.81)
    expected = np.zeros((14, 14))
    expected[:7, :7], expected[7:, 7:] = (hydrostatic_stiffness(alone(k), 1025.0, 9.81) for k in (0, 1))
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-6 * np.abs(expected).max())
    assert sorted(both.rigid_parts) == [*range(6), *range(7, 13)]
    assert both.rigid == {}


def test_part_that_rotates_alone_needs_its_own_centre_of_mass(both):
    with pytest.raises(ConfigError, match=r"centre_of_mass: received one, but Dof3 turns 2 separate parts, not all"):
        replace(both, centre_of_mass=np.zeros(3))
    with pytest.raises(ConfigError, match=r"centre_of_mass: shape \(3, 3\); needs \(3,\), or a row for each part, \(2"):
        replace(both, centre_of_mass=np.zeros((3, 3)))
    with pytest.raises(ConfigError, match="centre_of_mass: holds NaN"):
        replace(both, centre_of_mass=np.full((2, 3), np.nan))
    with pytest.raises(ConfigError, match="centre_of_mass is missing; a body that rotates needs it"):
        replace(both, centre_of_mass=None)


def test_two_centres_of_mass_are_read_back(both, tmp_path):
    write_body(both, tmp_path / "both.nc")
    assert read_body(tmp_path / "both.nc", tmp_path / "both.nc").centre_of_mass == pytest.approx(CENTRES)


@pytest.mark.parametrize("number", [0, 1])
def test_stiffness_transforms_with_the_centre_of_rotation(number):
    """A turn about the origin is one about a point c and the shift a x (-c): C turns with them, the body upright."""
    one = alone(number)
    c = np.append(number * np.array([9.0, 1.0]) + [-2.0, 3.0], 0.25)
    vertices = one.vertices + np.array([-2.0, 3.0, 0.0])
    own, origin = (made(vertices, one.faces, rigid(vertices, about), centre_of_mass=c) for about in (c, np.zeros(3)))
    turned = np.eye(6)
    turned[3:, :3] = [np.cross(e, -c) * -1.0 for e in np.eye(3)]
    expected = turned @ hydrostatic_stiffness(own, 1025.0, 9.81) @ turned.T
    found = hydrostatic_stiffness(origin, 1025.0, 9.81)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def test_motion_of_all_parts_has_the_sum_of_their_stiffnesses(both):
    """Turns of all about one point are the sum of those of either, the weight of each at its own centre."""
    whole = rigid(both.vertices, (1.0, 2.0, 3.0))
    first = len(BOXES[0][0])
    halves = np.concatenate([whole, whole])
    halves[:6, first:] = halves[6:, :first] = 0.0
    mixed = made(
        both.vertices, both.faces, np.concatenate([halves, whole]), centre_of_mass=CENTRES + np.array([0.2, 0.1, 0.0])
    )
    total = np.concatenate([np.eye(12), np.tile(np.eye(6), (1, 2))])
    found = hydrostatic_stiffness(mixed, 1025.0, 9.81)
    expected = total @ found[:12, :12] @ total.T
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
