"""Scatter tables as atlases, reports and spreadsheets print them: occurrences over height and period.

Full tables, whose corner names both or whose axes are distinguished by what seas can be, and lists of cells. Sums
that are printed beside are compared and left out, cells of less than the last digit count half of it.
"""

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vsb.engine.waves.climate import UNSTATED, YEAR_HOURS
from vsb.errors import ConfigError
from vsb.tools import units
from vsb.tools.arrays import FloatArray
from vsb.tools.files import read_text
from vsb.tools.units import number, unit
from vsb.tools.words import LONGEST, shortened

HEIGHT = {
    "hs", "hm0", "hsig", "h13", "h1/3", "significantwaveheight", "significantheight", "waveheight", "swh", "vhm0",
    "wvht", "wavehs", "seasurfacewavesignificantheight",
}  # fmt: skip
PERIODS = {
    "te": {
        "te", "tm10", "tm-10", "tm-1,0", "tm-1.0", "t-10", "t-1,0", "energyperiod", "meanenergyperiod",
        "waveenergyperiod", "mwp", "vtm10", "t0m1",
        "seasurfacewavemeanperiodfromvariancespectraldensityinversefrequencymoment",
    },
    "t01": {
        "t01", "tm01", "t0,1", "tm0,1", "mp1", "vtm01",
        "seasurfacewavemeanperiodfromvariancespectraldensityfirstfrequencymoment",
    },
    "tz": {
        "tz", "t02", "tm02", "t0,2", "tm0,2", "zerocrossingperiod", "zeroupcrossingperiod", "meanzerocrossingperiod",
        "zeroupcrossingwaveperiod", "mp2", "vtm02", "apd", "wavetz", "seasurfacewavezeroupcrossingperiod",
        "seasurfacewavemeanperiodfromvariancespectraldensitysecondfrequencymoment",
    },
    "tp": {
        "tp", "peakperiod", "wavepeakperiod", "tpeak", "peakwaveperiod", "pp1d", "vtpk", "dpd", "wavetp",
        "seasurfacewaveperiodatvariancespectraldensitymaximum",
    },
}  # fmt: skip
"""Names of the energy period, of m_0/m_1, of the zero-crossing and the peak period; the first is the most certain.

Those of NDBC, CDIP, ERA5, Copernicus and the CF conventions among them.
"""
OCCURRENCE = {
    "occurrence", "occurrences", "percent", "percentage", "%", "hours", "h", "count", "counts", "frequency", "share",
    "probability", "n", "number", "hits", "occ", "freq",
}  # fmt: skip
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
        _check_no_powers(path, line, cells)
        if axes := _corner(path, rows, at):
            return _full(path, rows[at:], axes)
        if columns := _columns(path, rows[at]):
            return _pairs(path, rows[at:], columns)
    return None


def kind_of(name: str) -> str | None:
    """Return which quantity a name of a column is: hs, te, tp, tz, t01 or None."""
    plain = _plain(name)
    return next((kind for kind, spelled in {"hs": HEIGHT, **PERIODS}.items() if plain in spelled), None)


def is_series(names: Iterable[str]) -> bool:
    """Return whether names of columns or variables are those of a series: a height and a period, no occurrence."""
    names = list(names)
    kinds = {kind_of(name) for name in names}
    counted = any(_plain(name) in OCCURRENCE or name.strip(" ()[]").lower() in OCCURRENCE for name in names)
    return "hs" in kinds and bool(kinds & {*PERIODS}) and not counted


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


def _plain(name: str) -> str:
    """A name without unit, case, blanks, underscores and arrows; long text as it is."""
    if len(name) > LONGEST:
        return name
    return re.sub(r"[\s_{}$:\u2190-\u2193]|[\[(].*?[\])]", "", name).lower()


def _check_no_powers(path: str | Path, line: int, cells: list[str]) -> None:
    """Raise of the title of a power matrix, which has the layout of a scatter table."""
    text = " ".join(cells).lower()
    if "power matrix" in text or re.search(r"[\[(]\s*(kw|w|mw)\s*[\])]", text):
        raise ConfigError(
            f"{path}:{line}: received {shortened(repr(' '.join(filter(None, cells))))}, a power matrix; needs "
            "the occurrence of seas"
        )


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
    labels = [row[0] for _, row in body if row[0] and _sum_label(row[0]) is None and len(_trimmed(row)) > 1]
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
    plain = [_plain(cell) or cell.strip(" ()[]").lower() for cell in cells]
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
    plain = _plain(cell).replace(".", "")
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
    widths = {len(_trimmed(row)) for _, row in body if not _sum_label(row[0]) and len(_trimmed(row)) > 1}
    edges = len(labels) >= FEWEST_OF_EDGES and len(body) > 1 and widths == {len(header) - 1}
    across, width = _axis(path, [(first, cell) for _, cell in labels]), len(header)
    if edges:
        across = np.asarray((across[1:] + across[:-1]) / 2, dtype=float)
        labels, width = labels[:-1], width - 1
    read, down, cells, sums, words = Cells(path), [], [], [], []
    for line, row in body:
        if len(_trimmed(row)) == 1 and _bin(row[0]) is None and _sum_label(row[0]) is None:
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


def _trimmed(cells: list[str]) -> list[str]:
    """Cells without empty ones at the end, which a spreadsheet writes."""
    return cells[: max((i + 1 for i, cell in enumerate(cells) if cell), default=0)]


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
    name = _plain(header[at]) or header[at].strip(" ()[]").lower()
    read = Cells(path)
    factors = {key: factor_of(path, first, header[i]) for key, i in columns.items() if key != "occurrence"}
    if (stated := re.findall(r"[\[(](.*?)[\])]", header[at])) and not unit(stated[0]):
        raise ConfigError(f"{path}:{first}: received the unit {stated[0]!r} in {header[at]!r}, needs % or h")
    others = [i for i, cell in enumerate(header) if cell and i not in columns.values()]
    summed = [i for i in others if _plain(header[i]) in DIRECTIONS]
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
