"""The benchmark of take-offs: its plain methods find what the project finds, and nothing better."""

import pytest

from benchmarks import take_offs
from vsb.results.ladder import GAP


@pytest.fixture(autouse=True)
def few(monkeypatch):
    """Few seas: what takes long is the plain search."""
    monkeypatch.setattr(take_offs, "SEAS", 3)
    monkeypatch.setattr(take_offs, "SEARCHED", 1)
    monkeypatch.setattr(take_offs, "LIMITED", 2)


def test_no_search_finds_a_better_damper_or_pair_and_optima_are_proved(tmp_path):
    rows = take_offs.benchmark(tmp_path)
    assert [row["error"] for row in rows[:4:2]] == pytest.approx([0.0, 0.0], abs=1e-7)
    assert 0.0 < rows[4]["error"] <= GAP
    assert [row["case"] for row in rows[::2]] == [*take_offs.CASES, "optimum under a limit of force"]
    lines = (tmp_path / "take_offs.csv").read_text().splitlines()
    assert lines[0] == ",".join(take_offs.COLUMNS)
    assert len(lines) == 1 + len(rows) == 7


def test_searches_find_the_damper_and_of_pairs_no_less_than_a_damper_takes():
    """A simplex may end on a ridge of pairs: what it finds is between the best damper and the best pair."""
    port, squares = take_offs.ports(take_offs.OMEGA)[1], take_offs.seas()
    damper, pair = (ours(port, squares).power[0] for ours, _ in take_offs.CASES.values())
    assert take_offs.searched_damper(port, squares[0]) == pytest.approx(damper, rel=1e-6)
    assert damper < take_offs.searched_pair(port, squares[0]) <= pair * (1 + 1e-7)
