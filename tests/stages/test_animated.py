"""The animation of a page shows the motion of the runs."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied

from vsb.report.animation import PER_PERIOD, PERIODS
from vsb.report.interactive import packed
from vsb.stages.report import MOVING_SEAS, animated_study
from vsb.stages.stored import Inputs
from vsb.tools.files import load


@pytest.fixture
def moved(small):
    paths = {**small.hydro_files, **small.response_files}
    inputs = Inputs(small.study, f"{small.folder}/trajectories", paths)
    return animated_study(inputs, load(f"{small.folder}/modes.nc"), words(small.study))


def words(study):
    """Every sea in words."""
    return {wave.label: wave.description for wave in study.waves}


def test_animation_shows_the_motion_of_the_runs(small, moved):
    study = small.study
    assert [design["name"] for design in moved["designs"]] == list(study.designs)
    assert [sea["words"] for sea in moved["seas"]] == [wave.description for wave in study.drawn_waves][:MOVING_SEAS]
    (start, end), period = study.simulation.window, study.drawn_waves[0].period
    shown, sea = min(end - start, PERIODS * period), moved["seas"][0]
    assert (sea["start"], sea["step"] * (sea["frames"] - 1)) == pytest.approx((end - shown, shown))
    assert sea["frames"] == int(PER_PERIOD * shown / period) + 2
    for design, frames in zip(study.designs, moved["seas"][0]["designs"], strict=True):
        run = load(small.trajectory_path(design, study.drawn_waves[0].label))
        assert frames["modes"] == (run.sizes["dof"] - 1 if study.designs[design].flexible else 0)
        sea = moved["seas"][0]
        time = sea["start"] + sea["step"] * np.arange(sea["frames"])
        assert frames["heave"] == packed(np.interp(time, run.time.values, run.position.values[:, 0]))


def test_magnification_is_that_of_the_largest_motion_in_the_window(small):
    """A sea with ten times the motion is magnified ten times less; motion before the window does not count."""
    study = varied(
        small.study, waves=[{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.5, 3.0)]
    )
    first, modes = small.study.waves[0].label, load(f"{small.folder}/modes.nc")
    loaded = {design: load(small.trajectory_path(design, first)) for design in study.designs}
    start = study.simulation.window[0]

    def factor(*sizes, before=1):
        runs = {
            (design, wave.label): run.assign(position=run.position * size * (1 + (before - 1) * (run.time < start)))
            for wave, size in zip(study.waves, sizes, strict=True)
            for design, run in loaded.items()
        }
        stored = SimpleNamespace(study=study, runs=runs, database=load(small.database_path))
        return animated_study(stored, modes, words(study))["factor"]

    alike = factor(1.0, 1.0)
    assert factor(1.0, 10.0) == pytest.approx(alike / 10)
    assert factor(1.0, 1.0, before=100) == alike
