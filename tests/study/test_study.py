import json

import numpy as np
import pytest
from conftest import SEED, varied
from hypothesis import given, settings
from hypothesis import strategies as st
from study.test_sections import RAW, changed

from vsb.errors import ConfigError
from vsb.study import study as config
from vsb.study.study import canonical, content_id


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


def test_absurd_radius_is_a_configuration_error():
    with pytest.raises(ConfigError, match=r"device"):
        config.parse(changed(("device", "radius"), 1e200))


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


def test_half_the_displacement_floats_at_the_equator(seed):
    half = 2 / 3 * 3.141592653589793 * 8 * 1025.0
    assert varied(seed, device={"mass": half}).centre_height == pytest.approx(0.0, abs=1e-12)


@given(st.floats(1400.0, 34000.0))
def test_any_afloat_mass_is_the_mass_of_the_water_it_displaces(mass):
    study = config.parse(changed(("device", "mass"), mass))
    assert 1025.0 * 3.141592653589793 * study.draft**2 * (6.0 - study.draft) / 3 == pytest.approx(mass, rel=1e-11)
    assert study.centre_height + study.draft == pytest.approx(2.0, rel=1e-14)


def test_reference_is_the_first_rigid_design_by_name_as_stages_read_it(seed):
    assert seed.reference_design == "FSB"
    assert seed.flexible
    both = varied(seed, designs={"locked": {"flexible": False}, "free": {"flexible": False}})
    read = config.parse(json.loads(canonical(both)))
    assert both.reference_design == read.reference_design == "free"
    rigidless = varied(seed, designs={"A": {}, "B": {"clamp": 0}})
    assert rigidless.reference_design is None


@pytest.mark.parametrize("mass", [6000.0, 17170.0, 28000.0])
def test_heave_feels_the_waterplane_where_the_buoy_floats(seed, mass):
    """Natural frequency without the water's inertia: the force of the water, by how it changes with draft."""
    study = varied(seed, device={"mass": mass})
    h = 1e-4
    low, high = ((3 * study.device.radius - d) * d**2 / 3 for d in (study.draft - h, study.draft + h))
    stiffness = study.water.density * study.water.gravity * np.pi * (high - low) / (2 * h)
    assert study.heave_frequency == pytest.approx(np.sqrt(stiffness / mass), rel=1e-7)
