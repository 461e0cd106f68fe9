"""Seas: direction, band, memory, seeds."""

import math

import pytest

from vsb.engine.waves.kinds import Jonswap, OchiHubble, PiersonMoskowitz, RegularWave, WhiteNoise
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical

SEAS = [
    RegularWave(kind="regular", amplitude=0.5, period=7.0),
    Jonswap(kind="jonswap", hs=1.0, tp=7.0),
    PiersonMoskowitz(kind="pierson_moskowitz", hs=1.0, tp=7.0),
    OchiHubble(kind="ochi_hubble", swell={"hs": 0.8, "tp": 7.0, "peakedness": 3.0}, wind_sea={"hs": 0.6, "tp": 3.0}),
    WhiteNoise(kind="white_noise", hs=1.0, band=(0.5, 1.5)),
]


@pytest.mark.parametrize("wave", SEAS, ids=lambda wave: wave.kind)
def test_direction_is_part_of_label_and_id(wave):
    turned = wave.model_copy(update={"direction": 45.0})
    assert '"direction":45.0' in canonical(turned)
    assert "_d45" in turned.label
    assert turned.label.replace("_d45", "") == wave.label
    assert turned.description == f"{wave.description} going to 45 degrees"
    back = wave.model_copy(update={"direction": -90.0})
    assert back.label.replace("_d-90", "") == wave.label != back.label
    assert back.description == f"{wave.description} going to -90 degrees"
    assert [type(wave).model_validate(one.model_dump()) for one in (wave, turned, back)] == [wave, turned, back]


@pytest.mark.parametrize("band", [(0.5, 1.5), (0.95, 1.05), (0.9, 1.1)])
def test_memory_is_ten_periods_or_two_beats_of_the_band(band):
    noise = WhiteNoise(kind="white_noise", hs=1.0, band=band)
    period, beat = 2 * math.pi / noise.omega, 2 * math.pi / (band[1] - band[0])
    assert noise.memory == pytest.approx(max(10 * period, 2 * beat))
    assert [wave.memory for wave in SEAS[1:4]] == pytest.approx([70.0, 70.0, 70.0])


def test_seeds_of_all_realisations_have_32_bits():
    assert Jonswap(kind="jonswap", hs=1.0, tp=7.0, seed=2**32 - 3, realisations=3).seed == 2**32 - 3
    with pytest.raises(ConfigError, match=r"seed of 10 digits: needs at most 2\^32 - realisations"):
        Jonswap(kind="jonswap", hs=1.0, tp=7.0, seed=2**32 - 2, realisations=3)


def test_swell_is_longer_than_the_wind_sea():
    with pytest.raises(ConfigError, match=r"swell.tp 4 s: needs more than that of the wind sea, 5 s"):
        OchiHubble(kind="ochi_hubble", swell={"hs": 1.0, "tp": 4.0}, wind_sea={"hs": 1.0, "tp": 5.0})
