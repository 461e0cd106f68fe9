"""Coefficients over a band from few frequencies: errors, limits, noise; points and frequencies as tolerances need."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.hydro import dofs
from vsb.engine.hydro.spectral.solver import SpectralProblem, converged, converged_on_grid, incident_wave, resolved
from vsb.engine.hydro.sweep import FORCES, interpolants, on_grid, selected
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
    with pytest.raises(ConvergenceError, match=r"hydro.tolerance: received 1e-20, the spectral solver reaches .* 128"):
        resolved(problem(64), OMEGA[:1], 1e-20, 128)


BAND = np.linspace(0.1, 12.0, 400)
ONE = np.ones_like(BAND)


def resonances(omega, poles, residues, constant):
    """Real rational functions of -i omega with given poles below the real axis, one column per row of residues."""
    return (
        (1 / (omega[:, None] - poles)) @ residues.T
        - (1 / (omega[:, None] + poles.conj())) @ residues.conj().T
        + constant
    )


def body(count, columns, seed):
    """Poles, residues and limits of functions with a few resonances, as of floating bodies."""
    rng = np.random.default_rng(seed)
    poles = np.linspace(0.8, 8.0, count) + rng.uniform(-0.3, 0.3, count) - 1j * rng.uniform(0.5, 2.0, count)
    residues = rng.normal(size=(columns, count)) + 1j * rng.normal(size=(columns, count))
    return poles, residues, rng.normal(size=columns)


def samples(count):
    """Frequencies crowded to both ends of the band."""
    return 0.1 + 11.9 * (1 - np.cos(np.linspace(0.0, np.pi, count))) / 2


def slow(omega):
    """What deep water does at frequency zero: K log K."""
    s = -1j * omega
    return (s**2 * np.log(s) / (1 + s) ** 3)[:, None]


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("columns", [1, 3, 20])
def test_a_rational_function_is_recovered_with_its_poles_and_limit(count, columns):
    """From as few samples as have as many equations as weights: one more support point than pairs of poles."""
    poles, residues, limit = body(count, columns, count)
    omega = samples(max(4, count + 1 + math.ceil((2 * count + 1) / (2 * columns))))
    found = interpolants(omega, resonances(omega, poles, residues, limit), np.ones(len(omega)))[count]
    exact = resonances(BAND, poles, residues, limit)
    assert np.abs(found(BAND) - exact).max() < 1e-9 * np.abs(exact).max()
    right = np.sort_complex(found.poles[found.poles.real > 0.0])
    there = [right[np.abs(right - p).argmin()] for p in poles]
    np.testing.assert_allclose(there, poles, rtol=1e-6)
    np.testing.assert_allclose(found.at_infinity, limit, atol=1e-6 * np.abs(exact).max())


@given(st.integers(0, 10_000))
@settings(max_examples=25)
def test_interpolants_are_real_functions_of_time_and_exact_at_the_support(seed):
    rng = np.random.default_rng(seed)
    omega = np.sort(rng.uniform(0.1, 12.0, 6))
    values = rng.normal(size=(6, 3)) + 1j * rng.normal(size=(6, 3))
    for found in interpolants(omega, values, np.ones(6)):
        np.testing.assert_allclose(found(found.support), found.values, rtol=1e-14)
        mirrored = found(-BAND)
        np.testing.assert_allclose(mirrored, found(BAND).conj(), rtol=1e-9, atol=1e-9 * np.abs(mirrored).max())
        assert np.abs(found(np.zeros(1)).imag).max() <= 1e-12 * np.abs(found(np.zeros(1))).max()


def test_convergence_is_root_exponential_at_a_branch_point():
    counts = np.array([8, 12, 16, 24])
    found = [selected(samples(n), slow(samples(n)), np.ones(n), BAND, ONE) for n in counts]
    errors = [float(np.abs(f.rational(BAND) - slow(BAND)).max()) for f in found]
    slopes = np.diff(np.log(errors)) / np.diff(np.sqrt(counts))
    assert errors[-1] < 1e-6
    assert np.all(slopes < -2.0), (errors, slopes)
    assert np.all(slopes > -20.0), (errors, slopes)


@pytest.mark.parametrize(("depth", "hidden"), [(1e-3, True), (1e-2, True), (0.2, False), (1.0, False)])
def test_pole_between_grid_and_axis_is_found(depth, hidden):
    omega = samples(6)
    poles, residues = np.array([2.015 - depth * 1j]), np.full((2, 1), 1e-3 + 0j)
    values = resonances(omega, poles, residues, np.array([1.0, 2.0]))
    found = interpolants(omega, values, np.ones(6))[1]
    assert found.spurious(BAND) is hidden
    assert not found.spurious(BAND[BAND > 3.0])  # beside the grid
    result = selected(omega, values, np.ones(6), BAND, ONE)
    assert not (np.isfinite(result.error) and result.rational.spurious(BAND))


def test_too_few_samples_are_refused():
    with pytest.raises(ConvergenceError, match=r"omega: received 3 samples, rational interpolation needs 4; solve"):
        selected(samples(3), slow(samples(3)), np.ones(3), BAND, ONE)
