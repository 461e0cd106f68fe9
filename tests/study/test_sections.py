"""Wrong values of sections, one line each; seas; directions of motion and drag."""

import copy
import re

import pytest
import yaml
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.pipeline.graph import StudyPlan
from vsb.study import study as config
from vsb.study.study import load, parse

RAW = yaml.safe_load(SEED.read_text())


def changed(path, value):
    raw = copy.deepcopy(RAW)
    *parents, last = path
    target = raw
    for key in parents:
        target = target[key]
    target[last] = value
    return raw


BAD = [
    (("device", "thicknes"), 0.01, r"device.thicknes: received 0.01; unknown key"),
    (("device", "thickness"), -0.01, r"device.thickness: received -0.01; needs a number above 0"),
    (("device", "thickness"), 0.5, r"device: thickness 0.5 m: thin-shell theory \(C3\) needs less than radius/10 = 0.2 m"),
    (("device", "radius"), "two", r"device.radius: received 'two'; needs a number: .*sphere.*\[m\]"),
    (("water", "depth"), "infinite", r"water.depth: received 'infinite'; needs a number.* did you mean .inf\?"),
    (("waves",), [{"type": "regular"}], r"waves.0: kind: missing, but required; did you mean kind in place of type\?"),
    (("simulation", "window"), 40.0, r"simulation.window: received 40.0; needs a list, \[40.0\]"),
    (("device", "mass"), 1e9, r"study: device.mass 1e\+09 kg: the buoy would sink; needs less than 34348.\d kg"),
    (("reference_shape",), "bent", r"reference_shape: received 'bent'; .*'undeformed' or 'equilibrium'"),
    (("modes", "basis"), "spectral", r"modes.basis: received 'spectral'; needs 'paper', 'membrane' or 'full'"),
    (("modes", "degree"), 2.5, r"modes.degree: received 2.5; needs a whole number"),
    (("designs",), {}, r"designs: .*at least 1"),
    (("designs",), {"A": {"flexible": False, "clamp": 0}}, r"designs.A: clamp \[0.0\]: a rigid design .* remove one"),
    (("waves",), [], r"waves: received \[\]; .*at least 1 item"),
    (("waves",), [{"kind": "regular", "amplitude": 0.1, "period": 0.3}], r"waves.0 .*too short .*period of at least 0.5236 s"),
    (("waves",), [{"kind": "tsunami"}], r"waves.0: .*'still', 'regular', 'jonswap'"),
    (("waves",), [{"kind": "still"}, {"kind": "still"}], r"waves .*same sea is listed twice"),
    (("water", "depth"), 1.5, r"water.depth 1.5 m: needs more than the draft of the buoy, 2 m"),
    (("hydro", "model"), "magic", r"hydro.model: received 'magic'; needs 'linear'"),
    (("hydro", "omega"), [3.0, 2.0], r"hydro: omega \[3.0, 2.0\]: frequencies must ascend"),
    (("hydro", "omega"), [3.0, 13.0], r"hydro.omega 13 rad/s: needs at most hydro.omega_max = 12 rad/s"),
    (("simulation", "window"), [50, 70], r"simulation: window \[50.0, 70.0\]: needs 0 <= start < end <= duration = 60 s"),
    (("device", "mass"), float("nan"), r"device.mass: received nan; needs a"),
    (("device", "damping", "beta"), -1.0, r"device.damping.beta: received -1.0; needs a number of at least 0"),
    (("modes", "degree"), True, r"modes.degree: received True; a number is needed, not true/false"),
    (("modes", "degree"), 121, r"modes.degree: received 121; needs a number of at most 120"),
    (("hydro", "rows"), False, r"hydro.rows: received False; a number is needed"),
    (("hydro", "tolerance"), 1.0, r"hydro.tolerance: received 1.0; needs a number of at most 0.02"),
    (("designs",), {"A": {"clamp": [10, -1]}}, r"designs.A.clamp.1: received -1; needs a number of at least 0"),
    (("designs",), {"A B": {}}, r"designs.A B: received 'A B'; needs letters, digits and _"),
    (("waves",), [{"kind": "white_noise", "hs": 1, "band": [2.0, 20.0]}], r"waves.0.band .*needs at most hydro.omega_max = 12"),
    (("water", "depth"), 1e5, r"water.depth: .*needs at most 20000 m, or .inf for deep water"),
    (("hydro",), {"power_tolerance": 0.1}, r"power_tolerance 0.1: only model auto has one"),
    (("hydro",), {"model": "assumed_pressure"}, r"hydro: pressure: missing; model assumed_pressure needs its amplitude in Pa"),
    (("waves",), [{"kind": "jonswap", "hs": 1, "tp": 0.4}], r"waves.0 jonswap_Hs1_Tp0.4_g3.3_s1: the wave is too short"),
    (("simulation", "window"), [60], r"simulation.window.1: .*too short"),
    (("study",), "a" * 65, r"study: received 'a+'; needs at most 64 characters"),
    (("hydro", "accept"), ["haskind", "haskin"], r"hydro.accept \['haskin'\]: no such check; needs some of error_estimate, .*haskind"),
    (("study",), "../evil", r"study: received '../evil'; needs letters, digits and _"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "value", "message"), BAD, ids=[".".join(map(str, p)) + f"={v}" for p, v, _ in BAD])
def test_invalid_value_is_one_line_with_file_key_and_need(tmp_path, path, value, message):
    file = tmp_path / "bad.yaml"
    file.write_text(yaml.safe_dump(changed(path, value)))
    with pytest.raises(ConfigError, match=message) as error:
        config.load(file)
    assert re.match(rf"{re.escape(str(file))}:\d+: ", str(error.value))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("wave", "label", "words"),
    [
        ({"kind": "still"}, "still", "still water"),
        ({"kind": "regular", "amplitude": 0.179, "period": 2.5}, "regular_A0.179_T2.5", "regular waves of 0.179 m amplitude and 2.5 s period"),
        ({"kind": "jonswap", "hs": 0.5, "tp": 4, "seed": 7}, "jonswap_Hs0.5_Tp4_g3.3_s7", "a JONSWAP sea of Hs = 0.5 m and Tp = 4 s"),
        ({"kind": "pierson_moskowitz", "hs": 0.5, "tp": 4}, "pierson_moskowitz_Hs0.5_Tp4_s1", "a Pierson-Moskowitz sea of Hs = 0.5 m and Tp = 4 s"),
        ({"kind": "white_noise", "hs": 0.5, "band": [1, 3], "seed": 7}, "white_noise_Hs0.5_w1-3_s7", "white noise of 1 to 3 rad/s and Hs = 0.5 m"),
    ],
)  # fmt: skip
def test_labels_and_descriptions_of_seas(seed, wave, label, words):
    (read,) = varied(seed, waves=[wave]).waves
    assert (read.label, read.description) == (label, words)


def test_a_sea_of_finite_depth_is_in_water_of_that_depth(seed):
    wave = {"kind": "tma", "hs": 0.5, "tp": 4, "depth": 8}
    (read,) = varied(seed, waves=[wave], water={"depth": 8.0}).waves
    words = "a TMA sea of Hs = 0.5 m and Tp = 4 s in 8 m of water"
    assert (read.label, read.description) == ("tma_Hs0.5_Tp4_g3.3_h8_s1", words)
    with pytest.raises(
        ConfigError, match=r"waves\.0\.depth 8 m: is that of another water; needs water\.depth, here inf m"
    ):
        varied(seed, waves=[wave])


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
