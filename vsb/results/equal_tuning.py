"""Designs at equal tuning: each at its own best damper, and how much of that the given damper takes."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vsb.hydro.database import Check, Verdict
from vsb.results.budget import Budget, Rows, mean_budget
from vsb.results.comparison import gains
from vsb.results.ladder import Rung
from vsb.study.study import BaseStudy, IrregularSea
from vsb.study.take_off import Pto, damper_unit
from vsb.tools.words import plain

LOST = 0.05
"""Part of its best damper's power that a design may lose before a comparison at the given damper is in doubt."""
NEXT_TO_NOTHING = 1e3
"""Matched power over the rigid design's own best, above which gains over that design mean nothing."""


class Tuned(NamedTuple):
    """One design in one sea by linear theory, all realisations together: at its own best damper, and at the given one.

    Gains are over the first rigid design's power, none without one.
    """

    design: str
    sea: str
    best_damping: float | None  # mean over realisations [N s/m]; none of a port that cannot move
    best_power: float  # [W]
    best_gain_percent: float | None
    damping: float | None  # as given [N s/m]; this and the next are none where tuning decides
    power: float | None  # [W]
    gain_percent: float | None
    share: float | None  # power over best power [-]; none where there is none to take
    best_low: float | None = None  # interval of the gain at its own best damper [%], of all known sources of error
    best_high: float | None = None
    low: float | None = None  # likewise at the given damper
    high: float | None = None
    errors: Rows = ()  # of the gain at its own best damper [percentage points], see `vsb.results.budget.Budget.rows`


Beyond = Mapping[tuple[str, str], Budget]
"""Errors of a gain beyond linear theory and its numbers, by design and sea [percentage points]."""


def equal_tuning(study: BaseStudy, rungs: Sequence[Rung], beyond: Beyond | None = None) -> list[Tuned]:
    """Return one line per sea and design, from the ladder of a study.

    Parameters
    ----------
    study : BaseStudy
    rungs : sequence of Rung
    beyond : mapping, optional
        See `vsb.results.intervals.linearisation`.
    """
    found: list[Tuned] = []
    for sea, here in _by_sea(study, rungs).items():
        best, fixed = _means(here, "best_damper"), _means(here, "fixed")
        best_gains = gains({d: power for d, (_, power) in best.items()}, study.reference_design)
        fixed_gains = gains({d: power for d, (_, power) in fixed.items()}, study.reference_design) if fixed else {}
        for design, (damper, power) in best.items():
            given, taken = fixed.get(design, (None, None))
            share = taken / power if taken is not None and power > 0 else None
            at_best = (damper, power, best_gains[design])
            line = Tuned(design, sea, *at_best, given, taken, fixed_gains.get(design), share)
            more = (beyond or {}).get((design, sea), Budget())
            errors = gain_budget(here, design, "best_damper") + more
            low, high = _interval(line.best_gain_percent, errors)
            line = line._replace(best_low=low, best_high=high, errors=errors.rows)
            low, high = _interval(line.gain_percent, gain_budget(here, design, "fixed") + more)
            found.append(line._replace(low=low, high=high))
    return found


def gain_budget(rungs: Sequence[Rung], design: str, name: str) -> Budget:
    """Return the error budget of the gain of a design at a rung, realisations together; the reference has none."""
    rows = [rung.gain_error for rung in rungs if rung.rung == name and rung.design == design]
    return mean_budget([Budget.of(each) for each in rows if each is not None])


def _interval(gain: float | None, errors: Budget) -> tuple[float | None, float | None]:
    """The interval of a gain, if there is one."""
    return (None, None) if gain is None else errors.interval(gain)


class Limited(NamedTuple):
    """What no take-off within the limits of force and stroke can exceed, all realisations of a sea together."""

    design: str
    sea: str
    power: float  # [W]
    gain_percent: float | None
    low: float | None = None  # interval of the gain by all known sources of error [%]
    high: float | None = None


def within_limits(study: BaseStudy, rungs: Sequence[Rung]) -> list[Limited]:
    """Return one line per sea and design whose optimum under limits is known in all realisations."""
    found = []
    for sea, here in _by_sea(study, rungs).items():
        unknown = {rung.design for rung in here if rung.rung == "constrained" and rung.power_mean is None}
        powers = {d: p for d, (_, p) in _means(here, "constrained").items() if d not in unknown}
        over = gains(powers, study.reference_design if study.reference_design in powers else None)
        for design, power in powers.items():
            ends = _interval(over[design], gain_budget(here, design, "constrained"))
            found.append(Limited(design, sea, power, over[design], *ends))
    return found


def _by_sea(study: BaseStudy, rungs: Sequence[Rung]) -> dict[str, list[Rung]]:
    """Rungs by the name of their sea, one for all realisations; each looked at once, there may be thousands."""
    seas = {wave.label: wave.family if isinstance(wave, IrregularSea) else wave.label for wave in study.waves}
    found: dict[str, list[Rung]] = {}
    for rung in rungs:
        found.setdefault(seas[rung.wave], []).append(rung)
    return found


def _means(rungs: Sequence[Rung], name: str) -> dict[str, tuple[float | None, float]]:
    """Damper and power of a rung by design, means over the realisations of a sea."""
    of_design: dict[str, list[Rung]] = {}
    for rung in rungs:
        if rung.rung == name and rung.power_mean is not None:
            of_design.setdefault(rung.design, []).append(rung)
    dampers = {d: [rung.damping for rung in found if rung.damping is not None] for d, found in of_design.items()}
    powers = {d: float(np.mean([rung.power_mean or 0.0 for rung in found])) for d, found in of_design.items()}
    return {d: (float(np.mean(dampers[d])) if dampers[d] else None, power) for d, power in powers.items()}


def fair_damping_checks(lines: Sequence[Tuned], pto: Pto) -> list[Check]:
    """Return the power each design loses at the given damper: designs that lose unequally are not compared fairly.

    None for Coulomb friction, latching and declutching: their power is not that of the damper by linear theory.
    """
    if pto.law not in ("linear", "saturated"):
        return []
    checks, unit = [], damper_unit(pto.port)
    for line in lines:
        if line.share is None or line.power is None or line.damping is None or line.best_damping is None:
            continue
        text = f"power lost against the own best damper: {plain(line.power)} W at {plain(line.damping)} {unit}, "
        text += f"{plain(line.best_power)} W at {plain(line.best_damping)} {unit}, by linear theory"
        lost = max(0.0, 1 - line.share)
        verdict: Verdict = "doubt" if lost > LOST else "ok"  # never wrong: an answer to another question
        checks.append(Check("fair_damping", lost, LOST, "-", verdict, text, line.design, line.sea))
    return checks


def reference_power_checks(study: BaseStudy, rungs: Sequence[Rung]) -> list[Check]:
    """Return what the rigid design leaves in each sea at its best damper: over next to nothing any gain is large."""
    reference, checks = study.reference_design or "", []
    for sea, here in _by_sea(study, rungs).items():
        matched, best = (_means(here, name).get(reference, (None, 0.0))[1] for name in ("matched", "best_damper"))
        if best > 0 and matched > 0:
            left = matched / best
            verdict: Verdict = "doubt" if left > NEXT_TO_NOTHING else "ok"
            text = f"{plain(matched)} W within reach of {reference} over {plain(best)} W at its best damper: "
            text += "gains over next to nothing say nothing"
            checks.append(Check("reference_power", left, NEXT_TO_NOTHING, "-", verdict, text, wave=sea))
    return checks
