"""Rule panels: a block by panels, on the mesh of its specification and no other."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import DatabaseError
from vsb.stages import mesh, panels
from vsb.stages.stage import stamp
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id
from vsb.tools.files import load


def plan_of(study, rows):
    return StudyPlan(varied(study, hydro={"rows": rows, "omega": [1.0, 2.0], "omega_max": 3.0}, modes={"degree": 1}))


def test_a_block_holds_its_frequencies_its_id_and_its_seconds(seed, green_folder, tmp_path):
    (spec,) = plan_of(seed, 12).tabulated_blocks
    mesh.run(spec.mesh, str(tmp_path / "mean.nc"))
    panels.run(spec, str(tmp_path / "mean.nc"), str(green_folder), str(tmp_path / "block.nc"))
    ds = load(tmp_path / "block.nc", expected=content_id(spec))
    assert ds.omega.values.tolist() == [1.0, 2.0]
    assert np.linalg.eigvalsh(ds.radiation_damping.values + ds.radiation_damping.values.transpose(0, 2, 1)).min() > -1.0
    assert ds.attrs["error_estimate"] > 0
    assert ds.attrs["seconds"] > 0


def test_a_mesh_of_another_specification_is_refused(seed, tmp_path):
    (spec,), (other,) = plan_of(seed, 12).tabulated_blocks, plan_of(seed, 14).tabulated_blocks
    mesh.run(other.mesh, str(tmp_path / "mean.nc"))
    with pytest.raises(DatabaseError, match=f"mean.nc: holds '{content_id(other.mesh)}', needs"):
        panels.run(spec, str(tmp_path / "mean.nc"), "none", str(tmp_path / "block.nc"))
    assert not (tmp_path / "block.nc").exists()


def test_a_block_is_solved_on_its_mesh_and_on_one_of_half_the_panels_with_its_own_table(seed, monkeypatch):
    (spec,) = plan_of(seed, 13).tabulated_blocks
    asked, saved = [], []
    monkeypatch.setattr(panels, "load", lambda path, expected: asked.append((path, expected)) or "read")
    monkeypatch.setattr(panels, "solve_block", lambda *given: asked.append(given) or xr.Dataset(attrs={"solves": 2}))
    monkeypatch.setattr(panels, "save", lambda *given: saved.append(given))
    panels.run(spec, "mesh.nc", "table", "out.nc")
    (loaded, (own, fine, coarse, green)), ((ds, out),) = asked, saved
    assert loaded == ("mesh.nc", content_id(spec.mesh))
    assert (own, fine, green, out) == (spec, "read", "table", "out.nc")
    assert coarse.identical(mesh.mean_mesh(spec.mesh, coarser=2))
    assert {name: value for name, value in ds.attrs.items() if name != "seconds"} == {"solves": 2, **stamp(spec)}
    assert 0 <= ds.attrs["seconds"] < 60
