"""Seas: direction, band, memory, seeds."""

import math

import numpy as np
import pytest
from conftest import SEED
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import betaincinv

from vsb.engine.hydro.orders import Directions, heading_shares
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.kinds import (
    Jonswap,
    OchiHubble,
    PiersonMoskowitz,
    RegularWave,
    StillWater,
    Tma,
    WhiteNoise,
    jonswap_spectrum,
)
from vsb.engine.waves.seas import FEW, Sea, Spreading, superposed
from vsb.engine.waves.water import Water, group_velocity, wavenumber
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical
from vsb.keys.reading import validated
from vsb.models.floating_system import heading_in
from vsb.study.body import BodyStudy
from vsb.study.study import load, parse


def test_realisations_differ_by_phase_only_and_repeat_by_seed():
    first, again = (Jonswap(kind="jonswap", hs=1, tp=5, seed=3).realisation(12.0, 60.0) for _ in range(2))
    other = Jonswap(kind="jonswap", hs=1, tp=5, seed=4).realisation(12.0, 60.0)
    assert np.array_equal(first.amplitude, again.amplitude)
    assert np.abs(first.amplitude) == pytest.approx(np.abs(other.amplitude))
    assert not np.allclose(first.amplitude, other.amplitude)
    assert 4 * np.sqrt(0.5 * np.sum(np.abs(first.amplitude) ** 2)) == pytest.approx(1.0, rel=5e-3)
    assert 2 * np.pi / np.diff(first.omega).max() >= 60.0  # no repetition within the run


def test_random_amplitudes_are_rayleigh_distributed_about_the_spectrum():
    """|a|^2 is exponential of its mean: its square has twice the square of the mean."""
    fixed, drawn = (
        Jonswap(kind="jonswap", hs=1, tp=5, seed=3, amplitudes=kind).realisation(12.0, 20_000.0)
        for kind in ("fixed", "random")
    )
    share = np.abs(drawn.amplitude) ** 2 / np.abs(fixed.amplitude) ** 2
    assert share.mean() == pytest.approx(1.0, abs=4 / np.sqrt(len(share)))
    assert (share**2).mean() == pytest.approx(2.0, abs=4 * np.sqrt(20 / len(share)))


def test_regular_and_still_seas():
    regular = RegularWave(kind="regular", amplitude=0.2, period=4.0).realisation(12.0, 60.0)
    assert regular.elevation(np.array([0.0, 1.0, 2.0])) == pytest.approx([0.2, 0.0, -0.2], abs=1e-15)
    still = StillWater(kind="still").realisation(12.0, 60.0)
    assert np.array_equal(still.elevation(np.array([0.0, 1.0])), [0.0, 0.0])


@pytest.mark.parametrize(("hs", "tp"), [(2.5, 6.0), (0.3, 2.0)])
def test_unit_peakedness_is_pierson_moskowitz(hs, tp):
    peak = 2 * np.pi / tp
    w = np.linspace(0.4, 6.0, 57) * peak
    exact = 5 / 16 * hs**2 * peak**4 * w**-5 * np.exp(-1.25 * (peak / w) ** 4)
    assert jonswap_spectrum(w, hs, tp, 1.0) == pytest.approx(exact, rel=2e-6)  # the tail beyond 40 peaks: 5e-7


@given(st.floats(0.1, 15.0), st.floats(1.0, 20.0), st.floats(1.0, 10.0))
def test_variance_of_any_sea_is_that_of_its_height(hs, tp, gamma):
    omega = np.linspace(0.02, 40.0, 40001) * 2 * np.pi / tp
    assert np.trapezoid(jonswap_spectrum(omega, hs, tp, gamma), omega) == pytest.approx(hs**2 / 16, rel=1e-12)


def test_phase_convention_and_mean_power():
    waves = Sea(np.array([1.0, 2.0]), np.array([0.5j, 0.25]))
    time = np.linspace(0, 7, 29)
    assert waves.elevation(time) == pytest.approx(0.5 * np.sin(time) + 0.25 * np.cos(2 * time), abs=1e-15)
    assert waves.mean_of(np.array([8.0, 16.0])) == pytest.approx(8 * 0.25 + 16 * 0.0625)


@pytest.mark.parametrize(("relative", "width"), [(0.8, 0.07), (0.95, 0.07), (1.05, 0.09), (1.2, 0.09)])
def test_peak_enhancement_acts_over_the_published_widths(relative, width):
    """Over Pierson-Moskowitz a sea is gamma^exp(-(w/w_p - 1)^2/(2 sigma^2)) times as dense, up to one factor."""
    w = 2 * np.pi / 6 * np.array([relative, 1.0])
    raised = jonswap_spectrum(w, 1.0, 6.0, 3.3) / jonswap_spectrum(w, 1.0, 6.0, 1.0)
    assert raised[0] / raised[1] == pytest.approx(
        3.3 ** (np.exp(-((relative - 1) ** 2) / (2 * width**2)) - 1), rel=1e-12
    )


def test_white_noise_has_one_density_in_its_band():
    """Density, shares above and below any frequency, components and their energy, by hand for a band off zero."""
    wave = WhiteNoise(kind="white_noise", hs=2.0, band=(1.0, 3.5), seed=2)
    level = 4.0 / 16 / 2.5
    assert wave.density(np.array([0.99, 1.0, 2.0, 3.5, 3.51])) == pytest.approx([0.0, level, level, level, 0.0])
    for omega, above in ((0.5, 1.0), (1.0, 1.0), (1.5, 0.8), (3.0, 0.2), (3.5, 0.0), (5.0, 0.0)):
        assert wave.share_above(omega) == pytest.approx(above, abs=1e-14)
        assert wave.share_below(omega) == pytest.approx(1 - above, abs=1e-14)
    omega, amplitude = wave.components(12.0, 300.0)
    count = int(np.ceil(2.5 * 1.1 * 300.0 / (2 * np.pi)))
    assert omega == pytest.approx(1.0 + 2.5 * (np.arange(count) + 0.5) / count, rel=1e-12)
    assert amplitude == pytest.approx(np.full(count, np.sqrt(2 * level * 2.5 / count)), rel=1e-9)


def two_peaks(swell=3.0, wind_sea=1.0, **more):
    parts = {"hs": 1.5, "tp": 12.0, "peakedness": swell}, {"hs": 2.0, "tp": 5.0, "peakedness": wind_sea}
    return OchiHubble(kind="ochi_hubble", swell=parts[0], wind_sea=parts[1], **more)


@pytest.mark.parametrize(("swell", "wind_sea"), [(3.0, 1.0), (0.6, 0.6), (10.0, 2.5)])
def test_two_peaks_carry_the_energy_of_both_at_their_periods(swell, wind_sea):
    """Variance, energy period and peaks by quadrature; nothing below the reach, little above the fastest."""
    wave, omega = two_peaks(swell, wind_sea), np.geomspace(0.05, 2e4, 200_001)
    density = wave.density(omega)
    assert 4 * np.sqrt(np.trapezoid(density * omega, np.log(omega))) == pytest.approx(2.5, rel=1e-5)
    assert wave.hs == 2.5
    period = np.trapezoid(density, np.log(omega)) / np.trapezoid(density * omega, np.log(omega))
    assert wave.omega == pytest.approx(1 / period, rel=1e-5)
    assert wave.share_below(wave.reach[0]) < 1e-10
    assert density[omega > wave.fastest].max() <= density.max() / 400
    for tp, one in ((12.0, two_peaks(swell).swell), (5.0, two_peaks(1.0, wind_sea).wind_sea)):
        alone = two_peaks(swell, wind_sea).model_copy(update={"swell": one, "wind_sea": one})
        assert omega[alone.density(omega).argmax()] == pytest.approx(2 * np.pi / tp, rel=1e-4)


def test_two_peaks_of_peakedness_one_are_pierson_moskowitz():
    wave, omega = two_peaks(1.0, 1.0), np.linspace(0.2, 6.0, 57)
    alone = [PiersonMoskowitz(kind="pierson_moskowitz", hs=hs, tp=tp) for hs, tp in ((1.5, 12.0), (2.0, 5.0))]
    assert wave.density(omega) == pytest.approx(sum(one.density(omega) for one in alone), rel=2e-6)


@pytest.mark.parametrize("relative", [0.8, 1.0, 1.5, 3.0])
def test_share_of_variance_above_and_below_a_frequency(relative):
    """1 - exp(-1.25 (peak/w)^4) of the variance lies above w."""
    wave = PiersonMoskowitz(kind="pierson_moskowitz", hs=2.5, tp=6.0)
    omega, above = relative * 2 * np.pi / 6.0, -np.expm1(-1.25 * relative**-4.0)
    assert wave.share_above(omega) == pytest.approx(above, rel=3e-3)
    assert wave.share_below(omega) == pytest.approx(1 - above, rel=1e-3)


@settings(max_examples=15)
@given(st.floats(0.5, 12.0), st.floats(2.0, 20.0), st.floats(2.0, 300.0))
def test_a_sea_of_finite_depth_carries_its_height_and_a_saturated_tail(hs, tp, depth):
    """16 m0 = hs^2; over JONSWAP it has the factor of the depth, (w^2 h/g)/2 in shallow water, 1 in deep."""
    wave = Tma(kind="tma", hs=hs, tp=tp, gamma=3.3, depth=depth)
    omega = np.linspace(0.02, 40.0, 40001) * 2 * np.pi / tp
    assert np.trapezoid(wave.density(omega), omega) == pytest.approx(hs**2 / 16, rel=1e-12)
    some = omega[500::800]
    k = np.array([wavenumber(w, depth, 9.81) for w in some])
    group = np.array([group_velocity(w, depth, 9.81) for w in some])
    factor = np.tanh(k * depth) ** 2 * some / (2 * k * group)  # c_g = w/2k (1 + 2kh/sinh 2kh)
    over = wave.density(some) / jonswap_spectrum(some, hs, tp, 3.3)
    assert over / over[-1] == pytest.approx(factor / factor[-1], rel=1e-9)


@pytest.mark.parametrize("seed", [0, 5])
def test_phases_are_uniform_and_those_of_the_seed(seed):
    wave = WhiteNoise(kind="white_noise", hs=2.0, band=(1.0, 3.5), seed=seed)
    found = wave.realisation(12.0, 300.0)
    turned = np.exp(2j * np.pi * np.random.default_rng(seed).random(len(found.omega)))
    assert found.amplitude / np.abs(found.amplitude) == pytest.approx(turned, abs=1e-12)


def direct(omega, phasors, time):
    """The same sum as it stands, phases to 64 bits."""
    angle = np.outer(time.astype(np.longdouble), omega.astype(np.longdouble))
    return np.asarray(np.cos(angle) @ phasors.real + np.sin(angle) @ phasors.imag, dtype=float)


def random_phasors(count, signals, seed=0):
    rng = np.random.default_rng(seed)
    return (rng.normal(size=(count, signals)) + 1j * rng.normal(size=(count, signals))) / np.sqrt(count)


@settings(max_examples=40)
@given(st.integers(1, 3 * FEW), st.integers(1, 700), st.floats(-50.0, 50.0), st.floats(1e-3, 2.0), st.booleans())
def test_sum_equals_direct_summation(components, instants, start, dt, even):
    """Few and many components, of one spacing and not, at any instants."""
    rng = np.random.default_rng(components)
    omega = np.linspace(0.3, 9.0, components) if even else np.sort(rng.uniform(0.1, 9.0, components))
    phasors, time = random_phasors(components, 3), start + dt * np.arange(instants)
    error = np.abs(superposed(omega, phasors, time) - direct(omega, phasors, time)).max()
    assert error < 1e-14 * (100 + 9.0 * np.abs(time).max())  # of the phase: omega t is rounded


def test_one_hour_of_a_sea_loses_no_digits():
    """7565 components at 100 000 instants; a sum as it stands would need 6 GB of cosines."""
    waves = Jonswap(kind="jonswap", hs=1.0, tp=6.0).realisation(12.0, 3600.0)
    time = np.linspace(0.0, 3600.0, 100_001)
    some = np.random.default_rng(1).integers(0, len(time), 50)
    found = superposed(waves.omega, waves.amplitude[:, None], time)[some]
    assert len(waves.omega) > 7000
    assert np.abs(found - direct(waves.omega, waves.amplitude[:, None], time[some])).max() < 1e-11


@pytest.mark.parametrize("depth", [np.inf, 12.0])
@pytest.mark.parametrize(
    "wave",
    [
        Jonswap(kind="jonswap", hs=2.0, tp=8.0),
        OchiHubble(
            kind="ochi_hubble", swell={"hs": 1.0, "tp": 12.0}, wind_sea={"hs": 1.5, "tp": 6.0, "peakedness": 2.0}
        ),
        WhiteNoise(kind="white_noise", hs=1.0, band=(0.5, 1.5)),
    ],
    ids=lambda wave: getattr(wave, "kind", None),
)
def test_energy_of_a_sea_is_that_of_a_climate_with_its_spectrum(wave, depth):
    """Two routes: moments of the sea's own bands, and a year that consists of this sea alone in even narrow bands."""
    water = Water(depth=depth)
    omega = np.arange(0.1, 30.0, 1e-2) + 5e-3
    year = Climate.of_spectra(omega, wave.density(omega)[None], np.ones(1), "one sea")
    found = wave.energy(water)
    assert found == pytest.approx((year.hs[0], year.te[0], year.flux(water)[0]), rel=2e-3)


SEAS = [
    RegularWave(kind="regular", amplitude=0.5, period=7.0),
    Jonswap(kind="jonswap", hs=1.0, tp=7.0),
    PiersonMoskowitz(kind="pierson_moskowitz", hs=1.0, tp=7.0),
    OchiHubble(kind="ochi_hubble", swell={"hs": 0.8, "tp": 7.0, "peakedness": 3.0}, wind_sea={"hs": 0.6, "tp": 3.0}),
    WhiteNoise(kind="white_noise", hs=1.0, band=(0.5, 1.5)),
]


@pytest.mark.parametrize("wave", SEAS, ids=lambda wave: wave.kind)
def test_direction_is_part_of_label_and_id(wave):
    turned = wave.model_copy(update={"direction": 45.0})
    assert '"direction":45.0' in canonical(turned)
    assert "_d45" in turned.label
    assert turned.label.replace("_d45", "") == wave.label
    assert turned.description == f"{wave.description} going to 45 degrees"
    back = wave.model_copy(update={"direction": -90.0})
    assert back.label.replace("_d-90", "") == wave.label != back.label
    assert back.description == f"{wave.description} going to -90 degrees"
    assert [type(wave).model_validate(one.model_dump()) for one in (wave, turned, back)] == [wave, turned, back]


@pytest.mark.parametrize("band", [(0.5, 1.5), (0.95, 1.05), (0.9, 1.1)])
def test_memory_is_ten_periods_or_two_beats_of_the_band(band):
    noise = WhiteNoise(kind="white_noise", hs=1.0, band=band)
    period, beat = 2 * math.pi / noise.omega, 2 * math.pi / (band[1] - band[0])
    assert noise.memory == pytest.approx(max(10 * period, 2 * beat))
    assert [wave.memory for wave in SEAS[1:4]] == pytest.approx([70.0, 70.0, 70.0])


def test_seeds_of_all_realisations_have_32_bits():
    assert Jonswap(kind="jonswap", hs=1.0, tp=7.0, seed=2**32 - 3, realisations=3).seed == 2**32 - 3
    with pytest.raises(ConfigError, match=r"seed of 10 digits: needs at most 2\^32 - realisations"):
        Jonswap(kind="jonswap", hs=1.0, tp=7.0, seed=2**32 - 2, realisations=3)


def test_swell_is_longer_than_the_wind_sea():
    with pytest.raises(ConfigError, match=r"swell.tp 4 s: needs more than that of the wind sea, 5 s"):
        OchiHubble(kind="ochi_hubble", swell={"hs": 1.0, "tp": 4.0}, wind_sea={"hs": 1.0, "tp": 5.0})


PLANAR = {"motion": "planar", "mooring": [2e4, 0, 0, 0, 0, 0], "modes": {"basis": "membrane", "degree": 2}}


def spread(s, directions=9, **keys):
    return Jonswap(kind="jonswap", hs=1.0, tp=5.0, spreading={"s": s, "directions": directions}, **keys)


@pytest.mark.parametrize(("s", "count"), [(1.0, 9), (10.0, 9), (75.5, 4), (1e4, 15)])
def test_directions_have_equal_energy(s, count):
    """sin^2 of a quarter turn and half the angle is Beta(s + 1/2, s + 1/2)-distributed for cos^2s(angle/2)."""
    shares = (np.arange(count) + 0.5) / count
    exact = 2 * np.arcsin(2 * betaincinv(s + 0.5, s + 0.5, shares) - 1)
    assert np.array(Spreading(s=s, directions=count)._middles) == pytest.approx(exact, abs=2e-4 * abs(exact).max())


@pytest.mark.parametrize("s", [1.0, 2.5, 10.0, 75.5, 1e4])
@pytest.mark.parametrize("count", [2, 3, 4, 6, 7, 9, 36])
def test_directions_have_the_moments_of_their_law(s, count):
    """E cos m theta = Gamma(s + 1)^2/(Gamma(s + 1 + m) Gamma(s + 1 - m)); E cos^2 theta is the power of surge."""
    found = np.radians(Spreading(s=s, directions=count).angles)
    assert np.all(np.diff(found) > 0)
    assert found == pytest.approx(-found[::-1], abs=1e-12)
    moments = {1: s / (s + 1), 2: s * (s - 1) / ((s + 1) * (s + 2))}
    for m in (1, 2) if count >= 7 else (2,):
        assert np.mean(1 - np.cos(m * found)) == pytest.approx(1 - moments[m], rel=1e-9)


def test_energy_is_that_of_the_long_crested_sea_and_shared_by_the_directions():
    """Amplitudes and phases do not change; each direction has a ninth of the energy of any part of the spectrum."""
    long, short = (wave.realisation(6.0, 1200.0) for wave in (Jonswap(kind="jonswap", hs=1.0, tp=5.0), spread(10.0)))
    assert long.heading is None
    assert np.array_equal(long.amplitude, short.amplitude)
    squares = np.abs(short.amplitude) ** 2
    for low, high, within in ((0.0, 6.0, 0.01), (1.1, 1.4, 0.03)):
        inside = (short.omega >= low) & (short.omega < high)
        shares = [squares[inside & (short.heading == one)].sum() for one in np.unique(short.heading)]
        assert len(shares) == 9
        assert np.array(shares) / sum(shares) == pytest.approx(np.full(9, 1 / 9), abs=within)
    again, other = spread(10.0).realisation(6.0, 1200.0), spread(10.0, seed=2).realisation(6.0, 1200.0)
    assert np.array_equal(short.heading, again.heading)
    assert not np.array_equal(short.heading, other.heading)


def test_excitation_of_every_component_is_that_of_its_direction():
    sea = spread(4.0, direction=20.0).realisation(6.0, 300.0)
    going = heading_in(spread(4.0, direction=20.0), sea)
    orders = np.array([0, 1, -1, 2])
    found = going.shares(orders, sea.omega)
    assert isinstance(going, Directions)
    for k in (0, 17, len(sea.omega) - 1):
        assert found[k] == pytest.approx(heading_shares(orders, np.radians(sea.heading[k])))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motion": "heave", "mooring": None}, "spreading: a buoy of revolution that heaves answers"),
        ({"drag": {"surge": {"coefficient": 1.0, "area": 1.0}}}, "spreading: drag is past the flow of waves of one"),
    ],
)
def test_spreading_is_refused_where_it_says_nothing_or_is_not_known(changes, message):
    raw = load(SEED).model_dump() | PLANAR | {"waves": [spread(10.0).model_dump()]} | changes
    raw["device"] |= {"centre_of_mass": -0.6, "ballast_inertia": 9e3}
    raw["hydro"] |= {"omega_max": 6.0, "witness": "none"}
    with pytest.raises(ConfigError, match=message):
        parse(raw)


def test_a_sea_without_spreading_is_written_as_before():
    wave = Jonswap(kind="jonswap", hs=1.0, tp=5.0)
    assert "spreading" not in wave.model_dump()
    assert (wave.label, spread(10.0).label) == ("jonswap_Hs1_Tp5_g3.3_s1", "jonswap_Hs1_Tp5_g3.3_s10x9_s1")


def test_bodies_know_the_directions_of_their_database_alone():
    raw = {"study": "b", "body": {"database": "b.nc"}, "designs": {"one": {}}, "waves": [spread(10.0).model_dump()]}
    with pytest.raises(ConfigError, match=r"waves\.0\.spreading: the database of a body holds the directions"):
        validated(BodyStudy, raw, "b.yaml")
