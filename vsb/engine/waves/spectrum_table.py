"""Spectra of seas in text files: density over frequency, and perhaps over direction."""

import math
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from vsb.engine.waves.records import check_possible
from vsb.engine.waves.seas import BANDS, TAIL, SeaFile, SeaOfFile, SpectralSea
from vsb.errors import ConfigError
from vsb.keys.meanings import Key
from vsb.keys.quantities import Finite, NonNegative, Positive
from vsb.tools import units
from vsb.tools.arrays import FloatArray, IntArray
from vsb.tools.columns import Columns, read_columns
from vsb.tools.units import Frequency, number
from vsb.tools.words import shortened

MOST, MOST_DIRECTIONS = 10_000, 72
"""Frequencies and directions of a spectrum."""
PARTS = 36
"""Parts of equal energy that the directions at a frequency are drawn from in turn."""
UNEVEN = 1e-3
"""Largest deviation of directions from equal steps, in steps."""
NEEDED = "two columns, frequency [Hz] and density [m^2/Hz], or a table over frequency and direction"
HERTZ = Frequency(1.0)
ANGULAR, PERIOD = Frequency(1 / (2 * math.pi), angular=True), Frequency(1.0, period=True)
FREQUENCIES = {
    **dict.fromkeys(("f", "freq", "frequency", "frequencies", "fhz"), HERTZ),
    **dict.fromkeys(("w", "omega", "ω", "om", "angularfrequency", "radianfrequency", "circularfrequency"), ANGULAR),
    **dict.fromkeys(("t", "period", "periods", "waveperiod"), PERIOD),
}
"""What names of frequencies and periods mean where no unit is stated."""
DENSITIES = {
    "s", "sf", "s(f)", "s(w)", "sw", "e", "ef", "e(f)", "density", "spectraldensity", "energydensity", "energy", "psd",
    "variancedensity", "spectrum", "spec", "swden", "spectralwavedensity", "waveenergydensity", "powerspectraldensity",
    "efth", "eta2", "s(omega)",
}  # fmt: skip
AMPLITUDES = {"a", "amp", "amplitude", "amplitudes", "waveamplitude", "eta", "zeta"}


ENDS = 0.1
"""Density at the last frequency, relative to the largest, from which a spectrum seems to go on."""


class SpectrumTable(SeaFile):
    """Density [m^2/Hz] at frequencies [Hz], linear between them and none beyond, and its shares by direction.

    Directions [degrees] are those the waves go to, from the x axis; of each frequency the shares of them sum to one.
    """

    KEYS: ClassVar = {
        "frequency": Key("Hz", "[0.1, 0.15, 0.3]", "frequencies, ascending"),
        "variance_density": Key("m^2/Hz", "[0.0, 1.5, 0.0]", "density at each, linear between them"),
        "directions": Key("degrees", "[0.0, 30.0]", "directions the waves travel to, from the x axis"),
        "shares": Key("-", "[[0.5, 0.5], [0.5, 0.5], [0.5, 0.5]]", "shares of each frequency's energy, by direction"),
        "notes": Key("", "['columns left out: phase']", "what its file holds beside, and how it was read"),
    }
    frequency: Annotated[tuple[Positive, ...], Field(min_length=2, max_length=MOST)]
    variance_density: tuple[NonNegative, ...]
    directions: Annotated[tuple[Finite, ...], Field(max_length=MOST_DIRECTIONS)] = ()
    shares: tuple[tuple[NonNegative, ...], ...] = ()  # (frequency, direction)
    notes: tuple[str, ...] = ()  # what the file holds beside, and how it was read

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
    def omega(self) -> FloatArray:
        """Angular frequencies (frequency,) [rad/s]."""
        return 2 * np.pi * np.asarray(self.frequency)

    def at(self, omega: FloatArray) -> FloatArray:
        """Return the density at some frequencies, of the shape of omega [m^2 s/rad]."""
        return np.asarray(
            np.interp(omega, self.omega, np.asarray(self.variance_density) / (2 * np.pi), left=0.0, right=0.0)
        )

    def variance_below(self, omega: FloatArray) -> FloatArray:
        """Return the variance below some frequencies [rad/s], the exact integral, of the shape of omega [m^2]."""
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
        omega, density = self.omega, self.at(self.omega)
        slope = np.diff(density) / np.diff(omega)
        inverse = (density[:-1] - slope * omega[:-1]) * np.log(omega[1:] / omega[:-1]) + np.diff(density)
        return self.variance / float(inverse.sum())

    @property
    def lowest(self) -> float:
        """Frequency below which lies less than `TAIL` of the variance [rad/s]."""
        fine = np.linspace(self.omega[0], self.omega[-1], 4001)
        below = self.variance_below(fine)
        return float(fine[np.searchsorted(below, TAIL * self.variance, side="right") - 1])

    @property
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""
        fine = np.linspace(self.omega[0], self.omega[-1], 4001)
        density = self.at(fine)
        return float(fine[density > 0.05**2 * max(density)][-1])

    def share_outside(self, low: float, high: float) -> float:
        """Return the share of the variance outside a band [rad/s]."""
        first, last = self.variance_below(np.array([low, high]))
        return 1 - float(last - first) / self.variance

    def energy_at(self, omega: FloatArray) -> FloatArray:
        """Return the density of each direction at frequencies, shape (direction, omega), in a unit of its own."""
        energy = np.asarray(self.variance_density)[:, None] * np.asarray(self.shares)
        return np.array([np.interp(omega, self.omega, one) for one in energy.T])

    def direction_at(self, omega: FloatArray, share: FloatArray) -> FloatArray:
        """Return the directions below which a share of the energy at each frequency lies, shape (omega,) [degrees]."""
        below = np.cumsum(self.energy_at(omega), axis=0)
        directions: FloatArray = np.asarray(self.directions)[np.argmax(below >= share * below[-1], axis=0)]
        return directions


def read_spectrum(path: Path, where: str) -> dict[str, Any]:
    """Return frequencies [Hz], densities [m^2/Hz], directions [degrees], shares and notes of a text file.

    Either columns of frequency and density, their names and units before them or not; or a table whose first line is a
    word and the directions [degrees], every other a frequency [Hz] and the densities [m^2/Hz/degree] of them. Columns
    may state frequencies in Hz or rad/s, or periods in s, and densities per hertz or per rad/s: see
    `vsb.tools.columns.read_columns`. Raises `ConfigError` if it is neither.

    Parameters
    ----------
    where : str
        Place in the study, for messages about the file as a whole.
    """
    table = read_columns(path, where, NEEDED)
    over_directions = sum(number(name) is not None for name in table.names) > 1
    width = len(table.names) if over_directions else 2
    of_frequency, of_density, axis, factor, notes = (
        _over_directions(path, table) if over_directions else _two_columns(path, table)
    )
    lines, frequency, density = [], [], []
    for n, cells in table.rows:
        values = [number(cells[i]) for i in (of_frequency, *of_density) if i < len(cells)]
        known = [value for value in values if value is not None and 0 <= value < math.inf]
        if len(known) != width:
            raise ConfigError(
                f"{path}:{n}: received {shortened(repr(' '.join(cells)))}, needs {width} numbers of 0 or more, "
                + (
                    "a frequency [Hz] and a density [m^2/Hz/degree] per direction"
                    if over_directions
                    else "frequency [Hz] and density [m^2/Hz]; a word and directions in the first line, if it has them"
                )
            )
        if known[0] == 0 and (axis.period or not any(known[1:])):
            continue  # no energy at frequency 0
        lines.append(n)
        frequency.append(1 / (axis.factor * known[0]) if axis.period else axis.factor * known[0])
        density.append([factor * value for value in known[1:]])
    if axis.period and len(frequency) > 1 and frequency[1] < frequency[0]:
        lines, frequency, density = lines[::-1], frequency[::-1], density[::-1]
    for n, (before, after) in zip(lines[1:], pairwise(frequency), strict=False):
        if after <= before:
            raise ConfigError(f"{path}:{n}: received {after:g} Hz after {before:g} Hz, needs ascending frequencies")
    if not 2 <= len(frequency) <= MOST:
        raise ConfigError(f"{where}: received {len(frequency)} frequencies in {path.name}, needs 2 to {MOST}")
    if over_directions:
        return {"frequency": frequency, "notes": notes} | _by_direction(path, table, density)
    if density[-1][0] > ENDS * max(one for (one,) in density):
        share = density[-1][0] / max(one for (one,) in density)
        notes = [*notes, f"ends at {frequency[-1]:g} Hz with {share:.0%} of its peak: was the file cut?"]
    held: dict[str, Any] = {"frequency": frequency, "variance_density": [one for (one,) in density], "notes": notes}
    if not any(table.units) and any(held["variance_density"]) and frequency[0] > 0:
        of_file = SpectrumTable(**held)
        check_possible(
            f"{path}", of_file.hs, 2 * math.pi / of_file.energy_frequency, "frequencies in Hz, densities in m^2/Hz"
        )
    return held


_Read = tuple[int, list[int], Frequency, float, list[str]]
"""Column of frequencies, columns of densities, what the first means, factor of the second to m^2/Hz, notes."""


def _over_directions(path: Path, table: Columns) -> _Read:
    """How a table over directions is read: in Hz and m^2/Hz/degree."""
    if table.units[0].lower() not in ("", "hz") or {*table.units[1:]} - {"", "deg", "degrees"}:
        raise ConfigError(
            f"{path}: received the columns {shortened(repr(table.header))}; needs frequencies in Hz, directions in "
            "degrees and densities in m^2/Hz/degree where a table is over both"
        )
    return 0, list(range(1, len(table.names))), HERTZ, 1.0, []


def _two_columns(path: Path, table: Columns) -> _Read:
    """Which columns are frequency and density, by their units, then names, then places."""
    if not table.header:
        return 0, list(range(1, max(2, len(table.names)))), HERTZ, 1.0, []
    line = f"{path}: received the columns {shortened(repr(table.header))}"
    axes: dict[int, Frequency] = {}
    for i, (name, stated) in enumerate(zip(table.plain, table.units, strict=True)):
        if found := units.frequency(stated) if stated else FREQUENCIES.get(name):
            axes[i] = found
    of_frequency = next((i for i, axis in axes.items() if not axis.period), next(iter(axes), 0))
    if table.units[of_frequency] and of_frequency not in axes:
        raise ConfigError(f"{line}; needs frequencies in Hz or rad/s, or periods in s, no {table.label(of_frequency)}")
    axis = axes.get(of_frequency, HERTZ)
    rest = [i for i in range(len(table.names)) if i != of_frequency]
    of_unit = [i for i in rest if table.units[i] and units.density(table.units[i], axis, False)]
    of_name = [i for i in rest if table.plain[i] in DENSITIES and not table.units[i]]
    chosen = of_unit or of_name or (rest if len(rest) == 1 else [])
    if len(chosen) != 1:
        several = f"{len(chosen)} of them densities" if chosen else "none of them known as a density"
        raise ConfigError(f"{line}, {several}; needs one, named S and with its unit, such as S [m^2/Hz]")
    density = chosen[0]
    amplitudes = table.plain[density] in AMPLITUDES or units.scale(table.units[density], units.METRE) is not None
    if amplitudes and not of_unit:
        raise ConfigError(
            f"{line}, of which {table.label(density)} is an amplitude and no density; needs S = a^2/(2 df) in m^2/Hz, "
            "df the distance of frequencies"
        )
    factor = units.density(table.units[density], axis, False) if table.units[density] else 1.0
    if factor is None:
        raise ConfigError(f"{line}; needs a density in m^2/Hz or m^2 s/rad, no {table.label(density)}")
    unstated = [table.label(i) for i in (of_frequency, density) if not table.units[i]]
    if unstated and ((axis.angular or axis.period) or factor != 1.0):
        raise ConfigError(
            f"{line}, of which {' and '.join(unstated)} state no unit; needs those of "
            "both, such as omega [rad/s], S [m^2 s/rad]"
        )
    notes = []
    if axis != HERTZ or factor != 1.0:
        notes.append(f"{table.label(of_frequency)} and {table.label(density)} turned into Hz and m^2/Hz")
    elif unstated:
        notes.append("units that are not stated taken as Hz and m^2/Hz")
    if left := [table.label(i) for i in rest if i != density]:
        notes.append(f"columns left out: {', '.join(left)}")
    return of_frequency, [density], axis, factor, notes


def _by_direction(path: Path, table: Columns, density: list[list[float]]) -> dict[str, Any]:
    """Directions ascending, densities of all together and shares of each."""
    named = [number(name) for name in table.names[1:]]
    directions = [one for one in named if one is not None and math.isfinite(one)]
    if len(directions) < len(named) or len(directions) > MOST_DIRECTIONS:
        raise ConfigError(
            f"{path}:1: received {shortened(repr(table.header))}, needs a word and up to {MOST_DIRECTIONS} "
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


class TabulatedSea(SeaOfFile, SpectralSea):
    """A sea of a spectrum in a file, over frequency or over frequency and direction; random seed."""

    KEYS: ClassVar = {
        "kind": Key("", "spectrum", "a sea with the spectrum of a file"),
        "file": Key(
            "",
            "spectrum.csv",
            "file of two columns, frequency and density, in Hz and m^2/Hz or as their header says, or of a table over "
            "frequency and direction",
        ),
    }
    kind: Literal["spectrum"]
    file: SpectrumTable

    @field_validator("file", mode="before", json_schema_input_type=str | SpectrumTable)
    @classmethod
    def _read(cls, value: Any) -> Any:
        """A path stands for the file there."""
        return read_spectrum(Path(value), "file") if isinstance(value, str | Path) else value

    @model_validator(mode="after")
    def _spread_once(self) -> Self:
        if self.spreading and self.file.directions:
            raise ValueError("spreading: the file holds directions of its own; remove it")
        return self

    @property
    def spreads(self) -> bool:
        """Whether its waves go to several directions."""
        return bool(self.spreading or self.file.directions)

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions its waves go to [degrees]: those of the file, turned by `direction`."""
        if not self.file.directions:
            return super().directions
        return tuple(dict.fromkeys(round(self.direction + one, 6) for one in self.file.directions))

    @property
    def words(self) -> str:
        """The spectrum in words."""
        directional = "directional " if self.file.directions else ""
        return f"a {directional}spectrum of {self._size_in_words}"

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad], linear between frequencies of the file."""
        return self.file.at(omega)

    def variances(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the variance of the elevation in bands between frequencies [rad/s], shape (band,) [m^2]."""
        return self.file.variance_below(high) - self.file.variance_below(low)

    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return middles [rad/s] and variances [m^2] of bands that hold all of the sea."""
        edges = np.linspace(self.file.omega[0], self.file.omega[-1], BANDS + 1)
        return (edges[1:] + edges[:-1]) / 2, self.variances(edges[:-1], edges[1:])

    @property
    def parts_around(self) -> int:
        """Parts of equal energy that the directions of the sea are drawn from in turn."""
        return super().parts_around if self.spreading else PARTS

    def shares_around(self, omega: FloatArray) -> list[tuple[float, FloatArray]]:
        """Return the directions of a spread sea [degrees], and what part of the energy at frequencies goes to each."""
        if self.spreading:
            return super().shares_around(omega)
        energy = self.file.energy_at(omega)
        whole = energy.sum(axis=0)
        shares = np.divide(energy, whole, out=np.zeros_like(energy), where=whole > 0)
        going = (round(self.direction + one, 6) for one in self.file.directions)
        return list(zip(going, shares, strict=True))

    def angles_at(self, omega: FloatArray, part: IntArray, random: np.random.Generator) -> FloatArray:
        """Return the angles of parts at frequencies: of the energy of the file there, unless the sea is spread."""
        if self.spreading:
            return super().angles_at(omega, part, random)
        return self.file.direction_at(omega, (part + random.uniform(size=len(omega))) / PARTS)
