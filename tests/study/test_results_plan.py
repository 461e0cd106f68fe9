"""File names, content ids and memory of the results of a study."""

import math
import re

import pytest
from conftest import SEED, varied

from vsb.study.plan import StudyPlan
from vsb.study.study import content_id, load, result_id


@pytest.mark.parametrize("solver", ["spectral", "panels"])
def test_every_file_has_the_id_of_what_it_is_made_from(solver):
    """Shared files carry it in their name or folder; tables, figures and report have the study's."""
    plan = StudyPlan(varied(load(SEED), hydro={"solver": solver}), root="r")
    stages = dict.fromkeys(plan.response_files.values(), plan.response_id) | plan.shape_ids
    stages |= {f"{plan.folder}/ladder.{kind}": plan.ladder_id for kind in ("csv", "json")}
    runs = {
        plan.trajectory_path(design, wave.label): plan.trajectory_id(design, wave)
        for design in plan.study.designs
        for wave in plan.study.waves
    }
    assert len({plan.response_id, plan.ladder_id, plan.study_id, *runs.values()}) == 3 + len(runs)
    for path, identity in plan.ids.items():
        if path in stages or path in runs:
            assert identity == (stages | runs)[path]
        elif plan.is_shared(path):
            *_, folder, file = path.split("/")
            assert re.fullmatch("[0-9a-f]{16}", identity)
            assert file.startswith(f"{identity}.") or folder == identity
        else:
            assert identity == plan.study_id
    assert plan.ids[plan.database_path] == content_id(plan.database)
    assert {path for path in plan.ids if "/mesh/" in path}


@pytest.mark.parametrize("pressed", [False, True])
def test_study_id_covers_all_results(seed, pressed):
    hydro = {"model": "assumed_pressure", "pressure": 100.0} if pressed else {}
    regular = {"kind": "regular", "amplitude": 0.1, "period": 3.0}
    sea = {"kind": "jonswap", "hs": 0.5, "tp": 4.0, "realisations": 2}
    waves = [regular, {**regular, "period": 4.0}, *([] if pressed else [sea])]
    study = varied(seed, waves=waves, hydro=hydro, designs={"B": {}, "A": {"clamp": 0}})
    plan = StudyPlan(study)
    database, radiation = content_id(plan.database), content_id(plan.radiation)
    solved = () if pressed else (database, radiation)
    runs = [result_id(plan.simulation(name, wave), *solved) for wave in study.waves for name in ("A", "B")]
    answers = () if pressed else (result_id(plan.response, database), result_id(plan.ladder, database))
    witness = () if pressed else (content_id(plan.witness),)
    own = result_id(plan.comparison, content_id(plan.modes), *solved, *witness, *answers, *runs)
    assert plan.study_id == own
    assert plan.ids[f"{plan.folder}/report.html"] == own
    assert plan.ids[f"{plan.folder}/modes.nc"] == content_id(plan.modes)
    assert {plan.ids[path] for path in plan.display_paths} == {content_id(plan.display)}


def test_memory_of_runs_and_reports(seed):
    """Three records per run, one per design in the report, 0.6 kB per component of a spectrum."""
    waves = [
        {"kind": "regular", "amplitude": 0.1, "period": 5.0},
        {"kind": "regular", "amplitude": 0.1, "period": 2.5},
        {"kind": "jonswap", "hs": 0.5, "tp": 6.0},
        {"kind": "still"},
    ]
    run = {"duration": 2e4, "window": (0.0, 2e4)}
    study = varied(seed, waves=waves, simulation=run, hydro={"omega_max": 7.0}, designs={"A": {}, "B": {"clamp": 0}})
    plan = StudyPlan(study)
    records = [plan.record_megabytes(wave) for wave in study.waves]
    assert len(set(records)) > 2
    beyond = [plan.simulation_megabytes(wave) - 3 * record for wave, record in zip(study.waves, records, strict=True)]
    assert beyond == [800, 800, 800 + math.ceil(6e-4 * 7.0 * 2e4), 800]
    assert plan.study_megabytes == 800 + math.ceil(1.2 * 2 * max(records))
