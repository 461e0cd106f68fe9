"""A few runs in time correct a year: seas drawn, runs against linear theory, intervals of nominal coverage."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from results.test_year import WATER, climate, port

from vsb.engine.hydro.radiation import fit_radiation
from vsb.engine.integrators.settings import Simulation
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.take_off import Pto
from vsb.engine.waves.climate import realised
from vsb.engine.waves.measured_spectra import read_ndbc
from vsb.errors import ConfigError
from vsb.models.build import Memory
from vsb.models.rest import design_motions, reference_shell, study_basis
from vsb.results.statistics import linear_batches
from vsb.results.verification import (
    DECAYS,
    GAIN,
    LONGEST,
    POWER,
    DesignInTime,
    Verification,
    chances,
    contributions,
    drawn,
    record_of,
    verified,
    verified_dataset,
    with_all_designs,
)
from vsb.results.year import band_weights, frequencies, year
from vsb.stages.members import powers_in_time

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


@pytest.mark.slow
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
    assert chances(found, "one").sum() == pytest.approx(1.0)
    assert (chances(found, "one") >= energy / 2).all()
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


@pytest.mark.parametrize(("better", "count"), [(np.ones((2, 7)), 0), (np.full((2, 8), np.nan), 16)])
def test_powers_that_are_missing_or_not_finite_are_refused(measured, better, count):
    found, _ = measured
    sample = drawn(chances(found, "one"), found.climate.hours, 8, 3)
    with pytest.raises(ConfigError, match=rf"verify: received better powers of shape .*, {count} of them not finite"):
        verified(found, "one", sample, better, np.ones((2, 8)))


def test_start_up_lasts_as_long_as_motions_remember_up_to_a_hundred_periods():
    ends = [record_of(11.0, decay, Simulation()).window[0] for decay in (2.0, 50.0, 300.0, np.inf)]
    assert ends == pytest.approx([33.0, 250.0, 1100.0, 1100.0])


@pytest.mark.parametrize("seas", [2, 7])
def test_odd_number_of_seas_is_refused(seas):
    with pytest.raises(ConfigError, match=rf"verify\.seas: received {seas}, needs an even number of at least 4"):
        drawn(np.full(5, 0.2), np.full(5, 0.2), seas, 0)


def test_realisation_has_the_variance_and_the_power_of_its_sea():
    """Over the common period of its components."""
    seas = climate()
    duration = 2000.0
    sea = realised(seas, 3, duration, seed=5)
    assert float(np.sum(np.abs(sea.amplitude) ** 2)) / 2 == pytest.approx(seas.variance[3], rel=1e-9)
    period = 2 * np.pi / np.diff(sea.omega).min()
    assert period > duration
    here = port(sea.omega)
    mean = linear_batches(
        sea.omega, np.sqrt(2e4) * (here.velocity_under(here.load(2e4)) * sea.amplitude)[:, None], (0.0, period), 1
    )[0]
    assert mean == pytest.approx(sea.mean_of(here.power(2e4)), rel=1e-3)
    assert np.abs(realised(seas, 3, duration, seed=6).amplitude) == pytest.approx(np.abs(sea.amplitude))
    assert realised(seas, 3, duration, seed=5, highest=1.0).omega.max() < 1.0
    assert realised(seas, 3, duration, seed=5, lowest=0.6).omega.min() > 0.6


@pytest.fixture(scope="module")
def known():
    """A year of two bodies and a sample of its seas."""
    seas = climate()
    grid = frequencies(seas, 0.1, 4.0)
    found = year({"A": port(grid), "B": port(grid, mass=9000.0)}, seas, WATER, ("each", "one"), reference="A")
    return found, drawn(contributions(found, "one"), seas.hours, 8, 1)


def corrected(known, part):
    """The year whose designs absorb a share of the linear power."""
    found, sample = known
    linear = found.power[:, 1][:, sample.sea]
    return verified_dataset(found, "one", verified(found, "one", sample, np.array(part)[:, None] * linear, linear))


def test_proportional_loss_is_found_without_scatter(known):
    """A loss that grows with height has an interval."""
    found, sample = known
    linear = found.annual_mean_power[:, 1]
    ds = corrected(known, [0.8, 0.8])
    for name in POWER:
        np.testing.assert_allclose(ds[name], 0.8 * linear, rtol=1e-9)
    taken, hs = found.power[:, 1][:, sample.sea], found.climate.hs[sample.sea]
    ds = verified_dataset(found, "one", verified(found, "one", sample, (1 - 0.05 * hs) * taken, taken))
    lost = (sample.weight * 0.05 * hs * taken).mean(axis=1) / (sample.weight * taken).mean(axis=1)
    np.testing.assert_allclose(ds.corrected_mean_power, linear * (1 - lost), rtol=1e-12)
    assert bool((ds.corrected_power_low < ds.corrected_mean_power).all())
    assert bool((ds.corrected_power_high > ds.corrected_mean_power).all())
    assert [float(ds[name].sel(design="A")) for name in GAIN] == [0.0, 0.0, 0.0]
    ratio = float(ds.corrected_mean_power.sel(design="B") / ds.corrected_mean_power.sel(design="A"))
    assert float(ds.corrected_gain_percent.sel(design="B")) == pytest.approx(100 * (ratio - 1), rel=1e-12)
    np.testing.assert_array_equal(ds.drawn_hs, found.climate.hs[sample.sea])


def test_gain_is_certain_where_both_designs_lose_alike(known):
    """Of every draw the same share, by chance: powers have intervals, their ratio has none."""
    _, sample = known
    rng, draws = np.random.default_rng(3), len(sample.sea)
    linear = np.outer([1.0, 1.5], rng.uniform(1.0, 2.0, draws))
    better = rng.uniform(0.6, 0.9, draws) * linear
    both = Verification(np.array([2.0, 3.0]), linear, np.full(draws, 1 / draws), sample, better, linear)
    power, gain = both.power(0), both.gain(1, 0)
    assert power.high - power.low > 0.01 * power.mean
    assert (gain.low, gain.mean, gain.high) == pytest.approx((50.0, 50.0, 50.0), rel=1e-9)


def test_designs_that_are_not_viable_have_no_values(known):
    ds = with_all_designs(corrected(known, [0.9, 0.9]), ["A", "C", "B"], "A")
    assert ds.viable.values.tolist() == [True, False, True]
    for name in (*POWER, *GAIN, "run_power"):
        assert np.isnan(ds[name].sel(design="C")).all()
        assert np.isfinite(ds[name].sel(design=["A", "B"])).all()


def test_reference_without_power_is_refused(known):
    with pytest.raises(ConfigError, match=r"corrected power of -[\d.e+]+ W of the rigid A; needs more than 0 W"):
        corrected(known, [-3.0, 1.0])


@pytest.fixture(scope="module")
def rigid(seed, spectral_seed):
    """The seed's rigid buoy at 20 kN s/m."""
    radiation, basis = fit_radiation(spectral_seed.spectrum, 1e-3)[0], study_basis(seed)
    memory, motions = Memory(radiation, spectral_seed.added_mass_inf), design_motions(seed, basis, "FSB")
    return DesignInTime(spectral_seed, reference_shell(seed).shape, memory, motions, LinearPto(2e4))


def test_spring_of_the_take_off_shifts_run_and_theory_alike(rigid):
    sea, settings = realised(climate(), 3, 150.0, seed=1), Simulation(duration=150.0, window=(60.0, 150.0))
    held = replace(rigid, take_off=replace(rigid.take_off, stiffness=2e4))
    run, theory = held.powers(sea, settings, "linear")
    assert run == pytest.approx(theory, rel=2e-3)
    assert abs(theory / rigid.powers(sea, settings, "linear")[1] - 1) > 0.05


def test_motion_that_outlasts_the_start_up_is_compared_from_rest_and_widens_the_interval(rigid):
    """A spring that all but cancels the water's leaves heave a natural period of 20 s, in which it hardly radiates.

    A linear run then differs from the steady state by its transient alone: the year stays, its interval holds that.
    """
    seas = climate(8)
    soft = replace(rigid, take_off=LinearPto(20.0, -0.985 * float(rigid.buoy.stiffness[0, 0]), rigid.take_off.port))
    assert soft.decay_time(float(seas.edges[-1])) > seas.te.max() * LONGEST / DECAYS
    sample, hours = drawn(np.full(8, 1 / 8), seas.hours, 4, 1), seas.hours
    run, linear, steady = powers_in_time(seas, np.full((1, 8), 20.0), sample, {"A": soft}, Simulation(), "linear")
    assert run == pytest.approx(linear, rel=1e-5)
    apart = (sample.weight * np.abs(run - steady)).sum() / (sample.weight * steady).sum()
    assert apart > 0.01
    runs = Verification(np.array([5.0]), steady, hours, sample, run, linear, steady)
    assert runs.power(0) == pytest.approx([5.0, 5.0 * (1 - apart), 5.0 * (1 + apart)], rel=1e-4)


def test_tolerance_of_the_runs_is_far_below_the_intervals(rigid):
    """Against a motion a hundred times as exact, whose audit closes a hundred times as well."""
    settings = record_of(8.0, 2.0, Simulation())
    sea = realised(climate(), 3, settings.duration, seed=1)
    exact = settings.model_copy(update={"tolerance": 1e-7})
    assert rigid.powers(sea, settings)[0] == pytest.approx(rigid.powers(sea, exact)[0], rel=1e-5)


@pytest.mark.slow
def test_nonlinear_correction_scales_with_the_amplitude_squared(rigid):
    """Relative to the linear run in the same waves."""
    sea = realised(climate(), 3, 150.0, seed=1)
    settings = Simulation(duration=150.0, window=(60.0, 150.0), tolerance=1e-8)
    linear = rigid.powers(sea, settings, "linear")
    apart = []
    for part in (0.1, 0.2, 0.4):
        run, theory = rigid.powers(replace(sea, amplitude=part * sea.amplitude), settings)
        assert theory == pytest.approx(part**2 * linear[1], rel=1e-12)
        apart.append(run / theory - linear[0] / linear[1])
    assert abs(apart[0]) < 1e-3
    assert np.log2(np.array(apart[1:]) / apart[:-1]) == pytest.approx([2.0, 2.0], abs=0.2)


def test_force_and_stroke_limits_reduce_the_power(rigid):
    sea, settings = realised(climate(), 3, 60.0, seed=1), Simulation(duration=60.0, window=(40.0, 60.0))
    free, theory = rigid.powers(sea, settings, "linear")
    wide, tight = (replace(rigid, pto=Pto(damping=2e4, force_limit=limit)) for limit in (1e9, 4e3))
    assert wide.powers(sea, settings, "linear") == pytest.approx((free, theory), rel=1e-6)
    held = tight.powers(sea, settings, "linear")
    assert held[1] == theory
    assert 0.1 * free < held[0] < 0.9 * free
    stopped = replace(rigid, pto=Pto(damping=2e4, stroke_limit=0.3)).powers(sea, settings, "linear")
    assert stopped[0] < 0.9 * free


@pytest.mark.slow
def test_latching_absorbs_more_than_a_weak_damper(rigid):
    weak = rigid.with_damping(1e3)
    sea, settings = realised(climate(), 3, 30.0, seed=1), Simulation(duration=30.0, window=(10.0, 30.0))
    latched = replace(weak, pto=Pto(damping=1e3, law="latching")).powers(sea, settings, "linear")
    assert latched[0] > 1.2 * weak.powers(sea, settings, "linear")[0]
