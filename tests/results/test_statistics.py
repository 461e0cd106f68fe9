"""Statistics of mean power in irregular seas: coverage of intervals, variances, realisations."""

from functools import cache

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.engine.motion.port import Port
from vsb.engine.waves.seas import Sea, superposed
from vsb.models.build import TUNED
from vsb.results import statistics as seastatistics
from vsb.results.ledger import seas_checks
from vsb.results.statistics import (
    Line,
    Sample,
    batch_means,
    families,
    half_width,
    linear_batches,
    record_covariance,
    sample,
    statistical_checks,
    statistics,
)
from vsb.study.study import FEWEST_BATCHES, parse

DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}}


def run_of(power, time):
    """A run with its absorbed energy only."""
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    return xr.Dataset({"energy": (("time", "term"), energy[:, None])}, coords={"time": time, "term": ["pto"]})


MADE = {"FSB": (1.6, 0.05, 1.0), "VSWEC": (1.8, 0.08, 1.3)}
"""Natural frequency [rad/s], damping ratio and take-off damping of resonators in place of designs."""
LAWS = {"linear": lambda c, v: c * v**2, "coulomb": lambda c, v: 0.3 * c * np.abs(v)}
"""Absorbed power [W] of a velocity."""


def made(study, wave, law):
    """Samples of runs of `MADE` in a realisation, in closed form."""
    window, duration = study.simulation.window, study.simulation.duration
    waves, spectral = wave.realisation(4.0, duration), wave.expected.realisation(4.0, duration)
    count = int((window[1] - window[0]) / wave.memory + 1e-9)
    steps = int(np.ceil(seastatistics.INSTANTS * waves.omega.max() * (window[1] - window[0]) / count / (2 * np.pi)))
    found = {}
    for name, (natural, ratio, damper) in MADE.items():
        transfer = -1j * waves.omega / (natural**2 - waves.omega**2 - 2j * ratio * natural * waves.omega)
        speed = superposed(waves.omega, (transfer * waves.amplitude)[:, None], np.linspace(*window, count * steps + 1))
        batches = LAWS[law](damper, speed[:-1, 0]).reshape(count, steps).mean(axis=1)
        alike = linear_batches(waves.omega, np.sqrt(damper) * (transfer * waves.amplitude)[:, None], window, count)
        parts = (np.sqrt(damper / 2) * transfer * np.abs(spectral.amplitude))[:, None]
        linear = float(np.sum(np.abs(parts) ** 2))
        found[name, wave.label] = Sample(batches, alike, linear, parts, float(np.diff(waves.omega).mean()))
    return found


def made_study(coarse, amplitudes="random", seed=1, realisations=1, duration=460.0, **wave):
    """A study of a sea, by default 400 s at Tp = 4 s."""
    kind = {"kind": "jonswap", "hs": 1.0, "tp": 4.0} | wave
    waves = [{**kind, "amplitudes": amplitudes, "seed": seed, "realisations": realisations}]
    return varied(coarse, designs=DESIGNS, waves=waves, simulation={"duration": duration, "window": [60.0, duration]})


def lines_of(coarse, law, **given):
    """Statistics of made-up runs in realisations of a sea."""
    study = made_study(coarse, **given)
    return statistics(study, {key: one for wave in study.waves for key, one in made(study, wave, law).items()})


@pytest.fixture(scope="module")
def realisations(coarse):
    """Function law -> 500 realisations of a sea, each as (study, samples)."""

    @cache
    def records(law):
        study = made_study(coarse)
        waves = [study.waves[0].model_copy(update={"seed": 1 + i}) for i in range(500)]
        return [(study.model_copy(update={"waves": (wave,)}), made(study, wave, law)) for wave in waves]

    return records


@pytest.mark.slow
def test_intervals_have_their_nominal_coverage(realisations):
    """Records of 400 s in a Gaussian sea; the binomial deviation of 500 is 1 %."""
    cases = [statistics(study, samples) for study, samples in realisations("coulomb")]
    power = np.array([[line.power_mean for line in lines] for lines in cases]).mean(axis=0)
    gain = 100 * (power[1] / power[0] - 1)
    covered = [np.mean([lines[i].power_low < power[i] < lines[i].power_high for lines in cases]) for i in (0, 1)]
    covered.append(np.mean([lines[1].gain_low < gain < lines[1].gain_high for lines in cases]))
    assert min(covered) >= 0.93, covered
    assert max(covered) <= 0.97, covered


def test_interval_narrows_with_the_root_of_the_realisations(coarse):
    """In linear theory the variance of a record is known."""
    (one, _), (four, _) = (lines_of(coarse, "linear", realisations=n) for n in (1, 4))
    assert (four.realisations, four.batches) == (4, 40)
    assert four.power_high - four.power_mean == pytest.approx((one.power_high - one.power_mean) / 2, rel=0.05)


@pytest.mark.slow
def test_covariance_of_records_equals_that_of_many_records(realisations):
    records = [samples for _, samples in realisations("linear")]
    means = np.array([[one.batches.mean() for one in record.values()] for record in records])
    parts = [one.components for one in records[0].values()]
    spacing = next(iter(records[0].values())).spacing
    known = [[record_covariance(a, b, spacing, 400.0) for a in parts] for b in parts]
    scatter = np.cov(means.T)
    np.testing.assert_allclose(known, scatter, rtol=0.15)
    assert known[0][1] / np.sqrt(known[0][0] * known[1][1]) > 0.3  # the same waves


def test_variance_of_the_mean_is_the_sum_over_component_pairs():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 7, 2)) @ [1, 1j]
    at = 0.03 * np.arange(7)
    product, apart = a.conj() * b, np.sinc((at[:, None] - at) * 50.0 / (2 * np.pi)) ** 2
    assert record_covariance(a[:, None], b[:, None], 0.03, 50.0) == pytest.approx(
        (product @ apart @ product.conj()).real, rel=1e-12
    )


def test_fixed_amplitudes_have_the_interval_of_the_numerical_error(coarse):
    """The tolerance of the coefficients; the scatter between seeds is not included."""
    fixed, shell = lines_of(coarse, "linear", amplitudes="fixed")
    tolerance = made_study(coarse).hydro.tolerance
    for end, sign in (("low", -1), ("high", 1)):
        assert getattr(fixed, f"power_{end}") == pytest.approx((1 + sign * tolerance) * fixed.power_mean, rel=1e-12)
        width = 2 * tolerance * (100 + shell.gain_percent)
        assert getattr(shell, f"gain_{end}") == pytest.approx(shell.gain_percent + sign * width, rel=1e-9)
    means = [lines_of(coarse, "linear", amplitudes="fixed", seed=seed)[0].power_mean for seed in range(1, 21)]
    assert fixed.power_linear_record == pytest.approx(fixed.power_mean, rel=1e-3)
    assert fixed.power_linear == pytest.approx(np.mean(means), rel=0.05)


def test_gains_in_the_same_waves_are_sharper_than_powers(coarse):
    """Of proportional designs the gain is certain whatever the record."""
    study = made_study(coarse)
    samples = made(study, study.waves[0], "linear")
    label = study.waves[0].label
    base = samples["FSB", label]
    alike = Sample(
        1.2 * base.batches, 1.2 * base.linear_batches, 1.2 * base.linear, np.sqrt(1.2) * base.components, base.spacing
    )
    fixed, shell = statistics(study, {("FSB", label): base, ("VSWEC", label): alike})
    assert (shell.gain_percent, shell.gain_low, shell.gain_high) == pytest.approx((20.0,) * 3, abs=1e-6)
    assert fixed.power_high - fixed.power_low > 0.2 * fixed.power_mean
    assert fixed.gain_percent is None


def test_residual_scatter_has_students_interval():
    """Nine samples of deviation 1, uncorrelated with linear theory: t(0.975, 7) = 2.365."""
    rng = np.random.default_rng(1)
    alike = rng.normal(size=9)
    alike -= alike.mean()
    samples = rng.normal(size=9)
    samples -= samples.mean()
    samples -= alike * (alike @ samples) / (alike @ alike)
    samples /= np.sqrt(samples @ samples / 7)
    assert half_width(5 + samples, alike[:, None], np.zeros((1, 1))) == pytest.approx(2.365 / 3, rel=1e-3)
    known = half_width(5 + 2 * alike, 7 + alike[:, None], np.array([[0.25]]))
    assert known == pytest.approx(1.95996 * 2 * 0.5, rel=1e-5)


def test_short_record_has_no_interval(coarse):
    short, shell = lines_of(coarse, "linear", duration=60.0 + 5 * 40.0)
    assert (short.batches, short.power_low, short.power_high, shell.gain_low) == (5, None, None, None)
    assert shell.gain_percent is not None
    assert lines_of(coarse, "linear", duration=60.0 + 6 * 40.0)[0].power_low is not None
    study = made_study(coarse)
    still = {key: one._replace(batches=0 * one.batches) for key, one in made(study, study.waves[0], "linear").items()}
    assert [line.gain_percent for line in statistics(study, still)] == [None, None]


def test_batch_means_average_to_the_mean_of_the_window():
    time = np.linspace(0.0, 100.0, 2001)
    power = 3 + np.sin(0.7 * time) ** 2
    means = batch_means(run_of(power, time), (10.0, 95.0), 20.0)
    assert len(means) == 4
    inside = (time >= 10) & (time <= 95)
    assert means.mean() == pytest.approx(np.trapezoid(power[inside], time[inside]) / 85.0, rel=1e-4)
    assert len(batch_means(run_of(power, time), (10.0, 12.0), 20.0)) == 1


def test_linear_batches_of_a_regular_wave():
    """c |V|^2 / 2 in every batch of whole periods."""
    omega = np.array([2 * np.pi / 4.0])
    found = linear_batches(omega, np.sqrt(8e3) * np.array([[0.3 + 0.4j]]), (20.0, 60.0), 5)
    assert found == pytest.approx(np.full(5, 0.5 * 8e3 * 0.25), rel=1e-9)


def test_sample_of_a_tuned_run_has_its_closed_form(coarse):
    """In the second of two wave directions, beside a spring, over whole periods of the beat of two waves."""
    band = {"kind": "white_noise", "hs": 1.0, "band": [1.9, 2.1], "amplitudes": "random"}
    spring, period = -900.0, 4 * np.pi / 0.2  # of the correlation of the sea
    run = {"duration": 500.0, "window": [40.0, 40.0 + 4.5 * period]}
    study = varied(coarse, waves=[band], simulation=run, pto={"damping": 8e3, "stiffness": spring})
    wave = study.waves[0].model_copy(update={"direction": 90.0})
    omega, time = np.linspace(0.5, 4.0, 36), np.linspace(0.0, 500.0, 5001)
    port = Port(omega, 1 / (2e3 + 300.0 * omega - 1j * (17e3 * omega - 4e4 / omega)), 1.0 + 0.5j * omega, 1e-4)
    values = {"port_impedance": port.impedance, "port_velocity": port.velocity, "absorbed_power": 3.0 + 0 * omega}
    dims = ("wave_direction", "design", "omega")
    response = xr.Dataset(
        {name: (dims, np.stack([7.0 * value, value])[:, None]) for name, value in values.items()},
        {"wave_direction": [0.0, np.pi / 2], "design": ["A"], "omega": omega},
    ).assign(port_impedance=(("design", "omega"), port.impedance[None]))
    waves, spectral = (
        Sea(omega[[14, 15]], amplitude) for amplitude in (np.array([0.3 + 0.4j, -1.0]), np.array([0.6, 0.8]))
    )
    known = run_of(np.full(5001, 7.0), time)
    kept = sample(study, wave, "A", known.assign_attrs({TUNED: 4e3}), waves, spectral, response)
    powers = port.power(4e3, spring)[[14, 15]]
    assert kept.batches == pytest.approx(np.full(4, 7.0))
    assert kept.linear == pytest.approx(float(powers @ [0.36, 0.64]), rel=1e-9)
    assert np.abs(kept.components[:, 0]) ** 2 == pytest.approx(powers * [0.36, 0.64], rel=1e-9)
    assert kept.spacing == pytest.approx(0.1)
    speed = port.velocity_under(port.load(4e3, spring))[[14, 15]] * waves.amplitude
    instants = np.linspace(*study.simulation.window, 40001)
    power = 4e3 * np.real(np.exp(-1j * np.outer(instants, omega[[14, 15]])) @ speed) ** 2
    assert kept.linear_batches.mean() == pytest.approx(np.trapezoid(power) / 40000, rel=1e-3)
    assert sample(study, wave, "A", known, waves, spectral, response).linear == pytest.approx(3.0, rel=1e-9)


def line_of_100_watts(half=1.0, apart=0.0, batches=20):
    """A line of 100 W, its half interval and its distance from linear theory [W]."""
    low, high = (None, None) if batches < FEWEST_BATCHES else (100.0 - half, 100.0 + half)
    return [Line("FSB", "sea", "random", 1, batches, 100.0 + apart, low, high, 90.0, 100.0, None, None, None)]


@pytest.mark.parametrize(
    ("name", "limit", "changed"), [("statistical_error", 0.1, "half"), ("spectral_prediction", 0.005, "apart")]
)
def test_checks_of_irregular_seas_change_their_verdict_at_their_limit(seed, name, limit, changed):
    for share, verdict in ((0.99, "ok"), (1.01, "doubt")):
        found = {
            check.name: check for check in statistical_checks(seed, line_of_100_watts(**{changed: 100 * share * limit}))
        }
        assert (found[name].verdict, found[name].limit) == (verdict, limit)
        assert found[name].value == pytest.approx(share * limit, rel=2e-3)


def test_length_of_records_is_judged_before_anything_runs(seed):
    """Of every irregular sea: 20 s are two batches of ten periods; what is linear does not depend on its record."""
    sea = {"kind": "jonswap", "hs": 0.5, "tp": 1.0}
    for amplitudes, realisations, verdict in (("fixed", 1, "doubt"), ("random", 2, "doubt"), ("fixed", 3, "ok")):
        waves = [{**sea, "amplitudes": amplitudes, "realisations": realisations}]
        exact = varied(seed, waves=waves, hydro={"model": "body_exact"}, published=None)
        (found,) = (check for check in seas_checks(exact) if check.name == "record_length")
        assert (found.verdict, found.value) == (verdict, pytest.approx(FEWEST_BATCHES / (2 * realisations)))
        (found,) = (check for check in seas_checks(varied(seed, waves=waves)) if check.name == "record_length")
        assert (found.verdict, found.value) == ("ok", 0.0)
        assert "mean power follows from the spectrum" in found.explanation
        names = set(families(exact))
        (found,) = (check for check in seas_checks(exact, linear=names) if check.name == "record_length")
        assert found.verdict == "ok"  # the runs turned out to be linear


def test_records_last_as_long_as_an_interval_of_mean_power_needs_unless_they_are_given(seed):
    """Six memories of ten peak periods after one of start-up, of all realisations together; of a spectrum as before."""
    waves = [{"kind": "jonswap", "hs": 0.5, "tp": 6.0, "realisations": 2}]
    base = {**seed.model_dump(exclude_unset=True), "waves": waves, "published": None}
    base.pop("simulation")
    exact = {**base, "hydro": {"model": "body_exact"}}
    assert parse(exact).simulation.window == pytest.approx((60.0, 240.0))
    assert parse(
        {**base, "pto": {"damping": 8e3, "force_limit": 1e4, "law": "saturated"}}
    ).simulation.duration == pytest.approx(240.0)
    assert parse(base).simulation.window == (40.0, 60.0)
    given = {"duration": 70.0, "window": [50.0, 70.0]}
    assert parse({**exact, "simulation": given}).simulation.window == (50.0, 70.0)
    again = parse(exact)
    assert parse(again.model_dump()) == again


def test_sharp_gain_of_a_scattered_power_is_ok(seed):
    """In the same waves: power to 60 %, gain to 0.2 %."""
    rigid = Line("FSB", "sea", "random", 1, 20, 100.0, 40.0, 160.0, 100.0, 100.0, None, None, None)
    soft = Line("VSWEC", "sea", "random", 1, 20, 120.0, 50.0, 190.0, 120.0, 120.0, 20.0, 19.76, 20.24)
    checks = {
        (check.design, check.wave): check
        for check in statistical_checks(seed, [rigid, soft, rigid._replace(sea="other")])
        if check.name == "statistical_error"
    }
    assert checks["VSWEC", "sea"].value == checks["FSB", "sea"].value == pytest.approx(0.002)
    assert (checks["FSB", "other"].value, checks["FSB", "other"].verdict) == (pytest.approx(0.6), "fail")
