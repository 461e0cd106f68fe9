"""The answer of a study in sentences: gains with every design at its own optimal damping, and what is not valid."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import xarray as xr

from vsb.engine.motion.take_off import DEFAULTS, LAWS, port_kind
from vsb.report.band import gain_band, useful_band
from vsb.report.doubts import no_answer, reasons
from vsb.tools.words import (
    SAME,
    against,
    gain_decimals,
    gain_text,
    interval_text,
    multiple,
    plain,
    power,
    the_rigid,
    watts,
)

Lines = Sequence[dict[str, Any]]
"""Rows of `vsb.results.gains`: gains of designs in seas, optima within limits, or designs that are not valid."""
MISSING = ("", None)
"""What a table has where a quantity does not exist."""
COMPUTED = "Computed although the model does not hold: "
NO_OPTIMUM = (
    "An assumed pressure does not respond to the motion of the buoy, so optimal damping is unknown: all gains here are "
    "at the given damping."
)
GIVEN = "At the given damping"
DAMPINGS = {
    "fixed": GIVEN,
    "each": "In the time domain, each design at its optimal damping",
    "one": "In the time domain, each design at its best damping over all seas",
}
"""`pto.tuning` -> damping of the simulated designs."""
PARTS = ("design", "sea", "source of error", "below [points]", "above [points]", "kind")
"""Head of the table of what makes up the interval of a gain."""


class Answer(NamedTuple):
    """The answer of a study, in sentences."""

    stands: list[str]  # printed in bold
    below: list[str]  # results that are not valid, marked as such, and designs left out

    @property
    def lines(self) -> list[str]:
        """All sentences."""
        return [*self.stands, *self.below]


def headline(
    lines: Lines,
    best_power: xr.DataArray,
    reference: str | None,
    seas: dict[str, str],
    invalid: Lines = (),
    neglected: str = "",
    aside: str = "",
) -> Answer:
    """Return the answer of a study in its seas and over all waves; empty if there is no gain.

    Parameters
    ----------
    lines : sequence of dict
        Of `vsb.results.gains.Tuned`.
    best_power : DataArray, dims (design, omega) [W/m^2]
        At the optimal damping of each design and frequency.
    reference : str or None
        The rigid design gains are measured against.
    invalid : sequence of dict
        Designs that are not valid in a sea; the best one is chosen among the others.
    neglected : str
        What `best_power` leaves out, in words.
    aside : str
        What powers at optimal damping leave aside, see `limits_aside`.
    """
    others = [line for line in lines if line["design"] != reference and line["best_gain_percent"] is not None]
    if reference is None or not others:
        return Answer([], [])
    valid = valid_lines(others, reference, invalid)
    if not valid:
        found = [_in_seas(others, lines, reference, seas, aside), *_over_band(best_power, reference, neglected)]
        return Answer([no_answer(invalid)], [f"{COMPUTED}{' '.join(found)}"])
    kept = [reference, *dict.fromkeys(line["design"] for line in valid)]
    designs = [design for design in best_power.design.values if design in kept]
    stands = [_in_seas(valid, lines, reference, seas, aside)]
    stands += _over_band(best_power.sel(design=designs), reference, neglected)
    return Answer(stands, _left_out(others, valid, invalid, reference, seas))


def valid_lines(lines: Iterable[dict[str, Any]], reference: str | None, invalid: Iterable[dict[str, Any]]) -> Lines:
    """Return the lines of designs other than the reference that are valid in their sea, as is the reference."""
    broken = {(line["design"], line["sea"]) for line in invalid}
    return [
        line
        for line in lines
        if line["design"] != reference and not {(line["design"], line["sea"]), (reference, line["sea"])} & broken
    ]


def _left_out(others: Lines, valid: Lines, invalid: Lines, reference: str, seas: dict[str, str]) -> list[str]:
    """Gains that are not valid and not part of the answer, and why."""
    kept, found = {(line["design"], line["sea"]) for line in valid}, []
    for line in others:
        if (line["design"], line["sea"]) in kept:
            continue
        why = [one for one in invalid if one["design"] in (line["design"], reference) and one["sea"] == line["sea"]]
        gain = against(float(line["best_gain_percent"]), the_rigid(reference))
        what = f"{line['design']} in {seas[line['sea']]}, computed to absorb {gain}"
        found.append(f"Not valid and not part of this answer: {what}; {' and '.join(reasons(why))}.")
    return found


def _in_seas(shown: Lines, lines: Lines, reference: str, seas: dict[str, str], aside: str) -> str:
    """The largest gain of some lines, in which sea, and its interval."""
    best = max(shown, key=lambda line: float(line["best_gain_percent"]))
    gain, sea = float(best["best_gain_percent"]), best["sea"]
    base = next(line for line in lines if line["design"] == reference and line["sea"] == sea)
    (own, its), unit = watts([best["best_power"], base["best_power"]])
    count = len({line["sea"] for line in shown})
    several = len({line["design"] for line in shown}) > 1
    most = f"the best flexible design, {best['design']}," if several else best["design"]
    where = f"In {seas[sea]}" + (f", the most favourable of {count} seas" if count > 1 else "")
    ends = best.get("best_low"), best.get("best_high")
    interval, decimals = interval_text(*ends), gain_decimals(*ends)
    known = f"{interval} with all known errors; " if interval else ""
    what = f"{most} absorbs {against(gain, the_rigid(reference), decimals)} ({known}{own} against {its} {unit})"
    least, elsewhere = min(float(line["best_gain_percent"]) for line in shown), ""
    if count > 1 and least < 0:
        pays = len({line["sea"] for line in shown if float(line["best_gain_percent"]) > 0})
        elsewhere = f"; flexible designs absorb more in {pays or 'none'} of the {count} seas, "
        elsewhere += f"at worst {-least:.1f} % less"
    return f"{where}, each design at its optimal damping{aside}, {what}{elsewhere}."


def limits_aside(pto: Mapping[str, Any]) -> str:
    """Return what powers at optimal damping leave aside of a take-off, in words that follow; empty if it is nothing.

    Optimal damping is that of a linear take-off, which may exceed limits of force and stroke.
    """
    if pto.get("law", "linear") != "linear":
        return " of a linear take-off"
    limits = [float(pto.get(name, math.inf)) for name in ("force_limit", "stroke_limit")]
    return " without limits" if min(limits) < math.inf else ""


USEFUL = "a design absorbs at least 5 % of the maximum"
WITH_RIGID = "the rigid design absorbs at least 5 % of its maximum, or a tenth of the best one's power"
"""Bands over which gains are stated, see `vsb.report.band`."""


def _over_band(best_power: xr.DataArray, reference: str, neglected: str) -> list[str]:
    """What flexible designs absorb over all waves: the most and the least, where, and which of them."""
    useful, counts = useful_band(best_power), gain_band(best_power, reference)
    shown = best_power.where(counts, drop=True)
    if shown.sizes["omega"] < 2:
        return []
    gain = (100 * (shown / shown.sel(design=reference) - 1)).sel(design=shown.design != reference)
    several, parts = gain.sizes["design"] > 1, []
    for sign, word in ((1, "more"), (-1, "less")):
        place = (sign * gain).argmax(("design", "omega"))
        at = gain.isel({dim: int(where) for dim, where in place.items()})
        if sign * float(at) > SAME:
            size, which = abs(float(at)), f"{at.design.item()} " if several else ""
            amount = multiple(float(at)) or f"{size:.{0 if size >= 1 else 1}f} % {word}"
            parts.append(f"up to {amount} ({which}in waves of {2 * math.pi / float(at.omega):.2f} s)")
    who = "flexible designs absorb" if several else f"{gain.design.values[0]} absorbs"
    least = WITH_RIGID if bool((useful & ~counts).any()) else USEFUL
    where = f"Over the band where {least}, with damping optimal at each frequency"
    return [f"{where}{neglected and f' and {neglected}'}, {who} {' and '.join(parts)}."] if parts else []


def damping_in_words(pto: dict[str, Any]) -> str:
    """Return which damping, or other law, simulated designs have, from the take-off of a study in canonical form."""
    if pto.get("distribution"):
        return f"With the take-off law {pto['law']} of {pto['distribution']}"
    law = LAWS[pto.get("law", "linear")]
    if law.words:
        return f"With {law.words.format(**vars(port_kind(pto.get('port'))) | DEFAULTS | pto)}"
    words = DAMPINGS[pto.get("tuning", "fixed")]
    if law.has_latching_time:
        return f"{words}, {pto['law']}" if words == GIVEN else f"In the time domain, {pto['law']} at its best damping"
    return f"{GIVEN} of each" if isinstance(pto.get("damping"), dict) and words == GIVEN else words


def tuned_statements(lines: Lines, reference: str | None, seas: dict[str, str], aside: str = "") -> list[str]:
    """Return, for each sea, what the designs absorb at their optimal damping; see `headline`."""
    statements = []
    for name in dict.fromkeys(line["sea"] for line in lines):
        sea = [line for line in lines if line["sea"] == name]
        base = next((line for line in sea if line["design"] == reference), None)
        others = [line for line in sea if line is not base and line["best_gain_percent"] is not None]
        if base is None or not others:
            ends = ("best_power_low", "best_power_high")
            parts = [f"{line['design']} absorbs {power(line['best_power'], *map(line.get, ends))}" for line in sea]
        else:
            parts = [f"{line['design']} absorbs {_gain(line, base)}" for line in others]
        statements.append(f"In {seas[name]}, each design at its optimal damping{aside}: {'; '.join(parts)}.")
    return statements


def limited_statements(lines: Lines, reference: str | None, seas: dict[str, str]) -> list[str]:
    """Return, for each sea, what the designs can absorb within the limits of the take-off.

    Parameters
    ----------
    lines : sequence of dict
        Of `vsb.results.gains.Limited`.
    reference, seas
        See `headline`.
    """
    statements = []
    for name in dict.fromkeys(line["sea"] for line in lines):
        parts = []
        for line in (line for line in lines if line["sea"] == name):
            known = line["gain_percent"] is not None and line["design"] != reference
            ends = () if known else (line["power_low"], line["power_high"])
            parts.append(f"{line['design']} {power(line['power'], *ends)}{gain_in_brackets(line) if known else ''}")
        statements.append(f"In {seas[name]}, no take-off within its limits absorbs more than: {', '.join(parts)}.")
    return statements


def at_force_statements(lines: Lines, reference: str | None, seas: dict[str, str], unit: str) -> list[str]:
    """Return, for each irregular sea, what the designs absorb under causal control of one rms force, that of all.

    Parameters
    ----------
    lines : sequence of dict
        Of `vsb.results.gains.AtForce`.
    reference, seas
        See `headline`.
    unit : str
        Of the rms force.
    """
    statements = []
    for name in dict.fromkeys(line["sea"] for line in lines):
        sea = [line for line in lines if line["sea"] == name and line["force_rms"] is not None]
        base = next((line for line in sea if line["design"] == reference), None)
        others = [line for line in sea if line is not base and line["gain_percent"] is not None]
        parts = [f"{line['design']} absorbs {power(line['power'])}" for line in sea]
        if base is not None and others:
            parts = [f"{line['design']} absorbs {_under_control(line, base)}" for line in others]
        if parts:
            force = f"{plain(sea[0]['force_rms'])} {unit}"
            statements.append(f"In {seas[name]}, with causal control of {force} rms: {'; '.join(parts)}.")
    return statements


def _under_control(line: dict[str, Any], base: dict[str, Any]) -> str:
    """How a design stands against the reference under causal control, in words."""
    (own, its), unit = watts([line["power"], base["power"]])
    gain = against(line["gain_percent"], the_rigid(base["design"]), gain_decimals(line["low"], line["high"]))
    interval = interval_text(line["low"], line["high"])
    return f"{gain} ({interval and f'{interval}; '}{own} against {its} {unit})"


AT_FORCE = (
    "design", "sea", "rms force [{}]", "causal control [W]", "gain [%]", "interval [%]", "damper of that force [W]",
    "gain [%]",
)  # fmt: skip
"""Head of the table of causal control."""


def at_force_table(lines: Lines) -> list[list[str]]:
    """Return the cells of the table of causal control, of lines of `vsb.results.gains.AtForce`."""

    def percent(value: float | None, *ends: float | None) -> str:
        return "-" if value is None else gain_text(value, *ends)

    damper = {True: "", False: " (the damper)"}
    return [
        [
            line["design"], line["sea"], "-" if line["force_rms"] is None else plain(line["force_rms"]),
            plain(line["power"]) + damper[line["damper"] is None],
            percent(line["gain_percent"], line["low"], line["high"]),
            interval_text(line["low"], line["high"]) or "-", plain(line["damper_power"]),
            percent(line["damper_gain_percent"]),
        ]
        for line in lines
    ]  # fmt: skip


ELSEWHERE = (
    "design", "tuned in", "peak period [s]", "power [W]", "rms force [{}]", "tuned there [W]", "its rms force [{}]",
    "loss [%]",
)  # fmt: skip
"""Head of the table of controllers in other seas."""


def elsewhere_table(lines: Lines) -> list[list[str]]:
    """Return the cells of controllers in seas they are not tuned in, of lines of `vsb.results.forecast.Elsewhere`."""
    return [
        [
            line["design"], line["sea"], f"{line['period']:.2f}", plain(line["power"]), plain(line["force_rms"]),
            plain(line["own_power"]), plain(line["own_force_rms"]),
            f"{100 * (1 - line['power'] / line['own_power']):z.1f}",
        ]
        for line in lines
    ]  # fmt: skip


def knowledge_text(lines: Lines, dragged: bool = False) -> str:
    """Return what causal control knows of the waves, and of quadratic drag, in words."""
    if not lines:
        return ""
    noise, forecast = lines[0]["noise"], lines[0]["forecast"]
    ahead = f"the waves {forecast:g} s ahead" if forecast else "no future waves"
    said = f"It knows {ahead}, and measures with noise of {10 * math.log10(noise):.0f} dB of the waves' force."
    drag = " Drag counts as the damper equivalent to it under this control; no run in time has checked that."
    return said + drag * dragged


def gain_in_brackets(
    line: Mapping[str, Any], gain: str = "gain_percent", ends: tuple[str, str] = ("low", "high")
) -> str:
    """Return a gain in brackets, with its interval if there is one."""
    low, high = (None if line.get(end) in MISSING else float(line[end]) for end in ends)
    interval = interval_text(low, high)
    return f" ({gain_text(float(line[gain]), low, high)} %{interval and f'; {interval}'})"


def _gain(line: dict[str, Any], base: dict[str, Any]) -> str:
    """How a design stands against the reference at equal tuning, in words."""
    (own, its), unit = watts([line["best_power"], base["best_power"]])
    decimals = gain_decimals(line.get("best_low"), line.get("best_high"))
    return f"{against(line['best_gain_percent'], the_rigid(base['design']), decimals)} ({own} against {its} {unit})"


def shares_text(lines: Lines, sea: str, unit: str) -> str:
    """Return what part of its optimum each design reaches in a sea at the given damping; empty if not known."""
    known = [line for line in lines if line["sea"] == sea and line["share"] is not None]
    if not known:
        return ""
    given = ("the damper matrix" if c is None else f"{c:g} {unit}" for c in (line["damping"] for line in known))
    dampings = " and ".join(dict.fromkeys(given))
    first, *others = (f"{100 * line['share']:.0f} %" for line in known)
    rest = "".join(f", {line['design']} {share}" for line, share in zip(known[1:], others, strict=True))
    return f"; at {dampings} {known[0]['design']} reaches {first} of its optimum{rest}"


def parts_table(lines: Lines) -> list[list[str]]:
    """Return which source of error is which part of the interval of every gain at optimal damping."""
    return [
        [line["design"], line["sea"], source["name"], _points(source["low"]), _points(source["high"]), source["kind"]]
        for line in lines
        for source in line.get("errors", ())
    ]


def _points(value: float) -> str:
    """Percentage points, to a thousandth: more digits of an error mean nothing."""
    return f"{value:.3f}".replace("-0.000", "0.000")


def tuning_head(unit: str) -> list[str]:
    """Return the head of the table of designs at equal tuning, by the unit of damping."""
    measures = ["gain [%]", "interval of the gain", "mean power [W]"]
    best = ["design", "sea", *measures, f"optimal damping [{unit}]"]
    return [*best, *measures, f"given damping [{unit}]", "share of optimum [%]"]


def tuning_table(lines: Lines) -> list[list[str]]:
    """Return the cells of the table of designs at equal tuning; a quantity that does not exist is a dash."""

    def text(value: float | None, form: str = "", factor: float = 1.0) -> str:
        return "-" if value is None else format(factor * value, form) if form else plain(value)

    def gain(value: float | None, *ends: float | None) -> str:
        return "-" if value is None else gain_text(value, *ends)

    return [
        [
            line["design"], line["sea"],
            gain(line["best_gain_percent"], *best), interval_text(*best) or "-",
            text(line["best_power"]), text(line["best_damping"]),
            gain(line["gain_percent"], *given), interval_text(*given) or "-",
            text(line["power"]), text(line["damping"]),
            text(line["share"], ".1f", 100.0),
        ]
        for line in lines
        for best, given in [((line.get("best_low"), line.get("best_high")), (line.get("low"), line.get("high")))]
    ]  # fmt: skip


def closing_line(
    lines: Lines, reference: str | None, invalid: Lines = (), *, flexible: bool = True, aside: str = ""
) -> str:
    """Return the answer of a study in one line that another sentence continues; empty if there is none.

    Gains, and the largest mean power, with their intervals. Only valid designs count; where there is none, the line
    says so and why. `flexible` says whether any design is, `aside` what `limits_aside` does.
    """
    others = valid_lines(lines, reference, invalid)
    if not others and invalid:
        return f"{no_answer(invalid)} "
    parts = [
        f"{_range([line for line in others if line[f'{of}gain_percent'] is not None], of)} at {where}"
        for of, where in (("best_", f"optimal damping{aside}"), ("", "the given damping"))
        if any(line[f"{of}gain_percent"] is not None for line in others)
    ]
    most = _most_absorbed(lines, invalid, aside)
    if not (parts and reference):
        return most
    return f"mean power against {the_rigid(reference) if flexible else reference} {', '.join(parts)}; {most}"


def _range(lines: Lines, of: str) -> str:
    """One gain with its interval, or the smallest and the largest of several [%]; `of` is what keys begin with."""
    gains = [line[f"{of}gain_percent"] for line in lines]
    if len(lines) > 1:
        low, high = map(gain_text, (min(gains), max(gains)))
        return f"{low} %" if low == high else f"{low} to {high} %"
    ends = lines[0].get(f"{of}low"), lines[0].get(f"{of}high")
    interval = interval_text(*ends)
    return f"{gain_text(gains[0], *ends)} %{interval and f' ({interval})'}"


def _most_absorbed(lines: Lines, invalid: Lines, aside: str) -> str:
    """The largest mean power at optimal damping of what is valid, with its interval; empty without one."""
    broken = {(line["design"], line["sea"]) for line in invalid}
    valid = [line for line in lines if (line["design"], line["sea"]) not in broken]
    best = max(valid, key=lambda line: float(line["best_power"]), default=None)
    if best is None or best.get("best_power_low") is None:
        return ""
    value = power(best["best_power"], best["best_power_low"], best["best_power_high"])
    where = f" in {best['sea']}" if len({line["sea"] for line in lines}) > 1 else ""
    verb = "absorbs most," if len({line["design"] for line in lines}) > 1 else "absorbs"
    return f"{best['design']} {verb} {value}{where} at optimal damping{aside}; "
