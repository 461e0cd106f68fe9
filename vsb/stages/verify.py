"""Command verify: whether results are what they should be; and what a run does about those that are not."""

import json
import os
import time
from collections.abc import Sequence
from pathlib import Path

from vsb.errors import DatabaseError, VsbError
from vsb.keys.quantities import id_in, leaves
from vsb.pipeline.graph import AnyPlan, plan_for
from vsb.pipeline.plans import CampaignPlan, DesignPlan, Plan, plan_of
from vsb.stages.stage import shared_lock
from vsb.study.body import read_study
from vsb.tools import packed
from vsb.tools.files import DELETE, attributes
from vsb.tools.stamps import MANIFEST, Fault, Manifest, Stamp, faults, read_manifest

STUDY = "study.json"
"""The study a folder of results is of."""


TRASH = "trash"
"""Folder of the results that a run moves files to which stand in the place of a product."""


def verify(target: str) -> list[str]:
    """Check the results of a study file, of a study's folder, or of that of all results; return the lines to print.

    Contents included. Raises `VsbError` if something is wrong or missing; several of these are printed, a line each.
    """
    folders = [Path(target), *sorted(Path(target).iterdir())] if Path(target).is_dir() else []
    plans: Sequence[Plan] = [plan for one in folders if (one / STUDY).is_file() and (plan := _plan(one))]
    if not folders:
        plans = [plan_of(target)]
    root = Path(plans[0].root if plans else target)
    ids = {path: identity for plan in plans for path, identity in plan.file_ids.items()}
    missing = sorted({path for plan in plans for path in plan.products if not Path(path).exists()})
    found = [*faults(ids, manifests(root)), *_index_faults(root)]
    if Path(target).is_dir():
        found += _other_faults(Path(target), {*ids, *(plan.manifest for plan in plans)}, root / TRASH)
    wrong = {fault.path: f"{fault.path}: {fault.reason}" for fault in found}  # studies share what their manifests name
    lines = [*wrong.values(), *(f"{path}: is not there" for path in missing)]
    if not lines:
        return [f"{target}: {len(ids)} files are what they should be"]
    if len(lines) > 1:
        print(*lines, sep="\n")
    command = f"vsb run {target}" if Path(target).is_file() else "vsb run CONFIG"
    raise VsbError(f"{lines[0]}{_more(lines)}; {'delete what is wrong, then ' if wrong else ''}{command} makes it anew")


def _more(lines: Sequence[object]) -> str:
    """How many others there are."""
    return f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""


def _plan(folder: Path) -> AnyPlan | None:
    """The plan of the study a folder is of; none if the folder does not know it any more, which is a fault."""
    path = folder / STUDY
    stamp = manifests(folder.parent).get(os.path.normpath(path))
    if stamp and Stamp.of(path, stamp.spec_id) != stamp:
        return None
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
        study = read_study(raw, str(path)).study
        return plan_for(study, str(folder.parent))
    except (ValueError, RecursionError, VsbError):
        return None


def _other_faults(folder: Path, known: set[str], trash: Path) -> list[Fault]:
    """Damage among the files of a folder that no plan names: of other studies, seas and designs."""
    found = []

    def others(pattern: str) -> list[Path]:
        return sorted(path for path in folder.rglob(pattern) if trash not in path.parents)

    def unreadable(path: Path, error: DatabaseError) -> Fault:
        return Fault(str(path), "damaged", str(error).removeprefix(f"{path}: "))

    for path in (path for path in others("*.nc") if str(path) not in known and not path.name.startswith(".")):
        try:
            identity = attributes(path).get("spec_id")
        except DatabaseError as error:
            found.append(unreadable(path, error))
            continue
        if id_in(path) == path.stem and identity not in (None, path.stem):
            found.append(Fault(str(path), "damaged", f"holds {identity!r}"))
    for path in (path for path in others(f"*{packed.SUFFIX}") if id_in(path) == path.stem and str(path) not in known):
        try:
            packed.Pack(path).check()
        except DatabaseError as error:
            found.append(unreadable(path, error))
    for path in others(MANIFEST):
        try:
            stamps = {name: stamp for name, stamp in read_manifest(path).items() if name not in known}
            found += faults({name: stamp.spec_id for name, stamp in stamps.items()}, stamps)
        except DatabaseError as error:
            found.append(unreadable(path, error))
    return found


def _index_faults(root: Path) -> list[Fault]:
    """Whether the index of the databases lists those there are."""
    from vsb.engine.hydro.database import index_text

    index, folder = root / "hydro" / "INDEX.tsv", root / "hydro" / "db"
    if not index.is_file() or index.read_bytes() == index_text(folder).encode():
        return []
    return [Fault(str(index), "stale", "does not list the databases there; the next one writes it again")]


def _moved(root: Path, found: Sequence[Fault]) -> list[str]:
    """Move files to the trash; say so."""
    trash, lines = root / TRASH / time.strftime("%Y%m%d-%H%M%S"), []
    for fault in found:
        parts = os.path.relpath(fault.path, root).split(os.sep)
        place = trash.joinpath(*(part for part in parts if part != os.pardir))
        place.parent.mkdir(parents=True, exist_ok=True)
        os.replace(fault.path, place)
        lines.append(f"moved {fault.path} to {place}: {fault.reason}")
    return lines


def manifests(root: Path) -> Manifest:
    """Return the stamps in all manifests of a results folder, those of viewable meshes, which studies share, included.

    One that cannot be read promises nothing: what stands in it is computed again.
    """
    found: Manifest = {}
    for path in sorted([*root.glob(f"*/{MANIFEST}"), *root.glob(f"hydro/mesh/*/{MANIFEST}")]):
        try:
            found |= read_manifest(path)
        except DatabaseError:
            continue
    return found


def study_faults(plan: Plan) -> list[Fault]:
    """Return which files of a study that are there are not what they should be."""
    return faults(plan.file_ids, manifests(Path(plan.root)))


MOST_CHANGES = 6
"""Most changes of a study that are listed."""


def differences(plan: Plan) -> str:
    """Return what a study changes of the one whose results it replaces; empty if there is none, or the same."""
    before = _plan(Path(plan.folder)) if Path(plan.folder, STUDY).is_file() else None
    if before is None or isinstance(plan, CampaignPlan | DesignPlan):
        return ""
    old, new = (leaves(study.model_dump()) for study in (before.study, plan.study))
    changes = [
        f"{key} {old.get(key, 'nothing')} -> {new.get(key, 'nothing')}"
        for key in {**old, **new}
        if old.get(key) != new.get(key)
    ]
    more = f" (and {len(changes) - MOST_CHANGES} more)" if len(changes) > MOST_CHANGES else ""
    return ", ".join(changes[:MOST_CHANGES]) + more


def stale_products(plan: Plan, *, dry: bool) -> list[str]:
    """Return the products a run must make anew, and say so; a file in the place of one goes to the trash.

    It may be one that a user wrote or changed. Nothing is moved if the run is `dry`.

    Raises `DatabaseError` if a file that studies share is damaged or foreign: other results rest on it and it may have
    taken hours, so it is for the user to remove.
    """
    if changes := differences(plan):
        print(f"vsb: {plan.folder} {'holds' if dry else 'held'} another study of this name: {changes}", flush=True)
    stale = study_faults(plan)
    shared = [fault.path for fault in stale if plan.is_shared(fault.path)]
    with shared_lock(plan.root, [] if dry else shared):
        if shared:  # another run may have been making them
            stale = [one for one in study_faults(plan) if one.path in shared or not plan.is_shared(one.path)]
        for fault in stale:
            if plan.is_shared(fault.path) and fault.path.endswith(".nc"):
                raise DatabaseError(f"{fault.path}: {fault.reason}; {DELETE}")
        moved = [] if dry else _moved(Path(plan.root), [one for one in stale if one.kind in ("nameless", "damaged")])
    if stale:
        kept = f", what was there is in {Path(plan.root, TRASH)}" if moved else ""
        print(f"vsb: {stale[0].path}: {stale[0].reason}{_more(stale)}; computed anew{kept}", flush=True)
    return [fault.path for fault in stale]
