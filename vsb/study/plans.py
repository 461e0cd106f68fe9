"""The plan of any file: of a study of a buoy or of a body, of a campaign, or of a design problem."""

from typing import Any

from vsb.study.body import is_body
from vsb.study.campaign import is_campaign, read
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design import is_design
from vsb.study.design import read as read_design
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import BodyPlan, StudyPlan
from vsb.study.reading import read_yaml
from vsb.study.study import parse

Plan = StudyPlan | BodyPlan | CampaignPlan | DesignPlan


def planned(raw: dict[str, Any], source: str) -> Plan:
    """Return the plan of a file as nested mappings, its results folder, if not `results`, as `root`."""
    if is_campaign(raw):
        return CampaignPlan.of(raw, source)
    if is_design(raw):
        return DesignPlan.of(raw, source)
    return BodyPlan.of(raw, source) if "body" in raw else StudyPlan.of(raw, source)


def plan_of(path: str) -> Plan:
    """Return the plan of a study file, of a buoy or of a body, of a campaign file or of a design file."""
    raw = read_yaml(path, "a study file such as config/buoy.yaml")
    if is_body(raw):
        return BodyPlan.of(raw, path)
    if is_campaign(raw):
        return CampaignPlan(read(raw, path))
    return DesignPlan(read_design(raw, path)) if is_design(raw) else StudyPlan(parse(raw, source=path))
