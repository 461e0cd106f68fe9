"""What plans of buoys and bodies share: file names, options, memory."""

import re

import pytest
from conftest import SEED, varied

from vsb.study.plan import StudyPlan
from vsb.study.results_plan import figure_paths, options, quoted, trajectory_name
from vsb.study.study import content_id, load


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
