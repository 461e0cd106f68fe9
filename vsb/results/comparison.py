"""Designs side by side: the comparison table."""

from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from vsb.results.power import Merit, damper_of, merit
from vsb.study.study import BaseStudy, StillWater, Wave
from vsb.tools.tables import csv_text
from vsb.waves.seas import Sea

TAKE_OFF = ("damping", "stiffness", "power_gain_percent")
INTERVAL = ("low", "high")
"""Of the gain of mean power, by all known sources of error [%]."""
COLUMNS = ("design", "wave", *Merit._fields, "energy_gain_percent", "energy_residual", *TAKE_OFF, *INTERVAL)
NOTHING = 1e-9
"""Energy or power below this part of the best design's is round-off of a buoy at rest: no gain is over it."""
Row = dict[str, Any]
Runs = Mapping[str, xr.Dataset]
"""Design -> its trajectory in a sea."""


def comparison(study: BaseStudy, wave: Wave, runs: Runs, sea: Sea) -> list[Row]:
    """Return one row per design in a sea; gains of energy and of mean power are over the first rigid design's.

    Parameters
    ----------
    study : Study
    wave : Wave
        One of the study's.
    runs : mapping design -> trajectory in this sea
    sea : Sea

    Notes
    -----
    Energy is that of the whole run, start-up included; in still water there is nothing else, and no gain of mean power.
    The interval of a gain is for `vsb.results.intervals.with_intervals` to fill in.
    """
    window = study.simulation.window
    merits = {design: merit(runs[design], wave, sea, study.water, window) for design in study.designs}
    energy = gains({d: m.energy for d, m in merits.items()}, study.reference_design)
    power = gains({d: m.power_mean for d, m in merits.items()}, study.reference_design)
    rows: list[Row] = []
    for design, values in merits.items():
        row = {"design": design, "wave": wave.label, **values._asdict(), "energy_gain_percent": energy[design]}
        row["energy_residual"] = float(runs[design].attrs["energy_residual"])
        gain = None if isinstance(wave, StillWater) else power[design]
        take_off = (damper_of(study, design, runs[design].attrs), study.pto.stiffness, gain)
        rows.append({**row, **dict(zip(TAKE_OFF, take_off, strict=True)), **dict.fromkeys(INTERVAL)})
    return rows


def gains(values: Mapping[str, float], reference: str | None) -> dict[str, float | None]:
    """Return the gain of each design over the reference [%]; nothing over nothing."""
    base = values[reference] if reference else None
    if base is None or base <= NOTHING * max(values.values()):
        return dict.fromkeys(values)
    return {design: 100 * (value / base - 1) for design, value in values.items()}


def as_csv(rows: Sequence[Row]) -> str:
    """Return the comparison as CSV; an empty cell is a quantity that does not exist, such as a gain over nothing."""
    return csv_text(COLUMNS, ([row[name] for name in COLUMNS] for row in rows))
