"""The motion a study's page draws is that of its runs."""

import base64
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied

from vsb.report.living import packed
from vsb.stages.inputs import Inputs
from vsb.stages.moving import SEAS, moving_study
from vsb.tools.files import load


@pytest.fixture
def moved(small):
    paths = {**small.hydro_files, **small.response_files}
    return moving_study(Inputs(small.study, f"{small.folder}/trajectories", paths), load(f"{small.folder}/modes.nc"))


def test_every_design_moves_in_the_seas_that_are_drawn(small, moved):
    study = small.study
    assert [design["name"] for design in moved["designs"]] == list(study.designs)
    assert [sea["words"] for sea in moved["seas"]] == [wave.description for wave in study.drawn_waves][:SEAS]
    for design, frames in zip(study.designs, moved["seas"][0]["designs"], strict=True):
        run = load(small.trajectory_path(design, study.drawn_waves[0].label))
        assert frames["modes"] == (run.sizes["dof"] - 1 if study.designs[design].flexible else 0)
        sea = moved["seas"][0]
        time = sea["start"] + sea["step"] * np.arange(sea["frames"])
        assert frames["heave"] == packed(np.interp(time, run.time.values, run.position.values[:, 0]))


def test_the_shell_is_magnified_by_a_round_factor_that_shows_it(small, moved):
    largest = max(
        float(abs(load(small.trajectory_path(d, w.label)).position[:, 1:].sel(time=slice(*small.study.simulation.window))).max())
        for d, one in small.study.designs.items() if one.flexible for w in small.study.drawn_waves
    )  # fmt: skip
    assert 0.05 < moved["factor"] * largest / small.study.device.radius <= 0.2
    assert f"{moved['factor']:g}"[0] in "125"


def test_still_water_moves_where_there_are_no_waves(small):
    still = varied(small.study, waves=[{"kind": "still"}])

    first = small.study.waves[0].label
    runs = {(design, "still"): load(small.trajectory_path(design, first)) for design in still.designs}
    (sea,) = moving_study(SimpleNamespace(study=still, runs=runs), load(f"{small.folder}/modes.nc"))["seas"]
    assert not np.frombuffer(base64.b64decode(sea["surface"]), dtype="<f4").any()
