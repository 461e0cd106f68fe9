"""Words of a campaign's report, of results made up by hand: the answer, what else is said, what to doubt, the table."""

import re

import numpy as np
import pytest
import xarray as xr
from report.test_campaign_figures import GAINS, by_runs, campaign

from vsb.report.campaign_answer import TUNED
from vsb.report.campaign_page import MOST_ROWS, STILL, CampaignReport, captions, render, rows, statements, warnings


def test_what_else_is_said():
    each, points, beyond, practice = statements(campaign(margin=[[0.5, -0.5], [0.5, -0.5]]), "FSB", "one")
    assert each.startswith("Each design at its own optimal damper in each sea, it is VSWEC at young modulus 100 MPa")
    assert points == ("2 of 4 points carry their static load without buckling; flexibility pays at 1 of these.")
    assert beyond == (
        "25 % of the energy is from seas beyond what is described, crossed in the matrices: 10 % too steep, 0 % with "
        "waves that break, 40 % with shells deformed by more than a tenth of their radius."
    )
    assert practice.endswith("would have said +12.0 to +12.0 % of the annual energy.")


def test_numbers_stand_right_where_a_column_of_words_is_left_out():
    """Of a campaign of one point the first column is: the first of numbers once stood as words do."""
    point = campaign().isel(young_modulus=[0], thickness=[0]).squeeze(drop=True)
    for ds, count in ((campaign(), 3), (point.assign_attrs(varied=""), 2)):
        text = render(CampaignReport(ds, {}))
        row = re.search(r"<tbody><tr>(.*?)</tr>", text[text.index("designs over the year") :]).group(1)
        assert [' class="text"' in cell for cell in re.findall(r"<td[^>]*>", row)] == [True] * count + [False] * 5


def test_a_part_of_a_year_is_doubted():
    notes = ("8 spectra used", "50 days stand for a year: seasons are missing")
    text = render(CampaignReport(campaign(), {}, notes=notes))
    assert "<li>Of the climate, 50 days stand for a year: seasons are missing.</li>" in text
    assert "Of the climate, 8" not in text


def test_numbers_of_the_table_have_no_exponents():
    cells = [cell for row in rows(campaign(margin=-2163.0)) for cell in row[3:]]
    assert "-2163" in cells
    assert not any("e+" in cell for cell in cells)


@pytest.mark.parametrize("scale", [1e-9, 1e-5, 1e6])
def test_what_is_said_of_usual_practice_knows_no_units(scale):
    """A buoy of a tank absorbs milliwatts; where a design absorbs nothing there is no part of it."""
    ds = campaign()
    of_powers = {name: scale * ds[name] for name in ("annual_mean_power", "practice_power")}
    assert statements(ds.assign(of_powers), "FSB", "one")[-1] == statements(ds, "FSB", "one")[-1]
    of_powers["annual_mean_power"][{"design": 1}] = 0.0
    assert "would have said +12.0 to +12.0 % of" in statements(ds.assign(of_powers), "FSB", "one")[-1]


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
    ds = campaign()
    runs, coverage = warnings(by_runs(ds, ds.gain_percent, width=0.1))[:2]
    assert "they are not: coverage 77 to 95 % with 12 seas, 89 to 96 % with 24" in coverage
    assert runs.startswith("Runs in time correct tuning one: 4 seas. Figures")
    _, few, _ = warnings(by_runs(ds, ds.gain_percent, width=5.1))[:3]
    assert few == "The interval of the gain of VSWEC includes none: more verify.seas would narrow it."
    lost = campaign()
    lost["viable"] = lost.viable & (lost.design != "VSWEC")
    lost["reason"] = lost.reason.where(lost.design != "VSWEC", other="unstable: at rest")
    assert warnings(lost)[-1] == "4 of 8 designs at their points are not viable: unstable."


def test_the_table_has_a_row_for_every_point_design_and_tuning():
    found = rows(campaign())
    assert len(found) == 24 == MOST_ROWS
    assert found[4] == ["young modulus 1 MPa, thickness 0.01 m", "VSWEC", "one", "83.28", "0.95", "-5.0", "2", "0.5"]
    ds = campaign()
    told = rows(by_runs(ds, ds.gain_percent - 2.0))
    assert [row[-1] for row in told[3:6]] == ["-", "-7.0 (-7.5 to -6.5)", "-"]
    missing = campaign()
    missing["annual_energy"] = missing.annual_energy.where(missing.design != "VSWEC")
    assert rows(missing)[4][3] == "-"
    assert len(rows(campaign(gains=np.tile(GAINS, (2, 1)), modulus=(1.0, 2.0, 3.0, 4.0)))) == MOST_ROWS


def test_rows_that_are_left_out_are_counted():
    long = campaign(gains=np.tile(GAINS, (2, 1)), modulus=(1.0, 2.0, 3.0, 4.0))
    for ds, left_out in ((campaign(), []), (long, ["24 more rows in campaign.csv"])):
        text = render(CampaignReport(ds.assign_attrs(study="a.yaml", campaign="c", spec_id="1"), {}))
        assert re.findall(r"-?\d+ more rows in campaign\.csv", text) == left_out


def test_captions_name_what_is_drawn():
    """A map has hatching and a line of buckling, a curve an interval; what runs in time correct is said."""
    mapped = captions(campaign())["sweep"]
    assert "hatched" in mapped
    assert "shaded" not in mapped
    curve = campaign(gains=np.array([[-5.0], [8.0]]), thickness=(0.01,))
    assert captions(curve)["sweep"].endswith("optimal damper of the year; shaded: its interval.")
    for one, last in (
        (campaign(), "not viable; corrected by runs in time."),
        (curve, ", dotted: by linear theory alone."),
    ):
        assert captions(by_runs(one, one.gain_percent))["sweep"].endswith(last)


@pytest.mark.parametrize(("port", "unit"), [("volume", "Pa s/m³"), ("heave", "N s/m")])
def test_a_page_of_a_take_off_of_the_volume_is_of_pressures(port, unit):
    """Tables, captions and scripts."""
    text = render(CampaignReport(campaign(port=port, study="a.yaml", campaign="c", spec_id="1"), {}))
    assert ("rms pressure [kPa]" in text, "rms force [kN]" in text) == (port == "volume", port == "heave")
    assert f"damper [{unit}]" in text
    assert ("N s/m" in text) == (port == "heave")


@pytest.mark.parametrize(
    ("known", "impossible", "told"),
    [
        (1.0, 0.0, []),
        (1 - 5e-10, 0.0, []),  # round-off of a sum of shares
        (1 - 2e-9, 0.0, ["Optima were found in bins of 99.9 % of the energy flux alone: raise constrained.seconds."]),
        (0.6259, 0.0, ["Optima were found in bins of 62.5 % of the energy flux alone: raise constrained.seconds."]),
        (1.0, 0.034, ["In up to 3.4 % of the year no force keeps the stroke within its limit: counted as nothing."]),
    ],
)
def test_optima_within_limits_are_doubted_by_the_worst_of_all_designs_at_all_points(known, impossible, told):
    """One design at one point does it; what is known of a part is never said to be known of all."""
    ds = campaign().assign_coords(tuning=["fixed", "one", "constrained"])
    by, place = ("young_modulus", "thickness", "design"), (1, 0, 1)
    shares = np.ones((2, 2, 2)), np.zeros((2, 2, 2))
    shares[0][place], shares[1][place] = known, impossible
    ds = ds.assign(optimum_share=(by, shares[0]), impossible_share=(by, shares[1]))
    always = "The best force within limits knows all waves beforehand: no control takes more, few come near."
    assert warnings(ds)[2:] == [always, *told]


@pytest.mark.parametrize(
    ("margin", "told"),
    [(0.0, []), (-1.5, ["The shell would buckle under its static load, 2.5 times what it carries."])],
)
def test_a_shell_of_a_single_point_that_buckles_is_told_by_how_much(margin, told):
    """One less the margin is the load over what is carried, and none buckles at a margin of zero."""
    point = campaign(margin=margin).isel(young_modulus=[0], thickness=[0]).squeeze(drop=True)
    assert warnings(point.assign_attrs(varied=""))[2:] == told


def test_of_reasons_each_is_told_once_without_its_numbers():
    lost = campaign()
    lost["viable"] = lost.viable & (lost.design != "VSWEC")
    for place, text in enumerate(("unstable: at rest", "sinks: 3 kN too heavy", "unstable: in waves", "sinks: 4 kN")):
        lost.reason[divmod(place, 2)][{"design": 1}] = text
    assert warnings(lost)[-1] == "4 of 8 designs at their points are not viable: sinks, unstable."


def test_points_are_counted_where_there_are_several_and_a_rigid_design_to_be_better_than():
    """The second sentence says them where nothing else is told there."""
    several, one = campaign(), campaign().isel(young_modulus=[0], thickness=[0])
    alone = several.sel(tuning=["one"])
    for ds, reference, told in ((several, "FSB", 1), (one, "FSB", 0), (several, None, 0), (alone, "FSB", 0)):
        assert sum("carry their static load" in line for line in statements(ds, reference, "one")) == told


def test_every_note_of_the_climate_stands_among_the_facts_and_is_doubted_wherever_it_stands():
    partial, used = "50 days stand for a year: seasons are missing", "8 spectra used"
    for notes in ((partial, used), (used, partial), (partial,)):
        text = render(CampaignReport(campaign(), {}, notes=notes))
        assert text.count(f"<li>Of the climate, {partial}.</li>") == 1
        assert "; ".join(["a buoy", *notes]) in text


def of_tunings(*values):
    return xr.DataArray(list(values), {"tuning": ["fixed", "one", "each"]}, ("tuning",))


def test_captions_say_at_which_point_and_tuning_curves_are_and_what_squares_are():
    told, at = captions(campaign()), " at young modulus 100 MPa, thickness 0.01 m"
    assert f"{TUNED['one']}{at}; white:" in told["power_matrices"]
    assert f"for all seas{at}; full:" in told["tuned_power"]
    assert told["pareto"].endswith(f"force{at}, over the damper up to the best one, without limits.")
    assert told["sweep"].startswith(f"Gain of annual energy over the rigid design, {TUNED['one']}.")
    within = captions(campaign().assign_coords(tuning=["fixed", "one", "constrained"]))["pareto"]
    assert within.endswith("without limits. Squares: the best force within each limit.")
    point = campaign().isel(young_modulus=[0], thickness=[0]).squeeze(drop=True).assign_attrs(varied="")
    assert "for all seas; full:" in captions(point)["tuned_power"]


def test_what_else_is_said_is_of_the_tuning_the_answer_is_of():
    """Shares of energy, the heave that is doubted, and from which to which they reach over designs and points."""
    ds = campaign()
    ds["energy_beyond"] = ds.energy_beyond * of_tunings(0.5, 1.0, 2.0)
    ds["energy_beyond"] = ds.energy_beyond.where(ds.design == "FSB", ds.energy_beyond / 2)
    ds["energy_beyond_validity"] = ds.energy_beyond_validity * of_tunings(0.4, 1.0, 2.0)
    for tuning, whole, parts in (("fixed", 10, ("2 to 5", "0", "10 to 20")), ("one", 25, ("5 to 10", "0", "20 to 40"))):
        (told,) = (line for line in statements(ds, "FSB", tuning) if "crossed in the matrices" in line)
        assert told.startswith(f"{whole} % of the energy")
        steep, breaking, deformed = parts
        assert f": {steep} % too steep, {breaking} % with waves that break, {deformed} % with shells deformed" in told
    assert warnings(ds)[1].startswith("In seas that bring 45 to 90 % of the energy the buoy heaves")
    assert warnings(ds.sel(tuning=["fixed"]))[1].startswith("In seas that bring 22 to 45 % of the energy the buoy")


def test_usual_practice_may_say_less_and_is_told_from_its_least_to_its_most():
    ds = campaign()
    less = xr.DataArray([0.7, 0.9], {"design": ["FSB", "VSWEC"]}, ("design",))
    ds["practice_power"] = ds.annual_mean_power * less
    assert statements(ds, "FSB", "one")[-1].endswith("would have said -30.0 to -10.0 % of the annual energy.")
    ds["practice_power"] = ds.annual_mean_power * (2 - less)
    assert statements(ds, "FSB", "one")[-1].endswith("would have said +10.0 to +30.0 % of the annual energy.")


def test_of_a_campaign_without_a_viable_design_nothing_more_is_said():
    lost = campaign()
    lost["viable"] = lost.viable & False
    assert statements(lost, "FSB", "one") == []
    assert not any("heaves" in line for line in warnings(lost))
    one = campaign()
    one["viable"] = one.viable & (one.design == "FSB")
    assert statements(one, "FSB", "one")
    assert any("heaves" in line for line in warnings(one))


def test_a_row_tells_numbers_of_its_own_point_design_and_tuning():
    """Force in kilonewtons; without a rigid design there is no gain."""
    ds = campaign(margin=[[0.1, 0.2], [0.3, 0.4]])
    ds["force_rms"] = ds.force_rms * of_tunings(1.0, 2.0, 3.0)
    ds["capture_width"] = ds.capture_width * of_tunings(0.5, 1.0, 123.456)
    found = rows(ds)
    assert found[11] == ["young modulus 1 MPa, thickness 0.02 m", "VSWEC", "each", "89.41", "126", "+2.0", "6", "0.2"]
    assert found[12] == ["young modulus 100 MPa, thickness 0.01 m", "FSB", "fixed", "87.66", "0.5", "+0.0", "2", "0.3"]
    assert [row[5] for row in rows(ds.drop_vars("gain_percent"))] == ["-"] * 24


def test_a_page_names_its_campaign_tunings_study_and_id_and_says_why_nothing_moves():
    ds = campaign(study="a.yaml", campaign="a_year", spec_id="0123")
    text = render(CampaignReport(ds, {"sweep": "<svg>drawn</svg>"}))
    told = [f"{name}, {TUNED[name]}" for name in ("fixed", "one", "each")]
    assert f"Tunings: {'; '.join(told)}." in text
    for part in ("a_year", "a.yaml", "0123", "<svg>drawn</svg>", STILL, "VSWEC absorbs", "All at the given damper"):
        assert part in text.replace("VSWEC at young modulus 100 MPa, thickness 0.01 m, absorbs", "VSWEC absorbs"), part
    moving = {"designs": [{"name": "FSB"}], "factor": 1.0, "seas": [{"calm": True, "designs": []}]}
    sketch = {"name": "soft one", "words": "elastic shell, free", "svg": "<svg>sketched</svg>"}
    more = render(CampaignReport(ds, {}, {"kind": "year", "here": 1}, [sketch], moving))
    assert STILL not in more
    for part in ("FSB side by side; all is to scale.", '"here":1', "elastic shell, free"):
        assert part in more, part


def test_the_table_of_one_key_has_a_row_for_each_of_its_values():
    ds = campaign().isel(thickness=0, drop=True).assign_attrs(varied="young_modulus")
    found = rows(ds)
    assert [row[0] for row in found] == ["young modulus 1 MPa"] * 6 + ["young modulus 100 MPa"] * 6
    assert [row[5] for row in found[3:6]] == ["-5.0"] * 3
    point = ds.isel(young_modulus=[1]).squeeze(drop=True).assign_attrs(varied="")
    assert [row[0] for row in rows(point)] == ["-"] * 6


def test_usual_practice_is_told_where_one_design_alone_differs_from_it():
    ds = campaign()
    for part in (1.2, 0.8):
        ds["practice_power"] = ds.annual_mean_power * xr.DataArray(
            [1.0, part], {"design": ["FSB", "VSWEC"]}, ("design",)
        )
        low, high = sorted((0.0, 100 * (part - 1)))
        assert statements(ds, "FSB", "one")[-1].endswith(
            f"would have said {low:+.1f} to {high:+.1f} % of the annual energy."
        )


def test_of_further_tunings_each_has_its_own_best_design_and_gain():
    """In their order; what stands in the answer or the second sentence is not said again."""
    ds = campaign()
    ds["gain_percent"] = ds.gain_percent * of_tunings(1.0, 1.0, -1.0)
    (each,) = (line for line in statements(ds, "FSB", "one") if "it is" in line)
    assert each.endswith("in each sea, it is VSWEC at young modulus 1 MPa, thickness 0.01 m with +5.0 %.")
    less = ds.assign(gain_percent=ds.gain_percent - 20.0)
    (each,) = (line for line in statements(less, "FSB", "one") if "it is" in line)
    assert each.endswith("with -15.0 %.")
    told = [line for line in statements(ds, "FSB", "each") if "it is" in line]
    assert [line.partition(", it is")[0] for line in told] == [TUNED["one"].capitalize()]


def test_what_is_not_said_leaves_no_empty_line(monkeypatch):
    ds = campaign().sel(tuning=["one"]).isel(young_modulus=0, thickness=0, drop=True)
    lost = ds.assign(energy_beyond_validity=ds.energy_beyond_validity * np.nan).assign_attrs(varied="")
    seen = []
    monkeypatch.setattr("vsb.report.campaign_page.page", lambda template, **given: seen.append(given) or "")
    for one, count in ((ds.assign_attrs(varied=""), 2), (lost, 1)):
        render(CampaignReport(one, {}))
        assert len(seen[-1]["answer"]) == count
        assert all(seen[-1]["answer"])
