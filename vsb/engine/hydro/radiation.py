"""Radiation memory: transforms of damping over frequency, and the passive state space of a round body's one channel.

The damping is a cubic spline through the solved frequencies and through B(0) = 0 (B ~ omega^3 in deep water, omega in
finite depth), continued above the band as omega^-3, the decay of a body that meets the surface at a right angle. All
that follows from it is linear in the values at the solved frequencies: a sum with weights that all motions share.

A state space that is passive by construction is

    x' = A x + G v,   f = -G^T x,   A = J - L L^T/2,   J = -J^T:

its stored energy is x.x/2 and it radiates |L^T x|^2/2 >= 0, whatever G. Every passive memory can be written so
(`vsb.engine.hydro.passive` fits those of any body). All axisymmetric motions radiate one ring wave, so B(omega) has
rank one and L is one column l: the memory of N modes costs as many states as that of one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import (
    block_diag,
    cho_factor,
    cho_solve,
    cholesky,
    eigh,
    expm,
    solve_continuous_lyapunov,
    solve_triangular,
)
from scipy.special import exp1

from vsb.errors import ConvergenceError, DatabaseError, StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray

_STEPS = 200  # of the least squares
_ENOUGH = 1e-3  # gain of a step, in terms of what is left, that ends them
_ROUND_OFF = 1e-13  # least damping of a step, in terms of the largest entry of the normal equations
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(8)
_TAIL_NODE, _TAIL_WEIGHT = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True)
class DampingSpectrum:
    """Radiation damping as a function of frequency, and its transforms."""

    omega: FloatArray  # solved frequencies, ascending, (omega,) [rad/s]
    damping: FloatArray  # (omega, dof, dof) [kg/s]

    def __post_init__(self) -> None:
        """Check that all values are finite."""
        if not (np.isfinite(self.omega).all() and np.isfinite(self.damping).all()):
            raise DatabaseError("radiation damping: received NaN or infinite values; solve these frequencies again.")

    @property
    def diagonal(self) -> "DampingSpectrum":
        """The spectrum of each motion by itself, its damping of shape (omega, dof)."""
        return DampingSpectrum(self.omega, np.einsum("wii->wi", self.damping))

    def combined(self, combinations: FloatArray) -> "DampingSpectrum":
        """Return the spectrum of combinations of the motions, shape (dof, combination)."""
        return DampingSpectrum(self.omega, combinations.T @ self.damping @ combinations)

    @cached_property
    def _quadrature(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gauss points within every spline interval: frequencies, weights, shares of the solved values there."""
        edges = np.append(0.0, self.omega)
        half = np.diff(edges)[:, None] / 2
        nodes = ((edges[:-1] + edges[1:])[:, None] / 2 + half * _NODE).ravel()
        return nodes, (half * _WEIGHT).ravel(), self.shares(nodes)

    @cached_property
    def _unit(self) -> CubicSpline:
        """Cubic splines over [0, omega_max], each one at one solved frequency and zero at the others and at 0."""
        count = len(self.omega)
        ones, flat = np.eye(count + 1)[:, 1:], np.zeros(count)
        return CubicSpline(np.append(0.0, self.omega), ones, bc_type=("not-a-knot", (2, flat)))

    def shares(self, omega: FloatArray) -> FloatArray:
        """Return the shares of the solved values in the damping at any frequency, shape (omega, solved) [-]."""
        top = self.omega[-1]
        fall = np.minimum(1.0, top / np.maximum(omega, 1e-12)) ** 3
        return np.asarray(self._unit(np.minimum(omega, top)) * fall[:, None])

    def kernel(self, time: FloatArray) -> FloatArray:
        """Return the retardation kernel K(t) = (2/pi) int B cos(omega t) d omega, shape (time, dof, dof) [kg/s^2].

        Eight Gauss points per interval are exact to round-off up to t = 10/(frequency step). The tail integral is a
        generalized exponential integral, int_W^inf cos(wt) w^-3 dw = Re E_3(iWt)/W^2.
        """
        nodes, weights, shares = self._quadrature
        top = self.omega[-1]
        rows = np.cos(np.outer(time, nodes)) @ (weights[:, None] * shares)
        rows[:, -1] += np.real(_e3(1j * top * time)) * top
        return np.asarray(2 / np.pi * np.tensordot(rows, self.damping, 1))

    def added_mass_shares(self, omega: FloatArray) -> FloatArray:
        """Return the weights of the solved damping in A(omega) - A(infinity) by Kramers-Kronig, (omega, solved) [s].

        -(2/pi) PV int B(v)/(omega^2 - v^2) dv, with the singularity taken out: PV int dv/(omega^2 - v^2) = 0.
        """
        nodes, weights, shares = self._quadrature
        top = self.omega[-1]
        u = 0.5 * (_TAIL_NODE + 1)  # v = top/u beyond the band
        beyond, beyond_weight = top / u, 0.5 * _TAIL_WEIGHT * top / u**2
        within = weights / (omega[:, None] ** 2 - nodes**2)
        above = beyond_weight / (omega[:, None] ** 2 - beyond**2)
        rows = within @ shares - (within.sum(axis=1) + above.sum(axis=1))[:, None] * self.shares(omega)
        rows[:, -1] += above @ u**3
        return np.asarray(-2 / np.pi * rows)

    def added_mass_difference(self, omega: FloatArray) -> FloatArray:
        """Return A(omega) - A(infinity) by Kramers-Kronig, shape (omega, dof, dof) [kg]."""
        return np.asarray(np.tensordot(self.added_mass_shares(omega), self.damping, 1))

    def at(self, omega: FloatArray) -> FloatArray:
        """Return the damping at any frequency, shape (omega, dof, dof) [kg/s]."""
        return np.asarray(np.tensordot(self.shares(omega), self.damping, 1))

    def transfer(self, omega: FloatArray) -> ComplexArray:
        """Return K(s = i omega) = B + i omega (A - A(infinity)), shape (omega, dof, dof) [kg/s]."""
        rows = self.shares(omega) + 1j * omega[:, None] * self.added_mass_shares(omega)
        return np.asarray(np.tensordot(rows, self.damping, 1))


def _e3(z: ComplexArray) -> ComplexArray:
    """Generalized exponential integral E_3 by recurrence from E_1; E_3(0) = 1/2."""
    z = np.asarray(z, dtype=complex)
    safe = np.where(z == 0, 1.0, z)
    e2 = np.exp(-safe) - safe * exp1(safe)
    return np.where(z == 0, 0.5, (np.exp(-safe) - safe * e2) / 2)


ORDERS = (6, 10, 14, 18, 22)
UNUSABLE = 0.02
"""Error from which on a radiation model is not usable [-]."""
_DELAYS = (0.0, 0.5, 1.0, 1.5, 2.0)  # starting phases of the channel, in units of the time scale of the body
_LEADING = 1e-4  # part of the largest singular value of the amplitudes above which a direction is fitted
_POLISHED_PART = 3e-3  # the same above which its fit is polished; the others follow from these
_GAIN = 1e-5  # part of the squared error that a step gains, below which polishing ends
_POLISHED = 2  # number of starts that are polished, best first


@dataclass(frozen=True)
class RadiationModel:
    """Passive state space of the radiation memory, of one or several channels."""

    state_matrix: FloatArray  # A (state, state) [1/s]
    input_matrix: FloatArray  # G (state, dof) [kg^0.5/s]
    channel: FloatArray  # L (state, channel), or l (state,) of one [s^-0.5]

    def __post_init__(self) -> None:
        """Check passivity: A + A^T = -L L^T and A stable."""
        defect = np.abs(self.state_matrix + self.state_matrix.T + 2 * self.radiated).max()
        growth = np.linalg.eigvals(self.state_matrix).real.max()
        if defect > 1e-8 * np.abs(self.state_matrix).max() or growth >= 0:
            raise StabilityError(
                f"the radiation model is not passive: |A + A^T + l l^T| = {defect:.1e}, largest growth rate "
                f"{growth:.1e}/s; needs a stable A whose symmetric part is -l l^T/2."
            )

    @property
    def order(self) -> int:
        """Number of memory states."""
        return len(self.channel)

    @cached_property
    def radiated(self) -> FloatArray:
        """Form of the radiated power x^T L L^T x/2, shape (state, state) [1/s]."""
        channels = self.channel.reshape(self.order, -1)
        return np.asarray(0.5 * channels @ channels.T)

    def transfer(self, omega: FloatArray) -> ComplexArray:
        """Return K(i omega) = G^T (i omega - A)^-1 G, shape (omega, dof, dof) [kg/s]."""
        g = self.input_matrix
        return np.asarray(g.T @ (_resolvent(self.state_matrix, omega) @ g))

    def damping(self, omega: FloatArray) -> FloatArray:
        """Return B(omega) = H^H H/2, H = L^T (i omega - A)^-1 G, shape (omega, dof, dof): never negative [kg/s]."""
        resolvent, channels = _resolvent(self.state_matrix, omega), self.channel.reshape(self.order, -1)
        h = channels.T @ (resolvent @ self.input_matrix)
        return np.asarray(0.5 * np.real(h.conj().transpose(0, 2, 1) @ h))

    def kernel(self, time: FloatArray) -> FloatArray:
        """Return K(t) = G^T exp(A t) G on equally spaced times from 0, shape (time, dof, dof) [kg/s^2]."""
        return np.asarray(self.input_matrix.T @ self._states(time))

    def own_kernels(self, time: FloatArray) -> FloatArray:
        """Return the diagonal of `kernel`, of each motion by itself, shape (time, dof) [kg/s^2]."""
        return np.asarray((self.input_matrix * self._states(time)).sum(axis=1))

    def _states(self, time: FloatArray) -> FloatArray:
        """States exp(A t) G after a unit velocity of each motion for no time, (time, state, dof)."""
        step = expm(self.state_matrix * (time[1] - time[0]))
        states = [self.input_matrix]
        for _ in time[1:]:
            states.append(step @ states[-1])
        return np.array(states)


def joined(models: Sequence[RadiationModel]) -> RadiationModel:
    """Return several memories as one, with their states one after the other."""
    if len(models) == 1:
        return models[0]
    channels = [model.channel.reshape(model.order, -1) for model in models]
    return RadiationModel(
        block_diag(*(model.state_matrix for model in models)),
        np.vstack([model.input_matrix for model in models]),
        block_diag(*channels),
    )


def _resolvent(a: FloatArray, omega: FloatArray) -> ComplexArray:
    """(i omega - A)^-1 at every frequency, shape (omega, state, state)."""
    return np.linalg.inv(1j * omega[:, None, None] * np.eye(len(a)) - a)


def truncated(model: RadiationModel, order: int) -> RadiationModel:
    """Return the model's balanced truncation to `order` states, which is passive.

    A + A^T = -L L^T makes the observability Gramian of L the identity. In the eigenvectors of the controllability
    Gramian, A W + W A^T = -G G^T with every mode's input alike in size, both are diagonal; cutting rows and columns
    keeps A + A^T = -L L^T.
    """
    if order >= model.order:
        return model
    a, g = model.state_matrix, model.input_matrix
    inputs = g / np.maximum(np.linalg.norm(g, axis=0), 1e-12 * np.linalg.norm(g))
    _, vectors = eigh(solve_continuous_lyapunov(a, -inputs @ inputs.T))
    kept = vectors[:, ::-1][:, :order]
    return RadiationModel(kept.T @ a @ kept, kept.T @ g, kept.T @ model.channel)


def vector_fit(omega: FloatArray, values: ComplexArray, order: int) -> ComplexArray:
    """Return stable common poles of a set of transfer functions, shape (order,) [rad/s].

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    values : ndarray, shape (omega, function)
    order : int
        Even number of poles.

    Notes
    -----
    Gustavsen & Semlyen's vector fitting without direct term, with the compressed least squares of Deschrijver et al.;
    poles in the right half plane are reflected.
    """
    s = 1j * omega
    start = np.geomspace(0.1, 0.7, order // 2) * omega.max() / 2
    poles = np.concatenate([(-0.3 + 1j) * start, (-0.3 - 1j) * start])
    for _ in range(15):
        basis, block, ones = partial_fractions(s, poles)
        rows, right = [], []
        for f in values.T:
            system = np.hstack([basis, -f[:, None] * basis, f[:, None]])
            r: FloatArray = np.asarray(np.linalg.qr(np.vstack([system.real, system.imag]), mode="r"))
            rows.append(r[order : 2 * order, order : 2 * order])
            right.append(r[order : 2 * order, -1])
        sigma = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
        poles = np.linalg.eigvals(block - np.outer(ones, sigma))
        poles = np.where(poles.real > 0, -poles.conj(), poles)
    return poles


def partial_fractions(s: ComplexArray, poles: ComplexArray) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Return a real partial-fraction basis, shape (s, order), its block-diagonal matrix and input vector."""
    basis, order = [], len(poles)
    block, ones, i = np.zeros((order, order)), np.zeros(order), 0
    for p in poles[np.abs(poles.imag) < 1e-9].real:
        basis.append(1 / (s - p))
        block[i, i], ones[i], i = p, 1.0, i + 1
    for p in poles[poles.imag >= 1e-9]:
        first, second = 1 / (s - p), 1 / (s - p.conjugate())
        basis += [first + second, 1j * (first - second)]
        block[i : i + 2, i : i + 2] = [[p.real, p.imag], [-p.imag, p.real]]
        ones[i], i = 2.0, i + 2
    return np.array(basis).T, block, ones


def _dissipative(poles: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return A and l with the given stable poles and A + A^T = -l l^T."""
    _, block, ones = partial_fractions(np.zeros(1, dtype=complex), poles)
    observed = np.where(ones > 0, 1.0, 0.0)
    energy = solve_continuous_lyapunov(block.T, -np.outer(observed, observed))
    root = cholesky(0.5 * (energy + energy.T))
    inverse = solve_triangular(root, np.eye(len(root)))
    a, channel = root @ block @ inverse, observed @ inverse
    skew = 0.5 * (a - a.T)
    return skew - 0.5 * np.outer(channel, channel), channel  # exact to round-off, as the Lyapunov solution is not


def _start(resolvent: ComplexArray, channel: FloatArray, x: FloatArray, phase: FloatArray) -> tuple[FloatArray, float]:
    """Input matrix with channel output |h| = sqrt(2) |x|, by alternating phase retrieval; also its rms error."""
    h0 = channel @ resolvent
    system = np.vstack([h0.real, h0.imag])
    inverse = np.linalg.pinv(system)
    g, target = np.zeros((len(channel), x.shape[1])), np.zeros(x.shape, dtype=complex)
    for _ in range(200):
        target = np.sqrt(2) * x * np.exp(1j * phase)[:, None]
        g = inverse @ np.vstack([target.real, target.imag])
        phase = np.angle(((h0 @ g) * x).sum(axis=1))
    return g, float(np.sqrt(np.mean(np.abs(h0 @ g - target) ** 2)))


def _polish(resolvent: ComplexArray, target: ComplexArray, start: FloatArray) -> tuple[FloatArray, float]:
    """Least-squares fit of G^T R G to the target from a start; returns G and the rms error."""
    state, dof = start.shape
    even = 0.5 * (resolvent + resolvent.transpose(0, 2, 1))
    first, second = np.triu_indices(dof)
    entry = np.arange(len(first))

    def residual(flat: FloatArray) -> FloatArray:
        g = flat.reshape(state, dof)
        d = (g.T @ (even @ g) - target)[:, first, second]
        return np.concatenate([d.real.ravel(), d.imag.ravel()])

    def jacobian(flat: FloatArray) -> FloatArray:
        both = (even @ flat.reshape(state, dof)).transpose(2, 0, 1)  # (dof, omega, state)
        slopes = np.zeros((2, len(even), len(entry), state, dof))
        for part, one in zip(slopes, (both.real, both.imag), strict=True):
            part[:, entry, :, first] += one[second]
            part[:, entry, :, second] += one[first]
        return slopes.reshape(-1, flat.size)

    found = levenberg_marquardt(residual, jacobian, start.ravel(), gain=_GAIN)
    return found.reshape(state, dof), float(np.sqrt(np.mean(residual(found) ** 2)))


def _channel_amplitudes(spectrum: DampingSpectrum, omega: FloatArray, scale: FloatArray) -> FloatArray:
    """Real amplitudes x with B = x x^T, scaled, shape (omega, dof): signs relative to the strongest radiator."""
    b = spectrum.at(omega) / np.outer(scale, scale)
    strongest = int(np.argmax(np.einsum("wii->i", b)))
    magnitude = np.sqrt(np.clip(np.einsum("wii->wi", b), 0.0, None))
    return np.asarray(magnitude * np.where(b[:, :, strongest] < 0, -1.0, 1.0))


def fit_order(spectrum: DampingSpectrum, omega: FloatArray, order: int) -> tuple[RadiationModel, float]:
    """Return the best passive model of an order and its rms error relative to each mode's largest damping [-].

    Motions that radiate alike (two modes of one degree) are fitted once: the fit lives in the leading singular vectors
    of the amplitudes x(omega), which leaves the Frobenius norm of the error unchanged. Of many modes most directions
    are small: they follow linearly from their coupling with the others.
    """
    scale = np.sqrt(np.einsum("wii->wi", spectrum.damping).max(axis=0))
    x = _channel_amplitudes(spectrum, omega, scale)
    _, singular, vt = np.linalg.svd(x, full_matrices=False)
    lead = vt[singular > _LEADING * singular[0]].T  # (dof, direction)
    main = int(np.count_nonzero(singular > _POLISHED_PART * singular[0]))
    target = spectrum.combined(lead / scale[:, None]).transfer(omega)
    of_main, upper = target[:, :main, :main], np.triu_indices(main)
    a, channel = _dissipative(vector_fit(omega, of_main[:, *upper], order))
    resolvent = _resolvent(a, omega)
    peak = omega[int(np.argmax(np.einsum("wi,wi->w", x, x)))]
    starts = sorted(
        (_start(resolvent, channel, x @ lead[:, :main], -omega * delay / peak) for delay in _DELAYS), key=lambda s: s[1]
    )
    polished = (_polish(resolvent, of_main, start)[0] for start, _ in starts[:_POLISHED])
    g, error = min((_completed(resolvent, target, g) for g in polished), key=lambda fit: fit[1])
    return RadiationModel(a, g @ lead.T * scale, channel), error


def _completed(resolvent: ComplexArray, target: ComplexArray, known: FloatArray) -> tuple[FloatArray, float]:
    """Input matrix of all directions from that of the first ones, (state, known), and the rms error of all.

    What couples a further direction with those known, (R + R^T)/2 between both, is linear in it.
    """
    main = known.shape[1]
    even = 0.5 * (resolvent + resolvent.transpose(0, 2, 1)) @ known  # (omega, state, known)
    rows = even.transpose(0, 2, 1).reshape(-1, even.shape[1])
    wanted = target[:, :main, main:].reshape(len(rows), -1)
    further = np.linalg.lstsq(np.vstack([rows.real, rows.imag]), np.vstack([wanted.real, wanted.imag]), rcond=None)[0]
    g = np.hstack([known, further])
    k = g.T @ (0.5 * (resolvent + resolvent.transpose(0, 2, 1))) @ g
    missed = (k - target)[:, *np.triu_indices(g.shape[1])]
    return g, float(np.sqrt(np.mean(np.abs(missed) ** 2) / 2))


def check_positive(spectrum: DampingSpectrum) -> None:
    """Check that the damping is positive semidefinite, each mode relative to its largest, within `UNUSABLE`.

    Raises `StabilityError`.
    """
    largest = np.einsum("wii->wi", spectrum.damping).max(axis=0)
    least = -np.inf if largest.min() < 0 else 0.0
    if least == 0.0:
        scale = np.sqrt(np.where(largest > 0, largest, 1.0))
        even = 0.5 * (spectrum.damping + spectrum.damping.transpose(0, 2, 1)) / np.outer(scale, scale)
        least = float(np.linalg.eigvalsh(even).min())
    if least < -UNUSABLE:
        raise StabilityError(
            f"radiation damping: received a least eigenvalue of {least:.2g} relative to each mode's largest damping, "
            f"needs at least {-UNUSABLE:g}; motion would draw energy from calm water: solve these coefficients again."
        )


def fit_radiation(spectrum: DampingSpectrum, tolerance: float) -> tuple[RadiationModel, float]:
    """Return the smallest passive model within tolerance, or the best there is, and its error.

    Raises `StabilityError` if the damping draws energy from calm water by more than `UNUSABLE`: no passive model is
    near it; `ConvergenceError` if the best model is further off than `UNUSABLE`.

    Parameters
    ----------
    tolerance : float
        Largest rms error over frequency of K(i omega), each mode relative to its largest damping [-]. Once two larger
        orders gain less than a tenth, the rest is the mesh error of the damping itself, which no passive model should
        fit; the validity ledger reports it.
    """
    check_positive(spectrum)
    band = spectrum.omega
    omega = np.concatenate([[0.2 * band[0]], band[:: max(1, len(band) // 60)], band[-1] * np.array([1.1, 1.4, 2.0])])
    best, idle = fit_order(spectrum, omega, ORDERS[0]), 0
    for order in ORDERS[1:]:
        if best[1] <= min(tolerance, UNUSABLE) or idle == 2:
            break
        larger = fit_order(spectrum, omega, order)
        idle = 0 if larger[1] < 0.9 * best[1] else idle + 1
        best = min(best, larger, key=lambda fit: fit[1])
    if best[1] > UNUSABLE:
        raise ConvergenceError(
            f"the radiation state space reaches an error of {best[1]:.1e} with {best[0].order} states, "
            f"needs {UNUSABLE:g}; widen the band (hydro.omega_max) or refine the mesh (hydro.tolerance)."
        )
    return best


def levenberg_marquardt(
    residual: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    x: FloatArray,
    enough: float = 0.0,
    gain: float = _ENOUGH,
) -> FloatArray:
    """Return where a sum of squares is least, or no more than enough, from a start; damped as Nielsen (1999) does.

    A step that gains less than a part `gain` of what is left ends the search. The normal equations are solved: with
    damping they stand a Jacobian without full rank.
    """
    r, j = residual(x), jacobian(x)
    damping, growth = 1e-3 * float((j**2).sum(axis=0).max()), 2.0
    for _ in range(_STEPS):
        slope, square = j.T @ r, j.T @ j
        damping = max(damping, _ROUND_OFF * float(np.diag(square).max()))
        step = -cho_solve(cho_factor(square + damping * np.eye(len(x))), slope)
        moved = residual(x + step)
        gained, promised = r @ r - moved @ moved, step @ (damping * step - slope)
        if gained > 0:
            x, r, j = x + step, moved, jacobian(x + step)
            damping, growth = damping * max(1 / 3, 1 - float(2 * gained / promised - 1) ** 3), 2.0
            if gained < gain * (r @ r) or r @ r <= enough:
                break
        elif promised < gain * (r @ r):
            break
        else:
            damping, growth = damping * growth, 2 * growth
    return x
