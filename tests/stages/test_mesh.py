"""Rule mesh: the mean wetted mesh, of a sphere or of a loaded shell."""

import numpy as np
import pytest
from conftest import shipped, varied

from vsb.hydro.panels import mesh as meshing
from vsb.scenes.rest import reference_shell
from vsb.stages import mesh
from vsb.study.plan import StudyPlan
from vsb.study.specs import SphereMesh
from vsb.study.study import content_id, load
from vsb.tools import files


@pytest.fixture(scope="module", params=["seed", "pressurised"])
def spec(request):
    study = varied(load(shipped(request.param)), hydro={"rows": 20, "omega_max": 6.0})
    return StudyPlan(study).mesh(6.0)


@pytest.mark.parametrize("coarser", [1, 2, 3])
def test_a_mesh_has_the_rows_asked_for_or_a_fraction_of_them(spec, coarser):
    ds = mesh.mean_mesh(spec, coarser)
    found = (ds.sizes["row"], ds.attrs["azimuth"], ds.sizes["lid_node"] - 1)
    assert found == tuple(-(-n // coarser) for n in (spec.rows, spec.azimuth, spec.lid_rows))


def test_it_runs_from_the_waterline_to_the_keel_and_is_covered_by_its_lid(spec):
    ds = mesh.mean_mesh(spec)
    assert ds.identical(mesh.mean_mesh(spec, 1))
    assert ds.meridian_height.values[0] == pytest.approx(0.0, abs=1e-9)
    assert (ds.meridian_radius.values[-1], ds.lid_radius.values[0]) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert ds.lid_radius.values[-1] == pytest.approx(ds.meridian_radius.values[0], rel=1e-3)
    assert np.all(np.diff(ds.meridian_height.values) < 0)


def test_a_mesh_carries_the_id_of_its_specification(spec, tmp_path):
    mesh.run(spec, str(tmp_path / "mean.nc"))
    stored = files.load(tmp_path / "mean.nc", expected=content_id(spec))
    for name, values in mesh.mean_mesh(spec).data_vars.items():
        np.testing.assert_array_equal(stored[name].values, values.values)


def test_a_mesh_is_of_the_shape_its_specification_says(spec):
    """Of a sphere at its height, or of the shell that its load deforms."""
    ds = mesh.mean_mesh(spec, 2)
    if isinstance(spec, SphereMesh):
        assert spec.centre_height != 0.0
        rows, azimuth, lid = (-(-n // 2) for n in (spec.rows, spec.azimuth, spec.lid_rows))
        assert ds.identical(meshing.mean_mesh(spec.radius, spec.centre_height, rows, azimuth, lid))
        return
    shape = reference_shell(spec).shape
    at = shape.meridian(ds.row_colatitude.values)
    length = np.hypot(at.dx, at.dz)
    np.testing.assert_allclose(ds.normal_radius.values, -at.dz / length, atol=1e-9)
    np.testing.assert_allclose(ds.normal_height.values, at.dx / length, atol=1e-9)
    keel = shape.meridian(np.array([np.pi])).z[0]
    assert ds.meridian_height.values[-1] == pytest.approx(keel)
    assert abs(keel - (spec.centre_height - spec.radius)) > 1e-3
