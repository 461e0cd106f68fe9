"""Tables and figures in HTML."""

import csv
import io
import re
import urllib.parse

import jinja2
import pytest

from vsb.report import html


def test_table_can_be_downloaded():
    body = [['a "b", c', "1 %"], ["<i>", "2"]]
    link = html.csv_link("t", ["x", "y"], body)
    data = re.search(r'href="data:text/csv;charset=utf-8,([^"]*)"', link)[1]
    assert list(csv.reader(io.StringIO(urllib.parse.unquote(data)))) == [["x", "y"], *body]


def test_empty_columns_are_left_out():
    assert html.filled(["x", "y", "z"], [["-", "-", "1"], ["2", "-", "-"]]) == (["x", "z"], [["-", "1"], ["2", "-"]])


def test_figures_are_grouped_by_sea():
    svgs = {"b": "<svg>2</svg>", "a-w-1": "<?xml?><svg/>", "a-v": "<svg/>"}
    of_all, first, second = html.captioned(svgs, {"a": "of a sea", "b": "of all"}, {"v": "a chop"})
    assert of_all == {
        "sea": "", "open": False,
        "figures": [{"name": "b", "number": 1, "caption": "of all", "svg": "<svg>2</svg>", "folded": ""}],
    }  # fmt: skip
    assert [(group["sea"], group["open"]) for group in (first, second)] == [("w-1", True), ("a chop", False)]
    assert first["figures"] == [{"name": "a-w-1", "number": 2, "caption": "of a sea", "svg": "<svg/>", "folded": ""}]


def test_figures_for_specialists_are_folded():
    svgs, captions = {"energy_audit-w": "<svg/>"}, {"energy_audit": "balance"}
    assert html.captioned(svgs, captions)[0]["figures"][0]["folded"] == "Energy balance"


def test_missing_value_of_a_template_raises():
    with pytest.raises(jinja2.UndefinedError, match="is undefined"):
        html.page("campaign.html.j2")
