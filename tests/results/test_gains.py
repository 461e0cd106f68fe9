"""Gains at equal tuning, within limits and in runs, and the budgets of their errors."""

import json

import numpy as np
import pytest
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st
from models.test_stationary import PUBLISHED, example  # noqa: F401

from vsb.engine.motion.causal import RmsLimits, optimum
from vsb.engine.motion.controller import achieved
from vsb.engine.motion.take_off import Pto
from vsb.errors import VsbError
from vsb.models.floating_system import expected_sea
from vsb.models.stationary import stationary_ports
from vsb.results.budget import Budget, Source, mean_budget
from vsb.results.gains import elsewhere, equal_tuning, fair_damping_checks, reference_power_checks, within_limits
from vsb.results.ladder import ControlLevel

REGULAR = {"kind": "regular", "amplitude": 0.5, "period": 5.0}
NOISE = {"kind": "jonswap", "hs": 1.0, "tp": 5.0, "realisations": 2}
SIZES = st.floats(0.0, 1e6)
SOURCES = st.builds(
    lambda low, high, kind: Source("s", -low, high, kind), SIZES, SIZES, st.sampled_from(["bound", "statistic"])
)

# budgets ------------------------------------------------------------------------------------------------------------


def test_bounds_add_linearly_and_statistics_in_quadrature():
    sources = [Source("coefficients", -1.0, 2.0), Source.towards("modes left out", -4.0)]
    sources += [Source.within("runs", 3.0, "statistic"), Source.within("seas", 4.0, "statistic")]
    budget = Budget(tuple(sources))
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


def test_bounds_stay_and_statistics_average_over_realisations():
    one = Budget((Source.within("coefficients", 2.0), Source.within("runs", 4.0, "statistic")))
    four = mean_budget([one] * 4)
    assert [(source.low, source.high) for source in four.sources] == [(-2.0, 2.0), (-2.0, 2.0)]
    for ends in ((0.1, 1.0), (-1.0, -0.1), (float("nan"), 0.0), (0.0, float("inf"))):
        with pytest.raises(VsbError, match=r"error budget: x: received .* needs a finite range about zero"):
            Source("x", *ends)


# equal tuning -------------------------------------------------------------------------------------------------------


def level(design, wave, name, damping, power):
    return ControlLevel(design, wave, name, damping, 0.0, power, None, 0.0, 0.0, 0.0, None)


@pytest.fixture
def seas(seed):
    return varied(seed, designs={"FSB": {"flexible": False}, "VSWEC": {}}, waves=[REGULAR, NOISE])


@pytest.fixture
def levels(seas):
    """Powers in the regular wave, and in two realisations of a sea."""
    best = {"FSB": (800.0, 100.0, 300.0), "VSWEC": (720.0, 150.0, 250.0)}
    fixed = {"FSB": (200.0, 96.0, 290.0), "VSWEC": (240.0, 140.0, 250.0)}
    rows = []
    for i, wave in enumerate(seas.waves):
        for design in seas.designs:
            rows.append(level(design, wave.label, "fixed", 8000.0, fixed[design][i]))
            rows.append(level(design, wave.label, "best_damper", 1e4 * (i + 1), best[design][i]))
            rows.append(level(design, wave.label, "matched", None, 1e3))
    return rows


def test_share_of_a_number_below_zero_is_a_range_about_zero():
    """As of a power that losses in conversion make negative."""
    assert Source.within("coefficients", -0.1 * 9.0) == Source("coefficients", -0.9, 0.9)


def test_gains_are_between_optimal_powers_of_all_realisations(seas, levels):
    rigid, shell, rigid_sea, shell_sea = equal_tuning(seas, levels)
    assert (rigid.best_gain_percent, rigid.share) == (0.0, 0.25)
    assert (shell.best_gain_percent, shell.gain_percent) == (pytest.approx(-10.0), pytest.approx(20.0))
    assert rigid_sea.sea == seas.waves[1].family
    assert (rigid_sea.best_power, rigid_sea.power, rigid_sea.best_damping) == (200.0, 193.0, 2.5e4)
    assert (shell_sea.best_gain_percent, shell_sea.damping) == (0.0, 8000.0)
    tuned = equal_tuning(seas, [level for level in levels if level.rung != "fixed"])
    assert {(line.power, line.gain_percent, line.share) for line in tuned} == {(None, None, None)}


def test_nothing_is_stated_at_the_given_damper_under_a_law_that_is_no_damper(seas, levels):
    """A buoy that latches does not absorb what linear theory has of its damper."""
    latching = varied(seas, pto={"law": "latching", "damping": 8e3})
    assert {(line.power, line.gain_percent, line.share) for line in equal_tuning(latching, levels)} == {(None,) * 3}
    assert [line.best_power for line in equal_tuning(latching, levels)] == [800.0, 720.0, 200.0, 200.0]


def test_power_lost_at_the_given_damper_is_reported(seas, levels):
    """Of dampers, not of take-offs that latch."""
    lines = equal_tuning(seas, levels)
    checks = fair_damping_checks(lines, Pto(damping=8e3))
    assert [check.verdict for check in checks] == ["doubt", "doubt", "ok", "ok"]
    assert checks[0].value == 0.75
    assert fair_damping_checks(lines, Pto(damping=8e3, law="latching", force_limit=300.0)) == []


def test_constrained_optima_are_compared_where_known(seas, levels):
    swell, first, second = (wave.label for wave in seas.waves)
    powers = {"FSB": (100.0, 50.0, 70.0), "VSWEC": (110.0, 66.0, 66.0)}
    best = [
        level(design, wave, "constrained", None, power)
        for design, all_powers in powers.items()
        for wave, power in zip((swell, first, second), all_powers, strict=True)
    ]
    assert [(line.design, line.power, line.gain_percent) for line in within_limits(seas, levels + best)] == [
        ("FSB", 100.0, 0.0), ("VSWEC", 110.0, pytest.approx(10.0)), ("FSB", 60.0, 0.0), ("VSWEC", 66.0, pytest.approx(10.0)),
    ]  # fmt: skip
    unknown = [one._replace(power_mean=None) if (one.design, one.wave) == ("FSB", second) else one for one in best]
    assert [(line.design, line.gain_percent) for line in within_limits(seas, unknown)][2:] == [("VSWEC", None)]


def test_gain_over_a_negligible_reference_power_is_in_doubt(seas, levels):
    swell, sea = reference_power_checks(seas, levels)
    assert (swell.value, sea.value) == (1e3 / 800.0, 1e3 / 200.0)
    assert (swell.wave, sea.wave, sea.verdict) == (seas.waves[0].label, seas.waves[1].family, "ok")
    weak = [row._replace(power_mean=0.5) if row.rung == "best_damper" else row for row in levels]
    assert reference_power_checks(seas, weak)[0].verdict == "doubt"
    assert reference_power_checks(varied(seas, designs={"A": {}, "B": {}}), levels) == []


def test_a_controller_loses_nothing_at_home_and_its_objective_elsewhere(example):  # noqa: F811
    """What either pays for its force counted, none is better than the one that is tuned there."""
    study, floating = example
    (wave,) = (wave for wave in study.waves if wave.tp == 5.0)
    limited = study.model_copy(update={"pto": type(study.pto)(force_limit=1284.4)})
    lines = {(line.design, round(line.period / 5.0, 2)): line for line in elsewhere(limited, floating, [wave])}
    assert len(lines) == 10
    home = lines["FSB", 1.0]
    assert home.power == pytest.approx(PUBLISHED[5.0][1284.4][0], rel=5e-3)
    assert (home.power, home.force_rms) == (home.own_power, home.own_force_rms)
    assert home.force_rms == pytest.approx(1284.4, rel=1e-6)
    there = wave.model_copy(update={"tp": 6.0})
    port = stationary_ports(floating, there, expected_sea(study, there, floating.linear.database))["FSB"]
    best, line = optimum(port, RmsLimits(1284.4)), lines["FSB", 1.2]
    price = best.weights.force
    assert line.own_power == pytest.approx(best.power, rel=1e-3)
    assert line.power - price * line.force_rms**2 < line.own_power - price * line.own_force_rms**2
    doubled = achieved(port, 2 * port.controller(best.weights))
    assert doubled[0] - price * doubled[1] ** 2 < line.own_power - price * line.own_force_rms**2
    assert np.isfinite([list(one[2:]) for one in lines.values()]).all()
