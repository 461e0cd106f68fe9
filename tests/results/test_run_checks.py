"""Runs against what they must agree with: their energy, what is held, the frequency domain."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from vsb.errors import ConvergenceError
from vsb.results.in_time import check_audit
from vsb.results.run_checks import (
    DAMPERS,
    LINEARISED,
    agreement_checks,
    dampers_in_words,
    drag_check,
    drift_checks,
    energy_check,
    linearity_check,
    steady_state_check,
)
from vsb.scenes.build import TUNED
from vsb.study.body import BodyStudy
from vsb.study.reading import validated
from vsb.study.study import Simulation

SWELL = {"kind": "regular", "amplitude": 0.5, "period": 7.0, "direction": 90.0}


def study(**changes):
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [SWELL], "pto": {"damping": 1.0}}
    return validated(BodyStudy, {**made, **changes}, "a.yaml")


def run(**attrs):
    return SimpleNamespace(attrs={"design": "a", "wave": "swell", "energy_residual": 2e-6, **attrs})


def test_energy_is_balanced_to_what_the_method_promises():
    assert energy_check(study(), run()).verdict == "doubt"
    convolved = study(simulation={"method": "convolution"})
    assert energy_check(convolved, run()).verdict == "ok"


@pytest.mark.parametrize(
    ("settings", "limit"),
    [
        ({}, 1e-6),
        ({"tolerance": 1e-4}, 1e-4),
        ({"method": "convolution"}, 1e-4),
        ({"tolerance": 1e-9}, 1e-6),
        ({"method": "exact"}, 1e-6),
        ({"method": "structure_preserving", "tolerance": 1e-9}, 1e-6),
        ({"method": "convolution", "tolerance": 1e-9}, 1e-4),
        ({"method": "convolution", "tolerance": 1e-2}, 1e-2),
    ],
)
def test_energy_is_closed_on_one_side_of_its_limit_and_not_on_the_other(settings, limit):
    verdicts = [
        energy_check(study(simulation=settings), run(energy_residual=part * limit)).verdict
        for part in (0.99, 1.01, 5.01)
    ]
    assert verdicts == ["ok", "doubt", "fail"]


def test_no_power_is_taken_from_a_run_whose_audit_fails():
    settings = Simulation()
    check_audit(settings, 4.9e-6)
    with pytest.raises(ConvergenceError, match=r"^the energy audit fails: 5\.1e-06 .*needs 1e-06; lower simulation\."):
        check_audit(settings, 5.1e-6)


def test_checks_of_a_run_say_whose_they_are():
    found = [energy_check(study(), run()), *drift_checks(study(), run(constraint_drift=1e-6))]
    assert [(check.design, check.wave) for check in found] == 2 * [("a", "swell")]


def test_what_is_held_is_watched_where_something_is():
    assert drift_checks(study(), run()) == []
    (check,) = drift_checks(study(), run(constraint_drift=1e-6))
    assert (check.name, check.verdict) == ("constraint_drift", "fail")


def test_power_in_time_is_that_of_the_frequency_domain_in_the_sea_s_own_direction():
    one = study()
    (wave,) = one.waves
    power = np.array([[[1.0, 1.0]], [[8.0, 8.0]]])
    coords = {"wave_direction": [0.0, np.pi / 2], "design": ["a"], "omega": [wave.omega - 0.1, wave.omega]}
    frequency = xr.Dataset({"absorbed_power": (("wave_direction", "design", "omega"), power)}, coords)
    rows, runs = [{"design": "a", "wave": wave.label, "power_mean": 2.02}], {("a", wave.label): {"model": "linear"}}
    (check,) = agreement_checks(one, wave, frequency, rows, runs)
    assert (check.name, check.verdict) == ("time_and_frequency_domain", "doubt")
    assert check.value == pytest.approx(0.01)
    after = study(waves=[{**SWELL, "direction": 0.0}, SWELL])  # and of the second sea, its own
    (second,) = agreement_checks(after, wave, frequency, rows, runs)
    assert second.value == check.value
    rows[0]["power_mean"] = 3e-16  # W, of bodies held together: round-off is no doubt of round-off
    (held,) = agreement_checks(one, wave, 1e-28 * frequency, rows, runs)
    assert (held.verdict, held.value) == ("ok", 3e-16)
    switching = study(pto={"damping": 1.0, "force_limit": 10.0})
    assert agreement_checks(switching, wave, frequency, rows, runs) == []
    (exact,) = agreement_checks(one, wave, frequency, rows, {("a", wave.label): {"model": "body_exact"}})
    assert exact.name == "linearity"


@pytest.mark.parametrize(("check", "limit"), [(linearity_check, 0.05), (steady_state_check, 0.005)])
def test_power_is_expected_to_grow_with_the_square_of_the_amplitude(check, limit):
    """40 W/m^2 in waves of 0.5 m are 10 W; a difference above its limit is a doubt on either side."""
    one = study()
    for factor, verdict in ((0.98, "ok"), (1.02, "doubt")):
        for sign in (1, -1):
            found = check(one, one.waves[0], 40.0, 10.0 * (1 + sign * factor * limit), "a")
            assert (found.verdict, found.design, found.wave) == (verdict, "a", one.waves[0].label)
            assert found.value == pytest.approx(factor * limit, rel=0.06)  # over the larger, or over what is expected
    assert "10 W in linear theory" in linearity_check(one, one.waves[0], 40.0, 11.0, "a").explanation


def test_an_equivalent_damper_of_heave_alone_needs_no_name_and_others_have_theirs(seed):
    """A body's, and a buoy's without drag, is of heave; of rotations it is in N m s."""
    for one in (study(), seed):
        assert dampers_in_words(one, {DAMPERS: 30.0}) == "30 N s/m"
    drag = {"directions": {"heave": {"coefficient": 1.0}, "pitch": {"coefficient": 1.0}}}
    both = seed.model_copy(update={"drag": SimpleNamespace(**drag)})
    assert dampers_in_words(both, {DAMPERS: [30.0, 4.5]}) == "30 N s/m of heave and 4.5 N m s of pitch"


def test_every_design_is_judged_by_its_own_run_in_its_own_sea():
    """Two designs in the second of two seas; one linear, one body-exact; the first sea is of no account."""
    waves = [
        {"kind": "regular", "amplitude": 0.25, "period": 5.0},
        {"kind": "regular", "amplitude": 0.5, "period": 7.0},
    ]
    one = study(designs={"a": {}, "b": {}}, waves=waves)
    first, wave = one.waves
    omega = [wave.omega - 0.2, wave.omega - 1e-9, first.omega]  # what is nearest, from below or from above
    for shift in (0.0, 2e-9):
        coords = {"design": ["a", "b"], "omega": np.array(omega) + shift}
        frequency = xr.Dataset({"absorbed_power": (("design", "omega"), [[1.0, 8.0, 3.0], [1.0, 40.0, 3.0]])}, coords)
        means = {("a", first): 55.0, ("b", first): 55.0, ("a", wave): 2.0, ("b", wave): 9.5}
        places = [*means, ("a", first), ("b", first)]  # rows of the first sea before and after
        rows = [{"design": d, "wave": w.label, "power_mean": means[d, w]} for d, w in places]
        runs = {(d, w.label): {"model": "linear" if d == "a" else "body_exact"} for d, w in means}
        linear, exact = agreement_checks(one, wave, frequency, rows, runs)
        assert (linear.name, linear.design, linear.wave) == ("time_and_frequency_domain", "a", wave.label)
        assert (exact.name, exact.design, exact.wave) == ("linearity", "b", wave.label)
        assert (linear.value, exact.value) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.05))
        assert exact.explanation == "mean power is 9.5 W body-exact, 10 W in linear theory"


def test_beside_drag_a_run_is_judged_by_its_equivalent_damper(seed):
    """Of its own sea, whose amplitude is in it already; the frequency response is not asked."""
    one = study()
    (wave,) = one.waves
    runs = {("a", wave.label): {LINEARISED: 10.0, DAMPERS: 30.0, "model": "body_exact"}}
    rows = [{"design": "a", "wave": wave.label, "power_mean": 9.4}]
    (check,) = agreement_checks(one, wave, None, rows, runs)
    assert check == drag_check(one, wave, runs["a", wave.label], 9.4, "a")
    assert (check.name, check.verdict, check.value, check.design) == ("drag", "doubt", pytest.approx(0.06), "a")
    assert check.explanation == (
        "mean power is 9.4 W with quadratic drag, 10 W beside its equivalent damper of 30 N s/m; the frequency response "
        "and the matched limit know no drag"
    )


def test_an_equivalent_damper_of_every_rotation_is_one_of_moments(seed):
    for name, unit in (("surge", "N s/m"), ("sway", "N s/m"), ("roll", "N m s"), ("pitch", "N m s"), ("yaw", "N m s")):
        both = seed.model_copy(update={"drag": SimpleNamespace(directions={name: None, "heave": None})})
        assert dampers_in_words(both, {DAMPERS: [3.0, 4.0]}) == f"3 {unit} of {name} and 4 N s/m of heave"


@pytest.mark.parametrize(("bem", "wave"), [(True, "swell"), (True, "still"), (False, "swell"), (False, "still")])
def test_a_slip_at_the_clamps_is_of_ten_thousand_periods_where_motion_is_linear_in_waves(bem, wave):
    """In still water, and under an assumed pressure, of the run."""
    (check,) = drift_checks(SimpleNamespace(needs_bem=bem), run(constraint_drift=1e-12, wave=wave))
    over = "10 000 wave periods" if bem and wave != "still" else "the run"
    assert check.explanation == f"largest slip of the shell at its clamps over {over}"


def test_the_only_direction_of_drag_has_its_name_unless_it_is_heave(seed):
    for name, told in (("pitch", "3 N m s of pitch"), ("surge", "3 N s/m of surge"), ("heave", "3 N s/m")):
        drag = seed.model_copy(update={"drag": SimpleNamespace(directions={name: None})})
        assert dampers_in_words(drag, {DAMPERS: [3.0]}) == told


def test_a_design_beside_drag_is_no_reason_to_leave_out_those_after_it():
    one = study(designs={"a": {}, "b": {}, "c": {}})
    (wave,) = one.waves
    coords = {"design": ["a", "b", "c"], "omega": [wave.omega, 2.0]}
    frequency = xr.Dataset({"absorbed_power": (("design", "omega"), [[1.0, 1.0], [8.0, 1.0], [12.0, 1.0]])}, coords)
    rows = [{"design": d, "wave": wave.label, "power_mean": p} for d, p in zip("abc", (9.0, 2.0, 3.0), strict=True)]
    runs = {("a", wave.label): {LINEARISED: 10.0, DAMPERS: 30.0}}
    runs |= {(d, wave.label): {"model": "linear"} for d in "bc"}
    found = agreement_checks(one, wave, frequency, rows, runs)
    assert [(check.name, check.design) for check in found] == [
        ("drag", "a"), ("time_and_frequency_domain", "b"), ("time_and_frequency_domain", "c"),
    ]  # fmt: skip
    assert [check.value for check in found] == pytest.approx([0.1, 0.0, 0.0], abs=1e-12)
    still = SimpleNamespace(label="still")
    assert agreement_checks(one, still, frequency, rows, runs) == []


def test_a_run_that_was_tuned_is_judged_by_what_its_own_damper_takes():
    """Half c |Z V|^2/|Z + c|^2 of each design's, in waves of 0.5 m; the response itself is of another damper."""
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


@pytest.mark.parametrize("sign", [1, -1])
def test_drag_may_change_power_by_a_twentieth_of_that_beside_its_damper(sign):
    one = study()
    for part, verdict in ((0.049, "ok"), (0.051, "doubt")):
        check = drag_check(one, one.waves[0], {LINEARISED: 10.0, DAMPERS: 30.0}, 10.0 * (1 + sign * part), "a")
        assert (check.limit, check.value, check.verdict) == (0.05, pytest.approx(part), verdict)
