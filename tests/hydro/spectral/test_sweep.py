"""The spectral solver over a band: points and frequencies enough for the tolerance, and no more."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hydro.test_sweep import GRID, buoy, largest_error

from vsb.errors import ConvergenceError
from vsb.hydro import dofs
from vsb.hydro.spectral import sweep
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.spectral.sweep import (
    MOST_NODES,
    _limit_difference,
    converged,
    converged_on_grid,
    incident_wave,
    resolved,
)
from vsb.shell.deformed import rigid_sphere
from vsb.waves.dispersion import wavenumber

OMEGA = [0.5, 1.5, 3.0]


def problem(nodes=8):
    return SpectralProblem(
        rigid_sphere(1.0, 0.0), dofs.displacements(["Radial0", "Radial1", "Radial4"]), 1.0, 1.0, nodes
    )


@dataclass(frozen=True)
class Halving:
    """A problem whose errors are halved where its points are doubled, that of damping the largest."""

    nodes: int
    asked: list[int] = field(default_factory=list, compare=False)

    def error_estimate(self, omegas):
        assert self.nodes not in self.asked  # the same problem once more
        self.asked.append(self.nodes)
        errors = {"added_mass": 0.5, "radiation_damping": 2.0, "excitation_force": 1.0}
        return xr.Dataset({name: ("omega", np.full(len(omegas), e / self.nodes)) for name, e in errors.items()})


def test_points_are_doubled_until_the_largest_error_is_within_the_tolerance():
    assert resolved(Halving(16), OMEGA, 0.126) == (Halving(16), 0.125)
    assert resolved(Halving(16), OMEGA, 0.124) == (Halving(32), 0.0625)
    assert resolved(Halving(16), OMEGA, 1 / 64) == (Halving(MOST_NODES), 1 / 64)
    with pytest.raises(ConvergenceError, match=r"received 0.015, the spectral solver reaches 1.6e-02 with 128 points"):
        resolved(Halving(16), OMEGA, 0.015)


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


def test_a_short_band_is_solved_and_its_splines_checked_by_solving():
    grid = [0.5, 0.6, 0.7, 0.8, 0.9]
    found = converged_on_grid(buoy(nodes=16), grid, 1e-3, 5e-4)
    assert found.attrs["solves"] == found.attrs["frequencies"] == 5
    assert 0 < found.attrs["interpolation_error"] < 1e-3
    xr.testing.assert_allclose(found.added_mass, buoy(nodes=16).solve(grid).added_mass)


def test_a_tolerance_out_of_reach_is_said():
    with pytest.raises(ConvergenceError, match=r"hydro.tolerance: received 1e-20, the spectral solver reaches .* 128"):
        resolved(problem(64), OMEGA, 1e-20)


@pytest.mark.parametrize("still", [0, 1])
def test_a_motion_that_moves_no_water_hides_no_difference_at_the_limits(still):
    """Beside one that does; where none does there is none to tell."""
    moved = np.diag(np.arange(2.0) if still == 0 else np.arange(1.0, -1.0, -1.0))
    swept = SimpleNamespace(
        radiation=xr.DataArray(np.stack([moved, 2 * moved])), at_infinity=1.25 * moved, at_zero=0.9 * moved
    )
    limits = {name: xr.Variable(("a", "b"), moved) for name in ("added_mass_inf", "added_mass_zero")}
    assert _limit_difference(swept, limits) == pytest.approx(0.25)
    assert _limit_difference(swept, {"added_mass_zero": limits["added_mass_zero"]}) == pytest.approx(0.1)
    swept.radiation = 0 * swept.radiation
    assert _limit_difference(swept, limits) == 0.0


@pytest.mark.parametrize(("height", "depth", "order"), [(0.6, np.inf, 0), (-0.8, 5.0, 1)])
def test_the_phase_of_a_wave_is_to_the_waterline_in_water_of_its_depth(height, depth, order):
    shell, moved = rigid_sphere(2.0, height), dofs.displacements(("Surge",) if order else ("Heave",), order)
    found = incident_wave(SpectralProblem(shell, moved, 1.0, 4.0, 8, depth=depth))
    omega, radius = np.array([0.5, 2.0]), np.sqrt(4.0 - height**2)
    assert found.phase(omega) == pytest.approx([radius * wavenumber(w, depth, 4.0) for w in omega], rel=1e-9)
    assert found.order == order
    solved = SpectralProblem(shell, moved, 1.0, 4.0, 8, depth=depth).solve(omega.tolist()).Froude_Krylov_force
    assert found.froude_krylov(omega) == pytest.approx(solved.values, rel=1e-12)


def test_the_error_told_is_of_all_frequencies_solved(monkeypatch):
    """Those the sweep adds may need more points than those it began with."""
    asked = []

    def error(problem, omegas):
        asked.append((problem.nodes, len(omegas)))
        return 1e-4 if len(omegas) == asked[0][1] else 16e-3 / problem.nodes

    monkeypatch.setattr(sweep, "_error", error)
    found = converged_on_grid(buoy(nodes=8), list(np.arange(1, 129) * 0.1), 1e-3, 5e-4)
    assert found.attrs["error_estimate"] == 16e-3 / asked[-1][0] <= 1e-3
    assert asked[-1] == (16, found.attrs["solves"])
    assert found.attrs["solves"] > asked[0][1]


@pytest.mark.parametrize("swept", [True, False])
def test_what_is_told_of_a_grid_is_of_its_sweep_and_of_splines_through_it(monkeypatch, swept):
    """Errors of interpolation add up; splines are judged by the sweep, or by what is solved anew. All are passed on."""
    asked = []
    one = SimpleNamespace(solve="solves", nodes=16)
    splines = {"holds": 0.003, "solves": 0.004}
    adaptive = SimpleNamespace(error=0.02, at="holds") if swept else None
    found = SimpleNamespace(
        sweep=adaptive, solved=[1.0, 4.0, 2.0], spline_error=splines.get, coefficients=xr.Dataset({"x": 1.0})
    )
    monkeypatch.setattr(sweep, "resolved", lambda *given: asked.append(("resolved", *given)) or (one, 0.5))
    monkeypatch.setattr(sweep, "on_grid", lambda *given: asked.append(("on grid", *given)) or found)
    monkeypatch.setattr(sweep, "incident_wave", lambda problem: ("wave of", problem))
    monkeypatch.setattr(sweep, "_error", lambda problem, omegas: asked.append(("error", problem, omegas)) or 0.007)
    monkeypatch.setattr(sweep, "_limits", lambda problem: {"added_mass_inf": xr.Variable((), 3.0)})
    monkeypatch.setattr(sweep, "_limit_difference", lambda *given: asked.append(("limits", given[0])) or 0.09)
    grid = [float(i) for i in range(1, 21)]
    ds = converged_on_grid("first", grid, 0.01, 0.03)
    first = [grid[i] for i in sweep.crowded(20)]
    assert asked[:3] == [
        ("resolved", "first", first, 0.01), ("on grid", "solves", grid, 0.03, ("wave of", one)),
        ("error", one, [1.0, 4.0, 2.0]),
    ]  # fmt: skip
    assert asked[3:] == ([("limits", adaptive)] if swept else [])
    told = {"error_estimate": 0.007, "solves": 3, "frequencies": 20}
    told |= {"interpolation_error": pytest.approx(0.023), "limit_difference": 0.09} if swept else {
        "interpolation_error": 0.004}  # fmt: skip
    assert ds.attrs == told
    assert (float(ds.x), float(ds.added_mass_inf)) == (1.0, 3.0)
