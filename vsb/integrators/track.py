"""A switching run as it is found: its nodes, and which pieces of the laws are in force from each of them on."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from vsb.tools.arrays import BoolArray, FloatArray

SOON = 2.0**-20
"""Part of a span after which a guard that has just vanished shows, above round-off, which way it goes."""


def sign(value: FloatArray | float) -> int:
    """Return the sign of a number, 1 of zero."""
    return 1 if value >= 0 else -1


class Mode(NamedTuple):
    """Which pieces of the laws are in force."""

    way: int  # sign of V; 0: the port is held at rest
    limited: int = 0  # sign of the spring-damper's force where it is at its limit; else 0
    contact: int = 0  # side of the stop that is pressed, or 0
    paused: bool = False
    until: float = np.inf  # end of the pause [s]


class Lookout(NamedTuple):
    """How far apart the instants are at which events are looked for."""

    step: float  # where the stop is pressed [s]
    stride: int = 1  # of these steps at once where it is not, a power of 2

    def steps(self, mode: Mode) -> int:
        """Return how many steps at once a mode takes."""
        return 1 if mode.contact else self.stride

    def apart(self, mode: Mode) -> float:
        """Return how far apart the instants of a mode are [s]."""
        return self.step * self.steps(mode)

    def ahead(self, mode: Mode, i: int, far: int) -> slice:
        """Return which steps a mode looks at next, at most so many, from the i-th step on or some time after it."""
        stride = self.steps(mode)
        first = (i // stride + 1) * stride
        return slice(first, first + far * stride, stride)


@dataclass
class Track:
    """Nodes of a run as they are found; each with the mode from there on."""

    lookout: Lookout
    times: list[FloatArray] = field(default_factory=list)
    states: list[FloatArray] = field(default_factory=list)
    leaving: list[FloatArray] = field(default_factory=list)  # as the next step begins
    regular: list[BoolArray] = field(default_factory=list)  # which are whole strides apart
    modes: list[Mode] = field(default_factory=list)
    error: float = 0.0  # of all steps together, in the norm of the state
    events: list[float] = field(default_factory=list)  # when pieces changed [s]

    def add(self, times: FloatArray, states: FloatArray, mode: Mode, regular: BoolArray) -> None:
        """Add nodes of one mode."""
        self.times.append(times)
        self.states.append(states)
        self.leaving.append(states)
        self.regular.append(regular)
        self.modes += [mode] * len(times)

    def switch(self, t: float, state: FloatArray, mode: Mode) -> None:
        """Add the node of an event, from which another mode is on."""
        self.events.append(t)
        self.add(np.array([t]), state[None], mode, np.array([False]))

    def leave(self, state: FloatArray, error: float) -> None:
        """Note how a step leaves the last node, and its error."""
        self.leaving[-1] = np.vstack([self.leaving[-1][:-1], state[None]])
        self.error += error

    def nodes(self) -> dict[Mode, list[int]]:
        """Return the nodes of each mode."""
        out: dict[Mode, list[int]] = {}
        for k, mode in enumerate(self.modes):
            out.setdefault(mode, []).append(k)
        return out

    @property
    def largest(self) -> float:
        """Largest norm of the states."""
        return max(float(np.linalg.norm(states, axis=1).max(initial=0.0)) for states in self.states)


def dips(values: FloatArray, rates: FloatArray) -> list[tuple[int, float]]:
    """Return the spans in which a guard, positive at both ends, is likely to dip below zero, and where it is lowest.

    Parameters
    ----------
    values, rates : ndarray, shape (span + 1,)
        At the ends of spans; rates per span.

    Returns
    -------
    list of (span, part of it)

    Notes
    -----
    Of the cubic through values and rates; where the rates are of one sign there is no bottom inside. A bottom right
    behind the begin is round-off of the event there: friction lets go with neither velocity nor acceleration.
    """
    found = []
    for k in np.flatnonzero((values[:-1] > 0) & (values[1:] >= 0) & (rates[:-1] < 0) & (rates[1:] > 0)):
        low, high, falling, rising = values[k], values[k + 1], rates[k], rates[k + 1]
        bend, twist = 3 * (high - low) - 2 * falling - rising, 2 * (low - high) + falling + rising
        root = np.sqrt(max(bend**2 - 3 * twist * falling, 0.0))
        # The root of the slope at which it rises, written so that a parabola, without a twist, is no special case.
        part = float(-falling / (bend + root) if bend > 0 else (root - bend) / (3 * twist))
        if part > SOON and low + part * (falling + part * (bend + part * twist)) < 0:
            found.append((int(k), part))
    return found
