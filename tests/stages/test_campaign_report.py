"""Stage answer: figures and report of a campaign, stamped, reproducible and accessible."""

import re
from pathlib import Path

import pytest
from browser import findings
from results.test_member import year_of
from results.test_year import climate
from stages.test_members import gather, planned, with_seas

from vsb.pipeline.plans import members
from vsb.report.campaign_answer import closing_answer
from vsb.report.html import with_minus_signs
from vsb.results.campaign import stacked
from vsb.stages import campaign_report
from vsb.tools.files import load, save
from vsb.tools.stamps import faults, read_manifest


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """A campaign over two moduli, in water given by a closed form."""
    one = planned(
        with_seas(tmp_path_factory.mktemp("campaign_report"), (1.0, 6.0)),
        {"device.young_modulus": [1e6, 1e9]},
        name="soft",
    )
    for batch, task in one.batches.items():
        spec = task.spec
        held = members(spec.base, spec.points, spec.climate, spec.tuning)
        found = [year_of(each.study, climate(8), spec.tuning) for each in held]
        save(stacked(found, [each.id for each in held]).assign_attrs(spec_id=batch), task.out)
    gather(one)
    return one


def answered(plan):
    """The files of an answer, as they are written."""
    files = (f"{plan.folder}/figures", f"{plan.folder}/report.html", plan.manifest)
    campaign_report.run_campaign_report(plan.campaign.spec, plan.data_path, plan.loaded.climate_path, plan.root, *files)
    paths = [f"{plan.folder}/report.html", *plan.report.makes[1:]]
    return {path: Path(path).read_bytes() for path in paths}


@pytest.fixture(scope="module")
def written(plan):
    """The files of the answer by path."""
    return answered(plan)


def test_report_and_figures_are_stamped(plan, written):
    assert {Path(path).stem for path in written} == {
        "report",
        "sweep",
        "spectra",
        "power_matrices",
        "tuned_power",
        "pareto",
    }
    begins = {"svg": b"<svg", "html": b"<!doctype", "csv": b"axes,series,x,y"}
    assert all(content.lstrip().startswith(begins[path.rpartition(".")[2]]) for path, content in written.items())
    assert faults(dict.fromkeys(written, plan.identity), read_manifest(plan.manifest)) == []


def test_report_states_the_answer_of_its_data(plan, written):
    page = written[f"{plan.folder}/report.html"].decode()
    words = " ".join(re.sub("<[^>]+>", " ", page).split())
    data = load(plan.data_path, expected=plan.identity)
    assert with_minus_signs(closing_answer(data)) in words
    for path in plan.report.makes[1:]:
        assert Path(path).stem in page


def test_report_is_accessible(plan, written, tmp_path):
    assert findings(written[f"{plan.folder}/report.html"].decode(), tmp_path, 360) == []
