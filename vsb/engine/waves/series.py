"""Series of heights and periods, counted into cells of seas: text of columns, and netCDF of reanalyses and buoys."""

import re
from datetime import datetime
from pathlib import Path

import numpy as np

from vsb.engine.waves.climate import FEW, TINY
from vsb.engine.waves.measured_spectra import ERA5, NAMES, NETCDF, dates_of, first_bytes, load_netcdf
from vsb.engine.waves.ndbc import DATE, calendar
from vsb.engine.waves.records import HIGHEST_SEA
from vsb.engine.waves.scatter_table import PERIODS, Table, is_series, kind_of
from vsb.errors import ConfigError
from vsb.tools import units
from vsb.tools.arrays import FloatArray
from vsb.tools.columns import Columns, dates, read_columns
from vsb.tools.files import read_text
from vsb.tools.units import number
from vsb.tools.words import shortened

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
        hs, period, notes = hs[kept], period[kept], [*remarks, *notes]
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
    notes.append(f"{len(hs)} records, {int((~there).sum())} with missing values or no waves left out")
    if there.mean() < 0.5:
        notes.append(f"{int(there.sum())} of {len(hs)}: {FEW}")
    return _counted(hs[there], period[there], kind, notes)


def _names_series(line: str) -> bool:
    """Whether a line names columns of a height and a period: words alone."""
    for between in (r"[;\t]", ",", r"\s+(?![\[(])"):
        cells = re.split(between, line)
        if is_series(cells) and not any(number(cell.strip()) is not None for cell in cells):
            return True
    return False


def _counted(hs: FloatArray, period: FloatArray, kind: str, notes: list[str]) -> Table:
    """Occupied cells of bins of height and period."""
    places = np.column_stack([np.floor(hs / HEIGHT_STEP), np.floor(period / PERIOD_STEP)])
    _, cell = np.unique(places, axis=0, return_inverse=True)
    count, energy, weighted = (np.bincount(cell.ravel(), weights) for weights in (None, hs**2, hs**2 * period))
    notes = [*notes, f"counted in bins of {HEIGHT_STEP:g} m and {PERIOD_STEP:g} s, their mean energy and flux kept"]
    return Table(np.sqrt(energy / count), weighted / energy, kind, count.astype(float), None, tuple(notes))


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
        found.append(factor * np.array([_value(path, line, cells[i]) for line, cells in table.rows]))
    times, of_time = _times(table)
    if left := [table.label(i) for i, name in enumerate(table.names) if name not in used and i not in of_time]:
        notes.append(f"columns left out: {', '.join(left)}")
    return found[0], found[1], kind, times, notes


def _value(path: str | Path, line: int, cell: str) -> float:
    """A number, NaN where it is missing."""
    value = np.nan if cell.strip().lower() in WORDS else number(cell)
    if value is None:
        raise ConfigError(
            f"{path}:{line}: received {shortened(repr(cell))}, needs a number, or nothing where it is missing"
        )
    return value


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
