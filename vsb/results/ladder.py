"""The control levels of a study: mean power of each design in each sea, from the given damper to the matched limit.

Every level comes with the budget of its known errors: what errors of the hydrodynamic coefficients and shell modes left
out change of its mean power, and of its gain over the reference design.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial, reduce
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import Check, check_at_most
from vsb.engine.motion.causal import GridError, RmsLimits, Stationary, numerical_error, optimum
from vsb.engine.motion.coefficient_errors import (
    CoefficientError,
    Sensitivity,
    coefficient_errors,
    sensitivity,
)
from vsb.engine.motion.constrained import optimum_in_sea
from vsb.engine.motion.drag import DraggedPort, best_damper, best_pair, with_load
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.port import Port
from vsb.engine.motion.take_off import Control, Pto, named_ports
from vsb.engine.motion.tuning import (
    Load,
    best_dampers,
    best_matrix,
    best_pairs,
    damper_within_force,
    frequencies,
    matrix_text,
    mean_power,
    priced_matrix,
    squares,
)
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import Sea, superposed
from vsb.errors import ConfigError, VsbError
from vsb.models.floating_system import (
    AtFrequencies,
    FloatingSystem,
    PortInSeas,
    band,
    expected_sea,
    floating_system,
    heading,
    heading_in,
    headings,
    port_in_seas,
    study_sea,
)
from vsb.models.mode_convergence import one_of_each_family
from vsb.models.stationary import (
    force_units,
    forces_alike,
    optimum_with_drag,
    rms_force,
    stationary_ports,
)
from vsb.models.take_off import dragged_port, given_matrix, matrix_kind
from vsb.results.budget import MODES, NUMERICAL, Budget, Rows, Source, modes_left_out
from vsb.study.study import Study
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.words import csv_text

CONSTRAINED = "constrained"
CAUSAL = "causal"
SAME_FORCE = "damper_same_force"
"""The best damper whose force has at most the rms of that of the level `causal`."""
NEAR_LIMITS = (SAME_FORCE, CAUSAL, CONSTRAINED)
"""Levels whose force is limited: they have the errors of the optimal damper and of the matched force."""
BEST_DIAGONAL = "best_diagonal"
"""Of several ports whose damper matrix may be full: the best damper at each port alone."""
MATERIAL = "material"
"""What the energy per cycle of the shell's material would allow, beside what the take-off finds in the waves."""
CONTROL_LEVELS = (
    "fixed", BEST_DIAGONAL, "best_damper", "best_damper_all_seas", "best_spring_damper", SAME_FORCE, CAUSAL,
    CONSTRAINED, "matched", MATERIAL,
)  # fmt: skip
"""Power does not decrease along the levels of the waves, to `matched`, but that of one damper for all seas is at most
that of the best one, and levels with a limit of force, of its rms to `causal`, of its peaks in `constrained`, are only
comparable with each other."""
INSTANTS = 8
"""Instants at which peaks are looked for, per shortest period of a sea."""
MOST_HARMONICS = 1024
"""Of the force of an optimum within limits: seconds of work and a tenth of a gigabyte."""
NAMED = 6
"""Ports up to which the damper matrix is reported."""
STILL = "waves do not move this port"
DAMPER_BETTER = "a damper absorbs no less than the controller with this noise"
SPREAD_DRAG = "beside quadratic drag causal control is known in seas of one direction alone"
FORCE_WITH_DRAG = "beside quadratic drag the rms force is that of the optimal damper; remove pto.control.force_rms"
GAP = 0.005
"""Of the best force found within limits, as a part of the bound of all forces [-]."""


class ControlLevel(NamedTuple):
    """One control level of one design in one sea; what a level does not have is None."""

    design: str
    wave: str
    rung: str  # the level, as the column of `ladder.csv` is named
    damping: float | None  # [N s/m]
    stiffness: float | None  # [N/m]
    power_mean: float | None  # [W]; this and the next are None where an optimum within limits is not known
    limit_fraction: float | None  # of the matched power [-]
    force_rms: float | None  # [N]
    force_peak: float | None  # of the realisation [N]
    stroke_peak: float | None  # likewise, from rest [m]
    gap: float | None  # by which a better one is not ruled out, of a constrained optimum [-]
    note: str = ""  # why there is no optimum within limits, or how far it is proved
    low: float | None = None  # interval of the mean power by all known sources of error [W]
    high: float | None = None
    power_error: Rows = ()  # error budget of the mean power [W], see `vsb.results.budget.Budget.rows`
    gain_error: Rows | None = None  # of its gain over the reference [percentage points]; None of the reference
    noise: float | None = None  # of what a causal controller measures, see `vsb.engine.motion.take_off.Control` [-]
    forecast: float | None = None  # how far ahead it knows the waves [s]
    numerical: GridError = GridError()  # by the grid of a causal controller


COLUMNS = (*ControlLevel._fields[: ControlLevel._fields.index("note")], "low", "high", "noise", "forecast")
"""Of `ladder.csv`."""


Matrices = dict[tuple[str, str, str], FloatArray]
"""Damper matrices by design, sea and level."""


class Given(NamedTuple):
    """The take-off of a study: damper (None: tuned), spring, efficiency of both directions of power."""

    damping: float | None
    stiffness: float = 0.0
    efficiency: float = 1.0


def study_ladder(study: Study, database: str) -> list[ControlLevel]:
    """Return the levels of every design of a study in every sea; still water has none.

    Powers are expectations over the spectrum, peaks those of a realisation as long as a run, with expected amplitudes,
    in which the optimum within limits is looked for, too.

    Parameters
    ----------
    database : str
        Path of its hydro database.
    """
    floating, pto = floating_system(study, database), study.pto
    waves = [wave for wave in study.waves if not wave.still]
    if not waves:
        return []
    ds = floating.linear.database
    records = {wave.label: study_sea(study, wave.expected, ds) for wave in waves}
    seas = {wave.label: expected_sea(study, wave, ds) for wave in waves}
    families = one_of_each_family(waves)
    pairs = list(zip(waves, seas.values(), strict=True))
    left_out = modes_left_out(study, pairs, families, wet=floating.clamps is not None)
    matrices: Matrices | None = None
    if pto.several:
        levels, matrices = matrix_levels(study, floating, seas, families)
        if named_ports(pto):
            levels += causal_levels_of_several(pto, floating, pairs, matrices, levels)
    else:
        both = [*pairs, *zip(waves, records.values(), strict=True)]
        ports = {design: port_in_seas(floating, design, both) for design in study.designs}
        given = {design: Given(pto.damper(design), pto.stiffness, pto.efficiency) for design in study.designs}
        dragged = None
        if study.plates:
            going = headings(both)
            dragged = {design: dragged_port(study, floating, design, going) for design in study.designs}
        levels = levels_of(ports, records, families, given, study.simulation.duration, dragged)
        if pto.limited:
            matched = {(level.design, level.wave): level.power_mean for level in levels if level.rung == "matched"}
            levels += [in_sea(level, matched[level[:2]]) for level in constrained_levels(study, floating, records)]
        if dragged is None:
            levels += causal_levels(study, floating, pairs, ports, levels)
        else:
            levels += causal_levels_with_drag(study, floating, pairs, levels)
    order = partial(_order, list(study.designs), list(seas))
    levels = with_errors(sorted(levels, key=order), floating, pairs, study.reference_design, left_out, matrices)
    return sorted([*levels, *material_levels(study, floating, seas, levels)], key=order)


def _order(designs: Sequence[str], waves: Sequence[str], level: ControlLevel) -> tuple[int, int, int]:
    """Place of a level in a table."""
    return designs.index(level.design), waves.index(level.wave), CONTROL_LEVELS.index(level.rung)


# dampers, springs and the matched force -----------------------------------------------------------------------------


def linear_levels(port: Port, waves: FloatArray, families: Sequence[int], given: Given) -> dict[str, Load]:
    """Return dampers and springs of one design by control level.

    Parameters
    ----------
    waves : ndarray, shape (sea, omega) [m^2]
        Squared amplitudes.
    families : sequence of int
        One sea of each family of realisations: the damper for all seas maximises their plain sum.
    """
    spring, count = np.full(len(waves), given.stiffness), len(waves)

    def with_damper(damping: float) -> Load:
        dampers = np.full(count, damping)
        return Load(dampers, spring, mean_power(port, waves, dampers, spring, given.efficiency))

    together = waves[list(families)].sum(axis=0, keepdims=True)
    one = with_damper(float(best_dampers(port, together, given.stiffness, given.efficiency).damping[0]))
    best = best_dampers(port, waves, given.stiffness, given.efficiency).elementwise_best(one)
    levels = {} if given.damping is None else {"fixed": with_damper(given.damping)}
    best = best.elementwise_best(levels["fixed"]) if levels else best
    pairs = best_pairs(port, waves, best, given.efficiency)
    return levels | {"best_damper": best, "best_damper_all_seas": one, "best_spring_damper": pairs}


def dragged_levels(port: DraggedPort, waves: FloatArray, families: Sequence[int], given: Given) -> dict[str, Load]:
    """Return the same with quadratic drag, whose equivalent damper depends on the sea; see `linear_levels`."""
    spring, efficiency = given.stiffness, given.efficiency
    one = with_load(port, waves, best_damper(port, waves[list(families)], spring, efficiency), spring, efficiency)
    levels = {} if given.damping is None else {"fixed": with_load(port, waves, given.damping, spring, efficiency)}
    best, pairs = [], []
    for i, here in enumerate(waves[:, None]):
        known = [Load(*(v[[i]] for v in load)) for load in (one, *levels.values())]
        found = with_load(port, here, best_damper(port, here, spring, efficiency), spring, efficiency)
        best.append(reduce(Load.elementwise_best, known, found))
        pairs.append(best_pair(port, here, best[-1], efficiency))
    best_of_each, best_pairs_of_each = (Load(*map(np.concatenate, zip(*some, strict=True))) for some in (best, pairs))
    return levels | {
        "best_damper": best_of_each,
        "best_damper_all_seas": one,
        "best_spring_damper": best_pairs_of_each,
    }


def levels_of(
    ports: Mapping[str, PortInSeas],
    seas: Mapping[str, Sea],
    families: Sequence[int],
    given: Mapping[str, Given],
    time: float,
    dragged: Mapping[str, DraggedPort] | None = None,
) -> list[ControlLevel]:
    """Return the levels of every design in every sea, all but that within limits.

    Parameters
    ----------
    ports : mapping design -> PortInSeas
        In these seas; where they are realisations, first in those that powers are of.
    seas : mapping wave label -> Sea
        That peaks are of, without still water.
    families : sequence of int
        See `linear_levels`.
    given : mapping design -> Given
    time : float
        Length of the realisations whose peaks are reported [s].
    dragged : mapping design -> DraggedPort, optional
        Where there is drag; the matched power is without it.
    """
    found: list[ControlLevel] = []
    for design, (port, squares_of_all, places_of_all) in ports.items():
        waves, places = squares_of_all[: len(seas)], places_of_all[-len(seas) :]
        matched, drag = waves @ port.matched_power, dragged[design] if dragged else None
        if drag is None:
            loads = linear_levels(port, waves, families, given[design])
        else:
            loads = dragged_levels(drag, waves, families, given[design])
        for i, (label, sea) in enumerate(seas.items()):
            forces: list[ComplexArray] = []
            strokes: list[ComplexArray] = []
            for damping, stiffness, _ in loads.values():
                own = damping[[i]], stiffness[[i]]
                seen = port if drag is None else drag.beside(drag.equivalent(waves[[i]], *own)[0, 0])
                impedance = seen.load(*own)
                velocity = seen.velocity_under(impedance)
                forces.append(np.asarray(impedance * velocity))
                strokes.append(velocity / (-1j * port.omega))
            forces.append(port.matched_force[None])
            strokes.append((port.velocity - port.admittance * port.matched_force)[None] / (-1j * port.omega))
            rms = np.sqrt(0.5 * np.abs(np.concatenate(forces)) ** 2 @ waves[i])
            force, stroke = (np.concatenate(each)[:, places[i]] * sea.amplitude for each in (forces, strokes))
            peaks = _peaks(sea, force, stroke, time)
            for j, name in enumerate([*loads, "matched"]):
                load = loads.get(name)
                power = float(load.power[i] if load else matched[i])
                share = power / float(matched[i]) if matched[i] > 0 else None
                c, k = (float(load.damping[i]), float(load.stiffness[i])) if load and port.moves else (None, None)
                sizes = (float(rms[j]), float(peaks[0, j]), float(peaks[1, j]))
                found.append(ControlLevel(design, label, name, c, k, power, share, *sizes, None))
    return found


def matrix_levels(
    study: Study, floating: FloatingSystem, seas: Mapping[str, Sea], families: Sequence[int]
) -> tuple[list[ControlLevel], Matrices]:
    """Return the levels of damper matrices, and the matched one, of every design in every sea; and those matrices.

    At several ports, or spread over the shell. `best_damper` and `best_damper_all_seas` are of the matrices the study
    allows, which stand in the notes. Peaks are not known, which several ports do not have in common.
    """
    omega, kind = frequencies(list(seas.values())), matrix_kind(study.pto)
    rows, found, matrices = squares(list(seas.values()), omega), list[ControlLevel](), Matrices()
    for design, ports in floating.several_ports(omega).items():
        given = given_matrix(study.pto, design, floating.port.shape[1])
        one = best_matrix(ports, rows[list(families)].sum(axis=0), kind).damping
        for label, sea in zip(seas, rows, strict=True):
            own = {} if given is None else {"fixed": given}
            if kind == "full":
                own[BEST_DIAGONAL] = best_matrix(ports, sea, "diagonal").damping
            own |= {"best_damper": best_matrix(ports, sea, kind).damping, "best_damper_all_seas": one}
            matrices |= {(design, label, name): matrix for name, matrix in own.items()}
            matched = float(sea @ ports.matched_power)
            for name, matrix in own.items():
                power, damper, note = float(sea @ ports.power(matrix)), None, ""
                if ports.moves and len(matrix) <= NAMED:
                    note = f"damper matrix {matrix_text(matrix, 6)}"
                elif ports.moves:
                    damper = float(matrix[0, 0])  # spread over the shell
                share = power / matched if matched > 0 else None
                found.append(
                    ControlLevel(design, label, name, damper, None, power, share, None, None, None, None, note)
                )
            share = 1.0 if matched > 0 else None
            found.append(ControlLevel(design, label, "matched", None, None, matched, share, None, None, None, None))
    return found, matrices


def material_levels(
    study: Study, floating: FloatingSystem, seas: Mapping[str, Sea], levels: Sequence[ControlLevel]
) -> list[ControlLevel]:
    """Return the mean power that the material of the shell would allow at ports of strain, by design and sea.

    Of `pto.energy_per_cycle` e [J/kg], the mass m of the shell and the mean frequency f of the strain's cycles under
    the optimal damper, e m f: all of the material, fully used in every cycle.
    """
    if study.pto.energy_per_cycle is None:
        return []
    omega, found, mass = frequencies(list(seas.values())), [], study.device.shell_mass
    rows = dict(zip(seas, squares(list(seas.values()), omega), strict=True))
    linear = floating.linear.equation(omega)
    by = {(level.design, level.wave, level.rung): level for level in levels}
    for design, motions in floating.motions.items():
        ports = linear.ports(motions, floating.port.reshape(len(motions), -1))
        for label, sea in rows.items():
            best, matched = by[design, label, "best_damper"], by[design, label, "matched"].power_mean
            if not best.power_mean:
                continue
            matrix = best_matrix(ports, sea, matrix_kind(study.pto) if study.pto.several else "full").damping
            absorbed = sea * ports.power(matrix)
            frequency = float(np.sqrt(absorbed.sum() / (absorbed / omega**2).sum())) / (2 * np.pi)
            allowed = study.pto.energy_per_cycle * mass * frequency
            share = allowed / matched if matched else None
            note = f"cycles of {1 / frequency:.4g} s, {mass:.6g} kg of shell"
            found.append(
                ControlLevel(design, label, MATERIAL, None, None, allowed, share, None, None, None, None, note)
            )
    return found


def material_checks(pto: Pto, levels: Sequence[ControlLevel]) -> list[Check]:
    """Return the energy that the optimal damper takes from a kilogram of shell in a cycle, against the material's."""
    by = {(level.design, level.wave, level.rung): level for level in levels}
    checks, limit = [], pto.energy_per_cycle or 0.0
    for level in (level for level in levels if level.rung == MATERIAL):
        power, allowed = by[level.design, level.wave, "best_damper"].power_mean or 0.0, level.power_mean or 1.0
        text = f"energy per cycle that the optimal damper takes from the shell at {power:.4g} W, where its material "
        text += f"would allow {allowed:.4g} W ({level.note})"
        where, taken = {"design": level.design, "wave": level.wave}, limit * power / allowed
        checks.append(check_at_most("specific_energy", taken, limit, "J/kg", text, doubt=True, **where))
    return checks


def _peaks(sea: Sea, force: ComplexArray, stroke: ComplexArray, time: float) -> FloatArray:
    """Largest force and stroke over a realisation, (2, level), of phasors (level, component); of one wave its own."""
    phasors = np.concatenate([force, stroke])
    if len(sea.omega) < 2:
        peaks = np.abs(phasors).sum(axis=1)
    else:
        count = int(np.ceil(INSTANTS * sea.omega.max() * time / (2 * np.pi))) + 1
        peaks = np.abs(superposed(sea.omega, phasors.T, np.linspace(0.0, time, count))).max(axis=0)
    return np.asarray(peaks.reshape(2, -1))


# optima within limits -----------------------------------------------------------------------------------------------


def constrained_levels(study: Study, floating: FloatingSystem, seas: Mapping[str, Sea]) -> list[ControlLevel]:
    """Return the level within the limits of the take-off of every design in every sea."""
    ds, limits = floating.linear.database, Limits(study.pto.force_limit, study.pto.stroke_limit)
    of_force, levels = (float(ds.omega[0]), band(study, ds)[1]), []
    for design, wave in product(study.designs, study.waves):
        if wave.label in seas:
            port_at = partial(floating.extended_port, design, direction=heading_in(wave, seas[wave.label]))
            levels.append(constrained_level(design, wave.label, seas[wave.label], port_at, limits, of_force))
    return levels


def in_sea(level: ControlLevel, matched: float | None) -> ControlLevel:
    """Return a level within limits with its power in the sea [W]: its share of the matched power times that of the sea.

    The optimum is of the waves of a run. Its share of what can be absorbed of them varies less than either power, and
    so it exceeds no level above it.
    """
    if level.limit_fraction is None or matched is None:
        return level
    return level._replace(power_mean=level.limit_fraction * matched)


def constrained_level(
    design: str,
    label: str,
    sea: Sea,
    port_at: Callable[[FloatArray], Port],
    limits: Limits,
    of_force: tuple[float, float],
) -> ControlLevel:
    """Return the best force found within limits in a sea and how near it is to the bound of all forces, or why not.

    Parameters
    ----------
    port_at : callable
        Frequencies -> port of the design, also outside the band of the database.
    of_force : (float, float)
        The band the force may be of [rad/s].
    """
    named = (design, label, CONSTRAINED, None, None)
    try:
        harmonics = Harmonics.of_sea(sea.omega, *of_force)
        if harmonics.count > MOST_HARMONICS:
            raise ConfigError(
                f"a force of {harmonics.count} harmonics has no optimum in reasonable time, needs at most "
                f"{MOST_HARMONICS}; lower simulation.duration or hydro.omega_max"
            )
        port = port_at(harmonics.port_omega)
        if not port.moves:
            return ControlLevel(*named, 0.0, None, 0.0, 0.0, 0.0, 0.0, STILL)
        best = optimum_in_sea(port, sea, harmonics, limits)
    except VsbError as error:
        return ControlLevel(*named, None, None, None, None, None, None, str(error))
    at = np.rint(sea.omega / harmonics.spacing - harmonics.first).astype(int)
    matched = sea.mean_of(port.matched_power[at])
    note = f"in the waves of a run {best.power:.4g} W found; no force within the limits, of any harmonics, "
    note += f"absorbs more than {best.bound:.4g} W"
    if best.excess:
        note += f"; between the instants limits are exceeded by up to {100 * best.excess:.2g} %"
    return ControlLevel(*named, best.power, best.power / matched, *best[4:7], best.gap, note)


def constrained_checks(levels: Sequence[ControlLevel]) -> list[Check]:
    """Return how far each optimum within limits is from its proof; a doubt where there is none."""
    checks = []
    for level in (level for level in levels if level.rung == CONSTRAINED):
        where = {"design": level.design, "wave": level.wave}
        if level.gap is None:
            checks.append(Check("constrained", 1.0, GAP, "-", "doubt", f"no optimum: {level.note}", **where))
        else:
            text = f"distance of the best force found from the bound of every force within the limits: {level.note}"
            checks.append(check_at_most("constrained", level.gap, GAP, "-", text, doubt=True, **where))
    return checks


# causal control -------------------------------------------------------------------------------------------------------


def causal_levels(
    study: Study,
    floating: FloatingSystem,
    seas: Sequence[tuple[Wave, Sea]],
    ports: Mapping[str, PortInSeas],
    levels: Sequence[ControlLevel],
) -> list[ControlLevel]:
    """Return the optimal causal control of every design in every irregular sea, and the damper of the same rms force.

    The limits of the take-off are read as limits of rms values; without a limit of force it is that of the optimal
    damper. Where the damper, which measures without noise, absorbs more than the controller, it is the level.

    Parameters
    ----------
    seas : sequence of (Wave, Sea)
        Those that powers are of.
    ports : mapping design -> PortInSeas
        First in these seas.
    levels : sequence of ControlLevel
        The optimal dampers and matched powers of these designs and seas.
    """
    by = {(level.design, level.wave, level.rung): level for level in levels}
    pto, found, stationary = study.pto, [], {}
    irregular = [(i, wave, sea) for i, (wave, sea) in enumerate(seas) if wave.irregular]
    for (i, wave, sea), design in product(irregular, study.designs):
        best, matched = (by[design, wave.label, rung] for rung in ("best_damper", "matched"))
        if not best.force_rms or not matched.power_mean:
            continue
        if wave.label not in stationary:
            stationary[wave.label] = stationary_ports(floating, wave, sea)
        (port, squares_of_all, _), row = ports[design], slice(i, i + 1)
        limits = RmsLimits(rms_force(pto, best.force_rms), pto.stroke_limit)
        damper = damper_within_force(port, squares_of_all[row], limits.force, pto.stiffness, pto.efficiency)
        load = port.load(damper.damping, damper.stiffness)[0]
        moved = port.velocity_under(load)
        rms = float(np.sqrt(0.5 * np.abs(load * moved) ** 2 @ squares_of_all[i]))
        stroke = float(np.sqrt(0.5 * np.abs(moved / port.omega) ** 2 @ squares_of_all[i]))
        c, k, power = (float(values[0]) for values in damper)
        same = ControlLevel(
            design, wave.label, SAME_FORCE, c, k, power, power / matched.power_mean, rms, None, None, None
        )
        found += [same, causal_level(stationary[wave.label][design], same, stroke, limits, matched, pto)]
    return found


def causal_level(
    port: Stationary, damper: ControlLevel, stroke: float, limits: RmsLimits, matched: ControlLevel, pto: Pto
) -> ControlLevel:
    """Return the level `causal` in a sea: its share of the matched power, or the damper if that absorbs more.

    Parameters
    ----------
    stroke : float [m]
        Rms displacement under the damper.
    """
    noise, forecast = pto.control.noise, pto.control.forecast
    unknown = damper._replace(rung=CAUSAL, damping=None, stiffness=None, noise=noise, forecast=forecast, note="")
    try:
        best = optimum(port, limits, noise, forecast, pto.efficiency)
        away = numerical_error(port, best, noise, forecast)
    except VsbError as error:
        return unknown._replace(power_mean=None, limit_fraction=None, force_rms=None, note=str(error))
    share = best.converted(pto.efficiency) / port.matched_power
    power = share * (matched.power_mean or 0.0)
    if stroke <= limits.stroke and (damper.power_mean or 0.0) >= power:
        return _damper_better(damper, pto.control, power, away)
    rms = None if damper.force_rms is None else best.force_rms  # of several forces without a unit in common
    return unknown._replace(power_mean=power, limit_fraction=share, force_rms=rms, numerical=away)


def _damper_better(damper: ControlLevel, control: Control, power: float, error: GridError) -> ControlLevel:
    """The level `causal` where a controller absorbs less than the damper, its power [W] and error."""
    error = error.of_damper(power / damper.power_mean) if damper.power_mean else GridError()
    own = damper._replace(noise=control.noise, forecast=control.forecast, numerical=error)
    return own._replace(rung=CAUSAL, note=DAMPER_BETTER)


def causal_levels_with_drag(
    study: Study, floating: FloatingSystem, seas: Sequence[tuple[Wave, Sea]], levels: Sequence[ControlLevel]
) -> list[ControlLevel]:
    """Return the optimal causal control beside quadratic drag in every irregular sea, and the damper of its rms force.

    That is the optimal damper: beside drag the take-off has no limits. The drag of each level is the damper equivalent
    to it under that level.
    """
    by = {(level.design, level.wave, level.rung): level for level in levels}
    pto, found = study.pto, []
    for (wave, sea), design in product(seas, study.designs):
        if not wave.irregular:
            continue
        best, matched = (by[design, wave.label, rung] for rung in ("best_damper", "matched"))
        if not best.force_rms or not matched.power_mean:
            continue
        noise, forecast = pto.control.noise, pto.control.forecast
        unknown = best._replace(
            rung=CAUSAL, damping=None, stiffness=None, power_mean=None, limit_fraction=None, force_rms=None,
            force_peak=None, stroke_peak=None, noise=noise, forecast=forecast,
        )  # fmt: skip
        if sea.heading is not None or pto.control.force_rms < np.inf:
            found.append(unknown._replace(note=SPREAD_DRAG if sea.heading is not None else FORCE_WITH_DRAG))
            continue
        found.append(best._replace(rung=SAME_FORCE))
        try:
            own = optimum_with_drag(study, floating, design, wave, sea, pto, best.force_rms)
        except VsbError as error:
            found.append(unknown._replace(note=str(error)))
            continue
        share = own.best.converted(pto.efficiency) / own.matched_power
        power, dampers = share * matched.power_mean, ", ".join(f"{d:.4g}" for d in own.damping)
        away = numerical_error(own.port, own.best, noise, forecast)
        if (best.power_mean or 0.0) >= power:
            found.append(_damper_better(best, pto.control, power, away))
            continue
        found.append(
            unknown._replace(
                power_mean=power,
                limit_fraction=share,
                force_rms=own.best.force_rms,
                numerical=away,
                note=f"the controller for drag as the dampers equivalent to it under this control, {dampers} N s/m",
            )
        )
    return found


def causal_levels_of_several(
    pto: Pto,
    floating: FloatingSystem,
    seas: Sequence[tuple[Wave, Sea]],
    matrices: Matrices,
    levels: Sequence[ControlLevel],
) -> list[ControlLevel]:
    """Return the optimal causal control of several ports in every irregular sea, and a damper matrix of its rms force.

    The rms of all forces together, sqrt(sum of mean squares), is the one given, or that of the optimal matrix. Forces
    of ports of unlike kinds are counted in units of those that it has.
    """
    omega, found = frequencies([sea for _, sea in seas]), []
    rows, ports, alike = squares([sea for _, sea in seas], omega), floating.several_ports(omega), forces_alike(pto)
    by = {(level.design, level.wave, level.rung): level for level in levels}
    for (wave, sea), row in zip(seas, rows, strict=True):
        if not wave.irregular:
            continue
        for design, stationary in stationary_ports(floating, wave, sea).items():
            best, matched = (by[design, wave.label, rung] for rung in ("best_damper", "matched"))
            if not best.power_mean or not matched.power_mean:
                continue
            force = ports[design].force_rms(matrices[design, wave.label, "best_damper"], row)
            units = force_units(pto, force)
            limit = rms_force(pto, float(np.linalg.norm(force / units)))
            together = "of all forces together" if alike else "of all forces together, each in units of the damper's"
            same = best._replace(rung=SAME_FORCE, force_rms=limit if alike else None)
            if pto.control.force_rms < np.inf:
                matrix, power = priced_matrix(ports[design], row, limit, matrix_kind(pto))[0]
                rms, note = float(np.linalg.norm(ports[design].force_rms(matrix, row))), matrix_text(matrix, 6)
                share = power / matched.power_mean
                same = same._replace(
                    power_mean=power, limit_fraction=share, force_rms=rms, note=f"damper matrix {note}"
                )
            turned = stationary.over(np.diag(units)).moved()
            causal = causal_level(turned, same, 0.0, RmsLimits(limit), matched, pto)
            found += [same, causal._replace(note="; ".join(filter(None, [f"rms {together}", causal.note])))]
    return found


# errors -------------------------------------------------------------------------------------------------------------


class _Slopes(NamedTuple):
    """Derivatives of the powers of levels by the coefficients in one sea, by design and level, and their errors."""

    powers: Mapping[tuple[str, str], Sensitivity]
    errors: Sequence[CoefficientError]


def with_errors(
    levels: Sequence[ControlLevel],
    floating: FloatingSystem,
    seas: Sequence[tuple[Wave, Sea]],
    reference: str | None,
    left_out: xr.Dataset,
    matrices: Matrices | None = None,
) -> list[ControlLevel]:
    """Return levels with the error budgets of power and gain; those of an unknown power have none.

    Parameters
    ----------
    reference : str or None
        Design gains are over. All designs share one database: of a gain only what their errors do not have in common
        is left.
    left_out : xarray.Dataset
        See `vsb.results.budget.modes_left_out`.
    matrices : mapping, optional
        Of several ports; their matched level has no budget.

    Notes
    -----
    With quadratic drag errors are taken as without it: what is damped more feels them less.
    """
    budgets: dict[tuple[str, str, str], tuple[Budget, Budget | None]] = {}
    known: dict[bytes, _Slopes] = {}
    by_sea: dict[str, dict[tuple[str, str], ControlLevel]] = {wave.label: {} for wave, _ in seas}
    for level in levels:
        if level.power_mean is not None:
            by_sea[level.wave][level.design, level.rung] = level
    for wave, sea in seas:
        here = by_sea[wave.label]
        linear = {key: level for key, level in here.items() if level.rung not in NEAR_LIMITS}
        loads = [(key, level.damping, level.stiffness) for key, level in linear.items()]
        key = repr((heading(wave), loads)).encode() + sea.omega.tobytes() + np.abs(sea.amplitude).tobytes()
        key += b"" if sea.heading is None else sea.heading.tobytes()
        if key not in known:  # realisations of a sea with the same amplitudes share them
            known[key] = _slopes(floating, wave, sea, list(linear.values()), matrices)
        slopes, errors = known[key]
        for (design, name), level in linear.items():
            if (design, name) not in slopes:
                continue
            power, own = level.power_mean or 0.0, slopes[design, name]
            numbers = [Source.within(e.name, power * own.to(e), shared=True) for e in errors]
            of_power = Budget((*numbers, *_by_modes(left_out, level, "power", power)))
            of_gain, base = None, linear.get((reference or "", name))
            if base is not None and design != reference:
                ratio = 100 * power / base.power_mean if base.power_mean else 0.0
                difference = own - slopes[base.design, name]
                numbers = [Source.within(e.name, ratio * difference.to(e), shared=True) for e in errors]
                of_gain = Budget((*numbers, *_by_modes(left_out, level, "gain", 1.0)))
            budgets[design, wave.label, name] = (of_power, of_gain)
        for (design, name), level in here.items():
            ends = [linear[design, end] for end in ("best_damper", "matched") if (design, wave.label, end) in budgets]
            if name in NEAR_LIMITS and (ends := [end for end in ends if end.power_mean]):
                budgets[design, wave.label, name] = _within_limits(level, ends, budgets)
    found = []
    for level in levels:
        if level.power_mean is None:
            found.append(level)
            continue
        of_power, of_gain = budgets.get((level.design, level.wave, level.rung), (Budget(), None))
        if level.gap:
            of_power += Budget((Source("optimum not proven", 0.0, level.power_mean * level.gap / (1 - level.gap)),))
        if level.rung == CAUSAL:
            of_power += Budget((Source.within(NUMERICAL, level.power_mean * level.numerical.size),))
            base = by_sea[level.wave].get((reference or "", CAUSAL))
            if of_gain is not None and base is not None and base.power_mean:
                together = level.numerical.size + base.numerical.size
                of_gain += Budget((Source.within(NUMERICAL, 100 * level.power_mean / base.power_mean * together),))
        low, high = of_power.interval(level.power_mean)
        gain_rows = None if of_gain is None else of_gain.rows
        found.append(level._replace(low=low, high=high, power_error=of_power.rows, gain_error=gain_rows))
    return found


def _slopes(
    floating: FloatingSystem, wave: Wave, sea: Sea, levels: Sequence[ControlLevel], matrices: Matrices | None
) -> _Slopes:
    """Derivatives of the powers of levels in a sea; the matched force is that of the conjugate impedance."""
    linear, squares = floating.towards(heading_in(wave, sea)), np.abs(sea.amplitude) ** 2
    found: dict[tuple[str, str], Sensitivity] = {}
    waves = AtFrequencies(linear.equation(sea.omega), floating.motions, floating.port).in_waves()
    for design, (port, _, moved) in waves.items():
        loads: dict[str, ComplexArray | FloatArray] = {}
        if matrices is not None:
            loads = {name: one for (of, at, name), one in matrices.items() if (of, at) == (design, wave.label)}
        else:
            for level in (level for level in levels if level.design == design):
                loads[level.rung] = np.conj(port.impedance)
                if level.damping is not None and level.stiffness is not None:
                    loads[level.rung] = port.load(level.damping, level.stiffness)
        found |= {(design, name): sensitivity(moved, port, load, squares) for name, load in loads.items()}
    return _Slopes(found, coefficient_errors(linear, sea.omega))


def _by_modes(left_out: xr.Dataset, level: ControlLevel, name: str, size: float) -> list[Source]:
    """What modes left out may change of a `power` or a `gain`; nothing where it is not known, or zero."""
    if name not in left_out:
        return []
    ends = left_out[name].sel(design=level.design, wave=level.wave, take_off=level.rung)
    low, high = sorted(size * float(end) for end in ends)
    return [Source(MODES, low, high)] if low or high else []


def _within_limits(
    level: ControlLevel,
    ends: Sequence[ControlLevel],
    budgets: Mapping[tuple[str, str, str], tuple[Budget, Budget | None]],
) -> tuple[Budget, Budget | None]:
    """Budgets of an optimum within limits: relative to power the larger of those at the best damper and matched.

    Where limits hardly bind the optimum is the matched force; where they bind most its power goes with |V0| alone,
    to which the optimal damper is twice as sensitive.
    """
    known = [(end.power_mean or 0.0, *budgets[end.design, end.wave, end.rung]) for end in ends]
    power, of_power, _ = max(known, key=lambda one: (one[1].high - one[1].low) / one[0])
    gains = [of_gain for _, _, of_gain in known if of_gain is not None]
    of_gain = max(gains, key=lambda budget: budget.high - budget.low) if gains else None
    return of_power.scaled((level.power_mean or 0.0) / power), of_gain


def as_csv(levels: Sequence[ControlLevel]) -> str:
    """Return the levels as CSV; an empty cell is a quantity that does not exist, as of a port that cannot move."""
    return csv_text(COLUMNS, ([getattr(level, name) for name in COLUMNS] for level in levels), 12)
