"""The runs of a study in a folder."""

import xarray as xr

from vsb.study.plan import StudyPlan, trajectory_name
from vsb.study.study import Study
from vsb.tools.files import load


def stored_runs(study: Study, folder: str) -> dict[tuple[str, str], xr.Dataset]:
    """Return the trajectories of a study in a folder, by design and sea; one of another specification is refused."""
    plan, runs = StudyPlan(study), {}
    for wave in study.waves:
        for design in study.designs:
            path = f"{folder}/{trajectory_name(design, wave.label)}"
            runs[design, wave.label] = load(path, expected=plan.trajectory_id(design, wave))
    return runs
