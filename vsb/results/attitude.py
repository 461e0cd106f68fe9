"""How far a run goes from what linear theory knows: its pitch, its surge."""

import numpy as np
import xarray as xr

from vsb.hydro.database import Check, check_at_most
from vsb.study.quantities import RIGID
from vsb.study.study import StillWater, Study
from vsb.tools.words import plain
from vsb.waves.dispersion import wavenumber


def attitude_checks(study: Study, run: xr.Dataset) -> list[Check]:
    """Return whether a buoy stays near upright and near the place its waves are taken at; nothing of heave alone."""
    if study.motion == "heave":
        return []
    where = {"design": run.attrs["design"], "wave": run.attrs["wave"]}
    moved = {name: run.position.sel(dof=name).values if name in run.dof else 0.0 for name in RIGID}
    tilt = float(np.max(np.hypot(moved["Pitch"], moved["Roll"])))
    checks = [check_at_most("pitch", tilt, 0.3, "rad", "largest angle from upright", doubt=True, **where)]
    wave = next(wave for wave in study.waves if wave.label == run.attrs["wave"])
    if not isinstance(wave, StillWater):
        going = np.deg2rad(wave.direction)
        along = float(np.max(np.abs(np.cos(going) * moved["Surge"] + np.sin(going) * moved["Sway"])))
        phase = along * wavenumber(wave.omega, study.water.depth, study.water.gravity)
        text = f"wavenumber times the largest surge, {plain(along)} m; without a mooring a start drifts"
        checks.append(check_at_most("surge", phase, 0.5, "-", text, doubt=True, **where))
    return checks
