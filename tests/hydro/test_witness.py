"""Two solvers that share nothing but the shape, on a sphere and on what one of its modes makes of it."""

import numpy as np
import pytest

from vsb.engine.hydro import witness
from vsb.engine.hydro.database import displacements_of, in_modes, with_excitation
from vsb.engine.hydro.panels.mesh import deformed_mesh
from vsb.engine.hydro.panels.rings import witness_runs
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.hydro.witness import Waves, deformed_shapes
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import ModeBasis, shell_modes
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError
from vsb.tools.files import load, save

SHELL = Shell(2.0, 0.01, 1.0, 0.3, 1.0)
BASIS = ModeBasis(SHELL, shell_modes(SHELL, "full", 2), 1.0, bending=True)
WAVES = Waves((1.2, 2.2, 3.8), 1025.0, np.inf, 9.81)
MODE = "Bending2"
ROWS = 32


def floating_system(height=0.0):
    return DeformedShell(BASIS, height)


def by_panels(shapes, rows=ROWS):
    def mesh(shape, part):
        return deformed_mesh(shape.shell, rows // part, 2 * rows // part, 16 // part)

    return [witness_runs((mesh(s, 1), mesh(s, 2)), BASIS, WAVES) for s in shapes]


@pytest.fixture(scope="module")
def shapes():
    return deformed_shapes(floating_system(), [MODE], np.inf)


@pytest.fixture(scope="module")
def panels(shapes):
    return by_panels(shapes)


@pytest.fixture(scope="module")
def spectral(shapes):
    return [witness.spectral_runs(s.shell, BASIS, WAVES) for s in shapes]


@pytest.fixture(scope="module")
def compared(shapes, panels, spectral):
    return witness.compared(shapes, panels, spectral, WAVES)


@pytest.fixture(scope="module")
def derivatives(shapes, panels):
    return witness.derivatives(shapes, panels, BASIS, WAVES)


def test_solvers_agree_within_small_estimates(compared, derivatives, tmp_path):
    save(compared.merge(derivatives), tmp_path / "witness.nc")
    checks = witness.witness_checks(load(tmp_path / "witness.nc"))
    assert [check.name for check in checks] == ["witness", "witness_derivatives"]
    for check in checks:
        assert check.verdict == "ok", check
        assert 0.05 < check.value < 1, check
    assert float(compared.witness_difference.max()) < 3e-3
    assert float(compared.witness_estimate.sel(solver="panels").max()) < 8e-3
    assert float(compared.witness_estimate.sel(solver="spectral").max()) < 1e-5


def test_central_differences_of_one_solver_differ_by_the_next_term(shapes, spectral):
    """Less their known term of third order: by its square, about."""
    own = witness.derivatives(shapes, spectral, BASIS, WAVES)
    assert float(own.slope_difference.max()) < float(own.slope_estimate.max()) < 1e-5


def database(solver, factor=1.0):
    omegas = [0.8, *WAVES.omegas, 4.5, 5.5]
    problem = SpectralProblem(floating_system(), displacements_of(BASIS), WAVES.density, WAVES.gravity, 24)
    solved = with_excitation(in_modes(problem.solve(omegas), BASIS))
    return (factor * solved).assign_attrs(solver=solver)


@pytest.mark.parametrize(("solver", "least"), [("spectral", 0.05), ("capytaine 3.0", 0.0)])
def test_database_is_checked_by_the_other_solver(compared, solver, least):
    (check,) = witness.database_checks(compared, database(solver), 1e-9)
    other = "panels" if solver == "spectral" else "the spectral solver"
    assert check.explanation.startswith(f"hydro database and {other} on the mean shape")
    assert check.explanation.endswith(f"({other})")
    assert check.verdict == "ok", check
    assert least <= check.value < 1
    (check,) = witness.database_checks(compared, database(solver, 1.01), 1e-9)
    assert check.verdict == "doubt", check
    (check,) = witness.database_checks(compared, database(solver, 1.01), 0.02)  # which says so itself
    assert check.verdict == "ok", check
    asides = database(solver).reindex(wave_direction=[0.0, np.pi / 2], fill_value=9.9)  # what surge and sway need
    assert witness.database_checks(compared, asides, 1e-9) == witness.database_checks(compared, database(solver), 1e-9)


@pytest.mark.parametrize(("depth", "size"), [(2.5, 0.1), (2.1, 0.05), (2.02, 0.00625)])
def test_deformed_shapes_keep_clear_of_the_bottom(depth, size):
    found = deformed_shapes(floating_system(), ["Membrane0"], depth)
    assert [s.amplitude for s in found] == pytest.approx([0.0, -size, size])
    lowest = [-float(s.shell.meridian(np.array([np.pi])).z[0]) for s in found]
    assert max(lowest) <= (2.0 + depth) / 2 + 1e-12


def test_keel_on_the_bottom_allows_no_cross_check():
    with pytest.raises(ConfigError, match=r"hydro.witness: received modes Membrane0, one of which, however small"):
        deformed_shapes(floating_system(), ["Membrane0"], 2.0)
