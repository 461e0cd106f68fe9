"""Shapes of azimuthal order m >= 1: energies, hydrostatics, clamps, prestress, enclosed volume, largest deformation."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import assoc_legendre_p

from vsb.engine.shell.deformed import enclosed
from vsb.engine.shell.device import Device, Gas
from vsb.engine.shell.loaded import ElasticShell, LoadedShell
from vsb.engine.shell.modes import mode_basis
from vsb.engine.shell.orders import (
    Ballast,
    OrderBasis,
    ballast_of,
    enclosed_in_orders,
    geometric_stiffness,
    largest_deformation,
    order_basis,
    prestress_stiffness,
    semi_normalisation,
    semi_normalised,
    volume_hessian,
    yaw,
)
from vsb.errors import ConfigError

DEVICE = Device(
    radius=2.0, thickness=0.02, young_modulus=3e7, poisson_ratio=0.3, density=2700.0, mass=17170.0,
    centre_of_mass=-0.4, ballast_inertia=3000.0, damping={"alpha": 0.1, "beta": 1e-3},
)  # fmt: skip
BALLAST = Ballast(17170.0, -0.4, 3000.0)
RHO, G, HEIGHT = 1025.0, 9.81, 0.15


def at_order(order, basis="full", degree=4) -> OrderBasis:
    return order_basis(mode_basis(DEVICE, basis, degree), order, BALLAST)


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


@pytest.mark.parametrize("kind", ["paper", "full"])
@pytest.mark.parametrize("order", [1, 3])
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


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("clamps", [(60.0, 60.0), (0.0, 120.0)])
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
        with pytest.raises(ConfigError, match="device: received no centre_of_mass or no ballast_inertia; pitch needs"):
            ballast_of(silent)


def potential(basis, amplitudes, points=40):
    """Energy of a deformed and, in order 1, then rotated shell, its ballast and the displaced water [J].

    Water at rest: -rho g int z over the wetted volume, by the divergence theorem -rho g int z^2/2 n_z over its surface.
    """
    node, weight = np.polynomial.legendre.leggauss(points)
    low, step = np.arccos(-HEIGHT / 2.0), 1e-4
    phi = np.concatenate([low / 2 * (1 + node), low + (np.pi - low) / 2 * (1 + node)])
    dphi = np.concatenate([low / 2 * weight, (np.pi - low) / 2 * weight])
    azimuth = np.linspace(0.0, 2 * np.pi, points, endpoint=False)
    rigid, m = basis.rigid, basis.order
    surge, turn = amplitudes[:2] if rigid else (0.0, 0.0)
    bent = np.concatenate([np.zeros(rigid), amplitudes[rigid:]])

    def place(phi, azimuth):
        """Where the points of the shell are, (3, phi, azimuth)."""
        cos, sin, around = np.cos(azimuth), np.sin(azimuth), np.cos(m * azimuth)
        v, u, w = (bent @ part for part in basis.field(phi))
        v, u, w = 2.0 + np.outer(v, around), np.outer(u, around), np.outer(w, np.sin(m * azimuth))
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


@pytest.mark.parametrize("order", [1, 2])
def test_stiffness_of_water_and_weight_is_the_second_derivative_of_their_energy(order):
    """Over surge, pitch and shapes, with a heavy shell."""
    heavy = replace(at_order(order, degree=2), shell=replace(at_order(1).shell, density=20000.0))
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


SMALL = Device(radius=1.5, thickness=0.01, young_modulus=1e8, poisson_ratio=0.3, density=2700.0, mass=17170.0)
SMALL_BASIS = mode_basis(SMALL, "full", 4)
SMALL_ORDERS = [order_basis(SMALL_BASIS, order, BALLAST) for order in (1, 2, 3)]
SMALL_SHELL = ElasticShell(SMALL_BASIS)


def by_shape(basis, matrix):
    """A matrix over (V, U) of a pair of modes of one degree, from that over the modes."""
    of = {}
    for degree in {mode.degree for mode in basis.modes}:
        at = [i for i, mode in enumerate(basis.modes) if mode.degree == degree]
        shapes = np.array([[basis.modes[i].radial, basis.modes[i].meridional] for i in at])
        if len(at) == 2:
            own = matrix[-len(basis.modes) :, -len(basis.modes) :][np.ix_(at, at)]
            of[degree] = np.linalg.inv(shapes) @ own @ np.linalg.inv(shapes).T
    return of


def test_hessian_is_that_of_the_enclosed_volume():
    """By differences, with two modes of different degrees."""
    labels = [*SMALL_BASIS.labels, *(label for basis in SMALL_ORDERS for label in basis.labels)]
    basis, step = SMALL_ORDERS[1], 1e-3
    q = np.array([{"Membrane2c2": 1.0, "Bending3c2": -0.7}.get(label, 0.0) for label in labels]) * step
    still, one, other = (enclosed_in_orders(SMALL_BASIS, SMALL_ORDERS, s * q[None])[0][0] for s in (0, 1, -1))
    own = np.array([{"Membrane2c2": 1.0, "Bending3c2": -0.7}.get(label, 0.0) for label in basis.labels])
    assert (one - 2 * still + other) / step**2 == pytest.approx(own @ volume_hessian(basis) @ own, rel=1e-5)


def test_varying_tension_works_on_the_second_order_strain():
    """Half the squared gradient of the displacement along phi and theta, by differences around the sphere."""
    basis = SMALL_ORDERS[1]
    colatitude, area = SMALL_SHELL.rings
    meridional, hoop = 3.0 + np.cos(colatitude), 2.0 - np.cos(colatitude) ** 2
    j, h, count = basis.labels.index("Bending3c2"), 1e-5, 64
    theta = 2 * np.pi * np.arange(count) / count

    def place(phi, theta):
        """Displacement in Cartesian coordinates, (3, phi, theta)."""
        v, u, w = (part[j][:, None] for part in basis.field(phi))
        cos, sin = np.cos(2 * theta), np.sin(2 * theta)
        r = np.array(
            [
                np.outer(np.sin(phi), np.cos(theta)),
                np.outer(np.sin(phi), np.sin(theta)),
                np.outer(np.cos(phi), 1 + 0 * theta),
            ]
        )
        e = np.array(
            [
                np.outer(np.cos(phi), np.cos(theta)),
                np.outer(np.cos(phi), np.sin(theta)),
                np.outer(-np.sin(phi), 1 + 0 * theta),
            ]
        )
        a = np.array([np.outer(1 + 0 * phi, -np.sin(theta)), np.outer(1 + 0 * phi, np.cos(theta)), 0 * r[2]])
        return v * cos * r + u * cos * e + w * sin * a

    along = (place(colatitude + h, theta) - place(colatitude - h, theta)) / (2 * h * SMALL.radius)
    around = (place(colatitude, theta + h) - place(colatitude, theta - h)) / (
        2 * h * SMALL.radius * np.sin(colatitude)[:, None]
    )
    squares = [(part**2).sum(axis=0).mean(axis=1) for part in (along, around)]
    expected = area @ (meridional * squares[0] + hoop * squares[1])
    assert geometric_stiffness(basis, colatitude, area, meridional, hoop)[j, j] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(
    ("basis", "gas"),
    [(SMALL_ORDERS[0].turned(), None), (SMALL_ORDERS[1], Gas(adiabatic_index=1.4))],
    ids=["order -1", "order 2 with gas"],
)
def test_additional_pressure_stiffens_all_orders_alike(basis, gas):
    """Around a floating shell: nothing for rigid motions, for shapes that of m = 0 of their degree; a gas expands first."""
    vented, tight = (LoadedShell(SMALL_SHELL, 0.0, 1025.0, 9.81, pressure, gas) for pressure in (0.0, 1e5))
    loose, held = (prestress_stiffness(basis, shell) for shell in (vented, tight))
    assert not held[: basis.rigid].any()
    assert loose[basis.rigid :].any()  # by the water
    np.testing.assert_allclose(held, held.T, atol=1e-9 * np.abs(held).max())
    of_axis = by_shape(SMALL_BASIS, tight.prestress_stiffness - vented.prestress_stiffness)
    for degree, block in by_shape(basis, held - loose).items():
        np.testing.assert_allclose(block, of_axis[degree], rtol=1e-7, atol=1e-6 * np.abs(block).max())


RING = mode_basis(DEVICE, "full", 3)
ORDERS = [order_basis(RING, order, BALLAST) for order in (1, 2)]
LABELS = [*RING.labels, *(label for basis in ORDERS for label in basis.labels)]


def moved(**amplitudes):
    return np.array([amplitudes.get(label, 0.0) for label in LABELS])


def test_axisymmetric_shapes_enclose_what_their_meridian_does():
    q = np.random.default_rng(1).normal(size=(3, len(RING.labels))) * 0.1
    volume, area = enclosed_in_orders(RING, ORDERS, np.pad(q, ((0, 0), (0, len(LABELS) - q.shape[1]))))
    expected = enclosed(RING, q)
    np.testing.assert_allclose(volume, expected[0], rtol=1e-12)
    np.testing.assert_allclose(area, expected[1], rtol=1e-9)


def test_rigid_motions_change_neither_volume_nor_area():
    still, tilted = (enclosed_in_orders(RING, ORDERS, q[None]) for q in (moved(), moved(Heave=1, Surge=3, Pitch=0.3)))
    np.testing.assert_array_equal(still, tilted)
    assert still[0][0] == pytest.approx(4 / 3 * np.pi * 8, rel=1e-13)
    assert still[1][0] == pytest.approx(16 * np.pi, rel=1e-12)


def test_volume_and_area_are_unchanged_by_rotation():
    """x^2 + y^2 - 2 z^2 rotated about y: a radial shape of order 0 becomes one of orders 0 and 2."""
    radial = order_basis(RING, 2, Ballast(1.0, 0.0, 0.0))
    upright = {"Membrane2": 0.2}
    scale = RING.shapes[3].radial / radial.modes[0].radial  # amplitudes of S_2^m by those of P_2
    side = {"Membrane2": -0.1, "Membrane2c2": 0.2 * np.sqrt(3) / 2 * scale}
    found = [enclosed_in_orders(RING, ORDERS, moved(**q)[None]) for q in (upright, side)]
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=1e-12)
    np.testing.assert_allclose(found[0][1], found[1][1], rtol=1e-6)
    lying = [largest_deformation(RING, ORDERS, moved(**q)) for q in (upright, side)]
    np.testing.assert_allclose(lying[0], lying[1], rtol=2e-2)  # looked for on a grid; all around by order two


def test_largest_displacement_of_a_mode_is_its_amplitude():
    """Surge, pitch and heave deform nothing."""
    for label in ("Membrane2", "Membrane3c1", "Membrane3c2", "Bending2c1"):
        displacement, strain = largest_deformation(RING, ORDERS, moved(Surge=1.0, Pitch=0.5, Heave=2.0, **{label: 0.1}))
        assert displacement == pytest.approx(0.1, rel=2e-3)
        assert 0.01 < strain < 1.0
    assert largest_deformation(RING, ORDERS, moved(Surge=1.0, Pitch=0.5)) == (0.0, 0.0)


def test_breathing_strain_is_uniform():
    assert largest_deformation(RING, ORDERS, moved(Membrane0=0.1)) == (pytest.approx(0.1), pytest.approx(0.05))


def test_odd_shapes_are_the_even_ones_rotated():
    both = [each for one in ORDERS for each in (one, one.turned())] + [yaw(RING, ORDERS[0].ballast)]
    labels = [*RING.labels, *(label for basis in both for label in basis.labels)]
    values = {"Membrane0": 0.05, "Membrane2": 0.1, "Membrane2c1": 0.12, "Bending3c1": 0.03}
    turned = {label.replace("c1", "s1"): value for label, value in values.items()} | {
        "Sway": 1.0,
        "Roll": 0.2,
        "Yaw": 3.0,
    }
    even, odd = (np.array([q.get(label, 0.0) for label in labels]) for q in (values, turned))
    for of in (enclosed_in_orders, largest_deformation):
        one, other = (of(RING, both, q[None] if of is enclosed_in_orders else q) for q in (even, odd))
        np.testing.assert_allclose(other, one, rtol=1e-3 if of is largest_deformation else 1e-12)
    both_sides = {"Membrane2c1": 0.1, "Membrane2s1": 0.1}  # one of sqrt(2) on the diagonal
    diagonal = np.array([both_sides.get(label, 0.0) for label in labels])
    assert largest_deformation(RING, both, diagonal)[0] == pytest.approx(0.1 * np.sqrt(2), rel=2e-3)
