import copy
import json

import pytest
import yaml
from conftest import SEED
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb import config
from vsb.config import canonical, content_id
from vsb.errors import ConfigError

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
    (("device", "thickness"), -0.01, r"device.thickness: received -0.01; Input should be greater than 0"),
    (("device", "thickness"), 0.5, r"device: thickness 0.5 m: thin-shell theory \(C3\) needs less than radius/10 = 0.2 m"),
    (("device", "radius"), "two", r"device.radius: received 'two'; .*valid number"),
    (("device", "radius"), True, r"device.radius: received True; a number is needed"),
    (("device", "mass"), 1e9, r"study: device.mass 1e\+09 kg: the buoy would sink; needs less than 34348.\d kg"),
    (("device", "mass"), 100.0, r"device: mass 100 kg: needs at least the mass of the shell itself"),
    (("device", "internal_pressure"), 5.0, r"device.internal_pressure: received 5.0; .*prestress"),
    (("modes", "basis"), "spectral", r"modes.basis: received 'spectral'; Input should be 'paper', 'membrane' or 'full'"),
    (("modes", "degree"), 2.5, r"modes.degree: received 2.5; .*valid integer"),
    (("designs",), {}, r"designs: .*at least 1"),
    (("designs",), {"A": {"flexible": False, "clamp": 0}}, r"designs.A: clamp \[0.0\]: a rigid design .* remove one"),
    (("designs",), {"A": {"clamp": 200}}, r"designs.A.clamp.0: received 200; .*less than or equal to 180"),
    (("waves",), [], r"waves: received \[\]; .*at least 1 item"),
    (("waves",), [{"kind": "regular", "amplitude": 0.1, "period": 0.3}], r"waves.0 .*too short .*period of at least 0.5236 s"),
    (("waves",), [{"kind": "tsunami"}], r"waves.0: .*'still', 'regular', 'jonswap'"),
    (("waves",), [{"kind": "still"}, {"kind": "still"}], r"waves .*same sea is listed twice"),
    (("water", "depth"), 1.5, r"water.depth 1.5 m: needs more than the draft of the buoy, 2 m"),
    (("hydro", "model"), "magic", r"hydro.model: received 'magic'; Input should be 'linear'"),
    (("hydro", "omega"), [3.0, 2.0], r"hydro: omega \[3.0, 2.0\]: frequencies must ascend"),
    (("hydro", "omega"), [13.0], r"hydro.omega 13 rad/s: needs at most hydro.omega_max = 12 rad/s"),
    (("simulation", "window"), [50, 70], r"simulation: window \[50.0, 70.0\]: needs 0 <= start < end <= duration = 60 s"),
    (("study",), "hydro", r"study: received 'hydro'; 'hydro' is the name of a results folder"),
    (("study",), "../evil", r"study: received '../evil'; String should match pattern"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "value", "message"), BAD, ids=[".".join(map(str, p)) + f"={v}" for p, v, _ in BAD])
def test_bad_value_is_one_line_with_file_key_and_need(tmp_path, path, value, message):
    file = tmp_path / "bad.yaml"
    file.write_text(yaml.safe_dump(changed(path, value)))
    with pytest.raises(ConfigError, match=message) as error:
        config.load(file)
    assert str(error.value).startswith(f"{file}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- a\n- b\n", "received list, needs a mapping"),
        ("a: [1\n", "not valid YAML"),
        ("a: 1\na: 2\n", "key 'a' is given twice"),
    ],
)
def test_what_is_no_study_at_all(tmp_path, text, message):
    file = tmp_path / "odd.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=message) as error:
        config.load(file)
    assert "\n" not in str(error.value)


def test_missing_file():
    with pytest.raises(ConfigError, match=r"nowhere.yaml: cannot be read \(No such file"):
        config.load("nowhere.yaml")


def shuffled(data, rnd):
    if isinstance(data, dict):
        keys = list(data)
        rnd.shuffle(keys)
        return {key: shuffled(data[key], rnd) for key in keys}
    return [shuffled(item, rnd) for item in data] if isinstance(data, list) else data


def respelled(data):
    """Numbers as YAML readers may hand them over: 1e5 as text, whole numbers without a point."""
    if isinstance(data, dict):
        return {key: respelled(value) for key, value in data.items()}
    if isinstance(data, list):
        return [respelled(item) for item in data]
    if isinstance(data, float):
        return int(data) if data.is_integer() and abs(data) < 1e6 else f"{data!r}"
    return data


@settings(max_examples=25, deadline=None)
@given(st.randoms(use_true_random=False))
def test_canonical_form_ignores_order_and_spelling(rnd):
    studies = [config.parse(raw) for raw in (RAW, shuffled(RAW, rnd), respelled(RAW))]
    assert len({canonical(study) for study in studies}) == 1
    assert config.parse(json.loads(canonical(studies[0]))) == studies[0]


@given(st.floats(0.5, 3.0), st.floats(0.5, 3.0))
def test_content_id_tells_values_apart(first, second):
    ids = [content_id({"radius": value}) for value in (first, second)]
    assert (ids[0] == ids[1]) == (first == second)


def test_floating_height_balances_the_weight(seed):
    depth = seed.draft
    assert 1025.0 * 3.141592653589793 * depth**2 * (6.0 - depth) / 3 == pytest.approx(17170.0, rel=1e-12)
