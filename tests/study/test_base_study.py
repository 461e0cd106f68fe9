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
        ({"waves": [SWELL, STILL, SWELL]}, r"waves \['regular_A0.5_T7', 'still', 'regular_A0.5_T7'\]: the same sea is"),
        ({"study": "logs"}, "study: received 'logs'; 'logs' is the name of a results folder; choose a name other"),
        ({"pto": {"damping": {"a": 1.0}}}, "pto.damping: received dampers of a, needs one for every design: a, b"),
        ({"pto": {"damping": {}}}, "pto.damping: received dampers of no design, needs one for every design: a, b"),
        (
            {"published": {"source": "x", "values": {"d": {}, "a": {}, "c": {}}}},
            r"published.values \['c', 'd'\]: no such design; needs some of a, b",
        ),
    ],
)
def test_errors_common_to_both(changes, message):
    with pytest.raises(ConfigError, match=message):
        study(**changes)


def test_realisations_are_seas_of_their_own():
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
    with pytest.raises(ConfigError, match=r"waves.3 still: still water has no optimal damping"):
        found.check_dampers()


def test_damping_in_still_water():
    """Without waves the given damping holds; with other seas the tuned one holds in still water too."""
    for waves, tuned in (([STILL], "fixed"), ([STILL, SWELL], "one")):
        found = study(waves=waves, pto={"damping": 5.0, "tuning": "one"})
        assert found.tuning(found.waves[0]) == tuned
        assert [found.tuning(wave) for wave in found.waves[1:]] == [tuned] * (len(waves) - 1)
