"""The interactive chart of a campaign's page computes the results of the campaign."""

from contextlib import chdir

import numpy as np
import pytest
from browser import asked, evaluated
from stages.test_members import folder, planned, run  # noqa: F401

from vsb.report import html
from vsb.report.campaign_answer import leading
from vsb.stages.campaign_report import interactive_year
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
    data = interactive_year(plan.campaign, ds, *leading(ds), seas, plan.root)
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
