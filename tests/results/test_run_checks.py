"""Checks of runs: energy, constraint drift, the frequency domain, attitude, latching times."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.errors import ConvergenceError
from vsb.results.attitude import attitude_checks
from vsb.results.in_time import check_audit
from vsb.results.pauses import pause_checks
from vsb.results.run_checks import (
    DAMPERS,
    LINEARISED,
    agreement_checks,
    drift_checks,
    energy_check,
    linearity_check,
    steady_state_check,
)
from vsb.scenes.build import TUNED
from vsb.study.body import BodyStudy
from vsb.study.reading import validated
from vsb.study.study import Simulation, load, parse
from vsb.waves.dispersion import wavenumber

SWELL = {"kind": "regular", "amplitude": 0.5, "period": 7.0, "direction": 90.0}


def study(**changes):
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [SWELL], "pto": {"damping": 1.0}}
    return validated(BodyStudy, {**made, **changes}, "a.yaml")


def run(**attrs):
    return SimpleNamespace(attrs={"design": "a", "wave": "swell", "energy_residual": 2e-6, **attrs})


@pytest.mark.parametrize(
    ("settings", "limit"),
    [
        ({"tolerance": 1e-4}, 1e-4),
        ({"tolerance": 1e-9}, 1e-6),
        ({"method": "convolution"}, 1e-4),
    ],
)
def test_energy_limit_follows_the_method_and_the_tolerance(settings, limit):
    verdicts = [
        energy_check(study(simulation=settings), run(energy_residual=part * limit)).verdict
        for part in (0.99, 1.01, 5.01)
    ]
    assert verdicts == ["ok", "doubt", "fail"]


def test_run_whose_audit_fails_is_refused():
    settings = Simulation()
    check_audit(settings, 4.9e-6)
    with pytest.raises(ConvergenceError, match=r"^the energy audit fails: 5\.1e-06 .*needs 1e-06; lower simulation\."):
        check_audit(settings, 5.1e-6)


def test_constraint_drift_is_checked():
    assert drift_checks(study(), run()) == []
    (check,) = drift_checks(study(), run(constraint_drift=1e-6))
    assert (check.name, check.verdict) == ("constraint_drift", "fail")


def test_power_in_time_is_compared_with_the_frequency_domain():
    one = study()
    (wave,) = one.waves
    power = np.array([[[1.0, 1.0]], [[8.0, 8.0]]])
    coords = {"wave_direction": [0.0, np.pi / 2], "design": ["a"], "omega": [wave.omega - 0.1, wave.omega]}
    frequency = xr.Dataset({"absorbed_power": (("wave_direction", "design", "omega"), power)}, coords)
    rows, runs = [{"design": "a", "wave": wave.label, "power_mean": 2.02}], {("a", wave.label): {"model": "linear"}}
    (check,) = agreement_checks(one, wave, frequency, rows, runs)
    assert (check.name, check.verdict) == ("time_and_frequency_domain", "doubt")
    assert check.value == pytest.approx(0.01)
    rows[0]["power_mean"] = 3e-16  # powers of round-off are equal
    (held,) = agreement_checks(one, wave, 1e-28 * frequency, rows, runs)
    assert held.verdict == "ok"
    switching = study(pto={"damping": 1.0, "force_limit": 10.0})
    assert agreement_checks(switching, wave, frequency, rows, runs) == []
    (exact,) = agreement_checks(one, wave, frequency, rows, {("a", wave.label): {"model": "body_exact"}})
    assert exact.name == "linearity"


@pytest.mark.parametrize(("check", "limit"), [(linearity_check, 0.05), (steady_state_check, 0.005)])
def test_expected_power_scales_with_the_amplitude_squared(check, limit):
    """40 W/m^2 in waves of 0.5 m are 10 W; differences of either sign count."""
    one = study()
    for factor, verdict in ((0.98, "ok"), (1.02, "doubt")):
        for sign in (1, -1):
            found = check(one, one.waves[0], 40.0, 10.0 * (1 + sign * factor * limit), "a")
            assert (found.verdict, found.design, found.wave) == (verdict, "a", one.waves[0].label)
            assert found.value == pytest.approx(factor * limit, rel=0.06)


def test_run_with_drag_is_compared_with_its_equivalent_damper():
    one = study()
    (wave,) = one.waves
    runs = {("a", wave.label): {LINEARISED: 10.0, DAMPERS: 30.0, "model": "body_exact"}}
    rows = [{"design": "a", "wave": wave.label, "power_mean": 9.4}]
    (check,) = agreement_checks(one, wave, None, rows, runs)
    assert (check.name, check.verdict, check.value, check.design) == ("drag", "doubt", pytest.approx(0.06), "a")


def test_tuned_run_is_compared_at_its_own_damping():
    """P = c |Z V|^2/|Z + c|^2 / 2 of each design in waves of 0.5 m; the response is at another damping."""
    one = study(designs={"a": {}, "b": {}})
    (wave,) = one.waves
    impedance, velocity = np.array([[2.0 + 1j], [4.0 - 3j]]), np.array([[3.0 + 0j], [1j]])
    values = {"port_impedance": impedance, "port_velocity": velocity, "absorbed_power": np.full((2, 1), 99.0)}
    values = {name: (("design", "omega"), value) for name, value in values.items()}
    frequency = xr.Dataset(values, {"design": ["a", "b"], "omega": [wave.omega]})
    runs = {("a", wave.label): {"model": "linear", TUNED: 5.0}, ("b", wave.label): {"model": "linear", TUNED: 7.0}}
    means = [0.25 * 0.5 * 5.0 * 5.0 * 9.0 / 50.0, 0.25 * 0.5 * 7.0 * 25.0 / 130.0]
    rows = [{"design": d, "wave": wave.label, "power_mean": mean} for d, mean in zip("ab", means, strict=True)]
    found = agreement_checks(one, wave, frequency, rows, runs)
    assert [check.design for check in found] == ["a", "b"]
    assert [check.value for check in found] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_latching_time_at_the_border_of_the_search_is_in_doubt():
    wet = {"model": "body_exact", "linear_pause": 1.0, "pause_tried": 0.25}
    runs = {
        ("A", "w"): {**wet, "pause": 1.05},
        ("B", "w"): {**wet, "pause": 0.76},
        ("C", "w"): {"model": "linear", "pause": 1.08},
        ("D", "w"): {**wet, "linear_pause": 0.2, "pause": 0.0},
        ("E", "w"): {"model": "body_exact"},
    }
    near, far = pause_checks(runs)
    assert (near.verdict, far.verdict) == ("ok", "doubt")
    assert (near.value, far.value) == (pytest.approx(0.2), pytest.approx(0.96))
    assert (far.design, far.wave) == ("B", "w")


def test_tilt_combines_pitch_and_roll_and_drift_is_along_the_waves():
    """In waves at 30 degrees."""
    data = load(SEED).model_dump() | {"motion": "planar"}
    data["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    study = varied(parse(data), waves=[{"kind": "regular", "amplitude": 0.1, "period": 3.0}])
    (wave,) = study.waves
    turned = study.model_copy(update={"waves": (wave.model_copy(update={"direction": 30.0}),)})
    number, going = wavenumber(wave.omega, np.inf, 9.81), np.deg2rad(30.0)
    dofs = ["Surge", "Sway", "Heave", "Roll", "Pitch"]
    along, across = np.array([np.cos(going), np.sin(going)]), np.array([-np.sin(going), np.cos(going)])
    for moved, expected in ((-0.7 * along, 0.7), (9.0 * across, 0.0), (0.4 * along + 5.0 * across, 0.4)):
        position = np.array([[0.0] * 5, [*moved, 9.0, -0.04, 0.03]])
        run = xr.Dataset({"position": (("time", "dof"), position)}, {"time": [0.0, 1.0], "dof": dofs})
        run = run.assign_attrs(design="FSB", wave=turned.waves[0].label)
        pitch, surge = attitude_checks(turned, run)
        assert pitch.value == pytest.approx(0.05, rel=1e-12)
        assert surge.value == pytest.approx(number * expected, abs=1e-12)
