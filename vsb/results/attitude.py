"""How far a run goes from what linear theory knows: its pitch, its surge."""

import numpy as np
import xarray as xr

from vsb.hydro.database import Check, check_at_most
from vsb.study.study import StillWater, Study
from vsb.tools.words import plain
from vsb.waves.seas import wavenumber


def attitude_checks(study: Study, run: xr.Dataset) -> list[Check]:
    """Return whether a buoy stays near upright and near the place its waves are taken at; nothing of heave alone."""
    if study.motion == "heave":
        return []
    where = {"design": run.attrs["design"], "wave": run.attrs["wave"]}
    pitch, surge = (float(np.abs(run.position.sel(dof=name).values).max()) for name in ("Pitch", "Surge"))
    checks = [check_at_most("pitch", pitch, 0.3, "rad", "largest angle from upright", doubt=True, **where)]
    wave = next(wave for wave in study.waves if wave.label == run.attrs["wave"])
    if not isinstance(wave, StillWater):
        phase = surge * wavenumber(wave.omega, study.water.depth, study.water.gravity)
        text = f"wavenumber times the largest surge, {plain(surge)} m; without a mooring a start drifts"
        checks.append(check_at_most("surge", phase, 0.5, "-", text, doubt=True, **where))
    return checks
