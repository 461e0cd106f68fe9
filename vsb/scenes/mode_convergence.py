"""Convergence of mean powers in the shell modes: how far a basis is from a shell with all its modes.

Bending makes a shell of thickness h answer over lengths sqrt(r h), so Legendre degrees to about 3 sqrt(r/h) take part,
more beside a clamp. Powers are computed with the full basis of ascending degrees of a fixed nested list, at the
frequencies of the seas alone, until what further degrees may change is small.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from vsb.errors import ConvergenceError
from vsb.hydro.database import Coefficients, with_excitation
from vsb.hydro.dofs import Displacement
from vsb.hydro.orders import heading_shares, with_haskind_damping
from vsb.hydro.spectral.solver import FEWEST_NODES, SpectralProblem, incident_wave, resolved
from vsb.hydro.sweep import on_grid
from vsb.motion.port import Port
from vsb.motion.tuning import best_dampers, best_pairs, mean_power
from vsb.scenes.floating_system import heading
from vsb.scenes.ports import ShapeWater, buoy_at
from vsb.scenes.rest import order_bases, reference_shell
from vsb.shell.deformed import DeformedShell, ReferenceShell
from vsb.study.directions import IN_PLANE, RIGID
from vsb.study.sections import DEGREES, Modes
from vsb.study.specs import AnyBuoy, BuoySystem, DegreeSpec
from vsb.study.study import RegularWave, StillWater, Wave
from vsb.study.take_off import BetweenPort, DofPort, Pto, ShellPort, StrainPort
from vsb.tools.arrays import FloatArray
from vsb.waves.climate import Climate
from vsb.waves.seas import Sea, expected, sea

SAFETY = 2.0
"""Of the last steps of the list, for what all further degrees may change where powers do not approach a limit yet."""
PROBED = (0.4, 0.7, 1.0, 1.3)
"""Frequencies of regular waves that stand for the seas of a study in still water, in sqrt(g/radius)."""
SOLVED = 2e-4
"""Largest tolerance of the coefficients: all degrees share their errors."""
MOST_FREQUENCIES = 128
"""Frequencies of a sea; seas of more components are summed at so many."""
SAMPLED = 0.01
"""Relative error of a change with the degree by so few frequencies: 6e-3 with 24, 3e-4 with 40 [-]."""

TAKE_OFFS = ("fixed", "best_damper", "best_spring_damper", "best_damper_all_seas", "matched")
"""Control levels: the given damper, or the optimal one; the optimal damper of each design in each sea; the optimal
damper and spring; one damper for all seas; any force."""
JUDGED = 2
"""Number of take-offs, the first ones, whose powers are to be within the tolerance."""


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


@dataclass(frozen=True, eq=False)
class ModeConvergence:
    """Mean powers of the designs of a study in seas, by the degree of the full basis.

    Powers have the dimensions (design, sea, take-off) [W], take-offs as `TAKE_OFFS`.
    """

    study: AnyBuoy
    seas: Sequence[Sea]
    families: Sequence[int] | None = None  # one sea of each, by index, for the damper for all seas; else every sea

    @cached_property
    def _motion(self) -> Literal["heave", "planar"]:
        found = motion_of_port(self.study)
        assert found is not None
        return found

    @cached_property
    def _sampled(self) -> Sampled:
        """The seas; what only heaves answers waves of all directions alike."""
        if self._motion == "heave":
            return sampled([replace(one, heading=None) for one in self.seas])
        return sampled(self.seas)

    @cached_property
    def _undeformed_water(self) -> ShapeWater:
        """Of the undeformed shell, whose displacements of all degrees are solved once.

        Around other shapes than spheres, and of orders m >= 1, as far as the points of the solver resolve them.
        """
        shape = reference_shell(self._with(Modes(basis="full", degree=1))).shape
        sphere = self.study.device.shape is None
        if sphere and self._motion == "heave":
            return self._solved(shape, DEGREES[-1], meridional=False)
        for highest in reversed(DEGREES[2 : -1 if sphere else -2]):
            try:
                return self._solved(shape, highest, meridional=not sphere)
            except ConvergenceError:
                continue
        return self._solved(shape, DEGREES[1], meridional=not sphere)

    def _with(self, modes: Modes) -> AnyBuoy:
        """The study with another basis, in the directions its port follows."""
        order = self.study.modes.order if isinstance(self.study.pto.port, BetweenPort) else 1
        modes = modes.model_copy(update={"order": order})
        return self.study.model_copy(update={"modes": modes, "motion": self._motion})

    def _solved(self, shape: DeformedShell, highest: int, *, meridional: bool = True) -> ShapeWater:
        """Coefficients of displacements of a shape to a degree, at the frequencies of the seas.

        Those along the meridian move water around other shapes than spheres alone.
        """
        along = [Displacement("meridional", n) for n in range(1, highest + 1)] if meridional else []
        first = self._of_order(shape, 0, [*(Displacement("radial", n) for n in range(highest + 1)), *along])
        if self._motion == "heave":
            return first
        orders = range(1, self._with(self.study.modes).modes.order + 1)
        others = (
            self._of_order(shape, m, [Displacement("radial", n, m) for n in range(m, highest + 1)]) for m in orders
        )
        return replace(first, orders=tuple(others))

    def _of_order(self, shape: DeformedShell, order: int, moved: Iterable[Displacement]) -> ShapeWater:
        """Coefficients of displacements of one azimuthal order."""
        water, omega, moved = self.study.water, self._sampled.omega.tolist(), tuple(moved)
        problem = SpectralProblem(shape, moved, water.density, water.gravity, FEWEST_NODES, depth=water.depth)
        problem, _ = resolved(problem, [omega[0], omega[-1]], SOLVED)
        found = with_excitation(on_grid(problem.solve, omega, SOLVED, incident_wave(problem)).coefficients)
        if order:
            found = with_haskind_damping(found, order, water.depth, water.density, water.gravity)
        matrices = (found[name].values for name in ("added_mass", "radiation_damping"))
        added_mass, damping = ((m + m.swapaxes(-1, -2)) / 2 for m in matrices)
        excitation = np.asarray(found.excitation_force.values[:, 0])
        return ShapeWater(moved, self._sampled.omega, Coefficients(added_mass, damping, excitation))

    def powers(self, modes: Modes) -> FloatArray:
        """Return mean powers with a basis, shape (design, sea, take-off) [W]."""
        study = self._with(modes)
        reference = reference_shell(study)
        if study.at_equilibrium or modes.max_degree > self._degrees[-1]:
            water = self._solved(reference.shape, max(1, modes.max_degree))
        else:
            water = self._undeformed_water
        ports, squares = self._ports(study, reference, water), self._sampled.squares
        return powers_of_ports(ports, study.pto, squares.reshape(len(squares), -1), self.families)

    def _ports(self, study: AnyBuoy, reference: ReferenceShell, water: ShapeWater) -> dict[str, Port]:
        """Ports of the designs, in waves of one direction after the other.

        By reciprocity, D being symmetric, V0 = -i w (D^-1 b).X, so that directions need no further solution.
        """
        buoy = buoy_at(study, reference, water)
        omega, directions, _ = self._sampled
        if not directions.any():
            return buoy.ports()
        families, found = order_bases(study, reference.basis), {}
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
            if len(found) > 2 and self.worst(further(list(found.values()))) <= self.study.modes.tolerance / 2:
                break
        return found

    @property
    def _degrees(self) -> list[int]:
        """Degrees there are displacements of."""
        if self.study.at_equilibrium:
            return list(DEGREES)
        highest = max(moved.degree for moved in self._undeformed_water.displacements)
        return [degree for degree in DEGREES if degree <= highest]

    @cached_property
    def further(self) -> FloatArray:
        """What degrees beyond the highest tried may change, shape of the powers [W]."""
        return further(list(self.powers_by_degree.values()))

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
        return self.powers(Modes(basis="full", degree=DEGREES[0]))

    def worst(self, change: FloatArray) -> float:
        """Return the largest of changes of powers, relative to each power or to the reference design's [-]."""
        relative = np.abs(change) / np.where(self._size > 0, self._size, np.inf)
        return float(relative[..., :JUDGED].max(initial=0.0))

    @cached_property
    def degree(self) -> int:
        """Least degree of the list whose powers and gains are within the tolerance of those of all modes."""
        for degree, power in self.powers_by_degree.items():
            if self.worst(np.abs(self.converged - power) + self.further) <= self.study.modes.tolerance:
                return degree
        return max(self.powers_by_degree)


def powers_of_ports(
    ports: Mapping[str, Port], pto: Pto, squares: FloatArray, families: Sequence[int] | None = None
) -> FloatArray:
    """Return mean powers of designs in seas under every take-off of `TAKE_OFFS`, (design, sea, take-off) [W].

    Parameters
    ----------
    ports : mapping design -> Port
    pto : Pto
    squares : ndarray, shape (sea, omega) [m^2]
        Squared amplitudes.
    families : sequence of int, optional
        Seas whose plain sum the damper for all seas maximises; by default all.
    """
    together = squares[list(families or range(len(squares)))].sum(axis=0, keepdims=True)
    found = []
    for design, port in ports.items():
        optimal = best_dampers(port, squares, pto.stiffness, pto.efficiency)
        sprung = best_pairs(port, squares, optimal, pto.efficiency).power
        one = float(best_dampers(port, together, pto.stiffness, pto.efficiency).damping[0])
        given, stiffness = pto.damper(design), np.full(len(squares), pto.stiffness)
        for_all = mean_power(port, squares, np.full(len(squares), one), stiffness, pto.efficiency)
        fixed = optimal.power
        if given is not None:
            fixed = mean_power(port, squares, np.full(len(squares), given), stiffness, pto.efficiency)
        found.append([fixed, optimal.power, sprung, for_all, squares @ port.matched_power])
    return np.asarray(found).swapaxes(1, 2)


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


def converged_degree(spec: DegreeSpec, climate: Climate | None = None) -> int:
    """Return the least degree whose mean powers and gains are within `modes.tolerance` of those of all modes.

    Parameters
    ----------
    spec : DegreeSpec
        Of a port whose powers are not known by degree (`motion_of_port`), heave stands for it.
    climate : Climate, optional
        The seas of a year: its mean spectrum, from which its mean power follows, takes the place of the waves.
    """
    buoy = spec.buoy
    assert buoy is not None
    if not knows_port(buoy):
        pto = buoy.pto.model_copy(update={"port": "heave", "damping": None, "tuning": "each", "stiffness": 0.0})
        buoy = buoy.model_copy(update={"pto": pto, "motion": "heave"})
    return ModeConvergence(buoy, _seas(spec, buoy, climate)).degree


def motion_of_port(study: AnyBuoy) -> Literal["heave", "planar"] | None:
    """Return in which directions a buoy must move for the power of its port to be known; None where it is not known.

    Azimuthal orders couple through the mooring alone, and a port of heave or of rings of the shell moves with order 0.
    Not known of several ports, and where motions out of the plane of x and z, or combinations with shell modes, matter.
    """
    port, axisymmetric = study.pto.port, study.pto.port in ("heave", "volume")
    if study.pto.several:
        return None
    if study.motion == "heave":
        return "heave"
    if isinstance(port, DofPort):
        if not set(port.dofs) <= {RIGID[i].capitalize() for i in IN_PLANE}:
            return None
        axisymmetric = set(port.dofs) == {"Heave"}
    if _couples(study, IN_PLANE):
        return None
    axisymmetric |= isinstance(port, ShellPort | StrainPort)
    return "heave" if axisymmetric and not _couples(study, (RIGID.index("heave"),)) else "planar"


def _couples(study: AnyBuoy, those: Sequence[int]) -> bool:
    """Whether the mooring couples some rigid motions with others."""
    rows = study.mooring or ()
    return any(entry for i in those for j, entry in enumerate(rows[i] if rows else ()) if j not in those)


def knows_port(study: AnyBuoy) -> bool:
    """Return whether powers are known by degree of the shell modes."""
    return motion_of_port(study) is not None


def mean_sea(climate: Climate, highest: float = np.inf) -> Sea:
    """Return the sea of the mean spectrum of a year, to a frequency [rad/s]."""
    inside = (climate.omega <= highest) & (climate.mean_density > 0)
    variance = climate.mean_density * np.diff(climate.edges)
    return Sea(climate.omega[inside], np.sqrt(2 * variance[inside]).astype(complex))


def _seas(spec: DegreeSpec, buoy: BuoySystem, climate: Climate | None) -> tuple[Sea, ...]:
    """The seas powers are to converge in."""
    assert spec.band is not None
    highest = spec.band[1]
    if climate is not None:
        return (mean_sea(climate, highest),)
    waves = [wave for wave in spec.waves if not isinstance(wave, StillWater)]
    if not waves:
        unit = np.sqrt(spec.water.gravity / buoy.device.radius)
        periods = [2 * np.pi / min(part * unit, highest) for part in PROBED]
        return tuple(sea(RegularWave(kind="regular", amplitude=0.1, period=t), highest, 0.0) for t in periods)
    return tuple(directed(wave, sea(expected(wave), highest, spec.simulation.duration)) for wave in waves)
