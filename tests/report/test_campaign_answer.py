"""The answer of a campaign in words."""

import numpy as np
from report.test_campaign_figures import by_runs, campaign

from vsb.engine.waves.climate import YEAR_HOURS
from vsb.report.campaign_answer import (
    answer,
    best_flexible,
    closing_answer,
    leading,
    of_points,
    where,
    whole_answer,
)


def test_answer_names_the_best_flexible_design_that_does_not_buckle():
    assert answer(campaign(), "FSB", "one") == (
        "Over a year of a buoy, each design at its optimal damping for the year, the best flexible design, VSWEC at "
        "young modulus 100 MPa, thickness 0.01 m, absorbs 8.0 % more than the rigid FSB (+5.0 to +11.0 % by linear "
        "theory; 94.67 against 87.66 MWh)."
    )
    one, design = best_flexible(campaign(margin=[[0.5, 0.5], [-0.1, 0.5]]), "FSB", "one")
    assert (design, where(one)) == ("VSWEC", "young modulus 1 MPa, thickness 0.02 m")


def test_no_valid_answer_where_every_shell_buckles():
    found = whole_answer(campaign(margin=-1.0), "FSB", "one")
    assert found.stands == [
        "No valid answer yet: the shell buckles under its static load at all 4 points (2 times what it can carry). Change "
        "first: raise device.internal_pressure to carry the load, or device.thickness."
    ]
    assert closing_answer(campaign(margin=-1.0)) == found.stands[0]
    (below,) = found.below
    assert below.startswith("Computed although the model does not hold: Over a year of a buoy, each design")
    assert "94.67 against 87.66 MWh)" in below
    carries = whole_answer(campaign(), "FSB", "one")
    assert (carries.stands[0], carries.below) == (answer(campaign(), "FSB", "one"), [])


def test_answer_of_time_domain_runs_also_gives_the_linear_gain():
    ds = campaign()
    gain = (ds.gain_percent - 2.0).where(ds.design != "FSB", 0.0)
    text = answer(by_runs(ds, gain, width=0.7, factor=0.917), "FSB", "one")
    assert "absorbs 6.0 % more" in text
    assert "(+5.3 to +6.7 % by body-exact runs; linear theory gives +8.0 %; 85.21 against 80.38 MWh)" in text
    text = answer(by_runs(ds, gain, width=7.0, model="linear"), "FSB", "one")
    assert (
        "(-1.0 to +13.0 % by linear time-domain runs; linear theory gives +8.0 %; too few runs to resolve the sign;"
        in text
    )


def test_no_gain_over_a_rigid_design_without_power():
    ds = campaign()
    ds.gain_percent.loc[{"tuning": "one"}] = np.nan
    assert leading(ds) == ("one", None)
    assert closing_answer(ds).endswith(
        "VSWEC at young modulus 100 MPa, thickness 0.01 m absorbs most: 94.67 MWh (93.73 to 96.57 with all known errors)."
    )
    ds["annual_mean_power"] = 0.0 * ds.annual_mean_power
    assert closing_answer(ds).endswith("optimal damping for the year, no design absorbs power.")
    ds = campaign()
    ds.gain_percent.loc[{"tuning": "fixed"}] = np.nan
    assert leading(ds) == ("one", "FSB")


def test_without_a_rigid_design_power_is_that_of_the_runs_too():
    """The power that `vsb compare` shows, with its interval; linear theory's has another column."""
    ds = campaign(gains=np.full((2, 2), 3.0))
    ds.gain_percent.loc[{"tuning": "one"}] = np.nan
    ds = by_runs(ds, ds.gain_percent)
    ds["body_exact_mean_power"] = 0.9 * ds.annual_mean_power.sel(tuning="one", drop=True)
    ds["body_exact_power_low"], ds["body_exact_power_high"] = 0.8 * ds.body_exact_mean_power, ds.body_exact_mean_power
    most = float(ds.body_exact_mean_power.max()) * YEAR_HOURS / 1e6
    assert closing_answer(ds).endswith(
        f"absorbs most: {most:.4g} MWh ({0.8 * most:.4g} to {most:.4g} with all known errors)."
    )


def test_points_that_buckle_are_not_counted_as_paying():
    """The interval must lie above zero; a margin of zero still carries."""
    expected = "{} stable against buckling; a flexible design absorbs more at {} of these."
    few = "3 of 4 points are", "1 of 4 points is"
    for margin, counts in (([[0.0, 0.5], [-0.1, 0.5]], (few[0], "none")), ([[-0.1, -0.1], [0.0, -0.1]], (few[1], 1))):
        assert of_points(campaign(margin=margin), "FSB", "one") == expected.format(*counts)
    assert of_points(campaign(gains=np.full((2, 2), 3.0)), "FSB", "one") == expected.format("All 4 points are", "none")


def test_points_say_under_which_damper_where_control_is_shown_too():
    """Under control flexible designs may gain where under dampers they do not."""
    ds = campaign().sel(tuning=["one", "one"]).assign_coords(tuning=["one", "causal"])
    assert "; each design at its optimal damping for the year, a flexible design absorbs" in of_points(ds, "FSB", "one")


def three(**changes):
    """The campaign with two flexible designs, the second with gains of its own."""
    ds = campaign().sel(design=["FSB", "VSWEC", "VSWEC"]).assign_coords(design=["FSB", "VSWEC", "other"])
    for name, values in changes.items():
        ds[name] = ds[name].copy()
        ds[name][{"design": 2}] = np.asarray(values)[..., None]
    return ds


def test_best_design_is_chosen_by_the_gains_of_the_runs():
    """Linear theory would choose another design and another point."""
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
