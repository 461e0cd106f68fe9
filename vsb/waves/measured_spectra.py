"""Spectra from files: netCDF of any program that states their units, formats that wavespectra reads, NDBC's text.

The units decide, not the name of the program: densities are per Hz, and with directions per degree or per radian.
"""

import gzip
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vsb.errors import ConfigError
from vsb.tools import units
from vsb.tools.arrays import FloatArray
from vsb.tools.bounded import bounded_reading, open_regular
from vsb.waves.climate import Climate, of_records
from vsb.waves.ndbc import calendar, read_ndbc

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
NETCDF, SWAN = (b"CDF", b"\x89HDF"), b"SWAN"
"""First characters of netCDF and of SWAN's text."""
ERA5 = "d2fd"
"""Variable of ERA5: decimal logarithms."""


def read_spectra(path: str | Path) -> Climate:
    """Return the climate of a file of spectra of one site: netCDF, SWAN's text, or else the text of `read_ndbc`.

    Raises `ConfigError` with file, name, value received and value needed.

    Parameters
    ----------
    path : path
        Density over time, frequency [Hz] and perhaps direction, by one of `NAMES`, in m^2/Hz, m^2/Hz/degree or
        m^2/Hz/radian as its units say; by wavespectra, netCDF of ERA5 and two-dimensional spectra in SWAN's text.
    """
    try:
        with open_regular(path) as file:
            packed = file.read(2) == b"\x1f\x8b"
        with gzip.open(path) if packed else open_regular(path) as file:
            begin = file.read(len(SWAN))
    except (OSError, EOFError) as error:
        raise ConfigError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if not begin.startswith((*NETCDF, SWAN)):
        return read_ndbc(path)
    stored = _per_hertz(path, _by_wavespectra(path, "swan") if begin == SWAN else _opened(path))
    spectra, hertz = stored.efth, np.asarray(stored.freq.values, dtype=float)
    if {"time", "freq"} - {*spectra.dims} or len(hertz) < 2 or not hertz[0] > 0 or not np.all(np.diff(hertz) > 0):
        raise ConfigError(
            f"{path}: received {spectra.name} over {spectra.dims}, needs time and two frequencies or more above 0 Hz"
        )
    for name in [name for name in spectra.dims if name not in ("time", "freq", "dir")]:
        if spectra.sizes[name] != 1:
            raise ConfigError(f"{path}: received {spectra.sizes[name]} along {name}, needs one: select a site")
        spectra = spectra.isel({name: 0})
    if "dir" in spectra.dims:
        _check_all_around(path, stored.dir.values)
        spectra = spectra.mean("dir", skipna=False) * 2 * np.pi
    density = spectra.transpose("time", "freq").values.astype(float) / (2 * np.pi)
    kept, notes = calendar(_dates(path, stored.time.values))
    if FLAGS in stored:
        unusable = ~np.isin(stored[FLAGS].values, USABLE)
        density[unusable] = np.nan
        notes += [f"{int(unusable.sum())} records not used for their {FLAGS}"] if unusable.any() else []
    return of_records(2 * np.pi * hertz, density[kept], Path(path).name, notes)


def _opened(path: str | Path) -> "xr.Dataset":
    """Spectra of a netCDF file in our names, frequencies ascending."""
    import xarray as xr  # here alone: text needs none

    try:
        with bounded_reading(path), xr.open_dataset(path, engine="netcdf4") as ds:
            stored = ds.load()
    except MemoryError:
        raise ConfigError(f"{path}: cannot be read as netCDF (it announces more than it holds)") from None
    except Exception as error:  # libraries raise errors of many types for damaged files
        raise ConfigError(f"{path}: cannot be read as netCDF ({_reason(error)})") from None
    if ERA5 in stored.variables:
        return _by_wavespectra(path, "era5", _hertz(path, stored))
    found = {ours: _among(stored.variables, names) for ours, names in NAMES.items()}
    for name in (name for name in ("efth", "freq", "time") if found[name] is None):
        names = ", ".join(sorted(map(str, stored.variables)))
        raise ConfigError(f"{path}: received variables {names}; needs {' or '.join(NAMES[name])}")
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


def _hertz(path: str | Path, ds: "xr.Dataset") -> dict[str, float]:
    """First frequency and ratio of ERA5's file where it states them; it mostly numbers them instead."""
    name = _among(ds.variables, ("frequency", "frequencyNumber"))
    values = np.arange(1.0, 3.0) if name is None else np.asarray(ds[name].values, dtype=float)
    if len(values) < 2 or np.array_equal(values, np.arange(len(values)) + values[0]):
        return {}
    ratio = float((values[-1] / values[0]) ** (1 / (len(values) - 1)))
    if not np.allclose(values, values[0] * ratio ** np.arange(len(values)), rtol=1e-3):
        raise ConfigError(f"{path}: received frequencies {values[0]:g} to {values[-1]:g}, needs them of equal ratio")
    return {"f0": float(values[0]), "df": ratio}


def _by_wavespectra(path: str | Path, reader: str, options: dict[str, float] | None = None) -> "xr.Dataset":
    """Spectra in our names, read by wavespectra's reader of a name; `ConfigError` if it is missing or cannot."""
    try:
        import wavespectra
    except ImportError:
        raise ConfigError(
            f"{path}: received spectra as {reader} writes them, needs the package wavespectra to read them: "
            "pip install 'vsb[spectra]'"
        ) from None
    try:
        with bounded_reading(path):
            return getattr(wavespectra, f"read_{reader}")(str(path), **options or {}).load().sortby("freq")  # type: ignore[no-any-return]
    except MemoryError:
        raise ConfigError(f"{path}: cannot be read by wavespectra (it announces more than it holds)") from None
    except Exception as error:  # libraries raise errors of many types for damaged files
        more = ": of SWAN's text it reads two-dimensional spectra" if reader == "swan" else ""
        raise ConfigError(f"{path}: cannot be read by wavespectra's read_{reader} ({_reason(error)}){more}") from None


def _reason(error: Exception) -> str:
    """The message of an error in one line."""
    return " ".join(str(error).split()) or type(error).__name__


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
