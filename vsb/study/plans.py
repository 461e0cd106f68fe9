"""The plan of any file: of a study of a buoy or of a body, of a campaign, or of a design problem."""

import os
from pathlib import PurePath
from typing import Any

from vsb.errors import ConfigError
from vsb.keys.reading import read_yaml
from vsb.study.body import is_body, located
from vsb.study.campaign import is_campaign, read
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design import is_design
from vsb.study.design import read as read_design
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import BodyPlan, StudyPlan
from vsb.study.study import parse

MESHES = {".stl", ".obj", ".ply", ".gdf", ".vtk", ".vtp", ".vtu", ".msh", ".step", ".stp", ".igs", ".iges"}
"""Endings of files that hold a hull, not a study."""

Plan = StudyPlan | BodyPlan | CampaignPlan | DesignPlan


def planned(raw: dict[str, Any], source: str) -> Plan:
    """Return the plan of a file as nested mappings, its results folder, if not `results`, as `root`."""
    own = {key: value for key, value in raw.items() if key != "root"}
    return _plan(own, os.path.relpath(source), raw.get("root", "results"))


def plan_of(path: str, root: str = "results") -> Plan:
    """Return the plan of a study file, of a buoy or of a body, of a campaign file or of a design file.

    `root` is the folder of all results.
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
        return CampaignPlan(read(raw, source), root=root)
    if is_design(raw):
        return DesignPlan(read_design(raw, source), root=root)
    return StudyPlan(parse(raw, source=source), root=root)
