"""Physical ranges: a number beyond its range is refused with the reason."""

import copy
import json
import math

import pytest
import yaml
from conftest import SEED
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from vsb.errors import ConfigError
from vsb.study import quantities
from vsb.study import study as config
from vsb.study.plan import StudyPlan
from vsb.study.quantities import Colatitude, Finite, NonNegative, Positive, within

BEYOND = [
    ("device.radius", 1e200, r"needs at most 1000 m, because .* nothing floats"),
    ("device.thickness", 2e-5, r"needs at least radius/3e4 = 6.667e-05 m, because .* a film that wrinkles"),
    ("device.young_modulus", 1e25, r"needs at most 1e\+16 Pa, because diamond has"),
    ("device.young_modulus", 1e-3, r"needs at least 1 Pa, because"),
    ("device.density", 1e-300, r"needs at least 0.1 kg/m\^3, because aerogel"),
    ("device.internal_pressure", 1e308, r"needs at most 1e\+08 Pa, because no vessel"),
    ("device.internal_pressure", -1e308, r"needs at least -1e\+08 Pa, because no vessel"),
    ("device.damping.beta", 1e300, r"needs at most 100 s, because"),
    ("water.density", 1e300, r"needs at most 20000 kg/m\^3, because mercury"),
    ("waves.0.amplitude", 1e200, r"needs at most 100 m, because the highest wave"),
    ("waves.0.period", 1e-9, r"needs at least 0.001 s, because"),
    ("simulation.duration", 1e12, r"needs at most 200000 s, because no sea stays the same"),
    ("simulation.initial_position", 1e300, r"needs at most 10000 m, because"),
]


def changed(path, value):
    """The seed study with one value changed."""
    raw = copy.deepcopy(yaml.safe_load(SEED.read_text()))
    *outer, last = (int(part) if part.isdigit() else part for part in path.split("."))
    here = raw
    for part in outer:
        here = here[part]
    here[last] = value
    return raw


@pytest.mark.parametrize(("path", "value", "message"), BEYOND, ids=[f"{path}={value}" for path, value, _ in BEYOND])
def test_number_beyond_its_range_is_refused_with_the_reason(path, value, message):
    with pytest.raises(ConfigError, match=message) as error:
        config.parse(changed(path, value))
    assert path.split(".")[0] in str(error.value)


@given(st.floats(-10.0, 10.0), st.floats(0.0, 10.0), st.floats())
def test_range_includes_its_ends(least, width, value):
    limits = within(least, least + width, "m", "of the test")
    if least <= value <= least + width:
        assert limits.func(value) == value
    else:
        bound = "at most" if value > least + width else "at least"
        with pytest.raises(ValueError, match=f"needs {bound} .* m, because of the test"):
            limits.func(value)


def test_band_below_the_peak_of_damping_is_refused():
    for highest, fits in ((2.0, False), (5.0, True)):
        plan = StudyPlan(config.parse(changed("hydro.omega_max", highest) | {"waves": [{"kind": "still"}]}))
        if fits:
            plan.check_waves()
        else:
            with pytest.raises(
                ConfigError, match=r"omega_max: received 2 rad/s, needs at least 5.515 .* beyond its peak; raise it"
            ):
                plan.check_waves()


def test_long_values_are_shortened_in_errors(tmp_path):
    with pytest.raises(ConfigError, match=r"received 'x{79}\.\.\. \(100002 characters\)") as error:
        config.parse(changed("study", "x" * 100_000))
    assert len(str(error.value)) < 400
    with pytest.raises(ConfigError, match=r"waves.0: kind 'x{79}\.\.\. \(100002 characters\)") as error:
        config.parse(changed("waves", [{"kind": "x" * 100_000}]))
    assert len(str(error.value)) < 400


@pytest.mark.parametrize(
    ("old", "new", "key", "line"),
    [
        ("radius: 2.0", "radius: {}", "device.radius", 4),
        ("clamp: 90", "clamp: [0, {}]", "designs.VSWEC90.clamp.1", 17),
        ("FSB: {", "? {}\n  : {", "designs.a key", 13),
    ],
)
def test_integer_of_too_many_digits_is_refused(tmp_path, old, new, key, line):
    file = tmp_path / "digits.yaml"
    file.write_text(SEED.read_text().replace(old, new.replace("{}", f"0x{'f' * 20_000}")))
    expected = rf"^{file}:{line}: {key}: received a number of too many digits; needs at most 4300$"
    with pytest.raises(ConfigError, match=expected):
        config.load(file)


def test_junk_of_json_is_one_line():
    for junk in (None, [], {}, "x", 10**5000, [[1]], {"a": json.loads("[[[]]]")}):
        with pytest.raises(ConfigError) as error:
            config.parse(changed("device.mass", junk))
        assert "\n" not in str(error.value)
        assert len(str(error.value)) < 400


@pytest.mark.parametrize(
    ("quantity", "taken", "refused"),
    [
        (Positive, [1e-300, 1e300], [0.0, -1.0]),
        (NonNegative, [0.0, 1e300], [-1e-300]),
        (Finite, [-1e300, 0.0, 1e300], []),
        (Colatitude, [0.0, 180.0], [-1e-9, 180.001]),
    ],
)
def test_quantities_are_finite_and_bounded(quantity, taken, refused):
    checked = TypeAdapter(quantity)
    assert [checked.validate_python(value) for value in taken] == taken
    for value in (*refused, math.nan, math.inf, -math.inf):
        with pytest.raises(ValidationError, match=r"greater|less|finite"):
            checked.validate_python(value)


@pytest.mark.parametrize(
    ("label", "body", "motion", "rigid"),
    [("Heave", "", "Heave", True), ("float__Heave", "float", "Heave", True), ("Mode7", "", "Mode7", False),
     ("left__float__Pitch", "left__float", "Pitch", True), ("Heave__Mode7", "Heave", "Mode7", False)],
)  # fmt: skip
def test_labels_of_motions_of_several_bodies(label, body, motion, rigid):
    """A body's name may be two words, or that of a motion."""
    assert (quantities.body_of(label), quantities.motion_of(label)) == (body, motion)
    assert quantities.is_rigid(label) is rigid


def test_places_of_each_body():
    labels = ["b__Heave", "a__Heave", "b__Pitch", "a__Mode7", "b__Mode1"]
    assert quantities.of_bodies(labels) == {"b": [0, 2, 4], "a": [1, 3]}
    assert quantities.of_bodies(["Heave", "Mode7"]) == {"": [0, 1]}
