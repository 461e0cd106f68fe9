"""What a study's page draws in motion, gathered from its runs."""

import itertools
import math
from collections.abc import Mapping
from typing import Any

import xarray as xr

from vsb.report.animation import PERIODS, SEEN, frames_data, largest_shell, shapes_data
from vsb.report.living import designs_data
from vsb.report.shell_figures import round_factor
from vsb.scenes.floating_system import heading
from vsb.stages.inputs import Inputs
from vsb.study.study import StillWater, Study
from vsb.waves.seas import NO_WAVES, sea

SEAS = 4
"""Most seas whose motion a page holds."""


def moving_study(stored: Inputs, modes: xr.Dataset, words: Mapping[str, str]) -> dict[str, Any]:
    """Return the motion of all designs in the first seas of a study, its still water left out where there are waves.

    Parameters
    ----------
    stored : Inputs
    modes : Dataset
        Of rule `modes`.
    words : mapping
        Every sea in words, by its label.
    """
    study = stored.study
    assert isinstance(study, Study)  # a body has no shell to draw
    waves = [wave for wave in study.drawn_waves if not isinstance(wave, StillWater)]
    shown = waves or study.drawn_waves
    width, shell = SEEN * study.device.radius, list(map(str, modes.mode.values))
    seas, largest, duration = [], 0.0, study.simulation.duration
    for wave in itertools.islice(shown, SEAS):
        runs = {design: stored.runs[design, wave.label].position for design in study.designs}
        settled = slice(*study.simulation.window)
        largest = max(largest, *(largest_shell(run.sel(time=settled), shell) for run in runs.values()))
        moved = sea(wave, study.hydro.omega_max, duration) if study.needs_bem else NO_WAVES
        period = duration / PERIODS if isinstance(wave, StillWater) else 2 * math.pi / wave.omega
        towards = math.radians(heading(wave))
        window, water = study.simulation.window, study.water
        seas.append(frames_data(words[wave.label], runs, moved, window, period, width, water, shell, towards))
    return {
        "designs": designs_data(list(study.designs), study.reference_design),
        "width": width,
        "factor": round_factor(largest, study.device.radius),
        "shapes": shapes_data(modes),
        "seas": seas,
    }
