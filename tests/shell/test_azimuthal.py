"""Stiffness of azimuthal orders about a deformed rest shape: spherical symmetry, limits, an energy on the surface."""

import numpy as np
import pytest

from vsb.engine.shell.loaded import ElasticShell, LoadedShell, complete_basis, equilibrium
from vsb.engine.shell.lobes import azimuthal_stiffness, complete_order, softest_order
from vsb.engine.shell.material import GentLaw, HookeLaw, MooneyRivlinLaw, NeoHookeanLaw
from vsb.engine.shell.orders import volume_hessian
from vsb.engine.shell.shell import Shell

LAWS = [HookeLaw(3e6, 0.3), NeoHookeanLaw(1e6), MooneyRivlinLaw(4e5, 1e5), GentLaw(1e6, 20.0)]


def loaded_of(law, pressure, degree=6, thickness=0.05, height=0.0, density=1025.0):
    rubber = None if isinstance(law, HookeLaw) else law
    shell = Shell(2.0, thickness, law.young_modulus, law.poisson_ratio, 1100.0, None, rubber)
    gravity = 9.81 if density else 0.0
    return LoadedShell(ElasticShell(complete_basis(shell, degree, 17170.0)), height, density, gravity, pressure)


@pytest.mark.parametrize("order", [2, 3, 5])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_an_inflated_sphere_looks_the_same_from_every_direction(law, order):
    """Its stiffness of every order is the axisymmetric one, degree by degree: moduli of shear and twist included."""
    loaded = loaded_of(law, 2e4, density=0.0)
    modes = np.eye(len(loaded.basis.labels))[:, 1:]
    q = equilibrium(loaded, modes)
    assert q[1] > 0.1
    of = complete_order(loaded, order, 6)
    same = [i for i, label in enumerate(loaded.basis.labels) if f"{label}c{order}" in of.labels]
    expected = (loaded.elastic.stiffness(q) + loaded.pressure_stiffness(q))[np.ix_(same, same)]
    np.testing.assert_allclose(azimuthal_stiffness(of, loaded, q), expected, atol=1e-11 * expected.max())


@pytest.mark.parametrize("order", [1, 2, 4])
def test_about_the_undeformed_shell_it_is_that_of_small_strains(order):
    loaded = loaded_of(NeoHookeanLaw(1e6), 1e4, height=0.3)
    of, none = complete_order(loaded, order, 6), np.zeros(len(loaded.basis.labels))
    water = of.hydrostatic_stiffness(0.3, 1025.0, 9.81)
    expected = of.stiffness + (water + water.T) / 2 - 1e4 * volume_hessian(of)
    rigid = of.rigid
    found = azimuthal_stiffness(of, loaded, none)
    np.testing.assert_allclose(found[rigid:, rigid:], expected[rigid:, rigid:], atol=1e-11 * expected.max())
    assert not found[:rigid].any()


def surface_energy(loaded, q, of, amplitude, index):
    """Potential of a submerged shell on a grid of its surface: strains from the metric, pressure from the volume."""
    shell, m, count = loaded.basis.shell, of.order, 8 * of.order
    node, weight = np.polynomial.legendre.leggauss(60)
    phi, theta = np.arccos(node)[:, None], 2 * np.pi * np.arange(count) / count
    v0, u0, dv0, du0 = (q @ part for part in loaded.basis.displacement_and_slope(phi[:, 0]))
    at, slope = of.field(phi[:, 0]), of.field(phi[:, 0], derivative=1)
    v1, u1, w1, dv1, du1, dw1 = (amplitude * part[index][:, None] for part in (*at, *slope))
    cos, sin = np.cos(m * theta), np.sin(m * theta)
    v, u, w = v0[:, None] + v1 * cos, u0[:, None] + u1 * cos, w1 * sin
    dv, du, dw = dv0[:, None] + dv1 * cos, du0[:, None] + du1 * cos, dw1 * sin
    tv, tu, tw = -m * v1 * sin, -m * u1 * sin, m * w1 * cos
    s, c, out = np.sin(phi), np.cos(phi), shell.radius + v
    along = np.array([dv - u, out + du, dw])
    around = np.array([tv - w * s, tu - w * c, tw + out * s + u * c])
    place = np.array([out, u, w])
    a, b, mixed = (along**2).sum(0), (around**2).sum(0) / s**2, (along * around).sum(0) / s
    metric = np.array([[a, mixed], [mixed, b]]).transpose(2, 3, 0, 1) / shell.radius**2
    strains = (np.linalg.eigvalsh(metric) - 1) / 2
    area = weight[:, None] * 2 * np.pi / count  # of the unit sphere
    elastic = shell.thickness * shell.radius**2 * (shell.law.energy(strains[..., 0], strains[..., 1]) * area).sum()
    normal = np.cross(along, around, axis=0) / s
    height = loaded.centre_height + out * c - u * s
    upwards = normal[0] * c - normal[1] * s
    volume = ((place * normal).sum(0) * area).sum() / 3
    water = -loaded.water_density * loaded.gravity * (height**2 / 2 * upwards * area).sum()
    return elastic - loaded.internal_pressure * volume + water


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_stiffness_is_the_second_slope_of_the_energy_of_the_surface(law):
    """About any axisymmetric shape, of a thin wall that bends freely; the pressure inside is constant."""
    loaded = loaded_of(law, 2e4, degree=4, thickness=1e-5, height=-3.0)
    q = 0.15 * np.cos(1.7 * np.arange(len(loaded.basis.labels)) + 0.3)
    of, step = complete_order(loaded, 2, 4), 2e-3
    found = np.diag(azimuthal_stiffness(of, loaded, q))
    for index in range(len(of.labels)):
        ends = [surface_energy(loaded, q, of, k * step, index) for k in (-2, -1, 0, 1, 2)]
        second = (-ends[0] + 16 * ends[1] - 30 * ends[2] + 16 * ends[3] - ends[4]) / (12 * step**2)
        assert found[index] == pytest.approx(second, rel=1e-5, abs=1e-6 * np.abs(found).max())


def test_a_shell_in_tension_is_stable_and_one_in_compression_wrinkles():
    """Few axisymmetric modes carry a load that folds the shell around its axis."""
    least = {}
    for pressure in (2.5e4, 1.2e4):
        loaded = loaded_of(NeoHookeanLaw(5e6), pressure, degree=4, thickness=0.01)
        q = equilibrium(loaded)
        tension = np.min(loaded.elastic.resultants(q))
        least[np.sign(tension)] = softest_order(loaded, q, 4, 16)[0]
    assert least[1.0] > 0.1
    assert least[-1.0] < -0.1
