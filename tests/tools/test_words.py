"""Numbers as people read them."""

import csv
import io

import numpy as np
import pytest
from matplotlib.figure import Figure

from vsb.errors import DatabaseError
from vsb.report.canvas import svg_text
from vsb.tools.stamps import check_table
from vsb.tools.words import against, csv_text, gains_within, plain, power, short, the_rigid, watts, watts_within


@pytest.mark.parametrize(
    ("value", "text"), [(18720.4, "18720"), (271.04, "271"), (0.19349, "0.1935"), (1e-7, "1e-07"), (-12345.0, "-12340")]
)
def test_numbers_have_four_digits_and_no_exponent(value, text):
    assert plain(value) == text


def test_powers_that_are_compared_have_one_unit():
    assert power(18720.0) == "18.72 kW"
    assert power(9999.0) == "9999 W"
    assert power(3.2e7) == "32 MW"
    assert watts([18720.0, 380.0]) == (["18.72", "0.38"], "kW")
    assert power(0.0) == "0 W"
    assert watts([380.0, 18720.0, -5.0]) == (["0.38", "18.72", "-0.005"], "kW")
    assert watts([380.0, -18720.0]) == (["0.38", "-18.72"], "kW")
    assert (power(1e4), power(9999999.0), power(1e7)) == ("10 kW", "10000 kW", "10 MW")


def test_an_interval_that_no_digit_shows_is_exact_to_them():
    """Not "4601.6 (4601.6 to 4601.6) W", as of an optimum whose errors are below its last digit."""
    assert watts_within([(4601.58, 4601.579, 4601.581), (4390.2, 4389.7, 4390.6)])[0] == [
        "4601.6 (within its last digit)", "4390.2 (4389.7 to 4390.6)",
    ]  # fmt: skip
    assert gains_within([(4.07, 4.07, 4.07)]) == ["+4.07 % (within its last digit)"]
    assert gains_within([(4.07, 4.06, 4.07)]) == ["+4.070 % (+4.060 to +4.070 %)"]


def test_gain_that_rounds_to_zero():
    assert against(0.049, "heave") == against(-0.049, "heave") == "as much as heave"
    assert against(0.05, the_rigid("rigid")) == "0.1 % more than the rigid one"
    assert against(-12.34, the_rigid("FSB")) == "12.3 % less than the rigid FSB"


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"),
        (1000.0, "1000"),
        (1e-6, "1e-06"),
        (3e7, "3e+07"),
        (999999.0, "1000000"),
        (1e6, "1e+06")],
)  # fmt: skip
def test_exponent_of_very_small_and_large_numbers(value, text):
    assert short(value) == text


def test_cells_round_trip_and_missing_ones_are_empty():
    rows = [("a, b", 1.0 / 3.0, 7, None), ('"', np.float64(1e-7), 2**60, "")]
    text = csv_text(("name", "x", "n", "none"), rows, 4)
    assert list(csv.reader(io.StringIO(text))) == [
        ["name", "x", "n", "none"], ["a, b", "0.3333", "7", ""], ['"', "1e-07", str(2**60), ""],
    ]  # fmt: skip
    assert "\r" not in text


def test_table_replaces_an_earlier_one_only(tmp_path):
    path = tmp_path / "table.csv"
    for text in (None, csv_text(("period", "gain"), [(2.5, 1.0)])):
        if text:
            path.write_text(text)
        check_table(path, ("period", "gain"))
    for other in ("my notes\n", "period,gain,note\n", "period,gai", ""):
        path.write_text(other)
        with pytest.raises(DatabaseError, match=r"table\.csv: is no earlier table of this command, and would be lost"):
            check_table(path, ("period", "gain"))
        assert path.read_text() == other


def test_figure_has_no_date():
    figure = Figure()
    figure.subplots().plot([0, 1])
    text = svg_text(figure)
    assert text.startswith("<?xml")
    assert "<dc:date>" not in text
