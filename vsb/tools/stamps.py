"""Stamps of result files: content id of the specification, and checksum of the contents.

NetCDF files have them as attributes `spec_id` and `checksum`; all other products of a study in its manifest.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from vsb.errors import DatabaseError
from vsb.tools.files import CHANGED, DELETE, attributes, carries_stamp, check_file, locked, reason_of, write_text
from vsb.tools.words import csv_text, shortened

MANIFEST = "manifest.json"
_BEGINNINGS = {
    "table of studies": (".csv", rb"study,point,design,sea,tuning,"),
    "page": (".html", rb'(?s:.*)<meta name="generator" content="vsb">'),
    "time series": (".csv", rb"time \[s\],(wave_elevation \[m\],)?bodies_position"),
    "figure": (".svg", rb"(?s:.*)<dc:title>vsb</dc:title>"),
    "PDF of a figure": (".pdf", rb"%PDF(?s:.*)/Creator \(vsb\)"),
    "PNG of a figure": (".png", rb"\x89PNG(?s:.*)Software\x00vsb"),
    "WAMIT file": ("", rb" WAMIT's form: ULEN "),
}
"""Endings of files that are written under a name the user chooses, and what they hold, by what they are."""
_MARKS = {"ptos_forceTotal": "time series", "tried_error": "shape dependence", "added_mass": "hydro database"}
"""Variables that only netCDF files of one kind have, by the first that is there."""
_LONGEST = 4096


@dataclass(frozen=True)
class Stamp:
    """Stamp of a product that is not a netCDF file."""

    spec_id: str
    checksum: str  # sha256 of its bytes
    size: int

    def __post_init__(self) -> None:
        """Check the form: a manifest may have been edited."""
        known = isinstance(self.spec_id, str) and re.fullmatch(r"[0-9a-f]{16}|capytaine [\w.]+", self.spec_id)
        summed = isinstance(self.checksum, str) and re.fullmatch("[0-9a-f]{64}", self.checksum)
        if not (known and summed and type(self.size) is int and self.size >= 0):
            raise ValueError("no stamp of an id, a checksum and a size")

    @classmethod
    def of(cls, path: str | Path, spec_id: str) -> "Stamp":
        """Return the stamp of a file as it is."""
        content = Path(path).read_bytes()
        return cls(spec_id, hashlib.sha256(content).hexdigest(), len(content))


class Fault(NamedTuple):
    """Why a file is not what it should be.

    `nameless` files have no stamp, `stale` ones that of another specification, `damaged` ones cannot be read or have
    changed contents.
    """

    path: str
    kind: Literal["nameless", "stale", "damaged"]
    reason: str


Manifest = dict[str, Stamp]
"""Stamps by path."""


def read_manifest(path: str | Path) -> Manifest:
    """Return the stamps of a manifest by path; none if there is no manifest.

    Raises `DatabaseError` if it is no manifest, or names files outside the results.
    """
    folder = Path(path).parent
    try:
        stored = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise DatabaseError(f"{path}: cannot be read as a manifest ({reason_of(error)}); {DELETE}.") from None
    try:
        return {_inside(folder, name): Stamp(**entry) for name, entry in stored.items()}
    except ValueError as error:
        raise DatabaseError(f"{path}: cannot be read as a manifest ({shortened(str(error))}); {DELETE}.") from None
    except (TypeError, AttributeError):
        raise DatabaseError(f"{path}: cannot be read as a manifest (no stamp by file); {DELETE}.") from None


def _inside(folder: Path, name: str) -> str:
    """Path of a product by its name in the manifest of a study's folder, within the results."""
    results = os.path.abspath(folder / os.pardir)
    if os.path.isabs(name) or os.path.commonpath([results, os.path.abspath(folder / name)]) != results:
        raise ValueError(f"{name!r} is outside the results")
    return os.path.normpath(folder / name)


def check_output(path: str | Path, inputs: Iterable[str | Path], kind: str) -> None:
    """Check that an output file named by a user can be written and replaces at most earlier output of its own kind.

    Raises `DatabaseError` if it cannot be written, or is an input, a study file, a product of a run, a file of the user
    or an output of another kind.

    Parameters
    ----------
    path : str or Path
        File to write.
    inputs : iterable of paths
        Files that are read.
    kind : str
        What is written, as `kind_of` names it.
    """
    check_file(path)
    if not os.path.exists(path):
        return
    found = kind_of(Path(path))
    kinds = {
        "an input of this command": any(os.path.exists(one) and os.path.samefile(path, one) for one in inputs),
        "a study file": Path(path).suffix in (".yaml", ".yml"),
        "a product of a run": _is_product(Path(os.path.abspath(path))),
        "no earlier output of vsb": found is None,
        f"a {found} of vsb, no {kind}": found != kind,
    }
    for words in (words for words, true in kinds.items() if true):
        raise DatabaseError(f"{path}: is {words}, which would be lost; needs another name for the output")


def check_product(path: str | Path, rule: str, stage: str) -> None:
    """Check that a file which a rule of the workflow writes replaces at most an earlier product of it.

    Of netCDF that is one whose specification is of the same stage. A folder may be empty, or hold results. Raises
    `DatabaseError` if it is a file of the user, or of another stage.
    """
    place = Path(os.path.abspath(path))
    if place.is_dir():
        own = not any(place.iterdir()) or any((folder / MANIFEST).is_file() for folder in (place, *place.parents[:3]))
        known = (*place.glob("*.nc"), *place.glob("*/*.nc"))  # such as the starts of a design, before its manifest
        own = own or any(map(carries_stamp, known))
    elif place.suffix == ".nc":
        made = re.search(r'"stage":"(\w+)"', _held(place)[1]) if place.exists() else None
        own = not place.exists() or (carries_stamp(place) and (made is None or made[1] == stage))
    else:
        own = not place.exists() or place.name == MANIFEST or kind_of(place) is not None or _is_product(place)
    if not own:
        raise DatabaseError(f"{path}: is no earlier output of the rule {rule}, and would be lost; needs another name")


def kind_of(path: Path) -> str | None:
    """Return what of this package a file is that stands under a name of the user's; None if it is none of it."""
    if path.suffix in (".nc", ".h5"):
        if not carries_stamp(path):
            return None
        names, _ = _held(path)
        of_netcdf = next((kind for name, kind in _MARKS.items() if name in names), "result")
        return "BEMIO file" if path.suffix == ".h5" else of_netcdf
    try:
        with path.open("rb") as file:
            held = file.read(_LONGEST)
            file.seek(max(_LONGEST, path.stat().st_size - _LONGEST))
            held += file.read()
    except OSError:
        return None
    endings = {ending for ending, _ in _BEGINNINGS.values()}
    suffix = path.suffix if path.suffix in endings else ""
    return next((kind for kind, (end, text) in _BEGINNINGS.items() if end == suffix and re.match(text, held)), None)


def _held(path: Path) -> tuple[set[str], str]:
    """Names of the variables of a netCDF file, and its specification; none if it is damaged."""
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            return {*file.variables}, str(file.getncattr("spec")) if "spec" in file.ncattrs() else ""
    except OSError:
        return set(), ""


def _is_product(path: Path) -> bool:
    """Whether a file is of the results: named by its content id, or in a folder with a manifest as one of its files."""
    manifests = [one for folder in path.parents[:4] if (one := folder / MANIFEST).is_file()]
    if path.suffix == ".nc":
        return bool(manifests or re.fullmatch("[0-9a-f]{16}", path.stem)) and carries_stamp(path)
    try:
        return any(str(path) in read_manifest(manifest) for manifest in manifests)
    except DatabaseError:
        return True  # it may be a product


def record(manifest: str | Path, spec_id: str, paths: Iterable[str | Path]) -> None:
    """Put the stamps of files just written into a manifest; those of missing files are dropped.

    Jobs of one study share the manifest. An unreadable one is replaced; its other products are computed again.
    """
    written = {os.path.normpath(path): Stamp.of(path, spec_id) for path in paths}
    Path(manifest).parent.mkdir(parents=True, exist_ok=True)
    with locked(Path(manifest).with_name(f".{MANIFEST}.lock")):
        try:
            stamps = read_manifest(manifest) | written
        except DatabaseError:
            stamps = written
        there = {path: stamp for path, stamp in stamps.items() if os.path.isfile(path)}
        stored = {Path(os.path.relpath(path, Path(manifest).parent)).as_posix(): asdict(s) for path, s in there.items()}
        write_text(manifest, json.dumps(stored, indent=1, sort_keys=True) + "\n")


def read_text(path: str | Path, manifest: str | Path, expected: str) -> str:
    """Read a text product after comparing it with its stamp.

    Raises `DatabaseError` if the file is missing, not the one expected, or damaged.
    """
    if not Path(path).is_file():
        raise DatabaseError(f"{path}: file not found; run the rule that makes it (vsb run CONFIG).")
    if fault := text_fault(path, expected, read_manifest(manifest)):
        raise DatabaseError(f"{path}: {fault.reason}; {DELETE}.")
    return Path(path).read_text(encoding="utf-8")


def faults(files: Mapping[str, str], manifest: Manifest) -> list[Fault]:
    """Return the faults of existing files.

    Parameters
    ----------
    files : mapping path -> content id
    manifest : mapping path -> Stamp
    """
    look = {path: netcdf_fault if path.endswith(".nc") else text_fault for path in files if os.path.exists(path)}
    found = (fault_of(path, files[path], manifest) for path, fault_of in look.items())
    return [fault for fault in found if fault]


def text_fault(path: str | Path, expected: str, manifest: Manifest) -> Fault | None:
    """Return why a product that is no netCDF file is not what it should be."""
    stamp = manifest.get(os.path.normpath(path))
    if stamp is None:
        return Fault(str(path), "nameless", "is not in the manifest")
    if stamp.spec_id != expected:
        return Fault(str(path), "stale", f"is of {stamp.spec_id!r}, needs {expected!r}")
    if os.stat(path).st_size != stamp.size or Stamp.of(path, expected) != stamp:
        return Fault(str(path), "damaged", CHANGED)
    return None


def netcdf_fault(path: str | Path, expected: str, _: Manifest) -> Fault | None:
    """Return why a netCDF file is not what it should be."""
    try:
        attrs = attributes(path)
    except DatabaseError as error:
        return Fault(str(path), "damaged", str(error).removeprefix(f"{path}: "))
    if "spec_id" not in attrs:
        return Fault(str(path), "nameless", "carries no stamp")
    if attrs["spec_id"] != expected:
        return Fault(str(path), "stale", f"is of {attrs['spec_id']!r}, needs {expected!r}")
    return None if "checksum" in attrs else Fault(str(path), "damaged", "carries no checksum of its contents")


def check_table(path: str | Path, head: Iterable[object]) -> None:
    """Check, before hours of work, that a table can be written and replaces at most an earlier one of its columns.

    Raises `DatabaseError` if it cannot be written, or is any other file.
    """
    check_file(path)
    if Path(path).exists():
        columns = csv_text(head, []).encode()
        with Path(path).open("rb") as file:
            if file.read(len(columns)) != columns:
                raise DatabaseError(
                    f"{path}: is no earlier table of this command, and would be lost; needs another name for the output"
                )
