"""What a campaign's page draws in motion: one measured sea of the bin that brings most energy, by linear theory."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from vsb.report.animation import PER_PERIOD, PERIODS, SEEN, frames_data, largest_shell, shapes_data
from vsb.report.campaign_answer import TUNED, shown_place, where
from vsb.report.living import designs_data
from vsb.report.shell_figures import round_factor
from vsb.results.year import Bins
from vsb.scenes.directions import whole_labels
from vsb.scenes.ports import designs_in_waves
from vsb.stages.interactive_year import Point, sweep_point
from vsb.stages.modes import shell_modes
from vsb.study.campaign import CONSTRAINED
from vsb.study.specs import CampaignSpec
from vsb.study.study import Water
from vsb.waves.climate import Climate, realised
from vsb.waves.seas import Sea
from vsb.waves.superposition import superposed

FRAMES = PER_PERIOD * PERIODS
"""Instants at which motions are summed; a page shows as many."""


def moving_year(
    spec: CampaignSpec, ds: xr.Dataset, tuning: str, reference: str | None, seas: Climate, root: str
) -> dict[str, Any] | None:
    """Return the motion of all viable designs in one sea of a campaign's year; none where no damper is known.

    Parameters are those of `vsb.stages.interactive_year.living_year`.
    """
    place = shown_place(ds, tuning, reference)
    index = int(np.ravel_multi_index(list(place.values()), ds.margin.shape)) if place else 0
    point, one = sweep_point(spec, index, root), ds.isel(place)
    told = next((name for name in (tuning, "one", "each", "fixed") if name in one.tuning and name != CONSTRAINED), None)
    if point is None or told is None:
        return None
    sea, row, column = most_energetic(seas, point.study.water)
    designs, period, radius = list(point.study.designs), float(seas.te[sea]), point.study.device.radius
    damping = one.damping.sel(tuning=told, design=designs).isel(hs=row, te=column).values
    band = point.swept.buoys[0].database.omega.values[[0, -1]]
    if not np.isfinite(damping).all():
        return None
    waves = realised(seas, sea, PERIODS * period, 0, *map(float, band))
    runs = _runs(point, dict(zip(designs, map(float, damping), strict=True)), waves, PERIODS * period)
    modes = shell_modes(point.study, point.reference)
    shell = list(map(str, modes.mode.values))
    width = max(SEEN * radius, radius + max(float(abs(run.sel(dof="Heave")).max()) for run in runs.values()))
    words = f"a sea of the bin that brings most energy (Hs {seas.hs[sea]:.2g} m, Te {period:.2g} s)"
    at = f" at {text}" if (text := where(one)) else ""
    span, largest = (0.0, PERIODS * period), max(largest_shell(run, shell) for run in runs.values())
    return {
        "designs": designs_data(designs, reference),
        "width": width,
        "factor": round_factor(largest, radius),
        "shapes": shapes_data(modes),
        "seas": [frames_data(words, runs, waves, span, period, width, point.study.water, shell)],
        "told": f"In {words}: a realisation of its spectrum, by linear theory, {TUNED[told]}{at}.",
    }


def most_energetic(climate: Climate, water: Water) -> tuple[int, int, int]:
    """Return a sea and the row and column of its bin: the bin that brings most energy, the sea nearest to its mean."""
    bins, flux = Bins(climate.hs, climate.te, climate.hours), climate.flux(water)
    energy = bins.total(flux * climate.hours)
    best = int(energy.argmax())
    inside = np.flatnonzero(bins.index == best)
    mean = energy.ravel()[best] / bins.share.ravel()[best]
    row, column = (int(i) for i in np.unravel_index(best, bins.shape))
    return int(inside[np.abs(flux[inside] - mean).argmin()]), row, column


def _runs(point: Point, dampers: Mapping[str, float], waves: Sea, duration: float) -> dict[str, xr.DataArray]:
    """Positions of all designs in a sea by linear theory, those degrees of freedom alone that a design moves in."""
    inside = designs_in_waves(point.study, point.reference, point.swept.at(waves.omega))
    labels, spring = np.array(whole_labels(point.study, point.reference)), point.study.pto.stiffness
    time = np.linspace(0.0, duration, FRAMES + 1)
    found = {}
    for design, damping in dampers.items():
        moved = waves.amplitude[:, None] * inside[design].position(damping, spring)
        free = moved.any(axis=0)
        coords = {"time": time, "dof": labels[free]}
        found[design] = xr.DataArray(superposed(waves.omega, moved[:, free], time), coords, ("time", "dof"))
    return found
