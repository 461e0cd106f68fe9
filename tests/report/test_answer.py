"""The answer of a study in sentences and tables, failed checks with advice, and the band in which gains count."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.engine.motion.take_off import LAWS, Law
from vsb.keys.meanings import KEYS
from vsb.report.answer import (
    ADVICE,
    LOWEST,
    USEFUL_SHARE,
    answer_of_study,
    at_force_statements,
    closing_line,
    damping_in_words,
    gain_band,
    limits_aside,
    no_answer,
    reasons,
    useful_band,
    warnings,
    with_extremes,
)
from vsb.report.answer import headline as answered
from vsb.tools.words import interval_text

OMEGA = np.linspace(0.5, 4.0, 351)
SEAS = {"w": "a swell", "v": "a chop"}


def gained(design, gain, sea="w", power=100.0, width=None):
    """A line, with an interval of a width to either side of its gain if there is one."""
    ends = {} if width is None else {"best_low": gain - width, "best_high": gain + width}
    own = power * (1 + (gain or 0) / 100)
    return {"design": design, "sea": sea, "best_power": own, "best_gain_percent": gain, **ends}


def headline(*given, **named):
    """What stands."""
    return answered(*given, **named).stands


def best_power(**gains):
    base = np.exp(-((OMEGA - 2.0) ** 2))
    values = np.array([base, *((1 + np.asarray(gain)) * base for gain in gains.values())])
    return xr.DataArray(values, dims=("design", "omega"), coords={"design": ["FSB", *gains], "omega": OMEGA})


def test_best_design_with_interval_and_band():
    gain = 0.2 - 0.1 * np.abs(OMEGA - 2.0)
    first, second = headline([gained("FSB", 0.0), gained("A", 20.0, width=0.2)], best_power(A=gain), "FSB", SEAS)
    assert first == (
        "In a swell, each design at its optimal damping, A absorbs 20.0 % more than the rigid FSB (+19.8 to +20.2 % "
        "with all known errors; 120 against 100 W)."
    )
    assert (
        second
        == "Over the band where a design absorbs at least 5 % of the maximum, with damping optimal at each frequency, A absorbs up to 20 % more (in waves of 3.14 s)."
    )


def test_optimal_damping_says_that_it_knows_no_limits():
    """Power at optimal damping may exceed what any take-off within its limits absorbs."""
    for pto, words in (
        ({}, ""),
        ({"law": "linear", "force_limit": "inf"}, ""),
        ({"force_limit": 4e3}, " without limits"),
        ({"law": "saturated", "force_limit": 4e3}, " of a linear take-off"),
        ({"efficiency": 0.7, "force_limit": 4e3}, " without limits, after conversion with an efficiency of 0.7"),
    ):
        aside = limits_aside(pto)
        assert aside == words
        assert damping_in_words(pto).endswith(", before conversion") == ("efficiency" in pto)
        lines = [gained("FSB", 0.0), gained("A", 20.0)]
        (first, _) = headline(lines, best_power(A=0.2), "FSB", SEAS, aside=aside)
        assert first.startswith(f"In a swell, each design at its optimal damping{words}, A absorbs")


def test_most_favourable_sea_and_largest_loss():
    lines = [
        gained("FSB", 0.0),
        gained("A", -20.0),
        gained("B", -5.0),
        gained("FSB", 0.0, "v"),
        gained("A", 3.0, "v"),
        gained("B", 0.0, "v"),
    ]
    first, second = headline(lines, best_power(A=-0.2, B=0.04), "FSB", SEAS)
    assert first.startswith(
        "In a chop, the most favourable of 2 seas, each design at its optimal damping, the best flexible"
    )
    assert "design, A, absorbs 3.0 % more" in first
    assert first.endswith("flexible designs absorb more in 1 of the 2 seas, at worst 20.0 % less.")
    assert "flexible designs absorb up to 4 % more (B in" in second
    assert "up to 20 % less (A in" in second


def test_no_gain_without_a_rigid_design_or_power():
    assert headline([gained("A", None)], best_power(A=0.1), None, SEAS) == []
    assert headline([gained("FSB", 0.0), gained("A", None)], best_power(A=0.1), "FSB", SEAS) == []
    (only,) = headline([gained("FSB", 0.0), gained("A", 0.0)], 0 * best_power(A=0.1), "FSB", SEAS)
    assert "as much as the rigid FSB" in only


def test_interval_has_enough_decimals():
    assert interval_text(-3.64, 1.2) == "-3.6 to +1.2 %"
    assert interval_text(4.4012, 4.4047) == "+4.401 to +4.405 %"
    assert interval_text(None, None) == ""
    assert interval_text(0.0, 0.0) == ""
    assert interval_text(2.0, 2.0 + 1e-9) == "+2.0 %, exact to 1e-5 points"


BUCKLED = {"name": "computed_buckling", "value": 53.6, "limit": 1.0}
STRAINED = {"name": "strain", "value": 0.12, "limit": 0.02}


def test_best_design_is_chosen_among_valid_ones():
    """A is invalid only in the chop, where it would gain most."""
    lines = [gained("FSB", 0.0), gained("A", 5.0), gained("B", 2.0)]
    lines += [gained("FSB", 0.0, "v"), gained("A", 50.0, "v"), gained("B", 3.0, "v")]
    invalid = [{"design": "A", "sea": "v", **STRAINED}]
    found = answered(lines, best_power(A=0 * OMEGA, B=0 * OMEGA), "FSB", SEAS, invalid)
    assert found.stands[0].startswith("In a swell, the most favourable of 2 seas,")
    assert "the best flexible design, A, absorbs 5.0 % more" in found.stands[0]
    assert found.below == [
        "Not valid and not part of this answer: A in a chop, computed to absorb 50.0 % more than the rigid FSB; "
        "the strain reaches 12 %, beyond the limit of its material's law (Hooke's: 10 %)."
    ]


def test_gain_over_an_invalid_reference_is_no_answer():
    lines = [gained("FSB", 0.0), gained("A", 5.0), gained("FSB", 0.0, "v"), gained("A", 50.0, "v")]
    invalid = [{"design": "FSB", "sea": "v", **STRAINED, "name": "power_limit"}]
    found = answered(lines, best_power(A=0 * OMEGA), "FSB", SEAS, invalid)
    assert found.stands[0].startswith("In a swell, each design at its optimal damping, A absorbs 5.0 % more")
    assert found.below[0].startswith("Not valid and not part of this answer: A in a chop, computed to absorb 50.0 %")


def test_number_of_an_invalid_design_stands_below_the_answer():
    lines = [gained("FSB", 0.0), gained("A", 5.0, width=1.0)]
    invalid = [{"design": "A", "sea": "w", **BUCKLED}, {"design": "A", "sea": "w", **BUCKLED, "name": "buckling"}]
    found = answered(lines, best_power(A=0.1 + 0 * OMEGA), "FSB", SEAS, invalid)
    assert found.stands == [
        "No valid answer yet: the shell buckles under its static load (53.6 times what it can carry). Change first: "
        "raise device.internal_pressure to carry the load, or device.thickness."
    ]
    (below,) = found.below
    assert below.startswith("Computed although the model does not hold: In a swell, each design at its optimal")
    assert "A absorbs 5.0 % more than the rigid FSB (+4.0 to +6.0 % with all known errors; 105 against 100 W)" in below


def line(design, power, gain, given=None, sea="w", share=None, given_gain=None):
    return {
        "design": design, "sea": sea, "best_damping": 64282.0, "best_power": power, "best_gain_percent": gain,
        "damping": None if given is None else 8000.0, "power": given, "gain_percent": given_gain, "share": share,
    }  # fmt: skip


SWELL = [line("FSB", 781.1, 0.0, 207.0, share=0.265, given_gain=0.0), line("A", 705.8, -9.64, 227.0, "w", 0.322, 9.5)]
CHOP = [line("FSB", 100.0, 0.0, sea="v"), line("A", 112.8, 12.8, sea="v"), line("B", 100.0, 0.01, sea="v")]


def test_closing_line_of_a_run():
    assert closing_line(SWELL, "FSB") == (
        "mean power against the rigid FSB -9.6 % at optimal damping, +9.5 % at the given damping; "
    )
    assert closing_line([*SWELL, *CHOP], "FSB").startswith(
        "mean power against the rigid FSB -9.6 to +12.8 % at optimal"
    )
    assert closing_line(SWELL[:1], "FSB") == ""
    assert closing_line(SWELL, None) == ""
    even = closing_line([SWELL[0], line("A", 781.1, 0.0, 207.0, given_gain=0.0)], "FSB")
    known = [
        one | {"best_power_low": 0.99 * one["best_power"], "best_power_high": 1.02 * one["best_power"]} for one in SWELL
    ]
    known[1] |= {"best_low": -9.7, "best_high": -9.5}
    assert closing_line(known, "FSB") == (
        "mean power against the rigid FSB -9.6 % (-9.7 to -9.5 %) at optimal damping, +9.5 % at the given damping; "
        "FSB absorbs most, 781.1 (773.3 to 796.7) W at optimal damping; "
    )
    assert closing_line(known[:1], "FSB") == "FSB absorbs 781.1 (773.3 to 796.7) W at optimal damping; "
    assert even == "mean power against the rigid FSB +0.0 % at optimal damping, +0.0 % at the given damping; "


def test_closing_line_states_the_power_under_a_law_that_is_no_damper(seed):
    """That of the comparison, with its interval, each sea once; not that of the damper by linear theory."""
    waves = [{"kind": "jonswap", "hs": 1.0, "tp": 5.0, "realisations": 2}]
    study = varied(seed, pto={"law": "latching", "damping": 8e3}, waves=waves)
    labels = [wave.label for wave in study.waves]
    ends = {"low": -85.8, "high": -82.2, "power_low": 70.4, "power_high": 88.4}
    rows = [
        {"design": design, "wave": label, "power_mean": power, "power_gain_percent": gain, **ends}
        for label in labels for design, power, gain in [("FSB", 79.39, 0.0), ("VSWEC", 12.71, -84.0)]
    ]  # fmt: skip
    tuned = [line("FSB", 781.1, 0.0, sea=study.waves[0].family), line("VSWEC", 705.8, -9.64, sea=study.waves[0].family)]
    checks = [{"name": name, "verdict": verdict} for name, verdict in (("record_length", "fail"), ("drift", "doubt"))]
    assert answer_of_study(study, {"comparison": rows, "equal_tuning": tuned, "invalid": [], "checks": checks}) == (
        "mean power against the rigid FSB -9.6 % at optimal damping of a linear take-off, -84.0 % (-85.8 to -82.2 %) at "
        "the given damping, latching; FSB absorbs most, 79.39 (70.4 to 88.4) W at the given damping, latching; "
        "checks that fail: record length; "
    )


def test_words_of_a_law_may_name_keys_at_their_default(monkeypatch):
    """A canonical take-off leaves those out."""
    monkeypatch.setitem(LAWS, "coulomb", Law(words="{force_limit:g} {load_unit} {rate_unit} at {efficiency:g}"))
    assert damping_in_words({"law": "coulomb", "force_limit": 5.0}) == "With 5 N m/s at 1"


def test_causal_control_of_a_given_force_is_part_of_the_answer():
    """Gains over the rigid design with their intervals; without one, and without a common unit, powers or nothing."""
    line = {"sea": "s", "force_rms": 2000.0, "power": 100.0, "gain_percent": 0.0, "low": 0.0, "high": 0.0}
    other = line | {"design": "VSWEC", "power": 101.9, "gain_percent": 1.88, "low": 1.47, "high": 1.92}
    lines, seas = [line | {"design": "FSB"}, other], {"s": "a sea"}
    start = "In a sea, with causal control of 2000 N rms: VSWEC absorbs"
    (found,) = at_force_statements(lines, "FSB", seas, "N")
    assert found == f"{start} 1.9 % more than the rigid FSB (+1.5 to +1.9 %; 101.9 against 100 W)."
    (bare,) = at_force_statements([lines[0], lines[1] | {"low": None, "high": None}], "FSB", seas, "N")
    assert bare == f"{start} 1.9 % more than the rigid FSB (101.9 against 100 W)."
    (alone,) = at_force_statements(lines[1:], None, seas, "N")
    assert alone == f"{start} 101.9 W."
    assert at_force_statements([line | {"design": "FSB", "force_rms": None}], "FSB", seas, "N") == []


BUCKLING = {
    "name": "buckling",
    "design": "",
    "wave": "",
    "value": 66.4,
    "limit": 1.0,
    "verdict": "fail",
    "explanation": "<p> & why",
}
HEAVE = {
    "name": "heave",
    "design": "A",
    "wave": "w",
    "value": 0.4,
    "limit": 0.3,
    "verdict": "doubt",
    "explanation": "large",
}


def test_failed_checks_head_the_page():
    assert warnings([BUCKLING, HEAVE]) == [f"buckling: 66.4, limit 1 (<p> & why). Change first: {ADVICE['buckling']}"]
    (accepted,) = warnings([{**HEAVE, "verdict": "accepted"}])
    assert accepted.startswith("heave of A in w: 0.4, limit 0.3 (large)")
    assert warnings([{**HEAVE, "verdict": "ok"}]) == []


def test_what_was_tried_for_a_shell_replaces_general_advice():
    """A page that says "raise the pressure" of a wall that no pressure carries sends its reader in circles."""
    tried = {**BUCKLING, "advice": "no pressure carries this wall; from 90 mm it stands (tried)"}
    assert warnings([tried])[0].endswith(f"Change first: {tried['advice']}")
    both = no_answer([tried, {**tried, "name": "computed_buckling"}])
    assert both.endswith(f"Change first: {tried['advice']}."), "said once"


def test_a_reason_has_the_largest_of_its_values():
    (text,) = reasons([{"name": "strain", "value": value} for value in (0.11, 0.13, 0.12)])
    assert text.startswith("the strain reaches 13 %")


def test_advice_names_keys_that_exist():
    for name, text in ADVICE.items():
        for section, key in re.findall(r"\b([a-z]+)\.(\w+)", text):
            assert section in {**KEYS["Study"], **KEYS["BodyStudy"]}, name
            assert any(key in keys for keys in KEYS.values()), name
        assert "body_exact" not in ADVICE["linearity"], "a check of body-exact runs alone"
    assert all(how == "lower" for how in re.findall(r"(\w+) hydro\.\w*tolerance", text)), name
    assert {name for name, text in ADVICE.items() if "hydro.power_tolerance" in text} == {"left_out", "gain_error"}
    assert all(
        ("waves" in ADVICE[name]) or name == "surge" for name in ("pitch", "rotation", "translation", "latching_time")
    )


def test_every_check_has_advice():
    """Except one of round-off, and one of a matrix that is repaired."""
    files = (Path(__file__).parents[2] / "vsb").rglob("*.py")
    made = re.compile(r"\b(?:check_at_most|check_at_least|Check)\(\s*\"(\w+)\"")
    names = {name for path in files for name in made.findall(path.read_text(encoding="utf-8"))}
    assert {"spectrum_cut", "buckling", "heave"} <= names
    assert names - set(ADVICE) == {"constraint_drift", "hydrostatic_symmetry"}


def test_any_design_makes_a_frequency_useful_above_the_lowest():
    omega = np.array([0.2, 0.5, 1.0, 1.5, 2.0])
    power = [[100.0, 1.0, 100.0, 1.0, 4.9], [100.0, 1.0, 1.0, 5.1, 1.0]]
    absorbed = xr.DataArray(power, dims=("design", "omega"), coords={"omega": omega})
    assert (LOWEST, USEFUL_SHARE) == (0.3, 0.05)
    assert useful_band(absorbed).values.tolist() == [False, False, True, True, False]


NARROW = 3e-3
"""Half width of a resonance, a third of the step of a grid [rad/s]."""


def resonant(omega):
    """A rigid design of a broad hump, and one that absorbs 6.36 times as much at 1.0437 rad/s, 0.2 at 1.6181."""
    rigid = 50.0 / (1 + (omega - 1.3) ** 2)
    peak, dip = (1 / (1 + ((omega - at) / NARROW) ** 2) for at in (1.0437, 1.6181))
    values = [rigid, rigid * (1 + 6.36 * peak) * (1 - 0.8 * dip)]
    return xr.DataArray(values, dims=("design", "omega"), coords={"design": ["FSB", "A"], "omega": omega})


def test_extremes_between_grid_frequencies_are_found():
    """In closed form +636 % and -80 %; the grid itself shows less than half of the first."""
    omega = np.arange(0.5, 2.5, 0.01)
    found = resonant(with_extremes(resonant, omega, "FSB"))
    gain, coarse = (100 * (p.sel(design="A") / p.sel(design="FSB") - 1) for p in (found, resonant(omega)))
    assert float(coarse.max()) < 300
    assert (float(gain.max()), float(gain.min())) == pytest.approx((636.0, -80.0), abs=0.7)
    assert float(gain.idxmax("omega")) == pytest.approx(1.0437, abs=1e-4)
    assert set(omega) <= set(found.omega.values)
    assert found.sizes["omega"] < len(omega) + 120


def falling(omega):
    """A rigid design whose power ends, and a gain that grows until it does: exp(2 omega) - 1 over 1/(1 + exp)."""
    rigid = 1 / (1 + np.exp(40 * (omega - 1.0)))
    values = [rigid, rigid * np.exp(2 * omega)]
    return xr.DataArray(values, dims=("design", "omega"), coords={"design": ["FSB", "A"], "omega": omega})


def test_gain_at_the_end_of_its_band_is_found():
    omega = np.arange(0.3, 1.5, 0.037)
    power = falling(with_extremes(falling, omega, "FSB"))
    inside = power.omega.values[gain_band(power, "FSB").values]
    end = inside.max()
    fine = falling(np.linspace(end - 0.05, end + 0.05, 200001))
    best, rigid = fine.max("design"), fine.sel(design="FSB")
    ends = (best >= USEFUL_SHARE * power.max("design").max()) & ((rigid >= USEFUL_SHARE * 1.0) | (rigid >= 0.1 * best))
    exact = float(fine.omega.values[ends.values].max())
    assert np.exp(2 * end) == pytest.approx(np.exp(2 * exact), rel=2e-3)
