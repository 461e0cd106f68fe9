"""Gains over the rigid design: at equal tuning, within limits, in runs; each with the interval of all known errors."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.hydro.database import Check, Verdict
from vsb.results.budget import Budget, Rows, Source, mean_budget
from vsb.results.comparison import Attributes, Row, gains, linear_mean, relative_difference
from vsb.results.ladder import ControlLevel
from vsb.results.statistics import Line
from vsb.scenes.drag import LINEARISED
from vsb.study.study import BaseStudy
from vsb.study.take_off import Pto, port_kind
from vsb.study.waves import IrregularSea
from vsb.tools.words import plain, superscripts

LOST = 0.05
"""Part of its best damper's power that a design may lose before a comparison at the given damper is in doubt."""
NEXT_TO_NOTHING = 1e3
"""Matched power over the rigid design's own best, above which gains over that design mean nothing."""
LEVELS = {"fixed": "fixed", "each": "best_damper", "one": "best_damper_all_seas"}
"""How the damper of a run is found -> the control level with the same damper."""
IN_TIME, SIMPLIFIED = "simulation in time", "forces left out by hydro.model auto"
LINEARISATION, STATISTICS = "linearisation", "statistics of the runs"

Beyond = Mapping[tuple[str, str], Budget]
"""Errors of a gain beyond linear theory and its numbers, by design and sea [percentage points]."""


# at equal tuning and within limits, by linear theory ----------------------------------------------------------------


class Tuned(NamedTuple):
    """One design in one sea by linear theory, all realisations together: at its own best damper, and at the given one.

    Gains are over the first rigid design's power, None without one.
    """

    design: str
    sea: str
    best_damping: float | None  # mean over realisations [N s/m]; None of a port that cannot move
    best_power: float  # [W]
    best_gain_percent: float | None
    damping: float | None  # as given [N s/m]; this and the next are None where the damper is tuned
    power: float | None  # [W]
    gain_percent: float | None
    share: float | None  # power over best power [-]; None where that is zero
    best_low: float | None = None  # interval of the gain at its own best damper [%], of all known sources of error
    best_high: float | None = None
    low: float | None = None  # likewise at the given damper
    high: float | None = None
    errors: Rows = ()  # of the gain at its own best damper [percentage points], see `vsb.results.budget.Budget.rows`


class Limited(NamedTuple):
    """What no take-off within the limits of force and stroke can exceed, all realisations of a sea together."""

    design: str
    sea: str
    power: float  # [W]
    gain_percent: float | None
    low: float | None = None  # interval of the gain by all known sources of error [%]
    high: float | None = None


def equal_tuning(study: BaseStudy, levels: Sequence[ControlLevel], beyond: Beyond | None = None) -> list[Tuned]:
    """Return one line per sea and design, from the control levels of a study.

    Parameters
    ----------
    beyond : mapping, optional
        See `linearisation`.
    """
    found: list[Tuned] = []
    for sea, here in _by_sea(study, levels).items():
        best, fixed = _means(here, "best_damper"), _means(here, "fixed")
        best_gains = gains({d: power for d, (_, power) in best.items()}, study.reference_design)
        fixed_gains = gains({d: power for d, (_, power) in fixed.items()}, study.reference_design) if fixed else {}
        for design, (damper, best_power) in best.items():
            more = (beyond or {}).get((design, sea), Budget())
            at_best, at_given = (gain_budget(here, design, level) + more for level in ("best_damper", "fixed"))
            given, power = fixed.get(design, (None, None))
            share = power / best_power if power is not None and best_power > 0 else None
            best_gain, gain = best_gains[design], fixed_gains.get(design)
            line = (design, sea, damper, best_power, best_gain, given, power, gain, share)
            found.append(Tuned(*line, *_interval(best_gain, at_best), *_interval(gain, at_given), at_best.rows))
    return found


def within_limits(study: BaseStudy, levels: Sequence[ControlLevel]) -> list[Limited]:
    """Return one line per sea and design whose optimum within limits is known in all realisations."""
    found = []
    for sea, here in _by_sea(study, levels).items():
        unknown = {one.design for one in here if one.rung == "constrained" and one.power_mean is None}
        powers = {d: p for d, (_, p) in _means(here, "constrained").items() if d not in unknown}
        over = gains(powers, study.reference_design if study.reference_design in powers else None)
        for design, power in powers.items():
            ends = _interval(over[design], gain_budget(here, design, "constrained"))
            found.append(Limited(design, sea, power, over[design], *ends))
    return found


def gain_budget(levels: Sequence[ControlLevel], design: str, level: str) -> Budget:
    """Return the error budget of the gain of a design at a level, realisations together; the reference has none."""
    rows = [one.gain_error for one in levels if one.rung == level and one.design == design]
    return mean_budget([Budget.of(each) for each in rows if each is not None])


def _interval(gain: float | None, errors: Budget) -> tuple[float | None, float | None]:
    """The interval of a gain, if there is one."""
    return (None, None) if gain is None else errors.interval(gain)


def _by_sea(study: BaseStudy, levels: Sequence[ControlLevel]) -> dict[str, list[ControlLevel]]:
    """Levels by the name of their sea, one for all realisations."""
    seas = {wave.label: wave.family if isinstance(wave, IrregularSea) else wave.label for wave in study.waves}
    found: dict[str, list[ControlLevel]] = {}
    for one in levels:
        found.setdefault(seas[one.wave], []).append(one)
    return found


def _means(levels: Sequence[ControlLevel], level: str) -> dict[str, tuple[float | None, float]]:
    """Damper and power at a level by design, means over the realisations of a sea."""
    of_design: dict[str, list[ControlLevel]] = {}
    for one in levels:
        if one.rung == level and one.power_mean is not None:
            of_design.setdefault(one.design, []).append(one)
    found: dict[str, tuple[float | None, float]] = {}
    for design, some in of_design.items():
        dampers = [one.damping for one in some if one.damping is not None]
        power = float(np.mean([one.power_mean or 0.0 for one in some]))
        found[design] = (float(np.mean(dampers)) if dampers else None, power)
    return found


def fair_damping_checks(lines: Sequence[Tuned], pto: Pto) -> list[Check]:
    """Return the power each design loses at the given damper: designs that lose unequally are not compared fairly.

    None for Coulomb friction, latching and declutching: their power is not that of the damper by linear theory.
    """
    if pto.law not in ("linear", "saturated"):
        return []
    checks, unit = [], superscripts(port_kind(pto.port).damping_unit)
    for line in lines:
        if line.share is None or line.power is None or line.damping is None or line.best_damping is None:
            continue
        text = f"power lost against the own best damper: {plain(line.power)} W at {plain(line.damping)} {unit}, "
        text += f"{plain(line.best_power)} W at {plain(line.best_damping)} {unit}, by linear theory"
        lost = max(0.0, 1 - line.share)
        verdict: Verdict = "doubt" if lost > LOST else "ok"  # never a failure: it answers another question
        checks.append(Check("fair_damping", lost, LOST, "-", verdict, text, line.design, line.sea))
    return checks


def reference_power_checks(study: BaseStudy, levels: Sequence[ControlLevel]) -> list[Check]:
    """Return the matched over the best-damper power of the rigid design: a gain over next to nothing means nothing."""
    reference, checks = study.reference_design or "", []
    for sea, here in _by_sea(study, levels).items():
        matched, best = (_means(here, name).get(reference, (None, 0.0))[1] for name in ("matched", "best_damper"))
        if best > 0 and matched > 0:
            ratio = matched / best
            verdict: Verdict = "doubt" if ratio > NEXT_TO_NOTHING else "ok"
            text = f"{reference} could absorb {plain(matched)} W, and absorbs {plain(best)} W at its best damper: "
            text += "gains over next to nothing mean nothing"
            checks.append(Check("reference_power", ratio, NEXT_TO_NOTHING, "-", verdict, text, wave=sea))
    return checks


# in runs ------------------------------------------------------------------------------------------------------------


def with_intervals(
    study: BaseStudy,
    rows: Sequence[Row],
    runs: Attributes,
    levels: Sequence[ControlLevel],
    frequency: xr.Dataset | None,
) -> list[Row]:
    """Return the rows of a comparison with the intervals of their gains of mean power.

    Parameters
    ----------
    rows : sequence of Row
        See `vsb.results.comparison.comparison`.
    runs : mapping (design, label) -> attributes of the run
    levels : sequence of ControlLevel
        The control levels; empty without linear hydrodynamics.
    frequency : xarray.Dataset or None
        The frequency response, likewise.

    Notes
    -----
    Sources are those of the same gain by linear theory at the same damper, and what simulation in time adds: in a
    regular wave by a linear model the distance from the frequency domain, transient included; else the energy that a
    run leaves unbalanced. A row is of one realisation of a sea, so nothing is statistical.
    """
    reference, found = study.reference_design, []
    waves = {wave.label: wave for wave in study.waves}
    power = {(row["design"], row["wave"]): float(row["power_mean"]) for row in rows}
    by_sea: dict[str, list[ControlLevel]] = {}
    for one in levels:
        by_sea.setdefault(one.wave, []).append(one)

    def error_in_time(design: str, label: str) -> float:
        """Relative error of the mean power of a run [-]."""
        run = runs[design, label]
        residual = float(str(run["energy_residual"]))
        if frequency is None or not _is_linear(run):
            return residual
        expected = linear_mean(study, waves[label], frequency, design, run)
        return residual if expected is None else max(residual, relative_difference(power[design, label], expected))

    for row in rows:
        if (gain := row["power_gain_percent"]) is None or reference is None:
            found.append(row)
            continue
        design, label, budget = row["design"], row["wave"], Budget()
        if design != reference:
            both, ratio = (design, reference), abs(100 + gain)
            budget = gain_budget(by_sea.get(label, ()), design, LEVELS[study.tuning(waves[label])])
            budget += Budget((Source.within(IN_TIME, ratio * sum(error_in_time(one, label) for one in both)),))
            simplified = sum(float(runs[one, label].get("power_error", 0.0)) for one in both)
            budget += Budget((Source.within(SIMPLIFIED, ratio * simplified),) if simplified else ())
        low, high = budget.interval(gain)
        found.append({**row, "low": low, "high": high})
    return found


def linearisation(
    study: BaseStudy, rows: Sequence[Row], runs: Attributes, frequency: xr.Dataset, lines: Sequence[Line]
) -> dict[tuple[str, str], Budget]:
    """Return how far gains by linear theory are from those of runs, by design and sea [percentage points].

    In a regular wave the difference of the gain in time from that of linear theory at the same damper; in irregular
    seas likewise of all realisations, with the statistics of the runs. Nothing where all models are linear.
    """
    reference, found = study.reference_design, {}
    if reference is None or study.pto.nonlinear or all(_is_linear(run) for run in runs.values()):
        return {}
    means = {(row["design"], row["wave"]): float(row["power_mean"]) for row in rows}
    for wave in study.waves:
        label = wave.label
        expected = {d: linear_mean(study, wave, frequency, d, runs[d, label]) for d in study.designs}
        known = {design: value for design, value in expected.items() if value is not None}
        if len(known) < len(expected) or all(_is_linear(runs[d, label]) for d in study.designs):
            continue
        linear, in_time = gains(known, reference), gains({d: means[d, label] for d in known}, reference)
        for design in known:
            there, here = in_time[design], linear[design]
            if design != reference and there is not None and here is not None:
                found[design, label] = Budget((Source.towards(LINEARISATION, there - here),))
    for line in lines:
        base = next(other for other in lines if other.sea == line.sea and other.design == reference)
        if line.design == reference or line.gain_percent is None or not base.power_linear_record > 0:
            continue
        change = line.gain_percent - 100 * (line.power_linear_record / base.power_linear_record - 1)
        sources = [Source.towards(LINEARISATION, change)]
        if line.amplitudes == "random" and line.gain_low is not None and line.gain_high is not None:
            sources.append(Source.within(STATISTICS, (line.gain_high - line.gain_low) / 2, "statistic"))
        found[line.design, line.sea] = Budget(tuple(sources))
    return found


def _is_linear(run: Mapping[str, Any]) -> bool:
    """Whether a run is of a linear model without drag, which the frequency domain describes."""
    return run["model"] == "linear" and LINEARISED not in run
