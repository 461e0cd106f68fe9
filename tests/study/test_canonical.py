"""Canonical JSON and content ids."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.study.quantities import canonical, content_id, result_id

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=8,
)


@settings(max_examples=20)
@given(st.dictionaries(st.text(), PLAIN))
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
