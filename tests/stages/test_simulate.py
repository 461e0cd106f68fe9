"""Rule simulate: a run in a file is that of its scene, with what a shell encloses."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import SMALL_PLAN, varied

from vsb.errors import ConvergenceError, StabilityError
from vsb.integrators.audit import Balance
from vsb.integrators.exact import propagate
from vsb.integrators.settled import settled_power
from vsb.integrators.trajectory import Leg
from vsb.motion.forces import Damper, Excitation, Spring
from vsb.motion.motion import Motion
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.scenes import build
from vsb.scenes.build import linear_design
from vsb.scenes.pause import SETTLED, BestPause
from vsb.shell.deformed import DeformedShell, enclosed
from vsb.stages import simulate
from vsb.study.body import BodyDesign
from vsb.study.body_specs import BodySimulateSpec
from vsb.study.plan import StudyPlan
from vsb.study.take_off import Pto
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


@pytest.mark.parametrize(("apart", "percent"), [(0.9e-3, None), (1e-3, None), (1.1e-3, "0.11"), (0.25, "25")])
def test_a_motion_repeats_whose_late_powers_differ_by_a_thousandth(monkeypatch, apart, percent):
    """Else by how much they differ is said in per cent."""
    asked = []
    monkeypatch.setattr(simulate, "settled_power", lambda *given: asked.append(given) or (7.0, apart))
    told = f"powers of periods from rest on differ by up to {percent} %"
    known = {"no_steady_state": told} if percent else {"steady_power": 7.0, "steady_unsettled": apart}
    assert simulate._settled("a law") == known
    assert asked == [("a law", SETTLED)]


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


# hand-made runs ------------------------------------------------------------------------------------------------------


def leg_of(count, seconds, steps, slip, **more):
    """A leg of a run of two motions, of which one slips by so much."""
    position = np.zeros((count, 2))
    position[count // 2, 1] = slip
    motion = Motion(np.arange(float(count)), position, position, position, np.zeros((count, 0)), seconds)
    return Leg(motion, {}, Balance({}, more.get("unbalanced", 0.0), 2.0), 1, 1, "Adams", steps)


@pytest.fixture
def told(monkeypatch):
    """Function legs, spec -> what a run of such legs is asked to save."""

    def by(parts, wave=WAVE, database="a.nc", pto=None, drift=0.0, holds=True, shape=None):
        scene = SimpleNamespace(labels=("Heave", "Membrane0"), motions=np.eye(2))
        system, saved, asked = SimpleNamespace(scene=scene), [], []
        rows, numbers = np.array([[0.0, 1.0]]) if holds else np.zeros((0, 2)), iter(range(10))

        def recorded(system, leg, waves, window):
            asked.append((waves, window))
            k = next(numbers)
            values = 10.0 * k + np.arange(4.0)
            ds = xr.Dataset({"position": (("time", "dof"), np.stack([values, -values], axis=1))})
            return ds.assign_coords(time=values, dof=["Heave", "Membrane0"])

        monkeypatch.setattr(simulate, "design_in_sea", lambda *_: (scene, shape, "sea", None, {"note": "so"}))
        monkeypatch.setattr(simulate.System, "of", lambda scene: system)
        monkeypatch.setattr(simulate, "legs", lambda *_: iter(parts))
        monkeypatch.setattr(simulate, "recorded", recorded)
        monkeypatch.setattr(simulate, "held_at_zero", lambda *_: rows)
        monkeypatch.setattr(simulate, "_steady", lambda system: {"steady_power": 7.0})
        monkeypatch.setattr(simulate, "_linear_drift", lambda *_: drift)
        monkeypatch.setattr(simulate, "stamp", lambda spec, *paths: {"spec_id": " ".join(paths)})
        monkeypatch.setattr(simulate, "save", lambda ds, out: saved.append((ds, out)))
        settings = SimpleNamespace(window=(4.0, 8.0))
        spec = SimpleNamespace(designs={"D": None}, waves=(wave,), simulation=settings, pto=Pto(**(pto or {})))
        simulate.run(spec, "out.nc", database, "r.nc")
        ((ds, out),) = saved
        assert out == "out.nc"
        return ds, asked

    return by


LEGS = [
    leg_of(51, 1.5, 30, 2e-7),
    leg_of(31, 0.25, 7, 5e-7, unbalanced=4e-9),
    leg_of(21, 0.5, 4, -3e-7, unbalanced=6e-9),
]


def test_what_a_run_of_several_legs_tells_is_of_all_of_them(told):
    """The instant at which one ends and the next begins is one; the audit is that of the last, which has all in it."""
    ds, asked = told(LEGS)
    assert ds.attrs == {
        "design": "D", "wave": WAVE.label, "energy_residual": 3e-9, "status": "completed", "method": "Adams, 41 steps",
        "instants": 101, "seconds": 2.25, "note": "so", "spec_id": "a.nc r.nc", "steady_power": 7.0,
        "constraint_drift": pytest.approx(5e-7),
    }  # fmt: skip
    assert ds.time.values.tolist() == [0.0, 1.0, 2.0, 3.0, 11.0, 12.0, 13.0, 21.0, 22.0, 23.0]
    assert asked == [("sea", (4.0, 8.0))] * 3


@pytest.mark.parametrize("order", [[0, 1, 2], [1, 0, 2], [2, 0, 1]])
@pytest.mark.parametrize("drift", [0.0, 9e-7])
def test_the_slip_of_a_run_is_the_largest_of_any_leg(told, order, drift):
    assert told([LEGS[i] for i in order], drift=drift)[0].attrs["constraint_drift"] == pytest.approx(max(5e-7, drift))


def test_a_run_without_waves_has_no_elevation_and_in_still_or_rough_water_no_steady_power(told, small):
    """Its sea is one of its database; clamps that are not there do not slip."""
    assert told(LEGS, database="", holds=False)[1] == [(None, (4.0, 8.0))] * 3
    for kind in ({"kind": "still"}, {"kind": "jonswap", "hs": 1.0, "tp": 4.0}):
        (wave,) = varied(small.study, waves=[kind]).waves
        attrs = told(LEGS, wave=wave, holds=False)[0].attrs
        assert not {"steady_power", "constraint_drift"} & set(attrs)
        assert attrs["wave"] == wave.label


@pytest.mark.parametrize(("port", "words"), [
    ("pitch", "pitch: moment against angular velocity, impedance in N m s, velocity in rad/s"), ("heave", None),
    ("volume", None),
])  # fmt: skip
def test_a_run_tells_its_port_where_that_turns(told, port, words):
    assert told(LEGS, pto={"port": port})[0].attrs.get("port") == words


# steady power --------------------------------------------------------------------------------------------------------


def drifting(omega=(2.0, 3.5)):
    """Two masses, of which the first is held by nothing, in some waves; a take-off and another damper on both."""
    pto, other = np.array([[3.0, 1.0], [1.0, 2.0]]), np.diag([0.2, 5.0])
    waves = np.array([[30.0 + 5j, -2.0], [4.0, 8j]])[: len(omega)]
    forces = {
        "hydrostatic": Spring(np.diag([0.0, 50.0])), "structural_damping": Damper(other), "pto": Damper(pto),
        "excitation": Excitation(np.array(omega), waves),
    }  # fmt: skip
    return System.of(Scene(("Surge", "Heave"), np.diag([2.0, 1.0]), forces, np.eye(2))), pto, other, waves


@pytest.mark.parametrize("omega", [(2.0,), (2.0, 3.5)])
def test_the_power_of_what_nothing_holds_is_that_of_its_swinging(omega):
    """Half v*.C v of the take-off's damper alone, of every wave; of what it does not forget it tells so."""
    system, pto, other, waves = drifting(omega)
    power = 0.0
    for w, push in zip(omega, waves, strict=True):
        v = np.linalg.solve(-1j * w * np.diag([2.0, 1.0]) + pto + other + 1j / w * np.diag([0.0, 50.0]), push)
        power += 0.5 * (v.conj() @ pto @ v).real
    assert simulate._swinging_power(system) == pytest.approx(power, rel=1e-9)
    assert simulate._steady(system) == {"steady_power": pytest.approx(power, rel=1e-9), "steady_decay": 1.0}


@pytest.mark.parametrize("system", [
    {}, {"switching": True}, {"pauses": True}, {"jumps": True}, {"linear": True}, {"linear": True, "loose": True},
    {"loose": True}, {"pauses": True, "jumps": True},
])  # fmt: skip
@pytest.mark.parametrize("refused", [None, ConvergenceError, StabilityError])
def test_by_what_a_steady_power_is_found(monkeypatch, system, refused):
    """Harmonic balance; of a law that pauses or jumps, or switches and has none there, a motion that is followed."""

    def balanced(system, tolerance):
        assert tolerance == 1e-6
        if refused:
            raise refused("no balance")
        return SimpleNamespace(power=SimpleNamespace(pto=5.0), decay=0.25)

    monkeypatch.setattr(simulate, "harmonic_balance", balanced)
    monkeypatch.setattr(simulate, "settled_power", lambda system, tolerance: (6.0, tolerance / 10))
    monkeypatch.setattr(simulate, "_swinging_power", lambda system: 4.0)
    known = {"linear": False, "pauses": False, "jumps": False, "switching": False, **system}
    scene = SimpleNamespace(adrift=known.pop("loose", False))
    found = simulate._steady(SimpleNamespace(scene=scene, **known))
    followed = known["pauses"] or known["jumps"] or (known["switching"] and refused)
    if known["linear"] and scene.adrift:
        assert found == {"steady_power": 4.0, "steady_decay": 1.0}
    elif followed:
        assert found == {"steady_power": 6.0, "steady_unsettled": pytest.approx(SETTLED / 10)}
    else:
        told = {"no_steady_state": "no balance"}
        assert found == (told if refused else {"steady_power": 5.0, "steady_decay": 0.25})


def test_a_motion_that_is_lost_has_no_steady_power(monkeypatch):
    def lost(*_):
        raise ConvergenceError("switches without end")

    monkeypatch.setattr(simulate, "settled_power", lost)
    assert simulate._settled(None) == {"no_steady_state": "switches without end"}


# clamps and ports ----------------------------------------------------------------------------------------------------


def test_clamps_of_still_water_or_of_what_is_not_linear_are_followed_once(small, monkeypatch):
    """No ten thousand periods; else from where the run begins, and the slip is that of all degrees of freedom."""
    asked, rows = [], np.array([[0.0, 2.0]])
    (still,) = varied(small.study, waves=[{"kind": "still"}]).waves

    def propagated(system, time, start):
        asked.append(start)
        return SimpleNamespace(position=np.array([[0.0, 1.0], [0.0, -3.0]]))

    monkeypatch.setattr(simulate, "propagate", propagated)
    scene = SimpleNamespace(motions=np.array([[1.0, 0.0], [0.0, 0.5]]), start=lambda *first: first)
    settings = SimpleNamespace(initial_position=0.3, initial_velocity=-0.2)
    for wave, linear, slip in ((WAVE, True, 3.0), (WAVE, False, 0.0), (still, True, 0.0)):
        spec = SimpleNamespace(waves=(wave,), simulation=settings)
        assert simulate._linear_drift(spec, SimpleNamespace(linear=linear, scene=scene), rows) == slip
    assert asked == [(0.3, -0.2)]


def test_a_body_tells_how_its_port_moves_and_a_shell_does_not():
    """By the degrees of freedom of the record, whatever their order and how many there are."""
    labels = ["Surge", "Heave", "Pitch"]
    pto = Pto(port={"dofs": {"Heave": 2.0, "Pitch": -0.5, "Surge": 4.0}})
    values = np.arange(4.0).reshape(2, 2)
    run = xr.Dataset({"position": (("time", "dof"), values), "velocity": (("time", "dof"), values**2)})
    run = run.assign_coords(dof=["Pitch", "Heave"])
    body = BodySimulateSpec.model_construct(pto=pto)
    found = simulate.with_stroke(run, body, labels)
    np.testing.assert_allclose(found.stroke.values, values @ [-0.5, 2.0])
    np.testing.assert_allclose(found.stroke_rate.values, values**2 @ [-0.5, 2.0])
    assert simulate.with_stroke(run, SimpleNamespace(pto=pto), labels) is run


def test_what_a_design_holds_is_told_by_its_rows_of_a_body_or_of_a_shell(monkeypatch):
    """Without a shell nothing is clamped."""
    labels = ("Surge", "Heave", "Pitch")
    design = BodyDesign(held=({"Surge": 1.0, "Pitch": -2.0}, {"Heave": 1.0}))
    body = BodySimulateSpec.model_construct(designs={"one": design})
    assert simulate.held_at_zero(body, None, (), labels).tolist() == [[1.0, 0.0, -2.0], [0.0, 1.0, 0.0]]
    spec = SimpleNamespace(designs={"one": SimpleNamespace(clamp="clamps")})
    assert simulate.held_at_zero(spec, None, (), labels).shape == (0, 3)
    monkeypatch.setattr(simulate, "all_clamp_rows", lambda *given: given)
    shape = SimpleNamespace(basis="basis")
    assert simulate.held_at_zero(spec, shape, ("orders",), labels) == ("clamps", "basis", ("orders",))


def test_volume_and_area_of_a_shell_with_orders_are_those_of_all_its_motions(monkeypatch):
    """In the order of its bases; a motion the run has not is none."""
    found = []
    monkeypatch.setattr(simulate, "enclosed_in_orders", lambda *given: found.append(given) or ([1.0, 2.0], [3.0, 4.0]))
    basis, *orders = (SimpleNamespace(labels=list(names)) for names in (("a", "b"), ("c",), ("d", "e")))
    values = np.arange(8.0).reshape(2, 4)
    run = xr.Dataset({"position": (("time", "dof"), values)}, {"dof": ["e", "a", "d", "b"]})
    run = simulate.with_enclosed(run, SimpleNamespace(basis=basis), orders)
    ((own, others, moved),) = found
    assert (own, others) == (basis, orders)
    np.testing.assert_array_equal(moved, np.column_stack([values[:, [1, 3]], [0.0, 0.0], values[:, [2, 0]]]))
    assert (run.volume.values.tolist(), run.area.values.tolist()) == ([1.0, 2.0], [3.0, 4.0])


def test_volume_and_area_of_a_shell_are_those_of_its_motions_beyond_its_shape_at_rest(monkeypatch):
    """A motion the run has not leaves what there is of it at rest."""
    found = []
    monkeypatch.setattr(simulate, "enclosed", lambda *given: found.append(given) or ([1.0, 2.0], [3.0, 4.0]))
    shape = SimpleNamespace(basis=SimpleNamespace(labels=["a", "b", "c"]), modal_amplitude=np.array([0.5, -2.0, 7.0]))
    run = xr.Dataset({"position": (("time", "dof"), [[1.0, 2.0], [3.0, 4.0]])}, {"dof": ["c", "a"]})
    run = simulate.with_enclosed(run, shape)
    ((basis, moved),) = found
    assert basis is shape.basis
    np.testing.assert_array_equal(moved, [[2.5, -2.0, 8.0], [4.5, -2.0, 10.0]])
    assert (run.volume.values.tolist(), run.area.values.tolist()) == ([1.0, 2.0], [3.0, 4.0])
