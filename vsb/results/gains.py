"""Gains over the rigid design: at equal tuning, within limits, in runs; each with the interval of all known errors."""

import contextlib
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import Check, Verdict
from vsb.engine.motion.causal import Controlled, RmsLimits, StationaryPort, optimum
from vsb.engine.motion.controller import achieved
from vsb.engine.motion.take_off import DAMPERS, Pto, port_kind
from vsb.engine.motion.tuning import damper_within_force, mean_power
from vsb.engine.waves.kinds import Irregular, PeakedSea, Wave
from vsb.errors import VsbError
from vsb.models.floating_system import FloatingSystem, expected_sea, port_in_seas
from vsb.models.stationary import rms_limits, stationary_ports
from vsb.models.take_off import LINEARISED
from vsb.results.budget import Budget, Rows, Source, mean_budget
from vsb.results.comparison import Attributes, gains
from vsb.results.ladder import CAUSAL, SAME_FORCE, ControlLevel
from vsb.results.mean_power import LEVELS, STATISTICS, MeanPower, MeanPowers, is_linear
from vsb.study.study import Study
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.words import plain, superscripts

LOST = 0.05
"""Part of its best damper's power that a design may lose before a comparison at the given damper is in doubt."""
NEXT_TO_NOTHING = 1e3
"""Matched power over the rigid design's own best, above which gains over that design mean nothing."""
LINEARISATION = "linearisation"


class Beyond(NamedTuple):
    """What linear theory leaves out of a mean power, relative to it [-], and of its gain [percentage points]."""

    power: Budget = Budget()
    gain: Budget = Budget()


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
    best_power_low: float | None = None  # interval of the power at its own best damper [W]
    best_power_high: float | None = None
    power_low: float | None = None  # likewise at the given damper
    power_high: float | None = None


class Limited(NamedTuple):
    """What no take-off within the limits of force and stroke can exceed, all realisations of a sea together."""

    design: str
    sea: str
    power: float  # [W]
    gain_percent: float | None
    low: float | None = None  # interval of the gain by all known sources of error [%]
    high: float | None = None
    power_low: float | None = None  # likewise of the power [W]
    power_high: float | None = None


class AtForce(NamedTuple):
    """A design in an irregular sea with a given rms force, realisations together: causal control and a damper.

    Gains are over the first rigid design's power, None without one.
    """

    design: str
    sea: str
    force_rms: float | None  # [N]; None of several ports whose forces have no unit in common
    noise: float  # see `vsb.engine.motion.take_off.Control` [-]
    forecast: float  # [s]
    power: float  # under causal control [W]
    gain_percent: float | None
    low: float | None  # interval of the gain by all known sources of error [%]
    high: float | None
    damper_power: float  # of the best damper of the same rms force [W]
    damper_gain_percent: float | None
    damper: float | None  # the controller is that damper [N s/m]; None: it is not


def equal_tuning(
    study: Study, levels: Sequence[ControlLevel], means: MeanPowers | None = None, runs: Attributes | None = None
) -> list[Tuned]:
    """Return one line per sea and design, from the control levels of a study, and from its runs where they differ.

    At the damper of the runs powers and gains are those of the runs. At another one they are of linear theory, their
    intervals wider by what that leaves out at the damper of the runs (`linearisation`). Under a law that is no damper
    nothing is stated at the given one: its power is that of the comparison.

    Parameters
    ----------
    means : mapping, optional
        See `vsb.results.mean_power.mean_powers`.
    runs : mapping, optional
        Attributes of the runs.
    """
    beyond = linearisation(study, means, runs, levels) if means and runs else {}
    in_time = _levels_in_time(study, means, runs) if means and runs else {}
    found: list[Tuned] = []
    for sea, here in _by_sea(study, levels).items():
        best, fixed = (_at_level(study, here, sea, level, beyond, in_time) for level in ("best_damper", "fixed"))
        for design, (damper, at_best) in best.items():
            given, at_given = fixed.get(design, (None, None)) if study.pto.law in DAMPERS else (None, None)
            power, gain = (None, None) if at_given is None else (at_given.power, at_given.gain)
            share = power / at_best.power if power is not None and at_best.power > 0 else None
            line = (design, sea, damper, at_best.power, at_best.gain, given, power, gain, share)
            of_gain, of_given_gain = (_ends(one, "gain") for one in (at_best, at_given))
            of_power, of_given_power = (_ends(one, "power") for one in (at_best, at_given))
            errors = at_best.gain_errors.rows
            found.append(Tuned(*line, *of_gain, *of_given_gain, errors, *of_power, *of_given_power))
    return found


def _at_level(
    study: Study,
    levels: Sequence[ControlLevel],
    sea: str,
    level: str,
    beyond: Mapping[tuple[str, str], Beyond],
    in_time: Mapping[tuple[str, str, str], MeanPower],
) -> dict[str, tuple[float | None, MeanPower]]:
    """Damper and mean power of every design at a level in a sea, of all realisations."""
    means = _means(levels, level)
    if not means:
        return {}
    over = gains({design: power for design, (_, power) in means.items()}, study.reference_design)
    found = {}
    for design, (damper, power) in means.items():
        if (mean := in_time.get((level, design, sea))) is None:
            more = beyond.get((design, sea), Beyond())
            own = power_budget(levels, design, level)
            of_gain = gain_budget(levels, design, level) + more.gain
            mean = MeanPower(power, own + more.power.scaled(power) if power > 0 else own, over[design], of_gain)
        found[design] = (damper, mean)
    return found


def _ends(mean: MeanPower | None, of: Literal["gain", "power"]) -> tuple[float | None, float | None]:
    """Interval of gain or power, if it is known."""
    if mean is None:
        return None, None
    return _interval(mean.gain, mean.gain_errors) if of == "gain" else mean.errors.interval(mean.power)


def _levels_in_time(study: Study, means: MeanPowers, runs: Attributes) -> dict[tuple[str, str, str], MeanPower]:
    """Mean powers of runs that are not linear, by the level with their damper, design and sea; of dampers alone."""
    if study.pto.law not in DAMPERS:
        return {}
    seas = {wave.label: wave for wave in study.waves}
    found = {}
    for (design, label), mean in means.items():
        if not is_linear(study, runs[design, label]):
            found[LEVELS[study.tuning(seas[label])], design, seas[label].family] = mean
    return found


def within_limits(study: Study, levels: Sequence[ControlLevel]) -> list[Limited]:
    """Return one line per sea and design whose optimum within limits is known in all realisations."""
    found = []
    for sea, here in _by_sea(study, levels).items():
        unknown = {one.design for one in here if one.rung == "constrained" and one.power_mean is None}
        powers = {d: p for d, (_, p) in _means(here, "constrained").items() if d not in unknown}
        over = gains(powers, study.reference_design if study.reference_design in powers else None)
        for design, power in powers.items():
            ends = _interval(over[design], gain_budget(here, design, "constrained"))
            of_power = power_budget(here, design, "constrained").interval(power)
            found.append(Limited(design, sea, power, over[design], *ends, *of_power))
    return found


def at_force(study: Study, levels: Sequence[ControlLevel]) -> list[AtForce]:
    """Return one line per irregular sea and design with causal control, and the damper of its rms force."""
    found = []
    for sea, here in _by_sea(study, levels).items():
        known = {one.design: one for one in here if one.rung == CAUSAL and one.power_mean is not None}
        causal, dampers = (_means([one for one in here if one.design in known], name) for name in (CAUSAL, SAME_FORCE))
        reference = study.reference_design if study.reference_design in known else None
        over, beside = (gains({d: p for d, (_, p) in some.items()}, reference) for some in (causal, dampers))
        for design, level in known.items():
            low, high = _interval(over[design], gain_budget(here, design, CAUSAL))
            knows = (level.force_rms, level.noise or 0.0, level.forecast or 0.0)
            power, damper = causal[design][1], dampers[design][1]
            line = AtForce(design, sea, *knows, power, over[design], low, high, damper, beside[design], level.damping)
            found.append(line)
    return found


def gain_budget(levels: Sequence[ControlLevel], design: str, level: str) -> Budget:
    """Return the error budget of the gain of a design at a level, realisations together; the reference has none."""
    rows = [one.gain_error for one in levels if one.rung == level and one.design == design]
    return mean_budget([Budget.of(each) for each in rows if each is not None])


def power_budget(levels: Sequence[ControlLevel], design: str, level: str) -> Budget:
    """Return the error budget of the power of a design at a level, realisations together."""
    return mean_budget([Budget.of(one.power_error) for one in levels if (one.design, one.rung) == (design, level)])


def _interval(gain: float | None, errors: Budget) -> tuple[float | None, float | None]:
    """The interval of a gain, if there is one."""
    return (None, None) if gain is None else errors.interval(gain)


def _by_sea(study: Study, levels: Sequence[ControlLevel]) -> dict[str, list[ControlLevel]]:
    """Levels by the name of their sea, one for all realisations."""
    seas = {wave.label: wave.family for wave in study.waves}
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
    if pto.law not in DAMPERS:
        return []
    checks, unit = [], superscripts(port_kind(pto.port).damping_unit)
    for line in lines:
        if line.share is None or line.power is None or line.damping is None or line.best_damping is None:
            continue
        text = f"power lost against the optimal damper: {plain(line.power)} W at {plain(line.damping)} {unit}, "
        text += f"{plain(line.best_power)} W at {plain(line.best_damping)} {unit}, by linear theory"
        lost = max(0.0, 1 - line.share)
        verdict: Verdict = "doubt" if lost > LOST else "ok"  # never a failure: it answers another question
        checks.append(Check("fair_damping", lost, LOST, "-", verdict, text, line.design, line.sea))
    return checks


def reference_power_checks(study: Study, levels: Sequence[ControlLevel]) -> list[Check]:
    """Return the matched over the best-damper power of the rigid design: a gain over next to nothing means nothing."""
    reference, checks = study.reference_design or "", []
    for sea, here in _by_sea(study, levels).items():
        matched, best = (_means(here, name).get(reference, (None, 0.0))[1] for name in ("matched", "best_damper"))
        if best > 0 and matched > 0:
            ratio = matched / best
            verdict: Verdict = "doubt" if ratio > NEXT_TO_NOTHING else "ok"
            text = f"power {reference} could absorb at most, {plain(matched)} W, over that at its optimal damping, "
            text += f"{plain(best)} W; above the limit a gain over so small a power has no meaning"
            checks.append(Check("reference_power", ratio, NEXT_TO_NOTHING, "-", verdict, text, wave=sea))
    return checks


# in runs ------------------------------------------------------------------------------------------------------------


def linearisation(
    study: Study, means: MeanPowers, runs: Attributes, levels: Sequence[ControlLevel]
) -> dict[tuple[str, str], Beyond]:
    """Return how far powers and gains by linear theory are from those of runs, by design and sea.

    The difference at the damper of the runs, with their sampling error. Nothing where all models are linear, or where
    the take-off is not.
    """
    reference, found = study.reference_design, {}
    if study.pto.nonlinear:
        return {}
    for wave in study.waves:
        label = wave.label
        some = {design: means[design, label] for design in study.designs if (design, label) in means}
        if not some or all(is_linear(study, runs[design, label]) for design in some):
            continue
        rung = LEVELS[study.tuning(wave)]
        linear = {
            one.design: float(runs[one.design, label].get(LINEARISED, one.power_mean or 0.0))
            for one in levels
            if (one.wave, one.rung) == (label, rung)
        }
        over = gains(linear, reference if reference in linear else None)
        for design, mean in some.items():
            of_power, of_gain = Budget(), Budget()
            if (expected := linear.get(design, 0.0)) > 0:
                away = Budget((Source.towards(LINEARISATION, mean.power / expected - 1),))
                of_power = away + _sampled(mean.errors.scaled(1 / expected))
            there = over.get(design)
            if design != reference and there is not None and mean.gain is not None:
                away = Budget((Source.towards(LINEARISATION, mean.gain - there),))
                of_gain = away + _sampled(mean.gain_errors)
            found[design, wave.family] = Beyond(of_power, of_gain)
    return found


def _sampled(errors: Budget) -> Budget:
    """The sampling error alone."""
    return Budget(tuple(source for source in errors.sources if source.name == STATISTICS))


# what knowledge is worth to a controller: seconds of forecast, less noise, the sea it is tuned in -------------------

FORECASTS = (0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0)
"""Forecasts over the period of the sea's peak [-]."""
NOISES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Densities of the noise over the peak of that of the waves' force [-]."""


PERIODS = (0.7, 0.85, 1.0, 1.2, 1.5)
"""Peak periods of the seas a controller is run in, over that of the sea it is tuned in [-]."""
LEFT_OUT = 0.05
"""Part of a sea beyond the frequencies of the coefficients with which a controller is not run in it."""


class Elsewhere(NamedTuple):
    """A causal controller in a sea that it is not tuned in, and one that is tuned in it."""

    design: str
    sea: str  # it is tuned in
    period: float  # of the peak of the sea it is run in [s]
    power: float  # [W]
    force_rms: float  # [N]
    own_power: float  # of the one tuned there [W]
    own_force_rms: float  # [N]


def elsewhere(study: Study, floating: FloatingSystem, waves: Sequence[Wave]) -> list[Elsewhere]:
    """Return what causal controllers absorb by linear theory in seas of the same height and other peak periods.

    Each keeps the rms force of the level `causal` in its own sea, and has no forecast. It stays stable: its loop is
    that of the same port. Seas without a peak period of their own, as records, have no lines.
    """
    pto, noise, found = study.pto, study.pto.control.noise, []
    for wave in waves:
        if not isinstance(wave, PeakedSea):
            continue
        seas = [wave.model_copy(update={"tp": factor * wave.tp}) for factor in PERIODS]
        seas = [one for one in seas if one.share_above(floating.band[1]) < LEFT_OUT]
        tuned: dict[tuple[str, float], tuple[StationaryPort, ComplexArray, Controlled]] = {}
        for one in seas:
            sea = expected_sea(study, one, floating.linear.database)
            for design, port in stationary_ports(floating, one, sea).items():
                with contextlib.suppress(VsbError):  # no control keeps the stroke
                    seen, squares, _ = port_in_seas(floating, design, [(one, sea)])
                    limits = rms_limits(pto, seen, squares[0])
                    best = optimum(port, limits, noise, 0.0, pto.efficiency)
                    if best.power > 0:
                        tuned[design, one.tp] = port, port.controller(best.weights, noise), best
        for (design, period), (port, own, best) in tuned.items():
            if (design, wave.tp) not in tuned:
                continue
            home, gain, _ = tuned[design, wave.tp]
            there = achieved(port, np.interp(port.omega, home.omega, gain), noise)
            power, force = np.divide(there, achieved(port, own, noise))  # what their grids leave out is alike
            reached = float(power) * best.power, float(force) * best.force_rms, best.power, best.force_rms
            found.append(Elsewhere(design, wave.family, period, *reached))
    return found


class _Control(NamedTuple):
    """A port in a sea, the rms values it is controlled within, and what of the sea could be absorbed."""

    port: StationaryPort
    limits: RmsLimits
    pto: Pto
    matched: float  # [W]

    def power(self, noise: float, forecast: float) -> float:
        """Mean power of the controller [W]."""
        best = optimum(self.port, self.limits, noise, forecast, self.pto.efficiency)
        return self.matched * best.converted(self.pto.efficiency) / self.port.matched_power


def worth_of_knowledge(study: Study, floating: FloatingSystem, wave: Irregular) -> xr.Dataset:
    """Return mean powers in a sea under causal control, at the rms force of the control level `causal`.

    Returns
    -------
    xarray.Dataset
        `over_forecast(design, forecast)` with the noise of the study, forecasts in s, `over_noise(design, noise)` with
        its forecast, `known_future(design)` and `damper(design)`, the best damper of the same rms force [W].
    """
    pto, sea = study.pto, expected_sea(study, wave, floating.linear.database)
    ports, forecasts = stationary_ports(floating, wave, sea), np.array(FORECASTS) * 2 * np.pi / wave.omega
    found: dict[str, list[FloatArray]] = {"over_forecast": [], "over_noise": [], "known_future": [], "damper": []}
    designs = []
    for design, port in ports.items():
        seen, squares, _ = port_in_seas(floating, design, [(wave, sea)])
        if not seen.moves:
            continue
        limits = rms_limits(pto, seen, squares[0])
        damper = damper_within_force(seen, squares, limits.force, pto.stiffness, pto.efficiency)
        absorbed = float(mean_power(seen, squares, damper.damping, damper.stiffness, pto.efficiency)[0])
        control = _Control(port, limits, pto, float(squares[0] @ seen.matched_power))
        found["over_forecast"].append(np.array([control.power(pto.control.noise, t) for t in forecasts]))
        found["over_noise"].append(np.array([control.power(noise, pto.control.forecast) for noise in NOISES]))
        found["known_future"].append(np.array(control.power(0.0, np.inf)))
        found["damper"].append(np.array(absorbed))
        designs.append(design)
    over = {"over_forecast": ("forecast", forecasts), "over_noise": ("noise", np.array(NOISES))}
    data = {}
    for name, values in found.items():
        dim, at = over.get(name, ("", np.zeros(0)))
        shape = (len(designs), len(at)) if dim else (len(designs),)  # none where waves move no design's port
        data[name] = (("design", dim)[: len(shape)], np.array(values, dtype=float).reshape(shape))
    return xr.Dataset(data, {"design": np.array(designs, dtype=str), **dict(over.values())})
