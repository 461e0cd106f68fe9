"""Coefficients of natural modes of other rest shapes, which are sums of many Legendre parts: independent references."""

import numpy as np
import pytest
from conftest import varied

from vsb.hydro.database import displacements_of, in_modes, with_excitation
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.scenes.ports import designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.stages.campaign import swept_shape

DENSITY, GRAVITY = 1025.0, 9.81
SPHEROID = {
    "device": {"shape": {"spheroid": {"height": 3.0}}, "young_modulus": 3e7, "mass": 12880.529879718},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}},
}
SHAPES = [
    SPHEROID["device"],
    {"shape": {"capsule": {"length": 3.0}}, "mass": 30000.0},
    {"shape": {"profile": [[0.0, 2.0], [1.0, 1.8], [1.9, 0.4], [1.6, -0.9], [0.0, -1.7]]}, "mass": 9000.0},
]


@pytest.mark.parametrize("device", SHAPES, ids=["spheroid", "capsule", "profile"])
def test_in_long_waves_the_force_on_a_mode_is_that_of_raised_water(seed, device):
    """X of a mode tends to -rho g int n.psi dS over the wet surface, integrated here on its own quadrature."""
    study = varied(seed, device=device, modes={"basis": "full", "degree": 7}, hydro={"witness": "none"})
    shell = reference_shell(study).shape
    basis, omega = shell.basis, 0.02
    problem = SpectralProblem(shell, displacements_of(basis), DENSITY, GRAVITY, 32)
    found = with_excitation(in_modes(problem.solve([omega]), basis)).excitation_force.values[0, 0]
    node, weight = np.polynomial.legendre.leggauss(400)
    half = (np.pi - shell.waterline) / 2
    phi, weight = shell.waterline + half * (node + 1), half * weight
    at = basis.shell.at_rest(phi)
    v, u = basis.displacement(phi)
    along_x, along_z = v * np.sin(phi) + u * np.cos(phi), v * np.cos(phi) - u * np.sin(phi)
    expected = -DENSITY * GRAVITY * 2 * np.pi * ((-at.dz * along_x + at.dx * along_z) * at.x * weight).sum(axis=1)
    np.testing.assert_allclose(found.real, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("degree", "expected"), [(10, [-4.745, -2.833, 0.761, -1.948]), (16, [-4.955, -3.005, 0.754, -2.109])]
)
def test_gains_of_a_flexible_spheroid_are_those_of_an_independent_computation(seed, tmp_path, degree, expected):
    """Own Ritz solution of the shell and multipoles by least squares on its meridian, sharing no code; at |Z| each."""
    study = varied(seed, **SPHEROID, modes={"basis": "full", "degree": degree}, hydro={"witness": "none"})
    omega = 2 * np.pi / np.array([6.0, 4.0, 3.0, 2.5])
    reference = reference_shell(study)
    seen = designs_in_waves(study, reference, swept_shape(study, reference.basis, str(tmp_path)).at(omega))
    gain = 100 * (seen["VSWEC"].port.best_power / seen["FSB"].port.best_power - 1)
    np.testing.assert_allclose(gain, expected, atol=2e-3)


@pytest.mark.parametrize("length", [12.0, 20.0])
def test_long_capsules_have_modes(seed, length):
    study = varied(
        seed, device={"shape": {"capsule": {"length": length}}, "mass": 5e4}, modes={"basis": "full", "degree": 6}
    )
    basis = reference_shell(study).basis
    assert np.all(np.linalg.eigvalsh(basis.inertia) > 0)
    assert np.all(np.diff(basis.dry_frequencies) >= 0)
