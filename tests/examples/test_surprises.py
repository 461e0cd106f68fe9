"""The page on surprises of the fair comparison gives what the script finds."""

import re

import pytest
from conftest import HERE, error_line

from examples import surprises

PAGE = (HERE.parent / "docs" / "surprises.md").read_text()
CHEAP = ("narrow_band", "port_within", "scarce_force")
"""Cases of one database and no run in time."""


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


@pytest.mark.slow
@pytest.mark.usefixtures("at_home")
@pytest.mark.parametrize("name", CHEAP)
def test_page_gives_what_the_script_finds(name, folder):
    found = surprises.CASES[name](folder)
    said = told_on_the_page(name)
    assert list(said) == list(found)
    assert list(said.values()) == pytest.approx(list(found.values()), rel=2e-3, abs=1e-3)


@pytest.mark.parametrize("name", surprises.CASES)
def test_every_case_is_on_the_page(name):
    said = told_on_the_page(name)
    assert len(said) >= 2
    assert surprises.table(name, said) in PAGE


def test_unknown_case_is_one_line(tmp_path, capsys):
    line = error_line([str(tmp_path / "out"), "drag", "nothing"], capsys, surprises.main)
    assert line.startswith("case: received nothing, needs some of one_damper, narrow_band")
