"""Stage simulate: stored runs, what the shell encloses, steady power of every kind of take-off."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import SMALL_PLAN, run_at, varied

from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.switching import periodic_power
from vsb.engine.motion.forces import Damper, Excitation, Spring
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.shell.deformed import enclosed
from vsb.models import build
from vsb.models.build import LatchingTime, linear_design
from vsb.pipeline.graph import StudyPlan
from vsb.stages import simulate
from vsb.tools.files import load

(WAVE,) = SMALL_PLAN.study.waves


def stored(plan, design):
    return load(plan.simulation(design, WAVE).out, expected=plan.simulation(design, WAVE).id)


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_stored_motion_is_that_of_the_scene(small, design):
    run = stored(small, design)
    one = small.simulation(design, WAVE).spec["run"]
    scene = linear_design(one, small.hydro_files).scene
    start = scene.start(one.study.simulation.initial_position, one.study.simulation.initial_velocity)
    exact = propagate(System.of(scene), run.time.values, start).position @ scene.motions.T
    np.testing.assert_allclose(run.position.values, exact[:, : run.sizes["dof"]], atol=1e-10)
    assert run.attrs["status"] == "completed"
    assert run.attrs["instants"] == run.sizes["time"]
    assert run.attrs["energy_residual"] < 1e-9
    assert run.attrs["steady_power"] > 0


def test_run_in_legs_equals_run_in_one_piece(small, tmp_path, monkeypatch):
    """Every instant once, also where one leg ends and the next begins."""
    whole, short = stored(small, "VSWEC"), partial(simulate.legs, longest=100)
    monkeypatch.setattr(simulate, "legs", short)
    run_at(small.simulation("VSWEC", WAVE), out=str(tmp_path / "run.nc"), **small.hydro_files)
    run = load(tmp_path / "run.nc", expected=small.simulation("VSWEC", WAVE).id)
    np.testing.assert_allclose(run.time.values, whole.time.values, atol=1e-12)
    for name in whole.data_vars:
        size = max(float(abs(whole[name]).max()), 1e-12)
        np.testing.assert_allclose(run[name].values, whole[name].values, atol=1e-8 * size, err_msg=name)
    assert run.attrs["instants"] == whole.attrs["instants"]
    assert run.attrs["steady_power"] == whole.attrs["steady_power"]


def test_volume_and_area_are_those_of_the_moving_shell(small):
    rigid, shell = (stored(small, design) for design in ("FSB", "VSWEC"))
    radius = small.study.device.radius
    assert rigid.volume.values == pytest.approx(4 / 3 * np.pi * radius**3, rel=1e-9)
    assert rigid.area.values == pytest.approx(4 * np.pi * radius**2, rel=1e-9)
    one = small.simulation("VSWEC", WAVE).spec["run"]
    shape = linear_design(one, small.hydro_files).shape
    volume, area = enclosed(shape.basis, shell.position.values)
    np.testing.assert_allclose(shell.volume.values, volume)
    np.testing.assert_allclose(shell.area.values, area)
    assert np.ptp(shell.volume.values) > 0


def test_clamped_shell_in_still_water_has_no_steady_power_and_no_drift(small, tmp_path):
    plan = StudyPlan(varied(small.study, designs={"C": {"clamp": 0}}, waves=[{"kind": "still"}]))
    (wave,) = plan.study.waves
    run_at(plan.simulation("C", wave), out=str(tmp_path / "run.nc"), **small.hydro_files)
    run = load(tmp_path / "run.nc", expected=plan.simulation("C", wave).id)
    assert "steady_power" not in run.attrs
    assert run.attrs["constraint_drift"] < 1e-12


LAWS = {"saturated": "steady_decay", "coulomb": "steady_difference", "latching": "steady_difference"}
"""By harmonic balance, or by following the motion until it repeats."""


@pytest.mark.parametrize("law", LAWS)
def test_steady_power_of_switching_laws(small, tmp_path, monkeypatch, law):
    """Equal to the mean over the end of a long run, and to that of the motion followed until it repeats."""
    monkeypatch.setattr(build, "linear_latching_time", lambda *_: LatchingTime(0.9, 0.0, 0.0))
    pto = {"damping": 8000.0, "law": law, "force_limit": 2e3}
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 5.0}]
    simulation = {"duration": 100.0, "window": [75.0, 100.0], "initial_velocity": 0.0}
    plan = StudyPlan(varied(small.study, pto=pto, waves=waves, simulation=simulation))
    (wave,) = plan.study.waves
    run_at(plan.simulation("FSB", wave), out=str(tmp_path / "run.nc"), **small.hydro_files)
    run = load(tmp_path / "run.nc", expected=plan.simulation("FSB", wave).id)
    assert LAWS[law] in run.attrs
    window = run.energy.sel(term="pto").interp(time=[75.0, 100.0]).values
    assert run.attrs["steady_power"] == pytest.approx(np.diff(window)[0] / 25.0, rel=5e-3)
    scene = linear_design(plan.simulation("FSB", wave).spec["run"], small.hydro_files).system
    assert run.attrs["steady_power"] == pytest.approx(periodic_power(scene, 1e-6)[0], rel=1e-4)


def drifting(omega=(2.0, 3.5)):
    """Two masses in waves, the first unrestrained, with a take-off and another damper on both."""
    pto, other = np.array([[3.0, 1.0], [1.0, 2.0]]), np.diag([0.2, 5.0])
    waves = np.array([[30.0 + 5j, -2.0], [4.0, 8j]])[: len(omega)]
    forces = {
        "hydrostatic": Spring(np.diag([0.0, 50.0])), "structural_damping": Damper(other), "pto": Damper(pto),
        "excitation": Excitation(np.array(omega), waves),
    }  # fmt: skip
    return System.of(Scene(("Surge", "Heave"), np.diag([2.0, 1.0]), forces, np.eye(2))), pto, other, waves


@pytest.mark.parametrize("omega", [(2.0,), (2.0, 3.5)])
def test_steady_power_of_an_unrestrained_system(omega):
    """Half v*.C v of the damper of the take-off alone, summed over the waves; the drift never decays."""
    system, pto, other, waves = drifting(omega)
    power = 0.0
    for w, push in zip(omega, waves, strict=True):
        v = np.linalg.solve(-1j * w * np.diag([2.0, 1.0]) + pto + other + 1j / w * np.diag([0.0, 50.0]), push)
        power += 0.5 * (v.conj() @ pto @ v).real
    assert simulate._steady(system) == {"steady_power": pytest.approx(power, rel=1e-9), "steady_decay": 1.0}


def test_stroke_is_the_port_combination_of_the_motions():
    """Whatever the order of the degrees of freedom in the record."""
    labels = ["Surge", "Heave", "Pitch"]
    made = SimpleNamespace(scene=SimpleNamespace(labels=labels), port=np.array([4.0, 2.0, -0.5]))
    values = np.arange(4.0).reshape(2, 2)
    run = xr.Dataset({"position": (("time", "dof"), values), "velocity": (("time", "dof"), values**2)})
    run = run.assign_coords(dof=["Pitch", "Heave"])
    found = simulate.with_stroke(run, made)
    np.testing.assert_allclose(found.stroke.values, values @ [-0.5, 2.0])
    np.testing.assert_allclose(found.stroke_rate.values, values**2 @ [-0.5, 2.0])
