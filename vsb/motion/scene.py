"""Equation of motion of a scene: mass, named forces, the motions a design allows. Knows no integrator.

M q'' = sum of forces, q = N y: heave and modal amplitudes q in the subspace N of the design. Only the forces of the
scene exist.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh

from vsb.errors import ConvergenceError
from vsb.hydro.statespace import RadiationModel
from vsb.motion.frequency import LinearBuoy
from vsb.motion.froude_krylov import Incident, incident
from vsb.motion.pto import LinearPto
from vsb.motion.wetted import WetShell
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis
from vsb.tools.units import ComplexArray, FloatArray
from vsb.waves.seas import NO_WAVES, Sea


@dataclass(frozen=True)
class Spring:
    """f = -K q."""

    stiffness: FloatArray  # (dof, dof) [N/m]


@dataclass(frozen=True)
class Damper:
    """f = -D v."""

    damping: FloatArray  # (dof, dof) [kg/s]


@dataclass(frozen=True)
class Excitation:
    """f = Re sum F_j exp(-i omega_j t) (C1)."""

    omega: FloatArray  # (component,) [rad/s]
    force: ComplexArray  # (component, dof) [N]


@dataclass(frozen=True)
class RadiationMemory:
    """f = -G^T x with memory states x' = A x + G v."""

    model: RadiationModel


@dataclass(frozen=True)
class ConstantForce:
    """A constant force."""

    force: FloatArray  # (dof,) [N]


@dataclass(frozen=True)
class AssumedPressure:
    """A uniform pressure P cos(omega t) on the wet shell, the paper's stand-in for waves."""

    amplitude: float  # P [Pa]
    omega: float  # [rad/s]


@dataclass(frozen=True)
class WaterPressure:
    """f_j = -int p n.psi_j dS on the instantaneous wet part of the deformed shell.

    The pressure is that of still water with an assumed P cos(omega t), or with waves (`vsb.waveforce`).
    """

    shell: WetShell
    rest: FloatArray  # amplitudes of the reference shape, about which q is measured (dof,) [m]
    specific_weight: float  # rho g [N/m^3]
    tangent: FloatArray  # -df/dq of the static part about the reference shape, (dof, dof) [N/m]
    assumed: AssumedPressure | None = None
    waves: Incident | None = None


Force = Spring | Damper | Excitation | RadiationMemory | ConstantForce | WaterPressure


class LinearSystem(NamedTuple):
    """z' = A z + Re sum b_j exp(-i omega_j t) in scaled modal coordinates z = (S p, p', x), y = shapes p.

    p are the natural modes of the scene and S their frequencies: every entry of A is of the size of a frequency, so
    a shell of 1e15 Pa costs no digits of the slow motion.
    """

    matrix: FloatArray  # (state, state)
    omega: FloatArray  # (component,) [rad/s]
    input: ComplexArray  # (component, state)
    position: FloatArray  # y = position @ z[:free], (free, free)
    velocity: FloatArray  # y' = velocity @ z[free:2 free]

    def first(self, start: tuple[FloatArray, ...]) -> FloatArray:
        """Return z of initial y and y', each shape (free,), and memory states x, if the water is not at rest."""
        y, rate, *memory = start
        rest = memory or [np.zeros(len(self.matrix) - 2 * len(y))]
        return np.concatenate([np.linalg.solve(self.position, y), np.linalg.solve(self.velocity, rate), *rest])


@dataclass(frozen=True)
class Plant:
    """A scene: mass including added mass at infinite frequency, named forces, allowed motions."""

    labels: tuple[str, ...]  # dof
    mass: FloatArray  # (dof, dof) [kg]
    forces: Mapping[str, Force]
    motions: FloatArray  # N (dof, free)
    origin: FloatArray = field(default_factory=lambda: np.zeros(0))  # y at rest (free,) [m]; empty: zero

    def total(self, kind: type[Spring] | type[Damper]) -> FloatArray:
        """Return the sum of the matrices of all springs or dampers, projected on the motions, shape (free, free)."""
        dof = len(self.labels)
        matrices = [
            force.stiffness if isinstance(force, Spring) else force.damping
            for force in self.forces.values()
            if isinstance(force, kind) and isinstance(force, Spring | Damper)
        ]
        return self.motions.T @ sum(matrices, np.zeros((dof, dof))) @ self.motions

    @property
    def memory(self) -> RadiationModel | None:
        """The radiation memory of the scene, if it has one."""
        return next((f.model for f in self.forces.values() if isinstance(f, RadiationMemory)), None)

    @property
    def water(self) -> WaterPressure | None:
        """The pressure on the instantaneous wet shell, if the scene is body-exact."""
        return next((f for f in self.forces.values() if isinstance(f, WaterPressure)), None)

    @property
    def excitation(self) -> Excitation | None:
        """The wave excitation of the scene, if it has waves."""
        return next((f for f in self.forces.values() if isinstance(f, Excitation)), None)

    def linear_system(self) -> LinearSystem:
        """Return the scene as one linear system."""
        squares, shapes = eigh(self.total(Spring), self.motions.T @ self.mass @ self.motions)
        scale = np.sqrt(np.maximum(np.abs(squares), 1.0))
        n, order = len(scale), self.memory.order if self.memory else 0
        a = np.zeros((2 * n + order, 2 * n + order))
        a[:n, n : 2 * n] = np.diag(scale)
        a[n : 2 * n, :n] = -np.diag(squares / scale)
        a[n : 2 * n, n : 2 * n] = -shapes.T @ self.total(Damper) @ shapes
        if self.memory:
            g = self.memory.input_matrix @ self.motions @ shapes
            a[n : 2 * n, 2 * n :] = -g.T
            a[2 * n :, n : 2 * n] = g
            a[2 * n :, 2 * n :] = self.memory.state_matrix
        omega: FloatArray = self.excitation.omega if self.excitation else np.zeros(0)
        push = np.zeros((len(omega), len(a)), dtype=complex)
        if self.excitation:
            push[:, n : 2 * n] = self.excitation.force @ self.motions @ shapes
        return LinearSystem(a, omega, push, shapes / scale, shapes)

    def start(self, heave: float, heave_velocity: float) -> tuple[FloatArray, FloatArray]:
        """Return the initial y and y': the buoy as it rests, moved in heave as given."""
        first = np.eye(self.motions.shape[1])[0]
        return heave * first + (self.origin if self.origin.size else 0.0), heave_velocity * first


def linear_plant(buoy: LinearBuoy, radiation: RadiationModel, sea: Sea, motions: FloatArray) -> Plant:
    """Return the linear hydroelastic scene of one design in one sea, with the forces it has and no others."""
    database = buoy.database
    forces: dict[str, Force] = {
        "hydrostatic": Spring(buoy.stiffness_parts["hydrostatic"]),
        "radiation": RadiationMemory(radiation),
    }
    if buoy.pto.damping:
        forces["pto"] = Damper(buoy.pto.matrix(len(buoy.mass)))
    if motions.shape[1] > 1:
        forces |= _shell_springs(buoy)
    if sea.omega.size:
        excitation = buoy.coefficients(sea.omega).excitation
        forces["excitation"] = Excitation(sea.omega, sea.amplitude[:, None] * excitation)
    labels = tuple(str(label) for label in database.influenced_dof.values)
    return Plant(labels, buoy.mass + buoy.added_mass_inf, forces, motions)


def _shell_springs(buoy: LinearBuoy) -> dict[str, Force]:
    """Elastic, prestress and gas forces of a flexible design, and its structural damping."""
    parts = {"elastic": "structural", "prestress": "prestress", "gas": "gas"}
    springs: dict[str, Force] = {
        force: Spring(buoy.stiffness_parts[name]) for force, name in parts.items() if name in buoy.stiffness_parts
    }
    if buoy.structural_damping.any():
        springs["structural_damping"] = Damper(buoy.structural_damping)
    return springs


def body_exact_plant(
    buoy: LinearBuoy, shape: DeformedShell, radiation: RadiationModel, sea: Sea, motions: FloatArray
) -> Plant:
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
    basis, attrs = shape.basis, buoy.database.attrs
    gravity, depth = float(attrs["gravity"]), float(attrs["water_depth"])
    specific_weight = float(attrs["water_density"]) * gravity
    linear = linear_plant(buoy, radiation, NO_WAVES, motions)
    forces = {name: force for name, force in linear.forces.items() if name != "hydrostatic"}
    waves = incident(sea, depth, gravity, basis.shell.radius) if sea.omega.size else None
    wet = WetShell(basis, shape.centre_height)
    water = WaterPressure(wet, shape.amplitudes, specific_weight, buoy.stiffness_parts["hydrostatic"], waves=waves)
    weight = ConstantForce(-gravity * basis.inertia[0])
    forces |= {"water": water, "weight": weight}
    if "prestress" in forces:
        at_rest = specific_weight * wet.forces(shape.amplitudes[None])[0][0]
        forces["preload"] = ConstantForce(-at_rest - weight.force)
    if sea.omega.size:
        forces["diffraction"] = Excitation(sea.omega, sea.amplitude[:, None] * buoy.diffraction(sea.omega))
    plant = Plant(linear.labels, linear.mass, forces, motions)
    return replace(plant, origin=resting(plant))


def resting(plant: Plant) -> FloatArray:
    """Return y of a body-exact scene at rest in still water, shape (free,) [m], by Newton's method.

    Raises
    ------
    ConvergenceError
        If the scene does not come to rest.
    """
    water, y = plant.water, np.zeros(plant.motions.shape[1])
    assert water is not None
    stiffness = plant.total(Spring)
    load = sum((f.force for f in plant.forces.values() if isinstance(f, ConstantForce)), np.zeros(len(plant.labels)))
    for _ in range(50):
        shell = DeformedShell(water.shell.basis, water.shell.centre_height, water.rest + plant.motions @ y)
        static = water.specific_weight * water.shell.forces(shell.amplitudes[None])[0][0]
        tangent = plant.motions.T @ shell.hydrostatic_stiffness(water.specific_weight, 1.0) @ plant.motions
        try:
            step = cho_solve(cho_factor(stiffness + tangent), plant.motions.T @ (static + load) - stiffness @ y)
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


def assumed_pressure_plant(
    shell: DeformedShell, pto: LinearPto, load: AssumedPressure, density: float, gravity: float, motions: FloatArray
) -> Plant:
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
    wet = WetShell(basis, shell.centre_height)
    forces: dict[str, Force] = {
        "water": WaterPressure(wet, np.zeros(len(basis.labels)), density * gravity, tangent, assumed=load),
        "weight": ConstantForce(-gravity * basis.inertia[0]),
    }
    if pto.damping:
        forces["pto"] = Damper(pto.matrix(len(basis.labels)))
    forces |= _shell_forces(basis, motions)
    plant = Plant(basis.labels, basis.inertia, forces, motions)
    resting(plant)  # a shell that cannot carry its load collapses: no buoy, however well integrated
    return plant


def _shell_forces(basis: ModeBasis, motions: FloatArray) -> dict[str, Force]:
    """Elastic force and structural damping of a flexible design; a rigid one has none."""
    if motions.shape[1] < 2:
        return {}
    damping: dict[str, Force] = {"structural_damping": Damper(basis.damping)} if basis.damping.any() else {}
    return {"elastic": Spring(basis.stiffness), **damping}
