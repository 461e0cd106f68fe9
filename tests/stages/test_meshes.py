"""Stages mesh, deformed and display: meshes of the mean shape, of deformed shapes, and shapes to look at."""

import json

import meshio
import numpy as np
import pytest
from conftest import shipped, varied

from vsb.engine.hydro.panels import mesh as meshing
from vsb.models.rest import reference_shell
from vsb.pipeline.graph import StudyPlan
from vsb.stages import panels, shell
from vsb.study.specs import SphereMesh
from vsb.study.study import load


@pytest.fixture(scope="module", params=["seed", "pressurised"])
def spec(request):
    study = varied(load(shipped(request.param)), hydro={"rows": 20, "omega_max": 6.0})
    return StudyPlan(study).mesh(6.0)


def test_mean_mesh_is_that_of_the_sphere_or_of_the_loaded_shell(spec):
    ds = panels.mean_mesh(spec, 2)
    if isinstance(spec, SphereMesh):
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


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("seed", {"designs": {"FSB": {"flexible": False}}}),
        ("seed", {"modes": {"degree": 2}}),
        ("pressurised", {"modes": {"degree": 2}}),
    ],
    ids=["rigid", "shell", "loaded"],
)
def test_deformed_shapes_are_the_rest_shape_and_each_mode_to_either_side(name, changes):
    study = varied(load(shipped(name)), **changes)
    spec = StudyPlan(study).deformed.spec
    rest, *moved = panels.shapes(spec)
    assert [shape.name for shape in moved] == [f"{m}_{side}" for m in spec.deformed for side in ("minus", "plus")]
    keel = -rest.shell.meridian(np.array([np.pi])).z[0]
    assert keel == pytest.approx(reference_shell(study).keel_depth, rel=1e-12)
    for shape in moved:
        difference = (shape.shell.modal_amplitude - rest.shell.modal_amplitude).tolist()
        assert difference.count(0.0) == len(difference) - 1
        assert sum(difference) == pytest.approx(shape.amplitude)


def test_viewable_shapes_are_written_and_stamped(seed, tmp_path):
    plan = StudyPlan(varied(seed, modes={"degree": 1}))
    shell.run_display(plan.display.spec, str(tmp_path / "shapes"), str(tmp_path / "manifest.json"))
    names = {path.rsplit("/")[-1] for path in plan.display.makes}
    assert {path.name for path in (tmp_path / "shapes").iterdir()} == names
    stamps = json.loads((tmp_path / "manifest.json").read_text())
    assert {entry["spec_id"] for entry in stamps.values()} == {plan.display.id}
    assert sorted(path.rpartition("/")[2] for path in stamps) == sorted(names)
    for name, least, most in (("mean", -1e-6, 1e-6), ("Membrane0_plus", 0.05, 1.0), ("Membrane0_minus", -1.0, -0.05)):
        points = meshio.read(tmp_path / "shapes" / f"{name}.vtu").points - [0.0, 0.0, seed.centre_height]
        beyond = np.linalg.norm(points, axis=1) - seed.device.radius
        assert np.ptp(beyond) < 2e-6  # breathing: a sphere of another radius
        assert least < beyond[0] < most
