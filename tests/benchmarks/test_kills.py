"""What a killed run is compared with; `python -m benchmarks kills 20 FOLDER` kills them."""

import signal
import subprocess
import sys

import pytest
import xarray as xr

from benchmarks import kills
from benchmarks.__main__ import main
from vsb.errors import VsbError
from vsb.stages.climate import read_climate
from vsb.study.campaign_plan import plan_of
from vsb.tools.files import save


def test_its_campaign_has_all_a_campaign_can_have(tmp_path, monkeypatch):
    kills.write_campaign(tmp_path)
    monkeypatch.chdir(tmp_path)
    plan = plan_of("killed.yaml")
    assert len(plan.members) == len(plan.verifications) == 2
    assert read_climate(plan.climate, plan.loaded.climate_path).hours.sum() == pytest.approx(1.0)


def test_other_results_are_told(tmp_path):
    for name, text in (("a.nc", "a"), ("b/c.csv", "c"), ("logs/one.log", "12:00")):
        (tmp_path / "results" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "results" / name).write_text(text)
    whole = kills.contents(tmp_path)
    assert sorted(whole) == ["a.nc", "b/c.csv"]
    assert kills.compared(kills.contents(tmp_path), whole) == "the same bytes"
    (tmp_path / "results" / "a.nc").write_text("other")
    (tmp_path / "results" / "b" / "c.csv").rename(tmp_path / "results" / "b" / "c.tmp")
    told = kills.compared(kills.contents(tmp_path), whole)
    assert told == "missing: b/c.csv; too many: b/c.tmp; other bytes: a.nc"


def test_what_its_making_took_is_no_part_of_a_result(tmp_path):
    def written(name, **attrs):
        save(xr.Dataset({"margin": 1.0}, attrs={"spec_id": "x", **attrs}), tmp_path / "results" / name)
        return kills.contents(tmp_path)[name]

    assert written("a.nc", seconds=1.5) == written("a.nc", seconds=2.5)
    assert written("a.nc", bem_seconds=1.5) == written("a.nc", bem_seconds=2.5)
    assert written("a.nc", seconds=1.5, other=1) != written("a.nc", seconds=1.5)
    assert written("b.nc", other=1.0) != written("b.nc", other=2.0)


def test_a_run_is_killed_with_all_it_started(tmp_path, monkeypatch):
    inner = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {'import time; time.sleep(60)'!r}])"

    def begun(folder):
        return subprocess.Popen([sys.executable, "-c", inner], start_new_session=True)

    found = []
    monkeypatch.setattr(kills, "started", lambda folder: found.append(begun(folder)) or found[-1])
    assert kills.killed(tmp_path, 0.5)
    assert found[0].returncode == -signal.SIGKILL
    monkeypatch.setattr(kills, "started", lambda folder: subprocess.Popen([sys.executable, "-c", ""]))
    assert not kills.killed(tmp_path, 60.0)


def test_a_run_that_fails_is_told(tmp_path, monkeypatch):
    failing = [sys.executable, "-c", "raise SystemExit(3)"]
    monkeypatch.setattr(kills, "started", lambda folder: subprocess.Popen(failing))
    with pytest.raises(VsbError, match=r"kills: a run ended with 3; see .*run\.log"):
        kills.finish(tmp_path)


@pytest.mark.parametrize(("verdict", "code"), [("the same bytes", 0), ("missing: a.nc", 1)])
def test_the_command_ends_with_what_came_of_it(tmp_path, monkeypatch, verdict, code):
    monkeypatch.setattr(kills, "benchmark", lambda count, place: [kills.Row(0, 1.0, 2, verdict)] * count)
    assert main(["kills", "2", str(tmp_path / "runs")]) == code
