"""A body file is checked before anything is solved."""

import pytest

from vsb.errors import ConfigError
from vsb.study.body_file import BodyFile
from vsb.study.reading import validated

RAFT = {"body": "raft", "mesh": "raft.nc", "modes": "raft.nc", "omega": [0.6, 0.9]}


def test_what_is_not_said_has_a_default():
    found = validated(BodyFile, RAFT, "raft.yaml")
    assert (found.lid, found.symmetry, found.wave_direction, found.tolerance) == (8, "auto", (0.0,), None)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"omega": [0.9, 0.6]}, r"omega \[0.9, 0.6\]: needs at least one value, ascending without repetition"),
        ({"wave_direction": []}, r"wave_direction \[\]: needs at least one value"),
        ({"water": {"depth": 10.0}, "omega": [0.1]}, "omega 0.1 rad/s: in 10 m of water needs at least"),
    ],
)
def test_frequencies_nobody_can_solve_are_refused(changes, message):
    with pytest.raises(ConfigError, match=message):
        validated(BodyFile, {**RAFT, **changes}, "raft.yaml")
