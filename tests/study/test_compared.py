"""What studies of buoys and of bodies have in common."""

import pytest

from vsb.errors import ConfigError
from vsb.study.body import BodyStudy
from vsb.study.reading import validated

BODY = {"study": "raft", "body": {"database": "raft.nc"}, "designs": {"a": {}, "b": {"dofs": "rigid"}}}
SWELL, STILL = {"kind": "regular", "amplitude": 0.5, "period": 7.0}, {"kind": "still"}


def study(**changes):
    return validated(BodyStudy, {**BODY, "waves": [SWELL], **changes}, "raft.yaml")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waves": [SWELL, SWELL]}, r"waves \['regular_A0.5_T7', 'regular_A0.5_T7'\]: the same sea is listed twice"),
        ({"waves": [SWELL, STILL, SWELL]}, r"waves \['regular_A0.5_T7', 'still', 'regular_A0.5_T7'\]: the same sea is"),
        ({"waves": [STILL, SWELL, {**SWELL, "period": 8.0}, STILL]}, r"waves \['still', .* 'still'\]: the same sea is"),
        *(
            (
                {"study": name},
                f"study: received '{name}'; '{name}' is the name of a results folder; choose a name other",
            )
            for name in ("hydro", "hydro_precision", "barge", "logs", "benchmarks")
        ),
        ({"pto": {"damping": {"a": 1.0}}}, "pto.damping: received dampers of a, needs one for every design: a, b"),
        ({"pto": {"damping": {}}}, "pto.damping: received dampers of no design, needs one for every design: a, b"),
        (
            {"pto": {"damping": {"a": 1.0, "b": 2.0, "c": 3.0}}},
            "pto.damping: received dampers of a, b, c, needs one for every design: a, b",
        ),
        ({"published": {"source": "x", "values": {"c": {}}}}, r"published.values \['c'\]: no such design"),
        (
            {"published": {"source": "x", "values": {"d": {}, "a": {}, "c": {}}}},
            r"published.values \['c', 'd'\]: no such design; needs some of a, b",
        ),
    ],
)
def test_what_both_refuse(changes, message):
    with pytest.raises(ConfigError, match=message):
        study(**changes)


def test_realisations_are_seas_and_one_of_each_suits_a_damper():
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 7.0, "realisations": 3}
    found = study(waves=[sea, STILL, {**SWELL, "direction": 20.0}])
    assert [wave.label for wave in found.one_of_each_sea] == ["jonswap_Hs1_Tp7_g3.3_s1", "regular_A0.5_T7_d20"]
    assert len(found.waves) == 5
    assert [(wave.seed, wave.realisations) for wave in found.waves[:3]] == [(1, 1), (2, 1), (3, 1)]
    assert found.has_spectra
    assert not study(waves=[STILL, SWELL]).has_spectra
    later = study(waves=[STILL, {**sea, "seed": 7}, {**sea, "tp": 5.0, "realisations": 1}])
    assert [wave.seed for wave in later.waves[1:]] == [7, 8, 9, 1]
    assert later.drawn_waves == (later.waves[0], later.waves[1], later.waves[4])
    assert later.one_of_each_sea == later.drawn_waves[1:]
    assert [found.tuning(wave) for wave in found.waves[-2:]] == ["fixed", "each"]
    with pytest.raises(ConfigError, match=r"waves.3 still: no damper is best where nothing comes in"):
        found.check_dampers()


def test_figures_may_be_published_of_some_designs():
    assert study(published={"source": "x", "values": {"b": {"energy": 1.0}}}).published.values == {"b": {"energy": 1.0}}


def test_in_still_water_a_damper_of_nothing_is_one_as_any_other():
    """Given to all designs, or one by one; whatever tuning finds where something comes in."""
    for damping in (0.0, {"a": 0.0, "b": 0.0}, 5.0):
        for tuning in ("fixed", "each"):
            study(waves=[SWELL, STILL], pto={"damping": damping, "tuning": tuning}).check_dampers()


def test_a_damper_for_all_seas_is_the_given_one_where_nothing_comes_in_at_all():
    """Of other seas there is one to find, which still water has as well."""
    for waves, tuned in (([STILL], "fixed"), ([STILL, SWELL], "one")):
        found = study(waves=waves, pto={"damping": 5.0, "tuning": "one"})
        assert found.tuning(found.waves[0]) == tuned
        assert [found.tuning(wave) for wave in found.waves[1:]] == [tuned] * (len(waves) - 1)
