"""Stiffness of several bodies in one mesh: each as if it were alone."""

from dataclasses import replace

import numpy as np
import pytest
from hydro.bodies.test_body import made, rigid
from scipy.spatial.transform import Rotation

from examples import barge
from vsb.engine.hydro.bodies.body import SYMMETRIES, detected_symmetry
from vsb.engine.hydro.bodies.build import read_body, write_body
from vsb.engine.hydro.bodies.hydrostatics import hinge_gap, hydrostatic_stiffness, linear_share
from vsb.engine.hydro.bodies.mesh import joined
from vsb.engine.hydro.bodies.solver import coarser_body
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


LENGTH, BEAM, DRAUGHT, MASS = 40.0, 6.0, 3.0, 0.4
"""Of a box, and the height of its centre of mass [m]."""
AXIS = -0.7
"""Height of another axis, about which some of the modes turn sections [m]."""


def cosine(s, side):
    """Deflection and slope along the box."""
    return np.cos(s / 7), -np.sin(s / 7) / 7


def sine(s, side):
    return np.sin(s / 9), np.cos(s / 9) / 9


def hinged(s, side):
    return side * s / 10 - 1, side / 10 + 0 * s


def vertical(bent, axis):
    """T and omega of sections normal to an axis at a height that bends vertically."""
    return lambda s, side: ([axis * bent(s, side)[1], 0 * s, bent(s, side)[0]], [0 * s, -bent(s, side)[1], 0 * s])


def horizontal(s, side):
    return [0 * s, cosine(s, side)[0], 0 * s], [0 * s, 0 * s, cosine(s, side)[1]]


def twist(s, side):
    angle = np.sin(s / 13 + 0.5)
    return [0 * s, AXIS * angle, 0 * s], [angle, 0 * s, 0 * s]


def stretch(s, side):
    return [np.sin(s / 15), 0 * s, 0 * s], np.zeros((3, len(s)))


FIELDS = {
    "bends": vertical(cosine, MASS),
    "bends_low": vertical(sine, AXIS),
    "bends_aside": horizontal,
    "twists": twist,
    "stretches": stretch,
    "hinge": vertical(hinged, MASS),
}


def shapes_of(vertices, names):
    """Displacements of points; where the hinge is they are the mean of both halves', as meshes have them."""
    s, rho = vertices[:, 0], np.where(np.arange(3) == 0, 0.0, vertices)
    motions = [np.array(FIELDS[name](s, np.sign(s))).swapaxes(1, 2) for name in names]
    return np.array([shift + np.cross(turn, rho) for shift, turn in motions])


def potential(q, names, cells=150):
    """Energy of water and weight over rho g for amplitudes, shape (case, dof) -> (case,) [m^4].

    From amidships slices are placed one after the other, by finite turns: in the frame of each, rotation per length and
    stretch are linear in the amplitudes. A slice is wet up to where the water cuts it, and carries the weight of the
    water it displaces at rest at the centre of mass.
    """
    h, x = LENGTH / 2 / cells, np.array([1.0, 0.0, 0.0])
    node, weight = np.polynomial.legendre.leggauss(6)
    y, across, down = node * BEAM / 2, weight * BEAM / 2, (1 + node) / 2
    total = np.zeros(len(q))
    for side in (-1.0, 1.0):

        def motion(s, side=side):
            """T and omega at s, shape (2, case, xyz)."""
            return np.einsum("cn,nkxs->skcx", q, np.array([FIELDS[name](np.array([s]), side) for name in names]))[0]

        shift, turn = motion(0.0)
        frame, place = Rotation.from_rotvec(turn), shift
        for k in range(cells):
            s = side * (k + 0.5) * h
            rate, bend = (motion(s + 1e-5) - motion(s - 1e-5)) / 2e-5
            lean = x + rate - np.cross(motion(s)[1], x)  # along the slice's normal, but for an axis of twist elsewhere
            half = frame * Rotation.from_rotvec(bend * side * h / 2)
            centre, up = place + half.apply(lean) * side * h / 2, half.as_matrix()[:, 2]
            keel = centre[:, 2, None] + up[:, 1, None] * y - up[:, 2, None] * DRAUGHT  # (case, y)
            wet = -keel / up[:, 2, None]  # along the slice
            zeta = wet[..., None] * down - DRAUGHT
            opened = 1 + (rate[:, 0, None] - bend[:, 2, None] * y)[..., None] + bend[:, 1, None, None] * zeta
            volume = h * (across * wet)[..., None] * weight / 2
            total -= (keel[..., None] * (1 - down) * opened * volume).sum(axis=(1, 2))
            total += (centre[:, 2] + up[:, 2] * MASS) * DRAUGHT * BEAM * h
            place, frame = place + half.apply(lean) * side * h, frame * Rotation.from_rotvec(bend * side * h)
    return total


def second_derivatives(names, step=2e-2):
    """Second derivatives of `potential` by central differences, (dof, dof) [m^2]."""
    e, n = step * np.eye(len(names)), len(names)
    at = np.array([i * e[a] + j * e[b] for i in (-1, 1) for j in (-1, 1) for a in range(n) for b in range(n)])
    value = potential(at, names).reshape(4, n, n)
    return (value[0] - value[1] - value[2] + value[3]) / (4 * step**2)


@pytest.fixture(scope="module")
def mesh():
    return barge.box(LENGTH, BEAM, DRAUGHT, 3)


def body_of(mesh, names=tuple(FIELDS), **changes):
    vertices, faces = mesh
    given = {"centre_of_mass": np.array([0.0, 0.0, MASS])} | changes
    return made(vertices, faces, shapes_of(vertices, names), tuple(names), **given)


def test_stiffness_matches_energy_of_slices_turned_by_finite_angles(mesh):
    """Bending both ways and about two axes, twist, stretch, a hinge, and all their couplings."""
    body = body_of(mesh)
    found, expected = hydrostatic_stiffness(body, 1.0, 1.0), second_derivatives(tuple(FIELDS))
    assert found == pytest.approx(expected, rel=1e-3, abs=0.01)
    assert abs(expected[2, 3]) > 1.0  # twist and bending aside are coupled
    assert linear_share(body) is None


def test_beam_along_y_matches_beam_along_x(mesh):
    """A quarter turn of everything about the vertical."""
    vertices, faces = mesh
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    body = body_of(mesh)
    turned = made(vertices @ quarter, faces, body.shapes @ quarter, body.labels, centre_of_mass=body.centre_of_mass)
    found, expected = (hydrostatic_stiffness(each, 1.0, 1.0) for each in (turned, body))
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def test_coarser_panels_give_the_same_beam(mesh):
    """Fields are of the corners, which both have; else the error estimate would compare two models."""
    body = body_of(mesh)
    fewer, _ = coarser_body(body, SYMMETRIES[detected_symmetry(body)])
    assert len(fewer.faces) < len(body.faces) / 2
    found = hydrostatic_stiffness(replace(fewer, centre_of_mass=body.centre_of_mass), 1.0, 1.0)
    assert found == pytest.approx(hydrostatic_stiffness(body, 1.0, 1.0), rel=2e-3, abs=0.02)


def folded(vertices, at, fore, aft):
    """Halves that turn about a transverse hinge at x = at by angles of their own, bow down."""
    angle = np.where(vertices[:, 0] > at, fore, aft)
    return np.column_stack([angle * (vertices[:, 2] - MASS), 0 * angle, 0.3 - angle * (vertices[:, 0] - at)])


def of_halves(at, fore, aft):
    """Newman's rigid form of either half, closed by a wall at the hinge, over rho g [m^2]."""
    total = 0.0
    for angle, low, high in ((aft, -LENGTH / 2, at), (fore, at, LENGTH / 2)):
        rise = np.polynomial.Polynomial([0.3 + angle * at, -angle])
        waterplane = (rise**2).integ()(high) - (rise**2).integ()(low)
        total += BEAM * (waterplane + angle**2 * DRAUGHT * (high - low) * (-DRAUGHT / 2 - MASS))
    return total


@pytest.mark.parametrize(("fore", "aft"), [(0.1, -0.1), (0.2, 0.05)])
@pytest.mark.parametrize("at", [0.0, 3.1])
def test_hinge_is_the_sum_of_the_rigid_forms_of_its_parts(mesh, at, fore, aft):
    """Also where it lies across panels, whose shares of either part are then found by quadrature alone."""
    vertices, faces = mesh
    body = made(vertices, faces, folded(vertices, at, fore, aft)[None], centre_of_mass=np.array([0.0, 0.0, MASS]))
    found = hydrostatic_stiffness(body, 1.0, 1.0)[0, 0]
    assert found == pytest.approx(of_halves(at, fore, aft), rel=1e-12 if at == 0.0 else 2e-3)
    assert linear_share(body) is None


def test_hinge_gap_is_the_water_between_the_walls(mesh):
    """Of a gap that opens by 0.2 rad below z = MASS and rises by -1: 2 B int w 0.2 (MASS - z) dz."""
    body = body_of(mesh, ("hinge", "bends"))
    own = hydrostatic_stiffness(body, 1.0, 1.0)[0, 0]
    gap = 2 * BEAM * 0.2 * ((MASS + DRAUGHT) ** 2 - MASS**2) / 2
    assert hinge_gap(body) == pytest.approx(gap / (own + gap), rel=1e-9)
    assert hinge_gap(body_of(mesh, ("bends",))) is None


def path_of(body, i, j):
    """Second-order displacements of vertices of inextensible bending about MASS, [1/m]."""
    s = np.linspace(-LENGTH / 2, LENGTH / 2, 2001)
    names = body.labels[i], body.labels[j]
    both = {"bends": cosine, "bends_low": sine}
    slopes = [both[name](s, 0)[1] for name in names]
    path = np.append(0.0, np.cumsum((slopes[0] * slopes[1])[1:] + (slopes[0] * slopes[1])[:-1]) / 2 * (s[1] - s[0]))
    product = np.interp(body.vertices[:, 0], s, slopes[0] * slopes[1])
    lever = body.vertices[:, 2] - MASS
    return np.column_stack([-np.interp(body.vertices[:, 0], s, path), 0 * lever, -product * lever])


def test_second_order_from_a_file(mesh, tmp_path):
    """Of an inextensible beam's: with it and the rise of its weight displaced panels are as stiff as the beam."""
    fine = barge.box(LENGTH, BEAM, DRAUGHT, 8)
    body = body_of(fine, ("bends",))
    stated = replace(body, second_order=path_of(body, 0, 0)[None, None])
    write_body(stated, tmp_path / "beam.nc")
    found = read_body(tmp_path / "beam.nc", tmp_path / "beam.nc")
    assert found.second_order == pytest.approx(stated.second_order)
    # the weight of a section lies on the axis, which stays at its height at second order: no rise
    beam, own, linear = (
        hydrostatic_stiffness(each, 1.0, 1.0)[0, 0]
        for each in (body, found, replace(body, second_order=np.zeros_like(stated.second_order)))
    )
    assert own == pytest.approx(beam, rel=5e-3)
    assert linear > 1.2 * beam
    assert linear_share(found) is hinge_gap(found) is None


def test_other_displacements_stay_linear_with_a_doubt(mesh):
    """Sections that do not turn as the axis does or breathe, dents, and a beam without a centre of mass."""
    vertices, faces = mesh
    x, _, z = vertices.T
    sheared = np.column_stack([0 * x, 0 * x, np.cos(x / 7)])
    breathes = np.column_stack([0 * x, 0 * x, np.cos(x / 7) * z**2 / 9])
    bends, bump = shapes_of(vertices, ("bends",))[0], np.zeros_like(vertices)
    bump[np.argmin(np.linalg.norm(vertices - [5.0, 0.0, -DRAUGHT], axis=1)), 2] = 1.0
    folds = folded(vertices, 0.0, 0.1, -0.1) + bump
    centre = np.array([0.0, 0.0, MASS])
    for shape, known in ((sheared, centre), (breathes, centre), (bump, centre), (folds, centre), (bends, None)):
        body = made(vertices, faces, shape[None], centre_of_mass=known)
        assert linear_share(body) > 0.02
        stated = replace(body, second_order=np.zeros((1, 1, len(vertices), 3)))
        assert hydrostatic_stiffness(body, 1.0, 1.0) == pytest.approx(
            hydrostatic_stiffness(stated, 1.0, 1.0), rel=1e-12
        )


def test_two_beams_have_the_stiffness_of_each_alone(mesh):
    """With the height of its own mass; one centre for both does not tell it."""
    vertices, faces = mesh
    other = vertices + np.array([LENGTH + 5.0, 0.0, 0.0])
    bends = shapes_of(vertices, ("bends", "hinge"))
    shapes = np.concatenate([np.concatenate([bends, 0 * bends], axis=1), np.concatenate([0 * bends, bends], axis=1)])
    centres = np.array([[0.0, 0.0, MASS], [LENGTH + 5.0, 0.0, -0.3]])
    both = made(*joined([mesh, (other, faces)]), shapes, centre_of_mass=centres)
    one, two = (hydrostatic_stiffness(made(vertices, faces, bends, centre_of_mass=c), 1.0, 1.0) for c in centres)
    expected = np.block([[one, np.zeros((2, 2))], [np.zeros((2, 2)), two]])
    assert hydrostatic_stiffness(both, 1.0, 1.0) == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert linear_share(both) is None
    assert linear_share(replace(both, centre_of_mass=centres[0])) > 0.02
