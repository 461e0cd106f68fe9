"""A scene as one equation in its natural modes, the form that every integrator solves; and the motion it returns.

    z' = A z + B (n(t, z) + Re sum w_j exp(-i omega_j t)),    z = (S p, p', x),

with p the natural modes, y = V p, S their frequencies, x the memory states of radiation, of a chamber's gas and, last,
those of a controller, which its own force drives besides (`vsb.engine.integrators.phases`). A holds springs, dampers,
memory and the tangents of nonlinear forces; n is what these forces do beyond their tangents; w are the linear waves.
Every entry of A is of the size of a frequency, so a shell of 1e15 Pa costs no digits of the slow motion.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from vsb.engine.motion.controller import Controller
from vsb.engine.motion.forces import (
    EXCITING,
    AssumedPressure,
    ConstantForce,
    EndStop,
    Linear,
    ShellForce,
    SpringDamper,
    TakeOff,
    WaterPressure,
)
from vsb.engine.motion.frequency import normal_modes, unrestrained_motions
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.wetted import Incident, Shape, incident, wave_force, wet_force
from vsb.engine.waves.sampling import Sampler, Signals, signals, signals_at
from vsb.engine.waves.seas import NO_WAVES, superposed
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.compiled import njit


@dataclass(frozen=True)
class Motion:
    """Motion of the free coordinates on equally spaced times."""

    time: FloatArray  # (time,) [s]
    position: FloatArray  # y (time, free) [m]
    velocity: FloatArray  # (time, free) [m/s]
    acceleration: FloatArray  # (time, free) [m/s^2]
    memory: FloatArray  # x (time, state), empty for the convolution
    seconds: float  # wall time [s]
    forces: Mapping[str, FloatArray] = field(default_factory=dict)  # q and v do not tell, each (time, dof) [N]
    works: Mapping[str, FloatArray] = field(default_factory=dict)  # from the start, where forces jump, (time,) [J]


def joined(parts: Sequence[Motion]) -> Motion:
    """Return one motion of several, each begun where the one before ended; works add up."""
    if len(parts) == 1:
        return parts[0]

    def whole(arrays: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate([arrays[0], *(later[1:] for later in arrays[1:])])

    names = ("time", "position", "velocity", "acceleration", "memory")
    works = {}
    for term in parts[0].works:
        before = np.cumsum([0.0, *(part.works[term][-1] for part in parts[:-1])])
        works[term] = whole([done + part.works[term] for done, part in zip(before, parts, strict=True)])
    return Motion(
        **{name: whole([getattr(part, name) for part in parts]) for name in names},
        seconds=sum(part.seconds for part in parts),
        forces={name: whole([part.forces[name] for part in parts]) for name in parts[0].forces},
        works=works,
    )


__all__ = ["EXCITING", "Controller", "EndStop", "Remainder", "System", "TakeOff", "remainder"]


class Remainder(NamedTuple):
    """What the compiled loops need for n(t, z) = R^T (f_water + constant + C q) + diffraction, q = L z."""

    shape: Shape
    rest: FloatArray  # (dof,)
    position: FloatArray  # L (dof, free)
    project: FloatArray  # R^T (free, dof)
    constant: FloatArray  # R^T constant (free,)
    tangent: FloatArray  # R^T C L (free, free)
    specific_weight: float
    amplitude: float  # of the assumed pressure
    omega: float
    waves: Incident  # none: no components
    diffraction: Signals  # on the modes, or none
    round_off: float  # of n
    begin: float  # of the run [s]


@njit(cache=True)
def remainder(r: Remainder, t: float, p: FloatArray, out: FloatArray) -> None:
    """Fill n at time t since the begin and scaled modal positions, the first numbers of a state p."""
    q, free = r.rest.copy(), len(out)
    static, uniform = np.empty(len(q)), np.empty(len(q))
    for i in range(len(q)):
        for j in range(free):
            q[i] += r.position[i, j] * p[j]
    if len(r.waves.omega):
        wave_force(r.shape, q, r.waves, r.begin + t, static)
        for i in range(len(q)):
            static[i] *= r.specific_weight
    else:
        wet_force(r.shape, q, static, uniform)
        pressure = r.amplitude * np.cos(r.omega * (r.begin + t))
        for i in range(len(q)):
            static[i] = r.specific_weight * static[i] + pressure * uniform[i]
    for i in range(free):
        out[i] = r.constant[i]
        for j in range(free):
            out[i] += r.tangent[i, j] * p[j]
        for j in range(len(q)):
            out[i] += r.project[i, j] * static[j]
    if len(r.diffraction.omega):
        diffracted = signals_at(r.diffraction, r.begin + t)
        for i in range(free):
            out[i] += diffracted[i]


@dataclass(frozen=True)
class System:
    """A scene in its natural modes."""

    scene: Scene
    matrix: FloatArray  # A (state, state) [1/s]
    omega: FloatArray  # (component,) [rad/s]
    waves: ComplexArray  # w (component, free)
    scale: FloatArray  # diagonal of S (free,) [rad/s]
    modes: FloatArray  # V (free, free)

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """Return a scene as a system."""
        stiffness, mass = scene.stiffness, scene.motions.T @ scene.mass @ scene.motions
        squares, modes = normal_modes(stiffness, mass, unrestrained_motions(stiffness, scene.labels, scene.motions))
        scale = np.sqrt(np.maximum(np.abs(squares), 1.0))
        n, order = len(scale), 2 * len(scale) + (scene.memory.order if scene.memory else 0)
        controller = scene.law.controller if scene.law else None
        a = np.zeros((whole := order + (len(controller.output) if controller else 0), whole))
        a[:n, n : 2 * n] = np.diag(scale)
        a[n : 2 * n, :n] = -np.diag(squares / scale)
        a[n : 2 * n, n : 2 * n] = -modes.T @ scene.damping @ modes
        if scene.memory:
            g = scene.memory.input_matrix @ scene.motions @ modes
            a[n : 2 * n, 2 * n : order] = -g.T
            a[2 * n : order, n : 2 * n] = g
            a[2 * n : order, 2 * n : order] = scene.memory.state_matrix
        if scene.law and controller:
            a[order:, n : 2 * n] = np.outer(controller.of_velocity, scene.law.direction @ scene.motions @ modes)
            a[order:, order:] = controller.state_matrix
        wave = scene.excitation
        if wave is None:
            return cls(scene, a, np.zeros(0), np.zeros((0, n), dtype=complex), scale, modes)
        return cls(scene, a, wave.omega, wave.phasors @ scene.motions @ modes, scale, modes)

    def scaled_waves(self, share: float) -> Self:
        """Return the system in a share of its waves or assumed pressure."""
        return replace(self, scene=self.scene.scaled_waves(share), waves=share * self.waves)

    @property
    def free(self) -> int:
        """Number of modes."""
        return len(self.scale)

    @cached_property
    def shapes(self) -> FloatArray:
        """Natural modes in all degrees of freedom, q = shapes p, shape (dof, free)."""
        return np.ascontiguousarray(self.scene.motions @ self.modes)

    @property
    def position(self) -> FloatArray:
        """Y of the scaled modes, V S^-1: y = position @ z[:free], shape (free, free)."""
        return self.modes / self.scale

    @cached_property
    def input(self) -> FloatArray:
        """B: forces act on the rates of p', shape (state, free)."""
        return np.eye(len(self.matrix), self.free, -self.free)

    @property
    def linear(self) -> bool:
        """Whether n vanishes."""
        return not self._nonlinear

    @cached_property
    def _nonlinear(self) -> dict[str, Linear]:
        """Linear parts of the forces that have others as well."""
        return {name: part for name, part in self.scene.linear.items() if not part.fully_linear}

    @property
    def switching(self) -> bool:
        """Whether a take-off or an end stop switches between pieces of its law."""
        return bool(self.scene.laws)

    @property
    def has_latching_time(self) -> bool:
        """Whether a take-off latches or declutches: its force is then none of position and velocity."""
        return self.scene.law is not None and self.scene.law.latching_time > 0

    @property
    def jumps(self) -> bool:
        """Whether a take-off is friction: its force jumps where the motion turns round."""
        return self.scene.law is not None and bool(np.isinf(self.scene.law.damping))

    @property
    def not_compiled(self) -> list[str]:
        """Names of nonlinear forces the compiled n does not know: all but the water's and constant parts.

        Of a spring that is slack elsewhere K q0 is left beyond the tangent, which is constant (`Scene.constant`).
        """
        known = (ConstantForce, SpringDamper, WaterPressure)
        return [name for name in self._nonlinear if not isinstance(self.scene.forces[name], known)]

    @property
    def dissipating(self) -> list[str]:
        """Those of them that may dissipate: all but forces of the shell, which have a potential."""
        return [name for name in self.not_compiled if not isinstance(self.scene.forces[name], ShellForce)]

    def check_smooth(self) -> None:
        """Check that no force switches: compiled steps know smooth forces only; raises `ValueError`."""
        if self.switching:
            raise ValueError("received a take-off that switches, needs smooth forces; use `Switching`.")

    def check_compiled(self) -> None:
        """Check that the compiled n holds all nonlinear forces; raises `ValueError`."""
        self.check_smooth()
        if self.not_compiled:
            names = ", ".join(self.not_compiled)
            raise ValueError(f"received the force {names}, which compiled steps do not know; use `collocated`.")

    # forces ---------------------------------------------------------------------------------------------------------

    def added(self, time: FloatArray, z: FloatArray) -> FloatArray:
        """Return n along a motion at times (time,) [s] with states z (time, state), shape (time, free)."""
        return self.added_during(time)(z, slice(None))

    def added_during(self, time: FloatArray) -> Callable[[FloatArray, slice], FloatArray]:
        """Return n at rows of some instants as a function of z there; see `added`."""
        beyond = [self.scene.forces[name].during(time) for name in self._nonlinear]
        position = (self.shapes / self.scale).T

        def n(z: FloatArray, rows: slice) -> FloatArray:
            q, v = z[:, : self.free] @ position, z[:, self.free : 2 * self.free] @ self.shapes.T
            return sum((force(q, v, rows) for force in beyond), self._tangential(q, v)) @ self.shapes

        return n

    @cached_property
    def waves_sampler(self) -> Sampler:
        """The linear waves on the modes."""
        return Sampler(signals(self.omega, self.waves))

    def wave_forcing(self, time: FloatArray) -> FloatArray:
        """Return the linear waves at equally spaced instants, shape (time, free)."""
        return superposed(self.omega, self.waves, time)

    def forcing(self, time: FloatArray, z: FloatArray) -> FloatArray:
        """Return n and the linear waves along a motion, shape (time, free): z' = A z + B forcing; see `added`."""
        return self.added(time, z) + self.wave_forcing(time)

    @cached_property
    def remainder(self) -> Remainder | None:
        """Arguments of the compiled n, waves and laws that switch left out; none without water."""
        scene, water = self.scene, self.scene.water
        if water is None:
            return None
        assumed = water.assumed or AssumedPressure(0.0, 0.0)
        position, project = scene.motions @ self.position, self.shapes.T
        return Remainder(
            water.shell.shape,
            water.rest,
            np.ascontiguousarray(position),
            np.ascontiguousarray(project),
            project @ scene.constant,
            project @ water.tangent @ position,
            water.specific_weight,
            assumed.amplitude,
            assumed.omega,
            water.waves or incident(NO_WAVES, np.inf, 1.0, water.shell.shape.radius),
            signals(np.zeros(0), np.zeros((0, self.free), dtype=complex)),
            1e-14 * float(np.linalg.norm(project)) * water.specific_weight * water.shell.shape.radius**3,
            0.0,
        )

    def forces(self, motion: Motion) -> dict[str, FloatArray]:
        """Return the forces of the scene by name, each shape (time, dof) [N].

        Of what remembers, that of the memory states; radiation is what remains of the equation of motion, M q'' - sum
        of the other forces, where the motion has none.
        """
        q, v = self._moved(motion)
        out = self.scene.named(motion.time, q, v) | dict(motion.forces)
        for name, memory in self.scene.memories.items():
            if motion.memory.size:
                states = motion.memory[:, self.scene.remembered[name]]
                out[name] = self.scene.forces[name].force(motion.time, q, v) - states @ memory.input_matrix
            else:
                inertia = motion.acceleration @ self.scene.motions.T @ self.scene.mass.T
                out[name] = inertia - sum(out.values(), np.zeros_like(q))
        return out

    def driving(self, motion: Motion, named: Mapping[str, FloatArray]) -> FloatArray:
        """Return what drives z' = A z + B g from the forces by name: n and waves, shape (time, free).

        In a motion without memory states radiation drives, too.
        """
        held = {
            name
            for name, part in self.scene.linear.items()
            if part.fully_linear and part.waves is None and (part.memory is None or motion.memory.size)
        }
        none = np.zeros((len(motion.time), len(self.shapes)))
        loose = sum((force for name, force in named.items() if name not in held), none)
        return (loose if self.linear else loose + self._tangential(*self._moved(motion))) @ self.shapes

    def _moved(self, motion: Motion) -> tuple[FloatArray, FloatArray]:
        """Q and v of a motion, each shape (time, dof)."""
        return motion.position @ self.scene.motions.T, motion.velocity @ self.scene.motions.T

    def _tangential(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """What A holds of the nonlinear forces, with the sign of n, shape (time, dof) [N]."""
        out = np.zeros(q.shape)
        for part in self._nonlinear.values():
            if part.stiffness is not None:
                out += q @ part.stiffness.T
            if part.damping is not None:
                out += v @ part.damping.T
        return out

    # states and motions ---------------------------------------------------------------------------------------------

    def first(self, start: tuple[FloatArray, ...]) -> FloatArray:
        """Return z of initial y and y', each shape (free,), and memory states x, if the water is not at rest."""
        y, rate, *memory = start
        rest = memory or [np.zeros(len(self.matrix) - 2 * len(y))]
        return np.concatenate([np.linalg.solve(self.position, y), np.linalg.solve(self.modes, rate), *rest])

    def states(self, motion: Motion) -> FloatArray:
        """Return z of a motion, without memory states if it has none, shape (time, state)."""
        positions = np.linalg.solve(self.position, motion.position.T).T
        return np.hstack([positions, np.linalg.solve(self.modes, motion.velocity.T).T, motion.memory])

    def motion(self, time: FloatArray, states: FloatArray, forcing: FloatArray, seconds: float) -> Motion:
        """Return the motion of states z under n and waves `forcing`, shape (time, free)."""
        n = self.free
        rates = states @ self.matrix[n : 2 * n].T + forcing
        return Motion(
            time,
            states[:, :n] @ self.position.T,
            states[:, n : 2 * n] @ self.modes.T,
            rates @ self.modes.T,
            states[:, 2 * n :],
            seconds,
        )

    def energy(self, motion: Motion) -> tuple[FloatArray, FloatArray]:
        """Return the energy stored in mass, forces and memory, and its kinetic part, each shape (time,) [J]."""
        q, v = self._moved(motion)
        kinetic = 0.5 * np.einsum("ti,ti->t", v @ self.scene.mass, v)
        memory = motion.memory[:, : self.scene.memory.order if self.scene.memory else 0]
        remembered = 0.5 * np.einsum("ti,ti->t", memory, memory)
        return sum((force.potential_energy(q) for force in self.scene.forces.values()), kinetic + remembered), kinetic

    def beyond_tangents(self, position: FloatArray) -> FloatArray:
        """Return the energy smooth nonlinear forces store beyond that of their tangents, shape (time,) [J]."""
        q, out = position @ self.scene.motions.T, np.zeros(len(position))
        for name, part in self._nonlinear.items():
            force = self.scene.forces[name]
            if not isinstance(force, TakeOff | EndStop):
                out += force.potential_energy(q)
                out -= 0.0 if part.stiffness is None else 0.5 * np.einsum("ti,ti->t", q @ part.stiffness, q)
        return out

    def dampers(self) -> list[FloatArray]:
        """Return the linear damping of the take-off and of all other forces, each shape (free, free) [1/s]."""
        parts = self.scene.linear
        ours = [part.damping for name, part in parts.items() if name == self.scene.take_off]
        others = [part.damping for name, part in parts.items() if name != self.scene.take_off]
        return [self.modes.T @ self.scene.projected(group) @ self.modes for group in (ours, others)]

    def losses(self) -> FloatArray:
        """Return the powers z.Q z the take-off, structure and all other dampers, and radiation take.

        Q, shape (3, state, state) [1/s].
        """
        n, scene = self.free, self.scene
        out = np.zeros((3, len(self.matrix), len(self.matrix)))
        for form, damper in zip(out, self.dampers(), strict=False):
            form[n : 2 * n, n : 2 * n] = damper
        for name, memory in scene.memories.items():
            own = scene.remembered[name]
            at = slice(2 * n + own.start, 2 * n + own.stop)
            out[{scene.take_off: 0, "radiation": 2}.get(name, 1), at, at] = memory.radiated
        return out

    # sizes ----------------------------------------------------------------------------------------------------------

    @property
    def size(self) -> float:
        """Length no amplitude is measured against if smaller [m]: a millionth of the radius, of a metre without water.

        Zero of a linear scene, which has no scale.
        """
        if self.linear:
            return 0.0
        return 1e-6 * (self.remainder.shape.radius if self.remainder else 1.0)

    @property
    def least(self) -> float:
        """Norm of a state too small to matter: a millionth of the root of rho g r^4; 0 of a linear scene."""
        r = self.remainder
        return 1e-6 * float(np.sqrt(r.specific_weight) * r.shape.radius**2) if r else 0.0

    @property
    def heaving(self) -> float:
        """Frequency of heave alone, without memory; 1 without a spring [rad/s]."""
        y = self.scene.heaving
        mass = self.scene.motions.T @ self.scene.mass @ self.scene.motions
        return float(np.sqrt(max(float(y @ self.scene.stiffness @ y), 0.0) / (y @ mass @ y))) or 1.0

    @property
    def frequencies(self) -> FloatArray:
        """Frequencies of waves and assumed pressure, ascending, shape (component,) [rad/s]."""
        return np.unique(np.concatenate([np.zeros(0), *(f.frequencies() for f in self.scene.forces.values())]))

    @cached_property
    def horizon(self) -> float:
        """Time over which errors add up [s]: that of the slowest decay without a take-off that switches."""
        slowest = -float(np.linalg.eigvals(self.matrix).real.max())
        return 1.0 / slowest if slowest > 0 else np.inf
