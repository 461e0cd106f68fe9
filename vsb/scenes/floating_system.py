"""What a study lets float, a buoy or a body: its linear motion, the motions of its designs, its port, its seas.

All that is linear, the response, the ladder of take-offs, the tuning of a damper, asks this and knows no other kind.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from vsb.errors import ConfigError
from vsb.hydro import database
from vsb.hydro.dofs import flexible
from vsb.motion.linear import LinearSystem, with_open_chamber
from vsb.motion.port import LinearPto, Port, channels_reached, combination, port_direction
from vsb.motion.tuning import frequencies
from vsb.scenes.rest import design_motions, order_bases
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, check_rank, mode_basis, rigid_basis
from vsb.study.body import BodyDesign, BodyStudy
from vsb.study.quantities import is_rigid
from vsb.study.specs import AnyBuoy, BodySystem, LadderSpec, SimulateSpec, SystemSpec
from vsb.study.study import RecordedSea, StillWater, Study, Wave
from vsb.study.take_off import DofPort
from vsb.tools.arrays import FloatArray, IntArray
from vsb.waves.seas import Sea, sea

AnyBody = BodyStudy | BodySystem
"""A body with its designs and take-off."""
InSeas = Study | BodyStudy | LadderSpec | SimulateSpec
"""What has seas and how long they last."""


@dataclass(frozen=True)
class FloatingSystem:
    """A buoy or a body without take-off, in waves from one direction, and what designs and take-off make of it."""

    linear: LinearSystem
    motions: Mapping[str, FloatArray]  # design -> N (dof, free)
    port: FloatArray  # b (dof,)
    channels: int = 1  # azimuthal orders the port reaches: each may radiate, so that power is limited by as many λ/2π

    def towards(self, wave: Wave) -> LinearSystem:
        """Return its motion in waves of a sea's direction."""
        return towards(self.linear, heading(wave))


def towards(linear: LinearSystem, direction: float) -> LinearSystem:
    """Return a motion in waves of a direction [degrees]; a buoy of revolution that heaves answers all alike."""
    return replace(linear, direction=float(np.deg2rad(direction)))


def floating_system(study: AnyBuoy | AnyBody | SystemSpec, database_path: str) -> FloatingSystem:
    """Return what floats in a study, or in the specification of a stage, from its database."""
    system = study.system if isinstance(study, SystemSpec) else study
    if isinstance(system, BodyStudy | BodySystem):
        return body_system(system, stored_body(database_path))
    buoy, basis = linear_buoy(system, database_path)
    motions = {design: design_motions(system, basis, design) for design in system.designs}
    port = study_port(system, buoy, basis)
    return FloatingSystem(buoy, motions, port, channels_reached(port, buoy.orders))


# a buoy -------------------------------------------------------------------------------------------------------------


def linear_buoy(study: AnyBuoy, database_path: str) -> tuple[LinearSystem, ModeBasis]:
    """Return the linear buoy of a study, without take-off, from its database, and its axisymmetric shell modes.

    To a take-off of the volume trapped gas is a chamber before it.
    """
    ds = database.load_database(database_path, Path(database_path).stem)
    shell_moves = flexible(ds.influenced_dof.values)  # of the database: a rigid design may share it with flexible ones
    modes = study.modes
    basis = mode_basis(study.device, modes.basis, modes.max_degree) if shell_moves else rigid_basis(study.device)
    damping = block_diag(basis.damping, *(order.damping for order in order_bases(study, basis)))
    buoy = LinearSystem(ds, damping, LinearPto(0.0))
    return (with_open_chamber(buoy, study_port(study, buoy, basis)) if study.opens_chamber else buoy), basis


def rest_shape(study: AnyBuoy, buoy: LinearSystem, basis: ModeBasis) -> DeformedShell:
    """Return the shell a linear buoy moves about."""
    return DeformedShell(basis, study.centre_height, buoy.database.reference_amplitude.values[: len(basis.labels)])


def study_port(study: AnyBuoy, buoy: LinearSystem, basis: ModeBasis) -> FloatArray:
    """Return b of the take-off of a study, shape (dof,); see `vsb.motion.port.port_direction`."""
    return port_direction(study.pto.port, rest_shape(study, buoy, basis), order_bases(study, basis))


# a body -------------------------------------------------------------------------------------------------------------


def stored_body(database_path: str) -> LinearSystem:
    """Return the body of a database that stage `body` has completed."""
    ds = database.load_database(database_path, Path(database_path).stem)
    return LinearSystem(ds, np.asarray(ds.structural_damping_matrix.values), axisymmetric=False)


def body_system(study: AnyBody, body: LinearSystem) -> FloatingSystem:
    """Return what a study lets float of a body."""
    motions = {name: body_motions(name, design, body.labels) for name, design in study.designs.items()}
    return FloatingSystem(body, motions, body_port(study, body.labels))


def body_port(study: AnyBody, labels: Sequence[str]) -> FloatArray:
    """Return b of the take-off of a study of a body, shape (dof,); by default heave."""
    port = study.pto.port
    return combination(labels, port.dofs if isinstance(port, DofPort) else {"Heave": 1.0})


def moved(design: BodyDesign, labels: Sequence[str]) -> tuple[str, ...]:
    """Return the degrees of freedom a design moves in, by name."""
    if isinstance(design.dofs, tuple):
        return design.dofs
    return tuple(label for label in labels if design.dofs == "all" or is_rigid(label))


def held_rows(design: BodyDesign, labels: Sequence[str]) -> FloatArray:
    """Return what a design holds at zero, Phi q = 0, shape (constraint, dof)."""
    return np.array([[shares.get(label, 0.0) for label in labels] for shares in design.held]).reshape(-1, len(labels))


def body_motions(name: str, design: BodyDesign, labels: Sequence[str]) -> FloatArray:
    """Return the motions a design allows, N, shape (dof, free): degrees of freedom, less what is held.

    Raises
    ------
    ConfigError
        If it names what is not there, or nothing moves.
    """
    chosen = moved(design, labels)
    held = [label for shares in design.held for label in shares]
    for key, names in (("dofs", chosen), ("held", held)):
        if unknown := [label for label in names if label not in labels]:
            raise ConfigError(f"designs.{name}.{key}: received {', '.join(unknown)}; needs some of {', '.join(labels)}")
    free = np.eye(len(labels))[:, [labels.index(label) for label in chosen]]
    rows = held_rows(design, labels) @ free
    if rows.any():
        free = free @ np.linalg.svd(rows)[2][check_rank(rows) :].T
    if not free.size:
        raise ConfigError(
            f"designs.{name}: received dofs {', '.join(chosen) or 'none'}, all held; needs one that moves"
        )
    return np.asarray(free)


# seas ---------------------------------------------------------------------------------------------------------------


def band(study: InSeas, ds: xr.Dataset | None) -> tuple[float, float]:
    """Return the band the components of a sea lie in [rad/s]: of a body what its database holds."""
    if (known := study.band) is not None:
        return known
    assert ds is not None
    return float(ds.omega[0]), float(ds.omega[-1])


def study_sea(study: InSeas, wave: Wave, ds: xr.Dataset) -> Sea:
    """Return a sea of a study, what of it lies in the band of a database.

    Of a spectrum next to nothing lies below the first frequency of a buoy's database, of a record noise may.
    """
    lowest, highest = band(study, ds)
    lowest = float(ds.omega[0]) if isinstance(wave, RecordedSea) else lowest
    found = sea(wave, highest, study.simulation.duration)
    kept = (found.omega >= lowest - 1e-9) & (found.omega <= highest + 1e-9)
    return found if kept.all() else Sea(found.omega[kept], found.amplitude[kept])


def heading(wave: Wave) -> float:
    """Return the direction a sea goes to [degrees]; in still water any will do."""
    return 0.0 if isinstance(wave, StillWater) else wave.direction


def headings(seas: Sequence[tuple[Wave, Sea]]) -> dict[float, FloatArray]:
    """Return the directions of seas [degrees], still water left out, and all frequencies of those of each [rad/s]."""
    going = dict.fromkeys(heading(wave) for wave, _ in seas if not isinstance(wave, StillWater))
    return {one: frequencies([sea for wave, sea in seas if _goes(wave, one)]) for one in going}


def _goes(wave: Wave, direction: float) -> bool:
    """Whether a sea has waves, and they go to a direction."""
    return not isinstance(wave, StillWater) and wave.direction == direction


class PortInSeas(NamedTuple):
    """A port in several seas, those of each direction at their own frequencies, one direction after the other."""

    port: Port
    squares: FloatArray  # squared amplitudes (sea, omega) [m^2]
    places: Sequence[IntArray]  # of the components of each sea among the frequencies


def port_in_seas(floating: FloatingSystem, design: str, seas: Sequence[tuple[Wave, Sea]]) -> PortInSeas:
    """Return what the take-off of a design sees in seas, still water left out.

    Impedances do not know where waves come from, free velocities do: a port in waves of several directions is one at
    as many sets of frequencies.
    """
    ports, places, before = [], [np.zeros(0, dtype=np.intp)] * len(seas), 0
    for direction, omega in headings(seas).items():
        linear = towards(floating.linear, direction)
        ports.append(linear.port(omega, floating.motions[design], floating.port))
        for i in (i for i, (wave, _) in enumerate(seas) if _goes(wave, direction)):
            places[i] = before + np.searchsorted(omega, seas[i][1].omega)
        before += len(omega)
    squares = np.zeros((len(seas), before))
    for row, place, (_, waves) in zip(squares, places, seas, strict=True):
        row[place] = np.abs(waves.amplitude) ** 2
    omega, admittance, velocity = (
        np.concatenate([getattr(port, name) for port in ports]) for name in ("omega", "admittance", "velocity")
    )
    return PortInSeas(Port(omega, admittance, velocity, ports[0].compliance), squares, places)
