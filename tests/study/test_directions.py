"""Motion in several directions: modes, mooring, directions of waves, errors."""

import pytest
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.pipeline.graph import StudyPlan
from vsb.study.study import load, parse

BALANCE = {"centre_of_mass": -0.5, "ballast_inertia": 8000.0}


def raw(**changes):
    """The seed's study as nested mappings, with sections updated."""
    data = load(SEED).model_dump()
    for name, update in changes.items():
        data[name] = (
            {**data[name], **update} if isinstance(update, dict) and isinstance(data.get(name), dict) else update
        )
    return data


def planar(**changes):
    device = {**BALANCE, **changes.pop("device", {})}
    return raw(**{"motion": "planar", "device": device, **changes})


def free(**changes):
    return planar(motion="free", device={"ballast_yaw_inertia": 7e3}, **changes)


@pytest.mark.parametrize(
    ("motion", "known"), [("heave", (0.0,)), ("planar", (0.0, 180.0, -180.0, 360.0)), ("free", (-30.0, 90.0, 180.0))]
)
def test_waves_must_travel_in_the_directions_of_motion(motion, known):
    ours = {"heave": raw, "planar": planar, "free": free}[motion]
    for direction in (0.0, 180.0, -180.0, 360.0, -30.0, 90.0):
        study = ours(waves=[WAVE, {**WAVE, "period": 4.0, "direction": direction}])
        if direction in known or motion == "free":
            assert parse(study).waves[1].direction == direction
        else:
            with pytest.raises(ConfigError, match=rf"waves.1.direction {direction:g} degrees: "):
                parse(study)


UNEVEN = [[0.0] * 6 for _ in range(6)]
UNEVEN[0][4] = 1.0
ASIDE = [[0.0] * 6 for _ in range(6)]
ASIDE[0][1] = ASIDE[1][0] = 5.0
LINE = {"line_to": [9.0, -20.0]}
PLATE = {"coefficient": 1.0, "area": 9.0}
WAVE = {"kind": "regular", "amplitude": 0.1, "period": 3.0}


@pytest.mark.parametrize(
    ("changes", "match"),
    [({"device": {"centre_of_mass": None}}, r"device.centre_of_mass: missing; .* has no pitch stiffness"),
        ({"motion": "free", "device": {"ballast_inertia": None}}, r"device.ballast_inertia: missing; motion 'free'"),
        ({"hydro": {"model": "body_exact"}}, r"hydro.model 'body_exact': follows heave alone; motion 'planar' needs linear"),
        ({"drag": {"sway": PLATE}}, r"drag.sway: motion 'planar' has none; needs drag of surge, heave, pitch"),
        ({"waves": [{**WAVE, "direction": 30.0}]}, r"waves.0.direction 30 degrees: motion 'planar' knows .* 0 and 180; needs"),
        ({"motion": "free"}, r"device.ballast_yaw_inertia: missing; motion 'free' needs it, because yaw turns the ballast, too$"),
        ({"hydro": {"rows": 30}}, r"hydro.solver: panels solve axisymmetric motions alone"),
        ({"reference_shape": "equilibrium"}, r"motion 'planar': knows shells about the undeformed sphere"),
        ({"modes": {"degree": 2, "order": 3}}, r"modes.order 3: needs at most modes.degree = 2"),
        ({"mooring": UNEVEN}, r"mooring: received .*; needs a symmetric matrix, because a spring has an energy"),
        ({"mooring": ASIDE}, r"mooring: received 5 between surge and sway, which motion 'planar' does not have; needs 0"),
        ({"mooring": [1.0] * 5}, r"mooring: received .*; needs six rows of six numbers, or the six"),
        ({"pto": {"port": {"line_to": [9.0, 1.0]}}}, r"pto.port.line_to: received z = 1 m; needs one below still water"),
        ({"pto": {"port": {**LINE, "line_from": [0.0, -3.0]}}}, r"pto.port.line_from: .*needs a point inside the sphere"),
        ({"pto": {"port": {"line_to": [0.0, -1.0]}}}, r"pto.port.line_to: .*needs an anchor outside the sphere")],
    ids=str,
)  # fmt: skip
def test_errors_of_planar_and_free_motion(changes, match):
    with pytest.raises(ConfigError, match=match) as error:
        parse(planar(**changes))
    assert "\n" not in str(error.value)


def test_free_buoy_has_every_order_twice_and_yaw():
    """The water is solved once per order."""
    study = parse(
        free(modes={"degree": 3, "order": 2}, mooring=ASIDE, drag={"sway": PLATE, "yaw": {**PLATE, "lever": 2.0}})
    )
    assert StudyPlan(study).coordinates == 6 + 4 + 2 * 3 + 2 * 2
    assert [block.order for block in StudyPlan(study).sweep_blocks] == [0, 1, 2]
    plane = StudyPlan(parse(planar(modes={"degree": 3, "order": 2}))).bem_blocks
    assert StudyPlan(study).bem_blocks.keys() == plane.keys()


PLATE_OF_DRAG = {"heave": {"coefficient": 0.5, "area": 12.57}}


@pytest.fixture(scope="module")
def seed():
    return load(SEED)


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        ({"hydro": {"model": "auto"}}, "drag: hydro.model 'auto' knows none; needs linear or body_exact"),
        (
            {"pto": {"force_limit": 1e3}},
            "drag: cannot be followed beside a nonlinear take-off, received law linear with force_limit 1000 N and "
            "stroke_limit inf m; needs law: linear without limits",
        ),
        ({"hydro": {"model": "assumed_pressure", "pressure": 9.0}}, "drag: hydro.model 'assumed_pressure' knows none;"),
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
        varied(seed, **{"drag": PLATE_OF_DRAG, **sections})
