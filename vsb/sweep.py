"""Hydrodynamic coefficients over a band of frequencies, as finely resolved as a tolerance asks."""

from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.errors import ConvergenceError
from vsb.spectral import SpectralProblem

FEWEST_NODES = 16
MOST_NODES = 128


def converged(problem: SpectralProblem, omegas: list[float], tolerance: float) -> tuple[xr.Dataset, float]:
    """Return coefficients at these frequencies and at infinity, and their estimated error, below a tolerance.

    The points are doubled, from those of the problem, until the run's own estimate is below the tolerance.

    Raises
    ------
    ConvergenceError
        If `MOST_NODES` points do not reach the tolerance.
    """
    while problem.nodes <= MOST_NODES:
        error = float(max(problem.error_estimate(omegas).max().values()))
        if error <= tolerance:
            pair = ("influenced_dof", "radiating_dof")
            return problem.solve(omegas).assign(added_mass_inf=(pair, problem.at_infinity())), error
        problem = replace(problem, nodes=2 * problem.nodes)
    raise ConvergenceError(
        f"hydro.tolerance: received {tolerance:g}, the spectral solver reaches {error:.1e} with {MOST_NODES} points; "
        "raise it, lower hydro.omega_max, or set hydro.solver: panels"
    )


def interpolation_error(problem: SpectralProblem, solved: xr.Dataset) -> float:
    """Return how far cubic splines through solved coefficients are off half-way between their frequencies [-].

    Added mass, damping and excitation, each relative to its largest entry of the band; by solving there.
    """
    omega = solved.omega.values
    between = (omega[1:] + omega[:-1]) / 2
    exact = problem.solve(list(between))
    errors = []
    for name in ("added_mass", "radiation_damping", "Froude_Krylov_force", "diffraction_force"):
        missed = CubicSpline(omega, solved[name].values)(between) - exact[name].values
        errors.append(np.abs(missed).max() / np.abs(exact[name].values).max())
    return float(max(errors))
