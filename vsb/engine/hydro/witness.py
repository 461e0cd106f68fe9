"""Cross-check of two solvers on the mean and on deformed shapes: their differences against their estimated errors.

Panels and the spectral solver share nothing but the shape: neither Green's function nor surface nor equation. Each
solves every shape twice, once more coarsely. Differences and estimated errors are given by shape, frequency and
coefficient, relative to the coefficient's largest entry there. So are those of derivatives by a mode's amplitude, f':
the spectral solver's, from its family of shapes, against central differences of the panels' f,

    (f(h) - f(-h))/2h = f' + h^2 f'''/6 + O(h^4).

Heave and modes are motions of material points, so on every shape they are the same motions.
"""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.engine.hydro.database import Check, displacements_of, in_modes, with_excitation
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.shape_dependence import ShapeFamily
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.hydro.sweep import rows_of
from vsb.engine.hydro.variables import PAIR
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import ModeBasis
from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray

DEFORMATION = 0.05
"""Modal amplitude of the deformed shapes, in radii; halved until each crosses the water once, clear of the bottom."""
LEAST_DEFORMATION = 1e-3
NODES, FEWER_NODES = 24, 18
"""Points of the spectral solver, and of the coarser run: its error is 1e-5 or less on all shapes of twelve modes."""
COEFFICIENTS = ("added_mass", "radiation_damping", "excitation_force")
SOLVERS = {"panels": "panels", "spectral": "the spectral solver"}
"""The solvers and their names in explanations."""


class Waves(NamedTuple):
    """Water, and the frequencies that the solvers are compared at."""

    omegas: tuple[float, ...]  # [rad/s]
    density: float  # [kg/m^3]
    depth: float  # [m]
    gravity: float  # [m/s^2]


class Deformed(NamedTuple):
    """A shell deformed by an amplitude of one mode, or by nothing."""

    shell: DeformedShell
    mode: str = ""
    amplitude: float = 0.0  # [m]

    @property
    def name(self) -> str:
        """Name in files and tables: mean, <mode>_minus or <mode>_plus."""
        return f"{self.mode}_{'plus' if self.amplitude > 0 else 'minus'}" if self.mode else "mean"


def deformed_shapes(shell: DeformedShell, modes: Sequence[str], depth: float) -> list[Deformed]:
    """Return a shell at rest, and deformed by minus and plus the same amplitude of each mode.

    Raises `ConfigError` if some shape crosses the water more than once, or nearly touches the bottom, however little it
    is deformed.
    """
    lowest = (_keel(shell) + depth) / 2
    size = DEFORMATION * shell.basis.shell.radius
    while size >= LEAST_DEFORMATION * shell.basis.shell.radius:
        moved = []
        for mode, sign in product(modes, (-1, 1)):
            along = np.eye(len(shell.modal_amplitude))[shell.basis.labels.index(mode)]
            amplitudes = shell.modal_amplitude + sign * size * along
            moved.append(Deformed(replace(shell, modal_amplitude=amplitudes), mode, sign * size))
        wet = [each.shell.wet_segments for each in moved]
        floats_once = all(len(some) == 1 and some[0][0] > 0.0 and some[0][1] == np.pi for some in wet)
        if floats_once and all(_keel(each.shell) <= lowest for each in moved):
            return [Deformed(shell), *moved]
        size /= 2
    raise ConfigError(
        f"hydro.witness: received modes {', '.join(modes)}, one of which, however small, makes the shell cross the "
        "water more than once or touch the bottom; needs one waterline: change device.mass, or set hydro.witness: none"
    )


def _keel(shell: DeformedShell) -> float:
    """Depth of a shell's deepest point [m]."""
    return -float(shell.meridian(np.linspace(0.0, np.pi, 40 * (shell.basis.highest_degree + 1) + 1)).z.min())


class Versions(NamedTuple):
    """Coefficients of heave and modes by one solver, and versions that show their error."""

    fine: xr.Dataset
    coarse: xr.Dataset  # on half the rows, or from three quarters of the points
    implied: xr.Dataset  # the fine ones as implied by symmetry and Haskind's relation


class Runs(NamedTuple):
    """Coefficients of one shape by one solver, and the time it took [s]."""

    found: Versions
    seconds: float


def runs(solve: Callable[[], xr.Dataset], coarsely: Callable[[], xr.Dataset], basis: ModeBasis, waves: Waves) -> Runs:
    """Return the coefficients of heave and modes by a solver of displacements, from a run and a coarser one."""
    begun = clock.perf_counter()
    fine, coarse = (with_excitation(in_modes(run(), basis))[list(COEFFICIENTS)] for run in (solve, coarsely))
    damping = haskind_damping(fine, waves.depth, waves.density, waves.gravity)
    turned = fine.added_mass.values.swapaxes(1, 2)
    implied = fine.copy(data={**fine.data_vars, "added_mass": turned, "radiation_damping": damping})
    return Runs(Versions(fine, coarse, implied), clock.perf_counter() - begun)


def spectral_runs(shell: DeformedShell, basis: ModeBasis, waves: Waves) -> Runs:
    """Return the coefficients of a shape by the spectral solver."""
    fine, coarse = (
        SpectralProblem(shell, displacements_of(basis), waves.density, waves.gravity, nodes, depth=waves.depth)
        for nodes in (NODES, FEWER_NODES)
    )
    omegas = list(waves.omegas)
    return runs(lambda: fine.solve(omegas), lambda: coarse.solve(omegas), basis, waves)


def largest(rows: ComplexArray | FloatArray) -> FloatArray:
    """Return the largest entry at each frequency, shape (omega,); never quite zero."""
    return np.asarray(np.maximum(np.abs(rows).max(axis=1), np.finfo(float).tiny))


def differences(one: xr.Dataset, other: xr.Dataset, size: xr.Dataset) -> FloatArray:
    """Return the largest difference of each coefficient in terms of its largest entry, shape (omega, coefficient)."""
    return np.transpose(
        [largest(rows_of(one, n) - rows_of(other, n)) / largest(rows_of(size, n)) for n in COEFFICIENTS]
    )


def error_estimate(found: Versions, size: xr.Dataset, depth: float) -> FloatArray:
    """Return the estimated errors of a solver's finer run over all frequencies, shape (coefficient,) [-].

    The largest change of any coefficient by the coarser run, for a single one may happen not to change; plus the error
    common to both runs: asymmetry of added mass, and for damping and excitation the misfit of Haskind's relation. In
    finite depth, where the Green function itself is approximate, that misfit counts for added mass, too.
    """
    fine, coarse, implied = found
    asymmetry, haskind, _ = differences(fine, implied, size).max(axis=0)
    of_added_mass = asymmetry if np.isinf(depth) else max(asymmetry, haskind)
    return np.asarray(differences(fine, coarse, size).max() + np.array([of_added_mass, haskind, haskind]))


def compared(shapes: Sequence[Deformed], panels: Sequence[Runs], spectral: Sequence[Runs], waves: Waves) -> xr.Dataset:
    """Return the coefficients of every shape by both solvers, their differences, and the estimated errors of each.

    Returns
    -------
    xarray.Dataset
        `shape_<coefficient>` (solver, shape, omega, ...); `witness_difference` (shape, omega, coefficient) and
        `witness_estimate` (solver, shape, coefficient) [-]; `witness_seconds` (solver, shape) [s];
        `deformation_amplitude` (shape) [m].
    """
    by = dict(zip(SOLVERS, (panels, spectral), strict=True))
    solved = xr.concat([xr.concat([each.found.fine for each in by[solver]], "shape") for solver in SOLVERS], "solver")
    apart = [differences(p.found.fine, s.found.fine, s.found.fine) for p, s in zip(panels, spectral, strict=True)]
    estimates = [[error_estimate(r.found, r.found.fine, waves.depth) for r in by[s]] for s in SOLVERS]
    where, runs_of = ("shape", "omega", "coefficient"), ("solver", "shape")
    return solved.rename({name: f"shape_{name}" for name in COEFFICIENTS}).assign(
        witness_difference=(where, apart),
        witness_estimate=((*runs_of, "coefficient"), estimates),
        witness_seconds=(runs_of, [[each.seconds for each in by[s]] for s in SOLVERS]),
        deformation_amplitude=("shape", [each.amplitude for each in shapes]),
        solver=list(SOLVERS),
        shape=[each.name for each in shapes],
        coefficient=list(COEFFICIENTS),
    )


def derivatives(shapes: Sequence[Deformed], panels: Sequence[Runs], basis: ModeBasis, waves: Waves) -> xr.Dataset:
    """Return derivatives of the coefficients by every mode's amplitude, and the distance of the panels' from them.

    Returns
    -------
    xarray.Dataset
        `<coefficient>_slope` (shape_dof, omega, ...) of the spectral solver; `slope_difference` (shape_dof, omega,
        coefficient) from it of the panels' central differences less their known term of third order; `slope_estimate`
        (shape_dof, coefficient), `error_estimate` of these differences and about the next term, the square of that of
        third order; relative to the slope's largest entry [-]. Empty in finite depth, which the family does not treat.
    """
    if np.isfinite(waves.depth) or len(shapes) == 1:
        return xr.Dataset()
    family = ShapeFamily(shapes[0].shell, waves.omegas, waves.density, waves.gravity, NODES)
    dofs, unit = {dim: list(basis.labels) for dim in PAIR}, np.eye(len(family.labels))
    slopes, apart, expected = list[xr.Dataset](), list[FloatArray](), list[FloatArray]()
    for i in range(1, len(shapes), 2):
        (minus, plus), h = (each.found for each in panels[i : i + 2]), -shapes[i].amplitude
        line = family.along(unit[family.labels.index(shapes[i].mode)], levels=2)
        central = Versions(*((up - down) / (2 * h) for down, up in zip(minus, plus, strict=True)))
        slope, third = (ds[list(COEFFICIENTS)].sel(dofs) for ds in (line.slope, h**2 * line.cubic))
        fifth = float(differences(third, 0 * third, slope).max()) ** 2
        slopes.append(slope)
        apart.append(differences(central.fine - third, slope, slope))
        expected.append(error_estimate(central, slope, np.inf) + fifth)
    where = ("shape_dof", "omega", "coefficient")
    stacked: xr.Dataset = xr.concat(slopes, "shape_dof").rename({name: f"{name}_slope" for name in COEFFICIENTS})
    return stacked.assign(
        slope_difference=(where, apart),
        slope_estimate=(where[::2], expected),
        shape_dof=[each.mode for each in shapes[1::2]],
        coefficient=list(COEFFICIENTS),
    )


def witness_checks(ds: xr.Dataset) -> list[Check]:
    """Return checks that two solvers agree within both estimates, on all shapes and in derivatives by the shape."""
    errors = {words: ds.witness_estimate.sel(solver=solver) for solver, words in SOLVERS.items()}
    what = f"panels and spectral solver on {ds.sizes['shape']} shapes at {ds.sizes['omega']} frequencies"
    checks = [_agreement("witness", what, ds.witness_difference, errors)]
    if "slope_difference" in ds:
        what = f"derivatives by {ds.sizes['shape_dof']} modes, central differences of panels and the spectral solver's"
        checks.append(_agreement("witness_derivatives", what, ds.slope_difference, {"both": ds.slope_estimate}))
    return checks


def _agreement(name: str, what: str, apart: xr.DataArray, errors: dict[str, xr.DataArray]) -> Check:
    """Check of differences against estimated errors, a doubt beyond their sum."""
    share = apart / sum(errors.values())
    worst = share.isel({str(dim): int(i) for dim, i in share.argmax(...).items()})
    at = {str(dim): worst.coords[dim].item() for dim in share.dims}
    estimates = {who: float(e.sel({str(dim): at[str(dim)] for dim in e.dims})) for who, e in errors.items()}
    place = [str(at[dim]) for dim in ("shape", "shape_dof") if dim in at]
    text = (
        f"{what}: {float(apart.sel(at)):.1e} of the largest entry apart in "
        f"{', '.join([str(at['coefficient']).replace('_', ' '), *place])} at {at['omega']:.3g} rad/s, for estimated "
        "errors of " + " and ".join(f"{error:.1e} ({who})" for who, error in estimates.items())
    )
    return Check(name, float(worst), 1.0, "-", "ok" if float(worst) <= 1 else "doubt", text)


def database_checks(ds: xr.Dataset, database: xr.Dataset, error: float) -> list[Check]:
    """Return checks that a hydro database agrees with the other solver, on the mean shape within its band.

    Parameters
    ----------
    ds : xarray.Dataset
        As of `compared`.
    database : xarray.Dataset
        Its sweep, interpolated by splines as everywhere.
    error : float
        Estimated error of the database, relative to the band's largest entries [-].
    """
    first, last = database.omega.values[[0, -1]]
    omega = [w for w in ds.omega.values if first <= w <= last]
    if not omega:
        return []
    other = "panels" if database.attrs["solver"] == "spectral" else "spectral"
    judge = ds.sel(solver=other, shape="mean", omega=omega)
    theirs = judge.rename({f"shape_{name}": name for name in COEFFICIENTS})[list(COEFFICIENTS)]
    shared = (*PAIR, "wave_direction")  # one direction is all for what is axisymmetric
    whole = database[list(COEFFICIENTS)].sel({dim: ds[dim].values for dim in shared})
    splines = {name: CubicSpline(whole.omega, whole[name].values) for name in COEFFICIENTS}
    ours = theirs.assign({name: (theirs[name].dims, at(omega)) for name, at in splines.items()})
    sizes = np.transpose([np.abs(whole[n].values).max() / largest(rows_of(theirs, n)) for n in COEFFICIENTS])
    where = {"omega": omega, "coefficient": list(COEFFICIENTS)}
    apart, own = (xr.DataArray(a, where, tuple(where)) for a in (differences(ours, theirs, theirs), error * sizes))
    errors = {"the database": own, SOLVERS[other]: judge.witness_estimate}
    return [_agreement("witness_database", f"hydro database and {SOLVERS[other]} on the mean shape", apart, errors)]
