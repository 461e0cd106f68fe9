"""What knowledge is worth to a controller: seconds of forecast, less noise, and the sea it is tuned in."""

import contextlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.motion.causal import Controlled, RmsLimits, StationaryPort, optimum
from vsb.engine.motion.controller import achieved
from vsb.engine.motion.take_off import Pto
from vsb.engine.motion.tuning import damper_within_force, mean_power
from vsb.engine.waves.kinds import Irregular, PeakedSea, Wave
from vsb.errors import VsbError
from vsb.models.floating_system import FloatingSystem, InSeas, expected_sea, port_in_seas
from vsb.models.stationary import rms_limits, stationary_ports
from vsb.tools.arrays import ComplexArray, FloatArray

FORECASTS = (0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0)
"""Forecasts over the period of the sea's peak [-]."""
NOISES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Densities of the noise over the peak of that of the waves' force [-]."""


PERIODS = (0.7, 0.85, 1.0, 1.2, 1.5)
"""Peak periods of the seas a controller is run in, over that of the sea it is tuned in [-]."""
LEFT_OUT = 0.05
"""Part of a sea beyond the frequencies of the coefficients with which a controller is not run in it."""


class Elsewhere(NamedTuple):
    """A causal controller in a sea that it is not tuned in, and one that is tuned in it."""

    design: str
    sea: str  # it is tuned in
    period: float  # of the peak of the sea it is run in [s]
    power: float  # [W]
    force_rms: float  # [N]
    own_power: float  # of the one tuned there [W]
    own_force_rms: float  # [N]


def elsewhere(study: InSeas, floating: FloatingSystem, waves: Sequence[Wave]) -> list[Elsewhere]:
    """Return what causal controllers absorb by linear theory in seas of the same height and other peak periods.

    Each keeps the rms force of the level `causal` in its own sea, and has no forecast. It stays stable: its loop is
    that of the same port. Seas without a peak period of their own, as records, have no lines.
    """
    pto, noise, found = study.pto, study.pto.control.noise, []
    for wave in waves:
        if not isinstance(wave, PeakedSea):
            continue
        seas = [wave.model_copy(update={"tp": factor * wave.tp}) for factor in PERIODS]
        seas = [one for one in seas if one.share_above(floating.band[1]) < LEFT_OUT]
        tuned: dict[tuple[str, float], tuple[StationaryPort, ComplexArray, Controlled]] = {}
        for one in seas:
            sea = expected_sea(study, one, floating.linear.database)
            for design, port in stationary_ports(floating, one, sea).items():
                with contextlib.suppress(VsbError):  # no control keeps the stroke
                    seen, squares, _ = port_in_seas(floating, design, [(one, sea)])
                    limits = rms_limits(pto, seen, squares[0])
                    best = optimum(port, limits, noise, 0.0, pto.efficiency)
                    if best.power > 0:
                        tuned[design, one.tp] = port, port.controller(best.weights, noise), best
        for (design, period), (port, own, best) in tuned.items():
            if (design, wave.tp) not in tuned:
                continue
            home, gain, _ = tuned[design, wave.tp]
            there = achieved(port, np.interp(port.omega, home.omega, gain), noise)
            power, force = np.divide(there, achieved(port, own, noise))  # what their grids leave out is alike
            reached = float(power) * best.power, float(force) * best.force_rms, best.power, best.force_rms
            found.append(Elsewhere(design, wave.family, period, *reached))
    return found


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
        limits = rms_limits(pto, seen, squares[0])
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
