"""The band of useful frequencies and the extremes of gains in it."""

import numpy as np
import pytest
import xarray as xr

from vsb.report.band import LOWEST, USEFUL, gain_band, useful_band, with_extremes


def test_any_design_makes_a_frequency_useful_above_the_lowest():
    omega = np.array([0.2, 0.5, 1.0, 1.5, 2.0])
    power = [[100.0, 1.0, 100.0, 1.0, 4.9], [100.0, 1.0, 1.0, 5.1, 1.0]]
    absorbed = xr.DataArray(power, dims=("design", "omega"), coords={"omega": omega})
    assert (LOWEST, USEFUL) == (0.3, 0.05)
    assert useful_band(absorbed).values.tolist() == [False, False, True, True, False]


NARROW = 3e-3
"""Half width of a resonance, a third of the step of a grid [rad/s]."""


def resonant(omega):
    """A rigid design of a broad hump, and one that absorbs 6.36 times as much at 1.0437 rad/s, 0.2 at 1.6181."""
    rigid = 50.0 / (1 + (omega - 1.3) ** 2)
    peak, dip = (1 / (1 + ((omega - at) / NARROW) ** 2) for at in (1.0437, 1.6181))
    values = [rigid, rigid * (1 + 6.36 * peak) * (1 - 0.8 * dip)]
    return xr.DataArray(values, dims=("design", "omega"), coords={"design": ["FSB", "A"], "omega": omega})


def test_extremes_between_grid_frequencies_are_found():
    """In closed form +636 % and -80 %; the grid itself shows less than half of the first."""
    omega = np.arange(0.5, 2.5, 0.01)
    found = resonant(with_extremes(resonant, omega, "FSB"))
    gain, coarse = (100 * (p.sel(design="A") / p.sel(design="FSB") - 1) for p in (found, resonant(omega)))
    assert float(coarse.max()) < 300
    assert (float(gain.max()), float(gain.min())) == pytest.approx((636.0, -80.0), abs=0.7)
    assert float(gain.idxmax("omega")) == pytest.approx(1.0437, abs=1e-4)
    assert set(omega) <= set(found.omega.values)
    assert found.sizes["omega"] < len(omega) + 120


def falling(omega):
    """A rigid design whose power ends, and a gain that grows until it does: exp(2 omega) - 1 over 1/(1 + exp)."""
    rigid = 1 / (1 + np.exp(40 * (omega - 1.0)))
    values = [rigid, rigid * np.exp(2 * omega)]
    return xr.DataArray(values, dims=("design", "omega"), coords={"design": ["FSB", "A"], "omega": omega})


def test_gain_at_the_end_of_its_band_is_found():
    omega = np.arange(0.3, 1.5, 0.037)
    power = falling(with_extremes(falling, omega, "FSB"))
    inside = power.omega.values[gain_band(power, "FSB").values]
    end = inside.max()
    fine = falling(np.linspace(end - 0.05, end + 0.05, 200001))
    best, rigid = fine.max("design"), fine.sel(design="FSB")
    ends = (best >= USEFUL * power.max("design").max()) & ((rigid >= USEFUL * 1.0) | (rigid >= 0.1 * best))
    exact = float(fine.omega.values[ends.values].max())
    assert np.exp(2 * end) == pytest.approx(np.exp(2 * exact), rel=2e-3)
