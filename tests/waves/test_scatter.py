"""Scatter tables in the dialects of spreadsheets, and the seas made of them."""

from pathlib import Path

import numpy as np
import pytest
from scipy.special import gamma as gamma_function

from vsb.errors import ConfigError
from vsb.waves.scatter import (
    _kind,
    _plain,
    climate_of_cells,
    energy_over_peak_period,
    jonswap_bands,
    read_scatter,
    read_table,
)
from vsb.waves.seas import jonswap_spectrum

SHIPPED = Path(__file__).parents[2] / "config" / "climate" / "PacWave-South_Oregon_Wave-Resource.csv"
FULL = "Hs/Te,6.5,7.5\n0.25,10,20\n0.75,0,70\n"
HS, TE, SHARE = [0.25, 0.25, 0.75], [6.5, 7.5, 7.5], [0.1, 0.2, 0.7]


def test_the_shipped_table():
    """122 cells above zero; the file's own sum of percent."""
    climate = read_scatter(SHIPPED)
    assert climate.notes[0] == "122 occupied cells of Hs and Te, which sum to 99.82 (percent of 100)"
    assert len(climate.hs) == 122
    assert climate.notes[-1] == "JONSWAP spectra, gamma 3.3"


@pytest.mark.parametrize(
    "text",
    [
        FULL,
        "some words, about the site\n\n" + FULL,
        "some words; about the site,\n" + FULL,
        "\ufeff" + FULL,
        FULL.encode("utf-16"),
        FULL.replace("\n", "\r\n"),
        FULL.replace(",", "\t"),
        FULL.replace(",", ";").replace(".", ","),
        FULL.replace(",", " ; ").replace(".", ","),
        'Hs/Te,"6,5","7,5"\n"0,25",10,20\n"0,75",0,70\n',
        "Hm0 [m] \\ Te [s],6.5,7.5\n0.25,10%,20 %\n0.75,0%,70%\n",
        "Hs (m) / T_e (s);6,5;7,5;\n0,25;10,0;20,0;\n0,75;;70,0;\n",
        "Te/Hs,0.25,0.75\n6.5,10,0\n7.5,20,70\n",
        "Hs/Te,6-7,7-8\n0-0.5,0.1,0.2\n0.5-1,0,0.7\n",
        "Hs/Te;6,0-7,0;7 \u2013 8\n0-0,5;100;200\n0,5-1;0;700\n",
        "Hs,Te,Occurrence [%]\n0.25,6.5,10\n0.25,7.5,20\n0.75,7.5,70\n0.75,6.5,0\n",
        "Te (s);Hs (m);Hours\n6,5;0,25;876,6\n7,5;0,25;1753,2\n7,5;0,75;6136,2\n",
        "significant wave height,energy period,share\n0.25,6.5,0.1\n0.25,7.5,0.2\n0.75,7.5,0.7\n",
        "Hs,Te,n\n0.25,6.5,1\n0.25,7.5,2\n0.75,7.5,7\n",
        "Te/Tp,in words\nHs,Te,n\n0.25,6.5,10%\n0.25,7.5,20 %\n0.75,7.5,70%\n",
        "sep=;\nHs/Te;6,5;7,5\n0,25;10;20\n0,75;0;70\n",
        "\ufeffSeegang;;\n;Te [s];\nHs [m]/Te [s];6,5;7,5\n0,25;10\u00a0%;20\u202f%\n0,75;;70\u00a0%\n;;\n",
        "Hs/Te,6.5,7.5\n2.5E-01,1.0E+01,2.0E+01\n7.5E-01,0,7.0E+01\n",
    ],
)
def test_one_table_in_many_dialects(written, text):
    climate = read_scatter(written(text))
    order = np.lexsort([climate.te, climate.hs])
    assert climate.hs[order] == pytest.approx(HS)
    assert climate.te[order] == pytest.approx(TE)
    assert climate.hours[order] == pytest.approx(SHARE)


def test_empty_cells_are_said(written):
    table = read_table(written("Hs/Te,6.5,7.5\n0.25,10,20\n0.75,,70\n"))
    assert table.blank == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hello", "received no line that names Hs and Te or Tp"),
        ("a,b,c\n1,2,3\n", "received no line that names Hs and Te or Tp"),
        ("Hs/Tz,6.5,7.5\n0.25,10,90\n", "line 1: received the corner 'Hs/Tz', needs Hs/Te or Hs/Tp"),
        ("Hs/Hm0,6.5,7.5\n0.25,10,90\n", "line 1: received the corner 'Hs/Hm0', needs Hs/Te or Hs/Tp"),
        ("Te/Tp,6.5,7.5\n0.25,10,90\n", "received no line that names Hs and Te or Tp"),
        ("Hs,percent\n0.25,100\n", "received no line that names Hs and Te or Tp"),
        ("Hs [m] (ft)/Te,6.5,7.5\n0.25,10,90\n", r"line 1: received the unit 'ft' in 'Hs \[m\] \(ft\)', needs m and s"),
        ("Hs,Te,,Anteil\n0.25,6.5,,1\n", "line 1: received the columns 'Hs', 'Te', 'Anteil', needs one more"),
        ("Hs,Te,n\n0.25,6.5,10%\n0.75,6.5,47%\n", r"received occurrences that sum to 57, needs 100 \(percent\)"),
        ("Hs,Te,n\n0.25,6.5\n0.75,6.5,100%\n", "line 2: received 2 cells, needs 3 as the header has"),
        ("Hs [ft]/Te,6.5,7.5\n0.25,10,90\n", r"line 1: received the unit 'ft' in 'Hs \[ft\]', needs m and s"),
        ("Hs/Te,6.5,7.5,Total\n0.25,10,90,100\n", "line 1: received 'Total', needs the centre of a bin"),
        ("Hs/Te,6.5,7.5\n0.25,10,90\nSum,10,90\n", "line 3: received 'Sum', needs the centre of a bin"),
        ("Hs/Te,6.5,7.5\n0,10,90\n", "line 2: received the bin '0', needs the centre of a bin above 0"),
        ("Hs/Te,6.5,7.5\n0.25,10\n", "line 2: received 2 cells, needs 3 as the header has"),
        ("Hs/Te,6.5,7.5\n0.25,10,80,10\n", "line 2: received 4 cells, needs 3 as the header has"),
        ("Hs/Te,6.5,7.5\n0.25,10,x\n", "line 2: received 'x', needs an occurrence of 0 or more"),
        ("Hs/Te,6.5,7.5\n0.25,10,many %\n", "line 2: received 'many', needs an occurrence of 0 or more"),
        ("Hs/Te,6.5,7.5\n0.25,10,-10 %\n", "line 2: received '-10 %', needs an occurrence of 0 or more"),
        ("Hs/Te,6.5,7.5\n0.25,110,-10\n", "line 2: received '-10', needs an occurrence of 0 or more"),
        ('Hs/Te,6.5,7.5\n0.25,1.000,5\n0.75,"1,000.5",1\n', "line 3: received '1,000.5', needs an occurrence"),
        ("Hs/Te,6.5,6.5\n0.25,10,90\n", "received columns labelled 6.5 twice, needs every bin once"),
        ("Hs/Te,6.5,7.5\n0.25,10,40\n0.25,10,40\n", "received rows labelled 0.25 twice, needs every bin once"),
        ("Hs/Te,6.5,7.5\n", "line 1: received a header without rows"),
        ("Hs/Te,6.5,7.5\n0.25,0,0\n", "received no occurrence above 0"),
        ("Hs/Te,6.5,7.5\n0.25,10,47.3\n", r"received occurrences that sum to 57\.3, needs 1, 100 \(percent\)"),
        ("Hs/Te,6.5,7.5\n0.25,10%,47%\n", r"received occurrences that sum to 57, needs 100 \(percent\)"),
        ("Hs,Te,hours\n0.25,6.5,100\n", r"received occurrences that sum to 100, needs 8766 \(hours\)"),
        ("Hs,Te,Tp,count\n0.25,6.5,7,100\n", "line 1: received both Te and Tp, needs one of them"),
        (
            "Hs;Te;Anteil\n0,25;6,5;1\n",
            "line 1: received the columns 'Hs', 'Te', 'Anteil', needs one more that is called",
        ),
        ("Hs/Te;6,5;7,5\n0,25;3.506;5.26\n", r"received occurrences that sum to 8\.766, needs 1, 100"),
        ("Hs/Te,<6,6-7\n0.25,10,90\n", "line 1: received '<6', needs the centre of a bin"),
        ("Hs/Te,6.5,7.5\n0.25,NaN,100\n", "line 2: received 'NaN', needs an occurrence"),
        ("Hs,Te,count\n0.25,6.5,1\n0.25,6.5,2\n", r"received pairs labelled \(0.25, 6.5\) twice"),
        ("Hs,Te,count\n0.25,6.5\n", "line 2: received 2 cells, needs 3 as the header has"),
        ("Hs,Te [min],count\n0.25,6.5,1\n", "line 1: received the unit 'min'"),
        (
            "Te/Hs,6.5,7.5\n2.5,10,20\n3.5,0,70\n",
            "100.0% of seas that cannot be, as Hs 7.5 m with Te 2.5 s; needs Hs in m",
        ),
        (b"Hs/Te;6\xb0;7\n", "byte 7 that is no text, needs UTF-8"),
    ],
)
def test_refused_in_one_line(written, text, message):
    with pytest.raises(ConfigError, match=message) as caught:
        read_scatter(written(text))
    assert "\n" not in str(caught.value)
    assert "given.txt" in str(caught.value)


@pytest.mark.parametrize(("column", "total"), [
    ("Occurrence [%]", 100.0), ("hours", 8766.0), ("share", 1.0), ("[ % ]", 100.0), ("( H )", 8766.0), ("[h]", 8766.0),
])  # fmt: skip
@pytest.mark.parametrize("side", [1, -1])
def test_occurrences_may_miss_their_sum_by_two_percent(written, column, total, side):
    """A column may be called by its unit alone, in brackets."""

    def given(miss):
        return written(f"Hs,Te,{column}\n0.25,6.5,{0.4 * total}\n0.75,7.5,{(0.6 + side * miss) * total}\n")

    assert read_scatter(given(0.0199)).hours.sum() == pytest.approx(1.0)
    with pytest.raises(ConfigError, match=rf"received occurrences that sum to [\d.]+, needs {total:g} \("):
        read_scatter(given(0.0201))


def test_a_hundredth_of_a_table_may_be_impossible(written):
    assert len(read_scatter(written("Hs/Te,2.5,9.5\n1.5,0.9,99.1\n")).hs) == 2
    with pytest.raises(ConfigError, match=r"received 1\.1% of seas that cannot be, as Hs 1.5 m with Te 2.5 s"):
        read_scatter(written("Hs/Te,2.5,9.5\n1.5,1.1,98.9\n"))


def test_bands_reach_from_below_the_longest_peak_to_ten_times_the_shortest():
    climate = climate_of_cells(np.array([2.0, 1.0]), np.array([9.0, 5.0]), np.array([0.5, 0.5]), 1.0, "two")
    peaks = 2 * np.pi / np.array([9.0, 5.0]) * energy_over_peak_period(1.0)
    assert climate.omega[[0, -1]] == pytest.approx([0.45 * peaks[0], 10 * peaks[1]])
    steps = np.diff(np.log(climate.omega))
    assert np.ptp(steps) < 1e-12
    assert 0.019 < steps[0] <= 0.02


def test_energy_over_peak_period():
    """Pierson-Moskowitz in closed form, Gamma(5/4) 1.25^(-1/4); JONSWAP by DNV-RP-C205's (4.2 + g)/(5 + g)."""
    assert energy_over_peak_period(1.0) == pytest.approx(gamma_function(1.25) * 1.25**-0.25, abs=1e-5)
    assert energy_over_peak_period(3.3) == pytest.approx(7.5 / 8.3, abs=1e-3)


@pytest.mark.parametrize("gamma", [1.0, 3.3])
def test_bands_hold_the_variance_of_the_spectrum(gamma):
    """Mean of a fine sampling of each band; the bands of a table hold all of the sea."""
    omega = np.linspace(0.3, 2.0, 18)
    fine = (omega[:, None] + np.linspace(-0.05, 0.05, 2001)[None]).ravel()
    sampled = np.trapezoid(jonswap_spectrum(fine, 2.0, 9.0, gamma).reshape(18, 2001), dx=0.1 / 2000, axis=1) / 0.1
    assert jonswap_bands(omega, np.array([2.0]), np.array([9.0]), gamma)[0] == pytest.approx(
        sampled, abs=2e-5 * sampled.max()
    )
    climate = climate_of_cells(np.array([2.0, 1.0]), np.array([9.0, 5.0]), np.array([0.5, 0.5]), gamma, "two")
    assert 4 * np.sqrt(climate.variance) == pytest.approx(climate.hs, rel=2e-4)


def test_peak_periods_become_energy_periods(written):
    climate = read_scatter(written("Hs/Tp,8\n1.25,100\n"), gamma=2.0)
    assert climate.te == pytest.approx([8 * energy_over_peak_period(2.0)])
    assert climate.omega[climate.density[0].argmax()] == pytest.approx(2 * np.pi / 8, rel=0.02)


def test_pierson_moskowitz_is_jonswap_without_its_peak(written):
    path = written("Hs/Tp,8\n1.25,100\n")
    assert read_scatter(path, "pierson_moskowitz").density == pytest.approx(read_scatter(path, gamma=1.0).density)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Hs,Te,percent\n0.25,6.5,30\n0.75,7.5,70\n", "100 (percent of 100)"),
        ("Hs,Te,share\n0.25,6.5,0.3\n0.75,7.5,0.7\n", "1 (shares of 1)"),
        ("Hs,Te,hours\n0.25,6.5,2766\n0.75,7.5,6000\n", "8766 (hours of 8766)"),
        ("Hs,Te,n\n0.25,6.5,3\n0.75,7.5,4\n", "7 counts"),
        ("Hs,Te,n,share\n0.25,6.5,3,0.3\n0.75,7.5,4,0.7\n", "7 counts"),  # the first of two columns
    ],
)
def test_what_occurrences_sum_to_is_said(written, text, said):
    assert read_scatter(written(text)).notes[0] == f"2 occupied cells of Hs and Te, which sum to {said}"


def test_all_rows_of_a_full_table_are_looked_at(written):
    """Empty cells of three rows, percent in the first alone, two empty columns at the end of the header."""
    table = read_table(written("Hs/Te,6.5,7.5,,\n0.25,10%,20,,\n0.5,,30,,\n0.75,,40\n1.0,,\n"))
    assert table.blank == 4
    assert table.unit == 100.0
    assert table.occurrence.tolist() == [10.0, 20.0, 30.0, 40.0]
    assert table.hs.tolist() == [0.25, 0.25, 0.5, 0.75]
    assert table.period.tolist() == [6.5, 7.5, 7.5, 7.5]


def test_empty_cells_are_a_note_of_the_climate_where_there_are_any(written):
    with_peak = read_scatter(written("Hs/Tp,6.5,7.5\n0.25,10,20\n0.75,,70\n"), "pierson_moskowitz")
    assert with_peak.notes == (
        "3 occupied cells of Hs and Tp, which sum to 100 (percent of 100)",
        "1 empty cells read as none",
        "Pierson-Moskowitz spectra",
    )
    assert read_scatter(written(FULL), gamma=2.0).notes == (
        "3 occupied cells of Hs and Te, which sum to 100 (percent of 100)",
        "JONSWAP spectra, gamma 2",
    )


def test_percent_of_a_list_of_pairs_may_stand_in_any_row(written):
    table = read_table(written("Hs,Te,n\n0.25,6.5,10\n0.75,7.5,90%\n"))
    assert table.unit == 100.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Hs/Te [min],6.5,7.5\n0.25,10,90\n", r"line 1: received the unit 'min' in 'Te \[min\]', needs m and s"),
        ("Hs/Te,6.5\n0.2,10\n0.3,40\n0.4,30\n0.3,20\n", "received rows labelled 0.3 twice, needs every bin once"),
        ("Hs/Te,6.5,7.5\n0.25,inf,1\n", "line 2: received 'inf', needs an occurrence of 0 or more"),
        ("Hs/Te,6.5,inf\n0.25,1,1\n", "line 1: received 'inf', needs the centre of a bin above 0"),
    ],
)
def test_what_is_wrong_behind_the_first_is_refused_as_well(written, text, message):
    with pytest.raises(ConfigError, match=message):
        read_scatter(written(text))


def test_the_steepest_cell_is_named_by_the_period_of_the_table(written):
    """Judged by its energy period, nine tenths of the peak's: 5.05 m high waves of 6 s are too steep by it alone."""
    peak, hs = 6.0, 5.05
    te = peak * energy_over_peak_period(3.3)
    assert 2 * np.pi * hs / (9.81 * peak**2) < 0.1 < 2 * np.pi * hs / (9.81 * te**2)
    with pytest.raises(
        ConfigError, match=r"received 50\.0% of seas that cannot be, as Hs 5\.05 m with Tp 6 s; needs Hs"
    ):
        read_scatter(written("Hs,Tp,share\n9,16,0.5\n5.05,6,0.5\n"))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *((name, "hs") for name in ("Hs", "Hm0", "H_sig", "H13", "Significant Wave Height", "wave height (m)", "H_{s}")),
        *((name, "te") for name in ("Te", "Tm-10", "T m10", "Tm-1,0", "Energy period", "mean energy period [s]",
                                    "wave energy period")),
        *((name, "tp") for name in ("Tp", "Peak Period", "wave peak period", "T_p (sec)")),
        *((name, None) for name in ("Tz", "Tm02", "height", "period", "")),
    ],
)  # fmt: skip
def test_heights_and_periods_have_many_names(name, kind):
    assert _kind(_plain(name)) == kind


@pytest.mark.parametrize(("name", "unit"), [
    ("Occurrence", None), ("occurrences", None), ("Percent", 100.0), ("Percentage", 100.0), ("%", 100.0), ("Hours", 8766.0),
    ("h", 8766.0), ("Count", None), ("counts", None), ("frequency", None), ("Share", 1.0), ("probability", None),
    ("N", None), ("Number", None), ("hits", None), ("Occ", None), ("Occurrence (%)", 100.0),
])  # fmt: skip
def test_how_often_has_many_names_and_some_say_what_it_sums_to(written, name, unit):
    table = read_table(written(f"Hs;Te;{name}\n0.25;6.5;1\n0.75;7.5;3\n"))
    assert (table.unit, table.kind, table.blank) == (unit, "te", 0)
    assert table.occurrence.tolist() == [1.0, 3.0]


@pytest.mark.parametrize("unit", ["m", "s", "sec", "metres", "Meters", "seconds", "%", "h", "-", "", " S "])
def test_units_in_brackets_are_those_of_metres_and_seconds(written, unit):
    for brackets in ("[]", "()"):
        named = f"Hs {brackets[0]}{unit}{brackets[1]}"
        assert read_table(written(f"{named};Te;n\n0.25;6.5;1\n")).hs.tolist() == [0.25]
        assert read_table(written(f"{named}/Te;6.5\n0.25;1\n")).period.tolist() == [6.5]
        with pytest.raises(ConfigError, match=r"line 1: received the unit 'cm' in 'Hs .*cm.*', needs m and s"):
            read_table(written(f"Hs {brackets[0]}cm{brackets[1]};Te;n\n0.25;6.5;1\n"))


@pytest.mark.parametrize("range_", ["6-9", "6 - 9", "6\u20139", "6 to 9", "6..9", "6...9", "6.0-9,0", "7.5", "7,5"])
def test_a_bin_is_told_by_its_centre_or_its_ends(written, range_):
    assert read_table(written(f"Hs;Te;n\n0.25;{range_};1\n")).period.tolist() == [7.5]
    assert read_table(written(f"Hs/Te;{range_}\n0.25;1\n")).period.tolist() == [7.5]


@pytest.mark.parametrize("kind", ["te", "tp"])
@pytest.mark.parametrize("gamma", [1.0, 2.0, 3.3])
def test_every_cell_is_a_sea_of_its_own_height_and_period(written, kind, gamma):
    """Two heights and two periods that are not in order: each spectrum's own variance and peak."""
    climate = read_scatter(written(f"Hs;{kind};n\n3.0;11;5\n1.0;6;2\n2.0;8;3\n"), gamma=gamma)
    ratio = energy_over_peak_period(gamma)
    te = np.array([11.0, 6.0, 8.0]) * (ratio if kind == "tp" else 1.0)
    assert climate.hs.tolist() == [3.0, 1.0, 2.0]
    np.testing.assert_allclose(climate.te, te, rtol=1e-12)
    np.testing.assert_allclose(climate.hours, [0.5, 0.2, 0.3], rtol=1e-12)
    np.testing.assert_allclose(4 * np.sqrt(climate.variance), climate.hs, rtol=1e-3)
    np.testing.assert_allclose(climate.omega[climate.density.argmax(axis=1)], 2 * np.pi * ratio / te, rtol=0.025)
    assert climate.name == "given.txt"
    assert climate.notes[-1] == f"JONSWAP spectra, gamma {gamma:g}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a site\n\nHs/Te,6.5,7.5\n\n0.25,10,x\n", "line 5: received 'x', needs an occurrence of 0 or more"),
        ("a site\n\n\nHs,Te,n\n0.25,6.5,1\n,,\n0.75,6.5,-1\n", "line 7: received '-1', needs an occurrence of 0"),
        ("\n\nHs/Tz,6.5,7.5\n0.25,10,90\n", "line 3: received the corner 'Hs/Tz', needs Hs/Te or Hs/Tp"),
        ("\nHs [ft],Te,n\n0.25,6.5,1\n", r"line 2: received the unit 'ft' in 'Hs \[ft\]', needs m and s"),
        ("\n\nHs/Te,6.5,wide\n0.25,10,90\n", "line 3: received 'wide', needs the centre of a bin above 0"),
        (
            '"a site\nof two lines",\nHs/Te,6.5,7.5\n0.25,10,x\n',
            "line 4: received 'x', needs an occurrence of 0 or more",
        ),
    ],
)
def test_lines_are_those_of_the_file_empty_ones_too(written, text, message):
    with pytest.raises(ConfigError, match=rf"given\.txt, {message}"):
        read_scatter(written(text))


@pytest.mark.parametrize("text", ['"' + "1," * 100_000, "1" * 200_000])
def test_a_cell_longer_than_any_is_no_table(written, text):
    """As of a quotation mark that is never closed."""
    needs = r"received a cell too long \(field larger than field limit .*\); needs all quotes closed$"
    with pytest.raises(ConfigError, match=rf"given\.txt, line 2: {needs}"):
        read_scatter(written(f"Hs/Te,6.5\n{text}"))


@pytest.mark.parametrize("cell", ["(" * 120_000 + "/Te", "Hs/" + "[" * 120_000, "1" + "." * 120_000])
def test_a_cell_of_any_length_is_read_in_no_time(written, cell):
    for text in (f"{cell},6.5\n0.25,100\n", f"Hs/Te,{cell}\n0.25,100\n"):
        with pytest.raises(ConfigError) as error:
            read_table(written(text))
        assert len(str(error.value)) < 500


def test_records_in_the_place_of_bins_are_refused(written):
    rows = "".join(f"{0.5 + 1e-5 * i:.5f},8.0,1\n" for i in range(100_000))
    with pytest.raises(ConfigError, match="received 100000 bins, needs at most 10000"):
        read_table(written("Hs,Te,count\n" + rows))
