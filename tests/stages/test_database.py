"""Rule database: its blocks and no others, in the modes, with a verdict."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from study.test_shape import OBLATE, raw

from vsb.errors import DatabaseError
from vsb.hydro.database import load_database
from vsb.stages import database
from vsb.stages.make import make
from vsb.study.plan import StudyPlan
from vsb.study.specs import DatabaseSpec
from vsb.study.study import content_id, parse
from vsb.tools.files import load, save


def test_a_database_made_again_is_the_same(small, tmp_path):
    out = tmp_path / "db" / Path(small.database_path).name
    database.run(small.database, small.block_folder, str(out))
    again = load_database(out, content_id(small.database))
    assert again.identical(load_database(small.database_path, content_id(small.database)))
    assert again.attrs["solver"] == "spectral"
    assert (again.attrs["basis"], again.attrs["degree"]) == ("membrane", 2)
    assert float(again.omega[-1]) == small.database.omega_max
    assert {check["verdict"] for check in json.loads(again.attrs["quality"])} <= {"ok", "doubt"}
    stiffness = again.hydrostatic_stiffness.values
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-6 * np.abs(stiffness).max())


def test_a_block_that_is_missing_or_another_is_refused(small, tmp_path):
    (name,) = small.database.sweep
    with pytest.raises(DatabaseError, match=rf"{name}.nc: file not found"):
        database.run(small.database, str(tmp_path), str(tmp_path / "out.nc"))
    save(load(f"{small.block_folder}/{name}.nc").assign_attrs(spec_id="0" * 16), tmp_path / f"{name}.nc")
    with pytest.raises(DatabaseError, match=rf"{name}.nc: holds block 0+, needs {name}; delete it and run again"):
        database.run(small.database, str(tmp_path), str(tmp_path / "out.nc"))
    assert not (tmp_path / "out.nc").exists()


def test_a_check_that_fails_stops_it_unless_it_is_accepted(small, tmp_path):
    """Damping of the wrong size satisfies Haskind's relation no more."""
    (name,) = small.database.sweep
    shutil.copy(f"{small.block_folder}/{name}.nc", tmp_path)
    block = load(tmp_path / f"{name}.nc")
    save(block.assign(radiation_damping=1.3 * block.radiation_damping), tmp_path / f"{name}.nc")
    out = str(tmp_path / "db" / "out.nc")
    with pytest.raises(DatabaseError, match=r"hydro database: check '\w+' failed: .*list the name under hydro.accept"):
        database.run(small.database, str(tmp_path), out)
    assert not Path(out).exists()
    spec = DatabaseSpec(**{**small.database.model_dump(), "accept": ("haskind", "kramers_kronig")})
    database.run(spec, str(tmp_path), out)
    assert "accepted" in load(out).attrs["quality"]


def test_a_rigid_buoy_is_told_to_be_of_degree_one(seed, tmp_path):
    """Its only degree of freedom is heave, a displacement of degree one: `INDEX.tsv` says so."""
    study = varied(seed, designs={"FSB": {"flexible": False}}, modes={"degree": 0}, hydro={
        "omega_max": 3.0, "tolerance": 0.01, "witness": "none"}, reference_shape="undeformed")  # fmt: skip
    plan = StudyPlan(study, root=str(tmp_path))
    make(plan, [plan.database_path])
    found = load_database(plan.database_path, content_id(plan.database))
    assert plan.database.modes is None
    assert (found.attrs["basis"], found.attrs["degree"]) == ("rigid", 1)


@pytest.mark.parametrize("mass", [9e3, 15e3, 22e3])
def test_other_codes_are_told_where_the_water_holds_a_spheroid(mass):
    """Of semi-axes 2 and 1.5 m: a sphere's cap, squeezed; volume and moment of its slices."""
    spec = StudyPlan(parse(raw(OBLATE, device={"mass": mass}))).database
    told, height = database._at_rest(spec), spec.centre_height
    z = np.linspace(-1.5, -height, 20_001)  # of the spheroid's own
    slices = np.pi * 4.0 * (1 - (z / 1.5) ** 2)
    volume = np.trapezoid(slices, z)
    assert volume * 1025 == pytest.approx(mass, rel=1e-6)
    assert told["displaced_volume"] == pytest.approx(volume, rel=1e-6)
    assert told["centre_of_buoyancy"] == pytest.approx(
        [0.0, 0.0, height + np.trapezoid(slices * z, z) / volume], rel=1e-6
    )
    assert told["centre_of_mass"] == [0.0, 0.0, height]


@pytest.mark.parametrize("order", [None, 1, 2])
def test_coefficients_are_judged_by_the_relations_of_their_own_order(small, monkeypatch, order):
    """Swept and tabulated alike; pitch about a sphere's centre moves no water, and is not asked."""
    labels, asked = ["Surge", "Pitch", "Bend"], []
    pair = dict.fromkeys(("influenced_dof", "radiating_dof"), labels)
    values = xr.DataArray(np.ones((3, 3)), pair, tuple(pair))
    monkeypatch.setattr(database.quality, "verdict", lambda *given: asked.append(given))
    basis = SimpleNamespace(order=order) if order else None
    part = database._Part(small.database, None, {}, basis)
    for tabulated in (None, values.to_dataset(name="added_mass_inf")):
        part.verdict(values.to_dataset(name="added_mass_zero"), tabulated, 0.3)
    for (swept, other, *told), name in zip(asked, (None, "added_mass_inf"), strict=True):
        assert told == [small.study.water, 0.3, order or 0]
        assert swept.added_mass_zero.shape == (2, 2)
        assert list(swept.influenced_dof.values) == list(swept.radiating_dof.values) == ["Surge", "Bend"]
        assert other is None if name is None else other[name].shape == (2, 2)
