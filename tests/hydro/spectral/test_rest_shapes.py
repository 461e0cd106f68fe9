"""Spectral coefficients on other rest shapes than the sphere, against closed forms and the same body as a deformed one."""

import math

import numpy as np
import pytest
from conftest import varied

from vsb.engine.hydro.database import displacements_of, in_modes, with_excitation
from vsb.engine.hydro.dofs import displacements
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.meridian import capsule, spheroid
from vsb.engine.shell.modes import Mode, ModeBasis, natural_shapes
from vsb.engine.shell.shell import Shell
from vsb.models.ports import buoy_at
from vsb.models.rest import reference_shell
from vsb.stages.members import swept_shape

DENSITY, GRAVITY = 1025.0, 9.81


def _at_rest(meridian, centre_height=0.0, degree=0):
    shell = Shell(meridian.radius, 0.002 * meridian.radius, 1e7, 0.3, 2700.0, meridian)
    modes = natural_shapes(shell, degree) if degree else ()
    return DeformedShell(ModeBasis(shell, modes, 1e4, bending=True), centre_height)


def _lamb(a, c):
    """Added mass over displaced mass of a spheroid far from all, along and across its axis (Lamb 1932, art. 114)."""
    if c > a:
        e = math.sqrt(1 - a**2 / c**2)
        log = math.log((1 + e) / (1 - e))
        along, across = 2 * (1 - e**2) / e**3 * (log / 2 - e), 1 / e**2 - (1 - e**2) / (2 * e**3) * log
    else:
        e = math.sqrt(1 - c**2 / a**2)
        root = math.sqrt(1 - e**2)
        along, across = 2 / e**3 * (e - root * math.asin(e)), root / e**3 * math.asin(e) - (1 - e**2) / e**2
    return along / (2 - along), across / (2 - across)


@pytest.mark.parametrize("height", [1.6, 3.0, 6.0, 10.0])
def test_limits_of_half_immersed_spheroids_are_lambs(height):
    """Mirrored, the body is whole: odd at infinite frequency, so heave is along its axis; even at zero, so surge is."""
    body, displaced = _at_rest(spheroid(2.0, height)), DENSITY * 4 / 3 * math.pi * 4.0 * height / 4
    along, across = _lamb(2.0, height / 2)
    heave = SpectralProblem(body, displacements(["Heave"]), DENSITY, GRAVITY, 48)
    assert heave.at_infinity()[0, 0] == pytest.approx(along * displaced, rel=1e-6)
    surge = SpectralProblem(body, displacements(["Surge"], 1), DENSITY, GRAVITY, 48)
    assert surge.at_zero()[0, 0] == pytest.approx(across * displaced, rel=1e-6)


def test_a_spheroid_is_a_sphere_deformed_into_it():
    a, c = 2.0, 1.6
    v = {0: (2 * a + c) / 3 - a, 2: 2 * (c - a) / 3}
    modes = (Mode("Membrane0", 0, 1.0, 0.0), Mode("Membrane2", 2, v[2], (c - a) / 3))
    sphere = ModeBasis(Shell(a, 0.01, 1e7, 0.3, 2700.0), modes, 1e4, bending=True)
    deformed = DeformedShell(sphere, 0.3, np.array([0.0, v[0], 1.0]))
    asked = displacements(["Heave", "Radial0", "Radial3", "Meridional2"])
    one, other = (
        SpectralProblem(shell, asked, DENSITY, GRAVITY, 32).solve([1.0, 2.5])
        for shell in (deformed, _at_rest(spheroid(a, 2 * c), 0.3))
    )
    for name in ("added_mass", "radiation_damping", "diffraction_force", "Froude_Krylov_force"):
        assert other[name].values == pytest.approx(
            one[name].values, rel=1e-9, abs=1e-9 * np.abs(one[name].values).max()
        )


BODIES = [_at_rest(spheroid(2.0, 3.0), 0.4, 3), _at_rest(capsule(1.0, 1.0), 0.5, 2)]


@pytest.mark.parametrize("body", BODIES, ids=["spheroid", "capsule"])
def test_reciprocity_and_haskind_of_shell_modes(body):
    basis = body.basis
    asked = displacements(
        [*(f"Radial{n}" for n in range(basis.highest_degree + 1)),
         *(f"Meridional{n}" for n in range(1, basis.highest_degree + 1))]
    )  # fmt: skip
    found = with_excitation(in_modes(SpectralProblem(body, asked, DENSITY, GRAVITY, 20).solve([2.0]), basis))
    for name in ("added_mass", "radiation_damping"):
        value = found[name].values
        assert np.abs(value - value.transpose(0, 2, 1)).max() < 1e-8 * np.abs(value).max()
    implied = haskind_damping(found, np.inf, DENSITY, GRAVITY).real
    assert np.abs(found.radiation_damping.values - implied).max() < 1e-8 * np.abs(implied).max()


@pytest.mark.parametrize(("draft", "depth"), [(3.5, np.inf), (2.0, np.inf), (1.995, np.inf), (4.2, np.inf), (3.5, 4.0)])
def test_capsule_converges_spectrally_on_each_side_of_its_junctions(draft, depth):
    """Also where the waterline meets a junction, or nearly does, and over a level bottom."""
    meridian, found = capsule(2.0, 2.0), []
    body = _at_rest(meridian, -(meridian.lowest + draft))
    for nodes in (16, 48):
        problem = SpectralProblem(body, displacements(["Heave"]), DENSITY, GRAVITY, nodes, depth=depth)
        found.append(with_excitation(problem.solve([2.618])))
    for name in ("added_mass", "radiation_damping", "excitation_force"):
        assert found[0][name].values == pytest.approx(found[1][name].values, rel=2e-5), name
    implied = haskind_damping(found[1], depth, DENSITY, GRAVITY).real
    assert implied == pytest.approx(found[1].radiation_damping.values, rel=5e-7)


SPHEROID = {
    "device": {"shape": {"spheroid": {"height": 3.0}}, "young_modulus": 3e7, "mass": 12880.529879718},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}},
}
SHAPES = [
    SPHEROID["device"],
    {"shape": {"profile": [[0.0, 2.0], [1.0, 1.8], [1.9, 0.4], [1.6, -0.9], [0.0, -1.7]]}, "mass": 9000.0},
]


@pytest.mark.parametrize("device", SHAPES, ids=["spheroid", "profile"])
def test_force_on_modes_in_long_waves_is_hydrostatic(seed, device):
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


@pytest.mark.parametrize(("degree", "expected"), [(10, [-4.745, -2.833, 0.761, -1.948])])
def test_gains_of_a_flexible_spheroid_are_those_of_an_independent_computation(seed, tmp_path, degree, expected):
    """Own Ritz solution of the shell and multipoles by least squares on its meridian, sharing no code; at |Z| each."""
    study = varied(seed, **SPHEROID, modes={"basis": "full", "degree": degree}, hydro={"witness": "none"})
    omega = 2 * np.pi / np.array([6.0, 4.0, 3.0, 2.5])
    reference = reference_shell(study)
    seen = buoy_at(study, reference, swept_shape(study, reference.basis, str(tmp_path)).at(omega)).ports()
    gain = 100 * (seen["VSWEC"].best_power / seen["FSB"].best_power - 1)
    np.testing.assert_allclose(gain, expected, atol=2e-3)
