"""Stages campaign and campaign_report: members at their points, figures and report, interactive chart and animation."""

import csv
import re
from contextlib import chdir
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from browser import asked, evaluated, findings
from conftest import varied
from models.test_buoy_of_shape import water
from results.test_member import year_of
from results.test_year import climate
from stages.test_members import folder, gather, planned, run, with_seas  # noqa: F401

from vsb.engine.waves.seas import Sea
from vsb.models.floating_system import BuoyOfShape
from vsb.models.rest import reference_shell
from vsb.report import page as pages
from vsb.report.campaign_answer import closing_answer, leading
from vsb.report.interactive import PERIODS
from vsb.report.page import with_minus_signs
from vsb.results.campaign import stacked
from vsb.stages import campaign
from vsb.stages.campaign import animated_year, interactive_year
from vsb.stages.check import read_climate
from vsb.stages.stage import run_task
from vsb.tools.files import load, save
from vsb.tools.stamps import faults, read_manifest

VARIED = {"device.young_modulus": [3e6, 1e6], "device.thickness": [0.01, 0.02, 0.04]}
BY, BINS = ("design", "tuning"), ("hs", "te")


def made_up(one):
    """Results that identify their member: the power is the product of the varied values."""
    power = np.prod(list(one.point.values())) * np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    return xr.Dataset(
        {
            "annual_mean_power": (BY, power),
            "damping": ((*BY, *BINS), np.broadcast_to(power[..., None, None], (2, 3, 1, 2))),
            "margin": ((), 0.5),
            "viable": ("design", [True, True]),
            "reason": ("design", np.array(["", ""], dtype=object)),
            "count": (BINS, [[2, 0]]),
        },
        coords={"design": ["FSB", "VSWEC"], "tuning": ["fixed", "one", "each"], "hs": [1.25], "te": [4.5, 5.5]},
    )


@pytest.fixture
def plan(tmp_path):
    """A plan whose batches are there."""
    one = planned(with_seas(tmp_path, (1.0, 6.0)), VARIED)
    for batch, task in one.batches.items():
        held = one.members_by_batch[batch]
        whole = stacked([made_up(each) for each in held], [each.id for each in held])
        save(whole.assign_attrs(spec_id=batch), task.out)
    return one


def test_every_member_stands_at_its_point(plan):
    gather(plan)
    found = load(plan.data_path, expected=plan.identity)
    assert found.annual_mean_power.dims == ("young_modulus", "thickness", *BY)
    for modulus in VARIED["device.young_modulus"]:
        for thickness in VARIED["device.thickness"]:
            power = found.annual_mean_power.sel(young_modulus=modulus, thickness=thickness)
            np.testing.assert_allclose(power.sel(design="VSWEC", tuning="fixed"), 4 * modulus * thickness, rtol=1e-15)


def test_table_is_stamped_and_equals_the_data(plan):
    gather(plan)
    assert faults({plan.campaign.makes[1]: plan.identity}, read_manifest(plan.manifest)) == []
    rows = list(csv.DictReader(Path(plan.campaign.makes[1]).read_text().splitlines()))
    keys = ("device.young_modulus", "device.thickness", "design", "tuning")
    tunings = ["fixed", "one", "each"]
    points = [[f"{value:.12g}" for value in one.values()] for one in plan.campaign.spec["spec"].vary.points]
    expected = [[*one, design, tuning] for one in points for design in ("FSB", "VSWEC") for tuning in tunings]
    assert [[row[key] for key in keys] for row in rows] == expected
    for row in rows:
        factor = {"FSB": 0, "VSWEC": 3}[row["design"]] + 1 + tunings.index(row["tuning"])
        product = float(row["device.young_modulus"]) * float(row["device.thickness"])
        assert float(row["annual_mean_power"]) == pytest.approx(factor * product, rel=1e-11)


@pytest.fixture(scope="module")
def answered_plan(tmp_path_factory):
    """A campaign over two moduli, in water given by a closed form."""
    one = planned(
        with_seas(tmp_path_factory.mktemp("campaign_report"), (1.0, 6.0)),
        {"device.young_modulus": [1e6, 1e9]},
        name="soft",
    )
    for batch, task in one.batches.items():
        held = one.members_by_batch[batch]
        found = [year_of(each.study, climate(8), task.spec["tuning"]) for each in held]
        save(stacked(found, [each.id for each in held]).assign_attrs(spec_id=batch), task.out)
    gather(one)
    return one


@pytest.fixture(scope="module")
def written(answered_plan):
    """The files of the answer by path, as they are written."""
    run_task(answered_plan.report)
    paths = [f"{answered_plan.folder}/report.html", *answered_plan.report.makes[1:]]
    return {path: Path(path).read_bytes() for path in paths}


def test_report_and_figures_are_stamped(answered_plan, written):
    names = {"report", "sweep", "spectra", "power_matrices", "tuned_power", "pareto"}
    assert {Path(path).stem for path in written} == names
    begins = {"svg": b"<svg", "html": b"<!doctype", "csv": b"axes,series,x,y"}
    assert all(content.lstrip().startswith(begins[path.rpartition(".")[2]]) for path, content in written.items())
    assert faults(dict.fromkeys(written, answered_plan.identity), read_manifest(answered_plan.manifest)) == []


def test_report_states_the_answer_of_its_data(answered_plan, written):
    page = written[f"{answered_plan.folder}/report.html"].decode()
    words = " ".join(re.sub("<[^>]+>", " ", page).split())
    data = load(answered_plan.data_path, expected=answered_plan.identity)
    assert with_minus_signs(closing_answer(data)) in words
    for path in answered_plan.report.makes[1:]:
        assert Path(path).stem in page


def test_report_is_accessible(answered_plan, written, tmp_path):
    assert findings(written[f"{answered_plan.folder}/report.html"].decode(), tmp_path, 360) == []


@pytest.fixture(scope="module")
def swept(folder):  # noqa: F811
    """A campaign over two thicknesses, run, and its results."""
    plan = planned(folder, vary={"device.thickness": [0.01, 0.02]}, name="living")
    with chdir(folder):
        return plan, run(plan)


def test_page_computes_energies_and_power_matrices_of_the_campaign(swept, tmp_path):
    plan, ds = swept
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    data = interactive_year(plan.campaign.spec["spec"], ds, *leading(ds), seas, plan.root)
    expression = """data.points.map((stored) => {
      const bins = unpackedBins(data.bins);
      const point = unpackedPoint(stored);
      const squares = yearSquares(bins, point);
      return point.ports.map((port) => {
        const own = bestDamper(port, squares);
        return { mean: power(port, squares, own), bins: [...binPowers(bins, point.weights, port, own)] };
      });
    })"""
    found = evaluated([pages.text_of("algebra.js")], expression, data, tmp_path)
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
        return animated_year(plan.campaign.spec["spec"], ds, *leading(ds), seas, plan.root)


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
    point = BuoyOfShape(study, reference, SimpleNamespace(clamps=None, at=lambda omega: water(study, omega=omega)))
    waves = Sea(np.array([1.0, 1.3, 1.7]), np.array([0.3, 0.0, 0.2j]))
    runs = campaign._runs(point, dampers, waves, 10.0)
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
