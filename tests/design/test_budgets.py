"""Buoys compared, and budgets of their powers and gains: power by sea, years drawn, what cancels, waves not solved."""

from dataclasses import replace

import numpy as np
import pytest
from design.conftest import study_of

from vsb.design import take_offs
from vsb.design.budgets import PowerParts, drawn_years, power_of_seas, power_parts, uncertainty
from vsb.design.compared import Buoy, displacement_held, gain
from vsb.design.evaluation import DAMPER, DesignModel
from vsb.design.problem import POWER
from vsb.engine.motion.causal import RmsLimits
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.engine.waves.seas import RESOLVED
from vsb.results.budget import MODES


def buoy_of(study, design, climate, degree=2):
    found = DesignModel.of(study, design, climate, [], degree).at([])
    return Buoy(design, study, design, degree, {name: one.value for name, one in found.quantities.items()})


def test_powers_of_seas_add_up_to_the_year():
    omega = np.linspace(0.5, 1.7, 7)
    density = np.array([np.exp(-(((omega - peak) / 0.2) ** 2)) for peak in (0.7, 0.9, 1.3)])
    seas = Climate.of_spectra(omega, density, np.array([0.5, 0.3, 0.2]), "three seas")
    study = study_of(modes={"basis": "full", "degree": 2})
    for design in ("FSB", "VSWEC"):
        found = DesignModel.of(study, design, seas, []).at([])
        buoy = Buoy(design, study, design, 2, {name: one.value for name, one in found.quantities.items()})
        powers = power_of_seas(buoy, buoy.model(seas), seas)
        assert powers.shape == (3,)
        assert seas.hours @ powers == pytest.approx(buoy.power, rel=1e-12)


def test_years_drawn_keep_a_gain_that_is_the_same_in_every_sea():
    rigid = np.random.default_rng(1).uniform(1.0, 5.0, 500)
    years = gain(*(drawn_years(power, np.full(500, 1 / 500)) for power in (1.1 * rigid, rigid)))
    assert years == pytest.approx(np.full(len(years), 10.0))


def test_scatter_of_years_of_independent_seas_is_that_of_their_mean():
    """Blocks of independent seas: the variance of the ratio of means by the delta method."""
    random = np.random.default_rng(2)
    rigid = random.uniform(1.0, 3.0, 4000)
    flexible = rigid * (1 + 0.2 * random.normal(size=4000))
    years = gain(*(drawn_years(power, np.full(4000, 1 / 4000)) for power in (flexible, rigid)))
    expected = 100 * np.std(flexible - flexible.mean() / rigid.mean() * rigid) / rigid.mean() / np.sqrt(4000)
    assert np.std(years) == pytest.approx(expected, rel=0.15)


def test_what_two_buoys_share_is_in_their_powers_and_not_in_their_gain():
    """Twins with one power under every error: the gain is certain, and the power as uncertain as either."""
    years = np.random.default_rng(3).normal(9e3, 500.0, 2000)
    one = PowerParts(9e3, (-0.01, 0.02), 9.02e3, 9.05e3, 0.0, years, {"device.radius": 2.0})
    inputs = {"device.radius": 0.01}
    of_gain, of_power = uncertainty([one, replace(one, truncation=(0.0, 0.0))], inputs), uncertainty([one], inputs)
    assert {source.name for source in of_gain.budget.sources if source.high > 1e-5} == {MODES}
    assert (of_gain.budget.low, of_gain.budget.high) == pytest.approx((-1.0, 2.0), rel=1e-5)
    low, high = of_power.budget.low, of_power.budget.high
    assert -low == pytest.approx(90 + 2 * 20 + 2 * 50 + 1.96 * 0.01 * 2.0 * 9e3)
    assert high == pytest.approx(180 + 2 * 20 + 2 * 50 + 1.96 * 0.01 * 2.0 * 9e3)
    assert uncertainty([replace(one, truncation=None)]).unknown[0] == MODES


def test_an_interval_under_causal_control_at_several_ports_holds_the_power_on_a_finer_grid(monkeypatch):
    """With half the spacing the power happens to change by a fifth of what it does with a quarter."""
    omega = np.linspace(0.3, 3.0, 55)
    density = jonswap_spectrum(omega, 1.0, 5.74, 1.0)[None]
    seas, limit = Climate.of_spectra(omega, density, np.ones(1), "waves of 5.7 s"), RmsLimits(8.88e4)
    pto = {"ports": {"h": "heave", "r": {"colatitude": 120}}, "matrix": "diagonal"}
    study, found = study_of(pto=pto, device={"young_modulus": 7.36e7}), []
    for spacing in (RESOLVED / 1.6, RESOLVED / 0.4):
        monkeypatch.setattr(take_offs, "RESOLVED", spacing)
        found.append(DesignModel.of(study, "VSWEC", seas, [], control=limit).at([])[POWER].value)
    fine, coarse = found
    parts = power_parts(Buoy("VSWEC", study, "VSWEC", 4, {POWER: coarse}, control=limit), seas)
    low, high = uncertainty([parts]).budget.interval(coarse)
    assert low < fine < high
    assert uncertainty([parts, parts]).budget.high < 1e-5


@pytest.mark.parametrize(("maximise", "of"), [("power_per_mass", "mass"), ("power_per_cost", "cost")])
def test_a_quotient_has_the_errors_of_the_power_and_those_of_its_divisor_by_inputs(climate, maximise, of):
    """Thickness changes the power alone; of the mass a per cent more is a per cent less of the quotient."""
    study, inputs = study_of(reference_shape="undeformed"), ["device.mass", "device.thickness", "device.radius"]
    cost = {"mass": 4.0, "surface": 100.0}
    model = replace(DesignModel.of(study, "VSWEC", climate, [], 2), cost=cost)
    quantities = {name: one.value for name, one in model.at([]).quantities.items()}
    buoy = Buoy("VSWEC", study, "VSWEC", 2, quantities, (-0.01, 0.02))
    power, found = (power_parts(buoy, climate, inputs, **more) for more in ({}, {"maximise": maximise, "cost": cost}))
    assert found.power == pytest.approx(power.power / quantities[of], rel=1e-12)
    assert found.finer / found.power == pytest.approx(power.finer / power.power, rel=1e-9)
    rate = {"mass": 1.0, "cost": 4.0 * quantities["mass"] / quantities["cost"]}[of]
    assert found.slopes["device.mass"] == pytest.approx(power.slopes["device.mass"] - rate, rel=1e-7)
    both = [uncertainty([one], {"device.mass": 0.01}).budget.interval(one.power) for one in (power, found)]
    assert (both[1][1] - found.power) / found.power > (both[0][1] - power.power) / power.power > 0.02
    if of == "mass":
        assert found.slopes["device.radius"] == pytest.approx(power.slopes["device.radius"], rel=1e-9)


def test_other_years_are_said_beside_an_interval_and_not_in_it():
    """The power is the mean over the year of the file, as a campaign's, whose interval is of its errors alone."""
    years = np.linspace(8000.0, 10200.0, 2001)
    one = PowerParts(9e3, (0.0, 0.0), 9e3, 9e3, 0.0, years, {})
    known = uncertainty([one])
    assert known.unknown == ("the year as a sample (-945 to +1.14e+03 W in 95 % of years like it)",)
    assert known.budget.high < 1.0
    assert uncertainty([replace(one, years=None)]).unknown == (
        "the year as a sample (a table has no order of its seas)",
    )


def test_waves_above_the_frequencies_solved_widen_a_power_by_the_most_they_hold():
    """Deep water, density S in [a, b] above the band: rho g^3 S/4 (1/a^2 - 1/b^2) by the capture width 1/k."""
    omega, density = np.array([0.8, 1.2, 1.6]), np.array([[0.4, 0.6, 0.2]])
    seas = Climate.of_spectra(omega, density, np.ones(1), "three bands")
    study = study_of(modes={"basis": "full", "degree": 2}, hydro={"omega_max": 1.5})
    parts = power_parts(buoy_of(study, "FSB", seas), seas)
    assert parts.unsolved == pytest.approx(1025 * 9.81**3 * 0.2 / 4 * (1.5**-2 - 1.8**-2), rel=1e-6)
    whole = study_of(modes={"basis": "full", "degree": 2}, hydro={"omega_max": 4.0})
    damper = {DAMPER: buoy_of(study, "FSB", seas).quantities["damping"]}
    more = DesignModel.of(whole, "FSB", seas, [*damper]).at([*damper.values()])[POWER].value
    assert parts.power < more < parts.power + parts.unsolved


@pytest.mark.slow
def test_the_interval_of_a_profile_holds_the_power_of_the_curve_its_points_are_of():
    """Eleven points of a spheroid: through them go the spline that is solved, and the spheroid."""
    omega, density = np.array([0.8, 1.2, 1.6]), np.array([[0.4, 0.6, 0.0]])
    seas = Climate.of_spectra(omega, density, np.ones(1), "two bands")
    phi = np.linspace(0.0, np.pi, 11)
    points = [[float(2 * np.sin(at)) if 0 < at < np.pi else 0.0, float(1.4 * np.cos(at))] for at in phi]
    device = {"internal_pressure": None}

    def power(shape):
        return buoy_of(study_of(device=device | {"shape": shape}, reference_shape="undeformed"), "FSB", seas)

    buoy, truth = power({"profile": points}), power({"spheroid": {"height": 2.8}}).power
    low, high = uncertainty([power_parts(buoy, seas)]).budget.interval(buoy.power)
    assert abs(truth - buoy.power) > 1e-6 * buoy.power
    assert low <= truth <= high


def test_a_spring_below_zero_holds_a_sphere_it_has_lifted_far_enough():
    """Sphere of radius 1 m with its centre 0.25 m above the water: 0 = rho g (V(d) - V(d - s)) + k s of a spherical cap.

    A weak spring holds it where its pull is all the weight; one of 0.9 of the waterplane's stiffness, still in the
    water. Upside down, as much above the water as it had below, it is held as far below.
    """
    colatitude, draft, weight_density = np.linspace(0.0, np.pi, 2001), 0.75, 1025.0 * 9.81

    def volume(depth: float) -> float:
        return np.pi * depth**2 * (3 - depth) / 3

    for centre in (1 - draft, draft - 1):
        sphere = np.sin(colatitude), np.cos(colatitude) + centre
        weak = -weight_density * volume(draft) / 10.0
        assert displacement_held(sphere, 1025.0, 9.81, weak) == pytest.approx(10.0, rel=1e-3)
        strong = -0.9 * weight_density * np.pi * draft * (2 - draft)
        moved = displacement_held(sphere, 1025.0, 9.81, strong)
        assert weight_density * (volume(draft) - volume(draft - moved)) == pytest.approx(-strong * moved, rel=1e-3)
        assert 0 < moved < draft
    assert displacement_held(sphere, 1025.0, 9.81, 0.0) == np.inf
