"""Upper bound of the mean power of every force within limits, and a force whose power comes close to it.

In a sea that repeats after a period the port moves with velocity V = V0 - Y F. A force F =
Re sum f_k exp(-i omega_k t) absorbs the mean power P = sum Re(conj(f_k) v0_k)/2 - Re(Y_k) |f_k|^2/2, summed over all
its harmonics. For any two signals m = Re sum m_k exp(-i omega_k t) and n, every force with |F| <= F_max and
displacement |S| <= S_max satisfies

    P <= F_max <|m|> + S_max <|n|> - sum Re(conj(s0_k) n_k)/2 + sum |v0_k - m_k - conj(gamma_k) n_k|^2/(8 Re Y_k),

where s0 is the displacement without force, gamma = Y/(i omega) the displacement per unit force and <> the mean over
continuous time. The signals m and n contain harmonics up to omega_max only: beyond it the bound uses nothing but
Re Y >= 0, so Y need not be known there. Frequencies of the force that are not in the sea only dissipate power.
Without a force limit m = 0, without a stroke limit n = 0.

The m and n that minimise the bound, with |m| and |n| evaluated at nodes, are found by Mehrotra's interior-point
method. The Toeplitz and Hankel parts of its matrix are each one Fourier transform of weights. The dual solution is
a force that is linear between the nodes, hence within its limit at every instant.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.fft import fft, ifft, next_fast_len
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

POINTS_PER_WAVE = 4
"""Instants of collocation in the shortest period."""
FEWEST_POINTS = 64
BEYOND = 4
"""Highest frequency at which a piecewise-linear force is evaluated, over the highest of the band."""
SPACING = 1e-6
"""Part of the spacing by which a frequency may miss its order."""


@dataclass(frozen=True)
class Harmonics:
    """Equally spaced frequencies (first + k) spacing and the instants of collocation in 2 pi/spacing.

    Raises `ValueError` if twice the first order is no whole number above 0: a signal and its limits would not repeat.
    """

    spacing: float  # [rad/s]
    first: float  # order of the lowest, a multiple of 1/2 [-]
    count: int

    def __post_init__(self) -> None:
        """Check that signals repeat, if only with the other sign."""
        if self.first <= 0 or 2 * self.first % 1 or self.spacing <= 0 or self.count < 1:
            raise ValueError(
                f"harmonics: received first order {self.first:g}, spacing {self.spacing:g} rad/s and {self.count} of "
                "them; needs a first order of 1/2, 1, 3/2, ..., a spacing above 0 and at least one"
            )

    @classmethod
    def of_sea(cls, omega: FloatArray, lowest: float, highest: float) -> Self:
        """Return the harmonics of a sea's components in a band: of a regular wave its own, of others their grid.

        Raises `ConfigError` if the components are no multiples of half their spacing: the sea does not repeat.

        Parameters
        ----------
        omega : ndarray, shape (component,) [rad/s]
            Ascending.
        lowest, highest : float [rad/s]
            The band, the sea within it.
        """
        spacing = float(np.diff(omega).min()) if len(omega) > 1 else float(omega[0])
        orders = omega / spacing
        halves = np.rint(2 * orders)
        if np.abs(2 * orders - halves).max() > SPACING or np.ptp(halves % 2) > 0:
            raise ConfigError(
                f"waves: received components {spacing:.4g} rad/s apart from {omega[0]:.4g} rad/s on, which never "
                "repeat; an optimum under limits needs multiples of half that: change the band or simulation.duration"
            )
        part = float(halves[0] / 2 % 1)
        first = part + max(np.ceil(lowest / spacing - part - SPACING), 0.0 if part else 1.0)
        return cls(spacing, float(first), int(np.floor(highest / spacing - first + SPACING)) + 1)

    @property
    def omega(self) -> FloatArray:
        """Angular frequencies, shape (harmonic,) [rad/s]."""
        return (self.first + np.arange(self.count)) * self.spacing

    @cached_property
    def instants(self) -> int:
        """Number of instants of collocation."""
        return int(next_fast_len(max(FEWEST_POINTS, int(np.ceil(POINTS_PER_WAVE * (self.first + self.count))))))

    @cached_property
    def _orders_outside(self) -> IntArray:
        """Integer parts of the orders below the band, without the mean, and above it up to `BEYOND` times its end."""
        low, top = int(self.first), int(self.first) + self.count
        return np.concatenate([np.arange(0 if self.first % 1 else 1, low), np.arange(top, BEYOND * top)])

    @cached_property
    def outside(self) -> FloatArray:
        """Frequencies outside the band at which a piecewise-linear force is evaluated, shape (outside,) [rad/s]."""
        return (self._orders_outside + self.first % 1) * self.spacing

    @property
    def port_omega(self) -> FloatArray:
        """Frequencies at which a port must be given: those of the band, then those outside [rad/s]."""
        return np.concatenate([self.omega, self.outside])

    def signal(self, phasors: ComplexArray, finer: int = 1, outside: ComplexArray | None = None) -> FloatArray:
        """Return Re sum c_k exp(-i omega_k t) on the instants or some times as many, shape (instant,).

        With the phasors of the harmonics outside the band, shape (outside,), if given.
        """
        padded = np.zeros(finer * self.instants, dtype=complex)
        padded[int(self.first) : int(self.first) + self.count] = phasors
        if outside is not None:
            padded[self._orders_outside] = outside
        values = fft(padded)
        return np.asarray((values * _half_turns(len(padded)) if self.first % 1 else values).real)

    def phasors(self, weights: FloatArray) -> ComplexArray:
        """Return sum_j w_j exp(i omega_k t_j), shape (harmonic,): the adjoint of `signal`."""
        return self._transform(weights)[int(self.first) : int(self.first) + self.count]

    def phasors_outside(self, weights: FloatArray) -> ComplexArray:
        """Return `phasors` at the frequencies outside the band, shape (outside,)."""
        return self._transform(weights)[self._orders_outside]

    def _transform(self, weights: FloatArray) -> ComplexArray:
        """Sums of w_j exp(i omega t_j) at all frequencies of the spacing, half a spacing up for half whole orders."""
        turned = weights * _half_turns(len(weights)).conj() if self.first % 1 else weights
        return np.asarray(ifft(turned) * len(weights))

    def products(self, weights: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return sums of w_j e_k conj(e_l) over k - l, of w_j e_k e_l over k + l, e_k = exp(i omega_k t_j).

        A Toeplitz and a Hankel matrix: shapes (harmonic,), the others being conjugates, and (2 harmonic - 1,).
        """
        hat = np.asarray(ifft(weights) * len(weights))
        n, start = self.count, int(2 * self.first)
        return hat[:n], hat[np.arange(start, start + 2 * n - 1) % len(hat)]


@cache
def _half_turns(count: int) -> ComplexArray:
    """exp(-i t spacing/2) on so many instants, what half whole orders need beside a Fourier transform."""
    return np.asarray(np.exp(-1j * np.pi * np.arange(count) / count))


NODES = 4
"""Nodes per instant of collocation."""
CELLS = 8
"""Integration cells of |m| per node."""
PENALTY = 5e-4
"""Penalty on the mean square of force and stroke, over the power: selects the smallest of nearly equal optima."""
STEP_FRACTION = 0.995  # of the distance to the boundary
MOST_STEPS = 60
TOLERANCE = 1e-4  # of the optimal multipliers; the bound is valid for any


def mean_magnitude(harmonics: Harmonics, phasors: ComplexArray, cells: int = CELLS * NODES) -> float:
    """Return an upper bound of the mean over continuous time of |Re sum c_k exp(-i omega_k t)|.

    With so many cells of the period per instant of collocation. In a cell of length h the signal m differs from its
    chord by at most h^2 K/8, where K >= |m''| is the larger value at both ends plus h/2 sum omega^3 |c|. Where the
    chord stays further than that from zero, m does not change sign and the integral of |m| is the difference of its
    antiderivative. Elsewhere it is at most the integral of the chord's magnitude plus h^3 K/12.
    """
    omega = harmonics.omega
    turn = -1.0 if harmonics.first % 1 else 1.0
    orders = (np.ones(len(omega)), 1 / (-1j * omega), -(omega**2))
    value, integral, curved = (
        np.append(signal, turn * signal[0]) for signal in (harmonics.signal(order * phasors, cells) for order in orders)
    )
    left, right = value[:-1], value[1:]
    h = 2 * np.pi / harmonics.spacing / len(left)
    curvature = np.maximum(np.abs(curved[:-1]), np.abs(curved[1:])) + h / 2 * float(omega**3 @ np.abs(phasors))
    smaller, sum_of_ends = np.minimum(np.abs(left), np.abs(right)), np.abs(left) + np.abs(right)
    one_sign = (left * right > 0) & (smaller > h**2 / 8 * curvature)
    crossing = left * right < 0
    squares = np.divide(left**2 + right**2, sum_of_ends, out=np.zeros_like(left), where=crossing)
    chord = h / 2 * np.where(crossing, squares, sum_of_ends)
    total = np.where(one_sign, np.abs(np.diff(integral)), chord + h**3 / 12 * curvature).sum()
    return float(total) / (h * len(left))


def add_weighted(out: FloatArray, toeplitz: ComplexArray, hankel: ComplexArray, gain: ComplexArray) -> None:
    """Add the lower half of C^T W C, where C x = Re sum gain_bk x_bk exp(-i omega_k t), over real and imaginary x.

    In `out` real, then imaginary parts of each block; column-major. `toeplitz` and `hankel` are `Harmonics.products` of
    half the weights, gain has shape (block, harmonic).
    """
    blocks, n = gain.shape
    apart = sliding_window_view(np.concatenate([toeplitz[:0:-1].conj(), toeplitz]), n)[::-1]
    together = sliding_window_view(hankel, n)
    by_column = out.T.reshape(blocks, 2, n, blocks, 2, n)  # block, part and harmonic of column and row
    for c, b in itertools.combinations_with_replacement(range(blocks), 2):
        plain = gain[c, :, None] * apart * gain[b].conj()
        mirrored = gain[c, :, None].conj() * together * gain[b].conj()
        by_column[c, 0, :, b, 0] += plain.real + mirrored.real
        by_column[c, 0, :, b, 1] += plain.imag + mirrored.imag
        by_column[c, 1, :, b, 1] += plain.real - mirrored.real
        if b > c:
            by_column[c, 1, :, b, 0] += mirrored.imag - plain.imag


class Limits(NamedTuple):
    """Largest force and largest displacement of the port from rest."""

    force: float = np.inf  # [N]
    stroke: float = np.inf  # [m]


class ForceBound(NamedTuple):
    """Bound of the power of every force within limits, and a force whose power comes close to it."""

    power: float  # no force within the limits absorbs more [W]
    force: FloatArray  # at `NODES` nodes per instant, linear between them; empty without a limit of force [N]
    steps: int


@dataclass(frozen=True)
class _Multiplier:
    """Multiplier sum_b gain_b x_b of one limit."""

    limit: float
    gain: ComplexArray  # (block, harmonic)
    free: ComplexArray  # the limited signal without force (harmonic,)


@dataclass(frozen=True)
class _Bound:
    """The bound as a function of the unknowns x, shape (block, harmonic).

    The first block is m + conj(gamma) n, in which the last sum is diagonal. With both limits the second block is n.
    """

    harmonics: Harmonics
    velocity: ComplexArray  # v0 (harmonic,)
    loss: FloatArray  # Re Y (harmonic,)
    multipliers: Sequence[_Multiplier]

    @property
    def nodes(self) -> int:
        """Number of nodes in a period."""
        return NODES * self.harmonics.instants

    @property
    def hat(self) -> FloatArray:
        """Harmonics of a piecewise-linear signal over those of its node values, shape (harmonic,)."""
        return np.asarray(np.sinc((self.harmonics.first + np.arange(self.harmonics.count)) / self.nodes) ** 2)

    def quadratic(self, x: ComplexArray) -> float:
        """The part of the bound without absolute values: quadratic and linear terms."""
        linear = sum(float(np.sum((one.free.conj() * (one.gain * x).sum(axis=0)).real)) for one in self.multipliers)
        return float(np.sum(np.abs(self.velocity - x[0]) ** 2 / (8 * self.loss))) - linear / 2

    def value(self, x: ComplexArray) -> float:
        """The bound, over continuous time."""
        sizes = (one.limit * mean_magnitude(self.harmonics, (one.gain * x).sum(axis=0)) for one in self.multipliers)
        return sum(sizes) + self.quadratic(x)

    def at_nodes(self, x: ComplexArray) -> FloatArray:
        """Limit times multiplier averaged around each node, over the number of nodes, shape (limit, node)."""
        return np.array(
            [
                one.limit / self.nodes * self.harmonics.signal(self.hat * (one.gain * x).sum(axis=0), NODES)
                for one in self.multipliers
            ]
        )

    def from_nodes(self, values: FloatArray) -> ComplexArray:
        """The adjoint of `at_nodes`, shape (block, harmonic)."""
        pairs = zip(self.multipliers, values, strict=True)
        return np.asarray(
            sum(one.limit / self.nodes * one.gain.conj() * self.hat * self.harmonics.phasors(v) for one, v in pairs)
        )

    def matrix(self, weights: FloatArray) -> FloatArray:
        """Lower half of the Hessian, weighted squares of `at_nodes` included, shape (unknown, unknown)."""
        blocks, n = self.multipliers[0].gain.shape
        out = np.zeros((2 * blocks * n, 2 * blocks * n), order="F")
        for one, weight in zip(self.multipliers, weights, strict=True):
            products = self.harmonics.products(weight * (one.limit / self.nodes) ** 2 / 2)
            add_weighted(out, *products, one.gain * self.hat)
        first = np.arange(2 * n)
        out[first, first] += np.tile(1 / (4 * self.loss), 2)
        return out


@dataclass(frozen=True)
class _Point:
    """Iterate: unknowns, limited signals over their limits at the nodes, and multipliers of both sides of |u| <= 1."""

    x: ComplexArray  # (block, harmonic)
    u: FloatArray  # (limit, node), within -1 and 1
    sides: FloatArray  # (limit, side, node), above 0; their difference is `at_nodes` apart from the penalty

    @property
    def slack(self) -> FloatArray:
        """Distance to both sides, shape (limit, side, node)."""
        return np.stack([1 - self.u, 1 + self.u], axis=1)

    def moved(self, step: "_Point", share: float) -> tuple["_Point", float]:
        """The next iterate, at most a share of the way to the boundary or the whole step, and that part of the step."""
        change = np.stack([-step.u, step.u], axis=1)
        room = max(np.max(-change / self.slack), np.max(-step.sides / self.sides), 1e-30)
        part = min(1.0, share / float(room))
        return _Point(self.x + part * step.x, self.u + part * step.u, self.sides + part * step.sides), part


def _newton(
    bound: _Bound, at: _Point, factor: tuple[FloatArray, bool], target: FloatArray | float, penalty: float
) -> _Point:
    """Newton step towards slack times multiplier equal to a target, with multipliers consistent with the unknowns."""
    slack = at.slack
    weight, pull = at.sides / slack, target / slack
    net, stiff = pull[:, 0] - pull[:, 1] + penalty * at.u, weight.sum(axis=1) + penalty
    gradient = np.asarray(sum(one.gain.conj() * one.free / 2 for one in bound.multipliers), dtype=complex)
    gradient[0] += bound.velocity / (4 * bound.loss)  # of minus `quadratic` at x = 0
    right = gradient - bound.from_nodes(at.u - net / stiff)
    parts = np.stack([right.real, right.imag], axis=1)
    real, imag = np.moveaxis(cho_solve(factor, parts.ravel(), check_finite=False).reshape(parts.shape), 1, 0)
    x = real + 1j * imag
    u = (bound.at_nodes(x) - net) / stiff
    change = np.stack([u, -u], axis=1)
    return _Point(x - at.x, u, pull - at.sides + weight * change)


def force_bound(
    harmonics: Harmonics,
    velocity: ComplexArray,
    admittance: ComplexArray,
    limits: Limits,
    least: float = -np.inf,
) -> ForceBound:
    """Return an upper bound of the mean power of every force within limits, of which at least one is finite.

    Of the multipliers' harmonics, which include those of the sea, the free velocity V0 of the port [m/s] and Y of the
    port [m/(N s)], with a positive real part, each shape (harmonic,). `least` is a lower bound of what any force within
    its limit absorbs in the band [W]: iteration stops once the bound is below, for then no force keeps both limits.
    """
    gamma = admittance / (1j * harmonics.omega)  # displacement per unit force
    unit, free = np.ones((1, harmonics.count), dtype=complex), velocity / (-1j * harmonics.omega)
    force_limited, stroke_limited = np.isfinite(limits.force), np.isfinite(limits.stroke)
    both = force_limited and stroke_limited
    multipliers = []
    if force_limited:
        gain: ComplexArray = np.concatenate([unit, -gamma.conj()[None]]) if both else unit
        multipliers.append(_Multiplier(limits.force, gain, np.zeros(harmonics.count, dtype=complex)))
    if stroke_limited:
        gain = np.asarray(np.concatenate([0 * unit, unit]) if both else unit / gamma.conj(), dtype=complex)
        multipliers.append(_Multiplier(limits.stroke, gain, free))
    bound = _Bound(harmonics, velocity, admittance.real, multipliers)
    x = np.zeros(multipliers[0].gain.shape, dtype=complex)
    matched = bound.quadratic(x)
    x[0] = velocity
    values = bound.at_nodes(x)  # without force; multipliers of the order of the available power
    least_side = np.abs(values).mean(axis=1, keepdims=True) + matched / values.size
    sides = np.stack([np.maximum(v, 0) for v in (values, -values)], axis=1) + least_side[:, None]
    at, missing = _Point(x, np.zeros(values.shape), sides), 1.0
    penalty = 2 * PENALTY * min(matched, *np.abs(values).sum(axis=1)) / bound.nodes
    for steps in range(MOST_STEPS):  # noqa: B007 - returned
        value = float(np.abs(bound.at_nodes(at.x)).sum()) + bound.quadratic(at.x)
        products = at.slack * at.sides
        if value < least or max(float(products.sum()), missing * matched) <= TOLERANCE * abs(value):
            break
        weights = 1 / ((at.sides / at.slack).sum(axis=1) + penalty)
        try:
            factor = cho_factor(bound.matrix(weights), lower=True, overwrite_a=True, check_finite=False)
        except LinAlgError:  # limited by round-off; the bound holds for the present multipliers
            break
        straight = _newton(bound, at, factor, 0.0, penalty)
        ahead, _ = at.moved(straight, 1.0)
        mean = float(products.mean())
        centring = (float((ahead.slack * ahead.sides).mean()) / mean) ** 3
        curved = np.stack([-straight.u, straight.u], axis=1) * straight.sides
        at, part = at.moved(_newton(bound, at, factor, centring * mean - curved, penalty), STEP_FRACTION)
        missing *= 1 - part
    force = limits.force * at.u[0] if force_limited else np.zeros(0)
    return ForceBound(min(bound.value(at.x), matched), force, steps)
