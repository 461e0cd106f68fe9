"""Scenes of one design in one sea: linear, body-exact, and the paper's under an assumed pressure."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vsb.hydro.dofs import flexible
from vsb.hydro.statespace import RadiationModel
from vsb.motion.forces import (
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
from vsb.motion.frequency import LinearBuoy
from vsb.motion.froude_krylov import Incident, incident
from vsb.motion.port import LinearPto
from vsb.motion.scene import Scene, resting
from vsb.motion.wetted import wet_shell
from vsb.shell.deformed import DeformedShell, ReferenceShell
from vsb.tools.arrays import FloatArray
from vsb.waves.seas import NO_WAVES, Sea


def linear_scene(buoy: LinearBuoy, radiation: RadiationModel, sea: Sea, motions: FloatArray) -> Scene:
    """Return the linear hydroelastic scene of one design in one sea, with the forces it has and no others."""
    database = buoy.database
    forces: dict[str, Force] = {
        "hydrostatic": Spring(buoy.stiffness_parts["hydrostatic"]),
        "radiation": RadiationMemory(radiation),
    }
    forces |= _behind_chamber(buoy) if buoy.chamber else take_off(buoy.pto, len(buoy.mass))
    labels = tuple(str(label) for label in database.influenced_dof.values)
    if flexible(labels, motions):
        forces |= _shell_springs(buoy.stiffness_parts, buoy.structural_damping)
    if "mooring" in buoy.stiffness_parts:
        forces["mooring"] = Spring(buoy.stiffness_parts["mooring"])
    if sea.omega.size:
        excitation = buoy.coefficients(sea.omega).excitation
        forces["excitation"] = Excitation(sea.omega, sea.amplitude[:, None] * excitation)
    return Scene(labels, buoy.mass + buoy.added_mass_inf, forces, motions)


def take_off(pto: LinearPto, dof: int) -> dict[str, Force]:
    """Return the force of a take-off that is there, its spring slack about the rest, by name."""
    if pto.stiffness:
        return {"pto": SpringDamper(pto.spring(dof), pto.matrix(dof), np.zeros(dof))}
    return {"pto": Damper(pto.matrix(dof))} if pto.damping else {}


def _behind_chamber(buoy: LinearBuoy) -> dict[str, Force]:
    """Force of a take-off behind a chamber; without a damper a spring is left, if there is one."""
    dof, (beside, compliance) = len(buoy.mass), buoy.pto.relaxed(buoy.chamber)
    if not beside.damping:
        return take_off(beside, dof)
    return {"pto": RelaxingDamper(beside.spring(dof), beside.direction(dof), float(beside.damping), compliance)}


def _shell_springs(stiffness: Mapping[str, FloatArray], damping: FloatArray) -> dict[str, Force]:
    """Elastic, prestress and gas forces of a flexible design, and its structural damping."""
    parts = {"elastic": "structural", "prestress": "prestress", "gas": "gas"}
    springs: dict[str, Force] = {force: Spring(stiffness[name]) for force, name in parts.items() if name in stiffness}
    if damping.any():
        springs["structural_damping"] = Damper(damping)
    return springs


def body_exact_scene(
    buoy: LinearBuoy, shape: DeformedShell, radiation: RadiationModel, sea: Sea, motions: FloatArray
) -> Scene:
    """Return the scene with hydrostatics and Froude-Krylov forces on the instantaneous wet shell of one design.

    Radiation and diffraction stay linear about the reference shape.

    Parameters
    ----------
    buoy : LinearBuoy
    shape : DeformedShell
        The reference shape of its database.
    radiation : RadiationModel
    sea : Sea
    motions : ndarray, shape (dof, free)

    Notes
    -----
    The shell is elastic about its reference shape. A prestressed one carries its mean load there (`preload`); the
    vented sphere does not, and rests deformed: the motion starts from that rest.
    """
    attrs = buoy.database.attrs
    gravity, depth = float(attrs["gravity"]), float(attrs["water_depth"])
    specific_weight = float(attrs["water_density"]) * gravity
    linear = linear_scene(buoy, radiation, NO_WAVES, motions)
    waves = incident(sea, depth, gravity, shape.basis.shell.reach) if sea.omega.size else None
    others = {name: force for name, force in linear.forces.items() if name != "hydrostatic"}
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


def still_scene(reference: ReferenceShell, density: float, gravity: float, motions: FloatArray) -> Scene:
    """Return the body-exact scene of one design in still water, without what moving water does: all that rest needs.

    Parameters
    ----------
    reference : ReferenceShell
    density, gravity : float
        Of the water [kg/m^3], [m/s^2].
    motions : ndarray, shape (dof, free)

    Raises
    ------
    ConvergenceError
        If the shell gives way under its static load.
    """
    basis = reference.basis
    springs = _shell_springs(reference.stiffness, basis.damping) if flexible(basis.labels, motions) else {}
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
    wet = wet_shell(shape.basis, shape.centre_height)
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

    Parameters
    ----------
    shell : DeformedShell
        The shell about which stiff forces are linearised; undeformed.
    pto : LinearPto
    load : AssumedPressure
    density, gravity : float
        Of the water [kg/m^3], [m/s^2].
    motions : ndarray, shape (dof, free)

    Raises
    ------
    ConvergenceError
        If the shell gives way under its static load. The motion itself starts undeformed, as the paper's.
    """
    basis = shell.basis
    tangent = shell.hydrostatic_stiffness(density, gravity)
    wet = wet_shell(basis, shell.centre_height)
    forces: dict[str, Force] = {
        "water": WaterPressure(wet, np.zeros(len(basis.labels)), density * gravity, tangent, assumed=load),
        "weight": ConstantForce(-gravity * basis.inertia[0]),
    }
    forces |= take_off(pto, len(basis.labels))
    if flexible(basis.labels, motions):
        forces |= _shell_springs({"structural": basis.stiffness}, basis.damping)
    scene = Scene(basis.labels, basis.inertia, forces, motions)
    resting(scene)  # a shell that cannot carry its load collapses: no buoy, however well integrated
    return scene
