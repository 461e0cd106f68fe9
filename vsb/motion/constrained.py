"""The most any take-off can absorb within limits of force and stroke: a convex quadratic programme, with its proof.

In a sea that repeats after a period, force F = Re sum f_k exp(-i omega_k t) and velocity V = V0 - Y F of the port give
the mean power P = sum Re(conj(f_k) v0_k)/2 - Re(Y_k) |f_k|^2/2. It is concave since the port is passive, Re Y > 0, and
|F| <= F_max, |S| <= S_max at the instants of collocation are linear. Multipliers of these limits give an upper bound,

    P <= sum_j limit |mu_j| - S0_j mu_j + sum_k |v0_k/2 - m_k|^2/(2 Re Y_k),   m = C^H mu,

whatever they are: the distance between both is the gap of an optimum, or, where no force keeps the limits, the bound
falls below all that a limited force can do, which certifies just that. It bounds every control, causal or not.

An interior-point method (Mehrotra's) on the condensed matrix Re Y + C^T W C, in which W holds a weight per instant: of
exponentials it is a Toeplitz and a Hankel matrix, whose entries are one Fourier transform of the weights.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from vsb.errors import ConvergenceError, StabilityError
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port
from vsb.tools.compiled import njit
from vsb.tools.units import ComplexArray, FloatArray
from vsb.waves.seas import Sea

BETWEEN = 8
"""Times finer are the instants on which the excess between those of collocation is looked for."""
SHARE_OF_THE_WAY = 0.995  # to the boundary
MOST_STEPS = 80
KEPT = 1e-9
"""A limit is kept if it is exceeded by no more than this part of it."""


@dataclass(frozen=True)
class Limit:
    """A limit on |offset(t) + Re sum gain_k f_k exp(-i omega_k t)| at every instant."""

    offset: FloatArray  # (instant,) what there is without force
    gain: ComplexArray  # (harmonic,) per unit of force
    largest: float

    @property
    def plain(self) -> bool:
        """Whether it is the force itself that is limited."""
        return bool(np.all(self.gain == 1)) and not self.offset.any()


class ConstrainedOptimum(NamedTuple):
    """The best force within limits, its power, and the bound that proves it."""

    force: ComplexArray  # f (harmonic,) [N]
    stroke: ComplexArray  # displacement of the port (harmonic,) [m]
    power: float  # mean absorbed power [W]
    bound: float  # no force within the limits absorbs more [W]
    force_rms: float  # [N]
    force_peak: float  # at the instants of collocation [N]
    stroke_peak: float  # likewise [m]
    excess: float  # largest part by which a limit is exceeded between the instants [-]
    steps: int

    @property
    def gap(self) -> float:
        """Distance of the power from its bound, as a part of the bound [-]."""
        return (self.bound - self.power) / max(abs(self.bound), np.finfo(float).tiny)


@njit(cache=True)
def add_weighted(out: FloatArray, toeplitz: ComplexArray, hankel: ComplexArray, gain: ComplexArray) -> None:
    """Add the lower half of C^T W C over real and imaginary parts: of conj(g_k) (T_(k-j) g_j +- H_(k+j) conj(g_j)).

    Parameters
    ----------
    out : ndarray, shape (2 harmonic, 2 harmonic)
        Its first index runs fastest.
    toeplitz, hankel : ndarray, shape (harmonic,), (2 harmonic - 1,)
        See `Harmonics.products`.
    gain : ndarray, shape (harmonic,)
    """
    n = len(gain)
    for j in range(n):
        for k in range(n):
            apart = toeplitz[k - j] if k >= j else np.conj(toeplitz[j - k])
            plain = np.conj(gain[k]) * gain[j] * apart
            mirrored = np.conj(gain[k] * gain[j]) * hankel[k + j]
            out[n + k, j] += plain.imag + mirrored.imag
            if k >= j:
                out[k, j] += plain.real + mirrored.real
                out[n + k, n + j] += plain.real - mirrored.real


@dataclass(frozen=True)
class _Programme:
    """Maximise Re(conj(f) v0)/2 - G |f|^2/2 within limits."""

    harmonics: Harmonics
    velocity: ComplexArray  # v0 (harmonic,)
    loss: FloatArray  # G = Re Y (harmonic,)
    limits: Sequence[Limit]

    def power(self, force: ComplexArray) -> float:
        """Mean power."""
        return float(np.sum((force.conj() * self.velocity).real - self.loss * np.abs(force) ** 2) / 2)

    def values(self, force: ComplexArray) -> list[FloatArray]:
        """What the limits are on, at the instants."""
        return [limit.offset + self.harmonics.signal(limit.gain * force) for limit in self.limits]

    def excess(self, force: ComplexArray) -> float:
        """Largest part by which a limit is exceeded at the instants; negative if none is."""
        pairs = zip(self.limits, self.values(force), strict=True)
        return max((float(np.abs(value).max()) / limit.largest - 1 for limit, value in pairs), default=-1.0)

    def pull(self, multipliers: Sequence[FloatArray]) -> ComplexArray:
        """C^H mu, shape (harmonic,)."""
        pairs = zip(self.limits, multipliers, strict=True)
        return np.asarray(sum(limit.gain.conj() * self.harmonics.phasors(mu) for limit, mu in pairs))

    def bound(self, upper: Sequence[FloatArray], lower: Sequence[FloatArray]) -> float:
        """Upper bound of the power by the multipliers of both sides of the limits, all >= 0."""
        net = [p - m for p, m in zip(upper, lower, strict=True)]
        held = sum(
            limit.largest * float((p + m).sum()) - float(limit.offset @ mu)
            for limit, p, m, mu in zip(self.limits, upper, lower, net, strict=True)
        )
        free = np.abs(self.velocity / 2 - self.pull(net)) ** 2 / (2 * self.loss)
        return held + float(free.sum())

    def matrix(self, weights: Sequence[FloatArray]) -> FloatArray:
        """G + C^T W C over real and imaginary parts of the force, its lower half, (2 harmonic, 2 harmonic)."""
        n = self.harmonics.count
        out = np.zeros((2 * n, 2 * n), order="F")
        for limit, weight in zip(self.limits, weights, strict=True):
            add_weighted(out, *self.harmonics.products(weight / 2), limit.gain)
        out[np.diag_indices(2 * n)] += np.tile(self.loss, 2)
        return out

    @property
    def least(self) -> float:
        """Power no force within the limit of force falls below; -inf if force is free."""
        forces = [limit.largest for limit in self.limits if limit.plain]
        if not forces:
            return -np.inf
        size = np.sqrt(2) * min(forces)  # |f| of a signal whose mean square is below the square of the limit
        return float(-(size * np.linalg.norm(self.velocity) + self.loss.max() * size**2) / 2)


@dataclass(frozen=True)
class _Point:
    """Force, slacks and multipliers of both sides of all limits: arrays (limit, side, instant), all above 0."""

    force: ComplexArray
    slack: FloatArray
    multiplier: FloatArray

    @property
    def mean_product(self) -> float:
        """Mean of slack times multiplier: 0 at the optimum."""
        return float((self.slack * self.multiplier).mean())

    def moved(self, step: "_Point", share: float) -> "_Point":
        """The point a part of the way to the boundary further on, never more than the whole step."""
        primal = min(1.0, share * _room(self.slack, step.slack))
        dual = min(1.0, share * _room(self.multiplier, step.multiplier))
        return _Point(
            self.force + primal * step.force,
            self.slack + primal * step.slack,
            self.multiplier + dual * step.multiplier,
        )


def _room(value: FloatArray, change: FloatArray) -> float:
    """How many times a change may be made before a value reaches 0."""
    return float(1 / max(np.max(-change / value), 1e-30))


SIDES = np.array([1.0, -1.0])[:, None]


def _slacks(programme: _Programme, force: ComplexArray) -> FloatArray:
    """Distance to both sides of the limits, shape (limit, side, instant); negative beyond."""
    pairs = zip(programme.limits, programme.values(force), strict=True)
    return np.array([limit.largest - SIDES * value for limit, value in pairs])


def _start(programme: _Programme) -> _Point:
    """No force, slacks off the boundary, multipliers of the size of what there is to absorb."""
    force = np.zeros(programme.harmonics.count, dtype=complex)
    least = np.array([0.1 * limit.largest for limit in programme.limits])[:, None, None]
    slack = np.maximum(_slacks(programme, force), least)
    matched = float(np.sum(np.abs(programme.velocity) ** 2 / (8 * programme.loss)))
    return _Point(force, slack, matched / (slack.size * slack))


def _newton(programme: _Programme, at: _Point, factor: tuple[FloatArray, bool], target: FloatArray | float) -> _Point:
    """Step to where slack times multiplier equals a target and the slacks are the distances."""
    missing = _slacks(programme, at.force) - at.slack
    wanted = (target - at.multiplier * missing) / at.slack
    gradient = programme.velocity / 2 - programme.loss * at.force
    gradient = gradient - programme.pull([w[0] - w[1] for w in wanted])
    solved = cho_solve(factor, np.concatenate([gradient.real, gradient.imag]), check_finite=False)
    force = solved[: len(gradient)] + 1j * solved[len(gradient) :]
    moved = np.array([SIDES * programme.harmonics.signal(limit.gain * force) for limit in programme.limits])
    slack = missing - moved
    return _Point(force, slack, (target - at.multiplier * slack) / at.slack - at.multiplier)


def _predicted_and_corrected(programme: _Programme, at: _Point) -> _Point:
    """One step of Mehrotra's method: straight for the optimum first, then centred as well as that went."""
    weights = at.multiplier / at.slack
    matrix = programme.matrix([w[0] + w[1] for w in weights])
    factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
    straight = _newton(programme, at, factor, 0.0)
    centring = (at.moved(straight, 1.0).mean_product / at.mean_product) ** 3
    target = centring * at.mean_product - straight.slack * straight.multiplier
    return at.moved(_newton(programme, at, factor, target), SHARE_OF_THE_WAY)


def _solved(programme: _Programme, tolerance: float) -> tuple[ComplexArray, float, int]:
    """The best force, the bound of its power, and the steps it took."""
    at, best = _start(programme), np.inf
    for steps in range(MOST_STEPS):
        best = min(best, programme.bound(list(at.multiplier[:, 0]), list(at.multiplier[:, 1])))
        if best < programme.least:
            raise StabilityError(
                "pto: no force within force_limit keeps stroke_limit in this sea (proof: it would absorb at most "
                f"{best:.6g} W, and {programme.least:.6g} W is the least a force can do); raise one of them"
            )
        power = programme.power(at.force)
        if programme.excess(at.force) < KEPT and best - power <= tolerance * abs(best):
            return at.force, best, steps
        at = _predicted_and_corrected(programme, at)
    raise ConvergenceError(
        f"pto: the optimum under limits is not found to {tolerance:g} in {MOST_STEPS} steps (gap "
        f"{(best - power) / abs(best):.2g}); needs limits that leave more room"
    )


def optimum_in_sea(
    port: Port, sea: Sea, harmonics: Harmonics, force_limit: float = np.inf, stroke_limit: float = np.inf
) -> ConstrainedOptimum:
    """Return the optimum of a port known at the harmonics of a sea; see `constrained_optimum`."""
    amplitude = np.zeros(harmonics.count, dtype=complex)
    amplitude[np.rint(sea.omega / harmonics.spacing - harmonics.first).astype(int)] = sea.amplitude
    return constrained_optimum(harmonics, port.velocity * amplitude, port.admittance, force_limit, stroke_limit)


def constrained_optimum(
    harmonics: Harmonics,
    velocity: ComplexArray,
    admittance: ComplexArray,
    force_limit: float = np.inf,
    stroke_limit: float = np.inf,
    tolerance: float = 1e-6,
) -> ConstrainedOptimum:
    """Return the most any take-off absorbs at a port within limits, and the bound that proves it.

    Parameters
    ----------
    harmonics : Harmonics
        Those the force may have; the sea's among them.
    velocity : ndarray, shape (harmonic,) [m/s]
        Free velocity V0 of the port, amplitude and phase of the sea included.
    admittance : ndarray, shape (harmonic,) [m/(N s)]
        Y of the port; its real part above 0.
    force_limit, stroke_limit : float [N], [m]
        Of |F| and of the displacement of the port from rest.
    tolerance : float [-]
        Largest gap between power and bound.

    Raises
    ------
    ValueError
        If the port is not passive at one of the frequencies.
    StabilityError
        If no force within its limit keeps the stroke within its own; the certificate is in the message.
    ConvergenceError
    """
    if not np.all(admittance.real > 0):
        worst = int(np.argmin(admittance.real))
        raise ValueError(
            f"port: received Re Y = {admittance.real[worst]:.3g} m/(N s) at {harmonics.omega[worst]:.4g} rad/s, needs "
            "more than 0: a port that gives out energy has no optimum"
        )
    integral = 1 / (-1j * harmonics.omega)  # velocity to displacement
    still = np.zeros(harmonics.instants)
    limits = []
    if np.isfinite(force_limit):
        limits.append(Limit(still, np.ones(harmonics.count, dtype=complex), force_limit))
    if np.isfinite(stroke_limit):
        limits.append(Limit(harmonics.signal(velocity * integral), -admittance * integral, stroke_limit))
    programme = _Programme(harmonics, velocity, admittance.real, limits)
    matched: ComplexArray = velocity / (2 * admittance.real)
    if programme.excess(matched) <= 0:
        force, bound, steps = matched, programme.power(matched), 0
    else:
        force, bound, steps = _solved(programme, tolerance)
    return _reported(programme, force, (velocity - admittance * force) * integral, bound, steps)


def _reported(
    programme: _Programme, force: ComplexArray, stroke: ComplexArray, bound: float, steps: int
) -> ConstrainedOptimum:
    """An optimum with its peaks and what exceeds the limits between the instants."""
    signal = programme.harmonics.signal
    between = [
        float(np.abs(signal(force if limit.plain else stroke, BETWEEN)).max()) / limit.largest - 1
        for limit in programme.limits
    ]
    return ConstrainedOptimum(
        force,
        stroke,
        programme.power(force),
        bound,
        float(np.linalg.norm(force) / np.sqrt(2)),
        float(np.abs(signal(force)).max()),
        float(np.abs(signal(stroke)).max()),
        max([0.0, *between]),
        steps,
    )
