import re
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from examples import barge
from vsb.errors import ConfigError
from vsb.hydro.bodies import body as bodies
from vsb.hydro.bodies.body import FlexibleBody, at_centres, at_vertices
from vsb.hydro.bodies.coarsening import CoarserBody
from vsb.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.hydro.panels.mesh import graded_colatitudes, polygon_radius, revolved
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import Mode, ModeBasis, legendre
from vsb.shell.shell import Shell

LENGTH, BEAM, DRAUGHT = 6.0, 4.0, 2.0
CENTRE_OF_MASS = np.array([0.0, 0.0, 0.3])


def rigid(x, about=(0.0, 0.0, 0.0)):
    """Surge, sway, heave, roll, pitch, yaw of points."""
    r = x - np.asarray(about)
    return np.array([*(np.tile(e, (len(x), 1)) for e in np.eye(3)), *(np.cross(e, r) for e in np.eye(3))])


def made(vertices, faces, shapes, labels=None, **changes):
    labels = labels or tuple(f"Dof{i}" for i in range(len(shapes)))
    fields = {
        "modes": at_centres(vertices, faces, shapes),
        "shapes": shapes,
        "centre_of_mass": CENTRE_OF_MASS,
    } | changes
    return FlexibleBody(vertices, faces, labels, **fields)


@pytest.fixture(scope="module")
def box():
    return barge.box(LENGTH, BEAM, DRAUGHT, 2)


def shell_with(amplitude):
    """Unit sphere, half immersed, deformed by P_2 along the radius; its degrees of freedom are heave and P_2."""
    basis = ModeBasis(Shell(1.0, 0.01, 1.0, 0.0, 1.0), (Mode("P2", 2, 1.0, 0.0),), 1.0, bending=False)
    return DeformedShell(basis, 0.0, np.array([0.0, amplitude]))


def revolved_body(shell, rows, degrees, azimuth):
    """Wetted shell as quadrilaterals with the displacements P_n e_r, as `Radial<n>` of the axisymmetric solvers."""
    phi = graded_colatitudes(shell.wet_segments[0][0], rows)
    m = shell.meridian(phi)
    vertices, faces = revolved(polygon_radius(azimuth) * np.append(m.x[:-1], 0.0), np.append(0.0, m.z[1:]), azimuth)
    p, theta = np.repeat(phi, azimuth), np.tile(2 * np.pi * np.arange(azimuth) / azimuth, rows + 1)
    radial = np.column_stack([np.sin(p) * np.cos(theta), np.sin(p) * np.sin(theta), np.cos(p)])
    shapes = np.array([legendre(max(degrees), p)[0][n][:, None] * radial for n in degrees])
    return made(vertices, faces, shapes, tuple(f"Radial{n}" for n in degrees))


def test_volume_is_found_thrice(box):
    body = made(*box, rigid(box[0])[2:3])
    assert body.volumes == pytest.approx([LENGTH * BEAM * DRAUGHT] * 3, rel=1e-13)


def test_rigid_stiffness_is_waterplane_and_metacentric_heights(box):
    about = np.array([0.5, -0.2, 0.1])
    body = made(*box, rigid(box[0], about)[[2, 3, 4]])
    volume, area = LENGTH * BEAM * DRAUGHT, LENGTH * BEAM
    inertia = [area * BEAM**2 / 12, area * LENGTH**2 / 12]
    lever = -DRAUGHT / 2 - CENTRE_OF_MASS[2]  # centre of buoyancy over centre of mass
    expected = np.array(
        [
            [area, area * -about[1], area * about[0]],
            [area * -about[1], inertia[0] + area * about[1] ** 2 + volume * lever, -area * about[0] * about[1]],
            [area * about[0], -area * about[0] * about[1], inertia[1] + area * about[0] ** 2 + volume * lever],
        ]
    )
    stiffness = hydrostatic_stiffness(body, 1025.0, 9.81)
    # the body floats upright: its centres lie on one vertical line, so the axis of rotation does not matter otherwise
    assert stiffness == pytest.approx(1025.0 * 9.81 * expected, rel=1e-12, abs=1e-4)


def test_horizontal_motions_and_yaw_feel_no_stiffness(box):
    body = made(*box, rigid(box[0])[[0, 1, 5]])
    assert np.abs(hydrostatic_stiffness(body, 1.0, 1.0)).max() < 1e-12


def energy(vertices, faces):
    """-int z dV over the displaced volume, triangle by triangle by the divergence theorem: quadrature of its own."""
    total = 0.0
    for half in (faces[:, :3], faces[:, [0, 2, 3]]):
        a, b, c = vertices[half].swapaxes(0, 1)
        area = np.cross(b - a, c - a)[:, 2] / 2
        middles = [(a + b)[:, 2] / 2, (b + c)[:, 2] / 2, (c + a)[:, 2] / 2]  # exact for squares
        total -= 0.5 * np.sum(area * sum(m**2 for m in middles) / 3)
    return total


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_flexible_stiffness_is_the_second_derivative_of_the_waters_energy(seed):
    vertices, faces = barge.box(LENGTH, BEAM, DRAUGHT, 1)
    shapes = np.random.default_rng(seed).normal(size=(2, *vertices.shape))
    stiffness = hydrostatic_stiffness(made(vertices, faces, shapes), 1.0, 1.0)
    q, h = np.meshgrid([-1, 0, 1], [-1, 0, 1], indexing="ij"), 1e-3

    u = np.vectorize(lambda a, b: energy(vertices + h * (a * shapes[0] + b * shapes[1]), faces))(*q)
    second = np.array(
        [
            [u[2, 1] - 2 * u[1, 1] + u[0, 1], (u[2, 2] - u[2, 0] - u[0, 2] + u[0, 0]) / 4],
            [(u[2, 2] - u[2, 0] - u[0, 2] + u[0, 0]) / 4, u[1, 2] - 2 * u[1, 1] + u[1, 0]],
        ]
    )
    assert stiffness == pytest.approx(second / h**2, rel=2e-3, abs=2e-3 * np.abs(stiffness).max())


@pytest.mark.parametrize("amplitude", [-0.15, 0.0, 0.15])
def test_stiffness_of_a_deformed_shell_converges_to_the_exact_jacobian_at_second_order(amplitude):
    shell, rows = shell_with(amplitude), np.array([6, 9, 13, 19])
    exact = shell.hydrostatic_stiffness(1.0, 1.0)
    found = []
    for n in rows:
        body = revolved_body(shell, n, (1, 2), 4 * n)
        heave = np.tile([0.0, 0.0, 1.0], (len(body.vertices), 1))[None]
        both = made(body.vertices, body.faces, np.concatenate([heave, body.shapes[1:]]))
        found.append(hydrostatic_stiffness(both, 1.0, 1.0))
    errors = np.abs(np.array(found) - exact).max(axis=(1, 2)) / np.abs(exact).max()
    order = -np.polyfit(np.log(rows), np.log(errors), 1)[0]
    assert 1.8 < order < 2.2, errors
    limit, _ = barge.limit_and_order(rows, np.array(found).reshape(4, -1))
    assert limit == pytest.approx(exact.ravel(), abs=3e-3 * np.abs(exact).max())


def test_rigid_motions_are_recognised(box):
    shapes = np.concatenate([rigid(box[0], (1.0, 2.0, 3.0)), (box[0][:, :1] ** 2 * [[0.0, 0.0, 1.0]])[None]])
    body = made(*box, shapes)
    assert sorted(body.rigid) == list(range(6))
    assert body.rigid[4][1] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)


LINEAR = np.array([[1.0, 0.2, 0.3], [0.0, 1.0, 0.5], [0.4, 0.0, 1.0]])


def test_corner_values_are_interpolated_at_centroids_exactly_where_they_are_linear():
    body = revolved_body(shell_with(0.15), 4, (1,), 8)  # trapezoids and triangles
    field = at_centres(body.vertices, body.faces, (body.vertices @ LINEAR)[None])[0]
    assert field == pytest.approx(body.centres @ LINEAR, abs=1e-14)


def test_panel_values_reach_corners_as_means_also_where_every_panel_has_corners_of_its_own(box):
    vertices, faces = box
    values = (at_centres(vertices, faces, vertices[None])[0] @ LINEAR)[None]
    shared = at_vertices(vertices, faces, values)
    apart = at_vertices(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 4), values)
    assert apart.reshape(-1, 4, 3) == pytest.approx(shared[0][faces], abs=1e-14)
    middle = int(np.argmin(np.linalg.norm(vertices - [0.0, 0.0, -DRAUGHT], axis=1)))  # four equal panels meet here
    assert shared[0, middle] == pytest.approx(vertices[middle] @ LINEAR, abs=1e-14)


def test_symmetry_is_detected_or_refused(box):
    vertices, faces = box
    heave = rigid(vertices)[2:3]
    assert bodies.detected_symmetry(made(vertices, faces, heave)) == "xOz+yOz"
    moved = made(vertices + np.array([0.1, 0.0, 0.0]), faces, heave)
    assert bodies.detected_symmetry(moved) == "xOz"
    bodies.check_symmetry(moved, "xOz")
    with pytest.raises(ConfigError, match="not mirrored in the yOz plane"):
        bodies.check_symmetry(moved, "xOz+yOz")


def test_a_panel_across_a_plane_leaves_no_symmetry():
    shell = shell_with(0.0)
    assert bodies.detected_symmetry(revolved_body(shell, 4, (1,), 8)) == "xOz+yOz"
    assert bodies.detected_symmetry(revolved_body(shell, 4, (1,), 6)) == "xOz"
    vertices, faces = revolved_body(shell, 4, (1,), 8).vertices, revolved_body(shell, 4, (1,), 8).faces
    turn = np.pi / 8
    turned = vertices @ np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    assert bodies.detected_symmetry(made(turned, faces, rigid(turned)[2:3])) == "none"


def changed(array, index, value):
    out = np.array(array, dtype=float)
    out[index] = value
    return out


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v, f, s: {"vertices": changed(v, (0, 0), np.nan)}, "a vertex is NaN"),
        (lambda v, f, s: {"faces": f + 1}, "panels whose corners are there"),
        (lambda v, f, s: {"faces": f[:0], "modes": np.zeros((2, 0, 3))}, r"0 panels between \d+ vertices; needs panels"),
        (lambda v, f, s: {"vertices": v + np.array([0, 0, 0.5])}, "needs z <= 0: clip it"),
        (lambda v, f, s: {"faces": f[:, ::-1]}, "flip them"),
        (lambda v, f, s: {"faces": np.concatenate([f[:-1], f[-1:, ::-1]])}, "list their corners in opposite order"),
        (lambda v, f, s: {"faces": f[8:], "modes": np.ones((2, len(f) - 8, 3))}, "closed below z = 0"),
        (lambda v, f, s: {"vertices": v * [1, 1, 0]}, "panels in the water's surface"),
        (lambda v, f, s: {"labels": ("a", "a")}, "none twice"),
        (lambda v, f, s: {"labels": ()}, "needs at least one"),
        (lambda v, f, s: {"modes": np.ones((2, 3, 3))}, "modes: shape"),
        (lambda v, f, s: {"shapes": s[:1]}, "shapes: shape"),
        (lambda v, f, s: {"mass": np.eye(3)}, "mass: shape"),
        (lambda v, f, s: {"stiffness": np.full((2, 2), np.inf)}, "stiffness: holds NaN"),
        (lambda v, f, s: {"mass": np.array([[1.0, 0.1], [0.0, 1.0]])}, "mass: not symmetric"),
        (lambda v, f, s: {"modes": np.zeros((2, len(f), 3))}, "moves no water"),
        (lambda v, f, s: {"centre_of_mass": None}, "centre_of_mass is missing"),
    ],
)  # fmt: skip
def test_what_no_solver_can_use_is_refused(box, change, message):
    vertices, faces = box
    shapes = rigid(vertices)[[2, 4]]
    fields = {
        "vertices": vertices, "faces": faces, "labels": ("Heave", "Pitch"), "modes": at_centres(vertices, faces, shapes),
        "shapes": shapes, "centre_of_mass": CENTRE_OF_MASS,
    } | change(vertices, faces, shapes)  # fmt: skip
    with pytest.raises(ConfigError, match=message):
        FlexibleBody(**fields)


def test_a_panel_without_area_is_refused(box):
    vertices, faces = box
    faces = np.concatenate([faces, [[0, 0, 1, 1]]])
    with pytest.raises(ConfigError, match=f"panel {len(faces) - 1} has no area"):
        at_centres(vertices, faces, vertices[None])


def test_diameters_are_diagonals_of_rectangles(box):
    body = made(*box, rigid(box[0])[2:3])
    corner = body.vertices[body.faces]
    assert bodies.panel_diameters(body) == pytest.approx(np.linalg.norm(corner[:, 2] - corner[:, 0], axis=1))


def test_round_off_of_a_fit_is_no_rotation(box):
    """Heave alone, on a box off the axis: no centre of mass is asked for."""
    vertices, faces = box
    moved = vertices + np.array([3.7, 1.3, 0.0])
    body = made(moved, faces, rigid(moved)[2:3], centre_of_mass=None)
    assert np.all(body.rigid[0][1] == 0.0)
    with pytest.raises(ConfigError, match="centre_of_mass is missing"):
        made(moved, faces, rigid(moved)[4:5], centre_of_mass=None)


RIGID = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


@given(st.tuples(*[st.floats(-50.0, 50.0)] * 3), st.permutations(range(6)))
@settings(max_examples=20)
def test_unit_motions_bear_their_names_about_any_point(box, point, order):
    vertices, faces = box
    shapes = rigid(vertices, point)[list(order)]
    named = made(vertices, faces, shapes, tuple(RIGID[k] for k in order))
    assert bodies.rigid_misfit(named) < 1e-12
    assert bodies.rigid_misfit(made(vertices, faces, shapes)) == 0.0  # other names promise nothing


@pytest.mark.parametrize(("named", "is_", "misfit"), [("Heave", 2.0, 1.0), ("Pitch", -1.0, 2.0), ("Yaw", 0.5, 0.5)])
def test_a_name_of_another_size_or_sign_is_told(box, named, is_, misfit):
    vertices, faces = box
    shape = is_ * rigid(vertices)[RIGID.index(named)][None]
    assert bodies.rigid_misfit(made(vertices, faces, shape, (named,))) == pytest.approx(misfit)


def test_a_name_of_another_motion_is_told(box):
    vertices, faces = box
    assert bodies.rigid_misfit(made(vertices, faces, rigid(vertices)[:1], ("Heave",))) == pytest.approx(1.0)
    assert bodies.rigid_misfit(made(vertices, faces, rigid(vertices)[3:4], ("Pitch",))) > 0.3


def test_a_body_of_millimetres_is_refused():
    vertices, faces = barge.box(LENGTH / 1000, BEAM / 1000, DRAUGHT / 1000, 1)
    with pytest.raises(ConfigError, match=r"mesh: body of 0.00748 m; needs at least 0.01 m: is it in metres"):
        made(vertices, faces, rigid(vertices)[2:3])


def two_panels(left, right):
    """Panels on both sides of the plane y = 0, of equal area and mirrored centres; they bound nothing."""
    vertices = np.array([[x, y - 2.0, -1.0] for x, y in left] + [[x, y + 2.0, -1.0] for x, y in right])
    faces, shapes = np.arange(8).reshape(2, 4), np.ones((1, 8, 3))
    return CoarserBody(vertices, faces, ("Dof",), at_centres(vertices, faces, shapes), shapes)


SQUARE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
DIAMOND = [(0, -(2**0.5)), (2**0.5, 0), (0, 2**0.5), (-(2**0.5), 0)]
WIDE = [(x, 3 * y) for x, y in SQUARE]


@pytest.mark.parametrize(
    ("left", "right", "found"),
    [
        (SQUARE, SQUARE, "xOz"),
        (SQUARE, SQUARE[2:] + SQUARE[:2], "xOz"),
        (SQUARE, DIAMOND, "none"),  # centres are mirrored, corners are not
        (WIDE, WIDE, "none"),  # across the plane
        (SQUARE, [(x + 0.1, y) for x, y in SQUARE], "none"),
    ],
)
def test_symmetry_is_of_corners_not_of_centres_alone(left, right, found):
    body = two_panels(left, right)
    assert bodies.detected_symmetry(body) == found
    if found == "none":
        with pytest.raises(ConfigError, match="symmetry xOz: the panels are not mirrored in the xOz plane"):
            bodies.check_symmetry(body, "xOz")


def test_a_wall_in_a_plane_is_no_mirror_image_of_its_own():
    """Solved by halves, it would count twice."""
    both = two_panels(SQUARE, SQUARE)
    wall = np.array([[-1.0, 0.0, -3.0], [1.0, 0.0, -3.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]])
    vertices, faces = np.concatenate([both.vertices, wall]), np.arange(12).reshape(3, 4)
    body = CoarserBody(vertices, faces, ("Dof",), np.ones((1, 3, 3)), np.ones((1, 12, 3)))
    assert bodies.detected_symmetry(both) == "xOz"
    assert bodies.detected_symmetry(body) == "none"


@pytest.mark.parametrize(("degree", "rows"), [(0, 20), (2, 24), (6, 40)])
def test_panels_in_a_lobe_are_those_of_the_wavenumber(degree, rows):
    """int |grad psi|^2 = (n(n + 1) + 2) int |psi|^2/r^2 of P_n e_r over half a sphere: e_r turns, too."""
    body = revolved_body(shell_with(0.0), rows, (degree,), 2 * rows)
    expected = np.pi / np.sqrt(degree * (degree + 1) + 2) / bodies.panel_size(body)
    assert bodies.panels_per_lobe(body) == pytest.approx(expected, rel=6e-3)


def test_rigid_motions_need_no_panels_and_the_shortest_mode_counts(box):
    shapes = np.concatenate([rigid(box[0]), *(np.cos(k * box[0][:, :1])[None] * [0, 0, 1] for k in (0.3, 1.0))])
    assert bodies.panels_per_lobe(made(*box, shapes[:6])) == np.inf
    alone = [bodies.panels_per_lobe(made(*box, shapes[[i]])) for i in (6, 7)]
    assert alone[1] < alone[0]
    assert bodies.panels_per_lobe(made(*box, shapes)) == pytest.approx(alone[1])
    assert bodies.panels_per_lobe(made(*box, 1e3 * shapes)) == pytest.approx(alone[1])


def test_parts_that_move_past_each_other_need_no_panels(box):
    """Heave of one against the other bends nothing: no division by its gradient, which vanishes."""
    vertices, faces = box
    both = np.concatenate([vertices, vertices + np.array([2 * LENGTH, 0.0, 0.0])])
    past = np.zeros_like(both)
    past[:, 2] = np.repeat([0.5, -0.5], len(vertices))
    assert bodies.panels_per_lobe(made(both, np.concatenate([faces, faces + len(vertices)]), past[None])) > 1e6


@pytest.mark.parametrize("reach", [2e5, 1e9])
def test_a_body_beyond_the_horizon_is_refused(box, reach):
    with pytest.raises(ConfigError, match=r"mesh: reaches .* m; needs at most 100000 m: is it in metres"):
        made(box[0] + [reach, 0.0, 0.0], box[1], rigid(box[0])[2:3])


@given(hnp.arrays(float, (4, 3), elements=st.floats(-5.0, 5.0)))
def test_a_panel_s_diameter_is_the_largest_distance_of_its_corners(corners):
    """Of any four, a triangle's twice the same among them."""
    body = SimpleNamespace(vertices=corners, faces=np.array([[0, 1, 2, 3], [0, 1, 2, 2], [3, 3, 1, 0]]))
    expected = [max(np.linalg.norm(corners[a] - corners[b]) for a in face for b in face) for face in body.faces]
    np.testing.assert_allclose(bodies.panel_diameters(body), expected, rtol=1e-12)


def boxed(box, move=lambda x: x, faces=None):
    """The box with its vertices moved, heaving."""
    vertices = move(box[0].copy())
    return made(vertices, box[1] if faces is None else faces, rigid(vertices)[2:3])


REACH = np.linalg.norm([LENGTH, BEAM, DRAUGHT])
"""Diagonal of the box, in which round-off of its vertices is told."""


def test_a_body_may_reach_above_the_water_by_round_off_of_its_own_size_and_no_more(box):
    boxed(box, lambda x: x - [0.0, 0.0, -0.9e-8 * REACH])
    with pytest.raises(
        ConfigError, match=r"mesh: reaches z = 8\.232e-08 m; needs z <= 0: clip it at the water's surfa"
    ):
        boxed(box, lambda x: x - [0.0, 0.0, -1.1e-8 * REACH])


def test_points_of_no_panel_may_lie_anywhere(box):
    vertices = np.vstack([box[0], [0.0, 0.0, 5.0]])
    assert made(vertices, box[1], rigid(vertices)[2:3]).volumes == pytest.approx([LENGTH * BEAM * DRAUGHT] * 3)


def test_one_panel_in_the_waters_surface_is_a_lid(box):
    """As near to it as round-off of the body's size."""

    def lidded(depth):
        corners = [[x, y, -depth] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        vertices, faces = np.vstack([box[0], corners]), np.vstack([box[1], len(box[0]) + np.arange(4)])
        return made(vertices, faces, rigid(vertices)[2:3])

    lidded(1.1e-8 * REACH)
    with pytest.raises(
        ConfigError, match="mesh: has panels in the water's surface; needs the wetted surface alone, no l"
    ):
        lidded(0.9e-8 * REACH)


def test_corners_are_counted_from_the_first_vertex_to_the_last(box):
    """-1 would be the last one again, and nothing would look wrong."""
    last = len(box[0]) - 1
    boxed(box, faces=box[1])
    for wrong in (-1, last + 1):
        faces = np.where(box[1] == last, wrong, box[1])
        assert (faces == wrong).any()
        with pytest.raises(
            ConfigError, match=f"mesh: {len(faces)} panels between {last + 1} vertices; needs panels wh"
        ):
            FlexibleBody(box[0], faces, ("Heave",), np.ones((1, len(faces), 3)), rigid(box[0])[2:3])


def test_a_body_is_between_a_centimetre_and_a_hundred_kilometres(box):
    boxed(box, lambda x: x * (0.0101 / REACH))
    with pytest.raises(ConfigError, match=r"mesh: body of 0\.0099 m; needs at least 0\.01 m: is it in metres"):
        boxed(box, lambda x: x * (0.0099 / REACH))
    bodies.check_vertices(np.array([[-1e5, 0.0, 1e5]]))
    with pytest.raises(ConfigError, match=r"mesh: reaches 1e\+05 m; needs at most 100000 m: is it in metres"):
        bodies.check_vertices(np.array([[0.0, np.nextafter(-1e5, -np.inf), 0.0]]))


NONE = np.empty((0, 2), dtype=int)


def test_parts_are_numbered_by_their_first_panels_whatever_their_corners_are():
    """Four of them, taken in turn: the third has the first corners."""
    faces = np.array(
        [[4, 5, 6, 7], [12, 13, 14, 15], [0, 1, 2, 3], [6, 7, 20, 20], [8, 9, 10, 10], [15, 16, 12, 12], [3, 2, 17, 17]]
    )
    assert bodies.parts(faces, NONE).tolist() == [0, 1, 2, 0, 3, 1, 2]
    for order in ([2, 4, 1, 0], [4, 0, 2, 1], [1, 2, 0, 4]):
        assert bodies.parts(faces[order], NONE).tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("order", [[0, 1, 2], [1, 2, 0], [2, 0, 1]])
def test_of_several_named_motions_the_one_furthest_from_its_name_counts(box, order):
    names, sizes = np.array(["Surge", "Yaw", "Heave"]), np.array([1.2, -1.0, 0.7])
    shapes = sizes[:, None, None] * rigid(box[0])[[0, 5, 2]]
    assert bodies.rigid_misfit(made(*box, shapes[order], tuple(names[order]))) == pytest.approx(2.0)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_surface_open_to_any_side_is_told_to_be_open_not_to_be_turned(box, axis):
    """By the normals along that axis it encloses nothing."""
    vertices, faces = box
    corner = vertices[faces]
    along = np.abs(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]))
    with pytest.raises(ConfigError, match=r"mesh: open at \(.*\): \d+ edges below z = 0 belong to one panel only"):
        boxed(box, faces=faces[along.argmax(axis=1) != axis])


@pytest.mark.parametrize("name", ["mass", "stiffness"])
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_matrices_are_symmetric_to_a_billionth_of_their_largest_entry(box, name, scale):
    for part, known in ((0.9, True), (1.1, False), (-0.9, True), (-1.1, False)):
        matrix = scale * np.array([[-2.0, 0.5], [0.5 + 2e-9 * part, 1.0]])
        if known:
            made(*box, rigid(box[0])[[2, 4]], **{name: matrix})
            continue
        with pytest.raises(ConfigError, match=f"{name}: not symmetric; needs a symmetric matrix"):
            made(*box, rigid(box[0])[[2, 4]], **{name: matrix})


def test_the_size_of_panels_is_the_mean_of_the_roots_of_their_areas_over_the_surface():
    """A square of side 1, a triangle of area 8, a quadrilateral of halves 1/2 and 3."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1), (4, 0), (0, 4), (2, 1), (-2, 2)]
    vertices = np.column_stack([np.array(corners, dtype=float), np.full(8, -1.0)])
    faces = np.array([[0, 1, 2, 3], [0, 4, 5, 5], [0, 1, 6, 7]])
    body = CoarserBody(vertices, faces, ("Dof",), np.ones((1, 3, 3)), np.ones((1, 8, 3)))
    assert bodies.panel_size(body) == pytest.approx((1.0 + 8.0**1.5 + 3.5**1.5) / 12.5, rel=1e-12)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_panels_in_a_lobe_of_a_stretch_are_the_same_on_skewed_triangles(order):
    """psi = (a x + b y) e_x: |grad psi|^2 = a^2 + b^2 everywhere, int psi^2 by the middles of the sides."""
    corners = np.array([[0.0, 0.0, -1.0], [5.0, 0.5, -1.0], [6.0, 2.0, -1.0], [1.5, 3.0, -1.0]])
    faces = np.array([[0, 1, 2, 2], [0, 2, 3, 3]])
    slopes = np.array([[0.7, -0.4], [0.1, 0.3]])[order]
    shapes = np.array([(corners[:, :2] @ slope)[:, None] * [1.0, 0.0, 0.0] for slope in slopes])
    body = CoarserBody(corners, faces, ("A", "B"), np.ones((2, 2, 3)), shapes)
    area, square = np.zeros(2), np.zeros((2, 2))
    for k, face in enumerate(faces[:, :3]):
        x = corners[face]
        area[k] = np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / 2
        middles = (x + np.roll(x, 1, axis=0)) / 2
        square[:, k] = area[k] * ((middles[:, :2] @ slopes.T) ** 2).mean(axis=0)
    wavenumber = np.sqrt((slopes**2).sum(axis=1) * area.sum() / square.sum(axis=1))
    expected = np.pi / wavenumber.max() / ((area**1.5).sum() / area.sum())
    assert bodies.panels_per_lobe(body) == pytest.approx(expected, rel=1e-12)


def test_normals_into_the_body_are_told_with_the_volume_they_enclose(box):
    with pytest.raises(
        ConfigError, match=r"^mesh: encloses -48 m\^3; needs normals that point into the water: flip them$"
    ):
        boxed(box, faces=box[1][:, ::-1])


@pytest.mark.parametrize("still", [0, 1, 2])
def test_the_mode_that_moves_no_water_is_named(box, still):
    """Tangential displacements of a box: what slides along its sides and bottom."""
    shapes = rigid(box[0])[[0, 2, 4]]
    modes = at_centres(*box, shapes)
    modes[still] = np.cross(modes[still], _normals(box))
    with pytest.raises(ConfigError, match=rf"^modes: Dof{still} moves no water; remove it$"):
        made(*box, shapes, modes=modes)


def _normals(box):
    corner = box[0][box[1]]
    return np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_mode_that_draws_water_in_moves_some(box, sign):
    shapes = sign * np.concatenate([box[0][None], rigid(box[0])[2:3]])
    assert len(made(*box, shapes).labels) == 2


@pytest.mark.parametrize(("declared", "lacking"), [("xOz", "xOz"), ("yOz", None), ("xOz+yOz", "xOz")])
def test_the_plane_that_lacks_is_named(box, declared, lacking):
    body = boxed(box, lambda x: x + np.array([0.0, 0.3, 0.0]))
    assert bodies.detected_symmetry(body) == "yOz"
    if lacking is None:
        bodies.check_symmetry(body, declared)
        return
    told = f"symmetry {declared}: the panels are not mirrored in the {lacking} plane, or some lie across it; "
    with pytest.raises(ConfigError) as error:
        bodies.check_symmetry(body, declared)
    assert str(error.value) == f"{told}correct the mesh or declare less"


@pytest.mark.parametrize("name", ["mass", "stiffness", "modes", "shapes", "centre_of_mass"])
def test_every_array_of_a_body_has_its_shape_and_finite_numbers(box, name):
    vertices, faces = box
    shapes = rigid(vertices)[[2, 4]]
    sound = {"mass": np.eye(2), "stiffness": np.eye(2), "centre_of_mass": CENTRE_OF_MASS}
    sound |= {"modes": at_centres(vertices, faces, shapes), "shapes": shapes}
    FlexibleBody(vertices, faces, ("A", "B"), **sound)
    for value in (np.nan, -np.inf):
        array = np.array(sound[name], dtype=float)
        array[(-1,) * array.ndim] = value
        with pytest.raises(ConfigError, match=f"^{name}: holds NaN or infinite values; needs finite ones$"):
            FlexibleBody(vertices, faces, ("A", "B"), **sound | {name: array})
    wrong = np.ones((3, *np.shape(sound[name])[1:])) if name != "centre_of_mass" else np.ones(2)
    told = f"^{name}: shape {re.escape(str(wrong.shape))}; needs "
    with pytest.raises(ConfigError, match=told):
        FlexibleBody(vertices, faces, ("A", "B"), **sound | {name: wrong})


@pytest.mark.parametrize("panels", ["largest", "smallest"])
def test_water_moved_counts_by_the_largest_panel(box, panels):
    """A normal displacement of 1e-12 of the largest panel, or as much more of a smaller one, is the least that moves."""
    normals = _normals(box)
    area = np.linalg.norm(normals, axis=1)
    assert area.max() > 2 * area.min()
    at = int(area.argmax() if panels == "largest" else area.argmin())
    shapes = rigid(box[0])[:1]
    still = np.zeros((1, len(area), 3))
    still[0, :, 2] = np.abs(normals[:, 2]) < 1e-9 * area  # the sides slide down by one, the bottom rests
    for share, moves in ((0.9, False), (1.1, True)):
        modes = still.copy()
        modes[0, at] += share * 1e-12 * area.max() / area[at] * normals[at] / area[at]
        for unit in (1.0, 1e-9, 1e9):  # of its amplitude
            if moves:
                made(*box, shapes, modes=unit * modes)
                continue
            with pytest.raises(ConfigError, match=r"^modes: Dof0 moves no water; remove it$"):
                made(*box, shapes, modes=unit * modes)


@pytest.mark.parametrize(("turned", "found"), [(0, "xOz"), (2, "xOz"), (1, "none")])
def test_one_panel_folded_along_its_other_diagonal_is_no_mirror_image(turned, found):
    """Beside one that is: its corners are all there, begun with the next of them; its surface is another."""
    flat = np.array([(x, y - 2.0, -1.0) for x, y in SQUARE])
    folded = flat + np.array([(5.0, 0.0, 0.1), (5.0, 0.0, 0.3), (5.0, 0.0, 0.0), (5.0, 0.0, 0.0)])
    mirror = np.array([1.0, -1.0, 1.0])
    vertices = np.concatenate([flat, flat * mirror, folded, np.roll(folded, -turned, axis=0) * mirror])
    faces, shapes = np.arange(16).reshape(4, 4), np.ones((1, 16, 3))
    body = CoarserBody(vertices, faces, ("Dof",), at_centres(vertices, faces, shapes), shapes)
    assert bodies.detected_symmetry(body) == found
    if found == "none":
        with pytest.raises(ConfigError, match="symmetry xOz: the panels are not mirrored in the xOz plane"):
            bodies.check_symmetry(body, "xOz")


def test_corners_of_no_panel_are_at_rest_and_in_nobodys_way(box):
    """Displacements of panels reach those that have some; a file may list more points than it needs."""
    vertices, faces = np.vstack([box[0][:3], [9.0, 9.0, -9.0], box[0][3:]]), np.where(box[1] > 2, box[1] + 1, box[1])
    values = np.random.default_rng(1).normal(size=(2, len(faces), 3))
    found, bare = at_vertices(vertices, faces, values), at_vertices(*box, values)
    assert found[:, 3].tolist() == [[0.0] * 3] * 2
    np.testing.assert_allclose(np.delete(found, 3, axis=1), bare, rtol=1e-12)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize(("share", "same"), [(0.9, True), (1.1, False)])
def test_vertices_coincide_within_a_hundred_millionth_of_the_body(size, share, same):
    """Of the diagonal of all there is; the first of them stands for the others, in whatever order they are found."""
    far, near = np.array([2.0, 1.0, -2.0]), share * 1e-8 * 3.0  # the diagonal is 3
    points = np.array([[0, 0, 0], far, far - [0, 0, -near], [0, near, 0], [1, 1, -1], far])
    assert bodies.owners(size * points).tolist() == ([0, 1, 1, 0, 4, 1] if same else [0, 1, 2, 3, 4, 1])
