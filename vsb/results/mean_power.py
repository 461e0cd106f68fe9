"""The mean power of a design in a sea, and its gain: one number each, with the budget of its errors.

Where hydrodynamics and take-off are linear it is the expectation over the spectrum, from the frequency domain: that of
the control level with the damper of the run. Else it is estimated from runs in time: in a regular wave by their mean,
in irregular seas by the mean of all realisations of a sea times what linear theory expects of the sea over what it has
in the very same waves. This ratio takes out what a record has more or less of than its sea; its scatter between batches
of the records is the sampling error. Of a record of elevations the sea is the whole record.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.motion.take_off import DAMPERS
from vsb.engine.waves.kinds import Wave
from vsb.models.take_off import LINEARISED
from vsb.results.budget import Budget, Source
from vsb.results.comparison import Attributes, Row, gains, linear_mean, relative_difference
from vsb.results.ladder import ControlLevel
from vsb.results.statistics import Line, Sample, families, record_interval, student, together
from vsb.study.study import FEWEST_BATCHES, Study
from vsb.tools.arrays import FloatArray

LEVELS = {"fixed": "fixed", "each": "best_damper", "one": "best_damper_all_seas"}
"""How the damper of a run is found -> the control level with the same damper."""
IN_TIME, SIMPLIFIED = "simulation in time", "forces left out by hydro.model auto"
STATISTICS = "statistics of the runs"
Samples = Mapping[tuple[str, str], Sample]


class MeanPower(NamedTuple):
    """Mean power of a design in a sea, and its gain over the reference design; no gain without one."""

    power: float  # [W]
    errors: Budget  # [W]
    gain: float | None = None  # [%]
    gain_errors: Budget = Budget()  # [percentage points]

    @property
    def row(self) -> Row:
        """Its columns of the comparison."""
        low, high = (None, None) if self.gain is None else self.gain_errors.interval(self.gain)
        power_low, power_high = self.errors.interval(self.power)
        named = {"power_mean": self.power, "power_low": power_low, "power_high": power_high}
        return named | {"power_gain_percent": self.gain, "low": low, "high": high}


MeanPowers = Mapping[tuple[str, str], MeanPower]
"""Mean powers by design and label of the sea; those of all realisations of a sea are the same."""


OUT_OF_REACH = 5.0
"""Limit over the peak of a realisation by linear theory, above which the take-off never meets it."""


def is_linear(study: Study, run: Mapping[str, Any], level: ControlLevel | None = None) -> bool:
    """Return whether a run is of linear hydrodynamics and a linear take-off, which the frequency domain describes.

    So is one whose limits are out of reach, by the control level with its damper.
    """
    if run["model"] != "linear" or LINEARISED in run:
        return False
    pto = study.pto
    if not pto.nonlinear:
        return True
    if level is None or pto.law not in DAMPERS or level.force_peak is None or level.stroke_peak is None:
        return False
    return pto.force_limit > OUT_OF_REACH * level.force_peak and pto.stroke_limit > OUT_OF_REACH * level.stroke_peak


def linear_seas(study: Study, runs: Attributes, levels: Sequence[ControlLevel]) -> set[str]:
    """Return the irregular seas in all whose runs hydrodynamics and take-off are linear, see `is_linear`."""
    by = {(one.design, one.wave, one.rung): one for one in levels}
    found = set()
    for name, waves in families(study).items():
        label, rung = waves[0].label, LEVELS[study.tuning(waves[0])]
        if all(is_linear(study, runs[design, label], by.get((design, label, rung))) for design in study.designs):
            found.add(name)
    return found


def mean_powers(
    study: Study,
    rows: Sequence[Row],
    runs: Attributes,
    levels: Sequence[ControlLevel],
    frequency: xr.Dataset | None,
    samples: Samples,
) -> dict[tuple[str, str], MeanPower]:
    """Return the mean power of every design in every sea with waves.

    Parameters
    ----------
    rows : sequence of Row
        See `vsb.results.comparison.comparison`.
    runs : mapping (design, label) -> attributes of the run
    levels : sequence of ControlLevel
        The control levels; empty without linear hydrodynamics.
    frequency : xarray.Dataset or None
        The frequency response, likewise.
    samples : mapping (design, label) -> Sample
        Of runs in irregular seas.
    """
    records = {(row["design"], row["wave"]): float(row["record_power_mean"]) for row in rows}
    by = {(one.design, one.wave, one.rung): one for one in levels}
    seas: dict[str, list[Wave]] = {}
    for wave in study.waves:
        if not wave.still:
            seas.setdefault(wave.family, []).append(wave)
    found: dict[tuple[str, str], MeanPower] = {}
    for waves in seas.values():
        labels, rung = [wave.label for wave in waves], LEVELS[study.tuning(waves[0])]
        estimates = {}
        for design in study.designs:
            level = by.get((design, labels[0], rung))
            attrs = [runs[design, label] for label in labels]
            record = float(np.mean([records[design, label] for label in labels]))
            own = together([samples[design, label] for label in labels]) if (design, labels[0]) in samples else None
            linear = _linear(study, waves[0], frequency, design, attrs[0], level, own)
            estimates[design] = _estimate(study, attrs, level, record, linear, own)
        in_sea = _with_gains(study, estimates)
        found |= {(design, label): one for design, one in in_sea.items() for label in labels}
    return found


def with_mean_powers(rows: Sequence[Row], means: MeanPowers) -> list[Row]:
    """Return the rows of a comparison with the mean powers of their seas, their gains and the intervals of both.

    Capture widths are those of these powers. Rows without one, of still water, are left as they are.
    """
    found = []
    for row in rows:
        mean = means.get((row["design"], row["wave"]))
        if mean is None:
            found.append(row)
            continue
        record, width = float(row["record_power_mean"]), row["capture_width"]
        flux = record / width if width else None
        found.append({**row, **mean.row, "capture_width": mean.power / flux if flux else width})
    return found


def with_record_intervals(study: Study, wave: Wave, rows: Sequence[Row], samples: Samples) -> list[Row]:
    """Return the rows of a sea with what the mean of each record alone says of it; nothing of other seas than spectra.

    Parameters are those of `mean_powers`.
    """
    if not wave.drawn:
        return list(rows)
    found, random = [], wave.amplitudes == "random"
    for row in rows:
        mean, length = float(row["record_power_mean"]), float(row["record_end"] - row["record_start"])
        low, high = record_interval(mean, samples[row["design"], wave.label], length, random=random)
        found.append({**row, "record_power_low": low, "record_power_high": high})
    return found


def of_seas(study: Study, lines: Sequence[Line], means: MeanPowers) -> list[Line]:
    """Return the lines of irregular seas with the mean powers of the seas; those of the runs stand beside them."""
    labels = {name: waves[0].label for name, waves in families(study).items()}
    found = []
    for line in lines:
        mean = means[line.design, labels[line.sea]]
        low, high = mean.errors.interval(mean.power)
        one = line._replace(power_mean=mean.power, power_low=low, power_high=high)
        if line.gain_percent is not None and mean.gain is not None:
            low, high = mean.gain_errors.interval(mean.gain)
            one = one._replace(gain_percent=mean.gain, gain_low=low, gain_high=high)
        found.append(one._replace(record_power_mean=line.power_mean, record_gain_percent=line.gain_percent))
    return found


# one design ---------------------------------------------------------------------------------------------------------


class _Estimate(NamedTuple):
    """What is known of the mean power of a design in a sea."""

    power: float  # [W]
    coefficients: Budget  # by coefficients and shell modes [W]
    gain_by_coefficients: Budget  # the same of its gain over the reference [percentage points]
    in_time: float  # relative error by simulation in time [-]
    simplified: float  # relative error by what model auto leaves out [-]
    record: float  # mean of the records [W]
    linear: float | None  # expectation by linear theory [W]
    draws: FloatArray | None  # of each batch about the power (batch,) [W]; none where nothing is sampled


def _linear(
    study: Study,
    wave: Wave,
    frequency: xr.Dataset | None,
    design: str,
    run: Mapping[str, Any],
    level: ControlLevel | None,
    own: Sample | None,
) -> float | None:
    """Expectation of the power at the port by linear theory with the damper of the run [W], if there is one.

    The control level has it, unless its power is behind losses of the take-off.
    """
    if LINEARISED in run:
        return float(run[LINEARISED])
    if level is not None and level.power_mean is not None and study.pto.efficiency == 1.0:
        return level.power_mean
    if own is not None:
        return own.linear
    return None if frequency is None else linear_mean(study, wave, frequency, design, run)


def _estimate(
    study: Study,
    attrs: Sequence[Mapping[str, Any]],
    level: ControlLevel | None,
    record: float,
    linear: float | None,
    own: Sample | None,
) -> _Estimate:
    """Mean power of a design in a sea from the runs in it, by their attributes, and from linear theory."""
    draws: FloatArray | None = None
    in_time = max(float(run["energy_residual"]) for run in attrs)
    power = record
    if linear is not None and is_linear(study, attrs[0], level):
        power, in_time = linear, 0.0
    elif own is not None:
        power, draws = ratio_estimate(own, linear)
    elif "steady_power" in attrs[0]:
        in_time = max(in_time, relative_difference(record, float(attrs[0]["steady_power"])))
    simplified = max(float(run.get("power_error", 0.0)) for run in attrs)
    coefficients, of_gain = Budget(), Budget()
    if level is not None:
        size = power / level.power_mean if level.power_mean else 0.0
        coefficients = Budget.of(level.power_error).scaled(size) if size > 0 else Budget()
        of_gain = Budget.of(level.gain_error or ())
    return _Estimate(power, coefficients, of_gain, in_time, simplified, record, linear, draws)


def ratio_estimate(own: Sample, linear: float | None = None) -> tuple[float, FloatArray]:
    """Return the mean power of a sea from the records in it, and what each batch leaves of it, (batch,) [W].

    The mean of the records times the expectation of linear theory over linear theory in the same waves.

    Parameters
    ----------
    own : Sample
        All realisations together.
    linear : float, optional
        Expectation by linear theory, by default that of the sample [W].
    """
    expected, alike = own.linear if linear is None else linear, own.linear_record
    if not (expected > 0 and alike > 0):
        return float(own.batches.mean()), own.batches - own.batches.mean()
    scale = expected / alike
    power = scale * float(own.batches.mean())
    return power, scale * own.batches - power * own.linear_batches / float(own.linear_batches.mean())


def _with_gains(study: Study, some: Mapping[str, _Estimate]) -> dict[str, MeanPower]:
    """Mean powers of all designs in a sea with the budgets of power and gain."""
    reference = study.reference_design
    over = gains({design: one.power for design, one in some.items()}, reference)
    found = {}
    for design, one in some.items():
        budget = one.coefficients + Budget(_errors(abs(one.power), one.in_time, one.simplified))
        if one.draws is not None:
            budget += Budget((_sampling(one.power, one.draws, [one.record, one.linear]),))
        gain = over[design]
        if gain is None or reference is None or design == reference:
            found[design] = MeanPower(one.power, budget, gain)
            continue
        base = some[reference]
        ratio = one.power / base.power
        of_gain = one.gain_by_coefficients
        of_gain += Budget(_errors(abs(100 * ratio), one.in_time + base.in_time, one.simplified + base.simplified))
        if one.draws is not None and base.draws is not None:
            left = 100 * (one.draws - ratio * base.draws) / base.power
            others = [_gain(one.record, base.record), _gain(one.linear, base.linear)]
            of_gain += Budget((_sampling(gain, left, others),))
        found[design] = MeanPower(one.power, budget, gain, of_gain)
    return found


def _errors(size: float, in_time: float, simplified: float) -> tuple[Source, ...]:
    """Errors of simulation in time and of what model auto leaves out, of a number of some size."""
    named = ((IN_TIME, in_time), (SIMPLIFIED, simplified))
    return tuple(Source.within(name, size * share) for name, share in named if share)


def _sampling(value: float, draws: FloatArray, others: Sequence[float | None]) -> Source:
    """Sampling error of a number from batches of records.

    Half the 95 % interval by Student's t. Fewer batches than that needs do not tell their scatter: then the range that
    also holds other values, those of the records as they are and of linear theory.
    """
    count = len(draws)
    if count >= FEWEST_BATCHES:
        half = student(count - 1) * float(draws.std(ddof=1)) / float(np.sqrt(count))
        return Source.within(STATISTICS, half, "statistic")
    away = [other - value for other in others if other is not None]
    return Source(STATISTICS, min(0.0, *away), max(0.0, *away), "statistic")


def _gain(power: float | None, base: float | None) -> float | None:
    """A gain [%], if both powers are known and the base is not zero."""
    return 100 * (power / base - 1) if power is not None and base else None
