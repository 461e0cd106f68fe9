"""Motion of a study's designs for its page: of a buoy its shell, of a body its hull cut along x."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import xarray as xr

from vsb.engine.hydro.bodies.outline import OUTLINE
from vsb.engine.waves.kinds import StillWater, Wave
from vsb.engine.waves.seas import NO_WAVES
from vsb.models.floating_system import heading, study_sea
from vsb.report.animation import (
    PERIODS,
    SEEN,
    View,
    frames_data,
    largest_motion,
    largest_shell,
    outline_data,
    shapes_data,
)
from vsb.report.interactive import designs_data
from vsb.report.shell_figures import round_factor
from vsb.stages.stored import Inputs

ANIMATED_SEAS = 4
"""Most seas whose motion a page holds."""


def animated_study(stored: Inputs, words: Mapping[str, str]) -> dict[str, Any] | None:
    """Return the motion of all designs in the first seas of a study, its still water left out where there are waves.

    None of a body whose coefficients come without its mesh.

    Parameters
    ----------
    words : mapping
        Every sea in words, by its label.
    """
    study, shown = stored.study, _shown(stored)
    if buoy := study.buoy:
        labels, radius = list(map(str, stored.modes.mode.values)), buoy.device.radius
        factor = round_factor(_largest(stored, lambda run: largest_shell(run.position, labels)), radius)
        view, drawn = View(SEEN * radius), {"factor": factor, "shapes": shapes_data(stored.modes)}
    elif OUTLINE in (ds := stored.database):
        labels = list(map(str, ds.influenced_dof.values))
        view, drawn = outline_data(ds, _largest(stored, lambda run: largest_motion(ds, run)))
    else:
        return None
    return {
        "designs": designs_data(list(study.designs), study.reference_design),
        "width": view.width,
        **drawn,
        "seas": [_frames(stored, wave, words[wave.label], view, labels) for wave in shown],
    }


def _shown(stored: Inputs) -> tuple[Wave, ...]:
    """Seas that are drawn."""
    return (stored.study.one_of_each_sea or stored.study.drawn_waves)[:ANIMATED_SEAS]


def _largest(stored: Inputs, motion: Callable[[xr.Dataset], float]) -> float:
    """Largest motion [m] of all designs in the seas that are drawn, within the study's window."""
    window, designs = slice(*stored.study.simulation.window), stored.study.designs
    return max(motion(stored.runs[one, wave.label].sel(time=window)) for wave in _shown(stored) for one in designs)


def _frames(stored: Inputs, wave: Wave, words: str, view: View, labels: Sequence[str]) -> dict[str, Any]:
    """Frames of one sea; of a spread one the line through the designs does not tell its surface."""
    study = stored.study
    runs = {design: stored.runs[design, wave.label].position for design in study.designs}
    sea = study_sea(study, wave, stored.database) if study.needs_bem else NO_WAVES
    moved = sea if sea.heading is None else NO_WAVES
    period = study.simulation.duration / PERIODS if isinstance(wave, StillWater) else 2 * math.pi / wave.omega
    towards = math.radians(heading(wave))
    return frames_data(words, runs, moved, study.simulation.window, period, view, study.water, labels, towards)
