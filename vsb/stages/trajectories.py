"""The runs of a study in a folder."""

import xarray as xr

from vsb.study.plan import trajectory_name
from vsb.study.study import Study
from vsb.tools.files import load


def stored_runs(study: Study, folder: str) -> dict[tuple[str, str], xr.Dataset]:
    """Return the trajectories of a study in a folder, by design and sea."""
    pairs = [(design, wave.label) for wave in study.waves for design in study.designs]
    return {pair: load(f"{folder}/{trajectory_name(*pair)}") for pair in pairs}
