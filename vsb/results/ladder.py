"""The ladder of a study: what each design takes of each sea under ever better take-offs, up to the matched limit."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial, reduce
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.errors import ConfigError, VsbError
from vsb.hydro.database import Check, check_at_most
from vsb.motion.constrained import optimum_in_sea
from vsb.motion.drag import DraggedPort, best_damper, best_pair, under
from vsb.motion.force_bound import Harmonics, Limits
from vsb.motion.port import Port
from vsb.motion.tuning import Load, best_dampers, best_pairs, mean_power
from vsb.results.budget import Budget, Rows, Source
from vsb.results.left_out import modes_left_out
from vsb.results.rung_errors import Errors, Loaded, rung_errors
from vsb.scenes.drag import dragged_port
from vsb.scenes.floating_system import (
    FloatingSystem,
    PortInSeas,
    band,
    floating_system,
    headings,
    port_in_seas,
    study_sea,
)
from vsb.study.specs import BodyLadderSpec, LadderSpec
from vsb.study.study import IrregularSea, StillWater, Wave
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray
from vsb.tools.tables import csv_text
from vsb.waves.seas import Sea, expected
from vsb.waves.superposition import superposed

RUNGS = ("fixed", "best_damper", "best_damper_all_seas", "best_spring_damper", "constrained", "matched")
"""Each takes no less of a sea than those before it, but a damper for all seas no more than the best one."""
INSTANTS = 8
"""Instants at which peaks are looked for, per shortest period of a sea."""
MOST_HARMONICS = 1024
"""Of the force of an optimum under limits: seconds of work and a tenth of a gigabyte."""
STILL = "waves do not move this port"
GAP = 0.005
"""Of the best force found under limits, as a part of the bound of all forces [-]."""


class Rung(NamedTuple):
    """One take-off of one design in one sea; what a rung does not have is none."""

    design: str
    wave: str
    rung: str
    damping: float | None  # [N s/m]
    stiffness: float | None  # [N/m]
    power_mean: float | None  # [W]; this and the next are none where an optimum under limits is not known
    limit_fraction: float | None  # of the matched power [-]
    force_rms: float | None  # [N]
    force_peak: float | None  # of the realisation [N]
    stroke_peak: float | None  # likewise, from rest [m]
    gap: float | None  # by which a better one is not ruled out, of a constrained optimum [-]
    note: str = ""  # why there is no optimum under limits, or what its limits are kept to
    low: float | None = None  # interval of the mean power by all known sources of error [W]
    high: float | None = None
    power_error: Rows = ()  # error budget of the mean power [W], see `vsb.results.budget.Budget.rows`
    gain_error: Rows | None = None  # of its gain over the reference [percentage points]; none of the reference


COLUMNS = (*Rung._fields[: Rung._fields.index("note")], "low", "high")
"""Of `ladder.csv`."""


class Given(NamedTuple):
    """The take-off of a study: damper (none: tuned), spring, efficiency of both directions of power."""

    damping: float | None
    stiffness: float = 0.0
    efficiency: float = 1.0


class Limited(NamedTuple):
    """Limits of a take-off, and the band its port is known in."""

    limits: Limits
    lowest: float  # [rad/s]
    highest: float


def linear_rungs(port: Port, waves: FloatArray, families: Sequence[int], given: Given) -> dict[str, Load]:
    """Return the rungs of dampers and springs of one design, by name.

    Parameters
    ----------
    port : Port
    waves : ndarray, shape (sea, omega) [m^2]
        Squared amplitudes.
    families : sequence of int
        One sea of each family of realisations: the damper for all seas takes most of their plain sum.
    given : Given
    """
    spring, count = np.full(len(waves), given.stiffness), len(waves)

    def under(damping: float) -> Load:
        dampers = np.full(count, damping)
        return Load(dampers, spring, mean_power(port, waves, dampers, spring, given.efficiency))

    together = waves[list(families)].sum(axis=0, keepdims=True)
    one = under(float(best_dampers(port, together, given.stiffness, given.efficiency).damping[0]))
    best = best_dampers(port, waves, given.stiffness, given.efficiency).elementwise_best(one)
    rungs = {} if given.damping is None else {"fixed": under(given.damping)}
    best = best.elementwise_best(rungs["fixed"]) if rungs else best
    pairs = best_pairs(port, waves, best, given.efficiency)
    return rungs | {"best_damper": best, "best_damper_all_seas": one, "best_spring_damper": pairs}


def dragged_rungs(port: DraggedPort, waves: FloatArray, families: Sequence[int], given: Given) -> dict[str, Load]:
    """Return the rungs of dampers and springs of one design beside quadratic drag; see `linear_rungs`."""
    spring, efficiency = given.stiffness, given.efficiency
    one = under(port, waves, best_damper(port, waves[list(families)], spring, efficiency), spring, efficiency)
    rungs = {} if given.damping is None else {"fixed": under(port, waves, given.damping, spring, efficiency)}
    best, pairs = [], []
    for i, here in enumerate(waves[:, None]):
        known = [Load(*(v[[i]] for v in load)) for load in (one, *rungs.values())]
        found = under(port, here, best_damper(port, here, spring, efficiency), spring, efficiency)
        best.append(reduce(Load.elementwise_best, known, found))
        pairs.append(best_pair(port, here, best[-1], efficiency))
    together = (Load(*map(np.concatenate, zip(*loads, strict=True))) for loads in (best, pairs))
    names = ("best_damper", "best_damper_all_seas", "best_spring_damper")
    return rungs | dict(zip(names, (next(together), one, next(together)), strict=True))


def rungs_of(
    ports: Mapping[str, PortInSeas],
    seas: Mapping[str, Sea],
    families: Sequence[int],
    given: Mapping[str, Given],
    time: float,
    dragged: Mapping[str, DraggedPort] | None = None,
) -> list[Rung]:
    """Return the rungs of every design in every sea.

    Parameters
    ----------
    ports : mapping design -> PortInSeas
        In these seas.
    seas : mapping wave label -> Sea
        Without still water.
    families : sequence of int
        See `linear_rungs`.
    given : mapping design -> Given
    time : float
        How long a realisation is looked at for its peaks [s].
    dragged : mapping design -> DraggedPort, optional
        Where there is drag: dampers and springs are judged beside it, the matched power knows none.
    """
    found: list[Rung] = []
    for design, (port, waves, places) in ports.items():
        matched, beside = waves @ port.matched_power, dragged[design] if dragged else None
        if beside is None:
            loads = linear_rungs(port, waves, families, given[design])
        else:
            loads = dragged_rungs(beside, waves, families, given[design])
        for i, (label, here) in enumerate(seas.items()):
            own = [Load(*(v[[i]] for v in load)) for load in loads.values()]
            braked = [port] * len(own)
            if beside is not None:
                braked = [beside.beside(beside.settled(waves[[i]], c, k)[0, 0]) for c, k, _ in own]
            forces, strokes = _phasors(port, places[i], list(zip(braked, own, strict=True)), here)
            peaks = _peaks(here, np.concatenate([forces, strokes]), time)
            rms = np.sqrt(0.5 * np.sum(np.abs(forces) ** 2, axis=1))
            names = [*loads, "matched"]
            for j, name in enumerate(names):
                load = loads.get(name)
                there = load is not None and port.moves
                damping, stiffness = (float(load[0][i]), float(load[1][i])) if load and there else (None, None)
                power = float(load.power[i] if load else matched[i])
                share = power / float(matched[i]) if matched[i] > 0 else None
                sizes = (float(rms[j]), float(peaks[j]), float(peaks[len(names) + j]))
                found.append(Rung(design, label, name, damping, stiffness, power, share, *sizes, None))
    return found


def study_ladder(study: LadderSpec | BodyLadderSpec, database: str) -> list[Rung]:
    """Return the rungs of every design of a study in every sea, random amplitudes as expected; still water has none.

    Parameters
    ----------
    study : LadderSpec or BodyLadderSpec
    database : str
        Path of its hydro database.
    """
    floating, pto = floating_system(study, database), study.pto
    waves = [wave for wave in study.waves if not isinstance(wave, StillWater)]
    if not waves:
        return []
    ds = floating.linear.database
    seas = {wave.label: study_sea(study, expected(wave), ds) for wave in waves}
    names = [wave.family if isinstance(wave, IrregularSea) else wave.label for wave in waves]
    families = [names.index(name) for name in dict.fromkeys(names)]
    pairs = list(zip(waves, seas.values(), strict=True))
    ports = {design: port_in_seas(floating, design, pairs) for design in study.designs}
    given = {design: Given(pto.damper(design), pto.stiffness, pto.efficiency) for design in study.designs}
    dragged = None
    if isinstance(study, LadderSpec) and study.drag is not None:
        dragged = {design: dragged_port(study, floating, design, headings(pairs)) for design in study.designs}
    rungs = rungs_of(ports, seas, families, given, study.simulation.duration, dragged)
    if pto.limited:
        rungs += constrained_rungs(study, floating, seas)
        designs, labels = list(study.designs), list(seas)
        rungs.sort(key=lambda r: (designs.index(r.design), labels.index(r.wave), RUNGS.index(r.rung)))
    left_out = modes_left_out(study, pairs) if isinstance(study, LadderSpec) else xr.Dataset()
    return with_errors(rungs, floating, pairs, study.reference_design, left_out)


def with_errors(
    rungs: Sequence[Rung],
    floating: FloatingSystem,
    seas: Sequence[tuple[Wave, Sea]],
    reference: str | None,
    left_out: xr.Dataset,
) -> list[Rung]:
    """Return rungs with the error budgets of power and gain; of an unknown power there are none.

    Beside quadratic drag errors are taken as without it: what is damped more feels them less.
    """
    loads: dict[tuple[str, str], list[Loaded]] = {}
    for rung in rungs:
        some = loads.setdefault((rung.design, rung.wave), [])
        if rung.power_mean is not None:
            some.append(Loaded(rung.rung, rung.damping, rung.stiffness, rung.power_mean))
    errors = rung_errors(floating, seas, loads, reference, left_out)
    found = []
    for rung in rungs:
        if rung.power_mean is None:
            found.append(rung)
            continue
        power, gain = errors.get((rung.design, rung.wave, rung.rung), Errors(Budget(), None))
        if rung.gap:
            power += Budget((Source("optimum not proven", 0.0, rung.power_mean * rung.gap / (1 - rung.gap)),))
        low, high = power.interval(rung.power_mean)
        rows = None if gain is None else gain.rows
        found.append(rung._replace(low=low, high=high, power_error=power.rows, gain_error=rows))
    return found


def constrained_rungs(
    study: LadderSpec | BodyLadderSpec, floating: FloatingSystem, seas: Mapping[str, Sea]
) -> list[Rung]:
    """Return the rung within the limits of the take-off of every design in every sea."""
    pto, ds, rungs = study.pto, floating.linear.database, []
    within = Limited(Limits(pto.force_limit, pto.stroke_limit), float(ds.omega[0]), band(study, ds)[1])
    for design, wave in product(study.designs, study.waves):
        if wave.label not in seas:
            continue
        seen = partial(floating.towards(wave).extended_port, motions=floating.motions[design], direction=floating.port)
        rungs.append(constrained_rung(design, wave.label, seas[wave.label], seen, within))
    return rungs


def constrained_rung(design: str, label: str, sea: Sea, seen: Callable[[FloatArray], Port], within: Limited) -> Rung:
    """Return the best force found within limits in a sea and how near it is to the bound of all, or why not.

    Parameters
    ----------
    design, label : str
    sea : Sea
    seen : callable
        Frequencies -> port of the design, also outside the band of the database.
    within : Limited
    """
    named = (design, label, "constrained", None, None)
    try:
        harmonics = Harmonics.of_sea(sea.omega, within.lowest, within.highest)
        if harmonics.count > MOST_HARMONICS:
            raise ConfigError(
                f"a force of {harmonics.count} harmonics has no optimum in reasonable time, needs at most "
                f"{MOST_HARMONICS}; lower simulation.duration or hydro.omega_max"
            )
        port = seen(harmonics.port_omega)
        if not port.moves:
            return Rung(*named, 0.0, None, 0.0, 0.0, 0.0, 0.0, STILL)
        best = optimum_in_sea(port, sea, harmonics, within.limits)
    except VsbError as error:
        return Rung(*named, None, None, None, None, None, None, str(error))
    at = np.rint(sea.omega / harmonics.spacing - harmonics.first).astype(int)
    matched = sea.mean_of(port.matched_power[at])
    proven = f"no force within the limits, of any harmonics, absorbs more than {best.bound:.4g} W"
    note = f"{best.power:.4g} W found; {proven}"
    if best.excess:
        note += f"; between the instants limits are exceeded by up to {100 * best.excess:.2g} %"
    return Rung(*named, best.power, best.power / matched, *best[4:7], best.gap, note)


def constrained_checks(rungs: Sequence[Rung]) -> list[Check]:
    """Return how far each optimum under limits is from its proof; in doubt where there is none."""
    checks = []
    for rung in (rung for rung in rungs if rung.rung == "constrained"):
        where = {"design": rung.design, "wave": rung.wave}
        if rung.gap is None:
            checks.append(Check("constrained", 1.0, GAP, "-", "doubt", f"no optimum: {rung.note}", **where))
        else:
            text = f"distance of the best force found from the bound of every force within the limits: {rung.note}"
            checks.append(check_at_most("constrained", rung.gap, GAP, "-", text, doubt=True, **where))
    return checks


def _phasors(
    port: Port, at: IntArray, loads: Sequence[tuple[Port, Load]], sea: Sea
) -> tuple[ComplexArray, ComplexArray]:
    """Forces and displacements under loads at their ports and under the matched force, (load, component) [N], [m]."""
    impedance = [seen.load(*load[:2]) for seen, load in loads]
    velocity = [seen.velocity_under(z) for (seen, _), z in zip(loads, impedance, strict=True)]
    forces = np.concatenate([*(z * v for z, v in zip(impedance, velocity, strict=True)), port.matched_force[None]])
    velocities = np.concatenate([*velocity, (port.velocity - port.admittance * port.matched_force)[None]])
    return forces[:, at] * sea.amplitude, (velocities / (-1j * port.omega))[:, at] * sea.amplitude


def _peaks(sea: Sea, phasors: ComplexArray, time: float) -> FloatArray:
    """Largest values of signals over a realisation, shape (signal,); of a regular wave its amplitude."""
    if len(sea.omega) < 2:
        return np.asarray(np.abs(phasors).sum(axis=1))
    count = int(np.ceil(INSTANTS * sea.omega.max() * time / (2 * np.pi))) + 1
    signals = superposed(sea.omega, phasors.T, np.linspace(0.0, time, count))
    return np.asarray(np.abs(signals).max(axis=0))


def as_csv(rungs: Sequence[Rung]) -> str:
    """Return the ladder as CSV; an empty cell is a quantity that does not exist, as of a port that cannot move."""
    return csv_text(COLUMNS, ([getattr(rung, name) for name in COLUMNS] for rung in rungs), 12)
