"""Studies side by side, told: what a table leaves out, what the page says first, what its figure shows."""

import csv
import re

import numpy as np
import pytest
from browser import asked
from matplotlib.colors import to_hex

from vsb.report.side_by_side import DOUBTS, HEAD, MOST_POINTS, Line, answer, as_csv, as_page, as_text, figure

RIGID = Line("soft", "", "FSB", "wave1", "each", 100.0, 0.0, 8e3, 1.5, None)
SHELL = RIGID._replace(design="VSWEC", power_mean=90.0, gain_percent=-10.0, capture_width=1.35)
YEAR = Line("year", "scale 4", "VSWEC", "buoy", "one", 2e3, 12.34, 9e3, 2.0, 17.5)
GAS = Line("gas", "", "VSWEC", "still", "fixed", 70.0, None, 8e3, None, None)
LOST = YEAR._replace(point="scale 9", power_mean=None, gain_percent=None, damping=None, capture_width=None)
REPORTS = {"soft": ("soft/report.html", "id-1"), "year": ("year/report.html", "id-2")}


def test_a_long_sweep_is_cut_in_the_table_alone():
    many = [Line("s", f"p {i}", "A", "sea", "one", 1.0, None, None, 1.0, 2.0) for i in range(MOST_POINTS + 5)]
    text = as_text(many)
    assert text.splitlines()[-1] == "5 more lines with --out FILE.csv"
    assert "gain" not in text.splitlines()[0]
    assert len(HEAD) == len(Line._fields)
    assert len(as_csv(many).splitlines()) == len(many) + 1
    page = as_page(many, {"s": ("r.html", "id")})
    assert "5 more rows" in page
    assert len(re.findall("<tr>", page.partition("side by side</h2>")[2].partition("</table>")[0])) == 1 + MOST_POINTS


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (
            (RIGID, SHELL, YEAR),
            "brings most where VSWEC of year, scale 4, buoy takes 12.3 % more than its rigid design",
        ),
        ((RIGID, SHELL), "brings nothing here: at best, VSWEC of soft, wave1 takes 10.0 % less than its rigid design"),
        (
            (RIGID, SHELL._replace(gain_percent=0.4)),
            "Flexibility brings most where VSWEC of soft, wave1 takes 0.4 % more",
        ),
        (
            (RIGID, SHELL._replace(gain_percent=-0.4)),
            "brings nothing here: at best, VSWEC of soft, wave1 takes 0.4 % less",
        ),
        (
            (RIGID, SHELL._replace(gain_percent=-0.04)),
            "brings nothing here: at best, VSWEC of soft, wave1 takes as much as its rigid design (",
        ),
        (
            (RIGID, SHELL._replace(gain_percent=-30.0), YEAR, SHELL),
            "Flexibility brings most where VSWEC of year, scale 4, buoy takes 12.3 % more",
        ),
        (
            (RIGID, SHELL._replace(gain_percent=-30.0), SHELL),
            "brings nothing here: at best, VSWEC of soft, wave1 takes 10.0 % less",
        ),
        ((GAS,), "VSWEC of gas, still takes most: 70 W (all at the given damper)"),
        (
            (GAS, GAS._replace(design="VSWEC0", power_mean=71.0), GAS._replace(power_mean=None)),
            "VSWEC0 of gas, still takes most: 71 W (all at the given damper)",
        ),
        ((LOST,), "No design is viable."),
    ],
)
def test_the_page_begins_with_where_flexibility_brings_most(lines, said):
    assert said in answer(lines)


def test_the_figure_marks_every_number_in_its_row():
    gain, width = figure((RIGID, SHELL, YEAR, LOST)).axes
    marked = {line.get_label(): line.get_xydata() for line in gain.get_lines()}
    np.testing.assert_array_equal(marked["VSWEC"], [[-10.0, 0], [12.34, 1]])  # nothing where nothing is viable
    np.testing.assert_array_equal(marked["FSB"], [[0.0, 0]])  # a gain of nothing is a number
    np.testing.assert_array_equal(width.get_lines()[0].get_xydata(), [[1.5, 0]])
    assert [tick.get_text() for tick in gain.get_yticklabels()] == [
        "soft, wave1",
        "year, scale 4, buoy",
        "year, scale 9, buoy",
    ]
    assert marked["_zero"][:, 0].tolist() == [0.0, 0.0]
    (alone,) = figure((GAS,)).axes
    assert alone.get_xlabel() == "power [W]"


@pytest.mark.parametrize("count", [1, 4, 30])
def test_rows_of_the_figure_have_room_for_their_names_and_its_marks_from_its_edges(count):
    """Names of 8 points need more than that of height; the first and the last row have their half of it."""
    many = [YEAR._replace(sea=f"buoy {i}", gain_percent=10.0 * i + 5.0) for i in range(count)]
    ax = (drawn := figure(many)).axes[0]
    drawn.draw_without_rendering()
    bottom, top = ax.get_ylim()
    assert (bottom, top) == (count - 0.5, -0.5)
    assert 8 < 72 * ax.get_window_extent().height / drawn.dpi / count < 60
    left, right = ax.get_xlim()
    places = np.concatenate([line.get_xdata() for line in ax.get_lines()])
    assert left + 0.02 * (right - left) < places.min() <= places.max() < right - 0.02 * (right - left)


def test_the_page_needs_nothing_outside():
    page = as_page((RIGID, SHELL, YEAR), REPORTS)
    assert not re.findall(r'(?:src|href)="(?:https?:)?//', page)
    assert re.findall(r'href="(.*?report\.html)"', page) == ["soft/report.html", "year/report.html"]
    assert "id-2" in page
    assert "figures/" not in page


@pytest.mark.parametrize("width", [1100, 360])
def test_the_page_works_in_a_browser(tmp_path, width):
    script = (
        "document.querySelectorAll('th')[6].click(); const cell = document.querySelector('tbody td:nth-child(7)');"
        "return [errors, document.documentElement.scrollWidth <= innerWidth, cell.textContent];"
    )
    errors, fits, first = asked(as_page((YEAR, RIGID, SHELL), REPORTS), script, tmp_path, width)
    assert (errors, fits) == ([], True)
    assert first in ("-10.0", "+12.3")


def test_the_unit_of_dampers_is_said_once_where_it_is_one():
    """A column of the same words stood beyond the edge of the page."""
    volume = GAS._replace(damping_unit="Pa s/m³")
    alone, both = (as_text(lines).splitlines() for lines in ([RIGID, SHELL], [RIGID, SHELL, volume]))
    assert "damper [N s/m]" in alone[0]
    assert not any("N s/m" in line for line in alone[1:])
    assert both[0].endswith("damper in")
    assert both[-1].endswith("Pa s/m³")


def test_a_file_has_twelve_digits_of_every_number_and_nothing_where_there_is_none():
    precise = RIGID._replace(power_mean=12345.6789012)
    first, lost = csv.DictReader(as_csv((precise, LOST)).splitlines())
    assert (first["power_mean"], first["damping_unit"], lost["power_mean"]) == ("12345.6789012", "N s/m", "")


def test_however_many_designs_each_has_marks_of_its_own():
    """There are fewer kinds of marks, and fewer colours, than designs may be; axes say which measure they show."""
    gain, width = figure([RIGID._replace(design=f"D{k}", gain_percent=float(k)) for k in range(16)]).axes
    for ax in (gain, width):
        marks = [(to_hex(line.get_color()), line.get_marker()) for line in ax.get_lines() if line.get_label()[0] == "D"]
        assert len(set(marks)) == len(marks) == 16
    assert [ax.get_xlabel() for ax in (gain, width)] == ["gain over the rigid design [%]", "capture width [m]"]


def test_of_every_campaign_the_first_points_are_shown_with_all_their_lines():
    """Points of one name in two campaigns are two; studies, of a point each, are shown whole."""

    def swept(study):
        return [YEAR._replace(study=study, point=f"p {i}", design=d) for i in range(MOST_POINTS + 1) for d in "AB"]

    other = [line._replace(study="three", point=line.point.replace("p", "q")) for line in swept("one")]
    lines = [RIGID, *swept("one"), *swept("two"), SHELL, *other]
    text = as_text(lines).splitlines()
    assert text[-1] == "6 more lines with --out FILE.csv"
    assert len(text) == 1 + 2 + 3 * 2 * MOST_POINTS + 1
    assert not any(f"{name} {MOST_POINTS} " in line for line in text for name in "pq")
    assert [sum(line.startswith(s) for line in text) for s in ("one", "two", "soft", "three")] == [48, 48, 2, 48]


def test_a_table_has_words_to_the_left_numbers_to_the_right_and_no_column_nobody_has():
    assert as_text([RIGID, SHELL._replace(power_mean=1234.0, damping=None)]).splitlines() == [
        "study  design  sea    tuning  power [W]  gain [%]  damper [N s/m]  width [m]",
        "soft   FSB     wave1  each          100      +0.0            8000        1.5",
        "soft   VSWEC   wave1  each         1234     -10.0               -       1.35",
    ]


def test_the_answer_names_the_tuning_of_its_own_line():
    other = SHELL._replace(gain_percent=3.0, tuning="fixed")
    assert answer((RIGID, YEAR._replace(gain_percent=-3.0), other)).endswith(
        "takes 3.0 % more than its rigid design (all at the given damper)."
    )
    assert answer((RIGID, other._replace(gain_percent=0.05))).startswith("Flexibility brings most where VSWEC of soft")
    assert "at best, VSWEC of soft, wave1 takes 0.1 % less" in answer((RIGID, other._replace(gain_percent=-0.05)))


def test_a_page_names_all_it_puts_side_by_side_with_their_ids_and_says_what_to_doubt():
    page = as_page((RIGID, SHELL, YEAR), REPORTS)
    for part in ("soft", "year", "id-1", "id-2", "takes 12.3 % more than", *DOUBTS):
        assert part in page
    assert "more rows" not in page


def test_measures_of_the_figure_are_the_first_two_that_anybody_has():
    lost = YEAR._replace(gain_percent=None, capture_width=None)
    for lines, labels in (
        ([YEAR, GAS], ["gain over the rigid design [%]", "capture width [m]"]),
        ([YEAR._replace(capture_width=None), GAS], ["gain over the rigid design [%]", "power [W]"]),
        ([GAS._replace(capture_width=0.0)], ["capture width [m]", "power [W]"]),
        ([lost._replace(power_mean=None)], ["power [W]"]),
    ):
        assert [ax.get_xlabel() for ax in figure(lines).axes] == labels


def test_the_answer_of_a_page_is_of_all_points_also_of_those_its_table_leaves_out():
    many = [YEAR._replace(point=f"p {i}", gain_percent=1.0 + i) for i in range(MOST_POINTS + 3)]
    page = as_page(many, {"year": ("r.html", "id")})
    assert f"VSWEC of year, p {MOST_POINTS + 2}, buoy takes {MOST_POINTS + 3:.1f} % more" in page
    assert f"<td>p {MOST_POINTS + 2}</td>" not in page
