"""Runs in time of a campaign: the correction they say, where it stands, what is kept, what is refused."""

import csv
from contextlib import chdir
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import varied
from stages.test_members import BASE, batches, gather, told, with_seas

from vsb.cli import main
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.report.campaign_answer import answer as answer_of
from vsb.report.campaign_answer import closing_answer
from vsb.report.campaign_figures import sweep
from vsb.report.campaign_page import statements, warnings
from vsb.results.campaign import damper
from vsb.results.in_time import DesignInTime
from vsb.stages import answer, verification
from vsb.stages.campaign_preview import check_campaign
from vsb.stages.climate import read_climate
from vsb.study.campaign_plan import plan_of
from vsb.study.plan import StudyPlan
from vsb.study.study import Simulation
from vsb.tools import packed
from vsb.tools.files import load
from vsb.waves.climate import realised

RUNS = {"duration": 60.0, "window": [40.0, 60.0], "tolerance": 1e-4}
VERIFY = {"seas": 4, "seed": 3}
MASSES = {"device.mass": [17170.0, 17000.0]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return with_seas(tmp_path_factory.mktemp("verified"), (0.6, 5.0), (1.0, 6.0), (1.3, 6.5), (1.6, 7.0))


def planned(folder, name="checked", vary=None, verify=None, tuning=("fixed", "one"), **sections):
    raw = {**BASE, **sections, "study": f"{name}_study", "simulation": {**BASE["simulation"], **RUNS}}
    (folder / f"{name}_study.yaml").write_text(yaml.safe_dump(raw))
    given = {"campaign": name, "study": f"{name}_study.yaml", "climate": {"spectra": "sea.txt"}, "vary": vary or {}}
    given |= {"tuning": list(tuning), "verify": verify or VERIFY}
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    with chdir(folder):
        return plan_of(f"{name}.yaml")


def simulated(plan):
    for name, spec in plan.verifications.items():
        verification.run(
            told("verification", spec), plan.loaded.climate_path, plan.root, plan.verification_path(name)
        )  # fmt: skip
    return [load(path, expected=name) for name, path in zip(plan.verifications, plan.verification_paths, strict=True)]


def run(plan):
    batches(plan)
    found = simulated(plan)
    gather(plan)
    files = (f"{plan.folder}/figures", f"{plan.folder}/report.html", plan.manifest)
    answer.run(told("answer", plan.campaign), plan.data_path, plan.loaded.climate_path, plan.root, *files)
    return found, load(plan.data_path, expected=plan.campaign_id)


@pytest.fixture(scope="module")
def checked(folder):
    plan = planned(folder, vary=MASSES)
    with chdir(folder):
        return plan, *run(plan)


def test_the_correction_is_the_ratio_of_weighted_means(checked):
    """Sum h N over sum h L is the ratio of the means of N h/q and L h/q: by hand, from what is stored."""
    _, runs, found = checked
    for i, one in enumerate(runs):
        at = found.isel(mass=i)
        ratio = (one.drawn_weight * one.run_power).mean("draw") / (one.drawn_weight * one.linear_run_power).mean("draw")
        expected = at.annual_mean_power.sel(tuning="one") * ratio
        np.testing.assert_allclose(at.body_exact_mean_power, expected, rtol=1e-9)
        assert float(np.abs(ratio - 1).max()) > 1e-2
        rigid, shell = at.body_exact_mean_power.values
        assert float(at.body_exact_gain_percent.sel(design="VSWEC")) == pytest.approx(100 * (shell / rigid - 1))


def test_gains_of_linear_theory_and_of_runs_stand_each_in_its_own_interval(folder, checked):
    plan, runs, found = checked
    with chdir(folder):
        linear = [packed.load(f"{plan.folder}/members/{one.id}.npz", expected=one.id) for one in plan.members]
    for i, (one, before) in enumerate(zip(runs, linear, strict=True)):
        at = found.isel(mass=i)
        for name in ("gain_percent", "gain_low", "gain_high"):
            np.testing.assert_array_equal(at[name], before[name])
            beyond = (before[name] - before.gain_percent).sel(tuning="one")  # errors of numbers, modes left out
            np.testing.assert_allclose(at[f"body_exact_{name}"], one[f"corrected_{name}"] + beyond, rtol=1e-12)
        shell = at.sel(design="VSWEC")
        assert shell.body_exact_gain_low < shell.body_exact_gain_percent < shell.body_exact_gain_high
        linear_one = shell.sel(tuning="one")
        assert linear_one.gain_low < linear_one.gain_percent < linear_one.gain_high
    assert found.attrs["verification"] == (
        "tuning one: 4 seas, body_exact, means over 10 energy periods of each after 3 or more of start-up"
    )


def test_table_and_report_say_which(folder, checked):
    plan, _, found = checked
    rows = list(csv.DictReader((folder / plan.table_path).read_text().splitlines()))
    for row in rows:
        at = found.sel(mass=float(row["device.mass"]), design=row["design"])
        assert (row["body_exact_mean_power"] == "") == (row["tuning"] == "fixed")
        if row["tuning"] == "one":
            for name in ("mean_power", "gain_percent", "gain_low", "gain_high"):
                known = float(at[f"body_exact_{name}"])
                assert float(row[f"body_exact_{name}"]) == pytest.approx(known, rel=1e-11)
            assert float(row["gain_low"]) == pytest.approx(float(at.gain_low.sel(tuning="one")), abs=1e-9)
    best = found.isel(mass=int(found.body_exact_gain_percent.sel(design="VSWEC").argmax("mass"))).sel(design="VSWEC")
    one, gain = best.sel(tuning="one"), float(best.body_exact_gain_percent)
    assert closing_answer(found).startswith("No valid answer yet: the shell buckles")
    sentence = answer_of(found, "FSB", "one")
    assert f"absorbs {abs(gain):.1f} % {'more' if gain > 0 else 'less'} than the rigid FSB" in sentence
    assert (
        f"({float(one.body_exact_gain_low):+.1f} to {float(one.body_exact_gain_high):+.1f} % by body-exact runs"
        in sentence
    )
    assert (
        f"linear theory says {float(one.gain_percent):+.1f} %; {float(best.body_exact_mean_power) * 8766e-6:.4g}"
        in sentence
    )
    assert sentence in (folder / plan.folder / "report.html").read_text()
    assert any(
        "of the energy is from seas beyond what is described" in line for line in statements(found, "FSB", "one")
    )
    assert any("heaves by more than 0.3 of its radius" in line for line in warnings(found))


def test_the_figure_of_a_sweep_shows_the_corrected_gain_beside_the_linear_one(checked):
    _, _, found = checked
    shell = found.sel(design="VSWEC").sortby("mass")
    axes = sweep(found, "one", "FSB").axes[0]
    corrected, linear = (line.get_ydata() for line in axes.lines[:2])
    np.testing.assert_array_equal(corrected, shell.body_exact_gain_percent)
    np.testing.assert_array_equal(linear, shell.gain_percent.sel(tuning="one"))
    np.testing.assert_array_equal(
        sweep(found, "fixed", "FSB").axes[0].lines[0].get_ydata(), shell.gain_percent.sel(tuning="fixed")
    )


def test_a_map_shows_the_corrected_gain(checked):
    _, _, found = checked
    wide = found.expand_dims(thickness=[0.01, 0.02]).assign_attrs(varied="thickness mass")
    drawn = sweep(wide, "one", "FSB").axes[0].collections[0].get_array()
    np.testing.assert_array_equal(drawn, wide.sortby("mass").body_exact_gain_percent.sel(design="VSWEC"))


def test_linear_runs_correct_nothing(folder):
    """What is left of linear theory beside itself is the fitted memory and the end of the transient."""
    plan = planned(folder, "same", verify={**VERIFY, "model": "linear"})
    with chdir(folder):
        _, found = run(plan)
    assert found.in_time_mean_power.dims == ("design",)
    np.testing.assert_allclose(found.in_time_mean_power, found.annual_mean_power.sel(tuning="one"), rtol=2e-3)
    assert " by linear runs in time" in answer_of(found, "FSB", "one")


def test_a_run_goes_on_from_the_runs_in_time_that_are_there(folder, checked, capsys):
    """What is missing is made by the workflow, to the same bytes; what is there is kept."""
    plan, _, _ = checked
    kept, lost = (folder / path for path in plan.verification_paths)
    data = folder / plan.data_path
    before, stamp = {path: path.read_bytes() for path in (kept, lost, data)}, kept.stat().st_mtime_ns
    lost.unlink(), data.unlink()
    with chdir(folder):
        assert main(["run", "checked.yaml"]) == 0, capsys.readouterr()
    assert {path: path.read_bytes() for path in before} == before
    assert kept.stat().st_mtime_ns == stamp


def test_designs_that_are_not_viable_are_not_run(folder):
    """At its equilibrium the vented seed buckles; nothing of it is simulated."""
    plan = planned(folder, "lost", reference_shape="equilibrium", device={**BASE["device"], "internal_pressure": 0.0})
    with chdir(folder):
        (found,) = simulated(plan)
    assert not found.viable.any()
    assert np.isnan(found.corrected_mean_power).all()
    assert np.isnan(found.corrected_gain_low).all()


def test_a_point_at_which_nothing_is_taken_needs_no_runs_and_loses_no_other(folder):
    """Of two dampers one takes nothing: its corrected power is none, its gains are missing, the other's are there."""
    vary, verify = {"pto.damping": [0.0, 8e3]}, {"seas": 4, "model": "linear"}
    plan = planned(folder, "nothing", vary=vary, verify=verify, tuning=["fixed"])
    with chdir(folder):
        _, found = run(plan)
    none, some = (found.isel({found.margin.dims[0]: i}) for i in range(2))
    assert none.in_time_mean_power.values.tolist() == [0.0, 0.0]
    assert np.isnan(none.in_time_gain_percent).all()
    assert (some.in_time_mean_power > 0).all()
    assert np.isfinite(some.in_time_gain_percent).all()


def test_a_shell_that_finds_no_rest_on_the_water_is_refused_before_the_run(folder):
    plan = planned(folder, "soft", device={**BASE["device"], "young_modulus": 1e6})
    with chdir(folder), pytest.raises(ConfigError, match=r"soft.yaml: verify: .*for design VSWEC, but"):
        check_campaign(plan)


@pytest.mark.parametrize("error", [ConvergenceError, StabilityError])
def test_a_run_that_fails_names_its_sea(folder, checked, monkeypatch, error):
    plan, _, _ = checked

    def fails(*_):
        raise error("the buoy has left the water")

    monkeypatch.setattr(DesignInTime, "powers", fails)
    expected = r"verify: FSB in a sea of Hs [\d.]+ m and Te [\d.]+ s: the buoy has left the water"
    with chdir(folder), pytest.raises(error, match=expected):
        simulated(plan)


def test_check_tells_of_the_runs(folder, checked, capsys):
    with chdir(folder):
        assert main(["check", str(Path("checked.yaml"))]) == 0
    assert "verify       4 seas, body_exact, of each of 2 points, 2 done" in capsys.readouterr().out


def test_every_run_is_of_its_design_damper_sea_and_seed_for_as_long_as_the_sea_needs(folder, checked):
    """One of them made again by hand; both designs meet the same waves."""
    plan, (first, _), found = checked
    spec = next(iter(plan.verifications.values()))
    dampers = damper(found.isel(mass=0)).sel(tuning="one")
    with chdir(folder):
        climate, designs = (
            read_climate(spec.climate, plan.loaded.climate_path),
            verification.in_time(spec.simulated, plan.root),
        )
    draw = 2
    te = float(first.drawn_te[draw])
    settings = Simulation(duration=13 * te, window=(3 * te, 13 * te), tolerance=RUNS["tolerance"])
    for name, design in designs.items():
        low, high = design.buoy.database.omega.values[[0, -1]]
        sea = realised(climate, int(first.drawn_sea[draw]), 13 * te, int(first.drawn_seed[draw]), low, high)
        powers = design.under(float(dampers.sel(design=name))).powers(sea, settings, "body_exact")
        kept = first.sel(design=name).isel(draw=draw)
        assert powers == pytest.approx((float(kept.run_power), float(kept.linear_run_power)), rel=1e-9)


def test_designs_in_time_are_each_in_its_own_motions_on_the_study_s_spring_and_laws(seed, monkeypatch):
    """Of the database and the radiation memory, made if they are not there, beside the spring and without a damper."""
    pto = {"damping": 5e3, "stiffness": 700.0, "stroke_limit": 1.5}
    study, made = varied(seed, pto=pto, designs={"A": {"flexible": False}, "B": {}}), []
    plan = StudyPlan(study, root="elsewhere")
    monkeypatch.setattr(verification, "make", lambda plan, targets: made.append((plan.root, targets)))
    monkeypatch.setattr(verification, "linear_buoy", lambda *given: (given, "basis"))
    monkeypatch.setattr(verification, "radiation_model", lambda path: path)
    monkeypatch.setattr(verification, "rest_shape", lambda *given: given)
    monkeypatch.setattr(verification, "study_port", lambda *given: np.array([1.0, 2.0]))
    monkeypatch.setattr(verification, "design_motions", lambda study, basis, design: (basis, design))
    found = verification.in_time(study, "elsewhere")
    assert made == [("elsewhere", [plan.database_path, plan.radiation_path])]
    assert list(found) == ["A", "B"]
    for name, one in found.items():
        buoy = (study, plan.database_path)
        assert (one.buoy, one.shape, one.radiation) == (buoy, (study, buoy, "basis"), plan.radiation_path)
        assert (one.motions, one.pto) == (("basis", name), study.pto)
        assert (one.take_off.damping, one.take_off.stiffness) == (0.0, 700.0)
        assert one.take_off.direction(2).tolist() == [1.0, 2.0]


def test_the_seas_of_a_year_are_drawn_as_many_as_asked_by_the_seed_asked_for(monkeypatch):
    """By the year under the only tuning; where nothing is taken no sea is."""
    asked, power = [], np.array([[0.0], [2.0]])
    spec = SimpleNamespace(tuning=("one",), verify=SimpleNamespace(seas=8, seed=3, model="linear"))
    seas, swept = SimpleNamespace(hours="hours"), SimpleNamespace(of_year=lambda seas: ("water", seas))
    year, rest = SimpleNamespace(annual_mean_power=power), SimpleNamespace(basis="basis")
    monkeypatch.setattr(verification, "swept_shape", lambda *given: asked.append(given) or swept)
    monkeypatch.setattr(verification, "design_ports", lambda *given: asked.append(given) or "ports")
    monkeypatch.setattr(verification, "ports_year", lambda *given: asked.append(given) or year)
    monkeypatch.setattr(verification, "chances", lambda *given: ("chances", *given))
    monkeypatch.setattr(verification, "drawn", lambda *given: asked.append(given) or "sample")
    monkeypatch.setattr(verification, "in_time", lambda *given: ("designs", *given))
    monkeypatch.setattr(verification, "_powers", lambda *given: asked.append(given) or ("better", "linear"))
    monkeypatch.setattr(verification, "verified", lambda *given: ("verified", *given))
    monkeypatch.setattr(verification, "verified_dataset", lambda *given: given)
    monkeypatch.setattr(verification, "of_nothing", lambda year: "nothing")
    found = verification._of_viable(spec, "study", rest, seas, "root")
    assert asked == [
        ("study", "basis", "root"),
        ("study", rest, ("water", seas)),
        ("study", "ports", seas, ("one",)),
        (("chances", year, "one"), "hours", 8, 3),
        (spec, year, "sample", ("designs", "study", "root")),
    ]
    assert found == (year, "one", ("verified", year, "one", "sample", "better", "linear"))
    year.annual_mean_power = 0 * power
    assert verification._of_viable(spec, "study", rest, seas, "root") == "nothing"


@pytest.mark.parametrize("viable", [None, ("of the viable", "at rest")])
def test_designs_that_are_lost_stand_beside_those_that_were_run(seed, monkeypatch, viable):
    """All of the study's, over its rigid one; what is written says which runs, of what model, under which id."""
    study, asked = varied(seed, designs={"A": {}, "B": {"flexible": False}}), []
    spec = SimpleNamespace(simulated=study, climate="seas", verify=SimpleNamespace(model="linear"))
    ran = xr.Dataset(coords={"design": ["B"]})
    monkeypatch.setattr(verification, "read_climate", lambda *given: given)
    monkeypatch.setattr(verification, "viability", lambda of: SimpleNamespace(viable=viable))
    monkeypatch.setattr(verification, "_of_viable", lambda *given: asked.append(given) or ran)
    monkeypatch.setattr(verification, "with_lost", lambda *given: asked.append(given) or given[0])
    monkeypatch.setattr(verification, "_in_words", lambda spec: "words")
    monkeypatch.setattr(verification, "stamp", lambda spec: {"spec_id": "id"})
    monkeypatch.setattr(verification, "save", lambda ds, out: asked.append((ds.attrs, out)))
    verification.run(spec, "climate.nc", "root", "out.nc")
    if viable:
        assert asked.pop(0) == (spec, *viable, ("seas", "climate.nc"), "root")
    (found, names, reference), written = asked
    assert (list(found.design.values), names, reference) == (["B"] if viable else [], ["A", "B"], "B")
    assert written == ({"runs": "words", "model": "linear", "spec_id": "id"}, "out.nc")
