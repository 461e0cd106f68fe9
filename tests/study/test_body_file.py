"""Body files: frequencies, directions and limits."""

import math

import pytest

from vsb.errors import ConfigError
from vsb.study.body import BodyFile
from vsb.study.reading import validated

RAFT = {"body": "raft", "mesh": "raft.nc", "modes": "raft.nc", "omega": [0.6, 0.9]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"omega": [0.9, 0.6]}, r"omega \[0.9, 0.6\]: needs at least one value, ascending without repetition"),
        ({"omega": [0.6, 0.6]}, r"omega \[0.6, 0.6\]: needs at least one value, ascending without repetition"),
        ({"wave_direction": [0.0, 90.0, 0.0]}, r"wave_direction \[0.0, 90.0, 0.0\]: needs at least one value, asc"),
        ({"wave_direction": []}, r"wave_direction \[\]: needs at least one value"),
        ({"water": {"depth": 10.0}, "omega": [0.1]}, "omega 0.1 rad/s: in 10 m of water needs at least"),
    ],
)
def test_unsolvable_frequencies_are_refused(changes, message):
    with pytest.raises(ConfigError, match=message):
        validated(BodyFile, {**RAFT, **changes}, "raft.yaml")


@pytest.mark.parametrize(("gravity", "depth"), [(9.81, 10.0), (3.7, 2.0)])
def test_lowest_frequency_of_the_panels(gravity, depth):
    """Wavenumber times depth of 0.3."""
    lowest = math.sqrt(gravity * 0.3 / depth * math.tanh(0.3))
    water = {"gravity": gravity, "depth": depth}
    validated(BodyFile, {**RAFT, "water": water, "omega": [1.0001 * lowest, 9.0]}, "raft.yaml")
    with pytest.raises(ConfigError, match=rf"in {depth:g} m of water needs at least {lowest:.4g}$"):
        validated(BodyFile, {**RAFT, "water": water, "omega": [0.9999 * lowest, 9.0]}, "raft.yaml")


@pytest.mark.parametrize(
    ("key", "kept", "refused"),
    [
        ("omega", [[1e-3], [1e3]], [[0.99e-3], [1.01e3]]),
        ("wave_direction", [[-360.0, 360.0]], [[-360.1], [360.1]]),
        ("lid", [0, 64], [-1, 65]),
        ("tolerance", [1e-5, 0.1, None], [0.99e-5, 0.101]),
        ("symmetry", ["auto", "none", "xOz", "yOz", "xOz+yOz"], ["yOz+xOz", "xOy"]),
    ],
)
def test_limits_of_a_body_file(key, kept, refused):
    water = {"depth": float("inf")}
    for value in kept:
        found = getattr(validated(BodyFile, {**RAFT, "water": water, key: value}, "raft.yaml"), key)
        assert found == (tuple(value) if isinstance(value, list) else value)
    for value in refused:
        with pytest.raises(ConfigError, match=f"^raft.yaml: {key}"):
            validated(BodyFile, {**RAFT, "water": water, key: value}, "raft.yaml")
