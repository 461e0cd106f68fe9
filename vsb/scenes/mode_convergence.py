"""Convergence of mean powers in the shell modes: how far a basis is from a shell with all its modes.

Bending makes a shell of thickness h answer over lengths sqrt(r h), so Legendre degrees to about 3 sqrt(r/h) take part,
more beside a clamp. Powers are computed with the full basis of ascending degrees of a fixed nested list, at the
frequencies of the seas alone, until what further degrees may change is small.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vsb.errors import ConvergenceError
from vsb.hydro.database import Coefficients, with_excitation
from vsb.hydro.dofs import Displacement
from vsb.hydro.spectral.solver import FEWEST_NODES, SpectralProblem, incident_wave, resolved
from vsb.hydro.sweep import on_grid
from vsb.motion.port import Port
from vsb.motion.tuning import best_dampers, best_pairs, mean_power
from vsb.scenes.ports import ShapeWater, designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import DeformedShell
from vsb.study.sections import DEGREES, Modes
from vsb.study.specs import AnyBuoy, BuoySystem, DegreeSpec
from vsb.study.study import RegularWave, StillWater, Study
from vsb.study.take_off import Pto, ShellPort, StrainPort
from vsb.tools.arrays import FloatArray
from vsb.waves.climate import Climate
from vsb.waves.seas import Sea, expected, sea

SAFETY = 2.0
"""What all further degrees may change, over the last step of the list.

Steps of errors that fall like a power p of the degree shrink by 0.7^p, so that all further ones together are
1/(0.7^-p - 1) of the last: below 2 for p > 1.1; errors of resolved bending layers fall faster than any power.
"""
PROBED = (0.4, 0.7, 1.0, 1.3)
"""Frequencies of regular waves that stand for the seas of a study in still water, in sqrt(g/radius)."""
SOLVED = 2e-4
"""Largest tolerance of the coefficients: all degrees share their errors."""
MOST_FREQUENCIES = 128
"""Frequencies of a sea; seas of more components are summed at so many."""
SAMPLED = 0.01
"""Relative error of a change with the degree by so few frequencies: 6e-3 with 24, 3e-4 with 40 [-]."""

TAKE_OFFS = ("given", "optimal", "optimal_spring")
"""The given damper, if there is one; the optimal damper of each design in each sea; the optimal damper and spring."""
JUDGED = 2
"""Number of take-offs, the first ones, whose powers are to be within the tolerance."""


class Sampled(NamedTuple):
    """Seas at common frequencies."""

    omega: FloatArray  # (omega,) [rad/s]
    squares: FloatArray  # squared amplitudes (sea, omega) [m^2]


def sampled(seas: Sequence[Sea]) -> Sampled:
    """Return seas at as few frequencies as the change of their powers with the degree needs."""
    grids = []
    for one in seas:
        energy = np.cumsum(np.abs(one.amplitude) ** 2)
        inside = one.omega[(energy > 1e-4 * energy[-1]) & (energy < (1 - 1e-4) * energy[-1])]
        few = len(one.omega) <= MOST_FREQUENCIES or len(inside) < 2
        grids.append(one.omega if few else np.linspace(inside[0], inside[-1], MOST_FREQUENCIES))
    omega = np.unique(np.round(np.concatenate(grids), 9))
    squares = np.zeros((len(seas), len(omega)))
    for row, one, grid in zip(squares, seas, grids, strict=True):
        at = np.searchsorted(omega, np.round(grid, 9))
        nearest = at[np.abs(one.omega[:, None] - grid).argmin(axis=1)]
        np.add.at(row, nearest, np.abs(one.amplitude) ** 2)
    return Sampled(omega, squares)


@dataclass(frozen=True, eq=False)
class ModeConvergence:
    """Mean powers of the designs of a study in seas, by the degree of the full basis.

    Powers have the dimensions (design, sea, take-off) [W], take-offs as `TAKE_OFFS`.
    """

    study: AnyBuoy
    seas: Sequence[Sea]

    @cached_property
    def _sampled(self) -> Sampled:
        return sampled(self.seas)

    @cached_property
    def _undeformed_water(self) -> ShapeWater:
        """Of the undeformed shell, whose displacements of all degrees are solved once.

        Around other shapes than spheres they are solved as far as the points of the solver resolve them.
        """
        shape = reference_shell(self._with(Modes(basis="full", degree=1))).shape
        if self.study.device.shape is None:
            return self._solved(shape, _displacements(DEGREES[-1], meridional=False))
        for highest in reversed(DEGREES[2:-2]):
            try:
                return self._solved(shape, _displacements(highest))
            except ConvergenceError:
                continue
        return self._solved(shape, _displacements(DEGREES[1]))

    def _with(self, modes: Modes) -> AnyBuoy:
        """The study in heave with another basis: what varies around the axis moves no heaving port."""
        return self.study.model_copy(update={"modes": modes, "motion": "heave", "mooring": None})

    def _solved(self, shape: DeformedShell, moved: tuple[Displacement, ...]) -> ShapeWater:
        """Coefficients of displacements of a shape at the frequencies of the seas."""
        water, omega = self.study.water, self._sampled.omega.tolist()
        problem = SpectralProblem(shape, moved, water.density, water.gravity, FEWEST_NODES, depth=water.depth)
        problem, _ = resolved(problem, [omega[0], omega[-1]], SOLVED)
        found = with_excitation(on_grid(problem.solve, omega, SOLVED, incident_wave(problem)).coefficients)
        matrices = (found[name].values for name in ("added_mass", "radiation_damping"))
        added_mass, damping = ((m + m.swapaxes(-1, -2)) / 2 for m in matrices)
        excitation = np.asarray(found.excitation_force.values[:, 0])
        return ShapeWater(moved, self._sampled.omega, Coefficients(added_mass, damping, excitation))

    def powers(self, modes: Modes) -> FloatArray:
        """Return mean powers with a basis, shape (design, sea, take-off) [W]."""
        study = self._with(modes)
        reference = reference_shell(study)
        if study.at_equilibrium or modes.max_degree > self._degrees[-1]:
            water = self._solved(reference.shape, _displacements(max(1, modes.max_degree)))
        else:
            water = self._undeformed_water
        as_study = Study.model_construct(**{name: getattr(study, name) for name in type(study).model_fields})
        ports = {design: seen.port for design, seen in designs_in_waves(as_study, reference, water).items()}
        return powers_of_ports(ports, study.pto, self._sampled.squares)

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
        """Power that changes are relative to: of each design, or of the reference design where that is smaller [W]."""
        power, reference = self._first, self.study.reference_design
        if reference is None:
            return power
        return np.minimum(power, power[[list(self.study.designs).index(reference)]])

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


def _displacements(highest: int, *, meridional: bool = True) -> tuple[Displacement, ...]:
    """Displacements to a degree; those along the meridian move water around other shapes than spheres alone."""
    along = (Displacement("meridional", n) for n in range(1, highest + 1)) if meridional else ()
    return (*(Displacement("radial", n) for n in range(highest + 1)), *along)


def powers_of_ports(ports: Mapping[str, Port], pto: Pto, squares: FloatArray) -> FloatArray:
    """Return mean powers of designs in seas under every take-off of `TAKE_OFFS`, (design, sea, take-off) [W].

    Parameters
    ----------
    ports : mapping design -> Port
    pto : Pto
    squares : ndarray, shape (sea, omega) [m^2]
        Squared amplitudes.
    """
    found = []
    for design, port in ports.items():
        optimal = best_dampers(port, squares, pto.stiffness, pto.efficiency)
        sprung = best_pairs(port, squares, optimal, pto.efficiency).power
        given, count, power = pto.damper(design), len(squares), optimal.power
        if given is not None:
            damping, stiffness = np.full(count, given), np.full(count, pto.stiffness)
            power = mean_power(port, squares, damping, stiffness, pto.efficiency)
        found.append([power, optimal.power, sprung])
    return np.asarray(found).swapaxes(1, 2)


def further(powers: Sequence[FloatArray]) -> FloatArray:
    """Return what degrees beyond the last may change, shape of the powers [W]: `SAFETY` times the last step.

    Where the last step is not smaller than the one before, that one counts, too.

    Parameters
    ----------
    powers : sequence of ndarray [W]
        With two or more ascending degrees of `DEGREES`.
    """
    step = np.abs(powers[-1] - powers[-2])
    if len(powers) == 2:
        return SAFETY * step
    previous = np.abs(powers[-2] - powers[-3])
    return np.where(step > previous, SAFETY * (step + previous), SAFETY * step)


def converged_degree(spec: DegreeSpec, climate: Climate | None = None) -> int:
    """Return the least degree whose mean powers and gains are within `modes.tolerance` of those of all modes.

    Parameters
    ----------
    spec : DegreeSpec
        Of a port whose powers are not known by degree, heave stands for it.
    climate : Climate, optional
        The seas of a year: its mean spectrum, from which its mean power follows, takes the place of the waves.
    """
    buoy = spec.buoy
    assert buoy is not None
    if not knows_port(buoy):
        pto = buoy.pto.model_copy(update={"port": "heave", "damping": None, "tuning": "each", "stiffness": 0.0})
        buoy = buoy.model_copy(update={"pto": pto})
    return ModeConvergence(buoy, _seas(spec, buoy, climate)).degree


def knows_port(study: AnyBuoy) -> bool:
    """Whether powers are known by degree: of one port, and of heave, volume, strain or rings of the shell."""
    port = study.pto.port
    if study.pto.several:
        return False
    return study.motion == "heave" or port in ("heave", "volume") or isinstance(port, ShellPort | StrainPort)


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
    return tuple(sea(expected(wave), highest, spec.simulation.duration) for wave in waves)
