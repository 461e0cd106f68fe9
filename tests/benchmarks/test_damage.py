"""A small seeded part of the damage of `make torture`, and that it tells what is bad."""

import json
import random
import shutil
from pathlib import Path

import pytest
from conftest import SMALL_PLAN as PLAN

from benchmarks import damage
from benchmarks.__main__ import main
from vsb.errors import VsbError

MANIFEST = PLAN.manifest


@pytest.fixture
def place(finished, tmp_path, monkeypatch):
    """A copy of the small study's results, as the current folder."""
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    return tmp_path / "copy"


def test_damage_at_random_is_told_in_one_line_and_healed(place):
    files = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    met = [(one, damage.fate(PLAN, one)) for one in damage.trials(6, 12)]
    assert [each for each in met if each[1].verdict not in ("told", "harmless")] == []
    assert {one.path for one, _ in met} > {MANIFEST, f"{PLAN.folder}/study.json"}
    assert {path: path.read_bytes() for path in place.rglob("*") if path.is_file()} == files


def renamed(to):
    """The manifest with a product's stamp under another name."""
    stamps = json.loads(Path(MANIFEST).read_text())
    return damage.Damage(MANIFEST, "", json.dumps({**stamps, to: stamps["comparison.csv"]}).encode())


def test_a_manifest_that_names_a_file_outside_the_results_does_not_have_it_removed(place):
    """Once `vsb verify results --heal` removed whatever an edited manifest named."""
    for name in ("../../small.yaml", str(place / "small.yaml")):
        outcome = damage.fate(PLAN, renamed(name))
        assert outcome.verdict == "told"
        assert "is outside the results); delete it" in outcome.reason or "is not in the manifest" in outcome.reason


def test_what_is_bad_is_told_from_what_is_not(place, monkeypatch):
    table = f"{PLAN.folder}/comparison.csv"
    one = damage.Damage(table, "", Path(table).read_bytes().replace(b"FSB", b"BSF"))
    assert damage.fate(PLAN, one).verdict == "told"
    assert damage.fate(PLAN, damage.Damage(table, "", Path(table).read_bytes())).verdict == "harmless"

    def verdict(does):
        monkeypatch.setattr(damage, "verify", does)
        return damage.fate(PLAN, one).verdict

    def removes(target, heal):
        Path("small.yaml").unlink()

    def refuses(target, heal):
        raise VsbError("no")

    assert verdict(lambda target, heal: 1 / 0) == "traceback"
    assert verdict(lambda target, heal: None) == "silent"
    assert verdict(refuses) == "not healed"
    monkeypatch.setattr(damage, "stale_products", lambda plan, dry: (print("a\n" * 3), ["one"])[1])
    assert verdict(refuses) == "long message"


def test_a_table_of_damage_is_written(place, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(damage, "make", lambda plan, paths: shutil.copytree(place / "results", "results"))
    assert main(["damage", "4", str(tmp_path / "table.csv")]) == 0
    assert (tmp_path / "table.csv").read_text().count("\n") == 7
    assert "6 told" in capsys.readouterr().out
    monkeypatch.setattr(damage, "stale_products", lambda plan, dry: 1 / 0)
    assert main(["damage", "1", str(tmp_path / "table.csv")]) == 1


def test_what_is_damaged_was_sound(place, tmp_path, monkeypatch):
    """Once water without a floor was written as none: every damage was "told" by the study's own file."""
    (tmp_path / "new").mkdir()
    monkeypatch.chdir(tmp_path / "new")
    monkeypatch.setattr(damage, "make", lambda plan, paths: shutil.copytree(place / "results", "results"))
    plan = damage.finish()
    assert plan.study == PLAN.study
    shutil.rmtree("results")
    monkeypatch.setattr(damage, "make", lambda plan, paths: None)
    with pytest.raises(VsbError, match="is not there"):
        damage.finish()


def test_a_value_is_changed_in_one_place():
    data = {"a": [1.0, {"b": "c"}], "d": 2}
    for seed in range(40):
        found, where = damage.changed(random.Random(seed), data)
        assert found != data
        assert where.split(".")[0] in ("a", "d")
    assert data == {"a": [1.0, {"b": "c"}], "d": 2}
