"""Powers with more shell modes, for what a basis leaves out: at the frequencies of the seas alone, to twice a degree.

The degree of a basis follows from the stiffness of the wall (`vsb.study.resolution`); here powers are computed with it
and with up to twice as many degrees. Where a load acts at a ring of a sphere the static answer of all further degrees
to it is part of all of them (`vsb.models.rest`).
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from vsb.engine.hydro.database import Coefficients, with_excitation
from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.orders import heading_shares, with_haskind_damping
from vsb.engine.hydro.spectral.solver import Geometry, SpectralProblem, fewest_nodes, incident_wave, resolved
from vsb.engine.hydro.sweep import on_grid
from vsb.engine.motion.port import Port, Ports
from vsb.engine.motion.take_off import BetweenPort, DofPort, Pto, ShellPort, StrainPort
from vsb.engine.motion.tuning import best_dampers, best_matrix, best_pairs, mean_power
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell
from vsb.engine.shell.orders import goes_with_sine
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import Water
from vsb.errors import ConvergenceError
from vsb.models.floating_system import ShapeWater, buoy_at, buoy_key, heading
from vsb.models.rest import clamps, load_displacements, order_bases, reference_shell, with_rings
from vsb.models.take_off import given_matrix, matrix_kind
from vsb.study.resolution import bending_degree, degree_needed, loaded_at_ring
from vsb.study.sections import IN_PLANE, RIGID, Modes, Motion
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

FINER = (2.0, 1.5, 1.25)
"""Degree with which powers are compared, over the one that is enough: the first for which the water is resolved."""
SOLVED = 2e-4
"""Tolerance of the coefficients of the undeformed shape: all degrees share their errors."""
SOLVED_EACH = 2e-5
"""Tolerance of those about an equilibrium, of each degree by itself: with 2e-4 powers of degrees scattered by 3e-5."""
POINTS, MOST_POINTS = 2, 512
"""Points of the wet meridian over the highest degree, fewer of which never reach these tolerances, and at most."""
MOST_FREQUENCIES = 128
"""Frequencies of a sea; seas of more components are summed at so many."""
SAMPLED = 0.01
"""Relative error of a change with the degree by so few frequencies: 6e-3 with 24, 3e-4 with 40 [-]."""

TAKE_OFFS = ("fixed", "best_damper", "best_spring_damper", "best_damper_all_seas", "matched")
"""Control levels: the given damper, or the optimal one; the optimal damper of each design in each sea; the optimal
damper and spring; one damper for all seas; any force."""
OF_MATRICES = ("fixed", "best_damper", "best_diagonal", "best_damper_all_seas")
"""The same of a damper matrix at several ports, or spread over the shell; the optimal damper at each port alone."""
KEPT, OUTLINE = 12, 91
"""Shapes whose coefficients are kept for further members of a campaign, and points by which a shape is known."""
JUDGED = 2
"""Number of take-offs, the first ones, whose powers are to be within the tolerance."""
SHELL_MODE = re.compile(r"[A-Za-z]+(\d+)([cs]\d+)?")
"""Label of a shell mode: degree; azimuthal order, if it has one."""


class Sampled(NamedTuple):
    """Seas at common frequencies, in the directions they go to."""

    omega: FloatArray  # (omega,) [rad/s]
    directions: FloatArray  # (direction,) [degrees]
    squares: FloatArray  # squared amplitudes (sea, direction, omega) [m^2]


def directed(wave: Wave, sea: Sea) -> Sea:
    """Return a sea with the direction each of its components goes to."""
    return sea if sea.heading is not None else replace(sea, heading=np.full(len(sea.omega), float(heading(wave))))


def sampled(seas: Sequence[Sea]) -> Sampled:
    """Return seas at as few frequencies as the change of their powers with the degree needs.

    A sea without directions goes to 0.
    """
    grids = []
    for one in seas:
        energy = np.cumsum(np.abs(one.amplitude) ** 2)
        inside = one.omega[(energy > 1e-4 * energy[-1]) & (energy < (1 - 1e-4) * energy[-1])]
        few = len(one.omega) <= MOST_FREQUENCIES or len(inside) < 2
        grids.append(one.omega if few else np.linspace(inside[0], inside[-1], MOST_FREQUENCIES))
    omega = np.unique(np.round(np.concatenate(grids), 9))
    going = [np.zeros(len(one.omega)) if one.heading is None else one.heading for one in seas]
    directions = np.unique(np.concatenate(going))
    squares = np.zeros((len(seas), len(directions), len(omega)))
    for row, one, towards, grid in zip(squares, seas, going, grids, strict=True):
        at = np.searchsorted(omega, np.round(grid, 9))
        nearest = at[np.abs(one.omega[:, None] - grid).argmin(axis=1)]
        np.add.at(row, (np.searchsorted(directions, towards), nearest), np.abs(one.amplitude) ** 2)
    return Sampled(omega, directions, squares)


@dataclass(frozen=True)
class _Around:
    """A shape in water, by its outline: those of a campaign's members are the same while only take-offs vary."""

    outline: bytes
    water: Water
    order: int
    moved: tuple[Displacement, ...]
    omega: tuple[float, ...]  # [rad/s]
    tolerance: float
    shape: DeformedShell = field(compare=False)

    @classmethod
    def of(
        cls,
        shape: DeformedShell,
        water: Water,
        order: int,
        moved: tuple[Displacement, ...],
        omega: tuple[float, ...],
        tolerance: float,
    ) -> "_Around":
        """Return a shape with what is asked of the water around it."""
        at = shape.curve(np.linspace(0.0, np.pi, OUTLINE)[1:-1])
        return cls(np.array([at.x, at.z]).tobytes(), water, order, moved, omega, tolerance, shape)


@lru_cache(maxsize=2)
def _geometries(outline: bytes, order: int) -> dict[int, Geometry]:
    """The wet meridian of a shape by nodes, which all displacements of it share."""
    return {}


@lru_cache(maxsize=KEPT)
def _solved_around(one: _Around) -> ShapeWater:
    """Coefficients of displacements of one azimuthal order around a shape; those of the last shapes are kept."""
    water, omega = one.water, list(one.omega)
    nodes = min(fewest_nodes(one.moved, POINTS), MOST_POINTS)
    known = _geometries(one.outline, one.order)
    problem = SpectralProblem(one.shape, one.moved, water.density, water.gravity, nodes, water.depth, known)
    problem, _ = resolved(problem, [omega[0], omega[-1]], one.tolerance, MOST_POINTS)
    found = with_excitation(on_grid(problem.solve, omega, one.tolerance, incident_wave(problem)).coefficients)
    if one.order:
        found = with_haskind_damping(found, one.order, water.depth, water.density, water.gravity)
    added_mass, damping = (found[name].values for name in ("added_mass", "radiation_damping"))
    for each in (*added_mass, *damping):  # in place: of many degrees both take hundreds of megabytes
        each[:] = (each + each.T) / 2
    excitation = np.asarray(found.excitation_force.values[:, 0])
    return ShapeWater(one.moved, np.array(omega), Coefficients(added_mass, damping, excitation))


@dataclass(frozen=True, eq=False)
class ModeConvergence:
    """Mean powers of the designs of a study in seas, by the degree of the full basis.

    Powers have the dimensions (design, sea, take-off) [W], take-offs as of `take_offs`.
    """

    study: Study
    seas: Sequence[Sea]
    families: Sequence[int] | None = None  # one sea of each, by index, for the damper for all seas; else every sea
    judged: bool = False  # only the take-offs whose powers are judged
    wet: bool = False  # whether shapes beside loaded rings move water (`vsb.study.resolution.wets_rings`)
    _known: dict[int, FloatArray] = field(default_factory=dict, repr=False)

    @cached_property
    def _motion(self) -> Motion:
        return motion_of_port(self.study)

    @cached_property
    def _sampled(self) -> Sampled:
        """The seas; what only heaves answers waves of all directions alike."""
        if self._motion == "heave":
            return sampled([replace(one, heading=None) for one in self.seas])
        return sampled(self.seas)

    def _with(self, modes: Modes) -> Study:
        """The study with another basis, in the directions its port follows."""
        order = self.study.modes.order if isinstance(self.study.pto.port, BetweenPort | DofPort) else 1
        modes = modes.model_copy(update={"order": order})
        return self.study.model_copy(update={"modes": modes, "motion": self._motion})

    def _solved(
        self,
        shape: DeformedShell,
        highest: int,
        tolerance: float = SOLVED,
        *,
        meridional: bool = True,
        loads: Sequence[Displacement] = (),
    ) -> ShapeWater:
        """Coefficients of displacements of a shape to a degree, at the frequencies of the seas.

        Those along the meridian move water around other shapes than spheres alone.
        """
        along = [Displacement("meridional", n) for n in range(1, highest + 1)] if meridional else []
        radial = [Displacement("radial", n) for n in range(highest + 1)]
        first = self._of_order(shape, 0, [*radial, *along, *loads], tolerance)
        if self._motion == "heave":
            return first
        orders = range(1, self._with(self.study.modes).modes.order + 1)
        others = (
            self._of_order(shape, m, [Displacement("radial", n, m) for n in range(m, highest + 1)], tolerance)
            for m in orders
        )
        return replace(first, orders=tuple(others))

    def _of_order(
        self, shape: DeformedShell, order: int, moved: Iterable[Displacement], tolerance: float
    ) -> ShapeWater:
        """Coefficients of displacements of one azimuthal order."""
        omega = tuple(self._sampled.omega.tolist())
        return _solved_around(_Around.of(shape, self.study.water, order, tuple(moved), omega, tolerance))

    def powers(self, modes: Modes, among: int = 0) -> FloatArray:
        """Return mean powers with a basis, shape (design, sea, take-off) [W].

        Parameters
        ----------
        among : int
            Degree to which the water is solved, if higher: bases that are compared are to share its errors. About an
            equilibrium each has its own shape.
        """
        study = self._with(modes)
        reference = reference_shell(study)
        highest = max(modes.max_degree, 0 if study.at_equilibrium else among)
        water = self._around(reference.shape, highest, load_displacements(study, reference) if self.wet else ())
        if self.wet:
            water = replace(water, clamps=clamps(study))
        parts = water.parts(len(with_rings(study, reference, wet=water.clamps).basis.labels))
        squares = self._sampled.squares
        squares = np.concatenate([squares[:, :, part].reshape(len(squares), -1) for part in parts], axis=1)
        known = f"{buoy_key(study)} {self._sampled.directions.tolist()}"
        ports = water.kept(known, lambda: joined([self._ports(study, reference, water.at(part)) for part in parts]))
        return powers_of_ports(ports, study.pto, squares, self.families, judged=self.judged)

    @cached_property
    def enough(self) -> int:
        """Degree of the full basis that is enough for the tolerance, or the higher one of the study or of its port."""
        modes, port = self.study.modes, self.study.pto.port
        given = modes.degree or 0 if modes.basis == "full" else 0
        moved = [SHELL_MODE.fullmatch(name) for name in port.dofs] if isinstance(port, DofPort) else []
        return max(given, degree_needed(self.study, wet=self.wet), *(int(mode[1]) for mode in moved if mode))

    @cached_property
    def finer(self) -> int:
        """Degree with which powers are compared; `enough` itself where the water is resolved no further."""
        for factor in FINER:
            degree = math.ceil(factor * self.enough)
            known = degree if self.study.at_equilibrium else 1  # modes that the shape at rest depends on
            try:
                self._around(reference_shell(self._with(full(known))).shape, degree)
            except ConvergenceError:
                continue
            return degree
        return self.enough

    @cached_property
    def compared(self) -> list[FloatArray]:
        """Powers with the full basis of enough degrees, of some more, and of most; else of half as many to enough.

        About an equilibrium, where each degree has its own shape and water, of the first and the last alone.
        """
        few = self.enough if self.finer > self.enough else self.enough // 2
        between = [] if self.study.at_equilibrium else [round(math.sqrt(few * self.finer))]
        return [self.powers_of_degree(degree) for degree in (few, *between, self.finer)]

    def powers_of_degree(self, degree: int) -> FloatArray:
        """Return mean powers with the full basis to a degree, shape (design, sea, take-off) [W]."""
        if degree not in self._known:
            self._known[degree] = self.powers(full(degree), 0 if self.study.at_equilibrium else self.finer)
        return self._known[degree]

    def _around(self, shape: DeformedShell, degree: int, loads: Sequence[Displacement] = ()) -> ShapeWater:
        """Coefficients of the displacements to a degree around a shape at rest, and of those under loads at rings."""
        deformed = self.study.at_equilibrium
        meridional = deformed or self.study.device.shape is not None
        return self._solved(
            shape, max(1, degree), SOLVED_EACH if deformed else SOLVED, meridional=meridional, loads=loads
        )

    def _ports(self, study: Study, reference: ReferenceShell, water: ShapeWater) -> Mapping[str, Port | Ports]:
        """Ports of the designs, in waves of one direction after the other.

        By reciprocity, D being symmetric, V0 = -i w (D^-1 b).X, so that directions need no further solution.
        """
        buoy, omega, directions = buoy_at(study, reference, water), water.omega, self._sampled.directions
        if study.pto.several:
            return buoy.several_ports()
        if self._motion != "free" and not directions.any():
            return buoy.ports()
        reference, found = with_rings(study, reference, wet=water.clamps), dict[str, Port | Ports]()
        families = order_bases(study, reference.basis)
        orders = np.repeat(
            [0, *(each.signed for each in families)],
            [len(reference.basis.labels), *(len(each.labels) for each in families)],
        )
        force = buoy.equation.water.excitation
        shares = np.array([heading_shares(orders, np.deg2rad(one)) for one in directions])
        for design, one in buoy.in_waves().items():
            velocity = -1j * omega * (shares @ (one.moved[1] * force).T)
            admittance = np.tile(one.port.admittance, len(directions))
            found[design] = Port(np.tile(omega, len(directions)), admittance, velocity.ravel(), one.port.compliance)
        return found


def joined(parts: Sequence[Mapping[str, Port | Ports]]) -> Mapping[str, Port | Ports]:
    """Return the ports of designs at some frequencies and at others as one."""
    found = {}
    for design, port in parts[0].items():
        omega, admittance, velocity = (
            np.concatenate([getattr(part[design], name) for part in parts])
            for name in ("omega", "admittance", "velocity")
        )
        found[design] = replace(port, omega=omega, admittance=admittance, velocity=velocity)
    return found


def full(degree: int) -> Modes:
    """Return the full basis to a degree, also to a higher one than studies may have."""
    return Modes(basis="full", degree=0).model_copy(update={"degree": degree})


def one_of_each_family(waves: Sequence[Wave]) -> list[int]:
    """Return the first of each sea's realisations, by index."""
    names = [wave.family for wave in waves]
    return [names.index(name) for name in dict.fromkeys(names)]


def take_offs(pto: Pto) -> tuple[str, ...]:
    """Return the control levels whose powers are computed, the given damper and the optimal one first."""
    return OF_MATRICES if pto.several else TAKE_OFFS


def powers_of_ports(
    ports: Mapping[str, Any],
    pto: Pto,
    squares: FloatArray,
    families: Sequence[int] | None = None,
    *,
    judged: bool = False,
) -> FloatArray:
    """Return mean powers of designs in seas at every level of `take_offs`, shape (design, sea, take-off) [W].

    Parameters
    ----------
    ports : mapping design -> Port or Ports
        The latter of a damper matrix.
    squares : ndarray, shape (sea, omega) [m^2]
        Squared amplitudes.
    families : sequence of int, optional
        Seas whose plain sum the damper for all seas maximises; by default all.
    judged : bool
        Only the first levels, whose powers are judged.
    """
    together = squares[list(families or range(len(squares)))].sum(axis=0)
    found = [
        _of_matrices(port, pto, design, squares, together)[: JUDGED if judged else None]
        if pto.several
        else _of_dampers(port, pto, design, squares, together, judged=judged)
        for design, port in ports.items()
    ]
    return np.asarray(found).swapaxes(1, 2)


def _of_dampers(
    port: Port, pto: Pto, design: str, squares: FloatArray, together: FloatArray, *, judged: bool
) -> list[FloatArray]:
    """Powers of one design with a damper and a spring, at the levels `TAKE_OFFS`, each of shape (sea,) [W]."""
    optimal = best_dampers(port, squares, pto.stiffness, pto.efficiency)
    given, stiffness = pto.damper(design), np.full(len(squares), pto.stiffness)
    fixed = optimal.power
    if given is not None:
        fixed = mean_power(port, squares, np.full(len(squares), given), stiffness, pto.efficiency)
    if judged:
        return [fixed, optimal.power]
    sprung = best_pairs(port, squares, optimal, pto.efficiency).power
    one = float(best_dampers(port, together[None], pto.stiffness, pto.efficiency).damping[0])
    for_all = mean_power(port, squares, np.full(len(squares), one), stiffness, pto.efficiency)
    return [fixed, optimal.power, sprung, for_all, squares @ port.matched_power]


def _of_matrices(ports: Ports, pto: Pto, design: str, squares: FloatArray, together: FloatArray) -> list[FloatArray]:
    """Powers of one design with a damper matrix, at the levels `OF_MATRICES`, each of shape (sea,) [W]."""
    kind, given = matrix_kind(pto), given_matrix(pto, design, ports.velocity.shape[1])
    optimal = np.array([best_matrix(ports, sea, kind).power for sea in squares])
    diagonal = optimal
    if kind == "full":
        diagonal = np.array([best_matrix(ports, sea, "diagonal").power for sea in squares])
    for_all = optimal
    if len(squares) > 1:
        for_all = squares @ ports.power(best_matrix(ports, together, kind).damping)
    fixed = optimal if given is None else squares @ ports.power(given)
    return [fixed, optimal, diagonal, for_all]


def motion_of_port(study: Study) -> Motion:
    """Return in which directions a buoy must move for the power of its port to be known, as few as may be.

    Azimuthal orders couple through the mooring alone, and ports of heave, of rings or of strain of the shell move with
    order 0.
    """
    port = study.pto.port
    if study.motion == "heave":
        return "heave"
    axisymmetric = port in ("heave", "volume") or isinstance(port, ShellPort | StrainPort)
    out_of_plane = _couples(study, IN_PLANE)
    if isinstance(port, DofPort):
        modes = {name: SHELL_MODE.fullmatch(name) for name in port.dofs}
        axisymmetric = all(mode[2] is None if mode else name == "Heave" for name, mode in modes.items())
        out_of_plane |= any(goes_with_sine(name) or name in ("Sway", "Roll", "Yaw") for name in modes)
    if axisymmetric and not _couples(study, (RIGID.index("heave"),)):
        return "heave"
    return "free" if out_of_plane else "planar"


def _couples(study: Study, those: Sequence[int]) -> bool:
    """Whether the mooring couples some rigid motions with others."""
    rows = study.mooring or ()
    return any(entry for i in those for j, entry in enumerate(rows[i] if rows else ()) if j not in those)


def mean_sea(climate: Climate, highest: float = np.inf) -> Sea:
    """Return the sea of the mean spectrum of a year, to a frequency [rad/s]."""
    inside = (climate.omega <= highest) & (climate.mean_density > 0)
    variance = climate.mean_density * np.diff(climate.edges)
    return Sea(climate.omega[inside], np.sqrt(2 * variance[inside]).astype(complex))


# what all further shell modes may change ----------------------------------------------------------------------------

# From numbers with a basis, and with up to about twice as many degrees.

SAFETY = 2.0
"""At a ring of the shell errors fall unevenly: over what would be left if they did not [-]."""
RESOLVED = 2.0
"""Degree that resolves what bends about a loaded ring, over that at which bending is as stiff as the membrane [-]."""


def by_all_modes(
    before: FloatArray, finer: Sequence[FloatArray], reach: FloatArray | float = 1.0, least: FloatArray | float = 0.0
) -> FloatArray:
    """Return the range (..., end) about zero of what all modes change: to the last finer number, and as much beyond.

    Parameters
    ----------
    before : ndarray
        Numbers of which the change is asked.
    finer : sequence of ndarray
        The same with ascending degrees, to about twice the first of them.
    reach : ndarray or float
        What degrees beyond the last change at most, in terms of the span of these; 1 where errors fall like 1/degree.
    least : ndarray or float
        What they change at least, whatever the span: it may be small by chance.
    """
    change = finer[-1] - before
    missed = np.maximum(reach * np.ptp(finer, axis=0), least)
    return np.stack([np.minimum(change, 0.0) - missed, np.maximum(change, 0.0) + missed], axis=-1)


def reach_of_modes(study: Study, design: str, degree: int) -> float:
    """Return what degrees beyond one may change, in terms of the change from half of it, where modes stand alone [-].

    Errors fall like 1/degree or faster, but where a load acts at a ring of the shell. There each degree yields about as
    much as the one before up to that at which bending is as stiff as the membrane.
    """
    if not loaded_at_ring(study, design):
        return 1.0
    return SAFETY * max(1.0, 2 * RESOLVED * bending_degree(study) / degree - 2)
