"""Optimal control of several ports at once by a controller that does not know the future waves.

As of one port (`vsb.engine.motion.causal`) with matrices: V = V0 - Y F, the measured forces F_e = Y^-1 V0 with white
noise of the same density at each, and the objective E[F^T V] - lambda E[F^T F], so that what is limited is the rms of
all forces together, sqrt(sum E[F_i^2]): no turn of the ports among each other changes it. With the density matrix S_v
of V0 and causal factors with causal inverses

    H H^H = S_e + S_n,   S_e = Y^-1 S_v Y^-H,   W^H W = Re Y + lambda,

the optimum of F = Q e is W Q = the part at t >= -T of G = W^-H S_v Y^-H H^-H/2, and its objective int |that part|^2.
The factors are found by the iteration of G. T. Wilson (SIAM J. Appl. Math. 23, 1972), from those of the diagonals.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import fft, ifft

from vsb.engine.motion.causal import LEAST_WEIGHT, NOISE, Controlled, Weights, least_weight
from vsb.engine.motion.damper_matrix import ROUND_OFF
from vsb.errors import ConvergenceError
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray

STEPS, FACTORED, LEFT = 60, 1e-10, 1e-2
"""Most iterations for a factor, the relative error of its square, mean over frequencies, that ends them, and the most
that may be left where signals outlast the grid: what that does to powers is part of `numerical_error`."""


STILL = 1e-14
"""Square of an admittance, in terms of the largest, below which forces move nothing but by round-off."""


@dataclass(frozen=True)
class StationaryPorts:
    """Several ports in a stationary sea, at the frequencies (k + 1/2) spacing; see `StationaryPort`."""

    spacing: float  # [rad/s]
    admittance: ComplexArray  # Y (omega, port, port)
    spectrum: ComplexArray  # S_v, one-sided densities of the free velocities (omega, port, port), Hermitian

    def over(self, forces: FloatArray) -> "StationaryPorts":
        """Return the same as seen by other forces, those of the ports being F = U f, U shape (port, force)."""
        turned = (forces.T @ each @ forces for each in (self.admittance, self.spectrum))
        return StationaryPorts(self.spacing, *turned)

    def moving(self) -> FloatArray:
        """Return forces U (port, force), F = U f, without those that move nothing.

        Those of ports that stand still or move as others do are left out.
        """
        size, along = np.linalg.eigh(np.einsum("wij,wkj->ik", self.admittance, self.admittance.conj()).real)
        return np.asarray(along[:, size > STILL * size.max()])

    def moved(self) -> "StationaryPorts":
        """Return the same as seen by the forces of `moving`."""
        return self.over(self.moving())

    @cached_property
    def omega(self) -> FloatArray:
        """Angular frequencies, shape (omega,) [rad/s]."""
        return (np.arange(len(self.admittance)) + 0.5) * self.spacing

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
        kept = loss > ROUND_OFF * loss.max(axis=1, keepdims=True)
        return self._integral(np.divide(along, 4 * loss, out=np.zeros_like(along), where=kept))

    def coarser(self) -> "StationaryPorts":
        """Return the ports at every third of their frequencies."""
        return StationaryPorts(3 * self.spacing, self.admittance[1::3], self.spectrum[1::3])

    def shorter(self) -> "StationaryPorts":
        """Return the ports with half of the frequencies beyond the spectrum."""
        kept = (int(np.flatnonzero(self.spectrum.any(axis=(1, 2)))[-1]) + 1 + len(self.omega)) // 2
        return StationaryPorts(self.spacing, self.admittance[:kept], self.spectrum[:kept])

    def _integral(self, density: AnyArray) -> float:
        return float(density.real.sum() * self.spacing)

    # signals and factors ----------------------------------------------------------------------------------------------

    def _signal(self, phasors: ComplexArray) -> FloatArray:
        """Real signals int X exp(-i omega t) d omega, (time, port, port), as `StationaryPort.signal`."""
        return np.asarray(2 * self.spacing * (fft(phasors, 2 * len(phasors), axis=0) * self._turn).real)

    def _causal(self, phasors: ComplexArray) -> ComplexArray:
        """The part of matrices at t > 0, and half of that at t = 0, (omega, port, port)."""
        values = self._signal(phasors)
        values[0] /= 2
        values[len(phasors) :] = 0.0
        return np.asarray(ifft(values * self._turn.conj(), axis=0)[: len(phasors)] / self.spacing)

    @cached_property
    def _turn(self) -> ComplexArray:
        n = 2 * len(self.admittance)
        return np.asarray(np.exp(-1j * np.pi * np.arange(n) / n))[:, None, None]

    def _factor(self, square: ComplexArray) -> ComplexArray:
        """The causal B with a causal inverse and B B^H = a Hermitian, positive matrix, (omega, port, port).

        Wilson's iteration, Newton's method: B becomes B (the causal part of B^-1 square B^-H + 1).
        """
        one = np.eye(square.shape[1])
        logs = np.log(np.einsum("wii->wi", square).real)[:, :, None] * one
        parts = 2 * self._causal((0.5 * logs).astype(complex))  # causal, with these real parts
        begin = np.exp(np.einsum("wii->wi", parts))[:, :, None] * one
        found, before, size = begin, np.inf, np.abs(square).max(axis=(1, 2))
        for _ in range(STEPS):
            found = found @ self._causal(self._seen(found, square) + one)
            away = float((np.abs(found @ found.conj().swapaxes(1, 2) - square).max(axis=(1, 2)) / size).mean())
            if away <= FACTORED or 0.99 * before < away <= LEFT:
                return np.asarray(found)
            before = away
        raise ConvergenceError(
            f"pto: no causal control of {square.shape[1]} ports found: they swing longer than "
            f"{np.pi / self.spacing:.3g} s; needs more damping of the shell"
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
            T.
        """
        cost, g = self._wanted(weights, noise, forecast)
        by_force = self._causal(self._seen(cost, np.eye(cost.shape[1])[None])).conj() @ g
        objective, force = self._tails(g, g), 2 * self._tails(g, by_force)
        return Controlled(objective + weights.force * force, force, 0.0, 0.0, weights)

    def controller(self, weights: Weights, noise: float = NOISE, forecast: float = 0.0) -> ComplexArray:
        """Return K = Q H^-1 of the optimum, the forces over those of the waves, shape (omega, port, port) [-].

        Parameters as of `controlled`.
        """
        cost, g = self._wanted(weights, noise, forecast)
        behind = np.exp(-1j * self.omega * forecast)[:, None, None]
        q = np.linalg.solve(cost.swapaxes(1, 2), behind * self._causal(g))
        return np.asarray(np.linalg.solve(self._noisy(noise).swapaxes(1, 2), q.swapaxes(1, 2)).swapaxes(1, 2))

    def _wanted(self, weights: Weights, noise: float, forecast: float) -> tuple[ComplexArray, ComplexArray]:
        """The transpose of W, and G ahead by the forecast, each shape (omega, port, port)."""
        cost = self._factor(self.admittance.real + weights.force * np.eye(self.admittance.shape[1]) + 0j)
        whitened = np.linalg.solve(self._noisy(noise), self.measured.conj().swapaxes(1, 2)).conj().swapaxes(1, 2)
        ahead = np.exp(1j * self.omega * forecast)[:, None, None]
        return cost, np.asarray(ahead * np.linalg.solve(cost.conj(), whitened) / 2)

    def _noisy(self, noise: float) -> ComplexArray:
        """H, shape (omega, port, port); kept, for it is the same at all weights."""
        known: dict[float, ComplexArray] = self.__dict__.setdefault("_known", {})
        if noise not in known:
            peak = float(np.einsum("wii->w", self.excitation).real.max())
            known[noise] = self._factor(self.excitation + noise * peak * np.eye(self.admittance.shape[1]))
        return known[noise]

    def _tails(self, one: ComplexArray, other: ComplexArray) -> float:
        """The integral over frequency of the product of causal parts, summed over all entries."""
        rate, step = -1j * self.omega[:, None, None], np.pi / (len(self.omega) * self.spacing)
        a, b = (self._signal(g)[: len(g)] for g in (one, other))
        slopes = [[2 * self.spacing * (rate**n * g).sum(axis=0).real for n in range(4)] for g in (one, other)]
        (a0, a1, a2, a3), (b0, b1, b2, b3) = slopes
        first, third = a0 * b1 + a1 * b0, a0 * b3 + 3 * (a1 * b2 + a2 * b1) + a3 * b0
        ends = -step * a0 * b0 / 2 + step**2 * first / 12 - step**4 * third / 720  # Euler and Maclaurin
        return float(step * (a * b).sum() + ends.sum()) / (4 * np.pi)

    def known_future(self, weights: Weights) -> Controlled:
        """Return the optimum of forces that know all waves, F = (Re Y + lambda)^-1 V0/2."""
        loss = self.admittance.real
        cost = loss + weights.force * np.eye(loss.shape[1])
        forces = np.linalg.solve(cost, np.linalg.solve(cost, self.spectrum).conj().swapaxes(1, 2)) / 4
        along = self._integral(np.einsum("wii->w", np.linalg.solve(cost, self.spectrum)) / 2)
        power = along - self._integral(np.einsum("wij,wji->w", loss, forces))
        return Controlled(power, self._integral(np.einsum("wii->w", forces)), 0.0, 0.0, weights)


def optimum(ports: StationaryPorts, force: float, noise: float = NOISE, forecast: float = 0.0) -> Controlled:
    """Return the control of several ports that absorbs most with a given rms of all forces together.

    Parameters
    ----------
    force : float
        The limit; one that the optimum without it keeps does not bind.
    noise, forecast : float [-], [s]
        See `StationaryPorts.controlled`. Infinite forecast without noise: all waves are known.
    """
    if not ports.spectrum.any():
        return Controlled(0.0, 0.0, 0.0, 0.0, Weights(np.inf))
    ports = ports.moved()

    def at(weight: float) -> Controlled:
        weights = Weights(weight)
        return ports.known_future(weights) if np.isinf(forecast) else ports.controlled(weights, noise, forecast)

    least = LEAST_WEIGHT * float(np.linalg.eigvalsh(ports.admittance.real).max())
    start = float(np.sqrt(np.einsum("wii->", ports.spectrum).real * ports.spacing)) / (2 * force)
    return least_weight(at, least, start, lambda found: found.force_rms / force)
