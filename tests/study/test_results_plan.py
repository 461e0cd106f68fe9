"""What plans of buoys and bodies share: file names, options, memory."""

import math
import re

import pytest
from conftest import SEED, varied

from vsb.study.plan import StudyPlan
from vsb.study.results_plan import figure_paths, options, quoted, trajectory_name
from vsb.study.study import content_id, load, result_id


def test_names_of_files_and_options():
    assert trajectory_name("FSB", "still") == "FSB-still.nc"
    assert figure_paths("results/a", ["b"]) == [f"results/a/figures/b.{kind}" for kind in ("svg", "pdf", "csv")]
    assert options({"database": "a.nc", "out": "b"}) == "--database a.nc --out b"
    assert quoted({"mesh": "my mesh's.stl"}) == """--mesh 'my mesh'"'"'s.stl'"""


def test_answers_are_among_the_products_and_shared_files_are_in_hydro():
    plan = StudyPlan(load(SEED), root="r")
    assert set(plan.answers) < set(plan.products)
    assert plan.is_shared(plan.database_path)
    assert not plan.is_shared(plan.manifest)
    assert plan.manifest == "r/seed/manifest.json"


def test_results_of_designs_in_another_order_are_the_same_results(seed):
    """As canonical JSON has it: files that are there need not be made again."""
    plan, other = (StudyPlan(varied(seed, designs=dict(some))) for some in _orders(seed))
    assert list(plan.study.designs) != list(other.study.designs)
    assert other.study_id == plan.study_id
    assert other.ids == plan.ids


def _orders(study):
    """Its designs in their order and in the other one."""
    designs = [(name, design.model_dump()) for name, design in study.designs.items()]
    return designs, designs[::-1]


@pytest.mark.parametrize("solver", ["spectral", "panels"])
def test_every_file_has_the_id_of_what_it_is_made_from(solver):
    """A shared one is named by it, or lies in a folder that is; tables, figures and the report have the study's."""
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
def test_a_study_rests_on_all_it_is_made_of(seed, pressed):
    """Its own words, the shapes of its modes, coefficients, second solver, responses, and every run of every sea."""
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


def test_every_run_of_every_sea_is_an_answer(seed):
    regular = {"kind": "regular", "amplitude": 0.1, "period": 3.0}
    sea = {"kind": "jonswap", "hs": 0.5, "tp": 4.0, "realisations": 2}
    plan = StudyPlan(varied(seed, waves=[regular, sea], designs={"B": {}, "A": {"clamp": 0}}), root="r")
    runs = {path for path in plan.answers if "/trajectories/" in path}
    seas = ("regular_A0.1_T3", "jonswap_Hs0.5_Tp4_g3.3_s1", "jonswap_Hs0.5_Tp4_g3.3_s2")
    assert runs == {f"r/seed/trajectories/{design}-{sea}.nc" for design in "AB" for sea in seas}


def test_a_record_is_nine_numbers_of_every_coordinate_and_ten_others(seed):
    """Two hundred instants a period, of eight bytes each; thinned where they are too many."""
    regular = {"kind": "regular", "amplitude": 0.1, "period": 2.0}
    for designs, coordinates in (({"A": {"flexible": False}}, 1), ({"A": {}}, 8)):
        for duration, kept in ((1e3, 1e5), (1e4, 1.25e5), (1e5, 1e6)):
            run = {"duration": duration, "window": (0.0, duration)}
            study = varied(seed, waves=[regular], simulation=run, designs=designs, modes={"degree": 6})
            plan = StudyPlan(study)
            assert plan.coordinates == coordinates
            assert plan.record_megabytes(study.waves[0]) == pytest.approx(
                8e-6 * (9 * coordinates + 10) * kept, abs=1.01
            )


def test_what_studies_share_lies_in_hydro_alone_and_has_the_id_of_its_name_or_of_its_folder(seed):
    """A study may be called nearly so; names that only begin with a digit of an id, or are longer, are none."""
    plan = StudyPlan(varied(seed).model_copy(update={"study": "hydrofoil"}), root="r")
    assert not plan.is_shared(plan.manifest)
    assert not any(map(plan.is_shared, plan.answers[:6]))
    identity = 16 * "a"
    for name in ("mean.nc", "face.vtu", f"{17 * 'a'}.nc", f"{15 * 'a'}.nc"):
        assert plan._named_id(f"r/hydro/mesh/{identity}/{name}") == identity
    assert plan._named_id(f"r/hydro/db/{identity}.nc") == identity
    assert plan._named_id("r/hydrofoil/report.html") == plan.study_id
    assert re.fullmatch(r"r/hydro/green/capytaine-[0-9.a-z+]+", plan.green_folder)


def test_memory_is_of_all_of_a_run_however_short_its_window(seed):
    sea = {"kind": "jonswap", "hs": 0.5, "tp": 4.0}
    for wave in ({"kind": "regular", "amplitude": 0.1, "period": 2.5}, sea):
        told = set()
        for window in ((0.0, 2e4), (100.0, 200.0)):
            plan = StudyPlan(varied(seed, waves=[wave], simulation={"duration": 2e4, "window": window}))
            told.add((plan.simulation_megabytes(plan.study.waves[0]), plan.study_megabytes))
        assert len(told) == 1


def test_every_file_promised_and_every_file_solved_on_the_way_has_an_id(seed):
    plan = StudyPlan(varied(seed, hydro={"omega": [2.0, 11.0]}), root="r")
    assert list(plan.ids) == [*plan.products, *plan.solved_files]
    assert set(plan.solved_files) - set(plan.products)


def test_memory_is_of_the_longest_record_of_all_designs_and_of_the_components_of_a_spectrum_alone(seed):
    """A record thrice in a run, that of the longest sea once for each design in what draws them; 0.6 kB a component."""
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


@pytest.mark.parametrize("pressed", [False, True])
def test_a_study_answers_by_a_report_tables_and_what_is_solved_of_the_water(seed, pressed):
    hydro = {"model": "assumed_pressure", "pressure": 100.0} if pressed else {}
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 3.0}]
    plan = StudyPlan(varied(seed, hydro=hydro, waves=waves), root="r")
    tables = {"report.html", "comparison.csv", "statistics.csv", "validity.json", "study.json", "tables.json"}
    solved = set() if pressed else {"response.nc", "ladder.csv", "ladder.json"}
    beside = {f"r/seed/{name}" for name in tables | solved} | (
        set() if pressed else {plan.database_path, plan.radiation_path}
    )
    drawn = {f"r/seed/figures/{name}.{kind}" for name in plan.figures for kind in ("svg", "pdf", "csv")}
    runs = {plan.trajectory_path(design, plan.study.waves[0].label) for design in plan.study.designs}
    assert set(plan.answers) == beside | drawn | runs
    assert len(plan.answers) == len(set(plan.answers))
