import csv
import io

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from vsb.tools.tables import csv_text, svg_text


def test_cells_of_a_table_are_read_as_they_were_and_what_is_not_there_is_empty():
    rows = [("a, b", 1.0 / 3.0, 7, None), ('"', np.float64(1e-7), 2**60, "")]
    text = csv_text(("name", "x", "n", "none"), rows, 4)
    assert list(csv.reader(io.StringIO(text))) == [
        ["name", "x", "n", "none"], ["a, b", "0.3333", "7", ""], ['"', "1e-07", str(2**60), ""],
    ]  # fmt: skip
    assert "\r" not in text


def test_a_table_without_rows_has_its_head():
    assert csv_text(("a", "b"), []) == "a,b\n"


def test_a_figure_is_the_same_text_at_any_time():
    figure = Figure()
    figure.subplots().plot([0, 1])
    text = svg_text(figure)
    assert text.startswith("<?xml")
    assert "<dc:date>" not in text


def test_a_figure_is_drawn_once_to_what_saving_it_would_write(monkeypatch):
    """`savefig` lays a figure out by drawing all of it once more."""
    text, drawn = io.StringIO(), []

    def figure():
        one = Figure(layout="constrained")
        one.subplots(2, 1)[1].set(xlabel="time [s]", yscale="log", title="above")
        return one

    with mpl.rc_context({"svg.hashsalt": "same"}):
        figure().savefig(text, format="svg", metadata={"Date": None})
        other, draw = figure(), Figure.draw
        monkeypatch.setattr(Figure, "draw", lambda self, renderer: drawn.append(draw(self, renderer)))
        dpi = other.dpi
        assert svg_text(other) == text.getvalue()
    assert len(drawn) == 1
    assert other.dpi == dpi


def test_numbers_of_a_table_have_ten_digits_unless_asked_otherwise():
    for kind in (float, np.float64):
        assert csv_text(("a",), [(kind(2.0 / 3.0),), (kind(-1e-9),), (kind(12345678901.5),), (True,)]) == (
            "a\n0.6666666667\n-1e-09\n1.23456789e+10\nTrue\n"
        )


def test_a_figure_keeps_its_resolution_whatever_it_was():
    figure = Figure(dpi=173.0)
    figure.subplots().plot([0, 1])
    svg_text(figure)
    assert figure.dpi == 173.0
