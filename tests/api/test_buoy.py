"""A first result without files."""

import numpy as np
import pytest

import vsb

PERIODS = np.array([2.2, 2.9, 4.0])


def test_power_scales_by_froude_and_stays_below_the_limit():
    """Twice the size and sqrt(2) the period: 2^1.5 times the power per squared amplitude, and the same gain."""
    small, large = vsb.Buoy(radius=2.0).power(PERIODS), vsb.Buoy(radius=4.0).power(np.sqrt(2) * PERIODS)
    for column in ("rigid", "flexible", "limit"):
        assert large[column].values == pytest.approx(2**1.5 * small[column].values, rel=2e-3)
    assert (small.rigid <= small.limit).all()
    assert (small.flexible <= small.limit).all()


def test_wrong_key_and_period_are_one_line_each(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(vsb.VsbError, match=r"vsb\.Buoy: device\.young_modulu: .*did you mean young_modulus"):
        vsb.Buoy(young_modulu=1e7)
    with pytest.raises(vsb.VsbError, match=r"periods: received \[100\.0\] s, needs 0\.\d+ to \d+\.\d s"):
        vsb.Buoy().rao([100.0])
    assert list(tmp_path.iterdir()) == []
