"""Damping from the excitation of another code's files, where headings resolve it."""

import numpy as np
import pytest

from tests.hydro.formats.test_foreign import CIRCLE, RHO, G, sound
from vsb.hydro.formats.haskind import fitting_depth, haskind_axisymmetric, haskind_headings

FACTS = {"depth": np.inf, "density": RHO, "gravity": G}
NOTHING = np.zeros(2)


def test_headings_all_around_give_the_damping_of_the_waves_they_excite():
    ds = sound(("Surge", "Heave"))
    found = haskind_headings(ds, NOTHING, **FACTS)
    assert found.resolved.all()
    largest = np.abs(ds.radiation_damping.values).max()
    np.testing.assert_allclose(found.damping, ds.radiation_damping.values, atol=1e-9 * largest)


@pytest.mark.parametrize("headings", [(0.0,), CIRCLE[:5], (*CIRCLE[:11], 345.0)])
def test_headings_that_do_not_go_around_in_equal_steps_give_none(headings):
    assert haskind_headings(sound(("Surge", "Heave"), headings), NOTHING, **FACTS) is None


def test_a_single_heading_does_for_motions_that_send_out_rings():
    ds = sound(("Heave",))
    found = haskind_axisymmetric(ds, **FACTS)
    np.testing.assert_allclose(found.damping, ds.radiation_damping.values, rtol=1e-9)
    assert found.resolved.all()


def test_no_depth_is_told_where_none_would_fit():
    omega = np.array([0.3, 0.5])
    assert fitting_depth(np.array([3.0, 0.2]), omega, np.inf, G) is None
    assert fitting_depth(np.ones(2), omega, np.inf, G) == np.inf
