"""A buoy from the coefficients of its shape: closed forms of water that acts on one ring."""

import numpy as np
import pytest
from conftest import varied
from scipy.linalg import block_diag

from vsb.engine.hydro.database import Coefficients
from vsb.engine.hydro.dofs import displacements
from vsb.engine.motion.port import port_direction
from vsb.engine.shell.orders import semi_normalisation, semi_normalised
from vsb.models.floating_system import ShapeWater, buoy_at, shell_shapes
from vsb.models.rest import design_motions, order_bases, reference_shell
from vsb.study.resolution import HydroPlan

OMEGA = np.linspace(0.5, 3.0, 26)
SPRING = 3e4
BALANCED = {"centre_of_mass": -0.5, "ballast_inertia": 9e3}


def water(study, colatitude=2.0, mass=4e3, loss=1e3, pull=5e4, omega=OMEGA):
    """A body that moves water, radiates and is pulled at one ring alone: all coefficients are products there."""
    solved = displacements(HydroPlan(study).displacements())
    at_ring = np.polynomial.legendre.legvander(np.cos([colatitude]), len(solved) - 1)[0]
    at_ring = at_ring if len(solved) > 1 else np.cos([colatitude])  # of a rigid study Radial1 alone
    product = np.outer(at_ring, at_ring)
    every = omega[:, None, None]
    excitation = np.tile(pull * at_ring, (len(omega), 1)).astype(complex)
    return ShapeWater(solved, omega, Coefficients(mass * product + 0 * every, loss * every * product, excitation))


@pytest.fixture(scope="module")
def study(seed):
    """The seed with a spring at its port."""
    return varied(seed, pto={"damping": 8e3, "stiffness": SPRING}, modes={"degree": 4})


def test_modal_coefficients_of_a_ring(study):
    """A mode moves the ring by its own normal displacement, which is all such water knows of it."""
    basis, found = reference_shell(study).basis, water(study)
    radial = basis.displacement(np.array([2.0]))[0][:, 0]
    modes = found.in_modes(basis)
    np.testing.assert_allclose(modes.added_mass[3], 4e3 * np.outer(radial, radial), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(modes.damping[3], 1e3 * OMEGA[3] * np.outer(radial, radial), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(modes.excitation[3], 5e4 * radial, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("spring", [SPRING, -4e4, 0.0])
def test_rigid_design_is_a_mass_on_two_springs(study, spring):
    """V0 = F/Z and Y = 1/Z with added mass, loss, waterplane and the spring of the take-off."""
    study = varied(study, pto={"stiffness": spring})
    rest = reference_shell(study)
    port = buoy_at(study, rest, water(study)).ports(spring)["FSB"]
    heave, squared = np.cos(2.0), study.device.radius**2 - study.centre_height**2
    waterplane = study.water.density * study.water.gravity * np.pi * squared
    inertia = study.device.mass + 4e3 * heave**2
    impedance = -1j * OMEGA * inertia + 1e3 * OMEGA * heave**2 + (waterplane + spring) / (-1j * OMEGA)
    np.testing.assert_allclose(port.admittance, 1 / impedance, rtol=1e-9)
    np.testing.assert_allclose(port.velocity, 5e4 * heave / impedance, rtol=1e-9)
    assert port.compliance == pytest.approx(1 / (waterplane + spring), rel=1e-9)


def moved_under(waves, damping, stiffness=0.0):
    """All degrees of freedom per wave amplitude under a damper and a spring."""
    return waves.moved[0] - waves.port.force(damping, stiffness)[:, None] * waves.moved[1]


def test_motion_under_a_damper_matches_the_port(study):
    waves = buoy_at(study, reference_shell(study), water(study)).in_waves()
    for one in waves.values():
        velocity = -1j * OMEGA * moved_under(one, 8e3, 2e4)[:, 0]
        load = one.port.load(8e3, 2e4)
        np.testing.assert_allclose(velocity, one.port.velocity_under(load), rtol=1e-9)
        heave, _ = one.motion.under(load * one.port.velocity_under(load))
        np.testing.assert_allclose(moved_under(one, 8e3, 2e4)[:, 0], heave, rtol=1e-12)


def test_gas_chamber_with_a_shut_and_an_open_turbine(study):
    """Shut as beside a take-off of heave without effect, open as without the gas."""
    gas = {"device": {"gas": {"adiabatic_index": 1.4}}, "pto": {"stiffness": 0.0}}
    changes = {
        "volume": gas | {"pto": {"port": "volume", "stiffness": 0.0}},
        "heave": gas,
        "vented": {"pto": gas["pto"]},
    }
    waves = {}
    for name, change in changes.items():
        own = varied(study, **change)
        waves[name] = buoy_at(own, reference_shell(own), water(own)).in_waves()
    for design in ("VSWEC", "VSWEC90"):
        opened, held, vented = (waves[name][design] for name in ("volume", "heave", "vented"))
        for moved, expected in ((moved_under(opened, 1e15), held), (moved_under(opened, 0.0), vented)):
            np.testing.assert_allclose(moved, expected.moved[0], rtol=1e-6, atol=1e-8 * np.abs(expected.moved[0]).max())
        assert np.abs(held.moved[0] / vented.moved[0] - 1).max() > 0.01
        loose = reference_shell(varied(study, **changes["vented"]))
        b, free = port_direction("volume", loose.shape), design_motions(study, loose.basis, design)
        yields = b @ free @ np.linalg.solve(free.T @ loose.total @ free, free.T @ b)
        chamber = 4 / 3 * np.pi * 2.0**3 / (1.4 * 101325.0)
        assert opened.port.compliance == pytest.approx(yields + chamber, rel=1e-9)


PLANAR = {
    "motion": "planar", "modes": {"degree": 3, "order": 2}, "mooring": [2e4, 0, 0, 0, 0, 0],
    "device": {**BALANCED, "damping": {"alpha": 0.3, "beta": 2e-3}},
    "pto": {"port": {"line_to": [12.0, -9.0], "line_from": [0.3, -1.0]}, "damping": 8e3, "stiffness": SPRING},
}  # fmt: skip


def ring_of(order, colatitude, mass, loss, pull, highest=3):
    """Water as of `water`, of an order: what it knows of a shape is how far one ring moves, all around."""
    solved = displacements([f"Radial{n}" for n in range(order, highest + 1)], order)
    ring = np.array([
        semi_normalised(each.degree, order, np.array([colatitude]))[0, 0] / semi_normalisation(each.degree, order)
        for each in solved
    ])  # fmt: skip
    product, every = np.outer(ring, ring), OMEGA[:, None, None]
    excitation = np.tile(pull * ring, (len(OMEGA), 1))
    return ShapeWater(solved, OMEGA, Coefficients(mass * product + 0 * every, loss * every * product, excitation))


@pytest.mark.parametrize("design", ["FSB", "VSWEC", "VSWEC90"])
def test_line_port_of_all_orders_solves_the_equation_of_motion(seed, design):
    """One system of all degrees of freedom, assembled and solved independently."""
    study = varied(seed, **PLANAR)
    reference = reference_shell(study)
    basis, families = reference.basis, order_bases(study, reference.basis)
    at = np.array([2.0])
    kinds = {1: (3e3, 700.0, 4e4 * (0.6 + 0.8j)), 2: (900.0, 200.0, 1e4 * (0.8 - 0.6j))}
    orders = tuple(ring_of(order, 2.0, *kind) for order, kind in kinds.items())
    axial = water(study)
    buoy = buoy_at(study, reference, ShapeWater(axial.displacements, OMEGA, axial.coefficients, orders))
    found = buoy.in_waves()[design]
    radial = [basis.displacement(at)[0][:, 0], *(each.field(at).radial[:, 0] for each in families)]
    kinds = [(4e3, 1e3, 5e4), *kinds.values()]
    mass, loss = (
        block_diag(*(kind[i] * np.outer(v, v) for kind, v in zip(kinds, radial, strict=True))) for i in (0, 1)
    )
    pull = np.concatenate([kind[2] * v for kind, v in zip(kinds, radial, strict=True)])
    labels = [*basis.labels, *(label for each in families for label in each.labels)]
    stiffness = block_diag(
        reference.total,
        *(each.stiffness + each.hydrostatic_stiffness(study.centre_height, 1025.0, 9.81) for each in families),
    )
    stiffness[labels.index("Surge"), labels.index("Surge")] += 2e4
    inertia, damping = (
        block_diag(*(getattr(each, name) for each in (basis, *families))) for name in ("inertia", "damping")
    )
    b = port_direction(study.pto.port, reference.shape, families)
    free = design_motions(study, basis, design)
    still, driven, moved = [], [], []
    for w in OMEGA:
        impedance = -(w**2) * (inertia + mass) - 1j * w * (damping + w * loss) + stiffness
        forced = free @ np.linalg.solve(free.T @ impedance @ free, free.T @ np.array([pull, b], dtype=complex).T)
        still.append(-1j * w * b @ forced[:, 0])
        driven.append(-1j * w * b @ forced[:, 1])
        loaded = impedance + (SPRING - 1j * w * 8e3) * np.outer(b, b)
        moved.append(free @ np.linalg.solve(free.T @ loaded @ free, free.T @ pull))
    np.testing.assert_allclose(found.port.velocity, still, rtol=1e-9)
    np.testing.assert_allclose(found.port.admittance, driven, rtol=1e-9)
    assert np.linalg.norm(np.real(driven) / found.port.admittance.real - 1, np.inf) < 1e-7
    under = b @ free @ np.linalg.solve(free.T @ stiffness @ free, free.T @ b)
    assert found.port.compliance == pytest.approx(under, rel=1e-9)
    together = moved_under(found, 8e3, SPRING)
    np.testing.assert_allclose(together, moved, rtol=1e-8, atol=1e-9 * np.abs(moved).max())
    heave, shell = found.motion.under(found.port.force(8e3, SPRING))
    np.testing.assert_allclose(heave, together[:, 0], rtol=1e-10)
    expected = np.einsum("wi,iab->abw", together[:, 1:], shell_shapes(basis, families)[1:])
    np.testing.assert_allclose(shell, expected, rtol=1e-9, atol=1e-10 * np.abs(together).max())


def test_modes_radiate_through_the_channel_of_their_excitation(study):
    """h = tr B/|X|^2."""
    basis, exact = reference_shell(study).basis, water(study)
    beside = 300.0 * np.eye(len(exact.displacements)) * OMEGA[:, None, None]
    coefficients = exact.coefficients._replace(damping=exact.coefficients.damping + beside)
    left = ShapeWater(exact.displacements, OMEGA, coefficients)
    found, alone = left.in_modes(basis), exact.in_modes(basis)
    np.testing.assert_array_equal(found.excitation, alone.excitation)
    np.testing.assert_array_equal(found.added_mass, alone.added_mass)
    shape = alone.damping[3] / np.trace(alone.damping[3])
    assert np.trace(found.damping[3]) > 1.01 * np.trace(alone.damping[3])
    np.testing.assert_allclose(found.damping[3], np.trace(found.damping[3]) * shape, rtol=1e-9, atol=1e-9)


def test_a_viscous_shell_is_at_each_frequency_a_stiffer_one_with_more_damping(seed):
    """Of Hooke's law, open to constant pressure, all stiffness of the shell goes with E."""
    branch = {"ratio": 0.6, "time": 0.4}
    viscous = varied(seed, device={"damping": {"alpha": 0.0, "beta": 1e-3, "maxwell": [branch]}}, modes={"degree": 4})
    found = buoy_at(viscous, reference_shell(viscous), water(viscous)).ports()["VSWEC"]
    for i in (0, 12, 25):
        x = (OMEGA[i] * branch["time"]) ** 2
        stiffer, loss = 1 + branch["ratio"] * x / (1 + x), branch["ratio"] * branch["time"] / (1 + x)
        device = {"young_modulus": 1e7 * stiffer, "damping": {"alpha": 0.0, "beta": (1e-3 + loss) / stiffer}}
        plain = varied(viscous, device=device)
        port = buoy_at(plain, reference_shell(plain), water(plain)).ports()["VSWEC"]
        assert found.admittance[i] == pytest.approx(port.admittance[i], rel=1e-9)
        assert found.velocity[i] == pytest.approx(port.velocity[i], rel=1e-9)
