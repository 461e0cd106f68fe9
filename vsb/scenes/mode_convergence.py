"""Convergence of mean powers in the shell modes: how far a basis is from a shell with all its modes.

Bending makes a shell of thickness h answer over lengths sqrt(r h), so Legendre degrees to about 3 sqrt(r/h) take part,
more beside a clamp. Powers are computed with the full basis of ascending degrees of a fixed nested list, at the
frequencies of the seas alone, until what further degrees may change is small. Where a load acts at a ring of a sphere
the static answer of all further degrees to it is part of what powers converge to (`vsb.scenes.ring_loads`).
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from vsb.errors import ConvergenceError
from vsb.hydro.database import Coefficients, with_excitation
from vsb.hydro.dofs import Displacement
from vsb.hydro.orders import heading_shares, with_haskind_damping
from vsb.hydro.spectral.solver import FEWEST_NODES, SpectralProblem, incident_wave, resolved
from vsb.hydro.sweep import on_grid
from vsb.motion.damper_matrix import Ports, best_matrix
from vsb.motion.port import Port
from vsb.motion.tuning import best_dampers, best_pairs, mean_power
from vsb.scenes.floating_system import heading
from vsb.scenes.ports import ShapeWater, buoy_at
from vsb.scenes.rest import loaded_at_ring, order_bases, reference_shell
from vsb.scenes.ring_loads import has_attachment_modes, with_rings
from vsb.scenes.take_off import given_matrix, matrix_kind
from vsb.shell.deformed import DeformedShell, ReferenceShell
from vsb.shell.orders import goes_with_sine
from vsb.shell.shell import Shell
from vsb.study.directions import IN_PLANE, RIGID, Motion
from vsb.study.sections import DEGREES, Modes, Water
from vsb.study.specs import AnyBuoy, BuoySystem, DegreeSpec
from vsb.study.take_off import BetweenPort, DofPort, Pto, ShellPort, StrainPort
from vsb.study.waves import IrregularSea, RegularWave, SeaOfFile, StillWater, Wave
from vsb.tools.arrays import FloatArray
from vsb.waves.climate import Climate
from vsb.waves.seas import Sea, expected, sea

SAFETY = 2.0
"""Of the last steps of the list, for what all further degrees may change where powers do not approach a limit yet."""
RESOLVED = 2.0
"""Degree that resolves what bends about a loaded ring, in terms of `bending_degree`."""
UNRESOLVED = 3.0
"""Of the last steps, where all degrees answer loads at rings but the modes do not resolve what bends about them."""
PROBED = (0.4, 0.7, 1.0, 1.3)
"""Frequencies of regular waves that stand for the seas of a study in still water, in sqrt(g/radius)."""
SOLVED = 2e-4
"""Tolerance of the coefficients of the undeformed shape: all degrees share their errors."""
SOLVED_EACH = 2e-5
"""Tolerance of those about an equilibrium, of each degree by itself: with 2e-4 powers of degrees scattered by 3e-5."""
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


@lru_cache(maxsize=KEPT)
def _solved_around(one: _Around) -> ShapeWater:
    """Coefficients of displacements of one azimuthal order around a shape; those of the last shapes are kept."""
    water, omega = one.water, list(one.omega)
    problem = SpectralProblem(one.shape, one.moved, water.density, water.gravity, FEWEST_NODES, depth=water.depth)
    problem, _ = resolved(problem, [omega[0], omega[-1]], one.tolerance)
    found = with_excitation(on_grid(problem.solve, omega, one.tolerance, incident_wave(problem)).coefficients)
    if one.order:
        found = with_haskind_damping(found, one.order, water.depth, water.density, water.gravity)
    matrices = (found[name].values for name in ("added_mass", "radiation_damping"))
    added_mass, damping = ((m + m.swapaxes(-1, -2)) / 2 for m in matrices)
    excitation = np.asarray(found.excitation_force.values[:, 0])
    return ShapeWater(one.moved, np.array(omega), Coefficients(added_mass, damping, excitation))


@dataclass(frozen=True, eq=False)
class ModeConvergence:
    """Mean powers of the designs of a study in seas, by the degree of the full basis.

    Powers have the dimensions (design, sea, take-off) [W], take-offs as of `take_offs`.
    """

    study: AnyBuoy
    seas: Sequence[Sea]
    families: Sequence[int] | None = None  # one sea of each, by index, for the damper for all seas; else every sea
    judged: bool = False  # only the take-offs whose powers are judged

    @cached_property
    def _motion(self) -> Motion:
        return motion_of_port(self.study)

    @cached_property
    def _sampled(self) -> Sampled:
        """The seas; what only heaves answers waves of all directions alike."""
        if self._motion == "heave":
            return sampled([replace(one, heading=None) for one in self.seas])
        return sampled(self.seas)

    @cached_property
    def _undeformed_water(self) -> ShapeWater:
        """Of the undeformed shell, whose displacements of all degrees are solved once.

        As far as the points of the solver resolve them: around spheres that heave mostly all, in shallow water fewer.
        """
        shape = reference_shell(self._with(Modes(basis="full", degree=1))).shape
        sphere = self.study.device.shape is None
        out_of_reach = 2 if not sphere else 1 if self._motion != "heave" else 0
        for highest in reversed(DEGREES[2 : len(DEGREES) - out_of_reach]):
            try:
                return self._solved(shape, highest, meridional=not sphere)
            except ConvergenceError:
                continue
        return self._solved(shape, DEGREES[1], meridional=not sphere)

    def _with(self, modes: Modes) -> AnyBuoy:
        """The study with another basis, in the directions its port follows."""
        order = self.study.modes.order if isinstance(self.study.pto.port, BetweenPort | DofPort) else 1
        modes = modes.model_copy(update={"order": order})
        return self.study.model_copy(update={"modes": modes, "motion": self._motion})

    def _solved(
        self, shape: DeformedShell, highest: int, tolerance: float = SOLVED, *, meridional: bool = True
    ) -> ShapeWater:
        """Coefficients of displacements of a shape to a degree, at the frequencies of the seas.

        Those along the meridian move water around other shapes than spheres alone.
        """
        along = [Displacement("meridional", n) for n in range(1, highest + 1)] if meridional else []
        first = self._of_order(shape, 0, [*(Displacement("radial", n) for n in range(highest + 1)), *along], tolerance)
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

    def powers(self, modes: Modes) -> FloatArray:
        """Return mean powers with a basis, shape (design, sea, take-off) [W]."""
        study = self._with(modes)
        reference = reference_shell(study)
        if study.at_equilibrium or modes.max_degree > self._degrees[-1]:
            water = self._solved(reference.shape, max(1, modes.max_degree), SOLVED_EACH)
        else:
            water = self._undeformed_water
        squares = self._sampled.squares
        squares = squares.reshape(len(squares), -1)
        ports = self._ports(study, reference, water)
        return powers_of_ports(ports, study.pto, squares, self.families, judged=self.judged)

    @property
    def completes(self) -> bool:
        """Whether all degrees answer loads at rings, whatever the degree of the modes."""
        return self._motion == "heave" and has_attachment_modes(self._with(Modes(basis="full", degree=1)))

    def _ports(self, study: AnyBuoy, reference: ReferenceShell, water: ShapeWater) -> Mapping[str, Port | Ports]:
        """Ports of the designs, in waves of one direction after the other.

        By reciprocity, D being symmetric, V0 = -i w (D^-1 b).X, so that directions need no further solution.
        """
        buoy = buoy_at(study, reference, water)
        omega, directions, _ = self._sampled
        if study.pto.several:
            return buoy.several_ports()
        if self._motion != "free" and not directions.any():
            return buoy.ports()
        reference, found = with_rings(study, reference), dict[str, Port | Ports]()
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

    @cached_property
    def powers_by_degree(self) -> Mapping[int, FloatArray]:
        """Powers by degree of the full basis, up to where further degrees change less than half the tolerance.

        Or to where the water around the shell can be solved: of shapes other than spheres that is less than the list.
        """
        found: dict[int, FloatArray] = {}
        for degree in self._degrees:
            try:
                found[degree] = self.powers(Modes(basis="full", degree=degree)) if found else self._first
            except ConvergenceError:  # the water around a deformed shell is not resolved to so high degrees
                if len(found) < 2:
                    raise
                break
            enough = self.study.modes.tolerance / 2
            if len(found) > 2 and self.worst(beyond(self.study, found, complete=self.completes)) <= enough:
                break
        return found

    @cached_property
    def _degrees(self) -> list[int]:
        """Degrees there are displacements of, from that of the modes its port is of."""
        port = self.study.pto.port
        modes = [SHELL_MODE.fullmatch(name) for name in port.dofs] if isinstance(port, DofPort) else []
        least = max([DEGREES[0], *(int(mode[1]) for mode in modes if mode)])
        highest = DEGREES[-1]
        if not self.study.at_equilibrium:
            highest = max(moved.degree for moved in self._undeformed_water.displacements)
        return [degree for degree in DEGREES if least <= degree <= highest] or [least]

    @cached_property
    def further(self) -> FloatArray:
        """What degrees beyond the highest tried may change, shape of the powers [W]."""
        return beyond(self.study, self.powers_by_degree, complete=self.completes)

    @property
    def converged(self) -> FloatArray:
        """Powers with the highest degree tried, shape (design, sea, take-off) [W]."""
        return self.powers_by_degree[max(self.powers_by_degree)]

    @cached_property
    def _size(self) -> FloatArray:
        """Power that changes are relative to: of each design, or of the reference design where that is smaller [W].

        A rigid reference design absorbs nothing at a port within the shell: there is no gain then.
        """
        power, reference = self._first, self.study.reference_design
        if reference is None:
            return power
        base = power[[list(self.study.designs).index(reference)]]
        return np.where(base > 0, np.minimum(power, base), power)

    @cached_property
    def _first(self) -> FloatArray:
        """Powers with the lowest degree [W]."""
        return self.powers(Modes(basis="full", degree=self._degrees[0]))

    def worst(self, change: FloatArray) -> float:
        """Return the largest of changes of powers, relative to each power or to the reference design's [-]."""
        relative = np.abs(change) / np.where(self._size > 0, self._size, np.inf)
        return float(relative[..., :JUDGED].max(initial=0.0))

    @cached_property
    def degree(self) -> int:
        """Least degree whose powers and gains are within the tolerance of those of all modes, or the highest tried."""
        return next((degree for degree in self.powers_by_degree if self._meets(degree)), max(self.powers_by_degree))

    @property
    def met(self) -> bool:
        """Whether the tolerance is met with that degree."""
        return self._meets(self.degree)

    def _meets(self, degree: int) -> bool:
        return self._tolerable(np.abs(self.converged - self.powers_by_degree[degree]) + self.further)

    def _tolerable(self, missing: FloatArray) -> bool:
        """Whether what may be missing from powers is within the tolerance."""
        return self.worst(missing) <= self.study.modes.tolerance


def one_of_each_family(waves: Sequence[Wave]) -> list[int]:
    """Return the first of each sea's realisations, by index."""
    names = [wave.family if isinstance(wave, IrregularSea) else wave.label for wave in waves]
    return [names.index(name) for name in dict.fromkeys(names)]


def take_offs(pto: Pto) -> tuple[str, ...]:
    """Return the control levels whose powers are computed, the given damper and the optimal one first."""
    return OF_MATRICES if pto.several else TAKE_OFFS


def powers_of_ports(
    ports: Mapping[str, Port | Ports],
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
        if isinstance(port, Ports)
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


def as_lists(powers: Mapping[int, FloatArray], study: AnyBuoy) -> dict[str, dict[str, list[Any]]]:
    """Return powers by degree and design as lists, for JSON; see `from_lists`."""
    return {str(degree): dict(zip(study.designs, one.tolist(), strict=True)) for degree, one in powers.items()}


def from_lists(stored: Mapping[str, Mapping[str, list[Any]]], designs: Iterable[str]) -> dict[int, FloatArray]:
    """Return powers by degree from lists, (sea, take-off) of each design, of designs in order."""
    names = list(designs)
    return {int(degree): np.array([by_design[name] for name in names]) for degree, by_design in stored.items()}


def beyond(study: AnyBuoy, powers: Mapping[int, FloatArray], *, complete: bool = False) -> FloatArray:
    """Return what degrees beyond the last may change, of each design, shape of the powers.

    Parameters
    ----------
    powers : mapping degree -> ndarray, shape (design, ...)
        Powers or gains with two or more ascending degrees of the full basis.
    complete : bool
        Whether all degrees answer loads at rings (`vsb.scenes.ring_loads`).
    """
    degrees, values = list(powers), list(powers.values())
    change = further(values)
    for row, design in enumerate(study.designs):
        bending = bending_degree(study, design)
        if bending is None:
            continue
        if not complete or len(degrees) == 2:
            change[row] = further_about_rings([one[row] for one in values], degrees, bending)
        elif degrees[-1] < RESOLVED * bending:
            change[row] *= UNRESOLVED  # steps may be small by chance
    return change


def further(powers: Sequence[FloatArray]) -> FloatArray:
    """Return what degrees beyond the last may change, shape of the powers [W]: the span of the last three powers.

    That holds of errors that fall like 1/degree or faster, because two steps of `DEGREES` double the degree. One step
    would not do: before bending is resolved it may be small by chance. Steps of opposite signs have a small span, and
    count at least `SAFETY` times the last; where the last step is larger than the one before, errors do not fall yet:
    `SAFETY` times both.

    Parameters
    ----------
    powers : sequence of ndarray [W]
        With two or more ascending degrees of `DEGREES`.
    """
    step = np.abs(powers[-1] - powers[-2])
    if len(powers) == 2:
        return SAFETY * step
    previous = np.abs(powers[-2] - powers[-3])
    falling = np.maximum(np.ptp(powers[-3:], axis=0), SAFETY * step)
    return np.where(step > previous, SAFETY * (step + previous), falling)


def further_about_rings(powers: Sequence[FloatArray], degrees: Sequence[int], bending: float) -> FloatArray:
    """Return what degrees beyond the last may change where a load acts at a ring of the shell, shape of the powers [W].

    Below `bending_degree` each degree yields about as much to such a load as the one before, more or less with its
    amplitude at the ring: the steepest change per degree seen counts up to `RESOLVED` times that degree. Beyond it
    errors fall like 1/degree, unevenly. `SAFETY` times the larger of that and of both last steps.

    Parameters
    ----------
    powers : sequence of ndarray [W]
        With two or more ascending degrees of `DEGREES`.
    degrees : sequence of int
    bending : float
        See `bending_degree`.
    """
    steps, widths = np.abs(np.diff(powers[-3:], axis=0)), np.diff(degrees[-3:])
    per_degree = (steps.T / widths).T.max(axis=0)
    missing = max(RESOLVED * bending - degrees[-1], 0.0)
    return np.asarray(SAFETY * np.maximum(steps.sum(axis=0), missing * per_degree))


def bending_degree(study: AnyBuoy, design: str) -> float | None:
    """Return the degree at which the shell is as stiff by bending as by its membrane; None if no load acts at a ring.

    D n^4/r^4 = E h/r^2 with D = E h^3/(12 (1 - nu^2)), r the largest radius or half the height. See `loaded_at_ring`.
    """
    if not loaded_at_ring(study, design):
        return None
    shell = Shell.of(study.device)
    return float((12 * (1 - shell.poisson_ratio**2)) ** 0.25 * np.sqrt(shell.reach / shell.thickness))


def mode_convergence(spec: DegreeSpec, climate: Climate | None = None) -> ModeConvergence:
    """Return the search for the least degree whose powers and gains are within `modes.tolerance` of all modes.

    Parameters
    ----------
    climate : Climate, optional
        The seas of a year: its mean spectrum, from which its mean power follows, takes the place of the waves.
    """
    buoy = spec.buoy
    assert buoy is not None
    return ModeConvergence(buoy, *_seas(spec, buoy, climate))


def motion_of_port(study: AnyBuoy) -> Motion:
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


def _couples(study: AnyBuoy, those: Sequence[int]) -> bool:
    """Whether the mooring couples some rigid motions with others."""
    rows = study.mooring or ()
    return any(entry for i in those for j, entry in enumerate(rows[i] if rows else ()) if j not in those)


def mean_sea(climate: Climate, highest: float = np.inf) -> Sea:
    """Return the sea of the mean spectrum of a year, to a frequency [rad/s]."""
    inside = (climate.omega <= highest) & (climate.mean_density > 0)
    variance = climate.mean_density * np.diff(climate.edges)
    return Sea(climate.omega[inside], np.sqrt(2 * variance[inside]).astype(complex))


def _seas(spec: DegreeSpec, buoy: BuoySystem, climate: Climate | None) -> tuple[tuple[Sea, ...], list[int] | None]:
    """The seas powers are to converge in, and one of each family."""
    assert spec.band is not None
    highest = spec.band[1]
    if climate is not None:
        return (mean_sea(climate, highest),), None
    waves = [wave for wave in spec.waves if not isinstance(wave, StillWater)]
    if not waves:
        unit = np.sqrt(spec.water.gravity / buoy.device.radius)
        periods = [2 * np.pi / min(part * unit, highest) for part in PROBED]
        return tuple(sea(RegularWave(kind="regular", amplitude=0.1, period=t), highest, 0.0) for t in periods), None
    seas = [sea(expected(wave), highest, spec.simulation.duration) for wave in waves]
    lowest = [spec.omega_min - 1e-9 if isinstance(wave, SeaOfFile) else 0.0 for wave in waves]
    kept = [one.part(one.omega >= low) for one, low in zip(seas, lowest, strict=True)]
    return tuple(map(directed, waves, kept)), one_of_each_family(waves)
