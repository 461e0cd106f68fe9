"""Scatter tables in the layouts of spreadsheets, and the seas made of them."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.special import gamma as gamma_function
from scipy.stats import norm, weibull_min

from vsb.engine.waves.climate import is_doubt
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.engine.waves.measured_spectra import read_spectra
from vsb.engine.waves.scatter import climate_of_cells, energy_period_over, jonswap_bands, read_scatter, read_table
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError

SHIPPED = Path(__file__).parents[2] / "config" / "climate" / "PacWave-South_Oregon_Wave-Resource.csv"
FULL = "Hs/Te,6.5,7.5\n0.25,10,20\n0.75,0,70\n"
HS, TE, SHARE = [0.25, 0.25, 0.75], [6.5, 7.5, 7.5], [0.1, 0.2, 0.7]


def test_shipped_table():
    """122 cells above zero; the file's own sum of percent."""
    climate = read_scatter(SHIPPED)
    assert climate.notes[0] == "122 occupied cells of Hs and Te, which sum to 99.82 (percent of 100)"
    assert len(climate.hs) == 122
    assert climate.notes[-1] == "JONSWAP spectra, gamma 3.3"


@pytest.mark.parametrize(
    "text",
    [
        "sep=,\nsome words, about the site\n\n" + FULL,
        FULL.encode("utf-16"),
        FULL.replace(",", " ; ").replace(".", ","),
        'Hs/Te,"6,5","7,5"\n"0,25",10,20\n"0,75",0,70\n',
        "Hs (m) / T_e (s);6,5;7,5;\n0,25;10,0;20,0;\n0,75;;70,0;\n",
        "Hs/Te,6.5,7.5,Total\n0.25,10,20,30\n0.75,0,70,70\nTotal,10,90,100\n",
        "Hs [m] vs Te [s];6,5;7,5;Sum;Cum. %\n0,25;10;20;30;30\n0,75;-;70;70;100\nSum;10;90;;\n",
        ",Te [s],,\nHs [m],6.5,7.5\n0.25,10,20\n0.75,\u2013,70\n",
        "Hm0 (m),,\nTm-10 (s),0-0.5,0.5-1\n6-7,10,0\n7-8,20,70\n",
        "Occurrence [%] of Hs and Te\n,6.5,7.5\n0.25,10,20\n0.75,,70\n",
        ";6,5;7,5\n0,25;10;20\n0,75;;70\n",
        "Hs/Te   6.5   7.5\n0.25    10    20\n0.75     0    70\n",
        "Hs/Te 6.5 7.5 Total\n<0.5 10 20 30\n0.5-1.0 0 70 70\n",
        "Hs (ft) / Te (s),6-7,>7\n0-1.640419947,10,20\n1.640419947-3.280839895,0,70\nSource: a buoy\n",
        "month,Hs,Te,depth,%\n1,0.25,6.5,20,10\n1,0.25,7.5,20,20\n1,0.75,7.5,20,30\n2,0.75,7.5,20,40\n",
        "Te/Hs,0.25,0.75\n6.5,10,0\n7.5,20,70\n",
        "Hs/Te;6,0-7,0;7 \u2013 8\n0-0,5;100;200\n0,5-1;0;700\n",
        "Hs,Te,Occurrence [%]\n0.25,6.5,10\n0.25,7.5,20\n0.75,7.5,70\n0.75,6.5,0\n",
        "Te (s);Hs (m);Hours\n6,5;0,25;876,6\n7,5;0,25;1753,2\n7,5;0,75;6136,2\n",
        "significant wave height,energy period,share\n0.25,6.5,0.1\n0.25,7.5,0.2\n0.75,7.5,0.7\n",
        "\ufeffSeegang;;\n;Te [s];\nHs [m]/Te [s];6,5;7,5\n0,25;10\u00a0%;20\u202f%\n0,75;;70\u00a0%\n;;\n",
    ],
)
def test_layouts_of_one_table(written, text):
    climate = read_scatter(written(text))
    order = np.lexsort([climate.te, climate.hs])
    assert climate.hs[order] == pytest.approx(HS)
    assert climate.te[order] == pytest.approx(TE)
    assert climate.hours[order] == pytest.approx(SHARE)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b,c\n1,2,3\n", "received no line that names Hs and Te or Tp"),
        ("\n\nHmax/Te,6.5,7.5\n0.25,10,90\n", ":3: received the corner 'Hmax/Te', needs Hs/Te, Hs/Tp or Hs/Tz"),
        (
            "Hs/Te,6.5,7.5,Total\n0.25,10,20,40\n0.75,0,70,70\n",
            ":2: received '40' in the column 'Total', needs the sum",
        ),
        ("Hs/Te,6.5,7.5\n0.25,10,20\n0.75,0,70\nSum,10,70\n", ":4: received '70' in the row 'Sum', needs .* 90$"),
        (
            "Power matrix [kW]\nHs/Te,6.5,7.5\n0.25,10,20\n",
            r":1: received 'Power matrix \[kW\]', a power matrix; needs",
        ),
        ("Hs/Te,<6,>7\n0.25,10,90\n", ":1: received open bins alone, needs the centre of a bin"),
        (",6.5,7.5\n6.5,10,20\n7.5,0,70\n", "received no line that names Hs and Te or Tp"),
        ("Hs,Te,Tp,count\n0.25,6.5,7,100\n", ":1: received both Te and Tp, needs one of them"),
        ("Hs,Te,Anteil\n0.25,6.5,1\n", ":1: received the columns 'Hs', 'Te', 'Anteil', needs one more that is"),
        ("Hs [s]/Te,6.5,7.5\n0.25,10,90\n", r":1: received the unit 's' in 'Hs \[s\]', needs m and s"),
        ("Hs/Te,6.5,7.5\n0,10,90\n", ":2: received the bin '0', needs the centre of a bin above 0"),
        ("Hs/Te,6.5,7.5\n0.25,10\n", ":2: received 2 cells, needs 3 as the header has"),
        ("a site\n\nHs/Te,6.5,7.5\n\n0.25,10,x\n", ":5: received 'x', needs an occurrence of 0 or more"),
        ("Hs/Te,6.5,7.5\n0.25,110,-10\n", ":2: received '-10', needs an occurrence of 0 or more"),
        ("Hs/Te,6.5,6.5\n0.25,10,90\n", "received columns labelled 6.5 twice, needs every bin once"),
        ("Hs,Te,count\n0.25,6.5,1\n0.25,6.5,2\n", r"received pairs labelled \(0.25, 6.5\) twice"),
        ("Hs/Te,6.5,7.5\n", ":1: received a header without rows"),
        ("Hs/Te,6.5,7.5\n0.25,0,0\n", "received no occurrence above 0"),
        ("Hs/Te,6.5,7.5\n0.25,10,47.3\n", r"received occurrences that sum to 57\.3, needs 1, 100 \(percent\)"),
        ("Hs/Te,6.5,7.5\n0.25,10%,47%\n", r"received occurrences that sum to 57, needs 100 \(percent\)"),
        ("Hs,Te,hours\n0.25,6.5,100\n", r"received occurrences that sum to 100, needs 8766 \(hours\)"),
        ("Te/Hs,6.5,7.5\n2.5,10,20\n3.5,0,70\n", "100.0% of seas that are physically impossible, as Hs 7.5 m with Te"),
        ("Hs/Te,2.5,6.5\n1.5,50,0\n7.0,0,50\n", "as Hs 1.5 m with Te 2.5 s"),  # the steepest, not the highest
        ("Hs/Te,2.5,9.5\n1.5,1.1,98.9\n", r"received 1\.1% of seas that are physically impossible, as Hs 1.5 m with"),
        (b"Hs/Te;6\xb0;7\n", "received '6°', needs the centre of a bin"),
        ('Hs/Te,6.5\n"' + "1," * 100_000, r":2: received a cell too long .*; needs all quotes closed"),
    ],
)
def test_errors_are_one_line(written, text, message):
    with pytest.raises(ConfigError, match=message) as caught:
        read_scatter(written(text))
    assert "\n" not in str(caught.value)
    assert "given.txt" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("Hs,Te,percent\n0.25,6.5,30\n0.75,7.5,70\n", "100 (percent of 100)"),
        ("Hs,Te,[h]\n0.25,6.5,2766\n0.75,7.5,6000\n", "8766 (hours of 8766)"),
        ("Hs,Te,share\n0.25,6.5,0.3\n0.75,7.5,0.719\n", "1.019 (shares of 1)"),
        ("Hs,Te,n\n0.25,6.5,3\n0.75,7.5,4\n", "7 counts"),
    ],
)
def test_sum_of_occurrences_is_noted(written, text, note):
    assert read_scatter(written(text)).notes[0] == f"2 occupied cells of Hs and Te, which sum to {note}"


def test_cells_that_are_no_numbers_are_noted(written):
    """A trace counts half its bound; a bin open at an end is as wide as its neighbour; labels one too many are edges."""
    climate = read_scatter(written("Hs/Tz,4,6,8,10\n0-1,40,20,-\n>1,<0.1,30,10\n"))
    assert climate.hours.sum() == pytest.approx(1.0)
    assert climate.hours.min() == pytest.approx(0.05 / 100.05)
    assert set(climate.hs) == {0.5, 1.5}
    assert climate.te / energy_period_over("tz", 3.3) == pytest.approx([5.0, 7.0, 5.0, 7.0, 9.0])
    assert set(climate.notes[1:]) == {
        "labels of the columns read as the edges of their bins, one more than there are cells",
        "bins that are open at an end taken as wide as their neighbours: >1",
        "1 empty cells read as none",
        "1 cells of less than a bound read as half of it",
        "Te = 1.162 Tz of these spectra",
        "JONSWAP spectra, gamma 3.3",
    }


def test_axes_that_no_corner_names_are_doubted(written):
    doubt = "the columns, of smaller numbers, read as Hs, the others as Tp, which the file does not state"
    climate = read_scatter(written("Tp (s) against Hs (m)\n\n,0.25,0.75\n6.5,10,0\n7.5,20,70\n"))
    assert doubt in climate.notes
    assert is_doubt(doubt)


@pytest.mark.parametrize("text", ["6-9", "6 \u2013 9", "6 to 9", "6..9", "6.0-9,0", "7,5"])
def test_bin_is_given_by_its_centre_or_its_ends(written, text):
    assert read_table(written(f"Hs;Te;n\n0.25;{text};1\n")).period.tolist() == [7.5]


def test_energy_period_over_others():
    """Pierson-Moskowitz in closed form, Gamma(5/4) 1.25^(-1/4), Tz = Tp (1.25 pi)^(-1/4); JONSWAP by DNV-RP-C205's fits."""
    assert energy_period_over("tp", 1.0) == pytest.approx(gamma_function(1.25) * 1.25**-0.25, abs=1e-5)
    assert energy_period_over("tp", 3.3) == pytest.approx(7.5 / 8.3, abs=1e-3)
    assert energy_period_over("tz", 1.0) / energy_period_over("tp", 1.0) == pytest.approx(1 / 0.7104, rel=1e-3)
    assert energy_period_over("tz", 3.3) / energy_period_over("tp", 3.3) == pytest.approx(1 / 0.7775, rel=2e-3)


@pytest.mark.parametrize("gamma", [1.0, 3.3])
def test_bands_hold_the_variance_of_the_spectrum(gamma):
    """Mean of a fine sampling of each band; the bands of a table hold all of the sea."""
    omega = np.linspace(0.3, 2.0, 18)
    fine = (omega[:, None] + np.linspace(-0.05, 0.05, 2001)[None]).ravel()
    sampled = np.trapezoid(jonswap_spectrum(fine, 2.0, 9.0, gamma).reshape(18, 2001), dx=0.1 / 2000, axis=1) / 0.1
    found = jonswap_bands(omega, np.array([2.0]), np.array([9.0]), gamma)[0]
    assert found == pytest.approx(sampled, abs=2e-5 * sampled.max())
    climate = climate_of_cells(np.array([2.0, 1.0]), np.array([9.0, 5.0]), np.array([0.5, 0.5]), gamma, "two")
    assert 4 * np.sqrt(climate.variance) == pytest.approx(climate.hs, rel=2e-4)


@pytest.mark.parametrize("kind", ["te", "tp"])
@pytest.mark.parametrize("gamma", [1.0, 3.3])
def test_every_cell_is_a_sea_with_its_own_height_and_period(written, kind, gamma):
    """Heights and periods in no order: variance and peak of each spectrum."""
    climate = read_scatter(written(f"Hs;{kind};n\n3.0;11;5\n1.0;6;2\n2.0;8;3\n"), gamma=gamma)
    ratio = energy_period_over("tp", gamma)
    te = np.array([11.0, 6.0, 8.0]) * (ratio if kind == "tp" else 1.0)
    assert climate.hs.tolist() == [3.0, 1.0, 2.0]
    np.testing.assert_allclose(climate.te, te, rtol=1e-12)
    np.testing.assert_allclose(climate.hours, [0.5, 0.2, 0.3], rtol=1e-12)
    np.testing.assert_allclose(4 * np.sqrt(climate.variance), climate.hs, rtol=1e-3)
    np.testing.assert_allclose(climate.omega[climate.density.argmax(axis=1)], 2 * np.pi * ratio / te, rtol=0.025)


def test_table_of_short_waves_is_its_formula():
    """Hs after Weibull, Te normal about 4.4 s (Hs/1 m)^0.35, as the README of climates says."""
    seas = read_scatter(SHIPPED.with_name("short_waves.csv"))
    height, about = weibull_min(1.4, scale=0.8 / gamma_function(1 + 1 / 1.4)), norm(4.4 * seas.hs**0.35, 0.7)
    share = (height.cdf(seas.hs + 0.25) - height.cdf(seas.hs - 0.25)) * (
        about.cdf(seas.te + 0.5) - about.cdf(seas.te - 0.5)
    )
    assert seas.hours == pytest.approx(share / share.sum(), abs=1e-4)
    assert seas.hours @ seas.hs == pytest.approx(0.8, abs=0.05)


HS_SERIES, TE_SERIES = [1.1, 1.3, 2.6, 1.2], [6.2, 6.8, 8.0, 6.5]
DAYS = ["2020-01-01 00:00", "2020-01-01 03:00", "2020-01-01 06:00", "2020-01-01 09:00"]
ENERGY = np.square(HS_SERIES)


def text(head="time,Hm0,Te", between=",", times=DAYS):
    return (
        head
        + "\n"
        + "".join(between.join([t, f"{h}", f"{e}"]) + "\n" for t, h, e in zip(times, HS_SERIES, TE_SERIES, strict=True))
    )


NDBC = (
    "#YY  MM DD hh mm WDIR WSPD GST  WVHT   DPD   APD MWD\n#yr  mo dy hr mn degT m/s  m/s     m   sec   sec degT\n"
    + "".join(f"2020 01 01 {3 * i:02d} 00 999 5.0 6.0 {h} {t} 5.0 280\n" for i, (h, t) in enumerate(zip(HS_SERIES, TE_SERIES, strict=True)))
    + "2020 01 01 12 00 999 5.0 6.0 99.00 99.00 99.00 999\n"
)  # fmt: skip
TEXTS = {
    "dates": (text(), "te"),
    "units and decimal commas": (text("Datum;Hs [m];Te [s]", ";").replace(".", ","), "te"),
    "American dates": (text(times=[f"1/31/2020 {int(d[11:13]) % 12 or 12}:00 AM" for d in DAYS]), "te"),
    "German dates": (text("Datum;Hs;Te", ";", [f"01.01.2020 {d[11:]}" for d in DAYS]), "te"),
    "peak periods": (text("time,Hs (m),Tp (s)"), "tp"),
    "no dates": ("Hs Tz\n" + "".join(f"{h} {t}\n" for h, t in zip(HS_SERIES, TE_SERIES, strict=True)), "tz"),
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
    mean = float(ENERGY[[0, 1, 3]] @ np.array(TE_SERIES)[[0, 1, 3]] / ENERGY[[0, 1, 3]].sum())
    assert climate.te[order] == pytest.approx([ratio * mean, ratio * 8.0])
    kept = float(climate.hours @ (climate.hs**2 * climate.te))
    assert kept == pytest.approx(ratio * float(np.mean(ENERGY * TE_SERIES)), rel=1e-12)
    deep = 1025 * 9.81**2 / (64 * np.pi) * ratio * float(np.mean(ENERGY * TE_SERIES))
    assert float(climate.hours @ climate.flux(Water())) == pytest.approx(deep, rel=2e-3)


def test_afternoons_are_twelve_hours_later(written):
    days = ["01/31/2020 12:00 AM", "01/31/2020 11:00 AM", "01/31/2020 12:00 PM", "01/31/2020 11:00 p.m."]
    notes = read_scatter(written(text(times=days))).notes
    assert "2020-01-31 00:00 to 2020-01-31 23:00" in notes


def test_calm_is_no_missing_value(written):
    """A sea that is flat half of the time brings half the energy, which the file cannot tell from a fault."""
    content = text() + "".join(f"2020-01-01 {h}:00,0.0,\n" for h in (12, 15, 18))
    (note,) = (note for note in read_scatter(written(content)).notes if "height 0" in note)
    assert note.startswith("3 records of height 0 left out: calm or faulty")
    assert is_doubt(note)


def test_average_periods_of_ndbc(written):
    """Of WVHT, DPD and APD the zero-crossing period is used: peaks jump between swell and wind sea."""
    climate = read_scatter(written(NDBC))
    assert climate.te == pytest.approx([5.0 * energy_period_over("tz", 3.3)] * 2)
    notes = "; ".join(climate.notes)
    for note in (
        "series of WVHT and APD", "5 records, 1 with missing values left out",
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
        (reanalysis(HS_SERIES, TE_SERIES), 1.0),
        (reanalysis(HS_SERIES, TE_SERIES, swh="VHM0", mwp="VTM10", pp1d="VTPK", valid_time="time"), 1.0),
        (reanalysis(HS_SERIES, TE_SERIES, swh="VHM0", mwp="VTPK", pp1d="VMDR").drop_vars("VMDR"), energy_period_over("tp", 3.3)),
        (reanalysis(100 * np.array(HS_SERIES), TE_SERIES).assign(swh=lambda ds: ds.swh.assign_attrs(units="cm")), 1.0),
        (
            reanalysis(HS_SERIES, TE_SERIES, swh="a", mwp="b").assign(
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
    assert kept == pytest.approx(ratio * float(np.mean(ENERGY * TE_SERIES)), rel=1e-6)


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
    reanalysis(HS_SERIES, TE_SERIES).to_netcdf(tmp_path / "s.nc")
    for path in (tmp_path / "s.nc", written(text()), written(NDBC)):
        with pytest.raises(ConfigError, match=r"climate: \{scatter: FILE\}"):
            read_spectra(path)
    two = xr.concat(
        [reanalysis(HS_SERIES, TE_SERIES), reanalysis(HS_SERIES, TE_SERIES).assign_coords(latitude=[46.0])],
        dim="latitude",
    )
    two.to_netcdf(tmp_path / "two.nc")
    with pytest.raises(
        ConfigError, match=r"received swh over .*2 along latitude.*; needs one site over time: select a"
    ):
        read_scatter(tmp_path / "two.nc")
    assert read_table(written("Hs,Te,n\n1.0,6.0,3\n")).occurrence.tolist() == [3.0]
