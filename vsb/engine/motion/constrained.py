"""The best force found within limits of force and stroke, and the bound of every force within them.

In a sea that repeats after a period, force F = Re sum f_k exp(-i omega_k t) and port velocity V = V0 - Y F give
the mean power P = sum Re(conj(f_k) v0_k)/2 - Re(Y_k) |f_k|^2/2, which is concave because the port is passive. No force
within the limits, whatever its harmonics and whether causal or not, absorbs more than the bound of
`vsb.engine.motion.force_bound`. This assumes linear hydrodynamics, a periodic steady state, and no other force beside F
(such as an end stop).

Where only the force limit is active, the force found is linear between nodes: it keeps its limit at every instant, and
the power dissipated by its harmonics outside the band is subtracted. Where the stroke limit is active, the force has
harmonics of the band only and both limits hold at the collocation instants. It is found by Mehrotra's interior-point
method on the condensed matrix Re Y + C^T W C with a weight per instant in W; its Toeplitz and Hankel parts are each one
Fourier transform of the weights. Such a force may be several per cent below the bound.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from vsb.engine.motion.force_bound import NODES, ForceBound, Harmonics, Limits, add_weighted, force_bound
from vsb.engine.motion.port import Port
from vsb.engine.waves.seas import Sea
from vsb.errors import ConvergenceError, StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray

BETWEEN = 8
"""Refinement of the time grid on which limits are checked between the collocation instants."""
REFINED = 0.002
"""Distance from the bound above which a piecewise-linear force is optimised again, losses outside the band included."""
STEP_FRACTION = 0.995  # of the distance to the boundary
MOST_STEPS = 80
KEPT = 1e-9
"""Relative tolerance on limits at the collocation instants."""
TOLERANCE = 1e-6
"""Of the power of the best force with harmonics of the band [-]."""


@dataclass(frozen=True)
class Limit:
    """A limit on |offset(t) + Re sum gain_k f_k exp(-i omega_k t)| at every instant."""

    offset: FloatArray  # (instant,) signal without force
    gain: ComplexArray  # (harmonic,) per unit of force
    largest: float

    @property
    def plain(self) -> bool:
        """Whether the limited signal is the force itself."""
        return bool(np.all(self.gain == 1)) and not self.offset.any()


class NoForceFoundError(StabilityError):
    """No force with harmonics of the band keeps the limits, but that no other force does is not proved."""

    bound = np.inf  # no force within the limits absorbs more [W]


class ConstrainedOptimum(NamedTuple):
    """The best force found within limits, its power, and the bound of every force within them."""

    force: ComplexArray  # f (harmonic,) [N]
    stroke: ComplexArray  # displacement of the port (harmonic,) [m]
    power: float  # mean absorbed power [W]
    bound: float  # no force within the limits absorbs more, whatever its harmonics [W]
    force_rms: float  # [N]
    force_peak: float  # [N]
    stroke_peak: float  # [m]
    excess: float  # largest relative excess over a limit between the collocation instants [-]
    steps: int

    @property
    def gap(self) -> float:
        """Distance of the power from its bound over the bound [-]."""
        return (self.bound - self.power) / max(abs(self.bound), np.finfo(float).tiny)


SIDES = np.array([1.0, -1.0])[:, None]


@dataclass(frozen=True)
class _Programme:
    """Maximise Re(conj(f) v0)/2 - G |f|^2/2 within limits."""

    harmonics: Harmonics
    velocity: ComplexArray  # v0 (harmonic,)
    admittance: ComplexArray  # Y (harmonic,)
    limits: Sequence[Limit]

    @property
    def loss(self) -> FloatArray:
        """G = Re Y, shape (harmonic,)."""
        return self.admittance.real

    def power(self, force: ComplexArray) -> float:
        """Mean power."""
        return float(np.sum((force.conj() * self.velocity).real - self.loss * np.abs(force) ** 2) / 2)

    def slacks(self, force: ComplexArray) -> FloatArray:
        """Distance to both sides of the limits, shape (limit, side, instant); negative beyond."""
        pairs = zip(self.limits, self.values(force), strict=True)
        return np.array([limit.largest - SIDES * value for limit, value in pairs])

    def values(self, force: ComplexArray) -> list[FloatArray]:
        """Limited signals at the collocation instants."""
        return [limit.offset + self.harmonics.signal(limit.gain * force) for limit in self.limits]

    def excess(self, force: ComplexArray) -> float:
        """Largest relative excess over a limit at the instants; negative if all are kept."""
        pairs = zip(self.limits, self.values(force), strict=True)
        return max((float(np.abs(value).max()) / limit.largest - 1 for limit, value in pairs), default=-1.0)

    def pull(self, multipliers: FloatArray) -> ComplexArray:
        """C^H mu of multipliers (limit, instant), shape (harmonic,)."""
        pairs = zip(self.limits, multipliers, strict=True)
        return np.asarray(sum(limit.gain.conj() * self.harmonics.phasors(mu) for limit, mu in pairs))

    def bound(self, multiplier: FloatArray) -> float:
        """Upper bound of the power of forces of the band from multipliers >= 0 (limit, side, instant) of the limits."""
        net = multiplier[:, 0] - multiplier[:, 1]
        held = sum(
            limit.largest * float((p + m).sum()) - float(limit.offset @ mu)
            for limit, (p, m), mu in zip(self.limits, multiplier, net, strict=True)
        )
        free = np.abs(self.velocity / 2 - self.pull(net)) ** 2 / (2 * self.loss)
        return held + float(free.sum())

    def matrix(self, weights: FloatArray) -> FloatArray:
        """G + C^T W C over real and imaginary parts of the force, its lower half; W (limit, instant)."""
        n = self.harmonics.count
        out = np.zeros((2 * n, 2 * n), order="F")
        for limit, weight in zip(self.limits, weights, strict=True):
            add_weighted(out, *self.harmonics.products(weight / 2), limit.gain[None])
        out[np.diag_indices(2 * n)] += np.tile(self.loss, 2)
        return out

    @property
    def least(self) -> float:
        """Lower bound of the power in the band of any force within its limit; -inf if the force is not limited."""
        forces = [limit.largest for limit in self.limits if limit.plain]
        if not forces:
            return -np.inf
        size = np.sqrt(2) * min(forces)  # largest |f|: the mean square is at most the square of the limit
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
        """The next iterate, at most a share of the way to the boundary or the whole step."""
        primal, dual = (
            min(1.0, share * float(1 / max(np.max(-change / value), 1e-30)))  # until a value reaches 0
            for value, change in ((self.slack, step.slack), (self.multiplier, step.multiplier))
        )
        return _Point(
            self.force + primal * step.force,
            self.slack + primal * step.slack,
            self.multiplier + dual * step.multiplier,
        )


def _newton(programme: _Programme, at: _Point, factor: tuple[FloatArray, bool], target: FloatArray | float) -> _Point:
    """Newton step towards slack times multiplier equal to a target, with slacks consistent with the force."""
    missing = programme.slacks(at.force) - at.slack
    wanted = (target - at.multiplier * missing) / at.slack
    gradient = programme.velocity / 2 - programme.loss * at.force
    gradient = gradient - programme.pull(wanted[:, 0] - wanted[:, 1])
    solved = cho_solve(factor, np.concatenate([gradient.real, gradient.imag]), check_finite=False)
    force = solved[: len(gradient)] + 1j * solved[len(gradient) :]
    moved = np.array([SIDES * programme.harmonics.signal(limit.gain * force) for limit in programme.limits])
    slack = missing - moved
    return _Point(force, slack, (target - at.multiplier * slack) / at.slack - at.multiplier)


def _solved(programme: _Programme) -> tuple[ComplexArray, int]:
    """The best force with harmonics of the band, by Mehrotra's predictor-corrector method, and the number of steps."""
    # no force, slacks off the boundary, multipliers of the order of the available power
    force = np.zeros(programme.harmonics.count, dtype=complex)
    least = np.array([0.1 * limit.largest for limit in programme.limits])[:, None, None]
    slack = np.maximum(programme.slacks(force), least)
    matched = float(np.sum(np.abs(programme.velocity) ** 2 / (8 * programme.loss)))
    at, best = _Point(force, slack, matched / (slack.size * slack)), np.inf
    for steps in range(MOST_STEPS):
        best = min(best, programme.bound(at.multiplier))
        if best < programme.least:
            raise NoForceFoundError(
                f"pto: no force of the {programme.harmonics.count} harmonics up to "
                f"{programme.harmonics.omega[-1]:.4g} rad/s within force_limit keeps stroke_limit in this sea; whether "
                "another does is not known; raise one of them"
            )
        power = programme.power(at.force)
        if programme.excess(at.force) < KEPT and best - power <= TOLERANCE * abs(best):
            return at.force, steps
        weights = at.multiplier / at.slack
        matrix = programme.matrix(weights[:, 0] + weights[:, 1])
        factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
        straight = _newton(programme, at, factor, 0.0)
        centring = (at.moved(straight, 1.0).mean_product / at.mean_product) ** 3
        target = centring * at.mean_product - straight.slack * straight.multiplier
        at = at.moved(_newton(programme, at, factor, target), STEP_FRACTION)
    raise ConvergenceError(
        f"pto: the optimum under limits is not found to {TOLERANCE:g} in {MOST_STEPS} steps (gap "
        f"{(best - power) / abs(best):.2g}); needs limits that leave more room"
    )


def optimum_in_sea(port: Port, sea: Sea, harmonics: Harmonics, limits: Limits) -> ConstrainedOptimum:
    """Return the optimum of a port known at `harmonics.port_omega`; see `constrained_optimum`."""
    amplitude = np.zeros(harmonics.count, dtype=complex)
    amplitude[np.rint(sea.omega / harmonics.spacing - harmonics.first).astype(int)] = sea.amplitude
    return constrained_optimum(harmonics, port, amplitude, limits)


def constrained_optimum(
    harmonics: Harmonics, port: Port, amplitude: ComplexArray, limits: Limits
) -> ConstrainedOptimum:
    """Return the best force found at a port within limits, and the bound of every force within them.

    Raises `ValueError` if the port is not passive at one of the frequencies; `StabilityError` if it is proved that no
    force within its limit keeps the stroke limit; `NoForceFoundError` if no force with harmonics of the band does, but
    another force might; `ConvergenceError`.

    Parameters
    ----------
    harmonics : Harmonics
        The band used by the bound; it includes the harmonics of the sea.
    port : Port
        At `harmonics.omega`, then at `harmonics.outside`, where it only gives the power dissipated by the force found.
        Its real part is positive.
    amplitude : ndarray, shape (harmonic,) [m]
        Of the waves.
    """
    if not np.all(port.admittance.real > 0):
        worst = int(np.argmin(port.admittance.real))
        raise ValueError(
            f"port: not passive at {port.omega[worst]:.4g} rad/s, received Re Y = {port.admittance.real[worst]:.3g} "
            "m/(N s), needs more than 0"
        )
    band = port.at(np.arange(harmonics.count))
    velocity, admittance = band.velocity * amplitude, band.admittance
    integral = 1 / (-1j * harmonics.omega)  # velocity to displacement
    still = np.zeros(harmonics.instants)
    kept = []
    if np.isfinite(limits.force):
        kept.append(Limit(still, np.ones(harmonics.count, dtype=complex), limits.force))
    if np.isfinite(limits.stroke):
        kept.append(Limit(harmonics.signal(velocity * integral), -admittance * integral, limits.stroke))
    programme = _Programme(harmonics, velocity, admittance, kept)
    matched: ComplexArray = velocity / (2 * admittance.real)
    if programme.excess(matched) <= 0:
        return _reported(programme, matched, programme.power(matched), 0)
    most = programme.power(matched)
    if np.isfinite(limits.force):
        limited = force_bound(harmonics, velocity, admittance, Limits(limits.force))
        free = _linear_between_nodes(harmonics, port, velocity, limited.force, limited.power, limited.steps)
        if free.gap > REFINED:
            refined = _refined(harmonics, port, velocity, limits.force, limited)
            free = _linear_between_nodes(harmonics, port, velocity, refined, limited.power, limited.steps)
        if free.stroke_peak <= limits.stroke:
            return free
        most = min(most, limited.power)
    proved = force_bound(harmonics, velocity, admittance, limits, programme.least)
    if proved.power < programme.least:
        raise StabilityError(
            "pto: no force within force_limit keeps stroke_limit in this sea (proof: it would absorb at most "
            f"{proved.power:.6g} W, and {programme.least:.6g} W is the least a force can do); raise one of them"
        )
    bound = min(most, proved.power)
    try:
        force, steps = _solved(programme)
    except NoForceFoundError as error:
        error.bound = bound
        raise
    return _reported(programme, force, bound, steps)


def _linear_between_nodes(
    harmonics: Harmonics, port: Port, velocity: ComplexArray, values: FloatArray, bound: float, steps: int
) -> ConstrainedOptimum:
    """The optimum of a piecewise-linear force, with losses and stroke of its harmonics outside the band.

    A mean force displaces a port with a finite compliance; from a port that would drift it is removed.
    """
    mean = 0.0 if harmonics.first % 1 else float(values.mean())
    if mean and not np.isfinite(port.compliance):
        peak = np.abs(values).max()
        values, mean = (values - mean) * peak / (peak + abs(mean)), 0.0
    nodes, outside = len(values), harmonics.outside
    shares = np.sinc((harmonics.first + np.arange(harmonics.count)) / nodes) ** 2
    force = 2 / nodes * shares * harmonics.phasors(values)
    beyond = 2 / nodes * np.sinc(outside / harmonics.spacing / nodes) ** 2 * harmonics.phasors_outside(values)
    band, rest = port.admittance[: harmonics.count], port.admittance[harmonics.count :]
    stroke = (velocity - band * force) / (-1j * harmonics.omega)
    power = float(np.sum((force.conj() * velocity).real - band.real * np.abs(force) ** 2) / 2)
    power -= float(np.sum(rest.real * np.abs(beyond) ** 2) / 2)
    moved = harmonics.signal(stroke, BETWEEN, -rest * beyond / (-1j * outside))
    moved -= mean * port.compliance if mean else 0.0
    following = np.append(values[1:], -values[0] if harmonics.first % 1 else values[0])
    rms = float(np.sqrt(np.mean(values**2 + values * following + following**2) / 3))
    peaks = float(np.abs(values).max()), float(np.abs(moved).max())
    return ConstrainedOptimum(force, stroke, power, bound, rms, *peaks, 0.0, steps)


def _refined(harmonics: Harmonics, port: Port, velocity: ComplexArray, limit: float, bound: ForceBound) -> FloatArray:
    """Node values of the best piecewise-linear force within a limit, losses outside the band included.

    The power is concave in the node values and they are limited separately: L-BFGS-B.
    """
    nodes, band = len(bound.force), harmonics.count
    inside = 2 * limit / nodes * np.sinc(harmonics.omega / harmonics.spacing / nodes) ** 2
    beyond = 2 * limit / nodes * np.sinc(harmonics.outside / harmonics.spacing / nodes) ** 2
    loss, lost = port.admittance.real[:band], port.admittance.real[band:]

    def negative_power(u: FloatArray) -> tuple[float, FloatArray]:
        f, g = inside * harmonics.phasors(u), beyond * harmonics.phasors_outside(u)
        power = np.sum((f.conj() * velocity).real - loss * np.abs(f) ** 2) / 2 - np.sum(lost * np.abs(g) ** 2) / 2
        slope = harmonics.signal(inside * (velocity / 2 - loss * f), NODES, -beyond * lost * g)
        return -float(power) / bound.power, -slope / bound.power

    best = minimize(
        negative_power, bound.force / limit, jac=True, method="L-BFGS-B", bounds=[(-1.0, 1.0)] * nodes,
        options={"ftol": 1e-8, "gtol": 0.0},
    )  # fmt: skip
    return limit * np.asarray(best.x)


def _reported(programme: _Programme, force: ComplexArray, bound: float, steps: int) -> ConstrainedOptimum:
    """The optimum of a force with harmonics of the band, its peaks and the excess over the limits between instants."""
    signal, limits = programme.harmonics.signal, programme.limits
    moved = programme.velocity - programme.admittance * force
    stroke = moved / (-1j * programme.harmonics.omega)
    between = [
        float(np.abs(signal(force if limit.plain else stroke, BETWEEN)).max()) / limit.largest - 1 for limit in limits
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
