"""A pressurised shell, a rigid buoy and a small climate, for tests of derivatives."""

import numpy as np
import pytest

from vsb.design.linearised import displacements
from vsb.engine.hydro.database import Coefficients, with_excitation
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.waves.climate import Climate
from vsb.models.floating_system import ShapeWater, buoy_at
from vsb.models.rest import reference_shell
from vsb.study.study import parse

DEVICE = {
    "radius": 2.0, "thickness": 0.01, "young_modulus": 10.0e6, "poisson_ratio": 0.3, "density": 2700.0,
    "mass": 17170.0, "internal_pressure": 16.5e3, "damping": {"beta": 1.0e-3},
}  # fmt: skip


def study_of(**changes):
    """A study of designs of a pressurised shell at equilibrium, with other sections."""
    raw = {
        "study": "shell",
        "device": {key: value for key, value in (DEVICE | changes.pop("device", {})).items() if value is not None},
        "modes": {"basis": "full", "degree": 4},
        "reference_shape": "equilibrium",
        "designs": {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}},
        "waves": [{"kind": "still"}],
    }
    return parse(raw | changes)


def campaigns_buoy(study, grid, nodes):
    """The buoy of a study in natural modes, its water solved at the frequencies of a year."""
    reference, moved, water = reference_shell(study), displacements(study.modes.degree), study.water
    problem = SpectralProblem(reference.shape, moved, water.density, water.gravity, nodes, water.depth)
    solved = with_excitation(problem.solve(list(grid.omega)))
    parts = solved.added_mass.values, solved.radiation_damping.values, solved.excitation_force.values[:, 0]
    return buoy_at(study, reference, ShapeWater(moved, grid.omega, Coefficients(*parts)))


@pytest.fixture(scope="session")
def climate():
    """Two bands of waves."""
    omega, density = np.array([0.8, 1.2, 1.6]), np.array([[0.4, 0.6, 0.0]])
    return Climate.of_spectra(omega, density, np.ones(1), "two bands")
