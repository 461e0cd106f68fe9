"""Figures and report of a campaign: all that is promised, each stamped, of its own data alone, the same every time."""

import html
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from browser import findings
from results.test_year import climate
from scenes.test_ports import water
from stages.test_members import gather, planned, with_seas

from vsb.errors import DatabaseError
from vsb.report.campaign_answer import closing_answer
from vsb.results.campaign import stacked
from vsb.results.member import member
from vsb.stages import answer
from vsb.stages.climate import read_climate
from vsb.study.campaign_plan import members
from vsb.tools.files import load, save
from vsb.tools.stamps import faults, read_manifest

OMEGA = np.arange(0.1, 3.0, 0.02)


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """A campaign over two moduli, its members those of water that only one ring of the shell feels."""
    one = planned(
        with_seas(tmp_path_factory.mktemp("answer"), (1.0, 6.0)), {"device.young_modulus": [1e6, 1e9]}, name="soft"
    )
    for batch, spec in one.batches.items():
        held = members(spec.base, spec.points, spec.climate, spec.tuning)
        found = [
            member(each.study, lambda basis, s=each.study: water(s, omega=OMEGA), climate(8), spec.tuning)
            for each in held
        ]
        save(stacked(found, [each.id for each in held]).assign_attrs(spec_id=batch), one.batch_path(batch))
    gather(one)
    return one


def answered(plan):
    """The files of an answer, as they are written."""
    files = (f"{plan.folder}/figures", f"{plan.folder}/report.html", plan.manifest)
    answer.run(plan.campaign, plan.data_path, plan.loaded.climate_path, plan.root, *files)
    paths = [f"{plan.folder}/report.html", *plan.figure_paths]
    return {path: Path(path).read_bytes() for path in paths}


@pytest.fixture(scope="module")
def written(plan):
    """The files of the answer by path."""
    return answered(plan)


def test_the_page_says_what_the_climates_file_lacks(plan, written):
    """Of what is left out, `vsb check` told alone."""
    notes = read_climate(plan.campaign.climate, plan.loaded.climate_path).notes
    assert len(notes) > 2
    told = "; ".join([plan.campaign.climate_name, *notes])
    assert told in html.unescape(written[f"{plan.folder}/report.html"].decode())


def test_all_that_is_promised_is_there_and_stamped(plan, written):
    assert {Path(path).stem for path in written} == {
        "report",
        "sweep",
        "spectra",
        "power_matrices",
        "tuned_power",
        "pareto",
    }
    begins = {"svg": b"<svg", "html": b"<!doctype", "pdf": b"%PDF", "csv": b"axes,series,x,y"}
    assert all(content.lstrip().startswith(begins[path.rpartition(".")[2]]) for path, content in written.items())
    assert faults(dict.fromkeys(written, plan.campaign_id), read_manifest(plan.manifest)) == []


def test_the_report_says_the_answer_of_its_data(plan, written):
    page = written[f"{plan.folder}/report.html"].decode()
    words = " ".join(re.sub("<[^>]+>", " ", page).split())
    data = load(plan.data_path, expected=plan.campaign_id)
    assert closing_answer(data) in words
    for path in plan.figure_paths:
        assert Path(path).stem in page


def test_figures_are_the_same_every_time_and_leave_the_callers_alone(plan, written):
    """No date, no random names; whoever draws figures of his own keeps their looks."""
    with mpl.rc_context({"axes.grid": True, "font.size": 31.0, "svg.hashsalt": None}):
        assert answered(plan) == written
        assert mpl.rcParams["font.size"] == 31.0


def test_data_of_another_campaign_are_refused(plan, tmp_path):
    other = tmp_path / "campaign.nc"
    save(load(plan.data_path).assign_attrs(spec_id="0" * 16), other)
    files = (str(tmp_path), str(tmp_path / "report.html"), str(tmp_path / "m.json"))
    with pytest.raises(DatabaseError, match=f"holds '0{{16}}', needs '{plan.campaign_id}'"):
        answer.run(plan.campaign, str(other), plan.loaded.climate_path, plan.root, *files)
    assert [path.name for path in tmp_path.iterdir()] == ["campaign.nc"]


def test_readers_who_do_not_see_the_page_lose_nothing(plan, written, tmp_path):
    assert findings(written[f"{plan.folder}/report.html"].decode(), tmp_path, 360) == []


def test_every_figure_is_that_of_its_name_at_the_tuning_of_the_answer(monkeypatch):
    """Of the results, but for the spectra, which are those of the seas."""
    monkeypatch.setattr(answer, "leading", lambda ds: ("one", f"rigid of {ds}"))
    monkeypatch.setattr(answer, "year_spectra", lambda seas: f"spectra of {seas}")
    monkeypatch.setattr(answer, "DRAWN", {name: lambda *given, name=name: (name, *given) for name in answer.DRAWN})
    monkeypatch.setattr(answer, "drawn", lambda figure, name: (name, figure))
    names = ["tuned_power", "spectra", "sweep", "pareto", "power_matrices"]
    found = answer._drawn(names, "results", "seas")
    own = {name: (name, "results", "one", "rigid of results") for name in names} | {"spectra": "spectra of seas"}
    assert list(found.items()) == [(name, (name, own[name])) for name in names]
