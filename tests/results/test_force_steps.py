"""Constrained optima over a range of force limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report.test_interactive import ports

from vsb.engine.motion.port import Port
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.waves.kinds import Jonswap, PiersonMoskowitz, RegularWave, WhiteNoise
from vsb.results.force_steps import SHARES, force_steps, harmonics_within, repeating

BAND = (0.2, 9.0)
SWELL = RegularWave(kind="regular", amplitude=0.2, period=2.5)
SEA = Jonswap(kind="jonswap", hs=1.0, tp=5.0)
NOISE = WhiteNoise(kind="white_noise", hs=0.5, band=(1.0, 3.0))


def seen(name):
    return lambda omega: ports(omega)[name]


BOTH = {name: seen(name) for name in ("FSB", "VSWEC")}


@pytest.mark.parametrize("wave", [SWELL, SEA])
def test_power_is_increasing_and_concave_in_the_force_limit(wave):
    steps = force_steps(wave, BOTH, "FSB", BAND)
    assert list(steps.limits) == pytest.approx([share * steps.limits[-1] for share in SHARES])
    harmonics = harmonics_within(BAND, 2 * len(SHARES))
    waves = wave.realisation() if wave is SWELL else repeating(wave, harmonics)
    for name, powers in steps.powers.items():
        assert np.all(np.diff(powers) > 0)
        assert np.all(np.diff(np.diff(powers) / np.diff(steps.limits)) < 0)
        assert 0 < powers[0] < powers[-1] < waves.mean_of(ports(waves.omega)[name].matched_power)
    assert (steps.of, steps.repeats is None) == ("FSB", wave is SWELL)


def test_largest_limit_is_the_force_of_the_optimal_damper():
    omega, squares = np.array([SWELL.omega]), np.array([[SWELL.amplitude**2]])
    for name in BOTH:
        steps = force_steps(SWELL, BOTH, name, BAND)
        port = ports(omega)[name]
        best = best_dampers(port, squares)
        force = best.damping[0] * abs(port.velocity_under(port.load(best.damping[0]))[0]) * SWELL.amplitude
        assert steps.limits[-1] == pytest.approx(force, rel=2e-3)  # at the instants of collocation
        assert steps.powers[name][-1] >= best.power[0] * (1 - 1e-6)


@pytest.mark.parametrize("wave", [NOISE, PiersonMoskowitz(kind="pierson_moskowitz", hs=2.0, tp=8.0)])
def test_periodic_sea_has_the_energy_of_the_spectrum(wave):
    waves = repeating(wave, harmonics_within((0.05, 9.0), 16))
    assert 4 * np.sqrt(np.sum(np.abs(waves.amplitude) ** 2) / 2) == pytest.approx(wave.hs, rel=5e-3)


@given(st.floats(1e-3, 3.0), st.floats(0.5, 20.0), st.integers(1, 10_000))
def test_harmonics_fill_their_band(low, width, programmes):
    harmonics = harmonics_within((low, low + width), programmes)
    first, last = harmonics.omega[[0, -1]]
    assert first >= low * (1 - 1e-8)
    assert last <= (low + width) * (1 + 1e-8)
    assert first - harmonics.spacing < low
    assert last + harmonics.spacing > (low + width) * (1 + 1e-12)


def test_impossible_stroke_has_no_optimum():
    free = force_steps(SWELL, BOTH, "FSB", BAND)
    held = force_steps(SWELL, BOTH, "FSB", BAND, stroke=0.3)
    tight = force_steps(SWELL, BOTH, "FSB", BAND, stroke=1e-3)
    assert tight.powers["FSB"][0] is None
    assert all(h is None or h <= f * (1 + 1e-6) for h, f in zip(held.powers["FSB"], free.powers["FSB"], strict=True))


def test_port_that_does_not_move_absorbs_nothing():
    def still(omega):
        nothing = np.zeros(len(omega), dtype=complex)
        return Port(omega, nothing, nothing, 0.0)

    steps = force_steps(SWELL, {"FSB": still, "VSWEC": seen("VSWEC")}, "FSB", BAND)
    assert (steps.of, set(steps.powers["FSB"])) == ("VSWEC", {0.0})
    assert force_steps(SWELL, {"FSB": still}, "FSB", BAND) is None
