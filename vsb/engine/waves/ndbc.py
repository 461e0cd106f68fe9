"""Spectra in the text files of the National Data Buoy Center."""

import re
from collections import Counter
from datetime import datetime
from itertools import pairwise
from pathlib import Path

import numpy as np

from vsb.engine.waves.climate import PARTIAL, Climate, of_records
from vsb.engine.waves.scatter_table import is_series
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray
from vsb.tools.files import read_text
from vsb.tools.words import shortened

MISSING, NONE = 999.0, {"MM": "999.0"}
"""Numbers of the text from which on a value is missing, and words for missing values."""
HIGHEST_HZ = 5.0
"""Highest possible band [Hz]."""
DATE = ("YY", "MM", "DD", "hh", "mm")
SERIES = (
    "which are series of heights and periods, no spectra; needs spectra, or climate: {scatter: FILE}, which counts the "
    "series into a table of seas of one spectrum"
)
"""What is said of files of heights and periods where spectra are needed."""
METEOROLOGICAL = {"WVHT", "SWVHT", "WSPD"}
"""Columns of the National Data Buoy Center's files without spectra."""
DIRECTIONAL = {
    "alpha1": "mean directions (swdir)", "alpha2": "principal directions (swdir2)",
    "r1": "the first directional coefficient r1 (swr1)", "r2": "the second directional coefficient r2 (swr2)",
}  # fmt: skip
"""What the National Data Buoy Center's files beside those of densities hold, by their headers."""
BOUNDED = {
    1.0: "directional coefficients r1 or r2 (swr1, swr2)",
    100.0: "directional coefficients r1 or r2 in hundredths (swr1, swr2)",
    360.0: "directions in degrees (swdir, swdir2)",
}
"""Likewise by their largest number; their headers are those of densities."""
EVEN, FEW_BANDS = 0.1, 10
"""Median over the largest number from which on numbers are no densities, which differ by magnitudes; bands needed."""


def read_ndbc(path: str | Path) -> Climate:
    """Return the climate of a text file of spectral densities, packed with gzip or not.

    Raises `ConfigError` with file, line, value received and value needed.

    Parameters
    ----------
    path : path
        Header `YY MM DD hh [mm]` and the frequencies [Hz]; rows of a date and densities [m^2/Hz], 999 or MM for none.
        Or `.data_spec`: rows of a date, a separation frequency and densities each with its frequency in brackets.
    """
    lines = [(i, line.split()) for i, line in enumerate(read_text(path).splitlines(), 1) if line.strip()]
    head = lines[0][1] if lines else []
    rows = [(i, row) for i, row in lines[1:] if not row[0].startswith("#")]
    if not rows:
        raise ConfigError(f"{path}: received {len(lines)} lines, needs a header with frequencies and rows of spectra")
    if METEOROLOGICAL & {*head}:
        raise ConfigError(
            f"{path}: received the buoy's meteorological data, which holds no spectra; needs its spectral wave "
            "density, or climate: {scatter: FILE}, which counts WVHT and DPD into a table of seas of one spectrum"
        )
    if is_series(re.split(r"[,;\s]+", " ".join(head))):
        raise ConfigError(f"{path}:1: received {shortened(repr(' '.join(head)))}, {SERIES}")
    for i, row in lines[1:]:
        if row[0].lstrip("#") == head[0].lstrip("#") and row[1:] != head[1:]:
            raise ConfigError(f"{path}:{i}: received another header, needs one set of frequencies: cut the file")
    if meant := DIRECTIONAL.get(head[5].split("_")[0] if len(head) > 5 else ""):
        raise ConfigError(f"{path}:1: received {meant}, no densities; needs the spectral wave density (swden)")
    if head[5:6] == ["Sep_Freq"]:
        hertz, rows = _bracketed(path, rows)
        dates = 5
    else:
        dates, hertz = _header(path, head)
    for i, row in rows:
        if len(row) != dates + len(hertz):
            raise ConfigError(
                f"{path}:{i}: received {len(row)} columns, needs {dates + len(hertz)} as the header has; "
                "a cut line, or frequencies written beside densities"
            )
    times = [_time(path, i, row[:dates]) for i, row in rows]
    values = _numbers(path, [(i, [NONE.get(word, word) for word in row[dates:]]) for i, row in rows])
    density = np.where(values >= MISSING, np.nan, values) / (2 * np.pi)
    _check_densities(path, 2 * np.pi * density)
    kept, notes = calendar(times)
    return of_records(2 * np.pi * hertz, density[kept], Path(path).name, notes)


def _check_densities(path: str | Path, values: FloatArray) -> None:
    """Raise where numbers are no densities but bounded quantities of direction, whose files look the same."""
    known = values[~np.isnan(values)]
    if not known.size or values.shape[1] < FEW_BANDS or np.median(known) < EVEN * known.max():
        return
    if meant := next((meant for largest, meant in BOUNDED.items() if known.max() <= largest), ""):
        raise ConfigError(
            f"{path}: received numbers up to {known.max():g} with a median of {np.median(known):.3g}, which are "
            f"{meant}, no densities; needs the spectral wave density (swden)"
        )


def _bracketed(path: str | Path, rows: list[tuple[int, list[str]]]) -> tuple[FloatArray, list[tuple[int, list[str]]]]:
    """Frequencies [Hz] in brackets behind the densities of a `.data_spec` file, the same in all rows; rows without."""
    first = rows[0][1][7::2]
    for i, row in rows:
        if row[7::2] != first or len(row) % 2:
            raise ConfigError(
                f"{path}:{i}: received other frequencies than line {rows[0][0]}, needs the same: cut the file"
            )
    hertz = _ascending(path, rows[0][0], [word.strip("()") for word in first])
    return hertz, [(i, [*row[:5], *row[6::2]]) for i, row in rows]


def _header(path: str | Path, words: list[str]) -> tuple[int, FloatArray]:
    """Number of columns of the date, and the frequencies [Hz]."""
    names = [words[0].lstrip("#").replace("YYYY", "YY"), *words[1:]]
    dates = 5 if names[:5] == list(DATE) else 4
    if names[:dates] != list(DATE[:dates]):
        raise ConfigError(
            f"{path}:1: received {shortened(repr(' '.join(words[:6])))}; needs NDBC's header, YY MM DD hh [mm] and the "
            "frequencies in Hz, or netCDF, SWAN, WAVEWATCH III, TRIAXYS, Datawell; series of heights and periods are a "
            "climate: {scatter: FILE}, one spectrum or record stands in the waves of a study"
        )
    return dates, _ascending(path, 1, names[dates:])


def _ascending(path: str | Path, line: int, words: list[str]) -> FloatArray:
    """Words as ascending frequencies [Hz]."""
    hertz: FloatArray = _numbers(path, [(line, words)])[0]
    if len(hertz) < 2 or hertz[0] <= 0 or np.any(np.diff(hertz) <= 0) or hertz[-1] > HIGHEST_HZ:
        received = f"{len(hertz)} frequencies" + (f" from {hertz[0]:g} to {hertz[-1]:g}" if len(hertz) else "")
        raise ConfigError(f"{path}:{line}: received {received}, needs them ascending, above 0, in Hz")
    return hertz


def _numbers(path: str | Path, rows: list[tuple[int, list[str]]]) -> FloatArray:
    """Rows of words as numbers, shape (row, column)."""
    try:
        values: FloatArray = np.array([row for _, row in rows], dtype=float)
    except ValueError:
        line, word = next((i, word) for i, row in rows for word in row if not _is_number(word))
        raise ConfigError(f"{path}:{line}: received {word!r}, needs a number") from None
    if not np.all(np.isfinite(values)) or (values.size and values.min() < 0):
        at, column = np.argwhere(~(values >= 0) | ~np.isfinite(values))[0]
        raise ConfigError(
            f"{path}:{rows[at][0]}: received {rows[at][1][column]}, needs a number of 0 or more (999 for none)"
        )
    return values


def _is_number(word: str) -> bool:
    """Whether a word is a number."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _time(path: str | Path, line: int, words: list[str]) -> datetime:
    """Date of a row; of two digits of the year, 70 and above are of the last century."""
    try:
        year, month, day, *hour = (int(word) for word in words)
        century = 1900 if 70 <= year < 100 else 2000 if year < 70 else 0
        return datetime(century + year, month, day, hour[0], hour[1] if len(hour) > 1 else 0)
    except (TypeError, ValueError):
        raise ConfigError(f"{path}:{line}: received the date {' '.join(words)!r}, needs YY MM DD hh [mm]") from None


def calendar(times: list[datetime]) -> tuple[list[int], list[str]]:
    """Indices of the records to keep, the first of each instant, and notes on gaps of the calendar."""
    first = {time: i for i, time in reversed(list(enumerate(times)))}
    order = sorted(first)
    notes = [f"{order[0]:%Y-%m-%d %H:%M} to {order[-1]:%Y-%m-%d %H:%M}"]
    if len(first) < len(times):
        notes.append(f"{len(times) - len(first)} records of an instant that has one already left out")
    steps = [(b - a).total_seconds() for a, b in pairwise(order)]
    if steps:
        usual = Counter(steps).most_common(1)[0][0]
        lacking = sum(round(step / usual) - 1 for step in steps if step > usual)
        notes.append(f"one record per {usual / 3600:g} h, {lacking} of them not in the file")
        if (uneven := sum(step < usual for step in steps)) > 0:
            notes.append(f"{uneven} records closer than that count as much as the others")
        days = (order[-1] - order[0]).total_seconds() / 86400
        if days < 360:
            notes.append(f"{days:.0f} days {PARTIAL}: seasons are missing")
    return sorted(first.values()), notes
