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

from vsb.hydro.coefficients import Coefficients
from vsb.hydro.database import with_excitation
from vsb.hydro.dofs import Displacement
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.spectral.sweep import FEWEST_NODES, incident_wave, resolved
from vsb.hydro.sweep import on_grid
from vsb.motion.tuning import best_dampers, mean_power
from vsb.scenes.ports import ShapeWater, designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import DeformedShell
from vsb.study.sections import Modes
from vsb.study.specs import LadderSpec
from vsb.study.study import Study
from vsb.tools.units import FloatArray
from vsb.waves.seas import Sea

DEGREES = (6, 9, 14, 20, 30, 42, 60, 90)
"""Degrees a basis is tried with; each basis is part of the next."""
TOLERANCE = 0.005
"""Of mean power, relative, and of the gain in parts of the reference design's power, unless a study says another."""
SAFETY = 2.0
"""What all further degrees may change, in terms of the last step of the list.

Steps of errors that fall like a power p of the degree shrink by 0.7^p, so that all further ones together are
1/(0.7^-p - 1) of the last: below 2 for p > 1.1; errors of resolved bending layers fall faster than any power.
"""
SOLVED = 2e-4
"""Tolerance of the coefficients, at most: what they have wrong all degrees have wrong alike."""
MOST_FREQUENCIES = 24
"""Of a sea: its components are summed at so many frequencies; the change with the degree is smooth enough for that."""


TAKE_OFFS = ("given", "optimal")
"""The damper a study gives, where it gives one, and that of the largest mean power of each design in each sea."""


class Sampled(NamedTuple):
    """Seas at common frequencies."""

    omega: FloatArray  # (omega,) [rad/s]
    squares: FloatArray  # squared amplitudes (sea, omega) [m^2]


def sampled(seas: Sequence[Sea]) -> Sampled:
    """Return seas at as few frequencies as the change of their powers with the degree needs."""
    grids = []
    for sea in seas:
        energy = np.cumsum(np.abs(sea.amplitude) ** 2)
        inside = sea.omega[(energy > 1e-4 * energy[-1]) & (energy < (1 - 1e-4) * energy[-1])]
        few = len(sea.omega) <= MOST_FREQUENCIES or len(inside) < 2
        grids.append(sea.omega if few else np.linspace(inside[0], inside[-1], MOST_FREQUENCIES))
    omega = np.unique(np.round(np.concatenate(grids), 9))
    squares = np.zeros((len(seas), len(omega)))
    for row, sea, grid in zip(squares, seas, grids, strict=True):
        at = np.searchsorted(omega, np.round(grid, 9))
        nearest = at[np.abs(sea.omega[:, None] - grid).argmin(axis=1)]
        np.add.at(row, nearest, np.abs(sea.amplitude) ** 2)
    return Sampled(omega, squares)


@dataclass(frozen=True, eq=False)
class ModeConvergence:
    """Mean powers of the designs of a study in seas, by the degree of the full basis.

    Powers have the dimensions (design, sea, take-off) [W], take-offs as `TAKE_OFFS`.
    """

    study: LadderSpec
    seas: Sequence[Sea]
    tolerance: float = TOLERANCE

    @cached_property
    def _sampled(self) -> Sampled:
        return sampled(self.seas)

    @cached_property
    def _undeformed_water(self) -> ShapeWater:
        """Of the undeformed sphere, whose displacements of all degrees are solved once."""
        moved = tuple(Displacement("radial", n) for n in range(DEGREES[-1] + 1))
        return self._solved(reference_shell(self._with(Modes(basis="full", degree=1))).shape, moved)

    def _with(self, modes: Modes) -> LadderSpec:
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
        if study.at_equilibrium:
            radial = (Displacement("radial", n) for n in range(max(1, modes.degree) + 1))
            meridional = (Displacement("meridional", n) for n in range(1, max(1, modes.degree) + 1))
            water = self._solved(reference.shape, (*radial, *meridional))
        else:
            water = self._undeformed_water
        pto, squares = study.pto, self._sampled.squares
        as_study = Study.model_construct(**{name: getattr(study, name) for name in type(study).model_fields})
        designs = designs_in_waves(as_study, reference, water)
        found = []
        for design, seen in designs.items():
            optimal = best_dampers(seen.port, squares, pto.stiffness, pto.efficiency).power
            given, count = pto.damper(design), len(squares)
            if given is None:
                found.append([optimal, optimal])
                continue
            damping, stiffness = np.full(count, given), np.full(count, pto.stiffness)
            found.append([mean_power(seen.port, squares, damping, stiffness, pto.efficiency), optimal])
        return np.asarray(found).swapaxes(1, 2)

    @cached_property
    def climbed(self) -> Mapping[int, FloatArray]:
        """Powers by degree of the full basis, up to where further degrees change less than half the tolerance."""
        found: dict[int, FloatArray] = {}
        for degree in DEGREES:
            found[degree] = self.powers(Modes(basis="full", degree=degree)) if found else self._first
            if len(found) > 2 and self.worst(self._further(found)) <= self.tolerance / 2:
                break
        return found

    @staticmethod
    def _further(found: Mapping[int, FloatArray]) -> FloatArray:
        """What degrees beyond the highest may change, shape of the powers [W]: `SAFETY` times the last step.

        Where the last step is not the smaller one, the one before counts, too.
        """
        *_, before, last, highest = found.values()
        step, previous = np.abs(highest - last), np.abs(last - before)
        return np.where(step > previous, SAFETY * (step + previous), SAFETY * step)

    @cached_property
    def further(self) -> FloatArray:
        """What degrees beyond the highest tried may change, shape of the powers [W]."""
        return self._further(self.climbed)

    @property
    def converged(self) -> FloatArray:
        """Powers with the highest degree tried, shape (design, sea, take-off) [W]."""
        return self.climbed[max(self.climbed)]

    @cached_property
    def _size(self) -> FloatArray:
        """What changes are relative to: each power, or that of the reference design where it is smaller [W]."""
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
        return float((np.abs(change) / np.where(self._size > 0, self._size, np.inf)).max(initial=0.0))

    @cached_property
    def degree(self) -> int:
        """Least degree of the list whose powers and gains are within the tolerance of those of all modes."""
        for degree, power in self.climbed.items():
            if self.worst(np.abs(self.converged - power) + self.further) <= self.tolerance:
                return degree
        return max(self.climbed)
