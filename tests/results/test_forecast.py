"""Causal controllers in seas that they are not tuned in."""

import numpy as np
import pytest
from models.test_stationary import PUBLISHED, example  # noqa: F401

from vsb.engine.motion.causal import RmsLimits, optimum
from vsb.engine.motion.controller import achieved
from vsb.models.floating_system import expected_sea
from vsb.models.stationary import stationary_ports
from vsb.results.forecast import elsewhere


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
