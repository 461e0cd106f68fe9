"""Optimal control of a port, or of several, by a controller that does not know the future waves (Wiener and Hopf).

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

Of several ports the same holds with matrices and the objective E[F^T V] - lambda E[F^T F], so that what is limited is
the rms of all forces together, sqrt(sum E[F_i^2]): no turn of the ports among each other changes it. With the density
matrix S_v of V0, white noise of the same density at each port, and causal factors with causal inverses

    H H^H = S_e + S_n,   S_e = Y^-1 S_v Y^-H,   W^H W = Re Y + lambda,

the optimum of F = Q e is W Q = the part at t >= -T of G = W^-H S_v Y^-H H^-H/2, and its objective int |that part|^2.
Of one port the factors have a closed form, by the logarithms of what they are to be; of several they are found by the
iteration of G. T. Wilson (SIAM J. Appl. Math. 23, 1972), from those of the diagonals.

A spectrum that vanishes as fast as exp(-omega^-4), like those of seas, has no factor H without noise: such a sea could
be predicted from its past without error (Paley and Wiener). So the noise is part of the result. See J. T. Scruggs,
S. M. Lattanzio, A. A. Taflanidis and I. L. Cassidy, Optimal causal control of a wave energy converter in a random sea,
Applied Ocean Research 42 (2013), which solves the same problem with rational models and a Riccati equation.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import NamedTuple, Self

import numpy as np
from scipy.fft import fft, ifft
from scipy.optimize import brentq

from vsb.engine.motion.port import RADIATES_NOTHING
from vsb.engine.motion.tuning import converted_power
from vsb.errors import ConvergenceError, StabilityError
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray

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
KEPT, FAR = 1e-6, 1e3
"""Relative tolerance on a limit, and the share of it that stands for any larger one."""
REPEATED, SAME_POWER = 40, 1e-9
"""With losses in conversion: most repetitions, and the relative change of power after which they end."""
COARSEST, CORRECTED, NUDGED, FARTHEST = 1000, 10, 1e-3, 2.0
"""Least frequencies whose weights begin at those of a third of them, most corrections of these, the difference that
gives the first slopes, and the longest correction; all of logarithms."""

STEPS, FACTORED, LEFT = 60, 1e-12, 1e-8
"""Most iterations for a factor, the relative error of its square, mean over frequencies, before the last of them, and
the most that round-off may leave."""
NEAR, SLOW = 0.5, 0.99
"""Ratios an iteration is to bring the relative error of a factor's square to: from below `NEAR` to `NEAR` of it, from
further away to `SLOW`. Where it does not, fading out signals keeps it from converging."""
UNRESOLVED = 5e-3
"""Third of the change of power by five times the spacing from which on it does not tell what is left by the spacing."""
STILL = 1e-14
"""Square of an admittance, in terms of the largest, below which forces move nothing but by round-off."""


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
        """Root mean square of the force [N]; inf where its weight is too small for it to be resolved."""
        return float(np.sqrt(self.force)) if self.force >= 0 else np.inf

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
class _OnGrid:
    """One port or several in a stationary sea, at the frequencies (k + 1/2) spacing; further axes are those of ports.

    Signals of these frequencies change sign after 2 pi/spacing, which must be longer than they remember. The band must
    extend to where the spectrum of the free velocity is small.
    """

    spacing: float  # [rad/s]
    admittance: ComplexArray  # Y (omega, ...) [m/(N s)]
    spectrum: AnyArray  # S_v, one-sided density of the free velocity (omega, ...) [m^2/s]

    @cached_property
    def omega(self) -> FloatArray:
        """Angular frequencies, shape (omega,) [rad/s]."""
        return (np.arange(len(self.admittance)) + 0.5) * self.spacing

    @property
    def step(self) -> float:
        """Time step of signals [s]."""
        return float(np.pi / (len(self.admittance) * self.spacing))

    def integral(self, density: AnyArray) -> float:
        """Return the integral of a density over the frequencies."""
        return float(density.real.sum() * self.spacing)

    def coarser(self, step: int) -> Self:
        """Return the same at every third, fifth, ... of its frequencies: what is resolved changes little."""
        kept = slice(step // 2, None, step)
        return replace(
            self, spacing=step * self.spacing, admittance=self.admittance[kept], spectrum=self.spectrum[kept]
        )

    def shorter(self) -> Self:
        """Return the same with half of the frequencies beyond the spectrum."""
        used = int(np.flatnonzero(self.spectrum.reshape(len(self.omega), -1).any(axis=1))[-1]) + 1
        kept = (used + len(self.omega)) // 2
        return replace(self, admittance=self.admittance[:kept], spectrum=self.spectrum[:kept])

    @cached_property
    def _turn(self) -> ComplexArray:
        """exp(-i spacing t/2) at the times of a period: frequencies lie half a spacing off those of a transform."""
        n = 2 * len(self.admittance)
        return np.asarray(np.exp(-1j * np.pi * np.arange(n) / n)).reshape(-1, *(1,) * (self.admittance.ndim - 1))

    def signal(self, phasors: ComplexArray) -> FloatArray:
        """Return the real signal int X exp(-i omega t) d omega over all frequencies, shape (time, ...).

        Times are 0, step, 2 step, ...; the second half of them are the negative ones, with the other sign.
        """
        return np.asarray(2 * self.spacing * (fft(phasors, 2 * len(phasors), axis=0) * self._turn).real)

    def causal(self, phasors: ComplexArray, end: float = 0.0) -> ComplexArray:
        """Return the part of a signal at t > 0, and half of that at t = 0, as phasors of its shape.

        With half of that at the end of the period as well, `end`, a Hermitian matrix is the sum of its causal part and
        the adjoint of that, to round-off.
        """
        weights = np.ones(len(phasors) + 1)
        weights[0], weights[-1] = 0.5, end
        return self._kept(phasors, weights)

    def faded(self, phasors: ComplexArray) -> ComplexArray:
        """Return the part of a signal at t >= 0, faded out over the second half of them, as phasors of its shape."""
        late = np.maximum(np.linspace(-1.0, 1.0, len(phasors) + 1), 0.0)
        return self._kept(phasors, np.cos(0.5 * np.pi * late) ** 2)

    def _kept(self, phasors: ComplexArray, weights: FloatArray) -> ComplexArray:
        """A signal times weights at 0, step, ... to half the period, 0 at negative times, as phasors."""
        values = self.signal(phasors)
        values[: len(weights)] *= weights.reshape(-1, *(1,) * (phasors.ndim - 1))
        values[len(weights) :] = 0.0
        return np.asarray(ifft(values * self._turn.conj(), axis=0)[: len(phasors)] / self.spacing)

    def causal_part(self, real: FloatArray) -> ComplexArray:
        """Return the causal function with this real part."""
        return 2 * self.causal(real.astype(complex))


@dataclass(frozen=True)
class StationaryPort(_OnGrid):
    """A port in a stationary sea: admittance and density of the free velocity have the shape (omega,)."""

    def __post_init__(self) -> None:
        """Check that the port is passive and its spectrum a density."""
        if self.spacing <= 0 or not np.all(self.admittance.real >= 0):
            raise ValueError(
                "port: not passive, or its frequencies do not ascend; needs Re Y >= 0 and a spacing above 0"
            )
        if not np.all(self.spectrum >= 0):
            raise ValueError("spectrum: received a negative density; needs at least 0")

    @cached_property
    def excitation(self) -> FloatArray:
        """S_e, one-sided density of the Thevenin force, shape (omega,) [N^2 s]."""
        size = np.abs(self.admittance) ** 2
        return np.asarray(np.divide(self.spectrum, size, out=np.zeros_like(size), where=size > 0))

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

    @property
    def largest_loss(self) -> float:
        """The largest Re Y [m/(N s)]."""
        return float(self.admittance.real.max())

    @property
    def free_rms(self) -> float:
        """Root mean square of the free velocity [m/s]."""
        return float(np.sqrt(self.integral(self.spectrum)))

    def moved(self) -> Self:
        """Return itself: a single port moves."""
        return self

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
        cost, _ = self.cost(weights)
        ahead = np.exp(1j * self.omega * forecast)
        density = self.excitation + noise * self.excitation.max()
        w, h = (np.exp(self.causal_part(0.5 * np.log(square))) for square in (cost, density))
        return np.asarray(self.causal(self.wanted(weights, noise, forecast)) / (w * h * ahead))

    def wanted(self, weights: Weights, noise: float, forecast: float) -> ComplexArray:
        """Return G of a controller, ahead of it by its forecast: what W Q would be if it knew the future (omega,)."""
        cost, kappa = self.cost(weights)
        density = self.excitation + noise * self.excitation.max()
        factors = np.exp(-np.conj(self.causal_part(0.5 * np.log(density * cost))))  # 1/conj(H W)
        ahead = np.exp(1j * self.omega * forecast)
        return np.asarray(self.spectrum * ahead * factors * (1 / self.admittance.conj() + 2 * kappa) / 2)

    def lasts(self, weights: Weights, noise: float, forecast: float) -> float:
        """Return the part of the rms of the controller's signal in the second half of the times it may last [-].

        Powers err by about a hundredth of its square.
        """
        signal = self.signal(self.wanted(weights, noise, forecast))[: len(self.omega)]
        whole = float(np.linalg.norm(signal))
        return float(np.linalg.norm(signal[len(signal) // 2 :])) / whole if whole else 0.0


@dataclass(frozen=True)
class StationaryPorts(_OnGrid):
    """Several ports in a stationary sea: admittances and Hermitian densities have the shape (omega, port, port)."""

    stroke_weight = 1.0
    """Displacements are not limited."""

    def over(self, forces: FloatArray) -> "StationaryPorts":
        """Return the same as seen by other forces, those of the ports being F = U f, U shape (port, force)."""
        admittance, spectrum = forces.T @ self.admittance @ forces, forces.T @ self.spectrum @ forces
        return StationaryPorts(self.spacing, admittance, spectrum)

    def moving(self) -> FloatArray:
        """Return forces U (port, force), F = U f, without those that move nothing.

        Those of ports that stand still or move as others do are left out.
        """
        size, along = np.linalg.eigh(np.einsum("wij,wkj->ik", self.admittance, self.admittance.conj()).real)
        moves = size > STILL * size.max()
        return np.eye(len(size)) if moves.all() else np.asarray(along[:, moves])

    def moved(self) -> "StationaryPorts":
        """Return the same as seen by the forces of `moving`."""
        return self.over(self.moving())

    @cached_property
    def measured(self) -> ComplexArray:
        """S_v Y^-H, shape (omega, port, port)."""
        return np.asarray(np.linalg.solve(self.admittance.conj(), self.spectrum.swapaxes(1, 2)).swapaxes(1, 2))

    @cached_property
    def excitation(self) -> ComplexArray:
        """S_e, densities of the forces of the waves, shape (omega, port, port)."""
        return np.asarray(np.linalg.solve(self.admittance, self.measured))

    @cached_property
    def matched_power(self) -> float:
        """Mean power of forces without limits that know the future [W]."""
        loss, vectors = np.linalg.eigh(self.admittance.real)
        along = np.einsum("wji,wjk,wki->wi", vectors, self.spectrum, vectors).real
        kept = loss > RADIATES_NOTHING * loss.max(axis=1, keepdims=True)
        return self.integral(np.divide(along, 4 * loss, out=np.zeros_like(along), where=kept))

    @property
    def largest_loss(self) -> float:
        """The largest eigenvalue of Re Y [m/(N s)]."""
        return float(np.linalg.eigvalsh(self.admittance.real).max())

    @property
    def free_rms(self) -> float:
        """Root of the sum of the mean squares of all free velocities."""
        return float(np.sqrt(self.integral(np.einsum("wii->w", self.spectrum))))

    # factors ----------------------------------------------------------------------------------------------------------

    def _factor(
        self, square: ComplexArray, changes: Sequence[AnyArray] = ()
    ) -> tuple[ComplexArray, list[ComplexArray]]:
        """The causal B with a causal inverse and B B^H = a Hermitian, positive matrix, (omega, port, port).

        Wilson's iteration, Newton's method: B becomes B (the causal part of B^-1 square B^-H + 1). Products of signals
        that outlast the grid end at negative times, and no later step removes them: B B^H is right with any of them. So
        they are faded out after each step, until that keeps the steps from converging: the last ones are without. The
        derivatives of B by those of the square follow it step by step.
        """
        one = np.eye(square.shape[1])

        def diagonal(values: AnyArray) -> FloatArray:
            return np.asarray(values.real[:, :, None] * one)

        own = np.einsum("wii->wi", square).real
        found = np.asarray(np.exp(self.causal_part(diagonal(0.5 * np.log(own)))) * one, dtype=complex)
        ratios = [0.5 * np.einsum("wii->wi", change) / own for change in changes]
        slopes: list[ComplexArray] = [found * self.causal_part(diagonal(ratio)) for ratio in ratios]
        before, size = np.inf, np.abs(square).max(axis=(1, 2))
        fades, apart = True, np.inf
        for turn in range(STEPS):
            inverse, seen = np.linalg.inv(found), self._seen(found, square)
            off = np.abs(seen - one).max(axis=(1, 2))
            last, apart = apart, float(off.mean())
            fades &= apart > FACTORED and (turn < 2 or apart < (SLOW if off.max() > NEAR else NEAR) * last)
            step = self.causal(seen + one, end=0.5)
            for i, change in enumerate(changes):
                turned = inverse @ slopes[i] @ seen
                moved = self._seen(found, change) - turned - turned.conj().swapaxes(1, 2)
                slopes[i] = slopes[i] @ step + found @ self.causal(moved, end=0.5)
            found = found @ step
            if fades:
                found, slopes = self.faded(found), [self.faded(slope) for slope in slopes]
                continue
            away = float((np.abs(found @ found.conj().swapaxes(1, 2) - square).max(axis=(1, 2)) / size).mean())
            if before <= FACTORED or 0.99 * before < away <= LEFT:
                return found, slopes
            before = away
        raise ConvergenceError(
            f"pto: no causal control of {square.shape[1]} ports found: factors of their spectra do not converge; needs "
            "more control.noise, or more damping of the shell"
        )

    @staticmethod
    def _seen(factor: ComplexArray, square: AnyArray) -> ComplexArray:
        """B^-1 square B^-H."""
        inverse = np.linalg.inv(factor)
        return np.asarray(inverse @ square @ inverse.conj().swapaxes(1, 2))

    # optima -----------------------------------------------------------------------------------------------------------

    def controlled(self, weights: Weights, noise: float = NOISE, forecast: float = 0.0) -> Controlled:
        """Return the optimum at a weight of the forces; its stroke and speed are not computed, and 0.

        Parameters
        ----------
        noise : float [-]
            Density of the noise at each port over the peak of the sum of those of the forces of the waves; above 0.
        forecast : float [s]
            T; infinite, without noise: all waves are known.
        """
        if np.isinf(forecast):
            return self.known_future(weights)
        one = np.broadcast_to(np.eye(self.admittance.shape[1]), self.admittance.shape)
        cost, (by_force,) = self._cost(weights, [one])
        g = self._wanted(cost, noise, forecast)
        tail = Tail(self, g)
        objective = tail.square(tail)
        force = 2 * tail.square(Tail(self, np.linalg.solve(cost, by_force).conj() @ g))  # less its slope by the weight
        return Controlled(objective + weights.force * force, force, 0.0, 0.0, weights)

    def controller(self, weights: Weights, noise: float = NOISE, forecast: float = 0.0) -> ComplexArray:
        """Return K = Q H^-1 of the optimum, the forces over those of the waves, shape (omega, port, port) [-].

        Parameters as of `controlled`.
        """
        cost = self._cost(weights)[0]
        behind = np.exp(-1j * self.omega * forecast)[:, None, None]
        causal = behind * self.causal(self._wanted(cost, noise, forecast))
        q = np.linalg.solve(cost.swapaxes(1, 2), causal)
        return np.asarray(np.linalg.solve(self._noisy(noise).swapaxes(1, 2), q.swapaxes(1, 2)).swapaxes(1, 2))

    def slopes(
        self, weights: Weights, noise: float, forecast: float, changes: Sequence[tuple[ComplexArray, ComplexArray]]
    ) -> FloatArray:
        """Return the derivatives of the objective at given weights, by those of admittance and density, (variable,)."""
        adjoint = self.admittance.conj().swapaxes(1, 2)
        cost, of_cost = self._cost(weights, [admittance.real for admittance, _ in changes])
        g, ahead = self._wanted(cost, noise, forecast), np.exp(1j * self.omega * forecast)[:, None, None]
        measured = [
            np.linalg.solve(
                adjoint.swapaxes(1, 2), (density - self.measured @ admittance.conj().swapaxes(1, 2)).swapaxes(1, 2)
            ).swapaxes(1, 2)
            for admittance, density in changes
        ]
        excitation = [
            np.linalg.solve(self.admittance, moved - admittance @ self.excitation)
            for moved, (admittance, _) in zip(measured, changes, strict=True)
        ]
        h, of_noisy = self._factor(
            self.excitation + self._noise(self.excitation, noise), [one + self._noise(one, noise) for one in excitation]
        )
        whitened, tail, found = self._over(self.measured, h), Tail(self, g), []
        for moved, by_cost, by_noisy in zip(measured, of_cost, of_noisy, strict=True):
            seen = self._over(moved - whitened @ by_noisy.conj().swapaxes(1, 2), h)
            change = ahead * np.linalg.solve(cost.conj(), seen) / 2 - np.linalg.solve(cost, by_cost).conj() @ g
            found.append(2 * tail.square(Tail(self, change)))
        return np.array(found)

    def _cost(self, weights: Weights, changes: Sequence[AnyArray] = ()) -> tuple[ComplexArray, list[ComplexArray]]:
        """The transpose of W, and its derivatives by those of its square, each shape (omega, port, port)."""
        return self._factor(self.admittance.real + weights.force * np.eye(self.admittance.shape[1]) + 0j, changes)

    def _wanted(self, cost: ComplexArray, noise: float, forecast: float) -> ComplexArray:
        """G ahead by the forecast, shape (omega, port, port)."""
        ahead = np.exp(1j * self.omega * forecast)[:, None, None]
        return np.asarray(ahead * np.linalg.solve(cost.conj(), self._over(self.measured, self._noisy(noise))) / 2)

    @staticmethod
    def _over(matrix: ComplexArray, factor: ComplexArray) -> ComplexArray:
        """A B^-H."""
        return np.asarray(np.linalg.solve(factor, matrix.conj().swapaxes(1, 2)).conj().swapaxes(1, 2))

    @cached_property
    def _peak(self) -> int:
        """Where the density of the forces of the waves is largest."""
        return int(np.einsum("wii->w", self.excitation).real.argmax())

    def _noise(self, excitation: ComplexArray, noise: float) -> ComplexArray:
        """S_n, or its derivative, of S_e, or that of it, shape (port, port)."""
        return np.asarray(noise * np.trace(excitation[self._peak]).real * np.eye(excitation.shape[1]))

    def _noisy(self, noise: float) -> ComplexArray:
        """H, shape (omega, port, port); kept, for it is the same at all weights."""
        known: dict[float, ComplexArray] = self.__dict__.setdefault("_known", {})
        if noise not in known:
            known[noise] = self._factor(self.excitation + self._noise(self.excitation, noise))[0]
        return known[noise]

    def known_future(self, weights: Weights) -> Controlled:
        """Return the optimum of forces that know all waves, F = (Re Y + lambda)^-1 V0/2."""
        loss = self.admittance.real
        cost = loss + weights.force * np.eye(loss.shape[1])
        forces = np.linalg.solve(cost, np.linalg.solve(cost, self.spectrum).conj().swapaxes(1, 2)) / 4
        along = self.integral(np.einsum("wii->w", np.linalg.solve(cost, self.spectrum)) / 2)
        power = along - self.integral(np.einsum("wij,wji->w", loss, forces))
        return Controlled(power, self.integral(np.einsum("wii->w", forces)), 0.0, 0.0, weights)


Stationary = StationaryPort | StationaryPorts
"""One port or several in a stationary sea."""


class GridError(NamedTuple):
    """Relative changes of a power by other grids of its controller, and what follows from them [-]."""

    third: float = 0.0  # with three times the spacing
    fifth: float = 0.0  # with five times the spacing
    shorter: float = 0.0  # with half of the frequencies beyond the spectrum
    beyond: float = 0.0  # most by which a controller may absorb more than the damper in its place

    @property
    def size(self) -> float:
        """The relative error of the power.

        Errors fall in proportion to the spacing or faster: what is left is at most half of the change by three times
        the spacing, and a quarter of that by five times. By chance the first was smaller than what is left in 17 of 380
        cases, down to a tenth of it; the larger of it and a third of the other, up to `UNRESOLVED`, was in none.
        """
        spacing = max(abs(self.third), min(abs(self.fifth) / 3, UNRESOLVED))
        return spacing + abs(self.shorter) + self.beyond

    def over(self, other: "GridError") -> "GridError":
        """Return the same of the ratio of two powers, in which what changes both alike cancels."""
        third, fifth, shorter = (mine - theirs for mine, theirs in zip(self[:3], other[:3], strict=True))
        return GridError(third, fifth, shorter, self.beyond + other.beyond)

    def of_damper(self, share: float) -> "GridError":
        """Return the same of a damper that absorbs more than the controller, whose power is a share of the damper's."""
        return GridError(beyond=max(share * (1 + self.size) - 1, 0.0))


def numerical_error(port: Stationary, found: Controlled, noise: float, forecast: float) -> GridError:
    """Return the relative error of an optimum by spacing and time step of its signals."""
    if not found.power:
        return GridError()
    power, others = found.objective / port.matched_power, (port.coarser(3), port.coarser(5), port.shorter())
    changes = (
        other.controlled(found.weights, noise, forecast).objective / other.matched_power - power for other in others
    )
    return GridError(*(change * port.matched_power / abs(found.power) for change in changes))


class RmsLimits(NamedTuple):
    """Largest root mean squares of the force and of the displacement of the port."""

    force: float = np.inf  # [N]
    stroke: float = np.inf  # [m]


def optimum(
    port: Stationary, limits: RmsLimits, noise: float = NOISE, forecast: float = 0.0, efficiency: float = 1.0
) -> Controlled:
    """Return the control that absorbs most within limits of the rms of force and displacement.

    Raises `StabilityError` if no control keeps the limit of displacement.

    Parameters
    ----------
    limits : RmsLimits
        Those that the optimum without them keeps do not bind. Of several ports of all forces together alone.
    noise, forecast : float [-], [s]
        See `StationaryPort.controlled`. Infinite forecast without noise: all waves are known.
    efficiency : float [-]
        Of both directions of power; of several ports 1.

    Notes
    -----
    With losses in conversion the mean power is a function of the means of F V, F^2 and V^2 (`converted_power`), whose
    slopes at the optimum are the weights: they are found by repetition.
    """
    if not port.spectrum.any():
        return Controlled(0.0, 0.0, 0.0, 0.0, Weights(np.inf))
    port = port.moved()

    def within(losses: Weights) -> Controlled:
        return _within_limits(port, limits, losses, noise, forecast)

    best = within(Weights(LEAST_WEIGHT * port.largest_loss))
    if best.force < 0:
        raise ConvergenceError(
            "pto: no causal control found: signals of so large a force outlast what the frequencies resolve; needs a "
            "smaller limit of force, more control.noise, or more damping of the shell"
        )
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
    weight, least = STEADY * port.stroke_weight, LEAST_WEIGHT * port.largest_loss
    return _within_limits(port, RmsLimits(force), Weights(least, weight), noise, forecast)


def _losses(at: Controlled, efficiency: float) -> Weights:
    """Slopes of the converted power by the mean squares of force and velocity, over that by the power at the port."""
    size = np.sqrt(at.force * at.speed)
    rho, lost = float(np.clip(at.power / size, -1.0, 1.0)), (1 / efficiency - efficiency) / np.pi
    of_power, of_size = efficiency + lost * np.arccos(rho), lost * np.sqrt(1 - rho**2) / 2
    ratio = np.sqrt(at.speed / at.force)
    return Weights(float(of_size * ratio / of_power), 0.0, float(of_size / ratio / of_power))


def _within_limits(port: Stationary, limits: RmsLimits, least: Weights, noise: float, forecast: float) -> Controlled:
    """The optimum with the least weights with which both limits hold.

    They are sought on few frequencies, and corrected on more and more.
    """
    if len(port.omega) >= COARSEST:
        with suppress(ConvergenceError, StabilityError):  # of fewer frequencies
            if found := _corrected(port, limits, least, noise, forecast):
                return found

    def with_force_limit(stroke: float) -> Controlled:
        def at(force: float) -> Controlled:
            return port.controlled(least._replace(force=force, stroke=stroke), noise, forecast)

        if np.isinf(limits.force):
            return at(least.force)
        start = port.free_rms / (2 * limits.force)  # where the force alone costs, it holds
        return least_weight(at, least.force, start, lambda one: one.force_rms / limits.force)

    def share(one: Controlled) -> float:
        return one.stroke_rms / limits.stroke

    found = least_weight(with_force_limit, least.stroke, port.stroke_weight, share)
    if share(found) > 1 + KEPT:
        raise StabilityError(
            f"pto: no control within force_limit keeps an rms displacement of {limits.stroke:.4g} m in this sea, "
            f"{found.stroke_rms:.4g} m is the least; raise one of them"
        )
    return found


def _corrected(port: Stationary, limits: RmsLimits, least: Weights, noise: float, forecast: float) -> Controlled | None:
    """The same, from the weights at a third of the frequencies by Broyden's method; None if it does not get there."""
    rough = port.coarser(3)
    begin = _within_limits(rough, limits, least, noise, forecast)
    binding = np.array(begin.weights[:2]) > np.array(least[:2]) * (1 + KEPT)

    def at(one: Stationary, logs: FloatArray) -> tuple[Controlled, FloatArray]:
        weights = np.array(least[:2])
        weights[binding] = np.exp(logs)
        found = one.controlled(least._replace(force=float(weights[0]), stroke=float(weights[1])), noise, forecast)
        with np.errstate(divide="ignore"):
            return found, np.log([found.force_rms / limits.force, found.stroke_rms / limits.stroke])

    logs = np.log(np.array(begin.weights[:2])[binding])
    here, nudges = at(rough, logs)[1][binding], NUDGED * np.eye(len(logs))
    if not np.isfinite(here).all():
        return None
    slopes = np.array([at(rough, logs + one)[1][binding] - here for one in nudges]).T.reshape(nudges.shape) / NUDGED
    step: FloatArray = np.zeros(0)
    for _ in range(CORRECTED):
        found, over = at(port, logs)
        if not (np.isfinite(over[binding]).all() and np.isfinite(slopes).all()):
            return None
        if np.abs(over[binding]).max(initial=0.0) <= ROOT:
            kept = (over[~binding] <= 0).all() and (np.array(found.weights[:2]) >= np.array(least[:2])).all()
            return found if kept else None
        if step.size:
            slopes += np.outer(over[binding], step) / (step @ step)
        step = -np.linalg.lstsq(slopes, over[binding], rcond=None)[0]
        if np.abs(step).max(initial=0.0) > FARTHEST:
            return None
        logs = logs + step
    return None


def least_weight(
    at: Callable[[float], Controlled], least: float, start: float, share: Callable[[Controlled], float]
) -> Controlled:
    """Return the optimum at the least weight, no less than a given one, at which a quantity keeps its limit.

    The quantity falls with its weight. If no weight keeps the limit, the optimum at the largest one.
    """
    found, floor = at(least), float(np.log(least)) if least > 0 else -np.inf
    if share(found) <= 1:
        return found

    @cache
    def own(x: float) -> Controlled:
        return at(float(np.exp(x))) if x > floor else found

    low = high = float(np.log(max(start, 2 * least)))
    while share(own(high)) > 1:
        low, high = high, high + np.log(100)
        if high > np.log(MOST_WEIGHT * start):
            return own(high)
    step = 0.5
    while share(own(low)) <= 1:
        low, high, step = max(low - step, floor), low, 2 * step
    return own(float(brentq(lambda x: np.log(min(share(own(x)), FAR)), low, high, xtol=ROOT)))


class Tail:
    """The part of a signal at times t >= 0, for integrals of products of two of them."""

    def __init__(self, port: Stationary, phasors: ComplexArray) -> None:
        self.values, self.step = port.signal(phasors)[: len(phasors)], port.step
        rate = (-1j * port.omega).reshape(-1, *(1,) * (phasors.ndim - 1))
        self.slopes = [2 * port.spacing * np.sum(rate**n * phasors, axis=0).real for n in (0, 1, 2, 3)]

    def square(self, other: "Tail") -> float:
        """Return the integral over frequency of the product of the phasors of two causal parts, summed over entries.

        By the trapezoidal rule over time with the first two terms of Euler and Maclaurin at t = 0.
        """
        (a0, a1, a2, a3), (b0, b1, b2, b3), dt = self.slopes, other.slopes, self.step
        first = a0 * b1 + a1 * b0
        third = a0 * b3 + 3 * (a1 * b2 + a2 * b1) + a3 * b0
        ends = dt**2 * first / 12 - dt * a0 * b0 / 2 - dt**4 * third / 720
        return float(dt * np.vdot(self.values, other.values) + np.sum(ends)) / (4 * np.pi)


# derivatives of the optimum of one port -----------------------------------------------------------------------------

# Of the objective L, power less weights times mean squares, the logarithm of the phasors G is a sum of logarithms, so
# that first and second derivatives of L have a closed form. The controller is the best one at given weights: its own
# change does not count in dL (envelope theorem), and the slopes of L by the weights are less the mean squares. At given
# limits the weights of those that bind follow from d(mean square) = 0, and the power from dP = dL at fixed weights +
# weights times d(mean square).


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
    """Return the derivatives of an optimum of `optimum` without losses in conversion.

    Parameters
    ----------
    port, found : StationaryPort, Controlled
    admittance, spectrum : ndarray, shape (variable, omega)
        Derivatives of the admittance [m/(N s)] and of the density of the free velocity [m^2/s].
    steadiest : bool
        Of one of `steadiest` instead.
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
