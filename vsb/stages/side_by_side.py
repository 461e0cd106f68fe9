"""Command compare of people: finished studies and campaigns side by side, of checked results alone."""

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from vsb.engine.motion.take_off import DAMPERS, port_kind
from vsb.engine.waves.climate import YEAR_HOURS
from vsb.errors import ConfigError
from vsb.pipeline.graph import AnyPlan
from vsb.pipeline.plans import CampaignPlan, DesignPlan, plan_of
from vsb.report.side_by_side import Line, as_csv, as_page, as_text
from vsb.study.campaign import leading_tuning
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


def left_out(plans: Sequence[AnyPlan | CampaignPlan], found: Sequence[Line]) -> list[str]:
    """Return what of each study and campaign has no line, a sentence each: seas, designs, tunings."""
    missing = []
    for plan in plans:
        own, parts = [line for line in found if line.study == plan.name], dict[str, list[str]]()
        if isinstance(plan, CampaignPlan):
            loaded, there = plan.loaded, {line.tuning for line in own}
            parts = {"tuning": [one for one in loaded.tuning if one not in there], "power": ["in single seas"]}
        else:
            seas, designs = ({getattr(line, key) for line in own} for key in ("sea", "design"))
            parts = {
                "sea": [sea for sea in dict.fromkeys(wave.family for wave in plan.study.waves) if sea not in seas],
                "design": [design for design in plan.study.designs if design not in designs],
            }
        words = [f"{kind} {', '.join(names)}" for kind, names in parts.items() if names]
        missing += [f"Left out of {plan.name}: {'; '.join(words)}; see {plan.folder}."] if words else []
    return missing


def _of_study(plan: AnyPlan) -> Iterator[Line]:
    """Every design in every sea, at its own best damper, then at that of the runs where it is another one."""
    found = json.loads(read_text(f"{plan.folder}/tables.json", plan.manifest, plan.identity))
    name, unit = plan.study.study, port_kind(plan.study.pto.port).damping_unit
    for row in found["equal_tuning"]:
        numbers = (
            row["best_power"],
            row["best_gain_percent"],
            row["best_damping"],
            _width(plan, found, row),
            None,
            unit,
        )
        ends = (row["best_power_low"], row["best_power_high"], row["best_low"], row["best_high"])
        yield Line(name, "", row["design"], row["sea"], "each", *numbers, *ends)
    after = {(row["design"], row["sea"]): row for row in found["equal_tuning"]}
    listed: set[str] = set()
    for wave in plan.study.waves:
        tuning, sea = plan.study.tuning(wave), wave.family  # one for all realisations, which have one mean power
        of_damper = plan.study.pto.law in DAMPERS
        if sea in listed or (found["equal_tuning"] and (wave.still or (tuning == "each" and of_damper))):
            continue
        listed.add(sea)
        for row in found["comparison"]:
            if row["wave"] == wave.label:
                power, gain, damping, width, *within = (_known(row.get(key)) for key in OF_RUNS)
                under = tuning if of_damper else plan.study.pto.law
                if plan.study.pto.efficiency < 1 and power:  # runs are before conversion, other lines after it
                    own = after.get((row["design"], sea)) if of_damper else None
                    if own is None or own["power"] is None:
                        under += ", before conversion"
                    else:
                        width = None if width is None else width * own["power"] / power
                        power, gain, damping, *within = (_known(own[key]) for key in AFTER_CONVERSION)
                yield Line(name, "", row["design"], sea, under, power, gain, damping, width, None, unit, *within)


OF_RUNS = ("power_mean", "power_gain_percent", "damping", "capture_width", "power_low", "power_high", "low", "high")
"""Columns of the comparison that a line has."""
AFTER_CONVERSION = ("power", "gain_percent", "damping", "power_low", "power_high", "low", "high")
"""Those of designs at equal tuning, at the damping of the runs."""


def _width(plan: AnyPlan, found: dict[str, list[dict[str, Any]]], row: dict[str, Any]) -> float | None:
    """Capture width at the best damper, by the energy flux of the sea: that of the runs, over their power."""
    labels = {wave.label for wave in plan.study.waves if wave.family == row["sea"]}
    for run in found["comparison"]:
        if run["design"] == row["design"] and run["wave"] in labels:
            power, width = _known(run["power_mean"]), _known(run["capture_width"])
            return row["best_power"] * width / power if power and width else None
    return None


def _of_year(plan: CampaignPlan) -> Iterator[Line]:
    """Every design at every point over the year, under the tuning of the answer, by runs where they correct it."""
    from vsb.results.campaign import GAIN, POWER, damper, in_time
    from vsb.results.year import POWER_ENDS

    tuning = leading_tuning(plan.loaded.tuning)
    ds = load(plan.data_path, expected=plan.identity)
    unit = str(ds.damping.attrs["units"])
    names = {"power": "annual_mean_power", "power_low": POWER_ENDS[0], "power_high": POWER_ENDS[1]}
    names |= {"gain": "gain_percent", "low": "gain_low", "high": "gain_high"}
    if ds.attrs.get("verified_tuning") == tuning:
        corrected = [in_time(ds.attrs["verified_model"], name) for name in (*POWER, *GAIN)]
        names |= {key: name for key, name in zip(names, corrected, strict=True) if name in ds}
    ds = ds.assign(damper=damper(ds)).sel(tuning=tuning)
    points = [str(dim) for dim in ds.margin.dims]
    stacked = ds.stack(point=points, create_index=False) if points else ds.expand_dims("point")
    for i, point in enumerate(plan.loaded.campaign.vary.points):
        words = ", ".join(f"{key} {value:g}" if isinstance(value, float) else value for key, value in point.items())
        for design in map(str, ds.design.values):
            one = stacked.isel(point=i).sel(design=design)
            value = {key: _known(float(one[name])) if name in one else None for key, name in names.items()}
            damping, width, linear = (_known(float(one[k])) for k in ("damper", "capture_width", "annual_mean_power"))
            power = value["power"]
            energy = None if power is None else power * YEAR_HOURS / 1e6
            width = power * width / linear if power is not None and width is not None and linear else width
            where = (plan.name, words, design, str(ds.attrs["climate"]), tuning)
            ends = (value["power_low"], value["power_high"], value["low"], value["high"])
            yield Line(*where, power, value["gain"], damping, width, energy, unit, *ends)


def _known(value: Any) -> float | None:
    """A number; none of what is missing."""
    return None if value in ("", None) or float(value) != float(value) else float(value)


def compare(configs: Sequence[str], out: str | None, root: str = "results") -> str:
    """Return the table of finished studies and campaigns, and write it as CSV or as a page if a file is named.

    `root` is the folder of all results.
    """
    kind = None if out is None else Path(out).suffix
    if kind not in (None, ".csv", ".html"):
        raise ConfigError(f"--out: received {out}, needs a file that ends in .csv or .html")
    plans: list[AnyPlan | CampaignPlan] = []
    for config in configs:
        if isinstance(plan := plan_of(config, root), DesignPlan):
            received = f"{config}: received a design problem"
            raise ConfigError(f"{received}, needs a study or campaign, such as its optimum.yaml")
        plans.append(plan)
    found = lines(plans)
    missing = left_out(plans, found)
    if out is not None:
        pages = {one.name: Path(os.path.relpath(f"{one.folder}/report.html", Path(out).parent)) for one in plans}
        reports = {one.name: (pages[one.name].as_posix(), one.identity) for one in plans}
        write_text(out, as_csv(found) if kind == ".csv" else as_page(found, reports, missing))
    return "\n".join([as_text(found), *missing])
