"""The shell of any meridian by quadrature, held to the sphere's closed form and to conical finite elements."""

import numpy as np
import pytest
from scipy.linalg import eigh
from shell.test_sphere import DENSER, STIFFER, STRETCH, larger

from vsb.errors import ConvergenceError
from vsb.shell import ritz
from vsb.shell.curve import curve
from vsb.shell.modes import bending_block, mass_block, membrane_block
from vsb.shell.ritz import heave, matrices, natural_modes
from vsb.shell.sphere import Shell, natural_frequencies
from vsb.study.meridian import RestMeridian, capsule, spheroid

SEED = Shell(radius=2.0, thickness=0.01, young_modulus=10e6, poisson_ratio=0.3, density=2700.0)
OBLATE = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 3.0))
PROLATE = Shell(2.0, 0.05, 10e6, 0.3, 2700.0, spheroid(2.0, 6.0))
CAPSULE = Shell(1.0, 0.02, 10e6, 0.3, 2700.0, capsule(1.0, 1.0))


def _blocks(block, shell, degree):
    """A closed-form matrix of the sphere over radial, then meridional displacements."""
    found = np.zeros((2 * degree + 1, 2 * degree + 1))
    for n in range(degree + 1):
        at = [n, degree + n] if n else [0]
        found[np.ix_(at, at)] = block(shell, n)[: len(at), : len(at)]
    return found


@pytest.mark.parametrize("degree", [1, 6, 20])
def test_the_sphere_is_that_of_the_closed_form(degree):
    for found, block in zip(matrices(SEED, degree), (mass_block, membrane_block, bending_block), strict=True):
        exact = _blocks(block, SEED, degree)
        assert np.abs(found - exact).max() < 1e-11 * np.abs(exact).max()
        size = np.sqrt(np.outer(*2 * (np.diag(exact) + 1e-9 * exact.max(),)))
        assert np.abs((found - exact) / size).max() < 1e-10


def test_natural_modes_of_the_sphere():
    exact = [natural_frequencies(SEED, n)[1] for n in range(7)], [natural_frequencies(SEED, n)[0] for n in range(2, 7)]
    found = natural_modes(SEED, 6).omega
    assert found == pytest.approx([*exact[1], *exact[0]], rel=1e-10)


@pytest.mark.parametrize("shell", [OBLATE, PROLATE, CAPSULE])
def test_rigid_heave_strains_nothing_and_weighs_the_shell(shell):
    mass, membrane, bending = matrices(shell, 8)
    rigid = heave(8)
    assert rigid @ mass @ rigid == pytest.approx(shell.mass, rel=1e-12)
    assert np.abs(membrane @ rigid).max() < 1e-12 * membrane.max()
    assert np.abs(bending @ rigid).max() < 1e-12 * bending.max()
    modes = natural_modes(shell, 8)
    assert np.abs(rigid @ mass @ modes.shapes).max() < 1e-11 * np.sqrt(shell.mass)
    assert (modes.omega > 0).all()


def test_a_uniform_swelling_is_all_membrane():
    """A displacement proportional to the position stretches all lines alike and turns none."""
    terms = np.zeros(2 * 6 + 1)
    meridian = spheroid(2.0, 2.6)  # x sin + z cos along e_r, x cos - z sin along e_phi: degrees 0 and 2
    a, c = 2.0, 1.3
    terms[0], terms[2], terms[6 + 2] = (2 * a + c) / 3, 2 * (c - a) / 3, (c - a) / 3
    shell = Shell(2.0, 0.01, 10e6, 0.3, 2700.0, meridian)
    _, membrane, bending = matrices(shell, 6)
    assert terms @ membrane @ terms == pytest.approx(
        2 * (1 + 0.3) * shell.membrane_stiffness * meridian.area, rel=1e-12
    )
    assert abs(terms @ bending @ terms) < 1e-12 * bending.max()
    phi = np.linspace(0.1, 3.0, 7)
    found = ritz.strains(meridian, 6, phi)
    assert terms @ found.meridional == pytest.approx(1.0)
    assert terms @ found.hoop == pytest.approx(1.0)
    assert np.abs(terms @ found.rotation).max() < 1e-12


def _conical_elements(shell, count):
    """Natural frequencies by conical frusta: straight, u linear and w cubic along each (Grafton & Strome 1963)."""
    at = curve(shell.meridian, np.linspace(0.0, np.pi, count + 1))
    mass, stiffness = np.zeros((2, 3 * count + 3, 3 * count + 3))
    node, weight = np.polynomial.legendre.leggauss(4)
    c, d, nu = shell.membrane_stiffness, shell.bending_stiffness, shell.poisson_ratio
    for i in range(count):
        dx, dz = at.x[i + 1] - at.x[i], at.z[i + 1] - at.z[i]
        length = np.hypot(dx, dz)
        t, n = np.array([dx, dz]) / length, np.array([-dz, dx]) / length
        turn = np.zeros((6, 6))  # local (u, w, beta) of either end from (x, z, beta)
        for e in (0, 3):
            turn[e, e : e + 2], turn[e + 1, e : e + 2], turn[e + 2, e + 2] = t, n, 1.0
        for s, w in zip((node + 1) / 2, weight / 2, strict=True):
            x = at.x[i] + s * dx
            u = np.array([1 - s, 0, 0, s, 0, 0])
            along = np.array([-1, 0, 0, 1, 0, 0]) / length
            cubic = np.array([0, 1 - 3 * s**2 + 2 * s**3, length * (s - 2 * s**2 + s**3),
                              0, 3 * s**2 - 2 * s**3, length * (s**3 - s**2)])  # fmt: skip
            slope = np.array([0, -6 * s + 6 * s**2, length * (1 - 4 * s + 3 * s**2),
                              0, 6 * s - 6 * s**2, length * (3 * s**2 - 2 * s)]) / length  # fmt: skip
            bent = np.array([0, -6 + 12 * s, length * (-4 + 6 * s), 0, 6 - 12 * s, length * (6 * s - 2)]) / length**2
            hoop, turned = (u * t[0] + cubic * n[0]) / x, -slope * t[0] / x
            ring = 2 * np.pi * x * length * w
            e = turn.T @ (
                c * (np.outer(along, along) + np.outer(hoop, hoop) + nu * (np.outer(along, hoop) + np.outer(hoop, along)))
                + d * (np.outer(bent, bent) + np.outer(turned, turned) - nu * (np.outer(bent, turned) + np.outer(turned, bent)))
            ) @ turn * ring  # fmt: skip
            m = turn.T @ (np.outer(u, u) + np.outer(cubic, cubic)) @ turn * ring * shell.density * shell.thickness
            part = slice(3 * i, 3 * i + 6)
            stiffness[part, part] += e
            mass[part, part] += m
    free = [j for j in range(3 * count + 3) if j not in (0, 2, 3 * count, 3 * count + 2)]  # poles: neither x nor turn
    return np.sqrt(np.abs(eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)))[1:]


@pytest.mark.parametrize(("shell", "degree"), [(SEED, 24), (OBLATE, 24), (PROLATE, 24), (CAPSULE, 24)])
def test_natural_frequencies_are_those_of_conical_finite_elements(shell, degree):
    """Another geometry, other shapes, other strains: equal as their error, of second order, vanishes."""
    coarse, fine = (_conical_elements(shell, count)[:4] for count in (40, 80))
    ours = natural_modes(shell, degree).omega[:4]
    assert fine == pytest.approx(ours, rel=1e-2)
    assert np.log2(np.abs(coarse / ours - 1) / np.abs(fine / ours - 1)) == pytest.approx(2.0, abs=0.35)
    assert (4 * fine - coarse) / 3 == pytest.approx(ours, rel=3e-4)


def test_more_degrees_lower_the_frequencies_to_a_limit():
    """Rayleigh's principle, and spectral convergence: each degree more gains."""
    found = [natural_modes(PROLATE, degree).omega[:3] for degree in (6, 10, 14, 30)]
    errors = [np.max(omega / found[-1] - 1) for omega in found[:-1]]
    assert all(np.min(omega - found[-1]) > -1e-9 * omega[0] for omega in found[:-1])
    assert errors[1] < 0.2 * errors[0]
    assert errors[2] < 0.2 * errors[1]


def test_a_little_eccentricity_changes_frequencies_to_first_order():
    """Second differences about the sphere are bounded: the sphere is no special case of the quadrature."""

    def lowest(part):
        return natural_modes(Shell(2.0, 0.01, 10e6, 0.3, 2700.0, spheroid(2.0, 4.0 * (1 + part))), 12).omega[:3]

    slope = (lowest(1e-4) - lowest(-1e-4)) / 2e-4
    wider = (lowest(1e-2) - lowest(-1e-2)) / 2e-2
    assert slope == pytest.approx(wider, rel=5e-2)
    assert lowest(0.0) == pytest.approx([natural_frequencies(SEED, n)[0] for n in (2, 3, 4)], rel=1e-10)


def test_a_meridian_too_rough_for_any_quadrature_is_refused(monkeypatch):
    monkeypatch.setattr(ritz, "MOST_POINTS", 40)
    with pytest.raises(ConvergenceError, match=r"device.shape: the energy of its shell is not integrated by 40 points"):
        matrices(Shell(1.0, 1e-4, 1e7, 0.3, 2700.0, RestMeridian((1.0,), (0.0, 0.07))), 3)


@pytest.mark.parametrize("size", [1.0, 1e9, 1e-9])
@pytest.mark.parametrize(("share", "near"), [(0.9, True), (1.1, False)])
def test_matrices_are_near_by_each_entry_of_its_own_size_but_round_off_of_the_largest(share, near, size):
    b = np.diag([1.0, 1e-6, 0.0])
    off = ritz.CONVERGED * np.array([[1.0, -1e-3, 0.0], [-1e-3, 1e-6, 0.0], [0.0, 0.0, 0.0]])
    off[2, 2] = 1e-15
    for entry in ((0, 0), (0, 1), (1, 1), (2, 2)):
        a = b.copy()
        a[entry] += share * (off[entry] + np.copysign(1e-15, off[entry]) * (entry != (2, 2)))
        assert ritz._near(size * a, size * b) is near, entry


EGG = RestMeridian((2.0,), (0.3, 2.2, 0.1, 0.05))


@pytest.mark.parametrize("rest", [spheroid(2.0, 3.0), EGG], ids=["oblate", "egg"])
def test_a_larger_shell_strains_bends_and_rings_by_the_powers_of_its_size(rest):
    shell = Shell(rest.radius, 0.02, 1e7, -0.2, 2700.0, rest)
    large, phi = larger(shell), np.linspace(0.2, 2.9, 8)
    one, other = (ritz.strains(each.rest, 5, phi) for each in (shell, large))
    for name, power in (
        ("meridional", 1),
        ("hoop", 1),
        ("rotation", 1),
        ("meridional_bending", 2),
        ("hoop_bending", 2),
    ):
        expected = getattr(one, name) / STRETCH**power
        np.testing.assert_allclose(getattr(other, name), expected, rtol=1e-10, atol=1e-11 * np.abs(expected).max())
    small, big = matrices(shell, 5), matrices(large, 5)
    for name, factor in (
        ("mass", DENSER * STRETCH**3),
        ("membrane", STIFFER * STRETCH),
        ("bending", STIFFER * STRETCH),
    ):
        expected = factor * getattr(small, name)
        np.testing.assert_allclose(getattr(big, name), expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())
    found, expected = natural_modes(large, 5), natural_modes(shell, 5)
    assert found.omega == pytest.approx(np.sqrt(STIFFER / DENSER) / STRETCH * expected.omega, rel=1e-9)
    assert found.shapes.shape == (11, 10)


def test_curvatures_of_a_body_unlike_above_and_below_are_what_its_rotation_changes_by():
    """Along the meridian by differences, around it by how far the parallels lean."""
    phi, step = np.linspace(0.3, 2.8, 7), 1e-4
    at, found = curve(EGG, phi), ritz.strains(EGG, 4, phi)
    arc = np.hypot(at.dx, at.dz)
    before, after = (ritz.strains(EGG, 4, phi + s * step).rotation for s in (-1, 1))
    np.testing.assert_allclose(found.meridional_bending, -(after - before) / (2 * step) / arc, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(found.hoop_bending, -found.rotation * at.dx / (arc * at.x), rtol=1e-12, atol=1e-14)


def test_matrices_are_kept_and_cannot_be_written_to():
    shell = Shell(EGG.radius, 0.02, 1e7, 0.3, 2700.0, EGG)
    assert matrices(shell, 3) is matrices(shell, 3)
    for matrix in matrices(shell, 3):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
        with pytest.raises(ValueError, match="read-only"):
            matrix[0, 0] = 0.0


@pytest.mark.parametrize("slow", [0, 1, 2])
def test_points_are_doubled_until_none_of_the_matrices_changes(slow, monkeypatch):
    """Mass, membrane or bending: the last to settle counts."""
    tried = []

    def integrated(shell, degree, points):
        tried.append(points)
        found = [np.eye(3) * (k + 1.0) for k in range(3)]
        found[slow] += 1e-3 / points if points < 600 else 0.0
        return tuple(found)

    monkeypatch.setattr(ritz, "_integrated", integrated)
    found = matrices(Shell(3.7 + slow, 0.01, 1e7, 0.3, 2700.0), 3)
    assert tried == [tried[0] * 2**k for k in range(len(tried))]
    assert tried[-3] < 600 <= tried[-2]
    assert [float(each[0, 0]) for each in found] == [1.0, 2.0, 3.0]
