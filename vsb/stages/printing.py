"""Figures of finished results as files for print, drawn anew."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from vsb.pipeline.plans import CampaignPlan, DesignPlan, Plan
from vsb.report.canvas import for_print
from vsb.stages import campaign, design_results, report
from vsb.stages.check import read_climate
from vsb.stages.stored import Inputs
from vsb.tools.files import atomic_write, load
from vsb.tools.stamps import check_output


def print_figures(plan: Plan, folder: str, kinds: Sequence[str]) -> list[str]:
    """Write all figures of a finished study, campaign or design problem as `pdf`, `png` or both and return their paths.

    Raises
    ------
    DatabaseError
        If a result is missing, damaged, or of another study, or a file of that name is the user's; nothing is written.
    """
    for name in (Path(path).stem for path in plan.products if path.endswith(".svg")):
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
        return campaign.figures_of(plan.campaign.spec["spec"], load(plan.data_path, expected=plan.campaign.id), seas)
    if isinstance(plan, DesignPlan):
        return design_results.figures_of(plan.design.spec["spec"], load(plan.data_path, expected=plan.design.id))
    files = {name: one.out for name, one in plan.solved.items()} | ({"modes": plan.modes.out} if plan.modes else {})
    return report.figures_of(Inputs(plan.study, f"{plan.folder}/trajectories", files))
