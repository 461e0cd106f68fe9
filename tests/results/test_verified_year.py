"""What runs in time say of a year, as a dataset: by design, with what is not viable, with what has no gain."""

import dataclasses

import numpy as np
import pytest
import xarray as xr
from results.test_year import WATER, climate, port

from vsb.errors import ConfigError
from vsb.results.verification import contributions, drawn, verified
from vsb.results.verified_year import GAIN, POWER, of_nothing, verified_dataset, with_lost
from vsb.results.year import frequencies, year
from vsb.tools.units import check_finite


@pytest.fixture(scope="module")
def known():
    """A year of two bodies and a sample of its seas."""
    seas = climate()
    grid = frequencies(seas, 0.1, 4.0)
    found = year({"A": port(grid), "B": port(grid, mass=9000.0)}, seas, WATER, ("each", "one"), reference="A")
    return found, drawn(contributions(found, "one"), seas.hours, 8, 1)


def corrected(known, part):
    """The year whose designs take a part of what linear theory says."""
    found, sample = known
    linear = found.power[:, 1][:, sample.sea]
    return verified_dataset(found, "one", verified(found, "one", sample, np.array(part)[:, None] * linear, linear))


def test_losses_of_each_design_are_those_of_its_year_and_gain(known):
    """A loss in proportion is known without scatter, whatever seas are drawn; one that grows with height is not."""
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


def test_over_a_design_that_takes_nothing_there_are_no_gains(known):
    """Nor is it refused for that: no longer run would change it."""
    found, sample = known
    power = found.power.copy()
    power[0] = 0.0
    nothing = dataclasses.replace(found, power=power)
    linear = power[:, 1][:, sample.sea]
    ds = verified_dataset(nothing, "one", verified(nothing, "one", sample, 0.9 * linear, linear))
    assert ds.corrected_mean_power.values[0] == 0.0
    assert ds.corrected_mean_power.values[1] == pytest.approx(0.9 * found.annual_mean_power[1, 1])
    for name in GAIN:
        assert np.isnan(ds[name]).all()
    check_finite(ds, "x")


@pytest.mark.parametrize("reference", ["A", None])
def test_a_year_of_nothing_is_told_without_runs(known, reference):
    found, _ = known
    nothing = dataclasses.replace(found, power=0.0 * found.power, reference=reference)
    ds = with_lost(of_nothing(nothing), ["A", "C", "B"], reference)
    assert [ds[name].sel(design="B").item() for name in POWER] == [0.0, 0.0, 0.0]
    assert {name for name in GAIN if name in ds} == (set(GAIN) if reference else set())
    check_finite(ds, "x")


def test_designs_that_are_not_viable_have_no_values(known):
    ds = with_lost(corrected(known, [0.9, 0.9]), ["A", "C", "B"], "A")
    assert ds.viable.values.tolist() == [True, False, True]
    for name in (*POWER, *GAIN, "run_power"):
        assert np.isnan(ds[name].sel(design="C")).all()
        assert np.isfinite(ds[name].sel(design=["A", "B"])).all()


@pytest.mark.parametrize(("reference", "names"), [("A", (*POWER, *GAIN)), (None, POWER)])
def test_where_no_design_is_viable_all_are_named_without_values(reference, names):
    ds = with_lost(xr.Dataset(coords={"design": []}), ["A", "B"], reference)
    assert set(ds.data_vars) == {*names, "viable"}
    assert ds.design.values.tolist() == ["A", "B"]
    assert not ds.viable.any()
    assert all(np.isnan(ds[name]).all() for name in names)


def test_without_a_rigid_design_there_is_no_gain(known):
    ds = with_lost(corrected(known, [0.9, 0.9]).drop_vars(GAIN), ["A", "B"], None)
    assert not set(GAIN) & set(ds)


def test_nothing_is_gained_over_a_reference_that_takes_nothing(known):
    with pytest.raises(ConfigError, match=r"corrected power of -[\d.e+]+ W of the rigid A; needs more than 0 W"):
        corrected(known, [-3.0, 1.0])


def test_gains_are_over_the_reference_wherever_it_stands_and_runs_are_told_as_they_were(known):
    """The second of two designs, under the second of two tunings; every draw with what it was drawn by and gave."""
    found, sample = known
    other = dataclasses.replace(found, reference="B")
    linear = found.power[:, 1][:, sample.sea] * np.linspace(0.8, 1.2, 8)
    better = linear * np.array([np.linspace(0.7, 0.9, 8), np.linspace(1.1, 0.8, 8)])
    runs = verified(other, "one", sample, better, linear)
    ds = verified_dataset(other, "one", runs)
    for i, design in enumerate(found.designs):
        at = ds.sel(design=design)
        assert [float(at[name]) for name in POWER] == pytest.approx([*runs.power(i)])
        gain = [0.0, 0.0, 0.0] if design == "B" else [*runs.gain(i, 1)]
        assert [float(at[name]) for name in GAIN] == pytest.approx(gain)
        mean, low, high = (float(at[name]) for name in POWER)
        assert low < mean < high
    drawn_as = {"sea": sample.sea, "seed": sample.seed, "weight": sample.weight}
    drawn_as |= {"hs": found.climate.hs[sample.sea], "te": found.climate.te[sample.sea]}
    for name, values in drawn_as.items():
        np.testing.assert_array_equal(ds[f"drawn_{name}"], values, err_msg=name)
    powers = {"run_power": better, "linear_run_power": linear, "drawn_power": found.power[:, 1][:, sample.sea]}
    for name, values in powers.items():
        np.testing.assert_array_equal(ds[name], values, err_msg=name)


def test_over_a_reference_that_takes_nothing_under_one_tuning_alone_there_are_gains_under_the_other(known):
    found, sample = known
    power = found.power.copy()
    power[1, 0] = 0.0  # of B under the tuning each
    linear = power[:, 1][:, sample.sea]
    one = dataclasses.replace(found, power=power, reference="B")
    ds = verified_dataset(one, "one", verified(one, "one", sample, 0.9 * linear, linear))
    assert np.isfinite(ds.corrected_gain_percent).all()
    with pytest.raises(ConfigError, match=r"corrected power of -[\d.e+]+ W of the rigid B; needs more than 0 W"):
        verified_dataset(one, "one", verified(one, "one", sample, -3.0 * linear, linear))
