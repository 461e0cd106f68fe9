"""Figures of merit of a run: ranges of motion, absorbed power and energy, capture width."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.errors import ConfigError
from vsb.motion.bodies import direction_index
from vsb.scenes.build import TUNED
from vsb.study.study import BaseStudy, RegularWave, StillWater, Water, Wave
from vsb.tools.arrays import FloatArray
from vsb.waves.dispersion import group_velocity
from vsb.waves.seas import Sea

NOTHING = 1e-9
"""Mean power that is none [W]."""


class Merit(NamedTuple):
    """What one design does in one sea."""

    displacement_pp: float  # heave, of a body its port, highest to lowest in the window [m]
    velocity_pp: float  # its velocity, likewise [m/s]
    power_peak: float  # largest absorbed power in the window [W]
    power_mean: float  # over whole wave periods at the end of the window [W]
    energy: float  # absorbed over the whole run [J]
    capture_width: float | None  # mean power over the energy flux of the sea [m]; none in still water


def energy_flux(sea: Sea, water: Water) -> float:
    """Return the energy flux of a sea per metre of crest, sum rho g |a|^2 v_g/2 [W/m]."""
    speed = np.array([group_velocity(w, water.depth, water.gravity) for w in sea.omega])
    return float(0.5 * water.density * water.gravity * np.sum(np.abs(sea.amplitude) ** 2 * speed))


def apart(mean: float, expected: float) -> float:
    """Return by how much a mean power differs from the one expected, relative [-]; of `NOTHING` expected, its size [W].

    Two powers of round-off, as of bodies held together or of waves that reach both alike, are no doubt of each other.
    """
    return abs(mean / expected - 1) if abs(expected) > NOTHING else abs(mean)


def averaging_window(wave: Wave, window: tuple[float, float]) -> tuple[float, float]:
    """Return the part of the window means are taken over [s]: as many whole periods as fit, at its end (C8)."""
    start, end = window
    if not isinstance(wave, RegularWave) or end - start < wave.period:
        return start, end
    return end - np.floor((end - start) / wave.period + 1e-9) * wave.period, end


def damper_of(study: BaseStudy, design: str, run: Mapping[str, Any]) -> float:
    """Return the damper of a design in a run, by its attributes: given or tuned [N s/m]."""
    return float(run.get(TUNED, study.pto.damper(design) or 0.0))


def in_direction(response: xr.Dataset, wave: Wave) -> xr.Dataset:
    """Return the frequency response in the direction of a sea; a buoy has one for all, in still water any will do.

    Raises
    ------
    ConfigError
        If the response is of other directions.
    """
    if "wave_direction" not in response.dims:
        return response
    if isinstance(wave, StillWater):
        return response.isel(wave_direction=0)
    place = direction_index(response.wave_direction.values, float(np.deg2rad(wave.direction)))
    if place is None:
        known = ", ".join(f"{each:g}" for each in np.degrees(response.wave_direction.values))
        raise ConfigError(f"wave_direction: received {wave.direction:g} degrees, needs one of {known}")
    return response.isel(wave_direction=place)


def power_response(study: BaseStudy, response: xr.Dataset, design: str, run: Mapping[str, Any]) -> xr.DataArray:
    """Return the mean power that linear theory gives the take-off of a run, per squared wave amplitude [W/m^2].

    Parameters
    ----------
    study : Study
    response : xarray.Dataset
        The frequency response of the study.
    design : str
    run : mapping
        Attributes of a run of the design.

    Returns
    -------
    DataArray, dims (omega,)

    Notes
    -----
    Of a damper c that was not given c |Z V0|^2/|Z + c + ik/omega|^2/2, Z and V0 of the port.
    """
    here = response.sel(design=design)
    given: xr.DataArray = here.absorbed_power
    if TUNED not in run:
        return given
    impedance, damper = here.port_impedance, run[TUNED]
    through = np.abs(impedance + damper + 1j * study.pto.stiffness / here.omega) ** 2
    pushed = 0.5 * damper * np.abs(impedance * here.port_velocity) ** 2
    found: xr.DataArray = pushed / through.where(impedance != 0, 1.0)
    return found


def velocity_response(
    study: BaseStudy, response: xr.Dataset, design: str, run: Mapping[str, Any]
) -> tuple[float, xr.DataArray]:
    """Return the damper of a run [N s/m] and the velocity of the port beside it, per wave amplitude [1/s].

    Notes
    -----
    V = V0 Z/(Z + c + ik/omega), Z and V0 of the port; 0 where the port cannot move.
    """
    here, damper = response.sel(design=design), damper_of(study, design, run)
    through = here.port_impedance + damper + 1j * study.pto.stiffness / here.omega
    found: xr.DataArray = here.port_velocity * here.port_impedance / through.where(here.port_impedance != 0, 1.0)
    return damper, found


def lead(run: xr.Dataset) -> tuple[FloatArray, FloatArray]:
    """Return displacement and velocity of what a run is told by: of a body its port's, of a buoy heave."""
    if "stroke" in run:
        return run.stroke.values, run.stroke_rate.values
    return run.position.values[:, 0], run.velocity.values[:, 0]


def merit(run: xr.Dataset, wave: Wave, sea: Sea, water: Water, window: tuple[float, float]) -> Merit:
    """Return the figures of merit of a run (see `vsb.integrators.simulate.recorded`)."""
    time = run.time.values
    inside = (time >= window[0] - 1e-9) & (time <= window[1] + 1e-9)
    if not inside.any():
        raise ConfigError(
            f"simulation.window: received {list(window)} s, which holds none of the instants recorded, "
            f"{time[1] - time[0]:.4g} s apart; needs to be longer than that"
        )
    heave, rate = lead(run)
    velocity = run.velocity.values[inside]
    absorbed: FloatArray = run.energy.sel(term="pto").values
    force = run.pto.values[inside] if "pto" in run else np.zeros_like(velocity)
    start, end = averaging_window(wave, window)
    gained = np.diff(CubicSpline(time, absorbed)([start, end]))[0]
    mean = float(gained / (end - start))
    flux = energy_flux(sea, water)
    return Merit(
        float(np.ptp(heave[inside])),
        float(np.ptp(rate[inside])),
        float(np.max(-np.sum(force * velocity, axis=1))) + 0.0,  # no negative zero
        mean,
        float(absorbed[-1]) + 0.0,
        mean / flux if flux else None,
    )
