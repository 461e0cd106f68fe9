"""What the report says first: gains at equal tuning, each design at its own best damper, the given damper beside it."""

from collections.abc import Sequence
from typing import Any

from vsb.report.doubts import no_answer
from vsb.report.headline import interval_text, valid_lines
from vsb.study.take_off import PAUSE, port_kind
from vsb.tools.words import against_rigid, plain, power, short, the_rigid, watts

NO_BEST_DAMPER = (
    "An assumed pressure does not answer to the buoy's motion, so no best damper is known: all gains here are at the "
    "given damper."
)
GIVEN = "At the given damper"
DAMPERS = {"fixed": GIVEN, "each": "In time, at their own best dampers", "one": "In time, at their best for all seas"}
"""`pto.tuning` -> which dampers simulated designs have."""


def dampers_in_words(pto: dict[str, Any]) -> str:
    """Return which dampers simulated designs have, from the take-off of a study in canonical form."""
    if pto.get("law") == "coulomb":
        return f"With Coulomb friction of {short(pto['force_limit'])} {port_kind(pto.get('port')).load_unit}"
    words = DAMPERS[pto.get("tuning", "fixed")]
    if pto.get("law") in PAUSE:
        return f"{words}, {pto['law']}" if words == GIVEN else f"In time, {pto['law']}, with the damper that suits it"
    return f"{words}s" if isinstance(pto.get("damping"), dict) and words == GIVEN else words


def tuned_statements(lines: Sequence[dict[str, Any]], reference: str | None, seas: dict[str, str]) -> list[str]:
    """Return, for each sea, what the designs take at their own best dampers.

    Parameters
    ----------
    lines : sequence of dict
        Of `vsb.results.gains.Tuned`.
    reference : str or None
        The rigid design gains are measured against.
    seas : mapping of sea to words
    """
    statements = []
    for name in dict.fromkeys(line["sea"] for line in lines):
        sea = [line for line in lines if line["sea"] == name]
        base = next((line for line in sea if line["design"] == reference), None)
        others = [line for line in sea if line is not base and line["best_gain_percent"] is not None]
        if base is None or not others:
            parts = [f"{line['design']} absorbs {power(line['best_power'])}" for line in sea]
        else:
            parts = [f"{line['design']} absorbs {_gain(line, base)}" for line in others]
        statements.append(f"In {seas[name]}, each design at its own best damper: {'; '.join(parts)}.")
    return statements


def limited_statements(lines: Sequence[dict[str, Any]], reference: str | None, seas: dict[str, str]) -> list[str]:
    """Return, for each sea, what the designs take at most within the limits of force and stroke.

    Parameters
    ----------
    lines : sequence of dict
        Of `vsb.results.gains.Limited`.
    reference, seas
        See `tuned_statements`.
    """
    statements = []
    for name in dict.fromkeys(line["sea"] for line in lines):
        parts = []
        for line in (line for line in lines if line["sea"] == name):
            known = line["gain_percent"] is not None and line["design"] != reference
            parts.append(
                f"{line['design']} {line['power']:.4g} W" + (f" ({line['gain_percent']:+.1f} %)" if known else "")
            )
        statements.append(f"In {seas[name]}, no take-off within its limits absorbs more than: {', '.join(parts)}.")
    return statements


def _gain(line: dict[str, Any], base: dict[str, Any]) -> str:
    """How a design stands against the reference at equal tuning, in words."""
    (own, its), unit = watts([line["best_power"], base["best_power"]])
    return f"{against_rigid(line['best_gain_percent'], base['design'])} ({own} against {its} {unit})"


def shares_text(lines: Sequence[dict[str, Any]], sea: str, unit: str) -> str:
    """Return what part of its own optimum each design reaches in a sea at the given damper; nothing if not known."""
    known = [line for line in lines if line["sea"] == sea and line["share"] is not None]
    if not known:
        return ""
    dampers = " and ".join(dict.fromkeys(f"{line['damping']:g} {unit}" for line in known))
    first, *others = (f"{100 * line['share']:.0f} %" for line in known)
    rest = "".join(f", {line['design']} {share}" for line, share in zip(known[1:], others, strict=True))
    return f"; at {dampers} {known[0]['design']} reaches {first} of its own best{rest}"


PARTS = ("design", "sea", "source of error", "below [points]", "above [points]", "kind")
"""Head of the table of what makes up the interval of a gain."""


def parts_table(lines: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return which source of error is which part of the interval of every gain at the optimal dampers."""
    return [
        [line["design"], line["sea"], source["name"], short(source["low"]), short(source["high"]), source["kind"]]
        for line in lines
        for source in line.get("errors", ())
    ]


def tuning_head(unit: str) -> list[str]:
    """Return the head of the table of designs at equal tuning, by the unit of damping."""
    power = ["mean power [W]", "gain [%]", "interval of the gain"]
    best = ["design", "sea", f"optimal damping [{unit}]", *power]
    return [*best, f"given damping [{unit}]", *power, "share of optimum [%]"]


def tuning_table(lines: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return the cells of the table of designs at equal tuning; a quantity that does not exist is a dash."""

    def text(value: float | None, form: str = "", factor: float = 1.0) -> str:
        return "-" if value is None else format(factor * value, form) if form else plain(value)

    return [
        [
            line["design"], line["sea"],
            text(line["best_damping"]), text(line["best_power"]), text(line["best_gain_percent"], "+.1f"),
            interval_text(line.get("best_low"), line.get("best_high")) or "-",
            text(line["damping"]), text(line["power"]), text(line["gain_percent"], "+.1f"),
            interval_text(line.get("low"), line.get("high")) or "-",
            text(line["share"], ".1f", 100.0),
        ]
        for line in lines
    ]  # fmt: skip


def closing_line(lines: Sequence[dict[str, Any]], reference: str | None, invalid: Sequence[dict[str, Any]] = ()) -> str:
    """Return the answer of a study in one line, to go on from; empty if there is no gain to give.

    Of designs that are valid alone; where none is, that there is no answer and why.
    """
    others = valid_lines(lines, reference, invalid)
    if not others and invalid:
        return f"{no_answer(invalid)} "
    parts = [
        f"{_range(gains)} at {where}"
        for key, where in (("best_gain_percent", "own best dampers"), ("gain_percent", "the given damper"))
        if (gains := [line[key] for line in others if line[key] is not None])
    ]
    return f"mean power against {the_rigid(reference)} {', '.join(parts)}; " if parts and reference else ""


def _range(gains: Sequence[float]) -> str:
    """One gain, or the least and the largest of several [%]."""
    low, high = (f"{bound:+.1f}" for bound in (min(gains), max(gains)))
    return f"{low} %" if low == high else f"{low} to {high} %"
