"""Hard cases: the verdict on cheap ones, and that what goes wrong is reported as wrong."""

import csv
import io
import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import HERE

from benchmarks import hard_cases as hardcases
from benchmarks.hard_cases import Case, Result, Row, as_csv, as_text, benchmark, changed, judged, load_cases, run_cases
from vsb.errors import ConfigError, StabilityError

CASES = HERE.parent / "config" / "hard_cases.yaml"
SHORT = {"simulation": {"duration": 4.0, "window": [2.0, 4.0]}}


def paper(**changes):
    """A cheap case: the paper's rigid buoy, which needs no hydrodynamic coefficients."""
    return Case(
        **{
            "name": "cheap",
            "base": str(CASES.parent / "paper.yaml"),
            "designs": ("FSB",),
            "overrides": SHORT,
            **changes,
        }
    )


def planted(monkeypatch, run):
    """Let the cheap case run something else."""
    monkeypatch.setattr(hardcases, "PROBES", {**hardcases.PROBES, "simulation": run})


# the file -----------------------------------------------------------------------------------------------------------


def test_every_case_of_the_file_is_sound():
    cases = load_cases(CASES)
    assert len({case.name for case in cases}) == len(cases) > 60
    for case in cases:
        if case.probe == "simulation" and case.expected == "completed":
            assert set(case.designs) <= set(hardcases.case_study(case).designs), case.name


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("completed", "case x: received 'completed', needs a mapping with keys among"),
        ({"bass": "paper.yaml"}, "case x: received .*bass.*, needs a mapping with keys among.*base"),
        ({"probe": "none"}, "case x: received probe 'none' .* needs one of simulation"),
        ({"expected": "maybe"}, "expected 'maybe', needs .* completed or refused"),
        ({"base": 3}, "case x: received .*base.*, needs a path as base and a list of designs"),
        ({"designs": "FSB"}, "case x: received .*designs.*, needs a path as base and a list of designs"),
    ],
)
def test_a_bad_entry_is_refused(given, message):
    with pytest.raises(ConfigError, match=message):
        Case.of("x", given, CASES.parent)


@pytest.mark.parametrize("text", ["[1, 2]", "- a"])
def test_a_file_of_no_cases_is_refused(tmp_path, text):
    (tmp_path / "cases.yaml").write_text(text)
    with pytest.raises(ConfigError, match=r"cases.yaml: received list, needs a mapping of cases by name"):
        load_cases(tmp_path / "cases.yaml")
    case = Case.of("x", {"base": "cases.yaml"}, tmp_path)
    with pytest.raises(ConfigError, match=r"cases.yaml: received list, needs a study, as base of case x"):
        hardcases.case_study(case)


def test_overrides_are_nested_but_designs_are_replaced():
    base = {"device": {"radius": 2.0, "mass": 1.0}, "designs": {"A": {}}, "waves": [1]}
    new = changed(base, {"device": {"mass": 2.0}, "designs": {"B": {}}, "waves": [2], "pto": {"damping": 0.0}})
    assert new == {"device": {"radius": 2.0, "mass": 2.0}, "designs": {"B": {}}, "waves": [2], "pto": {"damping": 0.0}}
    assert base["device"]["mass"] == 1.0


# cheap cases --------------------------------------------------------------------------------------------------------


CHEAP = (
    "assumed_E_1e4", "linear_h_0.1", "steel_too_heavy", "linear_wave_0.5s", "linear_wave_100s", "linear_band_too_wide",
    "clamps_too_near", "clamps_too_many", "assumed_thrown_up", "assumed_undamped_still", "gimbal_quaternion", "gimbal_euler",
    "slightly_negative_damping",
)  # fmt: skip


@pytest.mark.parametrize("name", CHEAP)
def test_cheap_cases_end_as_expected(name, tmp_path):
    (case,) = (case for case in load_cases(CASES) if case.name == name)
    for row in run_cases([case], tmp_path):
        assert (row.finished, row.verdict) == (case.expected, "ok"), row
        assert bool(row.message) or case.expected == "completed"


def test_a_linear_case_has_a_reference_and_shares_its_files(tmp_path):
    case = Case("linear", base=str(CASES.parent / "few_modes.yaml"), designs=("VSWEC", "VSWEC90"), overrides=SHORT)
    first = run_cases([case], tmp_path)
    files = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nc")}
    coarse = replace(case, overrides=changed(SHORT, {"simulation": {"method": "convolution"}}))
    second = run_cases([coarse], tmp_path)
    assert {row.verdict for row in (*first, *second)} == {"ok"}
    assert {row.method for row in (*first, *second)} == {"exact propagation", "convolution"}
    assert all(0.0 < row.error < 1e-2 for row in (*first, *second))
    assert "clamps slip" in first[1].message
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nc")} == files


def test_the_wave_is_tuned_to_a_natural_mode(tmp_path):
    """Without water's inertia: sqrt(rho g pi r^2/m)."""
    (row,) = run_cases([paper(wet_mode=0)], tmp_path)
    assert row.message == f"wave at the natural frequency {math.sqrt(1024.7589 * 9.81 * 4 * math.pi / 17170):.6g} rad/s"


# planted failures ---------------------------------------------------------------------------------------------------


def test_a_motion_that_is_not_finite_is_wrong(monkeypatch, tmp_path):
    true = hardcases.simulate

    def broken(*scene):
        motion, stride, method = true(*scene)
        motion.position[-1, 0] = np.nan
        return motion, stride, method

    monkeypatch.setattr(hardcases, "simulate", broken)
    (row,) = run_cases([paper()], tmp_path)
    assert (row.finished, row.verdict) == ("not finite", "wrong")


def test_a_motion_off_its_reference_is_wrong(monkeypatch, tmp_path):
    true = hardcases.simulate

    def broken(*scene):
        motion, stride, method = true(*scene)
        return replace(motion, position=1.2 * motion.position), stride, method

    monkeypatch.setattr(hardcases, "simulate", broken)
    (row,) = run_cases([paper()], tmp_path)
    assert (row.finished, row.verdict) == ("completed", "wrong")
    assert row.error == pytest.approx(0.2, rel=0.5)


def refusal(*_):
    raise StabilityError("no")


def crash(*_):
    raise ZeroDivisionError("a\nb")


@pytest.mark.parametrize(
    ("run", "finished", "message"),
    [(refusal, "refused", "no"), (crash, "traceback", "ZeroDivisionError: a b")],
)
def test_what_is_not_expected_is_wrong(monkeypatch, tmp_path, run, finished, message):
    planted(monkeypatch, run)
    (row,) = run_cases([paper()], tmp_path)
    assert (row.finished, row.verdict, row.message) == (finished, "wrong", message)


def test_a_motion_where_a_refusal_is_due_is_wrong(tmp_path):
    (row,) = run_cases([paper(expected="refused")], tmp_path)
    assert (row.finished, row.verdict) == ("completed", "wrong")


def test_a_warning_is_a_doubt(monkeypatch, tmp_path):
    planted(monkeypatch, lambda *_: Result("completed", steps=int(np.sqrt(np.array([-1.0])).size)))
    (row,) = run_cases([paper()], tmp_path)
    assert row.verdict == "doubt"
    assert row.message == "warning: invalid value encountered in sqrt"


@pytest.mark.parametrize(
    ("error", "energy", "verdict"),
    [
        (None, None, "ok"), (0.9, 0.9, "ok"), (2.0, 0.9, "doubt"), (0.9, 2.0, "doubt"), (0.9, 1e9, "doubt"), (101.0, 0.0, "wrong"),
        (None, 101.0, "wrong"), (None, 2.0, "doubt"), (np.nan, 0.0, "wrong"), (0.9, np.nan, "wrong"), (None, np.nan, "wrong"),
    ],
)  # fmt: skip
def test_verdict(error, energy, verdict):
    result = Result("completed", error=error, energy_residual=energy, error_limit=1.0, energy_limit=1.0)
    assert judged("completed", result) == verdict
    assert judged("refused", result) == "wrong"


def test_a_refusal_of_several_lines_is_wrong():
    assert judged("refused", Result("refused", message="one")) == "ok"
    assert judged("refused", Result("refused", message="one\ntwo")) == "wrong"


# output -------------------------------------------------------------------------------------------------------------


def test_the_table_has_no_nan():
    row = Row("a", "b", "c", "not finite", np.nan, None, 0.123456, np.inf, "wrong", "x, y")
    (read,) = csv.DictReader(io.StringIO(as_csv([row])))
    assert read == {
        "case": "a", "design": "b", "method": "c", "finished": "not finite", "error": "", "steps": "", "seconds": "0.1235",
        "energy_residual": "", "verdict": "wrong", "message": "x, y",
    }  # fmt: skip
    assert "nan" not in as_text([row])
    head, line, _, counts = as_text([row]).splitlines()
    assert line.split() == ["a", "b", "c", "not", "finite", "0.1235", "wrong", "x,", "y"]
    assert line.index("wrong") == head.index("verdict")
    assert counts == "0 ok, 0 doubt, 1 wrong"


def test_one_call_writes_both_tables(tmp_path):
    text = "still: {base: %s, designs: [FSB], overrides: {simulation: {duration: 2.0, window: [1.0, 2.0]}}}\neuler: {probe: euler321, expected: refused}\n"
    (tmp_path / "cases.yaml").write_text(text % (CASES.parent / "paper.yaml"))
    rows = benchmark(tmp_path / "cases.yaml", tmp_path / "out" / "hard.csv")
    assert [row.verdict for row in rows] == ["ok", "ok"]
    table = (tmp_path / "out" / "hard.csv").read_text()
    assert len(list(csv.DictReader(io.StringIO(table)))) == 2
    assert (tmp_path / "out" / "hard.txt").read_text().splitlines()[-1] == "2 ok, 0 doubt, 0 wrong"
