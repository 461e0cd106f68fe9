"""Stage report: the page of a study."""

import html
import json
import re
from html.parser import HTMLParser
from pathlib import Path

from browser import findings
from conftest import varied

import vsb
from vsb.report.answer import NO_OPTIMUM
from vsb.results.ledger import assumed_pressure_checks


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
    assert findings(Path(f"{small.folder}/report.html").read_text(), tmp_path, width=360) == []
