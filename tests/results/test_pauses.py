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
