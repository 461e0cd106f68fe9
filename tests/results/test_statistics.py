"""Mean power in irregular seas: intervals that hold what they promise, the spectral prediction, realisations."""

import csv
import io

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st

from vsb.motion.port import Port
from vsb.results import statistics as seastatistics
from vsb.results.statistics import Line, Sample, batch_means, gain_percent, interval, ratio_interval, sample, statistics
from vsb.scenes.build import TUNED
from vsb.scenes.drag import LINEARISED
from vsb.study import study as config
from vsb.waves.seas import Sea, sea

DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}}


def run_of(power, time):
    """A run of which only the absorbed energy matters."""
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    return xr.Dataset({"energy": (("time", "term"), energy[:, None])}, coords={"time": time, "term": ["pto"]})


def resonator(omega, natural=1.6, ratio=0.05):
    """Velocity per unit wave amplitude of a lightly damped resonator."""
    return -1j * omega / (natural**2 - omega**2 - 2j * ratio * natural * omega)


def resonant_power(waves, time):
    """Power v^2 taken off the resonator by a sea, and what linear theory expects."""
    velocity = resonator(waves.omega) * waves.amplitude
    return np.real(np.exp(-1j * np.outer(time, waves.omega)) @ velocity) ** 2, float(
        0.5 * np.sum(np.abs(velocity) ** 2)
    )


def test_interval_of_normal_samples_is_student_s():
    # mean 2, standard deviation 1, nine samples: t(0.975, 8) = 2.306 (any table)
    samples = 2 + np.array([-1.5, -1, -0.5, -0.5, 0, 0.5, 0.5, 1, 1.5])
    samples = 2 + (samples - 2) / np.std(samples, ddof=1)
    assert interval(samples) == pytest.approx((2.0, 2 - 2.306 / 3, 2 + 2.306 / 3), rel=1e-3)


def test_interval_covers_the_mean_as_often_as_it_says():
    drawn = np.random.default_rng(1).normal(5.0, 2.0, (4000, 8))
    found = [interval(samples) for samples in drawn]
    assert np.mean([low < 5.0 < high for _, low, high in found]) == pytest.approx(0.95, abs=0.015)


@pytest.mark.parametrize("kind", [{"kind": "jonswap", "tp": 4.0}, {"kind": "white_noise", "band": (1.0, 2.5)}])
def test_intervals_of_one_record_cover_the_expected_power(kind, coarse):
    """A resonator of 5 % damping, 400 s records: about 95 in 100 intervals hold the spectral prediction."""
    time, hits = np.linspace(0.0, 400.0, 2001), []
    seas = [sea(varied(coarse, waves=[{**kind, "hs": 1.0, "seed": seed}]).waves[0], 4.0, 800.0) for seed in range(150)]
    rotation, transfer = np.exp(-1j * np.outer(time, seas[0].omega)), resonator(seas[0].omega)
    for waves in seas:
        power = np.real(rotation @ (transfer * waves.amplitude)) ** 2
        _, low, high = interval(batch_means(run_of(power, time), (40.0, 400.0), 40.0))
        hits.append(low < 0.5 * np.sum(np.abs(transfer * waves.amplitude) ** 2) < high)
    assert 0.88 <= np.mean(hits) <= 0.99


def test_gains_are_sharper_than_powers_because_designs_meet_the_same_waves():
    rng = np.random.default_rng(2)
    base = rng.gamma(4.0, 100.0, 20)
    better = 1.1 * base * (1 + 0.01 * rng.normal(size=20))
    gain, low, high = gain_percent(better, base)
    power = interval(better)
    assert low < 10.0 < high
    assert high - low < 0.1 * 100 * (power.high - power.low) / power.mean
    assert gain == pytest.approx(100 * (better.mean() / base.mean() - 1), rel=1e-12)


def test_the_interval_of_a_gain_covers_it_as_often_as_it_says():
    """Ratios of paired samples, partly alike: 95 in 100 intervals, neither wider nor narrower."""
    rng = np.random.default_rng(3)
    common, own = rng.normal(10.0, 1.0, (2000, 24)), rng.normal(0.0, 1.0, (2, 2000, 24))
    found = [ratio_interval(1.2 * (c + a), c + b) for c, a, b in zip(common, *own, strict=True)]
    assert np.mean([low < 1.2 < high for _, low, high in found]) == pytest.approx(0.95, abs=0.015)
    widths = [high - low for _, low, high in found]
    assert np.mean(widths) == pytest.approx(2 * 2.069 * 1.2 * np.sqrt(2) / 10 / np.sqrt(24), rel=0.02)


@given(st.lists(st.floats(1.0, 1e6), min_size=6, max_size=30), st.floats(0.1, 10.0))
def test_a_design_k_times_as_good_gains_exactly_that(values, factor):
    base = np.array(values)
    ratio, low, high = ratio_interval(factor * base, base)
    assert ratio == pytest.approx(factor, rel=1e-12)
    assert high - low == pytest.approx(0.0, abs=1e-8 * factor * base.max() / base.mean())


def test_too_few_batches_have_no_interval_and_nothing_over_nothing_no_gain():
    assert interval(np.ones(seastatistics.FEWEST_BATCHES - 1)) == (1.0, None, None)
    assert interval(np.arange(float(seastatistics.FEWEST_BATCHES))).low is not None
    assert gain_percent(np.ones(8), None) == gain_percent(np.ones(8), np.zeros(8)) == (None, None, None)


def test_batches_fill_the_window_and_average_to_its_mean():
    time = np.linspace(0.0, 100.0, 2001)
    power = 3 + np.sin(0.7 * time) ** 2
    means = batch_means(run_of(power, time), (10.0, 95.0), 20.0)
    assert len(means) == 4
    inside = (time >= 10) & (time <= 95)
    assert means.mean() == pytest.approx(np.trapezoid(power[inside], time[inside]) / 85.0, rel=1e-4)
    assert len(batch_means(run_of(power, time), (10.0, 12.0), 20.0)) == 1
    for short, count in ((0.0, 4), (1e-9, 4), (1e-7, 3)):  # a batch less by round-off is one
        assert len(batch_means(run_of(power, time), (10.0, 90.0 - short), 20.0)) == count


@pytest.fixture
def many(coarse):
    """A study of three realisations, samples of made-up runs in which VSWEC takes 1.2 times what FSB takes, the seas."""
    study = varied(
        coarse,
        designs=DESIGNS,
        waves=[{"kind": "still"}, {"kind": "pierson_moskowitz", "hs": 1.0, "tp": 4.0, "seed": 5, "realisations": 3}],
        simulation={"duration": 400.0, "window": [40.0, 400.0]},
    )
    time, runs = np.linspace(0.0, 400.0, 4001), {}
    seas = {w.label: sea(w, study.hydro.omega_max, 400.0) for w in study.waves}
    omega = np.linspace(0.1, 12.0, 400)
    transfer = omega**2 / np.abs(1.6**2 - omega**2 - 0.16j * omega) ** 2 / 2
    for wave in study.waves[1:]:
        power, _ = resonant_power(seas[wave.label], time)
        runs |= {("FSB", wave.label): run_of(power, time), ("VSWEC", wave.label): run_of(1.2 * power, time)}
    response = xr.Dataset(
        {"absorbed_power": (("design", "omega"), [transfer, 1.2 * transfer])},
        coords={"design": ["FSB", "VSWEC"], "omega": omega},
    )
    waves = {wave.label: wave for wave in study.waves}
    samples = {(d, w): sample(study, waves[w], d, run, seas[w], response) for (d, w), run in runs.items()}
    return study, samples, seas


def test_realisations_are_pooled_and_the_spectral_prediction_agrees(many):
    fixed, flexible = statistics(*many[:2])
    assert (fixed.realisations, fixed.batches) == (3, 27)
    assert fixed.power_low < fixed.power_linear < fixed.power_high
    assert fixed.power_linear == pytest.approx(
        resonant_power(next(reversed(many[2].values())), np.zeros(1))[1], rel=1e-4
    )
    assert (flexible.gain_percent, flexible.gain_low, flexible.gain_high) == pytest.approx((20.0,) * 3, abs=1e-6)
    assert fixed.gain_percent is None


def test_the_ledger_says_how_sharp_the_statistics_are(many):
    study, lines = many[0], statistics(*many[:2])
    checks = {(c.name, c.design): c for c in seastatistics.statistical_checks(study, lines)}
    assert checks["spectral_prediction", "FSB"].verdict == "ok"
    assert checks["statistical_error", "FSB"].value < 0.3
    wrong = [line._replace(power_linear=2 * line.power_mean) for line in lines]
    assert {c.verdict for c in seastatistics.statistical_checks(study, wrong) if c.name == "spectral_prediction"} <= {
        "doubt",
        "fail",
    }
    exact = varied(study, hydro={"model": "body_exact"})
    assert {c.name for c in seastatistics.statistical_checks(exact, wrong)} == {"statistical_error"}
    short = [line._replace(power_low=None, power_high=None, batches=3) for line in lines]
    found = seastatistics.statistical_checks(study, short)
    assert {(c.name, c.verdict) for c in found} == {("record_length", "doubt")}
    assert "more realisations" in found[0].explanation


def test_the_statistical_error_is_half_the_interval_of_what_is_asked_over_it():
    """Of gains in the same waves where one is known, the widest of the sea; else of power."""
    alone = Line("FSB", "sea", 1, 9, 100.0, 80.0, 120.0, 100.0, None, None, None)
    gaining = Line("VSWEC", "sea", 1, 9, 125.0, 90.0, 160.0, 125.0, 25.0, 15.0, 35.0)
    better = gaining._replace(design="VSWEC0", gain_low=0.0, gain_high=50.0)
    assert seastatistics._sharpness(alone, [alone])[0] == pytest.approx(0.2)
    share, text = seastatistics._sharpness(gaining, [alone, gaining, better])
    assert share == pytest.approx(10.0 / 125.0)
    assert text.endswith("that of mean power is 28 %")
    assert seastatistics._sharpness(alone, [alone, gaining, better])[0] == pytest.approx(25.0 / 125.0)
    assert seastatistics._sharpness(alone._replace(power_mean=0.0), [alone])[0] == 0.0
    given = alone._replace(power_mean=-100.0, power_low=-120.0, power_high=-80.0)  # as by a spring in a short record
    assert seastatistics._sharpness(given, [given])[0] == pytest.approx(0.2)
    against = gaining._replace(gain_percent=-225.0, gain_low=-250.0, gain_high=-200.0)
    assert seastatistics._sharpness(against, [alone, against])[0] == pytest.approx(25.0 / 125.0)


def test_csv_has_a_cell_for_everything_and_nothing_for_what_does_not_exist():
    line = Line("FSB", "sea", 1, 3, 1.0, None, None, 1.1, None, None, None)
    (row,) = csv.DictReader(io.StringIO(seastatistics.as_csv([line])))
    assert tuple(row) == Line._fields
    assert (row["power_mean"], row["power_low"], row["gain_percent"]) == ("1", "", "")
    assert seastatistics.as_csv([]).splitlines() == [",".join(Line._fields)]


def test_realisations_become_seas_with_seeds_in_a_row(coarse):
    wave = {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "seed": 3, "realisations": 2}
    study = varied(coarse, waves=[wave])
    assert [w.label for w in study.waves] == ["jonswap_Hs1_Tp4_g3.3_s3", "jonswap_Hs1_Tp4_g3.3_s4"]
    assert config.parse(study.model_dump()) == study
    assert list(seastatistics.families(study)) == ["jonswap_Hs1_Tp4_g3.3"]


def test_white_noise_is_flat_carries_its_energy_and_stays_in_its_band(coarse):
    (wave,) = varied(coarse, waves=[{"kind": "white_noise", "hs": 2.0, "band": [1.0, 2.0]}]).waves
    waves = sea(wave, 12.0, 300.0)
    assert isinstance(waves, Sea)
    assert np.ptp(np.abs(waves.amplitude)) < 1e-12
    assert (waves.omega.min() > 1.0, waves.omega.max() < 2.0) == (True, True)
    assert 16 * 0.5 * np.sum(np.abs(waves.amplitude) ** 2) == pytest.approx(4.0, rel=1e-12)


def test_pierson_moskowitz_is_jonswap_without_peak(coarse):
    (first, second) = varied(
        coarse,
        waves=[
            {"kind": "pierson_moskowitz", "hs": 1.0, "tp": 4.0},
            {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "gamma": 1.0},
        ],
    ).waves
    assert sea(first, 12.0, 100.0).amplitude == pytest.approx(sea(second, 12.0, 100.0).amplitude, rel=1e-12)


def test_narrow_bands_have_long_batches(coarse):
    """The envelope of a band forgets in 2 pi over its width, however short its waves."""
    wide, narrow = (
        varied(coarse, waves=[{"kind": "white_noise", "hs": 1.0, "band": band}]).waves[0]
        for band in ([1.0, 3.0], [1.99, 2.02])
    )
    assert wide.memory == pytest.approx(10 * np.pi)
    assert narrow.memory == pytest.approx(4 * np.pi / 0.03)


@pytest.mark.parametrize("tp", [4.0, 8.0, 20.0])
def test_a_short_record_has_the_energy_of_the_sea(coarse, tp):
    """Two periods long: the spectrum is averaged over each band, not sampled in its middle."""
    study = varied(
        coarse,
        waves=[{"kind": "pierson_moskowitz", "hs": 1.0, "tp": tp}],
        simulation={"duration": 2 * tp, "window": [0.0, tp]},
    )
    waves = sea(study.waves[0], 40.0, study.simulation.duration)
    assert 8 * np.sum(np.abs(waves.amplitude) ** 2) == pytest.approx(1.0, rel=0.005)


def test_every_batch_counts_once_and_the_prediction_is_the_mean_of_all_realisations(many):
    """Of 2, 3 and 4 batches of 10, 20 and 30 W; of linear theory 100, 400 and 900 W, twice that of the shell."""
    study = many[0]
    samples = {
        (design, wave.label): Sample(np.full(2 + i, 10.0 * (i + 1)), factor * 100.0 * (i + 1) ** 2)
        for design, factor in (("FSB", 1.0), ("VSWEC", 2.0))
        for i, wave in enumerate(study.waves[1:])
    }
    fixed, flexible = statistics(study, samples)
    assert (fixed.realisations, fixed.batches, flexible.batches) == (3, 9, 9)
    assert fixed.power_mean == pytest.approx((2 * 10 + 3 * 20 + 4 * 30) / 9)
    assert (fixed.power_linear, flexible.power_linear) == pytest.approx((1400.0 / 3, 2800.0 / 3))


def test_beside_drag_a_run_says_itself_what_linear_theory_predicts(many):
    study, _, seas = many
    wave, run = study.waves[1], run_of(np.full(4001, 7.0), np.linspace(0.0, 400.0, 4001))
    kept = sample(study, wave, "FSB", run.assign_attrs({LINEARISED: 123.0}), seas[wave.label], xr.Dataset())
    assert kept.linear == 123.0
    assert kept.batches == pytest.approx(np.full(9, 7.0))


def test_seas_of_two_kinds_are_told_apart_and_gains_are_over_the_first_rigid_design_wherever_it_stands(coarse):
    """A sea of two realisations between a regular wave and another sea; the rigid design stands second."""
    seas = [
        {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "realisations": 2}, {"kind": "regular", "amplitude": 0.1, "period": 4.0},
        {"kind": "jonswap", "hs": 2.0, "tp": 6.0},
    ]  # fmt: skip
    study = varied(coarse, designs={"VSWEC": {}, "FSB": {"flexible": False}}, waves=seas)
    short = [wave for wave in study.waves if getattr(wave, "hs", 0.0) == 1.0]
    (long,) = (wave for wave in study.waves if getattr(wave, "hs", 0.0) == 2.0)
    samples = {("FSB", wave.label): Sample(np.arange(10.0, 16.0), 12.0) for wave in short}
    samples |= {("VSWEC", wave.label): Sample(1.5 * np.arange(10.0, 16.0), 18.0) for wave in short}
    samples |= {("FSB", long.label): Sample(np.arange(40.0, 47.0), 50.0)}
    samples |= {("VSWEC", long.label): Sample(0.5 * np.arange(40.0, 47.0), 25.0)}
    found = {(line.design, line.sea): line for line in statistics(study, samples)}
    assert list(found) == [(d, w.family) for w in (short[0], long) for d in ("VSWEC", "FSB")]
    assert [line.realisations for line in found.values()] == [2, 2, 1, 1]
    assert [line.batches for line in found.values()] == [12, 12, 7, 7]
    assert [line.power_linear for line in found.values()] == [18.0, 12.0, 25.0, 50.0]
    for (design, _), line in found.items():
        gain = None if design == "FSB" else pytest.approx(50.0 if line.realisations == 2 else -50.0)
        assert (line.gain_percent, line.gain_low, line.gain_high) == (gain, gain, gain)


def test_what_a_run_is_kept_by_is_of_its_own_direction_and_of_batches_as_long_as_its_sea_remembers(coarse):
    """Two directions of a response; a sea of narrow band, whose batches are longer than ten peak periods."""
    band = {"kind": "white_noise", "hs": 1.0, "band": [1.9, 2.0]}
    study = varied(coarse, waves=[band], simulation={"duration": 500.0, "window": [40.0, 440.0]})
    wave = study.waves[0].model_copy(update={"direction": 90.0})
    omega, time = np.linspace(1.0, 3.0, 40), np.linspace(0.0, 500.0, 5001)
    response = xr.Dataset(
        {"absorbed_power": (("wave_direction", "design", "omega"), np.array([[[1.0]], [[8.0]]]) * np.ones(40))},
        {"wave_direction": [0.0, np.pi / 2], "design": ["A"], "omega": omega},
    )
    waves = Sea(np.array([1.91, 1.95]), np.array([0.3 + 0.4j, 1.0]))
    kept = sample(study, wave, "A", run_of(np.full(5001, 7.0), time), waves, response)
    assert kept.linear == pytest.approx(8.0 * 1.25)
    assert wave.memory == pytest.approx(40 * np.pi)
    assert kept.batches == pytest.approx(np.full(3, 7.0))  # 400 s over 126 s


def test_what_the_ledger_says_of_statistics_is_in_the_numbers_of_its_line(seed):
    """Below the prediction as above it; an interval of no width is no measure; batches, not realisations, are few."""
    line = Line("FSB", "sea", 2, 9, 100.0, 80.0, 130.0, 150.0, None, None, None)
    for sign in (1, -1):
        error, apart = seastatistics.statistical_checks(seed, [line._replace(power_linear=100.0 + 50.0 * sign)])
        assert (apart.value, apart.verdict) == (pytest.approx(2.0), "doubt")
        assert apart.explanation.startswith(f"distance from the spectral prediction, {100 + 50 * sign} W, in halves")
        assert (error.value, error.design, error.wave) == (pytest.approx(0.25), "FSB", "sea")
        assert error.explanation == "half the 95 % confidence interval of mean power, 100 W, over it"
    (exact,) = seastatistics.statistical_checks(seed, [line._replace(power_low=100.0, power_high=100.0)])
    assert (exact.name, exact.value) == ("statistical_error", 0.0)
    (short,) = seastatistics.statistical_checks(seed, [line._replace(power_low=None, power_high=None, batches=4)])
    assert (short.value, short.design, short.wave) == (1.5, "FSB", "sea")
    assert short.explanation == (
        "4 batches, of ten peak periods or more, give no confidence interval: lengthen simulation.duration and window, "
        "or ask for more realisations"
    )


def test_an_error_is_told_of_the_gains_in_the_same_sea_and_of_no_other(seed):
    """The widest of them for a design that has none itself, in whatever order they stand."""
    rigid = Line("FSB", "sea", 1, 9, 100.0, 80.0, 120.0, 100.0, None, None, None)
    shell = Line("VSWEC", "sea", 1, 9, 80.0, 60.0, 100.0, 80.0, -20.0, -36.0, -4.0)
    other = shell._replace(design="VSWEC0", gain_low=-24.0, gain_high=-16.0)
    rough = [line._replace(sea="rough", gain_low=line.gain_low and -70.0) for line in (rigid, shell)]
    for lines in ([rigid, shell, other, *rough], [*rough, rigid, other, shell]):
        found = seastatistics.statistical_checks(seed, lines)
        errors = {(c.design, c.wave): c.value for c in found if c.name == "statistical_error"}
        assert errors == {
            ("FSB", "sea"): pytest.approx(0.2), ("VSWEC", "sea"): pytest.approx(0.2), ("VSWEC0", "sea"): pytest.approx(0.05),
            ("FSB", "rough"): pytest.approx(33.0 / 80.0), ("VSWEC", "rough"): pytest.approx(33.0 / 80.0),
        }  # fmt: skip


def test_a_design_of_which_too_little_is_known_is_no_reason_to_leave_out_others(seed):
    short = Line("FSB", "sea", 1, 3, 100.0, None, None, 100.0, None, None, None)
    long = Line("VSWEC", "sea", 1, 9, 100.0, 90.0, 110.0, 100.0, None, None, None)
    found = seastatistics.statistical_checks(seed, [short, long])
    assert [(check.name, check.design) for check in found] == [
        ("record_length", "FSB"), ("statistical_error", "VSWEC"), ("spectral_prediction", "VSWEC"),
    ]  # fmt: skip


def test_a_design_that_takes_nothing_for_sure_has_no_error_of_its_gain(seed):
    """At a damper of nothing: 100 % less than the rigid design, and nothing to part the interval by."""
    rigid = Line("FSB", "sea", 1, 9, 100.0, 80.0, 120.0, 100.0, None, None, None)
    batches = np.arange(6.0, 15.0)
    nothing = Line("VSWEC", "sea", 1, 9, *interval(0 * batches), 0.0, *gain_percent(0 * batches, batches))
    assert (nothing.gain_percent, nothing.gain_low, nothing.gain_high) == (-100.0, -100.0, -100.0)
    found = seastatistics.statistical_checks(seed, [rigid, nothing])
    assert [(check.name, check.design) for check in found] == [
        ("statistical_error", "FSB"), ("spectral_prediction", "FSB"), ("statistical_error", "VSWEC"),
    ]  # fmt: skip
    assert [check.value for check in found] == pytest.approx([0.2, 0.0, 0.0])
    assert found[0].explanation == found[2].explanation.replace("power, 0 W", "power, 100 W")


@pytest.mark.parametrize("spring", [900.0, -900.0, 0.0])
def test_a_run_that_was_tuned_is_predicted_beside_its_own_damper_and_the_spring(coarse, spring):
    """And one with the damper given by the response as it is."""
    sea_of, run = {"kind": "jonswap", "hs": 1.0, "tp": 4.0}, {"duration": 400.0, "window": [40.0, 400.0]}
    study = varied(coarse, waves=[sea_of], simulation=run, pto={"damping": 8e3, "stiffness": spring})
    omega, time = np.linspace(0.5, 4.0, 36), np.linspace(0.0, 400.0, 4001)
    port = Port(omega, 1 / (2e3 + 300.0 * omega - 1j * (17e3 * omega - 4e4 / omega)), 1.0 + 0.5j * omega, 1e-4)
    values = {"port_impedance": port.impedance, "port_velocity": port.velocity, "absorbed_power": 3.0 + 0j * omega}
    values = {name: (("design", "omega"), value[None]) for name, value in values.items()}
    response = xr.Dataset(values, {"design": ["A"], "omega": omega})
    response["absorbed_power"] = response.absorbed_power.real
    waves, known = Sea(omega[[9, 20]], np.array([0.3 + 0.4j, -1.0])), run_of(np.full(4001, 7.0), time)
    tuned = sample(study, study.waves[0], "A", known.assign_attrs({TUNED: 4e3}), waves, response)
    assert tuned.linear == pytest.approx(float(port.power(4e3, spring)[[9, 20]] @ [0.25, 1.0]), rel=1e-9)
    assert sample(study, study.waves[0], "A", known, waves, response).linear == pytest.approx(3.0 * 1.25, rel=1e-9)
