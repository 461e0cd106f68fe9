"""Shapes of azimuthal order m >= 1: energies equal those of m = 0, hydrostatics as derivatives of forces, clamps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import assoc_legendre_p
from shell.test_sphere import DENSER, STIFFER, STRETCH, larger

from vsb.errors import ConfigError
from vsb.shell.modes import mode_basis
from vsb.shell.orders import (
    Ballast,
    OrderBasis,
    ballast_of,
    order_basis,
    semi_normalisation,
    semi_normalised,
    yaw,
)
from vsb.study.study import Device

DEVICE = Device(
    radius=2.0, thickness=0.02, young_modulus=3e7, poisson_ratio=0.3, density=2700.0, mass=17170.0,
    centre_of_mass=-0.4, ballast_inertia=3000.0, damping={"alpha": 0.1, "beta": 1e-3},
)  # fmt: skip
BALLAST = Ballast(17170.0, -0.4, 3000.0)
RHO, G, HEIGHT = 1025.0, 9.81, 0.15
KINDS = ("paper", "membrane", "full")


def at_order(order, basis="full", degree=4) -> OrderBasis:
    return order_basis(mode_basis(DEVICE, basis, degree), order, BALLAST)


@pytest.mark.parametrize(("n", "m"), [(1, 1), (2, 1), (2, 2), (5, 3), (6, 6)])
def test_semi_normalised_functions_have_the_norm_of_order_zero(n, m):
    norm, _ = quad(lambda phi: semi_normalised(n, m, np.array([phi]))[0, 0] ** 2 * np.sin(phi), 0, np.pi)
    assert norm / 4 == pytest.approx(1 / (2 * n + 1), rel=1e-12)  # int cos^2(m theta) is half that of m = 0


def test_semi_normalised_functions_match_scipy_and_finite_differences():
    phi, h = np.array([0.3, 1.1, 2.8]), 1e-5
    np.testing.assert_allclose(semi_normalised(2, 1, phi)[0], np.sqrt(3) * np.sin(phi) * np.cos(phi), rtol=1e-14)
    assert semi_normalisation(2, 2) == pytest.approx(np.sqrt(1 / 12))
    for k in (1, 2):
        for n, m in ((5, 3), (4, 1), (3, 2)):
            steps = semi_normalised(n, m, phi + h)[k - 1] - semi_normalised(n, m, phi - h)[k - 1]
            np.testing.assert_allclose(semi_normalised(n, m, phi)[k], steps / (2 * h), rtol=1e-8, atol=1e-8)
    for n, m in ((5, 3), (4, 1), (3, 2)):
        value, slope, _, around, its = semi_normalised(n, m, phi)
        np.testing.assert_allclose(around, value / np.sin(phi), rtol=1e-12)
        np.testing.assert_allclose(its, slope / np.sin(phi) - value * np.cos(phi) / np.sin(phi) ** 2, rtol=1e-12)
    ours, scipys = semi_normalised(8, 5, phi)[0], -assoc_legendre_p(8, 5, np.cos(phi))[0]
    np.testing.assert_allclose(ours, semi_normalisation(8, 5) * scipys, rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_energies_do_not_depend_on_the_order(order, kind):
    """The closed sphere's modes are degenerate in m."""
    ring = mode_basis(DEVICE, kind, 4)
    basis = order_basis(ring, order, BALLAST)
    kept = [1 + i for i, mode in enumerate(ring.modes) if mode.degree >= order]
    scale = [a.radial / b.radial for a, b in zip(basis.modes, np.array(ring.shapes, object)[kept], strict=True)]
    for name in ("inertia", "stiffness", "damping"):
        own = getattr(basis, name)[basis.rigid :, basis.rigid :]
        zero = getattr(ring, name)[np.ix_(kept, kept)] * np.outer(scale, scale)
        np.testing.assert_allclose(own, zero, rtol=1e-12, atol=1e-12 * np.abs(zero).max())


@pytest.mark.parametrize("order", [1, 2, 3])
def test_mass_and_elastic_energy_are_integrals_over_the_surface(order):
    """Strains by differentiation in space, without bending."""
    basis = order_basis(mode_basis(DEVICE, "membrane", 3), order, BALLAST)
    basis = replace(basis, bending=False)
    cos, weight = np.polynomial.legendre.leggauss(40)
    phi, r, m, nu = np.arccos(cos), 2.0, order, 0.3
    (v, u, w), (_, du, dw) = basis.field(phi), basis.field(phi, derivative=1)
    cot, sin = cos / np.sin(phi), np.sin(phi)
    along, around = (du + v) / r, (u * cot + v + m * w / sin) / r
    shear = (dw - w * cot - m * u / sin) / r

    def over(a, b):
        return np.pi * r**2 * (a * weight) @ b.T

    shell = basis.shell
    kept = slice(basis.rigid, None)
    mass = shell.density * shell.thickness * (over(v, v) + over(u, u) + over(w, w))
    np.testing.assert_allclose(basis.inertia[kept, kept], mass[kept, kept], rtol=1e-10, atol=1e-8)
    if order == 1:
        np.testing.assert_allclose(mass[1, [0, *range(2, len(mass))]], 0.0, atol=1e-9)  # pitch and shapes are apart
        assert mass[0, 0] == pytest.approx(shell.mass)
        assert mass[1, 1] == pytest.approx(2 / 3 * shell.mass * r**2)
    energy = over(along, along) + over(around, around) + nu * (over(along, around) + over(around, along))
    energy += (1 - nu) / 2 * over(shear, shear)
    np.testing.assert_allclose(basis.stiffness, shell.membrane_stiffness * energy, rtol=1e-9, atol=1e-6)


def test_yaw_rotates_the_sphere_about_its_axis():
    """r sin phi along e_theta, without stiffness."""
    turned = yaw(mode_basis(DEVICE, "full", 2), BALLAST._replace(yaw_inertia=500.0))
    phi = np.array([0.0, 0.4, np.pi / 2, 3.0])
    field, slope = turned.field(phi), turned.field(phi, 1)
    assert field.azimuthal == pytest.approx(-2.0 * np.sin(phi)[None], abs=1e-15)
    assert slope.azimuthal == pytest.approx(-2.0 * np.cos(phi)[None], abs=1e-15)
    assert not np.any([field.radial, field.meridional, slope.radial, slope.meridional])
    assert turned.inertia == pytest.approx(2 / 3 * turned.shell.mass * 4 + 500.0)
    assert not np.any([turned.stiffness, turned.hydrostatic_stiffness(HEIGHT, RHO, G)])


def deformed(basis, q, phi, theta):
    """Points of the deformed shell, r(phi, theta), and their derivatives with respect to the amplitudes q."""
    f, m = basis.field(phi), basis.order
    cos, sin, c, s = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    e_r, e_phi = np.array([sin * c, sin * s, cos]), np.array([cos * c, cos * s, -sin])
    e_theta = np.array([-s + 0 * phi, c + 0 * phi, 0 * phi])
    shapes = (f.radial[:, None] * e_r + f.meridional[:, None] * e_phi) * np.cos(m * theta)
    shapes = shapes + f.azimuthal[:, None] * e_theta * np.sin(m * theta)
    return basis.shell.radius * e_r + np.tensordot(q, shapes, 1) + np.array([[0], [0], [HEIGHT]]), shapes


def force(basis, q):
    """Generalised force of still water on the deformed shell, meridian by meridian."""
    node, weight = np.polynomial.legendre.leggauss(36)
    total, azimuths = np.zeros(len(q)), 2 * np.pi * np.arange(12) / 12
    for theta in azimuths:
        low = brentq(lambda phi, t=theta: deformed(basis, q, np.array([phi]), t)[0][2, 0], 0.5, 2.8, xtol=1e-14)
        phi, h = (low + np.pi) / 2 + (np.pi - low) / 2 * node, 1e-5
        x, psi = deformed(basis, q, phi, theta)
        by_phi = (deformed(basis, q, phi + h, theta)[0] - deformed(basis, q, phi - h, theta)[0]) / (2 * h)
        by_theta = (deformed(basis, q, phi, theta + h)[0] - deformed(basis, q, phi, theta - h)[0]) / (2 * h)
        normal = np.cross(by_phi, by_theta, axis=0)
        total += RHO * G * np.einsum("p,ap,jap->j", x[2] * weight, normal, psi) * (np.pi - low) / 2
    return total * 2 * np.pi / len(azimuths)


def test_hydrostatic_stiffness_is_the_derivative_of_the_force():
    basis = order_basis(mode_basis(DEVICE, "full", 2), 2, BALLAST)
    found, h = basis.hydrostatic_stiffness(HEIGHT, RHO, G), 1e-4
    steps = [(force(basis, h * e) - force(basis, -h * e)) / (2 * h) for e in np.eye(len(basis.labels))]
    np.testing.assert_allclose(found, -np.transpose(steps), atol=2e-6 * np.abs(found).max())
    np.testing.assert_allclose(found, found.T, atol=1e-12 * np.abs(found).max())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("clamps", [(90.0,), (60.0, 60.0), (0.0, 120.0)])
def test_clamped_shell_does_not_move_at_its_clamps(order, clamps):
    basis = order_basis(mode_basis(DEVICE, "full", 6), order, BALLAST)
    at = np.deg2rad(clamps)
    motions = basis.allowed(True, at)
    np.testing.assert_allclose(motions.T @ motions, np.eye(motions.shape[1]), atol=1e-13)
    assert motions.shape[1] < len(basis.labels)
    np.testing.assert_allclose(basis.clamp_rows(at) @ motions, 0.0, atol=1e-12)
    if order == 1:
        np.testing.assert_array_equal(motions[:2], np.eye(2, motions.shape[1]))  # surge and pitch stay free
        inside = (at > 0) & (at < np.pi)
        moved = np.array(basis.field(at[inside]))[:, 2:]
        np.testing.assert_allclose(np.einsum("ijp,jf->ifp", moved, motions[2:]), 0.0, atol=1e-12)


def test_clamp_at_a_pole_constrains_order_one_only():
    for order, held in ((1, 1), (2, 0), (3, 0)):
        basis = at_order(order, degree=6)
        for poles, times in (([0.0], 1), ([np.pi], 1), ([0.0, np.pi], 2)):
            assert len(basis.labels) - basis.allowed(True, poles).shape[1] == times * held
            assert bool(basis.clamp_rows(poles).any()) == bool(held)
    assert at_order(1).allowed(False).shape == (len(at_order(1).labels), 2)
    assert at_order(2).allowed(False).shape == (len(at_order(2).labels), 0)


def test_pitch_needs_centre_of_mass_and_ballast_inertia():
    assert ballast_of(DEVICE) == BALLAST
    assert ballast_of(DEVICE.model_copy(update={"centre_of_mass": 0.0})) == BALLAST._replace(centre_of_mass=0.0)
    for name in ("centre_of_mass", "ballast_inertia"):
        silent = DEVICE.model_copy(update={name: None})
        with pytest.raises(
            ConfigError, match="device: received no centre_of_mass or no ballast_inertia; pitch needs both"
        ):
            ballast_of(silent)


def potential(basis, amplitudes, points=40):
    """Energy of a deformed and then rotated shell of order 1, its ballast and the displaced water [J].

    Water at rest: -rho g int z over the wetted volume, by the divergence theorem -rho g int z^2/2 n_z over its surface.
    """
    node, weight = np.polynomial.legendre.leggauss(points)
    low, step = np.arccos(-HEIGHT / 2.0), 1e-4
    phi = np.concatenate([low / 2 * (1 + node), low + (np.pi - low) / 2 * (1 + node)])
    dphi = np.concatenate([low / 2 * weight, (np.pi - low) / 2 * weight])
    azimuth = np.linspace(0.0, 2 * np.pi, points, endpoint=False)
    surge, turn, bent = *amplitudes[:2], np.concatenate([[0.0, 0.0], amplitudes[2:]])

    def place(phi, azimuth):
        """Where the points of the shell are, (3, phi, azimuth)."""
        cos, sin = np.cos(azimuth), np.sin(azimuth)
        v, u, w = (bent @ part for part in basis.field(phi))
        v, u, w = 2.0 + np.outer(v, cos), np.outer(u, cos), np.outer(w, sin)
        s, c = np.sin(phi)[:, None], np.cos(phi)[:, None]
        x, y, z = (v * s + u * c) * cos - w * sin, (v * s + u * c) * sin + w * cos, v * c - u * s
        return np.array([surge + np.cos(turn) * x + np.sin(turn) * z, y, HEIGHT - np.sin(turn) * x + np.cos(turn) * z])

    z = place(phi, azimuth)[2]
    along_phi = (place(phi + step, azimuth) - place(phi - step, azimuth)) / (2 * step)
    around = (place(phi, azimuth + step) - place(phi, azimuth - step)) / (2 * step)
    area = dphi[:, None] * 2 * np.pi / points
    upward = along_phi[0] * around[1] - along_phi[1] * around[0]
    water = -RHO * G * np.sum(np.minimum(z, 0.0) ** 2 / 2 * upward * area)
    shell = basis.shell.mass / (4 * np.pi) * np.sum(z * np.sin(phi)[:, None] * area)
    return water + G * (shell + BALLAST.total_mass * BALLAST.centre_of_mass * np.cos(turn))


def test_stiffness_of_water_and_weight_is_the_second_derivative_of_their_energy():
    """Over surge, pitch and shapes, with a heavy shell."""
    heavy = replace(at_order(1, degree=2), shell=replace(at_order(1).shell, density=20000.0))
    stiffness, size = heavy.hydrostatic_stiffness(HEIGHT, RHO, G), len(heavy.labels)
    step = 0.02 * np.eye(size)
    for i, j in zip(*np.triu_indices(size), strict=True):
        signed = [a * b * potential(heavy, a * step[i] + b * step[j]) for a in (1, -1) for b in (1, -1)]
        found = sum(signed) / (4 * 0.02**2)
        assert found == pytest.approx(stiffness[i, j], rel=0, abs=2e-4 * np.abs(stiffness).max()), (i, j)
        assert stiffness[j, i] == pytest.approx(stiffness[i, j], rel=0, abs=1e-13 * np.abs(stiffness).max())


@pytest.mark.parametrize("order", [1, 2])
def test_odd_family_is_the_even_one_rotated_by_a_quarter_turn(order):
    """Sway replaces surge and minus roll replaces pitch."""
    even, odd = at_order(order), at_order(order).turned()
    sign = np.ones(len(even.labels))
    sign[1 : 2 if order == 1 else 1] = -1.0
    assert odd.signed == -order == -even.signed
    assert odd.labels == tuple(
        {"Surge": "Sway", "Pitch": "Roll"}.get(label, label.replace("c", "s")) for label in even.labels
    )
    for matrix in ("inertia", "stiffness", "damping"):
        np.testing.assert_array_equal(getattr(odd, matrix), getattr(even, matrix) * np.outer(sign, sign))
    water = [each.hydrostatic_stiffness(HEIGHT, RHO, G) for each in (even, odd)]
    np.testing.assert_array_equal(water[1], water[0] * np.outer(sign, sign))
    if order == 1:
        assert odd.inertia[0, 1] == pytest.approx(17170.0 * 0.4)
        assert np.abs(water[0][1, 2:]).max() > 1.0


@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize("order", [1, 2])
def test_matrices_scale_with_size(order, odd):
    small = order_basis(mode_basis(DEVICE, "full", 3), order, Ballast(17170.0, 0.3, 3000.0))
    big = Ballast(17170.0 * DENSER * STRETCH**3, 0.3 * STRETCH, 3000.0 * DENSER * STRETCH**5)
    large = replace(small, shell=larger(small.shell), ballast=big, alpha=0.3, beta=2e-3)
    small, large = (each.turned() if odd else each for each in (small, large))
    size = np.ones(len(small.labels))
    size[1 : small.rigid] = STRETCH
    size = np.outer(size, size)
    mass, stiffness = DENSER * STRETCH**3 * size * small.inertia, STIFFER * STRETCH * size * small.stiffness
    damping = 0.3 * mass + 2e-3 * stiffness
    damping[: small.rigid] = damping[:, : small.rigid] = 0.0
    water = DENSER * STRETCH**2 * size * small.hydrostatic_stiffness(HEIGHT, RHO, G)
    for found, expected in (
        (large.inertia, mass),
        (large.stiffness, stiffness),
        (large.damping, damping),
        (large.hydrostatic_stiffness(STRETCH * HEIGHT, DENSER * RHO, G), water),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-11 * np.abs(expected).max())
    slower = np.sqrt(STIFFER / DENSER) / STRETCH
    np.testing.assert_allclose(large.dry_frequencies, slower * small.dry_frequencies, rtol=1e-11)
    phi = np.array([0.0, 0.4, 1.7, np.pi])
    for derivative in (0, 1):
        for found, expected in zip(large.field(phi, derivative), small.field(phi, derivative), strict=True):
            expected[1 : small.rigid] *= STRETCH
            np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-14)


def test_centre_of_mass_above_and_below_the_centre():
    """The coupling with surge changes sign, the hydrostatic pitch stiffness becomes negative, the inertia stays."""
    above, below = (order_basis(mode_basis(DEVICE, "full", 2), 1, Ballast(9000.0, at, 500.0)) for at in (0.4, -0.4))
    shell = above.shell.mass
    expected = 2 / 3 * shell * 4.0 + 500.0 + (9000.0 * 0.4) ** 2 / (9000.0 - shell)
    assert above.inertia[1, 1] == pytest.approx(expected, rel=1e-13)
    assert below.inertia[1, 1] == pytest.approx(expected, rel=1e-13)
    assert (above.inertia[0, 1], below.inertia[0, 1]) == (pytest.approx(3600.0), pytest.approx(-3600.0))
    assert above.hydrostatic_stiffness(HEIGHT, RHO, G)[1, 1] == pytest.approx(-9000.0 * G * 0.4, rel=1e-13)
    np.testing.assert_array_equal(above.inertia[2:, 2:], below.inertia[2:, 2:])


@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_rigid_motions_have_neither_stiffness_nor_damping(kind, odd):
    """The publication's shape of degree 1 still has momentum along surge."""
    basis = order_basis(mode_basis(DEVICE, kind, 3), 1, BALLAST)
    basis = basis.turned() if odd else basis
    for matrix in (basis.stiffness, basis.damping):
        assert not matrix[:2].any()
        assert not matrix[:, :2].any()
        assert np.diag(matrix)[2:].all()
    coupled = abs(basis.inertia[0, 2]) / basis.shell.mass
    assert coupled > 0.01 if kind == "paper" else coupled < 1e-12
    np.testing.assert_allclose(basis.inertia, basis.inertia.T, rtol=1e-14, atol=1e-12)
