"""The answer of a study in sentences: gains with every design at its own optimal damping, and what is not valid.

With it the reasons of doubts in words, and the band of wave frequencies over which gains are stated.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.motion.take_off import DAMPERS, DEFAULTS, LAWS, port_kind
from vsb.keys.quantities import canonical
from vsb.study.study import Study
from vsb.tools.arrays import BoolArray, FloatArray
from vsb.tools.words import (
    SAME,
    against,
    gain_decimals,
    gain_text,
    interval_text,
    multiple,
    plain,
    power,
    short,
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

    `lines` are of `vsb.results.gains.Tuned`, `best_power` [W/m^2] is at the optimal damping of each design and
    frequency, gains are against the rigid design `reference`, the best design is chosen among those not `invalid` in a
    sea. `neglected` says what `best_power` leaves out, `aside` what powers at optimal damping do, see `limits_aside`.
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

    Optimal damping is that of a linear take-off, which may exceed limits of force and stroke. Its powers are after
    conversion.
    """
    after = f", after conversion with an efficiency of {pto['efficiency']:g}" if converts(pto) else ""
    if pto.get("law", "linear") != "linear":
        return f" of a linear take-off{after}"
    limits = [float(pto.get(name, math.inf)) for name in ("force_limit", "stroke_limit")]
    return (" without limits" if min(limits) < math.inf else "") + after


def converts(pto: Mapping[str, Any]) -> bool:
    """Return whether power is lost after the port, so that control levels are after conversion and runs before it."""
    return bool(pto.get("efficiency", 1.0) < 1.0)


def conversion_text(pto: Mapping[str, Any]) -> str:
    """Return which powers of a page are after conversion; empty without losses."""
    return converts(pto) * (
        f"With an efficiency of {pto.get('efficiency', 1.0):g} in both directions of power, powers at optimal or given "
        "damping by linear theory and under causal control are after conversion. Powers of runs in time, of optimal "
        "forces and of controllers in other seas are those at the port, before conversion."
    )


USEFUL = "a design absorbs at least 5 % of the maximum"
WITH_RIGID = "the rigid design absorbs at least 5 % of its maximum, or a tenth of the best one's power"
"""Bands over which gains are stated, see `vsb.report.answer`."""


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
    return _law_in_words(pto) + ", before conversion" * converts(pto)


def _law_in_words(pto: dict[str, Any]) -> str:
    """The damping or law of simulated designs."""
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
    """Return, for each sea, what the designs can absorb within limits, of `vsb.results.gains.Limited`."""
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
    """Return, for each irregular sea, what the designs absorb under causal control of one rms force, in its unit."""
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
    damper = {True: "", False: " (the damper)"}
    return [
        [
            line["design"], line["sea"], "-" if line["force_rms"] is None else plain(line["force_rms"]),
            plain(line["power"]) + damper[line["damper"] is None],
            _percent(line["gain_percent"], line["low"], line["high"]),
            interval_text(line["low"], line["high"]) or "-", plain(line["damper_power"]),
            _percent(line["damper_gain_percent"]),
        ]
        for line in lines
    ]  # fmt: skip


ELSEWHERE = (
    "design", "tuned in", "peak period [s]", "power [W]", "rms force [{}]", "tuned there [W]", "its rms force [{}]",
    "loss [%]",
)  # fmt: skip
"""Head of the table of controllers in other seas."""


def elsewhere_table(lines: Lines) -> list[list[str]]:
    """Return the cells of controllers in seas they are not tuned in, of lines of `vsb.results.gains.Elsewhere`."""
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


def cell(value: Any, form: str = "", factor: float = 1.0) -> str:
    """Return a number in a form, or to four digits without an exponent; a dash for none."""
    if value in MISSING:
        return "-"
    return format(factor * float(value), form) if form else plain(factor * float(value))


def _percent(value: float | None, *ends: float | None) -> str:
    """A gain to the decimals its interval resolves; a dash for none."""
    return "-" if value is None else gain_text(value, *ends)


def parts_table(lines: Lines) -> list[list[str]]:
    """Return which source of error is which part of the interval of every gain at optimal damping."""
    return [
        [line["design"], line["sea"], source["name"], *points, source["kind"]]
        for line in lines
        for source in line.get("errors", ())
        for points in [[f"{source[end]:.3f}".replace("-0.000", "0.000") for end in ("low", "high")]]
    ]  # to a thousandth: more digits of an error mean nothing


def tuning_head(unit: str) -> list[str]:
    """Return the head of the table of designs at equal tuning, by the unit of damping."""
    measures = ["gain [%]", "interval of the gain", "mean power [W]"]
    best = ["design", "sea", *measures, f"optimal damping [{unit}]"]
    return [*best, *measures, f"given damping [{unit}]", "share of optimum [%]"]


def tuning_table(lines: Lines) -> list[list[str]]:
    """Return the cells of the table of designs at equal tuning; a quantity that does not exist is a dash."""
    return [
        [
            line["design"], line["sea"],
            _percent(line["best_gain_percent"], *best), interval_text(*best) or "-",
            cell(line["best_power"]), cell(line["best_damping"]),
            _percent(line["gain_percent"], *given), interval_text(*given) or "-",
            cell(line["power"]), cell(line["damping"]),
            cell(line["share"], ".1f", 100.0),
        ]
        for line in lines
        for best, given in [((line.get("best_low"), line.get("best_high")), (line.get("low"), line.get("high")))]
    ]  # fmt: skip


def answer_of_study(study: Study, tables: Mapping[str, Lines]) -> str:
    """Return the answer of a study in one line, from its tables; see `closing_line`."""
    pto, seas = json.loads(canonical(study))["pto"], {wave.label: wave.family for wave in study.waves if not wave.still}
    runs = {
        (row["design"], seas[row["wave"]]): {
            "design": row["design"], "sea": seas[row["wave"]], "gain_percent": row["power_gain_percent"],
            "power": row["power_mean"], **{end: row.get(end) for end in ("low", "high", "power_low", "power_high")},
        }
        for row in tables["comparison"] if study.pto.law not in DAMPERS and row["wave"] in seas
    }  # fmt: skip
    where = damping_in_words(pto)
    line = closing_line(
        tables["equal_tuning"], study.reference_design, tables["invalid"], flexible=study.flexible,
        aside=limits_aside(pto), runs=[*runs.values()], where=where[0].lower() + where[1:],
    )  # fmt: skip
    failed = dict.fromkeys(check["name"].replace("_", " ") for check in tables["checks"] if check["verdict"] == "fail")
    return line if tables["invalid"] or not failed else f"{line}checks that fail: {', '.join(failed)}; "


def closing_line(
    lines: Lines,
    reference: str | None,
    invalid: Lines = (),
    *,
    flexible: bool = True,
    aside: str = "",
    runs: Lines = (),
    where: str = "",
) -> str:
    """Return the answer of a study in one line that another sentence continues; empty if there is none.

    Gains, and the largest mean power, with their intervals. Only valid designs count; where there is none, the line
    says so and why. `flexible` says whether any design is, `aside` what `limits_aside` does. Under a law of the
    take-off that is no damper, `runs` are lines of its own powers, and `where` says in words which law it is.
    """
    others = valid_lines(lines, reference, invalid)
    if not others and invalid:
        return f"{no_answer(invalid)} "
    kinds = [
        (others, "best_", f"at optimal damping{aside}"),
        (others, "", "at the given damping"),
        (valid_lines(runs, reference, invalid), "", where),
    ]
    stated = [([line for line in some if line[f"{of}gain_percent"] is not None], of, at) for some, of, at in kinds]
    parts = [f"{_range(some, of)} {at}" for some, of, at in stated if some]
    most = _most_absorbed(runs, "", invalid, where) or _most_absorbed(lines, "best_", invalid, kinds[0][2])
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


def _most_absorbed(lines: Lines, of: str, invalid: Lines, where: str) -> str:
    """The largest mean power of what is valid, with its interval; empty without one. `of` is what keys begin with."""
    broken = {(line["design"], line["sea"]) for line in invalid}
    valid = [line for line in lines if (line["design"], line["sea"]) not in broken]
    best = max(valid, key=lambda line: float(line[f"{of}power"]), default=None)
    if best is None or best.get(f"{of}power_low") is None:
        return ""
    value = power(*(best[f"{of}{name}"] for name in ("power", "power_low", "power_high")))
    sea = f" in {best['sea']}" if len({line["sea"] for line in lines}) > 1 else ""
    verb = "absorbs most," if len({line["design"] for line in lines}) > 1 else "absorbs"
    return f"{best['design']} {verb} {value}{sea} {where}; "


ADVICE = {
    "buckling": "raise device.internal_pressure to carry the load, or device.thickness",
    "computed_buckling": "raise device.internal_pressure to carry the load, or device.thickness",
    "static_deformation": "reference_shape: equilibrium if it is undeformed, or a stiffer shell",
    "static_strain": "a stiffer shell",
    "load_path": "a thicker or stiffer shell",
    "wrinkling": "raise device.internal_pressure until all of the shell is in tension",
    "angles": "angles in degrees",
    "specific_energy": "a thicker shell, or a smaller damper: the material converts less than the waves offer",
    "modes_left_out": "a smaller modes.tolerance or a higher modes.degree, of modes: {basis: full}",
    "ring_width": "rings further apart, by several thicknesses of the wall",
    "reference_power": "longer waves, in which the rigid design absorbs power",
    "fair_damping": "pto.tuning: each, or read the gains at optimal damping",
    "energy_residual": "lower simulation.tolerance",
    "transient": "a later simulation.window",
    "time_and_frequency_domain": "a later simulation.window",
    "heave": "lower waves, or hydro.model: body_exact if it is linear and the buoy heaves alone",
    "deformation": "a stiffer shell, or hydro.model: body_exact if it is linear and the buoy heaves alone",
    "strain": "a stiffer or thicker shell, or lower waves",
    "steepness": "lower or longer waves",
    "linearity": "lower waves, or take the powers of the runs: those of linear theory do not hold here",
    "statistical_error": "more waves.realisations, or a longer simulation.duration",
    "spectral_prediction": "a later simulation.window",
    "record_length": "a longer simulation.duration",
    "spectrum_cut": "raise hydro.omega_max",
    "power_limit": "lower hydro.tolerance",
    "radiation_fit": "lower hydro.tolerance",
    "passivity": "lower hydro.tolerance",
    "witness": "lower hydro.tolerance",
    "constrained": "a shorter simulation.duration, or looser limits",
    "assumed_pressure": "hydro.model: linear, which includes radiation",
    "left_out": "lower hydro.power_tolerance",
    "gain_error": "lower hydro.power_tolerance",
    "controller_margin": "a lower pto.force_limit, or more pto.control.noise",
    "latching_time": "lower waves, or another damping",
    "drag": "use the powers in the time domain, or lower waves",
    "pitch": "lower waves",
    "rotation": "lower waves",
    "translation": "a mooring (body.stiffness), if the body drifts; lower waves",
    "surge": "a mooring",
    "irregular_frequencies": "a lid, or finer panels",
    "resonance": "damping of the enclosed water (body.damping): linear theory has none but radiation",
    "lid": "finer panels, or lid: 0 and frequencies below the first irregular one",
    "closure": "a mesh without the gap",
    "displaced_mass": "the mass, or the vertical position of the mesh",
    "rigid_names": "the labels of the displacements",
    "hinge_gap": "a mesh whose parts are closed at the hinge",
    "second_order": "second_order in the file of the displacements",
    **dict.fromkeys(("panels", "modes", "corners", "one_resolution"), "finer panels"),
    **dict.fromkeys(
        ("error_estimate", "interpolation_error", "symmetry", "far_field", "positive_damping", "rank_one", "haskind",
         "kramers_kronig", "limit_difference", "witness_derivatives", "witness_database"),
        "lower hydro.tolerance, or finer panels",
    ),
    **dict.fromkeys(
        ("phases", "displaced_volume", "parts", "trim", "added_mass_limits", "tilt", "rotation_centre", "waterplane",
         "centre_of_buoyancy", "mass_coupling", "places"),
        "the coefficient file, as the check explains",
    ),
    **dict.fromkeys(
        ("long_waves", "haskind_scale", "haskind_long_waves"), "length, gravity and depth of the coefficient file"
    ),
}  # fmt: skip
"""Name of a check -> what to change first in the study where it fails, if the check itself has tried nothing."""
REASONS = {
    "buckling": "the shell buckles under its static load ({value} times the classical buckling pressure)",
    "computed_buckling": "the shell buckles under its static load ({value} times what it can carry)",
    "static_strain": "the strain at rest is {percent} %, beyond the limit of its material's law (Hooke's: 10 %)",
    "strain": "the strain reaches {percent} %, beyond the limit of its material's law (Hooke's: 10 %)",
    "modes_left_out": "the omitted shell modes change the absorbed power by up to {percent} %",
    "modes": "the panels do not resolve the shortest mode",
    "panels": "the panels do not resolve the shortest waves",
    "energy_residual": "the energy balance of the simulation does not close (residual {value})",
    "power_limit": "a design absorbs {value} times the theoretical limit of any device",
    "assumed_pressure": "the assumed pressure gives a buoy {value} times the power of a wave with that pressure",
}
"""Name of a check that invalidates results (`vsb.engine.hydro.database.INVALIDATING`) -> the reason in words."""


def reasons(invalid: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return why results are not valid, each reason once, with its largest value; of `vsb.results.ledger.Invalid`."""
    worst: dict[str, float] = {}
    for line in invalid:
        worst[line["name"]] = max(worst.get(line["name"], 0.0), float(line["value"]))
    if "computed_buckling" in worst:
        worst.pop("buckling", None)
    return [REASONS[name].format(value=short(value), percent=plain(100 * value, 2)) for name, value in worst.items()]


def no_answer(invalid: Sequence[Mapping[str, Any]]) -> str:
    """Return why there is no valid answer, and what to change."""
    changes = dict.fromkeys(line.get("advice") or ADVICE[line["name"]] for line in invalid)
    return f"No valid answer yet: {'; '.join(reasons(invalid))}. Change first: {'; '.join(changes)}."


def warnings(checks: Sequence[dict[str, Any]]) -> list[str]:
    """Return the checks that failed, for each name the one furthest beyond its limit; doubts are in the ledger only."""
    found: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        if check["verdict"] in ("fail", "accepted"):
            found.setdefault(str(check["name"]), []).append(check)
    lines = []
    for of in found.values():
        worst = max(of, key=lambda check: float(check["value"]) / (float(check["limit"]) or 1.0))
        others = f"; {len(of) - 1} more fail" if len(of) > 1 else ""
        change = f". Change first: {text}" if (text := advice(worst)) else ""
        lines.append(f"{in_words(worst)}{others}{change}")
    return lines


def in_words(check: dict[str, Any]) -> str:
    """Return a check with its value and limit in words."""
    of = f" of {check['design']}" if check["design"] else ""
    where = f" in {check['wave']}" if check["wave"] else ""
    what = f"{str(check['name']).replace('_', ' ')}{of}{where}"
    return f"{what}: {short(check['value'])}, limit {short(check['limit'])} ({check['explanation']})"


def advice(check: dict[str, Any]) -> str:
    """Return what to change first if a check does not hold; empty if it holds or no general advice exists."""
    return "" if check["verdict"] == "ok" else check.get("advice") or ADVICE.get(str(check["name"]), "")


LOWEST = 0.3
"""Lowest frequency shown [rad/s]: waves longer than 21 s are not seas."""
USEFUL_SHARE = 0.05
"""Share of the largest absorbed power below which power, and a gain there, is of no use."""
RESOLVED, RELATIVE = 0.01, 1e-3
"""Absolute [%] and relative tolerance of gains at their extremes."""
HALVINGS = 30
"""Most halvings of a step of frequency."""


def lowest(first: float, last: float) -> float:
    """Return the lowest frequency shown of a band [rad/s]: `LOWEST`, or the first of a band that hardly exceeds it."""
    return LOWEST if last >= 2 * LOWEST else first


def useful_band(absorbed: xr.DataArray) -> xr.DataArray:
    """Return at which frequencies some design absorbs a useful power; dims of the argument (design, omega)."""
    best, least = absorbed.max(dim="design"), lowest(float(absorbed.omega[0]), float(absorbed.omega[-1]))
    found: xr.DataArray = (best >= USEFUL_SHARE * best.max()) & (absorbed.omega >= least)
    return found


def gain_band(absorbed: xr.DataArray, reference: str) -> xr.DataArray:
    """Return at which frequencies a gain over a design is meaningful, dims (omega).

    Not where the reference absorbs next to nothing compared with its largest power and with other designs.
    """
    rigid = absorbed.sel(design=reference, drop=True)
    absorbs = (rigid >= USEFUL_SHARE * rigid.max()) | (rigid >= 0.1 * absorbed.max("design"))
    found: xr.DataArray = useful_band(absorbed) & absorbs & (rigid > 0)
    return found


def with_extremes(power: Callable[[FloatArray], xr.DataArray], omega: FloatArray, reference: str) -> FloatArray:
    """Return frequencies refined where gains over a design are largest and smallest [rad/s].

    Steps next to an extreme, and across an end of `gain_band`, are halved until the gain changes over them by less than
    the tolerance `RESOLVED` + `RELATIVE` times the gain. `power` has dims (design, omega).
    """
    found = power(omega)
    for _ in range(HALVINGS):
        steps = _unresolved(found, reference)
        if not steps.any():
            break
        known = found.omega.values
        between = (known[1:] + known[:-1])[steps] / 2
        found = xr.concat([found, power(between)], "omega").sortby("omega")
    return np.asarray(found.omega.values)


def _unresolved(power: xr.DataArray, reference: str) -> BoolArray:
    """Which steps next to an extreme of gain or power, or across an end of the band, are too long."""
    shown = gain_band(power, reference).values
    others = power.sel(design=power.design != reference)
    rigid = power.sel(design=reference).where(power.sel(design=reference) > 0, 1.0)
    best = power.max("design")
    curves = np.vstack([100 * (others / rigid - 1).values, 100 * (best / best.max()).values[None]])
    change = np.diff(curves)
    long = np.abs(change) > RESOLVED + RELATIVE * np.minimum(np.abs(curves[:, 1:]), np.abs(curves[:, :-1]))
    turns = np.zeros_like(curves, dtype=bool)
    turns[:, 1:-1] = change[:, 1:] * change[:, :-1] <= 0
    near = shown[1:] | shown[:-1]
    ends = shown[1:] != shown[:-1]
    return np.asarray((long & (((turns[:, 1:] | turns[:, :-1]) & near) | ends)).any(axis=0))
