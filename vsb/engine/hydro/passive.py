"""Passive state space of the radiation memory of any body: many motions, many channels, order by tolerance.

1. Common stable poles of all entries of K(i omega) = B + i omega (A - A_inf) by vector fitting, residues by least
   squares; balanced truncation to as few states as the tolerance allows: (A, G, C), stable, perhaps not passive.
2. All passive K with the same A and G have C = G^T P, A^T P + P A = -F F^T for some F (positive-real lemma; F needs as
   many columns as there are motions). F starts from Riccati's equation of K + epsilon, which is passive, and least
   squares bring K back to the samples: the result is passive whatever F is.
3. In coordinates in which P = 1 that is a `RadiationModel`.

K(0+) = G^T P G, added mass and damping come from one K: they are consistent by construction.

Whether K(s) = C (s - A)^-1 B is passive samples cannot prove, for they miss what happens between them. It is if Phi(i
omega) = K(i omega) + K(i omega)^H has no negative eigenvalue at any frequency. But Phi(i omega) + 2 epsilon is singular
exactly at the imaginary eigenvalues i omega of

    [[A - B C/(2 epsilon), B B^T/(2 epsilon)], [-C^T C/(2 epsilon), -A^T + C^T B^T/(2 epsilon)]]

(Boyd, Balakrishnan and Kabamba 1989). At infinite frequency it is 2 epsilon: positive everywhere if there are none.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from scipy.linalg import block_diag, eigh, solve_continuous_are, solve_continuous_lyapunov
from scipy.sparse.csgraph import connected_components

from vsb.engine.hydro.radiation import (
    UNUSABLE,
    RadiationModel,
    levenberg_marquardt,
    partial_fractions,
    truncated,
    vector_fit,
)
from vsb.errors import ConvergenceError, DatabaseError, StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

_COLUMNS = 24  # combinations of entries that the poles are found from


# State spaces, passive or not


class StateSpace(NamedTuple):
    """K(s) = C (s - A)^-1 B, passive or not."""

    state_matrix: FloatArray  # A (state, state) [1/s]
    input_matrix: FloatArray  # B (state, dof)
    output_matrix: FloatArray  # C (dof, state)

    def transfer(self, omega: FloatArray) -> ComplexArray:
        """Return K(i omega), shape (omega, dof, dof)."""
        a, b, c = self
        poles, vectors = np.linalg.eig(a)
        inside = 1 / (1j * omega[:, None] - poles)
        return np.asarray(np.einsum("in,wn,nj->wij", c @ vectors, inside, np.linalg.solve(vectors, b), optimize=True))

    def damping(self, omega: FloatArray) -> FloatArray:
        """Return the least eigenvalue of the Hermitian part of K(i omega), shape (omega,)."""
        k = self.transfer(omega)
        return np.asarray(np.linalg.eigvalsh(0.5 * (k + k.conj().transpose(0, 2, 1)))[:, 0])


def rational_fit(omega: FloatArray, k: ComplexArray, poles: int) -> StateSpace:
    """Return the state space of a plain vector fit with common poles and full residues; it need not be passive."""
    dof, flat = k.shape[1], k.reshape(len(omega), -1)
    found = vector_fit(omega, _combined(flat), poles)
    basis, block, ones = partial_fractions(1j * omega, found)
    rows, right = (np.vstack([part.real, part.imag]) for part in (basis, flat))
    residues = np.linalg.lstsq(rows, right, rcond=None)[0].reshape(-1, dof, dof)
    output = residues.transpose(1, 0, 2).reshape(dof, -1)
    return StateSpace(np.kron(block, np.eye(dof)), np.kron(ones[:, None], np.eye(dof)), output)


def _combined(columns: ComplexArray) -> ComplexArray:
    """Real combinations of the columns that hold most of them, at most `_COLUMNS`."""
    left, singular, _ = np.linalg.svd(np.vstack([columns.real, columns.imag]), full_matrices=False)
    kept = (left * singular)[:, : min(_COLUMNS, int((singular > 1e-9 * singular[0]).sum()))]
    return np.asarray(kept[: len(columns)] + 1j * kept[len(columns) :])


@dataclass(frozen=True)
class Balanced:
    """A stable state space and the square roots of its Gramians (Moore 1981; Tombs and Postlethwaite 1987)."""

    system: StateSpace
    left: FloatArray  # (state, order), Hankel singular values descending
    right: FloatArray  # (state, order)

    @classmethod
    def of(cls, system: StateSpace) -> "Balanced":
        """Return it with the controllable and observable states."""
        a, b, c = system
        reached, seen = _root(solve_continuous_lyapunov(a, -b @ b.T)), _root(solve_continuous_lyapunov(a.T, -c.T @ c))
        u, hankel, v = np.linalg.svd(seen.T @ reached)
        kept = hankel > 1e-13 * hankel[0]
        scale = np.sqrt(hankel[kept])
        return cls(system, seen @ u[:, : len(kept)][:, kept] / scale, reached @ v.T[:, : len(kept)][:, kept] / scale)

    @property
    def order(self) -> int:
        """Number of states of the smallest realisation."""
        return int(self.left.shape[1])

    def truncated(self, order: int) -> StateSpace:
        """Return the state space of so many states; its K is off by twice the other singular values at most."""
        a, b, c = self.system
        left, right = self.left[:, :order], self.right[:, :order]
        return StateSpace(left.T @ a @ right, left.T @ b, c @ right)


def _root(gramian: FloatArray) -> FloatArray:
    """R with R R^T = a positive semidefinite matrix."""
    values, vectors = eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


LEVEL = 1e-8
"""Negative damping below which nothing is proved, relative to the largest |K|: round-off of the Hamiltonian matrix."""
_IMAGINARY = 1e-6  # real part, relative to the eigenvalue, up to which it may be imaginary: they come in close pairs
_ROUND_OFF = 1e-14  # the same relative to the largest eigenvalue
_ROUNDS = 30


class LeastDamping(NamedTuple):
    """The least eigenvalue of the Hermitian part of K over all frequencies."""

    value: float  # found; never positive, as K vanishes at infinity
    omega: float  # where [rad/s]
    bound: float  # no frequency has less: proven


def least_damping(system: StateSpace) -> LeastDamping:
    """Return the least eigenvalue of the Hermitian part of K(i omega) over all frequencies, and a proven bound.

    Raises `StabilityError` if A is not stable: K is then no transfer function of a memory.

    The level -epsilon is lowered to the least damping between the frequencies where it is crossed, until it is not
    crossed any more (Boyd and Balakrishnan 1990); convergence is quadratic, the proof is the last Hamiltonian matrix.
    """
    poles = np.linalg.eigvals(system.state_matrix)
    if poles.real.max() >= 0:
        raise StabilityError(
            f"passivity: received a pole with growth rate {poles.real.max():.3g}/s, needs a stable state matrix."
        )
    places = np.unique(np.concatenate([[0.0], np.abs(poles), np.abs(poles.imag)]))
    size = float(np.abs(system.transfer(places)).max())
    if size == 0.0:
        return LeastDamping(0.0, 0.0, 0.0)
    value, omega = 0.0, np.inf
    for _ in range(_ROUNDS):
        damping = system.damping(places)
        if damping.min() < value:
            value, omega = float(damping.min()), float(places[damping.argmin()])
        bound = 1.001 * value - LEVEL * size
        crossed = crossings(system, -bound)
        if not crossed.size:
            return LeastDamping(value, omega, bound)
        edges = np.concatenate([[0.0], crossed, [2 * crossed[-1]]])
        places = np.concatenate([crossed, 0.5 * (edges[1:] + edges[:-1])])
        if system.damping(places).min() >= bound:  # touched or round-off: not crossed
            return LeastDamping(value, omega, bound)
    raise ConvergenceError(
        f"passivity: received no level that is not crossed after {_ROUNDS}; scale the motions alike."
    )


def crossings(system: StateSpace, level: float) -> FloatArray:
    """Return the frequencies where an eigenvalue of the Hermitian part of K is -level, ascending [rad/s]."""
    a, b, c = system
    left = a - b @ c / (2 * level)
    values = np.linalg.eigvals(np.block([[left, b @ b.T / (2 * level)], [-c.T @ c / (2 * level), -left.T]]))
    near = _IMAGINARY * np.abs(values) + _ROUND_OFF * np.abs(values).max()
    return np.unique(values[(np.abs(values.real) <= near) & (values.imag >= 0)].imag)


# Passive fit

Limit = Literal["given", "fitted"]
POLES = (4, 6, 8, 10, 12, 14, 16, 20, 24, 30)
"""Numbers of common poles tried, one after the other."""
_ABOVE = np.array([-0.3 + 1.2j, -0.6 + 1.8j])
"""Poles above the band, relative to its end: the samples leave K open there, and it is chosen passive."""
_UNEVEN = 1e-6  # asymmetry taken as round-off, relative to the largest entry
_REST = 0.1  # of the tolerance: couplings and combinations of motions below it are left out
_FREE = 0.5  # of the tolerance: error of the rational functions before they are made passive
_REDUCED = 0.7  # of the tolerance: their error with fewer states
_STARTS = 12  # values of epsilon, each four times the one before
_SHORTER = 1.02  # error of fewer states, relative to that of all, where the tolerance is not met
_PARTS = (1.0, 0.85, 0.7, 0.55, 0.4)  # parts of the samples, from the lowest on, fitted until one succeeds
FEWEST = 10
"""Least number of samples fitted where not all can be."""
_LEAST_SIZE = 1e-4  # scale of a motion, relative to inertia times the frequency of the largest damping
_EMPTY = 1e-12  # of the largest energy of a state: states below it store none


@dataclass(frozen=True)
class RadiationSamples:
    """Added mass and damping of a body at some frequencies; checked when made."""

    omega: FloatArray  # ascending, positive (omega,) [rad/s]
    added_mass: FloatArray  # (omega, dof, dof) [kg]
    damping: FloatArray  # (omega, dof, dof) [kg/s]
    added_mass_inf: FloatArray  # (dof, dof) [kg]
    size: FloatArray  # s (dof,) [kg^0.5/s^0.5]: K_ij is measured in s_i s_j; see `sizes`

    def __post_init__(self) -> None:
        """Check shapes, values and symmetry."""
        count, dof = len(self.omega), len(self.size)
        if not (np.isfinite(self.size).all() and (self.size > 0).all()):
            raise DatabaseError("size: received values that are not positive, needs one above 0 for each motion.")
        shapes = {"added_mass": (count, dof, dof), "damping": (count, dof, dof), "added_mass_inf": (dof, dof)}
        for name, shape in shapes.items():
            values = getattr(self, name)
            if np.shape(values) != shape:
                raise DatabaseError(f"{name}: received shape {np.shape(values)}, needs {shape}.")
            if not np.isfinite(values).all():
                raise DatabaseError(f"{name}: received NaN or infinite values; solve these frequencies again.")
            scaled = values / np.outer(self.size, self.size)
            uneven, largest = np.abs(scaled - scaled.swapaxes(-1, -2)).max(), np.abs(scaled).max()
            if uneven > _UNEVEN * largest:
                raise DatabaseError(
                    f"{name}: received an asymmetry of {uneven / largest:.1e} of its largest entry, needs symmetric "
                    "matrices; use `with_symmetrized`."
                )
        if count < 4 or not (np.isfinite(self.omega).all() and self.omega[0] > 0 and (np.diff(self.omega) > 0).all()):
            raise DatabaseError(f"omega: received {count} frequencies, needs four or more, positive and ascending.")

    @cached_property
    def transfer(self) -> ComplexArray:
        """K(i omega) = B + i omega (A - A_inf), scaled, shape (omega, dof, dof) [-]."""
        k = self.damping + 1j * self.omega[:, None, None] * (self.added_mass - self.added_mass_inf)
        return np.asarray(k / np.outer(self.size, self.size))

    @cached_property
    def drawn(self) -> float:
        """Least eigenvalue of the scaled damping at the samples, 0 if there is no negative one [-]."""
        return min(0.0, float(np.linalg.eigvalsh(self.transfer.real).min()))


def sizes(omega: FloatArray, damping: FloatArray, inertia: FloatArray) -> FloatArray:
    """Return the scale of each motion, the root of its largest damping, shape (dof,) [kg^0.5/s^0.5].

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    damping : ndarray, shape (omega, dof, dof) [kg/s]
    inertia : ndarray, shape (dof,) [kg]
        Of each motion, added mass included: yaw of a round body radiates nothing but round-off.
    """
    own = np.einsum("wii->wi", damping)
    floor = _LEAST_SIZE * omega[np.abs(own).argmax(axis=0)] * np.abs(inertia)
    size = np.maximum(own.max(axis=0), floor)
    return np.sqrt(np.where(size > 0, size, 1.0))


class PassiveFit(NamedTuple):
    """A passive radiation model, its error, and the change that made it passive."""

    model: RadiationModel
    error: float  # largest rms over the samples of an entry of K, relative to its size [-]
    sampled: float  # least eigenvalue of the damping sampled, never positive [-]
    drawn: float  # least eigenvalue of the rational functions over all frequencies, before they were made passive [-]
    changed: float  # largest rms change of an entry by making them passive [-]
    added_mass_inf: FloatArray  # given or fitted (dof, dof) [kg]
    shifted: float = 0.0  # largest change of it by the fit, relative to the inertia of both motions [-]
    up_to: float = np.inf  # frequency above which no passive memory follows the samples [rad/s]

    @property
    def history(self) -> str:
        """Repairs in words; empty if there were none."""
        found = []
        if self.sampled < 0:
            found.append(f"least eigenvalue of the damping given {self.sampled:.1e}")
        if self.drawn < 0:
            found.append(f"of its rational fit {self.drawn:.1e}, made passive by a change of {self.changed:.1e}")
        if self.shifted:
            found.append(f"added mass at infinite frequency fitted, a change of {self.shifted:.1e} of the diagonal's")
        if self.up_to < np.inf:
            found.append(f"fitted up to {self.up_to:.4g} rad/s, above which no passive memory follows the coefficients")
        return f"radiation memory, in terms of each motion's largest damping: {', '.join(found)}" if found else ""


def fit_lowest(samples: RadiationSamples, tolerance: float, *, limit: Limit = "given") -> PassiveFit:
    """Return the passive model of all samples, or, if that fails, of the samples below a lower frequency.

    Irregular frequencies and noise, which no passive memory follows, lie at the end of a band. See `fit_passive`.
    """
    failure: ConvergenceError | StabilityError | None = None
    for share in _PARTS:
        count = round(share * len(samples.omega))
        if share < 1 and count < FEWEST:
            break
        lowest = replace(
            samples, omega=samples.omega[:count], added_mass=samples.added_mass[:count], damping=samples.damping[:count]
        )
        try:
            fit = fit_passive(lowest, tolerance, limit=limit)
        except (ConvergenceError, StabilityError) as error:
            failure = failure or error
            continue
        return fit._replace(up_to=float(lowest.omega[-1])) if share < 1 else fit
    assert failure
    raise failure


def fit_passive(samples: RadiationSamples, tolerance: float, *, limit: Limit = "given") -> PassiveFit:
    """Return the passive model with the fewest states found within a tolerance, or the best there is.

    Raises `StabilityError` if the damping sampled draws energy from calm water by more than `UNUSABLE`: no passive
    model is near it; `ConvergenceError` if the best model is further off than `UNUSABLE`, or the tolerance is not
    within 1e-9 and 0.1.

    Parameters
    ----------
    tolerance : float
        Largest rms over the samples of an entry of K, relative to its size [-].
    limit : "given" or "fitted"
        Added mass at infinite frequency. Its mesh error differs from that at finite frequencies: where no passive K
        is near enough to both, it can be fitted to the samples.
    """
    if not 1e-9 <= tolerance <= 0.1:
        raise ConvergenceError(f"tolerance: received {tolerance:g}, needs 1e-9 to 0.1.")
    if samples.drawn < -UNUSABLE:
        raise StabilityError(
            f"radiation damping: received a least eigenvalue of {samples.drawn:.2g} relative to each motion's largest "
            f"damping, needs at least {-UNUSABLE:g}; motion would draw energy from calm water: solve these "
            "coefficients again."
        )
    k = samples.transfer
    groups = coupled(k, _REST * tolerance)
    fit = _fit_limit if limit == "fitted" else _fit_block
    parts = [fit(samples.omega, k[:, group[:, None], group], tolerance) for group in groups]
    if not any(part.model for part in parts):
        raise DatabaseError("radiation: received damping of no motion, needs one that makes waves.")
    model = _scaled(samples.size, groups, [part.model for part in parts])
    shift = np.zeros_like(samples.added_mass_inf)
    for group, part in zip(groups, parts, strict=True):
        shift[group[:, None], group] = part.shift
    found = model.transfer(samples.omega) / np.outer(samples.size, samples.size)
    difference = found - k + 1j * samples.omega[:, None, None] * shift
    error = entry_error(difference)
    if error > UNUSABLE:
        worst = float(samples.omega[np.abs(difference).max(axis=(1, 2)).argmax()])
        raise ConvergenceError(
            f"the radiation state space reaches an error of {error:.1e} with {model.order} states, needs {UNUSABLE:g}; "
            f"most at {worst:.4g} rad/s: smaller panels or steps of frequency there resolve a resonance in a gap, a "
            "lid removes an irregular frequency; or fit added mass at infinite frequency."
        )
    shift *= np.outer(samples.size, samples.size)
    own = np.sqrt(np.maximum(np.abs(np.diag(samples.added_mass_inf)), np.abs(np.diag(shift)))) + 1e-100
    drawn, changed = min(part.drawn for part in parts), max(part.changed for part in parts)
    shifted = float(np.abs(shift / np.outer(own, own)).max())
    return PassiveFit(model, error, samples.drawn, drawn, changed, samples.added_mass_inf + shift, shifted)


def entry_error(difference: ComplexArray) -> float:
    """Return the largest rms over frequencies of an entry of a matrix (omega, dof, dof)."""
    return float(np.sqrt((np.abs(difference) ** 2).mean(axis=0)).max())


def coupled(k: ComplexArray, least: float) -> list[IntArray]:
    """Return groups of motions that radiate together, each an array of indices; other couplings are below `least`."""
    graph = np.sqrt((np.abs(k) ** 2).mean(axis=0)) > least
    count, group = connected_components(graph, directed=False)
    return [np.flatnonzero(group == i) for i in range(count)]


class _Part(NamedTuple):
    """Fit of motions that radiate together."""

    model: RadiationModel | None  # none: they radiate nothing
    error: float
    drawn: float
    changed: float
    shift: FloatArray  # of added mass at infinite frequency (dof, dof) [-]


def _fit_limit(omega: FloatArray, k: ComplexArray, tolerance: float) -> _Part:
    """Passive fit with a fitted limit: once to find the limit, once more with the poles of the remainder."""
    first = _fit_block(omega, k, tolerance, "fitted")
    second = _fit_block(omega, k - 1j * omega[:, None, None] * first.shift, tolerance, "fitted")
    return second._replace(shift=first.shift + second.shift) if second.error < first.error else first


def _fit_block(omega: FloatArray, k: ComplexArray, tolerance: float, limit: Limit = "given") -> _Part:
    """Passive fit of scaled K (omega, dof, dof) in as few combinations of its motions as it takes."""
    lead = leading_directions(k, _REST * tolerance)
    best = _Part(None, np.inf, 0.0, 0.0, np.zeros(k.shape[1:]))
    if not lead.shape[1]:
        return best
    inside, rate = lead.T @ k @ lead, 1j * omega[:, None, None]
    for free in _candidates(omega, inside, tolerance):
        drawn = least_damping(free)
        above = _ABOVE * omega[-1] if drawn.value < -_REST * tolerance else _ABOVE[:0]
        outputs = _PassiveOutputs(*_widened(free.state_matrix, free.input_matrix, above))
        start = np.pad(free.output_matrix, ((0, 0), (0, len(outputs.a) - len(free.state_matrix))))
        factor = outputs.fitted(omega, inside, outputs.start(start, -drawn.bound), _REST * tolerance, limit)
        model = outputs.model(factor, lead)
        shift = limit_shift(omega, k - model.transfer(omega)) if limit == "fitted" else np.zeros(k.shape[1:])
        error = entry_error(model.transfer(omega) - (own := k - rate * shift))
        if error < best.error:
            model = shortest(model, omega, own, max(tolerance, _SHORTER * error))
            found = model.transfer(omega)
            changed = entry_error(found - lead @ free.transfer(omega) @ lead.T + rate * shift)
            best = _Part(model, entry_error(found - own), drawn.value, changed, shift)
        if error <= tolerance:
            break
    return best


def limit_shift(omega: FloatArray, missed: ComplexArray) -> FloatArray:
    """Return the symmetric D for which i omega D is nearest to a misfit, (omega, dof, dof) -> (dof, dof)."""
    shift = _rate(omega, missed)
    return np.asarray(0.5 * (shift + shift.T))


def _rate(omega: FloatArray, values: ComplexArray) -> FloatArray:
    """Coefficient of i omega in values (omega, ...): that of a shift of added mass."""
    return np.asarray(np.einsum("w,w...->...", omega, values.imag) / (omega @ omega))


def _widened(a: FloatArray, b: FloatArray, poles: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """State and input matrix with further poles driven by all motions: passive K needs freedom above the band."""
    dof = b.shape[1]
    _, block, ones = partial_fractions(np.zeros(1, dtype=complex), np.concatenate([poles, poles.conj()]))
    return block_diag(a, np.kron(block, np.eye(dof))), np.vstack([b, np.kron(ones[:, None], np.eye(dof))])


def shortest(model: RadiationModel, omega: FloatArray, k: ComplexArray, tolerance: float) -> RadiationModel:
    """Return the shortest of a model's truncations within a tolerance of K, passive like all of them."""

    def error(order: int) -> float:
        return entry_error(truncated(model, order).transfer(omega) - k)

    return truncated(model, _fewest_states(error, model.order, tolerance))


def _fewest_states(error: Callable[[int], float], most: int, tolerance: float) -> int:
    """Fewest states whose error is within a tolerance, by bisection; the most if no fewer are."""
    low, high = 1, most
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if error(middle) <= tolerance else (middle + 1, high)
    return low


def leading_directions(k: ComplexArray, least: float) -> FloatArray:
    """Return orthonormal combinations of motions outside of which K is less than `least` (rms), shape (dof, direction).

    Motions that radiate alike, two modes of one degree, are fitted once; those that radiate nothing, not at all.
    """
    rows = np.concatenate([k.real, k.imag]).reshape(-1, k.shape[1])
    _, singular, right = np.linalg.svd(rows, full_matrices=False)
    rest = np.sqrt(np.cumsum(singular[::-1] ** 2)[::-1] / len(k))  # of all from this one on
    return np.asarray(right[rest > least].T)


def _candidates(omega: FloatArray, k: ComplexArray, tolerance: float) -> Iterator[StateSpace]:
    """Rational functions near K, with more states from one to the next."""
    best, idle = (np.inf, 0), 0
    for poles in [count for count in POLES if count <= max(4, len(omega) // 2)]:
        whole = rational_fit(omega, k, poles)
        error = entry_error(whole.transfer(omega) - k)
        idle = 0 if error < 0.9 * best[0] else idle + 1
        best = min(best, (error, poles))
        if error <= _FREE * tolerance:
            yield from _reductions(omega, k, whole, tolerance)
        if idle == 2:
            break
    if best[0] > _FREE * tolerance:  # noise, or no rational function: the best there is
        yield from _reductions(omega, k, rational_fit(omega, k, best[1]), max(tolerance, 1.5 * best[0]))


def _reductions(omega: FloatArray, k: ComplexArray, whole: StateSpace, tolerance: float) -> Iterator[StateSpace]:
    """Balanced truncations of a state space, from the smallest within the tolerance on."""
    balanced = Balanced.of(whole)

    def error(order: int) -> float:
        return entry_error(balanced.truncated(order).transfer(omega) - k)

    low = _fewest_states(error, balanced.order, _REDUCED * tolerance)
    for order in sorted({low, min(low + max(1, low // 4), balanced.order)}):
        yield balanced.truncated(order)


class _PassiveOutputs:
    """All outputs that make K passive, C = B^T P with A^T P + P A = -F F^T, in the eigenvectors of A."""

    def __init__(self, a: FloatArray, b: FloatArray) -> None:
        """A stable and diagonalisable."""
        self.a, self.b = a, b
        self.poles, self.vectors = np.linalg.eig(a)
        self.inverse = np.linalg.inv(self.vectors)
        self.cauchy = -1 / (self.poles.conj()[:, None] + self.poles)
        self.reads = b.T @ self.inverse.conj().T

    def energy(self, factor: FloatArray) -> FloatArray:
        """Return P of F, shape (state, state)."""
        inside = self.vectors.T @ factor
        p = self.inverse.conj().T @ (self.cauchy * (inside.conj() @ inside.T)) @ self.inverse
        return np.asarray(0.5 * (p + p.T).real)

    def start(self, output: FloatArray, epsilon: float) -> FloatArray:
        """Return F of the passive K + epsilon by Riccati's equation, shape (state, dof).

        A^T P + P A + (C^T - P B)(C - B^T P)/(2 epsilon) = 0 is solved for -P.
        """
        zero, one = np.zeros_like(self.a), np.eye(len(output))
        for _ in range(_STARTS):
            try:
                p = -solve_continuous_are(self.a, self.b, zero, 2 * epsilon * one, s=output.T)
                return np.asarray((output.T - p @ self.b) / np.sqrt(2 * epsilon))
            except np.linalg.LinAlgError:
                epsilon *= 4
        raise ConvergenceError(
            f"radiation state space: received no start with {len(self.a)} states; refine the frequencies."
        )

    def fitted(
        self, omega: FloatArray, k: ComplexArray, start: FloatArray, enough: float, limit: Limit = "given"
    ) -> FloatArray:
        """Return F of the K nearest to that sampled, or as near as `enough` (rms), from a start, shape (state, dof).

        With a fitted limit, misfits of the form i omega D with a matrix D do not count.
        """
        inside = 1 / (1j * omega[:, None] - self.poles)
        states = np.einsum("mn,wn,nj->wjm", self.vectors, inside, self.inverse @ self.b, optimize=True)
        right = k.transpose(0, 2, 1)
        if limit == "fitted":
            rate = 1j * omega[:, None, None]
            states, right = (part - rate * _rate(omega, part) for part in (states, right))
        rows, right = states.reshape(-1, len(self.a)), right.reshape(-1, k.shape[1])
        q, r = np.linalg.qr(np.vstack([rows.real, rows.imag]))
        target = q.T @ np.vstack([right.real, right.imag])

        def residual(entries: FloatArray) -> FloatArray:
            return np.asarray((r @ self.energy(entries.reshape(start.shape)) @ self.b - target).ravel())

        def jacobian(entries: FloatArray) -> FloatArray:
            slope = self.slope(entries.reshape(start.shape))
            return np.asarray((r @ slope.reshape(len(r), -1)).reshape(start.size, -1))

        near = len(omega) * enough**2
        return levenberg_marquardt(residual, jacobian, start.ravel(), near).reshape(start.shape)

    @cached_property
    def _sides(self) -> tuple[ComplexArray, ComplexArray]:
        """Factors of conj(F) and of F in C, (dof, state, state) and (state, state, dof)."""
        one = np.einsum("ai,ij,ci->ajc", self.reads, self.cauchy, self.vectors.conj())
        return one, np.einsum("jb,ij,cj->ibc", self.inverse, self.cauchy, self.vectors)

    def slope(self, factor: FloatArray) -> FloatArray:
        """Return the derivative of C^T by the entries of F, shape (state, dof, state, dof)."""
        inside, (one, two) = factor.T @ self.vectors, self._sides
        conjugate = np.einsum("ajc,kj,jb->back", one, inside, self.inverse, optimize=True)
        return np.real(conjugate + np.einsum("ai,ki,ibc->back", self.reads, inside.conj(), two, optimize=True))

    def model(self, factor: FloatArray, lead: FloatArray) -> RadiationModel:
        """Return the model in states whose energy is x.x/2; K of its motions is lead K lead^T."""
        energy, vectors = eigh(self.energy(factor))
        kept = energy > _EMPTY * energy[-1]
        root = np.sqrt(energy[kept])
        to, back = root[:, None] * vectors[:, kept].T, vectors[:, kept] / root
        a, channel = to @ self.a @ back, back.T @ factor
        return RadiationModel(0.5 * (a - a.T) - 0.5 * channel @ channel.T, to @ self.b @ lead.T, channel)


def _scaled(size: FloatArray, groups: Sequence[IntArray], models: Sequence[RadiationModel | None]) -> RadiationModel:
    """One model of all groups of motions, in physical units."""
    parts = [(group, model) for group, model in zip(groups, models, strict=True) if model]
    inputs = [model.input_matrix @ np.eye(len(size))[group] * size for group, model in parts]
    return RadiationModel(
        block_diag(*(model.state_matrix for _, model in parts)),
        np.concatenate(inputs),
        block_diag(*(model.channel for _, model in parts)),
    )
