"""Figures of a design problem: the hulls to scale, where the starts ended, Pareto fronts, sensitivities, the budget."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.design.certificate import VIOLATION
from vsb.design.compared import COMPETITOR, FLEXIBLE, TWIN
from vsb.report.campaign_figures import FEWEST_OF_A_LINE
from vsb.report.canvas import STYLES, grid_of_axes, legend_above, style
from vsb.report.design_answer import OBJECTIVES, Facts, in_full
from vsb.study.design import unit_of
from vsb.tools.words import superscripts

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
