"""Rule compare: comparison table, statistics, validity ledger."""

import json
from dataclasses import asdict, replace
from typing import Any, NamedTuple

from vsb.engine.hydro.database import Check, stored_checks
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.waves.kinds import IrregularSea, Wave
from vsb.engine.waves.seas import NO_WAVES, expected
from vsb.keys.quantities import canonical
from vsb.models.floating_system import expected_sea, floating_system, study_sea
from vsb.models.rest import reference_shell
from vsb.results import comparison, ledger
from vsb.results import statistics as irregular
from vsb.results.forecast import Elsewhere, elsewhere
from vsb.results.gains import (
    AtForce,
    Limited,
    Tuned,
    at_force,
    equal_tuning,
    fair_damping_checks,
    reference_power_checks,
    within_limits,
)
from vsb.results.ladder import ControlLevel, constrained_checks, material_checks
from vsb.results.mean_power import linear_seas, mean_powers, of_seas, with_mean_powers, with_record_intervals
from vsb.results.run_checks import agreement_checks, law_checks, sea_checks, transient_checks
from vsb.stages.stored import Inputs
from vsb.study.specs import CompareSpec
from vsb.tools.files import write_text
from vsb.tools.stamps import read_text, record


def run_compare(spec: CompareSpec, trajectories: str, **files: str) -> None:
    """Write the comparison table, statistics of irregular seas, the validity ledger and the study in canonical form.

    Those are for people; what the report reads is one file of checked data, `tables`.
    """
    compared = spec.study
    found = Inputs(compared, trajectories, files)
    buoy = compared.buoy
    reference = reference_shell(buoy) if buoy else None
    in_seas = [in_a_sea(found, reference.basis if reference else None, wave) for wave in compared.waves]
    rows = [row for one in in_seas for row in one.rows]
    runs = {run: attrs for one in in_seas for run, attrs in one.runs.items()}
    checks = [check for one in in_seas for check in one.checks]
    if buoy and reference:
        checks = [*ledger.shell_checks(buoy, reference), *checks]
    checks += [*ledger.angle_checks(compared), *transient_checks(runs, rows), *law_checks(runs)]
    lines: list[irregular.Line] = []
    tuned: list[Tuned] = []
    limited: list[Limited] = []
    controlled: list[AtForce] = []
    other_seas: list[Elsewhere] = []
    if compared.needs_bem:
        samples = {run: kept for one in in_seas for run, kept in one.samples.items()}
        lines = irregular.statistics(compared, samples)
        ladder = [
            ControlLevel(**row)
            for row in json.loads(read_text(files["levels"], files["manifest"], found.plan.ladder.id))
        ]
        checks += of_the_water(found, rows, runs, linear_seas(compared, runs, ladder))
        means = mean_powers(compared, rows, runs, ladder, found.response, samples)
        tuned, limited = equal_tuning(compared, ladder, means, runs), within_limits(compared, ladder)
        controlled = at_force(compared, ladder)
        if controlled and not (compared.pto.several or compared.plates):
            other_seas = elsewhere(compared, floating_system(compared, found.path("database")), compared.drawn_waves)
        rows, lines = with_mean_powers(rows, means), of_seas(compared, lines, means)
        checks += irregular.statistical_checks(compared, lines)
        checks += [*fair_damping_checks(tuned, compared.pto), *constrained_checks(ladder)]
        checks += [*reference_power_checks(compared, ladder), *material_checks(compared.pto, ladder)]
        checks += (
            [*ledger.mode_checks(buoy, ladder), *ledger.ring_width_checks(buoy, found.path("database"))] if buoy else []
        )
    elif buoy:
        checks += ledger.assumed_pressure_checks(buoy, rows)
        rows = with_mean_powers(rows, mean_powers(compared, rows, runs, (), None, {}))
    checks = ledger.worst_first(checks)
    invalid = ledger.invalid_designs(compared, checks)
    data = {
        "comparison": rows,
        "statistics": [line._asdict() for line in lines],
        "equal_tuning": [line._asdict() for line in tuned],
        "within_limits": [line._asdict() for line in limited],
        "at_force": [line._asdict() for line in controlled],
        "elsewhere": [line._asdict() for line in other_seas],
        "checks": [asdict(check) for check in checks],
        "invalid": [line._asdict() for line in invalid],
    }
    texts = {
        files["out"]: comparison.as_csv(rows),
        files["statistics"]: irregular.as_csv(lines),
        files["validity"]: ledger.ledger_json(compared.study, checks, invalid),
        files["study"]: canonical(compared) + "\n",
        files["tables"]: json.dumps(data, indent=1, allow_nan=False) + "\n",
    }
    for path, text in texts.items():
        write_text(path, text)
    record(files["manifest"], found.plan.identity, list(texts))


def of_the_water(
    found: Inputs, rows: list[comparison.Row], runs: comparison.Attributes, linear: set[str]
) -> list[Check]:
    """Return the checks of linear hydrodynamics: waves, coefficients, radiation memory, time and frequency domain.

    Of a buoy also the limit of its power, and what a second solver says. `linear` names the seas whose runs are.
    """
    study, database = found.study, found.database
    buoy = study.buoy
    checks = [ledger.limit_check(found.response)] if buoy else []
    checks += ledger.radiation_checks(found.radiation, study.hydro.tolerance)
    checks += [*ledger.seas_checks(study, database, linear), *agreement_checks(study, found.response, rows, runs)]
    checks += [replace(check, name=f"hydro {check.name}") for check in stored_checks(database)]
    return checks + (ledger.witness_checks(buoy, database, found.witness) if buoy else [])


class InASea(NamedTuple):
    """What the runs in a sea leave for the comparison; all runs at a time may be more than memory holds."""

    rows: list[comparison.Row]
    checks: list[Check]
    runs: dict[tuple[str, str], dict[str, Any]]  # their attributes
    samples: dict[tuple[str, str], irregular.Sample]  # of an irregular sea


def in_a_sea(found: Inputs, basis: ModeBasis | None, wave: Wave) -> InASea:
    """Return what the runs of all designs in a sea leave."""
    study, label = found.study, wave.label
    waves, spectral, whole = NO_WAVES, NO_WAVES, NO_WAVES
    if study.needs_bem:
        waves, spectral = (study_sea(study, one, found.database) for one in (wave, expected(wave)))
        whole = expected_sea(study, wave, found.database)
    runs = {design: found.runs[design, label] for design in study.designs}
    samples = {}
    if study.needs_bem and isinstance(wave, IrregularSea):
        response = found.response
        samples = {
            (d, label): irregular.sample(study, wave, d, run, waves, spectral, response, whole)
            for d, run in runs.items()
        }
    return InASea(
        with_record_intervals(study, wave, comparison.comparison(study, wave, runs, whole), samples),
        sea_checks(study, wave, runs, basis, found.database),
        {(design, label): run.attrs for design, run in runs.items()},
        samples,
    )
