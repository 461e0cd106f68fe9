"""Several studies side by side: table, answer, figure, page."""

import re

import numpy as np
import pytest
from browser import asked

from vsb.report.side_by_side import HEAD, MOST_POINTS, Line, answer, as_csv, as_page, as_text, figure

RIGID = Line("soft", "", "FSB", "wave1", "each", 100.0, 0.0, 8e3, 1.5, None)
SHELL = RIGID._replace(design="VSWEC", power_mean=90.0, gain_percent=-10.0, capture_width=1.35)
YEAR = Line("year", "scale 4", "VSWEC", "buoy", "one", 2e3, 12.34, 9e3, 2.0, 17.5)
GAS = Line("gas", "", "VSWEC", "still", "fixed", 70.0, None, 8e3, None, None)
LOST = YEAR._replace(point="scale 9", power_mean=None, gain_percent=None, damping=None, capture_width=None)
REPORTS = {"soft": ("soft/report.html", "id-1"), "year": ("year/report.html", "id-2")}


def test_long_sweep_is_cut_only_in_the_table():
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
            "brings most where VSWEC of year, scale 4, buoy absorbs 12.3 % more than its rigid design",
        ),
        (
            (RIGID, SHELL),
            "brings nothing here: at best, VSWEC of soft, wave1 absorbs 10.0 % less than its rigid design",
        ),
        (
            (RIGID, SHELL._replace(gain_percent=-30.0), YEAR, SHELL),
            "Flexibility brings most where VSWEC of year, scale 4, buoy absorbs 12.3 % more",
        ),
        ((GAS,), "VSWEC of gas, still absorbs most: 70 W (all at the given damping)"),
        (
            (GAS, GAS._replace(design="VSWEC0", power_mean=71.0), GAS._replace(power_mean=None)),
            "VSWEC0 of gas, still absorbs most: 71 W (all at the given damping)",
        ),
        ((LOST,), "No design is viable."),
    ],
)
def test_answer_names_where_flexibility_helps_most(lines, said):
    assert said in answer(lines)


def test_figure_marks_every_number_in_its_row():
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


def test_page_works_in_a_browser_on_a_phone(tmp_path):
    script = (
        "document.querySelectorAll('th')[6].click(); const cell = document.querySelector('tbody td:nth-child(7)');"
        "return [errors, document.documentElement.scrollWidth <= innerWidth, cell.textContent];"
    )
    errors, fits, first = asked(as_page((YEAR, RIGID, SHELL), REPORTS), script, tmp_path, 360)
    assert (errors, fits) == ([], True)
    assert first in ("-10.0", "+12.3")


def test_table_as_text():
    assert as_text([RIGID, SHELL._replace(power_mean=1234.0, damping=None)]).splitlines() == [
        "study  design  sea    tuning  power [W]  gain [%]  damping [N s/m]  width [m]",
        "soft   FSB     wave1  each          100      +0.0             8000        1.5",
        "soft   VSWEC   wave1  each         1234     -10.0                -       1.35",
    ]
