"""Records of the sea: what is read, what is refused, and that a run meets the elevations that were measured."""

import gzip
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import EXAMPLE, SMALL, SMALL_PLAN, run_at, varied

from vsb.engine.waves.kinds import Jonswap, RecordedSea
from vsb.engine.waves.records import read_record
from vsb.errors import ConfigError
from vsb.pipeline.graph import StudyPlan, plan_for
from vsb.study.study import load, parse
from vsb.tools.files import load as stored

STEP = 0.25


def measured(count=400, seed=3):
    """Elevations of a sea between 1.2 and 4 rad/s, by sums of cosines of the record's own length."""
    time, rng = STEP * np.arange(count), np.random.default_rng(seed)
    omega = 2 * np.pi / (STEP * count) * np.arange(1, count)
    omega = omega[(omega > 1.2) & (omega < 4.0)]
    phase = rng.uniform(0, 2 * np.pi, len(omega))
    return time, 0.02 * np.cos(np.outer(time, omega) + phase).sum(axis=1)


def text(time, elevation, head="time [s],elevation [m]\n", between=","):
    return head + "".join(f"{t:.6f}{between}{e:.9f}\n" for t, e in zip(time, elevation, strict=True))


def recorded(elevation, step=STEP, **keys):
    return RecordedSea(kind="record", file={"step": step, "elevation": tuple(elevation)}, **keys)


@pytest.mark.parametrize("count", [64, 65])
def test_harmonics_pass_through_every_sample(count):
    """Of any record, white noise about a mean level: even and odd numbers of samples, the highest harmonic included."""
    elevation = 0.4 + np.random.default_rng(count).normal(size=count)
    wave = recorded(elevation)
    found = wave.realisation(np.inf, 1.0).elevation(STEP * np.arange(count))
    assert found == pytest.approx(elevation - elevation.mean(), abs=1e-13)
    if count % 2:  # else the highest harmonic has its crests at the samples: half its variance lies between them
        assert wave.hs == pytest.approx(4 * elevation.std(), rel=1e-12)


def test_phase_is_that_of_the_convention():
    time = STEP * np.arange(64)
    found = recorded(0.3 * np.cos(2 * np.pi * 4 * time / 16.0 - 0.7)).realisation(np.inf, 1.0)
    assert found.omega[3] == pytest.approx(np.pi / 2)
    assert found.amplitude[3] == pytest.approx(0.3 * np.exp(0.7j), abs=1e-14)  # Re(a exp(-i omega t))


def test_spectrum_and_bands_hold_the_variance_of_the_record():
    _, elevation = measured()
    wave, omega = recorded(elevation), np.linspace(0.0, 12.0, 12001)
    assert np.trapezoid(wave.density(omega), omega) == pytest.approx(elevation.var(), rel=1e-5)
    _, amplitude = wave.components(12.0, 20.0)
    assert np.sum(amplitude**2) / 2 == pytest.approx(elevation.var(), rel=1e-9)
    assert wave.share_above(2.5) + wave.share_below(2.5) == pytest.approx(1.0)
    time = STEP * np.arange(400)
    two = recorded(0.3 * np.cos(0.02 * np.pi * 10 * time) + 0.1 * np.cos(0.02 * np.pi * 50 * time))
    assert 2 * np.pi / two.omega == pytest.approx(
        (0.9 * 10.0 + 0.1 * 2.0), rel=1e-9
    )  # m_-1/m_0 of periods 10 s and 2 s


@pytest.mark.parametrize("form", ["comma", "semicolon", "blanks", "packed"])
def test_files_are_read_and_known_by_what_they_hold(form, tmp_path):
    time, elevation = measured()
    between = {"semicolon": "; ", "blanks": "  "}.get(form, ",")
    content = "# a buoy\n" + text(time, elevation, between=between, head="" if form == "blanks" else "t, eta\n")
    data = content.encode() if form != "packed" else gzip.compress(content.encode())
    (tmp_path / "one.csv").write_bytes(data)
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(SMALL | {"waves": [{"kind": "record", "file": "one.csv"}]}))
    study = load(tmp_path / "study.yaml")
    again = parse(study.model_dump())
    assert np.allclose(study.waves[0].file.elevation, elevation, atol=1e-9)
    assert study.waves[0].file.step == pytest.approx(STEP)
    assert plan_for(study).identity == plan_for(again).identity
    assert (
        study.waves[0].label == parse(SMALL | {"waves": [recorded(np.round(elevation, 9)).model_dump()]}).waves[0].label
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: [*rows[:50], *rows[51:]], r"e.csv:51: received 1 missing value at 12.25 s; needs none, or .* repair: \[gaps\]"),
        (lambda rows: [*rows[:9], "2.001,0.1", *rows[10:]], r"e.csv:10: received 1 uneven time at 2.001 s; needs none, or beside the file in the study repair: \[times\]"),
        (lambda rows: [*rows[:9], "2.0,MM", *rows[10:]], r"e.csv:10: received 1 missing value at 2 s"),
        (lambda rows: [*rows[:9], "2.0,x", *rows[10:]], r"e.csv:10: received '2.0 x', needs two numbers"),
        (lambda rows: [*rows[:9], "1.5,0.1", *rows[10:]], r"e.csv:10: time: received 1.5 s after 1.75 s, needs ascending times"),
        (lambda rows: [*rows[:9], "2.0,99.00", *rows[10:]], r"e.csv:10: elevation: received 99 m at 2 s, needs at most 50 m"),
        (lambda rows: [*rows[:9], "2.0,nan", *rows[10:]], r"e.csv:10: received 1 missing value at 2 s"),
        (lambda rows: rows[:20], r"s.yaml: waves.0.file: received 19 samples in e.csv, needs 32 to 131072"),
        (lambda rows: [row.split(",")[0] + ",0.5" for row in rows], r"elevation: received 0.5 m throughout, needs waves"),
    ],
)  # fmt: skip
def test_gaps_and_what_is_no_record_are_refused(change, message, tmp_path):
    rows = text(*measured()).splitlines()
    (tmp_path / "e.csv").write_text("\n".join(change(rows)))
    raw = SMALL | {"waves": [{"kind": "record", "file": "e.csv"}]}
    with pytest.raises(ConfigError, match=message):
        parse(raw, source=str(tmp_path / "s.yaml"))


def test_missing_and_uneven_files_are_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"received no\.csv, which cannot be read"):
        read_record(tmp_path / "no.csv", "file")
    time, elevation = measured()
    (tmp_path / "drift.csv").write_text(text(time * (1 + 4e-6 * time), elevation))
    with pytest.raises(ConfigError, match=r"drift.csv:\d+: received \d+ uneven times at"):
        read_record(tmp_path / "drift.csv", "file")


def test_run_longer_than_the_record_and_waves_outside_the_band_are_refused():
    _, elevation = measured()
    with pytest.raises(ConfigError, match=r"simulation\.duration 120 s: is longer than the record waves.0; needs at"):
        varied(SMALL_PLAN.study, waves=[recorded(elevation).model_dump()], simulation={"duration": 120.0})
    quick = StudyPlan(varied(SMALL_PLAN.study, waves=[recorded(elevation, step=0.15).model_dump()]))
    with pytest.raises(ConfigError, match=r"waves.0.file: received a record with [\d.]+ % of its variance outside"):
        quick.check_waves()


@pytest.mark.parametrize("model", ["linear", pytest.param("body_exact", marks=pytest.mark.slow)])
def test_elevation_of_a_run_is_the_record(model, small, tmp_path):
    """Recorded every instant of a run that coincides with a sample; the rigid buoy follows the waves."""
    _, elevation = measured()
    study = varied(
        small.study, waves=[recorded(elevation).model_dump()], hydro={"model": model},
        simulation={"duration": 8.0, "window": [4.0, 8.0]},
    )  # fmt: skip
    plan, wave = StudyPlan(study), study.waves[0]
    plan.check_waves()
    run_at(plan.simulation("FSB", wave), out=str(tmp_path / "run.nc"), **small.hydro_files)
    run = stored(tmp_path / "run.nc")
    exact = wave.realisation(5.0, 8.0).elevation(run.time.values)
    assert run.elevation.values == pytest.approx(exact, abs=1e-12)
    at_samples = np.interp(STEP * np.arange(32), run.time, run.elevation)
    assert np.abs(at_samples - (elevation - elevation.mean())[:32]).max() < 0.02 * np.abs(elevation).max()
    assert wave.realisation(5.0, 8.0).elevation(STEP * np.arange(400)) == pytest.approx(
        elevation - elevation.mean(), abs=1e-12
    )
    assert float(abs(run.position.sel(dof="Heave")).max()) > 0.05


def test_record_of_the_documentation(tmp_path):
    """Its study reads the record its program writes."""
    page = (Path(__file__).parents[2] / "docs" / "own-buoy.md").read_text().split("## Measured waves\n")[1]
    program, section = page.split("```python\n")[1].split("```")[0], page.split("```yaml\n")[1].split("```")[0]
    exec(program.replace('"elevation.csv"', repr(str(tmp_path / "elevation.csv"))), {})
    raw = yaml.safe_load(EXAMPLE.read_text()) | yaml.safe_load(section)
    study = parse(raw, source=str(tmp_path / "study.yaml"))
    assert study.waves[0].hs == pytest.approx(1.0, rel=0.1)
    assert study.simulation.duration <= study.waves[0].file.length


STEP_RECORD_FAULTS, COUNT = 0.5, 1200
TIME = STEP_RECORD_FAULTS * np.arange(COUNT)
SEA = Jonswap(kind="jonswap", hs=0.6, tp=4.0, seed=2).realisation(6.0, TIME[-1] + STEP_RECORD_FAULTS).elevation(TIME)
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
    assert held["step"] == pytest.approx(STEP_RECORD_FAULTS, rel=1e-4)
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
