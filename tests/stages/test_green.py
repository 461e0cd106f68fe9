"""Rule green: the table is asked for once, and its seconds are said."""

import re

import pytest

from vsb.errors import DatabaseError
from vsb.stages import green


def test_the_table_is_stored_in_its_folder_and_its_seconds_in_a_file(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(green, "stored_green_function", asked.append)
    green.run("table", str(tmp_path / "table.done"))
    assert asked == ["table"]
    assert re.fullmatch(r"\d+\.\d s\n", (tmp_path / "table.done").read_text())


def test_without_the_table_nothing_says_that_it_is_done(monkeypatch, tmp_path):
    def fails(folder):
        raise DatabaseError(f"{folder}: cannot be written")

    monkeypatch.setattr(green, "stored_green_function", fails)
    with pytest.raises(DatabaseError, match="table: cannot be written"):
        green.run("table", str(tmp_path / "table.done"))
    assert list(tmp_path.iterdir()) == []
