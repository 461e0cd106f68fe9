"""Volume, area and deformation of shells deformed in all orders."""

import numpy as np
import pytest

from vsb.shell.deformed import enclosed
from vsb.shell.modes import mode_basis
from vsb.shell.orders import Ballast, order_basis
from vsb.shell.surface import enclosed_in_orders, largest_deformation
from vsb.study.device import Device

DEVICE = Device(radius=2.0, thickness=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0, mass=17170.0)
RING = mode_basis(DEVICE, "full", 3)
ORDERS = [order_basis(RING, order, Ballast(17170.0, -0.4, 3000.0)) for order in (1, 2)]
LABELS = [*RING.labels, *(label for basis in ORDERS for label in basis.labels)]


def moved(**amplitudes):
    return np.array([amplitudes.get(label, 0.0) for label in LABELS])


def test_of_axisymmetric_shapes_it_is_that_of_the_meridian():
    q = np.random.default_rng(1).normal(size=(3, len(RING.labels))) * 0.1
    volume, area = enclosed_in_orders(RING, ORDERS, np.pad(q, ((0, 0), (0, len(LABELS) - q.shape[1]))))
    expected = enclosed(RING, q)
    np.testing.assert_allclose(volume, expected[0], rtol=1e-12)
    np.testing.assert_allclose(area, expected[1], rtol=1e-9)


def test_rigid_motions_change_neither():
    still, tilted = (enclosed_in_orders(RING, ORDERS, q[None]) for q in (moved(), moved(Heave=1, Surge=3, Pitch=0.3)))
    np.testing.assert_array_equal(still, tilted)
    assert still[0][0] == pytest.approx(4 / 3 * np.pi * 8, rel=1e-13)
    assert still[1][0] == pytest.approx(16 * np.pi, rel=1e-12)


def test_shapes_turned_on_their_side_enclose_what_they_did_upright():
    """x^2 + y^2 - 2 z^2 turned about y: a radial shape of order 0 is one of orders 0 and 2, P_2 = -S_20/2 + ..."""
    radial = order_basis(RING, 2, Ballast(1.0, 0.0, 0.0))
    upright = {"Membrane2": 0.2}
    scale = RING.shapes[3].radial / radial.modes[0].radial  # amplitudes of S_2^m by those of P_2
    side = {"Membrane2": -0.1, "Membrane2c2": 0.2 * np.sqrt(3) / 2 * scale}
    found = [enclosed_in_orders(RING, ORDERS, moved(**q)[None]) for q in (upright, side)]
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=1e-12)
    np.testing.assert_allclose(found[0][1], found[1][1], rtol=1e-6)


def test_the_largest_displacement_of_a_mode_is_its_amplitude():
    """Surge, pitch and heave deform nothing."""
    for label in ("Membrane2", "Membrane3c1", "Membrane3c2", "Bending2c1"):
        displacement, strain = largest_deformation(RING, ORDERS, moved(Surge=1.0, Pitch=0.5, Heave=2.0, **{label: 0.1}))
        assert displacement == pytest.approx(0.1, rel=2e-3)
        assert 0.01 < strain < 1.0
    assert largest_deformation(RING, ORDERS, moved(Surge=1.0, Pitch=0.5)) == (0.0, 0.0)


def test_breathing_strains_everywhere_alike():
    assert largest_deformation(RING, ORDERS, moved(Membrane0=0.1)) == (pytest.approx(0.1), pytest.approx(0.05))
