"""What a campaign's page draws in motion is its own linear theory in one of the year's seas."""

from contextlib import chdir
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from browser import asked
from conftest import varied
from scenes.test_ports import water
from stages.test_living_year import swept  # noqa: F401
from stages.test_members import folder  # noqa: F401

from vsb.report.animation import PERIODS
from vsb.report.campaign_answer import leading
from vsb.report.campaign_page import STILL, CampaignReport, render
from vsb.report.shell_figures import round_factor
from vsb.results.bins import Bins
from vsb.scenes.ports import designs_in_waves
from vsb.scenes.rest import reference_shell
from vsb.stages import moving_year as module
from vsb.stages.climate import read_climate
from vsb.stages.living_year import Point
from vsb.stages.moving_year import most_energetic, moving_year
from vsb.study.study import Water
from vsb.waves.climate import Climate, realised
from vsb.waves.seas import Sea


def moved(swept):  # noqa: F811
    plan, ds = swept
    with chdir(plan.root + "/.."):
        seas = read_climate(plan.climate, plan.loaded.climate_path)
        return moving_year(plan.campaign, ds, *leading(ds), seas, plan.root)


def test_the_sea_is_of_the_bin_that_brings_most_energy(swept):  # noqa: F811
    """Of seas of 1, 2.2, 2.3 and 3.1 m two share a bin, and together bring less than the last."""
    plan, ds = swept
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    sea, row, column = most_energetic(seas, plan.members[0].study.water)
    assert sea == int(seas.hs.argmax())
    assert float(ds.hs[row]) == pytest.approx(seas.hs[sea], abs=0.25)
    assert float(ds.te[column]) == pytest.approx(seas.te[sea], abs=0.5)


@pytest.mark.parametrize("seed", range(4))
def test_of_the_bin_the_sea_is_the_one_nearest_to_its_mean(seed):
    """Many seas in one bin: none of them brings an hour's energy nearer to the bin's mean over its hours.

    Half of the year is calm, and no part of that mean.
    """
    random, omega = np.random.default_rng(seed), np.linspace(0.3, 2.0, 60)
    density = random.uniform(0.8, 1.2, (30, 1)) * np.exp(-(((omega - 0.8) / 0.1) ** 2))
    density[0] *= 30.0
    hours = np.where(np.arange(30) == 0, 1e-6, random.uniform(0.5, 1.5, 30))
    density, hours = np.concatenate([1e-3 * density[1:], density]), np.concatenate([hours[1:], hours])
    seas, water = Climate.of_spectra(omega, density, hours / hours.sum(), "a swell"), Water()
    sea, row, column = most_energetic(seas, water)
    flux, bins = seas.flux(water), Bins(seas.hs, seas.te, seas.hours)
    inside = np.flatnonzero(bins.index == bins.index[sea])
    assert bins.index[sea] == np.ravel_multi_index((row, column), bins.shape)
    assert len(inside) > 5
    mean = flux[inside] @ seas.hours[inside] / seas.hours[inside].sum()
    assert np.abs(flux[inside] - mean).min() == pytest.approx(abs(flux[sea] - mean), rel=1e-9)
    assert bins.total(flux * seas.hours).ravel()[bins.index[sea]] == bins.total(flux * seas.hours).max()


@pytest.mark.parametrize("radius", [0.1, 2.0, 30.0])
@pytest.mark.parametrize("rise", [0.0, 0.5, 3.0])
def test_what_is_shown_is_as_wide_as_the_buoy_moves(swept, monkeypatch, radius, rise):  # noqa: F811
    """In radii: as much as of every page's buoys, or what it needs to rise as far as it does."""
    sized = []
    monkeypatch.setattr(module, "frames_data", lambda *given: sized.append(given))
    monkeypatch.setattr(module, "_runs", lambda point, dampers, *_: {
        name: xr.DataArray([[rise * radius, 0.0], [-rise * radius / 2, 0.0]], dims=("time", "dof"),
                           coords={"dof": ["Heave", "Membrane0"]}) for name in dampers})  # fmt: skip
    monkeypatch.setattr(module, "largest_shell", lambda *_: 0.1 * radius)
    monkeypatch.setattr(module, "shell_modes", lambda *_: xr.Dataset(coords={"mode": ["Membrane0"]}))
    monkeypatch.setattr(module, "shapes_data", lambda *_: None)
    looked_at = module.looked_at
    monkeypatch.setattr(module, "looked_at", lambda *given: of_radius(looked_at(*given), radius))
    data = moved(swept)
    assert data["width"] == pytest.approx(radius * max(1.7, 1.0 + rise))
    assert sized[0][5] == data["width"]


def of_radius(point, radius):
    """A point of another radius; what it moves like is not asked."""
    device = point.study.device.model_copy(update={"radius": radius})
    return replace(point, study=point.study.model_copy(update={"device": device}))


def test_every_design_moves_as_long_as_is_said_and_the_page_says_in_what(swept, tmp_path, monkeypatch):  # noqa: F811
    plan, ds = swept
    made = []
    monkeypatch.setattr(module, "realised", lambda *given: made.append(given) or realised(*given))
    data = moved(swept)
    ((seas, index, duration, *_),) = made
    assert duration == pytest.approx(PERIODS * seas.te[index])
    assert [design["name"] for design in data["designs"]] == list(ds.design.values)
    (sea,) = data["seas"]
    assert "most energy (Hs 3.1 m, Te 1" in sea["words"]
    assert sea["step"] * (sea["frames"] - 1) == pytest.approx(
        PERIODS * read_climate(plan.climate, plan.loaded.climate_path).te.max(), rel=1e-6
    )
    assert [design["modes"] for design in sea["designs"]] == [0, 3]
    assert sea["frames"] - 2 == module.FRAMES, "summed at as many instants as are shown, but the ends"
    with open(f"{plan.folder}/report.html", encoding="utf-8") as file:
        page = file.read()
    script = """
      const text = document.querySelector("#buoys > p:last-child").textContent;
      return { errors, shown: !document.getElementById("buoys").hidden, text };"""
    found = asked(page, script, tmp_path)
    assert (found["errors"], found["shown"]) == ([], True)
    assert "by linear theory, each design at its own optimal damper of the year at thickness 0.0" in found["text"]


def test_where_nothing_can_move_the_page_says_so(swept, monkeypatch):  # noqa: F811
    plan, ds = swept
    monkeypatch.setattr(module, "looked_at", lambda *_: None)
    assert moved(swept) is None
    assert STILL in render(CampaignReport(ds, {}))
    monkeypatch.undo()
    unknown = ds.assign(damping=np.nan * ds.damping)
    with chdir(plan.root + "/.."):
        seas = read_climate(plan.climate, plan.loaded.climate_path)
        assert moving_year(plan.campaign, unknown, *leading(ds), seas, plan.root) is None


def test_designs_rise_as_their_ports_under_their_own_dampers_beside_the_spring(seed):
    """V = V0/(1 + Y (c + i k/w)) of each component, summed over the time shown; a rigid buoy moves in heave alone."""
    spring, dampers = 2e4, {"FSB": 5e3, "VSWEC": 3e4}
    study = varied(seed, modes={"degree": 2}, pto={"damping": 8e3, "stiffness": spring})
    reference = reference_shell(study)
    point = Point(study, reference, SimpleNamespace(at=lambda omega: water(study, omega=omega)))
    waves = Sea(np.array([1.0, 1.3, 1.7]), np.array([0.3, 0.0, 0.2j]))
    runs = module._runs(point, dampers, waves, 10.0)
    inside = designs_in_waves(study, reference, water(study, omega=waves.omega))
    for design, damping in dampers.items():
        port = inside[design].port
        velocity = port.velocity / (1 + port.admittance * (damping + 1j * spring / waves.omega))
        time = runs[design].time.values
        assert (time[0], time[-1]) == (0.0, 10.0)
        parts = waves.amplitude * velocity / (-1j * waves.omega) * np.exp(-1j * np.outer(time, waves.omega))
        np.testing.assert_allclose(runs[design].sel(dof="Heave"), parts.sum(axis=1).real, rtol=1e-9, atol=1e-12)
    assert list(runs["FSB"].dof.values) == ["Heave"]
    assert runs["VSWEC"].sizes["dof"] > 1


@pytest.mark.parametrize(
    ("tuning", "there", "taken"),
    [
        ("each", ("fixed", "one", "each"), "each"),
        ("constrained", ("fixed", "each", "constrained", "one"), "one"),
        ("constrained", ("fixed", "constrained", "each"), "each"),
        ("constrained", ("fixed", "constrained"), "fixed"),
        ("constrained", ("constrained",), None),
    ],
)
def test_dampers_are_those_of_the_point_and_bin_shown_under_a_law_of_motion(seed, monkeypatch, tuning, there, taken):
    """Of two points by three, bins of two by four, designs in another order than the results'; limits are no damper."""
    sizes = {"thickness": 2, "mass": 3, "tuning": len(there), "design": 3, "hs": 2, "te": 4}
    damping = xr.DataArray(np.arange(np.prod([*sizes.values()]), dtype=float).reshape([*sizes.values()]), dims=sizes)
    coords = {"tuning": list(there), "design": ["A", "B", "C"], "thickness": [0.1, 0.2], "mass": [1.0, 2.0, 3.0]}
    ds = xr.Dataset({"damping": damping, "margin": (("thickness", "mass"), np.zeros((2, 3)))}, coords)
    study = varied(seed, designs={"C": {"flexible": False}, "A": {"flexible": False}})
    buoy = SimpleNamespace(database=xr.Dataset(coords={"omega": [0.5, 1.0, 4.0]}))
    point, asked, made, framed = Point(study, None, SimpleNamespace(buoys=(buoy,))), [], [], []
    monkeypatch.setattr(module, "shown_place", lambda *_: {"thickness": 1, "mass": 1})
    monkeypatch.setattr(module, "looked_at", lambda spec, index, root: asked.append((spec, index, root)) or point)
    monkeypatch.setattr(module, "most_energetic", lambda *_: (1, 0, 3))
    monkeypatch.setattr(module, "realised", lambda *given: made.append(given) or "waves")
    still = xr.DataArray([[-9.0]], coords={"dof": ["Heave"]}, dims=("time", "dof"))
    rises = {"C": 0.1 * still, "A": still}  # the second design rises most, its shell moves most
    monkeypatch.setattr(module, "_runs", lambda p, dampers, *_: made.append(dampers) or rises)
    monkeypatch.setattr(module, "shell_modes", lambda *_: xr.Dataset(coords={"mode": ["Membrane0"]}))
    monkeypatch.setattr(module, "largest_shell", lambda run, shell: abs(float(run[0, 0])) / 90)
    monkeypatch.setattr(module, "shapes_data", lambda *_: None)
    monkeypatch.setattr(module, "frames_data", lambda words, *given: framed.append(given) or words)
    monkeypatch.setattr(module, "where", lambda one: "the point" if float(one.mass) == 2.0 else "another")
    seas = SimpleNamespace(te=np.array([5.0, 7.0]), hs=np.array([1.0, 2.5]))
    found = moving_year("spec", ds, tuning, "A", seas, "root")
    assert asked == [("spec", 4, "root")]
    if taken is None:
        assert found is None
        return
    (given, dampers) = made
    assert given == (seas, 1, PERIODS * 7.0, 0, 0.5, 4.0)
    at = damping.values[1, 1, there.index(taken), :, 0, 3]
    assert dampers == {"C": at[2], "A": at[0]}
    assert found["seas"] == ["a sea of the bin that brings most energy (Hs 2.5 m, Te 7 s)"]
    words = (
        f"In {found['seas'][0]}: a realisation of its spectrum, by linear theory, {module.TUNED[taken]} at the point."
    )
    assert found["told"] == words
    radius = study.device.radius
    assert (found["width"], found["factor"]) == (radius + 9.0, round_factor(0.1, radius))
    assert [design["name"] for design in found["designs"] if design["reference"]] == ["A"]
    span, shell = (0.0, PERIODS * 7.0), ["Membrane0"]
    assert framed == [(rises, "waves", span, 7.0, found["width"], study.water, shell)]
    unknown = ds.assign(damping=damping.where(damping != at[0]))
    assert moving_year("spec", unknown, tuning, "A", seas, "root") is None
