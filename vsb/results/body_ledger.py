"""The validity ledger of a study of a body: its runs, its seas, its coefficients, time against frequency domain."""

import numpy as np
import xarray as xr

from vsb.hydro.database import Check, check_at_most
from vsb.hydro.formats.modes import volume_of
from vsb.results.comparison import Runs
from vsb.results.ledger import wave_checks
from vsb.results.run_checks import drift_checks, energy_check
from vsb.scenes.floating_system import band
from vsb.study.body import BodyStudy
from vsb.study.quantities import RIGID, body_of, motion_of
from vsb.study.waves import Wave

TURN, SHIFT = 0.2, 0.3
"""Rotation [rad], and translation in terms of the cube root of the displaced volume, beyond which there is doubt."""
_TURNS = RIGID[3:]


def seas_checks(study: BodyStudy, database: xr.Dataset) -> list[Check]:
    """Return whether linear wave theory and the band of the database cover the seas."""
    lowest, highest = band(study, database)
    return [check for wave in study.waves for check in wave_checks(wave, study.water, highest, lowest)]


def runs_checks(study: BodyStudy, database: xr.Dataset, wave: Wave, runs: Runs) -> list[Check]:
    """Return whether the runs in a sea close their energy balance, hold what is held, and stay within small motion."""
    checks = []
    for design in study.designs:
        run = runs[design]
        checks += [energy_check(study, run), *motion_checks(study, database, run), *drift_checks(study, run)]
    return checks


def motion_checks(study: BodyStudy, database: xr.Dataset, run: xr.Dataset) -> list[Check]:
    """Return the largest rotation, and the largest translation in terms of the body's size, if that is known."""
    start, end = study.simulation.window
    largest = np.abs(run.position.sel(time=slice(start, end))).max("time")
    where = {"design": run.attrs["design"], "wave": run.attrs["wave"]}
    labels, checks = list(map(str, run.dof.values)), []
    kinds = np.array(list(map(motion_of, labels)))
    if (turns := np.isin(kinds, _TURNS)).any():
        value = float(largest.values[turns].max())
        checks.append(check_at_most("rotation", value, TURN, "rad", "largest rotation", doubt=True, **where))
    whole = database.attrs.get(volume_of(""), 0.0)
    volumes = np.array([float(database.attrs.get(volume_of(body_of(label)), whole)) for label in labels])
    if (shifts := np.isin(kinds, RIGID[:3]) & (volumes > 0)).any():
        value = float((largest.values[shifts] / volumes[shifts] ** (1 / 3)).max())
        text = "largest translation over the cube root of the displaced volume"
        checks.append(check_at_most("translation", value, SHIFT, "-", text, doubt=True, **where))
    return checks
