"""Seas beyond linear waves and small motions."""

import numpy as np
import pytest
from results.test_year import climate, port

from vsb.results.validity import motion_limits, rms, stroke_rms, wave_limits
from vsb.results.year import frequencies
from vsb.study.study import Water
from vsb.waves.scatter import climate_of_cells

SEAS = climate_of_cells(np.array([1.0, 4.0, 6.0]), np.array([9.0, 7.0, 6.5]), np.array([0.5, 0.3, 0.2]), 3.3, "three")


def test_steep_and_breaking_seas_in_deep_water():
    """Hs over g Te^2/(2 pi): 0.0079, 0.0523, 0.0910; the highest wave of the last is 0.169 of its length."""
    steep, breaking = wave_limits(SEAS, Water())
    assert steep.seas.tolist() == [False, True, True]
    assert breaking.seas.tolist() == [False, False, True]
    assert steep.largest == pytest.approx(6.0 * 2 * np.pi / (9.81 * 6.5**2), rel=1e-9)
    assert breaking.largest == pytest.approx(1.86 * steep.largest / 0.142, rel=1e-9)
    assert steep.energy(np.array([1.0, 10.0, 20.0]), SEAS.hours) == pytest.approx(7.0 / 7.5)
    assert steep.energy(np.zeros(3), SEAS.hours) == 0.0


def test_shallow_water_breaks_waves():
    """Miche's limit goes over into 0.89 of the depth."""
    breaking = wave_limits(SEAS, Water(depth=0.2))[1]
    assert breaking.seas.tolist() == [True, True, True]
    assert breaking.largest == pytest.approx(1.86 * 6.0 / (0.142 * 2 * np.pi * 0.2), rel=0.01)


def test_root_mean_square_of_a_flat_response_is_that_of_the_waves():
    seas = climate()
    grid = np.linspace(0.2, 2.4, 500)
    assert rms(seas, grid, np.full(500, 4.0)) == pytest.approx(2 * np.sqrt(seas.variance), rel=1e-12)


def test_a_body_much_stiffer_than_its_mass_rides_little():
    """Below resonance the stroke is excitation over stiffness."""
    seas = climate()
    grid = frequencies(seas, 0.1, 4.0)
    stiff = port(grid, mass=1.0, loss=1.0, stiffness=1e8)
    excitation = 5e4 / (1 + grid**2)
    assert stroke_rms(stiff, seas, 1.0) == pytest.approx(rms(seas, grid, (excitation / 1e8) ** 2), rel=1e-6)


def test_motions_beyond_their_limits():
    heave, deformation = motion_limits({"heave": np.array([0.1, 0.2]), "deformation": np.array([0.05, 0.06])}, 2.0)
    assert heave.seas.tolist() == [False, True]
    assert deformation.seas.tolist() == [False, True]
    assert heave.largest == pytest.approx(0.372)
