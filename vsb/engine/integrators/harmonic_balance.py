"""Steady state in a regular wave without its transient: harmonic balance, stability and power of the periodic orbit.

With the natural modes u of the scene, y = S u, the motion with the wave's period is u(t) = Re sum U_h exp(-i h omega t)
(C1) and solves, h = 0..H,

    Z(h omega) U_h = G_h,    Z(w) = diag(s) - w^2 - i w (D + conj K(i w)),

with s the squared natural frequencies and K the radiation at any frequency, of the memory's state space or directly
from the damping. G are the harmonics of the nonlinear forces beyond their tangents, from samples of the orbit. Newton's
method couples the low harmonics through the tangent along the orbit; the others, where Z dominates, follow by
substitution. The residual at instants between the samples gives the error. Floquet multipliers tell whether the orbit
is stable.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from vsb.engine.integrators.collocation import NODES, step_of
from vsb.engine.integrators.exact import steady_state
from vsb.engine.motion.system import EXCITING, System
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray

# periodic functions and linear equations with periodic coefficients: f = Re sum F_h exp(-i h phase), h = 0, 1, ... (C1)


SAMPLES = (32, 128, 512, 2048)
"""Samples of a period tried for its multipliers."""
AGREEMENT = 1e-7
"""Tolerance of the largest multiplier, or a hundredth of its distance from one if that is larger."""


def phases(count: int, offset: float = 0.0) -> FloatArray:
    """Return equally spaced phases of a period [rad], the first `offset` of a distance after zero, shape (count,)."""
    return 2 * np.pi / count * (np.arange(count) + offset)


def harmonics_of(samples: FloatArray) -> ComplexArray:
    """Return F_h from an even number of equally spaced samples of a period, shape (sample/2, ...)."""
    count = len(samples)
    out = 2 / count * np.conj(np.fft.rfft(samples, axis=0))[: count // 2]
    out[0] /= 2
    return np.asarray(out)


def synthesized(harmonics: ComplexArray, phase: FloatArray) -> FloatArray:
    """Return f at some phases, shape (phase, ...)."""
    return np.real(np.exp(-1j * np.outer(phase, np.arange(len(harmonics)))) @ harmonics)


def largest(harmonics: ComplexArray) -> float:
    """Return a bound of a signal from its harmonics, of the component where it is largest."""
    return float(np.abs(harmonics).sum(axis=0).max(initial=0.0))


def hill_matrix(matrix: ComplexArray, count: int) -> FloatArray:
    """Return the real matrix from the harmonics of u to those of E(t) u(t), shape (2, count, free, 2, count, free).

    Of E its harmonics (harmonic, free, free), those beyond being zero. Axes are real and imaginary parts, harmonics and
    components of the product, then of u; the mean has no imaginary part. With two-sided T_m, T_-m = conj T_m, the
    product has harmonics sum_k T_(h-k) U_k + T_(h+k) conj U_k, the mean of u twice in all but the mean of the product.
    """
    two_sided = np.zeros((max(2 * count - 1, len(matrix)), *matrix.shape[1:]), dtype=complex)
    two_sided[: len(matrix)] = matrix / 2
    two_sided[0] *= 2
    order = np.arange(count)
    apart = order[:, None] - order
    direct = np.where((apart >= 0)[..., None, None], two_sided[np.abs(apart)], two_sided[np.abs(apart)].conj())
    mirrored = two_sided[order[:, None] + order]
    mirrored[:, 0] = 0.0
    mirrored[0] /= 2
    direct[1:, 0] *= 2
    direct[0, 1:] /= 2
    plus, minus = direct + mirrored, direct - mirrored
    blocks = np.array([[plus.real, -minus.imag], [plus.imag, minus.real]])
    blocks[:, 1, :, 0], blocks[1, :, 0] = 0.0, 0.0
    return np.ascontiguousarray(blocks.transpose(0, 2, 4, 1, 3, 5))


def monodromy(matrix: FloatArray, coupling: FloatArray, period: float) -> FloatArray:
    """Return the change of z over a period [s] of z' = (A + B W(t) P) z, shape (state, state).

    Of W its values (sample, free, seen) [1/s] at equally spaced instants, a multiple of four of them: rates of
    z[free:2 free] per unit z[:seen]. Exponential collocation: W P z is a polynomial through the five instants of a
    step, the rest exact. Order 6, where A is stiff 5; what is seen at the nodes solves
    p_i = exp(i d A) z + sum_j F_ij W_j p_j.
    """
    (_, free, seen), size, inner = coupling.shape, len(matrix), NODES - 1
    steps = len(coupling) // inner
    step = step_of(matrix, np.eye(size, free, -free), period / steps, inner)  # forces act on the rates
    exact, forced = step.free, step.forced.reshape(inner, size, NODES, free)
    nodes = coupling[(inner * np.arange(steps)[:, None] + np.arange(NODES)) % len(coupling)]
    first = np.concatenate([nodes[:, 0], np.zeros((steps, free, size - seen))], axis=2)  # W P z at the start
    mutual = np.einsum("iajf,sjfg->siajg", forced[:, :seen, 1:], nodes[:, 1:]).reshape(steps, inner * seen, -1)
    alone = exact[:, :seen] + np.einsum("iaf,sfz->siaz", forced[:, :seen, 0], first)
    there = np.linalg.solve(np.eye(inner * seen) - mutual, alone.reshape(steps, inner * seen, size))
    acting = nodes[:, 1:] @ there.reshape(steps, inner, seen, size)
    ends = exact[-1] + forced[-1, :, 0] @ first + np.einsum("ajf,sjfz->saz", forced[-1, :, 1:], acting)
    whole: FloatArray = reduce(np.matmul, ends[::-1])
    return whole


def multipliers(matrix: FloatArray, coupling: Callable[[FloatArray], FloatArray], period: float) -> ComplexArray:
    """Return the Floquet multipliers of z' = (A + B W(t) P) z, largest first, shape (state,).

    `coupling` gives W at phases [rad]; see `monodromy`. Raises `ConvergenceError` if the largest is not resolved: stiff
    modes without damping need more samples.
    """
    for count in SAMPLES:
        sampled = coupling(phases(count))
        values, coarse = (np.linalg.eigvals(monodromy(matrix, sampled[::every], period)) for every in (1, 2))
        growth, before = (float(np.abs(found).max()) for found in (values, coarse))
        if abs(growth - before) < max(AGREEMENT, 0.01 * abs(1 - growth)):
            return np.asarray(values[np.argsort(-np.abs(values))], dtype=complex)
    raise ConvergenceError(
        f"stability of a periodic motion cannot be determined: a disturbance grows by {growth:.6g} in a period, "
        f"or by {before:.6g} with half the samples; add structural damping, or follow the motion in time."
    )


# steady states ------------------------------------------------------------------------------------------------------


Transfer = Callable[[FloatArray], ComplexArray]
"""Radiation K(i w) = B + i w (A - A(infinity)), shape (omega, dof, dof) [N s/m], at any w > 0."""


def regular_frequency(system: System) -> float:
    """Return the frequency of the waves or the assumed pressure of a scene, zero without either [rad/s].

    Raises `ConfigError` if there are several, or a load without a period.
    """
    known = system.frequencies.tolist()
    if len(known) > 1 or 0.0 in known:
        raise ConfigError(
            f"waves: received {len(known)} frequencies from {min(known):.4g} to {max(known):.4g} rad/s, needs one "
            "above zero: only a regular wave has a steady state; use kind: regular, or follow the motion in time."
        )
    return float(known.pop()) if known else 0.0


@dataclass(frozen=True)
class PeriodicScene:
    """A scene in a regular wave, in its natural modes."""

    system: System
    omega: float
    transfer: Transfer | None  # of radiation; none: nothing radiates

    def memories(self, omega: FloatArray) -> dict[str, ComplexArray]:
        """Return conj K between the modes of every force with memory, -conj K U' (C1), each (omega, free, free)."""
        others = {name: model.transfer for name, model in self.system.scene.memories.items() if name != "radiation"}
        known = others if self.transfer is None else {"radiation": self.transfer, **others}
        shapes = self.system.shapes
        return {name: np.asarray(shapes.T @ transfer(omega).conj() @ shapes) for name, transfer in known.items()}

    def impedance(self, count: int) -> ComplexArray:
        """Return Z of the harmonics below `count`, shape (count, free, free) [1/s^2]."""
        free = self.system.free
        squares = -np.diag(self.system.matrix[free : 2 * free, :free]) * self.system.scale
        omega = self.omega * np.arange(1, count)
        damping = sum(self.memories(omega).values(), -self.system.matrix[free : 2 * free, free : 2 * free])
        moving = np.diag(squares) - omega[:, None, None] ** 2 * np.eye(free) - 1j * omega[:, None, None] * damping
        return np.concatenate([np.diag(squares)[None].astype(complex), moving])

    def states(self, harmonics: ComplexArray, phase: FloatArray) -> FloatArray:
        """Return z of the modes and their rates along an orbit, shape (phase, 2 free)."""
        rates = -1j * self.omega * np.arange(len(harmonics))[:, None] * harmonics
        return synthesized(np.hstack([self.system.scale * harmonics, rates]), phase)

    def remainder(self, phase: FloatArray, z: FloatArray) -> FloatArray:
        """Return the nonlinear forces on the modes beyond their tangents, shape (phase, free)."""
        return self.system.added(phase / self.omega, z)

    def tangents(self, phase: FloatArray, z: FloatArray) -> FloatArray:
        """Return E = d remainder/d(u, u') along an orbit by central differences, shape (phase, free, free or 2 free).

        Rates count only where a force beyond the water's depends on them.
        """
        count, free = len(z), self.system.free
        if self.system.linear:
            return np.zeros((count, free, free))
        step = self.system.size / np.abs(self.system.shapes).max(axis=0)
        steps, moves = step, step * self.system.scale
        if self.system.not_compiled:
            steps, moves = (np.append(x, self.omega * step) for x in (steps, moves))
        away = np.eye(len(moves), z.shape[1])[:, None] * moves[:, None, None]
        moved = np.concatenate([z + away, z - away]).reshape(-1, z.shape[1])
        force = self.remainder(np.tile(phase, 2 * len(moves)), moved).reshape(2, len(moves), count, free)
        return np.asarray(((force[0] - force[1]) / (2 * steps[:, None, None])).transpose(1, 2, 0))

    def coupling(self, harmonics: ComplexArray, phase: FloatArray) -> FloatArray:
        """Return E along an orbit as it acts in the linear system, shape (phase, free, free or 2 free) [1/s]."""
        out = self.tangents(phase, self.states(harmonics, phase))
        out[..., : self.system.free] /= self.system.scale
        return out

    def forced(self, harmonics: ComplexArray, phase: FloatArray) -> ComplexArray:
        """Return G of an orbit, sampled at phases a whole period long, shape (sample/2, free)."""
        force = harmonics_of(self.remainder(phase, self.states(harmonics, phase)))
        force *= np.exp(1j * phase[0] * np.arange(len(force)))[:, None]
        if len(self.system.waves):
            force[1] += self.system.waves[0]
        return force

    def amplitude(self, harmonics: ComplexArray) -> float:
        """Return the largest amplitude of any coordinate [m], no less than `size`."""
        return max(largest(harmonics[1:] @ self.system.modes.T), self.system.size) or 1.0


FARTHEST = 1e7
"""Displacement beyond which an orbit is given up, over `System.size`."""
COUPLED, HIGHEST = 16, 1024
"""Harmonics Newton's method couples and starts with, and the most of all."""
MOST_SAMPLES = 16384
"""Of a period, to balance the harmonics."""
STEPS = 30
"""Newton steps of one attempt."""
SLOW = 0.3
"""A step longer than this part of the one before needs a new tangent, which costs as much as a dozen steps."""
LEAST_GROWTH = 1e-4
"""Least increment of the wave when it is raised step by step, over its full height."""
UNSTABLE = 1e-6
"""Growth of a disturbance per period above round-off."""


class Power(NamedTuple):
    """Mean powers over a period [W]: wave = the sum of the others."""

    wave: float
    pto: float
    radiated: float
    structural: float

    @property
    def residual(self) -> float:
        """Unbalanced power over the largest term [-]."""
        size = max(abs(term) for term in self)
        return abs(self.wave - self.pto - self.radiated - self.structural) / size if size else 0.0


@dataclass(frozen=True)
class SteadyState:
    """Periodic motion y(t) = Re sum Y_h exp(-i h omega t) of a scene; at rest without waves: omega = 0."""

    omega: float  # [rad/s]
    harmonics: ComplexArray  # Y (H + 1, free) [m]; the first is the mean
    error: float  # estimated, over the largest amplitude of any coordinate [-]
    iterations: int
    multipliers: ComplexArray  # of a disturbance in a period, by the scene's own memory, largest first (state,)
    power: Power

    @property
    def decay(self) -> float:
        """Remainder of the slowest transient after a period, the largest modulus of the multipliers [-].

        One means that the motion does not approach this steady state: it depends on its start for ever.
        """
        return float(np.abs(self.multipliers).max(initial=0.0))

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return position y [m] and velocity y' [m/s] at any times, each shape (time, free)."""
        order = self.omega * np.arange(len(self.harmonics))
        turn = np.exp(-1j * np.outer(time, order))
        return np.real(turn @ self.harmonics), np.real(turn @ (-1j * order[:, None] * self.harmonics))


class Newton:
    """Newton's method about an orbit: the tangent couples the low harmonics, its mean acts on the others."""

    def __init__(self, scene: PeriodicScene, impedance: ComplexArray, harmonics: ComplexArray, samples: int) -> None:
        phase = phases(samples)
        tangent = harmonics_of(scene.tangents(phase, scene.states(harmonics, phase)))
        free, self.omega = scene.system.free, scene.omega
        mean = np.real(tangent[0])
        self.spring, self.damper = mean[:, :free], mean[:, free:] if mean.shape[1] > free else np.zeros((free, free))
        matrix = -hill_matrix(tangent[..., :free], COUPLED + 1)
        if mean.shape[1] > free:  # u' = -i h omega u
            rates = hill_matrix(tangent[..., free:], COUPLED + 1) * self.omega * np.arange(COUPLED + 1.0)[:, None]
            matrix -= np.stack([-rates[:, :, :, 1], rates[:, :, :, 0]], axis=3)
        for h, z in enumerate(impedance[: COUPLED + 1]):
            matrix[0, h, :, 0, h] += z.real
            matrix[1, h, :, 1, h] += z.real if h else np.eye(free)  # there is no Im U_0
            matrix[0, h, :, 1, h] -= z.imag
            matrix[1, h, :, 0, h] += z.imag
        whole = matrix.reshape(2 * (COUPLED + 1) * free, -1)
        if not whole.any(axis=0).all():
            raise ConvergenceError("harmonic balance: nothing holds a coordinate in a mean place; follow it in time")
        self.factors = lu_factor(whole)

    def step(self, impedance: ComplexArray, missing: ComplexArray) -> ComplexArray:
        """Return the change of the harmonics that cancels a residual, shape (count, free), count > `COUPLED`."""
        low, high = missing[: COUPLED + 1], missing[COUPLED + 1 :]
        solved = lu_solve(self.factors, np.concatenate([low.real, low.imag]).ravel()).reshape(2, *low.shape)
        order = self.omega * np.arange(COUPLED + 1, len(missing))[:, None, None]
        tangent = self.spring - 1j * order * self.damper
        rest = np.linalg.solve(impedance[COUPLED + 1 : len(missing)] - tangent, high[:, :, None])[..., 0]
        return np.concatenate([solved[0] + 1j * solved[1], rest])


class Orbit(NamedTuple):
    """An approximate periodic motion."""

    harmonics: ComplexArray  # U (H + 1, free)
    impedance: ComplexArray  # of half as many harmonics as there are samples (sample/2, free, free)
    newton: Newton
    iterations: int

    @property
    def samples(self) -> int:
        """Samples of a period."""
        return 2 * len(self.impedance)

    @property
    def inertial(self) -> ComplexArray:
        """Z U up to the highest harmonic the samples resolve, shape (sample/2, free)."""
        out = np.zeros(self.impedance.shape[:2], dtype=complex)
        out[: len(self.harmonics)] = np.einsum("hij,hj->hi", self.impedance[: len(self.harmonics)], self.harmonics)
        return out


def balanced(scene: PeriodicScene, orbit: Orbit, tolerance: float) -> Orbit | None:
    """Return the orbit whose harmonics are in balance at its samples, or none if Newton's method does not converge."""
    phase, count, previous = phases(orbit.samples), len(orbit.harmonics), np.inf
    for _ in range(STEPS):
        step = orbit.newton.step(orbit.impedance, (scene.forced(orbit.harmonics, phase) - orbit.inertial)[:count])
        u, change = orbit.harmonics + step, largest(step @ scene.system.modes.T)
        orbit = orbit._replace(harmonics=u, iterations=orbit.iterations + 1)
        if change <= max(0.01 * tolerance * scene.amplitude(u), 1e-7 * scene.system.size):
            return orbit
        if not largest(u @ scene.system.modes.T) < (FARTHEST * scene.system.size or np.inf):
            return None
        if change > SLOW * previous:
            orbit = orbit._replace(newton=Newton(scene, orbit.impedance, u, 2 * COUPLED + 2))
        previous = change
    return None


def missed(scene: PeriodicScene, orbit: Orbit) -> tuple[float, float]:
    """Return the estimated errors of too few samples and of too few harmonics, over the largest amplitude.

    The residual with twice the samples, up to the highest harmonic they resolve, through one Newton step.
    """
    u = orbit.harmonics
    between = [scene.forced(u, phases(orbit.samples, offset)) for offset in (0.0, 0.5)]
    missing = (between[0] + between[1]) / 2 - orbit.inertial
    step = orbit.newton.step(orbit.impedance, missing) @ scene.system.modes.T
    amplitude = scene.amplitude(u)
    return largest(step[: len(u)]) / amplitude, largest(step[len(u) :]) / amplitude


def refined(scene: PeriodicScene, orbit: Orbit, tolerance: float) -> tuple[Orbit, float]:
    """Return the orbit with enough harmonics and samples, and its estimated error.

    Raises `ConvergenceError` if `HIGHEST` harmonics or `MOST_SAMPLES` are not enough.
    """
    while True:
        aliased, cut = missed(scene, orbit)
        if aliased + cut <= tolerance:
            return orbit, aliased + cut
        count, samples = len(orbit.harmonics), orbit.samples
        if cut > aliased:
            count = 2 * count - 1
            samples = max(samples, 4 * count)
        else:
            samples *= 2
        if count > HIGHEST + 1 or samples > MOST_SAMPLES:
            break
        wider = np.concatenate([orbit.harmonics, np.zeros((count - len(orbit.harmonics), scene.system.free))])
        finer = balanced(scene, orbit._replace(harmonics=wider, impedance=scene.impedance(samples // 2)), tolerance)
        if finer is None:
            break
        orbit = finer
    raise ConvergenceError(
        f"the steady state is known to {aliased + cut:.1e} with {len(orbit.harmonics) - 1} harmonics, needs "
        f"{tolerance:g}; use a gentler wave or a larger tolerance, or follow the motion in time."
    )


def continued(scene: PeriodicScene, rest: FloatArray, tolerance: float) -> Orbit:
    """Return the orbit Newton's method reaches from rest, the wave raised step by step where it must be.

    Raises `ConvergenceError` if the wave cannot be raised to its full height.
    """
    first = np.zeros((COUPLED + 1, len(rest)), dtype=complex)
    first[0] = np.linalg.solve(scene.system.modes, rest)
    impedance, calm = scene.impedance(2 * COUPLED), replace(scene, system=scene.system.scaled_waves(0.0))
    orbit, share, growth = Orbit(first, impedance, Newton(calm, impedance, first, 2), 0), 0.0, 1.0
    while share < 1.0:
        there = min(share + growth, 1.0)
        lower = scene if there == 1.0 else replace(scene, system=scene.system.scaled_waves(there))
        reached = balanced(lower, orbit, tolerance)
        if reached:
            orbit, share, growth = reached, there, 2 * growth
        else:
            growth /= 2
        if growth < LEAST_GROWTH:
            raise ConvergenceError(
                f"no steady state is found beyond {100 * share:.3g} % of the wave's amplitude; "
                "use a smaller wave, or follow the motion in time."
            )
    return orbit


def check_stable(factors: ComplexArray, period: float) -> None:
    """Check that no disturbance of an orbit grows; raises `StabilityError`."""
    growth = float(np.abs(factors).max())
    if growth > 1 + UNSTABLE:
        raise StabilityError(
            f"the steady state is unstable: received a disturbance multiplied by {growth:.6g} in every period of "
            f"{period:.4g} s, needs at most 1; the wave leads elsewhere: follow the motion in time, or add damping."
        )


def mean_power(scene: PeriodicScene, orbit: Orbit) -> Power:
    """Return the mean powers of an orbit: of radiation harmonic by harmonic, the others from its samples."""
    system, phase = scene.system, phases(orbit.samples, 0.5)  # between those in balance: what they miss is seen
    z = scene.states(orbit.harmonics, phase)
    q, v = z[:, : system.free] @ (system.shapes / system.scale).T, z[:, system.free :] @ system.shapes.T
    named = system.scene.named(phase / scene.omega, q, v)
    wave = sum(float(np.mean(np.sum(named[name] * v, axis=1))) for name in EXCITING if name in named)
    losses = {name: force.dissipated_power(v) for name, force in system.scene.forces.items()}
    losses |= {name: -np.sum(named[name] * v, axis=1) for name in system.dissipating}
    means = {name: float(np.mean(loss)) for name, loss in losses.items()}
    omega = scene.omega * np.arange(1, len(orbit.harmonics))
    rate = -1j * omega[:, None] * orbit.harmonics[1:]

    def taken(transfer: ComplexArray) -> float:
        return 0.5 * float(np.real(np.einsum("hi,hij,hj", rate.conj(), transfer, rate)))

    for name, transfer in scene.memories(omega).items():
        means[name] = means.get(name, 0.0) + taken(transfer)
    pto, radiated = (means.pop(name, 0.0) for name in (system.scene.take_off, "radiation"))
    return Power(wave, pto, radiated, sum(means.values()))


def harmonic_balance(system: System, tolerance: float = 1e-8, transfer: Transfer | None = None) -> SteadyState:
    """Return the steady state of a scene in a regular wave, linear or body-exact; in still water, at rest.

    Parameters
    ----------
    tolerance : float
        Of the motion's estimated error, relative to the largest amplitude of any coordinate or a millionth of the
        radius.
    transfer : callable, optional
        Radiation at a frequency, e.g. `DampingSpectrum.transfer` for that of the database itself. By default that of
        the scene's memory, so that the steady state is what a long motion in time tends to.

    Raises
    ------
    ConfigError
        In an irregular sea.
    ConvergenceError
        If no steady state is found.
    StabilityError
        If it is unstable, or a linear scene meets an undamped resonance.

    Notes
    -----
    There may be several steady states: this is the one Newton's method reaches from rest, the wave at its full height
    if it can, else raised step by step. The error is estimated from the residual with twice the samples. It falls
    exponentially with the number of harmonics under an assumed pressure, as long as the waterline does not meet a
    pole; in waves as its sixth power, for the forces of crest and trough join with two derivatives only.
    """
    omega, rest, memory = regular_frequency(system), system.scene.rest, system.scene.memories.get("radiation")
    if system.has_latching_time:
        raise ValueError(
            "harmonic balance: received a latching or declutching take-off; needs another, or time domain."
        )
    if not omega:
        return SteadyState(
            0.0, rest[None].astype(complex), 0.0, 0, np.zeros(0, dtype=complex), Power(0.0, 0.0, 0.0, 0.0)
        )
    if system.linear:
        steady_state(system)  # refuses an undamped resonance
    scene = PeriodicScene(system, omega, transfer or (memory.transfer if memory else None))
    orbit, error = refined(scene, continued(scene, rest, tolerance), tolerance)
    disturbed = multipliers(system.matrix, lambda phase: scene.coupling(orbit.harmonics, phase), 2 * np.pi / omega)
    check_stable(disturbed, 2 * np.pi / omega)
    return SteadyState(
        omega,
        orbit.harmonics @ scene.system.modes.T,
        error,
        orbit.iterations,
        disturbed,
        mean_power(scene, orbit),
    )


def steady_power(system: System, tolerance: float = 1e-8, transfer: Transfer | None = None) -> float:
    """Return the mean power absorbed in the steady state [W]; parameters and errors of `harmonic_balance`."""
    return harmonic_balance(system, tolerance, transfer).power.pto
