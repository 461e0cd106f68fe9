"""Designs side by side: the comparison table."""

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from vsb.results.power import Merit, merit
from vsb.study.study import Study
from vsb.waves.seas import Sea

COLUMNS = ("design", "wave", *Merit._fields, "energy_gain_percent", "energy_residual")
NOTHING = 1e-9
"""An energy below this part of the best design's is round-off of a buoy at rest: no gain is measured against it."""
Row = dict[str, Any]
Runs = Mapping[tuple[str, str], xr.Dataset]


def comparison(study: Study, runs: Runs, seas: Mapping[str, Sea]) -> list[Row]:
    """Return one row per design and sea; the gain is of absorbed energy over the first rigid design's.

    Parameters
    ----------
    study : Study
    runs : mapping (design, wave label) -> trajectory
    seas : mapping wave label -> Sea
    """
    rows: list[Row] = []
    for wave in study.waves:
        merits = {
            design: merit(runs[design, wave.label], wave, seas[wave.label], study.water, study.simulation.window)
            for design in study.designs
        }
        base = merits[study.reference_design].energy if study.reference_design else None
        if base is not None and base <= NOTHING * max(values.energy for values in merits.values()):
            base = None
        for design, values in merits.items():
            gain = 100 * (values.energy / base - 1) if base else None
            residual = float(runs[design, wave.label].attrs["energy_residual"])
            row = {"design": design, "wave": wave.label, **values._asdict()}
            rows.append({**row, "energy_gain_percent": gain, "energy_residual": residual})
    return rows


def as_csv(rows: Sequence[Row]) -> str:
    """Return the comparison as CSV; an empty cell is a quantity that does not exist, such as a gain over nothing."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow(
            {key: f"{v:.10g}" if isinstance(v, float) else "" if v is None else v for key, v in row.items()}
        )
    return text.getvalue()
