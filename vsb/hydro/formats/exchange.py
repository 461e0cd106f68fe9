"""Hydro databases as files of other codes."""

from collections.abc import Collection
from pathlib import Path

import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro.database import load_database
from vsb.hydro.formats.bemio import bemio_entries, write_h5
from vsb.hydro.formats.sources import read_source
from vsb.hydro.formats.wamit import wamit_texts
from vsb.study.sections import Water
from vsb.tools.files import write_text
from vsb.tools.stamps import check_output

FORMATS = ("wamit", "bemio")


def opened(path: str | Path, expected_id: str | None = None) -> xr.Dataset:
    """Return a database to be exported: this project's, with an `expected_id` that one, or capytaine's own file."""
    return load_database(path, expected_id) if expected_id else read_source("database", str(path), Water())


def export(
    database_path: str | Path,
    folder: str | Path,
    name: str,
    formats: Collection[str] = FORMATS,
    length: float = 1.0,
    expected_id: str | None = None,
    inputs: Collection[str | Path] = (),
) -> list[Path]:
    """Write a database for other codes and return the files written; none is begun unless all can be made.

    They are FOLDER/NAME.1, .3, .3fk, .3sc, .hst and .mmx of format `wamit` with ULEN = length [m] (see `wamit_texts`)
    and FOLDER/NAME.h5 of format `bemio` (see `bemio_entries`). With an `expected_id` it must be that database.
    Files of the same name are replaced, but neither `inputs` nor products of a run.
    """
    if not formats or set(formats) - set(FORMATS):
        raise DatabaseError(f"formats: received {list(formats)}, needs wamit, bemio or both.")
    ds, source = opened(database_path, expected_id), str(database_path)
    texts = wamit_texts(ds, source, length) if "wamit" in formats else {}
    entries = bemio_entries(ds, source) if "bemio" in formats else {}
    files = [Path(folder) / f"{name}{extension}" for extension in [*texts, *[".h5"] * bool(entries)]]
    for path in files:
        check_output(path, inputs)
    for path, text in zip(files, texts.values(), strict=False):
        write_text(path, text)
    if entries:
        write_h5(entries, files[-1])
    return files


def exported(
    path: str | Path, folder: str | Path, name: str, expected_id: str | None = None, inputs: Collection[str | Path] = ()
) -> list[str]:
    """Write a database in every format that it has enough for; return the files, and lines on what is left out.

    Raises
    ------
    DatabaseError
        If it has enough for none.
    """
    ds = opened(path, expected_id)
    files: list[Path] = []
    missing: list[str] = []
    for form in FORMATS:
        try:
            files += export(path, folder, name, [form], expected_id=expected_id, inputs=inputs)
        except DatabaseError as error:
            missing.append(f"no {'.h5' if form == 'bemio' else 'WAMIT files'}: {error}")
    if not files:
        raise DatabaseError("; ".join(missing))
    if files[0].suffix == ".1":
        known = {"-1": "added_mass_zero" in ds or float(ds.omega[0]) == 0, "0": "added_mass_inf" in ds}
        lines = [f"{files[0]}: without lines PER = {per}, whose added mass {path} does not hold" for per in known]
        missing += [line for line, there in zip(lines, known.values(), strict=True) if not there]
    return [*map(str, files), *missing]
