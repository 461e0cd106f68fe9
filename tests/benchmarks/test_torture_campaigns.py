"""A small seeded part of the campaigns of `make torture`."""

import yaml

from benchmarks import torture_campaigns as torture
from benchmarks.__main__ import main
from benchmarks.measure import Outcome
from vsb.errors import DatabaseError


def test_ten_campaigns_are_refused_or_told_to_their_page(tmp_path_factory):
    found = {index: torture.fate(torture.drawn(index), tmp_path_factory.mktemp("odd")) for index in range(10)}
    assert {index: outcome for index, outcome in found.items() if outcome.verdict not in {"refused", "completed"}} == {}
    assert "completed" in {outcome.verdict for outcome in found.values()}


def test_a_campaign_is_always_the_same_for_an_index_and_of_many_kinds():
    assert torture.drawn(3) == torture.drawn(3)
    given = [yaml.safe_load(torture.drawn(index)["year.yaml"]) for index in range(60)]
    assert {next(iter(one.get("vary", {"": 0}))) for one in given} == set(torture.KEYS)
    assert {name for one in given for name in one["tuning"]} == {"fixed", "one", "each", "constrained"}


def test_what_a_campaign_ends_in_is_told_by_when_it_does(tmp_path, monkeypatch, capsys):
    sound = next(
        files for files in map(torture.drawn, range(50)) if torture.fate(files, tmp_path).verdict == "completed"
    )
    assert torture.fate(sound | {"year.yaml": "- no campaign\n"}, tmp_path).verdict == "refused"

    def failing(error):
        def run(plan):
            raise error

        return run

    monkeypatch.setattr(torture, "run_campaign", failing(DatabaseError("x.nc: holds NaN")))
    assert torture.fate(sound, tmp_path) == Outcome("failed after check", "x.nc: holds NaN")
    monkeypatch.setattr(torture, "run_campaign", failing(KeyError("x")))
    assert torture.fate(sound, tmp_path).verdict == "traceback"
    monkeypatch.setattr(torture, "drawn", lambda index: sound)
    assert main(["torture-campaigns", "1", str(tmp_path / "table.csv")]) == 1
    assert "0: traceback: " in capsys.readouterr().out
