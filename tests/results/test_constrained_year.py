"""The year within limits of force and stroke, bin by bin, and as the tuning constrained of a member."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st
from models.test_buoy_of_shape import water
from report.test_interactive import ports
from results.test_year import WATER, climate, port

from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.port import Port
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.waves.kinds import Jonswap, PiersonMoskowitz, RegularWave, WhiteNoise
from vsb.models.floating_system import BuoyOfShape, buoy_at
from vsb.models.rest import reference_shell
from vsb.models.viability import viability
from vsb.results.campaign import member
from vsb.results.constrained_year import (
    SHARES,
    ConstrainedYear,
    Optima,
    affordable,
    constrained_year,
    force_steps,
    harmonics_of_year,
    harmonics_within,
    repeating,
)
from vsb.results.year import LIMITS as WAVE_LIMITS
from vsb.results.year import Bins
from vsb.study.campaign import CONSTRAINED

SEAS = climate(seas=10)
HARMONICS = Harmonics(0.2, 1.0, 12)  # 0.2 to 2.4 rad/s
PORT = port(HARMONICS.port_omega)


def limited(limits, seconds=10.0, **changes):
    given = {"port": PORT, "climate": SEAS, "water": WATER, "harmonics": HARMONICS} | changes
    return constrained_year(**given, limits=limits, seconds=seconds)


@cache
def within(limits):
    return limited(limits)


def test_year_without_limits_is_the_matched_year():
    """Without limits power is linear in the spectrum, so that bins do not matter."""
    fine = Harmonics(0.005, 40.0, 441)
    found = limited(Limits(), harmonics=fine, port=port(fine.port_omega), seconds=1e3)
    inside = np.arange(0.25, 2.25, 0.001) + 0.0005
    exact, band = port(inside).matched_power, np.searchsorted(SEAS.edges, inside) - 1
    each = [2 * 0.001 * float(exact @ s[band]) for s in SEAS.density]
    mean, low, high = found.annual_mean_power
    assert mean == pytest.approx(float(np.dot(each, SEAS.hours)), rel=2e-3)
    assert low == pytest.approx(mean, rel=1e-12)
    assert high == pytest.approx(mean, rel=1e-5)
    assert found.flux_share == pytest.approx(1.0)
    assert found.reached.sum() == len(found.bins.occupied)


def test_tighter_limits_absorb_less():
    free, loose, tight = (within(Limits(force=f)) for f in (np.inf, 2e4, 1e4))
    powers = [one.annual_mean_power.mean for one in (free, loose, tight)]
    assert powers[0] > powers[1] > powers[2] > 0
    assert tight.force_rms < 1e4 < free.force_rms
    assert max(optimum.force_peak for pair in tight.optima for optimum in pair) <= 1e4
    assert tight.excess == 0
    assert within(Limits(stroke=0.5)).excess > 0  # the limits hold at the instants of collocation only


def test_partly_solved_year_brackets_the_whole():
    whole, part = within(Limits(force=2e4)), limited(Limits(force=2e4), seconds=0.05)
    assert len(part.solved) == affordable(HARMONICS, 0.05) < len(whole.solved)
    mean, low, high = part.annual_mean_power
    assert low < whole.annual_mean_power.mean < high
    assert low < mean < high
    assert part.flux_share < 1
    assert part.power_matrix[part.reached] == pytest.approx(whole.power_matrix[part.reached], rel=1e-12)
    assert part.flux_share > len(part.solved) / len(whole.solved)  # the most energetic come first


def test_seas_in_which_no_force_keeps_the_stroke():
    found = limited(Limits(force=1e2, stroke=0.05))
    assert 0 < found.impossible <= 1
    none = np.array([[optimum is None for optimum in pair] for pair in found.optima])
    assert found.impossible == pytest.approx(float(found.share @ none.mean(axis=1)))
    assert np.all(found.power_matrix.ravel()[found.solved[none.all(axis=1)]] == 0)


@pytest.mark.slow
def test_interval_of_the_gain_covers_other_realisations():
    """Eight draws of phases in the same waves; the gap between powers and bounds is left out."""
    coarse, seas = Harmonics(0.1, 3.0, 18), climate(seas=4)
    ports = port(coarse.port_omega), port(coarse.port_omega, mass=22000.0)
    pairs = [
        [limited(Limits(force=1e4), harmonics=coarse, port=p, climate=seas, seed=seed) for p in ports]
        for seed in range(8)
    ]
    gains = np.array([b.gain(a) for a, b in pairs])
    halves = [100 * (b.absorbed / a.bound - 1) - low for (a, b), low in zip(pairs, gains[:, 1], strict=True)]
    others = [high - 100 * (b.bound / a.absorbed - 1) for (a, b), high in zip(pairs, gains[:, 2], strict=True)]
    assert halves == pytest.approx(others, rel=1e-6)
    truth = 100 * (sum(b.absorbed for _, b in pairs) / sum(a.absorbed for a, _ in pairs) - 1)
    assert np.count_nonzero(np.abs(gains[:, 0] - truth) <= halves) >= 7
    assert 1 < np.median(halves) / np.std(gains[:, 0]) < 6


def taking(*bins):
    """A year of equally frequent bins with (power, bound) of each realisation."""
    count = len(bins)
    optima = tuple(tuple(SimpleNamespace(power=power, bound=bound) for power, bound in pair) for pair in bins)
    seas = Bins(0.5 * np.arange(count) + 0.1, np.full(count, 0.5), np.full(count, 1 / count))
    return ConstrainedYear(
        seas, np.arange(count), np.zeros((count, 2, 1)), optima, np.full(seas.shape, 1e3), flux_share=1.0
    )


def test_gain_is_bounded_by_powers_and_bounds():
    """60 W with bound 66 over 40 W with bound 50: a gain of 50 %, between 60/50 and 66/40."""
    better, base = taking([(60.0, 66.0)] * 2), taking([(40.0, 50.0)] * 2)
    assert better.annual_mean_power == pytest.approx((60.0, 60.0, 66.0))
    assert better.gain(base) == pytest.approx((50.0, 20.0, 65.0))


def test_gain_in_the_same_waves_is_sharp():
    """Proportional powers have no scatter; exchanged realisations have."""
    draws = [[(30.0, 30.0), (50.0, 50.0)], [(10.0, 10.0), (20.0, 20.0)]]
    scaled = [[(1.5 * power, 1.5 * bound) for power, bound in pair] for pair in draws]
    base, alike, turned = taking(*draws), taking(*scaled), taking(*(pair[::-1] for pair in scaled))
    assert alike.gain(base) == pytest.approx((50.0, 50.0, 50.0))
    mean, low, high = turned.gain(base)
    assert mean == pytest.approx(50.0)
    assert high - mean == pytest.approx(mean - low)
    assert high - mean > 20.0


def test_undecided_sea_keeps_its_bound():
    """Where no force was found but none is excluded either."""
    limits = Limits(1e4, 0.05)
    year_of = limited(limits)
    none = np.array([[optimum is None for optimum in pair] for pair in year_of.optima])
    assert none.any()
    known = [[one.bound if one else 0.0 for one in pair] for pair in year_of.optima]
    bounds = np.where(none, year_of.undecided, known)
    assert year_of.bound == pytest.approx(float(year_of.share @ bounds.mean(axis=1)))
    assert (year_of.undecided[none] > 0).any()
    assert not np.any(year_of.undecided[~none])


LIMIT, SECONDS = 2e4, 0.05


def buoy(study):
    """The buoy in water that acts on one ring."""
    swept = SimpleNamespace(band=(0.1, 8.0), clamps=None, at=lambda omega: water(study, omega=omega))
    return BuoyOfShape(study, reference_shell(study), swept)


@pytest.fixture(scope="module")
def study(seed):
    return varied(
        seed,
        designs={"FSB": {"flexible": False}, "VSWEC": {}},
        modes={"degree": 2, "tolerance": 0.1},
        pto={"damping": 8e3, "force_limit": LIMIT},
        hydro={"omega_max": 8.0},
    )


@pytest.fixture(scope="module")
def seas():
    return climate(seas=6)


@pytest.fixture(scope="module")
def found(study, seas):
    return member(viability(study), lambda: buoy(study), seas, ("one", CONSTRAINED), Optima(SECONDS, 1))


def test_member_equals_the_constrained_years_of_its_ports(study, seas, found):
    harmonics = harmonics_of_year(seas, float(seas.edges[0]), 8.0, SECONDS)
    ports = buoy_at(study, reference_shell(study), water(study, omega=harmonics.port_omega)).ports()
    years = {
        design: constrained_year(port, seas, study.water, harmonics, Limits(LIMIT), SECONDS, 1)
        for design, port in ports.items()
    }
    at = found.sel(tuning=CONSTRAINED)
    for design, one in years.items():
        here = at.sel(design=design)
        assert float(here.annual_mean_power) == pytest.approx(one.annual_mean_power.mean, rel=1e-12)
        assert float(here.annual_energy) == pytest.approx(one.annual_mean_power.mean * 8.766e-3, rel=1e-12)
        flux = float(seas.flux(study.water) @ seas.hours)
        assert float(here.capture_width) * flux == pytest.approx(one.annual_mean_power.mean, rel=1e-12)
        assert 2 * float(here.quadrature_error) == pytest.approx(np.ptp(one.annual_mean_power[1:]), rel=1e-12)
        assert float(here.force_rms) == pytest.approx(one.force_rms)
        assert one.force_rms < LIMIT
        np.testing.assert_allclose(here.power_matrix, one.power_matrix, rtol=1e-12)
        assert float((here.power_matrix * one.bins.share).sum()) == pytest.approx(one.absorbed, rel=1e-12)
        if design != "FSB":
            mean, low, high = one.gain(years["FSB"])
            assert float(here.gain_percent) == pytest.approx(mean, rel=1e-9)
            assert float(here.gain_low) < low < high < float(here.gain_high)


@pytest.mark.slow
def test_soft_shell_is_marked_beyond_validity(study, seas, found):
    soft = varied(study, device={"young_modulus": 5e5}, pto={"stiffness": 1e5})
    ds = Optima(SECONDS, 1)(soft, buoy(soft), seas).sel(tuning=CONSTRAINED)
    ds = ds.assign_coords(limit=list(WAVE_LIMITS))
    assert 0 < float(ds.energy_beyond.sel(design="VSWEC", limit="deformation")) <= 1
    assert float(ds.energy_beyond.sel(design="FSB", limit="deformation")) == 0
    assert bool((ds.energy_beyond_validity >= ds.energy_beyond.sel(limit="deformation") - 1e-12).all())


@pytest.mark.slow
def test_known_years_are_not_reused_for_other_limits(study, seas):
    """Of one rigid design in one sea."""
    rigid, kept = varied(study, designs={"FSB": {"flexible": False}}), None
    powers = []
    for pto in ({"force_limit": 1e4}, {"force_limit": 2e4}):
        one = varied(rigid, pto=pto)
        kept = kept or Optima(SECONDS, 1)
        found, alone = (of(one, buoy(one), seas) for of in (kept, Optima(SECONDS, 1)))
        assert found.identical(alone)
        powers.append(float(found.annual_mean_power.squeeze()))
    assert len(kept.known) == len(set(powers)) == 2


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
