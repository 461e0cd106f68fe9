"""Any hydro database read from any file, with its verdict, and written as files of other codes."""

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import netCDF4
import xarray as xr

from vsb.engine.hydro.database import Check, load_database, open_database, stored_checks
from vsb.engine.hydro.formats.bemio import bemio_entries, read_bemio, write_h5
from vsb.engine.hydro.formats.capytaine import read_capytaine
from vsb.engine.hydro.formats.checks import coefficient_checks
from vsb.engine.hydro.formats.wamit import import_wamit, wamit_texts
from vsb.engine.waves.water import Water
from vsb.errors import DatabaseError
from vsb.tools.files import open_regular, reason_of, write_text
from vsb.tools.stamps import check_output

FORMATS = ("wamit", "bemio")


def read_source(
    kind: str,
    path: str,
    water: Water,
    length: float = 1.0,
    bodies: int | None = None,
    modes: Sequence[int] | None = None,
) -> xr.Dataset:
    """Return a hydro database: this project's, or one of another code, which is not yet checked.

    Raises `DatabaseError` if the file is none of its kind.

    Parameters
    ----------
    kind : "database", "wamit" or "bemio"
        A database is this project's netCDF file or capytaine's.
    path : str
        Of the file; of WAMIT's files without their endings.
    water : Water
        Of WAMIT's run, whose files do not state it.
    length : float
        WAMIT's ULEN [m].
    bodies, modes : int and sequence of int, optional
        Number of WAMIT's bodies, and of the modes of each, where its files do not state it.
    """
    if kind == "wamit":
        return import_wamit(
            Path(path).parent,
            Path(path).name,
            density=water.density,
            gravity=water.gravity,
            length=length,
            depth=water.depth,
            bodies=bodies,
            modes=modes,
        )
    if kind == "bemio":
        return read_bemio(path)
    return open_database(path) if is_own(path) else read_capytaine(path)


def is_own(path: str) -> bool:
    """Return whether a netCDF file is a database of this project."""
    try:
        with open_regular(path), netCDF4.Dataset(path) as file:
            return "separate_sweep" in file.ncattrs()
    except (OSError, RuntimeError) as error:
        raise DatabaseError(f"{path}: cannot be read: {reason_of(error)}; needs a hydro database as netCDF.") from None


def source_checks(ds: xr.Dataset, dofs: Sequence[str] | None = None) -> tuple[list[Check], list[str]]:
    """Return the checks stored with a database, or else those of `coefficient_checks` for some degrees of freedom."""
    return (stored_checks(ds), []) if "quality" in ds.attrs else coefficient_checks(ds, dofs=dofs)


def exported(
    path: str | Path, folder: str | Path, name: str, expected_id: str | None = None, inputs: Collection[str | Path] = ()
) -> list[str]:
    """Write a database in every format that it is complete enough for; return the files, and lines on what is left out.

    WAMIT's are FOLDER/NAME.1, .3, .3fk, .3sc, .hst and .mmx with ULEN = 1 m (`wamit_texts`), BEMIO's is FOLDER/NAME.h5
    (`bemio_entries`). The database is this project's, with an `expected_id` that one, or capytaine's. Of files of the
    same name only those that this wrote before are replaced; none is begun unless all can be made. Raises
    `DatabaseError` if the database is complete enough for no format.
    """
    ds = load_database(path, expected_id) if expected_id else read_source("database", str(path), Water())
    contents: dict[Path, Any] = {}
    missing: list[str] = []
    for form in FORMATS:
        try:
            found: dict[str, Any] = (
                dict(wamit_texts(ds, str(path))) if form == "wamit" else {".h5": bemio_entries(ds, str(path))}
            )
        except DatabaseError as error:
            missing.append(f"no {'.h5' if form == 'bemio' else 'WAMIT files'}: {error}")
        else:
            contents |= {Path(folder, f"{name}{ending}"): content for ending, content in found.items()}
    if not contents:
        raise DatabaseError("; ".join(text.removesuffix(".") for text in missing))
    for file in contents:
        check_output(file, inputs, "BEMIO file" if file.suffix == ".h5" else "WAMIT file")
    for file, content in contents.items():
        if isinstance(content, str):
            write_text(file, content)
        else:
            write_h5(content, file)
    files = list(contents)
    if files[0].suffix == ".1":
        known = {"-1": "added_mass_zero" in ds or float(ds.omega[0]) == 0, "0": "added_mass_inf" in ds}
        lines = [f"{files[0]}: without lines PER = {per}, whose added mass {path} does not hold" for per in known]
        missing += [line for line, there in zip(lines, known.values(), strict=True) if not there]
    return [*map(str, files), *missing]
