"""Rule compare: comparison table, statistics, validity ledger."""

import json
from dataclasses import asdict
from pathlib import Path

from vsb.hydro.database import load_database
from vsb.results import comparison, ledger
from vsb.results import statistics as irregular
from vsb.results.equal_tuning import equal_tuning, fair_damping_checks
from vsb.results.ladder import study_ladder
from vsb.stages.trajectories import stored_runs
from vsb.study.plan import StudyPlan
from vsb.study.specs import CompareSpec
from vsb.study.study import canonical
from vsb.tools.files import load, write_text
from vsb.tools.stamps import record
from vsb.waves.seas import NO_WAVES, sea


def run(
    spec: CompareSpec,
    trajectories: str,
    out: str,
    statistics: str,
    validity: str,
    study: str,
    tables: str,
    manifest: str,
    database: str = "",
    radiation: str = "",
    response: str = "",
    witness: str = "",
) -> None:
    """Write the comparison table, statistics of irregular seas, the validity ledger and the study in canonical form.

    Those are for people; what the report reads is one file of checked data, `tables`.
    """
    compared, plan = spec.study, StudyPlan(spec.study)
    runs = stored_runs(compared, trajectories)
    bem = compared.needs_bem
    seas = {
        wave.label: sea(wave, compared.hydro.omega_max, compared.simulation.duration) if bem else NO_WAVES
        for wave in compared.waves
    }
    rows = comparison.comparison(compared, runs, seas)
    checks, lines, tuned = [*ledger.run_ledger(compared, runs), *ledger.transient_checks(runs, rows)], [], []
    if bem:
        ds = load_database(database, Path(database).stem)
        frequency = load(response, expected=plan.response_id)
        lines = irregular.statistics(compared, runs, seas, frequency)
        model = load(radiation, expected=Path(radiation).stem)
        checks += ledger.linear_ledger(compared, ds, model, frequency, rows, runs)
        checks += ledger.witness_checks(compared, ds, load(witness, expected=Path(witness).stem) if witness else None)
        checks += irregular.statistical_checks(compared, lines)
        tuned = equal_tuning(compared, study_ladder(compared, database))
        checks += fair_damping_checks(tuned)
    else:
        checks += ledger.assumed_pressure_checks(compared, rows)
    checks = ledger.worst_first(checks)
    write_text(out, comparison.as_csv(rows))
    write_text(statistics, irregular.as_csv(lines))
    write_text(validity, ledger.ledger_json(compared.study, checks))
    write_text(study, canonical(compared) + "\n")
    data = {
        "comparison": rows,
        "statistics": [line._asdict() for line in lines],
        "equal_tuning": [line._asdict() for line in tuned],
        "checks": [asdict(check) for check in checks],
    }
    write_text(tables, json.dumps(data, indent=1, allow_nan=False) + "\n")
    record(manifest, plan.study_id, [out, statistics, validity, study, tables])
