"""Hydrodynamic coefficients over a band of frequencies from as few solves as a tolerance allows.

Two families of functions are interpolated, each with common poles: A + iB/omega, whose poles lie deep below the real
axis, and the excitation X. Waves act where they meet the waterline, of radius R, so the phase of X turns by k R over
the band; turned back X is as smooth as the radiated far field, which it is by Haskind's relation. Froude-Krylov forces,
which oscillate with both signs of k R, need no solving; diffraction is the rest of X.

Interpolation is rational and barycentric, with common support points and weights of many functions.
Coefficients of motions that are real in time obey f(-conj omega) = conj f(omega): they are rational functions of
s = -i omega with real coefficients. Support points therefore come in pairs +-omega, and every solved frequency counts
twice. With nodes s_j, values f_j and weights w_j (Nakatsukasa, Sete and Trefethen 2018, AAA; common weights of several
functions: Lietaert, Meerbergen, Perez and Vandereycken 2022),

    r(s) = [sum_j w_j f_j/(s - s_j) + conj. pairs]/[sum_j w_j/(s - s_j) + conj. pairs],

which has the values f_j whatever the weights; these make the linearized misfit elsewhere as small as can be.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.linalg import eigvals

from vsb.errors import ConfigError, ConvergenceError
from vsb.tools.arrays import ComplexArray, FloatArray, in_parts

_COLUMNS = 12
"""Combinations of columns that the weights are found from; all columns are interpolated."""
FEWEST_SAMPLES = 4
"""Least number of samples for which three interpolants can be compared."""


# Rational interpolation


@dataclass(frozen=True)
class Rational:
    """Rational functions of frequency with common poles, one for each column."""

    support: FloatArray  # (point,) [rad/s]
    values: ComplexArray  # (point, column)
    weights: ComplexArray  # (point,)

    def __call__(self, omega: FloatArray) -> ComplexArray:
        """Return the values at real frequencies [rad/s], shape (omega, column); at support points those given."""
        apart = omega[:, None] - self.support
        upper = self.weights / np.where(apart == 0.0, 1e-290, apart)
        lower = -self.weights.conj() / (omega[:, None] + self.support)
        share = np.concatenate([upper, lower], axis=1)
        share /= share.sum(axis=1, keepdims=True)
        return np.asarray(share @ np.concatenate([self.values, self.values.conj()]))

    @property
    def at_infinity(self) -> FloatArray:
        """Limits at infinite frequency, shape (column,); an extrapolation."""
        return np.asarray((self.weights @ self.values).imag / self.weights.sum().imag)

    @cached_property
    def poles(self) -> ComplexArray:
        """Finite poles, shape (pole,) [rad/s]: eigenvalues of the arrowhead pencil of the denominator."""
        nodes = np.concatenate([self.support, -self.support]).astype(complex)
        size = len(nodes) + 1
        arrow = np.diag(np.concatenate([[0.0], nodes]))
        arrow[0, 1:] = np.concatenate([self.weights, -self.weights.conj()])
        arrow[1:, 0] = 1.0
        finite = np.eye(size)
        finite[0, 0] = 0.0
        alpha, beta = eigvals(arrow, finite, homogeneous_eigvals=True)
        there = np.abs(beta) > 1e-12 * np.abs(alpha)
        return np.asarray(alpha[there] / beta[there])

    def spurious(self, grid: FloatArray) -> bool:
        """Return whether a pole hides between neighbours of an ascending grid of real frequencies.

        Such a pole is nearer to the real axis than the grid is fine, so that no value on the grid need reveal it: a
        doublet of pole and zero made of round-off or noise. Poles of floating bodies lie deep below the axis.
        """
        inside = (self.poles.real > grid[0]) & (self.poles.real < grid[-1])
        poles = self.poles[inside]
        gap = np.diff(grid)[np.searchsorted(grid, poles.real) - 1]
        return bool(np.any(np.abs(poles.imag) < gap))


def _loewner(omega: FloatArray, values: ComplexArray, size: FloatArray, support: list[int]) -> FloatArray:
    """Linearized misfit at the other samples of unit real and imaginary weights, shape (2 row, 2 point)."""
    others = np.setdiff1d(np.arange(len(omega)), support)
    at, f = omega[others, None], values[others, None]
    upper = (f - values[support]) / (at - omega[support])[..., None]
    lower = -(f - values[support].conj()) / (at + omega[support])[..., None]
    terms = np.concatenate([upper + lower, 1j * (upper - lower)], axis=1) * size[others, None, None]
    rows = terms.transpose(0, 2, 1).reshape(-1, 2 * len(support))
    return np.concatenate([rows.real, rows.imag])


def _leading(values: ComplexArray, size: FloatArray) -> ComplexArray:
    """Real combinations of the columns that hold most of their misfits, at most `_COLUMNS`, shape (sample, fewer)."""
    real = np.concatenate([values.real * size[:, None], values.imag * size[:, None]])
    left, s, _ = np.linalg.svd(real, full_matrices=False)
    kept = left[:, :_COLUMNS] * s[:_COLUMNS]
    return np.asarray((kept[: len(values)] + 1j * kept[len(values) :]) / size[:, None])


def interpolants(omega: FloatArray, values: ComplexArray, size: FloatArray) -> list[Rational]:
    """Return the interpolants with 1, 2, ... support points, each but the first where the last one missed most.

    Of values, shape (sample, column), at different positive frequencies, shape (sample,) [rad/s]; `size`, shape
    (sample,), says how much an error counts at each.
    """
    combined = _leading(values, size)
    support: list[int] = []
    missed = np.abs(values - values.mean(axis=0)).max(axis=1) * size
    found = []
    for _ in range(len(omega) - 1):
        missed[support] = -1.0
        support.append(int(np.argmax(missed)))
        _, _, right = np.linalg.svd(_loewner(omega, combined, size, support), full_matrices=False)
        real, imaginary = right[-1].reshape(2, -1)
        found.append(Rational(omega[support], values[support], real + 1j * imaginary))
        missed = np.abs(found[-1](omega) - values).max(axis=1) * size
    return found


class Selected(NamedTuple):
    """The interpolant its neighbours agree with best."""

    rational: Rational
    doubt: FloatArray  # (grid,): the larger difference from the interpolants with one support point less and more
    error: float  # estimated largest on the grid: the largest doubt, or misfit at a sample; inf if a pole hides there


def _steps(rationals: Sequence[Rational], grid: FloatArray) -> list[FloatArray]:
    """Largest differences of neighbouring interpolants on a grid, each (grid,): of few values at once."""
    found = []
    for part in in_parts(len(grid), rationals[0].values.shape[1]):
        on = (r(grid[part]) for r in rationals)
        found.append([np.abs(b - a).max(axis=1) for a, b in itertools.pairwise(on)])
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def selected(
    omega: FloatArray, values: ComplexArray, size: FloatArray, grid: FloatArray, on_grid: FloatArray
) -> Selected:
    """Return the interpolant that one support point more or less changes least on a grid, and by how much.

    Too few support points miss features, too many fit noise with doublets of poles and zeros; in between neighbours
    agree. Interpolants with a hidden pole (`Rational.spurious`) are passed over. Raises `ConvergenceError` if there are
    fewer than `FEWEST_SAMPLES` samples, which are as of `interpolants`. The grid is ascending, shape (grid,) [rad/s];
    `on_grid`, shape (grid,), says how much an error counts there.
    """
    if len(omega) < FEWEST_SAMPLES:
        raise ConvergenceError(
            f"omega: received {len(omega)} samples, rational interpolation needs {FEWEST_SAMPLES}; solve more of them"
        )
    ascending = np.argsort(omega)  # round-off, and what it decides, must not depend on the order of solving
    omega, values, size = omega[ascending], values[ascending], size[ascending]
    found = interpolants(omega, values, size)
    steps = [step * on_grid for step in _steps(found, grid)]
    doubts = [np.maximum(a, b) for a, b in itertools.pairwise(steps)]
    misfits = [float((np.abs(r(omega) - values).max(axis=1) * size).max()) for r in found[1:-1]]
    errors = [max(float(doubt.max()), misfit) for doubt, misfit in zip(doubts, misfits, strict=True)]
    order = [int(i) for i in np.argsort(errors, kind="stable")]
    for i in order:
        if not found[i + 1].spurious(grid):
            return Selected(found[i + 1], doubts[i], errors[i])
    return Selected(found[order[0] + 1], doubts[order[0]], np.inf)


# Sweep

FIRST_SOLVES = 7
"""Frequencies solved before any interpolation."""
MOST_SOLVES = 40
"""With more solves than this, or than half the frequencies, coefficients count as too rough to be interpolated."""
FORCES = ("Froude_Krylov_force", "diffraction_force")

_TURNING = 2.0
"""Phase k R from which on excitation is turned back fully."""

Solve = Callable[[list[float]], xr.Dataset]


class IncidentWave(NamedTuple):
    """Parts of the excitation known without solving."""

    phase: Callable[[FloatArray], FloatArray]
    """Phase k R of the wave from axis to waterline, of frequencies [rad/s], shape (omega,) [rad]."""
    froude_krylov: Callable[[FloatArray], ComplexArray]
    """Froude-Krylov force of frequencies [rad/s], shape (omega, wave direction, displacement) [N/m]."""
    order: int
    """Azimuthal order m of the motions, which see the component i^m J_m(kR) of the wave."""

    def turn(self, omega: FloatArray) -> ComplexArray:
        """Factor that turns excitation back, shape (omega, 1) [-].

        Its phase nears k R like an odd analytic function of frequency, as the spectra of real forces have it:
        k R = omega^2 R/g itself, continued to -omega as the phase must be, -k R, would have a kink at zero.
        """
        phase = self.phase(omega)
        turned = np.exp(1j * phase * np.sqrt(phase / (_TURNING + phase)))[:, None]
        return np.asarray((-1j) ** self.order * turned)


class _Family(NamedTuple):
    """Functions with common poles, at the frequencies solved."""

    values: ComplexArray  # (omega, column)
    scale: Callable[[FloatArray], FloatArray]  # how much an error counts at frequencies, shape (omega,)


def rows_of(ds: xr.Dataset, name: str) -> ComplexArray:
    """Return the values of a variable, one row for each frequency."""
    return np.asarray(ds[name].values.reshape(ds.sizes["omega"], -1))


def apart(one: npt.NDArray[np.inexact[Any]], other: npt.NDArray[np.inexact[Any]]) -> float:
    """Return the largest difference of two arrays."""
    return float(np.abs(one - other).max())


def relative(difference: ComplexArray | FloatArray, value: ComplexArray | FloatArray) -> float:
    """Return the largest difference relative to the largest value; as it is if all values are zero."""
    return float(np.abs(difference).max() / (np.abs(value).max() or 1.0))


def coefficients(ds: xr.Dataset) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Return added mass, damping and excitation, each shape (omega, entry)."""
    a, b = rows_of(ds, "added_mass").real, rows_of(ds, "radiation_damping").real
    return a, b, np.asarray(sum(rows_of(ds, name) for name in FORCES))


def largest(*parts: xr.Dataset) -> tuple[float, ...]:
    """Return the largest added mass, damping and excitation of all parts; one for motions that move no water."""
    sizes = [[float(np.abs(rows).max()) for rows in coefficients(ds)] for ds in parts]
    return tuple(max(size) or 1.0 for size in zip(*sizes, strict=True))


def _families(ds: xr.Dataset, incident: IncidentWave, elsewhere: Sequence[xr.Dataset]) -> tuple[_Family, _Family]:
    """Radiation, errors of A relative to the largest A and of B to the largest B; and excitation, to the largest X."""
    omega = ds.omega.values
    of_a, of_b, of_x = (1 / size for size in largest(ds, *elsewhere))
    a, b, x = coefficients(ds)
    x = x * incident.turn(omega)

    def radiation(at: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(of_a, of_b * at))

    return _Family(a + 1j * b / omega[:, None], radiation), _Family(x, lambda at: np.full(len(at), of_x))


@dataclass(frozen=True)
class AdaptiveSweep:
    """Coefficients at every frequency of a band, from those solved."""

    solved: xr.Dataset  # ascending frequencies
    radiation: Rational
    excitation: Rational
    incident: IncidentWave
    error: float  # estimated, of added mass, damping and excitation, relative to the band's largest entry of each

    @property
    def at_infinity(self) -> FloatArray:
        """Added mass at infinite frequency, extrapolated, shape (displacement, displacement) [kg]."""
        return self.radiation.at_infinity.reshape(self.solved.added_mass.shape[1:])

    @property
    def at_zero(self) -> FloatArray:
        """Added mass at frequency zero, extrapolated, shape (displacement, displacement) [kg]."""
        return self.radiation(np.zeros(1)).real.reshape(self.solved.added_mass.shape[1:])

    def at(self, omegas: Sequence[float]) -> xr.Dataset:
        """Return the coefficients at frequencies within the band [rad/s], a dataset as of the solver.

        Raises `ConfigError`: outside the band.
        """
        omega, (first, last) = np.asarray(omegas, dtype=float), self.solved.omega.values[[0, -1]]
        if not np.all((omega >= first) & (omega <= last)):
            raise ConfigError(
                f"omega: received {omega.min():g} to {omega.max():g} rad/s, the sweep holds {first:g} to {last:g}; "
                "sweep a wider band"
            )
        added_mass = np.empty((len(omega), self.radiation.values.shape[1]))
        damping = np.empty_like(added_mass)
        for part in in_parts(len(omega), added_mass.shape[1]):
            radiated = self.radiation(omega[part])
            added_mass[part], damping[part] = radiated.real, omega[part, None] * radiated.imag
        total = self.excitation(omega) / self.incident.turn(omega)
        known = self.incident.froude_krylov(omega).reshape(total.shape)
        values = (added_mass, damping, known, total - known)
        names = ("added_mass", "radiation_damping", *FORCES)
        shaped = {
            name: (self.solved[name].dims, rows.reshape(len(omega), *self.solved[name].shape[1:]))
            for name, rows in zip(names, values, strict=True)
        }
        return xr.Dataset(shaped, {**self.solved.coords, "omega": omega})


def crowded(count: int) -> list[int]:
    """Return the indices of the first frequencies solved, crowded to both ends of the band like Chebyshev's."""
    ends = (1 - np.cos(np.linspace(0.0, np.pi, FIRST_SOLVES))) / 2
    return [int(i) for i in np.unique(np.rint(ends * (count - 1)).astype(int))]


def _doubtful(fits: Sequence[Selected], solved: Sequence[int]) -> list[int]:
    """Indices of the largest doubt of each interpolant, the worse one first, unless they are neighbours."""
    chosen: list[int] = []
    for fit in sorted(fits, key=lambda f: -f.error):
        doubt = fit.doubt.copy()
        doubt[[*solved, *chosen]] = -1.0
        worst = int(np.argmax(doubt))
        if not chosen or abs(worst - chosen[0]) > 1:
            chosen.append(worst)
    return chosen


def _surprise(fits: Sequence[Selected], families: Sequence[_Family], omega: FloatArray, new: int) -> float:
    """Largest misfit of the interpolants at the last `new` frequencies, which they were made without."""
    at = omega[-new:]
    missed = [
        np.abs(f.rational(at) - family.values[-new:]).max(axis=1) * family.scale(at)
        for f, family in zip(fits, families, strict=True)
    ]
    return float(np.max(missed))


def _sampled(
    solve: Solve,
    frequencies: Sequence[float],
    tolerance: float,
    incident: IncidentWave,
    elsewhere: Sequence[xr.Dataset],
    most: int | None = None,
) -> AdaptiveSweep:
    """Sweep until the estimated error is below the tolerance twice in a row, or too many frequencies are solved."""
    grid = np.asarray(frequencies, dtype=float)
    most = min(MOST_SOLVES, len(grid) // 2) if most is None else min(most, len(grid))
    solved, new = crowded(len(grid)), 0
    ds = solve([frequencies[i] for i in solved])
    fits: list[Selected] = []
    while True:
        families, omega = _families(ds, incident, elsewhere), ds.omega.values
        error = max(_surprise(fits, families, omega, new), *(fit.error for fit in fits)) if fits else np.inf
        fits = [selected(omega, f.values, f.scale(omega), grid, f.scale(grid)) for f in families]
        error = max(error, *(fit.error for fit in fits))
        if error <= tolerance or len(solved) + 2 > most:
            return AdaptiveSweep(ds.sortby("omega"), fits[0].rational, fits[1].rational, incident, error)
        chosen = _doubtful(fits, solved)
        new, solved = len(chosen), solved + chosen
        ds = joined(ds, solve([frequencies[i] for i in chosen]))


def joined(*parts: xr.Dataset) -> xr.Dataset:
    """Return coefficients at the frequencies of all parts, one after the other."""
    return xr.concat(parts, dim="omega", data_vars="minimal", coords="minimal", compat="override")


@dataclass(frozen=True)
class GridSweep:
    """Coefficients on a grid of frequencies: of a sweep if one reaches a tolerance, else all solved."""

    coefficients: xr.Dataset
    sweep: AdaptiveSweep | None

    @property
    def solved(self) -> list[float]:
        """Frequencies solved, ascending [rad/s]."""
        omega: list[float] = (self.sweep.solved if self.sweep else self.coefficients).omega.values.tolist()
        return omega

    def spline_error(self, exact: Solve) -> float:
        """Return how far cubic splines are off half-way between frequencies, relative to the band's largest entry."""
        omega = self.coefficients.omega.values
        if len(omega) < 2:
            return 0.0
        between = (omega[1:] + omega[:-1]) / 2
        true = exact(between.tolist())
        errors = []
        for name in ("added_mass", "radiation_damping", *FORCES):
            missed = CubicSpline(omega, self.coefficients[name].values)(between) - true[name].values
            errors.append(relative(missed, true[name].values))
        return max(errors)


def on_grid(
    solve: Solve,
    frequencies: Sequence[float],
    tolerance: float,
    incident: IncidentWave,
    elsewhere: Sequence[xr.Dataset] = (),
    most: int | None = None,
) -> GridSweep:
    """Return coefficients over a band from as few solves as a tolerance needs, each frequency at most once.

    After every one or two solves, at the largest doubts, both families are interpolated again. The estimated error is
    the largest of the change by one support point more or less on the frequencies given, the misfit of the previous
    interpolants at the frequencies solved last, and the misfit at those solved.

    All frequencies are solved if they are few, or if coefficients are too rough to be interpolated to the tolerance
    from `most` solves (None: `MOST_SOLVES`, or half the frequencies), as with noise above the tolerance.

    Parameters
    ----------
    solve : callable
        Coefficients at given frequencies, a dataset as of `vsb.engine.hydro.spectral.solver.SpectralProblem.solve`.
    frequencies : sequence of float [rad/s]
        Ascending, the band; spaced more finely than the coefficients vary. Only these are solved.
    tolerance : float [-]
        Of added mass, damping and excitation, relative to the band's largest entry of each.
    elsewhere : sequence of xarray.Dataset
        Coefficients at other frequencies of the same band, which count for its largest entries.
    """
    if len(frequencies) < 2 * FIRST_SOLVES:
        return GridSweep(solve(list(frequencies)), None)
    swept = _sampled(solve, frequencies, tolerance, incident, elsewhere, most)
    if swept.error <= tolerance:
        return GridSweep(swept.at(frequencies), swept)
    left = sorted({*map(float, frequencies)} - {*swept.solved.omega.values.tolist()})
    parts = [swept.solved, *([solve(left)] if left else [])]
    return GridSweep(joined(*parts).sortby("omega"), None)
