import ast
import copy
import json
import re

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import SEED, varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConfigError
from vsb.hydro import quality
from vsb.study import study as config
from vsb.study.study import canonical, content_id

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
    (("device", "gas"), {"adiabatic_index": 0.5}, r"device.gas.adiabatic_index: received 0.5"),
    (("reference_shape",), "bent", r"reference_shape: received 'bent'; .*'undeformed' or 'equilibrium'"),
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
    (("device", "poisson_ratio"), 0.5, r"device.poisson_ratio: received 0.5; Input should be less than 0.5"),
    (("device", "mass"), float("nan"), r"device.mass: received nan; Input should be"),
    (("device", "damping", "beta"), -1.0, r"device.damping.beta: received -1.0; .*greater than or equal to 0"),
    (("modes", "degree"), True, r"modes.degree: received True; a number is needed, not true/false"),
    (("modes", "degree"), 41, r"modes.degree: received 41; Input should be less than or equal to 40"),
    (("hydro", "rows"), False, r"hydro.rows: received False; a number is needed"),
    (("hydro", "tolerance"), 1.0, r"hydro.tolerance: received 1.0; Input should be less than or equal to 0.1"),
    (("hydro", "omega"), [1.0, 1.0], r"hydro: omega \[1.0, 1.0\]: frequencies must ascend without repetition"),
    (("designs",), {"A": {"clamp": [10, -1]}}, r"designs.A.clamp.1: received -1; .*greater than or equal to 0"),
    (("designs",), {"A": {"clamp": True}}, r"designs.A.clamp.0: received True; a number is needed"),
    (("designs",), {"A B": {}}, r"designs.A B.\[key\]: received 'A B'; String should match pattern"),
    (("waves",), [{"kind": "regular", "amplitude": 0.1, "period": 2, "phase": 1}], r"waves.0.regular.phase: received 1; unknown key"),
    (("waves",), [{"kind": "white_noise", "hs": 1, "band": [2.0, 2.001]}], r"waves.0.white_noise.band: .*one at least 1 % higher"),
    (("waves",), [{"kind": "white_noise", "hs": 1, "band": [2.0, 20.0]}], r"waves.0.band .*needs at most hydro.omega_max = 12"),
    (("water", "depth"), 1e5, r"water.depth: .*needs at most 20000 m, or .inf for deep water"),
    (("hydro",), {"power_tolerance": 0.1}, r"power_tolerance 0.1: only model auto has one"),
    (("hydro",), {"model": "auto", "power_tolerance": 0.9}, r"hydro.power_tolerance: received 0.9"),
    (("waves",), [{"kind": "jonswap", "hs": 1, "tp": 0.4}], r"waves.0 jonswap_Hs1_Tp0.4_g3.3_s1: the wave is too short"),
    (("waves",), [{"kind": "jonswap", "hs": 1, "tp": 8, "gamma": 0.5}], r"waves.0.jonswap.gamma: received 0.5; .*greater than or equal to 1"),
    (("simulation", "window"), [50, 50], r"simulation: window \[50.0, 50.0\]: needs 0 <= start < end"),
    (("simulation", "window"), [60], r"simulation.window.1: .*required"),
    (("pto", "damping"), "soft", r"pto.damping: received 'soft'; .*valid number"),
    (("study",), "a" * 65, r"study: received 'a+'; String should have at most 64 characters"),
    (("waves",), [{"kind": "jonswap", "hs": 1, "tp": 4, "seed": 10**400}], r"waves.0.jonswap: seed of 401 digits: needs at most 2\^32"),
    (("hydro", "accept"), ["haskind", "haskin"], r"hydro.accept \['haskin'\]: no such check; needs some of error_estimate, .*haskind"),
    (("study",), "logs", r"study: received 'logs'; 'logs' is the name of a results folder"),
    (("study",), "benchmarks", r"study: received 'benchmarks'; .*choose a name other than hydro, hydro_precision, barge, logs, benchmarks"),
    (("study",), "hydro", r"study: received 'hydro'; 'hydro' is the name of a results folder"),
    (("study",), "../evil", r"study: received '../evil'; String should match pattern"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "value", "message"), BAD, ids=[".".join(map(str, p)) + f"={v}" for p, v, _ in BAD])
def test_bad_value_is_one_line_with_file_key_and_need(tmp_path, path, value, message):
    file = tmp_path / "bad.yaml"
    file.write_text(yaml.safe_dump(changed(path, value)))
    with pytest.raises(ConfigError, match=message) as error:
        config.load(file)
    assert re.match(rf"{re.escape(str(file))}:\d+: ", str(error.value))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- a\n- b\n", "received list, needs a mapping"),
        ("a: [1\n", "not valid YAML"),
        ("a: 1\na: 2\n", "key 'a' is given twice"),
        ("device: {radius: 2, mass: 1, radius: 3}\n", r"key 'radius' is given twice.* line 1, column 30"),
        ("", "received NoneType, needs a mapping with keys study, device"),
        ("a: !!python/object:os.system 1\n", "not valid YAML .*could not determine a constructor"),
        ("study: alone\n", r"device: missing, but required: the spherical buoy, .* \(and 2 more\)"),
        pytest.param("? [a, b]\n: 1\n", "not valid YAML"),
        pytest.param("? {a: 1}\n: 1\n", "not valid YAML"),
        pytest.param("a: 2020-99-99\n", "not valid YAML"),
        pytest.param("a: " + 5000 * "[" + 5000 * "]", r"not valid YAML \(nested too deeply\); give a study file"),
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


@settings(max_examples=25)
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


def test_file_that_is_no_text(tmp_path):
    file = tmp_path / "binary.yaml"
    file.write_bytes(b"\xff\xfe\x00a")
    with pytest.raises(ConfigError, match=r"binary.yaml: not valid YAML \('utf-8' codec can't decode"):
        config.load(file)


def test_folder_in_place_of_a_file(tmp_path):
    with pytest.raises(ConfigError, match=r"cannot be read \(Is a directory\); give the path of a study file"):
        config.load(tmp_path)


@pytest.mark.parametrize("raw", [None, [], "seed", 3.0])
def test_data_that_are_no_mapping_name_what_was_received(raw):
    with pytest.raises(ConfigError, match=f"here: received {type(raw).__name__}, needs a mapping"):
        config.parse(raw, source="here")


def test_a_misspelt_key_is_named_before_the_key_it_left_out(seed):
    data = seed.model_dump()
    data["device"]["youngs_modulus"] = data["device"].pop("young_modulus")
    with pytest.raises(ConfigError, match=r"device.youngs_modulus: received 10000000.0; unknown key; .*\(and 1 more\)"):
        config.parse(data)


def test_line_break_in_a_key_stays_in_one_line():
    with pytest.raises(ConfigError) as error:
        config.parse(changed(("designs",), {"A\n": {}}))
    assert "\n" not in str(error.value)


def test_absurd_radius_is_a_configuration_error():
    with pytest.raises(ConfigError, match=r"device"):
        config.parse(changed(("device", "radius"), 1e200))


def test_first_of_several_errors_is_told_and_the_rest_counted():
    raw = changed(("device", "thickness"), -1.0)
    raw["pto"]["damping"] = -1.0
    with pytest.raises(ConfigError, match=r"device.thickness: received -1.0; .* \(and 1 more\)$"):
        config.parse(raw)


@pytest.mark.parametrize("spelling", ["1e5", "100000", "100000.0", "1.0e+5", "'1e5'", "+1E5"])
def test_spellings_of_one_number(tmp_path, spelling):
    file = tmp_path / "a.yaml"
    file.write_text(SEED.read_text().replace("10.0e6", spelling))
    assert content_id(config.load(file)) == content_id(config.parse(changed(("device", "young_modulus"), 1e5)))


def test_negative_zero_is_zero():
    ids = [content_id(config.parse(changed(("simulation", "initial_position"), x))) for x in (0.0, -0.0)]
    assert ids[0] == ids[1]


LEAVES = [
    (("device", "radius"), st.floats(2.0, 3.0)),
    (("device", "young_modulus"), st.floats(1e6, 1e12)),
    (("hydro", "tolerance"), st.floats(1e-6, 0.1)),
    (("pto", "damping"), st.floats(0.0, 1e5).map(abs)),
    (("simulation", "initial_velocity"), st.floats(0.1, 1.0)),
    (("modes", "degree"), st.integers(0, 40)),
]


@pytest.mark.parametrize(("path", "values"), LEAVES, ids=[".".join(path) for path, _ in LEAVES])
def test_id_of_a_study_changes_if_and_only_if_a_value_does(path, values):
    @settings(max_examples=20)
    @given(values, values)
    def check(first, second):
        ids = [content_id(config.parse(changed(path, value))) for value in (first, second, first)]
        assert ids[0] == ids[2]
        assert (ids[0] == ids[1]) == (first == second)

    check()


def test_canonical_form_of_infinity_and_containers():
    assert (
        canonical({"b": (1.0, float("inf")), "a": [-float("inf"), None, True]})
        == '{"a":["-inf",null,true],"b":[1.0,"inf"]}'
    )
    assert len(content_id({})) == 16


def test_nan_has_no_canonical_form():
    with pytest.raises(ValueError, match="Out of range float values are not JSON compliant"):
        canonical({"a": float("nan")})


def test_a_study_cannot_be_altered(seed):
    with pytest.raises(ValueError, match="Instance is frozen"):
        seed.study = "other"


def test_one_clamp_may_stand_alone():
    assert config.Design(clamp=45) == config.Design(clamp=[45.0])


def test_half_the_displacement_floats_at_the_equator(seed):
    half = 2 / 3 * 3.141592653589793 * 8 * 1025.0
    assert varied(seed, device={"mass": half}).centre_height == pytest.approx(0.0, abs=1e-12)


@given(st.floats(1400.0, 34000.0))
def test_any_afloat_mass_is_the_mass_of_the_water_it_displaces(mass):
    study = config.parse(changed(("device", "mass"), mass))
    assert 1025.0 * 3.141592653589793 * study.draft**2 * (6.0 - study.draft) / 3 == pytest.approx(mass, rel=1e-11)
    assert study.centre_height + study.draft == pytest.approx(2.0, rel=1e-14)


def test_reference_is_the_first_rigid_design(seed):
    assert seed.reference_design == "FSB"
    assert seed.flexible
    rigidless = varied(seed, designs={"A": {}, "B": {"clamp": 0}})
    assert rigidless.reference_design is None


@pytest.mark.parametrize(
    ("wave", "label", "words"),
    [
        ({"kind": "still"}, "still", "still water"),
        (
            {"kind": "regular", "amplitude": 0.179, "period": 2.5},
            "regular_A0.179_T2.5",
            "regular waves of 0.179 m amplitude and 2.5 s period",
        ),
        (
            {"kind": "jonswap", "hs": 0.5, "tp": 4, "seed": 7},
            "jonswap_Hs0.5_Tp4_g3.3_s7",
            "a JONSWAP sea of Hs = 0.5 m and Tp = 4 s",
        ),
        (
            {"kind": "pierson_moskowitz", "hs": 0.5, "tp": 4, "seed": 7},
            "pierson_moskowitz_Hs0.5_Tp4_s7",
            "a Pierson-Moskowitz sea of Hs = 0.5 m and Tp = 4 s",
        ),
        (
            {"kind": "white_noise", "hs": 0.5, "band": [1, 3], "seed": 7},
            "white_noise_Hs0.5_w1-3_s7",
            "white noise of 1 to 3 rad/s and Hs = 0.5 m",
        ),
    ],
)
def test_labels_and_words_of_seas(seed, wave, label, words):
    (read,) = varied(seed, waves=[wave]).waves
    assert (read.label, read.description) == (label, words)


@pytest.mark.parametrize("mass", [6000.0, 17170.0, 28000.0])
def test_heave_feels_the_waterplane_where_the_buoy_floats(seed, mass):
    """Natural frequency without the water's inertia: the force of the water, by how it changes with draft."""
    study = varied(seed, device={"mass": mass})
    h = 1e-4
    low, high = ((3 * study.device.radius - d) * d**2 / 3 for d in (study.draft - h, study.draft + h))
    stiffness = study.water.density * study.water.gravity * np.pi * (high - low) / (2 * h)
    assert study.heave_frequency == pytest.approx(np.sqrt(stiffness / mass), rel=1e-7)


def test_figures_are_published_of_designs_there_are(seed):
    published = {"source": "x", "values": {"FSB": {"energy": 1.0}, "VSWEC45": {"energy": 2.0}}}
    with pytest.raises(ConfigError, match=r"published.values \['VSWEC45'\]: no such design; needs some of FSB, VSWEC"):
        config.parse({**seed.model_dump(), "published": published})


def test_checks_a_study_may_accept_are_those_there_are():
    """Names are known before anything is solved; every literal of the module is offered as the name of an estimate."""
    tree = ast.parse((SEED.parents[1] / "vsb" / "hydro" / "quality.py").read_text(encoding="utf-8"))
    literals = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    omega = np.arange(1, 9) * 0.5
    pair = ("influenced_dof", "radiating_dof")
    square = np.tile(np.eye(2), (8, 1, 1))
    ds = xr.Dataset(
        {
            "added_mass": (("omega", *pair), square),
            "radiation_damping": (("omega", *pair), square),
            "added_mass_inf": (pair, np.eye(2)),
            "excitation_force": (("omega", "wave_direction", "influenced_dof"), np.ones((8, 1, 2)) + 0j),
        },
        coords={"omega": omega},
    )
    estimates = [dict.fromkeys((name for name in literals if isinstance(name, str)), 0.0)]
    found = [
        *quality.pointwise_checks(ds, np.inf, 1e3, 9.81),
        *quality.sweep_checks(ds),
        *quality.estimate_checks(estimates, 1e-3),
    ]
    assert sorted(check.name for check in found) == sorted(config.CHECKS)
    assert len(set(config.CHECKS)) == len(config.CHECKS)


@pytest.mark.parametrize("name", config.CHECKS)
def test_every_check_may_be_accepted(name):
    assert config.parse(changed(("hydro", "accept"), [name])).hydro.accept == (name,)
