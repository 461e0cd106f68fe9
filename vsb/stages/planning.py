"""The plan of a file, with the degree of its shell modes, which stands in every id."""

import contextlib
from collections.abc import Iterator
from typing import Any, overload

from vsb.errors import ConfigError
from vsb.study import plans
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.degree import degree_needed
from vsb.study.plan import BodyPlan, StudyPlan
from vsb.study.plans import Plan
from vsb.study.study import Study


def plan_of(path: str, root: str = "results") -> Plan:
    """Return the plan of a study file, of a buoy or of a body, or of a campaign file; see `with_degree`."""
    return with_degree(plans.plan_of(path, root))


def planned(raw: dict[str, Any], source: str) -> Plan:
    """Return the plan of a file as nested mappings, its results folder, if not `results`, as `root`."""
    return with_degree(plans.planned(raw, source))


@overload
def with_degree(plan: StudyPlan) -> StudyPlan: ...
@overload
def with_degree(plan: StudyPlan | BodyPlan) -> StudyPlan | BodyPlan: ...
@overload
def with_degree(plan: Plan) -> Plan: ...
def with_degree(plan: Plan) -> Plan:
    """Return a plan whose shell modes have a degree: the one given, or the one that `modes.tolerance` needs.

    Of a campaign it is the largest of those of its points. An optimum has modes of its own.
    """
    if isinstance(plan, StudyPlan) and plan.study.modes.degree is None:
        return StudyPlan(_with(plan.study, needed(plan)), root=plan.root)
    if not isinstance(plan, CampaignPlan) or (base := plan.loaded.base.buoy) is None or base.modes.degree is not None:
        return plan
    if "modes.degree" in plan.loaded.campaign.vary.keys:
        return plan
    degree = needed(plan)
    studies = tuple(_with(one.buoy, degree) if one.buoy else one for one in plan.studies)
    return CampaignPlan(plan.loaded.model_copy(update={"base": _with(base, degree)}), plan.root, studies)


def needed(plan: StudyPlan | CampaignPlan) -> int:
    """Return the degree of the full basis that `modes.tolerance` needs, whatever degree is given."""
    if isinstance(plan, StudyPlan):
        return degree_needed(plan.study)
    return max(degree_needed(one.buoy) for one in plan.studies if one.buoy)


def degree_lines(plan: StudyPlan | CampaignPlan) -> list[str]:
    """Return what `vsb check` says of modes that are given: a doubt where the tolerance needs others."""
    study = plan.study if isinstance(plan, StudyPlan) else plan.loaded.base.buoy
    if study is None or not study.flexible or not study.needs_bem:
        return []
    modes, varied = study.modes, isinstance(plan, CampaignPlan) and "modes.degree" in plan.loaded.campaign.vary.keys
    enough = modes.degree is None or (modes.basis == "full" and modes.degree >= needed(plan))
    if varied or enough:
        return []
    return [
        f"doubt        modes: {modes.basis}, degree {modes.degree}, but modes.tolerance {modes.tolerance:g} needs "
        f"the full basis to about degree {needed(plan)}: what is left out is measured in the run and widens the "
        "intervals"
    ]


@contextlib.contextmanager
def load_advised(study: Study) -> Iterator[None]:
    """Say in an error of a shell that does not carry its load what would carry it, tried now."""
    try:
        yield
    except ConfigError as error:
        from vsb.models.load_advice import advised  # only now: it imports what solves

        raise advised(study, error) from None


def _with(study: Study, degree: int) -> Study:
    """The study with a degree."""
    return study.model_copy(update={"modes": study.modes.model_copy(update={"degree": degree})})
