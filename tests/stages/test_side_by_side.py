"""Finished studies and campaigns side by side: their numbers, of checked results alone."""

import csv
import json
import re
from contextlib import chdir
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import SMALL_PLAN, varied
from stages.test_members import batches, gather, planned, with_seas

from vsb.cli import main
from vsb.errors import ConfigError, DatabaseError
from vsb.report.side_by_side import as_csv, as_text
from vsb.stages import side_by_side
from vsb.stages.side_by_side import _width, compare, lines
from vsb.study.study import canonical
from vsb.study.take_off import DofPort
from vsb.tools.files import load
from vsb.tools.stamps import record


@pytest.fixture(scope="module")
def year(tmp_path_factory):
    """A campaign over two moduli that was run."""
    plan = planned(with_seas(tmp_path_factory.mktemp("beside"), (1.0, 6.0)), {"device.young_modulus": [1e8, 1e9]})
    batches(plan)
    gather(plan)
    return plan


def test_a_study_is_told_at_its_own_best_dampers(small):
    found = lines([small])
    tables = json.loads(Path(f"{small.folder}/tables.json").read_text())
    assert [(one.design, one.sea) for one in found] == [(row["design"], row["sea"]) for row in tables["equal_tuning"]]
    for one, row in zip(found, tables["equal_tuning"], strict=True):
        assert (one.power_mean, one.gain_percent) == (row["best_power"], row["best_gain_percent"])
        assert (one.damping, one.damping_unit) == (row["best_damping"], "N s/m")
        assert one.annual_energy is None


def test_capture_width_is_that_of_the_power_told(small):
    """The energy flux of a sea is one, whatever takes it."""
    runs = {
        (row["design"], row["wave"]): row
        for row in json.loads(Path(f"{small.folder}/tables.json").read_text())["comparison"]
    }
    for one in lines([small]):
        run = runs[one.design, one.sea]
        flux = run["power_mean"] / run["capture_width"]
        assert one.capture_width == pytest.approx(one.power_mean / flux, rel=1e-9)


def test_a_campaign_is_told_over_its_year(year):
    ds = load(year.data_path, expected=year.campaign_id).sel(tuning="one")
    found = lines([year])
    assert len(found) == ds.annual_energy.size
    assert {one.damping_unit for one in found} == {ds.damping.units}
    for one in found:
        at = ds.sel(young_modulus=float(one.point.partition(" ")[2]), design=one.design)
        assert one.annual_energy == pytest.approx(float(at.annual_energy))
        assert one.power_mean == pytest.approx(float(at.annual_mean_power))
        assert one.gain_percent == pytest.approx(float(at.gain_percent))
        assert one.capture_width == pytest.approx(float(at.capture_width))
        assert one.damping > 0


def test_a_campaign_that_varies_nothing_is_one_point(tmp_path):
    plan = planned(with_seas(tmp_path, (1.0, 6.0)))
    batches(plan)
    gather(plan)
    ds = load(plan.data_path, expected=plan.campaign_id).sel(tuning="one")
    found = lines([plan])
    assert [(one.design, one.point) for one in found] == [(str(design), "") for design in ds.design.values]
    assert [one.annual_energy for one in found] == pytest.approx(list(ds.annual_energy.values))


def test_what_has_no_best_damper_is_told_as_it_was_run(small, tmp_path):
    """Without hydrodynamics, say: under its own damper, without a width; a gain or damper it has not is none."""
    names = ("design", "wave", "power_mean", "power_gain_percent", "damping")
    rows = [("A", "calm", 10.0, "", 5.0), ("B", "calm", 30.0, 200.0, ""), ("B", "high", 0.0, float("nan"), 7.0)]
    path, manifest = tmp_path / "tables.json", str(tmp_path / "manifest.json")
    found = {"equal_tuning": [], "comparison": [dict(zip(names, row, strict=True)) for row in rows]}
    path.write_text(json.dumps(found))
    record(manifest, small.study_id, [str(path)])
    plan = SimpleNamespace(folder=str(tmp_path), manifest=manifest, study_id=small.study_id, study=small.study)
    told = [(one.design, one.sea, one.power_mean, one.gain_percent, one.damping) for one in lines([plan])]
    assert told == [("A", "calm", 10.0, None, 5.0), ("B", "calm", 30.0, 200.0, None), ("B", "high", 0.0, None, 7.0)]
    assert {(one.tuning, one.capture_width, one.annual_energy) for one in lines([plan])} == {("fixed", None, None)}


def test_studies_and_campaigns_stand_in_one_table(small, year):
    found = lines([small, year])
    head, *body = as_text(found).splitlines()
    assert head.split()[0] == "study"
    assert "MWh/year" in head
    assert [row.split()[0] for row in body] == [one.study for one in found]
    assert "MWh/year" not in as_text(lines([small]))
    rows = list(csv.DictReader(as_csv(found).splitlines()))
    assert [row["design"] for row in rows] == [one.design for one in found]
    assert rows[0]["annual_energy"] == ""
    assert float(rows[-1]["annual_energy"]) == pytest.approx(found[-1].annual_energy, rel=1e-11)


def test_results_of_another_state_of_the_file_are_refused(finished, tmp_path, year):
    changed = type(SMALL_PLAN)(varied(SMALL_PLAN.study, pto={"damping": 7777.0}), root=SMALL_PLAN.root)
    with chdir(finished), pytest.raises(DatabaseError, match=r"tables\.json: "):
        lines([changed])
    other = planned(Path(year.loaded.source).parent, {"device.young_modulus": [1e8, 2e9]})
    with pytest.raises(DatabaseError, match=r"campaign\.nc"):
        lines([other])


def test_a_study_is_named_once(small):
    with pytest.raises(ConfigError, match=f"compare: received {SMALL_PLAN.study.study} more than once"):
        lines([small, small])


def test_mistakes_are_one_line(tmp_path, capsys):
    with pytest.raises(ConfigError, match=r"--out: received a\.txt, needs a file that ends in \.csv or \.html"):
        compare(["any"], "a.txt")
    assert main(["compare", str(tmp_path / "absent.yaml")]) == 2
    assert "absent.yaml: cannot be read" in capsys.readouterr().err
    for words, expected in (
        (["compare"], "needs studies, or as a rule of the workflow --trajectories"),
        (["compare", "a.yaml", "--rungs", "x"], "--rungs is of the rule compare, which takes no studies"),
    ):
        with pytest.raises(SystemExit) as stopped:
            main(words)
        assert stopped.value.code == 2
        assert expected in capsys.readouterr().err


def test_the_command_prints_and_writes_the_table(finished, tmp_path, capsys):
    config = tmp_path / "small.yaml"
    config.write_text(yaml.safe_dump(json.loads(canonical(SMALL_PLAN.study))))
    with chdir(finished):
        assert main(["compare", str(config), "--out", str(tmp_path / "table.csv")]) == 0
    printed = capsys.readouterr().out
    assert "VSWEC" in printed
    assert len((tmp_path / "table.csv").read_text().splitlines()) == len(printed.splitlines())


def test_a_page_is_written_with_ways_to_the_reports(finished, tmp_path, year):
    config = tmp_path / "small.yaml"
    config.write_text(yaml.safe_dump(json.loads(canonical(SMALL_PLAN.study))))
    with chdir(finished):
        compare([str(config)], str(tmp_path / "pages" / "beside.html"))
        report = Path(SMALL_PLAN.folder, "report.html").absolute()
    page = (tmp_path / "pages" / "beside.html").read_text()
    (link,) = re.findall(r'<a href="(.*?)">small</a>', page)
    assert (tmp_path / "pages" / link).resolve() == report.resolve()
    assert SMALL_PLAN.study_id in page


@pytest.mark.parametrize(
    ("sea", "design", "width"),
    [
        ("calm", "A", 6.0),
        ("calm", "B", 8.0),
        ("high", "A", 1.0),
        ("high", "B", None),
        ("flat", "A", None),
        ("many", "A", None),
    ],
)
def test_a_capture_width_grows_with_the_power_of_its_own_run(sea, design, width):
    """2 m at 10 W are 6 m at 30 W; none where nothing was taken, no width is known, or the sea is many realisations."""
    runs = [
        ("A", "calm", 10.0, 2.0), ("B", "calm", 15.0, 4.0), ("A", "high", 60.0, 2.0), ("B", "high", 10.0, None),
        ("A", "flat", 0.0, 0.0), ("A", "many_s1", 10.0, 2.0),
    ]  # fmt: skip
    names = ("design", "wave", "power_mean", "capture_width")
    found = {"comparison": [dict(zip(names, run, strict=True)) for run in runs]}
    assert _width(found, {"design": design, "sea": sea, "best_power": 30.0}) == width


class Year(SimpleNamespace):
    """What is asked of a campaign's plan."""


def test_points_of_several_keys_stand_in_the_order_they_were_asked_for(monkeypatch):
    """Numbers and words, the second of two tunings; what a campaign does not know, or is not a number, is none."""
    sizes = {"thickness": 2, "kind": 3, "tuning": 2, "design": 2}
    power = xr.DataArray(np.arange(24.0).reshape(2, 3, 2, 2), dims=sizes)
    gain = power.where(power != 3.0) + 100.0
    data = {"annual_mean_power": power, "gain_percent": gain, "damping": power.assign_attrs(units="N s/m")}
    data |= {"annual_energy": power + 200.0, "margin": (("thickness", "kind"), np.zeros((2, 3)))}
    coords = {"thickness": [0.01, 0.02], "kind": ["x", "y", "z"], "tuning": ["fixed", "each"], "design": ["A", "B"]}
    ds = xr.Dataset(data, coords, {"climate": "a coast"})
    points = [{"thickness": t, "kind": kind} for t in (0.0, 0.02) for kind in "xyz"]
    loaded = SimpleNamespace(tuning=("fixed", "each"), campaign=SimpleNamespace(vary=SimpleNamespace(points=points)))
    plan, asked = Year(name="year", data_path="c.nc", campaign_id="id", loaded=loaded), []
    monkeypatch.setattr(side_by_side, "CampaignPlan", Year)
    monkeypatch.setattr(side_by_side, "leading_tuning", lambda tuning: tuning[-1])
    monkeypatch.setattr(side_by_side, "load", lambda path, expected: asked.append((path, expected)) or ds)
    monkeypatch.setattr("vsb.results.campaign.damper", lambda ds: ds.damping + 300.0)
    found = lines([plan])
    assert asked == [("c.nc", "id")]
    words = [f"thickness {t:g}, {kind}" for t in (0.0, 0.02) for kind in "xyz"]
    where = [(one.study, one.point, one.design, one.sea, one.tuning, one.damping_unit) for one in found]
    assert where == [("year", word, design, "a coast", "each", "N s/m") for word in words for design in "AB"]
    own = power.values[:, :, 1].ravel()
    numbers = [(one.power_mean, one.gain_percent, one.damping, one.capture_width, one.annual_energy) for one in found]
    assert numbers == [(p, None if p == 3.0 else p + 100.0, p + 300.0, None, p + 200.0) for p in own]


def test_reports_are_those_of_their_own_plan_seen_from_the_page(monkeypatch):
    monkeypatch.setattr(side_by_side, "CampaignPlan", Year)
    study = SimpleNamespace(name="calm", folder="results/calm", study_id="1")
    found = side_by_side._reports([Year(name="year", folder="others/year", campaign_id="2"), study], Path("results/p"))
    assert found == {"year": ("../../others/year/report.html", "2"), "calm": ("../calm/report.html", "1")}


@pytest.mark.parametrize(("port", "unit"), [("heave", "N s/m"), ("volume", "Pa s/m³"), (DofPort(dof="Pitch"), "N m s")])
def test_dampers_of_a_study_have_the_unit_of_its_port(tmp_path, monkeypatch, port, unit):
    """Whether it is told at its own best dampers or as it was run; numbers are of their own row."""
    best = [
        {"design": d, "sea": "w", "best_power": p, "best_gain_percent": 2 * p, "best_damping": 3 * p}
        for d, p in (("A", 1.0), ("B", 5.0))
    ]
    run = {
        "design": "C",
        "wave": "v",
        "power_mean": 7.0,
        "power_gain_percent": 8.0,
        "damping": 9.0,
        "capture_width": 1.0,
    }
    study = SimpleNamespace(study="calm", pto=SimpleNamespace(port=port))
    plan = SimpleNamespace(folder="f", manifest="m", study_id="id", study=study)
    for tuned, told in (
        (best, [("A", "w", "each", 1.0, 2.0, 3.0), ("B", "w", "each", 5.0, 10.0, 15.0)]),
        ([], [("C", "v", "fixed", 7.0, 8.0, 9.0)]),
    ):
        text = json.dumps({"equal_tuning": tuned, "comparison": [run]})
        monkeypatch.setattr(
            side_by_side, "read_text", lambda *given, text=text: text if given == ("f/tables.json", "m", "id") else ""
        )
        found = lines([plan])
        assert [
            (one.design, one.sea, one.tuning, one.power_mean, one.gain_percent, one.damping) for one in found
        ] == told
        assert {(one.study, one.point, one.damping_unit) for one in found} == {("calm", "", unit)}


def test_the_name_that_is_there_twice_is_told_whichever_it_is(monkeypatch):
    monkeypatch.setattr(side_by_side, "CampaignPlan", Year)
    plans = [Year(name="year"), *(SimpleNamespace(study=SimpleNamespace(study=name)) for name in ("a", "b", "b"))]
    needs = "compare: received b more than once; needs every study and campaign once"
    with pytest.raises(ConfigError, match=f"^{needs}$"):
        lines(plans)
    year, namesake = Year(name="b"), SimpleNamespace(study=SimpleNamespace(study="b"))
    for both in ([year, year], [year, namesake], [namesake, year], [Year(name="a"), namesake, year]):
        with pytest.raises(ConfigError, match=f"^{needs}$"):
            lines(both)


@pytest.mark.parametrize(
    ("out", "told"),
    [
        ("beside.html", "results/a/report.html results/b/report.html"),
        ("pages/of/b.html", "../../results/a/report.html ../../results/b/report.html"),
        ("results/b/b.html", "../a/report.html report.html"),
        ("pages/table.csv", "the table"),
        (None, None),
    ],
)
def test_ways_to_the_reports_begin_where_the_page_is(monkeypatch, out, told):
    """All studies' in their order; a table has none, and nothing is written that was not asked for."""
    written = []
    plans = {name: SimpleNamespace(name=name, folder=f"results/{name}", study_id=name) for name in "ab"}
    monkeypatch.setattr(side_by_side, "plan_of", plans.__getitem__)
    monkeypatch.setattr(side_by_side, "lines", lambda given: [plan.name for plan in given])
    monkeypatch.setattr(side_by_side, "as_text", " ".join)
    monkeypatch.setattr(side_by_side, "as_csv", lambda found: "the table")
    monkeypatch.setattr(side_by_side, "as_page", lambda found, ways: " ".join(path for path, _ in ways.values()))
    monkeypatch.setattr(side_by_side, "write_text", lambda *given: written.append(given))
    assert compare(["a", "b"], out) == "a b"
    assert written == ([] if out is None else [(out, told)])
