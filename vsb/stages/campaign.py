"""Stages campaign and campaign_report: all members of a campaign as netCDF and as a table, its figures and report."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from vsb.engine.waves.climate import Climate, realised
from vsb.engine.waves.seas import Sea, superposed
from vsb.engine.waves.water import Water
from vsb.models.floating_system import BuoyOfShape, Floating
from vsb.models.rest import whole_labels
from vsb.models.viability import OVERLOADED, advice, with_designs
from vsb.pipeline.plans import members
from vsb.report.campaign_answer import TUNED, leading, shells_not_viable, shown_place, where
from vsb.report.campaign_page import DRAWN, render
from vsb.report.canvas import drawn
from vsb.report.hydro_figures import year_spectra
from vsb.report.interactive import (
    PER_PERIOD,
    PERIODS,
    SEEN,
    View,
    designs_data,
    frames_data,
    largest_shell,
    shapes_data,
    year_data,
)
from vsb.report.shell_figures import round_factor, sketches
from vsb.results.campaign import as_csv, gathered, with_verification
from vsb.results.year import Bins, frequencies
from vsb.stages.check import read_climate
from vsb.stages.members import at_rest
from vsb.stages.stage import Stamp
from vsb.stages.water import shell_modes
from vsb.study import figure_names
from vsb.study.specs import CampaignSpec
from vsb.study.study import Study
from vsb.tools.files import load, save, write_text
from vsb.tools.stamps import record
from vsb.tools.variables import kind_of


def _tried(spec: CampaignSpec, found: xr.Dataset) -> dict[str, str]:
    """What would carry the load of the shell that is nearest to it, where those of all points buckle or give way."""
    nearest = int(found.margin.values.argmax())
    if float(found.margin.values.flat[nearest]) >= 0 and not shells_not_viable(found).startswith(OVERLOADED):
        return {}
    (one,) = members(spec.base, [spec.vary.points[nearest]], spec.climate, spec.tuning)
    return {"advice": advice(one.study)}


def run_campaign(
    spec: CampaignSpec, batches: str, verifications: str, out: str, table: str, manifest: str, stamp: Stamp
) -> None:
    """Write the results of a campaign from its batches and from what runs in time say."""
    found = gathered(spec, (load(Path(batches) / f"{batch}.nc", expected=batch) for batch in spec.batches))
    runs = [load(Path(verifications) / f"{one}.nc", expected=one) for one in spec.verifications]
    found = with_verification(spec, found, runs)
    save(found.assign_attrs(_tried(spec, found), **stamp), out)
    write_text(table, as_csv(spec, found))
    record(manifest, stamp["spec_id"], [table])


FRAMES = PER_PERIOD * PERIODS
"""Instants at which motions are summed; a page shows as many."""


class Point(NamedTuple):
    """A point of a campaign whose take-off a page knows."""

    study: Study  # of its viable designs
    floating: Floating


def sweep_point(spec: CampaignSpec, index: int, root: str) -> Point | None:
    """Return a point of a campaign; none if no design is viable, its take-off is nonlinear or has several ports."""
    (one,) = members(spec.base, [spec.vary.points[index]], spec.climate, spec.tuning)
    if one.study.pto.nonlinear or one.study.pto.several:
        return None  # a damper of the page knows no limits, and is of one port
    rest, floating = at_rest(one.study, one.spec, root)
    return Point(with_designs(one.study, rest.designs), floating()) if rest.designs else None


def run_campaign_report(
    spec: CampaignSpec, data: str, climate: str, root: str, figures: str, out: str, manifest: str, stamp: Stamp
) -> None:
    """Draw the figures of a campaign and write its report."""
    identity = stamp["spec_id"]
    ds = load(data, expected=identity)
    seas = read_climate(spec.climate, climate)
    with mpl.rc_context():  # the caller's own figures keep their looks
        every = {name: drawn(figure, name) for name, figure in figures_of(spec, ds, seas)}
    files = [path for name, one in every.items() for path in one.write(figures, name)]
    interactive, animated = (made(spec, ds, *leading(ds), seas, root) for made in (interactive_year, animated_year))
    (first,) = members(spec.base, spec.vary.points[:1], spec.climate, spec.tuning)
    svgs = {name: one.svg for name, one in every.items()}
    write_text(out, render(ds, svgs, interactive, sketches(first.study), animated, seas.notes))
    record(manifest, identity, [out, *files])


def figures_of(spec: CampaignSpec, ds: xr.Dataset, seas: Climate) -> Iterator[tuple[str, Figure]]:
    """Draw the figures of a campaign by name: of its results, but for the year's spectra."""
    for name in figure_names.of_campaign(spec):
        yield name, year_spectra(seas) if name == "spectra" else DRAWN[name](ds, *leading(ds))


def animated_year(
    spec: CampaignSpec, ds: xr.Dataset, tuning: str, reference: str | None, seas: Climate, root: str
) -> dict[str, Any] | None:
    """Return the motion of all viable buoys in one sea of a campaign's year; none where no damper is known."""
    place = shown_place(ds, tuning, reference)
    index = int(np.ravel_multi_index(list(place.values()), ds.margin.shape)) if place else 0
    point, one = sweep_point(spec, index, root), ds.isel(place)
    dampers = [name for name in ("one", "each", "fixed") if name in one.tuning]
    tuned = tuning if tuning in dampers else next(iter(dampers), None)
    if point is None or tuned is None or not isinstance(buoy := point.floating, BuoyOfShape):
        return None
    study = buoy.study
    sea, row, column = most_energetic(seas, study.water)
    designs, period, radius = list(study.designs), float(seas.te[sea]), study.device.radius
    damping = one.damping.sel(tuning=tuned, design=designs).isel(hs=row, te=column).values
    if not np.isfinite(damping).all():
        return None
    waves = realised(seas, sea, PERIODS * period, 0, *buoy.band)
    runs = _runs(buoy, dict(zip(designs, map(float, damping), strict=True)), waves, PERIODS * period)
    modes = shell_modes(study, buoy.reference)
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
        "seas": [frames_data(words, runs, waves, span, period, View(width), study.water, shell)],
        "message": f"In {words}: a realisation of its spectrum by linear theory, {TUNED[tuned]}{at}.",
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


def _runs(point: BuoyOfShape, dampers: Mapping[str, float], waves: Sea, duration: float) -> dict[str, xr.DataArray]:
    """Positions of all designs in a sea by linear theory, those degrees of freedom alone that a design moves in."""
    inside = point.at(waves.omega).in_waves()
    labels, spring = np.array(whole_labels(point.study, point.moving)), point.study.pto.stiffness
    time = np.linspace(0.0, duration, FRAMES + 1)
    found = {}
    for design, damping in dampers.items():
        seen, _, (free_motion, forced) = inside[design]
        moved = waves.amplitude[:, None] * (free_motion - seen.force(damping, spring)[:, None] * forced)
        free = moved.any(axis=0)
        coords = {"time": time, "dof": labels[free]}
        found[design] = xr.DataArray(superposed(waves.omega, moved[:, free], time), coords, ("time", "dof"))
    return found


MOST = 6
"""Most points of a campaign a page computes with; of more, the one its figures show."""


def interactive_year(
    spec: CampaignSpec, ds: xr.Dataset, tuning: str, reference: str | None, seas: Climate, root: str
) -> dict[str, Any] | None:
    """Return the data of a campaign's page; none where no design is viable or the take-off is nonlinear."""
    points = [str(dim) for dim in ds.margin.dims]
    shape = tuple(ds.sizes[dim] for dim in points)
    shown = shown_place(ds, tuning, reference)
    places = [dict(zip(points, map(int, place), strict=True)) for place in np.ndindex(shape)]
    others = [place for place in places if place != shown] if len(places) <= MOST else []
    known = [_point(spec, ds, places.index(place), place, seas, root) for place in [shown, *others]]
    found = [one for one in known if one]
    return year_data(seas, found, list(map(str, ds.design.values)), reference, kind_of(ds)) if found else None


def _point(
    spec: CampaignSpec, ds: xr.Dataset, index: int, place: Mapping[str, int], seas: Climate, root: str
) -> dict[str, Any] | None:
    """Words, ports, flux of the seas and given dampers of one point, if it can be shown."""
    point = sweep_point(spec, index, root)
    if point is None or point.study.pto.spring_costs:
        return None
    study = point.study
    return {
        "words": where(ds.isel(place)) or "the study",
        "ports": point.floating.at(frequencies(seas, *point.floating.band)).ports(study.pto.stiffness),
        "given": {design: study.pto.damper(design) for design in study.designs},
        "flux": seas.flux(study.water),
        "efficiency": study.pto.efficiency,
    }
