"""The ladder of a study: what each design takes of each sea under ever better take-offs, up to the matched limit."""

import csv
import io
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vsb.motion.port import Port, port_direction
from vsb.motion.tuning import IntArray, Load, best_dampers, best_pairs, frequencies, mean_power, squares
from vsb.scenes.build import linear_buoy
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import design_motions
from vsb.study.study import IrregularSea, StillWater, Study
from vsb.tools.units import ComplexArray, FloatArray
from vsb.waves.seas import Sea, sea
from vsb.waves.superposition import superposed

RUNGS = ("fixed", "best_damper", "best_damper_all_seas", "best_spring_damper", "constrained", "matched")
"""Each takes no less of a sea than those before it, but a damper for all seas no more than the best one."""
INSTANTS = 8
"""Instants at which peaks are looked for, per shortest period of a sea."""


class Rung(NamedTuple):
    """One take-off of one design in one sea; what a rung does not have is none."""

    design: str
    wave: str
    rung: str
    damping: float | None  # [N s/m]
    stiffness: float | None  # [N/m]
    power_mean: float  # [W]
    limit_fraction: float | None  # of the matched power [-]
    force_rms: float  # [N]
    force_peak: float  # of the realisation [N]
    stroke_peak: float  # likewise, from rest [m]
    gap: float | None  # by which a better one is not ruled out, of a constrained optimum [-]


class Given(NamedTuple):
    """The take-off of a study: damper (none: tuned), spring, efficiency of both directions of power."""

    damping: float | None
    stiffness: float = 0.0
    efficiency: float = 1.0


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
    best = best_dampers(port, waves, given.stiffness, given.efficiency).or_better(one)
    rungs = {} if given.damping is None else {"fixed": under(given.damping)}
    best = best.or_better(rungs["fixed"]) if rungs else best
    pairs = best_pairs(port, waves, best, given.efficiency)
    return rungs | {"best_damper": best, "best_damper_all_seas": one, "best_spring_damper": pairs}


def ladder(
    ports: Mapping[str, Port], seas: Mapping[str, Sea], families: Sequence[int], given: Mapping[str, Given], time: float
) -> list[Rung]:
    """Return the rungs of every design in every sea.

    Parameters
    ----------
    ports : mapping design -> Port
        Over `frequencies` of the seas.
    seas : mapping wave label -> Sea
        Without still water.
    families : sequence of int
        See `linear_rungs`.
    given : mapping design -> Given
    time : float
        How long a realisation is looked at for its peaks [s].
    """
    found: list[Rung] = []
    for design, port in ports.items():
        waves = squares(list(seas.values()), port.omega)
        matched, loads = waves @ port.matched_power, linear_rungs(port, waves, families, given[design])
        for i, (label, here) in enumerate(seas.items()):
            at = np.searchsorted(port.omega, here.omega)
            forces, strokes = _phasors(port, at, [Load(*(v[[i]] for v in load)) for load in loads.values()], here)
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


def study_ladder(study: Study, database: str) -> list[Rung]:
    """Return the rungs of every design of a study in every sea; still water has none.

    Parameters
    ----------
    study : Study
    database : str
        Path of its hydro database.
    """
    buoy, basis = linear_buoy(study, database)
    waves = [wave for wave in study.waves if not isinstance(wave, StillWater)]
    if not waves:
        return []
    seas = {wave.label: sea(wave, study.hydro.omega_max, study.simulation.duration) for wave in waves}
    names = [wave.family if isinstance(wave, IrregularSea) else wave.label for wave in waves]
    families = [names.index(name) for name in dict.fromkeys(names)]
    direction = port_direction(study.pto.port, DeformedShell(basis, study.centre_height))
    omega = frequencies(list(seas.values()))
    ports = {design: buoy.port(omega, design_motions(study, basis, design), direction) for design in study.designs}
    pto = study.pto
    given = {design: Given(pto.damper(design), pto.stiffness, pto.efficiency) for design in study.designs}
    return ladder(ports, seas, families, given, study.simulation.duration)


def _phasors(port: Port, at: IntArray, loads: Sequence[Load], sea: Sea) -> tuple[ComplexArray, ComplexArray]:
    """Forces and displacements under loads and under the matched force, each shape (load, component) [N], [m]."""
    damping, stiffness = (np.concatenate([load[k] for load in loads]) for k in (0, 1))
    impedance = port.load(damping, stiffness)
    velocity = port.velocity_under(impedance)
    forces = np.concatenate([impedance * velocity, port.matched_force[None]])
    velocities = np.concatenate([velocity, (port.velocity - port.admittance * port.matched_force)[None]])
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
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Rung._fields)
    writer.writerows(["" if v is None else f"{v:.12g}" if isinstance(v, float) else v for v in rung] for rung in rungs)
    return text.getvalue()
