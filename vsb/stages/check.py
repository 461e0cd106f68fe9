"""What is checked before a run, and what `vsb check` prints: of a study, of a body, of a campaign or of a design.

Each kind has a module of its own, imported only for a plan of that kind: a run waits for it.
"""

from vsb.stages.planning import degree_lines
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import StudyPlan
from vsb.study.plans import Plan


def check_plan(plan: Plan) -> None:
    """Raise what would fail later in a run; raises `ConfigError` or `DatabaseError`."""
    if isinstance(plan, CampaignPlan):
        from vsb.stages.campaign_preview import check_campaign

        check_campaign(plan)
    elif isinstance(plan, DesignPlan):
        from vsb.stages.design_preview import check_design

        check_design(plan)
    elif isinstance(plan, StudyPlan):
        from vsb.stages.preview import check_before_run

        check_before_run(plan.study, plan)
    else:
        from vsb.stages.body_preview import body_before_run

        body_before_run(plan)


def summary(plan: Plan) -> list[str]:
    """Return the lines `vsb check` prints: what would be computed, at what cost, and what to doubt."""
    if isinstance(plan, CampaignPlan):
        from vsb.stages.campaign_preview import campaign_summary

        return [*campaign_summary(plan), *degree_lines(plan)]
    if isinstance(plan, DesignPlan):
        from vsb.stages.design_preview import design_summary

        return design_summary(plan)
    if isinstance(plan, StudyPlan):
        from vsb.stages import preview

        return [*preview.summary(plan.study, plan), *degree_lines(plan)]
    from vsb.stages.body_preview import body_summary

    return body_summary(plan)
