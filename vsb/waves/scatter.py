"""A climate from a scatter table, the occurrence of heights and periods, with one spectral shape for all seas.

Tables may have commas or semicolons, decimal commas, percent; full tables and lists of pairs are read.
"""

import csv
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from vsb.errors import ConfigError
from vsb.study.records import impossible
from vsb.tools.arrays import FloatArray
from vsb.tools.files import read_text
from vsb.tools.words import LONGEST, shortened
from vsb.waves.climate import FAULTY, YEAR_HOURS, Climate, band_edges
from vsb.waves.spectra import jonswap_spectrum

Spectrum = Literal["jonswap", "pierson_moskowitz"]
BAND = 0.02
"""Width of the bands of a climate from a table, relative to their frequency [-]."""
REACH = 0.45, 10.0
"""Ends of the bands in multiples of peak frequencies: 1e-4 of the variance lies beyond."""
WHOLE = 0.02
"""Relative error allowed in the sum of shares, percent or hours: tables round."""
HEIGHT = {"hs", "hm0", "hsig", "h13", "significantwaveheight", "waveheight"}
PERIODS = {
    "te": {"te", "tm10", "tm-10", "tm-1,0", "energyperiod", "meanenergyperiod", "waveenergyperiod"},
    "tp": {"tp", "peakperiod", "wavepeakperiod"},
}
OCCURRENCE = {
    "occurrence", "occurrences", "percent", "percentage", "%", "hours", "h", "count", "counts", "frequency", "share",
    "probability", "n", "number", "hits", "occ",
}  # fmt: skip
KINDS = {"percent": 100.0, "percentage": 100.0, "%": 100.0, "hours": YEAR_HOURS, "h": YEAR_HOURS, "share": 1.0}


class Table(NamedTuple):
    """Occupied cells of a scatter table."""

    hs: FloatArray  # (cell,) [m]
    period: FloatArray  # (cell,) [s]
    kind: str  # of the period, te or tp
    occurrence: FloatArray  # (cell,)
    unit: float | None  # nominal sum of the occurrences where the file gives their unit
    blank: int  # empty cells, read as zero


def read_scatter(path: str | Path, spectrum: Spectrum = "jonswap", gamma: float = 3.3) -> Climate:
    """Return the climate of a scatter table, one sea for each occupied cell.

    Raises `ConfigError` with file, line, value received and value needed.

    Parameters
    ----------
    path : path
        CSV: a table whose corner says `Hs/Te` or `Hs/Tp` (or the other way round), or three columns named so with
        occurrences in percent, hours, shares or counts. Labels are centres of bins, or ranges.
    spectrum : {'jonswap', 'pierson_moskowitz'}
    gamma : float
        Peakedness of JONSWAP.
    """
    table = read_table(path)
    share, total = _shares(path, table)
    notes = [f"{len(share)} occupied cells of Hs and {table.kind.capitalize()}, which sum to {total}"]
    notes += [f"{table.blank} empty cells read as none"] if table.blank else []
    gamma = gamma if spectrum == "jonswap" else 1.0
    shape = f"JONSWAP spectra, gamma {gamma:g}" if spectrum == "jonswap" else "Pierson-Moskowitz spectra"
    te = table.period if table.kind == "te" else table.period * energy_over_peak_period(gamma)
    wrong = impossible(table.hs, te)
    if share[wrong].sum() > FAULTY:
        at = int((table.hs / te**2).argmax())
        raise ConfigError(
            f"{path}: received {share[wrong].sum():.1%} of seas that are physically impossible, as Hs "
            f"{table.hs[at]:.4g} m with {table.kind.capitalize()} {table.period[at]:.4g} s; needs Hs "
            "in m, periods in s, the corner the right way"
        )
    return climate_of_cells(table.hs, te, share, gamma, Path(path).name, (*notes, shape))


def climate_of_cells(
    hs: FloatArray, te: FloatArray, share: FloatArray, gamma: float, name: str, notes: Sequence[str] = ()
) -> Climate:
    """Return the climate of JONSWAP seas of given heights, energy periods and shares, each shape (sea,)."""
    tp = te / energy_over_peak_period(gamma)
    low, high = 2 * np.pi / tp.max() * REACH[0], 2 * np.pi / tp.min() * REACH[1]
    omega = np.geomspace(low, high, int(np.ceil(np.log(high / low) / BAND)) + 1)
    return Climate(omega, jonswap_bands(omega, hs, tp, gamma), share, hs, te, name, tuple(notes))


@cache
def _unit_sea(gamma: float) -> tuple[FloatArray, FloatArray]:
    """Frequencies over that of the peak, and the variance below them of a sea of m0 = 1."""
    from scipy.integrate import cumulative_trapezoid  # slow to import, and not needed for spectra

    x = np.linspace(0.0, 40.0, 40001)[1:]
    below = cumulative_trapezoid(jonswap_spectrum(x, 4.0, 2 * np.pi, gamma), x=x, initial=0)
    return x, np.asarray(below / below[-1])


@cache
def energy_over_peak_period(gamma: float) -> float:
    """Return Te/Tp of a JONSWAP sea [-]; 0.857 for gamma 1, 0.903 for 3.3."""
    x, _ = _unit_sea(gamma)
    density = jonswap_spectrum(x, 4.0, 2 * np.pi, gamma)
    return float(np.trapezoid(density / x, x) / np.trapezoid(density, x))


def jonswap_bands(omega: FloatArray, hs: FloatArray, tp: FloatArray, gamma: float) -> FloatArray:
    """Return mean densities over bands of JONSWAP seas, shape (sea, omega) [m^2 s].

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
        Centres of the bands.
    hs, tp : ndarray, shape (sea,) [m], [s]
    """
    edges = band_edges(omega)
    x, below = _unit_sea(gamma)
    cumulated = np.interp(np.outer(tp / (2 * np.pi), edges), x, below)
    return np.asarray(hs[:, None] ** 2 / 16 * np.diff(cumulated, axis=1) / np.diff(edges))


def _shares(path: str | Path, table: Table) -> tuple[FloatArray, str]:
    """Shares of the year, and the sum of the occurrences in words."""
    total = float(table.occurrence.sum())
    known = {100.0: "percent", 1.0: "shares", YEAR_HOURS: "hours"}
    units = [table.unit] if table.unit else list(known)
    near = [unit for unit in units if abs(total / unit - 1) <= WHOLE]
    if near:
        return table.occurrence / total, f"{total:.6g} ({known[near[0]]} of {near[0]:g})"
    if table.unit is None and np.all(table.occurrence == np.rint(table.occurrence)):
        return table.occurrence / total, f"{total:.6g} counts"
    needed = f"{table.unit:g} ({known[table.unit]})" if table.unit else "1, 100 (percent), 8766 (hours) or whole counts"
    raise ConfigError(f"{path}: received occurrences that sum to {total:.6g}, needs {needed}")


MOST_BINS = 10_000
"""Largest number of bins: 100 heights by 100 periods."""


def read_table(path: str | Path) -> Table:
    """Return the occupied cells of a scatter table; see `read_scatter`."""
    lines = read_text(path).splitlines()
    for delimiter in (";", "\t", ","):
        rows = _rows(path, lines, delimiter)
        for at in range(len(rows)):
            if corner := _corner(path, rows[at]):
                return _full(path, rows[at:], corner)
            if columns := _columns(path, rows[at]):
                return _pairs(path, rows[at:], columns)
    raise ConfigError(
        f"{path}: received no line that names Hs and Te or Tp, needs a corner 'Hs/Te' or columns Hs, Te, occurrence"
    )


def _rows(path: str | Path, lines: list[str], delimiter: str) -> list[tuple[int, list[str]]]:
    """Numbers and cells of the lines that hold anything."""
    reader = csv.reader(lines, delimiter=delimiter)
    cells = ((reader.line_num, [cell.strip() for cell in row]) for row in reader)  # quoted ones may have several lines
    try:
        return [(i, row) for i, row in cells if any(row)]
    except csv.Error as error:
        raise ConfigError(
            f"{path}, line {reader.line_num}: received a cell too long ({error}); needs all quotes closed"
        ) from None


def _plain(name: str) -> str:
    """A name without unit, case, blanks and underscores; long text as it is."""
    if len(name) > LONGEST:
        return name
    return re.sub(r"[\s_{}$]|[\[(].*?[\])]", "", name).lower()


def _check_unit(path: str | Path, line: int, name: str) -> None:
    """Check the unit in brackets behind a name, where there is one."""
    for unit in re.findall(r"[\[(](.*?)[\])]", name):
        if unit.strip().lower() not in ("m", "s", "sec", "metres", "meters", "seconds", "%", "h", "-", ""):
            raise ConfigError(f"{path}, line {line}: received the unit {unit!r} in {name!r}, needs m and s")


def _kind(name: str) -> str | None:
    """Quantity of a column: hs, te, tp or None."""
    names = {"hs": HEIGHT, **PERIODS}
    return next((kind for kind, spelled in names.items() if name in spelled), None)


def _corner(path: str | Path, row: tuple[int, list[str]]) -> tuple[str, str] | None:
    """Quantities of rows and columns of a full table, from its corner."""
    parts = re.split(r"[/\\|]", row[1][0])
    if len(parts) != 2 or len(row[1]) < 2 or len(row[1][0]) > LONGEST:
        return None
    kinds = tuple(_kind(_plain(part)) for part in parts)
    for part in parts:
        _check_unit(path, row[0], part)
    if None in kinds or "hs" not in kinds or kinds[0] == kinds[1]:
        if "hs" in kinds:
            raise ConfigError(f"{path}, line {row[0]}: received the corner {row[1][0]!r}, needs Hs/Te or Hs/Tp")
        return None
    return str(kinds[0]), str(kinds[1])


def _columns(path: str | Path, row: tuple[int, list[str]]) -> dict[str, int] | None:
    """Columns of height, period and occurrence of a list of pairs."""
    plain = [_plain(cell) or cell.strip(" ()[]").lower() for cell in row[1]]
    found = {kind: i for i, name in enumerate(plain) if (kind := _kind(name))}
    often = [i for i, name in enumerate(plain) if name in OCCURRENCE]
    if "hs" not in found or len(found) < 2:
        return None
    if not often:
        named = ", ".join(repr(cell) for cell in row[1] if cell)
        raise ConfigError(
            f"{path}, line {row[0]}: received the columns {shortened(named)}, needs one more that is called "
            "occurrence, percent, hours, share or count"
        )
    return {**found, "occurrence": often[0]}


def _full(path: str | Path, rows: list[tuple[int, list[str]]], corner: tuple[str, str]) -> Table:
    """A full table."""
    (first, header), body = rows[0], rows[1:]
    while not header[-1]:  # its corner is not empty
        header = header[:-1]
    across = np.array([_label(path, first, cell) for cell in header[1:]])
    down, cells, blank, percent = [], [], 0, False
    for line, row in body:
        if len(row) < len(header) or any(row[len(header) :]):
            raise ConfigError(f"{path}, line {line}: received {len(row)} cells, needs {len(header)} as the header has")
        down.append(_label(path, line, row[0]))
        inside = row[1 : len(header)]
        blank += sum(not cell for cell in inside)
        percent |= any("%" in cell for cell in inside)
        cells.append([_occurrence(path, line, cell) if cell else 0.0 for cell in inside])
    if not cells:
        raise ConfigError(f"{path}, line {first}: received a header without rows, needs one for each bin")
    _check_repeats(path, "columns", list(across))
    _check_repeats(path, "rows", down)
    i, j = np.nonzero(np.array(cells))
    by = {corner[0]: np.array(down)[i], corner[1]: across[j]}
    return _table(path, by, np.array(cells)[i, j], 100.0 if percent else None, blank)


def _pairs(path: str | Path, rows: list[tuple[int, list[str]]], columns: dict[str, int]) -> Table:
    """A list of heights, periods and occurrences."""
    (first, header), body = rows[0], rows[1:]
    if {"te", "tp"} <= columns.keys():
        raise ConfigError(f"{path}, line {first}: received both Te and Tp, needs one of them")
    for i in columns.values():
        _check_unit(path, first, header[i])
    at = columns["occurrence"]
    name = _plain(header[at]) or header[at].strip(" ()[]").lower()
    percent = "%" in header[at] or any("%" in row[at] for _, row in body if len(row) > at)
    values: dict[str, list[float]] = {key: [] for key in columns}
    for line, row in body:
        if len(row) <= max(columns.values()):
            raise ConfigError(f"{path}, line {line}: received {len(row)} cells, needs {len(header)} as the header has")
        for key, i in columns.items():
            values[key].append((_occurrence if key == "occurrence" else _label)(path, line, row[i]))
    occurrence = np.array(values.pop("occurrence"))
    _check_repeats(path, "pairs", list(zip(*values.values(), strict=True)))
    kept = occurrence > 0
    by = {key: np.array(column)[kept] for key, column in values.items()}
    return _table(path, by, occurrence[kept], 100.0 if percent else KINDS.get(name), 0)


def _table(
    path: str | Path, by: dict[str, FloatArray], occurrence: FloatArray, unit: float | None, blank: int
) -> Table:
    """The table of some cells."""
    if not occurrence.size:
        raise ConfigError(f"{path}: received no occurrence above 0, needs one")
    if occurrence.size > MOST_BINS:
        raise ConfigError(
            f"{path}: received {occurrence.size} bins, needs at most {MOST_BINS}: records are to be counted in bins"
        )
    kind = "te" if "te" in by else "tp"
    return Table(by["hs"], by[kind], kind, occurrence, unit, blank)


def _check_repeats(path: str | Path, where: str, labels: Sequence[object]) -> None:
    """Check that every bin is there once."""
    seen: set[object] = set()
    for label in labels:
        if label in seen:
            raise ConfigError(f"{path}: received {where} labelled {label} twice, needs every bin once")
        seen.add(label)


def _number(path: str | Path, line: int, cell: str, needed: str) -> float:
    """A cell as a number; a single comma without a point is a decimal comma."""
    plain = cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell
    try:
        value = float(plain)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ConfigError(f"{path}, line {line}: received {shortened(repr(cell))}, needs {needed}")
    return value


def _label(path: str | Path, line: int, cell: str) -> float:
    """The centre of a bin, given itself or as a range."""
    ends = len(cell) <= LONGEST and re.fullmatch(r"([\d.,]+)\s*(?:-|\u2013|to|\.\.\.?)\s*([\d.,]+)", cell)
    needed = "the centre of a bin above 0, or its range as 0.5-1.0; no sums"
    values = [_number(path, line, part, needed) for part in (ends.groups() if ends else (cell,))]
    centre = float(np.mean(values))
    if centre <= 0:
        raise ConfigError(f"{path}, line {line}: received the bin {cell!r}, needs {needed}")
    return centre


def _occurrence(path: str | Path, line: int, cell: str) -> float:
    """An occurrence."""
    value = _number(path, line, cell.replace("%", "").strip(), "an occurrence of 0 or more")
    if value < 0:
        raise ConfigError(f"{path}, line {line}: received {cell!r}, needs an occurrence of 0 or more")
    return value
