"""The fair answer of a study in two sentences: each design at its own best damper, with what the numbers leave open."""

import math
from collections.abc import Sequence
from typing import Any

import xarray as xr

from vsb.report.band import USEFUL, useful_band
from vsb.tools.words import SAME, against_rigid, multiple, watts


def headline(
    lines: Sequence[dict[str, Any]],
    best_power: xr.DataArray,
    reference: str | None,
    seas: dict[str, str],
    tolerance: float,
    neglected: str = "",
) -> list[str]:
    """Return the fair answer of a study: in its seas, and over all waves; empty without a gain to give.

    Parameters
    ----------
    lines : sequence of dict
        Of `vsb.results.equal_tuning.Tuned`.
    best_power : DataArray, dims (design, omega) [W/m^2]
        At the best damper of each design and frequency.
    reference : str or None
        The rigid design gains are measured against.
    seas : mapping of sea to words
    tolerance : float
        Of the coefficients, relative [-]: gains are known to twice that much of both powers.
    neglected : str
        What `best_power` knows nothing of, in words.
    """
    others = [line for line in lines if line["design"] != reference and line["best_gain_percent"] is not None]
    if reference is None or not others:
        return []
    best = max(others, key=lambda line: float(line["best_gain_percent"]))
    gain, sea = float(best["best_gain_percent"]), best["sea"]
    base = next(line for line in lines if line["design"] == reference and line["sea"] == sea)
    (own, its), unit = watts([best["best_power"], base["best_power"]])
    width = 2 * tolerance * (100 + gain)
    count = len(dict.fromkeys(line["sea"] for line in others))
    designs = len(dict.fromkeys(line["design"] for line in others))
    most = f"the best flexible design, {best['design']}," if designs > 1 else best["design"]
    where = f"In {seas[sea]}" + (f", the most favourable of {count} seas" if count > 1 else "")
    interval = f"{gain - width:+.1f} to {gain + width:+.1f} % by the numbers' tolerance"
    what = f"{most} absorbs {against_rigid(gain, reference)} ({interval}; {own} against {its} {unit})"
    in_seas = f"{where}, each design at its own best damper, {what}{_elsewhere(others, count)}."
    return [in_seas, *_over_band(best_power, reference, neglected)]


def _elsewhere(others: Sequence[dict[str, Any]], count: int) -> str:
    """In how many of several seas any flexible design pays, and what the worst choice costs."""
    least = min(float(line["best_gain_percent"]) for line in others)
    if count < 2 or least >= 0:
        return ""
    pays = len({line["sea"] for line in others if float(line["best_gain_percent"]) > 0})
    return f"; flexibility pays in {pays or 'none'} of the {count}, and costs up to {-least:.1f} %"


def _over_band(best_power: xr.DataArray, reference: str, neglected: str) -> list[str]:
    """What flexible designs take over all waves: the most and the least, where, and which of them.

    Where the rigid design takes next to nothing, of its own and of what others take, any power is a thousandfold of
    it: that is no gain to lead with.
    """
    useful, rigid = useful_band(best_power), best_power.sel(design=reference, drop=True)
    takes = (rigid >= USEFUL * rigid.max()) | (rigid >= 0.1 * best_power.max("design"))
    shown = best_power.where(useful & takes, drop=True)
    if shown.sizes["omega"] < 2 or not float(shown.sel(design=reference).min()) > 0:
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
    but = " but those of which the rigid design takes next to nothing" if bool((useful & ~takes).any()) else ""
    where = f"Over all waves that carry power{but}, tuned wave by wave{neglected and f' and {neglected}'}"
    return [f"{where}, {who} {' and '.join(parts)}."] if parts else []
