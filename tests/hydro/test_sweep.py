"""Coefficients over a band from few frequencies: errors, limits, noise; points and frequencies as tolerances need."""

from pathlib import Path

import numpy as np
import pytest

from vsb.engine.hydro import dofs
from vsb.engine.hydro.spectral.solver import SpectralProblem, converged, converged_on_grid, incident_wave, resolved
from vsb.engine.hydro.sweep import FORCES, on_grid
from vsb.engine.shell.deformed import rigid_sphere
from vsb.errors import ConvergenceError
from vsb.models.rest import reference_shell
from vsb.study import study as config

HERE = Path(__file__).parents[1]
GRID = [round(0.1 * i, 10) for i in range(1, 129)]
BETWEEN = np.linspace(GRID[0], GRID[-1], 300)
LEGENDRE = tuple(f"Radial{n}" for n in range(7))


def buoy(height=0.0, displacements=LEGENDRE, nodes=32, order=0):
    """The seed's sphere in water."""
    return SpectralProblem(rigid_sphere(2.0, height), dofs.displacements(displacements, order), 1025.0, 9.81, nodes)


def pressurised():
    """The shell of the pressurised study at equilibrium, strained by 14 %."""
    shape = reference_shell(config.load(HERE.parent / "config" / "pressurised.yaml")).shape
    return SpectralProblem(
        shape, dofs.displacements([*LEGENDRE, *(f"Meridional{n}" for n in range(1, 7))]), 1025.0, 9.81, 32
    )


def largest_error(found, exact):
    """Of added mass, damping and excitation, each relative to the band's largest entry."""
    pairs = [(found[name].values, exact[name].values) for name in ("added_mass", "radiation_damping")]
    pairs.append(tuple(sum(ds[name].values for name in FORCES) for ds in (found, exact)))
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)


def swept(solver, tolerance, grid=GRID):
    found = on_grid(solver.solve, grid, tolerance, incident_wave(solver)).sweep
    assert found
    return found


@pytest.fixture(scope="module")
def cases():
    """Problems by name with their coefficients between the grid."""
    solvers = {"hemisphere": buoy(), "heave": buoy(displacements=("Radial1",)), "high": buoy(0.6), "low": buoy(-0.8)}
    solvers |= {"surge": buoy(displacements=("Surge", "Pitch"), order=1), "oblate": pressurised()}
    return {name: (solver, solver.solve(list(BETWEEN))) for name, solver in solvers.items()}


NAMES = ("heave", "low", "surge", "oblate")


@pytest.mark.parametrize(("tolerance", "solves"), [(1e-3, 17), (1e-5, 23)])
@pytest.mark.parametrize("name", NAMES)
def test_the_estimate_bounds_the_error_and_few_solves_reach_the_tolerance(cases, name, tolerance, solves):
    solver, exact = cases[name]
    found = swept(solver, tolerance)
    assert found.solved.sizes["omega"] <= solves
    assert found.error <= tolerance
    assert largest_error(found.at(BETWEEN), exact) <= found.error


@pytest.mark.parametrize("name", NAMES)
def test_limits_at_zero_and_infinity_are_those_solved_there(cases, name):
    """Neither is a sample, infinity is far outside the band; K log K makes zero the harder one."""
    solver, _ = cases[name]
    tolerance = 1e-4  # within it the distance changes a hundredfold with the round-off of the samples
    found = swept(solver, tolerance)
    for ours, theirs, bound in (
        (found.at_infinity, solver.at_infinity(), tolerance),
        (found.at_zero, solver.at_zero(), 3 * tolerance),
    ):
        assert np.abs(ours - theirs).max() <= bound * np.abs(theirs).max()


class Noisy:
    """A solver with an error that is not smooth, as a lid or a series of the Green function leaves."""

    def __init__(self, solver, size):
        self.solver, self.size, self.calls = solver, size, []

    def __call__(self, omegas):
        self.calls += omegas
        ds = self.solver.solve(list(omegas))
        rough = np.sin(1e4 * ds.omega)  # of each frequency its own, the same every time
        return ds.map(lambda a: a + self.size * rough * float(np.abs(a).max()) if "omega" in a.dims else a)


def test_noise_is_not_interpolated(cases):
    solver, exact = cases["heave"]
    incident = incident_wave(solver)
    assert on_grid(Noisy(solver, 3e-3), GRID, 1e-4, incident).sweep is None
    quiet = on_grid(Noisy(solver, 1e-5), GRID, 1e-3, incident).sweep
    assert quiet.solved.sizes["omega"] <= 17
    assert largest_error(quiet.at(BETWEEN), exact) <= quiet.error <= 1e-3


@pytest.mark.parametrize("count", [1, 13, 64])
def test_rough_coefficients_are_all_solved_once(cases, count):
    solver, _ = cases["heave"]
    noisy, grid = Noisy(solver, 3e-3), GRID[:count]
    found = on_grid(noisy, grid, 1e-4, incident_wave(solver))
    assert found.sweep is None
    assert sorted(noisy.calls) == found.solved == list(found.coefficients.omega.values) == grid
    assert largest_error(found.coefficients, solver.solve(grid)) < 1e-2
    assert (found.spline_error(solver.solve) > 1e-4) is (count > 1)


OMEGA = [0.5, 1.5, 3.0]


def problem(nodes=8):
    return SpectralProblem(
        rigid_sphere(1.0, 0.0), dofs.displacements(["Radial0", "Radial1", "Radial4"]), 1.0, 1.0, nodes
    )


@pytest.mark.parametrize("tolerance", [1e-1, 1e-6])
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


@pytest.mark.parametrize(("tolerance", "step", "solves"), [(1e-2, 0.1, 15), (1e-3, 0.1, 17)])
def test_points_and_solves_both_follow_from_the_tolerance(tolerance, step, solves):
    grid = list(np.arange(1, round(12.8 / step) + 1) * step)
    found = converged_on_grid(buoy(nodes=8), grid, tolerance, tolerance / 2)
    attrs = found.attrs
    assert attrs["error_estimate"] <= tolerance
    assert attrs["interpolation_error"] <= tolerance
    assert attrs["limit_difference"] <= 1e-3
    assert attrs["solves"] <= solves
    assert attrs["frequencies"] == len(grid) == found.sizes["omega"]
    assert largest_error(found, buoy(nodes=32).solve(grid)) <= attrs["error_estimate"] + attrs["interpolation_error"]


def test_unreachable_tolerance_is_refused():
    with pytest.raises(ConvergenceError, match=r"hydro.tolerance: received 1e-20, the spectral solver reaches .* 256"):
        resolved(problem(64), OMEGA, 1e-20)
