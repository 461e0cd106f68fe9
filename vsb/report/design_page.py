"""The report of a design problem and its figures: the answer, the buoys, the evidence, and what to doubt."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb import __version__
from vsb.design.certificate import VIOLATION
from vsb.design.compared import COMPETITOR, FLEXIBLE, TWIN
from vsb.design.problem import POWER
from vsb.engine.motion.tuning import matrix_text
from vsb.report.campaign_page import FEWEST_OF_A_LINE
from vsb.report.canvas import STYLES, grid_of_axes, legend_above, style
from vsb.report.design_answer import (
    OBJECTIVES,
    Facts,
    answer,
    ends,
    grouped,
    in_full,
    may_be_run,
    range_with_unit,
    with_unit,
    worth,
)
from vsb.report.page import captioned, page
from vsb.study.design import CONTROLLED, unit_of
from vsb.tools.variables import FORCE, KINDS
from vsb.tools.words import gains_within, superscripts, watts_and_ends, watts_within

BUOYS = (
    "annual_mean_power", "damping", "force_rms", "stroke_rms", "beam", "draft", "mass", "surface", "volume",
    "static_strain", "load_factor", "damage",
)  # fmt: skip
"""Rows of the table of buoys; that of the damage only where cycles of strain are given."""

STROKES_HELD = 20.0
"""Rms strokes of the year from rest to where a spring below zero takes over, below which the page says so: the storms
of a year have twice its rms waves or more, longer ones that such a spring is tuned to, and peaks of four standard
deviations."""


def render(facts: Facts, figures: Mapping[str, str], identity: str) -> str:
    """Return the report as one HTML page."""
    said = answer(facts)
    return page(
        "design.html.j2",
        name=facts["name"],
        climate=facts["climate"],
        objective=OBJECTIVES[facts["maximise"]],
        answer=said.stands,
        below=said.below,
        sketches=(),
        kind="year",
        animated=None,
        still="",
        interactive="",
        warnings=warnings(facts),
        buoys=buoys_table(facts),
        variables=variables_table(facts),
        limits=limits_table(facts),
        starts=starts_table(facts),
        fronts=[front_table(facts, limit) for limit in facts["fronts"]],
        budget=budget_table(facts),
        power_budget=power_budget_table(facts),
        figures=captioned(figures, captions(facts, list(figures))),
        facts={
            "Program": f"vsb {__version__}",
            "Command": f"vsb run {facts['name']}.yaml",
            "Study": facts["study"],
            "Climate": facts["climate"],
            "Content id": identity,
        },
    )


def warnings(facts: Facts) -> list[str]:
    """Return what makes the answer doubtful."""
    found = [f"{note}." for note in facts["notes"]]
    if facts["verified"] is None:
        estimated = "; verify in the file estimates it" if may_be_run(facts) else ""
        found.append(f"All results are linear theory; its own error is not in the interval{estimated}.")
    found += [f"Not in the interval: {name}." for name in facts["unknown"]]
    for name in (FLEXIBLE, COMPETITOR):
        one = facts["found"][name]
        if not one["accepted"]:
            found.append(f"The {name} is not a proven optimum: {one['message']}.")
    lost = [one for some in facts["starts"].values() for one in some if not one["accepted"]]
    if lost:
        total = sum(map(len, facts["starts"].values()))
        found.append(f"{len(lost)} of {total} starts did not end at a certified optimum; starts.csv says why.")
    for name, held in facts.get("held", {}).items():
        stroke = facts["quantities"][name]["stroke_rms"]
        if name in (FLEXIBLE, COMPETITOR) and held < STROKES_HELD * stroke:
            found.append(
                f"The {name} does not come back once it is {held:.3g} m from its rest in still water, "
                f"{held / stroke:.2g} times its rms stroke: its spring is below zero and then stronger than the water. "
                "Linear theory does not contain this; a greater pto.stiffness prevents it, verify shows it in time."
            )
    if facts["doubted"]:
        found.append(
            f"The best flexible buoy is {facts['doubted'].removeprefix('doubtful: ')}, where its material's law is "
            "doubtful."
        )
    return found


def buoys_table(facts: Facts) -> dict[str, Any]:
    """Return the buoys side by side."""
    names, rows = list(facts["power"]), []
    for key in BUOYS:
        known = [facts["quantities"][name].get(key) for name in names]
        if key == "load_factor":
            loads = [facts["quantities"][name].get("load_factor_inverse_0") or 0.0 for name in names]
            known = [1 / load if load > 0 else None for load in loads]
        if key == POWER:
            texts, unit = watts_and_ends([ends(facts["powers"][name]) for name in names])
            for title, place in ((in_full(key), 0), ("from", 1), ("to", 2)):
                rows.append([title, *(f"{text[place]} {unit}" for text in texts)])
            continue
        if key not in ("damage", "damping", *CONTROLLED) or any(value is not None for value in known):
            units = [unit_of(key, KINDS.get(facts["take_offs"][name]["kind"], FORCE)) for name in names]
            rows.append([in_full(key), *map(with_unit, known, units)])
        take_offs = [facts["take_offs"][name] for name in names]
        if key == "damping" and any("matrix" in one for one in take_offs):
            matrices = (
                f"{', '.join(one['ports'])}: {matrix_text(np.array(one['matrix']), 3)}" if "matrix" in one else "-"
                for one in take_offs
            )
            rows.append(["damper matrix [SI]", *matrices])
    return {"head": ["quantity", *names], "body": rows}


def variables_table(facts: Facts) -> dict[str, Any]:
    """Return the values of the variables of both best buoys with their bounds."""
    found: dict[str, list[str]] = {}
    for place, name in enumerate((FLEXIBLE, COMPETITOR)):
        for one in facts["found"][name]["variables"]:
            bounds = range_with_unit(one["low"], one["high"], one["unit"])
            row = found.setdefault(one["key"], [one["key"], bounds, "-", "-"])
            row[2 + place] = with_unit(one["value"], one["unit"])
    return {"head": ["variable", "bounds", FLEXIBLE, COMPETITOR], "body": list(found.values())}


def limits_table(facts: Facts) -> dict[str, Any]:
    """Return the limits, what the best buoys make of them, and what wider ones would bring."""
    rows = []
    held = {name: grouped(facts["found"][name]["multipliers"]) for name in (FLEXIBLE, COMPETITOR)}
    holds = facts["holds"]
    built = [name for name in (FLEXIBLE, COMPETITOR) if holds[name]]
    for limit, value in facts["limits"].items():
        cells = [in_full(limit), with_unit(value, unit_of(limit))]
        for name in (FLEXIBLE, COMPETITOR):
            multiplier = held[name].pop(limit, None)
            cells.append("-" if multiplier is None else worth(facts, limit, multiplier).partition("(")[2].rstrip(")"))
        cells += [f"{100 * holds[name][limit]:.1f} %" if limit in holds[name] else "-" for name in built]
        rows.append(cells)
    for name, some in held.items():
        for limit, multiplier in some.items():
            cells = [limit, "-", "-", "-", *["-"] * len(built)]
            cells[2 if name == FLEXIBLE else 3] = worth(facts, limit, multiplier).partition("(")[2].rstrip(")")
            rows.append(cells)
    head = ["limit", "value", f"{FLEXIBLE}: gain if wider", f"{COMPETITOR}: gain if wider"]
    return {"head": [*head, *(f"{name}: holds as built" for name in built)], "body": rows}


def starts_table(facts: Facts) -> dict[str, Any]:
    """Return where the starts ended, their power with its interval, and their certificates."""
    every = [one for some in facts["starts"].values() for one in some]
    known = [ends(one["within"]) for one in every if one["objective"] is not None]
    texts, unit = watts_within(known) if known else ([], "W")
    powers, rows = iter(texts), []
    for name, some in facts["starts"].items():
        for i, one in enumerate(some):
            numbers = ["-"] * 3
            if one["objective"] is not None:
                numbers = [next(powers), f"{one['kkt']:.1e}", f"{one['violation']:.1e}"]
            verdict = "optimum" if one["accepted"] else one["message"]
            rows.append([name, str(i + 1), verdict, *numbers, str(one["evaluations"])])
    head = ["buoy", "start", "ended at", f"power [{unit}]", "KKT", "violation", "evaluations"]
    return {"head": head, "body": rows}


def front_table(facts: Facts, limit: str) -> dict[str, Any]:
    """Return the best buoys over the values of a limit: their powers and the gain, with intervals."""
    of = facts["fronts"][limit]
    some = [(name, one) for name, points in of.items() for one in points]
    texts, unit = watts_within([ends(one["power"]) for _, one in some]) if some else ([], "W")
    gained = [one for one in of[FLEXIBLE] if one["gain"]]
    gains = gains_within([ends(one["gain"]) for one in gained]) if gained else []
    rows: dict[float, list[str]] = {}
    for (name, one), text in zip(some, texts, strict=True):
        row = rows.setdefault(one["limit"], [with_unit(one["limit"], unit_of(limit)), "-", "-", "-", "optimum"])
        row[1 if name == FLEXIBLE else 2] = text if one["violation"] <= VIOLATION else "-"
        if not one["accepted"]:
            row[4] = f"{name}: {one['message'] or 'not a proven optimum'}"
    for one, gain in zip(gained, gains, strict=True):
        rows[one["limit"]][3] = gain
    head = [in_full(limit), f"{FLEXIBLE} [{unit}]", f"{COMPETITOR} [{unit}]", "gain", "ended at"]
    return {
        "name": f"pareto_{limit}",
        "title": in_full(limit),
        "head": head,
        "body": [rows[key] for key in sorted(rows)],
    }


def budget_table(facts: Facts) -> dict[str, Any]:
    """Return what the gain is uncertain by."""
    rows = [
        [one["name"], f"{one['low']:+z.3f}", f"{one['high']:+z.3f}", one["kind"], "yes" if one["shared"] else "no"]
        for one in facts["budget"]
    ]
    return {"head": ["source", "low [points]", "high [points]", "kind", "shared"], "body": rows}


def power_budget_table(facts: Facts) -> dict[str, Any]:
    """Return what the powers of the buoys are uncertain by [W]."""
    names = list(facts["powers"])
    sources = list(dict.fromkeys(one["name"] for name in names for one in facts["powers"][name]["budget"]))
    rows = []
    for source in sources:
        cells = [source]
        for name in names:
            some = [one for one in facts["powers"][name]["budget"] if one["name"] == source]
            cells.append(f"{some[0]['low']:+.3g} to {some[0]['high']:+.3g}" if some else "-")
        rows.append(cells)
    return {"head": ["source", *(f"{name} [W]" for name in names)], "body": rows}


FARTHEST = 1.5
"""Distance from the gain to none, in widths of its interval, up to which both are drawn: else no bar could be read."""
THOUSANDS = ("force_rms", "mass")
"""Limits shown in thousands."""


def look(facts: Facts, name: str) -> dict[str, Any]:
    """Return colour, line style and label of a buoy: the best ones as their designs are drawn everywhere."""
    designs = facts["designs"]
    if name in designs:
        return {**style(designs[name], list(designs.values()), designs.get(COMPETITOR)), "label": name}
    colour, line = (STYLES[3][0], "--") if name == TWIN else STYLES[6]  # the twin's hull lies on the flexible one's
    return {"color": colour, "linestyle": line, "label": name}


def best_shapes(facts: Facts, ds: xr.Dataset) -> Figure:
    """Draw the hulls at rest to scale, the water below z = 0."""
    figure, axes = grid_of_axes(4.2)
    ax = axes[0, 0]
    for name in map(str, ds.buoy.values):
        one = ds.sel(buoy=name)
        x = np.concatenate([one.outline_x.values, -one.outline_x.values[::-1]])
        z = np.concatenate([one.outline_z.values, one.outline_z.values[::-1]])
        ax.plot(x, z, **look(facts, name))
    wide = 1.25 * float(ds.outline_x.max())
    low = float(ds.outline_z.min())
    ax.axhspan(1.2 * low, 0.0, color="#56B4E9", alpha=0.12, linewidth=0)
    ax.axhline(0.0, color="#56B4E9", linewidth=1.0)
    ax.set(xlim=(-wide, wide), ylim=(1.2 * low, 1.15 * float(ds.outline_z.max())), aspect="equal")
    ax.set(xlabel="distance from the axis [m]", ylabel="height above still water [m]")
    legend_above(figure, ax)
    return figure


def starts(facts: Facts, ds: xr.Dataset) -> Figure:
    """Draw the power each start ended at: filled where it is a certified optimum."""
    figure, axes = grid_of_axes(2.8)
    ax = axes[0, 0]
    for name, shift in ((FLEXIBLE, -0.1), (COMPETITOR, 0.1)):
        line = look(facts, name)
        for i, one in enumerate(facts["starts"][name]):
            if one["power"] is not None:
                face = line["color"] if one["accepted"] else "white"
                label = name if i == 0 else "_"
                ax.plot(i + 1 + shift, one["power"] / 1e3, "o", color=line["color"], markerfacecolor=face, label=label)
    ax.set(xlabel="start", ylabel="mean power of the year [kW]")
    ax.set_xticks(range(1, 1 + max(map(len, facts["starts"].values()))))
    if ax.get_legend_handles_labels()[1]:
        legend_above(figure, ax)
    return figure


def pareto(facts: Facts, limit: str) -> Figure:
    """Draw the objective over the values of one limit."""
    figure, axes = grid_of_axes(3.2)
    ax, unit = axes[0, 0], unit_of(limit)
    factor, prefix = (1e-3, "k") if limit in THOUSANDS and unit == "N" else (1.0, "")
    of_power = facts["maximise"] == "annual_mean_power"
    for name, points in facts["fronts"][limit].items():
        line, some = look(facts, name), [one for one in points if one["violation"] <= VIOLATION]
        limits = factor * np.array([one["limit"] for one in some])
        values = [one["quantities"]["annual_mean_power"] / 1e3 if of_power else one["objective"] for one in some]
        ax.plot(
            limits, values, **(line if len(limits) >= FEWEST_OF_A_LINE else {**line, "linestyle": "", "marker": "o"})
        )
        for x, y, one in zip(limits, values, some, strict=True):
            ax.plot(x, y, "o", color=line["color"], markerfacecolor=line["color"] if one["accepted"] else "white")
    bracket = "" if unit == "1" else f" [{prefix}{superscripts(unit)}]"
    ax.set(xlabel=f"limit of the {in_full(limit)}{bracket}")
    ax.set(ylabel="mean power of the year [kW]" if of_power else OBJECTIVES[facts["maximise"]])
    legend_above(figure, ax)
    return figure


def sensitivity(facts: Facts, ds: xr.Dataset) -> Figure:
    """Draw the change of power with each variable as bars, limits left aside."""
    rows = [one for one in facts["sensitivity"] if one["per"] in ("logarithm", "range")]
    keys = list(dict.fromkeys(one["variable"] for one in rows))
    figure, axes = grid_of_axes(1.2 + 0.36 * len(keys))
    ax = axes[0, 0]
    for name, shift in ((FLEXIBLE, -0.19), (COMPETITOR, 0.19)):
        own = {one["variable"]: one["slope"] for one in rows if one["buoy"] == name}
        at = [keys.index(key) + shift for key in own]
        ax.barh(at, list(own.values()), height=0.36, color=look(facts, name)["color"], label=name)
    per = {one["variable"]: one["per"] for one in rows}
    labels = [key.replace("_", " ") + (" (per range)" if per[key] == "range" else "") for key in keys]
    ax.set_yticks(range(len(keys)), labels)
    ax.invert_yaxis()
    ax.axvline(0.0, color="black", linewidth=0.8)
    ax.set(xlabel="d ln(power) / d ln(variable), or per its range")
    legend_above(figure, ax)
    return figure


def budget(facts: Facts, ds: xr.Dataset) -> Figure:
    """Draw what the gain is uncertain by as bars, and all together."""
    gain = facts["gain"]
    rows = [(one["name"], one["low"], one["high"]) for one in facts["budget"]]
    rows.append(("all together", gain["low"] - gain["value"], gain["high"] - gain["value"]))
    figure, axes = grid_of_axes(0.9 + 0.32 * len(rows))
    ax: Axes = axes[0, 0]
    colour = look(facts, FLEXIBLE)["color"]
    for i, (_, low, high) in enumerate(rows):
        ax.barh(i, high - low, left=low, height=0.6, color=colour if i == len(rows) - 1 else "#999999")
        ends = f" {low:+.3f} to {high:+.3f}"  # bars of small sources are too narrow to be read
        ax.annotate(ends, (1.0, i), xycoords=("axes fraction", "data"), va="center", fontsize="small")
    ax.set_yticks(range(len(rows)), [name.replace("_", " ") for name, _, _ in rows])
    ax.invert_yaxis()
    ax.axvline(0.0, color="black", linewidth=0.8)
    ax.set(xlabel="change of the gain [percentage points]")
    if abs(gain["value"]) <= FARTHEST * (gain["high"] - gain["low"]):
        ax.axvline(-gain["value"], color="black", linewidth=0.8, linestyle=":")
        ax.set(xlabel="change of the gain [percentage points]; dotted: no gain")
    return figure


DRAWN: Mapping[str, Callable[[Facts, xr.Dataset], Figure]] = {
    "best_shapes": best_shapes,
    "starts": starts,
    "sensitivity": sensitivity,
    "budget": budget,
}


def figure_of(name: str, facts: Facts, ds: xr.Dataset) -> Figure:
    """Return a figure by its name."""
    if name.startswith("pareto_"):
        return pareto(facts, name.removeprefix("pareto_"))
    return DRAWN[name](facts, ds)


def captions(facts: Facts, names: Sequence[str]) -> dict[str, str]:
    """Return the captions of figures by name."""
    found = {
        "best_shapes": "The hulls at rest, to scale; the line at zero is still water.",
        "starts": "Mean power of the year where each start of the optimiser ended; filled: a certified optimum, "
        "open: not.",
        "sensitivity": "Relative change of mean power with each variable at the best buoys, all else kept and limits "
        "left aside.",
        "budget": "What the gain over the best rigid buoy is uncertain by, 95 %; bounds add linearly, statistics "
        "quadratically, both linearly.",
    }
    for name in names:
        if name.startswith("pareto_"):
            limit = in_full(name.removeprefix("pareto_"))
            found[name] = (
                f"The best buoys over the limit of the {limit}, each begun at its neighbour; filled: a certified "
                "optimum, open: not."
            )
    return found
