"""Figures of merit of a run: ranges of motion, absorbed power and energy, capture width."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.errors import ConfigError
from vsb.study.study import RegularWave, Water, Wave
from vsb.tools.units import FloatArray
from vsb.waves.seas import Sea, group_velocity


class Merit(NamedTuple):
    """What one design does in one sea."""

    displacement_pp: float  # heave, highest to lowest in the window [m]
    velocity_pp: float  # heave velocity, likewise [m/s]
    power_peak: float  # largest absorbed power in the window [W]
    power_mean: float  # over whole wave periods at the end of the window [W]
    energy: float  # absorbed over the whole run [J]
    capture_width: float | None  # mean power over the energy flux of the sea [m]; none in still water


def energy_flux(sea: Sea, water: Water) -> float:
    """Return the energy flux of a sea per metre of crest, sum rho g |a|^2 v_g/2 [W/m]."""
    speed = np.array([group_velocity(w, water.depth, water.gravity) for w in sea.omega])
    return float(0.5 * water.density * water.gravity * np.sum(np.abs(sea.amplitude) ** 2 * speed))


def averaging_window(wave: Wave, window: tuple[float, float]) -> tuple[float, float]:
    """Return the part of the window means are taken over [s]: as many whole periods as fit, at its end (C8)."""
    start, end = window
    if not isinstance(wave, RegularWave) or end - start < wave.period:
        return start, end
    return end - np.floor((end - start) / wave.period + 1e-9) * wave.period, end


def merit(run: xr.Dataset, wave: Wave, sea: Sea, water: Water, window: tuple[float, float]) -> Merit:
    """Return the figures of merit of a run (see `vsb.integrators.trajectory.labelled`)."""
    time = run.time.values
    inside = (time >= window[0] - 1e-9) & (time <= window[1] + 1e-9)
    if not inside.any():
        raise ConfigError(
            f"simulation.window: received {list(window)} s, which holds none of the instants recorded, "
            f"{time[1] - time[0]:.4g} s apart; needs to be longer than that"
        )
    heave, velocity = run.position.values[inside, 0], run.velocity.values[inside, 0]
    absorbed: FloatArray = run.energy.sel(term="pto").values
    force = run.pto.values[inside, 0] if "pto" in run else np.zeros_like(velocity)
    start, end = averaging_window(wave, window)
    gained = np.diff(CubicSpline(time, absorbed)([start, end]))[0]
    mean = float(gained / (end - start))
    flux = energy_flux(sea, water)
    return Merit(
        float(np.ptp(heave)),
        float(np.ptp(velocity)),
        float(np.max(-force * velocity)) + 0.0,  # no negative zero
        mean,
        float(absorbed[-1]) + 0.0,
        mean / flux if flux else None,
    )
