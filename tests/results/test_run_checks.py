"""Checks of runs: energy, small motion, slip at clamps, steady state, latching times, linear theory."""

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.engine.integrators.settings import Simulation
from vsb.engine.waves.water import wavenumber
from vsb.errors import ConvergenceError
from vsb.keys.reading import validated
from vsb.models.build import TUNED
from vsb.models.rest import study_basis
from vsb.results.run_checks import (
    DAMPERS,
    LINEARISED,
    ROTATION,
    agreement_checks,
    body_motion_checks,
    buoy_motion_checks,
    energy_check,
    law_checks,
    sea_checks,
    simplification_checks,
    transient_checks,
)
from vsb.results.verification import check_audit
from vsb.study.body import BodyStudy
from vsb.study.study import load, parse

SWELL = {"kind": "regular", "amplitude": 0.5, "period": 7.0, "direction": 90.0}
TIME = np.linspace(0.0, 60.0, 61)


def body_study(**changes):
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [SWELL], "pto": {"damping": 1.0}}
    return validated(BodyStudy, {**made, **changes}, "a.yaml")


def moved(labels, position, **attrs):
    """A run that is displaced at 50 s only, of 60 s."""
    path = np.zeros((61, len(labels)))
    path[50] = position
    attrs = {"design": "VSWEC", "wave": "w", "energy_residual": 0.0, **attrs}
    return xr.Dataset({"position": (("time", "dof"), path)}, {"time": TIME, "dof": labels}, attrs)


@pytest.mark.parametrize(
    ("settings", "limit"), [({"tolerance": 1e-4}, 1e-4), ({"tolerance": 1e-9}, 1e-6), ({"method": "convolution"}, 1e-4)]
)
def test_energy_limit_follows_the_method_and_the_tolerance(settings, limit):
    verdicts = [energy_check(Simulation(**settings), part * limit).verdict for part in (0.99, 1.01, 5.01)]
    assert verdicts == ["ok", "doubt", "fail"]


def test_run_whose_audit_fails_is_refused():
    check_audit(Simulation(), 4.9e-6)
    with pytest.raises(ConvergenceError, match=r"^the energy audit fails: 5\.1e-06 .*needs 1e-06; lower simulation\."):
        check_audit(Simulation(), 5.1e-6)


@pytest.mark.parametrize(
    ("name", "limit", "motion"),
    [
        ("heave", 0.3, lambda x: {"heave": 2.0 * x}),
        ("deformation", 0.1, lambda x: {"breathing": 2.0 * x}),
        ("strain", 0.02, lambda x: {"breathing": 2.0 * x}),  # of a sphere that breathes, its share of the radius
        ("energy_residual", 1e-6, lambda x: {"energy_residual": x}),
        ("constraint_drift", 1e-9, lambda x: {"constraint_drift": x}),
    ],
)
def test_check_of_a_buoys_run_changes_its_verdict_at_its_limit(seed, name, limit, motion):
    one = varied(seed, designs={"VSWEC": {}}, waves=[{"kind": "still"}])
    labels, basis = ["Heave", *(f"Membrane{n}" for n in range(7))], study_basis(seed)

    def checks(heave=0.0, breathing=0.0, study=one, **attrs):
        run = moved(labels, [heave, breathing, *[0.0] * 6], **attrs)
        return {check.name: check for check in sea_checks(study, study.waves[0], {"VSWEC": run}, basis)}

    below, above = (checks(**motion(part * limit))[name] for part in (0.99, 1.01))
    assert (below.verdict, above.verdict) == ("ok", "fail" if name == "constraint_drift" else "doubt")
    assert (below.limit, above.value) == (pytest.approx(limit), pytest.approx(1.01 * limit, rel=2e-3))
    late = varied(one, simulation={"window": [51.0, 60.0]})  # motion before the window does not count
    assert checks(heave=5.0, breathing=1.0, study=late)["heave"].value == 0.0
    assert checks(heave=5.0, breathing=1.0, study=late)["strain"].value == 0.0


def test_tilt_combines_pitch_and_roll_and_drift_is_along_the_waves():
    """In waves at 30 degrees."""
    data = load(SEED).model_dump() | {"motion": "planar"}
    data["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    study = varied(parse(data), waves=[{"kind": "regular", "amplitude": 0.1, "period": 3.0}])
    wave = study.waves[0].model_copy(update={"direction": 30.0})
    number, towards = wavenumber(wave.omega, np.inf, 9.81), np.deg2rad(30.0)
    along, across = np.array([np.cos(towards), np.sin(towards)]), np.array([-np.sin(towards), np.cos(towards)])
    for shift, expected in ((-0.7 * along, 0.7), (9.0 * across, 0.0), (0.4 * along + 5.0 * across, 0.4)):
        run = moved(["Heave", "Surge", "Sway", "Roll", "Pitch"], [0.0, *shift, -0.04, 0.03])
        _, pitch, surge = buoy_motion_checks(study, study_basis(study), wave, run)
        assert pitch.value == pytest.approx(0.05, rel=1e-12)
        assert surge.value == pytest.approx(number * expected, abs=1e-12)


def test_largest_motion_of_a_body_in_the_window_counts():
    """Translations over the size of the smaller body; elastic modes have no limit."""
    study, where = body_study(), {"design": "a", "wave": "sea"}
    one = moved(["float__Heave", "spar__Pitch", "Mode7"], [-0.5, 1.5 * ROTATION, 9.0], **where)
    turned, shifted = body_motion_checks(study, xr.Dataset(attrs={"displaced_volume": 8.0}), one)
    assert (turned.name, turned.verdict, turned.value) == ("rotation", "doubt", pytest.approx(1.5 * ROTATION))
    assert (shifted.name, shifted.verdict, shifted.value) == ("translation", "ok", pytest.approx(0.25))
    apart = xr.Dataset(attrs={"displaced_volume_float": 1.0, "displaced_volume_spar": 8.0})
    (worst,) = body_motion_checks(study, apart, moved(["float__Heave", "spar__Heave"], [0.5, 0.6], **where))
    assert (worst.verdict, worst.value, worst.design, worst.wave) == ("doubt", pytest.approx(0.5), "a", "sea")
    late = body_study(simulation={"duration": 60.0, "window": [51.0, 60.0]})
    assert [check.value for check in body_motion_checks(late, apart, one)] == [0.0, 0.0]


def test_errors_of_model_auto_add_up_in_the_gain(seed):
    two = varied(seed, hydro={"model": "auto"}, designs={"FSB": {"flexible": False}, "VSWEC": {}})

    def checks(rigid, shell):
        attrs = {"description": "linear", "left_out": '[{"what": "shell_modes", "error": 0.0021}]'}
        runs = {"FSB": xr.Dataset(attrs={**attrs, "power_error": rigid})}
        runs["VSWEC"] = xr.Dataset(attrs={**attrs, "power_error": shell})
        return simplification_checks(two, two.waves[0], runs)

    rigid, shell, gain = checks(0.0099, 0.0101)
    assert [check.verdict for check in (rigid, shell, gain)] == ["ok", "fail", "ok"]
    assert (gain.value, gain.limit, gain.design) == (pytest.approx(0.02), 0.02, "VSWEC")
    assert "left out: shell modes 2.1e-03" in shell.explanation


def test_mean_power_is_compared_with_the_steady_state():
    row, steady = (
        {"design": "FSB", "wave": "w", "record_power_mean": 100.6},
        {"steady_power": 100.0, "steady_decay": 0.1},
    )
    (check,) = transient_checks({("FSB", "w"): steady}, [row])
    assert (check.verdict, check.value, check.limit) == ("doubt", pytest.approx(0.006), 0.005)
    (none,) = transient_checks({("FSB", "w"): {"no_steady_state": "it drifts"}}, [row])
    assert (none.verdict, none.explanation.endswith("it drifts")) == ("doubt", True)
    assert transient_checks({("FSB", "w"): {}}, [row]) == []


def test_latching_time_at_the_border_of_the_search_is_in_doubt():
    wet = {"model": "body_exact", "linear_latching_time": 1.0, "latching_time_searched": 0.25}
    runs = {
        ("A", "w"): {**wet, "latching_time": 1.05},
        ("B", "w"): {**wet, "latching_time": 0.76},
        ("C", "w"): {"model": "linear", "latching_time": 1.08},
        ("D", "w"): {**wet, "linear_latching_time": 0.2, "latching_time": 0.0},
    }
    near, far = law_checks(runs)
    assert near.name == far.name == "latching_time"
    assert (near.verdict, near.value) == ("ok", pytest.approx(0.2))
    assert (far.verdict, far.value, far.design) == ("doubt", pytest.approx(0.96), "B")


def test_power_in_time_is_compared_with_the_frequency_domain():
    """8 W/m^2 in waves of 0.5 m towards 90 degrees are 2 W."""
    one = body_study()
    (wave,) = one.waves
    coords = {"wave_direction": [0.0, np.pi / 2], "design": ["a"], "omega": [wave.omega - 0.1, wave.omega]}
    power = np.array([[[1.0, 1.0]], [[1.0, 8.0]]])
    frequency = xr.Dataset({"absorbed_power": (("wave_direction", "design", "omega"), power)}, coords)

    def checks(mean, study=one, scale=1.0, **run):
        rows = [{"design": "a", "wave": wave.label, "record_power_mean": mean}]
        return agreement_checks(study, scale * frequency, rows, {("a", wave.label): {"model": "linear", **run}})

    for sign in (1, -1):
        (below,), (above,) = (checks(2.0 * (1 + sign * part * 0.005)) for part in (0.98, 1.02))
        assert (below.name, below.verdict, above.verdict) == ("time_and_frequency_domain", "ok", "doubt")
        (below,), (above,) = (checks(2.0 * (1 + sign * part * 0.05), model="body_exact") for part in (0.98, 1.02))
        assert (below.name, below.verdict, above.verdict) == ("linearity", "ok", "doubt")
    (held,) = checks(3e-16, scale=1e-28)  # powers of round-off are equal
    assert held.verdict == "ok"
    assert checks(2.1, body_study(pto={"damping": 1.0, "force_limit": 10.0})) == []
    (drag,) = checks(9.4, **{LINEARISED: 10.0, DAMPERS: 30.0, "model": "body_exact"})
    assert (drag.name, drag.verdict, drag.value) == ("drag", "doubt", pytest.approx(0.06))
    assert "equivalent damper of 30 N s/m" in drag.explanation


def test_tuned_run_is_compared_at_its_own_damping():
    """P = c |Z V|^2/|Z + c|^2 / 2 of each design in waves of 0.5 m; the response is at another damping."""
    one = body_study(designs={"a": {}, "b": {}})
    (wave,) = one.waves
    impedance, velocity = np.array([[2.0 + 1j], [4.0 - 3j]]), np.array([[3.0 + 0j], [1j]])
    values = {"port_impedance": impedance, "port_velocity": velocity, "absorbed_power": np.full((2, 1), 99.0)}
    values = {name: (("design", "omega"), value) for name, value in values.items()}
    frequency = xr.Dataset(values, {"design": ["a", "b"], "omega": [wave.omega]})
    runs = {("a", wave.label): {"model": "linear", TUNED: 5.0}, ("b", wave.label): {"model": "linear", TUNED: 7.0}}
    means = [0.25 * 0.5 * 5.0 * 5.0 * 9.0 / 50.0, 0.25 * 0.5 * 7.0 * 25.0 / 130.0]
    rows = [{"design": d, "wave": wave.label, "record_power_mean": mean} for d, mean in zip("ab", means, strict=True)]
    found = agreement_checks(one, frequency, rows, runs)
    assert [check.design for check in found] == ["a", "b"]
    assert [check.value for check in found] == pytest.approx([0.0, 0.0], abs=1e-12)
