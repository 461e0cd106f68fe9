"""What a campaign's page computes with: ports of its members, and the mean spectra of the bins of the year."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from vsb.report.campaign_answer import shown_place, where
from vsb.report.living import year_data
from vsb.scenes.ports import design_ports
from vsb.scenes.viability import viability
from vsb.shell.reference import ReferenceShell
from vsb.stages.members import Swept, swept_shape
from vsb.study.campaign_plan import members
from vsb.study.specs import CampaignSpec
from vsb.study.study import Study
from vsb.tools.ports import kind_of
from vsb.waves.climate import Climate

MOST = 6
"""Most points of a campaign a page computes with; of more, the one its figures show."""


def living_year(
    spec: CampaignSpec, ds: xr.Dataset, tuning: str, reference: str | None, seas: Climate, root: str
) -> dict[str, Any] | None:
    """Return the data of a campaign's page; none where no design is viable or the take-off switches.

    Parameters
    ----------
    spec : CampaignSpec
    ds : Dataset
        Results of the campaign.
    tuning : str
        That the answer is told at.
    reference : str or None
        The design gains are over.
    seas : Climate
        Of the year.
    root : str
        Folder of all results.
    """
    points = [str(dim) for dim in ds.margin.dims]
    shape = tuple(ds.sizes[dim] for dim in points)
    shown = shown_place(ds, tuning, reference)
    places = [dict(zip(points, map(int, place), strict=True)) for place in np.ndindex(shape)]
    others = [place for place in places if place != shown] if len(places) <= MOST else []
    known = [_point(spec, ds, places.index(place), place, seas, root) for place in [shown, *others]]
    found = [one for one in known if one]
    return year_data(seas, found, list(map(str, ds.design.values)), reference, kind_of(ds)) if found else None


@dataclass(frozen=True)
class Point:
    """A point of a campaign whose take-off a page knows: what of it is viable, at rest, and the water it moves."""

    study: Study  # of its viable designs
    reference: ReferenceShell
    swept: Swept


def sweep_point(spec: CampaignSpec, index: int, root: str) -> Point | None:
    """Return a point of a campaign; none if no design is viable, or its take-off switches."""
    (one,) = members(spec.base, [spec.vary.points[index]], spec.climate, spec.tuning)
    if one.study.pto.switches:
        return None  # a damper of the page knows no limits
    if (viable := viability(one.study).viable) is None:
        return None
    study, reference = viable
    return Point(study, reference, swept_shape(one.study, reference.basis, root))


def _point(
    spec: CampaignSpec, ds: xr.Dataset, index: int, place: Mapping[str, int], seas: Climate, root: str
) -> dict[str, Any] | None:
    """Words, ports, flux of the seas and given dampers of one point, if it can be looked at."""
    point = sweep_point(spec, index, root)
    if point is None:
        return None
    study = point.study
    return {
        "words": where(ds.isel(place)) or "the study",
        "ports": design_ports(study, point.reference, point.swept.of_year(seas)),
        "given": {design: study.pto.damper(design) for design in study.designs},
        "flux": seas.flux(study.water),
    }
