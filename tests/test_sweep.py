import numpy as np
import pytest

from vsb.errors import ConvergenceError
from vsb.spectral import SpectralProblem
from vsb.surface import rigid_sphere
from vsb.sweep import converged, interpolation_error

OMEGA = [0.5, 1.5, 3.0]


def problem(nodes=8):
    return SpectralProblem(rigid_sphere(1.0, 0.0), ("Radial0", "Radial1", "Radial4"), 1.0, 1.0, nodes)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-4, 1e-8])
def test_estimate_and_error_are_below_the_tolerance(tolerance):
    found, estimate = converged(problem(), OMEGA, tolerance)
    assert estimate <= tolerance
    exact = problem(64).solve(OMEGA)
    for name in ("added_mass", "radiation_damping"):
        largest = np.abs(exact[name]).max(dim=("influenced_dof", "radiating_dof"))
        assert float((np.abs(found[name] - exact[name]) / largest).max()) <= tolerance
    assert found.added_mass_inf.shape == (3, 3)


def test_a_tolerance_out_of_reach_is_said():
    with pytest.raises(ConvergenceError, match=r"hydro.tolerance: received 1e-20, the spectral solver reaches .* 128"):
        converged(problem(64), OMEGA, 1e-20)


def test_interpolation_error_falls_at_fourth_order_with_the_step():
    steps = np.array([0.4, 0.2, 0.1, 0.05])
    errors = []
    for step in steps:
        omega = list(np.arange(1, round(4.0 / step) + 1) * step)
        errors.append(interpolation_error(problem(24), problem(24).solve(omega)))
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert errors[-1] < 1e-4
    assert np.all(slopes > 2.0), (errors, slopes)  # the first interval, next to frequency zero, is the slowest
    assert np.all(slopes < 5.0), (errors, slopes)
