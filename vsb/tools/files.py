"""Files in and out: netCDF with the table of units applied, and text; written whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import xarray as xr

from vsb.errors import DatabaseError
from vsb.tools.units import check_finite, described, merged, separated


def _write(ds: xr.Dataset, path: str, mode: Literal["w", "a"], group: str | None = None) -> None:
    """Write one group in the form on disk; large variables compressed, without loss."""
    out = separated(described(ds))
    large = {name: {"zlib": True, "complevel": 1} for name, v in out.data_vars.items() if v.size > 10_000}
    try:
        out.to_netcdf(path, engine="netcdf4", mode=mode, group=group, encoding=large)
    except RuntimeError as error:  # netCDF's own word for a full disk
        raise OSError(str(error)) from None


def _obstacle(folder: Path) -> str:
    """Why nothing can be put into a folder, there already or not; empty if something can."""
    place = folder.absolute()
    try:
        while not place.exists() and place != place.parent:
            place = place.parent
        if not place.is_dir():
            return f"{place} is no folder"
    except OSError as error:
        return str(error.strerror)
    return "" if os.access(place, os.W_OK | os.X_OK) else f"no permission to write to {place}"


def check_folder(folder: str | Path) -> None:
    """Check that files can be put into a folder, there already or not: hours of work must not end in an error.

    Raises
    ------
    DatabaseError
    """
    if reason := _obstacle(Path(folder)):
        raise DatabaseError(f"{folder}: cannot be written ({reason}); needs a folder you may write to")


def check_file(path: str | Path) -> None:
    """Check that a file can be written, see `check_folder`; neither folder nor device is ever replaced by it.

    Raises
    ------
    DatabaseError
    """
    reason = _obstacle(Path(path).absolute().parent)
    if not reason and os.path.exists(path) and not os.path.isfile(path):
        reason = "it is a folder or a device"
    if reason:
        raise DatabaseError(f"{path}: cannot be written ({reason}); needs a file in a folder you may write to")


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Give a temporary file to write, beside `path`, and put it there when it is complete; or leave nothing behind.

    Raises
    ------
    DatabaseError
        If it cannot be written: no permission, no space left, no such place.
    """
    check_file(path)
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=".tmp")
        os.close(handle)
        try:
            yield Path(name)
            os.chmod(name, 0o644)
            os.replace(name, target)
        finally:
            Path(name).unlink(missing_ok=True)
    except OSError as error:
        raise DatabaseError(
            f"{path}: cannot be written ({error.strerror or error}); needs space in a folder you may write to"
        ) from None


def save(ds: xr.Dataset, path: str | Path, groups: dict[str, xr.Dataset] | None = None) -> None:
    """Write a dataset (and named groups) to netCDF-4, complete or not at all; see `whole`."""
    check_finite(ds, str(path))
    with whole(path) as temporary:
        _write(ds, str(temporary), mode="w")
        for name, group in (groups or {}).items():
            check_finite(group, f"{path}:{name}")
            _write(group, str(temporary), mode="a", group=name)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file, complete or not at all; see `whole`."""
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def load(path: str | Path, group: str | None = None) -> xr.Dataset:
    """Read a dataset written by `save`: complex variables merged, units applied.

    Raises
    ------
    DatabaseError
        If the file is missing, not netCDF, or holds variables this project does not know.
    """
    if not Path(path).is_file():
        raise DatabaseError(f"{path}: file not found; run the rule that makes it (vsb run CONFIG).")
    try:
        with xr.open_dataset(path, engine="netcdf4", group=group) as ds:
            raw = ds.load()
    except (OSError, ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise DatabaseError(f"{path}: cannot be read as netCDF ({reason}); delete it and run again.") from None
    try:
        return described(merged(raw))
    except (DatabaseError, ValueError) as error:
        raise DatabaseError(f"{path}: not a file of this project ({error}); delete or move it and run again.") from None
