"""The budget of a gain: power by sea, and years drawn from one year."""

import numpy as np
import pytest
from design.conftest import study_of

from vsb.design.compared import Buoy, displacement_held, gain_of_years, power_of_seas
from vsb.design.evaluation import DesignModel
from vsb.waves.climate import Climate


def test_powers_of_seas_add_up_to_the_year():
    omega = np.linspace(0.5, 1.7, 7)
    density = np.array([np.exp(-(((omega - peak) / 0.2) ** 2)) for peak in (0.7, 0.9, 1.3)])
    seas = Climate.of_spectra(omega, density, np.array([0.5, 0.3, 0.2]), "three seas")
    study = study_of(modes={"basis": "full", "degree": 2})
    for design in ("FSB", "VSWEC"):
        found = DesignModel.of(study, design, seas, []).at([])
        buoy = Buoy(design, study, design, 2, {name: one.value for name, one in found.quantities.items()})
        powers = power_of_seas(buoy, seas)
        assert powers.shape == (3,)
        assert seas.hours @ powers == pytest.approx(buoy.power, rel=1e-12)


def test_years_drawn_keep_a_gain_that_is_the_same_in_every_sea():
    rigid = np.random.default_rng(1).uniform(1.0, 5.0, 500)
    years = gain_of_years(1.1 * rigid, rigid, np.full(500, 1 / 500))
    assert years == pytest.approx(np.full(len(years), 10.0))


def test_scatter_of_years_of_independent_seas_is_that_of_their_mean():
    """Blocks of independent seas: the variance of the ratio of means by the delta method."""
    random = np.random.default_rng(2)
    rigid = random.uniform(1.0, 3.0, 4000)
    flexible = rigid * (1 + 0.2 * random.normal(size=4000))
    years = gain_of_years(flexible, rigid, np.full(4000, 1 / 4000))
    expected = 100 * np.std(flexible - flexible.mean() / rigid.mean() * rigid) / rigid.mean() / np.sqrt(4000)
    assert np.std(years) == pytest.approx(expected, rel=0.15)


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
