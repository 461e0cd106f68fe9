"""The elastic shell by itself; its derivatives, statics and buckling are in `test_loaded`."""

import math
from dataclasses import replace

import numpy as np
import pytest
from shell.test_sphere import STIFFER, STRETCH, larger

from vsb.shell.deformed import enclosed
from vsb.shell.elastic import ElasticShell, converged_degree
from vsb.shell.mode import natural_shapes, scaled
from vsb.shell.modes import ModeBasis, mode_basis, shell_modes
from vsb.shell.sphere import Shell
from vsb.study.meridian import capsule, spheroid


@pytest.fixture(scope="module")
def elastic(seed):
    return ElasticShell(mode_basis(seed.device, "membrane", 6))


def test_a_sphere_that_breathes_grows_by_its_area(elastic, seed):
    r, q = seed.device.radius, np.zeros(len(elastic.basis.labels))
    assert elastic.volume(q) == pytest.approx(4 / 3 * np.pi * r**3, rel=1e-13)
    at = elastic.basis.labels.index("Membrane0")
    assert elastic.volume_gradient(q)[at] == pytest.approx(4 * np.pi * r**2, rel=1e-13)
    _, area = elastic.rings
    assert area.sum() == pytest.approx(4 * np.pi * r**2, rel=1e-13)


def test_shapes_are_tabulated_once_for_all_materials_and_for_no_other_shapes(elastic, seed):
    stiffer = ElasticShell(mode_basis(seed.device.model_copy(update={"young_modulus": 1e9}), "membrane", 6))
    heavier = ElasticShell(replace(elastic.basis, total_mass=1.0, beta=0.0))
    finer = ElasticShell(mode_basis(seed.device, "membrane", 7))
    assert stiffer._tables is elastic._tables is heavier._tables
    assert finer._tables is not elastic._tables
    q = np.linspace(0.0, 0.01, len(elastic.basis.labels))
    assert stiffer.energy(q) == pytest.approx(100 * elastic.energy(q), rel=1e-12)


@pytest.mark.parametrize("thickness", [0.01, 0.15])
def test_shapes_of_one_degree_share_its_bending_and_those_of_two_have_none(seed, thickness):
    """Curvatures hold V - U alone: of two shapes of a degree the matrix has rank one, and is that of their sum."""
    basis = mode_basis(seed.device.model_copy(update={"thickness": thickness}), "full", 4)
    bending, degrees = ElasticShell(basis).bending, np.array(basis.degrees)
    for n in range(2, 5):
        first, second = np.flatnonzero(degrees == n)
        shape = [basis.shapes[i].radial - basis.shapes[i].meridional for i in (first, second)]
        assert bending[first, second] == pytest.approx(bending[second, first], rel=1e-12)
        assert bending[first, second] * shape[0] == pytest.approx(bending[first, first] * shape[1], rel=1e-12)
        assert bending[first, second] * shape[1] == pytest.approx(bending[second, second] * shape[0], rel=1e-12)
    assert not bending[degrees[:, None] != degrees].any()


@pytest.mark.parametrize(("thickness", "degree"), [(0.01, 42), (0.1, 40), (0.0001, 412)])
def test_degrees_that_resolve_buckling_grow_with_slenderness(thickness, degree):
    """1.6 sqrt(r/h) [12 (1 - nu^2)]^(1/4), at least 40."""
    shell = Shell(radius=2.0, thickness=thickness, young_modulus=1e7, poisson_ratio=0.3, density=2700.0)
    assert converged_degree(shell) == degree


@pytest.mark.parametrize(
    "meridian", [spheroid(2.0, 3.0), spheroid(2.0, 6.0), capsule(2.0, 1.0)], ids=["flat", "long", "capsule"]
)
def test_a_shell_of_another_meridian_has_its_area_volume_and_linear_stiffness(meridian):
    """By its own quadrature; its bending is that of the curvatures of all degrees together."""
    shell = Shell(2.0, 0.05, 10e6, 0.3, 2700.0, meridian)
    basis = ModeBasis(shell, natural_shapes(shell, 4), 3000.0, bending=True)
    elastic, q = ElasticShell(basis), np.zeros(len(basis.labels))
    colatitude, area = elastic.rings
    assert area.sum() == pytest.approx(meridian.area, rel=1e-11)
    assert area @ shell.at_rest(colatitude).z == pytest.approx(0.0, abs=1e-9)
    assert elastic.volume(q) == pytest.approx(meridian.volume, rel=1e-12)
    stiffness = elastic.stiffness(q)
    np.testing.assert_allclose(stiffness, basis.stiffness, atol=1e-9 * np.abs(stiffness).max())
    np.testing.assert_allclose(elastic.bending[1:, 1:], basis.integrated("bending")[1:, 1:], atol=1e-6)


@pytest.mark.parametrize("meridian", [None, spheroid(2.0, 6.0), capsule(2.0, 1.0)], ids=["sphere", "long", "capsule"])
def test_volume_by_fewest_points_is_that_by_many_and_its_first_order_the_gradient(meridian):
    """The meridian's own turns are beside those of the shapes: a polynomial of cos phi all the same."""
    shell = Shell(2.0, 0.05, 10e6, 0.3, 2700.0, meridian)
    modes = mode_basis_of(shell)
    basis = ModeBasis(shell, modes, 3000.0, bending=True)
    q = 0.1 * np.cos(np.arange(len(basis.labels)) + 0.3)
    least, most = (enclosed(basis, q[None], points) for points in (0, 400))
    assert least[0] == pytest.approx(most[0], rel=1e-13)
    elastic = ElasticShell(basis)
    assert elastic.volume(q) == pytest.approx(float(most[0][0]), rel=1e-13)
    step = 1e-30j
    along = np.imag(elastic.volume(q + step * np.ones(len(q)))) / 1e-30
    assert elastic.volume_gradient(q).sum() == pytest.approx(along, rel=1e-11)


def mode_basis_of(shell):
    """Shapes up to the second degree."""
    return (
        natural_shapes(shell, 2) if shell.rest else (scaled("Membrane2", 2, 1.0, 0.3), scaled("Bending2", 2, 1.0, -0.6))
    )


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.0)], ids=["sphere", "capsule"])
def test_a_larger_shell_bent_alike_holds_energy_and_volume_by_its_size(meridian):
    """Strains are the same; energy goes with E r^3, its derivatives and the volume's with one power less each."""
    shell = Shell(2.0, 0.05, 10e6, 0.3, 2700.0, meridian)
    modes = natural_shapes(shell, 3) if meridian else shell_modes(shell, "full", 3)
    small, large = (ElasticShell(ModeBasis(each, modes, 3000.0, bending=True)) for each in (shell, larger(shell)))
    q = 0.05 * np.sin(1.4 * np.arange(len(modes) + 1) + 0.5)
    for name, factor in (
        ("energy", STIFFER * STRETCH**3),
        ("force", STIFFER * STRETCH**2),
        ("material_stiffness", STIFFER * STRETCH),
        ("stiffness", STIFFER * STRETCH),
        ("volume", STRETCH**3),
        ("volume_gradient", STRETCH**2),
        ("volume_hessian", STRETCH),
        ("resultants", STIFFER * STRETCH),
        ("strains", 1.0),
    ):
        found, expected = np.asarray(getattr(large, name)(STRETCH * q)), factor * np.asarray(getattr(small, name)(q))
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max(), err_msg=name)
    forces = 3.0 + np.cos(small.rings[0]), 2.0 - np.cos(small.rings[0])
    found, expected = large.geometric_stiffness(*forces), small.geometric_stiffness(*forces)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(large.rings[1], STRETCH**2 * small.rings[1], rtol=1e-12)
    phi = np.array([0.4, 1.3, 2.5])
    np.testing.assert_allclose(
        large.resultants(STRETCH * q, phi), STIFFER * STRETCH * np.array(small.resultants(q, phi))
    )


@pytest.mark.parametrize(("thickness", "nu"), [(0.01, -0.9), (0.005, 0.0), (0.005, 0.45), (0.001, -0.6)])
@pytest.mark.parametrize("size", [1.0, 3.5])
def test_degrees_that_resolve_buckling_go_with_slenderness_and_poissons_ratio(thickness, nu, size):
    shell = Shell(2.0 * size, thickness * size, 1e7, nu, 2700.0)
    degree = 1.6 * (2.0 / thickness) ** 0.5 * (12 * (1 - nu**2)) ** 0.25
    assert converged_degree(shell) == max(40, math.ceil(degree))


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.0)], ids=["sphere", "capsule"])
def test_membrane_forces_stiffen_by_what_they_do_along_strains_of_second_order(meridian):
    """Their work along q and back is q K q: of forces that differ along and around, and from place to place."""
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


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.0)], ids=["sphere", "capsule"])
def test_force_stiffness_and_what_swells_are_derivatives_of_energy_and_volume(meridian):
    """Of a strongly bent shell, by central differences; the energy is of forces and strains at each place."""
    shell = Shell(2.0, 0.05, 1e7, 0.3, 2700.0, meridian)
    elastic = ElasticShell(ModeBasis(shell, shell_modes(shell, "full", 3), 1e4, bending=True))
    count, step = len(elastic.basis.labels), 1e-4
    q = 0.08 * np.cos(1.7 * np.arange(count) + 0.4)

    def slope(function):
        return np.array([(function(q + step * e) - function(q - step * e)) / (2 * step) for e in np.eye(count)])

    for found, expected in (
        (elastic.force(q), -slope(elastic.energy)),
        (elastic.stiffness(q), -slope(elastic.force)),
        (elastic.volume_gradient(q), slope(elastic.volume)),
        (elastic.volume_hessian(q), slope(elastic.volume_gradient)),
    ):
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    strains, forces = np.array(elastic.strains(q)), np.array(elastic.resultants(q))
    work = np.sum(strains * forces, axis=0) @ elastic.rings[1] / 2
    assert elastic.energy(q) == pytest.approx(work + q @ elastic.bending @ q / 2, rel=1e-12)
