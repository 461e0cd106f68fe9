"""Which reader a climate's file gets, and that it is the one planned with."""

import gzip
import hashlib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from vsb.errors import ConfigError
from vsb.stages.climate import read_climate
from vsb.study.specs import ClimateSpec

CLIMATES = Path(__file__).parents[2] / "config" / "climate"
BUOY = CLIMATES / "ndbc46042_1996_spectra.txt.gz"
TABLE = CLIMATES / "PacWave-South_Oregon_Wave-Resource.csv"


def spec(path, form, gamma=None):
    """What is planned with a file."""
    return ClimateSpec(form=form, gamma=gamma, contents=hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16])


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Two days of the buoy, unpacked."""
    path = tmp_path_factory.mktemp("climate") / "short.txt"
    path.write_text("".join(gzip.decompress(BUOY.read_bytes()).decode().splitlines(keepends=True)[:49]))
    return path


def test_text_of_a_buoy(short):
    climate = read_climate(spec(short, "spectra"), str(short))
    assert len(climate.hs) == 48 - sum("999" in line for line in short.read_text().splitlines()[1:])
    assert climate.hours.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("form", ["NETCDF3_CLASSIC", "NETCDF4"])
def test_spectra_in_netcdf_are_known_by_how_the_file_begins(tmp_path, form):
    """Whatever it is called: a triangle of 2 or 8 m^2/Hz from 0.1 to 0.2 Hz has an area of 0.1 or 0.4 m^2."""
    path, hertz = tmp_path / "seas.txt", np.linspace(0.1, 0.2, 21)
    density = np.outer([2.0, 8.0], 1 - np.abs(np.linspace(-1, 1, 21)))
    times = np.array(["1996-01-01T00", "1996-01-01T01"], "datetime64[ns]")
    ds = xr.Dataset({"efth": (("time", "freq"), density, {"units": "m2/Hz"})}, {"time": times, "freq": hertz})
    ds.to_netcdf(path, engine="netcdf4", format=form)
    climate = read_climate(spec(path, "spectra"), str(path))
    assert sorted(climate.hs) == pytest.approx([4 * np.sqrt(0.1), 4 * np.sqrt(0.4)])


def test_a_table_is_of_the_form_planned():
    """The peak of JONSWAP seas is 3.3 times higher, nearly; heights are the table's own."""
    sharp, broad = (read_climate(spec(TABLE, form, 3.3), str(TABLE)) for form in ("jonswap", "pierson_moskowitz"))
    assert sharp.hs == pytest.approx(broad.hs)
    assert (sharp.density.max(axis=1) > 1.5 * broad.density.max(axis=1)).all()


def test_a_file_that_changed_is_refused(short, tmp_path):
    planned, other = spec(short, "spectra"), tmp_path / "other.txt"
    other.write_text(short.read_text() + "\n")
    with pytest.raises(ConfigError, match=r"other.txt: changed since the run was planned; run vsb run CONFIG again"):
        read_climate(planned, str(other))
    with pytest.raises(ConfigError, match=r"nowhere.txt: cannot be read .*; needs the climate of the campaign"):
        read_climate(planned, str(tmp_path / "nowhere.txt"))


@pytest.mark.parametrize(("form", "gamma", "told"), [
    ("jonswap", 2.0, "JONSWAP spectra, gamma 2"), ("jonswap", 5.5, "JONSWAP spectra, gamma 5.5"),
    ("pierson_moskowitz", None, "Pierson-Moskowitz spectra"),
])  # fmt: skip
def test_a_table_is_of_the_peakedness_planned(form, gamma, told):
    assert read_climate(spec(TABLE, form, gamma), str(TABLE)).notes[-1] == told


def test_a_file_is_the_one_planned_to_the_last_digit(short):
    planned = spec(short, "spectra")
    for at in (0, 7, 8, 15):
        other = planned.contents[:at] + "fe"[planned.contents[at] == "f"] + planned.contents[at + 1 :]
        with pytest.raises(ConfigError, match="changed since the run was planned"):
            read_climate(planned.model_copy(update={"contents": other}), str(short))


def test_a_file_that_is_not_there_is_told_with_the_reason(short, tmp_path):
    told = r"^.*nowhere\.txt: cannot be read \(No such file or directory\); needs the climate of the campaign$"
    with pytest.raises(ConfigError, match=told):
        read_climate(spec(short, "spectra"), str(tmp_path / "nowhere.txt"))
