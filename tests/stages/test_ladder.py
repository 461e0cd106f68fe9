"""Rule ladder: the table of all rungs, in its order, with its stamp."""

import csv
import json
from pathlib import Path

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
