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


def test_figures_are_told_by_their_kind_and_their_sea():
    one, other = html.captioned({"a-w-1": "<?xml?><svg/>", "b": "<svg>2</svg>"}, {"a": "of a sea", "b": "of all"})
    assert one == {"name": "a-w-1", "caption": "of a sea", "sea": "w-1", "svg": "<svg/>"}
    assert (other["sea"], other["caption"]) == ("", "of all")


def test_a_value_a_page_lacks_raises():
    with pytest.raises(jinja2.UndefinedError, match="is undefined"):
        html.page("campaign.html.j2")


def test_looks_are_said_once():
    assert [path.name for path in TEMPLATES.iterdir() if "<style" in path.read_text()] == ["page.html.j2"]
    assert [path.name for path in TEMPLATES.iterdir() if "<table>" in path.read_text()] == ["cells.html.j2"]
