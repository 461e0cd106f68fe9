"""What a study lets float, a buoy or a body: its linear motion, the motions of its designs, its port, its seas.

All that is linear, the response, the control levels, the tuning of a damper, a site's year, asks this and knows no
other kind.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from vsb.engine.hydro import database
from vsb.engine.hydro.database import Coefficients, shares
from vsb.engine.hydro.dofs import Displacement, displacements, flexible
from vsb.engine.hydro.orders import Directions, order_shares
from vsb.engine.hydro.variables import is_rigid
from vsb.engine.motion.coefficient_errors import (
    INTERPOLATION,
    RESOLVED,
    CoefficientError,
    coefficient_errors,
    combined,
    haskind_misfits,
    relative_error,
)
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.linear import LinearSystem, channelled, with_open_chamber
from vsb.engine.motion.port import Port, PortMotion, Ports, channels_reached, combination, port_direction
from vsb.engine.motion.take_off import DofPort
from vsb.engine.motion.tuning import frequencies
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell
from vsb.engine.shell.modes import ModeBasis, check_rank, mode_basis, rigid_basis
from vsb.engine.shell.orders import OrderBasis
from vsb.engine.shell.rings import HIGHEST
from vsb.engine.waves.kinds import Irregular, Wave
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.models.rest import (
    design_motions,
    order_bases,
    seen_by_take_off,
    side_by_side,
    stored_with_rings,
    viscous_parts,
    whole_stiffness,
    with_rings,
    without_rings,
)
from vsb.study.body import BodyDesign
from vsb.study.study import Study
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

Heading = float | Directions
"""A direction [degrees], or one for every frequency."""


SeenPort = TypeVar("SeenPort", Port, Ports)
Kept = TypeVar("Kept")


class InWaves(NamedTuple, Generic[SeenPort]):
    """One design in waves of unit amplitude: what its take-off sees of it, and what moves with that."""

    port: SeenPort
    motion: PortMotion
    moved: tuple[ComplexArray, ComplexArray]  # free (omega, dof) [m/m], forced (omega, dof) or (omega, dof, port) [m/N]


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

    def several_ports(self) -> dict[str, Ports]:
        """Return what a damper matrix at several ports sees of every design."""
        return {design: self.equation.ports(motions, self.port) for design, motions in self.motions.items()}

    def seen(self, stiffness: float = 0.0) -> Mapping[str, Port | Ports]:
        """Return what the take-off sees of every design at its one port, beside its spring [N/m], or at several."""
        return self.ports(stiffness) if self.port.ndim == 1 else self.several_ports()

    def in_waves(self) -> dict[str, InWaves[Any]]:
        """Return every design in waves of unit amplitude, computed once."""
        return dict(self._in_waves)

    @cached_property
    def _in_waves(self) -> dict[str, InWaves[Any]]:
        seen: Callable[..., Any] = self.equation.port_of_motion
        if self.port.ndim == 2:
            seen = self.equation.ports_of_motion
        found = {}
        for design, motions in self.motions.items():
            free, forced = self.equation.free_motion(motions, self.port)
            heave, shell = (free[:, 0], forced[:, 0]), (self.of_shell(free), self.of_shell(forced))
            port = seen(free, forced, motions, self.port)
            found[design] = InWaves(port, PortMotion(heave, shell), (free, forced))
        return found

    def of_shell(self, amplitude: ComplexArray) -> ComplexArray:
        """Return displacements of points of the shell without heave, of amplitudes (omega, dof) or (omega, dof, port).

        Shape (2, point, omega) or (2, point, omega, port).
        """
        if amplitude.ndim == 3:
            return np.stack([self.of_shell(one) for one in np.moveaxis(amplitude, 2, 0)], axis=-1)
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
    clamps: Sequence[float] | None = None  # where its wall moves water beside loads: clamps of all designs [degrees]

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


def floating_system(study: Study, database_path: str, highest: int | None = None) -> FloatingSystem:
    """Return what floats in a study from its database.

    Degrees of its shell up to the highest answer loads at rings, see `vsb.models.rest`; where one is given, what they
    do there moves no water.
    """
    if study.KIND == "body":
        return floating_body(study, stored_body(database_path))
    # the buoy of a study from its database; to a take-off of the volume trapped gas is a chamber before it
    ds = database.load_database(database_path, Path(database_path).stem)
    shell_moves = flexible(ds.influenced_dof.values)  # of the database: a rigid design may share it with flexible ones
    modes = study.modes
    basis = mode_basis(study.device, modes.basis, modes.max_degree) if shell_moves else rigid_basis(study.device)
    shape = DeformedShell(basis, study.centre_height, ds.reference_amplitude.values[: len(basis.labels)])
    dry, wet = without_rings(ds), None
    if highest is None and "Ring1" in ds.influenced_dof:
        wet = json.loads(ds.attrs["clamps"])
    ds, shape = stored_with_rings(study, dry if wet is None else ds, shape, highest or HIGHEST, wet=wet)
    if shape.basis.rings is None:
        ds = dry
    basis = shape.basis
    orders = order_bases(study, basis)
    port = port_direction(study.pto.port, shape, orders)
    damping, maxwell = block_diag(basis.damping, *(order.damping for order in orders)), study.device.damping.maxwell
    buoy = LinearSystem(ds, damping, maxwell=maxwell if shell_moves else ())
    motions = {design: design_motions(study, basis, design) for design in study.designs}
    linear = with_open_chamber(buoy, port) if study.opens_chamber else buoy
    return FloatingSystem(linear, motions, port, channels_reached(port, buoy.orders), shape, wet)


# a body -------------------------------------------------------------------------------------------------------------


def stored_body(database_path: str) -> LinearSystem:
    """Return the body of a database that stage `body` has completed."""
    ds = database.load_database(database_path, Path(database_path).stem)
    return LinearSystem(ds, np.asarray(ds.structural_damping_matrix.values), axisymmetric=False)


def floating_body(study: Study, body: LinearSystem) -> FloatingSystem:
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


def band(study: Study, ds: xr.Dataset | None) -> tuple[float, float]:
    """Return the band the components of a sea lie in [rad/s]: of a body what its database holds."""
    if (known := study.band) is not None:
        return known
    assert ds is not None
    return float(ds.omega[0]), float(ds.omega[-1])


def study_sea(study: Study, wave: Wave, ds: xr.Dataset) -> Sea:
    """Return a sea of a study, what of it lies in the band of a database.

    Of a spectrum next to nothing lies below the first frequency of a buoy's database, of what a file holds there may.
    """
    return _within_band(study, wave, ds, study.simulation.duration)


def _within_band(study: Study, wave: Wave, ds: xr.Dataset, duration: float) -> Sea:
    """A sea of components that do not repeat within a duration [s], what of it lies in the band of a database."""
    lowest, highest = band(study, ds)
    lowest = float(ds.omega[0]) if wave.of_file else lowest
    found = wave.realisation(highest, duration)
    kept = (found.omega >= lowest - 1e-9) & (found.omega <= highest + 1e-9)
    return found if kept.all() else found.part(kept)


def narrow_band(wave: Irregular) -> float:
    """Return the width of the bands of `expected_sea` [rad/s], a power of two, which neighbouring seas share."""
    return float(2.0 ** np.floor(np.log2(wave.resolution)))


TURN = 4
"""Bands of a spread sea to one of a long-crested sea, at least, and of these in a round of all directions, at most."""


def expected_sea(study: Study, wave: Wave, ds: xr.Dataset) -> Sea:
    """Return a sea whose components carry its spectrum: mean powers in it are expectations, whatever is simulated.

    Bands are narrower than any resonance that matters, and those of neighbouring seas are the same; of a spread sea
    they are narrower still, for its directions take turns. A record of elevations is all the sea there is: expectations
    are means over the whole of it.
    """
    if not wave.drawn:
        return study_sea(study, wave, ds)
    width = narrow_band(wave) / (max(TURN, -(-wave.parts_around // TURN)) if wave.spreads else 1)
    found = _within_band(study, wave.expected, ds, 2 * np.pi / (1.1 * width))
    return replace(found, heading=wave.even_headings(found.omega)) if wave.spreads else found


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


# a buoy from the coefficients of its shape, which studies of other materials share ----------------------------------

POINTS = 13
"""Points of the meridian the shell's motion is given at, both poles and the equator among them."""
KEPT = 32
"""Combinations of displacements whose coefficients are kept: as many thicknesses as a sweep may well have."""
BUOYS = 4
"""Buoys that are kept in the water of a shape: with the modes of a study, and with more of them."""
AT_ONCE = 4_000_000
"""Entries of a matrix of coefficients over frequency that are combined at once: 32 megabytes."""
GRIDS = 3
"""Sets of frequencies whose coefficients are kept: of a climate, and two of the harmonics of an optimum."""
OF_BUOY = {"device", "modes", "reference_shape", "designs", "water", "motion", "mooring"}
"""Sections of a study that its buoy follows from, without what its take-off does."""
OF_PORT = {"port", "held"}
"""Keys of a take-off by which it sees the buoy."""
STATED = ("error_estimate", "interpolation_error")
"""Errors that blocks estimate of themselves."""


@dataclass(frozen=True)
class ShapeWater:
    """Coefficients of the displacements of one wetted shape."""

    displacements: tuple[Displacement, ...]
    omega: FloatArray  # (omega,) [rad/s]
    coefficients: Coefficients  # of the displacements
    orders: tuple["ShapeWater", ...] = ()  # those of azimuthal orders 1, 2, ..., if the buoy moves in them
    resolution: float = 0.0  # estimated relative error of what is solved, and of what is interpolated between [-]
    interpolation: float = 0.0
    clamps: Sequence[float] | None = None  # see `FloatingSystem`
    _known: dict[bytes, Coefficients] = field(default_factory=dict, repr=False, compare=False)
    _errors: dict[Any, list[CoefficientError]] = field(default_factory=dict, repr=False, compare=False)  # the last ones
    _buoys: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)  # the last few

    def in_modes(self, basis: ModeBasis, families: Sequence[OrderBasis] = ()) -> Coefficients:
        """Return the coefficients of heave and modes, and of families of higher orders, each of one channel."""
        own = self._combined(shares(self.displacements, basis))
        return Coefficients.side_by_side([own, *(self._of_family(each) for each in families)])

    def parts(self, motions: int) -> list[slice]:
        """Return its frequencies in parts, for of many motions all at once take gigabytes.

        Each spans the band: a port is judged by what it does in all of it.
        """
        count = max(1, math.ceil(len(self.omega) * motions**2 / AT_ONCE))
        return [slice(first, None, count) for first in range(count)]

    def at(self, part: slice) -> "ShapeWater":
        """Return the same at some of its frequencies; itself at all of them."""
        if part == slice(0, None, 1):
            return self
        added_mass, damping, excitation = self.coefficients
        found = Coefficients(added_mass[part], damping[part], excitation[part])
        orders = tuple(one.at(part) for one in self.orders)
        return ShapeWater(
            self.displacements, self.omega[part], found, orders, self.resolution, self.interpolation, self.clamps
        )

    def kept(self, key: str, made: Callable[[], Kept]) -> Kept:
        """Return what a key stands for of a buoy in this water, made if it is none of the last few."""
        if key not in self._buoys:
            if len(self._buoys) == BUOYS:
                del self._buoys[next(iter(self._buoys))]
            self._buoys[key] = made()
        found: Kept = self._buoys[key]
        return found

    def _of_family(self, family: OrderBasis) -> Coefficients:
        """Coefficients of one family of higher orders; of yaw, of order 0, which moves no water, none."""
        if not family.order:
            still = np.zeros((len(self.omega), 1, 1))
            return Coefficients(still, still, still[..., 0].astype(complex))
        water = self.orders[family.order - 1]
        return water._combined(order_shares(water.displacements, family))

    def errors(self, basis: ModeBasis, families: Sequence[OrderBasis], water: Water) -> list[CoefficientError]:
        """Return the estimated errors of `in_modes`, as of `vsb.engine.motion.coefficient_errors`, added up."""
        transform = shares(self.displacements, basis)
        if (key := (transform.tobytes(), *families, water)) not in self._errors:
            self._errors.clear()
            self._errors[key] = combined(self._estimated(transform, self.in_modes(basis, families), water))
        return self._errors[key]

    def _estimated(self, transform: FloatArray, found: Coefficients, water: Water) -> list[CoefficientError]:
        """Errors by source of the coefficients of combinations of the displacements, and of families."""
        own = len(transform)
        mass, damping, force = (self.interpolation * np.abs(values) for values in found)
        mass[:, :own, :own], damping[:, :own, :own], force[:, :own] = haskind_misfits(
            self.omega,
            transform @ self.coefficients.damping @ transform.T,
            found.damping[:, :own, :own],
            found.excitation[:, :own],
            water.depth,
            water.density,
            water.gravity,
        )
        between = Coefficients(mass, damping, force.astype(complex))
        return [
            relative_error(RESOLVED, found, self.resolution),
            CoefficientError(INTERPOLATION, between, signed=False),
        ]

    def _combined(self, transform: FloatArray) -> Coefficients:
        """Coefficients of combinations of the displacements, once for all materials that combine them alike."""
        if (key := transform.tobytes()) not in self._known:
            if len(self._known) == KEPT:
                self._known.clear()
            self._known[key] = self._transformed(transform)
        return self._known[key]

    def _transformed(self, transform: FloatArray) -> Coefficients:
        """Those of one combination, which radiate through one channel as a buoy's do."""
        added_mass, damping, excitation = self.coefficients
        force, lost = excitation @ transform.T, np.einsum("wij,ij->w", damping, transform.T @ transform)
        return Coefficients(transform @ added_mass @ transform.T, channelled(lost, force), force)


@dataclass(frozen=True)
class SweptShape:
    """A shape whose coefficients are solved, to be had at any frequencies of the band."""

    buoys: tuple[LinearSystem, ...]  # in displacements, of azimuthal orders 0, 1, ...
    clamps: Sequence[float] | None = None  # see `FloatingSystem`
    _known: dict[bytes, ShapeWater] = field(default_factory=dict, repr=False, compare=False)  # the last few

    def at(self, omega: FloatArray) -> ShapeWater:
        """Return the coefficients at frequencies; outside the band those of its nearest end."""
        if (key := omega.tobytes()) not in self._known:
            if len(self._known) == GRIDS:
                del self._known[next(iter(self._known))]
            self._known[key] = self._at(omega)
        return self._known[key]

    def _at(self, omega: FloatArray) -> ShapeWater:
        """The coefficients at frequencies."""
        known = np.clip(omega, *self.band)
        first, *others = (
            ShapeWater(displacements(buoy.labels, order), omega, buoy.coefficients(known))
            for order, buoy in enumerate(self.buoys)
        )
        attrs = [buoy.database.attrs for buoy in self.buoys]
        resolution, interpolation = (max(float(each.get(name, 0.0)) for each in attrs) for name in STATED)
        return replace(
            first, orders=tuple(others), resolution=resolution, interpolation=interpolation, clamps=self.clamps
        )

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency solved [rad/s]."""
        first, last = self.buoys[0].database.omega.values[[0, -1]]
        return float(first), float(last)


@dataclass(frozen=True)
class BuoyOfShape:
    """The buoy of a study at rest in the coefficients of its shape, which studies of other materials share."""

    study: Study
    reference: ReferenceShell
    swept: SweptShape

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency solved [rad/s]."""
        return self.swept.band

    @property
    def moving(self) -> ReferenceShell:
        """Its shell at rest with all degrees of freedom it moves in: also the modes of rings that are loaded."""
        return with_rings(self.study, self.reference, wet=self.swept.clamps)

    def at(self, omega: FloatArray) -> AtFrequencies:
        """Return it at frequencies; outside the band with the coefficients of its nearest end.

        Kept for members of a campaign that differ by what their take-off does alone.
        """
        return kept_buoy(self.study, self.reference, self.swept.at(omega))

    def errors(self, omega: FloatArray) -> list[CoefficientError]:
        """Return the estimated errors of its coefficients at frequencies."""
        basis = self.moving.basis
        return self.swept.at(omega).errors(basis, order_bases(self.study, basis), self.study.water)


def kept_buoy(study: Study, reference: ReferenceShell, water: ShapeWater) -> AtFrequencies:
    """Return the same as `buoy_at`, kept for studies that differ by what their take-off does alone."""
    return water.kept(buoy_key(study), lambda: buoy_at(study, reference, water))


def buoy_key(study: Study) -> str:
    """Return what a buoy and what its take-off sees of it follow from, as text."""
    return " ".join([study.model_dump_json(include=OF_BUOY), study.pto.model_dump_json(include=OF_PORT)])


def buoy_at(study: Study, reference: ReferenceShell, water: ShapeWater) -> AtFrequencies:
    """Return the buoy of a study at the frequencies of the coefficients of its shape."""
    reference = with_rings(study, reference, wet=water.clamps)
    basis, families = reference.basis, order_bases(study, reference.basis)
    seen, chamber = seen_by_take_off(study, reference)
    inertia, damping = (
        side_by_side(getattr(basis, name), *(getattr(each, name) for each in families))
        for name in ("inertia", "damping")
    )
    omega, stiffness = water.omega, whole_stiffness(study, seen)
    lossy, stiffer = viscous_parts(study, reference, omega) if study.device.damping.maxwell else (0.0, 0.0)
    equation = LinearEquation(
        omega, water.in_modes(basis, families), inertia, damping + lossy, stiffness, stiffer, chamber
    )
    motions = {design: design_motions(study, basis, design) for design in study.designs}
    port = port_direction(study.pto.port, reference.shape, families)
    return AtFrequencies(equation, motions, port, shell_shapes(basis, families))


def shell_shapes(basis: ModeBasis, families: Sequence[OrderBasis] = ()) -> FloatArray:
    """Return displacements in both directions of points of a meridian, rigid motions none, (dof, 2, point) [-].

    With families of higher orders on both meridians in the plane of the waves, theta = 0 and pi.
    """
    at = np.linspace(0.0, np.pi, POINTS)
    axisymmetric = np.stack(basis.displacement(at), axis=1)
    if not families:
        return axisymmetric
    found = [np.concatenate([axisymmetric, axisymmetric], axis=2)]
    for each in families:
        one = np.stack(each.field(at)[:2], axis=1)
        one[: each.rigid] = 0.0
        found.append(np.concatenate([one, (-1) ** each.order * one], axis=2))
    return np.concatenate(found)
