"""The answer of a campaign in sentences, and what was computed but is not valid.

Imports nothing that draws: a run ends with this answer.
"""

import math

import numpy as np
import xarray as xr

from vsb.engine.waves.climate import YEAR_HOURS
from vsb.report.answer import ADVICE, COMPUTED, Answer
from vsb.results.campaign import GAIN, POWER, in_time
from vsb.results.year import POWER_ENDS
from vsb.study.campaign import GAIN_IN_TIME, leading_tuning
from vsb.tools.words import against, gain_decimals, quantity, short, the_rigid

TUNED = {
    "one": "each design at its optimal damping for the year",
    "each": "each design at its optimal damping in each sea",
    "fixed": "all at the given damping",
    "damper_same_force": "each design with the best damper of given rms force in each sea state",
    "causal": "each design with causal control scheduled over the sea states, of given rms force",
    "constrained": "each design with the optimal force within its limits",
}
BESIDE = {
    "causal": "With causal control, scheduled over the sea states",
    "constrained": "With the optimal force within its limits",
    "fixed": "All at the given damping",
}
"""Start of the second sentence, by its tuning."""
MODELS = {"body_exact": "body-exact runs", "linear": "linear time-domain runs"}


def leading(ds: xr.Dataset) -> tuple[str, str | None]:
    """Return the tuning of the answer, and the rigid design gains are measured against; None if it absorbs nothing."""
    tuning, reference = leading_tuning(ds.tuning.values), ds.attrs.get("reference") or None
    gains = reference and bool(reported_gain(ds.sel(tuning=tuning), tuning).notnull().any())
    return tuning, reference if gains else None


def closing_answer(ds: xr.Dataset) -> str:
    """Return the answer of a campaign in one sentence."""
    tuning, reference = leading(ds)
    return whole_answer(ds, reference, tuning).stands[0]


def whole_answer(ds: xr.Dataset, reference: str | None, tuning: str) -> Answer:
    """Return the site's answer; if nothing is valid, why, and below it what was computed."""
    said = [line for line in (answer(ds, reference, tuning), second_answer(ds, reference, tuning)) if line]
    best = best_flexible(ds, reference, tuning)
    where_so = f" at all {ds.margin.size} points" if ds.margin.size > 1 else ""
    change = ds.attrs.get("advice")
    if not_viable := shells_not_viable(ds):
        why = f"no flexible design is viable{where_so} ({not_viable})"
    elif best is None or float(best[0].margin) >= 0:
        return Answer(said, [])
    else:
        most = short(1 - float(best[0].margin))
        why = f"the shell buckles under its static load{where_so} ({most} times what it can carry)"
        change = change or ADVICE["buckling"]
    lines = [f"No valid answer yet: {why}."] + ([f"Change first: {change}."] if change else [])
    return Answer([" ".join(lines)], [f"{COMPUTED}{' '.join(said)}"])


def shells_not_viable(ds: xr.Dataset) -> str:
    """Return why no flexible design of a campaign is viable at any point, in few words; empty if one is."""
    flexible = ds.viable.isel(design=ds.design.values != (ds.attrs.get("reference") or ""))
    if bool(flexible.any()) or not flexible.size or not of_shells(ds):
        return ""
    return "; ".join(sorted({str(text).partition(":")[0] for text in ds.reason.values[~ds.viable.values]}))


def answer(ds: xr.Dataset, reference: str | None, tuning: str) -> str:
    """Return the result for the site in one sentence."""
    begins, ends = f"Over a year of {ds.attrs['climate']}", f", {TUNED[tuning]}"
    best = best_flexible(ds, reference, tuning)
    if best is None or not of_shells(ds):
        at_tuning, names = ds.sel(tuning=tuning), power_names(ds, tuning)
        power = at_tuning[names[0]]
        if not bool(power.notnull().any()):
            return f"{begins}, no design is viable."
        if not float(power.max()) > 0:
            return f"{begins}{ends}, no design absorbs power."
        most = at_tuning.isel({dim: int(at) for dim, at in power.argmax(...).items()})
        value, low, high = (short_energy(most[name]) for name in names)
        value = f"{value} MWh ({low} to {high} with all known errors)"
        return f"{begins}{ends}, {most.design.item()}{at_point(most)} absorbs most: {value}."
    return f"{begins}{ends}, {_absorbed(ds, reference, tuning, best)}."


def _absorbed(ds: xr.Dataset, reference: str | None, tuning: str, best: tuple[xr.Dataset, str]) -> str:
    """Energy of the best flexible design against the rigid one, with the interval of the gain."""
    one, design = best
    gain = float(reported_gain(one, tuning))
    low, high = (float(end) for end in reported_bounds(one, tuning))
    by, beside = "linear theory", ""
    if is_verified(one, tuning):
        by = MODELS[ds.attrs["verified_model"]]
        beside = f"; linear theory gives {float(one.gain_percent):+z.1f} %"
        if low <= 0 <= high:
            beside += "; too few runs to resolve the sign"
    rigid = shown_member(ds, tuning, reference).sel(tuning=tuning, design=reference)
    many = (ds.sizes["design"] > 2) or ds.margin.size > 1
    kind = "flexible design" if of_shells(ds) else "other design"
    subject = f"the best {kind}, {design}{at_point(one)}," if many else f"{design}"
    digits = gain_decimals(low, high)
    interval = f"{low:+z.{digits}f} to {high:+z.{digits}f} % by {by}{beside}"
    energies = _energy(one, tuning), _energy(rigid, tuning)
    decimals = max(0, 3 - math.floor(math.log10(max(energies))))
    both = " against ".join(f"{energy:.{decimals}f}" for energy in energies) + " MWh"
    other = the_rigid(str(reference)) if of_shells(ds) else str(reference)
    return f"{subject} absorbs {against(gain, other, digits)} ({interval}; {both})"


def _energy(one: xr.Dataset, tuning: str) -> float:
    """Annual energy of one design at a tuning, corrected by time-domain runs like its gain [MWh]."""
    return float(one[power_names(one, tuning)[0]]) * YEAR_HOURS / 1e6


def second_tuning(ds: xr.Dataset, tuning: str) -> str | None:
    """Return the tuning of the second sentence: within limits, or at the given damping; None without either."""
    return next((name for name in BESIDE if name in ds.tuning.values and name != tuning), None)


def second_answer(ds: xr.Dataset, reference: str | None, tuning: str) -> str:
    """Return the second sentence: the answer within limits or at the given damping, else the largest doubt."""
    other = second_tuning(ds, tuning)
    if other and (best := best_flexible(ds, reference, other)):
        return f"{BESIDE[other]}, {_absorbed(ds, reference, other, best)}."
    if ds.margin.size > 1 and reference is not None:
        return of_points(ds, reference, tuning)
    marked = 100 * ds.energy_beyond_validity.sel(tuning=tuning)
    theory = "" if "verification" in ds.attrs else "This is linear theory; "
    beyond = f"{share_range(marked)} of the energy comes from {too_steep_or_breaking(ds)}."
    return theory + beyond if bool((marked > 0).any() if "verification" in ds.attrs else marked.notnull().any()) else ""


def short_energy(mean_power: xr.DataArray) -> str:
    """Return the energy of a year of a mean power [W], in MWh to four digits."""
    return f"{float(mean_power) * YEAR_HOURS / 1e6:.4g}"


def too_steep_or_breaking(ds: xr.Dataset) -> str:
    """Return in words which seas count as beyond linear theory; those of large heave have a warning of their own."""
    shells = ", or deform the shell by more than a tenth of its radius" if of_shells(ds) else ""
    return f"seas that are too steep or break{shells}"


def of_points(ds: xr.Dataset, reference: str, tuning: str) -> str:
    """Return at how many viable points flexibility pays: the interval of some design's gain lies above zero."""
    least = reported_bounds(ds.sel(tuning=tuning), tuning)[0].where(ds.design != reference)
    carries, pays = ds.margin >= 0, least.max("design") > 0
    if not of_shells(ds):
        somewhere = f"At {int(pays.sum())} of {ds.margin.size} points a design absorbs more than {reference}."
        return somewhere if bool(pays.any()) else f"No design absorbs more than {reference} at any point."
    if not bool(carries.any()):
        return f"None of the {ds.margin.size} points is stable against buckling under its static load."
    count, stable = ds.margin.size, int(carries.sum())
    both = "Both" if count == 2 else f"All {count}"  # a sentence on points has several
    which = f"{both} points are" if stable == count else f"{stable} of {count} points {'is' if stable == 1 else 'are'}"
    gaining = int((pays & carries).sum())
    controlled = {"causal", "constrained"} & {*map(str, ds.tuning.values)} - {tuning}  # where it may gain though
    tuned = f"{TUNED[tuning]}, " if controlled else ""
    return f"{which} stable against buckling; {tuned}a flexible design absorbs more at {gaining or 'none'} of these."


def of_shells(ds: xr.Dataset) -> bool:
    """Return whether a campaign is of a buoy, whose shell deforms and may buckle; else it is of a body."""
    return "deformation" in ds.limit.values


def at_point(one: xr.Dataset) -> str:
    """At which point, in words."""
    return f" at {text}" if (text := where(one)) else ""


def best_flexible(ds: xr.Dataset, reference: str | None, tuning: str) -> tuple[xr.Dataset, str] | None:
    """Return the flexible design of largest gain and its member, one that carries its static load if there is any."""
    if reference is None or ds.sizes["design"] < 2:
        return None
    one = shown_member(ds, tuning, reference).sel(tuning=tuning)
    gains = reported_gain(one, tuning).where(one.design != reference)
    if not bool(gains.notnull().any()):
        return None
    design = str(gains.design.values[int(np.nanargmax(gains.values))])
    return one.sel(design=design), design


def where(one: xr.Dataset) -> str:
    """Return the values of what is varied of one member, in words; empty if nothing is."""
    names = str(one.attrs["varied"]).split()
    return ", ".join(
        f"{name.replace('_', ' ')} {quantity(one[name].item(), one[name].attrs.get('units', '1'))}"
        for name in names
        if one[name].ndim == 0
    )


def share_range(share: xr.DataArray) -> str:
    """Range of percentages, those of designs that are not viable left out."""
    least, most = f"{float(share.min()):.0f}", f"{float(share.max()):.0f}"
    return f"{most} %" if least == most else f"{least} to {most} %"


def shown_place(ds: xr.Dataset, tuning: str, reference: str | None) -> dict[str, int]:
    """Return the point with the largest gain of a design that carries its static load, else with the largest gain."""
    points = [str(dim) for dim in ds.margin.dims]
    if not points:
        return {}
    of_tuning = ds.sel(tuning=tuning)
    gain = of_tuning[power_names(ds, tuning)[0]] if reference is None else reported_gain(of_tuning, tuning)
    others = gain if reference is None else gain.where(gain.design != reference)
    best = others.max("design", skipna=True).fillna(-np.inf)
    score = best.where(ds.margin >= 0, best - 1e6)
    place = np.unravel_index(int(np.argmax(score.transpose(*points).values)), [ds.sizes[dim] for dim in points])
    return {dim: int(i) for dim, i in zip(points, place, strict=True)}


def shown_member(ds: xr.Dataset, tuning: str, reference: str | None) -> xr.Dataset:
    """Return the member whose curves are drawn; see `shown_place`."""
    return ds.isel(shown_place(ds, tuning, reference))


def power_names(ds: xr.Dataset, tuning: str) -> tuple[str, ...]:
    """Return the names of the annual mean power reported at one tuning, and of the ends of its interval."""
    if is_verified(ds, tuning):
        return tuple(in_time(ds.attrs["verified_model"], name) for name in POWER)
    return "annual_mean_power", *POWER_ENDS


def reported_gain(ds: xr.Dataset, tuning: str) -> xr.DataArray:
    """Return the gains at one tuning: corrected by time-domain runs if there are any, else of linear theory."""
    return ds[_reported_names(ds, tuning)[0]]


def reported_bounds(ds: xr.Dataset, tuning: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the ends of the intervals of those gains, by the same model."""
    _, low, high = _reported_names(ds, tuning)
    return ds[low], ds[high]


def _reported_names(ds: xr.Dataset, tuning: str) -> tuple[str, ...]:
    """Names of the gains reported at a tuning, and of the ends of their intervals."""
    if is_verified(ds, tuning):
        return tuple(in_time(ds.attrs["verified_model"], name) for name in GAIN)
    return GAIN_IN_TIME


def is_verified(ds: xr.Dataset, tuning: str) -> bool:
    """Return whether gains at a tuning are corrected by time-domain runs."""
    return ds.attrs.get("verified_tuning") == tuning and in_time(ds.attrs["verified_model"], GAIN[0]) in ds
