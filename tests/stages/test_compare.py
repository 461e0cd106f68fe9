"""Rule compare: tables of all runs, one sea in memory at a time."""

import json
import shutil
from pathlib import Path

import pytest
from conftest import SMALL_PLAN, varied

from vsb.errors import DatabaseError
from vsb.hydro.database import Check
from vsb.scenes.rest import reference_shell
from vsb.stages import compare
from vsb.stages.inputs import Inputs
from vsb.study.plan import StudyPlan

TABLES = {
    "out": "comparison.csv",
    "statistics": "statistics.csv",
    "validity": "validity.json",
    "study": "study.json",
    "tables": "tables.json",
}


@pytest.fixture
def place(finished, tmp_path, monkeypatch):
    """The small study's own results, without the tables, as those of the current folder; and the tables' texts."""
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    folder = Path(SMALL_PLAN.folder)
    texts = {name: (folder / name).read_text() for name in TABLES.values()}
    for name in texts:
        (folder / name).unlink()
    return folder, texts


def compared(plan, folder):
    made = {option: f"{folder}/{name}" for option, name in TABLES.items()}
    read = {**SMALL_PLAN.hydro_files, **SMALL_PLAN.response_files, **SMALL_PLAN.ladder_files}
    compare.run(plan.comparison, f"{folder}/trajectories", manifest=SMALL_PLAN.manifest, **made, **read)


def test_tables_made_again_are_the_same(place):
    folder, texts = place
    compared(SMALL_PLAN, folder)
    assert {name: (folder / name).read_text() for name in texts} == texts


def test_results_of_another_study_are_refused_and_nothing_is_written(place):
    folder, texts = place
    with pytest.raises(DatabaseError, match="stale or foreign"):
        compared(StudyPlan(varied(SMALL_PLAN.study, pto={"damping": 5000.0})), folder)
    assert not any((folder / name).exists() for name in texts)


MAKERS = {
    compare: ["agreement_checks", "constrained_checks", "fair_damping_checks", "pause_checks",
              "reference_power_checks", "stored_checks"],
    compare.ledger: ["bending_checks", "limit_check", "radiation_checks", "sea_checks", "shell_checks",
                     "transient_checks", "wave_checks", "witness_checks"],
    compare.irregular: ["statistical_checks"],
}  # fmt: skip


@pytest.mark.parametrize(("module", "name"), [(module, name) for module in MAKERS for name in MAKERS[module]])
def test_what_every_maker_of_checks_says_reaches_the_ledger_and_the_tables(place, monkeypatch, module, name):
    """A study in linear waves asks all of them; what one finds is written beside what the others found."""
    folder, texts = place
    told = Check("told here", 7.0, 1.0, "-", "fail", "by hand")
    before = json.loads(texts["validity.json"])["checks"]
    monkeypatch.setattr(module, name, lambda *_, **__: told if name == "limit_check" else [told])
    compared(SMALL_PLAN, folder)
    for file in ("validity.json", "tables.json"):
        found = json.loads((folder / file).read_text())["checks"]
        expected = "hydro told here" if name == "stored_checks" else "told here"
        assert [check["value"] for check in found if check["name"] == expected] == [7.0]
        kept = [check for check in found if check["value"] != 7.0]
        assert {check["name"] for check in kept} <= {check["name"] for check in before}


def test_what_a_sea_leaves_is_small_and_its_own(small):
    (wave,) = small.study.waves
    paths = {**small.hydro_files, **small.response_files}
    found = Inputs(small.study, f"{small.folder}/trajectories", paths)
    left = compare.in_a_sea(found, reference_shell(small.study).basis, wave)
    assert [row["design"] for row in left.rows] == ["FSB", "VSWEC"]
    assert {check.wave for check in left.checks} == {wave.label}
    assert set(left.runs) == {("FSB", wave.label), ("VSWEC", wave.label)}
    assert left.samples == {}
