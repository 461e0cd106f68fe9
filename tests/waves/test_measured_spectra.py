"""Spectra of other programs: netCDF by the units it states, SWAN's text, and files that are refused in one line."""

import gzip
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from vsb.errors import ConfigError
from vsb.waves.measured_spectra import read_spectra

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
    with pytest.raises(ConfigError, match=r"one.spec: cannot be read by wavespectra's read_swan .* two-dimensional"):
        read_spectra(tmp_path / "one.spec")


def test_a_file_for_wavespectra_names_it_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "wavespectra", None)
    with pytest.raises(
        ConfigError, match=r"swan\.spec: received spectra as swan writes them, needs the package wavesp"
    ):
        read_spectra(WRITTEN / "swan.spec")
