"""Checks, cost and dry shell frequencies of a study of a buoy before anything is solved."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vsb.engine.hydro import database
from vsb.engine.shell.modes import mode_basis
from vsb.engine.shell.ritz import natural_modes
from vsb.engine.shell.shell import Shell, natural_frequencies
from vsb.engine.waves.kinds import file_lines
from vsb.errors import ConfigError
from vsb.models.rest import check_spring, check_stable, reference_shell, seen_by_take_off
from vsb.models.take_off import check_law
from vsb.pipeline.costs import WITNESS_ROW2_SECONDS, block_seconds, latching_seconds
from vsb.pipeline.graph import StudyPlan
from vsb.study.resolution import no_witness
from vsb.study.specs import PanelsBlock
from vsb.study.study import Study
from vsb.tools.files import load

SECONDS_PER_INSTANT, NOTABLE = 1e-4, 60.0
"""Seconds per instant at which switches are looked for, measured with 13 modes, and from which on a run is long."""
FROM_REST = 8.0
"""Factor where a motion from rest absorbs less than the trials predict: then all times are tried from rest."""


@contextlib.contextmanager
def load_advised(study: Study) -> Iterator[None]:
    """Say in an error of a shell that does not carry its load what would carry it, tried now."""
    try:
        yield
    except ConfigError as error:
        from vsb.models.viability import advised  # only now: it imports what solves

        raise advised(study, error) from None


def check(plan: StudyPlan) -> None:
    """Raise what would fail later: shells that give way, clamps that leave nothing free, unreadable or foreign files.

    Raises `ConfigError` or `DatabaseError`.
    """
    from vsb.models.viability import check_rests_advised  # only now: it imports what solves

    study = plan.study
    with load_advised(study):
        reference = reference_shell(study)
        check_stable(study, seen_by_take_off(study, reference)[0])
    check_spring(study, reference)
    check_rests_advised(study, reference)
    if study.needs_bem:
        plan.check_waves()
    study.check_record()
    study.check_dampers()
    check_law(study.pto)
    if not study.needs_bem:
        return
    if Path(plan.database.out).exists():
        database.load_database(plan.database.out, plan.database.id)
    blocks = [plan.block_path(block) for block in plan.sweep_blocks + plan.tabulated_blocks]
    for path in [*blocks, plan.radiation.out]:
        if Path(path).exists():
            load(path)


def summary(plan: StudyPlan) -> list[str]:
    """Return the lines `vsb check` prints: what would be computed, at what cost, and the validity known beforehand."""
    study = plan.study
    check(plan)
    lines = [
        f"study        {study.study}: {', '.join(study.designs)} in {', '.join(wave.label for wave in study.waves)}",
        f"modes        {len(plan.mode_labels)} shell modes ({study.modes.basis}, degree {study.modes.max_degree})",
        *(_bem_lines(plan) if study.needs_bem else ["hydro        assumed pressure: no BEM"]),
        *file_lines(study.waves),
        *_latching_lines(study),
        *_switching_lines(study),
    ]
    if study.reference_shape == "equilibrium" and not study.at_equilibrium:
        lines.append("note         reference_shape: without a flexible design the rigid buoy is the undeformed sphere")
    from vsb.results import ledger  # of no campaign: it reads all that runs in time

    checks = [*ledger.angle_checks(study), *ledger.shell_checks(study, reference_shell(study))]
    if study.hydro.model != "assumed_pressure":  # which uses the period alone
        checks += ledger.seas_checks(study)
    return [*lines, *(one.line for one in checks)]


def _bem_lines(plan: StudyPlan) -> list[str]:
    """What BEM would do, and how long it would take."""
    study, blocks = plan.study, list(plan.bem_blocks.values())
    todo = [block for block in blocks if not Path(plan.block_path(block)).exists()]
    how = f"spectral, to {study.hydro.tolerance:g}"
    if study.uses_panels:  # the finest mesh
        finest = [block.mesh for block in blocks if isinstance(block, PanelsBlock)][-1]
        how = f"{finest.rows} rows of {finest.azimuth} panels"
    seconds = sum(block_seconds(block) for block in todo)
    return [
        f"hydro        {sum(len(block.omega) for block in blocks)} frequencies up to {study.hydro.omega_max:g} "
        f"rad/s, {how}",
        f"to solve     {len(todo)} of {len(blocks)} blocks of frequencies, at most about {seconds:.0f} s on one core",
        f"database     {plan.database.out}" + (" (there)" if Path(plan.database.out).exists() else ""),
        f"cross-check  {_witness_words(plan)}",
    ]


def _latching_lines(study: Study) -> list[str]:
    """How long the search for latching times would take."""
    if not study.pto.has_latching_time:
        return []
    designs = [one.flexible for one in study.designs.values()]
    seconds = sum(latching_seconds(study, wave, flexible=one) for wave in study.waves for one in designs)
    return [
        f"latching     times of {study.pto.law} are found in each run: about {seconds:.0f} s on one core, up to "
        f"{FROM_REST * seconds:.0f} s where motions from rest absorb less than the trials predict"
    ]


def _switching_lines(study: Study) -> list[str]:
    """How long a run under a nonlinear take-off takes, of a shell so stiff that this matters."""
    if not (study.pto.nonlinear and study.flexible) or study.pto.of_package:
        return []
    from vsb.engine.integrators.switching import RESOLVED  # compiled

    rate = float(reference_shell(study).basis.dry_frequencies.max(initial=0.0))
    seconds = SECONDS_PER_INSTANT * study.simulation.duration * rate / RESOLVED
    return [
        f"switches     looked for at the pace of the stiffest shell mode, {rate:.3g} rad/s in air: up to about "
        f"{seconds:.0f} s for each run on one core"
    ] * (seconds > NOTABLE)


def _witness_words(plan: StudyPlan) -> str:
    """What a second solver would be asked, and how long both would take."""
    if not (deformed := plan.deformed) or not (witness := plan.witness):
        return f"none: {no_witness(plan.study)}"
    meshes = deformed.spec["shapes"]
    shapes, rows = meshes.count, meshes.rows
    there = Path(witness.out).exists()
    seconds = "there" if there else f"about {shapes * WITNESS_ROW2_SECONDS * rows**2:.0f} s on one core"
    work = f"{shapes} shapes at {len(witness.spec['omega'])} frequencies"
    return f"{work}, by panels in {rows} rows and by the spectral solver: {seconds}"


def shell_table(study: Study) -> dict[str, Any]:
    """Return dry frequencies [rad/s] of both branches in closed form, the paper's Ritz column, buckling pressure [Pa].

    Of another shape than the sphere the natural ones alone, by the label of their mode.
    """
    shell = Shell.of(study.device)
    if shell.rest is not None:
        omega = natural_modes(shell, max(1, study.modes.max_degree)).omega
        return {"natural": [{"mode": f"Shell{i}", "omega": float(w)} for i, w in enumerate(omega, 1)]}
    degrees = range(study.modes.max_degree + 1)
    closed = {n: natural_frequencies(shell, n) for n in degrees}
    paper = mode_basis(study.device, "paper", study.modes.max_degree)
    return {
        "membrane": [{"degree": n, "omega": float(closed[n][1])} for n in degrees],
        "bending": [{"degree": n, "omega": float(closed[n][0])} for n in degrees if n >= 2],
        "paper_ritz": [{"degree": n, "omega": float(w)} for n, w in zip(degrees, paper.dry_frequencies, strict=True)],
        "buckling_pressure": shell.buckling_pressure,
    }


def shell_text(table: dict[str, Any]) -> str:
    """Return the shell's frequencies as a table for people."""
    if "natural" in table:
        lines = [f"{row['mode']:>8} {row['omega']:15.9f}" for row in table["natural"]]
        return "\n".join([f"{'mode':>8} {'natural':>15}   [rad/s]", *lines])
    bending = {row["degree"]: row["omega"] for row in table["bending"]}
    lines = [f"{'n':>3} {'membrane':>15} {'bending':>15} {'paper Ritz':>15}   [rad/s]"]
    for membrane, paper in zip(table["membrane"], table["paper_ritz"], strict=True):
        n = membrane["degree"]
        lower = f"{bending[n]:15.9f}" if n in bending else f"{'-':>15}"
        lines.append(f"{n:3} {membrane['omega']:15.9f} {lower} {paper['omega']:15.9f}")
    return "\n".join([*lines, f"classical buckling pressure {table['buckling_pressure']:.6g} Pa"])
