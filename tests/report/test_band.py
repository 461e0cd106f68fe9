"""The band that counts: where some design absorbs a twentieth of the most, and waves are seas."""

import numpy as np
import xarray as xr

from vsb.report.band import LOWEST, USEFUL, lowest, useful_band


def test_any_design_makes_a_frequency_useful_and_too_long_waves_none():
    omega = np.array([0.2, 0.5, 1.0, 1.5, 2.0])
    power = [[100.0, 1.0, 100.0, 1.0, 4.9], [100.0, 1.0, 1.0, 5.1, 1.0]]
    absorbed = xr.DataArray(power, dims=("design", "omega"), coords={"omega": omega})
    assert (LOWEST, USEFUL) == (0.3, 0.05)
    assert useful_band(absorbed).values.tolist() == [False, False, True, True, False]


def test_the_bounds_of_the_band_are_part_of_it():
    """Waves of just 0.3 rad/s are seas, a twentieth of the most is of use; half of a band must be of seas."""
    absorbed = xr.DataArray(
        [[5.0, 100.0, 4.99], [0.0, 0.0, 0.0]], dims=("design", "omega"), coords={"omega": [0.3, 1, 2]}
    )
    assert useful_band(absorbed).values.tolist() == [True, True, False]
    assert (lowest(0.1, 0.6), lowest(0.1, 0.599), lowest(0.5, 0.599)) == (0.3, 0.1, 0.5)
