"""Damping from the excitation of another code's files, where headings resolve it."""

import numpy as np
import pytest

from tests.hydro.formats.test_foreign import CIRCLE, RHO, G, sound
from vsb.hydro.formats.haskind import fitting_depth, haskind_axisymmetric, haskind_headings
from vsb.waves.dispersion import group_velocity, wavenumber

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
    but_one = np.array([*np.ones(19), 1.2])
    assert fitting_depth(but_one, np.linspace(1.0, 3.0, 20), np.inf, G) is None


def ringing(values, n=12):
    """Excitation over frequencies and modes, functions of the heading, at n headings all around."""
    beta = 2 * np.pi * np.arange(n) / n
    x = np.array([[mode(beta) for mode in row] for row in values]).swapaxes(1, 2)
    labels = ["Surge", "Heave"][: x.shape[2]]
    ds = sound(labels, np.degrees(beta), omega=np.linspace(0.5, 1.5, len(values)))
    return ds.assign(excitation_force=(ds.excitation_force.dims, x.astype(complex)))


@pytest.mark.parametrize(("order", "least"), [(3, 12), (4, 12), (5, 12), (6, 12), (2, 7), (3, 7), (1, 7)])
def test_a_mode_is_resolved_while_its_last_two_orders_hold_a_fortieth_of_its_largest_power(order, least):
    """Order 0 of power one and another of power s/(1 - s); orders below the last two may hold anything."""
    last = order >= least // 2 - 1
    for share in (0.0249, 0.0251):
        part = np.sqrt(share / (1 - share) * (1.0 if 2 * order == least else 2.0))
        ds = ringing([[lambda beta, part=part: 1.0 + part * np.cos(order * beta)]], least)
        assert bool(haskind_headings(ds, np.zeros(1), **FACTS).resolved[0, 0]) == (share < 0.025 or not last)


def test_each_mode_is_measured_by_its_own_power_in_the_band_or_by_its_size():
    """Heave, a thousandth of surge, turns too often at the second of three frequencies, and seems not to at the third."""
    ripple = [lambda beta: np.ones_like(beta), lambda beta: np.cos(5 * beta), lambda beta: np.cos(13 * beta)]
    for scale in (1.0, 1e-3):
        ds = ringing([[np.cos, lambda beta, f=f, scale=scale: scale * f(beta)] for f in ripple])
        found = haskind_headings(ds, NOTHING, **FACTS).resolved
        assert found.tolist() == [[True, True], [True, False], [True, False]]
        assert haskind_headings(ds, np.array([0.0, 1e30]), **FACTS).resolved.all()


@pytest.mark.parametrize("same", [360.0, -360.0, 359.9998, -0.0002, 720.0001])
def test_a_heading_told_twice_counts_once(same):
    once, twice = (haskind_headings(sound(("Surge", "Heave"), h), NOTHING, **FACTS) for h in (CIRCLE, (*CIRCLE, same)))
    np.testing.assert_allclose(twice.damping, once.damping, rtol=1e-6, atol=1e-6 * np.abs(once.damping).max())
    assert twice.resolved.all()


@pytest.mark.parametrize("seed", range(3))
def test_headings_may_stand_in_any_order(seed):
    """One of them told twice, wherever that is; what turns too often is told from what does not."""
    waves = [[lambda beta: 1.0 + np.cos(beta), lambda beta: 1.0 + np.cos(5 * beta)]]
    ds = ringing(waves)
    order = np.random.default_rng(seed).permutation([*range(12), seed])
    found, expected = (haskind_headings(each, NOTHING, **FACTS) for each in (ds.isel(wave_direction=order), ds))
    assert found.resolved.tolist() == expected.resolved.tolist() == [[True, False]]
    np.testing.assert_allclose(found.damping, expected.damping, rtol=1e-12, atol=1e-12 * np.abs(expected.damping).max())


@pytest.mark.parametrize(("count", "enough"), [(4, False), (5, False), (6, True), (7, True)])
def test_six_headings_in_equal_steps_are_the_fewest(count, enough):
    headings = np.roll(np.arange(count) * 360.0 / count, 2) - 100.0
    assert (haskind_headings(sound(("Heave",), headings), np.zeros(1), **FACTS) is not None) == enough


@pytest.mark.parametrize("step", [0.009, 0.011])
def test_steps_are_equal_to_a_hundredth_of_a_degree(step):
    headings = np.array(CIRCLE) + np.eye(12)[4] * step
    assert (haskind_headings(sound(("Heave",), headings), np.zeros(1), **FACTS) is None) == (step > 0.01)


@pytest.mark.parametrize("omega", [(0.3, 1.5), (1.5, 0.3), (0.3, 0.31, 4.0)])
@pytest.mark.parametrize("given", [np.inf, 60.0])
def test_a_depth_is_sought_by_the_longest_of_the_waves(omega, given):
    """Damping from excitation goes with k over group velocity: it is too much by that of the depth given."""

    def narrowness(depth):
        return np.array([wavenumber(w, depth, G) / group_velocity(w, depth, G) for w in omega])

    true = 20.0
    ratio = narrowness(given) / narrowness(true)
    assert fitting_depth(ratio, np.array(omega), given, G) == pytest.approx(true, rel=0.06)


@pytest.mark.parametrize("depth", [30.0, np.inf])
def test_of_rings_the_first_heading_counts_at_any_depth(depth):
    ds = sound(("Heave",), (40.0, 90.0), depth=depth)
    x = ds.excitation_force.values.copy()
    x[:, 1] *= 3.0
    found = haskind_axisymmetric(ds.assign(excitation_force=(ds.excitation_force.dims, x)), **{**FACTS, "depth": depth})
    np.testing.assert_allclose(found.damping, ds.radiation_damping.values, rtol=1e-9)
    other = haskind_axisymmetric(ds, depth=depth, density=2 * RHO, gravity=G)
    np.testing.assert_allclose(2 * other.damping, ds.radiation_damping.values, rtol=1e-9)


@pytest.mark.parametrize("depth", [30.0, np.inf])
def test_headings_around_give_damping_by_density_and_depth(depth):
    ds = sound(("Surge", "Heave"), depth=depth)
    for density in (RHO, 3 * RHO):
        found = haskind_headings(ds, NOTHING, depth=depth, density=density, gravity=G)
        largest = np.abs(ds.radiation_damping.values).max()
        np.testing.assert_allclose(density / RHO * found.damping, ds.radiation_damping.values, atol=1e-9 * largest)
