"""The drag of a study in its scenes, its linear theory, its ladder and its ledger."""

import itertools
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied

from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.simulate import suited
from vsb.motion.forces import Spring
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.results.ladder import study_ladder
from vsb.results.run_checks import drag_check
from vsb.scenes import drag as drag_module
from vsb.scenes.build import TUNED, body_exact_design, linear_design
from vsb.scenes.drag import DAMPERS, LINEARISED, coefficients, dragged, dragged_port, flow, linearised, with_drag
from vsb.study.drag import Drag
from vsb.study.plan import StudyPlan
from vsb.study.sections import Water
from vsb.study.study import parse
from vsb.study.waves import RegularWave
from vsb.waves.dispersion import wavenumber
from vsb.waves.seas import NO_WAVES, Sea

WAVE = {"kind": "regular", "amplitude": 0.5, "period": 4.0}
PLATE = {"heave": {"coefficient": 1.0, "area": 12.57}}


def study_of(small, design="VSWEC", drag=PLATE, wave=WAVE, **sections):
    """The small study with one design, one wave and drag."""
    data = small.study.model_dump()
    data |= {"designs": {design: data["designs"][design]}, "waves": [wave], **({"drag": drag} if drag else {})}
    return varied(parse(data), **sections)


def run_of(study):
    """The specification of the run of a study of one design in one wave."""
    (design,), (wave,) = study.designs, study.waves
    return StudyPlan(study).simulation(design, wave)


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_quadratic_drag_takes_what_its_equivalent_damper_takes(small, design):
    """Steady state with all harmonics against equivalent linearisation: drag is a tenth of all damping here."""
    at = linear_design(run_of(study_of(small, design)), small.hydro_files)
    found = harmonic_balance(at.system)
    assert at.notes[LINEARISED] == pytest.approx(found.power.pto, rel=2e-3)
    free = linear_design(run_of(study_of(small, design, drag=None)), small.hydro_files)
    assert LINEARISED not in free.notes
    assert harmonic_balance(free.system).power.pto > 1.01 * found.power.pto
    assert suited(at.system) == "collocation"
    assert suited(free.system) == "exact"


def test_the_water_it_moves_in_counts(small):
    """Its undisturbed flow at half the draft: a buoy in long waves goes with the water, and drag does nothing."""
    study = study_of(small)
    omega = np.array([0.7, 2.0])
    deep = -1j * omega * np.exp(-(omega**2) / 9.81 * study.draft / 2)
    assert flow(run_of(study), omega, 0.0)[:, 0] == pytest.approx(deep, rel=1e-12)
    shallow = varied(study, water={"depth": 10.0})
    assert abs(flow(run_of(shallow), omega, 0.0)[0, 0]) < abs(flow(run_of(study), omega, 0.0)[0, 0])


def test_a_tuned_damper_is_the_best_beside_drag(small):
    """No damper around it takes more, by linear theory and in the steady state."""

    def taken(damping):
        return linear_design(run_of(study_of(small, pto={"damping": damping, "tuning": "fixed"})), small.hydro_files)

    best = linear_design(run_of(study_of(small, pto={"tuning": "each"})), small.hydro_files)
    for factor in (0.8, 1.25):
        assert taken(best.notes[TUNED] * factor).notes[LINEARISED] < best.notes[LINEARISED]
        assert harmonic_balance(taken(best.notes[TUNED] * factor).system).power.pto < (
            harmonic_balance(best.system).power.pto
        )


def test_in_still_water_drag_brakes_and_nothing_of_linear_theory_is_recorded(small):
    at = linear_design(run_of(study_of(small, wave={"kind": "still"})), small.hydro_files)
    assert at.notes == {"model": "linear"}
    assert at.scene.forces["drag"].force(np.zeros(1), np.zeros((1, 4)), np.array([[2.0, 0.0, 0.0, 0.0]]))[0] == (
        pytest.approx([-0.5 * 1025.0 * 1.0 * 12.57 * 4.0, 0.0, 0.0, 0.0])  # rho C A |v| v/2
    )


def test_a_body_exact_scene_has_it_too(small):
    study = study_of(small, "FSB", wave={**WAVE, "amplitude": 0.02}, hydro={"model": "body_exact"})
    at = body_exact_design(run_of(study), small.hydro_files)
    linear = linear_design(run_of(varied(study, hydro={"model": "linear"})), small.hydro_files)
    assert suited(at.system) == "collocation"
    assert at.notes[LINEARISED] == linear.notes[LINEARISED]
    assert harmonic_balance(at.system).power.pto == pytest.approx(harmonic_balance(linear.system).power.pto, rel=1e-3)


def test_the_ladder_is_climbed_beside_drag(small):
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "gamma": 3.3, "seed": 1}
    data = small.study.model_dump() | {"waves": [WAVE, sea]}
    free, dragged = (
        study_ladder(StudyPlan(parse(data | extra)).ladder, small.database_path) for extra in ({}, {"drag": PLATE})
    )
    for before, after in zip(free, dragged, strict=True):
        assert before[:3] == after[:3]
        lost = 1 - after.power_mean / before.power_mean
        assert lost == 0 if after.rung == "matched" else 1e-3 < lost < 0.7
    for one, many in itertools.product(("best_damper",), ("fixed", "best_damper_all_seas")):
        power = {(r.design, r.wave, r.rung): r.power_mean for r in dragged}
        for design, wave, rung in list(power):
            if rung == one:
                assert power[design, wave, many] <= power[design, wave, one] * (1 + 1e-9)
                assert power[design, wave, one] <= power[design, wave, "best_spring_damper"] * (1 + 1e-9)
    fixed = next(r for r in dragged if r.design == "VSWEC" and r.rung == "fixed")
    run = linear_design(run_of(study_of(small)), small.hydro_files)
    assert fixed.power_mean == pytest.approx(run.notes[LINEARISED], rel=1e-9)
    assert fixed.force_peak == pytest.approx(8000.0 * fixed.stroke_peak * 2 * np.pi / 4.0, rel=1e-9)


@pytest.mark.parametrize(("mean", "verdict"), [(1049.0, "ok"), (951.0, "ok"), (1051.0, "doubt"), (949.0, "doubt")])
def test_the_ledger_compares_drag_with_its_damper(small, mean, verdict):
    study = study_of(small)
    check = drag_check(study, study.waves[0], {LINEARISED: 1000.0, "drag_damping": 500.0}, mean, "VSWEC")
    assert check.verdict == verdict
    assert "1000 W beside its equivalent damper of 500 N s/m" in check.explanation


@pytest.mark.parametrize("coefficient", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("area", [3.0, 12.57])
def test_a_drag_of_half_the_density_times_coefficient_area_and_cubed_lever(coefficient, area):
    """rho C A |u| u/2; on a rotation the plate's speed goes with its lever, squared in the force, once in the torque."""
    plate = {"coefficient": coefficient, "area": area}
    found = coefficients(Drag(heave=plate, surge=plate, pitch={**plate, "lever": 2.0}), 1025.0)
    assert found == pytest.approx(512.5 * coefficient * area * np.array([1.0, 1.0, 8.0]), rel=1e-14)


@pytest.mark.parametrize("stiffness", [-3e4, 6e4])
def test_linear_theory_of_drag_knows_the_spring_of_the_take_off(small, stiffness):
    """Beside it the steady state takes another power, and so does the equivalent damper."""
    free, sprung = (
        linear_design(run_of(study_of(small, "FSB", pto={"stiffness": k})), small.hydro_files) for k in (0.0, stiffness)
    )
    assert sprung.notes[LINEARISED] == pytest.approx(harmonic_balance(sprung.system).power.pto, rel=5e-3)
    assert abs(sprung.notes[LINEARISED] / free.notes[LINEARISED] - 1) > 0.05


@pytest.mark.parametrize("towards", [0.0, 30.0, 120.0, -90.0])
def test_the_water_moves_along_its_way_and_upwards_by_depth_and_direction(towards):
    """w cosh k(z + d)/sinh kd along x and y by their shares, -i w sinh k(z + d)/sinh kd upwards; it does not turn."""
    plate, vane = {"coefficient": 1.0, "area": 1.0}, {"coefficient": 1.0, "area": 1.0, "lever": 2.0}
    drag = Drag(surge=plate, sway=plate, heave=plate, roll=vane, pitch=vane, yaw=vane)
    run = SimpleNamespace(drag=drag, water=Water(depth=10.0, gravity=9.6), draft=3.0)
    omega = np.array([0.7, 1.9])
    k = np.array([wavenumber(w, 10.0, 9.6) for w in omega])
    along = omega * np.cosh(k * 8.5) / np.sinh(k * 10.0)
    expected = np.zeros((2, 6), dtype=complex)
    expected[:, 0], expected[:, 1] = np.cos(np.deg2rad(towards)) * along, np.sin(np.deg2rad(towards)) * along
    expected[:, 2] = -1j * omega * np.sinh(k * 8.5) / np.sinh(k * 10.0)
    np.testing.assert_allclose(flow(run, omega, towards), expected, rtol=1e-10, atol=1e-15)


def test_a_drag_acts_on_the_motion_of_its_name_alone():
    drag = Drag(heave={"coefficient": 1.0, "area": 1.0}, surge={"coefficient": 1.0, "area": 2.0})
    np.testing.assert_array_equal(dragged(drag, ["Heave", "Membrane2", "Surge"]), [[0, 0, 1], [1, 0, 0]])


OBLIQUE = RegularWave(kind="regular", amplitude=1.0, period=1.0, direction=40.0)
TWO = Sea(np.array([0.7, 1.9]), np.array([0.3 + 0.1j, -0.2j]))


def two_ways(density=900.0):
    """Of a study what its drag needs: surge and heave, in water that is not the sea's."""
    plates = {"surge": {"coefficient": 0.8, "area": 3.0}, "heave": {"coefficient": 0.5, "area": 4.0}}
    return SimpleNamespace(drag=Drag(**plates), water=Water(density=density, depth=10.0, gravity=9.6), draft=3.0)


def test_the_drag_of_a_scene_is_of_its_water_and_of_the_way_its_waves_go():
    run, scene = two_ways(), Scene(("Heave", "Surge"), np.eye(2), {"hydrostatic": Spring(np.eye(2))}, np.eye(2))
    found = with_drag(scene, run, OBLIQUE, TWO)
    assert list(found.forces) == ["hydrostatic", "drag"]
    force = found.forces["drag"]
    np.testing.assert_allclose(force.coefficient, [0.5 * 900.0 * 0.8 * 3.0, 0.5 * 900.0 * 0.5 * 4.0], rtol=1e-14)
    np.testing.assert_array_equal(force.direction, [[0.0, 1.0], [1.0, 0.0]])
    np.testing.assert_array_equal(force.omega, TWO.omega)
    np.testing.assert_allclose(force.flow, TWO.amplitude[:, None] * flow(run, TWO.omega, 40.0), rtol=1e-14)
    assert with_drag(scene, SimpleNamespace(drag=None), OBLIQUE, TWO) is scene


@dataclass(frozen=True)
class Answer:
    """Stands for a linear buoy in waves of a direction."""

    labels: tuple[str, ...] = ("Heave", "Surge")
    direction: float = 0.0


def test_a_dragged_port_is_of_each_direction_s_buoy_flow_and_frequencies(monkeypatch):
    monkeypatch.setattr(drag_module, "DraggedPort", SimpleNamespace(of=lambda *given: given, joined=list))
    motions = {"A": np.eye(2), "B": np.eye(2)[:, :1]}
    run, floating = two_ways(), SimpleNamespace(linear=Answer(), motions=motions, port=np.array([0.5, 2.0]))
    going = {0.0: np.array([0.7, 1.9]), 40.0: np.array([1.1])}
    parts = dragged_port(run, floating, "B", going)
    for (buoy, omega, free, port, along, moved, strength), (at, own) in zip(parts, going.items(), strict=True):
        assert buoy.direction == pytest.approx(np.deg2rad(at))
        np.testing.assert_array_equal(omega, own)
        np.testing.assert_array_equal(free, motions["B"])
        np.testing.assert_array_equal(port, floating.port)
        np.testing.assert_array_equal(along, [[0.0, 1.0], [1.0, 0.0]])
        np.testing.assert_allclose(moved, flow(run, own, at), rtol=1e-14)
        np.testing.assert_allclose(strength, coefficients(run.drag, 900.0), rtol=1e-14)


def test_linear_theory_records_the_dampers_and_the_power_of_its_own_sea_and_load(monkeypatch):
    """Of one sea from its own side under damper and spring of the run; of no drag or no waves nothing."""
    asked = []

    class Stub:
        def settled(self, *given):
            asked.append(given)
            return np.array([[[30.0, 40.0]]])

        def powers(self, *given):
            asked.append(given)
            return np.array([[7.0]])

    monkeypatch.setattr(drag_module, "dragged_port", lambda *given: asked.append(given) or Stub())
    run = two_ways()
    found = linearised(run, "floating", "B", LinearPto(55.0, -3.0), OBLIQUE, TWO)
    assert found == {DAMPERS: [30.0, 40.0], LINEARISED: 7.0}
    (study, floating, design, going), *loads = asked
    assert (study, floating, design, list(going)) == (run, "floating", "B", [40.0])
    np.testing.assert_array_equal(going[40.0], TWO.omega)
    assert len(loads) == 2
    for waves, damping, stiffness in loads:
        np.testing.assert_allclose(waves, [[0.1, 0.04]])
        assert (damping.tolist(), stiffness.tolist()) == ([55.0], [-3.0])
    assert linearised(run, "floating", "B", LinearPto(55.0), OBLIQUE, NO_WAVES) == {}
    assert linearised(SimpleNamespace(drag=None), "floating", "B", LinearPto(55.0), OBLIQUE, TWO) == {}
