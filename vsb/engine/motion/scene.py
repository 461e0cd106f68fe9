"""A scene: mass, named forces, the motions a design allows; of one design in one sea linear, body-exact or the paper's.

M q'' = sum of forces, q = N y: heave and modal amplitudes q in the subspace N of the design. Only the forces of the
scene exist.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from scipy.linalg import cho_factor, cho_solve, null_space

from vsb.engine.hydro.dofs import flexible
from vsb.engine.hydro.radiation import RadiationModel, joined
from vsb.engine.hydro.variables import motion_of
from vsb.engine.motion.forces import (
    AssumedPressure,
    ConstantForce,
    Damper,
    EndStop,
    Excitation,
    Force,
    Linear,
    RadiationMemory,
    RelaxingDamper,
    ShellForce,
    Spring,
    SpringDamper,
    TakeOff,
    ViscousForce,
    WaterPressure,
    shell_forces,
)
from vsb.engine.motion.frequency import unrestrained_motions
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.wetted import Incident, WetShell, incident
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.waves.seas import NO_WAVES, Sea
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
        """Return the largest force and stroke of its take-off along a motion, over their limits [-]."""
        law, stop, share = self.law, self.stop, 0.0
        if law is not None:
            stroke, speed = q @ law.direction - law.rest, v @ law.direction
            share = float(np.abs(law.damping * speed + law.stiffness * stroke).max()) / law.limit
        if stop is not None:
            share = max(share, float(np.abs(q @ stop.direction - stop.rest).max()) / stop.stroke)
        return share

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

        Times [s] are equally spaced; q [m] and v [m/s] have shape (time, dof).
        """
        out: dict[str, FloatArray] = {}
        for name, force in self.forces.items():
            if self.linear[name].memory is None:
                out |= force.named(name, time, q, v)
        return out

    def dissipated_power(self, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the power the take-off absorbs and that all other forces but radiation dissipate, each (time,) [W]."""
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


# scenes of one design in one sea --------------------------------------------------------------------------------------


_UNMOVED = 1e-9  # share of a degree of freedom in the motions allowed that is round-off: it does not move


def linear_scene(
    system: LinearSystem,
    radiation: RadiationModel | None,
    waves: Sea | Mapping[float, Sea],
    motions: FloatArray | None = None,
    added_mass_inf: FloatArray | None = None,
) -> Scene:
    """Return the linear scene of a buoy or body in waves, with only the forces that exist.

    Raises `StabilityError` if a body is unstable at rest.

    Parameters
    ----------
    radiation : RadiationModel or None
        None: it radiates no waves.
    waves : Sea or mapping of float to Sea
        In the system's direction, or direction [rad] -> sea; without components: still water.
    motions : ndarray, shape (dof, free), optional
        Those allowed; all.
    added_mass_inf : ndarray, shape (dof, dof), optional
        Of a radiation memory fitted with its own [kg]; of the database.
    """
    dof, labels = len(system.labels), system.labels
    free = np.eye(dof) if motions is None else motions
    if not system.axisymmetric:
        system.unrestrained(free.T @ system.held @ free, free)  # raises
    forces: dict[str, Force] = {"hydrostatic": Spring(system.stiffness_parts["hydrostatic"])}
    if radiation:
        forces["radiation"] = RadiationMemory(radiation)
    pto, compliance = system.pto.relaxed(system.chamber) if system.chamber else (system.pto, 0.0)
    if system.chamber and pto.damping:
        forces["pto"] = RelaxingDamper(pto.spring(dof), pto.direction(dof), float(pto.damping), compliance)
    else:
        forces |= take_off(pto, dof)
    if not system.axisymmetric or flexible(labels, free):
        forces |= _elastic_forces(system.stiffness_parts, system.structural_damping)
        if system.maxwell:
            forces["viscous"] = ViscousForce(system.maxwell, system.stiffness_parts["structural"])
    if "mooring" in system.stiffness_parts:
        forces["mooring"] = Spring(system.stiffness_parts["mooring"])
    seas = {system.direction: waves} if isinstance(waves, Sea) else waves
    if seas := {direction: sea for direction, sea in seas.items() if sea.omega.size}:
        phasors = [
            sea.amplitude[:, None] * replace(system, direction=at).coefficients(sea.omega).excitation
            for at, sea in seas.items()
        ]
        forces["excitation"] = Excitation(together(seas).omega, np.concatenate(phasors))
    mass = system.mass + (system.added_mass_inf if added_mass_inf is None else added_mass_inf)
    return Scene(labels, mass, forces, free, heave=unit_heave(labels, mass, free))


def together(waves: Mapping[Any, Sea]) -> Sea:
    """Return seas of several directions as one, the elevation at the origin."""
    seas = list(waves.values()) or [NO_WAVES]
    return Sea(np.concatenate([sea.omega for sea in seas]), np.concatenate([sea.amplitude for sea in seas]))


def unit_heave(labels: Sequence[str], mass: FloatArray, free: FloatArray) -> FloatArray:
    """Return y of a unit of heave, of the first body that heaves, or of the first motion there is, shape (free,).

    Where a design couples it with other motions it is the motion q = N y nearest to heave alone in kinetic energy:
    (q - e)^T M (q - e) least for q_heave = 1, whatever units and order the motions have.
    """
    moving = [i for i, row in enumerate(free) if np.abs(row).max() > _UNMOVED * np.abs(free).max()]
    lead = next((i for i in moving if motion_of(labels[i]) == "Heave"), moving[0])
    y, others = free[lead] / (free[lead] @ free[lead]), null_space(free[lead][None])
    besides, apart = free @ others, free @ y - np.eye(len(labels))[lead]
    return np.asarray(y - others @ np.linalg.solve(besides.T @ mass @ besides, besides.T @ mass @ apart))


def take_off(pto: LinearPto, dof: int) -> dict[str, Force]:
    """Return the force of a take-off by name, its spring slack at rest; none without damper and spring."""
    if pto.stiffness:
        return {"pto": SpringDamper(pto.spring(dof), pto.matrix(dof), np.zeros(dof))}
    return {"pto": Damper(pto.matrix(dof))} if np.any(pto.damping) else {}


def _elastic_forces(stiffness: Mapping[str, FloatArray], damping: FloatArray) -> dict[str, Force]:
    """Elastic, prestress and gas forces and structural damping, as far as they exist."""
    parts = {"elastic": "structural", "prestress": "prestress", "gas": "gas"}
    springs = {force: stiffness[name] for force, name in parts.items() if name in stiffness}
    forces: dict[str, Force] = {force: Spring(matrix) for force, matrix in springs.items() if matrix.any()}
    if damping.any():
        forces["structural_damping"] = Damper(damping)
    return forces


def body_exact_scene(
    buoy: LinearSystem,
    shape: DeformedShell,
    radiation: RadiationModel,
    sea: Sea,
    motions: FloatArray,
    rubber: LoadedShell | None = None,
) -> Scene:
    """Return the scene with hydrostatics and Froude-Krylov forces on the instantaneous wet shell of one design.

    Radiation and diffraction stay linear about the reference shape.

    Parameters
    ----------
    shape : DeformedShell
        The reference shape of its database.
    motions : ndarray, shape (dof, free)
    rubber : LoadedShell, optional
        The shell, if it is of rubber: its elastic force and that of the pressure inside are then exact.

    Notes
    -----
    The shell is elastic about its reference shape, by springs but for rubber. A prestressed one carries its mean load
    there (`preload`); the vented sphere does not, and rests deformed: the motion starts from that rest.
    """
    attrs = buoy.database.attrs
    gravity, depth = float(attrs["gravity"]), float(attrs["water_depth"])
    specific_weight = float(attrs["water_density"]) * gravity
    linear = linear_scene(buoy, radiation, NO_WAVES, motions)
    waves = incident(sea, depth, gravity, shape.basis.shell.reach) if sea.omega.size else None
    others = {name: force for name, force in linear.forces.items() if name != "hydrostatic"}
    if rubber:
        others = _of_rubber(others, rubber, shape.modal_amplitude)
    forces = _loaded(others, shape, buoy.stiffness_parts["hydrostatic"], specific_weight, gravity, waves)
    if sea.omega.size:
        forces["diffraction"] = Excitation(sea.omega, sea.amplitude[:, None] * buoy.diffraction(sea.omega))
    spring = forces.get("pto")
    unsprung = {name: force for name, force in forces.items() if not isinstance(force, SpringDamper)}
    scene = Scene(linear.labels, linear.mass, unsprung, motions)
    rest = resting(scene)
    if isinstance(spring, SpringDamper):  # slack where the buoy rests without it
        forces["pto"] = replace(spring, rest=motions @ rest)
    return replace(scene, forces=forces, origin=rest)


def _of_rubber(forces: Mapping[str, Force], rubber: LoadedShell, rest: FloatArray) -> dict[str, Force]:
    """Forces of a scene with those of a flexible shell of rubber in place of springs."""
    if "elastic" not in forces:
        return dict(forces)
    others = {name: force for name, force in forces.items() if name not in ("elastic", "prestress", "gas")}
    return {**others, **shell_forces(rubber, rest)}


def still_scene(
    reference: ReferenceShell, density: float, gravity: float, motions: FloatArray, rubber: LoadedShell | None = None
) -> Scene:
    """Return the body-exact scene of one design in still water, without what moving water does: all that rest needs.

    Density [kg/m^3] and gravity [m/s^2] are the water's, other parameters as of `body_exact_scene`. Raises
    `ConvergenceError` if the shell gives way under its static load.
    """
    basis = reference.basis
    springs = _elastic_forces(reference.stiffness, basis.damping) if flexible(basis.labels, motions) else {}
    if rubber:
        springs = _of_rubber(springs, rubber, reference.modal_amplitude)
    forces = _loaded(springs, reference.shape, reference.stiffness["hydrostatic"], density * gravity, gravity, None)
    scene = Scene(basis.labels, basis.inertia, forces, motions)
    return replace(scene, origin=resting(scene))


def _loaded(
    others: Mapping[str, Force],
    shape: DeformedShell,
    hydrostatic: FloatArray,
    specific_weight: float,
    gravity: float,
    waves: Incident | None,
) -> dict[str, Force]:
    """Forces of a scene with water on the instantaneous wet shell and weight; a prestressed shell carries both."""
    wet = WetShell(shape.basis, shape.centre_height)
    water = WaterPressure(wet, shape.modal_amplitude, specific_weight, hydrostatic, waves=waves)
    weight = ConstantForce(-gravity * shape.basis.inertia[0])
    forces = {**others, "water": water, "weight": weight}
    if "prestress" in forces:
        at_rest = specific_weight * wet.forces(shape.modal_amplitude[None])[0][0]
        forces["preload"] = ConstantForce(-at_rest - weight.value)
    return forces


def assumed_pressure_scene(
    shell: DeformedShell, pto: LinearPto, load: AssumedPressure, density: float, gravity: float, motions: FloatArray
) -> Scene:
    """Return the paper's scene of one design: static and assumed pressure on the instantaneous wet shell, no radiation.

    The shell is the undeformed one, about which stiff forces are linearised; there the motion starts, as the paper's.
    Raises `ConvergenceError` if the shell gives way under its static load.
    """
    basis = shell.basis
    tangent = shell.hydrostatic_stiffness(density, gravity)
    wet = WetShell(basis, shell.centre_height)
    forces: dict[str, Force] = {
        "water": WaterPressure(wet, np.zeros(len(basis.labels)), density * gravity, tangent, assumed=load),
        "weight": ConstantForce(-gravity * basis.inertia[0]),
    }
    forces |= take_off(pto, len(basis.labels))
    if flexible(basis.labels, motions):
        forces |= _elastic_forces({"structural": basis.stiffness}, basis.damping)
    scene = Scene(basis.labels, basis.inertia, forces, motions)
    resting(scene)  # a shell that cannot carry its load collapses: no buoy, however well integrated
    return scene
