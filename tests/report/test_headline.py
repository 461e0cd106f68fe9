"""The two sentences that answer a study."""

import numpy as np
import xarray as xr

from vsb.report.headline import headline as answered
from vsb.report.headline import interval_text

OMEGA = np.linspace(0.5, 4.0, 351)
SEAS = {"w": "a swell", "v": "a chop"}


def line(design, gain, sea="w", power=100.0, width=None):
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


def test_waves_in_which_the_rigid_design_absorbs_almost_nothing_are_left_out():
    """At a node of the rigid port's motion any gain is meaningless."""
    powers = best_power(A=0.2 + 0 * OMEGA)
    powers.loc["FSB"] *= 1 - 0.999999 * np.exp(-(((OMEGA - 2.5) / 0.05) ** 2))
    _, second = headline([line("FSB", 0.0), line("A", 20.0)], powers, "FSB", SEAS)
    assert second.startswith(
        "Over all waves that carry power but those of which the rigid design absorbs next to nothing, tuned wave"
    )
    assert "times as much" not in second
    powers.loc["FSB"] = best_power().sel(design="FSB") + 30 * np.exp(-(((OMEGA - 0.6) / 0.01) ** 2))
    _, second = headline([line("FSB", 0.0), line("A", 20.0)], powers, "FSB", SEAS)
    assert second.startswith("Over all waves that carry power, tuned"), "a twentieth of a peak is not nothing"
    powers.loc["FSB"] = 0.9 * best_power().sel(design="FSB")
    powers.loc["FSB"][np.argmin(np.abs(OMEGA - 0.6))] = 20.0  # with which useful is what exceeds 1, as 1.2 does at 2.0
    _, second = headline([line("FSB", 0.0), line("A", 20.0)], powers, "FSB", SEAS)
    assert second.startswith("Over all waves that carry power, tuned"), "nor are nine tenths of what the other takes"


def test_best_design_with_interval_and_band():
    gain = 0.2 - 0.1 * np.abs(OMEGA - 2.0)
    first, second = headline([line("FSB", 0.0), line("A", 20.0, width=0.2)], best_power(A=gain), "FSB", SEAS)
    assert first == (
        "In a swell, each design at its own optimal damper, A absorbs 20.0 % more than the rigid FSB (+19.8 to +20.2 % "
        "with all known errors; 120 against 100 W)."
    )
    assert (
        second == "Over all waves that carry power, tuned wave by wave, A absorbs up to 20 % more (in waves of 3.14 s)."
    )


def test_most_favourable_sea_and_largest_loss():
    lines = [
        line("FSB", 0.0),
        line("A", -20.0),
        line("B", -5.0),
        line("FSB", 0.0, "v"),
        line("A", 3.0, "v"),
        line("B", 0.0, "v"),
    ]
    first, second = headline(lines, best_power(A=-0.2, B=0.04), "FSB", SEAS)
    assert first.startswith(
        "In a chop, the most favourable of 2 seas, each design at its own optimal damper, the best flexible"
    )
    assert "design, A, absorbs 3.0 % more" in first
    assert first.endswith("flexibility pays in 1 of the 2, and costs up to 20.0 %.")
    assert "flexible designs absorb up to 4 % more (B in" in second
    assert "up to 20 % less (A in" in second


def test_no_gain_without_a_rigid_design_or_power():
    assert headline([line("A", None)], best_power(A=0.1), None, SEAS) == []
    assert headline([line("FSB", 0.0), line("A", None)], best_power(A=0.1), "FSB", SEAS) == []
    (only,) = headline([line("FSB", 0.0), line("A", 0.0)], 0 * best_power(A=0.1), "FSB", SEAS)
    assert "as much as the rigid FSB" in only


def test_powers_are_those_of_the_most_favourable_sea():
    seas = [("w", 100.0, 3.0), ("v", 40.0, 5.0)]
    for order in (seas, seas[::-1]):
        lines = [
            one
            for sea, power, gain in order
            for one in (line("FSB", 0.0, sea, power), line("A", gain, sea, power, 0.4))
        ]
        first, *_ = headline(lines, best_power(A=0 * OMEGA), "FSB", SEAS)
        assert first.startswith("In a chop, the most favourable of 2 seas")
        assert "(+4.6 to +5.4 % with all known errors; 42 against 40 W)" in first
        assert first.endswith("; 42 against 40 W).")


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
    lines = [line("FSB", 0.0), line("A", 5.0), line("B", 2.0)]
    lines += [line("FSB", 0.0, "v"), line("A", 50.0, "v"), line("B", 3.0, "v")]
    invalid = [{"design": "A", "sea": "v", **STRAINED}]
    found = answered(lines, best_power(A=0 * OMEGA, B=0 * OMEGA), "FSB", SEAS, invalid)
    assert found.stands[0].startswith("In a swell, the most favourable of 2 seas,")
    assert "the best flexible design, A, absorbs 5.0 % more" in found.stands[0]
    assert found.below == [
        "Not valid, and no part of this answer: A in a chop, computed to absorb 50.0 % more than the rigid FSB; "
        "the shell is strained by up to 12 %, and Hooke's law ends at 10 %."
    ]


def test_number_of_an_invalid_design_stands_below_the_answer():
    lines = [line("FSB", 0.0), line("A", 5.0, width=1.0)]
    invalid = [{"design": "A", "sea": "w", **BUCKLED}, {"design": "A", "sea": "w", **BUCKLED, "name": "buckling"}]
    found = answered(lines, best_power(A=0.1 + 0 * OMEGA), "FSB", SEAS, invalid)
    assert found.stands == [
        "No valid answer yet: the shell buckles under its static load (53.6 times what it can carry). Change first: "
        "raise device.internal_pressure to carry the load, or device.thickness."
    ]
    (below,) = found.below
    assert below.startswith("What was computed, although the model does not hold: In a swell, each design at its own")
    assert "A absorbs 5.0 % more than the rigid FSB (+4.0 to +6.0 % with all known errors; 105 against 100 W)" in below


def test_no_gain_over_an_invalid_rigid_design():
    invalid = [{"design": "FSB", "sea": "w", "name": "energy_residual", "value": 0.5, "limit": 1e-6}]
    (first,) = answered([line("FSB", 0.0), line("A", 5.0)], best_power(A=0 * OMEGA), "FSB", SEAS, invalid).stands
    assert first.startswith("No valid answer yet: the energy balance of the simulation does not close (residual 0.5).")
