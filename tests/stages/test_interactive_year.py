"""The interactive chart of a campaign's page computes the results of the campaign; the animation is of linear theory."""

from contextlib import chdir
from types import SimpleNamespace

import numpy as np
import pytest
from browser import asked, evaluated
from conftest import varied
from models.test_ports import water
from stages.test_members import folder, planned, run  # noqa: F401

from vsb.engine.waves.seas import Sea
from vsb.models.ports import BuoyOfShape
from vsb.models.rest import reference_shell
from vsb.report import html
from vsb.report.animation import PERIODS
from vsb.report.campaign_answer import leading
from vsb.stages import campaign_report as module
from vsb.stages.campaign_report import animated_year, interactive_year
from vsb.stages.climate import read_climate


@pytest.fixture(scope="module")
def swept(folder):  # noqa: F811
    """A campaign over two thicknesses, run, and its results."""
    plan = planned(folder, vary={"device.thickness": [0.01, 0.02]}, name="living")
    with chdir(folder):
        return plan, run(plan)


def test_page_computes_energies_and_power_matrices_of_the_campaign(swept, tmp_path):
    plan, ds = swept
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    data = interactive_year(plan.campaign.spec, ds, *leading(ds), seas, plan.root)
    expression = """data.points.map((stored) => {
      const bins = unpackedBins(data.bins);
      const point = unpackedPoint(stored);
      const squares = yearSquares(bins, point);
      return point.ports.map((port) => {
        const own = bestDamper(port, squares);
        return { mean: power(port, squares, own), bins: [...binPowers(bins, point.weights, port, own)] };
      });
    })"""
    found = evaluated([html.text_of("algebra.js")], expression, data, tmp_path)
    one = ds.sel(tuning="one")
    words = [point["words"] for point in data["points"]]
    assert sorted(words) == ["thickness 0.01 m", "thickness 0.02 m"]
    order = np.argsort(words)
    means = np.array([[design["mean"] for design in found[i]] for i in order])
    np.testing.assert_allclose(means, one.annual_mean_power.transpose("thickness", "design").values, rtol=1e-6)
    occupied = (ds["count"].values > 0).ravel()
    matrices = np.array([[design["bins"] for design in found[i]] for i in order])
    expected = one.power_matrix.transpose("thickness", "design", "hs", "te").values.reshape(*means.shape, -1)
    np.testing.assert_allclose(matrices, expected[..., occupied], rtol=1e-4)


def test_damping_slider_of_the_campaign_page(swept, tmp_path):
    plan, ds = swept
    with open(f"{plan.folder}/report.html", encoding="utf-8") as file:
        page = file.read()
    script = """
      const part = (name) => document.querySelector(`#live [data-part="${name}"]`);
      const rows = () => [...part("rows").rows].map((row) => [...row.cells].map((cell) => cell.textContent));
      const own = rows();
      part("damper").value = Math.log(5000);
      part("damper").dispatchEvent(new Event("input"));
      const bins = part("matrix").querySelectorAll("rect").length;
      return { errors, own, dragged: rows(), bins, words: part("matrix").getAttribute("aria-label"), wide: document.documentElement.scrollWidth };"""
    found = asked(page, script, tmp_path, width=360)
    assert (found["errors"], found["wide"]) == ([], 360)
    energies = ds.annual_energy.sel(tuning="one").values
    assert [float(row[2]) for row in found["own"]] in [pytest.approx(list(energy), rel=1e-3) for energy in energies]
    assert all(float(a[2]) < float(b[2]) for a, b in zip(found["dragged"], found["own"], strict=True))
    assert found["bins"] == int((ds["count"] > 0).sum())
    assert found["words"].startswith("gain of ")


def moved(swept):
    plan, ds = swept
    with chdir(plan.root + "/.."):
        seas = read_climate(plan.climate, plan.loaded.climate_path)
        return animated_year(plan.campaign.spec, ds, *leading(ds), seas, plan.root)


def test_animation_of_a_campaign_page(swept, tmp_path):
    plan, ds = swept
    data = moved(swept)
    assert [design["name"] for design in data["designs"]] == list(ds.design.values)
    (sea,) = data["seas"]
    assert "most energy (Hs 3.1 m, Te 1" in sea["words"]
    assert sea["step"] * (sea["frames"] - 1) == pytest.approx(
        PERIODS * read_climate(plan.climate, plan.loaded.climate_path).te.max(), rel=1e-6
    )
    assert [design["modes"] for design in sea["designs"]] == [0, 3]
    with open(f"{plan.folder}/report.html", encoding="utf-8") as file:
        page = file.read()
    script = """
      const text = document.querySelector("#buoys > p:last-child").textContent;
      return { errors, shown: !document.getElementById("buoys").hidden, text };"""
    found = asked(page, script, tmp_path)
    assert (found["errors"], found["shown"]) == ([], True)
    assert "by linear theory, each design at its optimal damping for the year at thickness 0.0" in found["text"]


@pytest.mark.parametrize("basis", ["membrane", "full"])
def test_heave_is_that_of_the_port_with_its_damping(seed, basis):
    """V = V0/(1 + Y (c + i k/w)) of each component, with damping c and spring k; a clamp moves modes of its ring."""
    spring, dampers = 2e4, {"FSB": 5e3, "VSWEC": 3e4, "VSWEC90": 2e4}
    study = varied(seed, modes={"basis": basis, "degree": 3}, pto={"damping": 8e3, "stiffness": spring})
    reference = reference_shell(study)
    point = BuoyOfShape(study, reference, SimpleNamespace(at=lambda omega: water(study, omega=omega)))
    waves = Sea(np.array([1.0, 1.3, 1.7]), np.array([0.3, 0.0, 0.2j]))
    runs = module._runs(point, dampers, waves, 10.0)
    inside = point.at(waves.omega).in_waves()
    for design, damping in dampers.items():
        port = inside[design].port
        velocity = port.velocity / (1 + port.admittance * (damping + 1j * spring / waves.omega))
        time = runs[design].time.values
        assert (time[0], time[-1]) == (0.0, 10.0)
        parts = waves.amplitude * velocity / (-1j * waves.omega) * np.exp(-1j * np.outer(time, waves.omega))
        np.testing.assert_allclose(runs[design].sel(dof="Heave"), parts.sum(axis=1).real, rtol=1e-9, atol=1e-12)
    assert list(runs["FSB"].dof.values) == ["Heave"]
    assert runs["VSWEC"].sizes["dof"] > 1
