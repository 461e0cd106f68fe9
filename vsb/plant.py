"""Equation of motion of a scene: mass, named forces, the motions a design allows. Knows no integrator.

M q'' = sum of forces, q = N y: heave and modal amplitudes q in the subspace N of the design. Only the forces of the
scene exist.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from vsb.modes import ModeBasis
from vsb.pto import LinearPto
from vsb.radiation import RadiationModel
from vsb.response import LinearBuoy
from vsb.surface import DeformedShell
from vsb.units import ComplexArray, FloatArray
from vsb.waves import Sea
from vsb.wetforce import WetShell


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
class Weight:
    """A constant force."""

    force: FloatArray  # (dof,) [N]


@dataclass(frozen=True)
class WaterPressure:
    """f_j = -int p n.psi_j dS, p = -rho g z + P cos(omega t), on the instantaneous wet part of the deformed shell."""

    shell: WetShell
    specific_weight: float  # rho g [N/m^3]
    amplitude: float  # P [Pa]
    omega: float  # [rad/s]
    tangent: FloatArray  # -df/dq of the static part about the reference shape, (dof, dof) [N/m]


Force = Spring | Damper | Excitation | RadiationMemory | Weight | WaterPressure


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


@dataclass(frozen=True)
class Plant:
    """A scene: mass including added mass at infinite frequency, named forces, allowed motions."""

    labels: tuple[str, ...]  # dof
    mass: FloatArray  # (dof, dof) [kg]
    forces: Mapping[str, Force]
    motions: FloatArray  # N (dof, free)

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
        """Return the initial y and y': heave as given, shell undeformed and at rest."""
        first = np.eye(self.motions.shape[1])[0]
        return heave * first, heave_velocity * first


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
        parts = {"elastic": "structural", "prestress": "prestress", "gas": "gas"}
        forces |= {
            force: Spring(buoy.stiffness_parts[name]) for force, name in parts.items() if name in buoy.stiffness_parts
        }
        if buoy.structural_damping.any():
            forces["structural_damping"] = Damper(buoy.structural_damping)
    if sea.omega.size:
        excitation = buoy.coefficients(sea.omega).excitation
        forces["excitation"] = Excitation(sea.omega, sea.amplitude[:, None] * excitation)
    labels = tuple(str(label) for label in database.influenced_dof.values)
    return Plant(labels, buoy.mass + buoy.added_mass_inf, forces, motions)


@dataclass(frozen=True)
class AssumedPressure:
    """A uniform pressure P cos(omega t) on the wet shell, the paper's stand-in for waves."""

    amplitude: float  # P [Pa]
    omega: float  # [rad/s]


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
    """
    basis = shell.basis
    tangent = shell.hydrostatic_stiffness(density, gravity)
    wet = WetShell(basis, shell.centre_height)
    forces: dict[str, Force] = {
        "water": WaterPressure(wet, density * gravity, load.amplitude, load.omega, tangent),
        "weight": Weight(-gravity * basis.inertia[0]),
    }
    if pto.damping:
        forces["pto"] = Damper(pto.matrix(len(basis.labels)))
    forces |= _shell_forces(basis, motions)
    return Plant(basis.labels, basis.inertia, forces, motions)


def _shell_forces(basis: ModeBasis, motions: FloatArray) -> dict[str, Force]:
    """Elastic force and structural damping of a flexible design; a rigid one has none."""
    if motions.shape[1] < 2:
        return {}
    damping: dict[str, Force] = {"structural_damping": Damper(basis.damping)} if basis.damping.any() else {}
    return {"elastic": Spring(basis.stiffness), **damping}
