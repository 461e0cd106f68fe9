"""Physical ranges: a number beyond its range is refused with the reason."""

import copy
import math

import pytest
import yaml
from conftest import SEED
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConfigError
from vsb.keys.quantities import canonical, content_id, result_id, within
from vsb.pipeline.graph import StudyPlan
from vsb.study import study as config


def changed(path, value):
    """The seed study with one value changed."""
    raw = copy.deepcopy(yaml.safe_load(SEED.read_text()))
    *outer, last = (int(part) if part.isdigit() else part for part in path.split("."))
    here = raw
    for part in outer:
        here = here[part]
    here[last] = value
    return raw


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
            with pytest.raises(ConfigError, match=r"omega_max: received 2 rad/s, needs at least 5.515 .* beyond its"):
                plan.check_waves()


TEXT = st.text("aZ09_. \n\u00e9\u4e2d\U0001f600")  # of all characters hypothesis makes a table, a second and a half
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | TEXT,
    lambda inner: st.lists(inner) | st.dictionaries(TEXT, inner),
    max_leaves=8,
)


@settings(max_examples=10)
@given(st.dictionaries(TEXT, PLAIN))
def test_order_of_keys_does_not_matter(data):
    assert canonical(dict(reversed(data.items()))) == canonical(data)
    assert content_id(dict(reversed(data.items()))) == content_id(data)


def test_infinity_is_a_word_and_zero_has_no_sign():
    assert canonical({"b": (math.inf, -math.inf), "a": -0.0}) == '{"a":0.0,"b":["inf","-inf"]}'


def test_nan_is_refused():
    with pytest.raises(ValueError, match="Out of range float values"):
        canonical({"a": math.nan})


def test_id_of_a_result_covers_its_inputs():
    assert result_id({"a": 1}) == content_id({"a": 1})
    assert (
        len({result_id({"a": 1}), result_id({"a": 1}, "x"), result_id({"a": 1}, "x", "y"), result_id({"a": 2}, "x")})
        == 4
    )
