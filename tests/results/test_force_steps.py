"""Optima at some limits of force: between nothing and all, the same as those of the ladder, no matter the clock."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report.test_living import ports

from vsb.motion.constrained import optimum_in_sea
from vsb.motion.force_bound import Limits
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port
from vsb.motion.tuning import best_dampers
from vsb.results.force_steps import FEWEST, MOST, SHARES, _damper_force, force_steps, harmonics_within, repeating
from vsb.study.study import Jonswap, PiersonMoskowitz, RegularWave, WhiteNoise
from vsb.waves.seas import Sea, regular, spectrum

BAND = (0.2, 9.0)
SWELL = RegularWave(kind="regular", amplitude=0.2, period=2.5)
SEA = Jonswap(kind="jonswap", hs=1.0, tp=5.0)
NOISE = WhiteNoise(kind="white_noise", hs=0.5, band=(1.0, 3.0))


def seen(name):
    return lambda omega: ports(omega)[name]


BOTH = {name: seen(name) for name in ("FSB", "VSWEC")}


@pytest.mark.parametrize("wave", [SWELL, SEA, NOISE])
def test_more_force_takes_more_and_never_more_than_there_is(wave):
    steps = force_steps(wave, BOTH, "FSB", BAND)
    assert list(steps.limits) == pytest.approx([share * steps.limits[-1] for share in SHARES])
    harmonics = harmonics_within(BAND, 2 * len(SHARES))
    waves = regular(wave) if wave is SWELL else repeating(wave, harmonics)
    for name, powers in steps.powers.items():
        assert np.all(np.diff(powers) > 0)
        assert np.all(np.diff(np.diff(powers) / np.diff(steps.limits)) < 0), "concave: each newton brings less"
        assert 0 < powers[0] < powers[-1] < waves.mean_of(ports(waves.omega)[name].matched_power)
    assert (steps.of, steps.repeats is None) == ("FSB", wave is SWELL)


def test_the_largest_limit_is_what_the_best_damper_of_the_reference_needs():
    """The optimum there takes at least as much; beyond it the damper alone would not."""
    omega, squares = np.array([SWELL.omega]), np.array([[SWELL.amplitude**2]])
    for name in BOTH:
        steps = force_steps(SWELL, BOTH, name, BAND)
        port = ports(omega)[name]
        best = best_dampers(port, squares)
        force = best.damping[0] * abs(port.velocity_under(port.load(best.damping[0]))[0]) * SWELL.amplitude
        assert steps.limits[-1] == pytest.approx(force, rel=2e-3)  # at the instants of collocation
        assert steps.powers[name][-1] >= best.power[0] * (1 - 1e-6)


def test_of_a_regular_wave_they_are_the_optima_of_the_ladder():
    steps = force_steps(SWELL, BOTH, "FSB", BAND)
    harmonics = Harmonics.of_sea(np.array([SWELL.omega]), *BAND)
    for limit, power in zip(steps.limits, steps.powers["VSWEC"], strict=True):
        best = optimum_in_sea(ports(harmonics.port_omega)["VSWEC"], regular(SWELL), harmonics, Limits(limit))
        assert best.power == power


@pytest.mark.parametrize("wave", [SEA, NOISE, PiersonMoskowitz(kind="pierson_moskowitz", hs=2.0, tp=8.0)])
def test_the_sea_that_repeats_holds_the_energy_of_the_spectrum(wave):
    waves = repeating(wave, harmonics_within((0.05, 9.0), 16))
    assert 4 * np.sqrt(np.sum(np.abs(waves.amplitude) ** 2) / 2) == pytest.approx(wave.hs, rel=5e-3)


def test_harmonics_are_what_the_budget_allows():
    few, many = harmonics_within(BAND, 10_000), harmonics_within(BAND, 1)
    for harmonics, count in ((few, FEWEST), (many, MOST)):
        assert count - 5 <= harmonics.count <= count
        assert harmonics.omega[0] >= BAND[0]
        assert harmonics.omega[-1] <= BAND[1] * (1 + 1e-9)


@given(st.floats(1e-3, 3.0), st.floats(0.5, 20.0), st.integers(1, 10_000))
def test_harmonics_fill_their_band(low, width, programmes):
    """All that lie in it, the edges too, and none beyond."""
    harmonics = harmonics_within((low, low + width), programmes)
    first, last = harmonics.omega[[0, -1]]
    assert first >= low * (1 - 1e-8)
    assert last <= (low + width) * (1 + 1e-8)
    assert first - harmonics.spacing < low
    assert last + harmonics.spacing > (low + width) * (1 + 1e-12)


@pytest.mark.parametrize("first", [1, 3, 7])
def test_a_harmonic_at_either_edge_of_a_band_is_in_it(first):
    """The lower edge a whole number of spacings: round-off of either kind does not lose it, nor the upper one."""
    for nudge in (1 - 1e-13, 1.0, 1 + 1e-13):
        spacing = 0.1
        band = first * spacing * nudge, (first + MOST) * spacing * nudge
        harmonics = harmonics_within(band, 1)
        assert harmonics.first == first
        assert harmonics.count == MOST + 1


def test_a_stroke_no_force_keeps_has_no_optimum():
    free = force_steps(SWELL, BOTH, "FSB", BAND)
    held = force_steps(SWELL, BOTH, "FSB", BAND, stroke=0.3)
    tight = force_steps(SWELL, BOTH, "FSB", BAND, stroke=1e-3)
    assert tight.powers["FSB"][0] is None
    assert all(h is None or h <= f * (1 + 1e-6) for h, f in zip(held.powers["FSB"], free.powers["FSB"], strict=True))


def test_a_port_waves_do_not_move_takes_nothing():
    def still(omega):
        nothing = np.zeros(len(omega), dtype=complex)
        return Port(omega, nothing, nothing, 0.0)

    steps = force_steps(SWELL, {"FSB": still, "VSWEC": seen("VSWEC")}, "FSB", BAND)
    assert (steps.of, set(steps.powers["FSB"])) == ("VSWEC", {0.0})
    assert force_steps(SWELL, {"FSB": still}, "FSB", BAND) is None


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_force_of_a_damper_is_the_largest_pushed_or_pulled(sign):
    """In a sea whose waves meet once: as large upside down, and never more than the sum of its waves'."""
    harmonics = Harmonics.of_sea(np.array([0.5, 1.0, 1.5, 2.0]), *BAND)
    omega = np.array([0.5, 1.0, 1.5, 2.0])
    port = ports(harmonics.omega)["FSB"]
    best = best_dampers(port, np.isclose(harmonics.omega[:, None], omega).any(axis=1)[None] * 1.0).damping[0]
    moved = port.velocity_under(port.load(best))[[np.argmin(np.abs(harmonics.omega - w)) for w in omega]]
    together = (
        np.abs(moved) / moved
    )  # every wave of amplitude 1, all of the port's velocities in phase at the beginning
    found = _damper_force(port, Sea(omega, sign * together), harmonics)
    assert found == pytest.approx(best * np.abs(moved).sum(), rel=1e-9)


def test_the_budget_of_a_page_is_for_all_its_seas_designs_and_limits():
    """Of twenty seas each is taken to repeat sooner than one alone is; a regular wave has no period to choose."""
    for seas in (1, 20):
        harmonics = harmonics_within(BAND, seas * len(BOTH) * len(SHARES))
        steps = force_steps(SEA, {name: BOTH[name] for name in BOTH}, "FSB", BAND, seas=seas)
        assert steps.repeats == pytest.approx(2 * np.pi / harmonics.spacing, rel=1e-12)
        assert FEWEST < harmonics.count <= MOST + 1
    assert harmonics.count < MOST


def test_a_sea_repeats_in_the_phases_of_its_own_seed():
    """Of the same sizes whatever the seed, of other phases with another one."""
    harmonics = harmonics_within((0.05, 9.0), 16)
    seas = [repeating(SEA.model_copy(update={"seed": seed}), harmonics).amplitude for seed in (3, 3, 4)]
    np.testing.assert_array_equal(seas[0], seas[1])
    np.testing.assert_allclose(np.abs(seas[0]), np.abs(seas[2]), rtol=1e-12)
    assert np.abs(seas[0] - seas[2]).max() > np.abs(seas[0]).max()
    phase = np.random.default_rng(3).uniform(0.0, 2 * np.pi, harmonics.count)
    np.testing.assert_allclose(seas[0], np.abs(seas[0]) * np.exp(1j * phase), atol=1e-12)


@pytest.mark.parametrize("wave", [SEA, NOISE])
def test_every_harmonic_has_the_variance_of_the_band_around_it(wave):
    """Half a spacing to either side; of few harmonics, within which a spectrum rises."""
    harmonics = Harmonics(0.15, 3.0, 30)
    waves = repeating(wave, harmonics)
    inside = 0.15 * ((np.arange(1000) + 0.5) / 1000 - 0.5)
    density = spectrum(wave, (harmonics.omega[:, None] + inside).ravel()).reshape(30, -1).mean(axis=1)
    expected = 2 * 0.15 * density
    assert np.abs(waves.amplitude) ** 2 == pytest.approx(expected, abs=(2e-3 if wave is SEA else 0.06) * expected.max())
    np.testing.assert_array_equal(waves.omega, harmonics.omega)


def test_the_force_of_a_damper_is_that_of_waves_at_their_own_harmonics():
    """Where the first harmonic of the force is the third: those of the waves are the fourth and the ninth."""
    harmonics = Harmonics(0.25, 3.0, 10)
    port, amplitude = ports(harmonics.omega)["FSB"], np.array([0.3 + 0.1j, -0.2j])
    best = best_dampers(port, np.array([[0, 0.1, 0, 0, 0, 0, 0.04, 0, 0, 0]])).damping[0]
    moved = (port.velocity_under(port.load(best)))[[1, 6]] * amplitude
    found = _damper_force(port, Sea(harmonics.omega[[1, 6]], amplitude), harmonics)
    time = np.linspace(0.0, 2 * np.pi / 0.25, 20001)
    signal = np.real(np.exp(-1j * np.outer(time, harmonics.omega[[1, 6]])) @ moved)
    assert found == pytest.approx(best * np.abs(signal).max(), rel=2e-2)


def test_without_a_reference_limits_are_of_the_first_design_that_moves():
    for reference in (None, "other"):
        steps = force_steps(SWELL, {name: BOTH[name] for name in ("VSWEC", "FSB")}, reference, BAND)
        assert steps.of == "VSWEC"
        assert list(steps.powers) == ["VSWEC", "FSB"]
        assert len(steps.limits) == len(SHARES)
