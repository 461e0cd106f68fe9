"""The answer of a study: what stands, each design at its own optimal damper, and what was computed but is not valid."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import xarray as xr

from vsb.report.band import gain_band, useful_band
from vsb.report.doubts import no_answer, reasons
from vsb.tools.words import SAME, against_rigid, multiple, watts

DIGITS = 5
"""Most decimals of an interval [%]."""
COMPUTED = "What was computed, although the model does not hold: "


class Answer(NamedTuple):
    """The answer of a study, in sentences."""

    stands: list[str]  # for bold letters
    below: list[str]  # numbers that are not valid, named as such, and designs left out

    @property
    def lines(self) -> list[str]:
        """All sentences."""
        return [*self.stands, *self.below]


def headline(
    lines: Sequence[dict[str, Any]],
    best_power: xr.DataArray,
    reference: str | None,
    seas: dict[str, str],
    invalid: Sequence[dict[str, Any]] = (),
    neglected: str = "",
) -> Answer:
    """Return the answer of a study: in its seas, and over all waves; empty without a gain to give.

    Parameters
    ----------
    lines : sequence of dict
        Of `vsb.results.gains.Tuned`.
    best_power : DataArray, dims (design, omega) [W/m^2]
        At the best damper of each design and frequency.
    reference : str or None
        The rigid design gains are measured against.
    seas : mapping of sea to words
    invalid : sequence of dict
        Of `vsb.results.ledger.Invalid`: designs that are not valid in a sea; the best one is chosen among the others.
    neglected : str
        What `best_power` knows nothing of, in words.
    """
    others = [line for line in lines if line["design"] != reference and line["best_gain_percent"] is not None]
    if reference is None or not others:
        return Answer([], [])
    valid = valid_lines(others, reference, invalid)
    if not valid:
        found = [_in_seas(others, lines, reference, seas), *_over_band(best_power, reference, neglected)]
        return Answer([no_answer(invalid)], [f"{COMPUTED}{' '.join(found)}"])
    kept = [reference, *dict.fromkeys(line["design"] for line in valid)]
    designs = [design for design in best_power.design.values if design in kept]
    stands = [_in_seas(valid, lines, reference, seas)]
    stands += _over_band(best_power.sel(design=designs), reference, neglected)
    return Answer(stands, _left_out(others, valid, invalid, reference, seas))


def _left_out(
    others: Sequence[dict[str, Any]],
    valid: Sequence[dict[str, Any]],
    invalid: Sequence[dict[str, Any]],
    reference: str,
    seas: dict[str, str],
) -> list[str]:
    """Gains that are not valid and no part of the answer, and why."""
    kept, found = {(line["design"], line["sea"]) for line in valid}, []
    for line in others:
        if (line["design"], line["sea"]) in kept:
            continue
        why = [one for one in invalid if one["design"] in (line["design"], reference) and one["sea"] == line["sea"]]
        gain = against_rigid(float(line["best_gain_percent"]), reference)
        what = f"{line['design']} in {seas[line['sea']]}, computed to absorb {gain}"
        found.append(f"Not valid, and no part of this answer: {what}; {' and '.join(reasons(why))}.")
    return found


def _in_seas(
    shown: Sequence[dict[str, Any]], lines: Sequence[dict[str, Any]], reference: str, seas: dict[str, str]
) -> str:
    """The largest gain of some lines, where, and its interval."""
    best = max(shown, key=lambda line: float(line["best_gain_percent"]))
    gain, sea = float(best["best_gain_percent"]), best["sea"]
    base = next(line for line in lines if line["design"] == reference and line["sea"] == sea)
    (own, its), unit = watts([best["best_power"], base["best_power"]])
    count = len(dict.fromkeys(line["sea"] for line in shown))
    designs = len(dict.fromkeys(line["design"] for line in shown))
    most = f"the best flexible design, {best['design']}," if designs > 1 else best["design"]
    where = f"In {seas[sea]}" + (f", the most favourable of {count} seas" if count > 1 else "")
    interval = interval_text(best.get("best_low"), best.get("best_high"))
    known = f"{interval} with all known errors; " if interval else ""
    what = f"{most} absorbs {against_rigid(gain, reference)} ({known}{own} against {its} {unit})"
    return f"{where}, each design at its own optimal damper, {what}{_elsewhere(shown, count)}."


def interval_text(low: float | None, high: float | None) -> str:
    """Return an interval in per cent, to as many decimals as tell its ends apart; empty without one, or of no width.

    Examples
    --------
    >>> interval_text(-3.64, 1.2), interval_text(4.4012, 4.4047)
    ('-3.6 to +1.2 %', '+4.401 to +4.405 %')
    """
    if low is None or high is None or low == high:
        return ""
    for digits in range(1, DIGITS + 1):
        ends = [f"{end:+.{digits}f}" for end in (low, high)]
        if ends[0] != ends[1]:
            return f"{ends[0]} to {ends[1]} %"
    return f"{(low + high) / 2:+.1f} %, exact to 1e-{DIGITS} points"


def _elsewhere(others: Sequence[dict[str, Any]], count: int) -> str:
    """In how many of several seas any flexible design pays, and what the worst choice costs."""
    least = min(float(line["best_gain_percent"]) for line in others)
    if count < 2 or least >= 0:
        return ""
    pays = len({line["sea"] for line in others if float(line["best_gain_percent"]) > 0})
    return f"; flexibility pays in {pays or 'none'} of the {count}, and costs up to {-least:.1f} %"


def _over_band(best_power: xr.DataArray, reference: str, neglected: str) -> list[str]:
    """What flexible designs absorb over all waves: the most and the least, where, and which of them."""
    useful, counts = useful_band(best_power), gain_band(best_power, reference)
    shown = best_power.where(counts, drop=True)
    if shown.sizes["omega"] < 2:
        return []
    gain = (100 * (shown / shown.sel(design=reference) - 1)).sel(design=shown.design != reference)
    parts = []
    for sign, word in ((1, "more"), (-1, "less")):
        place = (sign * gain).argmax(("design", "omega"))
        at = gain.isel({dim: int(where) for dim, where in place.items()})
        if sign * float(at) > SAME:
            period = 2 * math.pi / float(at.omega)
            which = f"{at.design.item()} " if gain.sizes["design"] > 1 else ""
            size = abs(float(at))
            said = multiple(float(at)) or f"{size:.{0 if size >= 1 else 1}f} % {word}"
            parts.append(f"up to {said} ({which}in waves of {period:.2f} s)")
    who = "flexible designs absorb" if gain.sizes["design"] > 1 else f"{gain.design.values[0]} absorbs"
    but = " but those of which the rigid design absorbs next to nothing" if bool((useful & ~counts).any()) else ""
    where = f"Over all waves that carry power{but}, tuned wave by wave{neglected and f' and {neglected}'}"
    return [f"{where}, {who} {' and '.join(parts)}."] if parts else []


def valid_lines(
    lines: Iterable[dict[str, Any]], reference: str | None, invalid: Iterable[dict[str, Any]]
) -> list[dict[str, Any]]:
    """Return the lines of designs other than the reference that are valid in their sea, as is the reference."""
    broken = {(line["design"], line["sea"]) for line in invalid}
    return [
        line
        for line in lines
        if line["design"] != reference and not {(line["design"], line["sea"]), (reference, line["sea"])} & broken
    ]
