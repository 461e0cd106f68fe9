"""The climate file of a campaign: recognised by its content, and the one that was planned with."""

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


def spec(path, form, gamma=None):
    """The specification of a climate file."""
    return ClimateSpec(form=form, gamma=gamma, contents=hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16])


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Two days of the buoy, unpacked."""
    path = tmp_path_factory.mktemp("climate") / "short.txt"
    path.write_text("".join(gzip.decompress(BUOY.read_bytes()).decode().splitlines(keepends=True)[:49]))
    return path


@pytest.mark.parametrize("form", ["NETCDF3_CLASSIC", "NETCDF4"])
def test_netcdf_spectra_are_recognised_by_content(tmp_path, form):
    """Triangles of 2 and 8 m^2/Hz from 0.1 to 0.2 Hz have areas of 0.1 and 0.4 m^2."""
    path, hertz = tmp_path / "seas.txt", np.linspace(0.1, 0.2, 21)
    density = np.outer([2.0, 8.0], 1 - np.abs(np.linspace(-1, 1, 21)))
    times = np.array(["1996-01-01T00", "1996-01-01T01"], "datetime64[ns]")
    ds = xr.Dataset({"efth": (("time", "freq"), density, {"units": "m2/Hz"})}, {"time": times, "freq": hertz})
    ds.to_netcdf(path, engine="netcdf4", format=form)
    climate = read_climate(spec(path, "spectra"), str(path))
    assert sorted(climate.hs) == pytest.approx([4 * np.sqrt(0.1), 4 * np.sqrt(0.4)])


def test_changed_or_missing_climate_file_is_refused(short, tmp_path):
    planned, other = spec(short, "spectra"), tmp_path / "other.txt"
    other.write_text(short.read_text() + "\n")
    with pytest.raises(ConfigError, match=r"other.txt: changed since the run was planned; run vsb run CONFIG again"):
        read_climate(planned, str(other))
    with pytest.raises(ConfigError, match=r"nowhere.txt: cannot be read .*; needs the climate of the campaign"):
        read_climate(planned, str(tmp_path / "nowhere.txt"))
