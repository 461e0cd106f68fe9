"""Coefficients of the spectral solver over a band, from as few points and as few solves as tolerances need."""

from dataclasses import replace

import numpy as np
import xarray as xr

from vsb.errors import ConvergenceError
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.sweep import AdaptiveSweep, IncidentWave, crowded, on_grid, relative
from vsb.hydro.variables import PAIR
from vsb.tools.arrays import ComplexArray, FloatArray

FEWEST_NODES = 16
MOST_NODES = 128


def incident_wave(problem: SpectralProblem) -> IncidentWave:
    """Return what is known of the excitation of a problem without solving."""
    m = problem.meridian
    radius = float(m.shell.meridian(np.array([m.waterline])).x[0])

    def froude_krylov(omega: FloatArray) -> ComplexArray:
        incident = problem.incident(problem.wavenumbers(list(omega)))[:, : m.nodes]
        return np.asarray(problem.gravity * (incident @ problem.onto.T)[:, None])

    return IncidentWave(lambda omega: radius * problem.wavenumbers(list(omega)), froude_krylov, problem.order)


def _error(problem: SpectralProblem, omegas: list[float]) -> float:
    """Largest error a problem estimates of its own added mass, damping and excitation at frequencies."""
    return float(max(problem.error_estimate(omegas).max().values()))


def _limits(problem: SpectralProblem) -> dict[str, xr.Variable]:
    """Added mass at infinite frequency and, where it has a limit, at zero."""
    limits = {"added_mass_inf": xr.Variable(PAIR, problem.at_infinity())}
    if np.isfinite(problem.depth) and not problem.order:
        return limits  # log K
    return limits | {"added_mass_zero": xr.Variable(PAIR, problem.at_zero())}


def _limit_difference(swept: AdaptiveSweep, limits: dict[str, xr.Variable]) -> float:
    """Largest relative difference of added mass extrapolated to its limits from that solved there."""
    if not swept.radiation.values.any():
        return 0.0  # motions that move no water
    far = {"added_mass_inf": swept.at_infinity, "added_mass_zero": swept.at_zero}
    return max(relative(far[name] - limit.values, limit.values) for name, limit in limits.items())


def resolved(problem: SpectralProblem, omegas: list[float], tolerance: float) -> tuple[SpectralProblem, float]:
    """Return the problem with as many points as frequencies need, doubled again and again, and its estimated error.

    Raises
    ------
    ConvergenceError
        If `MOST_NODES` points do not reach the tolerance.
    """
    while problem.nodes <= MOST_NODES:
        error = _error(problem, omegas)
        if error <= tolerance:
            return problem, error
        problem = replace(problem, nodes=2 * problem.nodes)
    raise ConvergenceError(
        f"hydro.tolerance: received {tolerance:g}, the spectral solver reaches {error:.1e} with {MOST_NODES} points; "
        "raise it, lower hydro.omega_max, or set hydro.solver: panels"
    )


def converged(problem: SpectralProblem, omegas: list[float], tolerance: float) -> xr.Dataset:
    """Return coefficients solved at these frequencies and at infinity, from as few points as a tolerance needs.

    Parameters and attributes as of `converged_on_grid`.

    Raises
    ------
    ConvergenceError
        As of `resolved`.
    """
    problem, error = resolved(problem, omegas, tolerance)
    ds = problem.solve(omegas).assign(_limits(problem))
    return ds.assign_attrs(error_estimate=error, solves=len(omegas), frequencies=len(omegas))


def converged_on_grid(
    problem: SpectralProblem, frequencies: list[float], tolerance: float, interpolation: float
) -> xr.Dataset:
    """Return coefficients on a grid of frequencies and at infinity, from as few points and solves as tolerances need.

    Parameters
    ----------
    problem : SpectralProblem
        With the fewest points.
    frequencies : list of float [rad/s]
        Ascending.
    tolerance, interpolation : float [-]
        Of the boundary elements' error at the frequencies solved, and of interpolation between them.

    Returns
    -------
    xarray.Dataset
        With the attributes `error_estimate`, of the boundary elements; `interpolation_error`, of the sweep and of cubic
        splines through these frequencies; `limit_difference` of added mass extrapolated by the sweep to infinite
        frequency, and in deep water to zero, from that solved there, relative to its largest entry; `solves` and
        `frequencies`, their numbers.

    Raises
    ------
    ConvergenceError
        As of `resolved`.
    """
    omegas, error = [frequencies[i] for i in crowded(len(frequencies))], np.inf
    while error > tolerance:
        problem, _ = resolved(problem, omegas, tolerance)
        found = on_grid(problem.solve, frequencies, interpolation, incident_wave(problem))
        omegas, error = found.solved, _error(problem, found.solved)
    limits = _limits(problem)
    attrs: dict[str, float] = {"error_estimate": error, "solves": len(omegas), "frequencies": len(frequencies)}
    if found.sweep:
        attrs["interpolation_error"] = found.sweep.error + found.spline_error(found.sweep.at)
        attrs["limit_difference"] = _limit_difference(found.sweep, limits)
    else:
        attrs["interpolation_error"] = found.spline_error(problem.solve)
    return found.coefficients.assign(limits).assign_attrs(attrs)
