"""Rule answer: figures and report of a campaign."""

from collections.abc import Iterable, Mapping

import matplotlib as mpl
import xarray as xr
from matplotlib.figure import Figure

from vsb.report.campaign_answer import leading
from vsb.report.campaign_figures import DRAWN
from vsb.report.campaign_page import CampaignReport, render
from vsb.report.sea_figures import year_spectra
from vsb.report.sketch import sketches
from vsb.report.svg import Drawn, drawn
from vsb.stages.animated_year import moving_year
from vsb.stages.climate import read_climate
from vsb.stages.interactive_year import living_year
from vsb.study.campaign_plan import figure_names, members
from vsb.study.specs import CampaignSpec
from vsb.study.study import content_id
from vsb.tools.files import load, write_text
from vsb.tools.stamps import record
from vsb.waves.climate import Climate


def run(spec: CampaignSpec, data: str, climate: str, root: str, figures: str, out: str, manifest: str) -> None:
    """Draw the figures of a campaign and write its report."""
    identity = content_id(spec)
    ds = load(data, expected=identity)
    seas = read_climate(spec.climate, climate)
    names = figure_names(spec)
    every = _drawn(names, ds, seas)
    files = [path for name in names for path in every[name].write(figures, name)]
    write_text(out, _page(spec, ds, seas, root, {name: one.svg for name, one in every.items()}))
    record(manifest, identity, [out, *files])


def _drawn(names: Iterable[str], ds: xr.Dataset, seas: Climate) -> dict[str, Drawn]:
    """Figures by name."""
    with mpl.rc_context():  # the caller's own figures keep their looks
        return {name: drawn(_figure(name, ds, seas), name) for name in names}


def _figure(name: str, ds: xr.Dataset, seas: Climate) -> Figure:
    """A figure by its name: of the results, but for the year's spectra."""
    if name == "spectra":
        return year_spectra(seas)
    return DRAWN[name](ds, *leading(ds))


def _page(spec: CampaignSpec, ds: xr.Dataset, seas: Climate, root: str, svgs: Mapping[str, str]) -> str:
    """The report, with its figures."""
    living, moving = (made(spec, ds, *leading(ds), seas, root) for made in (living_year, moving_year))
    first = members(spec.base, spec.vary.points[:1], spec.climate, spec.tuning)[0].study
    return render(CampaignReport(ds, svgs, living, sketches(first), moving, seas.notes))
