"""The ports of a study's designs from coefficients of its shape: closed forms, in place of any solver's."""

import numpy as np
import pytest
from conftest import varied

from vsb.hydro.coefficients import Coefficients
from vsb.hydro.dofs import displacements
from vsb.scenes.directions import order_bases
from vsb.scenes.ports import POINTS, ShapeWater, _of_shell, design_ports, designs_in_waves, shell_shapes
from vsb.scenes.rest import reference_shell
from vsb.study.blocks import HydroPlan

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


def test_coefficients_of_modes_are_those_of_what_their_ring_does(study):
    """A mode moves the ring by its own normal displacement, which is all such water knows of it."""
    basis, found = reference_shell(study).basis, water(study)
    radial = basis.displacement(np.array([2.0]))[0][:, 0]
    modes = found.in_modes(basis)
    np.testing.assert_allclose(modes.added_mass[3], 4e3 * np.outer(radial, radial), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(modes.damping[3], 1e3 * OMEGA[3] * np.outer(radial, radial), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(modes.excitation[3], 5e4 * radial, rtol=1e-12, atol=1e-9)


def test_a_rigid_design_is_a_mass_on_two_springs(study):
    """V0 = F/Z and Y = 1/Z: the mass and the water's, its loss, the waterplane and the spring of the take-off."""
    rest = reference_shell(study)
    port = design_ports(study, rest, water(study))["FSB"]
    heave, squared = np.cos(2.0), study.device.radius**2 - study.centre_height**2
    waterplane = study.water.density * study.water.gravity * np.pi * squared
    inertia = study.device.mass + 4e3 * heave**2
    impedance = -1j * OMEGA * inertia + 1e3 * OMEGA * heave**2 + (waterplane + SPRING) / (-1j * OMEGA)
    np.testing.assert_allclose(port.admittance, 1 / impedance, rtol=1e-9)
    np.testing.assert_allclose(port.velocity, 5e4 * heave / impedance, rtol=1e-9)
    assert port.compliance == pytest.approx(1 / (waterplane + SPRING), rel=1e-9)


def test_shells_of_other_materials_share_the_water(study):
    """The stiffer the shell, the nearer its port to that of the rigid design, by the first order of 1/E."""
    shared = water(study)
    far = []
    for modulus in (1e12, 1e13):
        stiff = varied(study, device={"young_modulus": modulus})
        ports = design_ports(stiff, reference_shell(stiff), shared)
        far.append(np.abs(ports["VSWEC"].velocity / ports["FSB"].velocity - 1).max())
    assert far[0] / far[1] == pytest.approx(10, rel=0.05)
    assert far[0] < 0.05


def test_a_port_may_be_elsewhere(study):
    """At its top a rigid buoy moves as it heaves, its shell does not; between its own points it does not move."""
    rest, shared = reference_shell(study), water(study)
    heave = design_ports(study, rest, shared)
    at_top = design_ports(
        varied(study, pto={"port": {"colatitude": 0, "direction": "vertical", "against": "sea_bed"}}), rest, shared
    )
    np.testing.assert_allclose(at_top["FSB"].velocity, heave["FSB"].velocity, rtol=1e-12)
    assert np.abs(at_top["VSWEC"].velocity / heave["VSWEC"].velocity - 1).max() > 0.1
    across = design_ports(varied(study, pto={"port": {"between": [0, 180]}}), rest, shared)
    assert not across["FSB"].moves
    assert across["VSWEC"].moves


def test_every_design_has_its_own_motions(study):
    """Clamped to its equator a shell still moves, but not as one that is free."""
    ports = design_ports(study, reference_shell(study), water(study))
    assert list(ports) == list(study.designs)
    velocity = {design: port.velocity for design, port in ports.items()}
    for design in ("FSB", "VSWEC"):
        assert np.abs(velocity["VSWEC90"] / velocity[design] - 1).max() > 1e-2


def test_a_rigid_study_is_solved_for_heave_alone(seed):
    rigid = varied(seed, designs={"FSB": {"flexible": False}}, pto={"damping": 8e3})
    rest = reference_shell(rigid)
    (port,) = design_ports(rigid, rest, water(rigid)).values()
    assert rest.basis.labels == ("Heave",)
    assert port.compliance == pytest.approx(1 / float(rest.total[0, 0]), rel=1e-12)


def test_what_moves_under_a_damper_is_what_the_take_off_feels(study):
    """-i w b.q of all degrees of freedom is the port's velocity under the same damper and spring."""
    waves = designs_in_waves(study, reference_shell(study), water(study))
    for one in waves.values():
        velocity = -1j * OMEGA * one.position(8e3, 2e4)[:, 0]
        load = one.port.load(8e3, 2e4)
        np.testing.assert_allclose(velocity, one.port.velocity_under(load), rtol=1e-9)
        heave, _ = one.motion.under(one.port, load)
        np.testing.assert_allclose(one.position(8e3, 2e4)[:, 0], heave, rtol=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_shapes_of_orders_are_told_on_both_meridians_in_the_plane_of_the_waves(seed, order):
    """They go with cos m theta: at theta = pi they are what they are at theta = 0, times (-1)^m; rigid ones are none."""
    planar = varied(seed, motion="planar", modes={"degree": 3, "order": 2}, device={**BALANCED})
    basis = reference_shell(planar).basis
    families = [each for each in order_bases(planar, basis) if not each.odd]
    shapes, at = shell_shapes(basis, families), np.linspace(0.0, np.pi, POINTS)
    count = len(basis.labels)
    assert shapes.shape == (count + sum(len(each.labels) for each in families), 2, 2 * POINTS)
    np.testing.assert_array_equal(shapes[:count, :, :POINTS], shapes[:count, :, POINTS:])
    start = count + sum(len(each.labels) for each in families if each.order < order)
    (family,) = (each for each in families if each.order == order)
    of_order = shapes[start : start + len(family.labels)]
    front = np.stack(family.field(at)[:2], axis=1)
    assert not of_order[: family.rigid].any()
    np.testing.assert_array_equal(of_order[family.rigid :, :, :POINTS], front[family.rigid :])
    np.testing.assert_array_equal(of_order[family.rigid :, :, POINTS:], (-1) ** order * front[family.rigid :])


def test_what_the_shell_does_is_the_sum_of_its_shapes_in_their_phases():
    """Heave left out; complex amplitudes of each frequency, shapes of two directions."""
    random = np.random.default_rng(2)
    amplitude, shapes = random.normal(size=(2, 5, 4)) * np.array([1, 1j])[:, None, None], random.normal(size=(4, 2, 7))
    together = amplitude.sum(axis=0)
    np.testing.assert_allclose(
        _of_shell(together, shapes), np.einsum("wk,kdp->dpw", together[:, 1:], shapes[1:]), rtol=1e-12
    )


def test_of_shells_of_several_materials_each_has_its_own_coefficients(study):
    """Whose heave moves the water alike and whose modes do not, by one water kept for all, in any order."""
    bases = [reference_shell(varied(study, device={"poisson_ratio": ratio})).basis for ratio in (0.1, 0.3, 0.45)]
    alone, shared = [water(study).in_modes(basis) for basis in bases], water(study)
    for which in (0, 1, 2, 1, 0):
        for one, other in zip(shared.in_modes(bases[which]), alone[which], strict=True):
            np.testing.assert_array_equal(one, other)
    assert np.abs(alone[0].added_mass / alone[2].added_mass - 1).max() > 0.01
