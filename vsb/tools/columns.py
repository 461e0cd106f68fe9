"""Text files of columns: their names, their units, decimal commas, and the lines that are none.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import csv
import re
import zlib
from collections import Counter
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from vsb.errors import ConfigError
from vsb.tools.files import decoded, read_unpacked
from vsb.tools.units import number, unit
from vsb.tools.words import shortened

COMMENT = ("#", "%", "//")
"""Beginnings of lines that are no rows; names and units of the columns may stand there."""
_DAY = r"\d{4}[-/]\d\d?[-/]\d\d?|\d\d?[./]\d\d?[./]\d{4}"
_DATE = re.compile(rf"(?:{_DAY})(?:T\d\d?:\d\d\S*)?")
_SPACED_DATE = re.compile(rf"({_DAY}) +(\d\d?:\d\d(?::\d\d(?:\.\d+)?)?)(?: ?([ap])\.?m\b\.?)?", re.IGNORECASE)
"""Day and time of day, perhaps with AM or PM."""
_ORDERS = ("%Y-%m-%d", "%Y/%m/%d", "%d.%m.%Y", "%m/%d/%Y", "%d/%m/%Y")
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
_WORD = re.compile(r"[^\s\[(]*(?:\s*(?:\[[^\]]*\]|\([^)]*\)))+|\S+")
_OF_MANY = re.compile(r"#?\s*YY(YY)?\s+MM\s+DD\s")
"""Beginning of the header of NDBC's files."""
_LOOSE = {"cm", "mm", "ft", "feet", "ms"}
"""Units of one word that a title may state for all columns."""


class Columns(NamedTuple):
    """Rows of a file with the names and units of its columns."""

    names: tuple[str, ...]  # as written; empty where there is none
    units: tuple[str, ...]  # as written; empty where none is stated
    header: str  # as written, empty if there is none
    rows: list[tuple[int, list[str]]]  # each with its line

    @property
    def plain(self) -> tuple[str, ...]:
        """Names in small letters without blanks, quotes and marks of formulas."""
        return tuple(map(plain_name, self.names))

    def label(self, i: int) -> str:
        """A column in words."""
        stated = f" [{self.units[i]}]" if self.units[i] else ""
        return f"{self.names[i] or f'column {i + 1}'}{stated}"


def plain_name(name: str) -> str:
    """Return the name of a column in small letters without blanks, quotes and marks of formulas."""
    return re.sub(r"[\s_{}$\"'#%\\]", "", name).lower()


def text_of(path: Path, where: str, needed: str) -> str:
    """Return the text of a file, packed with gzip or not; `ConfigError` names its place in a study."""
    try:
        return decoded(read_unpacked(path))
    except (OSError, UnicodeError, EOFError, zlib.error) as error:
        reason = (isinstance(error, OSError) and error.strerror) or "it is no text"
        raise ConfigError(
            f"{where}: received {path.name}, which cannot be read ({reason}); needs a text file of {needed}"
        ) from None


def read_columns(
    path: Path, where: str, needed: str, looked_for: Callable[[str], object] = lambda name: None
) -> Columns:
    """Return the columns of a text file, packed with gzip or not.

    Columns are separated by semicolons, tabs, commas or blanks; numbers may have decimal commas. Lines of names, and
    of units, may stand before the rows, as comments or not. Raises `ConfigError` if the file is no text, rows differ in
    length, or a title states a unit that no column does.

    Parameters
    ----------
    where : str
        Place in the study, for messages about the file as a whole.
    needed : str
        What the file should hold, for messages.
    looked_for : callable, optional
        Whether a name is one that is looked for: a comment with two of them is a line of names.
    """
    lines = [
        (n, _SPACED_DATE.sub(_joined_date, line.strip(" \r\n\ufeff")))
        for n, line in enumerate(text_of(path, where, needed).splitlines(), 1)
        if line.strip(" \t\r\n\ufeff,;")
    ]
    plain = [(n, line) for n, line in lines if not line.startswith(COMMENT)]
    delimiter = _delimiter([line for _, line in plain])
    split = [(n, _cells(line, delimiter)) for n, line in plain]
    data = (i for i, (_, cells) in enumerate(split) if number(cells[0]) is not None or _DATE.fullmatch(cells[0]))
    first = next(data, len(split))
    rows = _even(path, split[first:], needed)
    if not rows:
        return Columns((), (), "", [])
    before = [(n, line) for n, line in lines if n < rows[0][0]]
    names, units, used = _heads(before, delimiter, len(rows[0][1]), looked_for)
    header = " ".join(line for n, line in before if n in used)
    known = [name for name, stated in zip(names, units, strict=True) if not stated or unit(stated)]
    enough = sum(bool(looked_for(name)) for name in known) > 1  # temperatures and the like may stand beside
    for name, stated in zip(names, units, strict=True):
        if not enough and stated and unit(stated) is None:
            raise ConfigError(
                f"{path}:{max(used)}: received the unit {shortened(repr(stated))} of {name or 'a column'}, needs "
                "lengths, times, frequencies and their products, such as m, cm, s, Hz, rad/s, m^2/Hz, m^2 s/rad"
            )
    if not all(units):
        _check_titles(path, [(n, line) for n, line in before if n not in used])
    return Columns(names, units, header, rows)


def _joined_date(spaced: re.Match[str]) -> str:
    """A date without blanks."""
    day, clock, half = spaced.groups()
    return f"{day}T{clock}{half.upper() + 'M' if half else ''}"


def _heads(
    before: list[tuple[int, str]], delimiter: str, width: int, looked_for: Callable[[str], object]
) -> tuple[tuple[str, ...], tuple[str, ...], set[int]]:
    """Names and units of the columns from the lines before the rows, and the numbers of these lines.

    A comment is a line of names only if it states a unit or has two that are looked for: most comments are words.
    """
    names: tuple[int, list[tuple[str, str]]] | None = None
    units: tuple[int, list[str]] | None = None
    known = 0
    for n, line in before:
        cells = trimmed(_cells(line.lstrip("#%/ "), delimiter))
        if len(cells) != width:
            continue
        pairs = [_stated(cell) for cell in cells]
        here = sum(bool(looked_for(name)) for name, _ in pairs)
        if _all_units(cells) or known > 1 > here:  # a line of units may leave some out
            units = n, [_unit_alone(cell) for cell in cells]
        elif not line.startswith(COMMENT) or here > 1 or any(stated for _, stated in pairs):
            names, units, known = (n, pairs), None, here
    named = names[1] if names else [("", "")] * width
    below = units[1] if units else [""] * width
    return (
        tuple(name for name, _ in named),
        tuple(stated or lower for (_, stated), lower in zip(named, below, strict=True)),
        {found[0] for found in (names, units) if found},
    )


def dates(cells: Sequence[str]) -> list[datetime]:
    """Return cells as dates in universal time; none if they are no dates, or may be of two orders of day and month."""
    zoned = [  # universal time where no zone is stated
        cell if re.search(r"T.*(Z|[-+]\d\d:?\d\d)$", cell) else f"{cell}{'' if 'T' in cell else 'T00:00'}Z"
        for cell in cells
    ]
    try:
        return [datetime.fromisoformat(cell).astimezone(UTC).replace(tzinfo=None) for cell in zoned]
    except ValueError:
        pass
    found = [days for order in _ORDERS if (days := _in_order(cells, order))]
    return found[0] if len(found) == 1 else []


def _in_order(cells: Sequence[str], order: str) -> list[datetime]:
    """Cells as dates of an order of year, month and day, none if one of them is not."""
    found = []
    for cell in cells:
        clock = "T%H:%M:%S.%f" if "." in cell[11:] else "T%H:%M:%S" if cell.count(":") == 2 else "T%H:%M"
        if cell.endswith(("AM", "PM")):
            clock = clock.replace("%H", "%I") + "%p"
        try:
            found.append(datetime.strptime(cell, order + clock if "T" in cell else order))
        except ValueError:
            return []
    return found


def _delimiter(lines: Sequence[str]) -> str:
    """What separates cells: a semicolon, a tab, a comma, or blanks (empty)."""
    for delimiter in (";", "\t"):
        if any(delimiter in line for line in lines):
            return delimiter
    data = [line for line in lines if line[0] in "+-.0123456789"]
    if not any("," in line for line in data or lines):
        return ""
    split = [line.split() for line in data if "." not in line]
    commas = all(len(row) > 1 and all("," not in one or _DECIMAL_COMMA.fullmatch(one) for one in row) for row in split)
    decimal = bool(data) and len(split) == len(data) and commas
    return "" if decimal else ","


def _cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line; a name keeps the unit in brackets behind it."""
    if not delimiter or delimiter not in line:
        return [cell.strip('"') for cell in (_WORD.findall(line) if line[:1].isalpha() else line.split())]
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
    except csv.Error:
        return [cell.strip() for cell in line.split(delimiter)]


def trimmed(cells: list[str]) -> list[str]:
    """Return cells without empty ones at the end, which a spreadsheet writes."""
    last = max((i for i, cell in enumerate(cells) if cell), default=-1)
    return cells[: last + 1]


def _even(path: Path, rows: list[tuple[int, list[str]]], needed: str) -> list[tuple[int, list[str]]]:
    """Rows of equal length, without columns at the end that are empty throughout."""
    if not rows:
        return rows
    width = max(len(trimmed(cells)) for _, cells in rows)
    usual = Counter(min(len(cells), width) for _, cells in rows).most_common(1)[0][0]
    for n, cells in rows:
        if len(trimmed(cells)) > usual or len(cells) < usual:
            raise ConfigError(
                f"{path}:{n}: received {shortened(repr(' '.join(cells)))}, needs {usual} cells as the other rows have: "
                f"{needed}"
            )
    return [(n, cells[:usual]) for n, cells in rows]


def _stated(cell: str) -> tuple[str, str]:
    """Name and unit of a cell such as `S [m^2/Hz]`, `S (m^2/Hz)`, `S, m^2/Hz` or `time_s`."""
    if square := re.fullmatch(r"(.*?)\s*\[(.*)\]", cell):
        return square[1], square[2].strip()
    if (round_ := re.fullmatch(r"(.*?)\s*\((.*)\)", cell)) and (unit(round_[2]) or re.search(r"[/^]", round_[2])):
        return round_[1], round_[2].strip()
    if (spaced := re.fullmatch(r"(\w{3,})(?:, *|[ _])(\S+)", cell)) and unit(spaced[2]):
        return spaced[1], spaced[2]
    return ("", cell) if re.search(r"[/^²]|^hz$", cell.lower()) and unit(cell) else (cell, "")


def _unit_alone(cell: str) -> str:
    """The unit a cell is, in brackets or not; empty if it is none."""
    bare = re.sub(r"^[\[(](.*)[\])]$", r"\1", cell).strip()
    return bare if unit(bare) else ""


def _all_units(cells: list[str]) -> bool:
    """Whether the cells of a line are units, and one of them cannot be a name."""
    there = [cell for cell in cells if cell]
    certain = (len(cell) > 2 or cell.lower() in ("hz", "cm", "mm", "ft", "ms") for cell in there)
    return bool(there) and all(map(_unit_alone, there)) and any(certain)


def _check_titles(path: Path, titles: list[tuple[int, str]]) -> None:
    """Raise where a line that is not read states a unit other than those columns have where they state none."""
    for n, line in titles:
        if _OF_MANY.match(line):
            raise ConfigError(
                f"{path}:{n}: received many records, a row each, as NDBC writes them; needs one of them here; all of "
                "them are the climate of a campaign"
            )
        words = [*re.findall(r"[\[(](.*?)[\])]", line), *(word.strip(",.:;()[]\"'") for word in line.split())]
        for word in words:
            compound = re.search(r"[/^²]", word) and word.lower() not in ("m2/hz", "m^2/hz", "m²/hz", "m**2/hz")
            if (compound or word.lower() in _LOOSE) and unit(word):
                raise ConfigError(
                    f"{path}:{n}: received {shortened(repr(line))}, which states {word!r}, but not of which column; "
                    "needs units in the names of the columns, such as time [s]"
                )
