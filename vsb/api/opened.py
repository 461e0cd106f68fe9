"""Open what a run left in a folder."""

import json
import os
from pathlib import Path

from vsb.api.best_buoy import BestBuoy
from vsb.api.campaign import Campaign
from vsb.api.results import Results
from vsb.errors import DatabaseError
from vsb.study.body import is_body, located
from vsb.study.study import parse


def open(path: str | Path) -> Results | Campaign | BestBuoy:
    """Open the results of a study, of a campaign or of a design problem.

    Parameters
    ----------
    path : str or Path
        Its folder, such as `results/buoy` or `results/year`.

    Raises
    ------
    DatabaseError
        If the folder holds no results.
    """
    root, name = os.path.split(Path(path).resolve())
    root = os.path.relpath(root)
    folder = Path(root, name)
    if (folder / "campaign.nc").is_file():
        return Campaign(str(folder))
    if (folder / "design.nc").is_file():
        return BestBuoy(str(folder))
    text = folder / "study.json"
    if not text.is_file():
        raise DatabaseError(f"{folder}: holds no results; needs what vsb run wrote, such as results/buoy")
    try:
        raw = json.loads(text.read_text(encoding="utf-8"))
    except (ValueError, RecursionError):
        raise DatabaseError(f"{text}: is damaged; delete it and run vsb run CONFIG again") from None
    study = located(raw, str(text)).study if is_body(raw) else parse(raw, source=str(text))
    if name != study.study:
        raise DatabaseError(f"{folder}: holds the study {study.study}; needs a folder of that name")
    return Results(study, root)
