"""Measured spectra: the shipped year, other ways of writing them, and files that are refused in one line."""

import gzip
import sys
from datetime import datetime, timedelta
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from vsb.errors import ConfigError
from vsb.study.study import Water
from vsb.waves.ndbc import _calendar, _check_units, _dates, _direction_widths, _header, _time, read_ndbc, read_spectra

SHIPPED = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"
WRITTEN = Path(__file__).parents[1] / "data" / "spectra"
HEADER = "YY MM DD hh   .050   .100   .150\n"
ROWS = "96 01 01 00   1.00   2.00   0.50\n96 01 01 01   1.50   2.50   0.25\n"
BANDS = 0.05 * np.array([1.0, 2.0, 3.0])


def test_the_shipped_year():
    """Counts seen in the file itself, variance of its first row, sum S df."""
    first = gzip.decompress(SHIPPED.read_bytes()).decode().splitlines()[1].split()[4:]
    climate = read_ndbc(SHIPPED)
    assert climate.density.shape == (8600, 38)
    assert {"one record per 1 h, 72 of them not in the file", "8712 records, 112 with missing values left out"} <= set(
        climate.notes
    )
    assert climate.omega[[0, -1]] / (2 * np.pi) == pytest.approx([0.03, 0.40])
    assert climate.variance[0] == pytest.approx(sum(map(float, first)) * 0.01, rel=1e-12)
    assert float(climate.flux(Water()) @ climate.hours) == pytest.approx(26.5e3, rel=1e-3)


def test_units_of_the_text_are_per_hertz(written):
    climate = read_ndbc(written(HEADER + ROWS))
    assert climate.hs == pytest.approx(4 * np.sqrt(0.05 * np.array([3.5, 4.25])), rel=1e-14)
    assert climate.te[0] == pytest.approx((1 / 0.05 + 2 / 0.10 + 0.5 / 0.15) / 3.5, rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        HEADER + ROWS,
        HEADER.replace("YY", "YYYY") + ROWS.replace("96 01", "1996 01"),
        HEADER.replace("YY MM DD hh", "#YY MM DD hh mm") + ROWS.replace(" 00  ", " 00 00 ").replace(" 01  ", " 01 00 "),
        (HEADER + ROWS).replace("\n", "\r\n"),
        HEADER + "# densities in m*m/Hz\n" + ROWS,
        "\n" + HEADER + "  \n" + ROWS + "\n",
        b"\xef\xbb\xbf" + (HEADER + ROWS).encode(),
        gzip.compress((HEADER + ROWS).encode()),
        HEADER + ROWS + "96 01 01 01   9.99   9.99   9.99\n",  # an instant once more
        HEADER + ROWS + "96 01 01 02   999.0   9.99   9.99\n96 01 01 03   0.00   0.00   0.00\n",
        HEADER + ROWS + "96 01 01 02   MM   9.99   9.99\n" + HEADER.replace("YY", "#YY"),
        "YY MM DD hh .033 .050 .100 .150\n96 01 01 00 999.00 1.00 2.00 0.50\n96 01 01 01 999.00 1.50 2.50 0.25\n",
        "#YY MM DD hh mm Sep_Freq  < spec_1 (freq_1) spec_2 (freq_2) ... >\n"
        "2020 01 01 01 00 9.999 1.00 (0.050) 2.00 (0.100) 0.50 (0.150)\n"
        "2020 01 01 00 00 9.999 1.50 (0.050) 2.50 (0.100) 0.25 (0.150)\n",
    ],
)
def test_the_same_seas_in_other_ways_of_writing(written, text):
    climate = read_ndbc(written(text))
    assert climate.density * 2 * np.pi == pytest.approx(np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]]), rel=1e-14)


def test_what_is_left_out_is_said(written):
    rows = ROWS + "96 01 01 01 1 1 2\n96 01 01 05 999.00 1 2\n96 01 01 06 .00 .00 .00\n"
    notes = "; ".join(read_ndbc(written(HEADER + rows)).notes)
    for said in (
        "1 records of an instant that has one already left out",
        "3 of them not in the file",
        "1 with missing values left out",
        "1 records of one value throughout left out",
        "0 days stand for a year: seasons are missing",
    ):
        assert said in notes


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "received 0 lines, needs a header"),
        (HEADER, "received 1 lines, needs a header with frequencies and rows of spectra"),
        (HEADER + "#yr mo dy hr m2/Hz\n", "received 2 lines, needs a header with frequencies and rows of spectra"),
        ("hello\nworld\n", "line 1: received 'hello', needs YY MM DD hh"),
        ("YY MM DD hh hello\n96 01 01 00 1\n", "line 1: received 'hello', needs a number"),
        (
            "YY MM DD hh 20. 10. 6.7\n96 01 01 00 1 2 3\n",
            "line 1: received 3 frequencies from 20 to 6.7, needs them asc",
        ),
        ("YY MM DD hh 10 20\n96 01 01 00 1 2\n", "received 2 frequencies from 10 to 20, needs them ascending"),
        ("YY MM DD hh\n96 01 01 00\n", "received 0 frequencies"),
        ("#YY MM DD hh mm WDIR WSPD WVHT\n#yr\n20 01 01 00 00 9 2 1\n", "received the buoy's meteorological data"),
        (HEADER + ROWS + HEADER.replace(".050", ".040") + ROWS, "line 4: received another header, needs one set"),
        (
            "#YY MM DD hh mm Sep_Freq < spec_1 (freq_1) >\n2020 01 01 01 00 9 1 (.05) 2 (.1)\n"
            "2020 01 01 02 00 9 1 (.05) 2 (.2)\n",
            "line 3: received other frequencies than line 2",
        ),
        (HEADER + ROWS + "96 01 01 02 1.0\n", "line 4: received 5 columns, needs 7 as the header has"),
        (HEADER + ROWS + "96 01 01\n", "line 4: received 3 columns, needs 7 as the header has"),
        (HEADER + ROWS + "96 01 01 02 1.0 x 2\n", "line 4: received 'x', needs a number"),
        (HEADER + ROWS + "96 01 01 02 1.0 nan 2\n", "line 4: received nan, needs a number of 0 or more"),
        (HEADER + ROWS + "96 01 01 02 1.0 -1 2\n", "line 4: received -1, needs a number of 0 or more"),
        (HEADER + ROWS + "96 13 01 02 1.0 1 2\n", "line 4: received the date '96 13 01 02', needs YY MM DD"),
        (HEADER + ROWS + "96 1.5 01 02 1.0 1 2\n", "line 4: received the date"),
        (HEADER + "96 01 01 00 999 999 999\n", "received 1 records, none with a spectrum"),
        (HEADER + ROWS.replace("0.50", "900.").replace("0.25", "900."), "seas that cannot be, as Hs .* needs frequenc"),
        (gzip.compress((HEADER + ROWS).encode())[:-12], "a packed file that is cut or damaged, needs a whole one"),
        (b"\x89HDF\xff\xfe\x80\x81", "that is no text, needs UTF-8"),
    ],
)
def test_refused_in_one_line(written, text, message):
    with pytest.raises(ConfigError, match=message) as caught:
        read_ndbc(written(text))
    assert "\n" not in str(caught.value)
    assert "given.txt" in str(caught.value)


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


def test_a_file_that_is_not_there():
    with pytest.raises(ConfigError, match=r"nowhere\.txt: cannot be read"):
        read_ndbc("nowhere.txt")


def spectra(**changes):
    """Two seas at one site in wavespectra's names, spread over four directions as 1 to 4."""
    spread = np.array([1.0, 2.0, 3.0, 4.0]) / 10 / 90
    density = np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]])
    ds = xr.Dataset(
        {"efth": (("time", "site", "freq", "dir"), density[:, None, :, None] * spread)},
        coords={
            "time": np.array(["2020-01-01T00", "2020-01-01T01"], dtype="datetime64[ns]"),
            "site": [7],
            "freq": BANDS,
            "dir": [0.0, 90.0, 180.0, 270.0],
        },
    )
    ds.efth.attrs["units"] = "m^{2}.s.degree^{-1}"
    ds.freq.attrs["units"] = "Hz"
    return ds.assign(changes)


def test_a_site_may_be_told_by_several_dimensions_of_one(tmp_path):
    spectra().expand_dims(lat=[44.5], lon=[-124.2]).to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]]), rel=1e-14)
    spectra().expand_dims(lat=[44.5], lon=[-124.2, -124.3]).to_netcdf(tmp_path / "two.nc")
    with pytest.raises(ConfigError, match="received 2 along lon, needs one: select a site"):
        read_spectra(tmp_path / "two.nc")


def test_directional_spectra_of_netcdf(tmp_path):
    spectra().to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]]), rel=1e-14)


@pytest.mark.parametrize("order", list(permutations(("time", "freq", "dir"))))
def test_dimensions_of_netcdf_stand_in_any_order(tmp_path, order):
    ds = spectra().transpose("site", *order)
    ds.to_netcdf(tmp_path / "s.nc")
    ds.sum("dir").assign(efth=90.0 * ds.efth.sum("dir").drop_attrs()).to_netcdf(tmp_path / "summed.nc")
    expected = np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]])
    for name in ("s.nc", "summed.nc"):
        climate = read_spectra(tmp_path / name)
        np.testing.assert_allclose(climate.density * 2 * np.pi, expected, rtol=1e-14)
        np.testing.assert_allclose(climate.omega, 2 * np.pi * BANDS, rtol=1e-14)


@pytest.mark.parametrize(
    "units", ["m2/Hz/degree", "m2/Hz/deg", "m2 s / Degrees", "m^{2}.s.degree^{-1}", "m2 Hz-1 degree-1", ""]
)
@pytest.mark.parametrize("hertz", ["Hz", "s-1", "s^-1", "s^{-1}", "1/s", ""])
def test_units_of_netcdf_as_they_are_written(units, hertz):
    ds = spectra()
    ds.efth.attrs["units"], ds.freq.attrs["units"] = units, hertz
    _check_units("s.nc", ds, True)
    ds.efth.attrs["units"] = "m^2 s"
    with pytest.raises(ConfigError, match=r"^s.nc: received efth in 'm\^2 s', needs m2/Hz/degree$"):
        _check_units("s.nc", ds, True)


@pytest.mark.parametrize("units", ["m2/Hz", "m^2/Hz", "m2 s", "m^2 s", "m^{2}s", "m**2/hz", "m2 Hz-1", "m**2 s", ""])
def test_units_of_netcdf_without_directions(units):
    ds = spectra()
    ds.efth.attrs["units"] = units
    _check_units("s.nc", ds, False)
    ds.efth.attrs["units"] = "m2/Hz/degree"
    with pytest.raises(ConfigError, match=r"^s.nc: received efth in 'm2/Hz/degree', needs m2/Hz$"):
        _check_units("s.nc", ds, False)


def test_a_calendar_keeps_the_first_record_of_an_instant_and_says_what_it_lacks():
    """Hours 0, 1, 2, 2 again, 6, 2.25 and 7: of steps of an hour three are missing, one is shorter."""
    start = datetime(2020, 1, 1)
    times = [start + timedelta(hours=hours) for hours in (1, 0, 2, 2, 6, 2.25, 7)]
    kept, notes = _calendar(times)
    assert kept == [0, 1, 2, 4, 5, 6]
    assert notes == [
        "2020-01-01 00:00 to 2020-01-01 07:00",
        "1 records of an instant that has one already left out",
        "one record per 1 h, 3 of them not in the file",
        "1 records closer than that count as much as the others",
        "0 days stand for a year: seasons are missing",
    ]
    assert _calendar([start]) == ([0], ["2020-01-01 00:00 to 2020-01-01 00:00"])


@pytest.mark.parametrize(("days", "told"), [(359, ["359 days stand for a year: seasons are missing"]), (360, [])])
def test_a_year_may_lack_five_days(days, told):
    times = [datetime(2020, 1, 1) + timedelta(days=day) for day in range(days + 1)]
    assert _calendar(times)[1][1:] == ["one record per 24 h, 0 of them not in the file", *told]


@pytest.mark.parametrize(
    ("words", "year"),
    [("69 5 6 7", 2069), ("70 5 6 7", 1970), ("99 5 6 7", 1999), ("1970 5 6 7 8", 1970), ("0 5 6 7", 2000)],
)
def test_years_of_two_digits(words, year):
    assert _time("s.txt", 2, words.split()) == datetime(year, 5, 6, 7, 8 if words.endswith("8") else 0)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("YY MM DD hh 4.0 5.0", ""),
        ("YY MM DD hh 4.0 5.1", "line 1: received 2 frequencies from 4 to 5.1, needs them ascending, above 0, in Hz"),
        ("YY MM DD hh 0 0.1", "line 1: received 2 frequencies from 0 to 0.1, needs them ascending, above 0, in Hz"),
        ("YY MM DD hh 0.1 0.1", "line 1: received 2 frequencies from 0.1 to 0.1, needs them ascending, above 0, in Hz"),
        ("YY MM DD hh 0.1", "line 1: received 1 frequencies from 0.1 to 0.1, needs them ascending, above 0, in Hz"),
        ("YY MM DD 0.1 0.2", "line 1: received 'YY MM DD 0.1 0.2', needs YY MM DD hh [mm] and the frequencies in Hz"),
    ],
)
def test_frequencies_of_a_header(header, message):
    if not message:
        assert _header("s.txt", header.split())[1].tolist() == [4.0, 5.0]
        return
    with pytest.raises(ConfigError) as refused:
        _header("s.txt", header.split())
    assert str(refused.value) == f"s.txt, {message}"


def test_missing_numbers_of_netcdf_are_counted(tmp_path):
    ds = spectra()
    ds.efth[0, 0, 1, 2] = np.nan
    ds.to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert len(climate.hs) == 1
    assert "2 records, 1 with missing values left out" in climate.notes


def uneven(ds):
    return ds.assign_coords(dir=[0.0, 90.0, 180.0, 200.0])


def per_radian(ds):
    ds.efth.attrs["units"] = "m2/Hz/rad"
    return ds


def periods(ds):
    ds.freq.attrs["units"] = "s"
    return ds


def stamped(*time):
    """A change of the time of the records."""
    return lambda ds: ds.assign_coords(time=np.array(time))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (lambda ds: ds.rename(efth="S"), r"received variables .*'S'.*, needs efth"),
        (lambda ds: xr.concat([ds, ds], dim="site"), "received 2 along site, needs one: select a site"),
        (uneven, "received directions 20 to 160 degrees apart, needs equal distances"),
        (per_radian, "received efth in 'm2/Hz/rad', needs m2/Hz/degree"),
        (periods, "received freq in 's', needs Hz"),
        (lambda ds: ds.isel(freq=slice(None, None, -1)), "needs time and ascending freq"),
        (lambda ds: ds.isel(time=0), "needs time and ascending freq"),
        (lambda ds: ds.isel(freq=[1]), "needs time and ascending freq"),
        (lambda ds: ds.assign_coords(freq=BANDS - BANDS[0]), "needs time and ascending freq above 0 Hz"),
        (lambda ds: ds.isel(time=[]), "s.nc: received no record along time, needs one or more$"),
        (lambda ds: ds.drop_vars("time"), "received time from 0 to 1, needs a date for every record"),
        (stamped(0.0, 0.04), "received time from 0.0 to 0.04, needs a date for every record, in units such as 'hours "),
        (stamped("first", "second"), "received time from first to second, needs a date for every record"),
        (stamped(np.datetime64("2020-01-01", "ns"), np.datetime64("NaT")), "received time from 2020-.* to NaT, needs"),
        (lambda ds: ds.assign_coords(freq=["low", "middle", "high"]), "received freq of type <U6, needs numbers"),
        (lambda ds: ds.assign_coords(dir=list("NESW")), "received dir of type <U1, needs numbers"),
        (lambda ds: ds.assign(efth=(ds.efth.dims, np.full(ds.efth.shape, "x"))), "efth of type <U1, needs numbers"),
        (lambda ds: ds.assign_coords(dir=[0.0, np.nan, 180.0, 270.0]), "received directions nan to nan degrees apart"),
        (
            lambda ds: ds.assign(efth=-ds.efth.assign_attrs(units="")),
            "received a spectral density of -.* needs 0 or more",
        ),
    ],
)
def test_netcdf_refused_in_one_line(tmp_path, changed, message):
    changed(spectra()).to_netcdf(tmp_path / "s.nc")
    with pytest.raises(ConfigError, match=message) as caught:
        read_spectra(tmp_path / "s.nc")
    assert "\n" not in str(caught.value)


def test_no_netcdf_at_all(tmp_path):
    (tmp_path / "s.nc").write_text("hello")
    with pytest.raises(ConfigError, match=r"s\.nc: cannot be read as netCDF"):
        read_spectra(tmp_path / "s.nc")


@pytest.mark.parametrize("turns", [[0, 0, 0, 0], [0, 1, 0, 2], [-1, 0, 3, 0]])
def test_directions_are_as_far_apart_whichever_turn_they_are_told_in(turns):
    """Of 30, 120, 210 and 300 degrees each is the middle of a quarter of all."""
    degrees = np.array([120.0, 30.0, 300.0, 210.0]) + 360 * np.array(turns)
    np.testing.assert_allclose(_direction_widths("sea.nc", degrees), 90.0)
    with pytest.raises(
        ConfigError, match=r"sea\.nc: received directions 80 to 100 degrees apart, needs equal distances"
    ):
        _direction_widths("sea.nc", degrees + np.array([10.0, 0.0, 0.0, 0.0]))


def test_dates_of_netcdf_are_known_to_the_second(tmp_path):
    """Records 90 s apart, one of them told twice: the first counts, and the notes say from when to when they are."""
    time = np.array(["2020-01-01T00:10:00", "2020-01-01T00:11:30", "2020-01-01T00:11:30"], dtype="datetime64[ns]")
    density = np.outer([1.0, 3.0, 7.0], [1.0, 2.0, 0.5])
    ds = xr.Dataset({"efth": (("time", "freq"), density)}, coords={"time": time, "freq": BANDS})
    ds.to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(density[:2], rel=1e-14)
    assert climate.name == "s.nc"
    assert climate.notes[:3] == (
        "2020-01-01 00:10 to 2020-01-01 00:11",
        "1 records of an instant that has one already left out",
        "one record per 0.025 h, 0 of them not in the file",
    )
    assert [f"{date:%H:%M:%S}" for date in _dates("s.nc", time)] == ["00:10:00", "00:11:30", "00:11:30"]


def test_records_of_an_instant_that_has_one_are_left_out_of_text(written):
    climate = read_ndbc(written(HEADER + ROWS + "96 01 01 00 9 9 1\n"))
    assert climate.density * 2 * np.pi == pytest.approx(np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]]), rel=1e-14)
    assert climate.name == "given.txt"


def test_999_is_no_number_of_the_text(written):
    climate = read_ndbc(written(HEADER + ROWS + "96 01 01 02 998.9 999 999\n96 01 01 03 1 2 999\n"))
    assert "4 records, 2 with missing values left out" in climate.notes


@pytest.mark.parametrize(("row", "received"), [("1.0 -1 -2", "-1"), ("inf 1 nan", "inf"), ("1 2 inf", "inf")])
def test_the_first_number_that_is_none_is_named(written, row, received):
    rows = f"{ROWS}96 01 01 02 {row}\n96 01 01 03 {row}\n"
    with pytest.raises(
        ConfigError, match=rf"line 4: received {received}, needs a number of 0 or more \(999 for none\)"
    ):
        read_ndbc(written(HEADER + rows))


@pytest.mark.parametrize("first", [0.5, 3.0])
def test_the_usual_distance_of_records_is_the_most_frequent_not_the_first_or_the_least(first):
    start = datetime(2020, 1, 1)
    times = [start + timedelta(hours=hours) for hours in (0, first, first + 1, first + 2, first + 2.5, first + 3.5)]
    notes = _calendar(times)[1]
    lacking, uneven = (2, 1) if first == 3.0 else (0, 2)
    assert notes[1:3] == [
        f"one record per 1 h, {lacking} of them not in the file",
        f"{uneven} records closer than that count as much as the others",
    ]


def test_a_file_of_spectra_without_frequencies(tmp_path):
    spectra().rename(freq="hertz").to_netcdf(tmp_path / "s.nc")
    with pytest.raises(ConfigError, match=r"s\.nc: received variables \['dir', 'efth', 'hertz', .*\], needs freq$"):
        read_spectra(tmp_path / "s.nc")


@pytest.mark.parametrize(("miss", "refused"), [(5e-4, False), (2e-3, True)])
def test_directions_may_miss_their_distance_by_a_thousandth(miss, refused):
    degrees = np.array([0.0, 90.0 + 45 * miss, 180.0, 270.0])
    if not refused:
        np.testing.assert_array_equal(_direction_widths("s.nc", degrees), 90.0)
        return
    with pytest.raises(ConfigError, match="needs equal distances all around"):
        _direction_widths("s.nc", degrees)


def test_frequencies_of_netcdf_may_not_repeat(tmp_path):
    spectra().assign_coords(freq=[0.05, 0.1, 0.1]).to_netcdf(tmp_path / "s.nc")
    with pytest.raises(ConfigError, match=r"needs time and ascending freq above 0 Hz$"):
        read_spectra(tmp_path / "s.nc")


@pytest.mark.parametrize("units", ["m^2/Hz/degree", "M2 S / degree", "m2/hz/degrees", "m2 s degrees"])
def test_other_units_of_netcdf_with_directions(units):
    ds = spectra()
    ds.efth.attrs["units"] = units
    if units == "m2 s degrees":  # per degree it is not
        with pytest.raises(ConfigError, match=r"^s.nc: received efth in 'm2 s degrees', needs m2/Hz/degree$"):
            _check_units("s.nc", ds, True)
        return
    _check_units("s.nc", ds, True)


def test_a_year_of_netcdf_is_known_by_its_calendar_and_its_file(tmp_path):
    """Records told out of order: the seas stand in the order of the file, a year from the first to the last."""
    time = np.array(["2020-03-01T00:00", "2020-01-01T00:00", "2021-01-01T00:00"], dtype="datetime64[ns]")
    density = np.outer([1.0, 3.0, 2.0], [1.0, 2.0, 0.5])
    ds = xr.Dataset({"efth": (("time", "freq"), density)}, {"time": time, "freq": BANDS})
    ds.to_netcdf(tmp_path / "site.nc")
    climate = read_spectra(tmp_path / "site.nc")
    assert climate.name == "site.nc"
    np.testing.assert_allclose(climate.density * 2 * np.pi, density, rtol=1e-14)
    assert climate.notes[0] == "2020-01-01 00:00 to 2021-01-01 00:00"
    assert not any("seasons are missing" in note for note in climate.notes)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("1.0 2.0", "received 6 columns, needs 7 as the header has"),
        ("1.0 x 2.0", "received 'x', needs a number"),
        ("1.0 -1 2.0", r"received -1, needs a number of 0 or more \(999 for none\)"),
    ],
)
def test_lines_are_those_of_the_file_empty_ones_and_remarks_too(written, row, message):
    text = "\n" + HEADER + "# densities in m*m/Hz\n\n" + ROWS
    with pytest.raises(ConfigError, match=f"^.*given.txt, line 7: {message}"):
        read_ndbc(written(f"{text}96 01 01 02 {row}\n"))
    with pytest.raises(ConfigError, match=r"^.*given\.txt, line 7: received the date '96 13 01 02', needs YY MM DD"):
        read_ndbc(written(text + "96 13 01 02 1.0 1 2\n"))
