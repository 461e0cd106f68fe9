"""Motion under a switching take-off: exact between events in a linear scene, with events located to round-off.

A take-off's law and an end stop (`vsb.engine.motion.forces`) are piecewise linear, so from one switch to the next a
linear scene is one linear regime (`vsb.engine.integrators.phases`) whose motion is known exactly. Guards are evaluated
at instants close enough for every motion the port can feel; where one has changed sign between two of them its zero is
found by Brent's method on that motion. In a linear scene no step size matters but the distance of these instants. In a
body-exact scene the rest of the water's force is added by polynomials of order 6, known inside to the same order, each
over as many of these instants as the tolerance allows. In a regular wave the motion is followed until it is periodic.
"""

import time as clock
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from vsb.engine.integrators.harmonic_balance import regular_frequency
from vsb.engine.integrators.phases import TERMS, LinearLaw, Phase, Piece, Signals, WetPhase, account
from vsb.engine.motion.system import EndStop, Motion, System, TakeOff, joined
from vsb.errors import ConvergenceError
from vsb.tools.arrays import BoolArray, FloatArray

SOON = 2.0**-20
"""Part of a span after which a guard that has just vanished has a sign above round-off."""


def sign(value: FloatArray | float) -> int:
    """Return the sign of a number, 1 of zero."""
    return 1 if value >= 0 else -1


class Mode(NamedTuple):
    """Which pieces of the laws are in force."""

    way: int  # sign of V; 0: the port is held at rest
    limited: int = 0  # sign of the spring-damper's force where it is at its limit; else 0
    contact: int = 0  # side of the stop that is pressed, or 0
    in_latching_time: bool = False
    until: float = np.inf  # end of the latching time [s]


class Lookout(NamedTuple):
    """Distance of the instants at which events are looked for."""

    step: float  # while the stop is in contact [s]
    stride: int = 1  # steps at once while it is not, a power of 2

    def steps(self, mode: Mode) -> int:
        """Return the number of steps at once in a mode."""
        return 1 if mode.contact else self.stride

    def ahead(self, mode: Mode, i: int, far: int) -> slice:
        """Return the next steps of a mode, at most `far`, after the i-th step."""
        stride = self.steps(mode)
        first = (i // stride + 1) * stride
        return slice(first, first + far * stride, stride)


@dataclass
class Track:
    """Nodes of a run as they are computed; each with the mode from there on."""

    lookout: Lookout
    times: list[FloatArray] = field(default_factory=list)
    states: list[FloatArray] = field(default_factory=list)
    leaving: list[FloatArray] = field(default_factory=list)  # as the next step begins
    regular: list[BoolArray] = field(default_factory=list)  # which are whole strides apart
    modes: list[Mode] = field(default_factory=list)
    error: float = 0.0  # of all steps together, in the norm of z
    largest: float = 0.0  # norm of z
    events: list[float] = field(default_factory=list)  # when pieces changed [s]

    def add(self, times: FloatArray, states: FloatArray, mode: Mode, regular: BoolArray) -> None:
        """Add nodes of one mode."""
        self.times.append(times)
        self.states.append(states)
        self.leaving.append(states)
        self.regular.append(regular)
        self.modes += [mode] * len(times)

    def switch(self, t: float, state: FloatArray, mode: Mode) -> None:
        """Add the node of an event, with the mode after it."""
        self.events.append(t)
        self.add(np.array([t]), state[None], mode, np.array([False]))

    def leave(self, state: FloatArray, error: float) -> None:
        """Record the state in which a step leaves the last node, and its error."""
        self.leaving[-1] = np.vstack([self.leaving[-1][:-1], state[None]])
        self.error += error


def dips(values: FloatArray, rates: FloatArray) -> list[tuple[int, float]]:
    """Return the spans in which a guard, positive at both ends, may dip below zero, and where in them it is lowest.

    From values and rates per span at the ends of spans, (span + 1,), by the cubic through them; where the rates are of
    one sign there is no bottom inside. A bottom right behind the begin is round-off of the event there: friction lets
    go with neither velocity nor acceleration.
    """
    minima = []
    for k in np.flatnonzero((values[:-1] > 0) & (values[1:] >= 0) & (rates[:-1] < 0) & (rates[1:] > 0)):
        low, high, falling, rising = values[k], values[k + 1], rates[k], rates[k + 1]
        bend, twist = 3 * (high - low) - 2 * falling - rising, 2 * (low - high) + falling + rising
        root = np.sqrt(max(bend**2 - 3 * twist * falling, 0.0))
        # The root of the slope at which it rises, written so that a parabola, without a twist, is no special case.
        part = float(-falling / (bend + root) if bend > 0 else (root - bend) / (3 * twist))
        if part > SOON and low + part * (falling + part * (bend + part * twist)) < 0:
            minima.append((int(k), part))
    return minima


RESOLVED = 0.25
"""Largest distance of the instants of the lookout [rad], for the fastest motion at the port."""
EXACT, COARSER = 1e-6, 4.0
"""Tolerance for which it is chosen, with works and steps of order 6, and its largest increase for a larger one."""
CLOSE = 8  # instants computed ahead after an event, at most; doubled each time there is no other
GROWTH = 2.0**7
"""Twice the steps make 2^6 times the error per time."""
SAFE = 5.0
"""Errors of successive steps differ in sign: what adds up is such a part of them."""
FINEST = 10  # halvings of a recorded step, for accuracy
AT_ONCE = 2**15
"""Instants of the lookout computed together: bounds the memory of a run."""
MOST_EVENTS = 1000
"""In one recorded step, before a run is given up."""


FELT = 1e-3
"""Modes that respond less than this part of the largest to an impulse at the port are neglected."""


@dataclass(frozen=True)
class Switching:
    """A linear or body-exact scene with a take-off that switches, and perhaps an end stop.

    Raises `ValueError` if the scene has no such take-off, or forces that are not piecewise linear.
    """

    system: System
    tolerance: float = EXACT  # of a body-exact motion, relative to the largest norm of the state; of any other's works
    modes: dict[float, Mode] = field(default_factory=dict)  # at the ends of legs
    phases: dict[tuple[float, float, float, bool, str], Phase] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that all forces but the water's are piecewise linear and act at one port."""
        scene = self.system.scene
        others = [name for name in self.system.not_compiled if name not in scene.laws]
        if others or scene.law is None or scene.law is not scene.forces.get(scene.take_off):
            raise ValueError(
                f"switching: received the nonlinear forces {', '.join(others) or 'none'}, needs a linear or body-exact "
                "scene with a take-off that switches"
            )

    @cached_property
    def law(self) -> TakeOff:
        """The take-off."""
        law = self.system.scene.law
        assert law is not None  # checked when made
        return law

    @cached_property
    def stop(self) -> EndStop | None:
        """The end stop, if there is one."""
        return self.system.scene.stop

    @cached_property
    def port(self) -> FloatArray:
        """Beta, the port in natural modes, shape (free,)."""
        return self.system.shapes.T @ self.law.direction

    def rate(self, stop: EndStop | None) -> float:
        """Return the fastest rate at the port [rad/s]: of modes under each spring at it, of the laws' dampers."""
        n, port, controller = self.system.free, self.port, self.law.controller
        dampers = (self.law.damping, self.law.latching_damping, stop.damping if stop else 0.0)
        rates = [c * float(port @ port) for c in dampers if np.isfinite(c)]
        squares = -self.system.matrix[n : 2 * n, :n] * self.system.scale
        for spring in {0.0, self.law.stiffness, stop.stiffness if stop else 0.0}:
            values, vectors = eigh((squares + squares.T) / 2 + spring * np.outer(port, port))
            omega = np.sqrt(np.maximum(np.abs(values), 1e-6))
            kick = (port @ vectors) ** 2 / omega
            rates.append(float(omega[kick > FELT * kick.max()].max()))
        poles = np.linalg.eigvals(controller.state_matrix) if controller else np.zeros(1)
        return max(*rates, float(np.abs(poles).max()))

    def finer(self, dt: float) -> int:
        """Return how many instants of the lookout there are in a recorded step, a power of 2."""
        return self._instants(self.rate(self.stop) * dt)

    def _instants(self, angle: float) -> int:
        """Instants that resolve an angle [rad], a power of 2."""
        apart = RESOLVED * min(max(self.tolerance / EXACT, 1.0) ** (1 / 6), COARSER)
        return int(2 ** max(0, int(np.ceil(np.log2(angle / apart)))))

    def lookout(self, time: FloatArray, finer: int) -> Lookout:
        """Return the lookout of so many instants in a recorded step; an end stop's rate counts in contact."""
        dt, whole = float(time[1] - time[0]), float(time[-1] - time[0])
        return Lookout(whole / ((len(time) - 1) * finer), self.finer(dt) // self._instants(self.rate(None) * dt))

    # pieces ---------------------------------------------------------------------------------------------------------

    def friction(self, mode: Mode) -> bool:
        """Whether the take-off is friction now."""
        return bool(np.isinf(self.law.coefficients(mode.in_latching_time)[0]))

    def taken(self, mode: Mode) -> LinearLaw:
        """Force of the take-off, except that which holds the port."""
        c, k = self.law.coefficients(mode.in_latching_time)
        if np.isinf(c):
            return LinearLaw(0.0, 0.0, -mode.way * self.law.limit if mode.way else 0.0)
        if mode.limited:
            return LinearLaw(0.0, 0.0, -mode.limited * self.law.limit)
        return LinearLaw(c, k, k * self.law.rest, float(self.law.controller is not None))

    def stopped(self, mode: Mode) -> LinearLaw:
        """Force of the end stop."""
        if not (self.stop and mode.contact):
            return LinearLaw(0.0, 0.0, 0.0)
        loading = mode.way == mode.contact
        return LinearLaw(
            self.stop.damping if loading else 0.0,
            self.stop.stiffness,
            self.stop.stiffness * (mode.contact * self.stop.stroke + self.stop.rest),
        )

    def phase(self, mode: Mode, lookout: Lookout) -> tuple[Phase, float]:
        """Return the regime of a mode, and its constant force."""
        c, k, f, output = (a + b for a, b in zip(self.taken(mode), self.stopped(mode), strict=True))
        held, step = mode.way == 0, lookout.step * lookout.steps(mode)
        key = c, k, output, held, f"{step:.9e}"  # equal in all blocks of a run but for round-off
        if key not in self.phases:
            kind = Phase if self.system.scene.water is None else WetPhase
            own = output, self.law.controller
            self.phases[key] = kind(self.system, self.port, c, k, held, step, self.law.rest, *own)
        return self.phases[key], f

    # events ---------------------------------------------------------------------------------------------------------

    def wanted(self, mode: Mode, at: Signals) -> FloatArray:
        """Return the force the spring, damper and controller want [N], before it is limited."""
        c, k = self.law.coefficients(mode.in_latching_time)
        return c * at.velocity + k * at.stroke + at.remembered

    def guards(self, mode: Mode, at: Signals, time: FloatArray) -> dict[str, FloatArray]:
        """Return the guards by event: an event occurs where its guard becomes negative."""
        out, law = {"resume": mode.until - time} if mode.in_latching_time else {}, self.law
        if mode.way:
            out["turn"] = mode.way * at.velocity
        if np.isfinite(law.limit):
            if not mode.way:
                out["slip"] = law.limit - np.abs(at.net_force)
            elif mode.limited:
                out["limit"] = mode.limited * self.wanted(mode, at) - law.limit
            elif not self.friction(mode):
                out["limit"] = law.limit - np.abs(self.wanted(mode, at))
        if self.stop:
            inside = self.stop.stroke - np.abs(at.stroke)
            out["stop"] = mode.contact * at.stroke - self.stop.stroke if mode.contact else inside
        return out

    def after(self, event: str, mode: Mode, t: float, at: Signals) -> Mode:
        """Return the mode after an event."""
        if event == "turn":
            begins = self.law.latching_time > 0 and not mode.in_latching_time
            mode = mode._replace(in_latching_time=True, until=t + self.law.latching_time, limited=0) if begins else mode
            return self.stuck(mode, at) if self.friction(mode) else mode._replace(way=-mode.way)
        if event == "slip":
            return mode._replace(way=sign(at.net_force))
        if event == "resume":
            engaged = mode._replace(in_latching_time=False, until=np.inf, way=mode.way or sign(at.net_force))
            return self.limited(engaged, at)
        if event == "limit":
            return mode._replace(limited=0) if mode.limited else self.limited(mode, at, crossed=True)
        return mode._replace(contact=0 if mode.contact else sign(at.stroke))

    def limited(self, mode: Mode, at: Signals, crossed: bool = False) -> Mode:
        """Return the mode with the piece of the spring-damper for its force."""
        if self.friction(mode):
            return mode._replace(limited=0)
        wanted = float(self.wanted(mode, at))
        return mode._replace(limited=sign(wanted) if crossed or abs(wanted) > self.law.limit else 0)

    def stuck(self, mode: Mode, at: Signals) -> Mode:
        """Return the mode of friction at rest: held, or slipping on."""
        return mode._replace(way=0 if abs(at.net_force) <= self.law.limit else sign(at.net_force))

    def signals_if_held(self, mode: Mode, t: float, state: FloatArray, lookout: Lookout) -> Signals:
        """Return the signals of the port if friction held it."""
        phase, f = self.phase(mode._replace(way=0, limited=0, in_latching_time=True) if mode.way else mode, lookout)
        return Signals(*(signal[0] for signal in phase.watched(np.array([t]), self.with_constant(f, state)[None])))

    def with_constant(self, constant: float, state: FloatArray) -> FloatArray:
        """Return (z, f, ...) with another constant force f."""
        out = state.copy()
        out[len(self.system.matrix)] = constant
        return out

    def first(self, t: float, state: FloatArray, lookout: Lookout) -> Mode:
        """Return the mode at the start of a run."""
        n = self.system.free
        stroke = self.port / self.system.scale @ state[:n] - self.law.rest
        speed = self.port @ state[n : 2 * n]
        outside = self.stop is not None and abs(stroke) > self.stop.stroke
        mode = Mode(sign(speed), contact=sign(stroke) if outside else 0)
        at = self.signals_if_held(mode, t, state, lookout)
        if speed == 0:
            mode = self.stuck(mode, at) if self.friction(mode) else mode._replace(way=sign(at.net_force))
        return self.limited(mode, at)

    # runs -----------------------------------------------------------------------------------------------------------

    def begun(
        self, phase: Phase, t: float, state: FloatArray, steps: int, rate: float
    ) -> tuple[FloatArray, float, int]:
        """Return the start of so many steps, or fewer if their error per second exceeds a rate, and their error."""
        while True:
            limit = rate * steps * phase.step
            started, error = phase.begun(t, state, steps, SAFE * limit)
            if steps == 1 or error <= SAFE * limit:
                return started, error / SAFE, steps
            steps //= 2

    def track(self, time: FloatArray, z: FloatArray, finer: int, over: float) -> tuple[Track, Mode]:
        """Return the motion at its nodes, the instants of the lookout and the events, and the mode at its end.

        Errors over a time `over` [s] may add up to the tolerance. Raises `ConvergenceError` if the take-off switches
        without end.
        """
        count, lookout = (len(time) - 1) * finer, self.lookout(time, finer)
        grid, whole = np.linspace(time[0], time[-1], count + 1), np.arange(count + 1) % lookout.stride == 0
        t, i, far, track, order = float(grid[0]), 0, CLOSE, Track(lookout), len(z)
        track.largest = max(float(np.linalg.norm(z)), self.system.least)
        start, _ = self.phase(Mode(1), lookout)
        state = start.reset(np.append(z, np.zeros(len(start.flow) - len(z))), t)
        mode = self.modes.get(t) or self.first(t, state, lookout)
        track.add(grid[:1], state[None], mode, whole[:1])
        while i < count and np.isfinite(track.error):
            phase, f = self.phase(mode, lookout)
            rate = self.tolerance * track.largest / over
            state, error, far = self.begun(phase, t, self.with_constant(f, state), min(far, phase.reach), rate)
            track.leave(state, error)
            transient = phase.transient(t, state)
            even = t == grid[i] and i % lookout.steps(mode) == 0
            seen = lookout.ahead(mode, i, far if even else 1)
            ahead = grid[seen]
            transients = phase.ahead[: len(ahead)] @ transient if even else phase.later(transient, ahead[0] - t)[None]
            states = phase.states(ahead, transients)
            ends = np.append(t, ahead), np.vstack([state, states]), np.vstack([transient, transients])
            passed, broken = self.undisturbed(mode, phase, *ends)
            track.add(ahead[:passed], states[:passed], mode, whole[seen][:passed])
            largest = float(np.linalg.norm(states[: passed + 1, :order], axis=1).max())
            track.largest = max(track.largest, largest)
            if broken:
                far = min(far, CLOSE)
            elif GROWTH * error <= rate * far * phase.step:
                far *= 2
            if passed:
                t, i = float(ahead[passed - 1]), range(count + 1)[seen][passed - 1]
                state, transient = states[passed - 1], transients[passed - 1]
            if broken:
                span, event = self.next_event(broken, mode, phase, t, transient, float(ahead[passed]) - t)
                t += span
                state = phase.states(np.array([t]), phase.later(transient, span)[None])[0]
                mode = self.after(event, mode, t, self.signals_if_held(mode, t, state, lookout))
                if not mode.way:  # friction has stopped the port exactly
                    rates = slice(self.system.free, 2 * self.system.free)
                    state[rates] -= self.port * (self.port @ state[rates]) / (self.port @ self.port)
                track.switch(t, state, mode)
                i = max(i, int(np.searchsorted(grid, t)) - 1)
                if len(track.events) > MOST_EVENTS * (1 + i / finer):
                    raise ConvergenceError(
                        f"the take-off switches without end at t = {t:.6g} s; use a larger force_limit or a softer law"
                    )
        return track, mode

    def tracked(self, time: FloatArray, start: tuple[FloatArray, ...], whole: float = 0.0) -> tuple[Track, int]:
        """Return the motion at its nodes, and the number of instants of the lookout in a recorded step.

        `whole` is the duration of the run these instants are of, if they are a part [s]. Raises `ConvergenceError` if a
        body-exact motion is not followed to the tolerance with the finest lookout.
        """
        duration = float(time[-1] - time[0])
        over = min(whole or duration, self.system.horizon)
        finer, z = self.finer(float(time[1] - time[0])), self.system.first(start)
        while True:
            track, mode = self.track(time, z, finer, over)
            if track.error <= self.tolerance * track.largest * duration / over:
                self.modes[float(time[-1])] = mode
                return track, finer
            if finer >= 2**FINEST:
                raise ConvergenceError(
                    f"the motion under a take-off that switches is not followed to {self.tolerance:g} by steps of "
                    f"{track.lookout.step:.2g} s; raise simulation.tolerance"
                )
            finer *= 2

    def undisturbed(
        self, mode: Mode, phase: Phase, time: FloatArray, states: FloatArray, transients: FloatArray
    ) -> tuple[int, dict[str, float]]:
        """Return the number of spans without event, and the guards negative in the next one with the part of it.

        Guards are negative at the end of a span, or at the minimum of a dip inside it. Time, states and transients
        start at the beginning of the first span.
        """
        at, span = phase.watched(time, states), time[-1] - time[-2]
        guards = self.guards(mode, at, time)
        parts = np.where(np.array(list(guards.values()))[:, 1:] < 0, 1.0, np.nan)
        for name, rate in self.rates(mode, at).items():
            for k, part in dips(guards[name], span * rate):
                bottom = self.guard(name, mode, phase, float(time[k]), transients[k], part * span)
                parts[list(guards).index(name), k] = part if bottom < 0 else np.nan
        first = int(np.argmax(np.append(np.isfinite(parts).any(axis=0), True)))
        crossed = zip(guards, parts[:, first], strict=True) if first < parts.shape[1] else ()
        return first, {name: float(part) for name, part in crossed if np.isfinite(part)}

    def rates(self, mode: Mode, at: Signals) -> dict[str, FloatArray]:
        """Return the rates of the guards for which they are known."""
        out, law = {}, self.law
        gained = at.net_force * float(self.port @ self.port)  # V'
        if mode.way:
            out["turn"] = mode.way * gained
            if np.isfinite(law.limit) and not self.friction(mode):
                c, k = law.coefficients(mode.in_latching_time)
                sign = mode.limited or -np.sign(self.wanted(mode, at))
                out["limit"] = sign * (c * gained + k * at.velocity + at.remembered_rate)
        if self.stop:
            out["stop"] = at.velocity * (mode.contact or -np.sign(at.stroke))
        return out

    def guard(self, name: str, mode: Mode, phase: Phase, t: float, transient: FloatArray, s: float) -> float:
        """Return a guard at a time s after an instant with a given transient."""
        at, here = np.array([t + s]), phase.later(transient, s)[None]
        return float(self.guards(mode, phase.watched(at, phase.states(at, here)), at)[name][0])

    def next_event(
        self, broken: dict[str, float], mode: Mode, phase: Phase, t: float, transient: FloatArray, span: float
    ) -> tuple[float, str]:
        """Return the time in a span when the first of some guards vanishes, and its event."""

        def guard(s: float, name: str) -> float:
            return self.guard(name, mode, phase, t, transient, s)

        zeros = []
        for name, part in broken.items():
            end = part * span
            start = 0.0 if guard(0.0, name) > 0 else SOON * end  # a guard vanishes at the event that sets it up
            if guard(start, name) <= 0:
                zero = 0.0
            elif guard(end, name) >= 0:  # negative by round-off alone
                zero = end
            else:
                zero = float(brentq(guard, start, end, (name,), xtol=1e-15 * span, rtol=1e-15, maxiter=1000))
            zeros.append((zero, name))
        return min(zeros)

    def follow(self, time: FloatArray, start: tuple[FloatArray, ...]) -> tuple[Motion, int]:
        """Return the motion at equally spaced instants, from its start or a leg's end, and the number of switches.

        Raises `ConvergenceError` if the take-off switches without end, or a body-exact motion is not followed to the
        tolerance.
        """
        steps = len(time) - 1
        block = max(1, AT_ONCE // self.finer(float(time[1] - time[0])))
        blocks, switches = [], 0
        for first in range(0, steps, block):
            instants = time[first : first + block + 1]
            motion, more = self._block(instants, start, float(time[-1] - time[0]))
            blocks.append(motion)
            start, switches = (motion.position[-1], motion.velocity[-1], motion.memory[-1]), switches + more
        return joined(blocks), switches

    def _block(self, time: FloatArray, start: tuple[FloatArray, ...], whole: float) -> tuple[Motion, int]:
        """Motion and number of switches of a part of a run of some duration [s]."""
        begun = clock.perf_counter()
        track, finer = self.tracked(time, start, whole)
        nodes, states, leaving = (np.concatenate(part) for part in (track.times, track.states, track.leaving))
        regular = np.concatenate(track.regular)
        accounts = account(self.system, nodes, states, leaving, self.pieces(track), regular)
        recorded = np.flatnonzero(regular)[:: finer // track.lookout.stride]
        n, z, name = self.system.free, states[recorded], self.system.scene.take_off
        forces = {
            key: np.outer(accounts.taken[recorded] if key == name else accounts.stopped[recorded], law.direction)
            for key, law in self.system.scene.laws.items()
        }
        position, works = z[:, :n] @ self.system.position.T, dict(zip(TERMS, accounts.works[:, recorded], strict=True))
        held = self.system.beyond_tangents(position)
        spring = self.law.potential_energy(position @ self.system.scene.motions.T)
        motion = Motion(
            time,
            position,
            z[:, n : 2 * n] @ self.system.modes.T,
            accounts.rates[recorded] @ self.system.modes.T,
            z[:, 2 * n : len(self.system.matrix)],
            clock.perf_counter() - begun,
            forces,
            works | {"wave": works["wave"] + held - held[0], "pto": works["pto"] - spring + spring[0]},
        )
        return motion, len(track.events)

    def pieces(self, track: Track) -> dict[Piece, list[int]]:
        """Return the nodes from which each piece is in force, ascending."""
        nodes: dict[Mode, list[int]] = {}
        for k, mode in enumerate(track.modes):
            nodes.setdefault(mode, []).append(k)
        out: dict[Piece, list[int]] = {}
        for mode, own in nodes.items():
            phase, _ = self.phase(mode, track.lookout)
            out.setdefault(Piece(phase, self.taken(mode), self.stopped(mode)), []).extend(own)
        return {piece: sorted(own) for piece, own in out.items()}


# mean power once the motion is periodic -----------------------------------------------------------------------------


RECORDED = 16
"""Recorded instants of a period."""
FEWEST, MOST = 16, 64
"""Periods followed at first, and at most at a time; each time twice as many."""
MOST_INSTANTS = 2**15
"""Most instants of a period at which switches are looked for: more would take hours for a steady state."""
CONTINUED = 8
"""Periods followed at first from the end of another motion."""
FOLLOWED = 0.1
"""Tolerance of the motion over that of its mean power."""
Start = tuple[FloatArray, ...]
"""y [m], y' [m/s] and memory states."""


def periodic_power(system: System, tolerance: float = 1e-6) -> tuple[float, float]:
    """Return the mean absorbed power of a scene in a regular wave [W], starting at rest, and its unsteadiness.

    Over whole periods, the last quarter of the run. The unsteadiness is the largest relative difference between periods
    of its last half: above the tolerance the motion is not periodic, or its transient outlasts the run. Raises
    `ConfigError` if the sea is not one regular wave; `ConvergenceError` if the port responds so fast that a period
    needs more than `MOST_INSTANTS` instants.
    """
    step = 2 * np.pi / regular_frequency(system) / RECORDED
    runner = Switching(system)
    if (instants := RECORDED * runner.finer(step)) > MOST_INSTANTS:
        raise ConvergenceError(
            f"no steady state was computed: the port responds at {runner.rate(runner.stop):.3g} rad/s, so each "
            f"period needs {instants} instants, needs at most {MOST_INSTANTS}; leave out stiff modes "
            "or soften the shell"
        )
    power, unsteady, _ = _follow(system, tolerance, system.scene.start(0.0, 0.0), FEWEST, MOST)
    return power, unsteady


@dataclass
class Trials:
    """Periodic powers of one scene under several laws, each motion started from the end of the best one so far.

    A law may have several periodic motions: started from one that absorbs little it may stay in such a one. After
    `CONTINUED` and `FEWEST` further periods the power is used as it is.
    """

    tolerance: float  # largest relative difference between late periods
    most: float = -np.inf  # [W]
    ended: Start | None = None  # the end of its motion

    def power(self, system: System) -> float:
        """Return the mean absorbed power of late periods [W]; 0 if the motion cannot be followed."""
        start = self.ended or system.scene.start(0.0, 0.0)
        try:
            power, _, ended = _follow(system, self.tolerance, start, CONTINUED, FEWEST)
        except ConvergenceError:
            return 0.0
        if power > self.most:
            self.most, self.ended = power, ended
        return power


def _follow(system: System, tolerance: float, start: Start, fewest: int, most: int) -> tuple[float, float, Start]:
    """Mean power of late periods of a motion started at a crest, their difference, and the end of the motion."""
    period, runner = 2 * np.pi / regular_frequency(system), Switching(system, max(FOLLOWED * tolerance, EXACT))
    begin, count = 0.0, fewest
    while True:
        end = begin + count * period
        motion, _ = runner.follow(np.linspace(begin, end, count * RECORDED + 1), start)
        half = (np.diff(motion.works["pto"][::RECORDED]) / period)[count // 2 :]
        unsteady = float(np.ptp(half) / max(np.abs(half).max(), np.finfo(float).tiny))
        start = (motion.position[-1], motion.velocity[-1], motion.memory[-1])
        if unsteady <= tolerance or count >= most:
            return float(half[count // 4 :].mean()), unsteady, start
        begin, count = end, 2 * count
