"""Take-off laws in time and end stops: piecewise linear forces at a port, against its stroke S = b.q and velocity V.

One form serves all laws: a spring and a damper whose force is limited, F = -clip(c V + k S, -limit, limit). Without a
limit it is the linear take-off; an infinite c is friction, which holds the port at rest as long as the limit lets it
(Coulomb's law, a hydraulic take-off of constant pressure). Whenever the port comes to rest the law may pause: held by
friction it is latched, without any force declutched.
"""

from dataclasses import dataclass

import numpy as np

from vsb.motion.forces import Force, Linear
from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class TakeOff(Force):
    """f = -b clip(c V + k S, -limit, limit); for a pause after each reversal of V, c is another and k is 0.

    Only an integrator knows what friction does at rest, and when the law pauses: it gives the force with the motion.

    Raises
    ------
    ValueError
        Of friction without a limit: it would never move.
    """

    direction: FloatArray  # b (dof,) [-]
    damping: float  # c [kg/s]; infinite: friction
    stiffness: float = 0.0  # k [N/m]
    limit: float = np.inf  # [N]
    pause: float = 0.0  # length [s]
    paused_damping: float = np.inf  # c in the pause [kg/s]; infinite: latched, 0: declutched
    rest: float = 0.0  # S at rest, from where the spring counts [m]

    def __post_init__(self) -> None:
        """Check that the port moves."""
        if np.isinf(self.damping) and not 0 < self.limit < np.inf:
            raise ValueError(f"friction: received a limit of {self.limit:g} N, needs a finite one above 0")

    def linear(self) -> Linear:
        """Nothing: what is linear of it changes along the motion."""
        return Linear(whole=False)

    def coefficients(self, paused: bool) -> tuple[float, float]:
        """Return c and k, in a pause or out of it."""
        return (self.paused_damping, 0.0) if paused else (self.damping, self.stiffness)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the law out of its pauses; of friction at rest nothing."""
        speed = v @ self.direction
        if np.isinf(self.damping):
            wanted = self.limit * np.sign(speed)
        else:
            wanted = np.clip(
                self.damping * speed + self.stiffness * (q @ self.direction - self.rest), -self.limit, self.limit
            )
        return np.asarray(-np.outer(wanted, self.direction))


@dataclass(frozen=True)
class EndStop(Force):
    """A spring beyond a stroke of either sign, and a damper while it is being loaded: it pushes and never pulls."""

    direction: FloatArray  # b (dof,) [-]
    stroke: float  # [m]
    stiffness: float  # [N/m]
    damping: float  # [kg/s]
    rest: float = 0.0  # S at rest, from where the stroke counts [m]

    def linear(self) -> Linear:
        """Nothing: most of the time it is not there."""
        return Linear(whole=False)

    def beyond(self, q: FloatArray) -> FloatArray:
        """Return how far the stop is pressed in, with the sign of the stroke, shape (time,) [m]."""
        stroke = q @ self.direction - self.rest
        return np.asarray(np.sign(stroke) * np.maximum(np.abs(stroke) - self.stroke, 0.0))

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return what the stop does."""
        pressed, speed = self.beyond(q), v @ self.direction
        loading = self.damping * speed * (pressed * speed > 0)
        return np.asarray(-np.outer(self.stiffness * pressed + loading, self.direction))

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return the energy of its spring."""
        return np.asarray(0.5 * self.stiffness * self.beyond(q) ** 2)
