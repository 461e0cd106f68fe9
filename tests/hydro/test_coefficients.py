"""Coefficients of motions that do not couple through the water, side by side."""

import numpy as np
import pytest

from vsb.hydro.coefficients import Coefficients


def part(seed, count):
    rng = np.random.default_rng(seed)
    return Coefficients(
        rng.normal(size=(4, count, count)), rng.normal(size=(4, count, count)), rng.normal(size=(4, count)) + 1j
    )


@pytest.mark.parametrize("size", [2, 3])
def test_parts_are_blocks_with_nothing_between_them(size):
    one, other = part(1, 2), part(2, size)
    found = Coefficients.side_by_side([one, other])
    for name in ("added_mass", "damping"):
        whole = getattr(found, name)
        np.testing.assert_array_equal(whole[:, :2, :2], getattr(one, name))
        np.testing.assert_array_equal(whole[:, 2:, 2:], getattr(other, name))
        assert not whole[:, :2, 2:].any()
        assert not whole[:, 2:, :2].any()
    np.testing.assert_array_equal(found.excitation, np.hstack([one.excitation, other.excitation]))


def test_a_part_alone_is_itself():
    alone = part(1, 2)
    assert Coefficients.side_by_side([alone]) is alone
