import pytest

from benchmarks import memories
from vsb.hydro.passive import fit_passive


def test_three_fits_of_three_motions():
    samples = memories.smooth(3)
    rows = {method: memories.measured("two", samples, method, 1e-2) for method in memories.METHODS}
    assert all(row["error"] <= 1e-2 for row in rows.values())
    assert rows["passive"]["least_damping"] == pytest.approx(0.0, abs=1e-9)
    assert rows["vector fit"]["least_damping"] < -1e-3
    assert rows["entry by entry"]["least_damping"] < -1e-3
    assert rows["entry by entry"]["order"] > rows["vector fit"]["order"] > rows["passive"]["order"]


def test_a_fit_that_gives_up_says_why(monkeypatch):
    monkeypatch.setitem(memories.METHODS, "passive", lambda samples, _: fit_passive(samples, 1.0))
    row = memories.measured("two", memories.smooth(2), "passive", 1e-2)
    assert row["status"].startswith("tolerance: received 1, needs 1e-9 to 0.1")
    assert "error" not in row


def test_the_table_holds_every_case(tmp_path, monkeypatch):
    monkeypatch.setattr(memories, "CASES", {"small": lambda: memories.smooth(1)})
    rows = memories.benchmark(tmp_path)
    assert len(rows) == len(memories.METHODS) * len(memories.TOLERANCES)
    text = (tmp_path / "memories.csv").read_text()
    assert text.splitlines()[0] == ",".join(memories.COLUMNS)
    assert len(text.splitlines()) == len(rows) + 1
