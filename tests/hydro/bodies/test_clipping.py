import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_body import rigid

from examples.barge import box
from vsb.errors import ConfigError
from vsb.hydro.bodies.body import at_centres
from vsb.hydro.bodies.files import read_body


def written(path, vertices, faces, modes, dims):
    """A file of a mesh and its displacements, heave and pitch."""
    data = {"vertices": (("vertex", "xyz"), vertices), "faces": (("panel", "corner"), faces)}
    data |= {"mode_shape": (("dof", dims, "xyz"), modes), "centre_of_mass": ("xyz", [0.0, 0.0, 0.1])}
    xr.Dataset(data, coords={"dof": ["Heave", "Pitch"]}).to_netcdf(path)
    return path


def hull(above):
    """A box 6 x 4 m with a draught of 2 m, walls that go on `above` the water, and a deck."""
    vertices, faces = box(6.0, 4.0, 2.0, 2)
    top = vertices[:, 2] == 0.0
    vertices[:, 2] = np.where(top, above, vertices[:, 2])
    corners = np.array([[-3.0, -2, above], [3, -2, above], [3, 2, above], [-3, 2, above]])
    return np.vstack([vertices, corners]), np.vstack([faces, len(vertices) + np.arange(4)])


@pytest.mark.parametrize("dims", ["vertex", "panel"])
@pytest.mark.parametrize("above", [0.7, 0.0])
def test_what_lies_above_the_water_is_cut_off_and_displacements_go_with_it(tmp_path, dims, above):
    """Rigid motions stay rigid, of panels cut too: their centres move."""
    vertices, faces = hull(above)
    shapes = rigid(vertices)[[2, 4]]
    modes = shapes if dims == "vertex" else at_centres(vertices, faces, shapes)
    path = written(tmp_path / "a.nc", vertices, faces, modes, dims)
    body = read_body(path, path)
    assert body.volumes == pytest.approx([48.0] * 3, rel=1e-9)
    expected = rigid(body.centres)[[2, 4]]
    assert np.abs(body.modes - expected).max() < 1e-9
    cut = np.count_nonzero((vertices[faces][..., 2] > 0).any(axis=1)) - 1 if above else 0
    assert (
        body.history
        == f"clipped at z = 0: {cut} of {len(faces)} panels cut, 1 above the water or in its surface left out"
    )


def test_a_body_above_the_water_is_refused(tmp_path):
    vertices, faces = hull(0.5)
    path = written(tmp_path / "a.nc", vertices + np.array([0.0, 0.0, 9.0]), faces, rigid(vertices)[[2, 4]], "vertex")
    with pytest.raises(ConfigError, match=r"mesh: none of .* panels lies below z = 0; needs the water's surface at z"):
        read_body(path, path)
