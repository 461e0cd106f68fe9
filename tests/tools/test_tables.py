"""Tables and figures as text."""

import csv
import io

import numpy as np
from matplotlib.figure import Figure

from vsb.tools.tables import csv_text, svg_text


def test_cells_round_trip_and_missing_ones_are_empty():
    rows = [("a, b", 1.0 / 3.0, 7, None), ('"', np.float64(1e-7), 2**60, "")]
    text = csv_text(("name", "x", "n", "none"), rows, 4)
    assert list(csv.reader(io.StringIO(text))) == [
        ["name", "x", "n", "none"], ["a, b", "0.3333", "7", ""], ['"', "1e-07", str(2**60), ""],
    ]  # fmt: skip
    assert "\r" not in text


def test_figure_has_no_date():
    figure = Figure()
    figure.subplots().plot([0, 1])
    text = svg_text(figure)
    assert text.startswith("<?xml")
    assert "<dc:date>" not in text
