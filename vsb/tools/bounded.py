"""Files named by users are read within bounds of size, memory and time."""

import errno
import gzip
import hashlib
import io
import os
import signal
import stat
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

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
