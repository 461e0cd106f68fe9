"""Mean power in irregular seas: intervals that cover what they are of, linear theory in the same waves, realisations."""

import csv
import io

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.motion.port import Port
from vsb.results import statistics as seastatistics
from vsb.results.statistics import (
    Line,
    Sample,
    batch_means,
    half_width,
    linear_batches,
    record_covariance,
    sample,
    statistics,
)
from vsb.scenes.build import TUNED
from vsb.scenes.drag import LINEARISED
from vsb.study import study as config
from vsb.waves.seas import Sea, expected, sea
from vsb.waves.superposition import superposed

DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}}
LINE = Line("FSB", "sea", "random", 1, 9, 100.0, 80.0, 120.0, 100.0, 100.0, None, None, None)


def run_of(power, time):
    """A run of which only the absorbed energy matters."""
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    return xr.Dataset({"energy": (("time", "term"), energy[:, None])}, coords={"time": time, "term": ["pto"]})


def resonator(omega, natural=1.6, ratio=0.05):
    """Velocity per unit wave amplitude of a lightly damped resonator."""
    return -1j * omega / (natural**2 - omega**2 - 2j * ratio * natural * omega)


MADE = {"FSB": (1.6, 0.05, 1.0), "VSWEC": (1.8, 0.08, 1.3)}
"""Natural frequency [rad/s], damping ratio, damper of resonators that stand for designs."""
LAWS = {
    "linear": lambda c, v: c * v**2,
    "coulomb": lambda c, v: 0.3 * c * np.abs(v),
    "limited": lambda c, v: c * v**2 / (1 + 0.3 * v**2),
}
"""Power of a velocity [W]: of linear theory, and of take-offs that it describes badly."""


def made(study, wave, law):
    """Samples of runs of `MADE` in a realisation, without integrating anything."""
    window, duration = study.simulation.window, study.simulation.duration
    waves, spectral = sea(wave, 4.0, duration), sea(expected(wave), 4.0, duration)
    count = int((window[1] - window[0]) / wave.memory + 1e-9)
    steps = int(np.ceil(seastatistics.INSTANTS * waves.omega.max() * (window[1] - window[0]) / count / (2 * np.pi)))
    found = {}
    for name, (natural, ratio, damper) in MADE.items():
        transfer = resonator(waves.omega, natural, ratio)
        speed = superposed(waves.omega, (transfer * waves.amplitude)[:, None], np.linspace(*window, count * steps + 1))
        batches = LAWS[law](damper, speed[:-1, 0]).reshape(count, steps).mean(axis=1)
        alike = linear_batches(waves.omega, transfer * waves.amplitude, damper, window, count)
        parts = np.sqrt(damper / 2) * transfer * np.abs(spectral.amplitude)
        linear = float(np.sum(np.abs(parts) ** 2))
        found[name, wave.label] = Sample(batches, alike, linear, parts, float(np.diff(waves.omega).mean()))
    return found


def made_study(coarse, amplitudes="random", seed=1, realisations=1, duration=460.0, **wave):
    """A study of a sea, 400 s long at Tp 4 s unless said otherwise."""
    kind = {"kind": "jonswap", "hs": 1.0, "tp": 4.0} | wave
    waves = [{**kind, "amplitudes": amplitudes, "seed": seed, "realisations": realisations}]
    return varied(coarse, designs=DESIGNS, waves=waves, simulation={"duration": duration, "window": [60.0, duration]})


def lines_of(coarse, law, **given):
    """The lines of made-up runs in realisations of a sea."""
    study = made_study(coarse, **given)
    return statistics(study, {key: one for wave in study.waves for key, one in made(study, wave, law).items()})


@pytest.mark.parametrize("law", sorted(LAWS))
def test_intervals_cover_the_expected_power_and_gain_of_a_sea_in_93_to_97_of_a_hundred_cases(coarse, law):
    """A thousand records of 400 s of a Gaussian sea; binomial scatter of a thousand is 0.7 in a hundred."""
    study = made_study(coarse)
    cases = [
        statistics(one, made(one, one.waves[0], law))
        for one in (study.model_copy(update={"waves": (wave,)}) for wave in seeds(study.waves[0], 1000))
    ]
    power = np.array([[line.power_mean for line in lines] for lines in cases]).mean(axis=0)
    if law == "linear":
        predicted = [line.power_linear for line in cases[0]]
        assert power == pytest.approx(predicted, rel=0.03)  # four deviations of a thousand means
        power = predicted
    gain = 100 * (power[1] / power[0] - 1)
    covered = [np.mean([lines[i].power_low < power[i] < lines[i].power_high for lines in cases]) for i in (0, 1)]
    covered.append(np.mean([lines[1].gain_low < gain < lines[1].gain_high for lines in cases]))
    assert min(covered) >= 0.93, covered
    assert max(covered) <= 0.97, covered


def seeds(wave, count):
    """As many realisations of a sea."""
    return [wave.model_copy(update={"seed": 1 + i}) for i in range(count)]


def test_several_realisations_sharpen_the_interval_by_their_root(coarse):
    """Of linear theory exactly: the variance of a record is known."""
    (one, _), (four, _) = (lines_of(coarse, "linear", realisations=n) for n in (1, 4))
    assert (four.realisations, four.batches) == (4, 40)
    assert four.power_high - four.power_mean == pytest.approx((one.power_high - one.power_mean) / 2, rel=0.05)


def test_the_variance_of_records_is_that_of_many_of_them(coarse):
    """Two designs in 1000 records; their covariance in closed form."""
    study = made_study(coarse)
    records = [made(study, wave, "linear") for wave in seeds(study.waves[0], 1000)]
    means = np.array([[one.batches.mean() for one in record.values()] for record in records])
    parts = [one.components for one in records[0].values()]
    spacing = next(iter(records[0].values())).spacing
    known = [[record_covariance(a, b, spacing, 400.0) for a in parts] for b in parts]
    scatter = np.cov(means.T)
    np.testing.assert_allclose(known, scatter, rtol=0.15)
    assert known[0][1] / np.sqrt(known[0][0] * known[1][1]) > 0.3  # the same waves


def test_the_variance_of_the_mean_is_the_sum_over_pairs_of_components():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 7, 2)) @ [1, 1j]
    at = 0.03 * np.arange(7)
    product, apart = a.conj() * b, np.sinc((at[:, None] - at) * 50.0 / (2 * np.pi)) ** 2
    assert record_covariance(a, b, 0.03, 50.0) == pytest.approx((product @ apart @ product.conj()).real, rel=1e-12)


def test_of_fixed_amplitudes_the_interval_is_of_the_realisation_and_holds_the_error_of_the_numbers_alone(coarse):
    """Twice the tolerance of both powers; how its mean varies from seed to seed is no part of it."""
    fixed, shell = lines_of(coarse, "linear", amplitudes="fixed")
    tolerance = made_study(coarse).hydro.tolerance
    for end, sign in (("low", -1), ("high", 1)):
        assert getattr(fixed, f"power_{end}") == pytest.approx((1 + sign * tolerance) * fixed.power_mean, rel=1e-12)
        width = 2 * tolerance * (100 + shell.gain_percent)
        assert getattr(shell, f"gain_{end}") == pytest.approx(shell.gain_percent + sign * width, rel=1e-9)
    means = [lines_of(coarse, "linear", amplitudes="fixed", seed=seed)[0].power_mean for seed in range(1, 41)]
    assert fixed.power_linear_record == pytest.approx(fixed.power_mean, rel=1e-3)
    assert fixed.power_linear == pytest.approx(np.mean(means), rel=0.05)


def test_gains_are_sharper_than_powers_because_designs_meet_the_same_waves(coarse):
    """Of designs that hardly differ the gain is nearly certain whatever the record."""
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


def test_what_linear_theory_does_not_explain_is_student_s():
    """Nine samples of deviation 1, nothing alike: t(0.975, 7) = 2.365 (any table), one of 8 degrees spent on the slope."""
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


def test_too_few_batches_have_no_interval_and_nothing_over_nothing_no_gain(coarse):
    short, shell = lines_of(coarse, "linear", duration=60.0 + 5 * 40.0)
    assert (short.batches, short.power_low, short.power_high, shell.gain_low) == (5, None, None, None)
    assert shell.gain_percent is not None
    assert lines_of(coarse, "linear", duration=60.0 + 6 * 40.0)[0].power_low is not None
    study = made_study(coarse)
    still = {key: one._replace(batches=0 * one.batches) for key, one in made(study, study.waves[0], "linear").items()}
    assert [line.gain_percent for line in statistics(study, still)] == [None, None]


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


def test_linear_power_of_batches_is_that_of_the_wave():
    """Of one wave over whole periods half c |V|^2 in every batch."""
    omega = np.array([2 * np.pi / 4.0])
    found = linear_batches(omega, np.array([0.3 + 0.4j]), 8e3, (20.0, 60.0), 5)
    assert found == pytest.approx(np.full(5, 0.5 * 8e3 * 0.25), rel=1e-9)


def test_the_ledger_says_how_sharp_the_statistics_are(seed):
    """Random amplitudes alone have a sampling error; linear theory in the same waves is met by every linear run."""
    error, apart = seastatistics.statistical_checks(seed, [LINE])
    assert (error.name, error.value, error.verdict) == ("statistical_error", pytest.approx(0.2), "doubt")
    assert error.explanation == "half the 95 % confidence interval of mean power, 100 W, over it"
    assert (apart.name, apart.value, apart.verdict) == ("spectral_prediction", 0.0, "ok")
    for sign in (1, -1):
        (_, apart) = seastatistics.statistical_checks(seed, [LINE._replace(power_mean=100.0 * (1 + 0.01 * sign))])
        assert (apart.value, apart.verdict) == (pytest.approx(0.01), "doubt")
        assert apart.explanation == "relative difference of mean power from linear theory in the same waves, 100 W"
    fixed = LINE._replace(amplitudes="fixed", power_low=99.9, power_high=100.1)
    assert [check.name for check in seastatistics.statistical_checks(seed, [fixed])] == ["spectral_prediction"]
    exact, coulomb = (
        varied(seed, hydro={"model": "body_exact"}),
        varied(seed, pto={"law": "coulomb", "force_limit": 3e3}),
    )
    for study in (exact, coulomb):
        assert [check.name for check in seastatistics.statistical_checks(study, [LINE])] == ["statistical_error"]
    short = LINE._replace(power_low=None, power_high=None, batches=4)
    few = seastatistics.statistical_checks(seed, [short, LINE._replace(design="VSWEC")])
    assert [(check.name, check.design) for check in few] == [
        ("record_length", "FSB"), ("spectral_prediction", "FSB"),
        ("statistical_error", "VSWEC"), ("spectral_prediction", "VSWEC"),
    ]  # fmt: skip
    assert (few[0].value, few[0].verdict) == (1.5, "doubt")
    assert few[0].explanation == (
        "4 batches of ten peak periods or more are too few for a confidence interval: lengthen simulation.duration and "
        "window, or ask for more realisations"
    )


def test_beside_drag_linear_theory_is_that_of_its_dampers(seed, coarse):
    """Which a run knows; in these waves it varies as linear theory without drag does. A twentieth is the limit."""
    study = made_study(coarse)
    samples = made(study, study.waves[0], "linear")
    braked = {key: one._replace(linear=0.7 * one.linear) for key, one in samples.items()}
    own, other = statistics(study, samples)[0], statistics(study, braked)[0]
    assert own.power_linear_record == pytest.approx(own.power_mean, rel=1e-3)
    assert other.power_linear_record == pytest.approx(0.7 * own.power_linear_record, rel=1e-12)
    dragged = varied(seed, drag={"heave": {"coefficient": 0.5, "area": 3.0}})
    check = seastatistics.statistical_checks(dragged, [LINE._replace(power_mean=104.0)])[1]
    assert (check.name, check.verdict) == ("spectral_prediction", "ok")


def test_the_statistical_error_is_half_the_interval_of_what_is_asked_over_it():
    """Of gains in the same waves where one is known, the widest of the sea; else of power."""
    gaining = LINE._replace(design="VSWEC", power_mean=125.0, power_low=90.0, power_high=160.0)
    gaining = gaining._replace(gain_percent=25.0, gain_low=15.0, gain_high=35.0)
    better = gaining._replace(design="VSWEC0", gain_low=0.0, gain_high=50.0)
    assert seastatistics._sharpness(LINE, [LINE])[0] == pytest.approx(0.2)
    share, text = seastatistics._sharpness(gaining, [LINE, gaining, better])
    assert share == pytest.approx(10.0 / 125.0)
    assert text.endswith("that of mean power is 28 %")
    assert seastatistics._sharpness(LINE, [LINE, gaining, better])[0] == pytest.approx(25.0 / 125.0)
    assert seastatistics._sharpness(LINE._replace(power_mean=0.0), [LINE])[0] == 0.0
    given = LINE._replace(power_mean=-100.0, power_low=-120.0, power_high=-80.0)  # as by a spring in a short record
    assert seastatistics._sharpness(given, [given])[0] == pytest.approx(0.2)


def test_an_error_is_told_of_the_gains_in_the_same_sea_and_of_no_other(seed):
    """The widest of them for a design that has none itself, in whatever order they stand."""
    shell = LINE._replace(design="VSWEC", power_mean=80.0, gain_percent=-20.0, gain_low=-36.0, gain_high=-4.0)
    other = shell._replace(design="VSWEC0", gain_low=-24.0, gain_high=-16.0)
    rough = [line._replace(sea="rough", gain_low=line.gain_low and -70.0) for line in (LINE, shell)]
    for lines in ([LINE, shell, other, *rough], [*rough, LINE, other, shell]):
        found = seastatistics.statistical_checks(seed, lines)
        errors = {(c.design, c.wave): c.value for c in found if c.name == "statistical_error"}
        assert errors == {
            ("FSB", "sea"): pytest.approx(0.2), ("VSWEC", "sea"): pytest.approx(0.2), ("VSWEC0", "sea"): pytest.approx(0.05),
            ("FSB", "rough"): pytest.approx(33.0 / 80.0), ("VSWEC", "rough"): pytest.approx(33.0 / 80.0),
        }  # fmt: skip


def test_csv_has_a_cell_for_everything_and_nothing_for_what_does_not_exist():
    line = LINE._replace(power_low=None, power_high=None)
    (row,) = csv.DictReader(io.StringIO(seastatistics.as_csv([line])))
    assert tuple(row) == Line._fields
    assert (row["power_mean"], row["power_low"], row["gain_percent"]) == ("100", "", "")
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


def test_random_amplitudes_are_those_of_a_gaussian_sea(coarse):
    """|a|^2 exponential about the spectrum, independent of the phases, which are those of fixed amplitudes."""
    wave = made_study(coarse).waves[0]
    fixed, drawn = sea(expected(wave), 12.0, 4000.0), sea(wave, 12.0, 4000.0)
    ratio = drawn.amplitude / fixed.amplitude
    assert np.abs(ratio.imag).max() < 1e-12
    squares, count = ratio.real**2, len(ratio)
    assert squares.mean() == pytest.approx(1.0, abs=4 / np.sqrt(count))
    assert np.mean(squares > 2) == pytest.approx(np.exp(-2), abs=4 * np.sqrt(np.exp(-2) / count))
    assert wave.label == "jonswap_Hs1_Tp4_g3.3_random_s1"
    assert expected(wave).label == "jonswap_Hs1_Tp4_g3.3_s1"


def test_every_batch_counts_once_and_the_prediction_is_the_mean_of_all_realisations(coarse):
    """Of 2, 3 and 4 batches of 10, 20 and 30 W; of linear theory 100, 400 and 900 W, twice that of the shell."""
    study = made_study(coarse, realisations=3)
    samples = {
        (design, wave.label): Sample(
            np.full(2 + i, 10.0 * (i + 1)), np.full(2 + i, 9.0), factor * 100.0 * (i + 1) ** 2, np.ones(4, complex), 0.1
        )
        for design, factor in (("FSB", 1.0), ("VSWEC", 2.0))
        for i, wave in enumerate(study.waves)
    }
    fixed, flexible = statistics(study, samples)
    assert (fixed.realisations, fixed.batches, flexible.batches) == (3, 9, 9)
    assert fixed.power_mean == pytest.approx((2 * 10 + 3 * 20 + 4 * 30) / 9)
    assert (fixed.power_linear, flexible.power_linear) == pytest.approx((1400.0 / 3, 2800.0 / 3))
    assert fixed.power_linear_record == pytest.approx(9.0 / 4 * 1400.0 / 3)  # a record of 9 where 4 are expected


def test_seas_are_told_apart_and_gains_are_over_the_first_rigid_design_wherever_it_stands(coarse):
    """A sea of two realisations between a regular wave and another sea; the rigid design stands second."""
    seas = [
        {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "realisations": 2}, {"kind": "regular", "amplitude": 0.1, "period": 4.0},
        {"kind": "jonswap", "hs": 2.0, "tp": 6.0},
    ]  # fmt: skip
    study = varied(coarse, designs={"VSWEC": {}, "FSB": {"flexible": False}}, waves=seas)
    factors = {("FSB", 1.0): 1.0, ("VSWEC", 1.0): 1.5, ("FSB", 2.0): 4.0, ("VSWEC", 2.0): 2.0}
    blank = Sample(np.arange(10.0, 16.0), np.arange(10.0, 16.0), 12.0, np.ones(3, complex), 0.1)
    samples = {
        (design, wave.label): blank._replace(batches=factor * blank.batches, linear=factor * blank.linear)
        for (design, hs), factor in factors.items()
        for wave in study.waves
        if getattr(wave, "hs", None) == hs
    }
    found = statistics(study, samples)
    short, long = study.waves[0].family, study.waves[-1].family
    assert [(line.design, line.sea) for line in found] == [(d, s) for s in (short, long) for d in ("VSWEC", "FSB")]
    assert [line.realisations for line in found] == [2, 2, 1, 1]
    assert [line.batches for line in found] == [12, 12, 6, 6]
    assert [line.power_linear for line in found] == [18.0, 12.0, 24.0, 48.0]
    assert [line.gain_percent for line in found] == [pytest.approx(50.0), None, pytest.approx(-50.0), None]


@pytest.mark.parametrize("spring", [900.0, -900.0, 0.0])
@pytest.mark.parametrize("drag", [False, True])
def test_what_is_kept_of_a_run_is_of_its_own_damper_spring_direction_and_batches(coarse, spring, drag):
    """A tuned run of the second of two directions; by a port known in closed form, over whole periods of the beat."""
    band = {"kind": "white_noise", "hs": 1.0, "band": [1.9, 2.1], "amplitudes": "random"}
    period = 4 * np.pi / 0.2  # of the sea's memory
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
    known = run_of(np.full(5001, 7.0), time).assign_attrs({LINEARISED: 123.0} if drag else {})
    kept = sample(study, wave, "A", known.assign_attrs({TUNED: 4e3}), waves, spectral, response)
    powers = port.power(4e3, spring)[[14, 15]]
    assert wave.memory == pytest.approx(period)
    assert kept.batches == pytest.approx(np.full(4, 7.0))
    assert kept.linear == pytest.approx(123.0 if drag else float(powers @ [0.36, 0.64]), rel=1e-9)
    assert np.abs(kept.components) ** 2 == pytest.approx(powers * [0.36, 0.64], rel=1e-9)
    assert kept.spacing == pytest.approx(0.1)
    speed = port.velocity_under(port.load(4e3, spring))[[14, 15]] * waves.amplitude
    instants = np.linspace(*study.simulation.window, 40001)
    power = 4e3 * np.real(np.exp(-1j * np.outer(instants, omega[[14, 15]])) @ speed) ** 2
    assert kept.linear_batches.mean() == pytest.approx(np.trapezoid(power) / 40000, rel=1e-3)
    untuned = sample(study, wave, "A", known, waves, spectral, response)
    assert untuned.linear == pytest.approx(123.0 if drag else 3.0, rel=1e-9)
