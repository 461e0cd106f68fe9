"""Results of a study, each read when it is asked for and against its id."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import ConfigError, DatabaseError
from vsb.stages import stored
from vsb.stages.stored import Results

WAVE = "regular_A0.179_T2.5"


@pytest.fixture
def results(small):
    return Results(small.study)


def test_tables_have_a_row_for_every_design_and_sea(results):
    assert [row["design"] for row in results.comparison] == ["FSB", "VSWEC"]
    assert results.statistics == []
    verdicts = [check["verdict"] for check in results.checks]
    assert verdicts == sorted(verdicts, key=("fail", "accepted", "doubt", "ok").index)
    assert {row["rung"] for row in results.ladder} >= {"fixed", "best_damper", "best_spring_damper", "matched"}
    assert all(isinstance(row["power_mean"], float) for row in results.ladder)


def test_a_port_is_the_responses_at_its_frequencies(results):
    omega = results.response.omega.values[5:20]
    for design in results.study.designs:
        stored = results.response.sel(design=design, omega=omega)
        port = results.port(design, omega)
        np.testing.assert_allclose(port.impedance, stored.port_impedance.values, rtol=1e-12)
        np.testing.assert_allclose(port.matched_power, stored.matched_power.values, rtol=1e-12)


def test_a_port_meets_waves_along_the_axis_or_where_it_is_told(results, monkeypatch):
    asked = []
    monkeypatch.setattr("vsb.stages.stored.towards", lambda linear, direction: asked.append(direction) or linear)
    results.port("FSB")
    results.port("FSB", direction=30.0)
    assert asked == [0.0, 30.0]


def test_a_scene_is_that_of_its_design_in_its_sea(results):
    assert results.scene("VSWEC").scene.flexible
    assert not results.scene("FSB").scene.flexible
    assert results.trajectory("FSB").attrs["design"] == "FSB"
    assert results.report == Path("results/small/report.html")


def test_what_the_study_has_not_is_refused(results):
    with pytest.raises(ConfigError, match=r"design: received 'none', needs one of FSB, VSWEC"):
        results.trajectory("none")
    with pytest.raises(ConfigError, match=r"wave: received 'none', needs one of regular_A0.179_T2.5"):
        results.trajectory("FSB", "none")
    dry = Results(varied(results.study, hydro={"model": "assumed_pressure", "pressure": 1800.0}))
    with pytest.raises(ConfigError, match=r"hydro.model: received 'assumed_pressure', which has no frequency response"):
        _ = dry.response
    with pytest.raises(ConfigError, match=r"received 'assumed_pressure', which has no tuning ladder; needs linear"):
        _ = dry.ladder
    with pytest.raises(ConfigError, match=r"received 'assumed_pressure', which has no hydro database; needs linear"):
        _ = dry.database


def test_results_of_another_study_in_the_folder_are_refused(results):
    other = Results(varied(results.study, pto={"damping": 5000.0}))
    for name in ("comparison", "ladder", "response"):
        with pytest.raises(DatabaseError, match=r"small/\w+.\w+: "):
            getattr(other, name)
    for design in ("FSB", "VSWEC"):
        with pytest.raises(DatabaseError, match=rf"small/trajectories/{design}-{WAVE}.nc: holds .*, needs "):
            other.trajectory(design)


def test_a_run_is_that_of_the_sea_named_or_of_the_first(seed, monkeypatch):
    """Its scene too; a port is at the database's frequencies unless others are told, of its own design."""
    seas = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.0, 3.0)]
    study = varied(seed, waves=seas, designs={"A": {"flexible": False}, "B": {}})
    found, (first, second) = Results(study, "elsewhere"), study.waves
    monkeypatch.setattr(stored, "load", lambda path, expected: (path, expected))
    monkeypatch.setattr(stored, "design_in_sea", lambda spec, files: (spec, files))
    for design in "AB":
        for label, wave in ((None, first), (first.label, first), (second.label, second)):
            own = (found.plan.trajectory_path(design, wave.label), found.plan.trajectory_id(design, wave))
            assert found.trajectory(design, label) == own
            spec, files = found.scene(design, label)
            assert (spec, files) == (found.plan.simulation(design, wave), dict(found.plan.hydro_files))
    linear = SimpleNamespace(
        database=xr.Dataset(coords={"omega": [1.0, 2.0]}), port=lambda at, motions, port: (list(at), motions, port)
    )
    floating = SimpleNamespace(motions={"A": "a", "B": "b"}, linear=linear, port="heave")
    monkeypatch.setattr(stored, "afloat", lambda study, path: floating)
    headed = []
    monkeypatch.setattr(stored, "towards", lambda linear, direction: headed.append(direction) or linear)
    assert found.port("B") == ([1.0, 2.0], "b", "heave")
    assert found.port("A", [0.5], direction=-30.0) == ([0.5], "a", "heave")
    assert found.port("A", np.array([0.5, 2.5])) == ([0.5, 2.5], "a", "heave")
    assert found.port("A", np.array([0.0])) == ([0.0], "a", "heave")
    assert found.port("A", [2.5, 0.5, 1.5]) == ([2.5, 0.5, 1.5], "a", "heave")
    assert headed == [0.0, -30.0, 0.0, 0.0, 0.0]


def test_a_ladder_has_numbers_words_and_none(seed, monkeypatch):
    text = "design,wave,rung,power_mean,spring\nA,calm,fixed,1.5,\nB,1e3,matched,,2\nB,calm,fixed,0,-0.0\n"
    monkeypatch.setattr(stored, "read_text", lambda path, manifest, identity: text)
    rows = [(row["design"], row["wave"], row["rung"], row["power_mean"], row["spring"]) for row in Results(seed).ladder]
    assert rows == [
        ("A", "calm", "fixed", 1.5, None), ("B", "1e3", "matched", None, 2.0), ("B", "calm", "fixed", 0.0, 0.0)
    ]  # fmt: skip


def test_a_part_of_a_name_is_no_name():
    """Nor is none of them, nor two in a row."""
    for name in ("flex", "", "rigid, flexible"):
        with pytest.raises(ConfigError) as error:
            stored._known("design", name, iter(["rigid", "flexible"]))
        assert str(error.value) == f"design: received {name!r}, needs one of rigid, flexible"
    assert stored._known("design", "flexible", ["rigid", "flexible"]) == "flexible"
