"""A site's year of a damper matrix, at several ports or spread over the shell: see `vsb.results.year`.

The best matrix depends on the form of a spectrum, not on its height. So that of each sea is the best of those that are
optimal for the year and for the mean spectrum of every bin of energy period; none of them is worse than that of the
year, and all are matrices the take-off may have.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from vsb.engine.motion.coefficient_errors import CoefficientError, sensitivity_at_ports
from vsb.engine.motion.damper_matrix import Kind, Ports, best_matrix
from vsb.engine.waves.climate import Climate
from vsb.models.floating_system import AnyBody, SeveralInWaves
from vsb.models.take_off import given_matrix, matrix_kind
from vsb.results.left_out import LeftOut
from vsb.results.year import (
    PRACTICE_GAMMA,
    OverClimate,
    Tuning,
    Values,
    Year,
    bins_of,
    gains_within,
    powers_within,
    practice,
    variance_outside,
)
from vsb.results.year_validity import beyond_validity, rms_of_motions
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, FloatArray, IntArray


class Absorbed(NamedTuple):
    """Damper matrices, which of them every sea has, and its mean power."""

    matrices: FloatArray  # (matrix, port, port)
    chosen: IntArray  # (sea,)
    power: FloatArray  # (sea,) [W]

    def mean_matrix(self, hours: FloatArray) -> FloatArray:
        """Return the mean matrix of the year, shape (port, port)."""
        share = np.bincount(self.chosen, hours, minlength=len(self.matrices))
        return np.asarray(np.tensordot(share, self.matrices, axes=1))


@dataclass(frozen=True)
class MatrixYear(OverClimate[Ports]):
    """One design at several ports over a climate."""

    kind: Kind

    @cached_property
    def best(self) -> FloatArray:
        """The matrix that absorbs most over the year, shape (port, port)."""
        return best_matrix(self.port, self.squares, self.kind).damping

    @cached_property
    def tried(self) -> FloatArray:
        """The best of the year, and of the mean spectrum of every bin of energy period, shape (matrix, port, port)."""
        _, column = np.unravel_index(bins_of(self.climate).index, bins_of(self.climate).shape)
        energy = [self.climate.hours * (column == one) @ self.climate.density for one in np.unique(column)]
        return np.array([self.best, *(best_matrix(self.port, one @ self.weights, self.kind).damping for one in energy)])

    def with_matrices(self, matrices: FloatArray) -> Absorbed:
        """Return for every sea the best of some matrices (matrix, port, port)."""
        power = np.array([self.port.power(one) for one in matrices])
        table = (power @ self.weights.T) @ self.climate.density.T
        chosen = table.argmax(axis=0)
        return Absorbed(matrices, chosen, table[chosen, np.arange(len(chosen))])

    def absorbed(self, tuning: Tuning, given: FloatArray | None) -> Absorbed:
        """Return matrices and power of each sea under a tuning; `fixed` with a matrix given."""
        if tuning == "fixed":
            assert given is not None  # a campaign's own check
            return self.with_matrices(given[None])
        return self.with_matrices(self.tried if tuning == "each" else self.best[None])


@dataclass(frozen=True)
class MatrixYears:
    """Years of designs under damper matrices; see `vsb.results.member.DampedYears`."""

    climate: Climate
    tunings: Sequence[Tuning]

    def of_designs(self, study: Study | AnyBody, ports: Mapping[str, Ports]) -> dict[str, MatrixYear]:
        """Return every design of a study over the climate."""
        kind = matrix_kind(study.pto)
        return {design: MatrixYear(one, self.climate, kind) for design, one in ports.items()}

    def absorbed(self, study: Study | AnyBody, years: Mapping[str, MatrixYear]) -> dict[tuple[str, str], Absorbed]:
        """Return what every design absorbs, by design and tuning."""
        as_given = study.pto.model_copy(update={"tuning": "fixed"})
        return {
            (design, tuning): one.absorbed(tuning, given_matrix(as_given, design, one.port.velocity.shape[1]))
            for (design, one), tuning in product(years.items(), self.tunings)
        }

    def whole(
        self, study: Study | AnyBody, years: Mapping[str, MatrixYear], found: Mapping[tuple[str, str], Absorbed]
    ) -> Year:
        """Return the year of all designs with its errors of quadrature."""

        def elsewhere(year: MatrixYear, taken: Absorbed) -> float:
            return float(year.with_matrices(taken.matrices).power @ year.climate.hours)

        usual, power = practice(self.climate, PRACTICE_GAMMA), self._each(years, lambda *by: found[by].power)
        there = self._each(years, lambda *by: elsewhere(replace(years[by[0]], climate=usual), found[by]))
        rough = self._each(years, lambda *by: elsewhere(years[by[0]].coarser(), found[by]))
        outside = variance_outside({design: one.port.omega for design, one in years.items()}, self.climate)
        names, of_quadrature = (tuple(years), tuple(self.tunings)), np.abs(power @ self.climate.hours - rough) / 3
        notes = (*self.climate.notes, outside)
        return Year(self.climate, study.water, *names, None, power, there, of_quadrature, study.reference_design, notes)

    def _each(self, years: Mapping[str, MatrixYear], value: Callable[[str, str], FloatArray | float]) -> FloatArray:
        """Values of all designs and tunings, shape (design, tuning, ...)."""
        return np.array([[value(design, tuning) for tuning in self.tunings] for design in years])

    def __call__(
        self,
        study: Study | AnyBody,
        waves: Mapping[str, SeveralInWaves],
        errors: Sequence[CoefficientError] = (),
        left_out: LeftOut | None = None,
    ) -> Values:
        """Return the results of some designs of a study in waves, each shape (design, ...), and their gains.

        Parameters as of `DampedYears`. `damper_matrix(design, tuning, port, port_)` is the mean over the year; of a
        damper spread over the shell it is its one damper.
        """
        hours, years = self.climate.hours, self.of_designs(study, {design: one.port for design, one in waves.items()})
        found = self.absorbed(study, years)
        of = self.whole(study, years, found)
        power = of.power
        beyond = beyond_validity(
            of,
            lambda *by: rms_of_motions(waves[by[0]], self.climate, found[by].matrices, found[by].chosen),
            study.buoy.device.radius if study.buoy else None,
        )
        matrices = self._each(years, lambda *by: found[by].mean_matrix(hours))
        one_damper = matrices[..., :1, :1] if matrix_kind(study.pto) == "uniform" else matrices
        values: dict[str, tuple[tuple[str, ...], AnyArray]] = {**of.values, **beyond}
        values["damper_matrix"] = ("design", "tuning", "port", "port_"), one_damper
        at = None if of.reference is None else of.designs.index(of.reference)
        of_power, of_ratio = np.zeros((2, *power.shape[:2]))
        for j in range(len(self.tunings)):
            slopes = [
                sensitivity_at_ports(waves[design].moved, one.port, matrices[i, j], one.squares)
                for i, (design, one) in enumerate(years.items())
            ]
            of_power[:, j] = [sum(one.to(each) for each in errors) for one in slopes]
            if at is not None:
                of_ratio[:, j] = [sum((one - slopes[at]).to(each) for each in errors) for one in slopes]
        mean, error = of.annual_mean_power, of.quadrature_error
        values |= powers_within(mean, error, of_power, left_out.power if left_out else None)
        if at is None:
            return values
        return {**values, **gains_within(mean, error, of_ratio, at, left_out.gain if left_out else None)}


def year_of_matrices(
    study: Study | AnyBody, ports: Mapping[str, Ports], climate: Climate, tuning: Tuning
) -> tuple[Year, FloatArray]:
    """Return the year of the designs of a study under one tuning, and their matrices, (design, sea, port, port)."""
    them = MatrixYears(climate, (tuning,))
    years = them.of_designs(study, ports)
    found = them.absorbed(study, years)
    matrices = [found[design, tuning].matrices[found[design, tuning].chosen] for design in years]
    return them.whole(study, years, found), np.array(matrices)
