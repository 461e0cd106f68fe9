"""A site's climate: moments, energy flux, what is left out and noted."""

import re

import numpy as np
import pytest

from vsb.engine.waves.climate import Climate, height_and_period, is_doubt, of_records, realised
from vsb.engine.waves.records import impossible
from vsb.engine.waves.water import Water, wavenumber
from vsb.errors import ConfigError


def flat(seas=1, hours=None):
    """Seas of one density over 11 bands 0.1 rad/s wide."""
    omega, density = 0.5 + 0.1 * np.arange(11), np.full((seas, 11), 0.25)
    return Climate.of_spectra(omega, density, np.full(seas, 1 / seas) if hours is None else hours, "flat")


def rising(factors, hours):
    """Seas of one uneven spectrum between 0.8 and 1.8 rad/s, each a multiple of it."""
    omega = 0.8 + 0.1 * np.arange(11)
    return Climate.of_spectra(omega, np.outer(factors, np.linspace(0.1, 0.4, 11)), np.array(hours), "uneven")


def fields(climate):
    return {name: np.array(getattr(climate, name)) for name in ("omega", "density", "hours", "hs", "te")}


def test_moments_are_sums_over_bands():
    climate = flat()
    assert climate.hs == pytest.approx([4 * np.sqrt(0.25 * 1.1)], rel=1e-14)
    assert climate.te == pytest.approx([2 * np.pi * 0.1 * np.sum(1 / climate.omega) / 1.1], rel=1e-14)


def test_energy_flux_in_shallow_water():
    """rho g sum S v_g d, with the group velocity of the dispersion relation."""
    climate, water = rising([1.0, 3.0], [0.5, 0.5]), Water(depth=6.0, density=998.0, gravity=9.7)
    k = np.array([wavenumber(w, 6.0, 9.7) for w in climate.omega])
    speed = climate.omega / (2 * k) * (1 + 2 * k * 6.0 / np.sinh(2 * k * 6.0))
    closed = 998.0 * 9.7 * np.sum(climate.density * speed * 0.1, axis=1)
    assert climate.flux(water) == pytest.approx(closed, rel=1e-12)


def test_mean_and_variance_outside_weigh_seas_by_their_hours():
    """A rare high sea at low frequencies beside a common one at high frequencies: means and shares by hand."""
    density = np.array([[8.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0]])
    climate = Climate.of_spectra(np.array([1.0, 2.0, 3.0, 4.0]), density, np.array([0.1, 0.9]), "two")
    assert climate.mean_density == pytest.approx([0.8, 0.0, 0.0, 1.8], rel=1e-14)
    assert climate.variance_outside(1.5, 10.0) == pytest.approx(0.8 / 2.6, rel=1e-12)
    assert climate.variance_outside(0.1, 3.5) == pytest.approx(1.8 / 2.6, rel=1e-12)
    assert climate.variance_outside(0.0, 50.0) == pytest.approx(0.0, abs=1e-12)
    assert climate.variance_outside(0.1, 0.4) == 1.0
    half = (0.8 / 2) / 2.6
    assert climate.variance_outside(1.0, 9.0) == pytest.approx(half, rel=1e-12)  # half of the first band


def test_quantile_is_the_density_that_share_of_the_year_stays_below():
    climate = rising([3.0, 1.0, 2.0], [0.2, 0.5, 0.3])
    for share, sea in ((0.1, 1), (0.49, 1), (0.51, 2), (0.79, 2), (0.81, 0)):
        assert climate.quantile(share) == pytest.approx(climate.density[sea])


def test_realisation_has_the_amplitudes_of_the_spectrum_and_the_phases_of_its_seed():
    """a = sqrt(2 S d), with d a tenth finer than 2 pi over the duration; uniform phases of numpy's generator."""
    found = realised(flat(), 0, 600.0, 7)
    count = int(np.ceil(1.1 * 1.1 * 600.0 / (2 * np.pi)))
    assert found.omega == pytest.approx(0.45 + 1.1 * (np.arange(count) + 0.5) / count, rel=1e-12)
    assert np.abs(found.amplitude) == pytest.approx(np.full(count, np.sqrt(2 * 0.25 * 1.1 / count)), rel=1e-9)
    phases = np.exp(2j * np.pi * np.random.default_rng(7).random(count))
    assert found.amplitude / np.abs(found.amplitude) == pytest.approx(phases, abs=1e-12)


def test_limits_of_possible_seas():
    """A steepness of 0.1 and a height of 40 m, each from both sides."""
    just, period = np.array([0.99, 1.01]), 10.0
    steep = 0.1 * 9.81 * period**2 / (2 * np.pi)
    assert impossible(steep * just, np.full(2, period)).tolist() == [False, True]
    assert impossible(40.0 * just, np.full(2, 30.0)).tolist() == [False, True]


def test_at_most_one_percent_of_the_records_may_be_impossible():
    """Waves of half a hertz and 4 m are steeper than any sea; the steepest is named, not the highest."""
    omega = 3.0 + 0.1 * np.arange(5)
    calm, steep = np.linspace(0.001, 0.002, 5), np.linspace(2.0, 1.0, 5)
    assert len(of_records(omega, np.vstack([steep, *[calm] * 99]), "file").hs) == 99
    with pytest.raises(ConfigError, match=r"file: received 1.0% of records that are physically impossible, as Hs"):
        of_records(omega, np.vstack([steep, *[calm] * 98]), "file")


def test_records_without_a_spectrum_are_left_out_and_counted():
    omega = 0.5 + 0.1 * np.arange(11)
    density = np.vstack([np.linspace(0.1, 0.2, 11), np.full(11, np.nan), np.zeros(11), np.linspace(0.2, 0.1, 11)])
    density[1, 1:] = 0.1  # one missing band is enough
    climate = of_records(omega, density, "file")
    assert climate.hours.tolist() == [0.5, 0.5]
    assert climate.hs == pytest.approx(height_and_period(omega, density[[0, 3]])[0])
    assert "4 records, 1 with missing values left out" in climate.notes
    assert any(note.startswith("1 records of one value throughout left out") for note in climate.notes)


def test_variance_beyond_the_bands_is_that_of_a_fifth_power_tail():
    """Of a density w^-5 from w1 to w2: (w1/w2)^4/(1 - (w1/w2)^4) of what is inside."""
    omega = np.arange(1.0, 2.0, 0.01)
    first, end = omega[0] - 0.005, omega[-1] + 0.005
    notes = of_records(omega, np.outer([1.0, 0.5, 2.0], omega**-5.0), "tail").notes
    (note,) = [note for note in notes if "fifth power" in note]
    share = (first / end) ** 4
    found = float(re.search(r"would add (.*)% to the variance", note)[1])
    assert found == pytest.approx(100 * share / (1 - share), abs=0.01)
    assert is_doubt(note)  # 6.6 %


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"density": np.ones((2, 10))}, r"received spectra of shape \(2, 10\) over 11 frequencies"),
        ({"omega": np.linspace(1.5, 0.5, 11)}, "received omega with 0.5, needs ascending, > 0, all finite"),
        ({"density": np.full((2, 11), -1.0)}, "received density with -1, needs no number below 0"),
        ({"hours": np.array([0.5, 0.4])}, r"received shares that sum to 0\.9, needs 1"),
        ({"hs": np.array([2.0978, 4.0])}, r"received Hs 4 m of sea 1, its spectrum holds 2\.098 m"),
        ({"hs": flat(2).hs / 1.0201}, "needs both within 2%"),
        ({"te": np.array([8.0, np.inf])}, "received te with inf, needs periods above 0, all finite"),
        ({"te": np.array([8.0])}, "received 2 spectra, needs as many hours, hs and te"),
    ],
)
def test_errors_of_a_climate(changes, message):
    with pytest.raises(ConfigError, match=f"^climate flat: .*{message}"):
        Climate(**fields(flat(2)) | changes, name="flat")
