"""Rule witness: on the meshes of its specification, by both solvers."""

from pathlib import Path

import pytest
import xarray as xr
from conftest import varied

from vsb.errors import DatabaseError
from vsb.hydro.witness import Waves
from vsb.stages import deformed, witness
from vsb.stages.stage import stamp
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


def test_every_shape_is_asked_on_its_own_mesh_and_one_of_half_its_rows_in_the_water_of_the_study(seed, monkeypatch):
    """Of all shapes, in their order, by both solvers in the same motions; what is told is of both."""
    spec = StudyPlan(varied(seed, modes={"degree": 0})).witness
    spec = spec.model_copy(update={"water": spec.water.model_copy(update={"density": 1010.0, "gravity": 9.7})})
    asked, saved = {}, []

    def records(name, found):
        def call(*given):
            asked.setdefault(name, []).append(given)
            return found(len(asked[name])) if callable(found) else found

        monkeypatch.setattr(witness, name, call)

    records("witness_runs", lambda n: f"panels {n}")
    records("spectral_runs", lambda n: f"spectral {n}")
    records("compared", xr.Dataset({"both": 1.0}))
    records("derivatives", xr.Dataset({"slopes": 2.0}))
    monkeypatch.setattr(witness, "load", lambda path, expected: asked.setdefault("load", []).append(
        (path, expected)) or f"mesh {path.stem}")  # fmt: skip
    monkeypatch.setattr(witness, "save", lambda *given: saved.append(given))
    witness.run(spec, "meshes", "table", "out.nc")

    names = ["mean", "Membrane0_minus", "Membrane0_plus"]
    assert asked["load"] == [(Path("meshes") / f"{name}.nc", content_id(spec.meshes)) for name in names]
    waves = Waves(spec.omega, 1010.0, spec.water.depth, 9.7)
    assert len(asked["witness_runs"]) == len(asked["spectral_runs"]) == 3
    found = deformed.shapes(spec.meshes)
    for name, shape, by_panels, by_spectral in zip(
        names, found, asked["witness_runs"], asked["spectral_runs"], strict=True
    ):
        green, (mesh, coarse), basis, water = by_panels
        assert (green, mesh, water) == ("table", f"mesh {name}", waves)
        assert coarse.identical(deformed.shape_mesh(spec.meshes, shape, coarser=2))
        shell, motions, own = by_spectral
        assert shell.modal_amplitude.tolist() == shape.shell.modal_amplitude.tolist()
        assert own == waves
        assert basis.labels == motions.labels == ("Heave", "Membrane0")
    ((shapes, panels, spectral, water),) = asked["compared"]
    assert [shape.name for shape in shapes] == names
    assert panels == [f"panels {n}" for n in (1, 2, 3)]
    assert (spectral, water) == ([f"spectral {n}" for n in (1, 2, 3)], waves)
    ((shapes, panels, basis, water),) = asked["derivatives"]
    assert ([shape.name for shape in shapes], panels) == (names, [f"panels {n}" for n in (1, 2, 3)])
    assert (basis.labels, water) == (("Heave", "Membrane0"), waves)
    ((ds, out),) = saved
    assert (out, float(ds.both), float(ds.slopes)) == ("out.nc", 1.0, 2.0)
    assert ds.attrs == {
        "title": "two solvers on the mean and on deformed shapes",
        "panels": spec.solver,
        "rows": spec.meshes.rows,
        **stamp(spec),
    }
