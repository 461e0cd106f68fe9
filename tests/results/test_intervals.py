"""Intervals of gains in time, and the error of linear theory found by runs in time."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.results.budget import Budget, Source
from vsb.results.intervals import linearisation, with_intervals
from vsb.results.ladder import Rung
from vsb.results.statistics import Line

OMEGA = 2 * np.pi / 5.0


@pytest.fixture
def study(seed):
    waves = [{"kind": "regular", "amplitude": 0.5, "period": 5.0}]
    return varied(seed, designs={"FSB": {"flexible": False}, "A": {}}, waves=waves)


@pytest.fixture
def frequency():
    """100 W of the rigid design, 80 W of the other in waves of 0.5 m."""
    dims, at = ("design", "omega"), {"design": ["FSB", "A"], "omega": [OMEGA]}
    return xr.Dataset({"absorbed_power": (dims, [[400.0], [320.0]])}, at)


def rows(study, powers):
    label = study.waves[0].label
    base = powers["FSB"]
    return [
        {"design": d, "wave": label, "power_mean": p, "power_gain_percent": 100 * (p / base - 1)}
        for d, p in powers.items()
    ]


def runs(study, model, **more):
    return {(d, study.waves[0].label): {"model": model, "energy_residual": 1e-9, **more} for d in study.designs}


def ladder(study, *sources):
    label, gain = study.waves[0].label, Budget(sources).rows
    numbers = (8e3, 0.0, 80.0, None, 0.0, 0.0, 0.0, None)
    return [
        Rung("FSB", label, "fixed", *numbers), Rung("A", label, "fixed", *numbers)._replace(gain_error=gain),
        Rung("A", label, "best_damper", *numbers)._replace(gain_error=Budget((Source.within("c", 99.0),)).rows),
    ]  # fmt: skip


def test_interval_of_a_gain_adds_the_errors_of_both_runs(study, frequency):
    """Runs that differ by 1 % and 2 % from the frequency domain: 3 % of the ratio."""
    found = with_intervals(
        study, rows(study, {"FSB": 101.0, "A": 81.6}), runs(study, "linear"),
        ladder(study, Source.within("coefficients", 0.5), Source("modes left out", -3.0, 0.0)), frequency,
    )  # fmt: skip
    rigid, shell = found
    assert (rigid["low"], rigid["high"]) == (0.0, 0.0)
    gain = shell["power_gain_percent"]
    assert gain - shell["low"] == pytest.approx(3.5 + 0.03 * (100 + gain))
    assert shell["high"] - gain == pytest.approx(0.5 + 0.03 * (100 + gain))


def test_interval_of_a_nonlinear_run_includes_its_energy_residual(study, frequency):
    attrs = runs(study, "body_exact", power_error=0.01)
    attrs["A", study.waves[0].label]["energy_residual"] = 0.02
    _, shell = with_intervals(study, rows(study, {"FSB": 100.0, "A": 60.0}), attrs, ladder(study), frequency)
    assert shell["high"] - shell["power_gain_percent"] == pytest.approx((0.02 + 0.02) * 60, rel=1e-6)


def test_linearisation_error_is_one_sided(study, frequency):
    """-20 % by linear theory, -40 % in time at the same damper."""
    said = linearisation(study, rows(study, {"FSB": 100.0, "A": 60.0}), runs(study, "body_exact"), frequency, [])
    (key,) = said
    assert key == ("A", study.waves[0].label)
    assert (said[key].low, said[key].high) == (pytest.approx(-20.0), 0.0)
    assert linearisation(study, rows(study, {"FSB": 100.0, "A": 60.0}), runs(study, "linear"), frequency, []) == {}


def test_linearisation_error_in_irregular_seas_includes_the_sampling_error(study, frequency):
    """For random amplitudes only; linear theory is that in the same waves."""
    lines = [
        Line("FSB", "noise", "random", 4, 40, 100.0, 95.0, 105.0, 90.0, 100.0, None, None, None),
        Line("A", "noise", "random", 4, 40, 60.0, 55.0, 65.0, 50.0, 80.0, -40.0, -43.0, -37.0),
    ]
    for amplitudes, half in (("random", 3.0), ("fixed", 0.0)):
        drawn = [line._replace(amplitudes=amplitudes) for line in lines]
        said = linearisation(study, rows(study, {"FSB": 100.0, "A": 80.0}), runs(study, "body_exact"), frequency, drawn)
        assert said["A", "noise"].low == pytest.approx(-20.0 - half)
        assert said["A", "noise"].high == pytest.approx(half)
