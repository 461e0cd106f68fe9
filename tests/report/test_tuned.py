"""Statements and tables of designs at their own optimal damping."""

import pytest

from vsb.report.page import sea_statements
from vsb.report.tuned import (
    closing_line,
    dampers_in_words,
    limited_statements,
    shares_text,
    tuned_statements,
    tuning_head,
    tuning_table,
)

SEAS = {"w": "a swell", "v": "a chop"}


def line(design, power, gain, given=None, sea="w", share=None, given_gain=None):
    return {
        "design": design, "sea": sea, "best_damping": 64282.0, "best_power": power, "best_gain_percent": gain,
        "damping": None if given is None else 8000.0, "power": given, "gain_percent": given_gain, "share": share,
    }  # fmt: skip


SWELL = [line("FSB", 781.1, 0.0, 207.0, share=0.265, given_gain=0.0), line("A", 705.8, -9.64, 227.0, "w", 0.322, 9.5)]
CHOP = [line("FSB", 100.0, 0.0, sea="v"), line("A", 112.8, 12.8, sea="v"), line("B", 100.0, 0.01, sea="v")]


def test_answer_is_the_gain_at_own_optimal_damping():
    assert tuned_statements([*SWELL, *CHOP], "FSB", SEAS) == [
        "In a swell, each design at its own best damper: A absorbs 9.6 % less than the rigid FSB (705.8 against 781.1 W).",
        "In a chop, each design at its own best damper: A absorbs 12.8 % more than the rigid FSB (112.8 against 100 W); "
        "B absorbs as much as the rigid FSB (100 against 100 W).",
    ]


def test_share_of_the_optimum_at_the_given_damping():
    assert shares_text(SWELL, "w", "N s/m") == "; at 8000 N s/m FSB reaches 26 % of its own best, A 32 %"
    assert shares_text(CHOP, "v", "N s/m") == ""
    own = [SWELL[0], SWELL[1] | {"damping": 6000.0}, SWELL[1] | {"design": "B", "damping": 8000.0}]
    assert shares_text(own, "w", "N s/m").startswith(
        "; at 8000 N s/m and 6000 N s/m FSB reaches 26 % of its own best, A 32 %, B 32 %"
    )
    chop = [line("FSB", 4.0, 0.0, 1.0, sea="v", share=0.5), line("A", 4.0, 1.0, 1.0, sea="v", share=0.6)]
    assert shares_text([*chop, *SWELL], "w", "N s/m") == shares_text(SWELL, "w", "N s/m")
    rows = [{"design": "FSB", "wave": "w", "power_mean": 207.0}, {"design": "A", "wave": "w", "power_mean": 226.7}]
    assert sea_statements(rows, "FSB", SEAS, SWELL) == [
        "At the given damper, in a swell, A absorbs most: 226.7 W on average (against FSB: A +9.5 %); "
        "at 8000 N s/m FSB reaches 26 % of its own best, A 32 %."
    ]


def test_closing_line_of_a_run():
    assert closing_line(SWELL, "FSB") == (
        "mean power against the rigid FSB -9.6 % at own best dampers, +9.5 % at the given damper; "
    )
    assert closing_line([*SWELL, *CHOP], "FSB").startswith("mean power against the rigid FSB -9.6 to +12.8 % at own")
    assert closing_line(SWELL[:1], "FSB") == ""
    assert closing_line(SWELL, None) == ""
    even = closing_line([SWELL[0], line("A", 781.1, 0.0, 207.0, given_gain=0.0)], "FSB")
    assert even == "mean power against the rigid FSB +0.0 % at own best dampers, +0.0 % at the given damper; "


def test_closing_line_counts_valid_designs_only():
    buckled = {"name": "buckling", "value": 66.0, "limit": 1.0}
    a, b = ({"design": name, "sea": "v", **buckled} for name in ("A", "B"))
    assert closing_line(CHOP, "FSB", [a]) == "mean power against the rigid FSB +0.0 % at own best dampers; "
    assert closing_line(CHOP, "FSB", [a, b]).startswith("No valid answer yet: the shell buckles under its static load")


def test_table_of_optimal_damping():
    first, second = tuning_table([SWELL[1], CHOP[0]])
    assert first == ["A", "w", "64280", "705.8", "-9.6", "-", "8000", "227", "+9.5", "-", "32.2"]
    assert second == ["FSB", "v", "64280", "100", "+0.0", "-", "-", "-", "-", "-", "-"]
    (known,) = tuning_table([SWELL[1] | {"best_low": -9.7, "best_high": -9.5, "low": 9.0, "high": 10.0}])
    assert (known[5], known[9]) == ("-9.7 to -9.5 %", "+9.0 to +10.0 %")
    assert len(first) == len(tuning_head("N s/m"))


def test_power_within_limits():
    lines = [
        {"design": "FSB", "sea": "w", "power": 100.0, "gain_percent": 0.0},
        {"design": "A", "sea": "w", "power": 112.3, "gain_percent": 12.3},
        {"design": "A", "sea": "v", "power": 5.0, "gain_percent": None},
    ]
    assert limited_statements(lines, "FSB", {"w": "a swell", "v": "a chop"}) == [
        "In a swell, no take-off within its limits absorbs more than: FSB 100 W, A 112.3 W (+12.3 %).",
        "In a chop, no take-off within its limits absorbs more than: A 5 W.",
    ]


@pytest.mark.parametrize(
    ("pto", "words"),
    [
        ({"damping": 1.0}, "At the given damper"),
        ({"damping": {"A": 1.0}}, "At the given dampers"),
        ({"tuning": "each"}, "In time, at their own best dampers"),
        ({"tuning": "one", "damping": {"A": 1.0}}, "In time, at their best for all seas"),
        ({"tuning": "each", "law": "latching"}, "In time, latching, with the damper that suits it"),
        ({"damping": 1.0, "law": "declutching"}, "At the given damper, declutching"),
    ],
)
def test_damping_of_runs_is_named(pto, words):
    assert dampers_in_words(pto) == words
