"""A scene: mass, named forces, the motions a design allows.

M q'' = sum of forces, q = N y: heave and modal amplitudes q in the subspace N of the design. Only the forces of the
scene exist.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from vsb.engine.hydro.dofs import flexible
from vsb.engine.hydro.radiation import RadiationModel, joined
from vsb.engine.motion.forces import (
    ConstantForce,
    EndStop,
    Excitation,
    Force,
    Linear,
    SpringDamper,
    TakeOff,
    WaterPressure,
)
from vsb.engine.motion.frequency import unrestrained_motions
from vsb.engine.motion.shell_forces import ShellForce
from vsb.engine.shell.deformed import DeformedShell
from vsb.errors import ConvergenceError
from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class Scene:
    """A scene: mass including added mass at infinite frequency, named forces, allowed motions."""

    labels: tuple[str, ...]  # dof
    mass: FloatArray  # (dof, dof) [kg]
    forces: Mapping[str, Force]
    motions: FloatArray  # N (dof, free)
    origin: FloatArray = field(default_factory=lambda: np.zeros(0))  # y at rest (free,) [m]; empty: zero
    take_off: str = "pto"  # name of the force whose work is the power absorbed
    heave: FloatArray = field(default_factory=lambda: np.zeros(0))  # y of a unit of heave (free,); empty: the first

    @property
    def heaving(self) -> FloatArray:
        """Y of a unit of heave, in which initial position and velocity are given, shape (free,)."""
        return self.heave if self.heave.size else np.eye(self.motions.shape[1])[0]

    @property
    def laws(self) -> dict[str, TakeOff | EndStop]:
        """Forces that switch between pieces of their law, by name."""
        return {name: force for name, force in self.forces.items() if isinstance(force, TakeOff | EndStop)}

    @property
    def law(self) -> TakeOff | None:
        """The take-off, if it switches."""
        return next((force for force in self.laws.values() if isinstance(force, TakeOff)), None)

    @property
    def stop(self) -> EndStop | None:
        """The end stop, if there is one."""
        return next((force for force in self.laws.values() if isinstance(force, EndStop)), None)

    @property
    def without_limits(self) -> "Scene | None":
        """The scene without limits of force and stroke; None where the take-off is no damper and spring within them."""
        law = self.law
        if law is None or law.controller or law.latching_time or np.isinf(law.damping):
            return None
        b, forces = law.direction, {name: force for name, force in self.forces.items() if force is not self.stop}
        square, rest = np.outer(b, b), b * (law.rest / (b @ b))
        forces[self.take_off] = SpringDamper(law.stiffness * square, law.damping * square, rest)
        return replace(self, forces=forces)

    def reach(self, q: FloatArray, v: FloatArray) -> float:
        """Return the largest force and stroke of its take-off along a motion, over their limits [-].

        Parameters
        ----------
        q, v : ndarray, shape (time, dof)
        """
        law, stop, found = self.law, self.stop, 0.0
        if law is not None:
            stroke, speed = q @ law.direction - law.rest, v @ law.direction
            found = float(np.abs(law.damping * speed + law.stiffness * stroke).max()) / law.limit
        if stop is not None:
            found = max(found, float(np.abs(q @ stop.direction - stop.rest).max()) / stop.stroke)
        return found

    @cached_property
    def flexible(self) -> bool:
        """Whether an allowed motion deforms the shell."""
        return flexible(self.labels, self.motions)

    @cached_property
    def linear(self) -> dict[str, Linear]:
        """Linear part of every force."""
        return {name: force.linear() for name, force in self.forces.items()}

    def projected(self, matrices: Iterable[FloatArray | None]) -> FloatArray:
        """Return the sum of matrices in the allowed motions, None for an absent one, shape (free, free)."""
        dof = len(self.labels)
        return self.motions.T @ sum((m for m in matrices if m is not None), np.zeros((dof, dof))) @ self.motions

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness in the allowed motions, tangents of nonlinear forces among them, shape (free, free) [N/m]."""
        return self.projected(part.stiffness for part in self.linear.values())

    @property
    def unrestrained(self) -> bool:
        """Whether one of the allowed motions has no restoring force."""
        stiffness = self.stiffness
        return not stiffness.any(axis=0).all() or unrestrained_motions(stiffness, self.labels, self.motions).size > 0

    @property
    def damping(self) -> FloatArray:
        """Damping in the allowed motions, shape (free, free) [N s/m]."""
        return self.projected(part.damping for part in self.linear.values())

    @cached_property
    def memories(self) -> dict[str, RadiationModel]:
        """The memory of every force that has one."""
        return {name: part.memory for name, part in self.linear.items() if part.memory}

    @cached_property
    def memory(self) -> RadiationModel | None:
        """All memories of the scene as one, in their order, if it has any."""
        return joined(list(self.memories.values())) if self.memories else None

    @property
    def radiation(self) -> RadiationModel | None:
        """The memory of radiation, if there is one."""
        return self.memories.get("radiation")

    @cached_property
    def remembered(self) -> dict[str, slice]:
        """The states of `memory` that belong to each force."""
        ends = np.cumsum([model.order for model in self.memories.values()])
        return {name: slice(end - m.order, end) for (name, m), end in zip(self.memories.items(), ends, strict=True)}

    @property
    def excitation(self) -> Excitation | None:
        """The linear wave excitation of the scene, if it has one."""
        return next((part.waves for part in self.linear.values() if part.waves), None)

    @property
    def water(self) -> WaterPressure | None:
        """The pressure on the instantaneous wet shell, if the scene is body-exact."""
        return next((f for f in self.forces.values() if isinstance(f, WaterPressure)), None)

    @property
    def constant(self) -> FloatArray:
        """Sum of the constant forces, with those of springs at q = 0, shape (dof,) [N]."""
        values = [force.value for force in self.forces.values() if isinstance(force, ConstantForce)]
        values += [force.stiffness @ force.rest for force in self.forces.values() if isinstance(force, SpringDamper)]
        return sum(values, np.zeros(len(self.labels)))

    @cached_property
    def rest(self) -> FloatArray:
        """Y of the buoy as it rests in still water, shape (free,) [m]; `ConvergenceError` if it does not."""
        if self.origin.size:
            return self.origin
        return resting(self) if self.water else np.zeros(self.motions.shape[1])

    def start(self, heave: float, heave_velocity: float) -> tuple[FloatArray, FloatArray]:
        """Return the initial y and y': the buoy as it rests, moved in heave as given."""
        first = self.heaving
        return heave * first + (self.origin if self.origin.size else 0.0), heave_velocity * first

    def named(self, time: FloatArray, q: FloatArray, v: FloatArray) -> dict[str, FloatArray]:
        """Return the forces by name along a motion but that of memory states, each shape (time, dof) [N].

        Parameters
        ----------
        time : ndarray, shape (time,) [s]
            Equally spaced.
        q, v : ndarray, shape (time, dof) [m], [m/s]
        """
        out: dict[str, FloatArray] = {}
        for name, force in self.forces.items():
            if self.linear[name].memory is None:
                out |= force.named(name, time, q, v)
        return out

    def dissipated_power(self, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the power the take-off absorbs and that all other forces but radiation dissipate, each (time,) [W].

        `v` are velocities of all degrees of freedom, shape (time, dof) [m/s].
        """
        losses = {name: force.dissipated_power(v) for name, force in self.forces.items()}
        none = np.zeros(len(v))
        return losses.pop(self.take_off, none), sum(losses.values(), none)

    def scaled_waves(self, share: float) -> Self:
        """Return the scene with scaled waves or assumed pressure."""
        return replace(self, forces={name: force.scaled_waves(share) for name, force in self.forces.items()})


def resting(scene: Scene) -> FloatArray:
    """Return y of a body-exact scene at rest in still water, shape (free,) [m], by Newton's method.

    Raises `ConvergenceError` if the scene does not come to rest.
    """
    water, y = scene.water, np.zeros(scene.motions.shape[1])
    assert water is not None
    shell_forces = [force for force in scene.forces.values() if isinstance(force, ShellForce)]
    springs = (part.stiffness for name, part in scene.linear.items() if part.fully_linear)
    stiffness = scene.projected(springs)
    load = scene.constant
    for _ in range(50):
        shell = DeformedShell(water.shell.basis, water.shell.centre_height, water.rest + scene.motions @ y)
        static = water.specific_weight * water.shell.forces(shell.modal_amplitude[None])[0][0]
        slope = shell.hydrostatic_stiffness(water.specific_weight, 1.0)
        for force in shell_forces:
            q = scene.motions @ y
            static, slope = static + force.force(np.zeros(1), q, q), slope + force.stiffness(q)
        tangent = scene.motions.T @ slope @ scene.motions
        try:
            step = cho_solve(cho_factor(stiffness + tangent), scene.motions.T @ (static + load) - stiffness @ y)
        except np.linalg.LinAlgError:  # unstable
            break
        largest, y = np.abs(step).max() / shell.basis.shell.radius, y + step
        if largest < 1e-12:
            return y
        if not largest < 1.0:
            break
    raise ConvergenceError(
        "the loaded buoy does not come to rest: its shell gives way under the static load; raise "
        "device.internal_pressure, device.thickness or device.young_modulus, or use hydro.model: linear."
    )
