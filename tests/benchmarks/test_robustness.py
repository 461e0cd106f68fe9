"""Hard cases and a small seeded part of `make torture`: studies at random, damaged results."""

import json
import math
import random
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import HERE, error_line
from conftest import SMALL_PLAN as PLAN
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks import damage, hard_cases, torture
from benchmarks.__main__ import main
from benchmarks.hard_cases import Case, Result, judged, load_cases, run_cases

FILE = HERE.parent / "config" / "hard_cases.yaml"
CASES = load_cases(FILE)
SHORT = {"simulation": {"duration": 4.0, "window": [2.0, 4.0]}}
MANIFEST = PLAN.manifest
CHEAP = (
    "assumed_E_1e4", "linear_h_0.1", "steel_too_heavy", "linear_wave_0.5s", "linear_wave_100s", "linear_band_too_wide",
    "clamps_too_near", "clamps_too_many", "assumed_thrown_up", "assumed_undamped_still", "gimbal_quaternion",
    "slightly_negative_damping",
)  # fmt: skip


@pytest.fixture
def place(finished, tmp_path, monkeypatch):
    """A copy of the small study's results, as the current folder."""
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    return tmp_path / "copy"


def test_every_case_of_the_file_is_sound():
    assert len({case.name for case in CASES}) == len(CASES) > 60
    for case in CASES:
        if case.probe == "simulation" and case.expected == "completed":
            assert set(case.designs) <= set(hard_cases.case_study(case).designs), case.name


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name.startswith("assumed_") else name for name in CHEAP]
)
def test_cheap_cases_end_as_expected(name, tmp_path):
    (case,) = (case for case in CASES if case.name == name)
    for row in run_cases([case], tmp_path):
        assert (row.finished, row.verdict) == (case.expected, "ok"), row
        assert bool(row.message) or case.expected == "completed"


@pytest.mark.slow
def test_the_wave_is_tuned_to_a_natural_mode(tmp_path):
    """Without water's inertia: sqrt(rho g pi r^2/m)."""
    base = str(FILE.parent / "paper.yaml")
    (row,) = run_cases([Case(name="cheap", base=base, designs=("FSB",), overrides=SHORT, wet_mode=0)], tmp_path)
    assert row.message == f"wave at the natural frequency {math.sqrt(1024.7589 * 9.81 * 4 * math.pi / 17170):.6g} rad/s"


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


def test_broken_studies_are_refused_in_one_line_or_are_none(tmp_path):
    for seed in range(30):
        outcome = torture.fate(torture.broken(random.Random(seed)), tmp_path, run=False)
        assert outcome.verdict in ("refused", "completed"), (seed, outcome)


@pytest.mark.parametrize("seeds", [{*range(20)} - {13}, pytest.param({13}, marks=pytest.mark.slow)])
def test_equipped_studies_are_refused_or_checked_in_one_line(tmp_path, seeds):
    outcomes = [torture.fate(torture.equipped(random.Random(seed)), tmp_path, run=False) for seed in seeds]
    assert {outcome.verdict for outcome in outcomes} == {"completed", *({"refused"} if len(seeds) > 1 else {})}, (
        outcomes
    )


def test_study_without_shell_modes_runs(tmp_path):
    """Its modes are labels all the same, though there are none."""
    outcome = torture.fate(torture.odd(random.Random(2261)), tmp_path)
    assert outcome.verdict == "completed", outcome


@pytest.mark.slow
@settings(max_examples=6, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_what_passes_the_check_runs(tmp_path_factory, seed):
    outcome = torture.fate(torture.odd(random.Random(seed)), tmp_path_factory.mktemp("odd"))
    assert outcome.verdict in ("refused", "completed"), outcome


def test_damage_at_random_is_reported_in_one_line(place):
    files = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    met = [(one, damage.fate(PLAN, one)) for one in damage.trials(12, 12)]
    assert [each for each in met if each[1].verdict not in ("reported", "harmless")] == []
    assert {one.path for one, _ in met} > {MANIFEST, f"{PLAN.folder}/study.json"}
    assert {path: path.read_bytes() for path in place.rglob("*") if path.is_file()} == files


def renamed(to):
    """The manifest with a product's stamp under another name."""
    stamps = json.loads(Path(MANIFEST).read_text())
    return damage.Damage(MANIFEST, "", json.dumps({**stamps, to: stamps["comparison.csv"]}).encode())


def test_a_manifest_that_names_a_file_outside_the_results_is_refused(place):
    for name in ("../../small.yaml", str(place / "small.yaml")):
        outcome = damage.fate(PLAN, renamed(name))
        assert outcome.verdict == "reported"
        assert "is outside the results); delete it" in outcome.reason or "is not in the manifest" in outcome.reason


def test_a_missing_file_is_one_line_and_writes_nothing(workplace, capsys):
    assert error_line(["hard-cases", "missing.yaml", "out.csv"], capsys, main).startswith(
        "missing.yaml: cannot be read"
    )
    assert [path.name for path in workplace.iterdir()] == ["file"]
