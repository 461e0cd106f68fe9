"""Spectra of other programs: netCDF by the units it states, SWAN's text, and files that are refused in one line."""

import gzip
import sys
from datetime import datetime, timedelta
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from vsb.engine.waves.climate import is_doubt, of_records, seasons
from vsb.engine.waves.measured_spectra import read_ndbc, read_spectra
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.tools.files import sha256_of

BANDS = 0.05 * np.array([1.0, 2.0, 3.0])
DENSITY = np.array([[1.0, 2.0, 0.5], [1.5, 2.5, 0.25]])
"""Of two records, per hertz [m^2/Hz]."""


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
        (spectra().rename(efth="S"), r"received variables S, .*; needs efth or ef or spec"),
        (xr.concat([spectra(), spectra()], dim="site"), "received 2 along site, needs one: select a site"),
        (
            spectra().assign_coords(dir=[0.0, 90.0, 180.0, 200.0]),
            "directions 20 to 160 degrees apart, needs equal dist",
        ),
        (
            spectra(efth="m2/Hz"),
            "received efth over time, site, freq, dir in 'm2/Hz' with frequencies in Hz, needs m2/Hz/degree",
        ),
        (
            spectra(efth="J/m2/Hz"),
            "received efth over time, site, freq, dir in 'J/m2/Hz' .* needs m2/Hz/degree, m2/Hz/rad",
        ),
        (spectra(freq="rad/s"), r"in 'm\^\{2\}.s.degree\^\{-1\}' with frequencies in rad/s, needs .* m2 s/rad/degree"),
        (spectra(freq="s"), "received freq in 's', needs Hz or rad/s"),
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
    if name == "swan.spec":
        pytest.importorskip("wavespectra")
    assert read_spectra(WRITTEN / name).hs == pytest.approx([1.0, 2.0, 3.0], rel=1e-3)


RADIANS = (np.pi / 180 * spectra()).assign_coords(dir=np.radians([0.0, 90.0, 180.0, 270.0]))
PER_RADIAN = (180 / np.pi) ** 2 * RADIANS
DIALECTS = {
    "WAVEWATCH III": spectra().rename(freq="frequency", dir="direction", site="station") * (180 / np.pi),
    "its names with wavespectra's units": spectra().rename(freq="frequency", dir="direction"),
    "SWAN": PER_RADIAN.rename(efth="density", freq="frequency", dir="direction", site="points"),
    "SWAN, one-dimensional": (90.0 * spectra().sum("dir")).rename(efth="density", freq="frequency"),
    "NDBC": (90.0 * spectra().sum("dir")).rename(efth="spectral_wave_density", freq="frequency", site="latitude"),
    "frequencies descending": spectra().isel(freq=[2, 1, 0]),
    "over angular frequency": (90.0 / (2 * np.pi) * spectra().sum("dir")).assign_coords(
        freq=("freq", 2 * np.pi * BANDS, {"units": "radian s-1"})
    ),
    "over angular frequency and direction": (spectra() / (2 * np.pi)).assign_coords(
        freq=("freq", 2 * np.pi * BANDS, {"units": "rad/s"})
    ),
}
UNITS = dict(
    zip(
        DIALECTS,
        (
            "m2 s rad-1",
            "m2 s degree-1",
            "m**2 s radian**-1",
            "m2 s",
            "(meter * meter)/Hz",
            "m2/Hz/degr",
            "m2 s rad-1",
            "m2/(rad/s)/deg",
        ),
        strict=True,
    )
)


@pytest.mark.parametrize("name", DIALECTS)
def test_units_say_what_a_density_is_per(tmp_path, name):
    """The same seas as each program writes them: per degree, per radian, or over all directions."""
    ds = DIALECTS[name].copy()
    next(iter(ds.data_vars.values())).attrs["units"] = UNITS[name]
    ds.to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(DENSITY, rel=1e-14)
    assert climate.omega == pytest.approx(2 * np.pi * BANDS, rel=1e-14)


def test_records_flagged_by_cdip_are_left_out(tmp_path):
    time = np.array(["2020-01-01T00", "2020-01-01T01"], dtype="datetime64[ns]")
    axes = ("waveTime", "waveFrequency")
    ds = xr.Dataset(
        {"waveEnergyDensity": (axes, DENSITY, {"units": "meter^2 second"}), "waveFlagPrimary": (axes[0], [4, 1])}
    )
    ds.assign_coords(waveTime=time, waveFrequency=BANDS).to_netcdf(tmp_path / "s.nc")
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(DENSITY[1:])
    assert "1 records not used for their waveFlagPrimary" in climate.notes


@pytest.mark.parametrize("hertz", [None, 0.04 * 1.2 ** np.arange(3)])
def test_reanalyses(tmp_path, hertz):
    """ERA5 leaves out the logarithm of no energy: zero, not missing. Its bands are 0.03453 Hz and 10 % further each, or as stated."""
    pytest.importorskip("wavespectra")
    density, time = (
        [[0.0, 2.0, 0.5], [0.0, 2.5, 0.25]],
        np.array(["2020-01-01T00", "2020-01-01T01"], dtype="datetime64[ns]"),
    )
    with np.errstate(divide="ignore"):
        level = np.log10(np.repeat(np.array(density)[..., None], 4, axis=2) / (2 * np.pi))
    level[np.isinf(level)] = np.nan
    ds = xr.Dataset({"d2fd": (("time", "frequency", "direction"), level)}, {"time": time})
    ds.assign_coords(frequency=[1, 2, 3] if hertz is None else hertz, direction=[1, 2, 3, 4]).to_netcdf(
        tmp_path / "s.nc"
    )
    climate = read_spectra(tmp_path / "s.nc")
    assert climate.density * 2 * np.pi == pytest.approx(np.array(density), rel=1e-6)
    assert climate.omega == pytest.approx(2 * np.pi * (0.03453 * 1.1 ** np.arange(3) if hertz is None else hertz))


def test_swan_text_packed_with_gzip_and_one_dimensional(tmp_path):
    pytest.importorskip("wavespectra")
    whole = (WRITTEN / "swan.spec").read_bytes()
    (tmp_path / "s.spec.gz").write_bytes(gzip.compress(whole))
    assert read_spectra(tmp_path / "s.spec.gz").hs == pytest.approx([1.0, 2.0, 3.0], rel=1e-3)
    (tmp_path / "one.spec").write_bytes(whole.replace(b"NDIR", b"XXXX"))
    with pytest.raises(
        ConfigError, match=r"one.spec: cannot be read by wavespectra; needs two-dimensional spectra as SWAN"
    ):
        read_spectra(tmp_path / "one.spec")


def test_a_file_for_wavespectra_names_it_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "wavespectra", None)
    with pytest.raises(
        ConfigError, match=r"swan\.spec: received .* SWAN writes them; needs .*: pip install wavespectra"
    ):
        read_spectra(WRITTEN / "swan.spec")


HERTZ = 0.02 + 0.01 * np.arange(40)
SEA = 5 * 0.1**4 / HERTZ**5 * np.exp(-1.25 * (0.1 / HERTZ) ** 4) / 4  # Pierson-Moskowitz of Hs = 2 m, Tp = 10 s


def triaxys(directional):
    kind = "DIRECTIONAL SPECTRUM" if directional else "NON-DIRECTIONAL SPECTRUM"
    head = (
        f"TRIAXYS BUOY DATA REPORT\nVERSION = 5c.02.08\nTYPE     = {kind}\nDATE     = 2020 Jan 01 00:00(UTC)\n"
        "NUMBER OF FREQUENCIES = 42\nINITIAL FREQUENCY (Hz) = 0.000\nFREQUENCY SPACING (Hz) = 0.010\n"
    )
    head += "RESOLVABLE FREQUENCY RANGE (Hz) = 0.02 TO 0.41\n"
    spectrum = np.r_[0.0, 0.0, SEA]
    if not directional:
        rows = "".join(f" {0.01 * i:.3f} {s:.6E}\n" for i, s in enumerate(spectrum))
        return head + "COLUMN 1 = FREQUENCY (Hz)\nCOLUMN 2 = SPECTRAL DENSITY (M^2/Hz)\n" + rows
    shares = np.append(np.array([0.5, 0.2, 0.1, 0.2]), 0.5) / 90.0  # the last direction, 360, is the first again
    rows = "".join(" ".join(f"{s * share:.6E}" for share in shares) + "\n" for s in spectrum)
    return head + "DIRECTION SPACING (DEG) = 90.0\nROWS = FREQUENCY\n" + rows


def datawell():
    values = [3, 200, 7.1, SEA.max(), 10.0, 12.0, 7, 0.0, 0.0, 0.0, 180.0, 60.0]
    rows = "".join(f"{f:.3f},{s / SEA.max():.6E},270.0,20.0,0.1,2.0\n" for f, s in zip(HERTZ, SEA, strict=True))
    return "".join(f"{value}\n" for value in values) + rows


def ww3_station():
    directions = np.radians([90.0, 0.0, 270.0, 180.0])
    table = np.outer([0.5, 0.2, 0.1, 0.2], SEA) / (np.pi / 2)
    numbers = "\n".join(f" {value:.6E}" for value in table.ravel())
    return (
        f"'WAVEWATCH III SPECTRA'     {len(HERTZ)}     4     1 'made up                       '\n"
        + "\n".join(f" {f:.3E}" for f in HERTZ) + "\n" + "\n".join(f" {d:.5E}" for d in directions)
        + f"\n20200101 000000\n'POINT     '  45.00 -10.00   100.0   5.00 270.0   0.00 270.0\n{numbers}\n"
    )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("s.NONDIRSPEC", triaxys(False)),
        ("s.DIRSPEC", triaxys(True)),
        ("Buoy}2020-01-01T00h00Z.spt", datawell()),
        ("s.spc", ww3_station()),
    ],
    ids=["TRIAXYS", "TRIAXYS over direction", "Datawell", "WAVEWATCH III"],
)
def test_texts_of_buoys_and_models_by_wavespectra(tmp_path, name, text):
    """One sea, Pierson-Moskowitz of 2 m; densities per hertz, per degree, relative to their maximum, per radian."""
    pytest.importorskip("wavespectra")
    (tmp_path / name).write_text(text)
    climate = read_spectra(tmp_path / name)
    assert climate.hs == pytest.approx([2.0], rel=2e-2)
    assert np.interp(2 * np.pi * HERTZ, climate.omega, climate.density[0] * 2 * np.pi) == pytest.approx(
        SEA, rel=1e-4, abs=1e-6
    )
    (tmp_path / name).write_text(text[: len(text) // 2] + "\nx")
    with pytest.raises(ConfigError, match=r"cannot be read( by wavespectra)?; needs|needs .* frequencies") as caught:
        read_spectra(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_a_folder_of_files_of_one_buoy_is_one_series(tmp_path):
    pytest.importorskip("wavespectra")
    folder = tmp_path / "buoy"
    (folder / "night").mkdir(parents=True)
    for hour, place in ((1, "."), (0, "night"), (2, ".")):
        (folder / place / f"Buoy}}2020-01-01T{hour:02d}h00Z.spt").write_text(datawell())
    (folder / ".hidden").write_text("no spectrum")
    climate = read_spectra(folder)
    assert climate.hs == pytest.approx(np.full(3, 2.0), rel=2e-2)
    assert "one record per 1 h, 0 of them not in the file" in climate.notes
    before = sha256_of(folder)
    lines = datawell().splitlines(keepends=True)
    (folder / "Buoy}2020-01-01T03h00Z.spt").write_text("".join(lines[:-1]))
    assert sha256_of(folder) != before
    with pytest.raises(ConfigError, match=r"03h00Z.spt: received other frequencies or directions than Buoy}2020-01-01"):
        read_spectra(folder)
    (folder / "Buoy}2020-01-01T03h00Z.spt").unlink()
    (folder / "readme.txt").write_text("the buoy of the year")
    with pytest.raises(ConfigError, match=r"readme.txt: received a file that is no .spt, TRIAXYS.*: move it"):
        read_spectra(folder)
    (tmp_path / "empty").mkdir()
    with pytest.raises(ConfigError, match=r"empty: received a folder of 0 files; needs 1 to"):
        read_spectra(tmp_path / "empty")


def test_a_spectrum_that_was_cut_is_not_of_the_height_its_file_states(tmp_path):
    """Datawell states Hs in the second line [cm]."""
    pytest.importorskip("wavespectra")
    path = tmp_path / "Buoy}2020-01-01T00h00Z.spt"
    path.write_text(datawell()[:-20])
    with pytest.raises(ConfigError, match=r"00Z.spt: cannot be read; needs a whole file of a Datawell buoy"):
        read_spectra(path)
    path.write_text("".join(datawell().splitlines(keepends=True)[:24]))
    with pytest.raises(ConfigError, match=r"received Hs 2 m, but its spectrum holds .* m; needs a whole file"):
        read_spectra(path)


def test_a_triaxys_file_has_a_line_for_each_frequency_it_states(tmp_path):
    pytest.importorskip("wavespectra")
    lines = triaxys(False).splitlines(keepends=True)
    for changed in (lines[:-1], [*lines, lines[-1]]):
        (tmp_path / "s.NONDIRSPEC").write_text("".join(changed))
        with pytest.raises(ConfigError, match=r"needs 42, one for each of its frequencies|cannot be read by wavespec"):
            read_spectra(tmp_path / "s.NONDIRSPEC")


def test_a_date_that_is_no_date_names_the_unit_needed(tmp_path):
    ds = spectra()
    ds = ds.assign_coords(time=("time", [0.0, 1.0], {"units": "moons since 2020-01-01"}))
    ds.to_netcdf(tmp_path / "s.nc")
    with pytest.raises(ConfigError, match=r"s.nc: received times that are no dates; needs a date for every record"):
        read_spectra(tmp_path / "s.nc")


SHIPPED = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"
HEADER = "YY MM DD hh   .050   .100   .150\n"
ROWS = "96 01 01 00   1.00   2.00   0.50\n96 01 01 01   1.50   2.50   0.25\n"
TEXT = HEADER + ROWS


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
        "#YY MM DD hh mm Sep_Freq  < spec_1 (freq_1) spec_2 (freq_2) ... >\n"
        "2020 01 01 00 00 0.1 1.00 (0.050) 2.00 (0.100) 0.50 (0.150)\n"
        "2020 01 01 01 00 0.1 1.50 (0.050) 2.50 (0.100) 0.25 (0.150)\n",
    ],
    ids=["four-digit years", "minutes", "Windows", "comments", "packed", "repeated", "missing and calm", "data_spec"],
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


def test_months_without_usable_records_put_a_year_in_doubt():
    """A sensor that failed from March to July: rows are missing, or rows without a value."""
    days = [datetime(2023, 1, 1) + timedelta(days=i) for i in range(365)]
    omega, fine = np.array([0.5, 1.0, 1.5, 2.0]), np.array([day.month < 3 or day.month > 7 for day in days])
    density = np.tile([0.5, 1.0, 0.2, 0.002], (365, 1))
    assert not any(map(is_doubt, of_records(omega, density, "file", times=days).notes))
    density[~fine, 1] = np.nan
    (doubt,) = filter(is_doubt, of_records(omega, density, "file", times=days).notes)
    assert doubt == "7 months stand for a year: seasons are missing"


def test_seasons_that_count_unequally_put_a_year_in_doubt():
    """Of eighteen months six count twice; of five years and a half they count six times for five."""
    days = [datetime(2021, 1, 1) + timedelta(days=i) for i in range(365 + 181)]
    (doubt,) = seasons(days)
    assert doubt == "July has 50% of the records a day of January, and they stand for a year: seasons count unequally"
    assert is_doubt(doubt)
    assert not seasons([datetime(2015, 1, 1) + timedelta(days=i) for i in range(5 * 365 + 182)])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "received 0 lines, needs a header"),
        ("YY MM DD hh hello\n96 01 01 00 1\n", ":1: received 'hello', needs a number"),
        ("#YY MM DD hh mm WDIR WSPD WVHT\n#yr\n20 01 01 00 00 9 2 1\n", "received the buoy's meteorological data"),
        (HEADER + ROWS + HEADER.replace(".050", ".040") + ROWS, ":4: received another header, needs one set"),
        ("YY MM DD hh 20. 10.\n96 01 01 00 1 2\n", ":1: received 2 frequencies from 20 to 10, needs them asc"),
        ("\n" + HEADER + "# a comment\n" + ROWS + "96 01 01 02 1.0\n", ":6: received 5 columns, needs 7 as the hea"),
        (TEXT + "96 01 01 02 1.0 x 2\n", ":4: received 'x', needs a number"),
        (TEXT + "96 01 01 02 1.0 -1 2\n", ":4: received -1, needs a number of 0 or more"),
        (TEXT + "96 13 01 02 1.0 1 2\n", ":4: received the date '96 13 01 02', needs YY MM DD"),
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


BANDS_NDBC = 0.03 + 0.02 * np.arange(20)


def same_header(values):
    head = "#YY  MM DD hh mm " + " ".join(f"{f:.4f}" for f in BANDS_NDBC)
    return head + "\n" + "".join(f"2020 01 01 {h:02d} 00 {' '.join(map(str, row))}\n" for h, row in enumerate(values))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (same_header(np.full((6, 20), 0.8) - 0.01 * np.arange(20)), r"numbers up to 0.8 .* coefficients r1 or r2 \(swr1"),
        (same_header(np.full((6, 20), 80) - np.arange(20)), "up to 80 with a median of 70.5, which are .* in hundredths"),
        (same_header(np.full((6, 20), 280.0) - np.arange(20)), r"which are directions in degrees \(swdir, swdir2\), no dens"),
        ("#YY MM DD hh mm alpha1_1 (freq_1) alpha1_2 (freq_2) ... >\n2020 01 01 00 00 281.0 (0.033) 290.0 (0.038)\n",
         r":1: received mean directions \(swdir\), no densities; needs the spectral wave density \(swden\)"),
    ],
)  # fmt: skip
def test_files_of_directions_are_not_read_as_densities(written, text, message):
    """Their headers are those of densities: r1 of a year read as densities was a sea of 2.35 m in place of 1.74 m."""
    with pytest.raises(ConfigError, match=message):
        read_ndbc(written(text))
    swell, wind = (5.0 * (BANDS_NDBC / f) ** -5.0 * np.exp(-1.25 * (BANDS_NDBC / f) ** -4.0) for f in (0.1, 0.2))
    broad = swell + 0.5 * wind  # its median is more than a tenth of its peak
    for sea in (0.02 * swell, swell, 20.0 * swell, 0.02 * broad, broad):  # calm seas have small densities, too
        assert read_ndbc(written(same_header(np.round(np.outer(np.ones(6), sea), 6)))).hs.size == 6


def test_a_file_most_of_whose_records_cannot_be_used_is_doubted(written):
    rows = "".join(f"96 01 01 {h:02d} 999.0 1.0 1.0\n" for h in range(2, 9))
    assert any(
        "2 of 9: more than half of the records are not used" in note for note in read_ndbc(written(TEXT + rows)).notes
    )
