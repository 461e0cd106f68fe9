"""Prestress stiffness of azimuthal orders: invariant under rotation of the shell, zero for rigid motions."""

import numpy as np
import pytest

from vsb.shell.elastic import ElasticShell
from vsb.shell.loaded import LoadedShell
from vsb.shell.modes import mode_basis
from vsb.shell.order_prestress import geometric_stiffness, prestress_stiffness, volume_hessian
from vsb.shell.orders import Ballast, order_basis
from vsb.shell.surface import enclosed_in_orders
from vsb.study.device import Device, Gas

DEVICE = Device(radius=1.5, thickness=0.01, young_modulus=1e8, poisson_ratio=0.3, density=2700.0, mass=17170.0)
BASIS = mode_basis(DEVICE, "full", 4)
BALLAST = Ballast(17170.0, -0.4, 3000.0)
ORDERS = [order_basis(BASIS, order, BALLAST) for order in (1, 2, 3)]
SHELL = ElasticShell(BASIS)


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


def test_uniform_tension_stiffens_all_orders_alike():
    """The matrices over the (V, U) pairs of a degree equal those of m = 0."""
    colatitude, area = SHELL.rings
    tension = 7.0 + 0 * colatitude
    of_axis = by_shape(BASIS, SHELL.geometric_stiffness(tension, tension))
    for basis in ORDERS:
        found = by_shape(basis, geometric_stiffness(basis, colatitude, area, tension, tension))
        assert found.keys() >= {max(2, basis.order), 4}
        for degree, block in found.items():
            np.testing.assert_allclose(block, of_axis[degree], rtol=1e-9, atol=1e-9)


def test_volume_hessian_does_not_depend_on_the_order():
    of_axis = by_shape(BASIS, SHELL.volume_hessian(np.zeros(len(BASIS.labels))))
    for basis in ORDERS:
        for degree, block in by_shape(basis, volume_hessian(basis)).items():
            np.testing.assert_allclose(block, of_axis[degree], rtol=1e-9, atol=1e-9)


def test_hessian_is_that_of_the_enclosed_volume():
    """By differences, with two modes of different degrees."""
    labels = [*BASIS.labels, *(label for basis in ORDERS for label in basis.labels)]
    basis, step = ORDERS[1], 1e-3
    q = np.array([{"Membrane2c2": 1.0, "Bending3c2": -0.7}.get(label, 0.0) for label in labels]) * step
    still, one, other = (enclosed_in_orders(BASIS, ORDERS, s * q[None])[0][0] for s in (0, 1, -1))
    own = np.array([{"Membrane2c2": 1.0, "Bending3c2": -0.7}.get(label, 0.0) for label in basis.labels])
    assert (one - 2 * still + other) / step**2 == pytest.approx(own @ volume_hessian(basis) @ own, rel=1e-5)


def test_varying_tension_works_on_the_second_order_strain():
    """Half the squared gradient of the displacement along phi and theta, by differences around the sphere."""
    basis = ORDERS[1]
    colatitude, area = SHELL.rings
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

    along = (place(colatitude + h, theta) - place(colatitude - h, theta)) / (2 * h * DEVICE.radius)
    around = (place(colatitude, theta + h) - place(colatitude, theta - h)) / (
        2 * h * DEVICE.radius * np.sin(colatitude)[:, None]
    )
    squares = [(part**2).sum(axis=0).mean(axis=1) for part in (along, around)]
    expected = area @ (meridional * squares[0] + hoop * squares[1])
    assert geometric_stiffness(basis, colatitude, area, meridional, hoop)[j, j] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(
    ("basis", "gas"),
    [*((one, None) for one in (*ORDERS, ORDERS[0].turned())), (ORDERS[1], Gas(adiabatic_index=1.4))],
    ids=["order 1", "order 2", "order 3", "order -1", "gas"],
)
def test_additional_pressure_stiffens_all_orders_alike(basis, gas):
    """Around a floating shell: nothing for rigid motions, for shapes that of m = 0 of their degree; a gas expands first."""
    vented, tight = (LoadedShell(SHELL, 0.0, 1025.0, 9.81, pressure, gas) for pressure in (0.0, 1e5))
    loose, held = (prestress_stiffness(basis, shell) for shell in (vented, tight))
    assert not held[: basis.rigid].any()
    assert loose[basis.rigid :].any()  # by the water
    np.testing.assert_allclose(held, held.T, atol=1e-9 * np.abs(held).max())
    of_axis = by_shape(BASIS, tight.prestress_stiffness - vented.prestress_stiffness)
    for degree, block in by_shape(basis, held - loose).items():
        np.testing.assert_allclose(block, of_axis[degree], rtol=1e-7, atol=1e-6 * np.abs(block).max())
