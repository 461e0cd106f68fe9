"""The report page of a campaign on made-up results: statements, doubts, tables, captions."""

import pytest
from report.test_campaign_figures import by_runs, campaign

from vsb.report.campaign_page import CampaignReport, render, statements, warnings


def test_further_statements():
    each, points, beyond, practice = statements(campaign(margin=[[0.5, -0.5], [0.5, -0.5]]), "FSB", "one")
    assert "in each sea, the best flexible design, VSWEC at young modulus 100 MPa" in each
    assert points == "2 of 4 points are stable against buckling; a flexible design absorbs more at 1 of these."
    assert beyond == (
        "25 % of the energy comes from the seas crossed in the matrices: 10 % too steep, 0 % with breaking waves, "
        "40 % with shells deformed by more than a tenth of their radius."
    )
    assert practice.endswith("would change the annual energy by +12.0 to +12.0 %.")


def test_warnings_of_a_campaign():
    theory, heave = warnings(campaign())
    assert theory.startswith("All results are linear theory")
    assert heave.startswith("Seas with 90 % of the year's energy have heave amplitudes above 0.3 of the radius")
    assert warnings(campaign(margin=[[0.5, -0.5], [0.5, 0.5]]))[2].startswith("At 1 of 4 points the shell would buckle")
    ds = campaign()
    runs, coverage = warnings(by_runs(ds, ds.gain_percent, width=0.1))[:2]
    assert "coverage is 77 to 95 % with 12 seas, 89 to 96 % with 24" in coverage
    assert runs.startswith("Time-domain runs correct the answer (tuning one: 4 seas). Figures")
    _, few, _ = warnings(by_runs(ds, ds.gain_percent, width=5.1))[:3]
    assert few == "The interval of the gain of VSWEC includes zero: more verify.seas would narrow it."
    lost = campaign()
    lost["viable"] = lost.viable & (lost.design != "VSWEC")
    lost["reason"] = lost.reason.where(lost.design != "VSWEC", other="unstable: at rest")
    assert warnings(lost)[-1] == "4 of 8 combinations of design and point are not viable: unstable."


@pytest.mark.parametrize(("port", "unit"), [("pressure", "Pa s/m³"), ("force", "N s/m")])
def test_units_of_the_page_follow_the_port(port, unit):
    text = render(CampaignReport(campaign(port_kind=port, study="a.yaml", campaign="c", spec_id="1"), {}))
    assert ("rms pressure [kPa]" in text, "rms force [kN]" in text) == (port == "pressure", port == "force")
