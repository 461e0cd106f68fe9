"""Rule compare: tables of all runs, one sea in memory at a time."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

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


def test_every_sea_is_met_in_its_own_waves_and_irregular_ones_are_sampled(seed, monkeypatch):
    """Of a regular and two irregular seas: waves, runs and samples of each are its own."""
    sea = {"kind": "jonswap", "hs": 1, "tp": 4}
    study = varied(seed, waves=[*seed.model_dump()["waves"], sea, {**sea, "tp": 5}], designs={"A": {}, "B": {}})
    runs = {(d, w.label): SimpleNamespace(attrs={"of": (d, w.label)}) for d in "AB" for w in study.waves}
    found = SimpleNamespace(study=study, database="database", response="response", runs=runs)
    monkeypatch.setattr(compare, "study_sea", lambda study, wave, database: (wave, database))
    monkeypatch.setattr(compare.comparison, "comparison", lambda *given: list(given))
    monkeypatch.setattr(compare.irregular, "sample", lambda *given: given)
    monkeypatch.setattr(compare.ledger, "sea_checks", lambda *given: list(given))
    for i, wave in enumerate(study.waves):
        left = compare.in_a_sea(found, "basis", wave)
        own, waves = {d: runs[d, wave.label] for d in "AB"}, (wave, "database")
        assert left.rows == [study, wave, own, waves]
        assert left.checks == [study, "basis", wave, own]
        assert left.runs == {(d, wave.label): {"of": (d, wave.label)} for d in "AB"}
        samples = {(d, wave.label): (study, wave, d, own[d], waves, "response") for d in "AB"} if i else {}
        assert left.samples == samples


@pytest.mark.parametrize("name", ["wave_checks", "agreement_checks"])
def test_checks_of_a_sea_are_asked_of_every_sea(seed, monkeypatch, name):
    seas = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.0, 3.0, 4.0)]
    study, asked = varied(seed, waves=seas), []
    for maker in ("radiation_checks", "bending_checks", "wave_checks", "witness_checks"):
        monkeypatch.setattr(compare.ledger, maker, lambda *_: [])
    monkeypatch.setattr(compare.ledger, "limit_check", lambda *_: Check("limit", 0.0, 1.0, "-", "ok", ""))
    monkeypatch.setattr(compare, "agreement_checks", lambda *_: [])
    monkeypatch.setattr(compare, "stored_checks", lambda *_: [Check("symmetry", 0.0, 1.0, "-", "ok", "")])
    place = compare if name == "agreement_checks" else compare.ledger
    monkeypatch.setattr(place, name, lambda *given: asked.append(given) or [])
    found = SimpleNamespace(study=study, database="database", radiation=None, response="response", witness=None)
    checks = compare.of_the_water(found, ["rows"], {"runs": {}})
    assert [check.name for check in checks] == ["limit", "hydro symmetry"]
    if name == "wave_checks":
        assert asked == [(wave, study.water, study.hydro.omega_max) for wave in study.waves]
    else:
        assert asked == [(study, wave, "response", ["rows"], {"runs": {}}) for wave in study.waves]
