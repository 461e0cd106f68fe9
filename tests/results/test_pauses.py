"""A pause of a linear scene is judged where it is used: on the wet shell."""

import pytest

from vsb.results.pauses import pause_checks


def test_a_pause_of_the_linear_scene_is_judged_on_the_wet_shell():
    runs = {
        ("A", "w"): {"model": "body_exact", "pause": 1.08, "pause_power": 864.0},
        ("B", "w"): {"model": "body_exact", "pause": 1.08, "pause_power": 830.0},
        ("C", "w"): {"model": "linear", "pause": 1.08, "pause_power": 830.0},
        ("D", "w"): {"model": "body_exact", "pause": 0.0, "pause_power": 0.0},
        ("E", "w"): {"model": "body_exact"},
    }
    powers = (860.0, 319.0, 1.0, 1.0, 1.0)
    rows = [{"design": d, "wave": "w", "power_mean": p} for d, p in zip("ABCDE", powers, strict=True)]
    rigid, shell = pause_checks(runs, rows)
    assert (rigid.verdict, shell.verdict) == ("ok", "fail")
    assert shell.value == pytest.approx(1 - 319 / 830)
    assert "319 W body-exact, 830 W in the linear scene its pause of 1.08 s" in shell.explanation
