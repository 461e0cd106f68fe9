"""The report page of a campaign on made-up results: statements, doubts, tables, captions."""

import numpy as np
import pytest
from report.test_campaign_figures import GAINS, by_runs, campaign

from vsb.report.campaign_answer import TUNED
from vsb.report.campaign_page import MOST_ROWS, STILL, CampaignReport, render, rows, statements, warnings


def test_further_statements():
    each, points, beyond, practice = statements(campaign(margin=[[0.5, -0.5], [0.5, -0.5]]), "FSB", "one")
    assert each.startswith("Each design at its optimal damping in each sea: VSWEC at young modulus 100 MPa")
    assert points == ("2 of 4 points carry their static load without buckling; flexibility pays at 1 of these.")
    assert beyond == (
        "25 % of the energy comes from seas beyond the validity of linear theory, crossed in the matrices: 10 % too "
        "steep, 0 % with breaking waves, 40 % with shells deformed by more than a tenth of their radius."
    )
    assert practice.endswith("would change the annual energy by +12.0 to +12.0 %.")


def test_warnings_of_a_campaign():
    theory, heave = warnings(campaign())
    assert theory.startswith("All results are linear theory")
    assert heave.startswith("In seas that bring 90 % of the energy the heave amplitude exceeds 0.3 of the radius")
    assert warnings(campaign(margin=[[0.5, -0.5], [0.5, 0.5]]))[2].startswith("At 1 of 4 points the shell would buckle")
    ds = campaign()
    runs, coverage = warnings(by_runs(ds, ds.gain_percent, width=0.1))[:2]
    assert "coverage is 77 to 95 % with 12 seas, 89 to 96 % with 24" in coverage
    assert runs.startswith("Time-domain runs correct tuning one: 4 seas. Figures")
    _, few, _ = warnings(by_runs(ds, ds.gain_percent, width=5.1))[:3]
    assert few == "The interval of the gain of VSWEC includes zero: more verify.seas would narrow it."
    lost = campaign()
    lost["viable"] = lost.viable & (lost.design != "VSWEC")
    lost["reason"] = lost.reason.where(lost.design != "VSWEC", other="unstable: at rest")
    assert warnings(lost)[-1] == "4 of 8 combinations of design and point are not viable: unstable."


def test_table_has_a_row_for_every_point_design_and_tuning():
    found = rows(campaign())
    assert len(found) == 24 == MOST_ROWS
    assert found[4] == ["young modulus 1 MPa, thickness 0.01 m", "VSWEC", "one", "83.28", "0.95", "-5.0", "2", "0.5"]
    ds = campaign()
    text = rows(by_runs(ds, ds.gain_percent - 2.0))
    assert [row[-1] for row in text[3:6]] == ["-", "-7.0 (-7.5 to -6.5)", "-"]
    missing = campaign()
    missing["annual_energy"] = missing.annual_energy.where(missing.design != "VSWEC")
    assert rows(missing)[4][3] == "-"
    assert len(rows(campaign(gains=np.tile(GAINS, (2, 1)), modulus=(1.0, 2.0, 3.0, 4.0)))) == MOST_ROWS


@pytest.mark.parametrize(("port", "unit"), [("pressure", "Pa s/m³"), ("force", "N s/m")])
def test_units_of_the_page_follow_the_port(port, unit):
    text = render(CampaignReport(campaign(port_kind=port, study="a.yaml", campaign="c", spec_id="1"), {}))
    assert ("rms pressure [kPa]" in text, "rms force [kN]" in text) == (port == "pressure", port == "force")


@pytest.mark.parametrize(
    ("known", "impossible", "expected"),
    [
        (1.0, 0.0, []),
        (1 - 5e-10, 0.0, []),  # round-off of a sum of shares
        (
            1 - 2e-9,
            0.0,
            ["Optima were computed in bins with 99.9 % of the energy flux only: raise constrained.seconds."],
        ),
        (0.6259, 0.0, ["Optima were computed in bins with 62.5 % of the energy flux only: raise constrained.seconds."]),
        (1.0, 0.034, ["In up to 3.4 % of the year no force keeps the stroke within its limit: counted as zero power."]),
    ],
)
def test_incomplete_constrained_optima_are_doubted(known, impossible, expected):
    """One incomplete optimum is enough for a warning."""
    ds = campaign().assign_coords(tuning=["fixed", "one", "constrained"])
    by, place = ("young_modulus", "thickness", "design"), (1, 0, 1)
    shares = np.ones((2, 2, 2)), np.zeros((2, 2, 2))
    shares[0][place], shares[1][place] = known, impossible
    ds = ds.assign(optimum_share=(by, shares[0]), impossible_share=(by, shares[1]))
    always = "The optimal force within limits knows all waves in advance: it is an upper bound for any controller."
    assert warnings(ds)[2:] == [always, *expected]


def test_page_names_campaign_tunings_study_and_id():
    ds = campaign(study="a.yaml", campaign="a_year", spec_id="0123")
    text = render(CampaignReport(ds, {"sweep": "<svg>drawn</svg>"}))
    expected = [f"{name}, {TUNED[name]}" for name in ("fixed", "one", "each")]
    assert f"Tunings: {'; '.join(expected)}." in text
    for part in ("a_year", "a.yaml", "0123", "<svg>drawn</svg>", STILL, "VSWEC absorbs", "All at the given damping"):
        assert part in text.replace("VSWEC at young modulus 100 MPa, thickness 0.01 m, absorbs", "VSWEC absorbs"), part
    moving = {"designs": [{"name": "FSB"}], "factor": 1.0, "seas": [{"calm": True, "designs": []}]}
    sketch = {"name": "soft one", "words": "elastic shell, free", "svg": "<svg>sketched</svg>"}
    more = render(CampaignReport(ds, {}, {"kind": "year", "here": 1}, [sketch], moving))
    assert STILL not in more
    for part in ("FSB side by side; all is to scale.", '"here":1', "elastic shell, free"):
        assert part in more, part
