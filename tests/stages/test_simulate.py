"""Rule simulate: a run in a file is that of its scene, with what a shell encloses."""

from functools import partial

import numpy as np
import pytest
from conftest import SMALL_PLAN, varied

from vsb.integrators.exact import propagate
from vsb.integrators.settled import settled_power
from vsb.motion.system import System
from vsb.scenes import build
from vsb.scenes.build import linear_design
from vsb.scenes.pause import BestPause
from vsb.shell.deformed import DeformedShell, enclosed
from vsb.stages import simulate
from vsb.study.plan import StudyPlan
from vsb.tools.files import load

(WAVE,) = SMALL_PLAN.study.waves


def stored(plan, design):
    return load(plan.trajectory_path(design, WAVE.label), expected=plan.trajectory_id(design, WAVE))


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_the_motion_is_that_of_the_scene_from_its_start(small, design):
    run = stored(small, design)
    one = small.simulation(design, WAVE)
    scene = linear_design(one, small.hydro_files).scene
    start = scene.start(one.simulation.initial_position, one.simulation.initial_velocity)
    exact = propagate(System.of(scene), run.time.values, start).position @ scene.motions.T
    np.testing.assert_allclose(run.position.values, exact[:, : run.sizes["dof"]], atol=1e-10)
    assert run.attrs["status"] == "completed"
    assert run.attrs["instants"] == run.sizes["time"]
    assert run.attrs["energy_residual"] < 1e-9
    assert run.attrs["steady_power"] > 0


def test_a_run_in_legs_is_recorded_as_the_run_in_one(small, tmp_path, monkeypatch):
    """Every instant once, where one leg ends and the next begins too; what runs say of themselves is of all legs."""
    whole, short = stored(small, "VSWEC"), partial(simulate.legs, longest=100)
    monkeypatch.setattr(simulate, "legs", short)
    simulate.run(small.simulation("VSWEC", WAVE), str(tmp_path / "run.nc"), **small.hydro_files)
    run = load(tmp_path / "run.nc", expected=small.trajectory_id("VSWEC", WAVE))
    np.testing.assert_allclose(run.time.values, whole.time.values, atol=1e-12)
    for name in whole.data_vars:
        size = max(float(abs(whole[name]).max()), 1e-12)
        np.testing.assert_allclose(run[name].values, whole[name].values, atol=1e-8 * size, err_msg=name)
    assert run.attrs["instants"] == whole.attrs["instants"]
    assert run.attrs["steady_power"] == whole.attrs["steady_power"]


def test_volume_and_area_are_those_the_moving_shell_encloses(small):
    rigid, shell = (stored(small, design) for design in ("FSB", "VSWEC"))
    radius = small.study.device.radius
    assert rigid.volume.values == pytest.approx(4 / 3 * np.pi * radius**3, rel=1e-9)
    assert rigid.area.values == pytest.approx(4 * np.pi * radius**2, rel=1e-9)
    one = small.simulation("VSWEC", WAVE)
    shape = linear_design(one, small.hydro_files).shape
    volume, area = enclosed(shape.basis, shell.position.values)
    np.testing.assert_allclose(shell.volume.values, volume)
    np.testing.assert_allclose(shell.area.values, area)
    assert np.ptp(shell.volume.values) > 0
    moved = DeformedShell(shape.basis, shape.centre_height, shell.position.values[-1])
    np.testing.assert_allclose(simulate.with_enclosed(shell, moved).volume.values, enclosed(
        shape.basis, moved.modal_amplitude + shell.position.values)[0])  # fmt: skip


def test_still_water_has_no_steady_power_and_clamps_hold(small, tmp_path):
    plan = StudyPlan(varied(small.study, designs={"C": {"clamp": 0}}, waves=[{"kind": "still"}]))
    (wave,) = plan.study.waves
    simulate.run(plan.simulation("C", wave), str(tmp_path / "run.nc"), **small.hydro_files)
    run = load(tmp_path / "run.nc", expected=plan.trajectory_id("C", wave))
    assert "steady_power" not in run.attrs
    assert run.attrs["constraint_drift"] < 1e-12


LAWS = {"saturated": "steady_decay", "coulomb": "steady_unsettled", "latching": "steady_unsettled"}
"""Law -> what a run records beside its steady power: of harmonic balance, or of a motion followed until it repeats."""


@pytest.mark.parametrize("law", LAWS)
def test_a_run_that_switches_knows_its_steady_power(small, tmp_path, monkeypatch, law):
    """As the window of a long run shows, and of a saturated damper as its settled motion does, a second method."""
    monkeypatch.setattr(build, "best_pause_in_sea", lambda *_: BestPause(0.9, 0.0, 0.0))
    pto = {"damping": 8000.0, "law": law, "force_limit": 2e3}
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 5.0}]
    simulation = {"duration": 100.0, "window": [75.0, 100.0], "initial_velocity": 0.0}
    plan = StudyPlan(varied(small.study, pto=pto, waves=waves, simulation=simulation))
    (wave,) = plan.study.waves
    simulate.run(plan.simulation("FSB", wave), str(tmp_path / "run.nc"), **small.hydro_files)
    run = load(tmp_path / "run.nc", expected=plan.trajectory_id("FSB", wave))
    assert LAWS[law] in run.attrs
    window = run.energy.sel(term="pto").interp(time=[75.0, 100.0]).values
    assert run.attrs["steady_power"] == pytest.approx(np.diff(window)[0] / 25.0, rel=5e-3)
    scene = linear_design(plan.simulation("FSB", wave), small.hydro_files).system
    assert run.attrs["steady_power"] == pytest.approx(settled_power(scene, 1e-6)[0], rel=1e-4)


def test_a_motion_that_never_repeats_has_no_steady_power(small, tmp_path, monkeypatch):
    monkeypatch.setattr(simulate, "settled_power", lambda *_: (1.0, 0.02))
    monkeypatch.setattr(build, "best_pause_in_sea", lambda *_: BestPause(0.9, 0.0, 0.0))
    plan = StudyPlan(varied(small.study, pto={"damping": 8000.0, "law": "latching"}))
    simulate.run(plan.simulation("FSB", WAVE), str(tmp_path / "run.nc"), **small.hydro_files)
    attrs = load(tmp_path / "run.nc", expected=plan.trajectory_id("FSB", WAVE)).attrs
    assert attrs["no_steady_state"] == "powers of periods from rest on differ by up to 2 %"
    assert "steady_power" not in attrs


@pytest.mark.parametrize(("apart", "known"), [(0.9e-3, "steady_power"), (1.1e-3, "no_steady_state")])
def test_a_motion_repeats_whose_late_powers_differ_by_a_thousandth(monkeypatch, apart, known):
    monkeypatch.setattr(simulate, "settled_power", lambda *_: (1.0, apart))
    assert known in simulate._settled(None)


def test_clamps_are_watched_over_ten_thousand_periods(small, monkeypatch):
    seen = []
    monkeypatch.setattr(
        simulate, "propagate", lambda system, time, start: seen.append(time) or propagate(system, time[:3], start)
    )
    one = small.simulation("VSWEC", WAVE)
    system = linear_design(one, small.hydro_files).system
    assert simulate._linear_drift(one, system, np.zeros((1, len(system.scene.labels)))) == 0.0
    (time,) = seen
    assert (time[0], time[-1]) == (0.0, pytest.approx(1e4 * WAVE.period))
    assert np.diff(time).max() < WAVE.period


@pytest.mark.parametrize(("later", "told"), [(7.0, 7.0), (0.0, None)])
def test_the_slip_told_of_clamps_is_the_largest_of_the_run_and_of_ten_thousand_periods(
    small, tmp_path, monkeypatch, later, told
):
    monkeypatch.setattr(simulate, "_linear_drift", lambda *_: later)
    plan = StudyPlan(varied(small.study, designs={"FSB": {"flexible": False}, "VSWEC0": {"clamp": 0}}))
    for design in plan.study.designs:
        simulate.run(plan.simulation(design, WAVE), str(tmp_path / f"{design}.nc"), **small.hydro_files)
    held = load(tmp_path / "VSWEC0.nc").attrs["constraint_drift"]
    assert held == told or (told is None and 0 < held < 1e-12)
    assert "constraint_drift" not in load(tmp_path / "FSB.nc").attrs
