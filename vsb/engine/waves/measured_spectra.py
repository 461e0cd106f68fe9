"""Spectra from files: netCDF of any program that states their units, formats that wavespectra reads, NDBC's text.

The units decide, not the name of the program: densities are per Hz, and with directions per degree or per radian.
"""

import gzip
import re
import warnings
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vsb.engine.waves.climate import Climate, band_edges, is_series, of_records
from vsb.errors import ConfigError
from vsb.tools import units
from vsb.tools.arrays import FloatArray
from vsb.tools.files import bounded_reading, files_of, open_regular, read_text, read_unpacked
from vsb.tools.units import is_number
from vsb.tools.words import shortened

if TYPE_CHECKING:
    import numpy.typing as npt
    import xarray as xr

NAMES = {
    "efth": ("efth", "ef", "spectral_wave_density", "waveEnergyDensity", "density"),
    "freq": ("freq", "frequency", "waveFrequency"),
    "dir": ("dir", "direction"),
    "time": ("time", "waveTime"),
}
"""Names of wavespectra, WAVEWATCH III, SWAN, the National Data Buoy Center and CDIP; the first of each is ours."""
FLAGS, USABLE = "waveFlagPrimary", (1, 2)
"""CDIP's verdict on each record, and its values good and not evaluated."""
NETCDF = (b"CDF", b"\x89HDF")
"""First characters of netCDF."""
TEXTS = {b"SWAN": "swan", b"'WAVEWATCH III": "ww3_station", b"TRIAXYS BUOY": "triaxys"}
"""First characters of texts that wavespectra reads, and the name of its reader."""
DATAWELL = ".spt"
"""End of the names of Datawell's files."""
_BEFORE = 12  # lines of a Datawell file before its spectrum
STATED = 0.05
"""Relative difference allowed between the height a file of a buoy states and that of its spectrum."""
OTHER_GRID = "received other frequencies or directions than {} has; needs files of one buoy with one setting"
MOST_FILES = 20_000
"""Files of a folder: a year of half-hours is 17 568."""
EXPECTED = {
    "swan": "two-dimensional spectra as SWAN writes them",
    "ww3_station": "spectra of one point as WAVEWATCH III writes them",
    "triaxys": "a whole file of a TRIAXYS buoy, with its date, number, first value and spacing of frequencies",
    "datawell": "a whole file of a Datawell buoy, with its date in its name as BUOY}2020-01-01T00h00Z.spt",
    "era5": "ERA5's spectra d2fd over time, direction and frequency",
}
"""What is needed of a file for a reader of wavespectra."""
ERA5 = "d2fd"
"""Variable of ERA5: decimal logarithms."""


def read_spectra(path: str | Path) -> Climate:
    """Return the climate of spectra of one site: netCDF, SWAN's text, or else the text of `read_ndbc`.

    A folder may hold files of one buoy, a record each or more, in one format and at the same frequencies.

    Raises `ConfigError` with file, name, value received and value needed.

    Parameters
    ----------
    path : path
        Density over time, frequency [Hz] and perhaps direction, by one of `NAMES`, in m^2/Hz, m^2/Hz/degree or
        m^2/Hz/radian as its units say; Datawell's text; by wavespectra, netCDF of ERA5 and the texts of SWAN, WAVEWATCH
        III and TRIAXYS.
    """
    stored = _joined(path) if Path(path).is_dir() else _stored(path)
    if stored is None:
        return read_ndbc(path)
    notes = []
    if stored.freq.size and float(stored.freq[0]) == 0:
        stored, notes = stored.isel(freq=slice(1, None)), ["the band at 0 Hz left out"]
    spectra, hertz = stored.efth, np.asarray(stored.freq.values, dtype=float)
    if {"time", "freq"} - {*spectra.dims} or len(hertz) < 2 or not hertz[0] > 0 or not np.all(np.diff(hertz) > 0):
        over = ", ".join(map(str, spectra.dims))
        raise ConfigError(f"{path}: received spectra over {over}, needs time and two frequencies or more above 0 Hz")
    for name in [name for name in spectra.dims if name not in ("time", "freq", "dir")]:
        if spectra.sizes[name] != 1:
            raise ConfigError(f"{path}: received {spectra.sizes[name]} along {name}, needs one: select a site")
        spectra = spectra.isel({name: 0})
    if "dir" in spectra.dims:
        first, last = float(spectra.dir[0]), float(spectra.dir[-1])
        if len(spectra.dir) > 1 and last - first == 360.0:  # it repeats the first
            spectra = spectra.isel(dir=slice(0, -1))
        _check_all_around(path, spectra.dir.values)
        spectra = spectra.mean("dir", skipna=False) * 2 * np.pi
    density = spectra.transpose("time", "freq").values.astype(float) / (2 * np.pi)
    times = dates_of(path, stored.time.values)
    kept, dates = calendar(times)
    notes = [*dates, *notes]
    if FLAGS in stored:
        unusable = ~np.isin(stored[FLAGS].values, USABLE)
        density[unusable] = np.nan
        notes += [f"{int(unusable.sum())} records not used for their {FLAGS}"] if unusable.any() else []
    return of_records(2 * np.pi * hertz, density[kept], Path(path).name, notes, [times[i] for i in kept])


def _stored(path: str | Path) -> "xr.Dataset | None":
    """Spectra of one file in our names and units; None of a file that may be NDBC's text."""
    begin = first_bytes(path)
    if begin.startswith(NETCDF):
        return _per_hertz(path, _opened(path))
    if reader := next((name for start, name in TEXTS.items() if start in begin), ""):
        return _per_hertz(path, _by_wavespectra(path, reader))
    if Path(path).suffix.lower() == DATAWELL:
        return _per_hertz(path, _of_datawell([Path(path)]))
    return None


def _joined(folder: str | Path) -> "xr.Dataset":
    """Spectra of all files of a folder, which are of one buoy, along time."""
    import xarray as xr

    files, found = files_of(folder), list[xr.DataArray]()
    if not 0 < len(files) <= MOST_FILES:
        raise ConfigError(f"{folder}: received a folder of {len(files)} files; needs 1 to {MOST_FILES} of spectra")
    if all(file.suffix.lower() == DATAWELL for file in files):
        return _per_hertz(folder, _of_datawell(files))
    for file in files:
        if (stored := _stored(file)) is None or "time" not in stored.efth.dims:
            raise ConfigError(
                f"{file}: received a file that is no {DATAWELL}, TRIAXYS, SWAN, WAVEWATCH III or netCDF; needs these "
                "alone in a folder: move it, and join NDBC's texts to one file"
            )
        one = stored.efth.reset_coords(drop=True)
        over = [
            sorted(each.sizes) + [each[name].values.tolist() for name in ("freq", "dir") if name in each.dims]
            for each in (one, *found[:1])
        ]
        if over[0] != over[-1]:
            raise ConfigError(f"{file}: {OTHER_GRID.format(files[0].name)}")
        found.append(one)
    return xr.concat(found, "time").to_dataset(name="efth")


def first_bytes(path: str | Path) -> bytes:
    """Return the beginning of a file, packed with gzip or not; raises `ConfigError` if it cannot be read."""
    try:
        with open_regular(path) as file:
            packed = file.read(2) == b"\x1f\x8b"
        with gzip.open(path) if packed else open_regular(path) as file:
            return file.read(64)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror or 'it is packed, and damaged'})") from None
    except (EOFError, zlib.error):
        raise ConfigError(f"{path}: received a packed file that is cut or damaged, needs a whole one") from None


@contextmanager
def _silent(path: str | Path) -> Iterator[None]:
    """Bound memory and time while a library reads a file, and keep its warnings to itself."""
    with bounded_reading(path), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def load_netcdf(path: str | Path) -> "xr.Dataset":
    """Return what a netCDF file holds; raises `ConfigError` if it cannot be read."""
    import xarray as xr  # here alone: text needs none

    def loaded(*, decode_times: bool = True) -> "xr.Dataset":
        with _silent(path), xr.open_dataset(path, engine="netcdf4", decode_times=decode_times) as ds:
            return ds.load()

    try:
        return loaded()
    except MemoryError:
        raise ConfigError(f"{path}: cannot be read as netCDF (it announces more than it holds)") from None
    except Exception:  # libraries raise errors of many types for damaged files
        pass
    try:
        loaded(decode_times=False)
    except Exception:
        raise ConfigError(f"{path}: cannot be read as netCDF, it is cut or damaged; needs a whole file") from None
    raise ConfigError(
        f"{path}: received times that are no dates; needs a date for every record, in units such as 'hours since "
        "2020-01-01'"
    )


def _opened(path: str | Path) -> "xr.Dataset":
    """Spectra of a netCDF file in our names."""
    stored = load_netcdf(path)
    if ERA5 in stored.variables:
        return _by_wavespectra(path, "era5", _hertz(path, stored))
    found = {ours: _among(stored.variables, names) for ours, names in NAMES.items()}
    for name in (name for name in ("efth", "freq", "time") if found[name] is None):
        names = ", ".join(sorted(map(str, stored.variables)))
        if name == "efth" and is_series(map(str, stored.data_vars)):
            raise ConfigError(f"{path}: received variables {names}, {SERIES}")
        raise ConfigError(f"{path}: received variables {shortened(names)}; needs {' or '.join(NAMES[name])}")
    for name, theirs in found.items():
        if name != "time" and theirs and stored[theirs].dtype.kind not in "iuf":
            raise ConfigError(f"{path}: received {theirs} of type {stored[theirs].dtype}, needs numbers")
    return stored.rename({theirs: ours for ours, theirs in found.items() if theirs and theirs != ours})


def _per_hertz(path: str | Path, ds: "xr.Dataset") -> "xr.Dataset":
    """Spectra with ascending frequencies in Hz and densities in m^2/Hz, with directions in m^2/Hz/rad."""
    stated, directional = str(ds.freq.attrs.get("units", "")), "dir" in ds.efth.dims
    axis = units.frequency(stated) if stated else units.Frequency(1.0)
    if axis is None or axis.period:
        raise ConfigError(f"{path}: received freq in {stated!r}, needs Hz or rad/s")
    unit = str(ds.efth.attrs.get("units", "")) or ("m2/Hz/degree" if directional else "m2/Hz")  # as wavespectra has it
    if (factor := units.density(unit, axis, directional)) is None:
        over = ", ".join(map(str, ds.efth.dims))
        raise ConfigError(
            f"{path}: received {ds.efth.name} over {over} in {unit!r} with frequencies in {stated or 'Hz'}, needs "
            + ("m2/Hz/degree, m2/Hz/rad or m2 s/rad/degree" if directional else "m2/Hz or m2 s/rad")
        )
    return ds.assign(efth=factor * ds.efth).assign_coords(freq=axis.factor * ds.freq.values).sortby("freq")


def _among(variables: Iterable[Any], names: tuple[str, ...]) -> str | None:
    """The first of some names that is among those of a file."""
    return next((name for name in names if name in variables), None)


def _hertz(path: str | Path, ds: "xr.Dataset") -> dict[str, float | None]:
    """First frequency and ratio of ERA5's file where it states them; it mostly numbers them instead."""
    name = _among(ds.variables, ("frequency", "frequencyNumber"))
    values = np.arange(1.0, 3.0) if name is None else np.asarray(ds[name].values, dtype=float)
    if len(values) < 2 or np.array_equal(values, np.arange(len(values)) + values[0]):
        return {}
    ratio = float((values[-1] / values[0]) ** (1 / (len(values) - 1)))
    if not np.allclose(values, values[0] * ratio ** np.arange(len(values)), rtol=1e-3):
        raise ConfigError(f"{path}: received frequencies {values[0]:g} to {values[-1]:g}, needs them of equal ratio")
    return {"f0": float(values[0]), "df": ratio}


def _by_wavespectra(path: str | Path, reader: str, options: dict[str, float | None] | None = None) -> "xr.Dataset":
    """Spectra in our names, read by wavespectra's reader of a name; `ConfigError` if it is missing or cannot."""
    try:
        import wavespectra
    except ImportError:
        raise ConfigError(
            f"{path}: received {EXPECTED[reader]}; needs the package that reads them: pip install wavespectra"
        ) from None
    try:
        with _silent(path):
            stored: xr.Dataset = getattr(wavespectra, f"read_{reader}")(str(path), **options or {}).load()
            if "dir" not in stored.efth.dims:
                stored.efth.attrs["units"] = "m2 s"  # it states the units of spectra over direction there, too
            if {stored.efth.dtype.kind, stored.freq.dtype.kind} <= {*"iuf"}:
                stored = stored.sortby("freq")
                if reader == "triaxys":
                    _check_stated_lines(path)
                return stored
    except ConfigError:
        raise
    except MemoryError:
        raise ConfigError(f"{path}: announces more than it holds; needs {EXPECTED[reader]}") from None
    except Exception:  # libraries raise errors of many types for damaged files
        pass
    raise ConfigError(f"{path}: cannot be read by wavespectra; needs {EXPECTED[reader]}")


def _of_datawell(files: list[Path]) -> "xr.Dataset":
    """Spectra of files of a Datawell buoy, of which a year has 17 568: read here, in a fraction of the time."""
    import xarray as xr

    times, grids, densities = zip(*map(_datawell, files), strict=True)
    for file, hertz in zip(files, grids, strict=True):
        if not np.array_equal(hertz, grids[0]):
            raise ConfigError(f"{file}: {OTHER_GRID.format(files[0].name)}")
    found = xr.Dataset({"efth": (("time", "freq"), np.array(densities), {"units": "m2 s"})})
    return found.assign_coords(time=np.array(times, dtype="datetime64[ns]"), freq=grids[0])


def _datawell(path: Path) -> tuple[datetime, FloatArray, FloatArray]:
    """Date, frequencies [Hz] and densities [m^2/Hz] of one file of a Datawell buoy.

    Twelve lines, Hs [cm] and the largest density [m^2/Hz] the second and fourth of them; then a line for each
    frequency, with the density relative to the largest. The date stands in the name.
    """
    try:
        lines = read_unpacked(path).decode("ascii").split("\n")
        head = [float(line) for line in lines[:_BEFORE]]
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[_BEFORE:] if line.strip()])
        time = datetime.strptime(path.stem.partition("}")[2].removesuffix("Z"), "%Y-%m-%dT%Hh%M")
        hertz, density = rows[:, 0], head[3] * rows[:, 1]
    except (ValueError, IndexError):
        raise ConfigError(f"{path}: cannot be read; needs {EXPECTED['datawell']}") from None
    stated, held = head[1] / 100, 4 * float(density @ np.diff(band_edges(hertz))) ** 0.5
    if not abs(held - stated) <= STATED * max(held, stated):
        raise ConfigError(
            f"{path}: received Hs {stated:.3g} m, but its spectrum holds {held:.3g} m; needs a whole file"
        )
    return time, hertz, density


def _check_stated_lines(path: str | Path) -> None:
    """Check that a TRIAXYS file holds a line for each of the frequencies it states: `ConfigError`."""
    text = read_unpacked(path).decode("latin-1")
    stated = re.search(r"NUMBER OF FREQUENCIES\s*=\s*(\d+)", text)
    held = len(re.findall(r"^[ \t]*[-+.\d][-+.\deE \t]*\r?$", text, re.MULTILINE))
    if stated and int(stated[1]) != held:
        raise ConfigError(
            f"{path}: received {held} lines of numbers; needs {stated[1]}, one for each of its frequencies"
        )


def dates_of(path: str | Path, time: "npt.NDArray[np.generic]") -> list[datetime]:
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


def _check_all_around(path: str | Path, directions: FloatArray) -> None:
    """Check that directions, in degrees or radians, are in equal steps all around."""
    for turn in (2 * np.pi, 360.0):
        places = np.sort(np.asarray(directions, dtype=float) % turn)
        steps = np.diff(places, append=places[:1] + turn)
        if np.ptp(steps) <= 1e-3 * steps.mean():
            return
    raise ConfigError(
        f"{path}: received directions {steps.min():.4g} to {steps.max():.4g} degrees apart, needs equal distances all "
        "around"
    )


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
EVEN, CALM, FEW_BANDS = 0.1, 0.02, 10
"""Median over the largest number from which on numbers are no densities, which differ by magnitudes; that of the first
or last band below which they are, which bring next to no waves; bands needed.
"""


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
    return of_records(2 * np.pi * hertz, density[kept], Path(path).name, notes, [times[i] for i in kept])


def _check_densities(path: str | Path, values: FloatArray) -> None:
    """Raise where numbers are no densities but bounded quantities of direction, whose files look the same."""
    known, ends = values[~np.isnan(values)], [end[~np.isnan(end)] for end in (values[:, 0], values[:, -1])]
    if not known.size or values.shape[1] < FEW_BANDS or np.median(known) < EVEN * known.max():
        return
    if any(end.size and np.median(end) < CALM * known.max() for end in ends):
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
        line, word = next((i, word) for i, row in rows for word in row if not is_number(word))
        raise ConfigError(f"{path}:{line}: received {word!r}, needs a number") from None
    if not np.all(np.isfinite(values)) or (values.size and values.min() < 0):
        at, column = np.argwhere(~(values >= 0) | ~np.isfinite(values))[0]
        raise ConfigError(
            f"{path}:{rows[at][0]}: received {rows[at][1][column]}, needs a number of 0 or more (999 for none)"
        )
    return values


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
    return sorted(first.values()), notes
