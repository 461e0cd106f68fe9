"""Added mass, damping and excitation on the shapes around a reference shape, and their derivatives by its amplitudes.

A linear model has its coefficients on one shape while the shell moves. Here they are solved on shapes around it,

    A(q) = A + sum_k A_k q_k + 1/2 sum_kl A_kl q_k q_l + O(q^3),

always for displacements of material points, so a mode is the same motion on every shape; by heave, the draft changes.
A_k and A_kk are central differences at three steps along q_k, extrapolated twice, A_kl follows from those at two
steps along q_k + q_l; the error comes out of the same run.

The shape database holds these second-order expansions, mixed terms included, for any amplitudes within reach. Of
excitation it expands

    X(q) = exp(i sum_k b_k q_k) (X + ...),   b_k = Im X^H X_k/|X|^2,

since a wider shell meets the waves earlier: in short waves its phase turns by far more than its size changes. Damping
follows from excitation by Haskind's relation: it takes energy from every motion on every shape. The third order left
out is about

    c (sum_k (a_k^(1/3) q_k)^2)^(3/2) + sum_k s_k |q_k| + e,

a_k a sixth of the third derivative along each amplitude, c three times the largest ratio to it of errors on shapes
tried within reach, s_k the error of the first derivative, e three times the difference on the reference shape from a
solution with a third more points; all relative, as of `misfit`.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.linalg import block_diag

from vsb.engine.hydro.database import Coefficients, displacements_of, in_modes, with_excitation
from vsb.engine.hydro.dofs import normal_velocities
from vsb.engine.hydro.spectral.meridian import WetMeridian, unit_rule
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.hydro.variables import PAIR
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.meridian import Curve
from vsb.engine.waves.water import haskind_factor
from vsb.errors import ConfigError, DatabaseError
from vsb.keys.quantities import content_id
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.files import load, save

COEFFICIENTS = ("added_mass", "radiation_damping", "excitation_force", "added_mass_inf")
"""Coefficients that depend on the shape."""


class Line(NamedTuple):
    """Derivatives along one direction."""

    slope: xr.Dataset  # first [unit per m]
    curvature: xr.Dataset  # second [unit per m^2]
    correction: xr.Dataset  # last correction of the extrapolation of `slope`
    cubic: xr.Dataset  # a sixth of the third, to second order in the step [unit per m^3]


def extrapolated(levels: Sequence[xr.Dataset]) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the limit of values at steps h, h/2, h/4, ... whose errors are even in h, and its last correction."""
    table, power = list(levels), 4.0
    while len(table) > 1:
        best = table[-1]
        table = [fine + (fine - coarse) / (power - 1) for coarse, fine in itertools.pairwise(table)]
        power *= 4
    return table[0], table[0] - best


def misfit(value: xr.DataArray, exact: xr.DataArray) -> float:
    """Return the largest difference of any entry at any frequency relative to the largest entry of all [-]."""
    return float(np.abs(value - exact).max() / np.abs(exact).max())


def haskind_damping(omega: FloatArray, x: ComplexArray, density: float, gravity: float) -> FloatArray:
    """Return B = k/(4 rho g v_g) Re X X^H of heave and axisymmetric modes in deep water, (omega, dof, dof) [kg/s].

    From excitation `x`, shape (omega, dof) [N/m]; positive semidefinite for any `x`.
    """
    factor = haskind_factor(omega, np.inf, density, gravity)[:, None, None]
    return np.asarray(factor * (x[:, :, None] * x[:, None, :].conj()).real)


def haskind_slope(omega: FloatArray, x: ComplexArray, dx: ComplexArray, density: float, gravity: float) -> FloatArray:
    """Return dB = k (dX X^H + X dX^H)/(4 rho g v_g), shape (..., omega, dof, dof) [kg/(m s)].

    From excitation `x`, (omega, dof) [N/m], and its derivative `dx`, (..., omega, dof) [N/m^2]; in deep water.
    """
    half = dx[..., :, None] * x[:, None, :].conj()
    factor = haskind_factor(omega, np.inf, density, gravity)[:, None, None]
    return np.asarray((factor * (half + half.swapaxes(-1, -2).conj())).real)


def _stacked(parts: Sequence[xr.Dataset], labels: list[str], dim: str = "shape_dof") -> xr.Dataset:
    """Datasets of all degrees of freedom on a leading dimension."""
    index = xr.DataArray(labels, dims=dim, name=dim)
    return xr.concat(parts, index, coords="minimal", compat="override", join="override")


@dataclass(frozen=True)
class ShapeFamily:
    """Coefficients of one shell in deep water on the shapes around a reference shape, at rest or deformed."""

    shape: DeformedShell
    omegas: tuple[float, ...]  # [rad/s]
    density: float  # of water [kg/m^3]
    gravity: float  # [m/s^2]
    nodes: int = 48
    step: float = 0.01  # largest step of the differences, in radii of the shell [-]
    store: Path | None = None  # folder of shapes solved, each under its content id, from which a run resumes
    after_each: Callable[[], None] = lambda: None  # called after each shape

    @property
    def labels(self) -> list[str]:
        """Names of heave and modes."""
        return list(self.shape.basis.labels)

    @property
    def shapes_of_derivatives(self) -> int:
        """Number of shapes the first and second derivatives need."""
        dof = len(self.labels)
        return 1 + 6 * dof + 2 * dof * (dof - 1)

    @property
    def finer(self) -> "ShapeFamily":
        """The same family with a third more points: convergence is spectral, so its errors are far smaller."""
        return replace(self, nodes=math.ceil(4 * self.nodes / 3))

    def about(self, modal_amplitude: FloatArray) -> "ShapeFamily":
        """Return the family around a shape `modal_amplitude` (dof,) [m] away; `ConfigError` for another length."""
        dof = len(self.labels)
        if np.shape(modal_amplitude) != (dof,):
            raise ConfigError(
                f"modal_amplitude: received shape {np.shape(modal_amplitude)}; needs ({dof},), heave and all modes"
            )
        return replace(self, shape=replace(self.shape, modal_amplitude=self.shape.modal_amplitude + modal_amplitude))

    def at(self, modal_amplitude: FloatArray) -> xr.Dataset:
        """Return `COEFFICIENTS` of heave and modes on the shape deformed further, dimensions as of a hydro database.

        `modal_amplitude`, shape (dof,) [m], count from the reference shape. `ConfigError` if they are not one for each
        degree of freedom, or if the shape does not cross the water once.
        """
        moved = self.about(modal_amplitude)
        path = self.store / f"{moved.identity}.nc" if self.store else None
        if path and path.is_file():
            solved = load(path)[list(COEFFICIENTS)]
        else:
            solved = moved.solved()
            if path:
                save(solved, path)
        self.after_each()
        return solved

    @property
    def identity(self) -> str:
        """Content id of everything that `solved` depends on."""
        basis, shape = self.shape.basis, self.shape
        return content_id({
            "modes": [[[n, float(v), float(u)] for n, v, u in mode.parts] for mode in basis.shapes],
            "radius": float(basis.shell.radius),
            "centre_height": float(shape.centre_height),
            "amplitudes": shape.modal_amplitude.tolist(),
            "omega": [float(omega) for omega in self.omegas],
            "water": [float(self.density), float(self.gravity)],
            "nodes": self.nodes,
        })  # fmt: skip

    def solved(self) -> xr.Dataset:
        """Return the coefficients on the reference shape, newly solved."""
        basis = self.shape.basis
        problem = SpectralProblem(self.shape, displacements_of(basis), self.density, self.gravity, self.nodes)
        raw = problem.solve(list(self.omegas)).assign(added_mass_inf=(PAIR, problem.at_infinity()))
        return with_excitation(in_modes(raw, basis))[list(COEFFICIENTS)]

    @cached_property
    def centre(self) -> xr.Dataset:
        """Coefficients on the reference shape."""
        return self.at(np.zeros(len(self.labels)))

    def along(self, direction: FloatArray, levels: int = 3) -> Line:
        """Return derivatives along `direction`, shape (dof,), by central differences at two or more `levels` of steps.

        The steps are `step` radii times `direction`, and half as long at each level.
        """
        steps = self.step * self.shape.basis.shell.radius / 2.0 ** np.arange(levels)
        slopes, curvatures = [], []
        for h in steps:
            plus, minus = (self.at(sign * h * direction) for sign in (1, -1))
            slopes.append((plus - minus) / (2 * h))
            curvatures.append((plus - 2 * self.centre + minus) / h**2)
        slope, correction = extrapolated(slopes)
        cubic = (slopes[0] - slopes[1]) / (steps[0] ** 2 - steps[1] ** 2)
        return Line(slope, extrapolated(curvatures)[0], correction, cubic)

    @cached_property
    def axes(self) -> tuple[Line, ...]:
        """Derivatives along heave and every mode."""
        return tuple(map(self.along, np.eye(len(self.labels))))

    @cached_property
    def slopes(self) -> xr.Dataset:
        """First derivatives, (shape_dof, omega, influenced_dof, radiating_dof) and the like [unit per m]."""
        return _stacked([line.slope for line in self.axes], self.labels)

    @cached_property
    def curvatures(self) -> xr.Dataset:
        """Second derivatives by all pairs of modal amplitudes, (shape_dof, other_shape_dof, ...) [unit per m^2]."""
        unit, dofs = np.eye(len(self.labels)), range(len(self.labels))
        table = {(i, i): line.curvature for i, line in enumerate(self.axes)}
        for i, j in itertools.combinations(dofs, 2):  # along both: A_ii + 2 A_ij + A_jj
            both = self.along(unit[i] + unit[j], levels=2).curvature
            table[i, j] = table[j, i] = (both - table[i, i] - table[j, j]) / 2
        rows = [_stacked([table[i, j] for j in dofs], self.labels, "other_shape_dof") for i in dofs]
        return _stacked(rows, self.labels)

    @cached_property
    def slope_errors(self) -> xr.Dataset:
        """Estimated errors of the derivatives, relative to the largest entry of each over the band, (shape_dof,) [-].

        The last correction of the extrapolation plus errors of discretization: asymmetry and misfit of Haskind's.
        """
        turned = {"influenced_dof": "radiating_dof", "radiating_dof": "influenced_dof"}
        errors: dict[str, list[float]] = {name: [] for name in COEFFICIENTS}
        for line in self.axes:
            slope = line.slope
            x, dx = (ds.excitation_force.values[:, 0] for ds in (self.centre, slope))
            haskind = haskind_slope(np.array(self.omegas), x, dx, self.density, self.gravity)
            missed = dict.fromkeys(
                COEFFICIENTS, misfit(slope.radiation_damping.copy(data=haskind), slope.radiation_damping)
            )
            for name in ("added_mass", "added_mass_inf"):
                missed[name] = misfit(slope[name].rename(turned), slope[name])
            for name in COEFFICIENTS:
                errors[name].append(misfit(slope[name] + line.correction[name], slope[name]) + missed[name])
        return xr.Dataset({n: ("shape_dof", e) for n, e in errors.items()}, {"shape_dof": self.labels})

    @cached_property
    def derivatives(self) -> xr.Dataset:
        """Coefficients, `<name>_slope`, `<name>_curvature`, `<name>_slope_error`."""
        parts = {"_slope": self.slopes, "_curvature": self.curvatures, "_slope_error": self.slope_errors}
        renamed = [ds.rename({name: f"{name}{suffix}" for name in COEFFICIENTS}) for suffix, ds in parts.items()]
        return xr.merge([self.centre, *renamed])

    def expansion(self, modal_amplitude: FloatArray, order: int) -> xr.Dataset:
        """Return the coefficients at amplitudes (dof,) [m] to order 1 or 2; else `ConfigError`."""
        if order not in (1, 2):
            raise ConfigError(f"order: received {order}; needs 1 or 2")
        q = xr.DataArray(modal_amplitude, coords={"shape_dof": self.labels}, dims="shape_dof")
        linear = self.centre + (q * self.slopes).sum("shape_dof")
        if order == 1:
            return linear
        other = q.rename(shape_dof="other_shape_dof")
        return linear + self.curvatures.map(lambda curvature: xr.dot(curvature, q, other)) / 2

    def interpolation_error(self, amplitude: float, *, samples: int = 8) -> xr.Dataset:
        """Return the largest errors of `expansion` against direct solution, as of `misfit`, shape (order,) [-].

        Over `samples` deformations in random directions, the same for every root-sum-square `amplitude` [m];
        `ConfigError` if that is not positive.
        """
        if not amplitude > 0:
            raise ConfigError(f"amplitude: received {amplitude:g} m; needs a positive size of the deformation")
        vectors = np.random.default_rng(0).standard_normal((samples, len(self.labels)))
        errors = np.zeros((len(COEFFICIENTS), 2))
        for q in amplitude * vectors / np.linalg.norm(vectors, axis=1, keepdims=True):
            direct, models = self.at(q), [self.expansion(q, order) for order in (1, 2)]
            errors = np.maximum(errors, [[misfit(m[name], direct[name]) for m in models] for name in COEFFICIENTS])
        return xr.Dataset({n: ("order", e) for n, e in zip(COEFFICIENTS, errors, strict=True)}, {"order": [1, 2]})


SAFETY = 3.0
"""The estimate in terms of the largest error measured, for its size."""
_EXPANDED = ("added_mass", "excitation_force", "added_mass_inf")


@dataclass(frozen=True)
class ShapeDatabase:
    """Coefficients A(omega; q), B, X about one reference shape; `dataset` as of `shape_database`."""

    dataset: xr.Dataset

    @cached_property
    def labels(self) -> list[str]:
        """Names of heave and modes."""
        return [str(label) for label in self.dataset.shape_dof.values]

    @cached_property
    def omega(self) -> FloatArray:
        """Frequencies solved, shape (omega,) [rad/s]."""
        return np.asarray(self.dataset.omega.values)

    @cached_property
    def reach(self) -> FloatArray:
        """Largest amplitudes the database holds, either sign, shape (dof,) [m]."""
        return np.asarray(self.dataset.shape_reach.values)

    @cached_property
    def _terms(self) -> dict[str, tuple[ComplexArray | FloatArray, ...]]:
        """Value, first and second derivatives of coefficients; symmetric matrices, excitation without phase."""
        terms = {n: tuple(self._array(f"{n}{part}") for part in ("", "_slope", "_curvature")) for n in _EXPANDED}
        x, slope, curvature = terms["excitation_force"]
        turn = 1j * self._phase_rates[:, :, None]
        mixed = turn[:, None] * slope[None]
        unturned = curvature - mixed - mixed.swapaxes(0, 1) + turn[:, None] * turn[None] * x
        return {**terms, "excitation_force": (x, slope - turn * x, unturned)}

    @cached_property
    def _phase_rates(self) -> FloatArray:
        """Rates at which the excitation's phase turns with modal amplitudes, shape (dof, omega) [rad/m]."""
        return phase_rates(self._array("excitation_force"), self._array("excitation_force_slope"))

    def _array(self, name: str) -> ComplexArray | FloatArray:
        data = self.dataset[name]
        if "wave_direction" in data.dims:
            return np.asarray(data.isel(wave_direction=0).values)
        return np.asarray((data.values + data.values.swapaxes(-1, -2)) / 2)

    def _checked(self, modal_amplitude: FloatArray) -> FloatArray:
        """Amplitudes, checked for number and reach."""
        q, dof = np.asarray(modal_amplitude, dtype=float), len(self.labels)
        if q.shape != (dof,):
            raise ConfigError(f"modal_amplitude: received shape {q.shape}; needs ({dof},), heave and all modes")
        beyond = ~(np.abs(q) <= self.reach * (1 + 1e-9))
        if beyond.any():
            k = int(np.argmax(beyond))
            raise ConfigError(
                f"modal_amplitude: received {self.labels[k]} = {q[k]:.4g} m; the shape database holds "
                f"{self.reach[k]:.4g} m either way: build it with more reach"
            )
        return q

    def _expanded(self, name: str, q: FloatArray) -> ComplexArray | FloatArray:
        """Second-order expansion of one coefficient at the frequencies solved."""
        value, slope, curvature = self._terms[name]
        gradient = slope + np.tensordot(q, curvature, 1) / 2
        return np.asarray(value + np.tensordot(q, gradient, 1))

    def at(self, omega: FloatArray, modal_amplitude: FloatArray) -> Coefficients:
        """Return the coefficients on a shape by cubic splines between solved frequencies.

        Raises `ConfigError` if an amplitude is out of reach, or their number is another; `DatabaseError`: outside the
        band solved.

        Parameters
        ----------
        omega : ndarray, shape (omega,) [rad/s]
        modal_amplitude : ndarray, shape (dof,) [m]
            Of heave and modes, from the reference shape.
        """
        q, (first, last) = self._checked(modal_amplitude), self.omega[[0, -1]]
        if not (np.all(omega >= first - 1e-9) and np.all(omega <= last + 1e-9)):
            raise DatabaseError(
                f"frequencies {np.min(omega):.4g} to {np.max(omega):.4g} rad/s are asked for, the shape database "
                f"holds {first:g} to {last:g} rad/s; build it for a wider band."
            )
        weights = CubicSpline(self.omega, np.eye(len(self.omega)))(omega)
        phase = np.exp(1j * q @ self._phase_rates)[:, None]
        added = np.tensordot(weights, self._expanded("added_mass", q), 1)
        force = np.asarray(weights @ (phase * self._expanded("excitation_force", q)), dtype=complex)
        return Coefficients(added.real, self._damping(omega, force), force)

    def added_mass_inf(self, modal_amplitude: FloatArray) -> FloatArray:
        """Return added mass at infinite frequency on a shape, shape (dof, dof) [kg]; errors as of `at`."""
        return np.asarray(self._expanded("added_mass_inf", self._checked(modal_amplitude)).real)

    def _damping(self, omega: FloatArray, force: ComplexArray) -> FloatArray:
        attrs = self.dataset.attrs
        return haskind_damping(np.asarray(omega), force, float(attrs["water_density"]), float(attrs["gravity"]))

    def error(self, modal_amplitude: FloatArray) -> dict[str, float]:
        """Return estimated errors of `COEFFICIENTS` on a shape at the frequencies solved, as of `misfit` [-]."""
        q, ds = np.abs(self._checked(modal_amplitude)), self.dataset
        estimates = _cubic_size(ds.remainder.values, q) * ds.remainder_scale.values + ds.slope_noise.values @ q
        return dict(zip(COEFFICIENTS, map(float, estimates + ds.reference_error.values), strict=True))


def phase_rates(force: ComplexArray | FloatArray, slopes: ComplexArray | FloatArray) -> FloatArray:
    """Return Im X^H X_k/|X|^2 of excitation (omega, dof) and its derivatives (dof, omega, dof), shape (dof, omega)."""
    size = np.maximum(np.sum(np.abs(force) ** 2, axis=1), np.finfo(float).tiny)
    return np.asarray(np.einsum("wi,kwi->kw", force.conj(), slopes).imag / size)


def _cubic_size(remainder: FloatArray, q: FloatArray) -> FloatArray:
    """(sum_k (a_k^(1/3) q_k)^2)^(3/2) of each coefficient, shape (..., coefficient); remainder (coefficient, dof)."""
    return np.asarray((np.cbrt(remainder) ** 2 @ np.square(q).T) ** 1.5).T


def tried_shapes(reach: FloatArray, samples: int, seed: int = 0) -> FloatArray:
    """Return shapes to measure errors on, (shape, dof) [m]: each amplitude alone, then `samples` random shapes.

    In the latter all amplitudes are nonzero, in every other one all at the end of their reach.
    """
    rng = np.random.default_rng(seed)
    mixed = rng.uniform(-1.0, 1.0, (samples, len(reach)))
    mixed[1::2] = np.sign(mixed[1::2])
    return np.asarray(np.concatenate([np.eye(len(reach)), -np.eye(len(reach)), mixed]) * reach)


def measured_errors(database: ShapeDatabase, family: ShapeFamily, shapes: FloatArray) -> FloatArray:
    """Return errors against direct solutions on shapes (shape, dof) [m], as of `misfit`, (shape, coefficient) [-]."""
    return np.array([_measured(database, q, family.at(q)) for q in shapes])


def _left_out(family: ShapeFamily) -> list[xr.Dataset]:
    """Terms of third order along each amplitude that the database lacks; for damping for any phase of excitation."""
    x = family.centre.excitation_force.values
    rates = phase_rates(x[:, 0], family.slopes.excitation_force.values[:, :, 0])
    left_out = []
    for line, rate in zip(family.axes, rates, strict=True):
        turn = -1j * rate[:, None, None]
        dx = line.cubic.excitation_force + turn * line.curvature.excitation_force / 2
        dx = np.abs(dx + turn**2 / 2 * line.slope.excitation_force + turn**3 / 6 * x)
        terms = np.abs(x[:, 0]).astype(complex), dx.values[:, 0].astype(complex)
        damping = haskind_slope(np.array(family.omegas), *terms, family.density, family.gravity)
        changed = {"excitation_force": dx, "radiation_damping": line.cubic.radiation_damping.copy(data=damping)}
        left_out.append(line.cubic.assign(changed))
    return left_out


def _measured(database: ShapeDatabase, q: FloatArray, direct: xr.Dataset) -> list[float]:
    """Errors of `COEFFICIENTS` on one shape."""
    added, damping, force = database.at(database.omega, q)
    values = (added, damping, force[:, None], database.added_mass_inf(q))
    return [
        misfit(direct[name].copy(data=value), direct[name]) for name, value in zip(COEFFICIENTS, values, strict=True)
    ]


def shape_database(family: ShapeFamily, reach: FloatArray, samples: int = 20) -> ShapeDatabase:
    """Build the database of a family of shapes.

    Parameters
    ----------
    reach : ndarray, shape (dof,) [m]
        Largest amplitudes, all positive (else `ConfigError`).
    samples : int
        Number of random combinations of amplitudes that the error is measured on, besides each amplitude alone.
    """
    if np.shape(reach) != (len(family.labels),) or not np.all(np.asarray(reach) > 0):
        raise ConfigError(f"reach: received {reach} m; needs {len(family.labels)} positive amplitudes, heave and modes")
    table, shapes = ("coefficient", "shape_dof"), tried_shapes(reach, samples)
    size = {name: float(np.abs(family.centre[name]).max()) for name in COEFFICIENTS}
    cubic = [[float(np.abs(ds[name]).max()) / size[name] for ds in _left_out(family)] for name in COEFFICIENTS]
    largest = {name: np.abs(family.slopes[name].values).reshape(len(reach), -1).max(axis=1) for name in COEFFICIENTS}
    noise = [family.slope_errors[name].values * largest[name] / size[name] for name in COEFFICIENTS]
    bare = family.derivatives.assign(
        shape_reach=("shape_dof", reach),
        remainder=(table, cubic),
        slope_noise=(table, noise),
        tried_shape=(("tried", "shape_dof"), shapes),
    ).assign_attrs(water_density=family.density, gravity=family.gravity)
    bare = bare.assign_coords(coefficient=list(COEFFICIENTS))
    errors = measured_errors(ShapeDatabase(bare), family, shapes)
    scale = SAFETY * np.max(errors / _cubic_size(np.array(cubic), shapes), axis=0)
    points = SAFETY * np.array(_measured(ShapeDatabase(bare), np.zeros(len(reach)), family.finer.centre))
    found = {"remainder_scale": ("coefficient", scale), "reference_error": ("coefficient", points)}
    return ShapeDatabase(bare.assign(found).assign(tried_error=(("tried", "coefficient"), errors)))


Directions = Callable[[FloatArray], Curve]
"""Colatitudes (point,) [rad] -> radial and vertical displacement of the points there and their slopes by colatitude,
each (direction, point), per unit of each change of the shape."""


class ShapeDerivative(NamedTuple):
    """Coefficients of displacements of one shape, and their derivatives by changes of the shape."""

    radiation: ComplexArray  # A + i B/omega (omega, displacement, displacement) [kg]
    excitation: ComplexArray  # per wave amplitude (omega, displacement) [N/m]
    radiation_change: ComplexArray  # (omega, direction, displacement, displacement) [kg per unit of the direction]
    excitation_change: ComplexArray  # (omega, direction, displacement)


def slope_matrix(meridian: WetMeridian) -> FloatArray:
    """Return the derivatives by t, at the nodes, of the polynomials that are one at one node, shape (node, node).

    See Berrut and Trefethen, Barycentric Lagrange Interpolation (2004), section 9.
    """
    pieces = []
    for piece in meridian.pieces:
        t, weight = unit_rule(piece.nodes)
        scale = (-1.0) ** np.arange(piece.nodes) * np.sqrt(t * (1 - t) * weight)
        slopes = scale / scale[:, None] / (t[:, None] - t + np.eye(piece.nodes))
        np.fill_diagonal(slopes, 0.0)
        np.fill_diagonal(slopes, -slopes.sum(axis=1))
        pieces.append(slopes / (piece.end - piece.start))
    return block_diag(*pieces)


def shape_derivative(problem: SpectralProblem, omegas: list[float], directions: Directions) -> ShapeDerivative:
    """Return added mass, damping and excitation at frequencies and their derivatives by changes of the wetted shape.

    Raises `ConfigError` if the displacements are of another azimuthal order than 0.

    Parameters
    ----------
    problem : SpectralProblem
        Of axisymmetric displacements. The derivatives need twice the digits of the coefficients: 32 nodes give 1e-8.
    omegas : list of float [rad/s]
    directions : callable
        How the points move; the amplitude of `Radial0` of unit radial displacement is the radius of a sphere.

    Notes
    -----
    Hadamard's boundary formulas for axisymmetric motion (m = 0) in water of any depth. With colatitude phi as the label
    of material points, ' = d/dphi, the displacements (X_i, Z_i) per unit amplitude and f_i = x (-z' X_i + x' Z_i),

        G_ij = 2 pi int f_i phi_j dphi,    A + i B/omega = -rho G,    excitation = -rho g G_iT,

    where phi_j is the potential of the normal velocity w_j and phi_T that of the incident wave and the body held, w_T =
    0. If points move by (X_k, Z_k), of normal part eta and tangential part tau, the surface element and the potential
    on the moving points change by

        T_ij = 2 pi {int [X_k (-z' X_i + x' Z_i) + x (-Z_k' X_i + X_k' Z_i)] phi_j dphi
                     + int f_i (tau d_s phi_j + eta w_j) dphi - f_i phi_j|_w dphi_w},    dphi_w = -Z_k/z',

    the last at the waterline w, whose material points change. The potentials change, too; by reciprocity no further
    problem needs to be solved:

        dG_ij = T_ij + T_ji - 2 pi int eta (d_s phi_i d_s phi_j + w_i w_j) x ds
                + 2 pi (omega^2/g) x_w delta phi_i phi_j|_w,                                delta = X_k - x' Z_k/z',
        dG_iT = T_iT - 2 pi int eta d_s phi_i d_s phi_T x ds + 2 pi (omega^2/g) x_w delta phi_i phi_T|_w.
    """
    if problem.order:
        raise ConfigError(f"displacements: received azimuthal order {problem.order}; shape derivatives need order 0")
    m, phi = problem.meridian, problem.potentials(omegas).swapaxes(1, 2)  # (omega, displacement and wave, node)
    p, area, w = m.points, m.areas, problem.velocities
    w_all = np.vstack([w, np.zeros(m.count)])  # the body is held in the incident wave
    slope = (phi @ slope_matrix(m).T) * (p.x / p.rate)  # by the length of the arc
    at, moved, (x_i, z_i) = m.shell.curve(p.colatitude), directions(p.colatitude), _components(problem, p.colatitude)
    normal, tangential = moved.x * p.n_x + moved.z * p.n_z, moved.x * p.n_z - moved.z * p.n_x
    turned = (moved.dx[:, None] * z_i - moved.dz[:, None] * x_i) / np.hypot(at.dx, at.dz)
    element = (moved.x[:, None] * w / p.x + turned) * area  # change of f_i dphi, (direction, displacement, node)
    phi, slope = phi[:, None], slope[:, None]  # (omega, 1, displacement and wave, node)
    followed = tangential[:, None] * slope + normal[:, None] * w_all

    edge = np.array([m.waterline])
    rim, rim_moved = m.shell.curve(edge), directions(edge)
    (x_w, _, dx_w, dz_w), (rim_x, rim_z) = rim, (values[:, 0] for values in _components(problem, edge))
    phi_w = (phi @ m.interpolation(np.zeros(1))[0])[..., None, :]  # (omega, 1, 1, displacement and wave)
    f_w = (x_w * (-dz_w * rim_x + dx_w * rim_z))[:, None]
    phi_moved, reach = -rim_moved.z[:, :, None] / dz_w, (rim_moved.x - dx_w * rim_moved.z / dz_w)[:, :, None]

    t = element @ phi.swapaxes(2, 3) + (w * area) @ followed.swapaxes(2, 3) - phi_moved * f_w * phi_w
    kinetic = (slope[:, :, :-1] * (normal * area)[:, None]) @ slope.swapaxes(2, 3)
    kinetic = kinetic + (w * (normal * area)[:, None]) @ w_all.T
    surface = (np.square(omegas) / problem.gravity)[:, None, None, None] * x_w * reach
    change = t - kinetic + surface * phi_w[..., :-1].swapaxes(2, 3) * phi_w
    change[..., :-1] += t[..., :-1].swapaxes(2, 3)
    change *= -2 * np.pi * problem.density
    whole = problem.onto @ phi[:, 0].swapaxes(1, 2)
    gravity = problem.gravity
    return ShapeDerivative(whole[..., :-1], gravity * whole[..., -1], change[..., :-1], gravity * change[..., -1])


def _components(problem: SpectralProblem, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radial and vertical displacement per unit amplitude at points, each (displacement, point) [-]."""
    nowhere, one, none = np.zeros((2, len(colatitude))), np.ones(len(colatitude)), np.zeros(len(colatitude))
    return (
        normal_velocities(problem.displacements, colatitude, nowhere, np.array([one, none])),
        normal_velocities(problem.displacements, colatitude, nowhere, np.array([none, one])),
    )
