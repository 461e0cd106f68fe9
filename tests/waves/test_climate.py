"""A site's climate: moments, energy flux, what is left out and said."""

import re
from pathlib import Path

import numpy as np
import pytest

from vsb.errors import ConfigError
from vsb.study.study import Water
from vsb.waves.climate import Climate, band_edges, height_and_period, impossible, of_records, realised
from vsb.waves.dispersion import wavenumber

HOME = Path(__file__).parents[2]


def flat(seas=1, hours=None):
    """Seas of one density over 11 bands 0.1 rad/s wide."""
    omega, density = 0.5 + 0.1 * np.arange(11), np.full((seas, 11), 0.25)
    return Climate.of_spectra(omega, density, np.full(seas, 1 / seas) if hours is None else hours, "flat")


def test_moments_are_sums_over_bands():
    climate = flat()
    assert climate.hs == pytest.approx([4 * np.sqrt(0.25 * 1.1)], rel=1e-14)
    assert climate.te == pytest.approx([2 * np.pi * 0.1 * np.sum(1 / climate.omega) / 1.1], rel=1e-14)


def test_energy_flux_in_deep_water():
    """J = rho g^2 Hs^2 Te/(64 pi), the closed form of deep water."""
    climate, water = flat(), Water()
    closed = 1025 * 9.81**2 / (64 * np.pi) * climate.hs**2 * climate.te
    assert climate.flux(water) == pytest.approx(closed, rel=1e-13)


@pytest.mark.parametrize("seed", [0, 7])
def test_a_realisation_has_the_spectrums_amplitudes_and_its_seeds_phases_all_around_the_circle(seed):
    """a = sqrt(2 S d), d a tenth finer than 2 pi over the run; phases are the generator's uniform ones times 2 pi."""
    found = realised(flat(), 0, 600.0, seed)
    count = int(np.ceil(1.1 * 1.1 * 600.0 / (2 * np.pi)))
    assert found.omega == pytest.approx(0.45 + 1.1 * (np.arange(count) + 0.5) / count, rel=1e-12)
    assert np.abs(found.amplitude) == pytest.approx(np.full(count, np.sqrt(2 * 0.25 * 1.1 / count)), rel=1e-9)
    turned = np.exp(2j * np.pi * np.random.default_rng(seed).random(count))
    assert found.amplitude / np.abs(found.amplitude) == pytest.approx(turned, abs=1e-12)


def test_components_without_energy_are_left_out_of_a_realisation_and_weak_ones_are_not():
    """Of three bands the middle one is calm and the last has a millionth of the amplitude of the first."""
    density = np.array([[1.0, 0.0, 1e-12]])
    waves = Climate.of_spectra(np.array([0.5, 0.6, 0.7]), density, np.ones(1), "gap")
    found = realised(waves, 0, 2000.0, 1)
    assert not np.any((found.omega > 0.551) & (found.omega < 0.649))
    assert np.any(found.omega < 0.55)
    weak = found.omega > 0.65
    assert np.sum(weak) == pytest.approx(np.sum(found.omega < 0.55), abs=1)
    assert np.abs(found.amplitude[weak]).max() == pytest.approx(1e-6 * np.abs(found.amplitude).max(), rel=1e-3)


def test_shares_that_do_not_sum_to_one():
    with pytest.raises(ConfigError, match=r"received shares that sum to 0\.9, needs 1"):
        flat(2, np.array([0.5, 0.4]))


def test_heights_that_are_not_those_of_the_spectra():
    climate = flat()
    with pytest.raises(ConfigError, match=r"received Hs 4 m of sea 0, its spectrum holds 2\.098 m"):
        Climate(climate.omega, climate.density, climate.hours, np.array([4.0]), climate.te, "wrong")


@pytest.mark.parametrize("side", [1, -1])
def test_heights_may_be_two_percent_off_those_of_the_spectra(side):
    right = flat()
    fields = right.omega, right.density, right.hours
    assert Climate(*fields, right.hs / (1 + 0.0199 * side), right.te, "rounded").hs == pytest.approx(
        right.hs, rel=0.021
    )
    with pytest.raises(ConfigError, match="needs both within 2%"):
        Climate(*fields, right.hs / (1 + 0.0201 * side), right.te, "wrong")


def test_a_hundredth_of_the_records_may_be_impossible():
    """Waves of half a hertz and 4 m are steeper than any sea."""
    omega = 3.0 + 0.1 * np.arange(5)
    calm, steep = np.linspace(0.001, 0.002, 5), np.linspace(2.0, 1.0, 5)
    assert len(of_records(omega, np.vstack([steep, *[calm] * 99]), "file").hs) == 99
    with pytest.raises(ConfigError, match=r"file: received 1.0% of seas that cannot be, as Hs 3\.\d+ m with Te 1\.9"):
        of_records(omega, np.vstack([steep, *[calm] * 98]), "file")


@pytest.mark.parametrize("last", [2.0, 3.0])
def test_what_lies_beyond_the_bands_is_the_integral_of_their_tail(last):
    """Of a density w^-5 from the lowest edge w1 to the highest w2 on, (w1/w2)^4/(1 - (w1/w2)^4) of what is inside."""
    omega = np.arange(1.0, last, 0.01)
    first, end = omega[0] - 0.005, omega[-1] + 0.005
    (said,) = [
        note
        for note in of_records(omega, np.outer([1.0, 0.5, 2.0], omega**-5.0), "tail").notes
        if "fifth power" in note
    ]
    words = (
        rf"bands from {first / 2 / np.pi:.4g} to {end / 2 / np.pi:.4g} Hz: .* would add (.*)% to the variance, which"
    )
    share = (first / end) ** 4
    assert float(re.match(words, said)[1]) == pytest.approx(100 * share / (1 - share), abs=0.01)


def test_what_no_sea_is():
    """Each limit from both sides, in a sea that is far from the other."""
    just, period = np.array([0.99, 1.01]), 10.0
    steep = 0.1 * 9.81 * period**2 / (2 * np.pi)
    assert impossible(steep * just, np.full(2, period)).tolist() == [False, True]
    assert impossible(40.0 * just, np.full(2, 30.0)).tolist() == [False, True]


def test_records_without_a_spectrum_are_left_out_and_counted():
    omega = 0.5 + 0.1 * np.arange(11)
    density = np.vstack([np.linspace(0.1, 0.2, 11), np.full(11, np.nan), np.zeros(11), np.linspace(0.2, 0.1, 11)])
    density[1, 1:] = 0.1  # one missing band is enough
    climate = of_records(omega, density, "file")
    assert climate.density.shape == (2, 11)
    assert climate.hours.tolist() == [0.5, 0.5]
    assert climate.hs == pytest.approx(height_and_period(omega, density[[0, 3]])[0])
    assert "4 records, 1 with missing values left out" in climate.notes
    assert any(note.startswith("1 records of one value throughout left out") for note in climate.notes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"density": np.ones((2, 10))}, r"received spectra of shape \(2, 10\) over 11 frequencies"),
        ({"density": np.ones((0, 11))}, "needs at least one sea and two frequencies"),
        ({"omega": np.ones(1), "density": np.ones((2, 1))}, "over 1 frequencies; needs at least one sea and two freq"),
        ({"omega": np.linspace(1.5, 0.5, 11)}, "received omega with 0.5, needs ascending, > 0, all finite"),
        ({"omega": np.linspace(0.0, 1.0, 11)}, "received omega with 0, needs ascending, > 0, all finite"),
        ({"density": np.full((2, 11), np.nan)}, "received density with nan, needs no number below 0, all finite"),
        ({"density": np.full((2, 11), -1.0)}, "received density with -1, needs no number below 0"),
        ({"hours": np.array([1.5, -0.5])}, "received hours with -0.5, needs no share below 0"),
        ({"hs": np.zeros(2)}, "received hs with 0, needs heights above 0"),
        ({"te": np.array([8.0, np.inf])}, "received te with inf, needs periods above 0, all finite"),
        ({"te": np.array([8.0])}, "received 2 spectra, needs as many hours, hs and te"),
        ({"hs": np.array([2.0])}, "received 2 spectra, needs as many hours, hs and te"),
        ({"hours": np.ones(1)}, "received 2 spectra, needs as many hours, hs and te"),
    ],
)
def test_what_is_no_climate(changes, message):
    right = flat(2)
    fields = {name: getattr(right, name) for name in ("omega", "density", "hours", "hs", "te", "name")}
    with pytest.raises(ConfigError, match=message):
        Climate(**{**fields, **changes})


def test_a_quantile_is_the_density_of_the_sea_that_much_of_the_year_stays_below():
    omega, factor = 0.5 + 0.1 * np.arange(11), np.array([3.0, 1.0, 2.0])
    climate = Climate.of_spectra(omega, np.outer(factor, np.linspace(0.1, 0.3, 11)), np.array([0.2, 0.5, 0.3]), "three")
    for share, sea in ((0.1, 1), (0.49, 1), (0.51, 2), (0.79, 2), (0.81, 0)):
        assert climate.quantile(share) == pytest.approx(climate.density[sea])


def test_the_mean_of_the_year_and_what_lies_outside_weigh_seas_by_their_hours():
    """A rare high sea at low frequencies beside a usual one at high frequencies: means and shares by hand."""
    omega = np.array([1.0, 2.0, 3.0, 4.0])
    density = np.array([[8.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0]])
    climate = Climate.of_spectra(omega, density, np.array([0.1, 0.9]), "two")
    assert climate.mean_density == pytest.approx([0.8, 0.0, 0.0, 1.8], rel=1e-14)
    assert climate.variance_outside(1.5, 10.0) == pytest.approx(0.8 / 2.6, rel=1e-12)
    assert climate.variance_outside(0.1, 3.5) == pytest.approx(1.8 / 2.6, rel=1e-12)


def rising(factors, hours):
    """Seas of one uneven spectrum between 0.8 and 1.8 rad/s, so many times as dense each."""
    return Climate.of_spectra(
        0.8 + 0.1 * np.arange(11), np.outer(factors, np.linspace(0.1, 0.4, 11)), np.array(hours), "uneven", ("a note",)
    )


def test_the_flux_is_that_of_the_waters_depth_density_and_gravity():
    """rho g sum S v_g d, v_g the slope of the dispersion relation: two seas in shallow, light water of another gravity."""
    climate, water = rising([1.0, 3.0], [0.5, 0.5]), Water(depth=6.0, density=998.0, gravity=9.7)
    k = np.array([wavenumber(w, 6.0, 9.7) for w in climate.omega])
    speed = climate.omega / (2 * k) * (1 + 2 * k * 6.0 / np.sinh(2 * k * 6.0))
    closed = 998.0 * 9.7 * np.sum(climate.density * speed * 0.1, axis=1)
    assert climate.flux(water) == pytest.approx(closed, rel=1e-12)


def test_a_realisation_is_of_the_sea_asked_for_between_the_frequencies_asked_for():
    """The third of three seas, cut off on one side, the other and both: its variance there by hand."""
    climate = rising([1.0, 2.0, 5.0], [0.2, 0.3, 0.5])
    for lowest, highest in ((0.0, np.inf), (1.15, np.inf), (0.0, 1.45), (1.15, 1.45)):
        found = realised(climate, 2, 500.0, 4, lowest, highest)
        low, high = max(lowest, 0.75), min(highest, 1.85)
        half = (high - low) / len(found.omega) / 2
        assert found.omega[[0, -1]] == pytest.approx([low + half, high - half], rel=1e-9)
        inside = (climate.omega > low) & (climate.omega < high)
        assert np.sum(np.abs(found.amplitude) ** 2) / 2 == pytest.approx(
            0.1 * climate.density[2, inside].sum(), rel=1e-9
        )


def test_bands_do_not_reach_below_zero_and_are_as_wide_outwards_as_inwards():
    assert band_edges(np.array([0.1, 0.5, 0.7])) == pytest.approx([0.0, 0.3, 0.6, 0.8])
    assert band_edges(np.array([0.4, 0.6, 1.2])) == pytest.approx([0.3, 0.5, 0.9, 1.5])


def test_the_sea_whose_height_is_most_wrong_is_named():
    climate = rising([1.0, 1.0, 1.0], [0.2, 0.3, 0.5])
    hs = climate.hs * np.array([1.03, 0.9, 1.04])
    with pytest.raises(
        ConfigError, match=rf"received Hs {hs[1]:.4g} m of sea 1, its spectrum holds {climate.hs[1]:.4g} m"
    ):
        Climate(climate.omega, climate.density, climate.hours, hs, climate.te, "wrong")


@pytest.mark.parametrize("total", [0.9, 1.1])
def test_shares_may_not_sum_to_less_or_more_than_one(total):
    with pytest.raises(ConfigError, match=rf"climate uneven: received shares that sum to {total:g}, needs 1"):
        rising([1.0, 2.0], [0.5, total - 0.5])


@pytest.mark.parametrize("field", ["density", "hours", "hs", "te"])
def test_of_several_numbers_that_are_wrong_the_least_is_named(field):
    right = rising([1.0, 2.0, 3.0], [0.2, 0.3, 0.5])
    fields = {name: getattr(right, name) for name in ("omega", "density", "hours", "hs", "te", "name")}
    fields[field] = np.array(fields[field])
    fields[field][1], fields[field][2] = -1.0, -2.0
    with pytest.raises(ConfigError, match=rf"climate uneven: received {field} with -2, needs"):
        Climate(**fields)


def test_frequencies_of_a_climate_may_not_repeat():
    right = rising([1.0], [1.0])
    omega = np.array(right.omega)
    omega[3] = omega[4]
    with pytest.raises(ConfigError, match=r"received omega with 0\.8, needs ascending, > 0, all finite"):
        Climate(omega, right.density, right.hours, right.hs, right.te, "twice")


def test_records_are_told_and_those_left_out_are_in_no_sum():
    """Of 202 records one is flat and not calm, one too steep, one has a band of no energy: what is said of the others."""
    omega = 3.0 + 0.1 * np.arange(5)
    calm, steep = np.linspace(0.001, 0.0, 5), np.linspace(2.0, 1.0, 5)
    climate = of_records(omega, np.vstack([*[calm] * 100, steep, *[calm] * 100, np.full(5, 0.001)]), "file", ["first"])
    tail = of_records(omega, calm[None], "one").notes[-1]
    assert climate.notes == (
        "first",
        "202 records, 0 with missing values left out",
        "1 records of one value throughout left out: calm or faulty, the file cannot tell",
        "1 records steeper than any sea left out",
        "200 spectra used",
        tail,
    )
    assert climate.name == "file"
    assert of_records(omega, calm[None], "one").notes[:-1] == (
        "1 records, 0 with missing values left out",
        "1 spectra used",
    )
    with_energy = calm[::-1]
    tail = of_records(omega, with_energy[None], "one").notes[-1]
    mixed = of_records(omega, np.vstack([*[with_energy] * 200, steep]), "file")
    assert mixed.notes[-1] == tail


def test_the_steepest_of_records_that_cannot_be_is_named():
    """A swell of 8 m is high, one of 4 m at half a hertz steep."""
    omega = np.array([0.3, 0.4, 3.0, 3.1])
    swell, steep = np.array([10.0, 30.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, 9.0])
    hs, te = height_and_period(omega, np.vstack([swell, steep]))
    assert hs[0] > hs[1]
    with pytest.raises(ConfigError, match=rf"as Hs {hs[1]:.4g} m with Te {te[1]:.4g} s; needs frequencies in Hz"):
        of_records(omega, np.vstack([swell, steep]), "file")


@pytest.mark.parametrize(("field", "value", "needed"), [
    ("te", 0.0, "periods above 0"), ("hs", 0.0, "heights above 0"), ("te", -np.inf, "periods above 0"),
    ("hs", np.inf, "heights above 0"), ("hours", np.nan, "no share below 0"), ("density", np.inf, "no number below 0"),
    ("omega", np.nan, "ascending, > 0"),
])  # fmt: skip
def test_one_number_that_cannot_be_is_named_whichever_it_is(field, value, needed):
    right = rising([1.0, 2.0, 3.0], [0.2, 0.3, 0.5])
    fields = {name: np.array(getattr(right, name)) for name in ("omega", "density", "hours", "hs", "te")}
    fields[field].flat[-1] = value
    told = f"climate uneven: received {field} with {value:.6g}, needs {needed}, all finite"
    with pytest.raises(ConfigError, match=f"^{re.escape(told)}$"):
        Climate(**fields, name="uneven")


def test_a_calm_band_and_a_sea_of_no_hours_are_known_all_the_same():
    right = rising([1.0, 2.0], [0.0, 1.0])
    density = np.array(right.density)
    density[:, 0] = 0.0
    known = Climate.of_spectra(right.omega, density, right.hours, "calm", ["said"])
    assert known.notes == ("said",)
    assert known.mean_density == pytest.approx(density[1])


def test_a_realisation_reaches_no_farther_than_the_bands():
    """Beyond them nothing is known, whatever is asked for; as many components as the bands alone need."""
    climate = rising([1.0, 2.0], [0.5, 0.5])
    wide, own = realised(climate, 1, 300.0, 2, 0.1, 5.0), realised(climate, 1, 300.0, 2)
    np.testing.assert_array_equal(wide.omega, own.omega)
    np.testing.assert_array_equal(wide.amplitude, own.amplitude)
    assert len(own.omega) == int(np.ceil(1.1 * 1.1 * 300.0 / (2 * np.pi)))


def test_seas_just_as_high_or_as_steep_as_there_are_can_be():
    assert impossible(np.array([40.0]), np.array([30.0])).tolist() == [False]
    assert impossible(np.array([1.0, 41.0, 1.0]), np.array([30.0, 30.0, 1.0])).tolist() == [False, True, True]


def test_all_that_lies_in_the_bands_is_inside_and_none_of_what_lies_elsewhere():
    """Half of the first band, all of them, more than all of them, none of them."""
    climate = rising([1.0, 2.0], [0.25, 0.75])
    inside = 0.1 * climate.mean_density
    half = (inside[0] / 2) / inside.sum()
    assert climate.variance_outside(0.8, 9.0) == pytest.approx(half, rel=1e-9)
    assert climate.variance_outside(*climate.edges[[0, -1]]) == pytest.approx(0.0, abs=1e-12)
    assert climate.variance_outside(0.0, 50.0) == pytest.approx(0.0, abs=1e-12)
    assert climate.variance_outside(2.5, 3.0) == 1.0
    assert climate.variance_outside(0.1, 0.5) == 1.0


@pytest.mark.parametrize("field", ["density", "hours", "hs", "te"])
def test_of_several_numbers_that_are_not_finite_the_first_is_named(field):
    right = rising([1.0, 2.0, 3.0], [0.2, 0.3, 0.5])
    fields = {name: np.array(getattr(right, name)) for name in ("omega", "density", "hours", "hs", "te")}
    fields[field].flat[0], fields[field].flat[1], fields[field].flat[2] = -5.0, np.inf, np.nan
    with pytest.raises(ConfigError, match=rf"^climate uneven: received {field} with inf, needs .*, all finite$"):
        Climate(**fields, name="uneven")
