"""Files in and out: netCDF with units on every variable, and text; written completely or not at all."""

import errno
import gzip
import hashlib
import io
import json
import os
import signal
import socket
import stat
import sys
import tempfile
import threading
import time
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import psutil

from vsb.errors import ConfigError, DatabaseError
from vsb.tools.variables import check_finite, described

if TYPE_CHECKING:
    import xarray as xr

if sys.platform == "win32":
    import msvcrt

    _BEYOND = 1 << 30  # where nothing is written: what is locked there nobody else can read

    def take(handle: int) -> bool:
        """Take the lock of an open file, unless another process has it; return whether it is taken."""
        os.lseek(handle, _BEYOND, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            return False
        return True
else:
    import fcntl

    def take(handle: int) -> bool:
        """Take the lock of an open file, unless another process has it; return whether it is taken."""
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


def wait(handle: int, seconds: float = float("inf")) -> bool:
    """Take the lock of an open file, waiting so many seconds for it; return whether it is taken."""
    until = time.monotonic() + seconds
    while not (taken := take(handle)) and time.monotonic() < until:
        time.sleep(0.02)
    return taken


@contextmanager
def locked(path: str | Path) -> Iterator[None]:
    """Hold the lock of a file, waiting for it."""
    with Path(path).open("a") as handle:
        wait(handle.fileno())
        yield


LARGEST = 2**28
"""Most bytes of an unpacked text file; 40 years of hourly spectra are a third of it."""
LARGEST_STUDY = 2**22
"""Most bytes of a study file or of the profile of a shell."""
MEMORY = (2**30, 200)
"""Memory a library may use to read a file [bytes], and in addition per byte of the file."""
SECONDS = (20.0, 2e-5)
"""Time a library may take to read a file [s], and in addition per byte of the file."""


def open_regular(path: str | Path) -> io.BufferedReader:
    """Open a file to read its bytes.

    Raises `OSError` if it cannot be opened, or is a pipe or a device, which may have no end.
    """
    if not stat.S_ISREG(os.stat(path).st_mode):
        raise OSError(errno.EINVAL, "it is no regular file", str(path))
    return Path(path).open("rb")


def read_bounded(path: str | Path, largest: int = LARGEST) -> bytes:
    """Return what a file holds; `OSError` as of `open_regular`, and if it holds more than `largest` bytes."""
    with open_regular(path) as file:
        return _all_of(file, path, largest)


def read_unpacked(path: str | Path) -> bytes:
    """Return what a file holds, unpacked if it is packed with gzip.

    Raises `OSError` as of `read_bounded`, of what is unpacked as well; `gzip.BadGzipFile`, `EOFError` or `zlib.error`
    if it is packed, and cut or damaged.
    """
    data = read_bounded(path)
    if not data.startswith(b"\x1f\x8b"):
        return data
    with gzip.open(io.BytesIO(data)) as unpacked:
        return _all_of(unpacked, path, LARGEST)


def _all_of(file: io.BufferedIOBase, path: str | Path, largest: int) -> bytes:
    """All bytes of an open file, if they are no more than so many."""
    data = file.read(largest + 1)
    if len(data) > largest:
        raise OSError(errno.EFBIG, f"it holds more than {largest / 2**20:.0f} MiB", str(path))
    return data


def decoded(data: bytes) -> str:
    """Return the text of bytes: UTF-8 or UTF-16, with or without byte-order mark, or the letters of older Windows.

    Raises `UnicodeDecodeError` if it is none, as bytes of zero show.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in data:
            raise
        return data.decode("cp1252")


def files_of(folder: str | Path) -> list[Path]:
    """Return the files of a folder and of those in it by name, without hidden ones."""
    found = (path for path in Path(folder).rglob("*") if path.is_file())
    return sorted(path for path in found if not any(part.startswith(".") for part in path.relative_to(folder).parts))


def sha256_of(path: str | Path) -> str:
    """Return the checksum of what a file of any size holds, or a folder; `OSError` as of `open_regular`."""
    if os.path.isdir(path):
        held = "".join(f"{file.relative_to(path)} {sha256_of(file)}\n" for file in files_of(path))
        return hashlib.sha256(held.encode()).hexdigest()
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def bounded_reading(path: str | Path) -> Iterator[None]:
    """Bound memory and time by the size of a file while a library reads it.

    Raises `OSError`, `MemoryError` or `TimeoutError` see `open_regular`; if it takes more.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
    memory, seconds = (least + per_byte * size for least, per_byte in (MEMORY, SECONDS))
    with bounded_memory(int(memory)), bounded_time(seconds):
        yield


def reason_of(error: BaseException) -> str:
    """Return why a file cannot be read, in words of our own: those of a library mean nothing to whoever named it."""
    if isinstance(error, TimeoutError):
        return str(error)
    if isinstance(error, MemoryError):
        return "it announces more than it holds"
    if isinstance(error, OSError) and (error.errno or 0) > 0:
        return str(error.strerror)
    return "it is damaged, cut short or not what its name says"


@contextmanager
def bounded_memory(more: int) -> Iterator[None]:
    """Bound the additional memory of this process [bytes], else `MemoryError`; only on Linux."""
    try:
        import resource

        used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    except (ImportError, OSError):
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    bound = used + more if soft == resource.RLIM_INFINITY else min(used + more, soft)
    resource.setrlimit(resource.RLIMIT_AS, (bound, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@contextmanager
def bounded_time(seconds: float) -> Iterator[None]:
    """Bound the time [s], else `TimeoutError`; only in the main thread of a Unix."""
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def over(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"it takes more than {seconds:.3g} s")

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


ROOT = "/"
"""Name of the root group."""
DELETE = "delete it and run again"
"""What to do about a file that is not what it should be."""
OWN = "if it is a result of vsb, "
"""Before that about a file that may be the user's."""
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
        for name in os.listdir(target.parent):  # of killed processes; quicker than a pattern with thousands of members
            if name.startswith(own) and name.endswith(".tmp"):
                writer = name.removeprefix(own).partition(".")[0]
                if writer.isdecimal() and not psutil.pid_exists(int(writer)):
                    (target.parent / name).unlink(missing_ok=True)
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f"{own}{os.getpid()}.", suffix=".tmp")
        os.close(handle)
        try:
            yield Path(name)
            os.chmod(name, 0o644)
            os.replace(name, target)
        finally:
            Path(name).unlink(missing_ok=True)
    except OSError as error:
        raise unwritable(path, error) from None


def unwritable(path: str | Path, error: OSError) -> DatabaseError:
    """Return what to say of a file or folder that cannot be written: no permission, no space left, no such place."""
    return DatabaseError(
        f"{path}: cannot be written ({error.strerror or error}); needs space in a folder you may write to"
    )


def write_text(path: str | Path, text: str) -> None:
    """Write a text file completely or not at all."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def read_text(path: str | Path) -> str:
    """Read a text file, packed with gzip or not; of its letters see `vsb.tools.files.decoded`.

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
            mode: Literal["w", "a"] = "w" if name == ROOT else "a"
            try:
                group.to_netcdf(str(temporary), engine="netcdf4", mode=mode, group=name)
            except RuntimeError as error:  # netCDF's error for a full disk
                raise OSError(str(error)) from None
        seal(temporary)


def separated(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with complex variables as reals on a dimension `complex` = re, im (capytaine's form)."""
    import xarray as xr

    parts = {
        name: xr.Variable(("complex", *v.dims), np.stack([v.values.real, v.values.imag]), v.attrs)
        for name, v in ds.data_vars.items()
        if np.iscomplexobj(v)
    }
    return ds.assign(parts).assign_coords(complex=["re", "im"]) if parts else ds.copy()


def merged(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with complex variables put together again: the inverse of `separated`.

    Raises `DatabaseError` if a dimension of that name holds anything but real and imaginary parts.
    """
    import xarray as xr

    if "complex" not in ds.dims:
        return ds
    if sorted(labels := [str(label) for label in ds["complex"].values]) != ["im", "re"]:
        raise DatabaseError(f"dimension complex: received {', '.join(labels)}, needs re, im")
    parts = {}
    for name, variable in ds.data_vars.items():
        if "complex" in variable.dims:
            real, imag = (variable.variable.isel(complex=labels.index(part)) for part in ("re", "im"))
            parts[name] = xr.Variable(real.dims, real.values + 1j * imag.values, real.attrs)
    return ds.assign(parts).drop_vars("complex")


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
            values = variable.values  # the same on every machine; text counts as such, of whatever length on disk
            if values.dtype.kind in "OSU":
                kind, content = "text", _plain(values.astype(str).tolist())
            else:
                kind = values.dtype.newbyteorder("<").str
                content = np.ascontiguousarray(values, dtype=kind).tobytes()
            shape = dict(zip(variable.dims, variable.shape, strict=True))
            digest.update(_plain([name, name in ds.coords, list(shape.items()), kind, _listed(variable.attrs)]))
            digest.update(content)
    return digest.hexdigest()


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

    whole = sealed(path)
    try:
        groups = {}
        for name, ds in xr.open_groups(path, engine="netcdf4").items():
            with ds:
                groups[name.removeprefix("/") or ROOT] = ds.load()
        stated = groups[ROOT].attrs.get("checksum")
        changed = not whole and stated is not None and stated != checksum(groups)
    except Exception as error:  # a damaged file may raise anything in the libraries that read it
        raise DatabaseError(f"{path}: cannot be read as netCDF ({reason_of(error)}); {OWN}{DELETE}.") from None
    if changed:
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
        raise DatabaseError(f"{path}: cannot be read as netCDF (no group {group}); {OWN}{DELETE}.")
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
