import itertools

import numpy as np
import pytest
from conftest import SEED
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from vsb.motion.sixdof.body import Body, Elastic, GeneralScene, State, Weight, integrate, skew
from vsb.motion.sixdof.hydrostatics import Hydrostatic
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
def test_a_sphere_obeys_archimedes_and_feels_no_torque(height, tilt):
    water = Hydrostatic(RIGID, RHO, G)
    force = water(0.0, at(height, tilt, RIGID))
    scale = RHO * G * cap(-9.0)
    np.testing.assert_allclose(force[:3], [0.0, 0.0, RHO * G * cap(height)], rtol=1e-12, atol=1e-12 * scale)
    np.testing.assert_allclose(force[3:], 0.0, atol=1e-12 * scale)


@pytest.mark.parametrize("height", [-2.6, -1.4, 0.0, 0.3, 1.9, 2.6])
def test_without_tilt_it_is_the_force_on_the_upright_shell(height):
    force = Hydrostatic(FULL, RHO, G)(0.0, at(height, 0.0, FULL, SHAPE))
    upright = DeformedShell(FULL, height, np.concatenate([[0.0], SHAPE])).hydrostatic_force(RHO, G)
    np.testing.assert_allclose(force[[2, *range(6, len(force))]], upright, rtol=1e-11, atol=1e-8)
    np.testing.assert_allclose(force[[0, 1, 3, 4, 5]], 0.0, atol=1e-9)


@pytest.mark.parametrize("height", [-0.6, 0.0, 0.8])
def test_an_upside_down_buoy_is_the_mirrored_one(height):
    """Modes of odd degree change sign in the mirror z -> -z of the body, those of even degree do not."""
    sign = np.array([(-1.0) ** mode.degree for mode in FULL.modes])
    down = Hydrostatic(FULL, RHO, G)(0.0, at(height, np.pi, FULL, SHAPE))
    up = Hydrostatic(FULL, RHO, G)(0.0, at(height, 0.0, FULL, sign * SHAPE))
    np.testing.assert_allclose(down[6:], sign * up[6:], atol=1e-11 * RHO * G * cap(-9.0))
    assert down[2] == pytest.approx(up[2], rel=1e-12)


def by_azimuths(basis, state, columns=160, points=40):
    """The same force as a sum over meridians: trapezoid in azimuth, Gauss between the waterlines of each meridian."""
    shell = DeformedShell(basis, 0.0, np.concatenate([[0.0], state.modal_amplitude]))
    up = state.rotation[2]
    node, weight = np.polynomial.legendre.leggauss(points)
    force, torque, modal = np.zeros(3), np.zeros(3), np.zeros(len(basis.modes))
    for theta in 2 * np.pi * np.arange(columns) / columns:
        outward = np.array([np.cos(theta), np.sin(theta), 0.0])

        def height(phi, outward=outward):
            m = shell.meridian(np.atleast_1d(phi))
            return state.position[2] + m.x * (outward @ up) + m.z * up[2]

        grid = np.linspace(0, np.pi, 61)
        z = height(grid)
        found = [
            brentq(lambda phi: height(phi)[0], a, b, xtol=1e-14)
            for a, b, za, zb in zip(grid, grid[1:], z, z[1:], strict=False)
            if (za < 0) != (zb < 0)
        ]
        for a, b in itertools.pairwise([0.0, *found, np.pi]):
            if height((a + b) / 2)[0] > 0:
                continue
            phi = (a + b) / 2 + (b - a) / 2 * node
            m = shell.meridian(phi)
            dry = RHO * G * height(phi) * (b - a) / 2 * weight * 2 * np.pi / columns
            normal = m.x[:, None] * (-m.dz[:, None] * outward + m.dx[:, None] * np.array([0.0, 0.0, 1.0]))
            place = m.x[:, None] * outward + m.z[:, None] * np.array([0.0, 0.0, 1.0])
            force += dry @ normal
            torque += dry @ np.cross(place, normal)
            modal += (m.shape_x * (normal @ outward) + m.shape_z * normal[:, 2])[1:] @ dry
    return np.concatenate([state.rotation @ force, torque, modal])


@pytest.mark.parametrize(("height", "tilt"), [(0.1, 0.3), (-0.6, 0.5), (-2.6, 1.0)])
def test_it_is_the_sum_over_meridians(height, tilt):
    state = at(height, tilt, FULL, SHAPE)
    expected = by_azimuths(FULL, state)
    force = Hydrostatic(FULL, RHO, G)(0.0, state)
    np.testing.assert_allclose(force, expected, atol=1e-9 * np.abs(expected).max())
    assert np.abs(expected[3:6]).max() > 1e-3 * np.abs(expected).max()


def moved(state, coordinate, step):
    """The state displaced along one quasi-velocity: a turn is about a body axis."""
    push = step * np.eye(6 + len(state.modal_amplitude))[coordinate]
    turned = state.rotation @ Rotation.from_rotvec(push[3:6]).as_matrix()
    return state._replace(
        position=state.position + push[:3], rotation=turned, modal_amplitude=state.modal_amplitude + push[6:]
    )


@pytest.mark.parametrize("tilt", [0.4, np.pi / 2, 2.6])
@pytest.mark.parametrize("height", [-2.6, -1.5, 0.2, 1.6])
def test_the_force_is_minus_the_gradient_of_the_potential(height, tilt):
    """Central differences with two Richardson steps, at tilts with pole wet, dry, and the waterline across the pole."""
    water, state = Hydrostatic(FULL, RHO, G), at(height, tilt, FULL, SHAPE)

    def central(j, h):
        return (water.potential(moved(state, j, -h)) - water.potential(moved(state, j, h))) / (2 * h)

    h = 4e-3
    gradient = [(64 * central(j, h / 4) - 20 * central(j, h / 2) + central(j, h)) / 45 for j in range(6 + len(SHAPE))]
    force = water(0.0, state)
    np.testing.assert_allclose(force, gradient, atol=2e-7 * np.abs(force).max())
    np.testing.assert_allclose(force[:2], 0.0, atol=1e-9 * np.abs(force).max())
    assert force[5] == 0.0  # no torque about the axis of symmetry


@pytest.mark.parametrize("tilt", [0.0, 0.7, np.pi / 2])
def test_a_submerged_shell_feels_its_volume_at_every_depth(tilt):
    water = Hydrostatic(FULL, RHO, G)
    near, deep = (water(0.0, at(height, tilt, FULL, SHAPE)) for height in (-2.6, -9.0))
    volume = DeformedShell(FULL, -5.0, np.concatenate([[0.0], SHAPE])).volume()
    np.testing.assert_allclose([near[2], deep[2]], RHO * G * volume, rtol=1e-11)
    np.testing.assert_allclose(near[3:6], deep[3:6], atol=1e-9 * deep[2])  # a couple about the centre of buoyancy
    assert np.abs(deep[6:]).max() > 2 * np.abs(near[6:]).max()


def test_a_dry_shell_feels_nothing():
    water, state = Hydrostatic(FULL, RHO, G), at(2.6, 0.7, FULL, SHAPE)
    np.testing.assert_array_equal(water(0.0, state), 0.0)
    assert water.potential(state) == 0.0


@pytest.mark.parametrize(("height", "tilt"), [(0.3, 0.7), (0.0, np.pi / 2), (-1.7, 1.3)])
def test_quadrature_converges_spectrally_at_every_tilt(height, tilt):
    state = at(height, tilt, FULL, SHAPE)
    exact = Hydrostatic(FULL, RHO, G, 120)(0.0, state)
    forces = [Hydrostatic(FULL, RHO, G, points)(0.0, state) for points in (10, 20, 40)]
    errors = [np.abs(force - exact).max() / np.abs(exact).max() for force in forces]
    assert errors[0] > 100 * errors[1]
    assert errors[2] < 1e-12


def test_a_sphere_tilted_or_not_has_the_potential_of_a_cap():
    """The work of lifting it out of the water, rho g int_0^r cap(z) dz = rho g pi r^4/4."""
    water = Hydrostatic(RIGID, RHO, G)
    for tilt in TILTS:
        expected = RHO * G * np.pi * DEVICE.radius**4 / 4
        assert water.potential(at(0.0, tilt, RIGID)) == pytest.approx(expected, rel=1e-12)


def test_a_tumbling_floating_shell_keeps_its_energy():
    basis = mode_basis(DEVICE, "membrane", 2)
    forces = {"weight": Weight(basis, G), "elastic": Elastic(basis), "hydrostatic": Hydrostatic(basis, RHO, G, 24)}
    scene = GeneralScene(Body(basis, (3000.0, 2000.0)), forces, "free")
    moving = {
        "modal_amplitude": np.array([-0.05, 0.02, 0.04]),
        "velocity": np.array([0.4, 0.0, -0.8]),
        "angular_velocity": np.array([1.5, -2.0, 0.7]),
    }
    loose, tight = (integrate(scene, scene.start(**moving), np.linspace(0, 1, 6), rtol, rtol) for rtol in (1e-4, 1e-8))
    drifts = []
    for motion in (loose, tight):
        energies = np.array([scene.energy(y) for y in motion])
        drifts.append(np.ptp(energies.sum(axis=1)) / np.ptp(energies[:, 0]))
    assert drifts[1] < 1e-6
    assert drifts[0] > 10 * drifts[1]
    assert scene.state(tight[-1]).rotation[2, 2] < 0.0  # upside down by now


def test_the_planar_scene_is_the_free_one_restricted():
    forces = {"weight": Weight(FULL, G), "elastic": Elastic(FULL), "hydrostatic": Hydrostatic(FULL, RHO, G)}
    planar, free = (GeneralScene(Body(FULL), forces, motion) for motion in ("planar", "free"))
    pitch, modes = 0.9, len(FULL.modes)
    y = planar.start(position=np.array([1.0, 0.2]), attitude=np.array([pitch]), modal_amplitude=SHAPE)
    turned = np.array([np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0])
    whole = free.start(position=np.array([1.0, 0.0, 0.2]), attitude=turned, modal_amplitude=SHAPE)
    acceleration = free.rates(0.0, whole)[-(6 + modes) :]
    scale = np.abs(acceleration).max()
    own = planar.rates(0.0, y)[-(3 + modes) :]
    np.testing.assert_allclose(own, acceleration[[0, 2, 4, *range(6, 6 + modes)]], atol=1e-12 * scale)
    assert np.abs(acceleration[[1, 3, 5]]).max() < 1e-12 * scale
    assert abs(own[2]) > 1e-3


def test_the_torque_is_that_of_buoyancy_at_the_centre_of_buoyancy():
    """A submerged shell: torque = R^T((R c) x (0, 0, rho g V)), c the centroid of its volume."""
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
def test_a_sphere_all_but_out_of_the_water_or_in_it_obeys_archimedes(part, tilt):
    """A small cap is wet, or dry, about any point of it: its circle crosses a meridian twice within a few degrees."""
    height = part * DEVICE.radius
    force, scale = Hydrostatic(RIGID, RHO, G)(0.0, at(height, tilt, RIGID)), RHO * G * cap(-9.0)
    np.testing.assert_allclose(force[:3], [0.0, 0.0, RHO * G * cap(height)], rtol=1e-9, atol=1e-12 * scale)
    np.testing.assert_allclose(force[3:], 0.0, atol=1e-12 * scale)
