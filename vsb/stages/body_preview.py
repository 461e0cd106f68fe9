"""Checks of a body study before anything is solved: its files, its rest, its seas, its cost."""

import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vsb.engine.hydro import database, quality
from vsb.engine.hydro.bodies.body import FlexibleBody
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.solution import check_solvable, cost, history_of, refined_file, solved
from vsb.engine.hydro.bodies.verdict import mesh_checks
from vsb.engine.hydro.database import Check
from vsb.engine.hydro.formats.exchange import read_source
from vsb.engine.hydro.repairs import check_repairable
from vsb.engine.hydro.variables import motion_of
from vsb.engine.motion.frequency import allowed_part, compliance
from vsb.engine.motion.linear import LinearSystem, direction_index
from vsb.engine.waves.kinds import Wave, file_lines
from vsb.errors import ConfigError, StabilityError
from vsb.models.body import check_water, complete_body, dry_database, within_band
from vsb.models.floating_system import floating_body, port_in_seas, study_sea
from vsb.models.take_off import check_law, dragged
from vsb.pipeline.costs import body_seconds, memory_doubts, plain_seconds
from vsb.pipeline.graph import BodyPlan
from vsb.results import ledger
from vsb.stages.coefficients import REMEDY, judged, of_own_mass
from vsb.study.body import REPAIRS
from vsb.tools.arrays import FloatArray
from vsb.tools.files import load

STIFF = 100.0
"""Natural frequency over the highest one of the database from which a motion is held still."""


class CheckedBody(NamedTuple):
    """What is known of a body before it is solved."""

    body: LinearSystem
    checks: list[Check]  # of its files
    mesh: FlexibleBody | None  # if it will be solved on panels
    drifting: dict[str, list[str]]  # of each design, what waves push along and nothing holds


def check(plan: BodyPlan) -> CheckedBody:
    """Return what is known of the body of a study before it is solved, after what would fail later.

    Raises `ConfigError`, `DatabaseError` or `StabilityError` if its files are not what they should be, it is statically
    unstable, nothing moves, or its seas are not in its band.
    """
    study, files, source, mesh = plan.study, plan.files, plan.study.body, None
    if isinstance(source.file, BodyFile):
        mesh = build_body(source.file, files)
        check_solvable(source.file, mesh)
        ds = within_band(dry_database(mesh, source.file), study.hydro.omega_max)
        body = complete_body(source, study.dofs, ds)
        check_repairable(study.hydro.repair, body.database.omega.values)
        checks = quality.judged(
            of_own_mass(mesh_checks(source.file, mesh), source, body), study.hydro.accept, REMEDY, REPAIRS
        )
    else:
        ds = read_source(source.kind, files[source.kind], study.water, source.length, source.bodies, source.modes)
        check_water(study.water, ds)
        body, _, checks, _ = judged(plan.database.spec["source"], within_band(ds, study.hydro.omega_max))
    floating, drifting = floating_body(study, body), {}
    for design, motions in floating.motions.items():
        held = body.held + study.pto.stiffness * np.outer(floating.port, floating.port)
        try:
            loose = body.unrestrained(motions.T @ held @ motions, motions)
        except StabilityError as error:
            raise ConfigError(f"designs.{design}: {_off_axis(checks) or error}") from None
        drifting[design] = drifting_motions(body.labels, motions @ loose, study.waves)
        yields = compliance(motions.T @ held @ motions, allowed_part(floating.port, motions))
        if yields == np.inf and study.pto.stroke_limit < np.inf:
            raise ConfigError(
                f"pto.stroke_limit: received {study.pto.stroke_limit:g} m, but the port of design {design} has "
                "no position of rest to measure it from; needs a mooring that holds it"
            )
    for i, wave in enumerate(study.waves):
        check_wave(i, wave, body)
    dragged(study.plates, body.labels)
    study.check_dampers()
    check_law(study.pto)
    if Path(plan.database.out).exists():
        database.load_database(plan.database.out, plan.database.id)
    if Path(plan.radiation.out).exists():
        load(plan.radiation.out)
    moving = [wave for wave in study.waves if not wave.still]
    if moving and not plan.study.uses_panels:
        seas = [(wave, study_sea(study, wave, body.database)) for wave in moving]
        for design in floating.motions:
            port_in_seas(floating, design, seas)  # raises if the port is not passive where the seas are
    return CheckedBody(body, checks, mesh, drifting)


def drifting_motions(labels: Sequence[str], loose: FloatArray, waves: Sequence[Wave]) -> list[str]:
    """Return the displacements along the waves that nothing holds; `loose` are motions without restoring force.

    The start of waves leaves a body a velocity in them; radiation does not stop what moves steadily.
    """
    if not loose.size:
        return []
    found, free = np.zeros(len(labels)), np.linalg.qr(loose)[0]
    for wave in waves:
        if wave.still:
            continue
        towards = {"Surge": np.cos(np.deg2rad(wave.direction)), "Sway": np.sin(np.deg2rad(wave.direction))}
        along = np.array([towards.get(motion_of(label), 0.0) for label in labels])
        found = np.maximum(found, np.abs(free @ (free.T @ along)))
    named = [motion_of(label) in ("Surge", "Sway") for label in labels]
    return [label for label, size, is_named in zip(labels, found, named, strict=True) if is_named and size > 1e-3]


def held_still(body: LinearSystem) -> list[tuple[str, float]]:
    """Return the motions, with their stiffness, whose dry natural frequency is `STIFF` times the end of the band."""
    inertia, stiffness = np.diag(body.mass), np.diag(body.stiffness)
    still = (inertia > 0) & (stiffness > inertia * (STIFF * float(body.database.omega.values[-1])) ** 2)
    return [(label, float(k)) for label, k, of_it in zip(body.labels, stiffness, still, strict=True) if of_it]


def _off_axis(checks: Sequence[Check]) -> str:
    """Why a body is not in equilibrium upright; nothing if its centres of mass and buoyancy lie on one vertical."""
    trim = next((check for check in checks if check.name == "trim" and check.verdict != "ok"), None)
    if trim is None:
        return ""
    return (
        f"the body is not in equilibrium upright: its centres of mass and buoyancy are {trim.value:.2g} of the cube "
        f"root of the displaced volume apart horizontally, needs at most {trim.limit:g}: correct "
        "centre_of_mass or the mesh"
    )


def check_wave(i: int, wave: Wave, body: LinearSystem) -> None:
    """Check that a sea comes from a direction the database has, and lies in its band; raises `ConfigError`."""
    if wave.still:
        return
    first, last = body.database.omega.values[[0, -1]]
    check_direction(wave.direction, body, f"waves.{i}.direction")
    if wave.of_file:
        wave.check_band(float(first), float(last), f"waves.{i}.file")
        return
    low, high = wave.reach if wave.irregular else (wave.omega, wave.omega)
    if not first - 1e-9 <= high <= last + 1e-9 or (low < first - 1e-9 and not wave.irregular):
        raise ConfigError(
            f"waves.{i} {wave.label}: received a frequency of {high:.4g} rad/s, needs {first:.4g} to {last:.4g} rad/s, "
            "the band of the body's database"
        )


def check_direction(direction: float, body: LinearSystem, where: str) -> None:
    """Check that a body's database has waves of a direction [degrees]; `ConfigError`."""
    known = np.asarray(body.database.wave_direction.values)
    if direction_index(known, float(np.deg2rad(direction))) is None:
        raise ConfigError(
            f"{where}: received {direction:g} degrees, needs one of "
            f"{', '.join(f'{d:g}' for d in np.degrees(known))}, the directions of the body's database"
        )


QUICK = 25.0
"""Seconds within which a body is solved to see what a run would say of it."""


def solved_lines(plan: BodyPlan, file: BodyFile, mesh: FlexibleBody) -> list[str]:
    """Return what the coefficients of a body say of its panels, solved now, unstored, where that takes seconds.

    Panels that fail a check are made smaller, as in the run, and solved again. Raises `DatabaseError` as the run would:
    if a check fails that smaller panels do not mend.
    """
    if Path(plan.database.out).exists():
        return []
    count = len(file.omega)
    if not _quick(file, mesh):
        return [f"panels       not tried: {count} frequencies take more than {QUICK:g} s; the run judges them"]
    from vsb.engine.hydro.panels.bem import quick_green_function  # capytaine

    green, smaller = quick_green_function(), list[str]()
    while True:
        with tempfile.TemporaryDirectory() as folder:
            found, checks = solved(file, mesh, folder, green=green)
        checks = [check for check in checks if check.name not in plan.study.hydro.accept]
        if (finer := refined_file(file, mesh, checks)) is None:
            known = judged(plan.database.spec["source"], within_band(found, plan.study.hydro.omega_max)).checks
            of_mesh = {check.name for check in mesh_checks(file, mesh)}
            doubts = doubt_lines(check for check in known if check.name not in of_mesh)
            tried = f"{count} frequencies tried"
            first = f"panels       {tried}" if doubts else f"ok           panels: {tried}"
            return [_refined(smaller, tried) if smaller else first, *doubts]
        smaller.append(history_of(file, finer, checks))
        file, mesh = finer, build_body(finer, plan.files)
        if not _quick(file, mesh):
            more = plain_seconds(body_seconds(file, cost(file, mesh)[1]))
            return [_refined(smaller, f"not tried: {count} frequencies take about {more}; the run judges them")]


def solving_seconds(plan: BodyPlan) -> float:
    """Return the CPU time of the coefficients of a body on its panels, with the planes of symmetry they have [s]."""
    file = plan.study.body.file
    assert isinstance(file, BodyFile)
    return body_seconds(file, cost(file, build_body(file, plan.files))[1])


def _quick(file: BodyFile, mesh: FlexibleBody) -> bool:
    """Whether the coefficients of a body are solved within seconds."""
    return body_seconds(file, cost(file, mesh)[1]) <= QUICK


def _refined(smaller: Sequence[str], outcome: str) -> str:
    """What is said of panels that the run makes smaller."""
    return f"doubt        panels: as given they fail; in the run {'; '.join(smaller)}; {outcome}"


def summary(plan: BodyPlan) -> list[str]:
    """Return the lines `vsb check` prints: what would be computed, at what cost, and the validity known beforehand."""
    (body, checks, mesh, drifting), study = check(plan), plan.study
    floating, omega = floating_body(study, body), body.database.omega.values
    there = " (there)" if Path(plan.database.out).exists() else ""
    designs = (f"{name} moves in {motions.shape[1]}" for name, motions in floating.motions.items())
    lines = [
        f"study        {study.study}: {', '.join(study.designs)} in {', '.join(wave.label for wave in study.waves)}",
        f"body         {len(body.labels)} degrees of freedom: {', '.join(body.labels)}; {', '.join(designs)}",
        f"hydro        {len(omega)} frequencies from {omega[0]:g} to {omega[-1]:g} rad/s, "
        f"{'solved of the mesh' if plan.study.uses_panels else 'read from ' + plan.files[study.body.kind]}",
        f"database     {plan.database.out}{there}",
        *file_lines(study.waves),
    ]
    if mesh and isinstance(file := study.body.file, BodyFile):
        memory, seconds = cost(file, mesh)
        lines.append(
            f"mesh         {len(mesh.faces)} panels: about {seconds:.2g} s a frequency on one core, {memory:.2g} GB"
        )
        lines += memory_doubts(memory)
        lines += solved_lines(plan, file, mesh)
    lines += [
        f"note         drift: nothing holds {' and '.join(names)} of design {design}: it keeps the velocity the first "
        "waves leave it, and translation may leave linear theory; a mooring (body.stiffness) or other dofs prevent it"
        for design, names in drifting.items()
        if names
    ]
    lines += [
        f"doubt        stiffness: {label} has {stiffness:.3g} N/m (rotations: N m/rad), which hold it still in these "
        "waves; in another unit? A design whose dofs leave it out needs no stiffness"
        for label, stiffness in held_still(body)
    ]
    history = mesh.history if mesh else str(body.database.attrs.get("history", ""))
    lines += [f"note         {part}" for part in history.split("; ") if part and not part.startswith("read from")]
    checks_of_seas = [*ledger.angle_checks(study), *ledger.seas_checks(study, body.database)]
    return [*lines, *doubt_lines(checks), *(check.line for check in checks_of_seas)]


def doubt_lines(checks: Iterable[Check]) -> list[str]:
    """Return the lines of checks of coefficients that do not hold."""
    return [replace(check, name=f"hydro {check.name}").line for check in checks if check.verdict != "ok"]
