import pytest
from conftest import varied

from vsb.results.equal_tuning import equal_tuning, fair_damping_checks, reference_power_checks, within_limits
from vsb.results.ladder import Rung
from vsb.study.study import Jonswap
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


def test_gains_are_between_best_powers_realisations_together(study, rungs):
    rigid, shell, rigid_sea, shell_sea = equal_tuning(study, rungs)
    assert (rigid.best_gain_percent, rigid.share) == (0.0, 0.25)
    assert shell.best_gain_percent == pytest.approx(-10.0)
    assert shell.gain_percent == pytest.approx(20.0)
    assert rigid_sea.sea == study.waves[1].family
    assert (rigid_sea.best_power, rigid_sea.power, rigid_sea.best_damping) == (200.0, 193.0, 2.5e4)
    assert (shell_sea.best_gain_percent, shell_sea.damping) == (0.0, 8000.0)


def test_power_lost_at_the_given_damper_is_doubted_above_five_per_cent(study, rungs):
    checks = fair_damping_checks(equal_tuning(study, rungs), DAMPER)
    assert [(check.name, check.verdict) for check in checks] == [
        ("fair_damping", "doubt"), ("fair_damping", "doubt"), ("fair_damping", "ok"), ("fair_damping", "ok"),
    ]  # fmt: skip
    assert checks[0].value == 0.75
    assert checks[0].explanation == (
        "power lost against the own best damper: 200 W at 8000 N s/m, 800 W at 10000 N s/m, by linear theory"
    )


@pytest.mark.parametrize(("law", "count"), [("saturated", 4), ("coulomb", 0), ("latching", 0), ("declutching", 0)])
def test_a_law_whose_power_is_not_that_of_a_damper_is_not_judged_by_one(study, rungs, law, count):
    pto = Pto(damping=8e3, law=law, force_limit=300.0)
    assert len(fair_damping_checks(equal_tuning(study, rungs), pto)) == count


@pytest.mark.parametrize(("share", "verdict"), [(1.001, "ok"), (0.951, "ok"), (0.949, "doubt"), (0.0, "doubt")])
def test_five_per_cent_lost_is_the_limit(study, rungs, share, verdict):
    line = equal_tuning(study, rungs)[0]._replace(share=share)
    (check,) = fair_damping_checks([line], DAMPER)
    assert (check.verdict, check.limit) == (verdict, 0.05)
    assert check.value == pytest.approx(max(0.0, 1 - share))


def test_power_lost_is_said_in_the_unit_of_the_damper(study, rungs):
    first, *_ = fair_damping_checks(equal_tuning(study, rungs), Pto(damping=8e3, port="volume"))
    assert "200 W at 8000 Pa s/m³, 800 W at 10000 Pa s/m³" in first.explanation


def test_where_no_damper_is_given_nothing_is_lost(study, rungs):
    lines = equal_tuning(study, [rung for rung in rungs if rung.rung != "fixed"])
    assert {(line.power, line.gain_percent, line.share) for line in lines} == {(None, None, None)}
    assert fair_damping_checks(lines, DAMPER) == []


def test_optima_under_limits_stand_side_by_side_where_they_are_known(study, rungs):
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


def test_a_gain_over_next_to_nothing_is_doubted_by_sea_and_without_a_rigid_design_none_is(study, rungs):
    swell, sea = reference_power_checks(study, rungs)
    assert (swell.value, sea.value) == (1e3 / 800.0, 1e3 / 200.0)
    assert {swell.verdict, sea.verdict} == {"ok"}
    assert (swell.wave, sea.wave) == (study.waves[0].label, study.waves[1].family)
    weak = [row._replace(power_mean=0.5) if row.rung == "best_damper" else row for row in rungs]
    first, _ = reference_power_checks(study, weak)
    assert first.verdict == "doubt"
    assert first.explanation.startswith("1000 W within reach of FSB over 0.5 W at its best damper")
    assert reference_power_checks(varied(study, designs={"A": {}, "B": {}}), rungs) == []


def test_thousands_of_realisations_are_named_once_each_not_once_for_every_rung(study, rungs, monkeypatch):
    """The squares of thousands took longer than reading all runs."""
    named = []
    family = Jonswap.family.fget
    monkeypatch.setattr(Jonswap, "family", property(lambda sea: named.append(sea.seed) or family(sea)))
    labels = [wave.label for wave in study.waves if isinstance(wave, Jonswap)]
    named.clear()
    equal_tuning(study, rungs)
    within_limits(study, [rung(each.design, each.wave, "constrained", None, 1.0) for each in rungs])
    assert len(named) <= 4 * len(labels)  # two tables, each by label and family


@pytest.mark.parametrize("dead", [{"matched"}, {"best_damper"}, {"matched", "best_damper"}])
def test_a_sea_that_gives_the_rigid_design_nothing_has_no_share_to_judge(study, rungs, dead):
    """No quotient of nothing, nor over nothing: such a sea is left out, the other is not."""
    swell = study.waves[0]
    changed = [row._replace(power_mean=0.0) if row.rung in dead and row.wave != swell.label else row for row in rungs]
    assert [check.wave for check in reference_power_checks(study, changed)] == [swell.label]


def test_an_optimum_of_nothing_is_shown_and_one_that_is_not_known_is_not(study, rungs):
    """A port that waves do not move takes 0 W for sure; gains over that are none."""
    swell = study.waves[0].label
    best = [rung("FSB", swell, "constrained", None, 0.0), rung("VSWEC", swell, "constrained", None, 110.0)]
    found = within_limits(study, rungs + best)
    assert [tuple(line)[:4] for line in found] == [("FSB", swell, 0.0, None), ("VSWEC", swell, 110.0, None)]
    found = within_limits(study, [*rungs, best[0]._replace(power_mean=None), best[1]])
    assert [tuple(line)[:4] for line in found] == [("VSWEC", swell, 110.0, None)]


def test_realisations_in_which_nothing_is_taken_count_in_the_mean_with_their_dampers(study, rungs):
    """0 W and 300 W are 150 W, at dampers of 0 and of 30 kN s/m 15; a damper of a port that cannot move is none."""
    _, first, second = (wave.label for wave in study.waves)

    def changed(one):
        if one.rung == "best_damper" and one.design == "FSB" and one.wave == first:
            return one._replace(power_mean=0.0, damping=0.0)
        return one

    *_, rigid, _ = equal_tuning(study, [changed(one) for one in rungs])
    assert (rigid.design, rigid.sea) == ("FSB", study.waves[1].family)
    assert (rigid.best_power, rigid.best_damping) == (150.0, 1.5e4)
    still = [one._replace(damping=None, power_mean=0.0) if one.design == "FSB" else one for one in rungs]
    *_, rigid, shell = equal_tuning(study, still)
    assert (rigid.best_power, rigid.best_damping, rigid.damping, rigid.share) == (0.0, None, None, None)
    assert (shell.best_gain_percent, shell.gain_percent) == (None, None)
    assert {check.design for check in fair_damping_checks(equal_tuning(study, still), DAMPER)} == {"VSWEC"}
    assert second != first


def test_all_that_is_lost_is_told_of_its_own_sea(study, rungs):
    """A given damper that takes nothing: no line is left out, and every one names its design and its sea."""
    dead = [one._replace(power_mean=0.0) if one.rung == "fixed" else one for one in rungs]
    checks = fair_damping_checks(equal_tuning(study, dead), DAMPER)
    seas = (study.waves[0].label, study.waves[1].family)
    assert [(one.design, one.wave, one.value) for one in checks] == [
        (design, sea, 1.0) for sea in seas for design in study.designs
    ]


def test_a_best_damper_that_takes_all_there_is_leaves_nothing_to_gain_in_its_sea(study, rungs):
    """Of a wave at resonance: a share of one, which is told as any other is."""
    matched = [row._replace(power_mean=800.0) if row.rung == "matched" else row for row in rungs]
    found = reference_power_checks(study, matched)
    assert [(check.value, check.verdict) for check in found] == [(1.0, "ok"), (4.0, "ok")]
