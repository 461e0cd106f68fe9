"""Rule figures: all figures of a study, and nothing else of the caller's changed."""

import json
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.report.figures import draw
from vsb.stages import figures
from vsb.study.body import BodyStudy
from vsb.study.plan import figure_names
from vsb.study.reading import validated
from vsb.study.results_plan import FIGURE_KINDS


def test_every_figure_is_drawn_as_before_and_the_callers_looks_stay(small, tmp_path):
    looks = dict(mpl.rcParams)
    files = {**small.hydro_files, **small.response_files}
    out, manifest = str(tmp_path / "figures"), str(tmp_path / "manifest.json")
    figures.run(small.study, f"{small.folder}/trajectories", out, manifest, modes=f"{small.folder}/modes.nc", **files)
    assert dict(mpl.rcParams) == looks
    names = {f"{name}.{kind}" for name in figure_names(small.study) for kind in FIGURE_KINDS}
    assert {path.name for path in (tmp_path / "figures").iterdir()} == names
    assert {entry["spec_id"] for entry in json.loads((tmp_path / "manifest.json").read_text()).values()} == {
        small.study_id
    }
    for name in (name for name in names if name.endswith(".svg")):
        drawn = (tmp_path / "figures" / name).read_text()
        assert drawn.count("<path") > 5, name
        assert "nan" not in drawn.lower().replace("dominant", ""), name


def test_each_irregular_sea_has_a_spectrum_of_its_own_and_others_none(seed):
    """Its area is Hs^2/16; frequencies are of all: from half the lowest of the longest sea."""
    waves = [{"kind": "jonswap", "hs": hs, "tp": tp} for hs, tp in ((1.0, 6.0), (3.0, 9.0))]
    others = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 5.0}]
    study = varied(seed, waves=[others[0], *waves, others[1]])
    found = figures._spectra(study, 20.0)
    assert list(found.sea.values) == [wave.description for wave in study.waves[1:3]]
    assert found.integrate("omega").values == pytest.approx([1 / 16, 9 / 16], rel=0.01)
    lowest = min(wave.reach[0] for wave in study.waves[1:3])
    assert found.omega.values[[0, -1]] == pytest.approx([lowest / 2, 20.0])
    assert figures._spectra(varied(seed, waves=others), 20.0).ndim == 0


def test_the_period_of_still_water_is_that_of_the_slowest_free_motion(seed):
    still, wave = varied(seed, waves=[{"kind": "still"}]).waves[0], seed.waves[0]
    response = xr.Dataset({"wet_natural_frequency": ("wet_mode", [3.0, 1.5])})
    assert figures._period(seed, still, response) == pytest.approx(2 * np.pi / 1.5)
    assert figures._period(seed, wave, response) == pytest.approx(wave.period)
    dry = varied(seed, hydro={"model": "assumed_pressure", "pressure": 1800.0})
    assert figures._period(dry, still, xr.Dataset()) == pytest.approx(2 * np.pi / dry.heave_frequency)


def test_figures_are_drawn_of_the_study_and_its_files(small, tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(figures, "draw", lambda name, data: seen.append(data) or draw(name, data))
    files = {**small.hydro_files, **small.response_files}
    out, manifest = str(tmp_path / "figures"), str(tmp_path / "manifest.json")
    monkeypatch.setattr("vsb.study.plan.StudyPlan.figures", ["mode_shapes"])
    figures.run(small.study, f"{small.folder}/trajectories", out, manifest, modes=f"{small.folder}/modes.nc", **files)
    (data,), (wave,) = seen, small.study.waves
    assert (data.designs, data.reference) == (tuple(small.study.designs), small.study.reference_design)
    assert (data.wave_frequencies, data.periods) == ((wave.omega,), {wave.label: pytest.approx(wave.period)})
    assert (data.window, data.tuned, data.limit) == (small.study.simulation.window, False, "limit λ/2π")
    assert set(data.runs) == {(design, wave.label) for design in small.study.designs}


def test_figures_over_frequency_are_in_the_direction_of_the_first_sea(seed, tmp_path, monkeypatch):
    """As the report says them, whatever comes after it."""
    swell, asked = seed.model_dump()["waves"][0], []
    study = varied(seed, waves=[swell, {**swell, "amplitude": 0.3}, {**swell, "amplitude": 0.2}])
    plan = SimpleNamespace(figures=(), study_id="0" * 16, highest=5.0)
    parts = dict.fromkeys(("modes", "database", "radiation", "response", "witness"), xr.Dataset())
    monkeypatch.setattr(figures, "Inputs", lambda *_: SimpleNamespace(plan=plan, runs={}, **parts))
    monkeypatch.setattr(figures, "in_direction", lambda response, wave: asked.append(wave) or response)
    monkeypatch.setattr(figures, "_spectra", lambda *_: None)
    figures.run(study, "nowhere", str(tmp_path), str(tmp_path / "manifest.json"))
    assert asked == [study.waves[0]]


def test_the_design_that_others_are_compared_with_is_the_rigid_one_wherever_it_stands(small, tmp_path, monkeypatch):
    study = varied(small.study, designs={"A": {}, "B": {"flexible": False}})
    plan, seen = SimpleNamespace(figures=("any",), study_id="0" * 16, highest=5.0), []
    parts = dict.fromkeys(("modes", "database", "radiation", "response", "witness"), xr.Dataset())
    monkeypatch.setattr(figures, "Inputs", lambda *_: SimpleNamespace(plan=plan, runs={}, **parts))
    monkeypatch.setattr(figures, "draw", lambda _, data: seen.append(data))
    monkeypatch.setattr(figures, "drawn", lambda *_: SimpleNamespace(write=lambda *_: []))
    figures.run(study, "nowhere", str(tmp_path), str(tmp_path / "manifest.json"))
    assert [data.reference for data in seen] == ["B"]


@pytest.mark.parametrize(("damping", "tuned"), [(None, True), (5e3, False)])
def test_what_figures_are_told_of_a_study_is_its_own(seed, tmp_path, monkeypatch, damping, tuned):
    """Still water has no frequency, and the period of the slowest motion; the limit is that of all channels reached."""
    regular = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (5.0, 3.0)]
    study = varied(seed, waves=[{"kind": "still"}, *regular], pto={"damping": damping, "port": "volume"})
    response = xr.Dataset({"wet_natural_frequency": ("wet_mode", [3.0, 1.5])}, attrs={"limit": "3 λ/2π"})
    parts = {name: xr.Dataset(attrs={"name": name}) for name in ("modes", "database", "radiation", "witness")}
    plan, seen = SimpleNamespace(figures=("any",), study_id="0" * 16, highest=5.0), []
    found = SimpleNamespace(plan=plan, runs={}, response=response, **parts)
    monkeypatch.setattr(figures, "Inputs", lambda *_: found)
    monkeypatch.setattr(figures, "in_direction", lambda response, _: response)
    monkeypatch.setattr(figures, "draw", lambda _, data: seen.append(data))
    monkeypatch.setattr(figures, "drawn", lambda *_: SimpleNamespace(write=lambda *_: []))
    figures.run(study, "nowhere", str(tmp_path), str(tmp_path / "manifest.json"))
    (data,) = seen
    assert data.wave_frequencies == pytest.approx((2 * np.pi / 5.0, 2 * np.pi / 3.0))
    assert data.periods == pytest.approx({"still": 2 * np.pi / 1.5, **{w.label: w.period for w in study.waves[1:]}})
    assert (data.limit, data.tuned, data.port) == ("limit 3 λ/2π", tuned, "volume")
    assert [getattr(data, name).attrs["name"] for name in parts] == list(parts)


def test_what_drifts_alone_has_a_period_of_its_own_in_still_water(seed):
    still = varied(seed, waves=[{"kind": "still"}]).waves[0]
    assert figures._period(seed, still, xr.Dataset({"wet_natural_frequency": ("wet_mode", [])})) == 2 * np.pi


def test_spectra_reach_as_far_as_runs_have_components_and_a_body_has_no_limit(seed, tmp_path, monkeypatch):
    """What floats without an axis of revolution may take more than a wavelength over two pi."""
    raft = {
        "study": "raft", "designs": {"a": {}}, "waves": [{"kind": "still"}], "pto": {"damping": 1.0},
        "body": {"file": {"body": "raft", "mesh": "-", "modes": "-", "omega": [0.5, 1.0]}},
    }  # fmt: skip
    plan, seen = SimpleNamespace(figures=("any",), study_id="0" * 16, highest=7.5), []
    response = xr.Dataset({"wet_natural_frequency": ("wet_mode", [1.5])}, attrs={"limit": "3 λ/2π"})
    parts = dict.fromkeys(("modes", "database", "radiation", "witness"), xr.Dataset())
    found = SimpleNamespace(plan=plan, runs={}, response=response, **parts)
    monkeypatch.setattr(figures, "Inputs", lambda *_: found)
    monkeypatch.setattr(figures, "in_direction", lambda response, _: response)
    monkeypatch.setattr(figures, "_spectra", lambda *given: given)
    monkeypatch.setattr(figures, "draw", lambda _, data: seen.append(data))
    monkeypatch.setattr(figures, "drawn", lambda *_: SimpleNamespace(write=lambda *_: []))
    studies = (seed, validated(BodyStudy, raft, "raft.yaml"))
    for study in studies:
        figures.run(study, "nowhere", str(tmp_path), str(tmp_path / "manifest.json"))
    assert [data.spectra for data in seen] == [(study, 7.5) for study in studies]
    assert [data.limit for data in seen] == ["limit 3 λ/2π", "λ/2π"]
    del response.attrs["limit"]
    figures.run(seed, "nowhere", str(tmp_path), str(tmp_path / "manifest.json"))
    assert seen[-1].limit == "limit λ/2π"


def test_files_of_every_figure_are_stamped(seed, tmp_path, monkeypatch):
    plan, noted = SimpleNamespace(figures=("one", "two"), study_id="identity", highest=5.0), []
    parts = dict.fromkeys(("modes", "database", "radiation", "response", "witness"), xr.Dataset())
    monkeypatch.setattr(figures, "Inputs", lambda *_: SimpleNamespace(plan=plan, runs={}, **parts))
    monkeypatch.setattr(figures, "in_direction", lambda response, _: response)
    monkeypatch.setattr(figures, "draw", lambda name, _: f"figure {name}")
    monkeypatch.setattr(
        figures, "drawn", lambda *of: SimpleNamespace(write=lambda *to: [f"{of} {to} {kind}" for kind in ("a", "b")])
    )
    monkeypatch.setattr(figures, "record", lambda *given: noted.append(given))
    figures.run(seed, "nowhere", "out", "manifest")
    paths = [
        f"{(f'figure {name}', name)} {('out', name)} {kind}" for name in ("one", "two") for kind in ("a", "b")
    ]  # fmt: skip
    assert noted == [("manifest", "identity", paths)]
