"""Volume, area, displacement and strain of shells deformed in all azimuthal orders."""

import numpy as np
import pytest

from vsb.shell.deformed import enclosed
from vsb.shell.modes import mode_basis
from vsb.shell.orders import Ballast, order_basis, yaw
from vsb.shell.surface import enclosed_in_orders, largest_deformation
from vsb.study.device import Device

DEVICE = Device(radius=2.0, thickness=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0, mass=17170.0)
RING = mode_basis(DEVICE, "full", 3)
ORDERS = [order_basis(RING, order, Ballast(17170.0, -0.4, 3000.0)) for order in (1, 2)]
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


def test_strains_of_orders_match_finite_differences_of_the_surface():
    both = [ORDERS[1], ORDERS[1].turned()]
    labels = [*RING.labels, *(label for basis in both for label in basis.labels)]
    step, size = 1e-5, 1e-6
    phi = np.repeat(np.linspace(0.01, np.pi - 0.01, 181), 48)
    theta = np.tile(2 * np.pi * np.arange(48) / 48, 181)

    def place(q, phi, theta):
        """Displacements along e_r, e_phi and e_theta."""
        parts = np.array([*RING.displacement(phi), np.zeros((len(RING.labels), len(phi)))])
        parts[:, 0] = 0.0
        total, at = np.einsum("j,ijp->ip", q[: len(RING.labels)], parts), len(RING.labels)
        for basis in both:
            cos, sin = np.cos(2 * theta), np.sin(2 * theta)
            around = np.array([sin, sin, -cos]) if basis.odd else np.array([cos, cos, sin])
            total = total + np.einsum("j,ijp->ip", q[at : at + len(basis.labels)], np.array(basis.field(phi))) * around
            at += len(basis.labels)
        return total

    for amplitudes in (
        {"Membrane2c2": 1.0, "Bending3s2": -0.4, "Membrane0": -0.2},
        {"Bending2c2": 0.3, "Bending3s2": 1.0, "Bending2": 0.5},
        {"Bending2s2": -1.0},
    ):
        q = size * np.array([amplitudes.get(label, 0.0) for label in labels])
        v, u, _ = place(q, phi, theta)
        along = ((place(q, phi + step, theta) - place(q, phi - step, theta))[1] / (2 * step) + v) / 2.0
        w_around = (place(q, phi, theta + step) - place(q, phi, theta - step))[2] / (2 * step)
        around = (u / np.tan(phi) + v + w_around / np.sin(phi)) / 2.0
        displacement, strain = largest_deformation(RING, both, q)
        assert strain == pytest.approx(max(np.abs(along).max(), np.abs(around).max()), rel=2e-2)
        assert displacement == pytest.approx(np.sqrt((place(q, phi, theta) ** 2).sum(axis=0)).max(), rel=2e-2)
