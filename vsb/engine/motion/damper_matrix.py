"""Several ports at once: impedances between them, and the damper matrix that absorbs most in a sea.

The take-off acts on p combinations B of the degrees of freedom with forces F = C V against their velocities V = B^T q'.
Per frequency and unit wave amplitude V = V0 - Y F, Y (p, p) symmetric, and with L L^T = C >= 0

    P = 1/2 Re V^H C V,   dP = Re mu^H dC V/2,   mu = (1 + C Y)^-H (V - Y^H F).

With one radiation channel a real matrix reaches the matched power where the reactance X of the ports is indefinite:
locked in a ratio u with u^T X u = 0 they are one port in resonance. Where X is definite no matrix does.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize

from vsb.tools.arrays import ComplexArray, FloatArray

Kind = Literal["full", "diagonal", "uniform"]
"""What a damper matrix may be: symmetric, a damper at each port alone, or the same damper at all ports."""
DRAWN = 64
"""Damper matrices tried first, drawn about the ports' own impedances, always the same ones."""
CLIMBED = 4
"""The best of them that are followed to a maximum."""
SPREAD = 2.5
"""Standard deviation of the logarithm of those dampers over the ports' own impedances."""
ALONG = np.arange(-8.0, 9.0)
"""Logarithms of those dampers, where all ports have the same: power in them has no feature narrower than 1."""
FORCE_KEPT, NEAR_PRICE = 1e-6, 1e-2
"""Relative tolerance on a limit of the rms of all forces, and of its price before secants."""
ROUND_OFF = 1e-9
"""Share of the largest loss of the ports at a frequency below which a combination of them radiates nothing [-]."""


@dataclass(frozen=True)
class Ports:
    """Thevenin's equivalent of one design at several ports, over frequency; units are those of each port's kind."""

    omega: FloatArray  # (omega,) [rad/s]
    admittance: ComplexArray  # Y (omega, port, port) [m/(N s)]
    velocity: ComplexArray  # V0 per wave amplitude (omega, port) [1/s]

    @property
    def moves(self) -> bool:
        """Whether waves move any of the ports."""
        return bool(self.velocity.any())

    @cached_property
    def size(self) -> FloatArray:
        """Mean modulus of each port's own admittance, shape (port,): what makes the ports comparable."""
        own = np.abs(np.einsum("wii->wi", self.admittance))
        return np.asarray(np.exp(np.log(np.where(own > 0, own, 1.0)).mean(axis=0)))

    @cached_property
    def impedance(self) -> ComplexArray:
        """Z = Y^-1, shape (omega, port, port); 0 of ports that cannot move."""
        scale = np.sqrt(np.outer(self.size, self.size))
        return np.asarray(np.linalg.pinv(self.admittance / scale, rcond=1e-13) / scale)

    @cached_property
    def matched_power(self) -> FloatArray:
        """Mean power under the optimal forces, V0^H (Re Y)^-1 V0/8 per squared amplitude, shape (omega,) [W/m^2].

        Where ports radiate through fewer channels than there are ports and lose nothing else, Re Y is singular, and V0
        in its range.
        """
        scale = np.sqrt(np.outer(self.size, self.size))
        loss, free = (self.admittance / scale).real, self.velocity / np.sqrt(self.size)
        values, vectors = np.linalg.eigh(loss)
        along = np.abs(np.einsum("wij,wi->wj", vectors, free)) ** 2
        kept = values > ROUND_OFF * np.abs(values).max(axis=1, keepdims=True)
        return np.asarray(np.divide(along, 8 * values, out=np.zeros_like(along), where=kept).sum(axis=1))

    def velocity_under(self, damping: FloatArray) -> ComplexArray:
        """Return V = (1 + Y C)^-1 V0 under a damper matrix C (port, port), per wave amplitude, (omega, port) [1/s]."""
        loaded = np.eye(len(damping)) + self.admittance @ damping
        return np.asarray(np.linalg.solve(loaded, self.velocity[..., None])[..., 0])

    def power(self, damping: FloatArray) -> FloatArray:
        """Return the mean power V^H C V/2 of a damper matrix per squared wave amplitude, shape (omega,) [W/m^2]."""
        velocity = self.velocity_under(damping)
        return np.asarray(0.5 * np.real(np.einsum("wi,ij,wj->w", velocity.conj(), damping, velocity)))

    def power_and_slope(self, damping: FloatArray, squares: FloatArray, price: float = 0.0) -> tuple[float, FloatArray]:
        """Return the mean power in a sea [W] and its derivative by the entries of a symmetric damper matrix.

        Parameters
        ----------
        damping : ndarray, shape (port, port)
        squares : ndarray, shape (omega,)
            Squared amplitudes of the sea [m^2].
        price : float [m/(N s)]
            Less this times the mean square of all forces.
        """
        velocity = self.velocity_under(damping)
        force = velocity @ damping
        beyond = velocity - np.einsum("wji,wj->wi", self.admittance.conj(), force) - 2 * price * force
        loaded = np.eye(len(damping)) + self.admittance.conj().swapaxes(1, 2) @ damping
        adjoint = np.linalg.solve(loaded, beyond[..., None])[..., 0]
        paid = velocity - price * force
        power = 0.5 * float(squares @ np.real(np.einsum("wi,wi->w", paid.conj(), force)))
        slope = 0.5 * np.real(np.einsum("w,wi,wj->ij", squares, adjoint.conj(), velocity))
        return power, (slope + slope.T) / 2

    def force_rms(self, damping: FloatArray, squares: FloatArray) -> FloatArray:
        """Return the root mean square of each port's force in a sea under a damper matrix, shape (port,)."""
        force = self.velocity_under(damping) @ damping
        return np.asarray(np.sqrt(0.5 * squares @ np.abs(force) ** 2))

    def at(self, chosen: FloatArray) -> "Ports":
        """Return the ports at some of their frequencies, by index or mask."""
        return Ports(self.omega[chosen], self.admittance[chosen], self.velocity[chosen])


class DamperMatrix(NamedTuple):
    """A damper matrix and the mean power it absorbs."""

    damping: FloatArray  # C (port, port)
    power: float  # [W]


def best_matrix(
    ports: Ports,
    squares: FloatArray,
    kind: Kind = "full",
    newton_steps: int = 0,
    price: float = 0.0,
    near: FloatArray | None = None,
) -> DamperMatrix:
    """Return the damper matrix C >= 0, real and symmetric, that absorbs most in a sea.

    Parameters
    ----------
    squares : ndarray, shape (omega,)
        Squared amplitudes [m^2]: of one sea, of several together, or of a year.
    kind : {'full', 'diagonal', 'uniform'}
    newton_steps : int
        Most Newton steps after quasi-Newton's: of a matrix whose power is to be differentiated, for then slopes by the
        ports are as exact as the matrix.
    price : float [m/(N s)]
        Of the mean square of all forces, which is taken from the power that is maximised.
    near : ndarray, shape (port, port)
        Matrix whose nearest maximum is wanted; none: the largest of all.

    Notes
    -----
    Over the Cholesky factor, or the logarithms of the dampers, of ports in terms of their own impedances: quasi-Newton
    with the exact slope from the best of `DRAWN` matrices. A full matrix also starts from the best diagonal one: it
    absorbs no less. A port that cannot move has no damper. One damper for all ports has one variable: from every local
    maximum along it.
    """
    used = (squares > 0) & (np.abs(ports.velocity).max(axis=1) > 0)
    count = ports.velocity.shape[1]
    if not used.any():
        return DamperMatrix(np.zeros((count, count)), 0.0)
    moving = ports.admittance.any(axis=(0, 2))
    if kind != "uniform" and not moving.all():  # as in a rigid design, which a port of strain does not move with
        part = Ports(ports.omega, ports.admittance[:, moving][:, :, moving], ports.velocity[:, moving])
        chosen = None if near is None else near[np.ix_(moving, moving)]
        some, whole = best_matrix(part, squares, kind, newton_steps, price, chosen), np.zeros((count, count))
        whole[np.ix_(moving, moving)] = some.damping
        return DamperMatrix(whole, some.power)
    seen, weights, unit = ports.at(used), squares[used], 1 / np.sqrt(ports.size)
    if kind == "uniform":  # of ports that have one unit
        unit = np.full(count, np.exp(np.log(unit).mean()))
    form = _FORMS[kind](count)
    limit = float(weights @ seen.matched_power) or 1.0

    def loss(x: FloatArray) -> tuple[float, FloatArray]:
        damping, pull = form.matrix(x, unit)
        power, slope = seen.power_and_slope(damping, weights, price)
        return -power / limit, -pull(slope) / limit

    def power(x: FloatArray) -> float:
        damping, _ = form.matrix(x, unit)
        return float(weights @ seen.power(damping)) - price * float((seen.force_rms(damping, weights) ** 2).sum())

    starts = (
        form.starts(np.random.default_rng(count)) if near is None else [form.of_matrix(near / np.outer(unit, unit))]
    )
    powers = np.array([power(x) for x in starts])
    if kind == "uniform" and near is None:
        beside = np.pad(powers, 1, constant_values=-np.inf)
        followed = [starts[i] for i in np.flatnonzero((powers >= beside[:-2]) & (powers >= beside[2:]))]
    else:
        followed = [starts[i] for i in np.argsort(-powers, kind="stable")[:CLIMBED]]
    if isinstance(form, _Full) and near is None:
        own = best_matrix(ports, squares, "diagonal", price=price).damping
        followed.append(form.of_diagonal(np.diag(own) / unit**2))
    found = [minimize(loss, x, jac=True, method="L-BFGS-B", options={"ftol": 1e-13, "gtol": 1e-9}) for x in followed]
    best: FloatArray = min(found, key=lambda one: float(one.fun)).x
    for _ in range(newton_steps):
        best = _newton_step(loss, best)
    damping, _ = form.matrix(best, unit)
    return DamperMatrix(damping, float(weights @ seen.power(damping)))


def _newton_step(loss: Callable[[FloatArray], tuple[float, FloatArray]], x: FloatArray) -> FloatArray:
    """A point after a Newton step towards the least loss, the Hessian by differences of slopes; itself if no better.

    Along directions in which the loss hardly bends, such as those of dampers that lock, the point stays.
    """
    value, slope = loss(x)
    steps = 1e-5 * np.diag(1 + np.abs(x))
    hessian = np.array([(loss(x + step)[1] - loss(x - step)[1]) / (2 * step.sum()) for step in steps])
    bends, directions = np.linalg.eigh((hessian + hessian.T) / 2)
    kept = bends > 1e-9 * bends[-1]
    moved = x - directions[:, kept] @ ((slope @ directions[:, kept]) / bends[kept])
    after, slope_after = loss(moved)
    better = after <= value + 1e-14 and np.abs(slope_after).max() < np.abs(slope).max()
    return np.asarray(moved if better else x)


def matrix_within_force(ports: Ports, squares: FloatArray, limit: float, kind: Kind = "full") -> DamperMatrix:
    """Return the damper matrix that absorbs most in a sea with a given rms of all forces together at most.

    Parameters
    ----------
    squares, kind
        See `best_matrix`.
    limit : float [N]
        Of ports whose forces have one unit.
    """
    return priced_matrix(ports, squares, limit, kind)[0]


def priced_matrix(
    ports: Ports, squares: FloatArray, limit: float, kind: Kind = "full", newton_steps: int = 0
) -> tuple[DamperMatrix, float]:
    """Return the matrix of `matrix_within_force`, and the price of the squared force at which it is the best one.

    With Newton steps, see `best_matrix`, power less the price times the squared force is as exact as without limit.
    """

    def at(logarithm: float, near: FloatArray | None = None, steps: int = 0) -> DamperMatrix:
        return best_matrix(ports, squares, kind, steps, float(np.exp(logarithm)), near)

    def excess(found: DamperMatrix) -> float:
        return float(np.log(np.linalg.norm(ports.force_rms(found.damping, squares)) / limit))

    best = best_matrix(ports, squares, kind, newton_steps)
    if not best.power > 0 or excess(best) <= FORCE_KEPT:
        return best, 0.0
    free = 0.5 * squares @ np.abs(ports.velocity) ** 2
    high = float(np.log(np.sqrt(free.sum()) / (2 * limit)))  # where the force alone costs, the limit holds
    low = high - 1.0
    while excess(at(low)) < 0:
        low -= 2.0
    close = NEAR_PRICE if newton_steps else FORCE_KEPT
    root = float(brentq(lambda price: excess(at(price)), low, high, xtol=close))
    if not newton_steps:
        tried = ((at(one), one) for one in (root, root + 2 * FORCE_KEPT, high))
        return next((one, float(np.exp(price))) for one, price in tried if excess(one) <= FORCE_KEPT)
    found = at(root, at(root).damping, newton_steps)
    for apart in (close, close**2):  # secants
        beside = at(root + apart, found.damping, newton_steps)
        root -= apart * excess(found) / (excess(beside) - excess(found))
        found = at(root, found.damping, newton_steps)
    return found, float(np.exp(root))


def matrix_text(matrix: FloatArray, digits: int) -> str:
    """Return a damper matrix as text, in SI units of its ports; nothing if it is missing."""
    if np.isnan(matrix).any():
        return ""
    return str([[float(f"{entry:.{digits}g}") for entry in row] for row in matrix.tolist()])


class _Full:
    """C = S L L^T S of a lower triangular L, S the ports' units."""

    def __init__(self, count: int) -> None:
        self.at, self.count = np.tril_indices(count), count

    def factor(self, x: FloatArray) -> FloatArray:
        """L."""
        found = np.zeros((self.count, self.count))
        found[self.at] = x
        return found

    def matrix(self, x: FloatArray, unit: FloatArray) -> tuple[FloatArray, Callable[[FloatArray], FloatArray]]:
        """C and what takes its slope back to x: dP/dL = 2 S G S L."""
        factor, scale = self.factor(x), np.outer(unit, unit)
        return scale * (factor @ factor.T), lambda slope: (2 * (scale * slope) @ factor)[self.at]

    def starts(self, rng: np.random.Generator) -> list[FloatArray]:
        """Dampers of all sizes along all combinations of the ports."""
        found = []
        for _ in range(DRAWN):
            turned = np.linalg.qr(rng.standard_normal((self.count, self.count)))[0]
            size = np.exp(SPREAD * rng.standard_normal(self.count))
            found.append(np.linalg.cholesky((turned * size) @ turned.T)[self.at])
        return found

    def of_matrix(self, matrix: FloatArray) -> FloatArray:
        """The point of a matrix in the ports' units."""
        sizes, along = np.linalg.eigh(matrix)
        return np.asarray(np.linalg.qr((along * np.sqrt(np.maximum(sizes, 0.0))).T)[1].T[self.at])

    def of_diagonal(self, dampers: FloatArray) -> FloatArray:
        """The point of a diagonal matrix, off its axis: there the slope across it would vanish."""
        root = np.sqrt(np.maximum(dampers, 1e-12))
        return np.asarray((np.diag(root) + 1e-6 * np.tril(np.outer(root, root) ** 0.5, -1))[self.at])


class _Logarithmic:
    """C = S diag(e^(W x)) S: a damper of its own at each port, or one at all."""

    def __init__(self, weight: FloatArray) -> None:
        self.weight = weight

    def matrix(self, x: FloatArray, unit: FloatArray) -> tuple[FloatArray, Callable[[FloatArray], FloatArray]]:
        """C and what takes its slope back to x."""
        dampers = unit**2 * np.exp(np.clip(self.weight @ x, -40.0, 40.0))
        return np.diag(dampers), lambda slope: self.weight.T @ (np.diag(slope) * dampers)

    def of_matrix(self, matrix: FloatArray) -> FloatArray:
        """The point of a matrix in the ports' units."""
        logs = np.log(np.maximum(np.diag(matrix), np.exp(-40.0)))
        return np.asarray(np.linalg.lstsq(self.weight, logs)[0])

    def starts(self, rng: np.random.Generator) -> list[FloatArray]:
        """Dampers of all sizes; of one variable evenly."""
        count = self.weight.shape[1]
        return list(ALONG[:, None]) if count == 1 else list(SPREAD * rng.standard_normal((DRAWN, count)))


_FORMS: Mapping[Kind, Callable[[int], "_Full | _Logarithmic"]] = {
    "full": _Full,
    "diagonal": lambda count: _Logarithmic(np.eye(count)),
    "uniform": lambda count: _Logarithmic(np.ones((count, 1))),
}
