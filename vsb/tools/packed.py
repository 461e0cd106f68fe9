"""Datasets one after another in a file that grows, each sealed: for what is written by the thousand, and read here.

netCDF takes 20 ms to write a member of a campaign, as long as to compute it; this takes one. Not a file for others. A
writer that is killed loses the dataset it was writing.
"""

import io
import json
import math
import re
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vsb.errors import DatabaseError
from vsb.tools.arrays import AnyArray
from vsb.tools.files import CHANGED, DELETE, check_file, check_stamp, is_sealed, reason_of, seal_of
from vsb.tools.variables import check_finite

if TYPE_CHECKING:
    import xarray as xr

SUFFIX = ".pack"
"""Of such files."""
_HEAD = 30
"""Bytes before a dataset: its content id and how many bytes follow."""
_HEADER = "."
"""Name of the entry with dimensions, coordinates and attributes: no variable is called so."""
_HEADER_LINE = re.compile(rb"([0-9a-f]{16}) +(\d+)\n")


class Pack:
    """A file of datasets by their content ids; of several with the same id the last counts."""

    def __init__(self, path: Path) -> None:
        """Of a file that may not be there yet."""
        self.path = path
        self._end = 0  # of the last whole dataset

    @cached_property
    def places(self) -> dict[str, tuple[int, int]]:
        """Begin and end of every dataset in the file by its id; what a killed writer left of one is none."""
        found: dict[str, tuple[int, int]] = {}
        if not self.path.is_file():
            return found
        size = self.path.stat().st_size
        with self.path.open("rb") as file:
            while head := _HEADER_LINE.fullmatch(file.read(_HEAD)):
                begin, end = self._end + _HEAD, self._end + _HEAD + int(head[2])
                if end > size:
                    break
                found[head[1].decode()] = (begin, end)
                self._end = end
                file.seek(end)
        return found

    def append(self, ds: "xr.Dataset") -> None:
        """Add a dataset of numbers and words that carries its content id, `spec_id`.

        Raises `DatabaseError` if it cannot be written.
        """
        check_finite(ds, str(self.path))
        identity, content = ds.attrs["spec_id"], _content(ds)
        known = self.places  # and with them the end
        check_file(self.path)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("r+b" if known or self.path.exists() else "wb") as file:
                file.truncate(self._end)
                file.seek(self._end)
                file.write(b"%s %12d\n" % (identity.encode(), len(content)) + content)
        except OSError as error:
            raise DatabaseError(
                f"{self.path}: cannot be written ({error.strerror or error}); needs space in a folder you may write to"
            ) from None
        known[identity] = (self._end + _HEAD, self._end + _HEAD + len(content))
        self._end = known[identity][1]

    def read(self, identity: str) -> "xr.Dataset":
        """Return a dataset, its words as objects; raises `DatabaseError` if it is damaged, or of something else."""
        begin, end = self.places[identity]
        with self.path.open("rb") as file:
            file.seek(begin)
            ds = _dataset(file.read(end - begin), self.path)
        check_stamp({**ds.attrs, "checksum": True}, identity, self.path)  # its seal is its checksum
        return ds

    def check(self) -> None:
        """Check that all of the file can be read; raises `DatabaseError`."""
        for identity in self.places:
            self.read(identity)
        if self._end < self.path.stat().st_size:
            raise DatabaseError(
                f"{self.path}: ends within a dataset; run again, which goes on after the last whole one."
            )


def packs(folder: str | Path) -> dict[str, Pack]:
    """Return the file that holds a dataset, by its id, of all in a folder."""
    return {
        one: pack
        for path in sorted(Path(folder).glob(f"[!.]*{SUFFIX}"))
        for pack in [Pack(path)]
        for one in pack.places
    }


def _content(ds: "xr.Dataset") -> bytes:
    """A dataset as sealed bytes; all values of each type in a row, as an entry costs as much as a thousand numbers."""
    dims = {str(name): list(map(str, variable.dims)) for name, variable in ds.variables.items()}
    arrays = {str(name): variable.values for name, variable in ds.variables.items()}
    arrays = {name: values.astype(str) if values.dtype == object else values for name, values in arrays.items()}
    header = {"dims": dims, "coords": list(map(str, ds.coords)), "attrs": ds.attrs}
    header |= {"kinds": {name: (values.dtype.str, values.shape) for name, values in arrays.items()}}
    rows: dict[str, list[AnyArray]] = {}
    for values in arrays.values():
        rows.setdefault(values.dtype.str, []).append(values.ravel())
    entries = {kind: np.concatenate(parts) for kind, parts in rows.items()}
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **{_HEADER: np.array(json.dumps(header))}, **entries)
    return content.getvalue() + seal_of(content.getvalue())


def _dataset(content: bytes, path: Path) -> "xr.Dataset":
    """The dataset of sealed bytes; raises `DatabaseError`."""
    import xarray as xr

    if not is_sealed(content):
        raise DatabaseError(f"{path}: {CHANGED}; {DELETE}.")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            header = json.loads(str(stored[_HEADER]))
            rows = {kind: stored[kind] for kind in stored.files if kind != _HEADER}
        values, begun = {}, dict.fromkeys(rows, 0)
        for name, (kind, shape) in header["kinds"].items():
            begin, begun[kind] = begun[kind], begun[kind] + math.prod(shape)
            values[name] = header["dims"][name], rows[kind][begin : begun[kind]].reshape(shape)
        coords = {name: values.pop(name) for name in header["coords"]}
        return xr.Dataset(values, coords=coords, attrs=header["attrs"])
    except Exception as error:  # of other contents with a seal, whatever they hold
        raise DatabaseError(f"{path}: no packed dataset ({reason_of(error)}); {DELETE}.") from None
