"""Spectra of seas in text files: density over frequency, and perhaps over direction.

Imports nothing heavy unless there is one: the Snakefile reads a study at every parse.
"""

import math
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, model_validator

from vsb.errors import ConfigError
from vsb.study.quantities import Finite, NonNegative, Positive, Section, content_id
from vsb.study.records import TAIL, text_rows
from vsb.tools.words import shortened

if TYPE_CHECKING:
    from vsb.tools.arrays import FloatArray

MOST, MOST_DIRECTIONS = 10_000, 72
"""Frequencies and directions of a spectrum."""
UNEVEN = 1e-3
"""Largest deviation of directions from equal steps, in steps."""
NEEDED = "two columns, frequency [Hz] and density [m^2/Hz], or a table over frequency and direction"


class SpectrumTable(Section):
    """Density [m^2/Hz] at frequencies [Hz], linear between them and none beyond, and its shares by direction.

    Directions [degrees] are those the waves go to, from the x axis; of each frequency the shares of them sum to one.
    """

    frequency: Annotated[tuple[Positive, ...], Field(min_length=2, max_length=MOST)]
    variance_density: tuple[NonNegative, ...]
    directions: Annotated[tuple[Finite, ...], Field(max_length=MOST_DIRECTIONS)] = ()
    shares: tuple[tuple[NonNegative, ...], ...] = ()  # (frequency, direction)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if any(later <= earlier for earlier, later in pairwise(self.frequency)):
            raise ValueError("frequency: needs ascending frequencies")
        if len(self.variance_density) != len(self.frequency):
            raise ValueError(
                f"variance_density: received {len(self.variance_density)} numbers, needs one per frequency"
            )
        if max(self.variance_density) == 0:
            raise ValueError("variance_density: received 0 throughout, needs waves")
        rows = len(self.frequency) if self.directions else 0
        if len(self.shares) != rows or any(len(row) != len(self.directions) for row in self.shares):
            raise ValueError("shares: needs a row per frequency, of one number per direction")
        if any(abs(math.fsum(row) - 1) > 1e-6 for row in self.shares):
            raise ValueError("shares: needs rows that sum to 1")
        return self

    @cached_property
    def omega(self) -> "FloatArray":
        """Angular frequencies (frequency,) [rad/s]."""
        import numpy as np

        return 2 * np.pi * np.asarray(self.frequency)

    def at(self, omega: "FloatArray") -> "FloatArray":
        """Return the density at some frequencies, of the shape of omega [m^2 s/rad]."""
        import numpy as np

        return np.asarray(
            np.interp(omega, self.omega, np.asarray(self.variance_density) / (2 * np.pi), left=0.0, right=0.0)
        )

    def variance_below(self, omega: "FloatArray") -> "FloatArray":
        """Return the variance below some frequencies [rad/s], the exact integral, of the shape of omega [m^2]."""
        import numpy as np

        known, density = self.omega, self.at(self.omega)
        below = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(known))])
        to = np.clip(omega, known[0], known[-1])
        last = np.clip(np.searchsorted(known, to, side="right") - 1, 0, len(known) - 2)
        return np.asarray(below[last] + (density[last] + self.at(to)) / 2 * (to - known[last]))

    @cached_property
    def variance(self) -> float:
        """Variance of the elevation m_0 [m^2]."""
        return float(self.variance_below(self.omega[-1]))

    @property
    def size(self) -> str:
        """How much it holds, in words."""
        over = f" of {len(self.directions)} directions" if self.directions else ""
        return f"{len(self.frequency)} frequencies{over}"

    @property
    def hs(self) -> float:
        """Significant height, four standard deviations [m]."""
        return 4 * math.sqrt(self.variance)

    @property
    def energy_frequency(self) -> float:
        """Frequency of the energy period m_-1/m_0 [rad/s]: of a + b omega the integral of S/omega is exact."""
        import numpy as np

        omega, density = self.omega, self.at(self.omega)
        slope = np.diff(density) / np.diff(omega)
        inverse = (density[:-1] - slope * omega[:-1]) * np.log(omega[1:] / omega[:-1]) + np.diff(density)
        return self.variance / float(inverse.sum())

    @property
    def lowest(self) -> float:
        """Frequency below which lies less than `TAIL` of the variance [rad/s]."""
        import numpy as np

        fine = np.linspace(self.omega[0], self.omega[-1], 4001)
        below = self.variance_below(fine)
        return float(fine[np.searchsorted(below, TAIL * self.variance, side="right") - 1])

    @property
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""
        import numpy as np

        fine = np.linspace(self.omega[0], self.omega[-1], 4001)
        density = self.at(fine)
        return float(fine[density > 0.05**2 * max(density)][-1])

    def share_outside(self, low: float, high: float) -> float:
        """Return the share of the variance outside a band [rad/s]."""
        import numpy as np

        first, last = self.variance_below(np.array([low, high]))
        return 1 - float(last - first) / self.variance

    def direction_at(self, omega: "FloatArray", share: "FloatArray") -> "FloatArray":
        """Return the directions below which a share of the energy at each frequency lies, shape (omega,) [degrees]."""
        import numpy as np

        energy = np.asarray(self.variance_density)[:, None] * np.asarray(self.shares)
        below = np.cumsum([np.interp(omega, self.omega, one) for one in energy.T], axis=0)  # (direction, omega)
        directions: FloatArray = np.asarray(self.directions)[np.argmax(below >= share * below[-1], axis=0)]
        return directions

    @cached_property
    def digest(self) -> str:
        """Eight hexadecimal digits that name the spectrum by what it holds."""
        return content_id(self)[:8]


def read_spectrum(path: Path, where: str) -> dict[str, Any]:
    """Return frequencies [Hz], densities [m^2/Hz], directions [degrees] and shares of a text file.

    Either two columns, frequency [Hz] and density [m^2/Hz], a line of their names before them or not; or a table whose
    first line is a word and the directions [degrees], every other a frequency and the densities [m^2/Hz/degree] of
    them. Columns are separated by commas, semicolons or blanks. Raises `ConfigError` if it is neither.

    Parameters
    ----------
    where : str
        Place in the study, for messages about the file as a whole.
    """
    rows = text_rows(path, where, NEEDED)
    head = rows.pop(0)[1] if rows and _number(rows[0][1][0]) is None else []
    width = len(head) if any(_number(word) is not None for word in head) else 2
    known = [(n, [_number(word) for word in words]) for n, words in rows]
    for n, row in known:
        if len(row) != width or any(one is None or not 0 <= one < math.inf for one in row):
            raise ConfigError(
                f"{path}:{n}: received {shortened(repr(' '.join(dict(rows)[n])))}, needs {width} numbers of 0 or more, "
                + (
                    "a frequency [Hz] and a density [m^2/Hz/degree] per direction"
                    if width > 2
                    else "frequency [Hz] and density [m^2/Hz]; a word and directions in the first line, if it has them"
                )
            )
    table = [[one for one in row if one is not None] for _, row in known]
    table = table[1:] if table and not any(table[0]) else table  # no energy at frequency 0
    frequency, density = [row[0] for row in table], [row[1:] for row in table]
    for (n, _), (before, after) in zip(known[-len(frequency) + 1 :], pairwise(frequency), strict=False):
        if after <= before:
            raise ConfigError(f"{path}:{n}: received {after:g} Hz after {before:g} Hz, needs ascending frequencies")
    if not 2 <= len(frequency) <= MOST:
        raise ConfigError(f"{where}: received {len(frequency)} frequencies in {path.name}, needs 2 to {MOST}")
    if width == 2:
        return {"frequency": frequency, "variance_density": [one for (one,) in density]}
    return {"frequency": frequency} | _by_direction(path, head, density)


def _by_direction(path: Path, head: list[str], density: list[list[float]]) -> dict[str, Any]:
    """Directions ascending, densities of all together and shares of each."""
    named = [_number(word) for word in head[1:]]
    directions = [one for one in named if one is not None and math.isfinite(one)]
    if len(directions) < len(named) or len(directions) > MOST_DIRECTIONS:
        raise ConfigError(
            f"{path}:1: received {shortened(repr(' '.join(head)))}, needs a word and up to {MOST_DIRECTIONS} "
            "directions in degrees"
        )
    order = sorted(range(len(directions)), key=directions.__getitem__)
    steps = [directions[j] - directions[i] for i, j in pairwise(order)]
    step = sum(steps) / len(steps)
    if not step > 0 or max(abs(one - step) for one in steps) > UNEVEN * step or step * len(directions) > 360.5:
        apart = f"{min(steps):g} to {max(steps):g} degrees apart"
        raise ConfigError(f"{path}:1: received directions {apart}, needs equal steps, within a full turn")
    total = [math.fsum(row) for row in density]
    even = [1 / len(directions)] * len(directions)  # where there is no energy
    return {
        "variance_density": [step * one for one in total],
        "directions": [directions[i] for i in order],
        "shares": [[row[i] / one for i in order] if one else even for row, one in zip(density, total, strict=True)],
    }


def _number(word: str) -> float | None:
    """A word as a number, if it is one."""
    try:
        return float(word)
    except ValueError:
        return None
