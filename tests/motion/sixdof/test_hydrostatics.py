"""Hydrostatics of the tilted, deformed shell: Archimedes, meridian sums, potential, convergence."""

import numpy as np
import pytest
from conftest import SEED
from scipy.spatial.transform import Rotation

from vsb.motion.sixdof import Body, Elastic, GeneralScene, Hydrostatic, State, Weight, integrate, skew
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, mode_basis, rigid_basis
from vsb.study import study as config

RHO, G = 1025.0, 9.81
DEVICE = config.load(SEED).device
RIGID = rigid_basis(DEVICE)
FULL = mode_basis(DEVICE, "full", 4)
SHAPE = np.array([0.05, -0.03, 0.06, 0.04, -0.02, 0.08, -0.05, 0.04])
TILTS = [0.0, 1e-7, 0.4, 1.2, np.pi / 2, 2.6, np.pi]


def at(height, tilt=0.0, basis: ModeBasis = FULL, modal_amplitude=None) -> State:
    """A buoy turned by yaw, pitch and roll; the tilt of its axis is `tilt`, in a direction that is no axis."""
    rotation = Rotation.from_euler("ZYZ", [0.3, tilt, 0.8]).as_matrix()
    modes = len(basis.modes)
    shape = np.zeros(modes) if modal_amplitude is None else modal_amplitude
    return State(np.array([3.0, -2.0, height]), rotation, shape, np.zeros(3), np.zeros(3), np.zeros(modes))


def cap(height, radius=DEVICE.radius):
    depth = np.clip(radius - height, 0.0, 2 * radius)
    return np.pi * depth**2 * (3 * radius - depth) / 3


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("height", [-2.5, -1.2, 0.0, 0.7, 2.5])
def test_sphere_obeys_archimedes_without_torque(height, tilt):
    water = Hydrostatic(RIGID, RHO, G)
    force = water(0.0, at(height, tilt, RIGID))
    scale = RHO * G * cap(-9.0)
    np.testing.assert_allclose(force[:3], [0.0, 0.0, RHO * G * cap(height)], rtol=1e-12, atol=1e-12 * scale)
    np.testing.assert_allclose(force[3:], 0.0, atol=1e-12 * scale)


@pytest.mark.parametrize("height", [-2.6, -1.4, 0.0, 0.3, 1.9, 2.6])
def test_upright_force_matches_the_deformed_shell(height):
    force = Hydrostatic(FULL, RHO, G)(0.0, at(height, 0.0, FULL, SHAPE))
    upright = DeformedShell(FULL, height, np.concatenate([[0.0], SHAPE])).hydrostatic_force(RHO, G)
    np.testing.assert_allclose(force[[2, *range(6, len(force))]], upright, rtol=1e-11, atol=1e-8)
    np.testing.assert_allclose(force[[0, 1, 3, 4, 5]], 0.0, atol=1e-9)


def moved(state, coordinate, step):
    """The state displaced along one quasi-velocity: a turn is about a body axis."""
    push = step * np.eye(6 + len(state.modal_amplitude))[coordinate]
    turned = state.rotation @ Rotation.from_rotvec(push[3:6]).as_matrix()
    return state._replace(
        position=state.position + push[:3], rotation=turned, modal_amplitude=state.modal_amplitude + push[6:]
    )


@pytest.mark.parametrize(("height", "tilt"), [(-2.6, 0.4), (-1.5, 2.6), (0.2, np.pi / 2)])
def test_force_is_minus_the_gradient_of_the_potential(height, tilt):
    """Central differences with two Richardson steps; pole wet, dry and crossed by the waterline."""
    water, state = Hydrostatic(FULL, RHO, G), at(height, tilt, FULL, SHAPE)

    def central(j, h):
        return (water.potential(moved(state, j, -h)) - water.potential(moved(state, j, h))) / (2 * h)

    h = 4e-3
    gradient = [(64 * central(j, h / 4) - 20 * central(j, h / 2) + central(j, h)) / 45 for j in range(6 + len(SHAPE))]
    force = water(0.0, state)
    np.testing.assert_allclose(force, gradient, atol=2e-7 * np.abs(force).max())
    np.testing.assert_allclose(force[:2], 0.0, atol=1e-9 * np.abs(force).max())
    assert force[5] == 0.0  # no torque about the axis of symmetry


@pytest.mark.parametrize(("height", "tilt"), [(0.3, 0.7), (0.0, np.pi / 2), (-1.7, 1.3)])
def test_quadrature_converges_spectrally_at_every_tilt(height, tilt):
    state = at(height, tilt, FULL, SHAPE)
    exact = Hydrostatic(FULL, RHO, G, 120)(0.0, state)
    forces = [Hydrostatic(FULL, RHO, G, points)(0.0, state) for points in (10, 20, 40)]
    errors = [np.abs(force - exact).max() / np.abs(exact).max() for force in forces]
    assert errors[0] > 100 * errors[1]
    assert errors[2] < 1e-12


def test_potential_of_the_half_submerged_sphere():
    """Work of lifting it out of the water, rho g int_0^r cap(z) dz = rho g pi r^4/4."""
    water = Hydrostatic(RIGID, RHO, G)
    for tilt in TILTS:
        expected = RHO * G * np.pi * DEVICE.radius**4 / 4
        assert water.potential(at(0.0, tilt, RIGID)) == pytest.approx(expected, rel=1e-12)


def test_energy_of_a_tumbling_floating_shell_is_conserved():
    basis = mode_basis(DEVICE, "membrane", 2)
    forces = {"weight": Weight(basis, G), "elastic": Elastic(basis), "hydrostatic": Hydrostatic(basis, RHO, G, 24)}
    scene = GeneralScene(Body(basis, (3000.0, 2000.0)), forces, "free")
    moving = {
        "modal_amplitude": np.array([-0.05, 0.02, 0.04]),
        "velocity": np.array([0.4, 0.0, -0.8]),
        "angular_velocity": np.array([1.5, -2.0, 0.7]),
    }
    loose, tight = (
        integrate(scene, scene.start(**moving), np.linspace(0, 0.6, 4), rtol, rtol) for rtol in (1e-3, 1e-6)
    )
    drifts = []
    for motion in (loose, tight):
        energies = np.array([scene.energy(y) for y in motion])
        drifts.append(np.ptp(energies.sum(axis=1)) / np.ptp(energies[:, 0]))
    assert drifts[1] < 1e-4
    assert drifts[0] > 10 * drifts[1]
    assert scene.state(tight[-1]).rotation[2, 2] < 0.5


def test_torque_is_buoyancy_at_the_centre_of_buoyancy():
    """Submerged shell: torque = R^T((R c) x (0, 0, rho g V)) with the centroid c of its volume."""
    m = DeformedShell(FULL, 0.0, np.concatenate([[0.0], SHAPE]))
    node, weight = np.polynomial.legendre.leggauss(60)
    points = m.meridian(np.pi / 2 * (1 + node))
    slices = -np.pi * points.x**2 * points.dz * np.pi / 2 * weight
    volume, centroid = slices.sum(), np.array([0.0, 0.0, slices @ points.z / slices.sum()])
    state = at(-5.0, 0.9, FULL, SHAPE)
    buoyancy = RHO * G * volume * state.rotation[2]
    expected = skew(centroid) @ buoyancy
    force = Hydrostatic(FULL, RHO, G)(0.0, state)
    np.testing.assert_allclose(force[3:6], expected, atol=1e-11 * np.abs(buoyancy).max())
    assert np.abs(expected).max() > 100.0


@pytest.mark.parametrize("tilt", [0.0, 0.05, 0.59, 1.2, np.pi / 2, 2.55, 3.1])
@pytest.mark.parametrize("part", [-0.995, -0.95, 0.95, 0.995])
def test_sphere_nearly_dry_or_submerged_obeys_archimedes(part, tilt):
    """The circle of a small cap crosses a meridian twice within a few degrees."""
    height = part * DEVICE.radius
    force, scale = Hydrostatic(RIGID, RHO, G)(0.0, at(height, tilt, RIGID)), RHO * G * cap(-9.0)
    np.testing.assert_allclose(force[:3], [0.0, 0.0, RHO * G * cap(height)], rtol=1e-9, atol=1e-12 * scale)
    np.testing.assert_allclose(force[3:], 0.0, atol=1e-12 * scale)
