import meshio
import numpy as np
import pytest

from vsb.meshing import display_shapes, graded_colatitudes, mean_mesh, polygon_radius, write_wet_shell
from vsb.modes import mode_basis
from vsb.surface import DeformedShell


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
