"""Six rigid coordinates and shell modes: Lagrange's equation of particles, exact motions, hydrostatics."""

import numpy as np
import pytest
from conftest import SEED
from scipy.linalg import expm, sqrtm
from scipy.spatial.transform import Rotation

from examples.paper_rotations import AXIS, Body, Elastic, GeneralScene, Hydrostatic, State, Weight, integrate, skew
from vsb.engine.shell.modes import ModeBasis, mode_basis, rigid_basis
from vsb.study import study as config

G = 9.81
DEVICE = config.load(SEED).device
BASES = {name: mode_basis(DEVICE, name, 3) for name in ("paper", "membrane", "full")}
RIGID = rigid_basis(DEVICE)
ARMS = (0.5, 0.8)  # the ballast as six points, four on the equator and two on the axis [m]


@pytest.fixture(params=["paper", "full"])
def basis(request) -> ModeBasis:
    return BASES[request.param]


def ballast_inertia(basis):
    sixth = (basis.total_mass - basis.shell.mass) / 6
    return sixth * 2 * (ARMS[0] ** 2 + ARMS[1] ** 2), sixth * 4 * ARMS[0] ** 2


def body_of(basis) -> Body:
    return Body(basis, ballast_inertia(basis))


def particles(basis, rows=12, columns=7):
    """Mass (p,), undeformed place (p, 3) and shapes (p, mode, 3) of the shell and of the ballast's six points."""
    cos, weight = np.polynomial.legendre.leggauss(rows)
    azimuth = 2 * np.pi * np.arange(columns) / columns
    phi, theta = (grid.ravel() for grid in np.meshgrid(np.arccos(cos), azimuth, indexing="ij"))
    e_r = np.stack([np.sin(phi) * np.cos(theta), np.sin(phi) * np.sin(theta), np.cos(phi)], axis=1)
    e_phi = np.stack([np.cos(phi) * np.cos(theta), np.cos(phi) * np.sin(theta), -np.sin(phi)], axis=1)
    v, u = (shape[1:].T[:, :, None] for shape in basis.displacement(phi))
    shell = basis.shell
    mass = np.repeat(weight / 2, columns) / columns * shell.mass
    points = np.diag([ARMS[0], ARMS[0], ARMS[1]])
    points = np.concatenate([points, -points])
    ballast = np.full(6, (basis.total_mass - shell.mass) / 6)
    shapes = np.concatenate([u * e_phi[:, None] + v * e_r[:, None], np.zeros((6, len(basis.modes), 3))])
    return np.concatenate([mass, ballast]), np.concatenate([shell.radius * e_r, points]), shapes


def tumbling(scene, seed=0, spin=2.0):
    """A state vector with everything displaced and everything moving."""
    rng = np.random.default_rng(seed)
    parts = {name: rng.normal(size=size) for name, size in scene.sizes.items()}
    parts["modal_amplitude"] *= 0.05
    parts["angular_velocity"] *= spin
    if scene.motion == "free":
        parts["attitude"] /= np.linalg.norm(parts["attitude"])
    elif scene.motion != "heave":
        parts["attitude"] = 0.5 * np.tanh(parts["attitude"])
    return scene.start(**parts)


# --- the equation of motion against Lagrange's, from particles ------------------------------------------------------


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    i, j = [k for k in range(3) if k != axis]
    if axis == 1:
        s = -s
    matrix = np.eye(3, dtype=np.asarray(angle).dtype)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


class Particles:
    """The buoy as particles placed by q = (centre, yaw, pitch, roll, modal_amplitude): it knows no quasi-velocity."""

    def __init__(self, basis):
        self.basis = basis
        self.mass, self.at, self.shapes = particles(basis, rows=8, columns=6)

    def place(self, q):
        rotation = turn(2, q[3]) @ turn(1, q[4]) @ turn(0, q[5])
        return q[:3] + (self.at + np.einsum("pjk,j->pk", self.shapes, q[6:])) @ rotation.T

    def matrix(self, q):
        """Mass matrix of Lagrange's equation; Jacobian of the places by complex step."""
        step = 1e-30
        jacobian = np.array([self.place(q + 1j * step * e).imag / step for e in np.eye(len(q))])
        return np.einsum("ipk,p,jpk->ij", jacobian, self.mass, jacobian)

    def potential(self, q):
        return G * self.mass @ self.place(q)[:, 2] + 0.5 * q[6:] @ self.basis.stiffness[1:, 1:] @ q[6:]

    def velocity_terms(self, q, qd):
        """d/dt(M) q' - 1/2 d(q'.M q')/dq by differences of sixth order."""
        h, terms = 2e-3, ((1, 0.75), (2, -0.15), (3, 1 / 60))

        def slope(e):
            return sum(w * (self.matrix(q + k * h * e) - self.matrix(q - k * h * e)) for k, w in terms) / h

        slopes = np.array([slope(e) for e in np.eye(len(q))])
        return np.einsum("kij,k,j->i", slopes, qd, qd) - 0.5 * np.einsum("kij,i,j->k", slopes, qd, qd)


def eq_78(angles):
    """Angular velocity in body axes per rate of (yaw, pitch, roll)."""
    _, b, c = angles
    return np.array([
        [-np.sin(b), 0, 1],
        [np.cos(b) * np.sin(c), np.cos(c), 0],
        [np.cos(b) * np.cos(c), -np.sin(c), 0],
    ])  # fmt: skip


def eq_79(angles, rates):
    """Time derivative of Eq. 78."""
    (_, b, c), (_, bd, cd) = angles, rates
    sb, cb, sc, cc = np.sin(b), np.cos(b), np.sin(c), np.cos(c)
    return -np.array([
        [bd * cb, 0, 0],
        [bd * sb * sc - cd * cb * cc, cd * sc, 0],
        [bd * sb * cc + cd * cb * sc, cd * cc, 0],
    ])  # fmt: skip


@pytest.mark.parametrize("seed", [0])
def test_rates_satisfy_lagranges_equation(basis, seed):
    forces = {"weight": Weight(basis, G), "elastic": Elastic(basis)}
    scene, model = GeneralScene(body_of(basis), forces, "free"), Particles(basis)
    y = tumbling(scene, seed)
    half = len(y) // 2  # coordinates with three angles in place of a quaternion
    angles = Rotation.from_quat(y[3:7], scalar_first=True).as_euler("ZYX")
    q, velocity, acceleration = np.concatenate([y[:3], angles, y[7:-half]]), y[-half:], scene.rates(0.0, y)[-half:]
    qd, qdd = velocity.copy(), acceleration.copy()
    qd[3:6] = np.linalg.solve(eq_78(angles), velocity[3:6])
    qdd[3:6] = np.linalg.solve(eq_78(angles), acceleration[3:6] - eq_79(angles, qd[3:6]) @ qd[3:6])
    force = -np.array([model.potential(q + 1e-30j * e).imag / 1e-30 for e in np.eye(half)])
    terms = model.velocity_terms(q, qd)
    residual = model.matrix(q) @ qdd + terms - force
    assert np.abs(terms[3:]).min() > 1.0
    assert np.abs(residual).max() < 1e-9 * np.abs(terms).max()


# --- scenes of one equation -----------------------------------------------------------------------------------------


def structural_damping(basis):
    """Rayleigh damping of the shell's own motion, -D eta'."""
    return lambda time, state: np.concatenate([np.zeros(6), -basis.damping[1:, 1:] @ state.modal_amplitude_rate])


def heave_damper(time, state):
    """Between the sphere centre and the sea bed, Eq. 91."""
    return -8000.0 * state.velocity[2] * np.eye(6 + len(state.modal_amplitude))[2]


def all_forces(basis):
    return {
        "weight": Weight(basis, G),
        "elastic": Elastic(basis),
        "structural_damping": structural_damping(basis),
        "pto": heave_damper,
    }


def lifted(scene, y, general):
    """The same state in the coordinates of a free scene with quaternion."""
    parts = dict(zip(scene.sizes, np.split(y, np.cumsum(list(scene.sizes.values()))[:-1]), strict=True))
    state = scene.state(y)
    pitch = parts["attitude"][0] if parts["attitude"].size else 0.0
    return general.start(
        position=state.position,
        attitude=np.array([np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0]),
        modal_amplitude=parts["modal_amplitude"],
        velocity=state.velocity,
        angular_velocity=state.angular_velocity,
        modal_amplitude_rate=parts["modal_amplitude_rate"],
    )


@pytest.mark.parametrize("motion", ["heave", "planar"])
def test_restricted_motions_match_the_general_equation(basis, motion):
    forces = all_forces(basis)
    scene, general = GeneralScene(body_of(basis), forces, motion), GeneralScene(body_of(basis), forces, "free")
    y = tumbling(scene, 3)
    dof = len(basis.modes)
    general_rates = general.rates(0.0, lifted(scene, y, general))
    own = scene.rates(0.0, y)[-sum(list(scene.sizes.values())[3:]) :]
    kept = {"heave": [2], "planar": [0, 2, 4]}[motion]
    acceleration = general_rates[-(6 + dof) :]
    scale = np.abs(own).max()
    np.testing.assert_allclose(own, acceleration[[*kept, *range(6, 6 + dof)]], atol=1e-13 * scale)
    dropped = [i for i in range(6) if i not in kept]
    assert np.abs(acceleration[dropped]).max() < 1e-13 * scale


@pytest.mark.parametrize("colatitudes", [[np.pi / 2], [0.0, 0.0]])
def test_null_space_and_udwadia_kalaba_agree(basis, colatitudes):
    """Eq. 90 with b = 0, since clamps are linear in the modal amplitudes."""
    forces = all_forces(basis)
    allowed = basis.clamped(colatitudes)
    scene = GeneralScene(body_of(basis), forces, "free", motions=allowed)
    free = GeneralScene(body_of(basis), forces, "free")
    y = tumbling(scene, 6)
    state = scene.state(y)
    unclamped = lifted_amplitudes(scene, y, free, allowed[1:, 1:])
    matrix = free.body.mass_matrix(state)
    rows = np.pad(basis.clamp_rows(colatitudes)[:, 1:], ((0, 0), (6, 0)))
    unconstrained = free.rates(0.0, unclamped)[-len(matrix) :]
    root = np.linalg.inv(np.real(sqrtm(matrix)))
    constrained = unconstrained + root @ np.linalg.pinv(rows @ root, rcond=1e-10) @ (-rows @ unconstrained)
    own = scene.rates(0.0, y)[-(6 + allowed.shape[1] - 1) :]
    np.testing.assert_allclose(own[:6], constrained[:6], atol=1e-10 * np.abs(constrained).max())
    np.testing.assert_allclose(allowed[1:, 1:] @ own[6:], constrained[6:], atol=1e-10 * np.abs(constrained).max())
    assert np.abs(constrained - unconstrained).max() > 1e-3 * np.abs(unconstrained).max()


def lifted_amplitudes(scene, y, free, null_space):
    parts = dict(zip(scene.sizes, np.split(y, np.cumsum(list(scene.sizes.values()))[:-1]), strict=True))
    for name in ("modal_amplitude", "modal_amplitude_rate"):
        parts[name] = null_space @ parts[name]
    return free.start(**parts)


# --- exact motions --------------------------------------------------------------------------------------------------


def test_axisymmetric_body_precesses():
    """R = exp(H t/Jt) R0 exp(-l t e3), w = (A cos l t, A sin l t, n) with l = n (Ja - Jt)/Jt."""
    body = Body(RIGID, (4000.0, 7000.0))
    scene = GeneralScene(body, {}, "free")
    amplitude, n = 0.7, 1.3
    start = scene.start(angular_velocity=np.array([amplitude, 0.0, n]))
    first = scene.state(start)
    momentum = first.rotation @ body.mass_matrix(first)[3:6] @ first.quasi_velocities
    transverse, _, axial = body.inertia(np.zeros(0))
    rate = n * (axial - transverse) / transverse
    assert rate > 0.5
    time = np.linspace(0, 20, 9)
    for t, y in zip(time, integrate(scene, start, time, 1e-12), strict=True):
        state = scene.state(y)
        w = [amplitude * np.cos(rate * t), amplitude * np.sin(rate * t), n]
        np.testing.assert_allclose(state.angular_velocity, w, atol=1e-9)
        rotation = expm(t / transverse * skew(momentum)) @ expm(-rate * t * skew(AXIS))
        np.testing.assert_allclose(state.rotation, rotation, atol=1e-9)


RHO = 1025.0
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
@pytest.mark.parametrize("height", [-1.2, 0.7])
def test_sphere_obeys_archimedes_without_torque(height, tilt):
    water = Hydrostatic(RIGID, RHO, G)
    force = water(0.0, at(height, tilt, RIGID))
    scale = RHO * G * cap(-9.0)
    np.testing.assert_allclose(force[:3], [0.0, 0.0, RHO * G * cap(height)], rtol=1e-12, atol=1e-12 * scale)
    np.testing.assert_allclose(force[3:], 0.0, atol=1e-12 * scale)


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


REFUSED = [
    (lambda: Body(RIGID, (1.0, 2.1)), r"ballast_inertia: received .*needs \(transverse, axial\)"),
    (
        lambda: GeneralScene(Body(BASES["membrane"]), motions=np.eye(5)[:, ::-1]),
        r"motions: received .*ModeBasis.clamped",
    ),
    (lambda: GeneralScene(Body(RIGID)).start(velocity=np.ones(3)), r"received velocity \(3,\), a heave scene needs"),
    (lambda: GeneralScene(Body(RIGID)).rates(0.0, np.zeros(5)), r"received state \(5,\), a heave scene needs \(2,\)"),
]


@pytest.mark.parametrize(("made", "message"), REFUSED)
def test_impossible_bodies_and_states_are_refused(made, message):
    with pytest.raises(ValueError, match=message):
        made()
