"""The year within limits of force and stroke, bin by bin."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from results.test_year import WATER, climate, port

from vsb.errors import ConfigError
from vsb.motion.force_bound import Limits
from vsb.motion.harmonics import Harmonics
from vsb.results.bins import Bins, bins_of
from vsb.results.constrained_year import (
    REALISATIONS,
    SECONDS_AT_LEAST,
    SECONDS_PER_CUBE,
    ConstrainedYear,
    _optimum,
    _squares,
    affordable,
    constrained_year,
    harmonics_of_year,
)
from vsb.results.verification import half_width
from vsb.results.year import year
from vsb.study.study import Water
from vsb.waves.climate import Climate

SEAS = climate()
HARMONICS = Harmonics(0.05, 4.0, 45)  # 0.2 to 2.4 rad/s
PORT = port(HARMONICS.port_omega)


def limited(limits, seconds=10.0, **changes):
    return constrained_year(
        **{"port": PORT, "climate": SEAS, "water": WATER, "harmonics": HARMONICS} | changes,
        limits=limits,
        seconds=seconds,
    )


def test_without_limits_it_is_the_matched_year():
    """Matched power of every sea by itself, with no bins: power is linear in the spectrum."""
    fine = Harmonics(0.005, 40.0, 441)
    found = limited(Limits(), harmonics=fine, port=port(fine.port_omega), seconds=1e3)
    inside = np.arange(0.25, 2.25, 0.001) + 0.0005
    exact, band = port(inside).matched_power, np.searchsorted(SEAS.edges, inside) - 1
    each = [2 * 0.001 * float(exact @ s[band]) for s in SEAS.density]
    mean, low, high = found.annual_mean_power
    assert mean == pytest.approx(float(np.dot(each, SEAS.hours)), rel=2e-3)
    assert low == pytest.approx(mean, rel=1e-12)
    assert high == pytest.approx(mean, rel=1e-5)
    assert found.flux_share == pytest.approx(1.0)
    assert found.reached.sum() == len(found.bins.occupied)


def test_limits_take_power_and_dampers_take_less():
    """Matched, two limits one tighter than the other; a damper of less force at all times takes less than the optimum."""
    free, loose, tight = (limited(Limits(force=f)) for f in (np.inf, 3e4, 1e4))
    powers = [one.annual_mean_power.mean for one in (free, loose, tight)]
    assert powers[0] > powers[1] > powers[2] > 0
    assert tight.force_rms < 1e4 < free.force_rms
    assert max(optimum.force_peak for pair in tight.optima for optimum in pair) <= 1e4
    assert tight.excess == 0
    assert limited(Limits(stroke=0.5)).excess > 0  # its force is of the band, its limits are those at the instants


def test_a_budget_brackets_the_rest():
    whole, part = limited(Limits(force=2e4)), limited(Limits(force=2e4), seconds=0.05)
    assert len(part.solved) == affordable(HARMONICS, 0.05) < len(whole.solved)
    mean, low, high = part.annual_mean_power
    assert low < whole.annual_mean_power.mean < high
    assert low < mean < high
    assert part.flux_share < 1
    assert part.power_matrix[part.reached] == pytest.approx(whole.power_matrix[part.reached], rel=1e-12)
    assert part.flux_share > len(part.solved) / len(whole.solved)  # those that bring most come first


def test_bins_not_reached_take_the_part_of_the_matched_power_that_those_reached_do():
    """All of it without limits, whatever the budget; with limits one by one of what every bin's matched power is."""
    whole, part = limited(Limits(), seconds=1e3), limited(Limits(), seconds=0.05)
    assert 0.1 < part.flux_share < 0.9
    assert part.annual_mean_power.mean == pytest.approx(whole.annual_mean_power.mean, rel=1e-9)
    np.testing.assert_allclose(whole.matched, whole.power_matrix, rtol=1e-9)
    np.testing.assert_array_equal(part.matched, whole.matched)
    held = limited(Limits(force=2e4), seconds=0.05)
    matched = held.bins.share * held.matched
    scale = matched.sum() / matched[held.reached].sum()
    assert held.annual_mean_power.mean == pytest.approx(scale * held.taken, rel=1e-12)
    assert held.bound > held.taken + matched[~held.reached].sum() * (1 - 1e-9)


def test_the_budget_is_no_clock():
    assert affordable(HARMONICS, 1e-9) == 1
    assert affordable(HARMONICS, 2.0) == 2 * affordable(HARMONICS, 1.0)
    bin_of = REALISATIONS * (SECONDS_AT_LEAST + SECONDS_PER_CUBE * 45**3)
    assert [affordable(HARMONICS, bins * bin_of) for bins in (0.5, 1.9, 2.1, 7.5)] == [1, 1, 2, 7]


def test_seas_no_force_can_hold():
    found = limited(Limits(force=1e2, stroke=0.05))
    assert 0 < found.impossible <= 1
    none = np.array([[optimum is None for optimum in pair] for pair in found.optima])
    assert found.impossible == pytest.approx(float(found.share @ none.mean(axis=1)))
    assert np.all(found.power_matrix.ravel()[found.solved[none.all(axis=1)]] == 0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"port": port(HARMONICS.omega)},
            r"a port at 45 frequencies up to 2\.4 rad/s, needs the 45 harmonics up to 2\.4 rad/s and those outside",
        ),
        (
            {"port": port(HARMONICS.port_omega + 0.01)},
            r"up to 9\.76 rad/s, needs the 45 harmonics up to 2\.4 rad/s and",
        ),
        (
            {"harmonics": Harmonics(0.05, 20.0, 29), "port": port(Harmonics(0.05, 20.0, 29).port_omega)},
            r"harmonics from 0\.975 to 2\.425 rad/s, which leave out .* of the variance of random seas, needs at most 1%",
        ),
    ],
)
def test_what_cannot_be_solved(changes, message):
    with pytest.raises(ConfigError, match=message):
        limited(Limits(), **changes)


def test_a_best_damper_lies_below_the_matched_year_and_above_one_of_scarce_force():
    free, scarce = limited(Limits()), limited(Limits(force=5e3))
    damped = year({"A": PORT}, SEAS, WATER, ["each"]).annual_mean_power[0, 0]
    assert scarce.annual_mean_power.mean < damped < free.annual_mean_power.mean


def test_a_budget_that_is_enough_is_for_every_bin():
    """Longer periods for more time, never a bin less, and no waves nearer each other than a record tells."""
    bins = limited(Limits(), seconds=1e3).bins
    spacings = []
    for seconds in (0.5, 1.0, 4.0, 1e6):
        found = harmonics_of_year(SEAS, 0.25, 6.0, seconds)
        assert affordable(found, seconds) >= len(bins.occupied) or found.spacing > 0.15
        assert 0.25 - 1e-9 <= found.omega[0] < 0.25 + found.spacing
        assert found.omega[-1] <= 6.0 + 1e-9 < found.omega[-1] + found.spacing
        spacings.append(found.spacing)
    assert spacings == sorted(spacings, reverse=True)
    te = float(SEAS.te @ SEAS.hours)
    assert 2 * np.pi / spacings[-1] == pytest.approx(32 * te)


def test_a_band_that_ends_at_harmonics_but_for_round_off_holds_both():
    """Within the time of 4 to 32 mean periods; a millionth beyond, a harmonic is out; the mean level is none."""
    te = float(SEAS.te @ SEAS.hours)
    spacing = 2 * np.pi / (32 * te)
    for off, first, last in ((1e-15, 12, 40), (1e-6, 13, 39)):
        found = harmonics_of_year(SEAS, 12 * spacing * (1 + off), 40 * spacing * (1 - off), 1e6)
        assert found.omega[[0, -1]] == pytest.approx(np.array([first, last]) * spacing, rel=1e-12)
        assert found.count == last - first + 1
    assert harmonics_of_year(SEAS, 0.0, 2.0, 1e6).omega[0] == pytest.approx(spacing)
    assert harmonics_of_year(SEAS, 0.25, 6.0, 1e-9).spacing == pytest.approx(8 * spacing)


def test_harmonics_are_as_near_each_other_as_their_budget_allows_to_the_last():
    """The time of 100 harmonics, in all bins twice, gives 99 spacings from end to end of the band."""
    count = len(limited(Limits(), seconds=0.0).bins.occupied)
    seconds = REALISATIONS * count * (SECONDS_AT_LEAST + SECONDS_PER_CUBE * 100**3)
    assert harmonics_of_year(SEAS, 0.25, 6.0, seconds).spacing == pytest.approx(5.75 / 99, rel=1e-9)


def test_the_gain_of_a_design_over_itself_is_nothing_but_for_what_is_not_proved():
    found = limited(Limits(force=2e4))
    ends = [100 * (ratio - 1) for ratio in (1.0, found.taken / found.bound, found.bound / found.taken)]
    assert found.gain(found) == pytest.approx(ends, abs=1e-9)


def test_the_interval_of_the_gain_covers_what_more_waves_say():
    """Of fourteen draws of phases, what is not proved aside; the mean of all, paired as each of them is, is the truth."""
    coarse, seas = Harmonics(0.1, 3.0, 18), climate(seas=8)
    ports = port(coarse.port_omega), port(coarse.port_omega, mass=22000.0)
    pairs = [
        [limited(Limits(force=1e4), harmonics=coarse, port=p, climate=seas, seed=seed) for p in ports]
        for seed in range(14)
    ]
    gains = np.array([b.gain(a) for a, b in pairs])
    halves = [100 * (b.taken / a.bound - 1) - low for (a, b), low in zip(pairs, gains[:, 1], strict=True)]
    others = [high - 100 * (b.bound / a.taken - 1) for (a, b), high in zip(pairs, gains[:, 2], strict=True)]
    assert halves == pytest.approx(others, rel=1e-6)
    truth = 100 * (sum(b.taken for _, b in pairs) / sum(a.taken for a, _ in pairs) - 1)
    assert np.count_nonzero(np.abs(gains[:, 0] - truth) <= halves) >= 12
    assert 1 < np.median(halves) / np.std(gains[:, 0]) < 6


def test_a_port_that_does_not_move_takes_nothing():
    still = PORT
    still = type(still)(still.omega, 0 * still.admittance, 0 * still.velocity, 0.0)
    found = limited(Limits(force=1e4), port=still)
    assert found.annual_mean_power == (0, 0, 0)
    assert limited(Limits(force=1e4)).gain(found) is None
    assert len(found.optima[0]) == REALISATIONS
    assert (found.force_rms, found.excess) == (0, 0)
    assert not any(np.any(value) for pair in found.optima for optimum in pair for value in optimum)


def taking(*bins):
    """A year of equal bins, of (power, bound) in each realisation."""
    count = len(bins)
    optima = tuple(tuple(SimpleNamespace(power=power, bound=bound) for power, bound in pair) for pair in bins)
    seas = Bins(0.5 * np.arange(count) + 0.1, np.full(count, 0.5), np.full(count, 1 / count))
    return ConstrainedYear(
        seas, np.arange(count), np.zeros((count, 2, 1)), optima, np.full(seas.shape, 1e3), flux_share=1.0
    )


def test_a_gain_lies_between_what_is_taken_over_the_others_bound_and_its_own_bound_over_what_that_takes():
    """60 W of at most 66 over 40 W of at most 50, in all waves alike: 50 %, from 60/50 to 66/40."""
    better, base = taking([(60.0, 66.0)] * 2), taking([(40.0, 50.0)] * 2)
    assert better.annual_mean_power == pytest.approx((60.0, 60.0, 66.0))
    assert better.gain(base) == pytest.approx((50.0, 20.0, 65.0))


def test_waves_that_both_designs_meet_alike_leave_a_gain_sharp_and_others_do_not():
    """Power in proportion, realisation by realisation, scatters in neither end; turned about, in both alike."""
    draws = [[(30.0, 30.0), (50.0, 50.0)], [(10.0, 10.0), (20.0, 20.0)]]
    scaled = [[(1.5 * power, 1.5 * bound) for power, bound in pair] for pair in draws]
    base, alike, turned = taking(*draws), taking(*scaled), taking(*(pair[::-1] for pair in scaled))
    assert alike.gain(base) == pytest.approx((50.0, 50.0, 50.0))
    mean, low, high = turned.gain(base)
    assert mean == pytest.approx(50.0)
    assert high - mean == pytest.approx(mean - low)
    assert high - mean > 20.0


def test_the_spectrum_of_a_bin_is_the_mean_over_its_hours():
    """Two seas of one bin, nine hours of one to each of the other; harmonics are the middles of the bands."""
    omega = 0.3 + 0.1 * np.arange(20)
    narrow, wide = (0.02 * part * np.exp(-(((omega - 1.0) / width) ** 2)) for width, part in ((0.2, 1.0), (0.22, 0.9)))
    seas = Climate.of_spectra(omega, np.array([narrow, wide]), np.array([0.9, 0.1]), "two seas")
    bins = Bins(seas.hs, seas.te, seas.hours)
    assert len(bins.occupied) == 1
    (found,) = _squares(bins, seas, Harmonics(0.1, 3.0, 20))
    assert found == pytest.approx(2 * 0.1 * (0.9 * narrow + 0.1 * wide), rel=1e-9)


def test_what_is_said_of_a_year_weighs_its_bins_by_their_hours_and_its_realisations_alike():
    """Three bins of 0.5, 0.3 and 0.2 of the year; in the second no force keeps the stroke in one realisation of two."""

    def optimum(power, force, excess):
        return SimpleNamespace(power=power, bound=2 * power, force_rms=force, excess=excess)

    optima = (
        (optimum(10.0, 1.0, 0.01), optimum(30.0, 3.0, 0.02)),
        (optimum(50.0, 5.0, 0.01), None),
        (optimum(70.0, 7.0, 0.05), optimum(90.0, 9.0, 0.03)),
    )
    hours = np.array([0.5, 0.3, 0.2])
    seas = Bins(0.5 * np.arange(3) + 0.1, np.full(3, 0.5), hours)
    year_of = ConstrainedYear(seas, np.arange(3), np.zeros((3, 2, 1)), optima, np.full(seas.shape, 1e3), 1.0)
    assert year_of.taken == pytest.approx(0.5 * 20 + 0.3 * 25 + 0.2 * 80)
    assert year_of.bound == pytest.approx(2 * year_of.taken)
    assert year_of.impossible == pytest.approx(0.3 / 2)
    assert year_of.force_rms == pytest.approx(np.sqrt(0.5 * 5 + 0.3 * 12.5 + 0.2 * 65))
    assert year_of.excess == 0.05
    assert replace(year_of, optima=tuple(pair[::-1] for pair in optima)).excess == 0.05
    assert replace(year_of, optima=(optima[2], optima[1], optima[0])).excess == 0.05
    half = half_width(3 * np.array([0.5 * 10, 0.5 * 30, 0.3 * 50, 0.0, 0.2 * 70, 0.2 * 90]))
    assert half < year_of.taken
    assert year_of.annual_mean_power == pytest.approx((year_of.taken, year_of.taken - half, year_of.bound + half))
    apart = taking([(0.0, 0.0), (90.0, 90.0)], [(9.0, 9.0), (9.0, 9.0)]).annual_mean_power
    assert apart == pytest.approx((27.0, 0.0, apart.high))  # no power lies below nothing
    assert apart.high > 2 * 27.0
    part = ConstrainedYear(seas, np.array([2, 0]), np.zeros((2, 2, 1)), optima[::-2], np.full(seas.shape, 1e3), 1.0)
    assert part.force_rms == pytest.approx(np.sqrt((0.5 * 5 + 0.2 * 65) / 0.7))  # over what is solved
    assert part.annual_mean_power.mean == pytest.approx(part.taken / 0.7)
    for reached, others in ((0.0, 1e3), (0.0, 0.0)):  # of nothing there is no part
        nothing = replace(part, matched=np.where(part.reached, reached, others))
        assert nothing.annual_mean_power.mean == part.taken


@pytest.mark.parametrize(("part", "refused"), [(0.0099, False), (0.0101, True)])
def test_a_hundredth_of_the_variance_of_the_year_may_be_left_out(part, refused):
    """Two seas of two bins, of the higher one alone a part lies in the last band, which no harmonic is of."""
    omega, low = 0.3 + 0.1 * np.arange(20), np.zeros(20)
    low[2:6] = 0.05
    high, hours = 16.0 * low, np.array([0.8, 0.2])
    whole = float(hours @ [low.sum(), high.sum()])
    high[-1] = part / (1 - part) * whole / 0.2
    seas = Climate.of_spectra(omega, np.array([low, high]), hours, "two seas")
    bins = Bins(seas.hs, seas.te, seas.hours)
    assert len(bins.occupied) == 2
    if not refused:
        _squares(bins, seas, Harmonics(0.1, 3.0, 19))
        return
    said = (
        r"constrained: received harmonics from 0\.25 to 2\.15 rad/s, which leave out 1\.01% of the variance of two seas"
    )
    with pytest.raises(ConfigError, match=f"{said}, needs at most 1%: a longer period or a higher omega_max"):
        _squares(bins, seas, Harmonics(0.1, 3.0, 19))


def test_bands_of_a_spectrum_may_be_of_several_widths():
    """Each with the variance of the part of it that lies around a harmonic, between the edges of both."""
    omega = np.array([0.4, 0.6, 0.7, 0.8, 1.0, 1.3, 1.7, 1.8])
    density = np.array([[0.0, 0.02, 0.06, 0.09, 0.05, 0.02, 0.01, 0.0]])
    seas = Climate.of_spectra(omega, density, np.ones(1), "bands")
    harmonics = Harmonics(0.1, 4.0, 17)
    (found,) = _squares(Bins(seas.hs, seas.te, seas.hours), seas, harmonics)
    fine = np.linspace(0.35, 2.05, 17 * 4000, endpoint=False) + 0.5 * 1.7 / (17 * 4000)
    band = np.searchsorted(seas.edges, fine) - 1
    inside = np.where((band >= 0) & (band < 8), density[0][band.clip(0, 7)], 0.0)
    assert found == pytest.approx(2 * inside.reshape(17, -1).mean(axis=1) * 0.1, abs=2e-6)


@pytest.mark.parametrize("depth", [np.inf, 4.0])
def test_bins_are_taken_in_the_order_of_the_energy_flux_they_bring_in_their_own_water(depth):
    """By all hours of their seas, not by how high these are."""
    water = Water(depth=depth)
    bins = bins_of(SEAS)
    flux = np.array([(SEAS.flux(water) * SEAS.hours)[bins.index == place].sum() for place in bins.occupied])
    order = bins.occupied[np.argsort(-flux, kind="stable")]
    part = limited(Limits(), seconds=0.05, water=water)
    assert part.solved.tolist() == order[: len(part.solved)].tolist()
    assert 1 < len(part.solved) < len(order)
    assert part.flux_share == pytest.approx(np.sort(flux)[::-1][: len(part.solved)].sum() / flux.sum(), rel=1e-12)


def test_waves_of_a_bin_are_the_same_whatever_else_is_solved_and_others_of_another_seed():
    """Two draws of phases of its mean spectrum; no two bins have those of another."""
    whole, part = limited(Limits(), seconds=1e3), limited(Limits(), seconds=0.05)
    np.testing.assert_array_equal(part.amplitude, whole.amplitude[: len(part.solved)])
    sizes = np.abs(whole.amplitude)
    np.testing.assert_allclose(sizes[:, 0], sizes[:, 1], rtol=1e-12)
    phases = (whole.amplitude / np.where(sizes > 0, sizes, 1.0))[:, :, sizes.min(axis=(0, 1)) > 0].reshape(
        2 * len(whole.solved), -1
    )
    assert len(np.unique(np.round(phases, 9), axis=0)) == len(phases)
    other = limited(Limits(), seconds=0.05, seed=1)
    assert np.abs(other.amplitude - part.amplitude).max() > 0.1 * np.abs(part.amplitude).max()
    np.testing.assert_allclose(np.abs(other.amplitude), np.abs(part.amplitude), rtol=1e-12)


def test_a_port_that_some_waves_do_not_move_takes_what_the_others_bring():
    """One that none moves takes nothing and needs no force, whatever the limits."""
    rng = np.random.default_rng(5)
    waves = rng.rayleigh(size=HARMONICS.count) * np.exp(2j * np.pi * rng.uniform(size=HARMONICS.count))
    part = replace(PORT, velocity=np.where(np.arange(len(PORT.omega)) % 3 == 0, 0.0, PORT.velocity))
    best = _optimum(part, HARMONICS, waves, Limits())
    assert best.power == pytest.approx(float(part.matched_power[: HARMONICS.count] @ np.abs(waves) ** 2), rel=1e-9)
    np.testing.assert_allclose(best.force, part.matched_force[: HARMONICS.count] * waves, rtol=1e-9)
    still = _optimum(replace(PORT, velocity=0 * PORT.velocity), HARMONICS, waves, Limits(1.0, 1e-9))
    assert not still.force.any()
    assert not still.stroke.any()
    assert len(still.force) == len(still.stroke) == HARMONICS.count
    assert still[2:] == (0.0,) * 6 + (0,)


def test_a_gain_of_years_that_are_solved_in_part_lies_about_what_their_realisations_say_of_what_is_solved():
    """Two of three bins reached, the third by its matched power alone, of which the designs could take uneven parts."""
    seas = Bins(0.5 * np.arange(3) + 0.1, np.full(3, 0.5), np.array([0.5, 0.3, 0.2]))

    def solved(powers, matched):
        pairs = tuple(tuple(SimpleNamespace(power=p, bound=1.1 * p) for p in pair) for pair in powers)
        places = np.zeros(seas.shape)
        places[:, 0] = matched
        return ConstrainedYear(seas, np.arange(2), np.zeros((2, 2, 1)), pairs, places, flux_share=0.8)

    powers = {"base": [(10.0, 13.0), (20.0, 26.0)], "better": [(18.0, 16.0), (30.0, 33.0)]}
    matched = {"base": (30.0, 40.0, 90.0), "better": (35.0, 60.0, 50.0)}
    base, better = (solved(powers[name], matched[name]) for name in ("base", "better"))
    taken, bound, mean = {}, {}, {}
    for name, pairs in powers.items():
        taken[name] = 0.5 * sum(pairs[0]) / 2 + 0.3 * sum(pairs[1]) / 2
        could, left = 0.5 * matched[name][0] + 0.3 * matched[name][1], 0.2 * matched[name][2]
        bound[name], mean[name] = 1.1 * taken[name] + left, taken[name] * (1 + left / could)
    ratio = mean["better"] / mean["base"]
    draws = [
        2 * hours * (own - ratio * other)
        for hours, ours, others in zip((0.5, 0.3), powers["better"], powers["base"], strict=True)
        for own, other in zip(ours, others, strict=True)
    ]
    half = half_width(np.array(draws) / taken["base"])
    least, most = taken["better"] / bound["base"] - half, bound["better"] / taken["base"] + half
    assert better.gain(base) == pytest.approx((100 * (ratio - 1), 100 * (least - 1), 100 * (most - 1)))
    assert half > 0.01


def test_a_bin_in_which_no_force_keeps_the_stroke_adds_nothing_to_the_bound_however_much_its_waves_bring():
    """It is reached all the same; only what is not reached may have all of the matched power."""
    seas = Bins(0.5 * np.arange(3) + 0.1, np.full(3, 0.5), np.array([0.5, 0.3, 0.2]))
    some = SimpleNamespace(power=10.0, bound=12.0)
    found = ConstrainedYear(
        seas, np.arange(2), np.zeros((2, 2, 1)), ((some, some), (None, None)), np.full(seas.shape, 1e3), 0.8
    )
    assert found.reached[:, 0].tolist() == [True, True, False]
    assert found.bound == pytest.approx(0.5 * 12.0 + 0.2 * 1e3)
    assert (found.taken, found.impossible) == (pytest.approx(5.0), pytest.approx(0.3))


@pytest.mark.parametrize("found", ["none", "undecided"])
def test_a_sea_in_which_no_force_is_found_has_the_bound_of_those_that_might_keep_the_stroke(found):
    """And none where it is proved that no force keeps it. In between only the harmonics of the band are ruled out."""
    limits = {"none": Limits(1e2, 0.05), "undecided": Limits(2e4, 0.05)}[found]
    year_of = limited(limits)
    none = np.array([[optimum is None for optimum in pair] for pair in year_of.optima])
    assert none.any()
    known = [[one.bound if one else 0.0 for one in pair] for pair in year_of.optima]
    bounds = np.where(none, year_of.undecided, known)
    assert year_of.bound == pytest.approx(float(year_of.share @ bounds.mean(axis=1)))
    assert (year_of.undecided[none] > 0).any() == (found == "undecided")
    assert not np.any(year_of.undecided[~none])
    looser = limited(limits._replace(force=1.5 * limits.force))
    assert year_of.bound <= looser.bound * (1 + 1e-3)
