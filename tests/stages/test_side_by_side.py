"""Command compare: finished studies and campaigns side by side."""

import csv
import json
import shutil
from pathlib import Path

import pytest
from conftest import tables_of
from stages.test_members import batches, gather, planned, with_seas

from vsb.cli import main
from vsb.errors import ConfigError
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import make
from vsb.stages.side_by_side import compare, left_out, lines
from vsb.tools.files import load


@pytest.fixture(scope="module")
def year(tmp_path_factory):
    """A campaign over two moduli that was run."""
    plan = planned(with_seas(tmp_path_factory.mktemp("beside"), (1.0, 6.0)), {"device.young_modulus": [1e8, 1e9]})
    batches(plan)
    gather(plan)
    return plan


def test_study_is_compared_at_its_optimal_damping(small):
    found = [one for one in lines([small]) if one.tuning == "each"]
    tables = json.loads(Path(f"{small.folder}/tables.json").read_text())
    assert [(one.design, one.sea) for one in found] == [(row["design"], row["sea"]) for row in tables["equal_tuning"]]
    for one, row in zip(found, tables["equal_tuning"], strict=True):
        assert (one.power_mean, one.gain_percent) == (row["best_power"], row["best_gain_percent"])
        assert (one.power_low, one.power_high) == (row["best_power_low"], row["best_power_high"])
        assert (one.low, one.high) == (row["best_low"], row["best_high"])
        assert (one.damping, one.damping_unit) == (row["best_damping"], "N s/m")
        assert one.annual_energy is None


def test_study_at_a_given_damper_is_also_compared_as_it_ran(small):
    with open(f"{small.folder}/comparison.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["wave"] != "still"]
    found = [one for one in lines([small]) if one.tuning == "fixed"]
    assert [one.design for one in found] == [row["design"] for row in rows]
    columns = ("power_mean", "power_low", "power_high", "damping", "capture_width")
    for one, row in zip(found, rows, strict=True):
        assert [getattr(one, name) for name in columns] == pytest.approx([float(row[name]) for name in columns])


def test_powers_of_a_study_with_losses_are_all_after_conversion(small, tmp_path, capsys):
    """Of a linear take-off, efficiency times those without losses, at the optimal damping and at the given one."""
    pto = small.study.pto.model_copy(update={"efficiency": 0.8})
    shutil.copytree(f"{small.root}/hydro", tmp_path / "hydro")
    lossy = StudyPlan(small.study.model_copy(update={"study": "lossy", "pto": pto}), root=str(tmp_path))
    tables_of(lossy)
    make(lossy, [f"{lossy.folder}/tables.json"])
    without, found = lines([small]), lines([lossy])
    assert [(one.design, one.tuning) for one in found] == [(one.design, one.tuning) for one in without]
    assert {one.tuning for one in found} == {"each", "fixed"}
    for one, other in zip(found, without, strict=True):
        for key in ("power_mean", "power_low", "power_high", "capture_width"):
            assert getattr(one, key) == pytest.approx(0.8 * getattr(other, key), rel=1e-6)
        assert one.gain_percent == pytest.approx(other.gain_percent, rel=1e-6)
    make(lossy, [f"{lossy.folder}/study.json"])
    assert main(["matrix", lossy.folder]) == 0
    assert "by linear theory, after conversion with an efficiency of 0.8: not valid" in capsys.readouterr().out


def test_campaign_is_compared_over_its_year(year):
    ds = load(year.data_path, expected=year.identity).sel(tuning="one")
    found = lines([year])
    assert len(found) == ds.annual_energy.size
    assert {one.damping_unit for one in found} == {ds.damping.units}
    for one in found:
        at = ds.sel(young_modulus=float(one.point.partition(" ")[2]), design=one.design)
        assert one.annual_energy == pytest.approx(float(at.annual_energy))
        assert one.power_mean == pytest.approx(float(at.annual_mean_power))
        assert one.gain_percent == pytest.approx(float(at.gain_percent))
        assert (one.power_low, one.power_high) == (at.annual_mean_power_low, at.annual_mean_power_high)
        assert (one.low, one.high) == (at.gain_low, at.gain_high)
        assert one.capture_width == pytest.approx(float(at.capture_width))
        assert one.damping > 0


def test_studies_are_found_in_the_folder_of_results_that_is_named(small, tmp_path, monkeypatch):
    shutil.copytree("results", tmp_path / "runs")
    shutil.copy("small.yaml", tmp_path)
    expected = compare(["small.yaml"], None)
    monkeypatch.chdir(tmp_path)
    assert compare(["small.yaml"], None, "runs") == expected


def test_what_has_no_line_is_named(small, year):
    tunings = [name for name in year.loaded.tuning if name != "one"]
    assert left_out([small, year], lines([small, year])) == [
        f"Left out of {year.name}: tuning {', '.join(tunings)}; power in single seas; see {year.folder}."
    ]


def test_errors_are_one_line(tmp_path, capsys):
    with pytest.raises(ConfigError, match=r"--out: received a\.txt, needs a file that ends in \.csv or \.html"):
        compare(["any"], "a.txt")
    assert main(["compare", str(tmp_path / "absent.yaml")]) == 2
    assert "absent.yaml: cannot be read" in capsys.readouterr().err
    for words, expected in (
        (["compare"], "the following arguments are required: CONFIG"),
        (["compare", "a.yaml", "--levels", "x"], "unrecognized arguments: --levels x"),
    ):
        with pytest.raises(SystemExit) as stopped:
            main(words)
        assert stopped.value.code == 2
        assert expected in capsys.readouterr().err
