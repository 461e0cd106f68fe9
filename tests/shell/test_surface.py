"""Volume, area and deformation of shells deformed in all orders."""

import numpy as np
import pytest
from shell.test_sphere import STRETCH, larger

from vsb.shell import surface
from vsb.shell.deformed import enclosed
from vsb.shell.mode import natural_shapes
from vsb.shell.modes import ModeBasis, mode_basis
from vsb.shell.orders import Ballast, goes_with_sine, order_basis, yaw
from vsb.shell.sphere import Shell
from vsb.shell.strain import strain_shapes
from vsb.shell.surface import enclosed_in_orders, largest_deformation, largest_displacement, largest_strain
from vsb.study.device import Device
from vsb.study.meridian import spheroid

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


@pytest.mark.parametrize("instants", [0, 1, 2, 5])
def test_a_long_motion_is_drawn_in_parts_one_after_the_other(instants, monkeypatch):
    """A breathing sphere of radius 2 + a, two instants at a time."""
    monkeypatch.setattr(surface, "AT_ONCE", 2)
    radius = 2.0 + 0.1 * np.arange(instants)
    q = np.array([moved(Membrane0=r - 2.0) for r in radius]).reshape(instants, len(LABELS))
    volume, area = enclosed_in_orders(RING, ORDERS, q)
    np.testing.assert_allclose(volume, 4 / 3 * np.pi * radius**3, rtol=1e-12)
    np.testing.assert_allclose(area, 4 * np.pi * radius**2, rtol=1e-12)


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
    lying = [largest_deformation(RING, ORDERS, moved(**q)) for q in (upright, side)]
    np.testing.assert_allclose(lying[0], lying[1], rtol=2e-2)  # looked for on a grid; all around by order two


@pytest.mark.parametrize("label", [label for label in RING.labels if label != "Heave"])
def test_the_strain_of_axisymmetric_shapes_is_that_of_the_meridian(label):
    for mixed in ({label: 0.1}, {label: 0.1, "Membrane0": -0.07}):
        q = moved(**mixed)
        assert largest_deformation(RING, ORDERS, q)[1] == pytest.approx(
            largest_strain(RING, q[: len(RING.labels)]), rel=2e-3
        )


def test_the_largest_displacement_of_a_mode_is_its_amplitude():
    """Surge, pitch and heave deform nothing."""
    for label in ("Membrane2", "Membrane3c1", "Membrane3c2", "Bending2c1"):
        displacement, strain = largest_deformation(RING, ORDERS, moved(Surge=1.0, Pitch=0.5, Heave=2.0, **{label: 0.1}))
        assert displacement == pytest.approx(0.1, rel=2e-3)
        assert 0.01 < strain < 1.0
    assert largest_deformation(RING, ORDERS, moved(Surge=1.0, Pitch=0.5)) == (0.0, 0.0)


def test_breathing_strains_everywhere_alike():
    assert largest_deformation(RING, ORDERS, moved(Membrane0=0.1)) == (pytest.approx(0.1), pytest.approx(0.05))


def test_odd_shapes_are_the_even_ones_turned():
    """Volume, area, displacement and strain do not know from which side a shell is looked at."""
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


def test_yaw_turns_every_point_about_the_axis():
    basis = yaw(RING, Ballast(17170.0, -0.4, 3000.0, 500.0))
    radial, meridional, around = basis.field(np.array([0.3, np.pi / 2]))
    assert not radial.any()
    assert not meridional.any()
    np.testing.assert_allclose(-around[0], 2.0 * np.sin([0.3, np.pi / 2]))  # goes with -cos(0 theta)
    assert basis.inertia[0, 0] == pytest.approx(2 / 3 * RING.shell.mass * 4.0 + 500.0)
    assert basis.labels == ("Yaw",)
    assert basis.signed == 0
    assert not basis.allowed(True, [0.3]).shape[1] > 1
    assert goes_with_sine("Membrane12s3")
    assert not goes_with_sine("Membrane12c3")


OBLATE = Shell(2.0, 0.01, 1e7, 0.3, 2700.0, spheroid(2.0, 3.0))


@pytest.mark.parametrize(
    "basis", [RING, ModeBasis(OBLATE, natural_shapes(OBLATE, 4), 3000.0, True)], ids=["sphere", "oblate"]
)
@pytest.mark.parametrize("mode", [1, 2, 4])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_heave_neither_strains_a_shell_nor_moves_it_from_its_centre(basis, mode, sign):
    """A mode moves it by its amplitude, and strains it along or around, whichever is more."""
    q = sign * 0.1 * np.eye(len(basis.labels))[mode]
    lifted = q + 5.0 * np.eye(len(basis.labels))[0]
    along, around, _ = strain_shapes(basis, np.linspace(0.01, np.pi - 0.01, 20001))
    largest = max(np.abs(q @ along).max(), np.abs(q @ around).max())
    for one in (q, lifted):
        assert largest_displacement(basis, one) == pytest.approx(0.1, rel=1e-3)
        assert largest_strain(basis, one) == pytest.approx(largest, rel=1e-3)
    assert q[mode] == sign * 0.1  # and is left as it was


@pytest.mark.parametrize("most", ["along", "around"])
@pytest.mark.parametrize(
    "basis", [RING, ModeBasis(OBLATE, natural_shapes(OBLATE, 4), 3000.0, True)], ids=["sphere", "oblate"]
)
def test_the_largest_strain_is_that_along_or_around(basis, most):
    """Two modes together, of which one direction strains by a tenth more than the other."""
    shapes = dict(zip(("along", "around"), strain_shapes(basis, np.linspace(0.01, np.pi - 0.01, 2001)), strict=False))
    other = shapes["around" if most == "along" else "along"]
    random = np.random.default_rng(5)
    for q in random.normal(size=(200, len(basis.labels))):
        if np.abs(q[1:] @ shapes[most][1:]).max() > 1.1 * np.abs(q[1:] @ other[1:]).max():
            assert largest_strain(basis, q) == pytest.approx(np.abs(q[1:] @ shapes[most][1:]).max(), rel=1e-2)
            return
    pytest.fail("no such motion")


@pytest.mark.parametrize("degree", [3])
def test_a_larger_shell_bent_alike_is_strained_alike(degree):
    """In all orders of both families: displacements go with its size, areas with the square, volumes with the cube."""
    found = []
    for shell, size in ((RING.shell, 1.0), (larger(RING.shell), STRETCH)):
        ring = ModeBasis(shell, RING.modes, 1e4, True)
        orders = [order_basis(ring, order, Ballast(1e4, -0.4, 3e3)) for order in (1, 2)]
        orders.append(orders[1].turned())
        count = len(ring.labels) + sum(len(each.labels) for each in orders)
        q = 0.05 * np.cos(1.9 * np.arange(count) + 0.3) * size
        q[len(ring.labels) + 1] /= size  # pitch is an angle
        volume, area = enclosed_in_orders(ring, orders, np.array([q, -0.5 * q]))
        displacement, strain = largest_deformation(ring, orders, q)
        own = q[: len(ring.labels)]
        found.append([volume / size**3, area / size**2, displacement / size, strain,
                      largest_displacement(ring, own) / size, largest_strain(ring, own)])  # fmt: skip
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-10)
    assert found[0][0][0] != pytest.approx(found[0][0][1], rel=1e-3)


def test_the_largest_strain_of_shapes_that_go_around_is_that_of_lengths_along_and_around():
    """By differences of points of the bent surface, with shapes of both families: of each sign, whichever is more."""
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


@pytest.mark.parametrize("turned", [False, True])
def test_orders_may_be_told_in_any_order(turned):
    """What is largest is looked for finely enough for the highest of them, wherever that stands."""
    first, second = (order_basis(RING, order, Ballast(17170.0, -0.4, 3000.0)) for order in (1, 3))
    second = second.turned() if turned else second
    found = []
    q = {each.labels: 0.1 * np.sin(1.0 + 2.3 * np.arange(len(each.labels))) for each in (first, second)}
    for orders in ([first, second], [second, first]):
        amplitudes = np.concatenate([0.02 * np.cos(np.arange(len(RING.labels))), *(q[each.labels] for each in orders)])
        volume, area = enclosed_in_orders(RING, orders, amplitudes[None])
        found.append([*largest_deformation(RING, orders, amplitudes), volume[0], area[0]])
    assert found[0] == pytest.approx(found[1], rel=1e-12)


def test_volume_and_area_of_many_orders_are_those_of_points_all_around():
    """A lobed sphere of order 3 and one of order 1: r = 2 + v, its volume by finer quadrature."""
    basis = order_basis(RING, 3, Ballast(1.0, 0.0, 0.0))
    at = basis.labels.index("Membrane3c3")
    q = np.zeros(len(RING.labels) + len(basis.labels))
    q[len(RING.labels) + at] = 0.3
    node, weight = np.polynomial.legendre.leggauss(60)
    phi, theta = np.arccos(node), 2 * np.pi * np.arange(96) / 96
    v, u, w = (0.3 * part[at][:, None] for part in basis.field(phi))
    dv, du, dw = (0.3 * part[at][:, None] for part in basis.field(phi, derivative=1))
    c, s, sin, cos = np.cos(3 * theta), np.sin(3 * theta), np.sin(phi)[:, None], np.cos(phi)[:, None]
    out = 2.0 + v * c
    along = np.array([(dv - u) * c, out + du * c, dw * s])
    around = np.array([-3 * v * s - w * s * sin, -3 * u * s - w * s * cos, 3 * w * c + out * sin + u * c * cos])
    normal = np.cross(along, around, axis=0)
    flow = out * normal[0] + u * c * normal[1] + w * s * normal[2]
    area = (weight / np.sin(phi))[:, None] * 2 * np.pi / 96
    volume, surface = enclosed_in_orders(RING, [basis], q[None])
    assert volume[0] == pytest.approx(np.sum(flow * area) / 3, rel=1e-12)
    assert surface[0] == pytest.approx(np.sum(np.sqrt((normal**2).sum(axis=0)) * area), rel=1e-6)


@pytest.mark.parametrize(
    "basis", [RING, ModeBasis(OBLATE, natural_shapes(OBLATE, 4), 3000.0, True)], ids=["sphere", "oblate"]
)
def test_the_largest_displacement_of_several_modes_is_that_of_their_sum(basis):
    """Some outwards and some inwards, which take from each other; heave has no part in it."""
    phi = np.linspace(0.0, np.pi, 3601)
    v, u = basis.displacement(phi)
    for q in np.random.default_rng(3).normal(size=(5, len(basis.labels))):
        expected = np.hypot(q[1:] @ v[1:], q[1:] @ u[1:]).max()
        assert largest_displacement(basis, q) == pytest.approx(expected, rel=2e-3)
