"""What is checked before a run, and what `vsb check` prints: of a study, of a body, of a campaign or of a design.

Each kind has a module of its own, imported only for a plan of that kind: a run waits for it.
"""

import importlib
from typing import Any

from vsb.stages.planning import degree_lines
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import BodyPlan, StudyPlan
from vsb.study.plans import Plan

MODULES: dict[type, str] = {
    StudyPlan: "preview", BodyPlan: "body_preview", CampaignPlan: "campaign_preview", DesignPlan: "design_preview",
}  # fmt: skip
"""Kind of plan -> module here with the functions `check` and `summary`."""


def _of(plan: Plan) -> Any:
    """The module of a plan."""
    return importlib.import_module(f"vsb.stages.{MODULES[type(plan)]}")


def check_plan(plan: Plan) -> None:
    """Raise what would fail later in a run; raises `ConfigError` or `DatabaseError`."""
    _of(plan).check(plan)


def summary(plan: Plan) -> list[str]:
    """Return the lines `vsb check` prints: what would be computed, at what cost, and what to doubt."""
    lines: list[str] = _of(plan).summary(plan)
    return [*lines, *(degree_lines(plan) if isinstance(plan, StudyPlan | CampaignPlan) else [])]
