"""Figures of finished results as files for print, drawn anew."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from vsb.keys.quantities import content_id
from vsb.pipeline.tasks import products
from vsb.report.svg import for_print
from vsb.stages import campaign_report, design_report, report
from vsb.stages.climate import read_climate
from vsb.stages.stored import Inputs
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plans import Plan
from vsb.tools.files import atomic_write, load
from vsb.tools.stamps import check_output


def print_figures(plan: Plan, folder: str, kinds: Sequence[str]) -> list[str]:
    """Write all figures of a finished study, campaign or design problem as `pdf`, `png` or both and return their paths.

    Raises
    ------
    DatabaseError
        If a result is missing, damaged, or of another study, or a file of that name is the user's; nothing is written.
    """
    for name in (Path(path).stem for path in products(plan) if path.endswith(".svg")):
        for kind in kinds:
            check_output(Path(folder, f"{name}.{kind}"), [], f"{kind.upper()} of a figure")
    written = []
    with mpl.rc_context():
        for name, figure in _figures(plan):
            for kind in kinds:
                with atomic_write(path := Path(folder, f"{name}.{kind}")) as temporary:
                    temporary.write_bytes(for_print(figure, kind))
                written.append(str(path))
    return written


def _figures(plan: Plan) -> Iterator[tuple[str, Figure]]:
    """Figures by name."""
    if isinstance(plan, CampaignPlan):
        seas = read_climate(plan.climate, plan.loaded.climate_path)
        return campaign_report.figures_of(plan.campaign, load(plan.data_path, expected=content_id(plan.campaign)), seas)
    if isinstance(plan, DesignPlan):
        return design_report.figures_of(plan.design, load(plan.tables["design.nc"], expected=content_id(plan.design)))
    files = {**plan.hydro_files, **plan.response_files, **plan.witness_files, **plan.modes_files}
    return report.figures_of(Inputs(plan.study, f"{plan.folder}/trajectories", files))
