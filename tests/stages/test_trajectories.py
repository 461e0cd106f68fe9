"""Runs of a study in a folder, of which one sea's are in memory at a time."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import DatabaseError
from vsb.stages.trajectories import StoredRuns
from vsb.study.plan import StudyPlan
from vsb.study.results_plan import trajectory_name
from vsb.tools.files import save

SEAS = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.0, 3.0, 4.0)]


@pytest.fixture
def stored(seed, tmp_path):
    """Two designs in three seas; the heave of each run is a number of its own."""
    study = varied(seed, designs={"FSB": {"flexible": False}, "VSWEC": {}}, waves=SEAS)
    plan, heave = StudyPlan(study), 0.0
    for wave in study.waves:
        for design in study.designs:
            run = xr.Dataset(
                {"position": (("time", "dof"), np.full((3, 1), heave))},
                coords={"time": [0.0, 1.0, 2.0], "dof": ["Heave"]},
                attrs={"design": design, "spec_id": plan.trajectory_id(design, wave)},
            )
            save(run, tmp_path / trajectory_name(design, wave.label))
            heave += 1.0
    return StoredRuns(study, str(tmp_path))


def test_all_runs_are_there_sea_by_sea(stored):
    labels = [wave.label for wave in stored.study.waves]
    assert list(stored) == [(design, label) for label in labels for design in ("FSB", "VSWEC")]
    assert len(stored) == 6
    assert [float(run.position[0, 0]) for run in stored.values()] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert [attrs["design"] for attrs in stored.attributes()] == 3 * ["FSB", "VSWEC"]


def test_runs_of_one_sea_are_kept_and_no_others(stored):
    first, second = (wave.label for wave in stored.study.waves[:2])
    kept = [stored[design, first] for design in ("FSB", "VSWEC")]
    assert [stored[design, first] is run for design, run in zip(("FSB", "VSWEC"), kept, strict=True)] == [True, True]
    assert stored["FSB", second] is not kept[0]
    assert stored["FSB", first] is not kept[0]
    assert stored["FSB", first].identical(kept[0])
    assert stored["VSWEC", first] is not kept[1]


def test_a_run_of_another_specification_is_refused(stored, tmp_path):
    other = StoredRuns(varied(stored.study, pto={"damping": 5000.0}), str(tmp_path))
    name = trajectory_name("VSWEC", stored.study.waves[0].label)
    with pytest.raises(DatabaseError, match=rf"{name}: holds '\w+', needs '\w+': stale or foreign"):
        other["VSWEC", stored.study.waves[0].label]
    with pytest.raises(DatabaseError, match=r"FSB-.*: stale or foreign"):
        other.attributes()


@pytest.mark.parametrize("place", range(6))
def test_every_run_is_the_one_of_its_own_design_and_sea(stored, tmp_path, place):
    """A file that is whole, under the name of another run."""
    names = [trajectory_name(*run) for run in stored]
    (tmp_path / names[place]).write_bytes((tmp_path / names[place - 1]).read_bytes())
    with pytest.raises(DatabaseError, match=rf"{names[place]}: holds '\w+', needs '\w+': stale or foreign"):
        stored.attributes()


def test_a_damaged_run_is_refused_also_where_its_attributes_alone_are_read(stored, tmp_path):
    path = tmp_path / trajectory_name("FSB", stored.study.waves[1].label)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(DatabaseError, match=r"its contents are not those it was written with"):
        stored.attributes()
    with pytest.raises(DatabaseError, match=r"its contents are not those it was written with"):
        list(stored.values())
