"""Drag of a study file."""

import pytest
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study.study import load

PLATE = {"heave": {"coefficient": 0.5, "area": 12.57}}


@pytest.fixture(scope="module")
def seed():
    return load(SEED)


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        ({"hydro": {"model": "auto"}}, "drag: hydro.model 'auto' knows none; needs linear or body_exact"),
        (
            {"pto": {"force_limit": 1e3}},
            "drag: cannot be followed beside a take-off that switches, received law linear with force_limit 1000 N and "
            "stroke_limit inf m; needs law: linear without limits",
        ),
        (
            {"hydro": {"model": "assumed_pressure", "pressure": 9.0}},
            "drag: hydro.model 'assumed_pressure' knows none; needs linear or body_exact",
        ),
        ({"simulation": {"method": "exact"}}, "simulation.method 'exact': cannot follow a drag; needs auto"),
        ({"drag": {"heave": {"coefficient": -1.0, "area": 1.0}}}, "drag.heave.coefficient"),
        ({"drag": {"heave": {"coefficient": 1e3, "area": 1.0}}}, "needs at most 100"),
        ({"drag": {"heave": {"coefficient": 1.0}}}, "drag.heave.area"),
        ({"drag": {"pitch": {"coefficient": 1.0, "area": 1.0}}}, "drag.pitch.lever"),
        ({"drag": {"heave": None}}, "drag.*needs one of surge, sway, heave, roll, pitch, yaw"),
    ],
)
def test_errors_of_drag(seed, sections, message):
    with pytest.raises(ConfigError, match=message):
        varied(seed, **{"drag": PLATE, **sections})
