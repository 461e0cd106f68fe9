"""Values of a study: range, unit and the one line that refuses others."""

import copy
import re

import pytest
import yaml
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study import study as config

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
    (("modes", "degree"), 91, r"modes.degree: received 91; needs a number of at most 90"),
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
