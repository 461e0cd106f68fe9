"""How the optimum of a causal controller changes with its port and with its sea.

Of the objective L, power less weights times mean squares, the logarithm of the phasors G is a sum of logarithms
(`vsb.engine.motion.causal`), so that first and second derivatives of L have a closed form. The controller is the best
one at given weights: its own change does not count in dL (envelope theorem), and the slopes of L by the weights are
less the mean squares. At given limits the weights of those that bind follow from d(mean square) = 0, and the power from
dP = dL at fixed weights + weights times d(mean square).
"""

from typing import NamedTuple

import numpy as np

from vsb.engine.motion.causal import LEAST_WEIGHT, STEADY, Controlled, StationaryPort, Tail, Weights
from vsb.tools.arrays import ComplexArray, FloatArray


class Slopes(NamedTuple):
    """Derivatives of an optimum within limits by some variables, each shape (variable,)."""

    power: FloatArray
    force: FloatArray  # of the mean square of the force
    stroke: FloatArray  # of that of the displacement


def slopes(
    port: StationaryPort,
    found: Controlled,
    admittance: ComplexArray,
    spectrum: FloatArray,
    noise: float,
    forecast: float,
    *,
    steadiest: bool = False,
) -> Slopes:
    """Return the derivatives of an optimum of `vsb.engine.motion.causal.optimum` without losses in conversion.

    Parameters
    ----------
    port, found : StationaryPort, Controlled
    admittance, spectrum : ndarray, shape (variable, omega)
        Derivatives of the admittance [m/(N s)] and of the density of the free velocity [m^2/s].
    steadiest : bool
        Of one of `vsb.engine.motion.causal.steadiest` instead.
    """
    weights = np.array([found.weights.force, found.weights.stroke])
    largest = int(port.admittance.real.argmax())
    binds = weights > [LEAST_WEIGHT * float(port.admittance.real[largest]), np.inf if steadiest else 0.0]
    swung = int(np.abs(port.admittance * port.omega).argmax())
    objective = _Objective(port, found.weights, noise, forecast)
    by_weights = objective.by_force, objective.by_stroke
    bend = np.array([[objective.second(one, other) for other in by_weights] for one in by_weights])
    power, squares = np.empty(len(admittance)), np.empty((2, len(admittance)))
    for i, change in enumerate(map(objective.by_port, admittance, spectrum)):
        mixed = np.array([objective.second(one, change) for one in by_weights])
        moved = np.array([LEAST_WEIGHT * admittance[i, largest].real, 0.0])  # weights that do not bind
        if steadiest:
            grown = float((admittance[i, swung] / port.admittance[swung]).real)
            moved[1] = -STEADY * port.stroke_weight * grown
        moved[binds] = 0.0
        moved[binds] = -np.linalg.solve(bend[np.ix_(binds, binds)], (mixed + bend @ moved)[binds])
        squares[:, i] = np.where(binds, 0.0, -mixed - bend @ moved)
        power[i] = objective.first(change) + weights @ squares[:, i]
    return Slopes(power, *squares)


class _Change(NamedTuple):
    """Derivatives by a weight or a variable, each shape (omega,)."""

    log: ComplexArray  # of log G
    cost: FloatArray  # of |W|^2
    cross: ComplexArray  # of 1/conj(Y) + 2 kappa
    kappa: FloatArray
    size: FloatArray  # of |Y|^2
    spectrum: FloatArray  # of S_v


class _Objective:
    """The objective of a controller at given weights, int |the part of G at t >= -T|^2 - int kappa S_v."""

    def __init__(self, port: StationaryPort, weights: Weights, noise: float, forecast: float) -> None:
        self.port, self.noise = port, noise
        self.cost, self.kappa = port.cost(weights)
        self.cross = 1 / port.admittance.conj() + 2 * self.kappa
        self.g = port.wanted(weights, noise, forecast)
        self.tail = Tail(port, self.g)
        none, size = np.zeros_like(self.kappa), np.abs(port.admittance) ** 2
        at, still = 1 / port.omega**2, none.astype(complex)
        self.by_force = self._change(still, none + 1, still, none, none, none)
        self.by_stroke = self._change(still, at * size, (2 * at).astype(complex), at, none, none)

    def _change(self, log: ComplexArray, cost: FloatArray, cross: ComplexArray, *others: FloatArray) -> _Change:
        """A change, with what follows from those of |W|^2 and of 1/conj(Y) + 2 kappa."""
        of_cost = np.conj(self.port.causal_part(0.5 * cost / self.cost))
        return _Change(log + cross / self.cross - of_cost, cost, cross, *others)

    def by_port(self, admittance: ComplexArray, spectrum: FloatArray) -> _Change:
        """Return the change by those of admittance and density."""
        port, y, s_e = self.port, self.port.admittance, self.port.excitation
        share = np.divide(spectrum, port.spectrum, out=np.zeros_like(spectrum), where=port.spectrum > 0)
        excitation, peak = s_e * (share - 2 * np.real(admittance / y)), int(s_e.argmax())
        density = (excitation + self.noise * excitation[peak]) / (s_e + self.noise * s_e[peak])
        size = 2 * np.real(y.conj() * admittance)
        log, cost = share - np.conj(port.causal_part(0.5 * density)), admittance.real + self.kappa * size
        return self._change(log, cost, -np.conj(admittance / y**2), np.zeros_like(size), size, spectrum)

    def first(self, change: _Change) -> float:
        """Return the derivative of the objective by a change of the port."""
        paid = self.port.integral(self.kappa * change.spectrum)
        return 2 * self.tail.square(Tail(self.port, self.g * change.log)) - paid

    def second(self, weight: _Change, other: _Change) -> float:
        """Return the second derivative by a weight and another change."""
        of_cost = weight.kappa * other.size / self.cost - weight.cost * other.cost / self.cost**2
        bend = -weight.cross * other.cross / self.cross**2 - np.conj(self.port.causal_part(0.5 * of_cost))
        one, two, both = (
            Tail(self.port, self.g * log) for log in (weight.log, other.log, weight.log * other.log + bend)
        )
        paid = self.port.integral(weight.kappa * other.spectrum)
        return 2 * (one.square(two) + self.tail.square(both)) - paid
