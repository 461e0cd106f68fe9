"""Rule compare: comparison table, statistics, validity ledger."""

from pathlib import Path
from typing import Any

from vsb.hydro import database
from vsb.results import comparison as compare
from vsb.results import ledger
from vsb.results import statistics as seastatistics
from vsb.stages.stage import stored_runs
from vsb.study.study import canonical, parse
from vsb.tools.files import load, write_text
from vsb.waves.seas import NO_WAVES, sea

Spec = dict[str, Any]


def compare_designs(spec: Spec, paths: dict[str, Any]) -> None:
    """Write the comparison table, statistics of irregular seas, the validity ledger and the study in canonical form."""
    study = parse(spec["study"], source="spec")
    runs = stored_runs(study, paths["trajectories"])
    bem = study.needs_bem
    seas = {
        wave.label: sea(wave, study.hydro.omega_max, study.simulation.duration) if bem else NO_WAVES
        for wave in study.waves
    }
    rows = compare.comparison(study, runs, seas)
    checks, lines = [*ledger.run_ledger(study, runs), *ledger.transient_checks(runs, rows)], []
    if bem:
        ds = database.load_database(paths["database"], Path(paths["database"]).stem)
        frequency = load(paths["response"])
        lines = seastatistics.statistics(study, runs, seas, frequency)
        checks += ledger.linear_ledger(study, ds, load(paths["radiation"]), frequency, rows, runs)
        checks += seastatistics.statistical_checks(study, lines)
    else:
        checks += ledger.assumed_pressure_checks(study, rows)
    checks = ledger.worst_first(checks)
    write_text(paths["out"], compare.as_csv(rows))
    write_text(paths["statistics"], seastatistics.as_csv(lines))
    write_text(paths["validity"], ledger.ledger_json(study.study, checks))
    write_text(paths["study"], canonical(study) + "\n")
