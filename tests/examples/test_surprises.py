"""Surprises of the fair comparison: the page says what the script finds."""

import re

import pytest
from conftest import HERE, told

from examples import surprises

PAGE = (HERE.parent / "docs" / "surprises.md").read_text()
CHEAP = [name for name in surprises.CASES if name not in ("latching", "the_paper", "same_limit")]
"""Cases of one database, and of no motion in time."""


def told_on_the_page(name):
    """The figures of a case as the page has them."""
    (table,) = re.findall(rf"\| `{name}` \| \|\n\|---\|---\|\n((?:\|.*\|\n)+)", PAGE)
    return {key: float(value) for key, value in re.findall(r"\| (.*) \| (.*) \|", table)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("surprises")


@pytest.fixture
def at_home(monkeypatch):
    """The shipped studies are named from there."""
    monkeypatch.chdir(HERE.parent)


@pytest.mark.usefixtures("at_home")
@pytest.mark.parametrize("name", CHEAP)
def test_the_page_says_what_the_script_finds(name, folder):
    found = surprises.CASES[name](folder)
    said = told_on_the_page(name)
    assert list(said) == list(found)
    assert list(said.values()) == pytest.approx(list(found.values()), rel=2e-3, abs=1e-3)


@pytest.mark.parametrize("name", surprises.CASES)
def test_every_case_stands_on_the_page_and_its_table_can_be_read(name):
    said = told_on_the_page(name)
    assert len(said) >= 2
    assert surprises.table(name, said) in PAGE


def test_what_is_no_case_is_told_in_one_line(tmp_path, capsys):
    line = told([str(tmp_path / "out"), "drag", "nothing"], capsys, surprises.main)
    assert line.startswith("case: received nothing, needs some of one_damper, narrow_band")
