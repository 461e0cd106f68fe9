"""Optimal control of one port by a controller that does not know the future waves (Wiener and Hopf).

In a stationary sea the port moves with velocity V = V0 - Y F. The controller measures the Thevenin force F_e = V0/Y,
which it reconstructs from the motion and its own past force, with white noise, and knows it up to T seconds ahead.
Among all linear controllers it maximises

    E[F V] - lambda E[F^2] - mu E[S^2] - gamma E[V^2],

S the displacement. With the one-sided densities S_v of V0, S_e = S_v/|Y|^2 of F_e and S_n of the noise, and
kappa = gamma + mu/omega^2, let H and W be the causal factors without zeros of

    |H|^2 = S_e + S_n,   |W|^2 = Re Y + lambda + kappa |Y|^2,

so that F_e + noise = H e with white innovations e. A force F = Q e then has the objective

    int |G|^2 - int |W Q - G|^2 - int kappa S_v,   G = S_v (1/conj(Y) + 2 kappa)/(2 conj(H) conj(W)):

with the future known W Q = G, otherwise W Q is the part of G at times t >= -T. The weights are found such that force
and displacement have given rms values: the means of F^2, S^2 and V^2 are the slopes of the optimum by the weights.
Phasors are Re(. exp(-i omega t)) (C1): what is causal is analytic in the upper half plane.

A spectrum that vanishes as fast as exp(-omega^-4), like those of seas, has no factor H without noise: such a sea could
be predicted from its past without error (Paley and Wiener). So the noise is part of the result. See J. T. Scruggs,
S. M. Lattanzio, A. A. Taflanidis and I. L. Cassidy, Optimal causal control of a wave energy converter in a random sea,
Applied Ocean Research 42 (2013), which solves the same problem with rational models and a Riccati equation.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol, Self

import numpy as np
from scipy.fft import fft, ifft
from scipy.optimize import brentq

from vsb.engine.motion.tuning import converted_power
from vsb.errors import StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray

NOISE = 1e-5
"""Default density of the noise, over the peak of that of the Thevenin force: -50 dB."""
LEAST_WEIGHT = 1e-6
"""Least weight lambda of the squared force, over the largest Re Y: with less, a force of an unlimited band costs
nothing."""
STEADY = 1e3
"""Weight of displacement over `StationaryPort.stroke_weight` with which it is its least to about 1e-5."""
MOST_WEIGHT = 1e12
"""Largest weights tried, over those where a limit is certain to hold."""
ROOT = 1e-10
"""Tolerance of the logarithm of a weight."""
KEPT = 1e-6
"""Relative tolerance on a limit."""
REPEATED, SAME_POWER = 40, 1e-9
"""With losses in conversion: most repetitions, and the relative change of power after which they end."""


class Weights(NamedTuple):
    """What the controller pays for its force, for displacement and for velocity."""

    force: float  # lambda [m/(N s)]
    stroke: float = 0.0  # mu [N/(m s)]
    speed: float = 0.0  # gamma [N s/m]


class Controlled(NamedTuple):
    """Mean power and mean squares under an optimal controller."""

    power: float  # at the port [W]
    force: float  # mean square of the force [N^2]
    stroke: float  # of the displacement [m^2]
    speed: float  # of the velocity [m^2/s^2]
    weights: Weights

    @property
    def force_rms(self) -> float:
        """Root mean square of the force [N]."""
        return float(np.sqrt(max(self.force, 0.0)))

    @property
    def stroke_rms(self) -> float:
        """Root mean square of the displacement [m]."""
        return float(np.sqrt(max(self.stroke, 0.0)))

    @property
    def objective(self) -> float:
        """Power less what the weights cost [W]: to first order, at given mean squares, it changes as the power does."""
        return self.power - float(np.dot(self.weights, (self.force, self.stroke, self.speed)))

    def converted(self, efficiency: float) -> float:
        """Return the mean power after conversion with an efficiency of both directions [W]."""
        if efficiency == 1.0:
            return self.power
        size = np.asarray(np.sqrt(max(self.force * self.speed, 0.0)))
        return float(converted_power(np.asarray(self.power), size, efficiency))


@dataclass(frozen=True)
class StationaryPort:
    """A port in a stationary sea, at the frequencies (k + 1/2) spacing.

    Signals of these frequencies change sign after 2 pi/spacing, which must be longer than they remember. The band must
    extend to where the spectrum of the free velocity is small; beyond it the port may be continued (`extended`).
    """

    spacing: float  # [rad/s]
    admittance: ComplexArray  # Y (omega,) [m/(N s)]
    spectrum: FloatArray  # S_v, one-sided density of the free velocity (omega,) [m^2/s]

    def __post_init__(self) -> None:
        """Check that the port is passive and its spectrum a density."""
        if self.spacing <= 0 or not np.all(self.admittance.real >= 0):
            raise ValueError(
                "port: not passive, or its frequencies do not ascend; needs Re Y >= 0 and a spacing above 0"
            )
        if not np.all(self.spectrum >= 0):
            raise ValueError("spectrum: received a negative density; needs at least 0")

    @cached_property
    def omega(self) -> FloatArray:
        """Angular frequencies, shape (omega,) [rad/s]."""
        return (np.arange(len(self.admittance)) + 0.5) * self.spacing

    @property
    def step(self) -> float:
        """Time step of signals [s]."""
        return float(np.pi / (len(self.admittance) * self.spacing))

    @cached_property
    def excitation(self) -> FloatArray:
        """S_e, one-sided density of the Thevenin force, shape (omega,) [N^2 s]."""
        size = np.abs(self.admittance) ** 2
        return np.asarray(np.divide(self.spectrum, size, out=np.zeros_like(size), where=size > 0))

    def integral(self, density: FloatArray) -> float:
        """Return the integral of a density over the frequencies."""
        return float(density.sum() * self.spacing)

    @cached_property
    def matched_power(self) -> float:
        """Mean power of a force without limits that knows the future [W]."""
        loss = 4 * self.admittance.real
        return self.integral(np.divide(self.spectrum, loss, out=np.zeros_like(loss), where=loss > 0))

    def absorbed(self, gain: ComplexArray) -> FloatArray:
        """Return the density of the mean power of a force K F_e by frequency, without noise, shape (omega,) [W s]."""
        loss = self.admittance.real * np.abs(gain) ** 2
        return np.asarray((np.real(self.admittance.conj() * gain) - loss) * self.excitation)

    @property
    def stroke_weight(self) -> float:
        """Weight with which displacement counts as much as force where the port moves most [N/(m s)]."""
        return float(1 / np.abs(self.admittance * self.omega).max())

    def coarser(self) -> "StationaryPort":
        """Return the port at every third of its frequencies: what is resolved changes little."""
        return StationaryPort(3 * self.spacing, self.admittance[1::3], self.spectrum[1::3])

    def shorter(self) -> "StationaryPort":
        """Return the port with half of the frequencies beyond the spectrum."""
        used = int(np.flatnonzero(self.spectrum)[-1]) + 1
        kept = used + (len(self.admittance) - used) // 2
        return StationaryPort(self.spacing, self.admittance[:kept], self.spectrum[:kept])

    # signals and factors ----------------------------------------------------------------------------------------------

    @cached_property
    def _turn(self) -> ComplexArray:
        """exp(-i spacing t/2) at the times of a period: frequencies lie half a spacing off those of a transform."""
        n = 2 * len(self.admittance)
        return np.asarray(np.exp(-1j * np.pi * np.arange(n) / n))

    def signal(self, phasors: ComplexArray) -> FloatArray:
        """Return the real signal int X exp(-i omega t) d omega over all frequencies, shape (time,).

        Times are 0, step, 2 step, ...; the second half of them are the negative ones, with the other sign.
        """
        return np.asarray(2 * self.spacing * (fft(phasors, 2 * len(phasors)) * self._turn).real)

    def phasors(self, signal: FloatArray) -> ComplexArray:
        """Return the inverse of `signal`, shape (omega,)."""
        return np.asarray(ifft(signal * self._turn.conj())[: len(signal) // 2] / self.spacing)

    def causal_part(self, real: FloatArray) -> ComplexArray:
        """Return the causal function with this real part, shape (omega,)."""
        values = self.signal(real.astype(complex))
        values[1 : len(real)] *= 2
        values[len(real) :] = 0.0
        return self.phasors(values)

    # optima -----------------------------------------------------------------------------------------------------------

    def known_future(self, weights: Weights, noise: float = 0.0) -> Controlled:
        """Return the optimum of a controller that knows all waves, past and future; noise as in `controlled`."""
        y, s_v, s_e = self.admittance, self.spectrum, self.excitation
        cost, kappa = self.cost(weights)
        measured = s_e + noise * s_e.max(initial=0.0)
        share = np.divide(s_e, measured, out=np.zeros_like(s_e), where=measured > 0)
        gain = (y + 2 * kappa * np.abs(y) ** 2) / (2 * cost)  # F/F_e without noise
        force = np.abs(gain) ** 2 * share * s_e
        along = gain * share * s_e
        speed = s_v - 2 * np.abs(y) ** 2 * along.real + np.abs(y) ** 2 * force
        power = self.integral(np.real(y.conj() * along) - y.real * force)
        squares = self.integral(force), self.integral(speed / self.omega**2), self.integral(speed)
        return Controlled(power, *squares, weights)

    def cost(self, weights: Weights) -> tuple[FloatArray, FloatArray]:
        """Return |W|^2 and kappa, each shape (omega,)."""
        kappa = weights.speed + weights.stroke / self.omega**2
        return self.admittance.real + weights.force + kappa * np.abs(self.admittance) ** 2, kappa

    def controlled(self, weights: Weights, noise: float = NOISE, forecast: float = 0.0) -> Controlled:
        """Return the optimum of a controller that knows the past, and some seconds ahead.

        Parameters
        ----------
        noise : float [-]
            Density of the noise over the peak of that of the Thevenin force; above 0.
        forecast : float [s]
            T; infinite: the future is known, the noise not.
        """
        if np.isinf(forecast):
            return self.known_future(weights, noise)
        cost, kappa = self.cost(weights)
        size, cross = np.abs(self.admittance) ** 2, 1 / self.admittance.conj() + 2 * kappa
        g = self.wanted(weights, noise, forecast)
        signal = Tail(self, g)
        paid = self.integral(kappa * self.spectrum)
        objective = signal.square(signal) - paid

        def mean_square(of_cost: FloatArray, of_kappa: FloatArray | float, free: float) -> float:
            """Less the slope of the objective by a weight."""
            change = g * (2 * of_kappa / cross - np.conj(self.causal_part(0.5 * of_cost / cost)))
            return free - 2 * signal.square(Tail(self, change))

        one = np.ones_like(cost)
        force = mean_square(one, 0.0, 0.0)
        stroke = mean_square(size / self.omega**2, 1 / self.omega**2, self.integral(self.spectrum / self.omega**2))
        speed = mean_square(size, 1.0, self.integral(self.spectrum))
        power = objective + weights.force * force + weights.stroke * stroke + weights.speed * speed
        return Controlled(power, force, stroke, speed, weights)

    def controller(self, weights: Weights, noise: float = NOISE, forecast: float = 0.0) -> ComplexArray:
        """Return K = Q/H of the optimum, the force over the Thevenin force, shape (omega,) [-]; see `controlled`."""
        (cost, _), size = self.cost(weights), len(self.omega)
        ahead = np.exp(1j * self.omega * forecast)
        density = self.excitation + noise * self.excitation.max()
        w, h = (np.exp(self.causal_part(0.5 * np.log(square))) for square in (cost, density))
        wanted = self.signal(self.wanted(weights, noise, forecast))
        wanted[0] /= 2
        wanted[size:] = 0.0
        return np.asarray(self.phasors(wanted) / (w * h * ahead))

    def wanted(self, weights: Weights, noise: float, forecast: float) -> ComplexArray:
        """Return G of a controller, ahead of it by its forecast: what W Q would be if it knew the future (omega,)."""
        cost, kappa = self.cost(weights)
        density = self.excitation + noise * self.excitation.max()
        factors = np.exp(-np.conj(self.causal_part(0.5 * np.log(density * cost))))  # 1/conj(H W)
        ahead = np.exp(1j * self.omega * forecast)
        return np.asarray(self.spectrum * ahead * factors * (1 / self.admittance.conj() + 2 * kappa) / 2)


class OnGrid(Protocol):
    """Ports at the frequencies of a grid."""

    @property
    def matched_power(self) -> float:
        """Mean power without limits [W]."""

    def coarser(self) -> Self:
        """Return the same with a larger spacing."""

    def shorter(self) -> Self:
        """Return the same with fewer frequencies."""

    def controlled(self, weights: Weights, noise: float, forecast: float) -> Controlled:
        """Return the optimum at given weights."""


def numerical_error(port: OnGrid, found: Controlled, noise: float, forecast: float) -> float:
    """Return the relative error of an optimum by spacing and time step of its signals [-].

    The changes by three times the spacing and by half the frequencies beyond the spectrum: both errors fall by a factor
    of four or more with each halving, so that what is left is smaller than these.
    """
    power, changes = found.objective / port.matched_power, 0.0
    for other in (port.coarser(), port.shorter()):
        changes += abs(other.controlled(found.weights, noise, forecast).objective / other.matched_power - power)
    return changes * port.matched_power / abs(found.power)


class RmsLimits(NamedTuple):
    """Largest root mean squares of the force and of the displacement of the port."""

    force: float = np.inf  # [N]
    stroke: float = np.inf  # [m]


def optimum(
    port: StationaryPort, limits: RmsLimits, noise: float = NOISE, forecast: float = 0.0, efficiency: float = 1.0
) -> Controlled:
    """Return the control that absorbs most within limits of the rms of force and displacement.

    Raises `StabilityError` if no control keeps the limit of displacement.

    Parameters
    ----------
    limits : RmsLimits
        Those that the optimum without them keeps do not bind.
    noise, forecast : float [-], [s]
        See `StationaryPort.controlled`. Infinite forecast without noise: all waves are known.
    efficiency : float [-]
        Of both directions of power.

    Notes
    -----
    With losses in conversion the mean power is a function of the means of F V, F^2 and V^2 (`converted_power`), whose
    slopes at the optimum are the weights: they are found by repetition.
    """
    if not port.spectrum.any():
        return Controlled(0.0, 0.0, 0.0, 0.0, Weights(np.inf))

    def within(losses: Weights) -> Controlled:
        return _within_limits(lambda weights: port.controlled(weights, noise, forecast), port, limits, losses)

    best = within(Weights(LEAST_WEIGHT * float(port.admittance.real.max())))
    if efficiency == 1.0:
        return best
    value, losses = best.converted(efficiency), _losses(best, efficiency)
    for _ in range(REPEATED):
        found = within(losses)
        wanted, gained = _losses(found, efficiency), found.converted(efficiency)
        if gained > value:
            best = found
        if abs(gained - value) <= SAME_POWER * abs(value):
            break
        value = gained
        losses = Weights(*(np.sqrt(new * old) if old > 0 else new for new, old in zip(wanted, losses, strict=True)))
    return best


def steadiest(port: StationaryPort, force: float, noise: float = NOISE, forecast: float = 0.0) -> Controlled:
    """Return the control whose displacement has the least rms with a force of a given rms at most [N].

    Its weight of displacement is finite, see `STEADY`: the optimum changes smoothly with its port.
    """
    weight, least = STEADY * port.stroke_weight, LEAST_WEIGHT * float(port.admittance.real.max())
    return _within_force(lambda one: port.controlled(one, noise, forecast), port, force, Weights(least, weight))


def _losses(at: Controlled, efficiency: float) -> Weights:
    """Slopes of the converted power by the mean squares of force and velocity, over that by the power at the port."""
    size = np.sqrt(at.force * at.speed)
    rho, lost = float(np.clip(at.power / size, -1.0, 1.0)), (1 / efficiency - efficiency) / np.pi
    of_power, of_size = efficiency + lost * np.arccos(rho), lost * np.sqrt(1 - rho**2) / 2
    ratio = np.sqrt(at.speed / at.force)
    return Weights(float(of_size * ratio / of_power), 0.0, float(of_size / ratio / of_power))


def _within_limits(
    controlled: Callable[[Weights], Controlled], port: StationaryPort, limits: RmsLimits, least: Weights
) -> Controlled:
    """The optimum with the least weights with which both limits hold."""

    def with_force_limit(stroke: float) -> Controlled:
        return _within_force(controlled, port, limits.force, least._replace(stroke=stroke))

    found = least_weight(with_force_limit, 0.0, port.stroke_weight, lambda one: one.stroke_rms / limits.stroke)
    if found.stroke_rms > limits.stroke * (1 + KEPT):
        raise StabilityError(
            f"pto: no control within force_limit keeps an rms displacement of {limits.stroke:.4g} m in this sea, "
            f"{found.stroke_rms:.4g} m is the least; raise one of them"
        )
    return found


def _within_force(
    controlled: Callable[[Weights], Controlled], port: StationaryPort, force: float, least: Weights
) -> Controlled:
    """The optimum with the least weight of the force with which its limit holds; the other weights as given."""
    start = np.sqrt(port.integral(port.spectrum)) / (2 * force)  # where the force alone costs, it holds
    return least_weight(
        lambda weight: controlled(least._replace(force=weight)), least.force, start, lambda one: one.force_rms / force
    )


def least_weight(
    at: Callable[[float], Controlled], least: float, start: float, share: Callable[[Controlled], float]
) -> Controlled:
    """Return the optimum at the least weight, no less than a given one, at which a quantity keeps its limit.

    The quantity falls with its weight. If no weight keeps the limit, the optimum at the largest one.
    """
    found = at(least)
    if share(found) <= 1:
        return found
    low, high = max(least, start / MOST_WEIGHT), max(start, 2 * least)
    while share(at(high)) > 1:
        low, high = high, 100 * high
        if high > MOST_WEIGHT * start:
            return at(high)
    while share(at(low)) < 1:  # only where the least weight is 0
        low /= 100
    root = brentq(lambda x: np.log(share(at(np.exp(x)))), np.log(low), np.log(high), xtol=ROOT)
    return at(float(np.exp(root)))


class Tail:
    """The part of a signal at times t >= 0, for integrals of products of two of them."""

    def __init__(self, port: StationaryPort, phasors: ComplexArray) -> None:
        self.values, self.step = port.signal(phasors)[: len(phasors)], port.step
        rate = -1j * port.omega
        self.slopes = [2 * port.spacing * float(np.sum(rate**n * phasors).real) for n in (0, 1, 2, 3)]

    def square(self, other: "Tail") -> float:
        """Return the integral over frequency of the product of the phasors of two causal parts.

        By the trapezoidal rule over time with the first two terms of Euler and Maclaurin at t = 0.
        """
        (a0, a1, a2, a3), (b0, b1, b2, b3), dt = self.slopes, other.slopes, self.step
        first = a0 * b1 + a1 * b0
        third = a0 * b3 + 3 * (a1 * b2 + a2 * b1) + a3 * b0
        total = dt * (float(self.values @ other.values) - a0 * b0 / 2) + dt**2 * first / 12 - dt**4 * third / 720
        return total / (4 * np.pi)
