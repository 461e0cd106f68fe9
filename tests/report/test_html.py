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


def test_sea_is_named_in_a_table_of_several_only():
    assert html.filled(["design", "sea"], [["A", "T3"], ["B", "T3"]]) == (["design"], [["A"], ["B"]])
    assert html.filled(["design", "sea"], [["A", "T3"], ["A", "T4"]])[0] == ["design", "sea"]


def test_missing_value_of_a_template_raises():
    with pytest.raises(jinja2.UndefinedError, match="is undefined"):
        html.page("campaign.html.j2")


def test_negative_numbers_have_one_minus_sign():
    """Numbers of text alone: no name, date, exponent, script, figure, file or study is changed."""
    text = '<p title="-1">-6.3 % (-.5 to -1e-05), 2026-11-29, VSWEC-2, up-1, -</p><pre>x: -0.8</pre><svg>-1</svg>'
    signs = text.replace(">-6.3 % (-.5 to -1e", ">\N{MINUS SIGN}6.3 % (\N{MINUS SIGN}.5 to \N{MINUS SIGN}1e")
    assert html.with_minus_signs(text) == signs
