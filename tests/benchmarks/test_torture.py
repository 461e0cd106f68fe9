"""A small seeded part of `make torture`."""

import random

import pytest
from conftest import SMALL
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks import torture
from benchmarks.__main__ import main
from vsb.stages.make import due, jobs
from vsb.study.plan import StudyPlan
from vsb.study.study import parse


@pytest.mark.parametrize("block", range(2))
def test_broken_studies_are_refused_in_one_line_or_are_none(tmp_path, block):
    for seed in range(30 * block, 30 * block + 30):
        outcome = torture.fate(torture.broken(random.Random(seed)), tmp_path, run=False)
        assert outcome.verdict in ("refused", "completed"), (seed, outcome)


@pytest.mark.parametrize("seed", range(12))
def test_odd_studies_are_refused_or_checked_in_one_line(tmp_path, seed):
    outcome = torture.fate(torture.odd(random.Random(seed)), tmp_path, run=False)
    assert outcome.verdict in ("refused", "completed"), outcome


@pytest.mark.parametrize("block", range(3))
def test_equipped_studies_are_refused_or_checked_in_one_line(tmp_path, block):
    outcomes = [torture.fate(torture.equipped(random.Random(10 * block + i)), tmp_path, run=False) for i in range(10)]
    assert {outcome.verdict for outcome in outcomes} == {"refused", "completed"}, outcomes


def test_every_other_study_is_broken_and_of_the_rest_every_other_equipped(monkeypatch):
    for kind in ("broken", "odd", "equipped"):
        monkeypatch.setattr(torture, kind, lambda rng, kind=kind: kind)
    assert [torture.study_text(index) for index in range(5)] == ["broken", "odd", "broken", "equipped", "broken"]


@pytest.mark.parametrize("seed", [31])
def test_an_equipped_study_that_passes_the_check_runs(tmp_path, seed):
    assert torture.fate(torture.equipped(random.Random(seed)), tmp_path) == torture.Outcome("completed", "")


@settings(max_examples=12, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_what_passes_the_check_runs(tmp_path_factory, seed):
    outcome = torture.fate(torture.odd(random.Random(seed)), tmp_path_factory.mktemp("odd"))
    assert outcome.verdict in ("refused", "completed"), outcome


def test_what_breaks_is_told_from_what_is_refused(tmp_path, monkeypatch):
    text = torture.FEW_MODES.read_text()
    assert torture.fate("- no study\n", tmp_path).verdict == "refused"
    monkeypatch.setattr(torture, "run_stages", lambda study, plan: "response.nc: rao")
    assert torture.fate(text, tmp_path) == torture.Outcome("not finite", "response.nc: rao")
    monkeypatch.setattr(torture, "run_stages", lambda study, plan: torture.load("nowhere.yaml"))
    assert torture.fate(text, tmp_path).verdict == "failed after check"
    monkeypatch.setattr(torture, "run_stages", lambda study, plan: 1 / 0)
    assert torture.fate(text, tmp_path).verdict == "traceback"


def test_a_table_of_fates_is_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(torture, "study_text", lambda index: "- no study" if index else torture.FEW_MODES.read_text())
    monkeypatch.setattr(torture, "run_stages", lambda study, plan: "")
    assert main(["torture", "3", str(tmp_path / "table.csv")]) == 0
    assert (tmp_path / "table.csv").read_text().startswith("index,verdict,reason\n0,completed,\n1,refused,")
    assert "2 refused, 1 completed" in capsys.readouterr().out
    monkeypatch.setattr(torture, "run_stages", lambda study, plan: 1 / 0)
    assert main(["torture", "1", str(tmp_path / "table.csv")]) == 1


def test_all_numbers_of_a_study_are_made_and_nothing_is_drawn(tmp_path):
    """Figures take several times as long as all the rest."""
    plan = StudyPlan(parse(SMALL), root=str(tmp_path))
    stages = {job.stage for job in due(jobs(plan), torture.numbers(plan))}
    assert {"database", "radiation", "response", "ladder", "simulate", "compare"} <= stages
    assert not {"figures", "report", "display", "witness"} & stages
