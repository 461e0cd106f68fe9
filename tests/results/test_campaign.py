"""Members of a campaign together: their order, one damper or many, what a cell of the table says of what is missing."""

import csv

import numpy as np
import pytest
import xarray as xr
from stages.test_campaign import made_up
from stages.test_members import planned, with_seas

from vsb.results.campaign import as_csv, damper, gathered, stacked
from vsb.study.campaign_plan import members
from vsb.study.year_options import CONSTRAINED
from vsb.tools.units import described


@pytest.fixture
def held(tmp_path):
    """A plan of two moduli and its members."""
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), {"device.young_modulus": [3e6, 1e6]})
    (spec,) = plan.batches.values()
    return plan, members(spec.base, spec.points, spec.climate, spec.tuning)


def test_batches_in_any_order_make_the_same_campaign(held):
    """Members stand by their ids, not by when they were done."""
    plan, found = held
    parts = [stacked([made_up(one)], [one.id]) for one in found]
    one, other = (gathered(plan.campaign, some) for some in (parts, parts[::-1]))
    xr.testing.assert_identical(one, other)
    assert one.young_modulus.values.tolist() == [3e6, 1e6]
    assert one.young_modulus.attrs == {"units": "Pa", "long_name": "device.young_modulus"}
    assert one.attrs["reference"] == "FSB"


def test_a_tuning_has_one_damper_if_all_its_seas_have_it():
    """Bins without a sea say nothing; dampers apart by less than 1e-9 are one."""
    dampers = [[[1.0, 7.0, np.nan]], [[2.0, 2.0 + 1e-10, 9.0]], [[3.0, 4.0, 9.0]]]
    ds = xr.Dataset({"damping": (("tuning", "hs", "te"), dampers), "count": (("hs", "te"), [[1, 1, 0]])})
    ds = ds.assign_coords(tuning=["each", "one", "fixed"])
    np.testing.assert_array_equal(damper(ds), [np.nan, 2.0 + 1e-10, np.nan])
    np.testing.assert_array_equal(damper(ds.assign_coords(tuning=["each", CONSTRAINED, "fixed"])), 3 * [np.nan])


def test_what_is_missing_is_an_empty_cell_and_truth_a_word(held):
    plan, found = held
    lost = made_up(found[1]).assign(
        viable=("design", [True, False]), reason=("design", np.array(["", "buckles"], dtype=object))
    )
    lost["annual_mean_power"] = lost.annual_mean_power.where(lost.viable)
    ds = gathered(plan.campaign, [stacked([made_up(found[0]), lost], [one.id for one in found])])
    rows = list(csv.DictReader(as_csv(plan.campaign, ds).splitlines()))
    missing = [row for row in rows if row["annual_mean_power"] == ""]
    assert {(row["device.young_modulus"], row["design"], row["viable"], row["reason"]) for row in missing} == {
        ("1000000", "VSWEC", "false", "buckles")
    }
    assert [row["tuning"] for row in missing] == ["fixed", "one", "each"]
    assert len(rows) == 12


@pytest.mark.parametrize(
    ("port", "unit"),
    [
        ("heave", "N s/m"), ("volume", "Pa s/m^3"), ("pitch", "N m s"), ({"dofs": {"Pitch": 1.0}}, "N m s"),
        ({"dofs": {"Pitch": 1.0, "Heave": 1.0}}, "N s/m"), ({"between": [0.0, 90.0]}, "N s/m"),
    ],
    ids=str,
)  # fmt: skip
def test_dampers_of_a_campaign_have_the_unit_of_its_port(held, port, unit):
    """Force, pressure or moment over what the take-off moves at."""
    plan, found = held
    base = plan.campaign.base | {"pto": plan.campaign.base["pto"] | {"port": port}}
    spec = plan.campaign.model_copy(update={"base": base})
    ds = described(gathered(spec, [stacked([made_up(one)], [one.id]) for one in found]))
    assert ds.damping.attrs["units"] == unit
