"""Whether the pause of a body-exact run was looked for far enough from that of its linear scene."""

import pytest

from vsb.results.pauses import pause_checks


def test_a_pause_at_the_border_of_what_was_tried_is_doubted():
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
    assert "a pause of 0.76 s on the wet shell, 1 s in the linear scene, tried 0.25 s either side" in far.explanation


def test_runs_without_a_pause_of_their_own_are_no_reason_to_leave_out_others():
    """Whatever their order; a pause shorter than that of the linear scene is as far as a longer one."""
    wet = {"linear_pause": 1.0, "pause_tried": 0.25}
    runs = {("C", "w"): {"pause": 1.0}, ("D", "v"): {**wet, "pause": 0.0}}
    runs |= {("A", w): {**wet, "pause": 1.0 + sign * 0.15} for w, sign in (("v", 1), ("w", -1))}
    found = pause_checks(runs)
    assert [(check.design, check.wave, check.verdict) for check in found] == [("A", "v", "ok"), ("A", "w", "ok")]
    assert [check.value for check in found] == pytest.approx([0.6, 0.6])
    assert found[0].explanation.startswith(
        "takes most with a pause of 1.15 s on the wet shell, 1 s in the linear scene"
    )
