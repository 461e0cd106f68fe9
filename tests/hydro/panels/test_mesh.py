import meshio
import numpy as np
import pytest
from conftest import varied

from vsb.hydro.panels.mesh import (
    deformed_mesh,
    display_shapes,
    graded_colatitudes,
    mean_mesh,
    polygon_radius,
    revolved,
    write_wet_shell,
)
from vsb.scenes.rest import study_basis
from vsb.shell.deformed import DeformedShell, rigid_sphere
from vsb.shell.modes import mode_basis
from vsb.study import study as config


def panel_area(vertices, faces):
    a, b, c, d = (vertices[faces[:, i]] for i in range(4))
    return 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1)


def test_polygon_of_the_circles_area():
    n = 12
    corner = polygon_radius(n)
    assert 0.5 * n * corner**2 * np.sin(2 * np.pi / n) == pytest.approx(np.pi)


def test_rows_start_at_the_waterline_and_are_finest_there():
    phi = graded_colatitudes(1.6, 20)
    assert (phi[0], phi[-1]) == pytest.approx((1.6, np.pi))
    assert np.all(np.diff(phi, 2) > 0)


@pytest.mark.parametrize("height", [-0.5, 0.0, 0.8])
def test_mean_mesh_ends_on_the_surface_and_the_axis(height):
    mesh = mean_mesh(2.0, height, 30, 60, 9)
    assert mesh.meridian_height.values[0] == 0.0
    assert mesh.meridian_radius.values[-1] == 0.0
    assert mesh.meridian_radius.values[0] == mesh.lid_radius.values[-1]
    assert mesh.meridian_height.values[-1] == pytest.approx(height - 2.0)


def test_area_of_the_viewable_mesh_converges_at_second_order(seed, tmp_path):
    shell = DeformedShell(mode_basis(seed.device, "full", 4), 0.3, np.array([0.0, 0.1, 0, 0.05, 0, 0, -0.1, 0, 0]))
    rows, errors = [8, 16, 32, 64], []
    for n in rows:
        write_wet_shell(shell, tmp_path / "wet.vtu", n, 2 * n)
        mesh = meshio.read(tmp_path / "wet.vtu")
        errors.append(abs(panel_area(mesh.points, mesh.cells_dict["quad"]).sum() - shell.wet_area()))
        assert mesh.points[:, 2].max() < 1e-12
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(rows))
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


def test_one_shape_per_mode_and_sign(seed):
    shell = DeformedShell(mode_basis(seed.device, "membrane", 2), 0.0)
    shapes = display_shapes(shell)
    assert list(shapes) == [
        "mean", "Membrane0_minus", "Membrane0_plus", "Membrane1_minus", "Membrane1_plus", "Membrane2_minus", "Membrane2_plus",
    ]  # fmt: skip
    assert shapes["Membrane0_plus"].volume() > shell.volume() > shapes["Membrane0_minus"].volume()


def enclosed_volume(vertices, faces):
    """Volume below z = 0 by the divergence theorem on two triangles per panel; positive for outward normals."""
    a, b, c, d = (vertices[faces[:, i]] for i in range(4))
    return sum(np.einsum("ij,ij->i", p, np.cross(q, r)).sum() for p, q, r in ((a, b, c), (a, c, d))) / 6


@pytest.mark.parametrize("height", [-0.6, 0.0, 0.9])
def test_area_and_volume_of_the_mean_mesh_converge_at_second_order(height):
    depth, rows = 2.0 - height, np.array([20, 40, 80, 160, 320])
    exact = np.array([2 * np.pi * 2.0 * depth, np.pi * depth**2 * (6.0 - depth) / 3])
    errors = []
    for n in rows:
        mesh = mean_mesh(2.0, height, n, 2 * n, 8)
        vertices, faces = revolved(mesh.meridian_radius.values, mesh.meridian_height.values, 2 * n)
        assert (vertices.shape, faces.shape) == (((n + 1) * 2 * n, 3), (n * 2 * n, 4))
        found = np.array([panel_area(vertices, faces).sum(), enclosed_volume(vertices, faces)])
        errors.append(np.abs(found / exact - 1))
    slopes = -np.diff(np.log(errors), axis=0) / np.diff(np.log(rows))[:, None]
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


@pytest.mark.parametrize("azimuth", [3, 8, 80])
def test_every_section_of_the_mesh_keeps_the_area_of_its_circle(azimuth):
    mesh = mean_mesh(2.0, 0.3, 12, azimuth, 5)
    vertices, _ = revolved(mesh.meridian_radius.values, mesh.meridian_height.values, azimuth)
    x, y = vertices[:azimuth, 0], vertices[:azimuth, 1]
    shoelace = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert shoelace == pytest.approx(np.pi * (4.0 - 0.09), rel=1e-12)


def test_normals_point_into_the_water():
    mesh = mean_mesh(2.0, 0.0, 10, 20, 5)
    vertices, faces = revolved(mesh.meridian_radius.values, mesh.meridian_height.values, 20)
    a, b, c, d = (vertices[faces[:, i]] for i in range(4))
    normals, centres = np.cross(c - a, d - b), (a + b + c + d) / 4
    assert np.all(np.einsum("ij,ij->i", normals, centres) > 0)


@pytest.mark.parametrize("rows", [1, 2, 33])
def test_rows_span_any_band(rows):
    phi = graded_colatitudes(0.4, rows, keel=1.1)
    assert phi.shape == (rows + 1,)
    assert (phi[0], phi[-1]) == pytest.approx((0.4, 1.1), rel=1e-15)
    assert np.all(np.diff(phi) > 0)


def test_lid_covers_the_waterplane_in_equal_rows():
    mesh = mean_mesh(2.0, -0.5, 30, 60, 9)
    assert np.diff(mesh.lid_radius.values) == pytest.approx(np.full(9, mesh.lid_radius.values[-1] / 9), rel=1e-12)
    assert mesh.lid_radius.values[-1] == pytest.approx(polygon_radius(60) * np.sqrt(4.0 - 0.25), rel=1e-14)
    assert mesh.attrs["azimuth"] == 60


def test_both_wet_bands_of_a_dented_shell_are_written(seed, tmp_path):
    basis = mode_basis(seed.device, "full", 6)
    shell = DeformedShell(basis, -1.7, -0.4 * np.array([label == "Bending6" for label in basis.labels]))
    assert len(shell.wet_segments) == 2
    write_wet_shell(shell, tmp_path / "deep" / "wet.vtu", 40, 80)
    mesh = meshio.read(tmp_path / "deep" / "wet.vtu")
    quads = mesh.cells_dict["quad"]
    assert quads.shape == (2 * 40 * 80, 4)
    assert panel_area(mesh.points, quads).sum() == pytest.approx(shell.wet_area(120), rel=5e-3)
    assert mesh.points[:, 2].max() < 1e-12


def test_panels_of_three_wet_bands_have_their_own_corners(seed, tmp_path):
    """The first of which is all of the pole."""
    basis = mode_basis(seed.device, "full", 12)
    shell = DeformedShell(basis, -1.5, -0.7 * np.array([label == "Bending12" for label in basis.labels]))
    assert len(shell.wet_segments) == 3
    write_wet_shell(shell, tmp_path / "wet.vtu", 40, 40)
    mesh = meshio.read(tmp_path / "wet.vtu")
    quads = mesh.cells_dict["quad"]
    assert np.array_equal(np.unique(quads), np.arange(len(mesh.points)))
    assert panel_area(mesh.points, quads).sum() == pytest.approx(shell.wet_area(240), rel=2e-2)


def test_viewable_shapes_are_a_tenth_of_the_radius(seed):
    shapes = display_shapes(DeformedShell(mode_basis(seed.device, "full", 3), 0.1))
    for name, shape in shapes.items():
        assert shape.centre_height == 0.1
        if name != "mean":
            assert np.abs(shape.modal_amplitude).sum() == pytest.approx(0.2)
    assert [np.argmax(np.abs(s.modal_amplitude)) for n, s in shapes.items() if n.endswith("plus")] == [1, 2, 3, 4, 5, 6]


def test_every_viewable_shape_of_a_very_light_buoy_is_written(seed, tmp_path):
    study = config.parse(varied(seed, device={"density": 100.0, "mass": 60.0}).model_dump())
    for name, shape in display_shapes(DeformedShell(study_basis(study), study.centre_height)).items():
        write_wet_shell(shape, tmp_path / f"{name}.vtu", 8, 8)
        assert (tmp_path / f"{name}.vtu").is_file()


@pytest.mark.parametrize("height", [-0.5, 0.0, 0.8])
def test_a_shell_that_is_not_deformed_has_the_mesh_of_the_sphere(height):
    found, sphere = deformed_mesh(rigid_sphere(2.0, height), 12, 24, 5), mean_mesh(2.0, height, 12, 24, 5)
    assert found.attrs == sphere.attrs
    for name in sphere:
        np.testing.assert_allclose(found[name].values, sphere[name].values, atol=1e-12, err_msg=name)
    assert sphere.normal_radius.values == pytest.approx(np.sin(sphere.row_colatitude.values))
    assert sphere.normal_height.values == pytest.approx(np.cos(sphere.row_colatitude.values))


@pytest.mark.parametrize(("height", "size"), [(-0.5, 0.2), (0.9, 0.2), (1.5, 0.1), (1.9, 0.02)])
def test_viewable_shapes_of_what_hardly_dips_are_less_and_add_to_the_shape_at_rest(seed, height, size):
    """A tenth of the radius or of two drafts; one mode at a time, of either sign, heave never."""
    rest = np.array([0.01, -0.02, 0.005, 0.0])
    shapes = display_shapes(DeformedShell(mode_basis(seed.device, "membrane", 2), height, rest))
    moved = np.array([shape.modal_amplitude - rest for shape in shapes.values()])
    expected = [0 * rest]
    for j in (1, 2, 3):
        expected += [-size * np.eye(4)[j], size * np.eye(4)[j]]
    assert moved == pytest.approx(np.array(expected), abs=1e-15)
    assert {shape.centre_height for shape in shapes.values()} == {height}


def test_normals_of_a_deformed_shell_are_across_its_meridian_into_the_water(seed):
    """By the chord from row to row, to second order; lid, azimuth and colatitudes are as of the sphere."""
    shell = DeformedShell(mode_basis(seed.device, "full", 4), 0.3, np.array([0.0, 0.1, 0, 0.05, 0, 0, -0.1, 0, 0]))
    mesh = deformed_mesh(shell, 60, 24, 5)
    chord = np.diff([mesh.meridian_radius / polygon_radius(24), mesh.meridian_height], axis=1)
    across = np.array([-chord[1], chord[0]]) / np.hypot(*chord)
    assert np.array([mesh.normal_radius, mesh.normal_height]) == pytest.approx(across, abs=5e-3)
    edges = graded_colatitudes(shell.waterline, 60)
    assert mesh.row_colatitude.values == pytest.approx((edges[1:] + edges[:-1]) / 2)
    tangent = shell.meridian(mesh.row_colatitude.values)
    along = mesh.normal_radius.values * tangent.dx + mesh.normal_height.values * tangent.dz
    assert along == pytest.approx(np.zeros(60), abs=1e-13)
    assert np.hypot(mesh.normal_radius, mesh.normal_height).values == pytest.approx(np.ones(60), rel=1e-14)
    assert mesh.lid_radius.values == pytest.approx(np.linspace(0, mesh.meridian_radius.values[0], 6))
    assert (mesh.meridian_height.values[0], mesh.meridian_radius.values[-1]) == (0.0, 0.0)
