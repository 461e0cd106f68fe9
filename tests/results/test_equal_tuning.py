"""Designs compared at their own optimal damping."""

import pytest
from conftest import varied

from vsb.results.equal_tuning import equal_tuning, fair_damping_checks, reference_power_checks, within_limits
from vsb.results.ladder import Rung
from vsb.study.take_off import Pto

REGULAR = {"kind": "regular", "amplitude": 0.5, "period": 5.0}
NOISE = {"kind": "jonswap", "hs": 1.0, "tp": 5.0, "realisations": 2}
DAMPER = Pto(damping=8e3)


def rung(design, wave, name, damping, power):
    return Rung(design, wave, name, damping, 0.0, power, None, 0.0, 0.0, 0.0, None)


@pytest.fixture
def study(seed):
    return varied(seed, designs={"FSB": {"flexible": False}, "VSWEC": {}}, waves=[REGULAR, NOISE])


@pytest.fixture
def rungs(study):
    """Powers in the regular wave, and in two realisations of a sea."""
    best = {"FSB": (800.0, 100.0, 300.0), "VSWEC": (720.0, 150.0, 250.0)}
    fixed = {"FSB": (200.0, 96.0, 290.0), "VSWEC": (240.0, 140.0, 250.0)}
    rows = []
    for i, wave in enumerate(study.waves):
        for design in study.designs:
            rows.append(rung(design, wave.label, "fixed", 8000.0, fixed[design][i]))
            rows.append(rung(design, wave.label, "best_damper", 1e4 * (i + 1), best[design][i]))
            rows.append(rung(design, wave.label, "matched", None, 1e3))
    return rows


def test_gains_are_between_optimal_powers_of_all_realisations(study, rungs):
    rigid, shell, rigid_sea, shell_sea = equal_tuning(study, rungs)
    assert (rigid.best_gain_percent, rigid.share) == (0.0, 0.25)
    assert shell.best_gain_percent == pytest.approx(-10.0)
    assert shell.gain_percent == pytest.approx(20.0)
    assert rigid_sea.sea == study.waves[1].family
    assert (rigid_sea.best_power, rigid_sea.power, rigid_sea.best_damping) == (200.0, 193.0, 2.5e4)
    assert (shell_sea.best_gain_percent, shell_sea.damping) == (0.0, 8000.0)


def test_power_lost_at_the_given_damper_is_reported(study, rungs):
    checks = fair_damping_checks(equal_tuning(study, rungs), DAMPER)
    assert [(check.name, check.verdict) for check in checks] == [
        ("fair_damping", "doubt"), ("fair_damping", "doubt"), ("fair_damping", "ok"), ("fair_damping", "ok"),
    ]  # fmt: skip
    assert checks[0].value == 0.75


@pytest.mark.parametrize(("law", "count"), [("saturated", 4), ("latching", 0)])
def test_fair_damping_applies_to_dampers_only(study, rungs, law, count):
    pto = Pto(damping=8e3, law=law, force_limit=300.0)
    assert len(fair_damping_checks(equal_tuning(study, rungs), pto)) == count


def test_without_a_given_damper_nothing_is_lost(study, rungs):
    lines = equal_tuning(study, [rung for rung in rungs if rung.rung != "fixed"])
    assert {(line.power, line.gain_percent, line.share) for line in lines} == {(None, None, None)}
    assert fair_damping_checks(lines, DAMPER) == []


def test_constrained_optima_are_compared_where_known(study, rungs):
    swell, first, second = (wave.label for wave in study.waves)
    powers = {"FSB": (100.0, 50.0, 70.0), "VSWEC": (110.0, 66.0, 66.0)}
    best = [
        rung(design, wave, "constrained", None, power)
        for design, all_powers in powers.items()
        for wave, power in zip((swell, first, second), all_powers, strict=True)
    ]
    assert [(line.design, line.power, line.gain_percent) for line in within_limits(study, rungs + best)] == [
        ("FSB", 100.0, 0.0), ("VSWEC", 110.0, pytest.approx(10.0)), ("FSB", 60.0, 0.0), ("VSWEC", 66.0, pytest.approx(10.0)),
    ]  # fmt: skip
    unknown = [one._replace(power_mean=None) if (one.design, one.wave) == ("FSB", second) else one for one in best]
    assert [(line.design, line.gain_percent) for line in within_limits(study, unknown)][2:] == [("VSWEC", None)]
    assert within_limits(study, rungs) == []


def test_gain_over_a_negligible_reference_power_is_in_doubt(study, rungs):
    swell, sea = reference_power_checks(study, rungs)
    assert (swell.value, sea.value) == (1e3 / 800.0, 1e3 / 200.0)
    assert {swell.verdict, sea.verdict} == {"ok"}
    assert (swell.wave, sea.wave) == (study.waves[0].label, study.waves[1].family)
    weak = [row._replace(power_mean=0.5) if row.rung == "best_damper" else row for row in rungs]
    first, _ = reference_power_checks(study, weak)
    assert first.verdict == "doubt"
    assert reference_power_checks(varied(study, designs={"A": {}, "B": {}}), rungs) == []
