"""Intervals of what runs in time say, and what they say of linear theory."""

from collections.abc import Mapping, Sequence

import xarray as xr

from vsb.results.budget import Budget, Source
from vsb.results.comparison import Row, gains
from vsb.results.equal_tuning import gain_budget
from vsb.results.ladder import Rung
from vsb.results.power import apart, in_direction, power_response
from vsb.results.run_checks import Attributes
from vsb.results.statistics import Line
from vsb.scenes.drag import LINEARISED
from vsb.study.study import BaseStudy
from vsb.study.waves import RegularWave, Wave

RUNG = {"fixed": "fixed", "each": "best_damper", "one": "best_damper_all_seas"}
"""How the damper of a run is found -> the rung of the ladder at the same damper."""
IN_TIME, SIMPLIFIED = "simulation in time", "forces left out by hydro.model auto"
LINEARISATION, STATISTICS = "linearisation", "statistics of the runs"


def with_intervals(
    study: BaseStudy, rows: Sequence[Row], runs: Attributes, rungs: Sequence[Rung], frequency: xr.Dataset | None
) -> list[Row]:
    """Return the rows of a comparison with the intervals of their gains of mean power.

    Parameters
    ----------
    study : BaseStudy
    rows : sequence of Row
        See `vsb.results.comparison.comparison`.
    runs : mapping (design, label) -> attributes of the run
    rungs : sequence of Rung
        The ladder; empty without linear hydrodynamics.
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
    for row in rows:
        if (gain := row["power_gain_percent"]) is None or reference is None:
            found.append(row)
            continue
        design, wave = row["design"], waves[row["wave"]]
        budget = Budget()
        if design != reference:
            here = [rung for rung in rungs if rung.wave == wave.label]
            budget = gain_budget(here, design, RUNG[study.tuning(wave)])
            both, ratio = (design, reference), 100 + gain
            at = [(one, runs[one, wave.label], power[one, wave.label]) for one in both]
            wrong = sum(_error_in_time(study, wave, frequency, *each) for each in at)
            budget += Budget((Source.within(IN_TIME, abs(ratio) * wrong),))
            simplified = sum(float(runs[one, wave.label].get("power_error", 0.0)) for one in both)
            budget += Budget((Source.within(SIMPLIFIED, abs(ratio) * simplified),) if simplified else ())
        low, high = budget.interval(gain)
        found.append({**row, "low": low, "high": high})
    return found


def _error_in_time(
    study: BaseStudy, wave: Wave, frequency: xr.Dataset | None, design: str, run: Mapping[str, object], mean: float
) -> float:
    """Relative error of the mean power of a run [-]."""
    residual = float(str(run["energy_residual"]))
    expected = None if frequency is None else linear_mean(study, wave, frequency, design, run)
    if expected is None or not _is_linear(run):
        return residual
    return max(residual, apart(mean, expected))


def _is_linear(run: Mapping[str, object]) -> bool:
    """Whether a run is of a linear model without drag, which the frequency domain describes."""
    return run["model"] == "linear" and LINEARISED not in run


def linear_mean(
    study: BaseStudy, wave: Wave, frequency: xr.Dataset, design: str, run: Mapping[str, object]
) -> float | None:
    """Return the mean power of linear theory at the damper of a run in a regular wave; None if it is none [W]."""
    if not isinstance(wave, RegularWave) or study.pto.switches:
        return None
    if LINEARISED in run:
        return float(str(run[LINEARISED]))
    found = power_response(study, in_direction(frequency, wave), design, run)
    return float(found.sel(omega=wave.omega, method="nearest")) * wave.amplitude**2


def linearisation(
    study: BaseStudy, rows: Sequence[Row], runs: Attributes, frequency: xr.Dataset, lines: Sequence[Line]
) -> dict[tuple[str, str], Budget]:
    """Return what runs in time say of gains by linear theory, by design and sea [percentage points].

    In a regular wave the difference of the gain in time from that of linear theory at the same damper; in irregular
    seas likewise of all realisations, with the statistics of the runs. Where models are linear nothing is left out.
    """
    reference, found = study.reference_design, {}
    if reference is None or study.pto.switches:
        return {}
    nonlinear = [key for key, run in runs.items() if not _is_linear(run)]
    means = {(row["design"], row["wave"]): float(row["power_mean"]) for row in rows}
    for wave in study.waves:
        expected = {d: linear_mean(study, wave, frequency, d, runs[d, wave.label]) for d in study.designs}
        known = {design: value for design, value in expected.items() if value is not None}
        if len(known) < len(expected) or not any((d, wave.label) in nonlinear for d in study.designs):
            continue
        linear, in_time = gains(known, reference), gains({d: means[d, wave.label] for d in known}, reference)
        for design in known:
            there, here = in_time[design], linear[design]
            if design != reference and there is not None and here is not None:
                found[design, wave.label] = Budget((Source.towards(LINEARISATION, there - here),))
    if nonlinear:
        found |= _of_irregular_seas(lines, reference)
    return found


def _of_irregular_seas(lines: Sequence[Line], reference: str) -> dict[tuple[str, str], Budget]:
    """The same of irregular seas, linear theory in the same waves."""
    found = {}
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
