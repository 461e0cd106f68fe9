"""Command compare of people: finished studies and campaigns side by side, of checked results alone."""

import csv
import io
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from vsb.errors import ConfigError
from vsb.study.body_plan import AnyPlan
from vsb.study.campaign_plan import CampaignPlan, plan_of
from vsb.study.specs import leading_tuning
from vsb.tools.files import load, write_text
from vsb.tools.stamps import read_text
from vsb.tools.words import plain


class Line(NamedTuple):
    """One design of a study in one sea, or of a point of a campaign over its year; none: there is no such number."""

    study: str
    point: str  # what is varied of a campaign, in words
    design: str
    sea: str  # of a campaign its climate
    tuning: str
    power_mean: float | None  # [W]
    gain_percent: float | None  # over the rigid design under the same tuning
    damping: float | None  # [N s/m]
    capture_width: float | None  # [m]
    annual_energy: float | None  # [MWh]


HEAD = ("study", "point", "design", "sea", "tuning", "power [W]", "gain [%]", "damper [N s/m]", "width [m]", "MWh/year")
MOST_POINTS = 24
"""Points of a campaign a table shows; the file holds all."""


def side_by_side(configs: Sequence[str]) -> list[Line]:
    """Return the lines of finished studies and campaigns, in the order they are named.

    Parameters
    ----------
    configs : sequence of str
        Their files.

    Raises
    ------
    ConfigError
        If one is named twice, or two share a name.
    DatabaseError
        If results are missing, damaged, or of another state of their file.
    """
    return lines([plan_of(config) for config in configs])


def lines(plans: Sequence[AnyPlan | CampaignPlan]) -> list[Line]:
    """Return the lines of plans that were run; see `side_by_side`."""
    names = [plan.name if isinstance(plan, CampaignPlan) else plan.study.study for plan in plans]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ConfigError(f"compare: received {twice[0]} more than once; needs every study and campaign once")
    return [line for plan in plans for line in (_of_year(plan) if isinstance(plan, CampaignPlan) else _of_study(plan))]


def _of_study(plan: AnyPlan) -> Iterator[Line]:
    """Every design in every sea, at its own best damper; without BEM as it was run."""
    found = json.loads(read_text(f"{plan.folder}/tables.json", plan.manifest, plan.study_id))
    name = plan.study.study
    for row in found["equal_tuning"]:
        numbers = (row["best_power"], row["best_gain_percent"], row["best_damping"])
        yield Line(name, "", row["design"], row["sea"], "each", *numbers, _width(found, row), None)
    for row in [] if found["equal_tuning"] else found["comparison"]:
        numbers = (row["power_mean"], row["power_gain_percent"], row["damping"])
        power, gain, damping = map(_known, numbers)
        yield Line(name, "", row["design"], row["wave"], "fixed", power, gain, damping, None, None)


def _width(found: dict[str, list[dict[str, float]]], row: dict[str, float]) -> float | None:
    """Capture width at the best damper, by the energy flux of the run in the same sea; none of several realisations."""
    for run in found["comparison"]:
        if (run["design"], run["wave"]) == (row["design"], row["sea"]):
            power, width = _known(run["power_mean"]), _known(run["capture_width"])
            return row["best_power"] * width / power if power and width else None
    return None


def _of_year(plan: CampaignPlan) -> Iterator[Line]:
    """Every design at every point over the year, under the tuning of the report's answer."""
    from vsb.results.campaign import damper

    tuning = leading_tuning(plan.loaded.tuning)
    ds = load(plan.data_path, expected=plan.campaign_id)
    ds = ds.assign(damper=damper(ds)).sel(tuning=tuning)
    points = [str(dim) for dim in ds.margin.dims]
    stacked = ds.stack(point=points, create_index=False) if points else ds.expand_dims("point")
    names = ("annual_mean_power", "gain_percent", "damper", "capture_width", "annual_energy")
    for i, point in enumerate(plan.loaded.campaign.vary.points):
        words = ", ".join(f"{key} {value:g}" if isinstance(value, float) else value for key, value in point.items())
        for design in map(str, ds.design.values):
            one = stacked.isel(point=i).sel(design=design)
            numbers = [_known(float(one[name])) if name in one else None for name in names]
            yield Line(plan.name, words, design, str(ds.attrs["climate"]), tuning, *numbers)


def _known(value: float | str | None) -> float | None:
    """A number; none of what is missing."""
    return None if value in ("", None) or float(value) != float(value) else float(value)


def as_text(lines: Sequence[Line]) -> str:
    """Return a table for a terminal, numbers to the right; columns nobody has are left out."""
    cells = [HEAD, *([_cell(value, field) for field, value in line._asdict().items()] for line in _shown(lines))]
    kept = [j for j in range(len(HEAD)) if any(row[j] not in ("", "-") for row in cells[1:])]
    widths = {j: max(len(row[j]) for row in cells) for j in kept}
    text = [
        "  ".join(row[j].rjust(widths[j]) if j > 4 else row[j].ljust(widths[j]) for j in kept).rstrip() for row in cells
    ]
    left = len(lines) - len(_shown(lines))
    return "\n".join([*text, *([f"{left} more lines with --out FILE.csv"] if left else [])])


def _shown(lines: Sequence[Line]) -> list[Line]:
    """Lines of the first points of every campaign."""
    points = {(line.study, line.point): None for line in lines}
    first = {study: [point for name, point in points if name == study][:MOST_POINTS] for study, _ in points}
    return [line for line in lines if line.point in first[line.study]]


def _cell(value: str | float | None, field: str) -> str:
    """A value as a table shows it."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return f"{value:+.1f}" if field == "gain_percent" else plain(value)


def as_csv(lines: Sequence[Line]) -> str:
    """Return all lines as CSV; an empty cell is a number there is none of."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Line._fields)
    writer.writerows(["" if v is None else f"{v:.12g}" if isinstance(v, float) else v for v in line] for line in lines)
    return text.getvalue()


def compare(configs: Sequence[str], out: str | None) -> str:
    """Return the table of finished studies and campaigns, and write it as CSV if a file is named."""
    if out is not None and Path(out).suffix != ".csv":
        raise ConfigError(f"--out: received {out}, needs a file that ends in .csv")
    found = side_by_side(configs)
    if out is not None:
        write_text(out, as_csv(found))
    return as_text(found)
