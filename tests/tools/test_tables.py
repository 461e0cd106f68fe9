"""Tables and figures as text."""

import csv
import io

import numpy as np
import pytest
from matplotlib.figure import Figure

from vsb.errors import DatabaseError
from vsb.report.canvas import svg_text
from vsb.tools.stamps import check_table
from vsb.tools.words import csv_text


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
