"""A hydro database over frequency and shape: coefficients at any amplitudes within reach, and their error.

Values are second-order expansions about the reference shape, mixed terms included (`shapefamily.py`). Of excitation

    X(q) = exp(i sum_k b_k q_k) (X + ...),   b_k = Im X^H X_k/|X|^2,

since a wider shell meets the waves earlier: short ones turn its phase by far more than its size. Damping follows from
excitation by Haskind's relation: it takes energy from every motion on every shape. The third order left out is about

    c (sum_k (a_k^(1/3) q_k)^2)^(3/2) + sum_k s_k |q_k| + e,

a_k a sixth of the third derivative along each amplitude, c three times the largest ratio to it of errors on shapes
tried within reach, s_k the error of the first derivative, e three times what the database misses on the reference shape
of a solution with a third more points; all relative, as of `misfit`.
"""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro.coefficients import Coefficients
from vsb.hydro.shapes.family import COEFFICIENTS, ShapeFamily, haskind_damping, haskind_slope, misfit
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.files import load, save

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
        """Value, first and second derivatives of what is expanded; matrices symmetric, excitation without the phase."""
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
        """Amplitudes that are one for each degree of freedom and within reach."""
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

        Parameters
        ----------
        omega : ndarray, shape (omega,) [rad/s]
        modal_amplitude : ndarray, shape (dof,) [m]
            Of heave and modes, from the reference shape.

        Raises
        ------
        ConfigError
            If an amplitude is out of reach, or their number is another.
        DatabaseError
            Outside the band solved.
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

    def save(self, path: str | Path) -> None:
        """Write the database as netCDF."""
        save(self.dataset, path)

    @classmethod
    def load(cls, path: str | Path) -> "ShapeDatabase":
        """Read a database written by `save`; `DatabaseError` if the file is no shape database."""
        ds = load(path)
        needed = {"shape_reach", "remainder", "remainder_scale", "slope_noise", "reference_error", *_EXPANDED}
        if missing := needed - {str(name) for name in ds.data_vars}:
            raise DatabaseError(f"{path}: no shape database, without {sorted(missing)}; run vsb shape-dependence.")
        return cls(ds)


def phase_rates(force: ComplexArray | FloatArray, slopes: ComplexArray | FloatArray) -> FloatArray:
    """Return Im X^H X_k/|X|^2 of excitation (omega, dof) and its derivatives (dof, omega, dof), shape (dof, omega)."""
    size = np.maximum(np.sum(np.abs(force) ** 2, axis=1), np.finfo(float).tiny)
    return np.asarray(np.einsum("wi,kwi->kw", force.conj(), slopes).imag / size)


def _cubic_size(remainder: FloatArray, q: FloatArray) -> FloatArray:
    """(sum_k (a_k^(1/3) q_k)^2)^(3/2) of each coefficient, shape (..., coefficient); remainder (coefficient, dof)."""
    return np.asarray((np.cbrt(remainder) ** 2 @ np.square(q).T) ** 1.5).T


def tried_shapes(reach: FloatArray, samples: int, seed: int = 0) -> FloatArray:
    """Return shapes to measure errors on, (shape, dof) [m]: each amplitude alone, random shapes within, random corners.

    `samples` random ones, all amplitudes at once, every other of them with all at the end of their reach.
    """
    rng = np.random.default_rng(seed)
    mixed = rng.uniform(-1.0, 1.0, (samples, len(reach)))
    mixed[1::2] = np.sign(mixed[1::2])
    return np.asarray(np.concatenate([np.eye(len(reach)), -np.eye(len(reach)), mixed]) * reach)


def measured_errors(database: ShapeDatabase, family: ShapeFamily, shapes: FloatArray) -> FloatArray:
    """Return errors against direct solutions on shapes (shape, dof) [m], as of `misfit`, (shape, coefficient) [-]."""
    return np.array([_measured(database, q, family.at(q)) for q in shapes])


def _left_out(family: ShapeFamily) -> list[xr.Dataset]:
    """Terms of third order along each amplitude the database lacks; of damping, whatever the excitation's phase."""
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
    family : ShapeFamily
    reach : ndarray, shape (dof,) [m]
        Largest amplitudes asked for, all positive (`ConfigError`).
    samples : int
        Random combinations of amplitudes the error is measured on, next to each amplitude alone.
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
