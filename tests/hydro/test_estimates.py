"""Every summand of an error estimate has a case in which it alone tells of the error."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from vsb.hydro import dofs, sweep
from vsb.hydro.panels import rings
from vsb.hydro.panels import sweep as panels
from vsb.hydro.panels.mesh import deformed_mesh
from vsb.hydro.panels.sweep import TwoMeshes
from vsb.hydro.spectral import sweep as spectral_sweep
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.sweep import FORCES, IncidentWave, apart
from vsb.shell.deformed import rigid_sphere

GRID = [round(0.1 * i, 10) for i in range(1, 65)]
STILL = IncidentWave(lambda omega: 0 * omega, lambda omega: np.zeros((len(omega), 1, 1), dtype=complex), 0)


def heave(nodes=16):
    return SpectralProblem(rigid_sphere(2.0, 0.0), dofs.displacements(["Radial1"]), 1025.0, 9.81, nodes)


class Bump:
    """Smooth coefficients with one frequency that stands out of them, as an irregular one does."""

    def __init__(self, at, height):
        self.at, self.height, self.calls = at, height, []

    def __call__(self, omegas):
        self.calls += omegas
        omega = np.asarray(omegas)
        added = 1 / (1 + omega**2) + self.height * (np.abs(omega - self.at) < 0.05)
        pair, wave = ("influenced_dof", "radiating_dof"), ("wave_direction", "influenced_dof")
        values = {"added_mass": (("omega", *pair), added[:, None, None])}
        values["radiation_damping"] = (("omega", *pair), (omega**2 / (1 + omega**2))[:, None, None])
        values |= {name: (("omega", *wave), np.ones((len(omega), 1, 1), dtype=complex)) for name in FORCES}
        return xr.Dataset(values, {"omega": omega})


# the sweep -----------------------------------------------------------------------------------------------------------


def blind(monkeypatch, chosen, errors):
    """Let interpolants doubt one frequency after the other of a list, and be as sure of themselves as told."""
    real, left, told = sweep.settled, list(chosen), list(errors)

    def settled(omega, values, scale, grid, grid_scale):
        doubt = np.zeros(len(grid))
        doubt[[grid.tolist().index(w) for w in left if w not in omega][:1]] = 1.0
        return real(omega, values, scale, grid, grid_scale)._replace(doubt=doubt, error=told.pop(0) if told else 0.0)

    monkeypatch.setattr(sweep, "settled", settled)


def test_only_the_surprise_tells_of_what_was_met_at_the_frequency_solved_last(monkeypatch):
    """Interpolants before and after are sure of themselves; that they were off at 3.3 rad/s remains."""
    blind(monkeypatch, [3.3], [])
    solve = Bump(3.3, 0.2)
    found = sweep._sampled(solve, GRID, 1e-3, STILL, (), most=9)
    assert 3.3 in solve.calls
    assert found.error > 0.15
    blind(monkeypatch, [3.3], [])
    assert sweep._sampled(Bump(3.3, 0.0), GRID, 1e-3, STILL, (), most=9).error < 1e-3


def test_interpolants_must_agree_twice_in_a_row(monkeypatch):
    """The first sure of themselves after unsure ones are not believed yet."""
    blind(monkeypatch, [1.1, 2.3, 3.3, 4.7], [0.5, 0.5, 0.0, 0.0])
    once = Bump(3.3, 0.0)
    sweep.on_grid(once, GRID, 1e-3, STILL)
    blind(monkeypatch, [1.1, 2.3, 3.3, 4.7], [0.0, 0.0, 0.0, 0.0])
    sure = Bump(3.3, 0.0)
    sweep.on_grid(sure, GRID, 1e-3, STILL)
    assert len(once.calls) > len(sure.calls)


@pytest.mark.parametrize(("count", "most"), [(90, 40), (60, 30)])
def test_what_is_too_rough_is_solved_at_forty_frequencies_or_half_of_them_before_it_is_given_up(count, most):
    grid = [round(6.4 * i / count, 10) for i in range(1, count + 1)]
    rough = Bump(3.3, 0.0)

    def solve(omegas):
        found = rough(omegas)
        return found.map(lambda a: a + 0.01 * np.sin(1e4 * found.omega) if "radiating_dof" in a.dims else a)

    assert most - 2 < sweep._sampled(solve, grid, 1e-6, STILL, ()).solves <= most


# the spectral solver on a grid ---------------------------------------------------------------------------------------


def errors_on(found, grid):
    exact = heave(32).solve(grid)
    return max(apart(found[n].values, exact[n].values) / apart(exact[n].values, 0) for n in ("added_mass", *FORCES))


def test_only_the_splines_tell_of_a_grid_too_coarse():
    grid = [round(0.2 * i, 10) for i in range(1, 49)]
    found = spectral_sweep.converged_on_grid(heave(), grid, 1e-3, 1e-6)
    assert found.attrs["solves"] < len(grid)
    told = found.attrs["interpolation_error"]
    missed = sweep.GridSweep(found, None).spline_error(heave().solve)
    assert missed > 100 * errors_on(found, grid)
    assert missed <= told <= 1.5 * missed


def test_only_the_sweep_tells_of_what_it_missed_on_the_grid():
    grid = [round(0.025 * i, 10) for i in range(1, 257)]
    found = spectral_sweep.converged_on_grid(heave(), grid, 1e-3, 0.05)
    splines = sweep.GridSweep(heave().solve(grid), None).spline_error(heave().solve)
    error = errors_on(found, grid)
    assert error > 3 * splines
    assert error <= found.attrs["interpolation_error"] <= 0.05 + splines


@pytest.mark.parametrize("limit", ["at_infinity", "at_zero"])
def test_either_limit_alone_is_compared_with_the_sweeps(monkeypatch, limit):
    problem = heave()
    true = spectral_sweep.converged_on_grid(problem, GRID, 1e-3, 5e-4).attrs["limit_difference"]
    exact = getattr(SpectralProblem, limit)
    monkeypatch.setattr(SpectralProblem, limit, lambda self: 1.05 * exact(self))
    wrong = spectral_sweep.converged_on_grid(problem, GRID, 1e-3, 5e-4).attrs["limit_difference"]
    assert true < 2e-3
    assert wrong == pytest.approx(0.05 / 1.05, abs=3e-3)


# panels --------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def green(green_folder):
    return rings.green_function(green_folder)


def rows_of(green, rows):
    mesh = deformed_mesh(rigid_sphere(2.0, 0.0), rows, 2 * rows, max(4, rows // 2))
    return rings.AxisymmetricProblem(green, mesh, dofs.displacements(["Radial0", "Radial1"]), 1025.0, np.inf, 9.81)


def test_interpolation_adds_to_the_error_of_the_meshes(green, monkeypatch):
    """Whatever a sweep says it missed is part of what panels say they miss."""
    two, real = TwoMeshes(rows_of(green, 16), rows_of(green, 8)), panels.on_grid

    def rough(*args):
        found = real(*args)
        return replace(found, sweep=replace(found.sweep, error=0.25))

    sure = two.solve(GRID[:32], 5e-4).attrs["error_estimate"]
    monkeypatch.setattr(panels, "on_grid", rough)
    assert two.solve(GRID[:32], 5e-4).attrs["error_estimate"] == pytest.approx(sure + 0.25, abs=5e-4)


DOUBTS = {  # of a mesh, a variable and entries: what an error of 0.3 of its largest adds to
    "asymmetry": ("both", "added_mass", (0, 0, 1)),
    "Haskind's damping": ("both", "radiation_damping", (0, 0, 0)),
    "added mass of fewer panels": ("coarse", "added_mass", (0, 1, 1)),
    "damping of fewer panels": ("coarse", "radiation_damping", (0, 1, 1)),
    "excitation of fewer panels": ("coarse", "diffraction_force", (0, 0, 1)),
}


@pytest.mark.parametrize("doubt", DOUBTS)
def test_each_doubt_of_panels_is_in_terms_of_the_largest_of_its_own(green, doubt):
    fine = rows_of(green, 10)
    solved = fine.solve([1.5])
    sizes = dict(zip(("added_mass", "radiation_damping", "diffraction_force"), sweep.largest(solved), strict=True))
    mesh, name, entry = DOUBTS[doubt]
    wrong = solved.copy(deep=True)
    wrong[name].values[entry] -= 0.3 * sizes[name]

    def told(one, other):
        return TwoMeshes(fine, SimpleNamespace(solve=lambda omega: other)).error_estimate(one, solved)

    sound = told(solved, solved)
    assert sound < 0.03
    assert told(solved if mesh == "coarse" else wrong, wrong) == pytest.approx(0.3, abs=1.01 * sound)


def test_at_infinity_each_of_two_meshes_and_asymmetry_tells_by_itself(green):
    fine, coarse = rows_of(green, 16), rows_of(green, 8)
    a, half = fine.at_infinity(), coarse.at_infinity()
    skew, change = apart(a, a.T) / np.abs(a).max(), apart(a, half) / np.abs(a).max()
    assert TwoMeshes(fine, fine).at_infinity().attrs["error_estimate"] == pytest.approx(skew, rel=1e-9)
    symmetric = SimpleNamespace(at_infinity=lambda: (a + a.T) / 2, displacements=fine.displacements)
    halved = SimpleNamespace(at_infinity=lambda: (half + half.T) / 2, displacements=fine.displacements)
    told = TwoMeshes(symmetric, halved).at_infinity().attrs["error_estimate"]
    assert skew > 0
    assert told == pytest.approx(change, rel=0.2)
