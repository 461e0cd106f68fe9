"""Equation of motion of the shell with six rigid coordinates and the modal amplitudes, Eqs. 80-90.

A shell particle is at x = r + R (s + sum eta_j psi_j): r the sphere centre (inertial axes), R the attitude (body to
inertial axes), s on the undeformed sphere, psi_j = u_j e_phi + v_j e_r the shapes. The ballast is a point at the centre
with an inertia tensor of its own. The velocities are quasi-velocities: that of the centre in inertial axes, the angular
velocity w in body axes, the modal rates. Strains are linear, inertia exact: the stiffening by centrifugal tension is
missing, of order (w/natural frequency)^2.

The water sees a tilt only through the slope s of the body's axis: the height of a point of the shell is
Z = A + B cos(theta), A = centre height + c zeta, B = s x, with theta the azimuth from the upward side, x and zeta the
meridian's radius and height along the axis, c and s cosine and sine of the tilt. On every circle of colatitude the wet
arc is known, so azimuth is integrated in closed form; what remains is one integral along the meridian.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple, Protocol

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag, solve
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from vsb.engine.shell.deformed import DeformedShell, Meridian
from vsb.engine.shell.modes import ModeBasis
from vsb.errors import StabilityError
from vsb.tools.arrays import FloatArray

AXIS = np.array([0.0, 0.0, 1.0])  # body axis of symmetry, through the top pole


def skew(vector: FloatArray) -> FloatArray:
    """Return the matrix of the cross product, skew(a) b = a x b, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


class State(NamedTuple):
    """Where the body is and how it moves, in full whatever the scene."""

    position: FloatArray  # centre, inertial axes, (3,) [m]
    rotation: FloatArray  # R, body to inertial axes, (3, 3) [-]
    modal_amplitude: FloatArray  # eta (mode,) [m]
    velocity: FloatArray  # of the centre, inertial axes, (3,) [m/s]
    angular_velocity: FloatArray  # w, body axes, (3,) [rad/s]
    modal_amplitude_rate: FloatArray  # (mode,) [m/s]

    @property
    def quasi_velocities(self) -> FloatArray:
        """Velocity, angular velocity and modal rates, shape (6 + mode,)."""
        return np.concatenate([self.velocity, self.angular_velocity, self.modal_amplitude_rate])


class Force(Protocol):
    """Function of (time, state): generalized force over the quasi-velocities, shape (6 + mode,) [N, N m, N]."""

    def __call__(self, time: float, state: State, /) -> FloatArray:
        """Return the generalized force."""


@dataclass(frozen=True)
class Weight:
    """Weight of shell and ballast. The deformed shell's centre of mass may lie off the sphere centre, unlike Eq. 20.

    Uniform gravity is an upward acceleration of the frame: the force is -g times the heave column of the mass matrix.
    """

    basis: ModeBasis
    gravity: float  # [m/s^2]

    def __call__(self, time: float, state: State) -> FloatArray:
        """Return the generalized force, shape (6 + mode,) [N, N m, N]."""
        mass, moments = self.basis.inertia[0, 0], self.basis.inertia[0, 1:]
        up = state.rotation[2]  # the vertical in body axes
        torque = moments @ state.modal_amplitude * skew(AXIS) @ up
        return -self.gravity * np.concatenate([[0.0, 0.0, mass], torque, moments * up[2]])


@dataclass(frozen=True)
class Elastic:
    """Elastic force of the shell, -K eta."""

    basis: ModeBasis

    def __call__(self, time: float, state: State) -> FloatArray:
        """Return the generalized force, shape (6 + mode,) [N, N m, N]."""
        return np.concatenate([np.zeros(6), -self.basis.stiffness[1:, 1:] @ state.modal_amplitude])


@dataclass(frozen=True)
class Body:
    """Inertia of shell and ballast: constant, linear and quadratic in the modal amplitudes, exactly.

    T = 1/2 m v.v + 1/2 w.J(eta) w + 1/2 eta'.M eta' + v.R (S w x e3 + S' e3), with S(eta) = sum eta_j a_j and
    a_j e3 = int psi_j dm. Eq. 17 drops every product of two different velocities. Of these,

    - w.int rho x rho' dm vanishes always: both vectors lie in a meridian plane, so the integrand points along e_theta
      and its integral over the azimuth is zero (no torsion; in particular int s x psi_j dm = 0);
    - the two with S vanish if and only if all a_j = 0, that is if the modes are orthogonal to rigid heave: all are but
      the paper's slipped shape of degree 1. They are kept: with a_j = 0 they add nothing.
    """

    basis: ModeBasis
    ballast_inertia: tuple[float, float] = (0.0, 0.0)  # about the centre: transverse, axial [kg m^2]

    def __post_init__(self) -> None:
        """Check that some distribution of mass has the ballast's inertia."""
        if not 0.0 <= self.ballast_inertia[1] <= 2.0 * self.ballast_inertia[0] < np.inf:
            raise ValueError(
                f"ballast_inertia: received {self.ballast_inertia}, needs (transverse, axial), axial <= 2 transverse."
            )

    @property
    def moments(self) -> FloatArray:
        """First mass moment per unit modal amplitude, a_j = int psi_j.e3 dm, shape (mode,) [kg]."""
        return self.basis.inertia[0, 1:]

    @cached_property
    def _inertia_polynomial(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coefficients of diag J: constant (3,) [kg m^2], linear (3, mode) [kg m], quadratic (3, mode, mode) [kg].

        In cos(phi) the squares of the meridian's radius x and height z are polynomials of degree at most 2 (n + 1):
        n + 2 Gauss-Legendre points are exact.
        """
        shell = self.basis.shell
        cos, weight = np.polynomial.legendre.leggauss(self.basis.highest_degree + 2)
        sin, dm = np.sqrt(1.0 - cos**2), 0.5 * shell.mass * weight
        v, u = (shape[1:] for shape in self.basis.displacement(np.arccos(cos)))
        x = np.vstack([shell.radius * sin, v * sin + u * cos])  # undeformed, then per unit amplitude
        z = np.vstack([shell.radius * cos, v * cos - u * sin])
        axial, along = (x * dm) @ x.T, (z * dm) @ z.T
        form = np.stack([axial / 2 + along, axial / 2 + along, axial])
        return form[:, 0, 0] + np.take(self.ballast_inertia, [0, 0, 1]), 2.0 * form[:, 0, 1:], form[:, 1:, 1:]

    def inertia(self, modal_amplitude: FloatArray) -> FloatArray:
        """Return the diagonal (Jt, Jt, Ja) of J about the centre in body axes, shape (3,) [kg m^2]."""
        constant, linear, quadratic = self._inertia_polynomial
        return constant + (linear + quadratic @ modal_amplitude) @ modal_amplitude

    def inertia_gradient(self, modal_amplitude: FloatArray) -> FloatArray:
        """Return the derivative of `inertia` by the modal amplitudes, shape (3, mode) [kg m]."""
        _, linear, quadratic = self._inertia_polynomial
        return linear + 2.0 * quadratic @ modal_amplitude

    def mass_matrix(self, state: State) -> FloatArray:
        """Return M(R, eta) of T = 1/2 V.M V over the quasi-velocities V, shape (6 + mode, 6 + mode) [kg, kg m^2]."""
        matrix = np.zeros((6 + len(self.moments), 6 + len(self.moments)))
        matrix[:3, :3] = self.basis.total_mass * np.eye(3)
        matrix[:3, 3:6] = -(self.moments @ state.modal_amplitude) * state.rotation @ skew(AXIS)
        matrix[:3, 6:] = np.outer(state.rotation @ AXIS, self.moments)
        matrix[3:, :3] = matrix[:3, 3:].T
        matrix[3:6, 3:6] = np.diag(self.inertia(state.modal_amplitude))
        matrix[6:, 6:] = self.basis.inertia[1:, 1:]
        return matrix

    def velocity_terms(self, state: State) -> FloatArray:
        """Return the terms quadratic in the velocities: M V' + these = forces; shape (6 + mode,) [N, N m, N].

        Force R (2 S' w x e3 + S w x (w x e3)); torque J' w + w x J w; modal -1/2 w.(dJ/deta) w. Eq. 33 has J' w only:
        w x J w comes of the body axes. Eq. 69 has no centrifugal force on the modes, without which energy is not
        conserved. Modal Coriolis forces vanish: int psi_j.(w x psi_k) dm = 0.
        """
        w, spin = state.angular_velocity, skew(state.angular_velocity)
        moment, moment_rate = self.moments @ state.modal_amplitude, self.moments @ state.modal_amplitude_rate
        gradient = self.inertia_gradient(state.modal_amplitude)
        force = state.rotation @ (2.0 * moment_rate * spin + moment * spin @ spin) @ AXIS
        torque = (gradient @ state.modal_amplitude_rate) * w + spin @ (self.inertia(state.modal_amplitude) * w)
        return np.concatenate([force, torque, -0.5 * w**2 @ gradient])

    def kinetic_energy(self, state: State) -> float:
        """Return T [J]."""
        return float(0.5 * state.quasi_velocities @ self.mass_matrix(state) @ state.quasi_velocities)


def _quaternion_rates(q: FloatArray, w: FloatArray) -> FloatArray:
    """Rates 1/2 q (0, w): normal to q, so the norm stays as good as the integration."""
    return 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + skew(q[1:]) @ w])


class Attitude(NamedTuple):
    """Coordinates of a rotation and their kinematics."""

    unturned: FloatArray  # coordinates of R = 1
    rotation: Callable[[FloatArray], FloatArray]  # coordinates -> R (3, 3)
    rates: Callable[[FloatArray, FloatArray], FloatArray]  # coordinates, w (body axes) -> their rates


_ATTITUDES = {
    "heave": Attitude(np.zeros(0), lambda none: np.eye(3), lambda none, w: none),
    "planar": Attitude(np.zeros(1), lambda pitch: Rotation.from_euler("y", pitch[0]).as_matrix(), lambda p, w: w[1:2]),
    "free": Attitude(
        np.array([1.0, 0.0, 0.0, 0.0]),
        lambda q: Rotation.from_quat(q, scalar_first=True).as_matrix(),  # of its direction, whatever its norm
        _quaternion_rates,
    ),
}
_RIGID = {"heave": ((2,), ()), "planar": ((0, 2), (4,)), "free": ((0, 1, 2), (3, 4, 5))}  # among quasi-velocities
_PARTS = ("position", "attitude", "modal_amplitude", "velocity", "angular_velocity", "modal_amplitude_rate")


@dataclass(frozen=True)
class GeneralScene:
    """One motion of one body under named forces, in the coordinates it needs and no others.

    The state vector is (translations, attitude, free modal amplitudes, their velocities): heave; surge, heave and
    pitch; or three translations and a quaternion (scalar first). Velocities are quasi-velocities.
    """

    body: Body
    forces: Mapping[str, Force] = field(default_factory=dict)
    motion: Literal["heave", "planar", "free"] = "heave"
    motions: FloatArray | None = None  # allowed N (dof, free), heave first, as of `ModeBasis.clamped`; None: all

    def __post_init__(self) -> None:
        """Check that the allowed motions keep heave and shell apart."""
        dof = len(self.body.basis.labels)
        allowed = np.eye(dof) if self.motions is None else self.motions
        if not np.array_equal(allowed[:, :1], np.eye(dof, 1)) or allowed[0, 1:].any():
            raise ValueError(
                f"motions: received {allowed.shape}, needs ({dof}, free), heave first and alone; use ModeBasis.clamped."
            )

    @cached_property
    def _directions(self) -> FloatArray:
        """Quasi-velocities per velocity of the scene, shape (6 + mode, velocity); eta = N y, no multiplier (Eq. 87)."""
        allowed = np.eye(len(self.body.basis.labels)) if self.motions is None else self.motions
        rigid = np.eye(6)[:, np.concatenate(_RIGID[self.motion]).astype(int)]
        return block_diag(rigid, allowed[1:, 1:])

    @property
    def _attitude(self) -> Attitude:
        return _ATTITUDES[self.motion]

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Numbers of translations, attitude coordinates and free modal amplitudes, then of the velocities of each."""
        moves, turns = map(len, _RIGID[self.motion])
        free = self._directions.shape[1] - moves - turns
        return dict(zip(_PARTS, (moves, len(self._attitude.unturned), free, moves, turns, free), strict=True))

    def start(self, **given: FloatArray) -> FloatArray:
        """Return a state vector from its parts, named and sized as in `sizes`; the rest is undisplaced and at rest."""
        parts = {name: np.zeros(size) for name, size in self.sizes.items()} | {"attitude": self._attitude.unturned}
        for name, values in given.items():
            if name not in parts or np.shape(values) != parts[name].shape:
                raise ValueError(
                    f"start: received {name} {np.shape(values)}, a {self.motion} scene needs {self.sizes}."
                )
        return np.concatenate(list((parts | given).values()), dtype=float)

    def _split(self, y: FloatArray) -> list[FloatArray]:
        """Take a state vector apart into position, attitude, modal amplitudes and the three kinds of velocities."""
        ends = np.cumsum(list(self.sizes.values()))
        if y.shape != (ends[-1],):
            raise ValueError(
                f"received state {y.shape}, a {self.motion} scene needs ({ends[-1]},): use GeneralScene.start."
            )
        return np.split(y, ends[:-1])

    def state(self, y: FloatArray) -> State:
        """Return the state of the body in full, from a state vector."""
        position, attitude, modal_amplitude, *velocities = self._split(y)
        turned = np.zeros(self.sizes["angular_velocity"])  # the attitude is no integral of w
        place = self._directions @ np.concatenate([position, turned, modal_amplitude])
        moving = self._directions @ np.concatenate(velocities)
        return State(place[:3], self._attitude.rotation(attitude), place[6:], moving[:3], moving[3:6], moving[6:])

    def rates(self, time: float, y: FloatArray) -> FloatArray:
        """Return dy/dt: N^T M N a = N^T (forces - velocity terms), and the kinematics of the attitude."""
        state, (_, attitude, _, velocity, _, modal_amplitude_rate) = self.state(y), self._split(y)
        drive = sum((force(time, state) for force in self.forces.values()), -self.body.velocity_terms(state))
        allowed = self._directions
        acceleration = solve(allowed.T @ self.body.mass_matrix(state) @ allowed, allowed.T @ drive, assume_a="pos")
        turning = self._attitude.rates(attitude, state.angular_velocity)
        return np.concatenate([velocity, turning, modal_amplitude_rate, acceleration])


def integrate(
    scene: GeneralScene, start: FloatArray, time: FloatArray, rtol: float = 1e-9, atol: float = 1e-12
) -> FloatArray:
    """Return the motion of a scene from `start` at time[0], shape (time, state), by DOP853 with step control.

    Raises `StabilityError` if no step is small enough.
    """
    span = (time[0], time[-1])
    run = solve_ivp(scene.rates, span, start, "DOP853", time, rtol=rtol, atol=atol)
    if run.status < 0:
        raise StabilityError(f"no step reaches t = {span[1]:g} s ({run.message}): needs bounded forces; mend them.")
    return np.asarray(run.y.T)


class _Tilted(NamedTuple):
    """The deformed shell over still water, as far as the water can tell."""

    shell: DeformedShell  # in body axes
    height: float  # of the sphere centre above still water [m]
    cos: float  # of the tilt
    sin: float
    upward: FloatArray  # direction of theta = 0 in body axes, (3,)

    @classmethod
    def of(cls, basis: ModeBasis, state: State) -> "_Tilted":
        """Return the shell of a state."""
        up = state.rotation[2]  # the vertical in body axes
        azimuth = np.arctan2(up[1], up[0])
        upward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        shell = DeformedShell(basis, 0.0, np.concatenate([[0.0], state.modal_amplitude]))
        return cls(shell, float(state.position[2]), float(up[2]), float(np.hypot(up[0], up[1])), upward)

    def heights(self, colatitude: FloatArray, side: int) -> FloatArray:
        """Heights of the upward (+1) or downward (-1) meridian above still water, shape (point,) [m]."""
        m = self.shell.meridian(colatitude)
        return self.height + self.cos * m.z + side * self.sin * m.x

    def edges(self) -> list[float]:
        """Colatitudes between which the wet arc varies smoothly: poles, and circles that touch the water plane."""
        grid = np.linspace(0.0, np.pi, 40 * (self.shell.basis.highest_degree + 1) + 1)
        found = {0.0, float(np.pi)}
        for side in (1, -1) if self.sin else (1,):
            wet = self.heights(grid, side) < 0
            for i in np.flatnonzero(wet[1:] != wet[:-1]):
                found.add(float(brentq(self._height, grid[i], grid[i + 1], args=(side,), xtol=1e-15, rtol=1e-15)))
        return sorted(found)

    def _height(self, colatitude: float, side: int) -> float:
        return float(self.heights(np.array([colatitude]), side)[0])


def _wet_cosines(a: FloatArray, b: FloatArray) -> FloatArray:
    """Integrals of cos^k(theta) over the wet arc a + b cos(theta) < 0, b >= 0, shape (4, point)."""
    dry = np.arctan2(np.sqrt(np.maximum(b**2 - a**2, 0.0)), -a)  # half of the dry arc: 0 wet all round, pi dry
    wet, sin, cos = np.pi - dry, np.sin(dry), np.cos(dry)
    return np.array([2 * wet, -2 * sin, wet - sin * cos, -2 * sin + 2 / 3 * sin**3])


@dataclass(frozen=True)
class Hydrostatic:
    """Pressure -rho g Z on the wet part of the tilted, deformed shell.

    Q = -int p n.(dr/dq) dS = rho g int Z n.(dr/dq) dS with n dS = x (-zeta' e_x + x' e_3) dphi dtheta in body axes.
    Where a circle of colatitude touches the water's plane the integrand is as smooth as a power 3/2; the points crowd
    there like a sine, which makes it analytic: convergence is spectral at every tilt. No tilt, no azimuth: the force
    is `DeformedShell.hydrostatic_force`.
    """

    basis: ModeBasis
    density: float  # of the water [kg/m^3]
    gravity: float  # [m/s^2]
    points: int = 40  # per piece of the meridian

    def _quadrature(self, tilted: _Tilted) -> tuple[Meridian, FloatArray, FloatArray, FloatArray]:
        """Return points of the wet meridian, weights, A [m] and B [m], over all pieces with any water."""
        node, weight = np.polynomial.legendre.leggauss(self.points)
        place, weight = np.sin(np.pi / 2 * node), np.pi / 2 * np.cos(np.pi / 2 * node) * weight
        halves = [((a + b) / 2, (b - a) / 2) for a, b in itertools.pairwise(tilted.edges())]
        wet = [(middle, half) for middle, half in halves if tilted._height(middle, -1) < 0]
        m = tilted.shell.meridian(np.concatenate([np.zeros(0), *(middle + half * place for middle, half in wet)]))
        weights = np.concatenate([np.zeros(0), *(half * weight for _, half in wet)])
        return m, weights, tilted.height + tilted.cos * m.z, tilted.sin * m.x

    def __call__(self, time: float, state: State) -> FloatArray:
        """Return the generalized force, shape (6 + mode,) [N, N m, N]: inertial axes, body axes, modal."""
        tilted = _Tilted.of(self.basis, state)
        m, weight, a, b = self._quadrature(tilted)
        c = _wet_cosines(a, b)
        scale = self.density * self.gravity * weight * m.x
        mean, upward = scale * (a * c[0] + b * c[1]), scale * (a * c[1] + b * c[2])  # Z over the wet arc, Z cos(theta)
        along_shapes = (-m.dz * m.shape_x + m.dx * m.shape_z) @ mean  # heave's shape is e_3: the force along the axis
        axis = np.array([0.0, 0.0, 1.0])
        force = along_shapes[0] * axis - (m.dz @ upward) * tilted.upward
        torque = -((m.z * m.dz + m.x * m.dx) @ upward) * skew(axis) @ tilted.upward
        return np.concatenate([state.rotation @ force, torque, along_shapes[1:]])

    def potential(self, state: State) -> float:
        """Return the energy of the water displaced, rho g int (-Z) dV = -rho g/2 int Z^2 n_Z dS [J]."""
        tilted = _Tilted.of(self.basis, state)
        m, weight, a, b = self._quadrature(tilted)
        c = _wet_cosines(a, b)
        square, upward = (a**2 * c[k] + 2 * a * b * c[k + 1] + b**2 * c[k + 2] for k in (0, 1))
        lift = tilted.cos * m.dx * square - tilted.sin * m.dz * upward
        return float(-0.5 * self.density * self.gravity * (weight * m.x) @ lift)
