import csv
import io

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
