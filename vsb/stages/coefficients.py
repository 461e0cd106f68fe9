"""Rule coefficients: the hydro database of a body, solved of its mesh or read from files, its matrices with it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from vsb import __version__
from vsb.engine.hydro import database, quality
from vsb.engine.hydro.bodies.body import FlexibleBody
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.solution import (
    blocks_of,
    check_solvable,
    history_of,
    refined_file,
    solve,
    solved,
    table_in,
)
from vsb.engine.hydro.database import Check
from vsb.engine.hydro.formats import bemio, checks, nemoh, wamit
from vsb.engine.hydro.formats.checks import LARGEST_MASS_ERROR, displaced_mass_checks
from vsb.engine.hydro.formats.common import check_positive, volume_of
from vsb.engine.hydro.formats.exchange import read_source, source_checks
from vsb.engine.hydro.panels.bem import stored_green_function
from vsb.engine.hydro.repairs import failures_as_doubts, repaired, with_conjugated_forces, with_symmetric_stiffness
from vsb.engine.hydro.variables import PAIR, of_bodies
from vsb.engine.motion.linear import LinearSystem
from vsb.models.body import check_water, chosen, complete_body, with_hydrostatics, within_band, without_negative_ends
from vsb.pipeline.graph import frequencies
from vsb.pipeline.jobs import workers
from vsb.stages.stage import CAN_FORK, Stamp, run_side_by_side
from vsb.study.body import REPAIRS, Body
from vsb.study.specs import BodySource
from vsb.tools.files import save, write_text

_KEPT = (
    "displaced_volume",
    "centre_of_buoyancy",
    "centre_of_mass",
    "rotation_centre",
    "bem_seconds",
    "symmetry",
    "history",
)
"""Facts of the database read or solved that stay."""
_OWN_MASS_ERROR = 0.05
"""Difference of mass and water displaced beyond which a body does not float, of one that is meshed here."""
REMEDY = "use smaller panels or other frequencies, keep fewer of them (hydro.omega_max)"
"""What helps a body of which a check fails."""


def run_coefficients(source: BodySource, out: str, stamp: Stamp, **files: str) -> None:
    """Solve or read the coefficients of a body, check them, and store them with its matrices.

    Raises `ConfigError` or `DatabaseError` if a file is not what it should be, or a check fails that the study does not
    accept.
    """
    if isinstance(source.body.file, BodyFile):
        found = finely_solved(source.body.file, source.accept, files, files["folder"], files["green"])
    else:
        body = source.body
        found = read_source(body.kind, files[body.kind], source.water, body.length, body.bodies, body.modes)
    check_water(source.water, found)
    store(source, within_band(found, source.omega_max), out, stamp)


def run_frequencies(body: BodyFile, omega: list[float], out: str, **files: str) -> None:
    """Solve some frequencies of a body, each to a file of its own, where its database finds them."""
    _solve_frequencies(body, omega, files)
    write_text(out, f"{len(omega)} frequencies\n")


def _solve_frequencies(body: BodyFile, omega: Sequence[float], files: Mapping[str, str]) -> None:
    """The same without a note that it is done."""
    blocks = blocks_of(body, build_body(body, files), files["folder"], files["green"])
    for one in omega:
        blocks(one)


def solve_body(study: BodyFile, body: FlexibleBody, config: str, out: str) -> list[Check]:
    """Solve a body into the database `out`/<name>.nc on all cores where that takes long, and return the verdict."""
    table, folder = table_in(out), Path(config).parent
    sources = {name: str(folder / path) for name, path in study.paths.items()} | {"folder": out, "green": str(table)}
    some = list(frequencies(study, sources, (), out))
    if CAN_FORK and (count := workers(some)) > 1:
        check_solvable(study, body)
        stored_green_function(table)
        run_side_by_side(
            some,
            lambda task: _solve_frequencies(task.spec["body"], task.spec["omega"], task.files),
            count,
            lambda *_: None,
        )
    return solve(study, body, out)


def finely_solved(
    file: BodyFile, accept: Sequence[str], files: Mapping[str, str], folder: str, table: str = "", green: Any = None
) -> xr.Dataset:
    """Return coefficients of a body file, on smaller panels while a check fails that they may mend; see `solved`."""
    history: list[str] = []
    while True:
        mesh = build_body(file, files)
        found, checks = solved(file, mesh, folder, table, green)
        checks = [check for check in checks if check.name not in accept]
        finer = refined_file(file, mesh, checks)
        if finer is None:
            return database.with_history(found, *history)
        history.append(history_of(file, finer, checks))
        file = finer


class Judged(NamedTuple):
    """A body of a study, its database with the repairs asked for, its checks, and what is not checked."""

    body: LinearSystem
    database: xr.Dataset
    checks: list[Check]
    unseen: list[str]


def judged(source: BodySource, found: xr.Dataset) -> Judged:
    """Return a body from coefficients solved or read, judged in the degrees of freedom its designs move in.

    Raises `ConfigError` or `DatabaseError` if matrices or degrees of freedom are missing, or a check fails that the
    study does not accept.
    """
    found, conjugated = with_hydrostatics(source.body, found), list[Check]()
    if "phases" in source.repair:
        found, check = with_conjugated_forces(found)
        conjugated.append(check)
    if "positive_damping" not in source.repair:
        found = without_negative_ends(found, chosen(source.dofs, list(map(str, found.influenced_dof.values))))
    body = complete_body(source.body, source.dofs, found)
    kept = list(body.labels)
    checks, unseen = source_checks(found, kept)
    _, symmetry = with_symmetric_stiffness(found.sel(influenced_dof=kept, radiating_dof=kept))
    known = (check for check in of_own_mass(checks, source.body, body) if check.name != "hydrostatic_symmetry")
    checks = [*known, *symmetry]  # of what is kept, whatever is stored of all
    mended, repairs = repaired(body.database, source.repair)
    ds = mended.assign(structural_damping_matrix=(PAIR, body.structural_damping))
    checks = [*failures_as_doubts(checks, source.repair), *conjugated, *repairs]
    return Judged(body, ds, quality.judged(checks, source.accept, REMEDY, REPAIRS), unseen)


def of_own_mass(checks: Sequence[Check], given: Body, body: LinearSystem) -> list[Check]:
    """Return checks with that of the displaced mass made of the study's own mass, where it gives one."""
    if given.mass is None:
        return list(checks)
    largest = _OWN_MASS_ERROR if given.kind == "file" else LARGEST_MASS_ERROR
    return [
        *(check for check in checks if check.name != "displaced_mass"),
        *displaced_mass_checks(body.database, largest),
    ]


def store(source: BodySource, found: xr.Dataset, out: str, stamp: Stamp) -> None:
    """Write the database of a body, its designs' degrees of freedom alone, and what its numbers are worth."""
    body, ds, checks, unseen = judged(source, found)
    volumes = map(volume_of, of_bodies(body.labels))
    facts = {name: ds.attrs[name] for name in dict.fromkeys([*_KEPT, *volumes]) if name in ds.attrs}
    facts["history"] = "; ".join([text for text in (facts.get("history", ""), *unseen) if text])
    attrs = {
        "title": f"hydro database of a body: {', '.join(body.labels)}",
        "source": f"vsb {__version__}",
        **stamp,
        "quality": database.as_json(checks),
        "water_density": source.water.density,
        "water_depth": str(source.water.depth),
        "gravity": source.water.gravity,
        "solver": found.attrs.get("solver", found.attrs.get("source", "unknown")),
        **facts,
    }
    ds.attrs = {}
    database.save_database(ds.assign_attrs(attrs), None, out)


FACTS = {"density": "kg/m^3", "gravity": "m/s^2", "length": "m", "depth": "m"}
"""What WAMIT's files do not say of a run, and its units."""
Verdict = tuple[list[database.Check], list[str], list[str]]
"""Checks, what was left out of the file or of the checks, and what to look at where a check does not hold."""


def import_wamit(
    folder: str,
    name: str,
    out: str,
    *,
    axisymmetric: bool,
    bodies: int | None = None,
    modes: Sequence[int] | None = None,
    **facts: float,
) -> Verdict:
    """Read WAMIT's output into a database file and return the verdict on it; facts of the run as in `FACTS`."""
    for option, unit in FACTS.items():
        check_positive(f"--{option}", facts[option], unit, infinite=option == "depth")
    ds = wamit.import_wamit(
        folder,
        name,
        density=facts["density"],
        gravity=facts["gravity"],
        length=facts["length"],
        depth=facts["depth"],
        bodies=bodies,
        modes=modes,
    )
    return _stored(ds, out, axisymmetric, checks.WAMIT_WORDS)


def import_bemio(path: str, out: str, *, axisymmetric: bool) -> Verdict:
    """Read BEMIO's .h5 into a database file and return the verdict on it."""
    return _stored(bemio.read_bemio(path), out, axisymmetric, checks.BEMIO_WORDS)


def import_nemoh(folder: str, out: str, *, axisymmetric: bool) -> Verdict:
    """Read a folder of NEMOH into a database file and return the verdict on it."""
    return _stored(nemoh.read_nemoh(folder), out, axisymmetric, checks.NEMOH_WORDS)


def _stored(ds: xr.Dataset, out: str, axisymmetric: bool, words: dict[str, str]) -> Verdict:
    """Store a database of another code with the verdict of the identities that need no other data."""
    found, missing = checks.coefficient_checks(ds, axisymmetric=axisymmetric)
    found += with_symmetric_stiffness(ds)[1]
    notes = [ds.attrs["history"], *missing]
    attrs = {"quality": database.as_json(found), "spec_id": Path(out).stem, "separate_sweep": 0}
    save(ds.assign_attrs(**attrs, history="; ".join(notes)), out)
    return found, notes, [checks.causes(check, words) for check in found if check.verdict != "ok"]
