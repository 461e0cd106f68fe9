"""Any hydro database from any file, with its verdict: this project's, capytaine's, WAMIT's, BEMIO's."""

from collections.abc import Sequence
from pathlib import Path

import netCDF4
import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro.database import Check, open_database, stored_checks
from vsb.hydro.formats.bemio import read_bemio
from vsb.hydro.formats.capytaine import read_capytaine
from vsb.hydro.formats.foreign import foreign_checks
from vsb.hydro.formats.wamit import import_wamit
from vsb.study.sections import Water
from vsb.tools.bounded import open_regular


def read_source(kind: str, path: str, water: Water, length: float = 1.0) -> xr.Dataset:
    """Return a hydro database, not judged yet if it is another code's.

    Parameters
    ----------
    kind : "database", "wamit" or "bemio"
    path : str
        Of the file; of WAMIT's files without their endings.
    water : Water
        Of WAMIT's run, whose files do not say it.
    length : float
        WAMIT's ULEN [m].

    Raises
    ------
    DatabaseError
        If the file is none of its kind.
    """
    if kind == "wamit":
        folder, name = Path(path).parent, Path(path).name
        run = {"density": water.density, "gravity": water.gravity, "depth": water.depth}
        return import_wamit(folder, name, length=length, **run, labels=None)
    if kind == "bemio":
        return read_bemio(path)
    return open_database(path) if is_own(path) else read_capytaine(path)


def is_own(path: str) -> bool:
    """Return whether a netCDF file is a database of this project's; other files it need not be able to read."""
    try:
        with open_regular(path), netCDF4.Dataset(path) as file:
            return "separate_sweep" in file.ncattrs()
    except (OSError, RuntimeError) as error:
        raise DatabaseError(f"{path}: cannot be read: {error}; needs a hydro database as netCDF.") from None


def source_checks(ds: xr.Dataset, dofs: Sequence[str] | None = None) -> tuple[list[Check], list[str]]:
    """Return the checks stored with a database, or those its numbers allow, and a line on each that they do not.

    Of some degrees of freedom; what others tell of the file's conventions counts for all.
    """
    return (stored_checks(ds), []) if "quality" in ds.attrs else foreign_checks(ds, dofs=dofs)
