"""Few runs in time correct a year: unbiased, with intervals that hold what they promise."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from results.test_year import WATER, climate, port, stroke_rms
from scipy.special import chdtri

from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.results.statistics import student
from vsb.results.verification import (
    Sample,
    Verification,
    chances,
    contributions,
    drawn,
    half_width,
    linear_power,
    record_of,
    verified,
)
from vsb.results.year import frequencies, year
from vsb.study.study import Simulation
from vsb.waves.climate import realised
from vsb.waves.ndbc import read_ndbc
from vsb.waves.seas import Sea

SPECTRA = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"


@pytest.fixture(scope="module")
def measured():
    """A measured year of two bodies, each at its own best damper."""
    seas = read_ndbc(SPECTRA)
    grid = frequencies(seas, 0.1, 4.0)
    ports = {"A": port(grid), "B": port(grid, mass=25000.0)}
    found = year(ports, seas, WATER, ["one"], reference="A")
    strokes = [stroke_rms(p, seas, found.damping[i, 0, 0]) for i, p in enumerate(ports.values())]
    return found, np.array(strokes)


def test_draws_follow_the_energy():
    """Every stratum brings the same energy, and each of its seas is as likely as its part of it."""
    share, hours = np.array([0.1, 0.2, 0.3, 0.4]), np.full(4, 0.25)
    seas = np.array([drawn(share, hours, 4, seed).sea for seed in range(4000)])
    assert set(seas[:, :2].ravel()) == {0, 1, 2}  # 0.1 + 0.2 + a part of 0.3
    assert set(seas[:, 2:].ravel()) == {2, 3}
    found = np.bincount(seas.ravel()) / seas.size
    assert found == pytest.approx(share, abs=4 * np.sqrt(0.25 / seas.size))


def test_seas_lie_side_by_side_whose_hours_are_as_likely():
    """By the chance of an hour of each, not of all of them: 0.5, 3, 4 and 2 here, and none of one without hours."""
    share, hours = np.array([0.4, 0.3, 0.0, 0.2, 0.1]), np.array([0.8, 0.1, 0.0, 0.05, 0.05])
    seas = np.array([drawn(share, hours, 4, seed).sea for seed in range(300)])
    assert set(seas[:, :2].ravel()) == {0, 4}
    assert set(seas[:, 2:].ravel()) == {1, 3}
    assert np.mean(seas[:, :2] == 0) == pytest.approx(0.8, abs=0.07)
    assert np.mean(seas[:, 2:] == 1) == pytest.approx(0.6, abs=0.09)
    one = drawn(share, hours, 4, 1)
    assert one.weight == pytest.approx(hours[one.sea] / share[one.sea])


def test_the_same_seed_draws_the_same_seas():
    share, hours = np.full(50, 0.02), np.full(50, 0.02)
    a, b, other = (drawn(share, hours, 12, seed) for seed in (1, 1, 2))
    assert a.sea.tolist() == b.sea.tolist()
    assert a.seed.tolist() == b.seed.tolist()
    assert a.sea.tolist() != other.sea.tolist()
    assert len(set(a.seed)) == 12


def test_a_loss_in_proportion_is_found_exactly(measured):
    """Each design loses its own part of all seas: any two draws say the same of one design."""
    found, _ = measured
    share = found.power[0, 0] * found.climate.hours / found.annual_mean_power[0, 0]
    sample = drawn(share, found.climate.hours, 4, 7)
    linear = found.power[:1, 0, sample.sea]
    seas = found.power[:1, 0]
    checked = Verification(found.annual_mean_power[:1, 0], seas, found.climate.hours, sample, 0.9 * linear, linear)
    mean, low, high = checked.power(0)
    assert mean == pytest.approx(0.9 * found.annual_mean_power[0, 0], rel=1e-12)
    assert low == pytest.approx(mean, rel=1e-9)
    assert high == pytest.approx(mean, rel=1e-9)


@pytest.mark.parametrize("seas", [12, 24])
def test_intervals_cover_the_truth_of_a_thousand_campaigns(measured, seas):
    """A model that takes less the further a body moves; records scatter by 12 %, the same waves leave 1 % of it."""
    found, strokes = measured
    linear = found.power[:, 0]
    better = linear / (1 + np.array([[0.2], [0.3]]) * strokes**2)
    truth = better @ found.climate.hours
    gain = 100 * (truth[1] / truth[0] - 1)
    share, covered, means = chances(found, "one"), np.zeros(3), []
    for campaign in range(1000):
        sample, random = drawn(share, found.climate.hours, seas, campaign), np.random.default_rng(10**6 + campaign)
        record = random.normal(1.0, 0.12, seas)
        left = random.normal(0.0, 0.01, (2, seas))
        checked = verified(
            found, "one", sample, better[:, sample.sea] * (record + left), linear[:, sample.sea] * record
        )
        estimates = [checked.power(0), checked.power(1), checked.gain(1, 0)]
        covered += [low <= value <= high for (_, low, high), value in zip(estimates, (*truth, gain), strict=True)]
        means.append(checked.corrected)
    assert np.all((covered >= 930) & (covered <= 970)), covered
    apart = np.mean(means, axis=0) - truth
    assert np.all(np.abs(apart) < 4 * np.std(means, axis=0) / np.sqrt(1000))


def test_high_and_steep_seas_are_drawn_more_often_than_their_energy(measured):
    found, _ = measured
    energy, seas, likely = contributions(found, "one"), found.climate, chances(found, "one")
    assert likely.sum() == pytest.approx(1.0, rel=1e-12)
    assert np.all(likely >= energy / 2)  # no sea weighs too much
    grown = likely / energy - 0.5
    for by in (seas.hs, seas.hs / seas.te**2):
        assert grown[by > np.quantile(by, 0.99)].min() > 10 * grown[by < np.quantile(by, 0.5)].mean()


def test_designs_that_take_nothing_are_corrected_by_what_is_found():
    sample, still = Sample(np.arange(4), np.arange(4), np.full(4, 2.0)), np.zeros((2, 4))
    runs = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 2.0, 3.0, 4.0]])
    checked = Verification(np.zeros(2), still, np.full(4, 0.25), sample, runs, still)
    assert checked.corrected.tolist() == [0.0, 5.0]
    assert checked.power(0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("kind", ["height", "power", "steepness"])
def test_what_begins_in_few_seas_is_covered(measured, kind):
    """A loss beyond a threshold, in seas that bring 7 % of the energy: drawn by energy alone, 57 to 60 %."""
    found, _ = measured
    linear, hours, energy = found.power[:, 0], found.climate.hours, contributions(found, "one")
    hs, te = found.climate.hs, found.climate.te
    by = {"height": hs, "power": energy / hours, "steepness": hs / te**2}[kind]
    falling = np.argsort(-by)
    threshold = by[falling[np.searchsorted(np.cumsum(energy[falling]), 0.07)]]
    better = linear * (1 - np.minimum(0.6, np.array([[1.0], [1.6]]) * np.maximum(0, by / threshold - 1)))
    truth, covered = better @ hours, 0
    for campaign in range(300):
        sample = drawn(chances(found, "one"), hours, 12, campaign)
        left = np.random.default_rng(10**6 + campaign).normal(1.0, 0.01, (2, 12))
        checked = verified(found, "one", sample, better[:, sample.sea] * left, linear[:, sample.sea])
        _, low, high = checked.power(1)
        covered += low <= truth[1] <= high
    assert covered >= 243  # 87 % of a thousand, less three standard deviations


def test_what_a_record_has_more_or_less_of_than_its_sea_drops_out(measured):
    """A loss in proportion is known exactly from records that scatter by a half, of power and of gain."""
    found, _ = measured
    sample = drawn(chances(found, "one"), found.climate.hours, 8, 3)
    record = np.random.default_rng(5).uniform(0.5, 1.5, 8)
    linear = found.power[:, 0, sample.sea] * record
    checked = verified(found, "one", sample, np.array([[0.9], [0.7]]) * linear, linear)
    assert checked.power(0) == pytest.approx([0.9 * found.annual_mean_power[0, 0]] * 3, rel=1e-9)
    linear_gain = found.annual_mean_power[1, 0] / found.annual_mean_power[0, 0]
    assert checked.gain(1, 0) == pytest.approx([100 * (7 / 9 * linear_gain - 1)] * 3, rel=1e-9)


@pytest.mark.parametrize(("te", "decay", "start"), [(11.0, 0.4, 33.0), (11.0, 8.0, 40.0)])
def test_records_are_ten_energy_periods_from_rest_after_three_or_five_decay_times(te, decay, start):
    given = Simulation(duration=60.0, window=(20.0, 30.0), initial_velocity=-0.8, tolerance=1e-5)
    found = record_of(te, decay, given)
    assert (found.duration, found.window) == (pytest.approx(start + 110.0), pytest.approx((start, start + 110.0)))
    assert (found.initial_position, found.initial_velocity, found.tolerance) == (0.0, 0.0, 1e-5)


def test_motions_that_remember_longer_than_any_record_are_refused():
    with pytest.raises(ConfigError, match=r"motions that decay in 300 s in a sea of Te 11 s.*needs less than 220 s"):
        record_of(11.0, 300.0, Simulation())


def test_far_fewer_hours_than_plain_averaging(measured):
    """What is said of one campaign against the scatter of a hundred, and of a hundred plain averages."""
    found, strokes = measured
    linear, hours = found.power[:, 0], found.climate.hours
    better = linear / (1 + np.array([[0.2], [0.3]]) * strokes**2)
    share, ours, plain, said = contributions(found, "one"), [], [], []
    for campaign in range(200):
        sample, random = drawn(share, hours, 12, campaign), np.random.default_rng(10**6 + campaign)
        record = random.normal(1.0, 0.12, 12)
        checked = verified(found, "one", sample, better[:, sample.sea] * record, linear[:, sample.sea] * record)
        ours.append(checked.corrected[1])
        said.append(checked.fewer_hours(1))
        any_seas = random.integers(len(hours), size=12)
        plain.append(float(np.mean(better[1, any_seas] * random.normal(1.0, 0.12, 12))))
    true = np.var(plain) / np.var(ours)
    assert true > 100
    assert 0.3 * true < np.median(said) < 1.2 * true


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3])
def test_a_correction_knows_no_units(scale):
    """Of a buoy in a tank, or in milliwatts, powers are so many times as large and gains what they are."""
    random, hours = np.random.default_rng(5), np.full(40, 1 / 40)
    seas = random.uniform(0.1, 0.9, (2, 40))
    sample = drawn(seas[0] / seas[0].sum(), hours, 12, 7)
    linear = seas[:, sample.sea] * random.uniform(0.9, 1.1, (2, 12))
    better = linear * random.uniform(0.6, 1.0, (2, 12))

    def correction(factor, design):
        found = Verification(
            factor * seas @ hours, factor * seas, hours, sample, factor * better, factor * linear
        ).correction(design, 0)
        return [np.array(found.power) / factor, found.gain_percent or 0.0, found.fewer_hours]

    for design in (0, 1):
        for one, other in zip(correction(scale, design), correction(1.0, design), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-9)


@pytest.mark.parametrize("seas", [2, 7])
def test_seas_come_in_pairs(seas):
    with pytest.raises(ConfigError, match=rf"verify\.seas: received {seas}, needs an even number of at least 4"):
        drawn(np.full(5, 0.2), np.full(5, 0.2), seas, 0)


def test_what_cannot_be_verified(measured):
    found, _ = measured
    with pytest.raises(ConfigError, match="received the tuning 'each', needs one of one"):
        contributions(found, "each")
    sample = drawn(contributions(found, "one"), found.climate.hours, 4, 0)
    powers = np.ones((2, 4))
    with pytest.raises(ConfigError, match=r"received better powers of shape \(2, 3\), 0 of them"):
        verified(found, "one", sample, powers[:, :3], powers)
    with pytest.raises(ConfigError, match=r"received linear powers of shape \(2, 4\), 2 of them not finite"):
        verified(found, "one", sample, powers, np.where(np.arange(4) == 2, np.nan, powers))


def test_a_gain_over_itself_is_none(measured):
    found, _ = measured
    sample = Sample(np.arange(4), np.arange(4), np.full(4, 1e-3))
    powers = found.power[:, 0, :4]
    checked = verified(found, "one", sample, powers, powers)
    assert checked.gain(0, 0) is None
    assert checked.correction(0, None).gain_percent is None
    assert checked.correction(1, 0).gain_percent.mean == pytest.approx(
        100 * (found.annual_mean_power[1, 0] / found.annual_mean_power[0, 0] - 1)
    )


def test_realisations_hold_the_variance_and_the_power_of_their_sea():
    """Elevation and mean power over the whole period of the components, where no two of them beat."""
    seas = climate()
    duration = 2000.0
    sea = realised(seas, 3, duration, seed=5)
    assert float(np.sum(np.abs(sea.amplitude) ** 2)) / 2 == pytest.approx(seas.variance[3], rel=1e-9)
    period = 2 * np.pi / np.diff(sea.omega).min()
    assert period > duration
    here = port(sea.omega)
    mean = linear_power(here, sea, 2e4, (0.0, period))
    assert mean == pytest.approx(sea.mean_of(here.power(2e4)), rel=1e-3)
    assert np.abs(realised(seas, 3, duration, seed=6).amplitude) == pytest.approx(np.abs(sea.amplitude))
    assert realised(seas, 3, duration, seed=5, highest=1.0).omega.max() < 1.0
    assert realised(seas, 3, duration, seed=5, lowest=0.6).omega.min() > 0.6


@pytest.mark.parametrize("window", [(0.0, 40.0), (200.0, 240.0)])
def test_power_in_a_window_is_that_of_the_wave_wherever_it_lies(window):
    """Of one wave over whole periods half c |V|^2, in closed form."""
    omega = np.array([2 * np.pi / 4.0])
    port = Port(omega, np.array([2e-5 + 1e-5j]), np.array([0.7 + 0.2j]), 1e-5)
    speed = abs(port.velocity_under(port.load(8e3))[0]) * 0.5
    found = linear_power(port, Sea(omega, np.array([0.3 + 0.4j])), 8e3, window)
    assert found == pytest.approx(0.5 * 8e3 * speed**2, rel=1e-9)


@pytest.mark.filterwarnings("error")
def test_seas_that_are_alike_lie_in_the_order_of_the_climate_and_one_that_never_comes_is_never_drawn():
    share = np.append(np.full(50, 0.02), 0.0)
    for seed in range(20):
        sample = drawn(share, share, 50, seed)
        assert (sample.sea // 2).tolist() == np.repeat(np.arange(25), 2).tolist()
        assert sample.weight == pytest.approx(1.0)


def test_the_hours_saved_are_those_of_the_scatter_between_seas_and_within_them_over_that_of_the_draws():
    """Seas of 1 to 4 W: 1.25 W^2; records 0.5 W off: 0.25 W^2; draws +-a about nothing: a^2/2 of two strata.

    Two degrees of freedom: chi squared above -2 ln 0.75 in three of four.
    """
    seas, turned = np.array([[1.0, 2.0, 3.0, 4.0]]), np.array([[1.0, -1.0, 1.0, -1.0]])
    sample, hours, linear = Sample(np.arange(4), np.arange(4), np.ones(4)), np.full(4, 0.25), seas + 0.5 * turned

    def fewer(better):
        return Verification(np.array([2.5]), seas, hours, sample, better, linear).fewer_hours(0)

    for a in (0.1, 0.2):
        own = 4 * (a**2 / 2) * 2 / (-2 * np.log(0.75))
        assert fewer(linear + a * turned) == pytest.approx((1.25 + 0.25) / own, rel=1e-9)
    left = 0.1 * turned - 0.2 * linear  # four fifths of the year are left, and of the scatter that is averaged
    assert fewer(linear + left) == pytest.approx(0.8**2 * fewer(linear + 0.1 * turned), rel=1e-9)
    assert fewer(linear) == np.inf


def test_what_a_sea_brings_is_the_mean_of_what_it_brings_to_each_design_that_takes_something():
    """Of 1 W and 3 W, and a thousand times as much the other way round: half each; one that takes nothing counts not."""
    seas, grid = climate(seas=2), np.arange(0.1, 3.0, 0.05)
    found = year({"A": port(grid), "B": port(grid), "C": port(grid)}, seas, WATER, ("each", "one"))
    power = np.zeros_like(found.power)
    power[0, 1], power[1, 1] = np.array([1.0, 3.0]) / seas.hours, np.array([3e3, 1e3]) / seas.hours
    several = replace(found, power=power)
    assert contributions(several, "one") == pytest.approx([0.5, 0.5])
    with pytest.raises(
        ConfigError, match="verify: received designs that take no power under each, needs one that does"
    ):
        contributions(several, "each")
    with pytest.raises(ConfigError, match="verify: received designs that take no power under one, needs one that does"):
        contributions(replace(found, power=power[:, ::-1]), "one")
    assert contributions(replace(found, power=power[:1]), "one") == pytest.approx([0.25, 0.75])


def test_runs_correct_the_year_of_their_own_tuning_and_none_is_gained_over_a_loss(measured):
    """The second of two; a reference that is driven, on the whole, is nothing to gain over."""
    found, _ = measured
    both = replace(
        found,
        tunings=("each", "one"),
        power=np.concatenate([3 * found.power, found.power], axis=1),
    )
    sample = Sample(np.arange(4), np.arange(4), np.full(4, 1e-3))
    linear = found.power[:, 0, :4]
    checked = verified(both, "one", sample, linear, linear)
    assert checked.corrected == pytest.approx(found.annual_mean_power[:, 0], rel=1e-12)
    driven = verified(both, "one", sample, np.array([[-3.0], [1.0]]) * linear, linear)
    assert driven.corrected[0] < 0
    assert driven.gain(1, 0) is None
    with pytest.raises(
        ConfigError, match=r"received better powers of shape \(1, 4\), 0 of them not finite; needs 2 designs"
    ):
        verified(both, "one", sample, linear[:1], linear[:1])


@pytest.mark.parametrize("strata", [1, 2, 4])
def test_strata_that_scatter_alike_have_a_degree_of_freedom_each_and_no_more(strata):
    """Of S differences of 1 the variance is 1/(4 S), whichever is the larger of a pair."""
    draws = np.array([0.0, 1.0, 3.0, 2.0] * 2)[: 2 * strata]
    assert half_width(draws) == pytest.approx(student(strata) * np.sqrt(1 / (4 * strata)), rel=1e-12)


def test_seas_are_drawn_by_what_they_bring_their_height_and_their_steepness_each_to_its_power():
    """Half by energy, a quarter by that times Hs^4, a quarter by that times (Hs/Te^2)^4; in a year of four seas."""
    seas, grid = climate(seas=4), np.arange(0.1, 3.0, 0.05)
    found = year({"A": port(grid), "B": port(grid, mass=9e3)}, seas, WATER, ("each", "one"))
    energy, likely = contributions(found, "one"), np.zeros(4)
    for share, grows in ((0.5, np.ones(4)), (0.25, seas.hs**4), (0.25, seas.hs**4 / seas.te**8)):
        likely += share * energy * grows / float(energy @ grows)
    assert chances(found, "one") == pytest.approx(likely, rel=1e-12)
    assert np.abs(chances(found, "one") / chances(found, "each") - 1).max() > 1e-6


@pytest.mark.parametrize(
    ("second", "freedom"), [(1.0, 2.0), (3.0, 2.5 * 100 / 82 - 1.5), (0.0, 1.0), (10.0, 2.5 * 10201 / 10001 - 1.5)]
)
def test_strata_that_scatter_apart_have_fewer_degrees_of_freedom(second, freedom):
    """Of differences 1 and d the variance is (1 + d^2)/16, of F = (1 + d^2)^2/(1 + d^4) strata alike."""
    half = half_width(np.array([0.0, 1.0, 3.0, 3.0 - second]))
    assert half == pytest.approx(student(freedom) * np.sqrt(1 + second**2) / 4, rel=1e-12)


def test_a_design_that_is_another_times_as_much_gains_that_for_sure():
    """In every sea and run, however much both scatter; over more than it is, and over less."""
    sample, hours = Sample(np.arange(4), np.arange(4), np.array([1.0, 2.0, 1.5, 0.5])), np.full(4, 0.25)
    seas, better = np.array([5.0, 1.0, 4.0, 2.0]), np.array([3.0, 1.5, 2.0, 2.5])
    factors = np.array([[1.0], [1.7], [0.4]])
    found = Verification(3.0 * factors[:, 0], factors * seas, hours, sample, factors * better, factors * seas)
    assert np.ptp(found.power(0)) > 0.5
    for design, gain in ((1, 70.0), (2, -60.0)):
        assert found.gain(design, 0) == pytest.approx((gain, gain, gain), rel=1e-9)
    mean, low, high = found.gain(0, 2)
    assert (low, high) == pytest.approx((mean, mean))


@pytest.mark.filterwarnings("error")
def test_a_correction_is_about_the_ratio_of_what_is_left_to_what_is_taken():
    """Of draws of 4 W in the mean for a year of 8 W, twice what is left; of a design that takes nothing, what is left."""
    sample, hours = Sample(np.arange(4), np.arange(4), np.full(4, 2.0)), np.full(4, 0.25)
    seas = np.array([[2.0, 1.0, 2.0, 3.0], [0.0] * 4])
    left = np.array([[-1.0, -1.0, 0.0, 1.0], [1.0, 3.0, 2.0, 2.0]])
    found = Verification(np.array([8.0, 0.0]), seas, hours, sample, seas + left, seas)
    ratio = -0.5 / 4.0
    assert found.differences[0] == pytest.approx(2 * (2 * left[0] - ratio * 2 * seas[0]))
    assert found.differences[1] == pytest.approx(2 * left[1])
    assert found.corrected == pytest.approx([8.0 + 2 * -0.5, 4.0])
    assert found.gain(1, 0).mean == pytest.approx(100 * (4.0 / 7.0 - 1))
    assert found.correction(0, 1).gain_percent.mean == pytest.approx(75.0)


def test_what_is_said_of_a_design_among_others_is_what_is_said_of_it_alone():
    """Hours saved and power; of three, which scatter apart."""
    random, hours = np.random.default_rng(11), np.full(20, 1 / 20)
    seas = random.uniform(0.1, 0.9, (3, 20)) * np.array([[1.0], [5.0], [0.2]])
    sample = drawn(seas[0] / seas[0].sum(), hours, 8, 3)
    linear = seas[:, sample.sea] * random.uniform(0.8, 1.2, (3, 8))
    better = linear * random.uniform(0.5, 1.0, (3, 8))
    together = Verification(seas @ hours, seas, hours, sample, better, linear)
    for i in range(3):
        one = [i]
        alone = Verification(seas[one] @ hours, seas[one], hours, sample, better[one], linear[one])
        assert together.fewer_hours(i) == pytest.approx(alone.fewer_hours(0), rel=1e-12)
        assert together.power(i) == pytest.approx(alone.power(0), rel=1e-12)
        assert together.correction(i, None).fewer_hours == together.fewer_hours(i)
    assert together.correction(0, 2).gain_percent == together.gain(0, 2) != together.gain(0, 1)


@pytest.mark.parametrize("lost", [np.nan, np.inf, -np.inf])
def test_powers_that_are_not_finite_are_counted_whatever_they_are(measured, lost):
    found, _ = measured
    sample, powers = drawn(contributions(found, "one"), found.climate.hours, 4, 0), np.ones((2, 4))
    some = powers.copy()
    some[1, 2:] = lost
    for name, given in (("better", (some, powers)), ("linear", (powers, some))):
        with pytest.raises(
            ConfigError,
            match=rf"received {name} powers of shape \(2, 4\), 2 of them not finite; needs 2 designs by 4 seas, all fin",
        ):
            verified(found, "one", sample, *given)


def test_hours_saved_weigh_seas_by_their_hours_and_records_by_those_of_the_seas_they_stand_for():
    """Seas of uneven hours, drawn by other chances than those: for each of two designs, by the sums themselves."""
    hours, chance = np.array([0.5, 0.3, 0.15, 0.05]), np.array([0.25, 0.25, 0.3, 0.2])
    seas = np.array([[1.0, 2.0, 3.0, 8.0], [4.0, 1.0, 6.0, 2.0]])
    order = np.array([2, 0, 3, 1])
    sample = Sample(order, np.arange(4), (hours / chance)[order])
    linear = seas[:, order] + np.array([[0.5, -0.2, 0.3, 0.4], [-0.1, 0.2, 0.6, -0.3]])
    better = 0.8 * linear + np.array([[0.1, -0.3, 0.2, 0.4], [0.2, 0.1, -0.3, 0.2]])
    checked = Verification(seas @ hours, seas, hours, sample, better, linear)
    for i, powers in enumerate(seas):
        year = sum(h * p for h, p in zip(hours, powers, strict=True))
        between = sum(h * (p - year) ** 2 for h, p in zip(hours, powers, strict=True))
        within = sum(hours[k] / chance[k] * (run - powers[k]) ** 2 for k, run in zip(order, linear[i], strict=True)) / 4
        x, y, z, w = checked.differences[i]
        parts = (x - y) ** 2 / 16, (z - w) ** 2 / 16
        freedom = min(2.0, 2.5 * sum(parts) ** 2 / (parts[0] ** 2 + parts[1] ** 2) - 1.5)
        own = 4 * sum(parts) * freedom / chdtri(freedom, 0.75)
        expected = (checked.corrected[i] / year) ** 2 * (between + within) / own
        assert checked.fewer_hours(i) == pytest.approx(expected, rel=1e-9)


def test_the_interval_of_a_corrected_power_lies_evenly_about_it_below_nothing_as_well():
    """As of a better model that is driven in some of its seas."""
    hours, seas = np.full(4, 0.25), np.array([[1.0, 2.0, 3.0, 4.0]])
    sample = Sample(np.arange(4), np.arange(4), np.ones(4))
    for better in ([[-3.0, 1.0, -2.0, 0.5]], [[0.2, 3.0, 0.1, 2.0]]):
        mean, low, high = Verification(np.array([2.5]), seas, hours, sample, np.array(better), seas).power(0)
        assert mean == pytest.approx(np.mean(better))
        assert high - mean == pytest.approx(mean - low)
        assert low < 0
