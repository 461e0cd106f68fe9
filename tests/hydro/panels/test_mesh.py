import numpy as np
import pytest

from vsb.engine.hydro.panels.mesh import deformed_mesh, graded_colatitudes, mean_mesh, polygon_radius, revolved
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis


def panel_area(vertices, faces):
    a, b, c, d = (vertices[faces[:, i]] for i in range(4))
    return 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1)


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
