"""The loaded shell against closed forms, derivatives of an energy written here, statics and the classical theory."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from shell.test_sphere import DENSER, STRETCH, larger

from vsb.errors import ConvergenceError
from vsb.shell.deformed import DeformedShell
from vsb.shell.elastic import ElasticShell, converged_degree
from vsb.shell.loaded import (
    Gas,
    LoadedShell,
    _buckled,
    _newton,
    _pencil,
    _undeformed,
    buckling,
    complete_basis,
    complete_shell,
    equilibrium,
    viable_pressure,
)
from vsb.shell.mode import Mode
from vsb.shell.modes import bending_block, membrane_block, mode_basis
from vsb.shell.sphere import Shell
from vsb.shell.strain import strain_shapes

RHO, G = 1025.0, 9.81
SHELL = Shell(radius=2.0, thickness=0.01, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
MASS = 17170.0
GAS = Gas(adiabatic_index=1.4, atmospheric_pressure=101325.0)
PHI = np.linspace(0.0, np.pi, 181)


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


def complex_step(function, q):
    return np.array([np.imag(function(q + 1e-40j * e)) / 1e-40 for e in np.eye(q.size)])


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


def test_the_water_about_the_undeformed_shell_is_found_once_for_all_materials_and_waters(seed, monkeypatch):
    monkeypatch.setattr(DeformedShell, "hydrostatics", _counted(DeformedShell.hydrostatics, calls := []))
    height, q = 0.123, np.zeros(13)
    for modulus, density in ((1e7, 1025.0), (1e9, 1025.0), (1e9, 1000.0)):
        device = seed.device.model_copy(update={"young_modulus": modulus})
        shell = LoadedShell(ElasticShell(basis := mode_basis(device, "full", 6)), height, density, G)
        apart = DeformedShell(basis, height, q + 1e-300)  # another shape to the cache, the same to the numbers
        assert shell.hydrostatic_stiffness(q) == pytest.approx(apart.hydrostatic_stiffness(density, G, 64), rel=1e-12)
    assert len(calls) == 1 + 3
    LoadedShell(shell.elastic, 0.2, density, G).hydrostatic_stiffness(q)
    assert len(calls) == 1 + 3 + 1


def test_the_water_about_the_undeformed_shell_is_that_of_as_many_degrees_as_it_has(seed):
    """Of 80, by as many points as their products need: twice as many find the same."""
    shell = Shell.of(seed.device)
    loaded = LoadedShell(ElasticShell(complete_basis(shell, 80, seed.device.mass)), 0.2, RHO, G)
    force, stiffness = _undeformed(loaded._of_shapes)
    water, points = loaded._of_shapes._water(np.zeros(len(force)))
    exact = water.hydrostatics(1.0, 1.0, 2 * points)
    assert force == pytest.approx(exact[0], abs=1e-11 * np.abs(exact[0]).max())
    assert stiffness == pytest.approx((exact[1] + exact[1].T) / 2, abs=1e-11 * np.abs(exact[1]).max())


def test_elastic_derivatives_to_round_off(full, bent):
    elastic = ElasticShell(full)
    force, stiffness = complex_step(elastic.energy, bent), complex_step(elastic.force, bent)
    assert -elastic.force(bent) == pytest.approx(force, abs=1e-13 * np.abs(force).max())
    assert -elastic.stiffness(bent) == pytest.approx(stiffness, abs=1e-13 * np.abs(stiffness).max())
    assert elastic.volume_gradient(bent) == pytest.approx(complex_step(elastic.volume, bent), abs=1e-12)
    assert elastic.volume_hessian(bent) == pytest.approx(complex_step(elastic.volume_gradient, bent), abs=1e-12)


@pytest.mark.parametrize("gas", [None, GAS])
@pytest.mark.parametrize("height", [0.3, -2.6])
def test_force_is_minus_the_gradient_of_the_potential(full, bent, gas, height):
    loaded = floating(ElasticShell(full), 5e3, gas, height)
    force = loaded.force(bent)
    assert force == pytest.approx(-derivative(lambda q: potential(loaded, q), bent), abs=1e-9 * np.abs(force).max())


@pytest.mark.parametrize("gas", [None, GAS])
def test_stiffness_is_the_symmetric_hessian_and_the_sum_of_its_parts(full, bent, gas):
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


@pytest.mark.parametrize("degree", [2, 30])
def test_the_water_is_resolved_at_any_degree(degree):
    loaded = floating(complete(degree), 0.0, height=0.4)
    q = 0.1 * np.sin(1.7 * np.arange(2 * degree + 1)) / (1 + np.arange(2 * degree + 1))
    shell = DeformedShell(loaded.basis, 0.4, q)
    water = loaded.force(q) - loaded.elastic.force(q) + G * loaded.basis.inertia[0]
    exact, stiffness = shell.hydrostatic_force(RHO, G, 300), shell.hydrostatic_stiffness(RHO, G, 300)
    assert water == pytest.approx(exact, abs=1e-11 * np.abs(exact).max())
    assert loaded.hydrostatic_stiffness(q) == pytest.approx(stiffness, abs=1e-11 * np.abs(stiffness).max())


@pytest.mark.parametrize("name", ["paper", "membrane", "full"])
def test_the_undeformed_stiffness_is_that_of_the_basis_with_bending(seed, name):
    basis = mode_basis(seed.device, name, 6)
    expected = basis.stiffness.copy()
    if name == "paper":  # the publication leaves bending out; the energy here never does
        for n, mode in enumerate(basis.modes, start=1):
            shape = np.array([mode.radial, mode.meridional])
            expected[n, n] += shape @ bending_block(basis.shell, mode.degree) @ shape
    stiffness = ElasticShell(basis).stiffness(np.zeros(len(basis.labels)))
    assert stiffness == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("degree", [2, 40, 90])
def test_high_degrees_keep_their_accuracy(degree):
    elastic, r = complete(degree), SHELL.radius
    at, lam, scale = np.ix_([-2, -1], [-2, -1]), degree * (degree + 1), np.diag([1.0, 1 / degree])
    zero = np.zeros(len(elastic.basis.labels))
    block = membrane_block(SHELL, degree) + bending_block(SHELL, degree)
    assert elastic.stiffness(zero)[at] == pytest.approx(scale @ block @ scale, rel=1e-11)
    follower = np.array([[2.0, -lam], [-lam, lam]])  # of the volume: 2 v^2 + 2 v div u + u^2, integrated
    volume = 4 * np.pi * r / (2 * degree + 1) * scale @ follower @ scale
    assert elastic.volume_hessian(zero)[at] == pytest.approx(volume, rel=1e-11)
    strained = np.array([[2.0, -lam], [-lam, lam * (lam - 1)]]) + lam * np.array([[1.0, -1.0], [-1.0, 1.0]])
    tension = 2 * np.pi / (2 * degree + 1) * r * scale @ strained @ scale  # N = p r/2 at p = 1 Pa
    prestress = weightless(elastic, 1.0).prestress_stiffness[at]
    assert prestress == pytest.approx(tension - volume, abs=1e-11 * np.abs(tension).max())


@settings(max_examples=20)
@given(st.lists(st.floats(-0.05, 0.05), min_size=12, max_size=12), st.floats(-3.0, 3.0))
def test_rigid_heave_is_free_and_the_volume_is_that_of_the_meridian(full, modal, heave):
    elastic, q = ElasticShell(full), np.array([heave, *modal])
    still = np.array([0.0, *modal])
    assert elastic.energy(q) == pytest.approx(elastic.energy(still), rel=1e-14)
    assert elastic.force(q)[0] == 0.0
    assert abs(elastic.volume_gradient(q)[0]) < 1e-13
    assert not elastic.stiffness(q)[0].any()
    assert not elastic.volume_hessian(q)[0].any()
    assert elastic.volume(q) == pytest.approx(DeformedShell(full, -60.0, q).volume(80), rel=1e-12)
    assert elastic.energy(still) >= 0.0


def test_strains_are_those_of_the_deformed_meridian(full, bent):
    phi, step = PHI[1:-1], 1e-5
    shell = DeformedShell(full, 0.0, bent)
    m, before, after = (shell.meridian(phi + h) for h in (0.0, -step, step))
    arc = np.hypot(after.x - before.x, after.z - before.z) / (2 * step * 2.0)
    meridional, hoop = ElasticShell(full).strains(bent, phi)
    assert meridional == pytest.approx((arc**2 - 1) / 2, abs=1e-8)
    assert hoop == pytest.approx(((m.x / (2.0 * np.sin(phi))) ** 2 - 1) / 2, abs=1e-12)
    poles = np.array(ElasticShell(full).strains(bent, np.array([0.0, np.pi])))
    assert poles[0] == pytest.approx(poles[1], abs=1e-14)


# inflation and gas


def inflated(pressure, shell=SHELL):
    """Stretch of a spherical Green-Lagrange Hookean membrane: stretch - 1/stretch = p r (1 - nu)/(E h)."""
    load = pressure * shell.radius * (1 - shell.poisson_ratio) / (shell.young_modulus * shell.thickness)
    return (load + math.sqrt(load**2 + 4)) / 2


@pytest.mark.parametrize("pressure", [-100.0, 1e3, 2e4, 1e5])
def test_inflation_is_the_closed_form(pressure):
    elastic = complete(6)
    q = equilibrium(weightless(elastic, pressure), np.eye(13)[:, 1:])
    radius = SHELL.radius * inflated(pressure)
    assert SHELL.radius + q[1] == pytest.approx(radius, rel=1e-10)
    assert np.abs(q[[0, *range(2, 13)]]).max() < 1e-10
    tension = np.array(elastic.resultants(q))
    assert tension == pytest.approx(np.full_like(tension, pressure * SHELL.radius / 2 * inflated(pressure)), rel=1e-9)


def test_breathing_stiffness_of_a_uniform_pressure():
    loaded = weightless(complete(6), 700.0)
    breathing = np.eye(13)[1]
    follower = breathing @ loaded.pressure_stiffness(np.zeros(13)) @ breathing
    assert follower == pytest.approx(-8 * np.pi * SHELL.radius * 700.0, rel=1e-12)
    assert breathing @ loaded.prestress_stiffness @ breathing == pytest.approx(-4 * np.pi * 2.0 * 700.0, rel=1e-11)


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
def test_prestress_is_the_first_order_of_the_tangent_stiffness(gas):
    """Uniform pressure: what `prestress_stiffness` leaves out is the change of the moduli's part, and only that."""
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


def test_membrane_forces_are_statically_determinate():
    """The linear solution carries what equilibrium asks, up to the bending layer at the waterline, O(h/r) away from it."""
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


def test_prestress_belongs_to_the_load_not_to_the_basis(seed):
    narrow, wide = (mode_basis(seed.device, "full", n) for n in (4, 9))
    pick = [wide.labels.index(label) for label in narrow.labels]
    few, many = (floating(ElasticShell(basis), 2e4).prestress_stiffness for basis in (narrow, wide))
    assert few == pytest.approx(many[np.ix_(pick, pick)], abs=1e-10 * np.abs(few).max())
    assert few == pytest.approx(few.T, abs=1e-10 * np.abs(few).max())
    assert not few[0].any()


# buckling


def uniform(ratio, degree=None):
    shell = dataclasses.replace(SHELL, thickness=ratio * SHELL.radius)
    return shell, buckling(weightless(complete(degree or converged_degree(shell), shell), -1.0))


@pytest.mark.parametrize(("ratio", "critical"), [(0.05, 8), (0.02, 13), (0.005, 25.7), (0.002, 40.6)])
def test_uniform_pressure_gives_the_classical_load_and_degree(ratio, critical):
    """Two-sided: the exact energy lies below 2E(h/r)^2/sqrt(3(1-nu^2)) by 0.5 to 0.65 h/r, and no more."""
    shell, found = uniform(ratio)
    assert 0.45 * ratio < 1 - found.load_factor / shell.buckling_pressure < 0.65 * ratio
    assert abs(found.degree - critical) <= 1
    assert found.classical_factor == pytest.approx(shell.buckling_pressure, rel=1e-12)


def test_the_seeds_classical_load():
    shell, found = uniform(0.005)
    assert shell.buckling_pressure == pytest.approx(302.61, abs=0.01)
    assert found.load_factor == pytest.approx(301.73, abs=0.01)


def test_tension_never_buckles():
    found = buckling(weightless(complete(12), 100.0))
    assert found.load_factor > 100.0  # only breathing at 2C(1+nu)/r, a limit of linear theory
    assert found.degree == 0
    assert found.classical_factor == math.inf


def test_no_load_no_buckling():
    found = buckling(weightless(complete(12), 0.0))
    assert (found.load_factor, found.classical_factor, found.linear_strain) == (math.inf, math.inf, 0.0)


@pytest.fixture(scope="module")
def vented(seed):
    return complete_shell(seed.device, seed.centre_height, seed.water, 0.0)


def test_the_vented_seed_buckles_under_a_fiftieth_of_its_load(vented):
    found = buckling(vented)
    assert found.load_factor == pytest.approx(0.018667, rel=1e-4)
    assert found.degree == 25
    assert found.classical_factor == pytest.approx(0.01505, rel=1e-3)


def test_the_classical_factor_takes_the_pressure_at_the_keel():
    half_out = buckling(floating(complete(8), 4e3, height=1.0))
    assert half_out.classical_factor == pytest.approx(SHELL.buckling_pressure / (RHO * G * 1.0 - 4e3), rel=1e-12)
    in_the_air = buckling(floating(complete(8), -50.0, height=3.0))
    assert in_the_air.classical_factor == pytest.approx(SHELL.buckling_pressure / 50.0, rel=1e-12)
    filled = floating(complete(8), 4e3, Gas(adiabatic_index=1.4), height=1.0)
    expected = SHELL.buckling_pressure / (RHO * G * 1.0 - filled.pressure_inside)
    assert buckling(filled).classical_factor == pytest.approx(expected, rel=1e-12)
    assert not math.isclose(filled.pressure_inside, 4e3, rel_tol=0.1)


def test_the_pressure_that_carries_a_shell_of_gas_is_that_before_it_expands(seed):
    """As much inside at rest as where it is constant, but for what the gas itself stiffens; half of it is not enough."""
    vented, _ = viable_pressure(seed.device, seed.centre_height, seed.water)
    filled = seed.device.model_copy(update={"gas": Gas(adiabatic_index=1.4)})
    pressure, found = viable_pressure(filled, seed.centre_height, seed.water)
    assert found.load_factor == pytest.approx(1.0, rel=1e-6)
    shell = complete_shell(filled, seed.centre_height, seed.water, pressure)
    assert shell.pressure_inside == pytest.approx(vented, rel=1e-3)
    assert pressure > 3 * vented
    assert buckling(dataclasses.replace(shell, internal_pressure=0.99 * pressure)).load_factor < 1.0


@pytest.mark.parametrize("gas", [None, GAS])
@pytest.mark.parametrize("pressure", [0.0, 8e3])
def test_the_stiffness_is_singular_at_the_load_factor_with_heave_free(pressure, gas):
    """Trapped gas is as stiff as the factor's pressure makes it."""
    loaded = floating(complete(16, dataclasses.replace(SHELL, thickness=0.08)), pressure, gas, height=0.2)
    zero = np.zeros(33)
    load = loaded.prestress_stiffness + loaded.hydrostatic_stiffness(zero)

    def least(factor):
        stiffness = loaded.elastic.stiffness(zero) + loaded.scaled(factor).gas_stiffness(zero) + factor * load
        return np.linalg.eigvalsh(stiffness).min()

    critical = buckling(loaded).load_factor
    assert least(critical * (1 - 1e-6)) > 0.0 > least(critical * (1 + 1e-6))


def test_the_buckling_load_does_not_depend_on_the_basis(seed, vented):
    wider = dataclasses.replace(vented, elastic=complete(52))
    full = dataclasses.replace(vented, elastic=ElasticShell(mode_basis(seed.device, "full", 42)))
    assert buckling(wider).load_factor == pytest.approx(buckling(vented).load_factor, rel=1e-4)
    assert buckling(full).load_factor == pytest.approx(buckling(vented).load_factor, rel=1e-8)


def test_the_nonlinear_path_of_the_vented_seed_ends_where_computed(seed):
    loaded = floating(complete(28), 0.0, height=seed.centre_height)
    message = (
        r"buckles at 0\.01[78]\d* of its load, into a shape of degree 2[456]; raise device\.internal_pressure "
        r"\(now 0 Pa, gauge\) or device\.thickness \(now 0\.01 m\)"
    )
    with pytest.raises(ConvergenceError, match=message):
        equilibrium(loaded)


def test_a_shell_that_stands_no_part_of_its_load_is_told_so():
    """Half out of the water it does not float: the first steps fail however short, and the unloaded shell is looked at."""
    message = r"buckles at 0 of its load, into a shape of degree \d+; raise device\.internal_pressure \(now 0 Pa"
    with pytest.raises(ConvergenceError, match=message):
        equilibrium(floating(complete(16), 0.0, height=1.0))


def test_uniform_buckling_on_the_nonlinear_path():
    """Newton's path stops within a step of the computed load although it is scanned from below."""
    shell = dataclasses.replace(SHELL, thickness=0.06)
    elastic = complete(22, shell)
    critical = buckling(weightless(elastic, -1.0)).load_factor
    below = equilibrium(weightless(elastic, -0.97 * critical), np.eye(45)[:, 1:])
    assert below[1] == pytest.approx(2.0 * inflated(-0.97 * critical, shell) - 2.0, rel=1e-8)
    with pytest.raises(ConvergenceError, match=r"buckles at 0\.9\d* of its load, into a shape of degree 1\d"):
        equilibrium(weightless(elastic, -1.05 * critical), np.eye(45)[:, 1:])


# internal pressure that makes the shell viable


def test_viable_pressure_of_the_seed(seed, vented):
    pressure, found = viable_pressure(seed.device, seed.centre_height, seed.water)
    assert pressure == pytest.approx(16313.0, abs=2.0)
    assert found.load_factor == pytest.approx(1.0, rel=1e-6)
    assert found.linear_strain == pytest.approx(0.196, abs=1e-3)
    slightly_less = dataclasses.replace(vented, internal_pressure=0.99 * pressure)
    assert buckling(slightly_less).load_factor < 1.0


def test_viability_of_other_shells(seed):
    thick = seed.device.model_copy(update={"thickness": 0.08})
    pressure, found = viable_pressure(thick, 0.0, seed.water)
    assert pressure == 0.0
    assert found.load_factor > 1.0
    more, held = viable_pressure(thick, 0.0, seed.water, margin=2.0)
    assert more > 0.0
    assert held.load_factor == pytest.approx(2.0, rel=1e-6)
    weak = seed.device.model_copy(update={"young_modulus": 1e4})
    with pytest.raises(
        ConvergenceError, match=r"no internal pressure keeps a shell of thickness 0\.01 m from buckling"
    ):
        viable_pressure(weak, 0.0, seed.water)


def test_a_light_soft_shell_is_viable_just_below_the_pressure_it_breathes_at(seed):
    """With little of it in the water, what buckles is held at nine tenths of 2 C (1 + nu)/r, at which breathing fails."""
    soft = seed.device.model_copy(update={"young_modulus": 2.6e4, "thickness": 0.1})
    pressure, found = viable_pressure(soft, 1.6, seed.water)
    stretch = soft.young_modulus * soft.thickness / (1 - soft.poisson_ratio**2)
    assert 0.85 < pressure / (2 * stretch * (1 + soft.poisson_ratio) / soft.radius) < 0.95
    assert found.load_factor == pytest.approx(1.0, rel=1e-6)
    assert buckling(complete_shell(soft, 1.6, seed.water, 0.99 * pressure)).load_factor < 1.0


def test_a_margin_no_pressure_reaches_is_refused_and_one_just_below_is_met(seed, vented):
    """The largest load factor over pressure, each a buckling problem of its own."""
    factors = {}

    def lacking(pressure):
        factors[pressure] = buckling(dataclasses.replace(vented, internal_pressure=float(pressure))).load_factor
        return -factors[pressure]

    best = -minimize_scalar(lacking, bounds=(1.2e4, 1.2e5), method="bounded", options={"xatol": 30.0}).fun
    assert best > 1.05 * min(factors.values())
    _, held = viable_pressure(seed.device, seed.centre_height, seed.water, margin=0.9999 * best)
    assert held.load_factor == pytest.approx(0.9999 * best, rel=1e-6)
    with pytest.raises(ConvergenceError, match=r"from buckling under [\d.]+ times its load"):
        viable_pressure(seed.device, seed.centre_height, seed.water, margin=1.0001 * best)


# static equilibrium


@pytest.fixture(scope="module")
def pressurised(seed):
    loaded = floating(ElasticShell(mode_basis(seed.device, "full", 12)), 2e4, height=seed.centre_height)
    return loaded, equilibrium(loaded)


def test_the_pressurised_seed_floats(pressurised, seed):
    loaded, q = pressurised
    assert np.abs(loaded.force(q)).max() < 1e-13 * G * MASS * 10
    shell = DeformedShell(loaded.basis, seed.centre_height, q)
    assert RHO * shell.volume(120) == pytest.approx(MASS, rel=1e-12)
    assert np.linalg.eigvalsh(loaded.stiffness(q)).min() > 0.0
    assert q[0] == pytest.approx(0.36488, abs=1e-4)  # inflated, it floats higher
    largest = np.abs(loaded.elastic.strains(q, PHI)).max()
    assert largest == pytest.approx(0.1767, abs=1e-3)


def test_a_step_of_newton_is_one_meridian_in_the_water(pressurised, monkeypatch):
    calls = []
    _undeformed.cache_clear()  # the first step is about the undeformed shell, whose water is kept
    monkeypatch.setattr(DeformedShell, "hydrostatics", _counted(DeformedShell.hydrostatics, calls))
    monkeypatch.setattr(LoadedShell, "force_and_stiffness", _counted(LoadedShell.force_and_stiffness, calls))
    equilibrium(pressurised[0])
    assert calls.count("hydrostatics") == calls.count("force_and_stiffness") == len(calls) / 2 > 4


def _counted(function, calls):
    """The function, whose name goes to a list with every call."""

    def counted(*args):
        calls.append(function.__name__)
        return function(*args)

    return counted


def test_newton_converges_quadratically(pressurised):
    loaded, exact = pressurised
    q, errors = exact + 0.02 * np.cos(np.arange(exact.size)), []
    for _ in range(3):
        q = q + np.linalg.solve(loaded.stiffness(q), loaded.force(q))
        errors.append(np.abs(q - exact).max())
    assert errors[2] > 1e-12  # above round-off, so the order can be seen
    assert 1.7 < math.log(errors[2] / errors[1]) / math.log(errors[1] / errors[0]) < 2.5


def test_the_answer_does_not_depend_on_the_degree(pressurised, seed):
    loaded, q = pressurised
    heave = [
        equilibrium(dataclasses.replace(loaded, elastic=ElasticShell(mode_basis(seed.device, "full", n))))[0]
        for n in (3, 6, 24)
    ]
    assert abs(q[0] - heave[2]) < 0.3 * abs(heave[1] - heave[2]) < 0.3 * abs(heave[0] - heave[2])
    assert q[0] == pytest.approx(heave[2], rel=1e-4)


def test_a_stiff_shell_follows_linear_statics():
    """The error of the linear solution is of second order in load over stiffness."""

    def error(modulus):
        loaded = floating(complete(6, dataclasses.replace(SHELL, young_modulus=modulus)), 3e3)
        zero = np.zeros(13)
        linear = np.linalg.solve(loaded.unloaded_stiffness + loaded.hydrostatic_stiffness(zero), loaded.force(zero))
        return np.abs(equilibrium(loaded) - linear).max()

    order = math.log2(error(4e9) / error(8e9))
    assert 1.9 < order < 2.1


def test_clamps_hold(pressurised):
    loaded, free = pressurised
    motions = loaded.basis.clamped([0.0])
    q = equilibrium(loaded, motions)
    assert loaded.basis.clamp_rows([0.0]) @ q == pytest.approx([0.0, 0.0], abs=1e-12)
    assert motions.T @ loaded.force(q) == pytest.approx(np.zeros(motions.shape[1]), abs=1e-6)
    assert abs(loaded.basis.pole_radial_displacement[1:] @ free[1:]) > 0.05


def test_the_pressure_that_makes_a_shell_viable_does_not_know_what_is_inside_it_now(seed, monkeypatch):
    monkeypatch.setattr("vsb.shell.loaded.converged_degree", lambda shell: 10)
    found = []
    for inside in (0.0, 7e3, -2e3):
        device = seed.device.model_copy(update={"internal_pressure": inside})
        pressure, held = viable_pressure(device, 0.3, seed.water)
        found.append((pressure, held.load_factor))
    assert found[0] == found[1] == found[2]
    assert found[0][0] > 1e3


@pytest.mark.parametrize(("pressure", "thickness"), [(3e3, 0.01), (-400.0, 0.02)])
def test_a_shell_that_buckles_is_told_what_is_inside_it_and_how_thick_it_is(pressure, thickness):
    loaded = floating(complete(12, dataclasses.replace(SHELL, thickness=thickness)), pressure)
    told = rf"internal_pressure \(now {pressure:g} Pa, gauge\) or device\.thickness \(now {thickness:g} m\)$"
    with pytest.raises(ConvergenceError, match=told):
        equilibrium(loaded)


@pytest.mark.parametrize("density", [700.0, 1300.0])
def test_the_classical_factor_is_that_of_the_water_there(density):
    loaded = dataclasses.replace(floating(complete(8), 4e3, height=0.5), water_density=density, gravity=9.6)
    expected = SHELL.buckling_pressure / (density * 9.6 * 1.5 - 4e3)
    assert buckling(loaded).classical_factor == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("stretched", [0, 1], ids=["along", "around"])
def test_the_largest_linear_strain_is_of_either_direction_and_either_sign(stretched, sign):
    """Of amplitudes to first order of the load that strain the shell a tenth more in one direction than in the other."""
    loaded, random = floating(complete(6), 100.0), np.random.default_rng(3)
    shapes = strain_shapes(loaded.basis, loaded.elastic.rings[0])[:2]
    q, largest = np.zeros(13), [0.0, 0.0]
    while not largest[stretched] > 1.1 * largest[1 - stretched]:
        q = np.append(0.0, random.normal(size=12))
        largest = [np.abs(q @ shape).max() for shape in shapes]
    strain = q @ shapes[stretched]
    loaded.__dict__["first_order"] = sign * np.sign(strain[np.abs(strain).argmax()]) * q
    assert buckling(loaded).linear_strain == pytest.approx(largest[stretched], rel=1e-12)


def test_a_shell_of_gas_that_can_only_breathe_gives_way_where_all_that_holds_it_is_gone():
    """Its membrane, the gas at the pressure of that load, and what the pressure itself does, which grows with the load."""
    loaded, pressure = weightless(complete(1), -2e3, GAS), -2e3
    area, volume = 16 * np.pi, 32 / 3 * np.pi
    membrane = loaded.elastic.stiffness(np.zeros(3))[1, 1]
    held = membrane + 1.4 * 101325.0 * area**2 / volume
    lost = -(1.4 * pressure * area**2 / volume + loaded.prestress_stiffness[1, 1])
    found = buckling(loaded)
    assert found.load_factor == pytest.approx(held / lost, rel=1e-11)
    assert found.degree == 0


@pytest.mark.parametrize("pressure", [3e3, -800.0])
def test_the_pressure_inside_at_rest_is_less_by_what_the_gas_gives_as_the_shell_expands(pressure):
    """To first order: of the outer pressure, gamma dV/V; a reservoir's stays."""
    loaded, area, volume = weightless(complete(6), pressure, GAS), 16 * np.pi, 32 / 3 * np.pi
    held = loaded.elastic.stiffness(np.zeros(13))[1, 1] + 1.4 * 101325.0 * area**2 / volume
    left = pressure - 1.4 * 101325.0 * area / volume * (pressure * area / held)
    assert loaded.pressure_inside == pytest.approx(left, rel=1e-10)
    assert weightless(complete(6), pressure).pressure_inside == pressure


# other sizes


@pytest.mark.parametrize("gas", [None, GAS])
def test_a_larger_shell_in_as_much_lighter_water_rests_buckles_and_is_saved_alike(seed, gas):
    """Of a material as much stiffer as pressures grow, rho g r: all strains are the same, forces go with the load."""
    heavier = DENSER * STRETCH
    thick = dataclasses.replace(SHELL, thickness=0.08, young_modulus=3e7)
    kinds, degree = (thick, larger(thick, heavier)), 10
    outside = None if gas is None else Gas(adiabatic_index=1.4, atmospheric_pressure=heavier * 101325.0)
    small = LoadedShell(complete(degree, kinds[0], 6000.0), 1.0, 1000.0, 9.7, 1500.0, gas)
    large = LoadedShell(
        complete(degree, kinds[1], 6000.0 * DENSER * STRETCH**3),
        STRETCH,
        DENSER * 1000.0,
        9.7,
        heavier * 1500.0,
        outside,
    )
    rest = equilibrium(small)
    assert equilibrium(large) == pytest.approx(STRETCH * rest, abs=1e-8)
    assert np.abs(rest[1:]).max() > 1e-3
    zero, load, area, weight = np.zeros(2 * degree + 1), heavier * STRETCH**2, heavier * STRETCH, 6000.0 * 9.7
    for q in (zero, rest):
        for name, factor in (
            ("pressure", heavier),
            ("force", load),
            ("stiffness", area),
            ("pressure_stiffness", area),
            ("gas_stiffness", area),
            ("hydrostatic_stiffness", area),
        ):
            found, expected = getattr(large, name)(STRETCH * q), factor * getattr(small, name)(q)
            round_off = 1e-10 * load * weight if name == "force" else 0.0  # at rest there is none else
            np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max() + round_off)
    for name, factor in (
        ("pressure_inside", heavier),
        ("first_order", STRETCH),
        ("unloaded_stiffness", area),
        ("prestress_stiffness", area),
    ):
        expected = factor * getattr(small, name)
        np.testing.assert_allclose(getattr(large, name), expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())
    for found, expected in zip(large.linear_resultants(PHI[1:-1]), small.linear_resultants(PHI[1:-1]), strict=True):
        np.testing.assert_allclose(found, area * expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())
    assert dataclasses.astuple(buckling(large)) == pytest.approx(dataclasses.astuple(buckling(small)), rel=1e-8)


def test_the_pressure_that_carries_a_larger_shell_is_as_much_higher(seed, monkeypatch):
    monkeypatch.setattr("vsb.shell.loaded.converged_degree", lambda shell: 12)
    heavier = DENSER * STRETCH
    for gas in (None, {"adiabatic_index": 1.4, "atmospheric_pressure": 101325.0}):
        found = []
        for size, dense, stiff in ((1.0, 1.0, 1.0), (STRETCH, DENSER, heavier)):
            device = seed.device.model_copy(
                update={
                    "radius": 2.0 * size,
                    "thickness": 0.02 * size,
                    "young_modulus": 3e7 * stiff,
                    "density": 2700.0 * dense,
                    "mass": 9000.0 * dense * size**3,
                    "gas": gas and Gas(**{**gas, "atmospheric_pressure": 101325.0 * stiff}),
                }
            )
            water = seed.water.model_copy(update={"density": 1000.0 * dense})
            pressure, held = viable_pressure(device, 0.7 * size, water, 1.3)
            found.append([pressure / stiff, held.load_factor, held.degree, held.classical_factor, held.linear_strain])
        assert found[0][0] > 100.0
        assert found[0][1] == pytest.approx(1.3, rel=1e-6)
        assert found[1] == pytest.approx(found[0], rel=1e-6)


def test_a_step_of_newton_may_be_half_a_radius_and_no_longer():
    """Whatever the radius: a sphere of a gas that breathes alone, pushed from its rest by a pressure that is left out."""
    for radius in (0.5, 6.0):
        shell = Shell(radius, 0.01 * radius, 1e7, 0.3, 2700.0)
        elastic = ElasticShell(complete_basis(shell, 1, 1e3))
        breathing = np.eye(3)[:, 1:2]
        stiffness = elastic.stiffness(np.zeros(3))[1, 1]
        for step, settles in ((0.48, True), (0.52, False)):
            softening = 8 * np.pi * radius  # of the pressure, that follows the surface
            pressure = step * radius * stiffness / (4 * np.pi * radius**2 + step * radius * softening)
            loaded = LoadedShell(elastic, 0.0, 0.0, 0.0, pressure)
            found = _newton(loaded, breathing, np.zeros(3))
            assert (found is not None) is settles, (radius, step)
            if settles:
                assert found[1] + radius == pytest.approx(radius * inflated(pressure, shell), rel=1e-9)


@pytest.mark.parametrize("degree", [1, 2, 5])
def test_a_complete_basis_has_two_functions_of_each_degree_beside_heave(degree):
    """One of degree 0, and of degree 1 one that keeps the momentum of the shell."""
    basis = complete_basis(SHELL, degree, 123.0)
    assert len(basis.labels) == 2 * degree + 1
    assert basis.highest_degree == degree
    assert (basis.total_mass, basis.bending) == (123.0, True)
    assert np.abs(basis.inertia[0, 1:]).max() < 1e-12 * basis.inertia[1, 1]
    assert [(m.label, m.radial, m.meridional) for m in basis.modes[2:4]] == [
        ("Radial2", 1.0, 0.0), ("Meridional2", 0.0, 0.5)
    ][: 2 * (degree > 1)]  # fmt: skip
    assert {mode.label for mode in basis.modes[:2]} == {"Radial0", "Membrane1"}


def test_the_complete_shell_of_a_device_has_its_water_height_gas_and_pressure(seed):
    device = seed.device.model_copy(update={"thickness": 0.1, "gas": GAS, "internal_pressure": 700.0})
    water = seed.water.model_copy(update={"density": 900.0, "gravity": 9.7})
    found = complete_shell(device, 0.4, water, 50.0)
    assert (found.centre_height, found.water_density, found.gravity) == (0.4, 900.0, 9.7)
    assert (found.internal_pressure, found.gas) == (50.0, GAS)
    assert found.basis.highest_degree == converged_degree(Shell.of(device)) == 40
    assert (found.basis.total_mass, found.basis.shell) == (device.mass, Shell.of(device))


def test_the_membrane_forces_are_those_of_no_fewer_degrees_than_the_basis_has(seed):
    """More degrees than buckling needs: the forces of the load are those of the basis's own linear solution."""
    loaded = floating(complete(46), 3e3, height=0.3)
    assert converged_degree(SHELL) < 46
    strains = strain_shapes(loaded.basis, PHI[1:-1])
    own = loaded.elastic._hooke(*(loaded.first_order @ strain for strain in strains[:2]))
    for found, expected in zip(loaded.linear_resultants(PHI[1:-1]), own, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("reached", "clamped", "degree"), [(0.6, False, 3), (0.2, False, 2), (0.0, False, 2), (0.6, True, 2)]
)
def test_the_shape_a_shell_buckles_into_is_its_softest_where_it_last_stood(reached, clamped, degree):
    """Relative to what it is unloaded, of the motions clamps allow; the buoy's heave is none, however soft the water."""

    def at(factor):
        lost = {0.001: 0.2, 0.2: 0.2, 0.6: 0.8}[factor]
        return SimpleNamespace(stiffness=lambda q: np.diag([0.01, 80.0, 20.0 * 0.7, 30.0 * (1 - lost)]))

    basis = SimpleNamespace(
        labels=("Heave", "Membrane0", "Membrane2", "Bending3"),
        degrees=(1, 0, 2, 3),
        shell=SimpleNamespace(thickness=0.03),
    )
    unloaded = np.diag([0.0, 100.0, 20.0, 30.0])
    shell = SimpleNamespace(
        scaled=at,
        unloaded_stiffness=unloaded,
        elastic=SimpleNamespace(basis=basis, stiffness=lambda q: unloaded),
        basis=basis,
        internal_pressure=-120.0,
    )
    motions = np.eye(4)[:, :3] if clamped else np.eye(4)
    assert _buckled(shell, motions, np.zeros(4), reached) == (
        f"the shell buckles at {reached:.3g} of its load, into a shape of degree {degree}; raise device.internal_pressure "
        "(now -120 Pa, gauge) or device.thickness (now 0.03 m)"
    )
    assert unloaded[0, 0] == 0.0  # and is left as it was


@pytest.mark.parametrize(("modulus", "height"), [(2.6e4, 1.6), (1e5, 1.2)])
def test_gas_that_leaves_a_shell_as_it_swells_may_be_let_in_at_more_than_it_breathes_at(
    seed, monkeypatch, modulus, height
):
    """2 C (1 + nu)/r would burst it if it stayed; what is left of it once the shell has swollen carries it."""
    monkeypatch.setattr("vsb.shell.loaded.converged_degree", lambda shell: 12)
    soft = seed.device.model_copy(update={"young_modulus": modulus, "thickness": 0.1, "gas": Gas(adiabatic_index=1.4)})
    breathing = 2 * modulus * 0.1 / (1 - soft.poisson_ratio**2) * (1 + soft.poisson_ratio) / soft.radius
    pressure, found = viable_pressure(soft, height, seed.water)
    assert pressure > 10 * breathing
    assert found.load_factor == pytest.approx(1.0, rel=1e-6)
    shell = complete_shell(soft, height, seed.water, pressure)
    assert 0 < shell.pressure_inside < breathing
    assert buckling(dataclasses.replace(shell, internal_pressure=0.99 * pressure)).load_factor < 1.0


def test_a_margin_that_no_pressure_gives_is_told_with_the_shell(seed, monkeypatch):
    monkeypatch.setattr("vsb.shell.loaded.converged_degree", lambda shell: 12)
    weak = seed.device.model_copy(update={"young_modulus": 1e4, "thickness": 0.03})
    told = (
        r"^no internal pressure keeps a shell of thickness 0\.03 m from buckling under 2\.5 times its load; raise "
        r"device\.thickness or device\.young_modulus$"
    )
    with pytest.raises(ConvergenceError, match=told):
        viable_pressure(weak, 0.0, seed.water, margin=2.5)


@pytest.mark.parametrize("degree", [1, 4])
def test_a_mode_with_momentum_along_heave_feels_the_weight(seed, degree):
    """The publication's shape of degree 1 carries some of the shell up; the ballast does not go with it."""
    basis = mode_basis(seed.device, "paper", degree)
    loaded, q = floating(ElasticShell(basis), 700.0, height=0.3), 0.02 * np.cos(np.arange(len(basis.labels)) + 0.2)
    carried = basis.inertia[0, 1:]
    assert np.abs(carried).max() > 0.05 * basis.shell.mass
    force = loaded.force(q)
    expected = -derivative(lambda at: potential(loaded, at), q)
    assert force == pytest.approx(expected, abs=1e-9 * np.abs(force).max())
    weightless_force = dataclasses.replace(loaded, gravity=0.0).force(q)
    dry = dataclasses.replace(loaded, water_density=0.0).force(q)
    assert dry - weightless_force == pytest.approx(-G * basis.inertia[0], abs=1e-9 * G * MASS)


@pytest.mark.parametrize("gas", [None, GAS])
@pytest.mark.parametrize("pressure", [-2e3, 2e3])
def test_a_load_that_stiffens_all_a_shell_can_do_buckles_it_under_no_factor(pressure, gas):
    """Breathing alone, r dN/da = 8 pi r p less: suction stiffens it, pressure takes it away; gas turns that about."""
    basis = dataclasses.replace(complete_basis(SHELL, 1, MASS), modes=(Mode("Radial0", 0, 1.0, 0.0),))
    loaded = weightless(ElasticShell(basis), pressure, gas)
    stiffness, load = (float(each[0, 0]) for each in _pencil(loaded))
    found = buckling(loaded)
    assert found.load_factor == (math.inf if load > 0 else pytest.approx(-stiffness / load, rel=1e-12))
    assert stiffness > 0
    if gas is None:
        assert (load > 0) == (pressure < 0)
