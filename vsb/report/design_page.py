"""The report of a design problem: the answer first, then the buoys, the evidence, and what to doubt."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vsb import __version__
from vsb.design.certificate import VIOLATION
from vsb.design.compared import COMPETITOR, FLEXIBLE
from vsb.design.problem import POWER
from vsb.engine.motion.damper_matrix import matrix_text
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
from vsb.report.design_figures import captions
from vsb.report.html import captioned, page
from vsb.study.design import CONTROLLED, unit_of
from vsb.tools.variables import FORCE, KINDS
from vsb.tools.words import gains_within, watts_and_ends, watts_within

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
        if key == "damping" and any("matrix" in facts["take_offs"][name] for name in names):
            rows.append(["damper matrix [SI]", *(_matrix(facts["take_offs"][name]) for name in names)])
    return {"head": ["quantity", *names], "body": rows}


def _matrix(take_off: Mapping[str, Any]) -> str:
    """The damper matrix of several ports, with their names; a dash for none."""
    if "matrix" not in take_off:
        return "-"
    return f"{', '.join(take_off['ports'])}: {matrix_text(np.array(take_off['matrix']), 3)}"


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
