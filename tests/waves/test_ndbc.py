"""Measured spectra: the year of a buoy shipped with the package, other layouts, and files that are refused in one line."""

import gzip
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from vsb.errors import ConfigError
from vsb.study.study import Water
from vsb.waves.ndbc import read_ndbc, read_spectra

SHIPPED = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"
HEADER = "YY MM DD hh   .050   .100   .150\n"
ROWS = "96 01 01 00   1.00   2.00   0.50\n96 01 01 01   1.50   2.50   0.25\n"
TEXT = HEADER + ROWS
BANDS = 0.05 * np.array([1.0, 2.0, 3.0])
DENSITY = np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]])
"""Of the two records, per hertz [m^2/Hz]."""


def test_shipped_year():
    """Counts found in the file itself; variance of its first row, sum S df."""
    first = gzip.decompress(SHIPPED.read_bytes()).decode().splitlines()[1].split()[4:]
    climate = read_ndbc(SHIPPED)
    assert climate.density.shape == (8600, 38)
    notes = {"one record per 1 h, 72 of them not in the file", "8712 records, 112 with missing values left out"}
    assert notes <= set(climate.notes)
    assert climate.omega[[0, -1]] / (2 * np.pi) == pytest.approx([0.03, 0.40])
    assert climate.variance[0] == pytest.approx(sum(map(float, first)) * 0.01, rel=1e-12)
    assert float(climate.flux(Water()) @ climate.hours) == pytest.approx(26.5e3, rel=1e-3)


@pytest.mark.parametrize(
    "text",
    [
        HEADER.replace("YY", "YYYY") + ROWS.replace("96 01", "1996 01"),
        HEADER.replace("YY MM DD hh", "#YY MM DD hh mm") + ROWS.replace(" 00  ", " 00 00 ").replace(" 01  ", " 01 00 "),
        b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode(),
        "\n" + HEADER + "# densities in m*m/Hz\n  \n" + ROWS + "\n",
        gzip.compress(TEXT.encode()),
        TEXT + "96 01 01 01   9.99   9.99   9.99\n",  # the second record of an instant
        TEXT + "96 01 01 02   999.0   9.99   9.99\n96 01 01 03   0.00   0.00   0.00\n",
    ],
    ids=["four-digit years", "minutes", "Windows", "comments", "packed", "repeated", "missing and calm"],
)
def test_text_layouts(written, text):
    assert read_ndbc(written(text)).density * 2 * np.pi == pytest.approx(DENSITY, rel=1e-14)


def test_records_left_out_are_noted(written):
    rows = "96 01 01 01 1 1 2\n96 01 01 05 999.00 1 2\n96 01 01 06 .00 .00 .00\n"
    notes = "; ".join(read_ndbc(written(TEXT + rows)).notes)
    for note in (
        "1 records of an instant that has one already left out",
        "3 of them not in the file",
        "1 with missing values left out",
        "1 records of one value throughout left out",
        "0 days stand for a year: seasons are missing",
    ):
        assert note in notes


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "received 0 lines, needs a header"),
        ("YY MM DD hh hello\n96 01 01 00 1\n", "line 1: received 'hello', needs a number"),
        ("#YY MM DD hh mm WDIR WSPD WVHT\n#yr\n20 01 01 00 00 9 2 1\n", "received the buoy's meteorological data"),
        (HEADER + ROWS + HEADER.replace(".050", ".040") + ROWS, "line 4: received another header, needs one set"),
        ("YY MM DD hh 20. 10.\n96 01 01 00 1 2\n", "line 1: received 2 frequencies from 20 to 10, needs them asc"),
        (
            "\n" + HEADER + "# a comment\n" + ROWS + "96 01 01 02 1.0\n",
            "line 6: received 5 columns, needs 7 as the hea",
        ),
        (TEXT + "96 01 01 02 1.0 x 2\n", "line 4: received 'x', needs a number"),
        (TEXT + "96 01 01 02 1.0 -1 2\n", "line 4: received -1, needs a number of 0 or more"),
        (TEXT + "96 13 01 02 1.0 1 2\n", "line 4: received the date '96 13 01 02', needs YY MM DD"),
        (HEADER + "96 01 01 00 999 999 999\n", "received 1 records, none with a spectrum"),
        (
            HEADER + ROWS.replace("0.50", "900.").replace("0.25", "900."),
            "records that are physically impossible, as Hs .* needs frequenc",
        ),
        (gzip.compress(TEXT.encode())[:-12], "a packed file that is cut or damaged, needs a whole one"),
        (b"\x89HDF\xff\xfe\x80\x81", "that is no text, needs UTF-8"),
    ],
)
def test_text_errors_are_one_line(written, text, message):
    with pytest.raises(ConfigError, match=message) as caught:
        read_ndbc(written(text))
    assert "\n" not in str(caught.value)
    assert "given.txt" in str(caught.value)


@pytest.mark.parametrize("read", [read_ndbc, read_spectra])
def test_missing_file(read):
    with pytest.raises(ConfigError, match=r"nowhere\.\w+: cannot be read"):
        read("nowhere.txt")


def spectra(**units):
    """Two seas at one site with the names of wavespectra, spread over four directions as 1 to 4."""
    spread = np.array([1.0, 2.0, 3.0, 4.0]) / 10 / 90
    ds = xr.Dataset(
        {"efth": (("time", "site", "freq", "dir"), DENSITY[:, None, :, None] * spread)},
        coords={
            "time": np.array(["2020-01-01T00", "2020-01-01T01"], dtype="datetime64[ns]"),
            "site": [7],
            "freq": BANDS,
            "dir": [0.0, 90.0, 180.0, 270.0],
        },
    )
    for name, unit in ({"efth": "m^{2}.s.degree^{-1}", "freq": "Hz"} | units).items():
        ds[name].attrs["units"] = unit
    return ds


@pytest.mark.parametrize(
    "ds",
    [
        spectra(),
        spectra(efth="m2/Hz/deg", freq="s^-1").transpose("site", "dir", "freq", "time"),
        spectra().assign_coords(dir=[0.0, 450.0, -180.0, 270.0]),
        spectra().expand_dims(lat=[44.5], lon=[-124.2]),
        (90.0 * spectra().efth.sum("dir")).assign_attrs(units="m2/Hz").to_dataset(name="efth"),
    ],
    ids=["wavespectra", "transposed", "directions beyond a turn", "site by coordinates", "without directions"],
)
def test_netcdf_layouts(tmp_path, ds):
    ds.to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(DENSITY, rel=1e-14)
    assert climate.omega == pytest.approx(2 * np.pi * BANDS, rel=1e-14)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (spectra().rename(efth="S"), r"received variables .*'S'.*, needs efth"),
        (xr.concat([spectra(), spectra()], dim="site"), "received 2 along site, needs one: select a site"),
        (
            spectra().assign_coords(dir=[0.0, 90.0, 180.0, 200.0]),
            "directions 20 to 160 degrees apart, needs equal dist",
        ),
        (spectra(efth="m2/Hz/rad"), "received efth in 'm2/Hz/rad', needs m2/Hz/degree"),
        (spectra().isel(time=[]), "s.nc: received no record along time, needs one or more$"),
        (
            spectra().assign_coords(time=[0.0, 0.04]),
            "received time from 0.0 to 0.04, needs a date for every record, in",
        ),
        (spectra().assign_coords(freq=["a", "b", "c"]), "received freq of type <U1, needs numbers"),
        (-spectra(), "received a spectral density of -.* needs 0 or more"),
    ],
)
def test_netcdf_errors_are_one_line(tmp_path, changed, message):
    changed.to_netcdf(tmp_path / "s.nc")
    with pytest.raises(ConfigError, match=message) as caught:
        read_spectra(tmp_path / "s.nc")
    assert "\n" not in str(caught.value)


def test_netcdf_file_that_announces_more_than_it_holds_is_refused(tmp_path):
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        file.createDimension("time", 2_000_000_000)
        file.createDimension("freq", 2)
        file.createVariable("freq", "f8", ("freq",))[:] = [0.1, 0.2]
        file.createVariable("efth", "f8", ("time", "freq"), chunksizes=(1, 2))
    with pytest.raises(ConfigError, match=r"a.nc: cannot be read as netCDF"):
        read_spectra(tmp_path / "a.nc")


WRITTEN = Path(__file__).parents[1] / "data" / "spectra"


@pytest.mark.parametrize("name", ["wavespectra.nc", "swan.spec", "ww3.nc"])
def test_files_by_the_writers_of_wavespectra(name):
    """Seas of 1, 2 and 3 m at one site, written by wavespectra 4.9; its netCDF is packed to three digits."""
    if name != "wavespectra.nc":
        pytest.importorskip("wavespectra")
    assert read_spectra(WRITTEN / name).hs == pytest.approx([1.0, 2.0, 3.0], rel=1e-3)


def foreign(name):
    """Two seas as ECMWF and the National Data Buoy Center write them in netCDF, with a band without energy."""
    density = np.array([[0.0, 2.0, 0.5], [0.0, 2.5, 0.25]])
    time = np.array(["2020-01-01T00", "2020-01-01T01"], dtype="datetime64[ns]")
    if name == "ndbc":
        site = {"latitude": [44.5], "longitude": [-124.2]}
        coords = {"time": time, "frequency": BANDS, **site}
        return xr.Dataset({"spectral_wave_density": ((*coords,), density[:, :, None, None])}, coords)
    with np.errstate(divide="ignore"):
        level = np.log10(np.repeat(density[..., None], 4, axis=2) / (2 * np.pi))
    level[np.isinf(level)] = np.nan  # where there is no energy
    return xr.Dataset({"d2fd": (("time", "frequency", "direction"), level)}, {"time": time}).assign_coords(
        frequency=[1, 2, 3], direction=[1, 2, 3, 4]
    )


@pytest.mark.parametrize("name", ["era5", "ndbc"])
def test_files_of_reanalyses_and_data_servers(tmp_path, name):
    """ERA5 leaves out the logarithm of no energy: zero, not missing. Its bands are 0.03453 Hz and 10 % further each."""
    pytest.importorskip("wavespectra")
    foreign(name).to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(np.array([[0.0, 2.0, 0.5], [0.0, 2.5, 0.25]]), rel=1e-6)
    hertz = BANDS if name == "ndbc" else 0.03453 * 1.1 ** np.arange(3)
    assert climate.omega == pytest.approx(2 * np.pi * hertz)


def test_a_file_for_wavespectra_names_it_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "wavespectra", None)
    with pytest.raises(
        ConfigError, match=r"swan\.spec: received spectra as swan writes them, needs the package wavesp"
    ):
        read_spectra(WRITTEN / "swan.spec")
