"""Added mass, damping and excitation on the shapes around a reference shape, and their derivatives by its amplitudes.

A linear model takes its coefficients on one shape while the shell moves. Here they are solved on shapes around it,

    A(q) = A + sum_k A_k q_k + 1/2 sum_kl A_kl q_k q_l + O(q^3),

always for displacements of material points, so a mode is the same motion on every shape; by heave, the draft changes.
A_k and A_kk are central differences at three steps along q_k, extrapolated twice, A_kl follows from those at two
steps along q_k + q_l; the error comes out of the same run.
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

from vsb.errors import ConfigError
from vsb.hydro.database import displacements_of, in_modes, with_excitation
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.variables import PAIR
from vsb.shell.deformed import DeformedShell
from vsb.study.study import content_id
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.files import load, save

COEFFICIENTS = {
    "added_mass": ("kg", "kg/m", "kg/m^2"),
    "radiation_damping": ("kg/s", "kg/(m s)", "kg/(m^2 s)"),
    "excitation_force": ("N/m", "N/m^2", "N/m^3"),
    "added_mass_inf": ("kg", "kg/m", "kg/m^2"),
}
"""What depends on the shape; units of it and of its first and second derivative."""


class Line(NamedTuple):
    """Derivatives along one direction."""

    slope: xr.Dataset  # first [unit per m]
    curvature: xr.Dataset  # second [unit per m^2]
    correction: xr.Dataset  # the extrapolation's last, of `slope`
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
    """Return the largest difference of any entry at any frequency in terms of the largest entry of all [-]."""
    return float(np.abs(value - exact).max() / np.abs(exact).max())


def haskind_damping(omega: FloatArray, x: ComplexArray, density: float, gravity: float) -> FloatArray:
    """Return B = k/(2 rho g v_g) Re X X^H of heave and axisymmetric modes in deep water, (omega, dof, dof) [kg/s].

    Of excitation `x`, shape (omega, dof) [N/m]. It takes energy from no motion, whatever `x` is.
    """
    scale = omega[:, None, None] ** 3 / (2 * density * gravity**3)
    return np.asarray(scale * (x[:, :, None] * x[:, None, :].conj()).real)


def haskind_slope(omega: FloatArray, x: ComplexArray, dx: ComplexArray, density: float, gravity: float) -> FloatArray:
    """Return dB = k (dX X^H + X dX^H)/(4 rho g v_g), shape (..., omega, dof, dof) [kg/(m s)].

    Of excitation `x`, (omega, dof) [N/m], and its derivative `dx`, (..., omega, dof) [N/m^2]; in deep water.
    """
    half = dx[..., :, None] * x[:, None, :].conj()
    scale = omega[:, None, None] ** 3 / (2 * density * gravity**3)
    return np.asarray((scale * (half + half.swapaxes(-1, -2).conj())).real)


def _stacked(parts: Sequence[xr.Dataset], labels: list[str], dim: str = "shape_dof") -> xr.Dataset:
    """Datasets of all degrees of freedom on a leading dimension."""
    index = xr.DataArray(labels, dims=dim, name=dim)
    return xr.concat(parts, index, coords="minimal", compat="override", join="override")


def _nothing() -> None:
    """What is called after each shape where no one watches."""


@dataclass(frozen=True)
class ShapeFamily:
    """Coefficients of one shell in deep water on the shapes around a reference shape, at rest or deformed."""

    shape: DeformedShell
    omegas: tuple[float, ...]  # [rad/s]
    density: float  # of water [kg/m^3]
    gravity: float  # [m/s^2]
    nodes: int = 48
    step: float = 0.01  # largest step of the differences, in radii of the shell [-]
    store: Path | None = None  # folder of shapes solved, each under its content id, so that a run can go on
    after_each: Callable[[], None] = _nothing

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
        """The same family solved with a third more points: their errors are far smaller, convergence is spectral."""
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
        """Content id of what `solved` depends on."""
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

    def _missed(self, slope: xr.Dataset) -> dict[str, float]:
        """What the derivative by one amplitude misses of symmetry and of Haskind's relation, relative [-]."""
        turned = {"influenced_dof": "radiating_dof", "radiating_dof": "influenced_dof"}
        x, dx = (ds.excitation_force.values[:, 0] for ds in (self.centre, slope))
        haskind = haskind_slope(np.array(self.omegas), x, dx, self.density, self.gravity)
        damping = misfit(slope.radiation_damping.copy(data=haskind), slope.radiation_damping)
        even = {name: misfit(slope[name].rename(turned), slope[name]) for name in ("added_mass", "added_mass_inf")}
        return {**even, "radiation_damping": damping, "excitation_force": damping}

    @cached_property
    def slope_errors(self) -> xr.Dataset:
        """Estimated errors of the derivatives, relative to the largest entry of each over the band, (shape_dof,) [-].

        The last correction of the extrapolation; plus asymmetry, and damping against Haskind's: the discretization's.
        """
        missed = [self._missed(line.slope) for line in self.axes]
        errors = {
            name: [
                misfit(line.slope[name] + line.correction[name], line.slope[name]) + m[name]
                for line, m in zip(self.axes, missed, strict=True)
            ]
            for name in COEFFICIENTS
        }
        return xr.Dataset({n: ("shape_dof", e) for n, e in errors.items()}, {"shape_dof": self.labels})

    @cached_property
    def derivatives(self) -> xr.Dataset:
        """Coefficients, `<name>_slope`, `<name>_curvature`, `<name>_slope_error`, with their units."""
        parts = {"": self.centre, "_slope": self.slopes, "_curvature": self.curvatures}
        named = {
            f"{name}{suffix}": ds[name].assign_attrs(units=unit)
            for name, units in COEFFICIENTS.items()
            for (suffix, ds), unit in zip(parts.items(), units, strict=True)
        }
        errors = {f"{name}_slope_error": e.assign_attrs(units="1") for name, e in self.slope_errors.items()}
        return xr.Dataset({**named, **errors})

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

    def interpolation_error(self, amplitude: float, *, samples: int = 8, seed: int = 0) -> xr.Dataset:
        """Return the largest errors of `expansion` against direct solution, as of `misfit`, shape (order,) [-].

        Of `samples` deformations in random directions, the same for every `amplitude`, their root-sum-square [m];
        `ConfigError` if it is not positive.
        """
        if not amplitude > 0:
            raise ConfigError(f"amplitude: received {amplitude:g} m; needs a positive size of the deformation")
        vectors = np.random.default_rng(seed).standard_normal((samples, len(self.labels)))
        errors = np.zeros((len(COEFFICIENTS), 2))
        for q in amplitude * vectors / np.linalg.norm(vectors, axis=1, keepdims=True):
            direct, models = self.at(q), [self.expansion(q, order) for order in (1, 2)]
            errors = np.maximum(errors, [[misfit(m[name], direct[name]) for m in models] for name in COEFFICIENTS])
        return xr.Dataset({n: ("order", e) for n, e in zip(COEFFICIENTS, errors, strict=True)}, {"order": [1, 2]})
