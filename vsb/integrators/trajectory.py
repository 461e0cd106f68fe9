"""Labelled time series of a run: motion, forces by name, and the energy audit."""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from vsb.errors import ConvergenceError
from vsb.hydro.kernel import DampingSpectrum
from vsb.integrators.audit import flow
from vsb.integrators.convolution import convolve
from vsb.integrators.energy_preserving import structure_preserving
from vsb.integrators.exact import propagate, steady_state
from vsb.integrators.exponential import integrate
from vsb.motion.motion import Motion
from vsb.motion.system import EXCITING, System
from vsb.study.resolution import LEG, RECORDS_PER_PERIOD, thinning
from vsb.study.study import Simulation
from vsb.tools.units import FloatArray
from vsb.waves.seas import Sea

TERMS = ("wave", "pto", "radiated", "structural", "stored")
EXACT = "exact propagation"
CONVOLVED = 1e-4
"""Energy residual of a convolution: its motion is of second order, and so is what it loses."""
FEWEST_IN_WINDOW = 4
"""Instants recorded in the window of the statistics, at least."""
ROUND_OFF = 1e-9
"""Energy residual that is as good as none [-]."""
FINEST = 2**5
"""Most samples per recorded step."""


def energies(system: System, motion: Motion) -> dict[str, FloatArray]:
    """Return the energy of each term since the start, each shape (time,) [J]: wave = the sum of the others.

    Notes
    -----
    Losses and the waves' work are integrated along the flow between records (`vsb.integrators.audit`), what is stored
    is read from the records.
    `turned` is no term of the sum: kinetic energy, and a billionth of the energy stored, below which all is round-off.
    With the state space, radiated power is (l.x)^2/2 and the memory stores x.x/2, both from the memory states alone:
    the audit is then a check on the whole chain. With the convolution the radiation force's work stands for both.
    """
    named, remembered, memory = system.forces(motion), motion.memory.size > 0, system.scene.memory
    none = np.zeros((len(motion.time), system.free))
    acting: list[FloatArray] = [sum((named[name] @ system.shapes for name in EXCITING if name in named), none)]
    if memory and not remembered:
        acting.append(-named["radiation"] @ system.shapes)
    pto, structural, radiated, wave, *convolved = flow(system, motion, system.driving(motion, named)).works(
        system.dampers(), memory.channel if memory and remembered else None, acting
    )
    stored, kinetic = system.energy(motion)
    return {
        "wave": wave,
        "pto": pto,
        "radiated": sum(convolved, radiated),
        "structural": structural,
        "stored": stored - stored[0],
        "turned": kinetic + 1e-9 * np.abs(stored),
    }


class Balance(NamedTuple):
    """Energy audit of a run so far."""

    ended: Mapping[str, float]  # energy of each term at the end [J]
    unbalanced: float  # the largest so far [J]
    largest: float  # of all terms and of the kinetic energy so far [J]

    def after(self, energy: Mapping[str, FloatArray]) -> "Balance":
        """Return the audit after one more leg; `energy` since the start of the run."""
        unbalanced = energy["wave"] - sum(energy[term] for term in TERMS[1:])
        largest = max(float(np.abs(energy[term]).max()) for term in (*TERMS, "turned"))
        ended = {term: float(energy[term][-1]) for term in TERMS}
        return Balance(ended, max(self.unbalanced, float(np.abs(unbalanced).max())), max(self.largest, largest))

    @property
    def residual(self) -> float:
        """`residual` of the run so far."""
        return self.unbalanced / self.largest if self.largest else 0.0


START = Balance(dict.fromkeys(TERMS, 0.0), 0.0, 0.0)


def residual(energy: Mapping[str, FloatArray]) -> float:
    """Return the largest unbalanced energy relative to the energy that went round [-].

    |wave - pto - radiated - structural - stored| over the largest of the terms and of the kinetic energy: in free
    motion without losses every term is zero but for errors.
    """
    return START.after(energy).residual


class Leg(NamedTuple):
    """A part of a run: what needs memory at one time."""

    motion: Motion
    energy: Mapping[str, FloatArray]  # since the start of the run, each (time,) [J]; see `energies`
    balance: Balance  # at its end
    stride: int  # every how many instants make a readable record
    thinning: int  # every how many of those a long run records
    method: str
    steps: int  # the method took, if it takes steps

    @property
    def end(self) -> tuple[FloatArray, ...]:
        """Position, velocity and memory at the last instant, where the next leg starts."""
        return self.motion.position[-1], self.motion.velocity[-1], self.motion.memory[-1]


def labelled(system: System, motion: Motion, sea: Sea | None, design: str, wave: str, stride: int) -> xr.Dataset:
    """Return a run as a dataset, every `stride`-th instant, with the audit of all instants; see `recorded`."""
    energy = energies(system, motion)
    leg = Leg(motion, energy, START.after(energy), stride, 1, "", 0)
    attrs = {"design": design, "wave": wave, "energy_residual": leg.balance.residual, "status": "completed"}
    return recorded(system, leg, sea, (0.0, 0.0)).assign_attrs(attrs)


def recorded(system: System, leg: Leg, sea: Sea | None, window: tuple[float, float]) -> xr.Dataset:
    """Return the record of a leg: motion, forces by name, energies, elevation.

    Every readable instant of a short run. Of a long one a part of them, and those in the window [s] where a coordinate,
    a velocity or the power taken off is extreme: figures of merit are those of all instants.
    A rigid design carries its motions, a flexible one heave and all shell modes; an assumed pressure has no elevation.
    """
    motion, scene = leg.motion, system.scene
    carried = [i for i, row in enumerate(scene.motions) if scene.flexible or row.any()]
    labels, motions = [scene.labels[i] for i in carried], scene.motions[carried]
    named = {name: force[:, carried] for name, force in system.forces(motion).items()}
    series = {"position": motion.position @ motions.T, "velocity": motion.velocity @ motions.T} | named
    kept = np.append(np.arange(0, len(motion.time) - 1, leg.stride * leg.thinning), len(motion.time) - 1)
    if leg.thinning > 1:
        power = np.sum(named.get(scene.take_off, 0.0 * series["velocity"]) * series["velocity"], axis=1, keepdims=True)
        watched = np.hstack([series["position"], series["velocity"], power])
        kept = np.union1d(kept, _extremes(watched, (motion.time > window[0] - 1e-9) & (motion.time < window[1] + 1e-9)))
    run = xr.Dataset(
        {
            **{name: (("time", "dof"), values[kept]) for name, values in series.items()},
            "energy": (("time", "term"), np.stack([leg.energy[term][kept] for term in TERMS], axis=1)),
        },
        coords={"time": motion.time[kept], "dof": labels, "term": list(TERMS)},
    )
    return run.assign(elevation=("time", sea.elevation(motion.time)[kept])) if sea else run


def _extremes(series: FloatArray, inside: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Rows, among those inside, in which a column of a series has its least or its largest value."""
    (rows,) = np.nonzero(inside)
    extremes = [series[rows].argmin(axis=0), series[rows].argmax(axis=0)] if rows.size else []
    return np.asarray(rows[np.ravel(extremes).astype(int)])


def simulate(
    system: System, sea: Sea, settings: Simulation, spectrum: DampingSpectrum | None
) -> tuple[Motion, int, str]:
    """Return the whole motion of a scene at once, every how many instants make a readable record, and the method.

    See `legs`, which take no more memory for a longer run.
    """
    (leg,) = legs(system, sea, settings, spectrum, longest=None)
    return leg.motion, leg.stride, in_words(leg.method, leg.steps)


def in_words(method: str, steps: int) -> str:
    """Return how a motion was followed; only some methods take steps of their own."""
    return f"{method}, {steps} steps" if steps else method


def legs(
    system: System, sea: Sea, settings: Simulation, spectrum: DampingSpectrum | None, longest: int | None = LEG
) -> Iterator[Leg]:
    """Yield the motion of a scene, its energy audit closed, in legs one after the other.

    Parameters
    ----------
    system : System
    sea : Sea
    settings : Simulation
        Duration, initial heave and velocity, method, tolerance. Exact propagation runs once. What is not linear is
        recorded at half the distance until the audit closes to the tolerance: this sharpens the audit, not the
        motion. For the convolution that distance is the step.
    spectrum : DampingSpectrum or None
        Only the convolution reads it.
    longest : int or None
        Most instants of a leg; None: one leg, as the convolution, which needs its whole past, always has.

    Raises
    ------
    ConvergenceError
        If the audit of an exact propagation does not close.
    """
    count, convolved = recorded_steps(system, sea, settings), settings.method == "convolution"
    enough = max(settings.tolerance, CONVOLVED if convolved else ROUND_OFF)
    follow = _follower(system, settings, spectrum)
    start: tuple[FloatArray, ...] = system.scene.start(settings.initial_position, settings.initial_velocity)
    done, stride, balance, found = 0, 1, START, [np.inf, np.inf]
    while done < count:
        parts = 1 if convolved or longest is None else math.ceil((count - done) * stride / longest)
        last = done + math.ceil((count - done) / parts)
        begin, end = (settings.duration * (record / count) for record in (done, last))
        motion, method, steps = follow(np.linspace(begin, end, (last - done) * stride + 1), start)
        own = energies(system, motion)
        energy = {term: own[term] + balance.ended.get(term, 0.0) for term in own}
        after = balance.after(energy)
        found.append(START.after(own).unbalanced / after.largest if after.largest else 0.0)
        closed = found[-1] <= enough
        if closed or found[-1] > 0.9 * found[-3] or stride == FINEST:  # or finer records do not help
            leg = Leg(motion, energy, after, stride, thinning(count), method, steps)
            yield leg
            done, start, balance = last, leg.end, after
            found = [np.inf, np.inf] if closed else found
        elif method == EXACT:
            raise ConvergenceError(
                f"the energy audit does not close: {found[-1]:.1e} of the energy is missing, needs {enough:.0e}; "
                "near an undamped resonance add device.damping or pto.damping, else raise simulation.tolerance."
            )
        else:
            stride *= 2


Followed = tuple[Motion, str, int]
"""A motion, the name of its method, and the steps it took, if that takes steps."""


def _follower(
    system: System, settings: Simulation, spectrum: DampingSpectrum | None
) -> Callable[[FloatArray, tuple[FloatArray, ...]], Followed]:
    """What gives the motion at given times from a start, by the method that suits the scene."""
    tolerance = settings.tolerance
    if settings.method == "structure_preserving":
        return lambda time, start: _named("structure-preserving", *structure_preserving(system, time, start, tolerance))
    if not system.linear:
        return lambda time, start: _named("exponential Adams", *integrate(system, time, start, tolerance))
    if settings.method == "convolution" and spectrum is not None:
        return lambda time, start: _named("convolution", convolve(system, spectrum, time, (start[0], start[1])))
    steady = steady_state(system)
    return lambda time, start: _named(EXACT, propagate(system, time, start, steady))


def _named(name: str, motion: Motion, steps: int = 0) -> Followed:
    """A motion with the name of its method."""
    return motion, name, steps


def recorded_steps(system: System, sea: Sea, settings: Simulation) -> int:
    """Return the number of recorded steps, `RECORDS_PER_PERIOD` of the shortest wave that matters.

    Without waves, of the faster of free heave and the assumed pressure: the buoy heaves freely until that has died out.
    """
    if sea.omega.size:
        omega = float(sea.omega[np.abs(sea.amplitude) > 0.05 * np.abs(sea.amplitude).max()].max())
    else:
        omega = max([system.heaving, *system.frequencies])
    start, end = settings.window
    rate = max(RECORDS_PER_PERIOD * omega / (2 * np.pi), FEWEST_IN_WINDOW / (end - start))
    return int(np.ceil(rate * settings.duration))
