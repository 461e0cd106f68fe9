"""The ports of all designs of a study from the coefficients of its shape, which studies of other materials share."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vsb.hydro.coefficients import Coefficients
from vsb.hydro.database import shares
from vsb.hydro.dofs import Displacement
from vsb.motion.channel import channelled
from vsb.motion.frequency import free_motion, port_of_motion
from vsb.motion.port import Port, PortMotion, port_direction
from vsb.scenes.rest import design_motions, seen_by_take_off
from vsb.shell.modes import ModeBasis
from vsb.shell.rest import ReferenceShell
from vsb.study.study import Study
from vsb.tools.units import FloatArray

POINTS = 13
"""Points of the meridian the shell's motion is told at, both poles and the equator among them."""


@dataclass(frozen=True)
class ShapeWater:
    """Coefficients of the displacements of one wetted shape."""

    displacements: tuple[Displacement, ...]
    omega: FloatArray  # (omega,) [rad/s]
    coefficients: Coefficients  # of the displacements

    def in_modes(self, basis: ModeBasis) -> Coefficients:
        """Return the coefficients of heave and modes, which radiate through one channel as a buoy's do."""
        transform = shares(self.displacements, basis)
        added_mass, damping, excitation = self.coefficients
        force, lost = excitation @ transform.T, transform @ damping @ transform.T
        return Coefficients(transform @ added_mass @ transform.T, channelled(lost, force), force)


class InWaves(NamedTuple):
    """One design in waves of unit amplitude: what its take-off sees of it, and what moves with that."""

    port: Port
    motion: PortMotion


def designs_in_waves(study: Study, reference: ReferenceShell, water: ShapeWater) -> dict[str, InWaves]:
    """Return every design of a study in waves, without its take-off."""
    basis, omega = reference.basis, water.omega
    coefficients = water.in_modes(basis)
    direction = port_direction(study.pto.port, reference.shape)
    seen, chamber = seen_by_take_off(study, reference)
    matrices = (basis.inertia, basis.damping, seen.total)
    lossy = coefficients.damping + basis.damping
    shapes = np.stack(basis.displacement(np.linspace(0.0, np.pi, POINTS)), axis=1)[1:]  # (mode, 2, point)
    found = {}
    for design in study.designs:
        free = design_motions(study, basis, design)
        moved = free_motion(omega, coefficients, *matrices, free, direction)
        port = port_of_motion(omega, *moved, lossy, seen.total, free, direction)
        heave, shell = zip(*((one[:, 0], np.einsum("wn,ncp->cpw", one[:, 1:], shapes)) for one in moved), strict=True)
        found[design] = InWaves(port.behind(chamber), PortMotion(heave, shell))
    return found


def design_ports(study: Study, reference: ReferenceShell, water: ShapeWater) -> dict[str, Port]:
    """Return what the damper of the take-off sees of every design, its spring built in."""
    waves = designs_in_waves(study, reference, water)
    return {design: one.port.beside(study.pto.stiffness) for design, one in waves.items()}
