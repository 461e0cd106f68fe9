"""Buckling into lobes around the axis: closed forms of sphere and spheroids, rigid motions, finer displacements."""

import dataclasses

import numpy as np
import pytest

from vsb.engine.shell.deformed import rigid_buoy
from vsb.engine.shell.loaded import ElasticShell, LoadedShell, buckling, complete_basis, complete_shell, equilibrium
from vsb.engine.shell.lobes import (
    LobedShell,
    azimuthal_stiffness,
    complete_order,
    displacements,
    softest_order,
    strains,
    with_lobes,
)
from vsb.engine.shell.material import GentLaw, HookeLaw, MooneyRivlinLaw, NeoHookeanLaw
from vsb.engine.shell.meridian import RestMeridian, bend, capsule, curve, spheroid
from vsb.engine.shell.orders import prestress_stiffness, volume_hessian
from vsb.engine.shell.shell import Shell, converged_degree

RHO, G = 1025.0, 9.81
SPHERE = Shell(radius=2.0, thickness=0.04, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
EGG = RestMeridian((2.0, 0.1), (0.1, 1.8, 0.15))


def loaded(shell, pressure=0.0, height=-0.4, gravity=G, degree=None):
    """A shell that floats with its middle so high, or without weight under a pressure."""
    mass = RHO * rigid_buoy(shell, height).volume(200)
    basis = complete_basis(shell, degree or converged_degree(shell), mass)
    return LoadedShell(ElasticShell(basis), height, RHO, gravity, pressure)


def pressed(shell, degree=None):
    """A shell under a pressure of 1 Pa from outside."""
    return loaded(shell, -1.0, gravity=0.0, degree=degree)


def test_every_order_of_the_sphere_has_the_axisymmetric_buckling_load():
    """A degree n that buckles does in all 2 n + 1 shapes of it."""
    sphere = pressed(SPHERE)
    expected = buckling(sphere)
    found = LobedShell(sphere, 40).buckling(expected.degree + 2)
    same = {one.order for one in found if one.inverse_load_factor * expected.load_factor > 1 - 1e-9}
    assert same == set(range(1, expected.degree + 1))
    assert found[0].inverse_load_factor * expected.load_factor == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("height", [6.0, pytest.param(8.0, marks=pytest.mark.slow)])
def test_thin_long_spheroids_buckle_at_the_load_of_mushtari_and_galimov(height):
    """At the equator into lobes, under 1/(2 (b/r)^2 - 1) of the sphere's load, b half the height.

    The lobes are as long as the curvature stays the same: an excess like sqrt(h/r), extrapolated. Their whole number
    scatters it.
    """

    def excess(thickness):
        sphere = dataclasses.replace(SPHERE, thickness=thickness)
        classical = sphere.buckling_pressure / (2 * (height / 4) ** 2 - 1)
        found = with_lobes(pressed(dataclasses.replace(sphere, rest=spheroid(2.0, height))))
        assert found.order > 5
        return found.load_factor / classical - 1

    thick, thin = excess(0.04), excess(0.01)
    assert 0.0 < thin < 0.65 * thick
    assert 2 * thin - thick == pytest.approx(0.0, abs=0.015)


def test_flat_spheroids_and_the_floating_sphere_buckle_axisymmetrically_first(seed):
    """Their loads are those of `test_loaded`: lobes of order 1 follow closely where a pole buckles."""
    flat = pressed(dataclasses.replace(SPHERE, rest=spheroid(2.0, 3.0)))
    spheres = [complete_shell(seed.device, seed.centre_height, seed.water, pressure) for pressure in (0.0, 16.3e3)]
    for one in (flat, *spheres):
        assert with_lobes(one) == buckling(one)


def test_tension_makes_no_lobes():
    assert LobedShell.of(loaded(SPHERE, 100.0, gravity=0.0)).buckling(1)[0].inverse_load_factor < 1e-12


@pytest.mark.parametrize("rest", [spheroid(2.0, 3.0), spheroid(2.0, 6.0), EGG])
def test_rigid_motions_strain_nothing_and_pitch_meets_the_metacentre(rest):
    """The load's stiffness against pitch is m g times the metacentric height over the centroid of the wall.

    Up to h/r, for membrane forces alone carry the load there.
    """
    floating = loaded(dataclasses.replace(SPHERE, thickness=0.01, rest=rest, radius=rest.radius))
    (phi, area), (elastic, load) = floating.elastic.rings, LobedShell(floating, 40).pencil(1)
    psi, at = displacements(1, 40, phi), floating.basis.shell.at_rest(phi)
    fields, root = np.concatenate([psi.x, psi.w, psi.z], axis=1).T, np.sqrt(np.tile(area, 3))
    none, one, weight = 0 * phi, 1 + 0 * phi, floating.basis.total_mass * G
    motions = np.array([[one, -one, none], [at.z, -at.z, -at.x]]).reshape(2, -1).T
    q = np.linalg.lstsq(fields * root[:, None], motions * root[:, None], rcond=None)[0]
    assert np.abs(fields @ q - motions).max() < 1e-6
    scale = np.abs(elastic).max()
    assert np.abs(q.T @ elastic @ q).max() < 1e-11 * scale
    assert np.abs(load @ q[:, 0]).max() < 1e-6 * weight
    volume, centroid = floating.basis.total_mass / RHO, np.sum(at.z * area) / np.sum(area)
    metacentre = np.pi / 4 * rest.radius_at(0.4) ** 4 / volume + rest.centroid_below(0.4)
    assert q[:, 1] @ load @ q[:, 1] == pytest.approx(weight * (metacentre - centroid), abs=1e-3 * weight * 2.0)


def test_strain_of_a_capsule_that_pitches_falls_with_the_degree():
    """Smooth displacements follow z of a meridian whose curvature jumps to 1/n^2, and their strains to 1/n."""
    floating, energy = loaded(dataclasses.replace(SPHERE, thickness=0.01, rest=capsule(2.0, 2.0))), []
    phi, area = floating.elastic.rings
    at, root = floating.basis.shell.at_rest(phi), np.sqrt(np.tile(area, 3))
    for degree in (20, 40, 80):
        psi = displacements(1, degree, phi)
        fields = np.concatenate([psi.x, psi.w, psi.z], axis=1).T
        q = np.linalg.lstsq(fields * root[:, None], np.concatenate([at.z, -at.z, -at.x]) * root, rcond=None)[0]
        energy.append(q @ LobedShell(floating, degree).pencil(1)[0] @ q)
    assert energy[0] > 4 * energy[1] > 16 * energy[2]


@pytest.mark.parametrize(
    ("rest", "apart"), [(spheroid(2.0, 3.0), 1e-6), (spheroid(2.0, 6.0), 1e-6), (capsule(2.0, 1.0), 2e-3), (EGG, 1e-6)]
)
def test_more_displacements_and_orders_change_nothing(rest, apart):
    """Loads of a floating shell with twice the degree; further orders than are searched hold no larger factor.

    Smooth displacements follow the wall of a capsule, whose curvature jumps, with a power of the degree only.
    """
    floating = loaded(dataclasses.replace(SPHERE, rest=rest, radius=rest.radius))
    lobed = LobedShell.of(floating)
    coarse, fine = (one.buckling(4) for one in (lobed, LobedShell(floating, 2 * lobed.degree)))
    assert [one.order for one in coarse] == [one.order for one in fine]
    for one, other in zip(coarse, fine, strict=True):
        assert one.inverse_load_factor == pytest.approx(other.inverse_load_factor, rel=apart)
    for order in range(int(lobed.most_lobes) + 1, 2 * int(lobed.most_lobes), 5):
        elastic, load = lobed.pencil(order)
        below = load + coarse[-1].inverse_load_factor * elastic
        assert np.linalg.eigvalsh(below)[0] > 0


@pytest.mark.parametrize("rest", [spheroid(2.0, 6.0), EGG])
@pytest.mark.parametrize("order", [1, 4])
def test_strains_are_those_of_the_deformed_surface(rest, order):
    """First and second fundamental form to first order, by a complex step: Sanders' measure is dK - (k e + e k)/2.

    The surface X = (x + s_x cos, w sin, z + s_z cos) in the frame that turns with theta; K_ab = -X_ab.n.
    """
    phi, m, theta, step = np.linspace(0.3, 2.9, 7), order, 0.7, 1e-30j
    cos, sin = np.cos(m * theta), np.sin(m * theta)
    psi, at, (ddx, ddz) = displacements(m, 6, phi), curve(rest, phi), bend(rest, phi)
    membrane, bending, *_ = strains(psi, m, at, (ddx, ddz))
    ax, aw, az = psi.around(m)

    def vector(x, w, z):
        return np.array(np.broadcast_arrays(x, w, z))

    by_phi = vector(at.dx + step * psi.dx * cos, step * psi.dw * sin, at.dz + step * psi.dz * cos)
    by_theta = vector(step * ax * sin, at.x + step * aw * cos, step * az * sin)
    across = np.cross(by_phi, by_theta, axis=0)
    normal = across / np.sqrt((across**2).sum(axis=0))
    second = (  # the part of X_phi,phi along theta is of second order in its product with n
        vector(ddx + step * psi.ddx * cos, 0 * psi.x, ddz + step * psi.ddz * cos),
        vector(step * m * ax * cos - by_theta[1], 0 * psi.x, step * m * az * cos),
        vector(
            -step * (m * psi.dx + psi.dw) * sin, at.dx + step * (m * psi.dw + psi.dx) * cos, -step * m * psi.dz * sin
        ),
    )
    slope = np.hypot(at.dx, at.dz)
    scales = slope**2, at.x**2, slope * at.x
    along, around, twist = (-(one * normal).sum(axis=0) / scale for one, scale in zip(second, scales, strict=True))
    (e, t, g), size = (
        (by_phi**2).sum(axis=0) / 2 / scales[0], (by_theta**2).sum(axis=0) / 2 / scales[1],
        (by_phi * by_theta).sum(axis=0) / scales[2],
    ), step.imag  # fmt: skip
    for found, expected, around_axis in zip(membrane, (e, t, g), (cos, cos, sin), strict=True):
        assert found * around_axis == pytest.approx(expected.imag / size, rel=1e-9, abs=1e-9)
    changes = (
        along.imag - along.real * e.imag, around.imag - around.real * t.imag,
        2 * twist.imag - (along.real + around.real) / 2 * g.imag,
    )  # fmt: skip
    for found, expected, around_axis in zip(bending, changes, (cos, cos, sin), strict=True):
        assert found * around_axis == pytest.approx(expected / size, rel=1e-9, abs=1e-9)


def test_energies_of_the_floating_sphere_are_those_of_its_degrees(seed):
    """Shapes of one degree of `vsb.engine.shell.orders`, whose elastic, prestress and hydrostatic stiffness are their own."""
    sphere = complete_shell(seed.device, seed.centre_height, seed.water, 9e3)
    (phi, area), basis = sphere.elastic.rings, complete_order(sphere, 3, 6)
    (v, u, w), psi = basis.field(phi), displacements(3, 20, phi)
    sin, cos, root = np.sin(phi), np.cos(phi), np.sqrt(np.tile(area, 3))[:, None]
    motions = np.concatenate([v * sin + u * cos, w, v * cos - u * sin], axis=1).T
    q = np.linalg.lstsq(np.concatenate([psi.x, psi.w, psi.z], axis=1).T * root, motions * root, rcond=None)[0]
    elastic, load = LobedShell(sphere, 20).pencil(3, q)
    water = basis.hydrostatic_stiffness(sphere.centre_height, sphere.water_density, sphere.gravity)
    prestress = prestress_stiffness(basis, sphere) + (water + water.T) / 2
    for found, expected in ((elastic, basis.stiffness), (load, prestress)):
        assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


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
