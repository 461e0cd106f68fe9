"""Rule report: the page says what its checked data say."""

import html
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import pytest
import xarray as xr
import yaml
from browser import findings
from conftest import EXAMPLE, varied

import vsb
from vsb import __version__
from vsb.errors import DatabaseError
from vsb.report.tuned import NO_BEST_DAMPER
from vsb.results.ledger import assumed_pressure_checks
from vsb.stages import report
from vsb.study.body import BodyStudy
from vsb.study.plan import StudyPlan
from vsb.study.reading import validated
from vsb.study.study import load, parse
from vsb.tools.stamps import record


def made(plan, out, **changes):
    files = {
        "tables": f"{plan.folder}/tables.json",
        "modes": f"{plan.folder}/modes.nc",
        "trajectories": f"{plan.folder}/trajectories",
        "figures": f"{plan.folder}/figures",
        **plan.hydro_files,
        **plan.response_files,
        **changes,
    }
    report.run(plan.study, out=str(out), manifest=changes.pop("manifest", plan.manifest), **files)


def test_the_page_says_its_powers_its_solver_and_its_figures(small):
    page = Path(f"{small.folder}/report.html").read_text()
    tables = json.loads(Path(f"{small.folder}/tables.json").read_text())
    for row in tables["comparison"]:
        assert row["design"] in page
        assert f"{row['power_mean']:.4g}" in page
    assert "spectral integral equation" in page
    assert "none (hydro.witness: none)" in page
    assert page.count('<div class="drawn"') == len(list(Path(f"{small.folder}/figures").glob("*.svg")))


def test_the_living_page_knows_optima_within_limits_alone(small, tmp_path, monkeypatch):
    given = []
    monkeypatch.setattr(report, "living_study", lambda *args: given.append(args))
    monkeypatch.setattr(report, "record", lambda *args: None)
    made(small, tmp_path / "page.html")
    tables = json.loads(Path(f"{small.folder}/tables.json").read_text())
    assert given[0][-1] == tables["within_limits"] != tables["equal_tuning"]


def test_a_study_in_an_assumed_pressure_has_tables_and_a_page_and_no_best_damper(small, tmp_path, monkeypatch):
    """From its file to its report: no database, no response, no ladder; its checks are those of such a pressure."""
    monkeypatch.chdir(tmp_path)
    study = varied(small.study, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    vsb.run(study)
    tables = json.loads(Path("results/small/tables.json").read_text())
    assert [row["design"] for row in tables["comparison"]] == ["FSB", "VSWEC"]
    assert (tables["equal_tuning"], tables["within_limits"], tables["statistics"]) == ([], [], [])
    told = {check["name"] for check in tables["checks"]}
    assert {check.name for check in assumed_pressure_checks(study, tables["comparison"])} <= told
    assert not {"radiation_fit", "power_limit"} & told
    page = Path("results/small/report.html").read_text()
    assert NO_BEST_DAMPER in html.unescape(page)
    assert "uniform pressure of 1800 Pa on the instantaneous wet shell" in page


VOID = {"meta", "br", "hr", "input", "link", "img"}


class Page(HTMLParser):
    """A page as tags: those that do not match, identifiers, addresses, drawings."""

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


def test_the_page_is_whole_light_and_needs_nothing_from_outside(small):
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


def test_every_drawing_says_in_words_and_numbers_what_it_shows(small):
    page = Page(Path(f"{small.folder}/report.html").read_text())
    assert all(one["role"] == "img" and one["aria-label"] for one in page.drawings)
    power = next(one["aria-label"] for one in page.drawings if "absorbed power per amplitude" in one["aria-label"])
    assert re.search(r"over wave frequency \[rad/s\]: .*FSB [\d.]+ to [\d.]+", power)


def test_tables_that_are_in_no_manifest_are_refused(small, tmp_path):
    (tmp_path / "tables.json").write_text("{}")
    with pytest.raises(DatabaseError, match=r"tables.json: "):
        made(small, tmp_path / "report.html", tables=str(tmp_path / "tables.json"))
    assert not (tmp_path / "report.html").exists()


def test_seas_are_told_in_words(seed):
    assert report._seas(seed) == {"regular_A0.179_T2.5": "regular waves of 0.179 m amplitude and 2.5 s period"}
    many = varied(seed, waves=[{"kind": "jonswap", "hs": 1, "tp": 4, "realisations": 2}])
    assert list(report._seas(many)) == [*(f"jonswap_Hs1_Tp4_g3.3_s{s}" for s in (1, 2)), "jonswap_Hs1_Tp4_g3.3"]
    paper = load(EXAMPLE.with_name("paper.yaml"))
    words = set(report._seas(paper).values())
    assert any(word.startswith("an assumed uniform pressure of ") for word in words)
    for period in (2.5, 7.0):
        waves = [{"kind": "regular", "amplitude": 0.1, "period": period}]
        (dry,) = report._seas(varied(paper, published=None, waves=waves)).values()
        assert dry.endswith(f" Pa and {period:g} s period")
    waves = [{"kind": "still"}, *({"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.5, 7.0))]
    still, *others = report._seas(varied(paper, published=None, waves=waves)).values()
    assert still == "still water"
    assert [words.partition(" Pa and ")[2] for words in others] == ["2.5 s period", "7 s period"]


@pytest.mark.parametrize("width", [1100, 360])
def test_readers_who_do_not_see_the_page_lose_nothing(small, tmp_path, width):
    assert findings(Path(f"{small.folder}/report.html").read_text(), tmp_path, width) == []


def test_a_page_without_its_language_is_found_wanting(small, tmp_path):
    page = Path(f"{small.folder}/report.html").read_text().replace('<html lang="en">', "<html>")
    assert [rule for rule, *_ in findings(page, tmp_path)] == ["html-has-lang"]


def test_facts_tell_the_worst_of_all_runs_and_the_study_as_it_was_read(seed):
    told = ((0.25, 3e-7), (1.5, 4e-5), (0.5, 2e-6))  # neither the first nor the last is the worst
    runs = [{"method": "generalized-alpha", "seconds": s, "energy_residual": r} for s, r in told]
    facts = report._facts(seed, {"BEM": "x"}, runs)
    time = f"generalized-alpha, {seed.simulation.duration:g} s of motion in 1.500 s or less per design and sea"
    assert (facts["Time domain"], facts["Largest energy residual"], facts["BEM"]) == (time, "4.0e-05", "x")
    assert parse(yaml.safe_load(facts["Study"])) == seed
    assert list(yaml.safe_load(facts["Study"])) == list(seed.model_dump(exclude_none=True))
    assert facts["Program"].startswith(f"vsb {__version__}, 20")


def solved(solver, **attrs):
    """Results of three frequencies and two motions, as a stage reads them."""
    database = xr.Dataset(
        coords={"omega": [0.5, 1.0, 4.5], "influenced_dof": ["Heave", "Bend"]},
        attrs={"solver": solver, "bem_seconds": 12.34, **attrs},
    )
    radiation = xr.Dataset(attrs={"order": 24, "fit_error": 3.2e-4, "seconds": 1.26})
    seconds = xr.DataArray([[1.0, 2.5], [10.0, 20.25]], {"solver": ["spectral", "panels"]}, ("solver", "shape"))
    witness = xr.Dataset(
        {"witness_seconds": seconds}, {"omega": [1.0, 2.0, 3.0, 4.0]}, {"panels": "capytaine 2", "rows": 14}
    )
    paths = "r/hydro/{}/id.nc".format
    return SimpleNamespace(database=database, radiation=radiation, witness=witness, path=paths)


def test_facts_of_coefficients_tell_their_solver_their_band_and_what_they_took():
    model = "24 states, rms error 3.2e-04, fitted in 1.3 s"
    assert report._bem_facts(solved("spectral")) == {
        "BEM": "spectral integral equation",
        "Hydro database": "id.nc: 3 frequencies up to 4.5 rad/s, 2 degrees of freedom",
        "Seconds of BEM": "12.3 on one core",
        "Radiation model": model,
    }
    assert report._bem_facts(solved("capytaine 2"))["BEM"] == "capytaine 2"
    of_body = {
        "Coefficients": "WAMIT",
        "Hydro database": "id.nc: 3 frequencies from 0.5 to 4.5 rad/s, degrees of freedom Heave, Bend",
        "Radiation memory": model,
    }
    assert report._body_facts(solved("WAMIT")) == of_body
    assert report._body_facts(solved("WAMIT", history="cut at 4.5")) == of_body | {"History": "cut at 4.5"}
    both, alone = solved("WAMIT", history="cut at 4.5"), solved("WAMIT")
    for one in (both, alone):
        one.radiation.attrs["history"] = "memory mended"
    assert report._body_facts(both)["History"] == "cut at 4.5; memory mended"
    assert report._body_facts(alone)["History"] == "memory mended"


def test_facts_of_the_second_solver_tell_the_seconds_of_each(seed):
    assert report._witness_facts(solved("spectral"), seed) == {
        "Witness": "id.nc: 2 shapes at 4 frequencies by capytaine 2 on 14 rows (30.2 s) and the spectral solver (3.5 s)"
    }


def test_the_page_is_told_of_the_first_sea_and_of_all_realisations(seed, tmp_path, monkeypatch):
    """Responses in the direction of the first of three seas; irregular are those of every family alone."""
    swell, sea = seed.model_dump()["waves"][0], {"kind": "jonswap", "hs": 1, "tp": 4, "realisations": 2}
    study = varied(seed, waves=[swell, sea, {**sea, "tp": 5}, {**swell, "amplitude": 0.2}])
    tables = {
        "comparison": [1],
        "statistics": [2],
        "equal_tuning": [3],
        "within_limits": [4],
        "checks": [5],
        "invalid": [6],
    }
    (tmp_path / "tables.json").write_text(json.dumps(tables))
    record(str(tmp_path / "manifest.json"), "0" * 16, [str(tmp_path / "tables.json")])
    plan = SimpleNamespace(figures=(), study_id="0" * 16)
    stored = SimpleNamespace(plan=plan, response="all", path=str, runs=SimpleNamespace(attributes=list))
    monkeypatch.setattr(report, "Inputs", lambda *_: stored)
    monkeypatch.setattr(report, "in_direction", lambda response, wave: (response, wave))
    for name in ("_bem_facts", "_witness_facts", "_facts"):
        monkeypatch.setattr(report, name, lambda *_: {})
    monkeypatch.setattr(report, "living_study", lambda *given: given)
    monkeypatch.setattr(report, "sketches", lambda study: (study,))
    pages = []
    monkeypatch.setattr(report, "render", lambda page: pages.append(page) or "page")
    manifest = str(tmp_path / "manifest.json")
    report.run(study, "runs", str(tmp_path / "r.html"), manifest, tables=str(tmp_path / "tables.json"), figures="f")
    (page,) = pages
    assert page.response == ("all", study.waves[0])
    assert page.irregular == [wave.label for wave in study.waves[1:5]]
    told = (page.rows, page.statistics, page.equal_tuning, page.within_limits, page.checks, page.invalid)
    assert told == ([1], [2], [3], [4], [5], [6])
    assert (page.thing, page.flexible, page.sketches, page.reference) == ("buoy", True, (study,), "FSB")
    assert page.living == (study, "database", "all", [4])


def test_buoys_move_in_the_seas_of_their_study_and_bodies_do_not(seed, monkeypatch):
    monkeypatch.setattr(report, "moving_study", lambda *given: given)
    plan = StudyPlan(seed)
    stored = SimpleNamespace(plan=plan, modes="modes")
    assert report._buoys(stored) == (stored, "modes", report._seas(seed))
    assert report._buoys(SimpleNamespace(plan=SimpleNamespace(study=seed), modes="modes")) is None


@pytest.mark.parametrize("kind", ["body", "dry"])
def test_a_page_is_of_the_hydrodynamics_its_study_has(seed, tmp_path, monkeypatch, kind):
    """Figures by name, each of its own file; of a body nothing is sketched, of an assumed pressure nothing responds."""
    raft = {
        "study": "raft", "designs": {"b": {}}, "waves": [{"kind": "still"}], "pto": {"damping": 1.0},
        "body": {"file": {"body": "raft", "mesh": "-", "modes": "-", "omega": [0.5, 1.0]}},
    }  # fmt: skip
    dry = varied(seed, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    study = validated(BodyStudy, raft, "raft.yaml") if kind == "body" else dry
    tables = dict.fromkeys(("comparison", "statistics", "equal_tuning", "within_limits", "checks", "invalid"), ())
    texts = {"tables.json": json.dumps(tables), "f/one.svg": "<svg>1</svg>", "f/two.svg": "<svg>2</svg>"}
    plan = SimpleNamespace(figures=("two", "one"), study_id="identity")
    runs = SimpleNamespace(attributes=lambda: "attributes")
    stored, pages, noted = SimpleNamespace(plan=plan, response="all", path=str, runs=runs), [], []
    monkeypatch.setattr(report, "Inputs", lambda *_: stored)
    monkeypatch.setattr(report, "read_text", lambda path, *given: given == ("manifest", "identity") and texts[path])
    monkeypatch.setattr(report, "in_direction", lambda response, wave: response)
    monkeypatch.setattr(report, "_body_facts", lambda of: {"Body": of is stored})
    monkeypatch.setattr(report, "_facts", lambda *given: given)
    monkeypatch.setattr(report, "_buoys", lambda of: "buoys")
    monkeypatch.setattr(report, "living_study", lambda *_: None)
    monkeypatch.setattr(report, "render", lambda page: pages.append(page) or "page")
    monkeypatch.setattr(report, "record", lambda *given: noted.append(given))
    out = str(tmp_path / "r.html")
    report.run(study, "runs", out, "manifest", tables="tables.json", figures="f")
    (page,) = pages
    words = {
        "Hydrodynamics": "hydrostatic and assumed uniform pressure of 1800 Pa on the instantaneous wet shell; no radiation"
    }
    assert page.facts == (study, {"Body": True} if kind == "body" else words, "attributes")
    assert list(page.figures.items()) == [("two", "<svg>2</svg>"), ("one", "<svg>1</svg>")]
    assert (page.thing, page.response) == (("body", "all") if kind == "body" else ("buoy", None))
    assert (bool(page.sketches), page.buoys, page.study) == (kind == "dry", "buoys", study.model_dump())
    assert noted == [("manifest", "identity", [out])]
    assert (tmp_path / "r.html").read_text() == "page"
