"""A run from start to end by one of the methods, in legs of bounded memory, with its energy audit and its record."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.integrators.audit import START, Balance, absorbed_power, energies, terms
from vsb.engine.integrators.collocation import collocated
from vsb.engine.integrators.exact import convolve, propagate, steady_state
from vsb.engine.integrators.exponential import integrate
from vsb.engine.integrators.settings import LEG, RECORDS_PER_PERIOD, Simulation, thinning
from vsb.engine.integrators.switching import Switching
from vsb.engine.motion.system import Motion, System
from vsb.engine.waves.seas import Sea
from vsb.errors import ConvergenceError, StabilityError
from vsb.tools.arrays import FloatArray

FARTHEST = 100.0
"""Heave in radii that no floating buoy reaches."""


class Leg(NamedTuple):
    """A part of a run: what is in memory at one time."""

    motion: Motion
    forces: Mapping[str, FloatArray]  # `System.forces` of the motion where the audit needs them, else none
    energy: Mapping[str, FloatArray]  # since the start of the run, each (time,) [J]; see `energies`
    balance: Balance  # at its end
    stride: int  # instants per readable record
    thinning: int  # readable records per record of a long run
    method: str
    steps: int  # of the method, if it has steps of its own

    @property
    def end(self) -> tuple[FloatArray, ...]:
        """Position, velocity and memory at the last instant, where the next leg starts."""
        return self.motion.position[-1], self.motion.velocity[-1], self.motion.memory[-1]


def recorded(system: System, leg: Leg, sea: Sea | None, window: tuple[float, float]) -> xr.Dataset:
    """Return the record of a leg: motion, forces by name, absorbed power, energies, elevation.

    Every readable instant of a short run. Of a long one a part of them, and those in the window [s] where a coordinate,
    a velocity or the absorbed power is extreme: figures of merit are those of all instants.
    A rigid design records its motions, a flexible one heave and all shell modes; an assumed pressure has no elevation.
    """
    motion, scene = leg.motion, system.scene
    carried = [i for i, row in enumerate(scene.motions) if scene.flexible or row.any()]
    labels, motions = [scene.labels[i] for i in carried], scene.motions[carried]
    forces = leg.forces or system.forces(motion)
    absorbed = absorbed_power(system, motion, forces)
    named = {name: force[:, carried] for name, force in forces.items()}
    series = {"position": motion.position @ motions.T, "velocity": motion.velocity @ motions.T} | named
    kept = np.append(np.arange(0, len(motion.time) - 1, leg.stride * leg.thinning), len(motion.time) - 1)
    if leg.thinning > 1:
        watched = np.hstack([series["position"], series["velocity"], absorbed[:, None]])
        (inside,) = np.nonzero((motion.time > window[0] - 1e-9) & (motion.time < window[1] + 1e-9))
        if inside.size:
            kept = np.union1d(kept, inside[np.append(watched[inside].argmin(axis=0), watched[inside].argmax(axis=0))])
    balance = terms(leg.energy)
    run = xr.Dataset(
        {
            **{name: (("time", "dof"), values[kept]) for name, values in series.items()},
            "power_absorbed": ("time", absorbed[kept]),
            "energy": (("time", "term"), np.stack([leg.energy[term][kept] for term in balance], axis=1)),
        },
        coords={"time": motion.time[kept], "dof": labels, "term": list(balance)},
    )
    return run.assign(elevation=("time", sea.elevation(motion.time)[kept])) if sea else run


EXACT = "exact propagation"
WET_SWITCHING = "exponential collocation between switches"
CONVOLVED = 1e-4
"""Energy residual of a convolution: its motion is of second order, and so is its energy error."""
FEWEST_IN_WINDOW = 4
"""Least number of instants recorded in the window of the statistics."""
ROUND_OFF = 1e-9
"""Energy residual that is round-off [-]."""
FINEST = 2**5
"""Most samples per recorded step."""
Follow = Callable[[FloatArray, tuple[FloatArray, ...]], tuple[Motion, int]]
"""Equally spaced instants, y, y' and memory at the first of them -> the motion, and the number of steps or 0."""


class Method(NamedTuple):
    """A method of integration."""

    words: str
    follower: Callable[[System, float, DampingSpectrum | None], Follow]  # of a system, to a tolerance


def _exactly(system: System, tolerance: float, spectrum: DampingSpectrum | None) -> Follow:
    """Exact propagation; the steady state serves all legs."""
    steady = steady_state(system)
    return lambda time, start: (propagate(system, time, start, steady), 0)


def _convolved(system: System, tolerance: float, spectrum: DampingSpectrum | None) -> Follow:
    """Cummins' convolution with the damping itself."""
    if spectrum is None:
        raise ValueError("convolution: received no radiation damping, needs a scene with a hydro database.")
    return lambda time, start: (convolve(system, spectrum, time, (start[0], start[1])), 0)


METHODS: dict[str, Method] = {
    "exact": Method(EXACT, _exactly),
    "convolution": Method("convolution", _convolved),
    "switching": Method("exact propagation between switches", lambda s, tol, _: Switching(s, tol).follow),
    "exponential": Method("exponential Adams", lambda s, tol, _: lambda time, start: integrate(s, time, start, tol)),
    "collocation": Method(
        "exponential collocation", lambda s, tol, _: lambda time, start: collocated(s, time, start, tol)
    ),
}
"""`simulation.method` -> how a motion is followed; `auto` is the first of these or, where a take-off switches,
`switching`, where the water's force is nonlinear, `exponential`, where another one is, `collocation`."""


def suited(system: System) -> str:
    """Return the method that suits a system, of `METHODS`."""
    if system.linear:
        return "exact"
    return "switching" if system.switching else "collocation" if system.not_compiled else "exponential"


def simulate(
    system: System, sea: Sea, settings: Simulation, spectrum: DampingSpectrum | None
) -> tuple[Motion, int, str]:
    """Return the whole motion of a scene at once, the number of instants per readable record, and the method.

    See `legs`, whose memory does not grow with the run.
    """
    (leg,) = legs(system, sea, settings, spectrum, longest=None)
    return leg.motion, leg.stride, in_words(leg.method, leg.steps)


def in_words(method: str, steps: int) -> str:
    """Return the method in words, with its number of steps if it has its own."""
    return f"{method}, {steps} steps" if steps else method


def legs(
    system: System,
    sea: Sea,
    settings: Simulation,
    spectrum: DampingSpectrum | None,
    longest: int | None = LEG,
    records: int = RECORDS_PER_PERIOD,
) -> Iterator[Leg]:
    """Yield the motion of a scene, its energy audit closed, in legs one after the other.

    A motion far from the limits of its take-off is followed without them: it never switches. Exact propagation runs
    once. Nonlinear scenes are recorded at half the distance until the audit closes to the tolerance: this refines the
    audit, not the motion. For the convolution that distance is the step.

    Raises `ConvergenceError` if the audit of an exact propagation does not close; `StabilityError` if the buoy leaves
    the water for good.

    Parameters
    ----------
    settings : Simulation
        Duration, initial heave and velocity, method, tolerance.
    spectrum : DampingSpectrum or None
        For the convolution only.
    longest : int or None
        Most instants of a leg; None: one leg, as the convolution, which needs its whole past, always has.
    records : int
        Instants recorded per period of the shortest wave that matters, to begin with.
    """

    def run(some: System) -> Iterator[Leg]:
        return _legs(some, sea, settings, spectrum, longest, records)

    free = system.scene.without_limits if settings.method == "auto" and system.switching else None
    far = None if free is None else _far_from_limits(system, partial(run, System.of(free)))
    yield from far or run(system)


FAR = 0.8
"""Largest force and stroke, over their limits, of a motion that is far from them: between recorded instants, 200 for
each period of the shortest wave, the shell may move a little further."""


def _far_from_limits(system: System, run: Callable[[], Iterator[Leg]]) -> Iterable[Leg] | None:
    """Legs of a run of a system without its limits, forces not yet known; None if its motion comes near them."""
    motions = system.scene.motions.T
    try:
        for leg in run():
            if system.scene.reach(leg.motion.position @ motions, leg.motion.velocity @ motions) > FAR:
                return None
    except (ConvergenceError, StabilityError):  # such as of a buoy that its end stop holds
        return None
    whole = leg.motion.time[0] == 0.0  # of several legs only one is kept at a time
    return (one._replace(forces={}) for one in ([leg] if whole else run()))


def _legs(
    system: System,
    sea: Sea,
    settings: Simulation,
    spectrum: DampingSpectrum | None,
    longest: int | None,
    records: int,
) -> Iterator[Leg]:
    """Legs by the method of the settings, whatever the limits."""
    count, convolved = recorded_steps(system, sea, settings, records), settings.method == "convolution"
    enough = max(settings.tolerance, CONVOLVED if convolved else ROUND_OFF)
    name = {"auto": suited(system)}.get(settings.method, settings.method)
    follow = METHODS[name].follower(system, settings.tolerance, spectrum)
    method = WET_SWITCHING if name == "switching" and system.scene.water else METHODS[name].words
    start: tuple[FloatArray, ...] = system.scene.start(settings.initial_position, settings.initial_velocity)
    done, stride, balance, errors = 0, 1, START, [np.inf, np.inf]
    while done < count:
        parts = 1 if convolved or longest is None else math.ceil((count - done) * stride / longest)
        last = done + math.ceil((count - done) / parts)
        begin, end = (settings.duration * (record / count) for record in (done, last))
        motion, steps = follow(np.linspace(begin, end, (last - done) * stride + 1), start)
        check_floats(system, motion)
        forces = {} if motion.works else system.forces(motion)
        gained = energies(system, motion, forces)
        energy = {term: gained[term] + balance.ended.get(term, 0.0) for term in gained}
        after = balance.after(energy)
        errors.append(START.after(gained).unbalanced / after.largest if after.largest else 0.0)
        closed = errors[-1] <= enough
        if closed or errors[-1] > 0.9 * errors[-3] or stride == FINEST:  # or finer records do not help
            leg = Leg(motion, forces, energy, after, stride, thinning(count), method, steps)
            yield leg
            done, start, balance = last, leg.end, after
            errors = [np.inf, np.inf] if closed else errors
        elif name == "exact":
            raise ConvergenceError(
                f"the energy audit does not close: {errors[-1]:.1e} of the energy is missing, needs {enough:.0e}; "
                "near an undamped resonance add device.damping or pto.damping, else raise simulation.tolerance."
            )
        else:
            stride *= 2


def check_floats(system: System, motion: Motion) -> None:
    """Check that a buoy of finite motion heaves by less than `FARTHEST` radii, as any buoy that floats does.

    Raises `StabilityError`: out of the water, or far below, nothing holds it against a spring of negative stiffness.
    """
    scene = system.scene
    if scene.water is None or "Heave" not in scene.labels:
        return
    heave = np.abs(motion.position @ scene.motions[scene.labels.index("Heave")]).max()
    if not heave < FARTHEST * scene.water.shell.basis.shell.radius:
        raise StabilityError(
            f"the buoy heaves by {heave:.3g} m, more than {FARTHEST:g} radii, for away from the waterplane nothing "
            "holds it against a spring below zero; raise pto.stiffness, or lower the waves"
        )


def recorded_steps(system: System, sea: Sea, settings: Simulation, records: int = RECORDS_PER_PERIOD) -> int:
    """Return the number of recorded steps, so many per period of the shortest wave that matters.

    Without waves, of the faster of free heave and the assumed pressure: the buoy heaves freely until that has died out.
    """
    if sea.omega.size:
        omega = float(sea.omega[np.abs(sea.amplitude) > 0.05 * np.abs(sea.amplitude).max()].max())
    else:
        omega = max([system.heaving, *system.frequencies])
    start, end = settings.window
    rate = max(records * omega / (2 * np.pi), FEWEST_IN_WINDOW / (end - start))
    return int(np.ceil(rate * settings.duration))
