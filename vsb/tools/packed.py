"""Datasets in small sealed files, arrays as NumPy keeps them: for what is written by the hundred and read here alone.

netCDF takes 20 ms to write a member of a campaign, as long as to compute it; this takes one. Not a file for others.
"""

import io
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vsb.errors import DatabaseError
from vsb.tools.arrays import AnyArray
from vsb.tools.bounded import reason_of
from vsb.tools.files import CHANGED, DELETE, atomic_write, check_stamp, seal_of, sealed
from vsb.tools.variables import check_finite

if TYPE_CHECKING:
    import xarray as xr

SUFFIX = ".npz"
"""Of such files."""
_HEADER = "."
"""Name of the entry with dimensions, coordinates and attributes: no variable is called so."""


def save(ds: "xr.Dataset", path: str | Path) -> None:
    """Write a dataset of numbers and words, complete or not at all; see `vsb.tools.files.atomic_write`."""
    check_finite(ds, str(path))
    dims = {str(name): list(map(str, variable.dims)) for name, variable in ds.variables.items()}
    arrays = {str(name): _plain(variable.values) for name, variable in ds.variables.items()}
    header = {"dims": dims, "coords": list(map(str, ds.coords)), "attrs": ds.attrs}
    header |= {"kinds": {name: (values.dtype.str, values.shape) for name, values in arrays.items()}}
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **{_HEADER: np.array(json.dumps(header))}, **_rows(arrays))
    with atomic_write(path) as temporary:
        temporary.write_bytes(content.getvalue() + seal_of(content.getvalue()))


def _rows(arrays: Mapping[str, AnyArray]) -> dict[str, AnyArray]:
    """All values of each type in a row: an entry of the file costs as much as a thousand numbers."""
    kinds: dict[str, list[AnyArray]] = {}
    for values in arrays.values():
        kinds.setdefault(values.dtype.str, []).append(values.ravel())
    return {kind: np.concatenate(rows) for kind, rows in kinds.items()}


def _taken_apart(rows: Mapping[str, AnyArray], kinds: Mapping[str, tuple[str, list[int]]]) -> dict[str, AnyArray]:
    """Values by name from those of each type in a row."""
    found, begun = {}, dict.fromkeys(rows, 0)
    for name, (kind, shape) in kinds.items():
        end = begun[kind] + math.prod(shape)
        found[name] = rows[kind][begun[kind] : end].reshape(shape)
        begun[kind] = end
    return found


def _plain(values: AnyArray) -> AnyArray:
    """Words as NumPy stores them, numbers as they are."""
    return values.astype(str) if values.dtype == object else values


def load(path: str | Path, *, expected: str) -> "xr.Dataset":
    """Read a dataset written by `save`, its words as objects.

    Parameters
    ----------
    expected : str
        Content id it must carry.

    Raises
    ------
    DatabaseError
        If the file is missing, damaged, or of something else.
    """
    ds = read(path)
    check_stamp({**ds.attrs, "checksum": True}, expected, path)  # its seal is its checksum
    return ds


def read(path: str | Path) -> "xr.Dataset":
    """Read a dataset, whatever it is; see `load`."""
    import xarray as xr

    if not Path(path).is_file():
        raise DatabaseError(f"{path}: file not found; run the rule that makes it (vsb run CONFIG).")
    if not sealed(path):
        raise DatabaseError(f"{path}: {CHANGED}; {DELETE}.")
    try:
        with np.load(io.BytesIO(Path(path).read_bytes()), allow_pickle=False) as stored:
            header = json.loads(str(stored[_HEADER]))
            arrays = _taken_apart({kind: stored[kind] for kind in stored.files if kind != _HEADER}, header["kinds"])
            values = {name: (dims, arrays[name]) for name, dims in header["dims"].items()}
        coords = {name: values.pop(name) for name in header["coords"]}
        return xr.Dataset(values, coords=coords, attrs=header["attrs"])
    except Exception as error:  # of another file with a seal, whatever it holds
        raise DatabaseError(f"{path}: no packed dataset ({reason_of(error)}); {DELETE}.") from None
