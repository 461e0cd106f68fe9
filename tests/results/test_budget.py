"""Error budgets: how sources add up, and that a number lies in its interval."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.errors import VsbError
from vsb.results.budget import Budget, Source, mean_budget

SIZES = st.floats(0.0, 1e6)
SOURCES = st.builds(
    lambda low, high, kind: Source("s", -low, high, kind), SIZES, SIZES, st.sampled_from(["bound", "statistic"])
)


def test_bounds_add_linearly_and_statistics_in_quadrature():
    budget = Budget(
        (
            Source("coefficients", -1.0, 2.0),
            Source.towards("modes left out", -4.0),
            Source.within("runs", 3.0, "statistic"),
            Source.within("seas", 4.0, "statistic"),
        )
    )
    assert (budget.low, budget.high) == (-10.0, 7.0)  # 1 + 4 + 5 and 2 + 0 + 5
    assert budget.interval(50.0) == (40.0, 57.0)
    assert budget.scaled(2.0).interval(0.0) == (-20.0, 14.0)


@given(st.lists(SOURCES, max_size=6), st.floats(-1e6, 1e6))
def test_more_sources_never_narrow_the_interval(sources, value):
    budget = Budget(tuple(sources))
    low, high = budget.interval(value)
    assert low <= value <= high
    wider = budget + Budget((Source.within("more", 1.0, "statistic"),))
    assert wider.low <= budget.low
    assert wider.high >= budget.high
    assert Budget.of(json.loads(json.dumps(budget.rows))) == budget


@pytest.mark.parametrize("ends", [(0.1, 1.0), (-1.0, -0.1), (float("nan"), 0.0), (0.0, float("inf"))])
def test_source_that_excludes_zero_is_refused(ends):
    with pytest.raises(VsbError, match=r"error budget: x: received .* needs a finite range about zero"):
        Source("x", *ends)


def test_bounds_stay_and_statistics_average_over_realisations():
    one = Budget((Source.within("coefficients", 2.0), Source.within("runs", 4.0, "statistic")))
    four = mean_budget([one] * 4)
    assert [(source.low, source.high) for source in four.sources] == [(-2.0, 2.0), (-2.0, 2.0)]
    assert mean_budget([]) == Budget()
