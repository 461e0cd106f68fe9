"""Databases imported from files of other codes, and the shapes at rest given for them."""

import json

import pytest
from shell.test_device import raw

from tests.hydro.formats.test_checks import sound
from vsb.engine.hydro.formats.bemio import bemio_entries, write_h5
from vsb.engine.hydro.formats.wamit import wamit_texts
from vsb.pipeline.graph import StudyPlan
from vsb.stages.coefficients import import_bemio, import_wamit
from vsb.stages.water import _at_rest
from vsb.study.study import parse
from vsb.tools.files import load

WATER = {"density": 1000.0, "gravity": 9.81, "length": 1.0, "depth": float("inf")}


def test_wamit_and_bemio_files_are_imported_with_a_verdict(tmp_path):
    centres = {"centre_of_buoyancy": [0.0, 0.0, -2.0], "centre_of_mass": [0.0, 0.0, -3.0]}
    centres["rotation_centre"] = centres["centre_of_mass"]
    ds = sound(("Surge", "Heave", "Pitch")).assign_attrs(centres)
    for extension, text in wamit_texts(ds, "memory").items():
        (tmp_path / f"buoy{extension}").write_text(text)
    write_h5(bemio_entries(ds, "memory"), tmp_path / "buoy.h5")
    checks, notes, causes = import_wamit(str(tmp_path), "buoy", str(tmp_path / "a.nc"), axisymmetric=False, **WATER)
    again, _, _ = import_bemio(str(tmp_path / "buoy.h5"), str(tmp_path / "b.nc"), axisymmetric=False)
    assert {check.name for check in again} >= {check.name for check in checks} >= {"symmetry", "haskind"}
    assert {check.verdict for check in checks} == {"ok"}
    assert causes == []
    for name in ("a", "b"):
        stored = load(tmp_path / f"{name}.nc")
        assert stored.attrs["spec_id"] == name
        assert {check["verdict"] for check in json.loads(stored.attrs["quality"])} == {"ok"}
    assert load(tmp_path / "a.nc").attrs["history"] == "; ".join(notes)


def test_centres_of_a_spheroid_that_floats_high():
    """Stretched from the cap of a sphere of 2 m, whose centroid lies 3 (2 r - h)^2/4 (3 r - h) below the centre."""
    study = parse(raw({"spheroid": {"height": 3.0}}, device={"mass": 9e3, "centre_of_mass": -0.4}))
    found, height, h = _at_rest(StudyPlan(study).database.spec), study.centre_height, study.draft / 0.75
    assert found["displaced_volume"] == pytest.approx(9e3 / 1025.0, rel=1e-9)
    assert found["centre_of_buoyancy"][2] == pytest.approx(height - 0.75 * 3 * (4 - h) ** 2 / (4 * (6 - h)), rel=1e-9)
    assert found["centre_of_mass"] == pytest.approx([0.0, 0.0, height - 0.4])
    assert height > 0.2
