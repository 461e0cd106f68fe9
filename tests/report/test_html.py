import csv
import io
import re
import urllib.parse
from pathlib import Path

import jinja2
import pytest

from vsb.report import html

TEMPLATES = Path(html.__file__).parent / "templates"


def test_a_table_can_be_kept_as_it_is_read():
    body = [['a "b", c', "1 %"], ["<i>", "2"]]
    link = html.csv_link("t", ["x", "y"], body)
    data = re.search(r'href="data:text/csv;charset=utf-8,([^"]*)"', link)[1]
    assert list(csv.reader(io.StringIO(urllib.parse.unquote(data)))) == [["x", "y"], *body]


def test_a_column_of_dashes_is_left_out():
    assert html.filled(["x", "y", "z"], [["-", "-", "1"], ["2", "-", "-"]]) == (["x", "z"], [["-", "1"], ["2", "-"]])


def test_of_a_table_without_rows_no_column_is_left():
    """None holds anything; one cell is enough to keep a column."""
    assert html.filled(["x", "y"], []) == ([], [])
    assert html.filled(["x", "y"], [["-", "-"], ["-", "0"]]) == (["y"], [["-"], ["0"]])


def test_figures_are_told_by_their_kind_and_their_sea():
    svgs = {"b": "<svg>2</svg>", "a-w-1": "<?xml?><svg/>", "a-v": "<svg/>"}
    of_all, first, second = html.captioned(svgs, {"a": "of a sea", "b": "of all"}, {"v": "a chop"})
    assert of_all == {
        "sea": "", "open": False,
        "figures": [{"name": "b", "number": 1, "caption": "of all", "svg": "<svg>2</svg>"}],
    }  # fmt: skip
    assert [(group["sea"], group["open"]) for group in (first, second)] == [("w-1", True), ("a chop", False)]
    assert first["figures"] == [{"name": "a-w-1", "number": 2, "caption": "of a sea", "svg": "<svg/>"}]


def test_a_page_stays_light_whatever_the_number_of_figures(monkeypatch):
    monkeypatch.setattr(html, "INLINE", 20)
    ((drawn, left),) = (
        group["figures"] for group in html.captioned(dict.fromkeys("ab", "<svg>....</svg>"), {"a": "", "b": ""})
    )
    assert (drawn["svg"], left["svg"]) == ("<svg>....</svg>", "")


def test_a_value_a_page_lacks_raises():
    with pytest.raises(jinja2.UndefinedError, match="is undefined"):
        html.page("campaign.html.j2")


def test_looks_are_said_once():
    assert [path.name for path in TEMPLATES.iterdir() if "<style" in path.read_text()] == ["page.html.j2"]
    assert [path.name for path in TEMPLATES.iterdir() if path.suffix == ".css"] == ["style.css"]
    assert [path.name for path in TEMPLATES.iterdir() if "<table>" in path.read_text()] == ["cells.html.j2"]


@pytest.mark.parametrize(("room", "shown"), [(13, True), (12, False)])
def test_room_on_a_page_is_counted_in_bytes_of_what_stands_on_it(monkeypatch, room, shown):
    """An umlaut has two, what stands before the drawing none; the last byte of the room may be taken."""
    monkeypatch.setattr(html, "INLINE", room)
    ((one,),) = (group["figures"] for group in html.captioned({"a-w": "<?xml?><svg>\xe4</svg>"}, {"a": ""}))
    assert one["svg"] == ("<svg>\xe4</svg>" if shown else "")
