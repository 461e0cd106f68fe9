"""A first result without files."""

import numpy as np
import pytest

import vsb

PERIODS = np.array([2.2, 2.9, 4.0])


@pytest.fixture(scope="module")
def example():
    """The example's buoy, whose water is solved once."""
    return vsb.Buoy(radius=2.0)


def test_power_scales_by_froude_and_stays_below_the_limit(example):
    """Twice the size and sqrt(2) the period: 2^1.5 times the power per squared amplitude, and the same gain."""
    small, large = example.power(PERIODS), vsb.Buoy(radius=4.0).power(np.sqrt(2) * PERIODS)
    for column in ("rigid", "flexible", "limit"):
        assert large[column].values == pytest.approx(2**1.5 * small[column].values, rel=2e-3)
    assert (small.rigid <= small.limit).all()
    assert (small.flexible <= small.limit).all()


def test_wrong_key_and_period_are_one_line_each(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(vsb.VsbError, match=r"vsb\.Buoy: device\.young_modulu: .*did you mean young_modulus"):
        vsb.Buoy(young_modulu=1e7)
    for radius in (-1.0, "2 m"):
        with pytest.raises(vsb.VsbError, match=r"radius: received .*, needs 0\.01 to 100 m"):
            vsb.Buoy(radius=radius)
    with pytest.raises(vsb.VsbError, match=r"periods: received \[100\.0\] s, needs 0\.\d+ to \d+\.\d s"):
        example.rao([100.0])
    with pytest.raises(vsb.VsbError, match=r"periods: received an array of shape \(1, 2\), needs one row of periods"):
        example.power([[3.0, 4.0]])
    assert list(tmp_path.iterdir()) == []


def test_a_shell_beyond_its_law_gives_no_numbers(example):
    """30 kPa in a wall of 5 MPa: p r/2 E h (1 - nu) = 28 % of strain; the example's 3 % is a doubt."""
    with pytest.raises(vsb.VsbError, match=r"vsb\.Buoy: fail +static_strain = 0\.\d+ "):
        vsb.Buoy(young_modulus=5e6, internal_pressure=30e3).power([2.9])
    (doubt,) = example.doubts
    assert doubt.startswith("doubt        static_strain = 0.0289 ")
