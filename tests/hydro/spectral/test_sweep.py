"""The spectral solver over a band: points and frequencies enough for the tolerance, and no more."""

import numpy as np
import pytest
from hydro.test_sweep import GRID, buoy, largest_error

from vsb.errors import ConvergenceError
from vsb.hydro import dofs
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.spectral.sweep import (
    converged,
    converged_on_grid,
    resolved,
)
from vsb.shell.deformed import rigid_sphere

OMEGA = [0.5, 1.5, 3.0]


def problem(nodes=8):
    return SpectralProblem(
        rigid_sphere(1.0, 0.0), dofs.displacements(["Radial0", "Radial1", "Radial4"]), 1.0, 1.0, nodes
    )


@pytest.mark.parametrize("tolerance", [1e-1, 1e-4, 1e-8])
def test_estimate_and_error_are_below_the_tolerance(tolerance):
    found = converged(problem(), OMEGA, tolerance)
    assert found.attrs["error_estimate"] <= tolerance
    assert found.attrs["solves"] == found.attrs["frequencies"] == len(OMEGA)
    exact = problem(64).solve(OMEGA)
    for name in ("added_mass", "radiation_damping"):
        largest = np.abs(exact[name]).max(dim=("influenced_dof", "radiating_dof"))
        assert float((np.abs(found[name] - exact[name]) / largest).max()) <= tolerance
    assert found.added_mass_inf.shape == (3, 3)


@pytest.mark.parametrize(("depth", "order", "names"), [(np.inf, 0, 2), (5.0, 0, 1), (5.0, 1, 2)])
def test_limits_are_solved_where_they_exist(depth, order, names):
    displacements = dofs.displacements(("Surge",) if order else ("Radial0", "Radial1"), order)
    solver = SpectralProblem(rigid_sphere(1.0, 0.0), displacements, 1.0, 1.0, 16, depth)
    for found in (converged(solver, OMEGA, 1e-3), converged_on_grid(solver, GRID[:60], 1e-3, 5e-4)):
        limits = {name: found[name] for name in ("added_mass_inf", "added_mass_zero") if name in found}
        assert len(limits) == names
        assert found.added_mass_inf.values == pytest.approx(solver.at_infinity(), rel=1e-3)
        if "added_mass_zero" in limits:
            assert found.added_mass_zero.values == pytest.approx(solver.at_zero(), rel=1e-3)
    assert found.attrs["limit_difference"] < 0.01


@pytest.mark.parametrize(("tolerance", "step", "solves"), [(1e-2, 0.1, 15), (1e-3, 0.1, 17), (1e-4, 0.05, 20)])
def test_points_and_solves_both_follow_from_the_tolerance(tolerance, step, solves):
    grid = list(np.arange(1, round(12.8 / step) + 1) * step)
    found = converged_on_grid(buoy(nodes=8), grid, tolerance, tolerance / 2)
    told = found.attrs
    assert told["error_estimate"] <= tolerance
    assert told["interpolation_error"] <= tolerance
    assert told["limit_difference"] <= 1e-3
    assert told["solves"] <= solves
    assert told["frequencies"] == len(grid) == found.sizes["omega"]
    assert largest_error(found, buoy(nodes=32).solve(grid)) <= told["error_estimate"] + told["interpolation_error"]


def test_a_tolerance_out_of_reach_is_said():
    with pytest.raises(ConvergenceError, match=r"hydro.tolerance: received 1e-20, the spectral solver reaches .* 128"):
        resolved(problem(64), OMEGA, 1e-20)
