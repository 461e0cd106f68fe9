"""A switching run as it is found: its nodes, and which pieces of the laws are in force from each of them on."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vsb.tools.units import FloatArray


class Mode(NamedTuple):
    """Which pieces of the laws are in force."""

    way: int  # sign of V; 0: the port is held at rest
    limited: int = 0  # sign of the spring-damper's force where it is at its limit; else 0
    contact: int = 0  # side of the stop that is pressed, or 0
    paused: bool = False
    until: float = np.inf  # end of the pause [s]


@dataclass
class Track:
    """Nodes of a run as they are found; each with the mode from there on."""

    step: float  # between instants of the lookout [s]
    times: list[FloatArray] = field(default_factory=list)
    states: list[FloatArray] = field(default_factory=list)
    leaving: list[FloatArray] = field(default_factory=list)  # as the next step begins
    regular: list[npt.NDArray[np.bool_]] = field(default_factory=list)
    modes: list[Mode] = field(default_factory=list)
    error: float = 0.0  # of all steps together, in the norm of the state

    def add(self, times: FloatArray, states: FloatArray, mode: Mode, regular: bool) -> None:
        """Add nodes of one mode."""
        self.times.append(times)
        self.states.append(states)
        self.leaving.append(states)
        self.regular.append(np.full(len(times), regular))
        self.modes += [mode] * len(times)

    def leave(self, state: FloatArray, error: float) -> None:
        """Note how a step leaves the last node, and its error."""
        self.leaving[-1] = np.vstack([self.leaving[-1][:-1], state[None]])
        self.error += error

    @property
    def largest(self) -> float:
        """Largest norm of the states."""
        return max(float(np.linalg.norm(states, axis=1).max(initial=0.0)) for states in self.states)
