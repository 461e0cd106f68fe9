"""The loaded shell against closed forms, derivatives of an independently written energy, statics and classical theory."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad

from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import (
    ElasticShell,
    Gas,
    LoadedShell,
    buckling,
    complete_basis,
    complete_shell,
    equilibrium,
    viable_pressure,
)
from vsb.engine.shell.lobes import LobedShell, with_lobes
from vsb.engine.shell.meridian import capsule, spheroid
from vsb.engine.shell.modes import ModeBasis, curvature_shapes, mode_basis, natural_shapes, shell_modes
from vsb.engine.shell.shell import Shell, converged_degree
from vsb.errors import ConvergenceError

RHO, G = 1025.0, 9.81
SHELL = Shell(radius=2.0, thickness=0.01, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
MASS = 17170.0
GAS = Gas(adiabatic_index=1.4, atmospheric_pressure=101325.0)


@pytest.fixture(scope="module")
def full(seed):
    return mode_basis(seed.device, "full", 6)


@pytest.fixture(scope="module")
def bent():
    """Amplitudes of a strongly deformed shell of 13 degrees of freedom, heave included."""
    return 0.02 * np.sin(1.7 * np.arange(13) + 0.4)


def complete(degree, shell=SHELL, mass=MASS):
    return ElasticShell(complete_basis(shell, degree, mass))


def floating(elastic, pressure, gas=None, height=0.0):
    return LoadedShell(elastic, height, RHO, G, pressure, gas)


def weightless(elastic, pressure, gas=None):
    return LoadedShell(elastic, 0.0, 0.0, 0.0, pressure, gas)


def derivative(function, q, step=2e-3):
    """Derivative by each amplitude, three central differences extrapolated: exact for polynomials up to degree 6."""

    def central(e, h):
        return (function(q + h * e) - function(q - h * e)) / (2 * h)

    return np.array([
        (64 * central(e, step / 4) - 20 * central(e, step / 2) + central(e, step)) / 45 for e in np.eye(q.size)
    ])  # fmt: skip


def potential(loaded, q):
    """The total potential, written anew: the pressure's work by quadrature over the volume, the water's over its depth."""
    reference, volume = 4 / 3 * np.pi * 8, loaded.elastic.volume(q)
    index, outside = (loaded.gas.adiabatic_index, loaded.gas.atmospheric_pressure) if loaded.gas else (0.0, 0.0)
    gauge = quad(
        lambda v: (outside + loaded.internal_pressure) * (reference / v) ** index - outside, reference, volume
    )[0]
    shell = DeformedShell(loaded.basis, loaded.centre_height, q)
    node, weight = np.polynomial.legendre.leggauss(120)
    water = 0.0
    for a, b in shell.wet_segments:
        m = shell.meridian((a + b) / 2 + (b - a) / 2 * node)
        water += RHO * G * np.pi * (b - a) / 2 * (m.x**2 * m.z * m.dz) @ weight  # -rho g int z dV
    return loaded.elastic.energy(q) - gauge + water + G * loaded.basis.inertia[0] @ q


# the potential and its derivatives


@pytest.mark.parametrize(("gas", "height"), [(None, -2.6), (GAS, 0.3)])
def test_force_is_minus_the_gradient_of_the_potential(full, bent, gas, height):
    loaded = floating(ElasticShell(full), 5e3, gas, height)
    force = loaded.force(bent)
    assert force == pytest.approx(-derivative(lambda q: potential(loaded, q), bent), abs=1e-9 * np.abs(force).max())


@pytest.mark.parametrize("gas", [None, GAS])
def test_stiffness_is_the_symmetric_hessian_and_the_sum_of_its_contributions(full, bent, gas):
    loaded = floating(ElasticShell(full), 5e3, gas)
    stiffness = loaded.stiffness(bent)
    largest = np.abs(stiffness).max()
    assert stiffness == pytest.approx(-derivative(loaded.force, bent), abs=1e-9 * largest)
    assert np.abs(stiffness - stiffness.T).max() < 1e-13 * largest
    parts = [loaded.pressure_stiffness(bent), loaded.gas_stiffness(bent), loaded.hydrostatic_stiffness(bent)]
    elastic = loaded.elastic.material_stiffness(bent) + loaded.elastic.geometric_stiffness(
        *loaded.elastic.resultants(bent)
    )
    assert stiffness == pytest.approx(elastic + sum(parts), abs=1e-14 * largest)
    assert np.any(parts[1]) == (gas is not None)


# inflation and gas


def inflated(pressure, shell=SHELL):
    """Stretch of a spherical Green-Lagrange Hookean membrane: stretch - 1/stretch = p r (1 - nu)/(E h)."""
    load = pressure * shell.radius * (1 - shell.poisson_ratio) / (shell.young_modulus * shell.thickness)
    return (load + math.sqrt(load**2 + 4)) / 2


@pytest.mark.parametrize("pressure", [-100.0, 1e5])
def test_inflated_sphere_matches_the_closed_form(pressure):
    elastic = complete(6)
    q = equilibrium(weightless(elastic, pressure), np.eye(13)[:, 1:])
    radius = SHELL.radius * inflated(pressure)
    assert SHELL.radius + q[1] == pytest.approx(radius, rel=1e-10)
    assert np.abs(q[[0, *range(2, 13)]]).max() < 1e-10
    tension = np.array(elastic.resultants(q))
    assert tension == pytest.approx(np.full_like(tension, pressure * SHELL.radius / 2 * inflated(pressure)), rel=1e-9)


def test_trapped_gas_follows_the_adiabatic_law():
    q = 0.2 * np.eye(13)[1]
    loaded = weightless(complete(6), 3000.0, GAS)
    assert loaded.pressure(0 * q) == pytest.approx(3000.0, rel=1e-9)
    assert loaded.pressure(q) == pytest.approx(104325.0 * (2.0 / 2.2) ** 4.2 - 101325.0, rel=1e-11)
    expected = 1.4 * 104325.0 * (2.0 / 2.2) ** 4.2 / (4 / 3 * np.pi * 2.2**3) * (4 * np.pi * 2.2**2) ** 2
    assert loaded.gas_stiffness(q)[1, 1] == pytest.approx(expected, rel=1e-11)
    free = weightless(complete(6), 3000.0)
    assert equilibrium(loaded, np.eye(13)[:, 1:])[1] < 0.3 * equilibrium(free, np.eye(13)[:, 1:])[1]


@pytest.mark.parametrize("gas", [None, GAS])
def test_prestress_stiffness_is_the_first_order_change_of_the_tangent(gas):
    """Uniform pressure; what remains beyond the change of the material moduli is of second order in the load."""
    elastic, zero = complete(8), np.zeros(17)

    def rest(factor):
        loaded = weightless(elastic, factor * 50.0, gas)
        q = equilibrium(loaded, np.eye(17)[:, 1:])
        without_load = loaded.unloaded_stiffness + elastic.material_stiffness(q) - elastic.material_stiffness(zero)
        change = loaded.gas_stiffness(q) - loaded.scaled(0.0).gas_stiffness(zero)
        return np.abs(loaded.stiffness(q) - without_load - change - loaded.prestress_stiffness).max()

    assert 3.9 < rest(2.0) / rest(1.0) < 4.1  # what is left is of second order


# membrane forces of the floating shell


def statics(phi, pressure):
    """Membrane forces of the half submerged sphere from equilibrium alone: pressures and weight, spread evenly."""
    weight = RHO * G * 2 / 3 * np.pi * 8 / (4 * np.pi * 4)

    def outward(at):
        return pressure + RHO * G * 2.0 * np.minimum(np.cos(at), 0.0)

    axial = np.array([
        quad(lambda s: (outward(s) * np.cos(s) - weight) * np.sin(s), 0.0, p, points=[np.pi / 2], epsabs=1e-8)[0]
        for p in phi
    ])  # fmt: skip
    meridional = 2.0 * axial / np.sin(phi) ** 2
    return np.array([meridional, 2.0 * (outward(phi) - weight * np.cos(phi)) - meridional])


def test_membrane_forces_follow_from_statics_away_from_the_waterline():
    """The linear solution carries what equilibrium demands, up to the O(h/r) bending layer at the waterline."""
    phi = np.linspace(0.3, np.pi - 0.3, 25)
    phi = phi[np.abs(phi - np.pi / 2) > 0.4]
    worst = []
    for ratio in (0.02, 0.01):
        shell = dataclasses.replace(SHELL, thickness=ratio * 2.0)
        mass = RHO * 2 / 3 * np.pi * 8
        loaded = floating(complete(60, shell, mass), 9e3)
        worst.append(np.abs(np.array(loaded.linear_resultants(phi)) - statics(phi, 9e3)).max())
    assert worst[1] < 0.02 * np.abs(statics(phi, 9e3)).max()
    assert worst[1] < 0.75 * worst[0]


# buckling


def uniform(ratio, degree=None):
    shell = dataclasses.replace(SHELL, thickness=ratio * SHELL.radius)
    return shell, buckling(weightless(complete(degree or converged_degree(shell), shell), -1.0))


@pytest.mark.parametrize(("ratio", "critical"), [(0.02, 13), (0.005, 25.7)])
def test_uniform_pressure_buckles_at_the_classical_load_and_degree(ratio, critical):
    """Two-sided: the exact energy lies below 2E(h/r)^2/sqrt(3(1-nu^2)) by 0.45 to 0.65 h/r."""
    shell, found = uniform(ratio)
    assert 0.45 * ratio < 1 - found.load_factor / shell.buckling_pressure < 0.65 * ratio
    assert abs(found.degree - critical) <= 1


@pytest.mark.parametrize(("height", "radius"), [(4.0, 2.0), (6.0, 2.0), (3.0, 4 / 1.5), (2.4, 4 / 1.2)])
def test_thin_spheroids_buckle_around_the_axis_where_they_are_flattest(height, radius):
    """Shallow shell of hoop radius R compressed along the meridian by p R/2: it buckles at 2 sqrt(D E h)/R.

    R is largest at the equator of a long spheroid, at the poles of a flat one. The shape that buckles spans a length of
    sqrt(R h), over which R varies: an excess like sqrt(h), extrapolated.
    """

    def excess(ratio):
        sphere = dataclasses.replace(SHELL, thickness=2.0 * ratio)
        shell = dataclasses.replace(sphere, rest=spheroid(2.0, height))
        found = buckling(weightless(complete(int(3.2 / np.sqrt(ratio)) + 12, shell), -1.0))
        return found.load_factor / (sphere.buckling_pressure * (2.0 / radius) ** 2) - 1

    thick, thin = excess(0.01), excess(0.0025)
    assert 2 * thin - thick == pytest.approx(0.0, abs=0.004)


def test_tension_and_no_load_do_not_buckle():
    tension, none = (buckling(weightless(complete(12), pressure)) for pressure in (100.0, 0.0))
    assert tension.load_factor > 100.0  # only breathing at 2C(1+nu)/r, a limit of linear theory
    assert tension.degree == 0
    assert (none.load_factor, none.linear_strain) == (math.inf, 0.0)


@pytest.fixture(scope="module")
def vented(seed):
    return complete_shell(seed.device, seed.centre_height, seed.water, 0.0)


@pytest.mark.parametrize(("pressure", "gas"), [(0.0, None), (8e3, GAS)])
def test_stiffness_becomes_singular_at_the_load_factor(pressure, gas):
    loaded = floating(complete(16, dataclasses.replace(SHELL, thickness=0.08)), pressure, gas, height=0.2)
    zero = np.zeros(33)
    load = loaded.prestress_stiffness + loaded.hydrostatic_stiffness(zero)

    def least(factor):
        stiffness = loaded.elastic.stiffness(zero) + loaded.scaled(factor).gas_stiffness(zero) + factor * load
        return np.linalg.eigvalsh(stiffness).min()

    critical = buckling(loaded).load_factor
    assert least(critical * (1 - 1e-6)) > 0.0 > least(critical * (1 + 1e-6))


def test_buckling_load_does_not_depend_on_the_basis(seed, vented):
    wider = dataclasses.replace(vented, elastic=complete(52))
    full = dataclasses.replace(vented, elastic=ElasticShell(mode_basis(seed.device, "full", 42)))
    assert buckling(wider).load_factor == pytest.approx(buckling(vented).load_factor, rel=1e-4)
    assert buckling(full).load_factor == pytest.approx(buckling(vented).load_factor, rel=1e-8)


def test_nonlinear_path_and_eigenvalue_agree_on_uniform_buckling():
    shell = dataclasses.replace(SHELL, thickness=0.06)
    elastic = complete(22, shell)
    critical = buckling(weightless(elastic, -1.0)).load_factor
    below = equilibrium(weightless(elastic, -0.97 * critical), np.eye(45)[:, 1:])
    assert below[1] == pytest.approx(2.0 * inflated(-0.97 * critical, shell) - 2.0, rel=1e-8)
    with pytest.raises(ConvergenceError, match=r"buckles at 0\.9\d* of its load, into a shape of degree 1\d"):
        equilibrium(weightless(elastic, -1.05 * critical), np.eye(45)[:, 1:])


# internal pressure that makes the shell viable


def test_viable_pressure_of_the_published_shell(seed, vented):
    pressure, found = viable_pressure(seed.device, seed.centre_height, seed.water)
    assert pressure == pytest.approx(16313.0, abs=2.0)
    assert found.load_factor == pytest.approx(1.0, rel=1e-6)
    slightly_less = dataclasses.replace(vented, internal_pressure=0.99 * pressure)
    assert buckling(slightly_less).load_factor < 1.0


def test_viable_pressure_of_thick_and_weak_shells(seed):
    thick = seed.device.model_copy(update={"thickness": 0.08})
    pressure, found = viable_pressure(thick, 0.0, seed.water)
    assert pressure == 0.0
    assert found.load_factor > 1.0
    weak = seed.device.model_copy(update={"young_modulus": 1e4})
    with pytest.raises(ConvergenceError, match=r"no internal pressure keeps a shell of thickness 0\.01 m from"):
        viable_pressure(weak, 0.0, seed.water)


# static equilibrium


@pytest.fixture(scope="module")
def pressurised(seed):
    loaded = floating(ElasticShell(mode_basis(seed.device, "full", 12)), 2e4, height=seed.centre_height)
    return loaded, equilibrium(loaded)


def test_pressurised_shell_floats_in_stable_equilibrium(pressurised, seed):
    loaded, q = pressurised
    assert np.abs(loaded.force(q)).max() < 1e-13 * G * MASS * 10
    shell = DeformedShell(loaded.basis, seed.centre_height, q)
    assert RHO * shell.volume(120) == pytest.approx(MASS, rel=1e-12)
    assert np.linalg.eigvalsh(loaded.stiffness(q)).min() > 0.0
    assert q[0] > 0.0  # inflated, it floats higher


def test_equilibrium_satisfies_the_clamps(pressurised):
    loaded, free = pressurised
    motions = loaded.basis.clamped([0.0])
    q = equilibrium(loaded, motions)
    assert loaded.basis.clamp_rows([0.0]) @ q == pytest.approx([0.0, 0.0], abs=1e-12)
    assert motions.T @ loaded.force(q) == pytest.approx(np.zeros(motions.shape[1]), abs=1e-6)
    assert abs(loaded.basis.pole_radial_displacement[1:] @ free[1:]) > 0.05


@pytest.mark.parametrize("pressure", [3e3, -800.0])
def test_trapped_gas_loses_pressure_as_the_shell_expands(pressure):
    """To first order, gamma p dV/V; a reservoir keeps its pressure."""
    loaded, area, volume = weightless(complete(6), pressure, GAS), 16 * np.pi, 32 / 3 * np.pi
    held = loaded.elastic.stiffness(np.zeros(13))[1, 1] + 1.4 * 101325.0 * area**2 / volume
    left = pressure - 1.4 * 101325.0 * area / volume * (pressure * area / held)
    assert loaded.pressure_inside == pytest.approx(left, rel=1e-10)
    assert weightless(complete(6), pressure).pressure_inside == pressure


# other rest shapes than the sphere ----------------------------------------------------------------------------------


def shaped(rest, pressure, degree, thickness=0.02, modulus=1.5e8, gas=None):
    """A shell of another meridian, half of its height immersed, in all functions to a degree."""
    shell = Shell(rest.radius, thickness, modulus, 0.3, 1100.0, rest)
    return floating(complete(degree, shell, RHO * rest.volume_below(0.0)), pressure, gas)


def test_spheroid_of_equal_axes_rests_as_the_sphere():
    """Closed forms of the sphere against quadrature on curvatures: rest shape, stiffness there, buckling."""
    mass = RHO * 2 / 3 * np.pi * 8
    sphere = floating(complete(24, mass=mass), 16500.0)
    ball = shaped(spheroid(2.0, 4.0), 16500.0, 24, SHELL.thickness, SHELL.young_modulus)
    q = equilibrium(sphere)
    assert np.abs(q).max() > 0.2
    assert equilibrium(ball) == pytest.approx(q, abs=1e-10)
    stiffness = sphere.stiffness(q)
    assert ball.stiffness(q) == pytest.approx(stiffness, abs=1e-9 * np.abs(stiffness).max())
    assert buckling(ball).load_factor == pytest.approx(buckling(sphere).load_factor, rel=1e-8)


@pytest.mark.parametrize(
    ("rest", "apart"), [(spheroid(2.0, 6.0), 1e-3), (spheroid(2.0, 3.0), 1e-3), (capsule(2.0, 12.0), 5e-3)]
)
def test_membrane_forces_of_inflated_shells_are_those_of_equilibrium(rest, apart):
    """N_phi = p r_2/2 and N_theta = p r_2 (1 - r_2/2 r_1) with the radii of curvature: p r/2 and p r of a cylinder.

    Apart by bending, near the junctions of a capsule where N_theta of the membrane jumps.
    """
    inflated = weightless(complete(40, Shell(2.0, 0.005, 1e7, 0.3, 2700.0, rest)), 1e3)
    phi = np.array([0.4, math.pi / 2])
    k_1, k_2 = np.array([rest.curvatures(angle) for angle in phi]).T
    meridional, hoop = inflated.linear_resultants(phi)
    assert meridional == pytest.approx(1e3 / (2 * k_2), rel=apart)
    assert hoop == pytest.approx(1e3 / k_2 * (1 - k_1 / (2 * k_2)), rel=apart)


@pytest.mark.parametrize("gas", [None, GAS])
@pytest.mark.parametrize("rest", [spheroid(2.0, 6.0), capsule(2.0, 2.0)])
def test_force_and_stiffness_of_any_meridian_are_derivatives_of_the_energy(rest, gas):
    loaded = shaped(rest, 2e4, 5, gas=gas)
    q = 0.02 * np.sin(1.7 * np.arange(len(loaded.basis.labels)) + 0.4)
    momentum = loaded.basis.integrated("mass")[0]

    def energy(q):
        """The wall's, the pressure's and the weight's, which hangs evenly from the wall, and the water's over its depth."""
        water = 0.0
        for phi, weight in DeformedShell(loaded.basis, 0.0, q)._wet_points(200):
            at = DeformedShell(loaded.basis, 0.0, q).meridian(phi)
            water += np.pi * RHO * G * (at.x**2 * at.z * at.dz) @ weight
        hung = loaded.basis.total_mass * G * momentum @ q / momentum[0]
        return loaded.elastic.energy(q) + loaded.contents_energy(q) + water + hung

    force, stiffness = loaded.force_and_stiffness(q)
    assert force == pytest.approx(-derivative(energy, q), abs=1e-7 * np.abs(force).max())
    assert stiffness == pytest.approx(-derivative(loaded.force, q), abs=1e-7 * np.abs(stiffness).max())


def test_capsule_rests_alike_in_natural_modes_and_in_plain_functions():
    """Of the same degree both span the same displacements; modes have no momentum, plain functions have."""
    plain = shaped(capsule(2.0, 2.0), 2.5e4, 8)
    shell, mass = plain.basis.shell, plain.basis.total_mass
    modes = floating(ElasticShell(ModeBasis(shell, natural_shapes(shell, 8), mass, bending=True)), 2.5e4)
    phi = np.linspace(0.1, 3.0, 9)
    one, other = (DeformedShell(each.basis, 0.0, equilibrium(each)).curve(phi) for each in (plain, modes))
    assert one.x == pytest.approx(other.x, abs=1e-9)
    assert one.z == pytest.approx(other.z, abs=1e-9)
    assert np.abs(one.x - shell.at_rest(phi).x).max() > 1e-2


def test_pressure_that_carries_a_spheroid_counts_its_lobes(seed):
    """Under still water and weight: lobes need more pressure than axisymmetric shapes, and there the load factor is 1."""
    given = {"shape": {"spheroid": {"height": 5.0}}, "thickness": 0.03, "young_modulus": 2e7, "mass": 2.1e4}
    device = seed.device.model_validate(seed.device.model_dump() | given)
    height = -(device.meridian.lowest + device.meridian.draft_of(2.1e4 / RHO))
    lobes = lambda loaded: LobedShell.of(loaded).pencils()  # noqa: E731
    without, pressure = (viable_pressure(device, height, seed.water, *more)[0] for more in ((), (lobes,)))
    assert pressure > without
    assert with_lobes(complete_shell(device, height, seed.water, pressure)).load_factor == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize(
    "meridian", [spheroid(2.0, 3.0), spheroid(2.0, 6.0), capsule(2.0, 1.0)], ids=["flat", "long", "capsule"]
)
def test_area_volume_and_linear_stiffness_of_other_meridians(meridian):
    shell = Shell(2.0, 0.05, 10e6, 0.3, 2700.0, meridian)
    basis = ModeBasis(shell, natural_shapes(shell, 4), 3000.0, bending=True)
    elastic, q = ElasticShell(basis), np.zeros(len(basis.labels))
    colatitude, area = elastic.rings
    assert area.sum() == pytest.approx(meridian.area, rel=1e-11)
    assert area @ shell.at_rest(colatitude).z == pytest.approx(0.0, abs=1e-9)
    assert elastic.volume(q) == pytest.approx(meridian.volume, rel=1e-12)
    stiffness = elastic.stiffness(q)
    np.testing.assert_allclose(stiffness, basis.stiffness, atol=1e-9 * np.abs(stiffness).max())
    (along, around), nu = curvature_shapes(basis, colatitude), shell.poisson_ratio
    bending = along @ (area * (along + nu * around)).T + around @ (area * (around + nu * along)).T
    bending *= shell.bending_stiffness
    np.testing.assert_allclose(bending[1:, 1:], basis.integrated("bending")[1:, 1:], atol=1e-6)


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.0)], ids=["sphere", "capsule"])
def test_geometric_stiffness_is_the_work_of_membrane_forces_on_second_order_strains(meridian):
    shell = Shell(2.0, 0.01, 1e7, 0.3, 2700.0, meridian)
    elastic = ElasticShell(ModeBasis(shell, shell_modes(shell, "full", 4), 1e4, bending=True))
    colatitude, area = elastic.rings
    along, around = 3.0 + np.cos(colatitude), -2.0 + np.sin(colatitude) ** 2
    stiffness = elastic.geometric_stiffness(along, around)

    def work(q):
        meridional, hoop = elastic.strains(q)
        return float(area @ (along * meridional + around * hoop))

    random = np.random.default_rng(6)
    for q in 0.1 * random.normal(size=(5, len(elastic.basis.labels))):
        assert work(q) + work(-q) == pytest.approx(q @ stiffness @ q, rel=1e-10)
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-12 * np.abs(stiffness).max())
