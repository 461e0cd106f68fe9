"""Command crate: finished results as one RO-Crate, a zip archive that says what is in it.

The metadata follow RO-Crate 1.1 (https://w3id.org/ro/crate/1.1), JSON-LD of schema.org's words: every file with its
type, size, checksum and content id, and the run that made them.
"""

import hashlib
import json
import os
import time
import urllib.parse
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from vsb import __version__
from vsb.errors import VsbError
from vsb.stages.planning import plan_of
from vsb.stages.verify import study_faults
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plans import Plan
from vsb.tools.files import atomic_write
from vsb.tools.stamps import CRATE, MANIFEST

PROFILE = "https://w3id.org/ro/crate/1.1"
GPL = "https://spdx.org/licenses/GPL-3.0-or-later"
FORMATS = {
    ".csv": "text/csv", ".html": "text/html", ".json": "application/json", ".nc": "application/netcdf",
    ".pdf": "application/pdf", ".svg": "image/svg+xml", ".vtu": "application/xml", ".yaml": "application/yaml",
}  # fmt: skip
DESCRIPTIONS = {
    "report.html": "the report: the answer, its figures, what to doubt",
    "comparison.csv": "what each design does in each sea",
    "campaign.csv": "power each design absorbs in a year, point by point",
    "campaign.nc": "power each design absorbs in a year, matrices included",
    "ladder.csv": "power each design absorbs by control level",
    "response.nc": "frequency response and port of each design",
    "statistics.csv": "mean powers of irregular seas with their intervals",
    "validity.json": "the ledger: what was checked, and how it stands",
    "study.json": "the study, every key with its value",
}
"""What files are, by their names."""


def crate(config: str, out: str, licence: str | None = None, author: str | None = None) -> list[str]:
    """Write the results of a study or campaign into an archive; return the lines to print.

    Raises `VsbError` if results are missing, or are not what they should be, or the name is none of an archive.

    Parameters
    ----------
    config : str
        Its file.
    out : str
        Path of the archive.
    licence : str or None
        Address of the licence the results are given under.
    author : str or None
        Who made them.
    """
    if Path(out).suffix != ".zip":
        raise VsbError(f"{out}: received a name without .zip, needs one with it")
    plan = plan_of(config)
    beside = {str(one) for path in plan.products if (one := Path(path).with_name(MANIFEST)).is_file()}
    paths = sorted({*plan.products, plan.manifest, *beside})
    lines = [f"{path}: is not there" for path in paths if not Path(path).is_file()]
    lines += [f"{fault.path}: {fault.reason}" for fault in study_faults(plan)]
    if lines:
        more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
        raise VsbError(f"{lines[0]}{more}; vsb run {config} makes it")
    held = {_inside(plan, path): path for path in paths} | {Path(config).name: config}
    text = json.dumps(metadata(plan, held, Path(config).name, licence, author), indent=1, ensure_ascii=False) + "\n"
    with atomic_write(out) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(CRATE, text)
        for name, path in held.items():
            archive.write(path, name)
    return [f"{out}: {len(held)} files, {Path(out).stat().st_size / 1e6:.1f} MB"]


def _inside(plan: Plan, path: str) -> str:
    """Name of a product in the archive: as in the folder of all results."""
    return PurePosixPath(os.path.relpath(path, plan.root)).as_posix()


def metadata(
    plan: Plan, held: Mapping[str, str], config: str, licence: str | None, author: str | None
) -> dict[str, Any]:
    """Return the metadata of an archive as JSON-LD.

    Parameters
    ----------
    held : mapping name -> path
        Files by their names in the archive.
    config : str
        Which of them the run was asked for by.
    """
    ids = {_inside(plan, path): identity for path, identity in plan.ids.items()}
    newest = max(Path(path).stat().st_mtime for path in held.values())
    kind = "campaign" if isinstance(plan, CampaignPlan) else "design" if isinstance(plan, DesignPlan) else "study"
    own = {"@id": licence or "#licence", "@type": "CreativeWork"}
    words = {"name": licence or "not stated", "description": "what the results may be used for"}
    results = [name for name in held if name != config]
    graph = [
        {"@id": CRATE, "@type": "CreativeWork", "about": _at("./"), "conformsTo": _at(PROFILE)},
        {
            "@id": "./",
            "@type": "Dataset",
            "name": f"{kind} {plan.name}: flexible against rigid in waves",
            "description": f"Results of vsb {__version__}, made from {config}; report.html says what to doubt.",
            "datePublished": time.strftime("%Y-%m-%d", time.gmtime(newest)),
            "license": _at(own["@id"]),
            **({"author": _at("#author")} if author else {}),
            "hasPart": [_at(_address(name)) for name in held],
            "mentions": _at("#run"),
        },
        {
            "@id": "#run",
            "@type": "CreateAction",
            "name": f"vsb run {config}",
            "instrument": _at("#vsb"),
            "object": _at(_address(config)),
            "result": [_at(_address(name)) for name in results],
        },
        {"@id": "#vsb", "@type": "SoftwareApplication", "name": "vsb", "softwareVersion": __version__, "license": GPL},
        own | words,
        *([{"@id": "#author", "@type": "Person", "name": author}] if author else []),
    ]
    return {
        "@context": f"{PROFILE}/context",
        "@graph": [*graph, *(_file(name, path, ids.get(name)) for name, path in held.items())],
    }


def _file(name: str, path: str, identity: str | None) -> dict[str, Any]:
    """One file of an archive."""
    content = Path(path).read_bytes()
    pure = PurePosixPath(name)
    described = {"description": DESCRIPTIONS[pure.name]} if pure.name in DESCRIPTIONS else {}
    known = {"identifier": identity} if identity else {}
    return {
        "@id": _address(name),
        "@type": "File",
        "name": pure.name,
        **described,
        **known,
        "encodingFormat": FORMATS.get(pure.suffix, "application/octet-stream"),
        "contentSize": str(len(content)),
        "sha256": hashlib.sha256(content).hexdigest(),
    }


def _at(identity: str) -> dict[str, str]:
    """A reference to an entity."""
    return {"@id": identity}


def _address(name: str) -> str:
    """A file's name as an address."""
    return urllib.parse.quote(name)
