"""The answer of a campaign in words."""

import numpy as np
import pytest
import xarray as xr
from report.test_campaign_figures import GAINS, by_runs, campaign

from vsb.report.campaign_answer import (
    answer,
    best_flexible,
    closing_answer,
    is_verified,
    leading,
    of_points,
    second_answer,
    share_range,
    shown_place,
    told_beside,
    where,
    whole_answer,
)
from vsb.report.campaign_page import statements, warnings


def test_the_answer_is_of_the_best_flexible_design_that_carries_its_load():
    assert answer(campaign(), "FSB", "one") == (
        "Over a year of a buoy, each design at its own optimal damper of the year, the best flexible design, VSWEC at "
        "young modulus 100 MPa, thickness 0.01 m, absorbs 8.0 % more than the rigid FSB (+5.0 to +11.0 % by linear "
        "theory; 94.67 against 87.66 MWh)."
    )
    one, design = best_flexible(campaign(margin=[[0.5, 0.5], [-0.1, 0.5]]), "FSB", "one")
    assert (design, where(one)) == ("VSWEC", "young modulus 1 MPa, thickness 0.02 m")


def test_a_shell_that_buckles_gives_no_valid_answer_and_its_number_stands_below():
    found = whole_answer(campaign(margin=-1.0), "FSB", "one")
    assert found.stands == [
        "No valid answer yet: the shell buckles under its static load at all 4 points (2 times what it can carry). Change "
        "first: raise device.internal_pressure to carry the load, or device.thickness."
    ]
    assert closing_answer(campaign(margin=-1.0)) == found.stands[0]
    (below,) = found.below
    assert below.startswith("What was computed, although the model does not hold: Over a year of a buoy, each design")
    assert "94.67 against 87.66 MWh)" in below
    carries = whole_answer(campaign(), "FSB", "one")
    assert (carries.stands[0], carries.below) == (answer(campaign(), "FSB", "one"), [])


@pytest.mark.parametrize(
    ("gain", "words"), [(-4.0, "4.0 % less than"), (0.04, "as much as"), (0.06, "0.1 % more than")]
)
def test_more_less_and_the_same(gain, words):
    assert f"absorbs {words} the rigid FSB" in answer(campaign(gains=np.full((2, 2), gain)), "FSB", "one")


def test_an_answer_by_runs_in_time_says_what_linear_theory_says():
    """Value, interval and energies are of the runs; an interval that includes none is said to."""
    ds = campaign()
    gain = (ds.gain_percent - 2.0).where(ds.design != "FSB", 0.0)
    told = answer(by_runs(ds, gain, width=0.7, factor=0.917), "FSB", "one")
    assert "absorbs 6.0 % more" in told
    assert "(+5.3 to +6.7 % by body-exact runs, where linear theory says +8.0 %; 85.21 against 80.38 MWh)" in told
    told = answer(by_runs(ds, gain, width=7.0, model="linear"), "FSB", "one")
    assert (
        "(-1.0 to +13.0 % by linear runs in time, where linear theory says +8.0 %, too few to tell more from less;"
        in told
    )


def test_without_a_rigid_design_the_one_that_takes_most_is_told():
    assert answer(campaign(), None, "one").endswith("own optimal damper of the year, VSWEC absorbs most: 94.67 MWh.")
    lost = campaign()
    lost["annual_energy"] = lost.annual_energy * np.nan
    assert answer(lost, None, "one") == "Over a year of a buoy, no design is viable."


def test_over_a_rigid_design_that_takes_nothing_no_gain_is_told():
    """All gains missing under the tuning the answer is of; under another one they may be there."""
    ds = campaign()
    ds.gain_percent.loc[{"tuning": "one"}] = np.nan
    assert leading(ds) == ("one", None)
    assert closing_answer(ds).endswith("VSWEC absorbs most: 94.67 MWh.")
    ds["annual_energy"] = 0.0 * ds.annual_energy
    assert closing_answer(ds).endswith("own optimal damper of the year, no design absorbs power.")
    ds = campaign()
    ds.gain_percent.loc[{"tuning": "fixed"}] = np.nan
    assert leading(ds) == ("one", "FSB")


def test_the_second_sentence_says_what_a_fixed_damper_would():
    ds = by_runs(campaign(), campaign().gain_percent)
    ds.gain_percent.loc[{"tuning": "fixed", "design": "VSWEC"}] = 20.0
    told = second_answer(ds, "FSB", "one")
    assert told.startswith("All at the given damper, tuned for none of them, the best flexible design, VSWEC at young")
    assert "absorbs 20.0 % more than the rigid FSB (-8.0 to -2.0 % by linear theory;" in told
    assert not [line for line in statements(ds, "FSB", "one") if "given damper" in line]


def test_the_second_sentence_is_of_limits_where_they_are_known():
    ds = campaign().assign_coords(tuning=["fixed", "one", "constrained"])
    assert second_answer(ds, "FSB", "one").startswith("Under the best force there is within its limits, the best")
    assert any(line.startswith("All at the given damper, it is") for line in statements(ds, "FSB", "one"))


def test_the_second_sentence_tells_points_or_doubts_where_there_is_one_tuning():
    ds = campaign(margin=[[0.5, -0.5], [0.5, -0.5]]).sel(tuning=["one"])
    told = second_answer(ds, "FSB", "one")
    assert told == "2 of 4 points carry their static load without buckling; flexibility pays at 1 of these."
    assert told not in statements(ds, "FSB", "one")
    one = ds.isel(young_modulus=[0], thickness=[0])
    said = "25 % of the energy is from seas beyond what is described."
    assert second_answer(one, "FSB", "one") == f"This is linear theory alone: {said}"
    assert second_answer(one.assign_attrs(verification="tuning one: 4 seas"), "FSB", "one") == said
    lost = one.assign(energy_beyond_validity=one.energy_beyond_validity * np.nan)
    assert second_answer(lost, "FSB", "one") == ""


def test_the_tuning_the_answer_is_told_at():
    assert leading(campaign()) == ("one", "FSB")
    assert leading(campaign(reference="").sel(tuning=["fixed", "each"])) == ("each", None)


def test_the_only_flexible_design_of_a_single_point_is_not_called_the_best():
    one = campaign(gains=np.array([[8.0]]), margin=-0.5, modulus=(1e8,), thickness=(0.01,))
    assert "of the year, VSWEC absorbs 8.0 % more" in answer(one, "FSB", "one")
    two = one.sel(design=["FSB", "VSWEC", "VSWEC"]).assign_coords(design=["FSB", "VSWEC", "other"])
    assert "the best flexible design, VSWEC" in answer(two, "FSB", "one")
    assert warnings(one)[2] == "The shell would buckle under its static load, 1.5 times what it carries."


def test_a_point_that_pays_and_buckles_is_none_of_those_that_carry_their_load():
    """Where the interval of no design lies above zero nothing pays; a margin of zero carries."""
    told = "{} of 4 points carry their static load without buckling; flexibility pays at {} of these."
    for margin, counts in (([[0.0, 0.5], [-0.1, 0.5]], (3, 0)), ([[-0.1, -0.1], [0.0, -0.1]], (1, 1))):
        assert of_points(campaign(margin=margin), "FSB", "one") == told.format(*counts)
    assert of_points(campaign(gains=np.full((2, 2), 3.0)), "FSB", "one") == told.format(4, 0)


def three(**changes):
    """The campaign with two flexible designs, the second with gains of its own."""
    ds = campaign().sel(design=["FSB", "VSWEC", "VSWEC"]).assign_coords(design=["FSB", "VSWEC", "other"])
    for name, values in changes.items():
        ds[name] = ds[name].copy()
        ds[name][{"design": 2}] = np.asarray(values)[..., None]
    return ds


def test_a_point_at_which_several_designs_pay_is_counted_once():
    """VSWEC pays at one point, the other at this and at another one, the rigid one never."""
    ds = three(gain_low=[[-1.0, 1.0], [2.0, -3.0]])
    ds["margin"] = ds.margin.where(ds.thickness < 0.015, -0.5)
    ds["gain_low"] = ds.gain_low.where(ds.design != "FSB", 1.0)
    told = "2 of 4 points carry their static load without buckling; flexibility pays at 1 of these."
    assert of_points(ds, "FSB", "one") == told


def test_a_point_pays_where_the_interval_lies_above_zero_and_carries_where_nothing_is_left():
    for low, pays in ((0.0, 0), (1e-9, 1)):
        for margin, carries in ((0.0, 1), (-1e-9, 0)):
            ds = campaign(margin=[[margin, -1.0], [-1.0, -1.0]])
            ds["gain_low"] = 0 * ds.gain_low - 1.0
            ds.gain_low[0, 0, 1] = low
            told = f"1 of 4 points carry their static load without buckling; flexibility pays at {pays} of these."
            none = "None of the 4 points carries its static load without buckling."
            assert of_points(ds, "FSB", "one") == (told if carries else none)


def test_without_a_rigid_design_the_member_shown_is_the_one_that_takes_most():
    """Of results that know no gains."""
    ds = campaign(gains=GAINS[::-1]).drop_vars(["gain_percent", "gain_low", "gain_high"])
    assert shown_place(ds, "one", None) == {"young_modulus": 0, "thickness": 0}
    ds = ds.assign(margin=ds.margin.where(ds.young_modulus > 1e7, -0.1))
    assert shown_place(ds, "one", None) == {"young_modulus": 1, "thickness": 1}
    assert shown_place(ds.isel(young_modulus=0, thickness=0), "one", None) == {}


def test_of_designs_that_take_as_much_the_first_is_told():
    ds = three()
    assert answer(ds, None, "one").endswith("VSWEC absorbs most: 94.67 MWh.")
    assert answer(ds.isel(design=[0, 2, 1]), None, "one").endswith("other absorbs most: 94.67 MWh.")


def test_a_shell_with_nothing_left_does_not_buckle():
    assert "buckle" not in whole_answer(campaign(margin=0.0), "FSB", "one").stands[0]
    assert whole_answer(campaign(margin=-1e-9), "FSB", "one").stands[0].startswith("No valid answer yet")


@pytest.mark.parametrize(
    ("shares", "told"),
    [
        ([[np.nan, 10.4], [25.6, 12.0]], "10 to 26 %"),
        ([[25.6, 12.0], [10.4, np.nan]], "10 to 26 %"),
        ([[9.6, 10.4]], "10 %"),
    ],
)
def test_a_range_is_of_all_designs_that_are_viable(shares, told):
    assert share_range(xr.DataArray(shares)) == told


@pytest.mark.parametrize(
    ("tunings", "tuning", "beside"),
    [(["fixed"], "fixed", None), (["constrained"], "constrained", None), (["fixed", "constrained"], "fixed", "constrained"),
     (["one", "each"], "one", None), (["one", "fixed"], "one", "fixed")],
)  # fmt: skip
def test_beside_the_answer_stands_another_tuning(tunings, tuning, beside):
    ds = campaign().sel(tuning=["one"] * len(tunings)).assign_coords(tuning=tunings)
    assert (leading(ds)[0], told_beside(ds, tuning)) == (tuning, beside)


def test_a_point_of_which_no_gain_is_known_is_not_shown():
    """Whether it carries its load or not, and before or behind the others."""
    for margin in (0.5, -0.5):
        for lost, shown in (((1, 0), (0, 1)), ((0, 0), (1, 0))):
            ds = campaign(margin=margin)
            ds.gain_percent[lost] = np.nan
            assert tuple(shown_place(ds, "one", "FSB").values()) == shown


def test_shares_beyond_what_is_described_are_of_the_tuning_told():
    ds = campaign().sel(tuning=["each", "one"]).isel(young_modulus=[0], thickness=[0])
    ds["energy_beyond_validity"] = ds.energy_beyond_validity * xr.DataArray([2.0, 1.0], dims="tuning")
    assert second_answer(ds, "FSB", "one").endswith("25 % of the energy is from seas beyond what is described.")
    assert second_answer(ds, "FSB", "each").endswith("50 % of the energy is from seas beyond what is described.")


def test_gains_that_are_missing_of_some_points_leave_the_answer_over_the_rigid_design():
    """As of a shell that is not viable there; only where all are missing there is none to be told."""
    ds = campaign()
    ds.gain_percent[0, 0, :, :] = np.nan
    ds.annual_energy[0, 0, :, :] = np.nan
    ds.energy_beyond_validity[0, 0, :, :] = np.nan
    assert leading(ds) == ("one", "FSB")
    assert answer(ds, None, "one").endswith("VSWEC absorbs most: 94.67 MWh.")
    lost = ds.sel(tuning=["one"]).isel(young_modulus=[0])
    assert second_answer(lost, None, "one") == (
        "This is linear theory alone: 25 % of the energy is from seas beyond what is described."
    )


def test_without_a_rigid_design_no_points_are_counted():
    told = second_answer(campaign(margin=[[0.5, -0.5], [0.5, -0.5]]).sel(tuning=["one"]), None, "one")
    assert told == "This is linear theory alone: 25 % of the energy is from seas beyond what is described."


def test_the_member_shown_stands_in_its_place_whatever_the_order_of_dimensions():
    """Two moduli by three thicknesses; a shell with nothing left carries its load."""
    gains = np.array([[1.0, 2.0, 9.0], [3.0, 4.0, 5.0]])
    ds = campaign(gains=gains, margin=[[0.5, 0.5, 0.0], [0.5, 0.5, 0.5]], thickness=(0.01, 0.02, 0.03))
    turned = ds.assign(gain_percent=ds.gain_percent.transpose("design", "thickness", "tuning", "young_modulus"))
    for each in (ds, turned):
        assert shown_place(each, "one", "FSB") == {"young_modulus": 0, "thickness": 2}
        assert shown_place(each.assign(margin=each.margin - 1e-9), "one", "FSB") == {"young_modulus": 1, "thickness": 2}
        few = each.drop_vars(["gain_percent", "gain_low", "gain_high"])
        power = each.annual_mean_power.transpose("thickness", "design", "young_modulus", "tuning")
        assert shown_place(few.assign(annual_mean_power=power), "one", None) == {"young_modulus": 0, "thickness": 2}


def test_of_several_flexible_designs_the_best_is_the_one_whose_corrected_gain_is_largest():
    """And the member shown is the best by it; linear theory has another order of both."""
    ds = three(gain_percent=[[1.0, 2.0], [12.0, 4.0]])
    ds = by_runs(ds, ds.gain_percent.copy(deep=True))
    ds.body_exact_gain_percent[1, 0, 2] = 3.0
    ds.body_exact_gain_percent[0, 1, 1] = 9.0
    one, design = best_flexible(ds, "FSB", "one")
    assert (design, where(one)) == ("VSWEC", "young modulus 1 MPa, thickness 0.02 m")
    one, design = best_flexible(ds, "FSB", "each")
    assert (design, where(one)) == ("other", "young modulus 100 MPa, thickness 0.01 m")
    ds.body_exact_gain_percent[0, 1, 2] = 10.0
    assert best_flexible(ds, "FSB", "one")[1] == "other"


def test_of_one_design_or_of_gains_that_are_not_known_none_is_the_best():
    ds = campaign()
    assert best_flexible(ds, None, "one") is None
    assert best_flexible(ds.sel(design=["FSB"]), "FSB", "one") is None
    lost = ds.assign(gain_percent=ds.gain_percent.where(ds.design == "FSB"))
    assert best_flexible(lost, "FSB", "one") is None


def test_a_campaign_that_was_verified_without_a_rigid_design_has_no_corrected_gains():
    ds = campaign(verified_tuning="one", verified_model="body_exact")
    assert not is_verified(ds, "one")
    corrected = by_runs(ds, ds.gain_percent)
    assert [is_verified(corrected, tuning) for tuning in ("fixed", "one", "each")] == [False, True, False]
    assert not is_verified(corrected.drop_attrs(), "one")


def test_keys_that_have_several_values_are_no_place():
    ds = campaign()
    assert where(ds) == ""
    assert where(ds.isel(young_modulus=1)) == "young modulus 100 MPa"
    assert where(ds.isel(thickness=0, young_modulus=1)) == "young modulus 100 MPa, thickness 0.01 m"


@pytest.mark.parametrize("margin", [0.5, -0.5])
def test_flexible_designs_that_take_nothing_are_held_against_what_the_rigid_one_takes(margin):
    """As of limits no force keeps at a shell: 100 % less, which no energy follows from."""
    ds = campaign(gains=np.full((2, 2), -100.0), margin=margin)
    assert (
        "absorbs 100.0 % less than the rigid FSB (-103.0 to -97.0 % by linear theory; 0 against 87.66 MWh)"
        in answer(ds, "FSB", "one")
    )
    told = answer(by_runs(ds, ds.gain_percent, factor=0.5), "FSB", "one")
    assert "by body-exact runs, where linear theory says -100.0 %; 0 against 43.83 MWh)" in told


@pytest.mark.parametrize(
    ("gain", "told"), [(4.0, "VSWEC absorbs most: 91.17 MWh."), (-4.0, "FSB absorbs most: 87.66 MWh.")]
)
def test_the_design_named_is_that_whose_energy_is_told(gain, told):
    """Whether it is the first or the last, all points alike."""
    for order in (["FSB", "VSWEC"], ["VSWEC", "FSB"]):
        assert answer(campaign(gains=np.full((2, 2), gain)).sel(design=order), None, "one").endswith(told)


@pytest.mark.parametrize(("gain", "other", "best"), [(2.0, -9.0, "VSWEC"), (-9.0, -2.0, "other"), (-9.0, 2.0, "other")])
def test_the_best_design_gains_most_whatever_another_loses(gain, other, best):
    ds = three(gain_percent=np.full((2, 2), other))
    ds["gain_percent"] = ds.gain_percent.where(ds.design != "VSWEC", gain)
    assert best_flexible(ds, "FSB", "one")[1] == best
