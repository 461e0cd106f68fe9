"""The interactive chart of a page: it computes the powers of the study, and fits a phone."""

import json

import numpy as np
import pytest
from browser import asked, evaluated
from conftest import varied

from vsb.engine.waves.kinds import Jonswap, RegularWave
from vsb.report import html
from vsb.stages.report import interactive_study, no_slider
from vsb.tools.files import load


def living(plan, study=None, limited=()):
    """Data of the page of a study, or of another one of the same buoy."""
    return interactive_study(study or plan.study, plan.database.out, load(plan.response.out), limited)


@pytest.fixture
def tables(small):
    with open(f"{small.folder}/tables.json", encoding="utf-8") as file:
        return json.load(file)


def test_page_computes_the_optimal_powers_of_the_study(small, tables, tmp_path):
    data = living(small, limited=tables["within_limits"])
    expression = """data.seas.map((sea) => {
      const grid = unpackedGrid(data.grids[sea.grid]);
      const squares = seaSquares(sea, grid);
      return grid.ports.map((port) => power(port, squares, bestDamper(port, squares)));
    })"""
    found = evaluated([html.text_of("algebra.js")], expression, data, tmp_path)
    assert np.ravel(found) == pytest.approx([line["best_power"] for line in tables["equal_tuning"]], rel=1e-6)
    assert [design["name"] for design in data["designs"]] == list(small.study.designs)
    assert [design["name"] for design in data["designs"] if design["reference"]] == [small.study.reference_design]


def test_sea_of_a_spectrum_has_the_energy_of_its_height(small, tmp_path):
    data = living(small, small.study.model_copy(update={"waves": (Jonswap(kind="jonswap", hs=0.4, tp=4.0),)}))
    expression = "Array.from(seaSquares(data.seas[0], unpackedGrid(data.grids[0])))"
    squares = evaluated([html.text_of("algebra.js")], expression, data, tmp_path)
    assert 4 * np.sqrt(np.sum(squares) / 2) == pytest.approx(0.4, rel=0.01)


def test_seas_from_two_directions_have_their_own_ports(small):
    """With equal numbers for a buoy in heave, which is axisymmetric."""
    wave = RegularWave(kind="regular", amplitude=0.1, period=3.0)
    aside, higher = (wave.model_copy(update=more) for more in ({"direction": 90.0}, {"amplitude": 0.2}))
    data = living(small, small.study.model_copy(update={"waves": (wave, aside, higher)}))
    assert [(sea["grid"], sea["band"]) for sea in data["seas"]] == [(0, 0), (1, 1), (0, 0)]
    assert data["grids"][0] == data["grids"][1]
    assert data["bands"][0] == data["bands"][1]


def test_no_interactive_chart_where_damping_does_not_determine_power(small):
    still = varied(small.study, waves=[{"kind": "still"}])
    lossy = varied(small.study, pto={"damping": 8000.0, "stiffness": 100.0, "efficiency": 0.8})
    dry = varied(small.study, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    dragged = varied(small.study, drag={"heave": {"coefficient": 1.0, "area": 12.0}})
    spread = small.study.model_copy(update={"waves": (Jonswap(kind="jonswap", hs=1.0, tp=4.0, spreading={"s": 10.0}),)})
    for study in (still, lossy, dry, dragged, spread):
        assert living(small, study) is None
    for study, why in ((lossy, "reactive power"), (dragged, "drag"), (spread, "many directions")):
        assert why in no_slider(study)
    for pto in ({"stiffness": 100.0}, {"efficiency": 0.8}):  # a spring or losses alone leave the damper's power known
        assert living(small, varied(small.study, pto=pto)) is not None


def test_page_fits_a_phone_with_readable_figures_and_no_script_errors(small, tmp_path):
    """Letters are at least 9 pixels high: wide figures scroll in boxes of their own."""
    with open(f"{small.folder}/report.html", encoding="utf-8") as file:
        page = file.read()
    script = """
      for (const folded of document.querySelectorAll("details")) folded.open = true;
      const size = (text) => {
        const { a, b } = text.getScreenCTM();
        return parseFloat(getComputedStyle(text).fontSize) * Math.hypot(a, b);
      };
      const least = (where) => Math.min(...[...document.querySelectorAll(`${where} svg text`)].map(size));
      const hidden = document.getElementById("live").hidden, wide = document.documentElement.scrollWidth;
      return { errors, hidden, wide, drawn: least(".drawn"), charts: least(".chart") };"""
    found = asked(page, script, tmp_path, width=360)
    assert (found["errors"], found["hidden"], found["wide"]) == ([], False, 360)
    assert min(found["drawn"], found["charts"]) >= 9
