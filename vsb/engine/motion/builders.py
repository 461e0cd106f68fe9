"""Scenes of one design in one sea: linear, body-exact, and the paper's under an assumed pressure."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import null_space

from vsb.engine.hydro.dofs import flexible
from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.hydro.variables import motion_of
from vsb.engine.motion.forces import (
    AssumedPressure,
    ConstantForce,
    Damper,
    Excitation,
    Force,
    RadiationMemory,
    RelaxingDamper,
    Spring,
    SpringDamper,
    WaterPressure,
)
from vsb.engine.motion.froude_krylov import Incident, incident
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, resting
from vsb.engine.motion.shell_forces import shell_forces
from vsb.engine.motion.viscous import ViscousForce
from vsb.engine.motion.wetted import WetShell
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.tools.arrays import FloatArray

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
    forces |= _behind_chamber(system) if system.chamber else take_off(system.pto, dof)
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


def _behind_chamber(buoy: LinearSystem) -> dict[str, Force]:
    """Force of a take-off behind a chamber; without a damper a spring remains, if there is one."""
    dof, (beside, compliance) = len(buoy.mass), buoy.pto.relaxed(buoy.chamber)
    if not beside.damping:
        return take_off(beside, dof)
    return {"pto": RelaxingDamper(beside.spring(dof), beside.direction(dof), float(beside.damping), compliance)}


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

    Raises `ConvergenceError` if the shell gives way under its static load.

    Parameters
    ----------
    density, gravity : float
        Of the water [kg/m^3], [m/s^2].
    motions : ndarray, shape (dof, free)
    rubber : LoadedShell, optional
        See `body_exact_scene`.
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

    Raises `ConvergenceError` if the shell gives way under its static load. The motion itself starts undeformed, as the
    paper's.

    Parameters
    ----------
    shell : DeformedShell
        The shell about which stiff forces are linearised; undeformed.
    density, gravity : float
        Of the water [kg/m^3], [m/s^2].
    motions : ndarray, shape (dof, free)
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
