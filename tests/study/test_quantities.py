"""Physical ranges: a number beyond one is refused with its reason, one inside is not."""

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
    ("device.radius", 1e-3, r"needs at least 0.01 m, because below surface tension"),
    ("device.thickness", 2e-5, r"needs at least radius/3e4 = 6.667e-05 m, because .* a film that wrinkles"),
    ("device.young_modulus", 1e308, r"needs at most 1e\+16 Pa, because diamond has"),
    ("device.young_modulus", 1e25, r"needs at most 1e\+16 Pa, because diamond has"),
    ("device.young_modulus", 1e-3, r"needs at least 1 Pa, because"),
    ("device.poisson_ratio", -0.999, r"needs at least -0.99 , because"),
    ("device.density", 1e6, r"needs at most 25000 kg/m\^3, because .*osmium"),
    ("device.density", 1e-300, r"needs at least 0.1 kg/m\^3, because aerogel"),
    ("device.mass", 1e-300, r"needs at least the mass of the shell itself"),
    ("device.internal_pressure", 1e308, r"needs at most 1e\+08 Pa, because no vessel"),
    ("device.internal_pressure", -1e308, r"needs at least -1e\+08 Pa, because no vessel"),
    ("device.internal_pressure", -10e6, r"needs more than -101325 Pa, because no gas is thinner than vacuum"),
    ("device.gas", {"atmospheric_pressure": 1e9}, r"needs at most 1e\+07 Pa, because .*Venus"),
    ("device.damping.alpha", 1e300, r"needs at most 10000 1/s, because"),
    ("device.damping.beta", 1e300, r"needs at most 100 s, because"),
    ("water.density", 1e300, r"needs at most 20000 kg/m\^3, because mercury"),
    ("water.gravity", 1e-9, r"needs at least 0.01 m/s\^2, because"),
    ("pto.damping", 1e300, r"needs at most 1e\+12 N s/m, because"),
    ("waves.0.amplitude", 1e200, r"needs at most 100 m, because the highest wave"),
    ("waves.0.period", 1e-9, r"needs at least 0.001 s, because"),
    ("simulation.duration", 1e12, r"needs at most 200000 s, because no sea stays the same"),
    ("simulation.initial_position", 1e300, r"needs at most 10000 m, because"),
    ("simulation.initial_velocity", -1e300, r"needs at least -1000 m/s, because"),
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
def test_a_number_beyond_its_range_is_refused_with_the_reason(path, value, message):
    with pytest.raises(ConfigError, match=message) as error:
        config.parse(changed(path, value))
    assert path.split(".")[0] in str(error.value)


@given(st.floats(-10.0, 10.0), st.floats(0.0, 10.0), st.floats())
def test_a_range_holds_its_ends_and_nothing_beyond(least, width, value):
    limits = within(least, least + width, "m", "of the test")
    if least <= value <= least + width:
        assert limits.func(value) == value
    else:
        bound = "at most" if value > least + width else "at least"
        with pytest.raises(ValueError, match=f"needs {bound} .* m, because of the test"):
            limits.func(value)


def test_long_runs_are_refused_by_what_they_would_record():
    raw = changed("waves", [{"kind": "regular", "amplitude": 0.01, "period": 0.6}])
    raw["simulation"] |= {"duration": 1.9e5, "window": [0.0, 1.9e5]}
    with pytest.raises(
        ConfigError, match=r"duration: received 190000 s, needs at most 1.5e\+05 s in waves.0 .*recorded"
    ):
        config.parse(raw).check_record()
    raw["simulation"] |= {"duration": 1000.0, "window": [0.0, 1000.0], "method": "convolution"}
    with pytest.raises(
        ConfigError, match=r"received 1000 s, needs at most 196.6 s .* a convolution needs all of its past"
    ):
        config.parse(raw).check_record()


@pytest.mark.parametrize("wave", [{"kind": "still"}, {"kind": "jonswap", "hs": 0.1, "tp": 4.0}])
def test_a_window_too_short_for_the_motion_is_refused(wave):
    raw = changed("waves", [wave])
    for end, fits in ((50.01, False), (50.5, True)):
        raw["simulation"]["window"] = [50.0, end]
        if fits:
            config.parse(raw).check_record()
        else:
            with pytest.raises(
                ConfigError, match=r"window: received \[50.0, 50.01\] s, needs to be at least .* s long"
            ):
                config.parse(raw).check_record()


def test_a_band_that_ends_before_the_peak_of_damping_is_refused():
    for highest, fits in ((2.0, False), (5.0, True)):
        plan = StudyPlan(config.parse(changed("hydro.omega_max", highest) | {"waves": [{"kind": "still"}]}))
        if fits:
            plan.check_waves()
        else:
            with pytest.raises(
                ConfigError, match=r"omega_max: received 2 rad/s, needs at least 5.515 .* beyond its peak; raise it"
            ):
                plan.check_waves()


@pytest.mark.parametrize("share", [5e-5, 0.99995])
def test_a_waterline_at_a_pole_is_refused(share):
    raw = changed("device.mass", share * 4 / 3 * math.pi * 8.0 * 1025.0)
    raw["device"]["density"] = 0.1
    with pytest.raises(
        ConfigError, match=r"device.mass .* kg: needs .* because a waterline within 0.01 radii of a pole"
    ):
        config.parse(raw)


def test_no_page_of_a_value_is_repeated(tmp_path):
    with pytest.raises(ConfigError, match=r"received 'x{79}\.\.\. \(100002 characters\)") as error:
        config.parse(changed("study", "x" * 100_000))
    assert len(str(error.value)) < 400
    with pytest.raises(ConfigError, match=r"waves.0: kind 'x{79}\.\.\. \(100002 characters\)") as error:
        config.parse(changed("waves", [{"kind": "x" * 100_000}]))
    assert len(str(error.value)) < 400


@pytest.mark.parametrize(
    "number", [f"0x{'f' * 20_000}", "7" * 20_000, f"-{'7' * 4301}"], ids=["hex", "decimal", "least"]
)
@pytest.mark.parametrize(
    ("old", "new", "key", "line"),
    [
        ("radius: 2.0", "radius: {}", "device.radius", 4),
        ("kind: regular", "kind: {}", "waves.0.kind", 21),
        ("clamp: 90", "clamp: [0, {}]", "designs.VSWEC90.clamp.1", 17),
        ("FSB: {", "? {}\n  : {", "designs.a key", 13),
    ],
)
def test_no_integer_of_more_digits_than_can_be_printed_reaches_a_library(
    tmp_path, monkeypatch, old, new, key, line, number
):
    """It would be worded in vain, and not even one line would come of that; nor does Python read one in decimals."""
    unraised = []
    monkeypatch.setattr("sys.unraisablehook", unraised.append)
    file = tmp_path / "digits.yaml"
    file.write_text(SEED.read_text().replace(old, new.replace("{}", number)))
    with pytest.raises(
        ConfigError, match=rf"^{file}:{line}: {key}: received a number of too many digits; needs at most 4300$"
    ):
        config.load(file)
    assert unraised == []


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
def test_what_is_a_quantity_ends_where_it_says_and_is_finite(quantity, taken, refused):
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
def test_the_motion_is_what_stands_last_in_a_label(label, body, motion, rigid):
    """A body may be called by two words, or as a motion."""
    assert (quantities.body_of(label), quantities.motion_of(label)) == (body, motion)
    assert quantities.is_rigid(label) is rigid


def test_places_are_of_each_body_wherever_its_labels_stand():
    labels = ["b__Heave", "a__Heave", "b__Pitch", "a__Mode7", "b__Mode1"]
    assert quantities.of_bodies(labels) == {"b": [0, 2, 4], "a": [1, 3]}
    assert quantities.of_bodies(["Heave", "Mode7"]) == {"": [0, 1]}


def test_both_ends_of_a_range_are_in_it():
    checked = quantities.within(-2.0, 3.0, "m", "no buoy is larger").func
    assert [checked(value) for value in (-2.0, 0.0, 3.0)] == [-2.0, 0.0, 3.0]
    with pytest.raises(ValueError, match=r"^needs at least -2 m, because no buoy is larger$"):
        checked(-2.001)
    with pytest.raises(ValueError, match=r"^needs at most 3 m, because no buoy is larger$"):
        checked(3.001)


def test_a_key_of_later_is_not_said_at_its_default_alone():
    """Whatever that is, and whatever else it may be: nothing, zero, none."""

    class Some(quantities.Extended):
        LATER = ("word", "number", "flag")
        old: float = 0.0
        word: str | None = "heave"
        number: float = 0.0
        flag: bool = True

    assert Some().model_dump() == {"old": 0.0}
    assert Some(old=2.0, word="heave", number=0.0, flag=True).model_dump() == {"old": 2.0}
    said = {"old": 0.0, "word": None, "number": -1.0, "flag": False}
    assert Some(**said).model_dump() == said
    assert Some(word="").model_dump() == {"old": 0.0, "word": ""}


@pytest.mark.parametrize("kind", [Positive, NonNegative, Finite])
@pytest.mark.parametrize("value", [True, False])
def test_what_is_true_or_false_is_no_number(kind, value):
    """Neither 1 nor 0."""
    with pytest.raises(ValidationError, match="a number is needed, not true/false"):
        TypeAdapter(kind).validate_python(value)
