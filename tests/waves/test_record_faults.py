"""Faults of sensors in records: named with their time, repaired or accepted on request; waves are no faults."""

import numpy as np
import pytest
import yaml
from conftest import SMALL

from vsb.engine.waves.kinds import Jonswap
from vsb.engine.waves.records import read_record
from vsb.errors import ConfigError
from vsb.pipeline.graph import plan_for
from vsb.study.study import load, parse

STEP, COUNT = 0.5, 1200
TIME = STEP * np.arange(COUNT)
SEA = Jonswap(kind="jonswap", hs=0.6, tp=4.0, seed=2).realisation(6.0, TIME[-1] + STEP).elevation(TIME)
"""Ten minutes of a sea of 0.6 m."""


def with_change(places, values):
    changed = SEA.copy()
    changed[places] = values
    return changed


FAULTS = {
    "spikes": (TIME, with_change([300, 700], [12.0, -5.0]), "302: received 2 spikes at 150 s, 350 s; needs none, or"),
    "spike of several samples": (TIME, with_change([300, 301, 302], [4.0, 9.0, 5.0]), "302: received 1 spike at 150 s"),
    "spikes at the ends": (TIME, with_change([0, -1], [9.0, -9.0]), "2: received 2 spikes at 0 s, 599.5 s"),
    "steps": (TIME, SEA + 1.5 * (TIME >= 200.0), "402: received 1 level step at 200 s"),
    "drift": (TIME, SEA + 0.8 * np.sin(2 * np.pi * TIME / 2400), r"2: received drift of 0.8\d* m, [\d.]+ % of the variance"),
    "times": (TIME + 0.02 * np.sin(TIME), SEA, r"3: received \d+ uneven times at"),
    "gaps": (np.delete(TIME, [500, 900]), np.delete(SEA, [500, 900]), "502: received 2 missing values at 250 s, 450 s"),
    "missing values": (TIME, with_change([50, 51], np.nan), "52: received 2 missing values at 25 s, 25.5 s"),
}  # fmt: skip
REPAIR = {"spike of several samples": "spikes", "spikes at the ends": "spikes", "missing values": "gaps"}


def written(tmp_path, time, elevation):
    rows = (f"{t:.4f},{'' if np.isnan(e) else f'{e:.5f}'}\n" for t, e in zip(time, elevation, strict=True))
    (tmp_path / "r.csv").write_text("time [s],elevation [m]\n" + "".join(rows))
    return tmp_path / "r.csv"


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_with_its_time_and_repaired_on_request(fault, tmp_path):
    """A spike of 12 m in a sea of 0.6 m was taken as waves. Repaired, the record is that without the fault."""
    time, elevation, message = FAULTS[fault]
    path, name = written(tmp_path, time, elevation), REPAIR.get(fault, fault)
    with pytest.raises(ConfigError, match=rf"r.csv:{message}.* repair: \[{name}\]") as caught:
        read_record(path, "file")
    assert "\n" not in str(caught.value)
    held = read_record(path, "file", repair=[name])
    assert [note.startswith("repaired: ") for note in held["notes"]] == [True]
    assert held["step"] == pytest.approx(STEP, rel=1e-4)
    assert np.std(np.array(held["elevation"]) - SEA) < 0.05 * SEA.std()


def test_faults_at_once(tmp_path):
    elevation = with_change([300], [12.0]) + 1.5 * (TIME >= 200.0) + 1e-3 * TIME
    held = read_record(written(tmp_path, TIME, elevation), "file", repair=["drift", "spikes", "steps", "gaps"])
    assert np.std(np.array(held["elevation"]) - SEA) < 0.05 * SEA.std()
    assert [note.split(" ")[0] for note in held["notes"]] == ["repaired:"] * 3 + ["repair:"]
    assert held["notes"][-1] == "repair: no missing value found"


def test_a_stuck_sensor_and_long_gaps_are_not_repaired(tmp_path):
    stuck = written(tmp_path, TIME, with_change(slice(400, 440), SEA[400]))
    with pytest.raises(ConfigError, match=r"r.csv:402: received 1 stuck value at 200 s; .* study accept: \[stuck\]"):
        read_record(stuck, "file", repair=["spikes", "steps", "drift"])
    assert "accepted: 1 stuck value at 200 s" in read_record(stuck, "file", accept=["stuck"])["notes"]
    gap = written(tmp_path, np.delete(TIME, slice(500, 520)), np.delete(SEA, slice(500, 520)))
    with pytest.raises(
        ConfigError, match=r"r.csv:502: received a gap of 10 s at 250 s, needs at most 1.\d+ s, half of"
    ):
        read_record(gap, "file", repair=["gaps"])
    filled = written(tmp_path, TIME, with_change([50], 99.0))
    with pytest.raises(
        ConfigError, match=r"r.csv:52: .* received 99 m at 25 s, needs at most 50 m: .* repair: \[gaps\]"
    ):
        read_record(filled, "file")
    assert max(read_record(filled, "file", repair=["gaps"])["elevation"]) < 1.0


FINE = np.arange(0.0, 120.0, 0.05)
WAVES = {
    "a focused group in still water": 0.1 * np.exp(-(((FINE - 60) / 2.5) ** 2)) * np.cos(2 * np.pi * (FINE - 60) / 1.5),
    "a focused wave": 0.15 * np.cos(np.outer(FINE - 60, np.linspace(3, 9, 60))).mean(axis=1),
    "still water before the waves": np.clip((FINE - 20) / 10, 0, 1) * 0.05 * np.sin(2 * np.pi * (FINE - 20) / 1.5),
    "waves rounded to a fifth": np.round(0.05 * np.sin(np.pi * FINE), 2),
    "noise": np.random.default_rng(3).standard_normal(len(FINE)),
    "a steep wave": 0.05 * np.cos(np.pi * FINE) + 0.02 * np.cos(2 * np.pi * FINE) + 0.01 * np.cos(3 * np.pi * FINE),
}


@pytest.mark.parametrize("kind", WAVES)
def test_waves_are_no_faults(kind, tmp_path):
    """Of any sea within half a rounding of what the file has."""
    held = read_record(written(tmp_path, FINE, WAVES[kind]), "file")
    assert held["elevation"] == pytest.approx(WAVES[kind], abs=1e-5)
    assert held["notes"] == []


def test_a_study_asks_for_the_repair_and_keeps_it(tmp_path):
    """What was repaired stands in the sea; the request does not, since what is stored is repaired."""
    written(tmp_path, TIME, FAULTS["spikes"][1])
    record = {"kind": "record", "file": "r.csv", "repair": ["spikes"]}
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(SMALL | {"waves": [record]}))
    study = load(tmp_path / "study.yaml")
    assert study.waves[0].hs == pytest.approx(4 * SEA.std(), rel=0.01)
    assert "repaired: 2 spikes at 150 s, 350 s" in study.waves[0].description
    again = parse(study.model_dump())
    assert plan_for(again).identity == plan_for(study).identity
    with pytest.raises(ConfigError, match=r"study.yaml: waves.0.*repair.1: received 'stuck'"):
        parse(SMALL | {"waves": [record | {"repair": ["spikes", "stuck"]}]}, source=str(tmp_path / "study.yaml"))
