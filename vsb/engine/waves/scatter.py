"""A climate from a scatter table, the occurrence of heights and periods, with one spectral shape for all seas."""

import csv
import re
from collections.abc import Iterable, Sequence
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from vsb.engine.waves.climate import (
    FAULTY,
    FEW,
    OCCURRENCE,
    PERIODS,
    TINY,
    UNSTATED,
    YEAR_HOURS,
    Climate,
    band_edges,
    bare_name,
    calm_note,
    is_series,
    kind_of,
    seasons,
)
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.engine.waves.measured_spectra import DATE, ERA5, NAMES, NETCDF, calendar, dates_of, first_bytes, load_netcdf
from vsb.engine.waves.records import HIGHEST_SEA, impossible
from vsb.errors import ConfigError
from vsb.tools import units
from vsb.tools.arrays import FloatArray
from vsb.tools.columns import Columns, dates, read_columns, trimmed
from vsb.tools.files import read_text
from vsb.tools.units import number
from vsb.tools.words import LONGEST, shortened

KINDS = {"percent": 100.0, "percentage": 100.0, "%": 100.0, "hours": YEAR_HOURS, "h": YEAR_HOURS, "share": 1.0}
DIRECTIONS = {"dir", "direction", "dp", "mwd", "wavedirection", "meandirection", "sector", "month", "season", "year"}
"""Columns of a list whose rows add up: the seas of a year go in one direction."""
SUMS = {"total", "totals", "sum", "sums", "summe", "gesamt", "all", "\u03c3", "\u2211", "tot", "sub-total", "subtotal"}
SHARES = {"%", "percent", "cum", "cum%", "cumulative", "cumulative%", "cumsum", "exceedance", "%exceedance"}
"""Labels of columns and rows of a full table that are sums, and of those made of them."""
NONE = {"-", "\u2013", "\u2014", ".", "--", "n/a", "na", "nan"}
"""What stands for no occurrence."""
SMALLEST_BIN = 1e-6
"""Smallest centre of a bin [m], [s]."""
MOST_BINS = 10_000
"""Largest number of bins: 100 heights by 100 periods."""
FEWEST_OF_EDGES = 3
"""Labels of columns from which on one more than there are cells means edges."""
DISAGREE = 0.02
"""Largest difference of a sum that is printed from that of its cells, of the sum; half a last digit of each besides."""
LABEL = "the centre of a bin above 0, or its range as 0.5-1.0, <6 or >10 (of edges both)"

Rows = list[tuple[int, list[str]]]


class Table(NamedTuple):
    """Occupied cells of a scatter table."""

    hs: FloatArray  # (cell,) [m]
    period: FloatArray  # (cell,) [s]
    kind: str  # of the period: te, tp, tz or t01
    occurrence: FloatArray  # (cell,)
    unit: float | None  # nominal sum of the occurrences where the file gives their unit
    notes: tuple[str, ...]  # how cells were read that are no numbers, and what was left out


class Axes(NamedTuple):
    """Quantities of rows and columns of a full table, and factors to m or s."""

    down: str
    across: str
    factors: tuple[float, float]
    doubt: str = ""


def read_table(path: str | Path) -> Table:
    """Return the occupied cells of a scatter table; see `vsb.engine.waves.scatter.read_scatter`.

    Raises `ConfigError` with file, line, value received and value needed.
    """
    lines = read_text(path).splitlines()
    readings = [_rows(path, lines, delimiter) for delimiter in (";", "\t", ",", "  ")]
    for rows in readings:
        if table := _named(path, rows):
            return table
    for rows in readings:
        for at in range(len(rows) - 1):
            if axes := _blank_corner(path, rows, at):
                return _full(path, rows[at:], axes)
    if table := _named(path, _rows(path, lines, " ")):
        return table
    raise ConfigError(
        f"{path}: received no line that names Hs and Te or Tp, needs a corner 'Hs/Te' or columns Hs, Te, occurrence"
    )


def _named(path: str | Path, rows: Rows) -> Table | None:
    """The table of some rows, one of which names its quantities; None if none does."""
    for at, (line, cells) in enumerate(rows):
        text = " ".join(cells).lower()
        if "power matrix" in text or re.search(r"[\[(]\s*(kw|w|mw)\s*[\])]", text):  # has the layout of a table of seas
            words = shortened(repr(" ".join(filter(None, cells))))
            raise ConfigError(f"{path}:{line}: received {words}, a power matrix; needs the occurrence of seas")
        if axes := _corner(path, rows, at):
            return _full(path, rows[at:], axes)
        if columns := _columns(path, rows[at]):
            return _pairs(path, rows[at:], columns)
    return None


def factor_of(path: str | Path, line: int, name: str) -> float:
    """Return the factor from the unit in brackets behind a name to m or s, 1 where there is none; `ConfigError`."""
    stated = [text.strip() for text in re.findall(r"[\[(](.*?)[\])]", name) if text.strip(" -")]
    powers = units.METRE if kind_of(name) == "hs" else units.SECOND
    factors = [units.scale(text, powers) for text in stated]
    if None in factors:
        raise ConfigError(f"{path}:{line}: received the unit {stated[0]!r} in {name!r}, needs m and s")
    return next((factor for factor in factors if factor), 1.0)


def _rows(path: str | Path, lines: list[str], delimiter: str) -> Rows:
    """Numbers and cells of the lines that hold anything."""
    if delimiter.isspace() and delimiter != "\t":
        split = ((i, re.split(rf"\s{{{len(delimiter)},}}", line.strip())) for i, line in enumerate(lines, 1))
        return [(i, cells) for i, cells in split if any(cells)]
    reader = csv.reader(lines, delimiter=delimiter)
    rows = ((reader.line_num, [cell.strip() for cell in row]) for row in reader)  # quoted cells may have several lines
    try:
        return [(i, row) for i, row in rows if any(row)]
    except csv.Error as error:
        raise ConfigError(
            f"{path}:{reader.line_num}: received a cell too long ({error}); needs all quotes closed"
        ) from None


# which quantity is where --------------------------------------------------------------------------------------------


def _corner(path: str | Path, rows: Rows, at: int) -> Axes | None:
    """Quantities of rows and columns of a full table from its corner, which may be parted over two lines."""
    line, cells = rows[at]
    if len(cells) < 2 or len(cells[0]) > LONGEST:
        return None
    parts = re.split(r"\s*[/\\|]\s*|\s+vs\.?\s+|\s+[x\u00d7]\s+", re.sub(r"(?i)h1/3", "H13", cells[0]))
    kinds = [kind_of(part) for part in parts]
    if len(parts) == 2 and any(kinds):
        if None in kinds or "hs" not in kinds or kinds[0] == kinds[1]:
            raise ConfigError(
                f"{path}:{line}: received the corner {cells[0]!r}, needs Hs/Te, Hs/Tp or Hs/Tz, the significant "
                "height of seas and one of their periods"
            )
        down, across = (factor_of(path, line, part) for part in parts)
        return Axes(str(kinds[0]), str(kinds[1]), (down, across))
    if kinds == [None] or len(parts) > 1 or not _are_bins(cells[1:]):
        return None
    for above, words in reversed(rows[max(0, at - 3) : at]):
        for word in words:
            if (other := kind_of(word)) and (other == "hs") != (kinds[0] == "hs"):
                factors = factor_of(path, line, cells[0]), factor_of(path, above, word)
                return Axes(str(kinds[0]), other, factors)
    return None


def _blank_corner(path: str | Path, rows: Rows, at: int) -> Axes | None:
    """Quantities of a table without a corner: heights have the smaller numbers; the period is named above, or is Te."""
    (line, cells), body = rows[at], rows[at + 1 :]
    if len(cells) < 3 or kind_of(cells[0]) or number(cells[0]) is not None or not _are_bins(cells[1:]):
        return None
    labels = [row[0] for _, row in body if row[0] and _sum_label(row[0]) is None and len(trimmed(row)) > 1]
    if not labels or not all(map(_bin, labels)):
        return None
    across = _axis(path, [(line, cell) for cell in cells[1:] if cell and _sum_label(cell) is None])
    down = _axis(path, [(line, cell) for cell in labels])
    words = [word.strip(",.:;()[]") for _, above in rows[:at] for text in above for word in text.split()]
    named = {kind for word in words if (kind := kind_of(word)) in PERIODS}
    if len(named) > 1 or np.median(down) == np.median(across):
        return None
    period, heights_down = named.pop() if named else "te", bool(np.median(down) < np.median(across))
    doubt = (
        f"the {'rows' if heights_down else 'columns'}, of smaller numbers, read as Hs, the others as "
        f"{period.capitalize()}, {UNSTATED}"
    )
    return Axes(*(("hs", period) if heights_down else (period, "hs")), (1.0, 1.0), doubt)


def _columns(path: str | Path, row: tuple[int, list[str]]) -> dict[str, int] | None:
    """Columns of height, period and occurrence of a list of cells."""
    line, cells = row
    plain = [bare_name(cell) or cell.strip(" ()[]").lower() for cell in cells]
    found: dict[str, int] = {}
    for i, cell in enumerate(cells):
        if kind := kind_of(cell):
            found.setdefault(kind, i)
    often = [i for i, name in enumerate(plain) if name in OCCURRENCE]
    if "hs" not in found or len(found) < 2:
        return None
    if not often:
        named = ", ".join(repr(cell) for cell in cells if cell)
        raise ConfigError(
            f"{path}:{line}: received the columns {shortened(named)}, needs one more that is called "
            "occurrence, percent, hours, share or count"
        )
    return {**found, "occurrence": often[0]}


# labels of bins and their cells -------------------------------------------------------------------------------------


class Bin(NamedTuple):
    """A bin as its label gives it: both ends, one end, or the centre as both."""

    low: float | None
    high: float | None


def _bin(cell: str) -> Bin | None:
    """The bin of a label, None if it is none."""
    if len(cell) > LONGEST:
        return None
    plain = re.sub(r"\s*(m|s)$", "", cell.strip())
    if ends := re.fullmatch(r"([\d.,]+)\s*(?:-|\u2013|to|\.\.\.?)\s*([\d.,]+)", plain):
        low, high = map(number, ends.groups())
        return None if low is None or high is None or not low < high else Bin(low, high)
    if below := re.fullmatch(r"(?:<|\u2264|<=|under|below|up to)\s*([\d.,]+)", plain):
        return None if (end := number(below[1])) is None else Bin(None, end)
    if above := re.fullmatch(r"(?:>|\u2265|>=|over|above)\s*([\d.,]+)|([\d.,]+)\s*\+", plain):
        return None if (end := number(above[1] or above[2])) is None else Bin(end, None)
    centre = number(plain)
    return None if centre is None or not np.isfinite(centre) else Bin(centre, centre)


def _sum_label(cell: str) -> str | None:
    """Whether a label is of sums, or of shares made of them."""
    plain = bare_name(cell).replace(".", "")
    return "sum" if plain in SUMS else "share" if plain in SHARES else None


def _are_bins(cells: Sequence[str]) -> bool:
    """Whether cells are labels of bins, and perhaps of sums."""
    there = [cell for cell in cells if cell]
    bins = [cell for cell in there if _bin(cell)]
    return len(bins) > 1 and all(_bin(cell) or _sum_label(cell) for cell in there)


def _axis(path: str | Path, labels: Sequence[tuple[int, str]]) -> FloatArray:
    """Centres of bins; one that is open at an end is as wide as its neighbour."""
    bins = []
    for line, cell in labels:
        if (found := _bin(cell)) is None:
            raise ConfigError(f"{path}:{line}: received {shortened(repr(cell))}, needs {LABEL}")
        bins.append(found)
    closed = sorted(
        (one for one in bins if one.low is not None and one.high is not None), key=lambda one: one[0] or 0.0
    )
    if len(closed) < len(bins) and len(closed) < 2 and not (closed and closed[0].low != closed[0].high):
        raise ConfigError(f"{path}:{labels[0][0]}: received open bins alone, needs {LABEL}")
    centres = []
    for (line, cell), (low, high) in zip(labels, bins, strict=True):
        if low is None and high is not None:
            centre = max(high - _width(closed, 0) / 2, high / 2)
        elif high is None and low is not None:
            centre = low + _width(closed, -1) / 2
        else:
            centre = ((low or 0.0) + (high or 0.0)) / 2
        if centre < SMALLEST_BIN:
            raise ConfigError(f"{path}:{line}: received the bin {cell!r}, needs {LABEL}")
        centres.append(centre)
    return np.array(centres)


def _width(closed: Sequence[Bin], end: int) -> float:
    """Width of the first or last bin that has both ends; of centres their distance."""
    low, high = closed[end]
    assert low is not None
    assert high is not None
    if high > low:
        return high - low
    two = closed[:2] if end == 0 else closed[-2:]
    return float((two[-1].low or 0.0) - (two[0].low or 0.0))


class Cells:
    """Reads occurrences, and counts those that are no plain numbers."""

    def __init__(self, path: str | Path) -> None:
        self.path, self.blank, self.traces, self.percent = path, 0, 0, False

    def value(self, line: int, cell: str) -> float:
        """Return an occurrence; nothing, or a dash, is none, and `<0.1` half of it."""
        if not cell or cell.lower() in NONE:
            self.blank += 1
            return 0.0
        self.percent |= "%" in cell
        plain = cell.replace("%", "").strip()
        trace = plain[:1] in ("<", "\u2264")
        value = number(plain.lstrip("<\u2264= ")) if trace else number(plain)
        if value is None or not 0 <= value < np.inf:
            raise ConfigError(f"{self.path}:{line}: received {shortened(repr(cell))}, needs an occurrence of 0 or more")
        self.traces += trace
        return value / 2 if trace else value

    @property
    def notes(self) -> list[str]:
        """What was read as what."""
        found = [f"{self.blank} empty cells read as none"] if self.blank else []
        return found + ([f"{self.traces} cells of less than a bound read as half of it"] if self.traces else [])


# full tables and lists ----------------------------------------------------------------------------------------------


def _full(path: str | Path, rows: Rows, axes: Axes) -> Table:
    """A full table; what stands beside it is sums, which must be those of its cells."""
    (first, header), body = rows[0], rows[1:]
    while not header[-1]:  # its corner is not empty, or its labels are not
        header = header[:-1]
    labels = [(i, cell) for i, cell in enumerate(header) if i and _sum_label(cell) is None]
    beside = [i for i, cell in enumerate(header) if i and _sum_label(cell) == "sum"]
    widths = {len(trimmed(row)) for _, row in body if not _sum_label(row[0]) and len(trimmed(row)) > 1}
    edges = len(labels) >= FEWEST_OF_EDGES and len(body) > 1 and widths == {len(header) - 1}
    across, width = _axis(path, [(first, cell) for _, cell in labels]), len(header)
    if edges:
        across = np.asarray((across[1:] + across[:-1]) / 2, dtype=float)
        labels, width = labels[:-1], width - 1
    read, down, cells, sums, words = Cells(path), [], [], [], []
    for line, row in body:
        if len(trimmed(row)) == 1 and _bin(row[0]) is None and _sum_label(row[0]) is None:
            words.append(f"line {line} left out: {shortened(row[0])}")
            continue
        if len(row) < width or any(row[width:]):
            raise ConfigError(f"{path}:{line}: received {len(row)} cells, needs {width} as the header has")
        if (sort := _sum_label(row[0])) is not None:
            sums += [(line, row)] if sort == "sum" else []
            continue
        down.append((line, row[0]))
        cells.append([read.value(line, row[i]) for i, _ in labels])
    if not cells:
        raise ConfigError(f"{path}:{first}: received a header without rows, needs one for each bin")
    occurrence = np.array(cells)
    for i in beside if not edges else ():
        printed = [(line, row[i]) for line, row in body if _sum_label(row[0]) is None and len(row) > i]
        _check_sums(path, printed, occurrence.sum(axis=1), f"in the column {header[i]!r}")
    for line, row in sums:
        _check_sums(path, [(line, row[i]) for i, _ in labels], occurrence.sum(axis=0), f"in the row {row[0]!r}")
    heights = _axis(path, down)
    _check_repeats(path, "columns", across.tolist())
    _check_repeats(path, "rows", heights.tolist())
    occupied = np.nonzero(occurrence)
    by = {axes.down: axes.factors[0] * heights[occupied[0]], axes.across: axes.factors[1] * across[occupied[1]]}
    notes = [axes.doubt] if axes.doubt else []
    notes += ["labels of the columns read as the edges of their bins, one more than there are cells"] if edges else []
    opened = [cell for _, cell in (*labels, *down) if (found := _bin(cell)) and None in found]
    notes += [f"bins that are open at an end taken as wide as their neighbours: {', '.join(opened)}"] if opened else []
    notes += words
    left = [*(cell for cell in header[1:] if _sum_label(cell)), *(row[0] for _, row in body if _sum_label(row[0]))]
    notes += [f"left out, sums of the others: {', '.join(left)}"] if left else []
    return _table(path, by, occurrence[occupied], 100.0 if read.percent else None, [*notes, *read.notes])


def _check_sums(path: str | Path, printed: Iterable[tuple[int, str]], computed: FloatArray, where: str) -> None:
    """Check that sums are those of the cells, but for rounding: else a cell was misread."""
    for (line, cell), total in zip(printed, computed, strict=True):
        if not cell or cell.lower() in NONE:
            continue
        value = number(cell.replace("%", "").strip())
        decimals = re.search(r"[.,](\d+)", cell)
        rounding = 0.5 * 10.0 ** -(len(decimals[1]) if decimals else 0)
        if value is None or abs(value - total) > DISAGREE * abs(total) + rounding * (1 + np.sqrt(len(computed))):
            raise ConfigError(
                f"{path}:{line}: received {shortened(repr(cell))} {where}, needs the sum of its cells, {total:.6g}"
            )


def _pairs(path: str | Path, rows: Rows, columns: dict[str, int]) -> Table:
    """A list of heights, periods and occurrences; those of several directions or months are added up."""
    (first, header), body = rows[0], rows[1:]
    if len(periods := [header[i] for kind, i in columns.items() if kind in PERIODS]) > 1:
        raise ConfigError(f"{path}:{first}: received both {' and '.join(periods)}, needs one of them")
    at = columns["occurrence"]
    name = bare_name(header[at]) or header[at].strip(" ()[]").lower()
    read = Cells(path)
    factors = {key: factor_of(path, first, header[i]) for key, i in columns.items() if key != "occurrence"}
    if (stated := re.findall(r"[\[(](.*?)[\])]", header[at])) and not units.unit(stated[0]):
        raise ConfigError(f"{path}:{first}: received the unit {stated[0]!r} in {header[at]!r}, needs % or h")
    others = [i for i, cell in enumerate(header) if cell and i not in columns.values()]
    summed = [i for i in others if bare_name(header[i]) in DIRECTIONS]
    found: dict[tuple[float, ...], float] = {}
    seen: set[tuple[object, ...]] = set()
    for line, row in body:
        if len(row) <= max(columns.values()):
            raise ConfigError(f"{path}:{line}: received {len(row)} cells, needs {len(header)} as the header has")
        cell = tuple(factors[key] * float(_axis(path, [(line, row[columns[key]])])[0]) for key in factors)
        beside = tuple(row[i] for i in summed if i < len(row))
        if (cell, beside) in seen:
            raise ConfigError(f"{path}: received pairs labelled {cell} twice, needs every bin once")
        seen.add((cell, beside))
        found[cell] = found.get(cell, 0.0) + read.value(line, row[at])
    occurrence = np.array(list(found.values()))
    kept = occurrence > 0
    by = {key: np.array([cell[i] for cell in found])[kept] for i, key in enumerate(factors)} if found else {}
    notes = [f"cells added up over {', '.join(header[i] for i in summed)}"] if summed else []
    left = [header[i] for i in others if i not in summed]
    notes += [f"columns left out: {', '.join(left)}"] if left else []
    nominal = 100.0 if read.percent or "%" in header[at] else KINDS.get(name)
    return _table(path, by, occurrence[kept], nominal, [*notes, *read.notes])


def _table(
    path: str | Path, by: dict[str, FloatArray], occurrence: FloatArray, nominal: float | None, notes: list[str]
) -> Table:
    """The table of some cells."""
    if not occurrence.size:
        raise ConfigError(f"{path}: received no occurrence above 0, needs one")
    if occurrence.size > MOST_BINS:
        raise ConfigError(
            f"{path}: received {occurrence.size} bins, needs at most {MOST_BINS}: records are to be counted in bins"
        )
    kind = next(kind for kind in by if kind != "hs")
    return Table(by["hs"], by[kind], kind, occurrence, nominal, tuple(notes))


def _check_repeats(path: str | Path, where: str, labels: Sequence[object]) -> None:
    """Check that every bin is there once."""
    seen: set[object] = set()
    for label in labels:
        if label in seen:
            raise ConfigError(f"{path}: received {where} labelled {label} twice, needs every bin once")
        seen.add(label)


HEIGHT_STEP, PERIOD_STEP = 0.5, 1.0
"""Bins of heights [m] and periods [s], as in IEC TS 62600-100."""
MISSING = (99.0, 999.0, 9999.0, -9.0, -99.0, -999.0, -9999.0)
"""Numbers that stand for a missing value."""
WORDS = {"", "mm", "nan", "na", "n/a", "-", "null", "none", "--"}
"""Words that do."""
NEEDED = "columns of time, Hs and a period, Te or Tp"
LINES = 100
"""Lines at the beginning of a text that may name its columns."""
LONGEST_PERIOD = 60.0
"""Largest possible period of a sea [s]."""


def read_series(path: str | Path) -> Table | None:
    """Return a series of heights and periods, counted into cells; None of a file that is none.

    Each cell has the root mean square height and the mean period, weighted by energy, of its records, so that the
    mean energy flux is that of the series. Of several periods the first of `PERIODS` is used. Raises `ConfigError`.
    """
    if first_bytes(path).startswith(NETCDF):
        hs, period, kind, times, notes = _of_netcdf(path)
    else:
        if not any(map(_names_series, read_text(path).splitlines()[:LINES])):
            return None
        table = read_columns(Path(path), str(path), NEEDED, looked_for=kind_of)
        if not is_series(table.names):
            return None
        hs, period, kind, times, notes = _of_text(path, table)
        if not times and not all(map(kind_of, table.names)):
            return None
    if times:
        kept, remarks = calendar(times)
        hs, period, notes, times = hs[kept], period[kept], [*remarks, *notes], [times[i] for i in kept]
    else:
        notes.append("no dates in the file: gaps and seasons are not known")
    there = np.isfinite(hs) & np.isfinite(period) & (hs > TINY) & (period > TINY) & ~np.isin(hs, MISSING)
    there &= ~np.isin(period, MISSING)
    if not there.any():
        raise ConfigError(f"{path}: received {len(hs)} records, none with a height and a period; needs at least one")
    wrong = there & ((hs > HIGHEST_SEA) | (period > LONGEST_PERIOD))
    if wrong.any():
        at = int(np.flatnonzero(wrong)[0])
        raise ConfigError(
            f"{path}: received Hs {hs[at]:.4g} m with {kind.capitalize()} {period[at]:.4g} s in record {at + 1}, needs "
            f"at most {HIGHEST_SEA:g} m and {LONGEST_PERIOD:g} s, missing values as 99, 999 or empty cells"
        )
    calm = np.abs(hs) <= TINY
    notes.append(f"{len(hs)} records, {int((~there & ~calm).sum())} with missing values left out")
    notes += calm_note("records of height 0", int(calm.sum()), len(hs))
    notes += seasons([time for time, usable in zip(times, there, strict=True) if usable]) if times else []
    if there.mean() < 0.5:
        notes.append(f"{int(there.sum())} of {len(hs)}: {FEW}")
    hs, period = hs[there], period[there]
    places = np.column_stack([np.floor(hs / HEIGHT_STEP), np.floor(period / PERIOD_STEP)])
    _, cell = np.unique(places, axis=0, return_inverse=True)
    count, energy, weighted = (np.bincount(cell.ravel(), weights) for weights in (None, hs**2, hs**2 * period))
    notes.append(f"counted in bins of {HEIGHT_STEP:g} m and {PERIOD_STEP:g} s, their mean energy and flux kept")
    return Table(np.sqrt(energy / count), weighted / energy, kind, count.astype(float), None, tuple(notes))


def _names_series(line: str) -> bool:
    """Whether a line names columns of a height and a period: words alone."""
    for between in (r"[;\t]", ",", r"\s+(?![\[(])"):
        cells = re.split(between, line)
        if is_series(cells) and not any(number(cell.strip()) is not None for cell in cells):
            return True
    return False


_Series = tuple[FloatArray, FloatArray, str, list[datetime], list[str]]
"""Heights [m], periods [s], kind of these, dates if there are any, notes."""


def _chosen(path: str | Path, kinds: dict[str, str]) -> tuple[str, str, str, list[str]]:
    """Names of height and period among names with their kinds, the kind of the period, and notes on others."""
    heights = [name for name, kind in kinds.items() if kind == "hs"]
    periods = [name for known in PERIODS for name, kind in kinds.items() if kind == known]
    if len(heights) != 1 or not periods:
        raise ConfigError(
            f"{path}: received {', '.join(heights) or 'no height'} and {', '.join(periods) or 'no period'}; needs one "
            "significant height, and a period"
        )
    notes = [f"series of {heights[0]} and {periods[0]}"]
    return heights[0], periods[0], kinds[periods[0]], notes


def _of_netcdf(path: str | Path) -> _Series:
    """A series of one site of a netCDF file, by its standard names or the names of reanalyses."""
    ds = load_netcdf(path)
    kinds = {}
    for name, variable in ds.data_vars.items():
        if kind := kind_of(str(variable.attrs.get("standard_name", "")).replace("_", "")) or kind_of(str(name)):
            kinds[str(name)] = kind
    if not kinds:
        names = shortened(", ".join(sorted(map(str, ds.variables))))
        spectra = "; spectra are named as climate: {spectra: FILE}" if {ERA5, *NAMES["efth"]} & {*ds.variables} else ""
        raise ConfigError(f"{path}: received variables {names}; needs Hs and a period, such as swh and mwp{spectra}")
    height, period, kind, notes = _chosen(path, kinds)
    if left := [name for name in map(str, ds.data_vars) if name not in (height, period)]:
        notes.append(f"variables left out: {', '.join(left)}")
    found = []
    for name, powers, unit in ((height, units.METRE, "m"), (period, units.SECOND, "s")):
        variable = ds[name].squeeze()
        if variable.ndim != 1:
            over = ", ".join(f"{size} along {dim}" for dim, size in ds[name].sizes.items())
            raise ConfigError(f"{path}: received {name} over {over}; needs one site over time: select a point")
        if variable.dtype.kind not in "iuf":
            raise ConfigError(f"{path}: received {name} of type {variable.dtype}, needs numbers")
        stated = str(variable.attrs.get("units", unit))
        if (factor := units.scale(stated, powers)) is None:
            raise ConfigError(f"{path}: received {name} in {stated!r}, needs {unit}")
        found.append((factor * variable.values.astype(float), variable.dims[0]))
    if found[0][1] != found[1][1] or found[0][1] not in ds.coords:
        raise ConfigError(f"{path}: received {height} and {period} without a common time, needs dates of the records")
    return found[0][0], found[1][0], kind, dates_of(path, ds[found[0][1]].values), notes


def _of_text(path: str | Path, table: Columns) -> _Series:
    """A series in columns of text."""
    kinds = {name: kind for name in table.names if (kind := kind_of(name))}
    height, period, kind, notes = _chosen(path, kinds)
    found, used = [], {height, period}
    for name, powers, unit in ((height, units.METRE, "m"), (period, units.SECOND, "s")):
        i = table.names.index(name)
        stated = table.units[i] or unit
        if (factor := units.scale(stated, powers)) is None:
            raise ConfigError(f"{path}: received {table.label(i)}, needs {unit}")
        values = [np.nan if row[i].strip().lower() in WORDS else number(row[i]) for _, row in table.rows]
        if None in values:
            line, row = table.rows[values.index(None)]
            raise ConfigError(
                f"{path}:{line}: received {shortened(repr(row[i]))}, needs a number, or nothing where it is missing"
            )
        found.append(factor * np.array(values, dtype=float))
    times, of_time = _times(table)
    if left := [table.label(i) for i, name in enumerate(table.names) if name not in used and i not in of_time]:
        notes.append(f"columns left out: {', '.join(left)}")
    return found[0], found[1], kind, times, notes


def _times(table: Columns) -> tuple[list[datetime], list[int]]:
    """Dates of the records, and their columns: one of dates, NDBC's five, or none."""
    first = [name.lstrip("#") for name in table.names[:5]]
    if first[0] in ("YY", "YYYY", "yr") and first[1:] == list(DATE[1:]):
        cells = [f"{row[0]:0>4}-{row[1]}-{row[2]}T{row[3]:0>2}:{row[4]:0>2}" for _, row in table.rows]
        return dates(cells), list(range(5))
    for i in range(len(table.names)):
        if found := dates([row[i] for _, row in table.rows]):
            return found, [i]
    return [], []


Spectrum = Literal["jonswap", "pierson_moskowitz"]
BAND = 0.02
"""Width of the bands of a climate from a table, relative to their frequency [-]."""
REACH = 0.45, 10.0
"""Ends of the bands in multiples of peak frequencies: 1e-4 of the variance lies beyond."""
WHOLE = 0.02
"""Relative error allowed in the sum of shares, percent or hours: tables round."""


def read_scatter(path: str | Path, spectrum: Spectrum = "jonswap", gamma: float = 3.3) -> Climate:
    """Return the climate of a scatter table, one sea for each occupied cell.

    Raises `ConfigError` with file, line, value received and value needed.

    Parameters
    ----------
    path : path
        CSV: a table whose corner says `Hs/Te`, `Hs/Tp` or `Hs/Tz` (or the other way round), or three columns named so
        with occurrences in percent, hours, shares or counts. Labels are centres of bins, or ranges; see
        `vsb.engine.waves.scatter`. Or a series of Hs and a period, which is counted; see
        `vsb.engine.waves.scatter`.
    spectrum : {'jonswap', 'pierson_moskowitz'}
    gamma : float
        Peakedness of JONSWAP.
    """
    table = read_series(path) or read_table(path)
    total = float(table.occurrence.sum())
    known = {100.0: "percent", 1.0: "shares", YEAR_HOURS: "hours"}
    near = [unit for unit in ([table.unit] if table.unit else known) if abs(total / unit - 1) <= WHOLE]
    if near:
        summed = f"{total:.6g} ({known[near[0]]} of {near[0]:g})"
    elif table.unit is None and np.all(table.occurrence == np.rint(table.occurrence)):
        summed = f"{total:.6g} counts"
    else:
        unit = table.unit
        needed = f"{unit:g} ({known[unit]})" if unit else "1, 100 (percent), 8766 (hours) or whole counts"
        raise ConfigError(f"{path}: received occurrences that sum to {total:.6g}, needs {needed}")
    share = table.occurrence / total
    gamma = gamma if spectrum == "jonswap" else 1.0
    ratio = energy_period_over(table.kind, gamma)
    te = table.period * ratio
    notes = [f"{len(share)} occupied cells of Hs and {table.kind.capitalize()}, which sum to {summed}", *table.notes]
    shape = f"JONSWAP spectra, gamma {gamma:g}" if spectrum == "jonswap" else "Pierson-Moskowitz spectra"
    notes += [f"Te = {ratio:.3f} {table.kind.capitalize()} of these spectra"] if table.kind in ("tz", "t01") else []
    wrong = impossible(table.hs, te)
    if share[wrong].sum() > FAULTY:
        at = int((table.hs / np.maximum(te, TINY) ** 2).argmax())
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
    tp = te / energy_period_over("tp", gamma)
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
def energy_period_over(kind: str, gamma: float) -> float:
    """Return Te over another period of a JONSWAP sea [-], by its moments: Te = 2 pi m_-1/m_0.

    Parameters
    ----------
    kind : {'te', 'tp', 'tz', 't01'}
        The energy period itself, the peak period, the zero-crossing period 2 pi sqrt(m_0/m_2), or 2 pi m_0/m_1.
    gamma : float
    """
    x, _ = _unit_sea(gamma)
    density = jonswap_spectrum(x, 4.0, 2 * np.pi, gamma)
    before, m0, m1, m2 = (float(np.trapezoid(density * x**n, x)) for n in (-1, 0, 1, 2))
    m2 += float(density[-1] * x[-1] ** 3) / 2  # beyond the last frequency S falls with its fifth power
    te = before / m0  # in peak periods, as the others
    return float(te / {"te": te, "tp": 1.0, "tz": np.sqrt(m0 / m2), "t01": m0 / m1}[kind])


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
