"""Rule answer: figures and report of a campaign."""

import io

import matplotlib as mpl
import xarray as xr

from vsb.report.campaign_figures import DRAWN
from vsb.report.campaign_page import CampaignReport, leading, render
from vsb.study.campaign_plan import figure_names
from vsb.study.specs import CampaignSpec
from vsb.study.study import content_id
from vsb.tools.files import load, write_text
from vsb.tools.stamps import record


def run(spec: CampaignSpec, data: str, figures: str, out: str, manifest: str) -> None:
    """Draw the figures of a campaign and write its report."""
    identity = content_id(spec)
    ds = load(data, expected=identity)
    drawn = {name: _drawn(name, ds, *leading(ds)) for name in figure_names(spec)}
    for name, text in drawn.items():
        write_text(f"{figures}/{name}.svg", text)
    write_text(out, render(CampaignReport(ds, drawn)))
    record(manifest, identity, [out, *(f"{figures}/{name}.svg" for name in drawn)])


def _drawn(name: str, ds: xr.Dataset, tuning: str, reference: str | None) -> str:
    """A figure as SVG."""
    text = io.StringIO()
    with mpl.rc_context():  # the caller's own figures keep their looks
        DRAWN[name](ds, tuning, reference).savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()
