"""What knowledge of the waves is worth: power under causal control over seconds of forecast, and over noise."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.motion.causal import RmsLimits, StationaryPort, optimum
from vsb.motion.tuning import damper_within_force, mean_power
from vsb.scenes.floating_system import FloatingSystem, InSeas, expected_sea, port_in_seas
from vsb.scenes.stationary import rms_limits, stationary_ports
from vsb.study.take_off import Pto
from vsb.study.waves import Irregular
from vsb.tools.arrays import FloatArray

FORECASTS = (0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0)
"""Forecasts over the period of the sea's peak [-]."""
NOISES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Densities of the noise over the peak of that of the waves' force [-]."""


class _Control(NamedTuple):
    """A port in a sea, the rms values it is controlled within, and what of the sea could be absorbed."""

    port: StationaryPort
    limits: RmsLimits
    pto: Pto
    matched: float  # [W]

    def power(self, noise: float, forecast: float) -> float:
        """Mean power of the controller [W]."""
        best = optimum(self.port, self.limits, noise, forecast, self.pto.efficiency)
        return self.matched * best.converted(self.pto.efficiency) / self.port.matched_power


def worth_of_knowledge(study: InSeas, floating: FloatingSystem, wave: Irregular) -> xr.Dataset:
    """Return mean powers in a sea under causal control, at the rms force of the control level `causal`.

    Returns
    -------
    xarray.Dataset
        `over_forecast(design, forecast)` with the noise of the study, forecasts in s, `over_noise(design, noise)` with
        its forecast, `known_future(design)` and `damper(design)`, the best damper of the same rms force [W].
    """
    pto, sea = study.pto, expected_sea(study, wave, floating.linear.database)
    ports, forecasts = stationary_ports(floating, wave, sea), np.array(FORECASTS) * 2 * np.pi / wave.omega
    found: dict[str, list[FloatArray]] = {"over_forecast": [], "over_noise": [], "known_future": [], "damper": []}
    designs = []
    for design, port in ports.items():
        seen, squares, _ = port_in_seas(floating, design, [(wave, sea)])
        if not seen.moves:
            continue
        limits = rms_limits(floating, design, pto, wave, sea)
        damper = damper_within_force(seen, squares, limits.force, pto.stiffness, pto.efficiency)
        absorbed = float(mean_power(seen, squares, damper.damping, damper.stiffness, pto.efficiency)[0])
        control = _Control(port, limits, pto, float(squares[0] @ seen.matched_power))
        found["over_forecast"].append(np.array([control.power(pto.control.noise, t) for t in forecasts]))
        found["over_noise"].append(np.array([control.power(noise, pto.control.forecast) for noise in NOISES]))
        found["known_future"].append(np.array(control.power(0.0, np.inf)))
        found["damper"].append(np.array(absorbed))
        designs.append(design)
    dims = {"over_forecast": ("design", "forecast"), "over_noise": ("design", "noise")}
    return xr.Dataset(
        {name: (dims.get(name, ("design",)), np.array(values)) for name, values in found.items()},
        {"design": designs, "forecast": forecasts, "noise": np.array(NOISES)},
    )
