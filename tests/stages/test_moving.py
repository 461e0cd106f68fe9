"""The motion a study's page draws is that of its runs."""

import base64
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.report.animation import PER_PERIOD, PERIODS, SEEN, in_motion
from vsb.report.living import packed
from vsb.stages import moving as module
from vsb.stages.inputs import Inputs
from vsb.stages.moving import SEAS, moving_study
from vsb.study.study import RegularWave, StillWater
from vsb.tools.files import load
from vsb.waves.seas import NO_WAVES


@pytest.fixture
def moved(small):
    paths = {**small.hydro_files, **small.response_files}
    inputs = Inputs(small.study, f"{small.folder}/trajectories", paths)
    return moving_study(inputs, load(f"{small.folder}/modes.nc"), words(small.study))


def words(study):
    """Every sea in words."""
    return {wave.label: wave.description for wave in study.waves}


def test_every_design_moves_in_the_seas_that_are_drawn(small, moved):
    study = small.study
    assert [design["name"] for design in moved["designs"]] == list(study.designs)
    assert [sea["words"] for sea in moved["seas"]] == [wave.description for wave in study.drawn_waves][:SEAS]
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


def test_the_shell_is_magnified_by_a_round_factor_that_shows_it(small, moved):
    largest = max(
        float(abs(load(small.trajectory_path(d, w.label)).position[:, 1:].sel(time=slice(*small.study.simulation.window))).max())
        for d, one in small.study.designs.items() if one.flexible for w in small.study.drawn_waves
    )  # fmt: skip
    assert 0.05 < moved["factor"] * largest / small.study.device.radius <= 0.2
    assert f"{moved['factor']:g}"[0] in "125"


@pytest.mark.parametrize(
    "changes",
    [{"waves": [{"kind": "still"}]}, {"hydro": {"model": "assumed_pressure", "pressure": 1800.0}}],
    ids=["still water", "assumed pressure"],
)
def test_without_waves_buoys_move_and_nothing_is_said_of_where_waves_come_from(small, changes):
    calm = varied(small.study, **changes)
    first = small.study.waves[0].label
    runs = {
        (design, wave.label): load(small.trajectory_path(design, first))
        for design in calm.designs
        for wave in calm.waves
    }
    inputs = SimpleNamespace(study=calm, runs=runs)
    moved = moving_study(inputs, load(f"{small.folder}/modes.nc"), words(calm))
    assert [sea["words"] for sea in moved["seas"]] == list(words(calm).values())
    assert not any(np.frombuffer(base64.b64decode(sea["surface"]), dtype="<f4").any() for sea in moved["seas"])
    assert in_motion(moved)["waves"] == "Dotted: undeformed."


@pytest.mark.parametrize("large", [0, 1])
def test_the_factor_is_of_the_largest_shell_of_all_seas_in_the_window_alone(small, large):
    """In either sea ten times as large, and so ten times less magnified; what was before the window does not count."""
    study = varied(
        small.study, waves=[{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.5, 3.0)]
    )
    first, modes = small.study.waves[0].label, load(f"{small.folder}/modes.nc")
    loaded = {design: load(small.trajectory_path(design, first)) for design in study.designs}
    start = study.simulation.window[0]

    def factor(*sizes):
        runs = {
            (design, wave.label): run.assign(position=run.position * size * (1 + 99 * (run.time < start)))
            for wave, size in zip(study.waves, sizes, strict=True)
            for design, run in loaded.items()
        }
        return moving_study(SimpleNamespace(study=study, runs=runs), modes, words(study))["factor"]

    alike = factor(1.0, 1.0)
    assert factor(*(10.0 if i == large else 1.0 for i in range(2))) == pytest.approx(alike / 10)
    assert (
        alike
        == moving_study(
            SimpleNamespace(study=study, runs={(d, w.label): run for w in study.waves for d, run in loaded.items()}),
            modes,
            words(study),
        )["factor"]
    )


@pytest.mark.parametrize("dry", [False, True])
def test_each_sea_is_drawn_in_its_own_waves_going_its_own_way(seed, monkeypatch, dry):
    """The first few of those with waves, in the order of the study; of an assumed pressure no water moves."""
    waves = [RegularWave(kind="regular", amplitude=0.1, period=2.0 + i) for i in range(SEAS + 1)]
    waves = [wave.model_copy(update={"direction": 10.0 * i}) for i, wave in enumerate(waves)]
    still = StillWater(kind="still")
    hydro = {"model": "assumed_pressure", "pressure": 1800.0} if dry else {}
    study = varied(seed, designs={"A": {"flexible": False}, "B": {}}, hydro=hydro)
    study = study.model_copy(update={"waves": (waves[0], still, *waves[1:])})
    runs = {
        (design, wave.label): SimpleNamespace(
            position=xr.DataArray(
                [[float(i)]], {"time": [study.simulation.window[1]], "dof": [design]}, ("time", "dof")
            )
        )
        for design in "AB"
        for i, wave in enumerate(study.waves)
    }
    monkeypatch.setattr(module, "frames_data", lambda *given: given)
    monkeypatch.setattr(module, "largest_shell", lambda *_: 0.1)
    monkeypatch.setattr(module, "shapes_data", lambda modes: "shapes")
    monkeypatch.setattr(module, "sea", lambda *given: given)
    words = {wave.label: f"number {i}" for i, wave in enumerate(study.waves)}
    found = moving_study(SimpleNamespace(study=study, runs=runs), xr.Dataset(coords={"mode": ["M"]}), words)
    assert (found["width"], found["shapes"], len(found["seas"])) == (SEEN * study.device.radius, "shapes", SEAS)
    duration = study.simulation.duration
    for wave, (told, moved, water_waves, window, period, width, water, shell, towards) in zip(
        waves, found["seas"], strict=False
    ):
        assert told == words[wave.label]
        assert {name: run is runs[name, wave.label].position for name, run in moved.items()} == {"A": True, "B": True}
        assert water_waves == (NO_WAVES if dry else (wave, study.hydro.omega_max, duration))
        assert (window, width, water, shell) == (study.simulation.window, found["width"], study.water, ["M"])
        assert (period, towards) == pytest.approx((wave.period, np.deg2rad(wave.direction)))
    calm = study.model_copy(update={"waves": (still,)})
    (one,) = moving_study(SimpleNamespace(study=calm, runs=runs), xr.Dataset(coords={"mode": ["M"]}), words)["seas"]
    assert (one[0], one[4]) == (words["still"], duration / PERIODS)


@pytest.mark.parametrize("design", ["A", "B"])
@pytest.mark.parametrize("place", range(SEAS))
def test_a_shell_is_largest_in_any_of_the_seas_drawn_of_any_design(seed, monkeypatch, design, place):
    """Not before the window, not in a sea that is not drawn, and not by its heave."""
    waves = tuple(RegularWave(kind="regular", amplitude=0.1, period=2.0 + i) for i in range(SEAS + 1))
    study = varied(seed, designs={"A": {}, "B": {}}).model_copy(update={"waves": waves})
    start, end = study.simulation.window

    def run(name, i):
        moved = 0.3 if (name, i) == (design, place) else 0.9 if i == SEAS else 0.02
        position = [[0.7, 0.8], [0.6, -moved]]
        return SimpleNamespace(
            position=xr.DataArray(position, {"time": [start - 1.0, end], "dof": ["heave", "M"]}, ("time", "dof"))
        )

    monkeypatch.setattr(module, "frames_data", lambda *given: given)
    monkeypatch.setattr(module, "shapes_data", lambda modes: "shapes")
    monkeypatch.setattr(module, "sea", lambda *given: given)
    monkeypatch.setattr(module, "round_factor", lambda *given: given)
    runs = {(name, wave.label): run(name, i) for name in "AB" for i, wave in enumerate(waves)}
    modes, words = xr.Dataset(coords={"mode": ["M"]}), {wave.label: "" for wave in waves}
    found = moving_study(SimpleNamespace(study=study, runs=runs), modes, words)
    assert found["factor"] == (0.3, study.device.radius)
