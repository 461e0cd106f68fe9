"""A few runs in time correct a year: unbiased, with intervals of nominal coverage."""

from pathlib import Path

import numpy as np
import pytest
from results.test_year import WATER, climate, port

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
from vsb.results.year import band_weights, frequencies, year
from vsb.study.study import Simulation
from vsb.waves.climate import realised
from vsb.waves.ndbc import read_ndbc
from vsb.waves.seas import Sea

SPECTRA = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"


@pytest.fixture(scope="module")
def measured():
    """A measured year of two bodies at their optimal damping, and their rms strokes."""
    seas = read_ndbc(SPECTRA)
    grid = frequencies(seas, 0.1, 4.0)
    ports = {"A": port(grid), "B": port(grid, mass=25000.0)}
    found = year(ports, seas, WATER, ["one"], reference="A")
    strokes = []
    for i, one in enumerate(ports.values()):
        stroke = np.abs(one.velocity_under(one.load(found.damping[i, 0, 0])) / grid) ** 2 / 2
        strokes.append(np.sqrt(seas.density @ (band_weights(grid, seas) @ stroke)))
    return found, np.array(strokes)


def test_seas_are_drawn_in_proportion_to_their_energy():
    """Every stratum has the same energy, within which a sea is as likely as its share."""
    share, hours = np.array([0.1, 0.2, 0.3, 0.4]), np.full(4, 0.25)
    seas = np.array([drawn(share, hours, 4, seed).sea for seed in range(4000)])
    assert set(seas[:, :2].ravel()) == {0, 1, 2}  # 0.1 + 0.2 + a part of 0.3
    assert set(seas[:, 2:].ravel()) == {2, 3}
    found = np.bincount(seas.ravel()) / seas.size
    assert found == pytest.approx(share, abs=4 * np.sqrt(0.25 / seas.size))


def test_same_seed_draws_the_same_seas():
    share, hours = np.full(50, 0.02), np.full(50, 0.02)
    a, b, other = (drawn(share, hours, 12, seed) for seed in (1, 1, 2))
    assert a.sea.tolist() == b.sea.tolist()
    assert a.seed.tolist() == b.seed.tolist()
    assert a.sea.tolist() != other.sea.tolist()
    assert len(set(a.seed)) == 12


def test_proportional_loss_is_found_exactly(measured):
    """A design that loses 10 % in every sea."""
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


def test_intervals_cover_the_truth_of_many_campaigns(measured):
    """Losses grow with the stroke; records scatter by 12 %, of which 1 % remains between models in the same waves."""
    seas = 12
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


def test_loss_that_starts_in_few_seas_is_covered(measured):
    """A loss beyond a height above which seas have 7 % of the energy; drawing by energy alone covers 57 to 60 %."""
    found, _ = measured
    linear, hours, energy = found.power[:, 0], found.climate.hours, contributions(found, "one")
    by = found.climate.hs
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


def test_scatter_between_records_cancels(measured):
    """Proportional losses are known exactly from records that scatter by a half."""
    found, _ = measured
    sample = drawn(chances(found, "one"), found.climate.hours, 8, 3)
    record = np.random.default_rng(5).uniform(0.5, 1.5, 8)
    linear = found.power[:, 0, sample.sea] * record
    checked = verified(found, "one", sample, np.array([[0.9], [0.7]]) * linear, linear)
    assert checked.power(0) == pytest.approx([0.9 * found.annual_mean_power[0, 0]] * 3, rel=1e-9)
    linear_gain = found.annual_mean_power[1, 0] / found.annual_mean_power[0, 0]
    assert checked.gain(1, 0) == pytest.approx([100 * (7 / 9 * linear_gain - 1)] * 3, rel=1e-9)


def test_motion_that_decays_too_slowly_is_refused():
    with pytest.raises(ConfigError, match=r"motions that decay in 300 s in a sea of Te 11 s.*needs less than 220 s"):
        record_of(11.0, 300.0, Simulation())


def test_correction_scales_with_the_unit_of_power():
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
        for one, other in zip(correction(1e-6, design), correction(1.0, design), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-9)


@pytest.mark.parametrize("seas", [2, 7])
def test_odd_number_of_seas_is_refused(seas):
    with pytest.raises(ConfigError, match=rf"verify\.seas: received {seas}, needs an even number of at least 4"):
        drawn(np.full(5, 0.2), np.full(5, 0.2), seas, 0)


def test_errors_of_verification(measured):
    found, _ = measured
    with pytest.raises(ConfigError, match="received the tuning 'each', needs one of one"):
        contributions(found, "each")
    sample = drawn(contributions(found, "one"), found.climate.hours, 4, 0)
    powers = np.ones((2, 4))
    with pytest.raises(ConfigError, match=r"received better powers of shape \(2, 3\), 0 of them"):
        verified(found, "one", sample, powers[:, :3], powers)
    with pytest.raises(ConfigError, match=r"received linear powers of shape \(2, 4\), 2 of them not finite"):
        verified(found, "one", sample, powers, np.where(np.arange(4) == 2, np.nan, powers))


def test_realisation_has_the_variance_and_the_power_of_its_sea():
    """Over the common period of its components."""
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
def test_linear_power_of_a_regular_wave_in_any_window(window):
    """P = c |V|^2 / 2 over whole periods."""
    omega = np.array([2 * np.pi / 4.0])
    port = Port(omega, np.array([2e-5 + 1e-5j]), np.array([0.7 + 0.2j]), 1e-5)
    speed = abs(port.velocity_under(port.load(8e3))[0]) * 0.5
    found = linear_power(port, Sea(omega, np.array([0.3 + 0.4j])), 8e3, window)
    assert found == pytest.approx(0.5 * 8e3 * speed**2, rel=1e-9)


def test_hours_saved_have_their_closed_form():
    """Variance 1.25 W^2 between seas of 1 to 4 W and 0.25 W^2 within them, over a^2/2 of the draws.

    With two degrees of freedom chi squared exceeds -2 ln 0.75 in three of four cases.
    """
    seas, turned = np.array([[1.0, 2.0, 3.0, 4.0]]), np.array([[1.0, -1.0, 1.0, -1.0]])
    sample, hours, linear = Sample(np.arange(4), np.arange(4), np.ones(4)), np.full(4, 0.25), seas + 0.5 * turned

    def fewer(better):
        return Verification(np.array([2.5]), seas, hours, sample, better, linear).fewer_hours(0)

    for a in (0.1, 0.2):
        own = 4 * (a**2 / 2) * 2 / (-2 * np.log(0.75))
        assert fewer(linear + a * turned) == pytest.approx((1.25 + 0.25) / own, rel=1e-9)
    assert fewer(linear) == np.inf


@pytest.mark.parametrize(("second", "freedom"), [(1.0, 2.0), (3.0, 2.5 * 100 / 82 - 1.5), (0.0, 1.0)])
def test_degrees_of_freedom_of_unequal_strata(second, freedom):
    """Differences 1 and d: variance (1 + d^2)/16, effective number of strata (1 + d^2)^2/(1 + d^4)."""
    half = half_width(np.array([0.0, 1.0, 3.0, 3.0 - second]))
    assert half == pytest.approx(student(freedom) * np.sqrt(1 + second**2) / 4, rel=1e-12)
