"""Spectra from files: text of the National Data Buoy Center, netCDF in wavespectra's names, and formats it reads."""

from collections import Counter
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray
from vsb.tools.bounded import bounded_reading, open_regular
from vsb.tools.files import read_text
from vsb.waves.climate import PARTIAL, Climate, of_records

if TYPE_CHECKING:
    import numpy.typing as npt
    import xarray as xr

MISSING, NONE = 999.0, {"MM": "999.0"}
"""Numbers of the text from which on a value is missing, and words for missing values."""
HIGHEST_HZ = 5.0
"""Highest possible band [Hz]."""
DATE = ("YY", "MM", "DD", "hh", "mm")
FREQUENCY = {"hz", "s-1", "s^-1", "s^{-1}", "1/s"}
DENSITY = {
    False: {"m2/hz", "m^2/hz", "m2s", "m^2s", "m^{2}s", "m**2/hz", "m2hz-1", "m**2s"},
    True: {
        "m2/hz/degree", "m^2/hz/degree", "m2s/degree", "m2sdegree-1", "m^{2}.s.degree^{-1}", "m2hz-1degree-1",
        "m2/hz/deg",
    },
}  # fmt: skip
"""Units of spectral density, without and with directions."""
READERS = {"d2fd": "era5", "spectral_wave_density": "ndbc", "waveEnergyDensity": "ndbc", "density": "ncswan"}
"""Variables of other netCDF files of spectra, and wavespectra's reader for them."""
SWAN = b"SWAN"
"""First characters of SWAN's text."""
METEOROLOGICAL = {"WVHT", "SWVHT", "WSPD"}
"""Columns of the National Data Buoy Center's files without spectra."""


def read_ndbc(path: str | Path) -> Climate:
    """Return the climate of a text file of spectral densities, packed with gzip or not.

    Parameters
    ----------
    path : path
        Header `YY MM DD hh [mm]` and the frequencies [Hz]; rows of a date and densities [m^2/Hz], 999 or MM for none.
        Or `.data_spec`: rows of a date, a separation frequency and densities each with its frequency in brackets.

    Raises
    ------
    ConfigError
        With file, line, value received and value needed.
    """
    lines = [(i, line.split()) for i, line in enumerate(read_text(path).splitlines(), 1) if line.strip()]
    head = lines[0][1] if lines else []
    rows = [(i, row) for i, row in lines[1:] if not row[0].startswith("#")]
    if not rows:
        raise ConfigError(f"{path}: received {len(lines)} lines, needs a header with frequencies and rows of spectra")
    if METEOROLOGICAL & {*head}:
        raise ConfigError(
            f"{path}: received the buoy's meteorological data, which holds no spectra; needs its spectral wave density"
        )
    for i, row in lines[1:]:
        if row[0].lstrip("#") == head[0].lstrip("#") and row[1:] != head[1:]:
            raise ConfigError(f"{path}, line {i}: received another header, needs one set of frequencies: cut the file")
    if head[5:6] == ["Sep_Freq"]:
        hertz, rows = _bracketed(path, rows)
        dates = 5
    else:
        dates, hertz = _header(path, head)
    for i, row in rows:
        if len(row) != dates + len(hertz):
            raise ConfigError(
                f"{path}, line {i}: received {len(row)} columns, needs {dates + len(hertz)} as the header has; "
                "a cut line, or frequencies written beside densities"
            )
    times = [_time(path, i, row[:dates]) for i, row in rows]
    values = _numbers(path, [(i, [NONE.get(word, word) for word in row[dates:]]) for i, row in rows])
    density = np.where(values >= MISSING, np.nan, values) / (2 * np.pi)
    kept, notes = _calendar(times)
    return of_records(2 * np.pi * hertz, density[kept], Path(path).name, notes)


def _bracketed(path: str | Path, rows: list[tuple[int, list[str]]]) -> tuple[FloatArray, list[tuple[int, list[str]]]]:
    """Frequencies [Hz] in brackets behind the densities of a `.data_spec` file, the same in all rows; rows without."""
    first = rows[0][1][7::2]
    for i, row in rows:
        if row[7::2] != first or len(row) % 2:
            raise ConfigError(
                f"{path}, line {i}: received other frequencies than line {rows[0][0]}, needs the same: cut the file"
            )
    hertz = _ascending(path, rows[0][0], [word.strip("()") for word in first])
    return hertz, [(i, [*row[:5], *row[6::2]]) for i, row in rows]


def _header(path: str | Path, words: list[str]) -> tuple[int, FloatArray]:
    """Number of columns of the date, and the frequencies [Hz]."""
    names = [words[0].lstrip("#").replace("YYYY", "YY"), *words[1:]]
    dates = 5 if names[:5] == list(DATE) else 4
    if names[:dates] != list(DATE[:dates]):
        raise ConfigError(
            f"{path}, line 1: received {' '.join(words[:6])!r}, needs YY MM DD hh [mm] and the frequencies in Hz"
        )
    return dates, _ascending(path, 1, names[dates:])


def _ascending(path: str | Path, line: int, words: list[str]) -> FloatArray:
    """Words as ascending frequencies [Hz]."""
    hertz: FloatArray = _numbers(path, [(line, words)])[0]
    if len(hertz) < 2 or hertz[0] <= 0 or np.any(np.diff(hertz) <= 0) or hertz[-1] > HIGHEST_HZ:
        received = f"{len(hertz)} frequencies" + (f" from {hertz[0]:g} to {hertz[-1]:g}" if len(hertz) else "")
        raise ConfigError(f"{path}, line {line}: received {received}, needs them ascending, above 0, in Hz")
    return hertz


def _numbers(path: str | Path, rows: list[tuple[int, list[str]]]) -> FloatArray:
    """Rows of words as numbers, shape (row, column)."""
    try:
        values: FloatArray = np.array([row for _, row in rows], dtype=float)
    except ValueError:
        line, word = next((i, word) for i, row in rows for word in row if not _is_number(word))
        raise ConfigError(f"{path}, line {line}: received {word!r}, needs a number") from None
    if not np.all(np.isfinite(values)) or (values.size and values.min() < 0):
        at, column = np.argwhere(~(values >= 0) | ~np.isfinite(values))[0]
        raise ConfigError(
            f"{path}, line {rows[at][0]}: received {rows[at][1][column]}, needs a number of 0 or more (999 for none)"
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
        raise ConfigError(
            f"{path}, line {line}: received the date {' '.join(words)!r}, needs YY MM DD hh [mm]"
        ) from None


def _calendar(times: list[datetime]) -> tuple[list[int], list[str]]:
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


def read_spectra(path: str | Path) -> Climate:
    """Return the climate of a netCDF file of spectra with the names of wavespectra, or of one that wavespectra reads.

    Parameters
    ----------
    path : path
        `efth(time, freq, dir)` [m^2/Hz/degree] or `efth(time, freq)` [m^2/Hz], `freq` [Hz], `dir` [degree]; one site.
        By wavespectra: netCDF of WAVEWATCH III, SWAN, ERA5 and the National Data Buoy Center, and SWAN's text.

    Raises
    ------
    ConfigError
        With file, name, value received and value needed.
    """
    import xarray as xr  # here alone: text needs none

    try:
        with open_regular(path) as file:
            begin = file.read(len(SWAN))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    if begin == SWAN:
        stored = _by_wavespectra(path, "swan")
    else:
        try:
            with bounded_reading(path), xr.open_dataset(path, engine="netcdf4") as ds:
                stored = ds.load()
        except MemoryError:
            raise ConfigError(f"{path}: cannot be read as netCDF (it announces more than it holds)") from None
        except Exception as error:  # libraries raise errors of many types for damaged files
            reason = " ".join(str(error).split()) or type(error).__name__
            raise ConfigError(f"{path}: cannot be read as netCDF ({reason})") from None
        names = {"ww3"} if {"efth", "frequency"} <= {*stored.variables} else set()
        names |= {READERS[name] for name in READERS if name in stored.variables and "efth" not in stored.variables}
        stored = _by_wavespectra(path, min(names)) if names else stored
    for name in ("efth", "freq"):
        if name not in stored.variables:
            raise ConfigError(f"{path}: received variables {sorted(map(str, stored.variables))}, needs {name}")
    for name in ("efth", "freq", "dir"):
        if name in stored.variables and stored[name].dtype.kind not in "iuf":
            raise ConfigError(f"{path}: received {name} of type {stored[name].dtype}, needs numbers")
    spectra = stored.efth
    for name in [name for name in spectra.dims if name not in ("time", "freq", "dir")]:
        if spectra.sizes[name] != 1:
            raise ConfigError(f"{path}: received {spectra.sizes[name]} along {name}, needs one: select a site")
        spectra = spectra.isel({name: 0})
    directional = "dir" in spectra.dims
    _check_units(path, stored, directional)
    if directional:
        spectra = spectra * _direction_widths(path, stored.dir.values)
        spectra = spectra.sum("dir", skipna=False)
    hertz = np.asarray(stored.freq.values, dtype=float)
    if "time" not in spectra.dims or len(hertz) < 2 or hertz[0] <= 0 or np.any(np.diff(hertz) <= 0):
        raise ConfigError(f"{path}: received efth over {spectra.dims}, needs time and ascending freq above 0 Hz")
    density = spectra.transpose("time", "freq").values.astype(float) / (2 * np.pi)
    kept, notes = _calendar(_dates(path, stored.time.values))
    return of_records(2 * np.pi * hertz, density[kept], Path(path).name, notes)


def _by_wavespectra(path: str | Path, reader: str) -> "xr.Dataset":
    """Spectra in wavespectra's names and units, read by its reader of that name; without directions if possible.

    Raises
    ------
    ConfigError
        If wavespectra is not installed, or cannot read the file.
    """
    try:
        import wavespectra
    except ImportError:
        raise ConfigError(
            f"{path}: received spectra as {reader} writes them, needs the package wavespectra to read them: "
            "pip install 'vsb[spectra]'"
        ) from None
    options = {"directional": False} if reader == "ndbc" else {}
    try:
        found = getattr(wavespectra, f"read_{reader}")(str(path), **options).load()
    except (OSError, ValueError, KeyError, IndexError, RuntimeError, AttributeError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(f"{path}: cannot be read by wavespectra's read_{reader} ({reason})") from None
    found["efth"].attrs.pop("units", None)  # says per degree even without directions
    return found.sortby("freq")  # type: ignore[no-any-return]


def _dates(path: str | Path, time: "npt.NDArray[np.generic]") -> list[datetime]:
    """Dates of the records, one or more; plain numbers are refused."""
    if not time.size:
        raise ConfigError(f"{path}: received no record along time, needs one or more")
    try:
        if time.dtype.kind in "MO":
            return [datetime.fromisoformat(str(each)[:19]) for each in time.astype("datetime64[s]")]
    except ValueError:
        pass  # not a date
    raise ConfigError(
        f"{path}: received time from {time[0]} to {time[-1]}, needs a date for every record, in units such as 'hours "
        "since 2020-01-01'"
    )


def _check_units(path: str | Path, ds: "xr.Dataset", directional: bool) -> None:
    """Check units where the file states them."""
    for name, known in (("freq", FREQUENCY), ("efth", DENSITY[directional])):
        units = str(ds[name].attrs.get("units", ""))
        if units and units.lower().replace(" ", "").replace("degrees", "degree") not in known:
            needed = "Hz" if name == "freq" else "m2/Hz/degree" if directional else "m2/Hz"
            raise ConfigError(f"{path}: received {name} in {units!r}, needs {needed}")


def _direction_widths(path: str | Path, degrees: FloatArray) -> "xr.DataArray":
    """Widths of bands of direction [degree], which must be equal all around."""
    steps = np.diff(np.sort(np.asarray(degrees, dtype=float) % 360), append=np.sort(degrees % 360)[0] + 360)
    if not np.ptp(steps) <= 1e-3 * steps.mean():
        raise ConfigError(
            f"{path}: received directions {steps.min():.4g} to {steps.max():.4g} degrees apart, needs equal distances "
            "all around"
        )
    import xarray as xr

    return xr.DataArray(np.full(len(degrees), 360 / len(degrees)), dims="dir")
