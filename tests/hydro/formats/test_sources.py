"""Any database from any file."""

import pytest
import xarray as xr
from hydro.formats.test_capytaine import dataset

from vsb.errors import DatabaseError
from vsb.hydro.database import load_database
from vsb.hydro.formats import sources
from vsb.hydro.formats.exchange import export
from vsb.hydro.formats.sources import is_own, read_source, source_checks
from vsb.study.sections import Water


def test_a_buoy_comes_back_from_every_form(small, tmp_path):
    own = load_database(small.database_path, small.database_path.split("/")[-1].removesuffix(".nc"))
    export(small.database_path, tmp_path, "buoy")
    water = small.study.water
    found = {
        "database": read_source("database", small.database_path, water),
        "wamit": read_source("wamit", str(tmp_path / "buoy"), water),
        "bemio": read_source("bemio", str(tmp_path / "buoy.h5"), water),
    }
    for kind, ds in found.items():
        assert ds.added_mass.values == pytest.approx(own.added_mass.values, rel=1e-5, abs=1e-2), kind
        checks, unseen = source_checks(ds)
        assert all(check.verdict != "fail" for check in checks), kind
        assert bool(unseen) == (kind != "database")


def test_whose_a_netcdf_file_is(small, tmp_path):
    assert is_own(small.database_path)
    dataset().to_netcdf(tmp_path / "theirs.nc")
    assert not is_own(str(tmp_path / "theirs.nc"))
    assert read_source("database", str(tmp_path / "theirs.nc"), Water()).attrs["source"] == "capytaine"
    with pytest.raises(DatabaseError, match="cannot be read"):
        is_own(str(tmp_path / "nothing.nc"))


@pytest.mark.parametrize("length", [1.0, 2.5])
def test_what_wamits_files_do_not_say_is_of_the_study(monkeypatch, length):
    seen = []
    monkeypatch.setattr(sources, "import_wamit", lambda *place, **facts: seen.append((*map(str, place), facts)))
    read_source("wamit", "runs/rm3", Water(density=1010.0, gravity=9.7, depth=33.0), length)
    facts = {"density": 1010.0, "gravity": 9.7, "depth": 33.0, "length": length, "labels": None}
    read_source("wamit", "runs/old/rm3.v2", Water(density=1010.0, gravity=9.7, depth=33.0), length)  # no ending
    assert seen == [("runs", "rm3", facts), ("runs/old", "rm3.v2", facts)]


def test_each_kind_of_file_is_read_as_such(tmp_path, monkeypatch):
    """A netCDF file is this project's if it says so, else capytaine's."""
    for name in ("read_bemio", "open_database", "read_capytaine"):
        monkeypatch.setattr(sources, name, lambda path, name=name: (name, path))
    own, theirs = str(tmp_path / "own.nc"), str(tmp_path / "theirs.nc")
    xr.Dataset(attrs={"separate_sweep": 0}).to_netcdf(own)
    xr.Dataset(attrs={"spec_id": "a"}).to_netcdf(theirs)
    assert (is_own(own), is_own(theirs)) == (True, False)
    assert read_source("database", own, Water()) == ("open_database", own)
    assert read_source("database", theirs, Water()) == ("read_capytaine", theirs)
    assert read_source("bemio", "a/b.h5", Water(), 2.0) == ("read_bemio", "a/b.h5")


def test_a_file_that_is_none_is_refused_with_what_is_needed(tmp_path):
    (tmp_path / "text.nc").write_text("no netCDF")
    for name in ("text.nc", "gone.nc"):
        with pytest.raises(DatabaseError, match=rf"{name}: cannot be read: .*; needs a hydro database as netCDF\.$"):
            read_source("database", str(tmp_path / name), Water())
