"""The animation of a page shows the motion of the runs."""

import numpy as np
import pytest

from vsb.report.animation import PER_PERIOD, PERIODS
from vsb.report.interactive import packed
from vsb.stages.animated import ANIMATED_SEAS, animated_study
from vsb.stages.stored import Inputs
from vsb.tools.files import load


@pytest.fixture
def moved(small):
    paths = {**small.hydro_files, "response": small.response.out, "modes": f"{small.folder}/modes.nc"}
    inputs = Inputs(small.study, f"{small.folder}/trajectories", paths)
    return animated_study(inputs, words(small.study))


def words(study):
    """Every sea in words."""
    return {wave.label: wave.description for wave in study.waves}


def test_animation_shows_the_motion_of_the_runs(small, moved):
    study = small.study
    assert [design["name"] for design in moved["designs"]] == list(study.designs)
    assert [sea["words"] for sea in moved["seas"]] == [wave.description for wave in study.drawn_waves][:ANIMATED_SEAS]
    (start, end), period = study.simulation.window, study.drawn_waves[0].period
    shown, sea = min(end - start, PERIODS * period), moved["seas"][0]
    assert (sea["start"], sea["step"] * (sea["frames"] - 1)) == pytest.approx((end - shown, shown))
    assert sea["frames"] == int(PER_PERIOD * shown / period) + 2
    for design, frames in zip(study.designs, moved["seas"][0]["designs"], strict=True):
        run = load(small.simulation(design, study.drawn_waves[0]).out)
        assert frames["modes"] == (run.sizes["dof"] - 1 if study.designs[design].flexible else 0)
        sea = moved["seas"][0]
        time = sea["start"] + sea["step"] * np.arange(sea["frames"])
        assert frames["heave"] == packed(np.interp(time, run.time.values, run.position.values[:, 0]))
