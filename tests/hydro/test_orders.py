"""Orders side by side: surge against published coefficients, the limit (1 + 2N) lambda/2 pi, blocks of a database."""

import numpy as np
import pytest
import xarray as xr

from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.orders import (
    ORDER,
    heading_shares,
    in_order_modes,
    order_groups,
    order_shares,
    side_by_side,
    with_haskind_damping,
)
from vsb.engine.hydro.quality import haskind_difference
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.deformed import rigid_sphere
from vsb.engine.shell.device import Device
from vsb.engine.shell.modes import mode_basis
from vsb.engine.shell.orders import Ballast, order_basis, semi_normalisation
from vsb.engine.waves.water import power_limit

RHO, G = 1025.0, 9.81
DEVICE = Device(radius=2.0, thickness=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0, mass=17170.0)


def solved(order, degrees, omegas, nodes=32, radius=2.0, height=0.0):
    shell = rigid_sphere(radius, height)
    moved = tuple(Displacement("radial", n, order) for n in degrees)
    ds = SpectralProblem(shell, moved, RHO, G, nodes).solve(list(omegas))
    return ds.assign(excitation_force=ds.Froude_Krylov_force + ds.diffraction_force)


def basis(order, degree=3):
    return order_basis(mode_basis(DEVICE, "membrane", degree), order, Ballast(17170.0, -0.4, 3000.0))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_haskind_holds_order_by_order_and_makes_damping_passive(order):
    """To the solver's own error, which the repair takes away."""
    omegas = np.linspace(1.0, 4.0, 7)
    ds = in_order_modes(solved(order, range(order, 5), omegas), basis(order, 4))
    ds = ds.drop_sel(influenced_dof=["Pitch"], radiating_dof=["Pitch"]) if order == 1 else ds
    assert haskind_difference(ds, np.inf, RHO, G, order) < 1e-4
    assert haskind_difference(ds, np.inf, RHO, G) > 0.5  # that of order 0 is another
    made = with_haskind_damping(ds, order, np.inf, RHO, G)
    np.testing.assert_allclose(made.radiation_damping, ds.radiation_damping, atol=1e-4 * ds.radiation_damping.max())
    assert np.linalg.eigvalsh(made.radiation_damping.values).min() > -1e-12 * float(made.radiation_damping.max())
    assert made.attrs["history"] == f"damping of order {order} from excitation (Haskind)"


def test_largest_capture_width_of_orders_up_to_n():
    """1/8 X^H B^-1 X of one motion of each order, B and X solved independently of each other."""
    omegas = np.array([1.2, 2.0, 2.8])
    limit = np.array([power_limit(w, np.inf, RHO, G) for w in omegas])
    taken = 0.0
    for order in range(4):
        ds = solved(order, [max(order, 1)], omegas, nodes=64)
        force, damping = ds.excitation_force.values[:, 0, 0], ds.radiation_damping.values[:, 0, 0]
        taken = taken + np.abs(force) ** 2 / (8 * damping)
        np.testing.assert_allclose(taken, (1 + 2 * order) * limit, rtol=1e-6)


def parts():
    first = xr.Dataset(
        {
            "added_mass": (("omega", "influenced_dof", "radiating_dof"), np.ones((2, 1, 1))),
            "excitation_force": (("omega", "wave_direction", "influenced_dof"), np.ones((2, 1, 1), complex)),
            "hydrostatic_stiffness": (("influenced_dof", "radiating_dof"), np.full((1, 1), 5.0)),
        },
        {"omega": [1.0, 2.0], "wave_direction": [0.0], "influenced_dof": ["Heave"], "radiating_dof": ["Heave"]},
        {"history": "symmetrized"},
    )
    second = first.assign_coords(influenced_dof=["Surge"], radiating_dof=["Surge"]) * 2
    return [first.assign_attrs(solver="one"), second.assign_attrs(history="from excitation", solver="another")]


def test_orders_are_joined_without_coupling():
    whole = side_by_side(parts(), [0, 1])
    assert list(whole.influenced_dof.values) == ["Heave", "Surge"]
    np.testing.assert_array_equal(whole.added_mass[1], [[1.0, 0.0], [0.0, 2.0]])
    np.testing.assert_array_equal(whole.hydrostatic_stiffness, [[5.0, 0.0], [0.0, 10.0]])
    np.testing.assert_array_equal(whole.excitation_force[0, 0], [1.0, 2.0])
    assert whole.attrs == {"solver": "one", "history": "symmetrized; from excitation"}
    assert whole[ORDER].values.tolist() == [0, 1]
    assert {order: list(group) for order, group in order_groups(whole).items()} == {0: [0], 1: [1]}


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("direction", [0.0, 0.4, 2.5, -1.3])
def test_cosines_and_sines_of_a_heading_make_the_whole_wave(order, direction):
    """cos m(theta - beta), wherever it is looked at."""
    theta = np.linspace(0.0, 6.0, 13)
    shares = heading_shares([order, -order], direction)
    whole = shares[0] * np.cos(order * theta) + shares[1] * np.sin(order * theta)
    np.testing.assert_allclose(whole, np.cos(order * (theta - direction)), atol=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_shapes_of_an_order_are_semi_normalised_and_moved_by_their_radial_part(order):
    """Whatever else was solved, in whatever order; surge is P_1^1 itself and pitch moves no water."""
    one = basis(order)
    solved_ = [Displacement("radial", n, order) for n in (3, order, 4, 2) if n >= order]
    solved_ = list(dict.fromkeys(solved_))
    found = order_shares(solved_, one)
    rigid = {"Surge": {1: 1.0}, "Pitch": {}} if order == 1 else {}
    expected = [*rigid.values(), *({m.degree: m.radial * semi_normalisation(m.degree, order)} for m in one.modes)]
    assert list(one.labels[: len(rigid)]) == list(rigid)
    assert found == pytest.approx(np.array([[of.get(each.degree, 0.0) for each in solved_] for of in expected]))
