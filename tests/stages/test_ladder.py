"""Rule ladder: the table of all rungs, in its order, with its stamp."""

import csv
import json
from pathlib import Path

import pytest

from vsb.results.ladder import Rung, as_csv
from vsb.stages import ladder
from vsb.study.study import result_id


def test_a_ladder_made_again_is_the_same_and_stands_in_the_manifest(small, tmp_path):
    made, manifest = [tmp_path / "ladder.csv", tmp_path / "ladder.json"], tmp_path / "manifest.json"
    ladder.run(small.ladder, small.database_path, *map(str, made), str(manifest))
    for path in made:
        assert path.read_text() == Path(small.folder, path.name).read_text()
    stamps = json.loads(manifest.read_text())
    assert set(stamps) == {path.name for path in made}
    assert {entry["spec_id"] for entry in stamps.values()} == {small.ladder_id}
    assert small.ladder_id == result_id(small.ladder, Path(small.database_path).stem)


def test_every_design_has_its_rungs_and_takes_ever_more(small):
    rows = list(csv.DictReader(Path(f"{small.folder}/ladder.csv").read_text().splitlines()))
    for design in small.study.designs:
        power = {row["rung"]: float(row["power_mean"]) for row in rows if row["design"] == design}
        assert power["fixed"] <= power["best_damper"] <= power["best_spring_damper"] * (1 + 1e-9)
        assert power["best_spring_damper"] <= power["matched"] * (1 + 1e-9)


def test_rungs_are_stored_with_all_their_digits_beside_the_table_under_the_id_of_both(monkeypatch, tmp_path):
    """Of the specification and of the database; a number that is none is refused before anything is promised."""
    rung = Rung(**dict.fromkeys(Rung._fields) | {"design": "A", "wave": "w", "rung": "fixed", "power_mean": 1 / 3})
    found, asked = [rung, rung._replace(design="B", power_mean=2 / 3)], []
    monkeypatch.setattr(ladder, "study_ladder", lambda *given: asked.append(given) or found)
    monkeypatch.setattr(ladder, "stamp", lambda *given: asked.append(given) or {"spec_id": "own"})
    monkeypatch.setattr(ladder, "record", lambda *given: asked.append(given))
    out, rungs = str(tmp_path / "ladder.csv"), str(tmp_path / "ladder.json")
    ladder.run("spec", "database.nc", out, rungs, "manifest.json")
    assert asked == [("spec", "database.nc")] * 2 + [("manifest.json", "own", [out, rungs])]
    assert Path(out).read_text() == as_csv(found)
    assert [Rung(**one) for one in json.loads(Path(rungs).read_text())] == found
    found[1] = rung._replace(power_mean=float("nan"))
    with pytest.raises(ValueError, match="not JSON compliant"):
        ladder.run("spec", "database.nc", out, rungs, "manifest.json")
    assert len(asked) == 4  # and no entry of the manifest
