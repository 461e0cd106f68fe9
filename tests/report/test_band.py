"""The band that counts: where some design absorbs a twentieth of the most, and waves are seas."""

import numpy as np
import xarray as xr

from vsb.report.band import LOWEST, USEFUL, useful_band


def test_any_design_makes_a_frequency_useful_and_too_long_waves_none():
    omega = np.array([0.2, 0.5, 1.0, 1.5, 2.0])
    power = [[100.0, 1.0, 100.0, 1.0, 4.9], [100.0, 1.0, 1.0, 5.1, 1.0]]
    absorbed = xr.DataArray(power, dims=("design", "omega"), coords={"omega": omega})
    assert (LOWEST, USEFUL) == (0.3, 0.05)
    assert useful_band(absorbed).values.tolist() == [False, False, True, True, False]
