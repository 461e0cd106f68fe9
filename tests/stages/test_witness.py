"""Rule witness: on the meshes of its specification, by both solvers."""

import pytest
from conftest import varied

from vsb.errors import DatabaseError
from vsb.stages import deformed, witness
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id
from vsb.tools.files import load, save


@pytest.fixture(scope="module")
def spec(seed):
    """A rigid sphere on few rows."""
    found = StudyPlan(varied(seed, designs={"FSB": {"flexible": False}})).witness
    meshes = found.meshes.model_copy(update={"rows": 16, "azimuth": 32})
    return found.model_copy(update={"meshes": meshes})


def test_both_solvers_are_asked_and_agree_within_what_they_say(spec, green_folder, tmp_path):
    deformed.run(spec.meshes, str(tmp_path / "meshes"))
    witness.run(spec, str(tmp_path / "meshes"), str(green_folder), str(tmp_path / "witness.nc"))
    ds = load(tmp_path / "witness.nc", expected=content_id(spec))
    assert tuple(ds.omega.values) == spec.omega
    assert (ds.attrs["rows"], ds.attrs["panels"]) == (16, spec.solver)
    assert (ds.witness_difference <= ds.witness_estimate.sum("solver")).all()
    assert float(ds.witness_difference.max()) < 0.02


def test_meshes_of_another_specification_are_refused(spec, tmp_path):
    deformed.run(spec.meshes, str(tmp_path))
    save(load(tmp_path / "mean.nc").assign_attrs(spec_id="0" * 16), tmp_path / "mean.nc")
    with pytest.raises(DatabaseError, match=r"mean.nc: holds '0+', needs '\w+': stale or foreign"):
        witness.run(spec, str(tmp_path), "none", str(tmp_path / "witness.nc"))
    assert not (tmp_path / "witness.nc").exists()
