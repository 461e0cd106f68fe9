"""Rule compare: comparison table, statistics, validity ledger."""

from pathlib import Path

from vsb.hydro.database import load_database
from vsb.results import comparison, ledger
from vsb.results import statistics as irregular
from vsb.stages.trajectories import stored_runs
from vsb.study.specs import CompareSpec
from vsb.study.study import canonical
from vsb.tools.files import load, write_text
from vsb.waves.seas import NO_WAVES, sea


def run(
    spec: CompareSpec,
    trajectories: str,
    out: str,
    statistics: str,
    validity: str,
    study: str,
    database: str = "",
    radiation: str = "",
    response: str = "",
    witness: str = "",
) -> None:
    """Write the comparison table, statistics of irregular seas, the validity ledger and the study in canonical form."""
    compared = spec.study
    runs = stored_runs(compared, trajectories)
    bem = compared.needs_bem
    seas = {
        wave.label: sea(wave, compared.hydro.omega_max, compared.simulation.duration) if bem else NO_WAVES
        for wave in compared.waves
    }
    rows = comparison.comparison(compared, runs, seas)
    checks, lines = [*ledger.run_ledger(compared, runs), *ledger.transient_checks(runs, rows)], []
    if bem:
        ds = load_database(database, Path(database).stem)
        frequency = load(response)
        lines = irregular.statistics(compared, runs, seas, frequency)
        checks += ledger.linear_ledger(compared, ds, load(radiation), frequency, rows, runs)
        checks += ledger.witness_checks(compared, ds, load(witness) if witness else None)
        checks += irregular.statistical_checks(compared, lines)
    else:
        checks += ledger.assumed_pressure_checks(compared, rows)
    checks = ledger.worst_first(checks)
    write_text(out, comparison.as_csv(rows))
    write_text(statistics, irregular.as_csv(lines))
    write_text(validity, ledger.ledger_json(compared.study, checks))
    write_text(study, canonical(compared) + "\n")
