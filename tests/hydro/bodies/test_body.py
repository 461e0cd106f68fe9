"""A body: its hydrostatic stiffness, checks, symmetry and resolution."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import barge
from vsb.engine.hydro.bodies import body as bodies
from vsb.engine.hydro.bodies.body import FlexibleBody
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.bodies.mesh import at_centres
from vsb.engine.hydro.panels.mesh import graded_colatitudes, polygon_radius, revolved
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import Mode, ModeBasis
from vsb.engine.shell.ritz import legendre
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError

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


def test_volume_from_each_component_of_the_normals(box):
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


def test_symmetry_is_detected_or_refused(box):
    vertices, faces = box
    heave = rigid(vertices)[2:3]
    assert bodies.detected_symmetry(made(vertices, faces, heave)) == "xOz+yOz"
    moved = made(vertices + np.array([0.1, 0.0, 0.0]), faces, heave)
    assert bodies.detected_symmetry(moved) == "xOz"
    bodies.check_symmetry(moved, "xOz")
    with pytest.raises(ConfigError, match="not mirrored in the yOz plane"):
        bodies.check_symmetry(moved, "xOz+yOz")


def test_panel_across_a_plane_breaks_the_symmetry():
    shell = shell_with(0.0)
    assert bodies.detected_symmetry(revolved_body(shell, 4, (1,), 8)) == "xOz+yOz"
    assert bodies.detected_symmetry(revolved_body(shell, 4, (1,), 6)) == "xOz"
    vertices, faces = revolved_body(shell, 4, (1,), 8).vertices, revolved_body(shell, 4, (1,), 8).faces
    turn = np.pi / 8
    turned = vertices @ np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    assert bodies.detected_symmetry(made(turned, faces, rigid(turned)[2:3])) == "none"


def normals(vertices, faces):
    corner = vertices[faces]
    return np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])


def changed(array, index, value):
    out = np.array(array, dtype=float)
    out[index] = value
    return out


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v, f, s: {"vertices": changed(v, (0, 0), np.nan)}, "a vertex is NaN"),
        (lambda v, f, s: {"faces": f + 1}, "panels whose corners are there"),
        (lambda v, f, s: {"faces": f - 1}, "panels whose corners are there"),
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
        (lambda v, f, s: {"modes": np.cross(at_centres(v, f, s), normals(v, f))}, "Heave moves no water; remove it"),
        (lambda v, f, s: {"centre_of_mass": None}, "centre_of_mass is missing"),
        (lambda v, f, s: {"centre_of_mass": np.ones(2)}, r"centre_of_mass: shape \(2,\); needs \(3,\), or a row"),
        (lambda v, f, s: {"centre_of_mass": np.full(3, np.nan)}, "centre_of_mass: holds NaN"),
        (lambda v, f, s: {"vertices": v / 1000}, r"mesh: body of 0.00748 m; needs at least 0.01 m: is it in metres"),
        (lambda v, f, s: {"vertices": v + np.array([2e5, 0, 0])}, r"mesh: reaches 2e\+05 m; needs at most 100000 m"),
    ],
)  # fmt: skip
def test_wrong_bodies_are_refused_by_name(box, change, message):
    vertices, faces = box
    shapes = rigid(vertices)[[2, 4]]
    fields = {
        "vertices": vertices, "faces": faces, "labels": ("Heave", "Pitch"), "modes": at_centres(vertices, faces, shapes),
        "shapes": shapes, "centre_of_mass": CENTRE_OF_MASS,
    } | change(vertices, faces, shapes)  # fmt: skip
    with pytest.raises(ConfigError, match=message):
        FlexibleBody(**fields)


RIGID = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


@given(st.tuples(*[st.floats(-50.0, 50.0)] * 3), st.permutations(range(6)))
@settings(max_examples=20)
def test_named_unit_motions_have_no_misfit(box, point, order):
    vertices, faces = box
    shapes = rigid(vertices, point)[list(order)]
    named = made(vertices, faces, shapes, tuple(RIGID[k] for k in order))
    assert bodies.rigid_misfit(named) < 1e-12
    assert bodies.rigid_misfit(made(vertices, faces, shapes)) == 0.0  # other names promise nothing


@pytest.mark.parametrize(("named", "is_", "misfit"), [("Heave", 2.0, 1.0), ("Pitch", -1.0, 2.0), ("Yaw", 0.5, 0.5)])
def test_named_motion_of_another_size_or_sign_is_a_misfit(box, named, is_, misfit):
    vertices, faces = box
    shape = is_ * rigid(vertices)[RIGID.index(named)][None]
    assert bodies.rigid_misfit(made(vertices, faces, shape, (named,))) == pytest.approx(misfit)


@pytest.mark.parametrize(("degree", "rows"), [(0, 20), (6, 40)])
def test_panels_per_lobe_of_a_sphere(degree, rows):
    """int |grad psi|^2 = (n(n + 1) + 2) int |psi|^2/r^2 of P_n e_r over half a sphere: e_r turns, too."""
    body = revolved_body(shell_with(0.0), rows, (degree,), 2 * rows)
    expected = np.pi / np.sqrt(degree * (degree + 1) + 2) / bodies.panel_size(body)
    assert bodies.panels_per_lobe(body) == pytest.approx(expected, rel=6e-3)
