"""What a campaign's page draws in motion is its own linear theory in one of the year's seas."""

from contextlib import chdir

import numpy as np
import pytest
from browser import asked
from stages.test_living_year import swept  # noqa: F401
from stages.test_members import folder  # noqa: F401

from vsb.report.animation import PERIODS
from vsb.report.campaign_answer import leading
from vsb.report.campaign_page import STILL, CampaignReport, render
from vsb.stages import moving_year as module
from vsb.stages.climate import read_climate
from vsb.stages.moving_year import most_energetic, moving_year
from vsb.waves.climate import realised


def moved(swept):  # noqa: F811
    plan, ds = swept
    with chdir(plan.root + "/.."):
        seas = read_climate(plan.climate, plan.loaded.climate_path)
        return moving_year(plan.campaign, ds, *leading(ds), seas, plan.root)


def test_the_sea_is_of_the_bin_that_brings_most_energy(swept):  # noqa: F811
    """Of seas of 1, 2.2, 2.3 and 3.1 m two share a bin, and together bring less than the last."""
    plan, ds = swept
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    sea, row, column = most_energetic(seas, plan.members[0].study.water)
    assert sea == int(seas.hs.argmax())
    assert float(ds.hs[row]) == pytest.approx(seas.hs[sea], abs=0.25)
    assert float(ds.te[column]) == pytest.approx(seas.te[sea], abs=0.5)


def test_every_design_moves_as_long_as_is_said_and_the_page_says_in_what(swept, tmp_path, monkeypatch):  # noqa: F811
    plan, ds = swept
    made = []
    monkeypatch.setattr(module, "realised", lambda *given: made.append(given) or realised(*given))
    data = moved(swept)
    ((seas, index, duration, *_),) = made
    assert duration == pytest.approx(PERIODS * seas.te[index])
    assert [design["name"] for design in data["designs"]] == list(ds.design.values)
    (sea,) = data["seas"]
    assert "most energy (Hs 3.1 m, Te 1" in sea["words"]
    assert sea["step"] * (sea["frames"] - 1) == pytest.approx(
        PERIODS * read_climate(plan.climate, plan.loaded.climate_path).te.max(), rel=1e-6
    )
    assert [design["modes"] for design in sea["designs"]] == [0, 3]
    with open(f"{plan.folder}/report.html", encoding="utf-8") as file:
        page = file.read()
    script = """
      const text = document.querySelector("#buoys > p:last-child").textContent;
      return { errors, shown: !document.getElementById("buoys").hidden, text };"""
    found = asked(page, script, tmp_path)
    assert (found["errors"], found["shown"]) == ([], True)
    assert "by linear theory, each design at its own best damper of the year at thickness 0.0" in found["text"]


def test_where_nothing_can_move_the_page_says_so(swept, monkeypatch):  # noqa: F811
    plan, ds = swept
    monkeypatch.setattr(module, "looked_at", lambda *_: None)
    assert moved(swept) is None
    assert STILL in render(CampaignReport(ds, {}))
    monkeypatch.undo()
    unknown = ds.assign(damping=np.nan * ds.damping)
    with chdir(plan.root + "/.."):
        seas = read_climate(plan.climate, plan.loaded.climate_path)
        assert moving_year(plan.campaign, unknown, *leading(ds), seas, plan.root) is None
