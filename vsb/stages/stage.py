"""A stage of the workflow: the study its specification describes, and the runs of a study."""

from typing import Any

import xarray as xr

from vsb.study.plan import trajectory_name
from vsb.study.study import Study, parse
from vsb.tools.files import load

Spec = dict[str, Any]


def partial_study(spec: Spec) -> Study:
    """Return a study from the sections a stage's spec holds; what the stage does not read takes harmless values."""
    defaults: Spec = {
        "study": "stage",
        "designs": {"any": {"flexible": bool(spec.get("modes"))}},
        "waves": [{"kind": "still"}],
    }
    keys = [key for key in Study.model_fields if spec.get(key) is not None]
    return parse({**defaults, **{key: spec[key] for key in keys}}, source="spec")


def stored_runs(study: Study, folder: str) -> dict[tuple[str, str], xr.Dataset]:
    """Return the trajectories of a study in a folder, by design and sea."""
    pairs = [(design, wave.label) for wave in study.waves for design in study.designs]
    return {pair: load(f"{folder}/{trajectory_name(*pair)}") for pair in pairs}
