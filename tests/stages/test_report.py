"""Stages figures and report: figures, page, animation and interactive chart of a study."""

import html
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from browser import asked, evaluated, findings
from conftest import varied

import vsb
from vsb.cli import main
from vsb.engine.waves.kinds import Jonswap, RegularWave
from vsb.report import page as pages
from vsb.report.answer import NO_OPTIMUM
from vsb.report.interactive import PER_PERIOD, PERIODS, packed
from vsb.results.ledger import assumed_pressure_checks
from vsb.stages import report
from vsb.stages.report import ANIMATED_SEAS, animated_study, interactive_study, no_slider
from vsb.stages.stored import Inputs
from vsb.study.figure_names import FIGURE_KINDS, of_study
from vsb.tools.files import load


def test_study_with_assumed_pressure_from_file_to_page(small, tmp_path, monkeypatch):
    """Without database, response and control levels."""
    monkeypatch.chdir(tmp_path)
    study = varied(small.study, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    study = varied(study, simulation={"duration": 3.0, "window": [1.0, 3.0]})
    vsb.run(study)
    tables = json.loads(Path("results/small/tables.json").read_text())
    assert [row["design"] for row in tables["comparison"]] == ["FSB", "VSWEC"]
    assert (tables["equal_tuning"], tables["within_limits"], tables["statistics"]) == ([], [], [])
    names = {check["name"] for check in tables["checks"]}
    assert {check.name for check in assumed_pressure_checks(study, tables["comparison"])} <= names
    assert not {"radiation_fit", "power_limit"} & names
    page = Path("results/small/report.html").read_text()
    assert NO_OPTIMUM in html.unescape(page)
    assert "uniform pressure of 1800 Pa on the instantaneous wet shell" in page


def test_page_names_program_command_and_inputs(small):
    """Each input by its content."""
    facts = dict(
        re.findall(
            r'<tr><th class="text" scope="row">(.*?)</th><td class="text id">(.*?)</td>',
            Path("results/small/report.html").read_text(),
        )
    )
    assert facts["Program"].startswith(f"vsb {vsb.__version__}, ")
    assert facts["Command"].startswith("vsb run small.yaml, ")
    known = (small.identity, Path(small.database.out).stem, Path(small.radiation.out).stem)
    assert facts["Inputs"] == "study {}, database {}, radiation {}".format(*known)


VOID = {"meta", "br", "hr", "input", "link", "img"}


class Page(HTMLParser):
    """Tags of a page: those that do not match, identifiers, addresses, drawings."""

    def __init__(self, text):
        super().__init__()
        self.open, self.wrong, self.ids, self.addresses, self.drawings = [], [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.open += [] if tag in VOID else [tag]
        self.ids += [found["id"]] if "id" in found else []
        self.addresses += [found[key] for key in ("href", "src", "xlink:href") if key in found]
        self.drawings += [found] if tag == "svg" else []

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.open = self.open if tag in VOID else self.open[:-1]

    def handle_endtag(self, tag):
        self.wrong += [] if self.open and self.open.pop() == tag else [tag]


def test_page_is_valid_html_without_external_resources(small):
    text = Path(f"{small.folder}/report.html").read_text()
    page = Page(text)
    assert (page.wrong, page.open) == ([], [])
    assert len(set(page.ids)) == len(page.ids)
    assert {one[1:] for one in page.addresses if one.startswith("#")} <= set(page.ids)
    outside = [one for one in page.addresses if not one.startswith(("#", "data:text/csv", "figures/"))]
    assert outside == []
    assert not re.findall(r"url\((?!#)|@import|fetch\(|XMLHttpRequest|import\(", text)
    assert all((Path(small.folder) / one).is_file() for one in page.addresses if one.startswith("figures/"))
    assert len(text) < 1.5e6


def test_every_figure_has_a_text_description(small):
    page = Page(Path(f"{small.folder}/report.html").read_text())
    assert all(one["role"] == "img" and one["aria-label"] for one in page.drawings)
    power = next(one["aria-label"] for one in page.drawings if "absorbed power per amplitude" in one["aria-label"])
    assert re.search(r"over wave frequency \[rad/s\]: .*FSB [\d.]+ to [\d.]+", power)


def test_page_is_accessible(small, tmp_path):
    """Without the thousands of lines in its figures, which have one description each."""
    page = re.sub(r"<(path|use)\b[^>]*/>", "", Path(f"{small.folder}/report.html").read_text())
    assert findings(page, tmp_path, width=360) == []


def test_every_figure_is_drawn_and_stamped(small):
    names = {f"{name}.{kind}" for name in of_study(small.study) for kind in FIGURE_KINDS}
    folder = Path(small.folder, "figures")
    assert {path.name for path in folder.iterdir()} == names
    stamps = json.loads(Path(small.manifest).read_text())
    for path in folder.iterdir():
        assert stamps[f"figures/{path.name}"]["spec_id"] == small.identity
        if path.suffix == ".svg":
            text = path.read_text()
            assert text.count("<path") > 5, path.name
            assert "nan" not in text.lower().replace("dominant", ""), path.name


def test_figures_are_drawn_for_print_and_a_file_of_the_user_stays(small, tmp_path, monkeypatch, capsys):
    """Figures as PDF and PNG, here two of them; none at all if one would replace another file."""
    first, *_, last = of_study(small.study)
    names, command = [first, last], ["figures", f"{small.name}.yaml", "--out", str(tmp_path)]
    monkeypatch.setattr("vsb.study.figure_names.of_study", lambda _: names)
    assert main([*command, "--pdf", "--png"]) == 0
    drawn = {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert set(drawn) == {f"{name}.{kind}" for name in names for kind in ("pdf", "png")}
    own = tmp_path / f"{names[-1]}.pdf"
    own.write_bytes(b"%PDF-1.4 my thesis")
    assert main([*command, "--pdf"]) == 2
    assert "no earlier output of vsb" in capsys.readouterr().err
    assert own.read_bytes() == b"%PDF-1.4 my thesis"
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir() if path != own} == {
        name: time for name, time in drawn.items() if name != own.name
    }


def test_spectra_of_irregular_seas_have_their_significant_height(seed):
    """The area of each is Hs^2/16; regular waves and still water have none."""
    waves = [{"kind": "jonswap", "hs": hs, "tp": tp} for hs, tp in ((1.0, 6.0), (3.0, 9.0))]
    others = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 5.0}]
    study = varied(seed, waves=[others[0], *waves, others[1]])
    found = report._spectra(study, 20.0)
    assert list(found.sea.values) == [wave.description for wave in study.waves[1:3]]
    assert found.integrate("omega").values == pytest.approx([1 / 16, 9 / 16], rel=0.01)
    assert report._spectra(varied(seed, waves=others), 20.0).ndim == 0


@pytest.fixture
def animation(small):
    paths = {**small.hydro_files, "response": small.response.out, "modes": f"{small.folder}/modes.nc"}
    inputs = Inputs(small.study, f"{small.folder}/trajectories", paths)
    return animated_study(inputs, {wave.label: wave.description for wave in small.study.waves})


def test_animation_shows_the_motion_of_the_runs(small, animation):
    study = small.study
    assert [design["name"] for design in animation["designs"]] == list(study.designs)
    assert [sea["words"] for sea in animation["seas"]] == [wave.description for wave in study.drawn_waves][
        :ANIMATED_SEAS
    ]
    (start, end), period = study.simulation.window, study.drawn_waves[0].period
    shown, sea = min(end - start, PERIODS * period), animation["seas"][0]
    assert (sea["start"], sea["step"] * (sea["frames"] - 1)) == pytest.approx((end - shown, shown))
    assert sea["frames"] == int(PER_PERIOD * shown / period) + 2
    for design, frames in zip(study.designs, animation["seas"][0]["designs"], strict=True):
        run = load(small.simulation(design, study.drawn_waves[0]).out)
        assert frames["modes"] == (run.sizes["dof"] - 1 if study.designs[design].flexible else 0)
        sea = animation["seas"][0]
        time = sea["start"] + sea["step"] * np.arange(sea["frames"])
        assert frames["heave"] == packed(np.interp(time, run.time.values, run.position.values[:, 0]))


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
    found = evaluated([pages.text_of("algebra.js")], expression, data, tmp_path)
    assert np.ravel(found) == pytest.approx([line["best_power"] for line in tables["equal_tuning"]], rel=1e-6)
    assert [design["name"] for design in data["designs"]] == list(small.study.designs)
    assert [design["name"] for design in data["designs"] if design["reference"]] == [small.study.reference_design]


def test_sea_of_a_spectrum_has_the_energy_of_its_height(small, tmp_path):
    data = living(small, small.study.model_copy(update={"waves": (Jonswap(kind="jonswap", hs=0.4, tp=4.0),)}))
    expression = "Array.from(seaSquares(data.seas[0], unpackedGrid(data.grids[0])))"
    squares = evaluated([pages.text_of("algebra.js")], expression, data, tmp_path)
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
