"""Errors of users: one family, and all mistakes of a file in one of them."""

import pytest

from vsb import errors


@pytest.mark.parametrize("kind", ["ConfigError", "DatabaseError", "ConvergenceError", "StabilityError"])
def test_all_are_of_one_family(kind):
    with pytest.raises(errors.VsbError, match="received 1, needs 2"):
        raise getattr(errors, kind)("received 1, needs 2")


def test_one_mistake_is_all_there_are():
    assert errors.ConfigError("a: wrong").mistakes == ("a: wrong",)


def test_several_mistakes_are_kept_and_the_first_is_told():
    found = errors.ConfigError("a: wrong (and 1 more)", ["a: wrong", "b: wrong"])
    assert str(found) == "a: wrong (and 1 more)"
    assert found.mistakes == ("a: wrong", "b: wrong")
