"""Plan of a study: ids, figures, frequencies of the response, memory."""

from typing import get_args

import pytest
import yaml
from conftest import SEED, varied

from vsb.study import study as config
from vsb.study.plan import StudyPlan, figure_names
from vsb.study.sections import Basis
from vsb.study.study import content_id


@pytest.fixture(scope="module")
def seed(seed):
    """The seed study by panels, whose plan has meshes and blocks."""
    return varied(seed, hydro={"solver": "panels"})


def block_ids(study):
    return {content_id(block) for block in StudyPlan(study).sweep_blocks + StudyPlan(study).tabulated_blocks}


def database_id(study):
    return content_id(StudyPlan(study).database)


def test_labels_are_those_of_the_basis(seed):
    from vsb.scenes.rest import study_basis

    for basis in get_args(Basis):
        study = varied(seed, modes={"basis": basis, "degree": 4})
        assert study_basis(study).labels[1:] == StudyPlan(study).mode_labels


def test_figures_follow_from_the_study(seed):
    waves = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 3.0}]
    study = varied(seed, waves=waves)
    assert len(figure_names(study)) == 6 + 2 * 8
    assert len(figure_names(varied(study, designs={"FSB": {"flexible": False}}))) == 6 + 2 * 5
    assumed = varied(study, hydro={"model": "assumed_pressure", "pressure": 100.0})
    assert len(figure_names(assumed)) == 1 + 2 * 8
    assert not {"absorbed_power", "radiation_kernel"} & set(figure_names(assumed))
    sea = {"kind": "pierson_moskowitz", "hs": 0.5, "tp": 4.0}
    assert "spectra" in figure_names(varied(seed, waves=[*waves, sea]))
    assert "spectra" not in figure_names(study)


def test_assumed_pressure_needs_no_bem(seed):
    plan = StudyPlan(varied(seed, hydro={"model": "assumed_pressure", "pressure": 100.0}))
    assert plan.bem_blocks == plan.hydro_files == plan.response_files == {}
    assert not [path for path in plan.products if "/hydro/db" in path or "response" in path]
    assert plan.simulation("FSB", plan.study.waves[0]).hydro.pressure == 100.0


def rewritten(text):
    """The seed with comments gone, keys in reverse order and numbers spelled otherwise."""
    raw = yaml.safe_load(text)
    reversed_keys = {key: dict(reversed(v.items())) if key == "device" else v for key, v in reversed(raw.items())}
    return yaml.safe_dump(reversed_keys, sort_keys=False).replace("10000000.0", "1e7").replace("17170.0", "17170")


@pytest.mark.parametrize("rewrite", [rewritten, lambda text: f"# remark\n{text}# end\n"], ids=["respelled", "comments"])
def test_ids_do_not_depend_on_spelling(tmp_path, rewrite):
    file = tmp_path / "other.yaml"
    file.write_text(rewrite(SEED.read_text()))
    assert file.read_text() != SEED.read_text()
    ours, theirs = StudyPlan(config.load(SEED)), StudyPlan(config.load(file))
    for spec in ("database", "radiation", "display", "modes", "response", "comparison"):
        assert content_id(getattr(theirs, spec)) == content_id(getattr(ours, spec))
    assert block_ids(theirs.study) == block_ids(ours.study)


def test_paths_lie_under_the_root_and_name_their_ids(seed):
    plan = StudyPlan(seed, root="elsewhere")
    block = plan.sweep_blocks[0]
    assert plan.database_path == f"elsewhere/hydro/db/{database_id(seed)}.nc"
    assert plan.block_path(block) == f"elsewhere/hydro/blocks/{content_id(block)}.nc"
    assert plan.mesh_path(block.mesh) == f"elsewhere/hydro/mesh/{content_id(block.mesh)}/mean.nc"
    assert plan.trajectory_path("FSB", "still") == "elsewhere/seed/trajectories/FSB-still.nc"
    assert len(set(plan.display_paths)) == 1 + 2 * 7


def test_memory_bounds_what_was_measured(seed):
    """Measured with the seed's free shell: 0.3 GB for 60 s, 0.6 GB for 16 000 s, 1.7 GB for 100 000 s."""
    asked = {}
    for duration in (60.0, 16e3, 1e5):
        plan = StudyPlan(varied(seed, simulation={"duration": duration, "window": (0.0, duration)}))
        asked[duration] = plan.simulation_megabytes(plan.study.waves[0])
    assert 600 < asked[60.0] < 1000
    assert 700 < asked[16e3] < 1400
    assert 1700 < asked[1e5] < 2 * 1700
    irregular = varied(seed, waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}], simulation={"duration": 1e5})
    assert 2900 < StudyPlan(irregular).simulation_megabytes(irregular.waves[0]) < 2 * 2900
