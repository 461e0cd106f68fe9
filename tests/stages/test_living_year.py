"""The page of a campaign computes with the numbers the campaign was computed with."""

from contextlib import chdir
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from browser import asked, evaluated
from conftest import varied
from stages.test_members import folder, planned, run  # noqa: F401

from vsb.report import html
from vsb.report.campaign_answer import leading
from vsb.stages import living_year as living_year_module
from vsb.stages.climate import read_climate
from vsb.stages.living_year import living_year


@pytest.fixture(scope="module")
def swept(folder):  # noqa: F811
    """A campaign over two thicknesses, run, and its results."""
    plan = planned(folder, vary={"device.thickness": [0.01, 0.02]}, name="living")
    with chdir(folder):
        return plan, run(plan)


def test_the_page_finds_the_energies_and_matrices_of_the_campaign(swept, tmp_path):
    plan, ds = swept
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    data = living_year(plan.campaign, ds, *leading(ds), seas, plan.root)
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


def test_a_reader_drags_the_year(swept, tmp_path):
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


@pytest.mark.parametrize(("sizes", "known"), [((2, 3), 6), ((1, 7), 1), ((), 1)])
def test_of_few_points_all_are_known_and_of_more_the_one_shown_alone(monkeypatch, sizes, known):
    """The one shown first, then the others in their order, each by its number among all; what is not viable is left."""
    dims = ("thickness", "mass")[: len(sizes)]
    ds = xr.Dataset({"margin": (dims, np.zeros(sizes))}, {"design": ["A", "B"]})
    shown = dict(zip(dims, (size - 1 for size in sizes), strict=True))
    asked = []

    def point(spec, ds, index, place, seas, root):
        asked.append((index, place))
        assert (spec, seas, root) == ("spec", "seas", "root")
        return None if index == 1 else index + 10

    monkeypatch.setattr(living_year_module, "shown_place", lambda *given: shown)
    monkeypatch.setattr(living_year_module, "_point", point)
    monkeypatch.setattr(living_year_module, "year_data", lambda *given: given)
    found = living_year("spec", ds, "one", "A", "seas", "root")
    places = [dict(zip(dims, place, strict=True)) for place in np.ndindex(sizes)]
    order = [places.index(shown), *(i for i, place in enumerate(places) if place != shown)][:known]
    assert asked == [(i, places[i]) for i in order]
    assert found == (
        ("seas", [i + 10 for i in order if i != 1], ["A", "B"], "A") if any(i != 1 for i in order) else None
    )


@pytest.mark.parametrize(("viable", "switches"), [(True, False), (True, True), (False, False)])
def test_a_point_is_looked_at_by_its_number_if_a_damper_says_what_it_takes(monkeypatch, viable, switches):
    """Of the study of its viable designs, on the water of its own shape."""
    one = SimpleNamespace(study=SimpleNamespace(pto=SimpleNamespace(switches=switches)))
    reference, asked = SimpleNamespace(basis="basis"), []
    spec = SimpleNamespace(
        base="base", vary=SimpleNamespace(points=["a", "b", "c"]), climate="seas", tuning=("one", "each")
    )  # fmt: skip
    monkeypatch.setattr(living_year_module, "members", lambda *given: asked.append(given) or [one])
    found = SimpleNamespace(viable=("viable", reference) if viable else None)
    monkeypatch.setattr(living_year_module, "viability", lambda study: found if study is one.study else None)
    monkeypatch.setattr(living_year_module, "swept_shape", lambda *given: given)
    point = living_year_module.looked_at(spec, 1, "root")
    assert asked == [("base", ["b"], "seas", ("one", "each"))]
    if switches or not viable:
        assert point is None
    else:
        assert (point.study, point.reference, point.swept) == ("viable", reference, ("viable", "basis", "root"))


def test_a_point_of_a_page_has_its_own_words_ports_dampers_and_flux(seed, monkeypatch):
    """Words of its place, of a campaign that varies nothing its study's; dampers of each design."""
    study = varied(seed, designs={"A": {"flexible": False}, "B": {}}, pto={"damping": {"A": 1e3, "B": 2e3}})
    ds = xr.Dataset({"margin": ("mass", [1.0, 2.0])}, {"mass": [10.0, 20.0]})
    swept = SimpleNamespace(of_year=lambda seas: ("water", seas))
    point = living_year_module.Point(study, "reference", swept)
    seas = SimpleNamespace(flux=lambda water: ("flux", water))
    monkeypatch.setattr(living_year_module, "looked_at", lambda *given: point if given == ("spec", 1, "root") else None)
    monkeypatch.setattr(living_year_module, "design_ports", lambda *given: given)
    monkeypatch.setattr(living_year_module, "where", lambda one: f"mass {float(one.mass):g}" if "mass" in one else "")
    found = living_year_module._point("spec", ds, 1, {"mass": 1}, seas, "root")
    assert found == {
        "words": "mass 20", "ports": (study, "reference", ("water", seas)), "given": {"A": 1e3, "B": 2e3},
        "flux": ("flux", study.water),
    }  # fmt: skip
    assert living_year_module._point("spec", ds, 0, {"mass": 0}, seas, "root") is None
    assert living_year_module._point("spec", xr.Dataset(), 1, {}, seas, "root")["words"] == "the study"
