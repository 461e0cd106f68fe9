"""What a campaign may ask of a year: the tuning its answer is told at."""

import pytest

from vsb.study.year_options import leading_tuning


@pytest.mark.parametrize(
    ("tunings", "leading"),
    [
        (("fixed", "one", "each", "constrained"), "one"),
        (("constrained", "fixed", "each"), "each"),
        (("constrained", "fixed"), "fixed"),
        (("constrained",), "constrained"),
    ],
)
def test_a_campaign_is_answered_at_one_damper_of_the_year_if_it_has_it(tunings, leading):
    assert leading_tuning(tunings) == leading
