"""Files in and out: netCDF with units on every variable, and text; written completely or not at all."""

import gzip
import hashlib
import json
import os
import socket
import tempfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import psutil

from vsb.errors import ConfigError, DatabaseError
from vsb.tools.arrays import AnyArray
from vsb.tools.bounded import decoded, read_unpacked, reason_of
from vsb.tools.variables import check_finite, described

if TYPE_CHECKING:
    import xarray as xr

ROOT = "/"
"""Name of the root group."""
DELETE = "delete it and run again"
"""What to do about a file that is not what it should be."""
CHANGED = "its contents are not those it was written with (checksum)"
SEAL = b"sha256:"
"""Start of the checksum appended to a netCDF file: sha256 of all bytes before it, after what HDF5 reads.

HDF5 trusts its own structure: one flipped bit there can end the process. A tool that rewrites the file drops it.
"""


def _obstacle(folder: Path) -> str:
    """Why no file can be written into a folder, existing or not; empty if one can."""
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
    """Check that files can be written into a folder, existing or not, before hours of work; raises `DatabaseError`."""
    if reason := _obstacle(Path(folder)):
        raise DatabaseError(f"{folder}: cannot be written ({reason}); needs a folder you may write to")


def check_file(path: str | Path) -> None:
    """Check that a file can be written, see `check_folder`; folders and devices are never replaced.

    Raises `DatabaseError`.
    """
    reason = _obstacle(Path(path).absolute().parent)
    if not reason and os.path.exists(path) and not os.path.isfile(path):
        reason = "it is a folder or a device"
    if reason:
        raise DatabaseError(f"{path}: cannot be written ({reason}); needs a file in a folder you may write to")


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Yield a temporary file to write, which replaces `path` when it is complete; after an error nothing is left.

    Raises `DatabaseError` if it cannot be written: no permission, no space left, no such place.
    """
    check_file(path)
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        own = f".{target.name}.{socket.gethostname()}."
        _remove_abandoned(target.parent, own)
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f"{own}{os.getpid()}.", suffix=".tmp")
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


def _remove_abandoned(folder: Path, begins: str) -> None:
    """Remove temporary files of a target left by killed processes of this machine."""
    for name in os.listdir(folder):  # quicker than a pattern with thousands of members
        if name.startswith(begins) and name.endswith(".tmp"):
            writer = name.removeprefix(begins).partition(".")[0]
            if writer.isdecimal() and not psutil.pid_exists(int(writer)):
                (folder / name).unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file completely or not at all."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def read_text(path: str | Path) -> str:
    """Read a text file, packed with gzip or not; of its letters see `vsb.tools.bounded.decoded`.

    Raises `ConfigError` if it cannot be read or is no text.
    """
    try:
        return decoded(read_unpacked(path))
    except (EOFError, zlib.error, gzip.BadGzipFile):
        raise ConfigError(f"{path}: received a packed file that is cut or damaged, needs a whole one") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise ConfigError(
            f"{path}: received byte {error.start} that is no text, needs UTF-8: save it as CSV UTF-8 or plain text"
        ) from None


def save(ds: "xr.Dataset", path: str | Path, groups: "Mapping[str, xr.Dataset] | None" = None) -> None:
    """Write a dataset (and named groups) to netCDF-4 with its `checksum`, completely or not at all."""
    check_finite(ds, str(path))
    for name, group in (groups or {}).items():
        check_finite(group, f"{path}:{name}")
    stored = {name: separated(described(group)) for name, group in {ROOT: ds, **(groups or {})}.items()}
    stored[ROOT].attrs["checksum"] = checksum(stored)
    with atomic_write(path) as temporary:
        for name, group in stored.items():
            _write(group, str(temporary), mode="w" if name == ROOT else "a", group=name)
        seal(temporary)


def separated(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with complex variables as reals on a dimension `complex` = re, im (capytaine's form)."""
    import xarray as xr

    out = ds.copy()
    for name, variable in ds.data_vars.items():
        if np.iscomplexobj(variable):
            parts = xr.concat([variable.real, variable.imag], dim="complex").assign_coords(complex=["re", "im"])
            out[name] = parts.assign_attrs(variable.attrs)
    return out


def merged(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with complex variables put together again: the inverse of `separated`.

    Raises `DatabaseError` if a dimension of that name holds anything but real and imaginary parts.
    """
    if "complex" not in ds.dims:
        return ds
    if sorted(labels := [str(label) for label in ds["complex"].values]) != ["im", "re"]:
        raise DatabaseError(f"dimension complex: received {', '.join(labels)}, needs re, im")
    parts = {
        name: (v.sel(complex="re", drop=True) + 1j * v.sel(complex="im", drop=True)).assign_attrs(v.attrs)
        for name, v in ds.data_vars.items()
        if "complex" in v.dims
    }
    return ds.assign(parts).drop_vars("complex")


def _write(ds: "xr.Dataset", path: str, mode: Literal["w", "a"], group: str) -> None:
    """Write one group; large variables compressed, without loss."""
    large = {name: {"zlib": True, "complevel": 1} for name, v in ds.data_vars.items() if v.size > 10_000}
    try:
        ds.to_netcdf(path, engine="netcdf4", mode=mode, group=group, encoding=large)
    except RuntimeError as error:  # netCDF's error for a full disk
        raise OSError(str(error)) from None


def seal(path: str | Path) -> None:
    """Append the checksum to a netCDF file."""
    mark = seal_of(Path(path).read_bytes())
    with Path(path).open("ab") as file:
        file.write(mark)


def seal_of(content: bytes) -> bytes:
    """Return the checksum line of contents."""
    return SEAL + hashlib.sha256(content).hexdigest().encode()


def sealed(path: str | Path) -> bool:
    """Return whether a file ends with its checksum; a wrong one raises `DatabaseError`."""
    found = is_sealed(Path(path).read_bytes())
    if found is False:
        raise DatabaseError(f"{path}: {CHANGED}; {DELETE}.")
    return bool(found)


def is_sealed(content: bytes) -> bool | None:
    """Return whether contents are those of the checksum they end with; None if they have none."""
    end = content.rfind(SEAL, max(0, len(content) - len(SEAL) - 64))
    if end < 0:
        return None
    return content[end + len(SEAL) :] == hashlib.sha256(memoryview(content)[:end]).hexdigest().encode()


def checksum(groups: "Mapping[str, xr.Dataset]") -> str:
    """Return sha256 over names, dimensions, attributes and values of datasets as stored; `checksum` itself left out."""
    digest = hashlib.sha256()
    for group, ds in sorted(groups.items()):
        digest.update(_plain([group, _listed(ds.attrs)]))
        for name, variable in sorted(ds.variables.items()):
            kind, content = _content(variable.values)
            shape = dict(zip(variable.dims, variable.shape, strict=True))
            digest.update(_plain([name, name in ds.coords, list(shape.items()), kind, _listed(variable.attrs)]))
            digest.update(content)
    return digest.hexdigest()


def _content(values: AnyArray) -> tuple[str, bytes]:
    """Type and bytes of values, the same on every machine; text counts as such, of whatever length on disk."""
    if values.dtype.kind in "OSU":
        return "text", _plain(values.astype(str).tolist())
    kind = values.dtype.newbyteorder("<").str
    return kind, np.ascontiguousarray(values, dtype=kind).tobytes()


def _listed(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes as lists: on disk a number and a list of one are the same."""
    return {str(name): np.atleast_1d(value).tolist() for name, value in attrs.items() if name != "checksum"}


def _plain(data: object) -> bytes:
    """Names, shapes and attributes as JSON, the same before and after they were on disk."""
    return json.dumps(data, sort_keys=True).encode()


def read_groups(path: str | Path) -> "dict[str, xr.Dataset]":
    """Read all groups of a netCDF file as they are stored.

    Raises `DatabaseError` if the file is missing, not netCDF, or its contents are not those its `checksum` was taken
    of.
    """
    if not Path(path).is_file():
        raise DatabaseError(f"{path}: file not found; run the rule that makes it (vsb run CONFIG).")
    import xarray as xr  # half a second, which commands that read no data do not wait for

    sealed(path)
    try:
        groups = {}
        for name, ds in xr.open_groups(path, engine="netcdf4").items():
            with ds:
                groups[name.removeprefix("/") or ROOT] = ds.load()
        found = checksum(groups)
    except Exception as error:  # a damaged file may raise anything in the libraries that read it
        raise DatabaseError(f"{path}: cannot be read as netCDF ({reason_of(error)}); {DELETE}.") from None
    if groups[ROOT].attrs.get("checksum", found) != found:
        raise DatabaseError(f"{path}: {CHANGED}; {DELETE}.")
    return groups


def attributes(path: str | Path) -> dict[str, Any]:
    """Return the attributes of a netCDF file after checking its contents; raises `DatabaseError` see `read_groups`."""
    if not sealed(path):
        return read_groups(path)[ROOT].attrs
    import netCDF4

    with netCDF4.Dataset(path) as file:
        return {name: file.getncattr(name) for name in file.ncattrs()}


def carries_stamp(path: str | Path) -> bool:
    """Return whether this package wrote a file, damaged or not: it has a checksum or a content id."""
    with Path(path).open("rb") as file:
        file.seek(-min(len(SEAL) + 64, os.path.getsize(path)), os.SEEK_END)
        if file.read().startswith(SEAL):
            return True
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            return "spec_id" in file.ncattrs()
    except OSError:
        return False


def load(path: str | Path, group: str = ROOT, *, expected: str | None = None) -> "xr.Dataset":
    """Read a dataset written by `save`: contents checked, complex variables merged, units applied.

    Parameters
    ----------
    expected : str, optional
        Content id the file must carry.

    Raises
    ------
    DatabaseError
        If the file is missing, damaged, not netCDF, not the one expected, or holds unknown variables.
    """
    groups = read_groups(path)
    if expected is not None:
        check_stamp(groups[ROOT].attrs, expected, path)
    if group not in groups:
        raise DatabaseError(f"{path}: cannot be read as netCDF (no group {group}); delete it and run again.")
    try:
        return described(merged(groups[group]))
    except (DatabaseError, ValueError) as error:
        reason = error if isinstance(error, DatabaseError) else reason_of(error)
        raise DatabaseError(
            f"{path}: not a file of this project ({reason}); delete or move it and run again."
        ) from None


def check_stamp(attrs: Mapping[str, Any], expected: str, path: str | Path) -> None:
    """Check that a file carries the content id expected, and a checksum; raises `DatabaseError`."""
    found = attrs.get("spec_id")
    if found != expected:
        raise DatabaseError(f"{path}: holds {found!r}, needs {expected!r}: stale or foreign; {DELETE}.")
    if "checksum" not in attrs:
        raise DatabaseError(f"{path}: carries no checksum of its contents; {DELETE}.")
