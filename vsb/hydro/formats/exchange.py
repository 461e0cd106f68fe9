"""Hydro databases as files of other codes."""

from collections.abc import Collection
from pathlib import Path

from vsb.errors import DatabaseError
from vsb.hydro.database import load_database
from vsb.hydro.formats.bemio import bemio_entries, write_h5
from vsb.hydro.formats.wamit import wamit_texts
from vsb.tools.files import load, write_text
from vsb.tools.stamps import check_output

FORMATS = ("wamit", "bemio")


def export(
    database_path: str | Path,
    folder: str | Path,
    name: str,
    formats: Collection[str] = FORMATS,
    length: float = 1.0,
    expected_id: str | None = None,
    inputs: Collection[str | Path] = (),
) -> list[Path]:
    """Write a stored database for other codes and return the files written; none is begun unless all can be made.

    They are FOLDER/NAME.1, .3, .3fk, .3sc, .hst and .mmx of format `wamit` with ULEN = length [m] (see `wamit_texts`)
    and FOLDER/NAME.h5 of format `bemio` (see `bemio_entries`). With an `expected_id` it must be that database.
    Files of the same name are replaced, but neither `inputs` nor products of a run.
    """
    if not formats or set(formats) - set(FORMATS):
        raise DatabaseError(f"formats: received {list(formats)}, needs wamit, bemio or both.")
    attrs, source = load(database_path).attrs, str(database_path)
    if missing := {"spec_id", "separate_sweep"} - set(attrs):
        raise DatabaseError(f"{source}: holds no {', '.join(sorted(missing))}; needs a hydro database.")
    ds = load_database(database_path, expected_id or attrs["spec_id"])
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
