"""Command compare of people: finished studies and campaigns side by side, of checked results alone."""

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from vsb.errors import ConfigError
from vsb.report.side_by_side import Line, as_csv, as_page, as_text
from vsb.stages.planning import plan_of
from vsb.study.campaign import leading_tuning
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import AnyPlan
from vsb.study.take_off import port_kind
from vsb.tools.files import load, write_text
from vsb.tools.stamps import read_text


def lines(plans: Sequence[AnyPlan | CampaignPlan]) -> list[Line]:
    """Return the lines of studies and campaigns that were run, in their order.

    Raises `ConfigError` if one is named twice, or two share a name; `DatabaseError` if results are missing, damaged, or
    of another state of their file.
    """
    names = [plan.name for plan in plans]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ConfigError(f"compare: received {twice[0]} more than once; needs every study and campaign once")
    return [line for plan in plans for line in (_of_year(plan) if isinstance(plan, CampaignPlan) else _of_study(plan))]


def _of_study(plan: AnyPlan) -> Iterator[Line]:
    """Every design in every sea, at its own best damper; without BEM as it was run."""
    found = json.loads(read_text(f"{plan.folder}/tables.json", plan.manifest, plan.identity))
    name, unit = plan.study.study, port_kind(plan.study.pto.port).damping_unit
    for row in found["equal_tuning"]:
        numbers = (row["best_power"], row["best_gain_percent"], row["best_damping"])
        yield Line(name, "", row["design"], row["sea"], "each", *numbers, _width(found, row), None, unit)
    for row in [] if found["equal_tuning"] else found["comparison"]:
        numbers = (row["power_mean"], row["power_gain_percent"], row["damping"])
        power, gain, damping = map(_known, numbers)
        yield Line(name, "", row["design"], row["wave"], "fixed", power, gain, damping, None, None, unit)


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
    ds = load(plan.data_path, expected=plan.identity)
    unit = str(ds.damping.attrs["units"])
    ds = ds.assign(damper=damper(ds)).sel(tuning=tuning)
    points = [str(dim) for dim in ds.margin.dims]
    stacked = ds.stack(point=points, create_index=False) if points else ds.expand_dims("point")
    names = ("annual_mean_power", "gain_percent", "damper", "capture_width", "annual_energy")
    for i, point in enumerate(plan.loaded.campaign.vary.points):
        words = ", ".join(f"{key} {value:g}" if isinstance(value, float) else value for key, value in point.items())
        for design in map(str, ds.design.values):
            one = stacked.isel(point=i).sel(design=design)
            power, gain, damping, width, energy = (_known(float(one[name])) if name in one else None for name in names)
            where = (plan.name, words, design, str(ds.attrs["climate"]), tuning)
            yield Line(*where, power, gain, damping, width, energy, unit)


def _known(value: float | str | None) -> float | None:
    """A number; none of what is missing."""
    return None if value in ("", None) or float(value) != float(value) else float(value)


def compare(configs: Sequence[str], out: str | None) -> str:
    """Return the table of finished studies and campaigns, and write it as CSV or as a page if a file is named."""
    kind = None if out is None else Path(out).suffix
    if kind not in (None, ".csv", ".html"):
        raise ConfigError(f"--out: received {out}, needs a file that ends in .csv or .html")
    plans = [_compared(config) for config in configs]
    found = lines(plans)
    if out is not None:
        write_text(out, as_csv(found) if kind == ".csv" else as_page(found, _reports(plans, Path(out).parent)))
    return as_text(found)


def _compared(config: str) -> AnyPlan | CampaignPlan:
    """The plan of a study or campaign; a design problem has no designs of its own."""
    plan = plan_of(config)
    if isinstance(plan, DesignPlan):
        raise ConfigError(f"{config}: received a design problem, needs a study or campaign, such as its optimum.yaml")
    return plan


def _reports(plans: Sequence[AnyPlan | CampaignPlan], folder: Path) -> dict[str, tuple[str, str]]:
    """Report of every plan, as seen from a folder, and its content id, by name."""
    paths = [Path(os.path.relpath(f"{plan.folder}/report.html", folder)).as_posix() for plan in plans]
    return {plan.name: (path, plan.identity) for plan, path in zip(plans, paths, strict=True)}
