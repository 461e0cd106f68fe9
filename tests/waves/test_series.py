"""Series of heights and periods, counted into cells that keep their energy: text, netCDF of reanalyses and buoys."""

import numpy as np
import pytest
import xarray as xr

from vsb.engine.waves.measured_spectra import read_spectra
from vsb.engine.waves.scatter import energy_period_over, read_scatter, read_table
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError

HS, TE = [1.1, 1.3, 2.6, 1.2], [6.2, 6.8, 8.0, 6.5]
DAYS = ["2020-01-01 00:00", "2020-01-01 03:00", "2020-01-01 06:00", "2020-01-01 09:00"]
ENERGY = np.square(HS)


def text(head="time,Hm0,Te", between=",", times=DAYS):
    return (
        head + "\n" + "".join(between.join([t, f"{h}", f"{e}"]) + "\n" for t, h, e in zip(times, HS, TE, strict=True))
    )


NDBC = (
    "#YY  MM DD hh mm WDIR WSPD GST  WVHT   DPD   APD MWD\n#yr  mo dy hr mn degT m/s  m/s     m   sec   sec degT\n"
    + "".join(f"2020 01 01 {3 * i:02d} 00 999 5.0 6.0 {h} {t} 5.0 280\n" for i, (h, t) in enumerate(zip(HS, TE, strict=True)))
    + "2020 01 01 12 00 999 5.0 6.0 99.00 99.00 99.00 999\n"
)  # fmt: skip
TEXTS = {
    "dates": (text(), "te"),
    "units and decimal commas": (text("Datum;Hs [m];Te [s]", ";").replace(".", ","), "te"),
    "German dates": (text("Datum;Hs;Te", ";", [f"01.01.2020 {d[11:]}" for d in DAYS]), "te"),
    "peak periods": (text("time,Hs (m),Tp (s)"), "tp"),
    "no dates": ("Hs Tz\n" + "".join(f"{h} {t}\n" for h, t in zip(HS, TE, strict=True)), "tz"),
    "missing values": (text() + "2020-01-01 12:00,NaN,7.0\n2020-01-01 15:00,,\n2020-01-01 18:00,-999,-999\n", "te"),
}


@pytest.mark.parametrize("dialect", TEXTS)
def test_a_series_is_counted_into_cells(written, dialect):
    """Records of a bin become one sea with their mean energy and energy period, so that the flux is theirs."""
    content, kind = TEXTS[dialect]
    climate = read_scatter(written(content))
    order, ratio = np.argsort(climate.hs), energy_period_over(kind, 3.3)
    assert climate.hours[order] == pytest.approx([0.75, 0.25])
    assert climate.hs[order] == pytest.approx([np.sqrt(ENERGY[[0, 1, 3]].mean()), 2.6])
    mean = float(ENERGY[[0, 1, 3]] @ np.array(TE)[[0, 1, 3]] / ENERGY[[0, 1, 3]].sum())
    assert climate.te[order] == pytest.approx([ratio * mean, ratio * 8.0])
    kept = float(climate.hours @ (climate.hs**2 * climate.te))
    assert kept == pytest.approx(ratio * float(np.mean(ENERGY * TE)), rel=1e-12)
    deep = 1025 * 9.81**2 / (64 * np.pi) * ratio * float(np.mean(ENERGY * TE))
    assert float(climate.hours @ climate.flux(Water())) == pytest.approx(deep, rel=2e-3)


def test_average_periods_of_ndbc(written):
    """Of WVHT, DPD and APD the zero-crossing period is used: peaks jump between swell and wind sea."""
    climate = read_scatter(written(NDBC))
    assert climate.te == pytest.approx([5.0 * energy_period_over("tz", 3.3)] * 2)
    notes = "; ".join(climate.notes)
    for note in (
        "series of WVHT and APD", "5 records, 1 with missing values or no waves left out",
        "columns left out: WDIR, WSPD [m/s], GST [m/s], DPD [sec], MWD", "counted in bins of 0.5 m and 1 s", "0 days stand for a year",
    ):  # fmt: skip
        assert note in notes


def reanalysis(hs, te, **names):
    time = np.array(DAYS, dtype="datetime64[ns]")
    ds = xr.Dataset(
        {
            "swh": (("valid_time", "latitude", "longitude"), np.reshape(hs, (4, 1, 1)), {"units": "m"}),
            "mwp": (("valid_time", "latitude", "longitude"), np.reshape(te, (4, 1, 1)), {"units": "s"}),
            "pp1d": (("valid_time", "latitude", "longitude"), np.full((4, 1, 1), 9.0), {"units": "s"}),
        },
        coords={"valid_time": time, "latitude": [45.0], "longitude": [350.0], "number": 0},
    )
    return ds.rename(names)


@pytest.mark.parametrize(
    ("ds", "ratio"),
    [
        (reanalysis(HS, TE), 1.0),
        (reanalysis(HS, TE, swh="VHM0", mwp="VTM10", pp1d="VTPK", valid_time="time"), 1.0),
        (reanalysis(HS, TE, swh="VHM0", mwp="VTPK", pp1d="VMDR").drop_vars("VMDR"), energy_period_over("tp", 3.3)),
        (reanalysis(100 * np.array(HS), TE).assign(swh=lambda ds: ds.swh.assign_attrs(units="cm")), 1.0),
        (
            reanalysis(HS, TE, swh="a", mwp="b").assign(
                a=lambda ds: ds.a.assign_attrs(standard_name="sea_surface_wave_significant_height"),
                b=lambda ds: ds.b.assign_attrs(standard_name="sea_surface_wave_mean_period_from_variance_spectral_density_second_frequency_moment"),
            ).drop_vars("pp1d"),
            energy_period_over("tz", 3.3),
        ),
    ],
    ids=["ERA5", "Copernicus", "Copernicus by peak period", "centimetres", "standard names"],
)  # fmt: skip
def test_series_of_reanalyses(tmp_path, ds, ratio):
    ds.to_netcdf(tmp_path / "s.nc")
    climate = read_scatter(tmp_path / "s.nc")
    kept = float(climate.hours @ (climate.hs**2 * climate.te))
    assert kept == pytest.approx(ratio * float(np.mean(ENERGY * TE)), rel=1e-6)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (text("time,Hm0,Te [m]"), r"received Te \[m\], needs s"),
        (text("time,Hs,Tm"), "received no line that names Hs and Te or Tp"),
        (text().replace("2.6", "x"), r"given.txt:4: received 'x', needs a number, or nothing where it is missing"),
        (text().replace("2.6", "55"), "received Hs 55 m with Te 8 s in record 3, needs at most 40 m and 60 s"),
        (
            text().replace("1.1", "99").replace("1.2", "99").replace("1.3", "99").replace("2.6", "99"),
            "none with a height",
        ),
        (
            text("time,Hs,Te").replace("8.0", "2.0"),
            "25.0% of seas that are physically impossible, as Hs 2.6 m with Te 2 s",
        ),
    ],
)
def test_what_is_no_series_is_refused(written, content, message):
    with pytest.raises(ConfigError, match=message) as caught:
        read_scatter(written(content))
    assert "\n" not in str(caught.value)


def test_series_where_spectra_are_needed_are_named(written, tmp_path):
    reanalysis(HS, TE).to_netcdf(tmp_path / "s.nc")
    for path in (tmp_path / "s.nc", written(text()), written(NDBC)):
        with pytest.raises(ConfigError, match=r"climate: \{scatter: FILE\}"):
            read_spectra(path)
    two = xr.concat([reanalysis(HS, TE), reanalysis(HS, TE).assign_coords(latitude=[46.0])], dim="latitude")
    two.to_netcdf(tmp_path / "two.nc")
    with pytest.raises(
        ConfigError, match=r"received swh over .*2 along latitude.*; needs one site over time: select a"
    ):
        read_scatter(tmp_path / "two.nc")
    assert read_table(written("Hs,Te,n\n1.0,6.0,3\n")).occurrence.tolist() == [3.0]
