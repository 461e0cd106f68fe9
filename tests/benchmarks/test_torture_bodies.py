"""A small seeded part of the bodies of `make torture`."""

from contextlib import suppress

import pytest
import yaml

from benchmarks import torture_bodies as torture
from benchmarks.__main__ import main
from benchmarks.measure import Outcome
from vsb.errors import ConfigError, ConvergenceError, DatabaseError, StabilityError

PAGE = 5
"""One that is told to its page."""


def test_some_bodies_are_refused_or_told_to_their_page(tmp_path_factory, green_folder):
    found = {index: torture.fate(index, tmp_path_factory.mktemp("odd"), green_folder) for index in (1, 3, 4, 7, PAGE)}
    sound = {"refused", "completed", "unsound coefficients"}
    assert {index: outcome for index, outcome in found.items() if outcome.verdict not in sound} == {}
    assert found[PAGE] == Outcome("completed", "")


def test_a_body_is_always_the_same_for_an_index_and_of_many_kinds(tmp_path_factory):
    def told(index):
        folder = tmp_path_factory.mktemp("told")
        with suppress(ConfigError):  # a body that cannot be
            return torture.written(index, folder).read_text(), (folder / "box.yaml").read_text()

    assert told(3) == told(3)
    given = [yaml.safe_load(found[0]) for found in map(told, range(60)) if found]
    assert 40 < len(given) < 60
    assert {sea["kind"] for one in given for sea in one["waves"]} == {"regular", "jonswap", "still"}
    assert {one["pto"].get("law") for one in given} == {None, *torture.LAWS}
    assert {"mass", "stiffness", "damping"} <= {key for one in given for key in one["body"]}
    assert {"repair", "omega_max", "tolerance"} <= {key for one in given for key in one["hydro"]}


@pytest.mark.parametrize(
    ("error", "verdict"),
    [
        (DatabaseError("x.nc: holds NaN"), "unsound coefficients"),
        (ConvergenceError("the radiation state space reaches an error"), "unsound coefficients"),
        (StabilityError("radiation damping: received a least eigenvalue"), "unsound coefficients"),
        (ConfigError("hydro.repair: positive_damping would change damping"), "unsound coefficients"),
        (ConfigError("pto.stroke_limit: nothing holds this port"), "failed after check"),
        (KeyError("x"), "traceback"),
    ],
)
def test_what_a_body_ends_in_is_told_by_what_only_solving_shows(tmp_path, green_folder, monkeypatch, error, verdict):
    def failing(plan, targets):
        raise error

    monkeypatch.setattr(torture, "make", failing)
    assert torture.fate(PAGE, tmp_path, green_folder).verdict == verdict


def test_the_command_writes_the_fate_of_each_and_fails_if_one_is_bad(tmp_path, monkeypatch):
    out, fates = tmp_path / "fates.csv", [Outcome("refused", "x"), Outcome("completed", "")]
    monkeypatch.setattr(torture, "fate", lambda index, folder, shared: fates[index])
    assert main(["torture-bodies", "2", str(out)]) == 0
    assert [line.split(",")[:2] for line in out.read_text().splitlines()[1:]] == [["0", "refused"], ["1", "completed"]]
    fates[1] = Outcome("traceback", "y")
    assert main(["torture-bodies", "2", str(out)]) == 1
