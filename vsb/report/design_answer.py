"""The answer of a design problem in sentences: the best buoys, the gain and its interval, what limits it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from vsb.design.compared import COMPETITOR, FLEXIBLE, TWIN, UNDEFORMED
from vsb.engine.motion.take_off import Control
from vsb.report.answer import Answer
from vsb.study.design import LIMITS, limit_of, unit_of
from vsb.study.feasible import OF_EVERY_BUOY
from vsb.tools.words import decimals_of, gains_within, plain, prefixed, superscripts, watts_within, within_text

Facts = Mapping[str, Any]
"""What is known of a design problem, as `vsb.stages.design_results` keeps it."""
OBJECTIVES = {
    "annual_mean_power": "annual mean power",
    "gain": "gain over the rigid buoy of the same shape and mass",
    "power_per_force": "annual mean power over rms force",
    "power_per_mass": "annual mean power over mass",
    "power_per_surface": "annual mean power over surface",
    "power_per_cost": "annual mean power over cost",
}
WIDENED = {"beam": 0.1, "draft": 0.1, "stroke_rms": 0.1, "load_factor": -0.1, "static_strain": 0.01}
"""Change of a limit whose worth is said [its unit]; of others a tenth of it."""


LISTED = 5
"""Most points of a front whose gains are listed in a sentence; of more the first, the largest between and the last."""


def in_full(name: str) -> str:
    """Return the name of a quantity in words."""
    mean_square = name.removesuffix("_rms")
    return (mean_square if mean_square == name else f"rms {mean_square}").replace("_", " ")


def with_unit(value: float | None, unit: str = "1") -> str:
    """Return a number with its unit, of forces, powers and what is in terms of them with k or M; a dash for none."""
    if value is None:
        return "-"
    factor, prefix = prefixed(value, unit)
    return f"{plain(factor * value)} {prefix}{superscripts(unit)}".removesuffix(" 1")


def range_with_unit(low: float, high: float, unit: str) -> str:
    """Return a range with one unit for both ends: "3 to 100 MPa"."""
    factor, prefix = prefixed(max(abs(low), abs(high)), unit)
    return f"{plain(factor * low)} to {plain(factor * high)} {prefix}{superscripts(unit)}".removesuffix(" 1")


def answer(facts: Facts) -> Answer:
    """Return the answer of a design problem."""
    best, rigid = (powers(facts)[name] for name in (FLEXIBLE, COMPETITOR))
    best_of_all = (
        f"The best flexible buoy{_at(facts, FLEXIBLE)} absorbs {best}, mean over the year of {facts['climate']}; the "
        f"best rigid buoy{_at(facts, COMPETITOR)} {rigid} within the same limits: {in_words(facts)}."
    )
    if headline := no_answer(facts):
        return Answer([headline], ["Computed, but not valid: " + best_of_all, *limited(facts)])
    stands = [*fronts(facts), best_of_all]
    if unproven := [name for name in (FLEXIBLE, COMPETITOR) if not facts["found"][name]["accepted"]]:
        stands.append(f"The {' and the '.join(unproven)} shown are not proven optima.")
    below = [
        verdict(facts),
        *maximised(facts),
        *under_control(facts),
        *in_time(facts),
        *size_or_flexibility(facts),
        *limited(facts),
    ]
    return Answer(stands, below)


def _at(facts: Facts, name: str) -> str:
    """Where the take-off of a buoy acts, if rigid buoys have another; in words."""
    words = {one: port_words(facts["take_offs"][one]["port"]) for one in (FLEXIBLE, COMPETITOR)}
    return "" if words[FLEXIBLE] == words[COMPETITOR] else f" ({words[name]})"


def port_words(port: Any) -> str:
    """Return where a take-off acts in words, from `pto.port`."""
    if isinstance(port, str):
        return f"take-off in {port}" if port in ("heave", "surge", "pitch") else f"take-off of the {port}"
    if "distributed" in port:
        return "damper spread over the shell"
    if "ports" in port:
        return f"take-off at {', '.join(port['ports'])}"
    if "dofs" in port:
        return "take-off in heave"  # the one motion that designs know
    if "strain" in port:
        return f"take-off of the {'area' if port['strain'] == 'area' else port['strain'] + ' strain'} of the shell"
    return "take-off at the shell"


def in_control(control: Control) -> str:
    """Return the causal control of a design in words."""
    ahead = f"knows the waves {control.forecast:g} s ahead" if control.forecast else "knows no future waves"
    return f"one controller for the year, which {ahead} (noise of {10 * math.log10(control.noise):.3g} dB)"


def under_control(facts: Facts) -> list[str]:
    """Return what the take-off is under causal control, and what other levels absorb at the same rms force."""
    if not (control := facts.get("control")):
        return []
    words = []
    for name in (FLEXIBLE, COMPETITOR):
        of = control["levels"][name]
        damper, known = (100 * (of["causal"] / of[level] - 1) for level in ("damper_same_force", "future_known"))
        words.append(f"the {name} {damper:+.1f} % and {known:+.1f} %")
    return [
        f"The take-off is {in_control(Control(noise=control['noise'], forecast=control['forecast']))}, the best of its "
        "rms force. Compared with the best damper of that force, and with control that knows all waves, it absorbs: "
        f"{', '.join(words)}."
    ]


def no_answer(facts: Facts) -> str:
    """Return why there is no valid answer and what to change; "" if there is one."""
    if why := facts["not_viable"]:
        return f"No valid answer yet: the best flexible buoy found is not viable ({why}). Change first: the limits."
    if not (failure := (facts["verified"] or {}).get("failure")):
        return ""
    reason, _, change = failure.rstrip(".").rpartition("; ")
    return (
        f"No valid answer yet: a run in time to verify it failed ({reason or failure}). Change first: "
        f"{change if reason else 'the limits'}."
    )


def in_words(facts: Facts) -> str:
    """Return the gain with its interval."""
    return gains_within([ends(facts["gain"])])[0]


def powers(facts: Facts) -> dict[str, str]:
    """Return the powers of the buoys compared with their intervals, by name, in one unit and to as many digits."""
    texts, unit = watts_within([ends(one) for one in facts["powers"].values()])
    return {name: f"{text} {unit}" for name, text in zip(facts["powers"], texts, strict=True)}


def ends(number: Mapping[str, Any]) -> tuple[float, float, float]:
    """Return a number with the ends of its interval."""
    return number["value"], number["low"], number["high"]


def objective_text(facts: Facts, name: str) -> str:
    """Return what was maximised of a buoy with its interval; "" of power itself, and of the gain."""
    if not (found := facts.get("objectives")):
        return ""
    numbers = [tuple(found[one]) for one in (FLEXIBLE, COMPETITOR)]
    whole = math.floor(math.log10(max(abs(value) for value, _, _ in numbers)))
    digits = decimals_of(numbers, max(0, 3 - whole), max(0, 5 - whole))
    value, low, high = found[name]
    text = within_text(f"{value:.{digits}f}", f"{low:.{digits}f}", f"{high:.{digits}f}")
    unit = superscripts(found["unit"]) + (" per unit of cost" if facts["maximise"] == "power_per_cost" else "")
    return f"{OBJECTIVES[facts['maximise']]} {text} {unit}"


def maximised(facts: Facts) -> list[str]:
    """Return what was maximised of both buoys, and the gain in it; nothing of power itself."""
    if not (found := facts.get("objectives")):
        return []
    words = OBJECTIVES[facts["maximise"]]
    each = [f"of the {name}{objective_text(facts, name).removeprefix(words)}" for name in (FLEXIBLE, COMPETITOR)]
    value, low, high = found["gain"]
    return [
        f"Maximised is the {words}, {' and '.join(each)}: {gains_within([(value, low, high)])[0]}. These intervals "
        "hold the errors of the power, without that of linear theory, and what uncertain inputs change of both."
    ]


def verdict(facts: Facts) -> str:
    """Return whether the gain is one: above all that is known of its errors, runs in time among it."""
    gain, verified = facts["gain"], facts["verified"]
    if gain["low"] <= 0 <= gain["high"]:
        return "The interval includes zero: within the known errors neither buoy is better."
    word = "more" if gain["value"] > 0 else "less"
    if verified is None:
        how = "verify: {seas: 48, model: body_exact}" if may_be_run(facts) else "designs have these of one damper alone"
        return (
            f"By linear theory the flexible buoy absorbs {word}, by more than the known errors; it has not been "
            f"confirmed by runs in time ({how})."
        )
    return f"The flexible buoy absorbs {word}, by more than the known errors, those of {verified['runs']} among them."


def may_be_run(facts: Facts) -> bool:
    """Return whether `verify` runs the buoys in time: under one damper at one port each."""
    ports = [one["port"] for one in facts["take_offs"].values()]
    return not facts.get("control") and not any({"ports", "distributed"} & {*one} for one in ports if one != "heave")


def in_time(facts: Facts) -> list[str]:
    """Return what runs in time of both buoys in the same seas say of the gain, apart from all other errors."""
    if (runs := facts["verified"]) is None:
        return []
    interval = f"{runs['low']:+z.2f} to {runs['high']:+z.2f} %"
    return [f"Both buoys simulated in time in the same seas ({runs['runs']}): {runs['value']:+z.2f} % ({interval})."]


def size_or_flexibility(facts: Facts) -> list[str]:
    """Return what of the gain is size and what flexibility."""
    texts, found = powers(facts), []
    if TWIN in texts:
        found.append(
            f"A rigid buoy of its shape and mass absorbs {texts[TWIN]}: flexibility itself brings "
            f"{gains_within([ends(facts['over'][TWIN])])[0]}."
        )
    if UNDEFORMED in texts:
        found.append(
            f"A rigid buoy of its shape before inflation absorbs {texts[UNDEFORMED]}: size and flexibility together "
            f"bring {gains_within([ends(facts['over'][UNDEFORMED])])[0]}."
        )
    return found


def fronts(facts: Facts) -> list[str]:
    """Return of each Pareto front where on it flexibility gains, with the gain at each value of the limit."""
    found = []
    for limit, of in facts["fronts"].items():
        points = [one for one in of[FLEXIBLE] if one["gain"]]
        if not points:
            continue
        known = {one["limit"] for one in points}
        open_ = [with_unit(one["limit"], unit_of(limit)) for one in of[FLEXIBLE] if one["limit"] not in known]
        gains = gains_within([ends(one["gain"]) for one in points])
        each = [f"{gain} at {with_unit(one['limit'], unit_of(limit))}" for gain, one in zip(gains, points, strict=True)]
        if len(each) > LISTED:
            largest = max(range(1, len(each) - 1), key=lambda i: points[i]["gain"]["value"])
            each = [each[0], each[largest], each[-1]]
        without = f"; at {' and '.join(open_)} no proven optimum of both buoys" if open_ else ""
        found.append(f"{where_it_gains(limit, points, every=not open_)}: {', '.join(each)}{without}.")
    return found


LINEAR = "By linear theory, its own error not counted, flexibility gains"
"""How a sentence on a front begins: its buoys are not followed in time."""


def where_it_gains(limit: str, points: Sequence[Mapping[str, Any]], *, every: bool = True) -> str:
    """Return at which values of a limit, ascending, the gain lies above zero with all its interval, in words.

    If these are not `every` value of the front nothing is said of those between and beside them.
    """
    gains = [one["gain"]["low"] > 0 for one in points]
    values = [with_unit(one["limit"], unit_of(limit)) for one in points]
    count = sum(gains)
    if not count:
        return f"{LINEAR} at no limit of the {in_full(limit)} by more than the known errors"
    if count == len(points) and every:
        return f"{LINEAR} at all limits of the {in_full(limit)} by more than the known errors"
    if every and all(gains[:count]):
        where = f"{values[count - 1]} or less"
    elif every and all(gains[-count:]):
        where = f"{values[-count]} or more"
    else:
        where = " and ".join(value for value, gain in zip(values, gains, strict=True) if gain)
    return f"{LINEAR} by more than the known errors with the {in_full(limit)} limited to {where}"


def limited(facts: Facts) -> list[str]:
    """Return what limits the best flexible buoy, with what a wider limit would bring."""
    found = facts["found"][FLEXIBLE]
    words = [worth(facts, name, value) for name, value in grouped(found["multipliers"]).items()]
    lines = [f"What limits it: {'; '.join(words)}."] if words else ["No limit holds it."]
    lines += as_built(facts["holds"][FLEXIBLE], facts["sigmas"])
    if found["flat"]:
        ridges = " and ".join(one[1:] if " " not in one else f"({one})" for one in found["flat"])
        lines.append(
            f"The optimum is flat: along {ridges} power hardly changes within the range, so that other buoys on this "
            "ridge are as good."
        )
    return lines


SURE = 0.999
"""Probability that a limit holds from which on it is not named."""
LIKELY = 0.95
"""Probability that all hold below which margins are advised."""


def as_built(holds: Mapping[str, float], sigmas: float) -> list[str]:
    """Return with what probability a buoy keeps its limits as it is built; nothing without uncertain inputs."""
    if not holds:
        return []
    if holds["all"] >= SURE:
        return [
            f"As built, with the uncertain inputs given, it keeps all limits in more than {100 * SURE:g} % of cases."
        ]
    each = [f"{in_full(name)} {100 * p:.0f} %" for name, p in holds.items() if name != "all" and p < SURE]
    advice = ""
    if holds["all"] < LIKELY:
        more = "more than" if sigmas else "such as"
        advice = f" limits: {{sigmas: N}} keeps away from them by N standard deviations, {more} {sigmas or 2:g}."
    return [
        f"As built, with the uncertain inputs given, it keeps all limits in {100 * holds['all']:.0f} % of cases "
        f"({', '.join(each)}).{advice}"
    ]


def grouped(multipliers: Mapping[str, float]) -> dict[str, float]:
    """Return multipliers by limit, those of its parts together, the largest first."""
    found: dict[str, float] = {}
    for name, value in multipliers.items():
        found[limit_of(name)] = found.get(limit_of(name), 0.0) + value
    return dict(sorted(found.items(), key=lambda one: -one[1]))


LEAST_WORTH = 0.01
"""What a wider limit brings up to which it is not told from errors [%]."""


def brings(percent: float) -> str:
    """Return what a wider limit brings [%] in words."""
    return f"{percent:+.2g} %" if abs(percent) >= LEAST_WORTH else f"less than {LEAST_WORTH:g} %"


def worth(facts: Facts, name: str, multiplier: float) -> str:
    """Return what a wider limit would bring, by its multiplier: 0.1 m more beam: +2.1 %."""
    if name not in LIMITS:
        if name in OF_EVERY_BUOY or name == "spring_share":
            words = OF_EVERY_BUOY.get(name, "stable rest beside the spring")
            return f"{words} (10 % more: {brings(10 * multiplier)})"
        return f"the {name} (a tenth of its range beyond: {brings(10 * multiplier)})"
    limit, unit = facts["limits"][name], unit_of(name)
    step = WIDENED.get(name)
    share = 0.1 if step is None else abs(step) / limit
    size = "10 %" if step is None else with_unit(abs(step), unit)
    more = "less" if step is not None and step < 0 else "more"
    return f"{in_full(name)} of {with_unit(limit, unit)} ({size} {more}: {brings(100 * multiplier * share)})"
