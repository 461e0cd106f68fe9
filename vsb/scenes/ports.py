"""The ports of all designs of a study from the coefficients of its shape, which studies of other materials share."""

from dataclasses import dataclass

from vsb.hydro.coefficients import Coefficients
from vsb.hydro.database import shares
from vsb.hydro.dofs import Displacement
from vsb.motion.frequency import port_of
from vsb.motion.port import Port, port_direction
from vsb.scenes.rest import design_motions, seen_by_take_off
from vsb.shell.modes import ModeBasis
from vsb.shell.rest import ReferenceShell
from vsb.study.study import Study
from vsb.tools.units import FloatArray


@dataclass(frozen=True)
class ShapeWater:
    """Coefficients of the displacements of one wetted shape."""

    displacements: tuple[Displacement, ...]
    omega: FloatArray  # (omega,) [rad/s]
    coefficients: Coefficients  # of the displacements

    def in_modes(self, basis: ModeBasis) -> Coefficients:
        """Return the coefficients of heave and modes."""
        transform = shares(self.displacements, basis)
        added_mass, damping, excitation = self.coefficients
        return Coefficients(
            transform @ added_mass @ transform.T, transform @ damping @ transform.T, excitation @ transform.T
        )


def design_ports(study: Study, reference: ReferenceShell, water: ShapeWater) -> dict[str, Port]:
    """Return what the damper of the take-off sees of every design, its spring built in."""
    basis = reference.basis
    coefficients = water.in_modes(basis)
    direction = port_direction(study.pto.port, reference.shape)
    seen, chamber = seen_by_take_off(study, reference)
    matrices = (basis.inertia, basis.damping, seen.total)
    motions = {design: design_motions(study, basis, design) for design in study.designs}
    ports = {design: port_of(water.omega, coefficients, *matrices, free, direction) for design, free in motions.items()}
    return {design: port.behind(chamber).beside(study.pto.stiffness) for design, port in ports.items()}
