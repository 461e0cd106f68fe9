"""Drag of a study in its scenes, its linear theory and its control levels."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied

from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.simulate import suited
from vsb.engine.waves.water import Water, wavenumber
from vsb.models.build import TUNED, body_exact_design, linear_design
from vsb.models.drag import LINEARISED, coefficients, flow
from vsb.pipeline.graph import StudyPlan
from vsb.results.ladder import CAUSAL, SAME_FORCE, study_ladder
from vsb.study.sections import Drag
from vsb.study.study import parse

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
    return StudyPlan(study).simulation(design, wave).spec


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_quadratic_drag_agrees_with_its_equivalent_damper(small, design):
    """Harmonic balance against equivalent linearisation; drag is a tenth of all damping here."""
    at = linear_design(run_of(study_of(small, design)), small.hydro_files)
    found = harmonic_balance(at.system)
    assert at.notes[LINEARISED] == pytest.approx(found.power.pto, rel=2e-3)
    free = linear_design(run_of(study_of(small, design, drag=None)), small.hydro_files)
    assert LINEARISED not in free.notes
    assert harmonic_balance(free.system).power.pto > 1.01 * found.power.pto
    assert suited(at.system) == "collocation"
    assert suited(free.system) == "exact"


def test_tuned_damper_is_optimal_beside_drag(small):
    """By linear theory and in the steady state."""

    def taken(damping):
        return linear_design(run_of(study_of(small, pto={"damping": damping, "tuning": "fixed"})), small.hydro_files)

    best = linear_design(run_of(study_of(small, pto={"tuning": "each"})), small.hydro_files)
    for factor in (0.8, 1.25):
        assert taken(best.notes[TUNED] * factor).notes[LINEARISED] < best.notes[LINEARISED]
        assert harmonic_balance(taken(best.notes[TUNED] * factor).system).power.pto < (
            harmonic_balance(best.system).power.pto
        )


def test_drag_force_in_still_water(small):
    at = linear_design(run_of(study_of(small, wave={"kind": "still"})), small.hydro_files)
    assert at.notes == {"model": "linear"}
    assert at.scene.forces["drag"].force(np.zeros(1), np.zeros((1, 4)), np.array([[2.0, 0.0, 0.0, 0.0]]))[0] == (
        pytest.approx([-0.5 * 1025.0 * 1.0 * 12.57 * 4.0, 0.0, 0.0, 0.0])  # rho C A |v| v/2
    )


def test_drag_in_a_body_exact_scene(small):
    study = study_of(small, "FSB", wave={**WAVE, "amplitude": 0.02}, hydro={"model": "body_exact"})
    at = body_exact_design(run_of(study), small.hydro_files)
    linear = linear_design(run_of(varied(study, hydro={"model": "linear"})), small.hydro_files)
    assert suited(at.system) == "collocation"
    assert at.notes[LINEARISED] == linear.notes[LINEARISED]
    assert harmonic_balance(at.system).power.pto == pytest.approx(harmonic_balance(linear.system).power.pto, rel=1e-3)


def test_control_levels_are_ordered_beside_drag(small):
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "gamma": 3.3, "seed": 1}
    data = small.study.model_dump() | {"waves": [WAVE, sea], "designs": {"VSWEC": {}}}
    free, dragged = (
        study_ladder(StudyPlan(parse(data | extra)).ladder.spec, small.database.out) for extra in ({}, {"drag": PLATE})
    )
    of_linear_water = (SAME_FORCE, CAUSAL)  # beside drag a row says why it has no power
    free, dragged = ([r for r in some if r.rung not in of_linear_water] for some in (free, dragged))
    for before, after in zip(free, dragged, strict=True):
        assert before[:3] == after[:3]
        lost = 1 - after.power_mean / before.power_mean
        assert lost == 0 if after.rung == "matched" else 1e-3 < lost < 0.7
    power = {(r.wave, r.rung): r.power_mean for r in dragged}
    for wave in {r.wave for r in dragged}:
        fixed, common, best, pair = (
            power[wave, level] for level in ("fixed", "best_damper_all_seas", "best_damper", "best_spring_damper")
        )
        assert max(fixed, common) <= best * (1 + 1e-9)
        assert best <= pair * (1 + 1e-9)
    fixed = next(r for r in dragged if r.rung == "fixed")
    run = linear_design(run_of(study_of(small)), small.hydro_files)
    assert fixed.power_mean == pytest.approx(run.notes[LINEARISED], rel=1e-9)
    assert fixed.force_peak == pytest.approx(8000.0 * fixed.stroke_peak * 2 * np.pi / 4.0, rel=1e-9)


@pytest.mark.parametrize(("coefficient", "area"), [(0.5, 12.57), (2.0, 3.0)])
def test_drag_coefficients(coefficient, area):
    """rho C A |u| u/2; on a rotation the lever enters cubed."""
    plate = {"coefficient": coefficient, "area": area}
    drag = Drag(heave=plate, surge=plate, pitch={**plate, "lever": 2.0})
    found = coefficients(drag.plates.values(), 1025.0)
    assert found == pytest.approx(512.5 * coefficient * area * np.array([1.0, 1.0, 8.0]), rel=1e-14)


@pytest.mark.parametrize("towards", [0.0, 30.0, 120.0, -90.0])
def test_wave_velocity_at_finite_depth(towards):
    """w cosh k(z + d)/sinh kd along the wave, -i w sinh k(z + d)/sinh kd upwards, no rotation."""
    plate, vane = {"coefficient": 1.0, "area": 1.0}, {"coefficient": 1.0, "area": 1.0, "lever": 2.0}
    drag = Drag(surge=plate, sway=plate, heave=plate, roll=vane, pitch=vane, yaw=vane)
    run = SimpleNamespace(plates=drag.plates, water=Water(depth=10.0, gravity=9.6), draft=3.0)
    omega = np.array([0.7, 1.9])
    k = np.array([wavenumber(w, 10.0, 9.6) for w in omega])
    along = omega * np.cosh(k * 8.5) / np.sinh(k * 10.0)
    expected = np.zeros((2, 6), dtype=complex)
    expected[:, 0], expected[:, 1] = np.cos(np.deg2rad(towards)) * along, np.sin(np.deg2rad(towards)) * along
    expected[:, 2] = -1j * omega * np.sinh(k * 8.5) / np.sinh(k * 10.0)
    np.testing.assert_allclose(flow(run, omega, towards), expected, rtol=1e-10, atol=1e-15)
