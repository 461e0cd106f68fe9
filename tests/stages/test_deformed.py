"""Rule deformed: meshes of the shell at rest and deformed, of all three kinds of shapes."""

import numpy as np
import pytest
from conftest import SEED, shipped, varied

from vsb.scenes.rest import reference_shell, study_basis
from vsb.stages import deformed
from vsb.study.plan import StudyPlan
from vsb.study.specs import LoadedShape, Shapes, Sphere
from vsb.study.study import content_id, load
from vsb.tools import files

KINDS = {
    "rigid": (Sphere, "seed", {"designs": {"FSB": {"flexible": False}}}),
    "shell": (Shapes, "seed", {"modes": {"degree": 2}}),
    "loaded": (LoadedShape, "pressurised", {"modes": {"degree": 2}}),
}


@pytest.fixture(params=KINDS)
def case(request):
    kind, name, changes = KINDS[request.param]
    study = varied(load(shipped(name)), **changes)
    return kind, study, StudyPlan(study).witness.meshes


def test_shapes_are_the_one_at_rest_and_each_mode_to_either_side(case):
    kind, study, spec = case
    assert type(spec.shape) is kind
    rest, *moved = deformed.shapes(spec)
    assert [shape.name for shape in moved] == [f"{m}_{side}" for m in spec.deformed for side in ("minus", "plus")]
    assert rest.name == "mean"
    keel = -rest.shell.meridian(np.array([np.pi])).z[0]
    assert keel == pytest.approx(reference_shell(study).keel_depth, rel=1e-12)
    for shape in moved:
        left = (shape.shell.modal_amplitude - rest.shell.modal_amplitude).tolist()
        assert left.count(0.0) == len(left) - 1
        assert sum(left) == pytest.approx(shape.amplitude)


def test_only_modes_that_deform_are_compared(case):
    _, _, spec = case
    rest = deformed.shapes(spec)[0]
    assert deformed.compared_basis(spec, rest.shell.basis).labels == ("Heave", *spec.deformed)


def test_every_mesh_is_stored_by_name_with_what_deforms_it(tmp_path):
    study = varied(load(SEED), modes={"degree": 0})
    spec = StudyPlan(study).witness.meshes
    deformed.run(spec, str(tmp_path))
    assert {path.name for path in tmp_path.iterdir()} == {"mean.nc", "Membrane0_minus.nc", "Membrane0_plus.nc"}
    minus = files.load(tmp_path / "Membrane0_minus.nc", expected=content_id(spec))
    assert (minus.attrs["deformed_by"], minus.attrs["amplitude"]) == ("Membrane0", pytest.approx(-0.1))
    shape = deformed.shapes(spec)[1]
    coarse = deformed.shape_mesh(spec, shape, coarser=2)
    assert sum(v.size for v in coarse.data_vars.values()) < 0.7 * sum(v.size for v in minus.data_vars.values())


@pytest.mark.parametrize("basis", ["membrane", "full", "paper"])
def test_the_shapes_are_those_of_the_studys_own_shell(basis):
    """Of a unit modulus and density, which shapes do not know; of its radius, thickness, Poisson's ratio and height."""
    device = {"thickness": 0.15, "poisson_ratio": 0.2, "mass": 25e3}
    study = varied(load(SEED), modes={"basis": basis, "degree": 3}, device=device)
    spec = StudyPlan(study).witness.meshes
    rest, own = deformed.shapes(spec)[0].shell, study_basis(study)
    modes = {mode.label: np.array(mode.parts) for mode in own.modes}
    assert {mode.label for mode in rest.basis.modes} == set(spec.deformed)
    for mode in rest.basis.modes:
        np.testing.assert_allclose(mode.parts, modes[mode.label], rtol=1e-9, atol=1e-12)
    assert rest.centre_height == study.centre_height != 0.0


@pytest.mark.parametrize("coarser", [1, 2, 3])
def test_a_coarser_mesh_has_a_fraction_of_all_its_panels_on_the_same_shape(coarser):
    spec = StudyPlan(varied(load(SEED), modes={"degree": 0})).witness.meshes
    spec = spec.model_copy(update={"rows": 13, "azimuth": 25, "lid_rows": 7})
    rest, minus, plus = deformed.shapes(spec)
    for shape in (rest, minus, plus):
        ds = deformed.shape_mesh(spec, shape, coarser)
        found = (ds.sizes["row"], ds.attrs["azimuth"], ds.sizes["lid_node"] - 1)
        assert found == (13 // coarser, 25 // coarser, 7 // coarser)
        assert ds.meridian_height.values[-1] == pytest.approx(shape.shell.meridian(np.array([np.pi])).z[0])
    assert deformed.shape_mesh(spec, rest).identical(deformed.shape_mesh(spec, rest, 1))


def test_a_folder_of_meshes_has_all_shapes_each_as_it_is(tmp_path):
    """With the id of its specification, whatever their number."""
    spec = StudyPlan(varied(load(SEED), modes={"degree": 0})).witness.meshes
    spec = spec.model_copy(update={"rows": 6, "azimuth": 12, "lid_rows": 3})
    deformed.run(spec, str(tmp_path))
    for shape in deformed.shapes(spec):
        stored = files.load(tmp_path / f"{shape.name}.nc", expected=content_id(spec))
        assert (stored.attrs["deformed_by"], stored.attrs["amplitude"]) == (shape.mode, shape.amplitude)
        for name, values in deformed.shape_mesh(spec, shape).data_vars.items():
            np.testing.assert_array_equal(stored[name].values, values.values)


def test_modes_that_deform_may_be_told_in_any_order():
    """All there are, those of the lowest degree last as well as first."""
    spec = StudyPlan(varied(load(SEED), modes={"basis": "full", "degree": 3})).witness.meshes
    turned = spec.model_copy(update={"deformed": spec.deformed[::-1]})
    rest = deformed.shapes(spec)[0].shell
    (same, *moved) = deformed.shapes(turned)
    assert same.shell.basis.labels == rest.basis.labels == ("Heave", *spec.deformed)
    assert [shape.mode for shape in moved[::2]] == [*turned.deformed]
