"""Words of a campaign's report, of results made up by hand: the answer, what else is said, what to doubt, the table."""

import re

import numpy as np
import pytest
from report.test_campaign_figures import GAINS, campaign

from vsb.report.campaign_answer import answer, best_flexible, leading, second_answer, where
from vsb.report.campaign_page import MOST_ROWS, CampaignReport, captions, render, rows, statements, warnings


def test_the_answer_is_of_the_best_flexible_design_that_carries_its_load():
    assert answer(campaign(), "FSB", "one") == (
        "Over a year of a buoy, each design at its own best damper of the year, the best flexible design, VSWEC at young "
        "modulus 100 MPa, thickness 0.01 m, takes 8.0 % more than the rigid FSB (+5.0 to +11.0 %; 94.67 against 87.66 "
        "MWh)."
    )
    one, design = best_flexible(campaign(margin=[[0.5, 0.5], [-0.1, 0.5]]), "FSB", "one")
    assert (design, where(one)) == ("VSWEC", "young modulus 1 MPa, thickness 0.02 m")
    buckles = answer(campaign(margin=-1.0), "FSB", "one")
    assert buckles.endswith("94.67 against 87.66 MWh), and would buckle under its static load.")


def test_the_only_flexible_design_of_a_single_point_is_not_called_the_best():
    one = campaign(gains=np.array([[8.0]]), margin=-0.5, modulus=(1e8,), thickness=(0.01,))
    assert "of the year, VSWEC takes 8.0 % more" in answer(one, "FSB", "one")
    two = one.sel(design=["FSB", "VSWEC", "VSWEC"]).assign_coords(design=["FSB", "VSWEC", "other"])
    assert "the best flexible design, VSWEC" in answer(two, "FSB", "one")
    assert warnings(one)[2] == "The shell would buckle under its static load, 1.5 times what it carries."


@pytest.mark.parametrize(
    ("gain", "words"), [(-4.0, "4.0 % less than"), (0.04, "as much as"), (0.06, "0.1 % more than")]
)
def test_more_less_and_the_same(gain, words):
    assert f"takes {words} the rigid FSB" in answer(campaign(gains=np.full((2, 2), gain)), "FSB", "one")


def test_an_answer_by_runs_in_time_says_what_linear_theory_says():
    ds = campaign(verified_tuning="one", verified_model="body_exact")
    ds["corrected_gain_percent"], ds["corrected_mean_power"] = ds.gain_percent - 2.0, 0.9 * ds.annual_mean_power
    told = answer(ds, "FSB", "one")
    assert "takes 6.0 % more" in told
    assert "by body-exact runs, where linear theory says +8.0 %" in told
    assert "85.21 against 80.38 MWh" in told


def test_without_a_rigid_design_the_one_that_takes_most_is_told():
    assert answer(campaign(), None, "one").endswith("own best damper of the year, VSWEC takes most: 94.67 MWh.")
    lost = campaign()
    lost["annual_energy"] = lost.annual_energy * np.nan
    assert answer(lost, None, "one") == "Over a year of a buoy, no design is viable."


def test_the_second_sentence_says_what_a_fixed_damper_would():
    ds = campaign(verified_tuning="one", verified_model="body_exact", verification="tuning one: 4 seas")
    ds["corrected_gain_percent"], ds["corrected_mean_power"] = ds.gain_percent, ds.annual_mean_power
    ds.gain_percent.loc[{"tuning": "fixed", "design": "VSWEC"}] = 20.0
    told = second_answer(ds, "FSB", "one")
    assert told.startswith("All at the given damper, tuned for none of them, the best flexible design, VSWEC at young")
    assert "takes 20.0 % more than the rigid FSB (-8.0 to -2.0 % by linear theory;" in told
    assert not [line for line in statements(ds, "FSB", "one") if "given damper" in line]


def test_the_second_sentence_is_of_limits_where_they_are_known():
    ds = campaign().assign_coords(tuning=["fixed", "one", "constrained"])
    assert second_answer(ds, "FSB", "one").startswith("Under the best force there is within its limits, the best")
    assert any(line.startswith("All at the given damper, it is") for line in statements(ds, "FSB", "one"))


def test_the_second_sentence_tells_points_or_doubts_where_there_is_one_tuning():
    ds = campaign(margin=[[0.5, -0.5], [0.5, -0.5]]).sel(tuning=["one"])
    told = second_answer(ds, "FSB", "one")
    assert told == "Of 4 points 2 carry their static load; flexibility pays at 1 of all and at 1 of those."
    assert told not in statements(ds, "FSB", "one")
    one = ds.isel(young_modulus=[0], thickness=[0])
    said = "25 % of the energy is from seas beyond what is described."
    assert second_answer(one, "FSB", "one") == f"This is linear theory alone: {said}"
    assert second_answer(one.assign_attrs(verification="tuning one: 4 seas"), "FSB", "one") == said
    lost = one.assign(energy_beyond_validity=one.energy_beyond_validity * np.nan)
    assert second_answer(lost, "FSB", "one") == ""


def test_what_else_is_said():
    each, points, beyond, practice = statements(campaign(margin=[[0.5, -0.5], [0.5, -0.5]]), "FSB", "one")
    assert each.startswith("Each design at its own best damper in each sea, it is VSWEC at young modulus 100 MPa")
    assert points == ("Of 4 points 2 carry their static load; flexibility pays at 1 of all and at 1 of those.")
    assert beyond == (
        "25 % of the energy is from seas beyond what is described, crossed in the matrices: 10 % too steep, 0 % with "
        "waves that break, 40 % with shells deformed by more than a tenth of their radius."
    )
    assert practice.endswith("would have said +12.0 to +12.0 % of the annual energy.")


def test_usual_practice_is_not_set_against_itself():
    """A scatter table of JONSWAP seas is what usual practice says; another gamma, or spectra, are not."""
    ds = campaign(margin=[[0.5, -0.5], [0.5, -0.5]])
    ds["practice_power"] = ds.annual_mean_power * (1 + 1e-12)
    assert not any("usual practice" in line for line in statements(ds, "FSB", "one"))


def test_what_to_doubt():
    theory, heave = warnings(campaign())
    assert theory.startswith("All of this is linear theory")
    assert heave.startswith("In seas that bring 90 % of the energy the buoy heaves by more than 0.3 of its radius")
    assert warnings(campaign(margin=[[0.5, -0.5], [0.5, 0.5]]))[2].startswith("At 1 of 4 points the shell would buckle")
    runs, coverage = warnings(campaign(verification="tuning one: 4 seas; more"))[:2]
    assert "in 77 to 95 % where 3 to 5 %; in 89 to 96 % with 24: there they are not 95 % intervals" in coverage
    assert runs.startswith("Runs in time correct tuning one: 4 seas. Table, figures")
    lost = campaign()
    lost["viable"] = lost.viable & (lost.design != "VSWEC")
    lost["reason"] = lost.reason.where(lost.design != "VSWEC", other="unstable: at rest")
    assert warnings(lost)[-1] == "4 of 8 designs at their points are not viable: unstable."


def test_the_table_has_a_row_for_every_point_design_and_tuning():
    found = rows(campaign())
    assert len(found) == 24 == MOST_ROWS
    assert found[4] == ["young modulus 1 MPa, thickness 0.01 m", "VSWEC", "one", "83.28", "0.95", "-5.0", "2", "0.5"]
    missing = campaign()
    missing["annual_energy"] = missing.annual_energy.where(missing.design != "VSWEC")
    assert rows(missing)[4][3] == "-"
    assert len(rows(campaign(gains=np.tile(GAINS, (2, 1)), modulus=(1.0, 2.0, 3.0, 4.0)))) == MOST_ROWS


def test_rows_that_are_left_out_are_counted():
    long = campaign(gains=np.tile(GAINS, (2, 1)), modulus=(1.0, 2.0, 3.0, 4.0))
    for ds, left_out in ((campaign(), []), (long, ["24 more rows in campaign.csv"])):
        text = render(CampaignReport(ds.assign_attrs(study="a.yaml", campaign="c", spec_id="1"), {}))
        assert re.findall(r"-?\d+ more rows in campaign\.csv", text) == left_out


def test_the_tuning_the_answer_is_told_at():
    assert leading(campaign()) == ("one", "FSB")
    assert leading(campaign(reference="").sel(tuning=["fixed", "each"])) == ("each", None)


def test_captions_name_what_is_drawn():
    """A map has hatching and a line of buckling, a curve an interval; what runs in time correct is said."""
    mapped = captions(campaign())["sweep"]
    assert "hatched" in mapped
    assert "shaded" not in mapped
    curve = campaign(gains=np.array([[-5.0], [8.0]]), thickness=(0.01,))
    assert captions(curve)["sweep"].endswith("best damper of the year; shaded: its interval.")
    for one, last in (
        (campaign(), "not viable; corrected by runs in time."),
        (curve, ", dotted: by linear theory alone."),
    ):
        one["corrected_gain_percent"] = one.gain_percent
        assert captions(one.assign_attrs(verified_tuning="one"))["sweep"].endswith(last)


@pytest.mark.parametrize(("port", "unit"), [("volume", "Pa s/m³"), ("heave", "N s/m")])
def test_a_page_of_a_take_off_of_the_volume_is_of_pressures(port, unit):
    """Tables, captions and scripts."""
    text = render(CampaignReport(campaign(port=port, study="a.yaml", campaign="c", spec_id="1"), {}))
    assert ("rms pressure [kPa]" in text, "rms force [kN]" in text) == (port == "volume", port == "heave")
    assert f"damper [{unit}]" in text
    assert ("N s/m" in text) == (port == "heave")
