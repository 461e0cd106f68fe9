"""Members of a campaign in one dataset and its table."""

import csv

import numpy as np
import pytest
import xarray as xr
from stages.test_campaign import made_up
from stages.test_members import planned, with_seas

from vsb.results.campaign import TABLE_OF_SEAS, as_csv, damper, gathered, stacked, with_verification
from vsb.study.campaign import CONSTRAINED, Scatter
from vsb.study.vary import MEMBER


@pytest.fixture
def held(tmp_path):
    """A plan of two moduli and its members."""
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), {"device.young_modulus": [3e6, 1e6]})
    return plan, plan.members


def test_order_of_batches_does_not_matter(held):
    plan, found = held
    parts = [stacked([made_up(one)], [one.id]) for one in found]
    one, other = (gathered(plan.campaign.spec["spec"], some) for some in (parts, parts[::-1]))
    xr.testing.assert_identical(one, other)
    assert one.young_modulus.values.tolist() == [3e6, 1e6]
    assert one.young_modulus.attrs == {"units": "Pa", "long_name": "device.young_modulus"}
    assert one.attrs["reference"] == "FSB"
    of_table = plan.campaign.spec["spec"].model_copy(update={"climate": Scatter(scatter="site.csv")})
    assert "seas" not in one.attrs
    assert gathered(of_table, parts).attrs["seas"] == TABLE_OF_SEAS


def test_reference_of_a_campaign_is_the_first_rigid_design_by_name(held):
    """That gains are relative to, in whatever order the study lists its designs."""
    plan, found = held
    spec = plan.campaign.spec["spec"]
    base = {**spec.base, "designs": {"Twin": spec.base["designs"]["FSB"], **spec.base["designs"]}}
    ds = gathered(
        spec.model_copy(update={"base": base}), [stacked(list(map(made_up, found)), [one.id for one in found])]
    )
    assert ds.attrs["reference"] == "FSB"


def test_dampings_that_are_varied_stand_beside_those_of_the_results(tmp_path):
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), {"pto.damping": [3e3, 1e4]})
    parts = [stacked([made_up(one)], [one.id]) for one in plan.members]
    ds = gathered(plan.campaign.spec["spec"], parts)
    assert ds.pto_damping.values.tolist() == [3e3, 1e4]
    assert ds.damping.dims[:3] == ("pto_damping", "design", "tuning")


def test_intervals_of_gains_in_time_are_wider_by_the_errors_of_linear_theory(held):
    """-12 to -8 % by runs, and -1.5 to +2.5 points about the linear gain."""
    plan, found = held
    ds = gathered(plan.campaign.spec["spec"], [stacked([made_up(one) for one in found], [one.id for one in found])])
    like = xr.zeros_like(ds.annual_mean_power)
    ds = ds.assign(gain_percent=like + 5.0, gain_low=like + 3.5, gain_high=like + 7.5)
    ends = {"corrected_gain_percent": -10.0, "corrected_gain_low": -12.0, "corrected_gain_high": -8.0}
    run = xr.Dataset({name: ("design", np.full(like.sizes["design"], value)) for name, value in ends.items()})
    run = run.assign_coords(design=ds.design).assign_attrs(model="body_exact", runs="4 seas")
    both = with_verification(plan.campaign.spec["spec"], ds, [run, run])
    for end, expected in (("percent", -10.0), ("low", -13.5), ("high", -5.5)):
        np.testing.assert_allclose(both[f"body_exact_gain_{end}"], expected)


def test_damper_of_a_tuning_is_known_if_all_seas_share_it():
    """Bins without seas do not count; dampings are equal to a relative 1e-9."""
    dampers = [[[1.0, 7.0, np.nan]], [[2.0, 2.0 + 1e-10, 9.0]], [[3.0, 4.0, 9.0]]]
    ds = xr.Dataset({"damping": (("tuning", "hs", "te"), dampers), "count": (("hs", "te"), [[1, 1, 0]])})
    ds = ds.assign_coords(tuning=["each", "one", "fixed"])
    np.testing.assert_array_equal(damper(ds), [np.nan, 2.0 + 1e-10, np.nan])
    np.testing.assert_array_equal(damper(ds.assign_coords(tuning=["each", CONSTRAINED, "fixed"])), 3 * [np.nan])


def test_missing_values_are_empty_cells(held):
    plan, found = held
    lost = made_up(found[1]).assign(
        viable=("design", [True, False]), reason=("design", np.array(["", "buckles"], dtype=object))
    )
    lost["annual_mean_power"] = lost.annual_mean_power.where(lost.viable)
    ds = gathered(plan.campaign.spec["spec"], [stacked([made_up(found[0]), lost], [one.id for one in found])])
    rows = list(csv.DictReader(as_csv(plan.campaign.spec["spec"], ds).splitlines()))
    missing = [row for row in rows if row["annual_mean_power"] == ""]
    assert {(row["device.young_modulus"], row["design"], row["viable"], row["reason"]) for row in missing} == {
        ("1000000", "VSWEC", "false", "buckles")
    }
    assert [row["tuning"] for row in missing] == ["fixed", "one", "each"]
    assert len(rows) == 12


def test_parameters_varied_in_pairs(tmp_path):
    """Two moduli, each with its own thickness: two points rather than four."""
    varied = {"pairs": True, "device.young_modulus": [3e6, 1e6], "device.thickness": [0.02, 0.01]}
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), varied)
    found = plan.members
    power = {1e6: 5.0, 3e6: 7.0}
    parts = [
        stacked(
            [one.assign(annual_mean_power=power[each.point["device.young_modulus"]] + 0 * one.annual_mean_power)],
            [each.id],
        )
        for each in found
        for one in [made_up(each)]
    ]
    ds = gathered(plan.campaign.spec["spec"], parts)
    assert ds.attrs["varied"] == "young_modulus thickness"
    assert ds.annual_mean_power.dims[0] == MEMBER
    for name, values in (("young_modulus", [3e6, 1e6]), ("thickness", [0.02, 0.01])):
        assert (ds[name].dims, ds[name].values.tolist()) == ((MEMBER,), values)
    assert ds.annual_mean_power.isel(design=0, tuning=0).values.tolist() == [7.0, 5.0]
    rows = list(csv.DictReader(as_csv(plan.campaign.spec["spec"], ds).splitlines()))
    shown = {(row["device.young_modulus"], row["device.thickness"], row["annual_mean_power"]) for row in rows}
    assert shown == {("3000000", "0.02", "7"), ("1000000", "0.01", "5")}
    assert len(rows) == 12
