"""The plan of any file: of a study of a buoy or of a body, of a campaign, or of a design problem."""

import os
from pathlib import PurePath
from typing import Any, overload

from vsb.errors import ConfigError
from vsb.keys.reading import read_yaml
from vsb.pipeline.campaign_plan import CampaignPlan
from vsb.pipeline.design_plan import DesignPlan
from vsb.pipeline.graph import BodyPlan, StudyPlan
from vsb.study.body import is_body, located
from vsb.study.campaign import is_campaign, read
from vsb.study.degree import degree_needed
from vsb.study.design import is_design
from vsb.study.design import read as read_design
from vsb.study.study import Study, parse

MESHES = {".stl", ".obj", ".ply", ".gdf", ".vtk", ".vtp", ".vtu", ".msh", ".step", ".stp", ".igs", ".iges"}
"""Endings of files that hold a hull, not a study."""

Plan = StudyPlan | BodyPlan | CampaignPlan | DesignPlan


def planned(raw: dict[str, Any], source: str) -> Plan:
    """Return the plan of a file as nested mappings, its results folder, if not `results`, as `root`."""
    own = {key: value for key, value in raw.items() if key != "root"}
    return _plan(own, os.path.relpath(source), raw.get("root", "results"))


def plan_of(path: str, root: str = "results") -> Plan:
    """Return the plan of a study file, of a buoy or of a body, of a campaign file or of a design file.

    `root` is the folder of all results; see `with_degree`.
    """
    if PurePath(path).suffix.lower() in MESHES:
        raise ConfigError(
            f"{path}: received a hull, needs a study of it: vsb init my.yaml --body writes one, in which mesh: "
            f"{PurePath(path).name} names the hull"
        )
    return _plan(read_yaml(path, "a study file such as config/buoy.yaml"), path, root)


def _plan(raw: object, source: str, root: str) -> Plan:
    """The plan of what a file holds."""
    if is_body(raw):
        found = located(raw, os.path.relpath(source))
        return BodyPlan(found.study, root=root, files=found.files)
    if is_campaign(raw):
        return with_degree(CampaignPlan(read(raw, source), root=root))
    if is_design(raw):
        return DesignPlan(read_design(raw, source), root=root)
    return with_degree(StudyPlan(parse(raw, source=source), root=root))


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


def _with(study: Study, degree: int) -> Study:
    """The study with a degree."""
    return study.model_copy(update={"modes": study.modes.model_copy(update={"degree": degree})})
