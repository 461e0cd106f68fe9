"""Corrections of a year by runs in time, as a dataset."""

import numpy as np
import pytest
from results.test_year import WATER, climate, port

from vsb.errors import ConfigError
from vsb.results.verification import contributions, drawn, verified
from vsb.results.verified_year import GAIN, POWER, verified_dataset, with_lost
from vsb.results.year import frequencies, year


@pytest.fixture(scope="module")
def known():
    """A year of two bodies and a sample of its seas."""
    seas = climate()
    grid = frequencies(seas, 0.1, 4.0)
    found = year({"A": port(grid), "B": port(grid, mass=9000.0)}, seas, WATER, ("each", "one"), reference="A")
    return found, drawn(contributions(found, "one"), seas.hours, 8, 1)


def corrected(known, part):
    """The year whose designs absorb a share of the linear power."""
    found, sample = known
    linear = found.power[:, 1][:, sample.sea]
    return verified_dataset(found, "one", verified(found, "one", sample, np.array(part)[:, None] * linear, linear))


def test_proportional_loss_is_found_without_scatter(known):
    """A loss that grows with height has an interval."""
    found, sample = known
    linear = found.annual_mean_power[:, 1]
    ds = corrected(known, [0.8, 0.8])
    for name in POWER:
        np.testing.assert_allclose(ds[name], 0.8 * linear, rtol=1e-9)
    taken, hs = found.power[:, 1][:, sample.sea], found.climate.hs[sample.sea]
    ds = verified_dataset(found, "one", verified(found, "one", sample, (1 - 0.05 * hs) * taken, taken))
    lost = (sample.weight * 0.05 * hs * taken).mean(axis=1) / (sample.weight * taken).mean(axis=1)
    np.testing.assert_allclose(ds.corrected_mean_power, linear * (1 - lost), rtol=1e-12)
    assert bool((ds.corrected_power_low < ds.corrected_mean_power).all())
    assert bool((ds.corrected_power_high > ds.corrected_mean_power).all())
    assert [float(ds[name].sel(design="A")) for name in GAIN] == [0.0, 0.0, 0.0]
    ratio = float(ds.corrected_mean_power.sel(design="B") / ds.corrected_mean_power.sel(design="A"))
    assert float(ds.corrected_gain_percent.sel(design="B")) == pytest.approx(100 * (ratio - 1), rel=1e-12)
    np.testing.assert_array_equal(ds.drawn_hs, found.climate.hs[sample.sea])


def test_designs_that_are_not_viable_have_no_values(known):
    ds = with_lost(corrected(known, [0.9, 0.9]), ["A", "C", "B"], "A")
    assert ds.viable.values.tolist() == [True, False, True]
    for name in (*POWER, *GAIN, "run_power"):
        assert np.isnan(ds[name].sel(design="C")).all()
        assert np.isfinite(ds[name].sel(design=["A", "B"])).all()


def test_reference_without_power_is_refused(known):
    with pytest.raises(ConfigError, match=r"corrected power of -[\d.e+]+ W of the rigid A; needs more than 0 W"):
        corrected(known, [-3.0, 1.0])
