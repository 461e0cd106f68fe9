import numpy as np
import pytest

from vsb.engine.hydro import dofs
from vsb.engine.hydro.panels import rings as bem
from vsb.engine.hydro.panels.mesh import deformed_mesh
from vsb.engine.hydro.panels.sweep import TwoMeshes
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.hydro.sweep import coefficients, largest
from vsb.engine.shell.deformed import rigid_sphere

LEGENDRE = dofs.displacements(f"Radial{n}" for n in range(5))
LOW = [round(0.1 * i, 10) for i in range(1, 33)]
FROM_KD = [w for w in LOW if w >= 0.7]  # kd > 0.3
HIGH = [round(0.1 * i, 10) for i in range(65, 97)]
SCENES = {
    "hemisphere": (0.0, LEGENDRE, np.inf, LOW),
    "low": (-0.8, LEGENDRE, np.inf, LOW),
    "short waves": (-0.8, LEGENDRE, np.inf, HIGH),
    "near the bottom": (0.0, LEGENDRE, 2.2, FROM_KD),
}


@pytest.fixture(scope="module")
def green(green_folder):
    return bem.green_function(green_folder)


def meshes(green, rows, height=0.0, displacements=LEGENDRE, depth=np.inf, density=1025.0):
    """The sphere of radius 2 m with its centre at a height, and an undemanding lid."""

    def problem(part):
        mesh = deformed_mesh(rigid_sphere(2.0, height), rows // part, 2 * rows // part, 16 // part)
        return bem.AxisymmetricProblem(green, mesh, displacements, density, depth, 9.81)

    return TwoMeshes(problem(1), problem(2))


def true_error(two, found):
    """Against the spectral solver, in terms of the largest entries the estimate is told of."""
    p, height = two.fine, 2.0 + float(two.fine.mesh.meridian_height.min())
    exact = SpectralProblem(rigid_sphere(2.0, height), p.displacements, p.density, 9.81, 48, depth=p.depth)
    reference = exact.solve(found.omega.values.tolist())
    sizes = largest(reference, two.strongest)
    pairs = zip(coefficients(found), coefficients(reference), sizes, strict=True)
    return max(float(np.abs(a - b).max()) / size for a, b, size in pairs)


@pytest.mark.parametrize("scene", ["hemisphere", "low", "short waves", "near the bottom"])
def test_the_estimate_bounds_the_error_of_panels_and_interpolation(green, scene):
    *shape, frequencies = SCENES[scene]
    two = meshes(green, 12, *shape)
    found = two.solve(frequencies, 5e-4)
    estimate, error = found.attrs["error_estimate"], true_error(two, found)
    assert error <= estimate
    assert estimate <= (50 if scene == "short waves" else 8) * error


@pytest.mark.parametrize("depth", [np.inf, 4.0])
def test_the_estimate_at_infinite_frequency_bounds_the_error(green, depth):
    errors = []
    for rows in (12, 20):
        two = meshes(green, rows, depth=depth)
        exact = SpectralProblem(rigid_sphere(2.0, 0.0), LEGENDRE, 1025.0, 9.81, 48, depth=depth).at_infinity()
        found = two.at_infinity()
        errors.append(np.abs(found.added_mass_inf.values - exact).max() / np.abs(exact).max())
        assert errors[-1] <= found.attrs["error_estimate"] <= 10 * errors[-1]
    assert errors[0] > errors[1]


@pytest.mark.parametrize("scene", ["low", "short waves"])
def test_in_deep_water_few_frequencies_are_solved(green, scene):
    *shape, frequencies = SCENES[scene]
    two = meshes(green, 20, *shape)
    found = two.solve(frequencies, 5e-4)
    assert found.attrs["frequencies"] == len(frequencies) == found.sizes["omega"]
    assert found.attrs["solves"] <= 13
    direct = two.solve(frequencies)
    assert direct.attrs["solves"] == len(frequencies)
    sizes = largest(direct, two.strongest)
    pairs = zip(coefficients(found), coefficients(direct), sizes, strict=True)
    assert max(np.abs(a - b).max() / size for a, b, size in pairs) <= direct.attrs["error_estimate"] / 2
