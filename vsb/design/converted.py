"""The year's mean power after conversion: a take-off of damper and spring whose two directions of power both lose.

In a sea in which its velocity has the mean square v and its displacement x, a take-off -(c V + k X) absorbs A = c v and
moves B = |k| sqrt(x v) to and fro. Of Gaussian motions it returns R = (B - A theta)/pi, tan theta = B/A, to the sea
(`vsb.engine.motion.tuning.converted_power`), so that with an efficiency eta of both directions

    P = sum over seas of share [eta A - (1/eta - eta) R],
    dR = [sin^2 theta dB - (theta - sin theta cos theta) dA]/pi.

P depends on more of the seas than their mean spectrum, unless k = 0: then P = eta A. With |u|^2 = |u_0|^2/E(c), E(c) a
polynomial (`vsb.design.year.PortYear`), all of it is analytic in c.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from vsb.design.fatigue import SeaMoments
from vsb.design.resting import STEP
from vsb.design.year import PortYear
from vsb.tools.arrays import AnyArray, FloatArray

AROUND = np.logspace(-3.0, 3.0, 61)
"""Dampers tried, over the one that is optimal without losses."""
NEWTON_STEPS = 3


@dataclass(frozen=True)
class ConvertedYear:
    """The port of a buoy over the seas of a year, its take-off's power after conversion."""

    port: PortYear
    seas: SeaMoments
    efficiency: float
    spring: float  # k [N/m]

    def of_seas(self, damper: AnyArray | float) -> AnyArray:
        """Return the mean power of a damper in each sea, shape (sea,) [W]."""
        to_and_fro, absorbed, theta, _ = self._turned(damper)
        return np.asarray(self.efficiency * absorbed - self._lost * (to_and_fro - absorbed * theta) / np.pi)

    def slopes(self, damper: complex, spring_change: FloatArray) -> AnyArray:
        """Return the derivatives of the mean power by the variables at a fixed damper, and by it, (variable + 1,).

        Parameters
        ----------
        damper : complex [N s/m]
        spring_change : ndarray, shape (variable,)
            Derivatives of the spring.
        """
        w, (flat, bend, e), free = self.port.grid.omega, self._around(damper), np.abs(self.port.motion) ** 2
        to_and_fro, absorbed, theta, (x, v) = self._turned(damper)
        size = absorbed**2 + to_and_fro**2
        sine, both = _ratio(to_and_fro**2, size), _ratio(absorbed * to_and_fro, size)
        by_b = -self.seas.climate.hours * self._lost * sine / np.pi
        by_a = self.seas.climate.hours * (self.efficiency + self._lost * (theta - both) / np.pi)
        swing = np.sqrt(_ratio(x, v))
        by_v = by_a * damper + by_b * abs(self.spring) * swing / 2
        by_x = by_b * abs(self.spring) * _ratio(np.ones_like(swing), swing) / 2
        weight = self.seas.back(by_x) + w**2 * self.seas.back(by_v)
        y, y_change = self.port.receptance, self.port.receptance_change
        e_change = 2 * w * y_change.imag * damper + 2 * (w * damper) ** 2 * (y.conj() * y_change).real
        change = 2 * (self.port.motion.conj() * self.port.motion_change).real / e - free * e_change / e**2
        by_spring = np.sign(self.spring) * (by_b @ np.sqrt(x * v))
        by_damper = by_a @ v - weight @ (free * (flat + 2 * damper * bend) / e**2)
        return np.append(change @ weight + spring_change * by_spring, by_damper)

    @cached_property
    def optimal_damping(self) -> float:
        """The damper with the most power [N s/m]."""
        none = np.zeros(len(self.port.motion_change))
        tried = self.port.optimal_damping * AROUND
        best = int(np.argmax([self.seas.climate.hours @ self.of_seas(c) for c in tried]))

        def slope(c: float) -> float:
            return float(np.real(self.slopes(c, none)[-1]))

        low, high = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
        found = float(brentq(slope, low, high, rtol=1e-8)) if slope(low) > 0 > slope(high) else float(tried[best])
        for _ in range(NEWTON_STEPS):
            found *= float(np.exp(-slope(found) / (self._bend(found, none)[-1] * found)))
        return found

    def optimal_damping_change(self, spring_change: FloatArray) -> FloatArray:
        """Return its derivatives by the variables, -(d2P/dc dx)/(d2P/dc2), shape (variable,)."""
        bend = self._bend(self.optimal_damping, spring_change)
        return np.asarray(-bend[:-1] / bend[-1])

    def _bend(self, c: float, spring_change: FloatArray) -> FloatArray:
        """Derivatives of `slopes` by the damper, by the complex step."""
        return np.asarray(np.imag(self.slopes(c * (1 + 1j * STEP), spring_change)) / (c * STEP))

    @property
    def _lost(self) -> float:
        return 1 / self.efficiency - self.efficiency

    def _around(self, c: AnyArray | complex) -> tuple[FloatArray, FloatArray, AnyArray]:
        """Coefficients of E by c and c^2, and E, each shape (omega,)."""
        w, y = self.port.grid.omega, self.port.receptance
        flat, bend = 2 * w * y.imag, (w * np.abs(y)) ** 2
        return flat, bend, np.asarray(1 + flat * c + bend * c**2)

    def _turned(self, c: AnyArray | complex) -> tuple[AnyArray, AnyArray, AnyArray, tuple[AnyArray, AnyArray]]:
        """B, A and theta in each sea, and x and v."""
        square = np.abs(self.port.motion) ** 2 / self._around(c)[2]
        x, v = self.seas.of(square), self.seas.of(square * self.port.grid.omega**2)
        absorbed, to_and_fro = c * v, abs(self.spring) * np.sqrt(x * v)
        return to_and_fro, absorbed, np.arctan(_ratio(to_and_fro, absorbed)), (x, v)


def _ratio(one: AnyArray, other: AnyArray) -> AnyArray:
    """One over another, 0 in still water."""
    return np.asarray(np.divide(one, other, out=np.zeros_like(other), where=other != 0))
