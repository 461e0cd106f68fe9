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
from vsb.study.body import BodyStudy
from vsb.study.plan import StudyPlan
from vsb.study.reading import validated
from vsb.study.study import canonical

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
    compare.ledger: ["limit_check", "mode_checks", "radiation_checks", "sea_checks", "shell_checks",
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
    """Of a regular and two irregular seas: waves, runs and samples of each are its own, beside what its spectrum says."""
    sea = {"kind": "jonswap", "hs": 1, "tp": 4}
    study = varied(
        seed,
        waves=[*seed.model_dump()["waves"], sea, {**sea, "amplitudes": "random"}],
        designs={"A": {"flexible": False}, "B": {}},
    )
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
        spectral = (study.waves[1], "database")  # of both: the one of fixed amplitudes
        samples = {(d, wave.label): (study, wave, d, own[d], waves, spectral, "response") for d in "AB"} if i else {}
        assert left.samples == samples


@pytest.mark.parametrize("name", ["wave_checks", "agreement_checks"])
def test_checks_of_a_sea_are_asked_of_every_sea(seed, monkeypatch, name):
    seas = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.0, 3.0, 4.0)]
    study, asked = varied(seed, waves=seas), []
    for maker in ("radiation_checks", "wave_checks", "witness_checks"):
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


RAFT = {
    "study": "raft", "designs": {"a": {}}, "waves": [{"kind": "regular", "amplitude": 0.1, "period": 5.0}, {"kind": "still"}],
    "body": {"file": {"body": "raft", "mesh": "-", "modes": "-", "omega": [0.5, 1.0]}}, "pto": {"damping": 1.0, "port": {"dof": "Pitch"}},
}  # fmt: skip


def told(name):
    """A check by its name."""
    return Check(name, 0.0, 1.0, "-", "ok", "")


@pytest.mark.parametrize("kind", ["buoy", "dry", "body"])
def test_tables_are_of_all_seas_and_checks_of_all_that_a_study_has(seed, tmp_path, monkeypatch, kind):
    """Of a body there is no shell, of an assumed pressure neither water nor tuning."""
    regular = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.0, 3.0)]
    dry = {"hydro": {"model": "assumed_pressure", "pressure": 1800.0}} if kind == "dry" else {}
    study = validated(BodyStudy, RAFT, "raft.yaml") if kind == "body" else varied(seed, waves=regular, **dry)
    plan, asked = SimpleNamespace(ladder_id="ladder", study_id="0" * 16), {}

    def maker(name, found=None):
        def make(*given):
            asked[name] = given
            return [told(name)] if found is None else found

        return make

    for name in ("transient_checks", "shell_checks", "assumed_pressure_checks"):
        monkeypatch.setattr(compare.ledger, name, maker(name))
    for name in ("pause_checks", "of_the_water", "fair_damping_checks", "constrained_checks", "reference_power_checks"):
        monkeypatch.setattr(compare, name, maker(name))
    monkeypatch.setattr(compare.irregular, "statistical_checks", maker("statistical_checks"))
    monkeypatch.setattr(compare.irregular, "statistics", maker("statistics", []))
    monkeypatch.setattr(compare.irregular, "as_csv", lambda lines: "")
    monkeypatch.setattr(compare.comparison, "as_csv", lambda rows: f"{rows}")
    monkeypatch.setattr(compare, "equal_tuning", maker("equal_tuning", []))
    monkeypatch.setattr(compare, "linearisation", maker("linearisation", "beyond"))
    monkeypatch.setattr(compare, "with_intervals", lambda *given: asked.update(intervals=given) or given[1])
    monkeypatch.setattr(compare, "within_limits", maker("within_limits", []))
    reference = SimpleNamespace(basis="basis")
    monkeypatch.setattr(compare, "reference_shell", lambda of: reference)
    monkeypatch.setattr(
        compare, "Inputs", lambda *given: SimpleNamespace(study=study, plan=plan, given=given, response="response")
    )

    def in_a_sea(found, basis, wave):
        assert (basis, found.given[:2]) == (None if kind == "body" else "basis", (study, "runs"))
        of = wave.label
        return compare.InASea([{"of": of}], [told(of)], {("A", of): {"attrs": of}}, {("A", of): f"sample {of}"})

    monkeypatch.setattr(compare, "in_a_sea", in_a_sea)
    rung = dict.fromkeys(compare.Rung._fields) | {"design": "A", "wave": "w", "rung": "fixed", "note": ""}
    monkeypatch.setattr(compare, "read_text", lambda *given: asked.update(read=given) or json.dumps([rung]))
    monkeypatch.setattr(compare, "record", maker("record"))
    files = {option: str(tmp_path / name) for option, name in TABLES.items()}
    compare.run(SimpleNamespace(study=study), "runs", rungs="rungs.json", manifest="manifest", **files)
    labels = [wave.label for wave in study.waves]
    rows, runs = [{"of": of} for of in labels], {("A", of): {"attrs": of} for of in labels}
    assert asked["transient_checks"] == (runs, rows)
    assert asked["pause_checks"] == (runs,)
    names = {"transient_checks", "pause_checks", *labels}
    if kind != "body":
        assert asked["shell_checks"] == (study, reference)
        names |= {"shell_checks"}
    if kind == "dry":
        assert asked["assumed_pressure_checks"] == (study, rows)
        assert asked["intervals"] == (study, rows, runs, (), None)
        names |= {"assumed_pressure_checks"}
    else:
        ladder = [compare.Rung(**rung)]
        assert asked["read"] == ("rungs.json", "manifest", "ladder")
        assert asked["statistics"] == (study, {("A", of): f"sample {of}" for of in labels})
        assert asked["of_the_water"][1:] == (rows, runs)
        assert asked["statistical_checks"] == (study, [])
        assert asked["within_limits"] == asked["reference_power_checks"] == (study, ladder)
        assert asked["equal_tuning"] == (study, ladder, "beyond")
        assert asked["linearisation"] == (study, rows, runs, "response", [])
        assert asked["intervals"] == (study, rows, runs, ladder, "response")
        assert asked["fair_damping_checks"] == ([], study.pto)
        assert asked["constrained_checks"] == (ladder,)
        names |= {
            "of_the_water",
            "statistical_checks",
            "fair_damping_checks",
            "constrained_checks",
            "reference_power_checks",
        }
    tables = json.loads((tmp_path / "tables.json").read_text())
    assert tables["comparison"] == rows
    assert sorted(check["name"] for check in tables["checks"]) == sorted(names)
    assert (tmp_path / "comparison.csv").read_text() == f"{rows}"
    assert (tmp_path / "study.json").read_text() == canonical(study) + "\n"
    assert asked["record"] == ("manifest", "0" * 16, list(files.values()))


def test_of_a_body_the_water_is_judged_by_its_seas_and_no_shell_is(monkeypatch):
    study, asked = validated(BodyStudy, RAFT, "raft.yaml"), []
    monkeypatch.setattr(compare.ledger, "radiation_checks", lambda *given: asked.append(given) or [told("radiation")])
    monkeypatch.setattr(compare, "seas_checks", lambda *given: asked.append(given) or [told("seas")])
    monkeypatch.setattr(compare, "agreement_checks", lambda *given: asked.append(given) or [told(given[1].label)])
    monkeypatch.setattr(compare, "stored_checks", lambda database: asked.append(database) or [told("symmetry")])
    found = SimpleNamespace(study=study, database="database", radiation="radiation", response="response")
    checks = compare.of_the_water(found, "rows", "runs")
    labels = [wave.label for wave in study.waves]
    assert [check.name for check in checks] == ["radiation", "seas", *labels, "hydro symmetry"]
    agreed = [(study, wave, "response", "rows", "runs") for wave in study.waves]
    assert asked == [("radiation", study.hydro.tolerance), (study, "database"), *agreed, "database"]


@pytest.mark.parametrize("kind", ["dry", "body"])
def test_runs_of_a_sea_are_checked_as_those_of_what_floats(seed, monkeypatch, kind):
    """Of an assumed pressure in no waves, of a body by its own checks."""
    dry = varied(seed, designs={"a": {}}, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    study = validated(BodyStudy, RAFT, "raft.yaml") if kind == "body" else dry
    wave = study.waves[0]
    runs = {("a", wave.label): SimpleNamespace(attrs={"of": "a"}), ("a", "other"): None}
    found = SimpleNamespace(study=study, database="database", runs=runs)
    monkeypatch.setattr(compare, "study_sea", lambda *given: given)
    monkeypatch.setattr(compare.comparison, "comparison", lambda *given: given)
    monkeypatch.setattr(compare, "runs_checks", lambda *given: ("body", *given))
    monkeypatch.setattr(compare.ledger, "sea_checks", lambda *given: ("buoy", *given))
    left = compare.in_a_sea(found, None if kind == "body" else "basis", wave)
    own = {"a": runs["a", wave.label]}
    assert left.rows == (study, wave, own, (study, wave, "database") if kind == "body" else compare.NO_WAVES)
    assert left.checks == (
        ("body", study, "database", wave, own) if kind == "body" else ("buoy", study, "basis", wave, own)
    )
    assert (left.runs, left.samples) == ({("a", wave.label): {"of": "a"}}, {})
