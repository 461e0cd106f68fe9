"""What a study lets float, a buoy or a body: its linear motion, the motions of its designs, its port, its seas.

All that is linear, the response, the control levels, the tuning of a damper, a site's year, asks this and knows no
other kind.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from vsb.engine.hydro import database
from vsb.engine.hydro.dofs import flexible
from vsb.engine.hydro.orders import Directions
from vsb.engine.hydro.variables import is_rigid
from vsb.engine.motion.coefficient_errors import CoefficientError, coefficient_errors, combined
from vsb.engine.motion.damper_matrix import Ports
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.linear import LinearSystem, with_open_chamber
from vsb.engine.motion.port import Port, PortMotion, channels_reached, combination, port_direction
from vsb.engine.motion.take_off import DofPort
from vsb.engine.motion.tuning import frequencies
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import check_rank, mode_basis, rigid_basis
from vsb.engine.shell.rings import HIGHEST
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import Sea
from vsb.errors import ConfigError
from vsb.models.rest import design_motions, order_bases
from vsb.models.ring_loads import stored_with_rings
from vsb.study.body import BodyDesign, BodyStudy
from vsb.study.specs import AnyBuoy, BodySystem, LadderSpec, SimulateSpec, SystemSpec
from vsb.study.study import Study
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

AnyBody = BodyStudy | BodySystem
"""A body with its designs and take-off."""
InSeas = Study | BodyStudy | LadderSpec | SimulateSpec
"""What has seas and how long they last."""


Heading = float | Directions
"""A direction [degrees], or one for every frequency."""


class InWaves(NamedTuple):
    """One design in waves of unit amplitude: what its take-off sees of it, and what moves with that."""

    port: Port
    motion: PortMotion
    moved: tuple[ComplexArray, ComplexArray]  # free, forced (omega, dof) [m/m], [m/N]

    def position(self, damping: float, stiffness: float) -> ComplexArray:
        """Return all degrees of freedom per wave amplitude under a damper and a spring, shape (omega, dof) [m/m]."""
        load = self.port.load(damping, stiffness)
        return self.moved[0] - (load * self.port.velocity_under(load))[:, None] * self.moved[1]

    def motion_under(self, force: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return heave (omega,) and shell (2, point, omega) per wave amplitude under a force (omega,) [m/m]."""
        heave, shell = (free - force * forced for free, forced in (self.motion.heave, self.motion.shell))
        return heave, shell


class SeveralInWaves(NamedTuple):
    """One design in waves of unit amplitude at several ports; see `InWaves`."""

    port: Ports
    moved: tuple[ComplexArray, ComplexArray]  # free (omega, dof) [m/m], forced (omega, dof, port) [m/N]
    at: "AtFrequencies"

    def motion(self, damping: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return heave (omega,) and shell (2, point, omega) per wave amplitude under a damper matrix [m/m]."""
        return self.motion_under(self.port.velocity_under(damping) @ damping)

    def motion_under(self, force: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return the same under forces per wave amplitude (omega, port)."""
        moved = self.moved[0] - (self.moved[1] @ force[..., None])[..., 0]
        return moved[:, 0], self.at.of_shell(moved)


@dataclass(frozen=True)
class AtFrequencies:
    """A floating system at some frequencies, without take-off: its equation of motion, its designs, its port."""

    equation: LinearEquation
    motions: Mapping[str, FloatArray]  # design -> N (dof, free)
    port: FloatArray  # b (dof,); of several ports at once B (dof, port)
    shapes: FloatArray | None = None  # displacements of points of a shell (dof, 2, point) [-]; a body has none

    def ports(self, stiffness: float = 0.0) -> dict[str, Port]:
        """Return what the damper of a take-off sees of every design, beside its spring [N/m]."""
        return {design: port.beside(stiffness) for design, port in self._ports.items()}

    @cached_property
    def _ports(self) -> dict[str, Port]:
        return {design: self.equation.port(motions, self.port) for design, motions in self.motions.items()}

    def in_waves(self) -> dict[str, InWaves]:
        """Return every design in waves of unit amplitude, computed once."""
        return dict(self._in_waves)

    @cached_property
    def _in_waves(self) -> dict[str, InWaves]:
        return {design: self._of_design(motions) for design, motions in self.motions.items()}

    def several_ports(self) -> dict[str, Ports]:
        """Return what a damper matrix at several ports sees of every design."""
        return {design: self.equation.ports(motions, self.port) for design, motions in self.motions.items()}

    def several_in_waves(self) -> dict[str, SeveralInWaves]:
        """Return every design at several ports in waves of unit amplitude."""
        return {
            design: SeveralInWaves(port, self.equation.motion_of_ports(self.motions[design], self.port), self)
            for design, port in self.several_ports().items()
        }

    def _of_design(self, motions: FloatArray) -> InWaves:
        """One design."""
        moved = self.equation.free_motion(motions, self.port)
        heave, shell = zip(*((one[:, 0], self.of_shell(one)) for one in moved), strict=True)
        port = self.equation.port_of_motion(*moved, motions, self.port)
        return InWaves(port, PortMotion(heave, shell), moved)

    def of_shell(self, amplitude: ComplexArray) -> ComplexArray:
        """Return displacements of points of the shell without heave, (2, point, omega), of amplitudes (omega, dof)."""
        if self.shapes is None:
            return np.zeros((2, 0, len(amplitude)), dtype=complex)
        count, *places = self.shapes[1:].shape
        parts = np.stack([amplitude.real, amplitude.imag])[:, :, 1:] @ self.shapes[1:].reshape(count, math.prod(places))
        return np.asarray((parts[0] + 1j * parts[1]).T.reshape(*places, len(amplitude)))


class Floating(Protocol):
    """What a site's year asks of what floats, a `FloatingSystem` or a buoy whose shape studies share."""

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency solved [rad/s]."""

    def at(self, omega: FloatArray) -> AtFrequencies:
        """Return it at frequencies; outside the band with the coefficients of its nearest end."""

    def errors(self, omega: FloatArray) -> list[CoefficientError]:
        """Return the estimated errors of its coefficients at frequencies, as `combined`."""


@dataclass(frozen=True)
class FloatingSystem:
    """A buoy or a body without take-off, and what designs and take-off make of it."""

    linear: LinearSystem
    motions: Mapping[str, FloatArray]  # design -> N (dof, free)
    port: FloatArray  # b (dof,); of several ports at once B (dof, port)
    channels: int = 1  # azimuthal orders the port reaches: each may radiate, so that power is limited by as many λ/2π
    shape: DeformedShell | None = None  # a buoy moves about

    @property
    def shell(self) -> DeformedShell:
        """The shape a buoy moves about."""
        assert self.shape is not None
        return self.shape

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency solved [rad/s]."""
        first, last = self.linear.database.omega.values[[0, -1]]
        return float(first), float(last)

    def at(self, omega: FloatArray) -> AtFrequencies:
        """Return it at frequencies; outside the band with the coefficients of its nearest end."""
        return AtFrequencies(self.linear.extended_equation(omega), self.motions, self.port)

    def errors(self, omega: FloatArray) -> list[CoefficientError]:
        """Return the estimated errors of its coefficients at frequencies, as `combined`."""
        return combined(coefficient_errors(self.linear, np.clip(omega, *self.band)))

    def towards(self, direction: Heading) -> LinearSystem:
        """Return its motion in waves of a direction [degrees]; a buoy of revolution that heaves answers all alike."""
        if isinstance(direction, Directions):
            return replace(self.linear, direction=direction)
        going = float(np.deg2rad(direction))
        return self.linear if self.linear.direction == going else replace(self.linear, direction=going)

    def ports(self, omega: FloatArray, direction: Heading = 0.0) -> dict[str, Port]:
        """Return what the take-off sees of all designs in waves of one direction [degrees]."""
        equation = self.towards(direction).equation(omega)
        return {design: equation.port(motions, self.port) for design, motions in self.motions.items()}

    def several_ports(self, omega: FloatArray) -> dict[str, Ports]:
        """Return what a damper matrix at several ports sees of all designs."""
        return AtFrequencies(self.linear.equation(omega), self.motions, self.port).several_ports()

    def extended_port(self, design: str, omega: FloatArray, direction: Heading = 0.0) -> Port:
        """Return what the take-off sees of a design, also outside the band of the database."""
        return self.towards(direction).extended_port(omega, self.motions[design], self.port)


def floating_system(
    study: AnyBuoy | AnyBody | SystemSpec, database_path: str, highest: int = HIGHEST
) -> FloatingSystem:
    """Return what floats in a study, or in the specification of a stage, from its database.

    Degrees of its shell up to the highest answer loads at rings, see `vsb.models.ring_loads`.
    """
    system = study.system if isinstance(study, SystemSpec) else study
    if isinstance(system, BodyStudy | BodySystem):
        return floating_body(system, stored_body(database_path))
    return _floating_buoy(system, database_path, highest)


# a buoy -------------------------------------------------------------------------------------------------------------


def _floating_buoy(study: AnyBuoy, database_path: str, highest: int) -> FloatingSystem:
    """The buoy of a study from its database; to a take-off of the volume trapped gas is a chamber before it."""
    ds = database.load_database(database_path, Path(database_path).stem)
    shell_moves = flexible(ds.influenced_dof.values)  # of the database: a rigid design may share it with flexible ones
    modes = study.modes
    basis = mode_basis(study.device, modes.basis, modes.max_degree) if shell_moves else rigid_basis(study.device)
    shape = DeformedShell(basis, study.centre_height, ds.reference_amplitude.values[: len(basis.labels)])
    ds, shape = stored_with_rings(study, ds, shape, highest)
    basis = shape.basis
    orders = order_bases(study, basis)
    port = port_direction(study.pto.port, shape, orders)
    damping, maxwell = block_diag(basis.damping, *(order.damping for order in orders)), study.device.damping.maxwell
    buoy = LinearSystem(ds, damping, maxwell=maxwell if shell_moves else ())
    motions = {design: design_motions(study, basis, design) for design in study.designs}
    linear = with_open_chamber(buoy, port) if study.opens_chamber else buoy
    return FloatingSystem(linear, motions, port, channels_reached(port, buoy.orders), shape)


# a body -------------------------------------------------------------------------------------------------------------


def stored_body(database_path: str) -> LinearSystem:
    """Return the body of a database that stage `body` has completed."""
    ds = database.load_database(database_path, Path(database_path).stem)
    return LinearSystem(ds, np.asarray(ds.structural_damping_matrix.values), axisymmetric=False)


def floating_body(study: AnyBody, body: LinearSystem) -> FloatingSystem:
    """Return what a study lets float of a body; its take-off is on heave if it says nothing else."""
    motions = {name: body_motions(name, design, body.labels) for name, design in study.designs.items()}
    port = study.pto.port
    shares = port.dofs if isinstance(port, DofPort) else {"Heave": 1.0}
    return FloatingSystem(body, motions, combination(body.labels, shares))


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

    Raises `ConfigError` if it names what is not there, or nothing moves.
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

    Of a spectrum next to nothing lies below the first frequency of a buoy's database, of what a file holds there may.
    """
    return _within_band(study, wave, ds, study.simulation.duration)


def _within_band(study: InSeas, wave: Wave, ds: xr.Dataset, duration: float) -> Sea:
    """A sea of components that do not repeat within a duration [s], what of it lies in the band of a database."""
    lowest, highest = band(study, ds)
    lowest = float(ds.omega[0]) if wave.of_file else lowest
    found = wave.realisation(highest, duration)
    kept = (found.omega >= lowest - 1e-9) & (found.omega <= highest + 1e-9)
    return found if kept.all() else found.part(kept)


def expected_sea(study: InSeas, wave: Wave, ds: xr.Dataset) -> Sea:
    """Return a sea whose components carry its spectrum: mean powers in it are expectations, whatever is simulated.

    Bands are narrower than any resonance that matters, and those of neighbouring seas are the same. A record of
    elevations is all the sea there is: expectations are means over the whole of it.
    """
    if not wave.drawn:
        return study_sea(study, wave, ds)
    width = 2.0 ** np.floor(np.log2(wave.resolution))
    spectral = wave.expected.model_copy(update={"seed": 1})  # which a spread sea takes its directions by
    return _within_band(study, spectral, ds, 2 * np.pi / (1.1 * width))


def heading(wave: Wave) -> float:
    """Return the direction a sea goes to [degrees]; in still water any will do."""
    return 0.0 if wave.still else wave.direction


def heading_in(wave: Wave, sea: Sea) -> Heading:
    """Return the direction a sea goes to [degrees], or those of its components, where it is spread."""
    return heading(wave) if sea.heading is None else Directions(sea.omega, np.deg2rad(sea.heading))


def headings(seas: Sequence[tuple[Wave, Sea]]) -> dict[float, FloatArray]:
    """Return the directions of seas [degrees], still water left out, and all frequencies of those of each [rad/s]."""
    return {one: omega for one, omega, _ in _by_heading(seas) if not isinstance(one, Directions)}


def _by_heading(seas: Sequence[tuple[Wave, Sea]]) -> list[tuple[Heading, FloatArray, list[int]]]:
    """Directions of seas, still water left out, all frequencies of those of each, and which these are.

    A spread sea shares its directions with none.
    """
    moving = [i for i, (wave, _) in enumerate(seas) if not wave.still]
    alike = [i for i in moving if seas[i][1].heading is None]
    going = dict.fromkeys(heading(seas[i][0]) for i in alike)
    groups: list[tuple[Heading, list[int]]] = [(one, [i for i in alike if heading(seas[i][0]) == one]) for one in going]
    groups += [(heading_in(*seas[i]), [i]) for i in moving if seas[i][1].heading is not None]
    return [(one, frequencies([seas[i][1] for i in those]), those) for one, those in groups]


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
    for direction, omega, those in _by_heading(seas):
        ports.append(floating.towards(direction).port(omega, floating.motions[design], floating.port))
        for i in those:
            places[i] = before + np.searchsorted(omega, seas[i][1].omega)
        before += len(omega)
    squares = np.zeros((len(seas), before))
    for row, place, (_, waves) in zip(squares, places, seas, strict=True):
        row[place] = np.abs(waves.amplitude) ** 2
    omega, admittance, velocity = (
        np.concatenate([getattr(port, name) for port in ports]) for name in ("omega", "admittance", "velocity")
    )
    return PortInSeas(Port(omega, admittance, velocity, ports[0].compliance), squares, places)
