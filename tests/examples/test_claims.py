"""The page on published claims gives what the script finds."""

import re

import pytest
from conftest import HERE

from examples import claims, surprises

PAGE = (HERE.parent / "docs" / "claims.md").read_text()


def on_the_page(name):
    """The figures of a claim as the page has them."""
    (table,) = re.findall(rf"\| `{name}` \| \|\n\|---\|---\|\n((?:\|.*\|\n)+)", PAGE)
    return {key: float(value) for key, value in re.findall(r"\| (.*) \| (.*) \|", table)}


@pytest.mark.parametrize("name", claims.CASES)
def test_every_case_is_on_the_page(name):
    assert surprises.table(name, on_the_page(name)) in PAGE


@pytest.mark.slow
def test_each_azimuthal_order_adds_twice_the_limit_of_heave(tmp_path, monkeypatch):
    monkeypatch.chdir(HERE.parent)
    found = claims.more_orders(tmp_path)
    assert list(found.values()) == pytest.approx([1, 3, 5, 7], rel=1e-4)
    assert on_the_page("more_orders") == pytest.approx(found, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["flexible_barge", "start_of_a_run"])
def test_page_gives_what_the_script_finds(name, tmp_path, monkeypatch):
    monkeypatch.chdir(HERE.parent)
    assert on_the_page(name) == pytest.approx(claims.CASES[name](tmp_path), rel=2e-3, abs=1e-3)
